"""A joint alone with a direct inverse on the simulated plant: minutes of faults, pushes, rests, integrators."""

import sys
from dataclasses import replace

import numpy as np
import pytest

from dehyst.errors import ParameterError
from dehyst.models import DirectInverse, ModelCard, SignalCard
from dehyst_robot.arm import Reference, load_robot
from dehyst_robot.arm._runs import FAULTS
from dehyst_robot.control import Adaptation
from dehyst_robot.experiments import calibrate, plan_path
from places import ROOT

sys.path.insert(0, str(ROOT / "benchmarks"))

from studies.alone import ADAPT, DISTURBANCE, Alone, follow, rms, smooth_push
from studies.endurance import endure, map_slope
from studies.hold import gains, hold

REACH = 0.4887
CARD = ModelCard(SignalCard("torque", "Nm", -10.0, 10.0), SignalCard("angle", "rad", -REACH, REACH))
ROUGH = DirectInverse(  # a guess of the size of the hysteresis, good to a third
    radii=[0.004, 0.02, 0.07, 0.2],
    stop_weights=[60.0, 40.0, 20.0, 8.0],
    time_constants=[4.0, 25.0, 150.0],
    creep_weights=[2.0, 2.0, 2.0],
    polynomial=[0.0],
    card=CARD,
)
SWEEPS = {"mean_pressures_bar": [2.2, 3.8], "loads_bar": [-0.8, 0.8], "sweep_s": 8.0, "degree": 5}
SHORT = {
    "homing.cycles": 4,
    "path.slow_factor": 3.0,
    "hysteresis.mechanism": "dahl",
    "calibration": SWEEPS,
}


@pytest.fixture(scope="module")
def joint():
    robot = load_robot(conditions="kind", changes=SHORT)
    return Alone(
        robot, plan_path(load_robot(conditions="kind")), calibrate(robot, 1), ROUGH, Adaptation()
    )


@pytest.fixture(scope="module")
def off(joint):
    return replace(joint, model=None)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 1])
def test_minutes_of_faults_leave_scales_in_bounds_and_the_map_invertible_at_every_period(
    joint, seed
):
    seen = endure(joint, 200.0, seed)
    assert seen.faults > 3
    assert seen.within(joint.adaptation)
    assert seen.highest > 1.1 or seen.lowest < 0.9  # it did learn
    assert seen.slope > 0


@pytest.mark.slow
def test_bounds_that_are_left_would_be_seen(joint):
    seen = endure(joint, 50.0)
    tight = Adaptation(lowest=1.0, highest=1.0, offset_limit=0.0)
    assert not seen.within(tight)
    assert not replace(seen, finite=False).within(joint.adaptation)
    assert not replace(seen, slope=-1.0).within(joint.adaptation)


def test_a_map_with_a_falling_curve_is_not_called_invertible(joint):
    falling = replace(ROUGH, polynomial=[0.0, -500.0])
    assert map_slope(joint.characteristic, ROUGH, 2.0) > 0
    assert map_slope(joint.characteristic, falling, 2.0) < 0


def test_endurance_without_a_direct_inverse_is_refused(off):
    with pytest.raises(ParameterError, match="direct inverse"):
        endure(off, 50.0)


# At rest a frozen reading is a reading like any other, and a supply that fails is felt by who needs air.
@pytest.mark.parametrize(
    "fault", [fault for fault in FAULTS if "frozen" not in fault and fault != "supply_lost"]
)
def test_an_injected_fault_is_flagged(joint, fault):
    arm = joint.arm()
    zero = np.zeros((101, 1))
    switches = np.zeros((101, 1), np.uint32)
    switches[50:52] |= FAULTS[fault]
    reference = Reference.pressures(0.01, zero, zero + 3e5, zero)
    clean, hurt = arm.run(reference, 0.01), arm.run(replace(reference, switches=switches), 0.01)
    assert not clean.flags.any()
    assert hurt.flags[50:].any()


def test_a_stored_state_is_restored_into_an_equal_arm_and_no_other(joint):
    arm, other = joint.arm(), replace(joint, model=replace(ROUGH, viscous=0.1)).arm()
    images = arm.images()
    arm.restore(images)
    with pytest.raises(ParameterError, match="images"):
        other.restore(images)


@pytest.mark.slow
def test_a_push_is_estimated_within_the_hysteresis_that_is_not_known_and_not_learned(joint, off):
    push = smooth_push(30.0, lasting=10.0)
    run, blind = follow(joint, "slow", ADAPT, push=push), follow(off, "slow", push=push)
    before = rms(blind.log.load[:, 0] + blind.pushed)
    assert run.pushed.max() == pytest.approx(5.0)
    assert rms(run.contact_error) < 0.35 * before
    during = (run.log.time > 32.0) & (run.log.time < 39.0)
    assert -run.log.contact[during, 0].mean() == pytest.approx(5.0, abs=1.0)


@pytest.mark.slow
def test_half_the_hysteresis_is_learned_from_the_homing(joint, off):
    half = {"hysteresis__scale": 0.5}
    ratio = [
        follow(joint.with_changes(**half), "slow", switches, learn_homing=bool(switches)).figures()[
            0
        ]
        / follow(off.with_changes(**half), "slow").figures()[0]
        for switches in (0, ADAPT)
    ]
    assert ratio[1] < 0.9 * ratio[0]  # of a model that is rough in itself


@pytest.mark.slow
def test_feedback_of_contact_holds_what_drifts(joint):
    without, fed_back = hold(joint, lasting=60.0), hold(joint, DISTURBANCE, lasting=60.0)
    assert np.abs(fed_back.error).max() < 0.1
    assert np.abs(fed_back.error).max() < 0.5 * np.abs(without.error).max()
    assert not without.integrator.any()


@pytest.mark.slow
def test_an_integrator_of_gain_one_outside_is_the_one_inside(joint, off):
    inside = follow(off, "slow").figures()
    (outside,) = gains(off, values=(1.0,))
    assert outside.rms_deg == pytest.approx(inside[0], rel=0.05)
    assert outside.max_deg == pytest.approx(inside[1], rel=0.1)


@pytest.mark.slow
def test_the_compensator_takes_over_most_of_the_integrators_work(joint, off):
    (alone,), (beside,) = gains(off, values=(1.0,)), gains(joint, values=(1.0,))
    assert beside.work_Nm < 0.5 * alone.work_Nm
