"""Long signals go through the engine's walk: its answers are those of the core's own functions, to the bit."""

import numpy as np
import pytest

from element_samples import random_elements


def signal(rng, size=1500):
    """Strokes, rests, jumps to points of the maps, and samples that are none."""
    x = np.cumsum(rng.normal(0.0, 0.2, size))
    x[rng.random(size) < 0.1] = rng.uniform(-2.0, 2.0)
    x = np.clip(x, -3.0, 3.0)
    x[500:600] = x[500]
    corners = rng.random(size) < 0.05
    x[corners] = np.round(x[corners], 1)
    x[rng.random(size) < 0.01] = rng.choice([np.nan, np.inf, -1e300])
    return x


@pytest.mark.spread(20)
@pytest.mark.parametrize("seed", range(60))
def test_the_walk_answers_as_the_core_does_to_the_bit(seed):
    rng = np.random.default_rng(seed)
    machine = random_elements(rng)._sum
    x = signal(rng)
    # Steps of time as time stamps give them: of one length but for rounding, with a gap and a stamp that stands still.
    dt = np.diff(0.01 * np.arange(x.size + 1.0))
    dt[rng.integers(x.size, size=40)] = rng.uniform(0.0, 0.2, 40)
    dt[::97] = 0.0
    given = rng.uniform(-2.0, 2.0, (x.size, 3))
    memory = machine.rest(0.3)
    for steps in (dt, None):
        y, after, refused, _ = machine.run(x, steps, given, memory)
        y_core, after_core, refused_core, _ = machine.run(x, steps, given, memory, core=True)
        assert y.tobytes() == y_core.tobytes() and after.tobytes() == after_core.tobytes()
        assert refused == refused_core > 0
        wanted = np.where(np.isfinite(x), y, x)
        back = machine.solve(wanted, steps, given, memory)
        back_core = machine.solve(wanted, steps, given, memory, core=True)
        for walked, stepped in zip(back[:2], back_core[:2], strict=True):
            assert walked.tobytes() == stepped.tobytes()
        assert back[2:] == back_core[2:]
