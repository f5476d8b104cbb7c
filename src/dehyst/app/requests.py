"""What can be typed after each command: options with their help, once; `dehyst.cli` makes parsers of them."""

from __future__ import annotations

from dataclasses import MISSING, dataclass, field
from pathlib import Path
from typing import Annotated, Any

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
        help="Past of the actuator. compensate takes unknown (plays) or rest, simulate takes model, as the log began.",
    ),
]
Band = Annotated[Path | None, typer.Option("--figure", help="Picture of the band, .svg or .png, with --unknown-state.")]


def option(flag: str, about: str, *, default: Any = None, needed: bool = False, **more: Any) -> Any:
    """Return the field of an option with its help; `more` is for its parser."""
    metadata = {"typed": typer.Option(flag, help=about, **more)}
    return field(metadata=metadata) if needed else field(default=default, metadata=metadata)


def argument(about: str, *, default: Any = MISSING, **more: Any) -> Any:
    """Return the field of an argument with its help."""
    metadata = {"typed": typer.Argument(help=about, **more)}
    return field(metadata=metadata) if default is MISSING else field(default=default, metadata=metadata)


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

    family: str = option(
        "--family",
        "auto: the best there is for this log; or pi (the paper), pi-cumulative, modified-pi, stop, static, direct-"
        "inverse, or any family of `dehyst compare`.",
        default="auto",
    )
    purpose: str = option(
        "--for",
        "What the model is for: compensate keeps the gain of the inverse low, simulate only the error.",
        default="compensate",
        metavar="compensate|simulate",
    )
    n: str = option("--n", "Number of operators, or auto: by held-out error.", default="100")
    eps: str | None = option(
        "--eps",
        "Smallest slope after a reversal, relative to the ranges; auto, the default: the firmest that costs less than "
        "5 % of the accuracy. For pi w_1 >= EPS, 0.001 (the paper) by default.",
        metavar="auto|EPS",
    )
    thresholds: str | None = option("--thresholds", "Thresholds instead of a grid, e.g. 0,0.5,1 [input].")
    initial_state: str = option("--initial-state", "auto, zero, rest, rising, falling or unknown.", default="auto")
    train_fraction: TrainFraction = None
    shear: str | None = option(
        "--shear", "Fit the loop around the diagonal, input + K output (pi only).", metavar="auto|K"
    )
    max_inverse_gain: float | None = option(
        "--max-inverse-gain", "Largest slope of the inverse [input/output]; sets eps.", metavar="G"
    )
    creep: int | None = option("--creep", "direct-inverse: number of time constants; by default as it helps.")
    creep_times: str | None = option("--creep-times", "direct-inverse: time constants instead, e.g. 4,25,150 [s].")
    load: LoadColumn = None
    mean_pressure: MeanPressureColumn = None
    position_schedule: bool = option(
        "--position-schedule/--no-position-schedule",
        "direct-inverse: whether weights may change with the output.",
        default=True,
    )
    save: Path | None = option("--save", "Write the model to this JSON file.")
    report: Path | None = option("--report", "Write a report page to this HTML file.")
    figures: Path | None = option("--figures", "Write every figure as SVG and PNG into this folder.")
    stream: bool | None = option(
        "--stream/--no-stream", "Read in chunks, in constant memory, or at once; without either, by size."
    )
    spool_dir: Path | None = option(
        "--spool-dir", "Folder of the temporary copy that streaming makes of text logs and bags."
    )
    overwrite: Overwrite = False
    json: Json = False


@dataclass(frozen=True)
class SimulateRequest:
    """Print a model's output for a logged input, as CSV."""

    model: Model
    log: Log
    column: str | None = option("--input", "Input column; by default the model's.")
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

    log: Path = argument("File with the motion the actuator should make.", metavar="reference")
    column: str | None = option("--output", "Column of the wanted output; by default the model's.")


@dataclass(frozen=True)
class DesignRequest:
    """Design the motion to run on a rig before an identification: loops, rates and holds, within limits."""

    joint: int | None = option("--joint", "Joint of the robot: limits come from its file.")
    robot: Path | None = option("--robot", "Parameter file of the arm, .toml; the packaged arm without it.")
    range: tuple[float, float] | None = option(
        "--range", "Range that the motion uses, and does not leave.", metavar="LO HI"
    )
    unit: str | None = option("--unit", "Unit of range, rate and acceleration; deg with --joint.")
    rate: float | None = option("--rate", "Largest rate [unit/s]; without it the range in 4 s.")
    acceleration: float | None = option(
        "--acceleration", "Largest acceleration [unit/s^2]; without it what that stroke takes."
    )
    time_limit: float = option("--time-limit", "Longest duration [s].", default=600.0)
    period: float = option("--period", "Time between two samples of --out [s].", default=0.02)
    out: Path | None = option("--out", "CSV file to write: time, command, part.")
    figure: Path | None = option("--figure", "Picture to write, .svg or .png.")
    purpose: str = option(
        "--for", "identification, or drift: cycles alike.", default="identification", metavar="PURPOSE"
    )
    overwrite: Overwrite = False
    json: Json = False


@dataclass(frozen=True)
class ReproduceRequest:
    """Run the paper's experiment on the simulated arm and write its report."""

    quick: bool = option("--quick", "One plant, one seed, shorter trials, no studies: less than 20 s.", default=False)
    plant: str | None = option("--plant", "all, maxwell-slip, preisach, dahl or none; several as preisach,none.")
    joint: str = option("--joint", "Joint that is compensated: 1, 2, 4 or all.", default="all")
    compensator: tuple[str, ...] = option(
        "--compensator",
        "paper, literal, scaled, direct, creep, scheduled, adaptive, ilc, maxwell-slip or best; several as paper,best.",
        default=("paper",),
    )
    controller: str = option(
        "--controller",
        "paper, vo-minh, sliding-mode, one-valve or pid; several as paper,pid: the report is about the first.",
        default="paper",
    )
    seed: int | None = option("--seed", "Run this seed only; without it 0, 1 and 2, with --quick 0.")
    cycles: int | None = option("--cycles", "Cycles of the path in every trial; 10 fast and 1 slow without it.")
    robot: Path | None = option("--robot", "Parameter file of the arm, .toml; the packaged arm without it.")
    out: Path = option("--out", "Folder for report and logs.", default=Path("reproduction"))
    figures: Path | None = option("--figures", "Write every figure as SVG and PNG into this folder.")
    json: Path | None = option("--json", "Write every figure to this JSON file too.")
    overwrite: Overwrite = False


@dataclass(frozen=True)
class SweepRequest:
    """Run the simulated experiment over many parameters; goes on where it was stopped. Status 1 if runs failed."""

    sweep: Path = argument("What to vary; see examples/sensitivity.toml.", metavar="SWEEP.toml")
    out: Path | None = option("--out", "Table to write, .csv or .parquet; SWEEP.csv here without it.")
    figure: Path | None = option("--figure", "Picture to write, .svg or .png; beside the table without it.")
    workers: int | None = option("--workers", "Processes; one a processor without it.")
    dask: str | None = option("--dask", "Run on the Dask cluster at this address, tcp://host:port.")
    restart: bool = option("--restart", "Drop finished runs of an earlier start.", default=False)
    retry: bool = option("--retry", "Run again what failed in an earlier start.", default=False)
    overwrite: Overwrite = False


@dataclass(frozen=True)
class DriftRequest:
    """Tell whether the actuator has changed since it was identified; exit status 1 if it has."""

    model: Model
    logs: tuple[Path, ...] = argument("New logs, in their order in time.", metavar="log")
    input: str | None = option("--input", "Input column; by default the model's.")
    output: str | None = option("--output", "Output column; by default the model's.")
    time: Time = None
    time_unit: TimeUnit = None
    runs: tuple[str, ...] = option("--run", "Run to use, if the logs hold several; repeat for more.", default=())
    start: Start = None
    stop: Stop = None
    reference: Path | None = option(
        "--reference", "Log of the new actuator; by default that of the model, if it is among the logs."
    )
    false_alarm: float = option(
        "--false-alarm", "Probability of a false alarm allowed to the whole call.", default=0.01
    )
    least: float | None = option("--least", "Smallest change worth a word, rms in percent of range.")
    load: str | None = option("--load", "Column of the load, if the model depends on it.")
    mean_pressure: str | None = option("--mean-pressure", "Column of the mean pressure, if the model depends on it.")
    ignore: tuple[str, ...] = option("--ignore", "Part that does not count, e.g. offset; repeat for more.", default=())
    refit: Path | None = option("--refit", "Identify anew; write this JSON file only if it is better.")
    report: Path | None = option("--report", "Write a report page to this HTML file.")
    overwrite: Overwrite = False
    json: Json = False


@dataclass(frozen=True)
class ExportRequest:
    """Write a model, its inverse or a joint controller as code for a target, with the proof beside it."""

    model: Model
    target: str = option("--target", "c, c-header, fmu2, fmu3, st, simulink or arduino.", needed=True)
    out: Path = option("--out", "Folder to write.", needed=True, metavar="DIR")
    real: str | None = option("--real", "double or float; without it double, for arduino float.")
    what: str = option("--what", "inverse, forward or joint-controller.", default="inverse")
    range: tuple[float, float] | None = option(
        "--range", "What the actuator can be given; else the identified range.", metavar="LO HI"
    )
    ramp: int | None = option("--ramp", "Samples over which switching on and off fades; 500 without it.")
    log: Path | None = option(
        "--log", "Your log: an excerpt becomes part of the check; of a model or its inverse, which take one column."
    )
    run: Run = None
    start: Start = None
    stop: Stop = None
    time: Time = None
    column: str | None = option("--column", "Its column that is the input of what is exported; else the model's.")
    controller: Path | None = option("--controller", "Parameters of the joint controller, JSON.")
    period: float | None = option("--period", "Of a unit that depends on time: between two samples [s].")
    follow_offset: float | None = option(
        "--follow-offset",
        "One more input, what was measured: an offset follows the last cycle, within this share of the output's range.",
        metavar="LIMIT",
    )
    name: str | None = option("--name", "C identifier; made of the model's file name without it.")
    prune: bool = option("--prune", "Drop operators of weight zero, which is exact.", default=False)
    overwrite: Overwrite = False
    json: Json = False


@dataclass(frozen=True)
class CompareRequest(LogsRequest):
    """Identify every hysteresis family from a log: errors, parameters, time, inverses, side by side."""

    families: str | None = option("--families", "Only these, with commas, e.g. pi,preisach,bouc-wen; default all.")
    train_fraction: TrainFraction = None
    seed: int = option("--seed", "Of the searches of families whose fit is not convex.", default=0)
    save: Path | None = option("--save", "Write the model of the best family to this JSON file.")
    report: Path | None = option("--report", "Write a report page to this HTML file.")
    figure: Path | None = option("--figure", "Write the picture to this file, .svg or .png.")
    overwrite: Overwrite = False
    json: Json = False


@dataclass(frozen=True)
class EvaluateRequest:
    """Score saved models of any family on another log: output, input of the inverse, and which one to run."""

    models: tuple[Path, ...] = argument("Model files, of any family.", metavar="MODEL...")
    log: Path = argument("Log that they were not identified from, such as one of use.")
    input: str | None = option("--input", "Input column; by default that of the models.")
    output: str | None = option("--output", "Output column; by default that of the models.")
    time: Time = None
    time_unit: TimeUnit = None
    runs: Runs = ()
    start: Start = None
    stop: Stop = None
    load: LoadColumn = None
    mean_pressure: MeanPressureColumn = None
    follow_offset: float | None = option(
        "--follow-offset",
        "Score with an offset that follows the last cycle, within this share of the output's range.",
        metavar="LIMIT",
    )
    json: Json = False


@dataclass(frozen=True)
class MuscleRequest:
    """Put a muscle model on a test bench: forces, loops, quick release; fit it to a bench log."""

    model: str | None = argument(
        "Name of a model, or file that --save wrote; see --list.", default=None, metavar="MODEL"
    )
    list_models: bool = option("--list", "List all models and their parameter sets.", default=False)
    which: str | None = option("--set", "Published parameter set; the first without it.")
    parameters: tuple[str, ...] = option(
        "--param", "Change a parameter; repeat for more.", default=(), metavar="NAME=VALUE"
    )
    length: str | None = option("--length", "Length at rest, 0.3 [m] or 300mm.")
    pressures: str | None = option("--pressures", "Pressures, e.g. 1,3,6 [bar].")
    contractions: str | None = option("--contractions", "Contractions, e.g. 0,10,20 [%].")
    loads: str | None = option("--loads", "Loads of the isotonic loops, e.g. 100,400 [N].")
    log: Path | None = option("--log", "Bench log to fit the model to.")
    contraction: str | None = option("--contraction", "Column of the contraction, a number, percent or mm.")
    length_column: str | None = option("--length-column", "Column of the length instead; needs --length.")
    pressure: str = option("--pressure", "Column of the gauge pressure.", default="pressure")
    force: str = option("--force", "Column of the force.", default="force")
    time: Time = None
    time_unit: TimeUnit = None
    run: Run = None
    start: Start = None
    stop: Stop = None
    contraction_unit: str | None = option("--contraction-unit", "Of contraction or length: 1, percent, mm, ...")
    pressure_unit: str | None = option("--pressure-unit", "bar, kPa, MPa, psi, ...")
    force_unit: str | None = option("--force-unit", "N, kN, lbf, ...")
    absolute: bool = option("--absolute", "The pressure is absolute.", default=False)
    at_rest: bool = option("--at-rest", "Every row is a point at rest, even if the log has time.", default=False)
    seed: int = option("--seed", "Of starts and of samples left out.", default=0)
    save: Path | None = option("--save", "Write the fitted model to this JSON file.")
    report: Path | None = option("--report", "Write a report page to this HTML file.")
    figure: Path | None = option("--figure", "Picture to write, .svg or .png.")
    overwrite: Overwrite = False
    json: Json = False
