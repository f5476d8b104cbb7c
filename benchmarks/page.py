"""How long a person waits from dropping a log on the page to its verdict, and what 50 logs leave in memory.

python benchmarks/page.py [--quick] [--json] [--page FILE.html] [--rows 10000 100000 1000000] [--runs 5] [--logs 50]
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from itertools import pairwise
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

from startup import machine

from page_samples import big_log

PAGE = Path(__file__).parents[1] / "src" / "dehyst" / "page" / "dehyst.html"
BROWSER = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome", "chrome"))), None)
ROWS, LIMIT = 100_000, 1.5  # s from drop to verdict
REST = 2.0  # s from opening the page to the first drop
MORE = 3  # logs after the first one in the same page
PARTS = ("verdict", "reading", "identification", "painting", "figures", "stalled", "processor")
COUNTED = (1, 5, 10, 20, 50)  # logs after which memory is read

# Runs before the page's script: when something goes to the worker and comes back, and when the verdict is painted.
WATCH = """
(() => {
  const seen = (globalThis.seen = { memory: 0 }), asked = new Map(), post = Worker.prototype.postMessage;
  const mark = (name) => { seen[name] = performance.now(); };
  Worker.prototype.postMessage = function (message, ...rest) {
    if (!this.watched) this.addEventListener("message", ({ data }) => {
      mark(asked.get(data.id) + " answered");
      seen.memory = data.memory ?? seen.memory;
    });
    this.watched = true;
    asked.set(message.id, message.kind);
    return post.call(this, message, ...rest);
  };
  addEventListener("change", (event) => { if (event.target.id === "log") mark("dropped"); }, true);
  new MutationObserver(() => {
    if (!document.getElementById("verdict") || seen.verdict) return;
    seen.verdict = Infinity;
    requestAnimationFrame(() => (document.body.offsetHeight, mark("verdict")));
  }).observe(document, { subtree: true, childList: true });
  let last = performance.now();
  setInterval(() => {
    seen.stalled = Math.max(seen.stalled ?? 0, performance.now() - last);
    last = performance.now();
  }, 10);
})();
"""


def processes(pid: int) -> list[int]:
    """A process and all below it."""
    below = [int(child) for task in Path(f"/proc/{pid}/task").glob("*/children") for child in task.read_text().split()]
    return [pid, *(each for child in below for each in processes(child))]


def renderers() -> list[Path]:
    """Processes of this script's browser that run pages."""
    found = [Path(f"/proc/{pid}") for pid in processes(os.getpid())]
    return [place for place in found if b"--type=renderer" in (place / "cmdline").read_bytes()]


def processor() -> float:
    """Processor time of the pages so far [s]."""
    fields = [(place / "stat").read_text().rpartition(")")[2].split() for place in renderers()]
    return sum(int(each[11]) + int(each[12]) for each in fields) / os.sysconf("SC_CLK_TCK")


def resident() -> float:
    """Memory that is the pages' own [MB]."""
    lines = [line for place in renderers() for line in (place / "status").read_text().splitlines()]
    return sum(int(line.split()[1]) for line in lines if line.startswith("RssAnon")) / 1024


class Opened:
    """A browser of its own with the page."""

    def __init__(self, driver: Any, page: Path, rest: float = REST) -> None:
        options = ["--no-sandbox", "--disable-dev-shm-usage", "--enable-precise-memory-info", "--js-flags=--expose-gc"]
        self.browser = driver.chromium.launch(executable_path=BROWSER, args=options)
        self.page = self.browser.new_page()
        self.page.set_default_timeout(60_000)
        self.page.add_init_script(WATCH)
        self.page.goto(page.resolve().as_uri())
        self.page.wait_for_selector(".drop")
        self.page.wait_for_timeout(1000 * rest)

    def drop(self, log: Path) -> dict[str, float]:
        """Seconds of a log and of its parts."""
        self.page.evaluate("Object.keys(seen).forEach((key) => key === 'memory' || delete seen[key])")
        before, end = processor(), time.monotonic() + 120.0
        self.page.set_input_files("#log", log)
        while not self.page.evaluate("Boolean(document.querySelector('.results').answer?.said)"):
            self.page.wait_for_timeout(50)
            if time.monotonic() > end:
                sys.exit(f"{log.name}: no verdict in 120 s. {self.page.inner_text('[role=alert]')}")
        at = self.page.evaluate("seen")
        steps = [
            at[name] / 1e3 for name in ("dropped", "read answered", "identify answered", "verdict", "more answered")
        ]
        values = [steps[3] - steps[0], *(b - a for a, b in pairwise(steps)), at["stalled"] / 1e3]
        return dict(zip(PARTS, [*values, processor() - before], strict=True))

    def memory(self) -> dict[str, float]:
        """MB: JavaScript of the page without its garbage, WebAssembly of the worker, all of the pages' processes."""
        heap, wasm = self.page.evaluate("(gc(), [performance.memory.usedJSHeapSize, seen.memory])")
        return {"page": heap / 1e6, "wasm": wasm / 1e6, "processes": resident()}


def command(log: Path) -> float:
    """Wall time of the same fit by `dehyst identify`, start and imports included [s]."""
    arguments = ["identify", str(log), "--family", "pi", "--input", "pressure_bar", "--output", "angle_deg"]
    begin = time.perf_counter()
    subprocess.run([sys.executable, "-m", "dehyst", *arguments], check=True, capture_output=True)
    return time.perf_counter() - begin


def timed(driver: Any, page: Path, log: Path, runs: int) -> dict[str, Any]:
    """Medians of the first logs of fresh browsers, of the later ones, and of the command, in turns."""
    first, later, python = list[dict[str, float]](), list[dict[str, float]](), list[float]()
    for _ in range(runs):
        opened = Opened(driver, page)
        first.append(opened.drop(log))
        later += [opened.drop(log) for _ in range(MORE)]
        opened.browser.close()
        python.append(command(log))

    def middle(found: list[dict[str, float]]) -> dict[str, float]:
        return {part: statistics.median(each[part] for each in found) for part in PARTS}

    return {"first": middle(first), "later": middle(later), "command": statistics.median(python)}


def remembered(driver: Any, page: Path, log: Path, logs: int) -> dict[int, dict[str, float]]:
    """Memory after so many logs in a row."""
    opened, found = Opened(driver, page), dict[int, dict[str, float]]()
    for k in range(1, logs + 1):
        opened.drop(log)
        if k in COUNTED or k == logs:
            found[k] = opened.memory()
    opened.browser.close()
    return found


def main() -> None:
    """Measure, print, and fail if the limit is missed."""
    parser = argparse.ArgumentParser(
        description="Time from dropping a log on the page to its verdict; memory after many."
    )
    parser.add_argument("--page", type=Path, default=PAGE, help="the page, if not the shipped one")
    parser.add_argument("--rows", type=int, nargs="*", default=[10_000, ROWS, 1_000_000], help="rows of the logs")
    parser.add_argument("--runs", type=int, default=5, help="fresh browsers per length")
    parser.add_argument("--logs", type=int, default=50, help="logs in a row, for the memory; 0: none")
    parser.add_argument("--quick", action="store_true", help="10 000 and 100 000 rows in one browser, 5 logs in a row")
    parser.add_argument("--json", action="store_true", help="print JSON and nothing else")
    options = parser.parse_args()
    if options.quick:
        options.rows, options.runs, options.logs = options.rows[:2], 1, 5
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        sys.exit("Playwright is not installed: pip install playwright drives the page")
    if BROWSER is None:
        sys.exit("no Chromium or Chrome found: apt-get install chromium to open the page in it")
    with tempfile.TemporaryDirectory() as place, sync_playwright() as driver:
        times, logs = dict[int, dict[str, Any]](), {rows: Path(place) / f"{rows}.csv" for rows in {*options.rows, ROWS}}
        for rows, log in logs.items():
            log.write_bytes(big_log(rows))
        for rows in options.rows:
            times[rows] = timed(driver, options.page, logs[rows], options.runs)
        memory = remembered(driver, options.page, logs[ROWS], options.logs)
    if options.json:
        print(json.dumps({"machine": machine(("dehyst",)), "runs": options.runs, "times": times, "memory": memory}))
    else:
        print(", ".join(f"{key} {value}" for key, value in machine(("dehyst",)).items()))
        print(f"median of {options.runs} browsers, s\n")
        print(
            f"{'rows':>8} {'log':6}" + "".join(f"{part:>15}" for part in PARTS) + f"{'command':>9} {'page/command':>13}"
        )
        for rows, found in times.items():
            for name in ("first", "later"):
                values = "".join(f"{found[name][part]:15.2f}" for part in PARTS)
                ratio = found[name]["verdict"] / found["command"]
                print(f"{rows:8} {name:6}{values}{found['command']:9.2f} {ratio:13.2f}")
        for k, each in memory.items():
            print(f"after {k} logs of {ROWS} rows: " + ", ".join(f"{name} {mb:.0f} MB" for name, mb in each.items()))
    if ROWS in times and times[ROWS]["first"]["verdict"] > LIMIT:
        sys.exit(f"the first log of {ROWS} rows takes longer than {LIMIT} s to its verdict")


if __name__ == "__main__":
    main()
