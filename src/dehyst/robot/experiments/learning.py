"""Iterative learning control: a torque along a repeated path, updated from the last pass's errors."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from dehyst.arrays import Array
from dehyst.control import JointControllerParameters
from dehyst.robot.arm.parameters import Robot
from dehyst.robot.arm.rigid_body import ALL_JOINTS
from dehyst.robot.experiments.path import ArmPath
from dehyst.robot.experiments.results import TrialRun
from dehyst.robot.experiments.scores import joint_figures
from dehyst.robot.experiments.trials import Equipment, follow_path, trial_arm

CUTOFF_HZ = 3.0  # of the filter: beyond, the pressure loops and the nominal inertia are not known well enough
KNOTS_HZ = 25.0  # of what is learned
LEAST_STEP = 0.2  # of a step that failed before: smaller ones are not worth a pass


def learned_trial(
    robot: Robot,
    path: ArmPath,
    equipment: Equipment,
    trial: str,
    compensator: str,
    moving: tuple[int, ...] = ALL_JOINTS,
    *,
    passes: int = 0,
) -> tuple[TrialRun, float]:
    """Run a trial, then again up to `passes` times with a torque learned from the pass before; return the best.

    All passes are on one arm, each homed again, so that only what comes again is learned, and no noise.

    A pass is kept if the rms errors of the learning joints, each over what it was at first, fall in the sum of their
    squares, and no joint is worse than at first, in rms or largest error. Else it is forgotten and the step halved:
    what is returned is never worse than the first run, whatever the plant does.

    Parameters
    ----------
    robot, path, equipment, trial, compensator, moving
        As for `run_trial`; learning joints are those with a compensator in `equipment`.
    passes
        Most repetitions; 0: none, and nothing is learned.
    """
    arm = trial_arm(robot, equipment, trial, moving)
    best, speed = follow_path(arm, path, equipment, trial, compensator)
    joints = tuple(n for n in equipment.compensators if n in moving)
    step, kept = 1.0, dict(equipment.learned)
    first = {n: _size(best, n) for n in joints}
    for _ in range(passes if joints else 0):
        change = {n: learned_torque(robot, best, equipment.controllers[n], n) for n in joints}
        tried = {n: kept.get(n, 0.0) + step * change[n] for n in joints}
        run, _ = follow_path(arm, path, replace(equipment, learned=tried), trial, compensator)
        if _better(run, best, first):
            best, kept = run, tried
            continue
        step *= 0.5
        if step < LEAST_STEP:
            break
    return best, speed


def learned_torque(robot: Robot, run: TrialRun, controller: JointControllerParameters, number: int) -> Array:
    r"""Return the torque (K,) [Nm] along a cycle of the path that would have made the error of a joint disappear.

    What the position law answered to the error e, and the inertia torque that was missing,

    .. math:: \Delta Q = F\bigl[M(\ddot e + 3 \lambda \dot e + 3 \lambda^2 e) + I\bigr],

    over the angle as the encoder shows it, the mean of all cycles, F a filter without phase: of a log.
    """
    tick = 2 * np.pi / 2**robot.sensors.encoder_bits
    column = number - 1
    error = run.desired[:, column] - tick * np.round(run.angle[:, column] / tick)
    spacing = float(run.time[1] - run.time[0])
    width = 1.0 / (2 * np.pi * CUTOFF_HZ * spacing)  # of a Gaussian with that cut-off, in samples
    smooth, rate, bend = (_filtered(error, width, order) / spacing**order for order in range(3))
    pole, inertia = controller.pole, controller.inertia
    torque = inertia * (bend + 3 * pole * rate + 3 * pole**2 * smooth) + _filtered(run.integrator[:, column], width, 0)
    cycles = int(run.cycle.max()) + 1
    duration = (run.time[-1] + spacing) / cycles
    knots = np.linspace(0.0, duration, round(duration * KNOTS_HZ) + 1)
    return np.asarray(np.mean([np.interp(knots + k * duration, run.time, torque) for k in range(cycles)], axis=0))


def _filtered(values: Array, width: float, order: int) -> Array:
    """Gaussian filter of a width in samples, or its derivative; ends are mirrored at their own value."""
    reach = int(np.ceil(4 * width)) + 1
    x = np.arange(-reach, reach + 1) / width
    bell = np.exp(-0.5 * x**2)
    bell /= bell.sum()
    shape = (bell, -x / width * bell, (x**2 - 1) / width**2 * bell)[order]
    shape = shape - shape.mean() if order else shape
    before, after = 2 * values[0] - values[reach:0:-1], 2 * values[-1] - values[-2 : -reach - 2 : -1]
    return np.convolve(np.concatenate([before, values, after]), shape, mode="valid")


def _size(run: TrialRun, number: int) -> tuple[float, float]:
    figures = joint_figures(run, number)
    return figures["rms_deg"], figures["max_deg"]


def _better(run: TrialRun, best: TrialRun, first: Mapping[int, tuple[float, float]]) -> bool:
    sums = [sum((_size(one, n)[0] / rms) ** 2 for n, (rms, _) in first.items() if rms > 0) for one in (run, best)]
    worse = any(now > before for n, sizes in first.items() for now, before in zip(_size(run, n), sizes, strict=True))
    return sums[0] < sums[1] and not worse
