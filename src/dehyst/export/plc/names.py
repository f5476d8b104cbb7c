"""Names that every tool takes."""

from __future__ import annotations

from dehyst.export.iec.lexer import LONGEST_NAME
from dehyst.export.iec.reserved import RESERVED

_LONGEST_ENDING = len("_Example")


def type_name(name: str, taken: set[str]) -> str:
    """Return the name of the function block's type: the C identifier in the writing of PLC programmers.

    Parameters
    ----------
    name
        C identifier: small letters, digits, single underscores.
    taken
        Names of variables inside the units, in small letters; case does not count in Structured Text.

    Returns
    -------
    name
        Short enough that the names of example and test program fit the 32 characters of older tools, and no word that
        IEC 61131-3 or a vendor keeps for itself.

    Examples
    --------
    >>> type_name("elbow_inverse", set()), type_name("limit", set())
    ('ElbowInverse', 'LimitBlock')
    """
    word = "".join(part[0].upper() + part[1:] for part in name.split("_") if part)
    word = word[: LONGEST_NAME - _LONGEST_ENDING]
    if word.upper() in RESERVED or word.lower() in taken:
        word = word[: LONGEST_NAME - _LONGEST_ENDING - len("Block")] + "Block"
    return word
