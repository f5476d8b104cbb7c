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
from dehyst.models import kit as models_kit
from dehyst_robot.muscles._base import FLOATS, MuscleModel, constant_or_signal
from dehyst_robot.muscles._elements import VoMinh
from dehyst_robot.muscles._maps import Maker
from dehyst_robot.muscles._solve import halved

_POINTS = 401  # angles of the fit of a characteristic
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
        """Return the fields of ``JointControllerParameters(**fields)`` that it determines."""
        return {
            "a": self.a,
            "b": self.b,
            "c": self.c,
            "angle_low": -self.reach,
            "angle_high": self.reach,
        }

    def torque(self, angle: Any, mean: Any, difference: Any) -> Any:
        """Return Q [Nm] at angles [rad], mean pressures and pressure differences [Pa]."""
        a, b, c = self._values(angle)
        return a * mean + b * difference + c

    def balance(self, angle: Any, mean: Any) -> Any:
        """Return the pressure difference that holds an angle without load. [Pa]"""
        a, b, c = self._values(angle)
        return (-a * mean - c) / b

    def _values(self, angle: Any) -> tuple[Any, Any, Any]:
        """Return A, B and C at angles."""
        return (
            np.polynomial.polynomial.polyval(angle, self.a),
            np.polynomial.polynomial.polyval(angle, self.b),
            np.polynomial.polynomial.polyval(angle, self.c),
        )


def joint_characteristic(
    muscle: MuscleModel,
    radius: float,
    initial_contraction: float,
    *,
    opposing: MuscleModel | None = None,
    reach: float = 0.7,
    degree: int = 5,
) -> JointCharacteristic:
    """Return the characteristic of a joint of two muscles, for `dehyst_robot.control.JointControllerParameters`.

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
    >>> from dehyst_robot.muscles import muscle
    >>> joint = joint_characteristic(muscle("maker"), radius=0.05, initial_contraction=0.11)
    >>> round(joint.b[0] * 1e5, 1)
    34.9
    """
    r = models_kit.parameter_number(radius, "radius")
    start = models_kit.parameter_number(initial_contraction, "contraction")
    most = models_kit.parameter_number(reach, "reach")
    if not (r > 0 and most > 0 and 1 <= degree <= _MOST):
        raise ParameterError(
            f"radius = {r:g} m, reach = {most:g} rad, degree = {degree}: pass > 0, > 0 and 1 to {_MOST}."
        )
    second = opposing or muscle
    # Angles that lie closer at the ends make a fit whose largest error is nearly the least one.
    q = most * np.cos(np.linspace(np.pi, 0.0, _POINTS))
    pull_1, hold_1 = muscle.affine(start + r * q / muscle.length)
    pull_2, hold_2 = second.affine(start - r * q / second.length)
    curve_a = r * (pull_1 - pull_2)
    curve_b = 0.5 * r * (pull_1 + pull_2)
    curve_c = -r * (hold_1 - hold_2)
    # Equal muscles make A and C odd and B even.
    odd = even = None
    if opposing is None:
        odd, even = 1, 0
    a = _fitted(q, curve_a, degree, odd)
    b = _fitted(q, curve_b, degree, even)
    c = _fitted(q, curve_c, degree, odd)
    fit = JointCharacteristic(a, b, c, most, 0.0)
    residual = 0.0
    for dp in (-2e5, 0.0, 2e5):
        error = fit.torque(q, 3e5, dp) - (curve_a * 3e5 + curve_b * dp + curve_c)
        residual = max(residual, float(np.max(np.abs(error))))
    return JointCharacteristic(a, b, c, most, residual)


def _fitted(q: Array, y: Array, degree: int, parity: int | None) -> tuple[float, ...]:
    """Return the least squares in the powers of one parity, or in all."""
    powers = np.arange(degree + 1)
    if parity is not None:
        powers = powers[powers % 2 == parity]
    # Scaled angles keep the powers of one size.
    size = float(np.max(np.abs(q)))
    columns = np.stack([(q / size) ** k for k in powers.tolist()], axis=1)
    solution, *_ = np.linalg.lstsq(columns, y, rcond=None)
    coefficients = np.zeros(degree + 1)
    coefficients[powers] = solution / size**powers
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
    >>> from dehyst_robot.muscles import muscle
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
            object.__setattr__(self, name, models_kit.parameter_number(getattr(self, name), name))
        if not self.radius > 0:
            raise ParameterError(f"radius = {self.radius:g} m must be positive.")

    def contractions(self, angle: npt.ArrayLike) -> tuple[Array, Array]:
        """Return the contractions of both muscles, (T,) each, at angles (T,). [rad]"""
        q = models_kit.signal_array(angle, "angle")
        start = self.initial_contraction
        return (
            start + self.radius * q / self.first.length,
            start - self.radius * q / self.second.length,
        )

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
        pm = _like_angle(mean, k1.size, "mean")
        dp = _like_angle(difference, k1.size, "difference")
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

        Both pressures stay at 0 or above. It is solved by halving, because slack muscles and friction bend the torque.

        Raises
        ------
        InvertibilityError
            Where no such difference gives the torque.
        """
        samples = self.contractions(angle)[0].size
        pm = _like_angle(mean, samples, "mean")
        desired = _like_angle(torque, samples, "torque")
        if np.any(pm < 0):
            raise ParameterError(
                f"mean pressure {float(pm.min()):g} Pa is below 0; it is a gauge pressure."
            )
        # At a difference of twice the mean pressure one muscle is empty.
        most = self.torque(angle, pm, 2 * pm, time)
        least = self.torque(angle, pm, -2 * pm, time)
        slack = 1e-9 * (1.0 + np.abs(most) + np.abs(least))
        beyond = np.flatnonzero((desired > most + slack) | (desired < least - slack))
        if beyond.size:
            i = int(beyond[0])
            raise InvertibilityError(
                f"at sample {i} a mean pressure of {pm[i]:g} Pa gives {least[i]:.4g} to {most[i]:.4g} Nm, not "
                f"{desired[i]:.4g} Nm. Raise the mean pressure, or ask for less.",
                index=i,
            )
        return halved(lambda dp: self.torque(angle, pm, dp, time), desired, -2 * pm, 2 * pm)

    def characteristic(self, reach: float = 0.7, degree: int = 5) -> JointCharacteristic:
        """Return the polynomials without friction, for a joint controller; see `joint_characteristic`."""
        opposing = None
        if self.first != self.second:
            opposing = self.second
        start = self.initial_contraction
        return joint_characteristic(
            self.first, self.radius, start, opposing=opposing, reach=reach, degree=degree
        )


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
    >>> from dehyst_robot.muscles import muscle
    >>> joint = SlippingJoint.of_muscles(muscle("vo-minh"), radius=0.03, initial_contraction=0.1)
    >>> round(joint.size, 3)  # 2 r times 20 N
    1.2
    """

    characteristic: JointCharacteristic
    slip_angles: tuple[float, ...]
    slip_torques: tuple[float, ...]

    def __post_init__(self) -> None:
        angles = models_kit.parameter_array(self.slip_angles, "slip_angles")
        torques = models_kit.parameter_array(self.slip_torques, "slip_torques")
        models_kit.strictly_increasing(angles, "slip_angles")
        if angles.size != torques.size or not angles[0] > 0 or np.min(torques) < 0:
            raise ParameterError(
                f"{angles.size} slip angles from {angles[0]:g} rad and {torques.size} slip torques from "
                f"{np.min(torques):g} Nm: pass a torque of 0 or more for each positive angle."
            )
        object.__setattr__(self, "slip_angles", tuple(angles.tolist()))
        object.__setattr__(self, "slip_torques", tuple(torques.tolist()))

    @classmethod
    def of_muscles(
        cls, muscle: VoMinh, radius: float, initial_contraction: float, mean: float = 3e5
    ) -> Self:
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
        q = models_kit.signal_array(angle, "angle")
        d = np.array(self.slip_angles)
        if q.size == 0:
            return q
        if not np.all(np.isfinite(q)):
            raise ParameterError(f"angle {float(q[~np.isfinite(q)][0])!r} is not a finite number.")
        # A stop operator is the angle less a play operator of the same threshold.
        plays, _ = play_bank(q, d, np.full(d.size, q[0]), np.arange(q.size, dtype=np.int64))
        return np.asarray(((q[:, None] - plays) / d) @ np.array(self.slip_torques))

    def torque(self, angle: npt.ArrayLike, mean: npt.ArrayLike, difference: npt.ArrayLike) -> Array:
        """Return the torque (T,) along a motion from rest, at pressures [Pa]. [Nm]"""
        q = models_kit.signal_array(angle, "angle")
        pm = _like_angle(mean, q.size, "mean")
        dp = _like_angle(difference, q.size, "difference")
        return np.asarray(self.characteristic.torque(q, pm, dp)) - self.friction(q)

    def difference(
        self, angle: npt.ArrayLike, mean: npt.ArrayLike, torque: npt.ArrayLike = 0.0
    ) -> Array:
        """Return the pressure differences (T,) that give a torque along a motion from rest. [Pa]

        Raises
        ------
        InvertibilityError
            Where B is not positive.
        """
        q = models_kit.signal_array(angle, "angle")
        pm = _like_angle(mean, q.size, "mean")
        desired = _like_angle(torque, q.size, "torque")
        # B: torque for a pressure difference of 1 Pa.
        gain = np.polynomial.polynomial.polyval(q, self.characteristic.b)
        if np.any(gain <= 0):
            raise InvertibilityError(
                f"at {float(q[gain <= 0][0]):.4g} rad a pressure difference gives no torque of its sign (B = "
                f"{float(gain.min()):.4g} Nm/Pa): stay within {self.characteristic.reach:g} rad."
            )
        static = np.asarray(self.characteristic.torque(q, pm, 0.0))
        return np.asarray((desired + self.friction(q) - static) / gain)


def identify_slips(
    characteristic: JointCharacteristic,
    angle: npt.ArrayLike,
    mean: npt.ArrayLike,
    difference: npt.ArrayLike,
    torque: npt.ArrayLike = 0.0,
    slip_angles: npt.ArrayLike | None = None,
) -> SlippingJoint:
    """Return the joint whose slip torques fit a motion from rest best, by non-negative least squares.

    Parameters
    ----------
    characteristic
        Without hysteresis, from `MuscleJoint.characteristic` or a calibration.
    angle
        (T,), from the end of a homing on. [rad]
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
    >>> from dehyst_robot.muscles import muscle
    >>> true = SlippingJoint.of_muscles(muscle("vo-minh"), radius=0.03, initial_contraction=0.1)
    >>> q = 0.6 * np.sin(np.linspace(0.0, 7.0, 500))
    >>> fit = identify_slips(true.characteristic, q, 3e5, true.difference(q, 3e5))
    >>> bool(np.max(np.abs(fit.friction(q) - true.friction(q))) < 0.03 * true.size)
    True
    """
    from scipy.optimize import nnls

    q = models_kit.signal_array(angle, "angle")
    stroke = 0.0
    if q.size:
        stroke = float(np.ptp(q))
    if not (stroke > 0 and np.isfinite(stroke)):
        raise RecordingError("the angle does not move, or is not finite: it shows no friction.")
    d = np.geomspace(0.01, 1.0, 10) * stroke
    if slip_angles is not None:
        d = models_kit.parameter_array(slip_angles, "slip_angles")
    pm = _like_angle(mean, q.size, "mean")
    dp = _like_angle(difference, q.size, "difference")
    # What the characteristic gives beyond the load is friction: a sum of stops with torques of 0 or more.
    plays, _ = play_bank(q, d, np.full(d.size, q[0]), np.arange(q.size, dtype=np.int64))
    static = np.asarray(characteristic.torque(q, pm, dp))
    torques, _ = nnls((q[:, None] - plays) / d, static - _like_angle(torque, q.size, "torque"))
    return SlippingJoint(characteristic, tuple(d.tolist()), tuple(torques.tolist()))


def _like_angle(values: npt.ArrayLike, samples: int, name: str) -> Array:
    """Return one value for each sample of the angle."""
    array = constant_or_signal(values, samples, name)
    if array.size != samples:
        raise RecordingError(
            f"{name} has {array.size} samples, the angle {samples}; pass one for each."
        )
    return array


class MuscleMechanism:
    """A muscle model in place of the plant's muscle: a `dehyst_robot.Mechanism`.

    Parameters
    ----------
    model
        The muscle.
    plant_map
        Static map of the plant's muscle, which is subtracted; None for that of a DMSP-40 by the maker's tool.

    Notes
    -----
    The plant scales its map by the tolerance of each muscle: set ``tolerance.force`` to 0 for the model alone.

    Examples
    --------
    >>> from dehyst_robot.muscles import muscle
    >>> mechanism = MuscleMechanism(muscle("sarosi"))
    >>> mechanism.reset(0.1)
    >>> plant, model = muscle("maker"), muscle("sarosi")
    >>> force = float(plant.static_force(0.1, 3e5)) - mechanism.force(0.1, 3e5, 5e-4)
    >>> round(force - float(model.static_force(0.1, 3e5)), 9)
    0.0
    """

    def __init__(self, model: MuscleModel, plant_map: MuscleModel | None = None) -> None:
        self._step = model.stepper(0.0)
        # The plant adds its own map to the mechanism's force: the mechanism returns the difference.
        self._map = (plant_map or Maker.published())._static

    def reset(self, contraction: float) -> None:
        """Forget everything; the muscle rests at this contraction."""
        self._step.reset(contraction)

    def force(self, contraction: float, pressure: float, period: float) -> float:
        """Return the plant's map less the model's force after moving there within a period [s]. [N]"""
        return float(self._map(contraction, pressure, FLOATS)) - self._step(
            contraction, pressure, period
        )
