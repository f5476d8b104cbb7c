r"""Two muscles of a model around a pulley: the characteristic that a joint controller works with.

Positive angles shorten the first muscle, :math:`\kappa_{1,2} = \kappa_0 \pm r q/l_0`, and its torque is positive,

.. math:: Q = r (F_1 - F_2) = A(q)\, p_m + B(q)\, \Delta p + C(q),

with the mean pressure p_m and the difference of the pressures, :math:`p_{1,2} = p_m \pm \Delta p/2`. For muscles with
F = f_a p - f_e,

.. math::

    A = r [f_a(\kappa_1) - f_a(\kappa_2)], \quad B = \tfrac{r}{2} [f_a(\kappa_1) + f_a(\kappa_2)], \quad
    C = -r [f_e(\kappa_1) - f_e(\kappa_2)].
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from dehyst.arrays import Array
from dehyst.errors import ParameterError
from dehyst.models.arrays import parameter_number
from dehyst.robot.muscles.base import MuscleModel

_POINTS = 401
_MOST = 7  # degree that a joint controller takes


@dataclass(frozen=True)
class JointCharacteristic:
    """Torque of an antagonistic pair as polynomials in the angle.

    Attributes
    ----------
    a, b
        Coefficients of A and B, lowest power first. [Nm/Pa]
    c
        Coefficients of C. [Nm]
    reach
        Largest angle of the fit, to both sides. [rad]
    residual
        Largest error of the torque within it, at 3 bar in the mean and a difference of up to 2 bar. [Nm]
    """

    a: tuple[float, ...]
    b: tuple[float, ...]
    c: tuple[float, ...]
    reach: float
    residual: float

    def fields(self) -> dict[str, Any]:
        """Return what ``JointControllerParameters(**fields)`` takes of it."""
        return {"a": self.a, "b": self.b, "c": self.c, "angle_low": -self.reach, "angle_high": self.reach}

    def torque(self, angle: Any, mean: Any, difference: Any) -> Any:
        """Return Q [Nm] at angles [rad], mean pressures and pressure differences [Pa]."""
        a, b, c = (np.polynomial.polynomial.polyval(angle, k) for k in (self.a, self.b, self.c))
        return a * mean + b * difference + c

    def balance(self, angle: Any, mean: Any) -> Any:
        """Return the pressure difference that holds an angle without load. [Pa]"""
        a, b, c = (np.polynomial.polynomial.polyval(angle, k) for k in (self.a, self.b, self.c))
        return (-a * mean - c) / b


def joint_characteristic(
    muscle: MuscleModel,
    radius: float,
    initial_contraction: float,
    *,
    opposing: MuscleModel | None = None,
    reach: float = 0.7,
    degree: int = 5,
) -> JointCharacteristic:
    """Return the characteristic of a joint of two muscles, for `dehyst.control.JointControllerParameters`.

    Parameters
    ----------
    muscle
        The first one; the second one too unless `opposing` is given.
    radius
        r of the pulley. [m]
    initial_contraction
        kappa_0 of both at q = 0.
    opposing
        The second one.
    reach
        Largest angle to both sides. [rad]
    degree
        Of the polynomials, 7 at most. For two equal muscles A and C are odd and B is even.

    Returns
    -------
    JointCharacteristic
        With the largest error of the fit.

    Raises
    ------
    ParameterError
        If a muscle leaves the range of its formulas within the reach, or a value has no meaning.

    Examples
    --------
    >>> from dehyst.robot.muscles import muscle
    >>> joint = joint_characteristic(muscle("maker"), radius=0.05, initial_contraction=0.11)
    >>> round(joint.b[0] * 1e5, 1)
    34.9
    """
    r, start, most = (
        parameter_number(v, n) for v, n in ((radius, "radius"), (initial_contraction, "contraction"), (reach, "reach"))
    )
    if not (r > 0 and most > 0 and 1 <= degree <= _MOST):
        raise ParameterError(
            f"radius = {r:g} m, reach = {most:g} rad, degree = {degree}: pass > 0, > 0 and 1 to {_MOST}."
        )
    second = opposing or muscle
    q = most * np.cos(np.linspace(np.pi, 0.0, _POINTS))  # dense towards the ends: close to the best fit
    pull_1, hold_1 = muscle.affine(start + r * q / muscle.length)
    pull_2, hold_2 = second.affine(start - r * q / second.length)
    curves = r * (pull_1 - pull_2), 0.5 * r * (pull_1 + pull_2), -r * (hold_1 - hold_2)
    same = opposing is None
    a, b, c = (_fitted(q, y, degree, parity if same else None) for y, parity in zip(curves, (1, 0, 1), strict=True))
    fit = JointCharacteristic(a, b, c, most, 0.0)
    errors = [fit.torque(q, 3e5, dp) - (curves[0] * 3e5 + curves[1] * dp + curves[2]) for dp in (-2e5, 0.0, 2e5)]
    return JointCharacteristic(a, b, c, most, float(np.max(np.abs(errors))))


def _fitted(q: Array, y: Array, degree: int, parity: int | None) -> tuple[float, ...]:
    """Least squares in the powers of one parity, or in all."""
    powers = [k for k in range(degree + 1) if parity is None or k % 2 == parity]
    size = float(np.max(np.abs(q)))
    solution, *_ = np.linalg.lstsq(np.stack([(q / size) ** k for k in powers], axis=1), y, rcond=None)
    coefficients = np.zeros(degree + 1)
    coefficients[powers] = solution / size ** np.array(powers)
    return tuple(coefficients.tolist())
