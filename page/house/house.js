import { $ } from "./runtime.js";
$.module("dehyst.arrays", ($m) => {
let annotations, np, npt, Array_, Mask, Rows, rank;
np = $.imp("numpy");
npt = $.imp("numpy.typing");
Array_ = $.gi($.ga(npt, "NDArray"), $.ga(np, "float64"));
Mask = $.gi($.ga(npt, "NDArray"), $.ga(np, "bool_"));
Rows = $.gi($.ga(npt, "NDArray"), $.ga(np, "int64"));
rank = $.def(function (score) { 
return $.b.float(("" + $.f($.b.max(score, 1e-10), ("" + ".5e"), -1))); }, {p: ["score"], ks: false});
Object.assign($m, {"annotations": annotations, "np": np, "npt": npt, "Array": Array_, "Mask": Mask, "Rows": Rows, "rank": rank});
});
$.module("dehyst.findings", ($m) => {
let annotations, dataclass, IntEnum, visible, visible_lines, Finding, Grade, ENDINGS, grade_of, doubtful;
dataclass = $.from("dataclasses", "dataclass");
IntEnum = $.from("enum", "IntEnum");
visible = $.from("dehyst.shell", "visible");visible_lines = $.from("dehyst.shell", "visible_lines");
Finding = $.cls("Finding", [], "", [["code", null], ["message", null]], true, true, ($c) => { Finding = $c; $.meth($c, "__post_init__", $.def(function () { const self = this;
$.seta(self, "message", visible_lines($.ga(self, "message"))); }, {p: [], ks: false}));
$.meth($c, "as_dict", $.def(function () { const self = this;
return $.dict([["code", $.ga(self, "code")], ["message", $.ga(self, "message")]]); }, {p: [], ks: false}));});
Grade = $.cls("Grade", [], "IntEnum", [], false, true, ($c) => { Grade = $c; $.static($c, "GOOD", 0);$.static($c, "CARE", 1);$.static($c, "BAD", 2);$.prop($c, "words", $.def(function () { const self = this;
return $.gi($.tup("good", "usable with care", "do not use"), self); }, {p: [], ks: false}));
$.meth($c, "__str__", $.def(function () { const self = this;
return $.gi($.tup("good", "care", "no"), self); }, {p: [], ks: false}));
$.meth($c, "__format__", $.def(function (spec) { const self = this;
return format($.b.str(self), spec); }, {p: ["spec"], ks: false}));
$.prop($c, "css", $.def(function () { const self = this;
return $.gi($.tup("good", "care", "stop"), self); }, {p: [], ks: false}));});
ENDINGS = $.tup($.tup($.ga(Grade, "BAD"), "do not compensate"), $.tup($.ga(Grade, "CARE"), "usable with care"), $.tup($.ga(Grade, "GOOD"), "good for compensation"));
grade_of = $.def(function (verdict) { 
if (!$.t($.b.isinstance(verdict, $.b.str))) {return null;}
return $.b.next((function* () { for (const $v1 of $.it(ENDINGS)) { let grade, words; {const $v2 = $.unpack($v1, 2, -1);grade = $v2[0];words = $v2[1];} if ($.t($.in(words, verdict))) { yield grade; } } })(), null); }, {p: ["verdict"], ks: false});
doubtful = $.def(function (verdict) { 
if ($.t($.in(grade_of(verdict), $.tup(null, $.ga(Grade, "GOOD"))))) {return "";}
return $.gi(visible(verdict), $.slice(null, 600, null)); }, {p: ["verdict"], ks: false});
Object.assign($m, {"annotations": annotations, "dataclass": dataclass, "IntEnum": IntEnum, "visible": visible, "visible_lines": visible_lines, "Finding": Finding, "Grade": Grade, "ENDINGS": ENDINGS, "grade_of": grade_of, "doubtful": doubtful});
});
$.module("dehyst.errors", ($m) => {
let annotations, Any, visible_lines, DehystError, ParameterError, InvertibilityError, RecordingError, ExcitationError, SimulationError, IdentificationError, LogError, ColumnError, RunError, TimeError, UnitError, ModelFileError, MissingExtraError, OutputError;
Any = $.from("typing", "Any");
visible_lines = $.from("dehyst.shell", "visible_lines");
DehystError = $.cls("DehystError", [$.b.Exception], "", [], false, true, ($c) => { DehystError = $c; $.meth($c, "__init__", $.def(function (message, facts = $.dict()) { const self = this;
$.supcall(DehystError, this, "__init__", [visible_lines(message)]);
self.facts = facts; }, {p: ["message"], ks: true}));});
ParameterError = $.cls("ParameterError", [DehystError, $.b.ValueError], "", [], false, true, ($c) => { ParameterError = $c; });
InvertibilityError = $.cls("InvertibilityError", [DehystError, $.b.ValueError], "", [], false, true, ($c) => { InvertibilityError = $c; });
RecordingError = $.cls("RecordingError", [DehystError, $.b.ValueError], "", [], false, true, ($c) => { RecordingError = $c; });
ExcitationError = $.cls("ExcitationError", [DehystError, $.b.ValueError], "", [], false, true, ($c) => { ExcitationError = $c; });
SimulationError = $.cls("SimulationError", [DehystError, $.b.RuntimeError], "", [], false, true, ($c) => { SimulationError = $c; });
IdentificationError = $.cls("IdentificationError", [DehystError, $.b.RuntimeError], "", [], false, true, ($c) => { IdentificationError = $c; });
LogError = $.cls("LogError", [DehystError], "", [], false, true, ($c) => { LogError = $c; });
ColumnError = $.cls("ColumnError", [LogError], "", [], false, true, ($c) => { ColumnError = $c; });
RunError = $.cls("RunError", [LogError], "", [], false, true, ($c) => { RunError = $c; });
TimeError = $.cls("TimeError", [LogError], "", [], false, true, ($c) => { TimeError = $c; });
UnitError = $.cls("UnitError", [DehystError, $.b.ValueError], "", [], false, true, ($c) => { UnitError = $c; });
ModelFileError = $.cls("ModelFileError", [DehystError], "", [], false, true, ($c) => { ModelFileError = $c; });
MissingExtraError = $.cls("MissingExtraError", [DehystError, $.b.ImportError], "", [], false, true, ($c) => { MissingExtraError = $c; });
OutputError = $.cls("OutputError", [DehystError], "", [], false, true, ($c) => { OutputError = $c; });
Object.assign($m, {"annotations": annotations, "Any": Any, "visible_lines": visible_lines, "DehystError": DehystError, "ParameterError": ParameterError, "InvertibilityError": InvertibilityError, "RecordingError": RecordingError, "ExcitationError": ExcitationError, "SimulationError": SimulationError, "IdentificationError": IdentificationError, "LogError": LogError, "ColumnError": ColumnError, "RunError": RunError, "TimeError": TimeError, "UnitError": UnitError, "ModelFileError": ModelFileError, "MissingExtraError": MissingExtraError, "OutputError": OutputError});
});
$.module("dehyst.shell", ($m) => {
let annotations, os, re, unicodedata, Iterable, _PLAIN, _SPECIAL, quoted, typed, HARMLESS, HIDDEN, BREAKS, visible, visible_lines, _shown;
os = $.imp("os");
re = $.imp("re");
unicodedata = $.imp("unicodedata");
Iterable = $.from("collections.abc", "Iterable");
_PLAIN = re.compile("[A-Za-z0-9_./:+-][A-Za-z0-9_./:=+-]*");
_SPECIAL = re.compile("[\"$`!\\\\]");
quoted = $.def(function (word) { let text, shlex;
text = $.b.str(word);
if ($.t($.eq($.ga(os, "name"), "nt"))) {if ($.t(_PLAIN.fullmatch($.cm(text, "replace", ["\\", "/"])))) {return text;}
text = re.sub("(\\\\*)\"", "\\1\\1\\\\\"", text);
return $.add($.add("\"", re.sub("\\\\+$", "\\g<0>\\g<0>", text)), "\"");}
if ($.t(_PLAIN.fullmatch(text))) {return text;}
if (!$.t(_SPECIAL.search(text))) {return ("" + "\"" + $.f(text, "", -1) + "\"");}
shlex = $.imp("shlex");
return shlex.quote(text); }, {p: ["word"], ks: false});
typed = $.def(function (words) { 
return $.cm(" ", "join", [$.b.map(quoted, words)]); }, {p: ["words"], ks: false});
HARMLESS = "\u00ad\u200c\u200d";
HIDDEN = $.b.frozenset(["Cc", "Cf", "Cs", "Cn", "Zl", "Zp"]);
BREAKS = $.b.frozenset("\t\n\u000b\f\r\u0085\u2028\u2029");
visible = $.def(function (text) { let line;
line = $.b.str(text);
if ($.t($.cm(line, "isprintable", []))) {return line;}
line = re.sub("\\s+", $.def((gap) => {  return ($.t($.cm(BREAKS, "isdisjoint", [$.gi(gap, 0)])) ? $.gi(gap, 0) : " "); }, {p: ["gap"], ks: false}), line);
return $.cm("", "join", [(function* () { for (const $v1 of $.it(line)) { let letter; letter = $v1; yield _shown(letter); } })()]); }, {p: ["text"], ks: false});
visible_lines = $.def(function (text) { 
return $.cm("\n", "join", [$.b.map(visible, $.cm($.b.str(text), "split", ["\n"]))]); }, {p: ["text"], ks: false});
_shown = $.def(function (letter) { 
if (($.t(!$.in(unicodedata.category(letter), HIDDEN)) || $.t($.in(letter, HARMLESS)))) {return letter;}
return $.cm($.cm(letter, "encode", ["unicode_escape"]), "decode", ["ascii"]); }, {p: ["letter"], ks: false});
Object.assign($m, {"annotations": annotations, "os": os, "re": re, "unicodedata": unicodedata, "Iterable": Iterable, "_PLAIN": _PLAIN, "_SPECIAL": _SPECIAL, "quoted": quoted, "typed": typed, "HARMLESS": HARMLESS, "HIDDEN": HIDDEN, "BREAKS": BREAKS, "visible": visible, "visible_lines": visible_lines, "_shown": _shown});
});
$.module("dehyst.units", ($m) => {
let annotations, math, re, lru_cache, np, npt, UnitError, TABLE, MOST_NAMES, MASS_FACTORS, DIMENSION, ALIASES, _LOWER, _MEGA, _CLOCK_NAMES, _HINTED, _HINTS, canonical, dimension, mass_unit, words, _unit_text, _suffix_unit, parse_unit, convert;
math = $.imp("math");
re = $.imp("re");
lru_cache = $.from("functools", "lru_cache");
np = $.imp("numpy");
npt = $.imp("numpy.typing");
UnitError = $.from("dehyst.errors", "UnitError");
TABLE = $.dict([["pressure", $.dict([["Pa", 1.0], ["kPa", 1000.0], ["MPa", 1000000.0], ["bar", 100000.0], ["mbar", 100.0], ["psi", 6894.757293168361]])], ["angle", $.dict([["rad", 1.0], ["deg", $.div($.ga(math, "pi"), 180)], ["mrad", 0.001]])], ["length", $.dict([["m", 1.0], ["mm", 0.001], ["um", 1e-06], ["nm", 1e-09], ["cm", 0.01], ["in", 0.0254]])], ["force", $.dict([["N", 1.0], ["kN", 1000.0], ["mN", 0.001], ["lbf", 4.4482216152605]])], ["voltage", $.dict([["V", 1.0], ["mV", 0.001], ["kV", 1000.0]])], ["current", $.dict([["A", 1.0], ["mA", 0.001]])], ["torque", $.dict([["Nm", 1.0], ["mNm", 0.001]])], ["time", $.dict([["s", 1.0], ["ms", 0.001], ["us", 1e-06], ["ns", 1e-09], ["min", 60.0], ["h", 3600.0]])]]);
MOST_NAMES = $.shl(1, 17);
MASS_FACTORS = $.dict([["kg", 1.0], ["g", 0.001]]);
DIMENSION = $.dict((() => { const $r = []; for (const $v2 of $.it($.cm(TABLE, "items", []))) { let dimension, units; {const $v3 = $.unpack($v2, 2, -1);dimension = $v3[0];units = $v3[1];} for (const $v1 of $.it(units)) { let unit; unit = $v1; $r.push([unit, dimension]); } } return $r; })());
ALIASES = $.dict([["pascal", "Pa"], ["hpa", "mbar"], ["bars", "bar"], ["psig", "psi"], ["psia", "psi"], ["\u00b0", "deg"], ["degree", "deg"], ["degrees", "deg"], ["degs", "deg"], ["radian", "rad"], ["radians", "rad"], ["rads", "rad"], ["\u00b5m", "um"], ["\u03bcm", "um"], ["micron", "um"], ["microns", "um"], ["micrometer", "um"], ["meter", "m"], ["metre", "m"], ["meters", "m"], ["metres", "m"], ["inch", "in"], ["inches", "in"], ["millimeter", "mm"], ["millimetre", "mm"], ["newton", "N"], ["newtons", "N"], ["volt", "V"], ["volts", "V"], ["ampere", "A"], ["amperes", "A"], ["amp", "A"], ["amps", "A"], ["n\u00b7m", "Nm"], ["n*m", "Nm"], ["n m", "Nm"], ["n.m", "Nm"], ["n-m", "Nm"], ["sec", "s"], ["secs", "s"], ["second", "s"], ["seconds", "s"], ["msec", "ms"], ["millis", "ms"], ["milliseconds", "ms"], ["\u00b5s", "us"], ["\u03bcs", "us"], ["usec", "us"], ["micros", "us"], ["microseconds", "us"], ["nsec", "ns"], ["nanos", "ns"], ["nanoseconds", "ns"], ["nanosec", "ns"], ["minutes", "min"], ["hour", "h"], ["hours", "h"], ["minute", "min"], ["millisecond", "ms"], ["microsecond", "us"], ["nanosecond", "ns"], ["mins", "min"], ["kilopascal", "kPa"], ["megapascal", "MPa"], ["hektopascal", "mbar"], ["hectopascal", "mbar"], ["millibar", "mbar"], ["grad", "deg"], ["winkelgrad", "deg"], ["milliradian", "mrad"], ["milliradians", "mrad"], ["radiant", "rad"], ["millimeters", "mm"], ["millimetres", "mm"], ["centimeter", "cm"], ["centimeters", "cm"], ["centimetre", "cm"], ["centimetres", "cm"], ["zentimeter", "cm"], ["micrometers", "um"], ["micrometre", "um"], ["micrometres", "um"], ["mikrometer", "um"], ["nanometer", "nm"], ["nanometers", "nm"], ["nanometre", "nm"], ["nanometres", "nm"], ["zoll", "in"], ["kilonewton", "kN"], ["kilonewtons", "kN"], ["millinewton", "mN"], ["millinewtons", "mN"], ["newtonmeter", "Nm"], ["newtonmeters", "Nm"], ["newtonmetre", "Nm"], ["newtonmetres", "Nm"], ["newton-meter", "Nm"], ["newton meter", "Nm"], ["millivolt", "mV"], ["millivolts", "mV"], ["kilovolt", "kV"], ["kilovolts", "kV"], ["milliampere", "mA"], ["milliamperes", "mA"], ["milliamp", "mA"], ["milliamps", "mA"], ["sekunde", "s"], ["sekunden", "s"], ["sek", "s"], ["millisekunde", "ms"], ["millisekunden", "ms"], ["msek", "ms"], ["mikrosekunde", "us"], ["mikrosekunden", "us"], ["nanosekunde", "ns"], ["nanosekunden", "ns"], ["minuten", "min"], ["stunde", "h"], ["stunden", "h"]]);
_LOWER = $.bor($.dict((() => { const $r = []; for (const $v4 of $.it($.b.reversed(DIMENSION))) { let unit; unit = $v4; if ($.t($.ne(unit, "Nm"))) { $r.push([$.cm(unit, "lower", []), unit]); } } return $r; })()), ALIASES);
_MEGA = $.b.set(["MN", "MV", "MA", "MNm"]);
_CLOCK_NAMES = $.b.frozenset((function* () { for (const $v5 of $.it($.cm(ALIASES, "items", []))) { let alias, unit; {const $v6 = $.unpack($v5, 2, -1);alias = $v6[0];unit = $v6[1];} if (($.t($.eq($.gi(DIMENSION, unit), "time")) && $.t(!$.in(unit, $.b.set(["min", "h"]))) && $.t($.gt($.b.len(alias), 3)))) { yield alias; } } })());
_HINTED = $.b.set(["a", "v", "n", "m", "h", "s", "in", "min", "ma", "mn", "nm", "amp"]);
_HINTED = $.ibor(_HINTED, $.b.set(["grad", "radiant", "minute"]));
_HINTS = $.dict((() => { const $r = []; for (const $v7 of $.it($.cm($.dict([["length", "displacement position pos length x y z stroke height distance contraction extension elongation travel deflection depth disp weg"], ["angle", "angle winkel phi theta alpha beta gamma rotation drehung tilt"], ["force", "force f load tension kraft thrust grip fx fy fz"], ["voltage", "voltage volt u drive supply spannung piezo uin uout"], ["current", "current i strom"], ["torque", "torque moment tau drehmoment"], ["time", "time t timestamp stamp elapsed zeit temps tiempo duration clock dt date epoch period seconds ros sim"]]), "items", []))) { let dimension, words; {const $v8 = $.unpack($v7, 2, -1);dimension = $v8[0];words = $v8[1];} $r.push([dimension, $.b.frozenset($.cm(words, "split", []))]); } return $r; })());
canonical = $.def(function (unit) { let text;
text = $.cm(unit, "strip", []);
if ($.t($.in(text, DIMENSION))) {return text;}
if ($.t($.in(text, _MEGA))) {return null;}
return $.cm(_LOWER, "get", [$.cm(text, "lower", [])]); }, {p: ["unit"], ks: false});
dimension = $.def(function (unit) { let known;
known = canonical(unit);
return ($.t(known) ? $.gi(DIMENSION, known) : ""); }, {p: ["unit"], ks: false});
mass_unit = $.def(function (name, unit) { let suffix, found;
suffix = $.gi($.cm(re, "split", ["[_\\s]", $.cm(name, "strip", [])]), (-1));
found = $.or(unit, () => suffix);
return ($.t($.in(found, MASS_FACTORS)) ? found : ""); }, {p: ["name", "unit"], ks: false});
words = $.memo($.def(function (name) { let spaced;
spaced = re.sub("([a-z])([A-Z])", "\\1 \\2", name);
return $.b.tuple(re.findall("[^\\W\\d_]+", $.cm(spaced, "lower", []))); }, {p: ["name"], ks: false}));
_unit_text = $.def(function (text) { 
text = $.cm(text, "strip", []);
return ($.t($.in(text, $.b.set(["", "-", "--", "1", "none", "None"]))) ? "" : $.or(canonical(text), () => text)); }, {p: ["text"], ks: false});
_suffix_unit = $.def(function (bare, suffix) { let low, hints, unit;
low = $.cm(suffix, "lower", []);
hints = $.b.set(words(bare));
if (($.t($.eq(low, "nm")) && $.t($.band(hints, $.gi(_HINTS, "torque"))))) {return "Nm";}
unit = canonical(suffix);
if ($.t((unit == null))) {return null;}
if (($.t($.in(low, _HINTED)) && !($.t($.in(suffix, $.b.set(["N", "V"]))) || $.t($.band(hints, $.gi(_HINTS, $.gi(DIMENSION, unit))))))) {return null;}
return unit; }, {p: ["bare", "suffix"], ks: false});
parse_unit = $.memo($.def(function (name) { let text, bracket, inner, slash, rate, bare, found, suffix, unit;
text = $.cm(name, "strip", []);
bracket = re.fullmatch("(.*?\\S)\\s*(?:\\[([^\\[\\]]*)\\]|\\(([^()]*)\\))", text);
if (($.t(bracket) && !$.t($.cm($.or($.gi(bracket, 2), () => ""), "isdigit", [])))) {inner = ($.t(($.gi(bracket, 2) != null)) ? $.gi(bracket, 2) : $.gi(bracket, 3));
return $.tup($.cm($.gi(bracket, 1), "rstrip", ["_ "]), _unit_text(inner));}
slash = re.fullmatch("([^/]*[^/\\s])\\s*/\\s*([^/]+)", text);
if (($.t(slash) && $.t(canonical($.gi(slash, 2))))) {return $.tup($.gi(slash, 1), _unit_text($.gi(slash, 2)));}
rate = re.fullmatch("(.*\\w)_(mm|m|cm|um|deg|rad|bar)_s", text, $.ga(re, "IGNORECASE"));
if (($.t(rate) && $.t($.band($.b.set(words($.gi(rate, 1))), $.b.set(["velocity", "vel", "speed", "rate", "omega", "v"]))))) {return $.tup($.gi(rate, 1), ("" + $.f(canonical($.gi(rate, 2)), "", -1) + "/s"));}
if ($.t($.in($.cm(text, "lower", []), _CLOCK_NAMES))) {return $.tup(text, $.b.str(canonical(text)));}
{const $v9 = $.unpack($.cm(text, "rpartition", ["_"]), 3, -1);bare = $v9[0];found = $v9[1];suffix = $v9[2];}
if (!$.t(found)) {{const $v10 = $.unpack($.cm(text, "rpartition", [" "]), 3, -1);bare = $v10[0];found = $v10[1];suffix = $v10[2];}}
unit = (($.t(found) && $.t($.cm(bare, "strip", ["_ "]))) ? _suffix_unit(bare, suffix) : null);
return ($.t(unit) ? $.tup($.cm(bare, "rstrip", ["_ "]), unit) : $.tup(text, "")); }, {p: ["name"], ks: false}));
convert = $.def(function (values, source, target) { let known, given, unit, a, b, table, array, factor, inverse;
known = [canonical(source), canonical(target)];
for (const $v11 of $.it($.k($.b.zip, [$.tup(source, target), known], {"strict": true}))) { {const $v12 = $.unpack($v11, 2, -1);given = $v12[0];unit = $v12[1];}
{if ($.t((unit == null))) {throw $.exc($.k(UnitError, [("" + "unit '" + $.f(given, "", -1) + "' is not known. Known are " + $.f($.cm(", ", "join", [DIMENSION]), "", -1) + ". Convert the values yourself and put the unit into the column name, for example pressure_bar.")], {"unit": given}));}} }
{const $v13 = $.unpack($.tup($.b.str($.gi(known, 0)), $.b.str($.gi(known, 1))), 2, -1);a = $v13[0];b = $v13[1];}
if ($.t($.ne($.gi(DIMENSION, a), $.gi(DIMENSION, b)))) {throw $.exc($.k(UnitError, [("" + "cannot convert " + $.f(a, "", -1) + " (" + $.f($.gi(DIMENSION, a), "", -1) + ") into " + $.f(b, "", -1) + " (" + $.f($.gi(DIMENSION, b), "", -1) + "): they measure different things. Check that input and output are not swapped and that the column names carry the right units.")], {"source": a, "target": b}));}
table = $.gi(TABLE, $.gi(DIMENSION, a));
array = $.km(np, "asarray", [values], {"dtype": $.ga(np, "float64")});
factor = $.div($.gi(table, a), $.gi(table, b));
inverse = $.div($.gi(table, b), $.gi(table, a));
return ($.t($.cm(inverse, "is_integer", [])) ? $.div(array, inverse) : $.mul(array, factor)); }, {p: ["values", "source", "target"], ks: false});
Object.assign($m, {"annotations": annotations, "math": math, "re": re, "lru_cache": lru_cache, "np": np, "npt": npt, "UnitError": UnitError, "TABLE": TABLE, "MOST_NAMES": MOST_NAMES, "MASS_FACTORS": MASS_FACTORS, "DIMENSION": DIMENSION, "ALIASES": ALIASES, "_LOWER": _LOWER, "_MEGA": _MEGA, "_CLOCK_NAMES": _CLOCK_NAMES, "_HINTED": _HINTED, "_HINTS": _HINTS, "canonical": canonical, "dimension": dimension, "mass_unit": mass_unit, "words": words, "_unit_text": _unit_text, "_suffix_unit": _suffix_unit, "parse_unit": parse_unit, "convert": convert});
});
$.module("dehyst.data.loops", ($m) => {
let annotations, dataclass, np, npt, _native, Array_, TURN_FRACTION, GAP_MEDIANS, GAP_SAMPLES, MOVED, BACK_SAMPLES, BACK_SHARE, LIKE, turning_points, LoopSummary, summarise_loops, gap_limit, memory_lost, taken_back;
dataclass = $.from("dataclasses", "dataclass");
np = $.imp("numpy");
npt = $.imp("numpy.typing");
_native = $.imp("dehyst._native");
Array_ = $.from("dehyst.arrays", "Array");
TURN_FRACTION = 0.05;
GAP_MEDIANS = 5.0;
GAP_SAMPLES = 3.0;
MOVED = 0.05;
BACK_SAMPLES = 50;
BACK_SHARE = 0.01;
LIKE = 0.02;
turning_points = $.def(function (signal, swing = null) { let x;
x = $.km(np, "asarray", [signal], {"dtype": $.ga(np, "float64")});
if ($.t($.eq($.ga(x, "size"), 0))) {return $.km(np, "zeros", [0], {"dtype": $.ga(np, "int64")});}
if ($.t((swing == null))) {swing = $.mul(TURN_FRACTION, $.b.float($.sub(x.max(), x.min())));}
return _native.turning_points(np.ascontiguousarray(x), swing); }, {p: ["signal", "swing"], ks: false});
LoopSummary = $.cls("LoopSummary", [], "", [["turns", null], ["loops", null], ["swings", null]], true, true, ($c) => { LoopSummary = $c; });
summarise_loops = $.def(function (signal, swing = null) { let x, points, swings, turns;
x = $.km(np, "asarray", [signal], {"dtype": $.ga(np, "float64")});
points = turning_points(x, swing);
swings = np.abs(np.diff($.gi(x, points)));
turns = $.b.max(0, $.sub($.ga(points, "size"), 2));
return $.k(LoopSummary, [], {"turns": turns, "loops": $.fdiv($.add(turns, 1), 2), "swings": swings}); }, {p: ["signal", "swing"], ks: false});
gap_limit = $.def(function (step) { let steps, usual, limit;
steps = $.km(np, "asarray", [step], {"dtype": $.ga(np, "float64")});
steps = $.cm(np, "sort", [$.gi(steps, $.gt(steps, 0))]);
if ($.t($.eq($.ga(steps, "size"), 0))) {return $.b.float("inf");}
usual = $.b.float(np.mean($.gi(steps, $.slice(null, $.b.max(1, $.b.int($.mul(0.95, $.ga(steps, "size")))), null))));
limit = $.b.max($.mul(GAP_MEDIANS, $.b.float(np.median(steps))), $.mul(GAP_SAMPLES, usual));
if ($.t($.gt(np.mean($.gt(steps, limit)), 0.05))) {limit = $.mul(GAP_MEDIANS, $.b.float(np.percentile(steps, 95)));}
return $.b.float(limit); }, {p: ["step"], ks: false});
memory_lost = $.def(function (step, moved, span, measured, swings) { let lost;
lost = $.bor($.gt(moved, $.mul(MOVED, span)), $.gt(step, $.div(measured, $.b.max(1, swings))));
return lost; }, {p: ["step", "moved", "span", "measured", "swings"], ks: false});
taken_back = $.def(function (places, size, samples) { let near, found, k, cancels;
near = $.b.max(BACK_SAMPLES, $.b.int($.mul(BACK_SHARE, samples)));
{const $v1 = $.unpack($.tup([], 0), 2, -1);found = $v1[0];k = $v1[1];}
while ($.t($.lt($.add(k, 1), $.ga(places, "size")))) {cancels = $.le($.b.abs($.add($.gi(size, k), $.gi(size, $.add(k, 1)))), $.mul(LIKE, $.b.abs($.gi(size, k))));
if (($.t(cancels) && $.t($.le($.sub($.gi(places, $.add(k, 1)), $.gi(places, k)), near)))) {$.cm(found, "append", [$.tup(k, $.add(k, 1))]);
k = $.iadd(k, 1);}
k = $.iadd(k, 1);}
return found; }, {p: ["places", "size", "samples"], ks: false});
Object.assign($m, {"annotations": annotations, "dataclass": dataclass, "np": np, "npt": npt, "_native": _native, "Array": Array_, "TURN_FRACTION": TURN_FRACTION, "GAP_MEDIANS": GAP_MEDIANS, "GAP_SAMPLES": GAP_SAMPLES, "MOVED": MOVED, "BACK_SAMPLES": BACK_SAMPLES, "BACK_SHARE": BACK_SHARE, "LIKE": LIKE, "turning_points": turning_points, "LoopSummary": LoopSummary, "summarise_loops": summarise_loops, "gap_limit": gap_limit, "memory_lost": memory_lost, "taken_back": taken_back});
});
$.module("dehyst.data.outliers", ($m) => {
let annotations, np, npt, Array_, Mask, Run, SPIKE_LENGTH, SPIKE_RANGE, SPIKE_CURVATURE, SPIKE_STEP, END_RANGE, RARE, CHUNK, FEWEST, LEVELS, CODE_DISTANCE, CODE_SHARE, _CODES, CODES, LEAST_CODE, RUN_JUMP, RUN_STEP, RUN_SMOOTH, RUN_RETURN, RUN_MOST, RUNS_MOST, RUN_BEYOND, JUMPS_MOST, find_outliers, _is_smooth, _codes, _spikes, _certain_range, _excursions, _runs, _between, bridged;
np = $.imp("numpy");
npt = $.imp("numpy.typing");
Array_ = $.from("dehyst.arrays", "Array");Mask = $.from("dehyst.arrays", "Mask");
Run = $.gi($.b.tuple, $.tup($.b.int, $.b.int, $.b.float));
SPIKE_LENGTH = 3;
SPIKE_RANGE = 0.5;
SPIKE_CURVATURE = 10.0;
SPIKE_STEP = 2.0;
END_RANGE = 10.0;
RARE = 0.01;
CHUNK = $.shl(1, 15);
FEWEST = 32;
LEVELS = 8;
CODE_DISTANCE = 3.0;
CODE_SHARE = 0.5;
_CODES = [999.0, 9999.0, 99999.0, 999999.0, 9999999.0, 1000000.0, 10000000.0, 1000000000.0, 10000000000.0, 1e+20, 1e+30, 1e+37, 1e+38, 8191.0, 32767.0];
_CODES = $.iadd(_CODES, [32768.0, 65535.0, 8388607.0, 8388608.0, 2147483647.0, 2147483648.0, 4294967295.0, 999.9, 9999.9]);
CODES = np.array($.b.sorted($.b.set([...$.it(_CODES), ...$.it((function* () { for (const $v1 of $.it(_CODES)) { let code; code = $v1; yield $.neg(code); } })())])));
LEAST_CODE = $.b.min(_CODES);
RUN_JUMP = 0.1;
RUN_STEP = 4.0;
RUN_SMOOTH = 5.0;
RUN_RETURN = 0.5;
RUN_MOST = 5;
RUNS_MOST = 5;
RUN_BEYOND = 0.3;
JUMPS_MOST = 1000;
find_outliers = $.def(function (values) { let found, _, index, fresh;
found = $.km(np, "zeros", [$.ga(values, "size")], {"dtype": $.b.bool});
if (($.t($.lt($.ga(values, "size"), FEWEST)) || $.t(_is_smooth(values)))) {return found;}
for (const $v2 of $.it($.b.range(4))) { _ = $v2;
{index = np.flatnonzero($.inv(found));
fresh = _codes($.gi(values, index));
if (!$.t(fresh.any())) {fresh = _runs($.gi(values, index));}
if (!$.t(fresh.any())) {fresh = _spikes($.gi(values, index));}
if (!$.t(fresh.any())) {break;}
$.si(found, $.gi(index, fresh), true);} }
return found; }, {p: ["values"], ks: false});
_is_smooth = $.def(function (v) { let largest, low, high, least, begin, part;
{const $v3 = $.unpack($.tup(0.0, $.b.float(v.min()), $.b.float(v.max())), 3, -1);largest = $v3[0];low = $v3[1];high = $v3[2];}
if ($.t($.ge($.b.max($.neg(low), high), LEAST_CODE))) {return false;}
least = $.mul($.mul(0.99, RUN_JUMP), _certain_range(v));
for (const $v4 of $.it($.b.range(0, $.sub($.ga(v, "size"), 1), CHUNK))) { begin = $v4;
{part = np.diff($.gi(v, $.slice(begin, $.add($.add(begin, CHUNK), 1), null)));
largest = $.b.max(largest, $.b.float(part.max()), $.neg($.b.float(part.min())));
if ($.t($.gt(largest, least))) {return false;}} }
return true; }, {p: ["v"], ks: false});
_codes = $.def(function (v) { let nothing, codes, others, low, high, away;
nothing = $.km(np, "zeros", [$.ga(v, "size")], {"dtype": $.b.bool});
if (($.t($.lt($.ga(v, "size"), FEWEST)) || $.t($.lt($.b.max($.neg($.b.float(v.min())), $.b.float(v.max())), LEAST_CODE)))) {return nothing;}
codes = np.isin(v, CODES);
if ((!$.t(codes.any()) || $.t($.gt(codes.mean(), CODE_SHARE)))) {return nothing;}
others = $.gi(v, $.inv(codes));
{const $v5 = $.unpack($.tup($.b.float(others.min()), $.b.float(others.max())), 2, -1);low = $v5[0];high = $v5[1];}
if (($.t($.lt($.ga(others, "size"), FEWEST)) || $.t($.lt($.ga(np.unique(others), "size"), LEVELS)))) {return nothing;}
away = $.mul(CODE_DISTANCE, $.sub(high, low));
return np.asarray($.band(codes, $.bor($.gt(v, $.add(high, away)), $.lt(v, $.sub(low, away))))); }, {p: ["v"], ks: false});
_spikes = $.def(function (v) { let flagged, steps, largest, low, high, least, jump, others, span, bend, step, limit, kept;
flagged = $.km(np, "zeros", [$.ga(v, "size")], {"dtype": $.b.bool});
if ($.t($.lt($.ga(v, "size"), FEWEST))) {return flagged;}
steps = np.diff(v);
largest = $.b.max($.b.float(steps.max()), $.neg($.b.float(steps.min())));
if ($.t($.le(largest, $.mul($.mul($.mul(0.99, 0.8), SPIKE_RANGE), _certain_range(v))))) {return flagged;}
{const $v6 = $.unpack(np.percentile(v, [2, 98]), 2, -1);low = $v6[0];high = $v6[1];}
least = $.mul($.mul(0.8, SPIKE_RANGE), $.sub(high, low));
if ($.t($.le(largest, least))) {return flagged;}
jump = _excursions(v);
flagged = $.km(np, "asarray", [$.gt(jump, least)], {"dtype": $.b.bool});
while ($.t(flagged.any())) {if ($.t($.gt(flagged.sum(), $.b.max(SPIKE_LENGTH, $.mul(RARE, $.ga(v, "size")))))) {return $.km(np, "zeros", [$.ga(v, "size")], {"dtype": $.b.bool});}
others = $.gi(v, $.inv(flagged));
span = $.b.float(np.ptp(others));
if (($.t($.lt($.ga(np.unique(others), "size"), LEVELS)) || $.t($.eq(span, 0.0)))) {return $.km(np, "zeros", [$.ga(v, "size")], {"dtype": $.b.bool});}
bend = $.b.float(np.quantile(np.abs(np.diff(others, 2)), 0.999));
step = $.b.float(np.max(np.abs(np.diff(others))));
limit = np.full($.ga(v, "size"), $.b.max($.mul(SPIKE_RANGE, span), $.mul(SPIKE_CURVATURE, bend), $.mul(SPIKE_STEP, step)));
$.si(limit, $.slice(null, SPIKE_LENGTH, null), np.maximum($.gi(limit, $.slice(null, SPIKE_LENGTH, null)), $.mul(END_RANGE, span)));
$.si(limit, $.slice($.neg(SPIKE_LENGTH), null, null), np.maximum($.gi(limit, $.slice($.neg(SPIKE_LENGTH), null, null)), $.mul(END_RANGE, span)));
kept = $.band(flagged, $.gt(jump, limit));
if ($.t(np.array_equal(kept, flagged))) {break;}
flagged = kept;}
return flagged; }, {p: ["v"], ks: false});
_certain_range = $.def(function (v) { let bottom, top, low, high, enough;
{const $v7 = $.unpack($.tup($.b.float(v.min()), $.b.float(v.max())), 2, -1);bottom = $v7[0];top = $v7[1];}
{const $v8 = $.unpack($.tup($.add(bottom, $.mul(0.25, $.sub(top, bottom))), $.sub(top, $.mul(0.25, $.sub(top, bottom)))), 2, -1);low = $v8[0];high = $v8[1];}
enough = $.add($.mul(0.02, $.ga(v, "size")), 1);
if (($.t($.gt(np.count_nonzero($.le(v, low)), enough)) && $.t($.gt(np.count_nonzero($.ge(v, high)), enough)))) {return $.sub(high, low);}
return 0.0; }, {p: ["v"], ks: false});
_excursions = $.def(function (v) { let jump, top, bottom, length, before, after, above, below, off, k, part;
jump = np.zeros($.ga(v, "size"));
{ const $v9 = v; top = $v9; bottom = $v9;}
for (const $v10 of $.it($.b.range(1, $.add(SPIKE_LENGTH, 1)))) { length = $v10;
{if ($.t($.gt(length, 1))) {{const $v11 = $.unpack($.tup(np.maximum($.gi(top, $.slice(null, (-1), null)), $.gi(v, $.slice($.sub(length, 1), null, null))), np.minimum($.gi(bottom, $.slice(null, (-1), null)), $.gi(v, $.slice($.sub(length, 1), null, null)))), 2, -1);top = $v11[0];bottom = $v11[1];}}
before = np.concatenate($.tup($.gi(v, $.slice(length, $.add(length, 1), null)), $.gi(v, $.slice(null, $.sub($.ga(v, "size"), length), null))));
after = np.concatenate($.tup($.gi(v, $.slice(length, null, null)), $.gi(v, $.slice($.sub($.sub($.ga(v, "size"), length), 1), $.sub($.ga(v, "size"), length), null))));
above = $.sub(bottom, np.maximum(before, after));
below = $.sub(np.minimum(before, after), top);
off = np.maximum(above, below);
$.si(off, $.gt(np.abs($.sub(before, after)), $.mul(0.5, off)), 0.0);
for (const $v12 of $.it($.b.range(length))) { k = $v12;
{part = $.gi(jump, $.slice(k, $.add(k, $.ga(off, "size")), null));
$.km(np, "maximum", [part, off], {"out": part});} }} }
return jump; }, {p: ["v"], ks: false});
_runs = $.def(function (v) { let flagged, steps, low, high, most, jumps, runs, begin, end, _, others, span, step, least, kept, long;
flagged = $.km(np, "zeros", [$.ga(v, "size")], {"dtype": $.b.bool});
if ($.t($.lt($.ga(v, "size"), FEWEST))) {return flagged;}
steps = np.diff(v);
if ($.t($.le($.b.max($.b.float(steps.max()), $.neg($.b.float(steps.min()))), $.mul($.mul(0.99, RUN_JUMP), _certain_range(v))))) {return flagged;}
{const $v13 = $.unpack(np.percentile(v, [2, 98]), 2, -1);low = $v13[0];high = $v13[1];}
most = $.b.max(RUN_MOST, $.b.int($.mul(RARE, $.ga(v, "size"))));
jumps = np.flatnonzero($.gt(np.abs(steps), $.mul(RUN_JUMP, $.sub(high, low))));
if (!$.t((($t0, $t1) => $.t($.lt(0, ($t0 = $.ga(jumps, "size")))) && $.t($.le($t0, $.b.min(JUMPS_MOST, $.mul(4, most)))))())) {return flagged;}
runs = _between(v, jumps, most, low, high);
while ($.t(runs)) {$.si(flagged, $.slice(null, null, null), false);
for (const $v14 of $.it(runs)) { {const $v15 = $.unpack($v14, 3, -1);begin = $v15[0];end = $v15[1];_ = $v15[2];}
{$.si(flagged, $.slice(begin, end, null), true);} }
others = $.gi(v, $.inv(flagged));
if (($.t($.gt(flagged.sum(), most)) || $.t($.lt($.ga(others, "size"), FEWEST)) || $.t($.lt($.ga(np.unique(others), "size"), LEVELS)))) {runs = [];
break;}
span = $.b.float(np.ptp(others));
step = $.b.float(np.max(np.abs($.gi(steps, $.inv($.bor($.gi(flagged, $.slice(1, null, null)), $.gi(flagged, $.slice(null, (-1), null))))))));
if ($.t($.gt($.mul(step, RUN_SMOOTH), span))) {runs = [];
break;}
least = $.b.max($.mul(RUN_JUMP, span), $.mul(RUN_STEP, step));
kept = (() => { const $r = []; for (const $v16 of $.it(runs)) { let run; run = $v16; if ($.t($.gt($.gi(run, 2), least))) { $r.push(run); } } return $r; })();
if ($.t($.eq($.b.len(kept), $.b.len(runs)))) {break;}
runs = kept;}
long = (() => { const $r = []; for (const $v17 of $.it(runs)) { let run; run = $v17; if ($.t($.gt($.sub($.gi(run, 1), $.gi(run, 0)), SPIKE_LENGTH))) { $r.push(run); } } return $r; })();
return (($.t(runs) && $.t($.le($.b.len(long), RUNS_MOST))) ? flagged : $.km(np, "zeros", [$.ga(v, "size")], {"dtype": $.b.bool})); }, {p: ["v"], ks: false});
_between = $.def(function (v, jumps, most, low, high) { let size, slack, runs, beyond, k, last, m, end, first, others, smaller, back;
{const $v18 = $.unpack($.tup(np.abs($.gi(np.diff(v), jumps)), $.mul(RUN_BEYOND, $.sub(high, low))), 2, -1);size = $v18[0];slack = $v18[1];}
runs = [];
beyond = $.def(function (part) { 
return $.b.bool($.or($.gt(part.min(), $.add(high, slack)), () => $.lt(part.max(), $.sub(low, slack)))); }, {p: ["part"], ks: false});
{ const $v19 = 0; k = $v19; last = $v19;}
for (const $v20 of $.it(np.flatnonzero($.lt(jumps, RUN_MOST)).tolist())) { m = $v20;
{if ($.t(beyond($.gi(v, $.slice(null, $.add($.gi(jumps, m), 1), null))))) {{const $v21 = $.unpack($.tup([$.tup(0, $.add($.b.int($.gi(jumps, m)), 1), $.b.float($.gi(size, m)))], $.add(m, 1)), 2, -1);runs = $v21[0];k = $v21[1];}}} }
end = $.ga(jumps, "size");
for (const $v22 of $.it($.gi(np.flatnonzero($.ge(jumps, $.sub($.sub($.ga(v, "size"), 1), RUN_MOST))), $.slice(null, null, (-1))).tolist())) { m = $v22;
{if (($.t($.ge(m, k)) && $.t(beyond($.gi(v, $.slice($.add($.gi(jumps, m), 1), null, null)))))) {end = m;}} }
while ($.t($.lt(k, end))) {first = $.gi(jumps, k);
last = $.b.int($.km(np, "searchsorted", [jumps, $.add(first, most)], {"side": "right"}));
others = np.arange($.add(k, 1), $.b.min(last, end));
smaller = np.minimum($.gi(size, k), $.gi(size, others));
back = $.gi(others, $.le(np.abs($.sub($.gi(v, $.add($.gi(jumps, others), 1)), $.gi(v, first))), $.mul(RUN_RETURN, smaller)));
if ($.t($.ga(back, "size"))) {$.cm(runs, "append", [$.tup($.add($.b.int(first), 1), $.add($.b.int($.gi(jumps, $.gi(back, 0))), 1), $.b.float($.b.min($.gi(size, k), $.gi(size, $.gi(back, 0)))))]);
k = $.b.int($.gi(back, 0));}
k = $.iadd(k, 1);}
if ($.t($.lt(end, $.ga(jumps, "size")))) {$.cm(runs, "append", [$.tup($.add($.b.int($.gi(jumps, end)), 1), $.ga(v, "size"), $.b.float($.gi(size, end)))]);}
return runs; }, {p: ["v", "jumps", "most", "low", "high"], ks: false});
bridged = $.def(function (values, bad) { let good, filled;
good = np.flatnonzero($.inv(bad));
filled = $.cm(values, "copy", []);
$.si(filled, bad, np.interp(np.flatnonzero(bad), good, $.gi(values, good)));
return filled; }, {p: ["values", "bad"], ks: false});
Object.assign($m, {"annotations": annotations, "np": np, "npt": npt, "Array": Array_, "Mask": Mask, "Run": Run, "SPIKE_LENGTH": SPIKE_LENGTH, "SPIKE_RANGE": SPIKE_RANGE, "SPIKE_CURVATURE": SPIKE_CURVATURE, "SPIKE_STEP": SPIKE_STEP, "END_RANGE": END_RANGE, "RARE": RARE, "CHUNK": CHUNK, "FEWEST": FEWEST, "LEVELS": LEVELS, "CODE_DISTANCE": CODE_DISTANCE, "CODE_SHARE": CODE_SHARE, "_CODES": _CODES, "CODES": CODES, "LEAST_CODE": LEAST_CODE, "RUN_JUMP": RUN_JUMP, "RUN_STEP": RUN_STEP, "RUN_SMOOTH": RUN_SMOOTH, "RUN_RETURN": RUN_RETURN, "RUN_MOST": RUN_MOST, "RUNS_MOST": RUNS_MOST, "RUN_BEYOND": RUN_BEYOND, "JUMPS_MOST": JUMPS_MOST, "find_outliers": find_outliers, "_is_smooth": _is_smooth, "_codes": _codes, "_spikes": _spikes, "_certain_range": _certain_range, "_excursions": _excursions, "_runs": _runs, "_between": _between, "bridged": bridged});
});
$.module("dehyst.data.ranges", ($m) => {
let annotations, Sequence, np, Array_, FEW, MAKE, IN_A_ROW, FEWEST, robust_range, _held;
Sequence = $.from("collections.abc", "Sequence");
np = $.imp("numpy");
Array_ = $.from("dehyst.arrays", "Array");
FEW = 0.005;
MAKE = 0.2;
IN_A_ROW = 6;
FEWEST = 32;
robust_range = $.def(function (parts) { let there, low, high, count, few, near, values, least, most, held, inner;
there = (() => { const $r = []; for (const $v1 of $.it(parts)) { let part; part = $v1; if ($.t($.ga(part, "size"))) { $r.push(part); } } return $r; })();
{const $v4 = $.unpack($.tup($.b.min((function* () { for (const $v2 of $.it(there)) { let part; part = $v2; yield $.b.float(part.min()); } })()), $.b.max((function* () { for (const $v3 of $.it(there)) { let part; part = $v3; yield $.b.float(part.max()); } })())), 2, -1);low = $v4[0];high = $v4[1];}
count = $.b.sum((function* () { for (const $v5 of $.it(there)) { let part; part = $v5; yield $.ga(part, "size"); } })());
few = $.b.max(1, $.b.int($.mul(FEW, count)));
near = $.mul($.mul(0.5, MAKE), $.sub(high, low));
if (($.t($.lt(count, FEWEST)) || $.t($.b.all((function* () { for (const $v7 of $.it($.tup((() => { const $r = []; for (const $v8 of $.it(there)) { let part; part = $v8; $r.push($.ge(part, $.sub(high, near))); } return $r; })(), (() => { const $r = []; for (const $v9 of $.it(there)) { let part; part = $v9; $r.push($.le(part, $.add(low, near))); } return $r; })()))) { let ends; ends = $v7; yield $.gt($.b.sum((function* () { for (const $v6 of $.it(ends)) { let inside; inside = $v6; yield $.b.int(np.count_nonzero(inside)); } })()), few); } })())))) {return $.sub(high, low);}
values = np.concatenate(there);
{const $v10 = $.unpack($.gi($.cm(np, "partition", [values, [few, $.sub($.sub(count, 1), few)]]), [few, $.sub($.sub(count, 1), few)]).tolist(), 2, -1);least = $v10[0];most = $v10[1];}
if ($.t($.ge($.sub(most, least), $.mul($.sub(1.0, MAKE), $.sub(high, low))))) {return $.sub(high, low);}
held = (() => { const $r = []; for (const $v11 of $.it(there)) { let part; part = $v11; if ($.t($.ge($.ga(part, "size"), IN_A_ROW))) { $r.push(_held(part)); } } return $r; })();
inner = $.b.float($.sub($.b.max([most, ...$.it((function* () { for (const $v12 of $.it(held)) { let _, top; {const $v13 = $.unpack($v12, 2, -1);_ = $v13[0];top = $v13[1];} yield top; } })())]), $.b.min([least, ...$.it((function* () { for (const $v14 of $.it(held)) { let bottom, _; {const $v15 = $.unpack($v14, 2, -1);bottom = $v15[0];_ = $v15[1];} yield bottom; } })())])));
return ($.t($.gt(inner, $.mul(1e-09, $.sub(high, low)))) ? inner : $.sub(high, low)); }, {p: ["parts"], ks: false});
_held = $.def(function (values) { let windows;
windows = $.ga($.ga(np, "lib"), "stride_tricks").sliding_window_view(values, IN_A_ROW);
return $.tup($.b.float($.km(windows, "max", [], {"axis": 1}).min()), $.b.float($.km(windows, "min", [], {"axis": 1}).max())); }, {p: ["values"], ks: false});
Object.assign($m, {"annotations": annotations, "Sequence": Sequence, "np": np, "Array": Array_, "FEW": FEW, "MAKE": MAKE, "IN_A_ROW": IN_A_ROW, "FEWEST": FEWEST, "robust_range": robust_range, "_held": _held});
});
$.module("dehyst.data.recording", ($m) => {
let annotations, functools, inspect, itertools, os, Callable, Iterator, Mapping, Sequence, dataclass, field, replace, Any, ParamSpec, TypeVar, np, npt, Array_, Plotted, MissingExtraError, ParameterError, RecordingError, Finding, P, R, MINIMUM_SAMPLES, _signal, Recording, require_recordings, takes_recordings, _made_of;
functools = $.imp("functools");
inspect = $.imp("inspect");
itertools = $.imp("itertools");
os = $.imp("os");
Callable = $.from("collections.abc", "Callable");Iterator = $.from("collections.abc", "Iterator");Mapping = $.from("collections.abc", "Mapping");Sequence = $.from("collections.abc", "Sequence");
dataclass = $.from("dataclasses", "dataclass");field = $.from("dataclasses", "field");replace = $.from("dataclasses", "replace");
Any = $.from("typing", "Any");ParamSpec = $.from("typing", "ParamSpec");TypeVar = $.from("typing", "TypeVar");
np = $.imp("numpy");
npt = $.imp("numpy.typing");
Array_ = $.from("dehyst.arrays", "Array");
Plotted = $.from("dehyst.data.plotted", "Plotted");
MissingExtraError = $.from("dehyst.errors", "MissingExtraError");ParameterError = $.from("dehyst.errors", "ParameterError");RecordingError = $.from("dehyst.errors", "RecordingError");
Finding = $.from("dehyst.findings", "Finding");
P = ParamSpec("P");
R = TypeVar("R");
MINIMUM_SAMPLES = 4;
_signal = $.def(function (values, role, name) { let array, fault, bad;
try {array = $.km(np, "array", [values], {"dtype": $.ga(np, "float64"), "copy": true, "order": "C"});} catch ($e) { $e = $.caught($e); if ($.isinst($e, $.tup($.b.TypeError, $.b.ValueError))) { fault = $e; {throw $.exc($.k(RecordingError, [("" + $.f(role, "", -1) + " of recording '" + $.f(name, "", -1) + "' is not a sequence of numbers (" + $.f(fault, "", -1) + "). Pass a one-dimensional array of numbers: Recording(input=x, output=y, time=t).")], {"role": role}));} } else throw $e; }
if ($.t($.ne($.ga(array, "ndim"), 1))) {throw $.exc($.k(RecordingError, [("" + $.f(role, "", -1) + " of recording '" + $.f(name, "", -1) + "' has shape " + $.f($.ga(array, "shape"), "", -1) + ", but one value a sample is needed. Pass one column, shape (T,), for example data[:, 0].")], {"role": role, "shape": $.ga(array, "shape")}));}
bad = np.flatnonzero($.inv(np.isfinite(array)));
if ($.t($.ga(bad, "size"))) {throw $.exc($.k(RecordingError, [("" + $.f(role, "", -1) + " of recording '" + $.f(name, "", -1) + "' has " + $.f($.ga(bad, "size"), "", -1) + " samples that are not finite, the first at index " + $.f($.gi(bad, 0), "", -1) + ". A play operator would carry them into every later sample. Drop those samples (keep = numpy.isfinite(x) & numpy.isfinite(y)), or let dehyst.read_log do it.")], {"role": role, "indices": bad}));}
$.ga(array, "flags").writeable = false;
return array; }, {p: ["values", "role", "name"], ks: false});
Recording = $.cls("Recording", [Plotted], "", [["input", null], ["output", null], ["time", () => null], ["name", () => "recording"], ["input_name", () => "input"], ["output_name", () => "output"], ["input_unit", () => ""], ["output_unit", () => ""], ["breaks", () => $.tup()], ["findings", () => $.tup()], ["provenance", () => $.b.dict()], ["left_out", () => $.tup()]], true, false, ($c) => { Recording = $c; $.meth($c, "__post_init__", $.def(function () { const self = this;let put, edges;
put = $.ga($.b.object, "__setattr__");
put(self, "input", _signal($.ga(self, "input"), "input", $.ga(self, "name")));
put(self, "output", _signal($.ga(self, "output"), "output", $.ga(self, "name")));
put(self, "findings", $.b.tuple($.ga(self, "findings")));
put(self, "provenance", $.b.dict($.ga(self, "provenance")));
put(self, "breaks", $.b.tuple((function* () { for (const $v1 of $.it($.ga(self, "breaks"))) { let k; k = $v1; yield $.b.int(k); } })()));
put(self, "left_out", $.b.tuple($.b.sorted($.b.set((() => { const $r = []; for (const $v2 of $.it($.ga(self, "left_out"))) { let k; k = $v2; $r.push($.b.int(k)); } return $r; })()))));
if ($.t($.ne($.ga($.ga(self, "input"), "size"), $.ga($.ga(self, "output"), "size")))) {throw $.exc($.k(RecordingError, [("" + "recording '" + $.f($.ga(self, "name"), "", -1) + "' has " + $.f($.ga($.ga(self, "input"), "size"), "", -1) + " input samples but " + $.f($.ga($.ga(self, "output"), "size"), "", -1) + " output samples; sample k of both must belong together. Cut or resample them to one clock first.")], {"input": $.ga($.ga(self, "input"), "size"), "output": $.ga($.ga(self, "output"), "size")}));}
if ($.t($.lt($.ga($.ga(self, "input"), "size"), MINIMUM_SAMPLES))) {throw $.exc($.k(RecordingError, [("" + "recording '" + $.f($.ga(self, "name"), "", -1) + "' has " + $.f($.ga($.ga(self, "input"), "size"), "", -1) + " samples; a loop needs at least " + $.f(MINIMUM_SAMPLES, "", -1) + ". Check the window (--from, --to) and the run (--run).")], {"samples": $.ga($.ga(self, "input"), "size")}));}
edges = $.tup(0, ...$.it($.ga(self, "breaks")), $.ga($.ga(self, "input"), "size"));
if ($.t($.b.any((function* () { for (const $v3 of $.it(itertools.pairwise(edges))) { let a, b; {const $v4 = $.unpack($v3, 2, -1);a = $v4[0];b = $v4[1];} yield $.le(b, a); } })()))) {throw $.exc($.k(RecordingError, [("" + "breaks of recording '" + $.f($.ga(self, "name"), "", -1) + "' must increase strictly and lie between 1 and " + $.f($.sub($.ga($.ga(self, "input"), "size"), 1), "", -1) + ", got " + $.f($.ga(self, "breaks"), "", -1) + ".")], {"breaks": $.ga(self, "breaks")}));}
if (($.t($.ga(self, "left_out")) && !$.t((($t0, $t1, $t2) => $.t($.le(0, ($t0 = $.gi($.ga(self, "left_out"), 0)))) && $.t($.le($t0, ($t1 = $.gi($.ga(self, "left_out"), (-1))))) && $.t($.lt($t1, $.ga($.ga(self, "input"), "size"))))()))) {throw $.exc($.k(RecordingError, [("" + "left_out of recording '" + $.f($.ga(self, "name"), "", -1) + "' must hold indices from 0 to " + $.f($.sub($.ga($.ga(self, "input"), "size"), 1), "", -1) + ", got " + $.f($.gi($.ga(self, "left_out"), 0), "", -1) + " to " + $.f($.gi($.ga(self, "left_out"), (-1)), "", -1) + ".")], {"left_out": $.ga(self, "left_out")}));}
if ($.t(($.ga(self, "time") != null))) {self._check_time(edges);} }, {p: [], ks: false}));
$.meth($c, "_check_time", $.def(function (edges) { const self = this;let time, backward, inside;
time = _signal(($.t(($.ga(self, "time") != null)) ? $.ga(self, "time") : []), "time", $.ga(self, "name"));
$.seta(self, "time", time);
if ($.t($.ne($.ga(time, "size"), $.ga($.ga(self, "input"), "size")))) {throw $.exc($.k(RecordingError, [("" + "recording '" + $.f($.ga(self, "name"), "", -1) + "' has " + $.f($.ga(time, "size"), "", -1) + " time stamps for " + $.f($.ga($.ga(self, "input"), "size"), "", -1) + " samples. Pass one time per sample, or time=None.")], {"time": $.ga(time, "size"), "samples": $.ga($.ga(self, "input"), "size")}));}
backward = $.add(np.flatnonzero($.le(np.diff(time), 0)), 1);
inside = np.setdiff1d(backward, $.km(np, "array", [$.gi(edges, $.slice(1, (-1), null))], {"dtype": $.ga(np, "int64")}));
if ($.t($.ga(inside, "size"))) {throw $.exc($.k(RecordingError, [("" + "time of recording '" + $.f($.ga(self, "name"), "", -1) + "' does not increase at " + $.f($.ga(inside, "size"), "", -1) + " samples, the first at index " + $.f($.gi(inside, 0), "", -1) + ". The order of the samples decides the memory of the model. Sort or drop them, or let dehyst.read_log do it.")], {"indices": inside}));} }, {p: ["edges"], ks: false}));
$.meth($c, "__len__", $.def(function () { const self = this;
return $.b.int($.ga($.ga(self, "input"), "size")); }, {p: [], ks: false}));
$.prop($c, "samples", $.def(function () { const self = this;let stands_for;
stands_for = $.cm($.ga(self, "provenance"), "get", ["samples"]);
return ($.t($.b.isinstance(stands_for, $.b.int)) ? stands_for : $.b.len(self)); }, {p: [], ks: false}));
$.prop($c, "input_label", $.def(function () { const self = this;
return ($.t($.ga(self, "input_unit")) ? ("" + $.f($.ga(self, "input_name"), "", -1) + " [" + $.f($.ga(self, "input_unit"), "", -1) + "]") : $.ga(self, "input_name")); }, {p: [], ks: false}));
$.prop($c, "output_label", $.def(function () { const self = this;
return ($.t($.ga(self, "output_unit")) ? ("" + $.f($.ga(self, "output_name"), "", -1) + " [" + $.f($.ga(self, "output_unit"), "", -1) + "]") : $.ga(self, "output_name")); }, {p: [], ks: false}));
$.prop($c, "pieces", $.def(function () { const self = this;let edges;
edges = $.tup(0, ...$.it($.ga(self, "breaks")), $.b.len(self));
return $.b.tuple((function* () { for (const $v5 of $.it(itertools.pairwise(edges))) { let a, b; {const $v6 = $.unpack($v5, 2, -1);a = $v6[0];b = $v6[1];} yield $.b.slice(a, b); } })()); }, {p: [], ks: false}));
$.cmeth($c, "from_frame", $.def(function (frame, input, output, time = null, more = $.dict()) { const cls = this;let dehyst;
dehyst = $.imp("dehyst");
return $.km(dehyst, "read_log", [frame, input, output], {"time": time, ...$.obj(more)}); }, {p: ["frame", "input", "output", "time"], ks: true}));
$.meth($c, "to_frame", $.def(function (backend = "pandas") { const self = this;let columns, narwhals, fault;
columns = ($.t(($.ga(self, "time") == null)) ? $.dict([]) : $.dict([["time_s", $.ga(self, "time")]]));
columns = $.ibor(columns, $.dict([[$.ga(self, "input_label"), $.ga(self, "input")], [$.ga(self, "output_label"), $.ga(self, "output")]]));
try {narwhals = $.imp("narwhals");
return $.km(narwhals, "from_dict", [columns], {"backend": backend}).to_native();} catch ($e) { $e = $.caught($e); if ($.isinst($e, $.tup($.b.ImportError, $.b.ValueError, $.b.TypeError))) { fault = $e; {throw $.exc($.k(MissingExtraError, [("" + "no frame of " + $.f(backend, ("" + ".40"), 114) + " can be made (" + $.f(fault, ("" + ".120"), 115) + "). Type to_frame('pandas'), 'polars' or 'pyarrow' once it is installed, and: pip install 'dehyst[frames]'")], {"extra": "frames"}));} } else throw $e; } }, {p: ["backend"], ks: false}));
$.meth($c, "with_findings", $.def(function (...more) { const self = this;
return $.k(replace, [self], {"findings": $.tup(...$.it($.ga(self, "findings")), ...$.it(more))}); }, {p: [], va: true}));});
require_recordings = $.def(function (given) { let records, what, cure;
if ($.t($.b.isinstance(given, Recording))) {return $.tup(given);}
records = ($.t($.b.isinstance(given, $.bor(Sequence, Iterator))) ? $.b.tuple(given) : $.tup());
if (($.t(records) && $.t($.b.all((function* () { for (const $v7 of $.it(records)) { let record; record = $v7; yield $.b.isinstance(record, Recording); } })())))) {return records;}
{const $v8 = $.unpack(_made_of(given), 2, -1);what = $v8[0];cure = $v8[1];}
throw $.exc($.k(ParameterError, [("" + "a Recording or a list of Recordings is needed, and " + $.f(what, "", -1) + " was given: nothing tells what in it is input, output and time. Type: recording = " + $.f(cure, "", -1) + ", and give that.")], {"given": $.ga($.b.type(given), "__name__")})); }, {p: ["given"], ks: false});
takes_recordings = $.def(function (function_) { let signature, place, call;
signature = inspect.signature(function_);
place = $.cm($.b.list($.ga(signature, "parameters")), "index", ["recordings"]);
call = functools.wraps(function_)($.def(function (...args) { const $kw = $.popkw(args);let others = $kw.rest();
try {$.km(signature, "bind", [...$.it(args)], {...$.obj(others)});} catch ($e) { $e = $.caught($e); if ($.isinst($e, $.b.TypeError)) {  {if ($.t($.gt($.b.len(args), place))) {require_recordings($.gi(args, place));}
throw $e;} } else throw $e; }
return $.k(function_, [...$.it(args)], {...$.obj(others)}); }, {p: [], va: true}));
return call; }, {p: ["function"], ks: false});
_made_of = $.def(function (given) { let names, shown, x, y, time, shape, made;
if ($.t($.b.isinstance(given, $.bor($.b.str, $.ga(os, "PathLike"))))) {return $.tup(("" + "the path " + $.f($.b.str(given), ("" + ".80"), 114)), ("" + "dehyst.read_log(" + $.f($.b.str(given), ("" + ".80"), 114) + ", input='...', output='...')"));}
names = (() => { const $r = []; for (const $v9 of $.it($.b.getattr(given, "columns", $.tup()))) { let name; name = $v9; if ($.t($.b.isinstance(name, $.b.str))) { $r.push(name); } } return $r; })();
if ($.t($.ge($.b.len(names), 2))) {shown = ("" + "a table with the columns " + $.f($.cm(", ", "join", [$.gi(names, $.slice(null, 8, null))]), "", -1) + $.f(($.t($.gt($.b.len(names), 8)) ? ", ..." : ""), "", -1));
{const $v10 = $.unpack($.gi(names, $.slice((-2), null, null)), 2, -1);x = $v10[0];y = $v10[1];}
time = ($.t($.gt($.b.len(names), 2)) ? ("" + ", time=" + $.f($.gi(names, 0), "", 114)) : "");
return $.tup(shown, ("" + "dehyst.Recording.from_frame(table, input=" + $.f(x, "", 114) + ", output=" + $.f(y, "", 114) + $.f(time, "", -1) + ")"));}
shape = $.b.getattr(given, "shape", null);
if (($.t($.b.isinstance(shape, $.b.tuple)) && $.t($.eq($.b.len(shape), 2)))) {return $.tup(("" + "an array of shape " + $.f(shape, "", -1)), "dehyst.Recording(input=data[:, 0], output=data[:, 1])");}
made = "dehyst.Recording(input=u, output=y, time=t)";
if (($.t((shape == null)) && !($.t($.b.isinstance(given, Sequence)) && $.t(given)))) {return $.tup(("" + $.f($.ga($.b.type(given), "__name__"), "", -1)), ("" + $.f(made, "", -1) + " of arrays, or dehyst.read_log(path, input=..., output=...) of a file"));}
return $.tup(("" + "a " + $.f($.ga($.b.type(given), "__name__"), "", -1) + " of numbers"), made); }, {p: ["given"], ks: false});
Object.assign($m, {"annotations": annotations, "functools": functools, "inspect": inspect, "itertools": itertools, "os": os, "Callable": Callable, "Iterator": Iterator, "Mapping": Mapping, "Sequence": Sequence, "dataclass": dataclass, "field": field, "replace": replace, "Any": Any, "ParamSpec": ParamSpec, "TypeVar": TypeVar, "np": np, "npt": npt, "Array": Array_, "Plotted": Plotted, "MissingExtraError": MissingExtraError, "ParameterError": ParameterError, "RecordingError": RecordingError, "Finding": Finding, "P": P, "R": R, "MINIMUM_SAMPLES": MINIMUM_SAMPLES, "_signal": _signal, "Recording": Recording, "require_recordings": require_recordings, "takes_recordings": takes_recordings, "_made_of": _made_of});
});
$.module("dehyst.identification.cautions", ($m) => {
let annotations, Iterator, dataclass, np, Recording, Finding, DataSet, HIGH_GAIN, STATIC, is_high, Candidate, Certificate, LoopFacts, Measured, AFFORDABLE, STATIC_AS_GOOD, PAPER_EPS, RATE_SIZE, DRIFT_SIZE, DRIFT_CERTAINTY, BEYOND, USELESS_GAIN, OTHER_ACTUATOR, POOR_PERCENT, ROW_GAIN, INVERSE_MISSES, LEVELS_APART, SMALL_TEST, Knows, of_range, about_data, about_fit, _levels, late, plays_only, no_hysteresis, no_held_out, _bound_of_paper, _of_units, _cure_of_gain;
Iterator = $.from("collections.abc", "Iterator");
dataclass = $.from("dataclasses", "dataclass");
np = $.imp("numpy");
Recording = $.from("dehyst.data.recording", "Recording");
Finding = $.from("dehyst.findings", "Finding");
DataSet = $.from("dehyst.identification.data", "DataSet");
HIGH_GAIN = $.from("dehyst.identification.families", "HIGH_GAIN");STATIC = $.from("dehyst.identification.families", "STATIC");is_high = $.from("dehyst.identification.families", "is_high");
Candidate = $.from("dehyst.identification.fit", "Candidate");Certificate = $.from("dehyst.identification.fit", "Certificate");LoopFacts = $.from("dehyst.identification.fit", "LoopFacts");
Measured = $.from("dehyst.identification.scores", "Measured");
AFFORDABLE = $.from("dehyst.identification.selection", "AFFORDABLE");STATIC_AS_GOOD = $.from("dehyst.identification.selection", "STATIC_AS_GOOD");
PAPER_EPS = $.from("dehyst.identification.settings", "PAPER_EPS");
RATE_SIZE = 0.007;
DRIFT_SIZE = 0.02;
DRIFT_CERTAINTY = 3.0;
BEYOND = 0.02;
USELESS_GAIN = 2000.0;
OTHER_ACTUATOR = 0.25;
POOR_PERCENT = 10.0;
ROW_GAIN = "Smooth the reference. Or, where the loop runs counter-clockwise and neither creep nor rate matters, take plays with a smaller gain: --max-inverse-gain G, in units of input over output.";
INVERSE_MISSES = 25.0;
LEVELS_APART = 0.05;
SMALL_TEST = 0.1;
Knows = $.cls("Knows", [], "", [["leads", () => false], ["crosses", () => false], ["time", () => false]], true, true, ($c) => { Knows = $c; });
of_range = $.def(function (percent) { let times;
if (!$.t($.ge(percent, 100.0))) {return ("" + $.f(percent, ("" + ".2g"), -1) + " % of");}
times = $.b.float(("" + $.f($.div(percent, 100.0), ("" + ".2g"), -1)));
return ($.t((($t0, $t1) => $.t($.le(10.0, times)) && $.t($.lt(times, 1000000.0)))()) ? ("" + $.f(times, ("" + ".0f"), -1) + " times") : ("" + $.f(times, ("" + ".2g"), -1) + " times")); }, {p: ["percent"], ks: false});
about_data = $.def(function* (data, loop, change, doubt, knows, span) { let cure, lacking, all_of_it, sizes, masked;
if ($.t($.eq($.ga(loop, "orientation"), "clockwise"))) {cure = ($.t($.ga(knows, "leads")) ? "" : " Identify with --family stop or auto.");
(yield Finding("clockwise", ("" + "the loop runs clockwise (" + $.f($.ga(loop, "width_percent"), ("" + ".0f"), -1) + " % of the output's range wide): the output leads the input, as force against displacement does. A Prandtl-Ishlinskii model with non-negative weights lags and cannot show it; the stop form can. If this is an actuator's response, check that input and output are not swapped." + $.f(cure, "", -1))));}
if (($.t($.eq($.ga(loop, "orientation"), "mixed")) && !$.t($.ga(knows, "crosses")))) {(yield Finding("mixed-loop", "the loop runs clockwise over one part of the input and counter-clockwise over another. No Prandtl-Ishlinskii model does that; look at the loop in the report, and for a second moving part, a lagging sensor, or swapped columns."));}
if (($.t($.ge($.or($.ga(loop, "rate_dependence_percent"), () => 0.0), $.mul(100.0, RATE_SIZE))) && !$.t($.ga(knows, "time")))) {lacking = loop.lacking(...$.it(span));
(yield Finding("rate-dependent", $.add(("" + $.f($.cm(" and ", "join", [$.ga(loop, "depends")]), "", -1) + ", on blocks held out: damping, creep, or a lagging sensor, which no rate-independent model can follow. Take a family that knows them (--family auto looks for one), identify at the speed of use, or align the delay of a sensor."), ($.t(lacking) ? ("" + " " + $.f($.cm($.gi(lacking, 0), "upper", []), "", -1) + $.f($.gi(lacking, $.slice(1, null, null)), "", -1) + ".") : ""))));}
if (($.t($.gt(change, $.mul(DRIFT_SIZE, $.ga(data, "output_range")))) && $.t($.gt(change, $.mul(DRIFT_CERTAINTY, doubt))))) {(yield Finding("drift", ("" + "the output drifts by " + $.f($.b.abs($.ga(loop, "drift_percent")), ("" + ".1f"), -1) + " % of its range from the first to the last cycle at the same input: warming, leakage or creep. The model is an average over it. Warm up before logging, or leave out the first cycles (--from).")));
if ($.t($.gt(change, $.mul(OTHER_ACTUATOR, $.ga(data, "output_range"))))) {(yield Finding("two-actuators", ("" + "the output at the same input changes by " + $.f($.b.abs($.ga(loop, "drift_percent")), ("" + ".0f"), -1) + " % of its range within the log: no single model is both what the actuator was and what it became. Look at the residual in the report, and identify the part of the log that is like the use (--from, --to).")));}}
all_of_it = $.b.all((function* () { for (const $v1 of $.it($.ga(data, "pieces"))) { let piece; piece = $v1; yield $.ge($.ga(piece, "split"), $.ga($.ga(piece, "x"), "size")); } })());
if ($.t($.eq($.ga(loop, "turns"), 0))) {(yield Finding("never-turns", ("" + "the input never turns within the training part: one branch of a loop cannot show hysteresis, and what looks like memory is made up. " + $.f(($.t(all_of_it) ? "" : "Fit all of it (--train-fraction 1), or l"), "", -1) + $.f(($.t(all_of_it) ? "L" : ""), "", -1) + "og complete loops, at least two if one is to be held out.")));} else {if ($.t($.lt($.ga(loop, "loops"), 2))) {(yield Finding("few-loops", ("" + "the training part holds " + $.f($.ga(loop, "loops"), "", -1) + " complete loop" + $.f(($.t($.eq($.ga(loop, "loops"), 1)) ? "" : "s"), "", -1) + ": one loop cannot tell hysteresis from drift or noise. Log at least three, of different size" + $.f(($.t(all_of_it) ? "" : ", or fit a larger part (--train-fraction)"), "", -1) + ".")));}}
if ($.t($.ga($.ga(loop, "motion"), "one_size"))) {sizes = $.b.dict.fromkeys((function* () { for (const $v2 of $.it($.tup($.ga($.ga(loop, "motion"), "smallest"), $.ga($.ga(loop, "motion"), "largest")))) { let size; size = $v2; yield ("" + $.f(size, ("" + ".0f"), -1)); } })());
(yield Finding("one-loop-size", ("" + "all " + $.f($.ga(loop, "loops"), "", -1) + " loops are of one size (" + $.f($.cm(" to ", "join", [sizes]), "", -1) + " % of the input's range): smaller ones were neither fitted nor tested, and what the model says of them follows from the shape of one branch. Where the input will turn within its range, log loops of other sizes; `dehyst design --range " + $.f($.gi(span, 0), ("" + ".3g"), -1) + " " + $.f($.gi(span, 1), ("" + ".3g"), -1) + "` plans them, with holds that show creep.")));}
masked = $.b.sum((function* () { for (const $v3 of $.it($.ga(data, "pieces"))) { let piece; piece = $v3; if ($.t($.ga(piece, "after_break"))) { yield $.b.int($.ga(piece, "known")); } } })());
if ($.t(masked)) {(yield Finding("unknown-memory", ("" + $.f(masked, "", -1) + " samples after gaps do not count: until both extremes were visited again, of the range or of the piece, the output depends on what happened within the gap. Log without gaps, or begin each piece with a full loop.")));} }, {p: ["data", "loop", "change", "doubt", "knows", "span"], ks: false});
about_fit = $.def(function* (data, measured, certificate, paper, asked_test, knows, turns) { let records, first, unit, pairs, held_out, covered, apart, error, bar, slope, gain, misses, percent;
records = $.ga(measured, "recordings");
first = $.gi(records, 0);
(yield* $.it(_levels(data, $.ga(certificate, "initial_state"))));
if ($.t($.ga(certificate, "undetermined"))) {unit = ($.t($.ga(first, "input_unit")) ? ("" + " " + $.f($.ga(first, "input_unit"), "", -1)) : "");
(yield Finding("undetermined-operators", ("" + $.f($.b.len($.ga(certificate, "undetermined")), "", -1) + " of " + $.f($.ga(certificate, "operators"), "", -1) + " operators never moved in the training part (thresholds from " + $.f($.gi($.ga(certificate, "undetermined"), 0), ("" + ".4g"), -1) + $.f(unit, "", -1) + " on): their weights are unknown and left zero. Sweep the input further than that, or give fewer thresholds.")));}
if ($.t($.gt($.ga(measured, "beyond"), BEYOND))) {(yield Finding("extrapolation", ("" + "the held-out input leaves the range that was fitted by " + $.f($.mul(100, $.ga(measured, "beyond")), ("" + ".0f"), -1) + " %: the test measures extrapolation there. Fit a part that covers the whole range (--train-fraction, --from, --to).")));}
if ($.t(($.ga(measured, "test") != null))) {pairs = $.k($.b.zip, [records, $.ga(measured, "test_masks")], {"strict": true});
held_out = np.concatenate((() => { const $r = []; for (const $v4 of $.it(pairs)) { let record, mask; {const $v5 = $.unpack($v4, 2, -1);record = $v5[0];mask = $v5[1];} $r.push($.gi($.ga(record, "input"), mask)); } return $r; })());
covered = $.div($.b.float(np.ptp(held_out)), $.mul(2.0, $.ga(data, "half_range")));
if ($.t($.lt(covered, SMALL_TEST))) {(yield Finding("small-test", ("" + "the " + $.f($.ga(held_out, "size"), "", -1) + " samples held out cover " + $.f($.mul(100, covered), ("" + ".2g"), -1) + " % of the input's range: no loop, so the error on them says little. Log more, without gaps, or fit a smaller part (--train-fraction).")));}}
apart = $.div($.ga(measured, "levels_apart"), $.ga(data, "output_range"));
if ($.t($.gt(apart, LEVELS_APART))) {(yield Finding("recordings-differ", ("" + "the outputs of the recordings lie up to " + $.f($.mul(100, apart), ("" + ".0f"), -1) + " % of range apart at the same input: their sensors have different zeros, or the actuator was in another condition. One model averages over that. Align the zeros, or identify each recording by itself.")));}
error = $.ga($.or($.ga(measured, "test"), () => $.ga(measured, "train")), "rmse");
bar = $.ga($.or($.ga(measured, "static_test"), () => $.ga(measured, "static_train")), "rmse");
if (($.t(turns) && $.t($.ga(certificate, "operators")) && $.t($.gt(error, $.mul(STATIC_AS_GOOD, bar))))) {(yield Finding("static-as-good", ("" + "a curve without hysteresis is as good: it misses by " + $.f($.div($.mul(100, bar), $.ga(data, "output_range")), ("" + ".2f"), -1) + " % of range, the model by " + $.f($.div($.mul(100, error), $.ga(data, "output_range")), ("" + ".2f"), -1) + " %. Either there is no hysteresis at this scale, or the loop is of a kind this model cannot show. Use the curve (--family static), or look at the loop in the report.")));}
slope = $.div($.ga(data, "amplitude"), $.ga(data, "half_range"));
if ($.t($.gt($.ga(certificate, "strain"), AFFORDABLE))) {(yield _bound_of_paper(first, slope, $.ga(certificate, "strain")));}
gain = $.mul($.ga(certificate, "inverse_gain"), slope);
misses = $.gt($.ga(certificate, "inverse_miss_percent"), INVERSE_MISSES);
if (($.t(np.isfinite(gain)) && $.t(is_high(gain)) && !$.t(misses))) {(yield Finding("high-inverse-gain", ("" + "right after a reversal the inverse may amplify by " + $.f($.ga(certificate, "inverse_gain"), ("" + ".4g"), -1) + " (" + $.f(gain, ("" + ".0f"), -1) + " times the ratio of the ranges): noise on its input becomes steps of its output. " + $.f(($.t(paper) ? _of_units(slope) : ""), "", -1) + $.f(($.t($.ga(knows, "crosses")) ? ROW_GAIN : _cure_of_gain(certificate)), "", -1))));}
if (($.t(np.isfinite(gain)) && $.t($.gt(gain, USELESS_GAIN)) && !$.t(misses))) {(yield Finding("inverse-useless", ("" + "a change of the wanted output by 0.01 % of its range may ask for " + $.f($.mul(0.01, gain), ("" + ".0f"), -1) + " % of the input's: the inverse turns any noise into full strokes. Do not compensate with this model; raise --eps, and see the other warnings for the reason.")));}
if ($.t(misses)) {(yield Finding("inverse-misses", ("" + "to reach the measured output the inverse asks for an input that is off by " + $.f(of_range($.ga(certificate, "inverse_miss_percent")), "", -1) + " the input's range (rms): a compensator would drive the actuator astray. Use the model for simulation only; see the other warnings for the reason.")));}
percent = $.div($.mul(100.0, error), $.ga(data, "output_range"));
if ($.t($.gt(percent, POOR_PERCENT))) {(yield Finding("poor-fit", ("" + "the model misses by " + $.f(percent, ("" + ".1f"), -1) + " % of the output's range: too much for compensation. See the other warnings for the reason.")));}
if (($.t(($.ga(measured, "test") == null)) && $.t(asked_test))) {(yield no_held_out());} }, {p: ["data", "measured", "certificate", "paper", "asked_test", "knows", "turns"], ks: false});
_levels = $.def(function* (data, start) { let pieces, fitted, held_out, count;
pieces = (() => { const $r = []; for (const $v6 of $.it($.ga(data, "pieces"))) { let piece; piece = $v6; if ($.t(piece.unknown_level(start))) { $r.push(piece); } } return $r; })();
{const $v11 = $.unpack((function* () { for (const $v8 of $.it($.tup((function* () { for (const $v9 of $.it(pieces)) { let piece; piece = $v9; yield piece.fitted(start); } })(), (function* () { for (const $v10 of $.it(pieces)) { let piece; piece = $v10; yield piece.held_out(start); } })()))) { let spans; spans = $v8; yield $.b.sum((function* () { for (const $v7 of $.it(spans)) { let span; span = $v7; yield $.b.max($.sub($.ga(span, "stop"), $.ga(span, "start")), 0); } })()); } })(), 2, -1);fitted = $v11[0];held_out = $v11[1];}
if ($.t($.add(fitted, held_out))) {count = ($.t($.eq($.b.len(pieces), 1)) ? "a piece after a gap goes" : ("" + $.f($.b.len(pieces), "", -1) + " pieces after gaps go"));
(yield Finding("unknown-level", ("" + $.f(count, "", -1) + " over the whole range of the input late or never: what the actuator remembers of wider loops is unknown there and shifts the output by a constant. " + $.f(fitted, "", -1) + " fitted and " + $.f(held_out, "", -1) + " held-out samples count with one for each piece, no larger than the memory of the model can explain; a shifted zero may hide in it. Log without gaps, or begin each piece with a full loop.")));} }, {p: ["data", "start"], ks: false});
late = $.def(function (time, unit, percent, used) { let size, shifted, cure;
size = (($.t($.eq(unit, "s")) && $.t($.lt($.b.abs(time), 1.0))) ? ("" + $.f($.mul(1000.0, $.b.abs(time)), ("" + ".2g"), -1) + " ms") : ("" + $.f($.b.abs(time), ("" + ".2g"), -1) + " " + $.f(unit, "", -1)));
shifted = ("" + "with it shifted by that the model misses blocks left out by " + $.f($.gi(percent, 1), ("" + ".2g"), -1) + " % of range, as logged by " + $.f($.gi(percent, 0), ("" + ".2g"), -1) + " %");
if ($.t($.lt(time, 0.0))) {return Finding("output-early", ("" + "the output column is about " + $.f(size, "", -1) + " early: " + $.f(shifted, "", -1) + ". No actuator answers before it is asked, so the input was logged late, by a filter, a bus or another clock. Log both by one clock and unfiltered, or move the input column ahead by that time and identify again."));}
cure = ($.t(used) ? "The model knows it; its inverse says which input belongs to an output: give it the reference that much ahead." : "If the logging does it, log both by one clock and unfiltered, or move the column. If the actuator does, --for simulate takes it into the model; a compensator makes up for it only with a reference known ahead.");
return Finding("output-late", ("" + "the output column is about " + $.f(size, "", -1) + " late: " + $.f(shifted, "", -1) + ". It is a dead time (transport, a bus, two clocks), or a lag of a sensor or a filter. " + $.f(cure, "", -1))); }, {p: ["time", "unit", "percent", "used"], ks: false});
plays_only = $.def(function (cause, cure) { 
return Finding("plays-only", ("" + "auto chose among plays and the curve only, as " + $.f(cause, "", -1) + ": models with creep, rate or maps, which often err less, were not tried. " + $.f(cure, "", -1) + ".")); }, {p: ["cause", "cure"], ks: false});
no_hysteresis = $.def(function (candidates) { let curve, best;
curve = $.b.next((function* () { for (const $v12 of $.it(candidates)) { let each; each = $v12; if ($.t($.eq($.ga(each, "family"), STATIC))) { yield each; } } })());
best = $.k($.b.min, [(function* () { for (const $v13 of $.it(candidates)) { let each; each = $v13; if ($.t($.ne($.ga(each, "family"), STATIC))) { yield each; } } })()], {"key": $.def((each) => {  return $.ga(each, "error_percent"); }, {p: ["each"], ks: false})});
return Finding("no-hysteresis", ("" + "on loops held out within the fitted part a curve without memory misses by " + $.f($.ga(curve, "error_percent"), ("" + ".2f"), -1) + " % of range, the best model with memory (" + $.f($.ga(best, "family"), "", -1) + ") by " + $.f($.ga(best, "error_percent"), ("" + ".2f"), -1) + " %: hysteresis was not found at this scale, or does not repeat, so the model is the curve. If the loop in the report is open, log more of it, warmed up and under one load (`dehyst design` plans the motion), or insist with --family " + $.f($.ga(best, "family"), "", -1) + ".")); }, {p: ["candidates"], ks: false});
no_held_out = $.def(function () { 
return Finding("no-held-out", "no sample of the part that was held out counts, since its memory is unknown, so the errors are those of the fit itself and flatter it. Log without gaps, or fit another part (--train-fraction)."); }, {p: [], ks: false});
_bound_of_paper = $.def(function (first, slope, strain) { let unit;
unit = (($.t($.ga(first, "output_unit")) && $.t($.ga(first, "input_unit"))) ? ("" + " " + $.f($.ga(first, "output_unit"), "", -1) + "/" + $.f($.ga(first, "input_unit"), "", -1)) : "");
return Finding("paper-bound", ("" + "the paper's bound w_1 >= 0.001" + $.f(unit, "", -1) + " is " + $.f(of_range($.div($.mul(100, PAPER_EPS), slope)), "", -1) + " the mean slope of this log, " + $.f(slope, ("" + ".3g"), -1) + $.f(unit, "", -1) + ", and makes the error of the fit " + $.f($.add(1.0, strain), ("" + ".3g"), -1) + " times as large as a bound of a thousandth of that slope does: it is absolute, so the model depends on the units. Identify with --eps auto, which is relative, or with --eps " + $.f($.mul(0.001, slope), ("" + ".1g"), -1) + ".")); }, {p: ["first", "slope", "strain"], ks: false});
_of_units = $.def(function (slope) { 
return ("" + "The paper's bound w_1 >= 0.001 is absolute; in the units of this log it is " + $.f(of_range($.div($.mul(100, PAPER_EPS), slope)), "", -1) + " the mean slope. "); }, {p: ["slope"], ks: false});
_cure_of_gain = $.def(function (certificate) { 
if ($.t(($.ga(certificate, "affordable_eps") != null))) {return ("" + "Identify with --eps " + $.f($.ga(certificate, "affordable_eps"), ("" + ".3g"), -1) + ", or --eps auto: it costs less than 5 % of the accuracy of the fit.");}
if ($.t(($.ga(certificate, "enough_eps") != null))) {return ("" + "--eps " + $.f($.ga(certificate, "enough_eps"), ("" + ".3g"), -1) + " would keep it below " + $.f(HIGH_GAIN, ("" + "g"), -1) + " times, but raises the error of the fit by " + $.f($.mul(100, $.ga(certificate, "enough_eps_cost")), ("" + ".0f"), -1) + " %: take it where you can accept that, or smooth the reference.");}
return "No eps lowers it, the loop is as flat as that somewhere: stay clear of its flat end, or smooth the reference."; }, {p: ["certificate"], ks: false});
Object.assign($m, {"annotations": annotations, "Iterator": Iterator, "dataclass": dataclass, "np": np, "Recording": Recording, "Finding": Finding, "DataSet": DataSet, "HIGH_GAIN": HIGH_GAIN, "STATIC": STATIC, "is_high": is_high, "Candidate": Candidate, "Certificate": Certificate, "LoopFacts": LoopFacts, "Measured": Measured, "AFFORDABLE": AFFORDABLE, "STATIC_AS_GOOD": STATIC_AS_GOOD, "PAPER_EPS": PAPER_EPS, "RATE_SIZE": RATE_SIZE, "DRIFT_SIZE": DRIFT_SIZE, "DRIFT_CERTAINTY": DRIFT_CERTAINTY, "BEYOND": BEYOND, "USELESS_GAIN": USELESS_GAIN, "OTHER_ACTUATOR": OTHER_ACTUATOR, "POOR_PERCENT": POOR_PERCENT, "ROW_GAIN": ROW_GAIN, "INVERSE_MISSES": INVERSE_MISSES, "LEVELS_APART": LEVELS_APART, "SMALL_TEST": SMALL_TEST, "Knows": Knows, "of_range": of_range, "about_data": about_data, "about_fit": about_fit, "_levels": _levels, "late": late, "plays_only": plays_only, "no_hysteresis": no_hysteresis, "no_held_out": no_held_out, "_bound_of_paper": _bound_of_paper, "_of_units": _of_units, "_cure_of_gain": _cure_of_gain});
});
$.module("dehyst.identification.certify", ($m) => {
let annotations, _datetime, fields, replace, Any, NamedTuple, rank, Finding, facts, Knows, about_data, about_fit, no_hysteresis, of_range, DataSet, range_over, STATIC, Estimate, build_model, Candidate, Certificate, Fit, LoopFacts, Refitting, Score, size_of, Bank, settled, Measure, Measured, Choice, Firmness, output_knots, PAPER_EPS, tested_on, curve_of, fit_static, ModelCard, SignalCard, StaticCurve, __version__, GOOD_PERCENT, SERIOUS, FEW_LOOPS, UNUSABLE, HARMFUL, _examine, verdict_of, reasons_of, Seen, seen_in, certify, fit_of, _is_papers, _card;
_datetime = $.imp("datetime");
fields = $.from("dataclasses", "fields");replace = $.from("dataclasses", "replace");
Any = $.from("typing", "Any");NamedTuple = $.from("typing", "NamedTuple");
rank = $.from("dehyst.arrays", "rank");
Finding = $.from("dehyst.findings", "Finding");
facts = $.from("dehyst.identification", "facts");
Knows = $.from("dehyst.identification.cautions", "Knows");about_data = $.from("dehyst.identification.cautions", "about_data");about_fit = $.from("dehyst.identification.cautions", "about_fit");no_hysteresis = $.from("dehyst.identification.cautions", "no_hysteresis");of_range = $.from("dehyst.identification.cautions", "of_range");
DataSet = $.from("dehyst.identification.data", "DataSet");range_over = $.from("dehyst.identification.data", "range_over");
STATIC = $.from("dehyst.identification.families", "STATIC");Estimate = $.from("dehyst.identification.families", "Estimate");build_model = $.from("dehyst.identification.families", "build_model");
Candidate = $.from("dehyst.identification.fit", "Candidate");Certificate = $.from("dehyst.identification.fit", "Certificate");Fit = $.from("dehyst.identification.fit", "Fit");LoopFacts = $.from("dehyst.identification.fit", "LoopFacts");Refitting = $.from("dehyst.identification.fit", "Refitting");Score = $.from("dehyst.identification.fit", "Score");size_of = $.from("dehyst.identification.fit", "size_of");
Bank = $.from("dehyst.identification.regressors", "Bank");settled = $.from("dehyst.identification.regressors", "settled");
Measure = $.from("dehyst.identification.scores", "Measure");Measured = $.from("dehyst.identification.scores", "Measured");
Choice = $.from("dehyst.identification.selection", "Choice");Firmness = $.from("dehyst.identification.selection", "Firmness");output_knots = $.from("dehyst.identification.selection", "output_knots");
PAPER_EPS = $.from("dehyst.identification.settings", "PAPER_EPS");
tested_on = $.from("dehyst.identification.split", "tested_on");
curve_of = $.from("dehyst.identification.static_curve", "curve_of");fit_static = $.from("dehyst.identification.static_curve", "fit_static");
ModelCard = $.from("dehyst.models.card", "ModelCard");SignalCard = $.from("dehyst.models.card", "SignalCard");StaticCurve = $.from("dehyst.models.monotone", "StaticCurve");
__version__ = $.from("dehyst.version", "__version__");
GOOD_PERCENT = 3.0;
SERIOUS = $.b.set(["rate-dependent", "drift", "mixed-loop", "few-loops", "small-test", "high-inverse-gain", "paper-bound", "recordings-differ", "swapped-columns", "output-stopped", "forward-better", "schedule-once"]);
FEW_LOOPS = $.b.set(["few-loops", "never-turns"]);
UNUSABLE = $.b.set(["poor-fit", "static-as-good", "inverse-misses", "never-turns", "inverse-useless", "two-actuators"]);
HARMFUL = $.b.set(["never-turns", "inverse-useless", "two-actuators"]);
_examine = $.def(function (data, seen, measured, certificate, knows, settings) { let change, doubt, loops, turns, loop_facts, held_out, judged, said, read, unique;
{const $v1 = $.unpack($.ga(measured, "drift"), 2, -1);change = $v1[0];doubt = $v1[1];}
{const $v2 = $.unpack($.ga(seen, "counts"), 2, -1);loops = $v2[0];turns = $v2[1];}
loop_facts = $.k(LoopFacts, [], {"orientation": $.ga($.ga(seen, "loop"), "name"), "trend": $.ga(data, "trend"), "width_percent": $.mul(100.0, $.ga($.ga(seen, "loop"), "width")), "loops": loops, "turns": turns, "drift_percent": $.div($.mul((-100.0), change), $.ga(data, "output_range")), "motion": $.ga(seen, "motion"), "evidence": $.ga(measured, "evidence")});
held_out = $.lt($.gi(settings, "train_fraction"), 1.0);
judged = [...$.it(about_data(data, loop_facts, $.b.abs(change), doubt, knows, range_over((() => { const $r = []; for (const $v3 of $.it($.ga(measured, "recordings"))) { let record; record = $v3; $r.push($.ga(record, "input")); } return $r; })()))), ...$.it(about_fit(data, measured, certificate, _is_papers(settings), held_out, knows, turns))];
said = ($.t($.band($.b.set((() => { const $r = []; for (const $v4 of $.it(judged)) { let finding; finding = $v4; $r.push($.ga(finding, "code")); } return $r; })()), FEW_LOOPS)) ? FEW_LOOPS : $.b.set());
read = (() => { const $r = []; for (const $v6 of $.it($.ga(measured, "recordings"))) { let record; record = $v6; for (const $v5 of $.it($.ga(record, "findings"))) { let finding; finding = $v5; if ($.t(!$.in($.ga(finding, "code"), said))) { $r.push(finding); } } } return $r; })();
unique = $.dict((() => { const $r = []; for (const $v7 of $.it([...$.it(read), ...$.it(judged)])) { let finding; finding = $v7; $r.push([$.tup($.ga(finding, "code"), $.ga(finding, "message")), finding]); } return $r; })());
return $.tup(loop_facts, $.b.tuple($.cm(unique, "values", []))); }, {p: ["data", "seen", "measured", "certificate", "knows", "settings"], ks: false});
verdict_of = $.def(function (name, measured, findings, tested, no_inverse = "") { let test, codes, judged, static_, where, inverse, curve, against, grade, reasons, gives;
{const $v9 = $.unpack($.tup($.ga(measured, "test"), $.b.set((() => { const $r = []; for (const $v8 of $.it(findings)) { let finding; finding = $v8; $r.push($.ga(finding, "code")); } return $r; })())), 2, -1);test = $v9[0];codes = $v9[1];}
{const $v10 = $.unpack($.tup($.or(test, () => $.ga(measured, "train")), $.or($.ga(measured, "static_test"), () => $.ga(measured, "static_train"))), 2, -1);judged = $v10[0];static_ = $v10[1];}
where = ($.t((test != null)) ? ("" + "on " + $.f(tested, "", -1)) : "on the fitted samples (none held out)");
{const $v11 = $.unpack($.tup($.ga($.ga(measured, "input_error"), "rms_percent"), $.ga($.ga(measured, "curve_input"), "rms_percent")), 2, -1);inverse = $v11[0];curve = $v11[1];}
against = $.b.sorted($.band(codes, $.bor(SERIOUS, UNUSABLE)));
if ($.t($.gt(inverse, GOOD_PERCENT))) {$.cm(against, "append", [("" + "its inverse misses by more than " + $.f(GOOD_PERCENT, ("" + "g"), -1) + " %")]);} else {if ($.t($.gt(rank(inverse), rank(curve)))) {$.cm(against, "append", [("" + "the inverse of a curve without hysteresis misses less, " + $.f(of_range(curve), "", -1) + " range")]);}}
if (($.t($.band(codes, HARMFUL)) || ($.t($.band(codes, UNUSABLE)) && $.t($.gt(inverse, GOOD_PERCENT))))) {grade = ("" + "do not compensate with it (" + $.f($.cm(", ", "join", [$.b.sorted($.band(codes, UNUSABLE))]), "", -1) + ")");} else {if (($.t($.le($.ga(judged, "rmse_percent"), GOOD_PERCENT)) && $.t((test != null)) && !$.t(against))) {grade = "good for compensation";} else {reasons = reasons_of(judged, (test != null), against);
grade = $.add("usable with care", ($.t(reasons) ? ("" + " (" + $.f(reasons, "", -1) + ")") : ""));}}
if ($.t(no_inverse)) {return ("" + $.f(name, "", -1) + ": " + $.f($.ga(judged, "rmse_percent"), ("" + ".2f"), -1) + " % of range rms " + $.f(where, "", -1) + ", against " + $.f($.ga(static_, "rmse_percent"), ("" + ".2f"), -1) + " % for the best curve without hysteresis: simulate with it, do not compensate with it. It has no inverse: " + $.f($.cm(no_inverse, "rstrip", ["."]), "", -1) + ".");}
gives = ("" + "gives the applied input back to " + $.f(of_range(inverse), "", -1) + " its range");
if ($.t($.eq(name, STATIC))) {return $.add($.add(("" + "static, a curve without memory: " + $.f($.ga(judged, "rmse_percent"), ("" + ".2f"), -1) + " % of range rms " + $.f(where, "", -1) + "; its inverse " + $.f(gives, "", -1)), ($.t($.in("no-hysteresis", codes)) ? "; hysteresis was not found, or does not repeat" : "")), ("" + ": " + $.f(grade, "", -1) + "."));}
return ("" + $.f(name, "", -1) + ": " + $.f($.ga(judged, "rmse_percent"), ("" + ".2f"), -1) + " % of range rms " + $.f(where, "", -1) + ", against " + $.f($.ga(static_, "rmse_percent"), ("" + ".2f"), -1) + " % for the best curve without hysteresis; the inverse " + $.f(gives, "", -1) + ": " + $.f(grade, "", -1) + "."); }, {p: ["name", "measured", "findings", "tested", "no_inverse"], ks: false});
reasons_of = $.def(function (judged, held_out, serious) { let error;
error = ($.t($.le($.ga(judged, "rmse_percent"), GOOD_PERCENT)) ? [] : [("" + "its output errs by more than " + $.f(GOOD_PERCENT, ("" + "g"), -1) + " %")]);
return $.cm(", ", "join", [[...$.it(serious), ...$.it(error), ...$.it(($.t(held_out) ? [] : ["nothing held out"]))]]); }, {p: ["judged", "held_out", "serious"], ks: false});
Seen = $.cls("Seen", [], "NamedTuple", [["loop", null], ["counts", null], ["motion", null]], false, true, ($c) => { Seen = $c; });
seen_in = $.def(function (found) { 
return Seen(facts.orientation(found), facts.count_loops(found), facts.motion(found)); }, {p: ["found"], ks: false});
certify = $.def(function (data, operators, choice, bank, estimate, firm, candidates, seen, settings, measure, refitter) { let static_, knots, model, measured, certificate, knows, name;
static_ = curve_of($.gi(fit_static(data, $.ga(choice, "initial_state")), 0), data);
knots = ($.t($.eq($.ga(choice, "family"), "modified-pi")) ? output_knots() : null);
model = ($.t($.eq($.ga(choice, "family"), STATIC)) ? curve_of(estimate, data) : build_model(estimate, data, bank, knots, ModelCard()));
measured = measure(data, settled(data, bank, model), model, static_, $.gi($.ga(seen, "counts"), 1));
certificate = $.k(Certificate, [], {"kkt_residual": $.ga(estimate, "kkt_residual"), "round_trip_error": $.ga(measured, "round_trip"), "inverse_gain": $.ga(model, "inverse_gain"), "inverse_miss_percent": $.ga($.ga(measured, "input_error"), "rms_percent"), "affordable_eps": $.ga(firm, "affordable"), "enough_eps": $.ga(firm, "enough"), "enough_eps_cost": $.ga(firm, "cost"), "strain": ($.t(_is_papers(settings)) ? $.ga(firm, "strain") : 0.0), "nonzero_weights": $.ga(model, "nonzero_weights"), "operators": operators, "undetermined": $.b.tuple((function* () { for (const $v12 of $.it($.mul($.ga(bank, "undetermined"), $.ga(data, "half_range")))) { let r; r = $v12; yield $.b.float(r); } })()), "initial_state": $.ga(choice, "initial_state"), "route": $.ga(estimate, "route"), "condition": $.ga(estimate, "condition")});
knows = $.k(Knows, [], {"leads": $.in($.ga(choice, "family"), $.tup("stop", "pi-cumulative"))});
name = ($.t(operators) ? ("" + $.f($.ga(choice, "family"), "", -1) + ", " + $.f(size_of(model, $.ga(model, "nonzero_weights"), operators), "", -1)) : STATIC);
return fit_of(model, $.ga(choice, "family"), name, knows, data, seen, static_, measured, certificate, settings, candidates, refitter); }, {p: ["data", "operators", "choice", "bank", "estimate", "firm", "candidates", "seen", "settings", "measure", "refitter"], ks: false});
fit_of = $.def(function (model, family, name, knows, data, seen, static_, measured, certificate, settings, candidates, refitter = null, no_inverse = "", more = $.tup()) { let loop_facts, findings, verdict, card, own;
{const $v13 = $.unpack(_examine(data, seen, measured, certificate, knows, settings), 2, -1);loop_facts = $v13[0];findings = $v13[1];}
if (($.t($.eq(family, STATIC)) && $.t(candidates))) {more = $.tup(...$.it(more), no_hysteresis(candidates));}
findings = $.tup(...$.it(findings), ...$.it(more));
verdict = verdict_of(name, measured, findings, tested_on(settings), no_inverse);
card = _card(measured, settings, family, $.ga(certificate, "initial_state"), verdict);
own = $.ga(model, "card");
return $.k(Fit, [], {"family": family, "model": model.with_card(($.t(($.ga($.ga(own, "output"), "low") == null)) ? card : $.k(replace, [own], {"provenance": $.ga(card, "provenance")}))), ...$.obj($.dict((() => { const $r = []; for (const $v14 of $.it(fields(Fit))) { let one; one = $v14; if ($.t($.b.hasattr(measured, $.ga(one, "name")))) { $r.push([$.ga(one, "name"), $.b.getattr(measured, $.ga(one, "name"))]); } } return $r; })())), "static": StaticCurve($.ga(static_, "curve"), card), "certificate": certificate, "facts": loop_facts, "candidates": candidates, "warnings": findings, "settings": settings, "verdict": verdict, "refitter": refitter}); }, {p: ["model", "family", "name", "knows", "data", "seen", "static", "measured", "certificate", "settings", "candidates", "refitter", "no_inverse", "more"], ks: false});
_is_papers = $.def(function (settings) { 
return $.b.bool($.and($.eq($.gi(settings, "family"), "pi"), () => $.eq($.gi(settings, "eps"), PAPER_EPS))); }, {p: ["settings"], ks: false});
_card = $.def(function (measured, settings, family, start, verdict) { let records, low_in, high_in, low_out, high_out, provenance;
records = $.ga(measured, "recordings");
{const $v16 = $.unpack(range_over((() => { const $r = []; for (const $v15 of $.it(records)) { let record; record = $v15; $r.push($.ga(record, "input")); } return $r; })()), 2, -1);low_in = $v16[0];high_in = $v16[1];}
{const $v18 = $.unpack(range_over((() => { const $r = []; for (const $v17 of $.it(records)) { let record; record = $v17; $r.push($.ga(record, "output")); } return $r; })()), 2, -1);low_out = $v18[0];high_out = $v18[1];}
provenance = $.dict([["logs", (() => { const $r = []; for (const $v19 of $.it(records)) { let record; record = $v19; $r.push($.bor($.b.dict($.ga(record, "provenance")), $.dict([["name", $.ga(record, "name")], ["samples", $.ga(record, "samples")]]))); } return $r; })()], ["date", $.km($.ga(_datetime, "datetime").now($.ga(_datetime, "UTC")), "isoformat", [], {"timespec": "seconds"})], ["dehyst", __version__], ["settings", $.b.dict(settings)], ["identified_family", family], ["initial_state", start], ["train", $.ga(measured, "train").as_dict()], ["test", ($.t(($.ga(measured, "test") == null)) ? null : $.ga(measured, "test").as_dict())], ["verdict", verdict]]);
return ModelCard(SignalCard($.ga($.gi(records, 0), "input_name"), $.ga($.gi(records, 0), "input_unit"), low_in, high_in), SignalCard($.ga($.gi(records, 0), "output_name"), $.ga($.gi(records, 0), "output_unit"), low_out, high_out), provenance); }, {p: ["measured", "settings", "family", "start", "verdict"], ks: false});
Object.assign($m, {"annotations": annotations, "_datetime": _datetime, "fields": fields, "replace": replace, "Any": Any, "NamedTuple": NamedTuple, "rank": rank, "Finding": Finding, "facts": facts, "Knows": Knows, "about_data": about_data, "about_fit": about_fit, "no_hysteresis": no_hysteresis, "of_range": of_range, "DataSet": DataSet, "range_over": range_over, "STATIC": STATIC, "Estimate": Estimate, "build_model": build_model, "Candidate": Candidate, "Certificate": Certificate, "Fit": Fit, "LoopFacts": LoopFacts, "Refitting": Refitting, "Score": Score, "size_of": size_of, "Bank": Bank, "settled": settled, "Measure": Measure, "Measured": Measured, "Choice": Choice, "Firmness": Firmness, "output_knots": output_knots, "PAPER_EPS": PAPER_EPS, "tested_on": tested_on, "curve_of": curve_of, "fit_static": fit_static, "ModelCard": ModelCard, "SignalCard": SignalCard, "StaticCurve": StaticCurve, "__version__": __version__, "GOOD_PERCENT": GOOD_PERCENT, "SERIOUS": SERIOUS, "FEW_LOOPS": FEW_LOOPS, "UNUSABLE": UNUSABLE, "HARMFUL": HARMFUL, "_examine": _examine, "verdict_of": verdict_of, "reasons_of": reasons_of, "Seen": Seen, "seen_in": seen_in, "certify": certify, "fit_of": fit_of, "_is_papers": _is_papers, "_card": _card});
});
$.module("dehyst.identification.data", ($m) => {
let annotations, itertools, math, Callable, Iterator, Sequence, dataclass, Any, Protocol, cast, overload, np, npt, Array_, robust_range, Recording, ExcitationError, ParameterError, known_within, Split, CLEAR_TREND, CHUNK, LONG, ENOUGH, RESOLVED, LEAST_SPAN, MOST_SPAN, Signal, Streamed, Piece, DataSet, chunks, extremes, prepare, counting, _counted, _refuse_weightless, range_over, range_of, _scaled, middle, require_gain, _times, _trend, clear_trend, trend_of_increments;
itertools = $.imp("itertools");
math = $.imp("math");
Callable = $.from("collections.abc", "Callable");Iterator = $.from("collections.abc", "Iterator");Sequence = $.from("collections.abc", "Sequence");
dataclass = $.from("dataclasses", "dataclass");
Any = $.from("typing", "Any");Protocol = $.from("typing", "Protocol");cast = $.from("typing", "cast");overload = $.from("typing", "overload");
np = $.imp("numpy");
npt = $.imp("numpy.typing");
Array_ = $.from("dehyst.arrays", "Array");
robust_range = $.from("dehyst.data.ranges", "robust_range");
Recording = $.from("dehyst.data.recording", "Recording");
ExcitationError = $.from("dehyst.errors", "ExcitationError");ParameterError = $.from("dehyst.errors", "ParameterError");
known_within = $.from("dehyst.identification.memory", "known_within");
Split = $.from("dehyst.identification.split", "Split");
CLEAR_TREND = 0.3;
CHUNK = $.shl(1, 15);
{const $v1 = $.unpack($.tup(200000, 50000), 2, -1);LONG = $v1[0];ENOUGH = $v1[1];}
RESOLVED = 1e-12;
{const $v2 = $.unpack($.tup(1e-95, 1e+95), 2, -1);LEAST_SPAN = $v2[0];MOST_SPAN = $v2[1];}
Signal = $.cls("Signal", [], "", [], false, true, ($c) => { Signal = $c; $.prop($c, "size", $.def(function () { const self = this;
 }, {p: [], ks: false}));});
Streamed = $.cls("Streamed", [Signal], "", [], false, true, ($c) => { Streamed = $c; $.meth($c, "extremes", $.def(function (span) { const self = this;
 }, {p: ["span"], ks: false}));});
Piece = $.cls("Piece", [], "", [["x", null], ["y", null], ["recording", null], ["start", null], ["split", null], ["known", null], ["after_break", null], ["weight", () => null], ["within", () => null]], true, true, ($c) => { Piece = $c; $.meth($c, "begins_unknown", $.def(function (initial_state) { const self = this;
return $.or($.ga(self, "after_break"), () => $.eq(initial_state, "unknown")); }, {p: ["initial_state"], ks: false}));
$.meth($c, "usable_from", $.def(function (initial_state) { const self = this;
return ($.t(self.begins_unknown(initial_state)) ? $.ga(self, "known") : 0); }, {p: ["initial_state"], ks: false}));
$.meth($c, "unknown_level", $.def(function (initial_state) { const self = this;
return ($.t(self.begins_unknown(initial_state)) ? $.ga(self, "within") : null); }, {p: ["initial_state"], ks: false}));
$.meth($c, "fitted", $.def(function (initial_state) { const self = this;let begin;
begin = self.usable_from(initial_state);
return $.b.slice(begin, $.b.max(begin, $.ga(self, "split"))); }, {p: ["initial_state"], ks: false}));
$.meth($c, "held_out", $.def(function (initial_state) { const self = this;
return $.b.slice($.b.min($.b.max(self.usable_from(initial_state), $.ga(self, "split")), $.ga($.ga(self, "x"), "size")), $.ga($.ga(self, "x"), "size")); }, {p: ["initial_state"], ks: false}));});
DataSet = $.cls("DataSet", [], "", [["pieces", null], ["center", null], ["half_range", null], ["level", null], ["amplitude", null], ["trend", null], ["output_range", null]], true, true, ($c) => { DataSet = $c; $.prop($c, "weighted", $.def(function () { const self = this;
return $.b.any((function* () { for (const $v3 of $.it($.ga(self, "pieces"))) { let piece; piece = $v3; yield ($.ga(piece, "weight") != null); } })()); }, {p: [], ks: false}));});
chunks = $.def(function* (span, size = CHUNK) { let begin;
for (const $v4 of $.it($.b.range($.ga(span, "start"), $.ga(span, "stop"), size))) { begin = $v4;
{(yield $.b.slice(begin, $.b.min($.add(begin, size), $.ga(span, "stop"))));} } }, {p: ["span", "size"], ks: false});
extremes = $.def(function (x, span) { let streamed;
if ($.t($.b.isinstance(x, $.ga(np, "ndarray")))) {return range_of($.gi(x, span));}
streamed = x;
return streamed.extremes(span); }, {p: ["x", "span"], ks: false});
prepare = $.def(function (recordings, split, weights = null) { let inputs, counted, ends, outputs, center, half, level, amplitude, trend, pieces, index, recording, end, order, span, x, y, inside, weight, known, within, whole;
weights = counting(recordings, weights);
inputs = (() => { const $r = []; for (const $v5 of $.it($.k($.b.zip, [recordings, $.ga(split, "ends")], {"strict": true}))) { let recording, k; {const $v6 = $.unpack($v5, 2, -1);recording = $v6[0];k = $v6[1];} $r.push($.gi($.ga(recording, "input"), $.slice(null, k, null))); } return $r; })();
counted = (() => { const $r = []; for (const $v7 of $.it($.b.enumerate(inputs))) { let index, x; {const $v8 = $.unpack($v7, 2, -1);index = $v8[0];x = $v8[1];} $r.push(_counted(x, weights, index)); } return $r; })();
ends = $.b.enumerate($.k($.b.zip, [recordings, $.ga(split, "ends")], {"strict": true}));
outputs = (() => { const $r = []; for (const $v9 of $.it(ends)) { let i, rec, k; {const $v10 = $.unpack($v9, 2, -1);i = $v10[0];{const $v11 = $.unpack($v10[1], 2, -1);rec = $v11[0];k = $v11[1];}} $r.push(_counted($.gi($.ga(rec, "output"), $.slice(null, k, null)), weights, i)); } return $r; })();
_refuse_weightless(outputs);
{const $v12 = $.unpack(middle($.gi(recordings, 0), range_over(inputs), "input", $.ga(split, "fitted_part")), 2, -1);center = $v12[0];half = $v12[1];}
{const $v13 = $.unpack(middle($.gi(recordings, 0), range_over(outputs), "output", $.ga(split, "fitted_part")), 2, -1);level = $v13[0];amplitude = $v13[1];}
require_gain($.gi(recordings, 0), half, amplitude);
trend = _trend(counted, outputs, $.tup(center, half), $.tup(level, amplitude));
pieces = [];
for (const $v14 of $.it($.b.enumerate($.k($.b.zip, [recordings, $.ga(split, "ends")], {"strict": true})))) { {const $v15 = $.unpack($v14, 2, -1);index = $v15[0];{const $v16 = $.unpack($v15[1], 2, -1);recording = $v16[0];end = $v16[1];}}
{for (const $v17 of $.it($.b.enumerate($.ga(recording, "pieces")))) { {const $v18 = $.unpack($v17, 2, -1);order = $v18[0];span = $v18[1];}
{x = _scaled($.gi($.ga(recording, "input"), span), center, half);
y = _scaled($.gi($.ga(recording, "output"), span), level, $.mul(trend, amplitude));
inside = $.b.min($.b.max($.sub(end, $.ga(span, "start")), 0), $.ga(x, "size"));
weight = ($.t((weights == null)) ? null : np.ascontiguousarray($.gi($.gi(weights, index), span)));
{const $v19 = $.unpack(known_within(x), 2, -1);known = $v19[0];within = $v19[1];}
$.cm(pieces, "append", [Piece(x, y, index, $.ga(span, "start"), inside, known, $.gt(order, 0), weight, within)]);} }} }
whole = robust_range((() => { const $r = []; for (const $v20 of $.it($.b.enumerate(recordings))) { let index, rec; {const $v21 = $.unpack($v20, 2, -1);index = $v21[0];rec = $v21[1];} $r.push(_counted($.ga(rec, "output"), weights, index)); } return $r; })());
return DataSet($.b.tuple(pieces), center, half, level, amplitude, trend, whole); }, {p: ["recordings", "split", "weights"], ks: false});
counting = $.def(function (recordings, weights) { let found, weight, recording;
if (!$.t($.b.any((function* () { for (const $v22 of $.it(recordings)) { let recording; recording = $v22; yield $.ga(recording, "left_out"); } })()))) {return weights;}
found = ($.t((weights == null)) ? (() => { const $r = []; for (const $v23 of $.it(recordings)) { let rec; rec = $v23; $r.push(np.ones($.b.len(rec))); } return $r; })() : (() => { const $r = []; for (const $v24 of $.it(weights)) { let weight; weight = $v24; $r.push($.cm(weight, "copy", [])); } return $r; })());
for (const $v25 of $.it($.k($.b.zip, [found, recordings], {"strict": true}))) { {const $v26 = $.unpack($v25, 2, -1);weight = $v26[0];recording = $v26[1];}
{$.si(weight, $.b.list($.ga(recording, "left_out")), 0.0);} }
return found; }, {p: ["recordings", "weights"], ks: false});
_counted = $.def(function (values, weights, index) { 
return ($.t((weights == null)) ? values : $.gi(values, $.gt($.gi($.gi(weights, index), $.slice(null, $.ga(values, "size"), null)), 0.0))); }, {p: ["values", "weights", "index"], ks: false});
_refuse_weightless = $.def(function (outputs) { 
if (!$.t($.b.any((function* () { for (const $v27 of $.it(outputs)) { let y; y = $v27; yield $.ga(y, "size"); } })()))) {throw $.exc(ParameterError("all weights of the part that is fitted are 0: no sample is left to identify from. Give some of them a weight, or fit a larger part (--train-fraction)."));} }, {p: ["outputs"], ks: false});
range_over = $.def(function (parts) { let there;
there = (() => { const $r = []; for (const $v28 of $.it(parts)) { let part; part = $v28; if ($.t($.ga(part, "size"))) { $r.push(range_of(part)); } } return $r; })();
return $.tup($.b.min((function* () { for (const $v29 of $.it(there)) { let low, _; {const $v30 = $.unpack($v29, 2, -1);low = $v30[0];_ = $v30[1];} yield low; } })()), $.b.max((function* () { for (const $v31 of $.it(there)) { let _, high; {const $v32 = $.unpack($v31, 2, -1);_ = $v32[0];high = $v32[1];} yield high; } })())); }, {p: ["parts"], ks: false});
range_of = $.def(function (values) { let low, high, part, inside;
{const $v33 = $.unpack($.tup($.ga(np, "inf"), $.neg($.ga(np, "inf"))), 2, -1);low = $v33[0];high = $v33[1];}
for (const $v34 of $.it(chunks($.b.slice(0, $.ga(values, "size"))))) { part = $v34;
{inside = $.gi(values, part);
{const $v35 = $.unpack($.tup($.b.min(low, $.b.float(inside.min())), $.b.max(high, $.b.float(inside.max()))), 2, -1);low = $v35[0];high = $v35[1];}} }
return $.tup(low, high); }, {p: ["values"], ks: false});
_scaled = $.def(function (values, origin, unit) { let scaled;
scaled = np.subtract(values, origin);
scaled = $.idiv(scaled, unit);
return scaled; }, {p: ["values", "origin", "unit"], ks: false});
middle = $.def(function (first, extremes, role, part) { let low, high, span, largest, name, moves;
{const $v36 = $.unpack(extremes, 2, -1);low = $v36[0];high = $v36[1];}
{const $v37 = $.unpack($.tup($.sub(high, low), $.b.max($.b.abs(low), $.b.abs(high))), 2, -1);span = $v37[0];largest = $v37[1];}
if (($.t($.ge(span, $.mul(RESOLVED, largest))) && $.t((($t0, $t1) => $.t($.le(LEAST_SPAN, span)) && $.t($.le(span, MOST_SPAN)))()))) {return $.tup($.add(low, $.mul(0.5, span)), $.mul(0.5, span));}
name = ($.t($.eq(role, "input")) ? $.ga(first, "input_label") : $.ga(first, "output_label"));
if ($.t($.eq(span, 0.0))) {throw $.exc($.k(ExcitationError, [("" + $.f(role, "", -1) + " '" + $.f(name, "", -1) + "' stays at " + $.f(low, ("" + "g"), -1) + $.f(part, "", -1) + ". A loop needs a signal that moves, so nothing can be identified. Check the column, choose a window in which it moves (--from, --to), or fit a larger part (--train-fraction 1).")], {"value": low}));}
moves = ("" + $.f(role, "", -1) + " '" + $.f(name, "", -1) + "' moves by " + $.f(span, ("" + ".3g"), -1) + $.f(part, "", -1));
if ($.t($.lt(span, $.mul(RESOLVED, largest)))) {throw $.exc($.k(ExcitationError, [("" + $.f(moves, "", -1) + ", on an offset of " + $.f(largest, ("" + ".3g"), -1) + ", where numbers of double precision are " + $.f(np.spacing(largest), ("" + ".2g"), -1) + " apart: too few steps to tell a loop from rounding. If it is a signal, log it without the offset; otherwise choose a column or a window in which it moves more (--from, --to).")], {"value": low, "span": span}));}
throw $.exc($.k(ExcitationError, [("" + $.f(moves, "", -1) + ", and a model of it cannot be written in double precision: its numbers must lie between " + $.f(LEAST_SPAN, ("" + "g"), -1) + " and " + $.f(MOST_SPAN, ("" + "g"), -1) + ". Log it in another unit, for example " + $.f(_times($.b.min(span, largest)), "", -1) + ".")], {"span": span})); }, {p: ["first", "extremes", "role", "part"], ks: false});
require_gain = $.def(function (first, half_range, amplitude) { 
if ($.t((($t0, $t1) => $.t($.le(LEAST_SPAN, ($t0 = $.div(amplitude, half_range)))) && $.t($.le($t0, MOST_SPAN)))())) {return null;}
throw $.exc($.k(ExcitationError, [("" + "output '" + $.f($.ga(first, "output_label"), "", -1) + "' moves by " + $.f($.mul(2, amplitude), ("" + ".3g"), -1) + " while input '" + $.f($.ga(first, "input_label"), "", -1) + "' moves by " + $.f($.mul(2, half_range), ("" + ".3g"), -1) + ": a model from one to the other cannot be written in double precision, its weights would be near " + $.f($.div(amplitude, half_range), ("" + ".0e"), -1) + ". Log the output in another unit, for example " + $.f(_times(amplitude), "", -1) + ", or the input " + $.f(_times(half_range), "", -1) + ".")], {"spans": $.tup($.mul(2, half_range), $.mul(2, amplitude))})); }, {p: ["first", "half_range", "amplitude"], ks: false});
_times = $.def(function (size) { 
return ("" + "times 1e" + $.f($.neg(math.floor(math.log10(size))), ("" + "+d"), -1)); }, {p: ["size"], ks: false});
_trend = $.def(function (inputs, outputs, x_scale, y_scale) { let moments, whole_x, whole_y, part, x, y, clear;
moments = np.zeros(6);
for (const $v38 of $.it($.k($.b.zip, [inputs, outputs], {"strict": true}))) { {const $v39 = $.unpack($v38, 2, -1);whole_x = $v39[0];whole_y = $v39[1];}
{for (const $v40 of $.it(chunks($.b.slice(0, $.ga(whole_x, "size"))))) { part = $v40;
{{const $v41 = $.unpack($.tup(_scaled($.gi(whole_x, part), ...$.it(x_scale)), _scaled($.gi(whole_y, part), ...$.it(y_scale))), 2, -1);x = $v41[0];y = $v41[1];}
moments = $.iadd(moments, np.array([$.ga(x, "size"), np.sum(x), np.sum(y), $.mm(x, x), $.mm(y, y), $.mm(x, y)]));} }} }
clear = clear_trend(moments);
if ($.t(clear)) {return clear;}
{const $v42 = $.unpack($.tup(np.concatenate(inputs), np.concatenate(outputs)), 2, -1);whole_x = $v42[0];whole_y = $v42[1];}
return trend_of_increments($.def((part) => {  return $.tup($.gi(whole_x, part), $.gi(whole_y, part)); }, {p: ["part"], ks: false}), $.ga(whole_x, "size"), $.gi(x_scale, 1)); }, {p: ["inputs", "outputs", "x_scale", "y_scale"], ks: false});
clear_trend = $.def(function (moments) { let count, x_sum, y_sum, xx, yy, xy, spread, correlation;
{const $v43 = $.unpack(moments.tolist(), 6, -1);count = $v43[0];x_sum = $v43[1];y_sum = $v43[2];xx = $v43[3];yy = $v43[4];xy = $v43[5];}
spread = $.mul($.sub(xx, $.div($.pow(x_sum, 2), count)), $.sub(yy, $.div($.pow(y_sum, 2), count)));
correlation = ($.t($.gt(spread, 0.0)) ? $.div($.sub(xy, $.div($.mul(x_sum, y_sum), count)), np.sqrt(spread)) : 0.0);
if ($.t($.lt($.b.abs(correlation), CLEAR_TREND))) {return 0;}
return ($.t($.gt(correlation, 0)) ? 1 : (-1)); }, {p: ["moments"], ks: false});
trend_of_increments = $.def(function (read, samples, half_range) { let grain, total, edges, begin, end, x, y, level, keep;
{const $v44 = $.unpack($.tup($.mul($.mul(0.02, 2.0), half_range), 0.0), 2, -1);grain = $v44[0];total = $v44[1];}
edges = ($.t($.le(samples, LONG)) ? [0, samples] : np.linspace(0, samples, 21).astype($.b.int).tolist());
for (const $v45 of $.it(itertools.pairwise(edges))) { {const $v46 = $.unpack($v45, 2, -1);begin = $v46[0];end = $v46[1];}
{{const $v47 = $.unpack(read($.b.slice(begin, ($.t($.gt($.b.len(edges), 2)) ? $.b.min(end, $.add(begin, $.fdiv(ENOUGH, 20))) : end))), 2, -1);x = $v47[0];y = $v47[1];}
level = ($.t($.gt(grain, 0)) ? np.round($.div(x, grain)) : x);
keep = np.flatnonzero($.ne($.km(np, "diff", [level], {"prepend": $.ga(np, "nan")}), 0));
total = $.iadd(total, $.b.float(np.sum($.mul(np.diff($.gi(x, keep)), np.diff($.gi(y, keep))))));} }
return ($.t($.ge(total, 0)) ? 1 : (-1)); }, {p: ["read", "samples", "half_range"], ks: false});
Object.assign($m, {"annotations": annotations, "itertools": itertools, "math": math, "Callable": Callable, "Iterator": Iterator, "Sequence": Sequence, "dataclass": dataclass, "Any": Any, "Protocol": Protocol, "cast": cast, "overload": overload, "np": np, "npt": npt, "Array": Array_, "robust_range": robust_range, "Recording": Recording, "ExcitationError": ExcitationError, "ParameterError": ParameterError, "known_within": known_within, "Split": Split, "CLEAR_TREND": CLEAR_TREND, "CHUNK": CHUNK, "LONG": LONG, "ENOUGH": ENOUGH, "RESOLVED": RESOLVED, "LEAST_SPAN": LEAST_SPAN, "MOST_SPAN": MOST_SPAN, "Signal": Signal, "Streamed": Streamed, "Piece": Piece, "DataSet": DataSet, "chunks": chunks, "extremes": extremes, "prepare": prepare, "counting": counting, "_counted": _counted, "_refuse_weightless": _refuse_weightless, "range_over": range_over, "range_of": range_of, "_scaled": _scaled, "middle": middle, "require_gain": require_gain, "_times": _times, "_trend": _trend, "clear_trend": clear_trend, "trend_of_increments": trend_of_increments});
});
$.module("dehyst.identification.evidence", ($m) => {
let annotations, itertools, Callable, Iterator, Sequence, dataclass, replace, cached_property, NamedTuple, np, npt, _native, Array_, Mask, Finding, ENOUGH, LONG, DataSet, velocity, Solution, solve_bounded, triangle, RATE, CREEP, BLOCKS, _SIGNS, LEVEL, WORTH, IMITATED, TOLD, DEGREE, RADII, LENGTHS, TIMES, STEPS, SHARE, WIDEST, RIDGE, LEAST, OTHER_SPEED, SLOWER, Evidence, Stretch, rows_of, stretches_of, evidence, permutation_p, _Block, _Way, _square, _blocks, _scaling, _columns, _cut, without_holds;
itertools = $.imp("itertools");
Callable = $.from("collections.abc", "Callable");Iterator = $.from("collections.abc", "Iterator");Sequence = $.from("collections.abc", "Sequence");
dataclass = $.from("dataclasses", "dataclass");replace = $.from("dataclasses", "replace");
cached_property = $.from("functools", "cached_property");
NamedTuple = $.from("typing", "NamedTuple");
np = $.imp("numpy");
npt = $.imp("numpy.typing");
_native = $.imp("dehyst._native");
Array_ = $.from("dehyst.arrays", "Array");Mask = $.from("dehyst.arrays", "Mask");
Finding = $.from("dehyst.findings", "Finding");
ENOUGH = $.from("dehyst.identification.data", "ENOUGH");LONG = $.from("dehyst.identification.data", "LONG");DataSet = $.from("dehyst.identification.data", "DataSet");
velocity = $.from("dehyst.identification.facts", "velocity");
Solution = $.from("dehyst.identification.least_squares", "Solution");solve_bounded = $.from("dehyst.identification.least_squares", "solve_bounded");triangle = $.from("dehyst.identification.least_squares", "triangle");
{const $v1 = $.unpack($.tup("rate", "creep"), 2, -1);RATE = $v1[0];CREEP = $v1[1];}
BLOCKS = 10;
_SIGNS = $.sub(1.0, $.mul(2.0, $.band($.shr($.gi(np.arange($.shl(1, BLOCKS)), $.tup($.slice(null, null, null), null)), np.arange(BLOCKS)), 1)));
{const $v2 = $.unpack($.tup(0.05, 0.02), 2, -1);LEVEL = $v2[0];WORTH = $v2[1];}
IMITATED = 0.04;
TOLD = 0.12;
DEGREE = 7;
{const $v3 = $.unpack($.tup(np.geomspace(0.01, 0.95, 12), np.geomspace(0.05, 1.5, 5)), 2, -1);RADII = $v3[0];LENGTHS = $v3[1];}
{const $v4 = $.unpack($.tup(6, 3.0, $.div(1.0, 3.0), 300.0), 4, -1);TIMES = $v4[0];STEPS = $v4[1];SHARE = $v4[2];WIDEST = $v4[3];}
RIDGE = 1e-06;
LEAST = 200;
OTHER_SPEED = 1.0;
SLOWER = 10.0;
Evidence = $.cls("Evidence", [], "", [["group", null], ["without_percent", null], ["with_percent", null], ["better", null], ["blocks", null], ["p", null], ["own", () => 1.0], ["apart", () => 1.0]], true, true, ($c) => { Evidence = $c; $.prop($c, "told", $.def(function () { const self = this;
return $.ge($.b.min($.ga(self, "own"), $.ga(self, "apart")), TOLD); }, {p: [], ks: false}));
$.prop($c, "there", $.def(function () { const self = this;let better;
better = $.lt($.ga(self, "with_percent"), $.mul($.sub(1.0, WORTH), $.ga(self, "without_percent")));
return $.and(better, () => $.and($.lt($.ga(self, "p"), LEVEL), () => $.ge($.ga(self, "own"), IMITATED))); }, {p: [], ks: false}));
$.prop($c, "size_percent", $.def(function () { const self = this;
return ($.t($.ga(self, "there")) ? $.b.float(np.sqrt($.sub($.pow($.ga(self, "without_percent"), 2), $.pow($.ga(self, "with_percent"), 2)))) : 0.0); }, {p: [], ks: false}));
$.meth($c, "as_dict", $.def(function () { const self = this;
return $.dict([["group", $.ga(self, "group")], ["without_percent", $.ga(self, "without_percent")], ["with_percent", $.ga(self, "with_percent")], ["better", $.ga(self, "better")], ["blocks", $.ga(self, "blocks")], ["p", $.ga(self, "p")], ["own", $.ga(self, "own")], ["apart", $.ga(self, "apart")], ["told", $.ga(self, "told")], ["there", $.ga(self, "there")]]); }, {p: [], ks: false}));
$.prop($c, "figures", $.def(function () { const self = this;let without, with_it, digits;
{const $v5 = $.unpack($.tup($.ga(self, "without_percent"), $.ga(self, "with_percent")), 2, -1);without = $v5[0];with_it = $v5[1];}
for (const $v6 of $.it($.tup(2, 3, 4))) { digits = $v6;
{if ($.t($.ne(("" + $.f(without, ("" + "." + $.f(digits, "", -1) + "f"), -1)), ("" + $.f(with_it, ("" + "." + $.f(digits, "", -1) + "f"), -1))))) {break;}} }
return ("" + $.f(without, ("" + "." + $.f(digits, "", -1) + "f"), -1) + " % of range without, " + $.f(with_it, ("" + "." + $.f(digits, "", -1) + "f"), -1) + " % with it"); }, {p: [], ks: false}));
$.prop($c, "answer", $.def(function () { const self = this;
if ($.t($.ga(self, "told"))) {return ($.t($.ga(self, "there")) ? "found" : "not found");}
if ($.t($.ga(self, "there"))) {return "found, but this log cannot tell rate and creep apart";}
return "cannot be told from hysteresis in this log"; }, {p: [], ks: false}));
$.prop($c, "words", $.def(function () { const self = this;
return ($.t($.eq($.ga(self, "group"), RATE)) ? "rate" : "time (creep)"); }, {p: [], ks: false}));
$.meth($c, "__str__", $.def(function () { const self = this;
return ("" + "dependence on " + $.f($.ga(self, "words"), "", -1) + ": " + $.f($.ga(self, "answer"), "", -1) + "; " + $.f($.ga(self, "figures"), "", -1) + " on held-out blocks, better in " + $.f($.ga(self, "better"), "", -1) + " of " + $.f($.ga(self, "blocks"), "", -1) + ", p = " + $.f($.ga(self, "p"), ("" + ".2g"), -1) + ", " + $.f($.mul(100, $.ga(self, "own")), ("" + ".0f"), -1) + " % of its effect unlike hysteresis"); }, {p: [], ks: false}));});
Stretch = $.cls("Stretch", [], "NamedTuple", [["time", null], ["x", null], ["y", null], ["counts", null], ["loads", () => $.tup()]], false, true, ($c) => { Stretch = $c; });
rows_of = $.def(function (sizes, turns) { let size, step, share;
size = $.b.sum(sizes);
if ($.t($.le(size, LONG))) {return (() => { const $r = []; for (const $v7 of $.it(sizes)) { let each; each = $v7; $r.push($.b.slice(0, each)); } return $r; })();}
step = $.b.max(1, $.b.min($.neg($.fdiv($.neg(size), ENOUGH)), $.fdiv(size, $.mul(40, $.b.max(1, turns)))));
share = $.b.min(1.0, $.div($.mul(step, ENOUGH), size));
return (() => { const $r = []; for (const $v8 of $.it(sizes)) { let each; each = $v8; $r.push($.b.slice(0, $.b.round($.mul(share, each)), step)); } return $r; })(); }, {p: ["sizes", "turns"], ks: false});
stretches_of = $.def(function (data, recording, rows, signals) { let found, step, piece, first, last, time, x, y, loads, at, counts;
{const $v9 = $.unpack($.tup([], $.or($.ga(rows, "step"), () => 1)), 2, -1);found = $v9[0];step = $v9[1];}
for (const $v10 of $.it($.ga(data, "pieces"))) { piece = $v10;
{{const $v11 = $.unpack($.tup($.neg($.fdiv($.neg($.ga(piece, "start")), step)), $.neg($.fdiv($.neg($.add($.ga(piece, "start"), $.ga($.ga(piece, "x"), "size"))), step))), 2, -1);first = $v11[0];last = $v11[1];}
{const $v12 = $.unpack($.gi(signals, $.tup($.slice(null, null, null), $.slice(first, last, null))), 4, 3);time = $v12[0];x = $v12[1];y = $v12[2];loads = $v12[3];}
if (($.t($.eq($.ga(piece, "recording"), recording)) && $.t($.gt($.ga(time, "size"), 2)))) {at = $.sub($.add($.mul(np.arange($.ga(time, "size")), step), $.mul(first, step)), $.ga(piece, "start"));
counts = $.ge(at, piece.usable_from("zero"));
if ($.t(($.ga(piece, "weight") != null))) {counts = $.iband(counts, $.gt($.gi($.ga(piece, "weight"), at), 0.0));}
$.cm(found, "append", [Stretch(time, x, y, counts, $.b.tuple(loads))]);}} }
return (() => { const $r = []; for (const $v13 of $.it(found)) { let stretch; stretch = $v13; if ($.t($.ga(stretch, "counts").any())) { $r.push(stretch); } } return $r; })(); }, {p: ["data", "recording", "rows", "signals"], ks: false});
evidence = $.def(function (stretches) { let ways, turned, blocks, best, found;
if ($.t($.lt($.b.sum((function* () { for (const $v14 of $.it(stretches)) { let s; s = $v14; yield $.b.int($.ga(s, "counts").sum()); } })()), LEAST))) {return $.tup();}
ways = [];
for (const $v15 of $.it($.tup(stretches, (() => { const $r = []; for (const $v16 of $.it(stretches)) { let s; s = $v16; $r.push($.km(s, "_replace", [], {"x": $.ga(s, "y"), "y": $.ga(s, "x")})); } return $r; })()))) { turned = $v15;
{blocks = _blocks(turned);
if ($.t((blocks == null))) {return $.tup();}
ways = $.iadd(ways, (() => { const $r = []; for (const $v17 of $.it($.tup(1.0, (-1.0)))) { let sign; sign = $v17; $r.push(_Way(blocks, $.b.len($.ga($.gi(stretches, 0), "loads")), sign)); } return $r; })());} }
best = $.k($.b.min, [$.b.range($.b.len(ways))], {"key": $.def((k) => {  return $.ga($.gi(ways, k), "fitted"); }, {p: ["k"], ks: false})});
found = $.b.tuple((function* () { for (const $v18 of $.it($.tup(RATE, CREEP))) { let group; group = $v18; yield $.gi(ways, best).test(group, $.gi(ways, $.mod($.add(best, 2), 4))); } })());
return ($.t($.b.any((function* () { for (const $v19 of $.it(found)) { let each; each = $v19; yield $.ga(each, "there"); } })())) ? found : $.b.tuple((function* () { for (const $v20 of $.it(found)) { let each; each = $v20; yield $.k(replace, [each], {"apart": $.ga(each, "own")}); } })())); }, {p: ["stretches"], ks: false});
permutation_p = $.def(function (gains) { let means;
means = $.mm($.gi(_SIGNS, $.tup($.slice(null, $.shl(1, $.ga(gains, "size")), null), $.slice(null, $.ga(gains, "size"), null))), gains);
return $.b.float(np.mean($.ge(means, $.sub($.gi(means, 0), $.mul(1e-12, np.sum(np.abs(gains))))))); }, {p: ["gains"], ks: false});
_Block = $.cls("_Block", [], "NamedTuple", [["rows", null], ["samples", null]], false, true, ($c) => { _Block = $c; });
_Way = $.cls("_Way", [], "", [], false, true, ($c) => { _Way = $c; $.meth($c, "__init__", $.def(function (blocks, loads, sign) { const self = this;let ends, first, last, signs;
ends = $.b.max(1, $.mul(2, loads));
self.free = $.add(DEGREE, $.mul(loads, $.add(DEGREE, 1)));
first = $.add($.ga(self, "free"), $.mul($.mul(2, $.add(1, loads)), $.add($.ga(RADII, "size"), $.ga(LENGTHS, "size"))));
last = $.add(first, $.mul(ends, $.add(TIMES, 1)));
self.groups = $.dict([[CREEP, np.arange(first, $.sub(last, ends))], [RATE, np.arange($.sub(last, ends), last)]]);
self.every = np.arange($.add(last, 1));
signs = np.where($.band($.ge($.ga(self, "every"), $.ga(self, "free")), $.lt($.ga(self, "every"), last)), sign, 1.0);
self.blocks = (() => { const $r = []; for (const $v21 of $.it(blocks)) { let block; block = $v21; $r.push(_Block($.mul($.ga(block, "rows"), signs), $.ga(block, "samples"))); } return $r; })();
self.whole = triangle(np.concatenate((() => { const $r = []; for (const $v22 of $.it($.ga(self, "blocks"))) { let block; block = $v22; $r.push($.ga(block, "rows")); } return $r; })()));
self.fitted = _square($.ga(self, "whole"), $.ga(self, "every"), self._solve($.ga(self, "every"), $.ga(self, "whole"))); }, {p: ["blocks", "loads", "sign"], ks: false}));
$.cached($c, "others", $.def(function () { const self = this;let rows;
rows = (() => { const $r = []; for (const $v23 of $.it($.ga(self, "blocks"))) { let block; block = $v23; $r.push($.ga(block, "rows")); } return $r; })();
return (() => { const $r = []; for (const $v24 of $.it($.b.range($.b.len(rows)))) { let k; k = $v24; $r.push(triangle(np.concatenate($.add($.gi(rows, $.slice(null, k, null)), $.gi(rows, $.slice($.add(k, 1), null, null)))))); } return $r; })(); }, {p: [], ks: false}));
$.cached($c, "with_all", $.def(function () { const self = this;
return self._held_out($.ga(self, "every")); }, {p: [], ks: false}));
$.meth($c, "test", $.def(function (group, turned) { const self = this;let others, with_it, without_it, gains;
others = np.setdiff1d($.ga(self, "every"), $.gi($.ga(self, "groups"), group));
{const $v25 = $.unpack($.tup($.ga(self, "with_all"), self._held_out(others)), 2, -1);with_it = $v25[0];without_it = $v25[1];}
gains = $.sub(np.log(without_it), np.log(with_it));
return Evidence(group, $.mul(50.0, $.b.float(np.exp(np.mean(np.log(without_it))))), $.mul(50.0, $.b.float(np.exp(np.mean(np.log(with_it))))), $.b.int(np.sum($.lt(with_it, without_it))), BLOCKS, permutation_p(gains), self._own(group, $.gi(others, $.slice(null, (-1), null))), turned._own(group, $.gi(others, $.slice(null, (-1), null)))); }, {p: ["group", "turned"], ks: false}));
$.meth($c, "_held_out", $.def(function (columns) { const self = this;let errors, block, others, solution;
errors = [];
for (const $v26 of $.it($.k($.b.zip, [$.ga(self, "blocks"), $.ga(self, "others")], {"strict": true}))) { {const $v27 = $.unpack($v26, 2, -1);block = $v27[0];others = $v27[1];}
{solution = self._solve(columns, others);
$.cm(errors, "append", [np.sqrt($.div(_square($.ga(block, "rows"), columns, solution), $.ga(block, "samples")))]);} }
return np.maximum($.km(np, "array", [errors], {"dtype": $.ga(np, "float64")}), 1e-12); }, {p: ["columns"], ks: false}));
$.meth($c, "_solve", $.def(function (columns, rows) { const self = this;let penalty, lower;
rows = $.gi(rows, $.tup($.slice(null, null, null), columns));
penalty = np.zeros($.tup($.ga(columns, "size"), $.ga(columns, "size")));
$.si(penalty, $.tup($.slice(null, (-1), null), $.slice(null, (-1), null)), np.diag(np.sqrt($.mul(RIDGE, $.km(np, "sum", [$.pow($.gi(rows, $.tup($.slice(null, null, null), $.slice(null, (-1), null))), 2)], {"axis": 0})))));
lower = np.zeros($.sub($.sub($.ga(columns, "size"), 1), $.ga(self, "free")));
return solve_bounded(triangle(np.concatenate([rows, penalty])), $.ga(self, "free"), lower); }, {p: ["columns", "rows"], ks: false}));
$.meth($c, "_own", $.def(function (group, others) { const self = this;let columns, factor, left;
columns = $.gi($.ga(self, "whole"), $.tup($.slice(null, null, null), $.gi($.ga(self, "groups"), group)));
factor = triangle(np.column_stack([$.gi($.ga(self, "whole"), $.tup($.slice(null, null, null), others)), columns]));
left = $.km($.ga(np, "linalg"), "norm", [$.gi(factor, $.tup($.slice($.ga(others, "size"), null, null), $.slice($.ga(others, "size"), null, null)))], {"axis": 0});
return $.b.float(np.max($.div(left, np.maximum($.km($.ga(np, "linalg"), "norm", [columns], {"axis": 0}), 1e-300)))); }, {p: ["group", "others"], ks: false}));});
_square = $.def(function (rows, columns, solution) { let left;
left = $.mm($.gi(rows, $.tup($.slice(null, null, null), columns)), np.concatenate([$.ga(solution, "free"), $.ga(solution, "bounded"), [(-1.0)]]));
return $.b.float($.mm(left, left)); }, {p: ["rows", "columns", "solution"], ks: false});
_blocks = $.def(function (stretches) { let drive, other, longest, step, times, parts;
{const $v30 = $.unpack($.tup(_scaling((() => { const $r = []; for (const $v28 of $.it(stretches)) { let s; s = $v28; $r.push($.gi($.ga(s, "x"), $.ga(s, "counts"))); } return $r; })()), _scaling((() => { const $r = []; for (const $v29 of $.it(stretches)) { let s; s = $v29; $r.push($.gi($.ga(s, "y"), $.ga(s, "counts"))); } return $r; })())), 2, -1);drive = $v30[0];other = $v30[1];}
if (($.t((drive == null)) || $.t((other == null)))) {return null;}
longest = $.b.max((function* () { for (const $v31 of $.it(stretches)) { let s; s = $v31; yield $.b.float($.sub($.gi($.ga(s, "time"), (-1)), $.gi($.ga(s, "time"), 0))); } })());
step = $.b.float(np.median(np.concatenate((() => { const $r = []; for (const $v32 of $.it(stretches)) { let s; s = $v32; $r.push(np.diff($.ga(s, "time"))); } return $r; })())));
times = np.geomspace($.b.max($.mul(STEPS, step), $.div($.mul(SHARE, longest), WIDEST)), $.mul(SHARE, longest), TIMES);
parts = (() => { const $r = []; for (const $v33 of $.it(stretches)) { let s; s = $v33; $r.push($.gi(_columns($.ga(s, "time"), $.div($.sub($.ga(s, "x"), $.gi(drive, 0)), $.gi(drive, 1)), $.div($.sub($.ga(s, "y"), $.gi(other, 0)), $.gi(other, 1)), times, $.ga(s, "loads")), $.ga(s, "counts"))); } return $r; })();
return $.b.list(_cut(parts)); }, {p: ["stretches"], ks: false});
_scaling = $.def(function (parts) { let low, high;
{const $v36 = $.unpack($.tup($.b.min((function* () { for (const $v34 of $.it(parts)) { let p; p = $v34; if ($.t($.ga(p, "size"))) { yield $.b.float(p.min()); } } })()), $.b.max((function* () { for (const $v35 of $.it(parts)) { let p; p = $v35; if ($.t($.ga(p, "size"))) { yield $.b.float(p.max()); } } })())), 2, -1);low = $v36[0];high = $v36[1];}
return ($.t($.gt(high, low)) ? $.tup($.mul(0.5, $.add(low, high)), $.mul(0.5, $.sub(high, low))) : null); }, {p: ["parts"], ks: false});
_columns = $.def(function (time, q, explained, times, loads) { let memory, creep, inside, powers, rate, ends, whole, places;
{const $v37 = $.unpack($.tup(np.ascontiguousarray(q), np.ascontiguousarray(time)), 2, -1);q = $v37[0];time = $v37[1];}
{const $v38 = $.unpack($.cm(np, "split", [$.gi(_native.direct_bank(q, time, RADII, LENGTHS, times, false), 0), [$.neg($.ga(times, "size"))]], {"axis": 1}), 2, -1);memory = $v38[0];creep = $v38[1];}
inside = np.clip(q, (-1.0), 1.0);
powers = $.km(np, "asarray", [$.ga($.ga(np, "polynomial"), "chebyshev").chebvander(inside, DEGREE)], {"dtype": $.ga(np, "float64")});
rate = ($.t($.gt($.ga(q, "size"), 2)) ? velocity(time, q) : np.zeros($.ga(q, "size")));
ends = (() => { const $r = []; for (const $v40 of $.it(loads)) { let load; load = $v40; for (const $v39 of $.it($.tup(load, $.sub(1.0, load)))) { let share; share = $v39; $r.push($.gi(share, $.tup($.slice(null, null, null), null))); } } return $r; })();
whole = $.or(ends, () => [np.ones($.tup($.ga(q, "size"), 1))]);
places = [$.mul(0.5, $.gi($.add(1.0, inside), $.tup($.slice(null, null, null), null))), $.mul(0.5, $.gi($.sub(1.0, inside), $.tup($.slice(null, null, null), null))), ...$.it(ends)];
return np.column_stack([$.gi(powers, $.tup($.slice(null, null, null), $.slice(1, null, null))), ...$.it((function* () { for (const $v41 of $.it(loads)) { let load; load = $v41; yield $.mul($.gi(load, $.tup($.slice(null, null, null), null)), powers); } })()), ...$.it((function* () { for (const $v42 of $.it(places)) { let share; share = $v42; yield $.mul(share, memory); } })()), ...$.it((function* () { for (const $v43 of $.it(whole)) { let share; share = $v43; yield $.mul(share, creep); } })()), ...$.it((function* () { for (const $v44 of $.it(whole)) { let share; share = $v44; yield $.mul(share, $.gi(rate, $.tup($.slice(null, null, null), null))); } })()), explained]); }, {p: ["time", "q", "explained", "times", "loads"], ks: false});
_cut = $.def(function* (parts) { let ends, begin, end, inside;
ends = np.cumsum([0, ...$.it((function* () { for (const $v45 of $.it(parts)) { let part; part = $v45; yield $.gi($.ga(part, "shape"), 0); } })())]);
for (const $v46 of $.it(itertools.pairwise(np.linspace(0, $.gi(ends, (-1)), $.add(BLOCKS, 1)).round().astype($.b.int).tolist()))) { {const $v47 = $.unpack($v46, 2, -1);begin = $v47[0];end = $v47[1];}
{inside = (() => { const $r = []; for (const $v48 of $.it($.k($.b.zip, [parts, $.gi(ends, $.slice(null, (-1), null)).tolist(), $.gi(ends, $.slice(1, null, null)).tolist()], {"strict": true}))) { let part, first, last; {const $v49 = $.unpack($v48, 3, -1);part = $v49[0];first = $v49[1];last = $v49[2];} if (($.t($.lt(first, end)) && $.t($.gt(last, begin)))) { $r.push($.gi(part, $.slice($.b.max($.sub(begin, first), 0), $.sub(end, first), null))); } } return $r; })();
(yield _Block(triangle(np.concatenate((() => { const $r = []; for (const $v50 of $.it(inside)) { let part; part = $v50; $r.push($.sub(part, $.km(part, "mean", [], {"axis": 0}))); } return $r; })())), $.sub(end, begin)));} } }, {p: ["parts"], ks: false});
without_holds = $.def(function* (tested, answer, time) { let imitated, usual, slower;
imitated = (() => { const $r = []; for (const $v51 of $.it(tested)) { let found; found = $v51; if (($.t($.eq($.ga(found, "group"), CREEP)) && $.t($.lt($.ga(found, "own"), TOLD)))) { $r.push($.ga(found, "own")); } } return $r; })();
if (!$.t(imitated)) {return null;}
usual = answer(time);
slower = $.mul(100.0, $.b.float($.div(np.sqrt(np.mean($.pow($.sub(answer($.mul(SLOWER, time)), usual), 2))), $.b.max(np.ptp(usual), 1e-300))));
if ($.t($.gt(slower, OTHER_SPEED))) {(yield Finding("creep-without-holds", ("" + "at a tenth of the log's speed the model answers " + $.f(slower, ("" + ".2g"), -1) + " % of range (rms) otherwise, and this log cannot confirm that: hysteresis imitates " + $.f($.sub(100, $.mul(100, $.gi(imitated, 0))), ("" + ".0f"), -1) + " % of the course of creep in it. Use the model at the speeds of the log, or log with holds after reversals and at different speeds; `dehyst design` plans them.")));} }, {p: ["tested", "answer", "time"], ks: false});
Object.assign($m, {"annotations": annotations, "itertools": itertools, "Callable": Callable, "Iterator": Iterator, "Sequence": Sequence, "dataclass": dataclass, "replace": replace, "cached_property": cached_property, "NamedTuple": NamedTuple, "np": np, "npt": npt, "_native": _native, "Array": Array_, "Mask": Mask, "Finding": Finding, "ENOUGH": ENOUGH, "LONG": LONG, "DataSet": DataSet, "velocity": velocity, "Solution": Solution, "solve_bounded": solve_bounded, "triangle": triangle, "RATE": RATE, "CREEP": CREEP, "BLOCKS": BLOCKS, "_SIGNS": _SIGNS, "LEVEL": LEVEL, "WORTH": WORTH, "IMITATED": IMITATED, "TOLD": TOLD, "DEGREE": DEGREE, "RADII": RADII, "LENGTHS": LENGTHS, "TIMES": TIMES, "STEPS": STEPS, "SHARE": SHARE, "WIDEST": WIDEST, "RIDGE": RIDGE, "LEAST": LEAST, "OTHER_SPEED": OTHER_SPEED, "SLOWER": SLOWER, "Evidence": Evidence, "Stretch": Stretch, "rows_of": rows_of, "stretches_of": stretches_of, "evidence": evidence, "permutation_p": permutation_p, "_Block": _Block, "_Way": _Way, "_square": _square, "_blocks": _blocks, "_scaling": _scaling, "_columns": _columns, "_cut": _cut, "without_holds": without_holds});
});
$.module("dehyst.identification.facts", ($m) => {
let annotations, dataclass, np, npt, Array_, Rows, turning_points, ENOUGH, LONG, DataSet, BINS, NARROW, STILL, RESTS, ONE_SIZE, FEWEST_WAYS, Orientation, Branches, branches, strokes, longest_rest, Motion, motion, shares, first_branch, orientation, spread, count_loops, velocity, drift;
dataclass = $.from("dataclasses", "dataclass");
np = $.imp("numpy");
npt = $.imp("numpy.typing");
Array_ = $.from("dehyst.arrays", "Array");Rows = $.from("dehyst.arrays", "Rows");
turning_points = $.from("dehyst.data.loops", "turning_points");
ENOUGH = $.from("dehyst.identification.data", "ENOUGH");LONG = $.from("dehyst.identification.data", "LONG");DataSet = $.from("dehyst.identification.data", "DataSet");
BINS = 24;
NARROW = 0.01;
STILL = 0.01;
RESTS = 0.3;
ONE_SIZE = 0.9;
FEWEST_WAYS = 4;
Orientation = $.cls("Orientation", [], "", [["name", null], ["width", null]], true, true, ($c) => { Orientation = $c; });
Branches = $.cls("Branches", [], "", [["x", null], ["y", null], ["weight", null], ["falling", null], ["inner", null], ["strokes", null], ["still", () => $.b.float("nan")]], true, true, ($c) => { Branches = $c; });
branches = $.def(function (data) { let found, piece, most, x, points, rows, branch, falling, weight, inner;
found = [];
for (const $v1 of $.it($.k($.b.zip, [$.ga(data, "pieces"), shares(data)], {"strict": true}))) { {const $v2 = $.unpack($v1, 2, -1);piece = $v2[0];most = $v2[1];}
{x = $.gi($.ga(piece, "x"), $.slice(null, $.ga(piece, "split"), null));
points = turning_points(x, 0.1);
rows = spread(first_branch(points), $.ga(piece, "split"), most);
branch = np.minimum($.km(np, "searchsorted", [points, rows], {"side": "right"}), $.sub($.ga(points, "size"), 1));
falling = ($.t($.ga(rows, "size")) ? $.le($.gi(x, $.gi(points, branch)), $.gi(x, $.gi(points, $.sub(branch, 1)))) : $.km(np, "zeros", [0], {"dtype": $.ga(np, "bool_")}));
falling = $.iband(falling, $.lt(rows, $.sub($.ga(piece, "split"), 1)));
weight = ($.t(($.ga(piece, "weight") == null)) ? null : $.gi($.ga(piece, "weight"), rows));
inner = $.gi(points, $.slice(1, (-1), null));
$.cm(found, "append", [Branches($.gi(x, rows), $.gi($.ga(piece, "y"), rows), weight, falling, $.ga(inner, "size"), strokes(inner, $.gi(x, inner)), longest_rest(x))]);} }
return $.b.tuple(found); }, {p: ["data"], ks: false});
strokes = $.def(function (places, values) { 
return $.km(np, "array", [[$.mul(0.5, np.abs(np.diff(values))), np.diff(places)]], {"dtype": $.ga(np, "float64")}); }, {p: ["places", "values"], ks: false});
longest_rest = $.def(function (x) { let longest, offset, steps;
longest = 0;
for (const $v3 of $.it($.tup(0.0, 0.5))) { offset = $v3;
{steps = np.flatnonzero(np.diff(np.floor($.add($.div(x, $.mul(2.0, STILL)), offset))));
longest = $.b.max(longest, $.b.int($.km(np, "max", [$.km(np, "diff", [steps], {"prepend": (-1), "append": $.sub($.ga(x, "size"), 1)})], {"initial": 0})));} }
return $.b.float(longest); }, {p: ["x"], ks: false});
Motion = $.cls("Motion", [], "", [["smallest", () => $.b.float("nan")], ["largest", () => $.b.float("nan")], ["speeds", () => $.b.float("nan")], ["rests", () => null]], true, true, ($c) => { Motion = $c; $.prop($c, "one_size", $.def(function () { const self = this;
return $.gt($.ga(self, "smallest"), $.mul(ONE_SIZE, $.ga(self, "largest"))); }, {p: [], ks: false}));});
motion = $.def(function (found) { let ways, samples, still, low, high, slow, fast, rests, speeds;
{const $v5 = $.unpack($.km(np, "concatenate", [(() => { const $r = []; for (const $v4 of $.it(found)) { let piece; piece = $v4; $r.push($.ga(piece, "strokes")); } return $r; })()], {"axis": 1}), 2, -1);ways = $v5[0];samples = $v5[1];}
still = (() => { const $r = []; for (const $v6 of $.it(found)) { let piece; piece = $v6; $r.push($.ga(piece, "still")); } return $r; })();
if ($.t($.lt($.ga(ways, "size"), FEWEST_WAYS))) {return Motion();}
{const $v7 = $.unpack(np.quantile(ways, [0.05, 0.95]), 2, -1);low = $v7[0];high = $v7[1];}
{const $v8 = $.unpack(np.quantile($.div(ways, samples), [0.05, 0.95]), 2, -1);slow = $v8[0];fast = $v8[1];}
rests = ($.t(np.isnan(still).any()) ? null : $.b.bool($.gt($.b.max(still), $.mul(RESTS, $.b.float(np.median(samples))))));
speeds = ($.t(rests) ? $.b.float("nan") : $.b.float($.div(fast, slow)));
return Motion($.mul(100.0, $.b.float(low)), $.mul(100.0, $.b.float(high)), speeds, rests); }, {p: ["found"], ks: false});
shares = $.def(function (data) { let fitted, share;
fitted = $.b.sum((function* () { for (const $v9 of $.it($.ga(data, "pieces"))) { let piece; piece = $v9; yield $.ga(piece, "split"); } })());
share = ($.t($.le(fitted, LONG)) ? 1.0 : $.div(ENOUGH, fitted));
return (() => { const $r = []; for (const $v10 of $.it($.ga(data, "pieces"))) { let piece; piece = $v10; $r.push(($.t($.lt($.ga(piece, "split"), 3)) ? 0 : $.b.max(1, $.b.round($.mul(share, $.ga(piece, "split")))))); } return $r; })(); }, {p: ["data"], ks: false});
first_branch = $.def(function (points) { 
return ($.t($.gt($.ga(points, "size"), 3)) ? $.b.int($.gi(points, 1)) : 0); }, {p: ["points"], ks: false});
orientation = $.def(function (found) { let edges, sums, counts, piece, cell, inside, weight, values, both, distance, width, lag, lead;
edges = np.linspace((-0.9), 0.9, $.add(BINS, 1));
sums = np.zeros($.tup(2, BINS));
counts = np.zeros($.tup(2, BINS));
for (const $v11 of $.it(found)) { piece = $v11;
{cell = $.sub(np.digitize($.ga(piece, "x"), edges), 1);
inside = $.band($.ge(cell, 0), $.lt(cell, BINS));
cell = $.add($.mul($.gi($.ga(piece, "falling"), inside), BINS), $.gi(cell, inside));
weight = ($.t(($.ga(piece, "weight") == null)) ? null : $.gi($.ga(piece, "weight"), inside));
values = ($.t((weight == null)) ? $.gi($.ga(piece, "y"), inside) : $.mul($.gi($.ga(piece, "y"), inside), weight));
sums = $.iadd(sums, np.bincount(cell, values, $.mul(2, BINS)).reshape(2, BINS));
counts = $.iadd(counts, np.bincount(cell, weight, $.mul(2, BINS)).reshape(2, BINS));} }
both = $.km($.gt(counts, 0), "all", [], {"axis": 0});
if (!$.t(both.any())) {return Orientation("none", 0.0);}
distance = $.mul(0.5, $.sub($.div($.gi(sums, $.tup(1, both)), $.gi(counts, $.tup(1, both))), $.div($.gi(sums, $.tup(0, both)), $.gi(counts, $.tup(0, both)))));
width = $.b.float(np.mean(np.abs(distance)));
{const $v12 = $.unpack($.tup($.b.float(np.sum($.gi(distance, $.gt(distance, 0)))), $.b.float($.neg(np.sum($.gi(distance, $.lt(distance, 0)))))), 2, -1);lag = $v12[0];lead = $v12[1];}
if ($.t($.lt(width, NARROW))) {return Orientation("none", width);}
if ($.t($.gt($.b.min(lag, lead), $.mul(0.25, $.b.max(lag, lead))))) {return Orientation("mixed", width);}
return Orientation(($.t($.gt(lag, lead)) ? "counter-clockwise" : "clockwise"), width); }, {p: ["found"], ks: false});
spread = $.def(function (first, end, most) { let golden, step, places, rows;
if ($.t($.eq(most, 0))) {return $.km(np, "zeros", [0], {"dtype": $.ga(np, "int64")});}
if ($.t($.le($.sub(end, first), most))) {return $.km(np, "arange", [first, end], {"dtype": $.ga(np, "int64")});}
golden = 0.6180339887498949;
step = $.div($.sub(end, first), most);
places = $.add(first, $.mul(step, $.add(np.arange(most), $.gi(np.modf($.mul(golden, np.arange(most))), 0))));
rows = np.minimum(places.astype($.ga(np, "int64")), $.sub(end, 1));
return rows; }, {p: ["first", "end", "most"], ks: false});
count_loops = $.def(function (found) { 
return $.tup($.b.sum((function* () { for (const $v13 of $.it(found)) { let piece; piece = $v13; yield $.fdiv($.add($.ga(piece, "inner"), 1), 2); } })()), $.b.sum((function* () { for (const $v14 of $.it(found)) { let piece; piece = $v14; yield $.ga(piece, "inner"); } })())); }, {p: ["found"], ks: false});
velocity = $.def(function (time, x) { let turns, window, before, after, padded, middle, running, rate;
turns = $.b.max(2, $.sub($.ga(turning_points(x), "size"), 1));
window = $.b.max(1, $.b.round($.div($.div($.ga(x, "size"), turns), 20)));
{const $v15 = $.unpack($.tup($.fdiv(window, 2), $.fdiv($.sub(window, 1), 2)), 2, -1);before = $v15[0];after = $v15[1];}
padded = np.concatenate([np.full(before, $.gi(x, 0)), x, np.full(after, $.gi(x, (-1)))]);
middle = $.mul(0.5, $.add($.b.float(np.max(x)), $.b.float(np.min(x))));
running = np.concatenate([[0.0], np.cumsum($.sub(padded, middle))]);
rate = np.gradient(($.t($.gt(window, 1)) ? $.div($.sub($.gi(running, $.slice(window, null, null)), $.gi(running, $.slice(null, $.neg(window), null))), window) : x), time);
return rate; }, {p: ["time", "x"], ks: false});
drift = $.def(function (x, residual, less = null) { let points, begins, counted, sums, cycles, k, slope, rest, error;
points = $.gi(turning_points(x), $.slice(1, (-1), null));
begins = $.gi(points, $.slice(null, null, 2));
if ($.t($.lt($.ga(begins, "size"), 5))) {return $.tup(0.0, 0.0);}
counted = $.b.slice(0, $.b.int($.gi(begins, (-1))));
sums = $.ga(np, "add").reduceat($.gi(residual, counted), $.gi(begins, $.slice(null, (-1), null)));
if ($.t((less != null))) {sums = $.sub(sums, $.ga(np, "add").reduceat($.gi(less, counted), $.gi(begins, $.slice(null, (-1), null))));}
cycles = $.div(sums, np.diff(begins));
k = $.km(np, "arange", [$.ga(cycles, "size")], {"dtype": $.ga(np, "float64")});
k = $.isub(k, k.mean());
slope = $.b.float($.div($.mm(k, cycles), $.mm(k, k)));
rest = $.sub($.sub(cycles, cycles.mean()), $.mul(slope, k));
error = $.b.float(np.sqrt($.div($.div($.mm(rest, rest), $.sub($.ga(cycles, "size"), 2)), $.mm(k, k))));
return $.tup($.mul(slope, $.sub($.ga(cycles, "size"), 1)), $.mul(error, $.sub($.ga(cycles, "size"), 1))); }, {p: ["x", "residual", "less"], ks: false});
Object.assign($m, {"annotations": annotations, "dataclass": dataclass, "np": np, "npt": npt, "Array": Array_, "Rows": Rows, "turning_points": turning_points, "ENOUGH": ENOUGH, "LONG": LONG, "DataSet": DataSet, "BINS": BINS, "NARROW": NARROW, "STILL": STILL, "RESTS": RESTS, "ONE_SIZE": ONE_SIZE, "FEWEST_WAYS": FEWEST_WAYS, "Orientation": Orientation, "Branches": Branches, "branches": branches, "strokes": strokes, "longest_rest": longest_rest, "Motion": Motion, "motion": motion, "shares": shares, "first_branch": first_branch, "orientation": orientation, "spread": spread, "count_loops": count_loops, "velocity": velocity, "drift": drift});
});
$.module("dehyst.identification.families", ($m) => {
let annotations, Callable, dataclass, lru_cache, np, npt, _native, Array_, DataSet, Piece, solve_bounded, triangle, unsolved, TRACE, Bank, NormalEquations, blocks, ramp_columns, HysteresisModel, ModelCard, ModifiedPrandtlIshlinskii, MonotoneMap, PrandtlIshlinskii, StopOperatorModel, FAMILIES, BASIS, MAP_PIECES, SMALLEST_SLOPE, NORMALISATION, Regularisation, Program, lower_bounds, program, smoothing_rows, _smoothing, unit_ridge, Marks, STATIC, NORMAL, ORTHOGONAL, LARGEST_CONDITION, HIGH_GAIN, ROUNDING, OUTSIDE_SLOPE, Estimate, fit_family, estimate_of, gain_of, is_high, map_points, mapped, continued, CHUNK, solve_family, reduce, build_model;
Callable = $.from("collections.abc", "Callable");
dataclass = $.from("dataclasses", "dataclass");
lru_cache = $.from("functools", "lru_cache");
np = $.imp("numpy");
npt = $.imp("numpy.typing");
_native = $.imp("dehyst._native");
Array_ = $.from("dehyst.arrays", "Array");
DataSet = $.from("dehyst.identification.data", "DataSet");Piece = $.from("dehyst.identification.data", "Piece");
solve_bounded = $.from("dehyst.identification.least_squares", "solve_bounded");triangle = $.from("dehyst.identification.least_squares", "triangle");unsolved = $.from("dehyst.identification.least_squares", "unsolved");
TRACE = $.from("dehyst.identification.regressors", "TRACE");Bank = $.from("dehyst.identification.regressors", "Bank");NormalEquations = $.from("dehyst.identification.regressors", "NormalEquations");blocks = $.from("dehyst.identification.regressors", "blocks");ramp_columns = $.from("dehyst.identification.regressors", "ramp_columns");
HysteresisModel = $.from("dehyst.models.base", "HysteresisModel");ModelCard = $.from("dehyst.models.card", "ModelCard");ModifiedPrandtlIshlinskii = $.from("dehyst.models.monotone", "ModifiedPrandtlIshlinskii");MonotoneMap = $.from("dehyst.models.monotone", "MonotoneMap");PrandtlIshlinskii = $.from("dehyst.models.prandtl_ishlinskii", "PrandtlIshlinskii");StopOperatorModel = $.from("dehyst.models.prandtl_ishlinskii", "StopOperatorModel");
FAMILIES = $.tup("pi", "pi-cumulative", "modified-pi", "stop");
BASIS = $.dict([["pi", $.ga(_native, "WEIGHTS")], ["pi-cumulative", $.ga(_native, "SLOPES")], ["modified-pi", $.ga(_native, "WEIGHTS")], ["stop", $.ga(_native, "STOPS")]]);
MAP_PIECES = 20;
SMALLEST_SLOPE = 0.05;
NORMALISATION = 1000.0;
Regularisation = $.cls("Regularisation", [], "", [["smoothing", null], ["ridge", null]], true, true, ($c) => { Regularisation = $c; });
Program = $.cls("Program", [], "", [["basis", null], ["gram", null], ["rhs", null], ["lower", null], ["extra", null], ["extra_rhs", null], ["target", null]], true, true, ($c) => { Program = $c; });
lower_bounds = $.def(function (family, operators, eps, pieces = 0) { let lower;
lower = np.zeros($.add(operators, pieces));
$.si(lower, $.slice(null, operators, null), ($.t($.eq(family, "pi-cumulative")) ? eps : 0.0));
$.si(lower, 0, eps);
$.si(lower, $.slice(operators, null, null), SMALLEST_SLOPE);
return lower; }, {p: ["family", "operators", "eps", "pieces"], ks: false});
program = $.def(function (family, sums, eps, knots = null, regularisation = null, fold_ridge = 0.0) { let n, matrix, rhs, target, lower, extra, gram, widths, size, extra_rhs;
{const $v1 = $.unpack($.tup($.ga(sums, "operators"), $.ga(sums, "matrix")), 2, -1);n = $v1[0];matrix = $v1[1];}
if ($.t($.ne(family, "modified-pi"))) {{const $v2 = $.unpack($.tup($.cm($.gi(matrix, $.tup($.slice(null, $.add(1, n), null), (-1))), "copy", []), $.b.float(np.sqrt($.gi(matrix, $.tup((-1), (-1)))))), 2, -1);rhs = $v2[0];target = $v2[1];}
lower = np.concatenate([[0.0], lower_bounds(family, n, eps)]);
extra = ($.t(fold_ridge) ? $.mul(fold_ridge, unit_ridge(family, n)) : null);
gram = np.ascontiguousarray($.gi(matrix, $.tup($.slice(null, $.add(1, n), null), $.slice(null, $.add(1, n), null))));
return Program($.gi(BASIS, family), gram, rhs, lower, extra, null, target);}
if (($.t((knots == null)) || $.t((regularisation == null)))) {throw $.exc($.b.AssertionError("the modified model needs knots and a regularisation"));}
widths = np.diff(knots);
size = $.add($.add(1, n), $.ga(widths, "size"));
gram = np.array($.gi(matrix, $.tup($.slice(null, size, null), $.slice(null, size, null))));
$.isi(gram, $.tup($.slice($.add(1, n), null, null), $.slice(null, $.add(1, n), null)), $.imul, (-1.0));
$.isi(gram, $.tup($.slice(null, $.add(1, n), null), $.slice($.add(1, n), null, null)), $.imul, (-1.0));
extra = $.mul($.ga(sums, "samples"), _smoothing(regularisation, n, $.b.tuple(widths.tolist())));
$.isi(extra, $.tup($.slice(1, $.add(1, n), null), $.slice(1, $.add(1, n), null)), $.iadd, $.mul(fold_ridge, np.eye(n)));
extra_rhs = np.zeros(size);
$.si(extra_rhs, $.slice($.add(1, n), null, null), $.mul($.mul($.mul($.pow(NORMALISATION, 2), $.ga(sums, "samples")), $.b.float(np.sum(widths))), widths));
target = $.mul(NORMALISATION, $.b.float($.mul(np.sqrt($.ga(sums, "samples")), np.sum(widths))));
lower = np.concatenate([[0.0], lower_bounds(family, n, eps, $.ga(widths, "size"))]);
return Program($.gi(BASIS, family), gram, np.zeros(size), lower, extra, extra_rhs, target); }, {p: ["family", "sums", "eps", "knots", "regularisation", "fold_ridge"], ks: false});
smoothing_rows = $.def(function (regularisation, n, widths) { let pieces, rows, rhs, k, diagonal;
pieces = $.ga(widths, "size");
{const $v3 = $.unpack($.tup(np.zeros($.tup($.add(pieces, n), $.add($.add(1, n), pieces))), np.zeros($.add(pieces, n))), 2, -1);rows = $v3[0];rhs = $v3[1];}
$.si(rows, $.tup(0, $.slice($.add(1, n), null, null)), $.mul(NORMALISATION, widths));
$.si(rhs, 0, $.mul(NORMALISATION, $.b.float(np.sum(widths))));
k = np.arange($.sub(pieces, 1));
$.si(rows, $.tup($.add(1, k), $.add($.add(1, n), k)), $.neg($.ga(regularisation, "smoothing")));
$.si(rows, $.tup($.add(1, k), $.add($.add(2, n), k)), $.ga(regularisation, "smoothing"));
diagonal = np.arange(n);
$.si(rows, $.tup($.add(pieces, diagonal), $.add(1, diagonal)), $.ga(regularisation, "ridge"));
return $.tup(rows, rhs); }, {p: ["regularisation", "n", "widths"], ks: false});
_smoothing = $.memo($.def(function (regularisation, n, widths) { let rows, _, product;
{const $v4 = $.unpack(smoothing_rows(regularisation, n, np.array(widths)), 2, -1);rows = $v4[0];_ = $v4[1];}
product = $.mm($.ga(rows, "T"), rows);
$.ga(product, "flags").writeable = false;
return product; }, {p: ["regularisation", "n", "widths"], ks: false}));
unit_ridge = $.memo($.def(function (family, n) { let weights, ridge;
weights = np.eye(n);
if ($.t($.eq(family, "pi-cumulative"))) {weights = $.isub(weights, $.km(np, "eye", [n], {"k": (-1)}));} else {if ($.t($.eq(family, "stop"))) {weights = $.neg(np.eye(n));
$.si(weights, 0, 1.0);}}
ridge = np.zeros($.tup($.add(1, n), $.add(1, n)));
$.si(ridge, $.tup($.slice(1, null, null), $.slice(1, null, null)), $.mm($.ga(weights, "T"), weights));
$.ga(ridge, "flags").writeable = false;
return ridge; }, {p: ["family", "n"], ks: false}));
Marks = $.gi($.ga(npt, "NDArray"), $.ga(np, "bool_"));
STATIC = "static";
{const $v5 = $.unpack($.tup("normal equations", "orthogonal factors"), 2, -1);NORMAL = $v5[0];ORTHOGONAL = $v5[1];}
LARGEST_CONDITION = 1000000.0;
HIGH_GAIN = 20.0;
ROUNDING = 1e-09;
OUTSIDE_SLOPE = 0.5;
Estimate = $.cls("Estimate", [], "", [["family", null], ["parameters", null], ["offset", null], ["weights", null], ["slopes", null], ["stop_weights", null], ["stop_slope", null], ["kkt_residual", null], ["route", () => NORMAL], ["condition", () => 1.0], ["passive", () => null]], true, true, ($c) => { Estimate = $c; });
fit_family = $.def(function (family, sums, eps, knots = null, regularisation = null, fold_ridge = 0.0, warm = null, triangle = null) { let problem, u, passive, kkt, condition, _, status;
problem = program(family, sums, eps, knots, regularisation, fold_ridge);
{const $v6 = $.unpack(_native.solve_bounded($.ga(problem, "gram"), $.ga(problem, "rhs"), $.ga(problem, "lower"), 1, $.ga(sums, "operators"), $.ga(problem, "basis"), $.ga(problem, "extra"), $.ga(problem, "extra_rhs"), warm, $.ga(problem, "target")), 6, -1);u = $v6[0];passive = $v6[1];kkt = $v6[2];condition = $v6[3];_ = $v6[4];status = $v6[5];}
if (($.t($.eq(status, 0)) && $.t($.le(condition, LARGEST_CONDITION)))) {return estimate_of(family, $.ga(sums, "operators"), u, kkt, NORMAL, condition, passive);}
if ($.t((triangle == null))) {throw $.exc(unsolved($.ga(sums, "operators")));}
{const $v7 = $.unpack(solve_family(family, triangle(), $.ga(sums, "operators"), eps, knots, regularisation, fold_ridge, $.ga(sums, "counted")), 2, -1);u = $v7[0];kkt = $v7[1];}
return estimate_of(family, $.ga(sums, "operators"), u, kkt, ORTHOGONAL, condition, null); }, {p: ["family", "sums", "eps", "knots", "regularisation", "fold_ridge", "warm", "triangle"], ks: false});
estimate_of = $.def(function (family, n, u, kkt, route, condition, passive) { let offset, plays, slopes, s, weights;
{const $v8 = $.unpack($.tup($.b.float($.gi(u, 0)), $.gi(u, $.slice(1, $.add(1, n), null)), $.gi(u, $.slice($.add(1, n), null, null))), 3, -1);offset = $v8[0];plays = $v8[1];slopes = $v8[2];}
if ($.t($.eq(family, "stop"))) {s = $.cm(plays, "copy", []);
$.si(s, 0, 0.0);
weights = $.neg(s);
$.si(weights, 0, $.add($.gi(plays, 0), $.b.float(np.sum(s))));
return Estimate(family, u, offset, weights, null, s, $.b.float($.gi(plays, 0)), kkt, route, condition, passive);}
weights = ($.t($.eq(family, "pi-cumulative")) ? $.km(np, "diff", [plays], {"prepend": 0.0}) : plays);
return Estimate(family, u, offset, weights, ($.t($.ga(slopes, "size")) ? slopes : null), null, null, kkt, route, condition, passive); }, {p: ["family", "n", "u", "kkt", "route", "condition", "passive"], ks: false});
gain_of = $.def(function (estimate) { let steepest;
if ($.t($.eq($.ga(estimate, "family"), STATIC))) {return $.div(1.0, $.b.float(np.min($.gi($.ga(estimate, "parameters"), $.slice(1, null, null)))));}
steepest = ($.t(($.ga(estimate, "slopes") == null)) ? 1.0 : $.b.max($.b.float(np.max($.ga(estimate, "slopes"))), OUTSIDE_SLOPE));
return $.div(steepest, $.b.max($.b.float(np.min(np.cumsum($.ga(estimate, "weights")))), 1e-300)); }, {p: ["estimate"], ks: false});
is_high = $.def(function (gain) { 
return $.gt(gain, $.mul(HIGH_GAIN, $.add(1.0, ROUNDING))); }, {p: ["gain"], ks: false});
map_points = $.def(function (knots, slopes) { let u, span, below, above;
u = $.add($.gi(knots, 0), np.concatenate([[0.0], np.cumsum($.mul(slopes, np.diff(knots)))]));
span = $.b.float($.sub($.gi(knots, (-1)), $.gi(knots, 0)));
below = $.sub($.gi(u, 0), $.mul(span, $.b.max($.b.float($.gi(slopes, 0)), OUTSIDE_SLOPE)));
above = $.add($.gi(u, (-1)), $.mul(span, $.b.max($.b.float($.gi(slopes, (-1))), OUTSIDE_SLOPE)));
return $.tup(np.concatenate([[below], u, [above]]), np.concatenate([[$.sub($.gi(knots, 0), span)], knots, [$.add($.gi(knots, (-1)), span)]])); }, {p: ["knots", "slopes"], ks: false});
mapped = $.def(function (estimate, u, knots) { let points, values;
if (($.t(($.ga(estimate, "slopes") == null)) || $.t((knots == null)))) {return u;}
{const $v9 = $.unpack(map_points(knots, $.ga(estimate, "slopes")), 2, -1);points = $v9[0];values = $v9[1];}
return continued($.add(u, $.gi(knots, 0)), points, values); }, {p: ["estimate", "u", "knots"], ks: false});
continued = $.def(function (u, points, values) { let inside, low, high, result;
inside = np.interp(u, points, values);
low = $.add($.gi(values, 0), $.div($.mul($.sub(u, $.gi(points, 0)), $.sub($.gi(values, 1), $.gi(values, 0))), $.sub($.gi(points, 1), $.gi(points, 0))));
high = $.add($.gi(values, (-1)), $.div($.mul($.sub(u, $.gi(points, (-1))), $.sub($.gi(values, (-1)), $.gi(values, (-2)))), $.sub($.gi(points, (-1)), $.gi(points, (-2)))));
result = np.where($.lt(u, $.gi(points, 0)), low, np.where($.gt(u, $.gi(points, (-1))), high, inside));
return result; }, {p: ["u", "points", "values"], ks: false});
CHUNK = 1024;
solve_family = $.def(function (family, system, operators, eps, knots = null, regularisation = null, fold_ridge = 0.0, samples = null) { let length, ridge, one, plays, y, rows, rhs, ramp, data, differences, stops, solution;
length = ($.t((samples == null)) ? $.b.float($.ga(np, "linalg").norm($.gi(system, $.tup($.slice(null, null, null), $.slice(null, 1, null))))) : $.b.float(np.sqrt(samples)));
if ($.t(fold_ridge)) {ridge = np.zeros($.tup(operators, $.gi($.ga(system, "shape"), 1)));
$.si(ridge, $.tup(np.arange(operators), $.add(1, np.arange(operators))), np.sqrt(fold_ridge));
system = np.vstack([system, ridge]);}
{const $v10 = $.unpack($.tup($.gi(system, $.tup($.slice(null, null, null), $.slice(null, 1, null))), $.gi(system, $.tup($.slice(null, null, null), $.slice(1, $.add(1, operators), null))), $.gi(system, $.tup($.slice(null, null, null), $.slice((-1), null, null)))), 3, -1);one = $v10[0];plays = $v10[1];y = $v10[2];}
if ($.t($.eq(family, "modified-pi"))) {if (($.t((knots == null)) || $.t((regularisation == null)))) {throw $.exc($.b.AssertionError("the modified model needs knots and a regularisation"));}
{const $v11 = $.unpack(smoothing_rows(regularisation, operators, np.diff(knots)), 2, -1);rows = $v11[0];rhs = $v11[1];}
ramp = $.gi(system, $.tup($.slice(null, null, null), $.slice($.add(1, operators), $.add(operators, $.ga(knots, "size")), null)));
data = np.hstack([one, plays, $.neg(ramp), np.zeros($.tup($.gi($.ga(system, "shape"), 0), 1))]);
system = np.vstack([data, $.mul(length, np.column_stack([rows, rhs]))]);} else {if ($.t($.eq(family, "pi-cumulative"))) {differences = $.cm(plays, "copy", []);
$.isi(differences, $.tup($.slice(null, null, null), $.slice(null, (-1), null)), $.isub, $.gi(plays, $.tup($.slice(null, null, null), $.slice(1, null, null))));
system = np.hstack([one, differences, y]);} else {if ($.t($.eq(family, "stop"))) {stops = $.sub($.gi(plays, $.tup($.slice(null, null, null), $.slice(null, 1, null))), plays);
$.si(stops, $.tup($.slice(null, null, null), 0), $.gi(plays, $.tup($.slice(null, null, null), 0)));
system = np.hstack([one, stops, y]);} else {system = np.hstack([one, plays, y]);}}}
solution = solve_bounded(system, 1, lower_bounds(family, operators, eps, $.sub($.sub($.gi($.ga(system, "shape"), 1), 2), operators)));
return $.tup(np.concatenate([$.ga(solution, "free"), $.ga(solution, "bounded")]), $.ga(solution, "kkt_residual")); }, {p: ["family", "system", "operators", "eps", "knots", "regularisation", "fold_ridge", "samples"], ks: false});
reduce = $.def(function (data, bank, knots = null, span = null) { let factor, size, piece, state, chosen, own, before, part, plays, y, ramps, block;
factor = null;
size = $.b.max(CHUNK, $.mul(2, $.ga($.ga(bank, "thresholds"), "size")));
for (const $v12 of $.it($.k($.b.zip, [$.ga(data, "pieces"), $.ga(bank, "states")], {"strict": true}))) { {const $v13 = $.unpack($v12, 2, -1);piece = $v13[0];state = $v13[1];}
{chosen = ($.t((span == null)) ? piece.fitted($.ga(bank, "initial_state")) : span(piece));
own = (piece.unknown_level($.ga(bank, "initial_state")) != null);
{const $v14 = $.unpack($.tup(factor, ($.t(own) ? null : factor)), 2, -1);before = $v14[0];factor = $v14[1];}
for (const $v15 of $.it(blocks($.ga(piece, "x"), $.ga(bank, "thresholds"), state, chosen, size))) { {const $v16 = $.unpack($v15, 2, -1);part = $v16[0];plays = $v16[1];}
{y = $.gi($.ga(piece, "y"), part);
ramps = ($.t((knots == null)) ? [] : [$.ga(ramp_columns(y, knots), "T")]);
block = np.hstack([np.ones($.tup($.ga(y, "size"), 1)), plays, ...$.it(ramps), $.gi(y, $.tup($.slice(null, null, null), null))]);
if ($.t(($.ga(piece, "weight") != null))) {block = $.imul(block, $.gi(np.sqrt($.gi($.ga(piece, "weight"), part)), $.tup($.slice(null, null, null), null)));}
factor = triangle(($.t((factor == null)) ? block : np.vstack([factor, block])));} }
if (($.t(own) && $.t((factor != null)))) {$.isi(factor, 0, $.imul, np.sqrt(TRACE));}
if (($.t(own) && $.t((before != null)))) {factor = ($.t((factor == null)) ? before : triangle(np.vstack([before, factor])));}} }
if ($.t((factor == null))) {throw $.exc($.b.AssertionError("no rows to fit"));}
return factor; }, {p: ["data", "bank", "knots", "span"], ks: false});
build_model = $.def(function (estimate, data, bank, knots, card) { let a, b, keep, thresholds, state, gain, weights, offset, inner, u, y;
{const $v17 = $.unpack($.tup($.ga(data, "half_range"), $.ga(data, "amplitude")), 2, -1);a = $v17[0];b = $v17[1];}
keep = $.ne($.ga(estimate, "weights"), 0.0);
$.si(keep, 0, true);
thresholds = $.mul($.gi($.ga(bank, "thresholds"), keep), a);
state = $.mul($.gi($.gi($.ga(bank, "states"), 0), keep), a);
if (($.t(($.ga(estimate, "stop_weights") != null)) && $.t(($.ga(estimate, "stop_slope") != null)))) {gain = $.div($.mul($.ga(data, "trend"), b), a);
return StopOperatorModel(thresholds, $.mul($.gi($.ga(estimate, "stop_weights"), keep), gain), $.mul($.ga(estimate, "stop_slope"), gain), $.add($.ga(data, "level"), $.mul($.mul($.ga(data, "trend"), b), $.ga(estimate, "offset"))), ($.t(state.any()) ? state : null), $.ga(data, "center"), card);}
if (($.t(($.ga(estimate, "slopes") == null)) || $.t((knots == null)))) {weights = $.mul($.gi($.ga(estimate, "weights"), keep), $.div($.mul($.ga(data, "trend"), b), a));
offset = $.add($.ga(data, "level"), $.mul($.mul($.ga(data, "trend"), b), $.ga(estimate, "offset")));
return PrandtlIshlinskii(thresholds, weights, offset, ($.t(state.any()) ? state : null), $.ga(data, "center"), card);}
inner = PrandtlIshlinskii(thresholds, $.mul($.gi($.ga(estimate, "weights"), keep), $.div(b, a)), $.mul(b, $.add($.ga(estimate, "offset"), $.b.float($.gi(knots, 0)))), ($.t(state.any()) ? state : null), $.ga(data, "center"));
{const $v18 = $.unpack(map_points(knots, $.ga(estimate, "slopes")), 2, -1);u = $v18[0];y = $v18[1];}
return $.k(ModifiedPrandtlIshlinskii, [inner], {"after": MonotoneMap($.mul(b, u), $.add($.ga(data, "level"), $.mul($.mul($.ga(data, "trend"), b), y))), "card": card}); }, {p: ["estimate", "data", "bank", "knots", "card"], ks: false});
Object.assign($m, {"annotations": annotations, "Callable": Callable, "dataclass": dataclass, "lru_cache": lru_cache, "np": np, "npt": npt, "_native": _native, "Array": Array_, "DataSet": DataSet, "Piece": Piece, "solve_bounded": solve_bounded, "triangle": triangle, "unsolved": unsolved, "TRACE": TRACE, "Bank": Bank, "NormalEquations": NormalEquations, "blocks": blocks, "ramp_columns": ramp_columns, "HysteresisModel": HysteresisModel, "ModelCard": ModelCard, "ModifiedPrandtlIshlinskii": ModifiedPrandtlIshlinskii, "MonotoneMap": MonotoneMap, "PrandtlIshlinskii": PrandtlIshlinskii, "StopOperatorModel": StopOperatorModel, "FAMILIES": FAMILIES, "BASIS": BASIS, "MAP_PIECES": MAP_PIECES, "SMALLEST_SLOPE": SMALLEST_SLOPE, "NORMALISATION": NORMALISATION, "Regularisation": Regularisation, "Program": Program, "lower_bounds": lower_bounds, "program": program, "smoothing_rows": smoothing_rows, "_smoothing": _smoothing, "unit_ridge": unit_ridge, "Marks": Marks, "STATIC": STATIC, "NORMAL": NORMAL, "ORTHOGONAL": ORTHOGONAL, "LARGEST_CONDITION": LARGEST_CONDITION, "HIGH_GAIN": HIGH_GAIN, "ROUNDING": ROUNDING, "OUTSIDE_SLOPE": OUTSIDE_SLOPE, "Estimate": Estimate, "fit_family": fit_family, "estimate_of": estimate_of, "gain_of": gain_of, "is_high": is_high, "map_points": map_points, "mapped": mapped, "continued": continued, "CHUNK": CHUNK, "solve_family": solve_family, "reduce": reduce, "build_model": build_model});
});
$.module("dehyst.identification.fit", ($m) => {
let annotations, Callable, Mapping, asdict, dataclass, field, replace, cached_property, TYPE_CHECKING, Any, np, npt, Array_, Mask, Plotted, Recording, ParameterError, Finding, Grade, grade_of, CREEP, LEAST, RATE, Evidence, Motion, Residual, residual_structure, HysteresisModel, ModelCard, PrandtlIshlinskii, ShearedPrandtlIshlinskii, StaticCurve, SPEEDS, Score, InputError, UNKNOWN, Certificate, Candidate, Option, LoopFacts, Refit, Refitting, Fit, size_of, word_of, _kept, _sheared;
Callable = $.from("collections.abc", "Callable");Mapping = $.from("collections.abc", "Mapping");
asdict = $.from("dataclasses", "asdict");dataclass = $.from("dataclasses", "dataclass");field = $.from("dataclasses", "field");replace = $.from("dataclasses", "replace");
cached_property = $.from("functools", "cached_property");
TYPE_CHECKING = $.from("typing", "TYPE_CHECKING");Any = $.from("typing", "Any");
np = $.imp("numpy");
npt = $.imp("numpy.typing");
Array_ = $.from("dehyst.arrays", "Array");Mask = $.from("dehyst.arrays", "Mask");
Plotted = $.from("dehyst.data.plotted", "Plotted");
Recording = $.from("dehyst.data.recording", "Recording");
ParameterError = $.from("dehyst.errors", "ParameterError");
Finding = $.from("dehyst.findings", "Finding");Grade = $.from("dehyst.findings", "Grade");grade_of = $.from("dehyst.findings", "grade_of");
CREEP = $.from("dehyst.identification.evidence", "CREEP");LEAST = $.from("dehyst.identification.evidence", "LEAST");RATE = $.from("dehyst.identification.evidence", "RATE");Evidence = $.from("dehyst.identification.evidence", "Evidence");
Motion = $.from("dehyst.identification.facts", "Motion");
Residual = $.from("dehyst.identification.residual", "Residual");residual_structure = $.from("dehyst.identification.residual", "residual_structure");
HysteresisModel = $.from("dehyst.models.base", "HysteresisModel");ModelCard = $.from("dehyst.models.card", "ModelCard");PrandtlIshlinskii = $.from("dehyst.models.prandtl_ishlinskii", "PrandtlIshlinskii");ShearedPrandtlIshlinskii = $.from("dehyst.models.sheared", "ShearedPrandtlIshlinskii");StaticCurve = $.from("dehyst.models.monotone", "StaticCurve");
SPEEDS = 1.5;
Score = $.cls("Score", [], "", [["rmse", null], ["rmse_percent", null], ["nrmse", null], ["max", null]], true, true, ($c) => { Score = $c; $.meth($c, "as_dict", $.def(function () { const self = this;
return $.dict([["rmse", $.ga(self, "rmse")], ["rmse_percent", $.ga(self, "rmse_percent")], ["nrmse", $.ga(self, "nrmse")], ["max", $.ga(self, "max")]]); }, {p: [], ks: false}));});
InputError = $.cls("InputError", [], "", [["rms_percent", null], ["bias_percent", null]], true, true, ($c) => { InputError = $c; $.prop($c, "without_bias_percent", $.def(function () { const self = this;
return $.b.float(np.sqrt($.b.max($.sub($.pow($.ga(self, "rms_percent"), 2), $.pow($.ga(self, "bias_percent"), 2)), 0.0))); }, {p: [], ks: false}));
$.meth($c, "times", $.def(function (ratio) { const self = this;
return InputError($.mul(ratio, $.ga(self, "rms_percent")), $.mul(ratio, $.ga(self, "bias_percent"))); }, {p: ["ratio"], ks: false}));
$.meth($c, "as_dict", $.def(function () { const self = this;
return $.dict([["rms_percent", $.ga(self, "rms_percent")], ["bias_percent", $.ga(self, "bias_percent")]]); }, {p: [], ks: false}));});
UNKNOWN = InputError($.b.float("nan"), $.b.float("nan"));
Certificate = $.cls("Certificate", [], "", [["kkt_residual", null], ["round_trip_error", null], ["inverse_gain", null], ["inverse_miss_percent", null], ["affordable_eps", null], ["nonzero_weights", null], ["operators", null], ["undetermined", null], ["initial_state", null], ["route", () => "orthogonal factors"], ["condition", () => $.b.float("inf")], ["enough_eps", () => null], ["enough_eps_cost", () => 0.0], ["strain", () => 0.0]], true, true, ($c) => { Certificate = $c; });
Candidate = $.cls("Candidate", [], "", [["family", null], ["initial_state", null], ["smoothing", null], ["error_percent", null], ["uncertainty_percent", null], ["chosen", () => false]], true, true, ($c) => { Candidate = $c; });
Option = $.cls("Option", [], "", [["family", null], ["direction", null], ["test_percent", null], ["input_percent", null], ["tracking_percent", null], ["exportable", null], ["chosen", null]], true, true, ($c) => { Option = $c; $.meth($c, "as_dict", $.def(function () { const self = this;
return asdict(self); }, {p: [], ks: false}));});
LoopFacts = $.cls("LoopFacts", [], "", [["orientation", null], ["trend", null], ["width_percent", null], ["loops", null], ["turns", null], ["drift_percent", null], ["motion", () => Motion()], ["evidence", () => $.tup()]], true, true, ($c) => { LoopFacts = $c; $.prop($c, "rate_dependence_percent", $.def(function () { const self = this;
return $.k($.b.max, [(function* () { for (const $v1 of $.it($.ga(self, "evidence"))) { let found; found = $v1; yield $.ga(found, "size_percent"); } })()], {"default": null}); }, {p: [], ks: false}));
$.prop($c, "depends", $.def(function () { const self = this;let found;
found = (() => { const $r = []; for (const $v2 of $.it($.ga(self, "evidence"))) { let each; each = $v2; if ($.t($.ga(each, "there"))) { $r.push(each); } } return $r; })();
if ($.t($.b.all((function* () { for (const $v3 of $.it(found)) { let each; each = $v3; yield $.ga(each, "told"); } })()))) {return $.b.tuple((function* () { for (const $v4 of $.it(found)) { let each; each = $v4; yield ("" + $.f($.ga(each, "size_percent"), ("" + ".2g"), -1) + " % of range depend on " + $.f($.ga(each, "words"), "", -1)); } })());}
return $.tup(("" + $.f($.b.max((function* () { for (const $v5 of $.it(found)) { let each; each = $v5; yield $.ga(each, "size_percent"); } })()), ("" + ".2g"), -1) + " % of range depend on rate or time")); }, {p: [], ks: false}));
$.meth($c, "lacking", $.def(function (low, high) { const self = this;let untold, what, lacks, why;
untold = (() => { const $r = []; for (const $v6 of $.it($.ga(self, "evidence"))) { let found; found = $v6; if (!$.t($.ga(found, "told"))) { $r.push($.ga(found, "words")); } } return $r; })();
if (($.t($.ga(self, "evidence")) && !$.t(untold))) {return "";}
what = ("" + "dependence on " + $.f($.or($.cm(" and ", "join", [untold]), () => "rate and time (creep)"), "", -1) + " cannot be told from hysteresis");
if ($.t($.b.any((function* () { for (const $v7 of $.it($.ga(self, "evidence"))) { let found; found = $v7; yield $.and($.ga(found, "there"), () => !$.t($.ga(found, "told"))); } })()))) {what = "rate and creep cannot be told apart";}
lacks = (() => { const $r = []; for (const $v8 of $.it($.tup($.tup(!$.t($.ga(self, "evidence")), ("" + "no time stamps, or fewer than " + $.f(LEAST, "", -1) + " samples that have them")), $.tup(($.ga($.ga(self, "motion"), "rests") === false), "no holds"), $.tup($.lt($.ga($.ga(self, "motion"), "speeds"), SPEEDS), "one speed only")))) { let lacking, words; {const $v9 = $.unpack($v8, 2, -1);lacking = $v9[0];words = $v9[1];} if ($.t(lacking)) { $r.push(words); } } return $r; })();
why = ($.t(lacks) ? ("" + " (" + $.f($.cm(", ", "join", [lacks]), "", -1) + ")") : "");
return ("" + $.f(what, "", -1) + " in this log" + $.f(why, "", -1) + "; dehyst design --range " + $.f(low, ("" + ".3g"), -1) + " " + $.f(high, ("" + ".3g"), -1) + " plans a motion that tells"); }, {p: ["low", "high"], ks: false}));});
Refit = $.cls("Refit", [], "", [["family", null], ["n", null], ["eps", null], ["model", null], ["train", null], ["test", null], ["inverse_gain", null], ["nonzero_weights", null], ["kkt_residual", null], ["condition", null], ["route", null], ["seconds", null]], true, true, ($c) => { Refit = $c; });
Refitting = $.gi(Callable, $.tup([$.bor($.b.int, null), $.bor($.b.float, null), $.bor($.b.str, null), $.bor($.ga(npt, "ArrayLike"), null)], Refit));
Fit = $.cls("Fit", [Plotted], "", [["family", null], ["model", null], ["recordings", null], ["predictions", null], ["inverse_predictions", null], ["train_masks", null], ["test_masks", null], ["train", null], ["test", null], ["static", null], ["static_train", null], ["static_test", null], ["certificate", null], ["facts", null], ["candidates", null], ["warnings", null], ["settings", () => $.b.dict()], ["verdict", () => ""], ["refitter", () => null], ["shear_choice", () => null], ["input_train", () => UNKNOWN], ["input_test", () => null], ["curve_input", () => UNKNOWN], ["table", () => $.tup()], ["details", () => $.b.dict()]], true, true, ($c) => { Fit = $c; $.prop($c, "grade", $.def(function () { const self = this;
return grade_of($.ga(self, "verdict")); }, {p: [], ks: false}));
$.prop($c, "direction", $.def(function () { const self = this;
return $.b.str($.ga($.ga(self, "model"), "direction")); }, {p: [], ks: false}));
$.prop($c, "size", $.def(function () { const self = this;let c;
c = $.ga(self, "certificate");
return ($.t($.ga(c, "operators")) ? size_of($.ga(self, "model"), $.ga(c, "nonzero_weights"), $.ga(c, "operators")) : ""); }, {p: [], ks: false}));
$.prop($c, "evidence", $.def(function () { const self = this;
return $.ga($.ga(self, "facts"), "evidence"); }, {p: [], ks: false}));
$.prop($c, "evidence_words", $.def(function () { const self = this;let has, kinds;
has = $.dict([[RATE, $.tup("viscous", "rate")], [CREEP, $.tup("creep", "relax")]]);
kinds = $.ga($.ga(self, "model"), "kinds");
return $.b.tuple((function* () { for (const $v11 of $.it($.ga($.ga(self, "facts"), "evidence"))) { let found; found = $v11; yield ("" + $.f(found, "", -1) + $.f(_kept(found, $.b.any((function* () { for (const $v10 of $.it($.gi(has, $.ga(found, "group")))) { let k; k = $v10; yield $.in(k, kinds); } })())), "", -1)); } })()); }, {p: [], ks: false}));
$.prop($c, "lacking", $.def(function () { const self = this;let card;
card = $.ga($.ga($.ga(self, "model"), "card"), "input");
return (($.t(($.ga(card, "low") == null)) || $.t(($.ga(card, "high") == null))) ? "" : $.ga(self, "facts").lacking($.ga(card, "low"), $.ga(card, "high"))); }, {p: [], ks: false}));
$.prop($c, "output_error", $.def(function () { const self = this;
return $.or($.ga(self, "test"), () => $.ga(self, "train")); }, {p: [], ks: false}));
$.prop($c, "tracking", $.def(function () { const self = this;
return $.b.next((function* () { for (const $v12 of $.it($.ga(self, "table"))) { let row; row = $v12; if ($.t($.ga(row, "chosen"))) { yield $.ga(row, "tracking_percent"); } } })(), null); }, {p: [], ks: false}));
$.prop($c, "input_error", $.def(function () { const self = this;
return $.or($.ga(self, "input_test"), () => $.ga(self, "input_train")); }, {p: [], ks: false}));
$.cached($c, "residual", $.def(function () { const self = this;let score;
score = $.or($.ga(self, "test"), () => $.ga(self, "train"));
return $.k(residual_structure, [$.ga(self, "recordings"), $.ga(self, "predictions"), ($.t($.ga(self, "test")) ? $.ga(self, "test_masks") : $.ga(self, "train_masks")), ($.t($.gt($.ga(score, "rmse_percent"), 0.0)) ? $.div($.mul(100.0, $.ga(score, "rmse")), $.ga(score, "rmse_percent")) : 1.0)], {"part": ($.t($.ga(self, "test")) ? "held-out" : "fitted"), "knows_time": $.ga($.ga(self, "model"), "rate_dependent")}); }, {p: [], ks: false}));
$.meth($c, "refit", $.def(function (n = null, eps = null, family = null, thresholds = null) { const self = this;let found;
if ($.t(($.ga(self, "refitter") == null))) {throw $.exc(ParameterError("this fit holds no sums over its data: fits of plays by dehyst.identify do, curves without memory and those by identify_stream do not. Identify again with the other settings."));}
if ($.t($.b.isinstance(n, $.b.str))) {throw $.exc(ParameterError(("" + "n = " + $.f(n, "", 114) + ": a refit takes a whole number. Numbers are compared by identify(recording, n='auto').")));}
if (($.t((n != null)) && $.t((thresholds != null)))) {throw $.exc(ParameterError(("" + "n = " + $.f(n, "", -1) + " and thresholds were both given; thresholds are their own number. Pass one.")));}
found = self.refitter(n, eps, family, thresholds);
if ($.t(($.ga($.ga(self, "model"), "shear") != null))) {found = _sheared(found, $.ga($.ga(self, "model"), "shear"));}
return $.k(replace, [found], {"model": $.ga(found, "model").with_card(self._card_of(found))}); }, {p: ["n", "eps", "family", "thresholds"], ks: false}));
$.meth($c, "_card_of", $.def(function (found) { const self = this;let card, given, settings;
card = $.ga($.ga(self, "model"), "card");
given = $.b.dict($.ga(card, "provenance"));
settings = $.dict([...$.pairs($.b.dict($.cm(given, "get", ["settings", $.dict([])]))), ["family", $.ga(found, "family")], ["n", $.ga(found, "n")], ["eps", $.ga(found, "eps")]]);
given = $.ibor(given, $.dict([["settings", settings], ["identified_family", $.ga(found, "family")], ["train", $.ga(found, "train").as_dict()], ["test", ($.t(($.ga(found, "test") == null)) ? null : $.ga(found, "test").as_dict())], ["verdict", "a refit, which is not judged; see the scores"]]));
return $.k(replace, [card], {"provenance": given}); }, {p: ["found"], ks: false}));
$.meth($c, "__repr__", $.def(function () { const self = this;let where;
where = ($.t(($.ga(self, "test") == null)) ? "fitted" : "held out");
return ("" + "<Fit " + $.f($.ga(self, "family"), "", 114) + ": " + $.f($.or($.ga(self, "size"), () => "a curve"), "", -1) + ", " + $.f($.ga($.ga(self, "output_error"), "rmse_percent"), ("" + ".2f"), -1) + " % of range rms " + $.f(where, "", -1) + ", " + $.f($.b.len($.ga(self, "warnings")), "", -1) + " warning" + $.f(($.t($.eq($.b.len($.ga(self, "warnings")), 1)) ? "" : "s"), "", -1) + ">"); }, {p: [], ks: false}));
$.meth($c, "__str__", $.def(function () { const self = this;let unit, lines, name, score, rms, codes;
unit = $.ga($.gi($.ga(self, "recordings"), 0), "output_unit");
lines = [$.or($.ga(self, "verdict"), () => $.b.repr(self))];
for (const $v13 of $.it($.tup($.tup("fitted", $.ga(self, "train")), $.tup("held out", $.ga(self, "test"))))) { {const $v14 = $.unpack($v13, 2, -1);name = $v14[0];score = $v14[1];}
{if ($.t((score != null))) {rms = $.cm(("" + $.f($.ga(score, "rmse"), ("" + ".4g"), -1) + " " + $.f(unit, "", -1)), "rstrip", []);
$.cm(lines, "append", [$.cm(("" + $.f(name, "", -1) + ": rms " + $.f(rms, "", -1) + ", " + $.f($.ga(score, "rmse_percent"), ("" + ".2f"), -1) + " % of range, max " + $.f($.ga(score, "max"), ("" + ".4g"), -1) + " " + $.f(unit, "", -1)), "rstrip", [])]);}} }
$.cm(lines, "append", [("" + "model: " + $.f($.ga(self, "model"), "", 114))]);
codes = $.b.dict.fromkeys((function* () { for (const $v15 of $.it($.ga(self, "warnings"))) { let finding; finding = $v15; yield $.ga(finding, "code"); } })());
$.cm(lines, "append", [("" + "warnings: " + $.f($.or($.cm(", ", "join", [codes]), () => "none"), "", -1))]);
return $.cm("\n", "join", [lines]); }, {p: [], ks: false}));
$.meth($c, "as_dict", $.def(function () { const self = this;
return $.dict([["family", $.ga(self, "family")], ["n", $.ga($.ga(self, "certificate"), "operators")], ["nonzero_weights", $.ga($.ga(self, "certificate"), "nonzero_weights")], ["train", $.ga(self, "train").as_dict()], ["test", ($.t(($.ga(self, "test") == null)) ? null : $.ga(self, "test").as_dict())], ["static_train", $.ga(self, "static_train").as_dict()], ["static_test", ($.t(($.ga(self, "static_test") == null)) ? null : $.ga(self, "static_test").as_dict())], ["kkt_residual", $.ga($.ga(self, "certificate"), "kkt_residual")], ["round_trip_error", $.ga($.ga(self, "certificate"), "round_trip_error")], ["inverse_gain", $.ga($.ga(self, "certificate"), "inverse_gain")], ["inverse_miss_percent", $.ga($.ga(self, "certificate"), "inverse_miss_percent")], ["purpose", $.b.str($.cm($.ga(self, "settings"), "get", ["purpose", "compensate"]))], ["direction", $.ga(self, "direction")], ["elements", $.b.list($.ga($.ga(self, "model"), "kinds"))], ["dead_time_s", $.ga($.ga(self, "model"), "dead_time")], ["residual", $.ga(self, "residual").as_dict()], ["input_error", $.dict([["train", $.ga(self, "input_train").as_dict()], ["test", ($.t(($.ga(self, "input_test") == null)) ? null : $.ga(self, "input_test").as_dict())]])], ["tracking_percent", $.ga(self, "tracking")], ["table", (() => { const $r = []; for (const $v16 of $.it($.ga(self, "table"))) { let row; row = $v16; $r.push(row.as_dict()); } return $r; })()], ["grade", ($.t(($.ga(self, "grade") == null)) ? null : $.b.str($.ga(self, "grade")))], ["initial_state", $.ga($.ga(self, "certificate"), "initial_state")], ["route", $.ga($.ga(self, "certificate"), "route")], ["condition", $.ga($.ga(self, "certificate"), "condition")], ["shear", $.ga($.ga(self, "model"), "shear")], ["shears", ($.t(($.ga(self, "shear_choice") == null)) ? [] : $.ga(self, "shear_choice").as_list())], ["verdict", $.ga(self, "verdict")], ["evidence", (() => { const $r = []; for (const $v17 of $.it($.ga($.ga(self, "facts"), "evidence"))) { let found; found = $v17; $r.push(found.as_dict()); } return $r; })()], ["warnings", (() => { const $r = []; for (const $v18 of $.it($.ga(self, "warnings"))) { let finding; finding = $v18; $r.push(finding.as_dict()); } return $r; })()], ...$.pairs($.ga(self, "details"))]); }, {p: [], ks: false}));});
size_of = $.def(function (model, nonzero, offered) { let word;
word = word_of(model);
return (($.t($.eq(word, "terms")) && $.t($.eq(nonzero, offered))) ? ("" + $.f(offered, "", -1) + " parameters") : ("" + $.f(nonzero, "", -1) + " of " + $.f(offered, "", -1) + " " + $.f(word, "", -1))); }, {p: ["model", "nonzero", "offered"], ks: false});
word_of = $.def(function (model) { 
return ($.t(($.ga(model, "play_core") == null)) ? "terms" : "operators"); }, {p: ["model"], ks: false});
_kept = $.def(function (found, kept) { 
if ($.t($.eq(kept, $.ga(found, "there")))) {return "";}
if ($.t(kept)) {return "; the model has a term of it, which made the fit better";}
return ($.t($.ga(found, "told")) ? "; not in the model, whose other terms do as well there" : ""); }, {p: ["found", "kept"], ks: false});
_sheared = $.def(function (found, k) { let model;
if (!$.t($.b.isinstance($.ga(found, "model"), PrandtlIshlinskii))) {throw $.exc(ParameterError(("" + "a sheared loop is refitted with the families pi and pi-cumulative, not with '" + $.f($.ga(found, "family"), "", -1) + "': its inverse less k y is no sum of plays.")));}
model = ShearedPrandtlIshlinskii($.ga(found, "model"), k);
return $.k(replace, [found], {"model": model, "inverse_gain": $.ga(model, "inverse_gain")}); }, {p: ["found", "k"], ks: false});
Object.assign($m, {"annotations": annotations, "Callable": Callable, "Mapping": Mapping, "asdict": asdict, "dataclass": dataclass, "field": field, "replace": replace, "cached_property": cached_property, "TYPE_CHECKING": TYPE_CHECKING, "Any": Any, "np": np, "npt": npt, "Array": Array_, "Mask": Mask, "Plotted": Plotted, "Recording": Recording, "ParameterError": ParameterError, "Finding": Finding, "Grade": Grade, "grade_of": grade_of, "CREEP": CREEP, "LEAST": LEAST, "RATE": RATE, "Evidence": Evidence, "Motion": Motion, "Residual": Residual, "residual_structure": residual_structure, "HysteresisModel": HysteresisModel, "ModelCard": ModelCard, "PrandtlIshlinskii": PrandtlIshlinskii, "ShearedPrandtlIshlinskii": ShearedPrandtlIshlinskii, "StaticCurve": StaticCurve, "SPEEDS": SPEEDS, "Score": Score, "InputError": InputError, "UNKNOWN": UNKNOWN, "Certificate": Certificate, "Candidate": Candidate, "Option": Option, "LoopFacts": LoopFacts, "Refit": Refit, "Refitting": Refitting, "Fit": Fit, "size_of": size_of, "word_of": word_of, "_kept": _kept, "_sheared": _sheared});
});
$.module("dehyst.identification.least_squares", ($m) => {
let annotations, dataclass, np, _native, Array_, IdentificationError, NOTHING_LEFT, NO_EFFECT, DEPENDENT, HELD, ROWS, OPTIMAL, Solution, triangle, solve_bounded, _active, _nonnegative, unsolved, _held, _polish, _kkt_residual;
dataclass = $.from("dataclasses", "dataclass");
np = $.imp("numpy");
_native = $.imp("dehyst._native");
Array_ = $.from("dehyst.arrays", "Array");
IdentificationError = $.from("dehyst.errors", "IdentificationError");
NOTHING_LEFT = 1e-10;
NO_EFFECT = 1e-12;
{const $v1 = $.unpack($.tup(1e-10, 1e-07), 2, -1);DEPENDENT = $v1[0];HELD = $v1[1];}
ROWS = 8192;
OPTIMAL = 1e-13;
Solution = $.cls("Solution", [], "", [["free", null], ["bounded", null], ["kkt_residual", null]], true, true, ($c) => { Solution = $c; });
triangle = $.def(function (rows) { let kept, begin;
kept = $.gi(rows, $.slice(null, ROWS, null));
for (const $v2 of $.it($.b.range(ROWS, $.gi($.ga(rows, "shape"), 0), ROWS))) { begin = $v2;
{kept = np.vstack([$.km($.ga(np, "linalg"), "qr", [kept], {"mode": "r"}), $.gi(rows, $.slice(begin, $.add(begin, ROWS), null))]);} }
return $.km(np, "asarray", [$.km($.ga(np, "linalg"), "qr", [kept], {"mode": "r"})], {"dtype": $.ga(np, "float64")}); }, {p: ["rows"], ks: false});
solve_bounded = $.def(function (system, free, lower) { let reduced, r, n, inner, target, shifted, lengths, scale, w, right, a;
reduced = $.and($.le($.gi($.ga(system, "shape"), 0), $.gi($.ga(system, "shape"), 1)), () => !$.t(np.any(np.tril($.gi(system, $.tup($.slice(null, null, null), $.slice(null, free, null))), (-1)))));
r = ($.t(reduced) ? system : triangle(system));
n = $.ga(lower, "size");
if ($.t($.lt($.gi($.ga(r, "shape"), 0), $.gi($.ga(system, "shape"), 1)))) {r = np.vstack([r, np.zeros($.tup($.sub($.gi($.ga(system, "shape"), 1), $.gi($.ga(r, "shape"), 0)), $.gi($.ga(system, "shape"), 1)))]);}
if ($.t(free)) {r = _held(r, free);}
{const $v3 = $.unpack($.tup($.gi(r, $.tup($.slice(free, null, null), $.slice(free, $.add(free, n), null))), $.gi(r, $.tup($.slice(free, null, null), (-1)))), 2, -1);inner = $v3[0];target = $v3[1];}
shifted = $.sub(target, $.mm(inner, lower));
lengths = $.km($.ga(np, "linalg"), "norm", [inner], {"axis": 0});
inner = np.where($.gt(lengths, $.mul(NOTHING_LEFT, $.km($.ga(np, "linalg"), "norm", [$.gi(r, $.tup($.slice(null, null, null), $.slice(free, $.add(free, n), null)))], {"axis": 0}))), inner, 0.0);
scale = np.where($.gt(lengths, 0), lengths, 1.0);
w = $.add(lower, _polish(inner, shifted, $.div(_active($.div(inner, scale), shifted), scale)));
if (!$.t($.le(_kkt_residual(inner, target, w, lower), OPTIMAL))) {w = $.add(lower, _polish(inner, shifted, $.div(_nonnegative($.div(inner, scale), shifted), scale)));}
right = $.sub($.gi(r, $.tup($.slice(null, free, null), (-1))), $.mm($.gi(r, $.tup($.slice(null, free, null), $.slice(free, $.add(free, n), null))), w));
a = ($.t(free) ? np.asarray($.ga(np, "linalg").solve($.gi(r, $.tup($.slice(null, free, null), $.slice(null, free, null))), right)) : right);
return Solution(a, w, _kkt_residual(inner, target, w, lower)); }, {p: ["system", "free", "lower"], ks: false});
_active = $.def(function (columns, target) { let lower, norm;
{const $v4 = $.unpack($.tup(np.zeros($.gi($.ga(columns, "shape"), 1)), $.b.max($.b.float($.ga(np, "linalg").norm(target)), 1e-150)), 2, -1);lower = $v4[0];norm = $v4[1];}
return $.gi($.km(_native, "solve_bounded", [$.mm($.ga(columns, "T"), columns), $.mm($.ga(columns, "T"), target), lower, 0, 0, $.ga(_native, "WEIGHTS")], {"target_norm": norm}), 0); }, {p: ["columns", "target"], ks: false});
_nonnegative = $.def(function (columns, target) { let nnls, n, weights, fault;
nnls = $.from("scipy.optimize", "nnls");
n = $.gi($.ga(columns, "shape"), 1);
try {weights = $.gi($.k(nnls, [columns, target], {"maxiter": $.add($.mul(30, n), 100)}), 0);} catch ($e) { $e = $.caught($e); if ($.isinst($e, $.b.RuntimeError)) { fault = $e; {throw $.exc(unsolved(n, ("" + " (" + $.f(fault, "", -1) + ")")));} } else throw $e; }
return weights; }, {p: ["columns", "target"], ks: false});
unsolved = $.def(function (n, why = "") { 
return $.k(IdentificationError, [("" + "the quadratic program with " + $.f(n, "", -1) + " weights did not reach its optimum" + $.f(why, "", -1) + ". The operators are too alike for this data: identify fewer (--n " + $.f($.b.max(2, $.fdiv(n, 2)), "", -1) + "), or give thresholds that lie further apart.")], {"operators": n}); }, {p: ["n", "why"], ks: false});
_held = $.def(function (r, free) { let longest, rows;
longest = $.b.float(np.max($.km($.ga(np, "linalg"), "norm", [$.gi(r, $.tup($.slice(null, null, null), $.slice(null, free, null)))], {"axis": 0})));
if ($.t($.gt(np.abs($.gi(np.diag(r), $.slice(null, free, null))).min(), $.mul(DEPENDENT, longest)))) {return r;}
rows = np.zeros($.tup(free, $.gi($.ga(r, "shape"), 1)));
$.si(rows, $.tup($.slice(null, null, null), $.slice(null, free, null)), $.mul(np.eye(free), ($.t($.gt(longest, 0.0)) ? $.mul(HELD, longest) : 1.0)));
return triangle(np.vstack([r, rows])); }, {p: ["r", "free"], ks: false});
_polish = $.def(function (inner, target, v) { let effect, support, q, r, diagonal, better;
effect = $.mul(v, $.km($.ga(np, "linalg"), "norm", [inner], {"axis": 0}));
support = np.flatnonzero($.gt(effect, $.mul(NO_EFFECT, $.ga(np, "linalg").norm(target))));
if ($.t($.eq($.ga(support, "size"), 0))) {return v;}
{const $v5 = $.unpack($.ga(np, "linalg").qr($.gi(inner, $.tup($.slice(null, null, null), support))), 2, -1);q = $v5[0];r = $v5[1];}
diagonal = np.abs(np.diag(r));
if ($.t($.le(diagonal.min(), $.mul(1e-13, diagonal.max())))) {return v;}
better = np.zeros_like(v);
$.si(better, support, $.ga(np, "linalg").solve(r, $.mm($.ga(q, "T"), target)));
return ($.t(np.all($.gt($.gi(better, support), 0))) ? better : v); }, {p: ["inner", "target", "v"], ks: false});
_kkt_residual = $.def(function (inner, target, w, lower) { let gradient, scale, relative, violation;
gradient = $.mm($.ga(inner, "T"), $.sub($.mm(inner, w), target));
scale = $.mul($.km($.ga(np, "linalg"), "norm", [inner], {"axis": 0}), $.b.max($.b.float($.ga(np, "linalg").norm(target)), 1e-300));
relative = np.where($.gt(scale, 0), $.div(gradient, np.where($.gt(scale, 0), scale, 1.0)), 0.0);
violation = np.where($.gt(w, lower), np.abs(relative), np.maximum($.neg(relative), 0.0));
return $.b.float($.km(np, "max", [violation], {"initial": 0.0})); }, {p: ["inner", "target", "w", "lower"], ks: false});
Object.assign($m, {"annotations": annotations, "dataclass": dataclass, "np": np, "_native": _native, "Array": Array_, "IdentificationError": IdentificationError, "NOTHING_LEFT": NOTHING_LEFT, "NO_EFFECT": NO_EFFECT, "DEPENDENT": DEPENDENT, "HELD": HELD, "ROWS": ROWS, "OPTIMAL": OPTIMAL, "Solution": Solution, "triangle": triangle, "solve_bounded": solve_bounded, "_active": _active, "_nonnegative": _nonnegative, "unsolved": unsolved, "_held": _held, "_polish": _polish, "_kkt_residual": _kkt_residual});
});
$.module("dehyst.identification.memory", ($m) => {
let annotations, Callable, Literal, NamedTuple, get_args, np, Array_, InitialState, INITIAL_STATES, VISITED, LOOPS, NEARLY, state_before, known_from, Known, known_within, known_of, known_after_break, _first, largest_radius;
Callable = $.from("collections.abc", "Callable");
Literal = $.from("typing", "Literal");NamedTuple = $.from("typing", "NamedTuple");get_args = $.from("typing", "get_args");
np = $.imp("numpy");
Array_ = $.from("dehyst.arrays", "Array");
InitialState = $.gi(Literal, $.tup("zero", "origin", "rest", "rising", "falling", "unknown"));
INITIAL_STATES = get_args(InitialState);
VISITED = 0.02;
LOOPS = 0.1;
NEARLY = 0.9;
state_before = $.def(function (kind, thresholds, first, low, high, origin = 0.0) { let z, turn;
if ($.t($.eq(kind, "zero"))) {return np.zeros($.ga(thresholds, "size"));}
if ($.t($.eq(kind, "origin"))) {return np.full($.ga(thresholds, "size"), origin);}
if ($.t($.eq(kind, "rest"))) {return np.full($.ga(thresholds, "size"), first);}
z = np.zeros($.ga(thresholds, "size"));
for (const $v1 of $.it(($.t($.eq(kind, "falling")) ? $.tup(low, high, first) : $.tup(high, low, first)))) { turn = $v1;
{z = np.maximum($.sub(turn, thresholds), np.minimum($.add(turn, thresholds), z));} }
return z; }, {p: ["kind", "thresholds", "first", "low", "high", "origin"], ks: false});
known_from = $.def(function (x, low, high) { let slack;
slack = $.mul(VISITED, $.sub(high, low));
return $.b.max($.k(_first, [x, $.add(low, slack)], {"below": true}), $.k(_first, [x, $.sub(high, slack)], {"below": false})); }, {p: ["x", "low", "high"], ks: false});
Known = $.cls("Known", [], "NamedTuple", [["begin", null], ["within", null]], false, true, ($c) => { Known = $c; });
known_within = $.def(function (x) { 
return known_of($.ga(x, "size"), $.b.float(x.min()), $.b.float(x.max()), $.def((a, b) => {  return known_from(x, a, b); }, {p: ["a", "b"], ks: false})); }, {p: ["x"], ks: false});
known_of = $.def(function (size, low, high, visited) { let whole, own;
whole = visited((-1.0), 1.0);
if (($.t($.le($.mul(2, whole), size)) || $.t($.lt($.sub(high, low), $.mul(2.0, LOOPS))))) {return Known(whole, null);}
own = visited(low, high);
return ($.t($.gt($.sub(whole, own), $.sub(size, whole))) ? Known(own, $.tup(low, high)) : Known(whole, null)); }, {p: ["size", "low", "high", "visited"], ks: false});
known_after_break = $.def(function (x) { let whole, low, high;
{const $v2 = $.unpack($.tup(known_from(x, (-1.0), 1.0), $.b.float(x.min()), $.b.float(x.max())), 3, -1);whole = $v2[0];low = $v2[1];high = $v2[2];}
if (($.t($.le($.mul(2, whole), $.ga(x, "size"))) || $.t($.lt($.sub(high, low), $.mul(2.0, NEARLY))))) {return whole;}
return $.b.min(whole, known_from(x, low, high)); }, {p: ["x"], ks: false});
_first = $.def(function (x, bound, below) { let begin, size, part, found;
{const $v3 = $.unpack($.tup(0, 1024), 2, -1);begin = $v3[0];size = $v3[1];}
while ($.t($.lt(begin, $.ga(x, "size")))) {part = $.gi(x, $.slice(begin, $.add(begin, size), null));
found = np.flatnonzero(($.t(below) ? $.le(part, bound) : $.ge(part, bound)));
if ($.t($.ga(found, "size"))) {return $.add(begin, $.b.int($.gi(found, 0)));}
{const $v4 = $.unpack($.tup($.add(begin, size), $.mul(2, size)), 2, -1);begin = $v4[0];size = $v4[1];}}
return $.b.int($.ga(x, "size")); }, {p: ["x", "bound", "below"], ks: false});
largest_radius = $.def(function (kind, first, low, high) { let origin;
origin = ($.t($.eq(kind, "rest")) ? first : 0.0);
return $.b.max($.b.abs($.sub(high, origin)), $.b.abs($.sub(low, origin))); }, {p: ["kind", "first", "low", "high"], ks: false});
Object.assign($m, {"annotations": annotations, "Callable": Callable, "Literal": Literal, "NamedTuple": NamedTuple, "get_args": get_args, "np": np, "Array": Array_, "InitialState": InitialState, "INITIAL_STATES": INITIAL_STATES, "VISITED": VISITED, "LOOPS": LOOPS, "NEARLY": NEARLY, "state_before": state_before, "known_from": known_from, "Known": Known, "known_within": known_within, "known_of": known_of, "known_after_break": known_after_break, "_first": _first, "largest_radius": largest_radius});
});
$.module("dehyst.identification.mending", ($m) => {
let annotations, dataclass, replace, pairwise, np, npt, _native, Array_, Mask, Rows, turning_points, bridged, find_outliers, robust_range, Recording, Finding, single_blas, CHANGED, CERTAIN, LASTS, SPEED, SWING, CYCLES, MOST_CYCLES, MOST_ROWS, PLAYS, HINGES, FAR, COMPARED, RIDGE, Change, changed_at, _changed_at, _judged, _terms, _ridged, _weights, _left, _seen, about_change, _cut, AT_REST, STAYS, FEWEST, SHARE, DRIVEN, SWINGS, FOLLOWED, BINS, stopped_at, _levels, about_stop, SHOWN, ENDED, mended, _ended, _bridged, _outliers, _shown, _numbers;
dataclass = $.from("dataclasses", "dataclass");replace = $.from("dataclasses", "replace");
pairwise = $.from("itertools", "pairwise");
np = $.imp("numpy");
npt = $.imp("numpy.typing");
_native = $.imp("dehyst._native");
Array_ = $.from("dehyst.arrays", "Array");Mask = $.from("dehyst.arrays", "Mask");Rows = $.from("dehyst.arrays", "Rows");
turning_points = $.from("dehyst.data.loops", "turning_points");
bridged = $.from("dehyst.data.outliers", "bridged");find_outliers = $.from("dehyst.data.outliers", "find_outliers");
robust_range = $.from("dehyst.data.ranges", "robust_range");
Recording = $.from("dehyst.data.recording", "Recording");
Finding = $.from("dehyst.findings", "Finding");
single_blas = $.from("dehyst.identification.threads", "single_blas");
CHANGED = 0.15;
CERTAIN = 3.0;
LASTS = 0.5;
SPEED = 1.5;
SWING = 0.3;
CYCLES = 3;
{const $v1 = $.unpack($.tup(200, 20000), 2, -1);MOST_CYCLES = $v1[0];MOST_ROWS = $v1[1];}
{const $v2 = $.unpack($.tup(10, 8), 2, -1);PLAYS = $v2[0];HINGES = $v2[1];}
FAR = 1.5;
COMPARED = 0.5;
RIDGE = 1e-09;
Change = $.cls("Change", [], "", [["begin", null], ["place", null], ["size", null]], true, true, ($c) => { Change = $c; });
changed_at = $.def(function (x, y) { 
{ const $v3 = single_blas(); $.enter($v3); try {return _changed_at(x, y);} catch ($e) { if (!$.exit($v3, $.caught($e))) throw $e; } } }, {p: ["x", "y"], ks: false});
_changed_at = $.def(function (x, y) { let span, kept, reach, turns, marks, terms, joint, sums, cuts, best, cut, found, begin, place, size;
span = robust_range([y]);
kept = np.arange(0, $.ga(x, "size"), $.b.max(1, $.fdiv($.ga(x, "size"), MOST_ROWS)));
{const $v4 = $.unpack($.tup($.gi(x, kept), $.gi(y, kept)), 2, -1);x = $v4[0];y = $v4[1];}
reach = robust_range([x]);
if (!($.t($.gt(reach, 0.0)) && $.t($.gt(span, 0.0)))) {return null;}
turns = $.gi(turning_points(x, $.mul(SWING, reach)), $.slice(1, (-1), null));
marks = np.unique(np.concatenate([[0], $.gi(turns, $.slice(null, null, $.mul(2, $.b.max(1, $.fdiv($.ga(turns, "size"), $.mul(2, MOST_CYCLES)))))), [$.ga(x, "size")]]));
if ($.t($.le($.ga(marks, "size"), $.mul(2, CYCLES)))) {return null;}
terms = _terms(x, reach);
joint = np.column_stack([terms, $.div(y, span)]);
sums = $.km(np, "cumsum", [(() => { const $r = []; for (const $v5 of $.it(pairwise(marks))) { let a, b; {const $v6 = $.unpack($v5, 2, -1);a = $v6[0];b = $v6[1];} $r.push($.mm($.ga($.gi(joint, $.slice(a, b, null)), "T"), $.gi(joint, $.slice(a, b, null)))); } return $r; })()], {"axis": 0});
cuts = np.arange(CYCLES, $.sub($.ga(marks, "size"), CYCLES));
best = $.b.int($.gi(cuts, np.argmin((() => { const $r = []; for (const $v7 of $.it(cuts)) { let c; c = $v7; $r.push($.add(_left($.gi(sums, $.sub(c, 1))), _left($.sub($.gi(sums, (-1)), $.gi(sums, $.sub(c, 1)))))); } return $r; })())));
for (const $v8 of $.it($.tup($.sub(best, 1), best))) { cut = $v8;
{found = _judged(x, $.div(y, span), terms, marks, cut, $.gi(sums, $.sub(cut, 1)), $.sub($.gi(sums, (-1)), $.gi(sums, cut)));
if ($.t((found != null))) {{const $v9 = $.unpack(found, 3, -1);begin = $v9[0];place = $v9[1];size = $v9[2];}
return Change($.b.int($.gi(kept, begin)), $.b.int($.gi(kept, place)), size);}} }
return null; }, {p: ["x", "y"], ks: false});
_judged = $.def(function (x, y, terms, marks, cut, before, after) { let begin, span, error, own, last, usual, known, cycles, sizes, speeds, limit;
begin = $.b.int($.gi(marks, cut));
span = robust_range([$.gi(y, $.slice(null, begin, null))]);
if (!$.t($.gt(span, 0.0))) {return null;}
error = $.div(np.abs($.sub(y, $.mm(terms, _weights(before)))), span);
own = np.concatenate([$.gi(error, $.slice(null, begin, null)), $.div($.gi(np.abs($.sub(y, $.mm(terms, _weights(after)))), $.slice($.gi(marks, $.add(cut, 1)), null, null)), span)]);
last = $.gi(error, $.slice($.gi(marks, $.sub(cut, 1)), begin, null));
usual = $.b.float(np.quantile(own, 0.95));
known = _seen(terms, begin, before);
cycles = (() => { const $r = []; for (const $v10 of $.it(pairwise($.gi(marks, $.slice(cut, null, null))))) { let a, b; {const $v11 = $.unpack($v10, 2, -1);a = $v11[0];b = $v11[1];} $r.push($.b.slice(a, b)); } return $r; })();
sizes = (() => { const $r = []; for (const $v12 of $.it(cycles)) { let k; k = $v12; if ($.t($.ge(np.mean($.gi(known, k)), COMPARED))) { $r.push($.b.float(np.quantile($.gi($.gi(error, k), $.gi(known, k)), 0.95))); } } return $r; })();
if (($.t($.lt($.b.len(sizes), CYCLES)) || $.t($.le($.gi(sizes, 0), $.b.max(CHANGED, $.mul(CERTAIN, $.b.max(usual, $.b.float(np.quantile(last, 0.95))))))))) {return null;}
speeds = (() => { const $r = []; for (const $v13 of $.it($.tup($.gi(x, $.slice(null, begin, null)), $.gi(x, $.slice(begin, null, null))))) { let part; part = $v13; $r.push($.b.float(np.mean(np.abs(np.diff(part))))); } return $r; })();
if (($.t($.le($.b.min(sizes), $.mul(LASTS, $.gi(sizes, 0)))) || $.t($.gt($.b.max(speeds), $.mul(SPEED, $.b.min(speeds)))))) {return null;}
limit = $.b.max($.mul(CERTAIN, usual), $.b.float(last.max()));
return $.tup(begin, $.add(begin, $.b.int(np.argmax($.gt($.gi(error, $.slice(begin, null, null)), limit)))), $.b.max(sizes)); }, {p: ["x", "y", "terms", "marks", "cut", "before", "after"], ks: false});
_terms = $.def(function (x, reach) { let radii, levels, plays, shift, hinges;
radii = $.mul(reach, np.linspace(0.02, 0.45, PLAYS));
levels = np.quantile(x, $.gi(np.linspace(0.0, 1.0, $.add(HINGES, 2)), $.slice(1, (-1), null)));
plays = $.gi(_native.play_bank(np.ascontiguousarray(x), radii, $.add($.gi(x, 0), np.zeros(PLAYS)), np.arange($.ga(x, "size"))), 0);
shift = $.mul(0.5, $.add($.b.float(x.min()), $.b.float(x.max())));
hinges = np.maximum($.sub($.gi(x, $.tup($.slice(null, null, null), null)), levels), 0.0);
return np.column_stack([np.ones($.ga(x, "size")), $.div($.sub(x, shift), reach), $.div(hinges, reach), $.div($.sub(plays, shift), reach)]); }, {p: ["x", "reach"], ks: false});
_ridged = $.def(function (sums) { let square;
square = $.gi(sums, $.tup($.slice(null, (-1), null), $.slice(null, (-1), null)));
return np.asarray($.add(square, $.mul($.mul(RIDGE, np.trace(square)), np.eye($.gi($.ga(square, "shape"), 0))))); }, {p: ["sums"], ks: false});
_weights = $.def(function (sums) { 
return np.asarray($.ga(np, "linalg").solve(_ridged(sums), $.gi(sums, $.tup($.slice(null, (-1), null), (-1))))); }, {p: ["sums"], ks: false});
_left = $.def(function (sums) { 
return $.b.float($.sub($.gi(sums, $.tup((-1), (-1))), $.mm($.gi(sums, $.tup($.slice(null, (-1), null), (-1))), _weights(sums)))); }, {p: ["sums"], ks: false});
_seen = $.def(function (terms, begin, sums) { let leverage;
leverage = $.km(np, "sum", [$.mul(terms, $.ga($.ga(np, "linalg").solve(_ridged(sums), $.ga(terms, "T")), "T"))], {"axis": 1});
return np.asarray($.le(leverage, $.mul(FAR, $.gi(leverage, $.slice(null, begin, null)).max()))); }, {p: ["terms", "begin", "sums"], ks: false});
about_change = $.def(function (record, change, broke, place, samples, cut = true) { let time, times;
time = $.ga(record, "time");
times = (() => { const $r = []; for (const $v14 of $.it($.tup($.ga(change, "place"), $.ga(change, "begin")))) { let k; k = $v14; $r.push(($.t((time == null)) ? "" : ("" + " (t = " + $.f($.gi(time, k), ("" + ".6g"), -1) + " s)"))); } return $r; })();
return Finding("two-actuators", ("" + "the output '" + $.f($.ga(record, "output_name"), "", -1) + "' of " + $.f($.ga(record, "name"), "", -1) + " changes at sample " + $.f(broke, "", -1) + $.f($.gi(times, 0), "", -1) + " by " + $.f($.mul(100.0, $.ga(change, "size")), ("" + ".0f"), -1) + " % of the range that it had, at the same input and past, and stays so: a jam, a lost load, a sensor that was set anew. No single model is both what the actuator was and what it became. " + $.f(($.t(cut) ? _cut(place, $.gi(times, 1), samples, "the model is what the actuator was") : ""), "", -1) + "Repair it, or identify the part that is like the use (--from, --to).")); }, {p: ["record", "change", "broke", "place", "samples", "cut"], ks: false});
_cut = $.def(function (place, time, samples, result) { 
return ("" + "The " + $.f($.sub(samples, place), "", -1) + " samples from sample " + $.f(place, "", -1) + $.f(time, "", -1) + " on, of " + $.f(samples, "", -1) + ", were left out of the fit and of its errors: " + $.f(result, "", -1) + ". "); }, {p: ["place", "time", "samples", "result"], ks: false});
AT_REST = 0.005;
STAYS = 0.05;
{const $v15 = $.unpack($.tup(20, 0.01), 2, -1);FEWEST = $v15[0];SHARE = $v15[1];}
DRIVEN = 0.3;
SWINGS = 3;
FOLLOWED = 0.25;
BINS = 8;
stopped_at = $.def(function (x, y) { let span, tail, moving, stop, low, high, turns, begin, before, after, both, level, rest;
{const $v16 = $.unpack($.tup(robust_range([y]), $.gi(y, $.slice($.neg($.b.max(FEWEST, $.b.int($.mul(SHARE, $.ga(y, "size"))))), null, null))), 2, -1);span = $v16[0];tail = $v16[1];}
if ($.t($.gt($.b.float(np.ptp(tail)), $.mul($.mul(2.0, STAYS), span)))) {return null;}
moving = np.flatnonzero($.gt(np.abs($.sub(y, np.median(tail))), $.mul(STAYS, span)));
stop = ($.t($.eq($.ga(moving, "size"), 0)) ? 0 : $.add($.b.int($.gi(moving, (-1))), 1));
if (($.t($.lt(stop, FEWEST)) || $.t($.lt($.sub($.ga(y, "size"), stop), $.ga(tail, "size"))))) {return null;}
{const $v17 = $.unpack($.tup($.b.float($.gi(x, $.slice(stop, null, null)).min()), $.b.float($.gi(x, $.slice(stop, null, null)).max())), 2, -1);low = $v17[0];high = $v17[1];}
if (!$.t($.gt($.sub(high, low), $.mul(DRIVEN, robust_range([x]))))) {return null;}
if ($.t($.le($.ga(turning_points($.gi(x, $.slice(stop, null, null)), $.mul(0.5, $.sub(high, low))), "size"), SWINGS))) {return null;}
turns = turning_points($.gi(x, $.slice(null, stop, null)), $.mul(0.5, $.sub(high, low)));
begin = $.b.int($.gi(turns, $.b.max(0, $.sub($.ga(turns, "size"), 3))));
if ($.t($.lt(begin, FEWEST))) {return null;}
{const $v19 = $.unpack((function* () { for (const $v18 of $.it($.tup($.b.slice(0, begin), $.b.slice(stop, null)))) { let part; part = $v18; yield _levels($.gi(x, part), $.gi(y, part), low, high); } })(), 2, -1);before = $v19[0];after = $v19[1];}
both = $.band(np.isfinite(before), np.isfinite(after));
if (($.t($.lt(both.sum(), 2)) || !$.t($.gt(np.ptp($.gi(before, both)), $.mul(FOLLOWED, span))))) {return null;}
level = np.median($.gi(y, $.slice(stop, null, null)));
rest = $.b.float(np.abs($.sub($.gi(y, $.slice($.add(stop, $.fdiv($.sub($.ga(y, "size"), stop), 2)), null, null)), level)).max());
return $.tup(begin, $.add($.b.int($.gi(np.flatnonzero($.gt(np.abs($.sub(y, level)), $.b.max(rest, $.mul(AT_REST, span)))), (-1))), 1)); }, {p: ["x", "y"], ks: false});
_levels = $.def(function (x, y, low, high) { let cell, inside, count;
cell = np.clip($.div($.mul(BINS, $.sub(x, low)), $.sub(high, low)).astype($.ga(np, "int64")), (-1), BINS);
inside = $.band($.ge(x, low), $.le(x, high));
cell = np.minimum($.gi(cell, inside), $.sub(BINS, 1));
count = $.km(np, "bincount", [cell], {"minlength": BINS});
{ const $v20 = $.km(np, "errstate", [], {"invalid": "ignore", "divide": "ignore"}); $.enter($v20); try {return np.asarray($.div(np.bincount(cell, $.gi(y, inside), BINS), count));} catch ($e) { if (!$.exit($v20, $.caught($e))) throw $e; } } }, {p: ["x", "y", "low", "high"], ks: false});
about_stop = $.def(function (record, stop, broke, place, samples, cut = true) { let times, end, unit;
times = (() => { const $r = []; for (const $v21 of $.it(stop)) { let k; k = $v21; $r.push(($.t(($.ga(record, "time") == null)) ? "" : ("" + " (t = " + $.f($.gi($.ga(record, "time"), k), ("" + ".6g"), -1) + " s)"))); } return $r; })();
end = $.b.float(np.median($.gi($.ga(record, "output"), $.slice($.gi(stop, 1), null, null))));
unit = ($.t($.ga(record, "output_unit")) ? ("" + " " + $.f($.ga(record, "output_unit"), "", -1)) : "");
return Finding("output-stopped", ("" + "the output '" + $.f($.ga(record, "output_name"), "", -1) + "' of " + $.f($.ga(record, "name"), "", -1) + " stops following its input: from sample " + $.f(broke, "", -1) + $.f($.gi(times, 1), "", -1) + " on it stays at " + $.f(end, ("" + ".4g"), -1) + $.f(unit, "", -1) + " while the input cycles on. The actuator broke, or its sensor was lost. " + $.f(($.t(cut) ? _cut(place, $.gi(times, 0), samples, "the swing before counts as doubtful") : ""), "", -1) + "Repair it, and log again if the model needs more loops.")); }, {p: ["record", "stop", "broke", "place", "samples", "cut"], ks: false});
SHOWN = 4;
ENDED = $.b.set(["two-actuators", "output-stopped"]);
mended = $.def(function (record, cut = true) { let found, rest;
record = _bridged(record);
found = _ended(record, cut);
if (($.t((found == null)) || $.t($.in($.gi(found, 0), $.ga(record, "left_out"))))) {return record;}
if (!$.t(cut)) {return record.with_findings($.gi(found, 1));}
rest = $.b.range($.gi(found, 0), $.b.len(record));
return $.k(replace, [record], {"left_out": $.tup(...$.it($.ga(record, "left_out")), ...$.it(rest))}).with_findings($.gi(found, 1)); }, {p: ["record", "cut"], ks: false});
_ended = $.def(function (record, cut) { let stop, change;
stop = stopped_at($.ga(record, "input"), $.ga(record, "output"));
if ($.t((stop != null))) {return $.tup($.gi(stop, 0), about_stop(record, stop, $.gi(stop, 1), $.gi(stop, 0), $.b.len(record), cut));}
change = changed_at($.ga(record, "input"), $.ga(record, "output"));
if ($.t((change == null))) {return null;}
return $.tup($.ga(change, "begin"), about_change(record, change, $.ga(change, "place"), $.ga(change, "begin"), $.b.len(record), cut)); }, {p: ["record", "cut"], ks: false});
_bridged = $.def(function (record) { let masks, bad, names, said, memory, finding;
masks = (() => { const $r = []; for (const $v22 of $.it($.tup($.ga(record, "input"), $.ga(record, "output")))) { let values; values = $v22; $r.push(_outliers(record, values)); } return $r; })();
bad = $.bor($.gi(masks, 0), $.gi(masks, 1));
if (!$.t(bad.any())) {return record;}
names = $.tup($.ga(record, "input_name"), $.ga(record, "output_name"));
said = (() => { const $r = []; for (const $v23 of $.it($.k($.b.zip, [names, $.tup($.ga(record, "input"), $.ga(record, "output")), masks], {"strict": true}))) { let name, values, mask; {const $v24 = $.unpack($v23, 3, -1);name = $v24[0];values = $v24[1];mask = $v24[2];} if ($.t(mask.any())) { $r.push(("" + "'" + $.f(name, "", -1) + "' is " + $.f(_shown($.gi(values, mask)), "", -1) + " in " + $.f(_numbers(mask), "", -1))); } } return $r; })();
memory = ($.t($.gi(masks, 0).any()) ? " Memory follows the line through the input." : "");
finding = Finding("outlier", ("" + $.f($.b.int(bad.sum()), "", -1) + " of " + $.f($.ga(bad, "size"), "", -1) + " samples of " + $.f($.ga(record, "name"), "", -1) + " hold a value far from all others (" + $.f($.cm("; ", "join", [said]), "", -1) + "); they were left out of the fit and of its errors, and a straight line took their place." + $.f(memory, "", -1) + " Check the sensor and its wiring; if the values are real, log faster so that they are more than a spike."));
return $.k(replace, [record], {"input": bridged($.ga(record, "input"), $.gi(masks, 0)), "output": bridged($.ga(record, "output"), $.gi(masks, 1)), "left_out": $.tup(...$.it($.ga(record, "left_out")), ...$.it(np.flatnonzero(bad).tolist())), "findings": $.tup(...$.it($.ga(record, "findings")), finding)}); }, {p: ["record"], ks: false});
_outliers = $.def(function (record, values) { 
return np.concatenate((() => { const $r = []; for (const $v25 of $.it($.ga(record, "pieces"))) { let piece; piece = $v25; $r.push(find_outliers($.gi(values, piece))); } return $r; })()); }, {p: ["record", "values"], ks: false});
_shown = $.def(function (values) { let listed;
listed = $.b.list($.b.dict.fromkeys((function* () { for (const $v26 of $.it(values.tolist())) { let value; value = $v26; yield ("" + $.f(value, ("" + ".6g"), -1)); } })()));
return $.add($.cm(", ", "join", [$.gi(listed, $.slice(null, SHOWN, null))]), ($.t($.gt($.b.len(listed), SHOWN)) ? ", ..." : "")); }, {p: ["values"], ks: false});
_numbers = $.def(function (mask) { let index;
index = np.flatnonzero(mask);
if ($.t($.eq($.ga(index, "size"), 1))) {return ("" + "sample " + $.f($.gi(index, 0), "", -1));}
if (($.t($.gt($.ga(index, "size"), SHOWN)) && $.t($.eq($.sub($.gi(index, (-1)), $.gi(index, 0)), $.sub($.ga(index, "size"), 1))))) {return ("" + "samples " + $.f($.gi(index, 0), "", -1) + " to " + $.f($.gi(index, (-1)), "", -1));}
return $.add(("" + "samples " + $.f($.cm(", ", "join", [$.b.map($.b.str, $.gi(index, $.slice(null, SHOWN, null)).tolist())]), "", -1)), ($.t($.gt($.ga(index, "size"), SHOWN)) ? ", ..." : "")); }, {p: ["mask"], ks: false});
Object.assign($m, {"annotations": annotations, "dataclass": dataclass, "replace": replace, "pairwise": pairwise, "np": np, "npt": npt, "_native": _native, "Array": Array_, "Mask": Mask, "Rows": Rows, "turning_points": turning_points, "bridged": bridged, "find_outliers": find_outliers, "robust_range": robust_range, "Recording": Recording, "Finding": Finding, "single_blas": single_blas, "CHANGED": CHANGED, "CERTAIN": CERTAIN, "LASTS": LASTS, "SPEED": SPEED, "SWING": SWING, "CYCLES": CYCLES, "MOST_CYCLES": MOST_CYCLES, "MOST_ROWS": MOST_ROWS, "PLAYS": PLAYS, "HINGES": HINGES, "FAR": FAR, "COMPARED": COMPARED, "RIDGE": RIDGE, "Change": Change, "changed_at": changed_at, "_changed_at": _changed_at, "_judged": _judged, "_terms": _terms, "_ridged": _ridged, "_weights": _weights, "_left": _left, "_seen": _seen, "about_change": about_change, "_cut": _cut, "AT_REST": AT_REST, "STAYS": STAYS, "FEWEST": FEWEST, "SHARE": SHARE, "DRIVEN": DRIVEN, "SWINGS": SWINGS, "FOLLOWED": FOLLOWED, "BINS": BINS, "stopped_at": stopped_at, "_levels": _levels, "about_stop": about_stop, "SHOWN": SHOWN, "ENDED": ENDED, "mended": mended, "_ended": _ended, "_bridged": _bridged, "_outliers": _outliers, "_shown": _shown, "_numbers": _numbers});
});
$.module("dehyst.identification.plays", ($m) => {
let annotations, Sequence, npt, Recording, require_recordings, takes_recordings, ParameterError, identify_direct, Fit, DIRECT, call_of, solve_in_memory, PAPER_EPS, PAPER_OPERATORS, check_recordings, check_settings, check_weights, eps_of_call, refuse_both, identify_sheared, identify_within, split_recordings, identify, _identify_direct, identify_paper;
Sequence = $.from("collections.abc", "Sequence");
npt = $.imp("numpy.typing");
Recording = $.from("dehyst.data.recording", "Recording");require_recordings = $.from("dehyst.data.recording", "require_recordings");takes_recordings = $.from("dehyst.data.recording", "takes_recordings");
ParameterError = $.from("dehyst.errors", "ParameterError");
identify_direct = $.from("dehyst.identification.direct.procedure", "identify_direct");
Fit = $.from("dehyst.identification.fit", "Fit");
DIRECT = $.from("dehyst.identification.procedure", "DIRECT");call_of = $.from("dehyst.identification.procedure", "call_of");solve_in_memory = $.from("dehyst.identification.procedure", "solve_in_memory");
PAPER_EPS = $.from("dehyst.identification.settings", "PAPER_EPS");PAPER_OPERATORS = $.from("dehyst.identification.settings", "PAPER_OPERATORS");check_recordings = $.from("dehyst.identification.settings", "check_recordings");check_settings = $.from("dehyst.identification.settings", "check_settings");check_weights = $.from("dehyst.identification.settings", "check_weights");eps_of_call = $.from("dehyst.identification.settings", "eps_of_call");refuse_both = $.from("dehyst.identification.settings", "refuse_both");
identify_sheared = $.from("dehyst.identification.shear", "identify_sheared");identify_within = $.from("dehyst.identification.shear", "identify_within");
split_recordings = $.from("dehyst.identification.split", "split_recordings");
identify = $.def(function (recordings, family = "auto", n = PAPER_OPERATORS, eps = null, thresholds = null, initial_state = "auto", train_fraction = null, weights = null, shear = null, max_inverse_gain = null) { let given_here, records, begun, chosen, given, sample_weights, split, call;
recordings = require_recordings(recordings);
if ($.t($.eq($.b.str(family), DIRECT))) {given_here = $.dict([["n", $.ne(n, PAPER_OPERATORS)], ["eps", (eps != null)], ["thresholds", (thresholds != null)], ["weights", (weights != null)], ["shear", (shear != null)], ["max_inverse_gain", (max_inverse_gain != null)]]);
return _identify_direct(recordings, initial_state, train_fraction, given_here);}
records = check_recordings(recordings);
{const $v1 = $.unpack(eps_of_call(family, eps), 2, -1);begun = $v1[0];chosen = $v1[1];}
given = check_settings(family, n, begun, thresholds, initial_state);
sample_weights = check_weights(weights, records);
split = split_recordings(records, train_fraction, sample_weights);
call = call_of(family, n, $.tup(begun, chosen), given, initial_state, split, (sample_weights != null));
if ($.t((eps != null))) {refuse_both(eps, shear, max_inverse_gain);}
if (($.t((shear == null)) && $.t((max_inverse_gain == null)))) {return solve_in_memory(call, records, sample_weights);}
if ($.t((shear != null))) {return identify_sheared(call, records, sample_weights, shear, max_inverse_gain);}
return identify_within(call, records, sample_weights, ($.t((max_inverse_gain == null)) ? 0.0 : max_inverse_gain)); }, {p: ["recordings", "family", "n", "eps", "thresholds", "initial_state", "train_fraction", "weights", "shear", "max_inverse_gain"], ks: false});
_identify_direct = $.def(function (recordings, initial_state, train_fraction, given) { let set_here;
set_here = (() => { const $r = []; for (const $v2 of $.it($.cm(given, "items", []))) { let name, there; {const $v3 = $.unpack($v2, 2, -1);name = $v3[0];there = $v3[1];} if ($.t(there)) { $r.push(name); } } return $r; })();
if ($.t(set_here)) {throw $.exc($.k(ParameterError, [("" + $.f($.cm(" and ", "join", [set_here]), "", -1) + " " + $.f(($.t($.eq($.b.len(set_here), 1)) ? "says" : "say"), "", -1) + " nothing to the family 'direct-inverse': its radii, path lengths and slopes are its own and every sample counts alike. Leave " + $.f(($.t($.eq($.b.len(set_here), 1)) ? "it" : "them"), "", -1) + " out; creep and schedules are settings of dehyst.identify_direct.")], {"settings": set_here}));}
return $.k(identify_direct, [recordings], {"initial_state": initial_state, "train_fraction": train_fraction}); }, {p: ["recordings", "initial_state", "train_fraction", "given"], ks: false});
identify_paper = $.def(function (recordings, train_fraction = null) { 
return $.k(identify, [recordings, "pi"], {"n": PAPER_OPERATORS, "eps": PAPER_EPS, "train_fraction": train_fraction}); }, {p: ["recordings", "train_fraction"], ks: false});
Object.assign($m, {"annotations": annotations, "Sequence": Sequence, "npt": npt, "Recording": Recording, "require_recordings": require_recordings, "takes_recordings": takes_recordings, "ParameterError": ParameterError, "identify_direct": identify_direct, "Fit": Fit, "DIRECT": DIRECT, "call_of": call_of, "solve_in_memory": solve_in_memory, "PAPER_EPS": PAPER_EPS, "PAPER_OPERATORS": PAPER_OPERATORS, "check_recordings": check_recordings, "check_settings": check_settings, "check_weights": check_weights, "eps_of_call": eps_of_call, "refuse_both": refuse_both, "identify_sheared": identify_sheared, "identify_within": identify_within, "split_recordings": split_recordings, "identify": identify, "_identify_direct": _identify_direct, "identify_paper": identify_paper});
});
$.module("dehyst.identification.procedure", ($m) => {
let annotations, time, Callable, Sequence, dataclass, field, replace, cached_property, Any, np, npt, Array_, Recording, ExcitationError, facts, Seen, certify, seen_in, DataSet, prepare, STATIC, Estimate, build_model, fit_family, reduce, Candidate, Fit, Refit, polish, refine, Bank, NormalEquations, fitted_samples, make_bank, settled, sums_of, InMemory, Measure, parts, score, simulated, BY_ORIENTATION, REGULARISATIONS, STARTS, Choice, choose, choose_operators, compare, firmness, output_knots, possible_choices, start_of_paper, threshold_grid, PAPER_OPERATORS, check_settings, eps_of_call, paper_eps, Split, split_recordings, NO_MEMORY, fit_static, single_blas, ModelCard, DIRECT, KEPT_OPERATORS, KEPT_SUMS, SAME, Refitter, _solved, _Problem, solve_in_memory, Prepared, prepared, call_of, Call, solve, _choose, _fit;
time = $.imp("time");
Callable = $.from("collections.abc", "Callable");Sequence = $.from("collections.abc", "Sequence");
dataclass = $.from("dataclasses", "dataclass");field = $.from("dataclasses", "field");replace = $.from("dataclasses", "replace");
cached_property = $.from("functools", "cached_property");
Any = $.from("typing", "Any");
np = $.imp("numpy");
npt = $.imp("numpy.typing");
Array_ = $.from("dehyst.arrays", "Array");
Recording = $.from("dehyst.data.recording", "Recording");
ExcitationError = $.from("dehyst.errors", "ExcitationError");
facts = $.from("dehyst.identification", "facts");
Seen = $.from("dehyst.identification.certify", "Seen");certify = $.from("dehyst.identification.certify", "certify");seen_in = $.from("dehyst.identification.certify", "seen_in");
DataSet = $.from("dehyst.identification.data", "DataSet");prepare = $.from("dehyst.identification.data", "prepare");
STATIC = $.from("dehyst.identification.families", "STATIC");Estimate = $.from("dehyst.identification.families", "Estimate");build_model = $.from("dehyst.identification.families", "build_model");fit_family = $.from("dehyst.identification.families", "fit_family");reduce = $.from("dehyst.identification.families", "reduce");
Candidate = $.from("dehyst.identification.fit", "Candidate");Fit = $.from("dehyst.identification.fit", "Fit");Refit = $.from("dehyst.identification.fit", "Refit");
polish = $.from("dehyst.identification.refine", "polish");refine = $.from("dehyst.identification.refine", "refine");
Bank = $.from("dehyst.identification.regressors", "Bank");NormalEquations = $.from("dehyst.identification.regressors", "NormalEquations");fitted_samples = $.from("dehyst.identification.regressors", "fitted_samples");make_bank = $.from("dehyst.identification.regressors", "make_bank");settled = $.from("dehyst.identification.regressors", "settled");sums_of = $.from("dehyst.identification.regressors", "sums_of");
InMemory = $.from("dehyst.identification.scores", "InMemory");Measure = $.from("dehyst.identification.scores", "Measure");parts = $.from("dehyst.identification.scores", "parts");score = $.from("dehyst.identification.scores", "score");simulated = $.from("dehyst.identification.scores", "simulated");
BY_ORIENTATION = $.from("dehyst.identification.selection", "BY_ORIENTATION");REGULARISATIONS = $.from("dehyst.identification.selection", "REGULARISATIONS");STARTS = $.from("dehyst.identification.selection", "STARTS");Choice = $.from("dehyst.identification.selection", "Choice");choose = $.from("dehyst.identification.selection", "choose");choose_operators = $.from("dehyst.identification.selection", "choose_operators");compare = $.from("dehyst.identification.selection", "compare");firmness = $.from("dehyst.identification.selection", "firmness");output_knots = $.from("dehyst.identification.selection", "output_knots");possible_choices = $.from("dehyst.identification.selection", "possible_choices");start_of_paper = $.from("dehyst.identification.selection", "start_of_paper");threshold_grid = $.from("dehyst.identification.selection", "threshold_grid");
PAPER_OPERATORS = $.from("dehyst.identification.settings", "PAPER_OPERATORS");check_settings = $.from("dehyst.identification.settings", "check_settings");eps_of_call = $.from("dehyst.identification.settings", "eps_of_call");paper_eps = $.from("dehyst.identification.settings", "paper_eps");
Split = $.from("dehyst.identification.split", "Split");split_recordings = $.from("dehyst.identification.split", "split_recordings");
NO_MEMORY = $.from("dehyst.identification.static_curve", "NO_MEMORY");fit_static = $.from("dehyst.identification.static_curve", "fit_static");
single_blas = $.from("dehyst.identification.threads", "single_blas");
ModelCard = $.from("dehyst.models.card", "ModelCard");
DIRECT = "direct-inverse";
KEPT_OPERATORS = 2000;
KEPT_SUMS = 8;
SAME = 1e-12;
Refitter = $.cls("Refitter", [], "", [["records", null], ["data", null], ["choice", null], ["operators", null], ["eps", null], ["given", null], ["_kept", () => $.b.list()], ["_done", () => $.b.dict()]], true, true, ($c) => { Refitter = $c; $.meth($c, "keep", $.def(function (bank, sums, ramps) { const self = this;
if ($.t($.le($.ga($.ga(bank, "thresholds"), "size"), KEPT_OPERATORS))) {self._kept = [...$.it($.gi($.ga(self, "_kept"), $.slice($.add($.neg(KEPT_SUMS), 1), null, null))), $.tup(bank, ramps, sums)];} }, {p: ["bank", "sums", "ramps"], ks: false}));
$.meth($c, "__call__", $.def(function (n, eps, family, thresholds) { const self = this;let begin, setting, chosen, slope, asked, given, operators, scaled, found;
begin = time.perf_counter();
setting = ($.t((thresholds == null)) ? $.tup(n, eps, family) : null);
if ($.t($.in(setting, $.ga(self, "_done")))) {return $.gi($.ga(self, "_done"), setting);}
chosen = ($.t((family == null)) ? $.ga($.ga(self, "choice"), "family") : family);
slope = ($.t($.eq(chosen, "pi")) ? $.div($.ga($.ga(self, "data"), "amplitude"), $.ga($.ga(self, "data"), "half_range")) : 1.0);
asked = ($.t((eps == null)) ? $.mul($.ga(self, "eps"), slope) : eps);
given = check_settings(chosen, ($.t((n == null)) ? $.ga(self, "operators") : n), asked, thresholds, $.ga($.ga(self, "choice"), "initial_state"));
if (($.t((n == null)) && $.t((given == null)))) {given = $.ga(self, "given");}
operators = ($.t((given != null)) ? $.ga(given, "size") : $.b.int(($.t((n == null)) ? $.ga(self, "operators") : n)));
if ($.t((eps == null))) {scaled = $.ga(self, "eps");} else {scaled = ($.t($.eq(chosen, "pi")) ? paper_eps($.b.float(asked), $.gi($.ga(self, "records"), 0), $.ga(self, "data")) : $.b.float(asked));}
{ const $v1 = single_blas(); $.enter($v1); try {found = self._fit(chosen, operators, $.b.float(asked), scaled, given, begin);} catch ($e) { if (!$.exit($v1, $.caught($e))) throw $e; } }
if ($.t((setting != null))) {$.si($.ga(self, "_done"), setting, found);}
return found; }, {p: ["n", "eps", "family", "thresholds"], ks: false}));
$.meth($c, "_fit", $.def(function (family, operators, eps, scaled, given, begin) { const self = this;let data, start, mapped, choice, bank, sums, estimate, knots, model, outputs, train, test;
{const $v2 = $.unpack($.tup($.ga(self, "data"), $.ga($.ga(self, "choice"), "initial_state")), 2, -1);data = $v2[0];start = $v2[1];}
mapped = $.eq(family, "modified-pi");
choice = Choice(family, start, ($.t(mapped) ? $.or($.ga($.ga(self, "choice"), "regularisation"), () => $.gi(REGULARISATIONS, (-1))) : null), ($.t($.eq(family, $.ga($.ga(self, "choice"), "family"))) ? $.ga($.ga(self, "choice"), "power") : null));
{const $v3 = $.unpack(self._sums(threshold_grid(data, operators, choice, given), mapped), 2, -1);bank = $v3[0];sums = $v3[1];}
estimate = _solved(data, bank, sums, choice, scaled);
knots = ($.t(mapped) ? output_knots() : null);
model = build_model(estimate, data, bank, knots, ModelCard());
outputs = simulated($.ga(self, "records"), data, settled(data, bank, model), model);
{const $v5 = $.unpack((function* () { for (const $v4 of $.it(parts($.ga(self, "records"), data, start))) { let part; part = $v4; yield score($.ga(self, "records"), outputs, part, $.ga(data, "output_range")); } })(), 2, -1);train = $v5[0];test = $v5[1];}
if ($.t((train == null))) {throw $.exc($.b.AssertionError("no training samples"));}
return Refit(family, operators, eps, model, train, test, $.ga(model, "inverse_gain"), $.ga(model, "nonzero_weights"), $.ga(estimate, "kkt_residual"), $.ga(estimate, "condition"), $.ga(estimate, "route"), $.sub(time.perf_counter(), begin)); }, {p: ["family", "operators", "eps", "scaled", "given", "begin"], ks: false}));
$.meth($c, "_sums", $.def(function (grid, ramps) { const self = this;let wanted, bank, with_ramps, sums, places, kept;
wanted = make_bank($.ga(self, "data"), grid, $.ga($.ga(self, "choice"), "initial_state"));
for (const $v6 of $.it($.b.reversed($.ga(self, "_kept")))) { {const $v7 = $.unpack($v6, 3, -1);bank = $v7[0];with_ramps = $v7[1];sums = $v7[2];}
{if (($.t(ramps) && !$.t(with_ramps))) {continue;}
places = np.searchsorted($.ga(bank, "thresholds"), $.sub($.ga(wanted, "thresholds"), SAME));
if (($.t($.ge($.gi(places, (-1)), $.ga($.ga(bank, "thresholds"), "size"))) || $.t($.lt($.ga(np.unique(places), "size"), $.ga(places, "size"))))) {continue;}
if ($.t($.gt(np.max(np.abs($.sub($.gi($.ga(bank, "thresholds"), places), $.ga(wanted, "thresholds")))), SAME))) {continue;}
kept = $.km(np, "zeros", [$.ga($.ga(bank, "thresholds"), "size")], {"dtype": $.ga(np, "bool_")});
$.si(kept, places, true);
return $.tup(wanted, ($.t(kept.all()) ? sums : sums.coarser(kept)));} }
sums = sums_of($.ga(self, "data"), wanted, ($.t(ramps) ? output_knots() : null));
self.keep(wanted, sums, ramps);
return $.tup(wanted, sums); }, {p: ["grid", "ramps"], ks: false}));});
_solved = $.def(function (data, bank, sums, choice, eps) { let knots, estimate;
knots = ($.t($.eq($.ga(choice, "family"), "modified-pi")) ? output_knots() : null);
estimate = $.k(fit_family, [$.ga(choice, "family"), sums, eps, knots, $.ga(choice, "regularisation")], {"triangle": $.def(() => {  return reduce(data, bank, knots); }, {p: [], ks: false})});
if (($.t((knots == null)) || $.t(($.ga(choice, "regularisation") == null)))) {return estimate;}
return polish(sums, eps, knots, $.ga(choice, "regularisation"), estimate); }, {p: ["data", "bank", "sums", "choice", "eps"], ks: false});
_Problem = $.cls("_Problem", [], "", [["data", null], ["operators", null], ["eps", null], ["given", null], ["entering", null]], true, true, ($c) => { _Problem = $c; });
solve_in_memory = $.def(function (call, records, weights, measure = null) { let data;
{ const $v8 = single_blas(); $.enter($v8); try {data = prepare(records, $.ga(call, "split"), weights);
return solve(call, $.gi(records, 0), data, facts.branches(data), $.or(measure, () => InMemory(records)), records);} catch ($e) { if (!$.exit($v8, $.caught($e))) throw $e; } } }, {p: ["call", "records", "weights", "measure"], ks: false});
Prepared = $.cls("Prepared", [], "", [["records", null], ["split", null], ["measure", null]], true, false, ($c) => { Prepared = $c; $.cached($c, "data", $.def(function () { const self = this;
return prepare($.ga(self, "records"), $.ga(self, "split")); }, {p: [], ks: false}));
$.cached($c, "branches", $.def(function () { const self = this;
return facts.branches($.ga(self, "data")); }, {p: [], ks: false}));
$.cached($c, "seen", $.def(function () { const self = this;
return seen_in($.ga(self, "branches")); }, {p: [], ks: false}));
$.meth($c, "call", $.def(function (family) { const self = this;
return call_of(family, PAPER_OPERATORS, eps_of_call(family, null), null, "auto", $.ga(self, "split")); }, {p: ["family"], ks: false}));
$.meth($c, "plays", $.def(function (family) { const self = this;
if ($.t(!$.in(family, $.ga(self, "_fits")))) {{ const $v9 = single_blas(); $.enter($v9); try {$.si($.ga(self, "_fits"), family, solve(self.call(family), $.gi($.ga(self, "records"), 0), $.ga(self, "data"), $.ga(self, "branches"), $.ga(self, "measure"), $.ga(self, "records")));} catch ($e) { if (!$.exit($v9, $.caught($e))) throw $e; } }}
return $.gi($.ga(self, "_fits"), family); }, {p: ["family"], ks: false}));
$.cached($c, "_fits", $.def(function () { const self = this;
return $.dict([]); }, {p: [], ks: false}));});
prepared = $.def(function (records, train_fraction) { 
return Prepared(records, split_recordings(records, train_fraction), InMemory(records)); }, {p: ["records", "train_fraction"], ks: false});
call_of = $.def(function (family, n, eps, given, initial_state, split, weighted = false) { let operators;
operators = ($.t((given != null)) ? $.ga(given, "size") : ($.t($.b.isinstance(n, $.b.str)) ? PAPER_OPERATORS : $.b.int(n)));
return Call(family, operators, ...$.it(eps), given, initial_state, split, $.b.isinstance(n, $.b.str), weighted); }, {p: ["family", "n", "eps", "given", "initial_state", "split", "weighted"], ks: false});
Call = $.cls("Call", [], "", [["family", null], ["operators", null], ["eps", null], ["choose_eps", null], ["given", null], ["initial_state", null], ["split", null], ["choose_operators", () => false], ["weighted", () => false]], true, true, ($c) => { Call = $c; $.prop($c, "settings", $.def(function () { const self = this;
return $.dict([["family", $.ga(self, "family")], ["n", $.ga(self, "operators")], ["eps", $.ga(self, "eps")], ["thresholds", ($.t(($.ga(self, "given") == null)) ? "grid" : "given")], ["initial_state", $.ga(self, "initial_state")], ...$.pairs($.ga($.ga(self, "split"), "settings")), ...$.pairs(($.t($.ga(self, "weighted")) ? $.dict([["weights", "given"]]) : $.dict([])))]); }, {p: [], ks: false}));});
solve = $.def(function (call, first, data, found, measure, records = $.tup(), entering = $.b.len) { let slope, scaled, problem, seen, families, starts, choice, candidates, settings, operators, firm, refitter, bank, estimate, _;
slope = ($.t($.eq($.ga(call, "family"), "pi")) ? $.div($.ga(data, "amplitude"), $.ga(data, "half_range")) : 1.0);
scaled = (($.t($.ga(call, "choose_eps")) || $.t($.ne($.ga(call, "family"), "pi"))) ? $.ga(call, "eps") : paper_eps($.ga(call, "eps"), first, data));
problem = _Problem(data, $.ga(call, "operators"), scaled, $.ga(call, "given"), entering);
entering("choosing");
seen = seen_in(found);
families = ($.t($.eq($.ga(call, "family"), "auto")) ? $.gi(BY_ORIENTATION, $.ga($.ga(seen, "loop"), "name")) : $.tup($.ga(call, "family")));
starts = ($.t($.eq($.ga(call, "initial_state"), "auto")) ? STARTS : $.tup($.ga(call, "initial_state")));
if (($.t($.eq($.ga(call, "family"), "pi")) && $.t($.eq($.ga(call, "initial_state"), "auto")))) {starts = $.tup(start_of_paper(data, $.ga(problem, "operators"), scaled, $.ga(call, "given")));}
{const $v10 = $.unpack(_choose(problem, families, starts), 2, -1);choice = $v10[0];candidates = $v10[1];}
settings = $.ga(call, "settings");
if (($.t($.ga(call, "choose_operators")) && $.t($.ne($.ga(choice, "family"), STATIC)))) {{const $v11 = $.unpack(choose_operators(data, choice, scaled), 2, -1);operators = $v11[0];choice = $v11[1];}
problem = $.k(replace, [problem], {"operators": operators});
settings = $.ibor(settings, $.dict([["n", operators], ["n_by", "cross-validation"], ["power", $.ga(choice, "power")]]));}
firm = firmness(data, choice, $.ga(problem, "operators"), scaled, $.ga(call, "given"));
if ($.t($.ga(call, "choose_eps"))) {problem = $.k(replace, [problem], {"eps": $.or($.ga(firm, "affordable"), () => scaled)});
firm = $.km(firm, "_replace", [], {"affordable": null});
settings = $.ibor(settings, $.dict([["eps", $.mul($.ga(problem, "eps"), slope)], ["eps_by", "error of the fit"]]));}
refitter = null;
if ($.t($.eq($.ga(choice, "family"), STATIC))) {problem = $.k(replace, [problem], {"operators": 0});
bank = make_bank(data, NO_MEMORY, $.ga(choice, "initial_state"));
{const $v12 = $.unpack(fit_static(data, $.ga(choice, "initial_state"), $.ga(problem, "eps")), 2, -1);estimate = $v12[0];_ = $v12[1];}} else {refitter = ($.t(records) ? Refitter(records, data, choice, $.ga(problem, "operators"), $.ga(problem, "eps"), $.ga(call, "given")) : null);
{const $v13 = $.unpack(_fit(problem, choice, refitter), 2, -1);bank = $v13[0];estimate = $v13[1];}}
if ($.t(($.ga(choice, "regularisation") != null))) {$.si(settings, "smoothing", $.ga($.ga(choice, "regularisation"), "smoothing"));
$.si(settings, "ridge", $.ga($.ga(choice, "regularisation"), "ridge"));}
entering("comparing");
return certify(data, $.ga(problem, "operators"), choice, bank, estimate, firm.times(slope), candidates, seen, settings, measure, refitter); }, {p: ["call", "first", "data", "found", "measure", "records", "entering"], ks: false});
_choose = $.def(function (problem, families, starts) { let choices, results, family;
choices = $.b.list(possible_choices(families, starts));
if ($.t($.eq($.b.len(choices), 1))) {return $.tup($.gi(choices, 0), $.tup());}
results = compare($.ga(problem, "data"), choices, $.ga(problem, "operators"), $.ga(problem, "eps"), $.ga(problem, "given"));
if (!$.t(results)) {family = $.b.next((function* () { for (const $v14 of $.it(families)) { let name; name = $v14; if ($.t($.ne(name, STATIC))) { yield name; } } })());
return $.tup(Choice(family, $.gi(starts, 0), ($.t($.eq(family, "modified-pi")) ? $.gi(REGULARISATIONS, (-1)) : null)), $.tup());}
return choose(results); }, {p: ["problem", "families", "starts"], ks: false});
_fit = $.def(function (problem, choice, refitter) { let data, levels, usable, bank, mapped, sums, estimate;
data = $.ga(problem, "data");
levels = (() => { const $r = []; for (const $v15 of $.it($.ga(data, "pieces"))) { let piece; piece = $v15; if ($.t((piece.unknown_level($.ga(choice, "initial_state")) == null))) { $r.push(piece); } } return $r; })();
usable = fitted_samples($.k(replace, [data], {"pieces": $.b.tuple(levels)}), $.ga(choice, "initial_state"));
if ($.t($.lt(usable, 4))) {throw $.exc($.k(ExcitationError, [("" + "only " + $.f(usable, "", -1) + " training samples remain once the memory of the actuator is known: the input visits both of its extremes too late, or after every gap not at all. Fit a larger part (--train-fraction), or assume a start (--initial-state zero, rest, rising or falling).")], {"samples": usable}));}
bank = make_bank(data, threshold_grid(data, $.ga(problem, "operators"), choice, $.ga(problem, "given")), $.ga(choice, "initial_state"));
mapped = $.eq($.ga(choice, "family"), "modified-pi");
problem.entering("summing");
sums = sums_of(data, bank, ($.t(mapped) ? output_knots() : null));
if ($.t((refitter != null))) {refitter.keep(bank, sums, mapped);}
estimate = _solved(data, bank, sums, choice, $.ga(problem, "eps"));
problem.entering("refining");
return $.tup(bank, ($.t(mapped) ? estimate : refine(data, bank, sums, $.ga(problem, "eps"), estimate))); }, {p: ["problem", "choice", "refitter"], ks: false});
Object.assign($m, {"annotations": annotations, "time": time, "Callable": Callable, "Sequence": Sequence, "dataclass": dataclass, "field": field, "replace": replace, "cached_property": cached_property, "Any": Any, "np": np, "npt": npt, "Array": Array_, "Recording": Recording, "ExcitationError": ExcitationError, "facts": facts, "Seen": Seen, "certify": certify, "seen_in": seen_in, "DataSet": DataSet, "prepare": prepare, "STATIC": STATIC, "Estimate": Estimate, "build_model": build_model, "fit_family": fit_family, "reduce": reduce, "Candidate": Candidate, "Fit": Fit, "Refit": Refit, "polish": polish, "refine": refine, "Bank": Bank, "NormalEquations": NormalEquations, "fitted_samples": fitted_samples, "make_bank": make_bank, "settled": settled, "sums_of": sums_of, "InMemory": InMemory, "Measure": Measure, "parts": parts, "score": score, "simulated": simulated, "BY_ORIENTATION": BY_ORIENTATION, "REGULARISATIONS": REGULARISATIONS, "STARTS": STARTS, "Choice": Choice, "choose": choose, "choose_operators": choose_operators, "compare": compare, "firmness": firmness, "output_knots": output_knots, "possible_choices": possible_choices, "start_of_paper": start_of_paper, "threshold_grid": threshold_grid, "PAPER_OPERATORS": PAPER_OPERATORS, "check_settings": check_settings, "eps_of_call": eps_of_call, "paper_eps": paper_eps, "Split": Split, "split_recordings": split_recordings, "NO_MEMORY": NO_MEMORY, "fit_static": fit_static, "single_blas": single_blas, "ModelCard": ModelCard, "DIRECT": DIRECT, "KEPT_OPERATORS": KEPT_OPERATORS, "KEPT_SUMS": KEPT_SUMS, "SAME": SAME, "Refitter": Refitter, "_solved": _solved, "_Problem": _Problem, "solve_in_memory": solve_in_memory, "Prepared": Prepared, "prepared": prepared, "call_of": call_of, "Call": Call, "solve": solve, "_choose": _choose, "_fit": _fit});
});
$.module("dehyst.identification.refine", ($m) => {
let annotations, dataclass, replace, np, npt, SLOPES, STOPS, WEIGHTS, Evaluator, Gram, Array_, DataSet, chunks, BASIS, NORMAL, NORMALISATION, Estimate, Program, Regularisation, estimate_of, lower_bounds, program, TRACE, Bank, NormalEquations, Marks, ROUNDING, PROVEN, ROUNDS, Gradient, gradient_of, refine, _step, _solved, _groups, _from_slopes, slopes_of, kkt_residual, transposed, _squares, STEPS, polish, _in_weights, _gradient;
dataclass = $.from("dataclasses", "dataclass");replace = $.from("dataclasses", "replace");
np = $.imp("numpy");
npt = $.imp("numpy.typing");
SLOPES = $.from("dehyst._native", "SLOPES");STOPS = $.from("dehyst._native", "STOPS");WEIGHTS = $.from("dehyst._native", "WEIGHTS");Evaluator = $.from("dehyst._native", "Evaluator");Gram = $.from("dehyst._native", "Gram");
Array_ = $.from("dehyst.arrays", "Array");
DataSet = $.from("dehyst.identification.data", "DataSet");chunks = $.from("dehyst.identification.data", "chunks");
BASIS = $.from("dehyst.identification.families", "BASIS");NORMAL = $.from("dehyst.identification.families", "NORMAL");NORMALISATION = $.from("dehyst.identification.families", "NORMALISATION");Estimate = $.from("dehyst.identification.families", "Estimate");Program = $.from("dehyst.identification.families", "Program");Regularisation = $.from("dehyst.identification.families", "Regularisation");estimate_of = $.from("dehyst.identification.families", "estimate_of");lower_bounds = $.from("dehyst.identification.families", "lower_bounds");program = $.from("dehyst.identification.families", "program");
TRACE = $.from("dehyst.identification.regressors", "TRACE");Bank = $.from("dehyst.identification.regressors", "Bank");NormalEquations = $.from("dehyst.identification.regressors", "NormalEquations");
Marks = $.gi($.ga(npt, "NDArray"), $.ga(np, "bool_"));
ROUNDING = 1e-12;
PROVEN = 1e-13;
ROUNDS = 8;
Gradient = $.cls("Gradient", [], "", [["cells", null], ["square", null]], true, true, ($c) => { Gradient = $c; });
gradient_of = $.def(function (data, bank, estimate) { let total, square, piece, state, span, model, level, gram, part, x, residual, weight, targets, sums, mean;
{const $v1 = $.unpack($.tup(np.zeros($.add(1, $.ga($.ga(bank, "thresholds"), "size"))), 0.0), 2, -1);total = $v1[0];square = $v1[1];}
for (const $v2 of $.it($.k($.b.zip, [$.ga(data, "pieces"), $.ga(bank, "states")], {"strict": true}))) { {const $v3 = $.unpack($v2, 2, -1);piece = $v3[0];state = $v3[1];}
{span = piece.fitted($.ga(bank, "initial_state"));
if ($.t($.le($.ga(span, "stop"), $.ga(span, "start")))) {continue;}
model = Evaluator($.ga(bank, "thresholds"), $.ga(estimate, "weights"), 0.0, $.ga(estimate, "offset"), state);
level = (piece.unknown_level($.ga(bank, "initial_state")) != null);
gram = Gram($.ga(bank, "thresholds"), state, $.add(1, level));
gram.only_targets(true);
for (const $v4 of $.it(chunks($.b.slice(0, $.ga(span, "start"))))) { part = $v4;
{model.run($.gi($.ga(piece, "x"), part));
gram.skip($.gi($.ga(piece, "x"), part));} }
for (const $v5 of $.it(chunks(span))) { part = $v5;
{x = $.gi($.ga(piece, "x"), part);
residual = $.sub($.gi($.ga(piece, "y"), part), model.run(x));
weight = ($.t(($.ga(piece, "weight") == null)) ? null : $.gi($.ga(piece, "weight"), part));
targets = ($.t(level) ? np.vstack([np.ones($.ga(x, "size")), residual]) : $.gi(residual, $.tup(null, $.slice(null, null, null))));
$.cm(gram, "add", [x, targets, weight]);
square = $.iadd(square, $.b.float($.mm(residual, ($.t((weight == null)) ? residual : $.mul(weight, residual)))));} }
sums = gram.take();
total = $.iadd(total, $.gi(sums, $.tup($.slice(null, $.add(1, $.ga($.ga(bank, "thresholds"), "size")), null), (-1))));
if (($.t(level) && $.t($.gt($.gi(sums, $.tup(0, (-2))), 0.0)))) {mean = $.div($.mul($.sub(1.0, TRACE), $.gi(sums, $.tup(0, (-1)))), $.gi(sums, $.tup(0, (-2))));
total = $.isub(total, $.mul(mean, $.gi(sums, $.tup($.slice(null, $.add(1, $.ga($.ga(bank, "thresholds"), "size")), null), (-2)))));
square = $.isub(square, $.mul(mean, $.b.float($.gi(sums, $.tup(0, (-1))))));}} }
return Gradient(total, square); }, {p: ["data", "bank", "estimate"], ks: false});
refine = $.def(function (data, bank, sums, eps, estimate) { let before, kept, better, after, improved;
if (($.t(($.ga(estimate, "slopes") != null)) || $.t(($.ga(estimate, "passive") == null)) || $.t($.ne($.ga(estimate, "route"), NORMAL)))) {return estimate;}
before = gradient_of(data, bank, estimate);
kept = $.k(replace, [estimate], {"kkt_residual": kkt_residual(sums, $.ga(estimate, "family"), $.ga(estimate, "passive"), before)});
better = _step(sums, eps, estimate, before);
if ($.t((better == null))) {return kept;}
after = gradient_of(data, bank, better);
if ($.t(($.ga(better, "passive") == null))) {return kept;}
better = $.k(replace, [better], {"kkt_residual": kkt_residual(sums, $.ga(better, "family"), $.ga(better, "passive"), after)});
improved = $.le($.ga(after, "square"), $.mul($.ga(before, "square"), $.add(1.0, ROUNDING)));
return (($.t(improved) && $.t($.le($.ga(better, "kkt_residual"), $.b.max($.ga(kept, "kkt_residual"), PROVEN)))) ? better : kept); }, {p: ["data", "bank", "sums", "eps", "estimate"], ks: false});
_step = $.def(function (sums, eps, estimate, gradient) { let n, lower, passive, u, slope, _, step, out, back;
n = $.ga(sums, "operators");
if ($.t(($.ga(estimate, "passive") == null))) {return null;}
lower = np.concatenate([[$.neg($.ga(np, "inf"))], lower_bounds($.ga(estimate, "family"), n, eps)]);
{const $v6 = $.unpack($.tup($.cm($.ga(estimate, "passive"), "copy", []), $.cm($.ga(estimate, "parameters"), "copy", []), $.cm($.ga(gradient, "cells"), "copy", [])), 3, -1);passive = $v6[0];u = $v6[1];slope = $v6[2];}
$.si(passive, 0, true);
for (const $v7 of $.it($.b.range(ROUNDS))) { _ = $v7;
{step = _solved(sums, $.ga(estimate, "family"), $.gi(passive, $.slice(1, $.add(1, n), null)), slope);
if ($.t((step == null))) {return null;}
out = $.band(passive, $.le($.add(u, step), lower));
if (!$.t(out.any())) {$.si(passive, 0, $.gi($.ga(estimate, "passive"), 0));
return estimate_of($.ga(estimate, "family"), n, $.add(u, step), 0.0, $.ga(estimate, "route"), $.ga(estimate, "condition"), passive);}
back = np.where(out, $.sub(lower, u), 0.0);
{const $v8 = $.unpack($.tup($.gi(lower, out), false), 2, -1);$.si(u, out, $v8[0]);$.si(passive, out, $v8[1]);}
slope = $.isub(slope, $.mm($.gi($.ga(sums, "matrix"), $.tup($.slice(null, $.add(1, n), null), $.slice(null, $.add(1, n), null))), np.concatenate([[0.0], slopes_of($.ga(estimate, "family"), $.gi(back, $.slice(1, null, null)))])));} }
return null; }, {p: ["sums", "eps", "estimate", "gradient"], ks: false});
_solved = $.def(function (sums, family, passive, gradient) { let n, starts, free, edges, chosen, matrix, block, right, scale, step, slopes, change;
n = $.ga(sums, "operators");
{const $v9 = $.unpack(_groups(family, passive), 2, -1);starts = $v9[0];free = $v9[1];}
edges = np.concatenate([[0], $.add(1, starts)]);
chosen = np.concatenate([[true], free]);
matrix = $.gi($.ga(sums, "matrix"), $.tup($.slice(null, $.add(1, n), null), $.slice(null, $.add(1, n), null)));
block = $.gi($.km($.ga(np, "add"), "reduceat", [$.km($.ga(np, "add"), "reduceat", [matrix, edges], {"axis": 0}), edges], {"axis": 1}), np.ix_(chosen, chosen));
right = $.gi($.ga(np, "add").reduceat(gradient, edges), chosen);
scale = $.div(1.0, np.sqrt(np.maximum(np.diag(block), 1e-300)));
try {step = $.mul(scale, $.ga(np, "linalg").solve($.mul($.mul(block, $.gi(scale, $.tup($.slice(null, null, null), null))), scale), $.mul(scale, right)));} catch ($e) { $e = $.caught($e); if ($.isinst($e, $.ga($.ga(np, "linalg"), "LinAlgError"))) {  {return null;} } else throw $e; }
slopes = np.zeros($.ga(free, "size"));
$.si(slopes, free, $.gi(step, $.slice(1, null, null)));
change = np.repeat(slopes, np.diff($.cm(np, "append", [starts, n])));
return np.concatenate([$.gi(step, $.slice(null, 1, null)), _from_slopes(family, change)]); }, {p: ["sums", "family", "passive", "gradient"], ks: false});
_groups = $.def(function (family, passive) { let inner, starts, free;
if ($.t($.eq($.gi(BASIS, family), SLOPES))) {return $.tup(np.arange($.ga(passive, "size")), passive);}
inner = $.add(1, np.flatnonzero($.gi(passive, $.slice(1, null, null))));
starts = np.concatenate([[0], inner]);
free = $.km(np, "ones", [$.ga(starts, "size")], {"dtype": $.ga(np, "bool_")});
$.si(free, ($.t($.eq($.gi(BASIS, family), STOPS)) ? (-1) : 0), $.gi(passive, 0));
return $.tup(starts, free); }, {p: ["family", "passive"], ks: false});
_from_slopes = $.def(function (family, change) { 
if ($.t($.eq($.gi(BASIS, family), SLOPES))) {return change;}
if ($.t($.eq($.gi(BASIS, family), STOPS))) {return np.concatenate([$.gi(change, $.slice((-1), null, null)), $.sub($.gi(change, $.slice(null, (-1), null)), $.gi(change, $.slice(1, null, null)))]);}
return $.km(np, "diff", [change], {"prepend": 0.0}); }, {p: ["family", "change"], ks: false});
slopes_of = $.def(function (family, plays) { 
if ($.t($.eq($.gi(BASIS, family), SLOPES))) {return plays;}
if ($.t($.eq($.gi(BASIS, family), STOPS))) {return $.km(np, "asarray", [$.add($.gi(plays, 0), $.cm(np, "append", [$.gi(np.cumsum($.gi(plays, $.slice(null, 0, (-1)))), $.slice(null, null, (-1))), 0.0]))], {"dtype": $.ga(np, "float64")});}
return $.km(np, "asarray", [np.cumsum(plays)], {"dtype": $.ga(np, "float64")}); }, {p: ["family", "plays"], ks: false});
kkt_residual = $.def(function (sums, family, passive, gradient) { let n, matrix, slope, means, level, length, target, told, relative, violation, offset;
{const $v10 = $.unpack($.tup($.ga(sums, "operators"), $.ga(sums, "matrix")), 2, -1);n = $v10[0];matrix = $v10[1];}
slope = transposed(family, $.gi($.ga(gradient, "cells"), $.slice(1, null, null)));
means = transposed(family, $.gi(matrix, $.tup(0, $.slice(1, $.add(1, n), null))));
level = $.b.float($.gi(matrix, $.tup(0, 0)));
length = np.sqrt(np.maximum($.sub(_squares(sums, family), $.div($.pow(means, 2), level)), 0.0));
target = np.sqrt($.b.max($.sub($.b.float($.gi(matrix, $.tup((-1), (-1)))), $.div($.pow($.b.float($.gi(matrix, $.tup(0, (-1)))), 2), level)), 1e-300));
told = $.gt(length, $.mul(1e-07, np.sqrt($.ga(sums, "samples"))));
relative = $.div(np.where(told, slope, 0.0), $.mul(np.where(told, length, 1.0), target));
violation = np.where($.gi(passive, $.slice(1, $.add(1, n), null)), np.abs(relative), np.maximum(relative, 0.0));
offset = $.div($.b.abs($.b.float($.gi($.ga(gradient, "cells"), 0))), $.mul(np.sqrt(level), target));
return $.b.max($.b.float(np.max(violation)), $.b.float(offset)); }, {p: ["sums", "family", "passive", "gradient"], ks: false});
transposed = $.def(function (family, cells) { 
if ($.t($.eq($.gi(BASIS, family), SLOPES))) {return cells;}
if ($.t($.eq($.gi(BASIS, family), STOPS))) {return np.concatenate([[np.sum(cells)], $.gi(np.cumsum(cells), $.slice(null, (-1), null))]);}
return $.gi(np.cumsum($.gi(cells, $.slice(null, null, (-1)))), $.slice(null, null, (-1))); }, {p: ["family", "cells"], ks: false});
_squares = $.def(function (sums, family) { let n, size, diagonal, row, upper, ends, tails, lower;
{const $v11 = $.unpack($.tup($.ga(sums, "operators"), $.gi($.ga($.ga(sums, "matrix"), "shape"), 0)), 2, -1);n = $v11[0];size = $v11[1];}
diagonal = $.gi(np.diag($.ga(sums, "matrix")), $.slice(1, $.add(1, n), null));
if ($.t($.eq($.gi(BASIS, family), SLOPES))) {return diagonal;}
row = np.arange(1, $.add(1, n));
upper = np.zeros(n);
if ($.t($.gt(n, 1))) {ends = $.gi(np.column_stack([$.add($.add($.mul(row, size), row), 1), $.add($.add($.mul(row, size), 1), n)]), $.slice(null, (-1), null));
$.si(upper, $.slice(null, (-1), null), $.gi($.ga(np, "add").reduceat($.ga(sums, "matrix").reshape((-1)), ends.reshape((-1))), $.slice(null, null, 2)));}
tails = $.gi(np.cumsum($.gi($.add(diagonal, $.mul(2.0, upper)), $.slice(null, null, (-1)))), $.slice(null, null, (-1)));
if ($.t($.eq($.gi(BASIS, family), WEIGHTS))) {return tails;}
lower = np.zeros(n);
if ($.t($.gt(n, 1))) {ends = $.gi(np.column_stack([$.add($.mul(row, size), 1), $.add($.mul(row, size), row)]), $.slice(1, null, null));
$.si(lower, $.slice(1, null, null), $.gi($.ga(np, "add").reduceat($.ga(sums, "matrix").reshape((-1)), ends.reshape((-1))), $.slice(null, null, 2)));}
return np.concatenate([$.gi(tails, $.slice(null, 1, null)), $.gi(np.cumsum($.add(diagonal, $.mul(2.0, lower))), $.slice(null, (-1), null))]); }, {p: ["sums", "family"], ks: false});
STEPS = 2;
polish = $.def(function (sums, eps, knots, regularisation, estimate) { let passive, problem, on, square, scale, u, _, slope;
passive = $.ga(estimate, "passive");
if (($.t((passive == null)) || $.t($.ne($.ga(estimate, "route"), NORMAL)))) {return estimate;}
problem = program("modified-pi", sums, eps, knots, regularisation);
on = $.cm(passive, "copy", []);
$.si(on, 0, true);
square = $.gi(_in_weights(problem, $.ga(sums, "operators")), np.ix_(on, on));
scale = $.div(1.0, np.sqrt(np.diag(square)));
square = $.imul(square, $.mul($.gi(scale, $.tup($.slice(null, null, null), null)), scale));
u = $.cm($.ga(estimate, "parameters"), "copy", []);
for (const $v12 of $.it($.b.range(STEPS))) { _ = $v12;
{slope = $.gi(_gradient(problem, sums, np.diff(knots), regularisation, u), on);
try {$.isi(u, on, $.isub, $.mul(scale, $.ga(np, "linalg").solve(square, $.mul(scale, slope))));} catch ($e) { $e = $.caught($e); if ($.isinst($e, $.ga($.ga(np, "linalg"), "LinAlgError"))) {  {return estimate;} } else throw $e; }} }
if ((!$.t(np.all($.gt($.gi(u, passive), $.gi($.ga(problem, "lower"), passive)))) || !$.t(np.all(np.isfinite(u))))) {return estimate;}
return estimate_of($.ga(estimate, "family"), $.ga(sums, "operators"), u, $.ga(estimate, "kkt_residual"), NORMAL, $.ga(estimate, "condition"), passive); }, {p: ["sums", "eps", "knots", "regularisation", "estimate"], ks: false});
_in_weights = $.def(function (problem, n) { let square;
square = $.cm($.ga(problem, "gram"), "copy", []);
$.si(square, $.slice(1, $.add(1, n), null), $.gi($.km(np, "cumsum", [$.gi(square, $.slice(n, 0, (-1)))], {"axis": 0}), $.slice(null, null, (-1))));
$.si(square, $.tup($.slice(null, null, null), $.slice(1, $.add(1, n), null)), $.gi($.km(np, "cumsum", [$.gi(square, $.tup($.slice(null, null, null), $.slice(n, 0, (-1))))], {"axis": 1}), $.tup($.slice(null, null, null), $.slice(null, null, (-1)))));
return ($.t(($.ga(problem, "extra") == null)) ? square : $.add(square, $.ga(problem, "extra"))); }, {p: ["problem", "n"], ks: false});
_gradient = $.def(function (problem, sums, widths, regularisation, u) { let n, v, slope, weights, slopes, bend, rough;
n = $.ga(sums, "operators");
v = $.cm(u, "copy", []);
$.si(v, $.slice(1, $.add(1, n), null), np.cumsum($.gi(u, $.slice(1, $.add(1, n), null))));
slope = $.mm($.ga(problem, "gram"), v);
$.si(slope, $.slice(1, $.add(1, n), null), $.gi(np.cumsum($.gi(slope, $.slice(n, 0, (-1)))), $.slice(null, null, (-1))));
{const $v13 = $.unpack($.tup($.gi(u, $.slice(1, $.add(1, n), null)), $.gi(u, $.slice($.add(1, n), null, null))), 2, -1);weights = $v13[0];slopes = $v13[1];}
bend = np.diff(slopes);
$.isi(slope, $.slice(1, $.add(1, n), null), $.iadd, $.mul($.mul($.ga(sums, "samples"), $.pow($.ga(regularisation, "ridge"), 2)), weights));
rough = np.zeros_like(slopes);
$.isi(rough, $.slice(1, null, null), $.iadd, bend);
$.isi(rough, $.slice(null, (-1), null), $.isub, bend);
$.isi(slope, $.slice($.add(1, n), null, null), $.iadd, $.mul($.ga(sums, "samples"), $.add($.mul($.pow($.ga(regularisation, "smoothing"), 2), rough), $.mul($.mul($.pow(NORMALISATION, 2), $.b.float($.mm(widths, $.sub(slopes, 1.0)))), widths))));
return slope; }, {p: ["problem", "sums", "widths", "regularisation", "u"], ks: false});
Object.assign($m, {"annotations": annotations, "dataclass": dataclass, "replace": replace, "np": np, "npt": npt, "SLOPES": SLOPES, "STOPS": STOPS, "WEIGHTS": WEIGHTS, "Evaluator": Evaluator, "Gram": Gram, "Array": Array_, "DataSet": DataSet, "chunks": chunks, "BASIS": BASIS, "NORMAL": NORMAL, "NORMALISATION": NORMALISATION, "Estimate": Estimate, "Program": Program, "Regularisation": Regularisation, "estimate_of": estimate_of, "lower_bounds": lower_bounds, "program": program, "TRACE": TRACE, "Bank": Bank, "NormalEquations": NormalEquations, "Marks": Marks, "ROUNDING": ROUNDING, "PROVEN": PROVEN, "ROUNDS": ROUNDS, "Gradient": Gradient, "gradient_of": gradient_of, "refine": refine, "_step": _step, "_solved": _solved, "_groups": _groups, "_from_slopes": _from_slopes, "slopes_of": slopes_of, "kkt_residual": kkt_residual, "transposed": transposed, "_squares": _squares, "STEPS": STEPS, "polish": polish, "_in_weights": _in_weights, "_gradient": _gradient});
});
$.module("dehyst.identification.regressors", ($m) => {
let annotations, Callable, Iterator, dataclass, replace, np, npt, _native, Gram, Array_, ParameterError, DataSet, Piece, Signal, chunks, extremes, state_before, HysteresisModel, MOVED, Bank, make_bank, _extremes, _state, fitted_samples, blocks, settled, started, _settled, _miss, TRACE, NormalEquations, sums_of, without_level, ramp_columns;
Callable = $.from("collections.abc", "Callable");Iterator = $.from("collections.abc", "Iterator");
dataclass = $.from("dataclasses", "dataclass");replace = $.from("dataclasses", "replace");
np = $.imp("numpy");
npt = $.imp("numpy.typing");
_native = $.imp("dehyst._native");
Gram = $.from("dehyst._native", "Gram");
Array_ = $.from("dehyst.arrays", "Array");
ParameterError = $.from("dehyst.errors", "ParameterError");
DataSet = $.from("dehyst.identification.data", "DataSet");Piece = $.from("dehyst.identification.data", "Piece");Signal = $.from("dehyst.identification.data", "Signal");chunks = $.from("dehyst.identification.data", "chunks");extremes = $.from("dehyst.identification.data", "extremes");
state_before = $.from("dehyst.identification.memory", "state_before");
HysteresisModel = $.from("dehyst.models.base", "HysteresisModel");
MOVED = 1e-06;
Bank = $.cls("Bank", [], "", [["thresholds", null], ["undetermined", null], ["states", null], ["initial_state", null]], true, true, ($c) => { Bank = $c; });
make_bank = $.def(function (data, thresholds, initial_state) { let states, low, high, moved, piece, state, fitted, least, most, kept;
states = $.b.tuple((function* () { for (const $v1 of $.it($.ga(data, "pieces"))) { let piece; piece = $v1; yield _state(data, piece, thresholds, initial_state); } })());
low = np.full($.ga(thresholds, "size"), $.ga(np, "inf"));
high = np.full($.ga(thresholds, "size"), $.neg($.ga(np, "inf")));
moved = $.km(np, "zeros", [$.ga(thresholds, "size")], {"dtype": $.ga(np, "bool_")});
for (const $v2 of $.it($.k($.b.zip, [$.ga(data, "pieces"), states], {"strict": true}))) { {const $v3 = $.unpack($v2, 2, -1);piece = $v3[0];state = $v3[1];}
{fitted = piece.fitted(initial_state);
if ($.t($.gt($.ga(fitted, "stop"), $.ga(fitted, "start")))) {{const $v4 = $.unpack(_extremes($.ga(piece, "x"), fitted, thresholds, state), 2, -1);least = $v4[0];most = $v4[1];}
if ($.t(piece.unknown_level(initial_state))) {moved = $.ibor(moved, $.gt($.sub(most, least), MOVED));} else {{const $v5 = $.unpack($.tup(np.minimum(low, least), np.maximum(high, most)), 2, -1);low = $v5[0];high = $v5[1];}}}} }
moved = $.ibor(moved, $.gt($.sub(high, low), MOVED));
$.si(moved, 0, true);
kept = np.ascontiguousarray($.gi(thresholds, moved));
return Bank(kept, $.gi(thresholds, $.inv(moved)), $.b.tuple((function* () { for (const $v6 of $.it(states)) { let s; s = $v6; yield np.ascontiguousarray($.gi(s, moved)); } })()), initial_state); }, {p: ["data", "thresholds", "initial_state"], ks: false});
_extremes = $.def(function (x, fitted, thresholds, state) { let part, _, low, high;
for (const $v7 of $.it(chunks($.b.slice(0, $.add($.ga(fitted, "start"), 1))))) { part = $v7;
{{const $v8 = $.unpack(_native.play_bank($.gi(x, part), thresholds, state, $.km(np, "zeros", [0], {"dtype": $.ga(np, "int64")})), 2, -1);_ = $v8[0];state = $v8[1];}} }
{const $v9 = $.unpack(extremes(x, fitted), 2, -1);low = $v9[0];high = $v9[1];}
return $.tup(np.minimum(state, $.add(low, thresholds)), np.maximum(state, $.sub(high, thresholds))); }, {p: ["x", "fitted", "thresholds", "state"], ks: false});
_state = $.def(function (data, piece, thresholds, initial_state) { let within;
within = piece.unknown_level(initial_state);
if ($.t((within != null))) {return np.full($.ga(thresholds, "size"), $.mul(0.5, $.add($.gi(within, 0), $.gi(within, 1))));}
return $.k(state_before, [($.t($.ga(piece, "after_break")) ? "unknown" : initial_state), thresholds, $.b.float($.gi($.ga(piece, "x"), 0))], {"low": (-1.0), "high": 1.0, "origin": $.div($.neg($.ga(data, "center")), $.ga(data, "half_range"))}); }, {p: ["data", "piece", "thresholds", "initial_state"], ks: false});
fitted_samples = $.def(function (data, initial_state) { let spans;
spans = (() => { const $r = []; for (const $v10 of $.it($.ga(data, "pieces"))) { let piece; piece = $v10; $r.push(piece.fitted(initial_state)); } return $r; })();
return $.b.sum((function* () { for (const $v11 of $.it($.k($.b.zip, [$.ga(data, "pieces"), spans], {"strict": true}))) { let piece, span; {const $v12 = $.unpack($v11, 2, -1);piece = $v12[0];span = $v12[1];} yield ($.t(($.ga(piece, "weight") == null)) ? $.sub($.ga(span, "stop"), $.ga(span, "start")) : $.b.int(np.count_nonzero($.gi($.ga(piece, "weight"), span)))); } })()); }, {p: ["data", "initial_state"], ks: false});
blocks = $.def(function* (x, thresholds, state, rows, size) { let part, _, plays;
for (const $v13 of $.it(chunks($.b.slice(0, $.ga(rows, "start"))))) { part = $v13;
{{const $v14 = $.unpack(_native.play_bank($.gi(x, part), thresholds, state, $.km(np, "zeros", [0], {"dtype": $.ga(np, "int64")})), 2, -1);_ = $v14[0];state = $v14[1];}} }
for (const $v15 of $.it(chunks(rows, size))) { part = $v15;
{{const $v16 = $.unpack(_native.play_bank($.gi(x, part), thresholds, state, $.km(np, "arange", [$.sub($.ga(part, "stop"), $.ga(part, "start"))], {"dtype": $.ga(np, "int64")})), 2, -1);plays = $v16[0];state = $v16[1];}
(yield $.tup(part, plays));} } }, {p: ["x", "thresholds", "state", "rows", "size"], ks: false});
settled = $.def(function (data, bank, model) { let pairs;
pairs = $.k($.b.zip, [$.ga(data, "pieces"), $.ga(bank, "states")], {"strict": true});
return $.k(replace, [bank], {"states": $.b.tuple((function* () { for (const $v17 of $.it(pairs)) { let piece, state; {const $v18 = $.unpack($v17, 2, -1);piece = $v18[0];state = $v18[1];} yield _settled(data, bank, model, piece, state); } })())}); }, {p: ["data", "bank", "model"], ks: false});
started = $.def(function (data, bank, model, state) { let kept;
kept = np.searchsorted($.mul($.ga(bank, "thresholds"), $.ga(data, "half_range")), $.ga(model, "radii"));
return model.with_state($.mul($.gi(state, kept), $.ga(data, "half_range"))); }, {p: ["data", "bank", "model", "state"], ks: false});
_settled = $.def(function (data, bank, model, piece, state) { let within, span, spare, low, high, moved;
{const $v19 = $.unpack($.tup(piece.unknown_level($.ga(bank, "initial_state")), piece.fitted($.ga(bank, "initial_state"))), 2, -1);within = $v19[0];span = $v19[1];}
if ($.t($.le($.ga(span, "stop"), $.ga(span, "start")))) {span = piece.held_out($.ga(bank, "initial_state"));}
if (($.t((within == null)) || $.t($.le($.ga(span, "stop"), $.ga(span, "start"))))) {return state;}
spare = np.maximum($.sub($.ga(bank, "thresholds"), $.mul(0.5, $.sub($.gi(within, 1), $.gi(within, 0)))), 0.0);
{const $v21 = $.unpack((function* () { for (const $v20 of $.it($.tup((-1.0), 1.0))) { let side; side = $v20; yield _miss(data, piece, span, started(data, bank, model, $.add(state, $.mul(side, spare)))); } })(), 2, -1);low = $v21[0];high = $v21[1];}
if ($.t($.eq(low, high))) {return state;}
moved = $.add(state, $.mul($.b.float(np.clip($.div($.add(low, high), $.sub(low, high)), (-1.0), 1.0)), spare));
return moved; }, {p: ["data", "bank", "model", "piece", "state"], ks: false});
_miss = $.def(function (data, piece, span, model) { let stepper, total, part, output, miss;
{const $v22 = $.unpack($.tup(model.stepper("dense"), 0.0), 2, -1);stepper = $v22[0];total = $v22[1];}
for (const $v23 of $.it(chunks($.b.slice(0, $.ga(span, "start"))))) { part = $v23;
{stepper.simulate($.add($.ga(data, "center"), $.mul($.ga(data, "half_range"), $.gi($.ga(piece, "x"), part))));} }
for (const $v24 of $.it(chunks(span))) { part = $v24;
{output = $.gi(stepper.simulate($.add($.ga(data, "center"), $.mul($.ga(data, "half_range"), $.gi($.ga(piece, "x"), part)))), 0);
miss = $.sub($.add($.ga(data, "level"), $.mul($.mul($.ga(data, "trend"), $.ga(data, "amplitude")), $.gi($.ga(piece, "y"), part))), output);
total = $.iadd(total, $.b.float(($.t(($.ga(piece, "weight") == null)) ? np.sum(miss) : $.mm(miss, $.gi($.ga(piece, "weight"), part)))));} }
return total; }, {p: ["data", "piece", "span", "model"], ks: false});
TRACE = 1e-12;
NormalEquations = $.cls("NormalEquations", [], "", [["thresholds", null], ["matrix", null], ["counted", () => null]], true, false, ($c) => { NormalEquations = $c; $.prop($c, "operators", $.def(function () { const self = this;
return $.ga($.ga(self, "thresholds"), "size"); }, {p: [], ks: false}));
$.prop($c, "samples", $.def(function () { const self = this;
return ($.t(($.ga(self, "counted") == null)) ? $.b.float($.gi($.ga(self, "matrix"), $.tup(0, 0))) : $.ga(self, "counted")); }, {p: [], ks: false}));
$.meth($c, "__add__", $.def(function (other) { const self = this;let counted;
if ((!$.t(np.array_equal($.ga(self, "thresholds"), $.ga(other, "thresholds"))) || $.t($.ne($.ga($.ga(self, "matrix"), "shape"), $.ga($.ga(other, "matrix"), "shape"))))) {throw $.exc($.k(ParameterError, [("" + "sums over " + $.f($.ga(self, "operators"), "", -1) + " and " + $.f($.ga(other, "operators"), "", -1) + " operators (matrices " + $.f($.ga($.ga(self, "matrix"), "shape"), "", -1) + " and " + $.f($.ga($.ga(other, "matrix"), "shape"), "", -1) + ") belong to different columns and cannot be added. Accumulate both with the same thresholds and the same extra columns.")], {"operators": $.tup($.ga(self, "operators"), $.ga(other, "operators"))}));}
counted = ($.t((($t0, $t1) => $.t(($.ga(self, "counted") === ($t0 = $.ga(other, "counted")))) && $.t(($t0 == null)))()) ? null : $.add($.ga(self, "samples"), $.ga(other, "samples")));
return NormalEquations($.ga(self, "thresholds"), $.add($.ga(self, "matrix"), $.ga(other, "matrix")), counted); }, {p: ["other"], ks: false}));
$.meth($c, "coarser", $.def(function (kept) { const self = this;let n, starts, merged;
if (($.t($.ne($.ga(kept, "shape"), $.ga($.ga(self, "thresholds"), "shape"))) || !$.t($.gi(kept, 0)))) {throw $.exc($.k(ParameterError, [("" + "kept must have one entry for each of the " + $.f($.ga(self, "operators"), "", -1) + " operators and keep the first: without a play of radius 0 the model has no inverse.")], {"operators": $.ga(self, "operators")}));}
n = $.ga(self, "operators");
starts = np.concatenate([[0], $.add(1, np.flatnonzero(kept)), np.arange($.add(1, n), $.gi($.ga($.ga(self, "matrix"), "shape"), 0))]);
merged = $.km($.ga(np, "add"), "reduceat", [$.km($.ga(np, "add"), "reduceat", [$.ga(self, "matrix"), starts], {"axis": 0}), starts], {"axis": 1});
return NormalEquations($.gi($.ga(self, "thresholds"), kept), merged, $.ga(self, "counted")); }, {p: ["kept"], ks: false}));});
sums_of = $.def(function (data, bank, knots = null, span = null) { let targets, total, count, freed, piece, state, chosen, gram, part, y, columns, sums;
targets = $.add(1, ($.t((knots == null)) ? 0 : $.sub($.ga(knots, "size"), 1)));
total = null;
{const $v25 = $.unpack($.tup(0.0, false), 2, -1);count = $v25[0];freed = $v25[1];}
for (const $v26 of $.it($.k($.b.zip, [$.ga(data, "pieces"), $.ga(bank, "states")], {"strict": true}))) { {const $v27 = $.unpack($v26, 2, -1);piece = $v27[0];state = $v27[1];}
{chosen = ($.t((span == null)) ? piece.fitted($.ga(bank, "initial_state")) : span(piece));
if ($.t($.le($.ga(chosen, "stop"), $.ga(chosen, "start")))) {continue;}
gram = Gram($.ga(bank, "thresholds"), state, targets);
for (const $v28 of $.it(chunks($.b.slice(0, $.ga(chosen, "start"))))) { part = $v28;
{gram.skip($.gi($.ga(piece, "x"), part));} }
for (const $v29 of $.it(chunks(chosen))) { part = $v29;
{y = $.gi($.gi($.ga(piece, "y"), part), $.tup(null, $.slice(null, null, null)));
columns = ($.t((knots == null)) ? y : np.concatenate([ramp_columns($.gi(y, 0), knots), y]));
$.cm(gram, "add", [$.gi($.ga(piece, "x"), part), columns, ($.t(($.ga(piece, "weight") == null)) ? null : $.gi($.ga(piece, "weight"), part))]);} }
sums = gram.take();
count = $.iadd(count, $.b.float($.gi(sums, $.tup(0, 0))));
if ($.t(piece.unknown_level($.ga(bank, "initial_state")))) {{const $v30 = $.unpack($.tup(true, without_level(sums)), 2, -1);freed = $v30[0];sums = $v30[1];}}
total = ($.t((total == null)) ? sums : $.cm(np, "add", [total, sums], {"out": total}));} }
if ($.t((total == null))) {throw $.exc($.b.AssertionError("no rows to fit"));}
return NormalEquations($.ga(bank, "thresholds"), total, ($.t(freed) ? count : null)); }, {p: ["data", "bank", "knots", "span"], ks: false});
without_level = $.def(function (matrix) { let count;
count = $.b.float($.gi(matrix, $.tup(0, 0)));
return ($.t($.eq(count, 0.0)) ? matrix : $.sub(matrix, $.mul($.div($.sub(1.0, TRACE), count), np.outer($.gi(matrix, 0), $.gi(matrix, 0))))); }, {p: ["matrix"], ks: false});
ramp_columns = $.def(function (y, knots) { let ramp;
ramp = np.subtract(y, $.gi(knots, $.tup($.slice(null, (-1), null), null)));
return $.km(np, "clip", [ramp, 0.0, $.gi(np.diff(knots), $.tup($.slice(null, null, null), null))], {"out": ramp}); }, {p: ["y", "knots"], ks: false});
Object.assign($m, {"annotations": annotations, "Callable": Callable, "Iterator": Iterator, "dataclass": dataclass, "replace": replace, "np": np, "npt": npt, "_native": _native, "Gram": Gram, "Array": Array_, "ParameterError": ParameterError, "DataSet": DataSet, "Piece": Piece, "Signal": Signal, "chunks": chunks, "extremes": extremes, "state_before": state_before, "HysteresisModel": HysteresisModel, "MOVED": MOVED, "Bank": Bank, "make_bank": make_bank, "_extremes": _extremes, "_state": _state, "fitted_samples": fitted_samples, "blocks": blocks, "settled": settled, "started": started, "_settled": _settled, "_miss": _miss, "TRACE": TRACE, "NormalEquations": NormalEquations, "sums_of": sums_of, "without_level": without_level, "ramp_columns": ramp_columns});
});
$.module("dehyst.identification.residual", ($m) => {
let annotations, math, Iterator, Sequence, dataclass, replace, Any, NamedTuple, np, _native, Array_, Mask, Rows, TURN_FRACTION, turning_points, Recording, spread, single_blas, TITLES, CAUSES, MOST_ROWS, FEWEST, BLOCKS, PLACES, KNOTS, LAGS, MOST_LAGGING, USUAL, RIDGE, NOTHING, WORTH, OWN, RIVAL, MOSTLY, SAME_PLACE, SAME_TIME, FEWEST_PAIRS, MOST_PAIRS, PHASES, DIFFERENCE, Cause, Residual, residual_structure, _Features, _Span, _spans, _Table, _solved, _columns, _knots, _hats, _noise, _suggestions, _cure, _late;
math = $.imp("math");
Iterator = $.from("collections.abc", "Iterator");Sequence = $.from("collections.abc", "Sequence");
dataclass = $.from("dataclasses", "dataclass");replace = $.from("dataclasses", "replace");
Any = $.from("typing", "Any");NamedTuple = $.from("typing", "NamedTuple");
np = $.imp("numpy");
_native = $.imp("dehyst._native");
Array_ = $.from("dehyst.arrays", "Array");Mask = $.from("dehyst.arrays", "Mask");Rows = $.from("dehyst.arrays", "Rows");
TURN_FRACTION = $.from("dehyst.data.loops", "TURN_FRACTION");turning_points = $.from("dehyst.data.loops", "turning_points");
Recording = $.from("dehyst.data.recording", "Recording");
spread = $.from("dehyst.identification.facts", "spread");
single_blas = $.from("dehyst.identification.threads", "single_blas");
TITLES = $.dict([["offset", "one offset"], ["drift", "drift along the log"], ["position", "the position"], ["way-since-turn", "the way since the last turn"], ["time-since-turn", "the time since the last turn (creep)"], ["rate", "the rate of the input"], ["delay", "the slope of the output (a delay)"]]);
CAUSES = $.b.tuple(TITLES);
MOST_ROWS = 20000;
FEWEST = 100;
BLOCKS = 10;
PLACES = 7;
KNOTS = $.tup(0.0, 0.05, 0.15, 0.35, 0.65, 1.0);
LAGS = np.array([0.3, 1.0, 3.0]);
MOST_LAGGING = 50000;
USUAL = 0.95;
RIDGE = 0.0001;
NOTHING = 1e-09;
WORTH = 0.1;
OWN = 0.05;
RIVAL = 0.8;
MOSTLY = 0.5;
{const $v1 = $.unpack($.tup(0.02, 0.05), 2, -1);SAME_PLACE = $v1[0];SAME_TIME = $v1[1];}
{const $v2 = $.unpack($.tup(6, 400, 64), 3, -1);FEWEST_PAIRS = $v2[0];MOST_PAIRS = $v2[1];PHASES = $v2[2];}
DIFFERENCE = np.array([1.0, (-3.0), 3.0, (-1.0)]);
Cause = $.cls("Cause", [], "", [["name", null], ["share", null], ["own", null], ["size_percent", null]], true, true, ($c) => { Cause = $c; $.prop($c, "words", $.def(function () { const self = this;
return ("" + $.f(($.t($.eq($.ga(self, "name"), "offset")) ? "is" : "follows"), "", -1) + " " + $.f($.gi(TITLES, $.ga(self, "name")), "", -1)); }, {p: [], ks: false}));
$.meth($c, "as_dict", $.def(function () { const self = this;
return $.dict([["name", $.ga(self, "name")], ["share", $.ga(self, "share")], ["own", $.ga(self, "own")], ["size_percent", $.ga(self, "size_percent")]]); }, {p: [], ks: false}));});
Residual = $.cls("Residual", [], "", [["part", null], ["rms_percent", null], ["causes", () => $.tup()], ["explained", () => 0.0], ["noise_percent", () => null], ["noise_from", () => ""], ["delay", () => 0.0], ["timed", () => false], ["suggestions", () => $.tup()]], true, true, ($c) => { Residual = $c; $.prop($c, "largest", $.def(function () { const self = this;let found;
found = $.k($.b.max, [$.ga(self, "causes")], {"key": $.def((cause) => {  return $.b.round($.ga(cause, "share"), 2); }, {p: ["cause"], ks: false}), "default": null});
return (($.t((found != null)) && $.t($.gt($.ga(found, "share"), 0.0))) ? found : null); }, {p: [], ks: false}));
$.prop($c, "noise_share", $.def(function () { const self = this;
if (($.t(($.ga(self, "noise_percent") == null)) || !$.t($.gt($.ga(self, "rms_percent"), 0.0)))) {return null;}
return $.b.min(1.0, $.pow($.div($.ga(self, "noise_percent"), $.ga(self, "rms_percent")), 2)); }, {p: [], ks: false}));
$.meth($c, "as_dict", $.def(function () { const self = this;
return $.dict([["part", $.ga(self, "part")], ["rms_percent", $.ga(self, "rms_percent")], ["causes", (() => { const $r = []; for (const $v3 of $.it($.ga(self, "causes"))) { let cause; cause = $v3; $r.push(cause.as_dict()); } return $r; })()], ["explained", $.ga(self, "explained")], ["noise_percent", $.ga(self, "noise_percent")], ["noise_share", $.ga(self, "noise_share")], ["noise_from", $.ga(self, "noise_from")], ["delay", $.ga(self, "delay")], ["suggestions", $.b.list($.ga(self, "suggestions"))]]); }, {p: [], ks: false}));});
residual_structure = $.def(function (recordings, predictions, masks, output_range, part = "held-out", knows_time = false) { let timed, spans, samples, rows, squares, count, rms, found, times, table, causes, noise, source;
timed = $.b.all((function* () { for (const $v4 of $.it(recordings)) { let recording; recording = $v4; yield ($.ga(recording, "time") != null); } })());
spans = _spans(recordings, predictions, masks);
samples = $.b.sum((function* () { for (const $v5 of $.it(spans)) { let span; span = $v5; yield $.ga($.ga(span, "counted"), "size"); } })());
rows = (() => { const $r = []; for (const $v6 of $.it(spans)) { let span; span = $v6; $r.push(span.rows($.b.max(1, $.b.round($.div($.mul(MOST_ROWS, $.ga($.ga(span, "counted"), "size")), samples))))); } return $r; })();
squares = $.b.sum((function* () { for (const $v7 of $.it($.k($.b.zip, [spans, rows], {"strict": true}))) { let span, at; {const $v8 = $.unpack($v7, 2, -1);span = $v8[0];at = $v8[1];} yield $.b.float(np.sum($.pow($.gi($.ga(span, "e"), at), 2))); } })());
count = $.b.sum((function* () { for (const $v9 of $.it(rows)) { let at; at = $v9; yield $.ga(at, "size"); } })());
rms = $.div($.mul(100.0, $.b.float(np.sqrt($.div(squares, $.b.max(1, count))))), output_range);
found = $.k(Residual, [part, rms], {"timed": timed});
if (($.t($.lt(count, FEWEST)) || !$.t($.gt(rms, $.mul(100.0, NOTHING))))) {return found;}
times = $.mul(LAGS, $.b.float(np.median((() => { const $r = []; for (const $v10 of $.it(spans)) { let span; span = $v10; $r.push($.ga(span, "stroke")); } return $r; })())));
{ const $v13 = single_blas(); $.enter($v13); try {table = _Table((() => { const $r = []; for (const $v11 of $.it($.k($.b.zip, [spans, rows], {"strict": true}))) { let span, at; {const $v12 = $.unpack($v11, 2, -1);span = $v12[0];at = $v12[1];} $r.push(span.features(at, times)); } return $r; })());
causes = table.causes(rms);} catch ($e) { if (!$.exit($v13, $.caught($e))) throw $e; } }
{const $v14 = $.unpack(_noise(spans, rows), 2, -1);noise = $v14[0];source = $v14[1];}
found = $.k(replace, [found], {"causes": causes, "explained": $.ga(table, "explained"), "noise_percent": ($.t((noise == null)) ? null : $.div($.mul(100.0, noise), output_range)), "noise_from": source, "delay": $.ga(table, "delay")});
return $.k(replace, [found], {"suggestions": $.b.tuple(_suggestions(found, knows_time))}); }, {p: ["recordings", "predictions", "masks", "output_range", "part", "knows_time"], ks: false});
_Features = $.cls("_Features", [], "NamedTuple", [["e", null], ["x", null], ["way", null], ["since", null], ["sign", null], ["height", null], ["speed", null], ["slope", null], ["lags", null]], false, true, ($c) => { _Features = $c; });
_Span = $.cls("_Span", [], "", [], false, true, ($c) => { _Span = $c; $.meth($c, "__init__", $.def(function (time, x, f, e, counted, width) { const self = this;
{const $v15 = $.unpack($.tup(time, x, f, e, counted, width), 6, -1);self.time = $v15[0];self.x = $v15[1];self.f = $v15[2];self.e = $v15[3];self.counted = $v15[4];self.width = $v15[5];}
self.turns = turning_points(x, $.mul(TURN_FRACTION, width)); }, {p: ["time", "x", "f", "e", "counted", "width"], ks: false}));
$.meth($c, "rows", $.def(function (most) { const self = this;
return $.gi($.ga(self, "counted"), spread(0, $.ga($.ga(self, "counted"), "size"), most)); }, {p: ["most"], ks: false}));
$.meth($c, "jumps", $.def(function (at) { const self = this;let counts, four;
counts = $.km(np, "zeros", [$.ga($.ga(self, "x"), "size")], {"dtype": $.ga(np, "bool_")});
$.si(counts, $.ga(self, "counted"), true);
four = $.add($.gi($.gi(at, $.lt(at, $.sub($.ga($.ga(self, "x"), "size"), 3))), $.tup($.slice(null, null, null), null)), np.arange(4));
return np.asarray($.mm($.gi($.ga(self, "e"), $.gi(four, $.km($.gi(counts, four), "all", [], {"axis": 1}))), DIFFERENCE)); }, {p: ["at"], ks: false}));
$.meth($c, "repeats", $.def(function () { const self = this;let begin, end, inside, before, places, duration, alike, order, next_ones, chosen, phase, first, second;
{const $v16 = $.unpack($.tup($.gi($.ga(self, "turns"), $.slice(1, (-2), null)), $.gi($.ga(self, "turns"), $.slice(2, (-1), null))), 2, -1);begin = $v16[0];end = $v16[1];}
inside = $.eq($.sub(np.searchsorted($.ga(self, "counted"), end), np.searchsorted($.ga(self, "counted"), begin)), $.sub(end, begin));
{const $v17 = $.unpack($.tup($.gi(begin, inside), $.gi(end, inside)), 2, -1);begin = $v17[0];end = $v17[1];}
before = $.gi($.ga(self, "turns"), $.sub(np.searchsorted($.ga(self, "turns"), begin), 1));
places = (() => { const $r = []; for (const $v18 of $.it($.tup(begin, end, before))) { let at; at = $v18; $r.push(np.round($.div($.gi($.ga(self, "x"), at), $.mul(SAME_PLACE, $.ga(self, "width"))))); } return $r; })();
duration = np.round($.div(np.log($.sub($.gi($.ga(self, "time"), end), $.gi($.ga(self, "time"), begin))), SAME_TIME));
alike = $.gi($.km(np, "unique", [np.stack([...$.it(places), duration])], {"axis": 1, "return_inverse": true}), 1).ravel();
order = $.km(np, "argsort", [alike], {"kind": "stable"});
next_ones = np.flatnonzero($.eq(np.diff($.gi(alike, order)), 0));
chosen = $.gi(next_ones, spread(0, $.ga(next_ones, "size"), MOST_PAIRS));
phase = $.div($.add(np.arange(PHASES), 0.5), PHASES);
{const $v20 = $.unpack((function* () { for (const $v19 of $.it($.tup($.gi(order, chosen), $.gi(order, $.add(chosen, 1))))) { let at; at = $v19; yield $.add($.gi(begin, $.tup(at, null)), np.round($.mul(phase, $.gi($.sub(end, begin), $.tup(at, null)))).astype($.ga(np, "int64"))); } })(), 2, -1);first = $v20[0];second = $v20[1];}
return np.asarray($.sub($.gi($.ga(self, "e"), first), $.gi($.ga(self, "e"), second))); }, {p: [], ks: false}));
$.prop($c, "stroke", $.def(function () { const self = this;
return $.div($.b.float($.sub($.gi($.ga(self, "time"), (-1)), $.gi($.ga(self, "time"), 0))), $.b.max(1, $.sub($.ga($.ga(self, "turns"), "size"), 1))); }, {p: [], ks: false}));
$.meth($c, "behind", $.def(function (at, times) { const self = this;let every, none, time, x, ahead;
{const $v21 = $.unpack($.tup($.b.max(1, $.fdiv($.ga($.ga(self, "x"), "size"), MOST_LAGGING)), np.zeros(0)), 2, -1);every = $v21[0];none = $v21[1];}
{const $v22 = $.unpack($.tup(np.ascontiguousarray($.gi($.ga(self, "time"), $.slice(null, null, every))), np.ascontiguousarray($.gi($.ga(self, "x"), $.slice(null, null, every)))), 2, -1);time = $v22[0];x = $v22[1];}
ahead = $.gi(_native.direct_bank(x, time, none, none, times, true), 0);
return np.column_stack((() => { const $r = []; for (const $v23 of $.it($.ga(ahead, "T"))) { let one; one = $v23; $r.push(np.interp($.gi($.ga(self, "time"), at), time, one)); } return $r; })()); }, {p: ["at", "times"], ks: false}));
$.meth($c, "features", $.def(function (at, times) { const self = this;let x, time, turns, stroke, begin, heights, sign, half, low, high, step;
{const $v24 = $.unpack($.tup($.ga(self, "x"), $.ga(self, "time"), $.ga(self, "turns")), 3, -1);x = $v24[0];time = $v24[1];turns = $v24[2];}
stroke = np.clip($.sub($.km(np, "searchsorted", [turns, at], {"side": "right"}), 1), 0, $.b.max(0, $.sub($.ga(turns, "size"), 2)));
begin = $.gi(turns, stroke);
heights = $.div(np.abs($.km(np, "diff", [$.gi(x, turns)], {"prepend": $.gi(x, $.gi(turns, 0))})), $.ga(self, "width"));
sign = np.sign($.sub($.gi(x, $.gi(turns, np.minimum($.add(stroke, 1), $.sub($.ga(turns, "size"), 1)))), $.gi(x, begin)));
half = $.b.max(1, $.b.round($.div($.div($.ga(x, "size"), $.b.max(1, $.sub($.ga(turns, "size"), 1))), 40)));
{const $v25 = $.unpack($.tup(np.maximum($.sub(at, half), 0), np.minimum($.add(at, half), $.sub($.ga(x, "size"), 1))), 2, -1);low = $v25[0];high = $v25[1];}
step = $.sub($.gi(time, high), $.gi(time, low));
return _Features($.gi($.ga(self, "e"), at), $.gi(x, at), np.abs($.sub($.gi(x, at), $.gi(x, begin))), $.sub($.gi(time, at), $.gi(time, begin)), sign, $.gi(heights, stroke), $.div($.sub($.gi(x, high), $.gi(x, low)), step), $.div($.sub($.gi($.ga(self, "f"), high), $.gi($.ga(self, "f"), low)), step), self.behind(at, times)); }, {p: ["at", "times"], ks: false}));});
_spans = $.def(function (recordings, predictions, masks) { let width, timed, found, recording, f, mask, time, piece, counted, e;
width = $.sub($.b.max((function* () { for (const $v26 of $.it(recordings)) { let r; r = $v26; yield $.ga(r, "input").max(); } })()), $.b.min((function* () { for (const $v27 of $.it(recordings)) { let r; r = $v27; yield $.ga(r, "input").min(); } })()));
timed = $.b.all((function* () { for (const $v28 of $.it(recordings)) { let recording; recording = $v28; yield ($.ga(recording, "time") != null); } })());
found = [];
for (const $v29 of $.it($.k($.b.zip, [recordings, predictions, masks], {"strict": true}))) { {const $v30 = $.unpack($v29, 3, -1);recording = $v30[0];f = $v30[1];mask = $v30[2];}
{time = (($.t(timed) && $.t(($.ga(recording, "time") != null))) ? $.ga(recording, "time") : $.km(np, "arange", [$.b.len(recording)], {"dtype": $.ga(np, "float64")}));
for (const $v31 of $.it($.ga(recording, "pieces"))) { piece = $v31;
{counted = np.flatnonzero($.gi(mask, piece));
if ($.t($.gt($.ga(counted, "size"), 1))) {e = $.sub($.gi($.ga(recording, "output"), piece), $.gi(f, piece));
$.cm(found, "append", [_Span($.gi(time, piece), $.gi($.ga(recording, "input"), piece), $.gi(f, piece), e, counted, $.b.float(width))]);}} }} }
return found; }, {p: ["recordings", "predictions", "masks"], ks: false});
_Table = $.cls("_Table", [], "", [], false, true, ($c) => { _Table = $c; $.meth($c, "__init__", $.def(function (parts) { const self = this;let seen, groups, ends, rows, even;
seen = _Features(...$.it((function* () { for (const $v32 of $.it($.k($.b.zip, [...$.it(parts)], {"strict": true}))) { let values; values = $v32; yield np.concatenate(values); } })()));
groups = $.dict([["offset", np.ones($.tup($.ga($.ga(seen, "e"), "size"), 1))], ...$.pairs(_columns(seen))]);
ends = np.cumsum([0, ...$.it((function* () { for (const $v33 of $.it($.cm(groups, "values", []))) { let columns; columns = $v33; yield $.gi($.ga(columns, "shape"), 1); } })())]).tolist();
self.columns = $.dict((() => { const $r = []; for (const $v34 of $.it($.k($.b.zip, [groups, $.gi(ends, $.slice(null, (-1), null)), $.gi(ends, $.slice(1, null, null))], {"strict": true}))) { let name, a, b; {const $v35 = $.unpack($v34, 3, -1);name = $v35[0];a = $v35[1];b = $v35[2];} $r.push([name, np.arange(a, b)]); } return $r; })());
rows = np.column_stack([...$.it($.cm(groups, "values", [])), $.ga(seen, "e")]);
even = $.eq($.mod($.fdiv($.mul(np.arange($.ga($.ga(seen, "e"), "size")), BLOCKS), $.ga($.ga(seen, "e"), "size")), 2), 0);
self.halves = (() => { const $r = []; for (const $v36 of $.it($.tup($.gi(rows, even), $.gi(rows, $.inv(even))))) { let part; part = $v36; $r.push($.mm($.ga(part, "T"), part)); } return $r; })();
self.alone = $.dict((() => { const $r = []; for (const $v37 of $.it(groups)) { let name; name = $v37; $r.push([name, self._share(name)]); } return $r; })());
self.together = self._share(...$.it($.gi($.b.list(groups), $.slice(1, null, null)))); }, {p: ["parts"], ks: false}));
$.prop($c, "explained", $.def(function () { const self = this;
return $.b.max(0.0, $.ga(self, "together"), ...$.it($.cm($.ga(self, "alone"), "values", []))); }, {p: [], ks: false}));
$.prop($c, "delay", $.def(function () { const self = this;
return $.neg($.b.float($.gi(_solved($.b.sum($.ga(self, "halves")), $.cm(np, "append", [0, $.gi($.ga(self, "columns"), "delay")])), 1))); }, {p: [], ks: false}));
$.meth($c, "causes", $.def(function (rms) { const self = this;let found, offset, name, explained, others, share, own;
{const $v38 = $.unpack($.tup([], $.b.max(0.0, $.gi($.ga(self, "alone"), "offset"))), 2, -1);found = $v38[0];offset = $v38[1];}
for (const $v39 of $.it($.cm($.ga(self, "alone"), "items", []))) { {const $v40 = $.unpack($v39, 2, -1);name = $v40[0];explained = $v40[1];}
{others = (() => { const $r = []; for (const $v41 of $.it($.ga(self, "columns"))) { let other; other = $v41; if ($.t(!$.in(other, $.tup(name, "offset")))) { $r.push(other); } } return $r; })();
share = ($.t($.eq(name, "offset")) ? offset : $.b.max(0.0, $.sub(explained, offset)));
own = ($.t($.eq(name, "offset")) ? share : $.b.min(share, $.b.max(0.0, $.sub($.ga(self, "together"), self._share(...$.it(others))))));
$.cm(found, "append", [Cause(name, share, own, $.mul(rms, $.b.float(np.sqrt(share))))]);} }
return $.b.tuple(found); }, {p: ["rms"], ks: false}));
$.meth($c, "_share", $.def(function (...names) { const self = this;let use, at, left, total, fitted, scored, miss;
use = np.unique(np.concatenate([[0], ...$.it((function* () { for (const $v42 of $.it(names)) { let name; name = $v42; yield $.gi($.ga(self, "columns"), name); } })())]));
{const $v43 = $.unpack($.tup($.cm(np, "append", [use, (-1)]), 0.0, 0.0), 3, -1);at = $v43[0];left = $v43[1];total = $v43[2];}
for (const $v44 of $.it($.tup($.ga(self, "halves"), $.gi($.ga(self, "halves"), $.slice(null, null, (-1)))))) { {const $v45 = $.unpack($v44, 2, -1);fitted = $v45[0];scored = $v45[1];}
{miss = $.cm(np, "append", [_solved(fitted, use), (-1.0)]);
left = $.iadd(left, $.b.float($.mm($.mm(miss, $.gi(scored, np.ix_(at, at))), miss)));
total = $.iadd(total, $.b.float($.gi(scored, $.tup((-1), (-1)))));} }
return $.sub(1.0, $.div(left, total)); }, {p: [], va: true}));});
_solved = $.def(function (gram, use) { let length, a, weights;
length = np.sqrt($.gi(np.diag(gram), use));
$.si(length, $.eq(length, 0.0), 1.0);
a = $.div($.gi(gram, np.ix_(use, use)), np.outer(length, length));
$.isi(a, $.tup($.slice(1, null, null), $.slice(1, null, null)), $.iadd, $.mul(RIDGE, np.eye($.sub($.ga(use, "size"), 1))));
weights = $.div($.gi($.km($.ga(np, "linalg"), "lstsq", [a, $.div($.gi(gram, $.tup(use, (-1))), length)], {"rcond": null}), 0), length);
return $.km(np, "asarray", [weights], {"dtype": $.ga(np, "float64")}); }, {p: ["gram", "use"], ks: false});
_columns = $.def(function (seen) { let along, low, high, v, way;
along = $.gi(np.linspace((-1.0), 1.0, $.ga($.ga(seen, "e"), "size")), $.tup($.slice(null, null, null), null));
{const $v46 = $.unpack($.tup($.b.float($.ga(seen, "x").min()), $.b.float($.ga(seen, "x").max())), 2, -1);low = $v46[0];high = $v46[1];}
v = $.div($.ga(seen, "speed"), $.or($.b.float(np.quantile(np.abs($.ga(seen, "speed")), USUAL)), () => 1.0));
way = $.mul($.gi($.ga(seen, "sign"), $.tup($.slice(null, null, null), null)), _hats($.ga(seen, "way"), _knots($.ga(seen, "way"))));
return $.dict([["drift", $.pow(along, np.arange(1, 4))], ["position", _hats($.ga(seen, "x"), np.linspace(low, high, PLACES))], ["way-since-turn", np.hstack([way, $.mul(way, $.gi($.ga(seen, "height"), $.tup($.slice(null, null, null), null)))])], ["time-since-turn", np.hstack([$.mul($.gi($.ga(seen, "sign"), $.tup($.slice(null, null, null), null)), _hats($.ga(seen, "since"), _knots($.ga(seen, "since")))), $.ga(seen, "lags")])], ["rate", np.column_stack([v, $.mul(v, np.abs(v)), np.abs(v)])], ["delay", $.gi($.ga(seen, "slope"), $.tup($.slice(null, null, null), null))]]); }, {p: ["seen"], ks: false});
_knots = $.def(function (since) { 
return np.asarray(np.quantile(since, KNOTS)); }, {p: ["since"], ks: false});
_hats = $.def(function (values, knots) { 
knots = np.unique(knots);
return np.column_stack((() => { const $r = []; for (const $v47 of $.it(np.eye($.ga(knots, "size")))) { let unit; unit = $v47; $r.push(np.interp(values, knots, unit)); } return $r; })()); }, {p: ["values", "knots"], ks: false});
_noise = $.def(function (spans, rows) { let repeated, jumps;
repeated = (() => { const $r = []; for (const $v48 of $.it(spans)) { let span; span = $v48; $r.push(span.repeats()); } return $r; })();
if ($.t($.ge($.b.sum((function* () { for (const $v49 of $.it(repeated)) { let differences; differences = $v49; yield $.gi($.ga(differences, "shape"), 0); } })()), FEWEST_PAIRS))) {return $.tup($.b.float(np.sqrt($.mul(0.5, np.mean($.pow(np.concatenate(repeated), 2))))), "repeats");}
jumps = np.concatenate((() => { const $r = []; for (const $v50 of $.it($.k($.b.zip, [spans, rows], {"strict": true}))) { let span, at; {const $v51 = $.unpack($v50, 2, -1);span = $v51[0];at = $v51[1];} $r.push(span.jumps(at)); } return $r; })());
if ($.t($.lt($.ga(jumps, "size"), FEWEST))) {return $.tup(null, "");}
return $.tup($.b.float(np.sqrt($.div(np.mean($.pow(jumps, 2)), np.sum($.pow(DIFFERENCE, 2))))), "differences"); }, {p: ["spans", "rows"], ks: false});
_suggestions = $.def(function* (found, knows_time) { let order, said, cause, what, rivals, noise;
order = $.k($.b.sorted, [$.ga(found, "causes")], {"key": $.def((cause) => {  return $.neg($.b.round($.ga(cause, "share"), 2)); }, {p: ["cause"], ks: false})});
said = (() => { const $r = []; for (const $v52 of $.it(order)) { let cause; cause = $v52; if (($.t($.ge($.ga(cause, "share"), WORTH)) && ($.t((cause === $.gi(order, 0))) || $.t($.ge($.ga(cause, "own"), OWN))))) { $r.push(cause); } } return $r; })();
for (const $v53 of $.it(said)) { cause = $v53;
{what = ("" + $.f($.mul(100.0, $.ga(cause, "share")), ("" + ".0f"), -1) + " % of the squared residual " + $.f($.ga(cause, "words"), "", -1));
(yield ("" + $.f(what, "", -1) + ", " + $.f($.ga(cause, "size_percent"), ("" + ".2g"), -1) + " % of range rms. " + $.f(_cure(cause, found, knows_time), "", -1)));} }
rivals = (() => { const $r = []; for (const $v54 of $.it($.gi(order, $.slice(1, null, null)))) { let cause; cause = $v54; if (($.t(said) && $.t($.lt($.ga(cause, "own"), OWN)) && $.t($.ge($.ga(cause, "share"), $.mul(RIVAL, $.ga($.gi(order, 0), "share")))))) { $r.push(cause); } } return $r; })();
if ($.t(rivals)) {(yield ("" + "Nearly as much of the same follows " + $.f($.cm(" and ", "join", [(function* () { for (const $v55 of $.it(rivals)) { let cause; cause = $v55; yield $.gi(TITLES, $.ga(cause, "name")); } })()]), "", -1) + ": log several speeds, sizes of loop, and rests, which tell them apart (dehyst design plans such a motion)."));}
noise = $.ga(found, "noise_share");
if (($.t((noise != null)) && $.t($.ge(noise, MOSTLY)))) {(yield ("" + $.f($.mul(100.0, noise), ("" + ".0f"), -1) + " % of the squared residual is noise, " + $.f($.ga(found, "noise_percent"), ("" + ".2g"), -1) + " % of range rms: no model will do much better. Average samples, take a better sensor, or leave it at that."));} else {if ((!$.t(said) && $.t($.ga(found, "causes")))) {(yield "The residual follows none of these, and is more than the noise that is seen: something was not logged. Log what else acts on the actuator (load, temperature, supply), and repeat the same strokes: what differs between repetitions no model can know.");}} }, {p: ["found", "knows_time"], ks: false});
_cure = $.def(function (cause, found, knows_time) { let where, other, cures;
where = ($.t($.eq($.ga(found, "part"), "held-out")) ? "the samples held out" : "the samples");
other = "see whether another family does better (dehyst compare)";
cures = $.dict([["offset", ("" + "The zero of " + $.f(where, "", -1) + " is not that of the model: check the zero of the sensor, warm up before logging, or let an offset follow the last cycle in use, up to twice this one (dehyst export --follow-offset " + $.f($.div($.b.min(50, $.b.max(1, math.ceil($.mul(2, $.ga(cause, "size_percent"))))), 100), ("" + "g"), -1) + ").")], ["drift", "Warm up before logging, log longer, and log what may cause it, such as a temperature."], ["position", ("" + "Let loops over the whole range be part of what is fitted (--train-fraction), or " + $.f(other, "", -1) + ".")], ["way-since-turn", ("" + "Let loops of all sizes be part of what is fitted (--train-fraction), or " + $.f(other, "", -1) + ".")], ["time-since-turn", "The model knows creep, but not all of it: log longer rests and several speeds."], ["rate", "The model knows the rate, from other speeds: let those of use be part of what is fitted."], ["delay", _late(found)]]);
if (($.t($.in($.ga(cause, "name"), $.tup("time-since-turn", "rate"))) && !$.t($.ga(found, "timed")))) {return "Log time stamps: models of creep and rate need them.";}
if (($.t($.eq($.ga(cause, "name"), "time-since-turn")) && !$.t(knows_time))) {return "Take a model that knows creep (--family mixed-sum or creep-pi), and log rests, which tell it from rate.";}
if (($.t($.eq($.ga(cause, "name"), "rate")) && !$.t(knows_time))) {return "Take a model that knows the rate (--family mixed-sum), or identify at the speed of use.";}
return $.gi(cures, $.ga(cause, "name")); }, {p: ["cause", "found", "knows_time"], ks: false});
_late = $.def(function (found) { let unit;
unit = ($.t($.ga(found, "timed")) ? "s" : "samples");
return ("" + "The output is about " + $.f($.b.abs($.ga(found, "delay")), ("" + ".2g"), -1) + " " + $.f(unit, "", -1) + " " + $.f(($.t($.gt($.ga(found, "delay"), 0.0)) ? "behind" : "ahead of"), "", -1) + " the model: log both signals by one clock and without filters on one of them, or shift one by that time."); }, {p: ["found"], ks: false});
Object.assign($m, {"annotations": annotations, "math": math, "Iterator": Iterator, "Sequence": Sequence, "dataclass": dataclass, "replace": replace, "Any": Any, "NamedTuple": NamedTuple, "np": np, "_native": _native, "Array": Array_, "Mask": Mask, "Rows": Rows, "TURN_FRACTION": TURN_FRACTION, "turning_points": turning_points, "Recording": Recording, "spread": spread, "single_blas": single_blas, "TITLES": TITLES, "CAUSES": CAUSES, "MOST_ROWS": MOST_ROWS, "FEWEST": FEWEST, "BLOCKS": BLOCKS, "PLACES": PLACES, "KNOTS": KNOTS, "LAGS": LAGS, "MOST_LAGGING": MOST_LAGGING, "USUAL": USUAL, "RIDGE": RIDGE, "NOTHING": NOTHING, "WORTH": WORTH, "OWN": OWN, "RIVAL": RIVAL, "MOSTLY": MOSTLY, "SAME_PLACE": SAME_PLACE, "SAME_TIME": SAME_TIME, "FEWEST_PAIRS": FEWEST_PAIRS, "MOST_PAIRS": MOST_PAIRS, "PHASES": PHASES, "DIFFERENCE": DIFFERENCE, "Cause": Cause, "Residual": Residual, "residual_structure": residual_structure, "_Features": _Features, "_Span": _Span, "_spans": _spans, "_Table": _Table, "_solved": _solved, "_columns": _columns, "_knots": _knots, "_hats": _hats, "_noise": _noise, "_suggestions": _suggestions, "_cure": _cure, "_late": _late});
});
$.module("dehyst.identification.scores", ($m) => {
let annotations, Iterator, Sequence, dataclass, Protocol, np, Array_, Mask, robust_range, Recording, facts, DataSet, Piece, chunks, range_over, Evidence, evidence, rows_of, stretches_of, InputError, Score, Bank, started, HysteresisModel, StaticCurve, Readable, Part, Moments, parts, part_of, predictions, simulated, _started, _joined, score, score_of, round_trip, input_error, input_error_of, Measured, Answers, Measure, InMemory, _evidence, _levels_apart, _beyond_training;
Iterator = $.from("collections.abc", "Iterator");Sequence = $.from("collections.abc", "Sequence");
dataclass = $.from("dataclasses", "dataclass");
Protocol = $.from("typing", "Protocol");
np = $.imp("numpy");
Array_ = $.from("dehyst.arrays", "Array");Mask = $.from("dehyst.arrays", "Mask");
robust_range = $.from("dehyst.data.ranges", "robust_range");
Recording = $.from("dehyst.data.recording", "Recording");
facts = $.from("dehyst.identification", "facts");
DataSet = $.from("dehyst.identification.data", "DataSet");Piece = $.from("dehyst.identification.data", "Piece");chunks = $.from("dehyst.identification.data", "chunks");range_over = $.from("dehyst.identification.data", "range_over");
Evidence = $.from("dehyst.identification.evidence", "Evidence");evidence = $.from("dehyst.identification.evidence", "evidence");rows_of = $.from("dehyst.identification.evidence", "rows_of");stretches_of = $.from("dehyst.identification.evidence", "stretches_of");
InputError = $.from("dehyst.identification.fit", "InputError");Score = $.from("dehyst.identification.fit", "Score");
Bank = $.from("dehyst.identification.regressors", "Bank");started = $.from("dehyst.identification.regressors", "started");
HysteresisModel = $.from("dehyst.models.base", "HysteresisModel");StaticCurve = $.from("dehyst.models.monotone", "StaticCurve");
Readable = $.cls("Readable", [], "", [], false, true, ($c) => { Readable = $c; $.meth($c, "__getitem__", $.def(function (part) { const self = this;
 }, {p: ["part"], ks: false}));});
Part = $.cls("Part", [], "", [["spans", null], ["weights", null]], true, true, ($c) => { Part = $c; $.meth($c, "__bool__", $.def(function () { const self = this;
return $.b.any((function* () { for (const $v1 of $.it(self.blocks())) { let _; _ = $v1; yield true; } })()); }, {p: [], ks: false}));
$.meth($c, "blocks", $.def(function* (...numbers) { const self = this;let index, spans, weight, span, part, chosen;
for (const $v2 of $.it($.b.enumerate($.k($.b.zip, [$.ga(self, "spans"), $.ga(self, "weights")], {"strict": true})))) { {const $v3 = $.unpack($v2, 2, -1);index = $v3[0];{const $v4 = $.unpack($v3[1], 2, -1);spans = $v4[0];weight = $v4[1];}}
{if (($.t(numbers) && $.t(!$.in(index, numbers)))) {continue;}
for (const $v5 of $.it(spans)) { span = $v5;
{for (const $v6 of $.it(chunks(span))) { part = $v6;
{chosen = ($.t((weight == null)) ? null : $.gi(weight, part));
if (($.t((chosen == null)) || $.t(np.any($.gt(chosen, 0.0))))) {(yield $.tup(index, part, chosen));}} }} }} } }, {p: [], va: true}));
$.meth($c, "mask", $.def(function (index, size) { const self = this;let mask, weight, span;
{const $v7 = $.unpack($.tup($.km(np, "zeros", [size], {"dtype": $.ga(np, "bool_")}), $.gi($.ga(self, "weights"), index)), 2, -1);mask = $v7[0];weight = $v7[1];}
for (const $v8 of $.it($.gi($.ga(self, "spans"), index))) { span = $v8;
{$.si(mask, span, ($.t((weight == null)) ? true : $.gt($.gi(weight, span), 0.0)));} }
return mask; }, {p: ["index", "size"], ks: false}));
$.meth($c, "moments", $.def(function (signals, less = null, ...numbers) { const self = this;const $kw = $.popkw(numbers);let extremes = $kw.take("extremes", () => false);let count, first, second, largest, index, part, weight, values, scaled, sized;
{ const $v9 = 0.0; count = $v9; first = $v9; second = $v9; largest = $v9;}
for (const $v10 of $.it(self.blocks(...$.it(numbers)))) { {const $v11 = $.unpack($v10, 3, -1);index = $v11[0];part = $v11[1];weight = $v11[2];}
{values = ($.t((less == null)) ? $.gi($.gi(signals, index), part) : $.sub($.gi($.gi(signals, index), part), $.gi($.gi(less, index), part)));
scaled = ($.t((weight == null)) ? values : $.mul(values, weight));
count = $.iadd(count, ($.t((weight == null)) ? $.ga(values, "size") : $.b.float(np.sum(weight))));
first = $.iadd(first, $.b.float(np.sum(scaled)));
second = $.iadd(second, $.b.float($.mm(scaled, values)));
if ($.t(extremes)) {sized = ($.t((weight == null)) ? values : $.gi(values, $.gt(weight, 0.0)));
largest = $.b.max(largest, $.b.float(sized.max()), $.neg($.b.float(sized.min())));}} }
return Moments(count, ($.t(count) ? $.div(first, count) : 0.0), ($.t(count) ? $.div(second, count) : 0.0), largest); }, {p: ["signals", "less"], va: true}));});
Moments = $.cls("Moments", [], "", [["count", null], ["mean", null], ["square", null], ["largest", null]], true, true, ($c) => { Moments = $c; $.prop($c, "rms", $.def(function () { const self = this;
return $.b.float(np.sqrt($.ga(self, "square"))); }, {p: [], ks: false}));});
parts = $.def(function (records, data, initial_state) { let fitted, held_out, weights, piece, spans, span, given, first, second;
fitted = (() => { const $r = []; for (const $v12 of $.it(records)) { let _; _ = $v12; $r.push([]); } return $r; })();
held_out = (() => { const $r = []; for (const $v13 of $.it(records)) { let _; _ = $v13; $r.push([]); } return $r; })();
weights = (() => { const $r = []; for (const $v14 of $.it(records)) { let record; record = $v14; $r.push((!$.t($.ga(data, "weighted")) ? null : np.ones($.b.len(record)))); } return $r; })();
for (const $v15 of $.it($.ga(data, "pieces"))) { piece = $v15;
{for (const $v16 of $.it($.tup($.tup(fitted, piece.fitted(initial_state)), $.tup(held_out, piece.held_out(initial_state))))) { {const $v17 = $.unpack($v16, 2, -1);spans = $v17[0];span = $v17[1];}
{if ($.t($.gt($.ga(span, "stop"), $.ga(span, "start")))) {$.cm($.gi(spans, $.ga(piece, "recording")), "append", [$.b.slice($.add($.ga(piece, "start"), $.ga(span, "start")), $.add($.ga(piece, "start"), $.ga(span, "stop")))]);}} }
given = $.gi(weights, $.ga(piece, "recording"));
if (($.t((given != null)) && $.t(($.ga(piece, "weight") != null)))) {$.si(given, $.slice($.ga(piece, "start"), $.add($.ga(piece, "start"), $.ga($.ga(piece, "x"), "size")), null), $.ga(piece, "weight"));}} }
{const $v19 = $.unpack((function* () { for (const $v18 of $.it($.tup(fitted, held_out))) { let spans; spans = $v18; yield Part($.b.tuple($.b.map($.b.tuple, spans)), $.b.tuple(weights)); } })(), 2, -1);first = $v19[0];second = $v19[1];}
return $.tup(first, second); }, {p: ["records", "data", "initial_state"], ks: false});
part_of = $.def(function (masks) { let spans, mask, ends;
spans = [];
for (const $v20 of $.it(masks)) { mask = $v20;
{ends = np.flatnonzero(np.diff(np.concatenate([[false], mask, [false]]).astype($.ga(np, "int8")))).reshape((-1), 2);
$.cm(spans, "append", [$.b.tuple((function* () { for (const $v21 of $.it(ends)) { let low, high; {const $v22 = $.unpack($v21, 2, -1);low = $v22[0];high = $v22[1];} yield $.b.slice($.b.int(low), $.b.int(high)); } })())]);} }
return Part($.b.tuple(spans), $.mul($.tup(null), $.b.len(spans))); }, {p: ["masks"], ks: false});
predictions = $.def(function (records, data, bank, model) { let demands, piece, begun, span;
demands = (() => { const $r = []; for (const $v23 of $.it(records)) { let _; _ = $v23; $r.push([]); } return $r; })();
for (const $v24 of $.it(_started(data, bank, model))) { {const $v25 = $.unpack($v24, 2, -1);piece = $v25[0];begun = $v25[1];}
{span = $.b.slice($.ga(piece, "start"), $.add($.ga(piece, "start"), $.ga($.ga(piece, "x"), "size")));
$.cm($.gi(demands, $.ga(piece, "recording")), "append", [begun.inverse().simulate($.gi($.ga($.gi(records, $.ga(piece, "recording")), "output"), span))]);} }
return $.tup(simulated(records, data, bank, model), $.b.tuple($.b.map(_joined, demands))); }, {p: ["records", "data", "bank", "model"], ks: false});
simulated = $.def(function (records, data, bank, model) { let outputs, piece, begun, span;
outputs = (() => { const $r = []; for (const $v26 of $.it(records)) { let _; _ = $v26; $r.push([]); } return $r; })();
for (const $v27 of $.it(_started(data, bank, model))) { {const $v28 = $.unpack($v27, 2, -1);piece = $v28[0];begun = $v28[1];}
{span = $.b.slice($.ga(piece, "start"), $.add($.ga(piece, "start"), $.ga($.ga(piece, "x"), "size")));
$.cm($.gi(outputs, $.ga(piece, "recording")), "append", [begun.simulate($.gi($.ga($.gi(records, $.ga(piece, "recording")), "input"), span))]);} }
return $.b.tuple($.b.map(_joined, outputs)); }, {p: ["records", "data", "bank", "model"], ks: false});
_started = $.def(function* (data, bank, model) { let piece, state;
for (const $v29 of $.it($.k($.b.zip, [$.ga(data, "pieces"), $.ga(bank, "states")], {"strict": true}))) { {const $v30 = $.unpack($v29, 2, -1);piece = $v30[0];state = $v30[1];}
{(yield $.tup(piece, started(data, bank, model, state)));} } }, {p: ["data", "bank", "model"], ks: false});
_joined = $.def(function (pieces) { 
return ($.t($.eq($.b.len(pieces), 1)) ? $.gi(pieces, 0) : np.concatenate(pieces)); }, {p: ["pieces"], ks: false});
score = $.def(function (records, outputs, part, output_range) { let measured, about, error, middle;
measured = (() => { const $r = []; for (const $v31 of $.it(records)) { let record; record = $v31; $r.push($.ga(record, "output")); } return $r; })();
about = part.moments(measured);
if ($.t($.eq($.ga(about, "count"), 0.0))) {return null;}
error = $.km(part, "moments", [outputs, measured], {"extremes": true});
middle = (() => { const $r = []; for (const $v32 of $.it(records)) { let record; record = $v32; $r.push(np.broadcast_to($.ga(about, "mean"), $.ga($.ga(record, "output"), "shape"))); } return $r; })();
return score_of(error, $.ga(part.moments(measured, middle), "rms"), output_range); }, {p: ["records", "outputs", "part", "output_range"], ks: false});
score_of = $.def(function (error, deviation, output_range) { 
return $.k(Score, [], {"rmse": $.ga(error, "rms"), "rmse_percent": $.div($.mul(100.0, $.ga(error, "rms")), output_range), "nrmse": ($.t($.gt(deviation, 0)) ? $.div($.ga(error, "rms"), deviation) : ($.t($.gt($.ga(error, "rms"), 0)) ? $.b.float("inf") : 0.0)), "max": $.ga(error, "largest")}); }, {p: ["error", "deviation", "output_range"], ks: false});
round_trip = $.def(function (model, x) { let forward, inverse, again, misses, ranges, part, y, back, k, found, wanted;
{const $v34 = $.unpack((function* () { for (const $v33 of $.it($.tup(model, model.inverse(), model))) { let m; m = $v33; yield m.stepper("dense"); } })(), 3, -1);forward = $v34[0];inverse = $v34[1];again = $v34[2];}
{const $v35 = $.unpack($.tup(np.zeros(2), np.array([[$.ga(np, "inf"), $.neg($.ga(np, "inf"))], [$.ga(np, "inf"), $.neg($.ga(np, "inf"))]])), 2, -1);misses = $v35[0];ranges = $v35[1];}
for (const $v36 of $.it(chunks($.b.slice(0, $.ga(x, "size"))))) { part = $v36;
{y = $.gi(forward.simulate($.gi(x, part)), 0);
back = $.gi(inverse.simulate(y), 0);
for (const $v37 of $.it($.b.enumerate($.tup($.tup(back, $.gi(x, part)), $.tup($.gi(again.simulate(back), 0), y))))) { {const $v38 = $.unpack($v37, 2, -1);k = $v38[0];{const $v39 = $.unpack($v38[1], 2, -1);found = $v39[0];wanted = $v39[1];}}
{$.si(misses, k, $.b.max($.gi(misses, k), $.b.float(np.max(np.abs($.sub(found, wanted))))));
$.si(ranges, k, $.tup($.b.min($.gi(ranges, $.tup(k, 0)), $.b.float(wanted.min())), $.b.max($.gi(ranges, $.tup(k, 1)), $.b.float(wanted.max()))));} }} }
return $.b.float(np.max($.div(misses, np.maximum($.sub($.gi(ranges, $.tup($.slice(null, null, null), 1)), $.gi(ranges, $.tup($.slice(null, null, null), 0))), 1e-300)))); }, {p: ["model", "x"], ks: false});
input_error = $.def(function (records, demands, part) { let inputs, low, high, held;
inputs = (() => { const $r = []; for (const $v40 of $.it(records)) { let record; record = $v40; $r.push($.ga(record, "input")); } return $r; })();
{const $v41 = $.unpack(range_over(inputs), 2, -1);low = $v41[0];high = $v41[1];}
held = (() => { const $r = []; for (const $v42 of $.it(demands)) { let demand; demand = $v42; $r.push(np.clip(demand, low, high)); } return $r; })();
return input_error_of(part.moments(held, inputs), robust_range(inputs)); }, {p: ["records", "demands", "part"], ks: false});
input_error_of = $.def(function (moments, span) { 
if (!$.t($.ga(moments, "count"))) {return null;}
return InputError($.div($.mul(100.0, $.ga(moments, "rms")), span), $.div($.mul(100.0, $.ga(moments, "mean")), span)); }, {p: ["moments", "span"], ks: false});
Measured = $.cls("Measured", [], "", [["recordings", null], ["predictions", null], ["inverse_predictions", null], ["train_masks", null], ["test_masks", null], ["train", null], ["test", null], ["static_train", null], ["static_test", null], ["round_trip", null], ["input_train", null], ["input_test", null], ["curve_input", null], ["beyond", null], ["levels_apart", null], ["evidence", null], ["drift", null]], true, true, ($c) => { Measured = $c; $.prop($c, "input_error", $.def(function () { const self = this;
return $.or($.ga(self, "input_test"), () => $.ga(self, "input_train")); }, {p: [], ks: false}));});
Answers = $.cls("Answers", [], "", [["curve", null], ["input", null]], true, true, ($c) => { Answers = $c; $.meth($c, "__getitem__", $.def(function (part) { const self = this;
return $.ga(self, "curve").simulate($.gi($.ga(self, "input"), part)); }, {p: ["part"], ks: false}));
$.prop($c, "whole", $.def(function () { const self = this;
return $.ga(self, "curve").simulate($.ga(self, "input")); }, {p: [], ks: false}));});
Measure = $.cls("Measure", [], "", [], false, true, ($c) => { Measure = $c; $.meth($c, "__call__", $.def(function (data, bank, model, static_, turns) { const self = this;
 }, {p: ["data", "bank", "model", "static", "turns"], ks: false}));});
InMemory = $.cls("InMemory", [], "", [], false, true, ($c) => { InMemory = $c; $.meth($c, "__init__", $.def(function (records, loads = $.tup()) { const self = this;
{const $v43 = $.unpack($.tup(records, loads), 2, -1);self._records = $v43[0];self._loads = $v43[1];}
self._tested = null; }, {p: ["records", "loads"], ks: false}));
$.meth($c, "__call__", $.def(function (data, bank, model, static_, turns) { const self = this;let outputs, demands, trip, scored;
{const $v44 = $.unpack(predictions($.ga(self, "_records"), data, bank, model), 2, -1);outputs = $v44[0];demands = $v44[1];}
trip = round_trip(model, $.ga($.gi($.ga(self, "_records"), 0), "input"));
scored = parts($.ga(self, "_records"), data, $.ga(bank, "initial_state"));
return self.compared(data, scored, outputs, demands, trip, static_, turns); }, {p: ["data", "bank", "model", "static", "turns"], ks: false}));
$.meth($c, "compared", $.def(function (data, scored, outputs, demands, trip, static_, turns) { const self = this;let records, fitted, held_out, curves, train, test, static_train, static_test, input_train, input_test, asked, curve_input, better, change, seen, signals;
{const $v45 = $.unpack($.tup($.ga(self, "_records"), scored), 2, -1);records = $v45[0];{const $v46 = $.unpack($v45[1], 2, -1);fitted = $v46[0];held_out = $v46[1];}}
curves = $.b.tuple((function* () { for (const $v47 of $.it(records)) { let record; record = $v47; yield Answers(static_, $.ga(record, "input")); } })());
{const $v49 = $.unpack((function* () { for (const $v48 of $.it($.tup(fitted, held_out))) { let part; part = $v48; yield score(records, outputs, part, $.ga(data, "output_range")); } })(), 2, -1);train = $v49[0];test = $v49[1];}
{const $v51 = $.unpack((function* () { for (const $v50 of $.it($.tup(fitted, held_out))) { let part; part = $v50; yield score(records, curves, part, $.ga(data, "output_range")); } })(), 2, -1);static_train = $v51[0];static_test = $v51[1];}
{const $v53 = $.unpack((function* () { for (const $v52 of $.it($.tup(fitted, held_out))) { let part; part = $v52; yield input_error(records, demands, part); } })(), 2, -1);input_train = $v53[0];input_test = $v53[1];}
asked = $.b.tuple((function* () { for (const $v54 of $.it(records)) { let record; record = $v54; yield static_.inverse().simulate($.ga(record, "output")); } })());
curve_input = input_error(records, asked, ($.t((test == null)) ? fitted : held_out));
if (($.t((train == null)) || $.t((static_train == null)) || $.t((input_train == null)) || $.t((curve_input == null)))) {throw $.exc($.b.AssertionError("no training samples"));}
better = ($.t($.le($.ga(train, "rmse"), $.ga(static_train, "rmse"))) ? outputs : $.b.tuple((function* () { for (const $v55 of $.it(curves)) { let curve; curve = $v55; yield $.ga(curve, "whole"); } })()));
change = $.tup(0.0, 0.0);
seen = $.bor(fitted.mask(0, $.b.len($.gi(records, 0))), held_out.mask(0, $.b.len($.gi(records, 0))));
if ($.t($.gt(np.count_nonzero(seen), 8))) {signals = $.tup($.ga($.gi(records, 0), "input"), $.gi(better, 0), $.ga($.gi(records, 0), "output"));
change = facts.drift(...$.it(($.t(seen.all()) ? signals : (function* () { for (const $v56 of $.it(signals)) { let signal; signal = $v56; yield $.gi(signal, seen); } })())));}
if ($.t(($.ga(self, "_tested") == null))) {self._tested = _evidence(records, data, turns, $.ga(self, "_loads"));}
return $.k(Measured, [], {"recordings": records, "predictions": outputs, "inverse_predictions": demands, "train_masks": $.b.tuple((function* () { for (const $v57 of $.it($.b.enumerate(records))) { let index, record; {const $v58 = $.unpack($v57, 2, -1);index = $v58[0];record = $v58[1];} yield fitted.mask(index, $.b.len(record)); } })()), "test_masks": $.b.tuple((function* () { for (const $v59 of $.it($.b.enumerate(records))) { let index, record; {const $v60 = $.unpack($v59, 2, -1);index = $v60[0];record = $v60[1];} yield held_out.mask(index, $.b.len(record)); } })()), "train": train, "test": test, "static_train": static_train, "static_test": static_test, "round_trip": trip, "input_train": input_train, "input_test": input_test, "curve_input": curve_input, "beyond": _beyond_training(records, held_out, data), "levels_apart": _levels_apart(records, outputs, fitted, held_out), "evidence": $.ga(self, "_tested"), "drift": change}); }, {p: ["data", "scored", "outputs", "demands", "trip", "static", "turns"], ks: false}));});
_evidence = $.def(function (records, data, turns, loads) { let timed, found, k, record, time, rows, signals;
timed = (() => { const $r = []; for (const $v61 of $.it($.b.enumerate(records))) { let k, record; {const $v62 = $.unpack($v61, 2, -1);k = $v62[0];record = $v62[1];} if ($.t(($.ga(record, "time") != null))) { $r.push($.tup(k, record, $.ga(record, "time"))); } } return $r; })();
found = [];
for (const $v63 of $.it($.k($.b.zip, [timed, rows_of((() => { const $r = []; for (const $v64 of $.it(timed)) { let _, record; {const $v65 = $.unpack($v64, 3, -1);_ = $v65[0];record = $v65[1];_ = $v65[2];} $r.push($.b.len(record)); } return $r; })(), turns)], {"strict": true}))) { {const $v66 = $.unpack($v63, 2, -1);{const $v67 = $.unpack($v66[0], 3, -1);k = $v67[0];record = $v67[1];time = $v67[2];}rows = $v66[1];}
{signals = [time, $.ga(record, "input"), $.ga(record, "output"), ...$.it(($.t(loads) ? $.gi(loads, k) : $.tup()))];
found = $.iadd(found, stretches_of(data, k, rows, np.array((() => { const $r = []; for (const $v68 of $.it(signals)) { let signal; signal = $v68; $r.push($.gi(signal, rows)); } return $r; })())));} }
return evidence(found); }, {p: ["records", "data", "turns", "loads"], ks: false});
_levels_apart = $.def(function (records, outputs, fitted, held_out) { let measured, parts_of, levels;
if ($.t($.lt($.b.len(records), 2))) {return 0.0;}
measured = (() => { const $r = []; for (const $v69 of $.it(records)) { let record; record = $v69; $r.push($.ga(record, "output")); } return $r; })();
parts_of = (() => { const $r = []; for (const $v71 of $.it($.b.range($.b.len(records)))) { let k; k = $v71; $r.push((() => { const $r = []; for (const $v70 of $.it($.tup(fitted, held_out))) { let part; part = $v70; $r.push(part.moments(measured, outputs, k)); } return $r; })()); } return $r; })();
levels = (() => { const $r = []; for (const $v74 of $.it(parts_of)) { let found; found = $v74; if ($.t($.b.any((function* () { for (const $v73 of $.it(found)) { let a; a = $v73; yield $.ga(a, "count"); } })()))) { $r.push($.b.next((function* () { for (const $v72 of $.it(found)) { let about; about = $v72; if ($.t($.ga(about, "count"))) { yield $.ga(about, "mean"); } } })())); } } return $r; })();
return $.sub($.b.max(levels), $.b.min(levels)); }, {p: ["records", "outputs", "fitted", "held_out"], ks: false});
_beyond_training = $.def(function (records, part, data) { let inputs, middle, farthest;
if (!$.t(part)) {return 0.0;}
inputs = (() => { const $r = []; for (const $v75 of $.it(records)) { let record; record = $v75; $r.push($.ga(record, "input")); } return $r; })();
middle = (() => { const $r = []; for (const $v76 of $.it(inputs)) { let x; x = $v76; $r.push(np.broadcast_to($.ga(data, "center"), $.ga(x, "shape"))); } return $r; })();
farthest = $.ga($.km(part, "moments", [inputs, middle], {"extremes": true}), "largest");
return $.mul(0.5, $.b.max(0.0, $.sub($.div(farthest, $.ga(data, "half_range")), 1.0))); }, {p: ["records", "part", "data"], ks: false});
Object.assign($m, {"annotations": annotations, "Iterator": Iterator, "Sequence": Sequence, "dataclass": dataclass, "Protocol": Protocol, "np": np, "Array": Array_, "Mask": Mask, "robust_range": robust_range, "Recording": Recording, "facts": facts, "DataSet": DataSet, "Piece": Piece, "chunks": chunks, "range_over": range_over, "Evidence": Evidence, "evidence": evidence, "rows_of": rows_of, "stretches_of": stretches_of, "InputError": InputError, "Score": Score, "Bank": Bank, "started": started, "HysteresisModel": HysteresisModel, "StaticCurve": StaticCurve, "Readable": Readable, "Part": Part, "Moments": Moments, "parts": parts, "part_of": part_of, "predictions": predictions, "simulated": simulated, "_started": _started, "_joined": _joined, "score": score, "score_of": score_of, "round_trip": round_trip, "input_error": input_error, "input_error_of": input_error_of, "Measured": Measured, "Answers": Answers, "Measure": Measure, "InMemory": InMemory, "_evidence": _evidence, "_levels_apart": _levels_apart, "_beyond_training": _beyond_training});
});
$.module("dehyst.identification.selection", ($m) => {
let annotations, Callable, Iterable, Iterator, Sequence, dataclass, replace, partial, NamedTuple, Protocol, np, npt, Array_, rank, DataSet, extremes, FAMILIES, MAP_PIECES, STATIC, Estimate, Regularisation, fit_family, gain_of, is_high, mapped, Candidate, largest_radius, Bank, NormalEquations, make_bank, ramp_columns, ShortSignal, shorten, fit_static, held_out_errors, in_parallel, Marks, BLOCKS, FOLD_RIDGE, output_knots, blocks_of, Setting, Folds, COMPARED_ROWS, COMPARED_OPERATORS, STARTING_OPERATORS, FEWEST_ROWS, FLOOR, WITHIN_NOISE, CLEARLY_BETTER, NO_DIFFERENCE, STATIC_AS_GOOD, REGULARISATIONS, STOP_POWER, OPERATORS, POWERS, LOOSE, AFFORDABLE, EXACT, ROOM, FIRMER, STARTS, BY_ORIENTATION, Choice, threshold_grid, grid_power, possible_choices, compare, _memories, _by_bank, start_of_paper, choose_operators, Firmness, firmness, _firmness, _raised, choose, _score, _candidate;
Callable = $.from("collections.abc", "Callable");Iterable = $.from("collections.abc", "Iterable");Iterator = $.from("collections.abc", "Iterator");Sequence = $.from("collections.abc", "Sequence");
dataclass = $.from("dataclasses", "dataclass");replace = $.from("dataclasses", "replace");
partial = $.from("functools", "partial");
NamedTuple = $.from("typing", "NamedTuple");Protocol = $.from("typing", "Protocol");
np = $.imp("numpy");
npt = $.imp("numpy.typing");
Array_ = $.from("dehyst.arrays", "Array");rank = $.from("dehyst.arrays", "rank");
DataSet = $.from("dehyst.identification.data", "DataSet");extremes = $.from("dehyst.identification.data", "extremes");
FAMILIES = $.from("dehyst.identification.families", "FAMILIES");MAP_PIECES = $.from("dehyst.identification.families", "MAP_PIECES");STATIC = $.from("dehyst.identification.families", "STATIC");Estimate = $.from("dehyst.identification.families", "Estimate");Regularisation = $.from("dehyst.identification.families", "Regularisation");fit_family = $.from("dehyst.identification.families", "fit_family");gain_of = $.from("dehyst.identification.families", "gain_of");is_high = $.from("dehyst.identification.families", "is_high");mapped = $.from("dehyst.identification.families", "mapped");
Candidate = $.from("dehyst.identification.fit", "Candidate");
largest_radius = $.from("dehyst.identification.memory", "largest_radius");
Bank = $.from("dehyst.identification.regressors", "Bank");NormalEquations = $.from("dehyst.identification.regressors", "NormalEquations");make_bank = $.from("dehyst.identification.regressors", "make_bank");ramp_columns = $.from("dehyst.identification.regressors", "ramp_columns");
ShortSignal = $.from("dehyst.identification.short_signal", "ShortSignal");shorten = $.from("dehyst.identification.short_signal", "shorten");
fit_static = $.from("dehyst.identification.static_curve", "fit_static");held_out_errors = $.from("dehyst.identification.static_curve", "held_out_errors");
in_parallel = $.from("dehyst.identification.threads", "in_parallel");
Marks = $.gi($.ga(npt, "NDArray"), $.ga(np, "bool_"));
BLOCKS = 5;
FOLD_RIDGE = 0.0001;
output_knots = $.def(function () { 
return np.linspace((-1.0), 1.0, $.add(MAP_PIECES, 1)); }, {p: [], ks: false});
blocks_of = $.def(function (rows, blocks = BLOCKS) { let parts;
parts = np.array_split(np.arange(rows), blocks);
return (() => { const $r = []; for (const $v1 of $.it(parts)) { let part; part = $v1; $r.push($.b.slice($.b.int($.gi(part, 0)), $.add($.b.int($.gi(part, (-1))), 1))); } return $r; })(); }, {p: ["rows", "blocks"], ks: false});
Setting = $.cls("Setting", [], "", [], false, true, ($c) => { Setting = $c; $.prop($c, "family", $.def(function () { const self = this;
 }, {p: [], ks: false}));
$.prop($c, "regularisation", $.def(function () { const self = this;
 }, {p: [], ks: false}));});
Folds = $.cls("Folds", [], "", [], false, true, ($c) => { Folds = $c; $.meth($c, "__init__", $.def(function (short, bank, blocks = BLOCKS, ramps = true) { const self = this;
{const $v2 = $.unpack($.tup(short, bank), 2, -1);self._short = $v2[0];self._bank = $v2[1];}
{const $v3 = $.unpack($.tup($.ga(short, "y"), $.ga(short, "weight")), 2, -1);self._y = $v3[0];self._weight = $v3[1];}
self._blocks = blocks_of($.ga(short, "rows"), blocks);
self.knots = output_knots();
self._samples = $.b.float(($.t(($.ga(self, "_weight") == null)) ? $.ga($.ga(self, "_y"), "size") : np.sum($.ga(self, "_weight"))));
self._targets = $.gi($.ga(self, "_y"), $.tup(null, $.slice(null, null, null)));
if ($.t(ramps)) {self._targets = np.vstack([ramp_columns($.ga(self, "_y"), $.ga(self, "knots")), $.ga(self, "_y")]);}
self._sums = short.sums($.ga(bank, "thresholds"), $.ga(bank, "states"), $.ga(self, "_targets"), $.ga(self, "_blocks"));
self._warm = $.dict([]); }, {p: ["short", "bank", "blocks", "ramps"], ks: false}));
$.meth($c, "errors", $.def(function (choice, eps) { const self = this;
return np.array((() => { const $r = []; for (const $v4 of $.it(self.estimates(choice, eps))) { let _, error; {const $v5 = $.unpack($v4, 3, -1);_ = $v5[0];_ = $v5[1];error = $v5[2];} $r.push(error); } return $r; })()); }, {p: ["choice", "eps"], ks: false}));
$.meth($c, "estimates", $.def(function (choice, eps) { const self = this;let estimates;
estimates = (() => { const $r = []; for (const $v6 of $.it($.b.range($.b.len($.ga(self, "_blocks"))))) { let left_out; left_out = $v6; $r.push(self._without(choice, eps, left_out)); } return $r; })();
return (() => { const $r = []; for (const $v7 of $.it($.k($.b.zip, [estimates, $.ga(self, "_blocks")], {"strict": true}))) { let found, block; {const $v8 = $.unpack($v7, 2, -1);found = $v8[0];block = $v8[1];} $r.push($.tup(found, block, self._rms(found, block))); } return $r; })(); }, {p: ["choice", "eps"], ks: false}));
$.meth($c, "_without", $.def(function (choice, eps, left_out) { const self = this;let others, sums, estimate;
others = (() => { const $r = []; for (const $v9 of $.it($.b.enumerate($.ga(self, "_sums")))) { let k, block; {const $v10 = $.unpack($v9, 2, -1);k = $v10[0];block = $v10[1];} if ($.t($.ne(k, left_out))) { $r.push(block); } } return $r; })();
sums = self._summed($.km(np, "sum", [others], {"axis": 0}), left_out);
estimate = $.k(fit_family, [$.ga(choice, "family"), sums, eps, $.ga(self, "knots"), $.ga(choice, "regularisation")], {"fold_ridge": $.mul($.pow(FOLD_RIDGE, 2), $.ga(self, "_samples")), "warm": $.cm($.ga(self, "_warm"), "get", [$.tup($.ga(choice, "family"), left_out)]), "triangle": $.def(() => {  return self._triangle(left_out); }, {p: [], ks: false})});
$.si($.ga(self, "_warm"), $.tup($.ga(choice, "family"), left_out), $.ga(estimate, "passive"));
return estimate; }, {p: ["choice", "eps", "left_out"], ks: false}));
$.meth($c, "whole", $.def(function (choice, eps) { const self = this;let whole, estimate;
whole = ($.t($.eq($.b.len($.ga(self, "_sums")), 1)) ? $.gi($.ga(self, "_sums"), 0) : $.km(np, "sum", [$.ga(self, "_sums")], {"axis": 0}));
estimate = $.k(fit_family, [$.ga(choice, "family"), self._summed(whole, null), eps, $.ga(self, "knots"), $.ga(choice, "regularisation")], {"warm": $.cm($.ga(self, "_warm"), "get", [$.tup($.ga(choice, "family"), (-1))]), "triangle": $.def(() => {  return self._triangle(null); }, {p: [], ks: false})});
$.si($.ga(self, "_warm"), $.tup($.ga(choice, "family"), (-1)), $.ga(estimate, "passive"));
return $.tup(estimate, $.km(self, "_rms", [estimate, $.b.slice(0, $.ga($.ga(self, "_y"), "size"))], {"alone": false})); }, {p: ["choice", "eps"], ks: false}));
$.meth($c, "_summed", $.def(function (matrix, left_out) { const self = this;let counts;
if (!$.t($.b.any((function* () { for (const $v11 of $.it($.ga($.ga(self, "_short"), "pieces"))) { let piece; piece = $v11; yield $.ga(piece, "own_level"); } })()))) {return NormalEquations($.ga($.ga(self, "_bank"), "thresholds"), matrix);}
counts = ($.t(($.ga(self, "_weight") == null)) ? np.ones($.ga($.ga(self, "_y"), "size")) : $.cm($.ga(self, "_weight"), "copy", []));
if ($.t((left_out != null))) {$.si(counts, $.gi($.ga(self, "_blocks"), left_out), 0.0);}
return NormalEquations($.ga($.ga(self, "_bank"), "thresholds"), matrix, $.b.float(np.sum(counts))); }, {p: ["matrix", "left_out"], ks: false}));
$.meth($c, "_rms", $.def(function (estimate, block, alone = true) { const self = this;let bank, inner, residual;
bank = $.ga(self, "_bank");
inner = $.gi($.ga(self, "_short").outputs($.ga(bank, "thresholds"), $.ga(bank, "states"), $.ga(estimate, "weights"), $.ga(estimate, "offset")), block);
residual = $.ga(self, "_short").levelled($.sub(mapped(estimate, inner, $.ga(self, "knots")), $.gi($.ga(self, "_y"), block)), block, alone);
return $.b.float(np.sqrt($.km(np, "average", [$.pow(residual, 2)], {"weights": ($.t(($.ga(self, "_weight") == null)) ? null : $.gi($.ga(self, "_weight"), block))}))); }, {p: ["estimate", "block", "alone"], ks: false}));
$.meth($c, "_triangle", $.def(function (left_out) { const self = this;let triangle, plays, rows, block;
triangle = $.from("dehyst.identification.least_squares", "triangle");
plays = $.ga(self, "_short").plays($.ga($.ga(self, "_bank"), "thresholds"), $.ga($.ga(self, "_bank"), "states"));
rows = np.column_stack([np.ones($.ga($.ga(self, "_y"), "size")), plays, $.ga($.ga(self, "_targets"), "T")]);
for (const $v12 of $.it($.ga(self, "_blocks"))) { block = $v12;
{$.si(rows, block, $.km($.ga(self, "_short"), "levelled", [$.gi(rows, block), block], {"alone": false}));} }
if ($.t(($.ga(self, "_weight") != null))) {rows = $.imul(rows, $.gi(np.sqrt($.ga(self, "_weight")), $.tup($.slice(null, null, null), null)));}
return triangle(($.t((left_out == null)) ? rows : $.km(np, "delete", [rows, $.gi($.ga(self, "_blocks"), left_out)], {"axis": 0}))); }, {p: ["left_out"], ks: false}));});
COMPARED_ROWS = 4000;
{const $v13 = $.unpack($.tup(100, 2000), 2, -1);COMPARED_OPERATORS = $v13[0];STARTING_OPERATORS = $v13[1];}
FEWEST_ROWS = 40;
FLOOR = 0.1;
WITHIN_NOISE = 0.02;
CLEARLY_BETTER = 0.15;
NO_DIFFERENCE = 0.002;
STATIC_AS_GOOD = 0.95;
REGULARISATIONS = $.b.tuple((function* () { for (const $v15 of $.it($.tup(0.003, 0.01, 0.03))) { let s; s = $v15; for (const $v14 of $.it($.tup(0.05, 0.1))) { let r; r = $v14; yield Regularisation(s, r); } } })());
STOP_POWER = 2;
OPERATORS = $.tup(5, 7, 10, 14, 20, 28, 40, 57, 80, 113, 160);
POWERS = $.tup(1.0, 2.0);
LOOSE = 0.001;
AFFORDABLE = 0.05;
EXACT = 1e-06;
ROOM = 0.9;
FIRMER = $.tup(0.01, 0.0125, 0.016, 0.02, 0.025, 0.0315, 0.04, 0.05, 0.063, 0.08, 0.1, 0.125, 0.16, 0.2, 0.25, 0.315);
STARTS = $.tup("zero", "rest", "rising", "falling");
BY_ORIENTATION = $.dict([["counter-clockwise", $.tup(STATIC, "pi", "modified-pi")], ["clockwise", $.tup(STATIC, "stop", "pi-cumulative")], ["mixed", $.tup(STATIC, ...$.it(FAMILIES))], ["none", $.tup(STATIC, "pi", "modified-pi")]]);
Choice = $.cls("Choice", [], "", [["family", null], ["initial_state", null], ["regularisation", null], ["power", () => null]], true, true, ($c) => { Choice = $c; });
threshold_grid = $.def(function (data, operators, choice, given) { let power, radius, grid;
power = ($.t(($.ga(choice, "power") == null)) ? grid_power($.ga(choice, "family")) : $.ga(choice, "power"));
if ($.t((given != null))) {return $.div(given, $.ga(data, "half_range"));}
radius = $.b.max((function* () { for (const $v16 of $.it($.ga(data, "pieces"))) { let piece; piece = $v16; if ($.t($.ga(piece, "split"))) { yield largest_radius($.ga(choice, "initial_state"), $.b.float($.gi($.ga(piece, "x"), 0)), ...$.it(extremes($.ga(piece, "x"), $.b.slice(0, $.ga(piece, "split"))))); } } })());
grid = $.mul($.pow($.div(np.arange(operators), operators), power), radius);
return grid; }, {p: ["data", "operators", "choice", "given"], ks: false});
grid_power = $.def(function (family) { 
return ($.t($.eq(family, "stop")) ? STOP_POWER : 1); }, {p: ["family"], ks: false});
possible_choices = $.def(function* (families, starts) { let family, start;
for (const $v17 of $.it(families)) { family = $v17;
{for (const $v18 of $.it(($.t($.ne(family, STATIC)) ? starts : $.gi(starts, $.slice(null, 1, null))))) { start = $v18;
{if ($.t($.eq(family, "modified-pi"))) {(yield* $.it((function* () { for (const $v19 of $.it(REGULARISATIONS)) { let regularisation; regularisation = $v19; yield Choice(family, start, regularisation); } })()));} else {(yield Choice(family, start, null));}} }} } }, {p: ["families", "starts"], ks: false});
compare = $.def(function (data, choices, operators, eps, given) { let listed, shorts, errors_of, results;
listed = $.b.list(choices);
shorts = $.dict((() => { const $r = []; for (const $v20 of $.it($.cm(_memories(listed), "items", []))) { let unknown, start; {const $v21 = $.unpack($v20, 2, -1);unknown = $v21[0];start = $v21[1];} $r.push([unknown, shorten(data, start, COMPARED_ROWS)]); } return $r; })());
errors_of = $.def(function (group) { let start, short, bank, folds;
start = $.ga($.gi(group, 0), "initial_state");
short = $.gi(shorts, $.eq(start, "unknown"));
if ($.t($.lt($.ga(short, "rows"), FEWEST_ROWS))) {return [];}
if ($.t($.eq($.ga($.gi(group, 0), "family"), STATIC))) {return [$.tup($.gi(group, 0), held_out_errors(short, blocks_of($.ga(short, "rows"))))];}
bank = make_bank(data, threshold_grid(data, $.b.min(operators, COMPARED_OPERATORS), $.gi(group, 0), given), start);
folds = $.k(Folds, [short, bank], {"ramps": $.b.any((function* () { for (const $v22 of $.it(group)) { let choice; choice = $v22; yield $.eq($.ga(choice, "family"), "modified-pi"); } })())});
return (() => { const $r = []; for (const $v23 of $.it(group)) { let choice; choice = $v23; $r.push($.tup(choice, folds.errors(choice, eps))); } return $r; })(); }, {p: ["group"], ks: false});
results = (() => { const $r = []; for (const $v25 of $.it(in_parallel(errors_of, _by_bank(listed)))) { let part; part = $v25; for (const $v24 of $.it(part)) { let result; result = $v24; $r.push(result); } } return $r; })();
return $.k($.b.sorted, [results], {"key": $.def((result) => {  return $.cm(listed, "index", [$.gi(result, 0)]); }, {p: ["result"], ks: false})}); }, {p: ["data", "choices", "operators", "eps", "given"], ks: false});
_memories = $.def(function (choices) { 
return $.dict((() => { const $r = []; for (const $v26 of $.it(choices)) { let choice; choice = $v26; $r.push([$.eq($.ga(choice, "initial_state"), "unknown"), $.ga(choice, "initial_state")]); } return $r; })()); }, {p: ["choices"], ks: false});
_by_bank = $.def(function (choices) { let groups, choice, bank;
groups = $.dict([]);
for (const $v27 of $.it(choices)) { choice = $v27;
{bank = $.tup($.ga(choice, "initial_state"), grid_power($.ga(choice, "family")), $.eq($.ga(choice, "family"), STATIC));
$.cm($.cm(groups, "setdefault", [bank, []]), "append", [choice]);} }
return $.b.list($.cm(groups, "values", [])); }, {p: ["choices"], ks: false});
start_of_paper = $.def(function (data, operators, eps, given) { let errors, short, start, grid, bank, folds, best;
errors = $.dict([]);
short = shorten(data, "zero", COMPARED_ROWS);
if ($.t($.lt($.ga(short, "rows"), FEWEST_ROWS))) {return "zero";}
for (const $v28 of $.it($.tup("zero", "origin", "rest", "rising", "falling"))) { start = $v28;
{grid = threshold_grid(data, $.b.min(operators, STARTING_OPERATORS), Choice("pi", start, null), given);
bank = make_bank(data, grid, start);
folds = $.k(Folds, [short, bank], {"blocks": 1, "ramps": false});
$.si(errors, start, $.gi(folds.whole(Choice("pi", start, null), eps), 1));} }
best = $.k($.b.min, [errors], {"key": $.def((start) => {  return rank($.gi(errors, start)); }, {p: ["start"], ks: false})});
return ($.t($.lt($.gi(errors, best), $.mul(0.5, $.gi(errors, "zero")))) ? best : "zero"); }, {p: ["data", "operators", "eps", "given"], ks: false});
choose_operators = $.def(function (data, choice, eps) { let start, short, grids, score_of, scores, enough, own, good;
start = $.ga(choice, "initial_state");
short = shorten(data, start, COMPARED_ROWS);
if ($.t($.lt($.ga(short, "rows"), FEWEST_ROWS))) {return $.tup(COMPARED_OPERATORS, choice);}
grids = (() => { const $r = []; for (const $v30 of $.it(OPERATORS)) { let n; n = $v30; for (const $v29 of $.it(POWERS)) { let power; power = $v29; $r.push($.tup(n, $.k(replace, [choice], {"power": power}))); } } return $r; })();
score_of = $.def(function (grid) { let n, setting, bank, folds;
{const $v31 = $.unpack(grid, 2, -1);n = $v31[0];setting = $v31[1];}
bank = make_bank(data, threshold_grid(data, n, setting, null), start);
folds = $.k(Folds, [short, bank], {"ramps": $.eq($.ga(setting, "family"), "modified-pi")});
return _score(folds.errors(setting, eps)); }, {p: ["grid"], ks: false});
scores = in_parallel(score_of, grids);
enough = $.add($.b.min(scores), np.log1p(WITHIN_NOISE));
own = grid_power($.ga(choice, "family"));
good = (() => { const $r = []; for (const $v32 of $.it($.k($.b.zip, [grids, scores], {"strict": true}))) { let grid, score; {const $v33 = $.unpack($v32, 2, -1);grid = $v33[0];score = $v33[1];} if ($.t($.le(score, enough))) { $r.push(grid); } } return $r; })();
return $.k($.b.min, [good], {"key": $.def((grid) => {  return $.tup($.gi(grid, 0), $.ne($.ga($.gi(grid, 1), "power"), own)); }, {p: ["grid"], ks: false})}); }, {p: ["data", "choice", "eps"], ks: false});
Firmness = $.cls("Firmness", [], "NamedTuple", [["affordable", () => null], ["enough", () => null], ["cost", () => 0.0], ["strain", () => 0.0]], false, true, ($c) => { Firmness = $c; $.meth($c, "times", $.def(function (slope) { const self = this;let affordable, enough;
{const $v35 = $.unpack((function* () { for (const $v34 of $.it($.gi(self, $.slice(null, 2, null)))) { let eps; eps = $v34; yield ($.t((eps == null)) ? null : $.mul(eps, slope)); } })(), 2, -1);affordable = $v35[0];enough = $v35[1];}
return $.km(self, "_replace", [], {"affordable": affordable, "enough": enough}); }, {p: ["slope"], ks: false}));});
firmness = $.def(function (data, choice, operators, eps, given) { let start, short, bank;
start = $.ga(choice, "initial_state");
if ($.t($.eq($.ga(choice, "family"), STATIC))) {return _firmness(partial(fit_static, data, start), eps);}
short = shorten(data, start, COMPARED_ROWS);
if ($.t($.lt($.ga(short, "rows"), FEWEST_ROWS))) {return Firmness();}
bank = make_bank(data, threshold_grid(data, $.b.min(operators, COMPARED_OPERATORS), choice, given), start);
return _firmness(partial($.ga(Folds(short, bank, 1, $.eq($.ga(choice, "family"), "modified-pi")), "whole"), choice), eps); }, {p: ["data", "choice", "operators", "eps", "given"], ks: false});
_firmness = $.def(function (fitted, eps) { let estimate, error, found, firmer, raised, cost;
{const $v36 = $.unpack(fitted(eps), 2, -1);estimate = $v36[0];error = $v36[1];}
found = $.k(Firmness, [], {"strain": ($.t($.gt(eps, LOOSE)) ? _raised(error, $.gi(fitted(LOOSE), 1)) : 0.0)});
for (const $v37 of $.it(($.t(is_high(gain_of(estimate))) ? FIRMER : $.tup()))) { firmer = $v37;
{if ($.t($.le(firmer, eps))) {continue;}
{const $v38 = $.unpack(fitted(firmer), 2, -1);estimate = $v38[0];raised = $v38[1];}
cost = _raised(raised, error);
if ($.t($.le(cost, AFFORDABLE))) {found = $.km(found, "_replace", [], {"affordable": firmer});}
if (!$.t(is_high($.div(gain_of(estimate), ROOM)))) {return $.km(found, "_replace", [], {"enough": firmer, "cost": cost});}} }
return found; }, {p: ["fitted", "eps"], ks: false});
_raised = $.def(function (error, beside) { 
return $.sub($.b.float($.div(np.hypot(error, EXACT), np.hypot(beside, EXACT))), 1.0); }, {p: ["error", "beside"], ks: false});
choose = $.def(function (results) { let floor, scores, order, winner, families, index, simpler, margin, same, candidates;
floor = $.mul(FLOOR, $.b.min((function* () { for (const $v39 of $.it(results)) { let _, errors; {const $v40 = $.unpack($v39, 2, -1);_ = $v40[0];errors = $v40[1];} yield $.b.float(np.sqrt(np.mean($.pow(errors, 2)))); } })()));
scores = (() => { const $r = []; for (const $v41 of $.it(results)) { let _, errors; {const $v42 = $.unpack($v41, 2, -1);_ = $v42[0];errors = $v42[1];} $r.push(_score(np.hypot(errors, floor))); } return $r; })();
order = $.k($.b.sorted, [$.b.range($.b.len(results))], {"key": $.ga(scores, "__getitem__")});
winner = $.gi(order, 0);
families = $.b.list($.b.dict.fromkeys((function* () { for (const $v43 of $.it(results)) { let choice, _; {const $v44 = $.unpack($v43, 2, -1);choice = $v44[0];_ = $v44[1];} yield $.ga(choice, "family"); } })()));
for (const $v45 of $.it(order)) { index = $v45;
{simpler = $.lt($.cm(families, "index", [$.ga($.gi($.gi(results, index), 0), "family")]), $.cm(families, "index", [$.ga($.gi($.gi(results, winner), 0), "family")]));
margin = ($.t($.eq($.ga($.gi($.gi(results, $.gi(order, 0)), 0), "family"), "pi-cumulative")) ? CLEARLY_BETTER : WITHIN_NOISE);
if ($.t($.eq($.ga($.gi($.gi(results, index), 0), "family"), STATIC))) {margin = $.sub($.div(1.0, STATIC_AS_GOOD), 1.0);}
if (($.t(simpler) && $.t($.le($.sub($.gi(scores, index), $.gi(scores, $.gi(order, 0))), np.log1p(margin))))) {winner = index;}} }
for (const $v46 of $.it($.b.range($.b.len(results)))) { index = $v46;
{same = $.eq($.k(replace, [$.gi($.gi(results, index), 0)], {"initial_state": $.ga($.gi($.gi(results, winner), 0), "initial_state")}), $.gi($.gi(results, winner), 0));
if (($.t(same) && $.t($.lt(index, winner)) && $.t($.le($.sub($.gi(scores, index), $.gi(scores, winner)), np.log1p(NO_DIFFERENCE))))) {winner = index;}} }
candidates = (() => { const $r = []; for (const $v47 of $.it([winner, ...$.it((function* () { for (const $v48 of $.it(order)) { let k; k = $v48; if ($.t($.ne(k, winner))) { yield k; } } })())])) { let index; index = $v47; $r.push($.k(_candidate, [...$.it($.gi(results, index))], {"chosen": $.eq(index, winner)})); } return $r; })();
return $.tup($.gi($.gi(results, winner), 0), $.b.tuple(candidates)); }, {p: ["results"], ks: false});
_score = $.def(function (errors) { 
return $.b.float(np.log(rank($.b.float(np.exp(np.mean(np.log($.add(errors, 1e-12)))))))); }, {p: ["errors"], ks: false});
_candidate = $.def(function (choice, errors, chosen) { let percent;
percent = $.mul(50.0, errors);
return $.k(Candidate, [], {"family": $.ga(choice, "family"), "initial_state": $.ga(choice, "initial_state"), "smoothing": ($.t(($.ga(choice, "regularisation") == null)) ? null : $.ga($.ga(choice, "regularisation"), "smoothing")), "error_percent": $.b.float(np.exp(np.mean(np.log(np.maximum(percent, 1e-12))))), "uncertainty_percent": $.b.float($.div($.km(np, "std", [percent], {"ddof": 1}), np.sqrt($.ga(percent, "size")))), "chosen": chosen}); }, {p: ["choice", "errors", "chosen"], ks: false});
Object.assign($m, {"annotations": annotations, "Callable": Callable, "Iterable": Iterable, "Iterator": Iterator, "Sequence": Sequence, "dataclass": dataclass, "replace": replace, "partial": partial, "NamedTuple": NamedTuple, "Protocol": Protocol, "np": np, "npt": npt, "Array": Array_, "rank": rank, "DataSet": DataSet, "extremes": extremes, "FAMILIES": FAMILIES, "MAP_PIECES": MAP_PIECES, "STATIC": STATIC, "Estimate": Estimate, "Regularisation": Regularisation, "fit_family": fit_family, "gain_of": gain_of, "is_high": is_high, "mapped": mapped, "Candidate": Candidate, "largest_radius": largest_radius, "Bank": Bank, "NormalEquations": NormalEquations, "make_bank": make_bank, "ramp_columns": ramp_columns, "ShortSignal": ShortSignal, "shorten": shorten, "fit_static": fit_static, "held_out_errors": held_out_errors, "in_parallel": in_parallel, "Marks": Marks, "BLOCKS": BLOCKS, "FOLD_RIDGE": FOLD_RIDGE, "output_knots": output_knots, "blocks_of": blocks_of, "Setting": Setting, "Folds": Folds, "COMPARED_ROWS": COMPARED_ROWS, "COMPARED_OPERATORS": COMPARED_OPERATORS, "STARTING_OPERATORS": STARTING_OPERATORS, "FEWEST_ROWS": FEWEST_ROWS, "FLOOR": FLOOR, "WITHIN_NOISE": WITHIN_NOISE, "CLEARLY_BETTER": CLEARLY_BETTER, "NO_DIFFERENCE": NO_DIFFERENCE, "STATIC_AS_GOOD": STATIC_AS_GOOD, "REGULARISATIONS": REGULARISATIONS, "STOP_POWER": STOP_POWER, "OPERATORS": OPERATORS, "POWERS": POWERS, "LOOSE": LOOSE, "AFFORDABLE": AFFORDABLE, "EXACT": EXACT, "ROOM": ROOM, "FIRMER": FIRMER, "STARTS": STARTS, "BY_ORIENTATION": BY_ORIENTATION, "Choice": Choice, "threshold_grid": threshold_grid, "grid_power": grid_power, "possible_choices": possible_choices, "compare": compare, "_memories": _memories, "_by_bank": _by_bank, "start_of_paper": start_of_paper, "choose_operators": choose_operators, "Firmness": Firmness, "firmness": firmness, "_firmness": _firmness, "_raised": _raised, "choose": choose, "_score": _score, "_candidate": _candidate});
});
$.module("dehyst.identification.settings", ($m) => {
let annotations, Sequence, np, npt, Array_, Recording, require_recordings, ParameterError, DataSet, FAMILIES, STATIC, INITIAL_STATES, mended, parameter_array, parameter_number, strictly_increasing, PAPER_OPERATORS, PAPER_EPS, MOST_OPERATORS, SMALLEST_EPS, LARGEST_WEIGHT, AUTO, check_recordings, eps_of_call, refuse_both, check_settings, check_operators, check_weights, paper_eps;
Sequence = $.from("collections.abc", "Sequence");
np = $.imp("numpy");
npt = $.imp("numpy.typing");
Array_ = $.from("dehyst.arrays", "Array");
Recording = $.from("dehyst.data.recording", "Recording");require_recordings = $.from("dehyst.data.recording", "require_recordings");
ParameterError = $.from("dehyst.errors", "ParameterError");
DataSet = $.from("dehyst.identification.data", "DataSet");
FAMILIES = $.from("dehyst.identification.families", "FAMILIES");STATIC = $.from("dehyst.identification.families", "STATIC");
INITIAL_STATES = $.from("dehyst.identification.memory", "INITIAL_STATES");
mended = $.from("dehyst.identification.mending", "mended");
parameter_array = $.from("dehyst.models.arrays", "parameter_array");parameter_number = $.from("dehyst.models.arrays", "parameter_number");strictly_increasing = $.from("dehyst.models.arrays", "strictly_increasing");
PAPER_OPERATORS = 100;
PAPER_EPS = 0.001;
MOST_OPERATORS = 10000;
SMALLEST_EPS = 1e-12;
LARGEST_WEIGHT = 1000000000.0;
AUTO = "auto";
check_recordings = $.def(function (recordings) { let records, units;
records = require_recordings(recordings);
units = $.b.set((() => { const $r = []; for (const $v1 of $.it(records)) { let record; record = $v1; $r.push($.tup($.ga(record, "input_unit"), $.ga(record, "output_unit"))); } return $r; })());
if ($.t($.gt($.b.len(units), 1))) {throw $.exc($.k(ParameterError, [("" + "the recordings carry different units, " + $.f($.b.sorted(units), "", -1) + "; one model has one pair of units. Convert them first.")], {"units": units}));}
return $.b.tuple($.b.map(mended, records)); }, {p: ["recordings"], ks: false});
eps_of_call = $.def(function (family, eps) { 
if ($.t((eps == null))) {return $.tup(PAPER_EPS, $.ne(family, "pi"));}
if ($.t($.b.isinstance(eps, $.b.str))) {if ($.t($.ne(eps, AUTO))) {throw $.exc($.k(ParameterError, [("" + "eps = " + $.f(eps, ("" + ".40"), 114) + " is neither a number nor 'auto'; it is the smallest slope after a reversal. Pass for example 0.1, or 'auto' for the firmest that costs less than 5 % of the accuracy.")], {"eps": eps}));}
return $.tup(PAPER_EPS, true);}
return $.tup(parameter_number(eps, "eps"), false); }, {p: ["family", "eps"], ks: false});
refuse_both = $.def(function (eps, shear, max_inverse_gain) { 
if ($.t((max_inverse_gain != null))) {throw $.exc(ParameterError(("" + "eps = " + $.f(eps, "", -1) + " and max_inverse_gain were both given; both bound the slope after a reversal. Leave one of them out.")));}
if (($.t($.b.isinstance(eps, $.b.str)) && $.t((shear != null)))) {throw $.exc(ParameterError("eps = 'auto' chooses by the error of the fit, which says little of a sheared loop. Leave it out, or say what the compensator may amplify (--max-inverse-gain)."));} }, {p: ["eps", "shear", "max_inverse_gain"], ks: false});
check_settings = $.def(function (family, n, eps, thresholds, initial_state) { let given;
if ((!$.t($.b.isinstance(family, $.b.str)) || $.t(!$.in(family, $.tup("auto", STATIC, ...$.it(FAMILIES)))))) {throw $.exc($.k(ParameterError, [("" + "family " + $.f(family, ("" + ".60"), 114) + " is not one of auto, " + $.f($.cm(", ", "join", [FAMILIES]), "", -1) + ", " + $.f(STATIC, "", -1) + ", direct-inverse, which can be exported. Families of the literature (bouc-wen, preisach, dahl, ...) are identified by dehyst.identify_family, or `dehyst compare LOG ... --families NAME --save model.json`.")], {"family": family}));}
if (($.t($.ne(initial_state, "auto")) && $.t(!$.in(initial_state, INITIAL_STATES)))) {throw $.exc($.k(ParameterError, [("" + "initial_state " + $.f(initial_state, "", 114) + " is not one of auto, " + $.f($.cm(", ", "join", [INITIAL_STATES]), "", -1) + ".")], {"initial_state": initial_state}));}
check_operators(n, (thresholds != null));
eps = parameter_number(eps, "eps");
if (($.t($.lt(eps, SMALLEST_EPS)) || ($.t($.gt(eps, 1.0)) && $.t($.ne(family, "pi"))))) {throw $.exc($.k(ParameterError, [("" + "eps = " + $.f(eps, ("" + "g"), -1) + " must lie between " + $.f(SMALLEST_EPS, ("" + "g"), -1) + " and 1: it is the smallest slope after a reversal, relative to output range over input range, and 1/eps bounds the inverse's gain. The paper uses 0.001.")], {"eps": eps}));}
if ($.t((thresholds == null))) {return null;}
given = parameter_array(thresholds, "thresholds");
strictly_increasing(given, "thresholds");
if ($.t($.ne($.gi(given, 0), 0.0))) {throw $.exc($.k(ParameterError, [("" + "thresholds[0] = " + $.f($.gi(given, 0), ("" + "g"), -1) + " must be 0: without a play of radius 0 the model has no inverse.")], {"first": $.b.float($.gi(given, 0))}));}
if ($.t($.gt($.ga(given, "size"), MOST_OPERATORS))) {check_operators($.ga(given, "size"), false);}
return given; }, {p: ["family", "n", "eps", "thresholds", "initial_state"], ks: false});
check_operators = $.def(function (n, given) { 
if (($.t($.eq(n, AUTO)) && $.t($.b.isinstance(n, $.b.str)))) {if ($.t(given)) {throw $.exc($.k(ParameterError, ["n = 'auto' chooses the thresholds, but thresholds are given too. Leave one of them out."], {"n": n}));}
return null;}
if (($.t($.b.isinstance(n, $.b.bool)) || !$.t($.b.isinstance(n, $.tup($.b.int, $.ga(np, "integer")))) || $.t($.lt(n, 1)))) {throw $.exc($.k(ParameterError, [("" + "n = " + $.f(n, "", 114) + " operators: pass a whole number from 1 to " + $.f(MOST_OPERATORS, "", -1) + " (the paper uses 100), or 'auto'.")], {"n": n}));}
if ($.t($.gt(n, MOST_OPERATORS))) {throw $.exc($.k(ParameterError, [("" + "n = " + $.f(n, "", -1) + " operators: their sums would take several times " + $.f($.mul(8e-09, $.pow($.b.float($.b.min(n, $.pow(10, 12))), 2)), ("" + ".3g"), -1) + " GB, since memory grows with n^2. Pass at most " + $.f(MOST_OPERATORS, "", -1) + "; the paper uses 100, and a log seldom tells more than a few hundred apart.")], {"n": n}));} }, {p: ["n", "given"], ks: false});
check_weights = $.def(function (weights, records) { let listed, arrays, fault, w, record, bad;
if ($.t((weights == null))) {return null;}
listed = (($.t($.b.isinstance(weights, $.ga(np, "ndarray"))) && $.t($.eq($.ga(weights, "ndim"), 1))) ? [weights] : weights);
try {arrays = $.b.tuple((function* () { for (const $v2 of $.it(listed)) { let w; w = $v2; yield $.km(np, "ascontiguousarray", [w], {"dtype": $.ga(np, "float64")}); } })());} catch ($e) { $e = $.caught($e); if ($.isinst($e, $.tup($.b.TypeError, $.b.ValueError))) { fault = $e; {throw $.exc(ParameterError(("" + "weights are not numbers (" + $.f(fault, "", -1) + "). Pass an array with one weight for each sample, or a list of such arrays, one for each recording.")));} } else throw $e; }
if (($.t($.eq($.b.len(records), 1)) && $.t($.eq($.b.len(arrays), $.b.len($.gi(records, 0)))) && $.t($.b.all((function* () { for (const $v3 of $.it(arrays)) { let w; w = $v3; yield $.eq($.ga(w, "ndim"), 0); } })())))) {arrays = $.tup($.km(np, "array", [arrays], {"dtype": $.ga(np, "float64")}));}
if ($.t($.ne((() => { const $r = []; for (const $v4 of $.it(arrays)) { let w; w = $v4; $r.push($.ga(w, "shape")); } return $r; })(), (() => { const $r = []; for (const $v5 of $.it(records)) { let record; record = $v5; $r.push($.tup($.b.len(record))); } return $r; })()))) {throw $.exc(ParameterError(("" + "weights have the shapes " + $.f((() => { const $r = []; for (const $v6 of $.it(arrays)) { let w; w = $v6; $r.push($.ga(w, "shape")); } return $r; })(), "", -1) + " for recordings of " + $.f((() => { const $r = []; for (const $v7 of $.it(records)) { let r; r = $v7; $r.push($.b.len(r)); } return $r; })(), "", -1) + " samples. Pass one weight for each sample: an array, or a list of arrays for several recordings.")));}
for (const $v8 of $.it($.k($.b.zip, [arrays, records], {"strict": true}))) { {const $v9 = $.unpack($v8, 2, -1);w = $v9[0];record = $v9[1];}
{bad = np.flatnonzero($.inv($.band($.ge(w, 0.0), $.le(w, LARGEST_WEIGHT))));
if ($.t($.ga(bad, "size"))) {throw $.exc($.k(ParameterError, [("" + "weight " + $.f($.gi(w, $.gi(bad, 0)), ("" + "g"), -1) + " of sample " + $.f($.gi(bad, 0), "", -1) + " of '" + $.f($.ga(record, "name"), "", -1) + "' is not a number from 0 to " + $.f(LARGEST_WEIGHT, ("" + "g"), -1) + ": squares of errors are multiplied by it. 0 leaves a sample out.")], {"index": $.b.int($.gi(bad, 0))}));}} }
return arrays; }, {p: ["weights", "records"], ks: false});
paper_eps = $.def(function (eps, record, data) { let slope, unit;
slope = $.div($.ga(data, "amplitude"), $.ga(data, "half_range"));
if ($.t($.gt(eps, slope))) {unit = (($.t($.ga(record, "output_unit")) && $.t($.ga(record, "input_unit"))) ? ("" + " " + $.f($.ga(record, "output_unit"), "", -1) + "/" + $.f($.ga(record, "input_unit"), "", -1)) : "");
throw $.exc($.k(ParameterError, [("" + "eps = " + $.f(eps, ("" + "g"), -1) + $.f(unit, "", -1) + " is larger than the mean slope of this log, " + $.f(slope, ("" + ".3g"), -1) + $.f(unit, "", -1) + ": w_1 >= eps would leave a straight line. Pass a small part of the slope, for example --eps " + $.f($.mul(0.001, slope), ("" + ".1g"), -1) + ", or --eps auto, which is relative to it.")], {"eps": eps, "slope": slope}));}
return $.div(eps, slope); }, {p: ["eps", "record", "data"], ks: false});
Object.assign($m, {"annotations": annotations, "Sequence": Sequence, "np": np, "npt": npt, "Array": Array_, "Recording": Recording, "require_recordings": require_recordings, "ParameterError": ParameterError, "DataSet": DataSet, "FAMILIES": FAMILIES, "STATIC": STATIC, "INITIAL_STATES": INITIAL_STATES, "mended": mended, "parameter_array": parameter_array, "parameter_number": parameter_number, "strictly_increasing": strictly_increasing, "PAPER_OPERATORS": PAPER_OPERATORS, "PAPER_EPS": PAPER_EPS, "MOST_OPERATORS": MOST_OPERATORS, "SMALLEST_EPS": SMALLEST_EPS, "LARGEST_WEIGHT": LARGEST_WEIGHT, "AUTO": AUTO, "check_recordings": check_recordings, "eps_of_call": eps_of_call, "refuse_both": refuse_both, "check_settings": check_settings, "check_operators": check_operators, "check_weights": check_weights, "paper_eps": paper_eps});
});
$.module("dehyst.identification.short_signal", ($m) => {
let annotations, dataclass, np, _native, Array_, Rows, DataSet, Piece, chunks, fitted_samples, without_level, OFTEN, ShortPiece, ShortSignal, shorten, _essential, _with_last;
dataclass = $.from("dataclasses", "dataclass");
np = $.imp("numpy");
_native = $.imp("dehyst._native");
Array_ = $.from("dehyst.arrays", "Array");Rows = $.from("dehyst.arrays", "Rows");
DataSet = $.from("dehyst.identification.data", "DataSet");Piece = $.from("dehyst.identification.data", "Piece");chunks = $.from("dehyst.identification.data", "chunks");
fitted_samples = $.from("dehyst.identification.regressors", "fitted_samples");without_level = $.from("dehyst.identification.regressors", "without_level");
OFTEN = 256;
ShortPiece = $.cls("ShortPiece", [], "", [["x", null], ["rows", null], ["place", null], ["y", null], ["weight", null], ["own_level", null]], true, true, ($c) => { ShortPiece = $c; });
ShortSignal = $.cls("ShortSignal", [], "", [["pieces", null]], true, true, ($c) => { ShortSignal = $c; $.prop($c, "rows", $.def(function () { const self = this;
return $.b.sum((function* () { for (const $v1 of $.it($.ga(self, "pieces"))) { let piece; piece = $v1; yield $.ga($.ga(piece, "y"), "size"); } })()); }, {p: [], ks: false}));
$.prop($c, "y", $.def(function () { const self = this;
return np.concatenate((() => { const $r = []; for (const $v2 of $.it($.ga(self, "pieces"))) { let piece; piece = $v2; $r.push($.ga(piece, "y")); } return $r; })()); }, {p: [], ks: false}));
$.prop($c, "weight", $.def(function () { const self = this;let parts;
parts = (() => { const $r = []; for (const $v3 of $.it($.ga(self, "pieces"))) { let piece; piece = $v3; $r.push($.ga(piece, "weight")); } return $r; })();
if ($.t($.b.all((function* () { for (const $v4 of $.it(parts)) { let part; part = $v4; yield (part == null); } })()))) {return null;}
return np.concatenate((() => { const $r = []; for (const $v5 of $.it($.k($.b.zip, [$.ga(self, "pieces"), parts], {"strict": true}))) { let piece, w; {const $v6 = $.unpack($v5, 2, -1);piece = $v6[0];w = $v6[1];} $r.push(($.t((w == null)) ? np.ones($.ga($.ga(piece, "y"), "size")) : w)); } return $r; })()); }, {p: [], ks: false}));
$.meth($c, "plays", $.def(function (thresholds, states) { const self = this;let parts;
parts = (() => { const $r = []; for (const $v7 of $.it($.k($.b.zip, [$.ga(self, "pieces"), states], {"strict": true}))) { let piece, state; {const $v8 = $.unpack($v7, 2, -1);piece = $v8[0];state = $v8[1];} if ($.t($.ga($.ga(piece, "y"), "size"))) { $r.push($.gi(_native.play_bank($.ga(piece, "x"), thresholds, state, $.ga(piece, "place")), 0)); } } return $r; })();
return np.concatenate(parts); }, {p: ["thresholds", "states"], ks: false}));
$.meth($c, "outputs", $.def(function (thresholds, states, weights, offset) { const self = this;let parts;
parts = (() => { const $r = []; for (const $v9 of $.it($.k($.b.zip, [$.ga(self, "pieces"), states], {"strict": true}))) { let piece, state; {const $v10 = $.unpack($v9, 2, -1);piece = $v10[0];state = $v10[1];} if ($.t($.ga($.ga(piece, "y"), "size"))) { $r.push($.gi(_native.Evaluator(thresholds, weights, 0.0, offset, state).run($.ga(piece, "x")), $.ga(piece, "place"))); } } return $r; })();
return np.concatenate(parts); }, {p: ["thresholds", "states", "weights", "offset"], ks: false}));
$.meth($c, "levelled", $.def(function (rows, block, alone = true) { const self = this;let ends, places, known, every, weight, left, inside, piece, counts;
ends = np.cumsum((() => { const $r = []; for (const $v11 of $.it($.ga(self, "pieces"))) { let piece; piece = $v11; $r.push($.ga($.ga(piece, "y"), "size")); } return $r; })()).tolist();
places = (() => { const $r = []; for (const $v12 of $.it($.k($.b.zip, [ends, $.ga(self, "pieces")], {"strict": true}))) { let end, piece; {const $v13 = $.unpack($v12, 2, -1);end = $v13[0];piece = $v13[1];} $r.push($.tup($.b.slice($.sub($.b.max($.sub(end, $.ga($.ga(piece, "y"), "size")), $.ga(block, "start")), $.ga(block, "start")), $.sub($.b.min(end, $.ga(block, "stop")), $.ga(block, "start"))), piece)); } return $r; })();
known = $.b.sum((function* () { for (const $v14 of $.it(places)) { let s, p; {const $v15 = $.unpack($v14, 2, -1);s = $v15[0];p = $v15[1];} if (!$.t($.ga(p, "own_level"))) { yield $.sub($.ga($.ga(p, "y"), "size"), $.b.max($.sub($.ga(s, "stop"), $.ga(s, "start")), 0)); } } })());
every = $.and(alone, () => $.and(!$.t(known), () => $.b.any((function* () { for (const $v16 of $.it($.ga(self, "pieces"))) { let piece; piece = $v16; yield $.ga(piece, "own_level"); } })())));
{const $v17 = $.unpack($.tup($.ga(self, "weight"), rows), 2, -1);weight = $v17[0];left = $v17[1];}
for (const $v18 of $.it(places)) { {const $v19 = $.unpack($v18, 2, -1);inside = $v19[0];piece = $v19[1];}
{if ((($.t($.ga(piece, "own_level")) || $.t(every)) && $.t($.lt($.ga(inside, "start"), $.ga(inside, "stop"))))) {left = ($.t((left === rows)) ? $.cm(rows, "copy", []) : left);
counts = ($.t((weight == null)) ? null : $.gi($.gi(weight, block), inside));
if (($.t((counts == null)) || $.t(np.any($.gt(counts, 0.0))))) {$.isi(left, inside, $.isub, $.km(np, "average", [$.gi(rows, inside)], {"axis": 0, "weights": counts}));}}} }
return left; }, {p: ["rows", "block", "alone"], ks: false}));
$.meth($c, "sums", $.def(function (thresholds, states, targets, blocks) { const self = this;let sums, begin, piece, state, end, gram, done, number, block, low, high, place, stop, weight, columns, found;
sums = $.mul([np.zeros(0)], $.b.len(blocks));
begin = 0;
for (const $v20 of $.it($.k($.b.zip, [$.ga(self, "pieces"), states], {"strict": true}))) { {const $v21 = $.unpack($v20, 2, -1);piece = $v21[0];state = $v21[1];}
{end = $.add(begin, $.ga($.ga(piece, "y"), "size"));
gram = _native.Gram(thresholds, state, $.gi($.ga(targets, "shape"), 0));
done = 0;
for (const $v22 of $.it($.b.enumerate(blocks))) { {const $v23 = $.unpack($v22, 2, -1);number = $v23[0];block = $v23[1];}
{{const $v24 = $.unpack($.tup($.b.max($.ga(block, "start"), begin), $.b.min($.ga(block, "stop"), end)), 2, -1);low = $v24[0];high = $v24[1];}
if ($.t($.ge(low, high))) {continue;}
place = $.gi($.ga(piece, "place"), $.slice($.sub(low, begin), $.sub(high, begin), null));
stop = $.add($.b.int($.gi(place, (-1))), 1);
{const $v25 = $.unpack($.tup(np.zeros($.sub(stop, done)), np.zeros($.tup($.gi($.ga(targets, "shape"), 0), $.sub(stop, done)))), 2, -1);weight = $v25[0];columns = $v25[1];}
$.si(weight, $.sub(place, done), ($.t(($.ga(piece, "weight") == null)) ? 1.0 : $.gi($.ga(piece, "weight"), $.slice($.sub(low, begin), $.sub(high, begin), null))));
$.si(columns, $.tup($.slice(null, null, null), $.sub(place, done)), $.gi(targets, $.tup($.slice(null, null, null), $.slice(low, high, null))));
$.cm(gram, "add", [$.gi($.ga(piece, "x"), $.slice(done, stop, null)), columns, weight]);
found = ($.t($.ga(piece, "own_level")) ? without_level(gram.take()) : gram.take());
$.si(sums, number, ($.t($.eq($.ga($.gi(sums, number), "size"), 0)) ? found : $.add($.gi(sums, number), found)));
done = stop;} }
begin = end;} }
return sums; }, {p: ["thresholds", "states", "targets", "blocks"], ks: false}));});
shorten = $.def(function (data, initial_state, most) { let stride, pieces, piece, span, rows, x, place, y, weight;
stride = $.b.max(1, $.neg($.fdiv($.neg(fitted_samples(data, initial_state)), most)));
pieces = [];
for (const $v26 of $.it($.ga(data, "pieces"))) { piece = $v26;
{span = piece.fitted(initial_state);
if ($.t(($.ga(piece, "weight") == null))) {rows = $.km(np, "arange", [$.ga(span, "start"), $.ga(span, "stop"), stride], {"dtype": $.ga(np, "int64")});} else {rows = $.add($.ga(span, "start"), $.gi(np.flatnonzero($.gi($.ga(piece, "weight"), span)), $.slice(null, null, stride)));}
{const $v27 = $.unpack(_essential(piece, rows), 3, -1);x = $v27[0];place = $v27[1];y = $v27[2];}
weight = ($.t(($.ga(piece, "weight") == null)) ? null : $.gi($.ga(piece, "weight"), rows));
$.cm(pieces, "append", [ShortPiece(x, rows, place, y, weight, (piece.unknown_level(initial_state) != null))]);} }
return ShortSignal($.b.tuple(pieces)); }, {p: ["data", "initial_state", "most"], ks: false});
_essential = $.def(function (piece, rows) { let kept, place, x, places, y, new_, part, low, high, inside, signal;
if ($.t($.b.isinstance($.ga(piece, "x"), $.ga(np, "ndarray")))) {{const $v28 = $.unpack(_native.essential($.ga(piece, "x"), rows), 2, -1);kept = $v28[0];place = $v28[1];}
return $.tup($.gi($.ga(piece, "x"), kept), place, $.gi($.ga(piece, "y"), rows));}
{const $v29 = $.unpack($.tup(np.zeros(0), $.km(np, "zeros", [0], {"dtype": $.ga(np, "int64")}), np.empty($.ga(rows, "size"))), 3, -1);x = $v29[0];places = $v29[1];y = $v29[2];}
new_ = [];
for (const $v30 of $.it(($.t($.ga(rows, "size")) ? chunks($.b.slice(0, $.add($.b.int($.gi(rows, (-1))), 1))) : $.tup()))) { part = $v30;
{{const $v31 = $.unpack(np.searchsorted(rows, [$.ga(part, "start"), $.ga(part, "stop")]), 2, -1);low = $v31[0];high = $v31[1];}
inside = $.sub($.gi(rows, $.slice(low, high, null)), $.ga(part, "start"));
signal = $.gi($.ga(piece, "x"), part);
{const $v32 = $.unpack(_native.essential(signal, _with_last(inside, $.ga(signal, "size"))), 2, -1);kept = $v32[0];place = $v32[1];}
places = $.cm(np, "append", [places, $.add($.add($.ga(x, "size"), $.b.sum((function* () { for (const $v33 of $.it(new_)) { let one; one = $v33; yield $.ga(one, "size"); } })())), $.gi(place, $.slice(null, $.ga(inside, "size"), null)))]);
$.cm(new_, "append", [$.gi(signal, kept)]);
$.si(y, $.slice(low, high, null), $.gi($.gi($.ga(piece, "y"), part), inside));
if ($.t($.eq($.b.len(new_), OFTEN))) {x = np.concatenate([x, ...$.it(new_)]);
{const $v34 = $.unpack(_native.essential(x, _with_last(places, $.ga(x, "size"))), 2, -1);kept = $v34[0];place = $v34[1];}
{const $v35 = $.unpack($.tup($.gi(x, kept), $.gi(place, $.slice(null, $.ga(places, "size"), null)), []), 3, -1);x = $v35[0];places = $v35[1];new_ = $v35[2];}}} }
x = np.concatenate([x, ...$.it(new_)]);
{const $v36 = $.unpack(_native.essential(x, places), 2, -1);kept = $v36[0];place = $v36[1];}
return $.tup($.gi(x, kept), place, y); }, {p: ["piece", "rows"], ks: false});
_with_last = $.def(function (rows, size) { 
return (($.t($.ga(rows, "size")) && $.t($.eq($.gi(rows, (-1)), $.sub(size, 1)))) ? rows : $.cm(np, "append", [rows, $.sub(size, 1)])); }, {p: ["rows", "size"], ks: false});
Object.assign($m, {"annotations": annotations, "dataclass": dataclass, "np": np, "_native": _native, "Array": Array_, "Rows": Rows, "DataSet": DataSet, "Piece": Piece, "chunks": chunks, "fitted_samples": fitted_samples, "without_level": without_level, "OFTEN": OFTEN, "ShortPiece": ShortPiece, "ShortSignal": ShortSignal, "shorten": shorten, "_essential": _essential, "_with_last": _with_last});
});
$.module("dehyst.identification.split", ($m) => {
let annotations, Mapping, Sequence, dataclass, Any, np, Array_, Recording, ParameterError, parameter_number, HALF, LEAST_RECORDINGS, SLACK, BALANCED, SAME_RANGE, Split, Outline, tested_on, split_recordings, checked, whole, whole_recordings, end_of, _end_within;
Mapping = $.from("collections.abc", "Mapping");Sequence = $.from("collections.abc", "Sequence");
dataclass = $.from("dataclasses", "dataclass");
Any = $.from("typing", "Any");
np = $.imp("numpy");
Array_ = $.from("dehyst.arrays", "Array");
Recording = $.from("dehyst.data.recording", "Recording");
ParameterError = $.from("dehyst.errors", "ParameterError");
parameter_number = $.from("dehyst.models.arrays", "parameter_number");
HALF = 0.5;
LEAST_RECORDINGS = 3;
SLACK = 0.02;
BALANCED = $.tup(0.4, 0.75);
SAME_RANGE = 0.01;
Split = $.cls("Split", [], "", [["ends", null], ["share", null], ["held_out", () => $.tup()]], true, true, ($c) => { Split = $c; $.prop($c, "settings", $.def(function () { const self = this;
return $.dict([["train_fraction", $.ga(self, "share")], ...$.pairs(($.t($.ga(self, "held_out")) ? $.dict([["held_out", $.b.list($.ga(self, "held_out"))]]) : $.dict([])))]); }, {p: [], ks: false}));
$.prop($c, "train_fraction", $.def(function () { const self = this;
return ($.t($.ga(self, "held_out")) ? null : $.ga(self, "share")); }, {p: [], ks: false}));
$.prop($c, "fitted_part", $.def(function () { const self = this;
if ($.t($.ga(self, "held_out"))) {return " in the recordings that are fitted";}
return ($.t($.ge($.ga(self, "share"), 1.0)) ? "" : ("" + " in the first " + $.f($.mul(100, $.ga(self, "share")), ("" + "g"), -1) + " % of the recording, which is fitted")); }, {p: [], ks: false}));});
Outline = $.cls("Outline", [], "", [["samples", null], ["low", null], ["high", null], ["output_range", null]], true, true, ($c) => { Outline = $c; });
tested_on = $.def(function (settings) { let count;
count = $.b.len($.cm(settings, "get", ["held_out", $.tup()]));
return ($.t(count) ? ("" + $.f(count, "", -1) + " recording" + $.f(($.t($.eq(count, 1)) ? "" : "s"), "", -1) + " held out") : "held-out loops"); }, {p: ["settings"], ks: false});
split_recordings = $.def(function (records, train_fraction, weights = null) { let share, outlines, k, record, counts, y, low, high, held;
share = checked(train_fraction);
if (($.t((share == null)) && $.t($.ge($.b.len(records), LEAST_RECORDINGS)))) {outlines = [];
for (const $v1 of $.it($.b.enumerate(records))) { {const $v2 = $.unpack($v1, 2, -1);k = $v2[0];record = $v2[1];}
{counts = ($.t((weights == null)) ? $.km(np, "ones", [$.b.len(record)], {"dtype": $.ga(np, "bool_")}) : $.gt($.gi(weights, k), 0.0));
$.si(counts, $.b.list($.ga(record, "left_out")), false);
y = $.gi($.ga(record, "output"), counts);
{const $v3 = $.unpack($.tup($.b.float($.ga(record, "input").min()), $.b.float($.ga(record, "input").max())), 2, -1);low = $v3[0];high = $v3[1];}
$.cm(outlines, "append", [Outline($.ga(y, "size"), low, high, ($.t($.ga(y, "size")) ? $.b.float(np.ptp(y)) : 0.0))]);} }
held = whole_recordings(outlines);
if ($.t(held)) {return whole((() => { const $r = []; for (const $v4 of $.it(records)) { let record; record = $v4; $r.push($.b.len(record)); } return $r; })(), held);}}
share = ($.t((share == null)) ? HALF : share);
return Split($.b.tuple((function* () { for (const $v5 of $.it(records)) { let record; record = $v5; yield _end_within(record, share); } })()), share); }, {p: ["records", "train_fraction", "weights"], ks: false});
checked = $.def(function (train_fraction) { let share;
if ($.t((train_fraction == null))) {return null;}
share = parameter_number(train_fraction, "train_fraction");
if (!$.t((($t0, $t1) => $.t($.lt(0.0, share)) && $.t($.le(share, 1.0)))())) {throw $.exc($.k(ParameterError, [("" + "train_fraction = " + $.f(share, ("" + "g"), -1) + " must lie in (0, 1]: the share of each recording that is fitted. 0.5 fits the first half and tests on the second; 1 fits all and tests nothing.")], {"train_fraction": share}));}
return share; }, {p: ["train_fraction"], ks: false});
whole = $.def(function (sizes, held) { let ends;
ends = $.b.tuple((function* () { for (const $v6 of $.it($.b.enumerate(sizes))) { let k, size; {const $v7 = $.unpack($v6, 2, -1);k = $v7[0];size = $v7[1];} yield ($.t($.in(k, held)) ? 0 : size); } })());
return Split(ends, $.div($.b.sum(ends), $.b.sum(sizes)), $.b.tuple(held)); }, {p: ["sizes", "held"], ks: false});
whole_recordings = $.def(function (outlines) { let low, high, order, slack, ranked, fitted, samples, held, k, fits, share;
{const $v10 = $.unpack($.tup($.b.min((function* () { for (const $v8 of $.it(outlines)) { let each; each = $v8; yield $.ga(each, "low"); } })()), $.b.max((function* () { for (const $v9 of $.it(outlines)) { let each; each = $v9; yield $.ga(each, "high"); } })())), 2, -1);low = $v10[0];high = $v10[1];}
if (($.t($.lt($.b.len(outlines), LEAST_RECORDINGS)) || !$.t($.gt(high, low)))) {return $.tup();}
order = $.def(function (k) { let each;
each = $.gi(outlines, k);
return $.tup($.neg($.b.round($.div($.div($.sub($.ga(each, "high"), $.ga(each, "low")), $.sub(high, low)), SAME_RANGE))), $.neg($.ga(each, "samples")), $.neg($.ga(each, "output_range")), k); }, {p: ["k"], ks: false});
slack = $.mul(SLACK, $.sub(high, low));
ranked = $.k($.b.sorted, [$.b.range($.b.len(outlines))], {"key": order});
fitted = $.b.set([$.b.next((function* () { for (const $v11 of $.it(ranked)) { let k; k = $v11; if ($.t($.le($.ga($.gi(outlines, k), "low"), $.add(low, slack)))) { yield k; } } })()), $.b.next((function* () { for (const $v12 of $.it(ranked)) { let k; k = $v12; if ($.t($.ge($.ga($.gi(outlines, k), "high"), $.sub(high, slack)))) { yield k; } } })())]);
samples = $.dict([[true, $.b.sum((function* () { for (const $v13 of $.it(fitted)) { let k; k = $v13; yield $.ga($.gi(outlines, k), "samples"); } })())], [false, 0]]);
held = [];
for (const $v14 of $.it(ranked)) { k = $v14;
{if (($.t($.in(k, fitted)) || !$.t($.ga($.gi(outlines, k), "samples")))) {continue;}
fits = $.le($.gi(samples, true), $.gi(samples, false));
$.isi(samples, fits, $.iadd, $.ga($.gi(outlines, k), "samples"));
if (!$.t(fits)) {$.cm(held, "append", [k]);}} }
share = $.div($.gi(samples, true), $.b.max($.b.sum($.cm(samples, "values", [])), 1));
return ($.t((($t0, $t1) => $.t($.le($.gi(BALANCED, 0), share)) && $.t($.le(share, $.gi(BALANCED, 1))))()) ? $.b.tuple($.b.sorted(held)) : $.tup()); }, {p: ["outlines"], ks: false});
end_of = $.def(function (samples, fraction) { 
return ($.t($.ge(fraction, 1.0)) ? samples : $.b.max(1, $.b.min($.sub(samples, 1), $.b.int($.mul(fraction, samples))))); }, {p: ["samples", "fraction"], ks: false});
_end_within = $.def(function (recording, fraction) { let counted;
counted = np.delete(np.arange($.b.len(recording)), $.km(np, "array", [$.ga(recording, "left_out")], {"dtype": $.ga(np, "int64")}));
if (($.t($.lt($.ga(counted, "size"), 2)) || $.t($.ge(fraction, 1.0)) || !$.t($.ga(recording, "left_out")))) {return end_of($.b.len(recording), fraction);}
return $.b.int($.gi(counted, end_of($.ga(counted, "size"), fraction))); }, {p: ["recording", "fraction"], ks: false});
Object.assign($m, {"annotations": annotations, "Mapping": Mapping, "Sequence": Sequence, "dataclass": dataclass, "Any": Any, "np": np, "Array": Array_, "Recording": Recording, "ParameterError": ParameterError, "parameter_number": parameter_number, "HALF": HALF, "LEAST_RECORDINGS": LEAST_RECORDINGS, "SLACK": SLACK, "BALANCED": BALANCED, "SAME_RANGE": SAME_RANGE, "Split": Split, "Outline": Outline, "tested_on": tested_on, "split_recordings": split_recordings, "checked": checked, "whole": whole, "whole_recordings": whole_recordings, "end_of": end_of, "_end_within": _end_within});
});
$.module("dehyst.identification.static_curve", ($m) => {
let annotations, Sequence, np, _native, Array_, DataSet, chunks, STATIC, Estimate, ShortSignal, MonotoneMap, StaticCurve, PIECES, KNOTS, SMALLEST_SLOPE, SMOOTHING, NO_MEMORY, fit_static, curve_of, held_out_errors, _values, _solved, _sums, _moments, _from_bins;
Sequence = $.from("collections.abc", "Sequence");
np = $.imp("numpy");
_native = $.imp("dehyst._native");
Array_ = $.from("dehyst.arrays", "Array");
DataSet = $.from("dehyst.identification.data", "DataSet");chunks = $.from("dehyst.identification.data", "chunks");
STATIC = $.from("dehyst.identification.families", "STATIC");Estimate = $.from("dehyst.identification.families", "Estimate");
ShortSignal = $.from("dehyst.identification.short_signal", "ShortSignal");
MonotoneMap = $.from("dehyst.models.monotone", "MonotoneMap");StaticCurve = $.from("dehyst.models.monotone", "StaticCurve");
PIECES = 30;
KNOTS = np.linspace((-1.0), 1.0, $.add(PIECES, 1));
SMALLEST_SLOPE = 0.001;
SMOOTHING = 0.01;
NO_MEMORY = np.zeros(1);
fit_static = $.def(function (data, initial_state, smallest = SMALLEST_SLOPE) { 
return _solved(...$.it(_sums(data, initial_state)), smallest); }, {p: ["data", "initial_state", "smallest"], ks: false});
curve_of = $.def(function (estimate, data) { let y;
y = _values(estimate);
return StaticCurve(MonotoneMap($.add($.ga(data, "center"), $.mul($.ga(data, "half_range"), KNOTS)), $.add($.ga(data, "level"), $.mul($.mul($.ga(data, "trend"), $.ga(data, "amplitude")), y)))); }, {p: ["estimate", "data"], ks: false});
held_out_errors = $.def(function (short, blocks) { let x, y, weight, parts, errors, left_out, block, others, moments, estimate, _, squared;
x = np.concatenate((() => { const $r = []; for (const $v1 of $.it($.ga(short, "pieces"))) { let piece; piece = $v1; $r.push($.gi($.ga(piece, "x"), $.ga(piece, "place"))); } return $r; })());
{const $v2 = $.unpack($.tup($.ga(short, "y"), $.ga(short, "weight")), 2, -1);y = $v2[0];weight = $v2[1];}
parts = (() => { const $r = []; for (const $v3 of $.it(blocks)) { let b; b = $v3; $r.push(_moments($.gi(x, b), $.gi(y, b), ($.t((weight == null)) ? null : $.gi(weight, b)))); } return $r; })();
errors = [];
for (const $v4 of $.it($.b.enumerate(blocks))) { {const $v5 = $.unpack($v4, 2, -1);left_out = $v5[0];block = $v5[1];}
{others = (() => { const $r = []; for (const $v6 of $.it($.b.enumerate(parts))) { let k, part; {const $v7 = $.unpack($v6, 2, -1);k = $v7[0];part = $v7[1];} if ($.t($.ne(k, left_out))) { $r.push(part); } } return $r; })();
moments = $.km(np, "sum", [(() => { const $r = []; for (const $v8 of $.it(others)) { let bins, _; {const $v9 = $.unpack($v8, 2, -1);bins = $v9[0];_ = $v9[1];} $r.push(bins); } return $r; })()], {"axis": 0});
{const $v12 = $.unpack(_solved(moments, $.b.sum((function* () { for (const $v10 of $.it(others)) { let _, square; {const $v11 = $.unpack($v10, 2, -1);_ = $v11[0];square = $v11[1];} yield square; } })()), SMALLEST_SLOPE), 2, -1);estimate = $v12[0];_ = $v12[1];}
squared = $.pow(short.levelled($.sub(np.interp($.gi(x, block), KNOTS, _values(estimate)), $.gi(y, block)), block), 2);
$.cm(errors, "append", [np.sqrt($.km(np, "average", [squared], {"weights": ($.t((weight == null)) ? null : $.gi(weight, block))}))]);} }
return np.array(errors); }, {p: ["short", "blocks"], ks: false});
_values = $.def(function (estimate) { let rises;
rises = np.concatenate([[0.0], np.cumsum($.mul($.gi($.ga(estimate, "parameters"), $.slice(1, null, null)), np.diff(KNOTS)))]);
return $.add($.ga(estimate, "offset"), rises); }, {p: ["estimate"], ks: false});
_solved = $.def(function (moments, square, smallest) { let gram, rhs, difference, extra, lower, u, passive, kkt, condition, _, left, estimate;
{const $v13 = $.unpack(_from_bins(moments), 2, -1);gram = $v13[0];rhs = $v13[1];}
difference = $.sub($.km(np, "eye", [$.sub(PIECES, 1), PIECES], {"k": 1}), np.eye($.sub(PIECES, 1), PIECES));
extra = np.zeros_like(gram);
$.si(extra, $.tup($.slice(1, null, null), $.slice(1, null, null)), $.mul($.mul($.pow(SMOOTHING, 2), $.gi(gram, $.tup(0, 0))), $.mm($.ga(difference, "T"), difference)));
lower = np.full($.add(1, PIECES), smallest);
{const $v14 = $.unpack(_native.solve_bounded(gram, rhs, lower, 1, 0, $.ga(_native, "SLOPES"), extra, np.zeros($.add(1, PIECES)), null, np.sqrt(square)), 5, 4);u = $v14[0];passive = $v14[1];kkt = $v14[2];condition = $v14[3];_ = $v14[4];}
left = $.b.max($.b.float($.add($.sub(square, $.mul(2.0, $.mm(rhs, u))), $.mm($.mm(u, gram), u))), 0.0);
estimate = $.k(Estimate, [STATIC, u, $.b.float($.gi(u, 0)), np.ones(1), $.gi(u, $.slice(1, null, null)), null, null, kkt], {"condition": condition, "passive": passive});
return $.tup(estimate, $.b.float(np.sqrt($.div(left, $.gi(gram, $.tup(0, 0)))))); }, {p: ["moments", "square", "smallest"], ks: false});
_sums = $.def(function (data, initial_state) { let moments, square, piece, part, found;
{const $v15 = $.unpack($.tup(np.zeros($.tup(PIECES, 5)), 0.0), 2, -1);moments = $v15[0];square = $v15[1];}
for (const $v16 of $.it($.ga(data, "pieces"))) { piece = $v16;
{for (const $v17 of $.it(chunks(piece.fitted(initial_state)))) { part = $v17;
{found = _moments($.gi($.ga(piece, "x"), part), $.gi($.ga(piece, "y"), part), ($.t(($.ga(piece, "weight") == null)) ? null : $.gi($.ga(piece, "weight"), part)));
moments = $.iadd(moments, $.gi(found, 0));
square = $.iadd(square, $.gi(found, 1));} }} }
return $.tup(moments, square); }, {p: ["data", "initial_state"], ks: false});
_moments = $.def(function (x, y, weight) { let bins;
bins = _native.bin_sums(x, y, weight, PIECES, (-1.0), 1.0);
return $.tup(bins, $.b.float($.mm(y, ($.t((weight == null)) ? y : $.mul(weight, y))))); }, {p: ["x", "y", "weight"], ks: false});
_from_bins = $.def(function (moments) { let count, t, tt, y, ty, width, above, full, total, gram, later;
{const $v18 = $.unpack($.ga(moments, "T"), 5, -1);count = $v18[0];t = $v18[1];tt = $v18[2];y = $v18[3];ty = $v18[4];}
width = $.div(2.0, PIECES);
above = np.concatenate([$.gi($.gi(np.cumsum($.gi(count, $.slice(null, null, (-1)))), $.slice(null, null, (-1))), $.slice(1, null, null)), [0.0]]);
full = np.concatenate([$.gi($.gi(np.cumsum($.gi(y, $.slice(null, null, (-1)))), $.slice(null, null, (-1))), $.slice(1, null, null)), [0.0]]);
total = $.mul(width, $.add(t, above));
gram = np.zeros($.tup($.add(1, PIECES), $.add(1, PIECES)));
$.si(gram, $.tup(0, 0), count.sum());
{ const $v19 = total; $.si(gram, $.tup(0, $.slice(1, null, null)), $v19); $.si(gram, $.tup($.slice(1, null, null), 0), $v19);}
later = $.mul(np.triu(np.ones($.tup(PIECES, PIECES)), 1), $.mul(width, total));
$.si(gram, $.tup($.slice(1, null, null), $.slice(1, null, null)), $.add($.add(later, $.ga(later, "T")), np.diag($.mul($.pow(width, 2), $.add(tt, above)))));
return $.tup(gram, np.concatenate([[y.sum()], $.mul(width, $.add(ty, full))])); }, {p: ["moments"], ks: false});
Object.assign($m, {"annotations": annotations, "Sequence": Sequence, "np": np, "_native": _native, "Array": Array_, "DataSet": DataSet, "chunks": chunks, "STATIC": STATIC, "Estimate": Estimate, "ShortSignal": ShortSignal, "MonotoneMap": MonotoneMap, "StaticCurve": StaticCurve, "PIECES": PIECES, "KNOTS": KNOTS, "SMALLEST_SLOPE": SMALLEST_SLOPE, "SMOOTHING": SMOOTHING, "NO_MEMORY": NO_MEMORY, "fit_static": fit_static, "curve_of": curve_of, "held_out_errors": held_out_errors, "_values": _values, "_solved": _solved, "_sums": _sums, "_moments": _moments, "_from_bins": _from_bins});
});
$.module("dehyst.identification.tracking", ($m) => {
let annotations, Sequence, replace, Any, np, Array_, Mask, Recording, DehystError, STATIC, Fit, Option, MOST_SAMPLES, tracking_errors, _demand, with_table, _option_of;
Sequence = $.from("collections.abc", "Sequence");
replace = $.from("dataclasses", "replace");
Any = $.from("typing", "Any");
np = $.imp("numpy");
Array_ = $.from("dehyst.arrays", "Array");Mask = $.from("dehyst.arrays", "Mask");
Recording = $.from("dehyst.data.recording", "Recording");
DehystError = $.from("dehyst.errors", "DehystError");
STATIC = $.from("dehyst.identification.families", "STATIC");
Fit = $.from("dehyst.identification.fit", "Fit");Option = $.from("dehyst.identification.fit", "Option");
MOST_SAMPLES = 20000;
tracking_errors = $.def(function (models, rivals, records, masks) { let squares, record, mask, every, part, x, y, time, kept, demands, j, plant, applied, i, demand, moved, span;
squares = (() => { const $r = []; for (const $v1 of $.it(models)) { let _; _ = $v1; $r.push([]); } return $r; })();
for (const $v2 of $.it($.k($.b.zip, [records, masks], {"strict": true}))) { {const $v3 = $.unpack($v2, 2, -1);record = $v3[0];mask = $v3[1];}
{every = $.b.max(1, $.neg($.fdiv($.neg($.b.len(record)), MOST_SAMPLES)));
part = $.b.slice(null, null, every);
{const $v4 = $.unpack($.tup($.gi($.ga(record, "input"), part), $.gi($.ga(record, "output"), part), ($.t(($.ga(record, "time") == null)) ? null : $.gi($.ga(record, "time"), part))), 3, -1);x = $v4[0];y = $v4[1];time = $v4[2];}
kept = $.gi(mask, part);
if (!$.t(kept.any())) {continue;}
demands = (() => { const $r = []; for (const $v5 of $.it(models)) { let model; model = $v5; $r.push(_demand(model, x, y, time, every)); } return $r; })();
for (const $v6 of $.it($.b.enumerate(models))) { {const $v7 = $.unpack($v6, 2, -1);j = $v7[0];plant = $v7[1];}
{if (!$.t($.gi(rivals, j))) {continue;}
applied = plant.simulate(x, time);
for (const $v8 of $.it($.b.enumerate(demands))) { {const $v9 = $.unpack($v8, 2, -1);i = $v9[0];demand = $v9[1];}
{if ($.t($.ne(i, j))) {moved = ($.t((demand == null)) ? $.ga(np, "nan") : np.var($.gi($.sub(plant.simulate(demand, time), applied), kept)));
$.cm($.gi(squares, i), "append", [$.b.float(moved)]);}} }} }} }
span = np.ptp(np.concatenate((() => { const $r = []; for (const $v10 of $.it(records)) { let record; record = $v10; $r.push($.ga(record, "output")); } return $r; })()));
return $.b.tuple((function* () { for (const $v11 of $.it(squares)) { let own; own = $v11; yield ($.t(own) ? $.b.float($.div($.mul(100.0, np.sqrt(np.mean(own))), span)) : $.b.float("nan")); } })()); }, {p: ["models", "rivals", "records", "masks"], ks: false});
_demand = $.def(function (model, x, y, time, every) { 
try {return np.asarray(np.clip(model.ahead(model.inverse().simulate(y, time), every), x.min(), x.max()));} catch ($e) { $e = $.caught($e); if ($.isinst($e, DehystError)) {  {return null;} } else throw $e; } }, {p: ["model", "x", "y", "time", "every"], ks: false});
with_table = $.def(function (fit, ...others) { let fits, models, options, curve, remembers, tracked;
fits = $.tup(fit, ...$.it(others));
{const $v14 = $.unpack($.tup((() => { const $r = []; for (const $v12 of $.it(fits)) { let each; each = $v12; $r.push($.ga(each, "model")); } return $r; })(), (() => { const $r = []; for (const $v13 of $.it(fits)) { let each; each = $v13; $r.push(_option_of(each, (each === fit))); } return $r; })()), 2, -1);models = $v14[0];options = $v14[1];}
if ($.t($.b.all((function* () { for (const $v15 of $.it(fits)) { let each; each = $v15; yield $.ne($.ga(each, "family"), STATIC); } })()))) {curve = $.or($.ga(fit, "static_test"), () => $.ga(fit, "static_train"));
$.cm(models, "append", [$.ga(fit, "static")]);
$.cm(options, "append", [Option(STATIC, "forward", $.ga(curve, "rmse_percent"), $.ga($.ga(fit, "curve_input"), "rms_percent"), null, true, false)]);}
if ($.t(($.ga($.ga(fit, "model"), "shear") == null))) {remembers = (() => { const $r = []; for (const $v16 of $.it($.k($.b.zip, [options, models], {"strict": true}))) { let row, model; {const $v17 = $.unpack($v16, 2, -1);row = $v17[0];model = $v17[1];} $r.push($.and($.ne($.ga(row, "family"), STATIC), () => !$.t($.ga(model, "needs")))); } return $r; })();
tracked = tracking_errors(models, remembers, $.ga(fit, "recordings"), ($.t($.ga(fit, "test")) ? $.ga(fit, "test_masks") : $.ga(fit, "train_masks")));
options = (() => { const $r = []; for (const $v18 of $.it($.k($.b.zip, [options, tracked], {"strict": true}))) { let row, error; {const $v19 = $.unpack($v18, 2, -1);row = $v19[0];error = $v19[1];} $r.push($.k(replace, [row], {"tracking_percent": ($.t(np.isnan(error)) ? null : error)})); } return $r; })();}
return $.k(replace, [fit], {"table": $.b.tuple(options)}); }, {p: ["fit"], va: true});
_option_of = $.def(function (fit, chosen) { let asked, exportable;
{const $v20 = $.unpack($.tup($.ga($.ga(fit, "input_error"), "rms_percent"), !$.t($.ga($.ga(fit, "model"), "no_export"))), 2, -1);asked = $v20[0];exportable = $v20[1];}
return Option($.ga(fit, "family"), $.ga(fit, "direction"), $.ga($.ga(fit, "output_error"), "rmse_percent"), asked, null, exportable, chosen); }, {p: ["fit", "chosen"], ks: false});
Object.assign($m, {"annotations": annotations, "Sequence": Sequence, "replace": replace, "Any": Any, "np": np, "Array": Array_, "Mask": Mask, "Recording": Recording, "DehystError": DehystError, "STATIC": STATIC, "Fit": Fit, "Option": Option, "MOST_SAMPLES": MOST_SAMPLES, "tracking_errors": tracking_errors, "_demand": _demand, "with_table": with_table, "_option_of": _option_of});
});
$.module("dehyst.io.cells", ($m) => {
let annotations, re, Sequence, suppress, dataclass, UTC, datetime, nan, np, Array_, Rows, Finding, list_rows, canonical, MISSING, _NUMBER, _COMMA_NUMBER, _THOUSANDS_POINT, _THOUSANDS_COMMA, _INFINITE, _DATE_TIME, _TIME_OF_DAY, _YEAR_FIRST, _YEAR_LAST, _POINTED_DATE, _CLOCK, FORMULA, _STAMPS, _DIGITS, _BRACKETED, _WITH_UNIT, _TWO_MARKS, _GROUPS, _OTHER, _NAMES, LARGE, number, comma_number, unescaped, is_data, is_date_time, parse_numbers, parse_date_times, date_order, _unevenness, _iso, _seconds, is_dressed, with_unit, undress_units, undress_negatives, text_refusal, Marks, marks_of, separator_of, _is_continued, thousands_finding, thousands_refusal;
re = $.imp("re");
Sequence = $.from("collections.abc", "Sequence");
suppress = $.from("contextlib", "suppress");
dataclass = $.from("dataclasses", "dataclass");
UTC = $.from("datetime", "UTC");datetime = $.from("datetime", "datetime");
nan = $.from("math", "nan");
np = $.imp("numpy");
Array_ = $.from("dehyst.arrays", "Array");Rows = $.from("dehyst.arrays", "Rows");
Finding = $.from("dehyst.findings", "Finding");
list_rows = $.from("dehyst.io.table", "list_rows");
canonical = $.from("dehyst.units", "canonical");
MISSING = $.bor($.b.frozenset($.cm("nan na n/a #n/a null none nil - -- ? missing -nan +nan nan(ind) -nan(ind) 1.#qnan -1.#ind 1.#ind #nan nat", "split", [])), $.b.set([""]));
_NUMBER = re.compile("[+-]?(?:\\d+\\.?\\d*|\\.\\d+)(?:[eEdD][+-]?\\d+)?", $.ga(re, "ASCII"));
_COMMA_NUMBER = re.compile("[+-]?(?:\\d+,\\d*|,\\d+)(?:[eEdD][+-]?\\d+)?", $.ga(re, "ASCII"));
_THOUSANDS_POINT = re.compile("[+-]?\\d{1,3}(?:\\.\\d{3})+,\\d*", $.ga(re, "ASCII"));
_THOUSANDS_COMMA = re.compile("[+-]?\\d{1,3}(?:,\\d{3})+\\.\\d*", $.ga(re, "ASCII"));
_INFINITE = $.b.frozenset(["inf", "+inf", "-inf", "infinity", "+infinity", "-infinity", "1.#inf", "-1.#inf"]);
_DATE_TIME = re.compile("\\d{4}-\\d\\d-\\d\\d([T ]\\d\\d:\\d\\d(:\\d\\d([.,]\\d+)?)?)?( ?(Z|UTC|[+-]\\d\\d:?\\d\\d))?", $.ga(re, "ASCII"));
_TIME_OF_DAY = "[T ] *(\\d{1,2}:\\d\\d(?::\\d\\d(?:[.,]\\d+)?)?) *([AP]M)?";
_YEAR_FIRST = re.compile(("" + "(\\d{4})[/.](\\d{1,2})[/.](\\d{1,2})" + $.f(_TIME_OF_DAY, "", -1)), $.bor($.ga(re, "ASCII"), $.ga(re, "IGNORECASE")));
_YEAR_LAST = re.compile(("" + "(\\d{1,2})([/.-])(\\d{1,2})\\2(\\d{4}|\\d\\d)" + $.f(_TIME_OF_DAY, "", -1)), $.bor($.ga(re, "ASCII"), $.ga(re, "IGNORECASE")));
_POINTED_DATE = re.compile("\\d{1,2}\\.\\d{1,2}\\.\\d{4}", $.ga(re, "ASCII"));
_CLOCK = re.compile("\\d{1,2}:\\d\\d:\\d\\d([.,]\\d+)?", $.ga(re, "ASCII"));
FORMULA = re.compile("'*[=+\\-@\uff1d\uff0b\uff0d\uff20]");
_STAMPS = $.tup(_DATE_TIME, _CLOCK, _YEAR_LAST, _YEAR_FIRST, _POINTED_DATE);
_DIGITS = "(?:\\d[\\d.,]*|[.,]\\d+)(?:[eE][+-]?\\d+)?";
_BRACKETED = re.compile(("" + "\\(\\s*(" + $.f(_DIGITS, "", -1) + ")\\s*\\)"), $.ga(re, "ASCII"));
_WITH_UNIT = re.compile(("" + "([+-]?" + $.f(_DIGITS, "", -1) + ")(?:\\s+([^\\W\\d_]\\S*(?: \\S+)?|\u00b0)|([^\\W\\d_]{2,}|\u00b0))"));
_TWO_MARKS = re.compile("[+-]?\\d{1,3}(?:(?:\\.\\d{3}){2,}|(?:,\\d{3}){2,})", $.ga(re, "ASCII"));
_GROUPS = $.dict((() => { const $r = []; for (const $v1 of $.it(".,")) { let mark; mark = $v1; $r.push([mark, re.compile(("" + "[+-]?[1-9]\\d{0,2}(?:" + $.f(re.escape(mark), "", -1) + "\\d{3})+"), $.ga(re, "ASCII"))]); } return $r; })());
_OTHER = $.dict([[".", ","], [",", "."]]);
_NAMES = $.dict([[".", "points"], [",", "commas"]]);
LARGE = 100.0;
number = $.def(function (cell) { let text, low;
text = $.cm(cell, "strip", []);
if ($.t(_NUMBER.fullmatch(text))) {return $.b.float($.cm($.cm(text, "replace", ["d", "e"]), "replace", ["D", "e"]));}
low = $.cm(text, "lower", []);
if ($.t($.in(low, MISSING))) {return nan;}
return ($.t($.in(low, _INFINITE)) ? nan : null); }, {p: ["cell"], ks: false});
comma_number = $.def(function (cell) { let text;
text = $.cm(cell, "strip", []);
if ($.t(_COMMA_NUMBER.fullmatch(text))) {return number($.cm(text, "replace", [",", "."]));}
if ($.t(_THOUSANDS_POINT.fullmatch(text))) {return number($.cm($.cm(text, "replace", [".", ""]), "replace", [",", "."]));}
if ($.t(_THOUSANDS_COMMA.fullmatch(text))) {return number($.cm(text, "replace", [",", ""]));}
return number(text); }, {p: ["cell"], ks: false});
unescaped = $.def(function (cell) { 
return (($.t($.cm(cell, "startswith", ["'"])) && $.t(FORMULA.match(cell))) ? $.gi(cell, $.slice(1, null, null)) : cell); }, {p: ["cell"], ks: false});
is_data = $.def(function (cell) { let value;
value = comma_number(cell);
return ($.t((value != null)) ? $.eq(value, value) : is_date_time(cell)); }, {p: ["cell"], ks: false});
is_date_time = $.def(function (cell) { let text;
text = $.cm(cell, "strip", []);
return $.b.any((function* () { for (const $v2 of $.it(_STAMPS)) { let pattern; pattern = $v2; yield pattern.fullmatch(text); } })()); }, {p: ["cell"], ks: false});
parse_numbers = $.def(function (cells, decimal_comma) { let joined, convert, values, bad;
joined = $.cm("", "join", [cells]);
if (($.t($.cm(joined, "isascii", [])) && $.t(!$.in("_", joined)) && !$.t(decimal_comma))) {{ const $v3 = suppress($.b.ValueError); $.enter($v3); try {return $.tup($.km(np, "array", [$.b.list($.b.map($.b.float, cells))], {"dtype": $.ga(np, "float64")}), 0);} catch ($e) { if (!$.exit($v3, $.caught($e))) throw $e; } }}
convert = ($.t(decimal_comma) ? comma_number : number);
values = (() => { const $r = []; for (const $v4 of $.it(cells)) { let cell; cell = $v4; $r.push(convert(cell)); } return $r; })();
bad = $.cm(values, "count", [null]);
return $.tup($.km(np, "array", [(() => { const $r = []; for (const $v5 of $.it(values)) { let value; value = $v5; $r.push(($.t((value == null)) ? nan : value)); } return $r; })()], {"dtype": $.ga(np, "float64")}), bad); }, {p: ["cells", "decimal_comma"], ks: false});
parse_date_times = $.def(function (cells, order = null) { 
order = $.or(order, () => $.gi(date_order(cells), 0));
return $.km(np, "array", [(() => { const $r = []; for (const $v6 of $.it(cells)) { let cell; cell = $v6; $r.push(_seconds(cell, order)); } return $r; })()], {"dtype": $.ga(np, "float64")}); }, {p: ["cells", "order"], ks: false});
date_order = $.def(function (cells) { let dates, first, second, usual, other, spans;
dates = $.b.set((() => { const $r = []; for (const $v7 of $.it($.b.map($.ga(_YEAR_LAST, "fullmatch"), $.b.map($.ga($.b.str, "strip"), cells)))) { let match; match = $v7; if ($.t(match)) { $r.push(match.group(1, 2, 3, 6)); } } return $r; })());
if ((!$.t(dates) || $.t($.b.any((function* () { for (const $v8 of $.it(dates)) { let _, mark; {const $v9 = $.unpack($v8, 4, -1);_ = $v9[0];mark = $v9[1];_ = $v9[2];_ = $v9[3];} yield $.eq(mark, "."); } })())))) {return $.tup("day", false);}
if ($.t($.b.any((function* () { for (const $v10 of $.it(dates)) { let _, half; {const $v11 = $.unpack($v10, 4, -1);_ = $v11[0];_ = $v11[1];_ = $v11[2];half = $v11[3];} yield half; } })()))) {return $.tup("month", false);}
{const $v14 = $.unpack((function* () { for (const $v13 of $.it($.tup(0, 2))) { let k; k = $v13; yield $.b.max((function* () { for (const $v12 of $.it(dates)) { let date; date = $v12; yield $.b.int($.gi(date, k)); } })()); } })(), 2, -1);first = $v14[0];second = $v14[1];}
if (($.t($.gt(first, 12)) || $.t($.gt(second, 12)))) {return $.tup(($.t($.gt(first, 12)) ? "day" : "month"), false);}
{const $v17 = $.unpack(($.t($.b.any((function* () { for (const $v15 of $.it(dates)) { let _, mark; {const $v16 = $.unpack($v15, 4, -1);_ = $v16[0];mark = $v16[1];_ = $v16[2];_ = $v16[3];} yield $.eq(mark, "/"); } })())) ? $.tup("month", "day") : $.tup("day", "month")), 2, -1);usual = $v17[0];other = $v17[1];}
if ($.t($.eq($.b.len($.b.set((() => { const $r = []; for (const $v18 of $.it(dates)) { let date; date = $v18; $r.push($.gi(date, $.slice(null, 3, null))); } return $r; })())), 1))) {return $.tup(usual, false);}
spans = (() => { const $r = []; for (const $v19 of $.it($.tup(usual, other))) { let order; order = $v19; $r.push(_unevenness(parse_date_times(cells, order))); } return $r; })();
return ($.t($.eq($.gi(spans, 0), $.gi(spans, 1))) ? $.tup(usual, true) : $.tup(($.t($.lt($.gi(spans, 0), $.gi(spans, 1))) ? usual : other), false)); }, {p: ["cells"], ks: false});
_unevenness = $.def(function (t) { let step;
step = np.diff($.gi(t, $.inv(np.isnan(t))));
return $.tup($.b.int(np.sum($.lt(step, 0))), $.b.float($.km(np, "max", [np.abs(step)], {"initial": 0.0}))); }, {p: ["t"], ks: false});
_iso = $.def(function (text, order) { let match, year, month, day, clock, half, one, _, two, hour, rest;
if ($.t((match = _YEAR_FIRST.fullmatch(text)))) {{const $v20 = $.unpack(match.groups(), 5, -1);year = $v20[0];month = $v20[1];day = $v20[2];clock = $v20[3];half = $v20[4];}} else {if ($.t((match = _YEAR_LAST.fullmatch(text)))) {{const $v21 = $.unpack(match.groups(), 6, -1);one = $v21[0];_ = $v21[1];two = $v21[2];year = $v21[3];clock = $v21[4];half = $v21[5];}
{const $v22 = $.unpack(($.t($.eq(order, "day")) ? $.tup(one, two) : $.tup(two, one)), 2, -1);day = $v22[0];month = $v22[1];}} else {if ($.t(_POINTED_DATE.fullmatch(text))) {{const $v23 = $.unpack($.cm(text, "split", ["."]), 3, -1);day = $v23[0];month = $v23[1];year = $v23[2];}
{const $v24 = $.unpack($.tup("00:00", null), 2, -1);clock = $v24[0];half = $v24[1];}} else {return text;}}}
{const $v25 = $.unpack($.cm(clock, "partition", [":"]), 3, -1);hour = $v25[0];_ = $v25[1];rest = $v25[2];}
if ($.t(half)) {hour = $.b.str($.add($.mod($.b.int(hour), 12), ($.t($.eq($.cm(half, "upper", []), "PM")) ? 12 : 0)));}
return ("" + $.f(($.t($.eq($.b.len(year), 4)) ? year : $.add("20", year)), "", -1) + "-" + $.f(month, ("" + "0>2"), -1) + "-" + $.f(day, ("" + "0>2"), -1) + "T" + $.f(hour, ("" + "0>2"), -1) + ":" + $.f(rest, "", -1)); }, {p: ["text", "order"], ks: false});
_seconds = $.def(function (cell, order) { let text, moment;
text = $.cm($.cm($.cm(_iso($.cm(cell, "strip", []), order), "replace", [",", "."]), "replace", ["UTC", "Z"]), "replace", [" Z", "Z"]);
if ($.t(_CLOCK.fullmatch(text))) {text = ("" + "1970-01-01T" + $.f($.cm(text, "zfill", [$.add($.b.len(text), $.eq($.cm(text, "index", [":"]), 1))]), "", -1));}
try {moment = datetime.fromisoformat(text);
if ($.t(($.ga(moment, "tzinfo") == null))) {moment = $.cm(moment, "replace", [], {"tzinfo": UTC});}
return moment.timestamp();} catch ($e) { $e = $.caught($e); if ($.isinst($e, $.tup($.b.ValueError, $.b.OverflowError))) {  {return nan;} } else throw $e; } }, {p: ["cell", "order"], ks: false});
is_dressed = $.def(function (cell) { let text;
text = $.cm(cell, "strip", []);
return $.or($.b.bool($.or(_BRACKETED.fullmatch(text), () => _TWO_MARKS.fullmatch(text))), () => (with_unit(text) != null)); }, {p: ["cell"], ks: false});
with_unit = $.def(function (cell) { let match, unit;
match = _WITH_UNIT.fullmatch(cell);
unit = ($.t(match) ? canonical($.or($.gi(match, 2), () => $.gi(match, 3))) : null);
return (($.t(match) && $.t(unit)) ? $.tup($.gi(match, 1), unit) : null); }, {p: ["cell"], ks: false});
undress_units = $.def(function (column, cells, findings) { let filled, units, unit, pair;
filled = (() => { const $r = []; for (const $v26 of $.it(cells)) { let cell; cell = $v26; if ($.t(!$.in($.cm(cell, "lower", []), MISSING))) { $r.push(with_unit(cell)); } } return $r; })();
units = $.b.set((() => { const $r = []; for (const $v27 of $.it(filled)) { let pair; pair = $v27; $r.push(($.t(pair) ? $.gi(pair, 1) : "")); } return $r; })());
if (($.t($.ne($.b.len(units), 1)) || $.t($.in("", units)))) {return null;}
unit = $.cm(units, "pop", []);
$.cm(findings, "append", [Finding("unit-in-cells", ("" + "every number in column '" + $.f(column, "", -1) + "' carries its unit, " + $.f(unit, "", -1) + "; it was taken from there. Nothing to do."))]);
return $.tup((() => { const $r = []; for (const $v28 of $.it(cells)) { let cell; cell = $v28; $r.push(($.t((pair = with_unit(cell))) ? $.gi(pair, 0) : cell)); } return $r; })(), unit); }, {p: ["column", "cells", "findings"], ks: false});
undress_negatives = $.def(function (column, cells, rows, findings) { let where, plain, whole, bare;
where = (() => { const $r = []; for (const $v29 of $.it($.b.enumerate(cells))) { let k, cell; {const $v30 = $.unpack($v29, 2, -1);k = $v30[0];cell = $v30[1];} if ($.t($.cm(cell, "startswith", ["("]))) { $r.push(k); } } return $r; })();
plain = (() => { const $r = []; for (const $v31 of $.it(cells)) { let cell; cell = $v31; if (!$.t($.cm(cell, "startswith", ["("]))) { $r.push(comma_number(cell)); } } return $r; })();
whole = $.b.all((function* () { for (const $v32 of $.it(where)) { let k; k = $v32; yield _BRACKETED.fullmatch($.gi(cells, k)); } })());
if ((!$.t(where) || !$.t(whole) || !$.t($.b.any((function* () { for (const $v33 of $.it(plain)) { let value; value = $v33; yield $.eq(value, value); } })())) || $.t($.b.any((function* () { for (const $v34 of $.it(plain)) { let v; v = $v34; yield $.or((v == null), () => $.lt(v, 0)); } })())))) {return $.b.list(cells);}
bare = (() => { const $r = []; for (const $v35 of $.it(cells)) { let cell; cell = $v35; $r.push(($.t($.cm(cell, "startswith", ["("])) ? ("" + "-" + $.f($.cm($.gi(cell, $.slice(1, (-1), null)), "strip", []), "", -1)) : cell)); } return $r; })();
$.cm(findings, "append", [Finding("bracketed-negatives", ("" + "numbers in brackets in column '" + $.f(column, "", -1) + "' were read as negative (" + $.f($.gi(cells, $.gi(where, 0)), "", -1) + " is " + $.f($.gi(bare, $.gi(where, 0)), "", -1) + "), as in accounting: " + $.f(list_rows($.gi(rows, where)), "", -1) + ". The column has no minus sign and no other text. If they mean something else, save the log without them."))]);
return bare; }, {p: ["column", "cells", "rows", "findings"], ks: false});
text_refusal = $.def(function (column, log, cells, rows) { let where, kinds, examples, filled;
where = (() => { const $r = []; for (const $v36 of $.it($.b.enumerate(cells))) { let k, cell; {const $v37 = $.unpack($v36, 2, -1);k = $v37[0];cell = $v37[1];} if ($.t((comma_number(cell) == null))) { $r.push(k); } } return $r; })();
kinds = $.dict((() => { const $r = []; for (const $v38 of $.it($.b.reversed(where))) { let k; k = $v38; $r.push([$.gi(cells, k), k]); } return $r; })());
examples = $.cm(" and ", "join", [(function* () { for (const $v39 of $.it($.gi($.b.sorted($.cm(kinds, "values", [])), $.slice(null, 2, null)))) { let k; k = $v39; yield ("" + $.f($.gi($.gi(cells, k), $.slice(null, 30, null)), "", 114) + " (" + $.f(list_rows($.gi(rows, [k])), "", -1) + ")"); } })()]);
filled = $.b.sum((function* () { for (const $v40 of $.it(cells)) { let cell; cell = $v40; yield $.b.bool(cell); } })());
return ("" + "column '" + $.f(column, "", -1) + "' of " + $.f(log, "", -1) + " holds text in " + $.f($.b.len(where), "", -1) + " of " + $.f(filled, "", -1) + " cells, such as " + $.f(examples, "", -1) + ". Without these rows much of the loop would be lost, so it is not read. Write them as plain numbers, or empty the cells in which nothing was measured."); }, {p: ["column", "log", "cells", "rows"], ks: false});
Marks = $.cls("Marks", [], "", [["groups", null], ["decimals", null], ["separators", null]], true, true, ($c) => { Marks = $c; $.meth($c, "without", $.def(function (cells, mark) { const self = this;let grouped;
grouped = $.b.set($.gi($.ga(self, "groups"), mark));
return (() => { const $r = []; for (const $v41 of $.it($.b.enumerate(cells))) { let position, cell; {const $v42 = $.unpack($v41, 2, -1);position = $v42[0];cell = $v42[1];} $r.push(($.t($.in(position, grouped)) ? $.cm(cell, "replace", [mark, ""]) : cell)); } return $r; })(); }, {p: ["cells", "mark"], ks: false}));});
marks_of = $.def(function (cells) { let groups, decimals, separators, position, cell, used, mark, last;
groups = $.dict([[".", []], [",", []]]);
decimals = $.b.set();
separators = $.b.set();
for (const $v43 of $.it($.b.enumerate(cells))) { {const $v44 = $.unpack($v43, 2, -1);position = $v44[0];cell = $v44[1];}
{used = (() => { const $r = []; for (const $v45 of $.it(".,")) { let mark; mark = $v45; if ($.t($.in(mark, cell))) { $r.push(mark); } } return $r; })();
if (!$.t(used)) {continue;}
mark = $.gi(used, 0);
if (($.t($.eq($.b.len(used), 1)) && $.t($.gi(_GROUPS, mark).fullmatch(cell)))) {$.cm($.gi(groups, mark), "append", [position]);
$.cm(separators, "update", [($.t($.gt($.cm(cell, "count", [mark]), 1)) ? used : [])]);} else {if ((($.t($.gt($.b.len(used), 1)) || $.t(!$.in(mark, decimals))) && $.t((comma_number(cell) != null)))) {last = $.k($.b.max, [used], {"key": $.ga(cell, "rindex")});
$.cm(decimals, "add", [last]);
$.cm(separators, "update", [$.sub($.b.set(used), $.b.set([last]))]);}}} }
return Marks(groups, $.b.frozenset(decimals), $.b.frozenset(separators)); }, {p: ["cells"], ks: false});
separator_of = $.def(function (cells, marks, decimals) { let mark, asked;
for (const $v46 of $.it(".,")) { mark = $v46;
{asked = $.or($.in($.gi(_OTHER, mark), decimals), () => $.in(mark, $.ga(marks, "separators")));
if ((!$.t($.gi($.ga(marks, "groups"), mark)) || !$.t(asked))) {continue;}
if ($.t($.in(mark, $.ga(marks, "decimals")))) {if (($.t($.ga(marks, "separators")) || $.t($.in($.gi(_OTHER, mark), $.ga(marks, "decimals"))))) {return $.tup(mark, false);}
continue;}
return $.tup(mark, $.or($.in(mark, $.ga(marks, "separators")), () => _is_continued(cells, $.gi($.ga(marks, "groups"), mark))));} }
return $.tup("", false); }, {p: ["cells", "marks", "decimals"], ks: false});
_is_continued = $.def(function (cells, groups) { let grouped, values, plain;
grouped = $.b.set(groups);
values = (() => { const $r = []; for (const $v47 of $.it($.b.enumerate(cells))) { let position, cell; {const $v48 = $.unpack($v47, 2, -1);position = $v48[0];cell = $v48[1];} if ($.t(!$.in(position, grouped))) { $r.push(comma_number(cell)); } } return $r; })();
plain = (() => { const $r = []; for (const $v49 of $.it(values)) { let value; value = $v49; if (($.t((value != null)) && $.t($.eq(value, value)))) { $r.push($.b.abs(value)); } } return $r; })();
if ((!$.t(plain) || $.t($.ge($.b.max(plain), 1000)))) {return false;}
return $.or($.ge($.b.max(plain), LARGE), () => $.b.any((function* () { for (const $v50 of $.it(groups)) { let position; position = $v50; yield $.cm($.gi(cells, position), "endswith", ["0"]); } })())); }, {p: ["cells", "groups"], ks: false});
thousands_finding = $.def(function (column, cells, marks, mark, rows) { let where, cell;
where = $.gi($.ga(marks, "groups"), mark);
cell = $.gi(cells, $.gi(where, 0));
return Finding("thousands-separator", ("" + $.f($.gi(_NAMES, mark), "", -1) + " in column '" + $.f(column, "", -1) + "' were read as separators of thousands (" + $.f(cell, "", -1) + " is " + $.f($.cm(cell, "replace", [mark, ""]), "", -1) + "): " + $.f(list_rows($.gi(rows, where)), "", -1) + ". The numbers without one lie below 1000, or some have two. If they are decimal signs, save the log with one decimal sign throughout.")); }, {p: ["column", "cells", "marks", "mark", "rows"], ks: false});
thousands_refusal = $.def(function (column, log, cells, marks, mark, rows) { let where, cell, other;
where = $.gi($.ga(marks, "groups"), mark);
{const $v51 = $.unpack($.tup($.gi(cells, $.gi(where, 0)), $.gi(_OTHER, mark)), 2, -1);cell = $v51[0];other = $v51[1];}
return ("" + "column '" + $.f(column, "", -1) + "' of " + $.f(log, "", -1) + " can be read in two ways: " + $.f(cell, "", -1) + " (" + $.f(list_rows($.gi(rows, where)), "", -1) + ") is " + $.f($.cm(cell, "replace", [mark, ""]), "", -1) + " if its " + $.f($.gi(_NAMES, mark), "", -1) + " separate thousands, and " + $.f($.cm(cell, "replace", [mark, "."]), "", -1) + " if they are decimal signs; elsewhere the log uses " + $.f($.gi(_NAMES, other), "", -1) + " for that. The readings differ by a factor of 1000, so none was chosen. Save the column without separators (" + $.f($.cm(cell, "replace", [mark, ""]), "", -1) + "), or with the decimal sign of the other numbers (" + $.f($.cm(cell, "replace", [mark, other]), "", -1) + ")."); }, {p: ["column", "log", "cells", "marks", "mark", "rows"], ks: false});
Object.assign($m, {"annotations": annotations, "re": re, "Sequence": Sequence, "suppress": suppress, "dataclass": dataclass, "UTC": UTC, "datetime": datetime, "nan": nan, "np": np, "Array": Array_, "Rows": Rows, "Finding": Finding, "list_rows": list_rows, "canonical": canonical, "MISSING": MISSING, "_NUMBER": _NUMBER, "_COMMA_NUMBER": _COMMA_NUMBER, "_THOUSANDS_POINT": _THOUSANDS_POINT, "_THOUSANDS_COMMA": _THOUSANDS_COMMA, "_INFINITE": _INFINITE, "_DATE_TIME": _DATE_TIME, "_TIME_OF_DAY": _TIME_OF_DAY, "_YEAR_FIRST": _YEAR_FIRST, "_YEAR_LAST": _YEAR_LAST, "_POINTED_DATE": _POINTED_DATE, "_CLOCK": _CLOCK, "FORMULA": FORMULA, "_STAMPS": _STAMPS, "_DIGITS": _DIGITS, "_BRACKETED": _BRACKETED, "_WITH_UNIT": _WITH_UNIT, "_TWO_MARKS": _TWO_MARKS, "_GROUPS": _GROUPS, "_OTHER": _OTHER, "_NAMES": _NAMES, "LARGE": LARGE, "number": number, "comma_number": comma_number, "unescaped": unescaped, "is_data": is_data, "is_date_time": is_date_time, "parse_numbers": parse_numbers, "parse_date_times": parse_date_times, "date_order": date_order, "_unevenness": _unevenness, "_iso": _iso, "_seconds": _seconds, "is_dressed": is_dressed, "with_unit": with_unit, "undress_units": undress_units, "undress_negatives": undress_negatives, "text_refusal": text_refusal, "Marks": Marks, "marks_of": marks_of, "separator_of": separator_of, "_is_continued": _is_continued, "thousands_finding": thousands_finding, "thousands_refusal": thousands_refusal});
});
$.module("dehyst.io.checks", ($m) => {
let annotations, Sequence, np, Array_, summarise_loops, ExcitationError, RecordingError, Finding, Samples, Table, dimension, parse_unit, words, Signals, HELD_SHARE, STUCK_SHARE, COARSE_LEVELS, FIRST_VALUES, LOOP_SHARE, COMMAND_WORDS, BETWEEN_WORDS, DRIVES, MOTIONS, is_constant, _still, hold_length, stuck_share, _rests, levels, check_pair, _held, _between, _stuck, _coarse, _few_loops, _swapped, _a;
Sequence = $.from("collections.abc", "Sequence");
np = $.imp("numpy");
Array_ = $.from("dehyst.arrays", "Array");
summarise_loops = $.from("dehyst.data.loops", "summarise_loops");
ExcitationError = $.from("dehyst.errors", "ExcitationError");RecordingError = $.from("dehyst.errors", "RecordingError");
Finding = $.from("dehyst.findings", "Finding");
Samples = $.from("dehyst.io.clean", "Samples");
Table = $.from("dehyst.io.table", "Table");
dimension = $.from("dehyst.units", "dimension");parse_unit = $.from("dehyst.units", "parse_unit");words = $.from("dehyst.units", "words");
Signals = $.gi(Sequence, $.gi($.b.tuple, $.tup($.b.str, $.b.str, Array_)));
HELD_SHARE = 0.6;
STUCK_SHARE = 0.005;
COARSE_LEVELS = 24;
FIRST_VALUES = 4096;
LOOP_SHARE = 0.15;
COMMAND_WORDS = $.b.frozenset(words("cmd command commanded ref reference setpoint desired target soll des demand"));
BETWEEN_WORDS = $.b.frozenset(words("interp interpolated resampled filtered smooth smoothed"));
DRIVES = $.tup("pressure", "voltage", "current");
MOTIONS = $.tup("angle", "length");
is_constant = $.def(function (values) { let low, high;
{const $v1 = $.unpack(($.t($.ga(values, "size")) ? $.tup($.b.float(values.min()), $.b.float(values.max())) : $.tup(0.0, 0.0)), 2, -1);low = $v1[0];high = $v1[1];}
return $.le($.sub(high, low), $.mul(1e-12, $.b.max($.neg(low), high))); }, {p: ["values"], ks: false});
_still = $.def(function (values) { let span;
span = $.b.float(np.ptp(values));
if ($.t($.eq(span, 0.0))) {return ("" + "is " + $.f($.gi(values, 0), ("" + ".6g"), -1) + " in all " + $.f($.ga(values, "size"), "", -1) + " rows");}
return ("" + "moves by " + $.f(span, ("" + ".3g"), -1) + " only on an offset of " + $.f($.gi(values, 0), ("" + ".6g"), -1) + ", which is rounding, in " + $.f($.ga(values, "size"), "", -1) + " rows"); }, {p: ["values"], ks: false});
hold_length = $.def(function (values) { let step, count, moves, runs, typical, smallest;
step = np.diff(values);
count = np.count_nonzero(step);
if (($.t($.lt($.ga(step, "size"), 20)) || $.t($.lt(count, 8)) || $.t($.gt(count, $.mul($.sub(1, HELD_SHARE), $.ga(step, "size")))))) {return 1.0;}
moves = np.abs($.gi(step, $.ne(step, 0)));
runs = np.diff(np.flatnonzero($.ne(step, 0)));
typical = $.b.float(np.median(runs));
smallest = $.b.float(np.min(moves));
if (($.t($.lt(typical, 3)) || $.t($.lt($.b.float(np.median(moves)), $.mul(3, smallest))) || $.t($.lt($.ga(np.unique(np.round($.div(moves, smallest))), "size"), 6)))) {return 1.0;}
return typical; }, {p: ["values"], ks: false});
stuck_share = $.def(function (x, y) { let extremes, worst, centred, sign, span, level, rests, outward, total, first, last, push;
extremes = (() => { const $r = []; for (const $v2 of $.it($.tup($.b.float(y.max()), $.b.float(y.min())))) { let level; level = $v2; $r.push($.tup(level, _rests(y, level))); } return $r; })();
worst = $.tup(0.0, $.gi($.gi(extremes, 0), 0));
if (!$.t($.b.any((function* () { for (const $v3 of $.it(extremes)) { let _, rests; {const $v4 = $.unpack($v3, 2, -1);_ = $v4[0];rests = $v4[1];} yield rests; } })()))) {return worst;}
centred = $.sub(x, x.mean());
sign = $.or(np.sign($.b.float(np.dot(centred, $.sub(y, y.mean())))), () => 1.0);
span = $.b.float(np.ptp(x));
for (const $v5 of $.it($.k($.b.zip, [extremes, $.tup(sign, $.neg(sign))], {"strict": true}))) { {const $v6 = $.unpack($v5, 2, -1);{const $v7 = $.unpack($v6[0], 2, -1);level = $v7[0];rests = $v7[1];}outward = $v6[1];}
{total = 0;
for (const $v8 of $.it(rests)) { {const $v9 = $.unpack($v8, 2, -1);first = $v9[0];last = $v9[1];}
{push = $.mul(outward, $.sub($.gi(x, $.slice(first, last, null)), $.gi(x, first)));
if ($.t($.gt($.b.float(push.max()), $.mul(0.05, span)))) {total = $.iadd(total, $.sub(last, first));}} }
if ($.t($.gt($.div(total, $.ga(y, "size")), $.gi(worst, 0)))) {worst = $.tup($.div(total, $.ga(y, "size")), level);}} }
return worst; }, {p: ["x", "y"], ks: false});
_rests = $.def(function (y, level) { let at, cuts, firsts, lasts, long;
at = np.flatnonzero($.eq(y, level));
cuts = $.add(np.flatnonzero($.gt(np.diff(at), 1)), 1);
{const $v10 = $.unpack($.tup($.gi(at, np.concatenate($.tup([0], cuts))), $.add($.gi(at, np.concatenate($.tup($.sub(cuts, 1), [$.sub($.ga(at, "size"), 1)]))), 1)), 2, -1);firsts = $v10[0];lasts = $v10[1];}
long = $.ge($.sub(lasts, firsts), 3);
return $.b.list($.k($.b.zip, [$.gi(firsts, long).tolist(), $.gi(lasts, long).tolist()], {"strict": true})); }, {p: ["y", "level"], ks: false});
levels = $.def(function (values) { let some;
some = $.b.int($.ga(np.unique($.gi(values, $.slice(null, FIRST_VALUES, null))), "size"));
return ($.t($.gt(some, COARSE_LEVELS)) ? some : $.b.int($.ga(np.unique(values), "size"))); }, {p: ["values"], ks: false});
check_pair = $.def(function (table, columns, samples) { let x_name, y_name, x, y, signals;
{const $v11 = $.unpack(columns, 2, -1);x_name = $v11[0];y_name = $v11[1];}
{const $v12 = $.unpack($.ga(samples, "values"), 2, -1);x = $v12[0];y = $v12[1];}
if ($.t(is_constant(x))) {throw $.exc($.k(ExcitationError, [("" + "input '" + $.f(x_name, "", -1) + "' of " + $.f($.ga(table, "name"), "", -1) + " " + $.f(_still(x), "", -1) + ": nothing can be learned about how the output depends on it. Name another input column, run or window.")], {"column": x_name}));}
if ($.t(is_constant(y))) {throw $.exc($.k(RecordingError, [("" + "output '" + $.f(y_name, "", -1) + "' of " + $.f($.ga(table, "name"), "", -1) + " " + $.f(_still(y), "", -1) + " although the input moves: the sensor is not connected, or it is the wrong column. Name another output column, run or window.")], {"column": y_name}));}
signals = $.tup($.tup("input", x_name, x), $.tup("output", y_name, y));
return [...$.it(_held(table, signals, $.ga(samples, "time"))), ...$.it(_stuck(table, y_name, x, y)), ...$.it(_coarse(table, signals)), ...$.it(_few_loops(table, x_name, x)), ...$.it(_swapped(table, x_name, y_name))]; }, {p: ["table", "columns", "samples"], ks: false});
_held = $.def(function (table, signals, time) { let found, role, name, values, hold, rate, step, better, cure;
found = [];
for (const $v13 of $.it(signals)) { {const $v14 = $.unpack($v13, 3, -1);role = $v14[0];name = $v14[1];values = $v14[2];}
{hold = hold_length(values);
if ($.t($.eq(hold, 1.0))) {continue;}
rate = "";
if ($.t((time != null))) {step = $.b.float(np.median(np.diff(time)));
rate = ($.t($.gt(step, 0)) ? ("" + ", about " + $.f($.div(1, $.mul(hold, step)), ("" + ".2g"), -1) + " Hz") : "");}
better = _between(table, name);
cure = ($.t(better) ? ("" + "Column '" + $.f(better, "", -1) + "' looks like the same signal between its updates: use that one.") : "Log it faster, or interpolate between its updates.");
$.cm(found, "append", [Finding(("" + "held-" + $.f(role, "", -1)), ("" + $.f(role, "", -1) + " '" + $.f(name, "", -1) + "' of " + $.f($.ga(table, "name"), "", -1) + " changes only every " + $.f(hold, ("" + ".0f"), -1) + " samples" + $.f(rate, "", -1) + " and is held in between. The steps look like hysteresis and the delay like a lag. " + $.f(cure, "", -1)))]);} }
return found; }, {p: ["table", "signals", "time"], ks: false});
_between = $.def(function (table, name) { let mine, other, theirs;
mine = $.b.set(words($.gi(parse_unit(name), 0)));
for (const $v15 of $.it($.ga(table, "columns"))) { other = $v15;
{theirs = $.b.set(words($.gi(parse_unit(other), 0)));
if (($.t($.ne(other, name)) && $.t($.band(theirs, BETWEEN_WORDS)) && $.t($.le(mine, theirs)) && $.t($.eq($.cm($.ga(table, "units"), "get", [other]), $.gi($.ga(table, "units"), name))))) {return other;}} }
return null; }, {p: ["table", "name"], ks: false});
_stuck = $.def(function (table, y_name, x, y) { let share, level, where;
{const $v16 = $.unpack(stuck_share(x, y), 2, -1);share = $v16[0];level = $v16[1];}
if (($.t($.le(share, STUCK_SHARE)) || $.t($.le(levels(y), COARSE_LEVELS)))) {return [];}
where = $.cm(("" + $.f(level, ("" + ".6g"), -1) + " " + $.f($.cm($.ga(table, "units"), "get", [y_name, ""]), "", -1)), "rstrip", []);
return [Finding("saturated-output", ("" + "output '" + $.f(y_name, "", -1) + "' of " + $.f($.ga(table, "name"), "", -1) + " sits exactly at " + $.f(where, "", -1) + " in " + $.f($.mul(100, share), ("" + ".2g"), -1) + " % of the samples while the input still pushes on: sensor or converter is at the end of its range, or the actuator at a stop. What happens beyond cannot be learned or inverted. Reduce the input's range, or cut it away."))]; }, {p: ["table", "y_name", "x", "y"], ks: false});
_coarse = $.def(function (table, signals) { let found, role, name, values, count;
found = [];
for (const $v17 of $.it(signals)) { {const $v18 = $.unpack($v17, 3, -1);role = $v18[0];name = $v18[1];values = $v18[2];}
{count = levels(values);
if (($.t($.le(count, COARSE_LEVELS)) && $.t($.ge($.ga(values, "size"), $.mul(8, count))))) {$.cm(found, "append", [Finding(("" + "quantised-" + $.f(role, "", -1)), ("" + $.f(role, "", -1) + " '" + $.f(name, "", -1) + "' of " + $.f($.ga(table, "name"), "", -1) + " takes only " + $.f(count, "", -1) + " different values in " + $.f($.ga(values, "size"), "", -1) + " rows; no model can be better than " + $.f($.div(50, $.b.max(1, $.sub(count, 1))), ("" + ".2g"), -1) + " % of the range. Log it with more digits."))]);}} }
return found; }, {p: ["table", "signals"], ks: false});
_few_loops = $.def(function (table, x_name, x) { let smallest, turns, what, cure;
smallest = $.mul(LOOP_SHARE, $.b.float(np.ptp(x)));
turns = $.sub($.b.int(np.sum($.gt($.ga(summarise_loops(x, smallest), "swings"), smallest))), 1);
if ($.t($.ge(turns, 2))) {return [];}
what = ($.t($.le(turns, 0)) ? "never turns: it moves one way only" : "turns only once: there is a single loop");
cure = ($.t($.le(turns, 0)) ? "Hysteresis cannot be seen without a way back: log at least one full loop, better two." : "A half of the log holds one branch only: fit all of it (--train-fraction 1), and log a second loop for a test.");
return [Finding("few-loops", ("" + "input '" + $.f(x_name, "", -1) + "' of " + $.f($.ga(table, "name"), "", -1) + " " + $.f(what, "", -1) + ". " + $.f(cure, "", -1)))]; }, {p: ["table", "x_name", "x"], ks: false});
_swapped = $.def(function (table, x_name, y_name) { let x_dimension, y_dimension, x_command, y_command, by_unit, by_name, reason;
{const $v20 = $.unpack((function* () { for (const $v19 of $.it($.tup(x_name, y_name))) { let name; name = $v19; yield dimension($.cm($.ga(table, "units"), "get", [name, ""])); } })(), 2, -1);x_dimension = $v20[0];y_dimension = $v20[1];}
{const $v22 = $.unpack((function* () { for (const $v21 of $.it($.tup(x_name, y_name))) { let name; name = $v21; yield $.b.bool($.band(COMMAND_WORDS, $.b.set(words(name)))); } })(), 2, -1);x_command = $v22[0];y_command = $v22[1];}
by_unit = $.and($.in(y_dimension, DRIVES), () => $.in(x_dimension, MOTIONS));
by_name = $.and(y_command, () => $.and(!$.t(x_command), () => !$.in(x_dimension, DRIVES)));
if (!($.t(by_unit) || $.t(by_name))) {return [];}
reason = ("" + $.f(_a(y_dimension), "", -1) + " drives, " + $.f(_a(x_dimension), "", -1) + " follows ('" + $.f(y_name, "", -1) + "' is the output here)");
return [Finding("swapped-columns", ("" + "input and output of " + $.f($.ga(table, "name"), "", -1) + " look swapped: " + $.f(($.t(by_unit) ? reason : ("" + "the output " + $.f(y_name, "", -1) + " is named like a command")), "", -1) + ". If so, type: --input " + $.f(y_name, "", -1) + " --output " + $.f(x_name, "", -1)))]; }, {p: ["table", "x_name", "y_name"], ks: false});
_a = $.def(function (noun) { 
return ($.t($.in($.gi(noun, $.slice(null, 1, null)), "aeiou")) ? ("" + "an " + $.f(noun, "", -1)) : ("" + "a " + $.f(noun, "", -1))); }, {p: ["noun"], ks: false});
Object.assign($m, {"annotations": annotations, "Sequence": Sequence, "np": np, "Array": Array_, "summarise_loops": summarise_loops, "ExcitationError": ExcitationError, "RecordingError": RecordingError, "Finding": Finding, "Samples": Samples, "Table": Table, "dimension": dimension, "parse_unit": parse_unit, "words": words, "Signals": Signals, "HELD_SHARE": HELD_SHARE, "STUCK_SHARE": STUCK_SHARE, "COARSE_LEVELS": COARSE_LEVELS, "FIRST_VALUES": FIRST_VALUES, "LOOP_SHARE": LOOP_SHARE, "COMMAND_WORDS": COMMAND_WORDS, "BETWEEN_WORDS": BETWEEN_WORDS, "DRIVES": DRIVES, "MOTIONS": MOTIONS, "is_constant": is_constant, "_still": _still, "hold_length": hold_length, "stuck_share": stuck_share, "_rests": _rests, "levels": levels, "check_pair": check_pair, "_held": _held, "_between": _between, "_stuck": _stuck, "_coarse": _coarse, "_few_loops": _few_loops, "_swapped": _swapped, "_a": _a});
});
$.module("dehyst.io.clean", ($m) => {
let annotations, math, dataclass, field, replace, np, npt, Array_, Mask, Rows, GAP_SAMPLES, gap_limit, memory_lost, turning_points, FEWEST, find_outliers, RecordingError, Finding, finite, list_rows, canonical, HELD_MOST, TURN, WRAPPED, SMOOTH, Samples, Context, drop_unmeasured, hold_unmeasured, hold_last, drop_outliers, _named, _unwrap, wraps, _within, find_gaps;
math = $.imp("math");
dataclass = $.from("dataclasses", "dataclass");field = $.from("dataclasses", "field");replace = $.from("dataclasses", "replace");
np = $.imp("numpy");
npt = $.imp("numpy.typing");
Array_ = $.from("dehyst.arrays", "Array");Mask = $.from("dehyst.arrays", "Mask");Rows = $.from("dehyst.arrays", "Rows");
GAP_SAMPLES = $.from("dehyst.data.loops", "GAP_SAMPLES");gap_limit = $.from("dehyst.data.loops", "gap_limit");memory_lost = $.from("dehyst.data.loops", "memory_lost");turning_points = $.from("dehyst.data.loops", "turning_points");
FEWEST = $.from("dehyst.data.outliers", "FEWEST");find_outliers = $.from("dehyst.data.outliers", "find_outliers");
RecordingError = $.from("dehyst.errors", "RecordingError");
Finding = $.from("dehyst.findings", "Finding");
finite = $.from("dehyst.io.table", "finite");list_rows = $.from("dehyst.io.table", "list_rows");
canonical = $.from("dehyst.units", "canonical");
HELD_MOST = 0.5;
TURN = $.dict([["deg", 360.0], ["rad", $.mul(2, $.ga(math, "pi"))]]);
WRAPPED = 0.8;
SMOOTH = 3.0;
Samples = $.cls("Samples", [], "", [["time", null], ["values", null], ["rows", null], ["breaks", () => $.tup()]], true, false, ($c) => { Samples = $c; $.meth($c, "take", $.def(function (index) { const self = this;let time;
time = ($.t(($.ga(self, "time") == null)) ? null : $.gi($.ga(self, "time"), index));
return $.k(replace, [self], {"time": time, "values": $.b.tuple((function* () { for (const $v1 of $.it($.ga(self, "values"))) { let v; v = $v1; yield $.gi(v, index); } })()), "rows": $.gi($.ga(self, "rows"), index)}); }, {p: ["index"], ks: false}));});
Context = $.cls("Context", [], "", [["log", null], ["columns", null], ["word", () => "row"], ["units", () => $.tup()], ["findings", () => $.b.list()]], true, true, ($c) => { Context = $c; $.meth($c, "say", $.def(function (code, message) { const self = this;
$.cm($.ga(self, "findings"), "append", [Finding(code, message)]); }, {p: ["code", "message"], ks: false}));});
drop_unmeasured = $.def(function (samples, about) { let parts, good, bad;
parts = ($.t(($.ga(samples, "time") == null)) ? $.ga(samples, "values") : $.tup(...$.it($.ga(samples, "values")), $.ga(samples, "time")));
good = $.ga(np, "logical_and").reduce((() => { const $r = []; for (const $v2 of $.it(parts)) { let part; part = $v2; $r.push(finite(part)); } return $r; })());
if (($.t(good.all()) && $.t($.ga(good, "size")))) {return samples;}
if (!$.t(good.any())) {throw $.exc($.k(RecordingError, [("" + $.f($.ga(about, "log"), "", -1) + " has no " + $.f($.ga(about, "word"), "", -1) + " in which " + $.f($.cm(" and ", "join", [$.ga(about, "columns")]), "", -1) + " are both numbers, out of " + $.f($.ga(good, "size"), "", -1) + ". Check the columns with: dehyst inspect LOG")], {"columns": $.ga(about, "columns"), "rows": $.ga(good, "size")}));}
bad = $.gi($.ga(samples, "rows"), $.inv(good));
about.say("non-finite", ("" + $.f($.ga(bad, "size"), "", -1) + " of " + $.f($.ga(good, "size"), "", -1) + " rows of " + $.f($.ga(about, "log"), "", -1) + " were left out because a cell of " + $.f($.cm(", ", "join", [$.ga(about, "columns")]), "", -1) + " is empty, infinite or not a number: " + $.f(list_rows(bad, $.ga(about, "word")), "", -1) + ". Nothing to do if the sensor is known to drop out; otherwise check its cable."));
return samples.take(good); }, {p: ["samples", "about"], ks: false});
hold_unmeasured = $.def(function (samples, about) { let bad, missing, held, rows, many;
bad = (() => { const $r = []; for (const $v3 of $.it($.ga(samples, "values"))) { let v; v = $v3; $r.push($.inv(finite(v))); } return $r; })();
missing = $.ga(np, "logical_or").reduce(bad);
if ((!$.t(missing.any()) || $.t($.gt(missing.mean(), HELD_MOST)))) {return drop_unmeasured(samples, about);}
held = $.b.tuple((function* () { for (const $v4 of $.it($.k($.b.zip, [$.ga(samples, "values"), bad], {"strict": true}))) { let v, mask; {const $v5 = $.unpack($v4, 2, -1);v = $v5[0];mask = $v5[1];} yield hold_last(v, mask); } })());
rows = $.gi($.ga(samples, "rows"), missing);
many = $.gt($.ga(rows, "size"), 1);
about.say("held-reference", ("" + $.f($.ga(rows, "size"), "", -1) + " of " + $.f($.ga(missing, "size"), "", -1) + " rows of " + $.f($.ga(about, "log"), "", -1) + " " + $.f(($.t(many) ? "have" : "has"), "", -1) + " no number in " + $.f($.cm(", ", "join", [$.ga(about, "columns")]), "", -1) + " (" + $.f(list_rows(rows, $.ga(about, "word")), "", -1) + "); the last value was held there, so that every row still has its sample. Fill these cells, if the motion should go on in them."));
return drop_unmeasured($.k(replace, [samples], {"values": held}), about); }, {p: ["samples", "about"], ks: false});
hold_last = $.def(function (values, bad) { let good, last;
good = np.flatnonzero($.inv(bad));
last = $.sub($.km(np, "searchsorted", [good, np.arange($.ga(values, "size"))], {"side": "right"}), 1);
return np.asarray($.gi(values, $.gi(good, np.maximum(last, 0)))); }, {p: ["values", "bad"], ks: false});
drop_outliers = $.def(function (samples, about, hold = false) { let wrapped, masks, bad, what, done;
{const $v6 = $.unpack(_unwrap(samples, about, $.b.set()), 2, -1);samples = $v6[0];wrapped = $v6[1];}
masks = (() => { const $r = []; for (const $v7 of $.it($.ga(samples, "values"))) { let v; v = $v7; $r.push(find_outliers(v)); } return $r; })();
bad = $.ga(np, "logical_or").reduce(masks);
if (!$.t(bad.any())) {return samples;}
what = $.cm("; ", "join", [(function* () { for (const $v8 of $.it($.k($.b.zip, [$.ga(samples, "values"), masks, $.ga(about, "columns")], {"strict": true}))) { let v, mask, name; {const $v9 = $.unpack($v8, 3, -1);v = $v9[0];mask = $v9[1];name = $v9[2];} if ($.t(mask.any())) { yield _named(samples, v, mask, name, about); } } })()]);
done = ($.t(hold) ? "the value before each was held" : "their rows were left out");
about.say("outlier", ("" + $.f($.b.int(bad.sum()), "", -1) + " of " + $.f($.ga(bad, "size"), "", -1) + " rows of " + $.f($.ga(about, "log"), "", -1) + " hold a value far from all others (" + $.f(what, "", -1) + "); " + $.f(done, "", -1) + ". A single one would spoil the fit, because the model remembers extremes. Check the sensor and its wiring; if the values are real, log faster so that they are more than a spike."));
if ($.t(hold)) {samples = $.k(replace, [samples], {"values": $.b.tuple((function* () { for (const $v10 of $.it($.k($.b.zip, [$.ga(samples, "values"), masks], {"strict": true}))) { let v, mask; {const $v11 = $.unpack($v10, 2, -1);v = $v11[0];mask = $v11[1];} yield hold_last(v, mask); } })())});} else {samples = samples.take($.inv(bad));}
return $.gi(_unwrap(samples, about, wrapped), 0); }, {p: ["samples", "about", "hold"], ks: false});
_named = $.def(function (samples, v, mask, name, about) { let rows, shown;
rows = $.gi($.ga(samples, "rows"), mask);
shown = $.cm(", ", "join", [(function* () { for (const $v12 of $.it($.b.dict.fromkeys($.gi($.gi(v, mask), $.slice(null, 4, null)).tolist()))) { let value; value = $v12; yield ("" + $.f(value, ("" + ".6g"), -1)); } })()]);
return ("" + "'" + $.f(name, "", -1) + "' is " + $.f(shown, "", -1) + " in " + $.f(list_rows(rows, $.ga(about, "word")), "", -1)); }, {p: ["samples", "v", "mask", "name", "about"], ks: false});
_unwrap = $.def(function (samples, about, done) { let values, k, v, unit, turn, jumps, count;
values = $.b.list($.ga(samples, "values"));
for (const $v13 of $.it($.b.enumerate($.k($.b.zip, [$.ga(samples, "values"), $.ga(about, "units")], {"strict": false})))) { {const $v14 = $.unpack($v13, 2, -1);k = $v14[0];{const $v15 = $.unpack($v14[1], 2, -1);v = $v15[0];unit = $v15[1];}}
{turn = $.cm(TURN, "get", [$.or(canonical(unit), () => "")]);
jumps = (($.t((turn == null)) || $.t($.in(k, done))) ? $.km(np, "zeros", [0], {"dtype": $.ga(np, "int64")}) : wraps(v, turn));
if (($.t((turn == null)) || $.t($.eq($.ga(jumps, "size"), 0)))) {continue;}
done = $.bor(done, $.b.set([k]));
count = np.zeros($.ga(v, "size"));
$.si(count, jumps, $.neg(np.sign($.sub($.gi(v, jumps), $.gi(v, $.sub(jumps, 1))))));
$.si(values, k, $.add(v, $.mul(turn, np.cumsum(count))));
about.say("angle-wrap", ("" + "'" + $.f($.gi($.ga(about, "columns"), k), "", -1) + "' of " + $.f($.ga(about, "log"), "", -1) + " jumps by a full turn " + $.f($.ga(jumps, "size"), "", -1) + " " + $.f(($.t($.gt($.ga(jumps, "size"), 1)) ? "times" : "time"), "", -1) + ", at " + $.f(list_rows($.gi($.ga(samples, "rows"), jumps), $.ga(about, "word")), "", -1) + ": the angle wraps around. It was unwrapped and now runs from " + $.f($.gi(values, k).min(), ("" + ".6g"), -1) + " to " + $.f($.gi(values, k).max(), ("" + ".6g"), -1) + " " + $.f(unit, "", -1) + ". Nothing to do; the model knows the unwrapped angle."));} }
return $.tup($.k(replace, [samples], {"values": $.b.tuple(values)}), done); }, {p: ["samples", "about", "done"], ks: false});
wraps = $.def(function (v, turn) { let nothing, low, high, slack, circle, step, jump, usual, left;
nothing = $.km(np, "zeros", [0], {"dtype": $.ga(np, "int64")});
if (($.t($.lt($.ga(v, "size"), FEWEST)) || $.t($.gt($.b.float(np.ptp(v)), $.mul(1.001, turn))))) {return nothing;}
{const $v16 = $.unpack($.tup($.b.float(v.min()), $.b.float(v.max())), 2, -1);low = $v16[0];high = $v16[1];}
slack = $.mul(0.001, turn);
circle = $.or($.and($.ge(low, $.neg(slack)), () => $.le(high, $.add(turn, slack))), () => $.and($.ge(low, $.sub($.div($.neg(turn), 2), slack)), () => $.le(high, $.add($.div(turn, 2), slack))));
step = np.diff(v);
jump = $.gt(np.abs(step), $.mul(WRAPPED, turn));
if ((!$.t(circle) || !$.t(jump.any()) || $.t(jump.all()))) {return nothing;}
usual = $.b.float(np.max(np.abs($.gi(step, $.inv(jump)))));
left = np.abs($.sub(np.abs($.gi(step, jump)), turn));
return ($.t($.gt($.b.float(np.max(left)), $.mul(SMOOTH, usual))) ? nothing : $.add(np.flatnonzero(jump), 1)); }, {p: ["v", "turn"], ks: false});
_within = $.def(function (broken, gaps) { 
return ($.t($.gt(gaps, 1)) ? ("" + "In " + $.f(($.t($.eq(broken, gaps)) ? "all" : broken), "", -1) + " of them") : "In it"); }, {p: ["broken", "gaps"], ks: false});
find_gaps = $.def(function (samples, about) { let t, step, limit, found, x, moved, measured, broken, told, unit, longest, what, cure;
t = ($.t(($.ga(samples, "time") != null)) ? $.ga(samples, "time") : $.ga(samples, "rows").astype($.ga(np, "float64")));
if ($.t($.lt($.ga(t, "size"), 3))) {return samples;}
step = np.diff(t);
if ($.t((($t0, $t1) => $.t($.lt(0.0, ($t0 = $.b.float(step.max())))) && $.t($.le($t0, $.mul(GAP_SAMPLES, $.b.float(step.min())))))())) {return samples;}
limit = gap_limit(step);
found = $.add(np.flatnonzero($.gt(step, limit)), 1);
found = np.setdiff1d(found, $.km(np, "array", [$.ga(samples, "breaks")], {"dtype": $.ga(np, "int64")}));
if ($.t($.eq($.ga(found, "size"), 0))) {return samples;}
x = $.gi($.ga(samples, "values"), 0);
moved = np.abs($.sub($.gi(x, found), $.gi(x, $.sub(found, 1))));
measured = $.b.float(np.sum(np.clip(step, 0.0, limit)));
broken = $.gi(found, memory_lost($.gi(step, $.sub(found, 1)), moved, $.b.float(np.ptp(x)), measured, $.sub($.ga(turning_points(x), "size"), 1)));
told = $.le($.gi(step, $.sub(found, 1)), $.mul($.add($.gi(np.abs(np.diff($.ga(samples, "rows"))), $.sub(found, 1)), 0.5), $.b.float(np.median(step))));
if (($.t($.eq($.ga(broken, "size"), 0)) && $.t(told.all()))) {return samples;}
unit = ($.t(($.ga(samples, "time") != null)) ? "s" : "rows");
longest = $.b.int($.gi(found, np.argmax($.gi(step, $.sub(found, 1)))));
what = ("" + $.f($.ga(about, "log"), "", -1) + " has " + $.f($.ga(found, "size"), "", -1) + " gap" + $.f(($.t($.gt($.ga(found, "size"), 1)) ? "s" : ""), "", -1) + ", before " + $.f(list_rows($.gi($.ga(samples, "rows"), found), $.ga(about, "word")), "", -1) + "; the longest, " + $.f($.gi(step, $.sub(longest, 1)), ("" + ".4g"), -1) + " " + $.f(unit, "", -1) + " from " + $.f($.gi(t, $.sub(longest, 1)), ("" + ".6g"), -1) + " to " + $.f($.gi(t, longest), ("" + ".6g"), -1) + " " + $.f(unit, "", -1) + ", against " + $.f($.b.float(np.median(step)), ("" + ".3g"), -1) + " " + $.f(unit, "", -1) + " usually.");
cure = ($.t($.ga(broken, "size")) ? ("" + " " + $.f(_within($.ga(broken, "size"), $.ga(found, "size")), "", -1) + " the input may have turned unseen, so the memory of the actuator is taken as unknown after it. Keep one side of it, with --from or --to, if that is enough.") : " The input hardly moved across them, so the recording goes on. Nothing to do.");
about.say("gap", $.add(what, cure));
return $.k(replace, [samples], {"breaks": $.b.tuple($.b.sorted($.b.set([...$.it($.ga(samples, "breaks")), ...$.it((function* () { for (const $v17 of $.it(broken)) { let k; k = $v17; yield $.b.int(k); } })())])))}); }, {p: ["samples", "about"], ks: false});
Object.assign($m, {"annotations": annotations, "math": math, "dataclass": dataclass, "field": field, "replace": replace, "np": np, "npt": npt, "Array": Array_, "Mask": Mask, "Rows": Rows, "GAP_SAMPLES": GAP_SAMPLES, "gap_limit": gap_limit, "memory_lost": memory_lost, "turning_points": turning_points, "FEWEST": FEWEST, "find_outliers": find_outliers, "RecordingError": RecordingError, "Finding": Finding, "finite": finite, "list_rows": list_rows, "canonical": canonical, "HELD_MOST": HELD_MOST, "TURN": TURN, "WRAPPED": WRAPPED, "SMOOTH": SMOOTH, "Samples": Samples, "Context": Context, "drop_unmeasured": drop_unmeasured, "hold_unmeasured": hold_unmeasured, "hold_last": hold_last, "drop_outliers": drop_outliers, "_named": _named, "_unwrap": _unwrap, "wraps": wraps, "_within": _within, "find_gaps": find_gaps});
});
$.module("dehyst.io.clocks", ($m) => {
let annotations, replace, WeakKeyDictionary, np, Array_, ColumnError, TimeError, UnitError, Finding, find_column, Table, finite, list_names, measured, DIMENSION, TABLE, canonical, parse_unit, words, TIME_WORDS, PLAIN_WORDS, NAMELESS, FORWARD_SHARE, EPOCH, _FOUND, is_clock, _runs_forward, _is_even, clock_names, _find_clocks, _leads_matrix, _moves, seconds, counting, in_seconds, choose_clock, with_time_unit, refuse_clock, same_clock, unit_finding, two_columns;
replace = $.from("dataclasses", "replace");
WeakKeyDictionary = $.from("weakref", "WeakKeyDictionary");
np = $.imp("numpy");
Array_ = $.from("dehyst.arrays", "Array");
ColumnError = $.from("dehyst.errors", "ColumnError");TimeError = $.from("dehyst.errors", "TimeError");UnitError = $.from("dehyst.errors", "UnitError");
Finding = $.from("dehyst.findings", "Finding");
find_column = $.from("dehyst.io.columns", "find_column");
Table = $.from("dehyst.io.table", "Table");finite = $.from("dehyst.io.table", "finite");list_names = $.from("dehyst.io.table", "list_names");measured = $.from("dehyst.io.table", "measured");
DIMENSION = $.from("dehyst.units", "DIMENSION");TABLE = $.from("dehyst.units", "TABLE");canonical = $.from("dehyst.units", "canonical");parse_unit = $.from("dehyst.units", "parse_unit");words = $.from("dehyst.units", "words");
TIME_WORDS = $.b.frozenset(words("t time timestamp timestamps stamp zeit temps tiempo tempo elapsed clock datetime date sec secs seconds msec usec nsec ms us ns epoch zeitstempel uhrzeit datum"));
PLAIN_WORDS = $.b.frozenset(words("time timestamp timestamps zeit zeitstempel elapsed datetime"));
NAMELESS = $.tup("column_1", "X_Value");
FORWARD_SHARE = 0.9;
EPOCH = $.tup(978000000.0, 4100000000.0);
_FOUND = WeakKeyDictionary();
is_clock = $.def(function (table, name) { let bare, unit, called, values;
if ($.t($.in(name, $.ga(table, "stamps")))) {return _moves(table, name);}
{const $v1 = $.unpack(parse_unit(name), 2, -1);bare = $v1[0];unit = $v1[1];}
unit = $.or($.cm($.ga(table, "units"), "get", [name]), () => unit);
called = $.or($.b.bool($.band(TIME_WORDS, $.b.set(words(bare)))), () => $.eq($.cm(DIMENSION, "get", [unit]), "time"));
values = $.gi($.ga(table, "columns"), name);
return $.and(called, () => _runs_forward(values)); }, {p: ["table", "name"], ks: false});
_runs_forward = $.def(function (values) { let good, step;
good = measured(values);
if ($.t($.lt($.ga(good, "size"), 2))) {return false;}
step = np.diff(good);
return $.b.bool($.and($.ge($.div(np.count_nonzero($.ge(step, 0)), $.ga(step, "size")), FORWARD_SHARE), () => np.any($.gt(step, 0)))); }, {p: ["values"], ks: false});
_is_even = $.def(function (values) { let good, step, middle;
good = measured(values);
if ($.t($.lt($.ga(good, "size"), 8))) {return false;}
step = np.diff(good);
middle = $.b.float(np.median(step));
return $.and($.gt(middle, 0), () => $.b.bool($.ge(np.mean($.le(np.abs($.sub(step, middle)), $.mul(0.5, middle))), FORWARD_SHARE))); }, {p: ["values"], ks: false});
clock_names = $.def(function (table) { 
if ($.t(!$.in(table, _FOUND))) {$.si(_FOUND, table, _find_clocks(table));}
return $.b.list($.gi(_FOUND, table)); }, {p: ["table"], ks: false});
_find_clocks = $.def(function (table) { let names;
names = (() => { const $r = []; for (const $v2 of $.it($.ga(table, "order"))) { let name; name = $v2; if ($.t($.in(name, $.ga(table, "columns")))) { $r.push(name); } } return $r; })();
return $.or((() => { const $r = []; for (const $v6 of $.it(names)) { let name; name = $v6; if ($.t(is_clock(table, name))) { $r.push(name); } } return $r; })(), () => $.or((() => { const $r = []; for (const $v5 of $.it(names)) { let name; name = $v5; if (($.t($.band(PLAIN_WORDS, $.b.set(words($.gi(parse_unit(name), 0))))) && $.t(_moves(table, name)))) { $r.push(name); } } return $r; })(), () => $.or((() => { const $r = []; for (const $v4 of $.it($.gi(names, $.slice(null, 1, null)))) { let name; name = $v4; if (($.t($.in(name, NAMELESS)) && $.t(_is_even($.gi($.ga(table, "columns"), name))))) { $r.push(name); } } return $r; })(), () => (() => { const $r = []; for (const $v3 of $.it(names)) { let name; name = $v3; if (($.t(_leads_matrix(table, name)) && $.t(_is_even($.gi($.ga(table, "columns"), name))))) { $r.push(name); } } return $r; })()))); }, {p: ["table"], ks: false});
_leads_matrix = $.def(function (table, name) { let stem, _, number, second;
{const $v7 = $.unpack($.cm(name, "rpartition", ["_"]), 3, -1);stem = $v7[0];_ = $v7[1];number = $v7[2];}
second = $.cm($.ga(table, "columns"), "get", [("" + $.f(stem, "", -1) + "_2")]);
return $.and($.eq($.ga(table, "row_word"), "sample"), () => $.and($.eq(number, "1"), () => $.and((second != null), () => $.eq($.ga(second, "size"), $.ga($.gi($.ga(table, "columns"), name), "size"))))); }, {p: ["table", "name"], ks: false});
_moves = $.def(function (table, name) { let good;
good = measured($.gi($.ga(table, "columns"), name));
return $.and($.gt($.ga(good, "size"), 1), () => $.lt($.b.float(good.min()), $.b.float(good.max()))); }, {p: ["table", "name"], ks: false});
seconds = $.def(function (table, name) { let values, good, scale, is_epoch, first;
values = $.gi($.ga(table, "columns"), name);
good = measured(values);
if ($.t($.eq($.ga(good, "size"), 0))) {return $.tup(np.full($.ga(values, "size"), $.ga(np, "nan")), 0.0);}
{const $v8 = $.unpack(counting(table, name), 2, -1);scale = $v8[0];is_epoch = $v8[1];}
first = ($.t(is_epoch) ? $.b.float($.gi(good, 0)) : 0.0);
return $.tup(in_seconds(values, scale, first), $.mul(first, scale)); }, {p: ["table", "name"], ks: false});
counting = $.def(function (table, name) { let good, scale, middle, fits;
good = measured($.gi($.ga(table, "columns"), name));
scale = $.cm($.gi(TABLE, "time"), "get", [$.cm($.ga(table, "units"), "get", [name, ""]), 0.0]);
if (($.t($.eq($.ga(good, "size"), 0)) || ($.t(!$.in(name, $.ga(table, "stamps"))) && $.t($.lt($.mul($.b.float(good.max()), $.b.max(scale, 1.0)), $.gi(EPOCH, 0)))))) {return $.tup($.or(scale, () => 1.0), false);}
middle = $.b.float(np.median(good));
if (!$.t(scale)) {fits = (() => { const $r = []; for (const $v9 of $.it($.tup(1.0, 0.001, 1e-06, 1e-09))) { let s; s = $v9; if ($.t((($t0, $t1) => $.t($.le($.gi(EPOCH, 0), ($t0 = $.mul(middle, s)))) && $.t($.lt($t0, $.gi(EPOCH, 1))))())) { $r.push(s); } } return $r; })();
scale = ($.t(fits) ? $.gi(fits, 0) : 1.0);}
return $.tup(scale, $.or($.in(name, $.ga(table, "stamps")), () => (($t0, $t1) => $.t($.le($.gi(EPOCH, 0), ($t0 = $.mul(middle, scale)))) && $.t($.lt($t0, $.gi(EPOCH, 1))))())); }, {p: ["table", "name"], ks: false});
in_seconds = $.def(function (values, scale, first) { let good, stamps;
good = finite(values);
stamps = $.sub(($.t(good.all()) ? values : np.where(good, values, $.ga(np, "nan"))), first);
return np.asarray(($.t($.lt(scale, 1)) ? $.div(stamps, $.b.round($.div(1, scale))) : $.mul(stamps, scale))); }, {p: ["values", "scale", "first"], ks: false});
choose_clock = $.def(function (table, column, wanted) { let size, name, candidates, mine, shared, place, left, first;
size = $.ga($.gi($.ga(table, "columns"), column), "size");
if ($.t((wanted != null))) {name = find_column(table, wanted, "time");
if ($.t($.ne($.ga($.gi($.ga(table, "columns"), name), "size"), size))) {throw $.exc($.k(TimeError, [("" + "time column '" + $.f(name, "", -1) + "' of " + $.f($.ga(table, "name"), "", -1) + " has " + $.f($.ga($.gi($.ga(table, "columns"), name), "size"), "", -1) + " samples, but '" + $.f(column, "", -1) + "' has " + $.f(size, "", -1) + ": they are not on one clock. Name the time column of '" + $.f(column, "", -1) + "', or leave --time out.")], {"time": name, "column": column}));}
return name;}
if ($.t($.in(column, $.ga(table, "clocks")))) {return $.gi($.ga(table, "clocks"), column);}
candidates = (() => { const $r = []; for (const $v10 of $.it(clock_names(table))) { let name; name = $v10; if (($.t($.eq($.ga($.gi($.ga(table, "columns"), name), "size"), size)) && $.t($.ne(name, column)))) { $r.push(name); } } return $r; })();
if ($.t($.le($.b.len(candidates), 1))) {return ($.t(candidates) ? $.gi(candidates, 0) : null);}
mine = $.b.set(words($.gi(parse_unit(column), 0)));
shared = (() => { const $r = []; for (const $v11 of $.it(candidates)) { let name; name = $v11; $r.push($.b.len($.band(mine, $.sub($.b.set(words($.gi(parse_unit(name), 0))), TIME_WORDS)))); } return $r; })();
if (($.t($.gt($.b.max(shared), 0)) && $.t($.eq($.cm(shared, "count", [$.b.max(shared)]), 1)))) {return $.gi(candidates, $.cm(shared, "index", [$.b.max(shared)]));}
place = $.cm($.ga(table, "order"), "index", [column]);
left = (() => { const $r = []; for (const $v12 of $.it(candidates)) { let name; name = $v12; if ($.t($.lt($.cm($.ga(table, "order"), "index", [name]), place))) { $r.push(name); } } return $r; })();
if ($.t(left)) {return $.gi(left, (-1));}
first = $.gi(candidates, 0);
if ($.t($.b.all((function* () { for (const $v13 of $.it($.gi(candidates, $.slice(1, null, null)))) { let other; other = $v13; yield same_clock(table, first, other); } })()))) {return first;}
throw $.exc($.k(TimeError, [("" + $.f($.ga(table, "name"), "", -1) + " has " + $.f($.b.len(candidates), "", -1) + " time columns that contradict each other: " + $.f(list_names(candidates), "", -1) + ". Nothing tells which one belongs to '" + $.f(column, "", -1) + "'. Name it: --time " + $.f(first, "", -1))], {"columns": $.b.tuple(candidates)})); }, {p: ["table", "column", "wanted"], ks: false});
with_time_unit = $.def(function (table, unit, time) { let known, clocks, nameless;
if ($.t((unit == null))) {return table;}
known = canonical(unit);
if (($.t((known == null)) || $.t($.ne($.gi(DIMENSION, known), "time")))) {throw $.exc($.k(UnitError, [("" + "'" + $.f(unit, "", -1) + "' is no unit of time. Known are " + $.f($.cm(", ", "join", [$.gi(TABLE, "time")]), "", -1) + ": --time-unit ms")], {"unit": unit}));}
clocks = ($.t((time != null)) ? [find_column(table, time, "time")] : clock_names(table));
clocks = (() => { const $r = []; for (const $v14 of $.it(clocks)) { let name; name = $v14; if ($.t(!$.in(name, $.ga(table, "stamps")))) { $r.push(name); } } return $r; })();
nameless = (() => { const $r = []; for (const $v15 of $.it(clocks)) { let name; name = $v15; if (!$.t($.cm($.ga(table, "units"), "get", [name]))) { $r.push(name); } } return $r; })();
if (!$.t(clocks)) {throw $.exc($.k(TimeError, [("" + $.f($.ga(table, "name"), "", -1) + " has no time column whose unit could be " + $.f(known, "", -1) + ": it has none, or it holds dates. Name the column with --time, or leave --time-unit out.")], {"unit": unit}));}
return $.k(replace, [table], {"units": $.dict([...$.pairs($.ga(table, "units")), ...$.pairs($.b.dict.fromkeys($.or(nameless, () => clocks), known))])}); }, {p: ["table", "unit", "time"], ks: false});
refuse_clock = $.def(function (table, name, role) { let others;
if (!$.t(is_clock(table, name))) {return null;}
others = (() => { const $r = []; for (const $v16 of $.it($.ga(table, "columns"))) { let column; column = $v16; if (!$.t(is_clock(table, column))) { $r.push(column); } } return $r; })();
throw $.exc($.k(ColumnError, [("" + $.f(role, "", -1) + " column '" + $.f(name, "", -1) + "' of " + $.f($.ga(table, "name"), "", -1) + " is its time column: a clock neither drives nor follows. Name a signal: " + $.f($.or(list_names(others), () => "the log holds none"), "", -1) + ". If it is a signal, rename it so that it is not called like time.")], {"column": name, "columns": $.b.tuple(others)})); }, {p: ["table", "name", "role"], ks: false});
same_clock = $.def(function (table, a, b) { let ta, zero_a, tb, zero_b, both, step, typical, offset, unrelated, apart;
if ($.t($.eq(a, b))) {return true;}
{const $v17 = $.unpack($.tup(seconds(table, a), seconds(table, b)), 2, -1);{const $v18 = $.unpack($v17[0], 2, -1);ta = $v18[0];zero_a = $v18[1];}{const $v19 = $.unpack($v17[1], 2, -1);tb = $v19[0];zero_b = $v19[1];}}
if ($.t($.ne($.ga(ta, "size"), $.ga(tb, "size")))) {return false;}
both = $.band(np.isfinite(ta), np.isfinite(tb));
if (($.t($.lt(both.sum(), $.mul(0.9, $.b.max(np.isfinite(ta).sum(), np.isfinite(tb).sum())))) || $.t($.lt(both.sum(), 2)))) {return false;}
{const $v20 = $.unpack($.tup($.gi(ta, both), $.gi(tb, both)), 2, -1);ta = $v20[0];tb = $v20[1];}
step = np.abs(np.diff(ta));
typical = ($.t(np.any($.gt(step, 0))) ? $.b.float(np.median($.gi(step, $.gt(step, 0)))) : 0.0);
offset = $.sub($.add($.gi(tb, 0), zero_b), $.add($.gi(ta, 0), zero_a));
unrelated = $.gt($.b.abs(offset), $.mul(0.5, $.b.abs($.b.float($.sub($.gi(ta, (-1)), $.gi(ta, 0))))));
apart = $.add($.sub($.sub(tb, $.gi(tb, 0)), $.sub(ta, $.gi(ta, 0))), ($.t(unrelated) ? 0.0 : offset));
return $.b.bool($.le(np.max(np.abs(apart)), $.mul(0.1, typical))); }, {p: ["table", "a", "b"], ks: false});
unit_finding = $.def(function (table, name, stamps) { let step;
if (($.t($.cm($.ga(table, "units"), "get", [name])) || $.t($.in(name, $.ga(table, "stamps"))))) {return [];}
step = np.diff($.gi(stamps, np.isfinite(stamps)));
step = $.gi(step, $.gt(step, 0));
if (($.t($.eq($.ga(step, "size"), 0)) || $.t($.lt($.b.float(np.median(step)), 1.0)) || $.t($.in(name, $.cm($.ga(table, "clocks"), "values", []))))) {return [];}
return [Finding("time-unit", ("" + "time column '" + $.f(name, "", -1) + "' of " + $.f($.ga(table, "name"), "", -1) + " names no unit and was read as seconds, one sample every " + $.f($.b.float(np.median(step)), ("" + ".3g"), -1) + " s. If these are milliseconds, type --time-unit ms (in Python time_unit='ms'), or call the column " + $.f(name, "", -1) + "_ms; windows and rates depend on it."))]; }, {p: ["table", "name", "stamps"], ks: false});
two_columns = $.def(function (table, input, output) { let x_name, y_name;
x_name = find_column(table, input, "input");
y_name = find_column(table, output, "output");
if ($.t($.eq(x_name, y_name))) {throw $.exc($.k(ColumnError, [("" + "input and output are both column '" + $.f(x_name, "", -1) + "' of " + $.f($.ga(table, "name"), "", -1) + "; a loop needs two. Its columns are: " + $.f(list_names($.ga(table, "columns")), "", -1) + ".")], {"column": x_name}));}
refuse_clock(table, x_name, "input");
refuse_clock(table, y_name, "output");
return $.tup(x_name, y_name); }, {p: ["table", "input", "output"], ks: false});
Object.assign($m, {"annotations": annotations, "replace": replace, "WeakKeyDictionary": WeakKeyDictionary, "np": np, "Array": Array_, "ColumnError": ColumnError, "TimeError": TimeError, "UnitError": UnitError, "Finding": Finding, "find_column": find_column, "Table": Table, "finite": finite, "list_names": list_names, "measured": measured, "DIMENSION": DIMENSION, "TABLE": TABLE, "canonical": canonical, "parse_unit": parse_unit, "words": words, "TIME_WORDS": TIME_WORDS, "PLAIN_WORDS": PLAIN_WORDS, "NAMELESS": NAMELESS, "FORWARD_SHARE": FORWARD_SHARE, "EPOCH": EPOCH, "_FOUND": _FOUND, "is_clock": is_clock, "_runs_forward": _runs_forward, "_is_even": _is_even, "clock_names": clock_names, "_find_clocks": _find_clocks, "_leads_matrix": _leads_matrix, "_moves": _moves, "seconds": seconds, "counting": counting, "in_seconds": in_seconds, "choose_clock": choose_clock, "with_time_unit": with_time_unit, "refuse_clock": refuse_clock, "same_clock": same_clock, "unit_finding": unit_finding, "two_columns": two_columns});
});
$.module("dehyst.io.columns", ($m) => {
let annotations, difflib, Mapping, Any, np, npt, Array_, ColumnError, RunError, FRAME, Table, finite, list_names, parse_unit, words, RUN_WORDS, MAX_NUMBERED_RUNS, find_column, _match, _available, run_column, _is_whole, _in_blocks, _block_starts, run_labels, numbered_labels, count_runs, select_run, provenance;
difflib = $.imp("difflib");
Mapping = $.from("collections.abc", "Mapping");
Any = $.from("typing", "Any");
np = $.imp("numpy");
npt = $.imp("numpy.typing");
Array_ = $.from("dehyst.arrays", "Array");
ColumnError = $.from("dehyst.errors", "ColumnError");RunError = $.from("dehyst.errors", "RunError");
FRAME = $.from("dehyst.io.table", "FRAME");Table = $.from("dehyst.io.table", "Table");finite = $.from("dehyst.io.table", "finite");list_names = $.from("dehyst.io.table", "list_names");
parse_unit = $.from("dehyst.units", "parse_unit");words = $.from("dehyst.units", "words");
RUN_WORDS = $.b.frozenset(words("run runs trial experiment exp test episode session series recording measurement messung versuch lauf"));
MAX_NUMBERED_RUNS = 1000;
find_column = $.def(function (table, wanted, role) { let found, example, names, close, hint;
wanted = $.b.str(wanted);
found = _match(table, wanted);
if ($.t($.eq($.b.len(found), 1))) {if ($.t($.in($.gi(found, 0), $.ga(table, "labels")))) {example = $.cm(", ", "join", [$.b.dict.fromkeys($.gi($.gi($.gi($.ga(table, "labels"), $.gi(found, 0)), $.slice(null, 200, null)).tolist(), $.slice(null, 3, null)))]);
throw $.exc($.k(ColumnError, [("" + $.f(role, "", -1) + " column '" + $.f($.gi(found, 0), "", -1) + "' of " + $.f($.ga(table, "name"), "", -1) + " holds text (" + $.f(example, "", -1) + "), not numbers. " + $.f(_available(table), "", -1))], {"column": $.gi(found, 0), "columns": $.b.tuple($.ga(table, "columns"))}));}
if ($.t($.in($.gi(found, 0), $.ga(table, "columns")))) {return $.gi(found, 0);}}
if ($.t($.gt($.b.len(found), 1))) {throw $.exc($.k(ColumnError, [("" + $.f(role, "", -1) + " column '" + $.f(wanted, "", -1) + "' of " + $.f($.ga(table, "name"), "", -1) + " may be any of " + $.f(list_names(found), "", -1) + ". Type one of these names.")], {"column": wanted, "columns": $.b.tuple(found)}));}
names = $.b.list($.ga(table, "columns"));
close = $.km(difflib, "get_close_matches", [$.cm(wanted, "lower", []), (() => { const $r = []; for (const $v1 of $.it(names)) { let name; name = $v1; $r.push($.cm(name, "lower", [])); } return $r; })()], {"n": 1, "cutoff": 0.5});
hint = $.b.next((function* () { for (const $v2 of $.it(names)) { let name; name = $v2; if (($.t(close) && $.t($.eq($.cm(name, "lower", []), $.gi(close, 0))))) { yield ("" + "Did you mean '" + $.f(name, "", -1) + "'? "); } } })(), "");
throw $.exc($.k(ColumnError, [("" + $.f($.ga(table, "name"), "", -1) + " has no " + $.f(role, "", -1) + " column '" + $.f(wanted, "", -1) + "'. " + $.f(hint, "", -1) + $.f(_available(table), "", -1))], {"column": wanted, "columns": $.b.tuple(names)})); }, {p: ["table", "wanted", "role"], ks: false});
_match = $.def(function (table, wanted) { let low, spelled, found, index;
if ($.t($.in(wanted, $.ga(table, "order")))) {return [wanted];}
low = $.cm($.cm(wanted, "strip", []), "lower", []);
for (const $v3 of $.it($.tup($.def((name) => {  return $.cm(name, "lower", []); }, {p: ["name"], ks: false}), $.def((name) => {  return $.cm($.gi(parse_unit(name), 0), "lower", []); }, {p: ["name"], ks: false})))) { spelled = $v3;
{found = (() => { const $r = []; for (const $v4 of $.it($.ga(table, "order"))) { let name; name = $v4; if ($.t($.eq(spelled(name), low))) { $r.push(name); } } return $r; })();
if ($.t(found)) {return found;}} }
if (($.t($.cm(wanted, "startswith", ["#"])) && $.t($.cm($.gi(wanted, $.slice(1, null, null)), "isascii", [])) && $.t($.cm($.gi(wanted, $.slice(1, null, null)), "isdigit", [])) && $.t($.lt($.b.len(wanted), 8)))) {index = $.b.int($.gi(wanted, $.slice(1, null, null)));
return ($.t((($t0, $t1) => $.t($.le(1, index)) && $.t($.le(index, $.b.len($.ga(table, "order")))))()) ? [$.gi($.ga(table, "order"), $.sub(index, 1))] : []);}
return []; }, {p: ["table", "wanted"], ks: false});
_available = $.def(function (table) { let look;
look = ($.t($.eq($.ga(table, "name"), FRAME)) ? "dehyst.inspect_log(df)" : "dehyst inspect LOG");
return ("" + "Its columns of numbers are: " + $.f(list_names($.ga(table, "columns")), "", -1) + ". To see what they hold: " + $.f(look, "", -1)); }, {p: ["table"], ks: false});
run_column = $.def(function (table) { let texts, named, name, values;
texts = (() => { const $r = []; for (const $v5 of $.it($.cm($.ga(table, "labels"), "items", []))) { let name, labels; {const $v6 = $.unpack($v5, 2, -1);name = $v6[0];labels = $v6[1];} if ($.t($.eq($.ga(labels, "size"), $.ga($.ga(table, "rows"), "size")))) { $r.push(name); } } return $r; })();
named = (() => { const $r = []; for (const $v7 of $.it(texts)) { let name; name = $v7; if ($.t($.band(RUN_WORDS, $.b.set(words(name))))) { $r.push(name); } } return $r; })();
if ($.t(named)) {return $.gi(named, 0);}
for (const $v8 of $.it($.cm($.ga(table, "columns"), "items", []))) { {const $v9 = $.unpack($v8, 2, -1);name = $v9[0];values = $v9[1];}
{if (($.t($.band(RUN_WORDS, $.b.set(words(name)))) && $.t($.eq($.ga(values, "size"), $.ga($.ga(table, "rows"), "size"))) && $.t(_is_whole(values)))) {return name;}} }
return $.b.next((function* () { for (const $v10 of $.it(texts)) { let name; name = $v10; if ($.t(_in_blocks($.gi($.ga(table, "labels"), name)))) { yield name; } } })(), null); }, {p: ["table"], ks: false});
_is_whole = $.def(function (values) { let good;
good = $.gi(values, finite(values));
return $.b.bool($.and($.ga(good, "size"), () => $.and(np.all($.eq(good, np.round(good))), () => $.le($.ga(np.unique(good), "size"), MAX_NUMBERED_RUNS)))); }, {p: ["values"], ks: false});
_in_blocks = $.def(function (labels) { let starts;
starts = _block_starts(labels);
return $.and($.eq($.ga(starts, "size"), $.ga(np.unique($.gi(labels, starts)), "size")), () => $.le($.ga(starts, "size"), $.b.max(1, $.fdiv($.ga(labels, "size"), 4)))); }, {p: ["labels"], ks: false});
_block_starts = $.def(function (labels) { 
return $.gi(np.concatenate($.tup([0], $.add(np.flatnonzero($.ne($.gi(labels, $.slice(1, null, null)), $.gi(labels, $.slice(null, (-1), null)))), 1))).astype($.ga(np, "int64")), $.slice(null, $.ga(labels, "size"), null)); }, {p: ["labels"], ks: false});
run_labels = $.def(function (table) { let name;
name = run_column(table);
if ($.t((name == null))) {return null;}
if ($.t($.in(name, $.ga(table, "labels")))) {return $.gi($.ga(table, "labels"), name);}
return numbered_labels($.gi($.ga(table, "columns"), name)); }, {p: ["table"], ks: false});
numbered_labels = $.def(function (values) { let good, labels;
good = finite(values);
labels = $.km(np, "full", [$.ga(values, "size"), ""], {"dtype": "U24"});
$.si(labels, good, ($.t(good.any()) ? $.ga(np, "char").mod("%d", $.gi(values, good).astype($.ga(np, "int64"))) : ""));
return labels; }, {p: ["values"], ks: false});
count_runs = $.def(function (table) { let labels, starts, lengths, runs, name, length;
labels = run_labels(table);
if ($.t((labels == null))) {return $.dict([]);}
starts = _block_starts(labels);
lengths = np.diff(np.concatenate($.tup(starts, [$.ga(labels, "size")])));
runs = $.dict([]);
for (const $v11 of $.it($.k($.b.zip, [$.gi(labels, starts).tolist(), lengths.tolist()], {"strict": true}))) { {const $v12 = $.unpack($v11, 2, -1);name = $v12[0];length = $v12[1];}
{if ($.t(name)) {$.si(runs, name, $.add($.cm(runs, "get", [name, 0]), length));}} }
return runs; }, {p: ["table"], ks: false});
select_run = $.def(function (table, run) { let everything, runs, listed, chosen, low, close, hint, labels;
everything = $.km(np, "ones", [$.ga($.ga(table, "rows"), "size")], {"dtype": $.b.bool});
runs = count_runs(table);
listed = $.cm(", ", "join", [(function* () { for (const $v13 of $.it($.gi($.b.list($.cm(runs, "items", [])), $.slice(null, 40, null)))) { let name, rows; {const $v14 = $.unpack($v13, 2, -1);name = $v14[0];rows = $v14[1];} yield ("" + $.f(name, "", -1) + " (" + $.f(rows, "", -1) + " rows)"); } })()]);
if (!$.t(runs)) {if ($.t((run == null))) {return $.tup(null, everything);}
throw $.exc($.k(RunError, [("" + $.f($.ga(table, "name"), "", -1) + " does not tell runs apart, so there is no run '" + $.f(run, "", -1) + "': it has no text column and none called run, trial or experiment. Leave the run out, or cut a window with --from and --to.")], {"run": run}));}
if (($.t((run == null)) && $.t($.gt($.b.len(runs), 1)))) {throw $.exc($.k(RunError, [("" + $.f($.ga(table, "name"), "", -1) + " holds " + $.f($.b.len(runs), "", -1) + " runs and none was named: " + $.f(listed, "", -1) + ". What the actuator remembers does not carry over from one to the next, so name one: --run " + $.f($.b.next($.b.iter(runs)), "", -1))], {"runs": runs}));}
chosen = ($.t((run == null)) ? $.b.next($.b.iter(runs)) : $.b.str(run));
if ($.t(!$.in(chosen, runs))) {low = $.dict((() => { const $r = []; for (const $v15 of $.it(runs)) { let name; name = $v15; $r.push([$.cm(name, "lower", []), name]); } return $r; })());
close = $.km(difflib, "get_close_matches", [$.cm(chosen, "lower", []), $.b.list(low)], {"n": 1, "cutoff": 0.5});
hint = ($.t(close) ? ("" + "Did you mean '" + $.f($.gi(low, $.gi(close, 0)), "", -1) + "'? ") : "");
throw $.exc($.k(RunError, [("" + $.f($.ga(table, "name"), "", -1) + " has no run '" + $.f(chosen, "", -1) + "'. " + $.f(hint, "", -1) + "It holds: " + $.f(listed, "", -1) + ".")], {"run": chosen, "runs": runs}));}
labels = run_labels(table);
return $.tup(chosen, ($.t((labels == null)) ? everything : np.asarray($.eq(labels, chosen)))); }, {p: ["table", "run"], ks: false});
provenance = $.def(function (table, columns, run, window, rows) { 
return $.dict([["file", $.ga(table, "name")], ["sha256", $.ga(table, "sha256")], ...$.pairs(columns), ["run_column", ($.t((run != null)) ? run_column(table) : null)], ["run", run], ["window", window], ...$.pairs($.b.dict($.k($.b.zip, [$.tup("rows", "first_row", "last_row"), rows], {"strict": true})))]); }, {p: ["table", "columns", "run", "window", "rows"], ks: false});
Object.assign($m, {"annotations": annotations, "difflib": difflib, "Mapping": Mapping, "Any": Any, "np": np, "npt": npt, "Array": Array_, "ColumnError": ColumnError, "RunError": RunError, "FRAME": FRAME, "Table": Table, "finite": finite, "list_names": list_names, "parse_unit": parse_unit, "words": words, "RUN_WORDS": RUN_WORDS, "MAX_NUMBERED_RUNS": MAX_NUMBERED_RUNS, "find_column": find_column, "_match": _match, "_available": _available, "run_column": run_column, "_is_whole": _is_whole, "_in_blocks": _in_blocks, "_block_starts": _block_starts, "run_labels": run_labels, "numbered_labels": numbered_labels, "count_runs": count_runs, "select_run": select_run, "provenance": provenance});
});
$.module("dehyst.io.delimited", ($m) => {
let annotations, Iterator, Sequence, suppress, dataclass, field, compress, islice, np, npt, _native, Array_, Rows, LogError, Finding, date_order, is_data, is_date_time, is_dressed, marks_of, number, parse_date_times, parse_numbers, separator_of, text_refusal, thousands_finding, thousands_refusal, undress_negatives, undress_units, Column, Piece, Source, Layout, find_layout, is_comment, split_line, PROBE, Part, find_plain, keeps_whole, read_part, read_plain, SHOWN, Table, finite, list_names, list_rows, require_columns, shown_names, unique_names, BLOCK, GZIP, Text, expand, open_text, unpacked, visible, parse_unit, SUSPECT, TEXT_MOST, ODD_MOST, LONGEST_LINE, read_delimited, layout_of, _body, Content, _quick, _split, _ragged, _careful, _undress, _header_unit, _name, _dates, _warn_decimal_comma, _assemble, TextChunks;
Iterator = $.from("collections.abc", "Iterator");Sequence = $.from("collections.abc", "Sequence");
suppress = $.from("contextlib", "suppress");
dataclass = $.from("dataclasses", "dataclass");field = $.from("dataclasses", "field");
compress = $.from("itertools", "compress");islice = $.from("itertools", "islice");
np = $.imp("numpy");
npt = $.imp("numpy.typing");
_native = $.imp("dehyst._native");
Array_ = $.from("dehyst.arrays", "Array");Rows = $.from("dehyst.arrays", "Rows");
LogError = $.from("dehyst.errors", "LogError");
Finding = $.from("dehyst.findings", "Finding");
date_order = $.from("dehyst.io.cells", "date_order");is_data = $.from("dehyst.io.cells", "is_data");is_date_time = $.from("dehyst.io.cells", "is_date_time");is_dressed = $.from("dehyst.io.cells", "is_dressed");marks_of = $.from("dehyst.io.cells", "marks_of");number = $.from("dehyst.io.cells", "number");parse_date_times = $.from("dehyst.io.cells", "parse_date_times");parse_numbers = $.from("dehyst.io.cells", "parse_numbers");separator_of = $.from("dehyst.io.cells", "separator_of");text_refusal = $.from("dehyst.io.cells", "text_refusal");thousands_finding = $.from("dehyst.io.cells", "thousands_finding");thousands_refusal = $.from("dehyst.io.cells", "thousands_refusal");undress_negatives = $.from("dehyst.io.cells", "undress_negatives");undress_units = $.from("dehyst.io.cells", "undress_units");
Column = $.from("dehyst.io.collect", "Column");Piece = $.from("dehyst.io.collect", "Piece");Source = $.from("dehyst.io.collect", "Source");
Layout = $.from("dehyst.io.layout", "Layout");find_layout = $.from("dehyst.io.layout", "find_layout");is_comment = $.from("dehyst.io.layout", "is_comment");split_line = $.from("dehyst.io.layout", "split_line");
PROBE = $.from("dehyst.io.plain", "PROBE");Part = $.from("dehyst.io.plain", "Part");find_plain = $.from("dehyst.io.plain", "find_plain");keeps_whole = $.from("dehyst.io.plain", "keeps_whole");read_part = $.from("dehyst.io.plain", "read_part");read_plain = $.from("dehyst.io.plain", "read_plain");
SHOWN = $.from("dehyst.io.table", "SHOWN");Table = $.from("dehyst.io.table", "Table");finite = $.from("dehyst.io.table", "finite");list_names = $.from("dehyst.io.table", "list_names");list_rows = $.from("dehyst.io.table", "list_rows");require_columns = $.from("dehyst.io.table", "require_columns");shown_names = $.from("dehyst.io.table", "shown_names");unique_names = $.from("dehyst.io.table", "unique_names");
BLOCK = $.from("dehyst.io.text", "BLOCK");GZIP = $.from("dehyst.io.text", "GZIP");Text = $.from("dehyst.io.text", "Text");expand = $.from("dehyst.io.text", "expand");open_text = $.from("dehyst.io.text", "open_text");unpacked = $.from("dehyst.io.text", "unpacked");
visible = $.from("dehyst.shell", "visible");
parse_unit = $.from("dehyst.units", "parse_unit");
SUSPECT = " \t#%/";
TEXT_MOST = 0.1;
ODD_MOST = 0.1;
LONGEST_LINE = $.shl(1, 24);
read_delimited = $.def(function (data, name) { let text, layout, findings, quick, lines, body, rows, cells, content;
text = open_text(expand(data, name), name);
layout = layout_of(text, name);
findings = [];
quick = ($.t(layout) ? _quick(text, layout, findings) : null);
if (($.t(layout) && $.t(quick))) {return _assemble(name, layout, $.gi(quick, 1), $.gi(quick, 0), findings);}
lines = text.all_lines();
layout = (($.t(layout) && $.t($.ga(text, "complete"))) ? layout : find_layout(lines, name));
{const $v1 = $.unpack(_body(lines, $.ga(layout, "first")), 2, -1);body = $v1[0];rows = $v1[1];}
{const $v2 = $.unpack(_split(body, rows, layout, name, findings), 2, -1);cells = $v2[0];rows = $v2[1];}
content = _careful(cells, rows, layout, name, findings);
return _assemble(name, layout, rows, content, findings); }, {p: ["data", "name"], ks: false});
layout_of = $.def(function (text, name) { let layout;
if ($.t($.ga(text, "complete"))) {return find_layout($.ga(text, "lines"), name);}
{ const $v3 = suppress(LogError); $.enter($v3); try {layout = find_layout($.ga(text, "lines"), name);
if ($.t($.le($.add($.ga(layout, "first"), $.mul(2, PROBE)), $.b.len($.ga(text, "lines"))))) {return layout;}} catch ($e) { if (!$.exit($v3, $.caught($e))) throw $e; } }
return null; }, {p: ["text", "name"], ks: false});
_body = $.def(function (lines, first) { let body, keep, rows;
body = $.b.list($.gi(lines, $.slice(first, null, null)));
while (($.t(body) && !$.t($.cm($.gi(body, (-1)), "strip", [])))) {$.cm(body, "pop", []);}
if (($.t($.b.all(body)) && !$.t($.b.any((function* () { for (const $v4 of $.it(body)) { let line; line = $v4; yield $.in($.gi(line, 0), SUSPECT); } })())))) {return $.tup(body, $.km(np, "arange", [$.add(first, 1), $.add($.add(first, 1), $.b.len(body))], {"dtype": $.ga(np, "int64")}));}
keep = (() => { const $r = []; for (const $v5 of $.it(body)) { let line; line = $v5; $r.push(!$.t(is_comment(line))); } return $r; })();
rows = $.add($.add(np.flatnonzero($.km(np, "array", [keep], {"dtype": $.b.bool})), first), 1);
return $.tup($.b.list(compress(body, keep)), rows.astype($.ga(np, "int64"))); }, {p: ["lines", "first"], ks: false});
Content = $.cls("Content", [], "", [["numbers", () => $.b.dict()], ["labels", () => $.b.dict()], ["stamps", () => $.b.set()], ["refused", () => $.b.dict()], ["units", () => $.b.dict()]], true, true, ($c) => { Content = $c; });
_quick = $.def(function (text, layout, findings) { let body, plain, read, columns, rows, content, j, column;
body = $.b.list(islice((function* () { for (const $v6 of $.it($.gi($.ga(text, "lines"), $.slice($.ga(layout, "first"), null, null)))) { let line; line = $v6; if (!$.t(is_comment(line))) { yield line; } } })(), PROBE));
if (($.t($.lt($.b.len(body), PROBE)) && !$.t($.ga(text, "complete")))) {return null;}
plain = find_plain(body, layout);
read = ($.t(plain) ? read_plain($.ga(text, "data"), text.offset($.ga(layout, "first")), $.add($.ga(layout, "first"), 1), plain) : null);
if (($.t((plain == null)) || $.t((read == null)))) {return null;}
{const $v7 = $.unpack(read, 2, -1);columns = $v7[0];rows = $v7[1];}
content = Content();
for (const $v8 of $.it($.b.enumerate(columns))) { {const $v9 = $.unpack($v8, 2, -1);j = $v9[0];column = $v9[1];}
{if (!$.t($.gi($.ga(plain, "letters"), j))) {$.si($.ga(content, "numbers"), j, column);} else {if ($.t(is_date_time($.b.str($.gi(column, 0))))) {$.si($.ga(content, "numbers"), j, _dates(column.tolist(), layout, j, findings));
$.cm($.ga(content, "stamps"), "add", [j]);} else {$.si($.ga(content, "labels"), j, column);}}} }
return $.tup(content, rows); }, {p: ["text", "layout", "findings"], ks: false});
_split = $.def(function (body, rows, layout, name, findings) { let cells, keep, ragged;
cells = (() => { const $r = []; for (const $v10 of $.it(body)) { let line; line = $v10; $r.push(split_line(line, $.ga(layout, "delimiter"))); } return $r; })();
keep = $.km(np, "array", [(() => { const $r = []; for (const $v11 of $.it(cells)) { let row; row = $v11; $r.push($.eq($.b.len(row), $.ga(layout, "width"))); } return $r; })()], {"dtype": $.b.bool});
ragged = $.gi(rows, $.inv(keep));
if ($.t($.ga(ragged, "size"))) {$.cm(findings, "append", [_ragged(name, layout, ("" + $.f(list_rows(ragged), "", -1) + " of " + $.f(name, "", -1)))]);}
if ($.t($.gt($.ga(ragged, "size"), $.mul(0.5, $.ga(keep, "size"))))) {throw $.exc($.k(LogError, [("" + "log '" + $.f(name, "", -1) + "' is not a table: " + $.f($.ga(ragged, "size"), "", -1) + " of its " + $.f($.ga(keep, "size"), "", -1) + " lines do not have the " + $.f($.ga(layout, "width"), "", -1) + " cells of the others (" + $.f(list_rows(ragged), "", -1) + "). Check the delimiter and the decimal sign, or cut the file.")], {"file": name, "rows": ragged}));}
return $.tup($.b.list(compress(cells, keep)), $.gi(rows, keep)); }, {p: ["body", "rows", "layout", "name", "findings"], ks: false});
_ragged = $.def(function (name, layout, lines) { 
return Finding("ragged-lines", ("" + $.f(lines, "", -1) + " do not have the " + $.f($.ga(layout, "width"), "", -1) + " cells of the others and were left out: the logger was interrupted or lines were damaged. Look at them, and mend or delete them.")); }, {p: ["name", "layout", "lines"], ks: false});
_careful = $.def(function (cells, rows, layout, log, findings) { let content, columns, commas, marks, decimals, j, column, name, filled, values, bad, separator, certain, whole, text;
content = Content();
columns = (() => { const $r = []; for (const $v13 of $.it($.k($.b.zip, [...$.it(cells)], {"strict": true}))) { let raw; raw = $v13; $r.push((() => { const $r = []; for (const $v12 of $.it(raw)) { let cell; cell = $v12; $r.push($.cm(cell, "strip", [])); } return $r; })()); } return $r; })();
columns = (() => { const $r = []; for (const $v14 of $.it($.b.enumerate(columns))) { let j, column; {const $v15 = $.unpack($v14, 2, -1);j = $v15[0];column = $v15[1];} $r.push(_undress(column, j, rows, layout, content, log, findings)); } return $r; })();
commas = $.or($.ga(layout, "decimal_comma"), () => $.b.any((function* () { for (const $v17 of $.it(columns)) { let column; column = $v17; for (const $v16 of $.it(column)) { let cell; cell = $v16; yield $.in(",", cell); } } })()));
marks = ($.t(commas) ? (() => { const $r = []; for (const $v18 of $.it(columns)) { let column; column = $v18; $r.push(marks_of(column)); } return $r; })() : []);
decimals = $.cm($.gi($.b.frozenset, $.b.str)(), "union", [...$.it((function* () { for (const $v19 of $.it(marks)) { let found; found = $v19; yield $.ga(found, "decimals"); } })())]);
for (const $v20 of $.it($.b.enumerate(columns))) { {const $v21 = $.unpack($v20, 2, -1);j = $v21[0];column = $v21[1];}
{name = _name(layout, j);
filled = (() => { const $r = []; for (const $v22 of $.it(column)) { let cell; cell = $v22; if ($.t(cell)) { $r.push(cell); } } return $r; })();
{const $v23 = $.unpack(parse_numbers(column, commas), 2, -1);values = $v23[0];bad = $v23[1];}
{const $v24 = $.unpack(($.t(marks) ? separator_of(column, $.gi(marks, j), decimals) : $.tup("", false)), 2, -1);separator = $v24[0];certain = $v24[1];}
if ($.t(separator)) {{const $v25 = $.unpack(parse_numbers($.gi(marks, j).without(column, separator), commas), 2, -1);whole = $v25[0];text = $v25[1];}
if ($.t($.gt(text, $.mul(0.5, $.b.len(filled))))) {separator = "";} else {if ($.t(certain)) {$.cm(findings, "append", [thousands_finding(name, column, $.gi(marks, j), separator, rows)]);
{const $v26 = $.unpack($.tup(whole, text), 2, -1);values = $v26[0];bad = $v26[1];}} else {$.si($.ga(content, "refused"), j, thousands_refusal(name, log, column, $.gi(marks, j), separator, rows));}}}
if (($.t(separator) || $.t($.le(bad, $.mul(0.5, $.b.len(filled)))))) {$.si($.ga(content, "numbers"), j, values);
if (!$.t(separator)) {_warn_decimal_comma(column, name, findings);}
if ($.t($.gt(bad, $.mul(TEXT_MOST, $.b.len(filled))))) {$.cm($.ga(content, "refused"), "setdefault", [j, text_refusal(name, log, column, rows)]);}} else {if ($.t($.gt($.b.sum((function* () { for (const $v27 of $.it($.gi(filled, $.slice(null, PROBE, null)))) { let cell; cell = $v27; yield is_date_time(cell); } })()), $.mul(0.5, $.b.len($.gi(filled, $.slice(null, PROBE, null))))))) {$.si($.ga(content, "numbers"), j, _dates(column, layout, j, findings));
$.cm($.ga(content, "stamps"), "add", [j]);} else {$.si($.ga(content, "labels"), j, $.km(np, "array", [(() => { const $r = []; for (const $v28 of $.it(column)) { let cell; cell = $v28; $r.push($.gi(cell, $.slice(null, 200, null))); } return $r; })()], {"dtype": $.ga(np, "str_")}));}}} }
return content; }, {p: ["cells", "rows", "layout", "log", "findings"], ks: false});
_undress = $.def(function (column, j, rows, layout, content, log, findings) { let name, bare, header;
if ((!$.t($.b.any((function* () { for (const $v29 of $.it($.gi(column, $.slice(null, PROBE, null)))) { let cell; cell = $v29; yield is_dressed(cell); } })())) && !$.t($.b.any((function* () { for (const $v30 of $.it(column)) { let cell; cell = $v30; yield $.eq($.gi(cell, $.slice(null, 1, null)), "("); } })())))) {return column;}
name = _name(layout, j);
bare = undress_units(name, column, findings);
if ($.t((bare == null))) {return undress_negatives(name, column, rows, findings);}
$.si($.ga(content, "units"), j, $.gi(bare, 1));
header = _header_unit(layout, j);
if (($.t(header) && $.t($.ne(header, $.gi(bare, 1))))) {$.si($.ga(content, "refused"), j, ("" + "column '" + $.f(name, "", -1) + "' of " + $.f(log, "", -1) + " is in " + $.f(header, "", -1) + " by its header and in " + $.f($.gi(bare, 1), "", -1) + " by its cells (" + $.f($.gi(column, 0), "", 114) + "); one of them is wrong. Correct the header, or take the unit out of the cells."));}
return $.gi(bare, 0); }, {p: ["column", "j", "rows", "layout", "content", "log", "findings"], ks: false});
_header_unit = $.def(function (layout, j) { let given;
given = (($.t($.ga(layout, "units")) && $.t($.gi($.ga(layout, "units"), j))) ? $.gi(parse_unit(("" + "x [" + $.f(visible($.gi($.ga(layout, "units"), j)), "", -1) + "]")), 1) : "");
return $.or(given, () => $.gi(parse_unit(_name(layout, j)), 1)); }, {p: ["layout", "j"], ks: false});
_name = $.def(function (layout, j) { 
return ($.t($.ga(layout, "names")) ? visible($.gi($.ga(layout, "names"), j)) : ("" + "column_" + $.f($.add(j, 1), "", -1))); }, {p: ["layout", "j"], ks: false});
_dates = $.def(function (column, layout, j, findings) { let order, assumed;
{const $v31 = $.unpack(date_order(column), 2, -1);order = $v31[0];assumed = $v31[1];}
if ($.t(assumed)) {$.cm(findings, "append", [Finding("date-order", ("" + "dates in column '" + $.f(_name(layout, j), "", -1) + "', such as " + $.f($.cm($.gi(column, 0), "strip", []), "", -1) + ", were read with the " + $.f(order, "", -1) + " first; nothing in the log tells. If that is wrong, log dates as 2024-05-01 12:00:00."))]);}
return parse_date_times(column); }, {p: ["column", "layout", "j", "findings"], ks: false});
_warn_decimal_comma = $.def(function (column, name, findings) { let tails;
tails = (() => { const $r = []; for (const $v32 of $.it(column)) { let cell; cell = $v32; if ($.t($.in(",", cell))) { $r.push($.b.len($.gi($.cm(cell, "partition", [","]), 2))); } } return $r; })();
if (($.t(tails) && $.t($.eq($.b.set(tails), $.b.set([3]))) && $.t($.lt($.b.len(tails), $.b.sum((function* () { for (const $v33 of $.it(column)) { let cell; cell = $v33; yield is_data(cell); } })()))))) {$.cm(findings, "append", [Finding("decimal-comma", ("" + "commas in column '" + $.f(name, "", -1) + "' were read as decimal signs (1,234 is 1.234), but three digits follow each and other cells have none. If they separate thousands, save the log without them."))]);} }, {p: ["column", "name", "findings"], ks: false});
_assemble = $.def(function (name, layout, rows, content, findings) { let numbers, raw, names, renamed, trailing, kept;
numbers = $.ga(content, "numbers");
raw = shown_names($.or($.ga(layout, "names"), () => (() => { const $r = []; for (const $v34 of $.it($.b.range($.ga(layout, "width")))) { let j; j = $v34; $r.push(_name(layout, j)); } return $r; })()), name, findings);
names = unique_names(raw);
renamed = (() => { const $r = []; for (const $v35 of $.it($.k($.b.zip, [raw, names], {"strict": true}))) { let given, unique; {const $v36 = $.unpack($v35, 2, -1);given = $v36[0];unique = $v36[1];} if (($.t(given) && $.t($.ne(given, unique)))) { $r.push($.tup(given, unique)); } } return $r; })();
if ($.t(renamed)) {$.cm(findings, "append", [Finding("duplicate-columns", ("" + $.f(name, "", -1) + " names several columns " + $.f(list_names($.b.sorted($.b.set((() => { const $r = []; for (const $v37 of $.it(renamed)) { let given, _; {const $v38 = $.unpack($v37, 2, -1);given = $v38[0];_ = $v38[1];} $r.push(given); } return $r; })())), 8), "", -1) + "; the later ones were renamed (" + $.f(list_names((() => { const $r = []; for (const $v39 of $.it(renamed)) { let _, unique; {const $v40 = $.unpack($v39, 2, -1);_ = $v40[0];unique = $v40[1];} $r.push(unique); } return $r; })(), 8), "", -1) + "). Name the one you mean, or use #3 for the third column."))]);}
trailing = ($.t($.gt($.ga(layout, "width"), 1)) ? ("" + "column_" + $.f($.ga(layout, "width"), "", -1)) : "");
kept = (() => { const $r = []; for (const $v41 of $.it($.b.sorted(numbers))) { let j; j = $v41; if (($.t($.ne($.gi(names, j), trailing)) || $.t(finite($.gi(numbers, j)).any()))) { $r.push(j); } } return $r; })();
return require_columns($.k(Table, [], {"name": name, "columns": $.dict((() => { const $r = []; for (const $v42 of $.it(kept)) { let j; j = $v42; $r.push([$.gi(names, j), $.gi(numbers, j)]); } return $r; })()), "units": $.dict((() => { const $r = []; for (const $v43 of $.it(kept)) { let j; j = $v43; $r.push([$.gi(names, j), ($.t($.in(j, $.ga(content, "stamps"))) ? "s" : $.or($.cm($.ga(content, "units"), "get", [j]), () => _header_unit(layout, j)))]); } return $r; })()), "rows": rows, "labels": $.dict((() => { const $r = []; for (const $v44 of $.it($.b.sorted($.ga(content, "labels")))) { let j; j = $v44; $r.push([$.gi(names, j), $.gi($.ga(content, "labels"), j)]); } return $r; })()), "row_word": "line", "stamps": $.b.frozenset((function* () { for (const $v45 of $.it($.ga(content, "stamps"))) { let j; j = $v45; yield $.gi(names, j); } })()), "order": $.b.tuple(names), "findings": $.b.tuple(findings), "refused": $.dict((() => { const $r = []; for (const $v46 of $.it($.cm($.ga(content, "refused"), "items", []))) { let j, reason; {const $v47 = $.unpack($v46, 2, -1);j = $v47[0];reason = $v47[1];} if ($.t($.in(j, kept))) { $r.push([$.gi(names, j), reason]); } } return $r; })())})); }, {p: ["name", "layout", "rows", "content", "findings"], ks: false});
TextChunks = $.cls("TextChunks", [Source], "", [], false, true, ($c) => { TextChunks = $c; $.meth($c, "_head", $.def(function () { const self = this;let data, text, table, layout, plain, name, j;
data = $.gi($.b.next(self._blocks(BLOCK), $.tup($.bytes([]), 0)), 0);
text = open_text(data, $.ga($.ga(self, "path"), "name"));
table = read_delimited(data, $.ga($.ga(self, "path"), "name"));
layout = layout_of(text, $.ga($.ga(self, "path"), "name"));
plain = ($.t(layout) ? find_plain($.b.list(islice(self._whole(text, layout), PROBE)), layout) : null);
if (($.t((layout == null)) || $.t((plain == null)) || $.t($.in($.bytes([0]), $.gi(data, $.slice(null, 4096, null)))))) {throw $.exc($.k(LogError, [("" + "log '" + $.f($.ga($.ga(self, "path"), "name"), "", -1) + "' cannot be read in chunks: its cells are not plain numbers set off by one delimiter (quotes, units in cells, separators of thousands, UTF-16 or the like). Read it at once, with dehyst.read_log, or save it as CSV with plain numbers in UTF-8.")], {"file": $.ga($.ga(self, "path"), "name")}));}
{const $v48 = $.unpack($.tup(layout, plain), 2, -1);self._layout = $v48[0];self._plain = $v48[1];}
self._orders = $.dict([]);
for (const $v49 of $.it($.ga(table, "stamps"))) { name = $v49;
{j = $.cm($.ga(table, "order"), "index", [name]);
$.si($.ga(self, "_orders"), name, $.gi(date_order((() => { const $r = []; for (const $v50 of $.it(self._whole(text, layout))) { let line; line = $v50; $r.push($.gi(self._cells(line), j)); } return $r; })()), 0));} }
{const $v51 = $.unpack($.tup(0, $.gi($.b.list, $.b.int)()), 2, -1);self._ragged = $v51[0];self._shown = $v51[1];}
return table; }, {p: [], ks: false}));
$.smeth($c, "_whole", $.def(function (text, layout) { let lines;
lines = (function* () { for (const $v52 of $.it($.gi($.ga(text, "lines"), $.slice($.ga(layout, "first"), null, null)))) { let line; line = $v52; if (!$.t(is_comment(line))) { yield line; } } })();
return (function* () { for (const $v53 of $.it(lines)) { let line; line = $v53; if ($.t($.eq($.b.len(split_line(line, $.ga(layout, "delimiter"))), $.ga(layout, "width")))) { yield line; } } })(); }, {p: ["text", "layout"], ks: false}));
$.meth($c, "_cells", $.def(function (line) { const self = this;
return split_line(line, $.ga($.ga(self, "_layout"), "delimiter")); }, {p: ["line"], ks: false}));
$.meth($c, "_blocks", $.def(function* (least) { const self = this;let parts, size, stream, packed, block, text, cut;
parts = [];
size = 0;
{ const $v56 = $.ga(self, "path").open("rb"); stream = $.enter($v56); try {packed = $.eq(stream.read($.b.len(GZIP)), GZIP);
stream.seek(0);
for (const $v54 of $.it(($.t(packed) ? unpacked(stream, $.ga($.ga(self, "path"), "name")) : $.b.iter($.def(() => {  return stream.read(BLOCK); }, {p: [], ks: false}), $.bytes([]))))) { block = $v54;
{$.cm(parts, "append", [block]);
size = $.iadd(size, $.b.len(block));
if ($.t($.lt(size, least))) {continue;}
text = $.cm($.bytes([]), "join", [parts]);
cut = _native.text_whole_lines(text);
if ($.t(cut)) {(yield $.tup($.gi(text, $.slice(null, cut, null)), stream.tell()));} else {if ($.t($.gt(size, LONGEST_LINE))) {throw $.exc($.k(LogError, [("" + "a line of the log is longer than " + $.f($.shr(LONGEST_LINE, 20), "", -1) + " MB: it is no table. Check that it is the right file.")], {"bytes": size}));}}
{const $v55 = $.unpack($.tup([$.gi(text, $.slice(cut, null, null))], $.sub($.b.len(text), cut)), 2, -1);parts = $v55[0];size = $v55[1];}} }
if ($.t(size)) {(yield $.tup($.cm($.bytes([]), "join", [parts]), stream.tell()));}} catch ($e) { if (!$.exit($v56, $.caught($e))) throw $e; } } }, {p: ["least"], ks: false}));
$.meth($c, "findings", $.def(function () { const self = this;let lines;
if (!$.t($.ga(self, "_ragged"))) {return [];}
lines = ("" + $.f($.ga(self, "_ragged"), "", -1) + " lines of " + $.f($.ga($.ga(self, "path"), "name"), "", -1) + ", among them " + $.f(list_rows($.ga(self, "_shown")), "", -1) + ",");
return [_ragged($.ga($.ga(self, "path"), "name"), $.ga(self, "_layout"), lines)]; }, {p: [], ks: false}));
$.meth($c, "pieces", $.def(function* (names, rows) { const self = this;let index, skip, line, text, consumed, mark, offset, odd, begin, part, columns, numbers, end, k, name;
index = (() => { const $r = []; for (const $v57 of $.it(names)) { let name; name = $v57; $r.push($.cm($.ga($.ga(self, "table"), "order"), "index", [name])); } return $r; })();
{const $v58 = $.unpack($.tup($.ga($.ga(self, "_layout"), "first"), $.add(1, $.ga($.ga(self, "_layout"), "first"))), 2, -1);skip = $v58[0];line = $v58[1];}
{const $v59 = $.unpack($.tup(0, []), 2, -1);self._ragged = $v59[0];self._shown = $v59[1];}
for (const $v60 of $.it(self._blocks(BLOCK))) { {const $v61 = $.unpack($v60, 2, -1);text = $v61[0];consumed = $v61[1];}
{mark = (($.t($.eq(line, 1)) && $.t($.cm(text, "startswith", [$.bytes([239, 187, 191])]))) ? 3 : 0);
offset = ($.t(skip) ? _native.text_offset(text, skip) : mark);
{ const $v62 = 0; skip = $v62; odd = $v62;}
begin = line;
while ($.t($.lt(offset, $.b.len(text)))) {part = read_part(text, offset, line, $.ga(self, "_plain"), rows);
{const $v63 = $.unpack($.tup($.add(offset, $.ga(part, "bytes")), $.add(line, $.ga(part, "lines"))), 2, -1);offset = $v63[0];line = $v63[1];}
if (!$.t(keeps_whole($.ga(part, "columns"), $.ga(self, "_plain")))) {throw $.exc(self._refusal(line, "commas appear in a column that had none before"));}
{const $v65 = $.unpack($.tup((() => { const $r = []; for (const $v64 of $.it(index)) { let j; j = $v64; $r.push($.gi($.ga(part, "columns"), j)); } return $r; })(), $.ga(part, "rows")), 2, -1);columns = $v65[0];numbers = $v65[1];}
if ($.t($.ge($.ga(part, "column"), 0))) {end = _native.text_offset(text, 1, offset);
{const $v66 = $.unpack(self._with_odd_line($.gi(text, $.slice(offset, end, null)), line, index, part), 2, -1);columns = $v66[0];numbers = $v66[1];}
{const $v67 = $.unpack($.tup(end, $.add(line, 1), $.add(odd, 1)), 3, -1);offset = $v67[0];line = $v67[1];odd = $v67[2];}
if (($.t($.gt(odd, 100)) && $.t($.gt(odd, $.mul(ODD_MOST, $.sub(line, begin)))))) {throw $.exc(self._refusal(line, "many of its lines are not plain numbers"));}}
for (const $v68 of $.it($.b.enumerate(names))) { {const $v69 = $.unpack($v68, 2, -1);k = $v69[0];name = $v69[1];}
{if ($.t($.in(name, $.ga(self, "_orders")))) {$.si(columns, k, parse_date_times($.gi(columns, k).tolist(), $.gi($.ga(self, "_orders"), name)));}} }
if ($.t($.ga(numbers, "size"))) {(yield Piece(columns, numbers, consumed));}}} } }, {p: ["names", "rows"], ks: false}));
$.meth($c, "_with_odd_line", $.def(function (raw, line, index, part) { const self = this;let cells, columns, longer, column, j, text, value;
cells = self._cells($.cm($.cm(raw, "decode", [], {"errors": "replace"}), "strip", ["\r\n"]));
columns = (() => { const $r = []; for (const $v70 of $.it(index)) { let j; j = $v70; $r.push($.gi($.ga(part, "columns"), j)); } return $r; })();
if ($.t($.ne($.b.len(cells), $.ga($.ga(self, "_layout"), "width")))) {$.ia(self, "_ragged", $.iadd, 1);
$.ia(self, "_shown", $.iadd, ($.t($.lt($.b.len($.ga(self, "_shown")), SHOWN)) ? [line] : []));
return $.tup(columns, $.ga(part, "rows"));}
longer = [];
for (const $v71 of $.it($.k($.b.zip, [columns, index], {"strict": true}))) { {const $v72 = $.unpack($v71, 2, -1);column = $v72[0];j = $v72[1];}
{text = $.cm($.gi(cells, j), "strip", []);
if ($.t($.gi($.ga($.ga(self, "_plain"), "letters"), j))) {$.cm(longer, "append", [$.cm(np, "append", [column, text])]);} else {value = number(($.t($.eq($.ga($.ga(self, "_plain"), "decimal"), ",")) ? $.cm(text, "replace", [",", "."]) : text));
$.cm(longer, "append", [$.cm(np, "append", [column, ($.t((value == null)) ? $.ga(np, "nan") : value)])]);}} }
return $.tup(longer, $.cm(np, "append", [$.ga(part, "rows"), line])); }, {p: ["raw", "line", "index", "part"], ks: false}));
$.meth($c, "_refusal", $.def(function (line, why) { const self = this;
return $.k(LogError, [("" + "log '" + $.f($.ga($.ga(self, "path"), "name"), "", -1) + "' cannot be read in chunks: near line " + $.f(line, "", -1) + ", " + $.f(why, "", -1) + ". Read it at once, with dehyst.read_log, or save it as CSV with plain numbers.")], {"file": $.ga($.ga(self, "path"), "name"), "line": line}); }, {p: ["line", "why"], ks: false}));});
Object.assign($m, {"annotations": annotations, "Iterator": Iterator, "Sequence": Sequence, "suppress": suppress, "dataclass": dataclass, "field": field, "compress": compress, "islice": islice, "np": np, "npt": npt, "_native": _native, "Array": Array_, "Rows": Rows, "LogError": LogError, "Finding": Finding, "date_order": date_order, "is_data": is_data, "is_date_time": is_date_time, "is_dressed": is_dressed, "marks_of": marks_of, "number": number, "parse_date_times": parse_date_times, "parse_numbers": parse_numbers, "separator_of": separator_of, "text_refusal": text_refusal, "thousands_finding": thousands_finding, "thousands_refusal": thousands_refusal, "undress_negatives": undress_negatives, "undress_units": undress_units, "Column": Column, "Piece": Piece, "Source": Source, "Layout": Layout, "find_layout": find_layout, "is_comment": is_comment, "split_line": split_line, "PROBE": PROBE, "Part": Part, "find_plain": find_plain, "keeps_whole": keeps_whole, "read_part": read_part, "read_plain": read_plain, "SHOWN": SHOWN, "Table": Table, "finite": finite, "list_names": list_names, "list_rows": list_rows, "require_columns": require_columns, "shown_names": shown_names, "unique_names": unique_names, "BLOCK": BLOCK, "GZIP": GZIP, "Text": Text, "expand": expand, "open_text": open_text, "unpacked": unpacked, "visible": visible, "parse_unit": parse_unit, "SUSPECT": SUSPECT, "TEXT_MOST": TEXT_MOST, "ODD_MOST": ODD_MOST, "LONGEST_LINE": LONGEST_LINE, "read_delimited": read_delimited, "layout_of": layout_of, "_body": _body, "Content": Content, "_quick": _quick, "_split": _split, "_ragged": _ragged, "_careful": _careful, "_undress": _undress, "_header_unit": _header_unit, "_name": _name, "_dates": _dates, "_warn_decimal_comma": _warn_decimal_comma, "_assemble": _assemble, "TextChunks": TextChunks});
});
$.module("dehyst.io.layout", ($m) => {
let annotations, csv, re, Counter, Sequence, dataclass, LogError, MISSING, comma_number, is_data, is_date_time, is_dressed, number, unescaped, canonical, COMMENTS, SAMPLE, SAMPLE_TEXT, VOTERS, BLANKS, _QUOTED_COMMA, Layout, is_comment, split_line, _numeric, _score, find_layout, _sample, _refuse_header_only, _is_data_row, _with_header, _is_named_by_values, _first_missing, _header_cells, _last_empty, _is_units_row;
csv = $.imp("csv");
re = $.imp("re");
Counter = $.from("collections", "Counter");
Sequence = $.from("collections.abc", "Sequence");
dataclass = $.from("dataclasses", "dataclass");
LogError = $.from("dehyst.errors", "LogError");
MISSING = $.from("dehyst.io.cells", "MISSING");comma_number = $.from("dehyst.io.cells", "comma_number");is_data = $.from("dehyst.io.cells", "is_data");is_date_time = $.from("dehyst.io.cells", "is_date_time");is_dressed = $.from("dehyst.io.cells", "is_dressed");number = $.from("dehyst.io.cells", "number");unescaped = $.from("dehyst.io.cells", "unescaped");
canonical = $.from("dehyst.units", "canonical");
COMMENTS = $.tup("#", "%", "//");
SAMPLE = 400;
SAMPLE_TEXT = $.shl(1, 20);
VOTERS = 1000;
BLANKS = " ";
_QUOTED_COMMA = re.compile("\"\\s*[+-]?\\d*,\\d+(?:[eE][+-]?\\d+)?\\s*\"", $.ga(re, "ASCII"));
Layout = $.cls("Layout", [], "", [["delimiter", null], ["decimal_comma", null], ["width", null], ["names", null], ["units", null], ["first", null]], true, true, ($c) => { Layout = $c; });
is_comment = $.def(function (line) { let stripped;
stripped = $.cm(line, "lstrip", []);
return $.or(!$.t(stripped), () => $.cm(stripped, "startswith", [COMMENTS])); }, {p: ["line"], ks: false});
split_line = $.def(function (line, delimiter) { 
if ($.t($.in("\"", line))) {try {line = ($.t($.eq(delimiter, BLANKS)) ? $.cm(line, "strip", []) : line);
return $.b.next($.km(csv, "reader", [[line]], {"delimiter": delimiter, "skipinitialspace": true}), []);} catch ($e) { $e = $.caught($e); if ($.isinst($e, $.ga(csv, "Error"))) {  {return [line];} } else throw $e; }}
return ($.t($.eq(delimiter, BLANKS)) ? $.cm(line, "split", []) : $.cm(line, "split", [delimiter])); }, {p: ["line", "delimiter"], ks: false});
_numeric = $.def(function (cell, decimal_comma) { let value;
value = ($.t(decimal_comma) ? comma_number(cell) : number(cell));
return ($.t((value == null)) ? is_dressed(cell) : $.or($.eq(value, value), () => $.ne($.cm(cell, "strip", []), ""))); }, {p: ["cell", "decimal_comma"], ks: false});
_score = $.def(function (sample, delimiter, decimal_comma) { let rows, good, row, voters, hits, texts, width, lines, cells;
rows = (() => { const $r = []; for (const $v1 of $.it(sample)) { let line; line = $v1; $r.push(split_line(line, delimiter)); } return $r; })();
good = Counter();
for (const $v2 of $.it(rows)) { row = $v2;
{voters = $.gi(row, $.slice(null, VOTERS, null));
hits = $.b.sum((function* () { for (const $v3 of $.it(voters)) { let cell; cell = $v3; yield $.or(_numeric(cell, decimal_comma), () => is_date_time(cell)); } })());
texts = $.sub($.b.sum((function* () { for (const $v4 of $.it(voters)) { let cell; cell = $v4; yield $.b.bool($.cm(cell, "strip", [])); } })()), hits);
if (($.t(hits) && $.t($.le(texts, $.b.max(1, hits))))) {$.isi(good, $.b.len(row), $.iadd, hits);}} }
if (!$.t(good)) {return $.tup(0.0, 0);}
{const $v5 = $.unpack($.gi($.cm(good, "most_common", [1]), 0), 2, -1);width = $v5[0];hits = $v5[1];}
lines = $.b.sum((function* () { for (const $v6 of $.it(rows)) { let row; row = $v6; yield $.eq($.b.len(row), width); } })());
cells = $.b.sum((function* () { for (const $v8 of $.it(rows)) { let row; row = $v8; if ($.t($.eq($.b.len(row), width))) { yield $.b.sum((function* () { for (const $v7 of $.it($.gi(row, $.slice(null, VOTERS, null)))) { let cell; cell = $v7; yield $.b.bool($.cm(cell, "strip", [])); } })()); } } })());
return $.tup($.mul($.div(hits, $.b.max(1, cells)), $.div(lines, $.b.len(rows))), width); }, {p: ["sample", "delimiter", "decimal_comma"], ks: false});
find_layout = $.def(function (lines, name) { let body, sample, best, marks, trials, found, delimiter, decimal_comma, score, width;
body = (() => { const $r = []; for (const $v9 of $.it($.gi(lines, $.slice(null, $.mul(4, SAMPLE), null)))) { let line; line = $v9; if (!$.t(is_comment(line))) { $r.push(line); } } return $r; })();
if (!$.t(body)) {throw $.exc($.k(LogError, [("" + "log '" + $.f(name, "", -1) + "' holds no data: its " + $.f($.b.len(lines), "", -1) + " lines are empty or comments. Check that it is the right file and that the logger had not just been started.")], {"file": name}));}
sample = _sample($.gi(body, $.slice($.fdiv($.b.len(body), 4), null, null)));
best = $.tup(0.0, 0, ",", false);
marks = $.tup(",", ";", "\t", "|", BLANKS);
trials = $.add((() => { const $r = []; for (const $v10 of $.it(marks)) { let mark; mark = $v10; $r.push($.tup(mark, false)); } return $r; })(), (() => { const $r = []; for (const $v11 of $.it($.gi(marks, $.slice(1, null, null)))) { let mark; mark = $v11; $r.push($.tup(mark, true)); } return $r; })());
if ($.t($.b.any((function* () { for (const $v12 of $.it(sample)) { let line; line = $v12; yield _QUOTED_COMMA.search(line); } })()))) {$.cm(trials, "append", [$.tup(",", true)]);}
found = $.cm("", "join", [sample]);
for (const $v13 of $.it(trials)) { {const $v14 = $.unpack($v13, 2, -1);delimiter = $v14[0];decimal_comma = $v14[1];}
{if (($.t($.gt($.gi(best, 0), $.sub(1, 1e-09))) && !$.t(($.t($.eq(delimiter, BLANKS)) ? $.ne($.cm(found, "split", [null, 1]), [found]) : $.in(delimiter, found))))) {continue;}
{const $v15 = $.unpack(_score(sample, delimiter, decimal_comma), 2, -1);score = $v15[0];width = $v15[1];}
if (($.t($.gt(score, $.add($.gi(best, 0), 1e-09))) || ($.t($.gt(score, $.sub($.gi(best, 0), 1e-09))) && $.t($.gt(width, $.gi(best, 1)))))) {best = $.tup(score, width, delimiter, decimal_comma);}} }
{const $v16 = $.unpack(best, 4, -1);score = $v16[0];width = $v16[1];delimiter = $v16[2];decimal_comma = $v16[3];}
if ($.t($.lt(score, 0.2))) {_refuse_header_only(body, name);}
if (($.t($.lt(score, 0.2)) || $.t($.lt(width, 1)))) {throw $.exc($.k(LogError, [("" + "log '" + $.f(name, "", -1) + "' holds no table of numbers that , ; | tab or blanks would separate; its first line of text is " + $.f($.gi($.gi(body, 0), $.slice(null, 60, null)), "", 114) + ". Save it as CSV with one header line and a . or , as decimal sign.")], {"file": name}));}
return _with_header(lines, delimiter, decimal_comma, width); }, {p: ["lines", "name"], ks: false});
_sample = $.def(function (body) { let sample, left, line;
sample = [];
left = SAMPLE_TEXT;
for (const $v17 of $.it($.gi(body, $.slice(null, SAMPLE, null)))) { line = $v17;
{if (($.t($.le(left, 0)) && $.t($.ge($.b.len(sample), 3)))) {break;}
$.cm(sample, "append", [$.gi(line, $.slice(null, SAMPLE_TEXT, null))]);
left = $.isub(left, $.b.len(line));} }
return sample; }, {p: ["body"], ks: false});
_refuse_header_only = $.def(function (body, name) { let cells, names;
if ($.t($.gt($.b.len(body), 2))) {return null;}
cells = $.b.next((function* () { for (const $v18 of $.it((function* () { for (const $v19 of $.it($.tup(",", ";", "\t", "|"))) { let mark; mark = $v19; yield split_line($.gi(body, 0), mark); } })())) { let c; c = $v18; if ($.t($.gt($.b.len(c), 1))) { yield c; } } })(), []);
names = (() => { const $r = []; for (const $v20 of $.it(cells)) { let cell; cell = $v20; $r.push($.cm(cell, "strip", [])); } return $r; })();
if (($.t(names) && $.t($.b.all(names)) && !$.t($.b.any((function* () { for (const $v22 of $.it(body)) { let line; line = $v22; for (const $v21 of $.it($.cm(re, "split", ["[,;|\t]", line]))) { let cell; cell = $v21; yield is_data(cell); } } })())))) {throw $.exc($.k(LogError, [("" + "log '" + $.f(name, "", -1) + "' has a header (" + $.f($.cm(", ", "join", [$.gi(names, $.slice(null, 8, null))]), "", -1) + $.f(($.t($.gt($.b.len(names), 8)) ? ", ..." : ""), "", -1) + ") but no rows below it: the logger was started and wrote nothing, or the copy was cut. Copy the file again, or log again.")], {"file": name, "columns": $.b.tuple(names)}));} }, {p: ["body", "name"], ks: false});
_is_data_row = $.def(function (cells, width, decimal_comma) { let missing, hits, dates, texts;
if ($.t($.ne($.b.len(cells), width))) {return false;}
cells = $.gi(cells, $.slice(null, VOTERS, null));
missing = $.b.sum((function* () { for (const $v23 of $.it(cells)) { let cell; cell = $v23; yield $.in($.cm($.cm(cell, "strip", []), "lower", []), MISSING); } })());
hits = $.b.sum((function* () { for (const $v24 of $.it(cells)) { let cell; cell = $v24; yield $.and(_numeric(cell, decimal_comma), () => !$.in($.cm($.cm(cell, "strip", []), "lower", []), MISSING)); } })());
dates = $.b.sum((function* () { for (const $v25 of $.it(cells)) { let cell; cell = $v25; yield is_date_time(cell); } })());
texts = $.sub($.sub($.sub($.b.len(cells), missing), hits), dates);
return $.and($.gt($.add(hits, dates), 0), () => $.le(texts, $.b.max(1, $.add(hits, dates)))); }, {p: ["cells", "width", "decimal_comma"], ks: false});
_with_header = $.def(function (lines, delimiter, decimal_comma, width) { let data, first, above, line, cells, names, units;
data = (function* () { for (const $v26 of $.it($.b.enumerate(lines))) { let i, line; {const $v27 = $.unpack($v26, 2, -1);i = $v27[0];line = $v27[1];} if ((!$.t(is_comment(line)) && $.t(_is_data_row(split_line(line, delimiter), width, decimal_comma)))) { yield i; } } })();
first = $.b.next(data, $.b.len(lines));
if (($.t($.lt(first, $.b.len(lines))) && $.t(_is_named_by_values($.gi(lines, first), $.gi(lines, $.b.next(data, first)), delimiter)))) {first = $.iadd(first, 1);}
first = _first_missing(lines, first, delimiter, width);
above = [];
for (const $v28 of $.it($.b.reversed($.gi(lines, $.slice($.b.max(0, $.sub(first, 50)), first, null))))) { line = $v28;
{cells = _header_cells(line, delimiter);
if (($.t(cells) && $.t($.eq($.b.len(cells), $.sub(width, 1))) && $.t(_last_empty($.gi(lines, $.slice(first, $.add(first, 50), null)), delimiter, width)))) {cells = [...$.it(cells), ""];}
if (($.t(cells) && $.t($.cm(MISSING, "issuperset", [(function* () { for (const $v29 of $.it(cells)) { let cell; cell = $v29; yield $.cm(cell, "lower", []); } })()])))) {continue;}
if (($.t(cells) && $.t($.eq($.b.len(cells), width)))) {$.cm(above, "append", [cells]);} else {if (!$.t(is_comment(line))) {break;}}
if ($.t($.eq($.b.len(above), 2))) {break;}} }
names = null;
units = null;
if ($.t(above)) {if (($.t($.eq($.b.len(above), 2)) && $.t(_is_units_row($.gi(above, 0))))) {{const $v31 = $.unpack($.tup($.b.tuple((function* () { for (const $v30 of $.it($.gi(above, 0))) { let cell; cell = $v30; yield $.cm(cell, "strip", ["[]() "]); } })()), $.b.tuple($.gi(above, 1))), 2, -1);units = $v31[0];names = $v31[1];}} else {names = $.b.tuple($.gi(above, 0));}}
return Layout(delimiter, decimal_comma, width, names, units, first); }, {p: ["lines", "delimiter", "decimal_comma", "width"], ks: false});
_is_named_by_values = $.def(function (line, below, delimiter) { let cells;
cells = (() => { const $r = []; for (const $v32 of $.it(split_line(line, delimiter))) { let cell; cell = $v32; if (($.t(is_data(cell)) || $.t(is_dressed(cell)))) { $r.push(cell); } } return $r; })();
return $.and($.b.all($.b.map(is_dressed, cells)), () => !$.t($.b.any($.b.map(is_dressed, split_line(below, delimiter))))); }, {p: ["line", "below", "delimiter"], ks: false});
_first_missing = $.def(function (lines, first, delimiter, width) { let start, i, cells;
start = first;
for (const $v33 of $.it($.b.range($.sub(first, 1), (-1), (-1)))) { i = $v33;
{cells = (() => { const $r = []; for (const $v34 of $.it(split_line($.gi(lines, i), delimiter))) { let cell; cell = $v34; $r.push($.cm($.cm(cell, "strip", []), "lower", [])); } return $r; })();
if ((!$.t(is_comment($.gi(lines, i))) && ($.t($.ne($.b.len(cells), width)) || !$.t($.cm(MISSING, "issuperset", [cells]))))) {break;}
if ((!$.t(is_comment($.gi(lines, i))) && !$.t($.cm($.b.set(["-", "--"]), "issuperset", [cells])))) {start = i;}} }
return start; }, {p: ["lines", "first", "delimiter", "width"], ks: false});
_header_cells = $.def(function (line, delimiter) { let text, mark;
text = ($.t($.eq(delimiter, BLANKS)) ? $.cm(line, "strip", []) : line);
for (const $v35 of $.it(COMMENTS)) { mark = $v35;
{if ($.t($.cm($.cm(text, "lstrip", []), "startswith", [mark]))) {text = $.cm($.cm(text, "lstrip", []), "lstrip", [$.gi(mark, 0)]);}} }
if (!$.t($.cm(text, "strip", []))) {return [];}
if ($.t($.eq(delimiter, BLANKS))) {text = re.sub("[ \\t]+(?=[\\[(])", "_", text);}
return (() => { const $r = []; for (const $v36 of $.it(split_line(text, delimiter))) { let cell; cell = $v36; $r.push(unescaped($.cm(cell, "strip", []))); } return $r; })(); }, {p: ["line", "delimiter"], ks: false});
_last_empty = $.def(function (lines, delimiter, width) { let rows;
rows = (() => { const $r = []; for (const $v37 of $.it(lines)) { let line; line = $v37; if (!$.t(is_comment(line))) { $r.push(split_line(line, delimiter)); } } return $r; })();
return $.b.all((function* () { for (const $v38 of $.it(rows)) { let row; row = $v38; yield $.or($.ne($.b.len(row), width), () => !$.t($.cm($.gi(row, (-1)), "strip", []))); } })()); }, {p: ["lines", "delimiter", "width"], ks: false});
_is_units_row = $.def(function (cells) { let known, cell, inner;
known = 0;
for (const $v39 of $.it(cells)) { cell = $v39;
{inner = $.cm(cell, "strip", ["[]() "]);
known = $.iadd(known, $.or($.b.bool(canonical(inner)), () => $.or($.in(inner, $.b.set(["", "-", "1"])), () => $.ne(inner, $.cm(cell, "strip", [])))));} }
return $.and($.ge(known, $.mul(0.5, $.b.len(cells))), () => $.b.any((function* () { for (const $v40 of $.it(cells)) { let cell; cell = $v40; yield $.cm(cell, "strip", ["[]()- "]); } })())); }, {p: ["cells"], ks: false});
Object.assign($m, {"annotations": annotations, "csv": csv, "re": re, "Counter": Counter, "Sequence": Sequence, "dataclass": dataclass, "LogError": LogError, "MISSING": MISSING, "comma_number": comma_number, "is_data": is_data, "is_date_time": is_date_time, "is_dressed": is_dressed, "number": number, "unescaped": unescaped, "canonical": canonical, "COMMENTS": COMMENTS, "SAMPLE": SAMPLE, "SAMPLE_TEXT": SAMPLE_TEXT, "VOTERS": VOTERS, "BLANKS": BLANKS, "_QUOTED_COMMA": _QUOTED_COMMA, "Layout": Layout, "is_comment": is_comment, "split_line": split_line, "_numeric": _numeric, "_score": _score, "find_layout": find_layout, "_sample": _sample, "_refuse_header_only": _refuse_header_only, "_is_data_row": _is_data_row, "_with_header": _with_header, "_is_named_by_values": _is_named_by_values, "_first_missing": _first_missing, "_header_cells": _header_cells, "_last_empty": _last_empty, "_is_units_row": _is_units_row});
});
$.module("dehyst.io.logs", ($m) => {
let annotations, Mapping, dataclass, field, Any, Literal, Array_, Recording, ColumnError, Finding, Samples, drop_unmeasured, find_gaps, choose_clock, refuse_clock, two_columns, with_time_unit, find_column, provenance, PathLike, read_table, order_time, context, cut_window, parse_window, prepare, read_pair, require_samples, samples_of, select_rows, Table, Signal, Columns, read_log, read_signal, read_columns, _refuse_columns, _of_run, _origin;
Mapping = $.from("collections.abc", "Mapping");
dataclass = $.from("dataclasses", "dataclass");field = $.from("dataclasses", "field");
Any = $.from("typing", "Any");Literal = $.from("typing", "Literal");
Array_ = $.from("dehyst.arrays", "Array");
Recording = $.from("dehyst.data.recording", "Recording");
ColumnError = $.from("dehyst.errors", "ColumnError");
Finding = $.from("dehyst.findings", "Finding");
Samples = $.from("dehyst.io.clean", "Samples");drop_unmeasured = $.from("dehyst.io.clean", "drop_unmeasured");find_gaps = $.from("dehyst.io.clean", "find_gaps");
choose_clock = $.from("dehyst.io.clocks", "choose_clock");refuse_clock = $.from("dehyst.io.clocks", "refuse_clock");two_columns = $.from("dehyst.io.clocks", "two_columns");with_time_unit = $.from("dehyst.io.clocks", "with_time_unit");
find_column = $.from("dehyst.io.columns", "find_column");provenance = $.from("dehyst.io.columns", "provenance");
PathLike = $.from("dehyst.io.formats", "PathLike");read_table = $.from("dehyst.io.formats", "read_table");
order_time = $.from("dehyst.io.order", "order_time");
context = $.from("dehyst.io.select", "context");cut_window = $.from("dehyst.io.select", "cut_window");parse_window = $.from("dehyst.io.select", "parse_window");prepare = $.from("dehyst.io.select", "prepare");read_pair = $.from("dehyst.io.select", "read_pair");require_samples = $.from("dehyst.io.select", "require_samples");samples_of = $.from("dehyst.io.select", "samples_of");select_rows = $.from("dehyst.io.select", "select_rows");
Table = $.from("dehyst.io.table", "Table");
Signal = $.cls("Signal", [], "", [["values", null], ["time", null], ["name", null], ["unit", null], ["breaks", () => $.tup()], ["findings", () => $.tup()], ["provenance", () => $.b.dict()]], true, false, ($c) => { Signal = $c; });
Columns = $.cls("Columns", [], "", [["values", null], ["names", null], ["units", null], ["time", null], ["name", null], ["findings", () => $.tup()], ["provenance", () => $.b.dict()]], true, false, ($c) => { Columns = $c; });
read_log = $.def(function (path, input, output, time = null, run = null, start = null, stop = null, time_unit = null) { let table, window, x_name, y_name, about, samples, chosen, clock, x_bare, x_unit, y_bare, y_unit;
table = with_time_unit(read_table(path), time_unit, time);
window = parse_window(start, stop);
{const $v1 = $.unpack(two_columns(table, input, output), 2, -1);x_name = $v1[0];y_name = $v1[1];}
about = context(table, $.tup(x_name, y_name));
{const $v2 = $.unpack(read_pair(table, about, time, run, window), 3, -1);samples = $v2[0];chosen = $v2[1];clock = $v2[2];}
{const $v3 = $.unpack($.tup(table.label(x_name), table.label(y_name)), 2, -1);{const $v4 = $.unpack($v3[0], 2, -1);x_bare = $v4[0];x_unit = $v4[1];}{const $v5 = $.unpack($v3[1], 2, -1);y_bare = $v5[0];y_unit = $v5[1];}}
return $.k(Recording, [], {"input": $.gi($.ga(samples, "values"), 0), "output": $.gi($.ga(samples, "values"), 1), "time": $.ga(samples, "time"), "name": _of_run(table, chosen), "input_name": x_bare, "output_name": y_bare, "input_unit": x_unit, "output_unit": y_unit, "breaks": $.ga(samples, "breaks"), "findings": $.b.tuple($.ga(about, "findings")), "provenance": _origin(table, $.dict([["input", x_name], ["output", y_name], ["time", clock]]), chosen, start, stop, samples)}); }, {p: ["path", "input", "output", "time", "run", "start", "stop", "time_unit"], ks: false});
read_signal = $.def(function (path, column, time = null, run = null, start = null, stop = null, time_unit = null, missing = "hold") { let table, window, name, about, clock, chosen, mask, samples, origin, bare, unit;
table = with_time_unit(read_table(path), time_unit, time);
window = parse_window(start, stop);
name = find_column(table, column, "signal");
refuse_clock(table, name, "signal");
about = context(table, $.tup(name));
clock = choose_clock(table, name, time);
{const $v6 = $.unpack(select_rows(table, name, run), 2, -1);chosen = $v6[0];mask = $v6[1];}
samples = $.k(prepare, [samples_of(table, $.tup(name), clock, mask, about), about, window], {"hold": $.eq(missing, "hold")});
samples = find_gaps(samples, about);
$.k(require_samples, [samples, about, window], {"least": 1});
if ($.t(($.ga(samples, "time") == null))) {about.say("no-time", ("" + $.f($.ga(table, "name"), "", -1) + " has no time column; samples are taken as evenly spaced."));}
origin = _origin(table, $.dict([["column", name], ["time", clock]]), chosen, start, stop, samples);
{const $v7 = $.unpack(table.label(name), 2, -1);bare = $v7[0];unit = $v7[1];}
return Signal($.gi($.ga(samples, "values"), 0), $.ga(samples, "time"), bare, unit, $.ga(samples, "breaks"), $.b.tuple($.ga(about, "findings")), origin); }, {p: ["path", "column", "time", "run", "start", "stop", "time_unit", "missing"], ks: false});
read_columns = $.def(function (path, columns, time = null, run = null, start = null, stop = null, time_unit = null) { let table, window, names, chosen, about, clock, which, mask, samples;
table = with_time_unit(read_table(path), time_unit, time);
window = parse_window(start, stop);
names = $.dict((() => { const $r = []; for (const $v8 of $.it($.cm(columns, "items", []))) { let role, wanted; {const $v9 = $.unpack($v8, 2, -1);role = $v9[0];wanted = $v9[1];} $r.push([role, find_column(table, wanted, role)]); } return $r; })());
_refuse_columns(table, names);
chosen = $.b.tuple($.cm(names, "values", []));
about = context(table, chosen);
clock = choose_clock(table, $.gi(chosen, 0), time);
{const $v10 = $.unpack(select_rows(table, $.gi(chosen, 0), run), 2, -1);which = $v10[0];mask = $v10[1];}
samples = cut_window(samples_of(table, chosen, clock, mask, about), about, window);
samples = order_time(drop_unmeasured(samples, about), about);
return Columns($.b.dict($.k($.b.zip, [names, $.ga(samples, "values")], {"strict": true})), $.dict((() => { const $r = []; for (const $v11 of $.it($.cm(names, "items", []))) { let role, name; {const $v12 = $.unpack($v11, 2, -1);role = $v12[0];name = $v12[1];} $r.push([role, $.gi(table.label(name), 0)]); } return $r; })()), $.dict((() => { const $r = []; for (const $v13 of $.it($.cm(names, "items", []))) { let role, name; {const $v14 = $.unpack($v13, 2, -1);role = $v14[0];name = $v14[1];} $r.push([role, $.gi(table.label(name), 1)]); } return $r; })()), $.ga(samples, "time"), _of_run(table, which), $.b.tuple($.ga(about, "findings")), _origin(table, $.dict([...$.pairs(names), ["time", clock]]), which, start, stop, samples)); }, {p: ["path", "columns", "time", "run", "start", "stop", "time_unit"], ks: false});
_refuse_columns = $.def(function (table, names) { let seen, role, name, sizes, listed;
seen = $.dict([]);
for (const $v15 of $.it($.cm(names, "items", []))) { {const $v16 = $.unpack($v15, 2, -1);role = $v16[0];name = $v16[1];}
{if ($.t($.in(name, seen))) {throw $.exc($.k(ColumnError, [("" + $.f($.gi(seen, name), "", -1) + " and " + $.f(role, "", -1) + " are both column '" + $.f(name, "", -1) + "' of " + $.f($.ga(table, "name"), "", -1) + ". Name two columns.")], {"column": name}));}
$.si(seen, name, role);} }
for (const $v17 of $.it($.cm(names, "items", []))) { {const $v18 = $.unpack($v17, 2, -1);role = $v18[0];name = $v18[1];}
{refuse_clock(table, name, role);} }
sizes = $.dict((() => { const $r = []; for (const $v19 of $.it(seen)) { let name; name = $v19; $r.push([name, $.ga($.gi($.ga(table, "columns"), name), "size")]); } return $r; })());
if ($.t($.gt($.b.len($.b.set($.cm(sizes, "values", []))), 1))) {listed = $.cm(", ", "join", [(function* () { for (const $v20 of $.it($.cm(sizes, "items", []))) { let name, size; {const $v21 = $.unpack($v20, 2, -1);name = $v21[0];size = $v21[1];} yield ("" + $.f(name, "", -1) + " " + $.f(size, "", -1)); } })()]);
throw $.exc($.k(ColumnError, [("" + "columns of " + $.f($.ga(table, "name"), "", -1) + " differ in length (" + $.f(listed, "", -1) + "): they were logged on clocks of their own. Write them into one table first, a row for each instant.")], {"sizes": sizes}));} }, {p: ["table", "names"], ks: false});
_of_run = $.def(function (table, run) { 
return ($.t((run == null)) ? $.ga(table, "name") : ("" + $.f($.ga(table, "name"), "", -1) + ", run " + $.f(run, "", -1))); }, {p: ["table", "run"], ks: false});
_origin = $.def(function (table, columns, run, start, stop, samples) { let rows;
rows = $.ga(samples, "rows");
return provenance(table, columns, run, [start, stop], $.tup($.b.int($.ga(rows, "size")), $.b.int(rows.min()), $.b.int(rows.max()))); }, {p: ["table", "columns", "run", "start", "stop", "samples"], ks: false});
Object.assign($m, {"annotations": annotations, "Mapping": Mapping, "dataclass": dataclass, "field": field, "Any": Any, "Literal": Literal, "Array": Array_, "Recording": Recording, "ColumnError": ColumnError, "Finding": Finding, "Samples": Samples, "drop_unmeasured": drop_unmeasured, "find_gaps": find_gaps, "choose_clock": choose_clock, "refuse_clock": refuse_clock, "two_columns": two_columns, "with_time_unit": with_time_unit, "find_column": find_column, "provenance": provenance, "PathLike": PathLike, "read_table": read_table, "order_time": order_time, "context": context, "cut_window": cut_window, "parse_window": parse_window, "prepare": prepare, "read_pair": read_pair, "require_samples": require_samples, "samples_of": samples_of, "select_rows": select_rows, "Table": Table, "Signal": Signal, "Columns": Columns, "read_log": read_log, "read_signal": read_signal, "read_columns": read_columns, "_refuse_columns": _refuse_columns, "_of_run": _of_run, "_origin": _origin});
});
$.module("dehyst.io.order", ($m) => {
let annotations, replace, NamedTuple, np, Array_, Rows, gap_limit, taken_back, turning_points, TimeError, Context, Samples, list_rows, MAX_RESTARTS, FEW, NEAREST, COARSE_SHARE, order_time, _stamps, _turn_around, _sort_few, _put_in_order, _sort_swapped, _drop_stray, _drop_doubled, _spread_repeated, _typical_step, JUMPS_MOST, JUMPS_SHARE, FEWEST, BEND, STEP, USUAL, MOVING, UNSEEN, mend_jumps, _Usual;
replace = $.from("dataclasses", "replace");
NamedTuple = $.from("typing", "NamedTuple");
np = $.imp("numpy");
Array_ = $.from("dehyst.arrays", "Array");Rows = $.from("dehyst.arrays", "Rows");
gap_limit = $.from("dehyst.data.loops", "gap_limit");taken_back = $.from("dehyst.data.loops", "taken_back");turning_points = $.from("dehyst.data.loops", "turning_points");
TimeError = $.from("dehyst.errors", "TimeError");
Context = $.from("dehyst.io.clean", "Context");Samples = $.from("dehyst.io.clean", "Samples");
list_rows = $.from("dehyst.io.table", "list_rows");
MAX_RESTARTS = 50;
FEW = 0.01;
NEAREST = 10;
COARSE_SHARE = 0.5;
order_time = $.def(function (samples, about) { let time, restarts;
if (($.t(($.ga(samples, "time") == null)) || $.t($.lt($.ga($.ga(samples, "time"), "size"), 2)))) {return samples;}
if ($.t(np.all($.gt(np.diff($.ga(samples, "time")), 0)))) {return mend_jumps(samples, about);}
samples = _turn_around(samples, about);
samples = _sort_few(samples, about);
samples = _sort_swapped(samples, about);
samples = _drop_stray(samples, about);
samples = mend_jumps(samples, about);
samples = _drop_doubled(samples, about);
samples = _spread_repeated(samples, about);
time = _stamps(samples);
restarts = $.add(np.flatnonzero($.lt(np.diff(time), 0)), 1);
if ($.t($.eq($.ga(restarts, "size"), 0))) {return samples;}
if (($.t($.gt($.ga(restarts, "size"), MAX_RESTARTS)) && $.t($.gt($.ga(restarts, "size"), $.mul(0.01, $.ga(time, "size")))))) {throw $.exc($.k(TimeError, [("" + "time stamps of " + $.f($.ga(about, "log"), "", -1) + " run backward " + $.f($.ga(restarts, "size"), "", -1) + " times in " + $.f($.ga(time, "size"), "", -1) + " rows, first at " + $.f(list_rows($.gi($.ga(samples, "rows"), restarts), $.ga(about, "word")), "", -1) + ". The order of the samples is the memory of the actuator, so it is not guessed. Sort the log by time, or name another time column with --time.")], {"rows": $.gi($.ga(samples, "rows"), restarts)}));}
about.say("clock-restart", ("" + "the clock of " + $.f($.ga(about, "log"), "", -1) + " jumps back at " + $.f(list_rows($.gi($.ga(samples, "rows"), restarts), $.ga(about, "word")), "", -1) + ": several recordings follow each other. Each is treated as a piece of its own, with unknown memory at its start. Better split the log, or add a column run."));
return $.k(replace, [samples], {"breaks": $.b.tuple((function* () { for (const $v1 of $.it(restarts)) { let k; k = $v1; yield $.b.int(k); } })())}); }, {p: ["samples", "about"], ks: false});
_stamps = $.def(function (samples) { 
return $.ga(samples, "time"); }, {p: ["samples"], ks: false});
_turn_around = $.def(function (samples, about) { let step;
step = np.diff(_stamps(samples));
if (($.t($.lt($.ga(step, "size"), 3)) || !$.t($.gt(np.mean($.lt(step, 0)), 0.95)))) {return samples;}
about.say("reversed-time", ("" + $.f($.ga(about, "log"), "", -1) + " is written newest row first; it was turned around. Nothing to do."));
return samples.take(np.arange($.sub($.ga($.ga(samples, "rows"), "size"), 1), (-1), (-1))); }, {p: ["samples", "about"], ks: false});
_sort_few = $.def(function (samples, about) { let t, late, order, moved, step, typical, touched;
t = _stamps(samples);
late = np.flatnonzero($.lt(t, $.ga(np, "maximum").accumulate(t)));
if (($.t($.eq($.ga(late, "size"), 0)) || $.t($.gt($.ga(late, "size"), $.b.max(1, $.mul(FEW, $.ga(t, "size"))))))) {return samples;}
order = $.km(np, "argsort", [t], {"kind": "stable"});
moved = np.abs($.sub(order, np.arange($.ga(t, "size"))));
if ($.t($.gt(moved.max(), $.b.max(NEAREST, $.mul(FEW, $.ga(t, "size")))))) {return samples;}
step = np.diff($.gi(t, order));
typical = $.b.float(np.median(step));
touched = $.gi(step, $.bor($.gt($.gi(moved, $.slice(1, null, null)), 0), $.gt($.gi(moved, $.slice(null, (-1), null)), 0)));
if (($.t($.lt(touched.min(), $.mul(0.6, typical))) || $.t($.gt(touched.max(), $.mul(4.0, typical))))) {return samples;}
return _put_in_order(samples, order, late, about); }, {p: ["samples", "about"], ks: false});
_put_in_order = $.def(function (samples, order, late, about) { let many;
many = $.gt($.ga(late, "size"), 1);
about.say("swapped-rows", ("" + $.f($.ga(late, "size"), "", -1) + " row" + $.f(($.t(many) ? "s" : ""), "", -1) + " of " + $.f($.ga(about, "log"), "", -1) + " " + $.f(($.t(many) ? "stand" : "stands"), "", -1) + " after rows that follow " + $.f(($.t(many) ? "them" : "it"), "", -1) + " in time (" + $.f(list_rows($.gi($.ga(samples, "rows"), late), $.ga(about, "word")), "", -1) + "); they were put in order. Nothing to do."));
return samples.take(order); }, {p: ["samples", "order", "late", "about"], ks: false});
_sort_swapped = $.def(function (samples, about) { let t, order, swapped, k, before, after, typical, far;
t = _stamps(samples);
order = np.arange($.ga(t, "size"));
swapped = [];
for (const $v2 of $.it($.add(np.flatnonzero($.lt(np.diff(t), 0)), 1).tolist())) { k = $v2;
{before = ($.t($.ge(k, 2)) ? $.gi(t, $.sub(k, 2)) : $.neg($.ga(np, "inf")));
after = ($.t($.lt($.add(k, 1), $.ga(t, "size"))) ? $.gi(t, $.add(k, 1)) : $.ga(np, "inf"));
if (($.t($.lt(before, $.gi(t, k))) && $.t($.lt($.gi(t, $.sub(k, 1)), after)) && !($.t($.ge(k, 2)) && $.t($.ne($.gi(order, $.sub(k, 1)), $.sub(k, 1)))))) {{const $v3 = $.unpack($.tup(k, $.sub(k, 1)), 2, -1);$.si(order, $.sub(k, 1), $v3[0]);$.si(order, k, $v3[1]);}
$.cm(swapped, "append", [k]);}} }
typical = _typical_step(t);
far = (() => { const $r = []; for (const $v4 of $.it(swapped)) { let k; k = $v4; if ($.t($.gt($.sub($.gi(t, $.sub(k, 1)), $.gi(t, k)), $.mul(10, typical)))) { $r.push(k); } } return $r; })();
for (const $v5 of $.it(far)) { k = $v5;
{{const $v6 = $.unpack($.tup($.sub(k, 1), k), 2, -1);$.si(order, $.sub(k, 1), $v6[0]);$.si(order, k, $v6[1]);}} }
swapped = (() => { const $r = []; for (const $v7 of $.it(swapped)) { let k; k = $v7; if ($.t(!$.in(k, $.b.set(far)))) { $r.push(k); } } return $r; })();
if (!$.t(swapped)) {return samples;}
return _put_in_order(samples, order, np.array(swapped), about); }, {p: ["samples", "about"], ks: false});
_drop_stray = $.def(function (samples, about) { let t, typical, stray, k, index;
t = _stamps(samples);
typical = _typical_step(t);
stray = $.b.set();
for (const $v8 of $.it($.add(np.flatnonzero($.lt(np.diff(t), 0)), 1).tolist())) { k = $v8;
{if (($.t($.ge(k, 2)) && $.t((($t0, $t1) => $.t($.lt(0, ($t0 = $.sub($.gi(t, k), $.gi(t, $.sub(k, 2)))))) && $.t($.le($t0, $.mul(4, typical))))()))) {$.cm(stray, "add", [$.sub(k, 1)]);} else {if (($.t($.lt($.add(k, 1), $.ga(t, "size"))) && $.t((($t0, $t1) => $.t($.lt(0, ($t0 = $.sub($.gi(t, $.add(k, 1)), $.gi(t, $.sub(k, 1)))))) && $.t($.le($t0, $.mul(4, typical))))()))) {$.cm(stray, "add", [k]);}}} }
if (!$.t(stray)) {return samples;}
index = np.array($.b.sorted(stray));
about.say("stray-time", ("" + $.f($.ga(index, "size"), "", -1) + " time stamps of " + $.f($.ga(about, "log"), "", -1) + " fit neither the one before nor the one after (" + $.f(list_rows($.gi($.ga(samples, "rows"), index), $.ga(about, "word")), "", -1) + "); these rows were left out. Check the logger if there are many."));
return samples.take(np.delete(np.arange($.ga(t, "size")), index)); }, {p: ["samples", "about"], ks: false});
_drop_doubled = $.def(function (samples, about) { let t, repeated, same, doubled, coarse;
t = _stamps(samples);
repeated = np.concatenate($.tup([false], $.eq(np.diff(t), 0)));
same = $.ga(np, "logical_and").reduce((() => { const $r = []; for (const $v9 of $.it($.ga(samples, "values"))) { let v; v = $v9; $r.push(np.concatenate($.tup([false], $.eq(np.diff(v), 0)))); } return $r; })());
doubled = $.band(repeated, same);
coarse = $.and($.ge(repeated.sum(), $.mul(COARSE_SHARE, $.ga(t, "size"))), () => $.lt(doubled.sum(), $.mul(0.9, repeated.sum())));
if ((!$.t(doubled.any()) || $.t(coarse))) {return samples;}
about.say("repeated-time", ("" + $.f($.b.int(doubled.sum()), "", -1) + " of " + $.f($.ga(t, "size"), "", -1) + " rows of " + $.f($.ga(about, "log"), "", -1) + " repeat the time stamp and the values before them (" + $.f(list_rows($.gi($.ga(samples, "rows"), doubled), $.ga(about, "word")), "", -1) + "); the first of each was kept. Nothing is lost."));
return samples.take($.inv(doubled)); }, {p: ["samples", "about"], ks: false});
_spread_repeated = $.def(function (samples, about) { let t, starts, counts, usual, many, width, place, begin, spread, shared;
t = _stamps(samples);
starts = np.concatenate($.tup([0], $.add(np.flatnonzero($.ne(np.diff(t), 0)), 1)));
if (($.t($.eq($.ga(starts, "size"), $.ga(t, "size"))) || $.t($.lt($.ga(starts, "size"), 2)))) {return samples;}
counts = np.diff(np.concatenate($.tup(starts, [$.ga(t, "size")])));
{const $v10 = $.unpack($.tup(_typical_step(t), $.b.float(np.median(counts))), 2, -1);usual = $v10[0];many = $v10[1];}
width = $.cm(np, "append", [np.diff($.gi(t, starts)), usual]);
width = np.where($.bor($.le(width, 0), $.gt(width, usual)), usual, width);
$.si(width, (-1), $.mul(usual, $.b.min(1.0, $.div($.gi(counts, (-1)), many))));
place = $.sub(np.arange($.ga(t, "size")), np.repeat(starts, counts));
begin = $.cm($.gi(t, starts), "copy", []);
if (($.t($.gt(many, 1)) && $.t($.lt($.gi(counts, 0), many)))) {$.isi(begin, 0, $.iadd, $.mul(usual, $.sub(1.0, $.div($.gi(counts, 0), many))));
$.si(width, 0, $.div($.mul(usual, $.gi(counts, 0)), many));}
spread = $.add(np.repeat(begin, counts), $.mul(place, np.repeat($.div(width, counts), counts)));
shared = $.b.int($.sub($.ga(t, "size"), $.ga(starts, "size")));
about.say("coarse-time", ("" + $.f(shared, "", -1) + " of " + $.f($.ga(t, "size"), "", -1) + " rows of " + $.f($.ga(about, "log"), "", -1) + " share the time stamp of the row before them, in groups of up to " + $.f($.b.int(counts.max()), "", -1) + " (first at " + $.f(list_rows($.gi($.ga(samples, "rows"), $.gi(starts, $.gt(counts, 1))), $.ga(about, "word")), "", -1) + "): the clock is coarser than the sampling, " + $.f(usual, ("" + ".4g"), -1) + " s against about " + $.f(_typical_step(spread), ("" + ".3g"), -1) + " s. The rows of each group were spread evenly over its time. Rates are only as good as that; log time with more digits."));
return $.k(replace, [samples], {"time": spread}); }, {p: ["samples", "about"], ks: false});
_typical_step = $.def(function (t) { let step;
step = np.diff(t);
step = $.gi(step, $.gt(step, 0));
return ($.t($.ga(step, "size")) ? $.b.float(np.median(step)) : 0.0); }, {p: ["t"], ks: false});
{const $v11 = $.unpack($.tup(6, 0.01), 2, -1);JUMPS_MOST = $v11[0];JUMPS_SHARE = $v11[1];}
FEWEST = 32;
BEND = 2.0;
STEP = 0.25;
USUAL = 2.0;
MOVING = 10.0;
UNSEEN = 1.0;
mend_jumps = $.def(function (samples, about) { let t, step, typical, places, size, shift, usual, k, m, smooth, late, mended, at, by, shown;
t = $.ga(samples, "time");
if (($.t((t == null)) || $.t($.lt($.ga(t, "size"), FEWEST)))) {return samples;}
step = np.diff(t);
typical = ($.t(np.any($.gt(step, 0))) ? $.b.float(np.median($.gi(step, $.gt(step, 0)))) : 0.0);
places = $.add(np.flatnonzero($.bor($.lt(step, 0.0), $.gt(step, gap_limit(step)))), 1);
if (($.t($.eq(typical, 0.0)) || !$.t((($t0, $t1) => $.t($.lt(0, ($t0 = $.ga(places, "size")))) && $.t($.le($t0, $.b.max(JUMPS_MOST, $.mul(JUMPS_SHARE, $.ga(step, "size"))))))()))) {return samples;}
size = $.sub($.gi(step, $.sub(places, 1)), typical);
shift = np.zeros($.ga(places, "size"));
usual = (() => { const $r = []; for (const $v12 of $.it($.ga(samples, "values"))) { let v; v = $v12; $r.push(_Usual.of(v, places)); } return $r; })();
for (const $v13 of $.it(taken_back(places, size, $.ga(t, "size")))) { {const $v14 = $.unpack($v13, 2, -1);k = $v14[0];m = $v14[1];}
{if ($.t($.b.all((function* () { for (const $v15 of $.it($.k($.b.zip, [usual, $.ga(samples, "values")], {"strict": true}))) { let about_v, v; {const $v16 = $.unpack($v15, 2, -1);about_v = $v16[0];v = $v16[1];} yield about_v.goes_on(v, $.gi(places, [k, m])); } })()))) {$.si(shift, [k, m], $.tup($.gi(size, k), $.neg($.gi(size, k))));}} }
for (const $v17 of $.it(np.flatnonzero($.eq(shift, 0.0)).tolist())) { k = $v17;
{smooth = $.b.all((function* () { for (const $v18 of $.it($.k($.b.zip, [usual, $.ga(samples, "values")], {"strict": true}))) { let about_v, v; {const $v19 = $.unpack($v18, 2, -1);about_v = $v19[0];v = $v19[1];} yield about_v.is_smooth(v, $.gi(places, k)); } })());
if (($.t(smooth) && $.t($.gi(usual, 0).moves($.gi($.ga(samples, "values"), 0), $.gi(places, k), $.div($.b.abs($.gi(size, k)), typical))))) {$.si(shift, k, $.gi(size, k));}} }
if (!$.t(shift.any())) {return samples;}
if ($.t($.gt($.mul(2, np.count_nonzero(shift)), $.ga(places, "size")))) {for (const $v20 of $.it(np.flatnonzero($.eq(shift, 0.0)).tolist())) { k = $v20;
{if ($.t($.b.all((function* () { for (const $v21 of $.it($.k($.b.zip, [usual, $.ga(samples, "values")], {"strict": true}))) { let about_v, v; {const $v22 = $.unpack($v21, 2, -1);about_v = $v22[0];v = $v22[1];} yield about_v.goes_on(v, $.gi(places, [k])); } })()))) {$.si(shift, k, $.gi(size, k));}} }}
late = np.zeros($.ga(t, "size"));
$.si(late, places, shift);
mended = $.sub(t, np.cumsum(late));
{const $v23 = $.unpack($.tup($.gi(places, $.ne(shift, 0.0)), $.gi(size, $.ne(shift, 0.0))), 2, -1);at = $v23[0];by = $v23[1];}
shown = $.add($.cm(", ", "join", [(function* () { for (const $v24 of $.it($.gi(by, $.slice(null, 4, null)).tolist())) { let value; value = $v24; yield ("" + $.f(value, ("" + "+.4g"), -1) + " s"); } })()]), ($.t($.gt($.ga(by, "size"), 4)) ? ", ..." : ""));
about.say("clock-jump", ("" + "the clock of " + $.f($.ga(about, "log"), "", -1) + " jumps at " + $.f(list_rows($.gi($.ga(samples, "rows"), at), $.ga(about, "word")), "", -1) + " (by " + $.f(shown, "", -1) + ") while " + $.f($.cm(" and ", "join", [$.ga(about, "columns")]), "", -1) + " " + $.f(($.t($.gt($.b.len($.ga(about, "columns")), 1)) ? "go" : "goes"), "", -1) + " on smoothly: the clock was set, the log was not interrupted. The " + $.f(($.t($.gt($.ga(at, "size"), 1)) ? "jumps were" : "jump was"), "", -1) + " taken out, and memory goes on. Nothing to do; a clock that only counts up (monotonic) does not jump."));
return $.k(replace, [samples], {"time": mended}); }, {p: ["samples", "about"], ks: false});
_Usual = $.cls("_Usual", [], "NamedTuple", [["step", null], ["largest", null], ["bend", null], ["quiet", null], ["window", null]], false, true, ($c) => { _Usual = $c; $.cmeth($c, "of", $.def(function (v, places) { const cls = this;let step, bend, beside, swings, moved;
{const $v25 = $.unpack($.tup(np.abs(np.diff(v)), np.abs(np.diff(v, 2))), 2, -1);step = $v25[0];bend = $v25[1];}
beside = np.concatenate([$.sub(places, 1), $.sub(places, 2)]);
step = np.delete(step, $.sub(places, 1));
bend = np.delete(bend, $.gi(beside, $.band($.ge(beside, 0), $.lt(beside, $.ga(bend, "size")))));
swings = $.b.max(1, $.sub($.ga(turning_points(v), "size"), 1));
moved = $.gi(step, $.gt(step, 0.0));
return cls(($.t($.ga(moved, "size")) ? $.b.float(np.median(moved)) : 0.0), $.b.float(np.quantile(step, 0.99)), $.b.float(np.quantile(bend, 0.95)), $.b.float(np.median(bend)), $.b.max(20, $.fdiv($.fdiv($.ga(v, "size"), swings), 10))); }, {p: ["v", "places"], ks: false}));
$.meth($c, "goes_on", $.def(function (v, places) { const self = this;
return $.b.bool(np.all($.le(np.abs($.sub($.gi(v, places), $.gi(v, $.sub(places, 1)))), $.mul(USUAL, $.ga(self, "largest"))))); }, {p: ["v", "places"], ks: false}));
$.meth($c, "is_smooth", $.def(function (v, place) { const self = this;let near;
near = $.gi(v, $.slice($.b.max($.sub(place, 2), 0), $.add(place, 2), null));
return $.and($.eq($.ga(near, "size"), 4), () => $.b.bool($.le(np.max(np.abs(np.diff(near, 2))), $.add($.mul(BEND, $.ga(self, "bend")), $.mul(STEP, $.ga(self, "step")))))); }, {p: ["v", "place"], ks: false}));
$.meth($c, "moves", $.def(function (v, place, missing) { const self = this;let before, after, least, gone;
{const $v26 = $.unpack($.tup($.gi(v, $.slice($.b.max($.sub(place, $.ga(self, "window")), 0), place, null)), $.gi(v, $.slice(place, $.add(place, $.ga(self, "window")), null))), 2, -1);before = $v26[0];after = $v26[1];}
least = $.b.min($.b.float(np.ptp(before)), $.b.float(np.ptp(after)));
gone = $.div($.mul($.b.min(missing, $.ga(self, "window")), least), $.ga(self, "window"));
return $.and($.gt(least, $.mul(MOVING, $.ga(self, "quiet"))), () => $.gt(gone, $.mul(UNSEEN, $.ga(self, "step")))); }, {p: ["v", "place", "missing"], ks: false}));});
Object.assign($m, {"annotations": annotations, "replace": replace, "NamedTuple": NamedTuple, "np": np, "Array": Array_, "Rows": Rows, "gap_limit": gap_limit, "taken_back": taken_back, "turning_points": turning_points, "TimeError": TimeError, "Context": Context, "Samples": Samples, "list_rows": list_rows, "MAX_RESTARTS": MAX_RESTARTS, "FEW": FEW, "NEAREST": NEAREST, "COARSE_SHARE": COARSE_SHARE, "order_time": order_time, "_stamps": _stamps, "_turn_around": _turn_around, "_sort_few": _sort_few, "_put_in_order": _put_in_order, "_sort_swapped": _sort_swapped, "_drop_stray": _drop_stray, "_drop_doubled": _drop_doubled, "_spread_repeated": _spread_repeated, "_typical_step": _typical_step, "JUMPS_MOST": JUMPS_MOST, "JUMPS_SHARE": JUMPS_SHARE, "FEWEST": FEWEST, "BEND": BEND, "STEP": STEP, "USUAL": USUAL, "MOVING": MOVING, "UNSEEN": UNSEEN, "mend_jumps": mend_jumps, "_Usual": _Usual});
});
$.module("dehyst.io.plain", ($m) => {
let annotations, Sequence, dataclass, Any, np, npt, _native, Array_, Rows, comma_number, is_date_time, is_dressed, number, BLANKS, Layout, split_line, PROBE, LABEL_WIDTH, NUMBERISH, MOST_BLOCKS, SPARE, Labels, Plain, Part, find_plain, _looks_like_number, _is_label, _are_labels, _may_be_thousands, read_part, read_plain, keeps_whole, _room;
Sequence = $.from("collections.abc", "Sequence");
dataclass = $.from("dataclasses", "dataclass");
Any = $.from("typing", "Any");
np = $.imp("numpy");
npt = $.imp("numpy.typing");
_native = $.imp("dehyst._native");
Array_ = $.from("dehyst.arrays", "Array");Rows = $.from("dehyst.arrays", "Rows");
comma_number = $.from("dehyst.io.cells", "comma_number");is_date_time = $.from("dehyst.io.cells", "is_date_time");is_dressed = $.from("dehyst.io.cells", "is_dressed");number = $.from("dehyst.io.cells", "number");
BLANKS = $.from("dehyst.io.layout", "BLANKS");Layout = $.from("dehyst.io.layout", "Layout");split_line = $.from("dehyst.io.layout", "split_line");
PROBE = 200;
LABEL_WIDTH = 64;
NUMBERISH = "+-(.,0123456789";
MOST_BLOCKS = 4096;
SPARE = 1.05;
Labels = $.gi($.ga(npt, "NDArray"), $.ga(np, "str_"));
Plain = $.cls("Plain", [], "", [["delimiter", null], ["decimal", null], ["letters", null], ["whole", () => $.tup()], ["missing", () => false], ["doubtful", () => $.tup()]], true, true, ($c) => { Plain = $c; });
Part = $.cls("Part", [], "", [["columns", null], ["rows", null], ["lines", null], ["bytes", null], ["column", null], ["empty", null], ["odd", null]], true, true, ($c) => { Part = $c; });
find_plain = $.def(function (body, layout) { let probe, columns, whole, texts, doubtful, width, letters, missing;
if ((!$.t(body) || $.t($.in("\"", $.gi(body, 0))) || ($.t($.ga(layout, "decimal_comma")) && $.t($.eq($.ga(layout, "delimiter"), ","))))) {return null;}
probe = (() => { const $r = []; for (const $v1 of $.it($.gi(body, $.slice(null, PROBE, null)))) { let line; line = $v1; $r.push(split_line(line, $.ga(layout, "delimiter"))); } return $r; })();
if ($.t($.b.any((function* () { for (const $v2 of $.it(probe)) { let row; row = $v2; yield $.ne($.b.len(row), $.ga(layout, "width")); } })()))) {return null;}
columns = $.b.range($.ga(layout, "width"));
whole = $.tup();
if ($.t($.ga(layout, "decimal_comma"))) {if ($.t($.b.any((function* () { for (const $v4 of $.it(columns)) { let j; j = $v4; yield _may_be_thousands((() => { const $r = []; for (const $v3 of $.it(probe)) { let row; row = $v3; $r.push($.gi(row, j)); } return $r; })()); } })()))) {return null;}
if ($.t($.b.any((function* () { for (const $v5 of $.it($.gi(body, $.slice(null, PROBE, null)))) { let line; line = $v5; yield $.in(".", line); } })()))) {return null;}
whole = $.b.tuple((function* () { for (const $v7 of $.it(columns)) { let j; j = $v7; if (!$.t($.b.any((function* () { for (const $v6 of $.it(probe)) { let row; row = $v6; yield $.in(",", $.gi(row, j)); } })()))) { yield j; } } })());
probe = (() => { const $r = []; for (const $v9 of $.it(probe)) { let row; row = $v9; $r.push((() => { const $r = []; for (const $v8 of $.it(row)) { let cell; cell = $v8; $r.push($.cm(cell, "replace", [",", "."])); } return $r; })()); } return $r; })();}
texts = $.b.set((() => { const $r = []; for (const $v11 of $.it(columns)) { let j; j = $v11; if ($.t($.b.all((function* () { for (const $v10 of $.it(probe)) { let row; row = $v10; yield (number($.gi(row, j)) == null); } })()))) { $r.push(j); } } return $r; })());
if (($.t(texts) && $.t($.ga(layout, "decimal_comma")))) {return null;}
doubtful = $.b.tuple((function* () { for (const $v13 of $.it(texts)) { let j; j = $v13; if ($.t($.b.any((function* () { for (const $v12 of $.it(probe)) { let row; row = $v12; yield _looks_like_number($.gi(row, j)); } })()))) { yield j; } } })());
if (!$.t($.b.all((function* () { for (const $v16 of $.it(doubtful)) { let j; j = $v16; for (const $v14 of $.it($.b.set((() => { const $r = []; for (const $v15 of $.it(probe)) { let row; row = $v15; $r.push($.gi(row, j)); } return $r; })()))) { let cell; cell = $v14; yield _is_label(cell); } } })()))) {return null;}
width = $.b.min(LABEL_WIDTH, $.add(8, $.k($.b.max, [(function* () { for (const $v18 of $.it(probe)) { let row; row = $v18; for (const $v17 of $.it(texts)) { let j; j = $v17; yield $.b.len($.gi(row, j)); } } })()], {"default": 0})));
letters = $.b.tuple((function* () { for (const $v19 of $.it(columns)) { let j; j = $v19; yield ($.t($.in(j, texts)) ? width : 0); } })());
missing = !($.t($.ga(layout, "decimal_comma")) || $.t($.eq($.ga(layout, "delimiter"), BLANKS)));
return Plain($.ga(layout, "delimiter"), ($.t($.ga(layout, "decimal_comma")) ? "," : "."), letters, whole, missing, doubtful); }, {p: ["body", "layout"], ks: false});
_looks_like_number = $.def(function (cell) { 
return $.and($.in($.gi($.cm(cell, "strip", []), $.slice(null, 1, null)), NUMBERISH), () => !$.t(is_date_time(cell))); }, {p: ["cell"], ks: false});
_is_label = $.def(function (cell) { let text;
text = $.cm(cell, "strip", []);
if (($.t($.in(",", text)) || $.t($.cm(text, "startswith", ["("])) || $.t(is_dressed(text)))) {return false;}
return $.or(!$.t(text), () => !($.t(is_date_time(text)) || $.t((comma_number(text) != null)))); }, {p: ["cell"], ks: false});
_are_labels = $.def(function (column) { let starts;
starts = np.flatnonzero(np.concatenate($.tup([true], $.ne($.gi(column, $.slice(1, null, null)), $.gi(column, $.slice(null, (-1), null))))));
return $.and($.le($.ga(starts, "size"), MOST_BLOCKS), () => $.b.all($.b.map(_is_label, $.b.set($.gi(column, starts).tolist())))); }, {p: ["column"], ks: false});
_may_be_thousands = $.def(function (column) { let tails;
tails = $.b.set((() => { const $r = []; for (const $v20 of $.it(column)) { let cell; cell = $v20; if ($.t($.in(",", cell))) { $r.push($.b.len($.cm($.gi($.cm(cell, "partition", [","]), 2), "strip", []))); } } return $r; })());
return $.eq(tails, $.b.set([3])); }, {p: ["column"], ks: false});
read_part = $.def(function (text, offset, line, plain, capacity) { let columns, rows, count, lines, used, column, empty, odd, cut;
columns = (() => { const $r = []; for (const $v21 of $.it($.ga(plain, "letters"))) { let k; k = $v21; $r.push(($.t(k) ? np.empty($.tup(capacity, k), $.ga(np, "uint32")) : np.empty(capacity))); } return $r; })();
rows = $.km(np, "empty", [capacity], {"dtype": $.ga(np, "int64")});
{const $v22 = $.unpack(_native.text_read(text, offset, line, $.ga(plain, "delimiter"), $.ga(plain, "decimal"), $.b.list($.ga(plain, "letters")), columns, rows, $.ga(plain, "missing")), 6, -1);count = $v22[0];lines = $v22[1];used = $v22[2];column = $v22[3];empty = $v22[4];odd = $v22[5];}
cut = (() => { const $r = []; for (const $v23 of $.it($.k($.b.zip, [columns, $.ga(plain, "letters")], {"strict": true}))) { let v, k; {const $v24 = $.unpack($v23, 2, -1);v = $v24[0];k = $v24[1];} $r.push(($.t(k) ? $.gi($.gi(v, $.slice(null, count, null)).view(("" + "U" + $.f(k, "", -1))), $.tup($.slice(null, null, null), 0)) : $.gi(v, $.slice(null, count, null)))); } return $r; })();
return Part(cut, $.gi(rows, $.slice(null, count, null)), lines, used, column, empty, odd); }, {p: ["text", "offset", "line", "plain", "capacity"], ks: false});
read_plain = $.def(function (text, offset, line, plain) { let parts, part, columns, rows, empty, unsure;
parts = [];
while ($.t($.lt(offset, $.b.len(text)))) {part = read_part(text, offset, line, plain, _room(text, offset));
if ($.t($.ge($.ga(part, "column"), 0))) {return null;}
{const $v25 = $.unpack($.tup($.add(offset, $.ga(part, "bytes")), $.add(line, $.ga(part, "lines"))), 2, -1);offset = $v25[0];line = $v25[1];}
$.cm(parts, "append", [part]);}
if ((!$.t($.b.any((function* () { for (const $v26 of $.it(parts)) { let part; part = $v26; yield $.ga($.ga(part, "rows"), "size"); } })())) || ($.t($.b.any((function* () { for (const $v27 of $.it(parts)) { let p; p = $v27; yield $.ga(p, "empty"); } })())) && $.t($.b.any((function* () { for (const $v28 of $.it(parts)) { let p; p = $v28; yield $.ga(p, "odd"); } })()))))) {return null;}
if ($.t($.eq($.b.len(parts), 1))) {{const $v29 = $.unpack($.tup($.ga($.gi(parts, 0), "columns"), $.ga($.gi(parts, 0), "rows")), 2, -1);columns = $v29[0];rows = $v29[1];}} else {columns = (() => { const $r = []; for (const $v30 of $.it($.k($.b.zip, [...$.it((function* () { for (const $v31 of $.it(parts)) { let p; p = $v31; yield $.ga(p, "columns"); } })())], {"strict": true}))) { let column; column = $v30; $r.push(np.concatenate(column)); } return $r; })();
rows = np.concatenate((() => { const $r = []; for (const $v32 of $.it(parts)) { let p; p = $v32; $r.push($.ga(p, "rows")); } return $r; })());}
empty = $.b.any((function* () { for (const $v33 of $.it(parts)) { let p; p = $v33; yield $.ga(p, "empty"); } })());
unsure = (() => { const $r = []; for (const $v34 of $.it($.b.enumerate($.ga(plain, "letters")))) { let j, k; {const $v35 = $.unpack($v34, 2, -1);j = $v35[0];k = $v35[1];} if (($.t(k) && ($.t(empty) || $.t($.in(j, $.ga(plain, "doubtful")))))) { $r.push(j); } } return $r; })();
if ((!$.t(keeps_whole(columns, plain)) || !$.t($.b.all((function* () { for (const $v36 of $.it(unsure)) { let j; j = $v36; yield _are_labels($.gi(columns, j)); } })())))) {return null;}
return $.tup(columns, rows); }, {p: ["text", "offset", "line", "plain"], ks: false});
keeps_whole = $.def(function (columns, plain) { 
return !$.t($.b.any((function* () { for (const $v37 of $.it($.ga(plain, "whole"))) { let j; j = $v37; yield $.ne($.gi(columns, j), np.round($.gi(columns, j))).any(); } })())); }, {p: ["columns", "plain"], ks: false});
_room = $.def(function (text, offset) { let head;
head = $.gi(text, $.slice(offset, $.add(offset, $.shl(1, 16)), null));
return $.add($.b.int($.div($.mul($.mul(SPARE, _native.text_lines(head)), $.sub($.b.len(text), offset)), $.b.len(head))), 64); }, {p: ["text", "offset"], ks: false});
Object.assign($m, {"annotations": annotations, "Sequence": Sequence, "dataclass": dataclass, "Any": Any, "np": np, "npt": npt, "_native": _native, "Array": Array_, "Rows": Rows, "comma_number": comma_number, "is_date_time": is_date_time, "is_dressed": is_dressed, "number": number, "BLANKS": BLANKS, "Layout": Layout, "split_line": split_line, "PROBE": PROBE, "LABEL_WIDTH": LABEL_WIDTH, "NUMBERISH": NUMBERISH, "MOST_BLOCKS": MOST_BLOCKS, "SPARE": SPARE, "Labels": Labels, "Plain": Plain, "Part": Part, "find_plain": find_plain, "_looks_like_number": _looks_like_number, "_is_label": _is_label, "_are_labels": _are_labels, "_may_be_thousands": _may_be_thousands, "read_part": read_part, "read_plain": read_plain, "keeps_whole": keeps_whole, "_room": _room});
});
$.module("dehyst.io.select", ($m) => {
let annotations, math, replace, np, npt, Array_, gap_limit, MINIMUM_SAMPLES, ColumnError, RecordingError, TimeError, Finding, check_pair, Context, Samples, drop_outliers, drop_unmeasured, find_gaps, hold_unmeasured, choose_clock, clock_names, same_clock, seconds, unit_finding, find_column, select_run, order_time, Table, finite, Window, TOGETHER, WHOLE, parse_window, context, read_pair, _on_one_clock, _wanted_clock, select_rows, samples_of, prepare, cut_window, _bounds, require_samples, logged_in_turns, merge_clocks, _from_common_zero, _warn_other_clocks;
math = $.imp("math");
replace = $.from("dataclasses", "replace");
np = $.imp("numpy");
npt = $.imp("numpy.typing");
Array_ = $.from("dehyst.arrays", "Array");
gap_limit = $.from("dehyst.data.loops", "gap_limit");
MINIMUM_SAMPLES = $.from("dehyst.data.recording", "MINIMUM_SAMPLES");
ColumnError = $.from("dehyst.errors", "ColumnError");RecordingError = $.from("dehyst.errors", "RecordingError");TimeError = $.from("dehyst.errors", "TimeError");
Finding = $.from("dehyst.findings", "Finding");
check_pair = $.from("dehyst.io.checks", "check_pair");
Context = $.from("dehyst.io.clean", "Context");Samples = $.from("dehyst.io.clean", "Samples");drop_outliers = $.from("dehyst.io.clean", "drop_outliers");drop_unmeasured = $.from("dehyst.io.clean", "drop_unmeasured");find_gaps = $.from("dehyst.io.clean", "find_gaps");hold_unmeasured = $.from("dehyst.io.clean", "hold_unmeasured");
choose_clock = $.from("dehyst.io.clocks", "choose_clock");clock_names = $.from("dehyst.io.clocks", "clock_names");same_clock = $.from("dehyst.io.clocks", "same_clock");seconds = $.from("dehyst.io.clocks", "seconds");unit_finding = $.from("dehyst.io.clocks", "unit_finding");
find_column = $.from("dehyst.io.columns", "find_column");select_run = $.from("dehyst.io.columns", "select_run");
order_time = $.from("dehyst.io.order", "order_time");
Table = $.from("dehyst.io.table", "Table");finite = $.from("dehyst.io.table", "finite");
Window = $.gi($.b.tuple, $.tup($.b.float, $.b.float));
TOGETHER = 0.5;
WHOLE = $.tup($.neg($.ga(math, "inf")), $.ga(math, "inf"));
parse_window = $.def(function (start, stop) { let window;
window = $.tup(($.t((start == null)) ? $.neg($.ga(math, "inf")) : $.b.float(start)), ($.t((stop == null)) ? $.ga(math, "inf") : $.b.float(stop)));
if (!$.t($.lt($.gi(window, 0), $.gi(window, 1)))) {throw $.exc($.k(TimeError, [("" + "the window from " + $.f(start, "", -1) + " s to " + $.f(stop, "", -1) + " s is empty. --from must be less than --to, both in seconds of the log's own time.")], {"start": start, "stop": stop}));}
return window; }, {p: ["start", "stop"], ks: false});
context = $.def(function (table, columns, findings = null) { let units;
units = $.b.tuple((function* () { for (const $v1 of $.it(columns)) { let name; name = $v1; yield $.gi(table.label(name), 1); } })());
return Context($.ga(table, "name"), columns, $.ga(table, "row_word"), units, ($.t((findings == null)) ? $.b.list($.ga(table, "findings")) : findings)); }, {p: ["table", "columns", "findings"], ks: false});
read_pair = $.def(function (table, about, time, run, window) { let samples, chosen, clock;
{const $v2 = $.unpack(_on_one_clock(table, about, time, run, window), 3, -1);samples = $v2[0];chosen = $v2[1];clock = $v2[2];}
samples = find_gaps(samples, about);
require_samples(samples, about, window);
$.cm($.ga(about, "findings"), "extend", [check_pair(table, $.ga(about, "columns"), samples)]);
return $.tup(samples, chosen, clock); }, {p: ["table", "about", "time", "run", "window"], ks: false});
_on_one_clock = $.def(function (table, about, time, run, window) { let x_name, y_name, x_size, y_size, clocks, chosen, mask, first, second, samples, pair, masks, x, y;
{const $v3 = $.unpack($.ga(about, "columns"), 2, -1);x_name = $v3[0];y_name = $v3[1];}
{const $v4 = $.unpack($.tup($.ga($.gi($.ga(table, "columns"), x_name), "size"), $.ga($.gi($.ga(table, "columns"), y_name), "size")), 2, -1);x_size = $v4[0];y_size = $v4[1];}
clocks = (() => { const $r = []; for (const $v5 of $.it($.ga(about, "columns"))) { let name; name = $v5; $r.push(choose_clock(table, name, _wanted_clock(table, name, time, $.eq(x_size, y_size)))); } return $r; })();
{const $v6 = $.unpack(select_rows(table, x_name, run), 2, -1);chosen = $v6[0];mask = $v6[1];}
{const $v7 = $.unpack(clocks, 2, -1);first = $v7[0];second = $v7[1];}
if (($.t($.eq(x_size, y_size)) && ($.t($.eq(first, second)) || ($.t(first) && $.t(second) && $.t(same_clock(table, first, second)))))) {samples = samples_of(table, $.ga(about, "columns"), first, mask, about);
if ($.t((first == null))) {about.say("no-time", ("" + $.f($.ga(table, "name"), "", -1) + " has no time column: gaps, rate dependence and drift cannot be seen. Log one, or name it with --time."));} else {if ($.t((time == null))) {_warn_other_clocks(table, first, x_size, about);}}
if (($.t((first == null)) || !$.t(logged_in_turns(...$.it($.ga(samples, "values")))))) {return $.tup(prepare(samples, about, window), chosen, first);}
pair = $.b.tuple((function* () { for (const $v8 of $.it($.ga(samples, "values"))) { let v; v = $v8; yield Samples($.ga(samples, "time"), $.tup(v), $.ga(samples, "rows")).take(np.isfinite(v)); } })());} else {masks = (() => { const $r = []; for (const $v9 of $.it($.ga(about, "columns"))) { let name; name = $v9; $r.push($.gi(select_rows(table, name, run), 1)); } return $r; })();
pair = $.b.tuple((function* () { for (const $v10 of $.it($.k($.b.zip, [$.ga(about, "columns"), clocks, masks], {"strict": true}))) { let name, clock, m; {const $v11 = $.unpack($v10, 3, -1);name = $v11[0];clock = $v11[1];m = $v11[2];} yield $.k(samples_of, [table, $.tup(name), clock, m, about], {"shift": true}); } })());
pair = _from_common_zero(pair);}
{const $v14 = $.unpack((function* () { for (const $v12 of $.it($.k($.b.zip, [pair, $.ga(about, "columns"), $.ga(about, "units")], {"strict": true}))) { let s, name, unit; {const $v13 = $.unpack($v12, 3, -1);s = $v13[0];name = $v13[1];unit = $v13[2];} yield prepare(s, $.k(replace, [about], {"columns": $.tup(name), "units": $.tup(unit)}), window); } })(), 2, -1);x = $v14[0];y = $v14[1];}
return $.tup(merge_clocks(x, y, about), chosen, first); }, {p: ["table", "about", "time", "run", "window"], ks: false});
_wanted_clock = $.def(function (table, column, time, one_length) { let named;
if (($.t((time == null)) || $.t(one_length))) {return time;}
named = $.gi($.ga(table, "columns"), find_column(table, time, "time"));
return ($.t($.eq($.ga(named, "size"), $.ga($.gi($.ga(table, "columns"), column), "size"))) ? time : null); }, {p: ["table", "column", "time", "one_length"], ks: false});
select_rows = $.def(function (table, column, run) { 
if ($.t($.ne($.ga($.gi($.ga(table, "columns"), column), "size"), $.ga($.ga(table, "rows"), "size")))) {return $.tup(null, $.km(np, "ones", [$.ga($.gi($.ga(table, "columns"), column), "size")], {"dtype": $.b.bool}));}
return select_run(table, run); }, {p: ["table", "column", "run"], ks: false});
samples_of = $.def(function (table, names, clock, mask, about, shift = false) { let wanted, column, everything, columns, part, stamps, origin, rows;
wanted = $.b.dict.fromkeys($.tup(...$.it(names), ...$.it(($.t(clock) ? $.tup(clock) : $.tup()))));
for (const $v15 of $.it(wanted)) { column = $v15;
{if ($.t($.in(column, $.ga(table, "refused")))) {throw $.exc($.k(ColumnError, [$.gi($.ga(table, "refused"), column)], {"column": column}));}} }
everything = $.b.bool(mask.all());
columns = $.dict((() => { const $r = []; for (const $v16 of $.it(wanted)) { let n; n = $v16; $r.push([n, ($.t(everything) ? $.gi($.ga(table, "columns"), n) : $.gi($.gi($.ga(table, "columns"), n), mask))]); } return $r; })());
part = $.k(Table, [$.ga(table, "name"), columns, $.ga(table, "units"), $.ga(table, "rows")], {"clocks": $.ga(table, "clocks"), "stamps": $.ga(table, "stamps")});
stamps = null;
if ($.t(clock)) {{const $v17 = $.unpack(seconds(part, clock), 2, -1);stamps = $v17[0];origin = $v17[1];}
stamps = ($.t(shift) ? $.add(stamps, origin) : stamps);
$.cm($.ga(about, "findings"), "extend", [(function* () { for (const $v18 of $.it(unit_finding(part, clock, stamps))) { let f; f = $v18; if ($.t(!$.in(f, $.ga(about, "findings")))) { yield f; } } })()]);}
rows = ($.t(everything) ? $.gi($.ga(table, "rows"), $.slice(null, $.ga(mask, "size"), null)) : $.gi($.gi($.ga(table, "rows"), $.slice(null, $.ga(mask, "size"), null)), mask));
return Samples(stamps, $.b.tuple((function* () { for (const $v19 of $.it(names)) { let n; n = $v19; yield $.gi(columns, n); } })()), rows); }, {p: ["table", "names", "clock", "mask", "about", "shift"], ks: false});
prepare = $.def(function (samples, about, window, hold = false) { 
samples = cut_window(samples, about, window);
samples = ($.t(hold) ? hold_unmeasured : drop_unmeasured)(samples, about);
return order_time(drop_outliers(samples, about, hold), about); }, {p: ["samples", "about", "window", "hold"], ks: false});
cut_window = $.def(function (samples, about, window) { let t, inside, known, spans;
if ($.t($.eq(window, WHOLE))) {return samples;}
t = $.ga(samples, "time");
if ($.t((t == null))) {throw $.exc($.k(TimeError, [("" + $.f($.ga(about, "log"), "", -1) + " has no time column, so it cannot be cut to " + $.f(_bounds(window), "", -1) + ". Name one with --time, or leave --from and --to out.")], {"log": $.ga(about, "log")}));}
{ const $v20 = $.km(np, "errstate", [], {"invalid": "ignore"}); $.enter($v20); try {inside = $.band($.ge(t, $.gi(window, 0)), $.lt(t, $.gi(window, 1)));} catch ($e) { if (!$.exit($v20, $.caught($e))) throw $e; } }
if (!$.t(inside.any())) {known = $.gi(t, np.isfinite(t));
spans = ($.t($.ga(known, "size")) ? ("" + "from " + $.f(known.min(), ("" + ".6g"), -1) + " s to " + $.f(known.max(), ("" + ".6g"), -1) + " s") : "no time at all");
throw $.exc($.k(TimeError, [("" + "no sample of " + $.f($.ga(about, "log"), "", -1) + " lies in the window " + $.f(_bounds(window), "", -1) + "; the log covers " + $.f(spans, "", -1) + ". Change --from and --to.")], {"window": window}));}
return samples.take(inside); }, {p: ["samples", "about", "window"], ks: false});
_bounds = $.def(function (window) { let low, high;
{const $v22 = $.unpack((function* () { for (const $v21 of $.it(window)) { let bound; bound = $v21; yield ($.t(np.isfinite(bound)) ? ("" + $.f(bound, ("" + "g"), -1) + " s") : ""); } })(), 2, -1);low = $v22[0];high = $v22[1];}
return ("" + $.f(low, "", -1) + $.f(($.t(low) ? " <= " : ""), "", -1) + "t" + $.f(($.t(high) ? " < " : ""), "", -1) + $.f(high, "", -1)); }, {p: ["window"], ks: false});
require_samples = $.def(function (samples, about, window, least = MINIMUM_SAMPLES) { let cut;
if ($.t($.lt($.ga($.ga(samples, "rows"), "size"), least))) {cut = ($.t($.ne(window, WHOLE)) ? ("" + " in the window " + $.f($.gi(window, 0), ("" + "g"), -1) + " s <= t < " + $.f($.gi(window, 1), ("" + "g"), -1) + " s") : "");
throw $.exc($.k(RecordingError, [("" + $.f($.ga(about, "log"), "", -1) + " has " + $.f($.ga($.ga(samples, "rows"), "size"), "", -1) + " usable rows" + $.f(cut, "", -1) + "; a loop needs at least " + $.f(least, "", -1) + ". Check the window (--from, --to), the run (--run) and the columns.")], {"rows": $.ga($.ga(samples, "rows"), "size")}));} }, {p: ["samples", "about", "window", "least"], ks: false});
logged_in_turns = $.def(function (x, y) { let has_x, has_y, either, both;
{const $v23 = $.unpack($.tup(finite(x), finite(y)), 2, -1);has_x = $v23[0];has_y = $v23[1];}
either = $.b.int(np.sum($.bor(has_x, has_y)));
both = $.b.int(np.sum($.band(has_x, has_y)));
return $.and($.ge($.b.min(has_x.sum(), has_y.sum()), 4), () => $.and($.lt(both, $.mul(TOGETHER, either)), () => $.b.bool(np.any($.band(has_x, $.inv(has_y)))))); }, {p: ["x", "y"], ks: false});
merge_clocks = $.def(function (x, y, about) { let tx, ty, both, inside, right, exact, kept, output;
{const $v24 = $.unpack($.tup($.ga(x, "time"), $.ga(y, "time")), 2, -1);tx = $v24[0];ty = $v24[1];}
both = $.cm(" and ", "join", [$.ga(about, "columns")]);
if (($.t((tx == null)) || $.t((ty == null)))) {throw $.exc($.k(TimeError, [("" + $.f(both, "", -1) + " of " + $.f($.ga(about, "log"), "", -1) + " have " + $.f($.ga($.ga(x, "rows"), "size"), "", -1) + " and " + $.f($.ga($.ga(y, "rows"), "size"), "", -1) + " samples and no time column, so nothing tells which belong together. Log a time column for each, or resample them to one.")], {"columns": $.ga(about, "columns")}));}
if (($.t($.ga(x, "breaks")) || $.t($.ga(y, "breaks")))) {throw $.exc($.k(TimeError, [("" + $.f(both, "", -1) + " of " + $.f($.ga(about, "log"), "", -1) + " are on two clocks, and one of them restarts; they cannot be matched beyond that. Cut a window that holds one recording: --from S --to S")], {"columns": $.ga(about, "columns")}));}
if (($.t($.lt($.ga(tx, "size"), 2)) || $.t($.lt($.ga(ty, "size"), 2)))) {throw $.exc($.k(TimeError, [("" + $.f($.ga(about, "log"), "", -1) + ": a signal on two clocks needs two samples on each.")], {"columns": $.ga(about, "columns")}));}
inside = $.band($.ge(tx, $.gi(ty, 0)), $.le(tx, $.gi(ty, (-1))));
if (!$.t(inside.any())) {throw $.exc($.k(TimeError, [("" + "the clocks of " + $.f(both, "", -1) + " in " + $.f($.ga(about, "log"), "", -1) + " do not overlap: the input covers " + $.f($.gi(tx, 0), ("" + ".6g"), -1) + " to " + $.f($.gi(tx, (-1)), ("" + ".6g"), -1) + " s, the output " + $.f($.gi(ty, 0), ("" + ".6g"), -1) + " to " + $.f($.gi(ty, (-1)), ("" + ".6g"), -1) + " s. Shift one of them, or name the right time column with --time.")], {"columns": $.ga(about, "columns")}));}
right = np.clip(np.searchsorted(ty, tx), 1, $.sub($.ga(ty, "size"), 1));
exact = np.isin(tx, ty);
inside = $.iband(inside, $.bor(exact, $.le($.sub($.gi(ty, right), $.gi(ty, $.sub(right, 1))), gap_limit(np.diff(ty)))));
kept = x.take(inside);
output = np.interp($.ga(kept, "time"), ty, $.gi($.ga(y, "values"), 0));
about.say("two-clocks", ("" + $.f(both, "", -1) + " of " + $.f($.ga(about, "log"), "", -1) + " are on two clocks (steps of " + $.f(np.median(np.diff(tx)), ("" + ".3g"), -1) + " and " + $.f(np.median(np.diff(ty)), ("" + ".3g"), -1) + " s); the output was interpolated at the " + $.f($.ga($.ga(kept, "rows"), "size"), "", -1) + " stamps of the input that both cover. A delay between the clocks would look like hysteresis: log both in one row."));
return Samples($.ga(kept, "time"), $.tup($.gi($.ga(kept, "values"), 0), output), $.ga(kept, "rows")); }, {p: ["x", "y", "about"], ks: false});
_from_common_zero = $.def(function (pair) { let times, zero;
times = (() => { const $r = []; for (const $v25 of $.it(pair)) { let s; s = $v25; if (($.t(($.ga(s, "time") != null)) && $.t(np.isfinite($.ga(s, "time")).any()))) { $r.push($.ga(s, "time")); } } return $r; })();
if (($.t($.lt($.b.len(times), 2)) || $.t($.lt($.b.min((function* () { for (const $v26 of $.it(times)) { let t; t = $v26; yield $.b.float(np.nanmedian(t)); } })()), 978000000.0)))) {return pair;}
zero = $.b.min((function* () { for (const $v27 of $.it(times)) { let t; t = $v27; yield $.b.float($.gi($.gi(t, np.isfinite(t)), 0)); } })());
return $.b.tuple((function* () { for (const $v28 of $.it(pair)) { let s; s = $v28; yield Samples(($.t(($.ga(s, "time") != null)) ? $.sub($.ga(s, "time"), zero) : null), $.ga(s, "values"), $.ga(s, "rows")); } })()); }, {p: ["pair"], ks: false});
_warn_other_clocks = $.def(function (table, clock, size, about) { let others;
others = (() => { const $r = []; for (const $v29 of $.it(clock_names(table))) { let name; name = $v29; if (($.t($.ne(name, clock)) && $.t($.eq($.ga($.gi($.ga(table, "columns"), name), "size"), size)) && !$.t(same_clock(table, clock, name)))) { $r.push(name); } } return $r; })();
if (($.t(others) && $.t(!$.in(clock, $.cm($.ga(table, "clocks"), "values", []))))) {about.say("several-time-columns", ("" + $.f($.ga(table, "name"), "", -1) + " has more than one time column; '" + $.f(clock, "", -1) + "' was taken, and " + $.f($.cm(", ", "join", [others]), "", -1) + " tells another time. If that is the right one: --time " + $.f($.gi(others, 0), "", -1)));} }, {p: ["table", "clock", "size", "about"], ks: false});
Object.assign($m, {"annotations": annotations, "math": math, "replace": replace, "np": np, "npt": npt, "Array": Array_, "gap_limit": gap_limit, "MINIMUM_SAMPLES": MINIMUM_SAMPLES, "ColumnError": ColumnError, "RecordingError": RecordingError, "TimeError": TimeError, "Finding": Finding, "check_pair": check_pair, "Context": Context, "Samples": Samples, "drop_outliers": drop_outliers, "drop_unmeasured": drop_unmeasured, "find_gaps": find_gaps, "hold_unmeasured": hold_unmeasured, "choose_clock": choose_clock, "clock_names": clock_names, "same_clock": same_clock, "seconds": seconds, "unit_finding": unit_finding, "find_column": find_column, "select_run": select_run, "order_time": order_time, "Table": Table, "finite": finite, "Window": Window, "TOGETHER": TOGETHER, "WHOLE": WHOLE, "parse_window": parse_window, "context": context, "read_pair": read_pair, "_on_one_clock": _on_one_clock, "_wanted_clock": _wanted_clock, "select_rows": select_rows, "samples_of": samples_of, "prepare": prepare, "cut_window": cut_window, "_bounds": _bounds, "require_samples": require_samples, "logged_in_turns": logged_in_turns, "merge_clocks": merge_clocks, "_from_common_zero": _from_common_zero, "_warn_other_clocks": _warn_other_clocks});
});
$.module("dehyst.io.table", ($m) => {
let annotations, Iterable, Mapping, Sequence, dataclass, field, np, npt, Array_, Rows, LogError, Finding, visible, parse_unit, LARGEST, SHOWN, FRAME, Table, finite, measured, list_rows, list_names, unique_names, shown_names, require_columns;
Iterable = $.from("collections.abc", "Iterable");Mapping = $.from("collections.abc", "Mapping");Sequence = $.from("collections.abc", "Sequence");
dataclass = $.from("dataclasses", "dataclass");field = $.from("dataclasses", "field");
np = $.imp("numpy");
npt = $.imp("numpy.typing");
Array_ = $.from("dehyst.arrays", "Array");Rows = $.from("dehyst.arrays", "Rows");
LogError = $.from("dehyst.errors", "LogError");
Finding = $.from("dehyst.findings", "Finding");
visible = $.from("dehyst.shell", "visible");
parse_unit = $.from("dehyst.units", "parse_unit");
LARGEST = 1e+100;
SHOWN = 4;
FRAME = "data frame";
Table = $.cls("Table", [], "", [["name", null], ["columns", null], ["units", null], ["rows", null], ["labels", () => $.b.dict()], ["row_word", () => "row"], ["clocks", () => $.b.dict()], ["stamps", () => $.b.frozenset()], ["order", () => $.tup()], ["scalars", () => $.b.dict()], ["sha256", () => ""], ["findings", () => $.tup()], ["refused", () => $.b.dict()]], true, false, ($c) => { Table = $c; $.meth($c, "__post_init__", $.def(function () { const self = this;
if (!$.t($.ga(self, "order"))) {$.seta(self, "order", $.tup(...$.it($.ga(self, "columns")), ...$.it($.ga(self, "labels"))));} }, {p: [], ks: false}));
$.meth($c, "label", $.def(function (name) { const self = this;let bare, unit;
{const $v1 = $.unpack(parse_unit(name), 2, -1);bare = $v1[0];unit = $v1[1];}
return $.tup(bare, $.or($.cm($.ga(self, "units"), "get", [name]), () => unit)); }, {p: ["name"], ks: false}));});
finite = $.def(function (values) { 
{ const $v2 = $.km(np, "errstate", [], {"invalid": "ignore"}); $.enter($v2); try {return np.asarray($.band($.le(values, LARGEST), $.ge(values, $.neg(LARGEST))));} catch ($e) { if (!$.exit($v2, $.caught($e))) throw $e; } } }, {p: ["values"], ks: false});
measured = $.def(function (values) { let good;
good = finite(values);
return ($.t(good.all()) ? values : $.gi(values, good)); }, {p: ["values"], ks: false});
list_rows = $.def(function (rows, word = "line", count = 0, shown = SHOWN) { let numbers, more, text;
numbers = (() => { const $r = []; for (const $v3 of $.it($.gi(rows, $.slice(null, shown, null)))) { let row; row = $v3; $r.push($.b.str($.b.int(row))); } return $r; })();
more = $.sub($.b.max(count, $.b.len(rows)), $.b.len(numbers));
text = ("" + $.f(word, "", -1) + $.f(($.t($.ne($.b.len(rows), 1)) ? "s" : ""), "", -1) + " " + $.f($.cm(", ", "join", [numbers]), "", -1));
return ($.t($.gt(more, 0)) ? ("" + $.f(text, "", -1) + " and " + $.f(more, "", -1) + " more") : text); }, {p: ["rows", "word", "count", "shown"], ks: false});
list_names = $.def(function (names, shown = 30) { let given, more;
given = $.b.list(names);
more = ($.t($.gt($.b.len(given), shown)) ? ("" + " and " + $.f($.sub($.b.len(given), shown), "", -1) + " more") : "");
return $.add($.cm(", ", "join", [$.gi(given, $.slice(null, shown, null))]), more); }, {p: ["names", "shown"], ks: false});
unique_names = $.def(function (names) { let found, taken, number, name, base, unique;
found = [];
taken = $.dict([]);
for (const $v4 of $.it($.b.enumerate(names, 1))) { {const $v5 = $.unpack($v4, 2, -1);number = $v5[0];name = $v5[1];}
{{ const $v6 = $.or($.cm(name, "strip", []), () => ("" + "column_" + $.f(number, "", -1))); base = $v6; unique = $v6;}
while ($.t($.in(unique, taken))) {$.isi(taken, base, $.iadd, 1);
unique = ("" + $.f(base, "", -1) + "_" + $.f($.gi(taken, base), "", -1));}
$.si(taken, unique, 1);
$.cm(found, "append", [unique]);} }
return found; }, {p: ["names"], ks: false});
shown_names = $.def(function (names, log, findings) { let shown, changed;
shown = (() => { const $r = []; for (const $v7 of $.it(names)) { let name; name = $v7; $r.push($.cm(visible(name), "strip", [])); } return $r; })();
changed = (() => { const $r = []; for (const $v8 of $.it($.k($.b.zip, [names, shown], {"strict": true}))) { let old, new_; {const $v9 = $.unpack($v8, 2, -1);old = $v9[0];new_ = $v9[1];} if ($.t($.ne($.cm(old, "strip", []), new_))) { $r.push(new_); } } return $r; })();
if ($.t(changed)) {$.cm(findings, "append", [Finding("unprintable-names", ("" + $.f($.b.len(changed), "", -1) + " column name" + $.f(($.t($.gt($.b.len(changed), 1)) ? "s" : ""), "", -1) + " of " + $.f(log, "", -1) + " held line breaks, control characters or marks that turn the direction of writing, which a terminal would obey; the names used here are: " + $.f(list_names(changed, 8), "", -1) + ". Type them like this, or rename the columns in the log."))]);}
return shown; }, {p: ["names", "log", "findings"], ks: false});
require_columns = $.def(function (table) { let texts;
if (!$.t($.b.any((function* () { for (const $v10 of $.it($.cm($.ga(table, "columns"), "values", []))) { let column; column = $v10; yield $.or(finite($.gi(column, $.slice(null, 100, null))).any(), () => finite(column).any()); } })()))) {texts = ($.t($.ga(table, "labels")) ? ("" + " Its columns are text: " + $.f(list_names($.ga(table, "labels")), "", -1) + ".") : "");
throw $.exc($.k(LogError, [("" + "log '" + $.f($.ga(table, "name"), "", -1) + "' holds no column of numbers." + $.f(texts, "", -1) + " Check that it is the right file, and that its delimiter is one of , ; | tab or blanks.")], {"file": $.ga(table, "name")}));}
return table; }, {p: ["table"], ks: false});
Object.assign($m, {"annotations": annotations, "Iterable": Iterable, "Mapping": Mapping, "Sequence": Sequence, "dataclass": dataclass, "field": field, "np": np, "npt": npt, "Array": Array_, "Rows": Rows, "LogError": LogError, "Finding": Finding, "visible": visible, "parse_unit": parse_unit, "LARGEST": LARGEST, "SHOWN": SHOWN, "FRAME": FRAME, "Table": Table, "finite": finite, "measured": measured, "list_rows": list_rows, "list_names": list_names, "unique_names": unique_names, "shown_names": shown_names, "require_columns": require_columns});
});
$.module("dehyst.io.text", ($m) => {
let annotations, io, re, zlib, Iterator, dataclass, BinaryIO, _native, LogError, MEGABYTE, EXPANSION_LIMIT, EXPANSION_FREE, SIZE_LIMIT, BLOCK, PACKED, GZIP, expand, unpacked, _utf16, decode, lines_of, _NUMBER_CELL, MOST_JOINED, join_quoted, _opens, HEAD_LINES, HEAD_BYTES, Text, open_text, _head_size;
io = $.imp("io");
re = $.imp("re");
zlib = $.imp("zlib");
Iterator = $.from("collections.abc", "Iterator");
dataclass = $.from("dataclasses", "dataclass");
BinaryIO = $.from("typing", "BinaryIO");
_native = $.imp("dehyst._native");
LogError = $.from("dehyst.errors", "LogError");
MEGABYTE = $.shl(1, 20);
EXPANSION_LIMIT = 100;
EXPANSION_FREE = $.mul(8, MEGABYTE);
SIZE_LIMIT = $.mul(1024, MEGABYTE);
BLOCK = MEGABYTE;
PACKED = $.fdiv(BLOCK, 4);
GZIP = $.bytes([31, 139]);
expand = $.def(function (data, name) { let limit, parts, size, block;
if (!$.t($.cm(data, "startswith", [GZIP]))) {return data;}
limit = $.b.min(SIZE_LIMIT, $.b.max(EXPANSION_FREE, $.mul(EXPANSION_LIMIT, $.b.len(data))));
parts = [];
size = 0;
for (const $v1 of $.it(unpacked(io.BytesIO(data), name))) { block = $v1;
{$.cm(parts, "append", [block]);
size = $.iadd(size, $.b.len(block));
if ($.t($.gt(size, limit))) {throw $.exc($.k(LogError, [("" + "log '" + $.f(name, "", -1) + "' expands from " + $.f($.b.len(data), "", -1) + " bytes to more than " + $.f($.fdiv(limit, MEGABYTE), "", -1) + " MB; no log of a test rig packs that well, so it is not read. If it is one, unpack it first: gzip -d " + $.f(name, "", -1))], {"file": name, "limit": limit}));}} }
return $.cm($.bytes([]), "join", [parts]); }, {p: ["data", "name"], ks: false});
unpacked = $.def(function* (stream, name) { let data, size, left, member, block, fault, more;
{const $v2 = $.unpack($.tup(stream.read(PACKED), 0), 2, -1);data = $v2[0];size = $v2[1];}
while ($.t(data)) {data = $.iadd(data, ($.t($.lt($.b.len(data), $.b.len(GZIP))) ? stream.read(PACKED) : $.bytes([])));
if (!$.t($.cm(data, "startswith", [GZIP]))) {left = $.add($.b.len(data), $.b.len(stream.read()));
throw $.exc($.k(LogError, [("" + "log '" + $.f(name, "", -1) + "' is damaged: " + $.f(left, "", -1) + " bytes follow its gzip data that do not belong to it. Copy the file again.")], {"file": name}));}
member = $.km(zlib, "decompressobj", [], {"wbits": 31});
while (!$.t($.ga(member, "eof"))) {try {block = member.decompress(data, BLOCK);} catch ($e) { $e = $.caught($e); if ($.isinst($e, $.ga(zlib, "error"))) { fault = $e; {throw $.exc($.k(LogError, [("" + "log '" + $.f(name, "", -1) + "' is damaged: its gzip data cannot be expanded (" + $.f(fault, "", -1) + "). Copy the file again, or save what can be saved with: gzip -dc " + $.f(name, "", -1) + " > log.csv")], {"file": name}));} } else throw $e; }
data = $.or($.ga(member, "unconsumed_tail"), () => stream.read(PACKED));
size = $.iadd(size, $.b.len(block));
if ($.t(block)) {(yield block);} else {if ((!$.t(data) && !$.t($.ga(member, "eof")))) {throw $.exc($.k(LogError, [("" + "log '" + $.f(name, "", -1) + "' is damaged: its gzip data ends early, after " + $.f(size, "", -1) + " bytes of text. Copy the file again, or save what is there with: gzip -dc " + $.f(name, "", -1) + " > log.csv")], {"file": name}));}}}
data = $.cm($.add($.ga(member, "unused_data"), data), "lstrip", [$.bytes([0])]);
while ((!$.t(data) && $.t((more = stream.read(PACKED))))) {data = $.cm(more, "lstrip", [$.bytes([0])]);}} }, {p: ["stream", "name"], ks: false});
_utf16 = $.def(function (data) { let head, half;
if ($.t($.cm(data, "startswith", [$.tup($.bytes([255, 254]), $.bytes([254, 255]))]))) {return "utf-16";}
head = $.gi(data, $.slice(null, 4096, null));
half = $.fdiv($.b.len(head), 2);
if ($.t($.lt(half, 8))) {return null;}
if (($.t($.gt($.cm($.gi(head, $.slice(1, null, 2)), "count", [0]), $.mul(0.8, half))) && $.t($.lt($.cm($.gi(head, $.slice(0, null, 2)), "count", [0]), $.mul(0.1, half))))) {return "utf-16-le";}
if (($.t($.gt($.cm($.gi(head, $.slice(0, null, 2)), "count", [0]), $.mul(0.8, half))) && $.t($.lt($.cm($.gi(head, $.slice(1, null, 2)), "count", [0]), $.mul(0.1, half))))) {return "utf-16-be";}
return null; }, {p: ["data"], ks: false});
decode = $.def(function (data, name) { let wide, text, body, replaced, bad, good, head, control;
wide = _utf16(data);
if ($.t(wide)) {text = $.cm($.cm($.gi(data, $.slice(null, $.mul($.fdiv($.b.len(data), 2), 2), null)), "decode", [wide], {"errors": "replace"}), "lstrip", ["\ufeff"]);} else {body = data;
while ($.t($.cm(body, "startswith", [$.bytes([239, 187, 191])]))) {body = $.gi(body, $.slice(3, null, null));}
try {text = $.cm(body, "decode", ["utf-8"]);} catch ($e) { $e = $.caught($e); if ($.isinst($e, $.b.UnicodeDecodeError)) {  {replaced = $.cm(body, "decode", ["utf-8"], {"errors": "replace"});
bad = $.cm(replaced, "count", ["\ufffd"]);
good = $.sub($.b.sum((function* () { for (const $v3 of $.it($.gi(replaced, $.slice(null, 4096, null)))) { let character; character = $v3; yield $.gt(character, "\u007f"); } })()), $.cm($.gi(replaced, $.slice(null, 4096, null)), "count", ["\ufffd"]));
text = (($.t(good) && $.t($.le(bad, 3))) ? replaced : $.cm(body, "decode", ["latin-1"]));} } else throw $e; }}
head = $.gi(text, $.slice(null, 65536, null));
control = $.b.sum((function* () { for (const $v4 of $.it($.tup(...$.it($.b.range(9)), ...$.it($.b.range(14, 32)), 127))) { let code; code = $v4; yield $.cm(head, "count", [$.b.chr(code)]); } })());
if ($.t($.gt(control, $.b.max(2, $.mul(0.02, $.b.len(head)))))) {throw $.exc($.k(LogError, [("" + "log '" + $.f(name, "", -1) + "' is not text: " + $.f(control, "", -1) + " of its first " + $.f($.b.len(head), "", -1) + " characters are control characters. Known formats are .csv .txt .tsv .dat (also .gz), .mat, .h5, .npz, .npy, .bag, .db3, .mcap, .mf4, .mdf, .parquet and .feather; give the file the ending of its format.")], {"file": name}));}
return text; }, {p: ["data", "name"], ks: false});
lines_of = $.def(function (text) { 
if ($.t($.in("\r", text))) {text = $.cm($.cm(text, "replace", ["\r\n", "\n"]), "replace", ["\r", "\n"]);}
return $.cm(text, "split", ["\n"]); }, {p: ["text"], ks: false});
_NUMBER_CELL = re.compile("(?:^|[,;|\\t])\\s*[+-]?[\\d.]*\\d(?:[eE][+-]?\\d+)?\\s*(?:[,;|\\t]|$)", $.ga(re, "ASCII"));
MOST_JOINED = 20;
join_quoted = $.def(function (lines) { let joined, k, line, end;
joined = $.b.list(lines);
for (const $v5 of $.it($.b.enumerate(lines))) { {const $v6 = $.unpack($v5, 2, -1);k = $v6[0];line = $v6[1];}
{if (($.t(!$.in("\"", line)) || $.t($.ne($.gi(joined, k), line)) || !$.t(_opens(line)))) {continue;}
for (const $v7 of $.it($.b.range($.add(k, 1), $.b.min($.add(k, MOST_JOINED), $.b.len(lines))))) { end = $v7;
{if ($.t(_NUMBER_CELL.search($.gi(lines, end)))) {break;}
if ($.t($.mod($.cm($.gi(lines, end), "count", ["\""]), 2))) {$.si(joined, $.slice(k, $.add(end, 1), null), $.add([$.cm("\n", "join", [$.gi(lines, $.slice(k, $.add(end, 1), null))])], $.mul([""], $.sub(end, k))));
break;}} }} }
return joined; }, {p: ["lines"], ks: false});
_opens = $.def(function (line) { let before, quote, _;
{const $v8 = $.unpack($.cm($.cm(line, "replace", ["\"\"", ""]), "rpartition", ["\""]), 3, -1);before = $v8[0];quote = $v8[1];_ = $v8[2];}
return $.and($.eq($.mod($.cm(line, "count", ["\""]), 2), 1), () => $.and($.b.bool(quote), () => $.or(!$.t(before), () => $.in($.gi(before, (-1)), ",;|\t ")))); }, {p: ["line"], ks: false});
HEAD_LINES = 2000;
HEAD_BYTES = $.shl(1, 18);
Text = $.cls("Text", [], "", [["data", null], ["lines", null], ["complete", null]], true, true, ($c) => { Text = $c; $.meth($c, "offset", $.def(function (lines) { const self = this;
return _native.text_offset($.ga(self, "data"), lines); }, {p: ["lines"], ks: false}));
$.meth($c, "all_lines", $.def(function () { const self = this;
return ($.t($.ga(self, "complete")) ? $.ga(self, "lines") : join_quoted(lines_of($.cm($.ga(self, "data"), "decode", [])))); }, {p: [], ks: false}));});
open_text = $.def(function (data, name) { let cut, head, plain, text;
cut = ($.t(_utf16(data)) ? $.b.len(data) : _head_size(data));
if (($.t($.lt(cut, $.b.len(data))) && ($.t($.cm(data, "isascii", [])) || $.t($.cm($.gi(data, $.slice(cut, null, null)), "isascii", []))))) {head = decode($.gi(data, $.slice(null, cut, null)), name);
plain = $.cm(head, "encode", []);
return Text(($.t($.eq(plain, $.gi(data, $.slice(null, cut, null)))) ? data : $.add(plain, $.gi(data, $.slice(cut, null, null)))), join_quoted($.gi(lines_of(head), $.slice(null, (-1), null))), false);}
text = decode(data, name);
plain = $.cm(text, "encode", []);
cut = _head_size(plain);
if ($.t($.lt(cut, $.b.len(plain)))) {return Text(plain, join_quoted($.gi(lines_of($.cm($.gi(plain, $.slice(null, cut, null)), "decode", [])), $.slice(null, (-1), null))), false);}
return Text(plain, join_quoted(lines_of(text)), true); }, {p: ["data", "name"], ks: false});
_head_size = $.def(function (data) { 
return $.b.max(_native.text_offset(data, HEAD_LINES), _native.text_offset(data, 1, HEAD_BYTES)); }, {p: ["data"], ks: false});
Object.assign($m, {"annotations": annotations, "io": io, "re": re, "zlib": zlib, "Iterator": Iterator, "dataclass": dataclass, "BinaryIO": BinaryIO, "_native": _native, "LogError": LogError, "MEGABYTE": MEGABYTE, "EXPANSION_LIMIT": EXPANSION_LIMIT, "EXPANSION_FREE": EXPANSION_FREE, "SIZE_LIMIT": SIZE_LIMIT, "BLOCK": BLOCK, "PACKED": PACKED, "GZIP": GZIP, "expand": expand, "unpacked": unpacked, "_utf16": _utf16, "decode": decode, "lines_of": lines_of, "_NUMBER_CELL": _NUMBER_CELL, "MOST_JOINED": MOST_JOINED, "join_quoted": join_quoted, "_opens": _opens, "HEAD_LINES": HEAD_LINES, "HEAD_BYTES": HEAD_BYTES, "Text": Text, "open_text": open_text, "_head_size": _head_size});
});
$.module("dehyst.io.inspect", ($m) => {
let annotations, math, suppress, dataclass, Path, np, npt, Array_, gap_limit, turning_points, DehystError, TimeError, Finding, BETWEEN_WORDS, COMMAND_WORDS, hold_length, is_constant, choose_clock, clock_names, seconds, unit_finding, with_time_unit, count_runs, run_column, select_run, PathLike, read_table, is_frame, WHOLE, context, read_pair, Table, measured, typed, dimension, words, INPUT_POINTS, OUTPUT_POINTS, CLEAR, CANDIDATES, INPUT_WORDS, OUTPUT_WORDS, ColumnSummary, Sampling, LogSummary, inspect_log, _findings, _summarise, _sampling, _command, Role, _points, _relation, guess_roles, _leads;
math = $.imp("math");
suppress = $.from("contextlib", "suppress");
dataclass = $.from("dataclasses", "dataclass");
Path = $.from("pathlib", "Path");
np = $.imp("numpy");
npt = $.imp("numpy.typing");
Array_ = $.from("dehyst.arrays", "Array");
gap_limit = $.from("dehyst.data.loops", "gap_limit");turning_points = $.from("dehyst.data.loops", "turning_points");
DehystError = $.from("dehyst.errors", "DehystError");TimeError = $.from("dehyst.errors", "TimeError");
Finding = $.from("dehyst.findings", "Finding");
BETWEEN_WORDS = $.from("dehyst.io.checks", "BETWEEN_WORDS");COMMAND_WORDS = $.from("dehyst.io.checks", "COMMAND_WORDS");hold_length = $.from("dehyst.io.checks", "hold_length");is_constant = $.from("dehyst.io.checks", "is_constant");
choose_clock = $.from("dehyst.io.clocks", "choose_clock");clock_names = $.from("dehyst.io.clocks", "clock_names");seconds = $.from("dehyst.io.clocks", "seconds");unit_finding = $.from("dehyst.io.clocks", "unit_finding");with_time_unit = $.from("dehyst.io.clocks", "with_time_unit");
count_runs = $.from("dehyst.io.columns", "count_runs");run_column = $.from("dehyst.io.columns", "run_column");select_run = $.from("dehyst.io.columns", "select_run");
PathLike = $.from("dehyst.io.formats", "PathLike");read_table = $.from("dehyst.io.formats", "read_table");
is_frame = $.from("dehyst.io.frames", "is_frame");
WHOLE = $.from("dehyst.io.select", "WHOLE");context = $.from("dehyst.io.select", "context");read_pair = $.from("dehyst.io.select", "read_pair");
Table = $.from("dehyst.io.table", "Table");measured = $.from("dehyst.io.table", "measured");
typed = $.from("dehyst.shell", "typed");
dimension = $.from("dehyst.units", "dimension");words = $.from("dehyst.units", "words");
INPUT_POINTS = $.dict([["pressure", 6.0], ["voltage", 6.0], ["current", 5.0], ["length", 2.0], ["angle", 1.5], ["force", 0.5]]);
OUTPUT_POINTS = $.dict([["angle", 5.0], ["length", 4.0], ["force", 4.0], ["torque", 4.0], ["pressure", 0.5]]);
CLEAR = 1.0;
CANDIDATES = 20;
INPUT_WORDS = $.b.frozenset(words("input u x pressure voltage current drive valve command"));
OUTPUT_WORDS = $.b.frozenset(words("output y angle displacement position force tilt contraction strain length measured"));
ColumnSummary = $.cls("ColumnSummary", [], "", [["name", null], ["unit", null], ["samples", null], ["minimum", null], ["maximum", null], ["loops", null], ["missing", null], ["constant", null], ["role", null], ["reason", null]], true, true, ($c) => { ColumnSummary = $c; });
Sampling = $.cls("Sampling", [], "", [["column", null], ["first", null], ["last", null], ["median", null], ["jitter", null], ["gaps", null], ["repeated", null], ["backward", null]], true, true, ($c) => { Sampling = $c; });
LogSummary = $.cls("LogSummary", [], "", [["name", null], ["rows", null], ["columns", null], ["runs", null], ["run", null], ["sampling", null], ["input", null], ["output", null], ["clear", null], ["command", null], ["findings", null]], true, true, ($c) => { LogSummary = $c; });
inspect_log = $.def(function (path, run = null, time_unit = null) { let table, runs, chosen, mask, rows, values, paired, clocks, turns, roles, x, y, clear, columns, findings, readable;
table = with_time_unit(read_table(path), time_unit, null);
runs = count_runs(table);
{const $v1 = $.unpack(select_run(table, (($.t((run != null)) || !$.t(runs)) ? run : $.b.next($.b.iter(runs)))), 2, -1);chosen = $v1[0];mask = $v1[1];}
rows = $.dict((() => { const $r = []; for (const $v2 of $.it($.cm($.ga(table, "columns"), "items", []))) { let name, v; {const $v3 = $.unpack($v2, 2, -1);name = $v3[0];v = $v3[1];} $r.push([name, ($.t($.eq($.ga(v, "size"), $.ga(mask, "size"))) ? $.gi(v, mask) : v)]); } return $r; })());
values = $.dict((() => { const $r = []; for (const $v4 of $.it($.cm(rows, "items", []))) { let name, v; {const $v5 = $.unpack($v4, 2, -1);name = $v5[0];v = $v5[1];} $r.push([name, measured(v)]); } return $r; })());
paired = $.dict((() => { const $r = []; for (const $v6 of $.it($.cm(rows, "items", []))) { let name, v; {const $v7 = $.unpack($v6, 2, -1);name = $v7[0];v = $v7[1];} if ($.t($.eq($.ga(v, "size"), $.ga($.gi(values, name), "size")))) { $r.push([name, v]); } } return $r; })());
clocks = clock_names(table);
turns = $.dict((() => { const $r = []; for (const $v8 of $.it($.cm(values, "items", []))) { let name, v; {const $v9 = $.unpack($v8, 2, -1);name = $v9[0];v = $v9[1];} $r.push([name, $.b.max(0, $.sub($.ga(turning_points(v), "size"), 2))]); } return $r; })());
{const $v10 = $.unpack(guess_roles(table, values, paired, turns, clocks), 4, -1);roles = $v10[0];x = $v10[1];y = $v10[2];clear = $v10[3];}
columns = $.b.tuple((function* () { for (const $v11 of $.it($.ga(table, "order"))) { let name; name = $v11; yield _summarise(table, name, rows, values, turns, roles, mask); } })());
{const $v12 = $.unpack(_findings(table, x, y, chosen), 2, -1);findings = $v12[0];readable = $v12[1];}
return $.k(LogSummary, [], {"name": $.ga(table, "name"), "rows": $.b.int(mask.sum()), "columns": columns, "runs": runs, "run": chosen, "sampling": _sampling(table, x, rows, clocks), "input": x, "output": y, "clear": clear, "command": ($.t(readable) ? _command(path, x, y, ($.t($.gt($.b.len($.or(runs, () => $.tup())), 1)) ? chosen : null), time_unit, findings) : ""), "findings": findings}); }, {p: ["path", "run", "time_unit"], ks: false});
_findings = $.def(function (table, x, y, run) { let found, clocks, fault, refused;
found = $.b.list($.ga(table, "findings"));
found = $.iadd(found, (() => { const $r = []; for (const $v13 of $.it($.cm($.ga(table, "refused"), "items", []))) { let name, reason; {const $v14 = $.unpack($v13, 2, -1);name = $v14[0];reason = $v14[1];} if ($.t(!$.in(name, $.tup(x, y)))) { $r.push(Finding("not-readable", reason)); } } return $r; })());
if (($.t((x == null)) || $.t((y == null)))) {clocks = clock_names(table);
return $.tup($.tup(...$.it(found), ...$.it((function* () { for (const $v16 of $.it($.gi(clocks, $.slice(null, 1, null)))) { let name; name = $v16; for (const $v15 of $.it(unit_finding(table, name, $.gi(seconds(table, name), 0)))) { let f; f = $v15; yield f; } } })())), true);}
try {read_pair(table, context(table, $.tup(x, y), found), null, run, WHOLE);} catch ($e) { $e = $.caught($e); if ($.isinst($e, DehystError)) { fault = $e; {refused = Finding("not-readable", ("" + "reading '" + $.f(x, "", -1) + "' and '" + $.f(y, "", -1) + "' would end in an error: " + $.f(fault, "", -1)));
return $.tup($.tup(...$.it($.ga(table, "findings")), refused), false);} } else throw $e; }
return $.tup($.b.tuple(found), true); }, {p: ["table", "x", "y", "run"], ks: false});
_summarise = $.def(function (table, name, rows, values, turns, roles, mask) { let role, v, empty;
role = $.cm(roles, "get", [name, Role("", "text")]);
if ($.t(!$.in(name, values))) {return ColumnSummary(name, "", $.b.int(mask.sum()), $.ga(math, "nan"), $.ga(math, "nan"), 0, 0.0, false, $.ga(role, "role"), $.or($.ga(role, "reason"), () => "text"));}
v = $.gi(values, name);
empty = $.eq($.ga(v, "size"), 0);
return $.k(ColumnSummary, [], {"name": name, "unit": $.gi(table.label(name), 1), "samples": $.b.int($.ga(v, "size")), "minimum": ($.t(empty) ? $.ga(math, "nan") : $.b.float(v.min())), "maximum": ($.t(empty) ? $.ga(math, "nan") : $.b.float(v.max())), "loops": ($.t($.in($.ga(role, "role"), $.b.set(["time", "run"]))) ? 0 : $.fdiv($.add($.gi(turns, name), 1), 2)), "missing": $.sub(1.0, $.div($.ga(v, "size"), $.b.max(1, $.ga($.gi(rows, name), "size")))), "constant": $.and(!$.t(empty), () => is_constant(v)), "role": $.ga(role, "role"), "reason": $.ga(role, "reason")}); }, {p: ["table", "name", "rows", "values", "turns", "roles", "mask"], ks: false});
_sampling = $.def(function (table, signal, rows, clocks) { let clock, part, t, step, forward, median, low, high;
clock = ($.t(clocks) ? $.gi(clocks, 0) : null);
if ($.t((signal != null))) {{ const $v17 = suppress(TimeError); $.enter($v17); try {clock = choose_clock(table, signal, null);} catch ($e) { if (!$.exit($v17, $.caught($e))) throw $e; } }}
if ($.t((clock == null))) {return null;}
part = $.k(Table, [$.ga(table, "name"), $.dict([[clock, $.gi(rows, clock)]]), $.ga(table, "units"), $.ga(table, "rows")], {"stamps": $.ga(table, "stamps")});
t = $.gi(seconds(part, clock), 0);
t = $.gi(t, np.isfinite(t));
step = np.diff(t);
forward = $.gi(step, $.gt(step, 0));
if ($.t($.eq($.ga(forward, "size"), 0))) {return null;}
median = $.b.float(np.median(forward));
{const $v18 = $.unpack(np.percentile(forward, [5, 95]), 2, -1);low = $v18[0];high = $v18[1];}
return $.k(Sampling, [], {"column": clock, "first": $.b.float($.gi(t, 0)), "last": $.b.float($.gi(t, (-1))), "median": median, "jitter": $.div($.b.float($.sub(high, low)), $.mul(2, median)), "gaps": $.b.int(np.sum($.gt(step, gap_limit(step)))), "repeated": $.b.int(np.sum($.eq(step, 0))), "backward": $.b.int(np.sum($.lt(step, 0)))}); }, {p: ["table", "signal", "rows", "clocks"], ks: false});
_command = $.def(function (path, x, y, run, time_unit, findings) { let parts;
if (($.t((x == null)) || $.t((y == null)))) {return "";}
if ($.t(is_frame(path))) {return ("" + "dehyst.identify(dehyst.Recording.from_frame(df, input=" + $.f(x, "", 114) + ", output=" + $.f(y, "", 114) + "))");}
parts = ["dehyst", "identify", $.b.str(Path(path)), "--input", x, "--output", y];
if ($.t((run != null))) {parts = $.iadd(parts, ["--run", run]);}
if ($.t((time_unit != null))) {parts = $.iadd(parts, ["--time-unit", time_unit]);}
if ($.t($.b.any((function* () { for (const $v19 of $.it(findings)) { let finding; finding = $v19; yield $.in("--train-fraction 1", $.ga(finding, "message")); } })()))) {parts = $.iadd(parts, ["--train-fraction", "1"]);}
return typed(parts); }, {p: ["path", "x", "y", "run", "time_unit", "findings"], ks: false});
Role = $.cls("Role", [], "", [["role", null], ["reason", null]], true, true, ($c) => { Role = $c; });
_points = $.def(function (table, name, values, turns) { let bare, unit, kind, spoken, into, out, reasons, hold;
{const $v20 = $.unpack(table.label(name), 2, -1);bare = $v20[0];unit = $v20[1];}
kind = dimension(unit);
spoken = $.b.set(words(bare));
into = $.add($.cm(INPUT_POINTS, "get", [kind, 0.0]), $.b.bool($.band(spoken, INPUT_WORDS)));
out = $.add($.cm(OUTPUT_POINTS, "get", [kind, 0.0]), $.b.bool($.band(spoken, OUTPUT_WORDS)));
reasons = ($.t(kind) ? [("" + $.f(kind, "", -1) + " [" + $.f(unit, "", -1) + "]")] : []);
if ($.t($.band(spoken, COMMAND_WORDS))) {into = $.iadd(into, ($.t(!$.in(kind, $.b.set(["pressure", "voltage", "current"]))) ? 3.0 : (-0.5)));
out = $.isub(out, 4.0);
$.cm(reasons, "append", ["named like a command"]);}
if ($.t($.band(spoken, $.b.set(["velocity", "speed", "rate", "acceleration", "aux"])))) {{const $v21 = $.unpack($.tup($.sub(into, 3.0), $.sub(out, 3.0)), 2, -1);into = $v21[0];out = $v21[1];}
$.cm(reasons, "append", ["a rate or auxiliary signal"]);}
if ($.t($.band(spoken, BETWEEN_WORDS))) {into = $.iadd(into, 0.5);
$.cm(reasons, "append", ["interpolated between updates"]);}
hold = hold_length(values);
if ($.t($.gt(hold, 1.0))) {{const $v22 = $.unpack($.tup($.sub(into, 1.0), $.sub(out, 1.0)), 2, -1);into = $v22[0];out = $v22[1];}
$.cm(reasons, "append", [("" + "held for " + $.f(hold, ("" + ".0f"), -1) + " samples at a time")]);}
if ($.t($.lt(turns, 1))) {into = $.isub(into, 2.0);
$.cm(reasons, "append", ["never turns"]);}
return $.tup(into, out, $.cm(", ", "join", [reasons])); }, {p: ["table", "name", "values", "turns"], ks: false});
_relation = $.def(function (x, y) { let size, a, b, scale;
size = $.b.min($.ga(x, "size"), $.ga(y, "size"));
if (($.t($.lt(size, 3)) || $.t($.ne($.ga(x, "size"), $.ga(y, "size"))) || $.t(is_constant(x)) || $.t(is_constant(y)))) {return 0.0;}
{const $v23 = $.unpack($.tup($.sub(x, x.mean()), $.sub(y, y.mean())), 2, -1);a = $v23[0];b = $v23[1];}
scale = $.b.float($.mul($.ga(np, "linalg").norm(a), $.ga(np, "linalg").norm(b)));
return ($.t($.gt(scale, 0)) ? $.div($.b.abs($.b.float(np.dot(a, b))), scale) : 0.0); }, {p: ["x", "y"], ks: false});
guess_roles = $.def(function (table, values, paired, turns, clocks) { let roles, runs, free, points, best, drivers, followers, place, x, y, score, name, role;
roles = $.dict((() => { const $r = []; for (const $v24 of $.it(clocks)) { let name; name = $v24; $r.push([name, Role("time", "named or stepping like time")]); } return $r; })());
runs = run_column(table);
if ($.t((runs != null))) {$.si(roles, runs, Role("run", "tells recordings apart"));}
free = (() => { const $r = []; for (const $v25 of $.it($.cm(values, "items", []))) { let n, v; {const $v26 = $.unpack($v25, 2, -1);n = $v26[0];v = $v26[1];} if (($.t(!$.in(n, roles)) && $.t($.ge($.ga(v, "size"), 4)) && !$.t(is_constant(v)))) { $r.push(n); } } return $r; })();
points = $.dict((() => { const $r = []; for (const $v27 of $.it(free)) { let name; name = $v27; $r.push([name, _points(table, name, $.gi(values, name), $.gi(turns, name))]); } return $r; })());
best = $.tup(0.0, null, null);
drivers = $.gi($.k($.b.sorted, [free], {"key": $.def((n) => {  return $.neg($.gi($.gi(points, n), 0)); }, {p: ["n"], ks: false})}), $.slice(null, CANDIDATES, null));
followers = $.gi($.k($.b.sorted, [free], {"key": $.def((n) => {  return $.neg($.gi($.gi(points, n), 1)); }, {p: ["n"], ks: false})}), $.slice(null, CANDIDATES, null));
place = $.dict((() => { const $r = []; for (const $v28 of $.it($.b.enumerate($.ga(table, "order")))) { let k, name; {const $v29 = $.unpack($v28, 2, -1);k = $v29[0];name = $v29[1];} $r.push([name, k]); } return $r; })());
for (const $v30 of $.it(drivers)) { x = $v30;
{for (const $v31 of $.it(followers)) { y = $v31;
{if ($.t($.eq(x, y))) {continue;}
score = $.add($.gi($.gi(points, x), 0), $.gi($.gi(points, y), 1));
if ($.t($.gt(score, 0))) {score = $.iadd(score, $.mul(1.5, _relation($.cm(paired, "get", [x, $.gi(values, x)]), $.cm(paired, "get", [y, $.gi(values, y)]))));}
score = $.iadd(score, $.mul(0.01, $.gt($.gi(place, y), $.gi(place, x))));
if ($.t($.gt(score, $.gi(best, 0)))) {best = $.tup(score, x, y);}} }} }
for (const $v32 of $.it($.tup($.tup($.gi(best, 1), "input"), $.tup($.gi(best, 2), "output")))) { {const $v33 = $.unpack($v32, 2, -1);name = $v33[0];role = $v33[1];}
{if ($.t((name != null))) {$.si(roles, name, Role(role, $.or($.gi($.gi(points, name), 2), () => "the best match by its order and its movement")));}} }
for (const $v34 of $.it(free)) { name = $v34;
{$.cm(roles, "setdefault", [name, Role("", $.gi($.gi(points, name), 2))]);} }
for (const $v35 of $.it(values)) { name = $v35;
{$.cm(roles, "setdefault", [name, Role("", ($.t($.ga($.gi(values, name), "size")) ? "constant" : "empty"))]);} }
return $.tup(roles, $.gi(best, 1), $.gi(best, 2), _leads(points, $.gi(best, 1), $.gi(best, 2))); }, {p: ["table", "values", "paired", "turns", "clocks"], ks: false});
_leads = $.def(function (points, x, y) { let drivers, followers, others;
if (($.t((x == null)) || $.t((y == null)))) {return false;}
drivers = $.gi($.k($.b.sorted, [points], {"key": $.def((name) => {  return $.neg($.gi($.gi(points, name), 0)); }, {p: ["name"], ks: false})}), $.slice(null, 3, null));
followers = $.gi($.k($.b.sorted, [points], {"key": $.def((name) => {  return $.neg($.gi($.gi(points, name), 1)); }, {p: ["name"], ks: false})}), $.slice(null, 3, null));
others = (() => { const $r = []; for (const $v37 of $.it(drivers)) { let a; a = $v37; for (const $v36 of $.it(followers)) { let b; b = $v36; if (($.t($.ne(a, b)) && $.t($.ne($.tup(a, b), $.tup(x, y))))) { $r.push($.add($.gi($.gi(points, a), 0), $.gi($.gi(points, b), 1))); } } } return $r; })();
return $.ge($.add($.gi($.gi(points, x), 0), $.gi($.gi(points, y), 1)), $.add(CLEAR, $.k($.b.max, [others], {"default": $.neg($.ga(np, "inf"))}))); }, {p: ["points", "x", "y"], ks: false});
Object.assign($m, {"annotations": annotations, "math": math, "suppress": suppress, "dataclass": dataclass, "Path": Path, "np": np, "npt": npt, "Array": Array_, "gap_limit": gap_limit, "turning_points": turning_points, "DehystError": DehystError, "TimeError": TimeError, "Finding": Finding, "BETWEEN_WORDS": BETWEEN_WORDS, "COMMAND_WORDS": COMMAND_WORDS, "hold_length": hold_length, "is_constant": is_constant, "choose_clock": choose_clock, "clock_names": clock_names, "seconds": seconds, "unit_finding": unit_finding, "with_time_unit": with_time_unit, "count_runs": count_runs, "run_column": run_column, "select_run": select_run, "PathLike": PathLike, "read_table": read_table, "is_frame": is_frame, "WHOLE": WHOLE, "context": context, "read_pair": read_pair, "Table": Table, "measured": measured, "typed": typed, "dimension": dimension, "words": words, "INPUT_POINTS": INPUT_POINTS, "OUTPUT_POINTS": OUTPUT_POINTS, "CLEAR": CLEAR, "CANDIDATES": CANDIDATES, "INPUT_WORDS": INPUT_WORDS, "OUTPUT_WORDS": OUTPUT_WORDS, "ColumnSummary": ColumnSummary, "Sampling": Sampling, "LogSummary": LogSummary, "inspect_log": inspect_log, "_findings": _findings, "_summarise": _summarise, "_sampling": _sampling, "_command": _command, "Role": Role, "_points": _points, "_relation": _relation, "guess_roles": guess_roles, "_leads": _leads});
});
$.module("dehyst.models.arrays", ($m) => {
let annotations, math, os, np, npt, _native, Array_, ParameterError, _real, parameter_array, parameter_number, strictly_increasing, signal_array;
math = $.imp("math");
os = $.imp("os");
np = $.imp("numpy");
npt = $.imp("numpy.typing");
_native = $.imp("dehyst._native");
Array_ = $.from("dehyst.arrays", "Array");
ParameterError = $.from("dehyst.errors", "ParameterError");
_real = $.def(function (values) { let array;
if ($.t($.b.isinstance(values, $.ga($.ga(np, "ma"), "MaskedArray")))) {values = $.ga(np, "ma").filled(values.astype($.ga(np, "float64")), $.ga(np, "nan"));}
array = np.asarray(values);
if ($.t(!$.in($.ga($.ga(array, "dtype"), "kind"), "biufOUS"))) {throw $.exc($.b.TypeError(("" + "values of type " + $.f($.ga(array, "dtype"), "", -1) + " are not real numbers")));}
return array; }, {p: ["values"], ks: false});
parameter_array = $.def(function (values, name) { let array, fault, bad;
try {array = $.km(np, "array", [_real(values)], {"dtype": $.ga(np, "float64"), "copy": true, "order": "C"});} catch ($e) { $e = $.caught($e); if ($.isinst($e, $.tup($.b.TypeError, $.b.ValueError, $.b.OverflowError))) { fault = $e; {throw $.exc(ParameterError(("" + $.f(name, "", -1) + " is not a list of numbers (" + $.f(fault, "", -1) + "). Pass a one-dimensional array.")));} } else throw $e; }
if (($.t($.ne($.ga(array, "ndim"), 1)) || $.t($.eq($.ga(array, "size"), 0)))) {throw $.exc($.k(ParameterError, [("" + $.f(name, "", -1) + " has shape " + $.f($.ga(array, "shape"), "", -1) + "; pass one value per operator, shape (n,) with n >= 1.")], {"shape": $.ga(array, "shape")}));}
bad = np.flatnonzero($.inv($.le(np.abs(array), $.ga(_native, "INPUT_LIMIT"))));
if ($.t($.ga(bad, "size"))) {throw $.exc($.k(ParameterError, [("" + $.f(name, "", -1) + "[" + $.f($.gi(bad, 0), "", -1) + "] = " + $.f($.b.float($.gi(array, $.gi(bad, 0))), "", 114) + " is not a finite number of physical size (limit " + $.f($.ga(_native, "INPUT_LIMIT"), ("" + "g"), -1) + "); the model would answer with infinities. Correct or drop it.")], {"index": $.b.int($.gi(bad, 0))}));}
$.ga(array, "flags").writeable = false;
return array; }, {p: ["values", "name"], ks: false});
parameter_number = $.def(function (value, name) { let number;
try {number = $.b.float(value);} catch ($e) { $e = $.caught($e); if ($.isinst($e, $.b.OverflowError)) {  {throw $.exc(ParameterError(("" + $.f(name, "", -1) + " is beyond every floating point number; pass a finite one.")));} } else if ($.isinst($e, $.tup($.b.TypeError, $.b.ValueError))) {  {throw $.exc(ParameterError(("" + $.f(name, "", -1) + " = " + $.f(value, ("" + ".60"), 114) + " is not a number; pass one, such as 0.01.")));} } else throw $e; }
if ((!$.t(math.isfinite(number)) || $.t($.gt($.b.abs(number), $.ga(_native, "INPUT_LIMIT"))))) {throw $.exc(ParameterError(("" + $.f(name, "", -1) + " = " + $.f(number, "", 114) + " is not a finite number of physical size; pass a finite one.")));}
return number; }, {p: ["value", "name"], ks: false});
strictly_increasing = $.def(function (array, name) { let fault, k;
fault = np.flatnonzero($.le(np.diff(array), 0));
if ($.t($.ga(fault, "size"))) {k = $.b.int($.gi(fault, 0));
throw $.exc($.k(ParameterError, [("" + $.f(name, "", -1) + " must increase strictly, but " + $.f(name, "", -1) + "[" + $.f($.add(k, 1), "", -1) + "] = " + $.f($.gi(array, $.add(k, 1)), ("" + "g"), -1) + " follows " + $.f($.gi(array, k), ("" + "g"), -1) + ". Sort them and drop repeated ones.")], {"index": $.add(k, 1)}));} }, {p: ["array", "name"], ks: false});
signal_array = $.def(function (values, name) { let array, fault;
if ($.t($.b.isinstance(values, $.bor($.b.str, $.ga(os, "PathLike"))))) {throw $.exc(ParameterError(("" + $.f(name, "", -1) + " is the path " + $.f($.b.str(values), ("" + ".80"), 114) + ", and its samples are needed. Type: log = dehyst.read_log(" + $.f($.b.str(values), ("" + ".80"), 114) + ", input='...', output='...'), and give log.input or log.output.")));}
try {array = $.km(np, "ascontiguousarray", [_real(values)], {"dtype": $.ga(np, "float64")});} catch ($e) { $e = $.caught($e); if ($.isinst($e, $.tup($.b.TypeError, $.b.ValueError, $.b.OverflowError))) { fault = $e; {throw $.exc(ParameterError(("" + $.f(name, "", -1) + " is not a sequence of numbers (" + $.f(fault, "", -1) + ").")));} } else throw $e; }
if ($.t($.ne(np.ndim(values), 1))) {throw $.exc($.k(ParameterError, [("" + $.f(name, "", -1) + " has shape " + $.f(np.shape(values), "", -1) + "; pass one value a sample, shape (T,), for example data[:, 0], or use model.stepper() for single samples.")], {"shape": np.shape(values)}));}
return array; }, {p: ["values", "name"], ks: false});
Object.assign($m, {"annotations": annotations, "math": math, "os": os, "np": np, "npt": npt, "_native": _native, "Array": Array_, "ParameterError": ParameterError, "_real": _real, "parameter_array": parameter_array, "parameter_number": parameter_number, "strictly_increasing": strictly_increasing, "signal_array": signal_array});
});
$.module("dehyst.models.base", ($m) => {
let annotations, warnings, abstractmethod, TYPE_CHECKING, ClassVar, Literal, Self, TypeAlias, np, npt, _native, StackStepper, Stepper, Array_, ParameterError, signal_array, Direction, Machine, play_machine, Band, Model, Past, Plays, check_past, half_width, held, start_states, __all__, StepMethod, _NO_MAP, DENSE_UP_TO, RejectedSamplesWarning, HysteresisModel, _mapped, make_stepper, check_state;
warnings = $.imp("warnings");
abstractmethod = $.from("abc", "abstractmethod");
TYPE_CHECKING = $.from("typing", "TYPE_CHECKING");ClassVar = $.from("typing", "ClassVar");Literal = $.from("typing", "Literal");Self = $.from("typing", "Self");TypeAlias = $.from("typing", "TypeAlias");
np = $.imp("numpy");
npt = $.imp("numpy.typing");
_native = $.imp("dehyst._native");
StackStepper = $.from("dehyst._native", "StackStepper");Stepper = $.from("dehyst._native", "Stepper");
Array_ = $.from("dehyst.arrays", "Array");
ParameterError = $.from("dehyst.errors", "ParameterError");
signal_array = $.from("dehyst.models.arrays", "signal_array");
Direction = $.from("dehyst.models.machine", "Direction");Machine = $.from("dehyst.models.machine", "Machine");play_machine = $.from("dehyst.models.machine", "play_machine");
Band = $.from("dehyst.models.model", "Band");Model = $.from("dehyst.models.model", "Model");
Past = $.from("dehyst.models.unknown", "Past");Plays = $.from("dehyst.models.unknown", "Plays");check_past = $.from("dehyst.models.unknown", "check_past");half_width = $.from("dehyst.models.unknown", "half_width");held = $.from("dehyst.models.unknown", "held");start_states = $.from("dehyst.models.unknown", "start_states");
__all__ = ["HysteresisModel", "RejectedSamplesWarning", "StackStepper", "StepMethod", "Stepper"];
StepMethod = $.bor($.bor($.gi(Literal, $.tup("auto", "dense", "logarithmic")), $.b.float), null);
_NO_MAP = np.zeros(0);
DENSE_UP_TO = 100;
RejectedSamplesWarning = $.cls("RejectedSamplesWarning", [$.b.UserWarning], "", [], false, true, ($c) => { RejectedSamplesWarning = $c; });
HysteresisModel = $.cls("HysteresisModel", [Model], "", [], false, true, ($c) => { HysteresisModel = $c; $.static($c, "bounded", true);$.static($c, "core", "plays");$.static($c, "closeness", 1e-09);$.static($c, "family", "");$.meth($c, "inverse", $.def(function () { const self = this;
 }, {p: [], ks: false}));
$.prop($c, "kinds", $.def(function () { const self = this;let mapped;
mapped = $.b.any((function* () { for (const $v1 of $.it($.ga(self, "maps"))) { let each; each = $v1; yield (each != null); } })());
return ($.t(mapped) ? $.tup($.gi($.ga(self, "operators"), 0), "map") : $.tup($.gi($.ga(self, "operators"), 0))); }, {p: [], ks: false}));
$.meth($c, "with_state", $.def(function (state) { const self = this;
 }, {p: ["state"], ks: false}));
$.meth($c, "stepper", $.def(function (method = "auto") { const self = this;
 }, {p: ["method"], ks: false}));
$.prop($c, "inverse_gain", $.def(function () { const self = this;
 }, {p: [], ks: false}));
$.prop($c, "parts", $.def(function () { const self = this;
return $.tup($.ga($.ga(self, "radii"), "size"), "operators"); }, {p: [], ks: false}));
$.meth($c, "times", $.def(function (factor) { const self = this;
return null; }, {p: ["factor"], ks: false}));
$.prop($c, "radii", $.def(function () { const self = this;
return $.ga($.gi(self._plays(), 0), "thresholds"); }, {p: [], ks: false}));
$.meth($c, "__repr__", $.def(function () { const self = this;let operators;
operators = ($.t($.ga(self, "nonzero_weights")) ? ("" + $.f($.ga(self, "nonzero_weights"), "", -1) + " of " + $.f($.ga($.ga(self.stepper(), "state"), "size"), "", -1) + " operators") : "curve");
return ("" + "<" + $.f($.ga($.b.type(self), "__name__"), "", -1) + " " + $.f($.ga(self, "family"), "", 114) + ": " + $.f(operators, "", -1) + ", " + $.f($.ga($.ga(self, "card"), "input"), "", 115) + " -> " + $.f($.ga($.ga(self, "card"), "output"), "", 115) + ">"); }, {p: [], ks: false}));
$.meth($c, "simulate", $.def(function (x, time = null, signals = $.dict()) { const self = this;let inputs, y, rejected;
inputs = signal_array(x, "input x");
self.given(signals, $.ga(inputs, "size"));
{const $v2 = $.unpack(self.stepper("dense").simulate(inputs), 2, -1);y = $v2[0];rejected = $v2[1];}
if ($.t(rejected)) {$.km(warnings, "warn", [("" + $.f(rejected, "", -1) + " of " + $.f($.ga(y, "size"), "", -1) + " samples are not finite (or beyond " + $.f($.ga(_native, "INPUT_LIMIT"), ("" + "g"), -1) + "); the last good output was held for them and the state did not move. Clean the input, or read it with dehyst.read_log."), RejectedSamplesWarning], {"stacklevel": 2});}
return y; }, {p: ["x", "time"], ks: true}));
$.meth($c, "at_rest", $.def(function (first) { const self = this;let plays, before, _, value;
{const $v3 = $.unpack(self._plays(), 3, -1);plays = $v3[0];before = $v3[1];_ = $v3[2];}
value = ($.t((before == null)) ? $.b.float(first) : $.b.float($.gi(before([first]), 0)));
return self.with_state(np.full($.ga($.ga(plays, "thresholds"), "size"), $.sub(value, $.ga(plays, "center")))); }, {p: ["first"], ks: false}));
$.meth($c, "interval", $.def(function (x, known = null, past = null) { const self = this;
return self._bounds(signal_array(x, "input x"), known, past); }, {p: ["x", "known", "past"], ks: false}));
$.meth($c, "extreme_states", $.def(function (first, known = null, past = null) { const self = this;let plays, before, _, value, start;
{const $v4 = $.unpack(self._plays(), 3, -1);plays = $v4[0];before = $v4[1];_ = $v4[2];}
value = ($.t((before == null)) ? $.b.float(first) : $.b.float($.gi(before([first]), 0)));
start = start_states(plays, value, known, _mapped(past, before));
return $.tup($.ga(start, "lowest"), $.ga(start, "highest")); }, {p: ["first", "known", "past"], ks: false}));
$.prop($c, "usual_past", $.def(function () { const self = this;let low, high;
{const $v5 = $.unpack($.tup($.ga($.ga($.ga(self, "card"), "input"), "low"), $.ga($.ga($.ga(self, "card"), "input"), "high")), 2, -1);low = $v5[0];high = $v5[1];}
return (($.t((low == null)) || $.t((high == null)) || !$.t($.lt(low, high))) ? null : $.tup(low, high)); }, {p: [], ks: false}));
$.meth($c, "band", $.def(function (x, time = null, past = null, signals = $.dict()) { const self = this;let low, high;
{const $v6 = $.unpack($.km(self, "interval", [x], {"past": past}), 2, -1);low = $v6[0];high = $v6[1];}
return Band($.mul(0.5, $.add(low, high)), low, high, $.mul(0.5, $.sub(high, low)), $.km(self, "certainty", [x], {"past": past})); }, {p: ["x", "time", "past"], ks: true}));
$.meth($c, "certainty", $.def(function (x, known = null, past = null) { const self = this;let plays, _, low, high, first, whole, share, width;
{const $v7 = $.unpack(self._plays(), 3, -1);plays = $v7[0];_ = $v7[1];_ = $v7[2];}
{const $v8 = $.unpack(self._operator_interval(signal_array(x, "input x"), known, past), 3, -1);low = $v8[0];high = $v8[1];first = $v8[2];}
whole = $.mul(2.0, $.b.float(half_width(plays, 0.0)));
share = np.zeros($.ga(low, "size"));
if ($.t($.lt(first, $.ga(low, "size")))) {width = $.gi($.sub(high, low), $.slice(first, null, null));
$.si(share, $.slice(first, null, null), ($.t($.eq(whole, 0.0)) ? 1.0 : $.ga(np, "maximum").accumulate(np.clip($.sub(1.0, $.div(width, whole)), 0.0, 1.0))));}
return share; }, {p: ["x", "known", "past"], ks: false}));
$.meth($c, "with_operator", $.def(function (operator) { const self = this;
return operator; }, {p: ["operator"], ks: false}));
$.meth($c, "_plays", $.def(function () { const self = this;
throw $.exc($.b.NotImplementedError(("" + "a " + $.f($.ga($.b.type(self), "__name__"), "", -1) + " does not say what its memory is"))); }, {p: [], ks: false}));
$.meth($c, "_bounds", $.def(function (x, known, past) { const self = this;let _, after, low, high, first, ends;
{const $v9 = $.unpack(self._plays(), 3, -1);_ = $v9[0];_ = $v9[1];after = $v9[2];}
{const $v10 = $.unpack(self._operator_interval(x, known, past), 3, -1);low = $v10[0];high = $v10[1];first = $v10[2];}
if (($.t((after != null)) && $.t($.lt(first, $.ga(x, "size"))))) {ends = $.tup(after($.gi(low, $.slice(first, null, null))), after($.gi(high, $.slice(first, null, null))));
{const $v11 = $.unpack(($.t($.ga(after, "increasing")) ? ends : $.gi(ends, $.slice(null, null, (-1)))), 2, -1);$.si(low, $.slice(first, null, null), $v11[0]);$.si(high, $.slice(first, null, null), $v11[1]);}}
return $.tup(low, high); }, {p: ["x", "known", "past"], ks: false}));
$.meth($c, "_operator_interval", $.def(function (x, known, past) { const self = this;let _, before, values, first, low, high, u;
{const $v12 = $.unpack(self._plays(), 3, -1);_ = $v12[0];before = $v12[1];_ = $v12[2];}
{const $v13 = $.unpack(held(x, $.ga(_native, "INPUT_LIMIT")), 2, -1);values = $v13[0];first = $v13[1];}
{const $v14 = $.unpack($.tup(np.full($.ga(x, "size"), $.neg($.ga(np, "inf"))), np.full($.ga(x, "size"), $.ga(np, "inf"))), 2, -1);low = $v14[0];high = $v14[1];}
if ($.t($.lt(first, $.ga(x, "size")))) {u = ($.t((before == null)) ? $.gi(values, $.slice(first, null, null)) : before($.gi(values, $.slice(first, null, null))));
{const $v15 = $.unpack(self._inner()._operator_bounds(u, known, _mapped(past, before)), 2, -1);$.si(low, $.slice(first, null, null), $v15[0]);$.si(high, $.slice(first, null, null), $v15[1]);}}
return $.tup(low, high, first); }, {p: ["x", "known", "past"], ks: false}));
$.meth($c, "_operator_bounds", $.def(function (u, known, past) { const self = this;
throw $.exc($.b.NotImplementedError(("" + "a " + $.f($.ga($.b.type(self), "__name__"), "", -1) + " is no operator"))); }, {p: ["u", "known", "past"], ks: false}));
$.meth($c, "_inner", $.def(function () { const self = this;
return self; }, {p: [], ks: false}));
$.meth($c, "machine", $.def(function (direction, range, ramp, period) { const self = this;
return play_machine(self, direction, range, ramp); }, {p: ["direction", "range", "ramp", "period"], ks: false}));
$.meth($c, "final_state", $.def(function (x) { const self = this;let step;
step = self.stepper("dense");
step.simulate(signal_array(x, "input x"));
return $.ga(step, "state"); }, {p: ["x"], ks: false}));
$.meth($c, "moved", $.def(function (x) { const self = this;
return self.with_state(self.final_state(x)); }, {p: ["x"], ks: false}));});
_mapped = $.def(function (past, before) { let ends;
past = check_past(past);
if (($.t((past == null)) || $.t((before == null)))) {return past;}
ends = before($.b.list(past));
return $.tup($.b.float(np.min(ends)), $.b.float(np.max(ends))); }, {p: ["past", "before"], ks: false});
make_stepper = $.def(function (thresholds, weights, center, offset, state, before = null, after = null, method = "auto") { let dense, before_u, before_v, after_u, after_v, kind;
if (($.t((method == null)) || $.t($.b.isinstance(method, $.tup($.b.int, $.b.float))))) {method = "auto";}
if ($.t(!$.in(method, $.tup("auto", "dense", "logarithmic")))) {throw $.exc($.k(ParameterError, [("" + "method = " + $.f(method, ("" + ".40"), 114) + " is no way to step; pass 'dense' (time proportional to the number of operators, bits of exported code), 'logarithmic' (for many operators) or 'auto'.")], {"method": method}));}
dense = $.or($.eq(method, "dense"), () => $.and($.eq(method, "auto"), () => $.le($.ga(thresholds, "size"), DENSE_UP_TO)));
{const $v16 = $.unpack(($.t((before != null)) ? before : $.tup(_NO_MAP, _NO_MAP)), 2, -1);before_u = $v16[0];before_v = $v16[1];}
{const $v17 = $.unpack(($.t((after != null)) ? after : $.tup(_NO_MAP, _NO_MAP)), 2, -1);after_u = $v17[0];after_v = $v17[1];}
kind = ($.t(dense) ? Stepper : StackStepper);
return kind(thresholds, weights, center, offset, before_u, before_v, after_u, after_v, state); }, {p: ["thresholds", "weights", "center", "offset", "state", "before", "after", "method"], ks: false});
check_state = $.def(function (state, thresholds) { let slack, fault, k;
if ($.t($.ne($.ga(state, "size"), $.ga(thresholds, "size")))) {throw $.exc($.k(ParameterError, [("" + "state has " + $.f($.ga(state, "size"), "", -1) + " values for " + $.f($.ga(thresholds, "size"), "", -1) + " play operators; pass one per operator, or state=None for the model at rest in its centre.")], {"state": $.ga(state, "size"), "operators": $.ga(thresholds, "size")}));}
slack = $.mul(1e-09, $.b.max($.b.float($.gi(thresholds, (-1))), $.b.float(np.max(np.abs(state))), 1e-300));
fault = np.flatnonzero($.gt(np.abs(np.diff(state)), $.add(np.diff(thresholds), slack)));
if ($.t($.ga(fault, "size"))) {k = $.b.int($.gi(fault, 0));
throw $.exc($.k(ParameterError, [("" + "state is not admissible: |z[" + $.f(k, "", -1) + "] - z[" + $.f($.add(k, 1), "", -1) + "]| = " + $.f($.b.abs($.sub($.gi(state, k), $.gi(state, $.add(k, 1)))), ("" + "g"), -1) + " exceeds r[" + $.f($.add(k, 1), "", -1) + "] - r[" + $.f(k, "", -1) + "] = " + $.f($.sub($.gi(thresholds, $.add(k, 1)), $.gi(thresholds, k)), ("" + "g"), -1) + ". No input can produce it, and the inverse would be wrong. Use model.final_state(x) of a real input, or state=None.")], {"index": k}));} }, {p: ["state", "thresholds"], ks: false});
Object.assign($m, {"annotations": annotations, "warnings": warnings, "abstractmethod": abstractmethod, "TYPE_CHECKING": TYPE_CHECKING, "ClassVar": ClassVar, "Literal": Literal, "Self": Self, "TypeAlias": TypeAlias, "np": np, "npt": npt, "_native": _native, "StackStepper": StackStepper, "Stepper": Stepper, "Array": Array_, "ParameterError": ParameterError, "signal_array": signal_array, "Direction": Direction, "Machine": Machine, "play_machine": play_machine, "Band": Band, "Model": Model, "Past": Past, "Plays": Plays, "check_past": check_past, "half_width": half_width, "held": held, "start_states": start_states, "__all__": __all__, "StepMethod": StepMethod, "_NO_MAP": _NO_MAP, "DENSE_UP_TO": DENSE_UP_TO, "RejectedSamplesWarning": RejectedSamplesWarning, "HysteresisModel": HysteresisModel, "_mapped": _mapped, "make_stepper": make_stepper, "check_state": check_state});
});
$.module("dehyst.models.card", ($m) => {
let annotations, Mapping, dataclass, field, Any, Array_, Finding, visible, canonical, convert, SignalCard, ModelCard, NO_CARD, in_units_of;
Mapping = $.from("collections.abc", "Mapping");
dataclass = $.from("dataclasses", "dataclass");field = $.from("dataclasses", "field");
Any = $.from("typing", "Any");
Array_ = $.from("dehyst.arrays", "Array");
Finding = $.from("dehyst.findings", "Finding");
visible = $.from("dehyst.shell", "visible");
canonical = $.from("dehyst.units", "canonical");convert = $.from("dehyst.units", "convert");
SignalCard = $.cls("SignalCard", [], "", [["name", null], ["unit", () => ""], ["low", () => null], ["high", () => null]], true, true, ($c) => { SignalCard = $c; $.prop($c, "label", $.def(function () { const self = this;
return ($.t($.ga(self, "unit")) ? ("" + $.f($.ga(self, "name"), "", -1) + " [" + $.f($.ga(self, "unit"), "", -1) + "]") : $.ga(self, "name")); }, {p: [], ks: false}));
$.meth($c, "__str__", $.def(function () { const self = this;let label;
label = visible($.ga(self, "label"));
label = ($.t($.le($.b.len(label), 60)) ? label : ("" + $.f($.gi(label, $.slice(null, 57, null)), "", -1) + "..."));
return (($.t(($.ga(self, "low") == null)) || $.t(($.ga(self, "high") == null))) ? label : ("" + $.f(label, "", -1) + " " + $.f($.ga(self, "low"), ("" + "z.4g"), -1) + " to " + $.f($.ga(self, "high"), ("" + "z.4g"), -1))); }, {p: [], ks: false}));});
ModelCard = $.cls("ModelCard", [], "", [["input", () => SignalCard("input")], ["output", () => SignalCard("output")], ["provenance", () => $.b.dict()]], true, true, ($c) => { ModelCard = $c; $.meth($c, "__post_init__", $.def(function () { const self = this;
$.seta(self, "provenance", $.b.dict($.ga(self, "provenance"))); }, {p: [], ks: false}));
$.meth($c, "swapped", $.def(function () { const self = this;
return ModelCard($.ga(self, "output"), $.ga(self, "input"), $.ga(self, "provenance")); }, {p: [], ks: false}));});
NO_CARD = ModelCard();
in_units_of = $.def(function (card, values, unit, column) { let said;
if (($.t($.eq(unit, $.ga(card, "unit"))) || $.t((($t0, $t1) => $.t($.eq(canonical(unit), ($t0 = canonical($.ga(card, "unit"))))) && $.t(($t0 != null)))()))) {return $.tup(values, []);}
if ((!$.t(unit) || !$.t($.ga(card, "unit")))) {return $.tup(values, [Finding("unit-unknown", ("" + "column " + $.f(column, "", -1) + " is in '" + $.f($.or(unit, () => "unknown"), "", -1) + "', the model in '" + $.f($.or($.ga(card, "unit"), () => "unknown"), "", -1) + "': the values were taken as they are. Name the unit in the column, for example " + $.f($.ga(card, "name"), "", -1) + "_" + $.f($.or($.ga(card, "unit"), () => "bar"), "", -1) + "."))]);}
said = Finding("unit-converted", ("" + "column " + $.f(column, "", -1) + " was converted from " + $.f(unit, "", -1) + " to " + $.f($.ga(card, "unit"), "", -1) + "."));
return $.tup(convert(values, unit, $.ga(card, "unit")), [said]); }, {p: ["card", "values", "unit", "column"], ks: false});
Object.assign($m, {"annotations": annotations, "Mapping": Mapping, "dataclass": dataclass, "field": field, "Any": Any, "Array": Array_, "Finding": Finding, "visible": visible, "canonical": canonical, "convert": convert, "SignalCard": SignalCard, "ModelCard": ModelCard, "NO_CARD": NO_CARD, "in_units_of": in_units_of});
});
$.module("dehyst.models.model", ($m) => {
let annotations, json, os, warnings, ABC, abstractmethod, Mapping, dataclass, replace, Path, TYPE_CHECKING, Any, ClassVar, Generic, NamedTuple, Self, TypeVar, np, npt, Array_, DehystError, InvertibilityError, ParameterError, parameter_number, ModelCard, SignalCard, Direction, Machine, following, offset_numbers, width, save_model, M, TOO_SLOW, Band, WeightTable, Model, Inverted, Steps, require_model, without_inverse, positive_period, _fault_of;
json = $.imp("json");
os = $.imp("os");
warnings = $.imp("warnings");
ABC = $.from("abc", "ABC");abstractmethod = $.from("abc", "abstractmethod");
Mapping = $.from("collections.abc", "Mapping");
dataclass = $.from("dataclasses", "dataclass");replace = $.from("dataclasses", "replace");
Path = $.from("pathlib", "Path");
TYPE_CHECKING = $.from("typing", "TYPE_CHECKING");Any = $.from("typing", "Any");ClassVar = $.from("typing", "ClassVar");Generic = $.from("typing", "Generic");NamedTuple = $.from("typing", "NamedTuple");Self = $.from("typing", "Self");TypeVar = $.from("typing", "TypeVar");
np = $.imp("numpy");
npt = $.imp("numpy.typing");
Array_ = $.from("dehyst.arrays", "Array");
DehystError = $.from("dehyst.errors", "DehystError");InvertibilityError = $.from("dehyst.errors", "InvertibilityError");ParameterError = $.from("dehyst.errors", "ParameterError");
parameter_number = $.from("dehyst.models.arrays", "parameter_number");
ModelCard = $.from("dehyst.models.card", "ModelCard");SignalCard = $.from("dehyst.models.card", "SignalCard");
Direction = $.from("dehyst.models.machine", "Direction");Machine = $.from("dehyst.models.machine", "Machine");
following = $.from("dehyst.models.offset", "following");offset_numbers = $.from("dehyst.models.offset", "offset_numbers");width = $.from("dehyst.models.offset", "width");
save_model = $.from("dehyst.models.storage", "save_model");
M = $.k(TypeVar, ["M"], {"bound": "Model"});
TOO_SLOW = 10.0;
Band = $.cls("Band", [], "NamedTuple", [["middle", null], ["low", null], ["high", null], ["half_width", null], ["certainty", null]], false, true, ($c) => { Band = $c; });
WeightTable = $.cls("WeightTable", [], "NamedTuple", [["name", null], ["label", null], ["unit", null], ["scale", null], ["weights", null]], false, true, ($c) => { WeightTable = $c; });
Model = $.cls("Model", [], "", [], false, true, ($c) => { Model = $c; $.static($c, "direction", "forward");$.static($c, "bounded", false);$.static($c, "closeness", 1e-06);$.static($c, "judged_backward", false);$.static($c, "shear", null);$.static($c, "period", 0.0);$.static($c, "dead_time", 0.0);$.static($c, "file_kind", "dehyst-model");$.static($c, "core", "");$.prop($c, "family", $.def(function () { const self = this;
 }, {p: [], ks: false}));
$.prop($c, "rate_dependent", $.def(function () { const self = this;
return false; }, {p: [], ks: false}));
$.prop($c, "context", $.def(function () { const self = this;
return $.tup(); }, {p: [], ks: false}));
$.prop($c, "needs", $.def(function () { const self = this;
return $.b.tuple((function* () { for (const $v1 of $.it($.ga(self, "context"))) { let card; card = $v1; yield $.ga(card, "name"); } })()); }, {p: [], ks: false}));
$.prop($c, "no_inverse", $.def(function () { const self = this;
return _fault_of($.ga(self, "inverse")); }, {p: [], ks: false}));
$.prop($c, "no_forward", $.def(function () { const self = this;
return ""; }, {p: [], ks: false}));
$.prop($c, "unit_needs", $.def(function () { const self = this;
return $.ga(self, "needs"); }, {p: [], ks: false}));
$.prop($c, "no_export", $.def(function () { const self = this;
if ($.t($.ga(self, "core"))) {return "";}
return ("" + "a " + $.f($.ga(self, "family"), "", -1) + " model runs in Python alone, with `dehyst simulate` and `dehyst compensate`. For a target identify the same log again without --family: `dehyst identify LOG` chooses among sums of elements, which run everywhere."); }, {p: [], ks: false}));
$.prop($c, "nonzero_weights", $.def(function () { const self = this;
 }, {p: [], ks: false}));
$.prop($c, "free_parameters", $.def(function () { const self = this;
return $.add($.ga(self, "nonzero_weights"), $.or($.b.sum((function* () { for (const $v2 of $.it($.ga(self, "maps"))) { let each; each = $v2; if ($.t((each != null))) { yield $.ga($.ga(each, "v"), "size"); } } })()), () => 1)); }, {p: [], ks: false}));
$.prop($c, "remarks", $.def(function () { const self = this;
return $.tup(); }, {p: [], ks: false}));
$.prop($c, "kinds", $.def(function () { const self = this;
return $.tup($.ga(self, "family")); }, {p: [], ks: false}));
$.prop($c, "weight_tables", $.def(function () { const self = this;
return $.tup(); }, {p: [], ks: false}));
$.prop($c, "play_core", $.def(function () { const self = this;
return null; }, {p: [], ks: false}));
$.prop($c, "operators", $.def(function () { const self = this;
return $.tup("play", np.zeros(0), null); }, {p: [], ks: false}));
$.prop($c, "maps", $.def(function () { const self = this;
return $.tup(null, null); }, {p: [], ks: false}));
$.prop($c, "parts", $.def(function () { const self = this;
return $.tup(0, "parts"); }, {p: [], ks: false}));
$.meth($c, "simulate", $.def(function (x, time = null, signals = $.dict()) { const self = this;
 }, {p: ["x", "time"], ks: true}));
$.meth($c, "simulate_following", $.def(function (x, measured, limit, time = null, signals = $.dict()) { const self = this;let said, numbers;
said = $.km(self, "simulate", [x, time], {...$.obj(signals)});
numbers = offset_numbers(limit, width($.ga($.ga(self, "card"), "output"), said), width($.ga($.ga(self, "card"), "input"), x));
return following(x, said, measured, numbers); }, {p: ["x", "measured", "limit", "time"], ks: true}));
$.meth($c, "machine", $.def(function (direction, range, ramp, period) { const self = this;
throw $.exc(ParameterError($.ga(self, "no_export"))); }, {p: ["direction", "range", "ramp", "period"], ks: false}));
$.meth($c, "inverse", $.def(function () { const self = this;
 }, {p: [], ks: false}));
$.prop($c, "ends", $.def(function () { const self = this;let low, high;
{const $v3 = $.unpack($.tup($.ga($.ga($.ga(self, "card"), "input"), "low"), $.ga($.ga($.ga(self, "card"), "input"), "high")), 2, -1);low = $v3[0];high = $v3[1];}
return (($.t((low == null)) || $.t((high == null))) ? $.tup((-1.0), 1.0) : $.tup($.b.float(low), $.b.float(high))); }, {p: [], ks: false}));
$.prop($c, "usual_past", $.def(function () { const self = this;
return null; }, {p: [], ks: false}));
$.prop($c, "prompt", $.def(function () { const self = this;
return self; }, {p: [], ks: false}));
$.meth($c, "ahead", $.def(function (demand, every = 1) { const self = this;
return demand; }, {p: ["demand", "every"], ks: false}));
$.meth($c, "lost", $.def(function (y) { const self = this;
return 0; }, {p: ["y"], ks: false}));
$.meth($c, "too_slow", $.def(function (period) { const self = this;
if ((!$.t($.ga(self, "rate_dependent")) || !$.t((($t0, $t1) => $.t($.lt(0.0, ($t0 = $.mul(TOO_SLOW, $.ga(self, "period"))))) && $.t($.lt($t0, period)))()))) {return "";}
return ("" + "a period of " + $.f(period, ("" + "g"), -1) + " s is " + $.f($.div(period, $.ga(self, "period")), ("" + ".3g"), -1) + " times that of the log, " + $.f($.ga(self, "period"), ("" + "g"), -1) + " s: this " + $.f($.ga(self, "family"), "", -1) + " model depends on time, and what happens within a period is lost. Give it in seconds: " + $.f($.ga(self, "period"), ("" + "g"), -1) + ", or less."); }, {p: ["period"], ks: false}));
$.meth($c, "stepper", $.def(function (period = null) { const self = this;
 }, {p: ["period"], ks: false}));
$.meth($c, "compensator", $.def(function () { const self = this;
return self.inverse(); }, {p: [], ks: false}));
$.meth($c, "with_card", $.def(function (card) { const self = this;
return $.k(replace, [self], {"card": card}); }, {p: ["card"], ks: false}));
$.meth($c, "at_rest", $.def(function (first) { const self = this;
 }, {p: ["first"], ks: false}));
$.meth($c, "moved", $.def(function (x) { const self = this;
return null; }, {p: ["x"], ks: false}));
$.meth($c, "file_parameters", $.def(function () { const self = this;
 }, {p: [], ks: false}));
$.meth($c, "_content", $.def(function () { const self = this;let signals;
signals = (function* () { for (const $v4 of $.it($.tup($.ga($.ga(self, "card"), "input"), $.ga($.ga(self, "card"), "output")))) { let card; card = $v4; yield $.tup($.ga(card, "name"), $.ga(card, "unit")); } })();
return $.km(json, "dumps", [[$.ga(self, "file_kind"), $.ga(self, "family"), $.ga(self, "direction"), ...$.it(signals), self.file_parameters()]], {"sort_keys": true}); }, {p: [], ks: false}));
$.meth($c, "__eq__", $.def(function (other) { const self = this;
return ($.t($.b.isinstance(other, Model)) ? $.eq(self._content(), other._content()) : $.b.NotImplemented); }, {p: ["other"], ks: false}));
$.meth($c, "__hash__", $.def(function () { const self = this;
return $.b.hash(self._content()); }, {p: [], ks: false}));
$.meth($c, "pruned", $.def(function () { const self = this;
return self; }, {p: [], ks: false}));
$.meth($c, "replay", $.def(function (x, y, time = null, signals = $.dict()) { const self = this;
return $.km(self, "simulate", [x, time], {...$.obj(signals)}); }, {p: ["x", "y", "time"], ks: true}));
$.meth($c, "band", $.def(function (x, time = null, past = null, signals = $.dict()) { const self = this;
throw $.exc(ParameterError(("" + "an unknown past (--unknown-state, --start unknown) needs a model whose memory is bounded, as plays have (--family modified-pi); this is " + $.f($.ga(self, "family"), "", -1) + ". Leave it out, or choose --start rest."))); }, {p: ["x", "time", "past"], ks: true}));
$.meth($c, "save", $.def(function (path) { const self = this;
return save_model(self, path); }, {p: ["path"], ks: false}));
$.meth($c, "given", $.def(function (signals, size) { const self = this;let missing, spare, fault;
missing = (() => { const $r = []; for (const $v5 of $.it($.ga(self, "needs"))) { let name; name = $v5; if ($.t(!$.in(name, signals))) { $r.push(name); } } return $r; })();
spare = (() => { const $r = []; for (const $v6 of $.it(signals)) { let name; name = $v6; if ($.t(!$.in(name, $.ga(self, "needs")))) { $r.push(name); } } return $r; })();
if ($.t(missing)) {throw $.exc($.k(ParameterError, [("" + "the model depends on '" + $.f($.gi(missing, 0), "", -1) + "', which was not given. Pass " + $.f($.gi(missing, 0), "", -1) + "=values, one for each of the " + $.f(size, "", -1) + " samples, or one number.")], {"signal": $.gi(missing, 0)}));}
if ($.t(spare)) {throw $.exc($.k(ParameterError, [("" + "this " + $.f($.ga(self, "family"), "", -1) + " model takes no '" + $.f($.gi(spare, 0), "", -1) + "'; it needs " + $.f($.or($.cm(", ", "join", [$.ga(self, "needs")]), () => "no signal"), "", -1) + " beside its input. Leave it out.")], {"signal": $.gi(spare, 0)}));}
try {return $.dict((() => { const $r = []; for (const $v7 of $.it($.cm(signals, "items", []))) { let name, values; {const $v8 = $.unpack($v7, 2, -1);name = $v8[0];values = $v8[1];} $r.push([name, np.ascontiguousarray(np.broadcast_to($.km(np, "asarray", [values], {"dtype": $.ga(np, "float64")}), $.tup(size)))]); } return $r; })());} catch ($e) { $e = $.caught($e); if ($.isinst($e, $.tup($.b.TypeError, $.b.ValueError))) { fault = $e; {throw $.exc(ParameterError(("" + "a scheduling signal is not one number a sample, (" + $.f(size, "", -1) + ",): " + $.f(fault, "", -1) + ".")));} } else throw $e; } }, {p: ["signals", "size"], ks: false}));});
Inverted = $.cls("Inverted", [Model], "", [["of", null]], true, false, ($c) => { Inverted = $c; $.prop($c, "family", $.def(function () { const self = this;
return $.ga($.ga(self, "of"), "family"); }, {p: [], ks: false}));
$.prop($c, "card", $.def(function () { const self = this;
return $.ga($.ga(self, "of"), "card").swapped(); }, {p: [], ks: false}));
$.prop($c, "rate_dependent", $.def(function () { const self = this;
return $.ga($.ga(self, "of"), "rate_dependent"); }, {p: [], ks: false}));
$.prop($c, "context", $.def(function () { const self = this;
return $.ga($.ga(self, "of"), "context"); }, {p: [], ks: false}));
$.prop($c, "nonzero_weights", $.def(function () { const self = this;
return $.ga($.ga(self, "of"), "nonzero_weights"); }, {p: [], ks: false}));
$.meth($c, "inverse", $.def(function () { const self = this;
return $.ga(self, "of"); }, {p: [], ks: false}));
$.meth($c, "_content", $.def(function () { const self = this;
return ("" + "inverse of " + $.f($.ga(self, "of")._content(), "", -1)); }, {p: [], ks: false}));
$.meth($c, "with_card", $.def(function (card) { const self = this;
return $.k(replace, [self], {"of": $.ga(self, "of").with_card(card.swapped())}); }, {p: ["card"], ks: false}));
$.meth($c, "at_rest", $.def(function (first) { const self = this;
return $.k(replace, [self], {"of": $.ga(self, "of").at_rest(first)}); }, {p: ["first"], ks: false}));
$.meth($c, "pruned", $.def(function () { const self = this;
return $.k(replace, [self], {"of": $.ga(self, "of").pruned()}); }, {p: [], ks: false}));
$.meth($c, "file_parameters", $.def(function () { const self = this;
throw $.exc(ParameterError("an inverse has no file of its own; save the model, .of, and invert it again.")); }, {p: [], ks: false}));});
Steps = $.cls("Steps", [], "", [], false, true, ($c) => { Steps = $c; $.static($c, "rejected", false);$.static($c, "rejected_ever", false);$.meth($c, "__init__", $.def(function (model, period = null) { const self = this;let slow;
{const $v9 = $.unpack($.tup($.ga(model, "needs"), $.ga(model, "family"), $.ga(model, "rate_dependent")), 3, -1);self._needs = $v9[0];self._family = $v9[1];self._timed = $v9[2];}
self.period = ($.t((period == null)) ? $.ga(model, "period") : positive_period(period));
self.output = 0.0;
if ($.t((slow = model.too_slow($.ga(self, "period"))))) {$.km(warnings, "warn", [slow, $.b.UserWarning], {"stacklevel": 3});} }, {p: ["model", "period"], ks: false}));
$.meth($c, "reset", $.def(function () { const self = this;
 }, {p: [], ks: false}));
$.meth($c, "__call__", $.def(function (value, period = null, signals = $.dict()) { const self = this;
 }, {p: ["value", "period"], ks: true}));
$.meth($c, "_passed", $.def(function (period) { const self = this;let passed;
passed = ($.t((period == null)) ? $.ga(self, "period") : $.b.float(period));
if (($.t((period == null)) && $.t($.ga(self, "_timed")) && !$.t(passed))) {throw $.exc(ParameterError(("" + "this " + $.f($.ga(self, "_family"), "", -1) + " model depends on time, and nobody said how much passes between two samples. Call model.stepper(period) with the period of your loop [s], or step(x, seconds).")));}
return passed; }, {p: ["period"], ks: false}));});
require_model = $.def(function (model, wanted) { 
if ($.t($.b.isinstance(model, Model))) {return model;}
throw $.exc($.k(ParameterError, [("" + "a " + $.f($.ga($.b.type(model), "__name__"), "", -1) + " is no model. Pass " + $.f(wanted, "", -1) + ".")], {"type": $.ga($.b.type(model), "__name__")})); }, {p: ["model", "wanted"], ks: false});
without_inverse = $.def(function (model) { 
return $.k(InvertibilityError, [("" + "this " + $.f($.ga(model, "family"), "", -1) + " model has no inverse: " + $.f($.ga(model, "no_inverse"), "", -1))], {"family": $.ga(model, "family")}); }, {p: ["model"], ks: false});
positive_period = $.def(function (period) { let seconds;
seconds = parameter_number(period, "period");
if (!$.t($.gt(seconds, 0.0))) {throw $.exc(ParameterError(("" + "a period of " + $.f(seconds, ("" + "g"), -1) + " s is none; pass the time between two samples, above 0.")));}
return seconds; }, {p: ["period"], ks: false});
_fault_of = $.def(function (made) { let fault;
try {made();} catch ($e) { $e = $.caught($e); if ($.isinst($e, DehystError)) { fault = $e; {return $.b.str(fault);} } else throw $e; }
return ""; }, {p: ["made"], ks: false});
Object.assign($m, {"annotations": annotations, "json": json, "os": os, "warnings": warnings, "ABC": ABC, "abstractmethod": abstractmethod, "Mapping": Mapping, "dataclass": dataclass, "replace": replace, "Path": Path, "TYPE_CHECKING": TYPE_CHECKING, "Any": Any, "ClassVar": ClassVar, "Generic": Generic, "NamedTuple": NamedTuple, "Self": Self, "TypeVar": TypeVar, "np": np, "npt": npt, "Array": Array_, "DehystError": DehystError, "InvertibilityError": InvertibilityError, "ParameterError": ParameterError, "parameter_number": parameter_number, "ModelCard": ModelCard, "SignalCard": SignalCard, "Direction": Direction, "Machine": Machine, "following": following, "offset_numbers": offset_numbers, "width": width, "save_model": save_model, "M": M, "TOO_SLOW": TOO_SLOW, "Band": Band, "WeightTable": WeightTable, "Model": Model, "Inverted": Inverted, "Steps": Steps, "require_model": require_model, "without_inverse": without_inverse, "positive_period": positive_period, "_fault_of": _fault_of});
});
$.module("dehyst.models.monotone", ($m) => {
let annotations, dataclass, replace, Any, ClassVar, Self, cast, np, npt, _native, Array_, ParameterError, parameter_array, signal_array, strictly_increasing, HysteresisModel, StackStepper, StepMethod, Stepper, make_stepper, NO_CARD, ModelCard, AroundPlays, PrandtlIshlinskii, Plays, MonotoneMap, _IDENTITY, _ZERO, StaticCurve, ModifiedPrandtlIshlinskii;
dataclass = $.from("dataclasses", "dataclass");replace = $.from("dataclasses", "replace");
Any = $.from("typing", "Any");ClassVar = $.from("typing", "ClassVar");Self = $.from("typing", "Self");cast = $.from("typing", "cast");
np = $.imp("numpy");
npt = $.imp("numpy.typing");
_native = $.imp("dehyst._native");
Array_ = $.from("dehyst.arrays", "Array");
ParameterError = $.from("dehyst.errors", "ParameterError");
parameter_array = $.from("dehyst.models.arrays", "parameter_array");signal_array = $.from("dehyst.models.arrays", "signal_array");strictly_increasing = $.from("dehyst.models.arrays", "strictly_increasing");
HysteresisModel = $.from("dehyst.models.base", "HysteresisModel");StackStepper = $.from("dehyst.models.base", "StackStepper");StepMethod = $.from("dehyst.models.base", "StepMethod");Stepper = $.from("dehyst.models.base", "Stepper");make_stepper = $.from("dehyst.models.base", "make_stepper");
NO_CARD = $.from("dehyst.models.card", "NO_CARD");ModelCard = $.from("dehyst.models.card", "ModelCard");
AroundPlays = $.from("dehyst.models.prandtl_ishlinskii", "AroundPlays");PrandtlIshlinskii = $.from("dehyst.models.prandtl_ishlinskii", "PrandtlIshlinskii");
Plays = $.from("dehyst.models.unknown", "Plays");
MonotoneMap = $.cls("MonotoneMap", [], "", [["u", null], ["v", null]], true, false, ($c) => { MonotoneMap = $c; $.meth($c, "__post_init__", $.def(function () { const self = this;
$.seta(self, "u", parameter_array($.ga(self, "u"), "u"));
$.seta(self, "v", parameter_array($.ga(self, "v"), "v"));
if (($.t($.ne($.ga($.ga(self, "u"), "size"), $.ga($.ga(self, "v"), "size"))) || $.t($.lt($.ga($.ga(self, "u"), "size"), 2)))) {throw $.exc($.k(ParameterError, [("" + "a map needs at least two breakpoints and as many values, got " + $.f($.ga($.ga(self, "u"), "size"), "", -1) + " and " + $.f($.ga($.ga(self, "v"), "size"), "", -1) + ".")], {"u": $.ga($.ga(self, "u"), "size"), "v": $.ga($.ga(self, "v"), "size")}));}
strictly_increasing($.ga(self, "u"), "u");
strictly_increasing(($.t($.ga(self, "increasing")) ? $.ga(self, "v") : $.neg($.ga(self, "v"))), ($.t($.ga(self, "increasing")) ? "v" : "-v")); }, {p: [], ks: false}));
$.prop($c, "increasing", $.def(function () { const self = this;
return $.b.bool($.gt($.gi($.ga(self, "v"), (-1)), $.gi($.ga(self, "v"), 0))); }, {p: [], ks: false}));
$.prop($c, "slopes", $.def(function () { const self = this;
return $.div(np.diff($.ga(self, "v")), np.diff($.ga(self, "u"))); }, {p: [], ks: false}));
$.prop($c, "inverse_gain", $.def(function () { const self = this;let flattest;
flattest = $.b.float(np.min(np.abs($.ga(self, "slopes"))));
return ($.t($.eq(flattest, 0.0)) ? $.b.float("inf") : $.div(1.0, flattest)); }, {p: [], ks: false}));
$.meth($c, "__call__", $.def(function (u) { const self = this;
return _native.map_values($.ga(self, "u"), $.ga(self, "v"), signal_array(u, "u")); }, {p: ["u"], ks: false}));
$.meth($c, "file_parameters", $.def(function () { const self = this;
return $.dict([["u", $.ga(self, "u").tolist()], ["v", $.ga(self, "v").tolist()]]); }, {p: [], ks: false}));
$.meth($c, "inverse", $.def(function () { const self = this;
if ($.t($.ga(self, "increasing"))) {return MonotoneMap($.ga(self, "v"), $.ga(self, "u"));}
return MonotoneMap($.gi($.ga(self, "v"), $.slice(null, null, (-1))), $.gi($.ga(self, "u"), $.slice(null, null, (-1)))); }, {p: [], ks: false}));
$.prop($c, "pairs", $.def(function () { const self = this;
return $.tup($.ga(self, "u"), $.ga(self, "v")); }, {p: [], ks: false}));});
_IDENTITY = np.ones(1);
_ZERO = np.zeros(1);
StaticCurve = $.cls("StaticCurve", [HysteresisModel], "", [["curve", null], ["card", () => NO_CARD]], true, false, ($c) => { StaticCurve = $c; $.static($c, "family", "static");$.prop($c, "nonzero_weights", $.def(function () { const self = this;
return 0; }, {p: [], ks: false}));
$.prop($c, "kinds", $.def(function () { const self = this;
return $.tup("map"); }, {p: [], ks: false}));
$.prop($c, "inverse_gain", $.def(function () { const self = this;
return $.ga($.ga(self, "curve"), "inverse_gain"); }, {p: [], ks: false}));
$.meth($c, "stepper", $.def(function (method = "auto") { const self = this;
return $.k(make_stepper, [_ZERO, _IDENTITY, 0.0, 0.0, _ZERO], {"before": $.ga($.ga(self, "curve"), "pairs"), "method": method}); }, {p: ["method"], ks: false}));
$.meth($c, "inverse", $.def(function () { const self = this;
return StaticCurve($.ga(self, "curve").inverse(), $.ga(self, "card").swapped()); }, {p: [], ks: false}));
$.meth($c, "_plays", $.def(function () { const self = this;
return $.tup(Plays(_ZERO, _IDENTITY, 0.0, _ZERO), $.ga(self, "curve"), null); }, {p: [], ks: false}));
$.meth($c, "_inner", $.def(function () { const self = this;
return PrandtlIshlinskii(_ZERO, _IDENTITY); }, {p: [], ks: false}));
$.meth($c, "file_parameters", $.def(function () { const self = this;
return $.dict([["curve", $.ga(self, "curve").file_parameters()]]); }, {p: [], ks: false}));
$.meth($c, "with_state", $.def(function (state) { const self = this;
return self; }, {p: ["state"], ks: false}));});
ModifiedPrandtlIshlinskii = $.cls("ModifiedPrandtlIshlinskii", [AroundPlays], "", [["hysteresis", null], ["after", () => null], ["before", () => null], ["card", () => NO_CARD]], true, false, ($c) => { ModifiedPrandtlIshlinskii = $c; $.static($c, "family", "modified-pi");$.meth($c, "__post_init__", $.def(function () { const self = this;
if (($.t(($.ga(self, "after") == null)) && $.t(($.ga(self, "before") == null)))) {throw $.exc(ParameterError("a modified Prandtl-Ishlinskii model without a map is a plain one; pass after=MonotoneMap(...) or use the PrandtlIshlinskii itself."));}
self._take_card(); }, {p: [], ks: false}));
$.prop($c, "inverse_gain", $.def(function () { const self = this;let gain, mapping;
gain = $.ga($.ga(self, "hysteresis"), "inverse_gain");
for (const $v1 of $.it($.tup($.ga(self, "after"), $.ga(self, "before")))) { mapping = $v1;
{if ($.t((mapping != null))) {gain = $.imul(gain, $.ga(mapping, "inverse_gain"));}} }
return gain; }, {p: [], ks: false}));
$.meth($c, "stepper", $.def(function (method = "auto") { const self = this;let inner;
inner = $.ga(self, "hysteresis");
return $.k(make_stepper, [$.ga(inner, "thresholds"), $.ga(inner, "weights"), $.ga(inner, "center"), $.ga(inner, "offset"), ($.t(($.ga(inner, "state") == null)) ? np.zeros($.ga($.ga(inner, "thresholds"), "size")) : $.ga(inner, "state"))], {"before": ($.t(($.ga(self, "before") == null)) ? null : $.ga($.ga(self, "before"), "pairs")), "after": ($.t(($.ga(self, "after") == null)) ? null : $.ga($.ga(self, "after"), "pairs")), "method": method}); }, {p: ["method"], ks: false}));
$.meth($c, "inverse", $.def(function () { const self = this;
return $.k(ModifiedPrandtlIshlinskii, [$.ga(self, "hysteresis").inverse()], {"after": ($.t(($.ga(self, "before") == null)) ? null : $.ga(self, "before").inverse()), "before": ($.t(($.ga(self, "after") == null)) ? null : $.ga(self, "after").inverse()), "card": $.ga(self, "card").swapped()}); }, {p: [], ks: false}));
$.meth($c, "_plays", $.def(function () { const self = this;
return $.tup($.gi($.ga(self, "hysteresis")._plays(), 0), $.ga(self, "before"), $.ga(self, "after")); }, {p: [], ks: false}));
$.meth($c, "_inner", $.def(function () { const self = this;
return $.ga(self, "hysteresis"); }, {p: [], ks: false}));
$.meth($c, "with_operator", $.def(function (operator) { const self = this;
return $.k(replace, [self], {"hysteresis": operator}); }, {p: ["operator"], ks: false}));
$.prop($c, "maps", $.def(function () { const self = this;
return $.tup($.ga(self, "before"), $.ga(self, "after")); }, {p: [], ks: false}));
$.meth($c, "times", $.def(function (factor) { const self = this;
if ($.t(($.ga(self, "after") == null))) {return $.k(replace, [self], {"hysteresis": $.ga(self, "hysteresis").times(factor)});}
return $.k(replace, [self], {"after": MonotoneMap($.ga($.ga(self, "after"), "u"), $.mul($.ga($.ga(self, "after"), "v"), factor))}); }, {p: ["factor"], ks: false}));
$.meth($c, "file_parameters", $.def(function () { const self = this;let maps, told;
maps = $.dict([["after", $.ga(self, "after")], ["before", $.ga(self, "before")]]);
told = $.dict((() => { const $r = []; for (const $v2 of $.it($.cm(maps, "items", []))) { let name, each; {const $v3 = $.unpack($v2, 2, -1);name = $v3[0];each = $v3[1];} $r.push([name, ($.t((each == null)) ? null : each.file_parameters())]); } return $r; })());
return $.dict([["hysteresis", $.ga(self, "hysteresis").file_parameters()], ...$.pairs(told)]); }, {p: [], ks: false}));});
Object.assign($m, {"annotations": annotations, "dataclass": dataclass, "replace": replace, "Any": Any, "ClassVar": ClassVar, "Self": Self, "cast": cast, "np": np, "npt": npt, "_native": _native, "Array": Array_, "ParameterError": ParameterError, "parameter_array": parameter_array, "signal_array": signal_array, "strictly_increasing": strictly_increasing, "HysteresisModel": HysteresisModel, "StackStepper": StackStepper, "StepMethod": StepMethod, "Stepper": Stepper, "make_stepper": make_stepper, "NO_CARD": NO_CARD, "ModelCard": ModelCard, "AroundPlays": AroundPlays, "PrandtlIshlinskii": PrandtlIshlinskii, "Plays": Plays, "MonotoneMap": MonotoneMap, "_IDENTITY": _IDENTITY, "_ZERO": _ZERO, "StaticCurve": StaticCurve, "ModifiedPrandtlIshlinskii": ModifiedPrandtlIshlinskii});
});
$.module("dehyst.models.prandtl_ishlinskii", ($m) => {
let annotations, dataclass, replace, Any, ClassVar, Self, np, npt, _native, Array_, InvertibilityError, ParameterError, parameter_array, parameter_number, strictly_increasing, HysteresisModel, StackStepper, StepMethod, Stepper, check_state, make_stepper, NO_CARD, ModelCard, ROUNDING, Past, Plays, half_strokes, half_width, start_states, PrandtlIshlinskii, AroundPlays, StopOperatorModel;
dataclass = $.from("dataclasses", "dataclass");replace = $.from("dataclasses", "replace");
Any = $.from("typing", "Any");ClassVar = $.from("typing", "ClassVar");Self = $.from("typing", "Self");
np = $.imp("numpy");
npt = $.imp("numpy.typing");
_native = $.imp("dehyst._native");
Array_ = $.from("dehyst.arrays", "Array");
InvertibilityError = $.from("dehyst.errors", "InvertibilityError");ParameterError = $.from("dehyst.errors", "ParameterError");
parameter_array = $.from("dehyst.models.arrays", "parameter_array");parameter_number = $.from("dehyst.models.arrays", "parameter_number");strictly_increasing = $.from("dehyst.models.arrays", "strictly_increasing");
HysteresisModel = $.from("dehyst.models.base", "HysteresisModel");StackStepper = $.from("dehyst.models.base", "StackStepper");StepMethod = $.from("dehyst.models.base", "StepMethod");Stepper = $.from("dehyst.models.base", "Stepper");check_state = $.from("dehyst.models.base", "check_state");make_stepper = $.from("dehyst.models.base", "make_stepper");
NO_CARD = $.from("dehyst.models.card", "NO_CARD");ModelCard = $.from("dehyst.models.card", "ModelCard");
ROUNDING = $.from("dehyst.models.unknown", "ROUNDING");Past = $.from("dehyst.models.unknown", "Past");Plays = $.from("dehyst.models.unknown", "Plays");half_strokes = $.from("dehyst.models.unknown", "half_strokes");half_width = $.from("dehyst.models.unknown", "half_width");start_states = $.from("dehyst.models.unknown", "start_states");
PrandtlIshlinskii = $.cls("PrandtlIshlinskii", [HysteresisModel], "", [["thresholds", null], ["weights", null], ["offset", () => 0.0], ["state", () => null], ["center", () => 0.0], ["card", () => NO_CARD]], true, false, ($c) => { PrandtlIshlinskii = $c; $.static($c, "family", "pi");$.meth($c, "__post_init__", $.def(function () { const self = this;let put, r;
put = $.ga($.b.object, "__setattr__");
put(self, "thresholds", parameter_array($.ga(self, "thresholds"), "thresholds"));
put(self, "weights", parameter_array($.ga(self, "weights"), "weights"));
put(self, "offset", parameter_number($.ga(self, "offset"), "offset"));
put(self, "center", parameter_number($.ga(self, "center"), "center"));
r = $.ga(self, "thresholds");
if ($.t($.ne($.ga(r, "size"), $.ga($.ga(self, "weights"), "size")))) {throw $.exc($.k(ParameterError, [("" + $.f($.ga(r, "size"), "", -1) + " thresholds but " + $.f($.ga($.ga(self, "weights"), "size"), "", -1) + " weights; pass one weight per threshold.")], {"thresholds": $.ga(r, "size"), "weights": $.ga($.ga(self, "weights"), "size")}));}
if ($.t($.lt($.gi(r, 0), 0))) {throw $.exc($.k(ParameterError, [("" + "thresholds[0] = " + $.f($.gi(r, 0), ("" + "g"), -1) + " is negative; a play has a radius r >= 0.")], {"index": 0}));}
strictly_increasing(r, "thresholds");
if ($.t(($.ga(self, "state") != null))) {put(self, "state", parameter_array($.ga(self, "state"), "state"));
check_state($.ga(self, "_state"), r);} }, {p: [], ks: false}));
$.prop($c, "_state", $.def(function () { const self = this;
return ($.t(($.ga(self, "state") == null)) ? np.zeros($.ga($.ga(self, "thresholds"), "size")) : $.ga(self, "state")); }, {p: [], ks: false}));
$.prop($c, "partial_sums", $.def(function () { const self = this;
return np.cumsum($.ga(self, "weights")); }, {p: [], ks: false}));
$.prop($c, "nonzero_weights", $.def(function () { const self = this;
return $.b.int(np.count_nonzero($.ga(self, "weights"))); }, {p: [], ks: false}));
$.prop($c, "inverse_gain", $.def(function () { const self = this;let smallest;
smallest = $.b.float(np.min(np.abs($.ga(self, "partial_sums"))));
return ($.t($.eq(smallest, 0.0)) ? $.b.float("inf") : $.div(1.0, smallest)); }, {p: [], ks: false}));
$.meth($c, "loading_curve", $.def(function (radius) { const self = this;let r;
r = $.km(np, "asarray", [radius], {"dtype": $.ga(np, "float64")});
return $.mm(np.maximum($.sub($.gi(r, $.tup($.ellipsis, null)), $.ga(self, "thresholds")), 0.0), $.ga(self, "weights")); }, {p: ["radius"], ks: false}));
$.meth($c, "stepper", $.def(function (method = "auto") { const self = this;
return $.k(make_stepper, [$.ga(self, "thresholds"), $.ga(self, "weights"), $.ga(self, "center"), $.ga(self, "offset"), $.ga(self, "_state")], {"method": method}); }, {p: ["method"], ks: false}));
$.meth($c, "inverse", $.def(function () { const self = this;let fault, r, w, z, sums, state, why;
{const $v1 = $.unpack(_native.pi_invert($.ga(self, "thresholds"), $.ga(self, "weights"), $.ga(self, "_state")), 4, -1);fault = $v1[0];r = $v1[1];w = $v1[2];z = $v1[3];}
if ($.t($.eq(fault, (-1)))) {throw $.exc($.k(InvertibilityError, [("" + "this model has no inverse: its smallest threshold is " + $.f($.gi($.ga(self, "thresholds"), 0), ("" + "g"), -1) + ", so inputs that move less than that give the same output. Add an operator with threshold 0 and a small positive weight.")], {"threshold": $.b.float($.gi($.ga(self, "thresholds"), 0))}));}
if ($.t(fault)) {sums = $.ga(self, "partial_sums");
throw $.exc($.k(InvertibilityError, [("" + "this model has no closed inverse: the partial sum of the first " + $.f(fault, "", -1) + " weights is " + $.f($.gi(sums, $.sub(fault, 1)), ("" + "g"), -1) + " while the first weight is " + $.f($.gi($.ga(self, "weights"), 0), ("" + "g"), -1) + "; all partial sums must share one sign, or the output turns while the input does not. Identify with w >= 0 (family 'pi') or with positive partial sums (family 'pi-cumulative').")], {"index": $.sub(fault, 1), "partial_sum": $.b.float($.gi(sums, $.sub(fault, 1)))}));}
state = (($.t(($.ga(self, "state") == null)) && !$.t(z.any())) ? null : z);
try {return PrandtlIshlinskii(r, w, $.ga(self, "center"), state, $.ga(self, "offset"), $.ga(self, "card").swapped());} catch ($e) { $e = $.caught($e); if ($.isinst($e, ParameterError)) { why = $e; {throw $.exc(InvertibilityError(("" + "the inverse of this model cannot be represented in double precision: " + $.f(why, "", -1) + " Its weights span " + $.f(np.min(np.abs($.ga(self, "partial_sums"))), ("" + "g"), -1) + " to " + $.f(np.max(np.abs($.ga(self, "partial_sums"))), ("" + "g"), -1) + " in partial sums; raise eps or merge operators that lie close together.")));} } else throw $e; } }, {p: [], ks: false}));
$.meth($c, "_plays", $.def(function () { const self = this;
return $.tup(Plays($.ga(self, "thresholds"), $.ga(self, "weights"), $.ga(self, "center"), $.ga(self, "_state")), null, null); }, {p: [], ks: false}));
$.meth($c, "_operator_bounds", $.def(function (u, known, past) { const self = this;let plays, start, low, high, rest, width, size, slack, middle;
plays = $.gi(self._plays(), 0);
start = start_states(plays, $.b.float($.gi(u, 0)), known, past);
{const $v3 = $.unpack((function* () { for (const $v2 of $.it($.tup($.ga(start, "lowest"), $.ga(start, "highest")))) { let state; state = $v2; yield self.with_state(state).simulate(u); } })(), 2, -1);low = $v3[0];high = $v3[1];}
rest = $.gi($.ga(self, "weights"), $.slice($.b.int($.eq($.gi($.ga(self, "thresholds"), 0), 0.0)), null, null));
if (($.t(np.all($.ge(rest, 0.0))) || $.t(np.all($.le(rest, 0.0))))) {return $.tup(np.minimum(low, high), np.maximum(low, high));}
if ($.t((past != null))) {return self._mixed_bounds(u, known, past);}
width = half_width(plays, half_strokes($.sub(u, $.ga(self, "center")), start));
size = $.b.float($.mm(np.abs($.ga(self, "weights")), $.add($.ga(self, "thresholds"), np.max(np.abs($.sub(u, $.ga(self, "center")))))));
slack = np.where($.gt(width, 0.0), $.mul(ROUNDING, size), 0.0);
middle = $.mul(0.5, $.add(low, high));
return $.tup($.sub($.sub(middle, width), slack), $.add($.add(middle, width), slack)); }, {p: ["u", "known", "past"], ks: false}));
$.meth($c, "_mixed_bounds", $.def(function (u, known, past) { const self = this;let rising, falling, any_past;
rising = $.k(replace, [self], {"weights": np.maximum($.ga(self, "weights"), 0.0)})._operator_bounds(u, known, past);
falling = $.k(replace, [self], {"weights": np.minimum($.ga(self, "weights"), 0.0), "offset": 0.0})._operator_bounds(u, known, past);
any_past = self._operator_bounds(u, known, null);
return $.tup(np.maximum($.add($.gi(rising, 0), $.gi(falling, 0)), $.gi(any_past, 0)), np.minimum($.add($.gi(rising, 1), $.gi(falling, 1)), $.gi(any_past, 1))); }, {p: ["u", "known", "past"], ks: false}));
$.meth($c, "file_parameters", $.def(function () { const self = this;
return $.dict([["thresholds", $.ga(self, "thresholds").tolist()], ["weights", $.ga(self, "weights").tolist()], ["offset", $.ga(self, "offset")], ["center", $.ga(self, "center")], ["state", ($.t(($.ga(self, "state") == null)) ? null : $.ga(self, "state").tolist())]]); }, {p: [], ks: false}));
$.meth($c, "with_state", $.def(function (state) { const self = this;
return $.k(replace, [self], {"state": ($.t((state == null)) ? null : parameter_array(state, "state"))}); }, {p: ["state"], ks: false}));
$.prop($c, "play_core", $.def(function () { const self = this;
return self; }, {p: [], ks: false}));
$.prop($c, "operators", $.def(function () { const self = this;
return $.tup("play", $.ga(self, "weights"), null); }, {p: [], ks: false}));
$.meth($c, "times", $.def(function (factor) { const self = this;
return $.k(replace, [self], {"weights": $.mul($.ga(self, "weights"), factor), "offset": $.mul($.ga(self, "offset"), factor)}); }, {p: ["factor"], ks: false}));
$.meth($c, "pruned", $.def(function () { const self = this;let keep, state;
keep = $.ne($.ga(self, "weights"), 0.0);
$.si(keep, 0, true);
state = ($.t(($.ga(self, "state") == null)) ? null : $.gi($.ga(self, "state"), keep));
return $.k(replace, [self], {"thresholds": $.gi($.ga(self, "thresholds"), keep), "weights": $.gi($.ga(self, "weights"), keep), "state": state}); }, {p: [], ks: false}));});
AroundPlays = $.cls("AroundPlays", [HysteresisModel], "", [], false, true, ($c) => { AroundPlays = $c; $.meth($c, "_take_card", $.def(function () { const self = this;
if ($.t(($.ga(self, "card") === NO_CARD))) {$.seta(self, "card", $.ga($.ga(self, "hysteresis"), "card"));}
$.seta(self, "hysteresis", $.ga(self, "hysteresis").with_card(NO_CARD)); }, {p: [], ks: false}));
$.prop($c, "nonzero_weights", $.def(function () { const self = this;
return $.ga($.ga(self, "hysteresis"), "nonzero_weights"); }, {p: [], ks: false}));
$.prop($c, "play_core", $.def(function () { const self = this;
return $.ga(self, "hysteresis"); }, {p: [], ks: false}));
$.prop($c, "operators", $.def(function () { const self = this;
return $.ga($.ga(self, "hysteresis"), "operators"); }, {p: [], ks: false}));
$.meth($c, "with_state", $.def(function (state) { const self = this;
return $.k(replace, [self], {"hysteresis": $.ga(self, "hysteresis").with_state(state)}); }, {p: ["state"], ks: false}));
$.meth($c, "pruned", $.def(function () { const self = this;
return $.k(replace, [self], {"hysteresis": $.ga(self, "hysteresis").pruned()}); }, {p: [], ks: false}));});
StopOperatorModel = $.cls("StopOperatorModel", [HysteresisModel], "", [["thresholds", null], ["stop_weights", null], ["slope", null], ["offset", () => 0.0], ["state", () => null], ["center", () => 0.0], ["card", () => NO_CARD]], true, false, ($c) => { StopOperatorModel = $c; $.static($c, "family", "stop");$.meth($c, "__post_init__", $.def(function () { const self = this;let put, play;
put = $.ga($.b.object, "__setattr__");
put(self, "thresholds", parameter_array($.ga(self, "thresholds"), "thresholds"));
put(self, "stop_weights", parameter_array($.ga(self, "stop_weights"), "stop_weights"));
put(self, "slope", parameter_number($.ga(self, "slope"), "slope"));
put(self, "offset", parameter_number($.ga(self, "offset"), "offset"));
put(self, "center", parameter_number($.ga(self, "center"), "center"));
if (($.t($.ne($.gi($.ga(self, "thresholds"), 0), 0.0)) || $.t($.ne($.gi($.ga(self, "stop_weights"), 0), 0.0)))) {throw $.exc(ParameterError(("" + "the first element must be r_1 = 0 with s_1 = 0 (a stop of radius zero carries nothing), got r_1 = " + $.f($.gi($.ga(self, "thresholds"), 0), ("" + "g"), -1) + ", s_1 = " + $.f($.gi($.ga(self, "stop_weights"), 0), ("" + "g"), -1) + ".")));}
play = self.as_play();
put(self, "state", $.ga(play, "state")); }, {p: [], ks: false}));
$.meth($c, "as_play", $.def(function () { const self = this;let weights;
if ($.t($.ne($.ga($.ga(self, "thresholds"), "size"), $.ga($.ga(self, "stop_weights"), "size")))) {throw $.exc(ParameterError(("" + $.f($.ga($.ga(self, "thresholds"), "size"), "", -1) + " thresholds but " + $.f($.ga($.ga(self, "stop_weights"), "size"), "", -1) + " stop weights; pass one per threshold.")));}
weights = _native.stop_to_play($.ga(self, "slope"), $.ga(self, "stop_weights"));
return PrandtlIshlinskii($.ga(self, "thresholds"), weights, $.ga(self, "offset"), $.ga(self, "state"), $.ga(self, "center"), $.ga(self, "card")); }, {p: [], ks: false}));
$.prop($c, "nonzero_weights", $.def(function () { const self = this;
return $.add($.b.int(np.count_nonzero($.ga(self, "stop_weights"))), $.b.int($.ne($.ga(self, "slope"), 0.0))); }, {p: [], ks: false}));
$.prop($c, "inverse_gain", $.def(function () { const self = this;
return $.ga(self.as_play(), "inverse_gain"); }, {p: [], ks: false}));
$.meth($c, "stepper", $.def(function (method = "auto") { const self = this;
return self.as_play().stepper(method); }, {p: ["method"], ks: false}));
$.meth($c, "inverse", $.def(function () { const self = this;
return self.as_play().inverse(); }, {p: [], ks: false}));
$.meth($c, "_plays", $.def(function () { const self = this;
return self.as_play()._plays(); }, {p: [], ks: false}));
$.meth($c, "_inner", $.def(function () { const self = this;
return self.as_play(); }, {p: [], ks: false}));
$.prop($c, "play_core", $.def(function () { const self = this;
return self.as_play(); }, {p: [], ks: false}));
$.prop($c, "operators", $.def(function () { const self = this;
return $.tup("stop", $.ga(self, "stop_weights"), $.ga(self, "slope")); }, {p: [], ks: false}));
$.meth($c, "times", $.def(function (factor) { const self = this;
return self.as_play().times(factor); }, {p: ["factor"], ks: false}));
$.meth($c, "pruned", $.def(function () { const self = this;let keep, state;
keep = $.ne($.ga(self, "stop_weights"), 0.0);
$.si(keep, 0, true);
state = ($.t(($.ga(self, "state") == null)) ? null : $.gi($.ga(self, "state"), keep));
return $.k(replace, [self], {"thresholds": $.gi($.ga(self, "thresholds"), keep), "stop_weights": $.gi($.ga(self, "stop_weights"), keep), "state": state}); }, {p: [], ks: false}));
$.meth($c, "file_parameters", $.def(function () { const self = this;
return $.dict([["thresholds", $.ga(self, "thresholds").tolist()], ["stop_weights", $.ga(self, "stop_weights").tolist()], ["slope", $.ga(self, "slope")], ["offset", $.ga(self, "offset")], ["center", $.ga(self, "center")], ["state", ($.t(($.ga(self, "state") == null)) ? null : $.ga(self, "state").tolist())]]); }, {p: [], ks: false}));
$.meth($c, "with_state", $.def(function (state) { const self = this;
return $.k(replace, [self], {"state": ($.t((state == null)) ? null : parameter_array(state, "state"))}); }, {p: ["state"], ks: false}));});
Object.assign($m, {"annotations": annotations, "dataclass": dataclass, "replace": replace, "Any": Any, "ClassVar": ClassVar, "Self": Self, "np": np, "npt": npt, "_native": _native, "Array": Array_, "InvertibilityError": InvertibilityError, "ParameterError": ParameterError, "parameter_array": parameter_array, "parameter_number": parameter_number, "strictly_increasing": strictly_increasing, "HysteresisModel": HysteresisModel, "StackStepper": StackStepper, "StepMethod": StepMethod, "Stepper": Stepper, "check_state": check_state, "make_stepper": make_stepper, "NO_CARD": NO_CARD, "ModelCard": ModelCard, "ROUNDING": ROUNDING, "Past": Past, "Plays": Plays, "half_strokes": half_strokes, "half_width": half_width, "start_states": start_states, "PrandtlIshlinskii": PrandtlIshlinskii, "AroundPlays": AroundPlays, "StopOperatorModel": StopOperatorModel});
});
$.module("dehyst.models.unknown", ($m) => {
let annotations, dataclass, np, npt, Array_, ParameterError, parameter_number, ROUNDING, Plays, Start, Past, start_states, check_past, half_width, half_strokes, held;
dataclass = $.from("dataclasses", "dataclass");
np = $.imp("numpy");
npt = $.imp("numpy.typing");
Array_ = $.from("dehyst.arrays", "Array");
ParameterError = $.from("dehyst.errors", "ParameterError");
parameter_number = $.from("dehyst.models.arrays", "parameter_number");
ROUNDING = 1e-13;
Plays = $.cls("Plays", [], "", [["thresholds", null], ["weights", null], ["center", null], ["state", null]], true, false, ($c) => { Plays = $c; });
Start = $.cls("Start", [], "", [["lowest", null], ["highest", null], ["top", null], ["bottom", null]], true, false, ($c) => { Start = $c; });
Past = $.bor($.gi($.b.tuple, $.tup($.b.float, $.b.float)), null);
start_states = $.def(function (plays, first, known, past = null) { let r, v, lowest, highest, bottom, top, sure, z, last, reach, sure_ones, low, high;
r = $.ga(plays, "thresholds");
if (($.t((known != null)) && $.t($.lt(parameter_number(known, "known"), 0.0)))) {throw $.exc($.k(ParameterError, [("" + "known = " + $.f(known, ("" + "g"), -1) + " is negative; it is the radius up to which the plays are in the model's state, such as the half stroke of a homing. None stands for a memory of which nothing is known.")], {"known": known}));}
v = $.sub(first, $.ga(plays, "center"));
{const $v1 = $.unpack($.tup($.sub(v, r), $.add(v, r)), 2, -1);lowest = $v1[0];highest = $v1[1];}
if ($.t((past != null))) {{const $v2 = $.unpack($.tup($.b.min($.gi(past, 0), first), $.b.max($.gi(past, 1), first)), 2, -1);bottom = $v2[0];top = $v2[1];}
lowest = np.maximum(lowest, np.minimum($.ga(plays, "state"), $.add($.sub(bottom, $.ga(plays, "center")), r)));
highest = np.minimum(highest, np.maximum($.ga(plays, "state"), $.sub($.sub(top, $.ga(plays, "center")), r)));}
sure = ($.t((known == null)) ? 0 : $.b.int($.km(np, "searchsorted", [r, known], {"side": "right"})));
if ($.t($.eq(sure, 0))) {return Start(lowest, highest, v, v);}
{const $v3 = $.unpack($.tup($.b.float($.gi($.ga(plays, "state"), $.sub(sure, 1))), $.b.float($.gi(r, $.sub(sure, 1)))), 2, -1);z = $v3[0];last = $v3[1];}
reach = np.maximum($.sub(r, last), 0.0);
sure_ones = $.lt(np.arange($.ga(r, "size")), sure);
low = np.maximum($.sub(z, reach), ($.t((past != null)) ? lowest : $.neg($.ga(np, "inf"))));
high = np.minimum($.add(z, reach), ($.t((past != null)) ? highest : $.ga(np, "inf")));
return Start(np.where(sure_ones, $.ga(plays, "state"), low), np.where(sure_ones, $.ga(plays, "state"), high), $.add(z, last), $.sub(z, last)); }, {p: ["plays", "first", "known", "past"], ks: false});
check_past = $.def(function (past) { let bottom, top;
if ($.t((past == null))) {return null;}
try {{const $v4 = $.unpack(past, 2, -1);bottom = $v4[0];top = $v4[1];}} catch ($e) { $e = $.caught($e); if ($.isinst($e, $.tup($.b.TypeError, $.b.ValueError))) {  {throw $.exc(ParameterError(("" + "past = " + $.f(past, ("" + ".60"), 114) + " is no pair of numbers; pass past=(low, high).")));} } else throw $e; }
{const $v5 = $.unpack($.tup(parameter_number(bottom, "past[0]"), parameter_number(top, "past[1]")), 2, -1);bottom = $v5[0];top = $v5[1];}
if (!$.t($.lt(bottom, top))) {throw $.exc($.k(ParameterError, [("" + "past = (" + $.f(bottom, ("" + "g"), -1) + ", " + $.f(top, ("" + "g"), -1) + ") is no range; pass the smallest input that was possible first, then the largest.")], {"low": bottom, "high": top}));}
return $.tup(bottom, top); }, {p: ["past"], ks: false});
half_width = $.def(function (plays, half_stroke) { let knots, tails, pieces, left, width;
knots = np.concatenate([[0.0], $.ga(plays, "thresholds")]);
tails = $.gi(np.cumsum($.gi($.ga(plays, "weights"), $.slice(null, null, (-1)))), $.slice(null, null, (-1)));
pieces = $.mul(np.abs(tails), np.diff(knots));
left = np.concatenate([$.gi(np.cumsum($.gi(pieces, $.slice(null, null, (-1)))), $.slice(null, null, (-1))), [0.0]]);
width = np.interp($.km(np, "asarray", [half_stroke], {"dtype": $.ga(np, "float64")}), knots, left);
return width; }, {p: ["plays", "half_stroke"], ks: false});
half_strokes = $.def(function (centred, start) { let top, bottom;
top = np.maximum($.ga(np, "maximum").accumulate(centred), $.ga(start, "top"));
bottom = np.minimum($.ga(np, "minimum").accumulate(centred), $.ga(start, "bottom"));
return $.mul(0.5, $.sub(top, bottom)); }, {p: ["centred", "start"], ks: false});
held = $.def(function (x, limit) { let good, first, places;
good = $.le(np.abs(x), limit);
if ($.t(good.all())) {return $.tup(x, 0);}
if (!$.t(good.any())) {return $.tup(x, $.ga(x, "size"));}
first = $.b.int(np.argmax(good));
places = $.ga(np, "maximum").accumulate(np.where(good, np.arange($.ga(x, "size")), first));
return $.tup($.gi(x, places), first); }, {p: ["x", "limit"], ks: false});
Object.assign($m, {"annotations": annotations, "dataclass": dataclass, "np": np, "npt": npt, "Array": Array_, "ParameterError": ParameterError, "parameter_number": parameter_number, "ROUNDING": ROUNDING, "Plays": Plays, "Start": Start, "Past": Past, "start_states": start_states, "check_past": check_past, "half_width": half_width, "half_strokes": half_strokes, "held": held});
});
$.module("dehyst.models.offset", ($m) => {
let annotations, hashlib, struct, dataclass, np, npt, _native, Array_, ParameterError, parameter_number, signal_array, SignalCard, TURN, MOST, OffsetNumbers, offset_numbers, width, following;
hashlib = $.imp("hashlib");
struct = $.imp("struct");
dataclass = $.from("dataclasses", "dataclass");
np = $.imp("numpy");
npt = $.imp("numpy.typing");
_native = $.imp("dehyst._native");
Array_ = $.from("dehyst.arrays", "Array");
ParameterError = $.from("dehyst.errors", "ParameterError");
parameter_number = $.from("dehyst.models.arrays", "parameter_number");signal_array = $.from("dehyst.models.arrays", "signal_array");
SignalCard = $.from("dehyst.models.card", "SignalCard");
TURN = 0.05;
MOST = 0.5;
OffsetNumbers = $.cls("OffsetNumbers", [], "", [["limit", null], ["turn", null], ["part", null]], true, true, ($c) => { OffsetNumbers = $c; $.prop($c, "fingerprint", $.def(function () { const self = this;let packed;
packed = struct.pack("<3d", $.ga(self, "limit"), $.ga(self, "turn"), $.ga(self, "part"));
return $.b.int.from_bytes($.gi(hashlib.sha256(packed).digest(), $.slice(null, 4, null)), "big"); }, {p: [], ks: false}));
$.meth($c, "made", $.def(function () { const self = this;
return _native.Offset($.ga(self, "limit"), $.ga(self, "turn"), $.ga(self, "part"), $.ga(self, "fingerprint")); }, {p: [], ks: false}));});
offset_numbers = $.def(function (limit, output, x) { let share;
share = parameter_number(limit, "follow_offset");
if (!$.t((($t0, $t1) => $.t($.lt(0.0, share)) && $.t($.le(share, MOST)))())) {throw $.exc($.k(ParameterError, [("" + "follow_offset = " + $.f(share, ("" + "g"), -1) + " is no limit of an offset; pass a share of the output's range above 0 and at most " + $.f(MOST, ("" + "g"), -1) + ", for example 0.1 (in a terminal: --follow-offset 0.1).")], {"follow_offset": share}));}
if (!($.t($.gt(output, 0.0)) && $.t($.gt(x, 0.0)))) {throw $.exc(ParameterError("a signal that stands still has no cycles, so no offset can follow them."));}
return OffsetNumbers($.mul(share, output), $.mul(TURN, x), $.div($.mul(share, output), x)); }, {p: ["limit", "output", "x"], ks: false});
width = $.def(function (card, otherwise) { 
return $.b.float((($.t(($.ga(card, "low") == null)) || $.t(($.ga(card, "high") == null))) ? np.ptp(otherwise) : $.sub($.ga(card, "high"), $.ga(card, "low")))); }, {p: ["card", "otherwise"], ks: false});
following = $.def(function (x, said, measured, numbers) { let inputs, answers, seen, moved;
{const $v1 = $.unpack($.tup(signal_array(x, "input x"), signal_array(said, "said")), 2, -1);inputs = $v1[0];answers = $v1[1];}
seen = signal_array(measured, "measured");
if (!$.t((($t0, $t1) => $.t($.eq($.ga(inputs, "shape"), ($t0 = $.ga(answers, "shape")))) && $.t($.eq($t0, $.ga(seen, "shape"))))())) {throw $.exc(ParameterError(("" + "input, output and measurement differ: " + $.f($.ga(inputs, "shape"), "", -1) + ", " + $.f($.ga(answers, "shape"), "", -1) + ", " + $.f($.ga(seen, "shape"), "", -1) + ".")));}
moved = $.add(answers, numbers.made().run(inputs, answers, seen));
return moved; }, {p: ["x", "said", "measured", "numbers"], ks: false});
Object.assign($m, {"annotations": annotations, "hashlib": hashlib, "struct": struct, "dataclass": dataclass, "np": np, "npt": npt, "_native": _native, "Array": Array_, "ParameterError": ParameterError, "parameter_number": parameter_number, "signal_array": signal_array, "SignalCard": SignalCard, "TURN": TURN, "MOST": MOST, "OffsetNumbers": OffsetNumbers, "offset_numbers": offset_numbers, "width": width, "following": following});
});
$.module("dehyst.models.parameters", ($m) => {
let annotations, Any, np, Array_, ParameterError, DirectInverse, Schedule, Model, ModifiedPrandtlIshlinskii, MonotoneMap, StaticCurve, PrandtlIshlinskii, StopOperatorModel, ShearedPrandtlIshlinskii, Json, number, MOST_SCHEDULES, LONGEST_NAME, _numbers, _read_play, _read_map, _rows, _read_direct, _read_schedule, model_of;
Any = $.from("typing", "Any");
np = $.imp("numpy");
Array_ = $.from("dehyst.arrays", "Array");
ParameterError = $.from("dehyst.errors", "ParameterError");
DirectInverse = $.from("dehyst.models.direct", "DirectInverse");Schedule = $.from("dehyst.models.direct", "Schedule");
Model = $.from("dehyst.models.model", "Model");
ModifiedPrandtlIshlinskii = $.from("dehyst.models.monotone", "ModifiedPrandtlIshlinskii");MonotoneMap = $.from("dehyst.models.monotone", "MonotoneMap");StaticCurve = $.from("dehyst.models.monotone", "StaticCurve");
PrandtlIshlinskii = $.from("dehyst.models.prandtl_ishlinskii", "PrandtlIshlinskii");StopOperatorModel = $.from("dehyst.models.prandtl_ishlinskii", "StopOperatorModel");
ShearedPrandtlIshlinskii = $.from("dehyst.models.sheared", "ShearedPrandtlIshlinskii");
Json = $.from("dehyst.models.storage", "Json");number = $.from("dehyst.models.storage", "number");
MOST_SCHEDULES = 3;
LONGEST_NAME = 200;
_numbers = $.def(function (value, name) { 
if ((!$.t($.b.isinstance(value, $.b.list)) || !$.t($.b.all((function* () { for (const $v1 of $.it(value)) { let v; v = $v1; yield $.and($.b.isinstance(v, $.tup($.b.int, $.b.float)), () => !$.t($.b.isinstance(v, $.b.bool))); } })())))) {throw $.exc(ParameterError(("" + $.f(name, "", -1) + " is not a list of numbers.")));}
return value; }, {p: ["value", "name"], ks: false});
_read_play = $.def(function (p) { 
return PrandtlIshlinskii($.km(np, "array", [_numbers($.gi(p, "thresholds"), "thresholds")], {"dtype": $.ga(np, "float64")}), $.km(np, "array", [_numbers($.gi(p, "weights"), "weights")], {"dtype": $.ga(np, "float64")}), number($.gi(p, "offset"), "offset"), ($.t(($.gi(p, "state") == null)) ? null : $.km(np, "array", [_numbers($.gi(p, "state"), "state")], {"dtype": $.ga(np, "float64")})), number($.gi(p, "center"), "center")); }, {p: ["p"], ks: false});
_read_map = $.def(function (p) { 
if ($.t((p == null))) {return null;}
return MonotoneMap($.km(np, "array", [_numbers($.gi(p, "u"), "u")], {"dtype": $.ga(np, "float64")}), $.km(np, "array", [_numbers($.gi(p, "v"), "v")], {"dtype": $.ga(np, "float64")})); }, {p: ["p"], ks: false});
_rows = $.def(function (value, name, sets) { let rows;
rows = ($.t($.b.isinstance(value, $.b.list)) ? (() => { const $r = []; for (const $v2 of $.it(value)) { let row; row = $v2; $r.push(_numbers(row, name)); } return $r; })() : []);
if (($.t($.ne($.b.len(rows), sets)) || $.t($.ne($.b.len($.b.set((() => { const $r = []; for (const $v3 of $.it(rows)) { let row; row = $v3; $r.push($.b.len(row)); } return $r; })())), 1)))) {throw $.exc(ParameterError(("" + $.f(name, "", -1) + " is not a table of " + $.f(sets, "", -1) + " rows of one length.")));}
return $.km(np, "array", [rows], {"dtype": $.ga(np, "float64")}).reshape(sets, $.b.len($.gi(rows, 0))); }, {p: ["value", "name", "sets"], ks: false});
_read_direct = $.def(function (p) { let listed, schedules, sets;
listed = $.gi(p, "schedules");
if ((!$.t($.b.isinstance(listed, $.b.list)) || $.t($.gt($.b.len(listed), MOST_SCHEDULES)) || !$.t($.b.isinstance($.gi(p, "known"), $.b.bool)))) {throw $.exc(ParameterError("schedules are not a short list, or known is neither true nor false."));}
schedules = $.b.tuple((function* () { for (const $v4 of $.it(listed)) { let entry; entry = $v4; yield _read_schedule(entry); } })());
sets = $.b.max(1, $.mul(2, $.b.len(schedules)));
return $.k(DirectInverse, [], {"radii": $.km(np, "array", [_numbers($.gi(p, "radii"), "radii")], {"dtype": $.ga(np, "float64")}), "stop_weights": _rows($.gi(p, "stop_weights"), "stop_weights", sets), "path_lengths": $.km(np, "array", [_numbers($.gi(p, "path_lengths"), "path_lengths")], {"dtype": $.ga(np, "float64")}), "path_weights": _rows($.gi(p, "path_weights"), "path_weights", sets), "time_constants": $.km(np, "array", [_numbers($.gi(p, "time_constants"), "time_constants")], {"dtype": $.ga(np, "float64")}), "creep_weights": _rows($.gi(p, "creep_weights"), "creep_weights", sets), "polynomial": _rows($.gi(p, "polynomial"), "polynomial", sets), "viscous": $.km(np, "array", [_numbers($.gi(p, "viscous"), "viscous")], {"dtype": $.ga(np, "float64")}), "center": number($.gi(p, "center"), "center"), "schedules": schedules, "known": $.gi(p, "known")}); }, {p: ["p"], ks: false});
_read_schedule = $.def(function (entry) { let name, unit;
{const $v5 = $.unpack($.tup($.gi(entry, "name"), $.gi(entry, "unit")), 2, -1);name = $v5[0];unit = $v5[1];}
if ((!$.t($.b.isinstance(name, $.b.str)) || !$.t($.b.isinstance(unit, $.b.str)) || !$.t((($t0, $t1, $t2) => $.t($.lt(0, ($t0 = $.b.len(name)))) && $.t($.le($t0, LONGEST_NAME)) && $.t($.ge(LONGEST_NAME, $.b.len(unit))))()))) {throw $.exc(ParameterError("a schedule has no name and unit of ordinary length."));}
return Schedule(name, number($.gi(entry, "low"), "low"), number($.gi(entry, "high"), "high"), unit); }, {p: ["entry"], ks: false});
model_of = $.def(function (family, p) { let curve;
if ($.t($.eq(family, "pi"))) {return _read_play(p);}
if ($.t($.eq(family, "modified-pi"))) {return ModifiedPrandtlIshlinskii(_read_play($.gi(p, "hysteresis")), _read_map($.gi(p, "after")), _read_map($.gi(p, "before")));}
if ($.t($.eq(family, "stop"))) {return StopOperatorModel($.km(np, "array", [_numbers($.gi(p, "thresholds"), "thresholds")], {"dtype": $.ga(np, "float64")}), $.km(np, "array", [_numbers($.gi(p, "stop_weights"), "stop_weights")], {"dtype": $.ga(np, "float64")}), number($.gi(p, "slope"), "slope"), number($.gi(p, "offset"), "offset"), ($.t(($.gi(p, "state") == null)) ? null : $.km(np, "array", [_numbers($.gi(p, "state"), "state")], {"dtype": $.ga(np, "float64")})), number($.gi(p, "center"), "center"));}
if ($.t($.eq(family, "sheared-pi"))) {return ShearedPrandtlIshlinskii(_read_play($.gi(p, "hysteresis")), number($.gi(p, "shear"), "shear"));}
if ($.t($.eq(family, "static"))) {curve = _read_map($.gi(p, "curve"));
if ($.t((curve == null))) {throw $.exc(ParameterError("curve is missing."));}
return StaticCurve(curve);}
if ($.t($.eq(family, "direct-inverse"))) {return _read_direct(p);}
throw $.exc(ParameterError(("" + "family " + $.f(family, ("" + ".60"), 114) + " is not one of pi, modified-pi, stop, sheared-pi, static, direct-inverse."))); }, {p: ["family", "p"], ks: false});
Object.assign($m, {"annotations": annotations, "Any": Any, "np": np, "Array": Array_, "ParameterError": ParameterError, "DirectInverse": DirectInverse, "Schedule": Schedule, "Model": Model, "ModifiedPrandtlIshlinskii": ModifiedPrandtlIshlinskii, "MonotoneMap": MonotoneMap, "StaticCurve": StaticCurve, "PrandtlIshlinskii": PrandtlIshlinskii, "StopOperatorModel": StopOperatorModel, "ShearedPrandtlIshlinskii": ShearedPrandtlIshlinskii, "Json": Json, "number": number, "MOST_SCHEDULES": MOST_SCHEDULES, "LONGEST_NAME": LONGEST_NAME, "_numbers": _numbers, "_read_play": _read_play, "_read_map": _read_map, "_rows": _rows, "_read_direct": _read_direct, "_read_schedule": _read_schedule, "model_of": model_of});
});
$.module("dehyst.models.storage", ($m) => {
let annotations, hashlib, json, math, os, Callable, import_module, Path, TYPE_CHECKING, Any, cast, files, DehystError, ModelFileError, ParameterError, ModelCard, SignalCard, Json, SCHEMA, OWN, READERS, MAXIMUM_BYTES, MAXIMUM_DEPTH, number, _signal, _checksum, model_to_dict, signed, save_model, NO_MODEL, _refuse, _too_deep, _read_signal, check_signed, read_card, model_from_dict, model_from_text, load, load_model;
hashlib = $.imp("hashlib");
json = $.imp("json");
math = $.imp("math");
os = $.imp("os");
Callable = $.from("collections.abc", "Callable");
import_module = $.from("importlib", "import_module");
Path = $.from("pathlib", "Path");
TYPE_CHECKING = $.from("typing", "TYPE_CHECKING");Any = $.from("typing", "Any");cast = $.from("typing", "cast");
files = $.from("dehyst", "files");
DehystError = $.from("dehyst.errors", "DehystError");ModelFileError = $.from("dehyst.errors", "ModelFileError");ParameterError = $.from("dehyst.errors", "ParameterError");
ModelCard = $.from("dehyst.models.card", "ModelCard");SignalCard = $.from("dehyst.models.card", "SignalCard");
Json = $.gi($.b.dict, $.tup($.b.str, Any));
SCHEMA = 1;
OWN = "dehyst-model";
READERS = $.dict([[OWN, "dehyst.models.parameters"], ["dehyst-family", "dehyst.families.files"]]);
MAXIMUM_BYTES = $.mul(1024, 1024);
MAXIMUM_DEPTH = 32;
number = $.def(function (value, name) { 
if (($.t($.b.isinstance(value, $.b.bool)) || !$.t($.b.isinstance(value, $.tup($.b.int, $.b.float))))) {throw $.exc(ParameterError(("" + $.f(name, "", -1) + " is not a number.")));}
return $.b.float(value); }, {p: ["value", "name"], ks: false});
_signal = $.def(function (card) { 
return $.dict([["name", $.ga(card, "name")], ["unit", $.ga(card, "unit")], ["low", $.ga(card, "low")], ["high", $.ga(card, "high")]]); }, {p: ["card"], ks: false});
_checksum = $.def(function (content) { let canonical;
canonical = $.km(json, "dumps", [content], {"sort_keys": true, "separators": $.tup(",", ":"), "ensure_ascii": true, "allow_nan": false});
$.cm($.km(json, "dumps", [content], {"ensure_ascii": false}), "encode", ["utf-8"]);
return hashlib.sha256($.cm(canonical, "encode", ["ascii"])).hexdigest(); }, {p: ["content"], ks: false});
model_to_dict = $.def(function (model) { 
return signed($.ga(model, "file_kind"), $.ga(model, "family"), model.file_parameters(), $.ga(model, "card")); }, {p: ["model"], ks: false});
signed = $.def(function (kind, family, parameters, card) { let content, fault;
content = $.dict([["format", kind], ["schema", SCHEMA], ["family", family], ["parameters", parameters], ["input", _signal($.ga(card, "input"))], ["output", _signal($.ga(card, "output"))], ["provenance", $.b.dict($.ga(card, "provenance"))]]);
try {content = json.loads($.km(json, "dumps", [content], {"allow_nan": false}));
$.si(content, "sha256", _checksum(content));} catch ($e) { $e = $.caught($e); if ($.isinst($e, $.tup($.b.TypeError, $.b.ValueError, RecursionError))) { fault = $e; {throw $.exc(ParameterError(("" + "provenance must hold plain JSON values only (" + $.f(fault, "", -1) + ").")));} } else throw $e; }
return content; }, {p: ["kind", "family", "parameters", "card"], ks: false});
save_model = $.def(function (model, path) { let text, fault;
text = $.add($.km(json, "dumps", [model_to_dict(model)], {"indent": 1, "allow_nan": false}), "\n");
try {model_from_text(text, $.b.str(path));} catch ($e) { $e = $.caught($e); if ($.isinst($e, ModelFileError)) { fault = $e; {throw $.exc(ParameterError(("" + "this model was not saved, because its file could not be read back: " + $.f(fault, "", -1))));} } else throw $e; }
return files.write_atomically(path, text); }, {p: ["model", "path"], ks: false});
NO_MODEL = "If it is a log, name it behind the model; else save the model again: `dehyst identify LOG --save FILE`.";
_refuse = $.def(function (path, what, cure = "") { 
cure = $.or(cure, () => "Save the model again with model.save(...) or `dehyst identify ... --save`.");
return $.k(ModelFileError, [("" + "model file '" + $.f(path, "", -1) + "' " + $.f(what, "", -1) + " " + $.f(cure, "", -1))], {"path": path}); }, {p: ["path", "what", "cure"], ks: false});
_too_deep = $.def(function (value) { let level, _, children;
level = [value];
for (const $v1 of $.it($.b.range(MAXIMUM_DEPTH))) { _ = $v1;
{children = (() => { const $r = []; for (const $v3 of $.it(level)) { let item; item = $v3; for (const $v2 of $.it(($.t($.b.isinstance(item, $.b.dict)) ? $.cm(item, "values", []) : item))) { let child; child = $v2; $r.push(child); } } return $r; })();
level = (() => { const $r = []; for (const $v4 of $.it(children)) { let child; child = $v4; if ($.t($.b.isinstance(child, $.tup($.b.dict, $.b.list)))) { $r.push(child); } } return $r; })();
if (!$.t(level)) {return false;}} }
return true; }, {p: ["value"], ks: false});
_read_signal = $.def(function (p, name) { let low, high, bounds;
if ((!$.t($.b.isinstance(p, $.b.dict)) || !$.t($.b.isinstance($.cm(p, "get", ["name"]), $.b.str)) || !$.t($.b.isinstance($.cm(p, "get", ["unit"]), $.b.str)))) {throw $.exc(ParameterError(("" + "'" + $.f(name, "", -1) + "' does not name a signal and its unit.")));}
{const $v5 = $.unpack($.tup($.cm(p, "get", ["low"]), $.cm(p, "get", ["high"])), 2, -1);low = $v5[0];high = $v5[1];}
if (($.t($.ne((low == null), (high == null))) || ($.t((low != null)) && !$.t($.le(number(low, "low"), number(high, "high")))))) {throw $.exc(ParameterError(("" + "'" + $.f(name, "", -1) + "' has no valid range (" + $.f(low, ("" + ".40"), 114) + " to " + $.f(high, ("" + ".40"), 114) + ").")));}
bounds = ($.t((low == null)) ? $.tup(null, null) : $.tup(number(low, "low"), number(high, "high")));
if (($.t(($.gi(bounds, 0) != null)) && !($.t(math.isfinite($.gi(bounds, 0))) && $.t(math.isfinite($.or($.gi(bounds, 1), () => 0.0)))))) {throw $.exc(ParameterError(("" + "'" + $.f(name, "", -1) + "' has an infinite range.")));}
return SignalCard($.gi(p, "name"), $.gi(p, "unit"), ...$.it(bounds)); }, {p: ["p", "name"], ks: false});
check_signed = $.def(function (content, path) { let body, intact;
if ((!$.t($.b.isinstance(content, $.b.dict)) || !$.t($.b.isinstance($.cm(content, "get", ["format"]), $.b.str)) || $.t(!$.in($.gi(content, "format"), READERS)))) {throw $.exc(_refuse(path, ("" + "is not a dehyst model: it lacks \"format\": \"" + $.f(OWN, "", -1) + "\".")));}
if (($.t(($.b.type($.cm(content, "get", ["schema"])) !== $.b.int)) || $.t($.ne($.gi(content, "schema"), SCHEMA)))) {throw $.exc(_refuse(path, ("" + "has schema version " + $.f($.cm(content, "get", ["schema"]), ("" + ".60"), 115) + "; this dehyst reads version " + $.f(SCHEMA, "", -1) + "."), "Install the dehyst that wrote it, or identify again."));}
if ($.t(_too_deep(content))) {throw $.exc(_refuse(path, ("" + "is nested deeper than " + $.f(MAXIMUM_DEPTH, "", -1) + " levels.")));}
body = $.dict((() => { const $r = []; for (const $v6 of $.it($.cm(content, "items", []))) { let key, value; {const $v7 = $.unpack($v6, 2, -1);key = $v7[0];value = $v7[1];} if ($.t($.ne(key, "sha256"))) { $r.push([key, value]); } } return $r; })());
try {intact = $.eq(_checksum(body), $.cm(content, "get", ["sha256"]));} catch ($e) { $e = $.caught($e); if ($.isinst($e, $.tup($.b.ValueError, RecursionError))) {  {intact = false;} } else throw $e; }
if (!$.t(intact)) {throw $.exc(_refuse(path, "does not match its checksum: it was edited or damaged after it was saved, so its numbers cannot be trusted on a machine.", "Restore it from a backup, or write edited parameters with model.save(...), which signs them anew."));}
return content; }, {p: ["content", "path"], ks: false});
read_card = $.def(function (content) { let provenance;
provenance = $.gi(content, "provenance");
if (!$.t($.b.isinstance(provenance, $.b.dict))) {throw $.exc(ParameterError("provenance is not an object."));}
return ModelCard(_read_signal($.gi(content, "input"), "input"), _read_signal($.gi(content, "output"), "output"), provenance); }, {p: ["content"], ks: false});
model_from_dict = $.def(function (content, path = "model") { let intact, made, fault;
intact = check_signed(content, path);
made = $.ga(import_module($.gi(READERS, $.gi(intact, "format"))), "model_of");
try {return made($.gi(intact, "family"), $.gi(intact, "parameters")).with_card(read_card(intact));} catch ($e) { $e = $.caught($e); if ($.isinst($e, ModelFileError)) { fault = $e; {throw $.exc(_refuse(path, $.b.str(fault), "Install the version or the module that wrote it."));} } else if ($.isinst($e, $.tup($.b.KeyError, $.b.TypeError, $.b.AttributeError, $.b.IndexError))) { fault = $e; {throw $.exc(_refuse(path, ("" + "lacks a part or holds one of the wrong kind (" + $.f(fault, ("" + ".200"), 115) + ").")));} } else if ($.isinst($e, $.tup(DehystError, $.b.ValueError, $.b.OverflowError))) { fault = $e; {throw $.exc(_refuse(path, ("" + "holds parameters of no model: " + $.f(fault, ("" + ".600"), 115))));} } else throw $e; } }, {p: ["content", "path"], ks: false});
model_from_text = $.def(function (text, path = "model") { 
return model_from_dict(files.document_of(text, $.def((what) => {  return _refuse(path, ("" + $.f(what, "", -1) + "."), NO_MODEL); }, {p: ["what"], ks: false})), path); }, {p: ["text", "path"], ks: false});
load = $.def(function (path) { let cure, text;
if (!$.t($.b.isinstance(path, $.bor($.b.str, $.ga(os, "PathLike"))))) {throw $.exc(_refuse(("" + $.f(path, ("" + ".60"), 114)), "is no path.", "Give the file's name, for example 'model.json'."));}
cure = "Name a file written by `dehyst identify ... --save`.";
text = files.text_of(path, $.def((what) => {  return _refuse($.b.str(path), ("" + $.f(what, "", -1) + "."), cure); }, {p: ["what"], ks: false}), MAXIMUM_BYTES);
return model_from_text(text, $.b.str(path)); }, {p: ["path"], ks: false});
load_model = $.def(function (path) { let model;
model = load(path);
if (($.t($.ne($.ga(model, "file_kind"), OWN)) || $.t($.ne($.ga(model, "direction"), "forward")))) {throw $.exc(_refuse($.b.str(path), ("" + "holds a " + $.f($.ga(model, "family"), "", -1) + " model, which has no operators whose memory could be bounded."), "Read it with dehyst.load, which reads every model, or identify another family where this is needed."));}
return model; }, {p: ["path"], ks: false});
Object.assign($m, {"annotations": annotations, "hashlib": hashlib, "json": json, "math": math, "os": os, "Callable": Callable, "import_module": import_module, "Path": Path, "TYPE_CHECKING": TYPE_CHECKING, "Any": Any, "cast": cast, "files": files, "DehystError": DehystError, "ModelFileError": ModelFileError, "ParameterError": ParameterError, "ModelCard": ModelCard, "SignalCard": SignalCard, "Json": Json, "SCHEMA": SCHEMA, "OWN": OWN, "READERS": READERS, "MAXIMUM_BYTES": MAXIMUM_BYTES, "MAXIMUM_DEPTH": MAXIMUM_DEPTH, "number": number, "_signal": _signal, "_checksum": _checksum, "model_to_dict": model_to_dict, "signed": signed, "save_model": save_model, "NO_MODEL": NO_MODEL, "_refuse": _refuse, "_too_deep": _too_deep, "_read_signal": _read_signal, "check_signed": check_signed, "read_card": read_card, "model_from_dict": model_from_dict, "model_from_text": model_from_text, "load": load, "load_model": load_model});
});
$.module("dehyst.files", ($m) => {
let annotations, errno, json, os, stat, tempfile, tomllib, Callable, suppress, Path, Any, DehystError, OutputError, Refusal, FULL, write_atomically, _there, _write_through, _take_over, _refused, cure, text_of, document_of, _no_constant, _no_repetition;
errno = $.imp("errno");
json = $.imp("json");
os = $.imp("os");
stat = $.imp("stat");
tempfile = $.imp("tempfile");
tomllib = $.imp("tomllib");
Callable = $.from("collections.abc", "Callable");
suppress = $.from("contextlib", "suppress");
Path = $.from("pathlib", "Path");
Any = $.from("typing", "Any");
DehystError = $.from("dehyst.errors", "DehystError");OutputError = $.from("dehyst.errors", "OutputError");
Refusal = $.gi(Callable, $.tup([$.b.str], DehystError));
FULL = $.tup($.ga(errno, "ENOSPC"), $.ga(errno, "EDQUOT"), $.ga(errno, "EFBIG"));
write_atomically = $.def(function (path, content) { let given, data, there, target, handle, temporary, fault, stream;
given = Path(path);
data = ($.t($.b.isinstance(content, $.b.str)) ? $.cm(content, "encode", ["utf-8"]) : content);
try {there = _there(given);
if (($.t((there != null)) && !$.t(stat.S_ISREG($.ga(there, "st_mode"))))) {_write_through(given, there, data);
return given;}
target = Path($.ga(os, "path").realpath(given));
{const $v1 = $.unpack($.km(tempfile, "mkstemp", [], {"prefix": ("" + "." + $.f($.ga(target, "name"), "", -1) + "."), "dir": $.ga(target, "parent")}), 2, -1);handle = $v1[0];temporary = $v1[1];}} catch ($e) { $e = $.caught($e); if ($.isinst($e, $.tup($.b.OSError, $.b.ValueError))) { fault = $e; {throw $.exc(_refused(given, fault));} } else throw $e; }
try {{ const $v2 = os.fdopen(handle, "wb"); stream = $.enter($v2); try {_take_over(temporary, there);
stream.write(data);
stream.flush();
os.fsync(stream.fileno());} catch ($e) { if (!$.exit($v2, $.caught($e))) throw $e; } }
$.cm(Path(temporary), "replace", [target]);} catch ($e) { $e = $.caught($e); if ($.isinst($e, $.b.OSError)) { fault = $e; {throw $.exc(_refused(given, fault));} } else throw $e; } finally {{ const $v3 = suppress($.b.OSError); $.enter($v3); try {Path(temporary).unlink();} catch ($e) { if (!$.exit($v3, $.caught($e))) throw $e; } }}
return given; }, {p: ["path", "content"], ks: false});
_there = $.def(function (path) { let there;
try {there = path.stat();} catch ($e) { $e = $.caught($e); if ($.isinst($e, $.b.FileNotFoundError)) {  {return null;} } else throw $e; }
if (($.t(stat.S_ISREG($.ga(there, "st_mode"))) && !$.t(os.access(path, $.ga(os, "W_OK"))))) {throw $.exc($.b.OSError($.ga(errno, "EACCES"), "it is protected against writing"));}
return there; }, {p: ["path"], ks: false});
_write_through = $.def(function (path, there, data) { let stream, left;
if ($.t(stat.S_ISDIR($.ga(there, "st_mode")))) {throw $.exc($.b.IsADirectoryError($.ga(errno, "EISDIR"), "it is a folder. Name a file inside it"));}
if ((!$.t(stat.S_ISFIFO($.ga(there, "st_mode"))) && !$.t(stat.S_ISCHR($.ga(there, "st_mode"))))) {throw $.exc($.b.OSError($.ga(errno, "EINVAL"), "it is a disk or a socket, no file"));}
{ const $v4 = $.km(path, "open", ["wb"], {"buffering": 0}); stream = $.enter($v4); try {left = memoryview(data);
while ($.t(left)) {left = $.gi(left, $.slice(stream.write(left), null, null));}} catch ($e) { if (!$.exit($v4, $.caught($e))) throw $e; } } }, {p: ["path", "there", "data"], ks: false});
_take_over = $.def(function (temporary, there) { let mask, mode, now;
if ($.t((there == null))) {mask = os.umask(0);
os.umask(mask);
Path(temporary).chmod($.band(438, $.inv(mask)));
return null;}
mode = stat.S_IMODE($.ga(there, "st_mode"));
now = Path(temporary).stat();
if ($.t($.ne($.tup($.ga(now, "st_uid"), $.ga(now, "st_gid")), $.tup($.ga(there, "st_uid"), $.ga(there, "st_gid"))))) {try {os.chown(temporary, $.ga(there, "st_uid"), $.ga(there, "st_gid"));} catch ($e) { $e = $.caught($e); if ($.isinst($e, $.b.OSError)) {  {mode = $.iband(mode, 455);} } else throw $e; }}
Path(temporary).chmod(mode); }, {p: ["temporary", "there"], ks: false});
_refused = $.def(function (path, fault) { let reason;
reason = $.or($.b.getattr(fault, "strerror", null), () => fault);
return $.k(OutputError, [("" + "cannot write '" + $.f(path, "", -1) + "': " + $.f(reason, "", -1) + ". What was there is untouched. " + $.f(cure(fault), "", -1))], {"path": $.b.str(path)}); }, {p: ["path", "fault"], ks: false});
cure = $.def(function (fault) { 
if ($.t($.in($.b.getattr(fault, "errno", null), FULL))) {return "Free some space or name another folder.";}
return "Name a folder that exists and that you may write to."; }, {p: ["fault"], ks: false});
text_of = $.def(function (path, refused, most = $.shl(1, 20)) { let source, what, stream, data, fault;
try {source = Path(path);
if (!$.t(source.is_file())) {what = (!$.t(source.exists()) ? "does not exist" : ($.t(source.is_dir()) ? "is a folder" : "is no regular file"));} else {{ const $v5 = source.open("rb"); stream = $.enter($v5); try {data = stream.read($.add(most, 1));} catch ($e) { if (!$.exit($v5, $.caught($e))) throw $e; } }
if ($.t($.le($.b.len(data), most))) {return $.cm(data, "decode", ["utf-8"]);}
what = ("" + "is larger than " + $.f(most, "", -1) + " bytes");}} catch ($e) { $e = $.caught($e); if ($.isinst($e, $.b.OSError)) { fault = $e; {what = ("" + "cannot be read (" + $.f($.ga(fault, "strerror"), "", -1) + ")");} } else if ($.isinst($e, $.b.ValueError)) { fault = $e; {what = ("" + "cannot be read as UTF-8 text (" + $.f(fault, "", -1) + ")");} } else throw $e; }
throw $.exc(refused(what)); }, {p: ["path", "refused", "most"], ks: false});
document_of = $.def(function (text, refused, language = "JSON") { let fault;
try {if ($.t($.eq(language, "TOML"))) {return tomllib.loads(text);}
return $.km(json, "loads", [text], {"parse_constant": _no_constant, "object_pairs_hook": _no_repetition});} catch ($e) { $e = $.caught($e); if ($.isinst($e, $.tup($.b.ValueError, RecursionError))) { fault = $e; {throw $.exc(refused(("" + "is not " + $.f(language, "", -1) + " (" + $.f($.gi($.cm(" ", "join", [$.cm($.b.str(fault), "split", [])]), $.slice(null, 160, null)), "", -1) + ")")));} } else throw $e; } }, {p: ["text", "refused", "language"], ks: false});
_no_constant = $.def(function (name) { 
throw $.exc($.b.ValueError(("" + $.f(name, "", -1) + " is not a JSON number"))); }, {p: ["name"], ks: false});
_no_repetition = $.def(function (pairs) { let content, name, value;
content = $.dict([]);
for (const $v6 of $.it(pairs)) { {const $v7 = $.unpack($v6, 2, -1);name = $v7[0];value = $v7[1];}
{if ($.t($.in(name, content))) {throw $.exc($.b.ValueError(("" + "the key '" + $.f(name, ("" + ".60"), -1) + "' stands twice in one object")));}
$.si(content, name, value);} }
return content; }, {p: ["pairs"], ks: false});
Object.assign($m, {"annotations": annotations, "errno": errno, "json": json, "os": os, "stat": stat, "tempfile": tempfile, "tomllib": tomllib, "Callable": Callable, "suppress": suppress, "Path": Path, "Any": Any, "DehystError": DehystError, "OutputError": OutputError, "Refusal": Refusal, "FULL": FULL, "write_atomically": write_atomically, "_there": _there, "_write_through": _write_through, "_take_over": _take_over, "_refused": _refused, "cure": cure, "text_of": text_of, "document_of": document_of, "_no_constant": _no_constant, "_no_repetition": _no_repetition});
});
$.module("dehyst.version", ($m) => {
let re, __version__, RELEASE;
re = $.imp("re");
__version__ = "0.1.0";
RELEASE = $.cm(".", "join", [$.gi([...$.it(re.findall("\\d+", __version__)), "0", "0"], $.slice(null, 3, null))]);
Object.assign($m, {"re": re, "__version__": __version__, "RELEASE": RELEASE});
});
