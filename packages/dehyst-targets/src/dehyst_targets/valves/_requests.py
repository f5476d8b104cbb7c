"""Arguments and options of `dehyst valve`; see `dehyst.app.requests`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from dehyst.app import Command, argument, option


@dataclass(frozen=True, eq=False)
class ValveRequest:
    """Tell from a record of a control loop whether its valve sticks: dead band and jump. Status 4: cannot tell."""

    log: Path = argument(
        "Record of the loop: time, set point SP, controller output OP, measurement PV."
    )
    setpoint: str | None = option("Column of the set point; by default SP.")
    output: str | None = option("Column of the controller output; by default OP.")
    measurement: str | None = option("Column of the measurement; by default PV.")
    position: str | None = option("Column of the position of the valve, if it is logged.")
    span: tuple[float, float] | None = option(
        "Controller output at 0 and 100 %; 0 and 100 without it, 4 and 20 of mA.", metavar="LO HI"
    )
    time: str | None = option()
    time_unit: str | None = option()
    dt: float | None = option()
    sheet: str | None = option()
    run: str | None = option()
    start: float | None = option()
    stop: float | None = option()
    test: Path | None = option(
        "Write a test in manual to this CSV file: time and controller output."
    )
    figure: Path | None = option()
    overwrite: bool = option(default=False)
    json: bool = option(default=False)


VALVE = Command("dehyst_targets.valves._command:run_valve", ValveRequest)
