"""Models of families from the parameters of their files: values, scaling and start."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

import numpy as np

from dehyst.errors import ModelFileError, ParameterError
from dehyst.families.base import LoopModel, Scaling
from dehyst.families.registry import MODULES, ROWS, record_of


def model_of(name: Any, parameters: Any) -> LoopModel:
    """Return the model of a family and its parameters, as `dehyst.models.storage` asks for it.

    Raises
    ------
    ModelFileError
        If there is no such family here.
    ParameterError
        If the parameters are not those of one.
    """
    if name not in MODULES and name not in ROWS:
        raise ModelFileError(f"holds a model of the family '{name!s:.40}', which this dehyst does not have.")
    record: Any = record_of(name)
    known = {entry.name for entry in fields(record)} - {"scaling", "start", "card"}
    if set(parameters["values"]) != known:
        raise ParameterError(f"its parameters are {list(parameters['values'])!s:.120}, not {sorted(known)}.")
    values = {key: _value(value) for key, value in parameters["values"].items()}
    scaling = Scaling(**{key: _number(value) for key, value in parameters["scaling"].items()})
    model: LoopModel = record(**values, scaling=scaling, start=parameters["start"])
    if model.family != name:
        raise ParameterError(f"it is of the family {model.family!r:.40}, and its file says {name!r:.40}.")
    probe = model.before(0.0)  # an impossible start or shape shows here, not on a machine
    if not np.all(np.isfinite(probe)):
        raise ParameterError("its memory is not finite.")
    return model


def _number(value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not np.isfinite(value):
        raise ParameterError(f"{value!r:.40} is no finite number.")
    return float(value)


def _value(value: Any) -> Any:
    """A number, a word, or an array of finite numbers; a table is for its record to check."""
    if isinstance(value, str | bool):
        return value
    if isinstance(value, int):
        return value
    if not isinstance(value, list):
        return _number(value)
    if any(isinstance(part, list) for part in value):
        return value
    array = np.array(value, dtype=np.float64)
    if not np.all(np.isfinite(array)):
        raise ParameterError("a parameter is not finite.")
    return array
