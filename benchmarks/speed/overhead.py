"""What a call from Python costs beyond the work in C."""

from __future__ import annotations

import time

import numpy as np

from dehyst import _native

from . import engine
from .figures import Figures
from .measure import each
from .signals import operator

CALLS = 200_000


def run(rounds: int, figures: Figures) -> None:
    """Time batch calls of eight samples, and single steps of one operator."""
    r, w = operator(1)
    x, out = np.zeros(8), np.zeros(8)
    batch = engine.evaluator(r, w).run
    figures.add(
        "overhead of a batch call [ns]", "", 1e9 * each(lambda: batch(x, out), CALLS // 10, rounds)
    )
    figures.add("overhead of a step [ns]", "", 1e9 * step(rounds))


def step(rounds: int) -> float:
    """Time of a call of the stepper of one operator less the loop around it, the step itself included. [s]"""
    r, w = operator(1)
    nothing = np.zeros(0)
    stepper = _native.Stepper(r, w, 0.0, 0.0, nothing, nothing, nothing, nothing, np.zeros(1))
    values = np.sin(np.linspace(0.0, 60.0, CALLS)).tolist()
    calls, loops = [], []
    for _ in range(2 * rounds):
        begin = time.process_time()
        for u in values:
            stepper(u)
        called = time.process_time()
        for _u in values:
            pass
        calls.append(called - begin)
        loops.append(time.process_time() - called)
    return (min(calls) - min(loops)) / CALLS
