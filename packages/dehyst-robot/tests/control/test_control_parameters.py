"""Parameters of the joint controller: what has no meaning is refused by name before the core sees it."""

import math
from dataclasses import FrozenInstanceError, asdict, replace

import numpy as np
import pytest

from dehyst.errors import ParameterError
from dehyst_robot import _native
from dehyst_robot.control import (
    FLAGS,
    SWITCHES,
    Adaptation,
    JointController,
    JointControllerParameters,
    JointReference,
    Pneumatics,
)
from in_one import in_one

JOINT = JointControllerParameters()
BAD = [math.nan, math.inf, 1e300, "six", None, [1.0], 10**400]
NUMBERS = [n for n, v in asdict(JOINT).items() if isinstance(v, (int, float))]


@in_one("value", BAD)
@in_one("name", NUMBERS)
def test_a_value_that_is_no_number_is_refused_by_name(name, value):
    with pytest.raises(ParameterError, match=name):
        replace(JOINT, **{name: value})


@pytest.mark.parametrize("name", list(asdict(Pneumatics())))
@pytest.mark.parametrize("value", [math.nan, "air", -1.0])
def test_pneumatics_without_meaning_are_refused_by_name(name, value):
    with pytest.raises(ParameterError, match=name):
        Pneumatics(**{name: value})


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"period": 0.0}, "period"),
        ({"inertia": -1.0}, "inertia"),
        ({"pole": -1.0}, "pole"),
        ({"angle_low": 0.7}, "angle_low = 0.7 is not below"),
        ({"pressure_low": 7e5}, "pressure_low"),
        ({"a": ()}, "a has shape"),
        ({"b": [1.0] * 9}, "9 coefficients"),
        ({"c": [math.nan]}, "c"),
        ({"volume": 3.0}, "volume"),
        ({"volume": ((1e-3,),)}, "volume"),
        ({"volume": ((1e-3,), (1e-3,) * 5)}, "volume"),
        ({"pneumatics": None}, "pneumatics"),
        ({"frozen_samples": 2.5}, "frozen_samples"),
        ({"hold_samples": -1}, "hold_samples"),
        ({"hold_samples": 2**31}, "hold_samples"),
        ({"pressure_gain": 3000.0}, "too long"),
    ],
)
def test_parameters_that_contradict_are_refused(change, message):
    with pytest.raises(ParameterError, match=message):
        replace(JOINT, **change)


def test_parameters_are_frozen_and_become_the_cores_fields():
    with pytest.raises(FrozenInstanceError):
        JOINT.pole = 3.0
    fields = JOINT.as_dict()
    _native.JointController(fields, None, None, Adaptation().as_dict())
    for name in fields:
        lacking = {k: v for k, v in fields.items() if k != name}
        with pytest.raises(ValueError, match=f"lacks '{name}'"):
            _native.JointController(lacking, None, None, Adaptation().as_dict())
    with pytest.raises(ValueError, match="unknown entries"):
        _native.JointController({**fields, "gain": 1.0}, None, None, Adaptation().as_dict())


@pytest.mark.parametrize("switches", [-1, 32, 255])
def test_unknown_switches_are_refused(switches):
    controller = JointController(JOINT)
    with pytest.raises(ParameterError, match="position = 1, integrator = 2, compensator = 4"):
        controller.step(0.0, 3e5, 3e5, JointReference(), switches)
    with pytest.raises(ParameterError, match="unknown bits"):
        controller.run([0.0], [3e5], [3e5], np.zeros((1, 7)), [switches])


def test_runs_of_different_lengths_are_refused():
    controller = JointController(JOINT)
    good = ([0.0] * 3, [3e5] * 3, [3e5] * 3, np.zeros((3, 7)), [0] * 3)
    assert controller.run(*good).valve_1.shape == (3,)
    for position, wrong in (
        (0, [0.0] * 2),
        (3, np.zeros((3, 6))),
        (3, np.zeros((2, 7))),
        (4, [0] * 4),
        (1, "abc"),
    ):
        with pytest.raises(ParameterError):
            controller.run(*good[:position], wrong, *good[position + 1 :])


def test_one_run_is_many_steps_and_an_empty_one_is_empty():
    rng = np.random.default_rng(0)
    reference = np.zeros((50, 7))
    reference[:, 4] = 3e5
    p = 3e5 + 250 * rng.normal(size=(2, 50))
    one, many = JointController(JOINT), JointController(JOINT)
    for controller in (one, many):
        controller.reset(0.0, 3e5, 3e5)
    outputs = one.run(np.zeros(50), *p, reference, np.full(50, 3))
    for k in range(50):
        step = many.step(0.0, *p[:, k], JointReference(*reference[k]), 3)
        assert (step.valve_1, step.torque, step.flags) == (
            outputs.valve_1[k],
            outputs.torque[k],
            outputs.flags[k],
        )
    empty = one.run(np.zeros(0), np.zeros(0), np.zeros(0), np.zeros((0, 7)), np.zeros(0, dtype=int))
    assert empty.flags.shape == (0,)


def test_names_of_switches_and_flags_are_distinct_bits():
    for names in (SWITCHES, FLAGS):
        assert sum(names.values()) == 2 ** len(names) - 1
        assert all(bit & (bit - 1) == 0 for bit in names.values())
