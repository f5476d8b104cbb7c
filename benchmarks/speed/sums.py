"""A sum of elements along a long signal, as identified from the example log, against the core's own functions."""

from __future__ import annotations

import numpy as np

import dehyst
from dehyst.io import example_recording

from .figures import Figures
from .measure import Work, measure

REPEATS = 40  # of the example's input


def run(rounds: int, figures: Figures) -> None:
    """Time both ways; the numbers are of the sum alone, without the scaling around it."""
    recording = example_recording()
    model = dehyst.identify(recording).model
    machine = model._sum
    x = np.tile((recording.input - model.scaling.center) / model.scaling.half_range, REPEATS)
    # Stamps of a log are rounded, so that steps of time are of a few lengths.
    assert recording.time is not None
    dt = np.diff(np.arange(x.size + 1) * (recording.time[1] - recording.time[0]))
    memory = machine.rest(float(x[0]))
    y = machine.run(x, dt, None, memory)[0]
    for way, function, signal in (("forward", machine.run, x), ("back", machine.solve, y)):
        times = measure(
            {
                "long signal": Work(lambda f=function, s=signal: f(s, dt, None, memory), x.size),
                "core": Work(
                    lambda f=function, s=signal: f(s, dt, None, memory, core=True), x.size
                ),
            },
            rounds,
        )
        figures.times(f"a sum of {len(model.elements)} elements, {way}", "example log", times)
        figures.ratio(
            f"the core's functions / a sum along a signal, {way}",
            "example log",
            times,
            "core",
            "long signal",
        )
        figures.add(
            f"a sum along a signal, {way} [ns]", "example log", times.per_sample("long signal")
        )
