"""Arguments and options of every command: one dataclass per command, one field per option, with its help text."""

from __future__ import annotations

from dataclasses import MISSING, dataclass, field
from pathlib import Path
from typing import Any

COMMON = {  # name of a field -> its flag and its help, the same in every command that has it
    "input": ("--input", "Column that drives the actuator; by default by names and units."),
    "output": ("--output", "Column that responds; by default by names and units."),
    "time": ("--time", "Time column, if it is not found by itself."),
    "time_unit": (
        "--time-unit",
        "Unit of the time column, e.g. ms, or how many seconds one count is.",
    ),
    "sheet": (
        "--sheet",
        "Sheet of a workbook, by name or number; by default the one with the most numbers.",
    ),
    "dt": ("--dt", "Seconds from one row to the next, where the log has no time column."),
    "clocks": (
        "--clocks",
        "Of input and output in two files: keep their stamps, align them by the shape of the signals, or auto: keep "
        "equal stamps and dates.",
    ),
    "run": ("--run", "Run to use, if the log holds several."),
    "runs": ("--run", "Run to use, if a log holds several; repeat for more."),
    "start": ("--from", "Leave out samples before this time [s]."),
    "stop": ("--to", "Leave out samples from this time on [s]."),
    "schedules": (
        "--schedule",
        "Column of another signal that changes the loop (load, temperature, voltage); repeat for a second and a third.",
    ),
    "train_fraction": (
        "--train-fraction",
        "Share of each log that is fitted; the rest is the test. By default half, or of three logs whole ones.",
    ),
    "robot": ("--robot", "Parameter file of the arm, .toml; the packaged arm without it."),
    "report": ("--report", "Write a report page to this HTML file."),
    "figure": ("--figure", "Picture to write, .svg or .png."),
    "figures": ("--figures", "Write every figure as SVG and PNG into this folder."),
    "overwrite": ("--overwrite", "Replace files that exist already."),
    "json": ("--json", "Print the result as JSON and nothing else."),
}


def option(
    about: str = "", default: Any = None, *, flag: str = "", metavar: str | None = None
) -> Any:
    """Return the field of an option; without words about it, it is one of `COMMON`, its flag that of its name."""
    return field(
        default=default, kw_only=True, metadata={"about": about, "flag": flag, "metavar": metavar}
    )


def argument(about: str, default: Any = MISSING, *, metavar: str | None = None) -> Any:
    """Return the field of what is typed without a flag."""
    return field(default=default, metadata={"about": about, "metavar": metavar, "argument": True})


CLOCKS = "auto|stamps|shape"
LOGS = "One log file or several, fitted together; or input and output in two files: u.csv:COLUMN y.csv:COLUMN."
LOG = "Log file: .csv(.gz), .mat, .npz; with extras .mcap, .bag, .mf4, .parquet."
MODEL = "Model file written by `dehyst identify ... --save`."
BEGIN = "Past of the actuator; by default model: that of the identified log at its first sample."
PASTS = "unknown|rest|rising|falling|model"
INPUT, OUTPUT = "Input column; by default the model's.", "Output column; by default the model's."


@dataclass(frozen=True, eq=False)
class LogsRequest:
    """Which columns of logs are read, and which part of them."""

    input: str | None = option()
    output: str | None = option()
    time: str | None = option()
    time_unit: str | None = option()
    dt: float | None = option()
    sheet: str | None = option()
    runs: tuple[str, ...] = option(default=())
    start: tuple[float, ...] = option(
        "Leave out samples before this time [s]; several parts: repeat --from and --to.",
        default=(),
        flag="--from",
    )
    stop: tuple[float, ...] = option(
        "Leave out samples from this time on [s].", default=(), flag="--to"
    )
    schedules: tuple[str, ...] = option(default=(), metavar="[NAME=]COLUMN")


@dataclass(frozen=True, eq=False)
class IdentifyRequest(LogsRequest):
    """Identify a hysteresis model and its inverse from a log."""

    logs: tuple[Path, ...] = argument(LOGS, metavar="log")
    clocks: str = option(default="auto", metavar=CLOCKS)
    family: str = option(
        "auto: the best there is for this log; or pi (the paper), pi-cumulative, modified-pi, stop, static, direct-"
        "inverse, or any family of `dehyst compare`.",
        "auto",
    )
    purpose: str = option(
        "What the model is for: compensate keeps the gain of the inverse low, simulate only the error.",
        "compensate",
        flag="--for",
        metavar="compensate|simulate",
    )
    size: int | None = option(
        "At most so many numbers (weights, points of maps), for a small target; auto and rows of elements.",
        metavar="N",
    )
    ahead: str = option(
        "Longest dead time that the model may have, which is how long before its time the reference is known: auto, "
        "what the log shows; 0, none [s].",
        "auto",
        metavar="auto|SECONDS",
    )
    resonance: str = option(
        "Where the actuator rings: auto, where the log shows it; its frequency [Hz] and damping; or none.",
        "auto",
        metavar="auto|none|HZ,DAMPING",
    )
    processor: str | None = option(
        "cortex-m4f or cortex-m7: the best model whose compensator keeps its period there."
    )
    period: float | None = option(
        "Period of the controller on that processor [s]; by default that of the log."
    )
    relative: bool = option(
        "Errors count relative to the output of their log: small loops count as much as large ones.",
        False,
    )
    n: str = option("Number of operators, or auto: by held-out error.", "100")
    eps: str | None = option(
        "Smallest slope after a reversal, relative to the ranges; auto, the default: the largest that costs less than "
        "5 % of the accuracy. For pi w_1 >= EPS, 0.001 (the paper) by default.",
        metavar="auto|EPS",
    )
    thresholds: str | None = option("Thresholds instead of a grid, e.g. 0,0.5,1 [input].")
    initial_state: str = option("auto, zero, rest, rising, falling or unknown.", "auto")
    train_fraction: float | None = option()
    shear: float | None = option(
        "Fit the loop around the diagonal, input + K output (pi only).", metavar="K"
    )
    max_inverse_gain: float | None = option(
        "Largest slope of the inverse [input/output]; sets eps.", metavar="G"
    )
    creep: int | None = option("direct-inverse: number of time constants; by default as it helps.")
    creep_times: str | None = option("direct-inverse: time constants instead, e.g. 4,25,150 [s].")
    position_schedule: bool = option(
        "direct-inverse: whether weights may change with the output.",
        True,
        flag="--position-schedule/--no-position-schedule",
    )
    save: Path | None = option("Write the model to this JSON file.")
    report: Path | None = option()
    figures: Path | None = option()
    overwrite: bool = option(default=False)
    json: bool = option(default=False)


@dataclass(frozen=True, eq=False)
class CoupledRequest:
    """Identify several inputs that act on one or two outputs, such as the axes of a stage."""

    logs: tuple[Path, ...] = argument("One log or several of one rig.", metavar="log")
    inputs: tuple[str, ...] = option(
        "Column of an input; repeat for each, two or more.", (), flag="--input"
    )
    outputs: tuple[str, ...] = option(
        "Column of an output; repeat for a second.", (), flag="--output"
    )
    time: str | None = option()
    time_unit: str | None = option()
    dt: float | None = option()
    sheet: str | None = option()
    run: str | None = option()
    start: float | None = option()
    stop: float | None = option()
    train_fraction: float | None = option()
    save: Path | None = option(
        "Write the model to this file, for `dehyst simulate`, `compensate` and `export`."
    )
    export: Path | None = option(
        "Write C of the inverse into this folder, for `dehyst verify`.", metavar="DIR"
    )
    name: str = option("C identifier of the export.", "pair")
    real: str = option("double or float, of the export.", "double")
    period: float | None = option(
        "Between two samples of the export; that of the log without it [s]."
    )
    figure: Path | None = option()
    overwrite: bool = option(default=False)
    json: bool = option(default=False)


@dataclass(frozen=True, eq=False)
class SimulateRequest:
    """Print a model's output for a logged input, as CSV."""

    model: Path = argument(MODEL)
    log: Path = argument(LOG)
    column: str | None = option(INPUT, flag="--input")
    time: str | None = option()
    time_unit: str | None = option()
    dt: float | None = option()
    sheet: str | None = option()
    run: str | None = option()
    start: float | None = option()
    stop: float | None = option()
    out: Path | None = option("CSV file to write; without it, CSV goes to the terminal.")
    schedules: tuple[str, ...] = option(default=(), metavar="[NAME=]COLUMN")
    unknown_state: bool = option(
        "Assume nothing of the past: middle, low and high instead of one value.", False
    )
    past: tuple[float, float] | None = option(
        "What the signal cannot have left before; the identified range without it; no direct inverse.",
        metavar="LO HI",
    )
    begin: str | None = option(BEGIN, flag="--start", metavar=PASTS)
    after: Path | None = option(
        "Log of input and output that ends where this begins: the memory is the one that agrees with it.",
        metavar="LOG",
    )
    figure: Path | None = option("Picture of the band, .svg or .png, with --unknown-state.")
    overwrite: bool = option(default=False)


@dataclass(frozen=True, eq=False)
class CompensateRequest(SimulateRequest):
    """Print the input that makes the actuator follow a reference, as CSV."""

    log: Path = argument("File with the motion the actuator should make.", metavar="reference")
    column: str | None = option(
        "Column of the wanted output; by default the model's.", flag="--output"
    )
    wing: str | None = option(
        "Of a butterfly loop the wing that the actuator stays on: inputs above the turn, or below.",
        None,
        metavar="upper|lower",
    )
    ahead: str = option(
        "How long before its output each value is written: auto, the dead time of the model; 0, beside it [s].",
        "auto",
        metavar="auto|SECONDS",
    )


@dataclass(frozen=True, eq=False)
class InspectRequest:
    """Show columns, units, sampling, gaps and loops of a log, and the line to type next."""

    log: Path = argument(LOG)
    second: Path | None = argument(
        "Of input and output in two files, u.csv:COLUMN y.csv:COLUMN, the output.",
        None,
        metavar="output",
    )
    clocks: str = option(default="auto", metavar=CLOCKS)
    run: str | None = option()
    time_unit: str | None = option()
    dt: float | None = option()
    sheet: str | None = option()
    json: bool = option(default=False)


@dataclass(frozen=True, eq=False)
class LoopsRequest(LogsRequest):
    """Measure every loop of a log: width, opening, loss or area, coercivity, remanence, slopes, change by cycle."""

    logs: tuple[Path, ...] = argument(
        "One log file or several of one actuator; or two files: u.csv:COLUMN y.csv:COLUMN.",
        metavar="log",
    )
    clocks: str = option(default="auto", metavar=CLOCKS)
    symmetric: bool = option(
        "Complete half a loop, where there is no whole one, by odd symmetry about its centre.",
        False,
    )
    out: Path | None = option("Picture of where each number is measured, .svg or .png, or .html.")
    overwrite: bool = option(default=False)
    json: bool = option(default=False)


@dataclass(frozen=True, eq=False)
class SensorRequest(LogsRequest):
    """Data sheet of a sensor: non-linearity, hysteresis, creep, repeatability; with a model also those corrected."""

    logs: tuple[Path, ...] = argument(
        "One log file or several of one sensor; or two files: u.csv:READING y.csv:QUANTITY.",
        metavar="log",
    )
    input: str | None = option("Column of the reading of the sensor.", flag="--reading")
    output: str | None = option("Column of the true quantity, of a reference.", flag="--quantity")
    clocks: str = option(default="auto", metavar=CLOCKS)
    line: str = option(
        "Straight line that sensitivity and errors are measured from: terminal, through both ends; best, of the least "
        "largest deviation; zero, that through the lower end.",
        "terminal",
        metavar="terminal|best|zero",
    )
    model: Path | None = option(
        "Model file of `dehyst identify`: the same figures of the corrected reading, on what it was not fitted to."
    )
    out: Path | None = option("Picture of where each figure is measured, .svg or .png, or .html.")
    overwrite: bool = option(default=False)
    json: bool = option(default=False)


@dataclass(frozen=True, eq=False)
class ExampleRequest:
    """Write an example log: a simulated joint with Maxwell slip and creep."""

    out: Path = option("CSV file to write.", Path("example.csv"))
    seed: int = option("Seed of the sensor noise.", 0)
    overwrite: bool = option(default=False)


@dataclass(frozen=True, eq=False)
class DoctorRequest:
    """Show what is installed beside dehyst, what it is for, and what to type for what is missing."""

    json: bool = option(default=False)


@dataclass(frozen=True, eq=False)
class DesignRequest:
    """Design the motion to run on a rig before an identification: loops, rates and holds, within limits."""

    joint: int | None = option("Joint of the robot: limits come from its file.")
    robot: Path | None = option()
    range: tuple[float, float] | None = option(
        "Range that the motion uses, and does not leave.", metavar="LO HI"
    )
    unit: str | None = option("Unit of range, rate and acceleration; deg with --joint.")
    rate: float | None = option("Largest rate [unit/s]; without it the range in 4 s.")
    acceleration: float | None = option(
        "Largest acceleration [unit/s^2]; without it what that stroke takes."
    )
    time_limit: float | None = option("Longest duration [s]; without it 600, or what --hold takes.")
    period: float = option("Time between two samples of --out [s].", 0.02)
    hold: float | None = option(
        "Hold at rest at least so long once to either side [s], to see creep."
    )
    out: Path | None = option("CSV file to write: time, command, part.")
    figure: Path | None = option()
    purpose: str = option(
        "identification, or drift: cycles alike.", "identification", flag="--for", metavar="PURPOSE"
    )
    overwrite: bool = option(default=False)
    json: bool = option(default=False)


@dataclass(frozen=True, eq=False)
class DriftRequest(LogsRequest):
    """Tell whether the actuator has changed since it was identified; exit status 1 if it has."""

    input: str | None = option(INPUT)
    output: str | None = option(OUTPUT)
    model: Path = argument(MODEL)
    logs: tuple[Path, ...] = argument("New logs, in their order in time.", metavar="log")
    reference: Path | None = option(
        "Log of the new actuator; by default that of the model, if it is among the logs."
    )
    false_alarm: float = option("Probability of a false alarm allowed to the whole call.", 0.01)
    least: float | None = option("Smallest change worth reporting, rms in percent of range.")
    ignore: tuple[str, ...] = option("Part that does not count, e.g. offset; repeat for more.", ())
    refit: Path | None = option("Identify anew; write this JSON file only if it is better.")
    report: Path | None = option()
    overwrite: bool = option(default=False)
    json: bool = option(default=False)


@dataclass(frozen=True, eq=False)
class ExportRequest:
    """Write a model, its inverse or a joint controller as code for a target, with the proof beside it."""

    model: Path = argument(MODEL)
    target: str = option(
        "c, c-header, fmu2, fmu3, st, simulink, rust, ada or arduino; `dehyst doctor` lists those of other packages.",
        MISSING,
    )
    out: Path = option("Folder to write.", MISSING, metavar="DIR")
    real: str | None = option("double or float; without it double, for arduino float.")
    what: str = option("inverse, forward or joint-controller.", "inverse")
    range: tuple[float, float] | None = option(
        "What the actuator can be given; else the identified range.", metavar="LO HI"
    )
    ramp: int | None = option("Samples over which switching on and off fades; 500 without it.")
    log: Path | None = option(
        "Your log: an excerpt becomes part of the check; of a model or its inverse, which take one column."
    )
    run: str | None = option()
    start: float | None = option()
    stop: float | None = option()
    time: str | None = option()
    sheet: str | None = option()
    column: str | None = option(
        "Its column that is the input of what is exported; else the model's."
    )
    controller: Path | None = option("Parameters of the joint controller, JSON.")
    period: float | None = option("Of a unit that depends on time: between two samples [s].")
    follow_offset: float | None = option(
        "Add an offset that follows the last cycle, within this share of the output's range; the unit takes what was "
        "measured as one more input.",
        metavar="LIMIT",
    )
    retain: bool = option(
        "Of --target st: keep the memory over a power cycle, as VAR RETAIN.", False
    )
    tunable: bool = option(
        "c, c-header: scale, offset, limits and ramp can be changed while it runs.", False
    )
    name: str | None = option("C identifier; made of the model's file name without it.")
    prune: bool = option("Drop operators of weight zero, which is exact.", False)
    overwrite: bool = option(default=False)
    json: bool = option(default=False)


@dataclass(frozen=True, eq=False)
class VerifyRequest:
    """Compile and run an export, compare it with the model and with your log, sign it off."""

    folder: Path = argument("Folder written by `dehyst export`.", metavar="DIR")
    json: bool = option(default=False)


@dataclass(frozen=True, eq=False)
class CompareRequest(LogsRequest):
    """Identify every hysteresis family from a log: errors, parameters, time, inverses, side by side."""

    logs: tuple[Path, ...] = argument(LOGS, metavar="log")
    clocks: str = option(default="auto", metavar=CLOCKS)
    families: str | None = option(
        "Only these, with commas, e.g. pi,preisach,bouc-wen; default all."
    )
    train_fraction: float | None = option()
    seed: int = option("Of the searches of families whose fit is not convex.", 0)
    save: Path | None = option("Write the model of the best family to this JSON file.")
    report: Path | None = option()
    figure: Path | None = option()
    overwrite: bool = option(default=False)
    json: bool = option(default=False)


@dataclass(frozen=True, eq=False)
class EvaluateRequest(LogsRequest):
    """Score saved models of any family on another log: output, input of the inverse, and which one to run."""

    input: str | None = option(INPUT)
    output: str | None = option(OUTPUT)
    models: tuple[Path, ...] = argument("Model files, of any family.", metavar="MODEL...")
    log: Path = argument("Log that they were not identified from, such as one of use.")
    begin: str | None = option(BEGIN, flag="--start", metavar=f"{PASTS}|known")
    follow_offset: float | None = option(
        "Score with an offset that follows the last cycle, within this share of the output's range.",
        metavar="LIMIT",
    )
    json: bool = option(default=False)
