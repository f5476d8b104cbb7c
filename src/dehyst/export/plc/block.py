"""The function block of a model or its inverse: constants, variables, body."""

from __future__ import annotations

import re
from collections.abc import Sequence

from dehyst.export import precision
from dehyst.export.numbers import ModelNumbers, OffsetUnit, UnitNumbers
from dehyst.export.plc.numbers import constant
from dehyst.export.plc.pou import Pou, Variable
from dehyst.export.plc.template import names, rendered, used

INPUT_LIMIT = {"LREAL": precision.INPUT_LIMIT["double"], "REAL": precision.INPUT_LIMIT["float"]}


def shape(model: ModelNumbers) -> dict[str, object]:
    """Return the sizes of a model as the templates want them."""
    before, after = model.points
    return {"n": model.parts, "dead_zone": model.threshold[0] > 0, "before": before, "after": after}


def function_block(name: str, real: str, numbers: UnitNumbers, words: dict[str, str]) -> Pou:
    """Return the function block.

    Parameters
    ----------
    name
        Of its type.
    real
        LREAL or REAL.
    numbers
        Of the block.
    words
        ``input`` and ``output``: signals with units; ``about``: comment on top.
    """
    model = numbers.model
    assert isinstance(model, ModelNumbers)  # of plays
    reach = number("ReachLow", real, numbers.reach_low, "the same in front of the last map")
    own = (
        *model_tables(real, model),
        *limits(real, numbers, (reach, number("ReachHigh", real, numbers.reach_high))),
        *model_variables(real, model.parts),
        *frame_variables(real),
    )
    return unit_of(name, real, words, rendered("block.st.j2", **shape(model)), own, (), numbers.offset)


def unit_of(
    name: str, real: str, words: dict[str, str], body: str, own: tuple[Variable, ...], more: Sequence[str] = (),
    offset: OffsetUnit | None = None,
) -> Pou:  # fmt: skip
    """Return the function block of a unit from its body and its own variables; `more` are names of further inputs."""
    if offset is not None:
        around = {"InputValue": "AskedValue", "OutputValue": "SaidValue"}
        inner = re.sub("|".join(around), lambda match: around[match[0]], body)
        body = rendered("offset.st.j2", body=inner, forward=offset.forward)
        own, more = (*own, *_of_offset(real, offset)), (*more, "GivenMeasured")
    variables = (*interface(real, words, more), *own, *common_constants(real))
    return Pou("FUNCTION_BLOCK", name, used(body, variables), body, words["about"])


def _of_offset(real: str, offset: OffsetUnit) -> tuple[Variable, ...]:
    """Return constants and variables of an offset that follows the last cycle."""
    limit = INPUT_LIMIT[real]
    constants = (
        ("OffsetLow", -offset.limit, "of the offset"), ("OffsetHigh", offset.limit, ""),
        ("OffsetTurn", offset.turn, "way back that makes a turning point"),
        ("OffsetPart", offset.part, "offset that comes in along a way of one"), ("MeanLow", -limit, ""),
        ("MeanHigh", limit, ""), ("ManySamples", 1e9, "of a stroke"), ("SevenTimes", 7.0, ""),
    )  # fmt: skip
    reals = names(
        "OffsetNow OffsetNext OffsetTarget LastInput FarthestInput MeanNow MeanBefore GoodNow GoodBefore BadNow "
        "WayMade AskedValue SaidValue"
    )
    return (
        *(number(name, real, value, comment) for name, value, comment in constants),
        *(Variable("VAR", name, real, ("0.0",)) for name in reals),
        Variable("VAR", "CyclePhase", "DINT", ("0",), comment="0 nothing seen, 1 never turned, 2 falling, 3 rising"),
        *(Variable("VAR", name, "BOOL", ("FALSE",)) for name in ("StrokeEnds", "StrokeWhole")),
    )


def interface(real: str, words: dict[str, str], more: Sequence[str] = ()) -> tuple[Variable, ...]:
    """Return inputs and outputs of the function block of a unit; `more` are names of further inputs."""
    return (
        Variable("VAR_INPUT", "InputValue", real, comment=words["input"]),
        *(Variable("VAR_INPUT", name, real, comment=words.get(name, "")) for name in more),
        Variable("VAR_INPUT", "Enable", "BOOL", comment="TRUE: on; may change at any time, the output fades"),
        Variable("VAR_INPUT", "Restart", "BOOL", comment="TRUE: start states again, then this sample"),
        Variable("VAR_OUTPUT", "OutputValue", real, comment=words["output"]),
        Variable("VAR_OUTPUT", "Rejected", "BOOL", comment="this sample was no number: the last output is held"),
        Variable("VAR_OUTPUT", "RejectedEver", "BOOL", comment="some sample since the restart was"),
        Variable("VAR_OUTPUT", "Limited", "BOOL", comment="this sample met the limit of the input or of the output"),
        Variable("VAR_OUTPUT", "LimitedEver", "BOOL", comment="some sample since the restart did"),
        Variable("VAR_OUTPUT", "FlagWord", "UDINT", comment="1 rejected, 2 ever, 4 limited, 8 ever, added"),
    )


def model_tables(real: str, model: ModelNumbers) -> tuple[Variable, ...]:
    """Return the constants of a model."""
    tables = [
        ("ThresholdTable", model.threshold, "r_i [input of the hysteresis]"),
        ("SlopeTable", model.slope, "S_i = w_1 + ... + w_i"),
        ("LoadingTable", model.loading, "loading curve at r_i [output of the hysteresis]"),
        ("StartTable", model.start, "play states after a restart"),
    ]
    for name, points in (("Before", model.before), ("After", model.after)):
        if points:
            tables += [
                (f"{name}U", points[0], f"map: arguments, {name.lower()} the hysteresis"),
                (f"{name}V", points[1], "map: values"),
            ]
    return (
        *(table(name, real, values, comment) for name, values, comment in tables),
        number("InputCenter", real, model.center, "subtracted from the input"),
        number("Offset", real, model.offset, "added to the output"),
    )


def limits(real: str, b: UnitNumbers, inner: Sequence[Variable] = ()) -> tuple[Variable, ...]:
    """Return limits, straight line and fading of a unit; `inner` are limits in front of its last map."""
    return (
        number("InputLow", real, b.input_low, "inputs beyond are taken as the limit"),
        number("InputHigh", real, b.input_high),
        number("OutputLow", real, b.output_low, "no output lies beyond"),
        number("OutputHigh", real, b.output_high),
        *inner,
        number("LineSlope", real, b.line_slope, "answer while off: LineOffset + LineSlope * InputValue"),
        number("LineOffset", real, b.line_offset),
        number("Fade", real, b.fade, "share of a switching that one call makes"),
    )


def model_variables(real: str, n: int) -> tuple[Variable, ...]:
    """Return the states of a model and what its step works with."""
    zeros = tuple(["0.0"] * n)
    reals = names(
        "Beyond NextState Edge Hysteresis Side Argument Present Portion There Boundary BeginsAt MeetsAt EndsAt "
        "ModelOutput"
    )
    return (
        Variable("VAR", "States", real, zeros, n, "play states: all that the block remembers of its past"),
        *(Variable("VAR", name, real, ("0.0",)) for name in reals),
        *(Variable("VAR", name, "DINT", ("0",)) for name in names("Index Operator Dragged LeftEnd RightEnd Center")),
        *(Variable("VAR", name, "BOOL", ("FALSE",)) for name in names("Moved HeldBack Above Follows")),
    )


def frame_variables(real: str) -> tuple[Variable, ...]:
    """Return what every unit has beside its model."""
    return (
        Variable("VAR", "Running", "BOOL", ("FALSE",), comment="FALSE until the first call"),
        Variable("VAR", "Started", "BOOL", ("FALSE",), comment="FALSE until the first good sample after a restart"),
        Variable("VAR", "OnShare", real, ("0.0",), comment="0 off .. 1 on"),
        Variable("VAR", "Good", "BOOL", ("FALSE",)),
        *(Variable("VAR", name, real, ("0.0",)) for name in ("Taken", "Target", "OffLine")),
    )


def common_constants(real: str) -> tuple[Variable, ...]:
    """Return constants of the arithmetic; inside expressions tools disagree about the type of a literal."""
    return (
        number("InputLimit", real, INPUT_LIMIT[real], "samples beyond are rejected, and so is what is no number"),
        number("Zero", real, 0.0),
        number("Half", real, 0.5),
        number("One", real, 1.0),
    )


def number(name: str, real: str, value: float, comment: str = "") -> Variable:
    """Return a constant of a real type."""
    return Variable("VAR CONSTANT", name, real, (constant(value, real),), comment=comment)


def table(name: str, real: str, values: Sequence[float], comment: str) -> Variable:
    """Return a constant array of a real type."""
    return Variable("VAR CONSTANT", name, real, tuple(constant(x, real) for x in values), len(values), comment)
