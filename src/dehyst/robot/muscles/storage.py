"""Muscle files: the parameters of a fitted model as plain JSON."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from dehyst.errors import ModelFileError, ParameterError
from dehyst.files import write_atomically
from dehyst.robot.muscles.base import MuscleModel
from dehyst.robot.muscles.registry import muscle_class

FORMAT = "dehyst-muscle"
SCHEMA = 1
LARGEST = 100_000  # bytes; parameters are a few numbers


def save_muscle(model: MuscleModel, path: str | os.PathLike[str], provenance: Mapping[str, Any] | None = None) -> Path:
    """Write a model's parameters to a JSON file, which `load_muscle` and ``dehyst muscle FILE`` read.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> from dehyst.robot.muscles import muscle
    >>> path = save_muscle(muscle("tondu-lopez", shape=1.4), pathlib.Path(tempfile.mkdtemp()) / "muscle.json")
    >>> load_muscle(path).shape
    1.4
    """
    content = {
        "format": FORMAT,
        "schema": SCHEMA,
        "model": model.name,
        "parameters": model.as_dict(),
        "provenance": dict(provenance or {}),
    }
    return write_atomically(path, json.dumps(content, indent=1, allow_nan=False) + "\n")


def load_muscle(path: str | os.PathLike[str]) -> MuscleModel:
    """Read a model from a file that `save_muscle` wrote.

    Raises
    ------
    ModelFileError
        If there is no such file, or it is none, or its numbers have no meaning.
    """
    content = _content(Path(path))
    try:
        kind = muscle_class(content["model"])
        known = {entry.name for entry in kind.PARAMETERS}
        if set(content["parameters"]) != known:
            odd = sorted(set(content["parameters"]) ^ known)
            raise ParameterError(f"parameters {', '.join(odd)} are missing or unknown")
        values = {
            key: tuple(value) if isinstance(value, list) else value for key, value in content["parameters"].items()
        }
        return kind(**values)
    except (ParameterError, TypeError, ValueError, KeyError) as fault:
        raise _refused(path, f"holds no model ({fault!s:.200})") from None


def _content(path: Path) -> dict[str, Any]:
    try:
        if path.stat().st_size > LARGEST:
            raise _refused(path, f"has more than {LARGEST} bytes, and is no muscle")
        content = json.loads(path.read_text(encoding="utf-8"))
    except OSError as fault:
        raise _refused(path, f"cannot be read: {fault.strerror}") from None
    except (ValueError, RecursionError):
        raise _refused(path, "is no JSON") from None
    if not isinstance(content, dict) or content.get("format") != FORMAT:
        raise _refused(path, f'is no muscle: its "format" is not "{FORMAT}"')
    if content.get("schema") != SCHEMA:
        raise _refused(path, f"has schema {content.get('schema')!r:.20}, and this dehyst reads {SCHEMA}")
    if not isinstance(content.get("parameters"), dict) or not isinstance(content.get("model"), str):
        raise _refused(path, "names no model and its parameters")
    return content


def _refused(path: str | os.PathLike[str], what: str) -> ModelFileError:
    return ModelFileError(
        f"muscle file '{path}' {what}. Write it again: dehyst muscle MODEL --log LOG --save {Path(path).name}",
        path=str(path),
    )
