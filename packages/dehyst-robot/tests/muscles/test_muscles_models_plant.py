"""A muscle model is the muscle of the simulated joint, and the model that its controller works with."""

from dataclasses import replace

import numpy as np
import pytest

from dehyst.errors import ParameterError
from dehyst_robot.arm import Mechanism, load_robot
from dehyst_robot.arm._joints import run_pressures
from dehyst_robot.control import SWITCHES, JointControllerParameters
from dehyst_robot.muscles import MuscleMechanism, joint_characteristic, muscle, muscle_names

PERIOD = 5e-4
ALONE = {  # what the plant adds to static map and hysteresis of a muscle, and its tolerances
    "tolerance.force": 0.0,
    "tolerance.hysteresis": 0.0,
    "hysteresis.creep": 0.0,
    "muscle.dmsp40.viscous_force_N": 0.0,
}


def joint_muscle(name):
    """The model as strong as a DMSP-40 where there is such a set, and as long as the plant can be told."""
    if name in ("tondu-lopez", "chou-hannaford"):
        return muscle(name, "DMSP-40")
    return muscle(name, length=0.4) if name in ("sarosi", "klute") else muscle(name)


def pair(model):
    return MuscleMechanism(model), MuscleMechanism(model)


@pytest.mark.parametrize("name", muscle_names())
def test_the_plants_muscle_pulls_with_the_force_of_the_model(name):
    from dehyst_robot.arm import pneumatic_joint_parameters

    model = joint_muscle(name)
    robot = load_robot(conditions="kind", changes={**ALONE, "muscle.dmsp40.length_m": model.length})
    angle = 0.3 * np.sin(np.linspace(0, 10, 2001))
    pressure = 3e5 + 5e4 * np.sin(np.linspace(0, 7, 2001))[:, None] * np.array([1.0, -1.0])
    physics = pneumatic_joint_parameters(robot, 1, seed=0)
    course = run_pressures(physics, angle, pressure, PERIOD, mechanisms=pair(model))
    for m in (0, 1):
        expected = model.simulate(
            course.contraction[:, m], course.pressure[:, m], course.time, clamp=True
        )
        np.testing.assert_allclose(
            course.force[1:, m], expected[1:], atol=1e-6
        )  # it is asked from the first step on
    assert isinstance(MuscleMechanism(model), Mechanism)


@pytest.mark.parametrize("name", muscle_names())
def test_a_joint_of_two_such_muscles_runs_with_a_controller_that_knows_them(name):
    from dehyst_robot.arm import Arm, Reference

    model = joint_muscle(name)
    robot = load_robot(conditions="kind", changes={**ALONE, "muscle.dmsp40.length_m": model.length})
    joint = joint_characteristic(model, 0.05, 0.11, reach=0.4)
    controller = JointControllerParameters(**joint.fields())
    arm = Arm(robot, moving=(1,), controllers={1: controller}, mechanisms={1: pair(model)})
    goal, zero = np.full((401, 1), 0.1), np.zeros((401, 1))
    on = SWITCHES["position"] | SWITCHES["integrator"]
    log = arm.run(Reference.motion(0.01, (goal, zero, zero), zero, 3e5, on), every_s=0.1)
    assert abs(log.angle[-1, 0] - 0.1) < 0.01


def test_a_plant_with_another_map_needs_that_map_told():
    model, plant = muscle("sarosi"), muscle("sarosi", "DMSP-20-200N")
    told, untold = MuscleMechanism(model, plant), MuscleMechanism(model)
    for mechanism, map_of_plant in ((told, plant), (untold, muscle("maker"))):
        mechanism.reset(0.1)
        force = map_of_plant.static_force(0.1, 3e5) - mechanism.force(0.1, 3e5, PERIOD)
        assert force == pytest.approx(float(model.static_force(0.1, 3e5)))


def test_a_mechanism_forgets_at_a_reset():
    mechanism = MuscleMechanism(muscle("vo-minh"))
    mechanism.reset(0.05)
    first = [mechanism.force(k, 3e5, PERIOD) for k in (0.06, 0.08, 0.07)]
    mechanism.reset(0.05)
    assert [mechanism.force(k, 3e5, PERIOD) for k in (0.06, 0.08, 0.07)] == first


def test_two_different_muscles_make_a_joint_that_is_not_symmetric():
    strong, weak = muscle("maker"), muscle("maker", force=4000.0)
    joint = joint_characteristic(strong, 0.05, 0.11, opposing=weak)
    at_rest = 0.05 * float(strong.static_force(0.11, 3e5) - weak.static_force(0.11, 3e5))
    assert joint.torque(0.0, 3e5, 0.0) == pytest.approx(at_rest, abs=joint.residual)
    with pytest.raises(ParameterError, match="outside"):
        joint_characteristic(strong, 0.05, 0.11, reach=5.0)
    with pytest.raises(ParameterError, match="degree"):
        joint_characteristic(strong, 0.05, 0.11, degree=20)
    with pytest.raises(ParameterError, match="radius"):
        joint_characteristic(replace(strong), -0.05, 0.11)
