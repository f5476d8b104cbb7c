"""Builds models from the parameters in their files; `file_parameters` does the reverse."""

from __future__ import annotations

from typing import Any

import numpy as np

from dehyst.arrays import Array
from dehyst.errors import ParameterError
from dehyst.models.direct import DirectInverse, Schedule
from dehyst.models.model import Model
from dehyst.models.monotone import ModifiedPrandtlIshlinskii, MonotoneMap, StaticCurve
from dehyst.models.prandtl_ishlinskii import PrandtlIshlinskii, StopOperatorModel
from dehyst.models.sheared import ShearedPrandtlIshlinskii
from dehyst.models.storage import Json, number

MOST_SCHEDULES = 3
LONGEST_NAME = 200


def _numbers(value: Any, name: str) -> list[float]:
    if not isinstance(value, list) or not all(isinstance(v, (int, float)) and not isinstance(v, bool) for v in value):
        raise ParameterError(f"{name} is not a list of numbers.")
    return value


def _read_play(p: Json) -> PrandtlIshlinskii:
    return PrandtlIshlinskii(
        np.array(_numbers(p["thresholds"], "thresholds"), dtype=np.float64),
        np.array(_numbers(p["weights"], "weights"), dtype=np.float64),
        number(p["offset"], "offset"),
        None if p["state"] is None else np.array(_numbers(p["state"], "state"), dtype=np.float64),
        number(p["center"], "center"),
    )


def _read_map(p: Json | None) -> MonotoneMap | None:
    if p is None:
        return None
    return MonotoneMap(
        np.array(_numbers(p["u"], "u"), dtype=np.float64), np.array(_numbers(p["v"], "v"), dtype=np.float64)
    )


def _rows(value: Any, name: str, sets: int) -> Array:
    """A table of one row for each set of weights, (sets, columns)."""
    rows = [_numbers(row, name) for row in value] if isinstance(value, list) else []
    if len(rows) != sets or len({len(row) for row in rows}) != 1:
        raise ParameterError(f"{name} is not a table of {sets} rows of one length.")
    return np.array(rows, dtype=np.float64).reshape(sets, len(rows[0]))


def _read_direct(p: Json) -> DirectInverse:
    listed = p["schedules"]
    if not isinstance(listed, list) or len(listed) > MOST_SCHEDULES or not isinstance(p["known"], bool):
        raise ParameterError("schedules are not a short list, or known is neither true nor false.")
    schedules = tuple(_read_schedule(entry) for entry in listed)
    sets = max(1, 2 * len(schedules))
    return DirectInverse(
        radii=np.array(_numbers(p["radii"], "radii"), dtype=np.float64),
        stop_weights=_rows(p["stop_weights"], "stop_weights", sets),
        path_lengths=np.array(_numbers(p["path_lengths"], "path_lengths"), dtype=np.float64),
        path_weights=_rows(p["path_weights"], "path_weights", sets),
        time_constants=np.array(_numbers(p["time_constants"], "time_constants"), dtype=np.float64),
        creep_weights=_rows(p["creep_weights"], "creep_weights", sets),
        polynomial=_rows(p["polynomial"], "polynomial", sets),
        viscous=np.array(_numbers(p["viscous"], "viscous"), dtype=np.float64),
        center=number(p["center"], "center"),
        schedules=schedules,
        known=p["known"],
    )


def _read_schedule(entry: Any) -> Schedule:
    name, unit = entry["name"], entry["unit"]
    if not isinstance(name, str) or not isinstance(unit, str) or not 0 < len(name) <= LONGEST_NAME >= len(unit):
        raise ParameterError("a schedule has no name and unit of ordinary length.")
    return Schedule(name, number(entry["low"], "low"), number(entry["high"], "high"), unit)


def model_of(family: Any, p: Json) -> Model:
    """Return the model of a family and its parameters; KeyError or ParameterError if they are not those of one."""
    if family == "pi":
        return _read_play(p)
    if family == "modified-pi":
        return ModifiedPrandtlIshlinskii(_read_play(p["hysteresis"]), _read_map(p["after"]), _read_map(p["before"]))
    if family == "stop":
        return StopOperatorModel(
            np.array(_numbers(p["thresholds"], "thresholds"), dtype=np.float64),
            np.array(_numbers(p["stop_weights"], "stop_weights"), dtype=np.float64),
            number(p["slope"], "slope"),
            number(p["offset"], "offset"),
            None if p["state"] is None else np.array(_numbers(p["state"], "state"), dtype=np.float64),
            number(p["center"], "center"),
        )
    if family == "sheared-pi":
        return ShearedPrandtlIshlinskii(_read_play(p["hysteresis"]), number(p["shear"], "shear"))
    if family == "static":
        curve = _read_map(p["curve"])
        if curve is None:
            raise ParameterError("curve is missing.")
        return StaticCurve(curve)
    if family == "direct-inverse":
        return _read_direct(p)
    raise ParameterError(
        f"family {family!r:.60} is not one of pi, modified-pi, stop, sheared-pi, static, direct-inverse."
    )
