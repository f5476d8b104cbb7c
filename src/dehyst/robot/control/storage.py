"""Files of a joint controller: JSON with schema version and checksum; errors of saved states as messages."""

from __future__ import annotations

import hashlib
import json
import os
from pathlib import Path
from typing import Any

from dehyst.errors import ModelFileError, ParameterError
from dehyst.fields import read
from dehyst.files import document_of, text_of, write_atomically
from dehyst.models import Model
from dehyst.models.storage import model_to_dict
from dehyst.robot.control.parameters import Adaptation, JointControllerParameters
from dehyst.shell import visible

FORMAT = "dehyst-controller"
SCHEMA = 3  # 1: parameters alone; 2: with "adaptation"; 3: with "model"; each written only where it is needed
_MOST_BYTES = 64 * 1024


def controller_text(
    parameters: JointControllerParameters, adaptation: Adaptation | None = None, model: Model | None = None
) -> str:
    """Return the content of a controller file; floats keep all digits."""
    schema = SCHEMA if model is not None else 1 if adaptation is None else 2
    told = _told(parameters, adaptation)
    if model is not None:
        told["model"] = {"sha256": model_to_dict(model)["sha256"], "about": about(model)}
    signed = told["parameters"] if schema == 1 else told
    content: dict[str, Any] = {"format": FORMAT, "schema": schema, **told, "sha256": _checksum(signed)}
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
    told = f"{model.family}, {model.card.input.label} and {model.card.output.label}"
    return visible(told)[:120]


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
    parameters: JointControllerParameters,
    path: str | os.PathLike[str],
    adaptation: Adaptation | None = None,
    model: Model | None = None,
) -> Path:
    """Write the parameters of a joint controller to a JSON file, atomically.

    Parameters
    ----------
    parameters
        What is written.
    path
        Where to.
    adaptation
        How it learns, if it has a direct inverse.
    model
        The model that it was made for: its checksum goes into the file, and ``dehyst export`` refuses any other one.

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
    return text_of(path, lambda what: _refused(path, f"{what}."), _MOST_BYTES)


def controller_from_text(text: str, path: str = "controller") -> JointControllerParameters:
    """Return the parameters that the text of a file describes, or refuse it by name."""
    return controller_and_adaptation(text, path)[0]


def controller_and_adaptation(
    text: str, path: str = "controller"
) -> tuple[JointControllerParameters, Adaptation | None]:
    """Return parameters and, if the text tells it, the adaptation; or refuse it by name."""
    return _content(text, path)[:2]


def _content(text: str, path: str) -> tuple[JointControllerParameters, Adaptation | None, tuple[str, str] | None]:
    """Return parameters, adaptation and partner."""
    content = document_of(text, lambda what: _refused(path, f"{what}."))
    if not isinstance(content, dict) or content.get("format") != FORMAT:
        raise _refused(path, f'is no joint controller: it lacks "format": "{FORMAT}".')
    schema = content.get("schema")
    if schema not in (1, 2, SCHEMA) or isinstance(schema, bool):
        raise _refused(path, f"has schema version {schema!s:.40}; this dehyst reads versions 1 to {SCHEMA}.")
    told = {key: content[key] for key in ("parameters", "adaptation", "model")[:schema] if key in content}
    if schema == SCHEMA and "model" not in told:
        raise _refused(path, f"has schema version {SCHEMA} and names no model: it was edited after it was saved.")
    values, learning, partner = (told.get(key) for key in ("parameters", "adaptation", "model"))
    signed = values if schema == 1 else told
    try:
        if not isinstance(values, dict) or _checksum(signed) != content.get("sha256"):
            raise _refused(path, "does not match its checksum: it was edited or damaged after it was saved.")
        parameters = read(JointControllerParameters, values, "parameters")
        learned = None if learning is None else read(Adaptation, learning, "adaptation")
        made_for = None if partner is None else (_words(partner["sha256"]), _words(partner["about"]))
        return parameters, learned, made_for
    except (ParameterError, TypeError, KeyError, ValueError, RecursionError) as fault:
        raise _refused(path, f"holds parameters of no controller: {fault!s:.300}.") from None


def _words(told: object) -> str:
    if not isinstance(told, str):
        raise TypeError(f"its model is told by a {type(told).__name__} where words belong")
    return visible(told)[:120]


def _refused(path: object, what: str) -> ModelFileError:
    return ModelFileError(
        f"controller file '{path}' {what} Write it with dehyst.robot.control.save_controller(parameters, path); "
        f"`dehyst reproduce` writes one for each joint.",
        path=str(path),
    )
