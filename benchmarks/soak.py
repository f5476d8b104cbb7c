"""A soak: steppers, blocks and joint controllers that are interrupted again and again, beside twins that are not.

    python benchmarks/soak.py --minutes 60        as in docs/explanation/how-it-is-tested.md
    python benchmarks/soak.py --minutes 0.1

In each episode a machine of a random model runs on random samples, some of which are no numbers. One copy runs through;
the other is saved and continued by a new object, taken back to an older image and led through the same samples again,
and offered damaged images, which it has to refuse. Resets, switching and exchanged compensators happen to both. Every
output and flag, and the state at the end, must have the same bits.
"""

from __future__ import annotations

import argparse
import json
import math
import resource
import sys
import time
from collections import Counter
from dataclasses import astuple
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

from block_samples import sample, wishes
from dehyst.errors import ParameterError
from dehyst.models import Block
from dehyst_robot.control import (
    SWITCHES,
    JointController,
    JointControllerParameters,
    JointReference,
)
from direct_export_samples import QUICK, random_direct
from joint_oracles import PERIOD, Rig, reference_along

NO_NUMBERS = (math.nan, math.inf, -math.inf, 1e300, None)


class Stepper:
    """A model's or an inverse's stepper, dense or logarithmic; the switch of a sample is not for it."""

    def __init__(self, rng):
        self.model, _, _ = sample(int(rng.integers(2**31)))
        self.model = self.model.inverse() if rng.random() < 0.5 else self.model
        self.method = ("dense", "logarithmic")[int(rng.integers(2))]
        self.signal = rng.normal(size=2000).cumsum() / 20

    def fresh(self):
        return self.model.stepper(self.method)

    def apply(self, machine, act, x, _):
        if act == "reset":
            machine.reset()
        return machine(x), machine.rejected, machine.rejected_ever

    def inputs(self, k, _):
        return float(self.signal[k])


class DirectStepper(Stepper):
    """A direct inverse."""

    def __init__(self, rng):
        self.model = random_direct(rng)
        self.signal = np.clip(rng.normal(size=2000).cumsum() / 50, -0.6, 0.6)

    def fresh(self):
        return self.model.core_stepper(1e-3)

    def apply(self, machine, act, x, _):
        if act == "reset":
            machine.reset(0.1)
        y = math.nan if x is None else x
        return machine(y, 0.2 * y, 3e5, 4.0), machine.rejected, machine.limited, machine.doubt


class OfBlock(Stepper):
    """A function block that is switched on and off."""

    def __init__(self, rng):
        self.model, self.bounds, _ = sample(int(rng.integers(2**31)))
        self.direction = ("inverse", "forward")[int(rng.integers(2))]
        self.ramp = int(rng.integers(1, 60))
        self.signal = wishes(self.fresh(), rng, 2000)

    def fresh(self):
        return Block(self.model, self.direction, self.bounds, self.ramp)

    def apply(self, machine, act, x, on):
        if act == "reset":
            machine.reset()
        return machine.step(x, on % 2 == 0), machine.flags, machine.share


class OfJoint(Stepper):
    """A joint controller on a simulated joint, with a compensator that is exchanged, or one that learns."""

    def __init__(self, rng):
        self.parameters = JointControllerParameters(
            frozen_samples=100, hold_samples=int(rng.integers(1, 60))
        )
        self.direct = random_direct(rng) if rng.random() < 0.4 else None
        self.models = [sample(int(rng.integers(2**31)))[0].inverse() for _ in range(3)]
        self.chosen = 0
        self.reference = reference_along(
            PERIOD * np.arange(2000), float(rng.uniform(0.1, 0.4)), float(rng.uniform(0.2, 2))
        )
        self.rig = Rig(self.parameters, seed=int(rng.integers(2**31)))

    def fresh(self):
        if self.direct is not None:
            return JointController(self.parameters, self.direct, QUICK)
        machine = JointController(self.parameters)
        machine.exchange(self.models[self.chosen], unit=100.0)
        return machine

    def apply(self, machine, act, x, on):
        k, reading = x
        if act == "reset":
            machine.reset(*(0.0 if r is None else r for r in reading))
        if act == "exchange" and self.direct is None:
            machine.exchange(self.models[self.chosen], unit=100.0)
        return astuple(machine.step(*reading, JointReference(*self.reference[k]), on))

    def inputs(self, k, bad):
        reading = list(self.rig.read())
        if bad is not None:
            reading[k % 3] = bad[0]
        return k, reading

    def moved(self, out):
        self.rig.step(out[:2])


KINDS = (Stepper, DirectStepper, OfBlock, OfJoint)


def bits(values):
    return np.asarray(values, dtype=np.float64).tobytes()


def image_bits(machine):
    image = machine.save()
    return image if isinstance(image, bytes) else np.asarray(image).tobytes()


def damaged(image, rng):
    """Return an image with one bit changed, in the kind that it has."""
    values = bytearray(image if isinstance(image, bytes) else np.asarray(image).tobytes())
    values[int(rng.integers(len(values)))] ^= 1 << int(rng.integers(8))
    return (
        bytes(values)
        if isinstance(image, bytes)
        else np.frombuffer(bytes(values), dtype=image.dtype)
    )


def episode(kind, rng, count, samples=2000):
    """Run one machine beside its interrupted twin; return the first sample that differs, or None."""
    case = kind(rng)
    through, cut = case.fresh(), case.fresh()
    joint = kind is OfJoint
    if joint:
        for machine in (through, cut):
            machine.reset(0.0, 3e5, 3e5)
    mark, since, on = cut.save(), [], sum(SWITCHES.values()) if joint else 0
    for k in range(samples):
        draw = rng.random()
        act = "reset" if draw < 0.002 else "exchange" if joint and draw < 0.004 else ""
        if act == "exchange":
            case.chosen = int(rng.integers(3))
        if rng.random() < 0.01:
            on = int(rng.integers(sum(SWITCHES.values()) + 1))
            count["switchings"] += 1
        bad = (NO_NUMBERS[int(rng.integers(len(NO_NUMBERS)))],) if rng.random() < 0.01 else None
        x = case.inputs(k, bad) if joint or bad is None else bad[0]
        count["faults"] += bad is not None
        count[act or "plain samples"] += 1
        expected = case.apply(through, act, x, on)
        got = case.apply(cut, act, x, on)
        if joint:
            case.moved(expected)
        if bits(got) != bits(expected):
            return k
        since.append((act, x, on))
        if act == "exchange":  # images before it belong to another compensator
            mark, since = cut.save(), []
        event = rng.random()
        if event < 0.01:  # a new object goes on
            image, cut = cut.save(), case.fresh()
            cut.restore(image)
            count["continued by a new object"] += 1
        elif event < 0.015:  # back, and the same samples again
            cut.restore(mark)
            for step in since:
                got = case.apply(cut, *step)
            if bits(got if since else expected) != bits(expected):
                return k
            count["taken back and led again"] += 1
            mark, since = cut.save(), []
        elif event < 0.02 and kind in (OfBlock, OfJoint):  # their images carry a checksum
            try:
                cut.restore(damaged(cut.save(), rng))
            except ParameterError:
                count["damaged images refused"] += 1
            else:
                return k
    return None if image_bits(through) == image_bits(cut) else samples


def soak(minutes, seed):
    """Return what happened in that time."""
    count, differing, start, number = Counter(), [], time.perf_counter(), 0
    memory = 0
    while time.perf_counter() - start < 60 * minutes:
        wrong = episode(KINDS[number % len(KINDS)], np.random.default_rng([seed, number]), count)
        if wrong is not None:
            differing.append({"episode": number, "sample": wrong})
        number += 1
        if number == 40:
            memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - memory if memory else 0
    return {
        "minutes": round((time.perf_counter() - start) / 60, 2), "seed": seed, "episodes": number, **count,
        "memory grown after episode 40 [KiB]": grown, "differing": differing,
    }  # fmt: skip


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--minutes", type=float, default=60)
    parser.add_argument("--seed", type=int, default=15)
    asked = parser.parse_args()
    found = soak(asked.minutes, asked.seed)
    print(json.dumps(found, indent=1))
    return 1 if found["differing"] else 0


if __name__ == "__main__":
    sys.exit(main())
