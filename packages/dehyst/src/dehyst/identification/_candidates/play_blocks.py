"""Errors of plays on what is left out: their sums over a few thousand rows that have every state exactly."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

import dehyst._native as _native
from dehyst.arrays import Array, Rows, rank
from dehyst.errors import ExcitationError
from dehyst.identification._candidate import BlockErrors
from dehyst.identification._families import STATIC, Estimate, Regularisation, build_model
from dehyst.identification._prepared import Prepared
from dehyst.identification._regressors import PlayBank, make_bank
from dehyst.identification._selection import (
    COMPARED_ROWS,
    REGULARISATIONS,
    Choice,
    Folds,
    threshold_grid,
)
from dehyst.identification._short_signal import ShortSignal, shorten
from dehyst.identification._static_curve import FEWEST_ROWS, held_out_errors
from dehyst.models import HysteresisModel, ModelCard


@dataclass(frozen=True)
class _View:
    """A log, shortened for models and for their inverses."""

    log: Prepared
    short: ShortSignal
    outputs: tuple[Array, ...]  # extremes of each piece's output, raw, with the rows among them
    places: tuple[Rows, ...]  # where the rows stand in these
    applied: Array  # input at the rows, raw


def play_block_errors(
    log: Prepared,
    family: str,
    n: int,
    power: float | None,
    eps: float,
    start: str,
    thresholds: Array | None,
) -> BlockErrors:
    """Return the errors of one setting of plays; `eps` is relative to the ratio of the ranges."""
    view = _view(log, "zero")
    if start == "unknown":
        view = _view(log, start)
    if family == STATIC:
        errors = log.data.amplitude * held_out_errors(view.short)
        return BlockErrors(errors, np.full(errors.size, np.nan), 0, float("nan"))
    bank = make_bank(
        log.data, threshold_grid(log.data, n, Choice(family, start, None, power), thresholds), start
    )
    regularisations: tuple[Regularisation | None, ...] = (None,)
    if family == "modified-pi":
        regularisations = REGULARISATIONS
    folds = Folds(view.short, bank, ramps=family == "modified-pi")
    best, errors, chosen, least = None, np.zeros(0), None, np.inf
    for regularisation in regularisations:
        estimates = folds.estimates(Choice(family, start, regularisation, power), eps)
        tried = np.array([error for _, _, error in estimates])
        score = rank(float(np.mean(tried)))
        if best is None or score < least:
            best, errors, chosen, least = estimates, tried, regularisation, score
    assert best is not None  # one regularisation at least was tried
    input_errors = []
    for estimate, rows, _ in best:
        knots = None
        if estimate.slopes is not None:
            knots = folds.knots
        model = build_model(estimate, log.data, bank, knots, ModelCard())
        input_errors.append(_inverse_error(view, bank, model, estimate, rows))
    smoothing = None
    if chosen is not None:
        smoothing = chosen.smoothing
    return BlockErrors(
        output=log.data.amplitude * errors,
        input=np.array(input_errors),
        nonzero_weights=int(np.count_nonzero(best[-1][0].weights)),
        inverse_gain=model.inverse_gain,
        smoothing=smoothing,
    )


def _view(log: Prepared, start: str) -> _View:
    """The shortened log, made once for every setting with a known start, and once for "unknown"."""
    key = ("view of plays", start)
    if key not in log.shared:
        log.shared[key] = _shortened(log, start)
    view: _View = log.shared[key]
    return view


def _shortened(log: Prepared, start: str) -> _View:
    short = shorten(log.data, start, COMPARED_ROWS)
    if short.rows < FEWEST_ROWS:
        raise ExcitationError(
            f"only {short.rows} samples take part, but cross-validation cuts them into five parts and needs "
            f"{FEWEST_ROWS}. Log more, take a larger part (train_fraction), or assume a start whose memory is known.",
            samples=short.rows,
        )
    outputs, places, applied = [], [], []
    for piece, part in zip(log.data.pieces, short.pieces, strict=True):
        record = log.records[piece.recording]
        raw = record.output[piece.start : piece.start + piece.x.size]
        essential, place = _native.essential(np.ascontiguousarray(raw), part.rows)
        outputs.append(raw[essential])
        places.append(place)
        applied.append(record.input[piece.start + part.rows])
    return _View(log, short, tuple(outputs), tuple(places), np.concatenate(applied))


def _inverse_error(
    view: _View, bank: PlayBank, model: HysteresisModel, estimate: Estimate, rows: Rows
) -> float:
    """RMS of x - H^-1[y] at some rows. [input]"""
    asked = np.concatenate(list(_asked(view, bank, model, estimate)))[rows]
    miss = view.applied[rows] - asked
    return float(np.sqrt(np.average(miss**2, weights=view.short.weight[rows])))


def _asked(
    view: _View, bank: PlayBank, model: HysteresisModel, estimate: Estimate
) -> Iterator[Array]:
    """Input that the inverse asks for at the rows of each piece."""
    carrying = estimate.weights != 0.0
    carrying[0] = True
    for y, place, state in zip(view.outputs, view.places, bank.states, strict=True):
        if place.size:
            started = model.with_state(state[carrying] * view.log.data.half_range)
            yield started.inverse().simulate(y)[place]
