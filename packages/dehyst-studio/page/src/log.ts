/** Reads a delimited log: columns of numbers below one line of names. What is not certain is refused, never guessed. */

import { Refusal, unclear } from "./refusal";

export interface Column {
  name: string;
  unit: string;
  values: Float64Array; // NaN where a cell is empty
  missing: number; // cells that are empty
}

export interface Log {
  name: string;
  rows: number;
  columns: Column[]; // those of numbers
  time: Column | null; // rises from row to row
}

export const LARGEST = 12e6; // bytes of text: what is read and fitted without a pause that a person notices
const FEWEST = 40; // rows
const LOOKED_AT = 400; // lines by which the delimiter is told
const DELIMITERS = ["\t", ";", "|", ",", " "];
const COMMENT = /^\s*(#|%|\/\/)/;
const NUMBER = /^[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?$/;
const MISSING = /^(|nan|na|n\/a|null|none|-)$/i;
const DATE = /\d{1,4}[-/.:]\d{1,2}[-/.:]\d/; // a day or a time of day
const RUN = /^(run|trial|experiment|exp|test|episode|session|series|recording|measurement|messung|versuch|lauf)s?$/i;
const TIME = /^(t|time|zeit|timestamp|clock|seconds?|elapsed|uhr)$/i;
const GAP = 5; // a step of so many medians: what happened within it is not in the log

/** Units as the names of columns carry them, and their usual spelling. */
const UNITS: Record<string, string> = Object.fromEntries([
  ..."Pa kPa MPa bar mbar psi rad deg mrad m mm um nm cm N kN mN V mV kV A mA Nm mNm s ms us ns min h".split(" ").map((unit) => [unit, unit]),
  ["°", "deg"], ["grad", "deg"], ["µm", "um"], ["μm", "um"], ["µs", "us"], ["μs", "us"], ["sec", "s"], ["v", "V"], ["a", "A"], ["kpa", "kPa"], ["mpa", "MPa"],
]);

/** A name without its unit, and the unit: `angle [deg]`, `angle (deg)`, `angle, deg`, `angle_deg`. */
export function unitOf(name: string): { bare: string; unit: string } {
  const bracket = /^(.*\S)\s*[[(]([^[\]()]*)[\])]$/.exec(name);
  if (bracket && !/^\d*$/.test(bracket[2])) return { bare: bracket[1], unit: UNITS[bracket[2]] ?? bracket[2] };
  const suffix = /^(.+?)(?:_|,\s*|\s)([^\s_,]+)$/.exec(name);
  const unit = suffix && (suffix[2].length > 1 || /^[smVNA]$/.test(suffix[2])) ? UNITS[suffix[2]] : undefined;
  return suffix && unit ? { bare: suffix[1], unit } : { bare: name, unit: "" };
}

/** A column as figures name it. */
export const labelOf = ({ name, unit }: Column): string => (unit && !name.replace(/[\])]$/, "").endsWith(unit) ? `${name} [${unit}]` : name);

/** Numbers of a text with one of them a line, below a line of its name or without. */
export function readColumn(name: string, text: string): Float64Array {
  const lines = text.split(/\r\n|\n|\r/).map((line) => line.trim()).filter((line) => line && !COMMENT.test(line));
  const numbers = lines.slice(NUMBER.test(lines[0] ?? "") ? 0 : 1);
  if (numbers.length < 2 || !numbers.every((line) => NUMBER.test(line))) throw new Refusal(`${name} is not one column of numbers with a decimal point, one a line.`);
  return Float64Array.from(numbers, Number);
}

/** Text of a file, unpacked if it is gzip. */
export async function textOf(file: File): Promise<string> {
  if (file.size > LARGEST) throw tooLarge(file.name);
  let bytes = new Uint8Array(await file.arrayBuffer());
  if (bytes[0] === 0x1f && bytes[1] === 0x8b) bytes = await expanded(file.name, bytes);
  if (bytes.subarray(0, 65536).includes(0)) throw unclear(file.name, `${file.name} is no text.`);
  try {
    return new TextDecoder("utf-8", { fatal: true }).decode(bytes);
  } catch {
    throw unclear(file.name, `${file.name} is no text in UTF-8.`);
  }
}

async function expanded(name: string, packed: Uint8Array<ArrayBuffer>): Promise<Uint8Array<ArrayBuffer>> {
  const parts: Uint8Array<ArrayBuffer>[] = [];
  let size = 0;
  try {
    const reader = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip")).getReader();
    for (;;) {
      const { done, value } = await reader.read();
      if (done) break;
      size += value.length;
      if (size > LARGEST) throw tooLarge(name);
      parts.push(value);
    }
  } catch (fault) {
    throw fault instanceof Refusal ? fault : new Refusal(`${name} is damaged: its gzip data cannot be expanded. Copy it again.`);
  }
  return new Uint8Array(await new Blob(parts).arrayBuffer());
}

function tooLarge(name: string): Refusal {
  const refused = unclear(name, `${name} holds more than ${LARGEST / 1e6} MB of text, the most that this page reads.`);
  return new Refusal(`${name} holds more than ${LARGEST / 1e6} MB of text, the most that this page reads. In a terminal, dehyst reads logs of any length:`, refused.command);
}

/** Cells of a line; a delimiter between double quotes is a part of its cell. */
function cellsOf(line: string, delimiter: string): string[] {
  if (delimiter === " ") return line.trim().split(/\s+/);
  if (!line.includes('"')) return line.split(delimiter).map((cell) => cell.trim());
  const cells = [""];
  let inside = false;
  for (const sign of line) {
    if (sign === '"') inside = !inside;
    else if (sign === delimiter && !inside) cells.push("");
    else cells[cells.length - 1] += sign;
  }
  return cells.map((cell) => cell.trim());
}

const numeric = (cell: string): boolean => NUMBER.test(cell.replace(",", "."));

/** The delimiter that cuts all lines into the same number of cells, with two numbers at least in each. */
function delimiterOf(name: string, lines: string[]): string {
  const sample = lines.slice(-LOOKED_AT);
  const isValue = (cell: string): boolean => numeric(cell) || MISSING.test(cell);
  let candidate: string | null = null; // one that leaves words in some cells
  for (const delimiter of DELIMITERS) {
    const rows = sample.map((line) => cellsOf(line, delimiter));
    const width = rows[0].length;
    if (width < 2 || rows.some((cells) => cells.length !== width || cells.filter(isValue).length < 2)) continue;
    if (rows.every((cells) => cells.every(isValue))) return delimiter;
    candidate ??= delimiter;
  }
  if (candidate !== null) return candidate;
  throw unclear(name, `No delimiter (comma, semicolon, tab, bar, space) cuts ${name} into rows of one length with two numbers each.`);
}

/** The sign before the decimals; refused where a number may as well be a thousand times as large. */
function decimalOf(name: string, rows: string[][], delimiter: string): "." | "," {
  let commas = false;
  let points = false;
  let certain = false;
  for (const cells of rows) {
    for (const cell of cells) {
      if (!numeric(cell)) continue;
      const comma = cell.includes(",");
      if (!comma && !cell.includes(".")) continue;
      commas ||= comma;
      points ||= !comma;
      certain ||= !/^[+-]?[1-9]\d{0,2}[.,]\d{3}$/.test(cell);
    }
  }
  if (commas && points) throw unclear(name, `${name} holds numbers with a decimal point and numbers with a decimal comma.`);
  if (!certain && (commas || (points && delimiter === ";")))
    throw unclear(name, `All numbers of ${name} with a ${commas ? "comma" : "point"} have three digits behind it: it may stand before decimals or before thousands.`);
  return commas ? "," : ".";
}

/** Names and units of the columns, from what stands above the first row of numbers. */
function headingOf(name: string, above: string[], comment: string | null, width: number, delimiter: string): { name: string; unit: string }[] {
  const lines = above.map((line) => cellsOf(line, delimiter));
  if (lines.length > 2 || lines.some((cells) => cells.length !== width || cells.some((cell) => cell !== "" && numeric(cell))))
    throw unclear(name, `Above its first row of numbers, ${name} holds lines that are neither names of its ${width} columns nor comments.`);
  const commented = comment === null ? [] : cellsOf(comment.replace(COMMENT, "").trim(), delimiter);
  const names = lines[0] ?? (commented.length === width && !commented.some(numeric) ? commented : null);
  const units = lines[1] ?? null;
  if (units !== null && units.some((cell) => cell !== "" && UNITS[cell.replace(/^[[(]|[\])]$/g, "")] === undefined))
    throw unclear(name, `The second line of ${name} holds no units that this page knows.`);
  const columns = Array.from({ length: width }, (_v, k) => {
    const text = names?.[k] || `column_${k + 1}`;
    return { name: text, unit: units?.[k] ? UNITS[units[k].replace(/^[[(]|[\])]$/g, "")] : unitOf(text).unit };
  });
  if (new Set(columns.map((column) => column.name)).size < width) throw unclear(name, `Two columns of ${name} have one name.`);
  return columns;
}

/** Columns of a text. */
export function readLog(name: string, text: string): Log {
  const all = text.split(/\r\n|\n|\r/);
  while (all.length && !all[all.length - 1].trim()) all.pop();
  if (!all.length) throw new Refusal(`${name} is empty. Check that the logger was started.`);
  let first = 0;
  let comment: string | null = null;
  for (; first < all.length && (COMMENT.test(all[first]) || !all[first].trim()); first++) if (all[first].trim()) comment = all[first];
  const lines = all.slice(first);
  if (lines.length < FEWEST) throw unclear(name, `${name} holds ${lines.length} lines below its comments, fewer than the ${FEWEST} that a loop needs.`);
  const delimiter = delimiterOf(name, lines);
  const rows = lines.map((line) => cellsOf(line, delimiter));
  const width = rows[rows.length - 1].length;
  const begin = rows.findIndex((cells) => cells.filter(numeric).length >= 2);
  const heading = headingOf(name, lines.slice(0, begin), comment, width, delimiter);
  const table = rows.slice(begin);
  const odd = table.findIndex((cells) => cells.length !== width);
  if (odd >= 0) throw unclear(name, `Line ${first + begin + odd + 1} of ${name} has ${table[odd].length} cells where the others have ${width}.`);
  const unnamed = begin === 0 && !heading.some((column, k) => column.name !== `column_${k + 1}`);
  if (unnamed && delimiter === "," && !table.some((cells) => cells.some((cell) => cell.includes("."))))
    throw unclear(name, `${name} has no line of names and no decimal point: its commas may separate columns or decimals.`);
  const decimal = decimalOf(name, table, delimiter);
  const columns: Column[] = [];
  for (const [k, { name: title, unit }] of heading.entries()) {
    const column = columnOf(name, title, unit, table.map((cells) => cells[k]), decimal);
    if (column) columns.push(column);
  }
  if (columns.length < 2) throw unclear(name, `${name} has fewer than two columns of numbers.`);
  return { name, rows: table.length, columns, time: timeOf(name, columns) };
}

/** A column of numbers; null for one that says the same word in every row. */
function columnOf(log: string, title: string, unit: string, cells: string[], decimal: "." | ","): Column | null {
  const values = new Float64Array(cells.length);
  let missing = 0;
  let numbers = 0;
  for (const [k, cell] of cells.entries()) {
    const plain = decimal === "," ? cell.replace(",", ".") : cell;
    if (NUMBER.test(plain)) {
      values[k] = Number(plain);
      numbers++;
    } else if (MISSING.test(cell)) {
      values[k] = NaN;
      missing++;
    } else if (DATE.test(cell)) throw unclear(log, `Column ${title} of ${log} holds dates or times of day (${cell.slice(0, 40)}).`);
    else if (numbers || missing || cell !== cells[0]) throw unclear(log, `Column ${title} of ${log} holds words that change, or words among numbers (${cell.slice(0, 40)}).`);
  }
  if (numbers === 0) return null;
  if (numbers + missing < cells.length) throw unclear(log, `Column ${title} of ${log} holds words among numbers.`);
  if (RUN.test(unitOf(title).bare) && new Set(values).size > 1) throw unclear(log, `Column ${title} of ${log} tells several runs apart.`);
  return { name: title, unit, values, missing };
}

/** The column of time, if its name says so. */
function timeOf(log: string, columns: Column[]): Column | null {
  const named = columns.filter(({ name }) => TIME.test(unitOf(name).bare));
  if (named.length > 1) throw unclear(log, `${log} has several columns of time: ${named.map(({ name }) => name).join(", ")}.`);
  const time = named[0];
  if (!time) return null;
  const steps = time.values.slice(1).map((value, k) => value - time.values[k]);
  const back = steps.findIndex((step) => !(step > 0));
  if (back >= 0) throw unclear(log, `Time (${time.name}) of ${log} does not rise at row ${back + 2}: several runs, or rows that were logged twice.`);
  const median = steps.slice().sort()[steps.length >> 1];
  const gap = steps.findIndex((step) => step > GAP * median);
  if (gap >= 0) throw unclear(log, `${log} has a gap of ${(steps[gap] / median).toFixed(0)} samples at row ${gap + 2}: what moved within it is unknown.`);
  return time;
}

const LONGEST = 8; // samples of a false run
const FAR = 3; // ranges of the other values between them and a false one
const [LEAP, STEPS, USUAL] = [0.1, 4, 0.9]; // of the range, and in usual steps (their quantile): how far a false run leaps
const TURN: Record<string, number> = { deg: 360, rad: 2 * Math.PI, mrad: 2000 * Math.PI };

/** Refuse a signal with holes, constant, or with values that a sensor does not measure. */
export function check(log: string, { name, unit, values, missing }: Column): void {
  if (missing) throw unclear(log, `${missing} of the ${values.length} values of ${name} are missing.`);
  const sorted = values.slice().sort();
  const last = sorted.length - 1;
  if (sorted[0] === sorted[last]) throw new Refusal(`${name} stays at ${values[0]}. A loop needs two signals that move: choose another column.`);
  const steps = values.subarray(1).map((value, k) => Math.abs(value - values[k]));
  const wrapped = steps.findIndex((step) => step > 0.8 * TURN[unit] && step < 1.05 * TURN[unit]);
  if (wrapped >= 0) throw unclear(log, `${name} leaps by a whole turn at sample ${wrapped + 1}: it seems to be cut to one turn.`);
  const outlier = farValue(values, sorted) ?? falseRun(values, steps, sorted);
  if (outlier !== null) throw unclear(log, `Value ${values[outlier]} of ${name}, sample ${outlier}, stands far from those beside it: an outlier, which a play remembers for ever.`);
}

/** Sample of a value that stands alone beyond all others, however often it comes, or of the few that do; else null. */
function farValue(values: Float64Array, sorted: Float64Array): number | null {
  const last = sorted.length - 1;
  const few = Math.floor(0.005 * values.length);
  const inner = [[sorted.find((value) => value > sorted[0])!, sorted.findLast((value) => value < sorted[last])!], [sorted[few], sorted[last - few]]];
  for (const [low, high] of inner) {
    const place = values.findIndex((value) => value < low - FAR * (high - low) || value > high + FAR * (high - low));
    if (high > low && place >= 0) return place;
  }
  return null;
}

/** First sample of a short run that leaps away from a signal of small steps, and back; else null. */
function falseRun(values: Float64Array, steps: Float64Array, sorted: Float64Array): number | null {
  const usual = steps.slice().sort()[Math.floor(USUAL * steps.length)];
  const least = Math.max(LEAP * (sorted[sorted.length - 1] - sorted[0]), STEPS * usual);
  for (let k = 1; k + 1 < values.length; k++) {
    const leap = values[k] - values[k - 1];
    if (!(Math.abs(leap) > least)) continue;
    for (let end = k + 1; end <= Math.min(k + LONGEST, values.length - 1); end++) {
      const back = values[end - 1] - values[end];
      if (Math.abs(back) > least && back * leap > 0 && Math.abs(values[end] - values[k - 1]) < 0.5 * Math.abs(leap)) return k;
    }
  }
  return null;
}

// ---- which column drives, which follows
const DRIVES = /pressure|druck|voltage|spannung|current|strom|input|command|cmd|valve|drive|^u$|^x$|^p$/i;
const FOLLOWS = /angle|winkel|position|displacement|weg|force|kraft|torque|tilt|strain|stroke|dehnung|extension|output|^y$/i;
const DRIVING = new Set(["Pa", "kPa", "MPa", "bar", "mbar", "psi", "V", "mV", "kV", "A", "mA"]);
const FOLLOWING = new Set(["rad", "deg", "mrad", "mm", "um", "nm", "cm", "m", "N", "kN", "mN", "Nm", "mNm"]);

export interface Proposal {
  input: string;
  output: string;
  clear: boolean; // one column drives and one follows, by name or unit
}

/** Of several columns the one that the output follows most closely, by their correlation. */
function closest(columns: Column[], output: Column | undefined): Column | undefined {
  if (!output || columns.length < 2) return columns[0];
  const strengths = columns.map(({ values }) => Math.abs(correlation(values, output.values)));
  return columns[strengths.indexOf(Math.max(...strengths))];
}

/** Correlation over the rows in which both have values, 0 where one stands still. */
function correlation(a: Float64Array, b: Float64Array): number {
  const rows = Array.from(a.keys()).filter((k) => Number.isFinite(a[k]) && Number.isFinite(b[k]));
  const mean = (values: Float64Array): number => rows.reduce((sum, k) => sum + values[k], 0) / rows.length;
  const [middleA, middleB] = [mean(a), mean(b)];
  let [aa, bb, ab] = [0, 0, 0];
  for (const k of rows) {
    aa += (a[k] - middleA) ** 2;
    bb += (b[k] - middleB) ** 2;
    ab += (a[k] - middleA) * (b[k] - middleB);
  }
  return aa > 0 && bb > 0 ? ab / Math.sqrt(aa * bb) : 0;
}

/** Whether a column rises from row to row, as time and numbers of rows do. */
function counts(values: Float64Array): boolean {
  return values.every((value, k) => k === 0 || value > values[k - 1]);
}

/** Input and output by names and units; else the first two columns beside time, to be confirmed. */
export function propose({ columns, time }: Log): Proposal {
  const free = columns.filter((column) => column !== time && !counts(column.values));
  const drives = free.filter(({ name, unit }) => DRIVES.test(unitOf(name).bare) || DRIVING.has(unit));
  const follows = free.filter(({ name, unit }) => !drives.some((column) => column.name === name) && (FOLLOWS.test(unitOf(name).bare) || FOLLOWING.has(unit)));
  const input = closest(drives, follows[0]) ?? free.find((column) => column !== follows[0]);
  const output = follows[0] ?? free.find((column) => column !== input);
  return { input: input?.name ?? "", output: output?.name ?? "", clear: drives.length === 1 && follows.length === 1 };
}
