"""Direct inverses as compensators of a joint: from the written log, in the controller, with what a path teaches."""

from dataclasses import replace
from functools import cache
from pathlib import Path
from tempfile import mkdtemp

import numpy as np
import pytest

import dehyst
from dehyst.errors import ParameterError
from dehyst_robot.arm import load_robot
from dehyst_robot.experiments import SPACING, equip, run_trial
from dehyst_robot.experiments import _trials as trials
from dehyst_robot.experiments._identification import identify_compensators, motion_of, unsheared
from dehyst_robot.experiments._recipes import NAMES, RECIPES, recipe
from dehyst_robot.experiments._trials import learned_torque, learned_trial
from experiment_samples import QUICK, calibrated, path, rms, robot, same_bits

SHORT = {
    "identification.strokes_s": [3.0, 8.0], "identification.rests_s": [1.0, 12.0], "identification.sample_s": 0.05,
}  # fmt: skip


@cache
def short(mechanism="maxwell-slip"):
    return robot(mechanism).with_changes(SHORT)


@cache
def folder(mechanism):
    return Path(mkdtemp(prefix="dehyst-"))


@cache
def identified(mechanism="maxwell-slip"):
    names = ("paper", "direct", "creep", "adaptive") if mechanism == "maxwell-slip" else ("creep",)
    wanted = {name: (recipe(name), calibrated(1, mechanism)) for name in names}
    return identify_compensators(short(mechanism), 1, wanted, folder(mechanism))


@cache
def equipment(name, mechanism="maxwell-slip"):
    found = identified(mechanism)[name]
    return equip(
        short(mechanism), {1: calibrated(1, mechanism)}, {1: found}, adaptive=recipe(name).adaptive
    )


@cache
def trial(name, compensator, mechanism="maxwell-slip"):
    kit = equipment("creep" if compensator == "off" else compensator, mechanism)
    return run_trial(short(mechanism), path(), kit, name, compensator, (1,))[0]


@pytest.mark.slow
def test_creep_leaves_a_tenth_of_the_slow_error_and_less_than_the_paper():
    off, paper, creep = (rms(trial("slow", name)) for name in ("off", "paper", "creep"))
    assert creep < 0.10 * off and creep < 0.7 * paper


@pytest.mark.slow
def test_it_explains_unseen_loops_to_a_tenth_of_their_hysteresis():
    found = identified()["creep"]
    assert found.accepted and found.inverse_rms_ratio < 0.10
    measured, said = (found.unseen[f"{name}_bar"] for name in ("hysteresis", "inverse"))
    assert found.inverse_rms_ratio == pytest.approx(
        np.sqrt(np.mean((measured - said) ** 2) / np.mean(measured**2))
    )


@pytest.mark.slow
def test_the_model_is_that_of_the_written_log():
    found = identified()["creep"]
    log = folder("maxwell-slip") / "identification_joint1_rates.csv"
    read = dehyst.read_log(log, input="sheared_torque_Nm", output="angle_rad", time="time_s")
    settings = {
        "creep_times": recipe("creep").time_constants,
        "initial_state": "rest",
        "train_fraction": 1.0,
    }
    again = dehyst.identify(read, "direct-inverse", **settings).model
    assert np.array_equal(again.stop_weights, found.fit.model.stop_weights)
    q, t = found.unseen["angle_rad"], found.unseen["time_s"]
    k = calibrated().stiffness(3e5)
    np.testing.assert_allclose(
        again.run(q, t).u - k * q, found.direct.run(q, t).u, rtol=0, atol=1e-9
    )


@pytest.mark.slow
def test_the_torque_is_what_the_muscles_gave_beyond_the_known_load():
    log, c = identified()["creep"].log, calibrated()
    value = np.polynomial.polynomial.polyval
    q, p, dp = (
        log["angle_rad"],
        1e5 * log["mean_pressure_bar"],
        1e5 * log["pressure_difference_bar"],
    )
    inside = (q > c.low) & (q < c.high)
    given = value(q, c.a) * p + value(q, c.b) * dp + value(q, c.c)  # joint 1 carries no weight
    np.testing.assert_allclose(given[inside], log["torque_Nm"][inside], rtol=0, atol=1e-9)


@pytest.mark.slow
def test_compensators_with_the_same_motions_share_log_and_fit():
    found = identified()
    written = {file.name for file in folder("maxwell-slip").glob("identification*.csv")}
    assert written == {"identification_joint1.csv", "identification_joint1_rates.csv"}
    assert found["creep"] is found["adaptive"] and found["paper"] is not found["direct"]
    assert found["paper"].log is found["direct"].log


@pytest.mark.slow
def test_without_hysteresis_loops_of_creep_are_explained_and_yet_not_compensated():
    found = identified("none")["creep"]
    assert found.inverse_rms_ratio < 0.5 < found.unexplained and not found.accepted
    assert not equipment("creep", "none").compensators
    assert identified()["creep"].unexplained < 0.25


@pytest.mark.slow
def test_an_adaptive_compensator_is_as_good_as_the_one_that_does_not_learn():
    assert rms(trial("slow", "adaptive")) < 1.3 * rms(trial("slow", "creep"))
    assert set(equipment("adaptive").adaptations) == {1} and not equipment("creep").adaptations


@pytest.mark.slow
def test_learning_along_the_path_halves_the_error_and_what_is_kept_is_never_worse():
    first = trial("slow", "creep")
    best, _ = learned_trial(short(), path(), equipment("creep"), "slow", "ilc", (1,), passes=2)
    assert rms(best) < 0.5 * rms(first)
    assert np.abs(best.error[:, 0]).max() <= np.abs(first.error[:, 0]).max()


@pytest.mark.slow
def test_passes_that_make_it_worse_are_dropped(monkeypatch):
    first = trial("slow", "creep")
    monkeypatch.setattr(trials, "learned_torque", lambda *_: np.array([0.0, 8.0, 0.0]))
    best, _ = learned_trial(short(), path(), equipment("creep"), "slow", "creep", (1,), passes=1)
    assert same_bits(best, first)  # the first pass, and it was not touched


@pytest.mark.slow
def test_the_learned_torque_of_a_known_disturbance_is_that_disturbance():
    """The error that a torque d(t) leaves in the position law, integrated in closed form: d is given back."""
    run, controller = trial("slow", "creep"), equipment("creep").controllers[1]
    t, pole, inertia = run.time, controller.pole, controller.inertia
    w = 2 * np.pi * 0.2
    transfer = 1j * w / (inertia * (1j * w + pole) ** 3)  # of e over d, with integrator
    error = (transfer * np.exp(1j * w * t)).real
    held = (inertia * pole**3 * transfer / (1j * w) * np.exp(1j * w * t)).real
    made = replace(
        run,
        angle=run.desired - np.eye(7)[0] * error[:, None],
        integrator=np.eye(7)[0] * held[:, None],
    )
    fine = load_robot(conditions="kind", changes={**QUICK, "sensors.encoder_bits": 24})
    torque = learned_torque(fine, made, controller, 1)
    knots = np.linspace(0.0, t[-1] + t[1] - t[0], torque.size)
    inside = (knots > 1.0) & (knots < knots[-1] - 1.0)
    np.testing.assert_allclose(torque[inside], np.cos(w * knots)[inside], rtol=0, atol=0.02)


def test_a_sheared_model_less_its_shear_is_the_torque():
    model = dehyst.models.DirectInverse(
        radii=[0.2], stop_weights=[3.0], polynomial=[1.0, 50.0, 0.5], center=0.1
    )
    t = np.linspace(0.0, 5.0, 101)
    q = 0.4 * np.sin(t)
    bare = unsheared(model, 60.0, -30.0, 30.0).run(q, t).u
    np.testing.assert_allclose(bare, model.run(q, t).u - 60.0 * q, rtol=0, atol=1e-12)


def test_the_motions_of_several_rates_begin_with_the_loops():
    loops, rates = (motion_of(short(), 1, log) for log in ("loops", "rates"))
    assert np.array_equal(rates[: loops.size], loops) and rates.size > loops.size
    rest = np.diff(np.flatnonzero(np.diff(rates) != 0)).max() * SPACING
    assert rest == pytest.approx(12.0, abs=0.5)


def test_as_many_strokes_as_rests_are_asked_for():
    odd = short().with_changes({"identification.rests_s": [1.0]})
    with pytest.raises(ParameterError, match="strokes_s has 2 values and rests_s 1"):
        motion_of(odd, 1, "rates")


def test_every_recipe_has_a_name_and_says_what_it_is():
    known = (
        "paper",
        "literal",
        "printed",
        "scaled",
        "direct",
        "creep",
        "scheduled",
        "adaptive",
        "ilc",
        "maxwell-slip",
        "best",
    )
    assert known == NAMES
    assert all(one.summary and one.family in ("pi", "direct-inverse") for one in RECIPES.values())
