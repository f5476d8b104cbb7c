"""The direct inverse as a candidate: the input as a function of the measured output."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array, Mask, rank
from dehyst.data import Recording
from dehyst.errors import DehystError, ParameterError
from dehyst.findings import Finding
from dehyst.identification._candidate import BlockErrors, Outcome
from dehyst.identification._candidates.plays import plays_of
from dehyst.identification._cautions import Knows
from dehyst.identification._direct.data import (
    AUTO,
    DirectData,
    DirectPiece,
    check_creep,
    period_of,
    prepare_direct,
    time_constants,
)
from dehyst.identification._direct.program import (
    GROUPS,
    LENGTHS,
    RADII,
    ROWS,
    STARTS,
    Bank,
    DirectEstimate,
    Layout,
    predict,
    solve_shape,
    terms_along,
)
from dehyst.identification._direct.selection import (
    Trials,
    TriedShape,
    about_direct_fit,
    about_terms,
    choose_shape,
)
from dehyst.identification._evidence import Evidence, without_holds
from dehyst.identification._families import FAMILIES
from dehyst.identification._fit import Certificate, ComparedSetting, Fit
from dehyst.identification._prepared import Prepared
from dehyst.identification._scores import Measured, Part, part_of
from dehyst.models import DirectInverse, ModelCard, Schedule, SignalCard
from dehyst.models import kit as models_kit

ROUTE = "non-negative least squares of the terms"


def build_direct(
    layout: Layout, estimate: DirectEstimate, data: DirectData, card: ModelCard
) -> DirectInverse:
    """Return the model of an estimate; terms without weight are left out, which is exact."""
    shape, slope = estimate.shape, data.amplitude / data.half_range
    schedules = [Schedule(g.name, g.low, g.high, g.unit) for g in data.schedules]
    if shape.by_output:
        low, high = data.center - data.half_range, data.center + data.half_range
        schedules.insert(0, Schedule("output", low, high))
    tables = _tables(layout, estimate)
    return DirectInverse(
        radii=layout.bank.radii * data.half_range,
        stop_weights=tables["stops"] * slope,
        path_lengths=layout.bank.lengths * data.half_range,
        path_weights=tables["path"] * slope,
        time_constants=layout.bank.time_constants,
        creep_weights=tables["creep"] * slope,
        polynomial=_polynomials(estimate, data, len(data.schedules)),
        viscous=tables["viscous"][:, 0] * slope,
        center=data.center,
        schedules=tuple(schedules),
        past=shape.start,
        card=card,
    ).pruned()


def _tables(layout: Layout, estimate: DirectEstimate) -> dict[str, Array]:
    """Weights (sets, terms) of every group, zero where the shape has none."""
    sets = estimate.weights.shape[0]
    tables = {}
    begin = 0
    for name in GROUPS:
        size = layout.sizes[name]
        if name in estimate.shape.groups:
            tables[name] = estimate.weights[:, begin : begin + size]
            begin += size
        else:
            tables[name] = np.zeros((sets, size))
    return tables


def _polynomials(estimate: DirectEstimate, data: DirectData, scheduled: int) -> Array:
    """(sets, d): the polynomial in both sets of the output's schedule, or those of the given schedules in theirs."""
    by_output = estimate.shape.by_output
    parts = estimate.polynomials * (
        data.amplitude / data.half_range ** np.arange(estimate.shape.degree + 1)
    )
    # The level is added once: to both ends of the first schedule, whose shares add up to 1.
    parts[:2, 0] += data.level
    if scheduled == 0 and by_output:
        return np.repeat(parts, 2, axis=0)
    if by_output:
        return np.vstack([np.zeros((2, parts.shape[1])), parts])
    return parts


def compare_forward(log: Prepared) -> tuple[Fit, ...]:
    """Identify every forward family on the same samples, the one with the best inverse first.

    A family that cannot be identified is left out; if none can, the fault of the last one is raised.
    """
    fits: list[Fit] = []
    fault: DehystError | None = None
    for family in FAMILIES:
        try:
            fits.append(log.fit(plays_of(family)))
        except DehystError as refusal:
            fault = refusal
    if not fits:
        raise fault or AssertionError("no family was tried")
    return tuple(sorted(fits, key=lambda fit: rank(fit.input_error.rms_percent)))


@dataclass(frozen=True, eq=False)
class Direct:
    r"""The compensator itself as a candidate: the input that an actuator needs, as a function of its measured output.

    .. math::

        \min \sum_k \Big(u_k - P(y_k) - \sum_i s_i E_{r_i}[y]_k - \sum_j p_j R_{x_j}[y]_k
            - \sum_m k_m (y - L_{\tau_m}[y])_k - d \dot y_k\Big)^2
        \quad \text{subject to} \quad s, p, k, d \ge 0, \; P' \ge \varepsilon

    One non-negative least-squares problem with a trace of ridge. The regressor is the output, which an encoder
    measures with hardly any noise; the noise of the input, a pressure as a rule, is in the target and biases nothing.
    Which terms are in, the degree of P, the past before the first sample and whether the weights change with the
    output is chosen by the error on held-out parts of the fitted samples; a term has to lower it by 2 %.

    Attributes
    ----------
    creep
        How many time constants to offer, spread evenly on a logarithmic scale over what the log tells apart; 0 for
        none; "auto" offers six and keeps them if held-out error says so. Creep and rate need time stamps.
    creep_times
        Time constants instead, (m,), increasing; not together with a number of them. [s]
    position_schedule
        Whether the weights may change with the output, for loops that are not symmetric; they do if held-out error says
        so. Without it the input is guaranteed to rise with the output, whatever the past.
    initial_state
        Past before the first sample: "unknown" (a stop answers in the middle of what it may be), "rest", "rising" or
        "falling" (within a periodic motion), or "auto", by held-out error.
    stops_only
        Whether stop operators and P are all that is offered, no path lags and no viscosity: a Maxwell-slip model, as
        long as creep and position_schedule are off, too.

    References
    ----------
    K. Kuhnen, European Journal of Control 9(4), 2003. P. R. Dahl, A solid friction model, 1968.
    """

    creep: int | str = AUTO
    creep_times: npt.ArrayLike | None = None
    position_schedule: bool = True
    initial_state: str = AUTO
    stops_only: bool = False

    family = DirectInverse.family

    def fit(self, log: Prepared) -> Outcome:
        """Choose the terms and fit them."""
        choice = self._choose(log)
        data, shape = choice.data, choice.trial.shape
        creep = self.creep
        if self.creep_times is not None:
            creep = "given"
        creep_times = []
        if "creep" in shape.groups:
            creep_times = choice.layout.bank.time_constants.tolist()
        settings = {
            "family": self.family,
            "creep": creep,
            "period": period_of(data),
            "creep_times": creep_times,
            "initial_state": self.initial_state,
            **log.split.settings,
            "schedules": [signal.name for signal in data.schedules],
            "degree": shape.degree,
            "groups": list(shape.groups),
            "by_output": shape.by_output,
            "start": shape.start,
        }
        return _outcome(log, choice, settings)

    def block_errors(self, log: Prepared) -> BlockErrors:
        """Return the errors of the input by which the terms were chosen; the output is no target here."""
        choice = self._choose(log)
        errors = choice.data.amplitude * choice.trial.errors
        terms = int(choice.layout.terms_of(choice.trial.shape).size)
        return BlockErrors(np.full(errors.size, np.nan), errors, terms, float("nan"))

    def _choose(self, log: Prepared) -> _Choice:
        records = log.records
        times = check_creep(self.creep, self.creep_times)
        starts = _check_start(self.initial_state)
        data = prepare_direct(records, log.split)
        _refuse_untimed(data, self.creep, times, records)
        constants = np.zeros(0)
        if data.timed:
            constants = time_constants(data, self.creep, times)
        layout = Layout(Bank(RADII, LENGTHS, constants), len(data.schedules))
        trials = Trials(layout, data)
        # Creep that was asked for is in; what else is in, held-out error decides.
        creep_asked = times is not None or not isinstance(self.creep, str)
        required: list[str] = []
        optional: list[str] = []
        if not self.stops_only:
            optional.append("path")
        if constants.size and creep_asked:
            required.append("creep")
        elif constants.size:
            optional.append("creep")
        if data.timed and not self.stops_only:
            optional.append("viscous")
        trial = choose_shape(
            trials,
            tuple(required),
            tuple(optional),
            starts,
            by_output=bool(self.position_schedule),
        )
        return _Choice(data, layout, trials, trial, bool(required))


class _Choice(NamedTuple):
    """The chosen terms, and what they were chosen from; `asked` says whether creep was asked for."""

    data: DirectData
    layout: Layout
    trials: Trials
    trial: TriedShape
    asked: bool


def _check_start(initial_state: str) -> tuple[str, ...]:
    if initial_state == AUTO:
        return STARTS
    if initial_state not in STARTS:
        raise ParameterError(
            f"initial_state {initial_state!r} is not one of auto, {', '.join(STARTS)} for a direct inverse.",
            initial_state=initial_state,
        )
    return (initial_state,)


def _refuse_untimed(
    data: DirectData, creep: int | str, times: Array | None, records: tuple[Recording, ...]
) -> None:
    if not data.timed and (times is not None or (not isinstance(creep, str) and creep > 0)):
        raise ParameterError(
            f"creep is a matter of time, and '{records[0].name}' has no time stamps. Name the time column (--time), "
            f"pass time to the Recording, or leave creep out (--creep 0)."
        )


class _Answers(NamedTuple):
    """What a model says about every recording, in the units of the log, over which samples; inputs nothing needs."""

    demands: tuple[Array, ...]
    outputs: tuple[Array, ...]
    scored: tuple[Part, Part]
    missed: int


def _outcome(log: Prepared, choice: _Choice, settings: dict[str, Any]) -> Outcome:
    """Fit the chosen terms."""
    data, layout, trials, chosen, asked = choice
    shape, records, whole = chosen.shape, log.records, log.data
    estimate = solve_shape(layout, shape, *trials.system(shape))
    model = build_direct(layout, estimate, data, _signals(records, data))
    answers = _answers(records, data, layout, estimate, model)
    static = log.curve()
    rises = model.least_slope() > 0.0
    certificate = Certificate(
        kkt_residual=estimate.kkt_residual,
        inverse_gain=float("nan"),
        nonzero_weights=model.nonzero_weights,
        operators=int(layout.terms_of(shape).size),
        initial_state=shape.start,
        route=ROUTE,
    )

    def measured(turns: int) -> Measured:
        answered = answers.outputs, answers.demands
        return log.measure.compared(whole, answers.scored, *answered, float("nan"), static, turns)

    def remarks(measured: Measured) -> Iterator[Finding]:
        uncertainty = 100.0 * data.amplitude / data.input_range * chosen.uncertainty
        yield from about_terms(
            data, shape, layout.bank.time_constants, asked, trials, measured.evidence
        )
        yield from about_direct_fit(
            measured.input_error, compare_forward(log)[0], rises, uncertainty
        )
        yield from _without_holds(records, data, model, measured.evidence)

    return Outcome(
        family=model.family,
        model=model,
        settings=settings,
        certificate=certificate,
        measure=measured,
        static=static,
        knows=Knows(leads=True, crosses=True, time=True),
        compared=_candidates(trials, chosen, data),
        details=_details(model, settings, rises, answers.missed),
        remarks=remarks,
    )


def _details(
    model: DirectInverse, settings: dict[str, Any], rises: bool, missed: int
) -> dict[str, Any]:
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
    records: tuple[Recording, ...],
    data: DirectData,
    layout: Layout,
    estimate: DirectEstimate,
    model: DirectInverse,
) -> _Answers:
    demands: list[Array] = []
    outputs: list[Array] = []
    train: list[Mask] = []
    test: list[Mask] = []
    for record in records:
        demands.append(np.empty(len(record)))
        outputs.append(np.empty(len(record)))
        train.append(np.zeros(len(record), dtype=np.bool_))
        test.append(np.zeros(len(record), dtype=np.bool_))
    missed, start = 0, estimate.shape.start
    for piece in data.pieces:
        at, k = piece.span, piece.recording
        for part, terms in terms_along(layout, piece, start):
            asked = predict(layout, estimate, piece, terms, part)
            place = slice(at.start + part.start, at.start + part.stop)
            demands[k][place] = data.level + data.amplitude * asked
        # The output that needs the input which was applied: the model the other way round.
        followed = models_kit.follow(
            model, records[k].input[at], piece.time, _scheduling(data, piece), start
        )
        outputs[k][at] = followed.y
        missed += followed.missed
        train[k][at] = piece.mask(True)
        test[k][at] = piece.mask(False)
    return _Answers(tuple(demands), tuple(outputs), (part_of(train), part_of(test)), missed)


def _without_holds(
    records: tuple[Recording, ...],
    data: DirectData,
    model: DirectInverse,
    tested: Sequence[Evidence],
) -> Iterator[Finding]:
    piece = data.pieces[0]
    if piece.time is not None and model.time_constants.size:
        y = records[piece.recording].output[piece.span][:ROWS]
        cut = {name: values[:ROWS] for name, values in _scheduling(data, piece).items()}
        span = data.level - data.amplitude, data.level + data.amplitude
        yield from without_holds(
            tested, lambda at: model.run(y, at, given=cut).u, piece.time[:ROWS], span
        )


def _scheduling(data: DirectData, piece: DirectPiece) -> dict[str, Array]:
    """Scheduling variables along a piece, by name."""
    variables = {}
    for signal, xi in zip(data.schedules, piece.shares, strict=True):
        variables[signal.name] = signal.low + (signal.high - signal.low) * xi
    return variables


def _candidates(
    trials: Trials, chosen: TriedShape, data: DirectData
) -> tuple[ComparedSetting, ...]:
    percent = 100.0 * data.amplitude / data.input_range
    tried = sorted(
        trials.shapes.values(),
        key=lambda trial: (rank(trial.error), trial.shape.words, trial.shape.start),
    )
    settings = []
    for trial in tried:
        settings.append(
            ComparedSetting(
                trial.shape.words, trial.shape.start, None, percent * trial.error, percent * trial.uncertainty,
                trial.shape == chosen.shape,
            )
        )  # fmt: skip
    return tuple(settings)


def _signals(records: tuple[Recording, ...], data: DirectData) -> ModelCard:
    """Signals with the ranges that were fitted: beyond them the model holds its polynomials."""
    first = records[0]
    return ModelCard(
        SignalCard(
            first.input_name,
            first.input_unit,
            data.level - data.amplitude,
            data.level + data.amplitude,
        ),
        SignalCard(
            first.output_name,
            first.output_unit,
            data.center - data.half_range,
            data.center + data.half_range,
        ),
    )
