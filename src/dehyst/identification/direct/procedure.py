"""identify_direct(): from recordings to a direct inverse, checked and compared."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array, rank
from dehyst.data.recording import Recording, takes_recordings
from dehyst.errors import DehystError, ParameterError
from dehyst.findings import Finding
from dehyst.identification.cautions import Knows
from dehyst.identification.certify import fit_of
from dehyst.identification.direct.data import (
    AUTO,
    DirectData,
    DirectPiece,
    check_creep,
    check_given,
    period_of,
    prepare_direct,
    time_constants,
)
from dehyst.identification.direct.program import (
    GROUPS,
    LENGTHS,
    RADII,
    ROWS,
    STARTS,
    Bank,
    DirectEstimate,
    Layout,
    Shape,
    predict,
    solve_shape,
    terms_along,
)
from dehyst.identification.direct.selection import Trials, TriedShape, about_direct_fit, about_terms, choose_shape
from dehyst.identification.evidence import Evidence, without_holds
from dehyst.identification.families import FAMILIES
from dehyst.identification.fit import Candidate, Certificate, Fit, size_of
from dehyst.identification.procedure import Prepared, prepared
from dehyst.identification.scores import InMemory, Part, part_of
from dehyst.identification.settings import check_recordings
from dehyst.identification.split import HALF, Split
from dehyst.identification.static_curve import curve_of, fit_static
from dehyst.identification.threads import single_blas
from dehyst.identification.tracking import with_table
from dehyst.models import DirectInverse, ModelCard, Schedule, SignalCard
from dehyst.models.follow import follow

ROUTE = "non-negative least squares of the terms"
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


def compare_forward(log: Prepared) -> tuple[Fit, ...]:
    """Identify every forward family on the same samples, the one with the best inverse first.

    A family that cannot be identified is left out; if none can, the fault of the last one is raised.
    """
    fits: list[Fit] = []
    fault: DehystError | None = None
    for family in FAMILIES:
        try:
            fits.append(log.plays(family))
        except DehystError as found:
            fault = found
    if not fits:
        raise fault if fault is not None else AssertionError("no family was tried")
    return tuple(sorted(fits, key=lambda fit: rank(fit.input_error.rms_percent)))


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
) -> Fit:
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
    fit : Fit
        Model, errors in both directions, findings; its table compares it with the forward families.

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
    log = prepared(records, train_fraction)
    asked = _Asked(creep, times, initial_state, starts, given, bool(position_schedule), stops_only)
    return direct_fit(log, asked)


class _Asked(NamedTuple):
    """Settings, checked, as they are if nobody asks; scheduling signals: samples of each recording, and a unit."""

    creep: int | str = AUTO
    times: Array | None = None
    initial_state: str = AUTO
    starts: tuple[str, ...] = STARTS
    given: Mapping[str, tuple[tuple[Array, ...], str]] = {}
    by_output: bool = True
    stops_only: bool = False


USUAL = _Asked()


def direct_fit(log: Prepared, asked: _Asked = USUAL) -> Fit:
    """Identify the compensator of recordings that were prepared."""
    records, given, times = log.records, asked.given, asked.times
    with single_blas():
        data = prepare_direct(records, log.split, given)
        _refuse_untimed(data, asked.creep, times, records)
        bank = Bank(RADII, LENGTHS, time_constants(data, asked.creep, times) if data.timed else np.zeros(0))
        layout = Layout(bank, len(data.given))
        trials = Trials(layout, data)
        creeps = ("creep",) if bank.time_constants.size else ()
        required = creeps if times is not None or not isinstance(asked.creep, str) else ()
        lags = () if asked.stops_only else ("path",)
        viscous = ("viscous",) if data.timed and not asked.stops_only else ()
        optional = (*lags, *(creeps if not required else ()), *viscous)
        chosen = choose_shape(trials, required, optional, asked.starts, by_output=asked.by_output)
        settings = _settings(asked, log.split, chosen.shape, bank, data)
        if data.given:
            loads = [
                [np.clip((given[g.name][0][k] - g.low) / (g.high - g.low), 0.0, 1.0) for g in data.given]
                for k in range(len(records))
            ]
            log = replace(log, measure=InMemory(records, loads))
        return _fitted(log, data, layout, trials, chosen, bool(required), settings)


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


def _settings(asked: _Asked, split: Split, shape: Shape, bank: Bank, data: DirectData) -> dict[str, Any]:
    return {
        "family": DirectInverse.family,
        "creep": asked.creep if asked.times is None else "given",
        "period": period_of(data),
        "creep_times": bank.time_constants.tolist() if "creep" in shape.groups else [],
        "initial_state": asked.initial_state,
        **split.settings,
        "schedules": [given.name for given in data.given],
        "degree": shape.degree,
        "groups": list(shape.groups),
        "by_output": shape.by_output,
        "start": shape.start,
    }


class _Answers(NamedTuple):
    """What a model says about every recording, in the units of the log, over which samples; inputs nothing needs."""

    demands: tuple[Array, ...]
    outputs: tuple[Array, ...]
    scored: tuple[Part, Part]
    missed: int


def _fitted(
    log: Prepared,
    data: DirectData,
    layout: Layout,
    trials: Trials,
    chosen: TriedShape,
    asked: bool,
    settings: dict[str, Any],
) -> Fit:
    shape, records, whole = chosen.shape, log.records, log.data
    estimate = solve_shape(layout, shape, *trials.system(shape))
    model = build_direct(layout, estimate, data, _signals(records, data))
    answers = _answers(records, data, layout, estimate, model)
    others = compare_forward(log)
    static = curve_of(fit_static(whole, "zero")[0], whole)
    measured = log.measure.compared(
        whole, answers.scored, answers.outputs, answers.demands, float("nan"), static, log.seen.counts[1]
    )
    terms, rises = int(layout.terms_of(shape).size), model.least_slope() > 0.0
    certificate = Certificate(
        kkt_residual=estimate.kkt_residual,
        round_trip_error=measured.round_trip,
        inverse_gain=float("nan"),
        inverse_miss_percent=measured.input_error.rms_percent,
        affordable_eps=None,
        nonzero_weights=model.nonzero_weights,
        operators=terms,
        undetermined=(),
        initial_state=shape.start,
        route=ROUTE,
    )
    more = (
        *about_terms(data, shape, layout.bank.time_constants, asked, trials, measured.evidence),
        *about_direct_fit(
            measured.input_error, others[0], rises, 100.0 * data.amplitude / data.input_range * chosen.uncertainty
        ),
        *_without_holds(records, data, model, measured.evidence),
    )
    fit = fit_of(
        model, model.family, f"{model.family}, {size_of(model, model.nonzero_weights, terms)}",
        Knows(leads=True, crosses=True, time=True), whole, log.seen, static, measured, certificate,
        settings, _candidates(trials, chosen, data), more=more,
    )  # fmt: skip
    return with_table(replace(fit, details=_details(model, settings, rises, answers.missed)), *others)


def _details(model: DirectInverse, settings: dict[str, Any], rises: bool, missed: int) -> dict[str, Any]:
    """What only this family says of itself; `missed`: samples at which no output near the range needs the input."""
    return {
        "degree": settings["degree"],
        "groups": settings["groups"],
        "schedules": [schedule.name for schedule in model.schedules],
        "time_constants": model.time_constants.tolist(),
        "rises": rises,
        "missed": missed,
    }


def _answers(
    records: tuple[Recording, ...], data: DirectData, layout: Layout, estimate: DirectEstimate, model: DirectInverse
) -> _Answers:
    demands, outputs = [np.empty(len(r)) for r in records], [np.empty(len(r)) for r in records]
    train, test = ([np.zeros(len(r), dtype=np.bool_) for r in records] for _ in range(2))
    missed, start = 0, estimate.shape.start
    for piece in data.pieces:
        at, k = piece.span, piece.recording
        for part, terms in terms_along(layout, piece, start):
            asked = predict(layout, estimate, piece, terms, part)
            demands[k][at.start + part.start : at.start + part.stop] = data.level + data.amplitude * asked
        found = follow(model, records[k].input[at], piece.time, _given(data, piece), start)
        outputs[k][at] = found.y
        missed += found.missed
        train[k][at], test[k][at] = piece.mask(True), piece.mask(False)
    return _Answers(tuple(demands), tuple(outputs), (part_of(train), part_of(test)), missed)


def _without_holds(
    records: tuple[Recording, ...], data: DirectData, model: DirectInverse, tested: Sequence[Evidence]
) -> Iterator[Finding]:
    piece = data.pieces[0]
    if piece.time is not None and model.time_constants.size:
        y = records[piece.recording].output[piece.span][:ROWS]
        cut = {name: values[:ROWS] for name, values in _given(data, piece).items()}
        span = data.level - data.amplitude, data.level + data.amplitude
        yield from without_holds(tested, lambda at: model.run(y, at, given=cut).u, piece.time[:ROWS], span)


def _given(data: DirectData, piece: DirectPiece) -> dict[str, Array]:
    """Scheduling variables along a piece, by name."""
    return {g.name: g.low + (g.high - g.low) * xi for g, xi in zip(data.given, piece.given, strict=True)}


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


def _signals(records: tuple[Recording, ...], data: DirectData) -> ModelCard:
    """Signals with the ranges that were fitted: beyond them the model holds its polynomials."""
    first = records[0]
    return ModelCard(
        SignalCard(first.input_name, first.input_unit, data.level - data.amplitude, data.level + data.amplitude),
        SignalCard(first.output_name, first.output_unit, data.center - data.half_range, data.center + data.half_range),
    )
