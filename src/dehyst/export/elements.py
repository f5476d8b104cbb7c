"""Numbers of a block of a sum of elements as the core's structures hold them, in double or float."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from dehyst.control.block import Block
from dehyst.export.float_rules import check_unit
from dehyst.export.names import c_names
from dehyst.export.numbers import (
    INPUT_LIMIT,
    LIMITS,
    TOLERANCE,
    Constant,
    Map,
    OffsetUnit,
    Tables,
    UnitNumbers,
    in_real,
    inward,
    outward,
    read,
)
from dehyst.export.signal import SAMPLES
from dehyst.families.element_machine import ElementBlockParameters
from dehyst.families.elements import KINDS, LAGS

FAR = {"double": 1e300, "float": 1e38}  # DEHYST_FAR


@dataclass(frozen=True)
class ElementBlockNumbers(UnitNumbers):
    """``dehyst_element_block``: its elements and numbers by the names of `ElementBlockParameters`.

    Attributes
    ----------
    parameters
        In the precision of the unit; values stay doubles.
    given
        C names of the scheduling variables.
    tolerance
        Largest error in float. [output]
    """

    core = "element_block"
    functions = (
        "dehyst_element_block_reset", "dehyst_element_block_step", "dehyst_element_block_save",
        "dehyst_element_block_restore",
    )  # fmt: skip
    tables = "c/element_tables.j2"
    takes_given = True
    kind = "elements"
    parameters: ElementBlockParameters
    given: tuple[str, ...] = ()
    tolerance: float = 0.0
    offset: OffsetUnit | None = None

    @property
    def values(self) -> Mapping[str, float]:
        """Numbers of the block beside its sum."""
        return self.parameters.numbers

    input_low, input_high = read("values", "input_low"), read("values", "input_high")
    output_low, output_high = read("values", "output_low"), read("values", "output_high")
    line_slope, line_offset = read("values", "line_slope"), read("values", "line_offset")
    fade = read("values", "fade")

    @property
    def rising(self) -> Tables:
        """Maps, schedules and ranges."""
        p = self.parameters
        yield from (("breakpoints of an element", points[0]) for points in p.maps)
        yield from (("numbers of a map", side) for points in (p.before, p.after) for side in points)
        yield from (("ends of a schedule", pair) for pair in zip(p.schedule_low, p.schedule_high, strict=True))
        yield from super().rising

    @property
    def fingerprint(self) -> int:
        """Of the model: images of another one are refused."""
        return self.parameters.fingerprint

    @property
    def map_points(self) -> tuple[int, ...]:
        """Breakpoints of the maps before and after the sum."""
        return len(self.parameters.before[0]), len(self.parameters.after[0])

    @property
    def holds_back(self) -> bool:
        """Whether there is a value of the sum at which its input is held back."""
        return not self.parameters.solves and self.values["reach_high"] < INPUT_LIMIT["float"]

    @property
    def elements(self) -> list[dict[str, Any]]:
        """Kind, numbers and place of the map of each element."""
        p, at, rows = self.parameters, 0, []
        for k, kind in enumerate(p.kind):
            points = len(p.maps[k][0])
            rows.append(
                {"kind": f"DEHYST_{KINDS[kind].upper()}", "number": kind, "schedule": p.schedule[k],
                 "radius": p.radius[k], "gain": p.gain[k], "weight": p.weight[k], "points": points, "at": at}
            )  # fmt: skip
            at += points
        return rows

    @property
    def points(self) -> Map:
        """Breakpoints of all maps of elements, one behind the other."""
        u, v = (tuple(x for points in self.parameters.maps for x in points[side]) for side in (0, 1))
        return u, v

    @property
    def memory(self) -> tuple[tuple[str, str, str], ...]:
        """Elements, and what is under way in the dead time."""
        return ("sum.z", "z", "ELEMENTS"), ("delay.ring", "ring", "RING")

    @property
    def sizes(self) -> tuple[tuple[str, str, str], ...]:
        """Elements, ring of the dead time, words of an image."""
        n, delay = self.parts, self.parameters.delay
        return (
            ("ELEMENTS", f"{n}", ""),
            ("RING", f"{max(1, delay)}", "samples of dead time, 1 for none"),
            ("IMAGE_WORDS", f"DEHYST_ELEMENT_WORDS({n}, {delay})", "of a saved state"),
        )

    @property
    def parts(self) -> int:
        """Elements."""
        return len(self.parameters.kind)

    def constants(self, unit: str) -> Iterable[Constant]:
        """Return those of the elements and of the maps."""
        p = self.parameters
        for name, about in (
            ("kind", f"of the elements: {', '.join(f'{k} {kind}' for k, kind in enumerate(KINDS))}"),
            ("schedule", "whose share weighs them: 0 none, odd 1 - xi, even xi"),
            ("radius", "of the elements"),
            ("gain", "at the period"),
            ("weight", "of the elements"),
        ):
            yield Constant(name, about, "", tuple(map(float, getattr(p, name))))
        u, v = self.points
        tables = (("map_from", u), ("map_to", v), ("before_from", p.before[0]), ("before_to", p.before[1]),
                  ("after_from", p.after[0]), ("after_to", p.after[1]), ("start", p.start))  # fmt: skip
        for name, values in tables:
            if values:
                yield Constant(name, f"table {name.replace('_', ': ')}", "", values)
        for name in ("center", "half_range", "level", "amplitude"):
            yield Constant(name, f"{name.replace('_', ' ')} of the scaling", "", (self.values[name],), False)

    def bytes(self, size: int) -> tuple[int, int, int]:
        """Return bytes of constants, state and image on a 32-bit target, by the size of a real."""
        p, n = self.parameters, self.parts
        numbers = 2 * (len(self.points[0]) + sum(self.map_points)) + len(p.start) + len(p.numbers) + 9
        constants = n * {4: 32, 8: 48}[size] + size * numbers + {4: 64, 8: 80}[size]
        state = size * (n + max(1, p.delay) + 5) + {4: 32, 8: 40}[size]
        return constants, state, 4 * (6 + size // 4 * (n + p.delay + 4))


def numbers_of(block: Block, real: str) -> ElementBlockNumbers:
    """Return the numbers of a block in a precision."""
    exact: ElementBlockParameters = block.parameters
    holds = exact.numbers["reach_high"] < INPUT_LIMIT["double"]
    numbers = dict(in_real(exact.numbers, real))
    for what in LIMITS if real == "float" else ():
        within = inward if what == "input" or exact.solves or holds else outward
        ends = within(exact.numbers[f"{what}_low"], exact.numbers[f"{what}_high"], real)
        numbers[f"{what}_low"], numbers[f"{what}_high"] = ends
    if not holds:  # a reach that is none is written as what lies beyond all inputs
        numbers |= {"reach_low": -FAR[real], "reach_high": FAR[real]}
    told = replace(in_real(exact, real), numbers=numbers)
    given = c_names(block.given, ElementBlockNumbers.leading)
    unit = ElementBlockNumbers(told, given, 0.0 if real == "double" else _tolerance(exact, told))
    check_unit(ElementBlockNumbers(exact), unit, block.ramp, real)
    return unit


def _tolerance(exact: ElementBlockParameters, single: ElementBlockParameters) -> float:
    """1e-5 of the range, and what rounding makes of it: of x, of each term, of lags that stop short.

    Where the sum is solved, all of it counts over the least slope that one element of ``input`` gives.
    """
    n = exact.numbers
    ends = [abs((n[f"input_{end}"] - n["center"]) / n["half_range"]) for end in ("low", "high")]
    size = max(abs(exact.low), abs(exact.high), *ends, 1.0) + abs(n["center"] / n["half_range"])
    digit = float(np.spacing(np.float32(size)))
    terms, slopes = abs(exact.offset), 0.0
    stalled, direct = 0.0, 0.0
    for k, kind in enumerate(exact.kind):
        u, v = (np.array(side) for side in exact.maps[k])
        steep = float(np.abs(np.diff(v) / np.diff(u)).max()) if u.size else 1.0
        flat = float((np.diff(v) / np.diff(u)).min()) if u.size else 1.0
        weight = abs(exact.weight[k]) * steep
        terms += abs(exact.weight[k]) * (float(np.abs(v).max()) if v.size else size)
        slopes += weight
        direct += max(0.0, exact.weight[k] * flat) if KINDS[kind] == "input" else 0.0
        lag = KINDS[kind] in LAGS and exact.gain[k] > 0.0
        stalled += weight * 0.5 * digit * min(1.0 / exact.gain[k], SAMPLES) if lag else 0.0
    error = 4.0 * digit * (slopes + terms / size) + stalled
    if exact.solves:
        error /= max(direct, 1e-3)
    error *= abs(n["amplitude"]) * _steepest(exact.before) * _steepest(exact.after)
    return TOLERANCE * (n["output_high"] - n["output_low"]) + error


def _steepest(map: Map) -> float:
    u, v = (np.array(side) for side in map)
    return max(1.0, float(np.abs(np.diff(v) / np.diff(u)).max())) if u.size else 1.0
