"""Normal equations from data, and the way from data to weights."""

from __future__ import annotations

import numpy as np

from . import alternatives, engine
from .figures import Figures
from .limits import SIGNALS as BOUNDED
from .measure import Work, measure
from .signals import SIGNALS, Array, operator

OPERATORS = (100, 1000)
SCRIPT_SAMPLES = 1_000_000  # of data to weights
NOISE = 1e-3  # on the outputs


def run(samples: int, rounds: int, figures: Figures, quick: bool) -> None:
    """Time the accumulation for every signal, or those with a limit, then everything from data to weights."""
    for signal in BOUNDED if quick else SIGNALS:
        x = SIGNALS[signal](samples)
        for n in OPERATORS:
            y = outputs(x, n)
            times = measure(works(x, y, n), rounds)
            figures.times(f"normal equations, n = {n}", signal, times)
            read = "read x and y"
            figures.ratio(
                f"normal equations / reading x and y, n = {n}", signal, times, "engine", read
            )
            figures.ratio(
                f"chunked BLAS / normal equations, n = {n}", signal, times, "chunked BLAS", "engine"
            )
        if signal in ("smooth", "noisy"):
            data_to_weights(x[:SCRIPT_SAMPLES], signal, rounds, figures)


def outputs(x: Array, n: int, zeros: bool = True) -> Array:
    """Noisy outputs of an operator half of whose weights are zero."""
    r, w = operator(n)
    rng = np.random.default_rng(n + 1)
    if zeros:
        w = w * (rng.random(n) < 0.5)
    return np.asarray(engine.evaluator(r, w).run(x) + NOISE * rng.standard_normal(x.size))


def works(x: Array, y: Array, n: int) -> dict[str, Work | None]:
    """What is timed; BLAS on a prefix that takes it some tenths of a second."""
    r, _ = operator(n)
    part = slice(0, min(x.size, int(1e8 / n**1.5) // alternatives.CHUNK * alternatives.CHUNK))
    return {
        "read x and y": Work(lambda: np.dot(x, y), x.size),
        "engine": Work(lambda: engine.cell_sums(x, y, r), x.size),
        "chunked BLAS": Work(lambda: alternatives.chunked_blas(x[part], y[part], r), part.stop),
    }


def data_to_weights(x: Array, signal: str, rounds: int, figures: Figures, n: int = 100) -> None:
    """From a million samples to weights: ours, and a script that does what it says, 0.8 GB of play outputs included."""
    r, _ = operator(n)
    y = outputs(x, n)
    quadprog = alternatives.solvers()["quadprog"]

    def script() -> None:
        h = alternatives.numpy_plays(x, r)
        quadprog(h.T @ h, h.T @ y)  # type: ignore[misc]

    name = "numpy + quadprog"
    times = measure({
        "engine": Work(lambda: engine.weights(x, y, r), x.size),
        name: Work(script, x.size) if quadprog else None,
    }, rounds)  # fmt: skip
    figures.times(f"data to weights, n = {n}", signal, times)
    figures.ratio(f"{name} / data to weights, n = {n}", signal, times, name, "engine")
