"""Elements in parallel: what the families have in common whose output is a weighted sum of plays, stops and creep.

A family names its elements, their weights and thresholds; here they are simulated, inverted and regressed, by the
kernel of engine/elements.h.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from dehyst import _native
from dehyst.errors import ParameterError
from dehyst.families.base import LoopModel
from dehyst.families.inversion import FARTHEST
from dehyst.models.arrays import Array, parameter_array, parameter_number, strictly_increasing

PLAY, STOP, PIECE = _native.ELEMENT_PLAY, _native.ELEMENT_STOP, _native.ELEMENT_PIECE
DAMPER, CREEP, RATE = _native.ELEMENT_DAMPER, _native.ELEMENT_CREEP, _native.ELEMENT_RATE

Kinds = npt.NDArray[np.int32]
AHEAD = 2  # numbers of the memory in front of the states: the input of the sample before, its rate


@dataclass(frozen=True, eq=False)
class Elements:
    """n elements in parallel: u = slope x + sum of weight e.

    Attributes
    ----------
    kind
        PLAY, STOP, PIECE, DAMPER, CREEP or RATE of each, (n,).
    weight, radius
        (n,); the radius is a threshold, half the width of a piece, or the largest rate of a damper.
    extra
        (n,): growth of a threshold with the rate, place of a piece, time constant of a creep.
    slope
        Of the input itself.
    lag
        Time constant of the low-pass of the rate. [s]
    """

    kind: Kinds
    weight: Array
    radius: Array
    extra: Array
    slope: float = 0.0
    lag: float = 1.0

    @property
    def size(self) -> int:
        """Number of elements."""
        return int(self.kind.size)

    def rest(self, x: float) -> Array:
        """Memory (2 + n,) of elements that never moved from x."""
        states = np.where(np.isin(self.kind, (PLAY, STOP, CREEP)), x, 0.0)
        return np.concatenate([[x, 0.0], states])

    def run(self, x: Array, dt: Array | None, memory: Array) -> tuple[Array, Array]:
        """Sums (T,) and the memory after them."""
        return _native.elements_run(
            self.kind, self.weight, self.radius, self.extra, self.slope, self.lag, x, dt, memory
        )  # fmt: skip

    def bank(self, x: Array, dt: Array | None, memory: Array) -> Array:
        """Output of each element, (T, n)."""
        return _native.elements_bank(self.kind, self.radius, self.extra, self.lag, x, dt, memory)

    def invert(self, u: Array, dt: Array | None, memory: Array) -> tuple[Array, Array]:
        """Inputs (T,) for sums, and the memory after them."""
        return _native.elements_invert(
            self.kind, self.weight, self.radius, self.extra, self.slope, self.lag, u, dt, FARTHEST, memory
        )  # fmt: skip

    def weighted(self, weight: Array) -> Elements:
        """The same elements with other weights."""
        return replace(self, weight=np.ascontiguousarray(weight, dtype=np.float64))


def elements(*groups: tuple[int, npt.ArrayLike, npt.ArrayLike, npt.ArrayLike], **others: float) -> Elements:
    """Put groups (kind, weights, radii, extras) together; a single number stands for a whole group."""
    columns: list[list[Array]] = [[], [], []]
    kinds: list[Kinds] = []
    for kind, *numbers in groups:
        arrays = np.broadcast_arrays(*(np.atleast_1d(np.asarray(values, dtype=np.float64)) for values in numbers))
        kinds.append(np.full(arrays[0].size, kind, dtype=np.int32))
        for column, array in zip(columns, arrays, strict=True):
            column.append(array)
    weight, radius, extra = (np.ascontiguousarray(np.concatenate(column)) for column in columns)
    return Elements(np.concatenate(kinds), weight, radius, extra, **others)


class ParallelModel(LoopModel):
    """A family whose output is y = offset + sum of weight e, with elements in parallel."""

    offset: float

    @abstractmethod
    def make(self) -> Elements:
        """Return the elements."""

    @cached_property
    def parts(self) -> Elements:
        """The elements, made once."""
        return self.make()

    def seen(self, x: Array) -> Array:
        """What the elements see of an input: itself."""
        return x

    def rest(self, x: float) -> Array:
        """Every state at the input."""
        return self.parts.rest(float(self.seen(np.array([x]))[0]))

    def run(self, x: Array, dt: Array | None, memory: Array) -> tuple[Array, Array]:
        """Sum of the elements."""
        u, after = self.parts.run(self.seen(x), dt, memory)
        return self.offset + u, after

    def run_inverse(self, y: Array, dt: Array | None, memory: Array) -> tuple[Array, Array]:
        """One piecewise linear equation a sample."""
        return self.parts.invert(y - self.offset, dt, memory)


class MappedModel(ParallelModel):
    """A family whose output is y = T^-1(offset + sum of weight e): elements in parallel, and a monotone map behind.

    `map_inner` (p,) are sums and `map_outer` (p,) scaled outputs at the breakpoints of T^-1, both increasing; where
    they are empty the output is the sum.
    """

    map_inner: Array
    map_outer: Array

    def run(self, x: Array, dt: Array | None, memory: Array) -> tuple[Array, Array]:
        """Sum of the elements, then the map."""
        u, after = super().run(x, dt, memory)
        return self.mapped(u), after

    def run_inverse(self, y: Array, dt: Array | None, memory: Array) -> tuple[Array, Array]:
        """The map backwards, then one piecewise linear equation a sample."""
        return super().run_inverse(self.unmapped(y), dt, memory)

    def mapped(self, u: Array) -> Array:
        """Outputs for sums."""
        return _native.map_values(self.map_inner, self.map_outer, u) if self.map_inner.size else u

    def unmapped(self, y: Array) -> Array:
        """Sums for outputs."""
        return _native.map_values(self.map_outer, self.map_inner, y) if self.map_inner.size else y

    def _check_map(self) -> int:
        """Normalise offset and map; return the number of parameters they hold."""
        put = object.__setattr__
        put(self, "offset", parameter_number(self.offset, "offset"))
        for name in ("map_inner", "map_outer"):
            put(self, name, optional_array(getattr(self, name), name))
        if self.map_inner.size != self.map_outer.size or self.map_inner.size == 1:
            raise ParameterError(
                f"the map has {self.map_inner.size} sums and {self.map_outer.size} outputs; pass pairs, two or more."
            )
        for name in ("map_inner", "map_outer"):
            strictly_increasing(getattr(self, name), name)
        return 1 + max(0, self.map_inner.size - 3)  # the ends go on as beside them; its scale is that of the weights


def optional_array(values: npt.ArrayLike, name: str) -> Array:
    """Return finite values (n,), n may be 0."""
    if values.size if isinstance(values, np.ndarray) else values not in ([], ()):
        return parameter_array(values, name)
    empty = np.zeros(0)
    empty.flags.writeable = False
    return empty


def same_size(first: Array, second: Array, names: Sequence[str]) -> None:
    """Raise ParameterError unless two arrays have the same length."""
    if first.size != second.size:
        raise ParameterError(f"{names[0]} has {first.size} values but {names[1]} has {second.size}; pass as many.")


def not_negative(values: Array, name: str) -> None:
    """Raise ParameterError at the first negative value."""
    bad = np.flatnonzero(values < 0.0)
    if bad.size:
        raise ParameterError(
            f"{name}[{bad[0]}] = {values[bad[0]]:g} is negative; pass values from 0 on.", index=int(bad[0])
        )
