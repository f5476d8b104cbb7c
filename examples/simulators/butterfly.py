"""A stand-in for an actuator with a butterfly loop: writes a log of field and strain.

    python examples/simulators/butterfly.py log.csv [--rod]
    python examples/simulators/butterfly.py answer.csv --apply compensated.csv   # what it does with computed fields

A ferroelectric is a crowd of relays (Preisach), S = Q P^2 + d P. A magnetostrictive rod follows Jiles and Atherton,
S = a M^2 - b M^4. Before `--apply` the field goes over its range and comes down from the top: the actuator is poled.
"""

import argparse

import numpy as np

from dehyst.io import read_signal, write_csv

STEP = 0.01  # s
TOP = 2.0  # kV/mm


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
    state = -np.ones(half.size)
    polarisation = np.empty(field.size)
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
            gap, way = anhysteretic - irreversible, np.sign(change)
            if gap * way > 0.0:
                irreversible += change * gap / (way * pinning - coupling * gap)
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
    time, field = drive()
    poling = np.zeros(0)
    if options.apply:
        signal = read_signal(options.apply, "compensated_field")
        time, field = signal.time, signal.values
        poling = TOP * np.sin(np.linspace(0.0, 2.5 * np.pi, 300))
    strain = (rod if options.rod else ferroelectric)(np.append(poling, field))[poling.size :]
    strain += np.random.default_rng(1).normal(0.0, 0.003 * np.ptp(strain), strain.size)
    write_csv(options.log, {"time [s]": time, "field [kV/mm]": field, "strain [%]": strain})


if __name__ == "__main__":
    main()
