"""ISO 9283 sections of a run far beside its path: no crossing of another side is taken for this one."""

import numpy as np
import pytest

from dehyst.robot.iso9283 import TestCube, iso9283, test_path, timed

CENTER = np.array([0.7, 0.0, 0.5])
PATH = timed(test_path(TestCube(0.4, CENTER), 0.03), 0.3, 2.0, 40.0, rest=0.4, factor=5.0)
TIME = np.arange(0.0, PATH.duration, 0.02)


# Runs that lag, shrink, are offset and wander: of these, a crossing of another side of the rectangle was once taken for
# the section's own, and AT was up to 3.2 times the largest tracking error.
@pytest.mark.parametrize("seed", [0, 25, 26, 32, 36, 49, 54])
def test_path_accuracy_stays_near_the_largest_tracking_error_however_far_the_run_is_off(seed):
    draw = np.random.default_rng(seed)
    lag, scale, offset = draw.uniform(0, 1.5), draw.uniform(0.75, 1.1), 0.015 * draw.normal(size=3)
    run = CENTER + scale * (PATH.position(np.maximum(TIME - lag, 0.0)) - CENTER) + offset
    for f in (3, 7, 11):
        size = 0.01 * draw.normal(size=3)
        run += size * np.sin(2 * np.pi * TIME[:, None] * f / PATH.duration + draw.uniform(0, 6, 3))
    found = iso9283(PATH, TIME, run)
    assert found["AT_mm"] <= 1.55 * found["tracking_max_mm"]
