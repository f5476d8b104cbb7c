/** Fits the families pi and modified-pi, and the best curve without memory, by the programs of dehyst.identification.
 *
 *   minimise 1/2 v'G v - g'v + 1/2 u'E u - h'u,   v = T u,   u_i >= lower_i
 *
 * Input and output are scaled to [-1, 1] over the first half of the log, which is fitted; the second half is held out. */

import { Refusal } from "./refusal";
import { borrowed, Core, mapped, Model, Points } from "./wasm";

export type Family = "pi" | "modified-pi";

export interface Score {
  rmse: number; // in the unit of the output
  percent: number; // of the range of the output
}

export interface Parameters {
  thresholds: Float64Array;
  weights: Float64Array;
  center: number;
  offset: number;
  start: Float64Array; // states of the plays before the first sample
  after: Points | null; // map of the output
}

export interface Fit {
  family: Family;
  start: Start; // what is assumed of the time before the log
  smoothing: number | null; // of the map of the output
  ridge: number | null;
  eps: number;
  fitted: number; // samples that are fitted, from the first one
  model: Parameters;
  curve: Points;
  scores: { train: Score; test: Score; curve: Score }; // the curve's over held-out samples
  predicted: Float64Array;
  asked: Float64Array | null; // the input that the inverse asks for to reach the measured output
}

export type Start = "zero" | "origin" | "rest" | "rising" | "falling";
const STARTS: Start[] = ["zero", "origin", "rest", "rising", "falling"];

// Constants of dehyst.identification, by the names that they have there.
const OPERATORS = 100;
const EPS = 0.001; // of pi in units of the log, of modified-pi relative to the ratio of the ranges
const MOVED = 1e-6;
const LARGEST_CONDITION = 1e6;
const RESOLVED = 1e-12;
const [WEIGHTS, SLOPES] = [1, 0];
const [MAP_PIECES, SMALLEST_SLOPE, NORMALISATION, OUTSIDE_SLOPE] = [20, 0.05, 1e3, 0.5];
const REGULARISATIONS = [0.003, 0.01, 0.03].flatMap((smoothing) => [0.05, 0.1].map((ridge) => ({ smoothing, ridge })));
const [COMPARED_ROWS, FEWEST_ROWS, FOLD_RIDGE] = [4000, 40, 1e-4];
const [BAND, RESTS] = [0.004, 0.2];
const ORDER = [3, 2, 0, 4, 1, 4, 1, 3, 2, 0, 2, 0, 3, 1, 4, 1, 4, 3, 0, 2]; // fold of each part of the way
const CURVE = { pieces: 60, smallest: 1e-3, smoothings: [0.001, 0.003, 0.01, 0.03], points: 4000, closest: 1e-12 };

interface Regularisation {
  smoothing: number;
  ridge: number;
}

/** Samples scaled: x = center + half * scaled, y = level + gain * scaled, gain < 0 where the output falls. */
interface Data {
  x: Float64Array;
  y: Float64Array;
  end: number; // samples before it are fitted
  center: number;
  half: number;
  level: number;
  gain: number;
  range: number; // of the output over the whole log
}

const spaced = (low: number, high: number, n: number): Float64Array => Float64Array.from({ length: n }, (_v, k) => low + ((high - low) * k) / (n - 1));
const KNOTS = spaced(-1, 1, MAP_PIECES + 1);

function total(values: Iterable<number>): number {
  let sum = 0;
  for (const value of values) sum += value;
  return sum;
}

// ---- data
function extremes(values: Float64Array): [number, number] {
  let [low, high] = [Infinity, -Infinity];
  for (const value of values) {
    low = Math.min(low, value);
    high = Math.max(high, value);
  }
  return [low, high];
}

function middle(values: Float64Array, name: string): [number, number] {
  const [low, high] = extremes(values);
  const span = high - low;
  if (!(span >= RESOLVED * Math.max(Math.abs(low), Math.abs(high))) || !(span > 1e-95 && span < 1e95))
    throw new Refusal(`${name} does not move in the first half of the log, which is fitted. Cut what stands still from its beginning, or choose another column.`);
  return [low + 0.5 * span, 0.5 * span];
}

function prepared(input: Float64Array, output: Float64Array, names: [string, string]): Data {
  const end = Math.floor(0.5 * input.length);
  const [center, half] = middle(input.subarray(0, end), names[0]);
  const [level, amplitude] = middle(output.subarray(0, end), names[1]);
  const x = input.map((value) => (value - center) / half);
  const rising = output.map((value) => (value - level) / amplitude);
  const trend = trendOf(x.subarray(0, end), rising.subarray(0, end));
  const y = trend > 0 ? rising : rising.map((value) => -value);
  return { x, y, end, center, half, level, gain: trend * amplitude, range: robustRange(output) };
}

/** +1 or -1: whether the output follows its input; of a wide loop by increments over 2 % of the range. */
function trendOf(x: Float64Array, y: Float64Array): number {
  const n = x.length;
  const mean = (values: Float64Array): number => values.reduce((sum, value) => sum + value, 0) / n;
  const [mx, my] = [mean(x), mean(y)];
  let [xx, yy, xy] = [0, 0, 0];
  for (let k = 0; k < n; k++) {
    xx += (x[k] - mx) ** 2;
    yy += (y[k] - my) ** 2;
    xy += (x[k] - mx) * (y[k] - my);
  }
  const correlation = xy / Math.sqrt(xx * yy);
  if (Math.abs(correlation) >= 0.3) return correlation > 0 ? 1 : -1;
  let total = 0;
  for (let k = 1, last = 0; k < n; k++) {
    if (Math.round(x[k] / 0.04) === Math.round(x[k - 1] / 0.04)) continue;
    total += (x[k] - x[last]) * (y[k] - y[last]);
    last = k;
  }
  return total >= 0 ? 1 : -1;
}

/** Range of a signal without what less than 1 % of the samples make; as dehyst.data._ranges. */
export function robustRange(values: Float64Array): number {
  const sorted = values.slice().sort();
  const count = sorted.length;
  const whole = sorted[count - 1] - sorted[0];
  const few = Math.max(1, Math.floor(0.005 * count));
  const near = 0.1 * whole;
  const high = sorted.reduce((sum, value) => sum + Number(value >= sorted[count - 1] - near), 0);
  const low = sorted.reduce((sum, value) => sum + Number(value <= sorted[0] + near), 0);
  if (count < 32 || (high > few && low > few)) return whole;
  const [least, most] = [sorted[few], sorted[count - 1 - few]];
  if (most - least >= 0.8 * whole) return whole;
  let [bottom, top] = [least, most];
  for (let k = 0; k + 6 <= count; k++) {
    const six = values.subarray(k, k + 6);
    bottom = Math.min(bottom, Math.max(...six));
    top = Math.max(top, Math.min(...six));
  }
  return top - bottom > 1e-9 * whole ? top - bottom : whole;
}

// ---- rows that a choice looks at
interface Span {
  begin: number;
  end: number;
}

interface Part extends Span {
  number: number; // 0 to 19
}

/** What is left out together: parts that are spread, or parts one after the other. */
const FOLDS = [(part: Part): number => ORDER[part.number], (part: Part): number => Math.floor(part.number / 4)];

/** Samples that stand for the log, spread by way; all rests together have a fifth of the weight at most. */
interface Spread {
  rows: number;
  weight: Float64Array; // of every fitted sample, 0 of those that are no rows
  parts: Part[]; // of the way, one after the other
}

/** The rows and folds of dehyst.data._spread. */
function spreadOf({ x, end }: Data): Spread {
  const [low, high] = extremes(x);
  const band = BAND * 0.5 * (high - low);
  let z = x[0]; // a play as wide as the band: noise at rest is no way
  const moves = x.subarray(0, end).map((value) => {
    const before = z;
    z = Math.max(value - band, Math.min(value + band, z));
    return Math.abs(z - before);
  });
  const way = total(moves);
  const still = moves.filter((move) => move === 0).length;
  const rests = way > 0 ? Math.min(RESTS, still / end) : 1;
  const whole = moves.map((move) => (move === 0 ? rests / still : move * ((1 - rests) / way)));
  // Of a short log all samples are rows.
  const shares = end > COMPARED_ROWS ? stepsOf(whole) : whole;
  const rows = shares.filter((value) => value > 0).length;
  const weight = shares.map((value) => rows * value);
  return { rows, weight, parts: partsOf(weight, rows) };
}

/** Shares of the samples that the middles of equal steps of the way fall on; those of the others are 0. */
function stepsOf(shares: Float64Array): Float64Array {
  const steps = COMPARED_ROWS;
  let [progress, step] = [0, 0];
  return shares.map((share) => {
    progress += share;
    const begun = step;
    while (step < steps && (step + 0.5) / steps < progress) step++;
    return (step - begun) / steps;
  });
}

/** Twenty parts of like way, fewer where a part has no row. */
function partsOf(weight: Float64Array, rows: number): Part[] {
  const parts: Part[] = [];
  const scale = ORDER.length / rows; // the weights add up to the rows
  let progress = 0;
  weight.forEach((w, k) => {
    if (w === 0) return;
    progress += w;
    const number = Math.min(Math.floor((progress - 0.5 * w) * scale + 1e-9), ORDER.length - 1);
    const last = parts.at(-1);
    if (last?.number === number) last.end = k + 1;
    else parts.push({ number, begin: last?.end ?? 0, end: k + 1 });
  });
  return parts;
}

// ---- operators
interface Bank {
  thresholds: Float64Array;
  states: Float64Array; // before the first sample
}

function bankOf(data: Data, start: Start): Bank {
  const first = data.x[0];
  const radius = start === "rest" ? Math.max(Math.abs(1 - first), Math.abs(-1 - first)) : 1;
  const grid = Float64Array.from({ length: OPERATORS }, (_v, k) => (k / OPERATORS) * radius);
  const states = grid.map((r) => stateBefore(start, r, first, -data.center / data.half));
  const moves = grid.map((r, k) => {
    const begun = Math.max(first - r, Math.min(first + r, states[k]));
    return Number(k === 0 || Math.max(begun, 1 - r) - Math.min(begun, -1 + r) > MOVED);
  });
  const moving = (values: Float64Array): Float64Array => values.filter((_v, k) => moves[k] > 0);
  return { thresholds: moving(grid), states: moving(states) };
}

/** State of a play of radius r before the first sample. */
function stateBefore(start: Start, r: number, first: number, origin: number): number {
  if (start === "zero") return 0;
  if (start === "origin") return origin;
  if (start === "rest") return first;
  let z = 0;
  for (const turn of start === "falling" ? [-1, 1, first] : [1, -1, first]) z = Math.max(turn - r, Math.min(turn + r, z));
  return z;
}

/** Sums of products of the columns [1 | cells | targets], row by row in one array of (1 + n + targets)^2. */
interface Sums {
  matrix: Float64Array;
  size: number;
}

/** Sums over consecutive spans of the fitted samples; with the ramps of the output's map as targets, or y alone. */
function sumsOf(core: Core, data: Data, bank: Bank, ramps: boolean, spans: Span[], weight?: Float64Array): Sums[] {
  const targets = 1 + (ramps ? MAP_PIECES : 0);
  const size = 1 + bank.thresholds.length + targets;
  const gram = borrowed(core, [bank.thresholds, bank.states], (r, z) => core.c.page_gram_new(r && bank.thresholds.length, r, z, targets));
  if (!gram) throw new Refusal("The browser has no memory left for this log.");
  const blocks = spans.map(({ begin, end }) => {
    const y = data.y.subarray(begin, end);
    const columns = ramps ? rampsOf(y) : y;
    const weights = weight?.subarray(begin, end) ?? [];
    return borrowed(core, [data.x.subarray(begin, end), columns, weights, new Float64Array(size * size)], (x, target, counted, out) => {
      if (core.c.page_gram_add(gram, end - begin, x, targets, target, weight ? counted : 0) < end - begin) throw new Refusal("A sample is not finite.");
      core.c.page_gram_take(gram, out);
      return { matrix: core.doubles(out, size * size).slice(), size };
    });
  });
  core.c.page_gram_free(gram);
  return blocks;
}

/** Sums over all fitted samples. */
const sumsOfAll = (core: Core, data: Data, bank: Bank, ramps: boolean, weight?: Float64Array): Sums => sumsOf(core, data, bank, ramps, [{ begin: 0, end: data.end }], weight)[0];

/** Rows min(max(y - k_j, 0), k_{j+1} - k_j), then y itself. */
function rampsOf(y: Float64Array): Float64Array {
  const rows = new Float64Array((MAP_PIECES + 1) * y.length);
  for (let j = 0; j < MAP_PIECES; j++) {
    const width = KNOTS[j + 1] - KNOTS[j];
    for (let k = 0; k < y.length; k++) rows[j * y.length + k] = Math.min(Math.max(y[k] - KNOTS[j], 0), width);
  }
  rows.set(y, MAP_PIECES * y.length);
  return rows;
}

function added(blocks: Sums[]): Sums {
  const matrix = new Float64Array(blocks[0].matrix.length);
  for (const block of blocks) for (let k = 0; k < matrix.length; k++) matrix[k] += block.matrix[k];
  return { matrix, size: blocks[0].size };
}

// ---- programs
interface Program {
  unknowns: number;
  plays: number;
  basis: number;
  gram: Float64Array;
  rhs: Float64Array;
  lower: Float64Array;
  target: number;
  extra?: Float64Array;
  extraRhs?: Float64Array;
}

/** What multiplies [1 | plays | ramps], with exact zeros. */
function solved(core: Core, program: Program): Float64Array {
  const n = program.unknowns;
  const room = new Float64Array(n);
  const arrays = [program.gram, program.rhs, program.lower, room, new Float64Array(3), program.extra ?? [], program.extraRhs ?? []];
  return borrowed(core, arrays, (gram, rhs, lower, out, answer, extra, extraRhs) => {
    const failed = core.c.page_solve(n, program.plays, program.basis, gram, rhs, program.extra ? extra : 0, program.extraRhs ? extraRhs : 0, lower, program.target, out, answer);
    const [, condition, status] = core.doubles(answer, 3);
    // A curve has no other way; Python takes it as it is too.
    if (failed || (program.plays > 0 && (status !== 0 || condition > LARGEST_CONDITION)))
      throw new Refusal("The operators are too alike in this log for the short way that this page solves by. Python has a longer one: type the command below, or choose other columns.");
    return core.doubles(out, n).slice();
  });
}

function playProgram({ matrix, size }: Sums, eps: number): Program {
  const unknowns = size - 1;
  const gram = new Float64Array(unknowns * unknowns);
  const rhs = new Float64Array(unknowns);
  for (let i = 0; i < unknowns; i++) {
    rhs[i] = matrix[i * size + size - 1];
    for (let j = 0; j < unknowns; j++) gram[i * unknowns + j] = matrix[i * size + j];
  }
  const lower = new Float64Array(unknowns);
  lower[1] = eps;
  return { unknowns, plays: unknowns - 1, basis: WEIGHTS, gram, rhs, lower, target: Math.sqrt(matrix[size * size - 1]) };
}

/** T(y) = c + sum w_i z_i: the ramps have a minus, the mean slope of the map is held at 1, its slopes are smooth. */
function mapProgram({ matrix, size }: Sums, eps: number, { smoothing, ridge }: Regularisation, foldRidge: number): Program {
  const unknowns = size - 1;
  const plays = unknowns - 1 - MAP_PIECES;
  const samples = matrix[0];
  const gram = new Float64Array(unknowns * unknowns);
  const extra = new Float64Array(unknowns * unknowns);
  const extraRhs = new Float64Array(unknowns);
  const lower = new Float64Array(unknowns);
  lower[1] = eps;
  for (let i = 0; i < unknowns; i++)
    for (let j = 0; j < unknowns; j++) gram[i * unknowns + j] = matrix[i * size + j] * (i > plays === j > plays ? 1 : -1);
  for (let i = 1; i <= plays; i++) extra[i * unknowns + i] = samples * ridge ** 2 + foldRidge;
  const widths = KNOTS.slice(1).map((knot, j) => knot - KNOTS[j]);
  const whole = widths.reduce((sum, width) => sum + width, 0);
  for (let i = 0; i < MAP_PIECES; i++) {
    const row = 1 + plays + i;
    lower[row] = SMALLEST_SLOPE;
    extraRhs[row] = NORMALISATION ** 2 * samples * whole * widths[i];
    for (let j = 0; j < MAP_PIECES; j++) {
      const ends = Number(i > 0) + Number(i < MAP_PIECES - 1);
      const rough = i === j ? ends : Math.abs(i - j) === 1 ? -1 : 0;
      extra[row * unknowns + 1 + plays + j] = samples * (NORMALISATION ** 2 * widths[i] * widths[j] + smoothing ** 2 * rough);
    }
  }
  return { unknowns, plays, basis: WEIGHTS, gram, rhs: new Float64Array(unknowns), lower, target: NORMALISATION * Math.sqrt(samples) * whole, extra, extraRhs };
}

/** Breakpoints u = T(y) and values y of the map of the output, one range beyond the data at each end. */
function mapOf(slopes: Float64Array): { u: Float64Array; v: Float64Array } {
  const inner = [KNOTS[0]];
  for (let j = 0; j < MAP_PIECES; j++) inner.push(inner[j] + slopes[j] * (KNOTS[j + 1] - KNOTS[j]));
  const span = KNOTS[MAP_PIECES] - KNOTS[0];
  const below = inner[0] - span * Math.max(slopes[0], OUTSIDE_SLOPE);
  const above = inner[MAP_PIECES] + span * Math.max(slopes[MAP_PIECES - 1], OUTSIDE_SLOPE);
  return { u: Float64Array.of(below, ...inner, above), v: Float64Array.of(KNOTS[0] - span, ...KNOTS, KNOTS[MAP_PIECES] + span) };
}

/** Scaled output of the unknowns u of a program. */
function answered(core: Core, data: Data, bank: Bank, u: Float64Array): Float64Array {
  const n = bank.thresholds.length;
  const slopes = u.subarray(1 + n);
  const after = slopes.length ? mapOf(slopes) : null;
  const offset = u[0] + (after ? KNOTS[0] : 0);
  const model = Model.make(core, bank.thresholds, u.subarray(1, 1 + n), { offset, start: bank.states, after });
  const y = model.run(data.x.subarray(0, data.end));
  model.free();
  return y;
}

/** Root of the mean square of a - b over spans of samples, which count by their weight. */
function rms(a: Float64Array, b: Float64Array, spans: Span[], weight?: Float64Array): number {
  let [sum, counted] = [0, 0];
  for (const { begin, end } of spans) {
    for (let k = begin; k < end; k++) {
      const w = weight ? weight[k] : 1;
      sum += w * (a[k] - b[k]) ** 2;
      counted += w;
    }
  }
  return Math.sqrt(sum / counted);
}

/** Six digits: what only rounding tells apart is equal. */
const rank = (error: number): number => Number(Math.max(error, 1e-10).toExponential(5));

/** Start "zero", unless another one halves the error of the fit. */
function startOf(core: Core, data: Data, { rows, weight }: Spread, eps: number): Start {
  if (rows < FEWEST_ROWS) return "zero";
  const errors = STARTS.map((start) => {
    const bank = bankOf(data, start);
    const u = solved(core, playProgram(sumsOfAll(core, data, bank, false, weight), eps));
    return rms(answered(core, data, bank, u), data.y, [{ begin: 0, end: data.end }], weight);
  });
  const ranks = errors.map(rank);
  const best = ranks.indexOf(Math.min(...ranks));
  return errors[best] < 0.5 * errors[0] ? STARTS[best] : "zero";
}

/** Error on folds, each left out once, of what is predicted from the sums over the others: geometric mean of two means. */
function foldError({ y }: Data, { weight, parts }: Spread, blocks: Sums[], predicted: (remaining: Sums) => Float64Array): number {
  const means = FOLDS.map((foldOf) => {
    const folds = [...new Set(parts.map(foldOf))];
    const errors = folds.map((fold) => {
      const remaining = added(blocks.filter((_sums, k) => foldOf(parts[k]) !== fold));
      return rms(predicted(remaining), y, parts.filter((part) => foldOf(part) === fold), weight);
    });
    return total(errors) / folds.length;
  });
  return Math.sqrt(means[0] * means[1]);
}

/** Regularisation of the map by the error on folds. */
function regularisationOf(core: Core, data: Data, bank: Bank, spread: Spread): Regularisation {
  const { rows, weight, parts } = spread;
  if (rows < FEWEST_ROWS) return REGULARISATIONS.at(-1)!;
  const blocks = sumsOf(core, data, bank, true, parts, weight);
  const scores = REGULARISATIONS.map((regularisation) => {
    const program = (sums: Sums): Program => mapProgram(sums, EPS, regularisation, FOLD_RIDGE ** 2 * rows);
    return rank(foldError(data, spread, blocks, (remaining) => answered(core, data, bank, solved(core, program(remaining)))));
  });
  return REGULARISATIONS[scores.indexOf(Math.min(...scores))];
}

/** Values that never fall and are closest to y in the squares: neighbours that fall are replaced by their mean. */
function rising(y: number[], weight: number[]): number[] {
  const pools: { mean: number; weight: number; size: number }[] = [];
  y.forEach((value, k) => {
    let pool = { mean: value, weight: weight[k], size: 1 };
    while (pools.length && pools.at(-1)!.mean >= pool.mean) {
      const last = pools.pop()!;
      const sum = last.weight + pool.weight;
      pool = { mean: (last.weight * last.mean + pool.weight * pool.mean) / sum, weight: sum, size: last.size + pool.size };
    }
    pools.push(pool);
  });
  return pools.flatMap(({ mean, size }) => Array<number>(size).fill(mean));
}

/** Values from 0 to 1; all 0 if they do not rise. */
function share(values: number[]): number[] {
  const [first, last] = [values[0], values.at(-1)!];
  return values.map((value) => (last > first ? (value - first) / (last - first) : 0));
}

/** Breakpoints at equal distances of the input, the rising curve of least squares and the weight below, added up. */
function breakpointsOf(core: Core, { x, y }: Data, weight: Float64Array): Float64Array {
  const { pieces, closest } = CURVE;
  const uniform = spaced(-1, 1, pieces + 1);
  const order = [...weight.keys()].filter((k) => weight[k] > 0).sort((a, b) => x[a] - x[b]);
  const [u, sums, counts]: number[][] = [[], [], []]; // samples of the same input are one point
  for (const k of order) {
    if (u.at(-1) !== x[k]) {
      u.push(x[k]);
      sums.push(0);
      counts.push(0);
    }
    sums[u.length - 1] += weight[k] * y[k];
    counts[u.length - 1] += weight[k];
  }
  if (u.length < 2) return uniform;
  let below = 0;
  const numbers = share(counts.map((count) => (below += count)));
  const heights = share(rising(sums.map((sum, k) => sum / counts[k]), counts));
  const t = share(share(u).map((value, k) => value + heights[k] + numbers[k]));
  const breakpoints = mapped(core, { u: t.map((value) => 2 * value - 1), v: u }, uniform);
  breakpoints[0] = -1;
  breakpoints[pieces] = 1;
  // Two samples that differ in their last digits only leave no room for breakpoints between them.
  return breakpoints.every((value, k) => k === 0 || value - breakpoints[k - 1] > closest) ? breakpoints : uniform;
}

/** Sums over the bins between the breakpoints, five a bin, and behind them that of y^2. */
function binsOf(core: Core, data: Data, breakpoints: Float64Array, { begin, end }: Span, weight: Float64Array): Sums {
  const { pieces } = CURVE;
  const [x, y, weights] = [data.x, data.y, weight].map((values) => values.subarray(begin, end));
  const t = mapped(core, { u: breakpoints, v: spaced(-1, 1, 1 + pieces) }, x);
  const square = y.reduce((sum, value, k) => sum + weights[k] * value ** 2, 0);
  return borrowed(core, [t, y, weights, new Float64Array(5 * pieces)], (atT, atY, counted, out) => {
    core.c.page_bin_sums(end - begin, atT, atY, counted, pieces, -1, 1, out);
    return { matrix: Float64Array.of(...core.doubles(out, 5 * pieces), square), size: 5 };
  });
}

/** Smoothing of the curve by the error on folds, from the smoothest on, so that a rougher curve has to err less. */
function smoothingOf(core: Core, data: Data, spread: Spread): number {
  const { rows, weight, parts } = spread;
  let [best, least] = [CURVE.smoothings[1], Infinity];
  if (rows < FEWEST_ROWS) return best;
  const x = data.x.subarray(0, data.end);
  const breakpoints = breakpointsOf(core, data, weight);
  const blocks = parts.map((part) => binsOf(core, data, breakpoints, part, weight));
  for (const smoothing of [...CURVE.smoothings].reverse()) {
    const error = rank(foldError(data, spread, blocks, (remaining) => mapped(core, solvedCurve(core, remaining, breakpoints, smoothing), x)));
    if (error < least) [best, least] = [smoothing, error];
  }
  return best;
}

/** The rising piecewise linear curve of least squares, in units of the log. */
function curveOf(core: Core, data: Data, spread: Spread): Points {
  const every = Math.max(1, Math.floor(data.end / CURVE.points));
  const alike = new Float64Array(data.end).fill(1);
  const breakpoints = breakpointsOf(core, data, alike.map((w, k) => (k % every === 0 ? w : 0)));
  const bins = binsOf(core, data, breakpoints, { begin: 0, end: data.end }, alike);
  const { u, v } = solvedCurve(core, bins, breakpoints, smoothingOf(core, data, spread));
  return { u: u.map((knot) => data.center + data.half * knot), v: v.map((value) => data.level + data.gain * value) };
}

/** The curve of sums over bins, scaled. */
function solvedCurve(core: Core, { matrix, size }: Sums, breakpoints: Float64Array, smoothing: number): { u: Float64Array; v: Float64Array } {
  const { pieces, smallest } = CURVE;
  const width = 2 / pieces;
  const n = 1 + pieces;
  const gram = new Float64Array(n * n);
  const rhs = new Float64Array(n);
  let [above, full] = [0, 0]; // samples beyond the bin, and their y
  for (let j = pieces - 1; j >= 0; j--) {
    const [count, place, square, sum, product] = matrix.subarray(size * j, size * (j + 1));
    const ramp = width * (place + above);
    gram[1 + j] = gram[(1 + j) * n] = ramp;
    gram[(1 + j) * n + 1 + j] = width ** 2 * (square + above);
    for (let i = 0; i < j; i++) gram[(1 + i) * n + 1 + j] = gram[(1 + j) * n + 1 + i] = width * ramp;
    rhs[1 + j] = width * (product + full);
    above += count;
    full += sum;
  }
  gram[0] = above;
  rhs[0] = full;
  const extra = new Float64Array(n * n);
  // The unknowns are slopes over t; what is smooth are slopes over x, as far as t counts them.
  const wider = Float64Array.from({ length: pieces }, (_v, j) => (breakpoints[j + 1] - breakpoints[j]) / width);
  for (let j = 0; j + 1 < pieces; j++) {
    const least = Math.min(wider[j], wider[j + 1]);
    const row = [-least / wider[j], least / wider[j + 1]];
    for (const a of [0, 1]) for (const b of [0, 1]) extra[(1 + j + a) * n + 1 + j + b] += smoothing ** 2 * above * row[a] * row[b];
  }
  const lower = Float64Array.of(0, ...wider.map((factor) => smallest * factor));
  const target = Math.sqrt(matrix[size * pieces]);
  const u = solved(core, { unknowns: n, plays: 0, basis: SLOPES, gram, rhs, lower, target, extra, extraRhs: new Float64Array(n) });
  const values = new Float64Array(n).fill(u[0]);
  for (let j = 0; j < pieces; j++) values[1 + j] = values[j] + width * u[1 + j];
  return { u: breakpoints, v: values };
}

/** Parameters in units of the log, without weights of zero. */
function parametersOf(data: Data, bank: Bank, u: Float64Array): Parameters {
  const n = bank.thresholds.length;
  const weights = u.subarray(1, 1 + n);
  const slopes = u.subarray(1 + n);
  const carrying = (values: Float64Array): Float64Array => values.filter((_v, k) => k === 0 || weights[k] !== 0);
  const common = { thresholds: carrying(bank.thresholds).map((r) => r * data.half), start: carrying(bank.states).map((z) => z * data.half), center: data.center };
  if (!slopes.length) {
    const gain = data.gain / data.half;
    return { ...common, weights: carrying(weights).map((w) => w * gain), offset: data.level + data.gain * u[0], after: null };
  }
  // The inner operator rises and is in units of the output; the map carries level and direction.
  const amplitude = Math.abs(data.gain);
  const map = mapOf(slopes);
  return {
    ...common, weights: carrying(weights).map((w) => (w * amplitude) / data.half), offset: amplitude * (u[0] + KNOTS[0]),
    after: { u: map.u.map((value) => amplitude * value), v: map.v.map((value) => data.level + data.gain * value) },
  };
}

/** A model of parameters, at rest where the log starts. */
export function modelOf(core: Core, { thresholds, weights, center, offset, start, after }: Parameters): Model {
  return Model.make(core, thresholds, weights, { center, offset, start, after });
}

/** Fit a family to a log of two signals, named for what is refused. */
export function fit(core: Core, family: Family, input: Float64Array, output: Float64Array, names: [string, string]): Fit {
  const data = prepared(input, output, names);
  const slope = Math.abs(data.gain) / data.half;
  if (EPS > slope) throw new Refusal(`The output moves by ${slope.toExponential(1)} of its unit per unit of the input, less than the smallest slope of the family pi, ${EPS}. Log the output in a smaller unit.`);
  const spread = spreadOf(data);
  const start = startOf(core, data, spread, EPS / slope);
  const bank = bankOf(data, start);
  const withMap = family === "modified-pi";
  const sums = sumsOfAll(core, data, bank, withMap);
  const regularisation = withMap ? regularisationOf(core, data, bank, spread) : null;
  const u = solved(core, regularisation ? mapProgram(sums, EPS, regularisation, 0) : playProgram(sums, EPS / slope));
  const model = parametersOf(data, bank, u);
  const curve = curveOf(core, data, spread);
  const runner = modelOf(core, model);
  const predicted = runner.run(input);
  const inverse = runner.inverse();
  const asked = inverse?.run(output) ?? null;
  inverse?.free();
  runner.free();
  const score = (values: Float64Array, begin: number, end: number): Score => {
    const rmse = rms(values, output, [{ begin, end }]);
    return { rmse, percent: (100 * rmse) / data.range };
  };
  const length = input.length;
  return {
    family, start, smoothing: regularisation?.smoothing ?? null, ridge: regularisation?.ridge ?? null, eps: EPS, fitted: data.end, model, curve,
    scores: { train: score(predicted, 0, data.end), test: score(predicted, data.end, length), curve: score(mapped(core, curve, input), data.end, length) },
    predicted, asked,
  };
}
