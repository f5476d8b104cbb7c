"""Files of a joint controller's parameters: plain JSON with a schema version and a checksum, as model files are."""

from __future__ import annotations

import hashlib
import json
import os
from pathlib import Path
from typing import Any

from dehyst.control.adaptation import Adaptation
from dehyst.control.parameters import JointControllerParameters, Pneumatics
from dehyst.errors import ModelFileError, ParameterError
from dehyst.files import write_atomically

FORMAT = "dehyst-controller"
SCHEMA = 2  # 1: without "adaptation"; still written where there is none
_MOST_BYTES = 64 * 1024


def controller_text(parameters: JointControllerParameters, adaptation: Adaptation | None = None) -> str:
    """Return the content of a controller file; floats keep all digits."""
    content: dict[str, Any] = {"format": FORMAT, "schema": 1 if adaptation is None else SCHEMA}
    content |= _told(parameters, adaptation)
    content["sha256"] = controller_checksum(parameters, adaptation)
    return json.dumps(content, indent=1, allow_nan=False) + "\n"


def controller_checksum(parameters: JointControllerParameters, adaptation: Adaptation | None = None) -> str:
    """Return the sha256 of the parameters, and of the adaptation if there is one."""
    told = _told(parameters, adaptation)
    return _checksum(told["parameters"] if adaptation is None else told)


def _told(parameters: JointControllerParameters, adaptation: Adaptation | None) -> dict[str, Any]:
    told: dict[str, Any] = {"parameters": parameters.as_dict()}
    if adaptation is not None:
        told["adaptation"] = adaptation.as_dict()
    return dict(json.loads(json.dumps(told, allow_nan=False)))


def _checksum(values: Any) -> str:
    return hashlib.sha256(json.dumps(values, sort_keys=True, separators=(",", ":")).encode("ascii")).hexdigest()


def save_controller(
    parameters: JointControllerParameters, path: str | os.PathLike[str], adaptation: Adaptation | None = None
) -> Path:
    """Write the parameters of a joint controller to a JSON file, atomically, with how it learns if that is given.

    Raises
    ------
    OutputError
        If the file cannot be written.

    Examples
    --------
    >>> import tempfile, pathlib
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "controller.json"
    >>> load_controller(save_controller(JointControllerParameters(pole=5.0), path)).pole
    5.0
    >>> load_adaptation(save_controller(JointControllerParameters(), path, Adaptation(rate=0.5))).rate
    0.5
    """
    return write_atomically(path, controller_text(parameters, adaptation))


def load_controller(path: str | os.PathLike[str]) -> JointControllerParameters:
    """Read the parameters of a joint controller.

    Parameters
    ----------
    path
        A file written by `save_controller` or `dehyst reproduce`.

    Raises
    ------
    ModelFileError
        If the file is missing, damaged, edited, or holds parameters of no controller.
    """
    return controller_from_text(_read(path), str(path))


def load_adaptation(path: str | os.PathLike[str]) -> Adaptation | None:
    """Read how a joint controller with a direct inverse learns; None if the file does not say.

    Raises
    ------
    ModelFileError
        If the file is missing, damaged, edited, or holds parameters of no controller.
    """
    return controller_and_adaptation(_read(path), str(path))[1]


def _read(path: str | os.PathLike[str]) -> str:
    source = Path(path)
    try:
        if not source.is_file():
            raise _refuse(path, "is no file." if source.exists() else "does not exist.")
        if source.stat().st_size > _MOST_BYTES:
            raise _refuse(path, f"is larger than {_MOST_BYTES} bytes, which no controller needs.")
        return source.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as fault:
        raise _refuse(path, f"cannot be read ({fault}).") from None


def controller_from_text(text: str, path: str = "controller") -> JointControllerParameters:
    """Return the parameters that the text of a file describes, or refuse it by name."""
    return controller_and_adaptation(text, path)[0]


def controller_and_adaptation(
    text: str, path: str = "controller"
) -> tuple[JointControllerParameters, Adaptation | None]:
    """Return parameters and, if the text tells it, the adaptation; or refuse it by name."""
    try:
        content = json.loads(text)
    except (ValueError, RecursionError) as fault:
        raise _refuse(path, f"is not JSON ({fault}).") from None
    if not isinstance(content, dict) or content.get("format") != FORMAT:
        raise _refuse(path, f'is no joint controller: it lacks "format": "{FORMAT}".')
    schema = content.get("schema")
    if schema not in (1, SCHEMA) or isinstance(schema, bool):
        raise _refuse(path, f"has schema version {schema!s:.40}; this dehyst reads versions 1 and {SCHEMA}.")
    values, learning = content.get("parameters"), content.get("adaptation") if schema == SCHEMA else None
    signed = values if schema == 1 else {"parameters": values, "adaptation": learning}
    try:
        if not isinstance(values, dict) or _checksum(signed) != content.get("sha256"):
            raise _refuse(path, "does not match its checksum: it was edited or damaged after it was saved.")
        air = values.pop("pneumatics")
        volume = tuple(tuple(one) for one in values.pop("volume"))
        parameters = JointControllerParameters(**values, volume=volume, pneumatics=Pneumatics(**air))  # type: ignore[arg-type]
        return parameters, None if learning is None else Adaptation(**learning)
    except (ParameterError, TypeError, KeyError, ValueError, RecursionError) as fault:
        raise _refuse(path, f"holds parameters of no controller: {fault!s:.300}.") from None


def _refuse(path: object, what: str) -> ModelFileError:
    return ModelFileError(
        f"controller file '{path}' {what} Write it with dehyst.control.save_controller(parameters, path); "
        f"`dehyst reproduce` writes one for each joint.",
        path=str(path),
    )
