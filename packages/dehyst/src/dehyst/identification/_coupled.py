"""identify(..., input=[...], output=[...]): sums over several inputs from logs in which they move together."""

from __future__ import annotations

from collections.abc import Sequence
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
    test_percent
        On held-out samples; on all samples if none were held out.
    left_out_percent, alone_percent, curve_percent
        On what was left out of the fitted part in turn: of the model, of the own input alone, and of curves of all
        inputs without memory.
    terms
        Groups of elements of its sums.
    """

    name: str
    unit: str
    own: str
    effects: dict[str, float]
    test_percent: float
    left_out_percent: float
    alone_percent: float
    curve_percent: float
    terms: tuple[str, ...]


@dataclass(frozen=True)
class CoupledFit:
    """A model of several inputs, and how good it is.

    Attributes
    ----------
    model
        `dehyst.families.CoupledModel`.
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
            f"{self.determinant:.2g} of the ranges."
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
        lines = [f"{len(self.model.inputs)} inputs, {self.model.free_parameters} numbers"]
        for one in self.outputs:
            effects = ", ".join(f"{name} {effect:+.3g}" for name, effect in one.effects.items())
            lines.append(
                f"{one.name}: {one.test_percent:.2f} % of range held out; own input alone {one.alone_percent:.2f}, "
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
    if not any(ends):
        raise ParameterError("nothing is fitted; pass a train_fraction above 0.")
    u = [np.column_stack([_signal(record, name) for name in inputs]) for record in records]
    y = [np.column_stack([_signal(record, name) for name in outputs]) for record in records]
    fitted_u = np.concatenate([values[:end] for values, end in zip(u, ends, strict=True)])
    fitted_y = np.concatenate([values[:end] for values, end in zip(y, ends, strict=True)])
    _check_motion(fitted_u, inputs, fitted_y, outputs)
    center, half = _middle(fitted_u)
    level, amplitude = _middle(fitted_y)
    counts = [
        _counted(record, values, end, half)
        for record, values, end in zip(records, u, ends, strict=True)
    ]
    trainings = []
    for i in range(len(inputs)):
        stretches = []
        for record, values, counted, end in zip(records, u, counts, ends, strict=True):
            stretches += _stretches(record, (values[:, i] - center[i]) / half[i], counted, end)
        trainings.append(
            Training(tuple(stretches), Scaling(center[i], half[i], level[0], amplitude[0]), "none")
        )
    scaled = []
    for j in range(len(outputs)):
        parts = []
        for record, values, end in zip(records, y, ends, strict=True):
            for piece in _pieces(record, end):
                parts.append((values[piece, j] - level[j]) / amplitude[j])
        scaled.append(tuple(parts))
    scalings = []
    for j in range(len(outputs)):
        scalings.append(
            [Scaling(center[i], half[i], level[j], amplitude[j]) for i in range(len(inputs))]
        )
    training = families_kit.CoupledTraining(tuple(trainings), tuple(scaled))
    period = _period(records)
    with single_blas():
        fitted = families_kit.fit_coupled(
            training,
            _cards(records[0], inputs, fitted_u),
            _cards(records[0], outputs, fitted_y),
            scalings,
            u[0][0].tolist(),
            period,
        )
    provenance = {
        "log": records[0].name, "inputs": list(inputs), "outputs": list(outputs), "dehyst": __version__,
        "date": date.today().isoformat(),
    }  # fmt: skip
    model = fitted.model
    model = model.with_card(ModelCard(model.inputs[0], model.outputs[0], provenance))
    return _judged(model, fitted, records, u, y, ends)


def _judged(
    model: families_kit.CoupledModel,
    fitted: families_kit.FittedCoupled,
    records: tuple[Recording, ...],
    u: Sequence[Array],
    y: Sequence[Array],
    ends: Sequence[int],
) -> CoupledFit:
    """Simulate forward and back along the records, and compare on held-out samples."""
    tested = [end < len(record) for record, end in zip(records, ends, strict=True)]
    misses, input_misses = [], []
    for record, inputs, outputs, end in zip(records, u, y, ends, strict=True):
        for piece in record.pieces:
            begun = model.rested(inputs[piece.start].tolist())
            time = None if record.time is None else record.time[piece]
            part = slice(max(end - piece.start, 0) if any(tested) else 0, None)
            misses.append((begun.simulate(inputs[piece], time) - outputs[piece])[part])
            if not model.no_inverse:
                demand = _demand(begun, inputs[piece], outputs[piece], time)
                input_misses.append((demand - inputs[piece])[part])
    ranges = [robust_range([values[:, j] for values in y]) for j in range(len(model.outputs))]
    rms = PERCENT * np.sqrt(np.mean(np.concatenate(misses) ** 2, axis=0)) / ranges
    input_percent = {}
    if input_misses:
        input_ranges = [
            robust_range([values[:, i] for values in u]) for i in range(len(model.inputs))
        ]
        back = PERCENT * np.sqrt(np.mean(np.concatenate(input_misses) ** 2, axis=0)) / input_ranges
        names = [card.name for card in model.inputs]
        if len(model.outputs) == 1:
            names = [names[model.own[0]]]
            back = back[[model.own[0]]]
        input_percent = dict(zip(names, back.tolist(), strict=True))
    results = []
    for j, (card, one) in enumerate(zip(model.outputs, fitted.outputs, strict=True)):
        share = PERCENT * abs(model.paths[j][0].scaling.amplitude) / ranges[j]
        results.append(
            CoupledOutput(
                card.name,
                card.unit,
                model.inputs[model.own[j]].name,
                _effects(model, records, u, j),
                float(rms[j]),
                share * one.score,
                share * one.alone_score,
                share * one.curve_score,
                one.terms,
            )
        )
    pair = len(model.outputs) == 2 and len(model.inputs) == 2
    return CoupledFit(
        model,
        tuple(results),
        input_percent,
        model.determinant if pair else None,
        max(one.kkt for one in fitted.outputs),
        tuple(finding for record in records for finding in record.findings),
    )


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
                f"'{name}' moves together with the other inputs: only {PERCENT * left:.1g} % of it are its own, and "
                f"{PERCENT * POLICY.inputs_apart:g} % are needed. Their effects cannot be told apart. Log a motion in "
                f"which the inputs move at different times or frequencies.",
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


def _counted(record: Recording, u: Array, end: int, half: Sequence[float]) -> Mask:
    """Which samples count in a fit: those after every input went over most of its range, if half of a piece is left."""
    counts = np.ones(len(u), dtype=np.bool_)
    counts[list(record.left_out)] = False
    for piece in _pieces(record, end):
        part = u[piece]
        gone = np.maximum.accumulate(part) - np.minimum.accumulate(part)
        known = np.all(gone >= 2.0 * SEEN * np.asarray(half), axis=1)
        first = int(np.argmax(known)) if known.any() else len(part)
        if 2 * first <= len(part):
            counts[piece.start : piece.start + first] = False
    return counts


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
