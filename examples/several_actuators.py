"""Two actuators in series, and two that move each other: what to log, and in which order to invert.

    python examples/several_actuators.py

The actuators are made of relays, which are no model of dehyst. Each error is that of a reference that was never
logged, rms in percent of its range.
"""

import itertools

import numpy as np

import dehyst

PERIOD, NOISE = 0.01, 2e-4  # [s]; of the sensors


class Relays:
    """A Preisach sum of relays: up above one limit, down below another, each at its place of a random plane."""

    def __init__(self, seed: int, width: float) -> None:
        random = np.random.default_rng(seed)
        middle, half = random.normal(0.0, 0.5, 3000), np.abs(random.normal(0.0, width, 3000))
        self.low, self.high = middle - half, middle + half

    def play(self, signal: np.ndarray) -> np.ndarray:
        """Return the answer to a signal from rest."""
        state, answer = np.where(self.low + self.high > 0.0, -1.0, 1.0), np.empty(signal.size)
        for k, x in enumerate(signal):
            state[x > self.high], state[x < self.low] = 1.0, -1.0
            answer[k] = state.mean() + 0.3 * x
        return answer


def swings(sizes: list[float]) -> np.ndarray:
    """Return a motion from 0 through turning points, 2 s each, still for a second at the end."""
    ramp = 0.5 - 0.5 * np.cos(np.pi * np.arange(1, 201) / 200)
    points = [0.0, *sizes]
    parts = [a + (b - a) * ramp for a, b in itertools.pairwise(points)]
    return np.concatenate([*parts, np.full(100, points[-1])])


TRAINING = swings([1.0, -1.0, 1.0, -0.6, 0.7, -0.3, 0.4, -0.1, 0.9, -0.9, 0.2, -0.5, 1.0, -1.0, 0.5, 0.0])
REFERENCE = swings([0.55, -0.5, 0.35, -0.2, 0.3, -0.55, 0.1, 0.4, 0.0])


def identified(drive: np.ndarray, answer: np.ndarray, **names: str) -> dehyst.Model:
    """Log with a noisy sensor, identify, return the model."""
    seen = answer + NOISE * np.random.default_rng(0).standard_normal(answer.size)
    log = dehyst.Recording(input=drive, output=seen, time=PERIOD * np.arange(drive.size), **names)
    return dehyst.identify(log).model


def asked(model: dehyst.Model, wanted: np.ndarray) -> np.ndarray:
    """Return what the model's inverse asks for, from rest."""
    return model.inverse().at_rest(float(wanted[0])).simulate(wanted, PERIOD * np.arange(wanted.size))


def error(wanted: np.ndarray, got: np.ndarray) -> str:
    """Return the rms error in percent of the range."""
    return f"{100.0 * np.sqrt(np.mean((wanted - got) ** 2)) / np.ptp(wanted):4.1f} %"


def straight(drive: np.ndarray, answer: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """Return what a straight line asks for: no compensator at all."""
    slope, offset = np.polyfit(drive, answer, 1)
    return (wanted - offset) / slope


def in_series() -> None:
    """A valve drives a joint; the pressure between them can be measured, or cannot."""
    valve, joint = Relays(1, 0.15), Relays(2, 0.25)
    pressure = valve.play(TRAINING)
    angle = joint.play(pressure)
    one = identified(TRAINING, angle)
    first, last = identified(TRAINING, pressure), identified(pressure, angle)
    chain = lambda voltage: joint.play(valve.play(voltage))  # noqa: E731 - the rig
    print("in series: voltage -> valve -> pressure -> joint -> angle")
    print("  a straight line                       ", error(REFERENCE, chain(straight(TRAINING, angle, REFERENCE))))
    print("  one model of both                     ", error(REFERENCE, chain(asked(one, REFERENCE))))
    print("  a model of each, the last one first   ", error(REFERENCE, chain(asked(first, asked(last, REFERENCE)))))


def coupled() -> None:
    """Two axes of a stage: each moves the other by a tenth."""
    own, cross = (Relays(3, 0.2), Relays(4, 0.2)), (Relays(5, 0.1), Relays(6, 0.1))
    still = np.zeros(TRAINING.size)

    def stage(u: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return own[0].play(u) + 0.1 * cross[0].play(v), own[1].play(v) + 0.1 * cross[1].play(u)

    x_of_u, y_of_u = stage(TRAINING, still)  # one axis moves, the other is driven with nothing: four logs in two runs
    x_of_v, y_of_v = stage(still, TRAINING)
    models = [identified(TRAINING, signal) for signal in (x_of_u, y_of_u, x_of_v, y_of_v)]
    x_from_u, y_from_u, x_from_v, y_from_v = models
    time = PERIOD * np.arange(REFERENCE.size)
    x, y = REFERENCE, -0.8 * REFERENCE[::-1] + 0.8 * REFERENCE[-1]
    u, v = asked(x_from_u, x), asked(y_from_v, y)
    alone = stage(u, v)
    for _ in range(3):  # what the other axis does is taken off the wanted motion; three rounds are more than enough
        u, v = asked(x_from_u, x - moved(x_from_v, v, time)), asked(y_from_v, y - moved(y_from_u, u, time))
    both = stage(u, v)
    print("coupled: two axes, each moves the other by a tenth")
    print("  each axis by itself                   ", error(x, alone[0]), error(y, alone[1]))
    print("  what the other one does taken off     ", error(x, both[0]), error(y, both[1]))


def moved(model: dehyst.Model, drive: np.ndarray, time: np.ndarray) -> np.ndarray:
    """Return by how much an axis is moved from its rest by the drive of the other one."""
    answer = model.at_rest(float(drive[0])).simulate(drive, time)
    return answer - answer[0]


if __name__ == "__main__":
    in_series()
    coupled()
