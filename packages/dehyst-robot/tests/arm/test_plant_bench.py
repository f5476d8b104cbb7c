"""One joint on a bench, its valves commanded from outside, is that joint of the arm, to the bit."""

import numpy as np
import pytest

from dehyst import PrandtlIshlinskii
from dehyst.errors import ParameterError
from dehyst_robot.control import (
    SWITCHES,
    JointController,
    JointControllerParameters,
    JointReference,
)

pytest.importorskip("mujoco", reason="needs MuJoCo: pip install dehyst-robot")

from dehyst_robot.arm import Arm, JointBench, Reference, load_robot

ON = sum(SWITCHES.values())


@pytest.fixture(scope="module", params=["kind", "realistic"])
def robot(request):
    return load_robot(conditions=request.param)


def swing(spacing=0.01, duration=1.5):
    """Position control along a sine, switched now and then, with a torque hung on the joint."""
    t = spacing * np.arange(round(duration / spacing) + 1)[:, None]
    switches = np.full(t.shape, ON, np.uint32)
    switches[40:70], switches[90:100] = 0, SWITCHES["position"]
    motion = (0.2 * np.sin(2 * t), 0.4 * np.cos(2 * t), -0.8 * np.sin(2 * t))
    return Reference.motion(spacing, motion, 1.0 + t, 3e5, switches, extra=1e3 * t, hung=-2.0 * t)


def compensator():
    return PrandtlIshlinskii([0.0, 0.02, 0.05], [0.3, 0.1, 0.1])


def test_a_controller_outside_gives_the_run_of_the_one_inside(robot):
    reference = swing()
    arm = Arm(
        robot,
        moving=(1,),
        controllers={1: JointControllerParameters()},
        compensators={1: compensator()},
        seed=3,
    )
    log = arm.run(reference, every_s=robot.simulation.period)
    bench = JointBench(robot, 1, seed=3)
    controller = JointController(JointControllerParameters(), compensator())
    controller.reset(*bench.reset()[0])
    found = []
    fine, seen = reference.sampled(bench.period), bench.sense()[0]
    for row, switches in zip(fine.values[:-1, 0], fine.switches[:-1, 0], strict=True):
        assert list(bench.sensed(1).values()) == seen.tolist()
        out = controller.step(*seen, JointReference(*row[:7]), int(switches))
        found.append((bench.angles[0], *seen, out.integrator, out.compensation, out.flags))
        seen = bench.step([[out.valve_1, out.valve_2]], hung=row[7])[0]
    inside = np.column_stack(
        [log.angle, log.measured, log.pressure[:, 0], log.integrator, log.compensation, log.flags]
    )
    assert np.array_equal(np.array(found), inside)
    assert np.ptp(log.angle) > 0.1
    assert np.ptp(log.compensation) > 0


def test_a_reference_sampled_at_every_period_is_what_the_loop_interpolates(robot):
    period = robot.simulation.period
    reference = swing(spacing=0.004, duration=0.8)
    told = {1: JointControllerParameters()}
    logs = [
        Arm(robot, moving=(1,), controllers=told).run(one, every_s=period)
        for one in (reference, reference.sampled(period))
    ]
    assert np.array_equal(logs[0].angle, logs[1].angle)
    assert np.array_equal(logs[0].desired, logs[1].desired)
    knots = round(reference.spacing / period)
    inner = reference.sampled(period).values[: knots + 1, 0, 0]
    assert np.abs(np.diff(inner, 2)).max() > 0  # no straight line between two knots


def test_a_bench_begins_anew_after_a_reset(robot):
    bench = JointBench(robot, 2, seed=1)
    start = bench.reset()
    first = [bench.step([[0.5, -0.5]]).tolist() for _ in range(50)]
    assert np.array_equal(bench.reset(), start)
    assert first == [bench.step([[0.5, -0.5]]).tolist() for _ in range(50)]
    assert bench.angles[0] != 0 and bench.velocities[0] != 0
    assert not np.array_equal(JointBench(robot, 2, seed=2).reset(), start)


def test_an_electric_joint_is_refused_by_name(robot):
    electric = next(n for n in robot.joints if n not in robot.pneumatic)
    with pytest.raises(ParameterError, match=f"joint {electric} is electric"):
        JointBench(robot, electric)
