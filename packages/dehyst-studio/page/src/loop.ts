/** Width, area and coercivity of the deepest loop of a log, by the definitions of `dehyst loops`. */

export interface LoopNumbers {
  width: number; // between the branches, at the middle of the input [output]
  area: number; // enclosed [input output]
  coercivity: number; // half the distance of the inputs where the output passes zero, or its middle [input]
  at: "zero" | "middle"; // where coercivity is measured
}

interface Branch {
  x: number[];
  y: number[];
}

const NEAR = 0.02; // share of the range: samples so near a place are read by one line
const INSIDE = 0.25; // share of the range: coercivity is measured at zero if both ends are so far from it
const SMALL = 0.05; // share of the range: smaller swings are no turns; two ways that differ by less are equally far

/** Where a loop runs: from its foot to its turn and back to where the input was at the foot. */
interface Loop {
  depth: number; // [input]
  foot: number;
  turn: number;
  end: number;
}

/** Return the numbers of the deepest loop, or null where no loop closes. */
export function loopNumbers(input: Float64Array, output: Float64Array): LoopNumbers | null {
  const loop = deepest(input);
  if (!loop) return null;
  const { foot, turn, end } = loop;
  const upward = input[turn] > input[foot];
  // What went back and forth on the way is a smaller loop within: only new ground counts.
  const there = branch(input, output, foot, turn);
  const back = branch(input, output, turn, end);
  const [rising, descending] = upward ? [there, back] : [back, there];
  const [low, high] = ends(rising.x);
  const middle = 0.5 * (low + high);
  const near = NEAR * (high - low);
  const [least, most] = ends([...rising.y, ...descending.y]);
  const inside = least < -INSIDE * (most - least) && most > INSIDE * (most - least);
  const level = inside ? 0 : 0.5 * (least + most);
  const nearLevel = NEAR * (most - least);
  const width = at(descending.x, descending.y, middle, near) - at(rising.x, rising.y, middle, near);
  const across = at(rising.y, rising.x, level, nearLevel) - at(descending.y, descending.x, level, nearLevel);
  return { width: Math.abs(width), area: enclosed([...there.x, ...back.x], [...there.y, ...back.y]), coercivity: 0.5 * Math.abs(across), at: inside ? "zero" : "middle" };
}

/** Samples at which the input turns by more than a small swing, with the first and the last one. */
function turnsOf(x: Float64Array): number[] {
  const [low, high] = ends(x);
  const swing = SMALL * (high - low);
  const turns = [0];
  let [lowest, highest] = [0, 0];
  let rising: boolean | null = null;
  for (let k = 1; k < x.length; k++) {
    if (x[k] < x[lowest]) lowest = k;
    if (x[k] > x[highest]) highest = k;
    if (rising !== false && x[highest] - x[k] > swing) {
      turns.push(highest);
      [rising, lowest] = [false, k];
    } else if (rising !== true && x[k] - x[lowest] > swing) {
      turns.push(lowest);
      [rising, highest] = [true, k];
    }
  }
  turns.push(rising ? highest : lowest);
  return turns.filter((turn, k) => k === 0 || turn !== turns[k - 1]);
}

/** The deepest loop that closes: turns are taken out in pairs, as a rainflow count does; null where there is none. */
function deepest(x: Float64Array): Loop | null {
  let most: Loop | null = null;
  const open: number[] = [];
  for (const latest of turnsOf(x)) {
    open.push(latest);
    while (open.length > 2) {
      const [foot, turn, next] = open.slice(-3);
      const [way, back] = [Math.abs(x[turn] - x[foot]), Math.abs(x[next] - x[turn])];
      if (back < (1 - SMALL) * way) break;
      // What was before the log decides the first way, unless it comes back to its very begin.
      if (open.length === 3 && foot === 0 && back > (1 + SMALL) * way) {
        open.shift();
        break;
      }
      if (!most || way > most.depth) most = { depth: way, foot, turn, end: returned(x, foot, turn, next) };
      open.splice(-3, 2);
    }
  }
  return most;
}

/** Where, on the way from a turn to the next one, the input is back at the foot. */
function returned(x: Float64Array, foot: number, turn: number, next: number): number {
  const upward = x[turn] > x[foot];
  for (let k = turn; k < next; k++) if (upward ? x[k] <= x[foot] : x[k] >= x[foot]) return k;
  return next;
}

/** Samples of a way at which the input is farther than ever before on it. */
function branch(input: Float64Array, output: Float64Array, from: number, to: number): Branch {
  const way: Branch = { x: [], y: [] };
  const sign = Math.sign(input[to] - input[from]);
  let farthest = -Infinity;
  for (let k = from; k <= to; k++) {
    if (sign * input[k] <= farthest) continue;
    farthest = sign * input[k];
    way.x.push(input[k]);
    way.y.push(output[k]);
  }
  return way;
}

function ends(values: ArrayLike<number>): [number, number] {
  let [low, high] = [Infinity, -Infinity];
  for (let k = 0; k < values.length; k++) {
    low = Math.min(low, values[k]);
    high = Math.max(high, values[k]);
  }
  return [low, high];
}

/** Value of y at a place in x: by the line of least squares through the samples near, or between the two next to it. */
function at(x: number[], y: number[], place: number, near: number): number {
  let [n, sx, sy, sxx, sxy] = [0, 0, 0, 0, 0];
  let [below, above] = [-1, -1];
  for (let k = 0; k < x.length; k++) {
    const d = x[k] - place;
    if (d <= 0 && (below < 0 || d > x[below] - place)) below = k;
    if (d >= 0 && (above < 0 || d < x[above] - place)) above = k;
    if (Math.abs(d) > near) continue;
    n += 1;
    sx += d;
    sy += y[k];
    sxx += d * d;
    sxy += d * y[k];
  }
  const scatter = n * sxx - sx * sx;
  if (n > 3 && scatter > 0) return (sxx * sy - sx * sxy) / scatter;
  if (below < 0 || above < 0) return NaN;
  const width = x[above] - x[below];
  return width > 0 ? y[below] + ((place - x[below]) / width) * (y[above] - y[below]) : 0.5 * (y[below] + y[above]);
}

/** Area that a path encloses, its ends joined by a straight line. */
function enclosed(x: number[], y: number[]): number {
  let doubled = 0;
  for (let k = 0; k < x.length; k++) {
    const next = (k + 1) % x.length;
    doubled += x[k] * y[next] - x[next] * y[k];
  }
  return 0.5 * Math.abs(doubled);
}
