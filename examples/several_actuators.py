"""Two actuators in series, and two that move each other: what to log, and in which order to invert.

    python examples/several_actuators.py

Each error is that of a reference that was never logged, rms in percent of its range.
"""

import numpy as np
from relay_rig import Relays, asked, error, identified, moved, swings

TRAINING = swings([1.0, -1.0, 1.0, -0.6, 0.7, -0.3, 0.4, -0.1, 0.9, -0.9, 0.2, -0.5, 1.0, -1.0, 0.5, 0.0])
REFERENCE = swings([0.55, -0.5, 0.35, -0.2, 0.3, -0.55, 0.1, 0.4, 0.0])


def in_series() -> None:
    """A valve drives a joint; the pressure between them can be measured, or cannot."""
    valve, joint = Relays(1, 0.15), Relays(2, 0.25)
    pressure = valve.play(TRAINING)
    angle = joint.play(pressure)
    both, first, last = identified(TRAINING, angle), identified(TRAINING, pressure), identified(pressure, angle)
    slope, offset = np.polyfit(TRAINING, angle, 1)
    print("in series: voltage -> valve -> pressure -> joint -> angle")
    for name, voltage in (
        ("a straight line", (REFERENCE - offset) / slope),
        ("one model of both", asked(both, REFERENCE)),
        ("a model of each, the last one first", asked(first, asked(last, REFERENCE))),
    ):
        print(f"  {name:38}", error(REFERENCE, joint.play(valve.play(voltage))))


def stage(u: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two axes: each moves the other by a tenth."""
    x = Relays(3, 0.2).play(u) + 0.1 * Relays(5, 0.1).play(v)
    return x, Relays(4, 0.2).play(v) + 0.1 * Relays(6, 0.1).play(u)


def coupled() -> None:
    """One axis is logged while the other stands still, with both outputs: four loops from two runs."""
    still = np.zeros(TRAINING.size)
    x_from_u, y_from_u = (identified(TRAINING, answer) for answer in stage(TRAINING, still))
    x_from_v, y_from_v = (identified(TRAINING, answer) for answer in stage(still, TRAINING))
    x, y = REFERENCE, -0.8 * REFERENCE[::-1]
    print("coupled: two axes, each moves the other by a tenth")
    u, v = asked(x_from_u, x), asked(y_from_v, y)
    alone = stage(u, v)
    for _ in range(3):  # what the other axis does is taken off the wanted motion; three rounds are enough
        u, v = asked(x_from_u, x - moved(x_from_v, v)), asked(y_from_v, y - moved(y_from_u, u))
    for name, (got_x, got_y) in (("each axis by itself", alone), ("what the other one does taken off", stage(u, v))):
        print(f"  {name:38}", error(x, got_x), error(y, got_y))


if __name__ == "__main__":
    in_series()
    coupled()
