import { h } from "./dom";
import type { Core } from "./wasm";

/** Fill the tab "The arm"; called when it is opened for the first time. */
export function mount(root: HTMLElement, _core: Core): void {
  root.append(h("p", {}, "Soon."));
}
