"""Findings (warnings with a code and a cure) and grades (how far a model can be trusted as a compensator)."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

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


# How a verdict ends; the worst is looked for first.
ENDINGS = (
    (Grade.BAD, "do not compensate"),
    (Grade.CARE, "usable with care"),
    (Grade.GOOD, "good for compensation"),
)


def grade_of(verdict: object) -> Grade | None:
    """Return the grade that a verdict pronounces, or None if it is not one of dehyst's own.

    Examples
    --------
    >>> grade_of("pi, 9 of 9 operators: 12.00 % of range rms ...: do not compensate with it.").words
    'do not use'
    >>> grade_of("written by hand") is None
    True
    """
    if not isinstance(verdict, str):
        return None
    return next((grade for grade, words in ENDINGS if words in verdict), None)


def doubtful(verdict: object) -> str:
    """Return a verdict, printable and on one line, if it is less than good; "" otherwise.

    Examples
    --------
    >>> doubtful("pi: 9.0 % of range rms: usable with care."), doubtful("pi: 1.0 %: good for compensation.")
    ('pi: 9.0 % of range rms: usable with care.', '')
    """
    if grade_of(verdict) in (None, Grade.GOOD):
        return ""
    return visible(verdict)[:600]
