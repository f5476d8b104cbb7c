"""A stand-in for a rig with two instruments: writes the voltage to one file and the position to another.

    python examples/two_instruments.py u.csv y.csv

The second instrument is started 2.314 s later, samples at another rate, and its clock is 120 ppm slow.
"""

import argparse

import numpy as np

import dehyst

BEGIN, DRIFT = 2.314, 120e-6  # s, 1


def motion(t):
    """Voltage of swings that differ. [V]"""
    return 60.0 + (45.0 + 15.0 * np.sin(0.13 * t + 0.9)) * np.sin(1.05 * t) + 10.0 * np.sin(0.31 * t)


def main():
    """Write both logs."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("voltage")
    parser.add_argument("position")
    options = parser.parse_args()
    rng = np.random.default_rng(3)
    actuator = dehyst.PrandtlIshlinskii([0.0, 4.0, 10.0, 20.0, 35.0], [0.12, 0.12, 0.12, 0.1, 0.08])
    fine = np.arange(0.0, 95.0, 1e-3)
    position = actuator.simulate(motion(fine))
    t = 0.01 * np.arange(9000)
    u = motion(t) + 0.05 * rng.standard_normal(t.size)
    stamps = 0.004 * np.arange(20000)
    y = np.interp(BEGIN + (1.0 + DRIFT) * stamps, fine, position) + 0.03 * rng.standard_normal(stamps.size)
    for path, columns, header in (
        (options.voltage, (t, u), "time_s,voltage_V"),
        (options.position, (stamps, y), "time_s,position_um"),
    ):
        np.savetxt(path, np.column_stack(columns), delimiter=",", comments="", fmt="%.7g", header=header)
    print(
        f"{options.voltage}: {t.size} samples from 0 s on, "
        f"{options.position}: {stamps.size} samples from {BEGIN:g} s on"
    )


if __name__ == "__main__":
    main()
