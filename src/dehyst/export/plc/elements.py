"""The function block of a sum of elements or its inverse: constants, variables, body."""

from __future__ import annotations

from dehyst.export.numbers import ElementNumbers, UnitNumbers
from dehyst.export.plc.block import number, table, unit_of
from dehyst.export.plc.ports import signal_names
from dehyst.export.plc.pou import Pou, Variable
from dehyst.export.plc.template import names, rendered
from dehyst.export.precision import INPUT_LIMIT

HALVINGS = {"LREAL": 54, "REAL": 25}  # DEHYST_HALVINGS of core/dehyst.h
ROUNDING = {"LREAL": 2.2e-16, "REAL": 1.2e-7}  # of core/element_inverse.c


def element_function_block(name: str, real: str, numbers: UnitNumbers, words: dict[str, str]) -> Pou:
    """Return the function block, as that of plays."""
    model, given = numbers.model, signal_names(numbers.given)
    assert isinstance(model, ElementNumbers)  # it is one
    p = model.parameters
    holds = not p.solves and numbers.reach_high < INPUT_LIMIT["float"]
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
        ("LineOffset", b.line_offset, ""), ("Fade", b.fade, "share of a switching that one call makes"),
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
