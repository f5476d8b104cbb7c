r"""Joint of two antagonistic muscles on a pulley: characteristic for a controller, torque with friction, inverse.

Positive angles shorten the first muscle, :math:`\kappa_{1,2} = \kappa_0 \pm r q/l_0`, and its torque is positive,

.. math:: Q = r (F_1 - F_2) = A(q)\, p_m + B(q)\, \Delta p + C(q),

with the mean pressure p_m and the difference of the pressures, :math:`p_{1,2} = p_m \pm \Delta p/2`. For muscles with
F = f_a p - f_e,

.. math::

    A = r [f_a(\kappa_1) - f_a(\kappa_2)], \quad B = \tfrac{r}{2} [f_a(\kappa_1) + f_a(\kappa_2)], \quad
    C = -r [f_e(\kappa_1) - f_e(\kappa_2)].

:class:`MuscleJoint` is that pair with the friction and the memory of both: the torques of friction add up, because one
muscle shortens while the other one lengthens. :class:`SlippingJoint` (Vo-Minh, Tjahjowidodo, Ramon, Van Brussel, AIM
2010; structure: own knowledge, high) has Maxwell slip of the angle in place of the muscles' friction,

.. math:: Q = A(q)\, p_m + B(q)\, \Delta p + C(q) - \sum_i W_i\, E_{d_i}[q]/d_i.

At balance and at a fixed mean pressure the pressure difference is the nominal one and a sum of stop operators of the
angle over B. Where B is constant that is the model class of Prandtl-Ishlinskii compensation.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from dehyst._native import play_bank
from dehyst.arrays import Array
from dehyst.errors import InvertibilityError, ParameterError, RecordingError
from dehyst.models.arrays import parameter_array, parameter_number, signal_array, strictly_increasing
from dehyst.robot.muscles.base import FLOATS, MuscleModel
from dehyst.robot.muscles.elements import VoMinh
from dehyst.robot.muscles.maps import Maker
from dehyst.robot.muscles.solve import halved

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
    """Return the characteristic of a joint of two muscles, for `dehyst.robot.control.JointControllerParameters`.

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


@dataclass(frozen=True)
class MuscleJoint:
    """An antagonistic pair; positive angles shorten the first muscle.

    Parameters
    ----------
    first, second
        The muscles.
    radius
        Of the pulley. [m]
    initial_contraction
        Of both at q = 0.

    Raises
    ------
    ParameterError
        If radius or contraction are no numbers, or the radius is not positive.

    Examples
    --------
    >>> from dehyst.robot.muscles import muscle
    >>> joint = MuscleJoint(muscle("maker"), muscle("maker"), radius=0.05, initial_contraction=0.11)
    >>> joint.torque([0.0], [3e5], [1e5]).round(1).tolist()
    [34.9]
    """

    first: MuscleModel
    second: MuscleModel
    radius: float
    initial_contraction: float

    def __post_init__(self) -> None:
        for name in ("radius", "initial_contraction"):
            object.__setattr__(self, name, parameter_number(getattr(self, name), name))
        if not self.radius > 0:
            raise ParameterError(f"radius = {self.radius:g} m must be positive.")

    def contractions(self, angle: npt.ArrayLike) -> tuple[Array, Array]:
        """Return the contractions of both muscles, (T,) each, at angles (T,). [rad]"""
        q, start = signal_array(angle, "angle"), self.initial_contraction
        return start + self.radius * q / self.first.length, start - self.radius * q / self.second.length

    def torque(
        self,
        angle: npt.ArrayLike,
        mean: npt.ArrayLike,
        difference: npt.ArrayLike,
        time: npt.ArrayLike | None = None,
    ) -> Array:
        """Return the torque (T,) along a motion from rest: slack muscles do not push. [Nm]

        Parameters
        ----------
        angle
            (T,) [rad]
        mean, difference
            p_m and dp, (T,) or one for all. [Pa]
        time
            (T,) [s], None for an infinitely slow motion.

        Raises
        ------
        ParameterError, RecordingError
            As `MuscleModel.simulate`.
        """
        k1, k2 = self.contractions(angle)
        pm, dp = _like(mean, k1.size, "mean"), _like(difference, k1.size, "difference")
        pulls = self.first.simulate(k1, pm + dp / 2, time, clamp=True)
        return self.radius * (pulls - self.second.simulate(k2, pm - dp / 2, time, clamp=True))

    def difference(
        self,
        angle: npt.ArrayLike,
        mean: npt.ArrayLike,
        torque: npt.ArrayLike = 0.0,
        time: npt.ArrayLike | None = None,
    ) -> Array:
        """Return the pressure differences (T,) that give a torque along a motion from rest. [Pa]

        Both pressures stay at 0 or above; by halving, because slack muscles and friction bend the torque.

        Raises
        ------
        InvertibilityError
            Where no such difference gives the torque.
        """
        samples = self.contractions(angle)[0].size
        pm, wanted = _like(mean, samples, "mean"), _like(torque, samples, "torque")
        if np.any(pm < 0):
            raise ParameterError(f"mean pressure {float(pm.min()):g} Pa is below 0; it is a gauge pressure.")
        most, least = self.torque(angle, pm, 2 * pm, time), self.torque(angle, pm, -2 * pm, time)
        slack = 1e-9 * (1.0 + np.abs(most) + np.abs(least))
        beyond = np.flatnonzero((wanted > most + slack) | (wanted < least - slack))
        if beyond.size:
            i = int(beyond[0])
            raise InvertibilityError(
                f"at sample {i} a mean pressure of {pm[i]:g} Pa gives {least[i]:.4g} to {most[i]:.4g} Nm, not "
                f"{wanted[i]:.4g} Nm. Raise the mean pressure, or ask for less.",
                index=i,
            )
        return halved(lambda dp: self.torque(angle, pm, dp, time), wanted, -2 * pm, 2 * pm)

    def characteristic(self, reach: float = 0.7, degree: int = 5) -> JointCharacteristic:
        """Return the polynomials without friction, for a joint controller; see `joint_characteristic`."""
        other = None if self.first == self.second else self.second
        start = self.initial_contraction
        return joint_characteristic(self.first, self.radius, start, opposing=other, reach=reach, degree=degree)


@dataclass(frozen=True)
class SlippingJoint:
    """A characteristic and Maxwell slip of the angle (Vo-Minh and others 2010).

    Parameters
    ----------
    characteristic
        A, B and C.
    slip_angles
        d_i, (n,), increasing. [rad]
    slip_torques
        W_i, (n,). [Nm]

    Raises
    ------
    ParameterError
        If angles do not increase from above 0, or there is not one torque for each.

    Examples
    --------
    >>> from dehyst.robot.muscles import muscle
    >>> joint = SlippingJoint.of_muscles(muscle("vo-minh"), radius=0.03, initial_contraction=0.1)
    >>> round(joint.size, 3)  # 2 r times 20 N
    1.2
    """

    characteristic: JointCharacteristic
    slip_angles: tuple[float, ...]
    slip_torques: tuple[float, ...]

    def __post_init__(self) -> None:
        angles, torques = (parameter_array(getattr(self, n), n) for n in ("slip_angles", "slip_torques"))
        strictly_increasing(angles, "slip_angles")
        if angles.size != torques.size or not angles[0] > 0 or np.min(torques) < 0:
            raise ParameterError(
                f"{angles.size} slip angles from {angles[0]:g} rad and {torques.size} slip torques from "
                f"{np.min(torques):g} Nm: pass a torque of 0 or more for each positive angle."
            )
        object.__setattr__(self, "slip_angles", tuple(angles.tolist()))
        object.__setattr__(self, "slip_torques", tuple(torques.tolist()))

    @classmethod
    def of_muscles(cls, muscle: VoMinh, radius: float, initial_contraction: float, mean: float = 3e5) -> Self:
        """Return the joint of two equal muscles that slip, at a mean pressure [Pa]: exact where sigma is 0."""
        joint = MuscleJoint(muscle, muscle, radius, initial_contraction)
        g = 1.0 - muscle.pressure_share + muscle.pressure_share * mean / muscle.reference_pressure
        return cls(
            joint.characteristic(),
            tuple(d * muscle.length / radius for d in muscle.slip_strains),
            tuple(2.0 * radius * g * w for w in muscle.slip_forces),
        )

    @property
    def size(self) -> float:
        """Torque when everything slips. [Nm]"""
        return float(sum(self.slip_torques))

    def friction(self, angle: npt.ArrayLike) -> Array:
        """Return the torque (T,) that opposes a motion from rest. [Nm]"""
        q, d = signal_array(angle, "angle"), np.array(self.slip_angles)
        if q.size == 0:
            return q
        if not np.all(np.isfinite(q)):
            raise ParameterError(f"angle {float(q[~np.isfinite(q)][0])!r} is not a finite number.")
        plays, _ = play_bank(q, d, np.full(d.size, q[0]), np.arange(q.size, dtype=np.int64))
        return np.asarray(((q[:, None] - plays) / d) @ np.array(self.slip_torques))

    def torque(self, angle: npt.ArrayLike, mean: npt.ArrayLike, difference: npt.ArrayLike) -> Array:
        """Return the torque (T,) along a motion from rest, at pressures [Pa]. [Nm]"""
        q = signal_array(angle, "angle")
        pm, dp = _like(mean, q.size, "mean"), _like(difference, q.size, "difference")
        return np.asarray(self.characteristic.torque(q, pm, dp)) - self.friction(q)

    def difference(self, angle: npt.ArrayLike, mean: npt.ArrayLike, torque: npt.ArrayLike = 0.0) -> Array:
        """Return the pressure differences (T,) that give a torque along a motion from rest. [Pa]

        Raises
        ------
        InvertibilityError
            Where B is not positive.
        """
        q = signal_array(angle, "angle")
        pm, wanted = _like(mean, q.size, "mean"), _like(torque, q.size, "torque")
        gain = np.polynomial.polynomial.polyval(q, self.characteristic.b)
        if np.any(gain <= 0):
            raise InvertibilityError(
                f"at {float(q[gain <= 0][0]):.4g} rad a pressure difference gives no torque of its sign (B = "
                f"{float(gain.min()):.4g} Nm/Pa): stay within {self.characteristic.reach:g} rad."
            )
        rest = wanted + self.friction(q) - np.asarray(self.characteristic.torque(q, pm, 0.0))
        return np.asarray(rest / gain)


def identify_slips(
    characteristic: JointCharacteristic,
    angle: npt.ArrayLike,
    mean: npt.ArrayLike,
    difference: npt.ArrayLike,
    torque: npt.ArrayLike = 0.0,
    slip_angles: npt.ArrayLike | None = None,
) -> SlippingJoint:
    """Return the joint whose slip torques explain a motion from rest best: non-negative least squares, one solution.

    Parameters
    ----------
    characteristic
        Without hysteresis, from `MuscleJoint.characteristic` or a calibration.
    angle
        (T,), beginning where a homing left the joint. [rad]
    mean, difference, torque
        (T,) or one for all. [Pa, Pa, Nm]
    slip_angles
        (n,) where elements may slip; ten from 1 % to all of the largest stroke if none are given. [rad]

    Raises
    ------
    RecordingError
        If lengths differ, or the angle does not move.

    Examples
    --------
    >>> from dehyst.robot.muscles import muscle
    >>> true = SlippingJoint.of_muscles(muscle("vo-minh"), radius=0.03, initial_contraction=0.1)
    >>> q = 0.6 * np.sin(np.linspace(0.0, 7.0, 500))
    >>> found = identify_slips(true.characteristic, q, 3e5, true.difference(q, 3e5))
    >>> bool(np.max(np.abs(found.friction(q) - true.friction(q))) < 0.03 * true.size)
    True
    """
    from scipy.optimize import nnls

    q = signal_array(angle, "angle")
    stroke = float(np.ptp(q)) if q.size else 0.0
    if not (stroke > 0 and np.isfinite(stroke)):
        raise RecordingError("the angle does not move, or is not finite: no friction can be told from it.")
    d = np.geomspace(0.01, 1.0, 10) * stroke if slip_angles is None else parameter_array(slip_angles, "slip_angles")
    plays, _ = play_bank(q, d, np.full(d.size, q[0]), np.arange(q.size, dtype=np.int64))
    still = characteristic.torque(q, _like(mean, q.size, "mean"), _like(difference, q.size, "difference"))
    torques, _ = nnls((q[:, None] - plays) / d, np.asarray(still) - _like(torque, q.size, "torque"))
    return SlippingJoint(characteristic, tuple(d.tolist()), tuple(torques.tolist()))


def _like(values: npt.ArrayLike, samples: int, name: str) -> Array:
    """One value a sample."""
    array = np.full(samples, parameter_number(values, name)) if np.ndim(values) == 0 else signal_array(values, name)  # type: ignore[arg-type]
    if array.size != samples:
        raise RecordingError(f"{name} has {array.size} samples, the angle {samples}; pass one for each.")
    return array


class MuscleMechanism:
    """A muscle model in place of the plant's muscle: a `dehyst.robot.arm.mechanisms.Mechanism`.

    Parameters
    ----------
    model
        The muscle.
    plant_map
        Static map of the plant's muscle, which is taken off; None for that of a DMSP-40 by the maker's tool.

    Notes
    -----
    The plant scales its map by the tolerance of each muscle: set ``tolerance.force`` to 0 for the model alone.

    Examples
    --------
    >>> from dehyst.robot.muscles import muscle
    >>> mechanism = MuscleMechanism(muscle("sarosi"))
    >>> mechanism.reset(0.1)
    >>> plant, model = Maker(), muscle("sarosi")
    >>> force = float(plant.static_force(0.1, 3e5)) - mechanism.force(0.1, 3e5, 5e-4)
    >>> round(force - float(model.static_force(0.1, 3e5)), 9)
    0.0
    """

    def __init__(self, model: MuscleModel, plant_map: MuscleModel | None = None) -> None:
        self._step = model.stepper(0.0)
        self._map = (plant_map or Maker())._static

    def reset(self, contraction: float) -> None:
        """Forget everything; the muscle rests at this contraction."""
        self._step.reset(contraction)

    def force(self, contraction: float, pressure: float, period: float) -> float:
        """Return the plant's map less the model's force after moving there within a period [s]. [N]"""
        return float(self._map(contraction, pressure, FLOATS)) - self._step(contraction, pressure, period)
