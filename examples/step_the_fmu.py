"""The joint controller of the simulated robot as an FMU, stepped by FMPy against the simulated joint from outside.

Joint 1 is calibrated and identified, its controller with compensator and integrator becomes an FMU, and the FMU drives
the valves along the test path. Needs a C compiler and: pip install dehyst-robot 'dehyst-targets[fmi]'
"""

import sys
import tempfile
from pathlib import Path

import numpy as np
from fmpy import extract, instantiate_fmu, read_model_description

from dehyst.export import export
from dehyst_robot import calibrate, equip, identify_joint, plan_path
from dehyst_robot.arm import Arm, JointBench, Reference, load_robot
from dehyst_robot.control import SWITCHES
from dehyst_robot.export import joint_subject

if __name__ == "__main__":
    version = sys.argv[1] if len(sys.argv) > 1 else "fmu2"  # or fmu3
    work, robot = Path(tempfile.mkdtemp()), load_robot()
    backbone = calibrate(robot, 1)
    found = identify_joint(robot, 1, backbone, work)
    equipment = equip(robot, {1: backbone}, {1: found})
    export(joint_subject(found.fit.model, equipment.controllers[1], name="joint_1"), version, work / "fmu")
    # 2 s to the start of the path, 4 s along it.
    path, spacing = plan_path(robot), 0.004  # [s]
    u = np.arange(0.0, 1.0, spacing / 2.0)[:, None]
    rise, speed, rate = (u**3 * (10 - 15 * u + 6 * u**2), 15 * u**2 * (1 - u) ** 2, 15 * u * (1 - u) * (1 - 2 * u))
    along = [signal[:, :1] for signal in path.motion(path.timing, np.arange(0.0, 4.0, spacing))]
    motion = [np.vstack([part * along[0][0], rest]) for part, rest in zip((rise, speed, rate), along, strict=True)]
    arm = Arm(robot, moving=(1,), controllers=equipment.controllers, compensators=equipment.compensators)
    reference = Reference.motion(spacing, motion, arm.feedforward(*motion), 3e5, sum(SWITCHES.values()))
    inside = arm.run(reference, every_s=robot.simulation.period)

    bench, name = JointBench(robot, 1), str(work / "fmu" / "joint_1.fmu")
    about = read_model_description(name)
    number = {variable.name: variable.valueReference for variable in about.modelVariables}
    fmu = instantiate_fmu(extract(name), about)
    get, put = (fmu.getReal, fmu.setReal) if version == "fmu2" else (fmu.getFloat64, fmu.setFloat64)
    sensors, valves = ([number["angle"] + k for k in range(3)], [number["valve_1"], number["valve_2"]])
    wanted, switches = ([number["reference_angle"] + k for k in range(7)], [number[f"{word}_on"] for word in SWITCHES])
    _ = fmu.setupExperiment() if version == "fmu2" else None
    fmu.enterInitializationMode()
    put(sensors, bench.reset()[0])  # the controller starts where the sensors are
    fmu.setBoolean(switches, [True] * len(switches))
    fmu.exitInitializationMode()
    angle, seen = np.empty(inside.time.size), bench.sense()[0]
    for k, row in enumerate(reference.sampled(bench.period).values[:-1, 0]):
        angle[k] = bench.angles[0]
        put(sensors + wanted, [*seen, *row[:7]])
        fmu.doStep(k * bench.period, bench.period)
        seen = bench.step([get(valves)], hung=row[7])[0]
    rms = np.degrees(np.std((angle - inside.desired[:, 0])[-8000:]))
    print(f"{version}: {angle.size} periods, deviation from the path {rms:.3f} deg rms")
    print(f"same run as with the built-in controller: {np.array_equal(angle, inside.angle[:, 0])}")
