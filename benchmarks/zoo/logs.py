"""Logs of a rig: designed ones of three lengths, and one of its daily work."""

from __future__ import annotations

from functools import cache

import numpy as np

import dehyst
from dehyst.design import ExcitationPlan, design_excitation
from dehyst.errors import ParameterError
from zoo.compiled import Array
from zoo.rigs import Rig

# Longest duration of a designed log, over that of the shortest there is.
LENGTHS = {"short": 1.0, "usual": 1.5, "long": 3.0}
ROUTINE = "routine"
STATIONS = 7
VISITS = 60


def smooth(begin: float, end: float, samples: int) -> Array:
    """Stroke of minimal jerk (T,), without its first point, with its last."""
    s = np.arange(1, samples + 1) / samples
    return begin + (end - begin) * (10.0 * s**3 - 15.0 * s**4 + 6.0 * s**5)


@cache
def plan(rig: Rig, length: str) -> ExcitationPlan:
    """Return the motion that `dehyst design` proposes for the rig's range and rate."""
    try:
        design_excitation(rig.low, rig.high, rate=rig.rate, time_limit=1e-3, period=rig.period)
    except ParameterError as fault:
        shortest = float(fault.facts["needed"])
    return design_excitation(
        rig.low,
        rig.high,
        rate=rig.rate,
        time_limit=shortest * LENGTHS[length],
        period=rig.period,
        unit=rig.unit,
    )


def designed(rig: Rig, length: str) -> Array:
    """Return the input of a designed log (T,): it begins where the rig rests."""
    _, u, _ = plan(rig, length).signal()
    return np.concatenate([*approach(rig, float(u[0])), u])


def approach(rig: Rig, begin: float) -> list[Array]:
    """Return a short rest and a stroke from there to where a motion begins; nothing if the rig rests there."""
    if begin == rig.rest:
        return []
    samples = round(rig.stroke / rig.period)
    return [np.full(max(2, samples // 10), rig.rest), smooth(rig.rest, begin, samples)]


def routine(rig: Rig) -> Array:
    """Return the input of daily work (T,): from station to station in changing order, with rests of two lengths."""
    random = rig.random("routine")
    span = rig.high - rig.low
    stations = rig.low + span * (0.02 + 0.96 * np.linspace(0.0, 1.0, STATIONS))
    stations[1:-1] += 0.04 * span * random.standard_normal(STATIONS - 2)
    at = rig.rest
    parts = [np.full(max(2, round(0.1 * rig.stroke / rig.period)), at)]
    for visit in range(VISITS):
        # Work begins and ends with the whole range, as a machine that references itself.
        if visit in (0, VISITS - 2):
            station = float(stations[-1])
        elif visit in (1, VISITS - 1):
            station = float(stations[0])
        else:
            station = float(random.choice(stations))
        way = abs(station - at) / span
        time = rig.stroke * (0.25 + 0.75 * way) * float(random.choice([1.0, 1.6]))
        parts.append(smooth(at, station, max(8, round(time / rig.period))))
        rest = rig.stroke * float(random.choice([0.1, 0.8]))
        parts.append(np.full(max(1, round(rest / rig.period)), station))
        at = station
    return np.concatenate(parts)


@cache
def true_log(rig: Rig, length: str) -> tuple[Array, Array]:
    """Return input and true output of a log, (T,) each."""
    u = routine(rig) if length == ROUTINE else designed(rig, length)
    return u, rig.play(u)


def recording(rig: Rig, length: str) -> dehyst.Recording:
    """Return a log as its owner has it: with the sensor's noise and steps."""
    u, y = true_log(rig, length)
    return dehyst.Recording(
        input=u,
        output=rig.measured(y, length),
        time=rig.period * np.arange(u.size, dtype=np.float64),
        name=f"{rig.name} {length}",
        input_name="u",
        output_name="y",
        input_unit=rig.unit,
        output_unit=rig.output_unit,
    )
