"""Trials of a joint alone: what the compensator takes away, one's own compensator, loads, unknown history."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from dehyst.errors import OutputError, ParameterError, SimulationError
from dehyst_robot.arm import Reference
from dehyst_robot.control import FLAGS, SWITCHES, InverseCompensator
from dehyst_robot.experiments import run_trial
from dehyst_robot.experiments._calibration import home, home_from_zero, refuse_failed
from dehyst_robot.experiments._identification import _played
from dehyst_robot.experiments._point import _unknown_history
from dehyst_robot.experiments._trials import LOG_S, trial_arm
from experiment_samples import (
    FASTER,
    PLANTS,
    equipment,
    folder,
    identified,
    path,
    rms,
    robot,
    trial,
)

LIMITS = {
    "fast": 0.50,
    "slow": 0.40,
    "slow_no_integrator": 0.25,
}  # rms with the compensator over rms without


@pytest.mark.slow
@pytest.mark.parametrize("name", LIMITS)
@pytest.mark.parametrize("mechanism", PLANTS)
def test_the_compensator_reduces_the_error_of_joint_1(mechanism, name):
    off, on = trial(name, "off", mechanism), trial(name, "paper", mechanism)
    assert rms(on) <= LIMITS[name] * rms(off)
    assert rms(off) > 0.05  # [deg]: there was something to reduce
    assert not off.compensation.any() and np.abs(on.compensation[:, 0]).max() > 0.05e5


@pytest.mark.slow
@pytest.mark.parametrize("compensator", ["off", "paper"])
def test_a_run_raises_no_flag_and_keeps_the_pressures(compensator):
    run = trial("fast", compensator)
    assert not run.flags.any()
    low, high = robot().controller.pressure_low, robot().controller.pressure_high
    assert low < run.pressure[:, 0].min() and run.pressure[:, 0].max() < high


@pytest.mark.slow
def test_switching_the_compensator_off_is_the_same_as_having_none():
    bare = replace(equipment(), compensators={})
    short = robot().with_changes(FASTER)
    runs = [run_trial(short, path(), e, "slow", "off", (1,))[0] for e in (bare, equipment())]
    assert np.array_equal(runs[0].angle, runs[1].angle)


@pytest.mark.slow
def test_printed_states_are_zero_after_the_homing():
    on = SWITCHES["position"] | SWITCHES["compensator"]
    at_zero = (np.zeros((101, 1)),) * 3
    reference = Reference.motion(0.01, at_zero, np.zeros((101, 1)), 3e5, on)
    identified(1)
    log = folder("maxwell-slip") / "identification_joint1.csv"
    inverse = _played(robot(), log, odd=True).model.pruned().compensator()
    printed = replace(equipment(), compensators={1: inverse})
    left = []
    for history in (home_from_zero, home):
        arm = trial_arm(robot().with_changes(FASTER), printed, "fast", (1,))
        history(arm, equipment().characteristics)
        assert arm.encoder_angles[0] != 0.0
        left.append(arm.run(reference, every_s=0.1).compensation)
    # Plays at zero say nothing at zero; those that are centred on the angle of the homing do.
    assert not left[0].any() and left[1].any()


@pytest.mark.slow
def test_the_torque_error_is_what_is_left_to_the_feedback():
    known = equipment().controllers[1]
    for compensator in ("off", "paper"):
        run = trial("slow_no_integrator", compensator)
        error = run.error[:, 0]
        rate = np.gradient(error, run.time)
        feedback = 3 * known.inertia * known.pole * (rate + known.pole * error)
        # They differ by the noise of the sensors. [Nm]
        assert np.std(run.torque_error[:, 0] + feedback) < 0.2
    off, on = trial("slow", "off"), trial("slow", "paper")
    assert np.std(on.torque_error[:, 0]) < 0.5 * np.std(off.torque_error[:, 0])
    assert not off.torque_error[:, 1:].any()  # the other joints are locked


@pytest.mark.slow
def test_columns_of_a_run_belong_together():
    run = trial("slow", "off")
    moving = path().timing.slower(robot().path.slow_factor)
    assert run.time.size == run.angle.shape[0] == run.flags.shape[0] == run.tool.shape[0]
    np.testing.assert_allclose(np.diff(run.time), LOG_S[1], rtol=1e-9)
    assert run.time[-1] == pytest.approx(moving.duration, abs=2 * LOG_S[1])
    np.testing.assert_allclose(run.tool_desired, moving.position(run.time), rtol=0, atol=1e-12)
    wanted = path().motion(moving, run.time)[0]
    np.testing.assert_allclose(run.desired[:, 0], wanted[:, 0], rtol=0, atol=1e-5)
    assert not run.angle[:, 1:].any()  # the other joints are locked
    assert run.cycle.max() == 0 and set(np.unique(run.figure)) == {-1, 0, 1, 2, 3}
    assert run.frames.shape[1:] == (8, 3) and run.frames.shape[0] == run.frame_time.size > 100


@pytest.mark.slow
def test_the_fast_trial_follows_the_path_as_often_as_asked_for():
    run = trial("fast", "off")
    assert run.cycle.max() == 1
    assert run.time[-1] == pytest.approx(2 * path().timing.duration, abs=0.05)
    half = np.searchsorted(run.time, path().timing.duration)
    later = np.interp(run.time[:half] + path().timing.duration, run.time, run.desired[:, 0])
    np.testing.assert_allclose(later, run.desired[:half, 0], rtol=0, atol=1e-4)


def short(name, compensator="paper", robot_changes=(), **changes):
    made = robot().with_changes({**FASTER, **dict(robot_changes)})
    return run_trial(made, path(), replace(equipment(), **changes), name, compensator, (1,))[0]


@cache
def without(name):
    return short(name, "off")


def own_inverse():
    return InverseCompensator(identified().compensator, shear=identified().shear * 1e5)


class Delegates:
    """The three methods and nothing else: no class of dehyst's."""

    def __init__(self, inner):
        self.inner, self.starts, self.angles, self.velocities = inner, [], [], []

    def reset(self, angle):
        self.starts.append(angle)
        self.inner.reset(angle)

    def step(self, angle, velocity):
        self.angles.append(angle)
        self.velocities.append(velocity)
        return self.inner.step(angle, velocity)

    def output(self):
        return self.inner.output()


@pytest.mark.slow
@pytest.mark.parametrize("name", LIMITS)
def test_a_compensator_of_ones_own_that_does_the_same_helps_as_much(name):
    built_in = rms(short(name)) / rms(without(name))
    own = rms(short(name, compensators={}, own={1: Delegates(own_inverse())})) / rms(without(name))
    assert own < LIMITS[name] and own == pytest.approx(built_in, rel=0.3)


@pytest.mark.slow
def test_a_compensator_of_ones_own_hears_the_whole_motion_from_the_homing_on():
    mine = Delegates(own_inverse())
    run = short("slow", compensators={}, own={1: mine})
    heard = np.array(mine.angles)
    assert mine.starts == [heard[0]]  # reset once, to where the homing ended
    assert np.array_equal(heard[:100], np.full(100, heard[0])) and abs(heard[0]) < np.radians(
        2
    )  # it rests first
    assert np.abs(np.diff(heard)).max() < np.radians(0.5)  # no step of the motion is left out
    assert (
        heard.max() >= run.desired[:, 0].max() - 1e-4
        and heard.min() <= run.desired[:, 0].min() + 1e-4
    )
    assert np.abs(mine.velocities).max() > 0.05


@pytest.mark.slow
def test_a_compensator_of_ones_own_is_not_asked_while_it_is_off():
    mine = Delegates(own_inverse())
    assert np.array_equal(short("slow", "off", own={1: mine}).angle, without("slow").angle)
    assert not mine.starts and not mine.angles


@pytest.mark.slow
def test_what_is_no_number_never_reaches_the_valves():
    class Broken(Delegates):
        def step(self, angle, velocity):
            return float("nan")

    with pytest.raises(OutputError, match="finite"):
        short("fast", own={1: Broken(own_inverse())})


@pytest.mark.slow
def test_a_load_that_nobody_told_the_controller_is_found_by_the_integrator():
    for load in (-20.0, 20.0):
        run = short("slow", "off", loads={1: load})
        change = run.integrator[:, 0].mean() - without("slow").integrator[:, 0].mean()
        assert change == pytest.approx(-load, abs=2.0)
        assert rms(short("slow", loads={1: load})) < 0.4 * rms(run)


@pytest.mark.slow
def test_without_integrator_a_load_stays_as_an_error_to_its_own_side():
    name = "slow_no_integrator"
    shift = [
        float(
            np.degrees(
                short(name, "off", loads={1: load}).error[:, 0].mean()
                - without(name).error[:, 0].mean()
            )
        )
        for load in (-20.0, 20.0)
    ]
    assert shift[0] > 2.0 and shift[1] == pytest.approx(-shift[0], rel=0.1)


@pytest.mark.slow
def test_an_unknown_history_costs_little_and_the_compensator_still_helps():
    for name, limit in LIMITS.items():
        known, unknown = short(name), short(name, history=_unknown_history)
        assert not np.array_equal(known.angle, unknown.angle)
        assert rms(known) < rms(unknown) * 1.02 and rms(unknown) < limit * rms(without(name))


@pytest.mark.slow
def test_the_same_equipment_gives_the_same_bits_and_another_seed_does_not():
    assert np.array_equal(short("fast", "off").angle, without("fast").angle)
    assert not np.array_equal(short("fast", "off", seed=1).angle, without("fast").angle)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"name": "quick"}, "fast, slow, slow_no_integrator"),
        ({"own": {3: object()}}, "own compensators for joint 3"),
        ({"own": {1: object()}}, "lacks reset"),
        ({"loads": {8: 1.0}}, "loads for joint 8"),
        ({"controllers": {}}, "joint 1 is pneumatic and has no controller"),
    ],
    ids=["trial", "electric joint", "no compensator", "no joint", "no controller"],
)
def test_what_cannot_be_is_refused(arguments, words):
    with pytest.raises(ParameterError, match=words):
        short(**{"name": "fast", **arguments})


@pytest.mark.slow
def test_a_controller_that_fails_safe_gives_no_figures():
    told = replace(equipment().controllers[1], pressure_jump=100.0)  # [Pa], less than the noise
    with pytest.raises(
        SimulationError, match=r"joint 1 failed safe at .*noise alone.*pressure_jump_bar"
    ) as caught:
        short("fast", "off", controllers={1: told})
    assert "angle_jump" not in str(caught.value)


@pytest.mark.slow
def test_an_encoder_that_stands_still_is_not_called_one_that_jumps():
    arm = trial_arm(robot(), equipment(), "fast", (1,))
    log = arm.run(Reference.pressures(0.01, *np.zeros((3, 30, 1))), every_s=0.01)
    log.measured[:] = 0.1
    log.flags[-1] = FLAGS["failed"] + FLAGS["angle-fault"]
    with pytest.raises(
        SimulationError, match=r"stood still for 400 samples .* raise controller.frozen_samples"
    ):
        refuse_failed(arm, log)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("flags", "words", "not_said"),
    [
        (
            ("angle-fault",),
            "its angle was further than .* raise controller.angle_jump_deg",
            "pressure 1",
        ),
        (("pressure-fault-2",), "pressure 2 changed by .*frozen_samples", "angle_jump"),
        (("angle-fault", "valve-limit"), "limits in 50 % .* oscillates, .*pole_1_s", "angle_jump"),
    ],
)
def test_a_failure_is_blamed_on_what_the_flags_of_its_joint_say(flags, words, not_said):
    arm = trial_arm(robot(), equipment(), "fast", (1,))
    log = arm.run(Reference.pressures(0.01, *np.zeros((3, 5, 1))), every_s=0.01)
    log.flags[2:] = FLAGS["failed"] + sum(FLAGS[name] for name in flags)
    log.flags[0] = FLAGS["valve-limit"]  # one of the two seconds before
    with pytest.raises(SimulationError, match=f"joint 1 failed safe.*{words}") as caught:
        refuse_failed(arm, replace(log, time=np.arange(len(log.time)) * 1.0))
    assert not_said not in str(caught.value)
