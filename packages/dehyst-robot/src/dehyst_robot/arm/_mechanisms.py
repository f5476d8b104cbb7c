"""Hysteresis mechanisms of the simulated muscle: seven built in, none, or user-defined.

All act in parallel to the static force map and oppose the contraction kappa = (l_0 - l)/l_0. They have one size and one
scale of strain, so that their virgin curves (force along a first contraction from rest) are close to

    f(kappa) = size g(p) (1 - exp(-kappa/kappa_s)),   g(p) = constant_share + pressure_share p/reference_pressure,

to 0.1 of the size where they move fast, and differ in what they remember. No compensator of `reproduce` has a term that
is one of the last four:

| mechanism | built of | reversals |
|---|---|---|
| :func:`maxwell_slip` | springs that slip | return-point memory; shape of a loop does not depend on where it lies |
| :func:`preisach` | Everett function of a smooth, non-separable density | return-point memory; depends on where |
| :func:`dahl` | three Dahl elements | no memory: small loops drift |
| :func:`braid` | springs whose slip force follows the angle of the braid | loops are wide where the muscle is long |
| :func:`lugre` | a bristle of LuGre | loops are narrow at high speed |
| :func:`pinched` | a pinched Bouc-Wen spring, softer at first | each is soft once, just past the zero of the force |
| :func:`ageing` | springs whose contacts grow at rest | the stroke after a rest is stiffer than the next |

Strain 0.0125 is 5 mm of a muscle of 0.4 m; sizes of 1 to 3 % of the largest force are published. Both are assumptions
that were made before any compensator was run.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import Any, Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

from dehyst.errors import ParameterError
from dehyst_robot._native import PLANT_ELEMENTS

Parameters = dict[str, Any]

NONE, MAXWELL_SLIP, PREISACH, DAHL, BRAID, LUGRE, PINCHED, AGEING, FOREIGN = range(9)
STRAIN_SCALE = 0.0125
SPRINGS = 40
SPRING_STRAINS = (2e-4, 4e-2)
# Of the Preisach mechanism, whose virgin curve is about 1 - exp(-12.8 x), see packages/dehyst-robot/plant/preisach.c.
_RANGE_IN_SCALES = 12.8


@runtime_checkable
class Mechanism(Protocol):
    """A user-defined hysteresis mechanism, one object a muscle; the factory is passed as ``mechanisms``.

    The simulation calls it once a step and muscle; a call costs about 1 us. An exception in it, or a force that is not
    finite, ends the run and is raised there.

    Examples
    --------
    >>> class Coulomb:
    ...     def reset(self, contraction):
    ...         self.last = contraction
    ...
    ...     def force(self, contraction, pressure, period):
    ...         change, self.last = contraction - self.last, contraction
    ...         return 80.0 * math.tanh(change / 1e-6)
    >>> isinstance(Coulomb(), Mechanism)
    True
    """

    def reset(self, contraction: float) -> None:
        """Forget everything; the muscle rests at this contraction."""

    def force(self, contraction: float, pressure: float, period: float) -> float:
        """Return the force that opposes contraction after moving there within a period [s]; gauge pressure [Pa]. [N]"""


MechanismFactory = Callable[[int, int], Mechanism]
"""Joint number and muscle, 0 or 1, -> a new mechanism for it; each new arm calls it for each of its muscles."""


def mechanisms_of(
    factory: MechanismFactory | None, joints: Iterable[int]
) -> dict[int, tuple[Mechanism, Mechanism]]:
    """Return two new mechanisms for each joint, for `dehyst_robot.arm.Arm`; none without a factory."""
    pairs: dict[int, tuple[Mechanism, Mechanism]] = {}
    if factory is None:
        return pairs
    for joint in joints:
        pairs[joint] = (_made(factory, joint, 0), _made(factory, joint, 1))
    return pairs


def _made(factory: MechanismFactory, joint: int, muscle: int) -> Mechanism:
    mechanism = factory(joint, muscle)
    if not isinstance(mechanism, Mechanism):
        raise ParameterError(
            f"for muscle {muscle} of joint {joint} the factory made a {type(mechanism).__name__}, no mechanism: "
            f"give it reset(contraction) and force(contraction, pressure, period) -> N.",
            joint=joint,
        )
    return mechanism


def maxwell_slip(
    size: float,
    elements: int = SPRINGS,
    strain: tuple[float, float] = SPRING_STRAINS,
    strain_scale: float = STRAIN_SCALE,
    **common: float,
) -> Parameters:
    """Return springs in parallel, each slipping at a force that grows with pressure (Maxwell slip, 1867; Iwan, 1966).

        f_i <- clip(f_i + k_i dkappa, -W_i, W_i)
        k_i = size share_i/strain_i,   W_i = share_i size g(p) (1 +- asymmetry)

    Shares are such that the virgin curve at the reference pressure is size (1 - exp(-x/x_s))/(1 - exp(-x_n/x_s)) at
    every slip strain x_i; at the largest, x_n, everything slips.

    Parameters
    ----------
    size
        Force when everything slips, at the reference pressure. [N]
    elements
        Number of springs, at most 64.
    strain
        Smallest and largest slip strain at the reference pressure, log spaced.
    strain_scale
        x_s, the strain at which 63 % of the size are reached.
    **common
        ``pressure_share``, ``constant_share``, ``reference_pressure`` [Pa], ``asymmetry``, as of :func:`shared`.

    Returns
    -------
    dict
        Fields of ``plant_hysteresis`` in packages/dehyst-robot/plant/plant.h, for ``muscle["hysteresis"]`` of a joint.

    Raises
    ------
    ParameterError
        If a number lies outside its range.

    Examples
    --------
    >>> mechanism = maxwell_slip(80.0)
    >>> len(mechanism["share"]), round(sum(mechanism["share"]), 12)
    (40, 1.0)
    """
    return _mechanism(MAXWELL_SLIP, size, *_springs(elements, strain, strain_scale), common)


def _springs(
    elements: int, strain: tuple[float, float], strain_scale: float
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Return slip strains and shares of springs whose virgin curve is 1 - exp(-x/x_s)."""
    _positive(strain_scale=strain_scale)
    if not 1 <= elements <= PLANT_ELEMENTS:
        raise ParameterError(
            f"elements = {elements}: the plant keeps 1 to {PLANT_ELEMENTS} elements a muscle; choose one of these",
            elements=elements,
        )
    if not 0 < strain[0] < strain[1] and elements > 1:
        raise ParameterError(
            f"strain = {strain}: slip strains run from a positive smallest to a larger one; try (2e-4, 4e-2)",
            strain=strain,
        )
    x = np.geomspace(strain[0], strain[1], elements)
    if elements == 1:
        x = np.array([strain[1]])
    # Springs that slip one after the other make a curve of straight pieces. The share of a spring is its slip strain
    # times the change of slope there.
    curve = -np.expm1(-x / strain_scale)
    slope = np.diff(np.concatenate(([0.0], curve))) / np.diff(np.concatenate(([0.0], x)))
    share = x * (slope - np.append(slope[1:], 0.0))
    # The last one slips at x_n, where the formula ends below the whole size.
    return x, share / share.sum()


def preisach(
    size: float, strain_scale: float = STRAIN_SCALE, center: float = 0.11, **common: float
) -> Parameters:
    """Return a Preisach mechanism whose density is smooth and not separable (Preisach, 1935; Everett, 1955).

        f = size g(p) (P + asymmetry P^2),   P = P(last reversal) +- E(last reversal, x),   x = (kappa - center)/range
        E(a, b) = 2/N sum_j c_j (1 - exp(-|G_j(b) - G_j(a)|)),   G_j(x) = g_j x (1 + e_j x^2/3)

    The range is 12.8 strain scales to both sides of ``center``, 0.16 by default: more than a muscle can move. Beyond it
    the force stays as it is. Loops of one width differ from place to place, which no Prandtl-Ishlinskii model can do.

    Parameters
    ----------
    size
        Force at saturation, at the reference pressure. [N]
    strain_scale
        Strain of the virgin curve in the middle of the range, as of :func:`maxwell_slip`.
    center
        Contraction in the middle of the range.
    **common
        As of :func:`shared`.

    Returns
    -------
    dict
        As of :func:`maxwell_slip`.

    Raises
    ------
    ParameterError
        If a number lies outside its range.

    Examples
    --------
    >>> round(preisach(80.0)["strain"][0], 4)
    0.16
    """
    _positive(strain_scale=strain_scale)
    # One number describes the range: the density itself is in the C code.
    half = np.array([_RANGE_IN_SCALES * strain_scale])
    return _mechanism(PREISACH, size, half, np.ones(1), common, center)


def dahl(
    size: float,
    elements: int = 3,
    strain_scale: float = STRAIN_SCALE,
    spread: float = 2.5,
    **common: float,
) -> Parameters:
    """Return Dahl elements in parallel (Dahl, 1968), whose only memory is their forces.

        df_i/dkappa = k_i (1 -+ f_i/W_i),   k_i = size share_i/strain_i,   W_i = share_i size g(p) (1 +- asymmetry)

    Parameters
    ----------
    size
        Force when all elements slip, at the reference pressure. [N]
    elements
        Number of elements, at most 64; shares are binomial, (1/4, 1/2, 1/4) for three.
    strain_scale
        Strain of the middle element.
    spread
        Ratio of the strains of neighbours.
    **common
        As of :func:`shared`.

    Returns
    -------
    dict
        As of :func:`maxwell_slip`.

    Raises
    ------
    ParameterError
        If a number lies outside its range.

    Examples
    --------
    >>> [round(strain, 5) for strain in dahl(80.0)["strain"]]
    [0.005, 0.0125, 0.03125]
    """
    _positive(strain_scale=strain_scale)
    if not 1 <= elements <= PLANT_ELEMENTS or (elements > 1 and not spread > 1):
        raise ParameterError(
            f"elements = {elements}, spread = {spread}: 1 to {PLANT_ELEMENTS} elements and a spread above 1 are needed",
            elements=elements,
            spread=spread,
        )
    steps = np.arange(elements, dtype=np.float64) - (elements - 1) / 2
    x = strain_scale * np.power(spread, steps)
    # The middle elements carry most of the force, as in the smooth virgin curve.
    binomial = np.array([math.comb(elements - 1, i) for i in range(elements)])
    share = binomial / 2.0 ** (elements - 1)
    return _mechanism(DAHL, size, x, share, common)


def braid(size: float, center: float = 0.11, **common: float) -> Parameters:
    """Return springs that slip at a force which follows the contact of the braid's strands (Davis and Caldwell, 2006).

        f_i <- clip(f_i + k_i dkappa, -w W_i, w W_i),   w = sin(2 theta(center))/sin(2 theta(kappa))
        cos(theta) = (1 - kappa) cos(24 deg)

    Strands of one width that cross at 2 theta touch on an area in proportion to 1/sin(2 theta), so loops are wide where
    the muscle is long. The k_i and W_i are those of :func:`maxwell_slip`.

    Parameters
    ----------
    size
        Force when everything slips, at ``center`` and at the reference pressure. [N]
    center
        Contraction at which w is 1.
    **common
        As of :func:`shared`.

    Returns
    -------
    dict
        As of :func:`maxwell_slip`.

    Raises
    ------
    ParameterError
        If a number lies outside its range.

    Examples
    --------
    >>> braid(80.0)["center"]
    0.11
    """
    springs = _springs(SPRINGS, SPRING_STRAINS, STRAIN_SCALE)
    return _mechanism(BRAID, size, *springs, common, center)


def lugre(size: float, strain_scale: float = STRAIN_SCALE, **common: float) -> Parameters:
    """Return a bristle whose sliding force falls with speed (LuGre: Canudas de Wit and others, 1995).

        df/dkappa = k (1 -+ f/g(v)),   g(v) = W (1 + 0.3 exp(-(v/v_s)^2)),   v_s = 0.02 1/s,   k = size/strain_scale

    The micro damping of the paper is left out: without it the bristle takes energy at every speed.

    Parameters
    ----------
    size
        Sliding force at high speed, at the reference pressure. [N]
    strain_scale
        Strain of the virgin curve at high speed.
    **common
        As of :func:`shared`.

    Returns
    -------
    dict
        As of :func:`maxwell_slip`.

    Raises
    ------
    ParameterError
        If a number lies outside its range.

    Examples
    --------
    >>> lugre(80.0)["strain"]
    [0.0125]
    """
    return _bristle(LUGRE, size, strain_scale, common)


def pinched(size: float, strain_scale: float = STRAIN_SCALE, **common: float) -> Parameters:
    """Return a Bouc-Wen spring that is soft where it takes up slack (Baber and Noori, 1986; Foliente, 1995).

        df/dkappa = k h(u) (1 - max(u, 0)),   h(u) = 1 - 0.8 exp(-((u - 0.1)/0.3)^2),   k = size/strain_scale
        u = f/W in the direction of motion

    Parameters
    ----------
    size
        Force when it slips, at the reference pressure. [N]
    strain_scale
        Strain of the virgin curve without slack.
    **common
        As of :func:`shared`.

    Returns
    -------
    dict
        As of :func:`maxwell_slip`.

    Raises
    ------
    ParameterError
        If a number lies outside its range.

    Examples
    --------
    >>> pinched(80.0)["share"]
    [1.0]
    """
    return _bristle(PINCHED, size, strain_scale, common)


def ageing(size: float, **common: float) -> Parameters:
    """Return springs that slip at a force which grows while they rest (Dieterich, 1979; Ruina, 1983).

        f_i <- clip(f_i + k_i dkappa, -a W_i, a W_i),   a = 1 + 0.05 ln(1 + theta/0.1 s)
        d theta/dt = 1 - theta |dkappa/dt|/0.02

    The k_i and W_i are those of :func:`maxwell_slip`.

    Parameters
    ----------
    size
        Force when everything slips that never rests, at the reference pressure. [N]
    **common
        As of :func:`shared`.

    Returns
    -------
    dict
        As of :func:`maxwell_slip`.

    Raises
    ------
    ParameterError
        If a number lies outside its range.

    Examples
    --------
    >>> ageing(80.0)["n"]
    40
    """
    return _mechanism(AGEING, size, *_springs(SPRINGS, SPRING_STRAINS, STRAIN_SCALE), common)


def _bristle(kind: int, size: float, strain_scale: float, common: dict[str, float]) -> Parameters:
    _positive(strain_scale=strain_scale)
    return _mechanism(kind, size, np.array([strain_scale]), np.ones(1), common)


def none() -> Parameters:
    """Return no hysteresis at all: the control.

    Examples
    --------
    >>> none()["kind"]
    0
    """
    return {"kind": NONE}


def foreign() -> Parameters:
    """Return the placeholder for a :class:`Mechanism` that is attached to the joint afterwards.

    Examples
    --------
    >>> foreign()["kind"]
    8
    """
    return {"kind": FOREIGN}


def shared(
    pressure_share: float = 0.7,
    constant_share: float | None = None,
    reference_pressure: float = 3e5,
    asymmetry: float = 0.0,
) -> Parameters:
    """Return what all mechanisms share: dependence on pressure, and asymmetry.

    Friction grows with pressure, less than proportionally: g(p) = constant_share + pressure_share p/reference_pressure.

    Parameters
    ----------
    pressure_share, constant_share
        Together 1 unless both are given.
    reference_pressure
        Gauge pressure at which the force has its size. [Pa]
    asymmetry
        Contraction is held back by (1 + asymmetry), elongation by (1 - asymmetry); -0.5 .. 0.5.

    Raises
    ------
    ParameterError
        If a number lies outside its range.

    Examples
    --------
    >>> shared(asymmetry=0.1)["constant_share"]
    0.30000000000000004
    """
    constant = constant_share
    if constant is None:
        constant = 1.0 - pressure_share
    _positive(reference_pressure=reference_pressure)
    if not (pressure_share >= 0 and constant >= 0):
        raise ParameterError(
            f"constant_share = {constant}, pressure_share = {pressure_share}: a negative share would give energy "
            "in every loop; use 0 to 1",
            constant_share=constant,
            pressure_share=pressure_share,
        )
    if not abs(asymmetry) <= 0.5:
        raise ParameterError(
            f"asymmetry = {asymmetry} lies outside -0.5 .. 0.5; muscles are reported with 0 to 0.2",
            asymmetry=asymmetry,
        )
    return {
        "constant_share": constant,
        "pressure_share": pressure_share,
        "reference_pressure": reference_pressure,
        "asymmetry": asymmetry,
    }


def _mechanism(
    kind: int,
    size: float,
    strain: npt.NDArray[np.float64],
    share: npt.NDArray[np.float64],
    common: dict[str, float],
    center: float = 0.0,
) -> Parameters:
    if not (size >= 0 and math.isfinite(size)):
        raise ParameterError(
            f"size = {size}: the slipping force in newton is 0 or more, 80 for a DMSP-40", size=size
        )
    return {
        "kind": kind,
        "n": int(strain.size),
        "size": float(size),
        **shared(**common),
        "center": float(center),
        "strain": strain.tolist(),
        "share": share.tolist(),
    }


def _positive(**numbers: float) -> None:
    for name, value in numbers.items():
        if not (value > 0 and math.isfinite(value)):
            raise ParameterError(f"{name} = {value} must be a positive number", **{name: value})


BUILDERS: dict[str, Callable[..., Parameters]] = {
    "maxwell-slip": maxwell_slip,
    "preisach": preisach,
    "dahl": dahl,
    "braid": braid,
    "lugre": lugre,
    "pinched": pinched,
    "ageing": ageing,
}
PLANTS = (*BUILDERS, "none")
