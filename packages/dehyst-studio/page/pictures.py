"""Pictures of the page for docs/how-to/try-in-a-browser.md: python page/pictures.py [CHROMIUM]; needs Playwright."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

from playwright.sync_api import Page, sync_playwright

ROOT = Path(__file__).parents[3]
PAGE = ROOT / "packages" / "dehyst-studio" / "src" / "dehyst_studio" / "html" / "dehyst.html"
IMAGES = ROOT / "docs" / "images"


def opened(page: Page) -> Page:
    """Identify the example."""
    page.goto(PAGE.as_uri())
    page.click("text=Try an example")
    page.wait_for_selector("#result", timeout=240_000)
    page.wait_for_timeout(1500)
    return page


def main(browser: str) -> None:
    """Draw them all."""
    with sync_playwright() as driver:
        chromium = driver.chromium.launch(executable_path=browser, args=["--no-sandbox"])
        page = opened(chromium.new_page(viewport={"width": 1100, "height": 900}))
        page.evaluate("document.querySelector('#panel-identify .card').scrollIntoView()")
        page.screenshot(path=IMAGES / "browser.png")
        page.click("button:text-is('Play')")
        page.wait_for_timeout(4000)
        page.locator(".card:has-text('The compensator at work')").screenshot(
            path=IMAGES / "browser-inverse.png"
        )
        phone = chromium.new_context(
            viewport={"width": 390, "height": 844}, device_scale_factor=1.5, color_scheme="dark"
        ).new_page()
        opened(phone)
        phone.evaluate("document.querySelector('#result').scrollIntoView()")
        phone.screenshot(path=IMAGES / "browser-phone.png")
        chromium.close()


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else shutil.which("chromium") or "chromium")
