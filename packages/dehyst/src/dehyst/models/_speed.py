"""Signals that move faster than the log that a model was fitted to."""

from __future__ import annotations

from collections.abc import Sequence

from dehyst.arrays import Array
from dehyst.data import top_speed
from dehyst.findings import Finding
from dehyst.models._card import SignalCard
from dehyst.models._model import Model
from dehyst.models._policy import POLICY
from dehyst.shell import command

# Samples that the planned motion has on the way over the range, at least, and its usual period [s].
SAMPLES, PERIOD = 50.0, 0.02


def faster_than_log(
    model: Model, card: SignalCard, signal: str, parts: Sequence[tuple[Array | None, Array]]
) -> list[Finding]:
    """Return a finding where a signal moves faster than the log that a model of rate or time was fitted to.

    Parameters
    ----------
    model
        The model; one that was identified before its speed was kept, or by hand, brings no finding.
    card
        Signal of the model, its input or its output, whose range counts as one.
    signal
        The signal in words.
    parts
        Time and values, (T,) each; without time nothing can be said. [s], [unit]

    Examples
    --------
    >>> import dehyst, numpy as np
    >>> from dehyst.io import example_recording
    >>> model = dehyst.identify(example_recording(), "creep-pi").model
    >>> time = np.arange(0.0, 4.0, 0.01)
    >>> fast = [(time, 10.0 * np.sin(20.0 * time))]
    >>> [finding.code for finding in faster_than_log(model, model.card.output, "the reference", fast)]
    ['faster-than-log']
    """
    speeds, drive = model.card.provenance.get("fitted_speed"), model.card.input
    if not model.rate_dependent or not isinstance(speeds, dict):
        return []
    driven, fitted = speeds.get("input"), speeds.get("input" if card is drive else "output")
    # The provenance of a file may hold anything; without two numbers nothing is said.
    if not isinstance(driven, int | float) or not isinstance(fitted, int | float):
        return []
    if not min(driven, fitted) > 0.0:
        return []
    if card.low is None or card.high is None or drive.low is None or drive.high is None:
        return []
    # Speeds count in ranges of the signal, so that they are the same in any unit.
    span = card.high - card.low
    speed = top_speed([(time, values) for time, values in parts if time is not None], span)
    if not speed > POLICY.faster * fitted:
        return []
    unit = f" {card.unit}/s" if card.unit else " a second"
    period = min(PERIOD, float(f"{1.0 / (SAMPLES * speed):.1g}"))
    rate = speed / fitted * driven * (drive.high - drive.low)
    line = command(
        "design", range=(f"{drive.low:.3g}", f"{drive.high:.3g}"), rate=f"{rate:.2g}",
        period=f"{period:g}",
    )  # fmt: skip
    return [
        Finding(
            "faster-than-log",
            f"{signal} moves at up to {speed * span:.3g}{unit} ({speed:.2g} ranges a second), "
            f"{speed / fitted:.2g} times as fast as the log that the model was fitted to ({fitted:.2g} ranges a "
            f"second): what it says of rate and time is a guess there. Log at that speed, `{line}` plans the motion, "
            f"or go more slowly.",
        )
    ]
