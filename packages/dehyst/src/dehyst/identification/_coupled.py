"""identify(..., input=[...], output=[...]): sums over several inputs from logs in which they move together."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from datetime import date
from typing import Any

import numpy as np

from dehyst.arrays import Array, Mask
from dehyst.data import Recording, robust_range
from dehyst.errors import ExcitationError, ParameterError
from dehyst.families import Scaling, Stretch, Training, steps_of
from dehyst.families import kit as families_kit
from dehyst.findings import Finding
from dehyst.identification._policy import POLICY
from dehyst.identification._split import split_recordings
from dehyst.identification._threads import single_blas
from dehyst.models import ModelCard, SignalCard
from dehyst.version import __version__

PERCENT = 100.0
FEWEST = 200  # samples
SEEN = 0.9  # of the range of an input, over which its memory is taken to be known


@dataclass(frozen=True)
class CoupledOutput:
    """How one output was fitted; errors are rms, percent of the range of the output.

    Attributes
    ----------
    name, unit
        Of the output.
    own
        Input that moves it most, which the inverse finds it by.
    effects
        Input -> how far this input alone moves the output along the log, highest less lowest; negative where the output
        falls with it. [output]
    test_percent, alone_percent, curve_percent
        On held-out samples, on all samples if none were held out: of the model, of the own input alone, and of curves
        of all inputs without memory.
    terms
        Groups of elements of its sums.
    """

    name: str
    unit: str
    own: str
    effects: dict[str, float]
    test_percent: float
    alone_percent: float
    curve_percent: float
    terms: tuple[str, ...]


@dataclass(frozen=True)
class CoupledFit:
    """A model of several inputs, and how good it is.

    Attributes
    ----------
    model
        `dehyst.families.kit.CoupledModel`.
    outputs
        Of each output its errors.
    input_percent
        Input -> rms of what the inverse asks for, less what was applied, on held-out samples; percent of its range.
        Empty where there is no inverse.
    determinant
        Lower bound of the determinant of the slopes over all states, of two inputs and two outputs: above 0 two outputs
        have one pair of inputs. None for one output.
    kkt_residual
        Largest violation of the optimality conditions of the weights, relative.
    warnings
        What reading and fitting found.
    """

    model: families_kit.CoupledModel
    outputs: tuple[CoupledOutput, ...]
    input_percent: dict[str, float]
    determinant: float | None
    kkt_residual: float
    warnings: tuple[Finding, ...] = ()

    @property
    def certificate(self) -> str:
        """Whether the inverse is unique, in one sentence."""
        if self.model.no_inverse:
            return f"no inverse: {self.model.no_inverse}"
        if self.determinant is None:
            own = self.outputs[0].own
            return f"one value of {own} for each {self.outputs[0].name} while the other inputs are known."
        return (
            f"one pair of inputs for each pair of outputs, in every state: the determinant of the slopes is at least "
            f"{self.determinant:.2g}, and has to be above 0."
        )

    def as_dict(self) -> dict[str, Any]:
        """Return the figures as printed by ``--json``."""
        outputs = []
        for one in self.outputs:
            outputs.append({**vars(one), "terms": list(one.terms)})
        return {
            "family": self.model.family,
            "parameters": self.model.free_parameters,
            "outputs": outputs,
            "input_percent": dict(self.input_percent),
            "determinant": self.determinant,
            "certificate": self.certificate,
            "kkt_residual": self.kkt_residual,
            "warnings": [{"code": one.code, "message": one.message} for one in self.warnings],
        }

    def __str__(self) -> str:
        """Three or four lines: an error for each output, the certificate."""
        lines = [f"{len(self.model.inputs)} inputs, {self.model.free_parameters} parameters"]
        for one in self.outputs:
            effects = ", ".join(f"{name} {effect:+.3g}" for name, effect in one.effects.items())
            lines.append(
                f"{one.name}: {one.test_percent:.2f} % of range held out; {one.own} alone {one.alone_percent:.2f}, "
                f"curves {one.curve_percent:.2f}; moved by {effects} {one.unit}".rstrip()
            )
        lines.append(self.certificate)
        return "\n".join(lines)


def identify_coupled(
    records: tuple[Recording, ...],
    inputs: Sequence[str],
    outputs: Sequence[str],
    train_fraction: float | None = None,
) -> CoupledFit:
    """Return the model of outputs that several inputs move; `dehyst.identify` tells more.

    Raises
    ------
    ParameterError
        If a signal is not in a recording, or the numbers of inputs and outputs are none.
    ExcitationError
        If a signal does not move, or two inputs move together.
    """
    _check_names(records, inputs, outputs)
    ends = split_recordings(records, train_fraction).ends
    if sum(ends) < FEWEST:
        raise ExcitationError(
            f"{sum(ends)} samples are fitted, and several inputs need {FEWEST} or more: each has to go over its range, "
            f"alone and together with the others. Log longer, or pass a larger train_fraction (--train-fraction).",
            samples=sum(ends),
        )
    u, fitted_u = _columns(records, inputs, ends)
    y, fitted_y = _columns(records, outputs, ends)
    _check_motion(fitted_u, inputs, fitted_y, outputs)
    center, half = _middle(fitted_u)
    level, amplitude = _middle(fitted_y)
    scalings = []
    for j in range(len(outputs)):
        scalings.append(
            [Scaling(center[i], half[i], level[j], amplitude[j]) for i in range(len(inputs))]
        )
    cards = (
        _cards(records[0], inputs, np.concatenate(u)),
        _cards(records[0], outputs, np.concatenate(y)),
    )

    def fitted_with(counts: Sequence[Mask]) -> families_kit.FittedCoupled:
        training = _training(records, u, y, ends, counts, scalings)
        with single_blas():
            return families_kit.fit_coupled(
                training, *cards, scalings, u[0][0].tolist(), _period(records)
            )

    known = [
        _known(record, values, end, half)
        for record, values, end in zip(records, u, ends, strict=True)
    ]
    every = [_counted(record) for record in records]
    fitted = fitted_with(every)
    if _begins_elsewhere(fitted.model, records, u, y, ends, known):
        fitted = fitted_with([a & b for a, b in zip(every, known, strict=True)])
    provenance = {
        "log": records[0].name, "inputs": list(inputs), "outputs": list(outputs), "dehyst": __version__,
        "date": date.today().isoformat(),
    }  # fmt: skip
    model = fitted.model
    model = model.with_card(ModelCard(model.inputs[0], model.outputs[0], provenance))
    return _judged(model, fitted, records, u, y, ends)


def _training(
    records: Sequence[Recording],
    u: Sequence[Array],
    y: Sequence[Array],
    ends: Sequence[int],
    counts: Sequence[Mask],
    scalings: Sequence[Sequence[Scaling]],
) -> families_kit.CoupledTraining:
    """Return the fitted part of all recordings, scaled."""
    trainings = []
    for i, scaling in enumerate(scalings[0]):
        stretches = []
        for record, values, counted, end in zip(records, u, counts, ends, strict=True):
            stretches += _stretches(record, np.asarray(scaling.inward(values[:, i])), counted, end)
        trainings.append(Training(tuple(stretches), scaling, "none"))
    outputs = []
    for j, of_output in enumerate(scalings):
        scaling = of_output[0]
        parts = []
        for record, values, end in zip(records, y, ends, strict=True):
            for piece in _pieces(record, end):
                parts.append((values[piece, j] - scaling.level) / scaling.amplitude)
        outputs.append(tuple(parts))
    return families_kit.CoupledTraining(tuple(trainings), tuple(outputs))


def _begins_elsewhere(
    model: families_kit.CoupledModel,
    records: Sequence[Recording],
    u: Sequence[Array],
    y: Sequence[Array],
    ends: Sequence[int],
    known: Sequence[Mask],
) -> bool:
    """Whether a log does not begin at rest: samples before the memory is known are missed by far more than others."""
    early, later = [], []
    for record, inputs, outputs, end, at in zip(records, u, y, ends, known, strict=True):
        for piece in _pieces(record, end):
            begun = model.rested(inputs[piece.start].tolist())
            time = None if record.time is None else record.time[piece]
            square = (begun.simulate(inputs[piece], time) - outputs[piece]) ** 2
            early.append(square[~at[piece]])
            later.append(square[at[piece]])
    of_early, of_later = np.concatenate(early), np.concatenate(later)
    if not of_early.size or not of_later.size:
        return False
    return bool(np.any(of_early.mean(axis=0) > POLICY.begins_elsewhere**2 * of_later.mean(axis=0)))


def _judged(
    model: families_kit.CoupledModel,
    fitted: families_kit.FittedCoupled,
    records: tuple[Recording, ...],
    u: Sequence[Array],
    y: Sequence[Array],
    ends: Sequence[int],
) -> CoupledFit:
    """Simulate forward and back along the records, and compare on held-out samples."""
    ranges = np.array([_span(y, j) for j in range(len(model.outputs))])
    errors = []
    for rival in (model, fitted.alone, fitted.curves):
        errors.append(PERCENT * _forward_error(rival, records, u, y, ends) / ranges)
    results, findings = [], []
    for j, (card, one) in enumerate(zip(model.outputs, fitted.outputs, strict=True)):
        own = model.inputs[model.own[j]].name
        test, alone, curve = (float(error[j]) for error in errors)
        effects = _effects(model, records, u, j)
        results.append(
            CoupledOutput(card.name, card.unit, own, effects, test, alone, curve, one.terms)
        )
        if not test < alone:
            findings.append(
                Finding(
                    "coupling-not-shown",
                    f"on held-out samples {card.name} errs by {test:.2f} % of range with all inputs and by "
                    f"{alone:.2f} % with {own} alone: this log does not show what the other inputs do to it. "
                    f"Log longer, each input over its range alone first and then all together, or model {card.name} by "
                    f"{own} as its only input.",
                )
            )
    pair = len(model.outputs) == 2 and len(model.inputs) == 2
    return CoupledFit(
        model,
        tuple(results),
        _input_errors(model, records, u, y, ends),
        model.determinant if pair else None,
        max(one.kkt for one in fitted.outputs),
        (*(finding for record in records for finding in record.findings), *findings),
    )


def _forward_error(
    model: families_kit.CoupledModel,
    records: Sequence[Recording],
    u: Sequence[Array],
    y: Sequence[Array],
    ends: Sequence[int],
) -> Array:
    """Rms of what a model misses of each output on held-out samples, (m,). [outputs]"""
    misses = []
    for time, inputs, outputs, first in _parts_of(records, u, y, ends):
        begun = model.rested(inputs[0].tolist())
        misses.append((begun.simulate(inputs, time) - outputs)[first:])
    return np.asarray(np.sqrt(np.mean(np.concatenate(misses) ** 2, axis=0)))


def _input_errors(
    model: families_kit.CoupledModel,
    records: Sequence[Recording],
    u: Sequence[Array],
    y: Sequence[Array],
    ends: Sequence[int],
) -> dict[str, float]:
    """Input -> rms of what the inverse asks for, less what was applied, on held-out samples; percent of range."""
    if model.no_inverse:
        return {}
    misses = []
    for time, inputs, outputs, first in _parts_of(records, u, y, ends):
        begun = model.rested(inputs[0].tolist())
        misses.append((_demand(begun, inputs, outputs, time) - inputs)[first:])
    rms = np.sqrt(np.mean(np.concatenate(misses) ** 2, axis=0))
    solved = range(len(model.inputs)) if len(model.outputs) > 1 else model.own
    errors = {}
    for i in solved:
        span = _span(u, i)
        errors[model.inputs[i].name] = float(PERCENT * rms[i] / span)
    return errors


def _columns(
    records: Sequence[Recording], names: Sequence[str], ends: Sequence[int]
) -> tuple[list[Array], Array]:
    """Signals of each recording side by side, (T, n), and those of all fitted samples in one piece."""
    whole, fitted = [], []
    for record, end in zip(records, ends, strict=True):
        values = np.column_stack([_signal(record, name) for name in names])
        whole.append(values)
        fitted.append(values[:end])
    return whole, np.concatenate(fitted)


def _span(signals: Sequence[Array], column: int) -> float:
    """Range of one signal over all recordings."""
    return robust_range([values[:, column] for values in signals])


def _parts_of(
    records: Sequence[Recording], u: Sequence[Array], y: Sequence[Array], ends: Sequence[int]
) -> Iterator[tuple[Array | None, Array, Array, int]]:
    """Yield time, inputs and outputs of each piece, and its first sample that is scored: the first one held out."""
    tested = any(end < len(record) for record, end in zip(records, ends, strict=True))
    for record, inputs, outputs, end in zip(records, u, y, ends, strict=True):
        for piece in record.pieces:
            time = None if record.time is None else record.time[piece]
            first = max(end - piece.start, 0) if tested else 0
            if first < piece.stop - piece.start:
                yield time, inputs[piece], outputs[piece], first


def _demand(model: families_kit.CoupledModel, u: Array, y: Array, time: Array | None) -> Array:
    """Inputs that the inverse asks for along measured outputs, within what was applied, as an actuator would."""
    known = {}
    if len(model.outputs) == 1:
        for i, card in enumerate(model.inputs):
            if i != model.own[0]:
                known[card.name] = u[:, i]
    demand = model.inverse().simulate(y, time, **known)
    return np.asarray(np.clip(demand, u.min(axis=0), u.max(axis=0)))


def _effects(
    model: families_kit.CoupledModel, records: Sequence[Recording], u: Sequence[Array], output: int
) -> dict[str, float]:
    """How far each input alone moves an output along the recordings, highest less lowest; negative where it falls."""
    effects = {}
    for i, card in enumerate(model.inputs):
        path = model.paths[output][i]
        parts = []
        for record, values in zip(records, u, strict=True):
            for piece in record.pieces:
                x = np.ascontiguousarray(path.scaling.inward(values[piece, i]))
                steps = steps_of(record, piece.start, x.size) if path.rate_dependent else None
                parts.append(path.run(x, steps, path.rest(float(x[0])))[0])
        rises = model.slopes[output][i][0] * np.sign(path.scaling.amplitude)
        effects[card.name] = float(rises * robust_range(parts) * abs(path.scaling.amplitude))
    return effects


def _check_names(
    records: Sequence[Recording], inputs: Sequence[str], outputs: Sequence[str]
) -> None:
    """Refuse signals that are none, or too many of them."""
    names = [*inputs, *outputs]
    if len(inputs) < 2 or len(outputs) not in (1, 2) or len(set(names)) < len(names):
        raise ParameterError(
            f"{len(inputs)} inputs and {len(outputs)} outputs, {', '.join(names) or 'none'}: pass two or more inputs "
            f'and one or two outputs, each once: identify(recording, input=["a", "b"], output=["x", "y"]). For one '
            f"input leave both out.",
            inputs=list(inputs),
            outputs=list(outputs),
        )
    for record in records:
        known = [record.input_name, record.output_name, *record.schedules]
        missing = [name for name in names if name not in known]
        if missing:
            raise ParameterError(
                f"recording '{record.name}' has no signal {missing[0]!r:.60}; it has {', '.join(known)}. Read further "
                f'columns with read_log(..., schedules=["{missing[0]}"]), or pass Recording(..., '
                f'schedules={{"{missing[0]}": values}}).',
                missing=missing,
            )


def _check_motion(u: Array, inputs: Sequence[str], y: Array, outputs: Sequence[str]) -> None:
    """Refuse signals that stand still, and inputs that move together."""
    for values, names in ((u, inputs), (y, outputs)):
        for name, column in zip(names, values.T, strict=True):
            if not np.ptp(column) > 1e-12 * np.max(np.abs(column)):
                raise ExcitationError(
                    f"'{name}' stays at {column[0]:g} in what is fitted, so that nothing tells its effect. Log a "
                    f"motion in which every input goes over its range, also alone.",
                    signal=name,
                )
    centered = u - u.mean(axis=0)
    for i, name in enumerate(inputs):
        others = np.delete(centered, i, axis=1)
        explained = others @ np.linalg.lstsq(others, centered[:, i], rcond=None)[0]
        left = float(np.std(centered[:, i] - explained) / np.std(centered[:, i]))
        if left < POLICY.inputs_apart:
            raise ExcitationError(
                f"'{name}' moves together with the other inputs: all but {PERCENT * left:.1g} % of its motion "
                f"follows from theirs, and {PERCENT * POLICY.inputs_apart:g} % or more must be its own. Their effects "
                f"cannot be told apart. Log a motion in which the inputs move at different times or frequencies.",
                signal=name,
                share=left,
            )


def _signal(record: Recording, name: str) -> Array:
    if name == record.input_name:
        return record.input
    if name == record.output_name:
        return record.output
    return record.schedules[name]


def _unit(record: Recording, name: str) -> str:
    if name == record.input_name:
        return record.input_unit
    if name == record.output_name:
        return record.output_unit
    return record.schedule_units[name]


def _cards(record: Recording, names: Sequence[str], values: Array) -> tuple[SignalCard, ...]:
    cards = []
    for name, column in zip(names, values.T, strict=True):
        cards.append(
            SignalCard(name, _unit(record, name), float(column.min()), float(column.max()))
        )
    return tuple(cards)


def _middle(values: Array) -> tuple[list[float], list[float]]:
    """Middle and half of the range of each column."""
    low, high = values.min(axis=0), values.max(axis=0)
    return (0.5 * (low + high)).tolist(), (0.5 * (high - low)).tolist()


def _pieces(record: Recording, end: int) -> list[slice]:
    """Pieces of continuous memory, up to a last sample."""
    pieces = []
    for piece in record.pieces:
        if piece.start < end:
            pieces.append(slice(piece.start, min(piece.stop, end)))
    return pieces


def _counted(record: Recording) -> Mask:
    counts = np.ones(len(record), dtype=np.bool_)
    counts[list(record.left_out)] = False
    return counts


def _known(record: Recording, u: Array, end: int, half: Sequence[float]) -> Mask:
    """Samples from which on every input went over most of its range, so that nothing before the log counts.

    Of a piece of which that is less than half all samples are taken.
    """
    known = np.ones(len(u), dtype=np.bool_)
    for piece in _pieces(record, end):
        part = u[piece]
        gone = np.maximum.accumulate(part) - np.minimum.accumulate(part)
        reached = np.all(gone >= 2.0 * SEEN * np.asarray(half), axis=1)
        first = int(np.argmax(reached)) if reached.any() else len(part)
        if 2 * first <= len(part):
            known[piece.start : piece.start + first] = False
    return known


def _stretches(record: Recording, x: Array, counts: Mask, end: int) -> list[Stretch]:
    stretches = []
    for piece in _pieces(record, end):
        part = np.ascontiguousarray(x[piece])
        dt = steps_of(record, piece.start, part.size)
        stretches.append(Stretch(part, np.zeros(part.size), dt, counts[piece]))
    return stretches


def _period(records: Sequence[Recording]) -> float:
    """Median time between samples; 0 without time stamps. [s]"""
    steps = []
    for record in records:
        for piece in record.pieces:
            if record.time is not None:
                steps.append(np.diff(record.time[piece]))
    return float(f"{float(np.median(np.concatenate(steps))):.9g}") if steps else 0.0
