r"""Weights of a fit drawn anew, and the interval of whatever is computed from a model.

Structure, start state, bounds and input stay; what the errors would have been on another log like this one is drawn.
With the normal equations G of the fitted rows, their errors r, and blocks b of consecutive rows, a draw is the solution
of the same program with other sums of errors::

    minimise  1/2 d' (G + penalty) d - d' sum over b of h_b A_b' r_b,    u + d >= lower

- r_b are the errors of block b by the fit without that block: those of the fit itself are too small (CR3: R. M. Bell
  and D. F. McCaffrey, Survey Methodology 28, 2002). They cost no fit, only the sums of the block. The fit follows the
  errors of a block that alone tells of some unknown: in their place stands noise as large and lasting as all errors.
- h_b is normal, one number a block, so that what belongs together stays together: errors that last, and what no model
  of this structure explains (cluster and score bootstrap: A. C. Cameron, J. B. Gelbach and D. L. Miller, Review of
  Economics and Statistics 90, 2008; P. Kline and A. Santos, Journal of Econometric Methods 1, 2012).
- Blocks are so long that 5 % of the variance of their sums is lost across their ends (`block_rows`).
- A bound that holds a weight does not count as a force: where noise may be why a weight is 0, the draws are free to
  rise. So they have the pull of the bounds, too.

The draws of a sum from which terms were taken out are those of the sum before: what taking them out changed is then in
the interval, and so are weights that noise took out. The interval of f is f(u) - t s to f(u) + t s, where s is the root
mean square of f(draw) - f(u), and t that of Student's distribution for the number of blocks. It does not cross 0 where
no draw does: 0 is the bound of weights.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

import dehyst._native as _native
from dehyst.arrays import Array, Mask
from dehyst.errors import DehystError, IdentificationError, ParameterError
from dehyst.families.kit import LinearForm
from dehyst.identification._policy import POLICY
from dehyst.student import quantile

LEVEL = 0.95  # of the intervals that are printed and drawn
WINDOW = 5.0  # correlation times within which correlations are added up (A. D. Sokal, 1997)
SMALLEST = 1e-300  # that is divided by, or taken the root of
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


class LoopBand(NamedTuple):
    """Input, output of the model, and half the width of its interval, along the fitted rows, (K,) each."""

    inputs: Array
    outputs: Array
    half_width: Array


@dataclass(frozen=True, eq=False)
class Draws:
    """Models of a fit with weights drawn anew.

    Attributes
    ----------
    form
        The fit.
    unknowns
        Of each draw, (draws, p).
    blocks
        Number of blocks of the fitted rows.
    """

    form: LinearForm
    unknowns: Array
    blocks: int

    @cached_property
    def models(self) -> tuple[Any, ...]:
        """Of each draw."""
        return tuple(map(self.form.model, self.unknowns))

    @cached_property
    def band(self) -> LoopBand | None:
        """The 95 % interval of the output along the fitted rows; None where the rows are of the input."""
        form = self.form
        if form.inputs is None or form.outputs is None:
            return None
        moved = form.rows @ (self.unknowns - form.unknowns).T
        spread = np.sqrt(np.mean(moved**2, axis=1))
        return LoopBand(
            form.inputs, form.outputs, quantile(LEVEL, self.blocks - 1) * form.unit * spread
        )

    def interval(self, function: Callable[[Any], npt.ArrayLike], level: float) -> Interval:
        """Return the interval of a function of a model; `Fit.interval` says more."""
        if not isinstance(level, int | float) or not 0.0 < level < 1.0:
            raise ParameterError(
                f"level = {level!r:.40}; it is the share of logs whose intervals hold the true value: above 0, below "
                f"1, usually 0.95."
            )
        value = np.asarray(function(self.form.estimate), dtype=np.float64)
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
        spread = np.sqrt(np.mean((values - value) ** 2, axis=0))
        reach = quantile(level, self.blocks - 1) * spread
        low, high = value - reach, value + reach
        # What no draw passes is a bound: of a weight, a width, a gain.
        low = np.where(values.min(axis=0) >= 0.0, np.maximum(low, 0.0), low)
        high = np.where(values.max(axis=0) <= 0.0, np.minimum(high, 0.0), high)
        if value.ndim == 0:
            return Interval(float(value), float(low), float(high), float(level))
        return Interval(value, low, high, float(level))


def block_rows(errors: Array) -> float:
    r"""Return how long blocks of errors have to be, for white noise ten.

    A sum over a block of L errors has the variance :math:`L \sum_k \rho_k - 2 \sum_{k>0} k \rho_k` for long L, with
    the autocorrelations :math:`\rho_k`. Of errors that last T, :math:`\rho_k = e^{-|k|/T}`, the second term, which is
    lost, is the share T/L of the first. L is at least as long as for these with the same :math:`\sum_k \rho_k`, and
    longer where a part of the errors lasts and a part is white.

    Examples
    --------
    >>> noise = np.random.default_rng(0).normal(size=20_000)
    >>> held = np.repeat(noise, 9)  # their correlations add up to 9 times those of the noise
    >>> 80.0 < block_rows(held) < 100.0, round(block_rows(noise))
    (True, 10)
    """
    size = errors.size
    centred = errors - errors.mean()
    padded = 1 << int(np.ceil(np.log2(2 * size)))
    spectrum = np.fft.rfft(centred, padded)
    sums = np.fft.irfft(spectrum * spectrum.conj(), padded)[: max(size // 2, 1)]
    if not sums[0] > 0.0:
        return 1.0
    lags = np.arange(sums.size)
    correlations = sums / sums[0]
    times = 2.0 * np.cumsum(correlations) - 1.0
    enough = np.flatnonzero(lags >= WINDOW * times)
    last = int(enough[0]) if enough.size else times.size - 1
    lasting = max(float(times[last]), 1.0)
    lost = 2.0 * float(lags[: last + 1] @ correlations[: last + 1]) / lasting
    return max(0.5 * lasting, lost) / POLICY.lost_variance


def draws_of(form: LinearForm, seed: int = 0) -> Draws:
    """Draw the weights of a fit anew, `POLICY.interval_draws` times.

    Examples
    --------
    A mean of 10 000 numbers is known to a hundredth of their deviation.

    >>> y = np.random.default_rng(1).normal(size=10_000)
    >>> ones, none = np.ones((10_000, 1)), np.zeros(1)
    >>> errors, mean, unit = y - y.mean(), y.mean(keepdims=True), np.ones(10_000)
    >>> form = LinearForm(ones, errors, mean, none, np.zeros((1, 1)), None, None, unit, y.mean(), float)
    >>> draws = draws_of(form)
    >>> bool(0.008 < draws.unknowns.std() < 0.012)
    True
    """
    rows, miss = form.rows, form.miss
    size = miss.size
    most = min(POLICY.most_interval_blocks, size)
    least = min(POLICY.fewest_interval_blocks, most)
    length = block_rows(miss)
    blocks = int(np.clip(size / length, least, most))
    ends = np.linspace(0, size, blocks + 1).round().astype(np.int64)
    gram = rows.T @ rows + size * form.penalty
    gram[np.diag_indices_from(gram)] += REGULAR * float(np.mean(np.diag(gram)))
    free = form.unknowns > form.lower
    free[0] = True
    gram_of_free = gram[np.ix_(free, free)]
    known = 1.0 / np.diag(np.linalg.inv(gram_of_free))
    # Deviation of a sum of errors over the root of its length.
    lasting = float(np.sqrt(np.mean(miss**2) * max(1.0, 2.0 * POLICY.lost_variance * length)))
    random = np.random.default_rng(seed)
    numbers = random.normal(size=(POLICY.interval_draws, blocks))
    forces = np.zeros((blocks, form.unknowns.size))
    alone = np.zeros((POLICY.interval_draws, form.unknowns.size))
    for number, (begin, end) in enumerate(pairwise(ends.tolist())):
        part, errors = rows[begin:end], miss[begin:end]
        of_free = part[:, free]
        others = np.linalg.inv(gram_of_free - of_free.T @ of_free)
        if np.min(1.0 / (np.diag(others) * known)) < POLICY.told_elsewhere:
            # The fit follows the errors of such a block, and without it there is none.
            alone += lasting * random.normal(size=(len(alone), end - begin)) @ part
        else:
            forces[number] = part.T @ (errors + of_free @ (others @ (of_free.T @ errors)))
    forces -= forces.mean(axis=0)
    # Of a few blocks the mean takes one degree of freedom.
    forces *= np.sqrt(blocks / (blocks - 1))
    return Draws(form, _solved(form, gram, numbers @ forces + alone, free), blocks)


def _solved(form: LinearForm, gram: Array, forces: Array, free: Mask) -> Array:
    """Return the solution under each force, (draws, p)."""
    # Columns of like length make the choices of the active set independent of units.
    scale = 1.0 / np.sqrt(np.maximum(np.diag(gram), SMALLEST))
    system = gram * np.outer(scale, scale)
    at_rest = gram @ form.unknowns
    lower = form.lower / scale
    norm = float(np.sqrt(max(float(form.unknowns @ at_rest), SMALLEST)))
    solutions = np.empty_like(forces)
    for k, force in enumerate(forces):
        v, *_ = _native.solve_bounded(
            system,
            (at_rest + force) * scale,
            lower,
            1,
            0,
            _native.WEIGHTS,
            None,
            None,
            free,
            norm,
        )
        solutions[k] = v * scale
    return solutions
