"""Fills the text templates of exported files, with jinja2."""

from __future__ import annotations

import re
from collections.abc import Sequence
from functools import cache

import jinja2

from dehyst.export import precision
from dehyst.export._folders import FOLDERS


@cache
def _environment() -> jinja2.Environment:
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(FOLDERS),
        # A misspelt value stops the export, because a gap in code could stay unseen.
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        autoescape=False,  # C, ST and Markdown: what comes from users goes through `comment` or `string_literal`
    )
    environment.filters |= {
        "comment": comment,
        "string_literal": string_literal,
        "literal": precision.literal,
        "pattern": precision.pattern,
        "table": precision.precision_table,
        "padded": padded,
        "doc": doc,
        "decimal": precision.decimal,
    }
    return environment


def render(template: str, **values: object) -> str:
    """Return a template below ``templates/``, filled."""
    environment = _environment()
    assert isinstance(environment.loader, jinja2.FileSystemLoader)
    # Another package may have been loaded since.
    environment.loader.searchpath = FOLDERS
    return environment.get_template(template).render(**values)


def plain_template(template: str) -> str:
    """Return the text of a file below ``templates/`` that has nothing to fill in."""
    environment = _environment()
    assert environment.loader is not None
    return environment.loader.get_source(environment, template)[0]


def padded(values: Sequence[float], size: int) -> list[float]:
    """Return values with zeros behind them.

    Examples
    --------
    >>> padded([1.0], 3)
    [1.0, 0.0, 0.0]
    """
    return [*values, *[0.0] * (size - len(values))]


def comment(text: object) -> str:
    r"""Return text that is one line and cannot end a C comment, nor begin a trigraph or continue a line.

    Examples
    --------
    >>> comment("angle */ [deg]\n???/")
    'angle * / [deg] ? ? ?/'
    """
    letters = [letter if letter.isprintable() else " " for letter in str(text)]
    line = " ".join("".join(letters).split())
    # A character is kept apart from the one before if both together mean something; so no pass makes a new pair.
    line = re.sub(r"\*(?=/)|/(?=[*/])|\?(?=\?)", r"\g<0> ", line)
    # A backslash at the end would make the next line of code a part of the comment.
    return line[:300].rstrip("\\ ")


def doc(text: object) -> str:
    r"""Return text that is one line of a documentation comment of Rust, in which Markdown marks nothing.

    Examples
    --------
    >>> doc("angle [deg]")
    'angle \\[deg\\]'
    """
    return re.sub(r"[\\`*_\[\]<>]", r"\\\g<0>", comment(text))


def string_literal(text: object) -> str:
    r"""Return text for between the quotes of a C string that printf prints as it is.

    Examples
    --------
    >>> string_literal('a "b" 5%')
    'a \\"b\\" 5%'
    """
    plain = re.sub(r"[^ -~]", "?", str(text))[:60]
    # Two question marks could begin a trigraph.
    return plain.replace("\\", "\\\\").replace('"', '\\"').replace("?", "\\?")
