r"""Joint of two antagonistic muscles on a pulley with friction, and the joint model of Vo-Minh and others.

:class:`MuscleJoint` puts two muscle models together: what each of them remembers, the joint remembers. Its friction
torque is the sum of both, because one shortens while the other one lengthens.

:class:`SlippingJoint` (Vo-Minh, Tjahjowidodo, Ramon, Van Brussel, AIM 2010; structure: own knowledge, high) forgets
about muscles: a characteristic without hysteresis, and Maxwell slip of the angle,

.. math:: Q = A(q)\, p_m + B(q)\, \Delta p + C(q) - \sum_i W_i\, E_{d_i}[q]/d_i.

At balance and at a fixed mean pressure the pressure difference is the nominal one and a sum of stop operators of the
angle over B. Where B is constant that is the model class of Prandtl-Ishlinskii compensation.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np
import numpy.typing as npt

from dehyst._native import play_bank
from dehyst.arrays import Array
from dehyst.errors import InvertibilityError, ParameterError, RecordingError
from dehyst.models.arrays import parameter_array, parameter_number, signal_array, strictly_increasing
from dehyst.robot.muscles.base import FLOATS, MuscleModel
from dehyst.robot.muscles.joint import JointCharacteristic, joint_characteristic
from dehyst.robot.muscles.maker import Maker
from dehyst.robot.muscles.vo_minh import VoMinh

_HALVINGS = 60


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
        low, high = -2 * pm, 2 * pm
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            above = self.torque(angle, pm, middle, time) > wanted
            low, high = np.where(above, low, middle), np.where(above, middle, high)
        return 0.5 * (low + high)

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
