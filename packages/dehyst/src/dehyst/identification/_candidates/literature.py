"""Families of the literature and rows of elements as candidates: models with a start state."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from dehyst.arrays import Array, Mask
from dehyst.data import Recording
from dehyst.data import kit as data_kit
from dehyst.errors import IdentificationError
from dehyst.families import ROW_NAMES, LoopModel, Stretch, Training, first_input
from dehyst.families import family as family_of
from dehyst.families import kit as families_kit
from dehyst.findings import Finding
from dehyst.identification._candidate import BlockErrors, Outcome
from dehyst.identification._cautions import Knows
from dehyst.identification._data import DataSet, Piece, input_range
from dehyst.identification._evidence import beyond_rests, without_holds
from dehyst.identification._fit import Certificate, ComparedSetting
from dehyst.identification._prepared import Prepared
from dehyst.identification._scores import Measured, scored_parts
from dehyst.identification._selection import BLOCKS
from dehyst.identification._starts import with_starts
from dehyst.identification._training import stretch_of
from dehyst.models import StaticCurve

PROGRAM = "normal equations of the columns"
SEARCH = "its own search"
# Samples of the round trip, and of another speed: they say as much as a whole log.
MOST_PLAYED = 20_000


@dataclass(frozen=True)
class Literature:
    """A family of the registry: a row of elements, or a model of the literature.

    Attributes
    ----------
    family
        Its name.
    seed
        Of the search, where the fit is not convex.
    purpose
        "compensate" or "simulate".
    size
        Largest number of numbers of a row of elements; None for as many as it takes.
    """

    family: str
    seed: int = 0
    purpose: str = "compensate"
    size: int | None = None

    def fit(self, log: Prepared) -> Outcome:
        """Fit to the whole of the fitted part."""
        chosen = family_of(self.family)
        training = log.training(self.seed)
        made = None
        model: LoopModel
        if self.family in ROW_NAMES:
            row = families_kit.row_named(self.family, training, self.size)
            begun = with_starts(log, row.model, self._fitted)
            if begun is not None:
                log = begun
                row = families_kit.row_named(self.family, log.training(self.seed), self.size)
            model, made = row.model, row.terms
        else:
            model = chosen.fit(training)
        settings: dict[str, Any] = {**settings_of(self.family, log), "purpose": self.purpose}
        if not chosen.convex:
            settings["seed"] = self.seed
        if self.size is not None:
            settings["size"] = self.size
        terms = model.free_parameters
        return loop_outcome(log, model, settings, log.curve(), terms, terms, made=made)

    def _fitted(self, training: Training) -> LoopModel:
        if self.family in ROW_NAMES:
            return families_kit.row_named(self.family, training, self.size).model
        return family_of(self.family).fit(training)

    def block_errors(self, log: Prepared) -> BlockErrors:
        """Fit five times, each time without the outputs of one fold; the memory sees its inputs all the same."""
        training = log.training(self.seed)
        ends = np.cumsum([stretch.counts.size for stretch in training.stretches])[:-1]
        measured = np.concatenate([stretch.y for stretch in training.stretches])
        output_errors = []
        input_errors = []
        signals = [stretch.x for stretch in training.stretches]
        share = np.concatenate(
            data_kit.shares_of(signals, [stretch.counts for stretch in training.stretches])
        )
        fold = data_kit.folds_of(share)[0]
        for number in range(BLOCKS):
            left_out = (fold == number) & (share > 0.0)
            if not left_out.any():
                continue
            stretches = []
            for stretch, inside in zip(training.stretches, np.split(left_out, ends), strict=True):
                stretches.append(replace(stretch, counts=stretch.counts & ~inside))
            model = self._fitted(replace(training, stretches=tuple(stretches), shared=[]))
            miss = np.concatenate(training.simulate(model)) - measured
            output_errors.append(_rms(miss, left_out, share))
            if model.no_inverse:
                input_errors.append(np.nan)
            else:
                input_miss = _input_misses(training, model)
                input_errors.append(_rms(input_miss, left_out, share))
        return BlockErrors(
            output=log.data.amplitude * np.array(output_errors),
            input=log.data.half_range * np.array(input_errors),
            nonzero_weights=model.nonzero_weights,
            inverse_gain=model.inverse_gain,
        )


def _rms(miss: Array, rows: Mask, share: Array) -> float:
    return float(np.sqrt(np.average(miss[rows] ** 2, weights=share[rows])))


def _input_misses(training: Training, model: LoopModel) -> Array:
    """Input that the inverse asks for less the applied one along all stretches, scaled."""
    misses = []
    for stretch in training.stretches:
        first = first_input(model, float(stretch.y[0]), **stretch.surroundings(model))
        misses.append(stretch.run_inverse(model, first) - stretch.x)
    return np.concatenate(misses)


def settings_of(family: str, log: Prepared) -> dict[str, Any]:
    """Settings of a family that has none, as plain values: those of plays are 0, and their grid is not used."""
    grid = {"n": 0, "eps": 0.0, "thresholds": "grid", "initial_state": "auto"}
    return {"family": family, **grid, **log.settings}


def loop_outcome(
    log: Prepared,
    model: LoopModel,
    settings: dict[str, Any],
    static: StaticCurve,
    carrying: int,
    offered: int,
    kkt: float = float("nan"),
    compared: tuple[ComparedSetting, ...] = (),
    made: families_kit.Terms | None = None,
) -> Outcome:
    """Return the outcome of a model with a start state.

    Parameters
    ----------
    carrying, offered
        How many terms carry weight, and of how many.
    kkt
        Violation of the optimality conditions of its weights, relative; not a number for a search.
    compared
        What it was chosen from.
    made
        Of which terms it was made; None where it is no sum.
    """
    # Only the normal equations of a convex fit have conditions of optimality.
    route = SEARCH
    if np.isfinite(kkt):
        route = PROGRAM
    form = None
    if made is not None:
        form = made.form
    certificate = Certificate(
        kkt_residual=kkt,
        inverse_gain=model.inverse_gain,
        nonzero_weights=carrying,
        operators=offered,
        initial_state=str(model.start),
        route=route,
    )
    return Outcome(
        family=model.family,
        model=model,
        settings=settings,
        certificate=certificate,
        measure=lambda turns: _measured(log, model, static, turns),
        static=static,
        knows=Knows(leads=True, crosses=True, time=model.rate_dependent, turns=model.winged),
        compared=compared,
        remarks=lambda measured: _remarks(log, model, measured),
        form=form,
    )


def _remarks(log: Prepared, model: LoopModel, measured: Measured) -> Iterator[Finding]:
    """What rests and another speed do to a model that depends on time."""
    record = log.records[0]
    played = slice(0, MOST_PLAYED)
    x, time, signals = record.input[played], record.time, record.signals(model.needs, played)
    if time is None or not model.rate_dependent:
        return
    time = time[played]
    span = input_range(log.records)

    def simulate(x: Array, time: Array) -> Array:
        return model.simulate(x, time, **signals)

    yield from without_holds(measured.evidence, lambda at: simulate(x, at), time, span)
    # What rests add is tried on a longer time than the signals of the log cover.
    if not signals:
        yield from beyond_rests(x, time, simulate, log.data.output_range)


def _measured(log: Prepared, model: LoopModel, static: StaticCurve, turns: int) -> Measured:
    records, data = log.records, log.data
    outputs = predicted(model, records, data)
    if not all(np.all(np.isfinite(y)) for y in outputs):
        raise IdentificationError(f"the fitted {model.family} model diverges on the held-out part.")
    demands = tuple(np.full(len(record), np.nan) for record in records)
    trip = float("nan")
    if not model.no_inverse:
        demands = demanded(model, records, data)
        trip = _round_trip(model, records[0])
    scored = scored_parts(records, data, str(model.start))
    return log.measure.compared(data, scored, outputs, demands, trip, static, turns)


def _round_trip(model: LoopModel, record: Recording) -> float:
    """Largest difference after model and inverse, either way round, relative to the ranges."""
    played = slice(0, MOST_PLAYED)
    x, time, signals = record.input[played], record.time, record.signals(model.needs, played)
    if time is not None:
        time = time[played]
    model = model.prompt
    y = model.simulate(x, time, **signals)
    back = model.inverse().simulate(y, time, **signals)
    again = model.simulate(back, time, **signals)
    return max(_relative_miss(back, x), _relative_miss(again, y))


def _relative_miss(result: Array, goal: Array) -> float:
    return float(np.max(np.abs(result - goal)) / max(np.ptp(goal), 1e-300))


def predicted(model: LoopModel, records: tuple[Recording, ...], data: DataSet) -> tuple[Array, ...]:
    """Output of a model for each recording; every piece starts from its own memory. [output]"""
    outputs = [np.empty(len(record)) for record in records]
    for piece, stretch in _pieces(records, data):
        f = stretch.run(model)
        outputs[piece.recording][piece.start : piece.start + f.size] = model.scaling.outward(f)
    return tuple(outputs)


def demanded(model: LoopModel, records: tuple[Recording, ...], data: DataSet) -> tuple[Array, ...]:
    """Input that the inverse asks for at the measured output of each recording, known as far ahead as it takes."""
    inputs = [np.empty(len(record)) for record in records]
    for piece, stretch in _pieces(records, data):
        first = first_input(model, float(stretch.y[0]), **stretch.surroundings(model))
        u = stretch.run_inverse(model, first)
        asked = model.ahead(model.scaling.center + model.scaling.half_range * u)
        inputs[piece.recording][piece.start : piece.start + u.size] = asked
    return tuple(inputs)


def _pieces(records: tuple[Recording, ...], data: DataSet) -> Iterator[tuple[Piece, Stretch]]:
    for piece in data.pieces:
        yield piece, stretch_of(records, piece, piece.x.size)
