"""Structured Text against the core: random models, random samples, in all three forms, run by the own checker.

    python benchmarks/structured_text.py              # 1000 models x 1000 samples, LREAL and REAL
    python benchmarks/structured_text.py --models 50  # fewer

LREAL must have the bits of the extension, flags included; REAL must be within 1e-5 of the output's range. Ends with
status 1 otherwise. No PLC and no compiler of Structured Text takes part: see docs/how-to/run-on-a-plc.md.
"""

from __future__ import annotations

import argparse
import time

import numpy as np
from target.random_blocks import Trial, trials

from dehyst.export import Signal
from dehyst_targets.iec import load_program
from dehyst_targets.st import Ports, function_block, plcopen_xml, siemens_scl, structured_text
from dehyst_targets.st._pou import st_text
from dehyst_targets.st._verification import run_blocks

WORDS = {"input": "", "output": "", "about": ""}
FORMS = (
    structured_text,
    siemens_scl,
    lambda unit: st_text(plcopen_xml("P", (unit,), "1", "2000-01-01T00:00:00", "0")),
)


def answers(trial: Trial, number: int) -> tuple[np.ndarray, np.ndarray, Signal]:
    """Return outputs and flags of the text, and what the extension says."""
    outputs, flags = trial.expected()
    signal = Signal(
        trial.case.x[:, None],
        trial.case.on.astype(int),
        outputs[:, None],
        flags.astype(int),
        ("x",),
        ("y",),
    )
    real = "LREAL" if trial.real == "double" else "REAL"
    unit = function_block("Unit1", real, trial.case.block, WORDS)
    found, seen = run_blocks(
        load_program(FORMS[number % 3](unit)).new("Unit1"), Ports.of(unit), signal
    )
    return found, seen, signal


def measure(models: int, samples: int, real: str) -> bool:
    """Print one line and return whether it is good."""
    begin = time.perf_counter()
    different, worst, limited, rejected = 0, 0.0, 0, 0
    for number, trial in enumerate(trials(models, samples, real)):
        found, seen, signal = answers(trial, number)
        bits = (found.view(np.uint64) == signal.outputs.view(np.uint64))[:, 0] & (
            seen == signal.flags
        )
        different += int(np.sum(~bits))
        worst = max(worst, float(np.max(np.abs(found - signal.outputs))) / trial.range())
        limited += int(np.sum(signal.flags & 4 > 0))
        rejected += int(np.sum(signal.flags & 1))
    signals = f"{models} models x {samples} samples, {limited} limited, {rejected} rejected"
    seconds = f"({time.perf_counter() - begin:.0f} s)"
    if real == "double":
        print(f"LREAL: {signals}: {different} outputs or flags differ in a bit  {seconds}")
        return different == 0
    print(f"REAL:  {signals}: largest error {worst:.1e} of the range  {seconds}")
    return worst <= 1e-5


def main() -> int:
    """Parse, measure, print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--models", type=int, default=1000)
    parser.add_argument("--samples", type=int, default=1000)
    arguments = parser.parse_args()
    good = [measure(arguments.models, arguments.samples, real) for real in ("double", "float")]
    return 0 if all(good) else 1


if __name__ == "__main__":
    raise SystemExit(main())
