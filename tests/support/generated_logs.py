"""Logs of rigs whose mechanisms are no model of dehyst, and what must not matter to an identification of them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

import dehyst
from dehyst.families import names

Array = np.ndarray
MECHANISMS = ("relays", "plays", "bouc-wen", "slip", "backlash", "curve")
STARTS = ("zero", "rest", "rising", "falling")


@dataclass(frozen=True)
class Log:
    """Recordings of a rig (input, output, time), and a motion with its true outputs, which was not logged."""

    parts: tuple[tuple[Array, Array, Array], ...]
    x: Array
    y: Array
    time: Array
    scored: slice
    y_range: float
    x_range: float

    def recordings(self) -> list[dehyst.Recording]:
        return [
            dehyst.Recording(input=x, output=y, time=t, name=f"log {k}")
            for k, (x, y, t) in enumerate(self.parts)
        ]

    def true_error(self, fit) -> float:
        """RMS of what the model says of the other motion, less the truth; percent of range."""
        timed = getattr(fit.model, "rate_dependent", False)
        said = fit.model.simulate(self.x, self.time) if timed else fit.model.simulate(self.x)
        return 100.0 * _rms(said[self.scored] - self.y[self.scored]) / self.y_range


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def _relays(x: Array, rng: np.random.Generator) -> Array:
    """Relays with random switching points, up above a, down below b, and a line."""
    low, high = np.sort(rng.uniform(-1.1, 1.1, (2, 400)), axis=0)
    weight, state, y = rng.exponential(1.0, 400), -np.ones(400), np.empty(x.size)
    for k, value in enumerate(x):
        state[value > high], state[value < low] = 1.0, -1.0
        y[k] = weight @ state
    return y / np.sum(weight) + 0.8 * x


def _plays(x: Array, rng: np.random.Generator) -> Array:
    """Plays of random widths behind a bent curve."""
    radii, weight = rng.uniform(0.05, 0.9, 15), rng.exponential(1.0, 15)
    state, y = np.zeros(15), np.empty(x.size)
    for k, value in enumerate(x):
        state = np.clip(state, value - radii, value + radii)
        y[k] = value + weight @ state / 8.0
    return np.tanh(rng.uniform(0.3, 0.9) * y) + 0.1 * y


def _bouc_wen(x: Array, rng: np.random.Generator) -> Array:
    """Bouc-Wen, wider where the input is high."""
    beta, gamma, bend = rng.uniform(2.0, 4.0), rng.uniform(-1.0, 1.0), rng.uniform(0.0, 0.4)
    z, y = 0.0, np.empty(x.size)
    y[0] = x[0]
    for k in range(1, x.size):
        for step in np.full(8, (x[k] - x[k - 1]) / 8.0):
            z += step * (1.0 - abs(z) * (gamma + beta * np.sign(step * z) * (1.0 + bend * x[k])))
        y[k] = x[k] - (0.5 + 0.2 * bend * x[k]) * z
    return y


def _slip(x: Array, rng: np.random.Generator) -> Array:
    """Springs that slip: force against displacement, clockwise."""
    radii, stiff = rng.uniform(0.1, 1.0, 8), rng.exponential(1.0, 8)
    state, y = np.zeros(8), np.empty(x.size)
    for k, value in enumerate(x):
        state = np.clip(state, value - radii, value + radii)
        y[k] = stiff @ (value - state) / 4.0 + 0.5 * value + 0.1 * value**3
    return y


def _backlash(x: Array, rng: np.random.Generator) -> Array:
    """One slot and a curve that saturates."""
    radius, state, y = rng.uniform(0.05, 0.25), 0.0, np.empty(x.size)
    for k, value in enumerate(x):
        state = min(max(state, value - radius), value + radius)
        y[k] = 0.2 * value + np.tanh(1.2 * state)
    return y


def _curve(x: Array, rng: np.random.Generator) -> Array:
    """No memory at all."""
    return np.tanh(rng.uniform(0.5, 1.5) * x) + 0.05 * x**2


_RUN: dict[str, Callable[[Array, np.random.Generator], Array]] = {
    "relays": _relays, "plays": _plays, "bouc-wen": _bouc_wen, "slip": _slip, "backlash": _backlash, "curve": _curve,
}  # fmt: skip


def _way(rng: np.random.Generator, samples: int) -> Array:
    """From 0 through turning points of random height, both extremes among the first, to and fro like a sine."""
    turns = max(12, samples // int(rng.integers(50, 80)))
    height = rng.uniform(0.25, 1.0, turns) * np.where(np.arange(turns) % 2, -1.0, 1.0)
    height[:2], height[turns // 2 : turns // 2 + 2] = (1.0, -1.0), (1.0, -1.0)
    points = np.r_[0.0, height]
    place = np.linspace(0.0, turns, samples)
    part = np.minimum(place.astype(int), turns - 1)
    share = 0.5 - 0.5 * np.cos(np.pi * (place - part))
    return points[part] + share * (points[part + 1] - points[part])


def _past(start: str) -> Array:
    """What the rig did before the log, which begins at 0."""
    ring = {
        "zero": np.concatenate([[a, -a] for a in np.linspace(1.0, 0.0, 40)]),
        "rest": [0.0],
        "rising": [1.0, -1.0, 0.0],
        "falling": [-1.0, 1.0, 0.0],
    }[start]
    points = np.r_[0.0, ring]
    return np.interp(
        np.linspace(0, points.size - 1, 20 * points.size), np.arange(points.size), points
    )


def generated(seed: int, start: str | None = None, recordings: int = 1) -> Log:
    """A rig, drawn by its number: mechanism, start, size, units and noise of 0.2 % of range; a log of two sizes."""
    rng = np.random.default_rng(seed)
    mechanism = MECHANISMS[seed % len(MECHANISMS)]
    start = STARTS[seed // len(MECHANISMS) % len(STARTS)] if start is None else start
    samples = int(rng.integers(900, 1500))
    gain_x, zero_x, gain_y, zero_y = (
        rng.uniform(1, 8),
        rng.uniform(-3, 3),
        rng.uniform(5, 50),
        rng.uniform(-20, 20),
    )
    other, rig = _way(rng, 900), rng.integers(1 << 30)
    truth = _RUN[mechanism](other, np.random.default_rng(rig))
    noise = 0.01 * NOISE_PERCENT * float(np.ptp(truth))
    parts = []
    for _ in range(recordings):
        past, way = _past(start), _way(rng, samples // recordings if recordings > 1 else samples)
        y = _RUN[mechanism](np.r_[past, way], np.random.default_rng(rig))[past.size :] + rng.normal(
            0, noise, way.size
        )
        parts.append((zero_x + gain_x * way, zero_y + gain_y * y, 0.02 * np.arange(way.size)))
    x, y = zero_x + gain_x * other, zero_y + gain_y * truth
    return Log(
        tuple(parts),
        x,
        y,
        0.02 * np.arange(900),
        slice(200, None),
        float(np.ptp(y)),
        float(np.ptp(x)),
    )


def scaled(
    log: Log, x: float = 1.0, y: float = 1.0, x_zero: float = 0.0, y_zero: float = 0.0
) -> Log:
    """The same rig in other units: x times a factor and on another zero, and y too."""

    def of_x(values: Array) -> Array:
        return x * values + x_zero * abs(x) * log.x_range

    def of_y(values: Array) -> Array:
        return y * values + y_zero * abs(y) * log.y_range

    parts = tuple((of_x(a), of_y(b), t) for a, b, t in log.parts)
    ranges = {"x_range": abs(x) * log.x_range, "y_range": abs(y) * log.y_range}
    return replace(log, parts=parts, x=of_x(log.x), y=of_y(log.y), **ranges)


def doubled(log: Log) -> Log:
    """Every sample twice, the second between its neighbours in time."""
    twice = tuple(
        (
            np.repeat(x, 2),
            np.repeat(y, 2),
            np.interp(np.arange(2 * t.size) / 2.0, np.arange(t.size), t) + 0.0,
        )
        for x, y, t in log.parts
    )
    return replace(log, parts=tuple((x[:-1], y[:-1], t[:-1]) for x, y, t in twice))


def reversed_order(log: Log) -> Log:
    """The recordings in another order."""
    return replace(log, parts=log.parts[::-1])


def falsified(log: Log, rng: np.random.Generator, length: int, channel: int = 1) -> Log:
    """`length` samples in a row that the sensor made up, at a place drawn at random, 1.5 to 20 ranges away."""
    parts = [tuple(signal.copy() for signal in part) for part in log.parts]
    signal = parts[0][channel]
    place = int(rng.integers(10, signal.size - 10 - length))
    signal[place : place + length] = signal[place] + rng.choice([-1, 1]) * rng.uniform(
        1.5, 20.0
    ) * np.ptp(signal)
    return replace(log, parts=tuple(parts))


@dataclass(frozen=True)
class Relation:
    """A change of a log that must not change what is found in it.

    Attributes
    ----------
    name
        In words.
    changed
        Log and random numbers -> the changed log.
    exact
        Whether the numbers are the same but for rounding: then the choice is too. If not, the true error may grow by
        `ALLOWED`.
    recordings
        How many recordings the log must have.
    mirrored
        Whether a rising past becomes a falling one.
    moved
        Whether the input's 0 becomes another one: a start at "origin", that 0, is then another start.
    causes
        Codes of the warnings that may say why the error grew instead.
    """

    name: str
    changed: Callable[[Log, np.random.Generator], Log]
    exact: bool = True
    recordings: int = 1
    mirrored: bool = False
    moved: bool = False
    causes: tuple[str, ...] = ()
    of_plays: bool = False


ALLOWED = 1.15
NOISE_PERCENT = 0.2  # of the range, on the output of every generated log
ROUNDING = 1.0 + 1e-4
# True errors below this, percent of range, are a twentieth of the noise: no ratio of them says anything.
NOTHING = 0.01
FALSE = ("outlier",)
PAPER = ("paper-bound",)  # the paper's bound is absolute
UNITS = (
    Relation(
        "input in other units",
        lambda log, rng: scaled(log, x=10.0 ** rng.uniform(-6, 6)),
        causes=PAPER,
    ),
    Relation(
        "output in other units",
        lambda log, rng: scaled(log, y=10.0 ** rng.uniform(-6, 6)),
        causes=PAPER,
    ),
)
RELATIONS = (
    *UNITS,
    Relation(
        "input on another zero",
        lambda log, rng: scaled(log, x_zero=rng.uniform(-1000, 1000)),
        moved=True,
    ),
    Relation(
        "output on another zero", lambda log, rng: scaled(log, y_zero=rng.uniform(-1000, 1000))
    ),
    Relation("output with the other sign", lambda log, rng: scaled(log, y=-1.0)),
    Relation(
        "both with the other sign", lambda log, rng: scaled(log, x=-1.0, y=-1.0), mirrored=True
    ),
    Relation("every sample twice", lambda log, rng: doubled(log), exact=False, of_plays=True),
    Relation(
        "recordings in another order",
        lambda log, rng: reversed_order(log),
        exact=False,
        recordings=2,
        of_plays=True,
    ),
    Relation(
        "one false output", lambda log, rng: falsified(log, rng, 1), exact=False, causes=FALSE
    ),
    Relation(
        "five false outputs", lambda log, rng: falsified(log, rng, 5), exact=False, causes=FALSE
    ),
    Relation(
        "one false input", lambda log, rng: falsified(log, rng, 1, 0), exact=False, causes=FALSE
    ),
    Relation(
        "five false inputs", lambda log, rng: falsified(log, rng, 5, 0), exact=False, causes=FALSE
    ),
)
_MIRROR = {"rising": "falling", "falling": "rising"}


@dataclass(frozen=True)
class Found:
    """What an identification made of a log: its choice, the true error in percent of range, the warnings' codes."""

    choice: tuple[str, str]
    error: float
    codes: frozenset[str]


def found_in(log: Log, identify: Callable[[list[dehyst.Recording]], object]) -> Found:
    """Identify a log, and judge the model by the truth."""
    fit = identify(log.recordings())
    start = getattr(getattr(fit, "certificate", None), "initial_state", "")
    return Found(
        (fit.family, start),
        log.true_error(fit),
        frozenset(f.code for f in getattr(fit, "warnings", ())),
    )


def by_name(family: str) -> Callable[[list[dehyst.Recording]], object]:
    """How a family is identified, one of `dehyst.identify` or one of the literature."""
    if family in names():
        return lambda recordings: dehyst.identify(recordings, family)
    return lambda recordings: dehyst.identify(recordings, family)


def broken(relation: Relation, before: Found, after: Found) -> str:
    """What of the relation does not hold, in words; nothing where it holds, or where a warning names the cause."""
    if (after.codes - before.codes) & set(relation.causes):
        return ""
    family, start = before.choice
    elsewhere = relation.moved and "origin" in (
        start,
        after.choice[1],
    )  # a start that the other log does not have
    exact = relation.exact and not elsewhere
    expected = (family, _MIRROR.get(start, start) if relation.mirrored else start)
    if exact and after.choice != expected:
        return f"{' from '.join(after.choice)} is chosen instead of {' from '.join(expected)}"
    ratio = max(after.error, NOTHING) / max(before.error, NOTHING)
    if ratio > (ROUNDING if exact else ALLOWED):
        return f"true error {before.error:.3g} -> {after.error:.3g} % of range, and no warning names the cause"
    return ""
