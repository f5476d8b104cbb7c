/** The compensator at work: a reference by hand, a triangle, a sine or a column, and the loop around 45° with the
 * compensator and with a plain curve. */

import { h } from "./dom";
import { Fit, modelOf } from "./fit";
import { Column, labelOf, readColumn, textOf } from "./log";
import { LoopPlot, short, TimePlot } from "./plots";
import { Core, mapped, Model, Points, turned } from "./wasm";

const KEPT = 900; // samples in view
const RATE = 120; // samples a second

/** Where a reference goes at its sample k, from -1 to 1. */
const SHAPES: Record<string, (k: number) => number> = {
  triangle: (k) => Math.abs(((k / PERIOD) % 1) - 0.5) * 4 - 1,
  sine: (k) => Math.cos((2 * Math.PI * k) / PERIOD),
};
const PERIOD = 1.5 * RATE;
const FILE = "file";

export class Inverse {
  private readonly actuators: [Model, Model]; // with the compensator, with the curve
  private readonly inverse: Model | null;
  private readonly low: number;
  private readonly high: number;
  private history: { r: number[]; u: number[]; y: number[]; c: number[] } = { r: [], u: [], y: [], c: [] };
  private goal: number;
  private now: number;
  private phase: number | null = null; // of what is played, in samples
  private played: Float64Array | null = null; // values of a column that is played
  private readonly unturned: Points; // the plain curve, from output to input
  private readonly inputs: [number, number]; // range of the log
  private running = 0;
  private last = 0;
  private readonly time: TimePlot | null = null;
  private readonly asked: TimePlot | null = null;
  private readonly loop: LoopPlot | null = null;
  private readonly slider: HTMLInputElement;
  private readonly button: HTMLButtonElement;
  private readonly shape = h("select", { id: "shape", onchange: () => void this.choose() });
  private readonly file = h("input", { type: "file", "aria-label": "A file with one column of numbers to play", hidden: true, onchange: () => void this.upload() });
  private readonly words = h("p", { class: "readout", role: "status" });

  constructor(root: HTMLElement, private readonly core: Core, fit: Fit, input: Column, private readonly output: Column, private readonly columns: Column[]) {
    this.actuators = [modelOf(core, fit.model), modelOf(core, fit.model)];
    this.inverse = this.actuators[0].inverse();
    this.unturned = turned(fit.curve);
    this.inputs = rangeOf(input.values);
    const [low, high] = rangeOf(fit.predicted); // as far as the model moves within the log: the exported code asks for no input beyond it
    [this.low, this.high] = [low + 0.05 * (high - low), high - 0.05 * (high - low)];
    this.goal = this.now = 0.5 * (low + high);
    const name = labelOf(output);
    this.slider = h("input", { type: "range", min: 0, max: 1000, value: 500, id: "reference", oninput: () => this.steer(Number(this.slider.value) / 1000) });
    this.button = h("button", { type: "button", class: "main", onclick: () => this.play() }, "Play");
    root.append(h("h2", {}, "The compensator at work"));
    if (!this.inverse) {
      root.append(h("p", {}, "This model has no inverse: a slope of its loading curve is not positive."));
      return;
    }
    root.append(
      h("p", { class: "caption" }, "The C code that is exported runs here. Move the reference by the slider, or drag within the first figure; the identified model stands for the actuator. With the compensator its output stays on the reference; a plain curve leaves a loop."),
      h("div", { class: "row" }, h("label", { for: "shape" }, "Reference", this.shape), this.button, h("button", { type: "button", onclick: () => this.forget() }, "Begin anew"),
        h("label", { for: "reference", class: "grow" }, `By hand: ${name}`, this.slider)), this.file,
      this.words);
    const panels = h("div", { class: "panels" });
    root.append(panels);
    const left = h("div", {});
    panels.append(left);
    this.time = new TimePlot(left, { title: "Reference and output", name: "tracking", xLabel: "time [s]", yLabel: name, height: 230 });
    this.asked = new TimePlot(left, { title: "What the compensator asks for", name: "command", xLabel: "time [s]", yLabel: labelOf(input), height: 230 });
    this.loop = new LoopPlot(panels, { title: "Compensated loop", name: "compensated", xLabel: `${name}, wanted`, yLabel: `${name}, reached`, equal: true, height: 420,
      described: "Output against reference: with the compensator on the 45 degree line, with a plain curve around it." });
    this.shape.append(
      h("option", { value: "triangle" }, "a triangle"), h("option", { value: "sine" }, "a sine"),
      ...columns.map((column, k) => h("option", { value: String(k) }, `column ${column.name}`)), h("option", { value: FILE }, "a file of one column ..."));
    this.draggable();
    for (let k = 0; k < 3 * RATE; k++) this.step(this.reference(k));
    this.draw();
  }

  destroy(): void {
    cancelAnimationFrame(this.running);
    this.running = 0;
    for (const plot of [this.time, this.asked, this.loop]) plot?.destroy();
    for (const model of [...this.actuators, this.inverse]) model?.free();
  }

  /** What is played at its sample k: a column, or a shape whose strokes shrink and grow again. */
  private reference(k: number): number {
    if (this.played) return Math.max(this.low, Math.min(this.high, this.played[k % this.played.length]));
    const size = 0.45 + 0.55 * Math.abs(Math.cos((Math.PI * k) / (6 * PERIOD)));
    return 0.5 * (this.low + this.high) - 0.5 * (this.high - this.low) * SHAPES[this.shape.value](k) * size;
  }

  /** Take the reference that is chosen. */
  private async choose(): Promise<void> {
    if (this.phase !== null) this.play();
    this.file.hidden = this.shape.value !== FILE;
    this.played = this.columns[Number(this.shape.value)]?.values ?? null;
    this.button.disabled = !this.file.hidden;
  }

  private async upload(): Promise<void> {
    const file = this.file.files?.[0];
    if (!file) return;
    try {
      this.played = readColumn(file.name, await textOf(file));
      this.button.disabled = false;
      this.words.textContent = `${file.name}: ${this.played.length} values, kept between ${short(this.low)} and ${short(this.high)}.`;
    } catch (fault) {
      this.played = null;
      this.button.disabled = true;
      this.words.textContent = fault instanceof Error ? fault.message : String(fault);
    }
  }

  private step(reference: number): void {
    const u = this.inverse!.step(reference);
    const [least, most] = this.inputs;
    const plain = Math.max(least, Math.min(most, mapped(this.core, this.unturned, [reference])[0]));
    const { r, u: asked, y, c } = this.history;
    r.push(reference);
    asked.push(u);
    y.push(this.actuators[0].step(u));
    c.push(this.actuators[1].step(plain));
    this.now = reference;
    if (r.length > KEPT) for (const list of [r, asked, y, c]) list.splice(0, list.length - KEPT);
  }

  private draw(): void {
    const { r, u, y, c } = this.history;
    const t = r.map((_v, k) => (k - r.length) / RATE);
    this.time!.set(t, [
      { label: "reference", values: r, colour: "other", width: 3 },
      { label: "with compensator", values: y, colour: "train" },
      { label: "with plain curve", values: c, colour: "test", dash: [6, 4] },
    ]);
    this.asked!.set(t, [{ label: "compensator", values: u, colour: "train" }]);
    this.loop!.set([
      { label: "45°", x: [this.low, this.high], y: [this.low, this.high], colour: "other", dash: [5, 4] },
      { label: "with plain curve", x: r, y: c, colour: "test" },
      { label: "with compensator", x: r, y, colour: "train", width: 2 },
    ], true);
    const rms = (list: number[]): number => Math.sqrt(list.reduce((sum, v, k) => sum + (v - r[k]) ** 2, 0) / Math.max(1, r.length));
    const unit = this.output.unit ? ` ${this.output.unit}` : "";
    const zero = 1e-9 * (this.high - this.low);
    const size = (value: number): string => (value < zero ? "0" : short(value, 3));
    this.words.textContent = `Off the reference, rms: ${size(rms(y))}${unit} with the compensator, ${size(rms(c))}${unit} with a plain curve.`;
  }

  private play(): void {
    this.phase = this.phase === null ? 0 : null;
    this.button.textContent = this.phase === null ? "Play" : "Stop";
    if (this.phase !== null) this.go();
  }

  private forget(): void {
    for (const model of [...this.actuators, this.inverse!]) model.reset();
    this.history = { r: [], u: [], y: [], c: [] };
    this.step(this.now);
    this.draw();
  }

  private steer(share: number): void {
    if (this.phase !== null) this.play();
    this.goal = this.low + share * (this.high - this.low);
    this.slider.setAttribute("aria-valuetext", `${short(this.goal)} ${this.output.unit}`);
    this.go();
  }

  private go(): void {
    if (this.running) return;
    this.last = performance.now();
    const frame = (time: number): void => {
      const count = Math.min(12, Math.max(1, Math.round(((time - this.last) * RATE) / 1000)));
      this.last = time;
      const most = (1.6 * (this.high - this.low)) / RATE;
      for (let k = 0; k < count; k++) {
        const goal = this.phase === null ? this.goal : this.reference(this.phase++); // fast, never at once
        this.step(this.now + Math.max(-most, Math.min(most, goal - this.now)));
      }
      this.draw();
      const still = this.phase === null && Math.abs(this.goal - this.now) < 1e-12 * (this.high - this.low);
      this.running = still || !this.time!.element.isConnected ? 0 : requestAnimationFrame(frame);
    };
    this.running = requestAnimationFrame(frame);
  }

  private draggable(): void {
    const box = this.time!.element.querySelector<HTMLElement>(".plot")!;
    box.classList.add("draggable");
    let dragging = false;
    const follow = (event: PointerEvent): void => {
      if (!dragging) return;
      const area = box.querySelector(".u-over")!.getBoundingClientRect();
      const share = this.time!.share((event.clientY - area.top), this.low, this.high);
      this.slider.value = String(Math.round(1000 * share));
      this.steer(share);
    };
    box.addEventListener("pointerdown", (event) => { dragging = true; box.setPointerCapture(event.pointerId); follow(event); event.preventDefault(); event.stopPropagation(); }, true);
    box.addEventListener("pointermove", follow);
    for (const kind of ["pointerup", "pointercancel"]) box.addEventListener(kind, () => { dragging = false; });
  }
}

/** Least and largest value. */
export function rangeOf(values: ArrayLike<number>): [number, number] {
  let [low, high] = [Infinity, -Infinity];
  for (let k = 0; k < values.length; k++) [low, high] = [Math.min(low, values[k]), Math.max(high, values[k])];
  return [low, high];
}
