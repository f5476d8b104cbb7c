"""Normal equations for models of one's own: plays with a polynomial or creep beside them, from one pass over the data.

`identify` does all of this for its families. Here the sums are at hand, and `solve` fits them in the log's units.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from dehyst import _native
from dehyst._native import Gram
from dehyst.errors import IdentificationError, ParameterError
from dehyst.identification.data import counting
from dehyst.identification.memory import state_before
from dehyst.identification.settings import check_recordings, check_settings, check_weights
from dehyst.identification.sums import NormalEquations
from dehyst.models.arrays import parameter_array, parameter_number
from dehyst.recording import Recording

__all__ = ["NormalEquations", "Weights", "accumulate", "creep", "polynomial", "solve"]

Array = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Weights:
    """What `solve` finds.

    Attributes
    ----------
    offset
        c. [output]
    weights
        w, (n,). [output/input]
    coefficients
        Of the extra columns, (m,). [output/unit of the column]
    rms
        Root of the mean squared residual. [output]
    kkt_residual, condition
        As in a fit's certificate.
    """

    offset: float
    weights: Array
    coefficients: Array
    rms: float
    kkt_residual: float
    condition: float


def solve(sums: NormalEquations, eps: float = 0.001, *, cumulative: bool = False) -> Weights:
    r"""Fit plays and extra columns together.

    .. math::

        \min_{w, a, c} \sum_k v_k \Big(y_k - c - \sum_i w_i z_i[k] - \sum_j a_j f_j[k]\Big)^2
        \quad \text{subject to} \quad w_1 \ge \varepsilon, \; w_i \ge 0

    Parameters
    ----------
    sums
        What `accumulate` returned.
    eps
        Smallest slope right after a reversal. [output/input]
    cumulative
        Bound the sums w_1 + ... + w_i >= eps instead of the weights.

    Raises
    ------
    IdentificationError
        If columns are so alike that the sums do not tell them apart.
    """
    n, m = sums.operators, sums.extra
    # Unknowns without a bound come first.
    order = np.concatenate([[0], np.arange(1 + n, 1 + n + m), np.arange(1, 1 + n)])
    gram = np.ascontiguousarray(sums.matrix[np.ix_(order, order)])
    lower = np.full(1 + m + n, eps if cumulative else 0.0)
    lower[1 + m] = eps
    square = float(sums.matrix[-1, -1])
    u, _, kkt, condition, _, status = _native.solve_bounded(
        gram, np.ascontiguousarray(sums.matrix[order, -1]), lower, 1 + m, n,
        _native.SLOPES if cumulative else _native.WEIGHTS, target_norm=float(np.sqrt(square)),
    )  # fmt: skip
    if status:
        raise IdentificationError(
            f"the sums do not tell the {n} plays and {m} extra columns apart (condition {condition:.2g}). Accumulate "
            f"fewer thresholds or lower powers, or samples in which they differ.",
            operators=n,
        )
    weights = np.diff(u[1 + m :], prepend=0.0) if cumulative else u[1 + m :]
    v = np.concatenate([u[: 1 + m], np.cumsum(weights)])
    left = square - 2.0 * float(sums.matrix[order, -1] @ v) + float(v @ gram @ v)
    rms = float(np.sqrt(max(left, 0.0) / sums.samples))
    return Weights(float(u[0]), weights, u[1 : 1 + m], rms, kkt, condition)


def accumulate(
    recordings: Recording | Sequence[Recording],
    thresholds: npt.ArrayLike,
    *,
    extra: Callable[[Recording], npt.ArrayLike] | None = None,
    weights: npt.ArrayLike | Sequence[npt.ArrayLike] | None = None,
    center: float | None = None,
    initial_state: str = "zero",
) -> NormalEquations:
    """Sums of [1 | cells | extra columns | y] over recordings, in the units of the log, in one pass.

    With `solve` it fits what no family of `identify` has: a polynomial of the input or creep beside the plays. The
    columns of one recording are made at once; sums of several add up, `accumulate(a, r) + accumulate(b, r)`.

    Parameters
    ----------
    recordings
        One recording or a list of them. The memory starts anew in each, and after each break.
    thresholds
        r, (n,), increasing from 0. [input]
    extra
        Makes the extra columns of a recording, (T, m), for example ``lambda rec: creep(rec, [1.0, 10.0])``.
    weights
        How much each sample counts, as `identify` takes it.
    center
        Subtracted from the input before the plays; by default the middle of its range over all recordings. [input]
    initial_state
        Memory before the first sample, as `identify` takes it, without "auto"; "unknown" is "rising" here.

    Returns
    -------
    sums : NormalEquations
        Additive; `solve` fits them.

    Raises
    ------
    ParameterError
        If thresholds, weights, a start state or the extra columns do not fit.

    Examples
    --------
    >>> import numpy as np, dehyst
    >>> t = np.linspace(0.0, 60.0, 4000)
    >>> x = np.sin(t) * np.linspace(1, 0.2, t.size)
    >>> y = dehyst.PrandtlIshlinskii([0.0, 0.25, 0.5], [1.0, 0.5, 0.25]).simulate(x) + 0.3 * x**3
    >>> rec = dehyst.Recording(input=x, output=y)
    >>> sums = accumulate(rec, [0.0, 0.25, 0.5], extra=lambda rec: rec.input**3, center=0)
    >>> found = solve(sums)
    >>> found.weights.round(9).tolist(), found.coefficients.round(9).tolist()
    ([1.0, 0.5, 0.25], [0.3])
    """
    records = check_recordings(recordings)
    r = parameter_array(thresholds, "thresholds")
    check_settings("pi", r.size, 1.0, r, initial_state)
    if initial_state == "auto":
        raise ParameterError("initial_state = 'auto' needs a comparison; name a start, or use identify.")
    given = counting(records, check_weights(weights, records))
    low, high = min(float(rec.input.min()) for rec in records), max(float(rec.input.max()) for rec in records)
    middle = 0.5 * (low + high) if center is None else parameter_number(center, "center")
    total: NormalEquations | None = None
    for index, record in enumerate(records):
        columns = _extra_columns(record, extra)
        for span in record.pieces:
            x = record.input[span] - middle
            z0 = state_before(initial_state, r, float(x[0]), low - middle, high - middle, -middle)
            gram = Gram(r, z0, columns.shape[0])
            gram.add(x, np.ascontiguousarray(columns[:, span]), None if given is None else given[index][span])
            part = NormalEquations(r, gram.take())
            total = part if total is None else total + part
    if total is None:
        raise AssertionError("no recordings")  # checked
    return total


def _extra_columns(record: Recording, extra: Callable[[Recording], npt.ArrayLike] | None) -> Array:
    """Rows of the extra columns and y, (m + 1, T)."""
    if extra is None:
        return record.output[None, :]
    made = np.asarray(extra(record), dtype=np.float64)
    made = made[:, None] if made.ndim == 1 else made
    if made.ndim != 2 or made.shape[0] != len(record) or not np.all(np.isfinite(made)):
        raise ParameterError(
            f"the extra columns of '{record.name}' have the shape {made.shape} or are not finite; one finite value "
            f"for each of the {len(record)} samples and each column is needed, (T, m)."
        )
    return np.vstack([made.T, record.output])


def polynomial(record: Recording, degree: int) -> Array:
    """Columns x^2 .. x^degree of the input, (T, degree - 1), of x scaled to its range so that they do not grow.

    The offset and the straight line are in the plays already.

    Examples
    --------
    >>> rec = Recording(input=[0.0, 1.0, 2.0, 4.0], output=[0.0, 1.0, 2.0, 3.0])
    >>> polynomial(rec, 3).tolist()
    [[1.0, -1.0], [0.25, -0.125], [0.0, 0.0], [1.0, 1.0]]
    """
    low, high = float(record.input.min()), float(record.input.max())
    scaled = (record.input - 0.5 * (low + high)) / max(0.5 * (high - low), 1e-300)
    return np.column_stack([scaled**power for power in range(2, degree + 1)])


def creep(record: Recording, times: Sequence[float]) -> Array:
    """Creep states of the input, (T, m): first-order lags with the given time constants [s], from the first sample.

    v' = (x - v)/tau, exact for an input that keeps its value from one sample to the next.

    Examples
    --------
    >>> rec = Recording(input=[0.0, 1.0, 1.0, 1.0], output=[0.0, 1.0, 1.0, 1.0], time=[0.0, 1.0, 2.0, 3.0])
    >>> creep(rec, [1.0])[:, 0].round(4).tolist()
    [0.0, 0.0, 0.6321, 0.8647]
    """
    if record.time is None:
        raise ParameterError(f"creep needs the time of each sample, and '{record.name}' has none (--time).")
    columns = []
    for tau in times:
        if not parameter_number(tau, "tau") > 0.0:
            raise ParameterError(f"tau = {tau:g} s must be positive: the time constant of creep.", tau=tau)
        columns.append(_lag(record.time, record.input, float(tau)))
    return np.column_stack(columns)


def _lag(time: Array, x: Array, tau: float) -> Array:
    v = np.empty(x.size)
    v[0] = x[0]
    begin = 0
    while begin < x.size - 1:
        # Within thirty time constants the weights of the past stay within the range of floating point numbers.
        end = max(begin + 2, int(np.searchsorted(time, time[begin] + 30.0 * tau)))
        step = np.diff(time[begin:end]) / tau
        grown = np.exp(np.minimum(np.cumsum(step), 700.0))
        gain = -np.expm1(-step) * x[begin : end - 1]
        v[begin + 1 : end] = (v[begin] + np.cumsum(gain * grown)) / grown
        begin = end - 1
    return v
