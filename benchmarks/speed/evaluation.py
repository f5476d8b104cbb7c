"""Evaluation: ns a sample of every method, for every signal and number of operators."""

from __future__ import annotations

import numpy as np

from dehyst import PrandtlIshlinskii

from . import alternatives, engine
from .figures import Figures
from .limits import SIGNALS as BOUNDED
from .measure import Work, measure
from .signals import SIGNALS, Array, operator

OPERATORS = (14, 100, 1000, 10_000)
NUMPY_SAMPLES = 20_000


def run(samples: int, rounds: int, figures: Figures, quick: bool) -> None:
    """Time every pair of signal and number of operators; those with a limit only, if it shall be quick."""
    out = np.zeros(samples)
    for signal in BOUNDED if quick else SIGNALS:
        x = SIGNALS[signal](samples)
        for n in OPERATORS[quick:]:
            works = bounded(x, out, n) if quick else everything(x, out, n)
            times = measure(works, rounds)
            figures.times(f"evaluation, n = {n}", signal, times)
            figures.ratio(f"evaluation / memcpy, n = {n}", signal, times, "engine", "memcpy")
            figures.ratio(
                f"evaluation / dense SIMD, n = {n}", signal, times, "engine", "engine, dense"
            )
            figures.ratio(
                f"numpy loop / evaluation, n = {n}", signal, times, "numpy loop", "engine"
            )
            figures.ratio(f"numba / evaluation, n = {n}", signal, times, "numba", "engine")


def bounded(x: Array, out: Array, n: int) -> dict[str, Work | None]:
    """What the limits are about."""
    r, w = operator(n)
    dense, short = x[: int(1e9 / n)], x[:NUMPY_SAMPLES]
    works: dict[str, Work | None] = {
        "memcpy": Work(lambda: np.copyto(out, x), x.size),
        "engine": Work(lambda: engine.evaluator(r, w).run(x, out), x.size),
    }
    if n == 100:
        works["engine, dense"] = Work(
            lambda: engine.evaluator(r, w, engine.DENSE).run(dense, out[: dense.size]), dense.size
        )
        works["numpy loop"] = Work(lambda: alternatives.numpy_loop(short, r, w), short.size)
    return works


def everything(x: Array, out: Array, n: int) -> dict[str, Work | None]:
    """And the others; slow ones on a prefix of the signal that takes them some tenths of a second."""
    r, w = operator(n)
    model = PrandtlIshlinskii(r, w)
    numba = alternatives.numba_loop()
    core, dense, short = x[: int(1e8 / n)], x[: int(1e9 / n)], x[:NUMPY_SAMPLES]
    first = bounded(x, out, n)
    return {
        "memcpy": first["memcpy"],
        "engine": first["engine"],
        "engine, events only": Work(
            lambda: engine.evaluator(r, w, engine.EVENTS).run(x, out), x.size
        ),
        "engine, dense": Work(
            lambda: engine.evaluator(r, w, engine.DENSE).run(dense, out[: dense.size]), dense.size
        ),
        "model.simulate": Work(lambda: model.simulate(x), x.size),
        "core, dense": Work(lambda: alternatives.core_dense(core, r, w), core.size),
        "numba": Work(lambda: numba(core, r, w), core.size) if numba else None,
        "numpy loop": Work(lambda: alternatives.numpy_loop(short, r, w), short.size),
    }
