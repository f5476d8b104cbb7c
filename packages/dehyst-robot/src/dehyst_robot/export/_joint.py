"""Export of a whole joint controller: its compensator in SI units, its parameters, its tolerances."""

from __future__ import annotations

import zlib
from dataclasses import replace
from typing import cast

import numpy as np

import dehyst._native as _native
from dehyst.errors import ParameterError, UnitError
from dehyst.export import DirectNumbers, JointNumbers, ModelNumbers, Signal, Subject
from dehyst.export import kit as export_kit
from dehyst.findings import Finding
from dehyst.models import DirectInverse, HysteresisModel, Model, model_to_dict
from dehyst.units import TABLE, canonical, dimension
from dehyst_robot.control import FLAGS, Adaptation, JointController, JointControllerParameters
from dehyst_robot.control import kit as control_kit
from dehyst_robot.export._interface import joint_interface
from dehyst_robot.export._joint_run import joint_run

# In float, shares of the largest size of each output. Measured: valve commands 4e-3, because they hold derivatives of
# pressures of 1e5 Pa over a period; everything else 6e-5, where limits are met in the same periods.
VALVE_TOLERANCE, JOINT_TOLERANCE = 2e-2, 1e-4
SLIPS = 4  # limits that are met a period earlier or later and not forgotten yet; measured: 1 or 2
_LIMITS = FLAGS["pressure-limit"] | FLAGS["valve-limit"]
_SAME = 1e-9  # of a unit
MEANT = {
    "plays": ("the controller's compensator_unit", "rad"),
    "direct": ("Nm", "rad"),
}  # by what runs the model


def joint_subject(
    model: Model,
    parameters: JointControllerParameters,
    adaptation: Adaptation | None = None,
    *,
    name: str,
    real: str = "double",
) -> Subject:
    """Return a joint controller whose compensator is the inverse of a model, or a direct inverse.

    Parameters
    ----------
    model
        Identified: sheared pressure difference -> angle. Its inverse becomes the compensator. An angle that is not in
        rad is converted, exactly by its unit. Or a direct inverse, angle -> torque.
    parameters
        Of the controller.
    adaptation
        How a direct inverse learns; None: with the defaults of `Adaptation`.
    name
        C identifier.
    real
        "double" or "float".

    Raises
    ------
    ParameterError
        If the name is none, or the model does not survive the rounding to float.
    InvertibilityError
        If the model has no inverse.
    UnitError
        If the model is in no units of a joint, or its pressures in another than the controller's.
    """
    # Refused here, before anything is written.
    export_kit.check_choice(real, export_kit.REALS, "--real")
    export_kit.check_name(name)
    if model.core not in ("plays", "direct"):
        raise ParameterError(
            f"a joint controller holds a model of plays or a direct inverse, not a {model.family} model. Export that "
            f"as a unit of its own, --what inverse, or identify one for the controller: dehyst identify LOG --family "
            f"pi."
        )
    # A model of plays does not learn.
    learning = None
    if model.core == "direct":
        learning = adaptation or Adaptation()
    compensator = _compensator(model, parameters)
    if not isinstance(compensator, DirectInverse):
        control_kit.refuse_second_shear(compensator, parameters.shear)
    source, result = compensator.card.input, compensator.card.output
    if isinstance(compensator, DirectInverse):
        source, result = result, source
    checksum = control_kit.controller_checksum(parameters, learning)
    # Any change of model, parameters or type of number changes it.
    fingerprint = zlib.crc32(f"{checksum} {model_to_dict(model)['sha256']} {real}".encode("ascii"))
    numbers = _numbers(compensator, parameters, learning or control_kit.OFF, real, fingerprint)
    # The test is a part of the export: each target replays it.
    test = joint_run(parameters, compensator, real, learning)
    interface = joint_interface(
        JointController(parameters, compensator, learning), parameters, learning
    )
    return Subject(
        what="joint-controller",
        name=name,
        real=real,
        numbers=numbers,
        input=source,
        output=result,
        model=model,
        settings={
            "what": "joint-controller",
            "name": name,
            "real": real,
            "range": None,
            "ramp": 0,
        },
        test=test,
        tolerances=tuple(tolerances(parameters, test)),
        period=parameters.period,
        controller=interface,
        extra=interface.files,
    )


def _compensator(
    model: Model, parameters: JointControllerParameters
) -> HysteresisModel | DirectInverse:
    """A direct inverse, or the inverse of a model of plays, in the units of the controller."""
    if model.core == "direct":
        return control_kit.in_si(cast(DirectInverse, model))
    return in_radians(cast(HysteresisModel, model), parameters).inverse()


def _numbers(
    compensator: HysteresisModel | DirectInverse, parameters: JointControllerParameters, learning: Adaptation,
    real: str, fingerprint: int,
) -> JointNumbers:  # fmt: skip
    values = parameters.as_dict()
    exact: ModelNumbers | DirectNumbers
    if isinstance(compensator, DirectInverse):
        exact = export_kit.direct_numbers(
            control_kit.direct_parameters(compensator, parameters.period)
        )
        single: ModelNumbers | DirectNumbers = export_kit.direct_in(exact, real)
        checked = {**values, "adaptation": learning.as_dict()}
    else:
        exact, checked = compensator_numbers(compensator), values
        single = export_kit.in_real(exact, real)
    if real == "float":
        export_kit.check_float(exact, single)
        export_kit.check_values(checked)
    return JointNumbers(values, single, fingerprint, learning.as_dict())


def compensator_numbers(inverse: HysteresisModel) -> ModelNumbers:
    """Return the numbers of a model with the tables that the core makes of its weights."""
    limits = [-1.0, 1.0, -1.0, 1.0, -1.0, 1.0, 1.0, 0.0, 1.0]  # of a block that nobody runs
    return export_kit.model_numbers(
        _native.Block(
            _native.block_image(*inverse.stepper("dense").parameters, limits, 0)
        ).parameters
    )


def tolerances(parameters: JointControllerParameters, test: Signal) -> list[float]:
    """Return the largest error of each output in float: a share of its largest size in the test signal.

    On top of it, in what the integrator enters: what it gains when a limit is met a period earlier or later.
    """
    torque, pressure = _slip(parameters, test)
    # In the order of the outputs: valves, pressures, torque and integrator, what is observed.
    slips = [0.0, 0.0, pressure, pressure, pressure, torque, torque, *[0.0] * 6]
    shares = [VALVE_TOLERANCE] * 2 + [JOINT_TOLERANCE] * (test.outputs.shape[1] - 2)
    limits = []
    for share, column, slip in zip(shares, test.outputs.T, slips, strict=True):
        size = max(map(abs, column.tolist())) or 1.0
        limits.append(share * size + SLIPS * slip)
    return limits


def _slip(parameters: JointControllerParameters, test: Signal) -> tuple[float, float]:
    """What one period more or less at a limit makes in torque [Nm] and pressure difference [Pa].

    The last digit decides when a valve or a pressure meets its limit. From then on the integrator loses, in a period T,
    min(k_w T, 1) B(q) (dp_d - dp) by back-calculation; the largest loss next to a beginning or end of a limit counts.
    """
    p = parameters
    change = np.flatnonzero(np.diff(test.flags & _LIMITS))
    near = np.union1d(change, change + 1)
    near = near[(np.abs(test.inputs[near, 1:3]) < export_kit.FLOAT_LIMIT).all(axis=1)]
    # Torque of a pressure difference at the angle that the controller observes.
    b = np.polynomial.Polynomial(p.b)(np.clip(test.outputs[:, 8], p.angle_low, p.angle_high))
    lost = np.abs(test.outputs[near, 4] - (test.inputs[near, 1] - test.inputs[near, 2])) * b[near]
    torque = min(p.windup_gain * p.period, 1.0) * float(lost.max(initial=0.0))
    return torque, torque / float(b.min())


# ---- Units: the controller works in rad and Pa, whatever the log was in


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
        raise UnitError(
            _wrong("input", pressure.label, "a pressure difference"), unit=pressure.unit
        )
    if dimension(angle.unit) not in ("", "angle"):
        raise UnitError(_wrong("output", angle.label, "an angle"), unit=angle.unit)
    size = TABLE["pressure"].get(canonical(pressure.unit) or "")
    unit = parameters.compensator_unit
    if size is not None and abs(size - unit) > _SAME * unit:
        raise UnitError(
            f"the model's input {pressure.label} is in units of {size:g} Pa, and the controller takes what its "
            f"compensator answers in units of {unit:g} Pa: pressures would be wrong by a factor of {unit / size:g}. "
            f'Set "compensator_unit": {size!r} in the controller file (save_controller of parameters with '
            f"compensator_unit={size!r}), or take the model that belongs to the controller.",
            unit=pressure.unit,
        )
    factor = TABLE["angle"].get(canonical(angle.unit) or "", 1.0)
    if factor == 1.0:
        return model
    return _scaled(model, factor)


def unit_findings(model: Model) -> list[Finding]:
    """Return a warning for each signal of the model of which nobody knows the unit."""
    findings = []
    cards = (model.card.input, model.card.output)
    for card, meant in zip(cards, MEANT[model.core], strict=True):
        if dimension(card.unit):
            continue
        findings.append(
            Finding(
                "unit-unknown",
                f"the model does not say in which unit its {card.name or 'signal'} is (it says '{card.unit}'): it was "
                f"taken to be in {meant}. If it is not, the compensation is wrong by that factor; name the unit in the "
                f"column and identify again.",
            )
        )
    return findings


def _wrong(side: str, label: str, required: str) -> str:
    return (
        f"the model's {side} is {label}, and the model of a joint's compensator maps a pressure difference to an "
        f"angle: its {side} is {required}. Take the model that dehyst_robot.identify_joint or `dehyst reproduce` made."
    )


def _times(end: float | None, factor: float) -> float | None:
    """Scale an end of a range; a card without a range has none."""
    if end is None:
        return None
    return end * factor


def _scaled(model: HysteresisModel, factor: float) -> HysteresisModel:
    """Return the model with its output times `factor`, in rad."""
    card = model.card.output
    output = replace(card, unit="rad", low=_times(card.low, factor), high=_times(card.high, factor))
    named = replace(model.card, output=output)
    scaled = model.times(factor)
    if scaled is None:
        raise UnitError(
            f"the model's output {card.label} is not in rad, which the controller works in, and a model of the family "
            f"{model.family!r} is not converted. Identify from a log in rad.",
            unit=card.unit,
        )
    return scaled.with_card(named)
