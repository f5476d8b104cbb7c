"""Rivals of the compensators: each does what its law says, and the table holds every rival on every draw."""

import sys
from collections import defaultdict
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import dehyst
from dehyst_robot.arm import load_robot
from dehyst_robot.control import JointControllerParameters, JointReference, Reading
from dehyst_robot.experiments import equip, nominal_characteristic, plan_path, run_trial
from places import ROOT

sys.path.insert(0, str(ROOT / "benchmarks"))
sys.path.insert(0, str(ROOT / "docs"))

from generate import rivals as tables
from studies.learned_feedforward import PROCESSES, features, gaussian_process
from studies.rival_laws import (
    INTEGRATOR,
    POSITION,
    AdaptedScale,
    Around,
    DisturbanceObserver,
    PredictiveController,
)

PARAMETERS = JointControllerParameters()
BOTH = POSITION | INTEGRATOR
MEAN = 3e5


@pytest.fixture(scope="module")
def joint():
    robot = load_robot(changes={"path.cycles_fast": 1, "homing.cycles": 3})
    return robot, plan_path(robot), equip(robot, {1: nominal_characteristic(robot, 1)}, {})


def rms(joint, law=None):
    robot, path, equipment = joint
    if law is not None:
        equipment = replace(equipment, laws={1: law(equipment.controllers[1])})
    run, _ = run_trial(robot, path, equipment, "fast", "off", moving=(1,))
    return float(np.degrees(np.sqrt(np.mean(run.error[:, 0] ** 2))))


@pytest.mark.slow
def test_around_alone_is_the_controller_in_the_loop_and_a_disturbance_observer_halves_its_error(
    joint,
):
    off = rms(joint)
    assert rms(joint, lambda p: Around(p, BOTH)) == pytest.approx(off, rel=0.05)
    assert rms(joint, lambda p: DisturbanceObserver(p, BOTH, 10.0)) < 0.5 * off


@pytest.mark.slow
def test_a_faster_predictive_controller_errs_less(joint):
    slow, fast = (rms(joint, lambda p, w=w: PredictiveController(p, BOTH, w)) for w in (8.0, 16.0))
    assert fast < 0.5 * slow


@pytest.mark.parametrize("error", [-0.4, 0.4])
def test_a_predictive_controller_keeps_the_pressures_in_their_range(error):
    law = PredictiveController(PARAMETERS, BOTH, 60.0)
    reading = Reading(0.0, MEAN, MEAN)
    law.reset(reading, PARAMETERS.period)
    for _ in range(400):
        law.step(reading, JointReference(angle=error, mean_pressure=MEAN))
    room = 2.0 * min(MEAN - PARAMETERS.pressure_low, PARAMETERS.pressure_high - MEAN)
    assert np.sign(law.wish) == np.sign(error)
    assert law.feedforward + law.wish / law.slope == pytest.approx(np.sign(error) * room, rel=1e-3)


def test_an_adapted_scale_finds_half_of_the_torque_that_the_model_has():
    law = AdaptedScale(PARAMETERS, BOTH, 2.0)
    flat = [0.0] * 14
    for k in range(40_000):
        t = PARAMETERS.period * k
        extra = 2e4 * np.sin(t)
        reference = JointReference(velocity=0.1, extra=extra)
        # What the observer would show of half of the term, behind its lags.
        output = list(flat)
        output[10] = 0.5 * PARAMETERS.b[0] * 2e4 * np.sin(t - 3.0 / PARAMETERS.observer_pole)
        law.learn(reference, output)
    assert law.scale == pytest.approx(0.5, abs=0.02)
    assert law.offset == pytest.approx(0.0, abs=0.1)


def test_features_of_the_way_do_not_know_the_speed_and_those_of_time_do():
    t = np.linspace(0.0, 20.0, 4001)
    angle = 0.4 * np.sin(t)
    for name, same in (("8 ways, 3 turns", True), ("8 times", False)):
        once, slower = (features(PROCESSES[name], angle, times) for times in (t, 5.0 * t))
        assert np.allclose(once, slower, atol=1e-6) == same


@pytest.mark.slow
def test_a_gaussian_process_learns_a_play_and_is_cut_where_the_log_ends():
    pytest.importorskip(
        "sklearn", reason="scikit-learn is not installed: pip install --group bench"
    )
    t = np.linspace(0.0, 60.0, 1500)
    angle = 0.4 * np.sin(t) * (1.0 - 0.5 * t / t[-1])
    loop = dehyst.PrandtlIshlinskii([0.0, 0.05], [0.0, 1.0]).simulate(angle) - angle
    log = {"angle_rad": angle, "time_s": t, "hysteresis_bar": loop}
    learned = gaussian_process(SimpleNamespace(log=log), "8 ways")
    term = 1e-5 * learned.over(angle, np.zeros(t.size), t)
    assert np.sqrt(np.mean((term - loop) ** 2)) < 0.2 * np.std(loop)
    far = 1e-5 * learned.over(100.0 * angle, np.zeros(t.size), t)
    assert np.abs(far).max() <= 1.5 * np.abs(loop).max() * (1 + 1e-9)


def test_every_rival_was_run_on_every_draw_and_a_lost_trial_says_why():
    seen = defaultdict(set)
    for row in tables.rows():
        assert bool(row["rms_mdeg"]) != bool(row["failed"])
        if row["draw"] != tables.TUNING:
            seen[row["joint"], row["draw"]].add((row["rival"], row["trial"]))
    wanted = {(name, trial) for name in tables.TITLES for trial in tables.TRIALS}
    assert seen
    assert all(there == wanted for there in seen.values())


def test_rivals_with_a_number_to_choose_had_five_tries():
    tries = defaultdict(set)
    for row in tables.rows():
        if row["draw"] == tables.TUNING:
            tries[row["joint"], row["rival"]].add(row["setting"])
    assert tries
    assert {len(settings) for settings in tries.values()} == {5}


def ratio(joint, name, trial, other):
    return np.array(tables.ratios_to(tables.cells_of(joint), name, trial, other))


def wins(joint, name, trial):
    values = ratio(joint, name, trial, "best")
    assert values.size == 20
    return int(np.sum(values < 1.0))


JOINTS = ("1", "2", "4")
MOVING = ("fast", "slow", "moves")


@pytest.mark.parametrize("joint", JOINTS)
def test_gains_win_at_the_papers_pole_and_best_at_the_highest_one_as_the_page_says(joint):
    for name in ("sliding-mode", "one-valve", "predictive"):
        assert wins(joint, name, "slow") >= 17
        assert wins(joint, name, "moves") >= 16
    for name in tables.TITLES:
        if name in ("best at that pole", "iterative learning over best"):
            continue
        for trial in (*MOVING, "slow_no_integrator"):
            assert np.median(ratio(joint, name, trial, "best at that pole")) > 1.0
    for name in ("sliding-mode", "one-valve", "pid", "predictive"):
        assert np.median(ratio(joint, name, "slow_no_integrator", "off")) > 0.09


@pytest.mark.parametrize("joint", JOINTS)
def test_what_the_page_says_of_learning_is_in_the_file(joint):
    for trial in MOVING:
        assert 0.2 < np.median(ratio(joint, "iterative learning over best", trial, "best")) < 0.55
    for name in ("gaussian process", "recurrent network"):
        for trial in tables.TRIALS:
            assert 1.15 < np.median(ratio(joint, name, trial, "best")) < 3.05


@pytest.mark.parametrize("joint", JOINTS)
def test_best_errs_less_than_the_papers_compensator_on_nearly_every_draw(joint):
    assert wins(joint, "paper", "fast") == 0
    for trial in ("slow", "slow_no_integrator", "moves"):
        assert wins(joint, "paper", trial) <= 3


@pytest.mark.parametrize("joint", JOINTS)
def test_best_leaves_more_than_a_fifth_of_off_on_pinched_muscles_only(joint):
    cells = tables.cells_of(joint)
    for draw in tables.draws_of(cells, "off"):
        if "pinched" in cells["off", "fast", draw]["plant"]:
            continue
        assert tables.ratios_in(cells, [draw], "fast", "off")[0] < 0.2
