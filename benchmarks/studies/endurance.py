"""Hours of operation with everything going wrong: what was learned must stay within its bounds at every period."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from dehyst.errors import ParameterError
from dehyst.models import DirectInverse
from dehyst_robot.arm import Arm, Reference
from dehyst_robot.arm._runs import FAULTS
from dehyst_robot.control import FLAGS, Adaptation
from dehyst_robot.experiments._calibration import home_and_learn
from dehyst_robot.experiments._results import Characteristic
from studies.alone import ADAPT, COMPENSATOR, DISTURBANCE, INTEGRATOR, POSITION, Alone

Array = npt.NDArray[np.float64]

SPACING = 0.01
PIECE_S = 50.0
MEANS = (2e5, 4e5)  # of the mean pressure [Pa]
LARGEST_S = (
    0.3  # of a fault; longer than the controller holds a lost reading, so that it fails safe
)


@dataclass(frozen=True)
class Endured:
    """What was seen in all periods.

    Attributes
    ----------
    seconds
        How long it ran.
    faults
        How many were injected, contacts and changes of load and restarts left out.
    failed
        How often the controller failed safe and was started again.
    lowest, highest, offset
        Of every scale, learned and in use; largest |offset|. [Nm]
    finite
        Whether all were.
    slope
        Lower bound of the slope of the compensated map, over the range, mean pressures and scales that were seen.
        [Pa/rad]
    """

    seconds: float
    faults: int
    failed: int
    lowest: float
    highest: float
    offset: float
    finite: bool
    slope: float

    def within(self, adaptation: Adaptation) -> bool:
        """Whether scales and offset kept within their bounds, and the map could be inverted."""
        scales = adaptation.lowest <= self.lowest and self.highest <= adaptation.highest
        return self.finite and scales and self.offset <= adaptation.offset_limit and self.slope > 0


def endure(joint: Alone, seconds: float, seed: int = 0) -> Endured:
    """Run random motions with faults of sensors and references, contact, loads, limits, restarts and stored states.

    Raises
    ------
    ParameterError
        If the joint has no direct inverse.
    """
    if joint.model is None:
        raise ParameterError(
            "without a direct inverse nothing is learned: pass Alone(..., model=...)."
        )
    draw = np.random.default_rng(seed)
    arm = joint.arm()
    home_and_learn(arm, {joint.number: joint.characteristic})
    faults = failed = 0
    for _ in range(round(seconds / PIECE_S)):
        reference, number = _piece(joint, arm, draw)
        faults += number
        log = arm.run(reference, every_s=1.0)
        if (log.flags & FLAGS["failed"]).any():
            failed += 1
            arm.restart()
        elif draw.random() < 0.3:  # switched off and on again
            images = arm.images()
            arm.restart()
            arm.restore(images)
    lowest, highest, offset, finite = arm.learned_extremes(joint.number)
    slope = map_slope(joint.characteristic, joint.model, highest)
    return Endured(seconds, faults, failed, lowest, highest, offset, finite, slope)


def map_slope(characteristic: Characteristic, model: DirectInverse, scale: float) -> float:
    """Lower bound of d(dp)/dq of characteristic and compensator, whatever the past, scales up to `scale`. [Pa/rad]

    dp = (u(q) - A p_m - C)/B: what B's change with q takes of the hysteresis' part is subtracted at its largest.
    """
    q = np.linspace(characteristic.low, characteristic.high, 401)
    least = model.least_slope(float(q[0]), float(q[-1]), scale)
    b = np.polynomial.polynomial.polyval(q, characteristic.b)
    taken = scale * _height(model) * np.abs(np.gradient(b, q)) / b**2
    rest = (np.gradient(characteristic.difference(q, mean), q) for mean in MEANS)
    return min(float((slope + least / b - taken).min()) for slope in rest)


def _height(model: DirectInverse) -> float:
    """Largest torque of stops and path lags together."""
    stops, paths = model.stop_weights * model.radii, model.path_weights * model.path_lengths
    return float(stops.sum(axis=1).max() + paths.sum(axis=1).max())


def _piece(joint: Alone, arm: Arm, draw: np.random.Generator) -> tuple[Reference, int]:
    """A piece of operation, and how many faults are in it."""
    t: Array = np.asarray(SPACING * np.arange(round(PIECE_S / SPACING) + 1))
    reach = 0.6 * joint.robot.joint(joint.number).range
    motion = _strokes(t, float(arm.encoder_angles[0]), reach, draw)
    on = POSITION | COMPENSATOR | ADAPT
    on |= (INTEGRATOR if draw.random() < 0.5 else 0) | (DISTURBANCE if draw.random() < 0.5 else 0)
    hung = draw.choice([0.0, 0.0, 8.0, -8.0]) * np.clip(
        (t - 5.0) / draw.choice([1e-6, 2.0]), 0.0, 1.0
    )
    at, lasting = draw.uniform(5.0, 35.0), draw.uniform(1.0, 15.0)
    hung = hung + draw.uniform(-10.0, 10.0) * ((t > at) & (t < at + lasting))
    switches = np.full((t.size, 1), on, np.uint32)
    number = int(draw.integers(0, 6))
    for _ in range(number):
        k, length = int(draw.integers(t.size)), max(1, int(draw.uniform(0.0, LARGEST_S) / SPACING))
        switches[k : k + length] |= np.uint32(draw.choice(list(FAULTS.values())))
    reference = Reference.motion(
        SPACING, motion, arm.feedforward(*motion), 3e5, switches, hung=hung[:, None]
    )
    reference.values[:, 0, 4] = np.interp(t, [0.0, 25.0, PIECE_S], draw.uniform(*MEANS, 3))
    return reference, number


def _strokes(
    t: Array, start: float, reach: float, draw: np.random.Generator
) -> tuple[Array, Array, Array]:
    """Strokes between random angles, from slow ones to some that no valve can follow, with rests; (K, 1) each."""
    angle, velocity, acceleration = np.full(t.shape, start), np.zeros(t.shape), np.zeros(t.shape)
    begin, last = 0.0, start
    while begin < t[-1]:
        lasting = float(np.exp(draw.uniform(np.log(0.3), np.log(15.0))))
        goal = float(draw.uniform(-reach, reach))
        u = np.clip((t - begin) / lasting, 0.0, 1.0)
        angle += (goal - last) * u**3 * (10 - 15 * u + 6 * u**2)
        velocity += (goal - last) * 30 * u**2 * (1 - u) ** 2 / lasting
        acceleration += (goal - last) * 60 * u * (1 - u) * (1 - 2 * u) / lasting**2
        begin, last = begin + lasting + float(draw.choice([0.0, 3.0])), goal
    return angle[:, None], velocity[:, None], acceleration[:, None]
