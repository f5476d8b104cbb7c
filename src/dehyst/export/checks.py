"""What a verification found, one line a claim."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Status = Literal["passed", "failed", "skipped"]


@dataclass(frozen=True)
class Check:
    """One claim about an export, and whether it holds.

    Attributes
    ----------
    claim
        What is claimed, one line.
    status
        "passed", "failed", or "skipped" with the reason in `detail`.
    detail
        Numbers, or why it failed or was skipped.
    ran
        Whether code of the export was compiled and run for it.

    Examples
    --------
    >>> Check("outputs have the bits of the model", "passed", "1400 samples").ok
    True
    """

    claim: str
    status: Status
    detail: str = ""
    ran: bool = False

    @property
    def ok(self) -> bool:
        """Whether nothing speaks against the claim: a skipped one is not a failed one."""
        return self.status != "failed"

    def as_dict(self) -> dict[str, str]:
        """Return ``{"claim": ..., "status": ..., "detail": ...}``."""
        return {"claim": self.claim, "status": self.status, "detail": self.detail}
