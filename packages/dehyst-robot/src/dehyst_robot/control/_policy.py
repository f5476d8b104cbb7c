"""The thresholds by which a model is refused as a compensator or as a mechanism: one record, each with its reason."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class CompensatorPolicy:
    """Numbers that decide which models a joint takes.

    Shares are of the box of a loop, between 0 and 1.
    """

    # A model whose loop gives back more work than this lags its input: it was not inverted, and would double the
    # hysteresis; below it is rounding.
    lagging: float = 1e-3
    # A mechanism whose loop gives more work than this would be a motor; less is rounding.
    giving: float = 1e-6


POLICY = CompensatorPolicy()
