/** The compensator at work: a reference by hand or as a triangle, and the loop around 45° with it and with a plain curve. */

import { h } from "./dom";
import type { Answer } from "./engine";
import { LoopPlot, short, TimePlot } from "./plots";
import { Core, mapped, Model } from "./wasm";

const KEPT = 900; // samples in view
const RATE = 120; // samples a second

export class Inverse {
  private readonly actuators: [Model, Model]; // with the compensator, with the curve
  private readonly inverse: Model | null;
  private readonly low: number;
  private readonly high: number;
  private history: { r: number[]; u: number[]; y: number[]; c: number[] } = { r: [], u: [], y: [], c: [] };
  private wanted: number;
  private now: number;
  private phase: number | null = null; // of the triangle, in samples
  private running = 0;
  private last = 0;
  private readonly time: TimePlot | null = null;
  private readonly asked: TimePlot | null = null;
  private readonly loop: LoopPlot | null = null;
  private readonly slider: HTMLInputElement;
  private readonly button: HTMLButtonElement;
  private readonly words = h("p", { class: "readout", role: "status" });

  constructor(root: HTMLElement, private readonly core: Core, private readonly a: Answer) {
    const { thresholds, weights, center, offset, start } = a.model;
    const make = (): Model => Model.make(core, thresholds, weights, { center, offset, start });
    this.actuators = [make(), make()];
    this.inverse = this.actuators[0].inverse();
    let [low, high] = [Infinity, -Infinity]; // as far as the model moves within the log: the exported code asks for no input beyond it
    for (const value of a.predicted) [low, high] = [Math.min(low, value), Math.max(high, value)];
    [this.low, this.high] = [low + 0.05 * (high - low), high - 0.05 * (high - low)];
    this.wanted = this.now = 0.5 * (low + high);
    const name = a.labels.output;
    this.slider = h("input", { type: "range", min: 0, max: 1000, value: 500, id: "reference", oninput: () => this.steer(Number(this.slider.value) / 1000) });
    this.button = h("button", { type: "button", class: "main", onclick: () => this.play() }, "Play a triangle");
    root.append(h("h2", {}, "The compensator at work"));
    if (!this.inverse) {
      root.append(h("p", {}, "This model has no inverse: a slope of its loading curve is not positive."));
      return;
    }
    root.append(
      h("p", { class: "caption" }, "The C code that is exported runs here. Move the reference by the slider, or drag within the first figure; the identified model stands for the actuator. With the compensator its output stays on the reference; a plain curve leaves a loop."),
      h("div", { class: "row" }, this.button, h("button", { type: "button", onclick: () => this.forget() }, "Begin anew"),
        h("label", { for: "reference", class: "grow" }, `Reference: ${name}`, this.slider)),
      this.words);
    const panels = h("div", { class: "panels" });
    root.append(panels);
    const left = h("div", {});
    panels.append(left);
    this.time = new TimePlot(left, { title: "Reference and output", name: "tracking", xLabel: "time [s]", yLabel: name, height: 230 });
    this.asked = new TimePlot(left, { title: "What the compensator asks for", name: "command", xLabel: "time [s]", yLabel: a.labels.input, height: 230 });
    this.loop = new LoopPlot(panels, { title: "Compensated loop", name: "compensated", xLabel: `${name}, wanted`, yLabel: `${name}, reached`, equal: true, height: 420,
      described: "Output against reference: with the compensator on the 45 degree line, with a plain curve around it." });
    this.draggable();
    for (let k = 0; k < 3 * RATE; k++) this.step(this.triangle(k));
    this.draw();
  }

  destroy(): void {
    cancelAnimationFrame(this.running);
    this.running = 0;
    for (const plot of [this.time, this.asked, this.loop]) plot?.destroy();
    for (const model of [...this.actuators, this.inverse]) model?.free();
  }

  /** A triangle whose strokes shrink and grow again. */
  private triangle(k: number): number {
    const period = 1.5 * RATE;
    const way = Math.abs(((k / period) % 1) - 0.5) * 4 - 1;
    const size = 0.45 + 0.55 * Math.abs(Math.cos((Math.PI * k) / (6 * period)));
    return 0.5 * (this.low + this.high) - 0.5 * (this.high - this.low) * way * size;
  }

  private step(reference: number): void {
    const u = this.inverse!.step(reference);
    const [least, most] = this.a.card.input;
    const plain = Math.max(least, Math.min(most, mapped(this.core, this.a.curve.v, this.a.curve.u, [reference])[0]));
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
    const unit = this.a.labels.outputUnit ? ` ${this.a.labels.outputUnit}` : "";
    const zero = 1e-9 * (this.high - this.low);
    const said = (value: number): string => (value < zero ? "0" : short(value, 3));
    this.words.textContent = `Off the reference, rms: ${said(rms(y))}${unit} with the compensator, ${said(rms(c))}${unit} with a plain curve.`;
  }

  private play(): void {
    this.phase = this.phase === null ? 0 : null;
    this.button.textContent = this.phase === null ? "Play a triangle" : "Stop";
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
    this.wanted = this.low + share * (this.high - this.low);
    this.slider.setAttribute("aria-valuetext", `${short(this.wanted)} ${this.a.labels.outputUnit}`);
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
        const goal = this.phase === null ? this.wanted : this.triangle(this.phase++); // faster than a triangle, never at once
        this.step(this.now + Math.max(-most, Math.min(most, goal - this.now)));
      }
      this.draw();
      const still = this.phase === null && Math.abs(this.wanted - this.now) < 1e-12 * (this.high - this.low);
      this.running = still || !this.time!.element.isConnected ? 0 : requestAnimationFrame(frame);
    };
    this.running = requestAnimationFrame(frame);
  }

  private draggable(): void {
    const box = this.time!.element.querySelector<HTMLElement>(".plot")!;
    box.classList.add("draggable");
    let held = false;
    const follow = (event: PointerEvent): void => {
      if (!held) return;
      const area = box.querySelector(".u-over")!.getBoundingClientRect();
      const share = this.time!.share((event.clientY - area.top), this.low, this.high);
      this.slider.value = String(Math.round(1000 * share));
      this.steer(share);
    };
    box.addEventListener("pointerdown", (event) => { held = true; box.setPointerCapture(event.pointerId); follow(event); event.preventDefault(); event.stopPropagation(); }, true);
    box.addEventListener("pointermove", follow);
    for (const kind of ["pointerup", "pointercancel"]) box.addEventListener(kind, () => { held = false; });
  }
}
