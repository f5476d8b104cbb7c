import { h } from "./dom";
import type { Core } from "./wasm";

/** Fill the tab "Identify". */
export function mount(root: HTMLElement, _core: Core): void {
  root.append(h("p", {}, "Drop a log here."));
}
