"""identify(): chooses the best model of a log among sums of elements, plays and the curve without hysteresis."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from inspect import signature
from typing import Any

import numpy as np

from dehyst.data.recording import Recording, require_recordings, takes_recordings
from dehyst.data.repeats import counted_once
from dehyst.errors import DehystError, IdentificationError, ParameterError
from dehyst.families.base import LoopModel
from dehyst.families.choice import Candidate as SumCandidate
from dehyst.families.choice import Chosen
from dehyst.families.fitting import demanded, predicted, training_of_log
from dehyst.families.lateness import Lateness, lateness
from dehyst.families.registry import MODULES, ROWS
from dehyst.families.registry import family as family_of
from dehyst.families.rows import ENOUGH_TURNS, best_row, turns_of
from dehyst.families.training import Training
from dehyst.fields import did_you_mean
from dehyst.findings import Finding
from dehyst.identification import identify as identify_plays
from dehyst.identification.cautions import Knows, plays_only
from dehyst.identification.cautions import late as lateness_finding
from dehyst.identification.certify import fit_of
from dehyst.identification.data import range_over
from dehyst.identification.evidence import beyond_rests, without_holds
from dehyst.identification.families import FAMILIES, STATIC
from dehyst.identification.fit import Candidate, Certificate, Fit, size_of
from dehyst.identification.procedure import DIRECT, Prepared, call_of, prepared
from dehyst.identification.scores import Measured, parts
from dehyst.identification.settings import PAPER_OPERATORS, check_recordings
from dehyst.identification.static_curve import curve_of, fit_static
from dehyst.identification.threads import single_blas
from dehyst.identification.tracking import with_table
from dehyst.models import StaticCurve

USUAL = {"n": PAPER_OPERATORS, "eps": "auto", "initial_state": "auto"}
SETTINGS = tuple(
    name for name, each in signature(identify_plays).parameters.items()
    if each.kind is each.KEYWORD_ONLY and name != "train_fraction"
)  # fmt: skip
PURPOSES = ("compensate", "simulate")
CLEAR = 0.75  # of the error of plays, where blocks hardly tell sums apart
WORTH = 0.95  # of the curve's error: where more is left, nothing is remembered
PERCENT = 50.0  # of the range, for an error scaled to -1..1
PROGRAM = "normal equations of the columns"
TRIED = 20_000  # samples of the round trip, and of another speed


@takes_recordings
def identify(
    recordings: Recording | Sequence[Recording],
    family: str = "auto",
    *,
    purpose: str = "compensate",
    train_fraction: float | None = None,
    seed: int = 0,
    **settings: Any,
) -> Fit:
    """Identify a model from one recording or several: by default the best there is for this log.

    Parameters
    ----------
    recordings
        One recording or a list of them; all are fitted together.
    family
        "auto": the best of the curve, plays (pi, pi-cumulative, modified-pi, stop) and rows of elements, with creep,
        rate and maps, forward or inverse, by their errors within the fitted part. Or a family by its name: one of
        these, "direct-inverse", or any of `dehyst.families.names()`.
    purpose
        "compensate": the inverse shall not amplify noise where that costs next to nothing. "simulate": the smallest
        error of the output alone.
    train_fraction
        Share of each recording that is fitted; the rest is the test. None: see `dehyst.identification.identify`.
    seed
        Of the search, for families whose fit is not convex.
    **settings
        n, eps, thresholds, initial_state, weights, shear, max_inverse_gain: those of plays, as
        `dehyst.identification.identify` takes them. "auto" with one of them that is not the usual one chooses among
        plays only.

    Returns
    -------
    fit : Fit
        Model, scores, certificate, findings, and the table of what it was compared with.

    Raises
    ------
    ParameterError
        If a setting lies outside what its formula allows, or a family has no such setting.
    ExcitationError
        If the input or output does not move, or memory is unknown throughout the training part.
    IdentificationError
        If the program is not solved, or the family cannot fit such data; the message says why.

    Examples
    --------
    >>> import dehyst
    >>> from dehyst.io import example_recording
    >>> fit = dehyst.identify(example_recording())
    >>> fit.family, round(fit.test.rmse_percent, 1), round(fit.input_test.rms_percent, 1)
    ('full-sum', 0.1, 0.1)
    """
    # Before the family: identify(u, y) makes an array of it.
    recordings = tuple(map(counted_once, require_recordings(recordings)))
    if purpose not in PURPOSES:
        raise ParameterError(f"purpose = {purpose!r:.40}; it is one of {', '.join(PURPOSES)}.", purpose=purpose)
    known = ("auto", *FAMILIES, STATIC, DIRECT, *dict.fromkeys((*MODULES, *ROWS)))
    if not isinstance(family, str) or family not in known:
        hint = did_you_mean(family, known)
        raise ParameterError(
            f"there is no family {family!r:.60}.{hint} There are: {', '.join(known)}.", family=repr(family)[:60]
        )
    if family in MODULES or family in ROWS:
        if settings:
            raise ParameterError(
                f"{', '.join(settings)}: settings of plays, which say nothing to the family '{family}'. Leave them "
                f"out, or take {', '.join(FAMILIES)} or auto.",
                settings=sorted(settings),
            )
        return with_table(_named(prepared(check_recordings(recordings), train_fraction), family, seed, purpose))
    unknown = [name for name in settings if name not in SETTINGS]
    if unknown:
        raise ParameterError(
            f"{', '.join(unknown)}: no such setting; they are {', '.join(SETTINGS)}.", settings=unknown
        )
    settings = {name: value for name, value in settings.items() if not _is_usual(name, value, family)}
    if family == "auto" and not settings:
        log = prepared(check_recordings(recordings), train_fraction)
        return best_fit(log, training_of_log(log), purpose)
    fit = identify_plays(recordings, family, train_fraction=train_fraction, **settings)
    fit = fit if fit.table else with_table(fit)
    if family != "auto":
        return fit
    told = plays_only(
        f"settings of theirs were given ({', '.join(settings)})", "To have them tried leave those settings out"
    )
    return replace(fit, warnings=(*fit.warnings, told))


def _is_usual(name: str, value: object, family: str) -> bool:
    """Whether a setting is what it is without being given; the paper's eps is a number."""
    usual = None if (name, family) == ("eps", "pi") else USUAL.get(name)
    return value is None or (isinstance(value, (str, int)) and usual == value)


def best_fit(log: Prepared, training: Training, purpose: str = PURPOSES[0]) -> Fit:
    """Return the best of plays, the curve, and the rows of elements."""
    plays = log.plays("auto")
    with single_blas():
        job = _Job(log, log.call("auto").settings | {"purpose": purpose}, plays.static)
        try:
            chosen = best_row(training, purpose != "simulate")
            late = lateness(training, chosen.candidates[0], turns_of(training))
            ahead = late.samples if late and purpose == "simulate" and training.period > 0.0 else 0
            if ahead > 0:
                chosen = best_row(training.late(ahead), firm=False).later(ahead * training.period)
            rows = job.fit(chosen.model, chosen.kkt, (chosen.carrying, chosen.columns), _shown(plays, chosen))
        except DehystError:  # too few samples, or no program that could be solved: plays are what there is
            return with_table(plays)
    untold = turns_of(training) < ENOUGH_TURNS or any(len(record.pieces) > 1 for record in log.records)
    taken, other = (plays, rows) if _plays_do(plays, chosen, untold) else (rows, plays)
    fit = with_table(taken, other)
    if late is None:
        return fit
    return replace(fit, warnings=(*fit.warnings, _told(late, training.period, ahead > 0 and taken is rows)))


def _told(late: Lateness, period: float, used: bool) -> Finding:
    time, unit = (late.samples * period, "s") if period > 0.0 else (float(late.samples), "samples")
    return lateness_finding(time, unit, (PERCENT * late.without, PERCENT * late.shifted), used)


def _named(log: Prepared, name: str, seed: int, purpose: str) -> Fit:
    """Return the fit of a family of the registry."""
    settings = call_of(name, 0, (0.0, False), None, "auto", log.split).settings | {"purpose": purpose}
    with single_blas():
        static = curve_of(fit_static(log.data, "zero")[0], log.data)
        found = family_of(name)
        model = found.fit(training_of_log(log, seed))
        settings |= {} if found.convex else {"seed": seed}
        return _Job(log, settings, static).fit(model, float("nan"), (model.free_parameters, model.free_parameters), ())


def _plays_do(plays: Fit, chosen: Chosen, untold: bool) -> bool:
    """Whether plays, or a curve, do as well on blocks left out as the best sum of elements.

    Sums have to beat a curve by 5 %, and plays by a quarter. Plays count only where the log does not tell sums apart
    (`untold`), as the input turned too seldom, or where it breaks off, as only plays leave out what nobody knows of
    their memory; elsewhere sums of plays are among what was compared (docs/decisions/0048).
    """
    own = next((each.error_percent for each in plays.candidates if each.chosen), np.inf)
    left_out = PERCENT * chosen.candidates[0].left_out
    return own * WORTH <= left_out if plays.family == STATIC else untold and own * CLEAR <= left_out


def _shown(plays: Fit, chosen: Chosen) -> tuple[Candidate, ...]:
    """All that were compared: plays by their blocks left out, sums by their score, percent of range."""

    def shown(each: SumCandidate) -> Candidate:
        lam = each.regularisation.lam
        return Candidate(
            each.sum.name, chosen.model.start, lam, PERCENT * each.score, float("nan"), each is chosen.candidates[0]
        )

    return (*map(shown, chosen.candidates), *(replace(each, chosen=False) for each in plays.candidates))


class _Job:
    """Everything that judging a model of this log takes."""

    def __init__(self, log: Prepared, settings: dict[str, Any], static: StaticCurve) -> None:
        self.log, self.records, self.data, self.settings, self.static = log, log.records, log.data, settings, static

    def fit(self, model: LoopModel, kkt: float, terms: tuple[int, int], candidates: tuple[Candidate, ...]) -> Fit:
        """Return the judged fit of a model; `terms`: how many carry weight, and of how many."""
        measured = self._measured(model)
        certificate = Certificate(
            kkt_residual=kkt,
            round_trip_error=measured.round_trip,
            inverse_gain=model.inverse_gain,
            inverse_miss_percent=measured.input_error.rms_percent,
            affordable_eps=None,
            nonzero_weights=terms[0],
            operators=terms[1],
            undetermined=(),
            initial_state=model.start,
            route=PROGRAM if np.isfinite(kkt) else "its own search",
        )
        knows = Knows(leads=True, crosses=True, time=model.rate_dependent)
        name = f"{model.family}, {size_of(model, *terms)}"
        return fit_of(
            model, model.family, name, knows, self.data, self.log.seen, self.static, measured, certificate,
            self.settings, candidates, no_inverse=model.no_inverse, more=tuple(self._without_holds(model, measured)),
        )  # fmt: skip

    def _without_holds(self, model: LoopModel, measured: Measured) -> Iterator[Finding]:
        x, time = self.records[0].input[:TRIED], self.records[0].time
        if time is not None and model.rate_dependent:
            span = range_over([record.input for record in self.records])
            yield from without_holds(measured.evidence, lambda at: model.simulate(x, at), time[:TRIED], span)
            yield from beyond_rests(x, time[:TRIED], model.simulate, self.data.output_range)

    def _measured(self, model: LoopModel) -> Measured:
        records, data = self.records, self.data
        outputs = predicted(model, records, data)
        if not all(np.all(np.isfinite(y)) for y in outputs):
            raise IdentificationError(f"the fitted {model.family} model diverges on the held-out part.")
        nothing = tuple(np.full(len(record), np.nan) for record in records)
        demands = nothing if model.no_inverse else demanded(model, records, data)
        trip = float("nan") if model.no_inverse else _round_trip(model, records[0])
        scored = parts(records, data, model.start)
        return self.log.measure.compared(data, scored, outputs, demands, trip, self.static, self.log.seen.counts[1])


def _round_trip(model: LoopModel, record: Recording) -> float:
    """Largest difference after model and inverse, either way round, relative to the ranges."""
    x, time = record.input[:TRIED], None if record.time is None else record.time[:TRIED]
    model = model.prompt
    y = model.simulate(x, time)
    back = model.inverse().simulate(y, time)
    again = model.simulate(back, time)
    return max(float(np.max(np.abs(a - b)) / max(np.ptp(b), 1e-300)) for a, b in ((back, x), (again, y)))
