"""Two actuators in series, and two that move each other: what to log, and how to invert.

    python examples/several_actuators.py

Each error is that of a reference that was never logged, rms in percent of its range.
"""

from collections.abc import Callable

import numpy as np
from relay_rig import PERIOD, REFERENCE, TRAINING, Relays, asked, error, identified, logged, muscles, stage

import dehyst

Rig = Callable[[np.ndarray, np.ndarray], np.ndarray]

STILL = np.zeros(TRAINING.size)


def in_series() -> None:
    """A valve drives a joint; the pressure between them can be measured, or cannot."""
    valve, joint = Relays(1, 0.15), Relays(2, 0.25)
    pressure = valve.play(TRAINING)
    angle = joint.play(pressure)
    both, first, last = (identified(TRAINING, angle), identified(TRAINING, pressure), identified(pressure, angle))
    slope, offset = np.polyfit(TRAINING, angle, 1)
    print("in series: voltage -> valve -> pressure -> joint -> angle")
    for name, voltage in (
        ("a straight line", (REFERENCE - offset) / slope),
        ("one model of both", asked(both, REFERENCE)),
        ("a model of each, the last one first", asked(first, asked(last, REFERENCE))),
    ):
        print(f"  {name:38}", error(REFERENCE, joint.play(valve.play(voltage))))


def coupled() -> None:
    """Two axes that move each other, and two muscles that make an angle and a stiffness: one log, both inputs move."""
    x, y = REFERENCE, -0.8 * REFERENCE[::-1]
    alone = identified(TRAINING, stage(TRAINING, STILL)[0]), identified(TRAINING, stage(STILL, TRAINING)[1])
    print("coupled: two axes, each moves the other by a tenth")
    show("each axis by itself", (x, y), stage(asked(alone[0], x), asked(alone[1], y)))
    show("both together", (x, y), stage(*inputs_for(stage, x, y)))
    print("coupled: pressures of two muscles -> angle and stiffness of a joint")
    angle, stiffness = REFERENCE, 0.1 + 0.4 * REFERENCE[::-1]
    show("both together", (angle, stiffness), muscles(*inputs_for(muscles, angle, stiffness)))


def inputs_for(rig: Rig, first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Identify a rig, and return the inputs that two wanted outputs need."""
    _, u, v, x, y = logged(rig).values()
    log = dehyst.Recording(
        u, x, PERIOD * np.arange(u.size), input_name="u", output_name="x", schedules={"v": v, "y": y}
    )
    model = dehyst.identify(log, input=["u", "v"], output=["x", "y"]).model
    time = PERIOD * np.arange(first.size)
    return model.inverse().simulate(np.column_stack([first, second]), time).T


def show(name: str, wanted: tuple[np.ndarray, np.ndarray], got: np.ndarray) -> None:
    """Print both errors."""
    print(f"  {name:38}", error(wanted[0], got[0]), error(wanted[1], got[1]))


if __name__ == "__main__":
    in_series()
    coupled()
