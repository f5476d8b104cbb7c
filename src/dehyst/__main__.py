"""The command ``dehyst``, also as ``python -m dehyst``: it begins here, so that Ctrl-C ends it well at any moment."""

from __future__ import annotations

import sys


def main() -> None:
    """Run the command line; ends the process with the status of how it went."""
    try:
        from dehyst.app.interrupt import heed, let_go

        heed()
        from dehyst.cli import main as command

        try:
            command()
        finally:
            let_go()
    except KeyboardInterrupt:  # before anything heeded it
        sys.stderr.write("stopped\n")
        sys.exit(130)


if __name__ == "__main__":
    main()
