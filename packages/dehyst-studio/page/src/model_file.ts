/** The model file of dehyst: JSON with a checksum over its canonical form, as dehyst.models._storage reads it. */

import type { Fit } from "./fit";
import { Column, Log, unitOf } from "./log";
import type { Points } from "./wasm";

/** A number that is written as a real one. */
class Real {
  constructor(readonly value: number) {}
}
type Json = null | string | number | Real | Json[] | { [key: string]: Json };

const reals = (values: ArrayLike<number>): Real[] => Array.from(values, (value) => new Real(value));

/** A real number as Python writes it: 1.0, 1e-05, 1e+16. */
function realText(value: number): string {
  if (!Number.isFinite(value)) throw new RangeError("a parameter is not finite");
  const [digits, power] = value.toExponential().split("e");
  const exponent = Number(power);
  if (value !== 0 && (exponent < -4 || exponent >= 16)) return `${digits}e${exponent < 0 ? "-" : "+"}${String(Math.abs(exponent)).padStart(2, "0")}`;
  const text = Object.is(value, -0) ? "-0" : String(value);
  return text.includes(".") ? text : `${text}.0`;
}

const wordText = (word: string): string => JSON.stringify(word).replace(/[\u007f-\uffff]/g, (sign) => `\\u${sign.charCodeAt(0).toString(16).padStart(4, "0")}`);

/** JSON without spaces, keys in order; or with a line an entry, in the order that they have. */
function written(value: Json, indent: number | null): string {
  const gap = indent === null ? "" : `\n${" ".repeat(indent + 1)}`;
  const end = indent === null ? "" : `\n${" ".repeat(indent)}`;
  const inner = indent === null ? null : indent + 1;
  if (value === null) return "null";
  if (typeof value === "string") return wordText(value);
  if (typeof value === "number") return String(value);
  if (value instanceof Real) return realText(value.value);
  if (Array.isArray(value)) return value.length ? `[${gap}${value.map((entry) => written(entry, inner)).join(`,${gap}`)}${end}]` : "[]";
  const keys = indent === null ? Object.keys(value).sort() : Object.keys(value);
  const colon = indent === null ? ":" : ": ";
  return keys.length ? `{${gap}${keys.map((key) => wordText(key) + colon + written(value[key], inner)).join(`,${gap}`)}${end}}` : "{}";
}

/** Text of the model file of a fit. */
export function modelFile({ family, model, scores, eps, start, smoothing, ridge, fitted }: Fit, log: Log, input: Column, output: Column, version: string): string {
  const points = (map: Points): Json => ({ u: reals(map.u), v: reals(map.v) });
  const plays: Json = {
    thresholds: reals(model.thresholds), weights: reals(model.weights), offset: new Real(model.offset), center: new Real(model.center),
    state: model.start.some((z) => z !== 0) ? reals(model.start) : null,
  };
  const signal = ({ name, unit, values }: Column): Json => ({ name: unitOf(name).bare, unit, low: new Real(values.reduce((a, b) => Math.min(a, b))), high: new Real(values.reduce((a, b) => Math.max(a, b))) });
  const score = ({ rmse, percent }: Fit["scores"]["train"]): Json => ({ rmse: new Real(rmse), rmse_percent: new Real(percent) });
  const regularisation: Record<string, Json> = smoothing === null ? {} : { smoothing: new Real(smoothing), ridge: new Real(ridge!) };
  const content: Record<string, Json> = {
    format: "dehyst-model",
    schema: 1,
    family,
    parameters: model.after ? { hysteresis: plays, after: points(model.after), before: null } : plays,
    input: signal(input),
    output: signal(output),
    provenance: {
      logs: [{ name: log.name, samples: log.rows, input: input.name, output: output.name }],
      date: `${new Date().toISOString().slice(0, 19)}+00:00`,
      dehyst: version,
      settings: { family, n: 100, eps: new Real(eps), thresholds: "grid", initial_state: start, train_fraction: new Real(0.5), ...regularisation },
      identified_family: family,
      initial_state: start,
      fitted_samples: fitted,
      train: score(scores.train),
      test: score(scores.test),
      verdict: "not judged: fitted by the page in a browser; dehyst identify judges the same log.",
    },
  };
  content.sha256 = sha256(new TextEncoder().encode(written(content, null)));
  return `${written(content, 0)}\n`;
}

const primes: number[] = [];
for (let n = 2; primes.length < 64; n++) if (primes.every((p) => n % p)) primes.push(n);
const fraction = (value: number): number => ((value - Math.floor(value)) * 2 ** 32) >>> 0;
const ROUNDS = Uint32Array.from(primes, (p) => fraction(Math.cbrt(p)));

/** SHA-256 (FIPS 180-4) in hexadecimal: a page of a plain http address has no crypto.subtle. */
export function sha256(data: Uint8Array): string {
  const blocks = Math.ceil((data.length + 9) / 64);
  const padded = new Uint8Array(64 * blocks);
  padded.set(data);
  padded[data.length] = 0x80;
  const view = new DataView(padded.buffer);
  view.setBigUint64(padded.length - 8, BigInt(data.length) * 8n);
  const hash = Uint32Array.from(primes.slice(0, 8), (p) => fraction(Math.sqrt(p)));
  const w = new Uint32Array(64);
  const turn = (x: number, by: number): number => (x >>> by) | (x << (32 - by));
  for (let block = 0; block < blocks; block++) {
    for (let k = 0; k < 16; k++) w[k] = view.getUint32(64 * block + 4 * k);
    for (let k = 16; k < 64; k++) {
      const [x, y] = [w[k - 15], w[k - 2]];
      w[k] = w[k - 16] + w[k - 7] + (turn(x, 7) ^ turn(x, 18) ^ (x >>> 3)) + (turn(y, 17) ^ turn(y, 19) ^ (y >>> 10));
    }
    let [a, b, c, d, e, f, g, h] = hash;
    for (let k = 0; k < 64; k++) {
      const s = (h + (turn(e, 6) ^ turn(e, 11) ^ turn(e, 25)) + ((e & f) ^ (~e & g)) + ROUNDS[k] + w[k]) | 0;
      const t = ((turn(a, 2) ^ turn(a, 13) ^ turn(a, 22)) + ((a & b) ^ (a & c) ^ (b & c))) | 0;
      [h, g, f, e, d, c, b, a] = [g, f, e, (d + s) | 0, c, b, a, (s + t) | 0];
    }
    [a, b, c, d, e, f, g, h].forEach((value, k) => { hash[k] += value; });
  }
  return Array.from(hash, (value) => value.toString(16).padStart(8, "0")).join("");
}
