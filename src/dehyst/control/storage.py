"""Files of a joint controller's parameters: plain JSON with a schema version and a checksum, as model files are."""

from __future__ import annotations

import hashlib
import json
import os
from pathlib import Path
from typing import Any

from dehyst.control.parameters import JointControllerParameters, Pneumatics
from dehyst.errors import ModelFileError, ParameterError
from dehyst.files import write_atomically

FORMAT = "dehyst-controller"
SCHEMA = 1
_MOST_BYTES = 64 * 1024


def controller_text(parameters: JointControllerParameters) -> str:
    """Return the content of a controller file; floats keep all digits."""
    content: dict[str, Any] = {"format": FORMAT, "schema": SCHEMA, "parameters": parameters.as_dict()}
    content = json.loads(json.dumps(content, allow_nan=False))
    content["sha256"] = controller_checksum(parameters)
    return json.dumps(content, indent=1, allow_nan=False) + "\n"


def controller_checksum(parameters: JointControllerParameters) -> str:
    """Return the sha256 of the parameters."""
    return _checksum(json.loads(json.dumps(parameters.as_dict(), allow_nan=False)))


def _checksum(values: Any) -> str:
    return hashlib.sha256(json.dumps(values, sort_keys=True, separators=(",", ":")).encode("ascii")).hexdigest()


def save_controller(parameters: JointControllerParameters, path: str | os.PathLike[str]) -> Path:
    """Write the parameters of a joint controller to a JSON file, atomically.

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
    """
    return write_atomically(path, controller_text(parameters))


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
    source = Path(path)
    try:
        if not source.is_file():
            raise _refuse(path, "is no file." if source.exists() else "does not exist.")
        if source.stat().st_size > _MOST_BYTES:
            raise _refuse(path, f"is larger than {_MOST_BYTES} bytes, which no controller needs.")
        return controller_from_text(source.read_text(encoding="utf-8"), str(path))
    except (OSError, UnicodeDecodeError) as fault:
        raise _refuse(path, f"cannot be read ({fault}).") from None


def controller_from_text(text: str, path: str = "controller") -> JointControllerParameters:
    """Return the parameters that the text of a file describes, or refuse it by name."""
    try:
        content = json.loads(text)
    except (ValueError, RecursionError) as fault:
        raise _refuse(path, f"is not JSON ({fault}).") from None
    if not isinstance(content, dict) or content.get("format") != FORMAT:
        raise _refuse(path, f'is no joint controller: it lacks "format": "{FORMAT}".')
    if content.get("schema") != SCHEMA:
        raise _refuse(path, f"has schema version {content.get('schema')!s:.40}; this dehyst reads version {SCHEMA}.")
    values = content.get("parameters")
    try:
        if not isinstance(values, dict) or _checksum(values) != content.get("sha256"):
            raise _refuse(path, "does not match its checksum: it was edited or damaged after it was saved.")
        air = values.pop("pneumatics")
        volume = tuple(tuple(one) for one in values.pop("volume"))
        return JointControllerParameters(**values, volume=volume, pneumatics=Pneumatics(**air))  # type: ignore[arg-type]
    except (ParameterError, TypeError, KeyError, ValueError, RecursionError) as fault:
        raise _refuse(path, f"holds parameters of no controller: {fault!s:.300}.") from None


def _refuse(path: object, what: str) -> ModelFileError:
    return ModelFileError(
        f"controller file '{path}' {what} Write it with dehyst.control.save_controller(parameters, path); "
        f"`dehyst reproduce` writes one for each joint.",
        path=str(path),
    )
