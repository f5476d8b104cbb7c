"""The function blocks of models and their inverses: constants, variables, body."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

from dehyst.export import precision
from dehyst.export.numbers import DirectNumbers, ElementNumbers, ModelNumbers, OffsetUnit, UnitNumbers
from dehyst.export.st.pou import Pou, Variable, block_of, constant, names, rendered

INPUT_LIMIT = {"LREAL": precision.INPUT_LIMIT["double"], "REAL": precision.INPUT_LIMIT["float"]}
GROUPS = 8  # DEHYST_GROUPS of core/dehyst.h
HALVINGS = {"LREAL": 54, "REAL": 25}  # DEHYST_HALVINGS of core/dehyst.h
ROUNDING = {"LREAL": 2.2e-16, "REAL": 1.2e-7}  # of core/element_inverse.c


def signal_names(names: tuple[str, ...]) -> tuple[str, ...]:
    """Return the names of further inputs of a unit in a function block.

    Examples
    --------
    >>> signal_names(("signal_0", "load"))
    ('GivenSignal0', 'GivenLoad')
    """
    return tuple("Given" + "".join(word.capitalize() for word in name.split("_")) for name in names)


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
    return block_of(name, variables, body, words["about"])


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


def retained(unit: Pou, real: str) -> Pou:
    """Return the function block of a unit with states that outlive a power cycle.

    Outputs are kept in variables of their own, because STruC++ takes no VAR_OUTPUT RETAIN.
    """
    outputs = {"OutputValue": "KeptOutput", "RejectedEver": "KeptRejected", "LimitedEver": "KeptLimited"}
    before = "".join(f"{output} := {name};\n" for output, name in outputs.items())
    after = "".join(f"{name} := {output};\n" for output, name in outputs.items())
    states = (
        Variable("VAR", "KeptOutput", real, ("0.0",), comment="what the outputs were"),
        *(Variable("VAR", name, "BOOL", ("FALSE",)) for name in ("KeptRejected", "KeptLimited")),
    )
    body = f"(* ---- after a power cycle, outputs of the last call *)\n{before}\n{unit.body.rstrip()}\n\n{after}"
    return replace(unit, variables=tuple(map(kept, (*unit.variables, *states))), body=body)


def kept(variable: Variable) -> Variable:
    """Return a variable such that it keeps its value over a power cycle, if it stands in VAR."""
    return replace(variable, section="VAR RETAIN") if variable.section == "VAR" else variable


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
        number("ModelOffset", real, model.offset, "added to the output"),
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
        number("FadeStep", real, b.fade, "share of a switching that one call makes"),
    )


def model_variables(real: str, n: int) -> tuple[Variable, ...]:
    """Return the states of a model and what its step works with."""
    zeros = tuple(["0.0"] * n)
    reals = names(
        "Beyond NextState Edge HysteresisValue Side Argument Present Portion There Boundary BeginsAt MeetsAt EndsAt "
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


def direct_function_block(name: str, real: str, numbers: UnitNumbers, words: dict[str, str]) -> Pou:
    """Return the function block, as that of plays."""
    d = numbers.direct
    assert d is not None  # it is one
    given = signal_names(numbers.inputs[1 : 2 + len(numbers.given)])
    values = {"Eighth": 0.125, "Sixth": 1.0 / 6.0, "TwentyFourth": 1.0 / 24.0}
    own = (
        *direct_tables(real, d), *limits(real, numbers), *direct_states(real, d, "Held"), *direct_work(real),
        *(Variable("VAR", name, real, ("0.0",)) for name in names("Value Size HalfPart Share")),
        *frame_variables(real), *(number(name, real, value) for name, value in values.items()),
    )  # fmt: skip
    body = rendered("direct_block.st.j2", d=d, given=given[1:])
    return unit_of(name, real, words, body, own, given, numbers.offset)


def direct_tables(real: str, direct: DirectNumbers) -> tuple[Variable, ...]:
    """Return the constants of a direct inverse."""
    tables = (
        ("RadiusTable", direct.radius, "r of the stops [y]"),
        ("LengthTable", direct.length, "x of the lags along the path [y]"),
        ("GainTable", direct.gain, "1 - exp(-T/tau) of the creep lags"),
        ("WeightTable", direct.weight, "a row a set: polynomial, stops, lags along the path, creep lags, rate"),
        ("LowTable", direct.low, "ranges of what the weights depend on"),
        ("HighTable", direct.high, ""),
    )
    groups = tuple(str(group) for group in direct.group)
    return (
        *(table(name, real, values, comment) for name, values, comment in tables if values),
        Variable("VAR CONSTANT", "GroupTable", "DINT", groups, len(groups), "group of each term"),
        number("DirectCenter", real, direct.center, "subtracted in front of the polynomial"),
        number("DirectLow", real, direct.input_low, "beyond, the polynomial is held"),
        number("DirectHigh", real, direct.input_high),
        number("DirectLowest", real, direct.output_low, "no answer lies beyond"),
        number("DirectHighest", real, direct.output_high),
    )


def direct_states(real: str, direct: DirectNumbers, prefix: str) -> tuple[Variable, ...]:
    """Return what it remembers along one signal."""
    sizes = (
        (("Low", "High"), len(direct.radius)),
        (("Path", "PathDoubt"), len(direct.length)),
        (("Lag", "LagDoubt"), len(direct.gain)),
        (("Part", "Doubt"), GROUPS),
    )
    arrays = [(f"{prefix}{name}", size) for pair, size in sizes for name in pair if size]
    return (
        *(Variable("VAR", name, real, ("0.0",) * size, size) for name, size in arrays),
        *(Variable("VAR", f"{prefix}{name}", real, ("0.0",)) for name in names("Last Curve")),
        *(Variable("VAR", f"{prefix}{name}", "BOOL", ("FALSE",)) for name in names("Limited Rejected")),
    )


def direct_work(real: str) -> tuple[Variable, ...]:
    """Return what its step works with."""
    reals = names("DirectInside DirectThere DirectRoom DirectBottom DirectTop DirectPlace DirectWay WeightNow Lasting")
    return (
        *(Variable("VAR", name, real, ("0.0",)) for name in reals),
        *(Variable("VAR", name, "DINT", ("0",)) for name in names("TermNumber GroupNumber SetNumber")),
        Variable("VAR", "Shares", real, ("0.0",) * 6, 6, "of the sets of weights"),
    )


def element_function_block(name: str, real: str, numbers: UnitNumbers, words: dict[str, str]) -> Pou:
    """Return the function block, as that of plays."""
    model, given = numbers.model, signal_names(numbers.given)
    assert isinstance(model, ElementNumbers)  # it is one
    p = model.parameters
    holds = not p.solves and numbers.reach_high < precision.INPUT_LIMIT["float"]
    before, after = numbers.map_points
    halvings, kinds = HALVINGS[real], set(p.kind)
    body = rendered(
        "elements.st.j2", n=numbers.parts, kinds=kinds, dragged=bool(kinds - {0, 6, 8}), plays=bool(kinds & {1, 2, 7}),
        points=bool(model.points[0]), start=bool(p.start),
        sources=p.source, given=given, delay=p.delay, before=before, after=after, solves=p.solves,
        holds=holds, halvings=halvings, rounds=12 + 2 * halvings, last=12 + halvings,
    )  # fmt: skip
    return unit_of(
        name, real, words, body, (*_tables(real, numbers, model, holds), *_work(real, model)), given, numbers.offset
    )


def _tables(real: str, b: UnitNumbers, model: ElementNumbers, holds: bool) -> tuple[Variable, ...]:
    p, rows, (u, v) = model.parameters, model.elements, model.points
    values = p.numbers
    whole = (
        ("KindTable", "number", "0 input, 1 play, 2 stop, 3 creep, 4 relax, 5 past, 6 path, 7 wide"),
        ("ScheduleTable", "schedule", "share that weighs it"),
        ("PointsTable", "points", "of its map; 0 for none"),
        ("PlaceTable", "at", "of its map among all points"),
    )
    tables = (
        ("RadiusTable", p.radius, "r of the elements"), ("GainTable", p.gain, "for the period"),
        ("WeightTable", p.weight, ""), ("MapU", u, "maps: arguments"), ("MapV", v, "maps: values"),
        ("BeforeU", p.before[0], "map before the sum: arguments"), ("BeforeV", p.before[1], "its values"),
        ("AfterU", p.after[0], "map behind the sum: arguments"), ("AfterV", p.after[1], "its values"),
        ("StartTable", p.start, "memory from where one stroke leads to the first sample"),
        ("LowTable", p.schedule_low, "ranges of the schedules"), ("HighTable", p.schedule_high, ""),
    )  # fmt: skip
    single = (
        ("SumOffset", p.offset, ""), ("SumLow", p.low, "of all positions"), ("SumHigh", p.high, ""),
        ("Origin", values["origin"], "where the stroke begins"), ("InputCenter", values["center"], "of the scaling"),
        ("InputUnit", values["half_range"], ""), ("Level", values["level"], ""),
        ("Amplitude", values["amplitude"], ""), ("InputLow", b.input_low, "inputs beyond are taken as the limit"),
        ("InputHigh", b.input_high, ""), ("OutputLow", b.output_low, "no output lies beyond"),
        ("OutputHigh", b.output_high, ""), ("LineSlope", b.line_slope, "answer while off"),
        ("LineOffset", b.line_offset, ""), ("FadeStep", b.fade, "share of a switching that one call makes"),
        ("Rounding", ROUNDING[real], "of a number"), ("Two", 2.0, ""), ("SixtyFour", 64.0, ""),
        ("Eighth", 0.125, ""), ("Sixth", 1.0 / 6.0, ""), ("TwentyFourth", 1.0 / 24.0, ""),
    )  # fmt: skip
    reach = (("ReachLow", b.reach_low), ("ReachHigh", b.reach_high)) if holds else ()
    return (
        *(_whole(name, [row[key] for row in rows], comment) for name, key, comment in whole),
        *(table(name, real, numbers, comment) for name, numbers, comment in tables if numbers),
        *(number(name, real, value, comment) for name, value, comment in single),
        *(number(name, real, value, "of the sum: there the input is held back") for name, value in reach),
    )


def _whole(name: str, values: list[int], comment: str) -> Variable:
    return Variable("VAR CONSTANT", name, "DINT", tuple(map(str, values)), len(values), comment)


def _work(real: str, model: ElementNumbers) -> tuple[Variable, ...]:
    p = model.parameters
    arrays = (
        ("States", len(p.kind), "memory of the elements"), ("Ring", p.delay, "inputs that are under way"),
        ("Shares", 2 * len(p.source) + 1, "of the schedules"),
    )  # fmt: skip
    reals = names(
        "LastPosition LastStep OnShare Taken Target OffLine Scaled Late Wanted Position Answer Result Way Held Reading "
        "Memory Slope Reach LowSlope HighSlope Growth Distance EdgeBelow EdgeAbove Parts Lasting Share FirstPart "
        "LastPart Behind Before Steepness Total Steep Scheduled Near BoundLow BoundHigh Bound StepLength Miss Room "
        "Newton NewtonLength NextPosition Portion WeightNow"
    )
    counts = names("K Kind LeftEnd RightEnd Center Pieces Close Rounds RingPlace")
    truths = names("Running Started Good Rising Up Known KnownLow KnownHigh Outside Halves Follows Ahead AtLow AtHigh")
    return (
        *(Variable("VAR", name, real, ("0.0",) * size, size, comment) for name, size, comment in arrays if size),
        *(Variable("VAR", name, real, ("0.0",)) for name in reals),
        *(Variable("VAR", name, "DINT", ("0",)) for name in counts),
        *(Variable("VAR", name, "BOOL", ("FALSE",))
          for name in truths),
    )  # fmt: skip
