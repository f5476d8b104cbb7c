"""What must hold (the acceptance of the engine), as data: one limit for every figure of the table."""

from __future__ import annotations

from dataclasses import dataclass

SIGNALS = ("smooth", "noisy", "white")
TIMING = 0.05  # two equal things differ by so much in a good measurement
QUICK = 4.0  # a short measurement on any machine, busy or old, must reach a quarter of what is asked for


@dataclass(frozen=True)
class Limit:
    """A figure `what` for a signal: at most or at least so much.

    Kinds: a "ratio" of times, of which a short run has to reach a quarter; an "accuracy", which holds in a short run as
    well; a "time", which a short run on a busy machine does not judge.
    """

    what: str
    signal: str
    sense: str  # "<=" or ">="
    value: float
    kind: str = "ratio"

    def asked(self, quick: bool = False) -> float | None:
        """The bound that a run is judged by; None if it is not judged."""
        if self.kind == "time" and quick:
            return None
        easier = QUICK if self.kind == "ratio" and quick else 1.0
        return self.value * easier if self.sense == "<=" else self.value / easier

    def holds(self, measured: float, quick: bool = False) -> bool | None:
        """Whether a measured figure is within it; None if that is not judged."""
        bound = self.asked(quick)
        if bound is None:
            return None
        if bound == 1.0:
            bound += TIMING if self.sense == "<=" else -TIMING
        return measured <= bound if self.sense == "<=" else measured >= bound


def _row(what: str, sense: str, *values: float | None) -> tuple[Limit, ...]:
    pairs = zip(SIGNALS, values, strict=False)
    return tuple(Limit(what, signal, sense, value) for signal, value in pairs if value is not None)


def _one(what: str, value: float) -> tuple[Limit, ...]:
    return tuple(Limit(what, signal, "<=", value, "accuracy") for signal in SIGNALS)


LIMITS: tuple[Limit, ...] = (
    *_row("evaluation / memcpy, n = 100", "<=", 1.25, 5.0),
    *_row("evaluation / memcpy, n = 1000", "<=", 2.0, 14.0, 90.0),
    *_row("evaluation / memcpy, n = 10000", "<=", 8.0, 75.0, 90.0),
    *_row("evaluation / dense SIMD, n = 100", "<=", None, None, 1.0),
    *_row("numpy loop / evaluation, n = 100", ">=", 4000.0, 1000.0, 300.0),
    *_row("normal equations / reading x and y, n = 100", "<=", 2.0, 12.0),
    *_row("chunked BLAS / normal equations, n = 100", ">=", 400.0, 60.0, 3.0),
    *_row("chunked BLAS / normal equations, n = 1000", ">=", 4000.0, 800.0, 40.0),
    *_row("numpy + quadprog / data to weights, n = 100", ">=", 4000.0, 350.0),
    Limit("scipy nnls / solver, n = 100", "modulated", ">=", 2.0),
    Limit("scipy nnls / solver, n = 1000", "modulated", ">=", 15.0),
    *_one("evaluation - dense definition, n = 100", 1e-14),
    *_one("the same, last over first hundredth", 2.0),
    Limit("inverse round trip, gain 2, n = 100", "noisy", "<=", 1e-14, "accuracy"),
    Limit("inverse round trip, gain 2, n = 1000", "noisy", "<=", 1e-14, "accuracy"),
    Limit("inverse round trip, gain 2, n = 10000", "noisy", "<=", 3e-14, "accuracy"),
    Limit("weights of an exact model, n = 100", "modulated", "<=", 1e-12, "accuracy"),
    Limit("weights of an exact model, n = 1000", "modulated", "<=", 1e-11, "accuracy"),
    Limit("weights - qpOASES, n = 100", "modulated", "<=", 1e-8, "accuracy"),
    Limit("the core's functions / a sum along a signal, forward", "example log", ">=", 1.25),
    Limit("the core's functions / a sum along a signal, back", "example log", ">=", 1.25),
    Limit("a sum along a signal, forward [ns]", "example log", "<=", 150.0, "time"),
    Limit("a sum along a signal, back [ns]", "example log", "<=", 400.0, "time"),
    Limit("overhead of a batch call [ns]", "", "<=", 1000.0, "time"),
    Limit("overhead of a step [ns]", "", "<=", 30.0, "time"),
    Limit("identify, 10000 rows [s]", "example log", "<=", 1.5, "time"),
    Limit("identify, 1000000 rows [s]", "example log", "<=", 4.0, "time"),
    Limit("compare, 1000000 rows [s]", "example log", "<=", 20.0, "time"),
)
