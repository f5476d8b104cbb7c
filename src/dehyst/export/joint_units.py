"""Units of the model of a joint's compensator: the controller works in rad and Pa, whatever the log was in."""

from __future__ import annotations

from dataclasses import replace

from dehyst.control.parameters import JointControllerParameters
from dehyst.errors import UnitError
from dehyst.findings import Finding
from dehyst.models import HysteresisModel, Model
from dehyst.units import TABLE, canonical, dimension

_SAME = 1e-9  # of a unit
MEANT = {"plays": ("the controller's compensator_unit", "rad"), "direct": ("Nm", "rad")}  # by what runs the model


def in_radians(model: HysteresisModel, parameters: JointControllerParameters) -> HysteresisModel:
    """Return the model with its output in rad; its input must be in the controller's unit of pressure.

    Parameters
    ----------
    model
        Pressure difference -> angle. A unit that its card does not name is taken to be the right one.
    parameters
        Of the controller.

    Raises
    ------
    UnitError
        If its input is no pressure or in another unit than `parameters.compensator_unit`, or its output no angle.
    """
    pressure, angle = model.card.input, model.card.output
    if dimension(pressure.unit) not in ("", "pressure"):
        raise UnitError(_wrong("input", pressure.label, "a pressure difference"), unit=pressure.unit)
    if dimension(angle.unit) not in ("", "angle"):
        raise UnitError(_wrong("output", angle.label, "an angle"), unit=angle.unit)
    size = TABLE["pressure"].get(canonical(pressure.unit) or "")
    told = parameters.compensator_unit
    if size is not None and abs(size - told) > _SAME * told:
        raise UnitError(
            f"the model's input {pressure.label} is in units of {size:g} Pa, and the controller takes what its "
            f"compensator answers in units of {told:g} Pa: pressures would be wrong by a factor of {told / size:g}. "
            f'Set "compensator_unit": {size!r} in the controller file (save_controller of parameters with '
            f"compensator_unit={size!r}), or take the model that belongs to the controller.",
            unit=pressure.unit,
        )
    factor = TABLE["angle"].get(canonical(angle.unit) or "", 1.0)
    return model if factor == 1.0 else _scaled(model, factor)


def unit_findings(model: Model) -> list[Finding]:
    """Return a warning for each signal of the model of which nobody knows the unit."""
    pairs = zip((model.card.input, model.card.output), MEANT[model.core], strict=True)
    return [
        Finding(
            "unit-unknown",
            f"the model does not say in which unit its {card.name or 'signal'} is (it says '{card.unit}'): it was "
            f"taken to be in {meant}. If it is not, the compensation is wrong by that factor; name the unit in the "
            f"column and identify again.",
        )
        for card, meant in pairs
        if not dimension(card.unit)
    ]


def _wrong(side: str, label: str, wanted: str) -> str:
    return (
        f"the model's {side} is {label}, and the model of a joint's compensator maps a pressure difference to an "
        f"angle: its {side} is {wanted}. Take the model that dehyst.identify_joint or `dehyst reproduce` made."
    )


def _scaled(model: HysteresisModel, factor: float) -> HysteresisModel:
    """Return the model with its output times `factor`, in rad."""
    card = model.card.output
    low, high = (None if end is None else end * factor for end in (card.low, card.high))
    named = replace(model.card, output=replace(card, unit="rad", low=low, high=high))
    found = model.times(factor)
    if found is None:
        raise UnitError(
            f"the model's output {card.label} is not in rad, which the controller works in, and a model of the family "
            f"{model.family!r} is not converted. Identify from a log in rad.",
            unit=card.unit,
        )
    return found.with_card(named)
