"""Figures of a compensator on a joint that is not as it was: other hysteresis, contact, rest, hours of faults."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from dehyst_robot.control import Adaptation
from dehyst_robot.experiments._results import TRIALS
from studies.alone import ADAPT, DISTURBANCE, Alone, follow, rms, smooth_push
from studies.endurance import endure
from studies.hold import hold

SCALES = (0.5, 1.0, 1.5)  # of the plant's hysteresis over the identified one
PUSHES = ((20.0, 5.0), (150.0, -5.0))  # when [s] and how much [Nm]
EDGES = 1.0  # [s]


@dataclass(frozen=True)
class Figure:
    """A measured figure and what it must be.

    Attributes
    ----------
    name
        What was measured.
    value
        Of it.
    most
        It must not be larger; None: for comparison only.
    """

    name: str
    value: float
    most: float | None = None

    @property
    def good(self) -> bool:
        """Whether it is as it must be."""
        return self.most is None or bool(self.value <= self.most)


def without(joint: Alone) -> Alone:
    """Return the same joint without compensator."""
    return replace(joint, model=None)


def other_hysteresis(joint: Alone) -> Iterator[Figure]:
    """On over off while it learns, the plant's hysteresis at 50, 100 and 150 % of the identified one."""
    for scale in SCALES:
        plant = _scaled(joint, scale)
        for trial in TRIALS:
            off, on = follow(without(plant), trial).figures(), follow(plant, trial, ADAPT).figures()
            for what, a, b in zip(("rms", "max"), on, off, strict=True):
                yield Figure(f"hysteresis x{scale:g}, {trial}, {what} on/off", a / b, 1.05)


def cold_start(joint: Alone, told: Alone | None = None, name: str = "") -> Iterator[Figure]:
    """Half the hysteresis, nothing learned before: first and second pass, and after a homing that learns."""
    plant = _scaled(joint if told is None else replace(joint, model=told.model), 0.5)
    for trial, most in (("slow", 0.25), ("slow_no_integrator", 0.12)):
        off, on = follow(without(plant), trial, passes=2), follow(plant, trial, ADAPT, passes=2)
        for k, limit in ((0, None), (1, most)):
            ratio = on.figures(k)[0] / off.figures(k)[0]
            yield Figure(
                f"cold start{name}, hysteresis x0.5, {trial}, pass {k + 1}, rms on/off",
                ratio,
                limit,
            )
        homed = follow(plant, trial, ADAPT, learn_homing=True).figures()[0] / off.figures(0)[0]
        yield Figure(
            f"cold start{name}, hysteresis x0.5, {trial}, learned from homing, pass 1", homed, most
        )


def no_hysteresis(joint: Alone) -> Iterator[Figure]:
    """A plant without any, identified there, the contact torque fed back; the limit is that with noise."""
    for trial in TRIALS:
        off = follow(without(joint), trial).figures()
        for how, switches, most in (
            ("", ADAPT, None),
            (", contact fed back", ADAPT | DISTURBANCE, 1.02),
        ):
            on = follow(joint, trial, switches, learn_homing=True).figures()
            for what, a, b in zip(("rms", "max"), on, off, strict=True):
                yield Figure(f"no hysteresis{how}, {trial}, {what} on/off", a / b, most)


def contact(joint: Alone) -> Iterator[Figure]:
    """5 Nm push the joint for 15 s in the slow trial, after a homing from which it learned."""
    for at, size in PUSHES:
        push = smooth_push(at, size=size, edge=EDGES)
        run = follow(joint, "slow", ADAPT, push=push, learn_homing=True)
        cold = follow(joint, "slow", ADAPT, push=push)
        blind = follow(without(joint), "slow", push=push)
        error, before = run.contact_error, blind.log.load[:, 0] + blind.pushed
        free = np.abs(run.pushed) < 1e-3
        name = f"contact of {size:+g} Nm at {at:g} s"
        yield Figure(f"{name}, rms error [Nm]", rms(error), 0.1)
        yield Figure(f"{name}, false contact [Nm]", float(np.abs(error[free]).max()), 1.0)
        yield Figure(f"{name}, nothing learned before, rms error [Nm]", rms(cold.contact_error))
        yield Figure(f"{name}, without compensator, rms error [Nm]", rms(before))
        for how, switches in (("", ADAPT), (", fed back", ADAPT | DISTURBANCE)):
            _, largest = follow(joint, "slow", switches, push=push).figures()
            yield Figure(f"{name}{how}, largest error [deg]", largest)


def holding(joint: Alone) -> Iterator[Figure]:
    """Three minutes after a stroke without integrator: largest error; drift of the integrator where there is one."""
    for name, one, switches, most in (
        ("off", without(joint), 0, None),
        ("compensator", joint, 0, None),
        ("compensator and feedback of contact", joint, DISTURBANCE, 0.1),
        ("compensator, learning, feedback of contact", joint, DISTURBANCE | ADAPT, 0.1),
    ):
        yield Figure(
            f"hold 3 min without integrator, {name}, max [deg]",
            float(np.abs(hold(one, switches).error).max()),
            most,
        )
    for name, one in (("off", without(joint)), ("compensator", joint)):
        rest = hold(one, integrator=True)
        yield Figure(
            f"hold 3 min with integrator, {name}, its torque [Nm]", float(rest.integrator[0])
        )
        yield Figure(f"hold 3 min with integrator, {name}, its drift [mNm/s]", 1e3 * rest.drift)


def endurance(joint: Alone, seconds: float = 10_000.0) -> Iterator[Figure]:
    """Hours of faults: bounds at every period."""
    adaptation = joint.adaptation or Adaptation()
    seen = endure(joint, seconds)
    yield Figure(
        f"{seconds:g} s with {seen.faults} faults: -lowest scale", -seen.lowest, -adaptation.lowest
    )
    yield Figure(
        f"{seconds:g} s with {seen.faults} faults: highest scale", seen.highest, adaptation.highest
    )
    yield Figure(
        f"{seconds:g} s, {seen.failed} safe failures: |offset| [Nm]",
        seen.offset,
        adaptation.offset_limit,
    )
    yield Figure(f"{seconds:g} s: -slope of the compensated map [bar/rad]", -1e-5 * seen.slope, 0.0)
    yield Figure(f"{seconds:g} s: values that are not finite", float(not seen.finite), 0.0)


def _scaled(joint: Alone, scale: float) -> Alone:
    return joint.with_changes(hysteresis__scale=scale * joint.robot.hysteresis.scale)
