"""Variables of an FMU: the same list becomes the model description and the table in C."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Literal

Kind = Literal["real", "whole", "truth"]
Role = Literal["time", "input", "output", "constant"]


@dataclass(frozen=True)
class Variable:
    """One variable of an FMU.

    Attributes
    ----------
    name
        As importers show it.
    kind
        Real number, whole number or truth value.
    role
        Time, input, output or constant.
    description
        One line.
    unit
        Of real ones, "" for none.
    start
        Values at the start, one of a scalar; none of time.
    low, high
        Range, where there is one. [unit]
    array
        Whether it is an array, even of one value.
    place
        Of its first value among the signals of its kind, or among all constants.

    Examples
    --------
    >>> Variable("angle", "real", "input", "measured angle", "rad", (0.0,)).length
    1
    """

    name: str
    kind: Kind
    role: Role
    description: str
    unit: str = ""
    start: tuple[float, ...] = ()
    low: float | None = None
    high: float | None = None
    array: bool = False
    place: int = 0

    @property
    def length(self) -> int:
        """Number of values."""
        return max(len(self.start), 1)

    @property
    def nominal(self) -> float | None:
        """Size that is usual: half of the range, or None without a range or without any width."""
        if self.low is None or self.high is None or not self.high > self.low:
            return None
        return max(abs(self.low), abs(self.high))


TIME = Variable("time", "real", "time", "end of the last step", "s")


def placed(variables: Iterable[Variable], *, arrays: bool) -> tuple[Variable, ...]:
    """Give each variable its place, time first; without arrays, every element becomes a variable of its own.

    The place of a variable in the result is its value reference.

    Examples
    --------
    >>> r = Variable("r", "real", "constant", "thresholds", "V", (0.0, 1.0), array=True)
    >>> [v.name for v in placed([r], arrays=False)], placed([r], arrays=True)[1].length
    (['time', 'r[1]', 'r[2]'], 2)
    """
    next_place = {"real": 0, "whole": 0, "truth": 0, "constant": 0}
    out = []
    for variable in (TIME, *(variables if arrays else scalars(variables))):
        counter = "constant" if variable.role == "constant" else variable.kind
        out.append(replace(variable, place=0 if variable.role == "time" else next_place[counter]))
        next_place[counter] += variable.length if variable.role != "time" else 0
    return tuple(out)


def scalars(variables: Iterable[Variable]) -> Iterator[Variable]:
    """Split arrays into their elements, ``name[1]`` and so on."""
    for variable in variables:
        if not variable.array:
            yield variable
            continue
        for index, value in enumerate(variable.start, 1):
            yield replace(variable, name=f"{variable.name}[{index}]", start=(value,), array=False)


def count(variables: Sequence[Variable], kind: Kind) -> int:
    """Number of signals of a kind, constants and time not counted."""
    return sum(v.length for v in variables if v.kind == kind and v.role in ("input", "output"))


def constants(variables: Sequence[Variable]) -> list[float]:
    """Values of all constants in the order of their places."""
    return [float(value) for v in variables if v.role == "constant" for value in v.start]
