"""Identifies the best model of a log: among sums of elements, plays and the curve without hysteresis."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import fields, replace
from functools import partial
from typing import Any, overload

import numpy as np
import numpy.typing as npt

from dehyst.data import Recording, counted_once, require_recordings
from dehyst.errors import DehystError, IdentificationError, ParameterError
from dehyst.families import (
    ROW_NAMES,
    Chosen,
    Lateness,
    LoopModel,
    Training,
    best_row_and_delay,
    is_family,
)
from dehyst.families import kit as families_kit
from dehyst.families import names as names_of_literature
from dehyst.findings import Finding
from dehyst.identification._candidates.direct import Direct, compare_forward
from dehyst.identification._candidates.literature import Literature, loop_outcome
from dehyst.identification._candidates.plays import plays_of
from dehyst.identification._cautions import late as lateness_finding
from dehyst.identification._cautions import plays_only
from dehyst.identification._coupled import CoupledFit, identify_coupled
from dehyst.identification._families import FAMILIES, STATIC
from dehyst.identification._fit import WITHOUT_SIGNALS, ComparedSetting, Fit
from dehyst.identification._judge import judge
from dehyst.identification._policy import POLICY
from dehyst.identification._prepared import Prepared, prepared
from dehyst.identification._ringing import with_resonance
from dehyst.identification._schedules import learned_once, without_gain
from dehyst.identification._settings import (
    PAPER_OPERATORS,
    check_recordings,
    check_weights,
    refuse_both,
)
from dehyst.identification._shear import identify_sheared, identify_within
from dehyst.identification._starts import with_starts
from dehyst.identification._threads import single_blas
from dehyst.identification._tracking import with_table
from dehyst.models import Resonance, StaticCurve
from dehyst.models import kit as models_kit
from dehyst.shell import did_you_mean

USUAL = {"n": PAPER_OPERATORS, "eps": "auto", "initial_state": "auto"}
PLAYS_SETTINGS = ("n", "eps", "thresholds", "initial_state", "weights", "shear", "max_inverse_gain")
DIRECT_SETTINGS = tuple(setting.name for setting in fields(Direct))
PURPOSES = ("compensate", "simulate")
LEAST_SIZE = 3  # numbers: an offset, a slope, and one play
PERCENT = 50.0  # of the range, for an error scaled to -1..1


@overload
def identify(
    recordings: Recording | Sequence[Recording],
    family: str = "auto",
    *,
    input: None = None,
    output: None = None,
    **settings: Any,
) -> Fit: ...


@overload
def identify(
    recordings: Recording | Sequence[Recording],
    family: str = "auto",
    *,
    input: Sequence[str],
    output: Sequence[str],
    **settings: Any,
) -> CoupledFit: ...


def identify(
    recordings: Recording | Sequence[Recording],
    family: str = "auto",
    *,
    input: Sequence[str] | None = None,
    output: Sequence[str] | None = None,
    purpose: str = "compensate",
    train_fraction: float | None = None,
    seed: int = 0,
    size: int | None = None,
    ahead: float | None = None,
    resonance: Resonance | tuple[float, float] | str | None = "auto",
    relative: bool = False,
    **settings: Any,
) -> Fit | CoupledFit:
    r"""Identify a model from one recording or several: by default the best there is for this log.

    Parameters
    ----------
    recordings
        One recording or a list of them; all are fitted together.
    family
        "auto": the best of the curve, plays and rows of elements, with creep, rate and maps, forward or inverse, by
        their errors on what is left out of the fitted part in turn. Or a family by its name. Of plays: "pi"
        (Prandtl-Ishlinskii, the paper's), "pi-cumulative" (positive partial sums instead of weights), "modified-pi"
        (with an output map, for loops that saturate or are asymmetric), "stop" (for clockwise loops). "static", a curve
        without memory. "direct-inverse", the compensator itself. Any of `dehyst.families.names()`: rows of elements and
        families of the literature.
    input, output
        Names of several inputs, and of one or two outputs, that act on each other, such as the axes of a stage or the
        muscles of a joint: signals of the recordings, `Recording.schedules` among them. Each output is then a sum over
        all inputs, and what is returned a `CoupledFit`; of all other settings only `train_fraction` counts. None, the
        default: one of each.
    purpose
        "compensate": the inverse shall not amplify noise where that costs next to nothing. "simulate": the smallest
        error of the output alone.
    train_fraction
        Share of each recording that is fitted; the rest is the test. 1 fits everything and tests nothing. None, the
        default, fits the first half of one recording or two; of three or more, whole ones are held out, about half of
        the samples, such that the input of these stays within the range that is fitted.
    seed
        Of the search, for families whose fit is not convex.
    size
        At most so many numbers (weights, points of maps, the offset), for a small target: for "auto" and rows of
        elements. The model of so many that errs least is taken. A curve without memory, where the log shows none, is
        not counted. None, the default: as many as pay off.
    ahead
        How long before its time the reference is known: so much of a dead time may be in the model, as
        `Model.dead_time`, and its compensator is then to be sent that much earlier (`Model.ahead`). None, the default,
        as long as the log shows; 0 for a controller that hears of the reference when it is due. For "auto". [s]
    resonance
        At which the actuator rings: "auto", where the log shows it; frequency [Hz] and damping, where they are known;
        None: none. It is in the model as `Model.resonance`, and the compensator does not excite it (`Model.shaped`).
        For "auto" and rows of elements.
    relative
        Whether errors count relative to the standard deviation of their recording's output, so that a recording of
        small loops counts as much as one of large ones. For "auto" (among rows of elements) and these rows.
    **settings
        Those of plays, below, and of "direct-inverse": the attributes of `dehyst.identification.Direct`. "auto" with
        one of plays that is not the usual one chooses among plays only.
    n
        Number of operators, at thresholds r_i = (i - 1)/n max|x|; ((i - 1)/n)^2 max|x| for "stop", whose
        loops are steep right after a reversal. Memory grows with n^2: 10 000 operators take several gigabytes.
        "auto" takes the fewest operators, on a grid with exponent 1 or 2, that are within 2 % of the least error on
        held-out loops. By default 100.
    eps
        Smallest slope right after a reversal, whose inverse bounds that of the compensator. For the family "pi" the
        paper's bound w_1 >= eps, by default its 0.001 [output/input]; for all others, and for family "auto", relative
        to output range over input range. "auto", the default of these, begins with 0.001 and, where the inverse would
        amplify by more than 20 times the ratio of the ranges, raises it (relative, for "pi" too) until it does not, or
        as far as the error of the fit grows by no more than 5 %.
    thresholds
        Thresholds to use instead of the grid, (n,), increasing from 0. [input]
    initial_state
        Memory before the first sample: "zero" (after decaying oscillation; the paper), "rest" (never moved),
        "rising" or "falling" (in the middle of a periodic motion), "unknown" (samples before both extremes were
        visited do not count), "origin" (came from rest at input 0), or "auto": by held-out error; for the family
        "pi" it is "zero" unless another start halves the error.
    weights
        How much each sample counts, (T,), 0 or more, or one such array for each recording: squared errors are
        multiplied by it, in the fit and in the scores. 2 is the same as a sample that was logged twice; 0 leaves
        a sample out, except that its input is remembered. By default all count alike.
    shear
        k: the loop is fitted around the diagonal, as :math:`y = H[u + k y]`, and the model is the sheared one, whose
        inverse subtracts k y again; for the families "pi" (which "auto" then stands for) and "pi-cumulative".
        `cross_validate` with a list of shears tells the error of the inverse for each. [input/output]
    max_inverse_gain
        G, largest slope of the inverse right after a reversal, instead of eps: a wanted output that moves by one step
        of its sensor changes the input asked for by at most G times that step. [input/output]

    Returns
    -------
    fit : Fit
        Model, scores, certificate, findings, and the table of what it was compared with. `CoupledFit` of several
        inputs.

    Raises
    ------
    ParameterError
        If a setting lies outside what its formula allows, or a family has no such setting.
    ExcitationError
        If the input or output does not move, or memory is unknown throughout the training part.
    IdentificationError
        If the program is not solved, or the family cannot fit such data; the message says why.

    Notes
    -----
    The paper's problem, with the input centred and an offset c identified along:

    .. math::

        \min_{w, c} \sum_k \Big(y_k - c - \sum_i w_i z_i[k]\Big)^2
        \quad \text{subject to} \quad w_1 \ge \varepsilon, \; w_i \ge 0

    References
    ----------
    M. Kastner, H. Gattringer, R. Naderer, "Evaluation of a Joint Hysteresis Model in a Robot Actuated by Pneumatic
    Muscles", ICINCO 2012. K. Kuhnen, European Journal of Control 9(4), 2003.

    Examples
    --------
    >>> import dehyst
    >>> from dehyst.io import example_recording
    >>> fit = dehyst.identify(example_recording())
    >>> fit.family, round(fit.test.rmse_percent, 1), round(fit.input_test.rms_percent, 1)
    ('full-sum', 0.1, 0.1)
    >>> dehyst.identify(example_recording(), "pi", n=20).size
    '4 of 20 operators'
    """
    # Before the family: identify(u, y) makes an array of it.
    recordings = tuple(map(counted_once, require_recordings(recordings)))
    if input is not None or output is not None:
        usual = family == "auto" and purpose == "compensate" and size is None and ahead is None
        if not usual or resonance != "auto" or settings:
            raise ParameterError(
                "input and output name several signals, whose sums have no family, purpose, size, dead time, resonance "
                "or other settings to choose. Leave these out, or leave input and output out."
            )
        return identify_coupled(recordings, input or (), output or (), train_fraction)
    if purpose not in PURPOSES:
        raise ParameterError(
            f"purpose (--for) = {purpose!r:.40}; it is one of {', '.join(PURPOSES)}.",
            purpose=purpose,
        )
    names_of_plays = ("auto", *FAMILIES, STATIC, Direct.family)
    is_name = isinstance(family, str)
    # Families of other packages are looked for last: that takes as long as reading a log.
    of_registry = is_name and family not in names_of_plays and is_family(family)
    if not is_name or not (of_registry or family in names_of_plays):
        names = (*names_of_plays, *names_of_literature())
        hint = did_you_mean(family, names)
        raise ParameterError(
            f"there is no family {family!r:.60}.{hint} There are: {', '.join(names)}.",
            family=repr(family)[:60],
        )
    refuse_settings(family, settings)
    changed = {}
    for name, value in settings.items():
        if not _is_usual(name, value, family):
            changed[name] = value
    if size is not None:
        _check_size(size, family, changed)
    if ahead is not None:
        _check_ahead(ahead, family, changed)
    if resonance != "auto":
        resonance = _typed_resonance(resonance, family, changed)
    if relative and (changed or not (family == "auto" or family in ROW_NAMES)):
        raise ParameterError(
            f"relative errors (--relative) are for auto and the rows of elements, and not for "
            f"{', '.join(changed) or family}. Leave one of them out.",
            family=family,
        )
    if family == Direct.family:
        direct = Direct(**settings)
        log = prepared(check_recordings(recordings), train_fraction)
        return with_table(log.fit(direct), *compare_forward(log))
    if recordings[0].schedules and (changed or not (family == "auto" or family in ROW_NAMES)):
        _refuse_schedules(recordings[0], family, changed)
    if of_registry:
        log = prepared(check_recordings(recordings), train_fraction, relative=relative)
        fit = with_table(log.fit(Literature(family, seed, purpose, size)))
        return with_resonance(fit, resonance) if family in ROW_NAMES else fit
    if family == "auto" and not changed:
        log = prepared(check_recordings(recordings), train_fraction, relative=relative)
        return with_resonance(
            best_fit(log, purpose, size, np.inf if ahead is None else ahead), resonance
        )
    fit = with_table(fit_plays(recordings, family, train_fraction=train_fraction, **changed))
    if family != "auto":
        return fit
    finding = plays_only(
        f"settings of theirs were given ({', '.join(changed)})",
        "To have them tried leave those settings out",
    )
    return replace(fit, warnings=(*fit.warnings, finding))


def fit_plays(
    recordings: Recording | Sequence[Recording],
    family: str = "auto",
    *,
    train_fraction: float | None = None,
    weights: npt.ArrayLike | Sequence[npt.ArrayLike] | None = None,
    shear: float | None = None,
    max_inverse_gain: float | None = None,
    **settings: Any,
) -> Fit:
    """Fit plays as they are, with a bounded gain, or to a sheared loop."""
    candidate, records = plays_of(family, **settings), check_recordings(recordings)
    log = prepared(records, train_fraction, check_weights(weights, records))
    if settings.get("eps") is not None:
        refuse_both(settings["eps"], shear, max_inverse_gain)
    if shear is not None:
        return identify_sheared(candidate, log, shear, max_inverse_gain)
    if max_inverse_gain is not None:
        return identify_within(candidate, log, max_inverse_gain)
    return log.fit(candidate)


def refuse_settings(family: str, settings: Mapping[str, object]) -> None:
    """Refuse settings that say nothing to a family, with a cure."""
    if not settings:
        return
    allowed: tuple[str, ...]
    elsewhere: tuple[str, ...]
    if family == Direct.family:
        allowed, elsewhere = DIRECT_SETTINGS, PLAYS_SETTINGS
        why = (
            "its radii, path lengths and slopes are its own and every sample counts alike. Leave them out; its "
            f"settings are {', '.join(DIRECT_SETTINGS)}"
        )
    elif is_family(family):
        allowed, elsewhere = (), (*PLAYS_SETTINGS, *DIRECT_SETTINGS)
        why = (
            f"all of it is found in the log. Leave them out, or take {', '.join(FAMILIES)} or auto"
        )
    else:
        allowed, elsewhere = PLAYS_SETTINGS, DIRECT_SETTINGS
        why = f"they belong to {Direct.family}. Leave them out, or take that family"
    misplaced = []
    unknown = []
    for name in settings:
        if name in allowed:
            continue
        if name in elsewhere:
            misplaced.append(name)
        else:
            unknown.append(name)
    if unknown:
        raise ParameterError(
            f"{', '.join(unknown)}: no such setting; they are {', '.join(allowed or elsewhere)}.",
            settings=unknown,
        )
    if misplaced:
        say = "say"
        if len(misplaced) == 1:
            say = "says"
        raise ParameterError(
            f"{' and '.join(misplaced)} {say} nothing to the family '{family}': {why}.",
            settings=misplaced,
        )


def _check_size(size: int, family: str, changed: Mapping[str, object]) -> None:
    """Refuse a size that is none, or that says nothing to what is identified."""
    if isinstance(size, bool) or not isinstance(size, (int, np.integer)) or size < LEAST_SIZE:
        raise ParameterError(
            f"size (--size) = {size!r:.40}; it is the largest number of weights, points of maps and offset of a model: "
            f"a whole number of {LEAST_SIZE} or more.",
            size=repr(size)[:40],
        )
    if family != "auto" and family not in ROW_NAMES:
        raise ParameterError(
            f"size (--size) is for auto and the rows of elements, and {family} has the size that its own settings give "
            f"it. Leave it out, or leave the family out.",
            family=family,
        )
    if changed:
        raise ParameterError(
            f"size (--size) chooses among rows of elements, and {', '.join(changed)} among plays. Give one of them.",
            settings=[*changed],
        )


def _check_ahead(ahead: float, family: str, changed: Mapping[str, object]) -> None:
    """Refuse a time that is none, or that says nothing to what is identified."""
    if isinstance(ahead, bool) or not isinstance(ahead, (int, float)) or not ahead >= 0.0:
        raise ParameterError(
            f"ahead (--ahead) = {ahead!r:.40}; it is the time in seconds by which the reference is known before it is "
            f"due: 0 or more, or leave it out.",
            ahead=repr(ahead)[:40],
        )
    if family != "auto" or changed:
        raise ParameterError(
            f"ahead (--ahead) says how much of a dead time auto may take into the model, and "
            f"{', '.join(changed) or family} has none. Leave it out, or leave that out.",
            family=family,
        )


def _typed_resonance(
    value: Resonance | tuple[float, float] | str | None, family: str, changed: Mapping[str, object]
) -> Resonance | None:
    """Return a resonance that was typed; refuse what is none, or says nothing to what is identified."""
    resonance = models_kit.resonance_of(value)
    if resonance is not None and (changed or not (family == "auto" or family in ROW_NAMES)):
        other = ", ".join(changed) or f"family {family}"
        raise ParameterError(
            f"a resonance (--resonance) is for auto and the rows of elements; with {other} no model has a place for "
            f"one. Leave the resonance out, or {other}.",
            family=family,
        )
    return resonance


def _refuse_schedules(record: Recording, family: str, changed: Mapping[str, object]) -> None:
    """Refuse signals that say nothing to what is identified."""
    names = ", ".join(record.schedules)
    raise ParameterError(
        f"the weights of {', '.join(changed) or family} do not go with another signal, and there is a schedule "
        f"({names}; --schedule). Rows of elements and the direct inverse do: leave that out, so that auto chooses one "
        f"of them, or leave the schedule out.",
        family=family,
        schedules=list(record.schedules),
    )


def _is_usual(name: str, value: object, family: str) -> bool:
    """Whether a setting is what it is without being given; the paper's eps is a number."""
    usual = None if (name, family) == ("eps", "pi") else USUAL.get(name)
    return value is None or (isinstance(value, (str, int)) and usual == value)


def best_fit(
    log: Prepared,
    purpose: str = PURPOSES[0],
    size: int | None = None,
    ahead: float = np.inf,
) -> Fit:
    """Return the best of plays, the curve, and the rows of elements, these of at most so many numbers.

    A dead time that the log shows is in the model, of it at most `ahead` seconds.
    """
    by_plays = plays_of("auto")
    fitted_plays = log.fit(by_plays)
    training = log.training(0)
    settings = {**by_plays.settings, "purpose": purpose}
    if np.isfinite(ahead):
        settings["ahead"] = ahead
    if size is not None:
        settings["size"] = size
    too_large = size is not None and fitted_plays.model.free_parameters > size
    with single_blas():
        try:
            search = partial(best_row_and_delay, firm=purpose != "simulate", size=size, ahead=ahead)
            (chosen, late, delay), plain, about_schedules = _with_schedules_or_not(training, search)
            fit = partial(_row_again, chosen, firm=purpose != "simulate", most=size)
            begun = with_starts(log, chosen.model, fit) if not delay else None
            if begun is not None:
                log, training = begun, begun.training(0)
                search_again = _with_schedules_or_not(training, search)
                (chosen, late, delay), plain, about_schedules = search_again
            settings |= log.settings
            compared = _compared(fitted_plays, chosen)
            terms = chosen.carrying, chosen.columns
            outcome = loop_outcome(
                log,
                chosen.model,
                settings,
                fitted_plays.static,
                *terms,
                chosen.kkt,
                compared,
                chosen.terms,
            )
            rows = judge(log.data, log.seen, outcome)
            rows = replace(rows, warnings=(*rows.warnings, *about_schedules))
            rivals = [fitted_plays]
            if plain is not None:
                rivals.append(_without_signals(log, settings, fitted_plays.static, plain.chosen))
        # Too few samples, or no program that could be solved: plays are what there is.
        except DehystError:
            # Plays do not go with another signal, so they cannot stand in.
            if training.schedules:
                raise
            if size is None or not too_large or fitted_plays.family == STATIC:
                return with_table(fitted_plays)
            fitted_plays = log.fit(plays_of("pi", n=size - 1))
            if fitted_plays.model.free_parameters > size:
                raise
            return with_table(fitted_plays)
    broken_off = any(len(record.pieces) > 1 for record in log.records)
    not_told_apart = (
        families_kit.turns_of(training) < families_kit.POLICY.enough_turns or broken_off
    )
    if log.seen.butterfly is not None and size is None and not training.schedules:
        with suppress(IdentificationError):
            butterfly = log.fit(Literature("butterfly", purpose=purpose))
            left_out = PERCENT * chosen.candidates[0].score
            if butterfly.train.rmse_percent < POLICY.butterfly_worth * left_out:
                return with_table(butterfly, rows, *rivals)
    plays_do = _plays_do(fitted_plays, chosen, not_told_apart)
    if plays_do and (fitted_plays.family == STATIC or not too_large):
        return _with_lateness(with_table(fitted_plays, rows), late, training.period)
    return _with_lateness(with_table(rows, *rivals), late, training.period, delay)


def _row_again(chosen: Chosen, training: Training, firm: bool, most: int | None) -> LoopModel:
    """Return the model of the same row for another training; with the other signals where the row goes with them."""
    if not chosen.model.schedules:
        training = training.unscheduled
    return families_kit.row_again(chosen, training, firm, most).model


def _with_schedules_or_not(
    training: Training, search: Callable[[Training], families_kit.ChosenRow]
) -> tuple[families_kit.ChosenRow, families_kit.ChosenRow | None, tuple[Finding, ...]]:
    """Return the best row, whose weights go with other signals if that pays, and what is to be said of them.

    Where they do, the second row is the best one without these signals.
    """
    chosen = search(training)
    if not training.schedules:
        return chosen, None, ()
    names = [name for name, _ in training.signals]
    plain = search(training.unscheduled)
    once = tuple(learned_once(names, training.joined(training.xi)))
    if once:
        return chosen, plain, once
    findings = tuple(without_gain(names, chosen.score, plain.score, left_out=True))
    if findings:
        return plain, None, findings
    return chosen, plain, ()


def _without_signals(
    log: Prepared, settings: dict[str, Any], static: StaticCurve, plain: Chosen
) -> Fit:
    """Return the fit of the best row whose weights go with no signal: what a schedule has to beat is shown."""
    terms = plain.carrying, plain.columns
    fit = judge(log.data, log.seen, loop_outcome(log, plain.model, settings, static, *terms))
    return replace(fit, family=fit.family + WITHOUT_SIGNALS)


def _with_lateness(fit: Fit, late: Lateness | None, period: float, delay: int = 0) -> Fit:
    """A fit that says by how much the output is late; the model has `delay` samples of it."""
    if late is None:
        return fit
    step, unit = (period, "s") if period > 0.0 else (1.0, "samples")
    percent = PERCENT * late.without, PERCENT * late.shifted
    finding = lateness_finding(step * late.samples, unit, percent, step * delay)
    return replace(fit, warnings=(*fit.warnings, finding))


def _plays_do(fitted_plays: Fit, chosen: Chosen, not_told_apart: bool) -> bool:
    """Whether plays, or a curve, do as well on what is left out as the best sum of elements.

    Sums have to beat a curve by 5 %, and plays by a quarter. Plays count only where the log does not tell sums apart,
    as the input turned too seldom, or where it breaks off, as only plays leave out what nobody knows of their memory;
    elsewhere sums of plays are among what was compared (docs/decisions/0048).
    """
    error = np.inf
    for setting in fitted_plays.candidates:
        if setting.chosen:
            error = setting.error_percent
    left_out = PERCENT * chosen.candidates[0].score
    if fitted_plays.family == STATIC:
        return bool(error * POLICY.static_as_good <= left_out)
    return bool(not_told_apart and error * POLICY.clear <= left_out)


def _compared(fitted_plays: Fit, chosen: Chosen) -> tuple[ComparedSetting, ...]:
    """All that were compared: sums by their score, plays by what is left out, percent of range."""
    rows = []
    for row in chosen.candidates:
        lam, is_best = row.regularisation.lam, row is chosen.candidates[0]
        error = PERCENT * row.score
        rows.append(
            ComparedSetting(
                row.sum.name, str(chosen.model.start), lam, error, float("nan"), is_best
            )
        )
    for setting in fitted_plays.candidates:
        rows.append(replace(setting, chosen=False))
    return tuple(rows)
