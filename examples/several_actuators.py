"""Two actuators in series, and two that move each other: what to log, and in which order to invert.

    python examples/several_actuators.py

Each error is that of a reference that was never logged, rms in percent of its range.
"""

import numpy as np
from relay_rig import PERIOD, Relays, asked, error, identified, moved, stage, swings

TRAINING = swings([1.0, -1.0, 1.0, -0.6, 0.7, -0.3, 0.4, -0.1, 0.9, -0.9, 0.2, -0.5, 1.0, -1.0, 0.5, 0.0])
REFERENCE = swings([0.55, -0.5, 0.35, -0.2, 0.3, -0.55, 0.1, 0.4, 0.0])


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
    rounds = stage(u, v)
    models = x_from_u.inverse(), y_from_v.inverse(), x_from_v, y_from_u
    ask_u, ask_v, x_of_v, y_of_u = (model.at_rest(0.0).stepper(PERIOD) for model in models)
    at_rest = x_of_v(0.0), y_of_u(0.0)
    for k in range(x.size):  # sample by sample: u takes off what v did in the sample before
        u[k] = ask_u(x[k] - x_of_v(v[k - 1] if k else 0.0) + at_rest[0])
        v[k] = ask_v(y[k] - y_of_u(u[k]) + at_rest[1])
    names = ("each axis by itself", "what the other one does taken off", "the same, sample by sample")
    for name, (got_x, got_y) in zip(names, (alone, rounds, stage(u, v)), strict=True):
        print(f"  {name:38}", error(x, got_x), error(y, got_y))


if __name__ == "__main__":
    in_series()
    coupled()
