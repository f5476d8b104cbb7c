/* The package's extension and what it takes from Python's library, for the page. */

import { $, Dict, nd, Range } from "./python.js";
import { NDArray, array, arrayOf, np } from "./numpy.js";

let c = null; // exports of the C code
export const use = (core) => { c = core.c; };
const heap = () => c.memory.buffer;

/** Arrays as arguments: copied in before the call, freed after. */
function call(work) {
  const taken = [];
  const room = (bytes) => {
    const at = c.page_alloc(Math.max(8, bytes));
    if (!at) throw $.b.MemoryError("the browser has no memory left for this log");
    taken.push(at);
    return at;
  };
  const put = (a) => {
    if (a === null || a === undefined) return 0;
    const v = array(a).values();
    const at = room(8 * v.length);
    new Float64Array(heap(), at, v.length).set(v);
    return at;
  };
  const out = (at, n) => new Float64Array(heap(), at, n).slice();
  try { return work(put, (n) => room(8 * n), out, room); } finally { for (const at of taken) c.page_free(at); }
}
const size = (a) => array(a).size;
const named = (args, names) => {
  const o = args.length && args[args.length - 1] instanceof $.Named ? args.pop().values : {};
  return names.map((n, k) => (args[k] !== undefined ? args[k] : o[n] ?? null));
};

// What C holds is given back when JavaScript forgets it, and all of it with the worker.
const gone = new FinalizationRegistry(([free, at]) => c[free](at));

class Evaluator {
  constructor(r, w, center, offset, z) {
    this.at = call((put) => c.page_evaluator_new(size(r), put(r), put(w), center, offset, put(z)));
    gone.register(this, ["page_evaluator_free", this.at]);
  }
  run(x) {
    const n = size(x);
    return call((put, _r, out) => { const at = put(x); this.rejected = c.page_evaluator_run(this.at, n, at, at); return arrayOf(out(at, n)); });
  }
}
class Gram {
  constructor(r, z, targets) {
    this.n = size(r); this.targets = Number(targets);
    this.at = call((put) => c.page_gram_new(this.n, put(r), put(z), this.targets));
    gone.register(this, ["page_gram_free", this.at]);
  }
  add(x, targets, weight = null) {
    const n = size(x);
    if (call((put) => c.page_gram_add(this.at, n, put(x), this.targets, put(targets), put(weight))) < n) $.raise("ValueError", "a sample is not finite");
    return null;
  }
  skip(x) { call((put) => c.page_gram_skip(this.at, size(x), put(x))); return null; }
  take() { const m = 1 + this.n + this.targets; return call((_p, room, out) => { const at = room(m * m); c.page_gram_take(this.at, at); return arrayOf(out(at, m * m)).reshape(m, m); }); }
  only_targets(only) { c.page_gram_only_targets(this.at, only ? 1 : 0); return null; }
}
class Stepper {
  constructor(r, w, center, offset, bu, bv, au, av, z) { this.made = [r, w, center, offset, z]; this.maps = [bu, bv, au, av]; this.reset(); }
  reset() { if (this.at) c.page_model_reset(this.at); const [r, w, center, offset, z] = this.made; this.evaluator = new Evaluator(r, w, center, offset, z); return null; }
  get state() { return array(this.made[4]).fresh(); }
  get parameters() { const [r, w, center, offset, z] = this.made; return $.tup(r, w, center, offset, ...this.maps, z); }
  /* Sample by sample by the core itself, whose bits are those of exported code. */
  get single() {
    const [r, w, center, offset, z] = this.made;
    this.at ??= call((put) => c.page_model_new(size(r), put(r), put(w), center, offset, put(z)));
    return this.at;
  }
  get output() { return c.page_model_output(this.single); }
  __call__(x) { const at = this.single; return call((put, _r, out) => { const a = put([x]); c.page_model_run(at, 1, a, a); return out(a, 1)[0]; }); }
  simulate(x) {
    const [bu, bv, au, av] = this.maps;
    let y = size(bu) ? native.map_values(bu, bv, x) : x;
    y = this.evaluator.run(y);
    const rejected = this.evaluator.rejected;
    if (size(au)) y = native.map_values(au, av, y);
    return $.tup(y, rejected);
  }
}
class Block {
  constructor(image) {
    const v = array(image).values();
    this.at = call((_p, _r, _o, bytes) => { const at = bytes(4 * v.length); new Uint32Array(heap(), at, v.length).set(v); return c.page_block_new(at, v.length); });
    if (!this.at) $.raise("ValueError", "image");
    this.n = c.page_block_parameters(this.at, 0);
  }
  reset() { c.page_block_reset(this.at); return null; }
  get output() { return c.page_block_output(this.at); }
  run(x, on) {
    const n = size(x);
    return call((put, room, out, bytes) => {
      const [y, f, s] = [room(n), room(n), bytes(n)], given = put(x);
      new Uint8Array(heap(), s, n).set(array(on).values());
      c.page_block_run(this.at, n, given, s, y, f);
      return $.tup(arrayOf(out(y, n)), arrayOf(out(f, n), "i"));
    });
  }
  save() { const n = c.page_state_words(this.n); return call((_p, _r, _o, bytes) => { const at = bytes(4 * n); c.page_block_save(this.at, at); return arrayOf(Float64Array.from(new Uint32Array(heap(), at, n)), "i"); }); }
  get parameters() {
    const n = this.n, v = call((_p, room, out) => { const at = room(4 * n + 12); c.page_block_parameters(this.at, at); return out(at, 4 * n + 12); });
    const part = (k) => arrayOf(v.slice(k * n, (k + 1) * n)), none = () => np.zeros(0), rest = v.slice(4 * n);
    const names = ["input_low", "input_high", "output_low", "output_high", "reach_low", "reach_high", "line_slope", "line_offset", "fade", "fingerprint"];
    return $.dict([["threshold", part(0)], ["slope", part(1)], ["loading", part(2)], ["center", rest[0]], ["offset", rest[1]], ["before_u", none()], ["before_v", none()], ["after_u", none()], ["after_v", none()], ["start", part(3)], ...names.map((name, k) => [name, rest[k + 2]])]);
  }
}
const maker = (C) => {
  const f = (...args) => {
    const made = new C(...args);
    if (!made.__call__) return made;
    const callable = (x) => made.__call__(x); // an instance that is called
    return new Proxy(callable, { get: (_f, key) => { const v = made[key]; return typeof v === "function" ? v.bind(made) : v; }, getPrototypeOf: () => C.prototype, has: (_f, key) => key in made });
  };
  f.prototype = C.prototype;
  return f;
};

export const native = {
  SLOPES: 0, WEIGHTS: 1, STOPS: 2, ENGINE_DENSE: 2147483647, INPUT_LIMIT: 1e100, DIRECT_GROUPS: 8,
  Block: maker(Block), BLOCK_REJECTED: 1, BLOCK_REJECTED_EVER: 2, BLOCK_LIMITED: 4, BLOCK_LIMITED_EVER: 8, OFFSET_WORDS: 0,
  block_image: (r, w, center, offset, bu, bv, au, av, start, limits, fingerprint) => { const n = size(r), m = c.page_block_words(n); return call((put, _r, _o, bytes) => { const at = bytes(4 * m); c.page_block_image(n, put(r), put(w), center, offset, put(start), put(limits), fingerprint, at); return arrayOf(Float64Array.from(new Uint32Array(heap(), at, m)), "i"); }); },
  Evaluator: maker(Evaluator), Gram: maker(Gram), Stepper: maker(Stepper), StackStepper: maker(Stepper),
  turning_points: (x, swing) => { const n = size(x); return call((put, room, out) => { const at = room(n + 2); const m = c.page_turning_points(n, put(x), swing, at); return arrayOf(out(at, m), "i"); }); },
  essential: (x, rows) => { const k = size(rows), v = array(rows).values(), last = k ? v[k - 1] + 1 : 1; return call((put, room, out) => { const a = room(last), b = room(k + 1); const m = c.page_essential(put(x), k, put(rows), a, b); return $.tup(arrayOf(out(a, m), "i"), arrayOf(out(b, k), "i")); }); },
  bin_sums: (x, y, w, bins, low, high) => call((put, room, out) => { const at = room(5 * bins); new Float64Array(heap(), at, 5 * bins).fill(0); c.page_bin_sums(size(x), put(x), put(y), put(w), bins, low, high, at); return arrayOf(out(at, 5 * bins)).reshape(bins, 5); }),
  play_bank: (x, r, z, rows) => { const n = size(r), k = size(rows); return call((put, room, out) => { const at = room(n * k), st = put(z); if (c.page_plays(n, put(r), st, size(x), put(x), k, put(rows), at)) throw $.b.MemoryError("plays"); return $.tup(arrayOf(out(at, n * k)).reshape(k, n), arrayOf(out(st, n))); }); },
  solve_bounded: (...args) => {
    const [gram, rhs, lower, free, plays, basis, extra, extra_rhs, passive, norm] = named(args, ["gram", "rhs", "lower", "free", "plays", "basis", "extra", "extra_rhs", "passive", "target_norm"]);
    const n = size(rhs);
    return call((put, rm, out, bytes) => {
      const u = rm(n), marks = bytes(n), answer = rm(4);
      const m = new Uint8Array(heap(), marks, n);
      if (passive) m.set(array(passive).values()); else m.fill(0);
      if (c.page_solve(n, free, plays, basis, put(gram), put(rhs), put(extra), put(extra_rhs), put(lower), norm ?? 0, u, marks, answer)) throw $.b.MemoryError("solve");
      const [kkt, condition, iterations, status] = out(answer, 4);
      return $.tup(arrayOf(out(u, n)), new NDArray(new Uint8Array(heap(), marks, n).slice(), [n], "b"), kkt, condition, iterations, status);
    });
  },
  map_values: (u, v, x) => { const n = size(x); return call((put, room, out) => { const at = room(n); c.page_map_values(size(u), put(u), put(v), n, put(x), at); return arrayOf(out(at, n)); }); },
  pi_invert: (r, w, z) => { const n = size(r); return call((put, room, out) => { const [a, b, d] = [room(n), room(n), room(n)]; const fault = c.page_pi_invert(n, put(r), put(w), put(z), a, b, d); return $.tup(fault, arrayOf(out(a, n)), arrayOf(out(b, n)), arrayOf(out(d, n))); }); },
  direct_bank: (y, time, radius, length, constant, known) => {
    const [v, t, r, l, tau] = [y, time, radius, length, constant].map((a) => array(a).values());
    const [s, p, q] = [r.length, l.length, tau.length], m = s + p + q, n = v.length;
    const low = Float64Array.from(r, (w) => v[0] - (known ? 0 : w)), high = Float64Array.from(r, (w) => v[0] + (known ? 0 : w));
    const path = new Float64Array(p), lag = new Float64Array(q).fill(v[0]), rows = new Float64Array(n * m);
    for (let k = 0, at = 0; k < n; k++, at += m) {
      const x = v[k], way = k ? x - v[k - 1] : 0, passed = k ? t[k] - t[k - 1] : 0;
      for (let i = 0; i < s; i++) {
        low[i] = Math.max(x - r[i], Math.min(x + r[i], low[i])); high[i] = Math.max(x - r[i], Math.min(x + r[i], high[i]));
        rows[at + i] = x - (low[i] + 0.5 * (high[i] - low[i]));
      }
      for (let i = 0; i < p; i++) { const end = way < 0 ? -l[i] : l[i]; path[i] = end + c.page_decay(Math.abs(way) / l[i]) * (path[i] - end); rows[at + s + i] = path[i]; }
      for (let j = 0; j < q; j++) { lag[j] -= Math.expm1(-passed / tau[j]) * (x - lag[j]); rows[at + s + p + j] = x - lag[j]; }
    }
    return $.tup(arrayOf(rows).reshape(n, m), null);
  },
  text_lines: (text, from = 0) => inside(text.subarray(from), (at, n) => c.page_text_lines(at, n)),
  text_offset: (text, lines, start = 0) => { const begin = Math.min(start, text.length); return begin + inside(text, (at) => c.page_text_offset(at + begin, text.length - begin, lines)); },
  text_whole_lines: (text) => inside(text, (at, n) => c.page_text_whole_lines(at, n)),
  text_read: (text, offset, line, delimiter, decimal, letters, columns, rows, missing = false) => {
    const capacity = rows.size;
    return call((_p, room, _o, bytes) => {
      const answer = room(6), kept = bytes(4 * letters.length), holders = letters.map((k) => bytes(k ? 4 * k * capacity : 8 * capacity)), numbers = bytes(8 * capacity), list = bytes(4 * letters.length);
      return inside(text, (at) => {
        new Int32Array(heap(), kept, letters.length).set(letters);
        new Uint32Array(heap(), list, letters.length).set(holders);
        c.page_text_read(at + offset, text.length - offset, delimiter.charCodeAt(0), decimal.charCodeAt(0), missing ? 1 : 0, letters.length, kept, line, capacity, numbers, list, answer);
        const [count, lines, used, column, empty, odd] = new Float64Array(heap(), answer, 6);
        letters.forEach((k, j) => {
          if (!k) columns[j].data.set(new Float64Array(heap(), holders[j], count));
          else {
            const codes = new Uint32Array(heap(), holders[j], k * count), words = new Map(), out = new Array(capacity).fill("");
            for (let q = 0; q < count; q++) {
              let w = "";
              for (let m = q * k; m < (q + 1) * k && codes[m]; m++) w += String.fromCodePoint(codes[m]);
              const seen = words.get(w);
              if (seen === undefined) words.set(w, w);
              out[q] = seen ?? w;
            }
            columns[j].labels = out;
          }
        });
        const at_ = new BigInt64Array(heap(), numbers, count);
        for (let q = 0; q < count; q++) rows.data[q] = Number(at_[q]);
        return $.tup(count, lines, used, column, empty !== 0, odd !== 0);
      });
    });
  },
};
/* One text at a time stays in the memory of C: a reader asks many times about the same bytes. */
let held = null, held_at = 0, held_size = 0;
function inside(text, work) {
  if (held === null || held.buffer !== text.buffer || held.byteOffset !== text.byteOffset || held.length !== text.length) {
    if (text.length > held_size) {
      if (held_at) c.page_free(held_at);
      held_at = c.page_alloc(text.length + 64);
      held_size = held_at ? text.length : 0;
      if (!held_at) { held = null; throw $.b.MemoryError("the log is too long for the memory of this browser"); }
    }
    new Uint8Array(heap(), held_at, text.length).set(text);
    held = text;
  }
  return work(held_at, text.length);
}
export function forget() { if (held_at) c.page_free(held_at); held = null; held_at = held_size = 0; }
// Arrays (capacity, letters) of code points become arrays of words by .view("U64")[:, 0].
NDArray.prototype.view = function (t) {
  if (typeof t !== "string" || !t.startsWith("U")) return this;
  const words = (this.labelled ?? this).labels;
  return { __getitem__: () => arrayOf(words.slice(0, this.shape[0]), "U") };
};
const get = NDArray.prototype.get;
NDArray.prototype.get = function (i) { const made = get.call(this, i); if (this.labels && made instanceof NDArray) made.labelled = this; return made; };

// Tall factors are the work of C; JavaScript has the small ones.
const small = nd.qr;
nd.qr = (a, mode) => {
  const [n, m] = a.shape;
  if (mode !== "r" || n < m) return small(a, mode);
  return call((put, room, out) => {
    const r = room(m * m);
    new Float64Array(heap(), r, m * m).fill(0);
    if (c.page_triangle(n, m, put(a), r)) throw $.b.MemoryError("factors");
    return arrayOf(out(r, m * m)).reshape(m, m);
  });
};

/* Rows and triangles of the test for rate and creep by C, which holds one block at a time. */
const blocks_of = (stretches, blocks, degree, ...scale) => call((put, room, out) => {
  const [s, p, q] = scale.map(size), all = [...$.it(stretches)], loads = all[0].loads.length;
  const m = degree + loads * (degree + 1) + 2 * (1 + loads) * (s + p) + Math.max(1, 2 * loads) * (q + 1) + 1;
  const counted = all.map(({ counts }) => np.count_nonzero(counts)), ends = np.round(np.linspace(0, counted.reduce((a, b) => a + b, 0), blocks + 1)).tolist();
  const sizes = room(3), known = put(np.concatenate(scale)), r = room(m * m), rows = room((ends.slice(1).reduce((most, end, k) => Math.max(most, end - ends[k]), 0) + 1) * m);
  new Int32Array(heap(), sizes, 5).set([degree, s, p, q, loads]);
  let left = 0, state, given, samples, at = -1;
  return ends.slice(1).map((end, k) => {
    const count = end - ends[k];
    new Float64Array(heap(), r, m * m).fill(0);
    for (let more = count; more > 0;) {
      while (!left) {
        const { time, x, y, counts, loads } = all[++at];
        left = counted[at]; samples = size(x); state = put(new Float64Array(2 * s + p + q + 1));
        given = put(np.concatenate([counts, time, x, samples > 2 ? $.imp("dehyst.identification.facts").velocity(time, x) : np.zeros(samples), y, ...loads]));
      }
      const n = Math.min(left, more);
      c.page_evidence_rows(sizes, known, state, samples, given, n, rows);
      c.page_centre(n, m, rows);
      if (c.page_triangle(n, m, rows, r)) throw $.b.MemoryError("factors");
      left -= n; more -= n;
    }
    return $.tup(arrayOf(out(r, m * m)).reshape(m, m), count);
  });
});
// ---- Python's library
const regex_flags = { ASCII: 1, IGNORECASE: 2, DOTALL: 4, MULTILINE: 8 };
class Match {
  constructor(m, names) { this.m = m; this.names = names; this.string = m.input; }
  group(...k) { if (!k.length) k = [0]; const v = k.map((i) => this.m[i] ?? null); return v.length === 1 ? v[0] : $.tup(...v); }
  groups(other = null) { return $.tup(...this.m.slice(1).map((v) => v ?? other)); }
  __getitem__(k) { return this.group(k); }
  start() { return this.m.index; }
  end() { return this.m.index + this.m[0].length; }
  span() { return $.tup(this.start(), this.end()); }
}
/* \\w of any script, within brackets or not. */
function words_in(source) {
  let out = "", inside = false;
  for (let k = 0; k < source.length; k++) {
    const ch = source[k];
    if (ch === "\\") {
      const next = source[++k];
      out += next === "w" ? (inside ? "\\p{L}\\p{N}_" : "[\\p{L}\\p{N}_]") : ch + next;
      continue;
    }
    if (ch === "[") inside = true;
    else if (ch === "]") inside = false;
    out += ch;
  }
  return out;
}
class Pattern {
  constructor(text, flags = 0) {
    if (flags instanceof $.Named) flags = flags.values.flags ?? 0;
    let source = text;
    const inline = /^\(\?([imsx]+)\)/.exec(source);
    if (inline) {
      source = source.slice(inline[0].length);
      for (const [letter, bit] of [["i", 2], ["s", 4], ["m", 8]]) if (inline[1].includes(letter)) flags |= bit;
    }
    source = source.replace(/\\A/g, "^").replace(/\\Z/g, "$$");
    const wide = !(flags & 1) && /\\w|\\W/.test(source) || /[^\x00-\x7f]/.test(source);
    if (wide) source = source.replaceAll("[^\\W\\d_]", "\\p{L}");
    if (wide) source = words_in(source);
    this.pattern = text;
    const mode = (flags & 2 ? "i" : "") + (flags & 4 ? "s" : "") + (flags & 8 ? "m" : "") + (wide ? "u" : "");
    this.all = new RegExp(`^(?:${source})$`, mode.replace("m", ""));
    this.begin = new RegExp(source, mode + "y");
    this.any = new RegExp(source, mode + "g");
  }
  fullmatch(s) { const m = this.all.exec(s); return m && m[0].length === s.length ? new Match(m) : null; }
  match(s, at = 0) { this.begin.lastIndex = at; const m = this.begin.exec(s); return m ? new Match(m) : null; }
  search(s) { this.any.lastIndex = 0; const m = this.any.exec(s); return m ? new Match(m) : null; }
  sub(by, s) { return s.replace(this.any, typeof by === "function" ? (...a) => { const groups = a.slice(0, a.findIndex((x) => typeof x === "number")); groups.index = 0; groups.input = s; return by(new Match(groups)); } : by.replace(/\$/g, "$$$$").replace(/\\g<0>/g, "$$&").replace(/\\(\d)/g, "$$$1").replace(/\\\\/g, "\\")); }
  split(s) { return s.split(this.any); }
  findall(s) { return [...s.matchAll(this.any)].map((m) => (m.length > 2 ? $.tup(...m.slice(1).map((v) => v ?? "")) : m.length === 2 ? m[1] ?? "" : m[0])); }
  finditer(s) { return [...s.matchAll(this.any)].map((m) => new Match(m)); }
}
const patterns = new Map();
const compiled = (p, flags) => { if (p instanceof Pattern) return p; const key = `${p}/${flags instanceof $.Named ? flags.values.flags : flags ?? 0}`; if (!patterns.has(key)) patterns.set(key, new Pattern(p, flags)); return patterns.get(key); };
const re = {
  compile: (p, f) => compiled(p, f), escape: (s) => s.replace(/[.*+?^${}()|[\]\\/-]/g, "\\$&"),
  fullmatch: (p, s, f) => compiled(p, f).fullmatch(s), match: (p, s, f) => compiled(p, f).match(s), search: (p, s, f) => compiled(p, f).search(s), sub: (p, by, s) => compiled(p).sub(by, s), split: (p, s) => compiled(p).split(s), findall: (p, s, f) => compiled(p, f).findall(s), finditer: (p, s) => compiled(p).finditer(s), ...regex_flags, A: 1, I: 2,
};
class Moment {
  constructor(ms, zone, micro) { this.ms = ms; this.tzinfo = zone; this.micro = micro; }
  timestamp() { return this.ms / 1000 + this.micro; }
  replace() { return new Moment(this.ms, {}, this.micro); }
  isoformat() { return new Date(this.ms).toISOString().replace(/\.\d+Z/, "+00:00"); }
}
const datetime = Object.assign((y, mo, d, h = 0, mi = 0, s = 0, us = 0) => { const ms = Date.UTC(y, mo - 1, d, h, mi, s); const t = new Date(ms); if (t.getUTCMonth() !== mo - 1 || t.getUTCDate() !== d || h > 23 || mi > 59 || s > 59) $.raise("ValueError", "no such date"); return new Moment(ms, us instanceof $.Named ? us.values.tzinfo : null, typeof us === "number" ? us / 1e6 : 0); }, {
  fromisoformat: (text) => {
    const m = /^(\d{4})-(\d\d)-(\d\d)(?:[T ](\d\d):(\d\d)(?::(\d\d)(?:[.,](\d+))?)?)?\s?(Z|UTC|[+-]\d\d:?\d\d)?$/.exec(text);
    if (!m) $.raise("ValueError", "Invalid isoformat string");
    const made = datetime(+m[1], +m[2], +m[3], +(m[4] ?? 0), +(m[5] ?? 0), +(m[6] ?? 0));
    made.micro = m[7] ? Number(`0.${m[7].slice(0, 6)}`) : 0;
    if (m[8]) { made.tzinfo = {}; const z = /([+-])(\d\d):?(\d\d)/.exec(m[8]); if (z) made.ms -= (z[1] === "-" ? -1 : 1) * (60 * +z[2] + +z[3]) * 60000; }
    return made;
  },
  now: () => new Moment(Date.now(), {}, 0), strptime: () => $.raise("ValueError", "strptime"), fromtimestamp: (s) => new Moment(1000 * s, {}, 0),
});
/* Ratcliff and Obershelp's likeness of two words, as difflib has it. */
function likeness(a, b) {
  let matched = 0;
  const grow = (al, ah, bl, bh) => {
    let best = [al, bl, 0];
    for (let i = al; i < ah; i++) for (let j = bl; j < bh; j++) { let k = 0; while (i + k < ah && j + k < bh && a[i + k] === b[j + k]) k++; if (k > best[2]) best = [i, j, k]; }
    const [i, j, k] = best;
    if (!k) return;
    matched += k;
    grow(al, i, bl, j);
    grow(i + k, ah, j + k, bh);
  };
  grow(0, a.length, 0, b.length);
  return a.length + b.length ? (2 * matched) / (a.length + b.length) : 1;
}
function* cells(lines, o) {
  const delimiter = o?.values.delimiter ?? ",", blanks = o?.values.skipinitialspace ?? false;
  for (const line of $.it(lines)) {
    const row = [];
    let cell = "", quoted = false, k = 0, fresh = true;
    for (; k < line.length; k++) {
      const ch = line[k];
      if (quoted) { if (ch === '"') { if (line[k + 1] === '"') { cell += '"'; k++; } else quoted = false; } else cell += ch; }
      else if (fresh && ch === '"') { quoted = true; fresh = false; }
      else if (ch === delimiter) { row.push(cell); cell = ""; fresh = true; }
      else if (fresh && blanks && ch === " ") continue;
      else { cell += ch; fresh = false; }
    }
    row.push(cell);
    yield row;
  }
}
const category = (ch) => (/\p{Cc}/u.test(ch) ? "Cc" : /\p{Cf}/u.test(ch) ? "Cf" : /\p{Cs}/u.test(ch) ? "Cs" : /\p{Co}/u.test(ch) ? "Co" : /\p{Cn}/u.test(ch) ? "Cn" : /\p{Zl}/u.test(ch) ? "Zl" : /\p{Zp}/u.test(ch) ? "Zp" : /\p{Zs}/u.test(ch) ? "Zs" : /\p{L}/u.test(ch) ? "Ll" : "So");
const anything = new Proxy(function () {}, { get: (_f, k) => (k === "$absent" ? "typing" : k === "$inst" ? () => false : k === "prototype" ? {} : typeof k === "symbol" ? undefined : anything), apply: () => anything });
const words = (name, f) => Object.assign(f, { $absent: undefined, __name__: name });
function fields(o) { const C = typeof o === "function" ? o : o.constructor; return $.tup(...C.$fields.map(([name]) => ({ name }))); }
const as_dict = (v) => (v?.constructor?.$fields && !Array.isArray(v) ? $.dict(v.constructor.$fields.map(([k]) => [k, as_dict(v[k])])) : Array.isArray(v) ? v.map(as_dict) : v);
const suppress = (...kinds) => ({ __enter__: () => null, __exit__: (_t, e) => $.isinst(e, kinds) });
const maths = Object.fromEntries(["sqrt", "exp", "log10", "log2", "log1p", "sin", "cos", "tan", "atan", "atan2", "hypot", "floor", "ceil", "trunc", "tanh", "expm1"].map((n) => [n, Math[n]]));

/* Files of the package that the page carries: text by its path below the package, put here when the page is built. */
export const carried = new Map();
class Place {
  constructor(path) { this.path = path; }
  get name() { return this.path.split("/").pop(); }
  get suffix() { const m = /.(\.[^.]+)$/.exec(this.name); return m ? m[1] : ""; }
  get stem() { return this.suffix ? this.name.slice(0, -this.suffix.length) : this.name; }
  get parent() { return new Place(this.path.split("/").slice(0, -1).join("/")); }
  get parents() { const all = []; for (let p = this.parent; p.path; p = p.parent) all.push(p); return [...all, new Place(""), new Place(""), new Place(""), new Place("")]; }
  resolve() { return this; }
  exists() { return carried.has(this.path); }
  is_file() { return carried.has(this.path); }
  iterdir() { return [...carried.keys()].filter((k) => k.startsWith(this.path + "/") && !k.slice(this.path.length + 1).includes("/")).map((k) => new Place(k)); }
  read_text() { return carried.get(this.path) ?? $.raise("FileNotFoundError", this.path); }
  __truediv__(o) { return new Place(this.path ? `${this.path}/${$.b.str(o)}` : $.b.str(o)); }
  __lt__(o) { return this.path < o.path; }
  __str__() { return this.path; }
}
class Weak extends Dict { map = new WeakMap(); } // a table may go
class Counts extends Dict { lookup(k) { return super.lookup(k) ?? [k, 0]; } }
export function provide() {
  $.provide("numpy", np);
  $.provide("numpy.typing", anything);
  $.provide("dehyst._native", native);
  $.provide("dehyst.identification.evidence_rows", { blocks_of, Stretch: $.cls("Stretch", [], "NamedTuple", [["time", null], ["x", null], ["y", null], ["counts", null], ["loads", () => $.tup()]], false, true, () => undefined) });
  $.provide("dehyst.identification.threads", { single_blas: () => ({ __enter__: () => null, __exit__: () => false }), in_parallel: (f, items) => [...$.it(items)].map((v) => f(v)) });
  $.provide("math", { ...maths, pi: Math.PI, e: Math.E, inf: Infinity, nan: NaN, log: (v, b) => (b === undefined ? Math.log(v) : Math.log(v) / Math.log(b)), isfinite: Number.isFinite, isnan: Number.isNaN, isinf: (v) => Math.abs(v) === Infinity, fsum: (v) => $.b.sum(v), copysign: (a, b) => (b < 0 || Object.is(b, -0) ? -Math.abs(a) : Math.abs(a)), prod: (v) => [...$.it(v)].reduce((a, b) => a * b, 1), gcd: (a, b) => { while (b) [a, b] = [b, a % b]; return a; }, isclose: (a, b) => Math.abs(a - b) <= 1e-9 * Math.max(Math.abs(a), Math.abs(b)) });
  $.provide("re", re);
  $.provide("datetime", { datetime, UTC: {}, timezone: { utc: {} }, timedelta: anything });
  $.provide("time", { perf_counter: () => performance.now() / 1000, time: () => Date.now() / 1000 });
  $.provide("csv", { reader: (l, o) => cells(l, o), writer: (stream) => ({ writerows: (rows) => stream.write([...$.it(rows)].map((row) => [...$.it(row)].map((v) => { const s = $.b.str(v); return /[",\n\r]/.test(s) ? `"${s.replaceAll('"', '""')}"` : s; }).join(",") + "\n").join("")) }), Error: $.b.ValueError });
  $.provide("difflib", { get_close_matches: (w, all, o) => { const { n = 3, cutoff = 0.6 } = o?.values ?? {}; return [...$.it(all)].map((x) => [likeness(x, w), x]).filter((x) => x[0] >= cutoff).sort((a, b) => b[0] - a[0] || (a[1] < b[1] ? 1 : -1)).slice(0, n).map((x) => x[1]); } });
  $.provide("unicodedata", { category, normalize: (f, s) => s.normalize(f) });
  $.provide("shlex", { quote: (s) => (s !== "" && /^[\w@%+=:,./-]+$/.test(s) ? s : `'${s.replaceAll("'", "'\"'\"'")}'`) });
  $.provide("json", library.json);
  $.provide("warnings", { warn: () => null });
  $.provide("weakref", { WeakKeyDictionary: () => new Weak() });
  $.provide("os", { PathLike: anything, linesep: "\n", name: "posix", fspath: (v) => v, environ: $.dict(), cpu_count: () => 1 });
  $.provide("inspect", { signature: () => ({ bind: anything, parameters: $.dict() }) });
  $.provide("collections", { Counter: (v) => { const d = new Counts(); for (const x of v === undefined ? [] : $.it(v)) d.set(x, d.lookup(x)[1] + 1); return d; }, defaultdict: anything });
  $.provide("collections.abc", { Callable: anything, Iterable: anything, Iterator: anything, Mapping: $.b.dict, Sequence: words("Sequence", Object.assign(() => null, { $inst: (v) => Array.isArray(v) || typeof v === "string" })) });
  $.provide("itertools", {
    compress: (v, keep) => { const k = [...$.it(keep)]; return [...$.it(v)].filter((_x, j) => $.t(k[j])); }, pairwise: (v) => { const a = [...$.it(v)]; return a.slice(1).map((x, k) => $.tup(a[k], x)); },
    islice: function* (v, a, b) { const [lo, hi] = b === undefined ? [0, a] : [a, b]; let k = 0; if (hi !== null && k >= hi) return; for (const x of $.it(v)) { if (k >= lo) yield x; k++; if (hi !== null && k >= hi) return; } }, chain: Object.assign((...l) => l.flatMap((v) => [...$.it(v)]), { from_iterable: (l) => [...$.it(l)].flatMap((v) => [...$.it(v)]) }),
    combinations: (v, n) => { const a = [...$.it(v)]; if (n !== 2) $.raise("ValueError", "combinations"); return a.flatMap((x, k) => a.slice(k + 1).map((y) => $.tup(x, y))); }, product: (...l) => l.reduce((s, v) => s.flatMap((x) => [...$.it(v)].map((y) => $.tup(...x, y))), [$.tup()]), count: function* (k = 0) { for (;;) yield k++; }, groupby: anything, takewhile: (f, v) => { const o = []; for (const x of $.it(v)) { if (!$.t(f(x))) break; o.push(x); } return o; }, accumulate: (v) => { let s = 0; return [...$.it(v)].map((x) => (s += x)); },
  });
  $.provide("functools", { partial: (f, ...first) => { const n = first[first.length - 1] instanceof $.Named ? first.pop().values : null; return (...rest) => (n ? $.k(f, [...first, ...rest], n) : f(...first, ...rest)); }, wraps: () => (f) => f, reduce: (f, v, s) => { const a = [...$.it(v)]; return s === undefined ? a.slice(1).reduce((x, y) => f(x, y), a[0]) : a.reduce((x, y) => f(x, y), s); }, lru_cache: () => $.memo, cached_property: anything });
  $.provide("dataclasses", { replace: (o, n) => { const C = o.constructor; return C(...C.$fields.map(([k]) => (n && k in n.values ? n.values[k] : o[k]))); }, asdict: as_dict, fields, field: anything, dataclass: anything });
  $.provide("contextlib", { suppress, contextmanager: (f) => f, nullcontext: () => ({}), AbstractContextManager: anything });
  $.provide("typing", { cast: (_t, v) => v, get_args: (t) => t.args ?? $.tup(), Literal: { $generic: (v) => ({ args: Array.isArray(v) ? $.tup(...v) : $.tup(v), $generic: (x) => x, __or__: () => anything }) }, Any: anything, NamedTuple: anything, Protocol: anything, TypeVar: () => anything, Generic: anything, ClassVar: anything, TYPE_CHECKING: false, Self: anything, TypeAlias: anything, BinaryIO: anything, ParamSpec: () => anything, overload: anything });
  $.provide("enum", { IntEnum: anything, Enum: anything });
  $.provide("abc", { ABC: anything, abstractmethod: (f) => f });
  $.provide("importlib", { import_module: (n) => $.imp(n) });
  $.provide("importlib.util", { find_spec: () => ({}) });
  $.provide("types", { MappingProxyType: (d) => d });
  $.provide("struct", { pack: (_s, n) => { const b = new Uint8Array(8); new DataView(b.buffer).setBigUint64(0, BigInt(n), true); return b; } });
  $.provide("uuid", { UUID: (o) => { const b = Uint8Array.from(o.values.bytes); b[6] = (b[6] & 0x0f) | 0x50; b[8] = (b[8] & 0x3f) | 0x80; const h = [...b].map((v) => v.toString(16).padStart(2, "0")).join(""); return { __str__: () => `${h.slice(0, 8)}-${h.slice(8, 12)}-${h.slice(12, 16)}-${h.slice(16, 20)}-${h.slice(20)}` }; } });
  $.provide("io", { StringIO: () => { let t = ""; return { write: (s) => { t += s; return null; }, getvalue: () => t }; }, BytesIO: anything });
  $.provide("keyword", { kwlist: [], iskeyword: () => false });
  $.provide("dehyst.export.rendering.templates", {});
  $.provide("pathlib", { Path: words("Path", (v) => new Place(v?.path ?? v?.name ?? $.b.str(v))) });
  $.provide("hashlib", library.hashlib);
  $.provide("dehyst.io.frames", { is_frame: () => false });
  $.provide("dehyst.io.formats", { read_table: (t) => t, PathLike: anything });
  $.provide("dehyst.data.plotted", anything);
}
/** Python values as JSON knows them. */
export function plain(v) {
  if (v === undefined || v === null) return null;
  if (typeof v === "number") return v;
  if (v instanceof NDArray) return v.tolist();
  if (v?.pairs) return Object.fromEntries(v.pairs().map(([k, w]) => [k, plain(w)]));
  if (Array.isArray(v) || v instanceof Range || v?.map instanceof Map) return [...v].map(plain);
  if (typeof v === "object" && v.constructor?.$fields) return Object.fromEntries(v.constructor.$fields.map(([k]) => [k, plain(v[k])]));
  return typeof v === "object" && typeof v.valueOf() === "number" ? v.valueOf() : v;
}

// ---- JSON as Python writes it, and its fingerprint
const FLOATS = new Set(["parameters", "low", "high", "typical", "most"]);
function dumps(value, o = {}) {
  const { sort_keys: sorted = false, separators, ensure_ascii: ascii = true, indent = null } = o;
  const [comma, colon] = separators ? [...separators] : [indent === null ? ", " : ",", ": "];
  const text = (s) => {
    const t = JSON.stringify(s);
    return ascii ? t.replace(/[\u007f-\uffff]/g, (ch) => "\\u" + ch.charCodeAt(0).toString(16).padStart(4, "0")) : t;
  };
  // Numbers of a model are floats, which Python writes with a point: all of its parameters, and ranges of signals.
  const pointed = (s) => (/^-?\d+$/.test(s) ? s + ".0" : s);
  const write = (v, depth, floats = false) => {
    if (v === null || v === undefined) return "null";
    if (typeof v === "string") return text(v);
    if (typeof v === "boolean") return v ? "true" : "false";
    if (typeof v === "number") { if (!Number.isFinite(v)) $.raise("ValueError", "Out of range float values are not JSON compliant"); return floats ? pointed($.b.repr(v)) : $.b.repr(v); }
    const gap = indent === null ? "" : "\n" + " ".repeat(indent * (depth + 1)), end = indent === null ? "" : "\n" + " ".repeat(indent * depth);
    if (v instanceof Dict) {
      let pairs = v.pairs();
      if (sorted) pairs = [...pairs].sort((a, b) => (a[0] < b[0] ? -1 : 1));
      return pairs.length ? `{${gap}${pairs.map(([k, w]) => `${text($.b.str(k))}${colon}${write(w, depth + 1, floats || FLOATS.has(k))}`).join(comma + gap)}${end}}` : "{}";
    }
    if (Array.isArray(v)) return v.length ? `[${gap}${[...v].map((w) => write(w, depth + 1, floats)).join(comma + gap)}${end}]` : "[]";
    return $.raise("TypeError", `Object of type ${v?.constructor?.name} is not JSON serializable`);
  };
  return write(value, 0);
}
const python = (v) => (Array.isArray(v) ? v.map(python) : v && typeof v === "object" ? $.dict(Object.entries(v).map(([k, w]) => [k, python(w)])) : v);
const primes = [];
for (let n = 2; primes.length < 64; n++) if (primes.every((p) => n % p)) primes.push(n);
const part = (v) => ((v - Math.floor(v)) * 2 ** 32) >>> 0;
const rounds = Uint32Array.from(primes, (p) => part(Math.cbrt(p)));
/** SHA-256 (FIPS 180-4) in hexadecimal. */
export function sha256(data) {
  const n = data.length, blocks = Math.ceil((n + 9) / 64), w = new Uint32Array(64), h = Uint32Array.from(primes.slice(0, 8), (p) => part(Math.sqrt(p)));
  const tail = new Uint8Array(blocks * 64 - Math.floor(n / 64) * 64);
  tail.set(data.subarray(Math.floor(n / 64) * 64));
  tail[n % 64] = 0x80;
  new DataView(tail.buffer).setBigUint64(tail.length - 8, BigInt(n) * 8n);
  for (let b = 0; b < blocks; b++) {
    const [from, at] = b < Math.floor(n / 64) ? [data, b * 64] : [tail, (b - Math.floor(n / 64)) * 64];
    for (let k = 0; k < 16; k++) w[k] = (from[at + 4 * k] << 24) | (from[at + 4 * k + 1] << 16) | (from[at + 4 * k + 2] << 8) | from[at + 4 * k + 3];
    for (let k = 16; k < 64; k++) {
      const x = w[k - 15], y = w[k - 2];
      w[k] = (w[k - 16] + w[k - 7] + (((x >>> 7) | (x << 25)) ^ ((x >>> 18) | (x << 14)) ^ (x >>> 3)) + (((y >>> 17) | (y << 15)) ^ ((y >>> 19) | (y << 13)) ^ (y >>> 10))) | 0;
    }
    let [a, i, j, d, e, f, g, q] = h;
    for (let k = 0; k < 64; k++) {
      const s = (q + (((e >>> 6) | (e << 26)) ^ ((e >>> 11) | (e << 21)) ^ ((e >>> 25) | (e << 7))) + ((e & f) ^ (~e & g)) + rounds[k] + w[k]) | 0;
      const t = ((((a >>> 2) | (a << 30)) ^ ((a >>> 13) | (a << 19)) ^ ((a >>> 22) | (a << 10))) + ((a & i) ^ (a & j) ^ (i & j))) | 0;
      q = g; g = f; f = e; e = (d + s) | 0; d = j; j = i; i = a; a = (s + t) | 0;
    }
    h[0] += a; h[1] += i; h[2] += j; h[3] += d; h[4] += e; h[5] += f; h[6] += g; h[7] += q;
  }
  return [...h].map((v) => v.toString(16).padStart(8, "0")).join("");
}
export const library = {
  json: { dumps: (v, o) => dumps(v, o?.values), loads: (t) => python(JSON.parse(t)), JSONDecodeError: $.b.ValueError },
  hashlib: { sha256: (data) => { let all = data ?? new Uint8Array(0); return { update: (more) => { const b = new Uint8Array(all.length + more.length); b.set(all); b.set(more, all.length); all = b; return null; }, hexdigest: () => sha256(all), digest: () => Uint8Array.from(sha256(all).match(/../g), (h) => parseInt(h, 16)) }; } },
};
