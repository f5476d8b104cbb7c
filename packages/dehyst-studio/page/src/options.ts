/** The options of the command line that the messages of the page prescribe, as controls of the same names. */

import { h } from "./dom";
import { Refusal } from "./refusal";

type Control = HTMLInputElement | HTMLSelectElement;

/** What lists of an option hold: columns of the log, assumptions of its past, units of time. */
interface Known {
  columns: { name: string; minimum: number }[];
  starts: string[];
  units: string[];
}

/** What is passed on: names as Python has them, values as it takes them; what is left at its default is not there. */
export interface Given {
  reading: Record<string, string | number>;
  fitting: Record<string, string | number>;
}

interface Option {
  flag: string;
  name: string;
  about: string;
  control: Control;
  fits: boolean; // rather than reads
}

const WORDS = new Set(["auto"]); // that an option takes beside numbers
const isWord = (flag: string, text: string): boolean => WORDS.has(text) || (flag === "--time-unit" && Number.isNaN(Number(text)));

export class Options {
  readonly element: HTMLDetailsElement;
  private readonly all: Option[];

  constructor(known: Known, go: () => void) {
    const list = (usual: string, names: string[]): Control => h("select", {}, h("option", { value: "" }, usual), ...names.map((name) => h("option", {}, name)));
    const number = (usual: string): Control => h("input", { type: "text", inputmode: "decimal", placeholder: usual, size: 10, autocomplete: "off",
      onkeydown: (event: KeyboardEvent) => { if (event.key === "Enter") go(); } });
    const option = (fits: boolean, flag: string, label: string, control: Control): Option => ({ flag, name: flag.slice(2).replaceAll("-", "_"), about: label, control, fits });
    this.all = [
      option(true, "--train-fraction", "Share that is fitted, 0 to 1; the rest tests the model", number("first half")),
      option(true, "--eps", "Smallest slope after a reversal; auto: as firm as costs little", number("auto; of pi 0.001")),
      option(true, "--initial-state", "What the actuator did before the log", list("auto", known.starts)),
      option(true, "--max-inverse-gain", "Largest slope of the inverse, input over output; instead of the smallest slope", number("any")),
      option(true, "--ahead", "Seconds by which the reference is known before it is due, for a dead time", number("any")),
      option(false, "--time", "Time column", list("by its name", known.columns.filter(({ minimum }) => Number.isFinite(minimum)).map(({ name }) => name))),
      option(false, "--time-unit", "Unit of time, or seconds of one count", number(known.units.join(", "))),
      option(false, "--dt", "Seconds from row to row, if the log has no time", number("by its clock")),
    ];
    for (const { flag, control } of this.all) control.id = `studio${flag.slice(1)}`;
    this.element = h("details", { class: "options" }, h("summary", {}, "Options"),
      h("div", { class: "row" }, ...this.all.map(({ flag, about, control }) => h("label", { for: control.id }, h("span", {}, about, " ", h("code", {}, flag)), control))));
  }

  given(): Given {
    const given: Given = { reading: {}, fitting: {} };
    for (const { name, flag, control, fits } of this.all) {
      const text = control.value.trim();
      if (!text) continue;
      const value = control instanceof HTMLSelectElement || isWord(flag, text) ? text : Number(text.replace(",", "."));
      if (Number.isNaN(value)) throw new Refusal(`${flag}: “${text}” is not a number. Write for example 0.5, or leave it empty.`);
      given[fits ? "fitting" : "reading"][name] = value;
    }
    return given;
  }

  private find(flag: string): Option | undefined {
    return this.all.find((one) => one.flag === flag);
  }

  private show(flag: string): void {
    this.element.open = true;
    this.find(flag)!.control.focus();
  }

  /** What a message prescribes, as buttons: one for each value that it names, else one that leads to the control. */
  cures(message: string, go: () => void): HTMLElement[] {
    const made = new Map<string, HTMLElement>();
    let first = "";
    for (const [, flag, word] of message.matchAll(/(--[a-z-]+)(?: ([\w.%-]*\w))?/g)) {
      const option = this.find(flag);
      if (!option) continue;
      first ||= flag;
      const { control } = option;
      const known = word !== undefined && (control instanceof HTMLSelectElement ? [...control.options].some(({ value }) => value === word) : isWord(flag, word) || !Number.isNaN(Number(word)));
      if (!known || control.value === word) continue;
      const take = (): void => {
        control.value = word;
        control.dispatchEvent(new Event("change"));
        go();
      };
      made.set(`${flag} ${word}`, h("button", { type: "button", onclick: take }, "Identify with ", h("code", {}, `${flag} ${word}`)));
    }
    if (!made.size && first) made.set(first, h("button", { type: "button", onclick: () => this.show(first) }, "Set ", h("code", {}, first)));
    return [...made.values()];
  }
}
