"""Claims about the page of the paper's experiment in a real browser: desk, phone, dark, print, less motion."""

from __future__ import annotations

import re

import numpy as np
import pytest
from matplotlib.image import imread

from dehyst.robot.report import write_reproduction_report
from reproduction_samples import sample_reproduction
from test_report_browser import BROWSER, DESK, PHONE, browse, measured

pytestmark = pytest.mark.skipif(
    BROWSER is None,
    reason="no Chromium or Chrome found: install one (apt-get install chromium) to open the report in it",
)
NO_MOTION = "--force-prefers-reduced-motion"


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    result = sample_reproduction(("maxwell-slip", "none"))
    return write_reproduction_report(result, tmp_path_factory.mktemp("browser") / "report.html")


@pytest.fixture(scope="module")
def all_open(page):
    """The same page with every plant and table unfolded."""
    copy = page.with_name("open.html")
    copy.write_text(page.read_text(encoding="utf-8").replace("<details class", "<details open class"), encoding="utf-8")
    return copy


@pytest.mark.slow
@pytest.mark.parametrize("size", [DESK, PHONE], ids=["desk", "phone"])
def test_nothing_runs_over_the_edge_and_letters_can_be_read(all_open, tmp_path, size):
    found = measured(all_open, tmp_path, size=size)
    assert found["pixels"] == found["client"] == size[0]
    assert found["scroll"] <= found["client"]
    assert found["outside"] == [] and found["spill"] == []
    assert found["plots"] > 40 and found["smallest"] >= 9.0  # CSS pixels of the smallest letters in a figure


@pytest.mark.slow
def test_the_browser_has_no_complaint(page, tmp_path):
    seen = browse(page, tmp_path / "profile", "--dump-dom")
    assert seen.returncode == 0 and "</html>" in seen.stdout
    assert "CONSOLE" not in seen.stderr, seen.stderr


def picture(page, tmp_path, name, *arguments):
    shot = tmp_path / f"{name}.png"
    browse(page, tmp_path / name, f"--screenshot={shot}", *arguments, size=DESK)
    return imread(shot)[..., :3]


@pytest.mark.slow
def test_the_arm_moves_unless_the_reader_asked_for_less_motion(page, tmp_path):
    early, late = (picture(page, tmp_path, f"t{t}", f"--virtual-time-budget={t}") for t in (1000, 6000))
    assert np.mean(np.abs(early - late).max(axis=2) > 0.2) > 0.001
    for attempt in range(3):  # one browser in ten sets a line of letters a little differently; an arm never rests
        shots = [(f"s{t}-{attempt}", NO_MOTION, f"--virtual-time-budget={t}") for t in (1000, 6000)]
        early, late = (picture(page, tmp_path, *shot) for shot in shots)
        if np.array_equal(early, late):
            break
    assert np.array_equal(early, late)
    dark = np.sum(np.abs(early - early[0, 0]).max(axis=2) > 0.2)
    assert dark > 10_000  # the still picture is there instead


@pytest.mark.slow
def test_the_page_prints_what_is_open(page, all_open, tmp_path):
    sheets = []
    for file in (page, all_open):
        pdf = tmp_path / f"{file.stem}.pdf"
        browse(file, tmp_path / "profile", "--no-pdf-header-footer", f"--print-to-pdf={pdf}")
        sheets.append(len(re.findall(rb"/Type\s*/Page\b", pdf.read_bytes())))
    assert 6 <= sheets[0] <= 20 and sheets[1] >= sheets[0] + 4
