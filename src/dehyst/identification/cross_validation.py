"""cross_validate(): many settings on the same held-out blocks, by the error of the model and by that of its inverse."""

from __future__ import annotations

import itertools
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

import dehyst._native as _native
from dehyst.arrays import Array, rank
from dehyst.data.recording import Recording, require_recordings, takes_recordings
from dehyst.data.repeats import counted_once
from dehyst.errors import ExcitationError, ParameterError
from dehyst.identification.data import DataSet, prepare
from dehyst.identification.families import Estimate, build_model
from dehyst.identification.regressors import Bank, make_bank
from dehyst.identification.selection import COMPARED_ROWS, FEWEST_ROWS, REGULARISATIONS, Choice, Folds, threshold_grid
from dehyst.identification.settings import PAPER_EPS, check_recordings, check_settings, check_weights, paper_eps
from dehyst.identification.short_signal import ShortSignal, shorten
from dehyst.identification.split import Split, split_recordings
from dehyst.identification.threads import in_parallel, single_blas
from dehyst.models import HysteresisModel, ModelCard
from dehyst.models.arrays import parameter_number


@dataclass(frozen=True, slots=True)
class Trial:
    """One setting and its errors on held-out blocks.

    Attributes
    ----------
    family, n, power, shear, initial_state
        The setting: model family, operators at r_i = ((i - 1)/n)^power max|x|, k of the sheared input x + k y, memory
        before the first sample.
    smoothing
        Of the output map, the best of those that "auto" tries; None for families without one.
    errors
        RMSE of the output on each held-out block, (5,). [output] With a shear the model sees the output in its input;
        compare such rows by the inverse.
    inverse_errors
        RMS of x - (H^-1[y] - k y) on each held-out block, (5,): how far the input that a compensator asks for is from
        the one that was applied. [input]
    nonzero_weights
        Operators with weight in the fit to all blocks but the last.
    seconds
        Time that this row took.
    inverse_gain
        Largest slope of the inverse in the fit to all blocks but the last, of the sheared loop. [input/output]
    """

    family: str
    n: int
    power: float
    shear: float
    initial_state: str
    smoothing: float | None
    errors: tuple[float, ...]
    inverse_errors: tuple[float, ...]
    nonzero_weights: int
    seconds: float
    inverse_gain: float = float("nan")

    @property
    def error(self) -> float:
        """Geometric mean of the errors over the blocks. [output]"""
        return _mean(self.errors)

    @property
    def inverse_error(self) -> float:
        """Geometric mean of the inverse's errors over the blocks. [input]"""
        return _mean(self.inverse_errors)


@dataclass(frozen=True)
class CrossValidation:
    """Trials in the order of the settings.

    Attributes
    ----------
    trials
        One row for each setting.
    input_unit, output_unit
        Units of the errors.

    Examples
    --------
    >>> import dehyst
    >>> from dehyst.io import example_recording
    >>> table = dehyst.cross_validate(example_recording(), families=("pi", "modified-pi"), n=(50,))
    >>> table.best().family, [round(trial.error, 2) for trial in table.trials]
    ('modified-pi', [1.12, 0.13])
    """

    trials: tuple[Trial, ...]
    input_unit: str = ""
    output_unit: str = ""

    def best(self, by: str = "error") -> Trial:
        """Return the row with the smallest "error", or "inverse_error" (the one to compare shears by)."""
        if by not in ("error", "inverse_error"):
            raise ParameterError(f"by = {by!r} is neither 'error' nor 'inverse_error'.", by=by)
        return min(self.trials, key=lambda trial: rank(float(getattr(trial, by))))

    def __str__(self) -> str:
        """Table, a row a trial."""
        head = ("family", "n", "power", "shear", "start", "smoothing", f"error {self.output_unit}".strip(),
                f"inverse {self.input_unit}".strip(), "weights", "ms")  # fmt: skip
        rows = [
            (
                t.family, str(t.n), f"{t.power:g}", f"{t.shear:g}", t.initial_state,
                "" if t.smoothing is None else f"{t.smoothing:g}", f"{t.error:.4g}", f"{t.inverse_error:.4g}",
                str(t.nonzero_weights), f"{1e3 * t.seconds:.1f}",
            )
            for t in self.trials
        ]  # fmt: skip
        widths = [max(len(row[k]) for row in [head, *rows]) for k in range(len(head))]
        lines = ["  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)) for row in [head, *rows]]
        return "\n".join(line.rstrip() for line in lines)


@takes_recordings
def cross_validate(
    recordings: Recording | Sequence[Recording],
    *,
    families: Sequence[str] = ("pi",),
    n: Sequence[int] = (10, 20, 50, 100),
    powers: Sequence[float] = (1.0,),
    shear: Sequence[float] = (0.0,),
    starts: Sequence[str] = ("zero",),
    eps: float = PAPER_EPS,
    train_fraction: float | None = 1.0,
    weights: npt.ArrayLike | Sequence[npt.ArrayLike] | None = None,
) -> CrossValidation:
    r"""Compare settings by their errors on held-out blocks, all combinations of them.

    The recordings are cut into five consecutive blocks; each setting is fitted five times without one block and scored
    on it, on about 4000 samples that have every play's state exactly. A setting takes milliseconds, whatever the
    length of the log. A shear k identifies on :math:`x' = x + k y`, which turns the loop around the diagonal (the
    paper adds the angle to the pressure); what counts then is the inverse,

    .. math:: x - (H^{-1}[y] - k y)

    in units of the input, which is comparable over k.

    Parameters
    ----------
    recordings
        One recording or a list of them.
    families
        Any of "pi", "pi-cumulative", "modified-pi", "stop".
    n
        Numbers of operators.
    powers
        Exponents p of the grid :math:`r_i = ((i-1)/n)^p \max|x|`.
    shear
        Values of k. [input/output]
    starts
        Memory before the first sample, as `identify` takes it, without "auto".
    eps
        Smallest slope right after a reversal, as `identify` takes it for each family.
    train_fraction
        Share of each recording that takes part.
    weights
        How much each sample counts, as `identify` takes it.

    Returns
    -------
    table : CrossValidation
        A `Trial` for each combination, in the order of the arguments, the last one changing fastest.

    Raises
    ------
    ParameterError
        If a setting lies outside what its formula allows.
    ExcitationError
        If input or output does not move, or too few samples have a known memory.

    Examples
    --------
    >>> import numpy as np, dehyst
    >>> x = np.interp(np.linspace(0, 8, 1601), range(9), [0, 2, -2, 1.6, -1.2, 0.8, -2, 2, 0])
    >>> y = dehyst.PrandtlIshlinskii([0.0, 0.5, 1.0], [1.0, 0.5, 0.25]).simulate(x)
    >>> table = cross_validate(dehyst.Recording(input=x, output=y), n=(2, 4, 8), starts=("zero", "rest"))
    >>> table.best().n, table.best().initial_state
    (4, 'zero')
    """
    records = check_recordings(tuple(map(counted_once, require_recordings(recordings))))
    sample_weights = check_weights(weights, records)
    split = split_recordings(records, train_fraction, sample_weights)
    for name, listed in (("families", families), ("n", n), ("powers", powers), ("shear", shear), ("starts", starts)):
        if isinstance(listed, str) or np.ndim(listed) != 1 or not len(listed):
            raise ParameterError(f"{name} = {listed!r} must be a list of at least one setting: {name}=[{listed!r}].")
    for family, count, start in itertools.product(families, n, starts):
        if family == "auto" or start == "auto" or isinstance(count, str):
            raise ParameterError("cross_validate compares what is listed: name families, numbers and starts, not auto.")
        check_settings(family, count, eps, None, start)
    for power in powers:
        if not 0.1 <= parameter_number(power, "power") <= 10.0:
            raise ParameterError(f"power = {power:g} must lie between 0.1 and 10: the exponent of the threshold grid.")
    with single_blas():
        trials = [
            trial
            for k in shear
            for trial in _of_shear(
                records, parameter_number(k, "shear"), list(families), list(n), list(powers), list(starts),
                float(eps), split, sample_weights,
            )
        ]  # fmt: skip
    order = {(f, c, float(p), float(k), s): i for i, (f, c, p, k, s) in
             enumerate(itertools.product(families, n, powers, shear, starts))}  # fmt: skip
    trials.sort(key=lambda t: order[t.family, t.n, t.power, t.shear, t.initial_state])
    return CrossValidation(tuple(trials), records[0].input_unit, records[0].output_unit)


def _mean(errors: tuple[float, ...]) -> float:
    return float(np.exp(np.mean(np.log(np.maximum(errors, 1e-300)))))


@dataclass(frozen=True)
class _Sheared:
    """Data with one shear, shortened for the model and for its inverse."""

    data: DataSet
    shear: float
    short: ShortSignal
    outputs: tuple[Array, ...]  # extremes of each piece's output, raw, with the rows among them
    places: tuple[npt.NDArray[np.int64], ...]
    applied: Array  # input at the rows, raw, before the shear
    reached: Array  # output at the rows, raw


def _of_shear(
    records: tuple[Recording, ...],
    k: float,
    families: list[str],
    n: list[int],
    powers: list[float],
    starts: list[str],
    eps: float,
    split: Split,
    weights: tuple[Array, ...] | None,
) -> list[Trial]:
    turned = tuple(replace(rec, input=rec.input + k * rec.output) for rec in records) if k else records
    data = prepare(turned, split, weights)
    eps_of = {f: paper_eps(eps, turned[0], data) if f == "pi" else eps for f in families}
    views = {unknown: _view(turned, data, k, "unknown" if unknown else "zero") for unknown in
             {start == "unknown" for start in starts}}  # fmt: skip

    def rows(setting: tuple[str, int, float]) -> list[Trial]:
        start, count, power = setting
        view = views[start == "unknown"]
        begin = time.perf_counter()
        bank = make_bank(data, threshold_grid(data, count, Choice("pi", start, None, power), None), start)
        folds = Folds(view.short, bank, ramps="modified-pi" in families)
        spent = (time.perf_counter() - begin) / len(families)
        return [_trial(view, bank, folds, family, count, power, start, eps_of[family], spent) for family in families]

    return [trial for part in in_parallel(rows, itertools.product(starts, n, powers)) for trial in part]


def _view(records: tuple[Recording, ...], data: DataSet, k: float, start: str) -> _Sheared:
    short = shorten(data, start, COMPARED_ROWS)
    if short.rows < FEWEST_ROWS:
        raise ExcitationError(
            f"only {short.rows} samples take part, but cross-validation cuts them into five blocks and needs "
            f"{FEWEST_ROWS}. Log more, take a larger part (train_fraction), or assume a start whose memory is known.",
            samples=short.rows,
        )
    outputs, places, applied, reached = [], [], [], []
    for piece, part in zip(data.pieces, short.pieces, strict=True):
        record = records[piece.recording]
        raw = record.output[piece.start : piece.start + piece.x.size]
        kept, place = _native.essential(np.ascontiguousarray(raw), part.rows)
        outputs.append(raw[kept])
        places.append(place)
        reached.append(raw[part.rows])
        applied.append(record.input[piece.start + part.rows] - k * reached[-1])
    return _Sheared(data, k, short, tuple(outputs), tuple(places), np.concatenate(applied), np.concatenate(reached))


def _trial(
    view: _Sheared, bank: Bank, folds: Folds, family: str, n: int, power: float, start: str, eps: float, spent: float
) -> Trial:
    begin = time.perf_counter()
    settings = REGULARISATIONS if family == "modified-pi" else (None,)
    choices = [Choice(family, start, regularisation, power) for regularisation in settings]
    found = [folds.estimates(choice, eps) for choice in choices]
    errors = [np.array([error for _, _, error in fold]) for fold in found]
    scores = [rank(_mean(tuple(error))) for error in errors]
    best = scores.index(min(scores))
    models = [_model(view, bank, folds, estimate) for estimate, _, _ in found[best]]
    inverse = [
        _inverse_error(view, bank, model, estimate, block)
        for model, (estimate, block, _) in zip(models, found[best], strict=True)
    ]
    scale = view.data.amplitude
    regularisation = choices[best].regularisation
    return Trial(
        family, n, float(power), view.shear, start, None if regularisation is None else regularisation.smoothing,
        tuple((scale * errors[best]).tolist()), tuple(inverse),
        int(np.count_nonzero(found[best][-1][0].weights)), spent + time.perf_counter() - begin, models[-1].inverse_gain,
    )  # fmt: skip


def _model(view: _Sheared, bank: Bank, folds: Folds, estimate: Estimate) -> HysteresisModel:
    return build_model(estimate, view.data, bank, folds.knots if estimate.slopes is not None else None, ModelCard())


def _inverse_error(view: _Sheared, bank: Bank, model: HysteresisModel, estimate: Estimate, block: slice) -> float:
    """RMS of x - (H^-1[y] - k y) on one block, in units of the input."""
    asked = np.concatenate(list(_asked(view, bank, model, estimate)))[block]
    miss = view.applied[block] - (asked - view.shear * view.reached[block])
    miss, weight = view.short.levelled(miss, block), view.short.weight
    return float(np.sqrt(np.average(miss**2, weights=None if weight is None else weight[block])))


def _asked(view: _Sheared, bank: Bank, model: HysteresisModel, estimate: Estimate) -> Iterator[Array]:
    """Input that the inverse asks for at the rows of each piece."""
    kept = estimate.weights != 0.0
    kept[0] = True
    for y, place, state in zip(view.outputs, view.places, bank.states, strict=True):
        if place.size:
            started = model.with_state(state[kept] * view.data.half_range)
            yield started.inverse().simulate(y)[place]
