/** The C code of core/ and engine/, compiled to WebAssembly and carried inside the page. */

import { unpacked } from "./packed";

type Address = number;

interface Exports {
  memory: WebAssembly.Memory;
  _initialize(): void;
  page_alloc(bytes: number): Address;
  page_free(memory: Address): void;
  page_model_new(n: number, threshold: Address, weight: Address, center: number, offset: number, start: Address,
    pointsBefore: number, before: Address, pointsAfter: number, after: Address): Address;
  page_model_inverse(model: Address): Address;
  page_model_reset(model: Address): void;
  page_model_run(model: Address, samples: number, x: Address, y: Address): void;
  page_model_states(model: Address, z: Address): void;
  page_map_values(n: number, u: Address, v: Address, samples: number, x: Address, y: Address): void;
  page_bin_sums(samples: number, x: Address, y: Address, weight: Address, bins: number, low: number, high: number,
    sums: Address): void;
  page_gram_new(n: number, threshold: Address, state: Address, targets: number): Address;
  page_gram_free(gram: Address): void;
  page_gram_add(gram: Address, samples: number, x: Address, m: number, targets: Address, weight: Address): number;
  page_gram_take(gram: Address, sums: Address): void;
  page_solve(n: number, plays: number, basis: number, gram: Address, rhs: Address, extra: Address, extraRhs: Address,
    lower: Address, targetNorm: number, u: Address, answer: Address): number;
}

/** Unpack and compile the code. */
export async function compile(): Promise<WebAssembly.Module> {
  return WebAssembly.compile(await unpacked("wasm"));
}

/** An instance of the code with its own memory. */
export class Core {
  private constructor(readonly c: Exports) {}

  static async open(module: WebAssembly.Module): Promise<Core> {
    const none = () => 52; // what the C library would ask an operating system for; the page has none: ENOSYS
    const imports: WebAssembly.Imports = {};
    for (const { module: from, name } of WebAssembly.Module.imports(module)) (imports[from] ??= {})[name] = none;
    const instance = await WebAssembly.instantiate(module, imports);
    const exports = instance.exports as unknown as Exports;
    exports._initialize();
    return new Core(exports);
  }

  /** Numbers at an address, as long as no call has made the memory grow. */
  doubles(address: Address, length: number): Float64Array {
    return new Float64Array(this.c.memory.buffer, address, length);
  }

  /** Memory for so many bytes; give it back by c.page_free. */
  alloc(bytes: number): Address {
    const address = this.c.page_alloc(bytes);
    if (address === 0) throw new RangeError("the browser has no memory left for this");
    return address;
  }

  /** A copy of numbers in the memory of the code. */
  put(values: ArrayLike<number>): Address {
    const address = this.alloc(8 * Math.max(1, values.length));
    this.doubles(address, values.length).set(values);
    return address;
  }
}

/** Breakpoints, which rise, and values, which rise or fall: a piecewise linear map, continued along its ends. */
export interface Points {
  u: ArrayLike<number>;
  v: ArrayLike<number>;
}

/** Copies arrays in, calls, and frees them, whatever happens. */
export function borrowed<T>(core: Core, arrays: ArrayLike<number>[], call: (...addresses: Address[]) => T): T {
  const addresses: Address[] = [];
  try {
    for (const values of arrays) addresses.push(core.put(values));
    return call(...addresses);
  } finally {
    for (const address of addresses) core.c.page_free(address);
  }
}

/** Values of a map. */
export function mapped(core: Core, { u, v }: Points, x: ArrayLike<number>): Float64Array {
  return borrowed(core, [u, v, x], (atU, atV, atX) => {
    core.c.page_map_values(u.length, atU, atV, x.length, atX, atX);
    return core.doubles(atX, x.length).slice();
  });
}

/** The map that answers its argument. */
export function turned({ u, v }: Points): Points {
  const falls = v.length > 1 && v[0] > v[v.length - 1];
  const order = (values: ArrayLike<number>): number[] => (falls ? Array.from(values).reverse() : Array.from(values));
  return { u: order(v), v: order(u) };
}

/** y = after(offset + Σ wᵢ play_{rᵢ}[x − center]), run sample by sample by the code that is exported. */
export class Model {
  private constructor(
    private readonly core: Core,
    private address: Address,
    readonly n: number,
  ) {}

  /** Thresholds rise from 0; start states are admissible: |zᵢ − zᵢ₊₁| ≤ rᵢ₊₁ − rᵢ. */
  static make(
    core: Core,
    thresholds: ArrayLike<number>,
    weights: ArrayLike<number>,
    { center = 0, offset = 0, start, after }: { center?: number; offset?: number; start?: ArrayLike<number>; after?: Points | null } = {},
  ): Model {
    const n = thresholds.length;
    const points = after ? [...Array.from(after.u), ...Array.from(after.v)] : [];
    const address = borrowed(core, [thresholds, weights, start ?? new Float64Array(n), points], (r, w, z, map) =>
      core.c.page_model_new(n, r, w, center, offset, z, 0, map, points.length / 2, map));
    if (address === 0) throw new RangeError("the browser has no memory left for this");
    return new Model(core, address, n);
  }

  /** The closed inverse, or null if a slope of the loading curve is not positive. */
  inverse(): Model | null {
    const address = this.core.c.page_model_inverse(this.address);
    return address === 0 ? null : new Model(this.core, address, this.n);
  }

  /** Outputs of so many inputs, going on from the present state. */
  run(x: ArrayLike<number>): Float64Array {
    const address = this.core.put(x);
    this.core.c.page_model_run(this.address, x.length, address, address);
    const y = this.core.doubles(address, x.length).slice();
    this.core.c.page_free(address);
    return y;
  }

  /** Output of one input. */
  step(x: number): number {
    return this.run([x])[0];
  }

  /** Play states zᵢ. */
  states(): Float64Array {
    const address = this.core.alloc(8 * this.n);
    this.core.c.page_model_states(this.address, address);
    const z = this.core.doubles(address, this.n).slice();
    this.core.c.page_free(address);
    return z;
  }

  reset(): void {
    this.core.c.page_model_reset(this.address);
  }

  free(): void {
    if (this.address !== 0) this.core.c.page_free(this.address);
    this.address = 0;
  }
}
