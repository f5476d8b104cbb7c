"""Fits every family to one log and scores all of them on the same held-out samples."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from dehyst.arrays import rank
from dehyst.data import Plotted, Recording, counted_once, require_recordings
from dehyst.errors import DehystError, ParameterError
from dehyst.families import ROW_NAMES, ROWS, title_of
from dehyst.families import kit as families_kit
from dehyst.identification._auto import best_fit
from dehyst.identification._candidates import all_names, candidate_of
from dehyst.identification._data import DataSet
from dehyst.identification._fit import Fit, Score, codes_of
from dehyst.identification._policy import POLICY
from dehyst.identification._prepared import Prepared, prepared
from dehyst.identification._redrawing import interval, part_squares, within_doubt
from dehyst.identification._scores import Part, deviation_of, score, scored_parts
from dehyst.identification._settings import check_recordings
from dehyst.identification._threads import single_blas

LEADING = ("stop",)  # families of `identify` whose output leads
LAGGING = frozenset(row.name for row in ROWS if row.lags)
FEW_SAMPLES = 1000  # of a log
NOT_CLOSE = "no choice of its parameters that was found comes close to these loops"


@dataclass(frozen=True)
class ComparedFamily:
    """One family of a comparison: its fit and errors, or why there is none.

    Attributes
    ----------
    family, title
        Its name, and the name written in tables.
    fit
        What was identified; None if nothing could be.
    train, test
        Scores on the fitted and the held-out samples of the comparison, the same for all families; None without a fit,
        and test where nothing was held out.
    seconds
        What fit and judgement took, processor time of its thread. [s]
    reason
        Why the family cannot fit this log, or fits it badly, in one sentence; empty if nothing stands against it.
    same_as
        Family whose model answers the same to the last bit on this log, of a row further up; "" if there is none.
    tied
        Whether the held-out error is within doubt of the smallest one: on another log the order may turn.
    interval_percent
        Least and largest error of redraws: ten parts of the scored samples drawn anew with repetition, nine tenths of
        the results. None without a model. [% of the output's range]
    """

    family: str
    title: str
    fit: Fit | None = None
    train: Score | None = None
    test: Score | None = None
    seconds: float = 0.0
    reason: str = ""
    same_as: str = ""
    tied: bool = False
    interval_percent: tuple[float, float] | None = None

    @property
    def model(self) -> Any:
        """What was identified; None if nothing could be."""
        if self.fit is None:
            return None
        return self.fit.model

    @property
    def error_percent(self) -> float:
        """RMS error that counts, percent of the output's range; infinite without a model."""
        score = self.test or self.train
        if score is None:
            return float("inf")
        return score.rmse_percent

    @property
    def no_inverse(self) -> str:
        """Why the model has no inverse; "" if it has one, or there is no model."""
        if self.fit is None:
            return ""
        return str(self.fit.model.no_inverse)

    @property
    def invertible(self) -> bool:
        """Whether there is a model and it has an inverse."""
        return self.fit is not None and not self.no_inverse

    @property
    def inverse_percent(self) -> float | None:
        """RMS of what the inverse asks for less the applied input, percent of range; None without an inverse."""
        if self.fit is None or not self.invertible:
            return None
        return self.fit.certificate.inverse_miss_percent

    @property
    def exportable(self) -> bool:
        """Whether there is a model and a target can run it or its inverse; else it runs in Python only."""
        return self.fit is not None and not self.fit.model.no_export

    @property
    def parameters(self) -> int:
        """Number of identified values; weights of 0 do not count."""
        if self.fit is None:
            return 0
        return int(self.fit.model.free_parameters)

    @property
    def start(self) -> str:
        """Memory before the first sample that was assumed."""
        if self.fit is None:
            return ""
        return self.fit.certificate.initial_state

    @property
    def seed(self) -> int | None:
        """Of everything random; None for convex fits, which have nothing random."""
        if self.fit is None:
            return None
        return self.fit.settings.get("seed")

    def as_dict(self) -> dict[str, Any]:
        """Return the row as printed by ``dehyst compare --json``."""
        return {
            "title": self.title,
            "test": _score_dict(self.test),
            "train": _score_dict(self.train),
            "seconds": self.seconds,
            "parameters": self.parameters,
            "invertible": self.invertible,
            "inverse_percent": self.inverse_percent,
            "no_inverse": self.no_inverse,
            "exportable": self.exportable,
            "start": self.start,
            "seed": self.seed,
            "tied": self.tied,
            "same_as": self.same_as,
            "interval_percent": self.interval_percent,
            "reason": self.reason,
        }


@dataclass(frozen=True)
class Comparison(Plotted):
    """Families on a log, the smallest held-out error first; those that cannot fit it last, with the reason.

    Attributes
    ----------
    entries
        One for each family.
    recordings
        The data.
    auto
        What `dehyst.identify` chooses by itself, on the same samples; its family's row is this fit.
    auto_entry
        Its row.
    masks
        Held-out samples of each recording, (T,); all fitted ones where nothing was held out.
    seed
        Of all searches.

    Examples
    --------
    >>> import numpy as np, dehyst
    >>> x = 2 * np.sin(np.linspace(0, 40, 800)) * np.linspace(1, 0.3, 800)
    >>> y = dehyst.PrandtlIshlinskii([0.0, 0.6], [1.0, 0.5]).simulate(x)
    >>> comparison = dehyst.compare(dehyst.Recording(input=x, output=y), ["pi", "static"])
    >>> comparison.chosen.family, comparison["static"].error_percent > comparison["pi"].error_percent
    ('pi', True)
    """

    entries: tuple[ComparedFamily, ...]
    recordings: tuple[Recording, ...]
    auto: Fit
    auto_entry: ComparedFamily
    masks: tuple[npt.NDArray[np.bool_], ...]
    seed: int

    @property
    def chosen(self) -> ComparedFamily:
        """The family with the smallest held-out error."""
        return self.entries[0]

    @property
    def rows(self) -> tuple[ComparedFamily, ...]:
        """The entries, each model once."""
        return tuple(entry for entry in self.entries if not entry.same_as)

    @property
    def front(self) -> tuple[ComparedFamily, ...]:
        """Rows that no other one of as few parameters betters, the smallest first.

        Of those that can be exported and err less than the best curve without hysteresis.
        """
        curve = (self.auto.static_test or self.auto.static_train).rmse_percent
        front: list[ComparedFamily] = []
        least = rank(POLICY.static_as_good * curve)
        # Rows stand in the order of their errors, and the sort is stable.
        for entry in sorted(self.rows, key=lambda entry: entry.parameters):
            if entry.exportable and rank(entry.error_percent) < least:
                front.append(entry)
                least = rank(entry.error_percent)
        return tuple(front)

    @property
    def verdict(self) -> str:
        """The result in one sentence."""
        best, auto = self.chosen, self.auto_entry
        if best.model is None:
            return "no family could be identified from this log."
        best_percent, auto_percent = f"{best.error_percent:.3g}", f"{auto.error_percent:.3g}"
        scored_on = self._scored_on
        text = f"{best.family} has the smallest error, {best_percent} % of range rms {scored_on}"
        if best.family == auto.family:
            text += "; it is what identify chooses, too"
        elif rank(auto.error_percent) < rank(best.error_percent):  # it was left out here
            text += f" among those compared; {auto.family}, which identify chooses, has {auto_percent} %"
        else:
            text += f", against {auto_percent} % of {auto.family}, which identify chooses"
        ties = [entry.family for entry in self.rows[1:] if entry.tied]
        if ties:
            text += f"; within doubt of it: {', '.join(ties)}"
        text += f"; {_inverse(best)}"
        # A best family without an inverse, or without a target, is of no use to most: name the next one that has it.
        for entry in self.entries:
            if entry.invertible and not best.invertible:
                text += f". The best with an inverse is {entry.family}, {entry.error_percent:.3g} %"
                break
        if not best.exportable:
            text += f". {best.family} runs in Python only"
            for entry in self.entries:
                if entry.exportable:
                    text += f": of those that can be exported {entry.family} errs least, {entry.error_percent:.3g} %"
                    break
        return f"{text}."

    @property
    def _scored_on(self) -> str:
        """The samples on which the errors were counted, in words."""
        if "small-test" in codes_of(self.auto.warnings):
            return "on held-out samples too few to tell models apart"
        if self.chosen.test is None:
            return "on the fitted samples (none held out)"
        return "on held-out loops"

    @property
    def notes(self) -> list[tuple[str, str]]:
        """What stands against families, and why some have no inverse: names, and one sentence for all of them."""
        remarks = []
        for entry in self.entries:
            if entry.reason:
                remarks.append((entry.reason, entry.family))
        for entry in self.entries:
            if entry.no_inverse:
                remarks.append((f"no inverse: {entry.no_inverse}", entry.family))
        for entry in self.entries:
            if entry.same_as:
                remarks.append((f"the same model here as {entry.same_as}", entry.family))
        names_of: dict[str, list[str]] = {}
        for words, name in remarks:
            names_of.setdefault(words, []).append(name)
        return [(", ".join(names), words) for words, names in names_of.items()]

    def __getitem__(self, name: str) -> ComparedFamily:
        """Row of a family."""
        for entry in self.entries:
            if entry.family == name:
                return entry
        names = ", ".join(entry.family for entry in self.entries)
        raise ParameterError(f"'{name!s:.40}' is not among {names}.", name=name)

    def as_dict(self) -> dict[str, Any]:
        """Return the comparison as printed by ``dehyst compare --json``."""
        return {
            "families": {entry.family: entry.as_dict() for entry in self.entries},
            "chosen": self.chosen.family,
            "front": [entry.family for entry in self.front],
            "verdict": self.verdict,
            "auto": {"family": self.auto.family, "test": _score_dict(self.auto_entry.test)},
            "orientation": self.auto.facts.orientation,
            "rate_dependence_percent": self.auto.facts.rate_dependence_percent,
            "evidence": [term.as_dict() for term in self.auto.facts.evidence],
            "seed": self.seed,
            "warnings": [finding.as_dict() for finding in self.auto.warnings],
        }


def _inverse(best: ComparedFamily) -> str:
    if not best.invertible:
        return f"{best.family} has no inverse: {best.no_inverse.rstrip('.')}"
    return f"the inverse of {best.family} gives the applied input back to {best.inverse_percent:.2f} % of its range"


def _score_dict(score: Score | None) -> dict[str, float] | None:
    if score is None:
        return None
    return score.as_dict()


def compare(
    recordings: Recording | Sequence[Recording],
    families: Sequence[str] | None = None,
    *,
    train_fraction: float | None = None,
    seed: int = 0,
    progress: Callable[[str, int, int], object] | None = None,
) -> Comparison:
    """Identify every hysteresis family from the same samples and score it on the same held-out ones.

    Parameters
    ----------
    recordings
        One recording or a list of them; all are fitted together.
    families
        Names of `dehyst.identification.all_names()`; None for all but the choice among rows, which is one of them, and
        but for the butterfly where the loop is none.
    train_fraction
        Share of each recording that is fitted; the rest is the test, which no fit sees. The order of the rows is by
        the test: which family is best for a plant is itself a finding from this log, and another log confirms it.
    seed
        Of the searches of families whose fit is not convex.
    progress
        Called with the family that begins, its number and the number of all.

    Returns
    -------
    comparison : Comparison
        Rows with errors, parameters, time and whether an inverse exists.

    Raises
    ------
    ParameterError
        If a name is not that of a family, or the seed no whole number from 0 on.
    ExcitationError
        If input or output does not move, so that nothing can be identified.

    Examples
    --------
    >>> import numpy as np, dehyst
    >>> x = 2 * np.sin(np.linspace(0, 40, 800)) * np.linspace(1, 0.3, 800)
    >>> y = dehyst.PrandtlIshlinskii([0.0, 0.6], [1.0, 0.5]).simulate(x)
    >>> comparison = compare(dehyst.Recording(input=x, output=y), ["static", "pi"])
    >>> [entry.family for entry in comparison.entries], comparison["pi"].invertible
    (['pi', 'static'], True)
    """
    if isinstance(seed, bool) or not isinstance(seed, int | np.integer) or seed < 0:
        raise ParameterError(f"seed = {seed!r:.40} must be a whole number from 0 on.", seed=seed)
    records = check_recordings(tuple(map(counted_once, require_recordings(recordings))))
    names = _names_to_fit(families)
    log = prepared(records, train_fraction)
    if families is None and log.seen.butterfly is None:
        # Of any other loop it could only say that it is none.
        names = tuple(name for name in names if name != "butterfly")
    begun = time.thread_time()
    auto = best_fit(log)
    spent = time.thread_time() - begun
    with single_blas():
        compared = _Compared(records, log.data, auto.certificate.initial_state)
        baseline = _scored(auto.family, auto, spent, compared)
        entries = []
        for number, name in enumerate(names):
            if progress is not None:
                progress(name, number, len(names))
            if name == auto.family:
                entries.append(baseline)
            elif name == families_kit.BEST and auto.family in ROW_NAMES:  # whose best one it is
                entries.append(_scored(name, auto, spent, compared))
            else:
                entries.append(_entry(name, log, seed, compared))
    curve = (auto.static_test or auto.static_train).rmse_percent
    entries = [_with_reason(entry, auto, curve) for entry in entries]
    masks = compared.judged.masks(records)
    ranked = sorted(
        entries, key=lambda entry: (rank(entry.error_percent), entry.family != auto.family)
    )
    with_doubts = _with_doubts(_named_once(ranked), records, masks, log.data.output_range)
    return Comparison(with_doubts, records, auto, baseline, masks, seed)


def _names_to_fit(families: Sequence[str] | None) -> tuple[str, ...]:
    """The families asked for, each once; all of them if none was named."""
    known_names = all_names()
    if families is not None:
        names = tuple(dict.fromkeys(families))
    else:
        # The best row stands among the rows.
        names = tuple(name for name in known_names if name != families_kit.BEST)
    unknown = [name for name in names if name not in known_names]
    if unknown or not names:
        first = [*unknown, ""][0]
        raise ParameterError(
            f"no family '{first}'. There are: {', '.join(known_names)}.", names=unknown
        )
    return names


class _Compared:
    """Samples on which all families are scored, those that `identify` fits and holds out."""

    def __init__(self, records: tuple[Recording, ...], data: DataSet, initial_state: str) -> None:
        self._records, self._range = records, data.output_range
        self._parts: list[tuple[Part, float]] = []
        for part in scored_parts(records, data, initial_state):
            self._parts.append((part, deviation_of(records, part)))

    @property
    def judged(self) -> Part:
        """The held-out samples; the fitted ones where nothing was held out."""
        fitted, held_out = [part for part, _ in self._parts]
        return held_out or fitted

    def scores(self, fit: Fit) -> list[Score | None]:
        """Score of a fit on the fitted and on the held-out samples; None where there are none."""
        scores = []
        for part, deviation in self._parts:
            scores.append(score(self._records, fit.predictions, part, self._range, deviation))
        return scores


def _entry(name: str, log: Prepared, seed: int, compared: _Compared) -> ComparedFamily:
    begun = time.thread_time()
    try:
        fit = log.fit(candidate_of(name, seed))
    except DehystError as fault:
        return ComparedFamily(name, title_of(name), reason=" ".join(str(fault).split()))
    return _scored(name, fit, time.thread_time() - begun, compared)


def _scored(name: str, fit: Fit, seconds: float, compared: _Compared) -> ComparedFamily:
    """The row of a fit, which says for which other family it stands."""
    title = title_of(name)
    if fit.family != name:
        title = f"{title}: {fit.family}"
    train, test = compared.scores(fit)
    return ComparedFamily(name, title, fit, train, test, seconds)


def _with_reason(entry: ComparedFamily, auto: Fit, curve: float) -> ComparedFamily:
    """Say why a family that errs by a tenth of the range, or as much as a mere curve, does so."""
    small = min(POLICY.poor_percent, POLICY.static_as_good * curve)
    if entry.model is None or entry.reason or entry.error_percent < small:
        return entry
    reasons = []
    leads = entry.family in LEADING
    lags = entry.family in families_kit.TITLES or entry.family in LAGGING
    orientation = auto.facts.orientation
    if entry.family == "static":
        reasons.append("it remembers nothing: both branches of the loop are one curve")
    elif lags and leads and orientation == "counter-clockwise":
        reasons.append("the loop is counter-clockwise: its output lags, and these operators lead")
    elif lags and not leads and orientation == "clockwise":
        reasons.append("the loop is clockwise: its output leads, and these operators lag")
    follows = "rate-dependent" in codes_of(auto.warnings)
    if follows and not entry.model.rate_dependent:
        reasons.append(f"{' and '.join(auto.facts.depends)}, which the model does not know")
    return replace(entry, reason=f"{'; '.join(reasons) or NOT_CLOSE}.")


def _named_once(ranked: list[ComparedFamily]) -> list[ComparedFamily]:
    """Say of a row which one above it is the same model: terms that a log does not need are left out of both."""
    marked: list[ComparedFamily] = []
    for entry in ranked:
        twins = [above.family for above in marked if not above.same_as and _twins(above, entry)]
        marked.append(replace(entry, same_as=twins[0]) if twins else entry)
    return marked


def _twins(above: ComparedFamily, below: ComparedFamily) -> bool:
    """Whether two rows answer alike, to far more digits than a table shows."""
    if above.fit is None or below.fit is None:
        return False
    for a, b in zip(above.fit.predictions, below.fit.predictions, strict=True):
        if a.shape != b.shape:
            return False
        alike = POLICY.same_answer * float(np.ptp(a))
        # Almost all that differ do so at one of a few samples already.
        for every in (max(1, a.size // FEW_SAMPLES), 1):
            if not float(np.max(np.abs(a[::every] - b[::every]))) <= alike:
                return False
    return True


def _with_doubts(
    ranked: list[ComparedFamily],
    records: tuple[Recording, ...],
    masks: tuple[npt.NDArray[np.bool_], ...],
    output_range: float,
) -> tuple[ComparedFamily, ...]:
    """Give each row the interval of its error, and mark those whose error is within doubt of the best one's."""
    if not ranked or ranked[0].fit is None:
        return tuple(ranked)
    best = part_squares(ranked[0].fit.predictions, records, masks)
    marked = []
    for entry in ranked:
        if entry.fit is None:
            marked.append(entry)
            continue
        squares = part_squares(entry.fit.predictions, records, masks)
        low, high = interval(squares)
        percent = (100.0 * low / output_range, 100.0 * high / output_range)
        marked.append(replace(entry, tied=within_doubt(squares, best), interval_percent=percent))
    return tuple(marked)
