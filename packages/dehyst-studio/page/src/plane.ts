/** Small drawings with fixed axes, in SVG: a plane of two quantities, with paths, points and areas that move. */

import { h } from "./dom";

type Attributes = Record<string, string | number>;

/** An element of SVG. A colour is given by `paint`, as a token, so that it follows light and dark. */
export function s<K extends keyof SVGElementTagNameMap>(tag: K, attributes: Attributes = {}, ...children: (Node | string)[]): SVGElementTagNameMap[K] {
  const element = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, String(value));
  element.append(...children);
  return element;
}

/** Line and area of an element in colour tokens; null: none. */
export function paint<E extends SVGElement>(element: E, line: string | null, area: string | null = null, opacity = 1): E {
  element.style.stroke = line === null ? "none" : `var(--${line})`;
  element.style.fill = area === null ? "none" : `var(--${area})`;
  if (opacity < 1) element.style.opacity = String(opacity);
  return element;
}

export interface Axis {
  label: string;
  low: number;
  high: number;
  ticks?: number[];
}

const ROOM = { left: 46, right: 12, top: 10, bottom: 40 };

export class Plane {
  readonly element: HTMLElement;
  readonly svg: SVGSVGElement;
  private readonly inside: SVGGElement;
  private readonly above: SVGGElement;

  constructor(
    root: HTMLElement,
    title: string,
    described: string,
    private readonly x: Axis,
    private readonly y: Axis,
    private readonly size = { width: 360, height: 300 },
  ) {
    const { width, height } = size;
    this.svg = s("svg", { viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": `${title}. ${described}`, class: "plane" });
    const frame = { x: ROOM.left, y: ROOM.top, width: width - ROOM.left - ROOM.right, height: height - ROOM.top - ROOM.bottom };
    const id = `clip-${Math.random().toString(36).slice(2)}`;
    this.svg.append(s("clipPath", { id }, s("rect", frame)));
    for (const at of x.ticks ?? []) {
      this.svg.append(paint(s("line", { x1: this.px(at), x2: this.px(at), y1: frame.y, y2: frame.y + frame.height }), at === 0 ? "axis" : "grid"));
      this.svg.append(s("text", { x: this.px(at), y: frame.y + frame.height + 15, "text-anchor": "middle" }, tick(at)));
    }
    for (const at of y.ticks ?? []) {
      this.svg.append(paint(s("line", { y1: this.py(at), y2: this.py(at), x1: frame.x, x2: frame.x + frame.width }), at === 0 ? "axis" : "grid"));
      this.svg.append(s("text", { x: frame.x - 6, y: this.py(at) + 4, "text-anchor": "end" }, tick(at)));
    }
    this.svg.append(s("text", { x: frame.x + frame.width / 2, y: height - 6, "text-anchor": "middle", class: "axis" }, x.label));
    const middle = frame.y + frame.height / 2;
    this.svg.append(s("text", { x: 12, y: middle, "text-anchor": "middle", transform: `rotate(-90 12 ${middle})`, class: "axis" }, y.label));
    this.inside = s("g", { "clip-path": `url(#${id})` });
    this.above = s("g");
    this.svg.append(this.inside, this.above);
    this.element = h("figure", {}, h("figcaption", {}, h("h3", {}, title)), this.svg);
    root.append(this.element);
  }

  px(x: number): number {
    return ROOM.left + ((x - this.x.low) / (this.x.high - this.x.low)) * (this.size.width - ROOM.left - ROOM.right);
  }

  py(y: number): number {
    return this.size.height - ROOM.bottom - ((y - this.y.low) / (this.y.high - this.y.low)) * (this.size.height - ROOM.top - ROOM.bottom);
  }

  /** The abscissa below a pointer. */
  under(event: PointerEvent): number {
    const box = this.svg.getBoundingClientRect();
    const at = ((event.clientX - box.left) / box.width) * this.size.width;
    return this.x.low + ((at - ROOM.left) / (this.size.width - ROOM.left - ROOM.right)) * (this.x.high - this.x.low);
  }

  /** Something that moves inside the frame. */
  add<E extends SVGElement>(element: E): E {
    this.inside.append(element);
    return element;
  }

  /** A path in a colour; `set` gives it its points. */
  path(line: string | null, { width = 1.8, dash = "", area = null as string | null, opacity = 1 } = {}): Path {
    const path = paint(s("path", { "stroke-width": width, "stroke-linejoin": "round", "stroke-linecap": "round" }), line, area, opacity);
    if (dash) path.setAttribute("stroke-dasharray", dash);
    return new Path(this, this.add(path));
  }

  /** A point; it may touch the frame. */
  dot(colour: string, radius = 5): (x: number, y: number) => void {
    const circle = paint(s("circle", { r: radius, "stroke-width": 1.5 }), "paper", colour);
    this.above.append(circle);
    return (x, y) => {
      circle.setAttribute("cx", String(this.px(x)));
      circle.setAttribute("cy", String(this.py(y)));
    };
  }

  /** A word at a place of the plane. */
  word(x: number, y: number, text: string, anchor = "middle"): SVGTextElement {
    const element = s("text", { x: this.px(x), y: this.py(y), "text-anchor": anchor, class: "word" }, text);
    this.above.append(element);
    return element;
  }
}

export class Path {
  constructor(
    private readonly plane: Plane,
    readonly element: SVGPathElement,
  ) {}

  /** Points from index `from` on; a number that is none interrupts. */
  set(x: ArrayLike<number>, y: ArrayLike<number>, from = 0, to = x.length): void {
    let [text, pen] = ["", false];
    for (let k = Math.max(0, from); k < to; k++) {
      const [px, py] = [this.plane.px(x[k]), this.plane.py(y[k])];
      if (!(Number.isFinite(px) && Number.isFinite(py))) pen = false;
      else {
        text += `${pen ? "L" : "M"}${px.toFixed(1)} ${py.toFixed(1)}`;
        pen = true;
      }
    }
    this.element.setAttribute("d", text || "M0 0");
  }
}

function tick(value: number): string {
  return String(Number(value.toFixed(3))).replace("-", "−");
}
