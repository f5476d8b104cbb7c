"""A stand-in for a slow test of a silicon electrode: writes a log of charge and open-circuit voltage.

    python examples/simulators/ocv_cell.py ocv.csv             # a full cycle and partial ones
    python examples/simulators/ocv_cell.py outer.csv --outer   # the full cycle alone

Thousands of particles have two phases each: one takes lithium below one potential and gives it back above a higher one
(a Preisach sum). Between them lies a solution without hysteresis. This is no model with one state.
"""

import argparse
from itertools import pairwise

import numpy as np

CAPACITY, STEP, RESOLUTION = 2.4, 0.002, 3e-4  # Ah, of x a sample, V of noise


class Electrode:
    """Particles that fill below one potential and empty above another."""

    def __init__(self, seed=0):
        random = np.random.default_rng(seed)
        self.fill = random.normal(0.20, 0.07, 6000)
        self.empty = self.fill + np.abs(random.normal(0.16, 0.05, 6000))
        self.full = np.zeros(6000, dtype=bool)

    def lithium(self, potential, full):
        """Stoichiometry at a potential, of phases that are full or not."""
        return 0.6 * full.mean() + 0.4 / (1.0 + np.exp((potential - 0.28) / 0.09))

    def potential(self, x, rising):
        """The potential at which x is reached in this direction; the phases are set."""
        low, high = -0.6, 1.4
        for _ in range(40):
            middle = 0.5 * (low + high)
            full = self.phases(middle, rising)
            if self.lithium(middle, full) > x:
                low = middle
            else:
                high = middle
        self.full = self.phases(middle, rising)
        return middle

    def phases(self, potential, rising):
        """Which are full: more with lithium that enters, fewer with lithium that leaves."""
        if rising:
            return self.full | (potential < self.fill)
        return self.full & (potential < self.empty)


def log(outer=False):
    """Rows of charge [Ah] and voltage [V]."""
    turns = [0.02, 0.98, 0.02]
    if not outer:
        turns += [0.6, 0.35, 0.6, 0.98, 0.5, 0.7, 0.25, 0.45, 0.02]
    electrode, rows, random = Electrode(), [], np.random.default_rng(1)
    for begin, end in pairwise(turns):
        for x in np.arange(begin, end, np.copysign(STEP, end - begin)):
            rows.append((CAPACITY * x, electrode.potential(x, end > begin) + RESOLUTION * random.normal()))
    return np.array(rows)


def main():
    """Write the log."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out")
    parser.add_argument("--outer", action="store_true", help="no partial cycles")
    arguments = parser.parse_args()
    np.savetxt(arguments.out, log(arguments.outer), "%.6f", ",", header="charge [Ah],voltage [V]", comments="")


if __name__ == "__main__":
    main()
