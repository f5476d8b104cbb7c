"""Checks names of exported units: valid identifiers of C, C++ and Structured Text."""

from __future__ import annotations

import keyword
import re

from dehyst.errors import ParameterError
from dehyst.export.core_files import core_files
from dehyst.export.iec.reserved import LONGEST_NAME, RESERVED


def identifier(text: str) -> str:
    """Return a C identifier that reads like the text.

    Examples
    --------
    >>> identifier("Gelenk 1 (links).json"), identifier("1st"), identifier("int")
    ('gelenk_1_links_json', 'unit_1st', 'unit_int')
    """
    word = _word(text)
    return word if word and word[0].isalpha() and not _reserved(word) else f"unit_{word}".rstrip("_")


def why_prefixed(text: str) -> str:
    """Return why `identifier` puts unit_ in front of this text; "" if it does not.

    Examples
    --------
    >>> why_prefixed("math"), why_prefixed("1st"), why_prefixed("elbow")
    ("'math' is a word of C, of its headers or of dehyst", "'1st' does not begin with a letter", '')
    """
    word = _word(text)
    if not word or not word[0].isalpha():
        return f"'{word}' does not begin with a letter"
    return f"'{word}' is a word of C, of its headers or of dehyst" if _reserved(word) else ""


def _word(text: str) -> str:
    return re.sub(r"[^a-z0-9]+", "_", text.lower()).strip("_")[:40].rstrip("_")


_WORDS = """
auto break case char const continue default do double else enum extern float for goto if inline int long register
restrict return short signed sizeof static struct switch typedef union unsigned void volatile while bool class delete
explicit export false friend mutable namespace new operator private protected public template this throw true try
typename using virtual main std asm and or not xor bitand bitor compl linux unix near far
"""
C_WORDS = frozenset(_WORDS.split())


_HEADERS = """
assert complex ctype errno fenv float inttypes iso646 limits locale math memory setjmp signal stdalign stdarg
stdatomic stdbool stddef stdint stdio stdlib stdnoreturn string strings tgmath threads time uchar wchar wctype
malloc unistd windows arduino simstruc
"""
HEADERS = frozenset(_HEADERS.split())  # a unit of that name would be found in their place
_PROGRAMS = ("check", "check_main", "example_main", "expected")


def _reserved(word: str) -> bool:
    """Words of C, C++ and the core, whose files lie beside those of the unit; and those of its own programs."""
    taken = f"{word}.c" in core_files() or f"{word}.h" in core_files() or word in _PROGRAMS
    ours = word == "dehyst" or word.startswith(("dehyst_", "fmu", "fmi"))
    return ours or taken or word in C_WORDS or word in HEADERS or keyword.iskeyword(word)


def check_name(name: str) -> str:
    """Return the name, or refuse it."""
    if re.fullmatch(r"[a-z_0-9]+", name) and _reserved(name):
        raise ParameterError(
            f"--name {name!r:.60} is taken: it is a word of C or the name of a file that lies beside those of the "
            f"unit, or of a header that would be found in its place. Choose another: --name {identifier(name)}.",
            name=name,
        )
    if not re.fullmatch(r"[a-z][a-z0-9]*(_[a-z0-9]+)*", name) or len(name) > 48:
        raise ParameterError(
            f"--name {name!r:.60} cannot be the name of C functions; use small letters, digits and single underscores, "
            f"a letter first, 48 at most, for example --name {identifier(name)}.",
            name=name,
        )
    return name


def c_names(names: tuple[str, ...], taken: tuple[str, ...]) -> tuple[str, ...]:
    """C names of further inputs: their own where that is possible."""
    words = [identifier(name) for name in names]
    plain = len(set(words)) == len(words) and not set(words) & {*taken, "measured", "on", "self", "given", "values"}
    return tuple(words) if plain else tuple(f"given_{k + 1}" for k in range(len(names)))


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
        Short enough that the names of example and test fit the 32 characters of older tools, and none of `RESERVED`.

    Examples
    --------
    >>> type_name("elbow_inverse", set()), type_name("limit", set())
    ('ElbowInverse', 'LimitBlock')
    """
    word = _type_word(name)
    if word.upper() in RESERVED or word.lower() in taken:
        word = word[: LONGEST_NAME - _LONGEST_ENDING - len("Block")] + "Block"
    return word


def _type_word(name: str) -> str:
    return "".join(part[0].upper() + part[1:] for part in name.split("_") if part)[: LONGEST_NAME - _LONGEST_ENDING]


def check_type_name(name: str, taken: set[str]) -> None:
    """Refuse a name of the user's own of which `type_name` would make another."""
    word = _type_word(name)
    if type_name(name, taken) != word:
        raise ParameterError(
            f"--name {name!r:.60} is taken: the function block would be {word}, and that is a word or block of "
            f"IEC 61131-3, of a library (matiec, CODESYS, TwinCAT, OSCAT, Siemens) or a variable of its own, with "
            f"which tools confuse it. Choose another: --name {name[:40]}_block.",
            name=name,
        )
