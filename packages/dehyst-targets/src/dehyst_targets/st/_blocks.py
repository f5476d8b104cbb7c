"""The function blocks of models and their inverses: constants, variables, body."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import replace

from dehyst.export import (
    DirectNumbers,
    ElementNumbers,
    ModelNumbers,
    OffsetUnit,
    UnitNumbers,
    precision,
)
from dehyst_targets.st._pou import Pou, PouVariable, block_of, constant, rendered

INPUT_LIMIT = {"LREAL": precision.INPUT_LIMIT["double"], "REAL": precision.INPUT_LIMIT["float"]}
GROUPS = 8  # DEHYST_GROUPS of packages/dehyst/core/dehyst.h
HALVINGS = {"LREAL": 54, "REAL": 25}  # DEHYST_HALVINGS of packages/dehyst/core/dehyst.h
ROUNDING = {"LREAL": 2.2e-16, "REAL": 1.2e-7}  # DEHYST_ROUNDING of packages/dehyst/core/dehyst.h


def signal_names(names: tuple[str, ...]) -> tuple[str, ...]:
    """Return the names of further inputs of a unit in a function block.

    Examples
    --------
    >>> signal_names(("signal_0", "load"))
    ('GivenSignal0', 'GivenLoad')
    """
    # The prefix keeps them apart from variables of the block and from words of the language.
    block_names = []
    for name in names:
        words = map(str.capitalize, name.split("_"))
        block_names.append("Given" + "".join(words))
    return tuple(block_names)


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
    reach = st_number("ReachLow", real, numbers.reach_low, "the same in front of the last map")
    variables = (
        *model_tables(real, model),
        *limits(real, numbers, (reach, st_number("ReachHigh", real, numbers.reach_high))),
        *model_variables(real, model.parts),
        *frame_variables(real),
    )
    return st_unit(
        name, real, words, rendered("block.st.j2", **shape(model)), variables, (), numbers.offset
    )


def st_unit(
    name: str, real: str, words: dict[str, str], body: str, inner: tuple[PouVariable, ...], more: Sequence[str] = (),
    offset: OffsetUnit | None = None,
) -> Pou:  # fmt: skip
    """Return the function block of a unit from its body and its inner variables; `more` are further inputs."""
    if offset is not None:
        # The offset stands around the model: the model then works on variables between the two.
        between = {"InputValue": "AskedValue", "OutputValue": "SaidValue"}
        model_body = re.sub("|".join(between), lambda match: between[match[0]], body)
        body = rendered("offset.st.j2", body=model_body, forward=offset.forward)
        inner = (*inner, *_of_offset(real, offset))
        more = (*more, "GivenMeasured")
    variables = (*st_interface(real, words, more), *inner, *common_constants(real))
    return block_of(name, variables, body, words["about"])


def _of_offset(real: str, offset: OffsetUnit) -> tuple[PouVariable, ...]:
    """Return constants and variables of an offset that follows the last cycle."""
    limit = INPUT_LIMIT[real]
    constants = (
        ("OffsetLow", -offset.limit, "of the offset"), ("OffsetHigh", offset.limit, ""),
        ("OffsetTurn", offset.turn, "way back that makes a turning point"),
        ("OffsetPart", offset.part, "offset that comes in along a way of one"), ("MeanLow", -limit, ""),
        ("MeanHigh", limit, ""), ("ManySamples", 1e9, "of a stroke"), ("SevenTimes", 7.0, ""),
    )  # fmt: skip
    return (
        *st_numbers(real, constants),
        *zeros(
            real,
            "OffsetNow OffsetNext OffsetTarget LastInput FarthestInput MeanNow MeanBefore GoodNow GoodBefore BadNow "
            "WayMade AskedValue SaidValue",
        ),
        PouVariable(
            "VAR",
            "CyclePhase",
            "DINT",
            ("0",),
            comment="0 nothing seen, 1 never turned, 2 falling, 3 rising",
        ),
        *zeros("BOOL", "StrokeEnds StrokeWhole"),
    )


def retained(unit: Pou, real: str) -> Pou:
    """Return the function block of a unit with states that outlive a power cycle.

    Outputs are kept in variables of their own, because STruC++ takes no VAR_OUTPUT RETAIN.
    """
    outputs = {
        "OutputValue": "KeptOutput",
        "RejectedEver": "KeptRejected",
        "LimitedEver": "KeptLimited",
    }
    restored, saved = "", ""
    for output, name in outputs.items():
        restored += f"{output} := {name};\n"
        saved += f"{name} := {output};\n"
    states = (
        PouVariable("VAR", "KeptOutput", real, ("0.0",), comment="what the outputs were"),
        *zeros("BOOL", "KeptRejected KeptLimited"),
    )
    body = (
        "(* ---- after a power cycle, outputs of the last call *)\n"
        f"{restored}\n{unit.body.rstrip()}\n\n{saved}"
    )
    return replace(unit, variables=tuple(map(_retained, (*unit.variables, *states))), body=body)


def _retained(variable: PouVariable) -> PouVariable:
    """Return a variable that keeps its value over a power cycle, if it is a state and no constant."""
    if variable.section == "VAR":
        return replace(variable, section="VAR RETAIN")
    return variable


def st_interface(
    real: str, words: dict[str, str], more: Sequence[str] = ()
) -> tuple[PouVariable, ...]:
    """Return inputs and outputs of the function block of a unit; `more` are names of further inputs."""
    further_inputs = []
    for name in more:
        further_inputs.append(PouVariable("VAR_INPUT", name, real, comment=words.get(name, "")))
    # `Ports.of` reads this order: numbers are the columns of a signal, truth values the bits of its switch.
    return (
        PouVariable("VAR_INPUT", "InputValue", real, comment=words["input"]),
        *further_inputs,
        PouVariable(
            "VAR_INPUT",
            "Enable",
            "BOOL",
            comment="TRUE: on; may change at any time, the output fades",
        ),
        PouVariable(
            "VAR_INPUT", "Restart", "BOOL", comment="TRUE: start states again, then this sample"
        ),
        PouVariable("VAR_OUTPUT", "OutputValue", real, comment=words["output"]),
        PouVariable(
            "VAR_OUTPUT",
            "Rejected",
            "BOOL",
            comment="this sample was no number: the last output is held",
        ),
        PouVariable(
            "VAR_OUTPUT", "RejectedEver", "BOOL", comment="some sample since the restart was"
        ),
        PouVariable(
            "VAR_OUTPUT",
            "Limited",
            "BOOL",
            comment="this sample met the limit of the input or of the output",
        ),
        PouVariable(
            "VAR_OUTPUT", "LimitedEver", "BOOL", comment="some sample since the restart did"
        ),
        PouVariable(
            "VAR_OUTPUT",
            "FlagWord",
            "UDINT",
            comment="1 rejected, 2 ever, 4 limited, 8 ever, added",
        ),
    )


def model_tables(real: str, model: ModelNumbers) -> tuple[PouVariable, ...]:
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
        *st_tables(real, tables),
        st_number("InputCenter", real, model.center, "subtracted from the input"),
        st_number("ModelOffset", real, model.offset, "added to the output"),
    )


def limits(real: str, b: UnitNumbers, inner: Sequence[PouVariable] = ()) -> tuple[PouVariable, ...]:
    """Return limits, straight line and fading of a unit; `inner` are limits in front of its last map."""
    return (
        st_number("InputLow", real, b.input_low, "inputs beyond are taken as the limit"),
        st_number("InputHigh", real, b.input_high),
        st_number("OutputLow", real, b.output_low, "no output lies beyond"),
        st_number("OutputHigh", real, b.output_high),
        *inner,
        st_number(
            "LineSlope", real, b.line_slope, "answer while off: LineOffset + LineSlope * InputValue"
        ),
        st_number("LineOffset", real, b.line_offset),
        st_number("FadeStep", real, b.fade, "share of a switching that one call makes"),
    )


def model_variables(real: str, n: int) -> tuple[PouVariable, ...]:
    """Return the states of a model and what its step works with."""
    return (
        zero_array("States", real, n, "play states: all that the block remembers of its past"),
        *zeros(
            real,
            "Beyond NextState Edge HysteresisValue Side Argument Present Portion There Boundary BeginsAt MeetsAt "
            "EndsAt ModelOutput",
        ),
        *zeros("DINT", "Index Operator Dragged LeftEnd RightEnd Center"),
        *zeros("BOOL", "Moved HeldBack Above Follows"),
    )


def frame_variables(real: str) -> tuple[PouVariable, ...]:
    """Return what every unit has beside its model."""
    return (
        PouVariable("VAR", "Running", "BOOL", ("FALSE",), comment="FALSE until the first call"),
        PouVariable(
            "VAR",
            "Started",
            "BOOL",
            ("FALSE",),
            comment="FALSE until the first good sample after a restart",
        ),
        PouVariable("VAR", "OnShare", real, ("0.0",), comment="0 off .. 1 on"),
        PouVariable("VAR", "Good", "BOOL", ("FALSE",)),
        *zeros(real, "Taken Target OffLine"),
    )


def common_constants(real: str) -> tuple[PouVariable, ...]:
    """Return constants of the arithmetic; inside expressions tools disagree about the type of a literal."""
    return (
        st_number(
            "InputLimit",
            real,
            INPUT_LIMIT[real],
            "samples beyond are rejected, and so is what is no number",
        ),
        st_number("Zero", real, 0.0),
        st_number("Half", real, 0.5),
        st_number("One", real, 1.0),
    )


def st_number(name: str, real: str, value: float, comment: str = "") -> PouVariable:
    """Return a constant of a real type."""
    return PouVariable("VAR CONSTANT", name, real, (constant(value, real),), comment=comment)


def st_numbers(real: str, rows: Iterable[tuple[str, float, str]]) -> list[PouVariable]:
    """Return constants of a real type from rows of name, value and comment."""
    numbers = []
    for name, value, comment in rows:
        numbers.append(st_number(name, real, value, comment))
    return numbers


def st_table(name: str, type_: str, texts: Iterable[str], comment: str = "") -> PouVariable:
    """Return a constant array from the texts of its elements."""
    initial = tuple(texts)
    return PouVariable("VAR CONSTANT", name, type_, initial, len(initial), comment)


def st_tables(real: str, rows: Iterable[tuple[str, Sequence[float], str]]) -> list[PouVariable]:
    """Return constant arrays of a real type from rows of name, values and comment."""
    tables = []
    for name, values, comment in rows:
        tables.append(st_table(name, real, constant_texts(values, real), comment))
    return tables


def constant_texts(values: Iterable[float], real: str) -> list[str]:
    """Return numbers as constants of a real type."""
    return [constant(value, real) for value in values]


_ZERO = {"BOOL": "FALSE", "DINT": "0", "REAL": "0.0", "LREAL": "0.0"}


def zeros(type_: str, names: str) -> list[PouVariable]:
    """Return variables that begin at zero or FALSE, one for each word of `names`."""
    return [PouVariable("VAR", name, type_, (_ZERO[type_],)) for name in names.split()]


def zero_array(name: str, real: str, size: int, comment: str = "") -> PouVariable:
    """Return an array of a real type that begins at zero."""
    return PouVariable("VAR", name, real, ("0.0",) * size, size, comment)


def direct_function_block(name: str, real: str, numbers: UnitNumbers, words: dict[str, str]) -> Pou:
    """Return the function block, as that of plays."""
    d = numbers.direct
    assert d is not None  # it is one
    more = signal_names(numbers.inputs[1 : 2 + len(numbers.given)])
    variables = (
        *direct_tables(real, d),
        *limits(real, numbers),
        *direct_states(real, d, "Held"),
        *direct_work(real),
        *zeros(real, "Value Size HalfPart Share"),
        *frame_variables(real),
        *st_numbers(real, _FRACTIONS),
    )
    # The first of the further inputs is the rate, which schedules nothing.
    body = rendered("direct_block.st.j2", d=d, given=more[1:])
    return st_unit(name, real, words, body, variables, more, numbers.offset)


# They have names because tools disagree about the type of a literal inside an expression.
_FRACTIONS = (("Eighth", 0.125, ""), ("Sixth", 1.0 / 6.0, ""), ("TwentyFourth", 1.0 / 24.0, ""))


def direct_tables(real: str, direct: DirectNumbers) -> tuple[PouVariable, ...]:
    """Return the constants of a direct inverse."""
    tables = (
        ("RadiusTable", direct.radius, "r of the stops [y]"),
        ("LengthTable", direct.length, "x of the lags along the path [y]"),
        ("GainTable", direct.gain, "1 - exp(-T/tau) of the creep lags"),
        (
            "WeightTable",
            direct.weight,
            "a row a set: polynomial, stops, lags along the path, creep lags, rate",
        ),
        ("LowTable", direct.low, "ranges of what the weights depend on"),
        ("HighTable", direct.high, ""),
    )
    return (
        *st_tables(real, filter(_has_values, tables)),
        st_table("GroupTable", "DINT", map(str, direct.group), "group of each term"),
        st_number("DirectCenter", real, direct.center, "subtracted in front of the polynomial"),
        st_number("DirectLow", real, direct.input_low, "beyond, the polynomial is held"),
        st_number("DirectHigh", real, direct.input_high),
        st_number("DirectLowest", real, direct.output_low, "no answer lies beyond"),
        st_number("DirectHighest", real, direct.output_high),
    )


def _has_values(row: tuple[str, Sequence[float], str]) -> bool:
    """Return whether a table has elements: Structured Text has no array without."""
    return len(row[1]) > 0


def direct_states(real: str, direct: DirectNumbers, prefix: str) -> tuple[PouVariable, ...]:
    """Return what it remembers along one signal."""
    sizes = (
        (("Low", "High"), len(direct.radius)),
        (("Path", "PathDoubt"), len(direct.length)),
        (("Lag", "LagDoubt"), len(direct.gain)),
        (("Part", "Doubt"), GROUPS),
    )
    states = []
    for names, size in sizes:
        for name in names:
            # Structured Text has no array without elements.
            if size:
                states.append(zero_array(f"{prefix}{name}", real, size))
    return (
        *states,
        *zeros(real, f"{prefix}Last {prefix}Curve"),
        *zeros("BOOL", f"{prefix}Limited {prefix}Rejected"),
    )


def direct_work(real: str) -> tuple[PouVariable, ...]:
    """Return what its step works with."""
    return (
        *zeros(
            real,
            "DirectInside DirectThere DirectRoom DirectBottom DirectTop DirectPlace DirectWay WeightNow Lasting",
        ),
        *zeros("DINT", "TermNumber GroupNumber SetNumber"),
        zero_array("Shares", real, 6, "of the sets of weights"),
    )


def element_function_block(
    name: str, real: str, numbers: UnitNumbers, words: dict[str, str]
) -> Pou:
    """Return the function block, as that of plays."""
    model = numbers.model
    assert isinstance(model, ElementNumbers)  # it is one
    more = signal_names(numbers.given)
    p = model.parameters
    # A reach of 1e15 stands for no limit, and without one nothing is held back.
    holds = not p.solves and numbers.reach_high < precision.INPUT_LIMIT["float"]
    before, after = numbers.map_points
    halvings, kinds = HALVINGS[real], set(p.kind)
    body = rendered(
        "elements.st.j2", n=numbers.parts, kinds=kinds, dragged=bool(kinds - {0, 6, 8}), plays=bool(kinds & {1, 2, 7}),
        points=bool(model.points[0]), start=bool(p.start),
        sources=p.source, given=more, delay=p.delay, shapes=_shapes(model), before=before, after=after, solves=p.solves,
        holds=holds, halvings=halvings, rounds=12 + 2 * halvings, last=12 + halvings,
    )  # fmt: skip
    return st_unit(
        name,
        real,
        words,
        body,
        (*_tables(real, numbers, model, holds), *_work(real, model)),
        more,
        numbers.offset,
    )


def _shapes(model: ElementNumbers) -> bool:
    """Whether the delayed input is a part of what the sum is given, and not all of it."""
    return bool(model.parameters.numbers["echo"] < 1.0)


def _tables(
    real: str, b: UnitNumbers, model: ElementNumbers, holds: bool
) -> tuple[PouVariable, ...]:
    p, values = model.parameters, model.parameters.numbers
    u, v = model.points
    whole_rows = (
        (
            "KindTable",
            "number",
            "0 input, 1 play, 2 stop, 3 creep, 4 relax, 5 past, 6 path, 7 wide",
        ),
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
    number_rows = [
        ("SumOffset", p.offset, ""), ("SumLow", p.low, "of all positions"), ("SumHigh", p.high, ""),
        ("Origin", values["origin"], "where the stroke begins"), ("InputCenter", values["center"], "of the scaling"),
        ("InputUnit", values["half_range"], ""), ("Level", values["level"], ""),
        ("Amplitude", values["amplitude"], ""), ("InputLow", b.input_low, "inputs beyond are taken as the limit"),
        ("InputHigh", b.input_high, ""), ("OutputLow", b.output_low, "no output lies beyond"),
        ("OutputHigh", b.output_high, ""), ("LineSlope", b.line_slope, "answer while off"),
        ("LineOffset", b.line_offset, ""), ("FadeStep", b.fade, "share of a switching that one call makes"),
        ("Rounding", ROUNDING[real], "of a number"), ("Two", 2.0, ""), ("SixtyFour", 64.0, ""),
        *_FRACTIONS,
    ]  # fmt: skip
    if _shapes(model):
        number_rows.append(("Echo", values["echo"], "share of the delayed reference"))
    # Only a sum that is not solved can hold its input back.
    if holds:
        reach_comment = "of the sum: there the input is held back"
        number_rows.append(("ReachLow", b.reach_low, reach_comment))
        number_rows.append(("ReachHigh", b.reach_high, reach_comment))
    whole_tables = []
    for name, key, comment in whole_rows:
        texts = [str(element[key]) for element in model.elements]
        whole_tables.append(st_table(name, "DINT", texts, comment))
    return (
        *whole_tables,
        *st_tables(real, filter(_has_values, tables)),
        *st_numbers(real, number_rows),
    )


def _work(real: str, model: ElementNumbers) -> tuple[PouVariable, ...]:
    p = model.parameters
    rows = (
        ("States", len(p.kind), "memory of the elements"),
        ("Ring", p.delay, "inputs that are under way"),
        ("Shares", 2 * len(p.source) + 1, "of the schedules"),
    )
    arrays = []
    for name, size, comment in rows:
        if size:
            arrays.append(zero_array(name, real, size, comment))
    return (
        *arrays,
        *zeros(
            real,
            "LastPosition LastStep OnShare Taken Target OffLine Scaled Late Wanted Position Answer Result Way Held "
            "Reading Memory Slope Reach LowSlope HighSlope Growth Distance EdgeBelow EdgeAbove Parts Lasting Share "
            "FirstPart LastPart Behind Before Steepness Total Steep Scheduled Near BoundLow BoundHigh Bound StepLength "
            "Miss MissLow MissHigh Room Newton NewtonLength NextPosition Portion WeightNow",
        ),
        *zeros("DINT", "K Kind LeftEnd RightEnd Center Pieces Close Rounds RingPlace"),
        *zeros(
            "BOOL",
            "Running Started Good Rising Up Known KnownLow KnownHigh Outside Halves Follows Ahead AtLow AtHigh Open "
            "MovedLow MovedHigh",
        ),
    )
