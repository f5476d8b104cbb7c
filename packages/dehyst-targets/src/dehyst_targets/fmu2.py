"""Target ``fmu2``: an FMU for co-simulation, FMI 2.0, with its sources."""

from __future__ import annotations

from dehyst.export import kit as export_kit
from dehyst_targets.fmu import check_fmu, fmu_files

WRITER = export_kit.Writer(lambda subject: fmu_files(subject, 2), check_fmu)
