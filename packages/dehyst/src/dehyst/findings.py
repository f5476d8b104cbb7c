"""Findings (warnings with a code and a cure) and grades (how far a model can be trusted as a compensator)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntEnum
from typing import Any

from dehyst.shell import visible, visible_lines


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing a user should know before trusting a result.

    Attributes
    ----------
    code
        Short kebab-case name that programs can match, for example ``"rate-dependent"``.
    message
        What was found, the numbers, why it matters, and what to do about it.

    Examples
    --------
    >>> Finding("gap", "no samples between 1.0 s and 3.0 s").code
    'gap'
    """

    code: str
    message: str

    def __post_init__(self) -> None:
        object.__setattr__(self, "message", visible_lines(self.message))

    def as_dict(self) -> dict[str, str]:
        """Return ``{"code": ..., "message": ...}`` as printed by ``--json``."""
        return {"code": self.code, "message": self.message}


class Grade(IntEnum):
    """How far a model can be trusted as a compensator: green, amber, red."""

    GOOD = 0
    CARE = 1
    BAD = 2

    @property
    def words(self) -> str:
        """The grade in words, so that no light depends on its colour."""
        return ("good", "usable with care", "do not use")[self]

    def __str__(self) -> str:
        """As in ``--json``: "good", "care" or "no"."""
        return ("good", "care", "no")[self]

    def __format__(self, spec: str) -> str:
        """As `str`."""
        return format(str(self), spec)

    @property
    def css(self) -> str:
        """Name of its style class."""
        return ("good", "care", "stop")[self]


def grade_in(provenance: Mapping[str, Any]) -> Grade | None:
    """Return the grade that a model's card carries, None where nobody judged the model.

    Parameters
    ----------
    provenance
        Of a card; it may come from any file.

    Examples
    --------
    >>> grade_in({"grade": "no"}).words
    'do not use'
    >>> grade_in({"verdict": "written by hand"}) is None
    True
    """
    name = provenance.get("grade")
    return next((grade for grade in Grade if str(grade) == name), None)


def doubt_in(provenance: Mapping[str, Any]) -> str:
    """Return the verdict that a card carries, printable and on one line, if its grade is less than good; "" otherwise.

    Examples
    --------
    >>> doubt_in({"grade": "care", "verdict": "pi: 9.0 % of range rms: usable with care."})
    'pi: 9.0 % of range rms: usable with care.'
    >>> doubt_in({"grade": "good", "verdict": "pi: 1.0 %: good for compensation."})
    ''
    """
    verdict = provenance.get("verdict")
    if not isinstance(verdict, str) or grade_in(provenance) in (None, Grade.GOOD):
        return ""
    return visible(verdict)[:600]
