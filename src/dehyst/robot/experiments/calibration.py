"""Calibrates the static joint characteristic Q = A(q) p_m + B(q) dp + C(q) by slow sweeps."""

from __future__ import annotations

import itertools

import numpy as np

from dehyst.arrays import Array
from dehyst.design import triangle_sweep
from dehyst.errors import ParameterError
from dehyst.robot.arm.arm import Arm, ArmLog
from dehyst.robot.arm.mechanisms import MechanismFactory, mechanisms_of
from dehyst.robot.arm.parameters import Robot
from dehyst.robot.experiments.nominal import controller_parameters, nominal_characteristic, nominal_forces
from dehyst.robot.experiments.quasistatic import SPACING, excite, known_torque
from dehyst.robot.experiments.results import Characteristic

APPROACH_S = 5.0  # pressures and the hung weight are brought to the beginning of a sweep
SLACK = 0.1  # share of the force at zero and mean pressure below which a muscle may be slack
LOG_S = 0.05
TORQUE_DEGREE = 2  # of 1/B: three loads do not tell more
LARGEST_STRETCH = 2.0


def calibrate(
    robot: Robot, number: int, *, seed: int = 0, mechanisms: MechanismFactory | None = None
) -> Characteristic:
    """Sweep a joint slowly up and down at several mean pressures and known loads, and fit A, B and C.

    The joint moves alone. Fitted is

    .. math:: dp = Q \\beta(q) - p_m \\alpha(q) - \\gamma(q), \\qquad
              B = 1/\\beta, \\; A = \\alpha/\\beta, \\; C = \\gamma/\\beta

    and not Q over dp: the hysteresis sits in dp, and as a regressor it would make B too small (by 8 % with loads of
    20 Nm and a hysteresis of 6 Nm). Sweeps in both directions make it cancel.

    Parameters
    ----------
    robot
        Its [calibration] table.
    number
        Of the joint.
    seed
        Of the noise and the muscles' tolerances.
    mechanisms
        Makes hysteresis mechanisms of one's own, instead of the robot's.

    Returns
    -------
    characteristic : Characteristic

    Raises
    ------
    ParameterError
        If muscles are slack almost everywhere.
    SimulationError
        If the joint's controller failed safe during a sweep.

    Examples
    --------
    A short calibration; the file's own takes three mean pressures, three loads and sweeps of 24 s:

    >>> from dehyst.robot.arm.parameters import load_robot
    >>> short = {"mean_pressures_bar": [2.2, 3.8], "loads_bar": [-0.8, 0.8], "sweep_s": 8.0, "degree": 3}
    >>> found = calibrate(load_robot(changes={"calibration": short}), 1)
    >>> round(1e5 * found.b[0])  # B(0): torque of a bar of pressure difference [Nm/bar]
    34
    """
    plan = nominal_characteristic(robot, number)
    arm = Arm(
        robot,
        moving=(number,),
        controllers={number: controller_parameters(robot, number, plan)},
        mechanisms=mechanisms_of(mechanisms, (number,)),
        seed=seed,
    )
    settings = robot.calibration
    unit = float(plan.b[0])  # torque that a pressure difference gives at zero [Nm/Pa]
    sweep = triangle_sweep(settings.sweep, SPACING).value
    half = settings.range_share * robot.joint(number).range
    before = (half * float(sweep[-1]), robot.controller.mean_pressure, 0.0)
    half = half * _stretch(arm, plan, half * sweep)
    sweeps = []
    for mean, load in itertools.product(settings.mean_pressures, settings.loads):
        after = (half * sweep[0], mean, load * unit)
        approach = [_blend(x, y, APPROACH_S) for x, y in zip(before, after, strict=True)]
        target, means, hung = (
            np.concatenate([way, level])[:, None]
            for way, level in zip(
                approach, (half * sweep, np.full(sweep.size, mean), np.full(sweep.size, load * unit)), strict=True
            )
        )
        log = excite(arm, target, {number: plan}, LOG_S, means, hung)
        sweeps.append(_usable(robot, number, arm, log, load * unit))
        before = (float(target[-1, 0]), mean, load * unit)
    sweeps = [sweep for sweep in sweeps if sweep.shape[0]]
    _refuse_too_few(number, sum(sweep.shape[0] for sweep in sweeps), settings.degree)
    return fit_characteristic(sweeps, settings.degree)


def _refuse_too_few(number: int, samples: int, degree: int) -> None:
    unknowns = TORQUE_DEGREE + 1 + 2 * (degree + 1)
    if samples < 10 * unknowns:
        raise ParameterError(
            f"the sweeps of joint {number} left {samples} samples in which both muscles are tight, for {unknowns} "
            f"coefficients: no characteristic follows from so few. Raise calibration.mean_pressures_bar or sweep_s, or "
            f"lower range_share.",
            joint=number,
            samples=samples,
        )


def _blend(start: float, end: float, duration: float) -> Array:
    """A smooth way between two values at knots of `SPACING`."""
    u = np.linspace(0.0, 1.0, round(duration / SPACING), endpoint=False)
    return np.asarray(start + (end - start) * u**3 * (10 - 15 * u + 6 * u**2))


def _stretch(arm: Arm, plan: Characteristic, targets: Array) -> float:
    """How much further the plan must reach for the joint to get where it shall: one trial sweep tells."""
    begin = _blend(0.0, float(targets[0]), APPROACH_S)
    log = excite(arm, np.concatenate([begin, targets])[:, None], {arm.moving[0]: plan}, LOG_S)
    reached = float(np.ptp(log.measured[log.time > APPROACH_S]))
    return float(np.clip(np.ptp(targets) / max(reached, 1e-6), 1 / LARGEST_STRETCH, LARGEST_STRETCH))


def _usable(robot: Robot, number: int, arm: Arm, log: ArmLog, hung: float) -> Array:
    """Rows (T, 4) of a sweep: q, dp, p_m, Q; without the approach and without samples where a muscle may be slack.

    A slack muscle is outside of Q = A p_m + B dp + C. Which sample is, the data sheet tells.
    """
    q, pressure = log.measured[:, 0], log.pressure[:, 0]
    tight = (
        nominal_forces(robot, number, q, pressure).min(axis=1)
        > SLACK * nominal_forces(robot, number, np.zeros(1), np.full((1, 2), robot.controller.mean_pressure)).mean()
    )
    kept = (log.time >= APPROACH_S) & tight
    torque = known_torque(arm, q[:, None], hung)[:, 0]
    rows = np.stack([q, pressure[:, 0] - pressure[:, 1], pressure.mean(axis=1), torque], axis=1)
    return np.asarray(rows[kept])


def fit_characteristic(sweeps: list[Array], degree: int) -> Characteristic:
    """Fit A, B and C to sweeps, each (T, 4): q [rad], dp [Pa], p_m [Pa], Q [Nm].

    Examples
    --------
    >>> q, dp, load = (x.ravel() for x in np.meshgrid(np.linspace(-0.6, 0.6, 25), [0.0], [-20.0, 0.0, 20.0]))
    >>> law = [(p, (load + 60e-5 * q * p + 4 * q) / 35e-5) for p in (2e5, 3e5)]
    >>> sweeps = [np.stack([q, dp, np.full(q.size, p), load], axis=1) for p, dp in law]
    >>> found = fit_characteristic(sweeps, 3)
    >>> round(float(found.b[0]) * 1e5, 3), round(float(found.a[1]) * 1e5, 3), round(float(found.c[1]), 3)
    (35.0, -60.0, -4.0)
    """
    q, dp, mean, torque = np.concatenate(sweeps).T
    k, m = TORQUE_DEGREE + 1, degree + 1
    power = q[:, None] ** np.arange(degree + 1)
    scale = (10.0, 1e5)  # torques of 10 Nm, pressures of 1 bar: columns of one size
    regressors = np.hstack([power[:, :k] * (torque / scale[0])[:, None], -power * (mean / scale[1])[:, None], -power])
    found, *_ = np.linalg.lstsq(regressors, dp / scale[1], rcond=None)
    low, high = float(q.min()), float(q.max())
    grid = np.linspace(low, high, 201)
    parts = np.split(found, [k, k + m])
    beta, alpha, gamma = (np.polynomial.polynomial.polyval(grid, part) for part in parts)
    beta = beta * scale[1] / scale[0]  # [Pa/Nm]
    a, b, c = (
        np.polynomial.polynomial.polyfit(grid, y, degree) for y in (alpha / beta, 1 / beta, gamma * scale[1] / beta)
    )
    value = np.polynomial.polynomial.polyval
    residual = torque - value(q, a) * mean - value(q, b) * dp - value(q, c)
    return Characteristic(a, b, c, low, high, float(np.sqrt(np.mean(residual**2))), tuple(sweeps))
