"""The closed loop of the arm: deterministic, thread-safe, convergent, within limits; against one stepped by hand."""

import gc
import itertools
import re
import weakref
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import mujoco
import numpy as np
import pytest

from dehyst.errors import ParameterError, SimulationError
from dehyst_robot import _native
from dehyst_robot.arm import Arm, Reference, arm_model, load_robot, pneumatic_joint_parameters
from dehyst_robot.control import FLAGS, JointController, JointReference
from experiment_samples import ALL_JOINTS, HOLDS, arm, controllers, same_bits, swing
from plant_oracles import MaxwellSlip


def swung(moving=ALL_JOINTS, seed=0, **changes):
    made = arm(moving, seed, **changes)
    return made.run(swing(made), 0.01)


@pytest.mark.parametrize("moving", [(1,), (4,), (1, 2, 4), ALL_JOINTS], ids=str)
def test_the_same_seed_gives_the_same_bits_and_another_one_does_not(moving):
    assert same_bits(swung(moving), swung(moving))
    assert not np.array_equal(swung(moving).angle, swung(moving, seed=1).angle)


@pytest.mark.parametrize(
    "same",
    [{"tolerance__force": 0.0, "tolerance__hysteresis": 0.0}, {"sensors__pressure_noise_bar": 0.0}],
    ids=str,
)
def test_the_seed_draws_the_noise_as_well_as_the_muscles(same):
    assert not np.array_equal(swung((1,), **same).pressure, swung((1,), seed=1, **same).pressure)
    both = {
        "tolerance__force": 0.0,
        "tolerance__hysteresis": 0.0,
        "sensors__pressure_noise_bar": 0.0,
    }
    assert same_bits(swung((1,), **both), swung((1,), seed=1, **both))


def test_a_reset_arm_runs_as_a_new_one():
    made = arm()
    first = made.run(swing(made), 0.01)
    made.reset()
    assert same_bits(first, made.run(swing(made), 0.01))


@pytest.mark.slow
def test_two_arms_at_the_same_time_in_two_threads_give_the_bits_of_each_alone():
    alone = [swung(seed=seed) for seed in range(4)]
    with ThreadPoolExecutor(2) as pool:
        together = list(pool.map(lambda seed: swung(seed=seed), range(4)))
    assert all(same_bits(a, b) for a, b in zip(alone, together, strict=True))


def by_hand(robot, number, reference, steps):
    """One joint's closed loop in Python, period after period: angles, valves and desired pressures. No sensor noise.

    Shares with `Arm` the parts, joint plant, joint controller and MuJoCo, but not the loop that joins them.
    """
    period, told = robot.simulation.period, controllers(robot, (number,))[number]
    model = arm_model(robot, moving=(number,))
    data = mujoco.MjData(model)
    plant = _native.PneumaticJoint(pneumatic_joint_parameters(robot, number, 0), 0)
    plant.reset(0.0, 3e5, 3e5, 0)
    control = JointController(told)
    control.reset(*plant.sense(0.0, period))
    rows = np.empty((steps, 6))
    for k in range(steps):
        q, v = float(data.qpos[0]), float(data.qvel[0])
        out = control.step(*plant.sense(q, period), JointReference(*reference[k]), HOLDS)
        data.qfrc_applied[0] = plant.step(q, v, out.valve_1, out.valve_2, period)
        rows[k] = q, out.valve_1, out.valve_2, out.desired_1, out.desired_2, out.flags
        mujoco.mj_step(model, data)
    return rows


@pytest.mark.parametrize("number", [1, 2, 6])
def test_the_loop_is_the_one_stepped_by_hand(number):
    made = arm((number,), sensors__pressure_noise_bar=0.0)
    told = swing(made, duration=1.0, spacing=0.0005)
    log = made.run(told, 0.0005)
    rows = by_hand(made.robot, number, told.values[:, 0, :7].tolist(), log.time.size)
    np.testing.assert_allclose(rows[:, 0], log.angle[:, 0], rtol=0, atol=1e-11)
    assert np.array_equal(rows[:, 5].astype(int), log.flags[:, 0])


@pytest.mark.parametrize(("pole", "frequency"), [(6.0, 1.0), (40.0, 1.0), (120.0, 2.0)])
def test_valves_and_commanded_pressures_keep_their_limits_however_hard_the_loop_is_driven(
    pole, frequency
):
    made = arm((1,), controller__pole_1_s=pole)
    told = swing(made, duration=3.0, spacing=0.0005, amplitude=0.6, frequency=frequency)
    rows = by_hand(made.robot, 1, told.values[:, 0, :7].tolist(), 6000)
    valves, desired, flags = rows[:, 1:3], rows[:, 3:5], rows[:, 5].astype(int)
    control = made.robot.controller
    assert np.abs(valves).max() <= 1.0
    assert control.pressure_low <= desired.min() and desired.max() <= control.pressure_high
    at_limit = (np.abs(valves) == 1.0).any(axis=1)
    assert np.array_equal((flags & FLAGS["valve-limit"]) != 0, at_limit)
    assert at_limit.any() == (pole > 6.0)  # otherwise nothing was tried
    if pole > 100:
        assert ((flags & FLAGS["pressure-limit"]) != 0).any()


def test_half_the_period_changes_the_angles_by_half_as_much():
    periods = [0.002, 0.001, 0.0005, 0.00025]
    angles = []
    for period in periods:
        made = arm(
            (1,),
            simulation__period_s=period,
            sensors__pressure_noise_bar=0.0,
            sensors__encoder_bits=24,
        )
        angles.append(made.run(swing(made), 0.1).angle[:, 0])
    change = [np.abs(b - a).max() for a, b in itertools.pairwise(angles)]
    assert change[0] > 1.4 * change[1] and change[1] > 1.4 * change[2]
    assert change[2] < np.radians(0.003)  # what the period on the robot leaves


def test_equal_pressures_hold_a_joint_without_gravity_at_zero():
    made = arm((1,), tolerance__force=0.0, tolerance__hysteresis=0.0)
    zero = np.zeros((1001, 1))
    log = made.run(Reference.pressures(0.01, zero, zero + 3e5, zero), 0.01)
    assert abs(log.angle[-1, 0]) < np.radians(0.05)


def test_a_hung_torque_and_the_pressures_against_it_balance():
    made = arm((1,), hysteresis__mechanism="none", hysteresis__creep=0.0)
    ramp = np.clip(np.linspace(0, 4, 1501), 0, 1)[:, None]  # slowly: the joint is lightly damped
    log = made.run(Reference.pressures(0.01, -0.5e5 * ramp, 3e5 + 0 * ramp, 15.0 * ramp), 0.01)
    assert log.torque[-1, 0] == pytest.approx(-15.0, abs=0.1)  # the drive's, against what is hung


def test_the_arm_hangs_where_gravity_and_muscles_balance():
    made = arm()
    zero = np.zeros((2001, 7))
    log = made.run(Reference.pressures(0.01, zero, zero + 3e5, zero), 0.01)
    for_gravity = made.gravity(log.angle[-1:])[0]
    muscles = [i for i, n in enumerate(made.moving) if n in made.robot.pneumatic]
    np.testing.assert_allclose(log.torque[-1, muscles], for_gravity[muscles], atol=0.3)
    assert log.angle[-1, 1] > np.radians(5.0)  # the upper arm sinks: nobody holds it


class TestOwnMechanism:
    """Hysteresis of one's own in Python."""

    def run(self, make):
        made = arm((1,), mechanisms={1: (make(0), make(1))} if make else None)
        return made.run(swing(made), 0.01)

    def test_maxwell_slip_in_python_runs_as_the_built_in_one(self):
        muscles = pneumatic_joint_parameters(load_robot(conditions="kind"), 1, 0)["muscle"]
        own = self.run(lambda side: MaxwellSlip(muscles[side]["hysteresis"]))
        assert np.abs(own.angle - self.run(None).angle).max() < 1e-6

    def test_it_matters(self):
        class Nothing:
            def reset(self, contraction):
                pass

            def force(self, contraction, pressure, period):
                return 0.0

        assert np.abs(
            self.run(lambda side: Nothing()).angle - self.run(None).angle
        ).max() > np.radians(0.1)

    @pytest.mark.parametrize(
        ("answer", "error", "words"),
        [
            (lambda: 1 / 0, ZeroDivisionError, "division"),
            (lambda: float("nan"), ValueError, "finite"),
            (lambda: "much", TypeError, "number"),
        ],
        ids=["raises", "not finite", "no number"],
    )
    def test_its_error_comes_out_of_the_run_and_the_arm_lives_on(self, answer, error, words):
        class Fails:
            calls, armed = 0, True

            def reset(self, contraction):
                pass

            def force(self, contraction, pressure, period):
                Fails.calls += 1
                return answer() if Fails.calls > 100 and Fails.armed else 0.0

        made = arm((1,), mechanisms={1: (Fails(), Fails())})
        with pytest.raises(error, match=words):
            made.run(swing(made), 0.01)
        Fails.armed = False
        made.reset()
        assert np.isfinite(made.run(swing(made), 0.01).angle).all()

    def test_an_arm_that_its_own_mechanism_knows_is_not_kept_for_ever(self):
        class Knows(MaxwellSlip):
            arm = None

        muscles = pneumatic_joint_parameters(load_robot(conditions="kind"), 1, 0)["muscle"]
        own = tuple(Knows(muscle["hysteresis"]) for muscle in muscles)
        made = arm((1,), mechanisms={1: own})
        own[0].arm = made
        gone = weakref.ref(made)
        del made, own
        gc.collect()
        assert gone() is None

    @pytest.mark.parametrize(
        "own", [(MaxwellSlip({"share": [1], "size": 1, "strain": [1]}),), (object(), object())]
    )
    def test_what_is_no_pair_of_mechanisms_is_refused(self, own):
        with pytest.raises(ParameterError, match="joint 1"):
            arm((1,), mechanisms={1: own})


def test_an_arm_without_a_controller_says_how_to_make_one():
    with pytest.raises(
        ParameterError, match=r"joint 2 .* controller_parameters\(robot, 2, characteristic\)"
    ):
        Arm(
            load_robot(conditions="kind"),
            moving=(1, 2),
            controllers=controllers(load_robot(conditions="kind"), (1,)),
        )


@pytest.mark.parametrize("moving", [(1,), ALL_JOINTS], ids=str)
def test_an_arm_that_explodes_is_a_named_error_with_joint_and_cure(moving):
    made = arm(moving, controller__pole_1_s=200.0)
    with pytest.raises(
        SimulationError, match=r"joint \d went to .* deg, its range ends at .*joint.\d.pole_1_s"
    ) as e:
        made.run(swing(made), 0.01)
    went, ends = re.search(
        r"went to (-?)\d+ deg, its range ends at (-?)\d+ deg", str(e.value)
    ).groups()
    assert went == ends and "spring" not in str(e.value)
    assert e.value.facts["joint"] in moving


def test_a_joint_that_is_driven_to_the_end_of_its_range_is_no_explosion():
    made = arm((1,))
    ramp = np.clip(np.linspace(0, 2, 801), 0, 1)[:, None]
    log = made.run(Reference.pressures(0.01, 4e5 * ramp, 3e5 + 0 * ramp, 0 * ramp), 0.01)
    assert np.degrees(log.angle.max()) > 35


GOOD = Reference(0.01, np.zeros((5, 1, 8)), np.zeros((5, 1), np.uint32))


@pytest.mark.parametrize(
    ("reference", "every_s", "words"),
    [
        (replace(GOOD, values=np.zeros((1, 1, 8))), 0.01, "two knots"),
        (replace(GOOD, values=np.zeros((5, 2, 8))), 0.01, "moving joints"),
        (replace(GOOD, values=np.zeros((5, 1, 7))), 0.01, r"\(K, 1, 8\)"),
        (replace(GOOD, switches=np.zeros((4, 1), np.uint32)), 0.01, "switches"),
        (
            replace(
                GOOD, values=np.where(np.arange(5)[:, None, None] == 3, np.nan, np.zeros((5, 1, 8)))
            ),
            0.01,
            "knot 3",
        ),
        (replace(GOOD, spacing=0.0103), 0.01, "no multiple of the control period"),
        (replace(GOOD, spacing=0.0), 0.01, "no multiple"),
        (replace(GOOD, spacing=float("nan")), 0.01, "no multiple"),
        (GOOD, 0.0, "positive"),
        (GOOD, float("nan"), "positive"),
    ],
)
def test_a_reference_that_does_not_fit_is_refused_before_anything_moves(reference, every_s, words):
    made = arm((1,))
    with pytest.raises(ParameterError, match=words):
        made.run(reference, every_s)
    assert not made.angles.any()


def test_a_period_that_the_experiment_cannot_be_sampled_with_is_refused_and_not_run_at_another_speed():
    made = arm((1,), simulation__period_s=0.0003)
    with pytest.raises(ParameterError, match=r"simulation\.period_s"):
        made.run(GOOD, 0.01)
