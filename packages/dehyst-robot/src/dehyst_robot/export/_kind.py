"""The joint controller as a kind of controller that `dehyst export` writes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

from dehyst.errors import ModelFileError
from dehyst.export import Subject
from dehyst.findings import Finding
from dehyst.models import Model, model_to_dict
from dehyst_robot.control import (
    about,
    controller_and_adaptation,
    load_adaptation,
    load_controller,
    load_partner,
)
from dehyst_robot.export._interface import OUTPUTS, REFERENCE, SENSORS
from dehyst_robot.export._joint import joint_subject, unit_findings

SHOWN = 12  # characters of a checksum


class JointControllerKind:
    """Makes the subject of a joint controller from a model and a file of parameters."""

    def from_file(
        self, model: Model, path: Path, *, name: str, real: str
    ) -> tuple[Subject, list[Finding]]:
        """Return the controller with the parameters of a file, and what is not known of the model's units."""
        parameters, adaptation = load_controller(path), load_adaptation(path)
        subject = joint_subject(model, parameters, adaptation, name=name, real=real)
        return subject, unit_findings(model)

    def from_folder(
        self, model: Model, text: Callable[[str], str], folder: Path, settings: Mapping[str, Any]
    ) -> Subject:
        """Return the controller of an export folder again."""
        name, real = str(settings["name"]), str(settings["real"])
        controller_name = str(folder / "controller.json")
        parameters, adaptation = controller_and_adaptation(text("controller.json"), controller_name)
        return joint_subject(model, parameters, adaptation, name=name, real=real)

    def shown_interface(self) -> list[str]:
        """Return lines about sensors, references and outputs."""
        references = {f"{name}_d": about for name, about in REFERENCE.items()}
        lines = []
        for kind, signals in (
            ("sensors", SENSORS),
            ("references", references),
            ("outputs", OUTPUTS),
        ):
            shown = []
            for name, (unit, _) in signals.items():
                # Only valve commands have no unit.
                shown.append(f"{name} [{unit or '-1 .. 1'}]")
            lines.append(f"{kind}: {', '.join(shown)}")
        return lines

    def pair_findings(self, model: Model, model_path: Path, path: Path) -> list[Finding]:
        """Refuse a controller that was made for another model, and say where the two contradict each other."""
        partner, own_checksum = load_partner(path), str(model_to_dict(model)["sha256"])
        if partner is None:
            return list(_contradictions(model, model_path, path))
        checksum, was = partner
        if checksum != own_checksum:
            raise ModelFileError(
                f"controller '{path}' was made for another model than '{model_path}': for {was}, checksum "
                f"{checksum[:SHOWN]}, and this is {about(model)}, checksum {own_checksum[:SHOWN]}. Its shear and its "
                f"gains belong to that model; with this one the compensation is wrong without a sign of it. Give the "
                f"two files of one run, for example model_joint1_best.json with controller_joint1_best.json; or, if "
                f"they do belong together, write the controller again: "
                f"dehyst_robot.control.save_controller(parameters, FILE, model=model).",
                path=str(path),
            )
        return []


def _contradictions(model: Model, path: Path, controller: Path) -> Iterator[Finding]:
    """Say that the shear of one is not that of the other, as far as names tell."""
    k, name = load_controller(controller).shear, model.card.input.name
    if model.core == "direct" and k != 0.0:
        why = f"'{path}' is a direct inverse, which is not sheared, and the controller subtracts k q, k = {k:g} Pa/rad"
    elif model.core == "plays" and model.shear is None and k == 0.0 and "sheared" in name.lower():
        why = f"the input {model.card.input.label} of '{path}' holds k q, and the controller subtracts none (shear 0)"
    else:
        return
    yield Finding(
        "pair-doubtful",
        f"{why}: these do not look like files that belong together, and '{controller}' does not say which model it "
        f'was made for. Give the files of one run, or set "shear" right and write the controller again with '
        f"dehyst_robot.control.save_controller(parameters, FILE, model=model).",
    )


KIND = JointControllerKind()
