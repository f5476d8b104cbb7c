"""Whether a model and a joint controller belong together."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from dehyst.control import load_controller, load_partner
from dehyst.control.storage import about
from dehyst.errors import ModelFileError
from dehyst.findings import Finding
from dehyst.models import Model
from dehyst.models.storage import model_to_dict

SHOWN = 12  # characters of a checksum


def pair_findings(model: Model, path: Path, controller: Path | None) -> list[Finding]:
    """Refuse a controller that was made for another model, and say where the two contradict each other.

    Parameters
    ----------
    model
        As it was read, with its card.
    path
        Its file.
    controller
        File of the controller; None if there is none.

    Raises
    ------
    ModelFileError
        If the file of the controller names another model.
    """
    if controller is None:
        return []
    partner, own = load_partner(controller), str(model_to_dict(model)["sha256"])
    if partner is None:
        return list(_contradictions(model, path, controller))
    checksum, was = partner
    if checksum != own:
        raise ModelFileError(
            f"controller '{controller}' was made for another model than '{path}': for {was}, checksum "
            f"{checksum[:SHOWN]}, and this is {about(model)}, checksum {own[:SHOWN]}. Its shear and its gains belong "
            f"to that model; with this one the compensation is wrong without a sign of it. Give the two files of one "
            f"run, for example model_joint1_best.json with controller_joint1_best.json; or, if they do belong "
            f"together, write the controller again: dehyst.control.save_controller(parameters, FILE, model=model).",
            path=str(controller),
        )
    return []


def _contradictions(model: Model, path: Path, controller: Path) -> Iterator[Finding]:
    """Say that the shear of one is not that of the other, as far as names tell."""
    k, name = load_controller(controller).shear, model.card.input.name
    if model.core == "direct" and k != 0.0:
        what = f"'{path}' is a direct inverse, which is not sheared, and the controller subtracts k q, k = {k:g} Pa/rad"
    elif model.core == "plays" and model.shear is None and k == 0.0 and "sheared" in name.lower():
        what = f"the input {model.card.input.label} of '{path}' holds k q, and the controller subtracts none (shear 0)"
    else:
        return
    yield Finding(
        "pair-doubtful",
        f"{what}: these do not look like files that belong together, and '{controller}' does not say which model it "
        f'was made for. Give the files of one run, or set "shear" right and write the controller again with '
        f"dehyst.control.save_controller(parameters, FILE, model=model).",
    )
