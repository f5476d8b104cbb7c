"""A stand-in for a ferrite core on a B-H analyser: writes a log of field and flux density.

    python examples/simulators/ferrite_core.py core.csv                  # a saturated loop, then smaller ones, 1 kHz
    python examples/simulators/ferrite_core.py core.csv --top 60         # driven no farther than 60 A/m

The core is a Preisach sum of relays on a curve that saturates: none of the models that are fitted to it.
"""

import argparse

import numpy as np

MU_0, PERIOD, SAMPLES = 4e-7 * np.pi, 1e-3, 500  # H/m, s, samples a period


class Core:
    """Relays that switch up above one field and down below another, and a reversible part."""

    def __init__(self, seed=0):
        random = np.random.default_rng(seed)
        middle, half = random.normal(0.0, 14.0, 8000), np.abs(random.normal(16.0, 7.0, 8000))
        self.low, self.high = middle - half, middle + half
        self.state = np.where(middle > 0.0, -1.0, 1.0)

    def density(self, field):
        """Flux density along a field. [A/m] -> [T]"""
        b = np.empty(field.size)
        for k, h in enumerate(field):
            self.state[h > self.high], self.state[h < self.low] = 1.0, -1.0
            b[k] = 0.26 * self.state.mean() + 0.17 * np.tanh(h / 60.0) + 10.0 * MU_0 * h
        return b


def log(top=250.0):
    """Rows of time [us], field [A/m] and flux density [mT]."""
    phase = 2.0 * np.pi * np.arange(SAMPLES) / SAMPLES
    tops = np.repeat([1.0, 0.2, 0.06], 2) * top
    field = np.concatenate([size * np.sin(phase) for size in tops] + [[0.0]])
    time = PERIOD / SAMPLES * np.arange(field.size)
    density = Core().density(field) + 1e-4 * np.random.default_rng(1).normal(size=field.size)
    return np.column_stack([1e6 * time, field, 1e3 * density])


def main():
    """Write the log."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out")
    parser.add_argument("--top", type=float, default=250.0, help="largest field [A/m]")
    arguments = parser.parse_args()
    np.savetxt(arguments.out, log(arguments.top), "%.6g", ",", header="time_us,H [A/m],B [mT]", comments="")


if __name__ == "__main__":
    main()
