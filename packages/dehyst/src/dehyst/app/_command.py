"""A command of the command line: what runs it, and what it is asked with."""

from __future__ import annotations

from typing import Any, NamedTuple


class Command(NamedTuple):
    """A command of `dehyst`; packages add theirs by entry points of the group ``dehyst.commands``.

    Attributes
    ----------
    run
        ``module:function``, imported when the command is typed; called with a request.
    request
        Frozen dataclass of arguments and options (`dehyst.app.requests`); its docstring is the help.
    """

    run: str
    request: type[Any]

    @property
    def name(self) -> str:
        """Return what is typed: the name of the request without its last word, in small letters."""
        return self.request.__name__.removesuffix("Request").lower()
