"""The command ``dehyst``, also as ``python -m dehyst``; Ctrl-C is handled from the first import on."""

import _signal  # type: ignore[import-not-found]  # part of the interpreter; `signal` would have to be loaded
import gc
import os


def _end(*_: object) -> None:
    """Answer Ctrl-C while the command is being loaded, when there is nothing to finish."""
    try:
        os.write(2, b"stopped\n")
    finally:
        os._exit(130)


if _signal.getsignal(_signal.SIGINT) is _signal.default_int_handler:
    _signal.signal(_signal.SIGINT, _end)


def main() -> None:
    """Run the command line; ends the process with the status of how it went."""
    gc.disable()  # what is loaded stays: a command looks for garbage from its beginning on
    from dehyst.app import heed, let_go

    heed(_end)
    from dehyst.cli import main as command

    try:
        command()
    finally:
        let_go()


if __name__ == "__main__":
    main()
