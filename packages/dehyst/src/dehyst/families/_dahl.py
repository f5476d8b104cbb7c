"""Dahl friction: after every reversal the force approaches Coulomb friction exponentially.

Bristles of a rubbing surface bend before they slip. The force of one kind of bristles depends on the path x alone::

    dz/dx = 1 - sgn(dx) z / L            so that |z| < L after any history from rest
    z = L (1 - exp(-x / L))              from rest (the virgin curve)
    y = c(x) + sum over k of w_k z_k

The friction force of element k is F = w_k z_k, its stiffness sigma = w_k and its dry friction F_c = |w_k| L_k. This is
Dahl's law with the exponent i = 1, the usual one. A positive weight makes the output lead the input (clockwise loops, a
force over a displacement), a negative one makes it lag (an actuator's position over its drive). Input and output are
scaled to the range of the log.

==============  =======================================================  ============  =====================
parameter       meaning                                                  unit          source
==============  =======================================================  ============  =====================
``curve``       coefficients of c, lowest first; straight beyond +-1     scaled        identified
``lengths``     L_k, on which an element forgets a turn                  half ranges   grid, 0.01 to 2
``weights``     w_k, stiffness of an element                             scaled        identified, convex
==============  =======================================================  ============  =====================

Source: P. R. Dahl, A solid friction model, The Aerospace Corporation, TOR-0158(3107-18)-1, 1968. Structure: high
confidence. The bank of several lengths and its convex fit are this project's.

The fit: for given lengths, curve and weights are the solution of one convex program (least squares with weights that
are not negative over columns that rise in every state), so there is no seed. The inverse exists when the least slope of
the curve exceeds twice the sum of the lagging weights; a fitted model always has one.

Cannot show
-----------
Break-away: the force never exceeds its steady value, so there is no stick-slip. Speed: a loop is the same however fast
it is run (see lugre). Closed minor loops: a small cycle between two inputs drifts along exponentials and closes only
after several turns. Loops that are wider on one side than on the other (see duhem, generalised-bouc-wen).
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from dehyst.arrays import Array
from dehyst.errors import ParameterError
from dehyst.families._base import STARTS, UNSCALED, Scaling
from dehyst.families._friction import FrictionLoop, Mixer, best_start, positive
from dehyst.families._registry import Family
from dehyst.families._training import Training
from dehyst.models import ModelCard
from dehyst.models import kit as models_kit

LENGTHS = np.geomspace(0.01, 2.0, 12)


@dataclass(frozen=True, repr=False, eq=False)
class Dahl(FrictionLoop):
    """A curve c(x) plus a sum of elements of Dahl's friction.

    Attributes
    ----------
    curve
        (n,) coefficients of c(x), lowest first.
    lengths, weights
        (m,) length L_k > 0 and weight w_k of each element.

    Examples
    --------
    From rest the force follows 1 - exp(-x) towards 1:

    >>> import numpy as np
    >>> model = Dahl(curve=[0.0], lengths=[1.0], weights=[1.0])
    >>> bool(np.allclose(model.simulate([0.0, 0.5, 3.0]), 1 - np.exp([0.0, -0.5, -3.0])))
    True
    """

    curve: Array = field(default_factory=lambda: np.array([0.0, 1.5]))
    lengths: Array = field(default_factory=lambda: np.array([0.1, 0.4]))
    weights: Array = field(default_factory=lambda: np.array([-0.4, -0.3]))
    scaling: Scaling = UNSCALED
    start: str = "rest"
    card: ModelCard = models_kit.NO_CARD
    family = "dahl"

    def __post_init__(self) -> None:
        self.check()
        object.__setattr__(self, "lengths", models_kit.parameter_array(self.lengths, "lengths"))
        if self.lengths.size != self.weights.size:
            raise ParameterError(
                f"{self.lengths.size} lengths for {self.weights.size} weights; give one of each an element."
            )
        positive(self.lengths, "lengths")

    def table(self) -> Array:
        """Elements as the engine takes them: psi = sgn(dx) sgn(z) / L."""
        # The signs of dx and z in each of the eight phases of the engine.
        along, side, _ = np.unravel_index(np.arange(8), (2, 2, 2))
        psi = np.where(along == side, 1.0, -1.0) / self.lengths[:, None]
        ones = np.ones((self.lengths.size, 1))
        return np.hstack([ones, ones, psi])

    def slope_ranges(self) -> tuple[Array, Array]:
        """dz/dx lies between 0, slipping, and 2, turned after slipping."""
        return np.zeros(self.lengths.size), np.full(self.lengths.size, 2.0)

    @property
    def parameters_of_element(self) -> int:
        """The length."""
        return 1


def fit_dahl(training: Training) -> Dahl:
    """Return the bank of a grid of lengths that fits best, from the start state that fits best."""
    grid = Dahl(np.zeros(1), LENGTHS, np.zeros(LENGTHS.size), training.scaling, "zero")
    thin = Mixer(training.thinned())
    errors = {start: thin.error(grid.with_start(start)) for start in STARTS}
    bank = Mixer(training.spread())(grid.with_start(best_start(errors)))
    used = np.flatnonzero(bank.weights != 0.0)
    if not used.size:
        # A model needs one element, even of weight 0.
        used = np.array([0])
    return Dahl(bank.curve, LENGTHS[used], bank.weights[used], training.scaling, bank.start)


FAMILY = Family(
    name="dahl",
    title="Dahl",
    model=Dahl,
    fit=fit_dahl,
    convex=True,
    source="P. R. Dahl, A solid friction model, The Aerospace Corporation, TOR-0158(3107-18)-1, 1968",
)
