"""Claims about pages as a real browser shows them: desk, phone, dark, print, less motion; without a network."""

from __future__ import annotations

import base64
import hashlib
import json
import re
import shutil
import signal
import subprocess
from dataclasses import dataclass, replace
from html import unescape
from pathlib import Path

import numpy as np
import pytest
from matplotlib.image import imread

from dehyst.report import write_report
from dehyst_robot.report import write_reproduction_report
from report_samples import fit_by_hand, maxwell_slip_log
from reproduction_samples import sample_reproduction

BROWSER = next(
    filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome", "chrome"))),
    None,
)
FLAGS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-sync",
    "--disable-background-networking", "--disable-component-update", "--disable-dev-shm-usage", "--hide-scrollbars",
    "--enable-logging=stderr", "--host-resolver-rules=MAP * ~NOTFOUND",
)  # fmt: skip
DESK, PHONE = (1200, 1600), (390, 844)
NO_MOTION = "--force-prefers-reduced-motion"

# What the measuring copy of the page writes into its own body.
PROBE = """<script>
window.addEventListener("load", () => {
  const width = document.documentElement.clientWidth;
  const outside = [...document.querySelectorAll("body *")].filter(e => {
    const box = e.getBoundingClientRect();
    return box.width && (box.right > width + 1 || box.left < -1) && !e.closest(".scroll, pre, svg");
  }).map(e => e.tagName + "." + e.className).slice(0, 5);
  const letters = [...document.querySelectorAll("svg text")].filter(e => e.textContent.trim());
  const spill = letters.filter(e => {
    const box = e.getBoundingClientRect(), room = e.closest("svg").getBoundingClientRect();
    return box.right > room.right + 2 || box.left < room.left - 2 || box.top < room.top - 2;
  }).map(e => e.textContent).slice(0, 5);
  const heights = letters.map(e => parseFloat(getComputedStyle(e).fontSize) * e.getScreenCTM().a);
  const result = {
    client: width, scroll: document.documentElement.scrollWidth, outside, spill,
    plots: document.querySelectorAll("svg.plot").length, smallest: Math.min(...heights),
    verdict: document.querySelector("#verdict .lead").textContent,
    flat: [...document.querySelectorAll("svg.plot")].filter(e => e.getBoundingClientRect().height < 150).length,
    ink: getComputedStyle(document.body).color,
    pixels: window.innerWidth,
  };
  const out = document.createElement("pre");
  out.id = "probe";
  out.textContent = JSON.stringify(result);
  document.body.append(out);
});
</script></body>"""

pytestmark = pytest.mark.skipif(
    BROWSER is None,
    reason="no Chromium or Chrome found: install one (apt-get install chromium) to open the report in it",
)


@dataclass(frozen=True)
class Seen:
    """What the browser printed."""

    returncode: int
    stdout: str
    stderr: str


def browse(
    page: Path, profile: Path, *arguments: str, size: tuple[int, int] = DESK
) -> subprocess.CompletedProcess[str]:
    command = [
        BROWSER,
        *FLAGS,
        f"--user-data-dir={profile}",
        f"--window-size={size[0]},{size[1]}",
        *arguments,
    ]
    with subprocess.Popen(
        [*command, page.as_uri()],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    ) as process:
        try:
            out, err = process.communicate(timeout=600)
        except subprocess.TimeoutExpired:
            process.send_signal(signal.SIGKILL)
            raise
    return Seen(process.returncode, out, err)


def measured(page: Path, tmp_path: Path, *arguments: str, size: tuple[int, int]) -> dict:
    """Load a copy of the page that may run one script, inside a frame of exactly the given width.

    A window of a headless browser is never narrower than about 500 pixels; a frame is.
    """
    text = page.read_text(encoding="utf-8")
    text = re.sub(r'<meta http-equiv="Content-Security-Policy"[^>]*>', "", text)
    copy = tmp_path / "copy.html"
    copy.write_text(text.replace("</body>", PROBE), encoding="utf-8")
    frame = tmp_path / "frame.html"
    frame.write_text(
        f'<!DOCTYPE html><body style="margin:0"><iframe src="copy.html" width="{size[0]}" height="{size[1]}" '
        f'style="border:0"></iframe><script>addEventListener("load", () => setTimeout(() => {{'
        f'document.body.append(Object.assign(document.createElement("pre"), {{id: "found", textContent: '
        f'document.querySelector("iframe").contentDocument.querySelector("#probe").textContent}}))}}, 100))</script>',
        encoding="utf-8",
    )
    dom = browse(
        frame, tmp_path / "profile", "--allow-file-access-from-files", "--virtual-time-budget=4000", "--dump-dom",
        *arguments, size=(max(size[0], 600), size[1]),
    )  # fmt: skip
    found = re.search(r'<pre id="found">(.*?)</pre>', dom.stdout, re.S)
    assert found, dom.stderr[-2000:]
    return json.loads(unescape(found.group(1)))


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    return write_report(fit_by_hand(), tmp_path_factory.mktemp("browser") / "report.html")


@pytest.fixture(scope="module")
def experiment(tmp_path_factory):
    result = sample_reproduction(("maxwell-slip", "none"))
    return write_reproduction_report(result, tmp_path_factory.mktemp("experiment") / "report.html")


@pytest.fixture(scope="module")
def all_open(experiment):
    """The page of the experiment with every plant and table unfolded."""
    copy, text = experiment.with_name("open.html"), experiment.read_text(encoding="utf-8")
    copy.write_text(text.replace("<details class", "<details open class"), encoding="utf-8")
    return copy


@pytest.mark.slow
def test_the_browser_reads_whole_pages_without_complaint(page, experiment, tmp_path):
    for each in (page, experiment):
        seen = browse(each, tmp_path / "profile", "--dump-dom")
        assert seen.returncode == 0 and "</html>" in seen.stdout
        assert seen.stdout.count("<svg ") >= 13
        assert "CONSOLE" not in seen.stderr, seen.stderr


@pytest.mark.slow
@pytest.mark.parametrize("size", [DESK, PHONE], ids=["desk", "phone"])
def test_nothing_runs_over_the_edge_and_letters_can_be_read(page, all_open, tmp_path, size):
    for each, plots in ((page, 13), (all_open, 40)):
        found = measured(each, tmp_path, size=size)
        assert found["pixels"] == found["client"] == size[0]
        assert found["scroll"] <= found["client"]
        assert found["outside"] == [] and found["spill"] == []
        assert found["plots"] >= plots and (found["flat"] == 0 or each is all_open)
        assert found["smallest"] >= 9.0  # CSS pixels of the smallest letters in a figure
        assert found["verdict"] in unescape(each.read_text(encoding="utf-8"))


@pytest.mark.slow
def test_long_names_do_not_run_over_the_edge_of_a_phone(tmp_path):
    name = "a_very_long_column_name_without_any_space_" * 6
    log = maxwell_slip_log(
        300, name=name, input_name=name, output_name="圧力" * 40, input_unit="kgf/cm2" * 9
    )
    log = replace(log, provenance={"file": name, "sha256": "f" * 64})
    found = measured(
        write_report(fit_by_hand(log), tmp_path / "r.html", model_file=name), tmp_path, size=PHONE
    )
    assert found["scroll"] <= found["client"] and found["outside"] == []


@pytest.mark.slow
def test_a_dark_screen_gets_light_letters(page, tmp_path):
    dark = measured(page, tmp_path, "--blink-settings=preferredColorScheme=0", size=DESK)["ink"]
    light = measured(page, tmp_path, "--blink-settings=preferredColorScheme=1", size=DESK)["ink"]
    brightness = [sum(map(int, re.findall(r"\d+", colour)[:3])) for colour in (dark, light)]
    assert brightness[0] > 600 > 200 > brightness[1]


@pytest.mark.slow
@pytest.mark.parametrize("size", [DESK, (500, 1400)], ids=["desk", "narrow"])
def test_a_screenshot_shows_letters_and_curves(page, tmp_path, size):
    shot = tmp_path / "shot.png"
    browse(page, tmp_path / "profile", f"--screenshot={shot}", size=size)
    pixels = imread(shot)[..., :3]
    assert pixels.shape[:2] == (size[1], size[0])
    dark = float(np.mean(pixels.sum(axis=2) < 1.5))
    assert 0.005 < dark < 0.5  # neither blank nor black
    rows = pixels.reshape(pixels.shape[0], -1)
    written = np.ptp(rows, axis=1) > 0.3
    assert written.mean() > 0.3  # letters all the way down, not one error line
    if size == DESK:
        blue = (pixels[..., 2] - pixels[..., 0] > 0.3).sum()
        assert blue > 500


@pytest.mark.slow
def test_pages_print_what_is_open(page, experiment, all_open, tmp_path):
    sheets = []
    for each in (page, experiment, all_open):
        pdf = tmp_path / "report.pdf"
        browse(each, tmp_path / "profile", "--no-pdf-header-footer", f"--print-to-pdf={pdf}")
        data = pdf.read_bytes()
        assert data.startswith(b"%PDF-") and b"%%EOF" in data[-32:]
        sheets.append(len(re.findall(rb"/Type\s*/Page\b", data)))
    assert 3 <= sheets[0] <= 15
    assert 6 <= sheets[1] <= 20 and sheets[2] >= sheets[1] + 4


@pytest.mark.slow
def test_no_name_of_a_log_runs_as_a_script(tmp_path):
    name = '</script><script>document.title="x"</script>'
    log = maxwell_slip_log(
        300, name=name, input_name=name, output_name=f"<img src=x onerror={name}>"
    )
    fit = replace(fit_by_hand(log), verdict=f"</p></div></body>{name}")
    page = write_report(fit, tmp_path / "r.html")
    for text in (page.read_text(), page.read_text().replace("Content-Security-Policy", "x")):
        page.write_text(text)
        seen = browse(page, tmp_path / "profile", "--dump-dom")
        assert (
            seen.stdout.count("<script") == 1
            and 'tabindex="0"' in seen.stdout
            and "<img" not in seen.stdout
        )
        assert "hysteresis report</title>" in seen.stdout
        assert "CONSOLE" not in seen.stderr


# Plays a reader with a mouse and a keyboard, and prints what the page tells.
READER = """
const svg = document.querySelectorAll("svg.plot")[1], path = svg.querySelector(".curve > path");
const look = () => svg.outerHTML.replaceAll(' style=""', ""), drawn = look();
const visible = () => [...document.querySelectorAll("output")].filter(one => !one.hidden).map(one => one.innerText);
const points = [...path.getAttribute("d").matchAll(/[ML] (\\S+) (\\S+)/g)].map(found => found.slice(1).map(Number));
const peak = points.reduce((a, b) => b[1] < a[1] ? b : a);
const at = (kind, [x, y], on = svg) => {
  const { x: clientX, y: clientY } = new DOMPoint(x, y).matrixTransform(svg.getScreenCTM());
  on.dispatchEvent(new PointerEvent(kind, { clientX, clientY, bubbles: true }));
  return visible();
};
const press = key => { svg.dispatchEvent(new KeyboardEvent("keydown", { key })); return visible(); };
const drag = () => {
  [["pointerdown", -20], ["pointermove", 0], ["pointerup", 40]].forEach(([kind, by]) => at(kind, [peak[0] + by, 100]));
  return [...svg.querySelectorAll(".across .made text")].map(one => one.textContent);
};
const found = { nothing: visible(), hover: at("pointermove", peak) };
found.gone = at("pointerleave", peak);
found.ticks = drag();
const match = path.getAttribute("d").match(new RegExp(`(\\\\S+) ${peak[1].toFixed(2)}`));
found.zoomed = at("pointermove", [+match[1], peak[1]]);
found.keys = [press("ArrowRight"), press("ArrowLeft"), press("Escape")];
found.escaped = look() === drawn;
found.again = drag();
svg.dispatchEvent(new MouseEvent("dblclick"));
found.doubled = look() === drawn;
drag();
dispatchEvent(new Event("beforeprint"));
found.printed = look() === drawn;
document.body.append(Object.assign(document.createElement("pre"), { id: "found", textContent: JSON.stringify(found) }));
"""


@pytest.mark.slow
def test_a_panel_tells_its_samples_zooms_and_returns_by_mouse_and_keys(page, tmp_path):
    text, allowed = page.read_text(encoding="utf-8"), hashlib.sha256(READER.encode()).digest()
    text = text.replace("script-src", f"script-src 'sha256-{base64.b64encode(allowed).decode()}'")
    copy = tmp_path / "copy.html"
    copy.write_text(text.replace("</body>", f"<script>{READER}</script></body>"), encoding="utf-8")
    seen = browse(copy, tmp_path / "profile", "--dump-dom", size=(1200, 6000))
    assert "CONSOLE" not in seen.stderr, seen.stderr
    found = json.loads(
        unescape(re.search(r'<pre id="found">(.*?)</pre>', seen.stdout, re.S).group(1))
    )
    log = maxwell_slip_log()
    highest = int(np.argmax(log.output))
    time, fitted, _ = (
        float(re.search(r"[-−.\d]+", line).group()) for line in found["hover"][0].splitlines()
    )
    assert found["hover"][0].startswith("time ") and "\nfitted " in found["hover"][0]
    assert time == pytest.approx(log.time[highest], abs=0.02)
    assert fitted == pytest.approx(log.output[highest], abs=0.02)
    assert len(found["hover"]) == 3 and all(
        f"time {time}" in each for each in found["hover"]
    )  # one cursor, three panels
    assert found["nothing"] == found["gone"] == found["keys"][2] == []
    assert found["zoomed"][0] == found["hover"][0] != found["keys"][0][0]
    steps = np.diff([float(tick.replace("−", "-")) for tick in found["ticks"]])
    assert len(steps) >= 3 and np.ptp(steps) < 1e-9 and found["again"] == found["ticks"]
    assert found["escaped"] and found["doubled"] and found["printed"]


def picture(page, tmp_path, name, *arguments):
    shot = tmp_path / f"{name}.png"
    browse(page, tmp_path / name, f"--screenshot={shot}", *arguments, size=DESK)
    return imread(shot)[..., :3]


@pytest.mark.slow
def test_the_arm_moves_unless_the_reader_asked_for_less_motion(experiment, tmp_path):
    early, late = (
        picture(experiment, tmp_path, f"t{t}", f"--virtual-time-budget={t}") for t in (1000, 6000)
    )
    assert np.mean(np.abs(early - late).max(axis=2) > 0.2) > 0.001
    for attempt in range(
        3
    ):  # one browser in ten sets a line of letters a little differently; an arm never rests
        shots = [(f"s{t}-{attempt}", NO_MOTION, f"--virtual-time-budget={t}") for t in (1000, 6000)]
        early, late = (picture(experiment, tmp_path, *shot) for shot in shots)
        if np.array_equal(early, late):
            break
    assert np.array_equal(early, late)
    dark = np.sum(np.abs(early - early[0, 0]).max(axis=2) > 0.2)
    assert dark > 10_000  # the still picture is there instead


@pytest.mark.slow
def test_a_page_whose_script_does_not_run_is_the_same_picture(page, tmp_path):
    bare = tmp_path / "bare.html"
    bare.write_text(
        re.sub(r"<script>.*?</script>", "", page.read_text(encoding="utf-8"), flags=re.S),
        encoding="utf-8",
    )
    for attempt in range(3):  # as above: letters
        shots = [picture(each, tmp_path, f"{each.stem}{attempt}") for each in (page, bare)]
        if np.array_equal(*shots):
            break
    assert np.array_equal(*shots)
