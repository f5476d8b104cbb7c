"""Muscles of parallel elements: spring and damper (Reynolds), Maxwell slip (Vo-Minh)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.errors import ParameterError
from dehyst.models import kit as models_kit
from dehyst_robot.muscles._base import Arithmetic, MuscleModel, polynomial


@dataclass(frozen=True)
class Reynolds(MuscleModel):
    r"""Three elements in parallel: contractile force, spring and damper (Reynolds and others 2003).

    .. math:: F = F_{ce}(p) - K(p)\, x - B(p)\, v, \qquad x = l_0 \kappa, \quad v = \dot x

    All three are piecewise linear in the pressure, given by their values at knots and going on along the first and last
    piece; B depends on the direction, contracting or relaxing, and is never negative.

    Sources: Reynolds, Repperger, Phillips, Bandry, Annals of Biomedical Engineering 31, 2003 (own knowledge, high); the
    re-identification of Serres, Reynolds, Phillips, Gerschutz, Repperger 2008/2009 (found: three-element simulators).

    Raises
    ------
    ParameterError
        If there is not one value a knot, or fewer than two knots.

    Cannot show
    -----------
    Hysteresis: without motion the force is a function of contraction and pressure, and the direction-dependent damper
    opens loops that vanish with the speed. That makes it a baseline: what it cannot fit at low speed is hysteresis.

    Examples
    --------
    >>> original = Reynolds.published("original")
    >>> [round(float(original.static_force(0.0, p))) for p in (207e3, 621e3)]
    [467, 1042]
    """

    name = "reynolds"
    affine_in_pressure = False
    length: float
    pressures: tuple[float, ...]
    force: tuple[float, ...]
    stiffness: tuple[float, ...]
    contracting: tuple[float, ...]
    relaxing: tuple[float, ...]

    def __post_init__(self) -> None:
        super().__post_init__()
        models_kit.strictly_increasing(
            models_kit.parameter_array(self.pressures, "pressures"), "pressures"
        )
        n = len(self.pressures)
        for key in ("force", "stiffness", "contracting", "relaxing"):
            if len(getattr(self, key)) != n or n < 2:
                raise ParameterError(
                    f"{key} has {len(getattr(self, key))} values for {n} pressures; pass one a pressure, two at least."
                )

    def _static(self, kappa: Any, pressure: Any, m: Arithmetic) -> Any:
        pull = _piecewise(self.pressures, self.force, pressure, m)
        return pull - _piecewise(self.pressures, self.stiffness, pressure, m) * self.length * kappa

    def _resistance(self, kappa: Any, pressure: Any, speed: Any, slip: Any, m: Arithmetic) -> Any:
        contracting = _piecewise(self.pressures, self.contracting, pressure, m)
        relaxing = _piecewise(self.pressures, self.relaxing, pressure, m)
        # Lines that go on may fall below zero, where a damper would drive the motion.
        return m.maximum(m.where(speed > 0.0, contracting, relaxing), 0.0) * speed


def _piecewise(knots: tuple[float, ...], values: tuple[float, ...], p: Any, m: Arithmetic) -> Any:
    """Return the value at a pressure; the first and the last piece go on beyond their knots."""
    # One line, and a bend at each inner knot: a formula that arrays and floats share.
    slope = (values[1] - values[0]) / (knots[1] - knots[0])
    value = values[0] + slope * (p - knots[0])
    for i in range(1, len(knots) - 1):
        after = (values[i + 1] - values[i]) / (knots[i + 1] - knots[i])
        value = value + (after - slope) * m.maximum(p - knots[i], 0.0)
        slope = after
    return value


def slips(
    strains: npt.ArrayLike, forces: npt.ArrayLike
) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return slip strains and slip forces (n,) of the elements whose first curve from rest is a given one.

    Raises
    ------
    ParameterError
        If strains do not increase, or the curve bends upwards.

    Examples
    --------
    >>> strains, forces = slips([0.01, 0.02], [10.0, 15.0])
    >>> [round(w, 12) for w in forces]
    [5.0, 10.0]
    """
    x = models_kit.parameter_array(strains, "strains")
    f = models_kit.parameter_array(forces, "forces")
    if x.size != f.size or not x[0] > 0:
        raise ParameterError(
            f"{x.size} strains, first {x[0]:g}, and {f.size} forces: pass pairs beyond the rest at 0."
        )
    models_kit.strictly_increasing(x, "strains")
    slope = np.diff(f, prepend=0.0) / np.diff(x, prepend=0.0)
    # Where an element slips, the curve loses its stiffness.
    drop = slope - np.append(slope[1:], 0.0)
    if np.min(drop) < -1e-9 * np.max(np.abs(slope)):
        i = int(np.argmin(drop))
        raise ParameterError(
            f"the first curve bends upwards at strain {x[i]:g}: an element of negative stiffness would give energy. "
            "Take fewer points, or smooth the curve.",
            index=i,
        )
    return tuple(x.tolist()), tuple((np.maximum(drop, 0.0) * x).tolist())


@dataclass(frozen=True)
class VoMinh(MuscleModel):
    r"""Isometric polynomial and Maxwell slip (Vo-Minh, Tjahjowidodo, Ramon, Van Brussel 2009 to 2011).

    .. math::

        F = \sum_{j=0}^{3} (a_j p - b_j) \kappa^j - g(p) \sum_i W_i\, e_i/d_i, \qquad
        g = 1 - \sigma + \sigma\, p/p_r

    where e_i is a stop operator of the contraction: it follows kappa, and slips where |e_i| reaches d_i, with the force
    W_i. Loops have nonlocal memory, and their branches are the first curve from rest twice as large (Masing's rule).
    The slopes k_i = W_i/d_i are how much the first curve bends at the slip strains: `slips` reads them from it.

    sigma = 0 is a friction that does not depend on pressure, as reported for the MAS-20 in the force/length plane over
    most of the range; sigma = 1 one in proportion to it (Tondu, Lopez). Both are options because reports disagree.

    Source: Vo-Minh and others, IEEE/ASME AIM 2009 and 2010, Mechatronics 21, 2011: structure, own knowledge, high.
    Their numbers were not accessible: the polynomial was fitted to the map that Martens and Boblan measured on a
    DMSP-20 (5.7 N rms), first curve and size of the friction are assumptions.

    Cannot show
    -----------
    Dependence on speed (they found none between 1 and 16 mm/s) and creep; loops whose shape depends on where they lie.

    Examples
    --------
    A stroke from rest and back: friction opposes both, 20 N when everything slips.

    >>> muscle = VoMinh.published("DMSP-20")
    >>> path = np.concatenate((np.linspace(0.05, 0.15, 50), np.linspace(0.15, 0.05, 50)))
    >>> friction = muscle.static_force(path, 3e5) - muscle.simulate(path, 3e5)
    >>> [round(float(friction[i]), 6) for i in (0, 49, 99)]
    [0.0, 20.0, -20.0]
    """

    name = "vo-minh"
    length: float
    a: tuple[float, ...]
    b: tuple[float, ...]
    slip_strains: tuple[float, ...]
    slip_forces: tuple[float, ...]
    pressure_share: float
    reference_pressure: float

    def __post_init__(self) -> None:
        super().__post_init__()
        # The base class has checked single numbers; here they are checked against each other.
        strains = models_kit.parameter_array(self.slip_strains, "slip_strains")
        models_kit.strictly_increasing(strains, "slip_strains")
        if len(self.slip_forces) != strains.size or self.pressure_share > 1:
            raise ParameterError(
                f"{strains.size} slip strains from {strains[0]:g}, {len(self.slip_forces)} slip forces, pressure_share "
                f"= {self.pressure_share:g}: pass a force for each positive strain, and a share of 0 to 1."
            )

    @property
    def limits(self) -> tuple[float, float]:
        """Fitted on 0.013 to 0.21."""
        return -0.05, 0.35

    @property
    def size(self) -> float:
        """Force when everything slips, at the reference pressure. [N]"""
        return float(sum(self.slip_forces))

    def virgin(self, strain: npt.ArrayLike) -> Array:
        """Return the first curve from rest at the reference pressure: friction after a strain of one direction. [N]"""
        x = np.asarray(strain, float)[..., None]
        return np.asarray(
            np.clip(x / np.array(self.slip_strains), -1.0, 1.0) @ np.array(self.slip_forces)
        )

    def _static(self, kappa: Any, pressure: Any, m: Arithmetic) -> Any:
        return pressure * polynomial(self.a, kappa) - polynomial(self.b, kappa)

    def _resistance(self, kappa: Any, pressure: Any, speed: Any, slip: Any, m: Arithmetic) -> Any:
        # A vacuum does not press the strands together.
        share = self.pressure_share * m.maximum(pressure, 0.0) / self.reference_pressure
        return self.size * (1.0 - self.pressure_share + share) * slip

    def _contacts(self) -> tuple[Array, Array]:
        # Shares of a muscle without friction do not matter, but must be finite.
        forces = np.array(self.slip_forces)
        return np.array(self.slip_strains), forces / max(self.size, 1e-300)
