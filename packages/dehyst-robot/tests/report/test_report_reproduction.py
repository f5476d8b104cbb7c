"""Claims about the page of the paper's experiment: complete in itself, safe, its numbers those of the result."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from dataclasses import replace
from functools import reduce
from operator import getitem

import numpy as np
import pytest

from dehyst.errors import OutputError, ParameterError
from dehyst.findings import Grade
from dehyst.report._text import number
from dehyst_robot.experiments import PlantResult
from dehyst_robot.experiments._results import TRIALS
from dehyst_robot.report import WHY, write_reproduction_report
from dehyst_robot.report._arm import magnification, scene
from dehyst_robot.report._baseline import baseline, measured
from dehyst_robot.report._numbers import spread_over_seeds, tool_figures, trial_figure, trial_ratio
from dehyst_robot.report._overview import alone_figure
from dehyst_robot.report._studies import break_even
from dehyst_robot.report._tables import acceptance, largest_errors_table, limits_table
from dehyst_robot.report._words import error_tiles, lead
from places import ROOT
from report_samples import read
from reproduction_samples import plant_result, sample_reproduction

FIGURES = ["hysteresis", "play", "inverse", "inverse-others", "trials", "trials-others", "tool"]


@pytest.fixture(scope="module")
def result():
    return sample_reproduction(("maxwell-slip", "none"))


@pytest.fixture(scope="module")
def page(result, tmp_path_factory):
    logs = {"maxwell-slip, fast, off": ["logs/a.csv", "logs/a.mcap"]}
    return write_reproduction_report(
        result, tmp_path_factory.mktemp("reproduction") / "report.html", logs=logs
    )


@pytest.fixture(scope="module")
def one(tmp_path_factory):
    """One plant, one seed, one joint: the smallest page with everything."""
    result = sample_reproduction(("dahl",), (0,), (1,))
    return result, write_reproduction_report(result, tmp_path_factory.mktemp("one") / "report.html")


def sections(page):
    return read(page).ids("section")


def test_joints_that_moved_alone_have_a_table_of_their_own(one, tmp_path):
    plants, _ = one
    trials = {
        trial: {"off": {"rms_deg": 2.0, "max_deg": 4.0}, "paper": {"rms_deg": 0.3, "max_deg": 1.0}}
        for trial in TRIALS
    }
    alone = {
        name: PlantResult(name, {}, (), {0: {"joints": {"1": {"trials": trials}}}}, 1.0)
        for name in ("lugre", "my own")
    }
    figure = alone_figure(replace(plants, alone=alone), 1)
    assert [row[0] for row in figure.table.rows] == [
        f"{name}, joint 1, {words}"
        for name in ("lugre", "my own")
        for words in ("fast", "slow", "slow without integrator")
    ]
    assert {row[1:] for row in figure.table.rows} == {("2.00 | 4.00", "0.15 | 0.25")}
    assert "has the laws of lugre among its terms. lugre: a bristle of LuGre" in figure.caption
    page = write_reproduction_report(replace(plants, alone=alone), tmp_path / "report.html")
    assert "alone" in sections(page) and "Joint 1 alone on other plants" in read(page).text
    assert alone_figure(plants, 1) is None


@pytest.mark.slow
def test_all_figures_of_the_paper_are_there_for_every_plant(page):
    found = sections(page)
    assert {f"p{k}-{key}" for k in range(2) for key in FIGURES} <= set(found)
    assert {"arm", "overview", "rest", "harm", "about"} <= set(found)
    words = read(page).text
    assert all(f"Figure {number_} " in words for number_ in (3, 4, 5, 7, 8))
    pictures = [a for tag, a in read(page).elements if tag == "svg"]
    assert len(pictures) == 2 + 3 + 2 * 19 + 2 + 3  # arm, overview, plants, rest, harm
    assert all(a["role"] == "img" and len(a["aria-label"]) > 15 for a in pictures)


@pytest.mark.slow
def test_figure_7_shows_position_and_torque_error_of_every_trial(page):
    labels = [a["aria-label"] for tag, a in read(page).elements if tag == "svg"]
    shown = [label for label in labels if "error, torque error and integrator" in label]
    assert len(shown) == 2 * 3  # plants, trials
    assert "less what the measured pressures give" in read(page).text


@pytest.mark.slow
def test_the_first_plant_is_open_the_others_closed(page):
    plants = [a for tag, a in read(page).elements if tag == "details" and a.get("class") == "part"]
    assert [("open" in a) for a in plants] == [True, False]


@pytest.mark.slow
def test_every_number_of_the_trials_stands_in_the_tables(result, page):
    text = read(page).text
    for plant in result.plants.values():
        for joint in (1, 2, 4):
            for trial in TRIALS:
                for name in ("rms_deg", "max_deg"):
                    seeds = [f["joints"][joint]["trials"][trial] for f in plant.figures.values()]
                    for compensator in ("off", "paper"):
                        values = [seed[compensator][name] for seed in seeds]
                        mean, low, high = np.mean(values), min(values), max(values)
                        assert f"{number(mean)} ({number(low)}–{number(high)})" in text
                    ratios = [seed["paper"][name] / seed["off"][name] for seed in seeds]
                    if (
                        plant.plant != "none"
                    ):  # where nothing was switched on, a ratio of 1 would say nothing
                        assert (
                            f"{number(np.mean(ratios))} ({number(min(ratios))}–{number(max(ratios))})"
                            in text
                        )


@pytest.mark.slow
def test_every_figure_of_the_tool_stands_in_the_tables_with_its_unit(result, page):
    text = read(page).text
    for plant in result.plants.values():
        for trial in TRIALS:
            for compensator in ("off", "paper"):
                found = plant.figures[0]["tool"][trial][compensator]
                for table, *keys in (
                    (found,),
                    *((part, "figures", k) for k, part in found["figures"].items()),
                ):
                    for name, value in table.items():
                        if isinstance(value, float):
                            values = [
                                reduce(getitem, (trial, compensator, *keys, name), f["tool"])
                                for f in plant.figures.values()
                            ]
                            assert number(np.mean(values)) in text, (name, value)
    names = (
        "AT path accuracy",
        "RT path repeatability",
        "CR corner rounding",
        "CO corner overshoot",
    )
    assert all(f"{name} [mm]" in text and f"rectangle: {name} [mm]" in text for name in names)
    assert (
        "AV speed accuracy [%]" in text
        and "distance, rms [mm]" in text
        and "FV speed fluctuation [mm/s]" in text
    )
    assert (
        "No RT and RV in trials slow and slow without integrator: needs two cycles or more." in text
    )


@pytest.mark.slow
def test_the_headline_says_the_ratio_of_the_first_joint_in_the_slow_trial(one):
    result, page = one
    trials = result.plants["dahl"].figures[0]["joints"][1]["trials"]["slow"]
    share = 100 * trials["paper"]["rms_deg"] / trials["off"]["rms_deg"]
    text = read(page).text
    assert f"with over without compensator: dahl {share:.0f} %." in lead(result)
    assert lead(result) in text
    assert (
        f"{number(trials['off']['rms_deg'])}°" in text
        and f"{number(trials['paper']['rms_deg'])}°" in text
    )
    assert "seeds)" not in text  # one seed has no spread


def test_a_compensator_that_makes_it_worse_is_said_to(result):
    worse = plant_result("none", seeds=(0,), joints=(1,))
    joint = worse.figures[0]["joints"][1]
    joint["identification"]["accepted"] = True
    for trial in joint["trials"].values():
        trial["paper"] = {name: 3.0 * value for name, value in trial["off"].items()}
    said = lead(replace(result, plants={"none": worse}))
    assert said.endswith(": none 300 %.")


def test_the_largest_error_of_a_joint_is_shown_with_when_and_where_it_lies():
    plant = plant_result("maxwell-slip", seeds=(0,), joints=(1,))
    runs = list(plant.runs)
    k = next(i for i, run in enumerate(runs) if run.trial == "fast" and run.compensator == "paper")
    angle = runs[k].angle.copy()
    sample = int(np.flatnonzero(runs[k].figure == 1)[5])
    angle[sample, 0] += 1.0
    runs[k] = replace(runs[k], angle=angle)
    off = next(run for run in runs if run.trial == "fast" and run.compensator == "off")
    result = replace(
        sample_reproduction(("maxwell-slip",)), plants={"p": replace(plant, runs=tuple(runs))}
    )
    rows = {row[0]: row[1:] for row in largest_errors_table(result, result.plants["p"]).rows}
    error = number(float(np.rad2deg(abs(runs[k].error[sample, 0]))))
    without = number(float(np.rad2deg(abs(off.error[sample, 0]))))
    time = number(float(runs[k].time[sample] - runs[k].time[0]))
    assert rows["joint 1, fast"] == (error, without, time, runs[k].figures[1])


@pytest.mark.slow
def test_a_larger_largest_error_is_named_on_the_first_screen(tmp_path):
    plant = plant_result("maxwell-slip", seeds=(0,), joints=(1,))
    trial = plant.figures[0]["joints"][1]["trials"]["fast"]
    trial["paper"]["max_deg"] = 1.5 * trial["off"]["max_deg"]
    result = replace(sample_reproduction(("maxwell-slip",)), plants={"maxwell-slip": plant})
    text = read(write_reproduction_report(result, tmp_path / "r.html")).text
    assert (
        "The largest error of a joint grows with the compensator in 1 case: maxwell-slip, joint 1, fast (150 %)"
        in text
    )
    assert f"Why: {WHY}." in text


@pytest.mark.slow
def test_a_model_that_was_not_accepted_is_said_plainly_and_no_ratio_is_claimed(
    result, page, tmp_path
):
    text = read(page).text
    cells = acceptance(result).blocks[0].rows[1][1:]
    assert [(cell.badge, cell.grade) for cell in cells] == [("not accepted", Grade.CARE)] * 3
    share = 100 * np.mean(
        [
            f["joints"][2]["identification"]["unexplained_unseen"]
            for f in result.plants["none"].figures.values()
        ]
    )
    assert cells[1].text.startswith(f"{number(share)} % (") and cells[1].text in text
    assert lead(result).endswith(
        "On plant “none” the compensator stayed off: the model identified there was not accepted."
    ) and "100 %" not in lead(result)
    assert ("none", "model not accepted, compensator left off") in {
        (tile.name, tile.remark) for tile in error_tiles(result)[0]
    }
    assert "left off" in text and "“on” is without compensator too" in text
    assert "without; with it the same, left off" in page.read_text(
        encoding="utf-8"
    )  # one line instead of two
    only = replace(result, plants={"none": result.plants["none"]})
    alone = read(write_reproduction_report(only, tmp_path / "r.html")).text
    assert "the runs without and with it are the same" in alone and scene(only).sides == ("off",)
    assert "its studies compare runs without compensator" in alone and not {"rest", "harm"} & set(
        sections(tmp_path / "r.html")
    )


def test_the_errors_at_higher_gains_are_those_of_the_page_that_explains_them():
    page = (ROOT / "docs" / "explanation" / "gain-or-compensator.md").read_text(encoding="utf-8")
    for conditions in ("kind", "realistic"):
        assert len(measured(conditions)) >= 6
        for joint, pole, *cells in measured(conditions):
            named = f"**{pole}**, highest" if "." in pole else pole
            assert f"| {conditions} | {joint} | {named} | {' | '.join(cells)} |" in page


def test_gains_are_named_only_for_the_plant_they_were_measured_on(result):
    told = {"conditions": "realistic", "changes": {"path.cycles_fast": 2}}
    known = baseline(replace(result, settings=told))
    other = baseline(replace(result, settings=told | {"changes": {"joint.1.radius_m": 0.06}}))
    assert any(getattr(block, "rows", None) == measured("realistic") for block in known.blocks)
    assert "was not searched" in other.blocks[-1] and not any(
        hasattr(block, "rows") for block in other.blocks
    )


@pytest.mark.slow
def test_what_joints_met_is_said_on_the_first_screen_and_with_its_plant(tmp_path, result):
    dahl = replace(
        result.plants["none"], remarks=("seed 0, fast, off: lost, joint 1 went to 93 deg",)
    )
    page = write_reproduction_report(replace(result, plants={"none": dahl}), tmp_path / "r.html")
    words = read(page).text
    first = words.index("1 trial ended early and has no figures.")
    assert first < words.index("none, seed 0, fast, off: lost, joint 1 went to 93 deg")


def test_limits_and_faults_are_shown_with_trial_and_joint():
    plant = plant_result("dahl", seeds=(0,), joints=(1,))
    assert all(row[1:] == ("0", "0", "0") for row in limits_table(plant).rows)
    run = plant.runs[0]
    flags = run.flags.copy()
    flags[: len(flags) // 4, 3] = 32
    table = limits_table(replace(plant, runs=(replace(run, flags=flags), *plant.runs[1:])))
    assert table.rows[0] == ("fast, off", "0", "25 (4)", "0")


def test_break_even_lies_where_the_straight_line_passes_one():
    assert break_even(np.array([0.0, 0.5, 1.0]), np.array([2.0, 1.5, 0.5])) == pytest.approx(0.75)
    assert break_even(np.array([0.0, 1.0]), np.array([0.5, 0.4])) is None


@pytest.mark.slow
def test_a_page_without_studies_and_without_poses_leaves_those_parts_out(tmp_path):
    plant = plant_result("dahl", seeds=(0,), joints=(1,))
    still = tuple(
        replace(run, frames=np.zeros((0, 8, 3)), frame_time=np.zeros(0)) for run in plant.runs
    )
    result = replace(
        sample_reproduction(("dahl",), (0,), (1,)),
        plants={"dahl": replace(plant, runs=still)},
        studies={},
        settings={},
    )
    page = write_reproduction_report(result, tmp_path / "r.html")
    assert read(page).faults == []
    assert not {"arm", "rest", "harm", "studies"} & set(sections(page))
    assert "overview" in sections(page)


@pytest.mark.slow
def test_a_run_without_compensator_shows_what_there_is(tmp_path):
    result = sample_reproduction(("dahl",), (0,), (1,), compensators=("off",))
    page = write_reproduction_report(result, tmp_path / "r.html")
    reader = read(page)
    assert reader.faults == [] and "Without compensator, joint 1 is" in reader.text
    assert "p0-trials" in sections(page) and "p0-tool" in sections(page)


def test_an_unknown_study_becomes_a_table_and_a_missing_column_is_named(tmp_path):
    result = replace(
        sample_reproduction(("dahl",), (0,), (1,)), plants={}
    )  # a page of nothing but studies
    odd = {
        "payload <b>": {
            "mass_kg": np.array([0.0, 1.0]),
            "ratio_rms": np.array([0.2, 0.3]),
            "note": ["a", "b<i>"],
        }
    }
    text = read(write_reproduction_report(replace(result, studies=odd), tmp_path / "r.html")).text
    assert "payload <b>" in text and "b<i>" in text
    with pytest.raises(ParameterError, match="no column 'pole_1_s'"):
        write_reproduction_report(
            replace(result, studies={"high gains": {"ratio_rms": [1.0]}}), tmp_path / "r.html"
        )


@pytest.mark.slow
def test_figures_are_written_as_svg_and_png(one, tmp_path):
    result, _ = one
    plant = result.plants["dahl"]
    slow = tuple(run for run in plant.runs if run.trial == "slow")
    short = replace(
        result, plants={"dahl": replace(plant, runs=slow)}, studies={"rest": result.studies["rest"]}
    )
    write_reproduction_report(short, tmp_path / "r.html", figures=tmp_path / "figures")
    names = {path.name for path in (tmp_path / "figures").iterdir()}
    wanted = {
        "dahl-figure-3-hysteresis",
        "dahl-figure-5-inverse",
        "dahl-figure-7-trials",
        "overview",
        "rest",
    }
    assert {f"{name}.{ending}" for name in wanted for ending in ("svg", "png")} <= names
    for svg in (tmp_path / "figures").glob("*.svg"):
        ElementTree.fromstring(svg.read_bytes())
    with pytest.raises(OutputError):
        write_reproduction_report(replace(short, plants={}), tmp_path / "no" / "such" / "r.html")


def test_the_arm_moves_through_its_poses_and_a_still_picture_lies_beside_it(result):
    run = next(
        r
        for r in result.plants["maxwell-slip"].runs
        if r.trial == "slow" and r.compensator == "paper"
    )
    shown = scene(result)
    assert shown.sides == ("off", "on")
    for _, svg in shown.views:
        root = ElementTree.fromstring(svg)
        still = next(g for g in root if g.get("class") == "still")
        moving = next(g for g in root if g.get("class") == "moving")
        assert not list(still.iter("animate"))
        links = [line for line in moving.iter("polyline") if line.get("class") == "link"]
        for link in links:
            values = next(link.iter("animate")).get("values").split(";")
            assert len(values) == len(run.frames)
            assert len({len(value.split()) for value in values}) == 1
        assert {p.get("class") for p in still.iter("path")} == {"wanted", "trace off", "trace on"}


def test_the_close_up_shows_the_plane_of_the_path_true_to_scale(result):
    run = next(
        r
        for r in result.plants["maxwell-slip"].runs
        if r.trial == "slow" and r.compensator == "paper"
    )
    root = ElementTree.fromstring(scene(result).views[1][1])
    link = [line for line in root.iter("polyline") if line.get("class") == "link"][
        -1
    ]  # ends in the tool
    values = next(link.iter("animate")).get("values").split(";")
    drawn = np.array([[float(v) for v in value.split()[-1].split(",")] for value in values])
    up = np.array([-0.5, 0.0, 0.85]) / np.hypot(
        0.5, 0.85
    )  # the sample's path lies in the plane of y and this
    flat = np.column_stack(
        [run.frames[:, 7] @ [0, 1, 0], -run.frames[:, 7] @ up]
    )  # seen from before the arm
    scale = np.ptp(drawn, axis=0) / np.ptp(flat, axis=0)
    assert scale[0] == pytest.approx(scale[1], rel=0.01)
    assert np.allclose(drawn - drawn[0], scale[0] * (flat - flat[0]), atol=1.5)


def test_the_magnification_is_round_and_keeps_errors_small_against_the_path(result):
    runs = [r for r in result.plants["maxwell-slip"].runs if r.trial == "slow"]
    factor = magnification(runs)
    assert factor in {m * 10.0**e for e in range(4) for m in (1, 2, 5)}
    tiny = [replace(r, tool=r.tool_desired + 0.01 * (r.tool - r.tool_desired)) for r in runs]
    assert 40 * factor <= magnification(tiny) <= 250 * factor
    assert magnification([replace(r, tool=r.tool_desired) for r in runs]) == 1.0


def test_the_spread_is_taken_seed_by_seed(result):
    plant = result.plants["maxwell-slip"]
    found = trial_ratio(plant, 1, "slow", "paper", "rms_deg")
    trials = [f["joints"][1]["trials"]["slow"] for f in plant.figures.values()]
    ratios = [t["paper"]["rms_deg"] / t["off"]["rms_deg"] for t in trials]
    assert (found.mean, found.low, found.high) == pytest.approx(
        (np.mean(ratios), min(ratios), max(ratios))
    )
    assert (
        trial_figure(plant, 3, "slow", "off", "rms_deg") is None and spread_over_seeds([]) is None
    )


def test_figures_read_back_from_json_are_the_same(result):
    import json

    plant = result.plants["maxwell-slip"]
    again = replace(
        plant, figures={seed: json.loads(json.dumps(f)) for seed, f in plant.figures.items()}
    )
    assert trial_figure(again, 1, "fast", "off", "rms_deg") == trial_figure(
        plant, 1, "fast", "off", "rms_deg"
    )
    assert tool_figures(again, "fast", "off") == tool_figures(plant, "fast", "off")


@pytest.mark.slow
def test_four_plants_with_long_logs_make_a_page_of_bounded_size(tmp_path):
    page = write_reproduction_report(sample_reproduction(), tmp_path / "r.html")
    assert page.stat().st_size < 6e6


@pytest.mark.slow
def test_several_compensators_stand_side_by_side_in_pictures_and_then_in_a_table(tmp_path):
    result = sample_reproduction(("dahl",), (0,), (1,), compensators=("off", "paper", "creep"))
    result = replace(result, compensator="creep", compensators=("paper", "creep"), studies={})
    reader = read(write_reproduction_report(result, tmp_path / "several.html"))
    assert reader.faults == []
    page = (tmp_path / "several.html").read_text(encoding="utf-8")
    assert (
        0
        < page.index('id="compared"')
        < page.index("Each compensator against none")
        < page.index('id="p0"')
    )
    found = result.plants["dahl"].figures[0]["joints"][1]["trials"]["slow"]
    share = found["creep"]["rms_deg"] / found["off"]["rms_deg"]
    assert (
        f"{float(f'{share:.2g}'):g}" in reader.text
        and "What each compensator leaves over" in reader.text
    )
