"""dehyst example: a log to try things on."""

from __future__ import annotations

import sys
from pathlib import Path

from dehyst.app.targets import refuse_existing
from dehyst.files import write_atomically
from dehyst.robot.experiments import example_csv
from dehyst.shell import quoted


def run_example(out: Path, seed: int, overwrite: bool = False) -> None:
    """Write the example log and say what to type next."""
    text = example_csv(seed)
    refuse_existing(out, overwrite, content=text)
    write_atomically(out, text)
    sys.stdout.write(
        f"wrote {out}: a simulated joint, pressure difference [bar] -> angle [deg], 12 loops\n"
        f"next: dehyst identify {quoted(out)} --input pressure_difference_bar --output angle_deg "
        f"--save model.json --report report.html\n"
    )
