/** The C code of core/ and engine/, compiled to WebAssembly and carried inside the page. */

import { unpacked } from "./packed";

type Address = number;

interface Exports {
  memory: WebAssembly.Memory;
  _initialize(): void;
  page_alloc(bytes: number): Address;
  page_free(memory: Address): void;
  page_model_new(n: number, threshold: Address, weight: Address, center: number, offset: number, start: Address): Address;
  page_model_inverse(model: Address): Address;
  page_model_reset(model: Address): void;
  page_model_run(model: Address, samples: number, x: Address, y: Address): void;
  page_model_states(model: Address, z: Address): void;
  page_map_values(n: number, u: Address, v: Address, samples: number, x: Address, y: Address): void;
}

/** Unpack and compile the code; the module can be posted to a worker. */
export async function compile(): Promise<WebAssembly.Module> {
  return WebAssembly.compile(await unpacked("wasm"));
}

/** An instance of the code with its own memory. */
export class Core {
  private constructor(
    readonly c: Exports,
    readonly module: WebAssembly.Module,
  ) {}

  static async open(module: WebAssembly.Module): Promise<Core> {
    const none = () => 52; // what the C library would ask an operating system for; the page has none: ENOSYS
    const imports: WebAssembly.Imports = {};
    for (const { module: from, name } of WebAssembly.Module.imports(module)) (imports[from] ??= {})[name] = none;
    const instance = await WebAssembly.instantiate(module, imports);
    const exports = instance.exports as unknown as Exports;
    exports._initialize();
    return new Core(exports, module);
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

/** Values of a rising piecewise linear map, continued along its ends. */
export function mapped(core: Core, u: ArrayLike<number>, v: ArrayLike<number>, x: ArrayLike<number>): Float64Array {
  const given = [u, v, x].map((values) => core.put(values));
  core.c.page_map_values(u.length, given[0], given[1], x.length, given[2], given[2]);
  const y = core.doubles(given[2], x.length).slice();
  for (const each of given) core.c.page_free(each);
  return y;
}

/** y = offset + Σ wᵢ play_{rᵢ}[x − center], run sample by sample by the code that is exported. */
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
    { center = 0, offset = 0, start }: { center?: number; offset?: number; start?: ArrayLike<number> } = {},
  ): Model {
    const n = thresholds.length;
    const given = [thresholds, weights, start ?? new Float64Array(n)].map((values) => core.put(values));
    const address = core.c.page_model_new(n, given[0], given[1], center, offset, given[2]);
    for (const each of given) core.c.page_free(each);
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
