"""Rigs of mechanisms that are no family of dehyst, on which compensators are compared: relays with creep and
temperature, Bouc-Wen, dry and viscous friction, LuGre, plays behind a dead time.

A rig is played for many demands at once: `step` takes one input for each of K copies. Parameters are drawn from the
seed; input and output are of the order of 1.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import Protocol

import numpy as np
import numpy.typing as npt

import dehyst

Array = npt.NDArray[np.float64]

PERIOD = 0.02  # [s]
NOISE = 0.001  # of the output's range
APPROACH = 200  # samples from rest to the reference, not scored
STROKES = 14
SPEEDS = (0.4, 0.8, 1.6)  # of a stroke, in its middle [1/s]
SUBSTEPS = 8


class Rig(Protocol):
    """An actuator: K copies of it are moved together."""

    def start(self, copies: int) -> None:
        """Bring all copies to their first state."""

    def step(self, u: Array) -> Array:
        """Outputs (K,) one period later, with inputs (K,)."""


class Relays:
    """500 relays, creep of their sum, gain that follows a slow temperature."""

    def __init__(self, random: np.random.Generator) -> None:
        center, half = random.normal(0.0, 0.45, 500), np.abs(random.normal(0.25, 0.15, 500))
        self.up, self.down = center + half, center - half
        self.weight = random.uniform(0.5, 1.5, 500)
        self.weight /= self.weight.sum()
        self.line, self.creep, self.lag = (
            random.uniform(0.3, 0.8),
            random.uniform(0.02, 0.08),
            random.uniform(2.0, 20),
        )
        self.warm = random.uniform(-0.01, 0.01)

    def start(self, copies: int) -> None:
        self.relay = np.tile(np.where(self.up + self.down > 0.0, -1.0, 1.0), (copies, 1))
        self.z, self.time = np.zeros(copies), 0.0

    def step(self, u: Array) -> Array:
        self.relay = np.where(
            u[:, None] >= self.up, 1.0, np.where(u[:, None] <= self.down, -1.0, self.relay)
        )
        v = self.relay @ self.weight + self.line * u
        self.z = self.z - np.expm1(-PERIOD / self.lag) * (v - self.z)
        self.time += PERIOD
        return np.asarray((v + self.creep * self.z) * (1.0 + self.warm * np.sin(self.time / 60.0)))


class BoucWen:
    """Bouc 1967, Wen 1976, behind a gain that saturates."""

    def __init__(self, random: np.random.Generator) -> None:
        self.beta, self.gamma = random.uniform(0.5, 2.5), random.uniform(-0.3, 0.8)
        self.n, self.share = random.uniform(1.0, 2.0), random.uniform(0.1, 0.35)
        self.bend = 0.15 * random.uniform(0.0, 0.5)

    def start(self, copies: int) -> None:
        self.z, self.u = np.zeros(copies), np.full(copies, np.nan)

    def step(self, u: Array) -> Array:
        way = np.where(np.isnan(self.u), 0.0, u - self.u) / SUBSTEPS
        for _ in range(SUBSTEPS):
            power = np.abs(self.z) ** (self.n - 1.0)
            self.z = (
                self.z
                + way
                - np.abs(way) * self.beta * power * self.z
                - way * self.gamma * power * np.abs(self.z)
            )
        self.u = u.copy()
        v = u - self.share * self.z
        return np.asarray(v - self.bend * v**3)


class Friction:
    """A spring, progressive, that drags against dry friction with Stribeck's drop, and viscous friction."""

    def __init__(self, random: np.random.Generator) -> None:
        self.dry, self.drop = random.uniform(0.08, 0.2), random.uniform(0.0, 0.3)
        self.viscous, self.cubic = random.uniform(0.02, 0.1), random.uniform(-0.2, 0.3)

    def start(self, copies: int) -> None:
        self.y, self.speed = np.zeros(copies), np.zeros(copies)

    def step(self, u: Array) -> Array:
        for _ in range(SUBSTEPS):
            force = u - self.y - self.cubic * self.y**3
            dry = self.dry * (1.0 + self.drop * np.exp(-((self.speed / 0.1) ** 2)))
            self.speed = np.sign(force) * np.maximum(np.abs(force) - dry, 0.0) / self.viscous
            self.y = self.y + np.clip(self.speed * PERIOD / SUBSTEPS, -np.abs(force), np.abs(force))
        return self.y


class LuGre:
    """A spring that drags against bristles (Canudas de Wit and others 1995) and viscous friction, without mass."""

    def __init__(self, random: np.random.Generator) -> None:
        self.stiff, self.coulomb = random.uniform(5.0, 20.0), random.uniform(0.05, 0.2)
        self.drop, self.viscous = random.uniform(0.0, 0.1), random.uniform(0.05, 0.15)

    def start(self, copies: int) -> None:
        self.y, self.z = np.zeros(copies), np.zeros(copies)

    def step(self, u: Array) -> Array:
        part = PERIOD / (2 * SUBSTEPS)
        for _ in range(2 * SUBSTEPS):
            speed = (u - self.y - self.stiff * self.z) / self.viscous
            most = self.coulomb + self.drop * np.exp(-((speed / 0.2) ** 2))
            self.z = self.z + (speed - self.stiff * np.abs(speed) * self.z / most) * part
            self.y = self.y + speed * part
        return self.y


class Late:
    """Six plays and a curve behind a dead time of some periods and a short lag."""

    def __init__(self, random: np.random.Generator) -> None:
        self.radius, self.weight = (
            np.sort(random.uniform(0.02, 0.9, 6)),
            random.uniform(0.05, 0.2, 6),
        )
        self.square, self.periods = random.uniform(-0.15, 0.15), int(random.integers(1, 5))
        self.lag = random.uniform(0.01, 0.05)

    def start(self, copies: int) -> None:
        self.z, self.y = np.zeros((copies, 6)), np.zeros(copies)
        self.queue = [np.zeros(copies)] * self.periods

    def step(self, u: Array) -> Array:
        self.queue.append(u.copy())
        late = self.queue.pop(0)
        self.z = np.clip(self.z, late[:, None] - self.radius, late[:, None] + self.radius)
        v = 0.6 * late + self.z @ self.weight
        self.y = self.y - np.expm1(-PERIOD / self.lag) * (v + self.square * v * v - self.y)
        return self.y


MECHANISMS: dict[str, Callable[[np.random.Generator], Rig]] = {
    "relays, creep, temperature": Relays,
    "Bouc-Wen": BoucWen,
    "friction": Friction,
    "LuGre": LuGre,
    "dead time": Late,
}


def played(rig: Rig, inputs: Array) -> Array:
    """Outputs (K, T) of K copies of a rig from its first state."""
    rig.start(len(inputs))
    return np.stack([rig.step(u) for u in inputs.T], axis=1)


def logged(mechanism: str, seed: int) -> tuple[Rig, dehyst.Recording, Array]:
    """A rig, a log of it, and a reference (T,) within its range that was never logged."""
    random = np.random.default_rng([seed, list(MECHANISMS).index(mechanism)])
    rig = MECHANISMS[mechanism](random)
    u = strokes(random)
    y = played(rig, u[None])[0]
    measured = y + NOISE * np.ptp(y) * random.standard_normal(y.size)
    low, high = np.quantile(y, [0.03, 0.97])
    wanted = 0.5 * (low + high) + 0.4 * (high - low) * sines(random, 3000)
    whole = np.concatenate([np.linspace(y[0], wanted[0], APPROACH, endpoint=False), wanted])
    record = dehyst.Recording(
        input=u, output=measured, time=PERIOD * np.arange(u.size), name=f"{mechanism} {seed}"
    )
    return rig, record, whole


def strokes(random: np.random.Generator) -> Array:
    """Strokes of many sizes and speeds, some with a rest behind them."""
    sizes = np.concatenate([[1.0, 1.0], random.uniform(0.15, 1.0, STROKES)])
    tips = [
        0.0,
        *(sign * size * random.uniform(0.8, 1.0) for size in sizes for sign in (1.0, -1.0)),
    ]
    parts = []
    for begin, end in pairwise(tips):
        samples = max(8, int(abs(end - begin) / random.choice(SPEEDS) / PERIOD))
        parts.append(
            begin + (end - begin) * 0.5 * (1.0 - np.cos(np.pi * np.arange(samples) / samples))
        )
        if random.random() < 0.25:
            parts.append(np.full(int(1.0 / PERIOD), end))
    return np.concatenate(parts)


def sines(random: np.random.Generator, samples: int) -> Array:
    """Five sines of 0.03 to 0.25 Hz, within -1..1."""
    time = PERIOD * np.arange(samples)
    y = sum(random.uniform(0.3, 1.0) * np.sin(2.0 * np.pi * f * time + random.uniform(0.0, 2.0 * np.pi))
            for f in random.uniform(0.03, 0.25, 5))  # fmt: skip
    return np.asarray(y / np.max(np.abs(y)))
