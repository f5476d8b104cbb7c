/** The tab "Studio": what only Python can do, on a page that `dehyst studio` serves. It asks for commands of dehyst and
 * shows what they print; it decides nothing itself. */

import * as api from "./api";
import { h, line, save } from "./dom";
import { Given, Options } from "./options";
import { Link, short, TimePlot } from "./plots";
import type { Core } from "./wasm";

export { served } from "./api";

interface Column {
  name: string;
  unit: string;
  minimum: number;
  role: string;
  reason: string;
  constant: boolean;
  loops: number;
}

interface Finding {
  code: string;
  message: string;
}

interface Summary {
  name: string;
  rows: number;
  columns: Column[];
  runs: Record<string, number>;
  run: string | null;
  input: string | null;
  output: string | null;
  findings: Finding[];
}

interface Signals {
  samples: number;
  timed: boolean;
  time: number[];
  input: number[];
  output: number[];
  labels: [string, string];
}

interface Score {
  rmse: number;
  rmse_percent: number;
  max: number;
}

interface Fit {
  family: string;
  grade: string;
  verdict: string;
  train: Score;
  test: Score | null;
  static_test: Score | null;
  inverse_gain: number | null;
  warnings: Finding[];
}

interface Compared {
  verdict: string;
  chosen: string;
  auto: { family: string };
  warnings: Finding[];
  families: Record<string, { title: string; test: Score | null; train: Score | null; inverse_percent: number | null; invertible: boolean; parameters: number; seconds: number; tied: boolean; reason: string }>;
}

interface Exported {
  name: string;
  what: string;
  files: string[];
  bytes: number;
  warnings: Finding[];
}

interface Verified {
  checks?: { claim: string; status: string; detail: string }[];
}

const TIED = " *";
const WORKBOOK = /\.(xls[xmb]?|ods)$/i; // the files that hold sheets

/** Fill the tab. */
export function mount(root: HTMLElement, _core: Core): void {
  root.classList.add("studio");
  api.state().then((state) => new Studio(root, state), (fault: unknown) => root.append(alert(fault)));
}

class Studio {
  private readonly logs: HTMLSelectElement;
  private readonly about = h("div");
  private log: api.Log | null = null;

  constructor(root: HTMLElement, private readonly state: api.State) {
    this.logs = h("select", { onchange: () => this.choose(this.logs.value) });
    const file = h("input", { type: "file", hidden: true, onchange: () => { void this.take(file.files); file.value = ""; } });
    const open = h("button", { type: "button", onclick: () => file.click() }, "Open a log …");
    root.append(h("h2", {}, "Your log"), h("div", { class: "row" }, h("label", {}, "Log", this.logs), open, file,
      h("p", { class: "caption" }, "Any format that dehyst reads; or drop it here. It is copied to a temporary folder of this machine, which goes when the studio ends.")), this.about);
    root.addEventListener("dragover", (event) => event.preventDefault());
    root.addEventListener("drop", (event) => {
      event.preventDefault();
      void this.take(event.dataTransfer?.files ?? null);
    });
    void api.stay(() => root.prepend(alert(new api.Refusal("The studio has ended. What you downloaded stays; start it again with dehyst studio."))));
    this.list();
    const first = state.logs.find(({ refused }) => !refused) ?? state.logs[0];
    if (first) this.choose(first.id);
  }

  private list(): void {
    this.logs.replaceChildren(...this.state.logs.map((log) => h("option", { value: log.id }, `${this.called(log)}${log.refused ? " (refused)" : ""}`)));
    if (!this.state.logs.length) this.logs.append(h("option", {}, "none yet"));
    this.logs.disabled = !this.state.logs.length;
    if (this.log) this.logs.value = this.log.id;
  }

  /** The name of a log; of several of one name with the number of its turn. */
  private called(log: api.Log): string {
    const same = this.state.logs.filter(({ name }) => name === log.name);
    return same.length > 1 ? `${log.name} (${same.indexOf(log) + 1})` : log.name;
  }

  private async take(files: FileList | null): Promise<void> {
    for (const file of files ?? []) {
      this.about.replaceChildren(h("p", { class: "caption", role: "status" }, `Reading ${file.name} …`));
      try {
        const log = await api.upload(file, this.state.limit);
        this.state.logs.push(log);
        this.choose(log.id);
      } catch (fault) {
        this.about.replaceChildren(alert(fault));
      }
    }
  }

  private choose(id: string): void {
    this.log = this.state.logs.find((log) => log.id === id)!;
    this.list();
    const job = new Job();
    const log = this.log;
    const sheet = h("input", { type: "text", id: "studio-sheet", placeholder: "the one with the most numbers", value: log.sheet ?? "", autocomplete: "off",
      onchange: () => { log.sheet = sheet.value.trim() || undefined; this.choose(id); } });
    const book = WORKBOOK.test(log.name) && h("div", { class: "row" }, h("label", {}, h("span", {}, "Sheet, by name or number ", h("code", {}, "--sheet")), sheet));
    this.about.replaceChildren(...(book ? [book] : []), job.element);
    const known = (refused: boolean): void => {
      log.refused = refused;
      this.list();
    };
    void job.run<Summary>("inspect", { log: log.id, sheet: log.sheet }, ({ result }) => {
      known(false);
      job.element.remove();
      new Work(this.about, this.state, log, { ...result, name: this.called(log) });
    }, () => known(true));
  }
}

/** One log: columns, part of it, models, code. */
class Work {
  private readonly columns: Record<"input" | "output", HTMLSelectElement>;
  private readonly runs: HTMLInputElement[];
  private readonly windows = h("div", { class: "windows" });
  private bounds: [HTMLInputElement, HTMLInputElement][] = []; // ends of each window
  private readonly add = h("button", { type: "button", onclick: () => { this.window("", ""); this.bounds[this.bounds.length - 1][0].focus(); } }, "Add a window");
  private readonly family: HTMLSelectElement;
  private readonly purpose: HTMLSelectElement;
  private readonly extra: Record<"load" | "mean_pressure", HTMLSelectElement>;
  private readonly options: Options;
  private readonly charts = h("div");
  private readonly job = new Job((message) => this.cures(message));
  private readonly found = h("div");
  private plots: TimePlot[] = [];
  private drawn: Signals | null = null;

  constructor(
    root: HTMLElement,
    private readonly state: api.State,
    private readonly log: api.Log,
    summary: Summary,
  ) {
    const numbers = summary.columns.filter((column) => column.role !== "time" && column.role !== "run");
    const pick = (chosen: string | null, none = ""): HTMLSelectElement => {
      const select = h("select", {}, ...(none || chosen === null ? [h("option", { value: "" }, none || "choose …")] : []),
        ...numbers.map(({ name, unit, constant }) => h("option", { value: name }, `${name}${unit && !name.endsWith(unit) ? ` [${unit}]` : ""}${constant ? " (constant)" : ""}`)));
      select.value = chosen ?? "";
      return select;
    };
    this.columns = { input: pick(summary.input), output: pick(summary.output) };
    for (const select of Object.values(this.columns)) select.addEventListener("change", () => this.draw());
    const names = Object.keys(summary.runs);
    this.runs = names.map((name) => h("input", { type: "checkbox", value: name, onchange: () => this.draw() }));
    if (this.runs.length) this.runs[Math.max(0, names.indexOf(summary.run ?? ""))].checked = true;
    this.window("", "");
    this.family = h("select", { onchange: () => this.direct() }, h("option", { value: "auto" }, "auto: the best for this log"),
      ...state.families.map(({ name, title }) => h("option", { value: name }, `${title} (${name})`)));
    this.purpose = h("select", {}, h("option", { value: "compensate" }, "compensation"), h("option", { value: "simulate" }, "simulation"));
    this.extra = { load: pick(null, "none"), mean_pressure: pick(null, "none") };
    this.options = new Options({ ...state, columns: summary.columns }, () => this.identify());
    for (const list of this.options.element.querySelectorAll("select")) list.addEventListener("change", () => this.draw());
    const act = (command: "identify" | "compare", words: string, main = false): HTMLButtonElement =>
      h("button", { type: "button", ...(main ? { class: "main" } : {}), onclick: () => this[command]() }, words);
    root.append(
      h("p", { class: "caption" }, `${summary.name}: ${summary.rows} rows${names.length > 1 ? `, ${names.length} runs` : ""}.`),
      ...summary.findings.map((each) => this.finding(each)),
      h("div", { class: "row" }, h("label", {}, "Input, what drives", this.columns.input), h("label", {}, "Output, what follows", this.columns.output),
        this.runs.length > 1 && h("fieldset", {}, h("legend", {}, "Runs"), ...this.runs.map((box, k) => h("label", { class: "check" }, box, `${names[k]} (${summary.runs[names[k]]})`)))),
      this.charts,
      h("div", { class: "row" }, this.windows, this.add,
        h("button", { type: "button", onclick: () => this.whole() }, "Whole log"),
        h("p", { class: "caption" }, "Drag over a figure to use a part of the log only, with Shift for one part more. Parts are fitted together.")),
      h("h2", { class: "step" }, "Identify"),
      h("div", { class: "row" }, h("label", {}, "Family", this.family), h("label", {}, "Model for", this.purpose),
        h("label", { class: "of-direct", hidden: true }, "Load column", this.extra.load), h("label", { class: "of-direct", hidden: true }, "Mean pressure column", this.extra.mean_pressure),
        act("identify", "Identify", true), act("compare", "Compare all families")),
      this.options.element, this.job.element, this.found,
    );
    this.draw();
  }

  /** Options of the whole selection, as the command line names them. */
  private part(): Record<string, unknown> {
    const chosen = this.chosen();
    const several = chosen.length > 1; // then each needs both of its ends
    return {
      logs: [this.log.id],
      sheet: this.log.sheet,
      input: this.columns.input.value,
      output: this.columns.output.value,
      runs: this.runs.length > 1 ? this.runs.filter((box) => box.checked).map((box) => box.value) : [],
      start: chosen.flatMap(([from]) => (Number.isFinite(from) || several ? [String(from).replace("Infinity", "inf")] : [])),
      stop: chosen.flatMap(([, to]) => (Number.isFinite(to) || several ? [String(to).replace("Infinity", "inf")] : [])),
    };
  }

  /** The windows in their order in time, infinite where no end is named; one that names none is the whole log. */
  private chosen(): [number, number][] {
    const end = (input: HTMLInputElement, none: number): number => (Number.isFinite(input.valueAsNumber) ? input.valueAsNumber : none);
    const all = this.bounds.map(([from, to]): [number, number] => [end(from, -Infinity), end(to, Infinity)]);
    const named = all.filter(([from, to]) => Number.isFinite(from) || Number.isFinite(to));
    return named.sort((a, b) => a[0] - b[0]);
  }

  private draw(): void {
    this.plots.forEach((plot) => plot.destroy());
    this.plots = [];
    const { input, output } = { input: this.columns.input.value, output: this.columns.output.value };
    if (!input || !output || input === output) {
      this.charts.replaceChildren(h("p", { class: "caption" }, "Choose the columns of input and output."));
      return;
    }
    const run = this.runs.length > 1 ? (this.runs.find((box) => box.checked)?.value ?? null) : null;
    const job = new Job((message) => this.options.cures(message, () => undefined)); // what is changed is drawn
    this.charts.replaceChildren(job.element);
    void job.run<Signals>("signals", { log: this.log.id, sheet: this.log.sheet, input, output, run, ...this.given()?.reading }, ({ result }) => {
      const panels = h("div", { class: "signals" });
      this.charts.replaceChildren(panels);
      this.drawn = result;
      const link = new Link();
      const x = result.timed ? "time [s]" : "sample";
      this.plots = ([["input", "train"], ["output", "test"]] as const).map(([name, colour], k) => {
        const plot = new TimePlot(panels, {
          title: k ? "Output" : "Input", name: `${this.log.name}-${name}`, xLabel: x, yLabel: result.labels[k], height: 190, link,
          described: "Drag to choose a part of the log, with Shift one more, or type its times below.",
          ...(result.timed ? { onBrush: (from: number, to: number, more: boolean) => this.brushed(Number(from.toPrecision(6)), Number(to.toPrecision(6)), more) } : {}),
        });
        plot.set(result.time, [{ label: result.labels[k], values: result[name], colour }]);
        return plot;
      });
      for (const input of [...this.bounds.flat(), this.add]) input.disabled = !result.timed;
      this.shade();
    });
  }

  /** One window more. */
  private window(from: string, to: string): void {
    const bound = (): HTMLInputElement => h("input", { type: "number", step: "any", onchange: () => this.shade(), size: 8 });
    const pair: [HTMLInputElement, HTMLInputElement] = [bound(), bound()];
    [pair[0].value, pair[1].value] = [from, to];
    for (const input of pair) input.disabled = this.drawn?.timed === false;
    this.bounds.push(pair);
    this.rows();
  }

  private rows(): void {
    this.windows.replaceChildren(...this.bounds.map((pair, k) => h("div", { class: "row", role: "group", "aria-label": `Window ${k + 1}` },
      h("label", {}, "From [s]", pair[0]), h("label", {}, "To [s]", pair[1]),
      this.bounds.length > 1 && h("button", { type: "button", class: "quiet", "aria-label": `Remove window ${k + 1}`, onclick: () => this.remove(pair) }, "Remove"))));
    this.shade();
  }

  private remove(pair: [HTMLInputElement, HTMLInputElement]): void {
    this.bounds = this.bounds.filter((each) => each !== pair);
    this.rows();
    this.add.focus();
  }

  private whole(): void {
    this.bounds = [];
    this.window("", "");
  }

  /** Take a part of the log, alone or beside the others; parts that meet become one. */
  private brushed(from: number, to: number, more: boolean): void {
    const apart: [number, number][] = [];
    for (const part of [...(more ? this.chosen() : []), [from, to] as [number, number]].sort((a, b) => a[0] - b[0])) {
      const last = apart[apart.length - 1];
      if (last && part[0] <= last[1]) last[1] = Math.max(last[1], part[1]);
      else apart.push([...part]);
    }
    this.bounds = [];
    for (const ends of apart) this.window(...(ends.map((end) => (Number.isFinite(end) ? String(end) : "")) as [string, string]));
  }

  private shade(): void {
    if (!this.drawn) return;
    const [first, last] = [this.drawn.time[0], this.drawn.time[this.drawn.time.length - 1]];
    const out: { from: number; to: number; colour: string }[] = [];
    let reached = first;
    for (const [from, to] of [...this.chosen(), [Infinity, Infinity]]) {
      if (from > reached) out.push({ from: reached, to: Math.min(from, last), colour: "ink" });
      reached = Math.max(reached, to);
    }
    this.plots.forEach((plot) => plot.mark(this.chosen().length ? out : []));
  }

  /** The options as they stand; null if one is no number, which is said. */
  private given(): Given | null {
    try {
      return this.options.given();
    } catch (fault) {
      this.job.fail(fault);
      return null;
    }
  }

  /** Buttons for what a message prescribes. */
  private cures(message: string): HTMLElement[] {
    return this.options.cures(message, () => this.identify());
  }

  private finding({ code, message }: Finding): HTMLElement {
    return h("div", { class: "warning" }, h("code", {}, code), `: ${message}`, ...row(this.cures(message)));
  }

  private direct(): void {
    const on = this.family.value === "direct-inverse";
    for (const label of this.found.parentElement!.querySelectorAll<HTMLElement>(".of-direct")) label.hidden = !on;
  }

  private identify(): void {
    this.found.replaceChildren();
    const direct = this.family.value === "direct-inverse";
    const extra = direct ? { load: this.extra.load.value, mean_pressure: this.extra.mean_pressure.value } : {};
    const given = this.given();
    if (!given) return;
    void this.job.run<Fit>("identify", { ...this.part(), ...given.reading, ...given.fitting, family: this.family.value, purpose: this.purpose.value, ...extra }, (got) => this.show(got));
  }

  private show({ result, files, command }: api.Outcome<Fit>): void {
    const unit = /( \[[^\]]+\])$/.exec(this.drawn?.labels[1] ?? "")?.[1] ?? "";
    const row = (name: string, score: Score | null): HTMLElement | null => score &&
      h("tr", {}, h("th", { scope: "row" }, name), ...[score.rmse_percent, score.rmse, score.max].map((v) => h("td", { class: "number" }, short(v))));
    this.found.replaceChildren(
      h("p", { class: `verdict ${result.grade}`, role: "status" }, result.verdict),
      h("div", { class: "scroll", tabindex: 0, role: "region", "aria-label": "Scores" }, h("table", {}, h("thead", {}, h("tr", {}, h("td"), ...["rms [% of range]", `rms${unit}`, `largest${unit}`].map((name) => h("th", { class: "number", scope: "col" }, name)))),
        h("tbody", {}, row(`${result.family}, fitted`, result.train), row(`${result.family}, held out`, result.test), row("no hysteresis, held out", result.static_test)))),
      ...result.warnings.map((each) => this.finding(each)),
      h("div", { class: "row" }, view(files.report), get("Model file", files.save, "model.json", this.job)),
      h("p", { class: "caption" }, "The same in a terminal:"), line(command),
    );
    this.code(files.save);
  }

  private compare(): void {
    this.found.replaceChildren();
    const given = this.given();
    if (!given) return;
    const { train_fraction } = given.fitting; // the other ones are those of plays alone
    void this.job.run<Compared>("compare", { ...this.part(), ...given.reading, train_fraction }, ({ result, files, command }) => {
      const rows = Object.entries(result.families);
      const percent = (value: number | null | undefined): string => (value === null || value === undefined ? "" : short(value, 3));
      this.found.replaceChildren(
        h("p", { class: "verdict", role: "status" }, result.verdict),
        h("div", { class: "scroll", tabindex: 0, role: "region", "aria-label": "Families" }, h("table", {}, h("thead", {}, h("tr", {}, h("th", { scope: "col" }, "Family"),
          ...["held out [%]", "fitted [%]", "inverse [%]", "parameters", "time [s]"].map((name) => h("th", { class: "number", scope: "col" }, name)), h("td"))),
        h("tbody", {}, ...rows.map(([name, one]) => h("tr", name === result.chosen ? { class: "chosen" } : {},
          h("th", { scope: "row" }, `${one.title} (`, h("code", {}, name), `)${one.tied ? TIED : ""}`),
          ...[percent(one.test?.rmse_percent), percent(one.train?.rmse_percent), one.invertible ? percent(one.inverse_percent) : "none", String(one.parameters), percent(one.seconds)].map((cell) => h("td", { class: "number" }, cell)),
          h("td", {}, h("button", { type: "button", class: "quiet", "aria-label": `Identify with ${one.title}`, onclick: () => this.take(name) }, "Identify"))))))),
        h("p", { class: "caption" }, `rms, percent of the output’s range (inverse: of the input’s); ${TIED.trim()} within noise of the best. What auto takes, without looking at the held-out errors: ${result.auto.family}.`),
        ...rows.filter(([, one]) => one.reason).map(([, one]) => h("p", { class: "caption" }, h("b", {}, one.title), `: ${one.reason}`)),
        ...result.warnings.map((each) => this.finding(each)),
        h("div", { class: "row" }, view(files.report), get("Model file of the best", files.save, "model.json", this.job)),
        h("p", { class: "caption" }, "The same in a terminal:"), line(command),
      );
    });
  }

  private take(family: string): void {
    this.family.value = family;
    this.direct();
    this.identify();
    this.job.element.scrollIntoView({ block: "center" });
  }

  /** The model as code. */
  private code(model: string | undefined): void {
    if (model === undefined) return;
    const job = new Job();
    const made = h("div");
    const target = h("select", { onchange: () => offer() }, ...this.state.targets.map(({ name, summary }) => h("option", { value: name }, `${name}: ${summary}`)));
    const real = h("select");
    const what = h("select", {}, h("option", { value: "inverse" }, "the compensator"), h("option", { value: "forward" }, "the model"));
    const name = h("input", { type: "text", value: "compensator", pattern: "[A-Za-z][A-Za-z0-9_]*", size: 12 });
    const prune = h("input", { type: "checkbox", checked: true });
    const offer = (): void => real.replaceChildren(...this.state.targets.find((one) => one.name === target.value)!.reals.map((each) => h("option", {}, each)));
    offer();
    const write = (): void => {
      made.replaceChildren();
      const given = { model, target: target.value, real: real.value, what: what.value, name: name.value, prune: prune.checked };
      void job.run<Exported>("export", given, ({ result, files, command }) => {
        const checked = h("div", { role: "status" });
        made.replaceChildren(
          h("p", {}, `${result.files.length} files, ${Math.round(result.bytes / 1000)} kB, names begin with ${result.name}_.`),
          ...result.warnings.map((each) => this.finding(each)),
          h("div", { class: "row" }, get("Download the zip", files.zip, `${result.name}-${target.value}.zip`, job, true),
            h("button", { type: "button", onclick: () => void job.run<Verified>("verify", { folder: files.folder }, (got) =>
              checked.replaceChildren(checks(got.result), h("p", { class: "caption" }, "The zip now holds the record of this; one that you downloaded before is older: download it again."))) }, "Verify it here")),
          checked,
          h("p", { class: "caption" }, "The same in a terminal:"), line(command),
        );
      });
    };
    this.found.append(h("h2", { class: "step" }, "Export"),
      h("div", { class: "row" }, h("label", {}, "Target", target), h("label", {}, "Numbers", real), h("label", {}, "What", what), h("label", {}, "Name in the code", name),
        h("label", { class: "check" }, prune, "leave out weights of zero"), h("button", { type: "button", class: "main", onclick: write }, "Export")), job.element, made);
  }
}

/** One command after the other: its progress, its stop, its error. */
class Job {
  readonly element = h("div", { class: "job" });
  private stop: AbortController | null = null;

  /** `cures`: buttons for what a refusal prescribes. */
  constructor(private readonly cures: (message: string) => HTMLElement[] = () => []) {}

  async run<T>(command: string, given: Record<string, unknown>, done: (outcome: api.Outcome<T>) => void, refused: () => void = () => undefined): Promise<void> {
    this.stop?.abort();
    const own = (this.stop = new AbortController());
    const bar = h("progress", { "aria-label": "Progress" });
    const words = h("span", { role: "status" }, "starting");
    const clock = h("span", { class: "clock" });
    const begun = performance.now();
    const timer = setInterval(() => { clock.textContent = `${Math.round((performance.now() - begun) / 1000)} s`; }, 500);
    const shown = h("div", { class: "progress" }, bar, words, clock, h("button", { type: "button", onclick: () => own.abort() }, "Stop"));
    const late = setTimeout(() => this.element.replaceChildren(shown), 250); // what is quick needs no bar
    this.element.replaceChildren();
    const told = ({ stage, done: at, of }: api.Progress): void => {
      words.textContent = of ? `${stage}, ${short(at)} of ${short(of)}` : stage;
      if (of) [bar.max, bar.value] = [of, at];
      else bar.removeAttribute("value");
    };
    let fault: unknown;
    let outcome: api.Outcome<T> | null = null;
    try {
      outcome = await api.run<T>(command, given, own.signal, told);
    } catch (caught) {
      fault = own.signal.aborted ? new api.Refusal("Stopped; nothing was kept of it.") : caught;
    }
    clearTimeout(late);
    clearInterval(timer);
    if (this.stop !== own) return; // another command has taken its place
    this.element.replaceChildren();
    if (!outcome) this.fail(fault);
    if (outcome) done(outcome);
    else if (!own.signal.aborted) refused();
  }

  fail(fault: unknown): void {
    this.element.replaceChildren(alert(fault), ...row(this.cures(fault instanceof Error ? fault.message : "")));
  }
}

function alert(fault: unknown): HTMLElement {
  const said = fault instanceof Error ? fault.message : String(fault);
  return h("p", { class: "warning", role: "alert" }, /^[a-z]+ /.test(said) ? said[0].toUpperCase() + said.slice(1) : said);
}

function row(cures: HTMLElement[]): HTMLElement[] {
  return cures.length ? [h("p", { class: "row cures" }, ...cures)] : [];
}

/** A link to a report, in a tab of its own. */
function view(id: string | undefined): HTMLElement | null {
  return id === undefined ? null : h("a", { class: "button", href: api.report(id), target: "_blank", rel: "noopener" }, "Open the report");
}

/** A button that saves a file of the studio. */
function get(words: string, id: string | undefined, name: string, job: Job, main = false): HTMLElement | null {
  const fetched = (): void => void api.file(id!).then((blob) => save(name, blob, blob.type), (fault: unknown) => job.fail(fault));
  return id === undefined ? null : h("button", { type: "button", ...(main ? { class: "main" } : {}), onclick: fetched }, words);
}

function checks(result: Verified): HTMLElement {
  const marks: Record<string, string> = { passed: "✓", failed: "✗", skipped: "–" };
  return h("ul", { class: "checks" }, ...(result.checks ?? []).map(({ claim, status, detail }) =>
    h("li", { class: status }, h("span", { "aria-label": status }, marks[status] ?? status), ` ${claim}${detail ? `: ${detail}` : ""}`)));
}
