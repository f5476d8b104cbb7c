"""Files of family models: the JSON of model files, with scaling and start beside the parameters."""

from __future__ import annotations

import json
import os
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

import numpy as np

from dehyst.errors import DehystError, ModelFileError, ParameterError
from dehyst.families.base import LoopModel, Scaling
from dehyst.families.registry import MODULES, ROWS, record_of
from dehyst.files import write_atomically
from dehyst.models import DirectInverse, HysteresisModel, model_from_dict
from dehyst.models.storage import check_signed, content_of, read_card, signed, text_of

KIND = "dehyst-family"


def save_loop(model: LoopModel, path: str | os.PathLike[str]) -> Path:
    """Write a file of a family's model atomically, once it is sure that it can be read back.

    Raises
    ------
    ParameterError
        If its family is not registered, so that nobody could read the file.
    OutputError
        If the file cannot be written.
    """
    content = signed(
        KIND,
        model.family,
        {"values": model.parameters(), "scaling": asdict(model.scaling), "start": model.start},
        model.card,
    )
    text = json.dumps(content, indent=1, allow_nan=False) + "\n"
    try:
        _loop_of(content_of(text, str(path)), str(path))
    except ModelFileError as fault:
        raise ParameterError(f"this model was not saved, because its file could not be read back: {fault}") from None
    return write_atomically(path, text)


def load_file(path: str | os.PathLike[str]) -> LoopModel | HysteresisModel | DirectInverse:
    """Read a model file of any kind: of a family of the literature, a hysteresis model, or a direct inverse.

    Parameters
    ----------
    path
        A file written by ``model.save(path)``, ``dehyst compare --save`` or ``dehyst identify --save``.

    Raises
    ------
    ModelFileError
        If the file is missing, damaged, hostile, of another schema version, or not a model.

    Examples
    --------
    >>> import tempfile, pathlib
    >>> from dehyst.families import example
    >>> path = example("dahl").save(pathlib.Path(tempfile.mkdtemp()) / "dahl.json")
    >>> load_file(path).family
    'dahl'
    """
    content = content_of(text_of(path), str(path))
    if isinstance(content, dict) and content.get("format") == KIND:
        return _loop_of(content, str(path))
    return model_from_dict(content, str(path))


def _loop_of(content: Any, path: str) -> LoopModel:
    intact = check_signed(content, KIND, path)
    try:
        name, parameters = intact["family"], intact["parameters"]
        if name not in MODULES and name not in ROWS:
            raise ModelFileError(
                f"model file '{path}' holds a model of the family '{name!s:.40}', which this dehyst does not have. "
                f"Install the version or the module that wrote it.",
                path=path,
            )
        record: Any = record_of(name)
        known = {entry.name for entry in fields(record)} - {"scaling", "start", "card"}
        if set(parameters["values"]) != known:
            raise ParameterError(f"its parameters are {list(parameters['values'])!s:.120}, not {sorted(known)}.")
        values = {key: _value(value) for key, value in parameters["values"].items()}
        scaling = Scaling(**{key: _number(value) for key, value in parameters["scaling"].items()})
        model = record(**values, scaling=scaling, start=parameters["start"], card=read_card(intact))
        if model.family != name:
            raise ParameterError(f"it is of the family {model.family!r:.40}, and its file says {name!r:.40}.")
        probe = model.before(0.0)  # an impossible start or shape shows here, not on a machine
        if not np.all(np.isfinite(probe)):
            raise ParameterError("its memory is not finite.")
    except (KeyError, TypeError, AttributeError, IndexError) as fault:
        raise _refuse(path, f"lacks a part or holds one of the wrong kind ({fault!s:.200}).") from None
    except ModelFileError:
        raise
    except (DehystError, ValueError, OverflowError) as fault:
        raise _refuse(path, f"holds parameters of no model: {fault!s:.600}") from None
    assert isinstance(model, LoopModel)
    return model


def _refuse(path: str, what: str) -> ModelFileError:
    return ModelFileError(
        f"model file '{path}' {what} Save the model again with `dehyst compare ... --save`.", path=path
    )


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
