"""Arguments and options of `dehyst backlash`; see `dehyst.app.requests`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from dehyst.app import Command, argument, option


@dataclass(frozen=True, eq=False)
class BacklashRequest:
    """Backlash of an axis: plan a measurement, write its table for a machine, check a table. Status 1: no table."""

    action: str = argument("plan, table or check.", metavar="ACTION")
    files: tuple[Path, ...] = argument(
        "table: the filled sheet, or a log. check: a table and the sheet.",
        (),
        metavar="[FILE] [SHEET]",
    )
    machine: str | None = option("linuxcnc, grblhal, marlin or klipper; plan: linuxcnc without it.")
    axis: str = option("Letter of the axis.", "X")
    start: float | None = option("plan: first point.", flag="--from")
    stop: float | None = option("plan: last point.", flag="--to")
    points: int = option("plan: points, at equal distances.", 13)
    approach: tuple[float, ...] = option(
        "plan: way from the turn to the point, several times the play; 2 without it. Repeat to see whether it matters.",
        (),
    )
    repeats: int = option("plan: how often all of it is read.", 3)
    rate: float | None = option("plan: rate of all moves [unit/s]; without it the way in 20 s.")
    hold: float = option("plan: rest before a reading [s].", 2.0)
    pause: bool = option("plan: wait for the start button at each reading.", False)
    gcode: Path | None = option("plan: G-code program to write.")
    sheet: str | None = option("plan: empty sheet to write, .csv. Else: sheet of a workbook.")
    unit: str | None = option("mm, in or deg; by default as the sheet says, plan: mm.")
    input: str | None = option("Column of the commanded position; by default by its name.")
    output: str | None = option(
        "Column of the measured position, or of the error; by default by its name."
    )
    smoothing: float = option("table: Marlin spreads the correction over this way [mm].", 0.0)
    out: Path | None = option("table: folder for the files of the machine.")
    figure: Path | None = option()
    overwrite: bool = option(default=False)
    json: bool = option(default=False)


BACKLASH = Command("dehyst_targets.backlash._command:run_backlash", BacklashRequest)
