"""Text of others (names of columns, units, files, runs) made fit to be shown: nothing in it is hidden or obeyed."""

from __future__ import annotations

import re
import unicodedata

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
