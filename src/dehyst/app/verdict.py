"""What identification said of a model, repeated wherever the model is used."""

from __future__ import annotations

from pathlib import Path

from dehyst.findings import Finding
from dehyst.grades import Grade, doubtful, grade_of
from dehyst.models import Model


def verdict_findings(model: Model, path: Path, forbid: str) -> list[Finding]:
    """Return the verdict as a warning unless it was good; `forbid` is what not to do after the worst one."""
    said = model.card.provenance.get("verdict")
    verdict = doubtful(said)  # printable: the file may come from anywhere
    if not verdict:
        return []
    cure = forbid if grade_of(said) is Grade.BAD else "Watch the actuator"
    return [
        Finding(
            "verdict",
            f"when '{path}' was identified, the verdict was: {verdict} {cure}, and read the warnings of "
            f"`dehyst identify` for the reason.",
        )
    ]
