"""A stand-in for a machine and its gauge: runs the program of `dehyst backlash plan`, fills in the sheet.

    python examples/backlash_axis.py plan.ngc measure.csv                      # without compensation
    python examples/backlash_axis.py plan.ngc again.csv tables/x.comp          # with a table of LinuxCNC

The axis has a play of 0.03 mm at one end and 0.05 mm at the other, a pitch error, and a gauge that reads to 0.001 mm.
"""

import csv
import re
import sys
from pathlib import Path

import numpy as np

from dehyst_targets.backlash import Compensation, read_compensation

NOISE = 0.0008  # mm, standard deviation of a reading


def play(position):
    """Width of the play at a position. [mm]"""
    return 0.03 + 0.02 * position / 300.0


def pitch(position):
    """Error of the screw at a position. [mm]"""
    return 0.012 * np.sin(2.0 * np.pi * position / 220.0) + 4e-5 * position


def run(program, compensation):
    """Run a program; return what the gauge shows at each dwell. [mm]"""
    # Another run has other noise.
    noise = np.random.default_rng(7 if compensation is None else 8)
    command, nut, shown = 0.0, 0.0, []
    for line in program.splitlines():
        move = re.search(r"\bG1 X(-?[\d.]+)", line)
        if move:
            target = float(move[1])
            motor = target
            if compensation is not None:
                motor += float(compensation.added(np.array([target]), rising=target > command)[0])
            # The motor pushes the nut where the play ends, and leaves it where it is within the play.
            half = 0.5 * play(motor)
            nut, command = float(np.clip(nut, motor - half, motor + half)), target
        elif line.startswith("G4"):
            shown.append(round(nut + pitch(nut) + noise.normal(0.0, NOISE), 3))
    return shown


def main(program, sheet, table=None):
    """Run a program and fill its readings into the last column of a sheet."""
    compensation: Compensation | None = None
    if table is not None:
        compensation = read_compensation(Path(table).read_text(encoding="utf-8"), "linuxcnc")
    shown = run(Path(program).read_text(encoding="utf-8"), compensation)
    head, *rows = csv.reader(Path(sheet).read_text(encoding="utf-8").splitlines())
    with Path(sheet).open("w", newline="", encoding="utf-8") as stream:
        csv.writer(stream, lineterminator="\n").writerows(
            [head, *([*row[:-1], value] for row, value in zip(rows, shown, strict=True))]
        )
    print(f"{len(shown)} readings written into {sheet}")


if __name__ == "__main__":
    main(*sys.argv[1:])
