/** The tab "How it works": a play moved by hand, plays that add up to a loop, and the inverse that undoes it. All
 * operators are run by the C code of the page; nothing is computed twice here. */

import { h } from "./dom";
import { paint, Path, Plane, s } from "./plane";
import { short } from "./plots";
import { Model, type Core } from "./wasm";

const TICKS = [-1, -0.5, 0, 0.5, 1];
const REACH = 1.15; // of the axes, beyond the range of the input
const SHOWN = 700; // points of the past that are drawn
const KEPT = 6000; // points of the past that are kept
const STEP = 0.02; // largest move between two points
const COLOURS = ["train", "fifth", "sixth", "static", "test"];
const THRESHOLDS = [0, 0.12, 0.26, 0.42, 0.6];
const WEIGHTS = [0.35, 0.2, 0.2, 0.15, 0.15];
const FINE = 240; // plays whose states draw the memory

/** Fill the tab; called when it is opened for the first time. */
export function mount(root: HTMLElement, core: Core): void {
  const weights = Float64Array.from(WEIGHTS);
  const listeners: (() => void)[] = [];
  const changed = (): void => listeners.forEach((each) => each());
  root.classList.add("teach");
  onePlay(section(root, "One play: where memory lives",
    "A pin moves in a slot. Inside the slot it moves freely, and the slot stands still; at an end it takes the slot along. The pin is the input x, the middle of the slot is the memory z. Move the pin."), core);
  manyPlays(section(root, "Many plays: a loop",
    "Plays of growing half width r, each with a weight, add up to a loop of almost any shape. Every turn of the input stays remembered until a larger one wipes it out: the corners of the stairs below. (The paper’s Figure 4, alive.)"), core, weights, changed);
  inverse(section(root, "The inverse: what the actuator has to be given",
    "A sum of plays has an inverse that is a sum of plays again, so it costs no more than the model and needs no iteration. Give the actuator what the inverse says, and it goes where it should. (The paper’s Figure 5, alive.)"), core, weights, listeners);
}

function section(root: HTMLElement, title: string, words: string): HTMLElement {
  const made = h("section", { class: "lesson" }, h("h2", {}, title), h("p", { class: "caption" }, words));
  root.append(made);
  return made;
}

/** z of one play over a motion, from the state 0. */
function play(core: Core, r: number, x: ArrayLike<number>): Float64Array {
  return ran(Model.make(core, [0, Math.max(r, 1e-9)], [0, 1]), x);
}

function ran(model: Model, x: ArrayLike<number>): Float64Array {
  const y = model.run(x);
  model.free();
  return y;
}

/** A slider with its name and value. */
function slider(name: string, low: number, high: number, step: number, value: number, set: (value: number) => void, unit = ""): HTMLLabelElement & { input: HTMLInputElement } {
  const out = h("output", {}, short(value, 3) + unit);
  const input = h("input", { type: "range", min: low, max: high, step, value });
  input.addEventListener("input", () => {
    out.textContent = short(input.valueAsNumber, 3) + unit;
    set(input.valueAsNumber);
  });
  const label = h("label", { class: "slider" }, h("span", {}, name, " ", out), input);
  return Object.assign(label, { input });
}

/** Moves an input by a slider, by a drag in a figure, or by a motion of its own; keeps where it has been. */
class Driver {
  x: number[] = [0];
  readonly input: HTMLInputElement;
  private readonly button: HTMLButtonElement;
  private readonly value: HTMLOutputElement;
  private running = 0;

  constructor(root: HTMLElement, private readonly motion: (seconds: number) => number | null, private readonly moved: () => void, name = "input x") {
    this.value = h("output", {}, "0");
    this.input = h("input", { type: "range", min: -1, max: 1, step: 0.01, value: 0 });
    this.input.addEventListener("input", () => {
      this.stop();
      this.to(this.input.valueAsNumber);
    });
    this.button = h("button", { type: "button", onclick: () => (this.running ? this.stop() : this.start()) }, "Play a motion");
    const again = h("button", { type: "button", onclick: () => this.reset() }, "Start again");
    root.append(h("div", { class: "driver" }, h("label", { class: "slider wide" }, h("span", {}, name, " ", this.value), this.input), this.button, again));
  }

  /** Let a drag in a figure move the input. */
  drag(plane: Plane): void {
    const svg = plane.svg;
    svg.classList.add("draggable");
    svg.addEventListener("pointerdown", (event) => {
      svg.setPointerCapture(event.pointerId);
      this.stop();
      this.to(plane.under(event));
    });
    svg.addEventListener("pointermove", (event) => {
      if (svg.hasPointerCapture(event.pointerId)) this.to(plane.under(event));
    });
  }

  reset(): void {
    this.stop();
    this.x = [0];
    this.show();
  }

  /** Go to a value, in steps small enough to be drawn. */
  to(target: number): void {
    const to = Math.max(-1, Math.min(1, target));
    const from = this.x[this.x.length - 1];
    const steps = Math.max(1, Math.ceil(Math.abs(to - from) / STEP));
    for (let k = 1; k <= steps; k++) this.x.push(from + ((to - from) * k) / steps);
    if (this.x.length > KEPT) this.x = turnsOf(this.x, KEPT / 2);
    this.show();
  }

  private show(): void {
    const now = this.x[this.x.length - 1];
    this.input.value = String(now);
    this.value.textContent = short(now, 3);
    this.moved();
  }

  private start(): void {
    const begun = performance.now();
    this.button.textContent = "Pause";
    const frame = (now: number): void => {
      const target = this.motion((now - begun) / 1000);
      if (target === null || !this.input.isConnected) return this.stop();
      this.to(target);
      this.running = requestAnimationFrame(frame);
    };
    this.running = requestAnimationFrame(frame);
  }

  private stop(): void {
    cancelAnimationFrame(this.running);
    this.running = 0;
    this.button.textContent = "Play a motion";
  }
}

/** The past as its turning points, which is all that plays remember, and the newest points as they are. */
function turnsOf(x: number[], newest: number): number[] {
  const old = x.slice(0, -newest);
  const turns = old.filter((at, k) => k === 0 || k === old.length - 1 || (at - old[k - 1]) * (old[k + 1] - at) < 0);
  return [...turns, ...x.slice(-newest)];
}

/** Strokes that get smaller, then one that is larger than all: what is remembered, and what wipes it out. */
function nested(seconds: number): number | null {
  if (seconds < 12) return Math.exp(-seconds / 7) * Math.sin(1.9 * seconds);
  if (seconds < 15) return 0.95 * Math.sin(Math.PI * (seconds - 12) / 1.5) + Math.exp(-12 / 7) * Math.sin(1.9 * 12) * (15 - seconds) / 3;
  return null;
}

function onePlay(root: HTMLElement, core: Core): void {
  let r = 0.35;
  const panels = h("div", { class: "panels" });
  const rail = new Plane(panels, "Pin and slot", "The pin is moved; the slot follows when the pin touches one of its ends.",
    { label: "position", low: -1.6, high: 1.6, ticks: [-1, 0, 1] }, { label: "", low: 0, high: 1 }, { width: 360, height: 300 });
  const slot = rail.add(paint(s("rect", { y: rail.py(0.66), height: rail.py(0.34) - rail.py(0.66), rx: 14, "stroke-width": 2 }), "train", "data", 0.55));
  const middle = rail.path("train", { width: 2 });
  const memory = rail.word(0, 0.1, "z");
  const pinned = rail.path("test", { width: 2 });
  const pin = rail.dot("test", 9);
  const input = rail.word(0, 0.88, "x");
  const plane = new Plane(panels, "The memory over the input", "A loop between the two lines z = x − r and z = x + r.",
    { label: "input x", low: -REACH, high: REACH, ticks: TICKS }, { label: "memory z", low: -REACH, high: REACH, ticks: TICKS });
  const guides = [plane.path("axis", { dash: "4 4", width: 1.2 }), plane.path("axis", { dash: "4 4", width: 1.2 })];
  const trace = plane.path("train", { width: 2.2 });
  const dot = plane.dot("test");
  const said = h("p", { class: "readout", role: "status" });
  const show = (): void => {
    const x = driver.x;
    const z = play(core, r, x);
    const [at, where, before] = [x[x.length - 1], z[z.length - 1], z[Math.max(0, z.length - 2)]];
    slot.setAttribute("x", String(rail.px(where - r) - 12));
    slot.setAttribute("width", String(rail.px(where + r) - rail.px(where - r) + 24));
    middle.set([where, where], [0.2, 0.36]);
    pinned.set([at, at], [0.5, 0.82]);
    pin(at, 0.5);
    memory.setAttribute("x", String(rail.px(where)));
    input.setAttribute("x", String(rail.px(at)));
    guides.forEach((guide, k) => guide.set([-2, 2], [-2 + (k ? r : -r), 2 + (k ? r : -r)]));
    trace.set(x, z, x.length - SHOWN);
    dot(at, where);
    const moves = where > before ? "taken along to the right" : where < before ? "taken along to the left" : "standing still";
    said.textContent = `x = ${short(at, 3)}, z = ${short(where, 3)}: the slot is ${moves}.`;
  };
  const driver = new Driver(root, nested, show);
  driver.drag(rail);
  driver.drag(plane);
  root.append(h("div", { class: "sliders" }, slider("half width r", 0, 0.8, 0.01, r, (value) => { r = value; show(); })), panels, said);
  show();
}

function manyPlays(root: HTMLElement, core: Core, weights: Float64Array, changed: () => void): void {
  const panels = h("div", { class: "panels three" });
  const each = new Plane(panels, "The plays", "Five plays over the same input, each with its own half width.",
    { label: "input x", low: -REACH, high: REACH, ticks: TICKS }, { label: "plays zᵢ", low: -REACH, high: REACH, ticks: TICKS });
  const sum = new Plane(panels, "Their weighted sum", "The loop, and dashed the curve on which it begins at rest.",
    { label: "input x", low: -REACH, high: REACH, ticks: TICKS }, { label: "output y = Σ wᵢ zᵢ", low: -REACH, high: REACH, ticks: TICKS });
  const turns = new Plane(panels, "What is remembered", "The half-plane of Preisach: switches that are on lie below the stairs. Corners are the turns of the input that are remembered.",
    { label: "switches off at β", low: -REACH, high: REACH, ticks: TICKS }, { label: "switches on at α", low: -REACH, high: REACH, ticks: TICKS });
  const traces = THRESHOLDS.map((_, k) => each.path(COLOURS[k], { width: 1.8 }));
  const dots = THRESHOLDS.map((_, k) => each.dot(COLOURS[k], 4));
  const initial = sum.path("axis", { dash: "4 4", width: 1.4 });
  const trace = sum.path("train", { width: 2.2 });
  const dot = sum.dot("test");
  const on = turns.path(null, { area: "data", opacity: 0.6 });
  const diagonal = turns.path("axis", { width: 1.4 });
  const lines = THRESHOLDS.map((_, k) => turns.path(COLOURS[k], { width: 1, dash: "3 4" }));
  const stairs = turns.path("train", { width: 2.4 });
  const marks = THRESHOLDS.map((_, k) => turns.dot(COLOURS[k], 4));
  const [fine, ones] = [Float64Array.from({ length: FINE }, (_, k) => (1.2 * k) / FINE), new Float64Array(FINE).fill(1)];
  turns.word(0.55, -0.7, "no switches here", "middle");
  diagonal.set([-2, 2], [-2, 2]);

  const show = (): void => {
    const x = driver.x;
    const from = x.length - SHOWN;
    const at = x[x.length - 1];
    THRESHOLDS.forEach((r, k) => {
      const z = play(core, r, x);
      traces[k].set(x, z, from);
      traces[k].element.style.opacity = String(0.25 + 0.75 * Math.min(1, weights[k] / 0.3));
      const now = z[z.length - 1];
      dots[k](at, now);
      marks[k](now - r, now + r);
      lines[k].set([-2, 2], [-2 + 2 * r, 2 + 2 * r]);
    });
    const y = ran(Model.make(core, THRESHOLDS, weights), x);
    trace.set(x, y, from);
    dot(at, y[y.length - 1]);
    const rise = Float64Array.from({ length: 101 }, (_, k) => k / 100);
    const risen = ran(Model.make(core, THRESHOLDS, weights), rise);
    initial.set([...Array.from(rise, (v) => -v).reverse(), ...rise], [...Array.from(risen, (v) => -v).reverse(), ...risen]);
    const memory = Model.make(core, fine, ones);
    memory.run(x);
    const z = memory.states();
    memory.free();
    const [beta, alpha] = [Array.from(z, (v, k) => v - fine[k]), Array.from(z, (v, k) => v + fine[k])];
    stairs.set(beta, alpha);
    on.set([...beta, -2, -2, at], [...alpha, alpha[FINE - 1], -2, at]);
  };
  const driver = new Driver(root, nested, show);
  [each, sum, turns].forEach((plane) => driver.drag(plane));
  const sliders = THRESHOLDS.map((r, k) => {
    const made = slider(`w${"₁₂₃₄₅"[k]} (r = ${short(r, 2)})`, k ? 0 : 0.1, 0.6, 0.01, weights[k], (value) => {
      weights[k] = value;
      show();
      changed();
    });
    made.style.borderColor = `var(--${COLOURS[k]})`;
    return made;
  });
  root.append(h("div", { class: "sliders", role: "group", "aria-label": "Weights of the plays" }, ...sliders), panels,
    h("p", { class: "caption" }, "Stairs: a play of half width r is the point where its dashed line, α − β = 2r, meets them. Below and left of the stairs the switches are on."));
  show();
}

const MOTIONS: Record<string, (k: number) => number> = {
  "strokes that get smaller": (k) => 0.8 * Math.exp(-k / 330) * Math.sin(k / 21),
  "a slow and a fast wave": (k) => 0.45 * Math.sin(k / 70) + 0.28 * Math.sin(k / 13.7),
  "triangles": (k) => 0.7 * (2 / Math.PI) * Math.asin(Math.sin(k / 26)) * (k < 330 ? 1 : 0.5),
};

function inverse(root: HTMLElement, core: Core, weights: Float64Array, listeners: (() => void)[]): void {
  let [compensated, scale, motion] = [true, 1, Object.keys(MOTIONS)[0]];
  const panels = h("div", { class: "panels three" });
  const forward = new Plane(panels, "The actuator", "Its loop: output over input.",
    { label: "input x", low: -1.5, high: 1.5, ticks: TICKS }, { label: "output y", low: -REACH, high: REACH, ticks: TICKS });
  const back = new Plane(panels, "The inverse", "The mirrored loop: what to apply over what is wanted.",
    { label: "wanted output", low: -REACH, high: REACH, ticks: TICKS }, { label: "input x", low: -1.5, high: 1.5, ticks: TICKS });
  const both = new Plane(panels, "One after the other", "Output over wanted output: the 45° line if the inverse fits.",
    { label: "wanted output", low: -REACH, high: REACH, ticks: TICKS }, { label: "output y", low: -REACH, high: REACH, ticks: TICKS });
  const time = new Plane(root, "Over time", "Wanted output dashed, output solid.",
    { label: "sample", low: 0, high: 700, ticks: [0, 200, 400, 600] }, { label: "output", low: -REACH, high: REACH, ticks: TICKS }, { width: root.clientWidth < 640 ? 360 : 760, height: 230 });
  const paths: [Path, Path, Path] = [forward.path("train", { width: 1.8 }), back.path("static", { width: 1.8 }), both.path("test", { width: 1.8 })];
  both.path("axis", { dash: "4 4", width: 1.4 }).set([-2, 2], [-2, 2]);
  const [wantedLine, got] = [time.path("ink", { dash: "5 4", width: 1.4 }), time.path("test", { width: 1.8 })];
  const said = h("p", { class: "readout", role: "status" });
  const k = Float64Array.from({ length: 700 }, (_, at) => at);

  const show = (): void => {
    const wanted = Float64Array.from(k, MOTIONS[motion]);
    const model = Model.make(core, THRESHOLDS, weights);
    const undo = model.inverse();
    const gain = weights.reduce((all, each) => all + each, 0);
    const plain = Float64Array.from(wanted, (each) => each / gain);
    const x = compensated && undo ? undo.run(wanted) : plain;
    const reach = weights.reduce((all, each, at) => (at ? all + each * (1 - THRESHOLDS[at]) : 0), 0); // of the plays at x = 1
    const real = Float64Array.from(weights, (each, at) => (at ? each * scale : Math.max(0.02, each + (1 - scale) * reach)));
    const y = ran(Model.make(core, THRESHOLDS, real), x);
    undo?.free();
    model.free();
    paths[0].set(x, y);
    paths[1].set(wanted, x);
    paths[2].set(wanted, y);
    wantedLine.set(k, wanted);
    got.set(k, y);
    const range = Math.max(...wanted) - Math.min(...wanted);
    const rms = Math.sqrt(y.reduce((all, each, at) => all + (each - wanted[at]) ** 2, 0) / y.length);
    const words = rms < 1e-9 * range ? "no more than rounding" : `${short((100 * rms) / range, 3)} % of its range rms`;
    said.textContent = `${compensated ? "With" : "Without"} the inverse the output misses what is wanted by ${words}.`;
  };
  listeners.push(show);
  const box = h("input", { type: "checkbox", checked: true, onchange: () => { compensated = box.checked; show(); } });
  const choose = h("select", { onchange: () => { motion = choose.value; show(); } }, ...Object.keys(MOTIONS).map((name) => h("option", {}, name)));
  root.querySelector(".caption")!.after(h("div", { class: "sliders" },
    h("label", { class: "slider" }, "wanted motion", choose),
    h("label", { class: "check" }, box, "compensated by the inverse"),
    slider("hysteresis of the actuator, of that in the model", 0, 1.5, 0.05, 1, (value) => { scale = value; show(); }, " ×"),
  ), panels, said);
  root.append(h("p", { class: "caption" }, "The weights are those above. An actuator with less hysteresis than its model is driven too far, and may be worse off than without: that is why a model is judged on loops that it has not seen."));
  show();
}
