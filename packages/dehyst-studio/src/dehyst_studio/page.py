"""dehyst page: the page that fits a log in a browser, as one file to keep, mail, or put on a site."""

from __future__ import annotations

import sys
from importlib.resources import files

from dehyst.app import refuse_existing
from dehyst.files import write_atomically
from dehyst.shell import quoted
from dehyst_studio.requests import PageRequest


def run_page(request: PageRequest) -> None:
    """Write the page and say what to do with it."""
    text = (files("dehyst_studio") / "html" / "dehyst.html").read_text(encoding="utf-8")
    refuse_existing(request.out, request.overwrite, content=text)
    write_atomically(request.out, text)
    sys.stdout.write(
        f"wrote {request.out}: one file of {len(text.encode()) / 1000:.0f} kB, for any browser, with or without a "
        f"network\nnext: open {quoted(request.out)} in a browser and drop a log\n"
    )
