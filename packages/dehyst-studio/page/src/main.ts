/** The shell: tabs, each filled when it is first opened. */

import * as arm from "./arm";
import { h } from "./dom";
import * as identify from "./identify";
import * as studio from "./studio";
import * as teach from "./teach";
import { compile, Core } from "./wasm";

interface Tab {
  name: string;
  title: string;
  mount(root: HTMLElement, core: Core): void;
}

const TABS: Tab[] = [
  { name: "identify", title: "Identify a log", mount: identify.mount },
  { name: "teach", title: "How it works", mount: teach.mount },
  { name: "arm", title: "On an arm", mount: arm.mount },
  ...(studio.served() ? [{ name: "studio", title: "Studio", mount: studio.mount }] : []),
];

function shell(core: Core): void {
  const list = document.getElementById("tabs")!;
  const panels = document.getElementById("panels")!;
  const filled = new Set<string>();

  const open = (name: string, focus = false): void => {
    const chosen = TABS.find((tab) => tab.name === name) ?? TABS[0];
    for (const tab of TABS) {
      const button = document.getElementById(`tab-${tab.name}`)!;
      const selected = tab === chosen;
      button.setAttribute("aria-selected", String(selected));
      button.tabIndex = selected ? 0 : -1;
      document.getElementById(`panel-${tab.name}`)!.hidden = !selected;
      if (selected && focus) button.focus();
    }
    if (!filled.has(chosen.name)) {
      filled.add(chosen.name);
      chosen.mount(document.getElementById(`panel-${chosen.name}`)!, core);
    }
  };
  const turn = (event: KeyboardEvent): void => {
    const at = TABS.findIndex((tab) => `tab-${tab.name}` === (event.target as HTMLElement).id);
    const to = { ArrowRight: at + 1, ArrowLeft: at - 1 + TABS.length, Home: 0, End: TABS.length - 1 }[event.key];
    if (to === undefined) return;
    event.preventDefault();
    const name = TABS[to % TABS.length].name;
    open(name, true);
    history.replaceState(null, "", `#${name}`);
  };
  for (const { name, title } of TABS) {
    const click = (): void => {
      open(name);
      history.replaceState(null, "", `#${name}`);
    };
    list.append(
      h("button", { role: "tab", id: `tab-${name}`, "aria-controls": `panel-${name}`, type: "button", onclick: click, onkeydown: turn }, title),
    );
    panels.append(h("section", { role: "tabpanel", id: `panel-${name}`, "aria-labelledby": `tab-${name}`, hidden: true }));
  }
  // The address of a studio holds its token or a key, which the tab of the studio takes out of it.
  const addressed = (): void => open(/^#(studio|once)=/.test(location.hash) ? "studio" : location.hash.slice(1));
  addressed();
  addEventListener("hashchange", addressed);
}

void compile()
  .then((module) => Core.open(module))
  .then(shell);
