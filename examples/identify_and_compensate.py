"""From a log to a checked compensator, in one page of Python.

Run it with a log and its two columns, or without arguments on the example log:

    python examples/identify_and_compensate.py
    python examples/identify_and_compensate.py log.csv pressure_bar angle_deg
"""

import sys
import tempfile
from pathlib import Path

import numpy as np

import dehyst
from dehyst.io import write_example


def main(log: Path, input: str, output: str) -> None:
    """Read a log, identify, invert, check, save."""
    rec = dehyst.read_log(log, input=input, output=output)
    fit = dehyst.identify(rec)
    print(fit.verdict)
    for warning in fit.warnings:
        print(f"warning {warning.code}: {warning.message}")

    # A motion that was not logged: two loops that shrink, within the identified range.
    low, high = fit.model.card.output.low, fit.model.card.output.high
    phase = np.linspace(0.0, 4.0 * np.pi, 2001)
    wanted = 0.5 * (low + high) + 0.45 * (high - low) * np.linspace(1.0, 0.3, phase.size) * np.sin(phase)

    # The check of the algebra: the model answers the computed input with the wanted motion.
    inverse = fit.model.inverse()
    time = np.linspace(0.0, 20.0, phase.size)  # [s]; models with creep or rate need it, others do without
    needed = inverse.simulate(wanted, time)
    answered = fit.model.simulate(needed, time)
    miss = np.max(np.abs(answered - wanted))
    print(f"largest difference between model(inverse(wanted)) and wanted: {miss:.0e} {rec.output_unit}")

    # The check against the rig: the input that was applied, from the output that was measured.
    asked = inverse.simulate(rec.output, rec.time)
    share = np.sqrt(np.mean((asked - rec.input) ** 2)) / np.ptp(rec.input)
    print(f"the inverse asks for the applied input within {100 * share:.2f} % of its range (rms)")

    model_file = fit.model.save(Path(tempfile.mkdtemp()) / "model.json")
    again = dehyst.load(model_file)
    print(f"saved and read back, same output: {np.array_equal(again.simulate(needed, time), answered)}")


if __name__ == "__main__":
    if len(sys.argv) == 4:
        main(Path(sys.argv[1]), sys.argv[2], sys.argv[3])
    else:
        main(write_example(Path(tempfile.mkdtemp()) / "example.csv"), "pressure_difference_bar", "angle_deg")
