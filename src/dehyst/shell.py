"""Words of a command line that mean the same in POSIX shells, in PowerShell and in cmd.exe."""

from __future__ import annotations

import os
import re
import shlex
from collections.abc import Iterable

# What no shell takes for anything but itself. A comma makes a list in PowerShell, # begins a comment, ~ is the home.
_PLAIN = re.compile(r"[A-Za-z0-9_./:+-][A-Za-z0-9_./:=+-]*")
# What some shell takes for something else even between double quotes.
_SPECIAL = re.compile(r'["$`!\\]')


def quoted(word: object) -> str:
    r"""Return a word as it is typed into a shell, so that it arrives as it is.

    Double quotes work in all shells; only for what one of them reads between double quotes too (``" $ ` ! \``) there is
    no common form, and the one of this platform is taken.

    Examples
    --------
    >>> quoted("angle_deg"), quoted("angle [deg]"), quoted("it's"), quoted("pi,stop")
    ('angle_deg', '"angle [deg]"', '"it\'s"', '"pi,stop"')
    """
    text = str(word)
    if os.name == "nt":
        if _PLAIN.fullmatch(text.replace("\\", "/")):
            return text
        text = re.sub(r'(\\*)"', r'\1\1\\"', text)  # as programs on Windows take their command line apart
        return '"' + re.sub(r"\\+$", r"\g<0>\g<0>", text) + '"'
    if _PLAIN.fullmatch(text):
        return text
    return shlex.quote(text) if _SPECIAL.search(text) else f'"{text}"'


def typed(words: Iterable[object]) -> str:
    """Return words as one line to type, each `quoted`.

    Examples
    --------
    >>> typed(["dehyst", "inspect", "my log.csv"])
    'dehyst inspect "my log.csv"'
    """
    return " ".join(map(quoted, words))
