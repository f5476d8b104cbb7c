"""The rigs: mechanisms with units, ranges, rates of sampling, sensors and parameters.

Parameters at seed 0 are those of the table. Another seed draws each parameter within some percent around it and new
densities of relays, so that every seed is another specimen of the same kind.
"""

from __future__ import annotations

import zlib
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from zoo.compiled import Array, Mechanism
from zoo.friction import (
    ageing_stage,
    bowden,
    control_valve,
    cylinder,
    gear,
    greased_drive,
    lugre_slide,
    muscle_joint,
    pinched_frame,
    regulator,
    spool,
    tendon,
)
from zoo.materials import (
    charged_mirror,
    elastomer,
    ionic,
    landau,
    loaded_stack,
    magnetostriction,
    memory_wire,
    moist_wood,
    phase_change,
    piezo,
    pinned_walls,
    soft_finger,
    solenoid,
    superelastic,
)

SPREAD = 0.08  # of a parameter between two specimens, the standard deviation of its logarithm
Table = Callable[[np.random.Generator], Array]


def no_table(random: np.random.Generator) -> Array:
    """Return an empty table, of a mechanism that has none."""
    return np.zeros((1, 3))


def relays(count: int, low: float, width: float, gain: float, lean: float = 1.0) -> Table:
    """Return what draws relays whose width depends on where they switch: a density that is no product.

    Rows are the input at which one switches up, that at which it switches down, and its weight.
    """

    def table(random: np.random.Generator) -> Array:
        middle = low + (1.0 - low) * random.beta(1.6, 1.6, count)
        half = width * (0.3 + 1.4 * np.abs(middle) ** 1.5) * random.lognormal(0.0, 0.6, count)
        weight = (0.4 + lean * np.abs(middle) + half / width) * random.uniform(0.5, 1.5, count)
        swing = 0.5 * gain * (1.0 - low)
        return np.column_stack([middle + half, middle - half, swing * weight / weight.sum()])

    return table


def wells(count: int, width: float, gain: float) -> Table:
    """Return what draws double wells: bias, half width of the loop of each, weight; the width goes with the bias."""

    def table(random: np.random.Generator) -> Array:
        bias = random.normal(0.0, 0.45, count)
        half = width * (0.5 + np.abs(bias)) * random.lognormal(0.0, 0.4, count)
        weight = random.uniform(0.5, 1.5, count)
        return np.column_stack([bias, half, gain * weight / weight.sum()])

    return table


def landscapes(walls: int, places: int) -> Table:
    """Return what draws the forces of rough landscapes, (walls, places), each with a mean of 0."""

    def table(random: np.random.Generator) -> Array:
        forces = random.normal(0.0, 1.0, (walls, places))
        return np.asarray(forces - forces.mean(axis=1, keepdims=True))

    return table


def in_steps(x: Array, parts: int) -> Array:
    """Return an input (T,) in so many steps for each sample (T parts,): a line between two samples."""
    begin = np.concatenate([x[:1], x[:-1]])
    shares = np.arange(1, parts + 1) / parts
    return np.asarray(begin[:, None] + (x - begin)[:, None] * shares).ravel()


@dataclass(frozen=True)
class Rig:
    """An actuator that can be played.

    Attributes
    ----------
    name, physics
        What it is, in a word and in a line.
    mechanism, parameters, table
        What answers, in shares of the range.
    low, high, unit
        Range of its input.
    scale, output_unit
        What an answer of 1 is at the output.
    period
        Of its sensor. [s]
    stroke
        Time in which its owner moves it over the range. [s]
    noise, quantum
        Standard deviation and step of its sensor. [output]
    step
        Longest step of time in which its mechanism is played. [s]
    seed
        Which specimen it is.
    """

    name: str
    physics: str
    mechanism: Mechanism
    parameters: tuple[float, ...]
    low: float
    high: float
    unit: str
    scale: float
    output_unit: str
    period: float
    stroke: float
    noise: float
    quantum: float
    table: Table = no_table
    step: float = np.inf
    seed: int = 0

    @property
    def one_sided(self) -> bool:
        """Whether the input begins at an end of its range, 0, and never changes its sign."""
        return self.low >= 0.0

    @property
    def rest(self) -> float:
        """Input of the rig when it is switched on. [input]"""
        return self.low if self.one_sided else 0.5 * (self.low + self.high)

    @property
    def rate(self) -> float:
        """Largest rate of a smooth stroke over the range. [input/s]"""
        return 1.875 * (self.high - self.low) / self.stroke

    def random(self, purpose: str) -> np.random.Generator:
        """Return a generator for one purpose, the same at every call."""
        return np.random.default_rng([self.seed, zlib.crc32(f"{self.name} {purpose}".encode())])

    def play(self, u: Array, period: float | None = None) -> Array:
        """Return the true output (T,) along an input (T,), from rest; inputs beyond the range are clipped.

        The sensor's noise and steps are not in it.
        """
        shares = (np.clip(u, self.low, self.high) - self.low) / (self.high - self.low)
        low = 0.0 if self.one_sided else -1.0
        shares = low + (1.0 - low) * shares
        parameters = np.array(self.parameters)
        if self.seed:
            drawn = self.random("parameters").standard_normal(parameters.size)
            parameters *= np.exp(SPREAD * drawn)
        table = self.table(self.random("table"))
        period = period or self.period
        parts = max(1, int(np.ceil(period / self.step - 1e-9)))
        fine = in_steps(shares, parts)
        y = self.mechanism(fine, period / parts, tuple(parameters.tolist()), table)
        return np.asarray(self.scale * y[parts - 1 :: parts])

    def measured(self, y: Array, purpose: str) -> Array:
        """Return what the sensor shows of an output (T,)."""
        noisy = y + self.noise * self.random(f"noise of {purpose}").standard_normal(y.size)
        if self.quantum:
            return np.round(noisy / self.quantum) * self.quantum
        return noisy


RIGS = {
    rig.name: rig
    for rig in (
        Rig(
            "piezo", "ferroelectric relays, creep with log time, resonance at 800 Hz",
            piezo, (0.0, 0.75, 0.12, 0.006, 800.0, 800.0, 0.04),
            low=0.0, high=120.0, unit="V", scale=95.0, output_unit="um",
            period=1e-4, stroke=0.05, noise=0.02, quantum=0.0,
            table=relays(400, 0.0, 0.1, 0.3), step=2.5e-5,
        ),
        Rig(
            "stack", "piezo stack against a spring: width grows with load, zero drifts with heat",
            loaded_stack, (0.0, 0.7, 0.25, 1.2, 0.02, 0.02),
            low=0.0, high=150.0, unit="V", scale=60.0, output_unit="um",
            period=1e-3, stroke=0.5, noise=0.03, quantum=0.05,
            table=relays(300, 0.0, 0.07, 0.4, lean=-0.3),
        ),
        Rig(
            "terfenol", "magnetostriction (Jiles-Atherton squared) behind eddy currents",
            magnetostriction, (0.22, 0.12, 0.08, 0.15, 0.004, 0.012),
            low=0.0, high=4.0, unit="A", scale=80.0, output_unit="um",
            period=5e-4, stroke=0.4, noise=0.04, quantum=0.0,
            step=1e-4,
        ),
        Rig(
            "elastomer", "dielectric elastomer: stress of V squared, two networks that yield",
            elastomer, (0.15, 0.35, 0.012, 300.0, 0.2, 3.0),
            low=0.0, high=4.5, unit="kV", scale=6.0, output_unit="mm",
            period=0.02, stroke=4.0, noise=0.006, quantum=0.0,
        ),
        Rig(
            "wire", "shape-memory wire (Liang-Rogers cosine) behind its heat",
            memory_wire, (60.0, 0.5, 78.0, 40.0, 50.0, 94.0, 10.0, 6.0),
            low=0.0, high=2.6, unit="W", scale=9.0, output_unit="mm",
            period=0.1, stroke=40.0, noise=0.01, quantum=0.005,
            step=0.05,
        ),
        Rig(
            "muscles", "two pneumatic muscles: dead time, choked valves, friction of braid by pressure",
            muscle_joint, (0.025, 14.0, 1.5, 0.02, 0.3, 0.12, 0.35, 0.25),
            low=-2.0, high=2.0, unit="bar", scale=42.0, output_unit="deg",
            period=0.01, stroke=4.0, noise=0.02, quantum=0.01,
            step=2e-4,
        ),
        Rig(
            "tendon", "backlash, then friction exponential in an angle that grows with the motion",
            tendon, (0.02, 0.35, 3.0, 0.4, 0.12, 0.25, 0.8, 1.2, 0.15),
            low=-60.0, high=60.0, unit="deg", scale=60.0, output_unit="deg",
            period=0.01, stroke=4.0, noise=0.01, quantum=0.022,
            step=1e-3,
        ),
        Rig(
            "valve", "control valve: choked air, mass, stiction of the packing, forces of the flow",
            control_valve, (0.15, 0.6, 0.0015, 0.05, 0.03, 0.05, 0.25, 0.15),
            low=4.0, high=20.0, unit="mA", scale=100.0, output_unit="%",
            period=0.02, stroke=8.0, noise=0.05, quantum=0.1,
            step=2e-4,
        ),
        Rig(
            "slide", "slide with mass on bristles (LuGre) against a stiffening spring",
            lugre_slide, (0.0008, 1.0, 0.25, 40.0, 0.1, 0.08, 0.11, 0.3, 0.02),
            low=-3.0, high=3.0, unit="A", scale=12.0, output_unit="mm",
            period=1e-3, stroke=0.6, noise=0.002, quantum=0.001,
            step=2.5e-5,
        ),
        Rig(
            "cylinder", "pneumatic cylinder against a spring: sonic nozzle, seals that drag by pressure",
            cylinder, (4.0, 0.7, 0.08, 0.015, 0.06, 0.5, 0.2, 0.03),
            low=0.0, high=10.0, unit="V", scale=160.0, output_unit="mm",
            period=5e-3, stroke=2.0, noise=0.05, quantum=0.1,
            step=2e-4,
        ),
        Rig(
            "wax", "wax motor: layers that melt and freeze late, conduction",
            phase_change, (24.0, 0.3, 0.8, 10.0, 48.0, 6.0, 25.0, 0.25),
            low=0.0, high=15.0, unit="W", scale=8.0, output_unit="mm",
            period=1.0, stroke=900.0, noise=0.004, quantum=0.0,
            step=0.2,
        ),
        Rig(
            "wood", "moist wood: pores that fill and empty late, diffusion that eases with dampness",
            moist_wood, (0.5, 0.6, 1.2, 0.6),
            low=0.0, high=90.0, unit="%RH", scale=4.2, output_unit="mm",
            period=2.0, stroke=600.0, noise=0.002, quantum=0.001,
            table=relays(150, 0.0, 0.1, 0.5), step=0.5,
        ),
        Rig(
            "solenoid", "proportional solenoid: iron with relays, eddy currents, pull of the flux squared",
            solenoid, (0.0, 0.75, 0.003, 0.02, 0.35),
            low=0.0, high=1.6, unit="A", scale=90.0, output_unit="N",
            period=1e-3, stroke=0.5, noise=0.04, quantum=0.02,
            table=relays(300, 0.0, 0.06, 0.5), step=2e-4,
        ),
        Rig(
            "landau", "ferroelectric double wells that slide over at a finite rate",
            landau, (0.5, 0.004, 0.06),
            low=-200.0, high=200.0, unit="V", scale=12.0, output_unit="um",
            period=1e-3, stroke=0.8, noise=0.004, quantum=0.0,
            table=wells(80, 0.18, 0.35), step=2.5e-4,
        ),
        Rig(
            "finger", "silicone finger: Mullins' softening that heals, flow of fillers",
            soft_finger, (0.3, 0.012, 900.0, 0.35, 2000.0, 0.15, 1.0),
            low=0.0, high=80.0, unit="kPa", scale=70.0, output_unit="deg",
            period=0.04, stroke=5.0, noise=0.05, quantum=0.09,
        ),
        Rig(
            "ionic", "ionic polymer: barrier, bound ions, water that flows back",
            ionic, (0.12, 0.8, 0.3, 0.2, 40.0, 0.01, 0.6),
            low=-3.0, high=3.0, unit="V", scale=5.0, output_unit="mm",
            period=0.05, stroke=10.0, noise=0.003, quantum=0.0,
            step=0.005,
        ),
        Rig(
            "walls", "domain walls pinned in rough landscapes",
            pinned_walls, (1.0, 0.13, 0.002, 14.0, 0.25),
            low=-2.0, high=2.0, unit="A", scale=30.0, output_unit="mrad",
            period=2e-3, stroke=1.0, noise=0.01, quantum=0.0,
            table=landscapes(24, 64), step=6.5e-5,
        ),
        Rig(
            "mirror", "electrostatic mirror: softening, resonance, charge trapped in the insulator",
            charged_mirror, (0.15, 0.35, 0.006, 60.0, 1200.0, 0.08),
            low=0.0, high=55.0, unit="V", scale=8.0, output_unit="mrad",
            period=1e-4, stroke=0.05, noise=0.001, quantum=0.0,
            step=1.7e-5,
        ),
        Rig(
            "flag", "self-centring joint of superelastic wires: flags, warmed by their own transformation",
            superelastic, (1.6, 0.3, 0.85, 0.7, 0.16, 0.5, 0.12, 6.0),
            low=-25.0, high=25.0, unit="kN", scale=40.0, output_unit="mm",
            period=0.04, stroke=8.0, noise=0.02, quantum=0.01,
        ),
        Rig(
            "frame", "timber frame: pinching, holes that wear, springs in series",
            pinched_frame, (0.35, 2.4, 0.8, 1.3, 0.7, 0.15, 0.25, 0.12, 0.4),
            low=-60.0, high=60.0, unit="mm", scale=45.0, output_unit="kN",
            period=0.02, stroke=6.0, noise=0.03, quantum=0.01,
            step=8.4e-4,
        ),
        Rig(
            "stage", "stage whose friction ages at rest (rate and state)",
            ageing_stage, (4.0, 1.0, 0.12, 0.006, 0.009, 0.001, 0.01, 0.25),
            low=-10.0, high=10.0, unit="mm", scale=10.0, output_unit="mm",
            period=5e-3, stroke=2.5, noise=0.002, quantum=0.001,
            step=5e-4,
        ),
        Rig(
            "grease", "vane in thixotropic grease that grows stiff at rest",
            greased_drive, (0.12, 0.05, 0.7, 0.15, 0.6, 0.4, 0.2),
            low=-1.5, high=1.5, unit="Nm", scale=60.0, output_unit="deg",
            period=0.01, stroke=4.0, noise=0.01, quantum=0.02,
            step=1e-3,
        ),
        Rig(
            "spool", "hydraulic positioner: overlap, flow by the root of pressure, seals",
            spool, (0.015, 60.0, 0.3, 0.1, 0.6, 0.012, 0.1),
            low=-40.0, high=40.0, unit="mA", scale=75.0, output_unit="mm",
            period=2e-3, stroke=1.2, noise=0.01, quantum=0.0,
            step=1e-3,
        ),
        Rig(
            "gear", "load behind teeth with a gap, grease, zero that drifts with heat",
            gear, (0.025, 40.0, 0.5, 0.02, 0.2, 0.06, 0.3, 0.01, 120.0),
            low=-180.0, high=180.0, unit="deg", scale=180.0, output_unit="deg",
            period=5e-3, stroke=2.0, noise=0.02, quantum=0.088,
            step=5e-5,
        ),
        Rig(
            "bowden", "cable in a sheath: pieces in series that drag by the pull through them",
            bowden, (0.5, 0.25, 4.0, 1.0, 0.04, 0.2),
            low=0.0, high=30.0, unit="mm", scale=30.0, output_unit="mm",
            period=0.01, stroke=3.0, noise=0.005, quantum=0.01,
            step=1e-4,
        ),
        Rig(
            "regulator", "pressure regulator: dead time, poppet that sticks, choked flow",
            regulator, (0.03, 3.0, 2.2, 0.02, 0.6, 1.0, 0.1),
            low=0.0, high=10.0, unit="V", scale=8.0, output_unit="bar",
            period=0.01, stroke=4.0, noise=0.004, quantum=0.002,
            step=5e-4,
        ),
    )
}  # fmt: skip
# Every second one, by place in the table: rigs of one kind stand beside each other there.
DESIGN = tuple(RIGS)[::2]
JUDGE = tuple(RIGS)[1::2]
