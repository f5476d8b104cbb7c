"""Files of a joint controller: JSON with schema version and checksum; errors of saved states as messages."""

from __future__ import annotations

import hashlib
import json
import os
from pathlib import Path
from typing import Any

from dehyst.errors import ModelFileError, ParameterError
from dehyst.files import document_of, text_of, write_atomically
from dehyst.models import Model, model_to_dict
from dehyst.shell import visible
from dehyst_robot.control._parameters import Adaptation, JointControllerParameters
from dehyst_robot.fields import read

FORMAT = "dehyst-controller"
SCHEMA = 1
# Parts of a file in the order of its reader; a file may lack the last two.
_PARTS = ("parameters", "adaptation", "model")
# Larger files are no controllers: they are not read into memory.
_MOST_BYTES = 64 * 1024


def controller_text(
    parameters: JointControllerParameters,
    adaptation: Adaptation | None = None,
    model: Model | None = None,
) -> str:
    """Return the content of a controller file; floats keep all digits."""
    parts = _parts(parameters, adaptation)
    # The model itself has a file of its own.
    if model is not None:
        parts["model"] = {"sha256": model_to_dict(model)["sha256"], "about": about(model)}
    content: dict[str, Any] = {
        "format": FORMAT,
        "schema": SCHEMA,
        **parts,
        "sha256": _checksum(parts),
    }
    return json.dumps(content, indent=1, allow_nan=False) + "\n"


def about(model: Model) -> str:
    """Return family and signals of a model in words.

    Examples
    --------
    >>> from dehyst.models import ModelCard, PrandtlIshlinskii, SignalCard
    >>> card = ModelCard(SignalCard("sheared", "bar"), SignalCard("angle", "rad"))
    >>> about(PrandtlIshlinskii([0.0], [1.0], card=card))
    'pi, sheared [bar] and angle [rad]'
    """
    description = f"{model.family}, {model.card.input.label} and {model.card.output.label}"
    return visible(description)[:120]


def controller_checksum(
    parameters: JointControllerParameters, adaptation: Adaptation | None = None
) -> str:
    """Return the sha256 of the parameters, and of the adaptation if there is one."""
    return _checksum(_parts(parameters, adaptation))


def _parts(parameters: JointControllerParameters, adaptation: Adaptation | None) -> dict[str, Any]:
    """Return parameters and adaptation as a reader of the file gets them: JSON knows lists, but no tuples."""
    parts: dict[str, Any] = {"parameters": parameters.as_dict()}
    if adaptation is not None:
        parts["adaptation"] = adaptation.as_dict()
    return dict(json.loads(json.dumps(parts, allow_nan=False)))


def _checksum(values: Any) -> str:
    # One text a content: sorted keys, no spaces.
    text = json.dumps(values, sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode("ascii")).hexdigest()


def save_controller(
    parameters: JointControllerParameters,
    path: str | os.PathLike[str],
    adaptation: Adaptation | None = None,
    model: Model | None = None,
) -> Path:
    """Write the parameters of a joint controller to a JSON file, atomically.

    Parameters
    ----------
    parameters
        Of the controller.
    path
        Of the file.
    adaptation
        How it learns, if it has a direct inverse.
    model
        The model that the controller was made for: the file gets its checksum; ``dehyst export`` refuses another one.

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
    return write_atomically(path, controller_text(parameters, adaptation, model))


def load_controller(path: str | os.PathLike[str]) -> JointControllerParameters:
    """Read the parameters of a joint controller.

    Raises
    ------
    ModelFileError
        If the file is missing, damaged, edited, or holds parameters of no controller.
    """
    return controller_from_text(_read(path), str(path))


def load_adaptation(path: str | os.PathLike[str]) -> Adaptation | None:
    """Read how a joint controller with a direct inverse learns; None if the file does not say."""
    return controller_and_adaptation(_read(path), str(path))[1]


def load_partner(path: str | os.PathLike[str]) -> tuple[str, str] | None:
    """Read which model a controller was made for: its checksum and what it is; None if the file does not say.

    Examples
    --------
    >>> import tempfile, pathlib
    >>> from dehyst.models import PrandtlIshlinskii
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "controller.json"
    >>> made_for = PrandtlIshlinskii([0.0], [2.0])
    >>> load_partner(save_controller(JointControllerParameters(), path, model=made_for))[1]
    'pi, input and output'
    >>> load_partner(save_controller(JointControllerParameters(), path)) is None
    True
    """
    return _content(_read(path), str(path))[2]


def _read(path: str | os.PathLike[str]) -> str:
    return text_of(path, lambda fault: _refused(path, f"{fault}."), _MOST_BYTES)


def controller_from_text(text: str, path: str = "controller") -> JointControllerParameters:
    """Return the parameters that the text of a file describes; errors name the file."""
    return controller_and_adaptation(text, path)[0]


def controller_and_adaptation(
    text: str, path: str = "controller"
) -> tuple[JointControllerParameters, Adaptation | None]:
    """Return the parameters and, if the text has one, the adaptation; errors name the file."""
    return _content(text, path)[:2]


def _content(
    text: str, path: str
) -> tuple[JointControllerParameters, Adaptation | None, tuple[str, str] | None]:
    """Return parameters, adaptation and partner: checksum and description of the model."""
    content = document_of(text, lambda fault: _refused(path, f"{fault}."))
    if not isinstance(content, dict) or content.get("format") != FORMAT:
        raise _refused(path, f'is no joint controller: it lacks "format": "{FORMAT}".')
    schema = content.get("schema")
    if type(schema) is not int or schema != SCHEMA:
        raise _refused(
            path, f"has schema version {schema!s:.40}; this dehyst reads version {SCHEMA}."
        )
    parts = {key: content[key] for key in _PARTS if key in content}
    values, learning, partner = parts.get("parameters"), parts.get("adaptation"), parts.get("model")
    # A file may come from anywhere: whatever is wrong with its values becomes one message.
    try:
        if not isinstance(values, dict) or _checksum(parts) != content.get("sha256"):
            raise _refused(
                path, "does not match its checksum: it was edited or damaged after it was saved."
            )
        parameters = read(JointControllerParameters, values, "parameters")
        adaptation = made_for = None
        if learning is not None:
            adaptation = read(Adaptation, learning, "adaptation")
        if partner is not None:
            made_for = (_words(partner["sha256"]), _words(partner["about"]))
        return parameters, adaptation, made_for
    except (ParameterError, TypeError, KeyError, ValueError, RecursionError) as fault:
        raise _refused(path, f"holds parameters of no controller: {fault!s:.300}.") from None


def _words(text: object) -> str:
    if not isinstance(text, str):
        raise TypeError(f"its model is described by a {type(text).__name__}, not by a text")
    return visible(text)[:120]


def _refused(path: object, fault: str) -> ModelFileError:
    return ModelFileError(
        f"controller file '{path}' {fault} Write it with dehyst_robot.control.save_controller(parameters, path); "
        f"`dehyst reproduce` writes one for each joint.",
        path=str(path),
    )
