/** The tab "On an arm": recorded trials of the simulated arm of the paper's experiment, without and with compensator.
 * arm.json is written by page/arm.py from a run of `make demo`. */

import recorded from "./arm.json";
import { h, onScheme } from "./dom";
import { paint, s } from "./plane";
import { Link, short, TimePlot } from "./plots";
import type { Core } from "./wasm";

const KINDS = [
  { name: "off", title: "without compensator", short: "without", colour: "test" },
  { name: "paper", title: "the paper’s compensator", short: "the paper’s", colour: "static" },
  { name: "best", title: "the best compensator", short: "the best", colour: "train" },
] as const;
const BENDS = 3; // points of a pose: where joints 2, 4 and 6 are

interface Trial {
  title: string;
  samples: number;
  step: number; // s
  joints: number;
  rms: Record<string, number[]>; // of each joint [deg], and of the tool [mm]
  time: Float64Array;
  pose: Float64Array[]; // x, y, z of each bend [mm]
  desired: Float64Array[]; // [deg]
  tool: Float64Array[]; // x, y, z, where it should be [mm]
  error: Float64Array[][]; // kind, joint [deg]
  miss: Float64Array[][]; // kind, axis [mm]
}

/** Unpack the trials: differences of rounded values, zigzag, seven bits a byte. */
async function unpack(): Promise<Trial[]> {
  const stream = new Blob([Uint8Array.from(atob(recorded.data), (letter) => letter.charCodeAt(0))]).stream().pipeThrough(new DecompressionStream("gzip"));
  const bytes = new Uint8Array(await new Response(stream).arrayBuffer());
  let at = 0;
  const column = (samples: number, step: number): Float64Array => {
    const values = new Float64Array(samples);
    for (let k = 0, level = 0; k < samples; k++) {
      let [code, shift] = [0, 0];
      do {
        code |= (bytes[at] & 127) << shift;
        shift += 7;
      } while (bytes[at++] & 128);
      level += code & 1 ? -(code + 1) / 2 : code / 2;
      values[k] = level * step;
    }
    return values;
  };
  const { pose, angle, error, place, miss } = recorded.steps;
  return recorded.trials.map((about) => {
    const columns = (number: number, step: number): Float64Array[] => Array.from({ length: number }, () => column(about.samples, step));
    const time = Float64Array.from({ length: about.samples }, (_, k) => k * about.step);
    const shared = { pose: columns(3 * BENDS, pose), desired: columns(about.joints, angle), tool: columns(3, place) };
    const each = KINDS.map(() => ({ error: columns(about.joints, error), miss: columns(3, miss) }));
    return { ...about, time, ...shared, error: each.map((one) => one.error), miss: each.map((one) => one.miss) };
  });
}

/** Fill the tab; called when it is opened for the first time. */
export function mount(root: HTMLElement, _core: Core): void {
  void unpack().then((trials) => show(root, trials));
}

function show(root: HTMLElement, trials: Trial[]): void {
  let trial = trials[0];
  let [joint, at, running] = [3, 0, 0];
  const link = new Link();
  const view = new View();
  const chosen = h("select", { onchange: () => { trial = trials[Number(chosen.value)]; all(); } }, ...trials.map(({ title }, k) => h("option", { value: k }, title)));
  const which = h("select", { onchange: () => { joint = Number(which.value); errors(); } }, ...trial.desired.map((_, k) => h("option", { value: k }, `joint ${k + 1}`)));
  which.value = String(joint);
  const larger = h("select", { onchange: () => { view.larger = Number(larger.value); view.still(trial); view.move(trial, at); } }, ...[1, 3, 10].map((by) => h("option", { value: by }, by === 1 ? "as they are" : `${by} times larger`)));
  const play = h("button", { type: "button", class: "main", onclick: () => (running ? stop() : start()) }, "Play");
  const scrub = h("input", { type: "range", min: 0, max: 1, step: 1, value: 0, oninput: () => { stop(); go(scrub.valueAsNumber); } });
  const clock = h("output", {}, "0 s");
  const figure = h("div");
  const table = h("tbody");
  let plot: TimePlot | null = null;

  const go = (k: number): void => {
    at = Math.max(0, Math.min(trial.samples - 1, Math.round(k)));
    scrub.value = String(at);
    scrub.setAttribute("aria-valuetext", `${short(trial.time[at])} s`);
    clock.textContent = `${trial.time[at].toFixed(1)} s`;
    view.move(trial, at);
    cells();
    link.set(at);
  };
  const cells = (): void => {
    const miss = (kind: number): number => Math.hypot(...trial.miss[kind].map((axis) => axis[at]));
    const row = (name: string, now: (kind: number) => number, rms: (name: string) => number): HTMLElement =>
      h("tr", {}, h("th", { scope: "row" }, name), ...KINDS.flatMap(({ name: kind }, k) => [h("td", { class: "number" }, now(k).toFixed(2).replace("-", "−")), h("td", { class: "number rms" }, rms(kind).toFixed(2))]));
    table.replaceChildren(
      row("tool [mm]", miss, (kind) => trial.rms[kind][trial.joints]),
      ...trial.desired.map((_, j) => row(`joint ${j + 1} [°]`, (kind) => trial.error[kind][j][at], (kind) => trial.rms[kind][j])),
    );
  };
  const errors = (): void => {
    plot?.destroy();
    plot = new TimePlot(figure, {
      title: `Error of joint ${joint + 1}`, name: `error-joint-${joint + 1}`, xLabel: "time [s]", yLabel: "error [°]", height: 260, link,
      described: "Error over time without compensator, with the paper’s and with the best one.",
    });
    plot.set(trial.time, KINDS.map(({ title, colour }, k) => ({ label: title, values: trial.error[k][joint], colour, width: 1.6 })));
  };
  const all = (): void => {
    stop();
    scrub.max = String(trial.samples - 1);
    view.still(trial);
    errors();
    go(0);
  };
  const start = (): void => {
    if (at >= trial.samples - 1) go(0);
    const [begun, from] = [performance.now(), at];
    play.textContent = "Pause";
    const speed = trial.step > trials[0].step ? 4 : 2; // slow trials last long
    const frame = (now: number): void => {
      go(from + ((now - begun) / 1000) * speed / trial.step);
      if (at >= trial.samples - 1 || !play.isConnected || root.hidden) stop();
      else running = requestAnimationFrame(frame);
    };
    running = requestAnimationFrame(frame);
  };
  const stop = (): void => {
    cancelAnimationFrame(running);
    running = 0;
    play.textContent = "Play";
  };
  link.listen((k) => { if (k !== null && k !== at && !running) go(k); });
  const changed = recorded.changed;
  root.append(
    h("h2", {}, "The same path, three times"),
    h("p", { class: "caption" }, "Seven joints, three of them driven by pairs of pneumatic muscles with hysteresis and creep, follow a line, two circles and a rectangle of ISO 9283. Only the compensator differs."),
    h("div", { class: "row" }, h("label", {}, "Trial", chosen), h("label", {}, "Misses of the tool", larger), play, h("label", { class: "slider wide" }, h("span", {}, "time ", clock), scrub)),
    h("div", { class: "panels arm" }, view.element, h("div", {}, h("label", { class: "inline" }, "Figure of ", which), figure,
      h("div", { class: "scroll", tabindex: 0, role: "region", "aria-label": "Error of every joint" }, h("table", { class: "errors" },
        h("caption", { class: "caption" }, "At this moment, and over the whole trial (rms)"),
        h("thead", {}, h("tr", {}, h("td"), ...KINDS.map(({ short: title }) => h("th", { colspan: 2, scope: "colgroup", class: "number" }, title))),
          h("tr", {}, h("td"), ...KINDS.flatMap(() => [h("th", { class: "number", scope: "col" }, "now"), h("th", { class: "number rms", scope: "col" }, "rms")]))), table)))),
    h("p", { class: "caption" }, `A run of dehyst reproduce on the simulated arm (hysteresis: ${recorded.plant}${recorded.conditions ? `, conditions: ${recorded.conditions}` : ""}), thinned to fit into this page: by at most ${short(changed.deg, 2)}° and ${short(changed.mm, 2)} mm at any moment. The rms are those of the whole run. It is a simulation: no arm has been measured.`),
  );
  onScheme(() => plot?.element.isConnected && errors());
  all();
}

/** The arm and the path of its tool, seen from a side that can be turned. */
class View {
  readonly element: HTMLElement;
  larger = 1;
  private readonly svg = s("svg", { viewBox: "0 0 400 400", role: "img", class: "plane arm draggable", "aria-label": "The arm, the path it should follow, and where its tool went" });
  private readonly wanted = paint(s("path", { "stroke-width": 1.2, "stroke-dasharray": "4 3" }), "ink");
  private readonly trails = KINDS.map(({ colour }) => paint(s("path", { "stroke-width": 1.4, "stroke-linejoin": "round" }), colour, null, 0.3));
  private readonly past = KINDS.map(({ colour }) => paint(s("path", { "stroke-width": 2, "stroke-linejoin": "round" }), colour));
  private ways: string[][] = [];
  private readonly tips = KINDS.map(({ colour }) => paint(s("circle", { r: 4.5, "stroke-width": 1.5 }), "paper", colour));
  private readonly links = paint(s("path", { "stroke-width": 9, "stroke-linejoin": "round", "stroke-linecap": "round" }), "axis", null, 0.75);
  private readonly bends = Array.from({ length: BENDS + 1 }, () => paint(s("circle", { r: 4, "stroke-width": 2 }), "axis", "paper"));
  private turn = -0.9;
  private shown: [Trial, number] | null = null;

  constructor() {
    const floor = paint(s("ellipse", { "stroke-width": 1 }), "grid", "grid", 0.6);
    this.svg.append(floor, this.links, ...this.bends, this.wanted, ...this.trails, ...this.past, ...this.tips);
    const [fx, fy] = this.flat(0, 0, 0);
    for (const [name, value] of Object.entries({ cx: fx, cy: fy, rx: 60, ry: 18 })) floor.setAttribute(name, String(value));
    const side = h("input", { type: "range", min: -80, max: 80, step: 1, value: Math.round((this.turn * 180) / Math.PI) });
    const turned = (): void => {
      this.turn = (side.valueAsNumber * Math.PI) / 180;
      if (!this.shown) return;
      this.still(this.shown[0]);
      this.move(...this.shown);
    };
    side.addEventListener("input", turned);
    let from: [number, number] | null = null;
    this.svg.addEventListener("pointerdown", (event) => {
      this.svg.setPointerCapture(event.pointerId);
      from = [event.clientX, side.valueAsNumber];
    });
    this.svg.addEventListener("pointermove", (event) => {
      if (!from || !this.svg.hasPointerCapture(event.pointerId)) return;
      side.valueAsNumber = from[1] + (event.clientX - from[0]) * 0.5;
      turned();
    });
    const legend = h("ul", { class: "legend" }, ...[{ title: "where the tool should be", colour: "ink", dash: true }, ...KINDS.map((kind) => ({ ...kind, dash: false }))].map(({ title, colour, dash }) => {
      const mark = h("span", { class: dash ? "mark dashed" : "mark" });
      mark.style.borderColor = `var(--${colour})`;
      return h("li", {}, mark, title);
    }));
    this.element = h("figure", {}, h("figcaption", {}, h("h3", {}, "The tool’s path")), this.svg, legend, h("label", { class: "slider" }, "seen from", side));
  }

  /** Paths of a whole trial. */
  still(trial: Trial): void {
    const way = (axes: ArrayLike<number>[]): string[] =>
      Array.from(axes[0], (_, k) => `${k ? "L" : "M"}${this.flat(axes[0][k], axes[1][k], axes[2][k]).map((v) => v.toFixed(1)).join(" ")}`);
    this.wanted.setAttribute("d", way(trial.tool).join(""));
    this.ways = trial.miss.map((axes) => way(axes.map((axis, of) => axis.map((v, k) => trial.tool[of][k] + this.larger * v))));
    this.trails.forEach((trail, kind) => trail.setAttribute("d", this.ways[kind].join("")));
  }

  /** The arm and the tools at one moment. */
  move(trial: Trial, at: number): void {
    this.shown = [trial, at];
    this.past.forEach((path, kind) => path.setAttribute("d", this.ways[kind].slice(0, at + 1).join("")));
    const [bx, by, bz] = recorded.base;
    const tool = trial.tool.map((axis) => axis[at]);
    const points = [[0, 0, 0], [bx, by, bz], ...Array.from({ length: BENDS }, (_, k) => [0, 1, 2].map((axis) => trial.pose[3 * k + axis][at])), tool].map(([x, y, z]) => this.flat(x, y, z));
    this.links.setAttribute("d", points.map(([x, y], k) => `${k ? "L" : "M"}${x.toFixed(1)} ${y.toFixed(1)}`).join(""));
    const place = (circle: SVGCircleElement, [x, y]: number[]): void => {
      circle.setAttribute("cx", x.toFixed(1));
      circle.setAttribute("cy", y.toFixed(1));
    };
    this.bends.forEach((circle, k) => place(circle, points[k + 1]));
    this.tips.forEach((circle, kind) => place(circle, this.flat(...(tool.map((v, axis) => v + this.larger * trial.miss[kind][axis][at]) as [number, number, number]))));
  }

  /** Where a point of space [mm] is on the picture: parallel lines of sight, from a little above. */
  private flat(x: number, y: number, z: number): [number, number] {
    const [cos, sin] = [Math.cos(this.turn), Math.sin(this.turn)];
    const [aside, away] = [cos * x - sin * y, sin * x + cos * y];
    return [60 + 0.36 * aside, 375 - 0.33 * z - 0.1 * away];
  }
}
