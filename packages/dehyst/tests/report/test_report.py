"""Claims about reports: complete in themselves, safe, small, readable by machines that read HTML, SVG and PNG."""

from __future__ import annotations

import base64
import hashlib
import os
import re
import stat
import struct
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from dataclasses import replace

import numpy as np
import pytest

import dehyst
from dehyst.errors import OutputError
from dehyst.findings import Finding, Grade
from dehyst.identification import ComparedSetting, Score
from dehyst.models import ModifiedPrandtlIshlinskii, PrandtlIshlinskii, StaticCurve
from dehyst.report import write_comparison_report, write_drift_report, write_report
from dehyst.report._figures import all_figures
from dehyst.report._figures.choices import drawn_candidates, reach
from dehyst.report._figures.operators import typical_thresholds
from dehyst.report._judgement import lights, overall
from dehyst.report._svg import write_figure
from dehyst.report._theme import TOKENS, fonts
from dehyst_robot.report import write_muscle_report, write_reproduction_report
from report_samples import (
    bench,
    compared,
    drifted,
    falling,
    fit_by_hand,
    letters_of,
    maxwell_slip_log,
    muscle_fit,
    read,
)  # fmt: skip
from reproduction_samples import sample_reproduction

ALL_FIGURES = [
    "loop",
    "arranged",
    "play",
    "model",
    "residual",
    "structure",
    "weights",
    "candidates",
]


@pytest.fixture(scope="module")
def fit():
    return fit_by_hand()


@pytest.fixture(scope="module")
def page(fit, tmp_path_factory):
    return write_report(fit, tmp_path_factory.mktemp("report") / "report.html")


@pytest.fixture(scope="module")
def pages(page, tmp_path_factory):
    """A page of every kind."""
    folder = tmp_path_factory.mktemp("pages")
    experiment = sample_reproduction(("maxwell-slip", "none"), (0,), (1, 2))
    return {
        "fit": page,
        "comparison": write_comparison_report(compared(), folder / "comparison.html"),
        "drift": write_drift_report(drifted(), folder / "drift.html"),
        "muscle": write_muscle_report(bench(), folder / "muscle.html", fit=muscle_fit()),
        "experiment": write_reproduction_report(experiment, folder / "experiment.html"),
    }


@pytest.mark.slow
def test_every_page_is_well_formed_and_its_references_have_one_target(pages):
    for kind, page in pages.items():
        reader, text = read(page), page.read_text(encoding="utf-8")
        ids = reader.ids()
        assert reader.faults == [], kind
        assert len(ids) > 10 and len(set(ids)) == len(ids), kind
        wanted = set(re.findall(r'href="#([^"]+)"', text)) | set(
            re.findall(r"url\(#([^)]+)\)", text)
        )
        assert len(wanted) > 8 and wanted <= set(ids), kind


@pytest.mark.slow
def test_every_page_refers_to_nothing_outside_itself_and_forbids_requests_and_all_scripts_but_one(
    pages,
):
    for kind, page in pages.items():
        assert (
            re.search(r"(https?|ftp|file):|//[\w.]+\.\w|@import", page.read_text(encoding="utf-8"))
            is None
        ), kind
        elements = read(page).elements
        (script,) = re.findall(r"<script>(.*?)</script>", page.read_text(encoding="utf-8"), re.S)
        assert len(script) < 10_000, kind
        for tag, attributes in elements:
            assert (tag, attributes) == ("script", {}) or tag not in {
                "script",
                "iframe",
                "object",
                "embed",
                "img",
                "base",
                "form",
            }
            assert not any(name.startswith("on") for name in attributes)
            for name in ("src", "href", "xlink:href", "data", "action", "srcset"):
                assert (attributes.get(name) or "#")[0] == "#" or attributes[name] == "data:,"
            assert re.search(r"url\((?!#)", attributes.get("style") or "") is None
        policies = [
            a["content"] for _, a in elements if a.get("http-equiv") == "Content-Security-Policy"
        ]
        allowed = f"'sha256-{base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()}'"
        policy = (
            f"default-src 'none'; script-src {allowed}; style-src 'unsafe-inline'; img-src data:"
        )
        assert policies == [policy], kind


def test_every_figure_is_on_the_page_with_an_alternative_text(fit, page):
    reader = read(page)
    assert reader.ids("section", "figure") == ALL_FIGURES
    pictures = [a for t, a in reader.elements if t == "svg"]
    panels = [panel for figure in all_figures(fit) for panel in figure.panels]
    assert len(pictures) == len(panels) >= 13
    assert [a["aria-label"] for a in pictures] == [panel.alt for panel in panels]
    assert all(a["role"] == "img" and len(a["aria-label"]) > 15 for a in pictures)
    assert all(panel.title in reader.text for panel in panels)


@pytest.mark.slow
def test_the_page_says_the_verdict_the_scores_the_warnings_and_the_next_commands(fit, tmp_path):
    text = read(write_report(fit, tmp_path / "r.html", model_file="elbow model.json")).text
    assert fit.verdict in text
    assert f"{fit.test.rmse_percent:.2f}" in text and f"{fit.train.rmse_percent:.2f}" in text
    assert f"{fit.static_test.rmse_percent:.2f}" in text
    for finding in fit.warnings:
        assert finding.code in text and finding.message in text
    assert 'dehyst compensate "elbow model.json" reference.csv --output angle' in text
    assert "load('elbow model.json')" in text
    assert "ab" * 32 in text  # the checksum of the log


@pytest.mark.slow
def test_commands_name_the_columns_of_the_log_not_the_labels(tmp_path):
    log = maxwell_slip_log(provenance={"input": "pressure_bar", "output": "angle [deg]"})
    text = read(write_report(fit_by_hand(log), tmp_path / "r.html")).text
    assert '--output "angle [deg]"' in text and "--input pressure_bar" in text


def test_axes_carry_names_and_units(page):
    texts = letters_of(page)
    assert texts.count("pressure [bar]") >= 5
    assert texts.count("angle [deg]") >= 4
    assert {"residual [deg]", "weight w [deg/bar]", "threshold r [bar]", "time [s]"} <= set(texts)


@pytest.mark.slow
def test_very_small_and_very_large_units_get_powers_of_ten_on_the_axis(tmp_path):
    log = maxwell_slip_log()
    tiny = replace(
        log, output=log.output * 1e-6, input=log.input * 1e6, output_unit="rad", input_unit="Pa"
    )
    texts = letters_of(write_report(fit_by_hand(tiny), tmp_path / "r.html"))
    assert "angle [10⁻⁶ rad]" in texts and "pressure [10⁶ Pa]" in texts
    assert not any(re.search(r"\de[+-−]?\d", text) for text in texts)


@pytest.mark.slow
def test_a_log_without_time_is_drawn_over_sample_numbers_and_a_clock_from_1970_is_set_to_zero(
    tmp_path,
):
    text = write_report(fit_by_hand(maxwell_slip_log(time=None)), tmp_path / "r.html").read_text()
    assert ">sample number<" in text and "time [s]" not in text
    log = maxwell_slip_log()
    text = write_report(
        fit_by_hand(replace(log, time=log.time + 1.7e9)), tmp_path / "r.html"
    ).read_text()
    assert ">time since the first sample [s]<" in text


@pytest.mark.slow
@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("name", ["圧" * 300, "W" * 300, "🦾"])
def test_long_and_foreign_names_and_units_leave_room_for_the_picture(name, tmp_path):
    log = maxwell_slip_log(
        300, name=name, input_name=name, output_name=name, input_unit=name, output_unit=name
    )
    assert write_report(fit_by_hand(log), tmp_path / "r.html").exists()


@pytest.mark.slow
def test_figures_are_written_as_valid_svg_and_png(fit, tmp_path):
    write_report(fit, tmp_path / "r.html", figures=tmp_path / "new" / "figures")
    names = sorted(path.name for path in (tmp_path / "new" / "figures").iterdir())
    assert names == sorted(
        f"figure-{k}-{key}.{kind}"
        for k, key in enumerate(ALL_FIGURES, start=1)
        for kind in ("svg", "png")
    )
    for path in (tmp_path / "new" / "figures").iterdir():
        data = path.read_bytes()
        if path.suffix == ".svg":
            root = ElementTree.fromstring(data)
            assert root.tag == "{http://www.w3.org/2000/svg}svg"
            assert root.find("{http://www.w3.org/2000/svg}title").text
            assert len(root.findall(".//{http://www.w3.org/2000/svg}path")) > 5
            assert b"creativecommons" not in data and b"var(--" not in data
        else:
            assert data[:8] == b"\x89PNG\r\n\x1a\n" and data[-12:-4].endswith(b"IEND")
            width, height = struct.unpack(">II", data[16:24])
            assert width >= 900 and height >= 650


def test_a_figure_is_the_same_twice(fit, tmp_path):
    figure = all_figures(fit)[0]
    for folder in (tmp_path / "a", tmp_path / "b"):
        folder.mkdir()
        write_figure(figure, folder, figure.stem)
    for path in (tmp_path / "a").iterdir():
        assert path.read_bytes() == (tmp_path / "b" / path.name).read_bytes(), path.name


@pytest.mark.slow
def test_a_failed_write_leaves_the_old_page_and_no_litter(fit, tmp_path, monkeypatch):
    target = tmp_path / "r.html"
    target.write_text("old")

    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OutputError, match="No space left"):
        write_report(fit, target)
    assert target.read_text() == "old"
    assert [path.name for path in tmp_path.iterdir()] == ["r.html"]


@pytest.mark.slow
def test_a_folder_that_does_not_exist_is_named(fit, tmp_path):
    with pytest.raises(OutputError, match="nowhere"):
        write_report(fit, tmp_path / "nowhere" / "r.html")
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match="folder"):
        write_report(fit, tmp_path / "r.html", figures=tmp_path / "file")


def test_the_page_is_readable_by_others(page):
    assert stat.S_IMODE(page.stat().st_mode) & stat.S_IRUSR


@pytest.mark.slow
@pytest.mark.parametrize("loops", [6.0, 700.0])
def test_a_long_log_gives_a_small_page(loops, tmp_path):
    fit = fit_by_hand(maxwell_slip_log(100_000, loops=loops))
    page = write_report(fit, tmp_path / "r.html")
    assert page.stat().st_size < 3_000_000
    assert read(page).faults == []


@pytest.mark.slow
def test_a_million_rows_of_noise_work(tmp_path):
    rng = np.random.default_rng(1)
    log = maxwell_slip_log(4000)
    many = replace(
        log,
        input=rng.standard_normal(1_000_000),
        output=rng.standard_normal(1_000_000),
        time=np.arange(1e6),
    )
    page = write_report(fit_by_hand(many, n=4), tmp_path / "r.html")
    assert page.stat().st_size < 3_000_000


@pytest.mark.slow
@pytest.mark.parametrize(("family", "train"), [("pi", 1.0), ("modified-pi", 0.5), ("stop", 0.5)])
def test_every_family_and_split_is_drawn(family, train, tmp_path):
    page = write_report(
        fit_by_hand(falling(maxwell_slip_log(600)), family=family, train=train), tmp_path / "r.html"
    )
    reader = read(page)
    assert reader.faults == []
    assert ("held out" in " ".join(letters_of(page))) == (train < 1.0)
    assert ("Output map S" in reader.text) == (family == "modified-pi")
    assert ("stop weight s" in reader.text) == (family == "stop")


@pytest.mark.slow
@pytest.mark.parametrize("family", ["direct-inverse", "preisach", "lugre"])
def test_no_figure_of_a_family_is_left_without_a_number(family, tmp_path):
    rng = np.random.default_rng(0)
    time = np.arange(1200) * 0.01
    x = np.sin(2.0 * time) * np.linspace(1.0, 0.3, 1200)
    y = PrandtlIshlinskii([0.0, 0.2], [1.0, 0.5]).simulate(x) + 0.001 * rng.standard_normal(1200)
    fit = dehyst.identify(dehyst.Recording(input=x, output=y, time=time), family)
    page = write_report(fit, tmp_path / "r.html").read_text(encoding="utf-8")
    assert "not a number" not in page and "nan %" not in page
    assert ("Inverse model" in page) == (not fit.model.no_inverse)
    assert ("there is no inverse" in page) == bool(fit.model.no_inverse)
    # What does not break leaves a table its width.
    assert max(map(len, re.findall(r'class="range">([^<]*)', page)), default=0) < 60


def test_a_curve_without_memory_is_reported_without_operators(tmp_path):
    fit = fit_by_hand()
    flat = replace(fit, model=fit.static, candidates=(), warnings=())
    assert isinstance(flat.model, StaticCurve)
    page = write_report(flat, tmp_path / "r.html")
    assert read(page).ids(of="figure") == ["loop", "arranged", "model", "residual", "structure"]


@pytest.mark.slow
def test_several_logs_are_drawn_beside_each_other(tmp_path):
    logs = [maxwell_slip_log(500, seed=k, name=f"trial-{k}.csv") for k in range(8)]
    page = write_report(fit_by_hand(*logs), tmp_path / "r.html")
    reader = read(page)
    assert reader.faults == []
    assert all(f"trial-{k}.csv" in reader.text for k in range(8))
    assert "first 6 of 8 logs" in reader.text
    assert "time, log after log [s]" in reader.text


@pytest.mark.slow
def test_gaps_interrupt_lines_and_are_marked(tmp_path):
    log = maxwell_slip_log(600)
    time_with_gap = np.where(np.arange(600) >= 200, log.time + 30.0, log.time)
    reader = read(
        write_report(
            fit_by_hand(replace(log, breaks=(200,), time=time_with_gap)), tmp_path / "r.html"
        )
    )
    assert "the place where samples are missing" in reader.text


@pytest.mark.slow
def test_a_log_that_fits_exactly_and_numbers_that_do_not_exist_are_printed(tmp_path):
    x = np.sin(np.linspace(0, 20, 300))
    log = replace(maxwell_slip_log(300), input=x, output=2 * x)
    zero = Score(0.0, 0.0, 0.0, 0.0)
    nothing = Score(float("nan"), float("nan"), float("inf"), float("nan"))
    for score in (zero, nothing):
        fit = replace(
            fit_by_hand(log), train=score, test=score, static_train=score, static_test=score
        )
        assert read(write_report(fit, tmp_path / "r.html")).faults == []


def test_figures_use_colours_of_the_theme_only(page):
    css, _, body = page.read_text(encoding="utf-8").partition("</style>")
    used = set(re.findall(r"#[0-9a-f]{6}\b", body))
    assert used == set()  # every colour became a variable
    for token in TOKENS:
        assert f"--{token.name}: {token.light};" in css and f"--{token.name}: {token.dark};" in css


def _contrast(a: str, b: str) -> float:
    def luminance(colour):
        parts = [int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)]
        linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in parts]
        return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]

    low, high = sorted((luminance(a), luminance(b)))
    return (high + 0.05) / (low + 0.05)


@pytest.mark.parametrize("side", ["light", "dark"])
def test_letters_and_lines_stand_out_from_the_paper(side):
    colours = {token.name: getattr(token, side) for token in TOKENS}
    paper = colours["paper"]
    assert all(_contrast(colours[name], paper) >= 4.5 for name in ("ink", "muted"))
    assert all(
        _contrast(colours[n], paper) >= 3.0
        for n in ("train", "test", "model", "static", "other", "bad", "fifth")
    )


@pytest.mark.slow
def test_the_light_for_the_whole_says_what_the_verdict_says(tmp_path):
    words = {
        Grade.GOOD: "good for compensation",
        Grade.CARE: "usable with care",
        Grade.BAD: "do not compensate with it",
    }
    x = 2 * np.sin(np.linspace(0, 40, 900)) * np.linspace(1, 0.3, 900)
    y = PrandtlIshlinskii(np.array([0.0, 0.6]), np.array([1.0, 0.5])).simulate(x)
    noise = np.random.default_rng(0).standard_normal(900)
    seen = set()
    for output in (y, y + 0.12 * noise, 2 * x, 3.0 * noise + x):
        fit = dehyst.identify(dehyst.Recording(input=x, output=output), family="pi")
        assert words[overall(fit)] in fit.verdict
        seen.add(overall(fit))
        assert read(write_report(fit, tmp_path / "r.html")).faults == []
    assert {Grade.GOOD, Grade.BAD} <= seen


@pytest.mark.slow
def test_a_page_that_forbids_compensation_shows_no_line_that_does_it(fit, tmp_path):
    forbidden = replace(
        fit,
        verdict="pi, 9 of 20 operators: 9.39 % of range rms ...: do not compensate with it.",
        grade=Grade.BAD,
        warnings=(Finding("inverse-misses", "off by 7500 % of the range."),),
    )
    page = write_report(forbidden, tmp_path / "r.html", model_file="m.json")
    text = read(page).text
    assert 'class="verdict stop" id="verdict"' in page.read_text(encoding="utf-8")
    assert (
        "dehyst compensate" not in text
        and "inverse()" not in text
        and "dehyst simulate m.json" in text
    )
    assert overall(replace(forbidden, grade=None)) is Grade.BAD  # the rule says the same
    allowed = replace(fit, grade=Grade.CARE)
    assert overall(allowed) is Grade.CARE
    assert "dehyst compensate" in read(write_report(allowed, tmp_path / "r.html")).text


@pytest.mark.slow
def test_drawing_leaves_matplotlib_as_it_was(fit, tmp_path):
    import matplotlib

    before = dict(matplotlib.rcParams)
    write_report(fit, tmp_path / "r.html")
    assert dict(matplotlib.rcParams) == before
    assert fonts()[0] == "DejaVu Sans"


def test_importing_the_package_does_not_load_matplotlib():
    code = "import dehyst, dehyst.identification, sys; print('matplotlib' in sys.modules)"
    assert (
        subprocess.run([sys.executable, "-c", code], capture_output=True, text=True).stdout.strip()
        == "False"
    )


@pytest.mark.slow
def test_an_exploding_candidate_does_not_squash_the_others(fit, tmp_path):
    astray = ComparedSetting("stop", "zero", None, 7.5e5, 2e5)
    wild = replace(fit, candidates=(*fit.candidates, astray))
    assert astray in drawn_candidates(wild)
    assert reach(drawn_candidates(wild)) == pytest.approx(3.0 * 1.12)  # three times the chosen one
    figure = next(figure for figure in all_figures(wild) if figure.key == "candidates")
    assert "arrow" in figure.caption
    texts = letters_of(write_report(wild, tmp_path / "r.html"))
    assert {"1.12\xa0%", "1.12 %"} & set(texts) and any(
        "10⁵" in text or "750" in text for text in texts
    )
    near = [
        replace(c, error_percent=1.0 + 0.1 * k, uncertainty_percent=0.1)
        for k, c in enumerate(fit.candidates)
    ]
    assert reach(near) == pytest.approx(1.4)  # nothing cut
    assert reach([replace(near[0], error_percent=0.0), near[1]]) > 1.0


def test_a_share_of_a_range_above_one_is_said_in_ranges(fit):
    far = tuple(
        p + 75.4 * np.ptp(r.input)
        for p, r in zip(fit.inverse_predictions, fit.recordings, strict=True)
    )
    light = next(
        light
        for light in lights(replace(fit, inverse_predictions=far))
        if light.aspect == "Inverse"
    )
    assert "75 times its range" in light.reason and "e+" not in light.reason


def test_the_plays_of_the_play_figure_can_be_told_apart():
    for r in (
        np.arange(100) / 50,
        (np.arange(100) / 100) ** 2 * 2.0,
        np.r_[0.0, 0.002, 0.01, 0.05, 0.09, 0.35],
    ):
        core = PrandtlIshlinskii(r, np.ones(r.size))
        chosen = typical_thresholds(core, 2.0)
        assert 2 <= chosen.size <= 3 and chosen[0] == 0.0 and set(chosen) <= set(r)
        assert np.min(np.diff(chosen)) >= 0.06 * 2.0


def test_the_play_figure_uses_thresholds_of_the_model(fit):
    assert isinstance(fit.model, ModifiedPrandtlIshlinskii)
    figure = next(figure for figure in all_figures(fit) if figure.key == "play")
    named = [
        float(v) for v in re.findall(r"([\d.]+)\s*bar", figure.caption.replace("\xa0", " "))[1:]
    ]
    assert 2 <= len(named) <= 3
    for r in named:
        assert np.min(np.abs(fit.model.hysteresis.thresholds - r)) <= 0.005 * max(r, 1e-9) + 1e-12


@pytest.mark.slow
def test_a_home_that_cannot_be_written_is_not_the_user_s_concern(tmp_path):
    (tmp_path / "file").touch()
    done = subprocess.run(
        [sys.executable, "-c", "import dehyst.report"],
        env=os.environ
        | {"HOME": str(tmp_path / "file" / "home"), "XDG_CONFIG_HOME": "", "XDG_CACHE_HOME": ""},
        capture_output=True,
        text=True,
        timeout=600,
        check=True,
    )
    assert done.stdout + done.stderr == ""
