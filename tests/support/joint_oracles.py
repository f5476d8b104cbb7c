"""A joint in plain Python to test the controller on: chambers, valves, a rigid body; nothing shared with the core."""

from __future__ import annotations

import math

import numpy as np

PERIOD = 5e-4
SUPPLY, AMBIENT, RT, N, RHO, CONDUCTANCE, RATIO, BAND = (
    8.013e5,
    1.013e5,
    287.0 * 293.0,
    1.26,
    1.185,
    2e-8,
    0.3,
    0.03,
)


def psi(ratio, b=RATIO):
    """Return the flow function of ISO 6358 as the standard prints it, with a straight line above 0.999."""
    if ratio <= b:
        return 1.0
    if ratio >= 1.0:
        return 0.0
    if ratio > 0.999:
        return psi(0.999, b) * (1.0 - ratio) / 0.001
    return math.sqrt(1.0 - ((ratio - b) / (1.0 - b)) ** 2)


def opened(command, band=BAND):
    """Return how far a command opens a valve with a dead band."""
    return math.copysign(max(0.0, abs(command) - band) / (1.0 - band), command)


def flow(opening, p):
    """Return the mass flow [kg/s] into a chamber at absolute pressure p."""
    if opening >= 0:
        return CONDUCTANCE * RHO * opening * SUPPLY * psi(p / SUPPLY)
    return CONDUCTANCE * RHO * opening * p * psi(AMBIENT / p)


def volume(coefficients, q):
    """Return V(q) and V'(q)."""
    return (
        sum(v * q**j for j, v in enumerate(coefficients)),
        sum(j * v * q ** (j - 1) for j, v in enumerate(coefficients) if j),
    )


class Chamber:
    """One muscle's air: spool of 100 Hz, valve, polytropic change, four substeps a period."""

    def __init__(self, gauge, coefficients, substeps=4):
        self.p, self.coefficients, self.substeps = gauge + AMBIENT, coefficients, substeps
        self.spool = self.speed = 0.0

    def step(self, command, q, qd):
        h, w = PERIOD / self.substeps, 2 * math.pi * 100
        for i in range(self.substeps):
            self.speed += h * (w * w * (command - self.spool) - 1.4 * w * self.speed)
            self.spool += h * self.speed
            v, slope = volume(self.coefficients, q + qd * h * i)
            self.p += h * N / v * (RT * flow(opened(self.spool), self.p) - self.p * slope * qd)
        return self.p - AMBIENT


def quantised(q, step=2 * math.pi / 2**17):
    """Return what a 17-bit encoder says."""
    return round(q / step) * step


class Rig:
    """A joint of two muscles: torque A p_m + B dp + C, less `load(q)`, on an inertia; air as above."""

    def __init__(
        self, parameters, q=0.0, inertia=5.0, load=lambda q: 0.0, damping=3.0, noise=250.0, seed=0
    ):
        self.polynomials = [
            np.polynomial.Polynomial(c) for c in (parameters.a, parameters.b, parameters.c)
        ]
        self.chambers = [Chamber(3e5, v, substeps=2) for v in parameters.volume]
        self.q, self.qd, self.inertia, self.load, self.damping = q, 0.0, inertia, load, damping
        self.rng, self.noise = np.random.default_rng(seed), noise

    def torque(self):
        p = [c.p - AMBIENT for c in self.chambers]
        q = self.q
        a, b, c = (sum(x * q**j for j, x in enumerate(f.coef)) for f in self.polynomials)
        return a * (p[0] + p[1]) / 2 + b * (p[0] - p[1]) + c

    def read(self):
        n = self.rng.normal(size=2) * self.noise
        return (
            quantised(self.q),
            self.chambers[0].p - AMBIENT + n[0],
            self.chambers[1].p - AMBIENT + n[1],
        )

    def step(self, valves):
        acceleration = (self.torque() - self.load(self.q) - self.damping * self.qd) / self.inertia
        for chamber, command in zip(self.chambers, valves, strict=True):
            chamber.step(command, self.q, self.qd)
        self.qd += PERIOD * acceleration
        self.q += PERIOD * self.qd


def reference_along(time, amplitude=0.35, frequency=0.25):
    """Return a smooth reference (T, 7) that starts at rest: angle, two derivatives, no load, 3 bar."""
    w, t = 2 * math.pi * frequency, np.asarray(time)
    s = np.clip(t, 0, 1)
    ease, slope, bend = (
        s**3 * (10 - 15 * s + 6 * s**2),
        30 * s**2 * (1 - s) ** 2,
        60 * s * (1 - s) * (1 - 2 * s),
    )
    wave, speed = np.sin(w * t), w * np.cos(w * t)
    out = np.zeros((t.size, 7))
    out[:, 0] = amplitude * ease * wave
    out[:, 1] = amplitude * (slope * wave + ease * speed)
    out[:, 2] = amplitude * (bend * wave + 2 * slope * speed - ease * w * w * wave)
    out[:, 4] = 3e5
    return out


def closed_loop(controller, rig, reference, switches, spoil=lambda k, reading: reading):
    """Run a controller on a rig: true angles (T,) and the outputs; `spoil` may falsify readings."""
    from dehyst_robot.control import JointReference

    controller.reset(*rig.read())
    angles, outputs = [], []
    for k in range(len(reference)):
        on = switches[k] if np.ndim(switches) else switches
        out = controller.step(*spoil(k, rig.read()), JointReference(*reference[k]), on)
        angles.append(rig.q)
        outputs.append(out)
        rig.step((out.valve_1, out.valve_2))
    return np.array(angles), outputs


def column(outputs, name):
    """Return one field of a list of outputs as an array."""
    return np.array([getattr(out, name) for out in outputs])
