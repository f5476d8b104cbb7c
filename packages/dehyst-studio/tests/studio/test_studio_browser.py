"""The studio in a real browser: from a brushed log to an exported folder whose `make check` passes; stop, reload."""

from __future__ import annotations

import contextlib
import math
import os
import re
import shutil
import signal
import subprocess
import sys
import zipfile

import numpy as np
import pytest

import dehyst
from dehyst.io import example_csv
from places import STUDIO
from test_report_browser import BROWSER

playwright = pytest.importorskip(
    "playwright.sync_api", reason="playwright drives the browser: pip install playwright"
)
pytest.importorskip(
    "starlette", reason="the studio needs starlette and uvicorn: pip install dehyst-studio"
)

from dehyst_studio.studio._server import PAGE  # noqa: E402 - needs the extra

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(
        BROWSER is None, reason="no Chromium or Chrome found: apt-get install chromium"
    ),
    pytest.mark.skipif(not PAGE.exists(), reason="the page is not built: make page"),
    pytest.mark.skipif(os.name != "posix", reason="ended by Ctrl-C here"),
]
WAIT = 120_000  # ms; the machine may be busy


@contextlib.contextmanager
def started(folder, *words):
    """Yield the address of a studio and its process; Ctrl-C ends it with one line, and nothing is left."""
    environment = os.environ | {"TMPDIR": str(folder)}
    with subprocess.Popen(
        [sys.executable, "-m", "dehyst", "studio", *words, "--no-browser"],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment,
    ) as process:  # fmt: skip
        try:
            address = process.stdout.readline().split()[-1]
            process.stdout.readline()
            yield address, process
        finally:
            if process.poll() is None:
                process.send_signal(signal.SIGINT)
            ended = process.communicate(timeout=60)
    assert (process.returncode, ended) == (
        0,
        ("", "the studio has ended; its temporary files are removed\n"),
    )
    assert list(folder.glob("dehyst-studio-*")) == []


@pytest.fixture(scope="module")
def chromium():
    with playwright.sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=BROWSER, args=["--no-sandbox"])
        yield browser
        browser.close()


@pytest.fixture
def page(chromium):
    """A page that tells what it asked for, and must print no error."""
    page = chromium.new_page()
    page.asked, page.may_fail, said = [], "no answer of the studio", []
    page.set_default_timeout(WAIT)
    page.on("request", lambda request: page.asked.append(request.url))
    page.on("pageerror", lambda fault: said.append(str(fault)))
    page.on(
        "console", lambda message: said.append(message.text) if message.type == "error" else None
    )
    yield page
    assert [words for words in said if page.may_fail not in words] == []
    page.close()


@pytest.fixture
def log(tmp_path):
    path = tmp_path / "elbow log.csv"
    path.write_text(example_csv(0), encoding="utf-8")
    return path


def brush(page, begin, end):
    """Drag over the first figure from one share of its width to another."""
    box = page.locator(".signals .u-over").first.bounding_box()
    page.mouse.move(box["x"] + begin * box["width"], box["y"] + 30)
    page.mouse.down()
    page.mouse.move(box["x"] + end * box["width"], box["y"] + 40, steps=8)
    page.mouse.up()


def windows(page):
    """Ends of the windows as they stand in the fields."""
    return [
        float(v) if v else None
        for v in page.locator(".windows input").evaluate_all("all => all.map(e => e.value)")
    ]


def test_from_a_brush_to_a_zip_whose_check_passes(page, log, tmp_path):
    with started(tmp_path, str(log)) as (address, _):
        page.goto(address)
        brush(page, 0.1, 0.8)
        start, stop = (
            float(page.get_by_label(name).input_value()) for name in ("From [s]", "To [s]")
        )
        assert 12.0 < start < 17.0 and 112.0 < stop < 118.0  # of 144 s
        page.get_by_label("Family").select_option("pi")
        page.get_by_role("button", name="Identify", exact=True).click()
        page.locator(".verdict").wait_for()
        assert f"--from={start} --to={stop}" in page.locator("pre").inner_text()
        with page.context.expect_page() as opened:
            page.get_by_role("link", name="Open the report").click()
        opened.value.wait_for_load_state()
        assert "elbow log.csv" in opened.value.title()
        page.get_by_role("button", name="Export", exact=True).click()
        assert "rms [deg]" in page.get_by_role("region", name="Scores").inner_text()
        page.get_by_role("button", name="Verify it here").click()
        page.get_by_text("downloaded before is older").wait_for()
        with page.expect_download() as got:
            page.get_by_role("button", name="Download the zip").click()
        with zipfile.ZipFile(got.value.path()) as packed:
            packed.extractall(tmp_path / "out")
        assert {
            re.match(r"http://[^/]+/", each)[0] for each in page.asked if each.startswith("http")
        } == {address.partition("#")[0]}
        assert not any(
            "#" in each or address.partition("=")[2] in each for each in page.asked
        )  # the token is no path
    if shutil.which("make") and shutil.which("cc"):
        done = subprocess.run(
            ["make", "check"], cwd=tmp_path / "out" / "compensator", capture_output=True, text=True
        )
        assert done.returncode == 0 and "all checks passed" in done.stdout, (
            done.stdout + done.stderr
        )


def test_several_windows_are_brushed_or_typed_and_fitted_together(page, log, tmp_path):
    with started(tmp_path, str(log)) as (address, _):
        page.goto(address)
        brush(page, 0.05, 0.3)
        page.keyboard.down("Shift")
        brush(page, 0.5, 0.9)
        page.keyboard.up("Shift")
        first, second = windows(page)[:2], windows(page)[2:]
        assert first[1] - first[0] == pytest.approx(36, abs=2) and second[1] - second[
            0
        ] == pytest.approx(57.6, abs=2)
        brush(page, 0.2, 0.6)  # without Shift: instead of them
        assert len(windows(page)) == 2
        page.get_by_role("button", name="Whole log").press("Enter")
        assert windows(page) == [None, None]
        for keys in (
            "20",
            "Tab",
            "60",
            "Tab",
            "Enter",
            "90",
            "Tab",
            "Tab",
        ):  # remove, add, from, to, remove
            if keys == "20":
                page.get_by_label("From [s]").focus()
            page.keyboard.press(keys) if keys.isalpha() else page.keyboard.type(keys)
        assert windows(page) == [20, 60, 90, None]
        page.get_by_label("Family").select_option("pi")
        page.get_by_role("button", name="Identify", exact=True).click()
        page.locator(".verdict").wait_for()
        assert "--from=20 --from=90 --to=60 --to=inf" in page.locator("pre").inner_text()
        page.get_by_role("button", name="Remove window 1").click()
        assert windows(page) == [90, None]


def test_what_runs_can_be_stopped_and_a_page_that_is_reloaded_goes_on(page, log, tmp_path):
    with started(tmp_path) as (address, _):
        page.goto(address)
        page.locator("#panel-studio input[type=file]").set_input_files(log)
        page.locator(".signals .u-over").first.wait_for()
        page.get_by_role("button", name="Compare all families").click()
        page.get_by_role("button", name="Stop").click()
        assert "Stopped" in page.get_by_role("alert").inner_text()
        page.reload()
        page.locator(".signals .u-over").first.wait_for()
        assert page.locator("#panel-studio select").first.input_value() != ""
        page.may_fail = "403"
        page.evaluate("sessionStorage.clear()")
        page.goto(address.partition("#")[0] + "#studio")
        page.reload()
        assert "token is missing" in page.get_by_role("alert").inner_text()


def test_ctrl_c_ends_what_runs_too(page, log, tmp_path):
    page.may_fail = "net::ERR"
    with started(tmp_path, str(log)) as (address, _):
        page.goto(address)
        page.locator(".signals .u-over").first.wait_for()
        page.get_by_role("button", name="Compare all families").click()
        page.get_by_role("button", name="Stop").wait_for()
    page.get_by_text("The studio has ended").wait_for()


def test_an_error_is_shown_in_the_words_of_dehyst(page, tmp_path):
    (tmp_path / "odd.bin").write_bytes(bytes(range(256)) * 100)
    with started(tmp_path) as (address, _):
        page.goto(address)
        page.locator("#panel-studio input[type=file]").set_input_files(tmp_path / "odd.bin")
        said = page.get_by_role("alert").first.inner_text()
        assert "odd.bin" in said and "Traceback" not in said and str(tmp_path) not in said
        assert not re.match(r"\w*Error", said)


def test_a_log_that_is_refused_is_marked_and_logs_of_one_name_are_told_apart(page, log, tmp_path):
    (tmp_path / "odd.bin").write_bytes(bytes(range(256)) * 100)
    with started(tmp_path, str(log)) as (address, _):
        page.goto(address)
        for name in (tmp_path / "odd.bin", log):
            page.locator("#panel-studio input[type=file]").set_input_files(name)
            page.locator(".warning[role=alert], .signals .u-over").first.wait_for()
            page.wait_for_timeout(300)
        for again in (page.reload, lambda: None):
            page.locator(".signals .u-over").first.wait_for()
            listed = page.locator("#panel-studio select").first.locator("option").all_inner_texts()
            assert listed == ["elbow log.csv (1)", "odd.bin (refused)", "elbow log.csv (2)"]
            again()


def test_a_page_of_another_server_of_this_machine_gets_nothing(page, log, tmp_path, chromium):
    """Another port of the same machine, with a browser that holds the studio open: no answer can be read."""
    with started(tmp_path, str(log)) as (address, _):
        page.goto(address)
        other = chromium.new_page()
        other.route(
            "http://127.0.0.1:1/**",
            lambda route: route.fulfill(body="<p>other", content_type="text/html"),
        )
        other.goto("http://127.0.0.1:1/")
        here = address.partition("#")[0]
        ask = "(url) => fetch(url, {method: 'POST', body: '{}'}).then((answer) => answer.status, () => 'nothing')"
        assert other.evaluate(ask, f"{here}api/run/identify") == "nothing"
        assert (
            other.evaluate(
                "(url) => fetch(url).then((answer) => answer.status, () => 'nothing')", here
            )
            == "nothing"
        )
        other.close()


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_nothing_serious_in_the_studio(chromium, log, tmp_path, scheme):
    axe = STUDIO / "page" / "node_modules" / "axe-core" / "axe.min.js"
    if not axe.is_file():
        pytest.skip("axe-core is not installed: npm ci in page/, or make page")
    with started(tmp_path, str(log)) as (address, _):
        page = chromium.new_page(color_scheme=scheme, viewport={"width": 375, "height": 800})
        page.set_default_timeout(WAIT)
        page.goto(address)
        page.locator(".signals .u-over").first.wait_for()
        page.get_by_role("button", name="Add a window").click()
        page.get_by_label("Family").select_option("pi")
        page.get_by_role("button", name="Identify", exact=True).click()
        page.locator(".verdict").wait_for()
        page.evaluate(axe.read_text(encoding="utf-8"))
        found = page.evaluate("axe.run({resultTypes: ['violations']})")["violations"]
        bad = [
            (v["id"], v["nodes"][0]["html"][:150])
            for v in found
            if v["impact"] in ("serious", "critical")
        ]
        assert bad == []
        assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
        page.close()


def test_the_studio_has_the_options_too_and_does_what_a_warning_prescribes(page, tmp_path):
    t = np.linspace(0.0, 20.0, 400)
    x = 1.0 - np.cos(2.0 * np.pi * t / 20.0)
    y = dehyst.PrandtlIshlinskii([0.0, 0.2, 0.5], [1.0, 0.4, 0.3]).simulate(x)
    rows = "\n".join(
        f"{b:.5f},{c:.5f},{a:.4f},{3 * a * a:.4f}" for a, b, c in zip(t, x, y, strict=True)
    )
    (tmp_path / "loop.csv").write_text(f"pressure_bar,angle_deg,time_s,t_s\n{rows}\n")
    with started(tmp_path, str(tmp_path / "loop.csv")) as (address, _):
        page.goto(address)
        page.get_by_role(
            "button", name="Identify with --time time_s"
        ).last.click()  # two clocks contradict each other
        page.locator(".signals .u-over").first.wait_for()
        page.get_by_label("Family").select_option("pi")
        page.get_by_role("button", name="Identify", exact=True).click()
        page.locator(".verdict.no").wait_for()
        page.get_by_role("button", name="Identify with --train-fraction 1").last.click()
        page.locator(".verdict.care, .verdict.good").wait_for()
        assert "--time=time_s --train-fraction=1" in re.sub(
            r" --family=\S+ --for=\S+", "", page.locator("pre").inner_text()
        )
        page.get_by_text("Options", exact=True).click()
        page.locator("#studio-eps").fill("a lot")
        page.get_by_role("button", name="Identify", exact=True).click()
        assert "“a lot” is not a number" in page.get_by_role("alert").inner_text()


def test_the_studio_reads_the_sheet_of_a_workbook_that_is_named(page, tmp_path):
    openpyxl = pytest.importorskip("openpyxl")
    pytest.importorskip("python_calamine")
    book = openpyxl.Workbook()
    for name, rows, gain in (("Long", 400, 1.0), ("Second", 300, 2.0)):
        sheet = book.create_sheet(name)
        sheet.append(["time_s", f"pressure_{name}_bar", "angle_deg"])
        for k in range(rows):
            swing = math.sin(k / 20.0)
            sheet.append([0.01 * k, 1.0 + swing, gain * swing + 0.1 * math.cos(k / 20.0)])
    book.save(tmp_path / "book.xlsx")
    with started(tmp_path, str(tmp_path / "book.xlsx")) as (address, _):
        page.goto(address)
        page.get_by_text("400 rows").wait_for()
        page.locator("#studio-sheet").fill("Third")
        page.locator("#studio-sheet").blur()
        assert "no sheet 'Third'" in page.get_by_role("alert").inner_text()
        page.locator("#studio-sheet").fill("second")
        page.locator("#studio-sheet").blur()
        page.get_by_text("300 rows").wait_for()
        page.locator(".signals .u-over").first.wait_for()
        page.get_by_label("Family").select_option("pi")
        page.get_by_role("button", name="Identify", exact=True).click()
        page.locator("pre").wait_for()
        line = page.locator("pre").inner_text()
        assert "--sheet=second" in line and "pressure_Second" in line
