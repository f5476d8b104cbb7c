"""Routing of a joint's muscles: moment arms as polynomials of its angle.

The arm r_m(q) = -dl_m/dq of a muscle of length l_m is positive where q > 0 shortens it, and by the principle of virtual
work its pull F_m gives the torque r_m F_m (An, Takahashi, Harrigan, Chao, J. Biomech. Eng. 106 (1984) 280-282).

=============  ======================================================================================================
``routing``    r_1; r_2(q) = -r_1(-q), the mirror image, but for ``moment_arm_2_m`` and tendons
=============  ======================================================================================================
"pulley"       ``radius_m``
"lever"        a b sin(w)/l, l^2 = a^2 + b^2 - 2 a b cos(w), w = ``lever_angle_deg`` - q: muscle 1 spans between two
               points at distances ``lever_m`` = [a, b] from the axis, seen from there under the angle w
"polynomial"   ``moment_arm_m`` = [r0, r1, ...] [m/rad^j], lowest first; ``moment_arm_2_m``: what q lengthens muscle 2
"tendon"       of two spatial tendons of the body's file, ``tendons`` = ["flexor", "extensor"], one a muscle
=============  ======================================================================================================
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from dehyst.arrays import Array
from dehyst.errors import ParameterError
from dehyst_robot.arm._policy import POLICY

if TYPE_CHECKING:
    from dehyst_robot.arm._tables import Joint

Arms = tuple[Array, Array]
DEGREE = 7  # PLANT_ARM of packages/dehyst-robot/plant/plant.h less one
NEEDED = {
    "pulley": ("radius",),
    "lever": ("lever", "lever_angle"),
    "polynomial": ("moment_arm",),
    "tendon": ("tendons",),
}


def joint_arms(joint: Joint, key: str) -> Arms:
    """Return the coefficients of r_1 and r_2, lowest power first, of a joint that is routed by no tendon. [m/rad^j]

    Examples
    --------
    >>> from dehyst_robot.arm import load_robot
    >>> [arm.tolist() for arm in joint_arms(load_robot().joint(1), "joint.1")]
    [[0.05], [-0.05]]
    """
    if joint.routing == "lever":
        # Files that lack these are refused before; nan is for the type checker.
        a, b = joint.lever or (np.nan, np.nan)
        angle = joint.lever_angle or np.nan

        def of_lever(q: Array) -> Array:
            cosine, sine = np.cos(angle - q), np.sin(angle - q)
            return np.asarray(a * b * sine / np.sqrt(a**2 + b**2 - 2 * a * b * cosine))

        first = reduced(of_lever, joint.range, f"{key}.lever_m")
    elif joint.routing == "polynomial":
        first = np.array(joint.moment_arm, dtype=np.float64)
        if joint.moment_arm_2 is not None:
            return first, -np.array(joint.moment_arm_2)
    else:
        first = np.array([joint.radius], dtype=np.float64)
    # The mirror image -r_1(-q): the signs of the even powers change.
    return first, -first * (-1.0) ** np.arange(first.size)


def reduced(arm: Callable[[Array], Array], reach: float, key: str) -> Array:
    """Return an arm over -reach .. reach [rad] as a polynomial of degree 7, or refuse one that is none."""
    # Angles that lie closer at the ends, where polynomials of a high degree are off most.
    q = reach * np.cos(np.pi * np.linspace(0.0, 1.0, 201))
    fitted = np.polynomial.Polynomial.fit(q, arm(q), DEGREE)
    off = float(np.abs(fitted(q) - arm(q)).max() / np.abs(arm(q)).max())
    if not off <= POLICY.tolerated_arm:
        raise ParameterError(
            f"{key}: over the range of {np.degrees(reach):.3g} deg to both sides the moment arm is no polynomial of "
            f"degree {DEGREE}: the best one is off by {off:.2g} of the largest arm, {POLICY.tolerated_arm:g} is "
            f"allowed. A tendon that begins or ends to wrap does that, or one that comes near the axis: make range_deg "
            f"smaller or move its ends.",
            residual=off,
        )
    return np.asarray(fitted.convert().coef, dtype=np.float64)


def contraction(arm: Array, length: float, middle: float) -> np.polynomial.Polynomial:
    """Return kappa(q) = middle + int_0^q r dq/length of a muscle."""
    return np.polynomial.Polynomial([middle, *(arm / np.arange(1, arm.size + 1) / length)])


def refuse_unusable(
    joint: Joint, arms: Arms, lengths: Sequence[float], ends: tuple[float, float], key: str
) -> None:
    """Refuse arms that change their sign within the range, and muscles that contract by more than `ends` there."""
    q = np.linspace(-joint.range, joint.range, 201)
    for m, (arm, side) in enumerate(zip(arms, (1, -1), strict=True)):
        least = side * np.polynomial.polynomial.polyval(q, arm)
        if not (least > 0).all():
            worst = int(np.argmin(least))
            raise ParameterError(
                f"{key}: at {np.degrees(q[worst]):.3g} deg the moment arm of muscle {m + 1} is "
                f"{1e3 * least[worst]:.3g} mm; over the whole range a positive angle must shorten muscle 1 and "
                f"lengthen muscle 2. Make range_deg smaller or exchange the two muscles.",
                muscle=m + 1,
            )
    # A spring in the place of muscle 2 has no length here.
    reached = []
    for arm, length in zip(arms, lengths, strict=False):
        reached.append(contraction(arm, length, joint.middle)(q))
    low, high = float(np.min(reached)), float(np.max(reached))
    if low < ends[0] or high > ends[1]:
        unit = "" if joint.routing == "tendon" else "_m"
        raise ParameterError(
            f"{key}: at the ends of its range its muscles contract by {low:.3f} and {high:.3f} of their length, "
            f"possible are {ends[0]:g} .. {ends[1]:g}. Make {key.rpartition(' ')[2]}.range_deg or "
            f"{NEEDED[joint.routing][0]}{unit} smaller, the muscle longer, or put "
            f"contraction in the middle.",
            low=low,
            high=high,
        )
