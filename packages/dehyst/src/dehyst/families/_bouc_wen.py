"""Bouc-Wen model: hysteretic force with a sharpness exponent and different loading and unloading.

The state of an element depends on the path x alone::

    dz/dx = 1 - |z|^n (gamma + beta sgn(dx z))       i.e.  z' = x' - beta |x'| |z|^(n-1) z - gamma x' |z|^n
    |z| <= L = (beta + gamma)^(-1/n)                 after any history from rest, if beta + gamma > 0
    z = L (1 - exp(-x / L))                          from rest, n = 1
    y = c(x) + sum over k of w_k z_k

The usual factor A of x' is 1: only w A matters. n = 1 with gamma = 0 is Dahl's friction. A positive weight makes the
output lead (clockwise loops), a negative one makes it lag. Input and output are scaled to the range of the log.

==============  =======================================================  ================  ===================
parameter       meaning                                                  unit              source
==============  =======================================================  ================  ===================
``curve``       coefficients of c, lowest first; straight beyond +-1     scaled            identified
``beta``        beta_k >= 0: energy lost                                 half ranges^-n    identified
``gamma``       gamma_k: hardening where negative                        half ranges^-n    identified
``power``       n_k >= 1: how sharp the knee before slipping is          1                 identified
``weights``     w_k, stiffness of an element at z = 0                    scaled            identified, convex
==============  =======================================================  ================  ===================

Source: R. Bouc, Forced vibration of mechanical systems with hysteresis, 1967; Y.-K. Wen, Method for random vibration of
hysteretic systems, J. Eng. Mech. Div. ASCE 102 (1976) 249-263. Bounds: F. Ikhouane and J. Rodellar, Systems with
Hysteresis, Wiley 2007. Structure: high confidence.

The fit: curve and weights are the solution of a convex program for given shapes; the shapes (L, sigma = beta L^n, n)
of up to two elements are searched from a grid by the simplex method of Nelder and Mead, with sigma >= 1/2, so that
every cycle loses energy. The inverse exists when the least slope is positive: loading dz/dx goes from 1 down to 0,
unloading from 1 to 2 sigma; a fitted model always has one. n = 1 is solved exactly, other powers by Runge-Kutta steps
in x to about 1e-7 of L.

Cannot show
-----------
Closed minor loops: small cycles drift (the model does not obey Drucker's postulate). Speed: nothing depends on it (see
lugre). Loops that differ between the two sides (see generalised-bouc-wen). Degradation and pinching of the later
extensions.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from dehyst.arrays import Array
from dehyst.errors import ParameterError
from dehyst.families._base import UNSCALED, Scaling
from dehyst.families._friction import FrictionLoop, sharpness
from dehyst.families._registry import Family
from dehyst.families._shapes import search
from dehyst.families._training import Training
from dehyst.models import ModelCard
from dehyst.models import kit as models_kit

LENGTHS = (0.02, 0.05, 0.12, 0.25, 0.5, 0.9)
SIGMAS = (0.5, 1.0, 2.0)
POWERS = (1.0, 2.0, 5.0)
GRID = [
    np.log([length, sigma, power]) for length in LENGTHS for sigma in SIGMAS for power in POWERS
]
LIMITS = np.log([[0.02, 1.0], [0.5, 8.0], [1.0, 10.0]])
MOST_ELEMENTS = 2


@dataclass(frozen=True, repr=False, eq=False)
class BoucWen(FrictionLoop):
    """A curve and Bouc-Wen elements.

    Attributes
    ----------
    curve
        Coefficients of c(x), (n,), lowest first.
    beta, gamma, power, weights
        beta >= 0, gamma, n >= 1 and w of the elements, (m,).

    Examples
    --------
    The limit of |z| is (beta + gamma)^(-1/n):

    >>> model = BoucWen(curve=[0.0], beta=[3.0], gamma=[1.0], power=[2.0], weights=[1.0])
    >>> round(float(model.simulate([0.0, 9.0])[1]), 6)
    0.5
    """

    curve: Array = field(default_factory=lambda: np.array([0.0, 1.5]))
    beta: Array = field(default_factory=lambda: np.array([4.0]))
    gamma: Array = field(default_factory=lambda: np.array([2.25]))
    power: Array = field(default_factory=lambda: np.array([2.0]))
    weights: Array = field(default_factory=lambda: np.array([-0.8]))
    scaling: Scaling = UNSCALED
    start: str = "rest"
    card: ModelCard = models_kit.NO_CARD
    family = "bouc-wen"

    def __post_init__(self) -> None:
        self.check()
        for name in ("beta", "gamma", "power"):
            object.__setattr__(self, name, models_kit.parameter_array(getattr(self, name), name))
        sizes = {value.size for value in (self.beta, self.gamma, self.power, self.weights)}
        if len(sizes) != 1:
            raise ParameterError(
                f"beta, gamma, power and weights have {sorted(sizes)} values; give one an element."
            )
        if np.any(self.beta < 0.0):
            raise ParameterError(
                f"beta = {self.beta.tolist()}, but a friction that feeds energy in has no limits: give values >= 0."
            )
        sharpness(self.power)

    @property
    def lengths(self) -> Array:
        """Limit of |z| of each element, (m,); infinite where beta + gamma is not positive. [half ranges]"""
        both = self.beta + self.gamma
        # Without a limit the power is not used; 1 keeps it from dividing by zero.
        positive_sum = np.where(both > 0.0, both, 1.0)
        return np.where(both > 0.0, positive_sum ** (-1.0 / self.power), np.inf)

    def table(self) -> Array:
        """Elements as the engine takes them: psi = gamma + beta sgn(dx) sgn(z)."""
        # The signs of dx and z in each of the eight phases of the engine.
        along, side, _ = np.unravel_index(np.arange(8), (2, 2, 2))
        psi = self.gamma[:, None] + self.beta[:, None] * np.where(along == side, 1.0, -1.0)
        return np.hstack([np.ones((self.power.size, 1)), self.power[:, None], psi])

    def slope_ranges(self) -> tuple[Array, Array]:
        """dz/dx: 1 at z = 0; at the limit 0 loading and 2 beta L^n unloading; without a limit there is no largest."""
        both = self.beta + self.gamma
        unloading = np.where(both > 0.0, 2.0 * self.beta / np.where(both > 0.0, both, 1.0), np.inf)
        return np.where(both > 0.0, 0.0, np.minimum(1.0, unloading)), np.maximum(1.0, unloading)

    @property
    def parameters_of_element(self) -> int:
        """beta, gamma and n."""
        return 3


def bouc_wen_of(shapes: Sequence[Array], scaling: Scaling, start: str) -> BoucWen:
    """Elements of shapes (log L, log sigma, log n), without weights and curve."""
    length, sigma, power = np.exp(np.array(shapes)).T
    both = length**-power
    return BoucWen(
        np.zeros(1),
        sigma * both,
        (1.0 - sigma) * both,
        np.maximum(power, 1.0),
        np.zeros(length.size),
        scaling,
        start,
    )


def fit_bouc_wen(training: Training) -> BoucWen:
    """Return up to two elements that fit best, from the start state that fits best."""
    return search(training, bouc_wen_of, GRID, LIMITS, MOST_ELEMENTS)


FAMILY = Family(
    name="bouc-wen",
    title="Bouc-Wen",
    model=BoucWen,
    fit=fit_bouc_wen,
    convex=False,
    source="Y.-K. Wen, Method for random vibration of hysteretic systems, J. Eng. Mech. Div. ASCE 102 (1976) 249-263",
)
