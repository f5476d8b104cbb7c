"""docs/images/studio.png: the studio with the example log, as a browser shows it: `python docs/generate/studio.py`.

Needs playwright, Chromium and the built page; `docs/build.py` leaves the picture as it is.
"""

from __future__ import annotations

import shutil
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

OUT = Path(__file__).resolve().parents[1] / "images" / "studio.png"
WIDTH, HEIGHT = 1100, 1460


def main() -> None:
    """Start the studio with a log, choose a part of it, identify, export, and take the picture."""
    from playwright.sync_api import sync_playwright

    from dehyst.io import example_csv

    browser = next(
        filter(
            None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome", "chrome"))
        ),
        None,
    )
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as driver:
        log = Path(folder) / "elbow.csv"
        log.write_text(example_csv(0), encoding="utf-8")
        words = [sys.executable, "-m", "dehyst", "studio", log.name, "--no-browser"]
        with subprocess.Popen(words, stdout=subprocess.PIPE, text=True, cwd=folder) as studio:
            assert studio.stdout is not None
            address = studio.stdout.readline().split()[-1]
            page = driver.chromium.launch(executable_path=browser, args=["--no-sandbox"]).new_page(
                viewport={"width": WIDTH, "height": HEIGHT}, reduced_motion="reduce"
            )
            page.set_default_timeout(120_000)
            page.goto(address)
            page.locator(".signals .u-over").first.wait_for()
            page.get_by_label("From [s]").fill("14")
            page.get_by_label("To [s]").fill("130")
            page.get_by_label("To [s]").press("Tab")
            page.get_by_role("button", name="Identify", exact=True).click()
            page.locator(".verdict").wait_for()
            page.mouse.move(0, 0)
            page.screenshot(path=OUT)
            studio.send_signal(signal.SIGINT)
    print(f"{OUT}: {OUT.stat().st_size / 1e3:.0f} kB")


if __name__ == "__main__":
    main()
