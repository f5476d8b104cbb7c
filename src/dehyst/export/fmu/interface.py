"""Variables of the FMU of a block and of a joint controller."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import fields

from dehyst.control.joint import FLAGS, SWITCHES, JointReference
from dehyst.control.parameters import JointControllerParameters, Pneumatics
from dehyst.export.fmu.description import Variable
from dehyst.export.numbers import ElementNumbers, ModelNumbers, UnitNumbers
from dehyst.export.precision import INPUT_LIMIT
from dehyst.export.subject import Subject
from dehyst.families.elements import KINDS

_PLAIN = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
BEYOND = {real: f"{limit:g}".replace("+", "") for real, limit in INPUT_LIMIT.items()}
_BLOCK_FLAGS = {
    "limited": "input or output was at its limit in the last step",
    "rejected": "the last input was no number, infinite or beyond {beyond}: the last good output is held",
    "limited_ever": "a limit was met in some step since the reset",
    "rejected_ever": "some input since the reset was no number, infinite or beyond {beyond}",
}
_SENSORS = {
    "angle": ("rad", "measured angle"),
    "pressure_1": ("Pa", "measured gauge pressure of muscle 1"),
    "pressure_2": ("Pa", "measured gauge pressure of muscle 2"),
}
_REFERENCE = {
    "angle": ("rad", "desired angle"),
    "velocity": ("rad/s", "desired angular velocity"),
    "acceleration": ("rad/s^2", "desired angular acceleration"),
    "load": ("Nm", "known torque of gravity and coupling"),
    "mean_pressure": ("Pa", "mean gauge pressure of both muscles"),
    "pressure_difference": ("Pa", "pressure difference while position control is off"),
    "extra": ("Pa", "compensator term from outside, added to the built-in one"),
}
_SWITCHES = {
    "position": "position control is on",
    "integrator": "its integrator is on",
    "compensator": "the hysteresis compensator is on",
    "adapt": "a direct inverse as compensator learns",
    "disturbance": "the contact torque is fed back",
}
_OUTPUTS = {
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
    "doubt": ("Nm", "what its torque can be wrong by while the joint's past is unknown; 0 without one"),
}
_UNITS = {  # of parameters of a joint controller
    "period": "s", "inertia": "kg.m2", "pole": "1/s", "observer_pole": "1/s", "pressure_gain": "1/s",
    "windup_gain": "1/s", "angle_low": "rad", "angle_high": "rad", "pressure_low": "Pa", "pressure_high": "Pa",
    "ramp": "s", "shear": "Pa/rad", "compensator_unit": "Pa", "angle_jump": "rad", "pressure_jump": "Pa",
    "angle_step": "rad", "supply": "Pa", "ambient": "Pa", "gas_temperature": "J/kg", "reference_density": "kg/m3",
    "conductance": "m3/(s.Pa)",
}  # fmt: skip


def interface(subject: Subject) -> tuple[Variable, ...]:
    """Return the variables of the unit, time left out, in the order of the wrapper's templates."""
    return _joint(subject) if subject.joint else _block(subject)


def _block(subject: Subject) -> tuple[Variable, ...]:
    numbers = subject.block
    assert numbers is not None  # a subject without joint has a block
    numbered = (*_parameters_of(numbers, subject), *_states(numbers, subject.input.unit),
                *_limits(numbers, subject), *_constants(numbers, subject.input.unit))  # fmt: skip
    taken = {"time", "enable", "flags", *_BLOCK_FLAGS, "input", "output", *dict(subject.more)}
    taken |= {variable.name for variable in numbered}
    source = _name(subject.input.name, "input", taken)
    result = _name(subject.output.name, "output", taken | {source})
    low, high = numbers.input_low, numbers.input_high
    said = "wanted output of the actuator" if subject.what != "forward" else "input of the actuator"
    answer = "input of the actuator that gives it" if subject.what != "forward" else "output of the actuator"
    start, limits = (start_input(numbers),), (numbers.least, numbers.most)
    said, answer = f"{said}: {subject.input.label}", f"{answer}: {subject.output.label}"
    beyond = BEYOND[subject.real]
    enabled = "true: compensated; false: straight line, reached without a bump"
    return (
        Variable(source, "real", "input", said, subject.input.unit, start, low, high),
        *(
            Variable(name, "real", "input", about, "", (value,))
            for (name, about), value in zip(subject.more, subject.middle[1:], strict=True)
        ),
        Variable(result, "real", "output", answer, subject.output.unit, (subject.start_output,), *limits),
        Variable("enable", "truth", "input", enabled, "", (1.0,)),
        *(
            Variable(name, "truth", "output", text.format(beyond=beyond), "", (0.0,))
            for name, text in _BLOCK_FLAGS.items()
        ),
        Variable("flags", "whole", "output", "1 rejected, 2 rejected ever, 4 limited, 8 limited ever", "", (0.0,)),
        *numbered,
    )


def start_input(numbers: UnitNumbers) -> float:
    """Input before one is set: zero, or what is nearest to it in range."""
    return min(max(0.0, numbers.input_low), numbers.input_high)


def _name(name: str, otherwise: str, taken: Iterable[str]) -> str:
    """Name of a signal as importers can use it: its own if that is a plain word."""
    return name if _PLAIN.fullmatch(name) and name not in taken else otherwise


def tuned(subject: Subject) -> bool:
    """Whether the unit has parameters; an offset that follows the last cycle and a tuned one would fight each other."""
    return subject.block is not None and subject.block.offset is None


def _parameters_of(numbers: UnitNumbers, subject: Subject) -> Iterable[Variable]:
    """What may be set between steps; its start changes no bit of an answer, so the offset is -0."""
    if not tuned(subject):
        return
    unit, ends = subject.output.unit, (numbers.output_low, numbers.output_high)
    for name, text, of, start, low, high in (
        (
            "output_scale",
            "the output is output_offset + output_scale times that of the model; above 0",
            "",
            1.0,
            0.0,
            None,
        ),
        ("output_offset", "added to the scaled output, within the limits", unit, -0.0, None, None),
        ("output_low", "no output lies below", unit, ends[0], *ends),
        ("output_high", "no output lies above", unit, ends[1], *ends),
        ("fade", "share of a switching on or off that one sample makes; above 0", "", numbers.fade, 0.0, 1.0),
    ):
        yield Variable(name, "real", "parameter", text, unit=of, start=(start,), low=low, high=high)


def _states(numbers: UnitNumbers, unit: str) -> Iterable[Variable]:
    """What the unit remembers, to be read; `unit` is that of the input."""
    model = numbers.model
    if isinstance(model, ModelNumbers):
        yield _local("play_states", model.parts, "states of the play operators", "" if model.before else unit)
    elif isinstance(model, ElementNumbers):
        yield _local("element_states", numbers.parts, "states of the elements, in the order of `kind`")
    elif model.memory:
        text = "lowest and highest plays of the stops, then path lags, their doubts, creep lags, their doubts"
        yield _local("lag_states", model.memory, text)


def _local(name: str, length: int, text: str, unit: str = "") -> Variable:
    return Variable(name, "real", "local", text, unit, (0.0,) * length, array=True)


def _limits(numbers: UnitNumbers, subject: Subject) -> Iterable[Variable]:
    source, result = subject.input.unit, subject.output.unit
    for name, unit, text in (
        ("input_low", source, "inputs below are taken as this"),
        ("input_high", source, "inputs above are taken as this"),
        ("output_low", result, "no output lies below"),
        ("output_high", result, "no output lies above"),
        ("line_slope", "", "slope of the straight line while not enabled"),
        ("line_offset", result, "its value at zero"),
        ("fade", "", "share of a switching that one sample makes"),
    ):
        value = {"output_low": numbers.least, "output_high": numbers.most}.get(name, getattr(numbers, name))
        if tuned(subject) and name in ("output_low", "output_high", "fade"):
            continue  # parameters
        yield Variable(name, "real", "constant", text, unit, (float(value),))


def _constants(numbers: UnitNumbers, unit: str) -> Iterable[Variable]:
    """Numbers of the model, readable and no more; `unit` is that of the input."""
    model = numbers.model
    if isinstance(model, ModelNumbers):
        yield from _of_plays(model, "" if model.before else unit)
    elif isinstance(model, ElementNumbers):
        yield from _of_elements(model)


def _of_plays(model: ModelNumbers, unit: str, prefix: str = "") -> Iterable[Variable]:
    """Numbers of a model of plays; `unit` is that of its argument."""
    yield _table(f"{prefix}threshold", model.threshold, "thresholds of the play operators", unit)
    yield _table(f"{prefix}slope", model.slope, "running sums of their weights")
    yield _table(f"{prefix}loading", model.loading, "loading curve at the thresholds")
    yield _table(f"{prefix}start", model.start, "play states after a reset", unit)
    yield Variable(f"{prefix}center", "real", "constant", "subtracted from the input", unit, (model.center,))
    yield Variable(f"{prefix}offset", "real", "constant", "added to the output", "", (model.offset,))
    for place, points in (("before", model.before), ("after", model.after)):
        for axis, values in zip(("from", "to"), points or (), strict=False):
            yield _table(f"{prefix}{place}_{axis}", values, f"map {place} the hysteresis, breakpoints: {axis}")


def _of_elements(model: ElementNumbers) -> Iterable[Variable]:
    p, (u, v) = model.parameters, model.points
    for name, about in (
        ("kind", f"of the elements: {', '.join(f'{k} {kind}' for k, kind in enumerate(KINDS))}"),
        ("schedule", "whose share weighs them: 0 none, odd 1 - xi, even xi"),
        ("radius", "of the elements"),
        ("gain", "at the period"),
        ("weight", "of the elements"),
    ):
        yield _table(name, getattr(p, name), about)
    tables = (("map_from", u), ("map_to", v), ("before_from", p.before[0]), ("before_to", p.before[1]),
              ("after_from", p.after[0]), ("after_to", p.after[1]), ("start", p.start))  # fmt: skip
    yield from (_table(name, values, f"table {name.replace('_', ': ')}") for name, values in tables if values)
    for name in ("center", "half_range", "level", "amplitude"):
        about = f"{name.replace('_', ' ')} of the scaling"
        yield Variable(name, "real", "constant", about, "", (p.numbers[name],))


def _joint(subject: Subject) -> tuple[Variable, ...]:
    told = subject.parameters
    assert told is not None  # a joint controller has parameters
    starts = joint_starts(told)
    compensator = subject.joint.compensator if subject.joint else None
    return (
        *(Variable(n, "real", "input", t, u, (starts[n],)) for n, (u, t) in _SENSORS.items()),
        *(
            Variable(f"reference_{n}", "real", "input", t, u, (starts[f"reference_{n}"],))
            for n, (u, t) in _REFERENCE.items()
        ),
        *(
            Variable(n, "real", "output", t, u, (0.0,), *((-1.0, 1.0) if n.startswith("valve") else ()))
            for n, (u, t) in _OUTPUTS.items()
        ),
        *(Variable(f"{name}_on", "truth", "input", _SWITCHES[name], "", (0.0,)) for name in SWITCHES),
        *(
            Variable(name.replace("-", "_"), "truth", "output", f"flag {bit}", "", (0.0,))
            for name, bit in FLAGS.items()
        ),
        Variable("flags", "whole", "output", "sum of all flags", "", (0.0,)),
        *([_local("compensator_play_states", compensator.parts, "its play states")] if compensator else []),
        *_parameters(told),
        *(_of_plays(compensator, "", "compensator_") if compensator else ()),
    )


def joint_starts(told: JointControllerParameters) -> dict[str, float]:
    """Inputs before they are set: at zero angle, muscles at their lowest pressure, reference as in `JointReference`."""
    reference = JointReference()
    sensors = {"angle": 0.0, "pressure_1": told.pressure_low, "pressure_2": told.pressure_low}
    return sensors | {f"reference_{name}": float(getattr(reference, name)) for name in _REFERENCE}


def _parameters(told: JointControllerParameters) -> Iterable[Variable]:
    for source, prefix in ((told, "parameter_"), (told.pneumatics, "parameter_")):
        for item in fields(source):
            value = getattr(source, item.name)
            if isinstance(value, Pneumatics):
                continue
            if item.name == "volume":
                for muscle, row in enumerate(value, 1):
                    yield _table(f"{prefix}volume_{muscle}", row, f"chamber volume {muscle}, powers of the angle")
            elif isinstance(value, tuple):
                yield _table(f"{prefix}{item.name}", value, f"characteristic {item.name.upper()}, powers of the angle")
            else:
                text, unit = item.name.replace("_", " "), _UNITS.get(item.name, "")
                yield Variable(f"{prefix}{item.name}", "real", "constant", text, unit, (float(value),))


def _table(name: str, values: Iterable[float], text: str, unit: str = "") -> Variable:
    return Variable(name, "real", "constant", text, unit, tuple(float(v) for v in values), array=True)
