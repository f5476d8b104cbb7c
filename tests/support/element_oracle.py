"""Sums of elements by their definitions, case by case, in rational numbers but for paths; and random ones."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction as F

import numpy as np

from dehyst.families._elements import KINDS, LAGS, Element, ElementModel
from dehyst.families._rising import least_slope

TIMES = (0.0, 0.05, 0.5, 5.0)


def within(z, radius):
    return max(-radius, min(radius, F(z)))


def play(z, x, radius):
    if x - z > radius:
        return x - radius
    return x + radius if z - x > radius else z


class Cell:
    """One element with its memory, by definition."""

    def __init__(self, element, x):
        self.q, self.x = element, x
        self.z = 0 if element.kind == "path" else x

    def step(self, x, dt, after=None):
        """Value at x, and the memory follows; `after` is the next cell."""
        kind, r, z, way = self.q.kind, F(self.q.radius), self.z, x - self.x
        share = F(-math.expm1(-dt / self.q.time)) if self.q.time > 0 else F(1)
        lag = z + share * (play(z, x, r) - z)
        if kind == "wide":
            r += (min(F(self.q.time) / F(dt), F(15, 16)) if dt > 0 else 0) * abs(way)
        side = 1 if way >= 0 else -1
        path = (
            float(side * r) + math.exp(-abs(way / r)) * float(z - side * r)
            if kind == "path"
            else 0.0
        )
        e, z = {
            "input": (x, x),
            "play": (play(z, x, r),) * 2,
            "stop": (x - play(z, x, r), play(z, x, r)),
            "creep": (lag, lag),
            "relax": (x - z, lag),
            "past": (z, lag),
            "path": (F(path), F(path)),
            "wide": (play(z, x, r),) * 2,
            "product": (within(z, r) * within(after.z if after else 0, r), z + share * (x - z)),
        }[kind]
        self.x, self.z = x, F(float(z)) if kind in LAGS else z  # digits would grow for ever
        return e


def line(pairs, e):
    """A map at e, continued along its ends."""
    if not pairs[0]:
        return e
    u, v = ([F(value) for value in side] for side in pairs)
    k = max([i for i in range(len(u) - 1) if u[i] <= e], default=0)
    return v[k] + (v[k + 1] - v[k]) / (u[k + 1] - u[k]) * (e - u[k])


def answers(model, x, dt, rest, given=None):
    """Outputs of a forward model from rest at an input."""
    cells = [Cell(q, line(model.before_map, F(rest))) for q in model.elements]
    last, out = F(rest), []
    last = line(model.before_map, last)
    for k, sample in enumerate(x):
        at, share = line(model.before_map, F(float(sample))), [F(1)]
        for source, low, high in model.schedules:
            sigma = last if source < 0 else F(float(given[k, source]))
            xi = (min(max(sigma, F(low)), F(high)) - F(low)) / (F(high) - F(low))
            share += [1 - xi, xi]
        values = [
            cell.step(at, float(dt[k]), after)
            for cell, after in zip(cells, [*cells[1:], None], strict=True)
        ]
        terms = zip(model.elements, values, strict=True)
        total = F(model.offset) + sum(
            share[q.schedule] * F(q.weight) * line(q.map, e) for q, e in terms
        )
        out.append(float(line(model.after_map, total)))
        last = at
    return np.array(out)


def bend(rng, low, high):
    """A random map with slopes from low to high."""
    u = np.sort(rng.choice(np.arange(-24, 25), rng.integers(2, 7), replace=False)) / 16
    v = np.concatenate([[rng.normal()], rng.uniform(low, high, u.size - 1) * np.diff(u)]).cumsum()
    return tuple(u.tolist()), tuple(v.tolist())


def random_model(seed, kinds=KINDS, room=0.1, schedules=(), period=0.02, **others):
    """A model of up to 12 elements whose slope is `room` or more: enough input is added."""
    rng = np.random.default_rng(seed)
    elements = []
    for kind in rng.choice(kinds, rng.integers(1, 12)).tolist():
        radius = (
            float(rng.choice([0.0, rng.uniform(0.0, 0.8)]))
            if kind != "path"
            else float(rng.uniform(0.1, 0.8))
        )
        time = float(rng.choice(TIMES)) * (0.02 if kind == "wide" else 1.0)
        pairs = bend(rng, -0.3, 1.0) if rng.random() < 0.4 else ((), ())
        share = int(rng.integers(0, 2 * len(schedules) + 1))
        elements.append(Element(kind, radius, time, float(rng.uniform(-0.2, 0.5)), pairs, share))
        if kind == "product":  # the lag it reads
            elements.append(
                Element("past", 0.0, float(rng.choice(TIMES)), float(rng.choice([0.0, 0.1])))
            )
    needed = room - min(
        0.0, least_slope([*elements, Element("input", weight=0.0)], len(schedules), period)
    )
    model = ElementModel(
        (*elements, Element("input", weight=needed)), period=period, schedules=schedules, **others
    )
    return replace(model, offset=float(rng.normal()))


def signal(seed, samples=200):
    """Strokes, jumps, stillness and noise within -1 .. 1."""
    rng = np.random.default_rng(seed)
    kind = rng.integers(4)
    if kind == 0:
        return rng.uniform(-1.0, 1.0, samples)
    turns = rng.uniform(-1.0, 1.0, 14)
    x = np.interp(np.linspace(0.0, 13.0, samples), np.arange(14), turns)
    if kind == 1:
        x = np.round(4.0 * x) / 4.0
    if kind == 2:
        x = np.repeat([-1.0, 1.0, -1.0, 1.0], samples // 4)
    return x
