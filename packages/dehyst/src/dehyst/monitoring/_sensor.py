"""Runs a saved model over the readings of a sensor, on what it was not fitted to."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from dehyst.data import MINIMUM_SAMPLES, Recording, require_recordings
from dehyst.errors import ExcitationError, UnitError
from dehyst.findings import Finding
from dehyst.identification import known_from
from dehyst.models import Model, SignalCard
from dehyst.monitoring._logs import fitted_share, recording_in_units_of


@dataclass(frozen=True, eq=False)
class CorrectedReadings:
    """Readings of a sensor before and after a model has corrected them.

    Attributes
    ----------
    before, after
        The same samples of each recording: input the reading, and the corrected one in the unit of the quantity.
    held_out
        Whether the model was fitted to other samples of these recordings, which are left out.
    findings
        What converting units found.
    """

    before: tuple[Recording, ...]
    after: tuple[Recording, ...]
    held_out: bool
    findings: tuple[Finding, ...]


def corrected_readings(
    model: Model, recordings: Recording | Sequence[Recording]
) -> CorrectedReadings:
    """Correct the readings of a sensor, x, by a model of the quantity, z = y[x].

    A model of the reading as a function of the quantity corrects by its inverse. Left out are samples that the model
    was fitted to, and, as in `evaluate`, those before the reading has visited both ends of its range, where that leaves
    half: nothing is known of the past of the sensor there.

    Parameters
    ----------
    model
        From the reading to the quantity, or the other way, as the names of its signals say.
    recordings
        One, or several: input the reading, output the quantity.

    Raises
    ------
    UnitError
        If a unit cannot be converted to that of the model.
    ExcitationError
        If the model was fitted to all samples.
    InvertibilityError
        If a model of the reading has no inverse.
    ParameterError
        If the model needs a signal that a recording does not hold.

    Examples
    --------
    >>> import numpy as np
    >>> import dehyst
    >>> reading = 2.0 * np.sin(np.linspace(0.0, 20.0, 400))
    >>> model = dehyst.PrandtlIshlinskii([0.0], [0.5])
    >>> readings = corrected_readings(model, Recording(reading, 0.5 * reading))
    >>> bool(np.allclose(readings.after[0].input, 0.5 * reading)), readings.held_out
    (True, False)
    """
    records = require_recordings(recordings)
    identified = model
    from_quantity = model.card.output.name == records[0].input_name != model.card.input.name
    if from_quantity:
        model = model.inverse()
    card = model.card
    before, after = [], []
    findings: dict[Finding, None] = {}
    held_out = False
    for record in records:
        logged = record
        if from_quantity:
            logged = _swapped(record)
        share = fitted_share(identified, logged) or 0.0
        fitted = range(round(share * len(record)))
        # What is fitted shows less of its errors; it still tells the model the past of the rest.
        if len(fitted) > len(record) - MINIMUM_SAMPLES:
            continue
        held_out = held_out or len(fitted) > 0
        converted, unit_findings, why = recording_in_units_of(
            record, (card.input, card.output), model.context
        )
        if why:
            raise UnitError(f"the model cannot correct {record.name}: {why}.")
        findings.update(dict.fromkeys(unit_findings))
        left_out = (*fitted, *_unknown_past(converted, card.input), *record.left_out)
        before.append(replace(record, left_out=left_out))
        after.append(replace(_corrected(model, converted), left_out=left_out))
    if not before:
        raise ExcitationError(
            "the model was fitted to all samples of this log, so that none can show what it is worth. Name a log that "
            "it was not identified from, or identify anew with a part held out: --train-fraction 0.5."
        )
    return CorrectedReadings(tuple(before), tuple(after), held_out, tuple(findings))


def _swapped(record: Recording) -> Recording:
    """The recording as it was when the quantity was the input."""
    origin = dict(record.provenance)
    origin["input"], origin["output"] = origin.get("output"), origin.get("input")
    return replace(record, input=record.output, output=record.input, provenance=origin)


def _unknown_past(record: Recording, card: SignalCard) -> list[int]:
    """Samples before both ends of the range were visited, where that leaves half: there the past counts."""
    samples: list[int] = []
    if card.low is None or card.high is None:
        return samples
    for piece in record.pieces:
        known = piece.start + known_from(record.input[piece], card.low, card.high)
        samples += range(piece.start, min(known, piece.stop))
    if 2 * len(samples) > len(record):
        return []
    return samples


def _corrected(model: Model, record: Recording) -> Recording:
    """The recording with the corrected reading, piece by piece: after a break nothing is known of the past."""
    parts = []
    for piece in record.pieces:
        time = None
        if record.time is not None:
            time = record.time[piece]
        signals = record.signals(model.needs, piece)
        parts.append(model.simulate(record.input[piece], time, **signals))
    unit = model.card.output.unit or record.output_unit
    return replace(
        record,
        input=np.concatenate(parts),
        input_name=f"corrected {record.input_name}",
        input_unit=unit,
    )
