"""The highest stable gains: one procedure, and what it finds holds in a trial."""

from functools import cache

import pytest

from dehyst.errors import ParameterError
from dehyst_robot.arm import load_robot
from dehyst_robot.experiments import equip, nominal_characteristic
from dehyst_robot.experiments._gains import NEAR, at_pole, has_margins, highest_pole


def told(number=1, **more):
    """A joint that only data sheets describe, and its equipment."""
    robot = load_robot(**more)
    return robot, equip(robot, {number: nominal_characteristic(robot, number)}, {})


@cache
def highest(conditions):
    robot, equipment = told(conditions=conditions)
    return highest_pole(robot, equipment, (1,))


@pytest.mark.slow
def test_the_pole_that_is_found_has_its_margins_and_the_next_one_has_not():
    robot, equipment = told(conditions="realistic")
    pole = highest("realistic")
    assert has_margins(robot, at_pole(equipment, pole), (1,))
    assert not has_margins(robot, at_pole(equipment, pole * NEAR), (1,))


@pytest.mark.slow
def test_a_realistic_joint_takes_less_gain_than_a_kind_one():
    assert highest("realistic") < 0.7 * highest("kind")


def test_the_observer_follows_the_pole_and_is_never_slower_than_the_robots():
    _, equipment = told()
    assert [at_pole(equipment, pole).controllers[1].observer_pole for pole in (6.0, 20.0)] == [
        60.0,
        160.0,
    ]


def test_a_joint_that_nothing_holds_and_one_without_controller_are_refused():
    robot, equipment = told(conditions="kind", changes={"simulation.command_delay_s": 0.025})
    with pytest.raises(ParameterError, match="joint 1: a pole of 6 1/s oscillates already"):
        highest_pole(robot, equipment, (1,))
    with pytest.raises(
        ParameterError, match=r"joint 2 has no controller in the equipment, only \[1\]"
    ):
        highest_pole(robot, equipment, (2,))


def test_joints_that_couple_take_less_gain_than_each_alone():
    robot = load_robot(conditions="kind")
    equipment = equip(robot, {n: nominal_characteristic(robot, n) for n in (2, 4)}, {})
    together = at_pole(equipment, 12.0)
    assert all(has_margins(robot, together, (n,)) for n in (2, 4))
    assert not has_margins(robot, together, (2, 4))
