"""The thresholds by which an OCV log is judged: one record, each with its reason."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class OcvPolicy:
    """Numbers that decide which strokes are branches and what is told of them.

    Shares are between 0 and 1.
    """

    # A stroke that covers this share of the charge is one of the outer loop.
    outer: float = 0.9
    # The charge turns where it goes back by more than this share of its range; counters flicker by less.
    turn: float = 0.01
    # Slow cycles take hundreds of samples a stroke: a step of this share of the range is a counter that was reset.
    reset: float = 0.2
    # Samples outside of the outer loop that tell a decay rate: fewer are noise. [samples]
    fewest_minor: int = 20
    # A cell stands between these voltages, whatever it is made of; others are in another unit. [V]
    most_voltage: float = 6.0
    # A model that errs by more than this share of what a curve without hysteresis errs by is not worth its state. [-]
    gain: float = 0.9
    # Columns are exchanged if the model of them the other way round errs by less than this share of its own curve:
    # the state of a real electrode does not follow its own inverse so well. [-]
    exchanged: float = 0.5


POLICY = OcvPolicy()
