"""Simulated control loops with a sticking valve: set point SP, controller output OP, measurement PV, valve position MV.

    python examples/simulators/valve_loop.py log.csv [--valve kano] [--dead-band 4] [--jump 2] [--process flow]
    python examples/simulators/valve_loop.py manual.csv --test test.csv   # in manual, the output of a test

Valves: `choudhury` and `kano` move on until the signal turns, `he` sticks after every sample, `friction` is a mass with
a spring, a lagging actuator and packing friction that falls with speed (Karnopp), `linear` does not stick. Everything
is in percent of the span. `--wave sine` lets an external disturbance swing the loop.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from dehyst.io import write_csv

Array = NDArray[np.float64]


class Linear:
    """A valve that follows."""

    def __init__(self, dead_band: float, jump: float, period: float, at: float) -> None:
        del dead_band, jump, period, at

    def step(self, signal: float) -> float:
        """Return the position after a sample of the signal."""
        return signal


class Choudhury:
    """Two parameters S and J, after Choudhury, Thornhill and Shah (2005): sticks where the signal turns or rests."""

    def __init__(self, dead_band: float, jump: float, period: float, at: float) -> None:
        del period
        self.dead_band, self.jump = dead_band, jump
        self.stuck_at = self.last = self.position = at
        self.last_direction = 0.0
        self.needed = jump
        self.is_stuck = False

    def step(self, signal: float) -> float:
        """Return the position after a sample of the signal."""
        direction = float(np.sign(signal - self.last))
        if direction != self.last_direction and not self.is_stuck:
            # A turn needs all of the dead band, a rest only the jump.
            self.stuck_at, self.is_stuck = self.last, True
            self.moved_to = self.last_direction
        self.last, self.last_direction = signal, direction
        if self.is_stuck:
            way = signal - self.stuck_at
            same_way = way * self.moved_to > 0.0
            if abs(way) <= (self.jump if same_way else self.dead_band):
                return self.position
            self.is_stuck = False
            direction = float(np.sign(way))
        if direction:
            self.position = signal - 0.5 * direction * (self.dead_band - self.jump)
        return self.position


class Kano:
    """Kano, Maruta, Kugemoto and Shimizu (2004): the same numbers, and the direction of friction is remembered."""

    def __init__(self, dead_band: float, jump: float, period: float, at: float) -> None:
        del period
        self.dead_band, self.jump = dead_band, jump
        self.stuck_at, self.last, self.position = at, at, at
        self.friction, self.last_change, self.is_stuck = 1.0, 0.0, False

    def step(self, signal: float) -> float:
        """Return the position after a sample of the signal."""
        change = signal - self.last
        if change * self.last_change <= 0.0 and not self.is_stuck:
            self.stuck_at, self.is_stuck = self.last, True
        if not self.is_stuck:
            self.position = signal - 0.5 * self.friction * (self.dead_band - self.jump)
        elif -self.friction * (signal - self.stuck_at) > self.dead_band:
            self.friction, self.is_stuck = -self.friction, False
            self.position = signal - 0.5 * self.friction * (self.dead_band - self.jump)
        elif self.friction * (signal - self.stuck_at) > self.jump:
            self.is_stuck = False
            self.position = signal - 0.5 * self.friction * (self.dead_band - self.jump)
        self.last, self.last_change = signal, change
        return self.position


class He:
    """He, Wang, Pottmann and Qin (2007): static and kinetic friction, at rest again after every sample."""

    def __init__(self, dead_band: float, jump: float, period: float, at: float) -> None:
        del period
        self.static, self.kinetic = 0.5 * (dead_band + jump), 0.5 * (dead_band - jump)
        self.residue, self.last, self.position = 0.0, at, at

    def step(self, signal: float) -> float:
        """Return the position after a sample of the signal."""
        force = self.residue + signal - self.last
        self.last = signal
        if abs(force) <= self.static:
            self.residue = force
            return self.position
        self.residue = math.copysign(self.kinetic, force)
        self.position = signal - self.residue
        return self.position


class Friction:
    """Mass, spring, damping, lagging actuator, and dry friction that falls from static to kinetic with speed.

    Karnopp's way to stand still. The numbers beside the friction are assumptions, of a small pneumatic valve: natural
    frequency 50 rad/s, damping 0.1 s of the spring, actuator 0.3 s, Stribeck speed 1 %/s.
    """

    STEP, STIFFNESS, DAMPING, LAG, STRIBECK = 0.005, 2500.0, 250.0, 0.3, 1.0

    def __init__(self, dead_band: float, jump: float, period: float, at: float) -> None:
        self.static, self.kinetic = 0.5 * (dead_band + jump), 0.5 * (dead_band - jump)
        self.steps = max(1, round(period / self.STEP))
        self.actuator = self.position = at
        self.speed = 0.0

    def step(self, signal: float) -> float:
        """Return the position after a sample of the signal."""
        h, k = self.STEP, self.STIFFNESS
        share = 1.0 - math.exp(-h / self.LAG)
        p, x, v = self.actuator, self.position, self.speed
        for _ in range(self.steps):
            p += share * (signal - p)
            push = p - x
            if v == 0.0:
                if abs(push) <= self.static:
                    continue
                direction = math.copysign(1.0, push)
            else:
                direction = math.copysign(1.0, v)
            level = self.kinetic + (self.static - self.kinetic) * math.exp(-abs(v) / self.STRIBECK)
            faster = (v + h * k * (push - direction * level)) / (1.0 + h * self.DAMPING)
            if faster * direction <= 0.0:
                faster = 0.0
            v = faster
            x += h * v
        self.actuator, self.position, self.speed = p, x, v
        return x


VALVES: dict[str, Callable[[float, float, float, float], Linear | Choudhury | Kano | He | Friction]] = {
    "linear": Linear, "choudhury": Choudhury, "kano": Kano, "he": He, "friction": Friction,
}  # fmt: skip


@dataclass(frozen=True)
class Process:
    """Gain, lags and dead time from the valve to the measurement; a gain for each second where it integrates."""

    period: float
    gain: float
    lags: tuple[float, ...]
    dead_time: float
    proportional: float
    reset_time: float
    integrates: bool = False


PROCESSES = {
    "flow": Process(1.0, 1.0, (3.0,), 1.0, 0.4, 3.0),
    "pressure": Process(1.0, 1.5, (20.0,), 2.0, 1.2, 15.0),
    "level": Process(5.0, 0.002, (5.0,), 5.0, 4.0, 300.0, True),
    "temperature": Process(5.0, 1.2, (80.0, 25.0), 15.0, 1.8, 80.0),
}


@dataclass
class Loop:
    """What is simulated.

    `noise` is white, `load` a slow random disturbance before the process (both as standard deviations in percent),
    `wave` an external one of a shape, an amplitude and a period, `steps` changes the set point by so many percent.
    """

    process: Process
    valve: str = "kano"
    dead_band: float = 4.0
    jump: float = 2.0
    noise: float = 0.1
    load: float = 0.3
    wave: tuple[str, float, float] | None = None
    steps: float = 0.0
    detune: float = 1.0
    samples: int = 2400
    seed: int = 0
    manual: Array | None = None
    columns: dict[str, Array] = field(default_factory=dict)

    def run(self) -> dict[str, Array]:
        """Return time, SP, OP, PV and MV."""
        rng = np.random.default_rng(self.seed)
        p = self.process
        dt, size = p.period, self.samples
        valve = VALVES[self.valve](self.dead_band, self.jump, dt, 50.0)
        delay = round(p.dead_time / dt)
        waiting = [50.0] * (delay + 1)
        states = [50.0] * len(p.lags)
        level = 50.0
        integral = load = 0.0
        points = 50.0 + self.steps * np.repeat(rng.choice([-1.0, 0.0, 1.0], size // 300 + 1), 300)[:size]
        noise = self.noise * rng.normal(size=size)
        pushes = rng.normal(size=size)
        memory = math.exp(-dt / (20.0 * p.lags[0]))
        wave = _wave(self.wave, dt * np.arange(size), rng)
        op, pv, mv = np.empty(size), np.empty(size), np.empty(size)
        gain = self.detune * p.proportional
        for k in range(size):
            pv[k] = level + noise[k]
            if self.manual is None:
                error = points[k] - pv[k]
                integral += gain * error * dt / p.reset_time
                integral = min(max(integral, -60.0), 60.0)
                op[k] = min(max(50.0 + gain * error + integral, 0.0), 100.0)
            else:
                op[k] = self.manual[k]
            mv[k] = valve.step(op[k])
            waiting.append(mv[k])
            # The load pushes like a valve: 50 % holds the level.
            load = memory * load + math.sqrt(1.0 - memory**2) * self.load * pushes[k]
            driven = waiting.pop(0) + load + wave[k]
            for j, lag in enumerate(p.lags):
                states[j] += (1.0 - math.exp(-dt / lag)) * (driven - states[j])
                driven = states[j]
            if p.integrates:
                level += p.gain * (driven - 50.0) * dt
            else:
                level = 50.0 + p.gain * (driven - 50.0)
        time = dt * np.arange(size)
        return {"time_s": time, "SP": points, "OP": op, "PV": pv, "MV": mv}


def _wave(wave: tuple[str, float, float] | None, time: Array, rng: np.random.Generator) -> Array:
    """An external disturbance: a sine, a triangle, a square, or a square whose half periods vary by a tenth."""
    if wave is None:
        return np.zeros(time.size)
    shape, amplitude, period = wave
    phase = time / period
    if shape == "sine":
        return amplitude * np.sin(2.0 * np.pi * phase)
    if shape == "triangle":
        return amplitude * (4.0 * np.abs(phase % 1.0 - 0.5) - 1.0)
    if shape == "square":
        return amplitude * np.sign(np.sin(2.0 * np.pi * phase + 1e-9))
    halves = 0.5 * period * (1.0 + 0.1 * rng.normal(size=2 + 3 * int(phase[-1])))
    return amplitude * (1.0 - 2.0 * (np.searchsorted(np.cumsum(np.abs(halves)), time) % 2))


def main() -> None:
    """Write a log."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", type=Path)
    parser.add_argument("--valve", default="kano", choices=list(VALVES))
    parser.add_argument("--dead-band", type=float, default=4.0)
    parser.add_argument("--jump", type=float, default=2.0)
    parser.add_argument("--process", default="flow", choices=list(PROCESSES))
    parser.add_argument("--wave", choices=["sine", "triangle", "square", "jittered"])
    parser.add_argument("--test", type=Path, help="CSV file with the controller output, OP")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    process = PROCESSES[options.process]
    loop = Loop(process, options.valve, options.dead_band, options.jump, seed=options.seed)
    if options.wave:
        loop.wave = (options.wave, 3.0, 13.0 * process.lags[0])
    if options.test:
        rows = np.loadtxt(options.test, delimiter=",", skiprows=1)
        loop.manual, loop.samples = rows[:, 1], len(rows)
    write_csv(options.out, loop.run())


if __name__ == "__main__":
    main()
