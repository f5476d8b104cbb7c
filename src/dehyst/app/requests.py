"""What can be typed after each command: options with their help, once; `dehyst.cli` makes parsers of them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer

Log = Annotated[Path, typer.Argument(help="Log file: .csv(.gz), .mat, .npz; with extras .mcap, .bag, .mf4, .parquet.")]
Logs = Annotated[tuple[Path, ...], typer.Argument(metavar="log", help="One log file or several, fitted together.")]
Model = Annotated[Path, typer.Argument(help="Model file written by `dehyst identify ... --save`.")]
Input = Annotated[
    str | None, typer.Option("--input", help="Column that drives the actuator; by default by names and units.")
]
Output = Annotated[str | None, typer.Option("--output", help="Column that responds; by default by names and units.")]
Time = Annotated[str | None, typer.Option("--time", help="Time column, if it is not found by itself.")]
TimeUnit = Annotated[
    str | None, typer.Option("--time-unit", help="Unit of the time column, e.g. ms, if its name does not tell.")
]
Run = Annotated[str | None, typer.Option("--run", help="Run to use, if the log holds several.")]
Runs = Annotated[tuple[str, ...], typer.Option("--run", help="Run to use, if the log holds several; repeat for more.")]
TrainFraction = Annotated[
    float | None,
    typer.Option(
        "--train-fraction",
        help="Share of each log that is fitted; the rest is the test. By default half, or of three logs whole ones.",
    ),
]
Start = Annotated[float | None, typer.Option("--from", help="Leave out samples before this time [s].")]
Stop = Annotated[float | None, typer.Option("--to", help="Leave out samples from this time on [s].")]
Out = Annotated[Path | None, typer.Option("--out", help="CSV file to write; without it, CSV goes to the terminal.")]
Overwrite = Annotated[bool, typer.Option("--overwrite", help="Replace files that exist already.")]
LoadColumn = Annotated[
    str | None, typer.Option("--load", help="direct-inverse: column of the load (force, torque, mass).")
]
MeanPressureColumn = Annotated[
    str | None, typer.Option("--mean-pressure", help="direct-inverse: column of the mean pressure.")
]
Json = Annotated[bool, typer.Option("--json", help="Print the result as JSON and nothing else.")]
UnknownState = Annotated[
    bool, typer.Option("--unknown-state", help="Assume nothing of the past: middle, low and high instead of one value.")
]
Past = Annotated[
    tuple[float, float] | None,
    typer.Option(
        "--past",
        metavar="LO HI",
        help="What the signal cannot have left before; the identified range without it; no direct inverse.",
    ),
]
Begin = Annotated[
    str | None,
    typer.Option(
        "--start",
        metavar="unknown|rest|model",
        help="Past of the actuator: unknown (compensate), at rest, or as the model's log began (simulate).",
    ),
]
Band = Annotated[Path | None, typer.Option("--figure", help="Picture of the band, .svg or .png, with --unknown-state.")]


@dataclass(frozen=True)
class LogsRequest:
    """Logs that something is identified from."""

    logs: Logs
    input: Input = None
    output: Output = None
    time: Time = None
    time_unit: TimeUnit = None
    runs: Runs = ()
    start: Start = None
    stop: Stop = None


@dataclass(frozen=True)
class IdentifyRequest(LogsRequest):
    """Identify a hysteresis model and its inverse from a log."""

    family: Annotated[
        str,
        typer.Option(
            "--family",
            help="auto: the best there is for this log; or pi (the paper), pi-cumulative, modified-pi, stop, static, "
            "direct-inverse, or any family of `dehyst compare`.",
        ),
    ] = "auto"
    purpose: Annotated[
        str,
        typer.Option(
            "--for",
            metavar="compensate|simulate",
            help="What the model is for: compensate keeps the gain of the inverse low, simulate only the error.",
        ),
    ] = "compensate"
    n: Annotated[str, typer.Option("--n", help="Number of operators, or auto: by held-out error.")] = "100"
    eps: Annotated[
        str | None,
        typer.Option(
            "--eps",
            metavar="auto|EPS",
            help="Smallest slope after a reversal, relative to the ranges; auto, the default: the firmest that costs "
            "less than 5 % of the accuracy. For pi w_1 >= EPS, 0.001 (the paper) by default.",
        ),
    ] = None
    thresholds: Annotated[
        str | None, typer.Option("--thresholds", help="Thresholds instead of a grid, e.g. 0,0.5,1 [input].")
    ] = None
    initial_state: Annotated[
        str, typer.Option("--initial-state", help="auto, zero, rest, rising, falling or unknown.")
    ] = "auto"
    train_fraction: TrainFraction = None
    shear: Annotated[
        str | None,
        typer.Option("--shear", metavar="auto|K", help="Fit the loop around the diagonal, input + K output (pi only)."),
    ] = None
    max_inverse_gain: Annotated[
        float | None,
        typer.Option("--max-inverse-gain", metavar="G", help="Largest slope of the inverse [input/output]; sets eps."),
    ] = None
    creep: Annotated[
        int | None, typer.Option("--creep", help="direct-inverse: number of time constants; by default as it helps.")
    ] = None
    creep_times: Annotated[
        str | None, typer.Option("--creep-times", help="direct-inverse: time constants instead, e.g. 4,25,150 [s].")
    ] = None
    load: LoadColumn = None
    mean_pressure: MeanPressureColumn = None
    position_schedule: Annotated[
        bool,
        typer.Option(
            "--position-schedule/--no-position-schedule",
            help="direct-inverse: whether weights may change with the output.",
        ),
    ] = True
    save: Annotated[Path | None, typer.Option("--save", help="Write the model to this JSON file.")] = None
    report: Annotated[Path | None, typer.Option("--report", help="Write a report page to this HTML file.")] = None
    figures: Annotated[
        Path | None, typer.Option("--figures", help="Write every figure as SVG and PNG into this folder.")
    ] = None
    stream: Annotated[
        bool | None,
        typer.Option(
            "--stream/--no-stream",
            help="Read in chunks, in constant memory, or at once; without either, by size.",
        ),
    ] = None
    spool_dir: Annotated[
        Path | None,
        typer.Option("--spool-dir", help="Folder of the temporary copy that streaming makes of text logs and bags."),
    ] = None
    overwrite: Overwrite = False
    json: Json = False


@dataclass(frozen=True)
class SimulateRequest:
    """Print a model's output for a logged input, as CSV."""

    model: Model
    log: Log
    column: Annotated[str | None, typer.Option("--input", help="Input column; by default the model's.")] = None
    time: Time = None
    time_unit: TimeUnit = None
    run: Run = None
    start: Start = None
    stop: Stop = None
    out: Out = None
    load: LoadColumn = None
    mean_pressure: MeanPressureColumn = None
    unknown_state: UnknownState = False
    past: Past = None
    begin: Begin = None
    figure: Band = None
    overwrite: Overwrite = False


@dataclass(frozen=True)
class CompensateRequest(SimulateRequest):
    """Print the input that makes the actuator follow a reference, as CSV."""

    log: Annotated[Path, typer.Argument(metavar="reference", help="File with the motion the actuator should make.")]
    column: Annotated[
        str | None, typer.Option("--output", help="Column of the wanted output; by default the model's.")
    ] = None


@dataclass(frozen=True)
class DesignRequest:
    """Design the motion to run on a rig before an identification: loops, rates and holds, within limits."""

    joint: Annotated[int | None, typer.Option("--joint", help="Joint of the robot: limits come from its file.")] = None
    robot: Annotated[
        Path | None, typer.Option("--robot", help="Parameter file of the arm, .toml; the packaged arm without it.")
    ] = None
    range: Annotated[
        tuple[float, float] | None,
        typer.Option("--range", metavar="LO HI", help="Range that the motion uses, and does not leave."),
    ] = None
    unit: Annotated[
        str | None, typer.Option("--unit", help="Unit of range, rate and acceleration; deg with --joint.")
    ] = None
    rate: Annotated[
        float | None, typer.Option("--rate", help="Largest rate [unit/s]; without it the range in 4 s.")
    ] = None
    acceleration: Annotated[
        float | None,
        typer.Option("--acceleration", help="Largest acceleration [unit/s^2]; without it what that stroke takes."),
    ] = None
    time_limit: Annotated[float, typer.Option("--time-limit", help="Longest duration [s].")] = 600.0
    period: Annotated[float, typer.Option("--period", help="Time between two samples of --out [s].")] = 0.02
    out: Annotated[Path | None, typer.Option("--out", help="CSV file to write: time, command, part.")] = None
    figure: Annotated[Path | None, typer.Option("--figure", help="Picture to write, .svg or .png.")] = None
    purpose: Annotated[
        str, typer.Option("--for", metavar="PURPOSE", help="identification, or drift: cycles alike.")
    ] = "identification"
    overwrite: Overwrite = False
    json: Json = False


@dataclass(frozen=True)
class ReproduceRequest:
    """Run the paper's experiment on the simulated arm and write its report."""

    quick: Annotated[
        bool, typer.Option("--quick", help="One plant, one seed, shorter trials, no studies: less than 20 s.")
    ] = False
    plant: Annotated[
        str | None,
        typer.Option("--plant", help="all, maxwell-slip, preisach, dahl or none; several as preisach,none."),
    ] = None
    joint: Annotated[str, typer.Option("--joint", help="Joint that is compensated: 1, 2, 4 or all.")] = "all"
    compensator: Annotated[
        tuple[str, ...],
        typer.Option(
            "--compensator",
            help="paper, literal, scaled, direct, creep, scheduled, adaptive, ilc, maxwell-slip or best; several as"
            " paper,best.",
        ),
    ] = ("paper",)
    controller: Annotated[
        str,
        typer.Option(
            "--controller",
            help="paper, vo-minh, sliding-mode, one-valve or pid; several as paper,pid: the report is about the first.",
        ),
    ] = "paper"
    seed: Annotated[
        int | None, typer.Option("--seed", help="Run this seed only; without it 0, 1 and 2, with --quick 0.")
    ] = None
    cycles: Annotated[
        int | None, typer.Option("--cycles", help="Cycles of the path in every trial; 10 fast and 1 slow without it.")
    ] = None
    robot: Annotated[
        Path | None, typer.Option("--robot", help="Parameter file of the arm, .toml; the packaged arm without it.")
    ] = None
    out: Annotated[Path, typer.Option("--out", help="Folder for report and logs.")] = Path("reproduction")
    figures: Annotated[
        Path | None, typer.Option("--figures", help="Write every figure as SVG and PNG into this folder.")
    ] = None
    json: Annotated[Path | None, typer.Option("--json", help="Write every figure to this JSON file too.")] = None
    overwrite: Overwrite = False


@dataclass(frozen=True)
class SweepRequest:
    """Run the simulated experiment over many parameters; goes on where it was stopped. Status 1 if runs failed."""

    sweep: Annotated[Path, typer.Argument(metavar="SWEEP.toml", help="What to vary; see examples/sensitivity.toml.")]
    out: Annotated[
        Path | None, typer.Option("--out", help="Table to write, .csv or .parquet; SWEEP.csv here without it.")
    ] = None
    figure: Annotated[
        Path | None, typer.Option("--figure", help="Picture to write, .svg or .png; beside the table without it.")
    ] = None
    workers: Annotated[int | None, typer.Option("--workers", help="Processes; one a processor without it.")] = None
    dask: Annotated[
        str | None, typer.Option("--dask", help="Run on the Dask cluster at this address, tcp://host:port.")
    ] = None
    restart: Annotated[bool, typer.Option("--restart", help="Drop finished runs of an earlier start.")] = False
    retry: Annotated[bool, typer.Option("--retry", help="Run again what failed in an earlier start.")] = False
    overwrite: Overwrite = False


@dataclass(frozen=True)
class DriftRequest:
    """Tell whether the actuator has changed since it was identified; exit status 1 if it has."""

    model: Model
    logs: Annotated[tuple[Path, ...], typer.Argument(metavar="log", help="New logs, in their order in time.")]
    input: Annotated[str | None, typer.Option("--input", help="Input column; by default the model's.")] = None
    output: Annotated[str | None, typer.Option("--output", help="Output column; by default the model's.")] = None
    time: Time = None
    time_unit: TimeUnit = None
    runs: Annotated[
        tuple[str, ...], typer.Option("--run", help="Run to use, if the logs hold several; repeat for more.")
    ] = ()
    start: Start = None
    stop: Stop = None
    reference: Annotated[
        Path | None,
        typer.Option(
            "--reference", help="Log of the new actuator; by default that of the model, if it is among the logs."
        ),
    ] = None
    false_alarm: Annotated[
        float, typer.Option("--false-alarm", help="Probability of a false alarm allowed to the whole call.")
    ] = 0.01
    least: Annotated[
        float | None, typer.Option("--least", help="Smallest change worth a word, rms in percent of range.")
    ] = None
    load: Annotated[str | None, typer.Option("--load", help="Column of the load, if the model depends on it.")] = None
    mean_pressure: Annotated[
        str | None, typer.Option("--mean-pressure", help="Column of the mean pressure, if the model depends on it.")
    ] = None
    ignore: Annotated[
        tuple[str, ...], typer.Option("--ignore", help="Part that does not count, e.g. offset; repeat for more.")
    ] = ()
    refit: Annotated[
        Path | None, typer.Option("--refit", help="Identify anew; write this JSON file only if it is better.")
    ] = None
    report: Annotated[Path | None, typer.Option("--report", help="Write a report page to this HTML file.")] = None
    overwrite: Overwrite = False
    json: Json = False


@dataclass(frozen=True)
class ExportRequest:
    """Write a model, its inverse or a joint controller as code for a target, with the proof beside it."""

    model: Model
    target: Annotated[str, typer.Option("--target", help="c, c-header, fmu2, fmu3, st, simulink or arduino.")]
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="Folder to write.")]
    real: Annotated[
        str | None, typer.Option("--real", help="double or float; without it double, for arduino float.")
    ] = None
    what: Annotated[str, typer.Option("--what", help="inverse, forward or joint-controller.")] = "inverse"
    range: Annotated[
        tuple[float, float] | None,
        typer.Option("--range", metavar="LO HI", help="What the actuator can be given; else the identified range."),
    ] = None
    ramp: Annotated[
        int | None, typer.Option("--ramp", help="Samples over which switching on and off fades; 500 without it.")
    ] = None
    log: Annotated[
        Path | None,
        typer.Option(
            "--log",
            help="Your log: an excerpt becomes part of the check; of a model or its inverse, which take one column.",
        ),
    ] = None
    run: Run = None
    start: Start = None
    stop: Stop = None
    time: Time = None
    column: Annotated[
        str | None,
        typer.Option("--column", help="Its column that is the input of what is exported; else the model's."),
    ] = None
    controller: Annotated[
        Path | None, typer.Option("--controller", help="Parameters of the joint controller, JSON.")
    ] = None
    period: Annotated[
        float | None, typer.Option("--period", help="Of a unit that depends on time: between two samples [s].")
    ] = None
    name: Annotated[
        str | None, typer.Option("--name", help="C identifier; made of the model's file name without it.")
    ] = None
    prune: Annotated[bool, typer.Option("--prune", help="Drop operators of weight zero, which is exact.")] = False
    overwrite: Overwrite = False
    json: Json = False


@dataclass(frozen=True)
class CompareRequest(LogsRequest):
    """Identify every hysteresis family from a log: errors, parameters, time, inverses, side by side."""

    families: Annotated[
        str | None, typer.Option("--families", help="Only these, with commas, e.g. pi,preisach,bouc-wen; default all.")
    ] = None
    train_fraction: TrainFraction = None
    seed: Annotated[int, typer.Option("--seed", help="Of the searches of families whose fit is not convex.")] = 0
    save: Annotated[
        Path | None, typer.Option("--save", help="Write the model of the best family to this JSON file.")
    ] = None
    report: Annotated[Path | None, typer.Option("--report", help="Write a report page to this HTML file.")] = None
    figure: Annotated[Path | None, typer.Option("--figure", help="Write the picture to this file, .svg or .png.")] = (
        None
    )
    overwrite: Overwrite = False
    json: Json = False


@dataclass(frozen=True)
class EvaluateRequest:
    """Score saved models of any family on another log: output, input of the inverse, and which one to run."""

    models: Annotated[tuple[Path, ...], typer.Argument(metavar="MODEL...", help="Model files, of any family.")]
    log: Annotated[Path, typer.Argument(help="Log that they were not identified from, such as one of use.")]
    input: Annotated[str | None, typer.Option("--input", help="Input column; by default that of the models.")] = None
    output: Annotated[str | None, typer.Option("--output", help="Output column; by default that of the models.")] = None
    time: Time = None
    time_unit: TimeUnit = None
    runs: Runs = ()
    start: Start = None
    stop: Stop = None
    load: LoadColumn = None
    mean_pressure: MeanPressureColumn = None
    json: Json = False


@dataclass(frozen=True)
class MuscleRequest:
    """Put a muscle model on a test bench: forces, loops, quick release; fit it to a bench log."""

    model: Annotated[
        str | None, typer.Argument(metavar="MODEL", help="Name of a model, or file that --save wrote; see --list.")
    ] = None
    list_models: Annotated[bool, typer.Option("--list", help="List all models and their parameter sets.")] = False
    which: Annotated[str | None, typer.Option("--set", help="Published parameter set; the first without it.")] = None
    parameters: Annotated[
        tuple[str, ...], typer.Option("--param", metavar="NAME=VALUE", help="Change a parameter; repeat for more.")
    ] = ()
    length: Annotated[str | None, typer.Option("--length", help="Length at rest, 0.3 [m] or 300mm.")] = None
    pressures: Annotated[str | None, typer.Option("--pressures", help="Pressures, e.g. 1,3,6 [bar].")] = None
    contractions: Annotated[str | None, typer.Option("--contractions", help="Contractions, e.g. 0,10,20 [%].")] = None
    loads: Annotated[str | None, typer.Option("--loads", help="Loads of the isotonic loops, e.g. 100,400 [N].")] = None
    log: Annotated[Path | None, typer.Option("--log", help="Bench log to fit the model to.")] = None
    contraction: Annotated[
        str | None, typer.Option("--contraction", help="Column of the contraction, a number, percent or mm.")
    ] = None
    length_column: Annotated[
        str | None, typer.Option("--length-column", help="Column of the length instead; needs --length.")
    ] = None
    pressure: Annotated[str, typer.Option("--pressure", help="Column of the gauge pressure.")] = "pressure"
    force: Annotated[str, typer.Option("--force", help="Column of the force.")] = "force"
    time: Time = None
    time_unit: TimeUnit = None
    run: Run = None
    start: Start = None
    stop: Stop = None
    contraction_unit: Annotated[
        str | None, typer.Option("--contraction-unit", help="Of contraction or length: 1, percent, mm, ...")
    ] = None
    pressure_unit: Annotated[str | None, typer.Option("--pressure-unit", help="bar, kPa, MPa, psi, ...")] = None
    force_unit: Annotated[str | None, typer.Option("--force-unit", help="N, kN, lbf, ...")] = None
    absolute: Annotated[bool, typer.Option("--absolute", help="The pressure is absolute.")] = False
    at_rest: Annotated[
        bool, typer.Option("--at-rest", help="Every row is a point at rest, even if the log has time.")
    ] = False
    seed: Annotated[int, typer.Option("--seed", help="Of starts and of samples left out.")] = 0
    save: Annotated[Path | None, typer.Option("--save", help="Write the fitted model to this JSON file.")] = None
    report: Annotated[Path | None, typer.Option("--report", help="Write a report page to this HTML file.")] = None
    figure: Annotated[Path | None, typer.Option("--figure", help="Picture to write, .svg or .png.")] = None
    overwrite: Overwrite = False
    json: Json = False
