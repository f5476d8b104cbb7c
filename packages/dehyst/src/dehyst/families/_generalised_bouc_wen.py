"""Generalised Bouc-Wen model: asymmetric, with different sharpness and unloading for each sign of input and force.

The state of the element depends on the path x alone; x' is its direction::

    z' = x' (1 - |z|^n psi)
    psi = b1 sgn(x' z) + b2 sgn(x x') + b3 sgn(x z) + b4 sgn(x') + b5 sgn(z) + b6 sgn(x)
    y = c(x) + w z

Six signs give the six phases of a steady loop (loading on either side of x = 0, unloading, for z of either sign) each
its own psi. While loading z goes to psi^(-1/n). b1 = beta alone is Bouc-Wen's element with gamma = 0; on the six phases
b1 = beta + gamma, b2 = -gamma, b3 = gamma is Bouc-Wen's. x = 0 is the middle of the range of the log. The usual factor
A of x' is 1. A positive w makes the output lead (clockwise loops), a negative one makes it lag.

==============  =======================================================  ================  ===================
parameter       meaning                                                  unit              source
==============  =======================================================  ================  ===================
``curve``       coefficients of c, lowest first; straight beyond +-1     scaled            identified
``beta``        b1 ... b6                                                half ranges^-n    identified
``power``       n >= 1: how sharp the knee before slipping is            1                 identified
``weights``     w, stiffness of the element at z = 0                     scaled            identified, convex
==============  =======================================================  ================  ===================

Source: J. Song and A. Der Kiureghian, Generalized Bouc-Wen model for highly asymmetric hysteresis, J. Eng. Mech. ASCE
132 (2006) 610-618; for a pneumatic muscle D. Schindele and H. Aschemann, AMC 2012. Structure: high confidence.

The fit: Bouc-Wen's element is searched first; from there the four loading limits, the two unloading slopes and n are
searched by the simplex method of Nelder and Mead, curve and w being the solution of a convex program each time. Only
elements are taken whose state stays bounded, for unloading never turns into growth, and moves at most 32 times as far
as x. The output rises in the six phases of
a steady loop; two more, loading on the far side of x = 0 with z still of the other sign, come up in small cycles beside
x = 0, and their psi follows from the six. There the model may have to say that it has no inverse. n = 1 is solved
exactly, other powers by Runge-Kutta steps in x to about 1e-7.

Cannot show
-----------
Closed minor loops: small cycles drift, and those away from x = 0 see the phases of one side only. Speed. Asymmetry
about another place than the middle of the range, but for what the curve shows. More than one length (see bouc-wen).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.errors import ParameterError
from dehyst.families._base import UNSCALED, Scaling
from dehyst.families._bouc_wen import GRID, LIMITS
from dehyst.families._friction import FrictionLoop, Mixer, sharpness
from dehyst.families._registry import Family
from dehyst.families._shapes import COARSE, FINE, first_element, simplex
from dehyst.families._training import Training
from dehyst.models import ModelCard
from dehyst.models import kit as models_kit

PHASES = (
    np.array(np.unravel_index(np.arange(8), (2, 2, 2))).T * 2.0 - 1.0
)  # signs of x', z, x in the engine's order
ALONG, SIDE, PLACE = PHASES.T
SIGNS = np.column_stack([ALONG * SIDE, PLACE * ALONG, PLACE * SIDE, ALONG, SIDE, PLACE])
LOADING = ALONG == SIDE
MARGIN = 0.999  # of a loading limit's psi, below which that of unloading stays
STEEPEST = 32.0  # dz/dx in any phase of a fitted element, whether the log shows the phase or not
# Phases of a steady loop: loading up at x > 0, x < 0; loading down at x < 0, x > 0; unloading from either.
STEADY = [7, 6, 0, 1, 3, 4]


@dataclass(frozen=True, repr=False, eq=False)
class GeneralisedBoucWen(FrictionLoop):
    """A curve and one generalised Bouc-Wen element.

    Attributes
    ----------
    curve
        Coefficients of c(x), (n,), lowest first.
    beta
        b1 ... b6, (6,).
    power
        n >= 1.
    weights
        w, (1,).

    Examples
    --------
    Loading goes to psi^(-1/n), another limit in each direction:

    >>> model = GeneralisedBoucWen(curve=[0.0], beta=[3.0, 0.0, 0.0, 1.0, 0.0, 0.0], power=1.0, weights=[1.0])
    >>> [round(float(y), 6) for y in model.simulate([0.0, 30.0, -30.0])]
    [0.0, 0.25, -0.5]
    """

    curve: Array = field(default_factory=lambda: np.array([0.0, 2.0]))
    beta: Array = field(default_factory=lambda: np.array([6.0, -1.0, 1.0, 1.0, 0.5, 0.5]))
    power: float = 2.0
    weights: Array = field(default_factory=lambda: np.array([-0.6]))
    scaling: Scaling = UNSCALED
    start: str = "rest"
    card: ModelCard = models_kit.NO_CARD
    family = "generalised-bouc-wen"

    def __post_init__(self) -> None:
        self.check()
        object.__setattr__(self, "beta", models_kit.parameter_array(self.beta, "beta"))
        object.__setattr__(self, "power", models_kit.parameter_number(self.power, "power"))
        if self.beta.size != 6 or self.weights.size != 1:
            raise ParameterError(
                f"{self.beta.size} beta and {self.weights.size} weights; give six and one."
            )
        sharpness(np.array([self.power]))

    def table(self) -> Array:
        """The element as the engine takes it."""
        return np.array([[1.0, self.power, *(SIGNS @ self.beta)]])

    @property
    def limits(self) -> Array:
        """Largest z downwards and upwards, (2,), -+infinity where nothing bounds it. [half ranges]"""
        psi = SIGNS @ self.beta
        limits = []
        for side in (-1.0, 1.0):
            loading, unloading = psi[LOADING & (side == SIDE)], psi[~LOADING & (side == SIDE)]
            least = float(np.min(loading))
            limit = np.inf
            # Otherwise unloading would turn into growth, beyond the limit and, by rounding, right at it.
            if least > 0.0 and float(np.max(unloading)) <= MARGIN * least:
                limit = least ** (-1.0 / self.power)
            limits.append(side * limit)
        return np.array(limits)

    def slope_ranges(self) -> tuple[Array, Array]:
        """dz/dx over all phases, from z = 0 to the limits: 1 - |z|^n psi."""
        return self._ends(np.arange(8))

    def column_ranges(self) -> tuple[Array, Array]:
        """dz/dx over the six phases of a steady loop; infinite for elements that a fit must not take at all."""
        if np.abs(self.slope_ranges()).max() > STEEPEST:
            return self._ends(np.arange(0))
        return self._ends(np.array(STEADY))

    def _ends(self, phases: npt.NDArray[np.intp]) -> tuple[Array, Array]:
        limits = self.limits
        if not np.all(np.isfinite(limits)) or not phases.size:
            return np.array([-np.inf]), np.array([np.inf])
        z = np.abs(np.where(SIDE > 0.0, limits[1], limits[0]))
        slopes = (1.0 - (SIGNS @ self.beta) * z**self.power)[phases]
        # The slope changes between its values at z = 0, which is 1, and at the limit.
        return np.array([min(1.0, np.min(slopes))]), np.array([max(1.0, np.max(slopes))])

    @property
    def parameters_of_element(self) -> int:
        """Six of beta, and n."""
        return 7


def shaped(shapes: Sequence[Array], scaling: Scaling, start: str) -> GeneralisedBoucWen:
    """Element of shapes: log of four loading limits, of two sigma (unloading slope 2 sigma), and of n."""
    *lengths, first, second, power = np.exp(shapes[0])
    n = max(float(power), 1.0)
    loading = np.array(lengths) ** -n
    unloading = np.array([1.0 - 2.0 * first, 1.0 - 2.0 * second]) * loading[[0, 2]]
    beta = np.linalg.solve(SIGNS[STEADY], np.concatenate([loading, unloading]))
    return GeneralisedBoucWen(np.zeros(1), beta, n, np.zeros(1), scaling, start)


def tied(shapes: Sequence[Array], scaling: Scaling, start: str) -> GeneralisedBoucWen:
    """Bouc-Wen's element of a shape (log L, log sigma, log n)."""
    return shaped([spread_shape(shapes[0])], scaling, start)


def spread_shape(shape: Array) -> Array:
    """Shape of Bouc-Wen's element as that of a generalised one."""
    return np.asarray(shape[[0, 0, 0, 0, 1, 1, 2]])


def fit_generalised_bouc_wen(training: Training) -> GeneralisedBoucWen:
    """Return the element that fits best, from the start state that fits best."""
    # The element of Bouc and Wen that fits best is where the search of the six parameters begins.
    coarse, fine = Mixer(training.thinned(COARSE)), Mixer(training.thinned(FINE))
    start, shapes, _ = first_element(coarse, fine, tied, GRID, LIMITS)
    better, _ = simplex(
        fine, shaped, [spread_shape(shapes[0])], LIMITS[[0, 0, 0, 0, 1, 1, 2]], start
    )
    return Mixer(training.spread())(shaped(better, training.scaling, start))


FAMILY = Family(
    name="generalised-bouc-wen",
    title="Generalised Bouc-Wen",
    model=GeneralisedBoucWen,
    fit=fit_generalised_bouc_wen,
    convex=False,
    source="J. Song and A. Der Kiureghian, Generalized Bouc-Wen model for highly asymmetric hysteresis, J. Eng. Mech. "
    "ASCE 132 (2006) 610-618",
)
