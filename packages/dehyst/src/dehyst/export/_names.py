"""Checks names of exported units: valid identifiers of C and C++."""

from __future__ import annotations

import keyword
import re

from dehyst.errors import ParameterError
from dehyst.export.core_files import core_files


def identifier(text: str) -> str:
    """Return a C identifier that reads like the text.

    Examples
    --------
    >>> identifier("Gelenk 1 (links).json"), identifier("1st"), identifier("int")
    ('gelenk_1_links_json', 'unit_1st', 'unit_int')
    """
    word = _word(text)
    if word and word[0].isalpha() and not _reserved(word):
        return word
    return f"unit_{word}".rstrip("_")


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
    if _reserved(word):
        return f"'{word}' is a word of C, of its headers or of dehyst"
    return ""


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
    of_a_file = f"{word}.c" in core_files() or f"{word}.h" in core_files() or word in _PROGRAMS
    # The functions of every FMU begin with fmu and fmi.
    of_dehyst = word == "dehyst" or word.startswith(("dehyst_", "fmu", "fmi"))
    of_language = word in C_WORDS or word in HEADERS or keyword.iskeyword(word)
    return of_a_file or of_dehyst or of_language


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


def c_names(names: tuple[str, ...], in_use: tuple[str, ...]) -> tuple[str, ...]:
    """Return C names of further inputs: their own where all of them can have it, numbered ones otherwise."""
    words = tuple(map(identifier, names))
    in_step = {*in_use, "applied", "measured", "on", "self", "given", "values"}
    if len(set(words)) == len(words) and in_step.isdisjoint(words):
        return words
    return tuple(f"given_{k + 1}" for k in range(len(names)))
