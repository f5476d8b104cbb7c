"""Claims about the tabs that teach and that play the arm, in Chromium, from the file."""

from __future__ import annotations

import base64
import gzip
import json
import re

import numpy as np
import pytest

from places import STUDIO
from test_page import Opened, chromium  # noqa: F401 - a fixture

pytestmark = pytest.mark.slow
ARM = json.loads((STUDIO / "page" / "src" / "arm.json").read_text(encoding="utf-8"))


@pytest.fixture
def opened(chromium):  # noqa: F811
    made = Opened(chromium)
    yield made
    assert made.complaints == []
    made.context.close()


def move(page, slider, value):
    slider.evaluate(
        "(e, v) => { e.value = v; e.dispatchEvent(new Event('input', {bubbles: true})); }", value
    )


def number(text):
    return float(text.replace("\N{MINUS SIGN}", "-"))


def test_a_play_moved_by_hand_remembers_as_the_formula_says(opened):
    page = opened.page
    page.click("#tab-teach")
    lesson = page.locator(".lesson").first
    r, z, last = 0.35, 0.0, 0.0
    for target in (0.8, -0.2, 0.5, -1.0, -0.4):
        move(page, lesson.locator("input[type=range]").first, target)
        for x in np.linspace(last, target, 50):
            z = max(x - r, min(x + r, z))
        last = target
        found = re.search(r"x = (\S+), z = (\S+):", lesson.locator("[role=status]").inner_text())
        assert number(found[1]) == pytest.approx(target) and number(found[2]) == pytest.approx(
            z, abs=1e-3
        )


def test_the_inverse_on_the_page_leaves_nothing_but_rounding_and_less_of_it_leaves_more(opened):
    page = opened.page
    page.click("#tab-teach")
    lesson = page.locator(".lesson").last
    said = lesson.locator("[role=status]")
    assert "no more than rounding" in said.inner_text()
    lesson.get_by_role("checkbox").uncheck()
    without = number(re.search(r"by (\S+) %", said.inner_text())[1])
    lesson.get_by_role("checkbox").check()
    move(page, lesson.locator("input[type=range]"), 0.8)
    part = number(re.search(r"by (\S+) %", said.inner_text())[1])
    assert 0.2 < part < without / 2  # an actuator with four fifths of the hysteresis


def unpacked(trial, at, data):
    """Columns of one trial from byte `at` on, and where they end: pose, desired, tool, then errors a compensator."""
    step = ARM["steps"]
    sizes = [step["pose"]] * 9 + [step["angle"]] * trial["joints"] + [step["place"]] * 3
    sizes += 3 * ([step["error"]] * trial["joints"] + [step["miss"]] * 3)
    columns = []
    for size in sizes:
        level, values = 0, []
        for _ in range(trial["samples"]):
            code = shift = 0
            while True:
                byte = data[at]
                at += 1
                code |= (byte & 127) << shift
                shift += 7
                if byte < 128:
                    break
            level += -(code + 1) // 2 if code & 1 else code // 2
            values.append(level * size)
        columns.append(values)
    return np.array(columns), at


def test_the_arm_shows_every_joints_error_at_every_moment(opened):
    data, at, trials = gzip.decompress(base64.b64decode(ARM["data"])), 0, []
    for trial in ARM["trials"]:
        columns, at = unpacked(trial, at, data)
        trials.append(columns)
    assert at == len(data) and len(ARM["data"]) < 60_000
    page = opened.page
    page.click("#tab-arm")
    page.wait_for_selector("table.errors tbody tr")
    for k in (0, 2):
        page.locator("#panel-arm select").first.select_option(str(k))
        sample = ARM["trials"][k]["samples"] // 3
        move(page, page.locator("#panel-arm input[type=range]").first, sample)
        joints = ARM["trials"][k]["joints"]
        for j in range(joints):
            cells = page.locator("table.errors tbody tr").nth(j + 1).locator("td").all_inner_texts()
            for kind, name in enumerate(("off", "paper", "best")):
                error = trials[k][9 + joints + 3 + kind * (joints + 3) + j, sample]
                assert number(cells[2 * kind]) == pytest.approx(error, abs=0.0051)
                assert number(cells[2 * kind + 1]) == pytest.approx(
                    ARM["trials"][k]["rms"][name][j], abs=0.0051
                )


def test_figure_and_table_of_the_arm_are_of_one_moment_from_the_beginning(opened):
    page = opened.page
    page.click("#tab-arm")
    page.wait_for_selector("table.errors tbody tr")
    for joint in (4, 1):
        page.get_by_label("Figure of").select_option(f"joint {joint}")
        page.wait_for_timeout(300)
        time, *figure = page.locator("#panel-arm .u-legend .u-value").all_inner_texts()
        assert number(time) == 0.0
        cells = page.locator("table.errors tbody tr").nth(joint).locator("td").all_inner_texts()
        assert [number(cells[k]) for k in (0, 2, 4)] == pytest.approx(
            [number(v) for v in figure], abs=0.0051
        )


@pytest.mark.parametrize("width", [375, 320])
def test_on_a_phone_no_tab_and_no_column_of_the_arms_table_is_cut(chromium, width):  # noqa: F811
    made = Opened(chromium, viewport={"width": width, "height": 700})
    made.page.click("#tab-arm")
    made.page.wait_for_selector("table.errors tbody tr")
    cut = "[document.getElementById('tabs'), document.documentElement].map((e) => e.scrollWidth - e.clientWidth)"
    assert made.page.evaluate(cut) == [0, 0]
    ends = (
        "[...document.querySelectorAll('[role=tab]')].map((e) => e.getBoundingClientRect().right)"
    )
    assert max(made.page.evaluate(ends)) <= width
    if width == 375:
        table = "(([e]) => e.scrollWidth - e.clientWidth)([document.querySelector('.errors').parentElement])"
        assert made.page.evaluate(table) <= 0
    made.close()
