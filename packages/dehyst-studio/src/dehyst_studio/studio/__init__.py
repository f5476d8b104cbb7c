"""dehyst studio: the page in a browser, with all of dehyst behind it, on this machine alone."""

from __future__ import annotations

import os
import secrets
import shutil
import socket
import sys
import tempfile
import webbrowser
from importlib.util import find_spec
from pathlib import Path

from dehyst.app import tell
from dehyst.errors import LogError, MissingExtraError, OutputError
from dehyst_studio.requests import StudioRequest
from dehyst_studio.studio._commands import SignalsRequest as SignalsRequest
from dehyst_studio.studio._guard import HOST


def run_studio(request: StudioRequest) -> None:
    """Bind, print the address, open the browser, serve until Ctrl-C or until no page was open for a while."""
    if find_spec("starlette") is None or find_spec("uvicorn") is None:
        raise MissingExtraError(
            "dehyst studio serves its page with starlette and uvicorn, which are not installed. Type: pip install "
            "dehyst-studio. Without them: the page alone, opened from disk, and every command of the terminal."
        )
    if request.log is not None and not request.log.is_file():
        raise LogError(
            f"there is no log '{request.log}'. Name a file, or leave it out and drop one on the page."
        )
    from dehyst_studio.studio._server import serve

    token, key, listener = (
        secrets.token_urlsafe(32),
        secrets.token_urlsafe(32),
        _bound(request.port),
    )
    folder = Path(tempfile.mkdtemp(prefix="dehyst-studio-"))
    address = f"http://{HOST}:{listener.getsockname()[1]}/"
    try:
        sys.stdout.write(f"dehyst studio: {address}#studio={token}\n")
        sys.stdout.write("Only you, on this machine, can use it. Ctrl-C ends it.\n")
        sys.stdout.flush()
        if request.browser:
            # Every user of a machine sees the words of a command line: those of the browser hold what opens one page.
            _open(f"{address}#once={key}")
        serve(listener, token, folder, key=key, log=request.log, idle=60.0 * request.idle)
    except KeyboardInterrupt:
        pass
    finally:
        listener.close()
        shutil.rmtree(folder, ignore_errors=True)
    tell("the studio has ended; its temporary files are removed")


def _bound(port: int) -> socket.socket:
    """A socket that waits for connections of this machine; the system chooses the port if it is 0."""
    listener = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    try:
        listener.bind((HOST, port))
    except (OSError, OverflowError) as fault:
        listener.close()
        reason = getattr(fault, "strerror", None) or fault
        raise OutputError(
            f"port {port} of {HOST} cannot be used: {reason}. Leave --port out, and a free one is taken.",
            port=port,
        ) from None
    listener.listen(128)  # from now on: a browser that is quick waits instead of being refused
    return listener


def _open(address: str) -> None:
    """Open a browser that has a window; one in the terminal would take the terminal away."""
    if sys.platform.startswith("linux") and not (
        os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    ):
        tell("there is no screen here: open the address above yourself")
    elif not webbrowser.open(address):
        tell("no browser could be started: open the address above yourself")
