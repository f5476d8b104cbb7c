"""Signals, switches and flags of a joint controller as targets see them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import fields

import numpy as np

from dehyst.arrays import Array
from dehyst.export import ControllerInterface, Quantity, Whole
from dehyst_robot.control import (
    FLAGS,
    SWITCHES,
    Adaptation,
    JointController,
    JointControllerParameters,
    JointReference,
    Pneumatics,
)
from dehyst_robot.control import kit as control_kit

SENSORS = {
    "angle": ("rad", "measured angle"),
    "pressure_1": ("Pa", "measured gauge pressure of muscle 1"),
    "pressure_2": ("Pa", "measured gauge pressure of muscle 2"),
}
REFERENCE = {
    "angle": ("rad", "desired angle"),
    "velocity": ("rad/s", "desired angular velocity"),
    "acceleration": ("rad/s^2", "desired angular acceleration"),
    "load": ("Nm", "known torque of gravity and coupling"),
    "mean_pressure": ("Pa", "mean gauge pressure of both muscles"),
    "pressure_difference": ("Pa", "pressure difference while position control is off"),
    "extra": ("Pa", "compensator term from outside, added to the built-in one"),
}
OUTPUTS = {
    "valve_1": ("", "command to valve 1, -1 to 1, positive fills muscle 1"),
    "valve_2": ("", "command to valve 2, -1 to 1, positive fills muscle 2"),
    "desired_1": ("Pa", "desired gauge pressure of muscle 1"),
    "desired_2": ("Pa", "desired gauge pressure of muscle 2"),
    "pressure_difference": ("Pa", "desired pressure difference before limits"),
    "torque": ("Nm", "desired torque"),
    "integrator": ("Nm", "the integrator's part of it"),
    "compensation": ("Pa", "the compensator's part of the pressure difference"),
    "observed_angle": ("rad", "observed angle"),
    "observed_velocity": ("rad/s", "observed angular velocity"),
    "observed_load": ("Nm", "observed torque that neither model nor reference know"),
    "contact": ("Nm", "what of it a direct inverse does not explain either; 0 without one"),
    "doubt": (
        "Nm",
        "what its torque can be wrong by while the joint's past is unknown; 0 without one",
    ),
}
SWITCH_MEANINGS = {
    "position": "position control; otherwise the reference's pressure difference is applied",
    "integrator": "integrator of the position loop",
    "compensator": "hysteresis compensator, and the reference's extra",
    "adapt": "the scales of a direct inverse are learned",
    "disturbance": "the contact torque is fed back",
}
FLAG_MEANINGS = {
    "angle-fault": "the angle is no number, jumps or is frozen; its prediction is used",
    "pressure-fault-1": "the first pressure is no number, jumps or is frozen",
    "pressure-fault-2": "the second pressure is no number, jumps or is frozen",
    "failed": "a fault lasted too long; valves are closed until a reset",
    "pressure-limit": "desired pressures were limited",
    "valve-limit": "a valve was limited",
    "reference-fault": "the reference is no number; the last good one is held",
    "fault-ever": "there was some fault since the reset",
    "learned": "this period taught the adaptation something",
    "stale": "the compensator does not fit: it is scaled down to the hysteresis that there is",
    "shifted": "an offset of the torque, the same both ways: a pressure sensor or a weight",
    "touched": "a torque that came at once and is none of the joint's: a hand, a wall, a load",
}
# A rounding may decide a period earlier or later.
LAST_DIGIT_FLAGS = ("pressure-limit", "valve-limit", "learned", "stale", "shifted", "touched")
PARAMETER_UNITS = {
    "period": "s", "inertia": "kg.m2", "pole": "1/s", "observer_pole": "1/s", "pressure_gain": "1/s",
    "windup_gain": "1/s", "angle_low": "rad", "angle_high": "rad", "pressure_low": "Pa", "pressure_high": "Pa",
    "ramp": "s", "shear": "Pa/rad", "compensator_unit": "Pa", "angle_jump": "rad", "pressure_jump": "Pa",
    "angle_step": "rad", "supply": "Pa", "ambient": "Pa", "gas_temperature": "J/kg", "reference_density": "kg/m3",
    "conductance": "m3/(s.Pa)",
}  # fmt: skip


def joint_interface(
    controller: JointController, parameters: JointControllerParameters, adaptation: Adaptation | None,
) -> ControllerInterface:  # fmt: skip
    """Return what targets have to know of a joint controller."""

    def run(inputs: Array, switch: Whole) -> Array:
        # As the target is, before its first period.
        controller.reset(*map(float, inputs[0, :3]))
        angle, pressure_1, pressure_2 = inputs[:, :3].T
        out = controller.run(angle, pressure_1, pressure_2, inputs[:, 3:], switch)
        columns = []
        for column in fields(out):
            if column.name != "flags":
                columns.append(getattr(out, column.name))
        return np.column_stack(columns)

    return ControllerInterface(
        sensors=_sensors(parameters),
        references=_references(),
        outputs=_outputs(),
        switches=_bits(SWITCHES, SWITCH_MEANINGS),
        flags=_bits(FLAGS, FLAG_MEANINGS),
        last_digit_flags=sum(FLAGS[name] for name in LAST_DIGIT_FLAGS),
        constants=tuple(_constants(parameters)),
        example=("reference_angle", "observed_angle", parameters.angle_low, parameters.angle_high),
        run=run,
        files={"controller.json": control_kit.controller_text(parameters, adaptation)},
    )


def _bits(bits: Mapping[str, int], meanings: Mapping[str, str]) -> dict[str, tuple[int, str]]:
    return {name: (bit, meanings[name]) for name, bit in bits.items()}


def _sensors(parameters: JointControllerParameters) -> tuple[Quantity, ...]:
    """Sensors; before one is set the joint stands at angle zero, its muscles at their lowest pressure."""
    low = parameters.pressure_low
    starts = {"angle": 0.0, "pressure_1": low, "pressure_2": low}
    quantities = []
    for name, (unit, about) in SENSORS.items():
        quantities.append(Quantity(name, unit, about, (starts[name],)))
    return tuple(quantities)


def _references() -> tuple[Quantity, ...]:
    usual = JointReference()
    quantities = []
    for name, (unit, about) in REFERENCE.items():
        quantities.append(
            Quantity(f"reference_{name}", unit, about, (float(getattr(usual, name)),))
        )
    return tuple(quantities)


def _outputs() -> tuple[Quantity, ...]:
    quantities = []
    for name, (unit, about) in OUTPUTS.items():
        limits = (-1.0, 1.0) if name.startswith("valve") else None
        quantities.append(Quantity(name, unit, about, limits=limits))
    return tuple(quantities)


def _constants(parameters: JointControllerParameters) -> Iterator[Quantity]:
    for record in (parameters, parameters.pneumatics):
        for item in fields(record):
            name, value = f"parameter_{item.name}", getattr(record, item.name)
            if isinstance(value, Pneumatics):
                continue
            if item.name == "volume":
                for muscle, row in enumerate(value, 1):
                    about = f"chamber volume {muscle}, powers of the angle"
                    yield Quantity(
                        f"{name}_{muscle}", "", about, tuple(map(float, row)), table=True
                    )
            elif isinstance(value, tuple):
                about = f"characteristic {item.name.upper()}, powers of the angle"
                yield Quantity(name, "", about, tuple(map(float, value)), table=True)
            else:
                unit = PARAMETER_UNITS.get(item.name, "")
                yield Quantity(name, unit, item.name.replace("_", " "), (float(value),))
