"""What is going on during a long identification."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

# Stages of a streamed identification, in order. The first one reads the log; each of the others goes through the
# samples again, through those that are fitted or through all.
STAGES = ("reading", "looking", "choosing", "summing", "refining", "comparing", "scoring")


@dataclass(frozen=True, slots=True)
class Progress:
    """How far an identification has come.

    Attributes
    ----------
    stage
        What is being done, one of "reading", "looking" (turning points), "choosing" (family and start), "summing"
        (normal equations), "refining", "comparing" (the curve without hysteresis), "scoring".
    number, of
        Which stage it is, from 1 on, and how many there are.
    done, total
        Bytes of the log in this stage, or samples where the log does not tell bytes; total is 0 where it is unknown.

    Examples
    --------
    >>> now = Progress("summing", 4, 7, 5e8, 1e9)
    >>> f"{now.stage}, step {now.number} of {now.of}: {now.done / now.total:.0%}"
    'summing, step 4 of 7: 50%'
    """

    stage: str
    number: int
    of: int
    done: float
    total: float


class Watch:
    """Calls back with the progress of the present stage."""

    def __init__(self, progress: Callable[[Progress], object] | None) -> None:
        self._progress, self._stage = progress, STAGES[0]
        self._bytes = 0.0

    def begin(self, stage: str) -> None:
        """Enter a stage."""
        self._stage = stage
        self._tell(0.0, self._bytes)

    def read(self, samples: int, consumed: float, size: float) -> None:
        """Tell of the first pass."""
        self._bytes = size
        self._tell(consumed if size else float(samples), size)

    def advance(self, samples: int, of: int) -> None:
        """Tell of a later pass."""
        total = self._bytes or float(of)
        self._tell(total * samples / of, total)

    def _tell(self, done: float, total: float) -> None:
        if self._progress is not None:
            self._progress(Progress(self._stage, STAGES.index(self._stage) + 1, len(STAGES), done, total))
