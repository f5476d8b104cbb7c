/* What the page asks of the package: the columns of a log and their roles, a fit and what it says, its files. */

import "../generated/files.js";
import "../generated/program.js";
import { rendered } from "./jinja.js";
import "../generated/templates.js";
import { forget, plain, provide, sha256, use } from "./native.js";
import { $ } from "./python.js";

let table = null, pair = null;

export function begin(core) {
  use(core);
  provide();
  // The pair that was read to look at a log is the one that is identified next.
  const select = room("io.select"), read_pair = select.read_pair;
  select.read_pair = (table, about, time, run, window) => {
    const key = [table, ...about.columns, time ?? null, run ?? null, ...window];
    if (!pair || key.some((part, k) => part !== pair.key[k])) {
      const before = about.findings.length;
      pair = { key, made: read_pair(table, about, time, run, window), found: about.findings.slice(before) };
    } else about.findings.push(...pair.found);
    return pair.made;
  };
  room("export.rendering").render = $.def((template, values) => rendered(template, Object.fromEntries(values.pairs())), { p: ["template"], ks: true });
}
let model = null; // the last one identified, and its fit
let last = null;
const room = (path) => $.imp(`dehyst.${path}`);
const called = (f, args, named) => $.k(f, args, named);

/** Read a text log, `packed` as it was on disk; what the columns are, and which look like input and output. */
export async function read(data, packed, name, digest) {
  table = pair = null;
  if (!data.length) throw called(room("errors").LogError, [`'${name}' is empty. Check that the logger was started.`], { file: name });
  const made = room("io.delimited").read_delimited(data, name);
  forget();
  table = called($.imp("dataclasses").replace, [made], { sha256: digest ? $.cm(new Uint8Array(await digest), "hex", []) : sha256(packed) });
  return inspect(null);
}
export function inspect(run) {
  const known = { starts: [...room("identification.memory").INITIAL_STATES], units: Object.keys(plain(room("units").TABLE).time) };
  return { ...plain(room("io.inspect").inspect_log(table, run)), ...known };
}
const given = (options) => Object.fromEntries(Object.entries(options).filter(([, v]) => v !== null && v !== undefined && v !== ""));
const values = (a) => (a === null || a === undefined ? null : new Float64Array(a.values()));

/** Identify: the fit as `dehyst identify --json` prints it, its sentences, its signals, its model. */
export function identify(input, output, run, reading = {}, fitting = {}) {
  const record = called(room("io.logs").read_log, [table, input, output], given({ run, ...reading }));
  const fit = room("identification.tracking").with_table(called(room("identification.plays").identify, [record, "pi"], given(fitting)));
  [model, last] = [fit.model, fit];
  const curve = fit.static;
  const [train, test] = [fit.train_masks[0], fit.test_masks[0]].map((mask) => new Uint8Array(mask.values()));
  const start = model._state ?? model.state;
  return {
    scores: { train: plain(fit.train), test: plain(fit.test), curve: plain(fit.static_test ?? fit.static_train) },
    verdict: $.b.str(fit.verdict),
    grade: $.b.str(room("findings").grade_of(fit.verdict)?.css ?? "stop"),
    warnings: [...fit.warnings].map(({ code, message }) => ({ code, message })),
    size: fit.size,
    start: room("identification.memory").past_in_words(fit.certificate.initial_state),
    orientation: fit.facts.orientation,
    width: fit.facts.width_percent,
    gain: fit.certificate.inverse_gain,
    labels: { input: record.input_label, output: record.output_label, inputUnit: record.input_unit, outputUnit: record.output_unit, inputName: record.input_name, outputName: record.output_name, name: record.name },
    time: values(record.time), x: values(record.input), y: values(record.output),
    predicted: values(fit.predictions[0]), asked: values(fit.inverse_predictions[0]), train, test,
    curve: { u: values(curve.curve.u), v: values(curve.curve.v), y: values(curve.simulate(record.input)) },
    model: { thresholds: values(model.thresholds), weights: values(model.weights), center: model.center, offset: model.offset, start: values(start) },
    card: { input: [model.card.input.low, model.card.input.high], output: [model.card.output.low, model.card.output.high] },
    file: file_of(model),
    ...typed(input, output, given({ run, ...reading }), given(fitting)),
  };
}
/** The lines that compare all families on the same part of the log, and that fit this one again. */
function typed(input, output, reading, fitting) {
  const words = (options) => Object.entries(options).flatMap(([name, value]) => [{ start: "--from", stop: "--to" }[name] ?? `--${name.replaceAll("_", "-")}`, String(value)]);
  const line = (...more) => room("shell").typed(["dehyst", "identify", table.name, "--input", input, "--output", output, ...words(reading), ...more, "--save", "model.json", "--report", "report.html"]);
  const { train_fraction } = fitting; // the other options of fitting are those of plays alone
  return { command: line(...words(given({ train_fraction }))), repeat: line("--family", "pi", ...words(fitting)) };
}
/** What takes longer: the last fit as `dehyst identify --json` prints it, and what its residual follows. */
export function more() {
  return {
    said: plain(last.as_dict()),
    left: last.residual.suggestions[0] ?? "",
  };
}
/** The C folder of the last model, as `dehyst export MODEL --target c` writes it. */
export function files(stem) {
  const name = room("export.names").identifier(stem);
  const subject = called(room("export.subject").subject_of, [model], { name });
  return room("export.folder").contents(subject, "c").pairs().sort((a, b) => (a[0] < b[0] ? -1 : 1)).map(([path, data]) => ({ name: path, data: Uint8Array.from(data) }));
}
function file_of(model) {
  return called($.imp("json").dumps, [room("models.storage").model_to_dict(model)], { indent: 1 }) + "\n";
}
/** What a person reads where the package refuses, and whether it did. */
export function refusal(fault) {
  const known = $.isinst(fault, room("errors").DehystError) || $.isinst(fault, $.b.MemoryError);
  return { known, message: known ? $.b.str(fault) : `the page failed: ${$.b.str(fault)}`, stack: known ? "" : String(fault?.stack ?? "") };
}
export { $, plain };
