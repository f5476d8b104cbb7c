"""compare(): fits every family to one log and scores all on the same held-out samples."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array, rank
from dehyst.data.plotted import Plotted
from dehyst.data.recording import Recording, require_recordings, takes_recordings
from dehyst.data.repeats import counted_once
from dehyst.errors import DehystError, ParameterError
from dehyst.families.best import best_fit
from dehyst.families.fitting import FamilyFit, Judge, fit_one, training_of_log
from dehyst.families.registry import BEST, TITLES, names, title_of
from dehyst.families.registry import ROWS as ROW_NAMES
from dehyst.families.table import ROWS
from dehyst.families.training import Training
from dehyst.identification import Fit
from dehyst.identification.direct import direct_fit
from dehyst.identification.families import STATIC
from dehyst.identification.procedure import DIRECT, Prepared, prepared
from dehyst.identification.scores import parts
from dehyst.identification.settings import check_recordings
from dehyst.identification.threads import single_blas

BLOCKS = 10  # of the held-out part, for the noise of a difference
SIGMAS = 2.0
SAME = 1e-9  # of the range: two models that differ by less are one
POOR = 10.0  # held-out error from which a reason is looked for, percent of range
AS_A_CURVE = 0.95  # or this many times that of the best curve without memory
LEADING = ("stop",)  # families of `identify` whose output leads
LAGGING = frozenset(row.name for row in ROWS if row.lags)
NOT_FOUND = "no choice of its parameters that was found comes close to these loops"


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
    >>> found = dehyst.compare(dehyst.Recording(input=x, output=y), ["pi", "static"])
    >>> found.chosen.family, found["static"].error_percent > found["pi"].error_percent
    ('pi', True)
    """

    entries: tuple[FamilyFit, ...]
    recordings: tuple[Recording, ...]
    auto: Fit
    auto_entry: FamilyFit
    masks: tuple[npt.NDArray[np.bool_], ...]
    seed: int

    @property
    def chosen(self) -> FamilyFit:
        """The family with the smallest held-out error."""
        return self.entries[0]

    @property
    def rows(self) -> tuple[FamilyFit, ...]:
        """The entries, each model once."""
        return tuple(entry for entry in self.entries if not entry.same_as)

    @property
    def verdict(self) -> str:
        """The result in one sentence."""
        best, auto = self.chosen, self.auto_entry
        if best.model is None:
            return "no family could be identified from this log."
        where = "on held-out loops" if best.test is not None else "on the fitted samples (none held out)"
        if any(finding.code == "small-test" for finding in self.auto.warnings):
            where = "on held-out samples too few to tell models apart"
        own, its = (f"{each.error_percent:.2f}" for each in (best, auto))
        if own == its:  # the table below tells them apart
            own, its = (f"{each.error_percent:.3g}" for each in (best, auto))
        said = f"{best.family} has the smallest error, {own} % of range rms {where}"
        if best.family == auto.family:
            said += "; it is what identify chooses, too"
        elif rank(auto.error_percent) < rank(best.error_percent):  # it was left out here
            said += f" among those compared; {auto.family}, which identify chooses, has {its} %"
        else:
            said += f", against {its} % of {auto.family}, which identify chooses"
        ties = [entry.family for entry in self.rows[1:] if entry.tied]
        said += f"; within noise of it: {', '.join(ties)}" if ties else ""
        said += f"; {_inverse(best)}"
        able = next((entry for entry in self.entries if entry.model is not None and entry.invertible), None)
        if not best.invertible and able is not None:
            said += f". The best with an inverse is {able.family}, {able.error_percent:.2f} %"
        runs = next((entry for entry in self.entries if entry.exportable), None)
        if not best.exportable:
            said += f". {best.family} runs in Python only"
            said += (
                f": of those that can be exported {runs.family} errs least, {runs.error_percent:.2f} %" if runs else ""
            )
        return f"{said}."

    @property
    def notes(self) -> list[tuple[str, str]]:
        """What stands against families, and why some have no inverse: names, and one sentence for all of them."""
        said = [(entry.family, entry.reason) for entry in self.entries if entry.reason]
        said += [(entry.family, f"no inverse: {entry.no_inverse}") for entry in self.entries if entry.no_inverse]
        said += [(each.family, f"the same model here as {each.same_as}") for each in self.entries if each.same_as]
        named: dict[str, list[str]] = {}
        for name, words in said:
            named.setdefault(words, []).append(name)
        return [(", ".join(names), words) for words, names in named.items()]

    def __getitem__(self, name: str) -> FamilyFit:
        """Row of a family."""
        for entry in self.entries:
            if entry.family == name:
                return entry
        raise ParameterError(f"'{name!s:.40}' is not among {', '.join(e.family for e in self.entries)}.", name=name)

    def as_dict(self) -> dict[str, Any]:
        """Return the comparison as printed by ``dehyst compare --json``."""
        return {
            "families": {entry.family: entry.as_dict() for entry in self.entries},
            "chosen": self.chosen.family,
            "verdict": self.verdict,
            "auto": {"family": self.auto.family, "test": _plain(self.auto_entry)},
            "orientation": self.auto.facts.orientation,
            "rate_dependence_percent": self.auto.facts.rate_dependence_percent,
            "evidence": [found.as_dict() for found in self.auto.facts.evidence],
            "seed": self.seed,
            "warnings": [finding.as_dict() for finding in self.auto.warnings],
        }


def _inverse(best: FamilyFit) -> str:
    if not best.invertible:
        return f"{best.family} has no inverse: {best.no_inverse.rstrip('.')}"
    return f"the inverse of {best.family} gives the applied input back to {best.inverse_percent:.2f} % of its range"


def _plain(entry: FamilyFit) -> dict[str, float] | None:
    return None if entry.test is None else entry.test.as_dict()


def all_names() -> tuple[str, ...]:
    """Every family that can be compared.

    Examples
    --------
    >>> all_names()[:3]
    ('static', 'pi', 'pi-cumulative')
    """
    return (*TITLES, *names())


@takes_recordings
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
        Names of `dehyst.families.all_names()`; None for all of them but the choice among rows, which is one of them.
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
    >>> found = compare(dehyst.Recording(input=x, output=y), ["static", "pi"])
    >>> [entry.family for entry in found.entries], found["pi"].invertible
    (['pi', 'static'], True)
    """
    if isinstance(seed, bool) or not isinstance(seed, int | np.integer) or seed < 0:
        raise ParameterError(f"seed = {seed!r:.40} must be a whole number from 0 on.", seed=seed)
    records = check_recordings(tuple(map(counted_once, require_recordings(recordings))))
    every = tuple(name for name in all_names() if name != BEST)  # the best row stands among the rows
    wanted = tuple(dict.fromkeys(families)) if families is not None else every
    unknown = [name for name in wanted if name not in all_names()]
    if unknown or not wanted:
        raise ParameterError(
            f"no family '{unknown[0] if unknown else ''}'. There are: {', '.join(all_names())}.", names=unknown
        )
    log = prepared(records, train_fraction)
    training = training_of_log(log, seed)
    begun = time.thread_time()
    auto = best_fit(log, training)
    spent = time.thread_time() - begun
    with single_blas():
        part = parts(records, log.data, auto.certificate.initial_state)
        judge, found = Judge(records, part, log.data.output_range), []
        baseline = judge.identified(auto, spent)
        for number, name in enumerate(wanted):
            if progress is not None:
                progress(name, number, len(wanted))
            if name == auto.family:
                found.append(baseline)
            elif name == BEST and auto.family in ROW_NAMES:  # whose best one it is
                found.append(_as(name, baseline))
            elif name == STATIC:
                found.append(judge.curve_of(auto))
            else:
                found.append(_entry(name, judge, log, training))
    curve = (auto.static_test or auto.static_train).rmse_percent
    found = [_with_reason(entry, auto, curve) for entry in found]
    seen = part[1] if part[1] else part[0]
    masks = tuple(seen.mask(k, len(record)) for k, record in enumerate(records))
    ranked = sorted(found, key=lambda entry: (rank(entry.error_percent), entry.family != auto.family))
    return Comparison(_with_ties(_named_once(ranked), records, masks), records, auto, baseline, masks, seed)


def _entry(name: str, judge: Judge, log: Prepared, training: Training) -> FamilyFit:
    begun = time.thread_time()
    try:
        if name in TITLES:
            fit = direct_fit(log) if name == DIRECT else log.plays(name)
            return judge.identified(fit, time.thread_time() - begun)
        return _as(name, fit_one(name, judge, log.data, training))
    except DehystError as fault:
        return FamilyFit(name, title_of(name), reason=" ".join(str(fault).split()))


def _as(name: str, found: FamilyFit) -> FamilyFit:
    """The row of a family, which says which other one it stands for."""
    own = found.model.family
    return found if own == name else replace(found, family=name, title=f"{title_of(name)}: {own}")


def _with_reason(entry: FamilyFit, auto: Fit, curve: float) -> FamilyFit:
    """Say why a family that errs by a tenth of the range, or as much as a mere curve, does so."""
    if entry.model is None or entry.reason or entry.error_percent < min(POOR, AS_A_CURVE * curve):
        return entry
    said = []
    leads, lags = entry.family in LEADING, entry.family in TITLES or entry.family in LAGGING
    if entry.family == "static":
        said.append("it remembers nothing: both branches of the loop are one curve")
    elif lags and auto.facts.orientation == ("counter-clockwise" if leads else "clockwise"):
        way = ("counter-clockwise", "lags", "lead") if leads else ("clockwise", "leads", "lag")
        said.append("the loop is {}: its output {}, and these operators {}".format(*way))
    follows = any(finding.code == "rate-dependent" for finding in auto.warnings)
    if follows and not entry.model.rate_dependent:
        said.append(f"{' and '.join(auto.facts.depends)}, which the model does not know")
    return replace(entry, reason=f"{'; '.join(said) or NOT_FOUND}.")


def _named_once(ranked: list[FamilyFit]) -> list[FamilyFit]:
    """Say of a row which one above it is the same model: terms that a log does not need are left out of both."""
    marked: list[FamilyFit] = []
    for entry in ranked:
        twins = [above.family for above in marked if not above.same_as and _twins(above, entry)]
        marked.append(replace(entry, same_as=twins[0]) if twins else entry)
    return marked


def _twins(one: FamilyFit, other: FamilyFit) -> bool:
    """Whether two rows answer alike, to far more digits than a table shows."""
    if not len(one.predictions) == len(other.predictions) > 0:
        return False
    pairs = list(zip(one.predictions, other.predictions, strict=True))
    return all(a.shape == b.shape and float(np.max(np.abs(a - b))) <= SAME * float(np.ptp(a)) for a, b in pairs)


def _with_ties(
    ranked: list[FamilyFit], records: tuple[Recording, ...], masks: tuple[npt.NDArray[np.bool_], ...]
) -> tuple[FamilyFit, ...]:
    """Mark the rows whose mean square error differs from the best one by less than the scatter between blocks."""
    if not ranked or ranked[0].model is None:
        return tuple(ranked)
    best = _squares(ranked[0], records, masks)
    marked = []
    for entry in ranked:
        if entry.model is None:
            marked.append(entry)
            continue
        gaps = np.array(
            [block.mean() for block in np.array_split(_squares(entry, records, masks) - best, BLOCKS) if block.size]
        )
        doubt = float(np.std(gaps, ddof=1) / np.sqrt(gaps.size)) if gaps.size > 1 else float("inf")
        marked.append(replace(entry, tied=bool(gaps.mean() <= SIGMAS * doubt)))
    return tuple(marked)


def _squares(entry: FamilyFit, records: tuple[Recording, ...], masks: tuple[npt.NDArray[np.bool_], ...]) -> Array:
    pairs = zip(entry.predictions, records, masks, strict=True)
    return np.concatenate([(y[mask] - record.output[mask]) ** 2 for y, record, mask in pairs])
