"""Compares many settings on the same held-out samples, by the error of the model and by that of its inverse."""

from __future__ import annotations

import itertools
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from dehyst.arrays import rank
from dehyst.data import Recording, counted_once, require_recordings
from dehyst.errors import ParameterError
from dehyst.identification._candidate import Candidate
from dehyst.identification._candidates import candidate_of
from dehyst.identification._candidates.plays import PlaysFamily, plays_of
from dehyst.identification._families import FAMILIES
from dehyst.identification._prepared import prepared
from dehyst.identification._settings import PAPER_EPS, check_recordings, check_weights
from dehyst.identification._threads import in_parallel, single_blas
from dehyst.models import kit as models_kit


@dataclass(frozen=True, slots=True)
class Trial:
    """One setting and its errors on held-out fifths of the way.

    Attributes
    ----------
    family, n, power, shear, initial_state
        The setting: model family, operators at r_i = ((i - 1)/n)^power max|x|, k of the sheared input x + k y, memory
        before the first sample. Families that are no plays have n = 0, no power, and choose the start by themselves.
    smoothing
        Of the output map, the best of those that "auto" tries; None for families without one.
    errors
        RMSE of the output on each held-out fifth, (5,). [output] With a shear the model sees the output in its input;
        compare such rows by the inverse. Not a number for "direct-inverse", whose target is the input.
    inverse_errors
        RMS of x - (H^-1[y] - k y) on each held-out fifth, (5,): how far the input that a compensator asks for is from
        the one that was applied. [input]
    nonzero_weights
        Operators with weight in the fit to all but the last fifth.
    seconds
        Time that this row took.
    inverse_gain
        Largest slope of the inverse in the fit to all but the last fifth, of the sheared loop. [input/output]
    """

    family: str
    n: int
    power: float | None
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
        """Mean of `errors`. [output]"""
        return float(np.mean(self.errors))

    @property
    def inverse_error(self) -> float:
        """Mean of `inverse_errors`. [input]"""
        return float(np.mean(self.inverse_errors))


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
    ('modified-pi', [1.11, 0.14])
    """

    trials: tuple[Trial, ...]
    input_unit: str = ""
    output_unit: str = ""

    def best(self, by: str = "error") -> Trial:
        """Return the row with the smallest "error", or "inverse_error" (the one to compare shears by)."""
        if by not in ("error", "inverse_error"):
            raise ParameterError(f"by = {by!r} is neither 'error' nor 'inverse_error'.", by=by)
        errors = np.array([getattr(trial, by) for trial in self.trials], dtype=np.float64)
        if not np.isfinite(errors).any():
            raise ParameterError(
                f"no row has a finite {by}: none of the families answers it. Compare by the other.",
                by=by,
            )
        return self.trials[int(np.nanargmin(list(map(rank, errors.tolist()))))]

    def __str__(self) -> str:
        """Table, a row a trial."""
        head = ("family", "n", "power", "shear", "start", "smoothing", f"error {self.output_unit}".strip(),
                f"inverse {self.input_unit}".strip(), "weights", "ms")  # fmt: skip
        rows = [head]
        for t in self.trials:
            power = smoothing = ""
            if t.power is not None:
                power = f"{t.power:g}"
            if t.smoothing is not None:
                smoothing = f"{t.smoothing:g}"
            rows.append((
                t.family, str(t.n or ""), power, f"{t.shear:g}", t.initial_state, smoothing, f"{t.error:.4g}",
                f"{t.inverse_error:.4g}", str(t.nonzero_weights), f"{1e3 * t.seconds:.1f}",
            ))  # fmt: skip
        widths = []
        for column in zip(*rows, strict=True):
            widths.append(max(map(len, column)))
        lines = []
        for row in rows:
            lines.append("  ".join(map(str.ljust, row, widths)).rstrip())
        return "\n".join(lines)


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
    r"""Compare settings by their errors on held-out samples, all combinations of them.

    A fifth of the way of the input is left out in turn, in four parts that are spread over the recordings; each
    setting is fitted five times to the rest, and scored on what is left out. `identify` with "auto" leaves out fifths
    in one piece, too. Plays see about 4000 samples that have every play's state exactly, so that a setting takes
    milliseconds, whatever the length of the log; other families are fitted to all samples that are not left out.
    "direct-inverse" is scored on the consecutive blocks that its terms are chosen on. A shear k identifies on
    :math:`x' = x + k y`, which turns the loop around the diagonal (the paper adds the angle to the pressure); what
    counts then is the inverse,

    .. math:: x - (H^{-1}[y] - k y)

    in units of the input, which is comparable over k.

    Parameters
    ----------
    recordings
        One recording or a list of them.
    families
        Any of `dehyst.identification.all_names()`. n, powers and starts are those of plays ("pi", "pi-cumulative",
        "modified-pi", "stop"); other families have one row for each shear.
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
    for name, listed in (
        ("families", families),
        ("n", n),
        ("powers", powers),
        ("shear", shear),
        ("starts", starts),
    ):
        if isinstance(listed, str) or np.ndim(listed) != 1 or not len(listed):
            raise ParameterError(
                f"{name} = {listed!r} must be a list of at least one setting: {name}=[{listed!r}]."
            )
    logs = {}
    for k in shear:
        scale = models_kit.parameter_number(k, "shear")
        turned = []
        for record in records:
            if scale:
                record = replace(record, input=record.input + scale * record.output)
            turned.append(record)
        logs[scale] = prepared(tuple(turned), train_fraction, sample_weights)
    settings: list[tuple[Candidate, float]] = []
    for family in families:
        if family not in FAMILIES and family != "auto":
            candidate = candidate_of(family)
            for k in logs:
                settings.append((candidate, k))
            continue
        for count, power, k, start in itertools.product(n, powers, logs, starts):
            settings.append((_plays(family, count, power, start, eps), k))

    def trial(setting: tuple[Candidate, float]) -> Trial:
        candidate, k = setting
        begin = time.perf_counter()
        errors = candidate.block_errors(logs[k])
        n, power, start = 0, None, "auto"
        if isinstance(candidate, PlaysFamily) and candidate.family in FAMILIES:
            n, power, start = candidate.operators, candidate.power, candidate.initial_state
        return Trial(
            family=candidate.family,
            n=n,
            power=power,
            shear=k,
            initial_state=start,
            smoothing=errors.smoothing,
            errors=tuple(errors.output.tolist()),
            inverse_errors=tuple(errors.input.tolist()),
            nonzero_weights=errors.nonzero_weights,
            seconds=time.perf_counter() - begin,
            inverse_gain=errors.inverse_gain,
        )

    with single_blas():
        trials = in_parallel(trial, settings)
    return CrossValidation(tuple(trials), records[0].input_unit, records[0].output_unit)


def _plays(family: str, count: int, power: float, start: str, eps: float) -> PlaysFamily:
    """One setting of plays."""
    if family == "auto" or start == "auto" or isinstance(count, str):
        raise ParameterError(
            "cross_validate compares what is listed: name families, numbers and starts, not auto."
        )
    if not 0.1 <= models_kit.parameter_number(power, "power") <= 10.0:
        raise ParameterError(
            f"power = {power:g} must lie between 0.1 and 10: the exponent of the threshold grid."
        )
    return replace(plays_of(family, count, eps, None, start), power=float(power))
