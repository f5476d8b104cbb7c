"""Bodies from templates, and the variables that they use."""

from __future__ import annotations

import re
from collections.abc import Sequence

from jinja2 import Environment, PackageLoader, StrictUndefined

from dehyst.export.plc.pou import Variable

_ENVIRONMENT = Environment(
    loader=PackageLoader("dehyst.export", "templates/st"), undefined=StrictUndefined, keep_trailing_newline=True
)


def rendered(template: str, **values: object) -> str:
    """Return a template of this target with its values filled in."""
    text = _ENVIRONMENT.get_template(template).render(**values)
    return re.sub(r"(?m)[ \t]+$", "", text)


def used(body: str, variables: Sequence[Variable]) -> tuple[Variable, ...]:
    """Return those of the variables whose names stand in a body; inputs and outputs stay in any case."""
    words = set(re.findall(r"[A-Za-z_]\w*", re.sub(r"(?s)\(\*.*?\*\)", " ", body)))
    return tuple(v for v in variables if v.name in words or v.section in ("VAR_INPUT", "VAR_OUTPUT"))


def names(text: str) -> list[str]:
    """Return the words of a text: names that are declared alike."""
    return text.split()
