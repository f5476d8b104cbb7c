"""Target ``fmu3``: an FMU for co-simulation, FMI 3.0, with its sources."""

from __future__ import annotations

from dehyst.export.fmu.companions import companions
from dehyst.export.fmu.package import package
from dehyst.export.fmu.verification import verify as verify
from dehyst.export.subject import Subject


def files(subject: Subject) -> dict[str, str | bytes]:
    """Return relative path -> content of everything that belongs to the target alone."""
    made = package(subject, 3)
    return {f"{subject.name}.fmu": made.fmu, **companions(made)}
