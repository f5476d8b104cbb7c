"""Proposes which column of a log is the input and which one the output, and says how sure that is.

Points of names and units come first, then how much one signal follows the other, and which of them leads. Two copies of
one signal follow each other best of all, and are no pair.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from itertools import product
from typing import NamedTuple

import numpy as np

from dehyst.arrays import Array
from dehyst.io._checks import BETWEEN_WORDS, COMMAND_WORDS, hold_length, is_constant
from dehyst.io._columns import run_column
from dehyst.io._heading import COUNT_WORDS
from dehyst.io._policy import POLICY
from dehyst.io._table import LogTable
from dehyst.units import dimension, words

# How well a dimension drives and follows: pressure drives, angle follows, length does both.
INPUT_POINTS = {
    "pressure": 6.0, "voltage": 6.0, "current": 5.0, "temperature": 2.5, "length": 2.0, "angle": 1.5, "force": 0.5,
}  # fmt: skip
OUTPUT_POINTS = {
    "angle": 5.0,
    "length": 4.0,
    "force": 4.0,
    "torque": 4.0,
    "pressure": 0.5,
    "temperature": 0.5,
}
DRIVES = ("pressure", "voltage", "current")
CANDIDATES = 20  # pairs grow with the square, and a bag may hold thousands of columns
INPUT_WORDS = frozenset(
    words("input u x pressure voltage current drive valve command druck spannung strom")
)
OUTPUT_WORDS = frozenset(
    words(
        "output y angle displacement position force tilt contraction strain length measured actual ist elongation "
        "extension deflection stroke rotation crosshead weg winkel kraft dehnung feedback flow"
    )
)
TEMPERATURES = {"c", "degc", "°c", "k", "°f", "degf", "celsius", "kelvin"}
TEMPERATURE_WORDS = frozenset(words("temperature temp temperatur"))
LOOP_WORDS = {
    "op": (6.0, -2.0),
    "sp": (1.0, -4.0),
    "pv": (-4.0, 5.0),
}  # of a control loop: input and output points
SIDE_WORDS = frozenset(words("velocity speed rate acceleration aux noise status counter ambient"))
LOOKED_AT = 4000  # samples


@dataclass(frozen=True, slots=True)
class Role:
    """What a column looks like, and why: "time", "run", "input", "output" or ""."""

    role: str
    reason: str


@dataclass(frozen=True, slots=True)
class Points:
    """How well a column drives and follows by its name and unit, and what that rests on."""

    into: float
    out: float
    reason: str
    kind: str  # dimension, "" if not known
    is_command: bool


class Pair(NamedTuple):
    """A pair of columns and its points."""

    input: str
    output: str
    points: float


@dataclass(frozen=True)
class Proposal:
    """Pairs from the best one on, the points of the columns that may be in one, and roles of the others."""

    pairs: tuple[Pair, ...]
    points: dict[str, Points]
    others: dict[str, Role]

    def led_by(self, pair: Pair) -> Proposal:
        """Return the same with another pair as the best."""
        later = [rival for rival in self.pairs if rival is not pair]
        return replace(self, pairs=(pair, *later))

    @property
    def roles(self) -> dict[str, Role]:
        """Role of every column."""
        roles = dict(self.others)
        for name, points in self.points.items():
            roles[name] = Role("", points.reason)
        if self.pairs:
            best = self.pairs[0]
            by_movement = "the best match by its order and its movement"
            roles[best.input] = Role("input", self.points[best.input].reason or by_movement)
            roles[best.output] = Role("output", self.points[best.output].reason or by_movement)
        return roles

    @property
    def clear(self) -> bool:
        """Whether names and units leave no other choice; movement and order decide too little."""
        return bool(self.pairs) and _leads(self.points, self.pairs[0])

    @property
    def doubt(self) -> str:
        """Which other pairs are as likely as the best one, in a sentence; "" for none."""
        if not self.pairs or self.clear:
            return ""
        best, *rivals = self.pairs
        near = [pair for pair in rivals if pair.points > best.points - POLICY.near_points]
        if not near:
            return ""
        listed = "; ".join(f"{pair.input} -> {pair.output}" for pair in near[:3])
        if [pair[:2] for pair in near] == [(best.output, best.input)]:
            return (
                f"names and units do not tell which of {best.input} and {best.output} drives the other. If it is "
                f"{best.output}, take {listed}."
            )
        return f"{best.input} -> {best.output} leads by little. As likely: {listed}."


def propose(
    table: LogTable,
    values: dict[str, Array],
    paired: dict[str, Array],
    turns: dict[str, int],
    clocks: list[str],
) -> Proposal:
    """Propose pairs.

    `values` are the finite samples of each column in the run, `paired` the same columns row by row, `turns` how often
    they turn, `clocks` the columns that look like time.
    """
    other_roles = {name: Role("time", "named or stepping like time") for name in clocks}
    runs = run_column(table)
    if runs is not None:
        other_roles[runs] = Role("run", "tells recordings apart")
    for name in values:
        if name not in other_roles and _counts(name, values[name]):
            other_roles[name] = Role("", "counts the rows")
    points: dict[str, Points] = {}
    signals: dict[str, Array] = {}
    for name, column in values.items():
        if name in other_roles:
            continue
        if column.size >= 4 and not is_constant(column):
            points[name] = _points(table, name, column, turns[name])
            signals[name] = paired.get(name, column)
        elif column.size:
            other_roles[name] = Role("", "constant")
        else:
            other_roles[name] = Role("", "empty")
    return Proposal(_ranked(table, points, signals, bool(clocks)), points, other_roles)


def _counts(name: str, values: Array) -> bool:
    """Whether a column numbers the rows: from 0 or 1, or by its name, one more in each."""
    numbers = values.size >= POLICY.noise_from and bool(np.all(np.diff(values) == 1.0))
    return numbers and (float(values[0]) in (0.0, 1.0) or bool(COUNT_WORDS & set(words(name))))


def _ranked(
    table: LogTable, points: dict[str, Points], signals: dict[str, Array], clocked: bool
) -> tuple[Pair, ...]:
    """Pairs from the best one on; those with nothing for them are left out."""
    drivers = sorted(points, key=lambda name: -points[name].into)[:CANDIDATES]
    followers = sorted(points, key=lambda name: -points[name].out)[:CANDIDATES]
    place = {name: k for k, name in enumerate(table.order)}
    pairs = []
    for x, y in product(drivers, followers):
        if x == y or (signals[x].size != signals[y].size and not clocked):
            continue
        total = (
            points[x].into + points[y].out + _movement(signals[x], signals[y], points[x], points[y])
        )
        total += 0.01 * (
            place[y] > place[x]
        )  # of unknown names earlier columns tend to be the cause
        pairs.append(Pair(x, y, total))
    ranked = sorted(
        pairs, key=lambda pair: -round(pair.points, 6)
    )  # of equal ones the first columns
    return tuple(pair for pair in ranked if pair.points > 0.0 or len(points) == 2)


def _movement(x: Array, y: Array, driver: Points, follower: Points) -> float:
    """Points of a pair by how its signals move."""
    if x.size < 3 or x.size != y.size:
        return 0.0
    step = max(1, x.size // LOOKED_AT)
    a, b = _standard(x[::step]), _standard(y[::step])
    both = np.isfinite(a) & np.isfinite(b)
    a, b = a[both], b[both]
    if a.size < 3:
        return 0.0
    straight = float(np.mean(a * b))
    total = POLICY.points_follows * max(abs(straight), _monotone(a, b))
    drives = driver.is_command or (
        driver.kind in DRIVES and follower.kind not in ("", driver.kind, "force")
    )
    if 1.0 - straight**2 < POLICY.copy and not drives:
        total -= POLICY.points_copies
    # The loop of a signal that comes later runs counter-clockwise, or clockwise where it falls as the other rises.
    area = float(np.mean(a[:-1] * b[1:] - a[1:] * b[:-1]))
    if straight < 0.0:
        area = -area
    way = float(np.mean(np.abs(np.diff(a)))) + 1e-300
    return total + POLICY.points_leads * min(max(POLICY.sure_area * area / way, -1.0), 1.0)


def _standard(values: Array) -> Array:
    """Values less their mean, over their deviation."""
    good = values[np.isfinite(values)]
    if good.size == 0:
        return np.zeros(values.size)
    deviation = float(np.std(good))
    if deviation == 0.0:
        return np.zeros(values.size)
    return (values - float(np.mean(good))) / deviation


def _monotone(a: Array, b: Array) -> float:
    """Relation of the orders of two signals, 0 to 1."""
    return abs(float(np.mean(_standard(_ranks(a)) * _standard(_ranks(b)))))


def _ranks(values: Array) -> Array:
    order = np.argsort(values, kind="stable")
    return np.argsort(order, kind="stable").astype(np.float64)


def _points(table: LogTable, name: str, values: Array, turns: int) -> Points:
    """Points by name, unit, and what the column does by itself."""
    bare, unit = table.label(name)
    spoken = set(words(bare))
    kind = dimension(unit)
    if unit.lower() in TEMPERATURES or (not kind and not unit and spoken & TEMPERATURE_WORDS):
        kind = "temperature"
    if spoken & {"head", "suction"}:  # a pressure as the height of a column of water
        kind = "pressure"
    if "stress" in spoken and kind == "pressure":  # a load on an area
        kind = "force"
    into = INPUT_POINTS.get(kind, 0.0) + bool(spoken & INPUT_WORDS)
    out = OUTPUT_POINTS.get(kind, 0.0) + bool(spoken & OUTPUT_WORDS)
    reasons: list[str] = []
    if kind and unit:
        reasons.append(f"{kind} [{unit}]")
    elif kind:
        reasons.append(kind)
    is_command = bool(spoken & COMMAND_WORDS)
    if is_command:
        # A command of the output's own kind is the input; beside a measured pressure it is second choice.
        if kind in DRIVES:
            into -= 0.5
        else:
            into += 3.0
        out -= 4.0
        reasons.append("named like a command")
    for word, (more, less) in LOOP_WORDS.items():
        if spoken == {word} or word.upper() in re.split(r"[\W_]+", bare):
            into, out = into + more, out + less
            reasons.append(
                {"op": "output of a controller", "sp": "set point", "pv": "process value"}[word]
            )
    if spoken & SIDE_WORDS:
        into, out = into - 3.0, out - 3.0
        reasons.append("a rate or auxiliary signal")
    if spoken & BETWEEN_WORDS:
        into += 0.5
        reasons.append("interpolated between updates")
    hold = hold_length(values)
    if hold > 1.0:
        into, out = into - 1.0, out - 1.0
        reasons.append(f"held for {hold:.0f} samples at a time")
    if turns < 1:
        into, out = into - 2.0, out - 2.0
        reasons.append("never turns")
    if _is_noise(values):
        into, out = into - 3.0, out - 3.0
        reasons.append("noise about a constant")
    return Points(into, out, ", ".join(reasons), kind, is_command)


def _is_noise(values: Array) -> bool:
    """Whether a signal moves from sample to sample as far as over all of the log, but for a slow drift."""
    part = values[:LOOKED_AT]
    if part.size < POLICY.noise_from:
        return False
    t = np.arange(part.size) - 0.5 * (part.size - 1)
    about = part - np.mean(part)
    level = about - t * (float(t @ about) / float(t @ t))
    return bool(np.std(np.diff(part)) > POLICY.noisy * 2.0**0.5 * np.std(level))


def _leads(points: dict[str, Points], best: Pair) -> bool:
    """Whether a pair leads every other one by `clear_lead`, movement and order left out: these decide too little."""
    drivers = sorted(points, key=lambda name: -points[name].into)[:3]
    followers = sorted(points, key=lambda name: -points[name].out)[:3]
    strongest = -np.inf
    for driver, follower in product(drivers, followers):
        if driver != follower and (driver, follower) != (best.input, best.output):
            strongest = max(strongest, points[driver].into + points[follower].out)
    return points[best.input].into + points[best.output].out >= POLICY.clear_lead + strongest
