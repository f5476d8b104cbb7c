/* Filling templates: what jinja2 does at run time, as far as the templates of target c need it. */

import { $, Dict } from "./python.js";

const known = new Map();
export const template = (name, made) => known.set(name, made);
export function look(context, name) {
  if (!(name in context)) throw new Error(`'${name}' is undefined`);
  return context[name];
}
export function member(o, name) {
  if (o instanceof Dict) {
    if (o.has(name)) return o.lookup(name)[1];
    return (...args) => $.cm(o, name, args);
  }
  if (typeof name === "number") return $.gi(o, name);
  if (o !== null && typeof o === "object" && !Array.isArray(o) && o.constructor === Object) return o[name];
  return $.ga(o, name);
}
/** A template filled; blocks of those that extend it come first. */
export function rendered(name, context, below = []) {
  const found = known.get(name);
  if (!found) throw new Error(`the page does not carry the template ${name}`);
  const made = found.make(context), chain = [...below, made.blocks], parent = found.parent(context);
  if (parent) return rendered(parent, made.context, chain);
  const block = (which, c, from = 0) => {
    for (let k = from; k < chain.length; k++) if (chain[k][which]) return chain[k][which](c, block, () => block(which, c, k + 1));
    return "";
  };
  return made.root(context, block)[0];
}
export function imported(name) {
  return known.get(name).make({}).root({}, () => "")[1];
}
const word = (v) => $.b.str(v);
export const filters = {
  join: (v, by = "") => [...$.it(v)].map(word).join(by), length: (v) => $.b.len(v), list: (v) => [...$.it(v)], upper: (v) => word(v).toUpperCase(),
  format: (spec, ...args) => { let k = 0; return spec.replace(/%(-?0?\d*(?:\.\d+)?[a-zA-Z%])/g, (_m, s) => (s === "%" ? "%" : s.endsWith("s") ? (s.length > 1 ? (s[0] === "-" ? word(args[k++]).padEnd(Number(s.slice(1, -1))) : word(args[k++]).padStart(Number(s.slice(0, -1)))) : word(args[k++])) : $.f(args[k++], s, -1))); },
  round: (v, n = 0) => $.b.round(v, n), truncate: (s, n = 255, kill = false, end = "...") => { s = word(s); if (s.length <= n + 5 - (kill ? 5 : 0) && s.length <= n) return s; if (s.length <= n + (kill ? 0 : 5)) return s; if (kill) return s.slice(0, n - end.length) + end; const cut = s.slice(0, n - end.length); return cut.slice(0, Math.max(0, cut.lastIndexOf(" ") < 0 ? cut.length : cut.lastIndexOf(" "))) + end; },
  replace: (s, a, b) => word(s).replaceAll(a, () => b), batch: (v, n) => { const a = [...$.it(v)], o = []; for (let k = 0; k < a.length; k += n) o.push(a.slice(k, k + n)); return o; },
  map: (v, what) => [...$.it(v)].map((x) => (what === "int" ? Math.trunc(x) : filters[what](x))),
  e: (s) => word(s).replaceAll("&", "&amp;").replaceAll(">", "&gt;").replaceAll("<", "&lt;").replaceAll("'", "&#39;").replaceAll('"', "&#34;"),
  tojson: (v) => $.k($.imp("json").dumps, [v], { sort_keys: true }).replaceAll("<", "\\u003c").replaceAll(">", "\\u003e").replaceAll("&", "\\u0026").replaceAll("'", "\\u0027"),
};
for (const name of ["comment", "string_literal", "padded", "doc"]) filters[name] = (...a) => $.imp("dehyst.export.rendering")[name](...a);
for (const name of ["literal", "pattern", "table", "decimal"]) filters[name] = (...a) => $.imp("dehyst.export.precision")[name](...a);
