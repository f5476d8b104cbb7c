"""identify_direct(): from recordings to a direct inverse, certified and compared."""

from __future__ import annotations

import datetime as _datetime
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from dehyst import __version__
from dehyst.arrays import Array, Mask
from dehyst.errors import DehystError, ParameterError
from dehyst.findings import Finding
from dehyst.identification.direct.cautions import about_direct_fit, about_terms, direct_verdict, findings_of_data
from dehyst.identification.direct.columns import (
    GROUPS,
    LENGTHS,
    RADII,
    ROWS,
    STARTS,
    Bank,
    Layout,
    Shape,
    rows_at,
    terms_along,
)
from dehyst.identification.direct.data import DirectData, check_given, prepare_direct
from dehyst.identification.direct.fit import DirectCertificate, DirectFit, Rival
from dehyst.identification.direct.program import DirectEstimate, predict, solve_shape
from dehyst.identification.direct.selection import Trials, TriedShape, choose_shape
from dehyst.identification.direct.times import AUTO, check_creep, time_constants
from dehyst.identification.families import FAMILIES
from dehyst.identification.fit import Candidate, Fit, LoopFacts, Score
from dehyst.identification.measures import InMemory
from dehyst.identification.procedure import call_of, solve_in_memory
from dehyst.identification.settings import PAPER_OPERATORS, check_recordings, eps_of_call
from dehyst.identification.split import HALF, Split, split_recordings, tested_on
from dehyst.identification.threads import single_blas
from dehyst.models import DirectInverse, ModelCard, Schedule, SignalCard
from dehyst.models.follow import follow
from dehyst.recording import Recording, takes_recordings
from dehyst.ties import rank

LOAD, MEAN_PRESSURE = "load", "mean_pressure"
Given = npt.ArrayLike | Sequence[npt.ArrayLike] | None


def build_direct(layout: Layout, estimate: DirectEstimate, data: DirectData, card: ModelCard) -> DirectInverse:
    """Return the model of an estimate; terms without weight are left out, which is exact."""
    shape, slope = estimate.shape, data.amplitude / data.half_range
    given = tuple(Schedule(g.name, g.low, g.high, g.unit) for g in data.given)
    low, high = data.center - data.half_range, data.center + data.half_range
    schedules = (Schedule("output", low, high), *given) if shape.by_output else given
    tables = _tables(layout, estimate)
    return DirectInverse(
        radii=layout.bank.radii * data.half_range,
        stop_weights=tables["stops"] * slope,
        path_lengths=layout.bank.lengths * data.half_range,
        path_weights=tables["path"] * slope,
        time_constants=layout.bank.time_constants,
        creep_weights=tables["creep"] * slope,
        polynomial=_polynomials(estimate, data, len(given)),
        viscous=tables["viscous"][:, 0] * slope,
        center=data.center,
        schedules=schedules,
        known=shape.start == "rest",
        card=card,
    ).pruned()


def _tables(layout: Layout, estimate: DirectEstimate) -> dict[str, Array]:
    """Weights (sets, terms) of every group, zero where the shape has none."""
    sets, tables, begin = estimate.weights.shape[0], {}, 0
    for name in GROUPS:
        size = layout.sizes[name]
        there = name in estimate.shape.groups
        tables[name] = estimate.weights[:, begin : begin + size] if there else np.zeros((sets, size))
        begin += size if there else 0
    return tables


def _polynomials(estimate: DirectEstimate, data: DirectData, given: int) -> Array:
    """(sets, d): the polynomial in both sets of the output's schedule, or those of the given schedules in theirs."""
    parts = estimate.polynomials * (data.amplitude / data.half_range ** np.arange(estimate.shape.degree + 1))
    parts[: 2 if given else 1, 0] += data.level
    if given == 0:
        return np.repeat(parts, 2 if estimate.shape.by_output else 1, axis=0)
    return np.vstack([np.zeros((2, parts.shape[1])), parts]) if estimate.shape.by_output else parts


class Compared(NamedTuple):
    """Rivals, the one with the best inverse first; what the data shows; findings about the data."""

    rivals: tuple[Rival, ...]
    facts: LoopFacts
    findings: tuple[Finding, ...]


def compare_forward(records: tuple[Recording, ...], split: Split, loads: Sequence[Sequence[Array]]) -> Compared:
    """Identify every forward family and score it.

    A family that cannot be identified is left out; if none can, the fault of the last one is raised.
    """
    fits: list[Fit] = []
    fault: DehystError | None = None
    measure = InMemory(records, loads)  # which tests rate and creep once for all of them
    for family in FAMILIES:
        call = call_of(family, PAPER_OPERATORS, eps_of_call(family, None), None, "auto", split)
        try:
            fits.append(solve_in_memory(call, records, None, measure))
        except DehystError as found:
            fault = found
    if not fits:
        raise fault if fault is not None else AssertionError("no family was tried")
    fits.sort(key=lambda fit: rank(fit.certificate.inverse_miss_percent))
    rivals = tuple(
        Rival(fit.family, fit.certificate.inverse_miss_percent, (fit.test or fit.train).rmse_percent) for fit in fits
    )
    return Compared(rivals, fits[0].facts, tuple(findings_of_data(fits[0].warnings)))


@takes_recordings
def identify_direct(
    recordings: Recording | Sequence[Recording],
    *,
    creep: int | str = AUTO,
    creep_times: npt.ArrayLike | None = None,
    load: Given = None,
    mean_pressure: Given = None,
    units: Mapping[str, str] | None = None,
    position_schedule: bool = True,
    initial_state: str = AUTO,
    train_fraction: float | None = None,
    stops_only: bool = False,
) -> DirectFit:
    r"""Identify the compensator itself: the input that an actuator needs, as a function of its measured output.

    .. math::

        \min \sum_k \Big(u_k - P(y_k) - \sum_i s_i E_{r_i}[y]_k - \sum_j p_j R_{x_j}[y]_k
            - \sum_m k_m (y - L_{\tau_m}[y])_k - d \dot y_k\Big)^2
        \quad \text{subject to} \quad s, p, k, d \ge 0, \; P' \ge \varepsilon

    One non-negative least-squares problem with a trace of ridge. The regressor is the output, which an encoder
    measures with hardly any noise; the noise of the input, a pressure as a rule, is in the target and biases nothing.
    Which terms are in, the degree of P, the past before the first sample and whether the weights change with the
    output is chosen by the error on held-out parts of the fitted samples; a term has to lower it by 2 %.

    Parameters
    ----------
    recordings
        One recording or a list of them; all are fitted together. Creep and rate need time stamps.
    creep
        How many time constants to offer, spread evenly on a logarithmic scale over what the log tells apart; 0 for
        none; "auto" offers six and keeps them if held-out error says so.
    creep_times
        Time constants instead, (m,), increasing; not together with a number of them. [s]
    load, mean_pressure
        Scheduling signals: the weights are blended between their lowest and highest fitted value. One value a sample,
        (T,), or one such array for each recording.
    units
        Units of the scheduling signals by name, ``{"load": "N", "mean_pressure": "bar"}``.
    position_schedule
        Whether the weights may change with the output, for loops that are not symmetric; they do if held-out error says
        so. Without it the input is guaranteed to rise with the output, whatever the past.
    initial_state
        Past before the first sample: "unknown" (a stop answers in the middle of what it may be), "rest", "rising" or
        "falling" (within a periodic motion), or "auto", by held-out error.
    train_fraction
        Share of each recording that is fitted; the rest is the test.
    stops_only
        Whether stop operators and P are all that is offered, no path lags and no viscosity: a Maxwell-slip model, as
        long as creep and position_schedule are off, too.

    Returns
    -------
    fit : DirectFit
        Model, errors in both directions, comparison with the forward families, evidence, findings.

    Raises
    ------
    ParameterError
        If a setting lies outside what its formula allows, or a signal does not fit the recordings.
    ExcitationError
        If something does not move, the output falls while the input rises, or too few samples are left.
    IdentificationError
        If the program is not solved.

    References
    ----------
    K. Kuhnen, European Journal of Control 9(4), 2003. P. R. Dahl, A solid friction model, 1968.

    Examples
    --------
    >>> import numpy as np, dehyst
    >>> t = np.linspace(0.0, 60.0, 1200)
    >>> y = 10 * np.sin(0.8 * t) * np.linspace(1.0, 0.4, 1200)
    >>> truth = dehyst.DirectInverse(radii=[2.0], stop_weights=[0.3], polynomial=[1.0, 0.2])
    >>> fit = identify_direct(dehyst.Recording(input=truth.run(y, t).u, output=y, time=t), creep=0)
    >>> fit.settings["groups"]
    ['stops']
    """
    records = check_recordings(recordings)
    times = check_creep(creep, creep_times)
    starts = _check_start(initial_state)
    given = _check_schedules(records, {LOAD: load, MEAN_PRESSURE: mean_pressure}, units or {})
    if given and train_fraction is None:
        train_fraction = HALF  # a recording may be all that there is at one load
    split = split_recordings(records, train_fraction)
    with single_blas():
        data = prepare_direct(records, split, given)
        _refuse_untimed(data, creep, times, records)
        asked = times is not None or not isinstance(creep, str)
        bank = Bank(RADII, LENGTHS, time_constants(data, creep, times) if data.timed else np.zeros(0))
        layout = Layout(bank, len(data.given))
        trials = Trials(layout, data)
        creeps = ("creep",) if bank.time_constants.size else ()
        required = creeps if asked else ()
        lags = () if stops_only else ("path",)
        viscous = ("viscous",) if data.timed and not stops_only else ()
        optional = (*lags, *(creeps if not asked else ()), *viscous)
        chosen = choose_shape(trials, required, optional, starts, by_output=bool(position_schedule))
        settings = _settings(creep, times, initial_state, split, chosen.shape, bank, data)
        loads = [
            [np.clip((given[g.name][0][k] - g.low) / (g.high - g.low), 0.0, 1.0) for g in data.given]
            for k in range(len(records))
        ]
        compared = compare_forward(records, split, loads)
        return _fitted(records, data, layout, trials, chosen, bool(required), settings, compared)


def _check_start(initial_state: str) -> tuple[str, ...]:
    if initial_state == AUTO:
        return STARTS
    if initial_state not in STARTS:
        raise ParameterError(
            f"initial_state {initial_state!r} is not one of auto, {', '.join(STARTS)} for a direct inverse.",
            initial_state=initial_state,
        )
    return (initial_state,)


def _check_schedules(
    records: tuple[Recording, ...], signals: Mapping[str, Given], units: Mapping[str, str]
) -> dict[str, tuple[tuple[Array, ...], str]]:
    return {
        name: (check_given(name, values, records), units.get(name, ""))
        for name, values in signals.items()
        if values is not None
    }


def _refuse_untimed(data: DirectData, creep: int | str, times: Array | None, records: tuple[Recording, ...]) -> None:
    if not data.timed and (times is not None or (not isinstance(creep, str) and creep > 0)):
        raise ParameterError(
            f"creep is a matter of time, and '{records[0].name}' has no time stamps. Name the time column (--time), "
            f"pass time to the Recording, or leave creep out (--creep 0)."
        )


def _settings(
    creep: int | str,
    times: Array | None,
    initial_state: str,
    split: Split,
    shape: Shape,
    bank: Bank,
    data: DirectData,
) -> dict[str, Any]:
    return {
        "family": DirectInverse.family,
        "creep": creep if times is None else "given",
        "creep_times": bank.time_constants.tolist() if "creep" in shape.groups else [],
        "initial_state": initial_state,
        **split.settings,
        "schedules": [given.name for given in data.given],
        "degree": shape.degree,
        "groups": list(shape.groups),
        "by_output": shape.by_output,
        "start": shape.start,
    }


@dataclass(frozen=True)
class _Answers:
    """What a model says about every recording, in the units of the log."""

    inputs: tuple[Array, ...]
    statics: tuple[Array, ...]
    outputs: tuple[Array, ...]
    train: tuple[Mask, ...]
    test: tuple[Mask, ...]
    missed: int


def _fitted(
    records: tuple[Recording, ...],
    data: DirectData,
    layout: Layout,
    trials: Trials,
    chosen: TriedShape,
    asked: bool,
    settings: dict[str, Any],
    compared: Compared,
) -> DirectFit:
    shape = chosen.shape
    rows, samples = trials.rows(shape.start)
    estimate = solve_shape(layout, shape, rows, samples)
    curve = solve_shape(layout, Shape(7, (), False, shape.start), rows, samples)
    model = build_direct(layout, estimate, data, _signals(records, data, {}))
    answers = _answers(records, data, layout, estimate, curve, model)
    inputs, outputs = [r.input for r in records], [r.output for r in records]
    train, test = (_score(inputs, answers.inputs, part, data.input_range) for part in (answers.train, answers.test))
    forward = [_score(outputs, answers.outputs, part, data.output_range) for part in (answers.train, answers.test)]
    curves = [_score(inputs, answers.statics, part, data.input_range) for part in (answers.train, answers.test)]
    (forward_train, forward_test), (static_train, static_test) = forward, curves
    if train is None or forward_train is None or static_train is None:
        raise AssertionError("no fitted samples")  # prepare_direct has counted them
    certificate = DirectCertificate(
        estimate.kkt_residual, model.nonzero_weights, layout.terms_of(shape).size * len(layout.sets_of(shape)),
        shape.start, model.least_slope() > 0.0, answers.missed,
    )  # fmt: skip
    judged, static = test or train, static_test or static_train
    findings: list[Finding] = [finding for record in records for finding in record.findings]
    findings += compared.findings
    findings += about_terms(data, shape, layout.bank.time_constants, asked, trials, compared.facts.evidence)
    findings += about_direct_fit(
        records, data, judged, static, compared.rivals, certificate,
        test is None and settings["train_fraction"] < 1.0,
        100.0 * data.amplitude / data.input_range * chosen.uncertainty,
        all(finding.code != "never-turns" for finding in findings),
    )  # fmt: skip
    unique = tuple({(finding.code, finding.message): finding for finding in findings}.values())
    verdict = direct_verdict(
        judged,
        forward_test or forward_train,
        static,
        compared.rivals,
        certificate,
        None if test is None else tested_on(settings),
        unique,
    )
    provenance = _provenance(records, settings, train, test, verdict)
    return DirectFit(
        model=model.with_card(_signals(records, data, provenance)),
        recordings=records,
        predictions=answers.inputs,
        outputs=answers.outputs,
        train_masks=answers.train,
        test_masks=answers.test,
        train=train,
        test=test,
        forward_train=forward_train,
        forward_test=forward_test,
        static_train=static_train,
        static_test=static_test,
        certificate=certificate,
        rivals=compared.rivals,
        facts=compared.facts,
        candidates=_candidates(trials, chosen, data),
        warnings=unique,
        settings=settings,
        verdict=verdict,
    )


def _answers(
    records: tuple[Recording, ...],
    data: DirectData,
    layout: Layout,
    estimate: DirectEstimate,
    curve: DirectEstimate,
    model: DirectInverse,
) -> _Answers:
    inputs, statics = [np.empty(len(r)) for r in records], [np.empty(len(r)) for r in records]
    outputs = [np.empty(len(r)) for r in records]
    train = [np.zeros(len(r), dtype=np.bool_) for r in records]
    test = [np.zeros(len(r), dtype=np.bool_) for r in records]
    missed, start = 0, estimate.shape.start
    for piece in data.pieces:
        at, k = piece.span, piece.recording
        terms = terms_along(layout, piece, start)
        for begin in range(0, piece.y.size, ROWS):
            part = slice(begin, min(begin + ROWS, piece.y.size))
            rows, there = rows_at(layout, piece, terms, part), slice(at.start + part.start, at.start + part.stop)
            inputs[k][there] = data.level + data.amplitude * predict(layout, estimate, rows)
            statics[k][there] = data.level + data.amplitude * predict(layout, curve, rows)
        given = {g.name: g.low + (g.high - g.low) * xi for g, xi in zip(data.given, piece.given, strict=True)}
        found = follow(model, records[k].input[at], piece.time, given, start)
        outputs[k][at] = found.y
        missed += found.missed
        train[k][at], test[k][at] = piece.mask(True), piece.mask(False)
    return _Answers(tuple(inputs), tuple(statics), tuple(outputs), tuple(train), tuple(test), missed)


def _score(measured: list[Array], said: tuple[Array, ...], masks: tuple[Mask, ...], span: float) -> Score | None:
    left = np.concatenate([(y - m)[k] for y, m, k in zip(measured, said, masks, strict=True)])
    if left.size == 0:
        return None
    values = np.concatenate([y[k] for y, k in zip(measured, masks, strict=True)])
    rmse, scatter = float(np.sqrt(np.mean(left**2))), float(np.std(values))
    return Score(
        rmse, 100.0 * rmse / span, rmse / scatter if scatter > 0.0 else float("inf"), float(np.max(np.abs(left)))
    )


def _candidates(trials: Trials, chosen: TriedShape, data: DirectData) -> tuple[Candidate, ...]:
    percent = 100.0 * data.amplitude / data.input_range
    tried = sorted(trials.done.values(), key=lambda trial: (rank(trial.error), trial.shape.words, trial.shape.start))
    return tuple(
        Candidate(
            trial.shape.words, trial.shape.start, None, percent * trial.error, percent * trial.uncertainty,
            trial.shape == chosen.shape,
        )
        for trial in tried
    )  # fmt: skip


def _signals(records: tuple[Recording, ...], data: DirectData, provenance: Mapping[str, Any]) -> ModelCard:
    """Signals with the ranges that were fitted: beyond them the model holds its polynomials."""
    first = records[0]
    return ModelCard(
        SignalCard(first.input_name, first.input_unit, data.level - data.amplitude, data.level + data.amplitude),
        SignalCard(first.output_name, first.output_unit, data.center - data.half_range, data.center + data.half_range),
        provenance,
    )


def _provenance(
    records: tuple[Recording, ...], settings: dict[str, Any], train: Score, test: Score | None, verdict: str
) -> dict[str, Any]:
    return {
        "logs": [dict(record.provenance) | {"name": record.name, "samples": record.samples} for record in records],
        "date": _datetime.datetime.now(_datetime.UTC).isoformat(timespec="seconds"),
        "dehyst": __version__,
        "settings": dict(settings),
        "identified_family": DirectInverse.family,
        "initial_state": settings["start"],
        "train": train.as_dict(),
        "test": None if test is None else test.as_dict(),
        "verdict": verdict,
    }
