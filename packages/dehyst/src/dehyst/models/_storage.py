"""Model files: plain JSON with schema version and checksum, never executable code."""

from __future__ import annotations

import hashlib
import json
import math
import os
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from dehyst import files
from dehyst.errors import DehystError, ModelFileError, ParameterError
from dehyst.models._card import ModelCard, SignalCard

if TYPE_CHECKING:
    from dehyst.models._model import Model

Json = dict[str, Any]

SCHEMA = 1
OWN = "dehyst-model"
# Module and function that make a model of a kind of file, of family and parameters; those of families know more.
READERS = {
    OWN: ("dehyst.models._parameters", "model_of"),
    "dehyst-family": ("dehyst.families._files", "family_model"),
    "dehyst-coupled": ("dehyst.families._coupled", "coupled_model"),
}
# A model with 10 000 operators and its state takes 1 MB; nothing honest is larger than this, and the worst
# hostile file of this size is refused within a second.
MAXIMUM_BYTES = 1024 * 1024
MAXIMUM_DEPTH = 32


def json_number(value: Any, name: str) -> float:
    """Return a JSON number as float, or refuse it by name."""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise ParameterError(f"{name} is not a number.")
    return float(value)


def _signal(card: SignalCard) -> Json:
    return {"name": card.name, "unit": card.unit, "low": card.low, "high": card.high}


def _checksum(content: Json) -> str:
    canonical = json.dumps(
        content, sort_keys=True, separators=(",", ":"), ensure_ascii=True, allow_nan=False
    )
    # Half a surrogate pair passes the line above, and could never be printed.
    json.dumps(content, ensure_ascii=False).encode("utf-8")
    return hashlib.sha256(canonical.encode("ascii")).hexdigest()


def model_to_dict(model: Model) -> Json:
    """Return the content of a model file, checksum included.

    Floats are written with 17 significant digits, so that reading gives the same bits.

    Examples
    --------
    >>> from dehyst.models import PrandtlIshlinskii
    >>> content = model_to_dict(PrandtlIshlinskii([0.0], [2.0]))
    >>> content["family"], content["schema"]
    ('pi', 1)
    """
    return signed(model.file_kind, model.family, model.file_parameters(), model.card)


def signed(kind: str, family: str, parameters: Json, card: ModelCard) -> Json:
    """Return the content of a file of a kind, with its checksum."""
    content: Json = {
        "format": kind,
        "schema": SCHEMA,
        "family": family,
        "parameters": parameters,
        "input": _signal(card.input),
        "output": _signal(card.output),
        "provenance": dict(card.provenance),
    }
    try:
        # Tuples and keys that are numbers become what a reader of the file will see.
        content = json.loads(json.dumps(content, allow_nan=False))
        content["sha256"] = _checksum(content)
    except (TypeError, ValueError, RecursionError) as fault:
        raise ParameterError(f"provenance must hold plain JSON values only ({fault}).") from None
    return content


def save_model(model: Model, path: str | os.PathLike[str]) -> Path:
    """Write a model file atomically, once it is sure that it can be read back."""
    # Read back before it is written: a file that nobody can load must not replace one that works.
    text = json.dumps(model_to_dict(model), indent=1, allow_nan=False) + "\n"
    try:
        model_from_text(text, str(path))
    except ModelFileError as fault:
        raise ParameterError(
            f"this model was not saved, because its file could not be read back: {fault}"
        ) from None
    return files.write_atomically(path, text)


NO_MODEL = "If it is a log, name it behind the model; else save the model again: `dehyst identify LOG --save FILE`."


def _refuse(path: str, fault: str, cure: str = "") -> ModelFileError:
    cure = cure or "Save the model again with model.save(...) or `dehyst identify ... --save`."
    return ModelFileError(f"model file '{path}' {fault} {cure}", path=path)


def _too_deep(value: Any) -> bool:
    # All lists and objects of one depth at a time: without recursion, a hostile file cannot exhaust the stack.
    level = [value]
    for _ in range(MAXIMUM_DEPTH):
        children: list[Any] = []
        for item in level:
            children += item.values() if isinstance(item, dict) else item
        level = [child for child in children if isinstance(child, (dict, list))]
        if not level:
            return False
    return True


def _read_signal(p: Any, name: str) -> SignalCard:
    named = isinstance(p, dict) and isinstance(p.get("name"), str)
    if not named or not isinstance(p.get("unit"), str):
        raise ParameterError(f"'{name}' does not name a signal and its unit.")
    low, high = p.get("low"), p.get("high")
    if (low is None) != (high is None) or (
        low is not None and not json_number(low, "low") <= json_number(high, "high")
    ):
        raise ParameterError(f"'{name}' has no valid range ({low!r:.40} to {high!r:.40}).")
    bounds = (None, None) if low is None else (json_number(low, "low"), json_number(high, "high"))
    if bounds[0] is not None and not (math.isfinite(bounds[0]) and math.isfinite(bounds[1] or 0.0)):
        raise ParameterError(f"'{name}' has an infinite range.")
    return SignalCard(p["name"], p["unit"], *bounds)


def check_signed(content: Any, path: str) -> Json:
    """Return the content of a model file, as it was when it was signed."""
    if (
        not isinstance(content, dict)
        or not isinstance(content.get("format"), str)
        or content["format"] not in READERS
    ):
        raise _refuse(path, f'is not a dehyst model: it lacks "format": "{OWN}".')
    if type(content.get("schema")) is not int or content["schema"] != SCHEMA:
        raise _refuse(
            path,
            f"has schema version {content.get('schema')!s:.60}; this dehyst reads version {SCHEMA}.",
            "Install the dehyst that wrote it, or identify again.",
        )
    if _too_deep(content):
        raise _refuse(path, f"is nested deeper than {MAXIMUM_DEPTH} levels.")
    # The checksum was made before it became a part of the content.
    body = {key: value for key, value in content.items() if key != "sha256"}
    try:
        intact = _checksum(body) == content.get("sha256")
    except (ValueError, RecursionError):
        intact = False
    if not intact:
        raise _refuse(
            path,
            "does not match its checksum: it was edited or damaged after it was saved, so its numbers cannot be "
            "trusted on a machine.",
            "Restore it from a backup, or write edited parameters with model.save(...), which signs them anew.",
        )
    return content


def read_card(content: Json) -> ModelCard:
    """Return signals and provenance of a checked file; raises what a wrong value raises."""
    provenance = content["provenance"]
    if not isinstance(provenance, dict):
        raise ParameterError("provenance is not an object.")
    return ModelCard(
        _read_signal(content["input"], "input"),
        _read_signal(content["output"], "output"),
        provenance,
    )


def model_from_dict(content: Any, path: str = "model") -> Model:
    """Return the model of a file's content, or refuse it by name."""
    # The module that reads the parameters is imported here: a model of plays needs no module of families.
    intact = check_signed(content, path)
    module, function = READERS[intact["format"]]
    make: Callable[[Any, Any], Model] = getattr(import_module(module), function)
    try:
        return make(intact["family"], intact["parameters"]).with_card(read_card(intact))
    except ModelFileError as fault:
        raise _refuse(
            path, str(fault), "Install the version or the module that wrote it."
        ) from None
    except (KeyError, TypeError, AttributeError, IndexError) as fault:
        raise _refuse(
            path, f"lacks a part or holds one of the wrong kind ({fault!s:.200})."
        ) from None
    except (DehystError, ValueError, OverflowError) as fault:
        raise _refuse(path, f"holds parameters of no model: {fault!s:.600}") from None


def model_from_text(text: str, path: str = "model") -> Model:
    """Return the model that the text of a file describes, or refuse it by name.

    Raises
    ------
    ModelFileError
        If the text is not JSON, names a key twice, or is refused by `model_from_dict`.
    """
    return model_from_dict(
        files.document_of(text, lambda fault: _refuse(path, f"{fault}.", NO_MODEL)), path
    )


def load(path: str | os.PathLike[str]) -> Model:
    """Read a model file, whatever its family.

    Parameters
    ----------
    path
        A file written by ``model.save(path)``, ``dehyst identify --save`` or ``dehyst compare --save``.

    Returns
    -------
    model
        The model, equal to the saved one bit for bit.

    Raises
    ------
    ModelFileError
        If the file is missing, damaged, hostile, of another schema version, or not a model.

    Examples
    --------
    >>> import tempfile, pathlib
    >>> from dehyst.models import PrandtlIshlinskii
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "m.json"
    >>> _ = PrandtlIshlinskii([0.0, 0.5], [1.0, 1.0]).save(path)
    >>> load(path).simulate([0.0, 1.0]).tolist()
    [0.0, 1.5]
    """
    if not isinstance(path, str | os.PathLike):
        raise _refuse(
            f"{path!r:.60}", "is no path.", "Give the file's name, for example 'model.json'."
        )
    cure = "Name a file written by `dehyst identify ... --save`."
    text = files.text_of(path, lambda fault: _refuse(str(path), f"{fault}.", cure), MAXIMUM_BYTES)
    return model_from_text(text, str(path))
