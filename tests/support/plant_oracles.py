"""Hysteresis mechanisms a second time: slow, from their definitions, sharing no code with the plant."""

import numpy as np


class MaxwellSlip:
    """Springs that slip, in numpy, with the protocol of a foreign mechanism."""

    def __init__(self, parameters):
        self.share = np.array(parameters["share"])
        self.stiffness = parameters["size"] * self.share / np.array(parameters["strain"])
        self.parameters = parameters

    def reset(self, contraction):
        self.last = contraction
        self.f = np.zeros_like(self.share)

    def force(self, contraction, pressure, period):
        h = self.parameters
        slip = h["size"] * (
            h["constant_share"] + h["pressure_share"] * pressure / h["reference_pressure"]
        )
        self.f = np.clip(
            self.f + self.stiffness * (contraction - self.last),
            -slip * (1 - h["asymmetry"]) * self.share,
            slip * (1 + h["asymmetry"]) * self.share,
        )
        self.last = contraction
        return float(self.f.sum())


def everett(a, b):
    """The Everett function of packages/dehyst-robot/plant/preisach.c, from its comment."""
    a, b = np.broadcast_arrays(np.asarray(a, float), np.asarray(b, float))
    total, norm = 0.0, 0.0
    for c, g, e in ((0.5, 8.0, 3.0), (0.5, 5.0, -0.8)):
        bent = [g * x * (1 + e * x**2 / 3) for x in (a, b)]
        total = total + c * (1 - np.exp(-np.abs(bent[1] - bent[0])))
        norm += c * (1 - np.exp(-2 * g * (1 + e / 3)))
    return 2 * total / norm


class Relays:
    """Preisach model as a plane of relays on the cells of a grid, less a reversible part; for inputs on the grid.

    A relay of cell (i, j) goes up when the input reaches grid point j + 1, down when it comes back to i. The weights
    are the second differences of the Everett function: the density itself, not its integral over triangles.
    """

    def __init__(self, cells):
        self.x = np.linspace(-1, 1, cells + 1)
        e = everett(self.x[:, None], self.x[None, :])
        i, j = np.meshgrid(np.arange(cells), np.arange(cells), indexing="ij")
        self.weight = np.where(i < j, e[1:, 1:] - e[:-1, 1:] - e[1:, :-1] + e[:-1, :-1], 0.0)
        self.reversible = np.concatenate(([0.0], np.cumsum(np.diag(e, 1))))
        self.low, self.high = i, j + 1
        middle = cells // 2
        self.relay = np.sign(2 * middle - (i + j + 1.0))  # demagnetised in the middle
        self.start = self._sum(middle)

    def _sum(self, k):
        return self.reversible[k] - 0.5 * float(np.sum(self.weight * self.relay))

    def to(self, k):
        """Output after moving to grid point k."""
        self.relay = np.where(k >= self.high, 1.0, np.where(k <= self.low, -1.0, self.relay))
        return self._sum(k) - self.start
