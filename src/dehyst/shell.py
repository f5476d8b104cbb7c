"""Makes names from files printable on a terminal, and quotes words for each shell."""

from __future__ import annotations

import os
import re
import unicodedata
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
    if not _SPECIAL.search(text):
        return f'"{text}"'
    import shlex  # seldom needed, and `dehyst --help` has to be quick

    return shlex.quote(text)


def typed(words: Iterable[object]) -> str:
    """Return words as one line to type, each `quoted`.

    Examples
    --------
    >>> typed(["dehyst", "inspect", "my log.csv"])
    'dehyst inspect "my log.csv"'
    """
    return " ".join(map(quoted, words))


# Letters of Arabic, Persian and Indian scripts need the two joiners; a soft hyphen hides nothing.
HARMLESS = "\u00ad\u200c\u200d"
HIDDEN = frozenset(["Cc", "Cf", "Cs", "Cn", "Zl", "Zp"])
BREAKS = frozenset("\t\n\v\f\r\x85\u2028\u2029")


def visible(text: object) -> str:
    r"""Return text on one line, control characters and marks that turn the reading direction spelled out.

    A terminal obeys escape sequences, and marks of direction reorder the words around a name. A line break or a tab,
    with the white space around it, becomes one blank.

    Examples
    --------
    >>> visible("p\n[bar]"), visible("\x1b[31mangle\u202e")
    ('p [bar]', '\\x1b[31mangle\\u202e')
    """
    line = str(text)
    if line.isprintable():
        return line
    line = re.sub(r"\s+", lambda gap: gap[0] if BREAKS.isdisjoint(gap[0]) else " ", line)
    return "".join(_shown(letter) for letter in line)


def visible_lines(text: object) -> str:
    r"""Return text as `visible` does, its lines kept apart.

    Examples
    --------
    >>> visible_lines("a\nb\x07")
    'a\nb\\x07'
    """
    return "\n".join(map(visible, str(text).split("\n")))


def _shown(letter: str) -> str:
    if unicodedata.category(letter) not in HIDDEN or letter in HARMLESS:
        return letter
    return letter.encode("unicode_escape").decode("ascii")
