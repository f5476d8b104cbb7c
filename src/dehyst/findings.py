"""Findings: what was noticed about data or model, each with a code and a cure."""

from __future__ import annotations

from dataclasses import dataclass

from dehyst.visible import visible_lines


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
