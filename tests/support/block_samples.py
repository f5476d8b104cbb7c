"""Models, ranges and references for the tests of blocks."""

import numpy as np

from dehyst.models import BLOCK_FLAGS, Block
from dehyst.models._machine import started_machine
from oracles import random_walk
from test_inverse import FAMILIES, make

LIMITED, REJECTED = BLOCK_FLAGS["limited"], BLOCK_FLAGS["rejected"]


def sample(seed, most=30):
    """Return a random model of any family with up to `most` operators, in a visited state, and a range of its input."""
    rng = np.random.default_rng(seed)
    model = make(FAMILIES[seed % len(FAMILIES)], int(rng.integers(1, most + 1)), rng)
    low = rng.uniform(-1.0, 0.5)
    return model, (low, low + rng.uniform(0.4, 1.2)), rng


def operator_of(block):
    """Return the model that a block of plays answers with, in its start state."""
    if block.direction == "forward":
        return block.model
    return started_machine(block.model, block.output.low, block.output.high)


def wishes(block, rng, samples=300, beyond=1.6):
    """Return a reference that often leaves what can be reached, on both sides, and comes back."""
    low, high = block.input.low, block.input.high
    return (low + high) / 2 + (high - low) / 2 * beyond * random_walk(rng, samples)


def plain(model, x):
    """Return outputs and final states of dense steps."""
    step = model.stepper("dense")
    return np.array([step(v) for v in np.asarray(x).tolist()]), step.state


def inverse_block(seed):
    model, bounds, rng = sample(seed)
    return Block(model, "inverse", bounds, ramp=8), model, bounds, rng
