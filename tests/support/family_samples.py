"""What the tests of the families of friction share: paths, records, an integrator of their own."""

import itertools

import numpy as np
from scipy.integrate import solve_ivp

from dehyst import Recording


def excitation(samples=1500, seed=0):
    """A path of turns of all sizes within -1..1."""
    t = np.linspace(0.0, 60.0, samples)
    phase = 6.28 * np.random.default_rng(seed).random(3)
    return (
        0.62 * np.sin(1.0 * t + phase[0])
        + 0.25 * np.sin(2.3 * t + phase[1])
        + 0.12 * np.sin(5.1 * t + phase[2])
    )


def record(model, x, noise, seed=0, time=None, **names):
    """A recording of a model's output with noise of a share of its range."""
    y = model.simulate(x, time)
    y = y + noise * np.ptp(y) * np.random.default_rng(seed).normal(size=y.size)
    return Recording(input=x, output=y, time=time, **names)


def integrated(rate, x, z0=0.0):
    """z along straight moves between the values of x, dz/dx = rate(sgn dx, z, x): scipy's DOP853 with small steps."""
    z = [z0]
    for a, b in itertools.pairwise(x):
        s = np.sign(b - a)
        path = solve_ivp(
            lambda u, w, a=a, s=s: s * rate(s, w, a + s * u),
            (0.0, abs(b - a)),
            [z[-1]],
            method="DOP853",
            rtol=1e-10,
            atol=1e-12,
            max_step=0.01,
        )
        z.append(float(path.y[0, -1]))
    return np.array(z)
