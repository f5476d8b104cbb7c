"""One command of the studio in a process of its own: loads what takes long, waits for its words, and is that command.

Progress goes to the error stream, a line each, marked; everything else is what the command prints in a terminal.
"""

from __future__ import annotations

import json
import sys
import time

EVERY = 0.1  # s from one line of progress to the next within a stage


def main() -> None:
    """Wait for one line of JSON, the words of a command line; end at once if there is none."""
    from dehyst import cli, compare, identify
    from dehyst.app import Command, tell_progress
    from dehyst.app import kit as app_kit
    from dehyst.report import write_report
    from dehyst_studio.studio import SignalsRequest

    for prepared in (compare, identify, write_report):  # loaded by being named: the slow ones
        assert callable(prepared)

    line = sys.stdin.readline()
    if not line:
        return
    last = "", 0.0

    def report(stage: str, fraction: float, of: float | None) -> None:
        nonlocal last
        now = time.monotonic()
        if stage != last[0] or now - last[1] > EVERY or fraction == of:
            last = stage, now
            sys.stderr.write(
                f"{app_kit.MARK}{json.dumps({'stage': stage, 'done': fraction, 'of': of})}\n"
            )
            sys.stderr.flush()

    tell_progress(report)
    cli.add(Command("dehyst_studio.studio._signals:print_signals", SignalsRequest))
    sys.argv = ["dehyst", *json.loads(line)]
    cli.main()


if __name__ == "__main__":
    main()
