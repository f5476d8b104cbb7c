"use strict";
// Zooms panels and tells the values at the cursor. It reads both off the drawing: no sample is on the page twice.
const MOST = 40, NEAR = 5; // largest zoom; a drawn sample this close attracts the cursor [point]
const within = (value, low, high) => Math.min(Math.max(value, low), high);
const text = (value, digits) => (+value.toFixed(digits) || 0).toFixed(digits).replace("-", "−");

function axisOf(start, end, [low, high, label]) { // from places on the drawing to values
  const [, name, unit = ""] = label.match(/^(.*?)(?: \[(?:1|(.*))\])?$/), scale = (high - low) / (end - start);
  const digits = Math.max(0, Math.ceil(-Math.log10((high - low) / 2000))); // a drawing says no more
  const value = place => low + (place - start) * scale;
  const say = (place, other) => `${other || name} ${text(value(place), digits)} ${unit}`.trim();
  return { start, end, label, value, say, place: value => start + (value - low) / scale };
}

function curveOf(group) {
  const path = group.querySelector(":scope > path"), dots = [...group.querySelectorAll("use")];
  const joined = path ? [...path.getAttribute("d").matchAll(/([ML]) (\S+) (\S+)/g)] : [];
  const drawn = path ? joined.map(([, how, u, v]) => [+u, +v, how === "L"])
    : dots.map(dot => [...["x", "y"].map(name => +dot.getAttribute(name)), false]);
  const colour = path ? path.style.stroke : dots[0].style.fill;
  return { drawn, dotted: !path, name: group.dataset.about.trim(), colour };
}

function heightAt({ drawn, dotted }, x, y) { // of a curve at x; a loop has several, and the one next to y is meant
  let best = null;
  drawn.forEach(([u, v, joined], k) => {
    const [u0, v0] = joined ? drawn[k - 1] : [u, v];
    if (dotted ? Math.abs(u - x) > 0.5 : !joined || (u0 - x) * (u - x) > 0) return;
    const found = u === u0 ? v : v0 + (x - u0) / (u - u0) * (v - v0);
    if (best === null || Math.abs(found - y) < Math.abs(best - y)) best = found;
  });
  return best;
}

function rowOf(group) {
  const [left, bottom, right, , , top] = group.querySelector("path").getAttribute("d").match(/[\d.]+/g).map(Number);
  const [across, up] = JSON.parse(group.dataset.about);
  const was = [...group.querySelectorAll("path[clip-path], [clip-path] use")].filter(one => !one.closest(".across, .up"))
    .map(one => [one, ...["d", "x"].map(name => [name, one.getAttribute(name)]).find(([, value]) => value !== null)]);
  const loose = [...group.children].filter(one => { // arrows and words within the axes
    const box = one.getBBox();
    return !one.querySelector("[clip-path]") && box.x > left + 1 && box.y > top + 1 && box.y + box.height < bottom - 1;
  });
  const ticks = [...group.querySelectorAll(".across > g")].filter(one => one.querySelector("use"));
  const curves = [...group.querySelectorAll(".curve")].filter(one => one.querySelector(":scope > path, use")).map(curveOf);
  return { x: axisOf(left, right, across), y: axisOf(bottom, top, up), was, loose, ticks, curves };
}

function panelOf(svg) {
  const rows = [...svg.querySelectorAll(".axes")].map(rowOf), { x } = rows[0];
  const top = rows[0].y.end, bottom = rows.at(-1).y.start;
  const rises = ({ drawn }) => drawn.every(([u], k) => !k || u >= drawn[k - 1][0]);
  const series = rows.every(({ curves }) => curves.every(rises));
  const frame = svg.parentElement, told = frame.appendChild(document.createElement("output"));
  const make = (parent, tag, attributes) => {
    const made = parent.appendChild(document.createElementNS(svg.namespaceURI, tag));
    for (const name in attributes) made.setAttribute(name, attributes[name]);
    return made;
  };
  const over = make(svg, "g", { class: "over" });
  let [from, to] = [x.start, x.end], held = null, at = null; // what is shown; where a drag began; the cursor
  const shown = place => x.start + (place - from) / (to - from) * (x.end - x.start);
  const drawn = place => from + (place - x.start) / (x.end - x.start) * (to - from);
  const hit = ({ clientX, clientY }) => new DOMPoint(clientX, clientY).matrixTransform(svg.getScreenCTM().inverse());

  function hide() {
    over.replaceChildren();
    told.hidden = true;
  }
  function leave() {
    at = held = null;
    panels.forEach(one => one.hide());
  }
  function tell(u, v, k, own) {
    hide();
    if (u < from || u > to) return;
    const place = shown(u), lines = [[x.say(u), "transparent"]];
    make(over, "line", { x1: place, x2: place, y1: top, y2: bottom });
    for (const { y, curves } of rows) for (const curve of curves) {
      const height = heightAt(curve, u, y === rows[k]?.y ? v : y.end);
      if (height === null) continue;
      make(over, "circle", { cx: place, cy: height, r: 2.6 }).style.fill = curve.colour;
      lines.push([y.say(height, curve.name), curve.colour]);
    }
    told.replaceChildren(...lines.map(([textContent, colour]) => {
      const made = Object.assign(document.createElement("span"), { textContent });
      made.style.borderColor = colour;
      return made;
    }));
    told.hidden = false;
    told.ariaLive = own ? "polite" : "off";
    const { x: left, y: above, width } = frame.getBoundingClientRect(), room = told.offsetWidth;
    const tip = new DOMPoint(place, v).matrixTransform(svg.getScreenCTM()), right = tip.x - left + 14;
    told.style.left = `${within(right + room > width ? right - room - 28 : right, 0, width - room)}px`;
    told.style.top = `${tip.y - above + 10}px`;
  }
  function share(u, v, k) { // with all series in sight over the same abscissa
    at = [u, v, k];
    for (const one of panels) {
      const { top: from, bottom: to } = one.svg.getBoundingClientRect();
      if (one.svg === svg) tell(...at, true);
      else if (series && one.series && one.x.label === x.label && to > 0 && from < innerHeight)
        one.tell(one.x.place(x.value(u)), v, k, false);
      else one.hide();
    }
  }
  function zoom(low, high) {
    [from, to] = [low, high];
    const whole = from === x.start && to === x.end, across = value => shown(+value).toFixed(2);
    const place = (name, value) => name === "x" ? across(value)
      : value.replace(/(-?[\d.]+) (-?[\d.]+)/g, (_, u, v) => `${across(u)} ${v}`);
    svg.querySelectorAll(".made").forEach(one => one.remove());
    for (const { was, loose, ticks } of rows) {
      for (const [one, name, value] of was) one.setAttribute(name, whole ? value : place(name, value));
      for (const one of [...loose, ...ticks]) one.style.display = whole ? "" : "none";
    }
    if (whole) return;
    const [least, most] = [from, to].map(x.value), rough = (most - least) / 7, ten = 10 ** Math.floor(Math.log10(rough));
    const step = ten * [1, 2, 5, 10].find(times => times * ten > 0.99 * rough);
    const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
    for (const { ticks: [tick] } of rows) for (let k = Math.ceil(least / step); k * step <= most; k++) {
      const made = tick.parentNode.appendChild(tick.cloneNode(true)), by = shown(x.place(k * step));
      made.querySelectorAll("defs").forEach(one => one.remove());
      made.querySelectorAll("[clip-path]").forEach(one => one.removeAttribute("clip-path"));
      made.querySelectorAll("text").forEach(one => { one.textContent = text(k * step, digits); });
      made.setAttribute("class", "made");
      made.setAttribute("transform", `translate(${by - made.querySelector("use").getAttribute("x")} 0)`);
      made.style.display = "";
    }
  }
  function reset() {
    zoom(x.start, x.end);
    leave();
  }
  function select(event) { // the stretch between the place where the drag began and this one
    const [low, high] = [held, within(hit(event).x, x.start, x.end)].sort((a, b) => a - b);
    hide();
    make(over, "rect", { x: low, y: top, width: high - low, height: bottom - top });
    return [low, high].map(drawn);
  }
  function hover(event) {
    const { x: u, y: v } = hit(event), k = rows.findIndex(({ y }) => v < y.start + 1);
    if (u < x.start || u > x.end || v < top || k < 0) return leave();
    let found = [drawn(u), v], least = NEAR;
    for (const curve of rows[k].curves) for (const [a, b] of curve.drawn) {
      const far = Math.hypot(shown(a) - u, b - v);
      if (far < least) [found, least] = [[a, b], far];
    }
    share(...found, k);
  }
  const on = (kind, act, target = svg) => target.addEventListener(kind, act);
  on("pointerdown", event => {
    const { x: u } = hit(event);
    if (event.button === 0 && u >= x.start && u <= x.end) held = u;
  });
  on("pointermove", event => held === null && hover(event));
  on("pointermove", event => held !== null && select(event), window);
  on("pointerup", event => {
    if (held === null) return;
    const [low, high] = select(event);
    leave();
    if (high - low > (x.end - x.start) / MOST) zoom(low, high);
    else hover(event);
  }, window);
  on("pointercancel", leave, window);
  on("pointerleave", event => held === null && event.pointerType !== "touch" && leave());
  on("blur", leave);
  on("dblclick", reset);
  on("keydown", event => {
    const way = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -2], ArrowDown: [0, 2] }[event.key];
    if (event.key === "Escape") reset();
    if (!way) return;
    event.preventDefault();
    const [u, v, k] = at || [(from + to) / 2, (rows[0].y.start + top) / 2, 0];
    share(within(u + way[0] * (to - from) / 100, from, to), within(v + way[1], rows[k].y.end, rows[k].y.start), k);
  });
  hide();
  svg.tabIndex = 0;
  return { svg, x, series, tell, hide, reset };
}

const drawings = [...document.querySelectorAll("svg.plot")];
const panels = drawings.filter(svg => svg.querySelector(".axes")).map(panelOf);
addEventListener("beforeprint", () => panels.forEach(one => one.reset()));
