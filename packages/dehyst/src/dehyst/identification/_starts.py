"""Starts of many short pieces: what the actuator did before each is estimated, so that all of their samples count.

A short piece that begins anywhere does not show its memory, and a start state that is the same for all of them is wrong
for most. So strokes before its first sample are looked for, with a model that was fitted before
(`dehyst.models.kit.known_past`), the model is fitted again behind these, and so on. This is taken where it lowers the
error of pieces that are left out whole, whose first part tells their start, as it does in use.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from dehyst.arrays import Array
from dehyst.errors import DehystError
from dehyst.families import LoopModel, Stretch, Training
from dehyst.identification._data import Piece
from dehyst.identification._memory import known_from
from dehyst.identification._policy import POLICY
from dehyst.identification._prepared import PieceStart, Prepared
from dehyst.identification._training import stretch_of
from dehyst.models import kit as models_kit

Fitting = Callable[[Training], LoopModel]


class _Begun(NamedTuple):
    """A stretch with the strokes before it, and the mean squared error after the samples that told them, scaled."""

    stretch: Stretch
    error: float


def with_starts(log: Prepared, model: LoopModel, fit: Fitting) -> Prepared | None:
    """Return the log with the starts of its short pieces; None where there are few, or it does not pay.

    Parameters
    ----------
    log
        As it was fitted without.
    model
        Fitted to it.
    fit
        Fits such a model to another training.
    """
    pieces = log.data.pieces
    fitted = [k for k, piece in enumerate(pieces) if piece.split]
    # Numbers of stretches of the training: these are the pieces of which something is fitted, in their order.
    short = [n for n, k in enumerate(fitted) if _is_short(pieces[k])]
    samples = sum(pieces[fitted[n]].split for n in short)
    if len(short) < POLICY.pieces or 2 * samples < sum(piece.split for piece in pieces):
        return None
    plain = log.training(0)
    stretches = list(plain.stretches)
    for n in short:
        piece = pieces[fitted[n]]
        weight = plain.stretches[n].weight
        stretches[n] = replace(stretch_of(log.records, piece, piece.split), weight=weight)
    every = replace(plain, stretches=tuple(stretches), shared=[])
    try:
        if not _pays(plain, every, short, fit):
            return None
        begun = _rounds(every, short, fit, model)
        starts = {}
        for n in short:
            lead = begun.stretches[n].lead
            assert lead is not None
            starts[fitted[n]] = PieceStart(lead, 0)
        model = fit(begun)
        for k, piece in enumerate(pieces):
            if piece.split or not _is_short(piece):
                continue
            first = _first_part(piece.x.size)
            stretch = stretch_of(log.records, piece, first)
            lead = _started(stretch, every, model, first).stretch.lead
            assert lead is not None
            starts[k] = PieceStart(lead, first)
    except DehystError:
        return None
    return replace(log, starts=starts)


def _is_short(piece: Piece) -> bool:
    """Whether a piece shows its whole memory late or never."""
    return 2 * known_from(piece.x, -1.0, 1.0) > piece.x.size >= POLICY.least_piece


def _first_part(size: int) -> int:
    return round(POLICY.first_part * size)


def _pays(plain: Training, every: Training, short: Sequence[int], fit: Fitting) -> bool:
    """Whether starts lower the error of pieces that are left out, every other one in turn.

    `every` has all samples of the `short` stretches, `plain` those that count without their starts.
    """
    without = with_starts = 0.0
    for half in (0, 1):
        left_out = short[half::2]
        remaining = [n for n in range(len(plain.stretches)) if n not in left_out]
        still_short = [place for place, n in enumerate(remaining) if n in short]
        first = fit(_some(plain, remaining))
        begun = fit(_rounds(_some(every, remaining), still_short, fit, first))
        for n in left_out:
            stretch = every.stretches[n]
            samples = _first_part(stretch.x.size)
            without += stretch.weight * _started(stretch, every, first, samples).error
            with_starts += stretch.weight * _started(stretch, every, begun, samples).error
    return bool(with_starts < POLICY.starts_worth**2 * without)


def _some(training: Training, numbers: Sequence[int]) -> Training:
    return replace(training, stretches=tuple(training.stretches[n] for n in numbers), shared=[])


def _rounds(every: Training, short: Sequence[int], fit: Fitting, model: LoopModel) -> Training:
    """Return the training with strokes before its short stretches: estimated, fitted, and estimated again."""
    begun = every
    for number in range(POLICY.rounds_of_starts):
        if number:
            model = fit(begun)
        stretches = list(every.stretches)
        for n in short:
            stretch = every.stretches[n]
            stretches[n] = _started(stretch, every, model, stretch.x.size).stretch
        begun = replace(every, stretches=tuple(stretches), shared=[])
    return begun


def _started(stretch: Stretch, training: Training, model: LoopModel, samples: int) -> _Begun:
    """Return a stretch with the strokes before it that explain its first samples best, so many as `samples` says."""
    scaling = training.scaling
    x = scaling.center + scaling.half_range * stretch.x
    y = np.where(stretch.counts, scaling.outward(stretch.y), np.nan)
    time = None if stretch.dt is None else stretch.time
    signals: dict[str, Array] = {}
    if stretch.scheduling is not None:
        for source, (name, _) in enumerate(training.signals):
            if name in model.needs:
                signals[name] = stretch.scheduling[:, source]

    def rest_of(part: slice) -> tuple[Array | None, Mapping[str, Array]]:
        at = None if time is None else time[part]
        return at, {name: values[part] for name, values in signals.items()}

    known, after = slice(0, samples), slice(samples, None)
    past = models_kit.known_past(model, x[known], y[known], *rest_of(known))
    strokes = past.strokes
    held = {name: np.full(strokes.size, values[0]) for name, values in signals.items()}
    stamps = None
    if time is not None:
        stamps = (training.period or 1.0) * np.arange(strokes.size)
    # A sum of outputs sees those of the strokes: they are the model's own.
    outputs = model.at_rest(float(strokes[0])).simulate(strokes, stamps, **held)
    lead = np.column_stack([scaling.inward(strokes), scaling.swapped().inward(outputs)])
    begun = replace(stretch, lead=lead)
    if samples >= x.size:
        return _Begun(begun, 0.0)
    stamps, signals_after = rest_of(after)
    miss = (past.model.simulate(x[after], stamps, **signals_after) - y[after]) / scaling.amplitude
    return _Begun(begun, float(np.nanmean(miss**2)))
