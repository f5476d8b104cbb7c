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
    import dehyst.app.compare
    import dehyst.app.identify
    import dehyst.families
    import dehyst.report.fit  # noqa: F401 - the slow ones
    from dehyst import cli
    from dehyst.app import terminal
    from dehyst.app.command import Command
    from dehyst.app.studio.commands import SignalsRequest

    line = sys.stdin.readline()
    if not line:
        return
    last = "", 0.0

    def told(stage: str, done: float, of: float | None) -> None:
        nonlocal last
        now = time.monotonic()
        if stage != last[0] or now - last[1] > EVERY or done == of:
            last = stage, now
            sys.stderr.write(f"{terminal.MARK}{json.dumps({'stage': stage, 'done': done, 'of': of})}\n")
            sys.stderr.flush()

    terminal.tell_progress(told)
    cli.add(Command("dehyst.app.studio.signals:print_signals", SignalsRequest))
    sys.argv = ["dehyst", *json.loads(line)]
    cli.main()


if __name__ == "__main__":
    main()
