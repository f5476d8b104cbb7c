import { h } from "./dom";
import type { Core } from "./wasm";

/** Fill the tab "Studio", which only a page served by `dehyst studio` has. */
export function mount(root: HTMLElement, _core: Core): void {
  root.append(h("p", {}, "Soon."));
}

/** Whether this page is served by `dehyst studio`. */
export function served(): boolean {
  return document.querySelector('meta[name="dehyst-studio"]') !== null;
}
