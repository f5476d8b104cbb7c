"""Builds models of families from the parameters in their files."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

import numpy as np

from dehyst.errors import ModelFileError, ParameterError
from dehyst.families._base import LoopModel, Scaling
from dehyst.families._registry import is_family, record_of


def family_model(name: Any, parameters: Any) -> LoopModel:
    """Return the model of a family and its parameters, as `dehyst.models._storage` asks for it.

    Raises
    ------
    ModelFileError
        If there is no such family here.
    ParameterError
        If the parameters are not those of one.
    """
    if not is_family(name):
        raise ModelFileError(
            f"holds a model of the family '{name!s:.40}', which this dehyst does not have."
        )
    values, scales = {}, {}
    for key, value in parameters["values"].items():
        values[key] = _value(value)
    for key, value in parameters["scaling"].items():
        scales[key] = _number(value)
    scaling = Scaling(**scales)
    start = parameters["start"]
    if isinstance(start, list) and record_of(name).memory_grows:
        # Any list could be the turns of such a memory, and none of them can be checked.
        raise ParameterError(
            "its memory is a list of no fixed length, which a file cannot vouch for."
        )
    if isinstance(start, list):
        # The memory of a model that runs on.
        start = tuple(_number(value) for value in start)
    model = _record_of(name, values, scaling, start)
    if model.family != name:
        raise ParameterError(
            f"it is of the family {model.family!r:.40}, and its file says {name!r:.40}."
        )
    # An impossible start or shape must show here, not on a machine.
    if not np.all(np.isfinite(model.before(0.0))):
        raise ParameterError("its memory is not finite.")
    return model


def _record_of(
    name: str, values: dict[str, Any], scaling: Scaling, start: str | tuple[float, ...]
) -> LoopModel:
    record: Any = record_of(name)
    expected = {entry.name for entry in fields(record)} - {"scaling", "start", "card"}
    if set(values) != expected:
        raise ParameterError(f"its parameters are {list(values)!s:.120}, not {sorted(expected)}.")
    model: LoopModel = record(**values, scaling=scaling, start=start)
    return model


def _number(value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not np.isfinite(value):
        raise ParameterError(f"{value!r:.40} is no finite number.")
    return float(value)


def _value(value: Any) -> Any:
    """Return a number, a word, or an array of finite numbers; the record itself checks a table."""
    # Whole numbers, among them True and False, stay what they are: as floats they would be written differently.
    if isinstance(value, str | int):
        return value
    if not isinstance(value, list):
        return _number(value)
    if any(isinstance(part, list) for part in value):
        return value
    array = np.array(value, dtype=np.float64)
    if not np.all(np.isfinite(array)):
        raise ParameterError("a parameter is not finite.")
    return array
