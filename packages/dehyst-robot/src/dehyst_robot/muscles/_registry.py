"""Table of muscle models by name, and their files: the parameters of a fitted model as plain JSON."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from dehyst.errors import ModelFileError, ParameterError
from dehyst.files import document_of, text_of, write_atomically
from dehyst.shell import command, did_you_mean
from dehyst_robot.muscles._base import MuscleModel
from dehyst_robot.muscles._braided import BoblanMartens, ChouHannaford, DavisCaldwell, Klute
from dehyst_robot.muscles._conical import Kerscher, TonduLopez, TonduZagal
from dehyst_robot.muscles._elements import Reynolds, VoMinh
from dehyst_robot.muscles._maps import AschemannSchindele, Maker, Sarosi

# Maps first, then models that add friction, speed and memory.
_CLASSES: tuple[type[MuscleModel], ...] = (
    Maker, Sarosi, AschemannSchindele, BoblanMartens, ChouHannaford, TonduLopez,
    DavisCaldwell, TonduZagal, Klute, Reynolds, Kerscher, VoMinh,
)  # fmt: skip
MODELS: dict[str, type[MuscleModel]] = {kind.name: kind for kind in _CLASSES}
FORMAT = "dehyst-muscle"
SCHEMA = 1
LARGEST = 100_000  # bytes; parameters are a few numbers


def muscle_names() -> tuple[str, ...]:
    """Return the names of the models.

    Examples
    --------
    >>> "tondu-lopez" in muscle_names()
    True
    """
    return tuple(MODELS)


def muscle_class(name: str) -> type[MuscleModel]:
    """Return a model's class by its name.

    Raises
    ------
    ParameterError
        If there is none of that name.
    """
    if name not in MODELS:
        hint = did_you_mean(name, MODELS)
        raise ParameterError(
            f"no muscle model '{name!s:.40}'.{hint} There are: {', '.join(MODELS)}. What each is: dehyst muscle --list",
            name=name,
        )
    return MODELS[name]


def muscle(name: str, which: str = "", **changes: Any) -> MuscleModel:
    """Return a model with a published parameter set, and some parameters changed.

    Parameters
    ----------
    name
        Of the model.
    which
        Parameter set, one of its `SETS`; the first one if none is named.
    **changes
        Parameters by name.

    Raises
    ------
    ParameterError
        If there is no such model, set or parameter, or a value has no meaning.

    Examples
    --------
    >>> muscle("tondu-lopez", length=0.25).length
    0.25
    """
    kind = muscle_class(name)
    model = kind.published(which)
    values = {entry.name: getattr(model, entry.name) for entry in kind.PARAMETERS}
    for key in changes:
        if key not in values:
            raise ParameterError(
                f"{name} has no parameter {key!r:.40}; it has: {', '.join(values)}.",
                parameter=key,
            )
    return kind(**{**values, **changes})


def save_muscle(
    model: MuscleModel, path: str | os.PathLike[str], provenance: Mapping[str, Any] | None = None
) -> Path:
    """Write a model's parameters to a JSON file, which `load_muscle` and ``dehyst muscle FILE`` read.

    Examples
    --------
    >>> import pathlib, tempfile
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
    # A file may come from anywhere: whatever is wrong with its values becomes one message.
    try:
        kind = muscle_class(content["model"])
        values = dict(content["parameters"])
        names_of_model = {entry.name for entry in kind.PARAMETERS}
        if set(values) != names_of_model:
            odd = sorted(set(values) ^ names_of_model)
            raise ParameterError(f"parameters {', '.join(odd)} are missing or unknown")
        for key, value in values.items():
            if isinstance(value, list):  # JSON knows no tuples
                values[key] = tuple(value)
        return kind(**values)
    except (ParameterError, TypeError, ValueError, KeyError) as fault:
        raise _refused(path, f"holds no model ({fault!s:.200})") from None


def _content(path: Path) -> dict[str, Any]:
    def refused(fault: str) -> ModelFileError:
        return _refused(path, fault)

    content = document_of(text_of(path, refused, LARGEST), refused)
    if not isinstance(content, dict) or content.get("format") != FORMAT:
        raise _refused(path, f'is no muscle: its "format" is not "{FORMAT}"')
    if content.get("schema") != SCHEMA:
        raise _refused(
            path, f"has schema {content.get('schema')!r:.20}, and this dehyst reads {SCHEMA}"
        )
    if not isinstance(content.get("parameters"), dict) or not isinstance(content.get("model"), str):
        raise _refused(path, "names no model and its parameters")
    return content


def _refused(path: str | os.PathLike[str], fault: str) -> ModelFileError:
    line = command("muscle", "MODEL", log="LOG", save=Path(path).name)
    return ModelFileError(f"muscle file '{path}' {fault}. Write it again: {line}", path=str(path))
