"""Targets of `dehyst export` beside C, found by entry points of the group ``dehyst.targets``."""

from pathlib import Path

from dehyst.export import kit as export_kit

export_kit.add_templates(Path(__file__).resolve().parent / "templates")

FMU2 = export_kit.Target("fmu2", "FMU for co-simulation, FMI 2.0", "dehyst_targets.fmu2")
FMU3 = export_kit.Target("fmu3", "FMU for co-simulation, FMI 3.0", "dehyst_targets.fmu3")
ST = export_kit.Target(
    "st",
    "Structured Text function block and PLCopen XML",
    "dehyst_targets.st",
    export_kit.BLOCKS,
    retains=True,
)
SIMULINK = export_kit.Target(
    "simulink", "Simulink: C Function block recipe and S-function", "dehyst_targets.simulink"
)
RUST = export_kit.Target(
    "rust", "Rust crate without std around the C sources", "dehyst_targets.rust"
)
ADA = export_kit.Target(
    "ada", "Ada package with contracts around the C sources", "dehyst_targets.ada"
)
ARDUINO = export_kit.Target(
    "arduino", "Arduino library", "dehyst_targets.arduino", export_kit.BLOCKS, ("float",)
)
