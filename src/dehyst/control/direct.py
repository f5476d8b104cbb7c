"""A direct inverse in the joint controller: desired angle [rad] -> torque [Nm], scheduled by mean pressure and load."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from dehyst.errors import ParameterError, UnitError
from dehyst.models import DirectInverse, Schedule
from dehyst.units import MASS_FACTORS, TABLE, canonical

DIRECT = "direct"  # form of the models that are one
GIVEN = ("mean_pressure", "load")  # what the controller gives the model, in the order of the core
LARGEST = (
    1e6  # [rad], [Nm]: beyond what any joint has, and powers of it are still numbers that a state can be stored with
)
SI = {"mean_pressure": "pressure", "load": "torque"}


def in_si(model: DirectInverse) -> DirectInverse:
    """Return a joint's model in rad, Nm and Pa: the same function of the converted signals.

    A unit that is not named is taken to be the right one.

    Raises
    ------
    UnitError
        If its y is no angle, its u no torque, or a schedule in no unit of its size.
    ParameterError
        If it is scheduled by something that the controller does not know.

    Examples
    --------
    >>> from dehyst.models import ModelCard, SignalCard
    >>> card = ModelCard(SignalCard("torque", "Nm"), SignalCard("angle", "deg"))
    >>> model = DirectInverse(radii=[90.0], stop_weights=[1.0], card=card)
    >>> in_si(model).radii.round(6).tolist()
    [1.570796]
    """
    angle = _factor(model.card.output.unit, "angle", f"its output {model.card.output.label}")
    torque = _factor(model.card.input.unit, "torque", f"its input {model.card.input.label}")
    schedules = tuple(_schedule(schedule, angle) for schedule in model.schedules)
    gain = torque / angle
    powers = torque / angle ** np.arange(model.polynomial.shape[1])
    card = model.card
    output = replace(card.output, unit="rad", low=_times(card.output.low, angle), high=_times(card.output.high, angle))
    needed = replace(card.input, unit="Nm", low=_times(card.input.low, torque), high=_times(card.input.high, torque))
    if angle == 1.0 and torque == 1.0 and schedules == model.schedules:
        return model
    return replace(
        model,
        radii=model.radii * angle,
        path_lengths=model.path_lengths * angle,
        stop_weights=model.stop_weights * gain,
        path_weights=model.path_weights * gain,
        creep_weights=model.creep_weights * gain,
        viscous=model.viscous * gain,
        polynomial=model.polynomial * powers,
        center=model.center * angle,
        schedules=schedules,
        card=replace(card, input=needed, output=output),
    )


def direct_parameters(model: DirectInverse, period: float) -> tuple[Any, ...]:
    """Return what the core's joint takes: the model in SI, its schedules in the order of `GIVEN`."""
    return in_si(model).parameters(period, GIVEN, LARGEST)


def _times(value: float | None, factor: float) -> float | None:
    return None if value is None else value * factor


def _schedule(schedule: Schedule, angle: float) -> Schedule:
    if not schedule.outside:
        return replace(schedule, low=schedule.low * angle, high=schedule.high * angle, unit="rad")
    if schedule.name not in GIVEN:
        raise ParameterError(
            f"the model is scheduled by '{schedule.name}', which no joint controller knows; it gives "
            f"{' and '.join(GIVEN)}. Identify with --mean-pressure or --load.",
            schedule=schedule.name,
        )
    dimension = SI[schedule.name]
    factor = _factor(schedule.unit, dimension, f"its schedule '{schedule.name}'")
    return replace(schedule, low=schedule.low * factor, high=schedule.high * factor, unit=_unit(dimension))


def _unit(dimension: str) -> str:
    return next(iter(TABLE[dimension]))


def _factor(unit: str, dimension: str, what: str) -> float:
    known = (canonical(unit) or (unit if unit in MASS_FACTORS else "")) if unit else ""
    if not known:
        return 1.0
    if known not in TABLE[dimension]:
        raise UnitError(
            f"the direct inverse of a joint maps an angle to a torque, but {what} is in {unit}, which is no "
            f"{dimension}. Identify it from the torque A(q) p_m + B(q) dp + C(q) - load, as `dehyst reproduce` does.",
            unit=unit,
        )
    return TABLE[dimension][known]
