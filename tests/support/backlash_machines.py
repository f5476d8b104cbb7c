"""Simulated axes, and machines that read tables as their documentation and sources say: nothing of the package is used.

LinuxCNC: `usrmotLoadComp` (sscanf of three numbers a line, stops at the first other line), `EMCMOT_SET_JOINT_COMP`
(nominal must rise, at most 256), `compute_screw_comp` (trim of the sign of the velocity, straight between entries,
constant beyond them). grblHAL: `mc_line`, a move of its own before the first one after a turn, its steps not counted.
Marlin: `Backlash::add_correction_steps`, steps added to the first moves after a turn, at most as many as a move has.
"""

from __future__ import annotations

import re

import numpy as np


class Axis:
    """A motor, a play whose width depends on the position, and a screw with a pitch error."""

    def __init__(self, play=0.04, pitch=0.0, start=0.0):
        self.play = play if callable(play) else lambda position: play
        self.pitch = pitch if callable(pitch) else lambda position: pitch
        self.nut = start

    def move(self, motor):
        """Send the motor somewhere; return where the axis is."""
        half = 0.5 * self.play(motor)
        self.nut = min(max(self.nut, motor - half), motor + half)
        return self.nut + self.pitch(self.nut)


class Plain:
    """A machine without compensation."""

    def __init__(self, axis, text=""):
        self.axis, self.command = axis, 0.0

    def go(self, target):
        """Move to a commanded position; return where the axis is."""
        self.command = target
        return self.axis.move(self.motor(target))

    def motor(self, target):
        return target


class LinuxCNC(Plain):
    """A joint with COMP_FILE."""

    def __init__(self, axis, text, kind=0):
        super().__init__(axis)
        self.nominal, self.forward, self.reverse = [], [], []
        self.reports, self.velocity = [], 0
        for line in text.split("\n"):
            match = re.match(r"\s*([-+.\deE]+)\s+([-+.\deE]+)\s+([-+.\deE]+)", line)
            if match is None:
                break
            nominal, forward, reverse = map(float, match.groups())
            if kind == 0:
                forward, reverse = nominal - forward, nominal - reverse
            if len(self.nominal) >= 256:
                self.reports.append("too many compensation entries")
            elif self.nominal and nominal <= self.nominal[-1]:
                self.reports.append("compensation values must increase")
            else:
                self.nominal.append(nominal)
                # Trims are single precision there.
                self.forward.append(float(np.float32(forward)))
                self.reverse.append(float(np.float32(reverse)))

    def go(self, target):
        # Along the way too, since the play is taken up there.
        for place in np.linspace(self.command, target, 8)[1:]:
            velocity = np.sign(place - self.command)
            self.velocity = velocity or self.velocity
            self.command = float(place)
            trims = self.forward if self.velocity > 0 else self.reverse
            at = self.axis.move(self.command + float(np.interp(place, self.nominal, trims)))
        return at


class GrblHAL(Plain):
    """A build with ENABLE_BACKLASH_COMPENSATION; axis X."""

    def __init__(self, axis, text):
        super().__init__(axis)
        (value,) = re.findall(r"(?m)^\$160=([\d.]+)$", text)
        self.backlash, self.is_negative, self.shift = float(value), True, 0.0

    def go(self, target):
        if self.backlash > 0.0001 and target > self.command and self.is_negative:
            self.is_negative, self.shift = False, self.shift + self.backlash
        elif self.backlash > 0.0001 and target < self.command and not self.is_negative:
            self.is_negative, self.shift = True, self.shift - self.backlash
        return super().go(target)

    def motor(self, target):
        return target + self.shift


class Marlin(Plain):
    """With BACKLASH_COMPENSATION and BACKLASH_GCODE; axis X, 1600 steps/mm."""

    STEPS = 1600.0

    def __init__(self, axis, text):
        super().__init__(axis)
        (words,) = re.findall(r"(?m)^M425 (.*)$", text)
        values = dict(re.findall(r"([XFS])(-?[\d.]+)", words))
        self.backlash = float(values["X"]) * float(values["F"])
        self.is_forward, self.residual, self.shift = False, 0, 0

    def go(self, target):
        dist = round((target - self.command) * self.STEPS)
        if dist and (dist > 0) != self.is_forward:
            self.is_forward = dist > 0
            self.residual += int((1 if dist > 0 else -1) * self.backlash * self.STEPS)
        low, high = (0, dist) if dist > 0 else (dist, 0)
        added = min(max(self.residual, low), high)
        self.residual, self.shift = self.residual - added, self.shift + added
        return super().go(target)

    def motor(self, target):
        return target + self.shift / self.STEPS


def measure(machine, points, repeats=1, approach=2.0, noise=0.0, seed=0):
    """Readings: repeat, commanded, rising, measured; each point from below and from above."""
    rng = np.random.default_rng(seed)
    rows = []
    for repeat in range(repeats):
        for point in points:
            for rising in (True, False):
                machine.go(point - approach if rising else point + approach)
                rows.append((repeat, point, rising, machine.go(point) + noise * rng.normal()))
    return rows


def write_sheet(path, rows, head="commanded [mm],direction,measured [mm]", digits=4):
    """Write readings as a filled sheet."""
    lines = [head]
    for _, point, rising, value in rows:
        lines.append(f"{point:g},{'rising' if rising else 'falling'},{value:.{digits}f}")
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def errors(rows):
    """Measured less commanded, of rising and of falling readings, means over repeats by point."""
    sides = {True: {}, False: {}}
    for _, point, rising, value in rows:
        sides[rising].setdefault(point, []).append(value - point)
    return tuple(np.array([np.mean(v) for v in sides[side].values()]) for side in (True, False))
