/* The part of numpy that the rooms of the page use: strided arrays of doubles, of truth values (bytes) and of text. */

import { $, nd, Slice, bounds, Range, isTuple } from "./python.js";

const Named = $.Named;
const size_of = (shape) => shape.reduce((n, k) => n * k, 1);
const steps_of = (shape) => { const s = new Array(shape.length); let n = 1; for (let k = shape.length - 1; k >= 0; k--) { s[k] = n; n *= shape[k]; } return s; };
const store = (dtype, n) => (dtype === "b" ? new Uint8Array(n) : dtype === "U" ? new Array(n).fill("") : new Float64Array(n));

export class NDArray {
  constructor(data, shape, dtype, strides = steps_of(shape), offset = 0) {
    this.data = data; this.shape = $.tup(...shape); this.type = dtype; this.strides = strides; this.offset = offset;
  }
  get size() { return size_of(this.shape); }
  get ndim() { return this.shape.length; }
  get T() { return new NDArray(this.data, [...this.shape].reverse(), this.type, [...this.strides].reverse(), this.offset); }
  get dtype() { return { kind: this.type === "i" ? "i" : this.type === "b" ? "b" : this.type === "U" ? "U" : "f", type: this.type, itemsize: 8 }; }
  get nbytes() { return 8 * this.size; }
  get flags() { return { writeable: true, c_contiguous: this.dense() }; }
  get flat() { return this.ravel(); }
  get base() { return null; }
  dense() { let n = 1; for (let k = this.shape.length - 1; k >= 0; k--) { if (this.shape[k] !== 1 && this.strides[k] !== n) return false; n *= this.shape[k]; } return true; }
  /** Values in order: the memory itself where it is dense. */
  values() {
    const n = this.size;
    if (this.dense()) return this.type === "U" ? (this.offset === 0 && this.data.length === n ? this.data : this.data.slice(this.offset, this.offset + n)) : this.data.subarray(this.offset, this.offset + n);
    const out = store(this.type, n);
    if (this.ndim === 1) { const s = this.strides[0]; for (let k = 0, a = this.offset; k < n; k++, a += s) out[k] = this.data[a]; return out; }
    let k = 0;
    if (this.ndim === 2) {
      const [n, m] = this.shape, [s0, s1] = this.strides, from = this.data;
      for (let i = 0, r = this.offset; i < n; i++, r += s0) for (let j = 0, z = r; j < m; j++, z += s1) out[k++] = from[z];
      return out;
    }
    each(this.shape, [this.strides], [this.offset], (a) => { out[k++] = this.data[a]; });
    return out;
  }
  fresh() { const v = this.values(); return new NDArray(v === this.data || v.buffer === this.data.buffer && this.type !== "U" ? v.slice() : this.type === "U" ? v.slice() : v, this.shape, this.type); }
  out(v) { return this.type === "b" ? v !== 0 : v; }
  truth() { if (this.size !== 1) $.raise("ValueError", "truth value of an array"); return !!this.values()[0]; }
  item() { if (this.size !== 1) $.raise("TypeError", "only arrays of one element"); return this.out(this.values()[0]); }
  *[Symbol.iterator]() {
    if (!this.ndim) $.raise("TypeError", "0-d array");
    if (this.ndim === 1) { const v = this.values(); for (let k = 0; k < v.length; k++) yield this.out(v[k]); return; }
    for (let k = 0; k < this.shape[0]; k++) yield this.get(k);
  }
  __len__() { return this.shape[0]; }
  tolist() { if (this.ndim === 0) return this.item(); if (this.ndim === 1) { const v = this.values(); return this.type === "b" ? Array.from(v, (x) => x !== 0) : Array.from(v); } return [...this].map((r) => r.tolist()); }
  copy() { return this.fresh(); }
  view() { return this; }
  tobytes() { return new Uint8Array(new Float64Array(this.values()).buffer); }
  ravel() { return new NDArray(this.values(), [this.size], this.type); }
  flatten() { return this.fresh().ravel(); }
  reshape(...shape) {
    if (Array.isArray(shape[0])) shape = [...shape[0]];
    const n = this.size, at = shape.indexOf(-1);
    if (at >= 0) shape[at] = n / shape.reduce((p, k) => (k === -1 ? p : p * k), 1);
    return new NDArray(this.values(), shape, this.type);
  }
  transpose() { return this.T; }
  astype(t) { return cast(this, t); }
  fill(v) { this.put($.slice(null, null, null), v); return null; }
  sort() { const v = sorted(this.values()); this.put($.slice(null, null, null), new NDArray(v, [v.length], this.type)); return null; }
  argsort(n) { return np.argsort(this, n); }
  dot(o) { return np.dot(this, o); }
  searchsorted(v, n) { return np.searchsorted(this, v, n); }
  repeat(n) { return np.repeat(this, n); }
  round(d = 0) { return np.round(this, d); }
  clip(a, b) { return np.clip(this, a, b); }
  nonzero() { return $.tup(np.flatnonzero(this)); }
  take(i, n) { return np.take(this, i, n); }
  get(index) {
    if (typeof index === "number" && this.ndim === 1) {
      const at = index < 0 ? index + this.shape[0] : index;
      if (!(at >= 0 && at < this.shape[0])) $.raise("IndexError", `index ${index} is out of bounds for size ${this.shape[0]}`);
      return this.out(this.data[this.offset + at * this.strides[0]]);
    }
    if (index instanceof NDArray && index.ndim === 1 && this.type !== "U") {
      const quick = rows_at(this, index);
      if (quick) return quick;
    }
    const plan = planned(this, index);
    if (plan.places) return new NDArray(gather(this, plan), plan.shape, this.type);
    const view = new NDArray(this.data, plan.shape, this.type, plan.strides, plan.offset);
    return plan.shape.length ? view : view.out(this.data[plan.offset]);
  }
  put(index, value) {
    const plan = planned(this, index);
    if (plan.places) {
      const v = broadcast(array(value), plan.shape).values();
      for (let k = 0; k < plan.places.length; k++) this.data[plan.places[k]] = v[k];
      return;
    }
    const from = broadcast(array(value), plan.shape);
    if (from.data === this.data) { assign(this.data, plan, from.fresh()); return; }
    assign(this.data, plan, from);
  }
}
nd.NDArray = NDArray;
/* Rows by a mask or by numbers, the usual ways to choose. */
function rows_at(a, index) {
  const n = a.shape[0], v = index.values();
  if (a.ndim > 2 || (index.type === "b" && index.size !== n)) return null;
  const m = a.ndim === 2 ? a.shape[1] : 1;
  let count = v.length;
  if (index.type === "b") { count = 0; for (let k = 0; k < n; k++) if (v[k]) count++; }
  else for (let k = 0; k < count; k++) if (!(v[k] >= 0 && v[k] < n)) return null;
  const out = store(a.type, count * m);
  if (m > 1 || a.ndim === 2) {
    if (!a.dense()) return null;
    const from = a.values();
    if (index.type === "b" && count === n) out.set(from);
    else if (index.type === "b") { for (let k = 0, q = 0; k < n; k++) if (v[k]) { out.set(from.subarray(k * m, (k + 1) * m), q); q += m; } }
    else for (let k = 0; k < count; k++) out.set(from.subarray(v[k] * m, (v[k] + 1) * m), k * m);
    return new NDArray(out, [count, m], a.type);
  }
  const from = a.data, s = a.strides[0], o = a.offset;
  if (index.type === "b") { for (let k = 0, q = 0; k < n; k++) if (v[k]) out[q++] = from[o + k * s]; }
  else for (let k = 0; k < count; k++) out[k] = from[o + v[k] * s];
  return new NDArray(out, [count], a.type);
}
function gather(a, plan) { const out = store(a.type, plan.places.length); for (let k = 0; k < out.length; k++) out[k] = a.data[plan.places[k]]; return out; }
function assign(data, plan, from) {
  if (!plan.shape.length) { data[plan.offset] = from.values()[0]; return; }
  if (plan.shape.length === 1) { for (let k = 0, a = plan.offset, b = from.offset, s = plan.strides[0], t = from.strides[0], v = from.data; k < plan.shape[0]; k++, a += s, b += t) data[a] = v[b]; return; }
  each(plan.shape, [plan.strides, from.strides], [plan.offset, from.offset], (a, b) => { data[a] = from.data[b]; });
}
/** Visit the places of arrays of one shape together. */
function each(shape, strides, offsets, visit) {
  if (shape.some((n) => n === 0)) return;
  const last = shape.length - 1;
  if (last < 0) { visit(...offsets); return; }
  const at = new Array(shape.length).fill(0);
  const place = offsets.slice();
  const two = strides.length > 1;
  for (;;) {
    let a = place[0], b = two ? place[1] : 0;
    const sa = strides[0][last], sb = two ? strides[1][last] : 0;
    for (let k = 0; k < shape[last]; k++, a += sa, b += sb) visit(a, b);
    let axis = last - 1;
    for (; axis >= 0; axis--) {
      at[axis]++;
      for (let q = 0; q < place.length; q++) place[q] += strides[q][axis];
      if (at[axis] < shape[axis]) break;
      for (let q = 0; q < place.length; q++) place[q] -= strides[q][axis] * shape[axis];
      at[axis] = 0;
    }
    if (axis < 0) return;
  }
}
function planned(a, index) {
  let parts = Array.isArray(index) && isTuple(index) ? [...index] : [index];
  const used = parts.filter((p) => p !== null && p !== $.ellipsis).reduce((n, p) => n + (p instanceof NDArray && p.type === "b" ? p.ndim : 1), 0);
  const dots = parts.indexOf($.ellipsis);
  const fill = () => Array.from({ length: a.ndim - used }, () => new Slice(null, null, null));
  parts = dots >= 0 ? [...parts.slice(0, dots), ...fill(), ...parts.slice(dots + 1)] : [...parts, ...fill()];
  const shape = [], strides = [];
  let offset = a.offset, axis = 0;
  const fancy = []; // [position in shape, axis, indices]
  for (let part of parts) {
    if (part === null) { shape.push(1); strides.push(0); continue; }
    const n = a.shape[axis], s = a.strides[axis];
    if (part instanceof Slice) {
      const [lo, hi, step] = bounds(part, n);
      shape.push(Math.max(0, Math.ceil((hi - lo) / step))); strides.push(s * step); offset += lo * s; axis++;
      if (shape[shape.length - 1] === 0) offset -= lo * s;
      continue;
    }
    if (typeof part === "boolean") part = Number(part);
    if (typeof part === "number") {
      const at = part < 0 ? part + n : part;
      if (!(at >= 0 && at < n)) $.raise("IndexError", `index ${part} is out of bounds for axis of size ${n}`);
      offset += at * s; axis++;
      continue;
    }
    part = part instanceof NDArray ? part : array(part);
    if (part.type === "b" && part.ndim > 1) {
      const rows = [], cols = [], v = part.values(), w = part.shape[1];
      for (let k = 0; k < v.length; k++) if (v[k]) { rows.push(Math.floor(k / w)); cols.push(k % w); }
      fancy.push([shape.length, axis, arrayOf(rows, "i")], [shape.length, axis + 1, arrayOf(cols, "i")]);
      axis += 2;
      continue;
    }
    if (part.type === "b") {
      if (part.size !== n) $.raise("IndexError", `mask of ${part.size} for axis of size ${n}`);
      part = np.flatnonzero(part);
    }
    fancy.push([shape.length, axis, part]);
    axis++;
  }
  if (!fancy.length) return { shape, strides, offset };
  const common = fancy.reduce((sh, f) => joint(sh, f[2].shape), []);
  const lists = fancy.map(([, ax, p]) => {
    const v = broadcast(p, common).values(), n = a.shape[ax];
    const out = new Float64Array(v.length);
    for (let k = 0; k < v.length; k++) {
      const at = v[k] < 0 ? v[k] + n : v[k];
      if (!(at >= 0 && at < n)) $.raise("IndexError", `index ${v[k]} is out of bounds for axis of size ${n}`);
      out[k] = at * a.strides[ax];
    }
    return out;
  });
  const where = fancy[0][0];
  const before = shape.slice(0, where), after = shape.slice(where);
  const full = [...before, ...common, ...after];
  const m = size_of(common);
  const sums = new Float64Array(m);
  for (const l of lists) for (let k = 0; k < m; k++) sums[k] += l[k];
  const places = new Float64Array(size_of(full));
  let k = 0;
  each(before.length ? before : [1], [before.length ? strides.slice(0, where) : [0]], [offset], (p) => {
    for (let j = 0; j < m; j++) {
      if (!after.length) places[k++] = p + sums[j];
      else each(after, [strides.slice(where)], [p + sums[j]], (q) => { places[k++] = q; });
    }
  });
  return { shape: full, places };
}
function joint(a, b) {
  const n = Math.max(a.length, b.length), out = [];
  for (let k = 0; k < n; k++) {
    const x = a[a.length - n + k] ?? 1, y = b[b.length - n + k] ?? 1;
    if (x !== y && x !== 1 && y !== 1) $.raise("ValueError", `operands could not be broadcast together with shapes (${a}) (${b})`);
    out.push(x === 1 ? y : x);
  }
  return out;
}
function broadcast(a, shape) {
  if (a.shape.length === shape.length && a.shape.every((n, k) => n === shape[k])) return a;
  const lead = shape.length - a.shape.length;
  const strides = shape.map((n, k) => {
    const m = k < lead ? 1 : a.shape[k - lead];
    if (m !== n && m !== 1) $.raise("ValueError", `could not broadcast (${a.shape}) into (${shape})`);
    return m === n && k >= lead ? a.strides[k - lead] : 0;
  });
  return new NDArray(a.data, shape, a.type, strides, a.offset);
}
export const arrayOf = (values, dtype = "f") => new NDArray(dtype === "U" ? Array.from(values) : dtype === "b" ? Uint8Array.from(values, Number) : values instanceof Float64Array ? values : new Float64Array(values), [values.length], dtype);
const type_of = (v) => (typeof v === "boolean" ? "b" : typeof v === "string" ? "U" : "?");
const dtype_of = (t) => (t === undefined || t === null ? null : t === $.b.bool || t === np.bool_ || t === "bool" ? "b" : t === $.b.int || t === np.int64 || t === np.int8 || t === np.uint32 || t === np.int32 || t === "int64" ? "i" : t === $.b.str || t === np.str_ || (typeof t === "string" && t.startsWith("U")) ? "U" : typeof t === "object" && t.type ? t.type : "f");
function cast(a, t) {
  const d = dtype_of(t);
  if (d === a.type) return a.fresh();
  const v = a.values();
  const o = store(d, v.length);
  if (d === "U") for (let k = 0; k < o.length; k++) o[k] = $.b.str(v[k]);
  else if (d === "b") for (let k = 0; k < o.length; k++) o[k] = v[k] ? 1 : 0;
  else if (d === "i") for (let k = 0; k < o.length; k++) o[k] = Math.trunc(v[k]);
  else o.set(v);
  return new NDArray(o, a.shape, d);
}
/** Anything as an array; numbers that are all whole within lists count as integers only where that is asked for. */
export function array(v, t) {
  const want = dtype_of(t);
  if (v instanceof NDArray) return want === null || want === v.type ? v : cast(v, t);
  if (typeof v === "number" || typeof v === "boolean" || typeof v === "string") { const d = want ?? (typeof v === "number" ? "f" : type_of(v)); const s = store(d, 1); s[0] = d === "U" ? $.b.str(v) : v; return new NDArray(s, [], d); }
  if (v?.__array__) return array(v.__array__(), t);
  if (v === null || v === undefined) { if (want === "f" || want === null) return new NDArray(Float64Array.of(NaN), [], "f"); }
  const list = Array.isArray(v) ? v : [...$.it(v)];
  if (list.some((x) => x instanceof NDArray || Array.isArray(x) || x instanceof Range)) {
    const rows = list.map((x) => array(x, t));
    if (rows.some((r) => r.shape.length !== rows[0].shape.length || r.shape.some((n, k) => n !== rows[0].shape[k]))) $.raise("ValueError", "setting an array element with a sequence: inhomogeneous shape");
    return np.stack(rows, new Named({ axis: 0 }));
  }
  const d = want ?? (list.length && list.every((x) => typeof x === "boolean") ? "b" : list.length && list.some((x) => typeof x === "string") ? "U" : "f");
  const data = store(d, list.length);
  for (let k = 0; k < list.length; k++) data[k] = d === "U" ? $.b.str(list[k]) : d === "f" ? (typeof list[k] === "number" ? list[k] : $.b.float(list[k])) : d === "i" ? Math.trunc(list[k]) : $.t(list[k]) ? 1 : 0;
  return new NDArray(data, [list.length], d);
}

// ---- element by element
const F = {
  add: (a, b) => a + b, sub: (a, b) => a - b, mul: (a, b) => a * b, div: (a, b) => a / b, fdiv: (a, b) => Math.floor(a / b),
  mod: (a, b) => { const r = a % b; return r !== 0 && r < 0 !== b < 0 ? r + b : r; }, pow: (a, b) => (b === 2 ? a * a : b === 0.5 ? Math.sqrt(a) : a ** b),
  band: (a, b) => a & b, bor: (a, b) => a | b, bxor: (a, b) => a ^ b, shl: (a, b) => a * 2 ** b, shr: (a, b) => Math.floor(a / 2 ** b),
  eq: (a, b) => (a === b ? 1 : 0), ne: (a, b) => (a !== b ? 1 : 0), lt: (a, b) => (a < b ? 1 : 0), le: (a, b) => (a <= b ? 1 : 0), gt: (a, b) => (a > b ? 1 : 0), ge: (a, b) => (a >= b ? 1 : 0),
  max: (a, b) => (a !== a ? a : b !== b ? b : a > b ? a : b), min: (a, b) => (a !== a ? a : b !== b ? b : a < b ? a : b), hypot: Math.hypot,
  land: (a, b) => (a && b ? 1 : 0), lor: (a, b) => (a || b ? 1 : 0),
};
// One loop a function, so that each is compiled for its own.
function wrap(f) {
  return {
    aa: (x, y, o) => { for (let k = 0; k < o.length; k++) o[k] = f(x[k], y[k]); },
    as: (x, y, o) => { for (let k = 0; k < o.length; k++) o[k] = f(x[k], y); },
    sa: (x, y, o) => { for (let k = 0; k < o.length; k++) o[k] = f(x, y[k]); },
  };
}
const LOOPS = Object.fromEntries(Object.entries(F).map(([n, f]) => [n, wrap(f)]));
const COMPARES = new Set(["eq", "ne", "lt", "le", "gt", "ge", "land", "lor"]);
const own = (name, l) => Object.assign(LOOPS[name], l);
own("add", { aa: (x, y, o) => { for (let k = 0; k < o.length; k++) o[k] = x[k] + y[k]; }, sa: (x, y, o) => { for (let k = 0; k < o.length; k++) o[k] = x + y[k]; } });
own("sub", { aa: (x, y, o) => { for (let k = 0; k < o.length; k++) o[k] = x[k] - y[k]; }, as: (x, y, o) => { for (let k = 0; k < o.length; k++) o[k] = x[k] - y; } });
own("mul", { aa: (x, y, o) => { for (let k = 0; k < o.length; k++) o[k] = x[k] * y[k]; }, as: (x, y, o) => { for (let k = 0; k < o.length; k++) o[k] = x[k] * y; } });
own("div", { aa: (x, y, o) => { for (let k = 0; k < o.length; k++) o[k] = x[k] / y[k]; }, as: (x, y, o) => { for (let k = 0; k < o.length; k++) o[k] = x[k] / y; } });
own("lt", { as: (x, y, o) => { for (let k = 0; k < o.length; k++) o[k] = x[k] < y ? 1 : 0; } });
own("le", { aa: (x, y, o) => { for (let k = 0; k < o.length; k++) o[k] = x[k] <= y[k] ? 1 : 0; }, as: (x, y, o) => { for (let k = 0; k < o.length; k++) o[k] = x[k] <= y ? 1 : 0; } });
own("gt", { as: (x, y, o) => { for (let k = 0; k < o.length; k++) o[k] = x[k] > y ? 1 : 0; } });
own("eq", { as: (x, y, o) => { for (let k = 0; k < o.length; k++) o[k] = x[k] === y ? 1 : 0; } });
own("band", { aa: (x, y, o) => { for (let k = 0; k < o.length; k++) o[k] = x[k] & y[k]; } });
own("ge", { as: (x, y, o) => { for (let k = 0; k < o.length; k++) o[k] = x[k] >= y ? 1 : 0; } });
own("pow", { as: (x, y, o) => { if (y === 2) for (let k = 0; k < o.length; k++) o[k] = x[k] * x[k]; else for (let k = 0; k < o.length; k++) o[k] = F.pow(x[k], y); } });
own("mul", { sa: (x, y, o) => LOOPS.mul.as(y, x, o) });
function result_type(name, a, b) {
  if (COMPARES.has(name)) return "b";
  if ((name === "band" || name === "bor" || name === "bxor") && a === "b" && b === "b") return "b";
  if ((name === "max" || name === "min") && a === "b" && b === "b") return "b";
  if (name === "div") return "f";
  return a === "f" || b === "f" ? "f" : "i";
}
const scalar_type = (v) => (typeof v === "boolean" ? "b" : typeof v === "string" ? "U" : Number.isInteger(v) ? "i" : "f");
const calc = (name, a, b, out) => {
  if (name === "mm") return np.matmul(a, b);
  if (name === "pow" && b?.tens) return arrayOf(b.tens);
  const [sa, sb] = [!(a instanceof NDArray) && !Array.isArray(a), !(b instanceof NDArray) && !Array.isArray(b)];
  if ((a === null || b === null) && (name === "eq" || name === "ne")) return name === "ne";
  if (!sa && !(a instanceof NDArray)) a = array(a);
  if (!sb && !(b instanceof NDArray)) b = array(b);
  if (sa && typeof a === "object") a = array(a);
  if (sb && typeof b === "object") b = array(b);
  const ta = a instanceof NDArray ? a.type : scalar_type(a), tb = b instanceof NDArray ? b.type : scalar_type(b);
  let type = result_type(name, ta, tb);
  if (type === "i" && name !== "band" && ((a instanceof NDArray && a.type === "f") || (b instanceof NDArray && b.type === "f"))) type = "f";
  if (!(b instanceof NDArray)) {
    if (typeof b === "boolean") b = Number(b);
    const o = out ?? store(type, a.size);
    LOOPS[name].as(a.values(), b, o);
    return shaped(o, a.shape, type);
  }
  if (!(a instanceof NDArray)) {
    if (typeof a === "boolean") a = Number(a);
    const o = out ?? store(type, b.size);
    LOOPS[name].sa(a, b.values(), o);
    return shaped(o, b.shape, type);
  }
  const shape = joint(a.shape, b.shape);
  const o = out ?? store(type, size_of(shape));
  if (a.size === o.length && b.size === 1 && a.ndim >= b.ndim) LOOPS[name].as(a.values(), b.values()[0], o);
  else if (b.size === o.length && a.size === 1 && b.ndim >= a.ndim) LOOPS[name].sa(a.values()[0], b.values(), o);
  else if (a.size === o.length && b.size === o.length) LOOPS[name].aa(a.values(), b.values(), o);
  else if (rowwise(name, a, b, shape, o)) { /* done */ }
  else {
    const f = F[name], x = broadcast(a, shape), y = broadcast(b, shape);
    const v = x.data, w = y.data;
    let k = 0;
    if (shape.length === 2) for (let i = 0; i < shape[0]; i++) for (let j = 0, p = x.offset + i * x.strides[0], q = y.offset + i * y.strides[0]; j < shape[1]; j++, p += x.strides[1], q += y.strides[1]) o[k++] = f(v[p], w[q]);
    else each(shape, [x.strides, y.strides], [x.offset, y.offset], (p, q) => { o[k++] = f(v[p], w[q]); });
  }
  return shaped(o, shape, type);
};
/* (n, m) with (n, 1), (1, m) or (m,), which whole tables of columns are scaled and centred by. */
function rowwise(name, a, b, shape, o) {
  if (shape.length !== 2) return false;
  const [n, m] = shape, full = n * m;
  const [big, small, turned] = a.size === full ? [a, b, false] : b.size === full ? [b, a, true] : [null, null, false];
  if (!big || big.ndim !== 2) return false;
  const v = big.values(), s = small.values(), f = F[name];
  const column = small.ndim === 2 && small.shape[0] === n && small.shape[1] === 1;
  if (!column && s.length !== m) return false;
  if (name === "mul" || name === "sub" && !turned) {
    const times = name === "mul";
    for (let i = 0, k = 0; i < n; i++) { const w = column ? s[i] : 0; for (let j = 0; j < m; j++, k++) { const q = column ? w : s[j]; o[k] = times ? v[k] * q : v[k] - q; } }
  } else for (let i = 0, k = 0; i < n; i++) for (let j = 0; j < m; j++, k++) { const q = column ? s[i] : s[j]; o[k] = turned ? f(q, v[k]) : f(v[k], q); }
  return true;
}
const shaped = (o, shape, type) => (shape.length ? new NDArray(o, shape, type) : type === "b" ? o[0] !== 0 : o[0]);
const unary = (f, type) => (a, named) => {
  if (typeof a === "number" || typeof a === "boolean") return type === "b" ? f(Number(a)) !== 0 : f(Number(a));
  a = array(a);
  const v = a.values(), o = store(type ?? "f", v.length);
  for (let k = 0; k < v.length; k++) o[k] = f(v[k]);
  return into(shaped(o, a.shape, type ?? "f"), named);
};
const into = (made, named) => { const out = named instanceof Named ? named.values.out : named; if (out instanceof NDArray) { out.put($.slice(null, null, null), made); return out; } return made; };
const even = (x) => { const f = Math.floor(x), r = x - f; return r < 0.5 ? f : r > 0.5 ? f + 1 : f % 2 === 0 ? f : f + 1; };
nd.ops = {
  binary: (name, a, b) => calc(name, a, b),
  inplace: (name, a, b) => {
    const made = calc(name, a, b);
    const all = a.ndim ? Array.from({ length: a.ndim }, () => $.slice(null, null, null)) : [];
    if (a.dense() && made instanceof NDArray && made.size === a.size) a.values().set(made.values());
    else a.put($.tup(...all), made);
    return a;
  },
  unary: (name, a) => (name === "neg" ? keep(a, (v) => -v) : name === "abs" ? np.abs(a) : a.type === "b" ? calc("eq", a, 0) : keep(a, (v) => ~v)),
};
const keep = (a, f) => { const v = a.values(), o = store(a.type === "b" ? "i" : a.type, v.length); for (let k = 0; k < v.length; k++) o[k] = f(v[k]); return shaped(o, a.shape, a.type === "b" ? "i" : a.type); };

// ---- along axes
function told(args, names) {
  const named = args.length && args[args.length - 1] instanceof Named ? args.pop().values : {};
  const found = { ...named };
  names.forEach((name, k) => { if (args[k] !== undefined) found[name] = args[k]; });
  return found;
}
/** Pairwise sums: rounding grows with the logarithm, as numpy's does. */
function total(v, from, n, step) {
  if (n < 8) { let s = 0; for (let k = 0, a = from; k < n; k++, a += step) s += v[a]; return s; }
  if (n <= 128) {
    let a = 0, b = 0, c = 0, d = 0, e = 0, f = 0, g = 0, h = 0, k = 0, p = from;
    for (; k < n - (n % 8); k += 8, p += 8 * step) {
      a += v[p]; b += v[p + step]; c += v[p + 2 * step]; d += v[p + 3 * step];
      e += v[p + 4 * step]; f += v[p + 5 * step]; g += v[p + 6 * step]; h += v[p + 7 * step];
    }
    let s = a + b + (c + d) + (e + f + (g + h));
    for (; k < n; k++, p += step) s += v[p];
    return s;
  }
  let half = Math.floor(n / 2);
  half -= half % 8;
  return total(v, from, half, step) + total(v, from + half * step, n - half, step);
}
const norm_axis = (axis, n) => (axis < 0 ? axis + n : axis);
/** Reduce by f(values, from, count, step) over all or along an axis. */
function reduce(a, o, f, type) {
  a = array(a);
  if (o.axis === undefined || o.axis === null) { const v = a.values(); const r = f(v, 0, v.length, 1); return type === "b" ? !!r : r; }
  if (Array.isArray(o.axis)) { if (o.axis.length === a.ndim) return reduce(a, { ...o, axis: null }, f, type); $.raise("ValueError", "axes"); }
  if (a.ndim === 2 && norm_axis(o.axis, 2) === 0 && (f === total || f === mean) && !o.keepdims && !o.out) {
    const [n, m] = a.shape, v = a.values(), s = new Float64Array(m);
    for (let i = 0, k = 0; i < n; i++) for (let j = 0; j < m; j++, k++) s[j] += v[k];
    if (f === mean) for (let j = 0; j < m; j++) s[j] /= n;
    return new NDArray(s, [m], "f");
  }
  const axis = norm_axis(o.axis, a.ndim), shape = a.shape.filter((_n, k) => k !== axis), v = a.values(), s = steps_of(a.shape);
  const out = store(type ?? "f", size_of(shape));
  let k = 0;
  each(shape.length ? shape : [1], [shape.length ? s.filter((_n, j) => j !== axis) : [0]], [0], (p) => { out[k++] = f(v, p, a.shape[axis], s[axis]); });
  const made = o.keepdims ? new NDArray(out, a.shape.map((n, j) => (j === axis ? 1 : n)), type ?? "f") : shaped(out, shape, type ?? "f");
  return o.out instanceof NDArray ? into(made, o.out) : made;
}
const along = (f, type) => (a, ...args) => reduce(a, told(args, ["axis", "dtype", "out"]), f, type);
const extreme = (sign) => (a, ...args) => {
  const o = told(args, ["axis", "out"]);
  return reduce(a, o, (v, p, n, s) => {
    if (n === 0 && o.initial === undefined) $.raise("ValueError", "zero-size array to reduction operation which has no identity");
    return furthest(v instanceof Uint8Array ? new Float64Array(v) : v, p, n, s, sign, o.initial ?? v[p]);
  });
};
function furthest(v, p, n, s, sign, best) {
  if (sign > 0) for (let k = 0; k < n; k++, p += s) { const w = v[p]; if (w > best) best = w; else if (w !== w) return NaN; }
  else for (let k = 0; k < n; k++, p += s) { const w = v[p]; if (w < best) best = w; else if (w !== w) return NaN; }
  return best;
}
const counted = (v, p, n, s) => { let c = 0; for (let k = 0; k < n; k++, p += s) if (v[p]) c++; return c; };
const mean = (v, p, n, s) => (v instanceof Uint8Array ? counted : total)(v, p, n, s) / n;
const variance = (ddof) => (v, p, n, s) => { const m = mean(v, p, n, s); const d = new Float64Array(n); for (let k = 0; k < n; k++) d[k] = (v[p + k * s] - m) ** 2; return total(d, 0, n, 1) / (n - ddof); };
const sorted = (v) => (Array.isArray(v) ? [...v].sort() : new Float64Array(v).sort());
function quantile(v, p, n, s, q) {
  const d = new Float64Array(n);
  for (let k = 0; k < n; k++) { d[k] = v[p + k * s]; if (d[k] !== d[k]) return NaN; }
  d.sort();
  return at_quantile(d, q);
}
/* The value that order puts at h; all before it are no larger then (Hoare's way). */
function chosen(d, h) {
  for (let low = 0, high = d.length - 1, g = 0; low < high;) {
    g = (g + 0.618) % 1; // not the middle one, which is the largest of a triangle
    const pivot = d[low + Math.floor(g * (high - low + 1))];
    let i = low, j = high;
    while (i <= j) {
      while (d[i] < pivot) i++;
      while (d[j] > pivot) j--;
      if (i <= j) { const t = d[i]; d[i++] = d[j]; d[j--] = t; }
    }
    if (h <= j) high = j;
    else if (h >= i) low = i;
    else break;
  }
  return d[h];
}
function at_quantile(d, q) {
  if (!d.length) return NaN;
  const at = q * (d.length - 1), low = Math.floor(at), t = at - low;
  const a = d[low], b = d[Math.min(low + 1, d.length - 1)], diff = b - a;
  return t >= 0.5 ? b - diff * (1 - t) : a + diff * t;
}
function quantiles(a, q, o) {
  if (!(q instanceof NDArray) && !Array.isArray(q)) return reduce(a, o, (v, p, n, s) => quantile(v, p, n, s, q));
  const list = array(q).tolist();
  if (o.axis === undefined || o.axis === null) { const d = new Float64Array(array(a).values()); d.sort(); if (d.length && d[d.length - 1] !== d[d.length - 1]) return arrayOf(list.map(() => NaN)); return arrayOf(list.map((each) => at_quantile(d, each))); }
  return np.stack(list.map((each) => reduce(a, o, (v, p, n, s) => quantile(v, p, n, s, each))));
}

const dims = (shape) => (typeof shape === "number" ? [shape] : [...shape]);
const filled = (value) => (shape, ...args) => {
  const o = told(args, ["dtype"]);
  const d = dtype_of(o.dtype) ?? "f";
  const sh = dims(shape), s = store(d, size_of(sh));
  if (value) s.fill(value);
  return new NDArray(s, sh, d);
};
export const np = {
  NDArray, ndarray: NDArray, inf: Infinity, nan: NaN, pi: Math.PI, newaxis: null,
  float64: Object.assign((v) => $.b.float(v), { $inst: (v) => typeof v === "number", __name__: "float64" }),
  int64: Object.assign((v) => $.b.int(v), { $inst: (v) => Number.isInteger(v), __name__: "int64" }),
  int32: Object.assign((v) => $.b.int(v), { __name__: "int32" }), int8: Object.assign((v) => $.b.int(v), { __name__: "int8" }), uint32: Object.assign((v) => $.b.int(v), { __name__: "uint32" }),
  bool_: Object.assign((v) => $.t(v), { $inst: (v) => typeof v === "boolean", __name__: "bool_" }), str_: Object.assign((v) => $.b.str(v), { $inst: (v) => typeof v === "string", __name__: "str_" }),
  integer: { $inst: () => false }, floating: { $inst: () => false }, number: { $inst: () => false }, generic: { $inst: () => false },
  ma: { MaskedArray: { $inst: () => false }, filled: (v) => v, isMaskedArray: () => false },
  errstate: () => ({ __enter__: () => null, __exit__: () => false }),
  array: (v, ...a) => { const o = told(a, ["dtype"]); const made = array(v, o.dtype); return made === v || made.data === v?.data ? made.fresh() : made; },
  asarray: (v, ...a) => array(v, told(a, ["dtype"]).dtype), ascontiguousarray: (v, ...a) => { const made = array(v, told(a, ["dtype"]).dtype); return made.dense() ? (made.ndim ? made : made.reshape(1)) : made.fresh(); },
  zeros: filled(0), ones: filled(1), empty: filled(0),
  full: (shape, v, ...a) => { const o = told(a, ["dtype"]); const d = dtype_of(o.dtype) ?? (typeof v === "boolean" ? "b" : "f"); const sh = dims(shape); return new NDArray(store(d, size_of(sh)).fill(v), sh, d); },
  zeros_like: (a, ...r) => np.zeros(array(a).shape, new Named({ dtype: told(r, ["dtype"]).dtype ?? { type: array(a).type } })), ones_like: (a) => np.ones(array(a).shape), full_like: (a, v) => np.full(array(a).shape, v), empty_like: (a) => np.zeros(array(a).shape),
  arange: (...args) => { const o = told(args, []); let [a, b, c] = args; if (b === undefined || b === null) [a, b] = [0, a]; c ??= 1; const n = Math.max(0, Math.ceil((b - a) / c)); const v = new Float64Array(n); for (let k = 0; k < n; k++) v[k] = a + k * c; return new NDArray(v, [n], dtype_of(o.dtype) ?? ([a, b, c].every(Number.isInteger) ? "i" : "f")); },
  linspace: (a, b, n = 50, ...r) => { const end = told(r, ["endpoint"]).endpoint ?? true; const v = new Float64Array(n), step = (b - a) / (end ? n - 1 : n); for (let k = 0; k < n; k++) v[k] = a + k * step; if (end && n > 1) v[n - 1] = b; return arrayOf(v); },
  geomspace: (a, b, n = 50) => { if (a === 1 && b === 1e-4 && n === nd.ladder?.length) return arrayOf(nd.ladder); const l = Math.log10(a), h = Math.log10(b), v = new Float64Array(n); for (let k = 0; k < n; k++) v[k] = 10 ** (l + (k * (h - l)) / (n - 1)); v[0] = a; v[n - 1] = b; return arrayOf(v); },
  eye: (n, ...r) => { const o = told(r, ["M", "k"]); const m = o.M ?? n, a = np.zeros($.tup(n, m)); for (let k = 0; k < n; k++) { const j = k + (o.k ?? 0); if (j >= 0 && j < m) a.data[k * m + j] = 1; } return a; },
  identity: (n) => np.eye(n),
  diag: (a, k = 0) => { a = array(a); if (a.ndim === 1) { const m = np.zeros($.tup(a.size, a.size)), v = a.values(); for (let j = 0; j < v.length; j++) m.data[j * a.size + j] = v[j]; return m; } const n = Math.min(...a.shape), v = a.values(), o = new Float64Array(n); for (let j = 0; j < n; j++) o[j] = v[j * a.shape[1] + j + k]; return arrayOf(o); },
  tril: (a, k = 0) => triangular(a, (i, j) => j - i <= k), triu: (a, k = 0) => triangular(a, (i, j) => j - i >= k), trace: (a) => np.sum(np.diag(a)),
  outer: (a, b) => { a = array(a).ravel(); b = array(b).ravel(); return calc("mul", a.reshape(-1, 1), b); },
  copy: (a) => array(a).fresh(), shape: (a) => array(a).shape, ndim: (a) => array(a).ndim, size: (a) => array(a).size, isscalar: (v) => typeof v === "number",
  reshape: (a, s) => array(a).reshape(s), ravel: (a) => array(a).ravel(), transpose: (a) => array(a).T, squeeze: (a) => { a = array(a); return a.reshape($.tup(...a.shape.filter((n) => n !== 1))); }, atleast_1d: (a) => { a = array(a); return a.ndim ? a : a.reshape(1); },
  broadcast_to: (a, s) => broadcast(array(a), dims(s)),
  concatenate: (parts, ...r) => {
    const o = told(r, ["axis"]); const list = [...$.it(parts)].map((p) => array(p)); const axis = norm_axis(o.axis ?? 0, list[0].ndim);
    if (!list.length) $.raise("ValueError", "need at least one array to concatenate");
    const whole = list.filter((p) => p.size || p.type !== "f"); const kinds = new Set((whole.length ? whole : list).map((p) => p.type));
    const type = kinds.has("U") ? "U" : kinds.has("f") ? "f" : kinds.size === 1 ? [...kinds][0] : "i";
    const shape = [...list[0].shape];
    for (const p of list) if (p.ndim !== shape.length || p.shape.some((m, k) => k !== axis && m !== shape[k])) $.raise("ValueError", `all the input array dimensions must match (${shape}) (${p.shape})`);
    shape[axis] = list.reduce((n, p) => n + p.shape[axis], 0);
    const out = new NDArray(store(type, size_of(shape)), shape, type);
    if (axis === 0) { let k = 0; for (const p of list) { const v = p.values(); if (type === "U") for (let j = 0; j < v.length; j++) out.data[k + j] = v[j]; else out.data.set(v, k); k += v.length; } return out; }
    if (axis === 1 && shape.length === 2 && type !== "U") {
      const [n, m] = shape;
      let at = 0;
      for (const p of list) {
        const w = p.shape[1], [s0, s1] = p.strides, from = p.data;
        for (let i = 0, q = at, r = p.offset; i < n; i++, q += m, r += s0) for (let j = 0, z = r; j < w; j++, z += s1) out.data[q + j] = from[z];
        at += w;
      }
      return out;
    }
    let k = 0;
    for (const p of list) { const n = p.shape[axis]; out.put($.tup(...shape.map((_m, j) => (j === axis ? new Slice(k, k + n, null) : new Slice(null, null, null)))), p); k += n; }
    return out;
  },
  vstack: (parts) => np.concatenate([...$.it(parts)].map((p) => { p = array(p); return p.ndim === 1 ? p.reshape(1, p.size) : p; })),
  hstack: (parts) => { const l = [...$.it(parts)].map((p) => array(p)); return np.concatenate(l, new Named({ axis: l[0].ndim === 1 ? 0 : 1 })); },
  column_stack: (parts) => np.concatenate([...$.it(parts)].map((p) => { p = array(p); return p.ndim === 1 ? p.reshape(p.size, 1) : p; }), new Named({ axis: 1 })),
  stack: (parts, ...r) => { const axis = told(r, ["axis"]).axis ?? 0; const l = [...$.it(parts)].map((p) => array(p)); const n = l[0].ndim + 1, at = norm_axis(axis, n); return np.concatenate(l.map((p) => p.reshape($.tup(...p.shape.slice(0, at), 1, ...p.shape.slice(at)))), new Named({ axis: at })); },
  split: (a, at, ...r) => { const axis = told(r, ["axis"]).axis ?? 0; a = array(a); const n = a.shape[norm_axis(axis, a.ndim)]; const ends = typeof at === "number" ? Array.from({ length: at - 1 }, (_, k) => ((k + 1) * n) / at) : [...$.it(at)]; const edges = [0, ...ends.map((e) => (e < 0 ? e + n : e)), n]; return edges.slice(1).map((e, k) => a.get($.tup(...Array.from({ length: norm_axis(axis, a.ndim) }, () => new Slice(null, null, null)), new Slice(edges[k], e, null)))); },
  array_split: (a, m) => { const n = a.__len__ ? a.__len__() : a.length, base = Math.floor(n / m), more = n % m; let k = 0; return Array.from({ length: m }, (_, j) => { const s = base + (j < more ? 1 : 0); k += s; return $.gi(a, new Slice(k - s, k, null)); }); },
  append: (a, v) => np.concatenate([array(a).ravel(), array(v).ravel()]), insert: (a, k, v) => { const l = array(a).tolist(); l.splice(k, 0, v); return array(l); },
  delete: (a, at, ...r) => { a = array(a); const axis = told(r, ["axis"]).axis ?? 0; if (at instanceof Slice) { const [lo, hi, st] = bounds(at, a.shape[axis]); at = np.arange(lo, hi, st); } const n = a.shape[axis], drop = new Set(typeof at === "number" ? [at < 0 ? at + n : at] : array(at).type === "b" ? np.flatnonzero(at).tolist() : array(at).tolist().map((k) => (k < 0 ? k + n : k))); const kept = []; for (let k = 0; k < n; k++) if (!drop.has(k)) kept.push(k); const idx = arrayOf(kept, "i"); return a.get(axis === 0 ? idx : $.tup(new Slice(null, null, null), idx)); },
  repeat: (a, n, ...r) => { a = array(a); const o = told(r, ["axis"]); const idx = []; const v = n instanceof NDArray || Array.isArray(n) ? array(n).tolist() : null; const len = o.axis === undefined ? a.size : a.shape[o.axis]; for (let k = 0; k < len; k++) for (let j = 0; j < (v ? v[k] : n); j++) idx.push(k); const at = arrayOf(idx, "i"); return o.axis === 1 ? a.get($.tup(new Slice(null, null, null), at)) : (o.axis === 0 ? a : a.ravel()).get(at); },
  tile: (a, n) => { a = array(a); return np.concatenate(Array.from({ length: n }, () => a)); }, take: (a, i, ...r) => { const axis = told(r, ["axis"]).axis ?? 0; return array(a).get(axis ? $.tup(new Slice(null, null, null), i) : i); },
  ix_: (...l) => { const v = l.map((p) => { p = array(p); return p.type === "b" ? np.flatnonzero(p) : p; }); return $.tup(v[0].reshape(v[0].size, 1), v[1].reshape(1, v[1].size)); },
  flatnonzero: (a) => { const v = array(a).values(); let n = 0; for (let k = 0; k < v.length; k++) if (v[k]) n++; const o = new Float64Array(n); for (let k = 0, j = 0; k < v.length; k++) if (v[k]) o[j++] = k; return new NDArray(o, [n], "i"); },
  nonzero: (a) => $.tup(np.flatnonzero(a)),
  where: (c, a, b) => { c = array(c); if (a === undefined) return np.nonzero(c); a = array(a); b = array(b); const shape = joint(joint(c.shape, a.shape), b.shape), x = broadcast(c, shape).values(), y = broadcast(a, shape).values(), z = broadcast(b, shape).values(); const type = a.type === b.type ? a.type : a.type === "U" || b.type === "U" ? "U" : a.type === "f" || b.type === "f" ? "f" : "i"; const o = store(type, x.length); for (let k = 0; k < o.length; k++) o[k] = x[k] ? y[k] : z[k]; return shaped(o, shape, type); },
  clip: (a, lo, hi, ...r) => { let m = lo === null || lo === undefined ? array(a) : calc("max", array(a), lo); if (hi !== null && hi !== undefined) m = calc("min", m, hi); const o = told(r, ["out"]); return o.out instanceof NDArray ? into(m, o.out) : m instanceof NDArray && m.ndim === 0 ? m.item() : m; },
  add: wrapped("add"), subtract: wrapped("sub"), multiply: wrapped("mul"), divide: wrapped("div"), maximum: wrapped("max"), minimum: wrapped("min"), hypot: wrapped("hypot"), power: wrapped("pow"),
  logical_and: wrapped("land"), logical_or: wrapped("lor"), logical_not: (a) => nd.ops.unary("inv", cast(array(a), $.b.bool)), equal: wrapped("eq"), greater: wrapped("gt"), less: wrapped("lt"), mod: wrapped("mod"),
  abs: (a) => { if (typeof a === "number") return Math.abs(a); a = array(a); if (a.type !== "f") return keep(a, Math.abs); const v = a.values(), o = new Float64Array(v.length); for (let k = 0; k < o.length; k++) o[k] = Math.abs(v[k]); return shaped(o, a.shape, "f"); }, negative: (a) => $.neg(a),
  sqrt: unary(Math.sqrt), exp: unary(Math.exp), log: unary(Math.log), log1p: unary(Math.log1p), log10: unary(Math.log10), log2: unary(Math.log2), expm1: unary(Math.expm1), sin: unary(Math.sin), cos: unary(Math.cos), tanh: unary(Math.tanh), floor: unary(Math.floor), ceil: unary(Math.ceil), trunc: unary(Math.trunc), square: unary((v) => v * v),
  sign: unary((v) => (v > 0 ? 1 : v < 0 ? -1 : v)), rint: unary(even), isfinite: unary((v) => (Number.isFinite(v) ? 1 : 0), "b"), isnan: unary((v) => (v !== v ? 1 : 0), "b"), isinf: unary((v) => (v === Infinity || v === -Infinity ? 1 : 0), "b"),
  round: (a, d = 0, ...r) => { if (d instanceof Named) d = d.values.decimals ?? 0; return unary(d === 0 ? even : (v) => even(v * 10 ** d) / 10 ** d)(a, ...r); },
  modf: (a) => { const w = np.trunc(a); return $.tup(calc("sub", array(a), w), w); }, spacing: (v) => { const s = Math.abs(v); return 2 ** (Math.floor(Math.log2(s)) - 52); }, nan_to_num: unary((v) => (v !== v ? 0 : v)),
  sum: (a, ...r) => { const o = told(r, ["axis"]); return reduce(a, o, a.type === "b" ? counted : total); }, prod: along((v, p, n, s) => { let q = 1; for (let k = 0; k < n; k++, p += s) q *= v[p]; return q; }),
  mean: along(mean), nanmean: (a) => np.mean(array(a).get(calc("eq", array(a), array(a)))), max: extreme(1), min: extreme(-1), amax: extreme(1), amin: extreme(-1), ptp: (a, ...r) => { const o = told(r, ["axis"]); return $.sub(np.max(a, new Named(o)), np.min(a, new Named(o))); },
  nanmax: (a) => np.max(array(a).get(calc("eq", array(a), array(a)))), nanmin: (a) => np.min(array(a).get(calc("eq", array(a), array(a)))),
  std: (a, ...r) => { const o = told(r, ["axis"]); return np.sqrt(reduce(a, o, variance(o.ddof ?? 0))); }, var: (a, ...r) => { const o = told(r, ["axis"]); return reduce(a, o, variance(o.ddof ?? 0)); },
  any: along((v, p, n, s) => { for (let k = 0; k < n; k++, p += s) if (v[p]) return 1; return 0; }, "b"), all: along((v, p, n, s) => { for (let k = 0; k < n; k++, p += s) if (!v[p]) return 0; return 1; }, "b"),
  count_nonzero: along(counted),
  argmax: along((v, p, n, s) => { let b = 0; for (let k = 1; k < n; k++) if (v[p + k * s] > v[p + b * s] || (v[p + k * s] !== v[p + k * s] && v[p + b * s] === v[p + b * s])) b = k; return b; }, "i"), argmin: along((v, p, n, s) => { let b = 0; for (let k = 1; k < n; k++) if (v[p + k * s] < v[p + b * s]) b = k; return b; }, "i"),
  median: along((v, p, n, s) => {
    const d = new Float64Array(n);
    for (let k = 0; k < n; k++) { d[k] = v[p + k * s]; if (d[k] !== d[k]) return NaN; }
    const h = n >> 1, high = chosen(d, h);
    return !n ? NaN : n % 2 ? high : (furthest(d, 0, h, 1, 1, -Infinity) + high) / 2;
  }),
  nanmedian: (a, ...r) => { const o = told(r, ["axis"]); return reduce(a, o, (v, p, n, s) => { const d = []; for (let k = 0; k < n; k++) if (v[p + k * s] === v[p + k * s]) d.push(v[p + k * s]); if (!d.length) return NaN; d.sort((x, y) => x - y); const h = d.length >> 1; return d.length % 2 ? d[h] : (d[h - 1] + d[h]) / 2; }); },
  quantile: (a, q, ...r) => quantiles(a, q, told(r, ["axis"])), percentile: (a, q, ...r) => quantiles(a, q instanceof NDArray || Array.isArray(q) ? calc("div", array(q), 100) : q / 100, told(r, ["axis"])),
  average: (a, ...r) => { const o = told(r, ["axis", "weights"]); if (o.weights === undefined || o.weights === null) return np.mean(a, new Named({ axis: o.axis })); a = array(a); const w = array(o.weights); const ww = a.ndim > 1 && w.ndim === 1 ? w.reshape(-1, 1) : w; return $.div(np.sum(calc("mul", a, ww), new Named({ axis: o.axis })), np.sum(w)); },
  cumsum: (a, ...r) => { const o = told(r, ["axis"]); a = array(a); if (a.ndim < 2 || o.axis === undefined) { const v = a.values(), s = new Float64Array(v.length); let t = 0; for (let k = 0; k < v.length; k++) s[k] = t += v[k]; return new NDArray(s, [v.length], a.type === "f" ? "f" : "i"); } const m = new NDArray(new Float64Array(a.values()), a.shape, "f"); const [n, w] = a.shape; for (let i = 0; i < n; i++) for (let j = 0; j < w; j++) { if (norm_axis(o.axis, 2) === 0) { if (i) m.data[i * w + j] += m.data[(i - 1) * w + j]; } else if (j) m.data[i * w + j] += m.data[i * w + j - 1]; } return m; },
  diff: (a, ...r) => { const o = told(r, ["n", "axis"]); a = array(a); for (const [name, at] of [["prepend", 0], ["append", 1]]) if (o[name] !== undefined) { const p = array(o[name]); const q = p.ndim ? p : a.ndim === 2 ? np.full($.tup(a.shape[0], 1), p.item()) : p.reshape(1); a = at ? np.concatenate([a, q], new Named({ axis: a.ndim - 1 })) : np.concatenate([q, a], new Named({ axis: a.ndim - 1 })); } let times = o.n ?? 1; const axis = norm_axis(o.axis ?? -1, a.ndim); const S_ = (x, y) => $.tup(...a.shape.map((_n, k) => (k === axis ? new Slice(x, y, null) : new Slice(null, null, null)))); while (times-- > 0) { const [x, y] = [a.get(S_(1, null)), a.get(S_(null, -1))]; a = a.type === "b" ? calc("ne", x, y) : calc("sub", x, y); } return a; },
  gradient: (y, x) => { const v = array(y).values(), n = v.length, o = new Float64Array(n); const t = x === undefined ? null : array(x).values(); if (t === null) { for (let k = 1; k < n - 1; k++) o[k] = (v[k + 1] - v[k - 1]) / 2; o[0] = v[1] - v[0]; o[n - 1] = v[n - 1] - v[n - 2]; return arrayOf(o); } for (let k = 1; k < n - 1; k++) { const a = t[k] - t[k - 1], b = t[k + 1] - t[k]; o[k] = -b / (a * (a + b)) * v[k - 1] + (b - a) / (a * b) * v[k] + a / (b * (a + b)) * v[k + 1]; } o[0] = (v[1] - v[0]) / (t[1] - t[0]); o[n - 1] = (v[n - 1] - v[n - 2]) / (t[n - 1] - t[n - 2]); return arrayOf(o); },
  interp: (x, xp, fp) => { const t = array(xp).values(), f = array(fp).values(), n = t.length; return unary((v) => { if (v !== v) return NaN; if (v <= t[0]) return f[0]; if (v >= t[n - 1]) return f[n - 1]; const k = upper(t, v) - 1; return (f[k + 1] - f[k]) / (t[k + 1] - t[k]) * (v - t[k]) + f[k]; })(x); },
  searchsorted: (a, v, ...r) => { const o = told(r, ["side"]); const t = array(a).values(); const f = o.side === "right" ? upper : lower; if (typeof v === "number") return f(t, v); return np_int(unary((x) => f(t, x))(v)); },
  digitize: (x, bins) => { const t = array(bins).values(); return np_int(unary((v) => upper(t, v))(x)); },
  bincount: (c, ...r) => { const o = told(r, ["weights", "minlength"]); const v = array(c).values(); const w = o.weights === undefined || o.weights === null ? null : array(o.weights).values(); let n = o.minlength ?? 0; for (let k = 0; k < v.length; k++) if (v[k] >= n) n = v[k] + 1; const s = new Float64Array(n); for (let k = 0; k < v.length; k++) s[v[k]] += w ? w[k] : 1; return new NDArray(s, [n], w ? "f" : "i"); },
  sort: (a) => { a = array(a); return new NDArray(sorted(a.values()), a.shape, a.type); }, argsort: (a) => { const v = array(a).values(); const i = Array.from(v, (_x, k) => k); i.sort((p, q) => (v[p] < v[q] ? -1 : v[p] > v[q] ? 1 : p - q)); return arrayOf(i, "i"); }, partition: (a) => np.sort(a), lexsort: (keys) => { const l = [...$.it(keys)].map((k) => array(k).values()); const i = Array.from(l[0], (_x, k) => k); i.sort((p, q) => { for (let j = l.length - 1; j >= 0; j--) if (l[j][p] !== l[j][q]) return l[j][p] < l[j][q] ? -1 : 1; return p - q; }); return arrayOf(i, "i"); },
  unique: (a, ...r) => {
    const o = told(r, []); a = array(a);
    if (o.axis === 1) { const cols = a.T.tolist(); const seen = new Map(); const order = cols.map((c, k) => [c, k]).sort((p, q) => { for (let j = 0; j < p[0].length; j++) if (p[0][j] !== q[0][j]) return p[0][j] - q[0][j]; return 0; }); const inverse = new Float64Array(cols.length); const kept = []; for (const [c, k] of order) { const key = c.join(); if (!seen.has(key)) { seen.set(key, kept.length); kept.push(c); } inverse[k] = seen.get(key); } return $.tup(array(kept).T, arrayOf(inverse, "i")); }
    const v = a.values(); const i = Array.from(v, (_x, k) => k); i.sort((p, q) => (v[p] < v[q] ? -1 : v[p] > v[q] ? 1 : p - q));
    const kept = [], first = [], counts = [], inverse = new Float64Array(v.length);
    for (const k of i) { if (!kept.length || v[k] !== kept[kept.length - 1]) { kept.push(v[k]); first.push(k); counts.push(0); } counts[counts.length - 1]++; inverse[k] = kept.length - 1; }
    const u = arrayOf(kept, a.type), more = [...(o.return_index ? [arrayOf(first, "i")] : []), ...(o.return_inverse ? [arrayOf(inverse, "i")] : []), ...(o.return_counts ? [arrayOf(counts, "i")] : [])];
    return more.length ? $.tup(u, ...more) : u;
  },
  isin: (a, b) => { const s = new Set(array(b).tolist()); a = array(a); return new NDArray(Uint8Array.from(a.values(), (v) => (s.has(v) ? 1 : 0)), a.shape, "b"); }, setdiff1d: (a, b) => { const s = new Set(array(b).tolist()); const u = np.unique(a); return arrayOf(u.tolist().filter((v) => !s.has(v)), u.type); }, intersect1d: (a, b) => { const s = new Set(array(b).tolist()); const u = np.unique(a); return arrayOf(u.tolist().filter((v) => s.has(v)), u.type); }, union1d: (a, b) => np.unique(np.concatenate([a, b])),
  array_equal: (a, b) => { a = array(a); b = array(b); return a.ndim === b.ndim && a.shape.every((n, k) => n === b.shape[k]) && np.all(calc("eq", a, b)); }, allclose: (a, b) => { const d = np.abs(calc("sub", array(a), array(b))); return np.all(calc("le", d, calc("add", calc("mul", np.abs(array(b)), 1e-5), 1e-8))); }, isclose: (a, b) => Math.abs(a - b) <= 1e-8 + 1e-5 * Math.abs(b),
  dot: (a, b) => np.matmul(array(a), array(b)),
  matmul: (a, b) => {
    a = array(a); b = array(b);
    if (a.ndim === 1 && b.ndim === 1) { const x = a.values(), y = b.values(), n = x.length; if (n !== y.length) $.raise("ValueError", "matmul"); let s0 = 0, s1 = 0, s2 = 0, s3 = 0, k = 0; for (; k + 3 < n; k += 4) { s0 += x[k] * y[k]; s1 += x[k + 1] * y[k + 1]; s2 += x[k + 2] * y[k + 2]; s3 += x[k + 3] * y[k + 3]; } for (; k < n; k++) s0 += x[k] * y[k]; return s0 + s1 + (s2 + s3); }
    if (a.ndim === 2 && b.ndim === 1) { const [n, m] = a.shape, x = a.values(), y = b.values(), o = new Float64Array(n); for (let i = 0; i < n; i++) { let s = 0; for (let j = 0, p = i * m; j < m; j++) s += x[p + j] * y[j]; o[i] = s; } return arrayOf(o); }
    if (a.ndim === 1) return np.matmul(b.T, a);
    const [n, m] = a.shape, w = b.shape[1], y = b.values(), o = new Float64Array(n * w);
    if (m > n && a.T.dense() && a.type !== "U") { // tall tables row by row; of a table with itself one half
      const x = a.T.values(), same = x.buffer === y.buffer && x.byteOffset === y.byteOffset && n === w;
      for (let j = 0; j < m; j++) for (let i = 0, q = 0; i < n; i++, q += w) { const f = x[j * n + i]; for (let k = same ? i : 0, p = j * w; k < w; k++) o[q + k] += f * y[p + k]; }
      if (same) for (let i = 0; i < n; i++) for (let k = 0; k < i; k++) o[i * w + k] = o[k * w + i];
      return new NDArray(o, [n, w], "f");
    }
    const x = a.values();
    for (let i = 0; i < n; i++) for (let j = 0; j < m; j++) { const f = x[i * m + j]; if (f !== 0) for (let k = 0, p = j * w, q = i * w; k < w; k++) o[q + k] += f * y[p + k]; }
    return new NDArray(o, [n, w], "f");
  },
  linalg: {
    LinAlgError: $.cls("LinAlgError", [$.b.ValueError], "", [], false, false, () => undefined),
    norm: (a, ...r) => { const o = told(r, ["ord", "axis"]); return reduce(a, o, (v, p, n, s) => { let t = 0; for (let k = 0; k < n; k++, p += s) t += v[p] * v[p]; return Math.sqrt(t); }); },
    qr: (a, ...r) => nd.qr(array(a), told(r, ["mode"]).mode ?? "reduced"),
    solve: (a, b) => nd.solve(array(a), array(b)),
    lstsq: (a, b) => nd.lstsq(array(a), array(b)),
  },
  polynomial: { chebyshev: { chebvander: (x, d) => { x = array(x); const v = x.values(), n = v.length, o = new Float64Array(n * (d + 1)); for (let k = 0; k < n; k++) { const q = k * (d + 1); o[q] = 1; if (d) o[q + 1] = v[k]; for (let j = 2; j <= d; j++) o[q + j] = o[q + j - 1] * (2 * v[k]) - o[q + j - 2]; } return new NDArray(o, [n, d + 1], "f"); } } },
  lib: { stride_tricks: { sliding_window_view: (a, n) => { a = array(a); return new NDArray(a.data, [a.size - n + 1, n], a.type, [a.strides[0], a.strides[0]], a.offset); } } },
  char: { mod: (spec, v) => arrayOf(array(v).tolist().map((x) => $.f(x, spec.slice(1), -1)), "U") },
  uint64: Object.assign((v) => v, { __name__: "uint64" }), float32: Object.assign((v) => Math.fround(v), { __name__: "float32" }), nextafter: (v) => v,
  random: { default_rng: (seed) => nd.replay(seed), Generator: { $inst: () => false } },
  iinfo: () => ({ max: 2 ** 53, min: -(2 ** 53) }), finfo: (t) => (t === np.float32 ? { eps: 2 ** -23, tiny: 2 ** -126 } : { eps: 2 ** -52, max: Number.MAX_VALUE, tiny: 2 ** -1022 }),
};
function np_int(a) { return a instanceof NDArray ? new NDArray(a.data, a.shape, "i", a.strides, a.offset) : a; }
function lower(t, v) { let a = 0, b = t.length; while (a < b) { const m = (a + b) >> 1; if (t[m] < v) a = m + 1; else b = m; } return a; }
function upper(t, v) { let a = 0, b = t.length; while (a < b) { const m = (a + b) >> 1; if (v < t[m]) b = m; else a = m + 1; } return a; }
function triangular(a, keeps) { a = array(a).fresh(); const [n, m] = a.shape; for (let i = 0; i < n; i++) for (let j = 0; j < m; j++) if (!keeps(i, j)) a.data[i * m + j] = 0; return a; }
function wrapped(name) {
  const f = (a, b, ...r) => { const made = calc(name, a instanceof NDArray ? a : Array.isArray(a) ? array(a) : a, b instanceof NDArray || typeof b === "number" || typeof b === "boolean" ? (a instanceof NDArray || Array.isArray(a) ? b : array(b)) : array(b)); return into(made instanceof NDArray && made.ndim === 0 ? made.item() : made, told(r, ["out"]).out); };
  f.reduceat = (a, at, ...r) => {
    const axis = told(r, ["axis"]).axis ?? 0; a = array(a); const e = array(at).values();
    if (a.ndim === 2) { const [n, m] = a.shape, v = a.values(); const o = axis === 0 ? np.zeros($.tup(e.length, m)) : np.zeros($.tup(n, e.length)); const op = F[name]; if (axis === 0) for (let i = 0; i < e.length; i++) { const end = i + 1 < e.length ? Math.max(e[i] + 1, e[i + 1]) : n; for (let j = 0; j < m; j++) { let t = v[e[i] * m + j]; for (let k = e[i] + 1; k < end; k++) t = op(t, v[k * m + j]); o.data[i * m + j] = t; } } else for (let i = 0; i < n; i++) for (let j = 0; j < e.length; j++) { const end = j + 1 < e.length ? Math.max(e[j] + 1, e[j + 1]) : m; let t = v[i * m + e[j]]; for (let k = e[j] + 1; k < end; k++) t = op(t, v[i * m + k]); o.data[i * e.length + j] = t; } return o; }
    const v = a.values(), o = new Float64Array(e.length), op = F[name];
    for (let k = 0; k < e.length; k++) { const end = k + 1 < e.length ? Math.max(e[k] + 1, e[k + 1]) : v.length; let t = v[e[k]]; for (let j = e[k] + 1; j < end; j++) t = op(t, v[j]); o[k] = t; }
    return arrayOf(o);
  };
  f.reduce = (l, ...r) => { const axis = told(r, ["axis"]).axis ?? 0; if (l instanceof NDArray && l.ndim === 1) { let t = l.get(0); for (let k = 1; k < l.size; k++) t = F[name](t, l.get(k)); return t; } const all = [...$.it(axis === 1 ? l.T : l)]; return all.slice(1).reduce((x, y) => calc(name, x, y), all[0]); };
  f.accumulate = (a) => { a = array(a); const v = new Float64Array(a.values()), op = F[name]; for (let k = 1; k < v.length; k++) v[k] = op(v[k - 1], v[k]); return new NDArray(v, [v.length], a.type); };
  f.outer = (a, b) => calc(name, array(a).reshape(-1, 1), array(b));
  return f;
}
for (const name of ["sum", "min", "max", "mean", "std", "var", "any", "all", "cumsum", "argmax", "argmin", "ptp", "prod"]) NDArray.prototype[name] = function (...args) { return np[name](this, ...args); };
// A scalar of numpy is a number here, and some of its methods are asked for.
for (const proto of [Number.prototype, Boolean.prototype])
  for (const [name, f] of Object.entries({ tolist: (v) => v, item: (v) => v, view: (v) => { const b = new DataView(new ArrayBuffer(8)); b.setFloat64(0, v); return b.getBigUint64(0); }, any: (v) => !!v, all: (v) => !!v, sum: (v) => Number(v), max: (v) => v, min: (v) => v, mean: (v) => v, copy: (v) => v, round: (v, d = 0) => $.b.round(v, d) , astype: (v) => Number(v), ravel: (v) => array(v).reshape(1)}))
    Object.defineProperty(proto, name, { value(...args) { return f(this.valueOf(), ...args); }, configurable: true });
for (const [name, f] of Object.entries({ size: () => 1, ndim: () => 0, shape: () => $.tup(), real: (v) => v, T: (v) => v }))
  for (const proto of [Number.prototype, Boolean.prototype]) Object.defineProperty(proto, name, { get() { return f(this.valueOf()); }, configurable: true });

/* The random numbers of the test signal of an export, drawn when the page was built: numpy's generators are not here. */
nd.replay = () => {
  let k = 0;
  const next = () => { const { values, powers } = nd.draws[k++], made = arrayOf(values); if (powers) made.tens = values; return made; };
  return { standard_normal: next, uniform: next, choice: next, integers: next };
};

// ---- linear algebra: Householder and Gauss, rows in order
nd.qr = (a, mode) => {
  const [n, m] = a.shape, v = new Float64Array(a.values()), k = Math.min(n, m), tau = new Float64Array(k);
  // by columns: each is contiguous
  const c = new Float64Array(n * m);
  for (let i = 0; i < n; i++) for (let j = 0; j < m; j++) c[j * n + i] = v[i * m + j];
  for (let j = 0; j < k; j++) {
    const p = j * n;
    let s = 0;
    for (let i = j + 1; i < n; i++) s += c[p + i] * c[p + i];
    const alpha = c[p + j];
    if (s === 0) { tau[j] = 0; continue; }
    const beta = alpha >= 0 ? -Math.sqrt(alpha * alpha + s) : Math.sqrt(alpha * alpha + s);
    tau[j] = (beta - alpha) / beta;
    const scale = 1 / (alpha - beta);
    for (let i = j + 1; i < n; i++) c[p + i] *= scale;
    c[p + j] = beta;
    for (let q = j + 1; q < m; q++) {
      const r = q * n;
      let t = c[r + j];
      for (let i = j + 1; i < n; i++) t += c[p + i] * c[r + i];
      t *= tau[j];
      c[r + j] -= t;
      for (let i = j + 1; i < n; i++) c[r + i] -= t * c[p + i];
    }
  }
  const R = np.zeros($.tup(k, m));
  for (let j = 0; j < m; j++) for (let i = 0; i <= Math.min(j, k - 1); i++) R.data[i * m + j] = c[j * n + i];
  if (mode === "r") return R;
  const Q = new Float64Array(k * n);
  for (let j = 0; j < k; j++) Q[j * n + j] = 1;
  for (let j = k - 1; j >= 0; j--) for (let q = 0; q < k; q++) {
    const p = j * n, r = q * n;
    let t = Q[r + j];
    for (let i = j + 1; i < n; i++) t += c[p + i] * Q[r + i];
    t *= tau[j];
    Q[r + j] -= t;
    for (let i = j + 1; i < n; i++) Q[r + i] -= t * c[p + i];
  }
  return $.tup(new NDArray(Q, [k, n], "f").T.fresh(), R);
};
nd.solve = (a, b) => {
  const n = a.shape[0], A = new Float64Array(a.values()), w = b.ndim === 1 ? 1 : b.shape[1], X = new Float64Array(b.T.values()); // a right side a row
  for (let j = 0; j < n; j++) {
    let p = j;
    for (let i = j + 1; i < n; i++) if (Math.abs(A[i * n + j]) > Math.abs(A[p * n + j])) p = i;
    if (A[p * n + j] === 0 || A[p * n + j] !== A[p * n + j]) throw np.linalg.LinAlgError("Singular matrix");
    if (p !== j) {
      for (let k = 0; k < n; k++) [A[j * n + k], A[p * n + k]] = [A[p * n + k], A[j * n + k]];
      for (let k = 0; k < w * n; k += n) { const t = X[k + j]; X[k + j] = X[k + p]; X[k + p] = t; }
    }
    for (let i = j + 1; i < n; i++) {
      const f = A[i * n + j] /= A[j * n + j];
      if (f !== 0) for (let k = j + 1; k < n; k++) A[i * n + k] -= f * A[j * n + k];
    }
  }
  for (let o = 0; o < w * n; o += n) {
    for (let i = 1; i < n; i++) { let s = X[o + i]; for (let j = 0, q = i * n; j < i; j++) s -= A[q + j] * X[o + j]; X[o + i] = s; }
    for (let i = n - 1; i >= 0; i--) { let s = X[o + i]; for (let j = i + 1, q = i * n; j < n; j++) s -= A[q + j] * X[o + j]; X[o + i] = s / A[i * n + i]; }
  }
  return b.ndim === 1 ? arrayOf(X) : new NDArray(X, [w, n], "f").T;
};
/* Smallest least squares by the orthogonal factors, of full rank or with a trace of a ridge. */
nd.lstsq = (a, b) => {
  const [n, m] = a.shape;
  const wide = np.vstack([a, calc("mul", np.eye(m), 1e-9 * Math.max(1e-300, np.linalg.norm(a) / Math.sqrt(m)))]);
  const [q, r] = nd.qr(wide, "reduced");
  const target = np.concatenate([b, np.zeros(b.ndim === 1 ? m : $.tup(m, b.shape[1]))]);
  return $.tup(nd.solve(r, np.matmul(q.T, target)), null, m, null);
};
