"""A gated recurrent network of 24 states, trained on its own free run from the input alone.

Truncated backpropagation through time: the fitted half is cut into windows that are passed side by side. Each begins at
the state in which the pass before was there; its first half warms that state up and is not compared. The last fifth of
the fitted half is not trained on: it says when to stop.
"""

from __future__ import annotations

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax

from boxes.signals import Half, Predictor
from dehyst.arrays import Array

STATES = 24
SAMPLES = 1500  # of the fitted half that are kept; the output between them is interpolated
COUNTED = 128  # of a window, after as many that warm the state up
STEPS, LOOK = 2000, 50  # of Adam, and how many of them between two looks at the last fifth
RATE = 1e-2
SEEDS = (0, 1, 2)
Parameters = dict[str, jax.Array]


def born(seed: jax.Array, longest: float) -> Parameters:
    """Random parameters; states keep what they know from one sample to the `longest` time, in samples."""
    keys, n = jax.random.split(jax.random.key(seed), 4), STATES
    slow = jnp.log(longest) * jax.random.uniform(keys[2], (n,))
    return {
        "input": jax.random.normal(keys[0], (2, 3 * n)) / jnp.sqrt(2.0),
        "state": jax.random.normal(keys[1], (n, 3 * n)) / jnp.sqrt(float(n)),
        "bias": jnp.concatenate([slow, jnp.zeros(2 * n)]),
        "out": 0.1 * jax.random.normal(keys[3], (n,)),
        "line": jnp.array([1.0, 0.0, 0.0]),
    }


def passed(p: Parameters, u: jax.Array, h: jax.Array) -> tuple[jax.Array, jax.Array]:
    """States and outputs (T, ...) along inputs (T, ..., 2) from a state (..., STATES)."""
    n = STATES

    def step(h: jax.Array, a: jax.Array) -> tuple[jax.Array, jax.Array]:
        b = h @ p["state"]
        gates = jax.nn.sigmoid(a[..., : 2 * n] + b[..., : 2 * n])
        new = jnp.tanh(a[..., 2 * n :] + gates[..., n:] * b[..., 2 * n :])
        h = gates[..., :n] * h + (1.0 - gates[..., :n]) * new
        return h, h

    states = lax.scan(step, h, u @ p["input"] + p["bias"], unroll=4)[1]
    return states, states @ p["out"] + u @ p["line"][:2] + p["line"][2]


def adam(p: Any, g: Any, m: Any, v: Any, k: jax.Array) -> tuple[Any, Any, Any]:
    """One step of Adam; its rate falls on half a cosine, the gradient is cut to a length of 1."""
    length = jnp.sqrt(sum(jnp.sum(a * a) for a in jax.tree.leaves(g)))
    g = jax.tree.map(lambda a: a / jnp.maximum(length, 1.0), g)
    m = jax.tree.map(lambda m, g: 0.9 * m + 0.1 * g, m, g)
    v = jax.tree.map(lambda v, g: 0.999 * v + 0.001 * g * g, v, g)
    rate = RATE * (0.01 + 0.495 * (1.0 + jnp.cos(jnp.pi * k / STEPS)))
    rate *= jnp.sqrt(1.0 - 0.999 ** (k + 1.0)) / (1.0 - 0.9 ** (k + 1.0))
    return jax.tree.map(lambda p, m, v: p - rate * m / (jnp.sqrt(v) + 1e-8), p, m, v), m, v


def trained(
    carry: Any, first: jax.Array, windows: jax.Array, y: jax.Array, counts: jax.Array
) -> Any:
    """Parameters, moments and states of windows after LOOK more steps."""

    def loss(p: Parameters, h: jax.Array) -> tuple[jax.Array, jax.Array]:
        states, f = passed(p, windows, h)
        return jnp.sum(jnp.where(counts, f[COUNTED:] - y, 0.0) ** 2) / jnp.sum(counts), states[
            COUNTED - 1
        ]

    def step(carry: Any, k: jax.Array) -> tuple[Any, None]:
        p, m, v, h = carry
        g, middle = jax.grad(loss, has_aux=True)(p, h)
        return (*adam(p, g, m, v, k), jnp.concatenate([h[:1], middle[:-1]])), None

    return lax.scan(step, carry, first + jnp.arange(LOOK))[0]


TRAINED = jax.jit(jax.vmap(trained, in_axes=(0, None, None, None, None)))
RUN = jax.jit(jax.vmap(lambda p, u: passed(p, u, jnp.zeros(STATES))[1], in_axes=(0, None)))


def inputs(x: Array, rate: float) -> Array:
    """Input and its change, (T, 2), after a rest as long as the warm-up."""
    u = np.column_stack([x, np.diff(x, prepend=x[0]) / rate])
    return np.concatenate([np.repeat(u[:1], COUNTED, axis=0), u]).astype(np.float32)


def gru(half: Half) -> list[Predictor]:
    """Three networks, one a seed, trained side by side."""
    every = half.every(SAMPLES)
    x, y = half.x[::every], half.y[::every]
    rate = max(float(np.sqrt(np.mean(np.diff(x) ** 2))), 1e-9)
    size, stop = x.size, int(0.8 * x.size)
    count = -(-stop // COUNTED)
    u = inputs(x, rate)
    filled = np.concatenate([u, np.repeat(u[-1:], COUNTED, axis=0)])
    windows = np.stack([filled[k * COUNTED : (k + 2) * COUNTED] for k in range(count)], axis=1)
    aims = np.zeros(count * COUNTED, dtype=np.float32)
    aims[:stop] = y[:stop]
    counts = np.arange(count * COUNTED) < stop
    folded = [values.reshape(count, COUNTED).T for values in (aims, counts)]
    p = jax.vmap(lambda seed: born(seed, size / 4.0))(jnp.array(SEEDS))
    zero = jax.tree.map(jnp.zeros_like, p)
    carry = (p, zero, zero, jnp.zeros((len(SEEDS), count, STATES)))
    least, best = [np.inf] * len(SEEDS), [p] * len(SEEDS)
    for first in range(0, STEPS, LOOK):
        carry = TRAINED(carry, float(first), windows, *folded)
        error = np.asarray(RUN(carry[0], u))[:, COUNTED + stop :] - y[stop:]
        for k, rms in enumerate(np.sqrt(np.mean(error**2, axis=1)).tolist()):
            if rms < least[k]:
                least[k], best[k] = rms, carry[0]

    def predictor(k: int) -> Predictor:
        own = jax.tree.map(lambda a: a[k : k + 1], best[k])

        def predicted(x: Array) -> Array:
            f = np.asarray(RUN(own, inputs(x[::every], rate)))[0, COUNTED:]
            return np.asarray(np.interp(np.arange(x.size), np.arange(x.size)[::every], f))

        return predicted

    return [predictor(k) for k in range(len(SEEDS))]
