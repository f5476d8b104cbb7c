"""ISO 9283 sections of a run far beside its path: no crossing of another side is taken for this one."""

import numpy as np
import pytest

from dehyst.evaluation import TestCube, iso9283, test_path, timed


@pytest.mark.parametrize("size", [0.01, 0.03, 0.06])
@pytest.mark.parametrize("seed", [0, 1, 2, 3])
def test_path_accuracy_stays_near_the_largest_tracking_error_however_far_the_run_is_off(size, seed):
    path = timed(test_path(TestCube(0.4, [0.7, 0.0, 0.5]), 0.03), 0.3, 2.0, 40.0, rest=0.4, factor=5.0)
    time = np.arange(0.0, path.duration, 0.02)
    draw = np.random.default_rng(seed)
    wander = sum(
        size * draw.normal(size=3) * np.sin(2 * np.pi * time[:, None] * f / path.duration + draw.uniform(0, 6, 3))
        for f in (3, 7, 11)
    )
    found = iso9283(path, time, path.position(time) + wander)
    assert found["tracking_max_mm"] > 1000 * size / 2
    assert found["AT_mm"] <= 1.5 * found["tracking_max_mm"]
