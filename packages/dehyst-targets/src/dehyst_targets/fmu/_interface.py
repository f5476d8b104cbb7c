"""Variables of the FMU of a block and of a joint controller."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator

from dehyst.export import (
    ControllerInterface,
    ElementNumbers,
    ModelNumbers,
    Quantity,
    Subject,
    UnitNumbers,
)
from dehyst.export import kit as export_kit
from dehyst.families import kit as families_kit
from dehyst_targets.fmu._description import Role, Variable

_PLAIN = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
BEYOND = {real: f"{limit:g}".replace("+", "") for real, limit in export_kit.INPUT_LIMIT.items()}
# The wrapper of a block writes them by place: the order is that of fmu/unit_block.h.j2.
_BLOCK_FLAGS = {
    "limited": "input or output was at its limit in the last step",
    "rejected": "the last input was no number, infinite or beyond {beyond}: the last good output is held",
    "limited_ever": "a limit was met in some step since the reset",
    "rejected_ever": "some input since the reset was no number, infinite or beyond {beyond}",
}


def fmu_interface(subject: Subject) -> tuple[Variable, ...]:
    """Return the variables of the unit, time left out, in the order of the wrapper's templates."""
    if subject.controller:
        return _joint(subject, subject.controller)
    return _block(subject)


def _block(subject: Subject) -> tuple[Variable, ...]:
    numbers = subject.block
    assert numbers is not None  # a subject without joint has a block
    numbered = (*_parameters_of(numbers, subject), *_states(numbers, subject.input.unit),
                *_limits(numbers, subject), *_constants(numbers, subject.input.unit))  # fmt: skip
    # A log may call its signals as variables of the unit are called.
    reserved = {"time", "enable", "flags", *_BLOCK_FLAGS, "input", "output", *dict(subject.more)}
    for variable in numbered:
        reserved.add(variable.name)
    source = _name(subject.input.name, "input", reserved)
    result = _name(subject.output.name, "output", reserved | {source})
    low, high = numbers.input_low, numbers.input_high
    question, answer = "wanted output of the actuator", "input of the actuator that gives it"
    if subject.what == "forward":
        question, answer = "input of the actuator", "output of the actuator"
    question = f"{question}: {subject.input.label}"
    answer = f"{answer}: {subject.output.label}"
    start, limits = (start_input(numbers),), (numbers.least, numbers.most)
    more, flags = [], []
    for (name, about), value in zip(subject.more, subject.middle[1:], strict=True):
        more.append(Variable(name, "real", "input", about, "", (value,)))
    for name, text in _BLOCK_FLAGS.items():
        about = text.format(beyond=BEYOND[subject.real])
        flags.append(Variable(name, "truth", "output", about, "", (0.0,)))
    enabled = "true: compensated; false: straight line, reached without a bump"
    return (
        Variable(source, "real", "input", question, subject.input.unit, start, low, high),
        *more,
        Variable(
            result, "real", "output", answer, subject.output.unit, (subject.start_output,), *limits
        ),
        Variable("enable", "truth", "input", enabled, "", (1.0,)),
        *flags,
        Variable(
            "flags",
            "whole",
            "output",
            "1 rejected, 2 rejected ever, 4 limited, 8 limited ever",
            "",
            (0.0,),
        ),
        *numbered,
    )


def start_input(numbers: UnitNumbers) -> float:
    """Input before one is set: zero, or what is nearest to it in range."""
    return min(max(0.0, numbers.input_low), numbers.input_high)


def _name(name: str, otherwise: str, reserved: Iterable[str]) -> str:
    """Name of a signal as importers can use it: its own if that is a plain word."""
    if _PLAIN.fullmatch(name) and name not in reserved:
        return name
    return otherwise


def tuned(subject: Subject) -> bool:
    """Whether the unit has parameters; an offset that follows the last cycle and a tuned one would fight each other."""
    return subject.block is not None and subject.block.offset is None


def _parameters_of(numbers: UnitNumbers, subject: Subject) -> Iterable[Variable]:
    """What may be set between steps; its start changes no bit of an answer, so the offset is -0."""
    if not tuned(subject):
        return
    unit, ends = subject.output.unit, (numbers.output_low, numbers.output_high)
    # FMI has no open ranges: `low` of scale and fade says 0, and the unit itself refuses a zero.
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
        (
            "fade",
            "share of a switching on or off that one sample makes; above 0",
            "",
            numbers.fade,
            0.0,
            1.0,
        ),
    ):
        yield Variable(name, "real", "parameter", text, unit=of, start=(start,), low=low, high=high)


def _states(numbers: UnitNumbers, unit: str) -> Iterable[Variable]:
    """What the unit remembers, to be read; `unit` is that of the input."""
    model = numbers.model
    if isinstance(model, ModelNumbers):
        # A map before the plays takes the unit away.
        if model.before:
            unit = ""
        yield _local("play_states", model.parts, "states of the play operators", unit)
    elif isinstance(model, ElementNumbers):
        yield _local(
            "element_states", numbers.parts, "states of the elements, in the order of `kind`"
        )
    elif model.memory:
        text = "lowest and highest plays of the stops, then path lags, their doubts, creep lags, their doubts"
        yield _local("lag_states", model.memory, text)


def _local(name: str, length: int, text: str, unit: str = "") -> Variable:
    # The zeros only give the length, because the unit calculates the values.
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
        value = {"output_low": numbers.least, "output_high": numbers.most}.get(
            name, getattr(numbers, name)
        )
        if tuned(subject) and name in ("output_low", "output_high", "fade"):
            continue  # parameters
        yield Variable(name, "real", "constant", text, unit, (float(value),))


def _constants(numbers: UnitNumbers, unit: str) -> Iterable[Variable]:
    """Numbers of the model, readable and no more; `unit` is that of the input."""
    model = numbers.model
    if isinstance(model, ModelNumbers):
        if model.before:
            unit = ""
        yield from _of_plays(model, unit)
    elif isinstance(model, ElementNumbers):
        yield from _of_elements(model)


def _of_plays(model: ModelNumbers, unit: str, prefix: str = "") -> Iterable[Variable]:
    """Numbers of a model of plays; `unit` is that of its argument."""
    yield _table(f"{prefix}threshold", model.threshold, "thresholds of the play operators", unit)
    yield _table(f"{prefix}slope", model.slope, "running sums of their weights")
    yield _table(f"{prefix}loading", model.loading, "loading curve at the thresholds")
    yield _table(f"{prefix}start", model.start, "play states after a reset", unit)
    yield Variable(
        f"{prefix}center", "real", "constant", "subtracted from the input", unit, (model.center,)
    )
    yield Variable(
        f"{prefix}offset", "real", "constant", "added to the output", "", (model.offset,)
    )
    for place, points in (("before", model.before), ("after", model.after)):
        # A model without this map has no points, and then no table.
        for axis, values in zip(("from", "to"), points or (), strict=False):
            yield _table(
                f"{prefix}{place}_{axis}",
                values,
                f"map {place} the hysteresis, breakpoints: {axis}",
            )


def _of_elements(model: ElementNumbers) -> Iterable[Variable]:
    p, (u, v) = model.parameters, model.points
    kinds = ", ".join(f"{k} {kind}" for k, kind in enumerate(families_kit.KINDS))
    for name, about in (
        ("kind", f"of the elements: {kinds}"),
        ("schedule", "whose share weighs them: 0 none, odd 1 - xi, even xi"),
        ("radius", "of the elements"),
        ("gain", "at the period"),
        ("weight", "of the elements"),
    ):
        yield _table(name, getattr(p, name), about)
    tables = (("map_from", u), ("map_to", v), ("before_from", p.before[0]), ("before_to", p.before[1]),
              ("after_from", p.after[0]), ("after_to", p.after[1]), ("start", p.start))  # fmt: skip
    for name, values in tables:
        # Which tables a model has depends on its family: an empty one would be a variable without a value.
        if values:
            yield _table(name, values, f"table {name.replace('_', ': ')}")
    for name in ("center", "half_range", "level", "amplitude"):
        about = f"{name.replace('_', ' ')} of the scaling"
        yield Variable(name, "real", "constant", about, "", (p.numbers[name],))


def _joint(subject: Subject, controller: ControllerInterface) -> tuple[Variable, ...]:
    compensator = subject.joint.compensator if subject.joint else None
    variables = [*_quantities(controller.inputs, "input")]
    variables += _quantities(controller.outputs, "output")
    for name, (_, meaning) in controller.switches.items():
        variables.append(Variable(f"{name}_on", "truth", "input", meaning, "", (0.0,)))
    for name, (_, meaning) in controller.flags.items():
        # In the structured naming convention a name with a hyphen would have to stand in quotes.
        variables.append(Variable(name.replace("-", "_"), "truth", "output", meaning, "", (0.0,)))
    variables.append(Variable("flags", "whole", "output", "sum of all flags", "", (0.0,)))
    if compensator:
        variables.append(_local("compensator_play_states", compensator.parts, "its play states"))
    variables += _quantities(controller.constants, "constant")
    if compensator:
        variables += _of_plays(compensator, "", "compensator_")
    return tuple(variables)


def _quantities(quantities: Iterable[Quantity], role: Role) -> Iterator[Variable]:
    """Return signals or constants of a controller as variables."""
    for quantity in quantities:
        low, high = quantity.limits or (None, None)
        yield Variable(
            quantity.name,
            "real",
            role,
            quantity.meaning,
            quantity.unit,
            quantity.values,
            low,
            high,
            quantity.table,
        )


def _table(name: str, values: Iterable[float], text: str, unit: str = "") -> Variable:
    return Variable(name, "real", "constant", text, unit, tuple(map(float, values)), array=True)
