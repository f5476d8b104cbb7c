"""Reads units from column names, spells them in one way, and converts them within one dimension.

Values stay in the units of the log; this table exists for labels, for time stamps and for checks.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from dehyst.errors import UnitError

# dimension -> {canonical spelling: factor to the first unit of the dimension}
TABLE: dict[str, dict[str, float]] = {
    "pressure": {
        "Pa": 1.0,
        "kPa": 1e3,
        "MPa": 1e6,
        "bar": 1e5,
        "mbar": 1e2,
        "psi": 6894.757293168361,
        "mPa": 1e-3,
    },
    "angle": {"rad": 1.0, "deg": math.pi / 180, "mrad": 1e-3},
    "length": {"m": 1.0, "mm": 1e-3, "um": 1e-6, "nm": 1e-9, "cm": 1e-2, "in": 0.0254},
    "force": {"N": 1.0, "kN": 1e3, "mN": 1e-3, "lbf": 4.4482216152605},
    "voltage": {"V": 1.0, "mV": 1e-3, "kV": 1e3},
    "current": {"A": 1.0, "mA": 1e-3},
    "torque": {"Nm": 1.0, "mNm": 1e-3},
    "temperature": {"K": 1.0, "degC": 1.0, "degF": 5.0 / 9.0},
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0, "h": 3600.0},
}
# What 0 of a unit is in the first one of its dimension, where it is not 0.
OFFSETS = {"degC": 273.15, "degF": 459.67 * 5.0 / 9.0}
MOST_NAMES = (
    1 << 17
)  # that are remembered: a log of so many columns is asked for them several times
# Masses stand apart: only a load may be one. As the end of a name "g" is as often an acceleration or a letter.
MASS_FACTORS = {"kg": 1.0, "g": 1e-3}
DIMENSION = {unit: dimension for dimension, units in TABLE.items() for unit in units}

# Other spellings, in lower case. Upper-case variants of the table itself are found without them.
ALIASES = {
    "pascal": "Pa", "hpa": "mbar", "bars": "bar", "barg": "bar", "bara": "bar", "psig": "psi", "psia": "psi",
    "°": "deg", "degree": "deg", "degrees": "deg", "degs": "deg", "radian": "rad", "radians": "rad", "rads": "rad",
    "µm": "um", "μm": "um", "micron": "um", "microns": "um", "micrometer": "um", "meter": "m", "metre": "m",
    "meters": "m", "metres": "m", "inch": "in", "inches": "in", "millimeter": "mm", "millimetre": "mm",
    "newton": "N", "newtons": "N", "volt": "V", "volts": "V", "ampere": "A", "amperes": "A", "amp": "A", "amps": "A",
    "n·m": "Nm", "n*m": "Nm", "n m": "Nm", "n.m": "Nm", "n-m": "Nm",
    "kelvin": "K", "°c": "degC", "celsius": "degC", "deg_c": "degC", "deg c": "degC", "grad celsius": "degC",
    "°f": "degF", "fahrenheit": "degF", "deg_f": "degF", "deg f": "degF",
    "sec": "s", "secs": "s", "second": "s", "seconds": "s", "msec": "ms", "millis": "ms", "milliseconds": "ms",
    "µs": "us", "μs": "us", "usec": "us", "micros": "us", "microseconds": "us", "nsec": "ns", "nanos": "ns",
    "nanoseconds": "ns", "nanosec": "ns", "minutes": "min", "hour": "h", "hours": "h",
    "minute": "min", "millisecond": "ms", "microsecond": "us", "nanosecond": "ns", "mins": "min",
    "kilopascal": "kPa", "megapascal": "MPa", "hektopascal": "mbar", "hectopascal": "mbar", "millibar": "mbar",
    "grad": "deg", "winkelgrad": "deg", "milliradian": "mrad", "milliradians": "mrad", "radiant": "rad",
    "millimeters": "mm", "millimetres": "mm", "centimeter": "cm", "centimeters": "cm", "centimetre": "cm",
    "centimetres": "cm", "zentimeter": "cm", "micrometers": "um", "micrometre": "um", "micrometres": "um",
    "mikrometer": "um", "nanometer": "nm", "nanometers": "nm", "nanometre": "nm", "nanometres": "nm", "zoll": "in",
    "kilonewton": "kN", "kilonewtons": "kN", "millinewton": "mN", "millinewtons": "mN", "newtonmeter": "Nm",
    "newtonmeters": "Nm", "newtonmetre": "Nm", "newtonmetres": "Nm", "newton-meter": "Nm", "newton meter": "Nm",
    "millivolt": "mV", "millivolts": "mV", "kilovolt": "kV", "kilovolts": "kV", "milliampere": "mA",
    "milliamperes": "mA", "milliamp": "mA", "milliamps": "mA",
    "sekunde": "s", "sekunden": "s", "sek": "s", "millisekunde": "ms", "millisekunden": "ms", "msek": "ms",
    "mikrosekunde": "us", "mikrosekunden": "us", "nanosekunde": "ns", "nanosekunden": "ns", "minuten": "min",
    "stunde": "h", "stunden": "h",
}  # fmt: skip
# Spellings that are not accepted: only upper and lower case tell mega from milli, Nm from nm, newton seconds from ns.
_UNCLEAR = {"MN", "MV", "MA", "MNM", "NM", "Ns", "Us"}


def _spellings() -> dict[str, str]:
    """Spelling -> unit: in small letters, in capitals, and with a capital first letter unless that could mean mega."""
    variants: dict[str, str] = {}
    for unit in DIMENSION:
        forms = [unit.lower(), unit.upper()]
        if unit in {"m", "min"} or unit[0] != "m":
            forms += [unit[0].upper() + unit[1:], unit[0].upper() + unit[1:].lower()]
        for form in forms:
            if form not in _UNCLEAR and form not in variants:
                variants[form] = unit
    return variants


_SPELLINGS = _spellings()

# Whole names that can only be a time in that unit: Arduino's millis() and micros(), "Sekunden", ...
_CLOCK_NAMES = frozenset(
    alias
    for alias, unit in ALIASES.items()
    if DIMENSION[unit] == "time" and unit not in {"min", "h"} and len(alias) > 3
)

# Suffixes that are as often a channel letter, "input" or "minimum" as a unit: taken as a unit only when
# another word of the name belongs to the dimension.
_HINTED = {
    "k",
    "a",
    "v",
    "n",
    "m",
    "h",
    "s",
    "in",
    "min",
    "ma",
    "mn",
    "nm",
    "amp",
    "kn",
    "kv",
    "pa",
}
_HINTED |= {"grad", "radiant", "minute"}  # grad is a degree in German and a gradient in English
# In this case they are nothing but units.
_PLAIN_UNITS = {"N", "V", "Nm", "mN", "kN", "mA", "kV", "Pa"}
# In brackets: the wrong case of a unit is as often another one (siemens, henry, acceleration, number, speed).
_WRONG_CASE = {"S", "H", "M", "a", "n", "v"}
# Words beside which a suffix means something else: the yaw angle psi, a radial force, the pressure upstream.
_OTHER_MEANING = {
    "psi": frozenset({"angle", "euler", "yaw", "heading", "pitch", "roll", "winkel", "rotation"}),
    "rad": frozenset(
        {"force", "kraft", "load", "pressure", "stress", "strain", "stiffness", "clearance", "play"}
    ),
    "us": frozenset({"pressure", "druck", "flow", "temperature", "density"}),
}
# Of "position_in" most are inches, of "x_in" most are inputs.
_INCHES = frozenset(
    {
        "length",
        "displacement",
        "position",
        "stroke",
        "height",
        "distance",
        "contraction",
        "extension",
    }
)
_INCHES |= {"elongation", "travel", "deflection", "depth", "width", "thickness", "diameter", "gap"}
_HINTS = {
    dimension: frozenset(words.split())
    for dimension, words in {
        "pressure": "pressure p press druck supply pneumatic muscle chamber valve vacuum gauge stress",
        "length": "displacement position pos length x y z stroke height distance contraction extension elongation "
        "travel deflection depth disp weg",
        "angle": "angle winkel phi theta alpha beta gamma rotation drehung tilt",
        "force": "force f load tension kraft thrust grip fx fy fz",
        "voltage": "voltage volt u drive supply spannung piezo uin uout",
        "current": "current i strom",
        "torque": "torque moment tau drehmoment",
        "temperature": "temperature temp temps temperatur t housing coil winding heat body gehaeuse",
        "time": "time t timestamp stamp elapsed zeit temps tiempo duration clock dt date epoch period seconds ros sim",
    }.items()
}


def canonical(unit: str) -> str | None:
    """Spell a unit as in `TABLE`, or return None if it is not known. Capitals count where they change the unit.

    Examples
    --------
    >>> canonical("Degrees"), canonical("mpa"), canonical("mPa"), canonical("MV"), canonical("furlong")
    ('deg', 'MPa', 'mPa', None, None)
    """
    text = unit.strip()
    if text in DIMENSION:
        return text
    if text in _SPELLINGS:
        return _SPELLINGS[text]
    # Behind a micro sign the case counts: µS (microsiemens) must not be read as µs.
    if text.startswith(("µ", "μ")):
        return ALIASES.get(text)
    return ALIASES.get(text.lower())


def dimension(unit: str) -> str:
    """Dimension of a unit, for example ``"pressure"``, or "" if the unit is not known.

    Examples
    --------
    >>> dimension("psi"), dimension("rpm")
    ('pressure', '')
    """
    spelling = canonical(unit)
    if spelling is None:
        return ""
    return DIMENSION[spelling]


def mass_unit(name: str, unit: str) -> str:
    """Return the unit of a column that holds a mass, or "": ``unit`` if it is one, else that after the last ``_``.

    Examples
    --------
    >>> mass_unit("load_kg", ""), mass_unit("load", "g"), mass_unit("load_N", "N"), mass_unit("load_2", "")
    ('kg', 'g', '', '')
    """
    suffix = re.split(r"[_\s]", name.strip())[-1]
    unit_name = unit or suffix
    if unit_name in MASS_FACTORS:
        return unit_name
    return ""


@lru_cache(MOST_NAMES)
def words(name: str) -> tuple[str, ...]:
    """Words of a column name in lower case: split at punctuation, digits and changes of case.

    Examples
    --------
    >>> words("jointAngle_2 [deg]")
    ('joint', 'angle', 'deg')
    """
    spaced = re.sub(r"([a-z])([A-Z])", r"\1 \2", name)
    return tuple(re.findall(r"[^\W\d_]+", spaced.lower()))


def _unit_text(bare: str, text: str) -> str:
    """Unit as written in brackets: canonical where known, as it stands otherwise, "" for none."""
    text = text.strip()
    if text in {"", "-", "--", "1", "none", "None"}:
        return ""
    unit = _newton_metres(bare, text) or canonical(text)
    if unit is None or (text in _WRONG_CASE and not _hinted(bare, unit, text)):
        return text
    return unit


def _newton_metres(bare: str, text: str) -> str | None:
    """Nm in any case where the name is one of a torque, nm in capitals where it is one of a length."""
    if text.lower() != "nm":
        return None
    hints = set(words(bare))
    if hints & _HINTS["torque"]:
        return "Nm"
    if text == "NM" and hints & _HINTS["length"]:
        return "nm"
    return None


def _hinted(bare: str, unit: str, text: str) -> bool:
    """Whether another word of a name belongs to the dimension of a unit that is written so."""
    hints = _HINTS[DIMENSION[unit]]
    # "in" means input more often than inches, so fewer words speak for it.
    if text.lower() == "in":
        hints = _INCHES
    return bool(set(words(bare)) & hints)


def _suffix_unit(bare: str, suffix: str) -> str | None:
    low = suffix.lower()
    unit = _newton_metres(bare, suffix) or canonical(suffix)
    if unit is None and _is_field_unit(bare, suffix):
        return suffix
    if unit is None or (low in _OTHER_MEANING and set(words(bare)) & _OTHER_MEANING[low]):
        return None
    if low in _HINTED and not (suffix in _PLAIN_UNITS or _hinted(bare, unit, suffix)):
        return None
    return unit


def _is_field_unit(bare: str, suffix: str) -> bool:
    """Whether a suffix, in this very spelling, is a unit of a magnetic quantity or of a volume.

    "G" is as often an acceleration or a centre of gravity, "ml" a result of machine learning: a word of the name has to
    speak for the unit.
    """
    if suffix not in _FIELD_SUFFIXES:
        return False
    hints = _FIELD_SUFFIXES[suffix]
    return not hints or bool(set(words(bare)) & hints)


def _divided_unit(bare: str, unit: str) -> str | None:
    """Unit after a slash, as standards write labels: ``s/m`` is a way in metres, ``pos/in`` may be an input."""
    if unit in DIMENSION and unit not in {"in", "min"}:
        return unit
    return _suffix_unit(bare, unit)


def _quotient_unit(above: str, below: str) -> str:
    """Return the unit of a name like ``field_kV_per_mm``, or "" where one of both is none."""
    units = []
    for part in (above, below):
        if not _factor_of(part)[0]:
            return ""
        units.append(canonical(part) or part)
    return "/".join(units)


@lru_cache(MOST_NAMES)
def parse_unit(name: str) -> tuple[str, str]:
    """Split a column name into its bare name and its unit.

    Understood are ``angle [deg]``, ``angle (deg)``, ``p/bar`` and a known unit after the last ``_``.
    ``field_kV_per_mm`` is in kV/mm. A suffix that may as well be a letter or a word (``aux_a``, ``pressure_min``) is
    left alone. A name that is a unit of time and nothing else (``micros``) is both name and unit.

    Returns
    -------
    bare : str
        Name without the unit.
    unit : str
        Canonical spelling where the unit is known, the text in the brackets otherwise, "" if there is none.

    Examples
    --------
    >>> parse_unit("pressure_interp_psi"), parse_unit("angle [°]"), parse_unit("p/bar"), parse_unit("aux_a")
    (('pressure_interp', 'psi'), ('angle', 'deg'), ('p', 'bar'), ('aux_a', ''))
    """
    text = name.strip()
    if re.fullmatch(r"[VI]\([A-Za-z]\w*\)", text) and (
        text[2:-1] == "in" or not canonical(text[2:-1])
    ):
        return text, ""  # V(in), I(R1): a node or an element of a circuit
    if text[:3].lower() == "in " and canonical(text[3:]):
        return text, str(canonical(text[3:]))
    bracket = re.fullmatch(r"(.*?\S)\s*(?:\[([^\[\]]*)\]|\(([^()]*)\))", text)
    if bracket and not (bracket[2] or "").isdigit():  # position[0] is an index, not a unit
        inner = bracket[2]
        if inner is None:
            inner = bracket[3]
        return bracket[1].rstrip("_ "), _unit_text(bracket[1], inner)
    slash = re.fullmatch(r"([^/]*[^/\s])\s*/\s*([^/]+)", text)
    if slash:
        divided = _divided_unit(slash[1], slash[2].strip())
        if divided:
            return slash[1], divided
    # "angle_deg_s" would else be read as an angle in seconds.
    rate = re.fullmatch(r"(.*\w)_(mm|m|cm|um|deg|rad|bar)_s", text, re.IGNORECASE)
    if rate and set(words(rate[1])) & {"velocity", "vel", "speed", "rate", "omega", "v"}:
        return rate[1], f"{canonical(rate[2])}/s"
    quotient = re.fullmatch(r"(.*[^_\s])[_ ]([^_\s]+)[_ ]per[_ ]([^_\s]+)", text)
    if quotient and _quotient_unit(quotient[2], quotient[3]):
        return quotient[1], _quotient_unit(quotient[2], quotient[3])
    # "counts_per_mm" is no way in millimetres, whatever is counted.
    if re.search(r"(^|[_ ])per[_ ][^_\s]+$", text, re.IGNORECASE):
        return text, ""
    if text.lower() in _CLOCK_NAMES:
        return text, str(canonical(text))
    bare, unit_name, suffix = text.rpartition("_")
    if not unit_name:
        bare, unit_name, suffix = text.rpartition(" ")
    # Something must stand before the unit: a name like "_bar" is a name.
    if unit_name and bare.strip("_ "):
        unit = _suffix_unit(bare, suffix)
        if unit:
            return bare.rstrip("_ "), unit
    return text, ""


def stray_suffixes(names: Sequence[str]) -> frozenset[str]:
    """Names that seem to end in a unit, where another column of the log shows that the ending means something else.

    Examples
    --------
    >>> sorted(stray_suffixes(["time_s", "position_in", "position_out", "i_a", "i_b", "force_N", "motor_A", "motor_V"]))
    ['i_a', 'position_in']
    """
    outputs = any({"out", "output"} & set(words(name)) for name in names)
    endings: dict[str, set[str]] = {}
    for name in names:
        bare, _, suffix = name.rpartition("_")
        if len(suffix) == 1:
            endings.setdefault(bare.lower(), set()).add(suffix)
    stray = set()
    for name in names:
        bare, _, suffix = name.rpartition("_")
        if suffix.lower() not in _HINTED:
            continue
        unit = parse_unit(name)[1]
        # Columns of time are judged later, where the clock is chosen.
        if DIMENSION.get(unit, "time") == "time":
            continue
        # Beside "i_b", "i_a" is a channel and no ampere.
        for letter in endings.get(bare.lower(), set()) - {suffix}:
            if letter.isalpha() and letter not in DIMENSION:
                stray.add(name)
        if suffix.lower() == "in" and outputs:
            stray.add(name)
    return frozenset(stray)


def convert(values: npt.ArrayLike, source: str, target: str) -> npt.NDArray[np.float64]:
    """Convert values from one unit to another of the same dimension.

    Parameters
    ----------
    values
        Numbers, any shape. [source]
    source, target
        Units of one dimension, in any known spelling.

    Returns
    -------
    converted : same shape
        ``values * (factor of source / factor of target)``; temperatures are shifted, too. [target]

    Raises
    ------
    UnitError
        If a unit is not known, or the two differ in dimension.

    Examples
    --------
    >>> convert([1.0, 2.5], "bar", "kPa").tolist(), convert(20.0, "degC", "K").round(2).tolist()
    ([100.0, 250.0], 293.15)
    """
    spellings = [canonical(source), canonical(target)]
    for typed, unit in zip((source, target), spellings, strict=True):
        if unit is None:
            raise UnitError(
                f"unit '{typed}' is not known. Known are {', '.join(DIMENSION)}. Convert the values yourself "
                f"and put the unit into the column name, for example pressure_bar.",
                unit=typed,
            )
    a, b = str(spellings[0]), str(spellings[1])
    if DIMENSION[a] != DIMENSION[b]:
        raise UnitError(
            f"cannot convert {a} ({DIMENSION[a]}) into {b} ({DIMENSION[b]}): they measure different things. "
            f"Check that input and output are not swapped and that the column names carry the right units.",
            source=a,
            target=b,
        )
    table = TABLE[DIMENSION[a]]
    array = np.asarray(values, dtype=np.float64)
    # One rounded factor, except down to the reference unit and back, keeps round trips to one ulp.
    factor = table[a] / table[b]
    inverse = table[b] / table[a]
    shift = (OFFSETS.get(a, 0.0) - OFFSETS.get(b, 0.0)) / table[b]
    if shift:
        return np.asarray(array * factor + shift)
    if inverse.is_integer():
        return array / inverse
    return array * factor


# Quantities that logs hold beside those of `TABLE`, and whose product with another one is a work or a loss.
FIELD_UNITS: dict[str, dict[str, float]] = {
    "charge": {"C": 1.0, "mC": 1e-3, "uC": 1e-6, "nC": 1e-9, "pC": 1e-12},
    "flux": {"Wb": 1.0, "mWb": 1e-3, "Vs": 1.0, "V s": 1.0, "V*s": 1.0, "mVs": 1e-3},
    "flux density": {"T": 1.0, "mT": 1e-3, "G": 1e-4, "kG": 0.1},
    "magnetic field": {
        "A/m": 1.0,
        "kA/m": 1e3,
        "A/cm": 1e2,
        "Oe": 1e3 / (4.0 * math.pi),
        "kOe": 1e6 / (4.0 * math.pi),
    },
    "electric field": {"V/m": 1.0, "kV/m": 1e3, "kV/cm": 1e5, "kV/mm": 1e6, "MV/m": 1e6},
    "polarisation": {"C/m2": 1.0, "C/m^2": 1.0, "uC/cm2": 1e-2, "uC/cm^2": 1e-2},
    "volume": {"m3": 1.0, "m^3": 1.0, "L": 1e-3, "l": 1e-3, "mL": 1e-6, "ml": 1e-6, "cm3": 1e-6},
    "strain": {"%": 1e-2, "m/m": 1.0, "mm/mm": 1.0},
}
# Those that are known as the end of a name, beside one of these words; an empty set asks for none.
_FLUX = frozenset({"b", "flux", "field", "induction", "magnetic", "hall", "feld"})
_VOLUMES = frozenset({"v", "volume", "vol", "volumen", "dose", "syringe", "stroke", "displacement"})
_FIELD_SUFFIXES: dict[str, frozenset[str]] = {
    "Oe": frozenset(), "kOe": frozenset(), "G": _FLUX, "kG": _FLUX, "mT": _FLUX, "ml": _VOLUMES, "mL": _VOLUMES,
}  # fmt: skip
# Two dimensions -> the SI unit of the area of a loop between them.
WORKS: dict[frozenset[str], str] = {
    frozenset({"force", "length"}): "J",
    frozenset({"torque", "angle"}): "J",
    frozenset({"voltage", "charge"}): "J",
    frozenset({"current", "flux"}): "J",
    frozenset({"pressure", "volume"}): "J",
    frozenset({"flux density", "magnetic field"}): "J/m3",
    frozenset({"electric field", "polarisation"}): "J/m3",
    frozenset({"pressure", "strain"}): "J/m3",
}
PREFIXES = {1e-9: "n", 1e-6: "u", 1e-3: "m", 1.0: "", 1e3: "k", 1e6: "M"}


def _factor_of(unit: str) -> tuple[str, float]:
    """Dimension and factor to SI of a unit of `TABLE` or `FIELD_UNITS`; ("", 1) of any other."""
    spelling = canonical(unit)
    if spelling is not None:
        return DIMENSION[spelling], TABLE[DIMENSION[spelling]][spelling]
    plain = unit.strip().translate(_PLAIN_SIGNS)
    for kind, units in FIELD_UNITS.items():
        if plain in units:
            return kind, units[plain]
    return "", 1.0


_PLAIN_SIGNS = str.maketrans({"µ": "u", "μ": "u", "²": "2", "³": "3", "⋅": "*", "·": "*"})


def work_unit(first: str, second: str) -> tuple[float, str]:
    """Return the factor and the unit of a product of two signals, which is what a loop between them encloses.

    Joule, or joule per cubic metre, where both units are known and their product is a work; else both side by side.

    Returns
    -------
    factor : float
        The product in the units of the log times this is in `unit`.
    unit : str
        For example ``"mJ"``; ``"bar deg"`` where the product is no work, "" where one of both is not known.

    Examples
    --------
    >>> work_unit("mm", "N"), work_unit("T", "A/m"), work_unit("bar", "deg")
    ((1.0, 'mJ'), (1.0, 'J/m3'), (1.0, 'bar deg'))
    >>> factor, unit = work_unit("deg", "Nm")
    >>> round(180 * factor, 6), unit
    (3.141593, 'J')
    """
    kinds = []
    factor = 1.0
    for unit in (first, second):
        kind, to_si = _factor_of(unit)
        kinds.append(kind)
        factor *= to_si
    work = WORKS.get(frozenset(kinds))
    if work is None:
        both = first.strip(), second.strip()
        if not all(both):
            return 1.0, ""
        return 1.0, " ".join(both)
    # A product that is a joule with a prefix keeps its number: 3 N mm are 3 mJ.
    for size, prefix in PREFIXES.items():
        if math.isclose(factor, size, rel_tol=1e-12):
            return 1.0, f"{prefix}{work}"
    return factor, work
