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
        text = re.sub(
            r'(\\*)"', r'\1\1\\"', text
        )  # as programs on Windows take their command line apart
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


def command(name: str, *places: object, **options: object) -> str:
    r"""Return a line of this program, as it is typed: every line that is printed is made here.

    A file whose name begins with a dash gets ``./`` before it, and a value that does is joined to its flag: both would
    be read as flags otherwise. What is None or False is left out, True is a flag alone, a list repeats its flag, the
    words of a tuple follow one flag. A name that Python reserves ends with an underscore.

    Examples
    --------
    >>> command("identify", "-rf.csv", input="---", time_unit="ms", run=["a", "b b"], overwrite=True)
    'dehyst identify ./-rf.csv --input=--- --time-unit ms --run a --run "b b" --overwrite'
    >>> command("design", range=(-4, 4), for_="drift", unit=None)
    'dehyst design --range -4 4 --for drift'
    """
    line = typed(["dehyst", name, *map(as_place, places)])
    return f"{line} {options_line(**options)}".rstrip()


def schedules_to_type(names: Iterable[str]) -> dict[str, list[str]]:
    """Return the option that names a column for each signal that a model depends on, as `command` takes it.

    Examples
    --------
    >>> command("compensate", "m.json", "REF.csv", **schedules_to_type(["load"]))
    'dehyst compensate m.json REF.csv --schedule load=COLUMN'
    """
    return {"schedule": [f"{name}=COLUMN" for name in names]}


def options_line(**options: object) -> str:
    """Return options as they are typed behind a command, see there.

    Examples
    --------
    >>> options_line(input="pressure [bar]", from_=[0, 20])
    '--input "pressure [bar]" --from 0 --from 20'
    """
    words = []
    for option, value in options.items():
        flag = f"--{option.rstrip('_').replace('_', '-')}"
        # A list repeats its flag; a tuple holds several words behind one.
        items = [value]
        if isinstance(value, list):
            items = value
        for item in items:
            words += _option(flag, item)
    return typed(words)


def as_place(word: object) -> str:
    """Return what stands without a flag such that it is not read as one."""
    text = str(word)
    if text.startswith("-"):
        return f"./{text}"
    return text


def _option(flag: str, value: object) -> list[str]:
    if value is None or value is False:
        return []
    if value is True:
        return [flag]
    if isinstance(value, tuple):
        return [flag, *map(str, value)]
    text = str(value)
    # Behind a blank, "-5" would be read as an option.
    if text.startswith("-"):
        return [f"{flag}={text}"]
    return [flag, text]


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
    line = re.sub(r"\s+", _without_break, line)
    return "".join(map(_shown, line))


def _without_break(gap: re.Match[str]) -> str:
    """White space as it is, or one blank if a line breaks in it."""
    if BREAKS.isdisjoint(gap[0]):
        return gap[0]
    return " "


def visible_lines(text: object) -> str:
    r"""Return text as `visible` does, its lines kept apart.

    Examples
    --------
    >>> visible_lines("a\nb\x07")
    'a\nb\\x07'
    """
    return "\n".join(map(visible, str(text).split("\n")))


def visible_text(text: str) -> str:
    r"""Return a text of many lines with its tabs, all other control characters and marks of direction spelled out.

    Examples
    --------
    >>> visible_text("a:\n\tb\x07")
    'a:\n\tb\\x07'
    """
    return "\n".join(map(_with_tabs, text.split("\n")))


def _with_tabs(line: str) -> str:
    # Nearly every line of a large file is printable, and the loop over letters is slow.
    if line.isprintable():
        return line
    letters = []
    for letter in line:
        if letter != "\t" and not letter.isprintable():
            letter = _shown(letter)
        letters.append(letter)
    return "".join(letters)


def _shown(letter: str) -> str:
    if unicodedata.category(letter) not in HIDDEN or letter in HARMLESS:
        return letter
    return letter.encode("unicode_escape").decode("ascii")


def did_you_mean(word: object, allowed: Iterable[str]) -> str:
    """Return " Did you mean ...?" if a word is similar to an allowed one, else an empty text.

    Examples
    --------
    >>> did_you_mean("mechanisms.scale", ["hysteresis.scale", "air.supply_bar"])
    ' Did you mean hysteresis.scale?'
    """
    import difflib  # only a refusal needs it

    text = str(word)[:200]
    words = sorted(allowed)
    near = difflib.get_close_matches(text, words, 1, 0.5)
    if not near:
        # The last part of a key may be right and the name of its table wrong.
        last_part = text.rpartition(".")[2]
        near = [candidate for candidate in words if candidate.rpartition(".")[2] == last_part][:3]
    if not near:
        return ""
    return f" Did you mean {' or '.join(near)}?"
