r"""Three elements in parallel: contractile force, spring and damper (Reynolds and others 2003).

.. math:: F = F_{ce}(p) - K(p)\, x - B(p)\, v, \qquad x = l_0 \kappa, \quad v = \dot x

All three are piecewise linear in the pressure, given by their values at knots and going on along the first and last
piece; B depends on the direction, contracting or relaxing, and is never negative.

Sources: Reynolds, Repperger, Phillips, Bandry, Annals of Biomedical Engineering 31, 2003 (own knowledge, high); the
re-identification of Serres, Reynolds, Phillips, Gerschutz, Repperger 2008/2009 (found: three-element simulators).

Cannot show
-----------
Hysteresis: without motion the force is a function of contraction and pressure, and the direction-dependent damper
opens loops that vanish with the speed. That makes it a baseline: what it cannot fit at low speed is hysteresis.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from dehyst.errors import ParameterError
from dehyst.models.arrays import parameter_array, strictly_increasing
from dehyst.robot.muscles.base import Arithmetic, MuscleModel
from dehyst.robot.muscles.parameters import length_row, parameter, parameter_set

_FIRST = "Reynolds and others 2003, 207 to 621 kPa; own knowledge, high"
_SECOND = "Serres and others 2009, 150 to 550 kPa; found"
_BOTH = f"{_FIRST}; {_SECOND}"


def _line(constant: float, slope: float) -> tuple[float, float]:
    """Values at 207 and 621 kPa of a line over the pressure in kPa."""
    return constant + slope * 207, constant + slope * 621


@dataclass(frozen=True)
class Reynolds(MuscleModel):
    """Reynolds: force, spring and damper that depend on the pressure.

    Raises
    ------
    ParameterError
        If there is not one value a knot, or fewer than two knots.

    Examples
    --------
    >>> original = Reynolds.published("original")
    >>> [round(float(original.static_force(0.0, p))) for p in (207e3, 621e3)]
    [467, 1042]
    """

    name = "reynolds"
    affine_in_pressure = False
    length: float = length_row(0.3, "assumption: not published")
    pressures: tuple[float, ...] = parameter((207e3, 621e3), "Pa", 0.0, 1e6, _BOTH, "knots", False, least=-math.inf)
    force: tuple[float, ...] = parameter(_line(179.2, 1.39), "N", -1e4, 1e5, _BOTH, "F_ce at the knots")
    stiffness: tuple[float, ...] = parameter(_line(5710, 30.7), "N/m", 0.0, 1e7, _BOTH, "K at the knots")
    contracting: tuple[float, ...] = parameter(
        _line(1010, 6.91), "N s/m", 0.0, 1e6, _BOTH, "B at the knots, contraction"
    )
    relaxing: tuple[float, ...] = parameter(_line(600, -0.803), "N s/m", 0.0, 1e6, _BOTH, "B at the knots, relaxation")

    PUBLISHED = (
        parameter_set("original", _FIRST),
        parameter_set(
            "serres", _SECOND, pressures=(150e3, 314e3, 372e3, 550e3),
            force=tuple(44.6 + 2.91 * p for p in (150, 314, 372, 550)),
            stiffness=(32700 - 32.1 * 150, 32700 - 32.1 * 314, 17000 + 17.9 * 372, 17000 + 17.9 * 550),
            contracting=(2900.0, 2900.0, 2900.0, 2900.0),
            relaxing=(1570.0, 1570.0, 311 + 3.38 * 372, 311 + 3.38 * 550),
        ),
    )  # fmt: skip

    def __post_init__(self) -> None:
        super().__post_init__()
        strictly_increasing(parameter_array(self.pressures, "pressures"), "pressures")
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
        return m.maximum(m.where(speed > 0.0, contracting, relaxing), 0.0) * speed


def _piecewise(knots: tuple[float, ...], values: tuple[float, ...], p: Any, m: Arithmetic) -> Any:
    """Value at a pressure, the first and last piece going on."""
    slope = (values[1] - values[0]) / (knots[1] - knots[0])
    value = values[0] + slope * (p - knots[0])
    for i in range(1, len(knots) - 1):
        after = (values[i + 1] - values[i]) / (knots[i + 1] - knots[i])
        value = value + (after - slope) * m.maximum(p - knots[i], 0.0)
        slope = after
    return value


MUSCLE = Reynolds
