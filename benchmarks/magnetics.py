"""Loss per cycle of measured B-H loops against their integral, and the errors of core models on them.

    python benchmarks/magnetics.py ../shared/data/magnet_3c90/sequences.npz [--jobs 2]

The file holds arrays B [T] and H [A/m], a row a sequence of 1000 samples at 16 MHz: 105 sequences of ferrite 3C90 at
25, 50 and 70 C of the MagNet Challenge 2. They have no licence and stay outside of the project. Prints the table of
docs/how-to/magnetic-cores.md. Status 1 if the loss errs by more than 2 % in the median.
"""

from __future__ import annotations

import argparse
import sys
import warnings
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np

from dehyst import DehystError, Recording
from dehyst_targets.magnetics import core_of, fit_core

RATE = 16e6  # samples a second
LIMIT = 0.02  # of the median error of the loss
MODELS = ("jiles-atherton", "pspice", "tellinen", "chan")


def measured(
    b: np.ndarray, h: np.ndarray
) -> tuple[float, dict[str, tuple[float, float, float]]] | None:
    """Return the error of the loss, and errors of each model in B, loss and smaller loops; None without a loop."""
    warnings.simplefilter("ignore")
    record = Recording(h, b, np.arange(b.size) / RATE, input_unit="A/m", output_unit="T")
    try:
        core = core_of(record)
        if not core.largest.closes:
            return None
        fits = fit_core(core)
    except DehystError:
        return None
    # The integral of the samples as they were logged, from turn to turn, closed by a straight line.
    areas = []
    for loop in core.loops.largest:
        rows = np.arange(
            np.ceil(loop.start * RATE - 1e-6), np.floor(loop.end * RATE + 1e-6) + 1.0
        ).astype(int)
        closed = np.append(rows, rows[0])
        areas.append(abs(float(np.trapezoid(h[closed], b[closed]))))
    errors = {name: (fit.error, fit.loss_error, fit.smaller_error) for name, fit in fits.items()}
    return core.loss / float(np.mean(areas)) - 1.0, errors


def row(name: str, values: np.ndarray) -> str:
    """Return a row of the table: median and 95th percentile of sizes, in percent."""
    cells = []
    for column in np.abs(values).T:
        finite = column[np.isfinite(column)]
        if finite.size:
            cells.append(f"{100 * np.median(finite):.2g} | {100 * np.percentile(finite, 95):.2g}")
        else:
            cells.append("- | -")
    return f"| {name} | {len(values)} | {' | '.join(cells)} |"


def main() -> int:
    """Run all sequences and print the tables."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("data", type=Path)
    parser.add_argument("--jobs", type=int, default=2)
    arguments = parser.parse_args()
    data = np.load(arguments.data)
    with ProcessPoolExecutor(arguments.jobs) as pool:
        results = list(pool.map(measured, data["B"], data["H"]))
    closed = [result for result in results if result is not None]
    losses = np.abs([loss for loss, _ in closed])
    print(f"{len(closed)} of {len(results)} sequences hold a loop that closes")
    numbers = [100 * np.median(losses), 100 * np.percentile(losses, 95), 100 * losses.max()]
    print(
        "loss against the integral: median {:.2g} %, 95th percentile {:.2g} %, largest {:.2g} %".format(
            *numbers
        )
    )
    for name in MODELS:
        print(row(name, np.array([errors[name] for _, errors in closed if name in errors])))
    return int(np.median(losses) > LIMIT)


if __name__ == "__main__":
    sys.exit(main())
