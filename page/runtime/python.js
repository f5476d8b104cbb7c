/* What Python does at run time, as far as the rooms of the package that the page carries need it. Lists and tuples are
 * arrays (a tuple is marked), dictionaries and sets keep the order of their keys, None is null, numbers are doubles. */

export const $ = {};
const TUPLE = Symbol("tuple");

// ---- modules
const waiting = new Map();
const ready = new Map();
$.module = (name, fill) => waiting.set(name, fill);
$.provide = (name, members) => ready.set(name, members);
function load(name) {
  if (ready.has(name)) return ready.get(name);
  const fill = waiting.get(name);
  if (!fill) return null;
  const made = {};
  ready.set(name, made);
  fill(made);
  return made;
}
/* Something that the page does not carry: may be named, not used. */
function absent(name) {
  const nothing = function () { throw new Error(`the page does not carry ${name}`); };
  nothing.$absent = name;
  return new Proxy(nothing, {
    get: (f, key) => (key in f || typeof key === "symbol" ? f[key] : absent(`${name}.${key}`)),
  });
}
$.imp = (name) => load(name) ?? absent(name);
$.from = (module, name) => {
  const found = load(module);
  if (found && name in found) return found[name];
  return load(`${module}.${name}`) ?? absent(`${module}.${name}`);
};

// ---- functions and classes
$.def = (f, told) => {
  f.$p = told.p;
  if (told.va) f.$va = true;
  if (told.ks) f.$ks = true;
  return f;
};
class Named {
  constructor(values) { this.values = { ...values }; }
  take(name, other) {
    if (!(name in this.values)) return other();
    const value = this.values[name];
    delete this.values[name];
    return value;
  }
  rest() { return $.dict(Object.entries(this.values)); }
}
$.Named = Named;
$.popkw = (args) => (args.length && args[args.length - 1] instanceof Named ? args.pop() : new Named({}));
function arranged(f, args, named) {
  if (f.$va || !f.$p) return [...args, new Named(named)];
  const all = args.slice();
  let rest = null;
  for (const name in named) {
    const at = f.$p.indexOf(name);
    if (at >= 0) all[at] = named[name];
    else if (f.$ks) (rest ??= {})[name] = named[name];
    else throw new Error(`no parameter ${name} of (${f.$p})`);
  }
  if (rest) all[f.$p.length] = $.dict(Object.entries(rest));
  return all;
}
/* A call with as many arguments as a log has rows: the stack holds no more than some ten thousands, so what takes
 * any number of them also takes them as one list, `$all`. */
const many = (f, all) => Object.assign(f, { $all: all });
$.star = (f, args) => (f.$all ? f.$all(args, {}) : f(...args));
$.k = (f, args, named) => (f.$all ? f.$all(args, named) : f(...arranged(f, args, named)));
$.km = (o, name, args, named) => {
  const f = o[name];
  if (typeof f !== "function") return $.cm(o, name, args, named);
  return f.apply(o, arranged(f, args, named));
};
$.memo = (f) => {
  const kept = new Map();
  return $.def((...args) => {
    const key = args.map(keyOf).join("\u0001");
    if (!kept.has(key)) kept.set(key, f(...args));
    return kept.get(key);
  }, { p: f.$p ?? [] });
};

$.cls = (name, bases, kind, own, data, eq, fill) => {
  const base = bases.find((b) => typeof b === "function" && !b.$absent);
  const fields = [...(base?.$fields ?? [])];
  for (const field of own) {
    const at = fields.findIndex((f) => f[0] === field[0]);
    if (at >= 0) fields[at] = field;
    else fields.push(field);
  }
  const C = function (...args) {
    let self;
    if (kind === "NamedTuple") {
      self = [];
      Object.setPrototypeOf(self, C.prototype);
      fill_fields(args, fields, (_name, value) => self.push(value));
      return self;
    }
    if ("__call__" in C.prototype) {
      self = (...given) => self.__call__(...given);
      delete self.name;
      delete self.length;
      Object.setPrototypeOf(self, C.prototype);
      self.$p = C.prototype.__call__.$p;
    } else self = Object.create(C.prototype);
    if (C.$error) self.stack = new Error(name).stack;
    if (C.prototype.__init__) C.prototype.__init__.apply(self, args);
    else if (C.$fields) {
      fill_fields(args, C.$fields, (key, value) => { self[key] = value; });
      self.__post_init__?.();
    }
    return self;
  };
  const proto = kind === "NamedTuple" ? Array.prototype : base ? base.prototype : Object.prototype;
  C.prototype = Object.create(proto);
  Object.defineProperty(C.prototype, "constructor", { value: C });
  if (base) Object.setPrototypeOf(C, base);
  Object.defineProperty(C, "name", { value: name });
  if (base?.$error) C.$error = true;
  C.__name__ = name;
  if (data || kind === "NamedTuple") {
    C.$fields = fields;
    C.$p = fields.map((f) => f[0]);
    C.$eq = data && eq;
  }
  if (kind === "NamedTuple") {
    fields.forEach(([key], k) => Object.defineProperty(C.prototype, key, { get() { return this[k]; } }));
    C.prototype._replace = $.def(function (named) {
      return C(...fields.map(([key], k) => (named && key in named.values ? named.values[key] : this[k])));
    }, { p: undefined });
    C.prototype._replace.$p = undefined;
    Object.defineProperty(C.prototype, TUPLE, { value: true });
  }
  if (kind === "IntEnum" || kind === "Enum") C.$enum = [];
  fill(C);
  return C;
};
function fill_fields(args, fields, set) {
  let named = null;
  if (args.length && args[args.length - 1] instanceof Named) named = args.pop().values;
  fields.forEach(([key, other], k) => {
    let value = k < args.length ? args[k] : undefined;
    if (value === undefined && named && key in named) value = named[key];
    if (value === undefined) {
      if (other === null) throw new Error(`field ${key} is missing`);
      value = other();
    }
    set(key, value);
  });
}
class Member {
  constructor(name, value) { this.name = name; this.value = value; }
  valueOf() { return this.value; }
  toString() { return String(this.value); }
}
$.static = (C, name, value) => {
  if (C.$enum) {
    const member = new Member(name, value);
    Object.setPrototypeOf(member, Object.create(C.prototype, {
      valueOf: { value: Member.prototype.valueOf }, toString: { value: Member.prototype.toString },
    }));
    C.$enum.push(member);
    value = member;
  }
  Object.defineProperty(C, name, { value, configurable: true, writable: true, enumerable: true });
  if (!C.$enum) Object.defineProperty(C.prototype, name, { value, configurable: true, writable: true });
};
$.meth = (C, name, f) => {
  Object.defineProperty(C.prototype, name, { value: f, configurable: true, writable: true });
  if (name === "__init__") { C.$p = f.$p; C.$va = f.$va; C.$ks = f.$ks; }
  if (name === "__call__") C.prototype.$p = f.$p;
  Object.defineProperty(C, name, {
    value: $.def((self, ...args) => f.apply(self, args), { p: f.$p && ["self", ...f.$p], va: f.$va, ks: f.$ks }),
    configurable: true, writable: true,
  });
};
$.smeth = (C, name, f) => {
  for (const holder of [C, C.prototype]) Object.defineProperty(holder, name, { value: f, configurable: true, writable: true });
};
$.cmeth = (C, name, f) => {
  Object.defineProperty(C, name, { value: f, configurable: true, writable: true });
  Object.defineProperty(C.prototype, name, {
    value: $.def(function (...args) { return f.apply(this.constructor, args); }, { p: f.$p, va: f.$va, ks: f.$ks }),
    configurable: true,
  });
};
$.prop = (C, name, f) => Object.defineProperty(C.prototype, name, {
  get() { return f.call(this); },
  set(value) { Object.defineProperty(this, name, { value, configurable: true, writable: true, enumerable: true }); },
  configurable: true,
});
$.cached = (C, name, f) => Object.defineProperty(C.prototype, name, {
  get() {
    const value = f.call(this);
    Object.defineProperty(this, name, { value, configurable: true, writable: true, enumerable: false });
    return value;
  },
  configurable: true,
});
$.supcall = (C, self, name, args, named) => {
  const f = Object.getPrototypeOf(C.prototype)[name];
  if (!f) {
    if (name === "__init__" || name === "__post_init__") return null;
    throw new Error(`super().${name}`);
  }
  return f.apply(self, named ? arranged(f, args, named) : args);
};
$.sup = (C, self) => new Proxy({}, { get: (_o, name) => Object.getPrototypeOf(C.prototype)[name].bind(self) });
$.seta = (o, name, value) => {
  Object.defineProperty(o, name, { value, configurable: true, writable: true, enumerable: true });
};

// ---- errors
function error(name, base) {
  const C = $.cls(name, base ? [base] : [], "", [], false, false, () => undefined);
  C.$error = true;
  return C;
}
$.b = {};
$.b.BaseException = error("BaseException");
$.b.BaseException.prototype.__init__ = $.def(function (...args) { this.args = $.tup(...args); }, { p: [], va: true });
$.b.BaseException.$va = true;
$.b.BaseException.prototype.__str__ = function () { return this.args.length ? $.b.str(this.args[0]) : ""; };
$.b.BaseException.prototype.toString = function () { return `${this.constructor.name}: ${$.b.str(this)}`; };
$.b.BaseException.prototype.with_traceback = function () { return this; };
for (const line of [
  "Exception BaseException", "ValueError Exception", "TypeError Exception", "LookupError Exception", "KeyError LookupError",
  "IndexError LookupError", "RuntimeError Exception", "NotImplementedError RuntimeError", "OSError Exception",
  "FileNotFoundError OSError", "PermissionError OSError", "IsADirectoryError OSError", "AttributeError Exception",
  "AssertionError Exception", "ArithmeticError Exception", "OverflowError ArithmeticError",
  "ZeroDivisionError ArithmeticError", "StopIteration Exception", "UnicodeError ValueError",
  "UnicodeDecodeError UnicodeError", "MemoryError Exception", "Warning Exception", "UserWarning Warning",
  "DeprecationWarning Warning", "ImportError Exception", "ModuleNotFoundError ImportError",
]) {
  const [name, base] = line.split(" ");
  $.b[name] = error(name, $.b[base]);
  $.b[name].$va = true;
}
$.exc = (e) => (typeof e === "function" && e.$error && !("args" in e) ? e() : e);
$.caught = (e) => {
  if (e instanceof RangeError && /memory|array/i.test(e.message)) return $.b.MemoryError(e.message);
  return e;
};
$.raise = (name, message) => { throw $.b[name](message); };
$.enter = (c) => (c?.__enter__ ? c.__enter__() : c);
$.exit = (c, e) => (c?.__exit__ ? $.t(c.__exit__(null, e, null)) : false);

// ---- values
export class Slice { constructor(start, stop, step) { this.start = start; this.stop = stop; this.step = step; } }
$.slice = (a, b, c) => new Slice(a, b, c);
$.tuple = (values) => Object.defineProperty(values, TUPLE, { value: true }); // an array of its own
$.tup = (...values) => $.tuple(values);
export const isTuple = (v) => Array.isArray(v) && v[TUPLE] === true;
$.bytes = (values) => Uint8Array.from(values);
$.ellipsis = Symbol("...");

export class Range {
  constructor(start, stop, step) { this.start = start; this.stop = stop; this.step = step; }
  get length() { return Math.max(0, Math.ceil((this.stop - this.start) / this.step)); }
  *[Symbol.iterator]() { for (let k = 0, n = this.length; k < n; k++) yield this.start + k * this.step; }
  at(k) { return this.start + (k < 0 ? k + this.length : k) * this.step; }
}

function keyOf(key) {
  if (typeof key === "string") return "s" + key;
  if (typeof key === "number") return key;
  if (typeof key === "boolean") return Number(key);
  if (key === null || key === undefined) return "n";
  if (Array.isArray(key)) return "(" + key.map(keyOf).join("\u0000") + ")";
  if (key instanceof PySet) return "f" + [...key.map.keys()].sort().join("\u0000");
  if (key.constructor?.$eq) return key.constructor.name + "(" + key.constructor.$fields.map((f) => keyOf(key[f[0]])).join("\u0000") + ")";
  return key;
}
export class Dict {
  constructor(pairs = []) { this.map = new Map(); for (const [k, v] of pairs) this.set(k, v); }
  set(k, v) { const key = keyOf(k), had = this.map.get(key); if (had) had[1] = v; else this.map.set(key, [k, v]); }
  has(k) { return this.map.has(keyOf(k)); }
  lookup(k) { return this.map.get(keyOf(k)); }
  delete(k) { return this.map.delete(keyOf(k)); }
  get length() { return this.map.size; }
  *[Symbol.iterator]() { for (const [k] of this.map.values()) yield k; }
  pairs() { return [...this.map.values()]; }
}
export class PySet {
  constructor(values = []) { this.map = new Map(); for (const v of values) this.put(v); }
  put(v) { const key = keyOf(v); if (!this.map.has(key)) this.map.set(key, v); }
  has(v) { return this.map.has(keyOf(v)); }
  get length() { return this.map.size; }
  [Symbol.iterator]() { return this.map.values(); }
}
$.dict = (pairs = []) => new Dict(pairs);
$.pairs = (d) => (d instanceof Dict ? d.pairs() : Object.entries(d));
$.obj = (d) => Object.fromEntries($.pairs(d));

export const nd = { NDArray: class {}, ops: null }; // numpy.js puts its own here
const isArray = (v) => v instanceof nd.NDArray;

$.it = (v) => {
  if (typeof v === "string" || v?.[Symbol.iterator]) return v;
  if (v?.__iter__) return v.__iter__();
  if (v?.__getitem__ && v?.__len__) return Array.from({ length: v.__len__() }, (_, k) => v.__getitem__(k));
  return $.raise("TypeError", "not iterable");
};
$.unpack = (v, n, star) => {
  const all = Array.isArray(v) ? v : [...$.it(v)];
  if (star < 0) {
    if (all.length !== n) $.raise("ValueError", `expected ${n} values to unpack, got ${all.length}`);
    return all;
  }
  const after = n - star - 1;
  if (all.length < n - 1) $.raise("ValueError", "not enough values to unpack");
  return [...all.slice(0, star), all.slice(star, all.length - after), ...(after ? all.slice(-after) : [])];
};
$.t = (v) => {
  if (typeof v === "boolean") return v;
  if (v === null || v === undefined) return false;
  if (typeof v === "number") return v !== 0;
  if (typeof v === "string") return v.length > 0;
  if (isArray(v)) return v.truth();
  if (Array.isArray(v) || v instanceof Uint8Array) return v.length > 0;
  if (typeof v === "object" || typeof v === "function") {
    if (v.__bool__) return $.t(v.__bool__());
    if (v.__len__) return v.__len__() > 0;
    if (v instanceof Dict || v instanceof PySet || v instanceof Range) return v.length > 0;
    if (v instanceof Member || v.value !== undefined && v.valueOf !== Object.prototype.valueOf) return Number(v) !== 0;
  }
  return true;
};
$.and = (a, b) => ($.t(a) ? b() : a);
$.or = (a, b) => ($.t(a) ? a : b());

// ---- arithmetic
const numeric = (v) => typeof v === "number" || typeof v === "boolean";
function binary(name, f, dunder, other) {
  const run = (a, b) => {
    if (typeof a === "number" && typeof b === "number") return f(a, b);
    if (isArray(a) || isArray(b)) return nd.ops.binary(name, a, b);
    const special = other?.(a, b);
    if (special !== undefined) return special;
    if (a?.[dunder]) return a[dunder](b);
    const mirrored = "__r" + dunder.slice(2);
    if (b?.[mirrored]) return b[mirrored](a);
    if (numeric(a) && numeric(b)) return f(Number(a), Number(b));
    return f(Number(a), Number(b));
  };
  $[name] = run;
  $["i" + name] = (a, b) => (isArray(a) ? nd.ops.inplace(name, a, b) : Array.isArray(a) && name === "add" && !isTuple(a) ? ((() => { for (const v of [...$.it(b)]) a.push(v); })(), a) : run(a, b));
}
const joined = (a, b) => {
  if (typeof a === "string") return a + b;
  if (Array.isArray(a)) { const c = [...a, ...b]; return isTuple(a) ? $.tuple(c) : c; }
  if (a instanceof Uint8Array) { const c = new Uint8Array(a.length + b.length); c.set(a); c.set(b, a.length); return c; }
  return undefined;
};
const repeated = (a, b) => {
  if (typeof a === "string") return a.repeat(Math.max(0, b));
  if (typeof b === "string") return b.repeat(Math.max(0, a));
  if (Array.isArray(b)) [a, b] = [b, a];
  if (Array.isArray(a)) { const c = []; for (let k = 0; k < b; k++) for (const v of a) c.push(v); return isTuple(a) ? $.tuple(c) : c; }
  return undefined;
};
const setop = (f) => (a, b) => (a instanceof PySet ? f(a, b instanceof PySet ? b : new PySet($.it(b))) : typeof a === "boolean" && typeof b === "boolean" ? undefined : undefined);
binary("add", (a, b) => a + b, "__add__", joined);
binary("sub", (a, b) => a - b, "__sub__", setop((a, b) => new PySet([...a].filter((v) => !b.has(v)))));
binary("mul", (a, b) => a * b, "__mul__", repeated);
binary("div", (a, b) => a / b, "__truediv__");
binary("fdiv", (a, b) => Math.floor(a / b), "__floordiv__");
binary("mod", (a, b) => { const r = a % b; return r !== 0 && r < 0 !== b < 0 ? r + b : r; }, "__mod__");
binary("pow", (a, b) => (b === 2 ? a * a : b === 0.5 ? Math.sqrt(a) : a ** b), "__pow__");
binary("mm", () => $.raise("TypeError", "matmul"), "__matmul__");
const bits = (f, g) => (a, b) => (typeof a === "boolean" && typeof b === "boolean" ? f(a, b) : g?.(a, b));
binary("band", (a, b) => a & b, "__and__", (a, b) => (typeof a === "boolean" && typeof b === "boolean" ? a && b : setop((s, u) => new PySet([...s].filter((v) => u.has(v))))(a, b)));
binary("bor", (a, b) => a | b, "__or__", (a, b) => {
  if (typeof a === "boolean" && typeof b === "boolean") return a || b;
  if (a instanceof Dict) return new Dict([...a.pairs(), ...b.pairs()]);
  if (a instanceof PySet) return new PySet([...a, ...b]);
  if (typeof a === "function" || typeof b === "function") return [a, b];
  return undefined;
});
binary("bxor", (a, b) => a ^ b, "__xor__", bits((a, b) => a !== b));
binary("shl", (a, b) => a * 2 ** b, "__lshift__");
binary("shr", (a, b) => Math.floor(a / 2 ** b), "__rshift__");
$.neg = (a) => (typeof a === "number" ? -a : isArray(a) ? nd.ops.unary("neg", a) : -Number(a));
$.pos = (a) => a;
$.inv = (a) => (isArray(a) ? nd.ops.unary("inv", a) : typeof a === "boolean" ? !a : ~a);

$.eq = (a, b) => {
  if (a === b) return true;
  if (isArray(a) || isArray(b)) return nd.ops.binary("eq", a, b);
  if (a === null || a === undefined) return b === null || b === undefined;
  if (b === null || b === undefined) return false;
  if (numeric(a) && numeric(b)) return Number(a) === Number(b);
  if (Array.isArray(a)) return Array.isArray(b) && a.length === b.length && a.every((v, k) => $.t($.eq(v, b[k])));
  if (a instanceof Uint8Array) return b instanceof Uint8Array && a.length === b.length && a.every((v, k) => v === b[k]);
  if (a instanceof Dict) return b instanceof Dict && a.length === b.length && a.pairs().every(([k, v]) => b.has(k) && $.t($.eq(v, b.lookup(k)[1])));
  if (a instanceof PySet) return b instanceof PySet && a.length === b.length && [...a].every((v) => b.has(v));
  if (a.__eq__) return $.t(a.__eq__(b));
  if (a.constructor?.$eq && b.constructor === a.constructor) return a.constructor.$fields.every(([k]) => $.t($.eq(a[k], b[k])));
  if (typeof a === "object" && a.valueOf() !== a) return a.valueOf() === b.valueOf();
  return false;
};
$.ne = (a, b) => (isArray(a) || isArray(b) ? nd.ops.binary("ne", a, b) : !$.eq(a, b));
function ordered(a, b) {
  if (typeof a === "string") return a < b ? -1 : a > b ? 1 : 0;
  if (Array.isArray(a)) {
    for (let k = 0; k < Math.min(a.length, b.length); k++) if (!$.t($.eq(a[k], b[k]))) return ordered(a[k], b[k]);
    return a.length - b.length;
  }
  const [x, y] = [Number(a), Number(b)];
  return x < y ? -1 : x > y ? 1 : x === y ? 0 : NaN;
}
function comparison(name, f, subset) {
  $[name] = (a, b) => {
    if (typeof a === "number" && typeof b === "number") return f(a < b ? -1 : a > b ? 1 : a === b ? 0 : NaN);
    if (isArray(a) || isArray(b)) return nd.ops.binary(name, a, b);
    if (a instanceof PySet) return subset(a, b);
    if (name === "lt" && a?.__lt__) return $.t(a.__lt__(b));
    return f(ordered(a, b));
  };
}
const united = (s, sets) => new PySet([...s, ...sets.flatMap((x) => [...$.it(x)])]);
const within = (a, b) => [...a].every((v) => b.has(v));
comparison("lt", (o) => o < 0, (a, b) => a.length < b.length && within(a, b));
comparison("le", (o) => o <= 0, within);
comparison("gt", (o) => o > 0, (a, b) => a.length > b.length && within(b, a));
comparison("ge", (o) => o >= 0, (a, b) => within(b, a));
$.in = (v, c) => {
  if (typeof c === "string") return c.includes(v);
  if (c instanceof Dict || c instanceof PySet) return c.has(v);
  if (c?.__contains__) return $.t(c.__contains__(v));
  if (c instanceof Uint8Array) return typeof v === "number" ? c.includes(v) : find(c, v) >= 0;
  for (const each of $.it(c)) if ($.t($.eq(each, v))) return true;
  return false;
};
function find(data, part, from = 0) {
  outer: for (let k = from; k + part.length <= data.length; k++) {
    for (let j = 0; j < part.length; j++) if (data[k + j] !== part[j]) continue outer;
    return k;
  }
  return -1;
}

// ---- items
export function bounds(s, n) {
  const step = s.step ?? 1;
  const clip = (v, low, high) => (v === null || v === undefined ? null : Math.max(low, Math.min(high, v < 0 ? v + n : v)));
  if (step > 0) return [clip(s.start, 0, n) ?? 0, clip(s.stop, 0, n) ?? n, step];
  return [clip(s.start, -1, n - 1) ?? n - 1, s.stop === null || s.stop === undefined ? -1 : clip(s.stop, -1, n - 1), step];
}
$.gi = (o, i) => {
  if (i !== null && typeof i === "object" && typeof i.valueOf() === "number") i = i.valueOf();
  if (Array.isArray(o) || typeof o === "string" || o instanceof Uint8Array) {
    if (typeof i === "number" || typeof i === "boolean") {
      const at = i < 0 ? Number(i) + o.length : Number(i);
      if (!(at >= 0 && at < o.length)) $.raise("IndexError", "index out of range");
      return o[at];
    }
    if (i instanceof Slice) {
      const [a, b, c] = bounds(i, o.length);
      if (c === 1) return o instanceof Uint8Array ? o.subarray(a, Math.max(a, b)) : isTuple(o) ? $.tuple(Array.prototype.slice.call(o, a, b)) : Array.isArray(o) ? Array.prototype.slice.call(o, a, b) : o.slice(a, Math.max(a, b));
      const taken = [];
      for (let k = a; c > 0 ? k < b : k > b; k += c) taken.push(o[k]);
      return typeof o === "string" ? taken.join("") : o instanceof Uint8Array ? Uint8Array.from(taken) : taken;
    }
  }
  if (isArray(o)) return o.get(i);
  if (o instanceof Dict) {
    const found = o.lookup(i);
    if (!found) $.raise("KeyError", i);
    return found[1];
  }
  if (o instanceof Range) return o.at(i);
  if (o?.__getitem__) return o.__getitem__(i);
  if (o?.$absent !== undefined || typeof o === "function") return o; // Sequence[int], in an alias
  if (o?.$generic) return o.$generic(i);
  return $.raise("TypeError", "not subscriptable");
};
$.si = (o, i, v) => {
  if (isArray(o)) o.put(i, v);
  else if (o instanceof Dict) o.set(i, v);
  else if (Array.isArray(o)) {
    if (i instanceof Slice) {
      const [a, b] = bounds(i, o.length);
      o.splice(a, Math.max(0, b - a), ...$.it(v));
    } else o[i < 0 ? i + o.length : i] = v;
  } else o.__setitem__(i, v);
};
$.isi = (o, i, op, v) => $.si(o, i, op($.gi(o, i), v));
$.ia = (o, name, op, v) => { o[name] = op(o[name], v); };
$.di = (o, i) => { if (o instanceof Dict) o.delete(i); else if (i instanceof Slice) { const [a, b] = bounds(i, o.length); o.splice(a, b - a); } else o.splice(i < 0 ? i + o.length : i, 1); };

// ---- attributes and methods of what Python brings
$.ga = (o, name) => {
  if (o === null || o === undefined) $.raise("AttributeError", `None has no ${name}`);
  const v = o[name];
  if (name === "__name__" && typeof o === "function") return o.__name__ ?? o.name;
  if (name === "__class__") return o.constructor;
  if (v === undefined) {
    if (typeof o === "string" || Array.isArray(o) || o instanceof Dict || o instanceof PySet || o instanceof Uint8Array)
      return (...args) => $.cm(o, name, args);
    if (name === "__getitem__") return (i) => $.gi(o, i);
    if (name in o) return v;
    $.raise("AttributeError", `${o?.constructor?.name} has no ${name}`);
  }
  if (typeof v === "function" && typeof o === "object" && !Object.hasOwn(o, name) && !v.$class && !v.prototype?.constructor?.$fields) {
    if (Array.isArray(o) && !(name in Object.getPrototypeOf(o) && Object.getPrototypeOf(o) !== Array.prototype)) return (...args) => $.cm(o, name, args);
    if (v.__name__ !== undefined && v.$p === undefined) return v;
    return $.def((...args) => v.apply(o, args), { p: v.$p, va: v.$va, ks: v.$ks });
  }
  return v;
};
const blank = (c) => /\s/.test(c) || (c >= "\x1c" && c <= "\x1f");
function strip(s, chars, left, right) {
  const drop = chars === null || chars === undefined ? blank : (c) => chars.includes(c);
  let [a, b] = [0, s.length];
  if (left) while (a < b && drop(s[a])) a++;
  if (right) while (b > a && drop(s[b - 1])) b--;
  return s.slice(a, b);
}
const every = (s, test) => s.length > 0 && [...s].every((c) => test.test(c));
const S = {
  strip: (s, c) => strip(s, c, true, true), lstrip: (s, c) => strip(s, c, true, false), rstrip: (s, c) => strip(s, c, false, true),
  split: (s, by, most = -1) => {
    if (by === null || by === undefined) {
      const found = s.split(/\s+/).filter(Boolean);
      if (most < 0 || found.length <= most + 1) return found;
      const kept = [];
      let rest = strip(s, null, true, false);
      for (let k = 0; k < most; k++) { const m = /^\S+/.exec(rest); kept.push(m[0]); rest = strip(rest.slice(m[0].length), null, true, false); }
      return [...kept, strip(rest, null, false, true)];
    }
    const parts = s.split(by);
    return most < 0 || parts.length <= most + 1 ? parts : [...parts.slice(0, most), parts.slice(most).join(by)];
  },
  rsplit: (s, by, most = -1) => { const parts = s.split(by); return most < 0 || parts.length <= most + 1 ? parts : [parts.slice(0, parts.length - most).join(by), ...parts.slice(parts.length - most)]; },
  splitlines: (s) => { const p = s.split(/\r\n|[\n\r\v\f\x1c-\x1e\x85\u2028\u2029]/); if (p[p.length - 1] === "") p.pop(); return p; },
  join: (s, parts) => [...$.it(parts)].join(s),
  replace: (s, a, b, most) => (most === undefined ? s.replaceAll(a, () => b) : (() => { let t = s, out = ""; for (let k = 0; k < most; k++) { const at = t.indexOf(a); if (at < 0) break; out += t.slice(0, at) + b; t = t.slice(at + a.length); } return out + t; })()),
  startswith: (s, p) => (Array.isArray(p) ? p.some((q) => s.startsWith(q)) : s.startsWith(p)),
  endswith: (s, p) => (Array.isArray(p) ? p.some((q) => s.endsWith(q)) : s.endsWith(p)),
  lower: (s) => s.toLowerCase(), upper: (s) => s.toUpperCase(), casefold: (s) => s.toLowerCase().replaceAll("ß", "ss"),
  title: (s) => s.replace(/\p{L}+/gu, (w) => w[0].toUpperCase() + w.slice(1).toLowerCase()),
  capitalize: (s) => (s ? s[0].toUpperCase() + s.slice(1).toLowerCase() : s),
  isdigit: (s) => every(s, /^\p{Nd}$/u), isdecimal: (s) => every(s, /^\p{Nd}$/u), isalpha: (s) => every(s, /^\p{L}$/u), isalnum: (s) => every(s, /^[\p{L}\p{N}]$/u),
  isspace: (s) => every(s, /^\s$/), isascii: (s) => /^[\x00-\x7f]*$/.test(s), isupper: (s) => s !== s.toLowerCase() && s === s.toUpperCase(), islower: (s) => s !== s.toUpperCase() && s === s.toLowerCase(),
  isprintable: (s) => [...s].every((c) => c === " " || !/[\p{C}\p{Z}]/u.test(c)), isidentifier: (s) => /^[\p{L}_][\p{L}\p{N}_]*$/u.test(s),
  find: (s, p, from = 0) => s.indexOf(p, from), rfind: (s, p) => s.lastIndexOf(p), index: (s, p) => { const k = s.indexOf(p); if (k < 0) $.raise("ValueError", "substring not found"); return k; },
  rindex: (s, p) => { const k = s.lastIndexOf(p); if (k < 0) $.raise("ValueError", "substring not found"); return k; },
  count: (s, p) => (p === "" ? s.length + 1 : s.split(p).length - 1),
  partition: (s, p) => { const k = s.indexOf(p); return k < 0 ? $.tup(s, "", "") : $.tup(s.slice(0, k), p, s.slice(k + p.length)); },
  rpartition: (s, p) => { const k = s.lastIndexOf(p); return k < 0 ? $.tup("", "", s) : $.tup(s.slice(0, k), p, s.slice(k + p.length)); },
  encode: (s, e) => (e === "latin-1" ? Uint8Array.from(s, (c) => c.charCodeAt(0)) : new TextEncoder().encode(s)), zfill: (s, n) => (/^[+-]/.test(s) ? s[0] + s.slice(1).padStart(n - 1, "0") : s.padStart(n, "0")),
  ljust: (s, n, c = " ") => s.padEnd(n, c), rjust: (s, n, c = " ") => s.padStart(n, c),
  removeprefix: (s, p) => (s.startsWith(p) ? s.slice(p.length) : s), removesuffix: (s, p) => (p && s.endsWith(p) ? s.slice(0, -p.length) : s),
  translate: (s, table) => [...s].map((c) => { const f = table.lookup(c.codePointAt(0)) ?? table.lookup(c); return f === undefined ? c : f[1] === null ? "" : typeof f[1] === "number" ? String.fromCodePoint(f[1]) : f[1]; }).join(""),
  format: (s, ...args) => {
    const named = args[args.length - 1] instanceof Named ? args.pop().values : {};
    return s.replace(/\{(\w*)(?::([^}]*))?\}/g, (_m, k, spec) => $.f(k in named ? named[k] : args[k === "" ? 0 : Number(k)], spec ?? "", -1));
  },
  expandtabs: (s) => s.replaceAll("\t", "        "),
};
const L = {
  append: (a, v) => { a.push(v); return null; }, extend: (a, v) => { for (const each of $.it(v)) a.push(each); return null; },
  insert: (a, k, v) => { a.splice(k, 0, v); return null; },
  pop: (a, k = -1) => { if (!a.length) $.raise("IndexError", "pop from empty list"); return a.splice(k < 0 ? k + a.length : k, 1)[0]; },
  index: (a, v) => { for (let k = 0; k < a.length; k++) if ($.t($.eq(a[k], v))) return k; return $.raise("ValueError", "not in list"); },
  count: (a, v) => a.reduce((n, each) => n + Number($.t($.eq(each, v))), 0),
  sort: (a, named) => { const s = $.b.sorted(a, named); a.splice(0, a.length, ...s); return null; },
  reverse: (a) => { Array.prototype.reverse.call(a); return null; }, copy: (a) => a.slice(), clear: (a) => { a.length = 0; return null; },
  remove: (a, v) => { a.splice(L.index(a, v), 1); return null; }, __getitem__: (a, k) => $.gi(a, k), __len__: (a) => a.length,
};
const D = {
  get: (d, k, other = null) => d.lookup(k)?.[1] ?? (d.has(k) ? d.lookup(k)[1] : other), items: (d) => d.pairs().map(([k, v]) => $.tup(k, v)), keys: (d) => [...d],
  values: (d) => d.pairs().map((p) => p[1]), setdefault: (d, k, v = null) => { if (!d.has(k)) d.set(k, v); return d.lookup(k)[1]; },
  update: (d, o, named) => { if (o && !(o instanceof Named)) for (const [k, v] of o instanceof Dict ? o.pairs() : $.it(o)) d.set(k, v); return null; },
  pop: (d, k, other) => { const f = d.lookup(k); d.delete(k); if (!f && other === undefined) $.raise("KeyError", k); return f ? f[1] : other; },
  copy: (d) => new Dict(d.pairs()), clear: (d) => { d.map.clear(); return null; }, __getitem__: (d, k) => $.gi(d, k),
  most_common: (d, n) => d.pairs().sort((a, b) => b[1] - a[1]).slice(0, n).map((p) => $.tup(...p)),
};
const T = {
  add: (s, v) => { s.put(v); return null; }, discard: (s, v) => { s.map.delete(keyOf(v)); return null; }, remove: (s, v) => { s.map.delete(keyOf(v)); return null; },
  union: many((s, ...o) => united(s, o), united), update: (s, ...o) => { for (const x of o) for (const v of $.it(x)) s.put(v); return null; },
  difference: (s, o) => { const u = new PySet($.it(o)); return new PySet([...s].filter((v) => !u.has(v))); },
  intersection: (s, o) => { const u = new PySet($.it(o)); return new PySet([...s].filter((v) => u.has(v))); },
  isdisjoint: (s, o) => ![...$.it(o)].some((v) => s.has(v)), issubset: (s, o) => within(s, new PySet($.it(o))), issuperset: (s, o) => [...$.it(o)].every((v) => s.has(v)),
  copy: (s) => new PySet(s), pop: (s) => { const [v] = s; s.map.delete(keyOf(v)); return v; }, clear: (s) => { s.map.clear(); return null; },
};
const B = {
  startswith: (b, p) => (Array.isArray(p) ? p.some((q) => B.startswith(b, q)) : p.length <= b.length && p.every((v, k) => b[k] === v)),
  endswith: (b, p) => p.every((v, k) => b[b.length - p.length + k] === v),
  isascii: (b) => { for (let k = 0; k < b.length; k++) if (b[k] > 127) return false; return true; },
  decode: (b, encoding = "utf-8", errors) => {
    let named = {};
    if (encoding instanceof Named) { named = encoding.values; encoding = "utf-8"; }
    if (errors instanceof Named) named = errors.values;
    if (encoding === "latin-1") { let t = ""; for (let k = 0; k < b.length; k += 8192) t += String.fromCharCode(...b.subarray(k, k + 8192)); return t; }
    const strict = (named.errors ?? errors) !== "replace";
    if (encoding === "utf-16") { encoding = b[0] === 0xfe ? "utf-16be" : "utf-16le"; b = b.subarray(2); }
    try { return new TextDecoder(encoding.replace("utf-16-", "utf-16"), { fatal: strict, ignoreBOM: true }).decode(b); } catch { return $.raise("UnicodeDecodeError", "not utf-8"); }
  },
  count: (b, v) => { let n = 0; for (let k = 0; k < b.length; k++) n += b[k] === v; return n; },
  find: (b, p, from = 0) => find(b, p, from), lstrip: (b, c) => { let k = 0; while (k < b.length && c.includes(b[k])) k++; return b.subarray(k); },
  hex: (b) => [...b].map((v) => v.toString(16).padStart(2, "0")).join(""), join: (b, parts) => [...$.it(parts)].reduce((x, y) => joined(x, y), new Uint8Array(0)),
};
const N = { is_integer: (v) => Number.isInteger(v), bit_length: (v) => (v === 0 ? 0 : Math.floor(Math.log2(Math.abs(v))) + 1), hex: (v) => hex_of(v), copy: (v) => v };
function hex_of(v) {
  if (v !== v) return "nan";
  if (!Number.isFinite(v)) return v > 0 ? "inf" : "-inf";
  const bits = new DataView(new ArrayBuffer(8));
  bits.setFloat64(0, v);
  const high = bits.getUint32(0), sign = high >>> 31 ? "-" : "", power = (high >>> 20) & 0x7ff;
  const digits = (high & 0xfffff).toString(16).padStart(5, "0") + bits.getUint32(4).toString(16).padStart(8, "0");
  if (power === 0) return v === 0 ? `${sign}0x0.0p+0` : `${sign}0x0.${digits}p-1022`;
  return `${sign}0x1.${digits}p${power >= 1023 ? "+" : ""}${power - 1023}`;
}
$.cm = (o, name, args, named) => {
  const table = typeof o === "string" ? S : Array.isArray(o) && !Object.hasOwn(Object.getPrototypeOf(o), name) ? L : o instanceof Dict ? D : o instanceof PySet ? T : o instanceof Uint8Array ? B : typeof o === "number" ? N : null;
  if (table?.[name]?.$all) return table[name].$all(o, args);
  if (table && table[name]) return table[name](o, ...args, ...(named ? [new Named(named)] : []));
  if (o === null || o === undefined) $.raise("AttributeError", `None has no ${name}`);
  if (typeof o[name] !== "function") $.raise("AttributeError", `${o.constructor?.name} has no ${name}`);
  return named ? o[name](...arranged(o[name], args, named)) : o[name](...args);
};

// ---- text of numbers
function exponent(text) { return text.replace(/e([+-])(\d)$/, "e$10$2"); }
function general(v, digits, alternate) {
  digits = digits === 0 ? 1 : digits;
  const power = v === 0 ? 0 : Number(v.toExponential(digits - 1).split("e")[1]);
  let text = power < -4 || power >= digits ? exponent(v.toExponential(digits - 1)) : v.toFixed(Math.max(0, digits - 1 - power));
  if (!alternate && text.includes(".")) text = text.replace(/\.?0+(?=e|$)/, "");
  return text;
}
export function repr_number(v) {
  if (Number.isNaN(v)) return "nan";
  if (!Number.isFinite(v)) return v > 0 ? "inf" : "-inf";
  if (Object.is(v, -0)) return "-0.0";
  const size = Math.abs(v);
  if (size !== 0 && (size < 1e-4 || size >= 1e16)) return exponent(v.toExponential());
  return String(v);
}
$.f = (v, spec, conversion) => {
  if (conversion === 114) v = $.b.repr(v);
  else if (conversion === 115) v = $.b.str(v);
  if (spec === "") return $.b.str(v);
  if (v?.__format__) return v.__format__(spec);
  const m = /^(?:(.)?([<>^=]))?([+\- ])?(#)?(0)?(\d+)?([,_])?(?:\.(\d+))?([a-zA-Z%])?$/.exec(spec);
  if (!m) throw new Error(`format ${spec}`);
  let [, fill = " ", align, sign, alternate, zero, width, group, digits, type] = m;
  let text;
  if (typeof v === "bigint") return v.toString(16).padStart(Number(width ?? 0), zero ?? fill);
  if (typeof v === "string" || Array.isArray(v)) {
    text = $.b.str(v);
    if (digits !== undefined) text = text.slice(0, Number(digits));
    align ??= "<";
  } else {
    v = Number(v);
    const places = digits === undefined ? 6 : Number(digits);
    const size = Math.abs(v);
    if (!Number.isFinite(v)) text = Number.isNaN(v) ? "nan" : "inf";
    else if (type === "f" || type === "F") text = size >= 1e21 ? BigInt(Math.round(size)).toString() + (places ? "." + "0".repeat(places) : "") : size.toFixed(places);
    else if (type === "e") text = exponent(size.toExponential(places));
    else if (type === "%") text = (100 * size).toFixed(places) + "%";
    else if (type === "g" || (type === undefined && digits !== undefined)) text = general(size, places, alternate);
    else if (type === "x") text = size.toString(16);
    else if (type === "b") text = size.toString(2);
    else text = type === "d" ? String(Math.round(size)) : repr_number(size);
    if (type === "f" || type === "e" || type === "g") text = even(size, text, type, places, alternate);
    if (group) text = text.replace(/^\d+/, (d) => d.replace(/\B(?=(\d{3})+$)/g, group));
    const minus = v < 0 || Object.is(v, -0) ? "-" : sign === "+" ? "+" : sign === " " ? " " : "";
    if (zero && !align) text = minus + text.padStart(Number(width ?? 0) - minus.length, "0");
    else text = minus + text;
    align ??= ">";
  }
  const room = Number(width ?? 0) - text.length;
  if (room <= 0) return text;
  if (align === "<") return text + fill.repeat(room);
  if (align === "^") return fill.repeat(room >> 1) + text + fill.repeat(room - (room >> 1));
  return fill.repeat(room) + text;
};
/* JavaScript rounds a half away from zero, Python to even: they differ where the decimal is exact. */
function even(size, text, type, places, alternate) {
  const scaled = type === "f" ? size * 10 ** places : NaN;
  if (type === "f" && places < 16 && scaled < 2 ** 52 && scaled % 1 === 0.5 && size === scaled / 10 ** places && exactHalf(size, places)) {
    const down = Math.floor(scaled);
    if (down % 2 === 0) return (down / 10 ** places).toFixed(places);
  }
  if (type !== "f" && size !== 0) {
    const wanted = type === "e" ? places : Math.max(places, 1) - 1;
    const power = Math.floor(Math.log10(size));
    const left = wanted - power;
    if (left >= 0 && left < 16) {
      const s = size * 10 ** left;
      if (s % 1 === 0.5 && s < 2 ** 52 && exactHalf(size, left) && Math.floor(s) % 2 === 0) {
        const down = Math.floor(s) / 10 ** left;
        return type === "e" ? exponent(down.toExponential(places)) : general(down, places, alternate);
      }
    }
  }
  return text;
}
function exactHalf(size, places) { return Number.isInteger(size * 2 ** (places + 1)); }
function quote(s) {
  const mark = s.includes("'") && !s.includes('"') ? '"' : "'";
  return mark + s.replace(/\\/g, "\\\\").replaceAll(mark, "\\" + mark).replace(/\n/g, "\\n").replace(/\r/g, "\\r").replace(/\t/g, "\\t")
    .replace(/[\x00-\x1f\x7f]/g, (c) => "\\x" + c.charCodeAt(0).toString(16).padStart(2, "0")) + mark;
}
$.b.repr = (v) => {
  if (typeof v === "string") return quote(v);
  if (typeof v === "number") return repr_number(v);
  if (typeof v === "boolean") return v ? "True" : "False";
  if (v === null || v === undefined) return "None";
  if (Array.isArray(v)) { const t = [...v].map($.b.repr).join(", "); return isTuple(v) ? `(${t}${v.length === 1 ? "," : ""})` : `[${t}]`; }
  if (v instanceof Dict) return `{${v.pairs().map(([k, w]) => `${$.b.repr(k)}: ${$.b.repr(w)}`).join(", ")}}`;
  if (v instanceof PySet) return `{${[...v].map($.b.repr).join(", ")}}`;
  if (v.__repr__) return v.__repr__();
  if (v.constructor?.$fields) return `${v.constructor.name}(${v.constructor.$fields.map(([k]) => `${k}=${$.b.repr(v[k])}`).join(", ")})`;
  return String(v);
};
$.b.str = (v = "") => (typeof v === "string" ? v : v?.__str__ && typeof v !== "function" ? v.__str__() : $.b.repr(v));

// ---- builtins
const kind = (name, test, make) => { const f = make ?? (() => $.raise("TypeError", name)); f.$inst = test; f.__name__ = name; return f; };
const number = (v) => {
  if (typeof v === "string") {
    const t = strip(v, null, true, true).replace(/(?<=\d)_(?=\d)/g, "");
    if (/^[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?$/.test(t)) return Number(t);
    const word = /^([+-]?)(inf|infinity|nan)$/i.exec(t);
    if (word) return word[2].toLowerCase() === "nan" ? NaN : word[1] === "-" ? -Infinity : Infinity;
    return $.raise("ValueError", `could not convert string to float: ${quote(v)}`);
  }
  if (v === null || v === undefined) return $.raise("TypeError", "float() argument must be a string or a real number, not 'NoneType'");
  if (isArray(v)) return v.item();
  if (Array.isArray(v) || v instanceof Dict) return $.raise("TypeError", "float() argument must be a string or a real number");
  if (v.__float__) return v.__float__();
  return Number(v);
};
const listed = (v) => (v === undefined ? [] : [...$.it(v)]);
function zipped(lists, { strict }) {
  const all = lists.map((v) => (Array.isArray(v) ? v : [...$.it(v)]));
  const n = all.reduce((least, v) => Math.min(least, v.length), all.length ? Infinity : 0);
  if (strict && all.some((v) => v.length !== n)) $.raise("ValueError", "zip() arguments differ in length");
  return Array.from({ length: n }, (_, k) => $.tuple(all.map((v) => v[k])));
}
const best = (sign) => (...args) => {
  const { key, ...rest } = args[args.length - 1] instanceof Named ? args.pop().values : {};
  const all = args.length === 1 ? [...$.it(args[0])] : args;
  if (!all.length) return "default" in rest ? rest.default : $.raise("ValueError", "empty sequence");
  let found = all[0], value = key ? key(found) : found;
  for (let k = 1; k < all.length; k++) {
    const other = key ? key(all[k]) : all[k];
    if (sign > 0 ? $.gt(other, value) : $.lt(other, value)) [found, value] = [all[k], other];
  }
  return found;
};
Object.assign($.b, {
  int: kind("int", (v) => typeof v === "number" && Number.isInteger(v) || typeof v === "boolean", (v = 0, base) => {
    if (typeof v === "bigint") return v;
    if (typeof v === "string") {
      const t = strip(v, null, true, true);
      if (base === 16) return parseInt(t, 16);
      if (!/^[+-]?\d+(_\d+)*$/.test(t)) $.raise("ValueError", `invalid literal for int() with base 10: ${quote(v)}`);
      return Number(t.replaceAll("_", ""));
    }
    const n = number(v);
    if (Number.isNaN(n)) $.raise("ValueError", "cannot convert float NaN to integer");
    if (!Number.isFinite(n)) $.raise("OverflowError", "cannot convert float infinity to integer");
    return Math.trunc(n) + 0;
  }),
  float: kind("float", (v) => typeof v === "number", (v = 0) => number(v)),
  complex: kind("complex", () => false),
  bool: kind("bool", (v) => typeof v === "boolean", (v) => $.t(v)),
  str: kind("str", (v) => typeof v === "string", $.b.str),
  bytes: kind("bytes", (v) => v instanceof Uint8Array, (v) => Uint8Array.from($.it(v))),
  bytearray: kind("bytearray", () => false),
  list: kind("list", (v) => Array.isArray(v) && !isTuple(v), listed),
  tuple: kind("tuple", isTuple, (v) => $.tuple(listed(v))),
  dict: kind("dict", (v) => v instanceof Dict, (...args) => {
    const named = args[args.length - 1] instanceof Named ? args.pop().values : {};
    const from = args[0];
    return new Dict([...(from instanceof Dict ? from.pairs() : from ? $.it(from) : []), ...Object.entries(named)]);
  }),
  set: kind("set", (v) => v instanceof PySet, (v) => new PySet(listed(v))),
  frozenset: kind("frozenset", (v) => v instanceof PySet, (v) => new PySet(listed(v))),
  object: kind("object", () => true), property: kind("property", () => false),
  type: kind("type", (v) => typeof v === "function", (v) => (typeof v === "number" ? $.b.float : typeof v === "string" ? $.b.str : v === null || v === undefined ? { __name__: "NoneType" } : Array.isArray(v) && !v.constructor?.$fields ? (isTuple(v) ? $.b.tuple : $.b.list) : v instanceof Dict ? $.b.dict : v.constructor)),
  slice: (a, b, c) => (b === undefined ? new Slice(null, a, null) : new Slice(a, b, c ?? null)),
  range: (a, b, c = 1) => (b === undefined ? new Range(0, a, 1) : new Range(a, b, c)),
  len: (v) => (isArray(v) ? v.shape[0] : v.__len__ ? v.__len__() : typeof v === "string" && /[\ud800-\udbff]/.test(v) ? [...v].length : v.length),
  abs: (v) => (isArray(v) ? nd.ops.unary("abs", v) : Math.abs(v)),
  all: (v) => { for (const each of $.it(v)) if (!$.t(each)) return false; return true; },
  any: (v) => { for (const each of $.it(v)) if ($.t(each)) return true; return false; },
  callable: (v) => typeof v === "function", chr: (v) => String.fromCodePoint(v), ord: (v) => v.codePointAt(0),
  divmod: (a, b) => $.tup(Math.floor(a / b), $.mod(a, b)),
  enumerate: function* (v, start = 0) { if (start instanceof Named) start = start.values.start; let k = start; for (const each of $.it(v)) yield $.tup(k++, each); },
  filter: (f, v) => [...$.it(v)].filter((each) => $.t(f ? f(each) : each)),
  map: (f, ...lists) => { const named = lists.map((v) => [...$.it(v)]); return named[0].slice(0, Math.min(...named.map((v) => v.length))).map((_, k) => f(...named.map((v) => v[k]))); },
  zip: many((...lists) => zipped(lists, lists[lists.length - 1] instanceof Named ? lists.pop().values : {}), zipped),
  sorted: (v, named) => {
    const { key, reverse } = named?.values ?? {};
    const made = [...$.it(v)].map((each, k) => [key ? key(each) : each, k, each]);
    made.sort((a, b) => ($.t($.lt(a[0], b[0])) ? -1 : $.t($.lt(b[0], a[0])) ? 1 : 0) * (reverse ? -1 : 1) || a[1] - b[1]);
    return made.map((m) => m[2]);
  },
  reversed: (v) => [...$.it(v)].reverse(),
  sum: (v, start = 0) => { let s = start; for (const each of $.it(v)) s = $.add(s, each); return s; },
  max: best(1), min: best(-1),
  round: (v, digits) => {
    if (isArray(v)) return nd.np.round(v, digits ?? 0);
    if (digits === undefined || digits === null) { const f = Math.floor(v), r = v - f; return r < 0.5 ? f : r > 0.5 ? f + 1 : f % 2 === 0 ? f : f + 1; }
    return Number($.f(v, `.${digits}f`, -1));
  },
  pow: (a, b) => a ** b, iter: (v) => $.it(v)[Symbol.iterator](), hash: keyOf, id: (v) => v, print: () => null, vars: (v) => new Dict(Object.entries(v)), open: () => $.raise("OSError", "no files here"),
  next: (v, other) => {
    const it = typeof v.next === "function" ? v : v[Symbol.iterator]();
    const { value, done } = it.next();
    if (done) return other === undefined ? $.raise("StopIteration") : other;
    return value;
  },
  getattr: (o, name, other) => { const v = o?.[name]; if (v === undefined) { if (other === undefined) $.raise("AttributeError", name); return other; } return $.ga(o, name); },
  hasattr: (o, name) => o !== null && o !== undefined && o[name] !== undefined,
  setattr: (o, name, v) => { o[name] = v; return null; },
  isinstance: (v, t) => $.isinst(v, t), issubclass: (a, b) => a === b || a?.prototype instanceof b,
  NotImplemented: Symbol("NotImplemented"),
});
$.b.object.__setattr__ = (...a) => $.seta(...a);
$.b.dict.fromkeys = (keys, v = null) => new Dict([...$.it(keys)].map((k) => [k, v]));
$.b.str.maketrans = (a, b) => (a instanceof Dict ? a : new Dict([...a].map((c, k) => [c, [...b][k]])));
$.b.float.fromhex = Number;
$.b.int.from_bytes = (b, order) => [...(order === "little" ? [...b].reverse() : b)].reduce((s, v) => s * 256 + v, 0);
for (const name of Object.keys(S)) $.b.str[name] ??= (s, ...args) => S[name](s, ...args);
$.isinst = (v, t) => {
  if (Array.isArray(t)) return t.some((each) => $.isinst(v, each));
  if (t?.$inst) return t.$inst(v);
  if (t?.$absent !== undefined) return false;
  return typeof t === "function" && t.prototype !== undefined && v instanceof t;
};
