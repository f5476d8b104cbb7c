"""Arguments and options of `dehyst magnet`; see `dehyst.app.requests`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from dehyst.app import Command, argument, option


@dataclass(frozen=True, eq=False)
class MagnetRequest:
    """Loss, Hc, Br, Bs and permeability of a measured B-H loop; core models for LTspice, PSpice, ngspice, Modelica."""

    log: Path = argument("Log of field H and flux density B, at least one cycle.")
    field: str | None = option("Column of the field H; by default by its unit or name.")
    density: str | None = option("Column of the flux density B; by default by its unit or name.")
    field_unit: str | None = option("Unit of H where the log does not say: A/m, kA/m, A/cm, Oe.")
    density_unit: str | None = option("Unit of B where the log does not say: T, mT, G, kG.")
    symmetric: bool = option(
        "Complete half a loop, where there is no whole one, by odd symmetry about its centre.",
        False,
    )
    time: str | None = option()
    time_unit: str | None = option()
    dt: float | None = option()
    sheet: str | None = option()
    run: str | None = option()
    start: float | None = option()
    stop: float | None = option()
    out: Path | None = option("File of the core for a simulator: .lib, .cir, .mo or other.")
    format: str | None = option(
        "What it is written for; by default .lib ltspice, .cir ngspice, .mo modelica.",
        metavar="ltspice|pspice|ngspice|modelica",
    )
    figure: Path | None = option()
    overwrite: bool = option(default=False)
    json: bool = option(default=False)


MAGNET = Command("dehyst_targets.magnetics._command:run_magnet", MagnetRequest)
