"""The function block of a direct inverse: constants, variables, body."""

from __future__ import annotations

from dehyst.export.numbers import DirectNumbers, UnitNumbers
from dehyst.export.plc.block import frame_variables, limits, number, table, unit_of
from dehyst.export.plc.ports import signal_names
from dehyst.export.plc.pou import Pou, Variable
from dehyst.export.plc.template import names, rendered

GROUPS = 8  # DEHYST_GROUPS of core/dehyst.h


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
