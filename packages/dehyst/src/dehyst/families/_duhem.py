"""Duhem model in the form of Coleman and Hodgdon: the slope depends on input, output and direction.

The slope of the output depends on the direction of the input, its value, and the distance to a curve f::

    y' = alpha |x'| (f(x) - y) + x' g(x)

With h = f' - g, the loss, and w = f - y this is ``dw/dx = h(x) - alpha sgn(dx) w``. h is a polynomial on the range of
the log, its weights those of Bernstein's polynomials and all of one sign, and constant beyond; then a polynomial P with
``P' + alpha sgn(dx) P = h`` solves each stroke in closed form::

    w(x) = P(x) + (w_0 - P(x_0)) exp(-alpha |x - x_0|)

A loss above zero makes the output lag (counter-clockwise loops, an actuator), below zero it leads. A constant loss is
Dahl's friction of length 1/alpha. Input and output are scaled to the range of the log.

==============  =======================================================  ================  ===================
parameter       meaning                                                  unit              source
==============  =======================================================  ================  ===================
``curve``       coefficients of f, lowest first; straight beyond +-1     scaled            identified, convex
``alpha``       how soon a stroke forgets where it began                 1/half range      identified
``loss``        Bernstein coefficients of h over [-1, 1]                 scaled            identified, convex
==============  =======================================================  ================  ===================

Source: B. D. Coleman and M. L. Hodgdon, On a class of constitutive relations for ferromagnetic hysteresis, Arch.
Rational Mech. Anal. 99 (1987) 375-396. Structure: high confidence. A polynomial h and its fit are this project's.

The fit: for given alpha, f and the loss are the solution of one convex program, least squares with slopes that stay
positive in every reachable state; alpha alone is searched, on a grid and then by golden sections. That condition is
Coleman and Hodgdon's own, ``g(x) >= alpha e^(alpha x) int_x^oo (f' - g) e^(-alpha u) du`` and its mirror image: then
the output rises with the input, and there is an inverse.

Cannot show
-----------
More than one length of memory (see dahl, bouc-wen). Closed minor loops: a small cycle drifts towards f. Speed. A sharp
knee.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from math import comb

import numpy as np

import dehyst._native as _native
from dehyst.arrays import Array
from dehyst.errors import IdentificationError, ParameterError
from dehyst.families._base import STARTS, UNSCALED, LoopModel, Scaling
from dehyst.families._curve import FLOOR, rising_polynomials, values
from dehyst.families._friction import CALM, best_start
from dehyst.families._inversion import FARTHEST
from dehyst.families._registry import Family
from dehyst.families._training import Training
from dehyst.least_squares import lawson_hanson
from dehyst.models import ModelCard
from dehyst.models import kit as models_kit

LOSSES = 6  # coefficients of a fitted loss
MOST_LOSSES = 16
ALPHAS = np.geomspace(0.3, 60.0, 14)
# Places of [-1, 1], dense at its ends, where a slope is looked at, and where a fit keeps it positive.
PLACES = -np.cos(np.linspace(0.0, np.pi, 2001))
WATCHED = PLACES[::10]
SAMPLES = 3000  # for the search of alpha
GOLDEN = 0.5 * (5.0**0.5 - 1.0)
SECTIONS = 18  # alpha to 1e-4 of itself: the error, flat there, changes by 1e-8 of itself


@lru_cache
def bernstein(size: int) -> Array:
    """Coefficients (size, size) of Bernstein's polynomials on [-1, 1], a row each, lowest power first."""
    rows = np.zeros((size, size))
    up, down = np.polynomial.Polynomial([0.5, 0.5]), np.polynomial.Polynomial([0.5, -0.5])
    for k in range(size):
        coefficients = (comb(size - 1, k) * up**k * down ** (size - 1 - k)).coef
        rows[k, : coefficients.size] = coefficients
    rows.flags.writeable = False
    return rows


@dataclass(frozen=True, repr=False, eq=False)
class Duhem(LoopModel):
    """Coleman and Hodgdon's model.

    Attributes
    ----------
    curve
        Coefficients of f(x), (n,), lowest first.
    alpha
        alpha > 0.
    loss
        Bernstein coefficients of h, (1 to 16,), none of them of the other sign.

    Examples
    --------
    With f = x and a constant loss a long stroke stays h/alpha behind:

    >>> model = Duhem(curve=[0.0, 1.0], alpha=4.0, loss=[0.8])
    >>> [round(float(y), 6) for y in model.simulate([0.0, 9.0, -9.0])]
    [0.0, 8.8, -8.8]
    """

    curve: Array = field(default_factory=lambda: np.array([0.0, 1.0]))
    alpha: float = 4.0
    loss: Array = field(default_factory=lambda: np.array([0.1, 0.4]))
    scaling: Scaling = UNSCALED
    start: str = "rest"
    card: ModelCard = models_kit.NO_CARD
    family = "duhem"

    def __post_init__(self) -> None:
        for name in ("curve", "loss"):
            object.__setattr__(self, name, models_kit.parameter_array(getattr(self, name), name))
        object.__setattr__(self, "alpha", models_kit.parameter_number(self.alpha, "alpha"))
        if self.alpha <= 0.0:
            raise ParameterError(
                f"alpha = {self.alpha:g}, but a stroke that never forgets has no loops; give it > 0."
            )
        # With both signs no stroke would have one limit, and the bound of the slope below would not hold.
        if np.any(self.loss > 0.0) and np.any(self.loss < 0.0):
            raise ParameterError(
                f"loss = {self.loss.tolist()} lags at some inputs and leads at others; give one sign."
            )
        if self.loss.size > MOST_LOSSES:
            raise ParameterError(
                f"loss has {self.loss.size} coefficients; give at most {MOST_LOSSES}."
            )

    @cached_property
    def _powers(self) -> Array:
        return np.ascontiguousarray(self.loss @ bernstein(self.loss.size))

    def rest(self, x: float) -> Array:
        """On the curve, at x."""
        return np.array([x, 0.0])

    def run(self, x: Array, dt: Array | None, memory: Array) -> tuple[Array, Array]:
        """Outputs along scaled inputs, and the memory after them."""
        return _native.duhem_run(x, self.curve, self.alpha, self._powers, memory)

    def run_inverse(self, y: Array, dt: Array | None, memory: Array) -> tuple[Array, Array]:
        """Inputs for outputs: a root of a rising function each sample, to the last bits."""
        return _native.duhem_invert(y, FARTHEST, self.curve, self.alpha, self._powers, memory)

    @property
    def least_slope(self) -> float:
        """Least dy/dx over all places and reachable states, scaled."""
        away = steepest(self._powers, self.alpha, float(np.sign(self.loss.sum())), PLACES)
        slope = slope_of(self.curve, PLACES)
        return float(np.min(np.concatenate([slope, slope, slope[[0, -1]]]) - away))

    @property
    def no_inverse(self) -> str:
        """Why not: some reachable state in which the output does not rise with the input."""
        least = self.least_slope
        if least > CALM:
            return ""
        return (
            f"after a turn its output may move against its input (least slope {least:.3g} of the mean one): the loss "
            f"is larger than the slope of the curve can bear."
        )

    @property
    def free_parameters(self) -> int:
        """Coefficients of the curve and of the loss, and alpha."""
        return int(self.curve.size + np.count_nonzero(self.loss) + bool(np.any(self.loss != 0.0)))


def slope_of(curve: Array, x: Array) -> Array:
    """Slope of a polynomial at x."""
    polynomial = np.polynomial.polynomial
    return np.asarray(polynomial.polyval(x, polynomial.polyder(curve)) + 0.0 * x)


def steepest(powers: Array, alpha: float, sign: float, x: Array) -> Array:
    """Return what a loss takes from the slope of the curve at worst, (2 T + 2,): rising and falling at x, far outside.

    `powers` are the coefficients of h >= 0 or <= 0, `sign` its sign. The extreme states at x are those after endless
    strokes: w_up = int h e^(-alpha (x - u)) du from below, and w_down, minus the integral from above.
    """
    value = np.polynomial.polynomial.polyval
    h = value(x, powers)
    up, down = np.zeros(powers.size), np.zeros(powers.size)
    # Coefficients of the polynomial P with P' + rate P = h, from the highest power down.
    for particular, rate in ((up, alpha), (down, -alpha)):
        above = 0.0
        for j in range(powers.size - 1, -1, -1):
            above = (powers[j] - (j + 1) * above) / rate
            particular[j] = above
    w_up = value(x, up) + (h[0] / alpha - value(-1.0, up)) * np.exp(-alpha * (x + 1.0))
    w_down = value(x, down) + (-h[-1] / alpha - value(1.0, down)) * np.exp(-alpha * (1.0 - x))
    # The worst state is the one that is farthest from the curve on the side that the loss pulls to.
    if sign >= 0.0:
        rising, falling, outside = h - alpha * w_down, h + alpha * w_up, 2.0 * h[[0, -1]]
    else:
        rising, falling, outside = h - alpha * w_up, h + alpha * w_down, np.zeros(2)
    return np.concatenate([rising, falling, outside])


class DuhemProgram:
    """Best curve and loss for one alpha, on one set of data: convex, rising in every reachable state.

    Parameters
    ----------
    training
        Data.
    sign
        1 for a loss above zero, the output lags; -1 for one below.
    """

    def __init__(self, training: Training, sign: int) -> None:
        self.training, self.sign = training, sign
        self._basis = rising_polynomials()
        x = training.joined(lambda s: s.x[:, None])[:, 0]
        self._curves = np.column_stack([values(row, x) for row in self._basis])
        self._y = training.y
        rising = np.column_stack([slope_of(row, WATCHED) for row in self._basis])
        self._rising = np.vstack([rising, rising, rising[[0, -1]]])

    def __call__(self, alpha: float, start: str) -> tuple[Duhem, float]:
        """Return the best model, and the root mean square of what it leaves."""
        columns, losses = [self._curves], []
        for unit, row in zip(np.eye(LOSSES), bernstein(LOSSES), strict=True):
            model = Duhem(np.zeros(1), alpha, self.sign * unit, self.training.scaling, start)
            columns.append(self._outputs(model))
            losses.append(steepest(self.sign * row, alpha, self.sign, WATCHED))
        regressors = np.hstack(columns)
        # Conditions: the output rises by FLOOR at least in every reachable state, and the losses have one sign.
        slopes = np.hstack([self._rising, -np.column_stack(losses)])
        above = np.vstack([slopes, np.eye(regressors.shape[1])[-LOSSES:]])
        least = np.concatenate([np.full(self._rising.shape[0], FLOOR), np.zeros(LOSSES)])
        weights, offset, rms = bounded(regressors, self._y, above, least)
        curve = weights[: len(self._basis)] @ self._basis
        curve[0] += offset
        loss = self.sign * np.maximum(weights[len(self._basis) :], 0.0)
        return Duhem(curve, alpha, loss, self.training.scaling, start), rms

    def _outputs(self, model: Duhem) -> Array:
        return self.training.joined(lambda stretch: stretch.run(model)[:, None])


def bounded(columns: Array, y: Array, above: Array, least: Array) -> tuple[Array, float, float]:
    """Return c, an offset and the error: least squares of ``columns @ c + offset - y`` with ``above @ c >= least``.

    Lawson and Hanson's least distance programming: one least squares with weights that are not negative.
    """
    mean, level = columns.mean(axis=0), float(y.mean())
    centred, target = columns - mean, y - level
    size = np.linalg.norm(centred, axis=0)
    size[size == 0.0] = 1.0
    # A small ridge keeps the triangle regular where columns depend on each other.
    ridge = np.eye(size.size, size.size + 1) * 1e-7
    stack = np.vstack([np.column_stack([centred / size, target]), ridge])
    triangle: Array = np.linalg.qr(stack, mode="r")  # type: ignore[assignment]
    square, goal, residual = triangle[:-1, :-1], triangle[:-1, -1], triangle[-1, -1]
    # In the coordinates of the triangle the nearest point to the free solution is looked for.
    free = np.linalg.solve(square, goal)
    turned = np.linalg.solve(square.T, (above / size).T).T
    short = least - (above / size) @ free
    unit = max(float(np.max(np.abs(short))), 1e-12)
    ends = np.zeros(size.size + 1)
    ends[-1] = 1.0
    dual = lawson_hanson(np.vstack([turned.T, short / unit]), ends)
    if dual is None:
        raise IdentificationError(
            f"the least squares of a curve with {least.size} conditions on its slope did not end. The log hardly "
            f"moves: look at it with dehyst inspect.",
            conditions=least.size,
        )
    slack = np.concatenate([turned.T @ dual, [short @ dual / unit - 1.0]])
    move = np.zeros(size.size)
    if slack[-1] != 0.0:
        move = -unit * slack[:-1] / slack[-1]
    scaled = free + np.linalg.solve(square, move)
    miss = float(np.sqrt((residual**2 + move @ move) / y.size))
    weights = scaled / size
    return weights, level - float(mean @ weights), miss


def fit_duhem(training: Training) -> Duhem:
    """Return the model that fits best, from the start state that fits best."""
    signs = {"clockwise": (-1,), "counter-clockwise": (1,)}.get(training.orientation, (1, -1))
    return training.best([_fitted(training, sign) for sign in signs])


def _fitted(training: Training, sign: int) -> Duhem:
    program = DuhemProgram(training.thinned(SAMPLES), sign)
    errors, alphas = {}, {}
    for start in STARTS:
        tried = [(program(float(alpha), start)[1], float(alpha)) for alpha in ALPHAS]
        errors[start], alphas[start] = min(tried)
    start = best_start(errors)
    # Between the neighbours of the best alpha of the grid the error has one valley.
    near = np.log(alphas[start])
    step = np.log(ALPHAS[1] / ALPHAS[0])
    best = golden_sections(
        lambda a: program(float(np.exp(a)), start)[1], near - step, near + step, SECTIONS
    )
    model = DuhemProgram(training.spread(), sign)(float(np.exp(best)), start)[0]
    if np.any(model.loss != 0.0):
        return model
    return replace(model, loss=np.zeros(1))


def golden_sections(
    error: Callable[[float], float], low: float, high: float, sections: int
) -> float:
    """Return where a function with one valley is least, between limits; each section costs one evaluation.

    Examples
    --------
    >>> round(golden_sections(lambda x: (x - 0.3) ** 2, 0.0, 1.0, 30), 4)
    0.3
    """
    left = high - GOLDEN * (high - low)
    right = low + GOLDEN * (high - low)
    at_left, at_right = error(left), error(right)
    for _ in range(sections):
        if at_left < at_right:
            high, right, at_right = right, left, at_left
            left = high - GOLDEN * (high - low)
            at_left = error(left)
        else:
            low, left, at_left = left, right, at_right
            right = low + GOLDEN * (high - low)
            at_right = error(right)
    return left if at_left < at_right else right


FAMILY = Family(
    name="duhem",
    title="Duhem (Coleman-Hodgdon)",
    model=Duhem,
    fit=fit_duhem,
    convex=False,
    source="B. D. Coleman and M. L. Hodgdon, On a class of constitutive relations for ferromagnetic hysteresis, Arch. "
    "Rational Mech. Anal. 99 (1987) 375-396",
)
