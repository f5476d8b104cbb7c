r"""Polynomials in the contraction, affine in the pressure (Aschemann, Schindele 2008; Hildebrandt and others 2005).

.. math:: F = p \sum_{m=0}^{3} a_m \kappa^m - \sum_{n=0}^{4} b_n \kappa^n - b_r\, \mathrm{sgn}(\kappa) |\kappa|^{2/3}

b_r = 0 is the form of Aschemann and Schindele; three coefficients a, four b and the root are that of Hildebrandt,
Sawodny, Neumann and Hartmann (ACC 2005).

Structure: own knowledge, high confidence; the power 2/3 of the variant low. The coefficients here were fitted to the
maps of `dehyst.robot.muscles.maker` and `dehyst.robot.muscles.sarosi` from 0.5 to 6 bar and 0 to 0.25.

Cannot show
-----------
Hysteresis, speed, creep: it is a static map. Polynomials leave the data quickly outside the range of the fit.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from dehyst.robot.muscles.base import Arithmetic, MuscleModel, polynomial
from dehyst.robot.muscles.parameters import length_row, parameter, parameter_set

_FIT = "fitted, see SETS"
_A = (1036.8e-5, -237.8e-5, -35150e-5, 86649e-5)
_B = (67.1, 20759.0, -214268.0, 939766.0, -1494522.0)


@dataclass(frozen=True)
class AschemannSchindele(MuscleModel):
    """Polynomial map.

    Examples
    --------
    >>> AschemannSchindele.published("DMSP-40-maker").static_force([0.0, 0.1, 0.2], 3e5).round().tolist()
    [3043.0, 1454.0, 54.0]
    """

    name = "aschemann-schindele"
    length: float = length_row(0.4)
    a: tuple[float, ...] = parameter(_A, "N/Pa", -10.0, 10.0, _FIT, "a_m, pull of pressure")
    b: tuple[float, ...] = parameter(_B, "N", -1e8, 1e8, _FIT, "b_n, rubber")
    root: float = parameter(0.0, "N", -1e6, 1e6, _FIT, "b_r, of the two-thirds power", False)

    PUBLISHED = (
        parameter_set("DMSP-40-maker", "fitted to the maker's map of a DMSP-40, 25 N rms"),
        parameter_set(
            "DMSP-40-bench", "fitted to Sarosi's map of a DMSP-40 on a bench, 8.5 N rms", length=1.0,
            a=(947.9e-5, -3460.1e-5, 3033.5e-5, -6777.6e-5), b=(189.6, 10683.9, -117893.0, 552851.0, -924496.0),
        ),
        parameter_set(
            "DMSP-40-hildebrandt", "variant with the power 2/3, fitted to the maker's map of a DMSP-40, 49 N rms",
            a=(1.10283e-2, -3.53599e-2, -2.22996e-2), b=(202.298, -21098.34, 90378.51, -229170.2), root=9054.04,
        ),
    )  # fmt: skip

    @property
    def limits(self) -> tuple[float, float]:
        """Fitted on 0 to 0.25."""
        return -0.05, 0.35

    def _static(self, kappa: Any, pressure: Any, m: Arithmetic) -> Any:
        rubber = polynomial(self.b, kappa)
        if self.root:
            size = abs(kappa) ** (2.0 / 3.0)
            rubber = rubber + self.root * m.where(kappa < 0.0, -size, size)
        return pressure * polynomial(self.a, kappa) - rubber


MUSCLE = AschemannSchindele
