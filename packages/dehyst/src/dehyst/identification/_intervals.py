r"""Weights of a fit drawn anew, and the interval of whatever is computed from a model.

Structure, start state, bounds and input stay; what the errors would have been on another log like this one is drawn.
With the normal equations G of the fitted rows, their errors r, and blocks b of consecutive rows, a draw is the solution
of the same program with other sums of errors::

    minimise  1/2 d' (G + penalty) d - d' sum over b of h_b A_b' r_b,    u + d >= lower

- r_b are the errors of block b by the fit without that block: those of the fit itself are too small (CR3: R. M. Bell and
  D. F. McCaffrey, Survey Methodology 28, 2002). They cost no fit, only the sums of the block.
- h_b has mean 0 and variance 1, one number a block, so that what belongs together stays together: errors that last,
  and what no model of this structure explains (cluster and score bootstrap: A. C. Cameron, J. B. Gelbach and D. L. Miller,
  Review of Economics and Statistics 90, 2008; P. Kline and A. Santos, Journal of Econometric Methods 1, 2012). It is that
  of Student's distribution, as there are few blocks.
- A block is ten times as long as the errors are correlated (the integrated autocorrelation time, within five times
  itself: A. D. Sokal, Monte Carlo Methods in Statistical Mechanics, 1997).
- A bound that holds a weight does not count as a force: where a weight is 0 because of noise, the draws leave it free to
  rise. So the draws have the pull of the bounds, too, and an interval is about the estimate: the share `level` of
  \|f(draw) - f(estimate)\| is within it, and it ends where no draw goes. At a bound it is one-sided.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

import dehyst._native as _native
from dehyst.arrays import Array, Mask
from dehyst.errors import DehystError, IdentificationError, ParameterError
from dehyst.families.kit import LinearForm
from dehyst.identification._policy import POLICY

WINDOW = 5.0  # correlation times within which correlations are added up
REGULAR = 1e-9  # of the mean diagonal: keeps sums without a block regular


@dataclass(frozen=True)
class Interval:
    """What a function of a model is, and between which values it would be on other logs like the fitted one.

    Attributes
    ----------
    value
        For the model itself: a number, or an array.
    low, high
        Ends of the interval, of the same shape.
    level
        Share of such logs whose intervals hold the value of the best model of this structure.
    """

    value: Any
    low: Any
    high: Any
    level: float

    @property
    def half_width(self) -> Any:
        """The longer way from the value to an end."""
        return np.maximum(self.high - self.value, self.value - self.low)


@dataclass(frozen=True, eq=False)
class Draws:
    """Models of a fit with weights drawn anew.

    Attributes
    ----------
    form
        The fit.
    unknowns
        Of each draw, (draws, p).
    blocks, block_rows
        Number of blocks, and rows in each.
    correlated_rows
        Integrated autocorrelation time of the errors. [rows]
    """

    form: LinearForm
    unknowns: Array
    blocks: int
    block_rows: int
    correlated_rows: float

    @cached_property
    def estimate(self) -> Any:
        """The model itself, with its terms of weight 0."""
        return self.form.model(self.form.unknowns)

    @cached_property
    def models(self) -> tuple[Any, ...]:
        """Of each draw."""
        return tuple(map(self.form.model, self.unknowns))

    def interval(self, function: Callable[[Any], npt.ArrayLike], level: float) -> Interval:
        """Return the interval of a function of a model; `Fit.interval` says more."""
        if not isinstance(level, int | float) or not 0.0 < level < 1.0:
            raise ParameterError(
                f"level = {level!r:.40}; it is the share of logs whose intervals hold the true value: above 0, below 1, "
                f"usually 0.95."
            )
        value = np.asarray(function(self.estimate), dtype=np.float64)
        drawn = []
        refused: DehystError | None = None
        for model in self.models:
            try:
                drawn.append(np.asarray(function(model), dtype=np.float64))
            # One draw may have no inverse, or no loop, where the model itself has just one.
            except DehystError as error:
                refused = error
        if refused is not None and len(drawn) < POLICY.answering_draws * len(self.models):
            raise IdentificationError(
                f"{len(self.models) - len(drawn)} of {len(self.models)} models with weights drawn anew have no such "
                f"value ({refused!s:.200}), so it has no interval. Ask for a value that more of them have."
            )
        values = np.array(drawn)
        reach = np.quantile(np.abs(values - value), level, axis=0)
        low = np.maximum(value - reach, np.minimum(values.min(axis=0), value))
        high = np.minimum(value + reach, np.maximum(values.max(axis=0), value))
        if value.ndim == 0:
            return Interval(float(value), float(low), float(high), float(level))
        return Interval(value, low, high, float(level))


def correlated_rows(errors: Array) -> float:
    r"""Return for how many rows errors are correlated, 1 for white noise: :math:`1 + 2 \sum_k \rho_k`.

    Examples
    --------
    >>> noise = np.random.default_rng(0).normal(size=5000)
    >>> round(correlated_rows(noise), 1), round(correlated_rows(np.repeat(noise, 8)))
    (1.0, 8)
    """
    size = errors.size
    centred = errors - errors.mean()
    padded = 1 << int(np.ceil(np.log2(2 * size)))
    spectrum = np.fft.rfft(centred, padded)
    sums = np.fft.irfft(spectrum * spectrum.conj(), padded)[: max(size // 2, 1)]
    if not sums[0] > 0.0:
        return 1.0
    times = 2.0 * np.cumsum(sums / sums[0]) - 1.0
    enough = np.flatnonzero(np.arange(times.size) >= WINDOW * times)
    last = enough[0] if enough.size else times.size - 1
    return max(1.0, float(times[last]))


def draws_of(form: LinearForm, seed: int = 0) -> Draws:
    """Draw the weights of a fit anew, `POLICY.interval_draws` times.

    Examples
    --------
    A mean of 100 numbers is known to a tenth of their deviation.

    >>> y = np.random.default_rng(1).normal(size=100)
    >>> ones, none = np.ones((100, 1)), np.zeros(1)
    >>> draws = draws_of(LinearForm(ones, y - y.mean(), y.mean(keepdims=True), none, np.zeros((1, 1)), float))
    >>> 0.08 < draws.unknowns.std() < 0.12
    True
    """
    rows, miss = form.rows, form.miss
    size = miss.size
    correlated = correlated_rows(miss)
    block_rows = POLICY.interval_block * correlated
    blocks = int(np.clip(size / block_rows, POLICY.fewest_interval_blocks, POLICY.most_interval_blocks))
    blocks = min(blocks, size)
    ends = np.linspace(0, size, blocks + 1).round().astype(np.int64)
    gram = rows.T @ rows + size * form.penalty
    free = form.unknowns > form.lower
    free[0] = True
    forces = np.empty((blocks, form.unknowns.size))
    for number, (begin, end) in enumerate(zip(ends[:-1], ends[1:], strict=True)):
        forces[number] = _without_block(rows[begin:end], miss[begin:end], gram, free)
    forces -= forces.mean(axis=0)
    random = np.random.default_rng(seed)
    shape = (POLICY.interval_draws, blocks)
    numbers = random.normal(size=shape)
    # Student's numbers share their divisor, as the scatter of a few blocks is itself known to some digits only.
    numbers *= np.sqrt(blocks / random.chisquare(blocks - 1, size=(shape[0], 1)))
    return Draws(
        form, _solved(form, gram, numbers @ forces, free), blocks, int(size / blocks), correlated
    )


def _without_block(rows: Array, miss: Array, gram: Array, free: Mask) -> Array:
    """Return A' r of a block, (p,), with its errors r by the fit to all the others."""
    of_free = rows[:, free]
    others = gram[np.ix_(free, free)] - of_free.T @ of_free
    others[np.diag_indices_from(others)] += REGULAR * float(np.mean(np.diag(gram)))
    moved = np.linalg.solve(others, of_free.T @ miss)
    return np.asarray(rows.T @ (miss + of_free @ moved))


def _solved(form: LinearForm, gram: Array, forces: Array, free: Mask) -> Array:
    """Return the solution under each force, (draws, p)."""
    # Columns of like length make the choices of the active set independent of units.
    scale = 1.0 / np.sqrt(np.maximum(np.diag(gram), 1e-300))
    system = gram * np.outer(scale, scale)
    at_rest = gram @ form.unknowns
    lower = form.lower / scale
    norm = float(np.sqrt(max(form.unknowns @ at_rest, 1e-300)))
    solutions = np.empty_like(forces)
    for k, force in enumerate(forces):
        v, *_ = _native.solve_bounded(
            system.copy(), (at_rest + force) * scale, lower, 1, 0, _native.WEIGHTS, None, None, free, norm
        )
        solutions[k] = v * scale
    return solutions
