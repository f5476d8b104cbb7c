"""Times: minima of interleaved repetitions, so that a busy moment of the machine meets every method alike.

Processor time of the process, all its threads: on a machine that does nothing else it is the time on the wall, on a
busy one it leaves out the turns of other programs, which hit long runs and spare short ones.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

Action = Callable[[], object]


@dataclass(frozen=True)
class Work:
    """Something to time: what runs, and how many samples it handles (fewer than the signal has, if it is slow)."""

    run: Action
    samples: int


@dataclass
class Times:
    """Seconds of every repetition, by name, in the order in which they ran."""

    samples: dict[str, int] = field(default_factory=dict)
    seconds: dict[str, list[float]] = field(default_factory=dict)

    def best(self, name: str) -> float:
        """Least time of one run [s]."""
        return min(self.seconds[name])

    def per_sample(self, name: str) -> float:
        """Least time per sample [ns]."""
        return 1e9 * self.best(name) / self.samples[name]

    def ratio(self, name: str, other: str) -> float:
        """Time per sample of one over that of the other."""
        return self.per_sample(name) / self.per_sample(other)

    def as_dict(self) -> dict[str, dict[str, float]]:
        """Name -> samples, ns per sample, repetitions."""
        return {
            name: {
                "samples": self.samples[name],
                "ns": float(f"{self.per_sample(name):.4g}"),
                "runs": len(runs),
            }
            for name, runs in self.seconds.items()
        }


def measure(works: Mapping[str, Work | None], rounds: int, patience: float = 4.0) -> Times:
    """Time works in turn, `rounds` times each; one that has taken `patience` seconds in all is not repeated.

    Works that are None (not installed) are left out. What takes less than a second runs once more before, uncounted,
    so that memory is touched and code loaded; it is not worth it for the others.
    """
    times = Times()
    for turn in range(rounds + 1):
        for name, work in works.items():
            if work is None or sum(times.seconds.get(name, ())) > patience:
                continue
            begin = time.process_time()
            work.run()
            taken = time.process_time() - begin
            if turn == 0 and taken < 1.0:
                continue
            times.samples[name] = work.samples
            times.seconds.setdefault(name, []).append(taken)
    return times


def each(action: Callable[[], object], calls: int, rounds: int) -> float:
    """Least time of one call among many [s], the loop around it taken out."""

    def loop(function: Action) -> float:
        many = range(calls)
        begin = time.process_time()
        for _ in many:
            function()
        return time.process_time() - begin

    def nothing() -> None:
        return None

    with_call, empty = [], []
    for _ in range(rounds):
        with_call.append(loop(action))
        empty.append(loop(nothing))
    return max(min(with_call) - min(empty), 0.0) / calls
