"""Claims about the page that identifies a log in a browser, in Chromium, from a file, without a network."""

from __future__ import annotations

import ast
import base64
import gzip
import importlib.util
import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import dehyst
from dehyst import cli
from dehyst.export import subject_of
from dehyst.export.folder import MANIFEST, contents
from dehyst.export.names import identifier
from page_samples import HOSTILE, big_log, dialect_log

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "src" / "dehyst" / "page" / "dehyst.html"
DATA = ROOT.parent / "shared" / "data"
BROWSER = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome", "chrome"))), None)
LIMIT = 600_000
OPTIONS = (
    "--train-fraction", "--eps", "--initial-state", "--max-inverse-gain", "--from", "--to", "--time", "--time-unit",
    "--dt",
)  # fmt: skip
LISTS = ("--initial-state", "--time")
MEASURED = [
    ("piezo_dbo", "voltage_v", "displacement_um", "model"),
    ("mr_damper", "displacement_mm", "force_N", "ensaio1.2"),
    ("pam_wrist_joint", "pressure_mpa", "angle_deg", None),
    ("cavatappi_muscle", "pressure_psi", "displacement_mm", "200g_s3_t1"),
    ("tendon_sheath_joint", "angle_cmd_deg", "angle_deg", "config_000"),
    ("tendon_sheath_joint", "angle_cmd_deg", "angle_deg", "config_180"),
    ("pneumatic_arm_segment", "pressure_interp_psi", "tilt_rad", "oct28_exp5"),
]


def test_the_page_is_one_small_file_that_may_run_its_own_script_only():
    text = PAGE.read_text(encoding="utf-8")
    policy = re.search(r'http-equiv="Content-Security-Policy" content="([^"]*)"', text)[1]
    assert len(text.encode()) < LIMIT
    assert "unsafe-inline" not in policy and "'unsafe-eval'" not in policy and "default-src 'none'" in policy
    assert "connect-src" not in policy  # so default-src holds: no request at all
    assert not re.search(r'(?:src|href)="(?!data:|#)', text)


def test_the_command_writes_the_page(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["dehyst", "page", str(tmp_path / "mine.html")])
    with pytest.raises(SystemExit) as end:
        cli.main()
    assert not end.value.code and (tmp_path / "mine.html").read_bytes() == PAGE.read_bytes()
    assert "drop a log" in capsys.readouterr().out


@pytest.mark.slow
def test_the_shipped_page_is_built_of_these_sources(monkeypatch):
    missing = [name for name in ("npm", "node") if shutil.which(name) is None]
    missing += ["ziglang"] if importlib.util.find_spec("ziglang") is None else []
    if missing:
        pytest.skip(f"building the page needs {', '.join(missing)}: apt-get install nodejs npm, pip install ziglang")
    # By its file: docs/build.py, which other tests import, has the same name.
    monkeypatch.setattr(sys, "path", list(sys.path))
    spec = importlib.util.spec_from_file_location("page_build", ROOT / "page" / "build.py")
    build = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(build)
    assert _unpacked(build.page()) == _unpacked(PAGE.read_text(encoding="utf-8")), "run `make page` and commit it"


def _unpacked(text: str) -> str:
    """The page with its packed parts open: how well zlib packs is not what is asked."""

    def open_(found: re.Match[str]) -> str:
        return found[1] + gzip.decompress(base64.b85decode(found[2].replace(",", "<"))).hex() + "</script>"

    return re.sub(r'(<script type="application/octet-stream" id="\w+">)([^<]*)</script>', open_, text)


OPTION_SOURCE = (ROOT / "page" / "src" / "options.ts").read_text(encoding="utf-8")


# ---- in a browser
@pytest.fixture(scope="module")
def chromium():
    playwright = pytest.importorskip(
        "playwright.sync_api", reason="Playwright is not installed: pip install playwright drives the page"
    )
    if BROWSER is None:
        pytest.skip("no Chromium or Chrome found: apt-get install chromium to open the page in it")
    with playwright.sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=BROWSER, args=["--no-sandbox", "--disable-dev-shm-usage"])
        yield browser
        browser.close()


class Opened:
    """The page as somebody has opened it, and what it said or asked behind their back."""

    def __init__(self, browser, **options):
        self.context = browser.new_context(accept_downloads=True, **options)
        self.page = self.context.new_page()
        self.page.set_default_timeout(240_000)
        self.complaints: list[str] = []
        self.page.on("console", self._heard)
        self.page.on("pageerror", lambda fault: self.complaints.append(str(fault)))
        self.page.on("request", self._asked)
        self.page.goto(PAGE.as_uri())

    def _heard(self, message) -> None:
        if message.type in ("error", "warning"):
            self.complaints.append(message.text)

    def _asked(self, request) -> None:
        if not request.url.startswith(("file:", "blob:", "data:")):
            self.complaints.append(request.url)

    def drop(self, name: str, data: bytes) -> None:
        transfer = self.page.evaluate_handle(
            """([name, text]) => { const t = new DataTransfer();
            t.items.add(new File([Uint8Array.from(atob(text), c => c.charCodeAt(0))], name)); return t; }""",
            [name, base64.b64encode(data).decode()],
        )
        self.page.dispatch_event(".drop", "drop", {"dataTransfer": transfer})

    def until(self, true: str) -> None:
        """Wait for something; Playwright's own way would evaluate text within the page, which the page forbids."""
        for _ in range(4000):
            if self.page.evaluate(f"Boolean({true})"):
                return
            self.page.wait_for_timeout(60)
        raise AssertionError(true)

    def settled(self) -> None:
        self.until(
            "document.querySelector('.results').answer || document.querySelector('[role=alert] .judged') || "
            "(document.querySelector('#input') && !document.querySelector('.status').textContent)"
        )

    def identify(self, input: str, output: str, run: str | None = None, options: dict[str, str] | None = None) -> dict:
        page = self.page
        page.wait_for_selector("#input", state="attached")
        if run is not None and page.input_value("#run") != run:
            page.select_option("#run", run)
        self.settled()
        page.select_option("#input", input)
        page.select_option("#output", output)
        if options is not None:
            page.evaluate("document.querySelector('.options').open = true")
        for flag in OPTIONS if options is not None else ():
            control = page.locator(f"#option{flag[1:]}")
            (control.select_option if flag in LISTS else control.fill)(options.get(flag, ""))
        page.click("button:text-is('Identify')")
        return self.answer()

    def answer(self) -> dict:
        page = self.page
        self.until("document.querySelector('.results').answer?.said || document.querySelector('[role=alert] .judged')")
        return page.evaluate(
            "(() => { const a = document.querySelector('.results').answer;"
            "return a ? {said: a.said, verdict: a.verdict, "
            "warnings: a.warnings, thresholds: [...a.model.thresholds], weights: [...a.model.weights], "
            "offset: a.model.offset} : {refused: document.querySelector('[role=alert] .lead').textContent}; })()"
        )

    def close(self) -> None:
        assert self.complaints == []
        self.context.close()


@pytest.fixture
def opened(chromium):
    made = Opened(chromium)
    yield made
    made.close()


def same(said, expected, where="") -> None:
    """Number by number to 1e-9; what only rounding decides is left out: residuals of the optimality, ties of blocks."""
    if isinstance(expected, dict):
        assert said.keys() == expected.keys(), where
        for key, value in expected.items():
            if key in {"kkt_residual", "round_trip_error"}:
                assert said[key] < 1e-9, where
            elif key in {"own", "apart"}:  # what is left of columns that nearly depend on each other
                assert said[key] == pytest.approx(value, rel=1e-2, abs=1e-6), where
            elif key == "better" or (key == "p" and (value > 0.05 or _tied(expected))):
                pass  # counts of blocks that differ by rounding alone, or where they decide nothing
            else:
                same(said[key], value, f"{where}.{key}")
    elif isinstance(expected, list | tuple):
        assert len(said) == len(expected), where
        for k, (one, other) in enumerate(zip(said, expected, strict=True)):
            same(one, other, f"{where}[{k}]")
    elif isinstance(expected, float | int) and not isinstance(expected, bool):
        assert said == pytest.approx(expected, rel=1e-9, abs=1e-12, nan_ok=True), where
    else:
        assert said == expected, where


def _tied(evidence: dict) -> bool:
    return evidence["without_percent"] == pytest.approx(evidence["with_percent"], rel=1e-6)


def typed(options: dict[str, str]) -> tuple[dict, dict]:
    """Options of the command line as arguments of read_log and of identify."""
    names = {"--from": "start", "--to": "stop"}
    given = {
        names.get(flag, flag[2:].replace("-", "_")): value
        if flag in (*LISTS, "--time-unit") or value == "auto"
        else float(value)
        for flag, value in options.items()
    }
    fitting = {"train_fraction", "eps", "initial_state", "max_inverse_gain"}
    return {k: v for k, v in given.items() if k not in fitting}, {k: v for k, v in given.items() if k in fitting}


def compare(answer: dict, log: Path, input: str, output: str, run: str | None = None, options=None) -> None:
    """The page's answer is that of `dehyst identify LOG --family pi OPTIONS`, or its refusal word by word."""
    reading, fitting = typed(options or {})
    try:
        fit = dehyst.identify(dehyst.read_log(log, input, output, run=run, **reading), "pi", **fitting)
    except dehyst.DehystError as fault:
        assert answer.get("refused", "").lower() == str(fault).lower()
        return
    assert "refused" not in answer, answer
    same(answer["said"], json.loads(json.dumps(fit.as_dict(), default=lambda v: v.tolist())))
    assert answer["verdict"] == fit.verdict
    assert answer["warnings"] == [{"code": w.code, "message": w.message} for w in fit.warnings]
    same(answer["thresholds"], fit.model.thresholds.tolist(), "thresholds")
    assert answer["weights"] == pytest.approx(fit.model.weights.tolist(), rel=1e-9, abs=1e-12)
    assert answer["offset"] == pytest.approx(fit.model.offset, rel=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("case", MEASURED, ids=lambda case: f"{case[0]}-{case[3]}")
def test_a_measured_log_gives_what_python_says(opened, case):
    folder, *columns = case
    log = DATA / folder / "data.csv.gz"
    if not log.is_file():
        pytest.skip(f"no measured logs in ../{DATA.parent.name}")
    opened.drop(log.name, log.read_bytes())
    compare(opened.identify(*columns), log, *columns)


@pytest.mark.slow
def test_fifty_logs_in_ten_dialects_give_what_python_says(opened, tmp_path):
    memory = []
    for seed in range(50):
        log = tmp_path / (f"log{seed}.csv" + (".gz" if seed % 10 in (2, 7) else ""))
        log.write_bytes(dialect_log(seed))
        guess = dehyst.inspect_log(log)
        opened.drop(log.name, log.read_bytes())
        opened.settled()
        assert opened.page.query_selector("#input"), (seed, opened.page.inner_text("[role=alert]"))
        said = opened.page.evaluate("['input', 'output'].map((id) => document.getElementById(id).value)")
        assert said == [guess.input or "", guess.output or ""], log.read_bytes()[:200]
        compare(opened.identify(guess.input, guess.output), log, guess.input, guess.output)
        memory.append(opened.page.evaluate("performance.memory.usedJSHeapSize"))
    assert np.mean(memory[-10:]) < np.mean(memory[10:20]) + 60e6  # flat, but for what is not yet collected


def test_every_option_that_a_message_of_the_page_prescribes_has_a_control():
    sys.path.insert(0, str(ROOT / "page"))
    try:
        from translate.python import MODULES
    finally:
        sys.path.pop(0)
    controls = {"--input", "--output", "--run", *re.findall(r'option\((?:true|false), "(--[a-z-]+)"', OPTION_SOURCE)}
    # Another model than the page's: its last command leads there. A schedule's options stand behind --family.
    other = {"--family", "--for", "--load", "--mean-pressure"}
    beyond = {
        "--shear",
        "--stream",
        "--no-stream",
        "--families",
        "--save",
        "--report",
    }  # not of family pi, or a line to type
    prescribed = set()
    for name in MODULES:
        if name.partition("/")[0] in ("data", "identification", "io"):
            prescribed |= _prescribed((ROOT / "src" / "dehyst" / f"{name}.py").read_text(encoding="utf-8"))
    assert {"--train-fraction", "--eps", "--time-unit"} <= prescribed
    assert prescribed <= controls | other | beyond, prescribed - controls - other - beyond


def test_the_page_has_every_function_of_numpy_and_math_that_it_reaches():
    sys.path.insert(0, str(ROOT / "page"))
    try:
        from translate import python
    finally:
        sys.path.pop(0)
    runtime = {path.stem: path.read_text(encoding="utf-8") for path in (ROOT / "page" / "runtime").glob("*.js")}
    asked = "".join(runtime[name] for name in ("answer", "native", "jinja"))
    reached = set(re.findall(r"\b(?:np|math)\.(\w+)", python.script(python.MODULES, asked)))
    assert {"median", "isfinite"} <= reached
    elsewhere = {"savetxt", "convolve"}  # a sentence that tells of it; units of families that the page does not export
    assert {name for name in reached if not re.search(rf"\b{name}\b", "".join(runtime.values()))} <= elsewhere


def _prescribed(source: str) -> set[str]:
    """Options that the sentences of a module name; docstrings and lines to type into a rig are none."""
    found = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and "\n" not in node.value:
            found |= set(re.findall(r"--[a-z][a-z-]+", node.value)) - {"--range", "--follow-offset", "--json"}
    return found


CASES = [
    *({"--train-fraction": value} for value in ("0.3", "0.8", "1", "1.5")),
    *({"--eps": value} for value in ("auto", "0.5", "2", "1e9")),
    *({"--max-inverse-gain": value} for value in ("0.4", "0.1", "-1")), {"--max-inverse-gain": "2", "--eps": "0.5"},
    *({"--initial-state": value} for value in ("auto", "zero", "origin", "rest", "rising", "falling", "unknown")),
    {"--from": "5"}, {"--to": "12.5"}, {"--from": "4", "--to": "17"}, {"--from": "9", "--to": "3"}, {"--to": "1e-3"},
    {"--time-unit": "ms"}, {"--time-unit": "min"}, {"--time": "pressure_bar"},
    {"--time": "time_s", "--time-unit": "ms"}, {"--time-unit": "1/60 s"}, {"--dt": "0.02"},
    {"--train-fraction": "0.7", "--eps": "auto", "--initial-state": "rest", "--from": "3"},
]  # fmt: skip


@pytest.mark.slow
def test_the_options_of_the_page_are_those_of_the_command_line(opened, tmp_path):
    log = tmp_path / "log.csv"
    log.write_bytes(dialect_log(0))
    opened.drop(log.name, log.read_bytes())
    answers = [opened.identify("pressure_bar", "angle_deg", options=options) for options in CASES]
    for answer, options in zip(answers, CASES, strict=True):
        compare(answer, log, "pressure_bar", "angle_deg", options=options)
    assert len({json.dumps(answer.get("said", answer)) for answer in answers}) > len(CASES) - 6  # they do something
    words = [word for flag, value in CASES[-1].items() for word in (flag, value)]
    lines = [opened.page.inner_text(f"#{name}") for name in ("repeat", "command")]
    for flag, value in zip(words[::2], words[1::2], strict=True):
        assert f" {flag} {value} " in lines[0]
    assert "--family pi" in lines[0] and "--train-fraction 0.7" in lines[1] and "--eps" not in lines[1]


@pytest.mark.slow
def test_what_a_warning_prescribes_is_a_button_that_does_it(opened, tmp_path):
    t = np.linspace(0.0, 20.0, 400)
    x = 1.0 - np.cos(2 * np.pi * t / 20.0)
    y = dehyst.PrandtlIshlinskii([0.0, 0.2, 0.5], [1.0, 0.4, 0.3]).simulate(x)
    log = tmp_path / "loop.csv"
    rows = "\n".join(f"{a:.4f},{b:.5f},{c:.5f}" for a, b, c in zip(t, x, y, strict=True))
    log.write_text(f"time_s,pressure_bar,angle_deg\n{rows}\n")
    opened.drop(log.name, log.read_bytes())
    opened.answer()
    before = opened.page.inner_text("#verdict")
    opened.page.locator(".results").get_by_role("button", name="Identify with --train-fraction 1").first.click()
    answer = opened.answer()
    compare(answer, log, "pressure_bar", "angle_deg", options={"--train-fraction": "1"})
    assert "Do not compensate" in before and "Do not compensate" not in opened.page.inner_text("#verdict")
    assert opened.page.input_value("#option-train-fraction") == "1"


@pytest.mark.slow
def test_a_refusal_that_names_an_option_leads_to_it(opened):
    log = b"pressure_bar,angle_deg,time_s,t_s\n" + b"\n".join(
        b"%.4f,%.4f,%d,%d" % (np.sin(k / 9), np.sin(k / 9 - 0.3), k, 3 * k + k % 2) for k in range(400)
    )
    opened.drop("clocks.csv", log)
    opened.settled()
    assert "refused" in opened.identify("pressure_bar", "angle_deg")
    opened.page.get_by_role("alert").get_by_role("button", name="Identify with --time time_s").click()
    assert "said" in opened.answer()
    opened.page.click(".options summary")
    opened.page.fill("#option-eps", "a lot")
    opened.page.click("button:text-is('Identify')")
    assert "“a lot” is not a number" in opened.page.inner_text("[role=alert]")


@pytest.mark.slow
def test_a_log_is_let_go_when_the_next_one_comes(opened, tmp_path):
    log, rows = tmp_path / "log.csv", 50_000
    log.write_bytes(big_log(rows))
    page = opened.page
    page.evaluate("""(() => {
        const post = Worker.prototype.postMessage;
        Worker.prototype.postMessage = function (...given) {
            this.addEventListener("message", ({ data }) => { globalThis.wasm = data.memory; }, { once: true });
            return post.apply(this, given);
        };
    })()""")
    devtools = page.context.new_cdp_session(page)
    held = []
    for _ in range(6):
        page.set_input_files("#log", log)
        opened.until("document.querySelector('.results').answer?.said")
        page.wait_for_timeout(300)
        devtools.send("HeapProfiler.collectGarbage")
        used = devtools.send("Runtime.getHeapUsage")
        held.append((used["usedSize"] + used["backingStorageSize"], page.evaluate("globalThis.wasm")))
    own = 7 * 8 * rows  # bytes of its signals: four more logs would hold four times as many
    assert held[-1][0] < held[1][0] + own
    assert held[-1][1] < held[1][1] + own


@pytest.mark.slow
@pytest.mark.parametrize("name", HOSTILE)
def test_a_hostile_log_gets_a_sentence(opened, tmp_path, name):
    opened.drop(name, HOSTILE[name])
    opened.settled()
    said = opened.page.inner_text("[role=alert], .findings, .card") or opened.page.inner_text("#panel-identify")
    assert "page failed" not in said and len(said) > 40


@pytest.mark.slow
def test_a_log_of_300_mb_is_refused_with_what_to_do(opened, tmp_path):
    log = tmp_path / "huge.csv"
    with log.open("wb") as stream:
        stream.truncate(300_000_000)
    opened.page.set_input_files("#log", log)
    opened.page.wait_for_selector("[role=alert] .judged")
    assert "pip install dehyst" in opened.page.inner_text("[role=alert]")


@pytest.mark.slow
def test_a_long_log_says_that_it_is_being_read_and_can_be_stopped(opened, tmp_path):
    log = tmp_path / "long.csv"
    log.write_bytes(big_log(1_200_000))
    opened.page.set_input_files("#log", log)
    opened.page.wait_for_selector(".status button:text-is('Stop')")
    assert opened.page.evaluate(  # one that is made anew while it is pressed is not clicked
        """new Promise((done) => { const status = document.querySelector(".status"), button = status.lastElementChild,
        work = () => status.textContent.split(" ")[0], first = work();
        setTimeout(() => done(button.isConnected || work() !== first), 250); })"""
    )
    opened.page.click(".status button:text-is('Stop')")
    assert "Stopped" in opened.page.inner_text(".status")
    opened.drop("next.csv", dialect_log(0))
    opened.settled()
    assert opened.page.input_value("#input") == "pressure_bar"


@pytest.mark.slow
def test_the_model_that_is_taken_away_is_read_by_dehyst(opened, tmp_path):
    opened.page.click("text=Try an example")
    opened.settled()
    with opened.page.expect_download() as saving:
        opened.page.click("button:text-is('made-up.model.json')")
    saving.value.save_as(tmp_path / "model.json")
    model = dehyst.load(tmp_path / "model.json")
    answer = opened.page.evaluate("[...document.querySelector('.results').answer.predicted]")
    x = opened.page.evaluate("[...document.querySelector('.results').answer.x]")
    assert np.max(np.abs(model.simulate(x) - answer)) < 1e-9 * np.ptp(answer)
    assert model.card.provenance["settings"]["family"] == "pi"


@pytest.mark.slow
def test_the_zip_holds_what_export_writes_and_its_check_passes(opened, tmp_path):
    opened.page.click("text=Try an example")
    opened.settled()
    for button, name in (("made-up.model.json", "made-up.model.json"), ("C code (zip)", "c.zip")):
        with opened.page.expect_download() as saving:
            opened.page.click(f"button:text-is('{button}')")
        saving.value.save_as(tmp_path / name)
    shutil.unpack_archive(tmp_path / "c.zip", tmp_path / "taken")
    model = dehyst.load(tmp_path / "made-up.model.json")
    written = contents(subject_of(model, name=identifier("made-up.model")), "c")
    taken = {
        str(p.relative_to(tmp_path / "taken")): p.read_bytes() for p in (tmp_path / "taken").rglob("*") if p.is_file()
    }
    dated = {name: re.sub(rb'"date": "[^"]*"', b"", data) for name, data in (*written.items(),) if name == MANIFEST}
    assert {**taken, MANIFEST: re.sub(rb'"date": "[^"]*"', b"", taken[MANIFEST])} == {**written, **dated}
    if shutil.which("make") is None or shutil.which("cc") is None:
        pytest.skip("no make or C compiler: the folder is the right one, its check was not run")
    done = subprocess.run(["make", "check"], cwd=tmp_path / "taken", capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.slow
def test_the_compensator_at_work_stays_on_the_reference_and_a_curve_does_not(opened):
    page = opened.page
    page.click("text=Try an example")
    opened.settled()
    page.click("button:text-is('Play a triangle')")
    page.wait_for_timeout(1500)
    page.click("button:text-is('Stop')")
    page.focus("#reference")
    for _ in range(20):
        page.keyboard.press("ArrowRight")
    page.wait_for_timeout(500)
    said = page.inner_text(".readout[role=status]")
    with_it, without = re.search(r"rms: (\S+) deg with the compensator, (\S+) deg", said).groups()
    assert with_it == "0" and float(without) > 0.1
    with page.expect_download() as saving:
        page.click("figure:has-text('Compensated loop') button:text-is('PNG')")
    assert Path(saving.value.path()).read_bytes().startswith(b"\x89PNG")


def _circle(k: int) -> tuple[float, float]:
    return np.sin(k / 16), np.sin(k / 16 - 0.3)


@pytest.mark.slow
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_nothing_serious(chromium, scheme):
    axe = ROOT / "page" / "node_modules" / "axe-core" / "axe.min.js"
    if not axe.is_file():
        pytest.skip("axe-core is not installed: npm ci in page/, or make page")
    opened = Opened(chromium, color_scheme=scheme, viewport={"width": 390, "height": 844})
    opened.drop("loop.csv", b"time_s,u_V,y_mm\n" + b"\n".join(b"%d,%g,%g" % (k, *_circle(k)) for k in range(100)))
    opened.answer()
    assert opened.page.locator(".cures button").count() > 0
    opened.page.click(".options summary")
    found = []
    for tab in ("identify", "teach", "arm"):
        opened.page.click(f"#tab-{tab}")
        opened.page.wait_for_timeout(500)
        opened.page.evaluate(axe.read_text(encoding="utf-8"))
        result = opened.page.evaluate("axe.run({resultTypes: ['violations']})")
        found += [
            (tab, v["id"], v["nodes"][0]["html"][:150])
            for v in result["violations"]
            if v["impact"] in ("serious", "critical")
        ]
        assert opened.page.evaluate("document.documentElement.scrollWidth <= innerWidth"), tab
    assert found == []
    opened.close()
