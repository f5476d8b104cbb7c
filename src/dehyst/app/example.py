"""dehyst example: a log to try things on."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path

from dehyst.experiments import write_example


def run_example(out: Path, seed: int) -> None:
    """Write the example log and say what to type next."""
    write_example(out, seed)
    quoted = shlex.quote(str(out))
    sys.stdout.write(
        f"wrote {out}: a simulated joint, pressure difference [bar] -> angle [deg], 12 loops\n"
        f"next: dehyst identify {quoted} --input pressure_difference_bar --output angle_deg "
        f"--save model.json --report report.html\n"
    )
