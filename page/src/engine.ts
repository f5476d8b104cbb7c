/** The worker that reads and identifies, and what it answers. */

import { served } from "./api";
import { unpacked } from "./packed";

export interface Column {
  name: string;
  unit: string;
  samples: number;
  minimum: number;
  maximum: number;
  loops: number;
  missing: number;
  constant: boolean;
  role: string;
  reason: string;
}
export interface Finding {
  code: string;
  message: string;
}
export interface Summary {
  name: string;
  rows: number;
  columns: Column[];
  runs: Record<string, number>;
  run: string | null;
  sampling: { column: string; median: number; first: number; last: number } | null;
  input: string | null;
  output: string | null;
  clear: boolean;
  command: string;
  findings: Finding[];
  starts: string[];
  units: string[];
}
interface Score {
  rmse: number;
  rmse_percent: number;
  nrmse: number;
  max: number;
}
export interface Answer {
  scores: { train: Score; test: Score | null; curve: Score };
  verdict: string;
  grade: "good" | "care" | "stop";
  warnings: Finding[];
  size: string;
  start: string;
  orientation: string;
  width: number;
  gain: number;
  labels: { input: string; output: string; inputUnit: string; outputUnit: string; inputName: string; outputName: string; name: string };
  time: Float64Array | null;
  x: Float64Array;
  y: Float64Array;
  predicted: Float64Array;
  asked: Float64Array;
  train: Uint8Array;
  test: Uint8Array;
  curve: { u: Float64Array; v: Float64Array; y: Float64Array };
  model: { thresholds: Float64Array; weights: Float64Array; center: number; offset: number; start: Float64Array };
  card: { input: [number, number]; output: [number, number] };
  file: string;
  command: string;
  repeat: string;
}

/** What the package refuses, in its own words. */
export class Refusal extends Error {
  constructor(message: string, readonly known: boolean) {
    super(message);
  }
}

const HELD = 256e6; // bytes that a long log leaves: memory of WebAssembly only grows, so that the next log gets a new worker

export class Engine {
  private readonly waiting = new Map<number, [(answer: any) => void, (fault: unknown) => void]>();
  private number = 0;
  private held = 0;
  private worker!: Worker;

  private constructor(private readonly module: WebAssembly.Module) {}

  static async open(module: WebAssembly.Module): Promise<Engine> {
    const engine = new Engine(module);
    await engine.start();
    return engine;
  }

  private async start(): Promise<void> {
    const link = URL.createObjectURL(new Blob([await unpacked("worker")], { type: "text/javascript" }));
    const worker = (this.worker = new Worker(link));
    URL.revokeObjectURL(link);
    worker.onmessage = ({ data }) => {
      this.held = data.memory ?? 0;
      const [done, failed] = this.waiting.get(data.id)!;
      this.waiting.delete(data.id);
      if (data.fault) {
        if (data.fault.stack) console.warn(data.fault.stack);
        failed(new Refusal(data.fault.message, data.fault.known));
      } else done(data.answer);
    };
    worker.onerror = (event) => {
      for (const [, failed] of this.waiting.values()) failed(new Refusal(`the page failed: ${event.message}`, false));
      this.waiting.clear();
    };
    await this.ask("open", { module: this.module, studio: served() });
  }

  async read(file: Blob): Promise<Summary> {
    if (this.held > HELD) {
      this.stop();
      await this.start();
    }
    return this.ask("read", { file });
  }
  inspect(run: string): Promise<Summary> {
    return this.ask("inspect", { run });
  }
  identify(input: string, output: string, run: string | null, reading: object, fitting: object): Promise<Answer> {
    return this.ask("identify", { input, output, run, reading, fitting });
  }
  /** All of the last fit, and what is left of its error. */
  more(): Promise<{ said: Record<string, unknown>; left: string }> {
    return this.ask("more", {});
  }
  /** The C folder of the last model. */
  files(stem: string): Promise<{ name: string; data: Uint8Array }[]> {
    return this.ask("files", { stem });
  }
  stop(): void {
    this.worker.terminate();
    for (const [, failed] of this.waiting.values()) failed(new Refusal("stopped", true));
    this.waiting.clear();
  }

  private ask(kind: string, message: object): Promise<any> {
    const id = ++this.number;
    return new Promise((done, failed) => {
      this.waiting.set(id, [done, failed]);
      this.worker.postMessage({ kind, id, ...message });
    });
  }
}
