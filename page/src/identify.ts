/** The tab that takes a log to a model: drop, columns, verdict, figures, the inverse at work, files. */

import { h, line, painted, save } from "./dom";
import { Answer, Engine, Finding, Refusal, Summary } from "./engine";
import { Inverse } from "./inverse";
import { Options } from "./options";
import { Link, LoopPlot, Shade, short, TimePlot } from "./plots";
import { Core, Model } from "./wasm";
import { zipped } from "./zip";

const WAITS = 250; // ms before anything is said to be going on

export function mount(root: HTMLElement, core: Core): void {
  new Identify(root, core);
}

class Identify {
  private engine: Promise<Engine>;
  private readonly status = h("p", { role: "status", "aria-live": "polite", class: "status" });
  private readonly trouble = h("div", { role: "alert" });
  private readonly columns = h("div", {});
  private readonly results = h("div", { class: "results" });
  private figures: { destroy(): void }[] = [];
  private summary: Summary | null = null;
  private options: Options | null = null;
  private turn = 0; // the newest request: answers to older ones are dropped

  constructor(root: HTMLElement, private readonly core: Core) {
    this.engine = Engine.open(core.module);
    root.append(this.dropZone(), this.status, this.trouble, this.columns, this.results);
  }

  private dropZone(): HTMLElement {
    const picker = h("input", { type: "file", id: "log", class: "hidden-input", accept: ".csv,.txt,.tsv,.dat,.gz,text/csv,text/plain",
      onchange: () => { if (picker.files?.[0]) void this.open(picker.files[0]); picker.value = ""; } });
    const zone = h("div", { class: "drop" },
      h("div", {},
        h("h2", {}, "Drop a log here"),
        h("p", { class: "caption" }, "CSV or text with one row a sample: an input column (pressure, voltage), the output it moved (angle, displacement), a time column if there is one. Also packed with gzip.")),
      h("div", { class: "row" },
        h("label", { class: "button main", for: "log" }, "Choose a file"), picker,
        h("button", { type: "button", onclick: () => void this.open(example(this.core)) }, "Try an example")));
    for (const kind of ["dragenter", "dragover"]) zone.addEventListener(kind, (event) => { event.preventDefault(); zone.classList.add("over"); });
    for (const kind of ["dragleave", "drop"]) zone.addEventListener(kind, () => zone.classList.remove("over"));
    const take = (event: DragEvent): void => {
      event.preventDefault();
      const file = event.dataTransfer?.files[0];
      if (file) void this.open(file);
    };
    zone.addEventListener("drop", take);
    addEventListener("dragover", (event) => event.preventDefault());
    addEventListener("drop", (event) => { if (!zone.contains(event.target as Node) && zone.offsetParent) take(event); });
    return zone;
  }

  /** Do something that takes time: its sentence while it runs, its refusal where it ends. */
  private async during<T>(sentence: string, work: (engine: Engine) => Promise<T>): Promise<T | null> {
    const turn = ++this.turn;
    this.trouble.replaceChildren();
    const begun = performance.now();
    const clock = h("span", { "aria-hidden": "true" }); // seconds are to be seen, not to be read out
    // Made once: a button that is made anew while it is pressed is not clicked.
    const said = [h("span", { class: "spinner", "aria-hidden": "true" }), `${sentence} …`, clock, h("button", { type: "button", class: "quiet", onclick: () => this.stop() }, "Stop")];
    const tick = setInterval(() => {
      const seconds = (performance.now() - begun) / 1000;
      if (1000 * seconds < WAITS || turn !== this.turn) return;
      if (!clock.isConnected) this.status.replaceChildren(...said);
      if (seconds >= 2) clock.textContent = `${Math.floor(seconds)} s`;
    }, 200);
    try {
      const answer = await work(await this.engine);
      return turn === this.turn ? answer : null;
    } catch (fault) {
      if (turn === this.turn) this.refuse(fault);
      return null;
    } finally {
      clearInterval(tick);
      if (turn === this.turn) this.status.replaceChildren();
    }
  }

  private stop(): void {
    const old = this.engine;
    this.turn++;
    void old.then((engine) => engine.stop());
    this.engine = Engine.open(this.core.module);
    this.summary = null;
    this.columns.replaceChildren();
    this.clear();
    this.status.replaceChildren("Stopped. Drop the log once more to begin again.");
  }

  /** A sentence begins with a capital, unless it begins with the name of the log or of an option. */
  private sentence(message: string): string {
    return (this.summary && message.startsWith(this.summary.name)) || /^(\w+ =|--)/.test(message) ? message : message[0].toUpperCase() + message.slice(1);
  }

  private refuse(fault: unknown, title = this.options?.some ? "Log and options do not go together" : "This log cannot be used as it is"): void {
    const message = fault instanceof Error ? fault.message : String(fault);
    const known = fault instanceof Refusal && fault.known;
    this.trouble.replaceChildren(h("div", { class: "judged stop" }, h("span", { class: "badge" }, known ? title : "The page failed"),
      h("p", { class: "lead" }, this.sentence(message)), this.cures(message)));
  }

  private clear(): void {
    for (const figure of this.figures) figure.destroy();
    this.figures = [];
    Object.assign(this.results, { answer: null });
    this.results.replaceChildren();
  }

  private async open(file: File): Promise<void> {
    this.clear();
    this.options = null;
    this.columns.replaceChildren();
    const summary = await this.during(`Reading ${file.name}`, (engine) => engine.read(file));
    if (!summary) return;
    this.choose(summary);
    if (summary.input && summary.output && summary.clear) await this.identify();
  }

  // ---- columns
  private choose(summary: Summary): void {
    this.summary = summary;
    const signals = summary.columns.filter((column) => Number.isFinite(column.minimum));
    const list = (id: string, chosen: string | null): HTMLSelectElement => {
      const select = h("select", { id }, h("option", { value: "" }, "choose …"));
      for (const { name, unit, loops, constant } of signals)
        select.append(h("option", { value: name }, `${name}${unit && !name.replace(/\W+$/, "").endsWith(unit) ? ` [${unit}]` : ""}${constant ? " (constant)" : loops ? ` (${loops} loops)` : ""}`));
      select.value = chosen ?? "";
      return select;
    };
    const [input, output] = [list("input", summary.input), list("output", summary.output)];
    const moving = signals.filter(({ name, constant }) => !constant && name !== summary.sampling?.column).length;
    const runs = Object.keys(summary.runs);
    const run = h("select", { id: "run" });
    for (const name of runs) run.append(h("option", { value: name }, `${name} (${summary.runs[name]} rows)`));
    run.value = summary.run ?? "";
    run.addEventListener("change", () => void this.rerun(run.value));
    const identify = (): void => void this.identify();
    const go = h("button", { type: "button", class: "main", onclick: identify }, "Identify");
    this.options = new Options(summary, identify, this.options);
    const reason = (name: string | null): string => summary.columns.find((column) => column.name === name)?.reason ?? "";
    const rate = summary.sampling ? `, ${short(1 / summary.sampling.median, 3)} samples a second by ${summary.sampling.column}` : ", no time column";
    this.columns.replaceChildren(
      h("section", { class: "card" },
        h("h2", {}, summary.name),
        h("p", { class: "caption" }, `${summary.rows.toLocaleString("en")} rows${summary.run ? ` of run ${summary.run}` : ""}${rate}.`,
          summary.clear ? " Names and units leave no other choice of columns."
            : moving < 2 ? ` A loop needs two columns that change, what drives and what follows; besides time there ${moving ? "is one" : "is none"} here.`
            : summary.input && summary.output ? " The columns are a guess: confirm or change them."
            : " Nothing tells what drives and what follows: choose the columns."),
        h("div", { class: "row" },
          h("label", { for: "input" }, "Input", input), h("label", { for: "output" }, "Output", output),
          runs.length > 1 ? h("label", { for: "run" }, "Run", run) : null, go),
        summary.input && summary.output ? h("p", { class: "caption" }, `Why: ${summary.input} (${reason(summary.input)}) drives ${summary.output} (${reason(summary.output)}).`) : null,
        this.findings(summary.findings, "What reading the log found"), this.options.element));
  }

  private async rerun(run: string): Promise<void> {
    this.clear();
    const summary = await this.during(`Looking at run ${run}`, (engine) => engine.inspect(run));
    if (!summary) return;
    this.choose(summary);
    if (summary.clear) await this.identify();
  }

  private findings(found: Finding[], title: string): HTMLElement | null {
    if (!found.length) return null;
    const body = h("details", { class: "findings" }, h("summary", {}, `${title} (${found.length})`));
    body.append(...found.map((each) => this.warning(each)));
    return body;
  }

  private warning({ code, message }: Finding): HTMLElement {
    return h("div", { class: "warning" }, h("code", {}, code), h("p", {}, this.sentence(message)), this.cures(message));
  }

  private cures(message: string): HTMLElement | null {
    const made = this.options?.cures(message, () => void this.identify()) ?? [];
    if (message.includes("--family ")) made.push(h("button", { type: "button", onclick: () => document.getElementById("command")?.firstElementChild?.scrollIntoView({ block: "center" }) }, "To the command for other families"));
    return made.length ? h("p", { class: "row cures" }, ...made) : null;
  }

  // ---- result
  private async identify(): Promise<void> {
    const value = (id: string): string => (document.getElementById(id) as HTMLSelectElement | null)?.value ?? "";
    const [input, output] = [value("input"), value("output")];
    if (!input || !output) {
      this.refuse(new Refusal("choose a column for the input and one for the output.", true), "Columns are missing");
      return;
    }
    const run = Object.keys(this.summary!.runs).length > 1 ? value("run") : null;
    let given;
    try {
      given = this.options!.given();
    } catch (fault) {
      this.refuse(fault, "An option is not a number");
      return;
    }
    this.clear();
    const { reading, fitting } = given;
    const answer = await this.during("Identifying", (engine) => engine.identify(input, output, run, reading, fitting));
    if (answer) await this.show(answer);
  }

  private async show(a: Answer): Promise<void> {
    const { labels } = a;
    const { train, curve } = a.scores;
    const test = a.scores.test ?? train;
    const held = a.scores.test ? "held-out loops" : "fitted loops";
    const link = new Link();
    const t = a.time ?? Float64Array.from(a.x, (_v, k) => k);
    const tLabel = a.time ? "time [s]" : "sample";
    const shades = spans(a.test, t);
    const plots = h("div", { class: "panels" });
    const wide = h("div", { class: "stack" });
    const bad = a.grade === "stop";

    this.results.append(
      h("section", { class: `judged ${a.grade}`, id: "verdict", tabindex: -1 },
        h("span", { class: "badge" }, { good: "Good for compensation", care: "Usable with care", stop: "Do not compensate" }[a.grade]),
        h("p", { class: "lead" }, a.verdict),
        a.grade === "good" ? null : h("p", { class: "caption" }, `This is the verdict on the family pi with ${this.options!.some ? "the options above" : "its usual settings"}. ${a.warnings.length ? "The warnings say what to try. " : ""}Another family may do: the command at the end of the page compares all families.`),
        h("dl", { class: "tiles" },
          tile("Model errs by", `${short(test.rmse_percent, 3)} %`, `of range, rms, on ${held}: ${unit(test.rmse, labels.outputUnit)}`),
          tile("A plain curve by", `${short(curve.rmse_percent, 3)} %`, `the best one without hysteresis: ${unit(curve.rmse, labels.outputUnit)}`),
          tile("Operators", a.size.replace(" operators", ""), `carry weight; assumed before the log: ${a.start}`),
          tile("Loop", `${short(a.width, 2)} % wide`, a.orientation),
          tile("Inverse gain", Number.isFinite(a.gain) ? unit(a.gain, ratio(labels)) : "no inverse", "at most, right after a reversal"))),
      ...a.warnings.map((each) => this.warning(each)),
      plots,
      h("p", { class: "caption" }, shades.length ? "The shaded part was held out: the model has not seen it. " : "", "Drag over a figure to zoom, double click to see all; the cursor walks along all of them."),
      wide,
    );
    const verdict = document.getElementById("verdict")!;
    verdict.focus({ preventScroll: true });
    await painted(); // the sentence first: figures of a long log take as long again
    if (!verdict.isConnected) return; // another log came

    const loop = new LoopPlot(plots, { title: "The loop", name: "loop", xLabel: labels.input, yLabel: labels.output, link, height: 360,
      described: `Measured loop, ${a.orientation}, ${short(a.width, 2)} percent of range wide, and the model's.` });
    loop.set([
      { label: "measured", x: a.x, y: a.y, colour: "data", width: 3, linked: true },
      { label: "model", x: a.x, y: a.predicted, colour: "model", width: 1 },
      { label: "plain curve", x: a.curve.u, y: a.curve.v, colour: "static", dash: [6, 4] },
    ]);
    const back = new LoopPlot(plots, { title: "The inverse: asked for, against applied", name: "asked", xLabel: `${labels.input}, applied`, yLabel: `${labels.input}, asked for`,
      link, height: 360, equal: true, described: "The inverse's answer to the measured output against the input that was applied: on the diagonal it gives it back." });
    back.set([
      { label: "inverse of the measured output", x: a.x, y: a.asked, colour: "train", linked: true },
      { label: "45°", x: a.card.input, y: a.card.input, colour: "other", dash: [5, 4] },
    ]);
    const series = (title: string, name: string, yLabel: string, lines: Parameters<TimePlot["set"]>[1], height: number): TimePlot => {
      const plot = new TimePlot(wide, { title, name, xLabel: tLabel, yLabel, link, height });
      plot.set(t, lines, shades);
      return plot;
    };
    const residual = Float64Array.from(a.y, (v, k) => v - a.predicted[k]);
    this.figures.push(loop, back,
      series("Input", "input", labels.input, [{ label: labels.input, values: a.x, colour: "ink", width: 1.2 }], 200),
      series("Output and model", "output", labels.output, [{ label: "measured", values: a.y, colour: "data", width: 2 }, { label: "model", values: a.predicted, colour: "model" }], 240),
      series("Residual: measured less model", "residual", labels.output, [{ label: "residual", values: residual, colour: "test", width: 1 }], 200));

    const weights = new TimePlot(wide, { title: "Weights of the operators", name: "weights", xLabel: `threshold [${labels.inputUnit || "input"}]`, yLabel: `weight [${ratio(labels, true)}]`, height: 220,
      described: `${a.model.weights.length} weights.` });
    weights.set(a.model.thresholds, [{ label: "weight", values: a.model.weights, colour: "train", bars: true }]);
    this.figures.push(weights);

    const inverse = h("section", { class: "card" });
    this.results.append(inverse);
    this.figures.push(new Inverse(inverse, this.core, a));
    this.results.append(this.takeaway(a, bad));
    Object.assign(this.results, { answer: a }); // for the console of the browser, and for tests
    const { element } = this.figures[4] as TimePlot;
    void this.engine.then((engine) => engine.more()).then((more) => {
      Object.assign(a, more);
      if (more.left) element.append(h("p", { class: "caption" }, more.left), this.cures(more.left) ?? "");
    }, () => undefined); // another log came, or it was stopped
  }

  private async zip(stem: string): Promise<void> {
    const files = await this.during("Writing C", (engine) => engine.files(`${stem}.model`));
    if (files) save(`${stem}-c.zip`, zipped(files) as BlobPart, "application/zip");
  }

  private takeaway(a: Answer, bad: boolean): HTMLElement {
    const stem = (this.summary!.name.replace(/(\.csv|\.txt|\.tsv|\.dat)?(\.gz)?$/i, "") || "log").replace(/[^\w-]+/g, "-");
    const file = `${stem}.model.json`;
    return h("section", { class: "card" },
      h("h2", {}, "Take it with you"),
      bad ? h("p", { class: "caption" }, "The verdict says not to compensate with this model: it may serve to simulate.") : null,
      h("div", { class: "row" },
        h("button", { type: "button", class: "main", onclick: () => save(file, a.file, "application/json") }, file),
        h("button", { type: "button", onclick: () => void this.zip(stem) }, "C code (zip)")),
      h("p", { class: "caption" }, `${file} is read by every command of dehyst. The zip holds what `, h("code", {}, `dehyst export ${file} --target c`),
        " writes: the core, this compensator, an example, and a check that runs with ", h("code", {}, "make check"), "."),
      h("h3", {}, "In a terminal"),
      h("p", { class: "caption" }, "This page fits one family, pi. All of them, also with creep, rate and saturation, are compared by:"),
      h("div", { id: "command" }, line(a.command)),
      h("p", { class: "caption" }, "And this very model again, with its report, by:"),
      h("div", { id: "repeat" }, line(a.repeat)));
  }
}

function tile(title: string, value: string, remark: string): HTMLElement {
  return h("div", {}, h("dt", {}, title), h("dd", {}, h("span", { class: "value" }, value), h("span", { class: "remark" }, remark)));
}

const unit = (value: number, name: string): string => `${short(value)}${name ? ` ${name}` : ""}`;
const ratio = ({ inputUnit, outputUnit }: Answer["labels"], turned = false): string =>
  inputUnit && outputUnit ? (turned ? `${outputUnit}/${inputUnit}` : `${inputUnit}/${outputUnit}`) : turned ? "output/input" : "";

/** Where a mask holds, as parts of the abscissa. */
function spans(mask: Uint8Array, t: ArrayLike<number>): Shade[] {
  const found: Shade[] = [];
  for (let k = 0; k < mask.length; k++) {
    if (!mask[k]) continue;
    const from = k;
    while (k + 1 < mask.length && mask[k + 1]) k++;
    found.push({ from: t[from], to: t[k], colour: "test" });
  }
  return found;
}

/** A log of an actuator that never was: plays, a trace of noise, loops that shrink. */
function example(core: Core): File {
  const thresholds = [0, 0.2, 0.45, 0.8, 1.2, 1.7];
  const actuator = Model.make(core, thresholds, [6.5, 2.6, 2.1, 1.6, 1.2, 0.9], { offset: 4 });
  const rows = ["time_s,pressure_bar,angle_deg"];
  let seed = 7;
  const noise = (): number => ((seed = (seed * 16807) % 2147483647) / 2147483647 + (seed = (seed * 16807) % 2147483647) / 2147483647 - 1);
  for (let k = 0; k < 6000; k++) {
    const t = k / 100;
    const x = 2.2 * Math.cos(1.1 * t) * (0.35 + 0.65 * Math.abs(Math.cos(0.105 * t)));
    rows.push(`${t.toFixed(2)},${(2.5 + x).toFixed(5)},${(actuator.step(x) + 0.08 * noise()).toFixed(5)}`);
  }
  actuator.free();
  return new File([rows.join("\n") + "\n"], "made-up.csv", { type: "text/csv" });
}
