"""What can be streamed: anything that gives time, input and output in chunks, as often as it is asked."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Protocol, runtime_checkable

from dehyst.arrays import Array

Chunk = tuple[Array | None, Array, Array]


@runtime_checkable
class Source(Protocol):
    """A log that is read in chunks, again and again.

    Iteration starts at the first sample each time and gives ``(time, x, y)``, float64, (K,) each; time [s] is None for
    a log without one. `dehyst.open_chunks` makes one from a file. Further attributes are used where they are there:
    ``name``, ``input_name``, ``output_name``, ``input_unit``, ``output_unit``, ``findings``, ``provenance``; ``size``
    and ``consumed``, the bytes of a pass and those read of it so far; ``costly``, whether another pass takes much
    longer than reading numbers would.
    """

    def __iter__(self) -> Iterator[Chunk]:
        """Chunks from the first sample on."""
        ...
