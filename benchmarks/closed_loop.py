"""How much worse a fit is of a log that was taken in closed loop, against the same motion in open loop.

    python benchmarks/closed_loop.py [--out docs/generate/closed_loop.csv]

A servo follows a reference with a proportional and integral controller; its actuator is a sum of plays, its measurement
has noise that lasts 0.05 s, so that the command answers to noise that is still there. The open-loop log has the command
of the same servo without noise. Both are fitted by `dehyst.identify(log, "pi", n=20)` and scored on a motion without
noise. docs/build.py makes the table of docs/how-to/valves.md from the file. Status 1 if a closed loop is not found.
"""

from __future__ import annotations

import argparse
import csv
import itertools
import math
import sys
import tempfile
import warnings
from pathlib import Path

import numpy as np

import dehyst
from dehyst.io import read_log, write_csv

OUT = Path(__file__).parents[1] / "docs" / "generate" / "closed_loop.csv"
COLUMNS = ("reference", "noise", "controller", "seed", "from_noise", "closed_error", "open_error", "closed_gain",
           "open_gain", "warned")  # fmt: skip
STEP, SAMPLES, LASTS = 0.01, 6000, 0.05
PLAYS = ((0.0, 1.0), (0.5, 0.4), (1.0, 0.3), (2.0, 0.2))  # threshold, weight
CONTROLLERS = {"Kp 0.1, Ki 20/s": (0.1, 0.2), "Kp 0.3, Ki 2/s": (0.3, 0.02)}  # Ki times the step


def noise_of(level, seed):
    """Return noise of a standard deviation that lasts LASTS seconds, and a little white one."""
    rng = np.random.default_rng(seed)
    memory = math.exp(-STEP / LASTS)
    values, pushes = (
        np.zeros(SAMPLES),
        level * math.sqrt(1.0 - memory**2) * rng.normal(size=SAMPLES),
    )
    for k in range(1, SAMPLES):
        values[k] = memory * values[k - 1] + pushes[k]
    return values + 0.1 * level * rng.normal(size=SAMPLES)


def servo(reference, noise, controller):
    """Return command and measurement of a servo."""
    proportional, integral = CONTROLLERS[controller]
    states = [0.0] * len(PLAYS)
    command = total = 0.0
    commands, measured = np.empty(SAMPLES), np.empty(SAMPLES)
    for k in range(SAMPLES):
        answer = 0.0
        for j, (threshold, weight) in enumerate(PLAYS):
            states[j] = min(max(states[j], command - threshold), command + threshold)
            answer += weight * states[j]
        commands[k], measured[k] = command, answer + noise[k]
        error = reference[k] - measured[k]
        total += integral * error
        command = proportional * error + total
    return commands, measured


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--out", type=Path, default=OUT)
    options = parser.parse_args()
    warnings.simplefilter("ignore", UserWarning)
    time = STEP * np.arange(SAMPLES)
    shape = 4.0 * np.sin(0.2 * np.pi * time) * (1.0 - 0.6 * time / time[-1]) + np.sin(
        0.74 * np.pi * time
    )
    rows, missed = [], 0
    for amplitude, level, controller, seed in itertools.product(
        (1.0, 0.25), (0.03, 0.1, 0.3), CONTROLLERS, (1, 2, 3)
    ):
        reference, noise = amplitude * shape, noise_of(level, seed)
        command, measured = servo(reference, noise, controller)
        quiet, still = servo(reference, np.zeros(SAMPLES), controller)
        path = Path(tempfile.mkdtemp()) / "log.csv"
        write_csv(
            path,
            {
                "time_s": time,
                "reference_mm": reference,
                "command_V": command,
                "measured_mm": measured,
            },
        )
        closed = read_log(path, "command", "measured")
        warned = "closed-loop" in {finding.code for finding in closed.findings}
        missed += not warned
        planned = dehyst.Recording(
            quiet, still + noise_of(level, seed + 100), time, input_unit="V", output_unit="mm"
        )
        figures = []
        for log in (closed, planned):
            answer = dehyst.identify(log, "pi", n=20).model.simulate(quiet)
            # The level is not the question, and the start is not known.
            late = slice(1000, None)
            left = (answer - still)[late]
            figures.append(
                (
                    100.0 * left.std() / np.ptp(still[late]),
                    np.polyfit(still[late], answer[late], 1)[0],
                )
            )
        share = float(np.var(command - quiet) / np.var(command))
        numbers = (share, figures[0][0], figures[1][0], figures[0][1], figures[1][1])
        rows.append(
            (
                amplitude,
                level,
                controller,
                seed,
                *(f"{number:.4f}" for number in numbers),
                int(warned),
            )
        )
        print(*rows[-1], flush=True)
    with options.out.open("w", encoding="utf-8", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows([COLUMNS, *rows])
    return int(missed > 0)


if __name__ == "__main__":
    sys.exit(main())
