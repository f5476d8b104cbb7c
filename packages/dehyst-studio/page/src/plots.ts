/** Figures: signals over time and loops in the plane, by uPlot; zoom by dragging or keys, one linked cursor, PNG. */

import uPlot from "uplot";
import { h, onScheme, save, token } from "./dom";

/** One cursor for several figures: the index of a sample, or null. */
export class Link {
  private readonly listeners = new Set<(k: number | null) => void>();
  last: number | null = null;

  listen(listener: (k: number | null) => void): () => void {
    this.listeners.add(listener);
    return () => this.listeners.delete(listener);
  }

  set(k: number | null): void {
    if (k === this.last) return;
    this.last = k;
    for (const listener of this.listeners) listener(k);
  }
}

export interface Line {
  label: string;
  values: ArrayLike<number>;
  colour: string; // a token: ink, train, test, data, model, static, other, …
  width?: number;
  dash?: number[];
  bars?: boolean;
}

export interface Curve extends Omit<Line, "values"> {
  x: ArrayLike<number>;
  y: ArrayLike<number>;
  points?: boolean;
  linked?: boolean; // whether the linked cursor walks along it
}

/** Part of the abscissa with a background: from, to, a colour token. */
export interface Shade {
  from: number;
  to: number;
  colour: string;
}

export interface FigureOptions {
  title: string;
  name: string; // of the PNG, without ending
  xLabel: string;
  yLabel: string;
  height?: number;
  link?: Link;
  described?: string; // what somebody who does not see it should know
}

const FONT = '12px system-ui, -apple-system, "Segoe UI", Roboto, "Noto Sans", "DejaVu Sans", sans-serif';

const LONG = 20_000; // points of a curve
const PASSES = 3; // of a long curve through a place of two by two pixels, at which it is full

abstract class Figure {
  readonly element: HTMLElement;
  protected readonly box: HTMLDivElement;
  private readonly caption: HTMLElement;
  protected plot: uPlot | null = null;
  private readonly watch: ResizeObserver;
  private unlink: (() => void) | null = null;
  private readonly unscheme: () => void;

  constructor(
    root: HTMLElement,
    protected readonly options: FigureOptions,
  ) {
    this.box = h("div", {
      class: "plot",
      tabindex: 0,
      role: "img",
      "aria-label": `${options.title}. ${options.described ?? ""} Keys: + and − zoom, arrows move, 0 shows all.`,
      onkeydown: (event: KeyboardEvent) => this.key(event),
    });
    this.caption = h("figcaption", {}, h("h3", {}, options.title));
    const buttons = h("div", { class: "tools" },
      h("button", { type: "button", class: "quiet", onclick: () => this.whole(), "aria-label": `Show all of: ${options.title}` }, "Show all"),
      h("button", { type: "button", class: "quiet", onclick: () => this.png(), "aria-label": `Save as PNG: ${options.title}` }, "PNG"),
    );
    this.element = h("figure", {}, h("div", { class: "head" }, this.caption, buttons), this.box);
    root.append(this.element);
    this.watch = new ResizeObserver(() => this.fit());
    this.watch.observe(this.box);
    this.unscheme = onScheme(() => this.plot?.redraw());
    if (options.link) this.unlink = options.link.listen((k) => this.follow(k));
  }

  destroy(): void {
    this.unlink?.();
    this.unscheme();
    this.watch.disconnect();
    this.plot?.destroy();
    this.plot = null;
    this.element.remove();
  }

  /** Save the figure as a PNG, on paper of the present colour, with its title and what its lines are. */
  png(): void {
    if (!this.plot) return;
    const from = this.plot.ctx.canvas;
    const scale = devicePixelRatio;
    const canvas = h("canvas", { width: from.width, height: 0 });
    const ctx = canvas.getContext("2d")!;
    const [title, plain] = [FONT.replace("12px", `600 ${14 * scale}px`), FONT.replace("12px", `${12 * scale}px`)];
    ctx.font = title;
    let [x, y] = [20 * scale + ctx.measureText(this.options.title).width, 20 * scale];
    ctx.font = plain;
    const keys = this.keys().map(({ label, colour }) => {
      const width = 32 * scale + ctx.measureText(label).width;
      if (x + width > from.width) [x, y] = [10 * scale, y + 18 * scale];
      x += width;
      return { label, colour, x: x - width, y };
    });
    const head = y + 10 * scale;
    canvas.height = from.height + head; // which forgets the font
    ctx.fillStyle = token("paper");
    ctx.fillRect(0, 0, canvas.width, canvas.height);
    ctx.fillStyle = token("ink");
    ctx.font = title;
    ctx.fillText(this.options.title, 10 * scale, 20 * scale);
    ctx.font = plain;
    for (const key of keys) {
      ctx.fillStyle = token(key.colour);
      ctx.fillRect(key.x, key.y - 6 * scale, 14 * scale, 3 * scale);
      ctx.fillStyle = token("ink");
      ctx.fillText(key.label, key.x + 19 * scale, key.y);
    }
    ctx.drawImage(from, 0, head);
    canvas.toBlob((blob) => blob && save(`${this.options.name}.png`, blob, "image/png"));
  }

  protected abstract keys(): Pick<Line, "label" | "colour">[];
  protected abstract whole(): void;
  protected abstract follow(k: number | null): void;

  protected axes(): uPlot.Axis[] {
    const common = {
      stroke: () => token("muted"),
      grid: { stroke: () => token("grid"), width: 1 },
      ticks: { stroke: () => token("axis"), width: 1, size: 4 },
      font: FONT,
      labelFont: FONT,
      labelSize: 20,
    };
    return [
      { ...common, label: this.options.xLabel, size: 34 },
      { ...common, label: this.options.yLabel, size: (_u, values) => Math.max(44, 12 + 7 * Math.max(0, ...(values ?? []).map((v) => v.length))) },
    ];
  }

  protected size(): { width: number; height: number } {
    return { width: Math.max(200, this.box.clientWidth), height: this.options.height ?? 280 };
  }

  private fit(): void {
    const { width, height } = this.size();
    if (this.plot && (this.plot.width !== width || this.plot.height !== height)) this.plot.setSize({ width, height });
  }

  private key(event: KeyboardEvent): void {
    if (!this.plot) return;
    const zoom = { "+": 0.5, "=": 0.5, "-": 2 }[event.key];
    const move = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    if (event.key === "0") this.whole();
    else if (zoom !== undefined) this.view((low, high) => [(low + high) / 2 - (zoom * (high - low)) / 2, (low + high) / 2 + (zoom * (high - low)) / 2]);
    else if (move) this.view((low, high, axis) => [low + 0.2 * move[axis] * (high - low), high + 0.2 * move[axis] * (high - low)]);
    else return;
    event.preventDefault();
  }

  private view(change: (low: number, high: number, axis: 0 | 1) => [number, number]): void {
    const keys = this.plane() ? (["x", "y"] as const) : (["x"] as const);
    this.plot!.batch(() => {
      keys.forEach((key, axis) => {
        const { min, max } = this.plot!.scales[key];
        if (min === undefined || max === undefined || min === null || max === null) return;
        const [low, high] = change(min, max, axis as 0 | 1);
        this.plot!.setScale(key, { min: low, max: high });
      });
    });
  }

  protected plane(): boolean {
    return false;
  }
}

let more = false; // whether Shift was down where the last brush began; figures with one cursor are brushed together

/** Signals over time (or over the number of the sample). */
export class TimePlot extends Figure {
  private t: ArrayLike<number> = [];
  private readonly onBrush: ((from: number, to: number, more: boolean) => void) | undefined;
  private shades: Shade[] = [];
  private lines: Line[] = [];

  constructor(root: HTMLElement, options: FigureOptions & { onBrush?: (from: number, to: number, more: boolean) => void }) {
    super(root, options);
    this.onBrush = options.onBrush;
    this.box.addEventListener("mousedown", ({ shiftKey }) => { more = shiftKey; }, true);
  }

  protected keys(): Line[] {
    return this.lines;
  }

  /** Show lines over t, which rises. */
  set(t: ArrayLike<number>, lines: Line[], shades: Shade[] = []): void {
    this.t = t;
    this.lines = lines;
    this.shades = shades;
    const data = [t, ...lines.map((line) => line.values)] as unknown as uPlot.AlignedData;
    if (this.plot && this.plot.series.length === lines.length + 1) {
      this.plot.setData(data);
      return;
    }
    this.plot?.destroy();
    this.plot = new uPlot(
      {
        ...this.size(),
        // Bars begin at 0, and those at the ends are seen whole.
        scales: lines.some(({ bars }) => bars) ? { x: { time: false, range: (_u, low, high) => [low - 0.02 * (high - low), high + 0.02 * (high - low)] }, y: { range: (_u, low, high) => [Math.min(0, low), Math.max(0, 1.05 * high)] } } : { x: { time: false } },
        axes: this.axes(),
        legend: { markers: { width: 3 } },
        cursor: {
          y: false,
          drag: { x: true, y: false, setScale: !this.onBrush },
          points: { size: 7 },
          ...(this.options.link ? { sync: { key: "dehyst" } } : {}),
        },
        series: [
          { label: this.options.xLabel, value: (_u, v) => short(v) },
          ...lines.map((line) => ({
            label: line.label,
            stroke: () => token(line.colour),
            width: line.width ?? 1.4,
            ...(line.dash ? { dash: line.dash } : {}),
            ...(line.bars ? { paths: uPlot.paths.bars!({ size: [0.7, 26, 2] }), fill: () => token(line.colour) } : {}),
            points: { show: false },
            value: (_u: uPlot, v: number) => short(v),
          })),
        ],
        hooks: {
          ready: [() => setTimeout(() => this.follow(this.options.link?.last ?? null))],
          drawClear: [(u) => this.shade(u)],
          setCursor: [(u) => { if (u.cursor.event) this.options.link?.set(u.cursor.idx ?? null); }],
          setSelect: [(u) => {
            const { left, width } = u.select;
            if (!this.onBrush || width < 3) return;
            u.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
            this.onBrush(u.posToVal(left, "x"), u.posToVal(left + width, "x"), more);
          }],
        },
      },
      data,
      this.box,
    );
  }

  /** Other parts with a background; lines and view stay. */
  mark(shades: Shade[]): void {
    this.shades = shades;
    this.plot?.redraw(false);
  }

  /** Where a height within the figure [CSS pixels] lies between two values, 0 to 1. */
  share(pixels: number, low: number, high: number): number {
    const value = this.plot ? this.plot.posToVal(pixels, "y") : low;
    return Math.min(1, Math.max(0, (value - low) / (high - low)));
  }

  protected whole(): void {
    if (this.t.length) this.plot?.setScale("x", { min: this.t[0], max: this.t[this.t.length - 1] });
  }

  protected follow(k: number | null): void {
    const u = this.plot;
    if (!u || u.cursor.event) return;
    u.setCursor(k === null ? { left: -10, top: -10 } : { left: u.valToPos(this.t[k], "x"), top: 0 }, false);
    if (k !== null) u.setLegend({ idx: k }, false); // not the sample beside it, to which rounding of pixels may lead
  }

  private shade(u: uPlot): void {
    const { ctx, bbox } = u;
    for (const { from, to, colour } of this.shades) {
      const left = Math.max(bbox.left, u.valToPos(from, "x", true));
      const right = Math.min(bbox.left + bbox.width, u.valToPos(to, "x", true));
      if (right <= left) continue;
      ctx.save();
      ctx.globalAlpha = 0.13;
      ctx.fillStyle = token(colour);
      ctx.fillRect(left, bbox.top, right - left, bbox.height);
      ctx.restore();
    }
  }
}

/** Curves in the plane: a loop, its model, a compensated loop around 45°. */
export class LoopPlot extends Figure {
  private curves: Curve[] = [];
  private readonly readout: HTMLElement;
  private readonly dot: HTMLElement;
  private readonly equal: boolean;

  constructor(root: HTMLElement, options: FigureOptions & { equal?: boolean }) {
    super(root, options);
    this.equal = options.equal ?? false;
    this.readout = h("p", { class: "readout" }, "\u00a0");
    this.dot = h("div", { class: "dot", hidden: true });
    this.element.append(this.readout);
  }

  protected keys(): Curve[] {
    return this.curves;
  }

  /** Show curves; the view stays where it is if `keep`. */
  set(curves: Curve[], keep = false): void {
    this.curves = curves;
    const data = [null, ...curves.map(({ x, y }) => [x, y])] as unknown as uPlot.AlignedData;
    if (this.plot && this.plot.series.length === curves.length + 1) {
      this.plot.setData(data, !keep);
      if (keep) this.plot.redraw();
      return;
    }
    this.plot?.destroy();
    const extent = (of: "x" | "y") => (): [number, number] => {
      let [low, high] = [Infinity, -Infinity];
      for (const curve of this.equal ? this.curves.flatMap((c) => [c.x, c.y]) : this.curves.map((c) => c[of])) {
        for (let k = 0; k < curve.length; k++) {
          if (curve[k] < low) low = curve[k];
          if (curve[k] > high) high = curve[k];
        }
      }
      if (!(low <= high)) return [0, 1];
      const room = 0.04 * (high - low) || 1;
      return [low - room, high + room];
    };
    let zoomed: { x: [number, number]; y: [number, number] } | null = null;
    const range = (of: "x" | "y") => (_u: uPlot, low: number | null, high: number | null): [number, number] =>
      zoomed && low !== null && high !== null ? [low, high] : extent(of)();
    this.zoomTo = (view) => { zoomed = view; };
    this.plot = new uPlot(
      {
        ...this.size(),
        mode: 2,
        scales: { x: { time: false, range: range("x") }, y: { range: range("y") } },
        axes: this.axes(),
        legend: { show: false },
        cursor: { drag: { x: true, y: true, setScale: false }, points: { show: false } },
        series: [{}, ...curves.map((curve, at) => ({
          label: curve.label,
          stroke: () => token(curve.colour),
          width: curve.width ?? 1.4,
          facets: [{ scale: "x", auto: true }, { scale: "y", auto: true }],
          paths: (u: uPlot) => this.draw(u, this.curves[at]),
        }))] as unknown as uPlot.Series[],
        hooks: {
          setSelect: [(u) => {
            const { left, top, width, height } = u.select;
            if (width < 3 || height < 3) return;
            zoomed = {
              x: [u.posToVal(left, "x"), u.posToVal(left + width, "x")],
              y: [u.posToVal(top + height, "y"), u.posToVal(top, "y")],
            };
            const view = zoomed;
            u.batch(() => {
              u.setScale("x", { min: view.x[0], max: view.x[1] });
              u.setScale("y", { min: view.y[0], max: view.y[1] });
            });
            u.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
          }],
          setCursor: [(u) => { if (u.cursor.event) this.hover(u); }],
        },
      },
      data,
      this.box,
    );
    this.plot.over.append(this.dot);
    this.legend();
  }

  private zoomTo: (view: { x: [number, number]; y: [number, number] } | null) => void = () => undefined;

  protected override plane(): boolean {
    this.zoomTo({ x: [0, 1], y: [0, 1] });
    return true;
  }

  protected whole(): void {
    this.zoomTo(null);
    this.plot?.batch(() => {
      this.plot!.setScale("x", { min: 0, max: 1 });
      this.plot!.setScale("y", { min: 0, max: 1 });
    });
  }

  protected follow(k: number | null): void {
    const curve = this.curves.find((each) => each.linked);
    const u = this.plot;
    this.dot.hidden = k === null || !u || !curve || !(k < curve.x.length);
    if (this.dot.hidden || !u || !curve || k === null) return;
    this.dot.style.transform = `translate(${u.valToPos(curve.x[k], "x")}px, ${u.valToPos(curve.y[k], "y")}px)`;
    this.readout.textContent = `${this.options.xLabel} ${short(curve.x[k])}, ${this.options.yLabel} ${short(curve.y[k])}`;
  }

  private hover(u: uPlot): void {
    const curve = this.curves.find((each) => each.linked);
    const { left = -1, top = -1 } = u.cursor;
    if (!curve) return;
    if (left < 0) {
      this.follow(null);
      this.options.link?.set(null);
      return;
    }
    const [x, y] = [u.posToVal(left, "x"), u.posToVal(top, "y")];
    const [sx, sy] = [u.posToVal(1, "x") - u.posToVal(0, "x"), u.posToVal(0, "y") - u.posToVal(1, "y")];
    const stride = Math.ceil(curve.x.length / 200_000);
    let [best, found] = [Infinity, -1];
    for (let k = 0; k < curve.x.length; k += stride) {
      const distance = ((curve.x[k] - x) / sx) ** 2 + ((curve.y[k] - y) / sy) ** 2;
      if (distance < best) [best, found] = [distance, k];
    }
    const k = found < 0 || best > 900 ? null : found;
    this.follow(k);
    this.options.link?.set(k);
  }

  private draw(u: uPlot, curve: Curve): null {
    const { ctx, bbox } = u;
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    ctx.strokeStyle = ctx.fillStyle = token(curve.colour);
    ctx.lineWidth = (curve.width ?? 1.4) * devicePixelRatio;
    ctx.lineJoin = "round";
    ctx.setLineDash((curve.dash ?? []).map((d) => d * devicePixelRatio));
    const [x0, kx] = line(u, "x");
    const [y0, ky] = line(u, "y");
    ctx.beginPath();
    // Of a long curve, what goes once more from one place that is full to another is not to be seen, and slow to draw.
    const wide = curve.x.length > LONG ? (bbox.left + bbox.width >> 1) + 1 : 0;
    const drawn = new Uint8Array(wide * ((bbox.top + bbox.height >> 1) + 1));
    let px = NaN, py = NaN, pen = false, full = false;
    for (let k = 0; k < curve.x.length; k++) {
      const cx = x0 + kx * curve.x[k], cy = y0 + ky * curve.y[k];
      if (!(Number.isFinite(cx) && Number.isFinite(cy))) {
        px = NaN;
        pen = false;
        continue;
      }
      if (Math.abs(cx - px) + Math.abs(cy - py) < 0.5) continue; // the same pixel
      const before = full, at = cx >= 0 && cx < 2 * wide ? (cy >> 1) * wide + (cx >> 1) : -1;
      full = drawn[at] >= PASSES;
      if (curve.points) ctx.rect(cx - 1, cy - 1, 2, 2);
      else if (full && before) pen = false;
      else {
        if (!pen) ctx.moveTo(px === px ? px : cx, px === px ? py : cy);
        ctx.lineTo(cx, cy);
        drawn[at]++;
        pen = true;
      }
      px = cx;
      py = cy;
    }
    if (curve.points) ctx.fill();
    else ctx.stroke();
    ctx.restore();
    return null;
  }

  private legend(): void {
    this.element.querySelector("ul.legend")?.remove();
    const list = h("ul", { class: "legend" }, ...this.curves.map(({ label, colour, dash }) => {
      const mark = h("span", { class: dash ? "mark dashed" : "mark" });
      mark.style.borderColor = `var(--${colour})`;
      return h("li", {}, mark, label);
    }));
    this.readout.before(list);
  }
}

/** Canvas position of a value as x0 + k value: a loop of 100 000 points asks for it as often. */
function line(u: uPlot, axis: "x" | "y"): [number, number] {
  const { min = 0, max = 1 } = u.scales[axis];
  const [from, to] = [u.valToPos(min, axis, true), u.valToPos(max, axis, true)];
  const slope = (to - from) / (max - min);
  return [from - slope * min, slope];
}

/** A number in four digits, as people write it. */
export function short(value: number | null | undefined, digits = 4): string {
  if (value === null || value === undefined || Number.isNaN(value)) return "–";
  if (value === 0) return "0";
  const size = Math.abs(value);
  const text = size >= 1e6 || size < 1e-4 ? value.toExponential(digits - 1) : String(Number(value.toPrecision(digits)));
  return text.replace("-", "−");
}
