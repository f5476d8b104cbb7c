"""Figures of runs: what is a mean, what is JSON, and what a run's log holds."""

import json
import math
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import dehyst
from dehyst.errors import OutputError
from dehyst_robot.arm import load_robot
from dehyst_robot.control import FLAGS
from dehyst_robot.experiments import PlantResult, Reproduction, equip
from dehyst_robot.experiments._output import (
    MOST_ROWS,
    as_json,
    joint_figures,
    log_folder,
    mean_figures,
    plant_figures,
    trial_columns,
    write_trial,
)
from dehyst_robot.experiments._policy import POLICY
from dehyst_robot.experiments._results import TrialRun
from dehyst_robot.iso9283 import iso9283
from experiment_samples import equipment, identified, path, trial
from reproduction_samples import identification


def plant(*figures):
    return PlantResult("dahl", {}, (), dict(enumerate(figures)), 30.0)


@pytest.mark.slow
def test_joint_figures_are_rms_and_largest_error_in_degrees():
    run = trial("fast", "off")
    error = np.degrees(run.desired[:, 0] - run.angle[:, 0])
    found = joint_figures(run, 1)
    assert found["rms_deg"] == pytest.approx(
        math.sqrt(sum(e * e for e in error) / error.size), rel=1e-12
    )
    assert found["max_deg"] == max(abs(error))
    assert joint_figures(run, 3) == {"rms_deg": 0.0, "max_deg": 0.0}


def touched_run(contact_Nm, missed=None, flag="touched"):
    """A run of 100 samples with the flag up in 20 of them, when so much came that the model does not explain."""
    flags, contact = np.zeros((100, 7), dtype=np.int64), np.zeros((100, 7))
    flags[40:60, 0], contact[40:60, 0] = FLAGS[flag], contact_Nm
    none = np.zeros((100, 7))
    return TrialRun(
        "slow", "best", 0, np.arange(100.0), *[none] * 6, np.zeros((100, 7, 2)), *[np.zeros((100, 3))] * 2,
        np.zeros(100, dtype=np.int64), ("line",), np.zeros(100, dtype=np.int64), flags, contact=contact,
        hysteresis=none, offset=none, scale=none, missed=missed or {},
    )  # fmt: skip


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_contact_is_told_where_more_came_than_the_model_misses_by_itself(sign):
    limit = 1.5 * POLICY.beyond_model
    assert not touched_run(sign * 0.99 * limit, {1: 1.5}).warnings
    (told,) = touched_run(sign * 1.01 * limit, {1: 1.5}).warnings
    assert f"up to {1.01 * limit:.1f} Nm" in told and "in 20 % of the trial" in told
    assert "missed 1.5 Nm at most where nothing touched" in told and "a hand" in told
    # What another joint's model misses says nothing, nor does an unknown one.
    for missed in ({2: 100.0}, {}):
        (told,) = touched_run(sign * 0.6, missed).warnings
        assert "up to 0.6 Nm" in told and "it missed" not in told


def test_a_model_that_does_not_fit_is_told_whatever_it_missed():
    for flag in ("stale", "shifted"):
        assert len(touched_run(0.1, {1: 100.0}, flag).warnings) == 1


def test_what_a_compensator_misses_is_a_torque():
    found = identification("dahl", 1)
    hysteresis, inverse = found.unseen["hysteresis_bar"], found.unseen["inverse_bar"]
    angle, at = found.unseen["angle_rad"], found.characteristic
    torques = at.torque(angle, 3e5, 1e5 * hysteresis) - at.torque(angle, 3e5, 1e5 * inverse)
    assert found.missed == pytest.approx(np.abs(torques).max(), rel=1e-9)
    kit = equip(load_robot(), {1: at}, {1: found})
    assert kit.missed == {1: found.missed}
    # What is not switched on misses nothing.
    assert equip(load_robot(), {1: at}, {1: identification("none", 1)}).missed == {}


@pytest.mark.slow
def test_the_figures_of_a_plant_are_nested_as_promised_and_those_of_its_runs():
    runs = [trial("slow", name) for name in ("off", "paper")]
    motion = path().timing.slower(4.0)
    found = plant_figures({"paper": {1: identified()}}, runs, {"slow": motion}, (1,))
    joint = found["joints"]["1"]
    assert joint["identification"]["inverse_rms_ratio_unseen"] == identified().inverse_rms_ratio
    assert joint["identification"]["nonzero_weights"] == identified().nonzero_weights
    assert joint["trials"] == {"slow": {run.compensator: joint_figures(run, 1) for run in runs}}
    run = runs[0]
    assert found["tool"]["slow"]["off"] == iso9283(
        motion, run.time, run.tool, run.cycle, run.figure
    )
    json.dumps(found, allow_nan=False)


@given(st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=5))
def test_means_over_seeds_are_means(values):
    figures = [
        {"joints": {"1": {"trials": {"fast": {"off": {"rms_deg": value}}}}}} for value in values
    ]
    mean = mean_figures(plant(*figures))["joints"]["1"]["trials"]["fast"]["off"]["rms_deg"]
    assert mean == pytest.approx(sum(values) / len(values), rel=1e-9, abs=1e-9)


def test_what_a_seed_does_not_give_is_left_out_of_the_mean_and_nothing_becomes_none():
    figures = [
        {"RT_mm": value, "words": {"RT_mm": "why"}} for value in (1.0, None, float("nan"), 3.0)
    ]
    assert mean_figures(plant(*figures)) == {"RT_mm": 2.0, "words": {"RT_mm": "why"}}
    assert mean_figures(plant({"RT_mm": None}, {"RT_mm": None})) == {"RT_mm": None}
    assert mean_figures(plant({"RT_mm": float("nan")})) == {"RT_mm": None}


def test_what_only_some_seeds_have_is_not_lost():
    mean = mean_figures(plant({"reasons": {}}, {"reasons": {"RT_mm": "needs two cycles"}}))
    assert mean == {"reasons": {"RT_mm": "needs two cycles"}}


def test_accepted_means_accepted_for_every_seed():
    assert mean_figures(plant({"accepted": True}, {"accepted": False})) == {"accepted": False}
    assert mean_figures(plant({"accepted": True}, {"accepted": True})) == {"accepted": True}


def test_whole_numbers_stay_whole_where_the_mean_is():
    mean = mean_figures(plant({"nonzero_weights": 20, "x": 1}, {"nonzero_weights": 22, "x": 2}))
    assert mean == {"nonzero_weights": 21, "x": 1.5} and isinstance(mean["nonzero_weights"], int)


def test_json_holds_no_array_no_nan_and_every_seed():
    figures = [
        {"joints": {"1": {"rms_deg": np.float64(v)}}, "n": np.int64(3), "gap": float("nan")}
        for v in (1, 3)
    ]
    studies = {
        "rest": {"time_s": np.arange(3.0), "case": ["off", "on"], "hole": np.array([1.0, np.nan])}
    }
    slow = PlantResult("none", {}, (), {0: figures[0]}, 20.0)
    result = Reproduction(
        {"dahl": plant(*figures), "none": slow},
        "paper",
        {"seeds": (0, 1), "on": np.bool_(1)},
        studies,
    )
    told = json.loads(json.dumps(as_json(result), allow_nan=False))
    assert told["plants"]["dahl"]["joints"]["1"]["rms_deg"] == 2.0
    assert told["plants"]["dahl"]["seeds"]["1"]["joints"]["1"]["rms_deg"] == 3.0
    assert told["plants"]["dahl"]["seeds"]["0"]["gap"] is None and told["plants"]["dahl"]["n"] == 3
    assert told["real_time_factor"] == 20.0 and told["settings"] == {"seeds": [0, 1], "on": True}
    assert told["studies"]["rest"] == {
        "time_s": [0.0, 1.0, 2.0],
        "case": ["off", "on"],
        "hole": [1.0, None],
    }


@pytest.mark.slow
def test_a_run_comes_back_from_its_csv(tmp_path):
    run = trial("fast", "paper")
    write_trial(run, tmp_path, mcap=False)
    step = -(-run.time.size // MOST_ROWS)
    for number, what, values in (
        (1, "angle_deg", np.degrees(run.angle[:, 0])),
        (1, "pressure_1_bar", run.pressure[:, 0, 0] / 1e5),
        (1, "compensation_bar", run.compensation[:, 0] / 1e5),
    ):
        read = dehyst.read_log(
            tmp_path / "fast_paper.csv",
            input=f"joint{number}_desired_deg",
            output=f"joint{number}_{what}",
        )
        np.testing.assert_allclose(read.output, values[::step], rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(read.time, run.time[::step], rtol=0, atol=1e-9)


@pytest.mark.slow
def test_the_columns_of_a_log_carry_their_units_and_only_muscles_have_pressures():
    columns = trial_columns(trial("fast", "off"))
    units = ("_deg", "_bar", "_Nm", "_m")
    bare = re.compile(r"figure|cycle|joint\d_(hysteresis_of_model|scale(_\d)?)")
    assert all(name.endswith(units) or bare.fullmatch(name) for name in columns)
    assert "joint1_pressure_1_bar" in columns and "joint3_pressure_1_bar" not in columns
    assert len({values.shape for values in columns.values()}) == 1


@pytest.mark.slow
def test_a_folder_of_logs_that_cannot_be_made_is_a_named_error(tmp_path):
    (tmp_path / "file").write_text("mine")
    with pytest.raises(OutputError, match="file"):
        log_folder(tmp_path / "file", "dahl", 0)
    assert log_folder(tmp_path / "new", "dahl", 3).is_dir() and equipment().seed == 0
