"""Names of function blocks: what Structured Text and its tools allow."""

from __future__ import annotations

from dehyst.errors import ParameterError
from dehyst_targets.iec import LONGEST_NAME, RESERVED

_LONGEST_ENDING = len("_Example")


def type_name(name: str, reserved: set[str]) -> str:
    """Return the name of the function block's type: the C identifier in the writing of PLC programmers.

    Parameters
    ----------
    name
        C identifier: small letters, digits, single underscores.
    reserved
        Names of variables inside the units, in small letters; case does not count in Structured Text.

    Returns
    -------
    name
        Short enough that the names of example and test fit the 32 characters of older tools, and none of `RESERVED`.

    Examples
    --------
    >>> type_name("elbow_inverse", set()), type_name("limit", set())
    ('ElbowInverse', 'LimitBlock')
    """
    word = _type_word(name)
    # Tools confuse a block with a word of the language or a variable inside it of the same name.
    if word.upper() in RESERVED or word.lower() in reserved:
        word = word[: LONGEST_NAME - _LONGEST_ENDING - len("Block")] + "Block"
    return word


def _type_word(name: str) -> str:
    word = "".join(part[0].upper() + part[1:] for part in name.split("_") if part)
    return word[: LONGEST_NAME - _LONGEST_ENDING]


def check_type_name(name: str, reserved: set[str]) -> None:
    """Refuse a name of the user's own of which `type_name` would make another."""
    word = _type_word(name)
    if type_name(name, reserved) != word:
        raise ParameterError(
            f"--name {name!r:.60} is taken: the function block would be {word}, and that is a word or block of "
            f"IEC 61131-3, of a library (matiec, CODESYS, TwinCAT, OSCAT, Siemens) or a variable of its own, with "
            f"which tools confuse it. Choose another: --name {name[:40]}_block.",
            name=name,
        )
