"""Text to words: comments are skipped, letters of keywords may be of either case."""

from __future__ import annotations

import re

from dehyst.export.iec.tree import TextError, Token

LONGEST_NAME = 32  # of older tools

_WORDS = re.compile(
    r"""(?P<skip>\s+|\(\*.*?\*\))
      | (?P<real>\d+\.\d+(?:[eE][+-]?\d+)?)
      | (?P<integer>\d+(?![A-Za-z_]))
      | (?P<name>\#?[A-Za-z_][A-Za-z0-9_]*|"[A-Za-z_][A-Za-z0-9_]*")
      | (?P<pragma>\{[^{}]*\})
      | (?P<sign>:=|<=|>=|<>|\.\.|[-+*/()\[\],;:=<>.])""",
    re.VERBOSE | re.DOTALL,
)


def words(text: str) -> list[Token]:
    """Split a text into tokens and end them with one of kind ``end``.

    Raises
    ------
    TextError
        If a character is not ASCII or belongs to no word, or a name is one that some tool refuses.

    Examples
    --------
    >>> [token.text for token in words("z[i] := 1.5E-3; (* a comment *)")][:-1]
    ['z', '[', 'i', ']', ':=', '1.5E-3', ';']
    """
    found: list[Token] = []
    position, line = 0, 1
    while position < len(text):
        match = _WORDS.match(text, position)
        if match is None or not match.group().isascii():
            raise TextError(f"{text[position : position + 20]!r} is no word of the language", line)
        kind, word = str(match.lastgroup), match.group()
        plain = word.strip('#"') if kind == "name" else word
        if kind == "name":
            _check_name(plain, line)
        if kind in ("integer", "real") and len(word) > LONGEST_NAME:
            raise TextError(f"{word[:20]}... has {len(word)} characters", line)
        if kind != "skip":
            found.append(Token(kind, plain, line, word[0] if plain != word else ""))
        line += word.count("\n")
        position = match.end()
    return [*found, Token("end", "end of the text", line)]


def _check_name(name: str, line: int) -> None:
    """Refuse what the standard or an older tool does not take as an identifier."""
    if len(name) > LONGEST_NAME:
        raise TextError(f"{name!r} has {len(name)} characters, older tools take {LONGEST_NAME}", line)
    if "__" in name or name.startswith("_") or name.endswith("_"):
        raise TextError(f"{name!r}: underscores must stand alone between letters or digits", line)
