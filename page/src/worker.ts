/** Reads and identifies beside the page, so that it stays alive: asked by messages, one at a time. */

import { begin, files, identify, inspect, more, read, refusal } from "../runtime/answer.js";
import { Core } from "./wasm";

export const LARGEST = 120e6; // bytes of text: what one instance of the code holds with room for the columns

const PACKED = /\.(mat|h5|hdf5|npz|npy|bag|db3|mcap|mf4|mdf|parquet|feather|xlsx|xls|tdms)$/i; // what Python reads, and this page does not

const WARMED = 3;
const ready: Promise<unknown>[] = [];
let held: Core | undefined;

async function unpacked(packed: Uint8Array): Promise<Uint8Array> {
  if (packed[0] !== 0x1f || packed[1] !== 0x8b) return packed;
  const reader = new Blob([packed as BlobPart]).stream().pipeThrough(new DecompressionStream("gzip")).getReader();
  const parts: Uint8Array[] = [];
  let size = 0;
  for (;;) {
    const { value, done } = await reader.read();
    if (done) break;
    parts.push(value);
    size += value.length;
    if (size > LARGEST) throw new TooLarge("this log expands");
  }
  const all = new Uint8Array(size);
  let at = 0;
  for (const part of parts) {
    all.set(part, at);
    at += part.length;
  }
  return all;
}
class TooLarge extends Error {}
class OtherFormat extends Error {}

let inStudio = false; // all of Python is one tab away

const ANSWERS: Record<string, (message: any) => unknown> = {
  open: ({ module, studio }) => {
    inStudio = studio;
    ready.push(Core.open(module).then((core) => begin(held = core)).then(() => setTimeout(warm)));
  },
  read: async ({ file }: { file: File }) => {
    if (PACKED.test(file.name)) throw new OtherFormat(file.name);
    if (file.size > LARGEST) throw new TooLarge("this log is larger");
    const packed = new Uint8Array(await file.arrayBuffer());
    const digest = crypto.subtle?.digest("SHA-256", packed); // by other threads, where the browser has it
    return read(await unpacked(packed), packed, file.name, digest);
  },
  inspect: ({ run }) => inspect(run),
  more: () => more(),
  files: ({ stem }) => files(stem),
  identify: ({ input, output, run, reading, fitting }) => identify(input, output, run, reading, fitting),
};

function told(fault: unknown): { known: boolean; message: string; stack: string } {
  if (fault instanceof TooLarge)
    return { known: true, stack: "", message: `${fault.message} than the ${LARGEST / 1e6} MB that this page holds in memory. ${inStudio ? "Open it on the tab Studio, which reads logs of any length" : "Install dehyst, which reads logs of any length in chunks (pip install dehyst; dehyst identify LOG ...)"}, or cut the log.` };
  if (fault instanceof OtherFormat)
    return { known: true, stack: "", message: `this page reads text, and '${fault.message}' is none. ${inStudio ? "Open it on the tab Studio, which reads it." : `Save its columns as CSV, or install dehyst, which reads it (dehyst inspect ${fault.message}).`}` };
  if (fault instanceof TypeError && /decompress|gzip/i.test(fault.message))
    return { known: true, stack: "", message: "the file is damaged: its gzip data cannot be expanded. Copy it again." };
  return refusal(fault);
}

/* What was never run is slow: a made-up log goes its way while nobody has dropped one, so that a first log takes no
 * longer than a later one. A message waits for the present step at most. */
let asked = false;
const steps = [...Array(WARMED).keys()].flatMap(() => [() => read(made, made, "warm.csv"), () => identify("u_V", "y_mm", null)]);
let made: Uint8Array;
async function warm(): Promise<void> {
  made ??= madeUp();
  const step = asked ? undefined : steps.shift();
  if (!step) return;
  await step();
  setTimeout(warm);
}

function madeUp(): Uint8Array {
  const rows = ["t_s,u_V,y_mm"];
  for (let k = 0, y = 0; k < 3000; k++) {
    const t = k / 50, u = Math.sin(t) * (0.4 + 0.6 * Math.abs(Math.cos(0.1 * t)));
    y = Math.max(u - 0.2, Math.min(u + 0.2, y));
    rows.push(`${t.toFixed(2)},${u.toFixed(5)},${(u + y + 0.05 * Math.sin(k * k)).toFixed(5)}`);
  }
  return new TextEncoder().encode(rows.join("\n"));
}

onmessage = async ({ data }: MessageEvent) => {
  asked ||= data.kind !== "open";
  try {
    await Promise.all(ready);
    const answer = await ANSWERS[data.kind](data);
    // Signals are given away, not copied.
    const transfer = data.kind === "identify" ? Object.values(answer as object).filter((value) => value instanceof Float64Array || value instanceof Uint8Array).map(({ buffer }) => buffer) : [];
    postMessage({ id: data.id, answer: data.kind === "open" ? null : answer, memory: held?.c.memory.buffer.byteLength }, { transfer });
  } catch (fault) {
    postMessage({ id: data.id, fault: told(fault) });
  }
};
