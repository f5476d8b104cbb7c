"""After a break a piece counts once its memory is known, with a level of its own where wider plays stay unknown."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest

import dehyst
from dehyst.identification import known_from
from dehyst.identification._memory import known_after_break

Array = npt.NDArray[np.float64]
TRUTH = dehyst.PrandtlIshlinskii(
    np.arange(10) * 0.21, [3.0, 1.0, 1.0, 0.6, 0.5, 0.4, 0.3, 0.2, 0.2, 0.2]
)
SAMPLES, CYCLES = 8000, 200


def rig(
    rng: np.random.Generator, largest: float = 2.0
) -> tuple[dehyst.Recording, dehyst.Recording]:
    """Cycles to 89 .. 95 % of the range, one to its ends; whole, and with five stretches of it lost."""
    phase = CYCLES * np.arange(SAMPLES) / SAMPLES
    size = 2.0 * (0.95 - 0.06 * rng.random(CYCLES + 1))
    size[4] = largest
    cycle = phase.astype(int)
    x = size[cycle] * np.sin(2 * np.pi * phase) * np.where(cycle % 4 == 3, 0.5, 1.0)
    y = TRUTH.simulate(x) + 0.02 * rng.normal(size=SAMPLES)
    kept = np.ones(SAMPLES, dtype=bool)
    for begin in rng.choice(np.arange(300, SAMPLES - 300), 5, replace=False):
        kept[begin : begin + int(rng.integers(30, 120))] = False
    index = np.flatnonzero(kept)
    breaks = tuple((np.flatnonzero(np.diff(index) > 1) + 1).tolist())
    return dehyst.Recording(input=x, output=y), dehyst.Recording(
        input=x[kept], output=y[kept], breaks=breaks
    )


def true_error(model: dehyst.models.HysteresisModel) -> float:
    """Percent of range, on loops that nothing was fitted to."""
    x = 2.0 * np.sin(np.linspace(0.0, 30.0, 3000)) * np.linspace(1.0, 0.2, 3000)
    gap = model.simulate(x) - TRUTH.simulate(x)
    return 100.0 * float(np.sqrt(np.mean(gap**2)) / np.ptp(TRUTH.simulate(x)))


@pytest.mark.spread(3)
@pytest.mark.parametrize("seed", range(8))
def test_a_log_with_breaks_gives_the_model_of_the_whole_one(seed: int) -> None:
    whole, broken = rig(np.random.default_rng(seed))
    fits = [dehyst.identify(record, "pi", n=40) for record in (whole, broken)]
    counted = int(sum(mask.sum() for mask in (*fits[1].train_masks, *fits[1].test_masks)))
    assert counted > 0.9 * len(
        broken
    )  # of 7700 samples 600 to 2600 counted before, and none was held out
    assert fits[1].test is not None
    assert true_error(fits[1].model) < 1.5 * true_error(fits[0].model)


@pytest.mark.slow
def test_weights_are_unbiased() -> None:
    gaps = []
    for seed in range(8):
        _, broken = rig(np.random.default_rng(100 + seed))
        fit = dehyst.identify(broken, "pi", thresholds=np.asarray(TRUTH.thresholds))
        found = dict(zip(fit.model.thresholds.tolist(), fit.model.weights.tolist(), strict=True))  # type: ignore[union-attr]
        gaps.append(
            [
                found.get(r, 0.0) - w
                for r, w in zip(TRUTH.thresholds[:8], TRUTH.weights[:8], strict=True)
            ]
        )
    mean, doubt = np.mean(gaps, axis=0), np.std(gaps, axis=0, ddof=1) / np.sqrt(len(gaps))
    assert np.all(np.abs(mean) < 4.0 * doubt + 0.01)


def test_where_the_ends_are_visited_soon_nothing_else_will_do() -> None:
    x = np.concatenate([0.93 * np.sin(np.arange(40) / 3), np.sin(np.arange(400) / 3)])
    assert known_after_break(x) == known_from(x, -1.0, 1.0) > 40
