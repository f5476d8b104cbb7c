"""The quadratic program alone: ours against solvers that one can install."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Set
from functools import partial

import numpy as np

from . import alternatives, engine
from .figures import Figures
from .measure import Work, measure
from .normal_equations import outputs
from .signals import Array, operator

SAMPLES = 40_000
DATA = "modulated"
Solver = Callable[[Array, Array], Array]
SLOW = {"qpOASES"}  # minutes at n = 1000: not run there
SLOW_IF_QUICK = {"qpOASES", "quadprog", "DAQP"}  # seconds


def excitation(samples: int = SAMPLES) -> Array:
    """Sine of changing amplitude from exactly -1 to 1: every operator moves, loops of all sizes."""
    t = np.arange(samples)
    x = np.sin(2 * np.pi * t / 2000) * (0.6 + 0.4 * np.sin(2 * np.pi * t / 17_000))
    return np.asarray(np.where(x > 0, x / x.max(), x / -x.min()))


def run(rounds: int, figures: Figures, quick: bool) -> None:
    """Time the solvers on the same normal equations and compare what they find."""
    for n in (100, 1000):
        left_out = (SLOW_IF_QUICK if quick else SLOW) if n > 100 else set()
        compare(n, rounds, figures, left_out)


def compare(n: int, rounds: int, figures: Figures, left_out: Set[str]) -> None:
    """All solvers on one program with n weights."""
    x = excitation()
    r, _ = operator(n)
    posed = engine.program(engine.cell_sums(x, outputs(x, n), r))
    found, _ = engine.solve(posed)
    in_weights = engine.in_weights(posed)
    others = {name: solve for name, solve in alternatives.solvers().items() if name not in left_out}
    times = measure(works(posed, others), 4 * rounds, patience=2.0)
    figures.times(f"quadratic program, n = {n}", DATA, times)
    figures.ratio(f"scipy nnls / solver, n = {n}", DATA, times, "scipy nnls", "engine")
    figures.add(f"weights that are exactly 0, n = {n}", DATA, np.sum(found == 0.0))
    for name, solve in others.items():
        if solve:
            difference = np.max(np.abs(solve(*in_weights) - found)) / np.max(np.abs(found))
            figures.add(f"weights - {name}, n = {n}", DATA, difference)


def works(posed: engine.Program, others: Mapping[str, Solver | None]) -> dict[str, Work | None]:
    """What is timed: ours from sums of cells, the others from sums of plays, nnls from their triangular factor."""
    _, passive = engine.solve(posed)
    g_w, b_w = engine.in_weights(posed)
    factor, right = alternatives.triangle(g_w, b_w)
    return {
        "engine": Work(lambda: engine.solve(posed), 1),
        "engine, warm start": Work(lambda: engine.solve(posed, passive), 1),
        "scipy nnls": Work(lambda: alternatives.solve_nnls(factor, right), 1),
        **{
            name: Work(partial(solve, g_w, b_w), 1) if solve else None
            for name, solve in others.items()
        },
    }
