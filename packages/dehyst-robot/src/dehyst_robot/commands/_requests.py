"""Arguments and options of the commands of the robot; see `dehyst.app.requests`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from dehyst.app import argument, option


@dataclass(frozen=True, eq=False)
class ReproduceRequest:
    """Run the paper's experiment on the simulated arm and write its report."""

    quick: bool = option("One plant, one seed, shorter trials, no studies: half a minute.", False)
    plant: str | None = option(
        "all, maxwell-slip, preisach, dahl, braid, lugre, pinched, ageing or none; several as preisach,none."
    )
    as_printed: bool = option(
        "The paper to the letter, as far as it is printed: compensator printed in joint 1 alone, 3 bar, no studies. "
        "Not to the letter: anti-windup (its schedule is not printed) and the derivative of the desired pressure, "
        "which leaves out the feedback's part.",
        False,
    )
    alone: str | None = option(
        "Plants beside these on which the first joint runs alone, the others locked, in a third of the time; several "
        "as braid,lugre."
    )
    joint: str | None = option(
        "Joint that is compensated, 1, 2 or 4 of the packaged arm; several as 1,2; all without it."
    )
    compensator: tuple[str, ...] = option(
        "paper, literal, printed, scaled, direct, creep, scheduled, adaptive, ilc, maxwell-slip or best; several as "
        "paper,best; paper without it.",
        (),
    )
    controller: str = option(
        "paper, vo-minh, sliding-mode, one-valve or pid; several as paper,pid: the report is about the first.",
        "paper",
    )
    seed: int | None = option("Run this seed only; without it 0, 1 and 2, with --quick 0.")
    cycles: int | None = option("Cycles of the path in every trial; 10 fast and 1 slow without it.")
    robot: Path | None = option()
    conditions: str | None = option(
        "realistic, the default: with what a real arm adds; kind: the equations alone."
    )
    reference: Path | None = option(
        "Log of angles to follow, time_s,joint1_deg,...; by default what the robot says."
    )
    out: Path = option("Folder for report and logs.", Path("reproduction"))
    figures: Path | None = option()
    json: Path | None = option("Write every figure to this JSON file too.")
    overwrite: bool = option(default=False)


@dataclass(frozen=True, eq=False)
class RigRequest:
    """Write the file of a robot of one's own (new), say what it can do (check), or take its numbers from logs (fit)."""

    action: str = argument("new, check or fit.", metavar="ACTION")
    file: Path = argument("Parameter file of the robot.", metavar="ROBOT.toml")
    logs: tuple[Path, ...] = argument(
        "fit: logs of a muscle on a bench, or of a joint.", (), metavar="[BENCH]"
    )
    joints: int | None = option("new: joints of a chain; 1 without it.")
    from_urdf: Path | None = option("new: take links and joints from this URDF file.")
    from_mjcf: Path | None = option("new: take links and joints from this MJCF file.")
    joint: int | None = option(
        "fit: joint of the logs; a muscle alone is its first one. Else the first with muscles."
    )
    column: tuple[str, ...] = option(
        "fit: column of a role, e.g. force=LoadCell_N; repeat.", (), metavar="ROLE=NAME"
    )
    sheet: str | None = option()
    run: str | None = option()
    test: tuple[Path, ...] = option("fit: a log that is not fitted but tested on; repeat.", ())
    out: Path | None = option("fit: file of the robot to write, with the numbers found.")
    mjcf: Path | None = option(
        "check: write the robot for MuJoCo's viewer to this file, its muscles drawn."
    )
    figure: Path | None = option()
    json: bool = option(default=False)
    overwrite: bool = option(default=False)


@dataclass(frozen=True, eq=False)
class SweepRequest:
    """Run the simulated experiment over many parameters; goes on where it was stopped. Status 1 if runs failed."""

    sweep: Path = argument("What to vary; see examples/sensitivity.toml.", metavar="SWEEP.toml")
    out: Path | None = option("Table to write, and to go on from; SWEEP.csv here without it.")
    figure: Path | None = option("Picture to write, .svg or .png; beside the table without it.")
    workers: int | None = option("Processes; one a processor without it.")
    dask: str | None = option("Run on the Dask cluster at this address, tcp://host:port.")
    retry: bool = option("Run again what failed in an earlier start.", False)
    overwrite: bool = option("Drop the table and the picture of an earlier start.", False)


@dataclass(frozen=True, eq=False)
class MuscleRequest:
    """Put a muscle model on a test bench: forces, loops, quick release; fit it to a bench log."""

    model: str | None = argument(
        "Name of a model, or file that --save wrote; see --list.", None, metavar="MODEL"
    )
    list_models: bool = option("List all models and their parameter sets.", False, flag="--list")
    which: str | None = option("Published parameter set; the first without it.", flag="--set")
    parameters: tuple[str, ...] = option(
        "Change a parameter; repeat for more.", (), flag="--param", metavar="NAME=VALUE"
    )
    length: str | None = option("Length at rest, 0.3 [m] or 300mm.")
    pressures: str | None = option("Pressures, e.g. 1,3,6 [bar].")
    contractions: str | None = option("Contractions, e.g. 0,10,20 [%].")
    loads: str | None = option("Loads of the isotonic loops, e.g. 100,400 [N].")
    log: Path | None = option("Bench log to fit the model to.")
    contraction: str | None = option("Column of the contraction, a number, percent or mm.")
    length_column: str | None = option("Column of the length instead; needs --length.")
    pressure: str = option("Column of the gauge pressure.", "pressure")
    force: str = option("Column of the force.", "force")
    time: str | None = option()
    time_unit: str | None = option()
    dt: float | None = option()
    sheet: str | None = option()
    run: str | None = option()
    start: float | None = option()
    stop: float | None = option()
    contraction_unit: str | None = option("Of contraction or length: 1, percent, mm, ...")
    pressure_unit: str | None = option("bar, kPa, MPa, psi, ...")
    force_unit: str | None = option("N, kN, lbf, ...")
    absolute: bool = option("The pressure is absolute.", False)
    at_rest: bool = option("Every row is a point at rest, even if the log has time.", False)
    seed: int = option("Of starts and of samples left out.", 0)
    save: Path | None = option("Write the fitted model to this JSON file.")
    report: Path | None = option()
    figure: Path | None = option()
    overwrite: bool = option(default=False)
    json: bool = option(default=False)
