"""A stand-in for an actuator with a butterfly loop: writes a log of field and strain.

    python examples/simulators/butterfly.py log.csv [--rod] [--apply compensated.csv]

A ferroelectric is a crowd of relays (Preisach), S = Q P^2 + d P. A magnetostrictive rod follows Jiles and Atherton,
S = a M^2 - b M^4. `--apply` gives it computed fields, after one cycle over the whole range that ends at the top.
"""

import argparse

import numpy as np

from dehyst.io import read_signal, write_csv

STEP, TOP = 0.01, 2.0  # s, kV/mm


def drive(seconds=32.0):
    """Sines of 1 Hz, twice: about zero, smaller and smaller; then poled, between a third below zero and the top."""
    time = np.arange(0.0, seconds, STEP)
    part = 4.0 * (time % (0.5 * seconds)) / seconds
    size = np.interp(part, [0.0, 0.4, 1.0, 1.1, 1.2, 2.0], [1.0, 1.0, 0.35, 1.0, 0.65, 0.1])
    middle = np.interp(part, [1.1, 1.2, 2.0], [0.0, 0.35, 0.4])
    return time, TOP * (middle + size * np.sin(2.0 * np.pi * time))


def ferroelectric(field, coercive=0.8, spread=0.25, imprint=0.0, linear=0.08):
    """Strain [%] of relays that switch at random fields, and of what is reversible."""
    random = np.random.default_rng(7)
    half = np.abs(random.normal(coercive, spread, 4000))
    middle = random.normal(imprint, 0.2, half.size)
    state, polarisation = -np.ones(half.size), np.empty(field.size)
    for k, value in enumerate(field.tolist()):
        state[value >= middle + half], state[value <= middle - half] = 1.0, -1.0
        polarisation[k] = state.mean() + 0.06 * value
    return 0.1 * (polarisation**2 + linear * polarisation)


def rod(field, bias=0.2, shape=0.24, pinning=0.5, coupling=0.1, reversible=0.15):
    """Strain [%] of a magnetisation after Jiles and Atherton, in small steps of the field."""
    h, irreversible, total = 0.0, 0.0, 0.0
    strain = np.empty(field.size)
    for k, value in enumerate((field + bias).tolist()):
        change = (value - h) / 20.0
        for _ in range(20):
            h += change
            x = (h + coupling * total) / shape
            anhysteretic = x / 3.0 if abs(x) < 1e-3 else 1.0 / np.tanh(x) - 1.0 / x
            gap = anhysteretic - irreversible
            if gap * change > 0.0:
                irreversible += abs(change) * abs(gap) / (pinning - coupling * abs(gap)) * np.sign(gap)
            total = reversible * anhysteretic + (1.0 - reversible) * irreversible
        strain[k] = 0.1 * (total**2 - 0.15 * total**4)
    return strain


def main():
    """Write the log that was asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("log")
    parser.add_argument("--rod", action="store_true", help="a magnetostrictive rod")
    parser.add_argument("--apply", metavar="FIELDS", help="log with the field to apply")
    options = parser.parse_args()
    (time, field), poling = drive(), np.zeros(0)
    if options.apply:
        signal = read_signal(options.apply, "compensated_field")
        time, field, poling = signal.time, signal.values, TOP * np.sin(np.linspace(0.0, 2.5 * np.pi, 300))
    strain = (rod if options.rod else ferroelectric)(np.append(poling, field))[poling.size :]
    strain += np.random.default_rng(1).normal(0.0, 0.003 * np.ptp(strain), strain.size)
    write_csv(options.log, {"time [s]": time, "field [kV/mm]": field, "strain [%]": strain})


if __name__ == "__main__":
    main()
