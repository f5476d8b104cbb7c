"""Arguments and options of `dehyst battery`; see `dehyst.app.requests`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from dehyst.app import Command, argument, option


@dataclass(frozen=True, eq=False)
class BatteryRequest:
    """Branches and decay rate of an electrode's open-circuit voltage with hysteresis; a parameter file for PyBaMM."""

    log: Path = argument(
        "Slow cycles or rests of an electrode against lithium: charge and voltage."
    )
    charge: str | None = option(
        "Column of the charge or stoichiometry; by default by unit or name."
    )
    voltage: str | None = option("Column of the voltage; by default by unit or name.")
    stoichiometry: tuple[float, float] | None = option(
        "Stoichiometry at the delithiated and at the lithiated end of the log; 0 and 1 without it.",
        metavar="LO HI",
    )
    electrode: str = option(
        "Which electrode of PyBaMM it is.", "negative", metavar="negative|positive"
    )
    decay: float | None = option("Decay rate, where the log has no partial cycles to tell it.")
    time: str | None = option()
    time_unit: str | None = option()
    dt: float | None = option()
    sheet: str | None = option()
    run: str | None = option()
    start: float | None = option()
    stop: float | None = option()
    out: Path | None = option("Python file of parameters for PyBaMM.")
    figure: Path | None = option()
    overwrite: bool = option(default=False)
    json: bool = option(default=False)


BATTERY = Command("dehyst_targets.batteries._command:run_battery", BatteryRequest)
