"""LuGre friction: bristles with stiffness and damping and the Stribeck effect; depends on speed.

The mean deflection z of the bristles follows the path x and its speed v::

    z' = v - |v| z / L(v)                          so that |z| <= L(0)
    L(v) = L_c (1 + (rho - 1) exp(-(v / v_s)^2))   Stribeck's curve over the stiffness: g(v) = sigma_0 L(v)
    F = sigma_0 z + sigma_1 z' + sigma_2 v
    y = c(x) + F

In the usual letters F_c = sigma_0 L_c and F_s = rho F_c. At constant speed F = g(v) sgn v + sigma_2 v. Positive sigma
make the output lead (clockwise loops, a force over a displacement); negative ones, all three, make it lag. From sample
to sample the speed is constant, so that z is solved exactly. A move without time (dt = 0) is one of vanishing speed:
L(0), and neither z' nor v adds to it. Input and output are scaled to the range of the log, time is in seconds.

==============  =======================================================  ======================  ===================
parameter       meaning                                                  unit                    source
==============  =======================================================  ======================  ===================
``curve``       coefficients of c, lowest first; straight beyond +-1     scaled                  identified
``sigma``       sigma_0 stiffness, sigma_1 damping of the bristles,      scaled, scaled s,       identified, convex
                sigma_2 viscous friction                                 scaled s
``length``      L_c = F_c / sigma_0                                      half ranges             identified
``ratio``       rho = F_s / F_c >= 1                                     1                       identified
``stribeck``    v_s                                                      half ranges / s         identified
==============  =======================================================  ======================  ===================

Source: C. Canudas de Wit, H. Olsson, K. J. Astrom, P. Lischinsky, A new model for control of systems with friction,
IEEE Trans. Automatic Control 40 (1995) 419-425. Passivity: N. Barabanov and R. Ortega, Necessary and sufficient
conditions for passivity of the LuGre friction model, ibid. 45 (2000) 830-832. Structure: high confidence.

The fit: curve and sigma are the solution of a convex program for given L_c, rho and v_s, which are searched from a grid
by the simplex method of Nelder and Mead. Time stamps are needed.

Cannot show
-----------
Loops at vanishing speed that are more than one exponential (it is Dahl's friction there, with one length). Memory of
minor loops: they drift. Frictional lag while always slipping, other than that of one length. An inverse, where the
friction falls with speed faster than the curve rises, and wherever damping lags: then a faster move may need less.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import product
from typing import Self

import numpy as np

import dehyst._native as _native
from dehyst.arrays import Array
from dehyst.errors import IdentificationError, ParameterError
from dehyst.families._base import UNSCALED, LoopModel, Scaling
from dehyst.families._curve import slopes
from dehyst.families._friction import CALM
from dehyst.families._inversion import FARTHEST
from dehyst.families._registry import Family
from dehyst.families._shapes import search
from dehyst.families._training import Training
from dehyst.models import ModelCard
from dehyst.models import kit as models_kit

LENGTHS = (0.005, 0.02, 0.06, 0.15, 0.4, 0.9)
RATIOS = (1.02, 1.5, 3.0)
SPEEDS = (0.1, 0.5, 2.0)  # of the root of the mean squared speed of the log


@dataclass(frozen=True, repr=False, eq=False)
class LuGre(LoopModel):
    """A curve and LuGre friction.

    Attributes
    ----------
    curve
        Coefficients of c(x), (n,), lowest first.
    sigma
        sigma_0, sigma_1, sigma_2, (3,), all of one sign.
    length, ratio, stribeck
        L_c > 0, rho >= 1, v_s > 0.

    Examples
    --------
    Pulled slowly it breaks away at F_s = rho F_c:

    >>> import numpy as np
    >>> model = LuGre(curve=[0.0], sigma=[10.0, 0.0, 0.0], length=0.1, ratio=1.5, stribeck=0.1)
    >>> x = np.linspace(0.0, 2.0, 200)
    >>> round(float(model.simulate(x, 1e4 * x)[-1]), 4)
    1.5
    """

    curve: Array = field(default_factory=lambda: np.array([0.0, 1.0]))
    sigma: Array = field(default_factory=lambda: np.array([2.0, 0.01, 0.05]))
    length: float = 0.15
    ratio: float = 1.05
    stribeck: float = 0.5
    scaling: Scaling = UNSCALED
    start: str = "rest"
    card: ModelCard = models_kit.NO_CARD
    family = "lugre"
    rate_dependent = True

    def __post_init__(self) -> None:
        for name in ("curve", "sigma"):
            object.__setattr__(self, name, models_kit.parameter_array(getattr(self, name), name))
        for name in ("length", "ratio", "stribeck"):
            object.__setattr__(self, name, models_kit.parameter_number(getattr(self, name), name))
        if self.sigma.size != 3 or (np.any(self.sigma < 0.0) and np.any(self.sigma > 0.0)):
            raise ParameterError(
                f"sigma = {self.sigma.tolist()}; give sigma_0, sigma_1 and sigma_2, none negative for an output that "
                f"leads, none positive for one that lags."
            )
        if self.length <= 0.0 or self.ratio < 1.0 or self.stribeck <= 0.0:
            raise ParameterError(
                f"length = {self.length:g}, ratio = {self.ratio:g}, stribeck = {self.stribeck:g}; length and stribeck "
                f"must be positive and ratio = F_s/F_c at least 1."
            )

    @property
    def _numbers(self) -> Array:
        return np.array([*self.sigma, self.length, self.ratio, self.stribeck])

    def rest(self, x: float) -> Array:
        """Bristles upright, at x."""
        return np.array([x, 0.0])

    def run(self, x: Array, dt: Array | None, memory: Array) -> tuple[Array, Array]:
        """Outputs along scaled inputs, and the memory after them."""
        return _native.lugre_run(x, _steps(x, dt), self.curve, self._numbers, memory)

    def run_inverse(self, y: Array, dt: Array | None, memory: Array) -> tuple[Array, Array]:
        """Inputs for outputs: a root of a rising function each sample, to the last bits."""
        return _native.lugre_invert(y, _steps(y, dt), FARTHEST, self.curve, self._numbers, memory)

    def states(self, x: Array, dt: Array | None = None) -> Array:
        """z, z' and v (T, 3) along scaled inputs, from the start state on."""
        memory = self.before(float(x[0]))
        return _native.lugre_columns(x, _steps(x, dt), self.curve, self._numbers, memory)

    def column_ranges(self) -> tuple[Array, Array]:
        """What a fit adds of x to a column so that it rises while the speed stays the same: nothing where it leads."""
        return np.zeros(3), np.array([1.0 + self.ratio, 0.0, 0.0])

    def mixed(self, curve: Array, weights: Array) -> Self:
        """Return the same friction curve over another c, with other sigma."""
        return replace(self, curve=curve, sigma=weights)

    @property
    def passive(self) -> bool:
        """Whether friction never gives back more than it stored: sigma_2 >= sigma_1 (F_s - F_c)/F_c."""
        return bool(
            np.all(self.sigma >= 0.0) and self.sigma[2] >= self.sigma[1] * (self.ratio - 1.0)
        )

    def friction(self, v: float) -> float:
        """Friction at constant speed v: g(v) sgn v + sigma_2 v."""
        length = self.length * (1.0 + (self.ratio - 1.0) * np.exp(-((v / self.stribeck) ** 2)))
        return float(self.sigma[0] * length * np.sign(v) + self.sigma[2] * v)

    @property
    def no_inverse(self) -> str:
        """Why there need not be one: bounds of each term's slope over one move, for every duration of it."""
        rho, curve = self.ratio, float(np.min(slopes(self.curve)))
        stiffness, damping, viscous = self.sigma
        # The most that z changes because L(v) changes with the speed, over the move.
        falling = 2.0 / math.e * rho * (rho - 1.0)
        if damping < 0.0 or viscous < 0.0:
            return "its output falls behind a faster input, so that an output may belong to a slow and to a fast move."
        if stiffness < 0.0:
            least = curve + stiffness * (1.0 + rho + falling)
        else:
            least = curve - stiffness * (rho - 1.0 + falling)
        # The first condition concerns slow moves, where stiffness acts; the second one fast moves, where damping acts.
        if least <= CALM:
            return (
                f"its friction changes with speed and direction by more than its curve rises (least slope "
                f"{least:.3g} of the mean one cannot be excluded), so that one output may belong to several inputs."
            )
        knee = rho - 1.0 + (1.0 + rho) / math.e + falling * (1.0 + 1.0 / math.e)
        if rho == 1.0:
            knee = 2.0 * np.exp(-2.0)
        if viscous < damping * knee:
            return (
                f"the damping of its bristles, sigma_1 = {damping:.3g}, ends while they slip and is not made up for by "
                f"viscous friction (sigma_2 = {viscous:.3g}, needed {damping * knee:.3g}): a faster move may need less."
            )
        return ""

    @property
    def free_parameters(self) -> int:
        """Coefficients of the curve, sigma that are not zero, and the friction's three where it has any."""
        bristles = 3 * bool(np.any(self.sigma[:2] != 0.0))
        return int(self.curve.size + np.count_nonzero(self.sigma) + bristles)


def _steps(signal: Array, dt: Array | None) -> Array:
    """Return the times between samples as the engine takes them; without time the moves are infinitely slow."""
    if dt is None:
        return np.zeros(signal.size)
    return np.ascontiguousarray(dt)


def fit_lugre(training: Training) -> LuGre:
    """Return the friction that fits best, from the start state that fits best."""
    if not training.timed:
        raise IdentificationError(
            "LuGre friction depends on speed, but the log has no time stamps. Name its time column, or its rate."
        )
    moves = np.concatenate([np.diff(stretch.x) for stretch in training.stretches])
    steps = np.concatenate([np.asarray(stretch.dt)[1:] for stretch in training.stretches])
    timed = steps > 0.0
    speed = float(np.sqrt(np.sum(moves[timed] ** 2 / steps[timed]) / np.sum(steps[timed])))

    def shaped(shapes: Sequence[Array], scaling: Scaling, start: str) -> LuGre:
        # Speeds of the grid are shares of the usual speed of the log.
        length, ratio, stribeck = np.exp(shapes[0])
        return LuGre(np.zeros(1), np.zeros(3), length, ratio, stribeck * speed, scaling, start)

    # The search runs over logarithms, as lengths and speeds differ by orders of magnitude.
    grid = [np.log(shape) for shape in product(LENGTHS, RATIOS, SPEEDS)]
    limits = np.log([[0.001, 2.0], [1.0, 10.0], [0.01, 10.0]])
    signs = {"clockwise": (1,), "counter-clockwise": (-1,)}.get(training.orientation, (1, -1))
    fits = [search(training, shaped, grid, limits, signs=(sign,)) for sign in signs]
    return training.best(fits)


FAMILY = Family(
    name="lugre",
    title="LuGre",
    model=LuGre,
    fit=fit_lugre,
    convex=False,
    source="C. Canudas de Wit, H. Olsson, K. J. Astrom, P. Lischinsky, A new model for control of systems with "
    "friction, IEEE Trans. Automatic Control 40 (1995) 419-425",
)
