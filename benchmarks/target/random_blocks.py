"""Random models as blocks with random signals: limits are met, samples are no numbers at times, switches move."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from dehyst import ModifiedPrandtlIshlinskii, MonotoneMap, PrandtlIshlinskii
from dehyst.export._units import block_in, block_numbers
from dehyst.models import Block, HysteresisModel
from target.jobs import Array, Case


@dataclass(frozen=True)
class Trial:
    """A block in double precision, and the same with its signal as a job in another one."""

    block: Block
    case: Case
    real: str

    def expected(self) -> tuple[Array, Array]:
        """Return outputs and flags of the extension, in double precision."""
        self.block.reset()
        return self.block.run(self.case.x, self.case.on)

    def range(self) -> float:
        """Size of the range of the output."""
        return self.case.block.output_high - self.case.block.output_low


def random_model(rng: np.random.Generator) -> HysteresisModel:
    """Return a model of 1 to 60 operators that has an inverse, half of them with a map."""
    n = int(rng.integers(1, 61))
    r = np.concatenate([[0.0], np.cumsum(rng.uniform(0.05, 1.0, n - 1))]) * 10.0 ** rng.uniform(
        -1.0, 1.0
    )
    w = np.concatenate([[rng.uniform(0.3, 1.0)], rng.uniform(-0.2, 1.0, n - 1) / n])
    model = PrandtlIshlinskii(r, w, center=rng.normal(), offset=rng.normal())
    if rng.random() < 0.5:
        return model
    reach = 2.0 * (1.0 + r[-1]) * np.sum(np.abs(w))
    points = np.sort(rng.uniform(-reach, reach, int(rng.integers(2, 12))))
    points[-1] += 0.01 * reach
    values = np.cumsum(
        rng.uniform(0.2, 1.0, points.size) * np.diff(points, prepend=points[0] - 1.0)
    )
    return ModifiedPrandtlIshlinskii(model, after_map=MonotoneMap(points, values))


def trial(rng: np.random.Generator, samples: int, real: str) -> Trial:
    """Return a block, inverse or forward, and a signal that goes beyond its input range by up to a quarter."""
    model = random_model(rng)
    direction = "inverse" if rng.random() < 0.6 else "forward"
    stepper = model.stepper("dense")
    size = 1.5 * float(stepper.parameters[0][-1]) + 1.0
    block = Block(model, direction, range=(-size, 0.8 * size), ramp=int(rng.integers(1, 60)))
    numbers = block_in(block_numbers(block), real)
    low, high = numbers.input_low, numbers.input_high
    walk = np.cumsum(rng.normal(size=samples) * 10.0 ** rng.uniform(-2.0, -0.5))
    x = 0.5 * (low + high) + 0.5 * (high - low) * 1.25 * np.sin(walk)
    strange = rng.integers(0, samples, samples // 50)
    x[strange] = rng.choice(
        [np.nan, np.inf, -np.inf, 1e14, -1e14, low, high, -0.0, 5e-324], strange.size
    )
    if real == "float":
        x = x.astype(np.float32).astype(float)
    on = np.repeat(rng.random(samples // 40 + 1) < 0.7, 40)[:samples]
    return Trial(block, Case(numbers, x, on), real)


def trials(count: int, samples: int, real: str, seed: int = 5) -> list[Trial]:
    """Return that many."""
    rng = np.random.default_rng(seed)
    return [trial(rng, samples, real) for _ in range(count)]
