"""What speed must not cost: differences from the definition, over the whole length of the signals."""

from __future__ import annotations

import numpy as np

import dehyst
from dehyst import _native

from . import alternatives, engine
from .figures import Figures
from .limits import SIGNALS as BOUNDED
from .program import DATA, excitation
from .signals import SIGNALS, Array, operator


def run(samples: int, figures: Figures) -> None:
    """Compare with the dense sum, go there and back through the inverse, find the weights of an exact model again."""
    against_the_definition(samples, figures)
    for n in (100, 1000, 10_000):
        r, w = operator(n)
        figures.add(
            f"inverse round trip, gain {1 / w[0]:.0f}, n = {n}",
            "noisy",
            round_trip(samples // 10, r, w),
        )
        w[0] = 0.5
        figures.add(
            f"inverse round trip, gain 2, n = {n}", "noisy", round_trip(samples // 10, r, w)
        )
    for n in (100, 1000):
        figures.add(f"weights of an exact model, n = {n}", DATA, exact_weights(n))


def against_the_definition(samples: int, figures: Figures, n: int = 100) -> None:
    """Largest difference from the core's dense sum over max|y|, and how it grows from the first to the last 1 %."""
    r, w = operator(n)
    for signal in BOUNDED:
        x = SIGNALS[signal](samples)
        dense = alternatives.core_dense(x, r, w)
        differs = np.abs(engine.evaluator(r, w).run(x) - dense) / np.max(np.abs(dense))
        figures.add(f"evaluation - dense definition, n = {n}", signal, differs.max())
        part = samples // 100
        first = max(float(differs[:part].max()), np.finfo(float).eps)
        figures.add(
            "the same, last over first hundredth", signal, float(differs[-part:].max()) / first
        )


def round_trip(samples: int, r: Array, w: Array) -> float:
    """Largest error of inverse after model, over the range of x.

    No evaluator can do better than the gain of the inverse, 1/w_1 if weights are positive, times the rounding of y.
    """
    x = SIGNALS["noisy"](samples)
    _, r_inverse, w_inverse, z = _native.pi_invert(r, w, np.zeros(r.size))
    back = _native.Evaluator(r_inverse, w_inverse, 0.0, 0.0, z).run(engine.evaluator(r, w).run(x))
    return float(np.max(np.abs(back - x)) / np.ptp(x))


def exact_weights(n: int) -> float:
    """Largest error of identified weights over the largest weight, on data without noise."""
    r, w = operator(n)
    w = np.where(np.random.default_rng(n).random(n) < 0.5, w, 0.0)
    w[0] = 0.1
    x = excitation()
    log = dehyst.Recording(input=x, output=alternatives.core_dense(x, r, w))
    fit = dehyst.identify(log, "pi", thresholds=r, initial_state="zero", train_fraction=1.0)
    assert isinstance(fit.model, dehyst.PrandtlIshlinskii)
    found = np.zeros(n)  # operators without weight are left out of the model
    found[np.rint(fit.model.thresholds * n).astype(int)] = fit.model.weights
    return float(np.max(np.abs(found - w)) / w.max())
