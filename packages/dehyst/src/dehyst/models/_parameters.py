"""Builds models from the parameters in their files; `file_parameters` does the reverse."""

from __future__ import annotations

from typing import Any

import numpy as np

from dehyst.arrays import Array
from dehyst.errors import ParameterError
from dehyst.models._direct import DirectInverse, Schedule
from dehyst.models._model import Model
from dehyst.models._monotone import ModifiedPrandtlIshlinskii, MonotoneMap, StaticCurve
from dehyst.models._prandtl_ishlinskii import PrandtlIshlinskii, StopOperatorModel
from dehyst.models._sheared import ShearedPrandtlIshlinskii
from dehyst.models._start import REST, UNKNOWN
from dehyst.models._storage import Json, json_number

MOST_SCHEDULES = 3
LONGEST_NAME = 200


def _numbers(value: Any, name: str) -> list[float]:
    """Return a list of JSON numbers; True and False are none, although Python counts them as integers."""
    listed = isinstance(value, list)
    if not listed or not all(type(number) in (int, float) for number in value):
        raise ParameterError(f"{name} is not a list of numbers.")
    numbers: list[float] = value
    return numbers


def _read_play(p: Json) -> PrandtlIshlinskii:
    return PrandtlIshlinskii(
        np.array(_numbers(p["thresholds"], "thresholds"), dtype=np.float64),
        np.array(_numbers(p["weights"], "weights"), dtype=np.float64),
        json_number(p["offset"], "offset"),
        _read_state(p["state"]),
        json_number(p["center"], "center"),
    )


def _read_state(value: Any) -> Array | None:
    if value is None:
        return None
    return np.array(_numbers(value, "state"), dtype=np.float64)


def _read_map(p: Json | None) -> MonotoneMap | None:
    if p is None:
        return None
    return MonotoneMap(
        np.array(_numbers(p["u"], "u"), dtype=np.float64),
        np.array(_numbers(p["v"], "v"), dtype=np.float64),
    )


def _rows(value: Any, name: str, sets: int) -> Array:
    """A table of one row for each set of weights, (sets, columns)."""
    rows = []
    if isinstance(value, list):
        rows = [_numbers(row, name) for row in value]
    # NumPy would make an array of objects of rows of different lengths.
    if len(rows) != sets or len({len(row) for row in rows}) != 1:
        raise ParameterError(f"{name} is not a table of {sets} rows of one length.")
    return np.array(rows, dtype=np.float64).reshape(sets, len(rows[0]))


def _read_direct(p: Json) -> DirectInverse:
    listed = p["schedules"]
    # Checked before anything is built: a hostile file may list a million schedules.
    short = isinstance(listed, list) and len(listed) <= MOST_SCHEDULES
    if not short:
        raise ParameterError("schedules are not a short list.")
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
        center=json_number(p["center"], "center"),
        schedules=schedules,
        past=_read_past(p),
    )


def _read_past(p: Json) -> Any:
    """The past of a direct inverse; files that were written before pasts had names say whether it was at rest."""
    if "past" in p or "known" not in p:
        return p["past"]
    if not isinstance(p["known"], bool):
        raise ParameterError("known is neither true nor false.")
    return REST if p["known"] else UNKNOWN


def _read_schedule(entry: Any) -> Schedule:
    name, unit = entry["name"], entry["unit"]
    # Names and units are printed on pages and in exported code.
    texts = isinstance(name, str) and isinstance(unit, str)
    if not texts or not 0 < len(name) <= LONGEST_NAME >= len(unit):
        raise ParameterError("a schedule has no name and unit of ordinary length.")
    return Schedule(
        name, json_number(entry["low"], "low"), json_number(entry["high"], "high"), unit
    )


def model_of(family: Any, p: Json) -> Model:
    """Return the model of a family and its parameters; KeyError or ParameterError if they are not those of one."""
    if family == "pi":
        return _read_play(p)
    if family == "modified-pi":
        return ModifiedPrandtlIshlinskii(
            _read_play(p["hysteresis"]), _read_map(p["after"]), _read_map(p["before"])
        )
    if family == "stop":
        return StopOperatorModel(
            np.array(_numbers(p["thresholds"], "thresholds"), dtype=np.float64),
            np.array(_numbers(p["stop_weights"], "stop_weights"), dtype=np.float64),
            json_number(p["slope"], "slope"),
            json_number(p["offset"], "offset"),
            _read_state(p["state"]),
            json_number(p["center"], "center"),
        )
    if family == "sheared-pi":
        return ShearedPrandtlIshlinskii(
            _read_play(p["hysteresis"]), json_number(p["shear"], "shear")
        )
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
