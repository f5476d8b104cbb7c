"""Excitation of a joint: the simulated joint can follow it, within its pressures, and it ends where it began."""

import numpy as np
import pytest

from dehyst_robot.arm import Arm, load_robot
from dehyst_robot.experiments import (
    SPACING,
    controller_parameters,
    design_joint,
    excite,
    nominal_characteristic,
)
from dehyst_robot.experiments._calibration import pressure_room
from dehyst_robot.experiments._path import flow_share, pressure_share, utilisation
from dehyst_robot.experiments._policy import POLICY

ROBOT = load_robot(conditions="kind")


@pytest.fixture(scope="module")
def light():
    """A wrist joint: light, so that a short plan does."""
    return design_joint(ROBOT, 7, time_limit=300.0)


@pytest.mark.slow
def test_the_simulated_joint_follows_within_its_pressures(light):
    number = light.number
    characteristic = nominal_characteristic(ROBOT, number)
    arm = Arm(
        ROBOT,
        moving=(number,),
        controllers={number: controller_parameters(ROBOT, number, characteristic)},
    )
    _, target, part = light.plan.signal(SPACING)
    log = excite(arm, target[:, None], {number: characteristic}, every_s=0.05)
    control = ROBOT.controller
    pressure = log.pressure[:, 0]
    assert control.pressure_low < pressure.min() and pressure.max() < control.pressure_high
    angle = log.measured[:, 0]
    assert np.abs(angle).max() < ROBOT.joint(number).range
    assert angle.max() > 0.6 * light.plan.high and angle.min() < 0.6 * light.plan.low
    difference = pressure[:, 0] - pressure[:, 1]
    room = pressure_room(ROBOT, control.mean_pressure)
    assert np.abs(difference).max() / room == pytest.approx(light.pressure_share, abs=0.05)
    assert set(part) == {"home", "loops", "holds", "test"}


def test_acceleration_is_chosen_so_that_inertia_hides_in_no_log():
    for number in (1, 4):
        found = design_joint(ROBOT, number)
        characteristic = nominal_characteristic(ROBOT, number)
        torque = characteristic.b[0] * pressure_room(ROBOT, ROBOT.controller.mean_pressure)
        assert found.inertia_torque <= POLICY.inertia_share * torque * (1 + 1e-9)


@pytest.mark.slow
def test_a_rate_that_the_valves_cannot_follow_is_lowered_if_nobody_asked_for_it():
    narrow = {"valve.mpye_small.conductance_l_s_bar": 0.02}
    robot = ROBOT.with_changes(narrow)
    found = design_joint(robot, 7, time_limit=900.0)
    usual = design_joint(ROBOT, 7, time_limit=900.0)
    assert found.plan.limits.rate < usual.plan.limits.rate and found.flow_share <= 0.85


def test_utilisation_is_the_larger_of_pressure_and_flow():
    characteristic = nominal_characteristic(ROBOT, 1)
    controller = controller_parameters(ROBOT, 1, characteristic)
    angle = 0.4 * np.sin(np.linspace(0.0, 6.0, 400))
    for torque in (np.zeros(400), np.full(400, 60.0)):
        each = (
            pressure_share(ROBOT, characteristic, angle, torque),
            flow_share(ROBOT, characteristic, controller, angle, torque, 0.01),
        )
        assert (
            utilisation(ROBOT, characteristic, controller, angle, torque, 0.01) == max(each) / 0.85
        )
