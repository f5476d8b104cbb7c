"""Static joint characteristic Q = A(q) p_m + B(q) dp + C(q), measured as on a rig."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from dehyst.evaluation import triangle_sweep
from dehyst.experiments.nominal import controller_parameters, nominal_characteristic
from dehyst.experiments.quasistatic import SPACING, excite, known_torque
from dehyst.experiments.results import Characteristic
from dehyst.plant.arm import Arm
from dehyst.plant.mechanisms import Mechanism
from dehyst.plant.parameters import Robot

Array = npt.NDArray[np.float64]

APPROACH = 0.3  # share of a sweep's time in which the joint is brought to its beginning
LOG_S = 0.05


def calibrate(
    robot: Robot, number: int, *, seed: int = 0, mechanisms: tuple[Mechanism, Mechanism] | None = None
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
        Foreign hysteresis mechanisms of the two muscles.

    Returns
    -------
    characteristic : Characteristic
    """
    plan = nominal_characteristic(robot, number)
    arm = Arm(
        robot,
        moving=(number,),
        controllers={number: controller_parameters(robot, number, plan)},
        mechanisms={number: mechanisms} if mechanisms else None,
        seed=seed,
    )
    settings = robot.calibration
    half = settings.range_share * robot.joint(number).range
    sweep = triangle_sweep(settings.sweep, SPACING).value
    approach = int(APPROACH * settings.sweep / SPACING)
    blend = 0.5 - 0.5 * np.cos(np.linspace(0, np.pi, approach))
    sweeps = []
    last = 0.0
    for mean in settings.mean_pressures:
        for load in settings.loads:
            hung = {number: load}
            target = np.concatenate([last + blend * (half * sweep[0] - last), half * sweep])
            log = excite(arm, target[:, None], {number: plan}, mean, LOG_S, hung)
            last = float(target[-1])
            kept = log.time >= approach * SPACING
            q = log.measured[kept, 0]
            dp = log.pressure[kept, 0, 0] - log.pressure[kept, 0, 1]
            mean_measured = log.pressure[kept, 0].mean(axis=1)
            torque = known_torque(arm, q[:, None], hung)[:, 0]
            sweeps.append(np.stack([q, dp, mean_measured, torque], axis=1))
    return fit_characteristic(sweeps, settings.degree)


def fit_characteristic(sweeps: list[Array], degree: int) -> Characteristic:
    """Fit A, B and C to sweeps, each (T, 4): q [rad], dp [Pa], p_m [Pa], Q [Nm].

    Examples
    --------
    >>> q, dp, load = (x.ravel() for x in np.meshgrid(np.linspace(-0.6, 0.6, 25), [0.0], [-20.0, 0.0, 20.0]))
    >>> sweeps = [np.stack([q, (load + 60e-5 * q * p + 4 * q) / 35e-5, np.full(q.size, p), load], 1) for p in (2e5, 3e5)]
    >>> found = fit_characteristic(sweeps, 3)
    >>> round(float(found.b[0]) * 1e5, 3), round(float(found.a[1]) * 1e5, 3), round(float(found.c[1]), 3)
    (35.0, -60.0, -4.0)
    """
    q, dp, mean, torque = np.concatenate(sweeps).T
    power = q[:, None] ** np.arange(degree + 1)
    scale = (10.0, 1e5)  # torques of 10 Nm, pressures of 1 bar: columns of one size
    regressors = np.hstack([power * (torque / scale[0])[:, None], -power * (mean / scale[1])[:, None], -power])
    found, *_ = np.linalg.lstsq(regressors, dp / scale[1], rcond=None)
    m = degree + 1
    low, high = float(q.min()), float(q.max())
    grid = np.linspace(low, high, 201)
    beta, alpha, gamma = (np.polynomial.polynomial.polyval(grid, found[i * m : (i + 1) * m]) for i in range(3))
    beta = beta * scale[1] / scale[0]  # [Pa/Nm]
    a, b, c = (
        np.polynomial.polynomial.polyfit(grid, y, degree)
        for y in (alpha / beta, 1 / beta, gamma * scale[1] / beta)
    )
    value = np.polynomial.polynomial.polyval
    residual = torque - value(q, a) * mean - value(q, b) * dp - value(q, c)
    return Characteristic(a, b, c, low, high, float(np.sqrt(np.mean(residual**2))), tuple(sweeps))
