/* What the page asks of the package: a table of bytes, its columns and their roles, a fit and what it says. */

import "./house.js";
import { $ } from "./runtime.js";
import { forget, plain, provide, use } from "./native.js";

let name = "";
let digest = "";
let table = null;
let bytes = null;

export function begin(core) {
  use(core);
  provide({ fingerprint: () => digest });
}
const module = (path) => $.imp(`dehyst.${path}`);

/** Read a text log; what the columns are, and which of them look like input and output. */
export function read(data, called, fingerprint) {
  [bytes, name, digest] = [data, called, fingerprint];
  table = null;
  table = module("io.delimited").read_delimited(data, called);
  forget();
  return inspect(null);
}
export function inspect(run) {
  const summary = module("io.inspect").inspect_log(table, run);
  return plain(summary);
}
/** Identify; the fit as `--json` prints it, its sentences, its signals and its model. */
export function identify(input, output, run, options = {}) {
  const record = module("io.logs").read_log.call(null, ...arranged(module("io.logs").read_log, [table, input, output], { run, ...options.reading }));
  const fit = module("identification.plays").identify.apply(null, arranged(module("identification.plays").identify, [record, "pi"], options.fitting ?? {}));
  return { fit, record };
}
function arranged(f, args, named) {
  const all = args.slice();
  for (const key of Object.keys(named)) all[f.$p.indexOf(key)] = named[key];
  return all;
}
export { $, plain };
