"""How long a person waits from dropping a log on the page to its result, and what many logs leave in memory.

python benchmarks/page.py [--quick] [--json] [--page FILE.html] [--rows 10000 100000 250000] [--runs 5] [--logs 50]
"""

from __future__ import annotations

import argparse
import json
import shutil
import statistics
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

from startup import machine

from page_samples import big_log

PAGE = (
    Path(__file__).parents[1]
    / "packages"
    / "dehyst-studio"
    / "src"
    / "dehyst_studio"
    / "html"
    / "dehyst.html"
)
BROWSER = next(
    filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome", "chrome"))),
    None,
)
ROWS, LIMIT = 100_000, 2.0  # s from drop to result
PATIENCE = 120.0  # s
COUNTED = (1, 5, 10, 20, 50)  # logs after which memory is read

# Runs before the page's script: when a log is dropped, and when its result and its figures stand.
WATCH = """
(() => {
  const seen = (globalThis.seen = {});
  addEventListener("change", (event) => { if (event.target.id === "log") seen.dropped = performance.now(); }, true);
  new MutationObserver(() => {
    if (document.getElementById("result")) seen.result ??= performance.now();
  }).observe(document, { subtree: true, childList: true, attributes: true });
})();
"""


class Opened:
    """A browser of its own with the page."""

    def __init__(self, driver: Any, page: Path) -> None:
        options = [
            "--no-sandbox",
            "--disable-dev-shm-usage",
            "--enable-precise-memory-info",
            "--js-flags=--expose-gc",
        ]
        self.browser = driver.chromium.launch(executable_path=BROWSER, args=options)
        self.page = self.browser.new_page()
        self.page.add_init_script(WATCH)
        self.page.goto(page.resolve().as_uri())
        self.page.wait_for_selector(".drop")

    def drop(self, log: Path) -> float:
        """Seconds from the drop of a log to its result."""
        self.page.evaluate("Object.keys(seen).forEach((key) => delete seen[key])")
        end = time.monotonic() + PATIENCE
        self.page.set_input_files("#log", log)
        while not self.page.evaluate(
            "Boolean(document.querySelector('.results').answer && seen.result)"
        ):
            self.page.wait_for_timeout(50)
            if time.monotonic() > end:
                sys.exit(
                    f"{log.name}: no result in {PATIENCE:.0f} s. {self.page.inner_text('[role=alert]')}"
                )
        return float(self.page.evaluate("seen.result - seen.dropped")) / 1e3

    def memory(self) -> float:
        """MB of JavaScript and WebAssembly without garbage."""
        return float(self.page.evaluate("(gc(), performance.memory.usedJSHeapSize)")) / 1e6


def timed(driver: Any, page: Path, log: Path, runs: int) -> float:
    """Median over fresh browsers."""
    drops = []
    for _ in range(runs):
        opened = Opened(driver, page)
        drops.append(opened.drop(log))
        opened.browser.close()
    return statistics.median(drops)


def remembered(driver: Any, page: Path, log: Path, logs: int) -> dict[int, float]:
    """Memory after so many logs in a row."""
    opened = Opened(driver, page)
    memory: dict[int, float] = {}
    for k in range(1, logs + 1):
        opened.drop(log)
        if k in COUNTED or k == logs:
            memory[k] = opened.memory()
    opened.browser.close()
    return memory


def main() -> None:
    """Measure, print, and fail if the limit is missed."""
    parser = argparse.ArgumentParser(
        description="Time from dropping a log on the page to its result; memory."
    )
    parser.add_argument("--page", type=Path, default=PAGE, help="the page, if not the shipped one")
    parser.add_argument(
        "--rows", type=int, nargs="*", default=[10_000, ROWS, 250_000], help="rows of the logs"
    )
    parser.add_argument("--runs", type=int, default=5, help="fresh browsers per length")
    parser.add_argument(
        "--logs", type=int, default=50, help="logs in a row, for the memory; 0: none"
    )
    parser.add_argument(
        "--quick",
        action="store_true",
        help="10 000 and 100 000 rows in one browser, 5 logs in a row",
    )
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
        logs = {rows: Path(place) / f"{rows}.csv" for rows in {*options.rows, ROWS}}
        for rows, log in logs.items():
            log.write_bytes(big_log(rows))
        times = {
            rows: timed(driver, options.page, logs[rows], options.runs) for rows in options.rows
        }
        memory = remembered(driver, options.page, logs[ROWS], options.logs) if options.logs else {}
    if options.json:
        print(
            json.dumps(
                {
                    "machine": machine(("dehyst",)),
                    "runs": options.runs,
                    "times": times,
                    "memory": memory,
                }
            )
        )
    else:
        print(", ".join(f"{key} {value}" for key, value in machine(("dehyst",)).items()))
        print(f"median of {options.runs} browsers\n{'rows':>8} {'result':>10}")
        for rows, seconds in times.items():
            print(f"{rows:8} {seconds:8.2f} s")
        for k, megabytes in memory.items():
            print(f"after {k} logs of {ROWS} rows: {megabytes:.0f} MB")
    if ROWS in times and times[ROWS] > LIMIT:
        sys.exit(f"the log of {ROWS} rows takes longer than {LIMIT} s to its result")


if __name__ == "__main__":
    main()
