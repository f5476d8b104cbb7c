"""Which column looks like input, which like output, and why: a guess to be confirmed, never used silently."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from dehyst.arrays import Array
from dehyst.io.checks import BETWEEN_WORDS, COMMAND_WORDS, hold_length, is_constant
from dehyst.io.columns import run_column
from dehyst.io.table import Table
from dehyst.units import dimension, parse_unit, words

# How well a dimension drives and follows: pressure drives, angle follows, length does both.
INPUT_POINTS = {"pressure": 6.0, "voltage": 6.0, "current": 5.0, "length": 2.0, "angle": 1.5, "force": 0.5}
OUTPUT_POINTS = {"angle": 5.0, "length": 4.0, "force": 4.0, "torque": 4.0, "pressure": 0.5}
CLEAR = 1.0  # points by which a pair leads all others if names and units leave no choice
CANDIDATES = 20  # pairs grow with the square, and a bag may hold thousands of columns
INPUT_WORDS = frozenset(["input", "u", "x", "pressure", "voltage", "current", "drive", "valve", "command"])
OUTPUT_WORDS = frozenset(
    ["output", "y", "angle", "displacement", "position", "force", "tilt", "contraction", "strain", "length", "measured"]
)


@dataclass(frozen=True, slots=True)
class Role:
    """What a column looks like.

    Attributes
    ----------
    role
        ``"time"``, ``"run"``, ``"input"``, ``"output"`` or "".
    reason
        Why.
    """

    role: str
    reason: str


def _points(table: Table, name: str, values: Array, turns: int) -> tuple[float, float, str]:
    """Points as input and as output, and what they rest on."""
    bare, unit = parse_unit(name)
    unit = table.units.get(name) or unit
    kind = dimension(unit)
    spoken = set(words(bare))
    into = INPUT_POINTS.get(kind, 0.0) + bool(spoken & INPUT_WORDS)
    out = OUTPUT_POINTS.get(kind, 0.0) + bool(spoken & OUTPUT_WORDS)
    reasons = [f"{kind} [{unit}]"] if kind else []
    if spoken & COMMAND_WORDS:
        # A command of the output's own kind is the input; beside a measured pressure it is second choice.
        into += 3.0 if kind not in {"pressure", "voltage", "current"} else -0.5
        out -= 4.0
        reasons.append("named like a command")
    if spoken & {"velocity", "speed", "rate", "acceleration", "aux"}:
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
        into -= 2.0
        reasons.append("never turns")
    return into, out, ", ".join(reasons)


def _relation(x: Array, y: Array) -> float:
    """Strength of the linear relation of two signals, 0 to 1."""
    size = min(x.size, y.size)
    if size < 3 or x.size != y.size or is_constant(x) or is_constant(y):
        return 0.0
    a, b = x - x.mean(), y - y.mean()
    scale = float(np.linalg.norm(a) * np.linalg.norm(b))
    return abs(float(np.dot(a, b))) / scale if scale > 0 else 0.0


def guess_roles(
    table: Table, values: dict[str, Array], paired: dict[str, Array], turns: dict[str, int], clocks: list[str]
) -> tuple[dict[str, Role], str | None, str | None, bool]:
    """Role of every column, the best pair of input and output, and whether names and units leave no other choice.

    Parameters
    ----------
    table
        The log.
    values
        Finite samples of each column in the run, (n,).
    paired
        The same columns row by row, for relations between them, (rows,), without gaps.
    turns
        Turning points of each column.
    clocks
        Columns that look like time.
    """
    roles = {name: Role("time", "named or stepping like time") for name in clocks}
    runs = run_column(table)
    if runs is not None:
        roles[runs] = Role("run", "tells recordings apart")
    free = [n for n, v in values.items() if n not in roles and v.size >= 4 and not is_constant(v)]
    points = {name: _points(table, name, values[name], turns[name]) for name in free}
    best: tuple[float, str | None, str | None] = (0.0, None, None)
    drivers = sorted(free, key=lambda n: -points[n][0])[:CANDIDATES]
    followers = sorted(free, key=lambda n: -points[n][1])[:CANDIDATES]
    place = {name: k for k, name in enumerate(table.order)}
    for x in drivers:
        for y in followers:
            if x == y:
                continue
            score = points[x][0] + points[y][1]
            if score > 0:
                score += 1.5 * _relation(paired.get(x, values[x]), paired.get(y, values[y]))
            # Unknown names: earlier columns tend to be the cause.
            score += 0.01 * (place[y] > place[x])
            if score > best[0]:
                best = (score, x, y)
    for name, role in ((best[1], "input"), (best[2], "output")):
        if name is not None:
            roles[name] = Role(role, points[name][2] or "the best match by its order and its movement")
    for name in free:
        roles.setdefault(name, Role("", points[name][2]))
    for name in values:
        roles.setdefault(name, Role("", "constant" if values[name].size else "empty"))
    return roles, best[1], best[2], _leads(points, best[1], best[2])


def _leads(points: dict[str, tuple[float, float, str]], x: str | None, y: str | None) -> bool:
    """Whether a pair leads every other one by `CLEAR`, movement and order left out: these decide too little."""
    if x is None or y is None:
        return False
    drivers = sorted(points, key=lambda name: -points[name][0])[:3]
    followers = sorted(points, key=lambda name: -points[name][1])[:3]
    others = [points[a][0] + points[b][1] for a in drivers for b in followers if a != b and (a, b) != (x, y)]
    return points[x][0] + points[y][1] >= CLEAR + max(others, default=-np.inf)
