/** The tab of a log: drop, columns, model beside the best curve, figures, the inverse at work, model file. What needs
 * judgement is Python's, and the command for it stands there to be typed. */

import { served } from "./api";
import { typed } from "./command";
import { h, line, painted, save } from "./dom";
import { Family, Fit, fit } from "./fit";
import { Inverse } from "./inverse";
import { check, Column, labelOf, Log, propose, readLog, textOf } from "./log";
import { loopNumbers } from "./loop";
import { modelFile } from "./model_file";
import { Link, LoopPlot, Shade, short, TimePlot } from "./plots";
import { Refusal } from "./refusal";
import { Core, mapped, Model } from "./wasm";

export function mount(root: HTMLElement, core: Core): void {
  new Identify(root, core);
}

class Identify {
  private readonly status = h("p", { role: "status", "aria-live": "polite", class: "status" });
  private readonly trouble = h("div", { role: "alert" });
  private readonly columns = h("div", {});
  private readonly results = h("div", { class: "results" });
  private figures: { destroy(): void }[] = [];
  private log: Log | null = null;
  private unsaved: File | null = null; // a log that lies on no disk
  private turn = 0; // the newest request: what an older one read is dropped

  constructor(root: HTMLElement, private readonly core: Core) {
    root.append(this.dropZone(), this.status, this.trouble, this.columns, this.results);
  }

  private dropZone(): HTMLElement {
    const picker = h("input", { type: "file", id: "log", class: "hidden-input", accept: ".csv,.txt,.tsv,.dat,.gz,text/csv,text/plain",
      onchange: () => { if (picker.files?.[0]) void this.open(picker.files[0]); picker.value = ""; } });
    const zone = h("div", { class: "drop" },
      h("div", {},
        h("h2", {}, "Drop a log here"),
        h("p", { class: "caption" }, "Or paste one. CSV or text with one row a sample below a line of names: an input column (pressure, voltage), the output it moved (angle, displacement), a time column if there is one.")),
      h("div", { class: "row" },
        h("label", { class: "button main", for: "log" }, "Choose a file"), picker,
        h("button", { type: "button", onclick: () => void this.open(example(this.core), true) }, "Try an example")));
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
    addEventListener("paste", (event) => {
      const text = event.clipboardData?.getData("text/plain") ?? "";
      if (!zone.offsetParent || !text.includes("\n") || event.target instanceof HTMLInputElement) return;
      event.preventDefault();
      void this.open(new File([text], "pasted.csv", { type: "text/csv" }), true);
    });
    return zone;
  }

  /** Do something that may be refused: its sentence while it runs, the reason and the command where it ends. */
  private async during(sentence: string, work: () => Promise<void> | void): Promise<void> {
    const turn = ++this.turn;
    this.trouble.replaceChildren();
    this.status.replaceChildren(h("span", { class: "spinner", "aria-hidden": "true" }), `${sentence} …`);
    await painted();
    try {
      if (turn === this.turn) await work();
    } catch (fault) {
      if (turn === this.turn) this.refuse(fault);
    } finally {
      if (turn === this.turn) this.status.replaceChildren();
    }
  }

  private refuse(fault: unknown): void {
    const message = fault instanceof Error ? fault.message : String(fault);
    const command = fault instanceof Refusal ? fault.command : "";
    this.trouble.replaceChildren(h("div", { class: "judged stop" },
      h("span", { class: "badge" }, fault instanceof Refusal ? "This log cannot be used here as it is" : "The page failed"),
      h("p", { class: "lead" }, message), command ? line(command) : null, command ? this.way() : null));
  }

  /** How to come to a command: the log on a disk, dehyst installed, or its studio. */
  private way(): HTMLElement {
    const { unsaved } = this;
    return h("div", {},
      unsaved ? h("p", { class: "row" }, h("button", { type: "button", onclick: () => save(unsaved.name, unsaved, "text/csv") }, `Save ${unsaved.name}`), "This log lies on no disk yet.") : null,
      served() ? h("p", { class: "caption" }, "Or open it on the tab Studio, which has all of dehyst behind it.")
        : h("p", { class: "caption" }, "To install dehyst: ", h("code", {}, "pip install dehyst"), ". ", h("code", {}, "dehyst studio"), " opens this page with all of it behind."));
  }

  private clear(): void {
    for (const figure of this.figures) figure.destroy();
    this.figures = [];
    Object.assign(this.results, { answer: null });
    this.results.replaceChildren();
  }

  private async open(file: File, unsaved = false): Promise<void> {
    this.clear();
    this.unsaved = unsaved ? file : null;
    this.log = null;
    this.columns.replaceChildren();
    await this.during(`Reading ${file.name}`, async () => {
      const turn = this.turn;
      const text = await textOf(file);
      if (turn !== this.turn) return; // another log came
      this.log = readLog(file.name, text);
      this.choose(this.log);
    });
    if (this.log && propose(this.log).clear) await this.identify();
  }

  // ---- columns
  private choose(log: Log): void {
    const { input, output, clear } = propose(log);
    const list = (id: string, chosen: string): HTMLSelectElement => {
      const select = h("select", { id }, h("option", { value: "" }, "choose …"), ...log.columns.filter((column) => column !== log.time).map((column) =>
        h("option", { value: column.name }, `${labelOf(column)}${column.missing ? ` (${column.missing} missing)` : ""}`)));
      select.value = chosen;
      return select;
    };
    const family = h("select", { id: "family" }, h("option", { value: "pi" }, "pi: sum of plays"), h("option", { value: "modified-pi" }, "modified-pi: plays and a curve, for loops that saturate"));
    this.columns.replaceChildren(
      h("section", { class: "card" },
        h("h2", {}, log.name),
        h("p", { class: "caption" }, `${log.rows.toLocaleString("en")} rows, ${log.time ? `time is ${log.time.name}` : "no time column"}.`,
          clear ? " Names and units leave no other choice of columns." : " The columns are a guess: confirm or change them."),
        h("div", { class: "row" },
          h("label", { for: "input" }, "Input, what drives", list("input", input)), h("label", { for: "output" }, "Output, what follows", list("output", output)),
          h("label", { for: "family" }, "Family", family), h("button", { type: "button", class: "main", onclick: () => void this.identify() }, "Identify"))));
  }

  // ---- result
  private async identify(): Promise<void> {
    const log = this.log!;
    const value = (id: string): string => (document.getElementById(id) as HTMLSelectElement).value;
    const column = (id: string): Column | undefined => log.columns.find(({ name }) => name === value(id));
    const [input, output] = [column("input"), column("output")];
    this.clear();
    if (!input || !output || input === output) {
      this.refuse(new Refusal("Choose one column for the input and another one for the output."));
      return;
    }
    const options = { input: input.name, output: output.name };
    await this.during("Identifying", async () => {
      check(log.name, input);
      check(log.name, output);
      let result: Fit;
      try {
        result = fit(this.core, value("family") as Family, input.values, output.values, [input.name, output.name]);
      } catch (fault) {
        throw fault instanceof Refusal && !fault.command ? new Refusal(fault.message, typed("identify", log.name, options)) : fault;
      }
      await this.show(log, input, output, result);
    });
  }

  private async show(log: Log, input: Column, output: Column, result: Fit): Promise<void> {
    const { scores } = result;
    const link = new Link();
    const t = log.time?.values ?? Float64Array.from(input.values, (_v, k) => k);
    const shades: Shade[] = [{ from: t[result.fitted], to: t[t.length - 1], colour: "test" }];
    const plots = h("div", { class: "panels" });
    const wide = h("div", { class: "stack" });
    const share = scores.test.rmse / scores.curve.rmse;
    const lead = share < 1 ? `On the half of the log that was held out, the model errs ${short(1 / share, 3)} times less than the best curve without hysteresis.`
      : "On the half of the log that was held out, the model errs no less than the best curve without hysteresis.";
    this.results.append(
      h("section", { class: "judged care", id: "result", tabindex: -1 },
        h("span", { class: "badge" }, "Two figures, no verdict"),
        h("p", { class: "lead" }, lead),
        h("p", { class: "caption" }, "Whether a compensator is worth it also depends on creep, rate, gaps, drift and other families. Python judges that: the command stands below."),
        h("dl", { class: "tiles" },
          tile("Model errs by", `${short(scores.test.percent, 3)} %`, `of range, rms, held out: ${unit(scores.test.rmse, output)}`),
          tile("The best curve by", `${short(scores.curve.percent, 3)} %`, `of range, rms, held out: ${unit(scores.curve.rmse, output)}`),
          tile("On fitted samples", `${short(scores.train.percent, 3)} %`, `of range, rms: ${unit(scores.train.rmse, output)}`),
          tile("Operators", String(result.model.weights.length), `of 100 carry weight; assumed before the log: ${result.start}`)),
        h("p", { id: "loop-numbers", class: "caption" }, loopWords(input, output))),
      plots,
      h("p", { class: "caption" }, "The shaded part was held out: the model has not seen it. Drag over a figure to zoom, double click to see all; the cursor walks along all of them."),
      wide);
    document.getElementById("result")!.focus({ preventScroll: true });
    const [inputName, outputName] = [labelOf(input), labelOf(output)];
    const loop = new LoopPlot(plots, { title: "The loop", name: "loop", xLabel: inputName, yLabel: outputName, link, height: 360, described: "Measured loop, the model's, and the best curve without hysteresis." });
    loop.set([
      { label: "measured", x: input.values, y: output.values, colour: "data", width: 3, linked: true },
      { label: "model", x: input.values, y: result.predicted, colour: "model", width: 1 },
      { label: "plain curve", x: result.curve.u, y: result.curve.v, colour: "static", dash: [6, 4] },
    ]);
    this.figures.push(loop);
    if (result.asked) {
      const ends = [Math.min(...result.curve.u as Float64Array), Math.max(...result.curve.u as Float64Array)];
      const back = new LoopPlot(plots, { title: "The inverse: asked for, against applied", name: "asked", xLabel: `${inputName}, applied`, yLabel: `${inputName}, asked for`, link, height: 360, equal: true,
        described: "The inverse's answer to the measured output against the input that was applied: on the diagonal it gives it back." });
      back.set([
        { label: "inverse of the measured output", x: input.values, y: result.asked, colour: "train", linked: true },
        { label: "45°", x: ends, y: ends, colour: "other", dash: [5, 4] },
      ]);
      this.figures.push(back);
    }
    const series = (title: string, name: string, yLabel: string, lines: Parameters<TimePlot["set"]>[1], height: number): TimePlot => {
      const plot = new TimePlot(wide, { title, name, xLabel: log.time ? labelOf(log.time) : "sample", yLabel, link, height });
      plot.set(t, lines, shades);
      return plot;
    };
    const residual = output.values.map((value, k) => value - result.predicted[k]);
    this.figures.push(
      series("Input", "input", inputName, [{ label: inputName, values: input.values, colour: "ink", width: 1.2 }], 200),
      series("Output and model", "output", outputName, [{ label: "measured", values: output.values, colour: "data", width: 2 }, { label: "model", values: result.predicted, colour: "model" }], 240),
      series("Residual: measured less model", "residual", outputName, [{ label: "residual", values: residual, colour: "test", width: 1 }], 200));
    const inverse = h("section", { class: "card" });
    this.results.append(inverse);
    this.figures.push(new Inverse(inverse, this.core, result, input, output, log.columns.filter((column) => column !== log.time && !column.missing)));
    const file = modelFile(result, log, input, output, version());
    this.results.append(this.takeaway(log, input, output, result, file));
    const curve = mapped(this.core, result.curve, input.values);
    Object.assign(this.results, { answer: { ...result, x: input.values, y: output.values, curveAt: curve, file } }); // for the console of the browser, and for tests
  }

  private takeaway(log: Log, input: Column, output: Column, result: Fit, text: string): HTMLElement {
    const stem = (log.name.replace(/(\.csv|\.txt|\.tsv|\.dat)?(\.gz)?$/i, "") || "log").replace(/[^\w-]+/g, "-");
    const file = `${stem}.model.json`;
    const columns = { input: input.name, output: output.name };
    const again = { ...columns, family: result.family, eps: String(result.eps), "initial-state": result.start, save: "model.json", report: "report.html" };
    return h("section", { class: "card" },
      h("h2", {}, "The verdict, in a terminal"),
      h("p", { class: "caption" }, "All families on the same columns, with warnings, a verdict and a report:"),
      h("div", { id: "command" }, line(typed("identify", log.name, { ...columns, save: "model.json", report: "report.html" }))),
      h("p", { class: "caption" }, "This family alone, judged:"),
      h("div", { id: "repeat" }, line(typed("identify", log.name, again))),
      this.way(),
      h("h2", {}, "Take the model with you"),
      h("div", { class: "row" }, h("button", { type: "button", class: "main", onclick: () => save(file, text, "application/json") }, file)),
      h("p", { class: "caption" }, `${file} is read by every command of dehyst; it says that nobody judged it. C code of its compensator is written by:`),
      line(typed("export", file, { target: "c", out: "compensator" })));
  }
}

function tile(title: string, value: string, remark: string): HTMLElement {
  return h("div", {}, h("dt", {}, title), h("dd", {}, h("span", { class: "value" }, value), h("span", { class: "remark" }, remark)));
}

/** Numbers of the deepest loop, in one sentence. */
function loopWords(input: Column, output: Column): string {
  const numbers = loopNumbers(input.values, output.values);
  if (!numbers) return "No loop of this log closes: dehyst loops says what there is.";
  const both = input.unit && output.unit ? ` ${input.unit} ${output.unit}` : "";
  return `The deepest loop: width ${unit(numbers.width, output)} at the middle, area ${short(numbers.area)}${both}, coercivity ${unit(numbers.coercivity, input)} at output ${numbers.at}. dehyst loops prints these and more, with intervals.`;
}

const unit = (value: number, column: Column): string => `${short(value)}${column.unit ? ` ${column.unit}` : ""}`;
const version = (): string => document.querySelector<HTMLMetaElement>('meta[name="generator"]')!.content.replace("dehyst ", "");

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
