"""Command line: parse, call one function, print."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from dehyst.app.ending import end

app = typer.Typer(
    name="dehyst",
    help="From a logged hysteresis loop to a verified compensator.",
    epilog="Begin with `dehyst inspect LOG`, or with `dehyst example` if you have no log yet.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,  # plain help: starting rich would cost more than the command
)

Log = Annotated[Path, typer.Argument(help="Log file: .csv(.gz), .mat, .npz; with extras .mcap, .bag, .mf4, .parquet.")]
Logs = Annotated[list[Path], typer.Argument(help="One log file or several, fitted together.")]
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
Runs = Annotated[list[str] | None, typer.Option("--run", help="Run to use, if the log holds several; repeat for more.")]
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


def _version(wanted: bool) -> None:
    if wanted:
        from dehyst import __version__

        typer.echo(f"dehyst {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version and stop.")
    ] = False,
) -> None:
    """From a logged hysteresis loop to a verified compensator."""


@app.command()
def identify(
    log: Logs,
    input: Input = None,
    output: Output = None,
    time: Time = None,
    time_unit: TimeUnit = None,
    run: Runs = None,
    start: Start = None,
    stop: Stop = None,
    family: Annotated[
        str,
        typer.Option(
            "--family",
            help="auto: the best there is for this log; or pi (the paper), pi-cumulative, modified-pi, stop, static, "
            "direct-inverse, or any family of `dehyst compare`.",
        ),
    ] = "auto",
    purpose: Annotated[
        str,
        typer.Option(
            "--for",
            metavar="compensate|simulate",
            help="What the model is for: compensate keeps the gain of the inverse low, simulate only the error.",
        ),
    ] = "compensate",
    n: Annotated[str, typer.Option("--n", help="Number of operators, or auto: by held-out error.")] = "100",
    eps: Annotated[
        str | None,
        typer.Option(
            "--eps",
            metavar="auto|EPS",
            help="Smallest slope after a reversal, relative to the ranges; auto, the default: the firmest that costs "
            "less than 5 % of the accuracy. For pi w_1 >= EPS, 0.001 (the paper) by default.",
        ),
    ] = None,
    thresholds: Annotated[
        str | None, typer.Option("--thresholds", help="Thresholds instead of a grid, e.g. 0,0.5,1 [input].")
    ] = None,
    initial_state: Annotated[
        str, typer.Option("--initial-state", help="auto, zero, rest, rising, falling or unknown.")
    ] = "auto",
    train_fraction: TrainFraction = None,
    shear: Annotated[
        str | None,
        typer.Option("--shear", metavar="auto|K", help="Fit the loop around the diagonal, input + K output (pi only)."),
    ] = None,
    max_inverse_gain: Annotated[
        float | None,
        typer.Option("--max-inverse-gain", metavar="G", help="Largest slope of the inverse [input/output]; sets eps."),
    ] = None,
    creep: Annotated[
        int | None, typer.Option("--creep", help="direct-inverse: number of time constants; by default as it helps.")
    ] = None,
    creep_times: Annotated[
        str | None, typer.Option("--creep-times", help="direct-inverse: time constants instead, e.g. 4,25,150 [s].")
    ] = None,
    load: LoadColumn = None,
    mean_pressure: MeanPressureColumn = None,
    position_schedule: Annotated[
        bool,
        typer.Option(
            "--position-schedule/--no-position-schedule",
            help="direct-inverse: whether weights may change with the output.",
        ),
    ] = True,
    save: Annotated[Path | None, typer.Option("--save", help="Write the model to this JSON file.")] = None,
    report: Annotated[Path | None, typer.Option("--report", help="Write a report page to this HTML file.")] = None,
    figures: Annotated[
        Path | None, typer.Option("--figures", help="Write every figure as SVG and PNG into this folder.")
    ] = None,
    stream: Annotated[
        bool | None,
        typer.Option(
            "--stream/--no-stream",
            help="Read in chunks, in constant memory, or at once; without either, by size.",
        ),
    ] = None,
    spool_dir: Annotated[
        Path | None,
        typer.Option("--spool-dir", help="Folder of the temporary copy that streaming makes of text logs and bags."),
    ] = None,
    overwrite: Overwrite = False,
    json: Json = False,
) -> None:
    """Identify a hysteresis model and its inverse from a log."""
    from dehyst.app.identify import IdentifyRequest, run_identify

    request = IdentifyRequest(
        logs=tuple(log), input=input or "", output=output or "", time=time, time_unit=time_unit,
        runs=tuple(run or ()), start=start, stop=stop,
        family=family, purpose=purpose, n=n, eps=eps, thresholds=thresholds, initial_state=initial_state,
        train_fraction=train_fraction, save=save, report=report, figures=figures, overwrite=overwrite, json=json,
        stream=stream, spool_dir=spool_dir, shear=shear, max_inverse_gain=max_inverse_gain,
        creep=creep, creep_times=creep_times, load=load, mean_pressure=mean_pressure,
        position_schedule=position_schedule,
    )  # fmt: skip
    run_identify(request)


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


@app.command()
def simulate(
    model: Model,
    log: Log,
    input: Annotated[str | None, typer.Option("--input", help="Input column; by default the model's.")] = None,
    time: Time = None,
    time_unit: TimeUnit = None,
    run: Run = None,
    start: Start = None,
    stop: Stop = None,
    out: Out = None,
    load: LoadColumn = None,
    mean_pressure: MeanPressureColumn = None,
    unknown_state: UnknownState = False,
    past: Past = None,
    begin: Begin = None,
    figure: Band = None,
    overwrite: Overwrite = False,
) -> None:
    """Print a model's output for a logged input, as CSV."""
    from dehyst.app.play import PlayRequest, run_simulate

    run_simulate(
        PlayRequest(
            model, log, input, time, run, start, stop, out, overwrite, time_unit, load, mean_pressure,
            unknown_state, past, figure, begin,
        )
    )  # fmt: skip


@app.command()
def compensate(
    model: Model,
    reference: Annotated[Path, typer.Argument(help="File with the motion the actuator should make.")],
    output: Annotated[
        str | None, typer.Option("--output", help="Column of the wanted output; by default the model's.")
    ] = None,
    time: Time = None,
    time_unit: TimeUnit = None,
    run: Run = None,
    start: Start = None,
    stop: Stop = None,
    out: Out = None,
    load: LoadColumn = None,
    mean_pressure: MeanPressureColumn = None,
    unknown_state: UnknownState = False,
    past: Past = None,
    begin: Begin = None,
    figure: Band = None,
    overwrite: Overwrite = False,
) -> None:
    """Print the input that makes the actuator follow a reference, as CSV."""
    from dehyst.app.play import PlayRequest, run_compensate

    run_compensate(
        PlayRequest(
            model, reference, output, time, run, start, stop, out, overwrite, time_unit, load, mean_pressure,
            unknown_state, past, figure, begin,
        )
    )  # fmt: skip


@app.command()
def inspect(log: Log, run: Run = None, time_unit: TimeUnit = None, json: Json = False) -> None:
    """Show columns, units, sampling, gaps and loops of a log, and the line to type next."""
    from dehyst.app.inspect import run_inspect

    run_inspect(log, run, json, time_unit)


@app.command()
def example(
    out: Annotated[Path, typer.Option("--out", help="CSV file to write.")] = Path("example.csv"),
    seed: Annotated[int, typer.Option("--seed", help="Seed of the sensor noise.")] = 0,
    overwrite: Overwrite = False,
) -> None:
    """Write an example log: a simulated joint with Maxwell slip and creep."""
    from dehyst.app.example import run_example

    run_example(out, seed, overwrite)


@app.command()
def design(
    joint: Annotated[int | None, typer.Option("--joint", help="Joint of the robot: limits come from its file.")] = None,
    robot: Annotated[
        Path | None, typer.Option("--robot", help="Parameter file of the arm, .toml; the packaged arm without it.")
    ] = None,
    range: Annotated[
        tuple[float, float] | None,
        typer.Option("--range", metavar="LO HI", help="Range that the motion uses, and does not leave."),
    ] = None,
    unit: Annotated[
        str | None, typer.Option("--unit", help="Unit of range, rate and acceleration; deg with --joint.")
    ] = None,
    rate: Annotated[
        float | None, typer.Option("--rate", help="Largest rate [unit/s]; without it the range in 4 s.")
    ] = None,
    acceleration: Annotated[
        float | None,
        typer.Option("--acceleration", help="Largest acceleration [unit/s^2]; without it what that stroke takes."),
    ] = None,
    time_limit: Annotated[float, typer.Option("--time-limit", help="Longest duration [s].")] = 600.0,
    period: Annotated[float, typer.Option("--period", help="Time between two samples of --out [s].")] = 0.02,
    out: Annotated[Path | None, typer.Option("--out", help="CSV file to write: time, command, part.")] = None,
    figure: Annotated[Path | None, typer.Option("--figure", help="Picture to write, .svg or .png.")] = None,
    purpose: Annotated[
        str, typer.Option("--for", metavar="PURPOSE", help="identification, or drift: cycles alike.")
    ] = "identification",
    overwrite: Overwrite = False,
    json: Json = False,
) -> None:
    """Design the motion to run on a rig before an identification: loops, rates and holds, within limits."""
    from dehyst.app.design import DesignRequest, run_design

    run_design(
        DesignRequest(
            joint, robot, range, unit, rate, acceleration, time_limit, period, out, figure, overwrite, json, purpose
        )
    )


@app.command()
def reproduce(
    quick: Annotated[
        bool, typer.Option("--quick", help="One plant, one seed, shorter trials, no studies: less than 20 s.")
    ] = False,
    plant: Annotated[
        str | None,
        typer.Option("--plant", help="all, maxwell-slip, preisach, dahl or none; several as preisach,none."),
    ] = None,
    joint: Annotated[str, typer.Option("--joint", help="Joint that is compensated: 1, 2, 4 or all.")] = "all",
    compensator: Annotated[
        list[str],
        typer.Option(
            "--compensator",
            help="paper, literal, scaled, direct, creep, scheduled, adaptive, ilc, maxwell-slip or best; several as"
            " paper,best.",
        ),
    ] = ["paper"],  # noqa: B006
    controller: Annotated[
        str,
        typer.Option(
            "--controller",
            help="paper, vo-minh, sliding-mode, one-valve or pid; several as paper,pid: the report is about the first.",
        ),
    ] = "paper",
    seed: Annotated[
        int | None, typer.Option("--seed", help="Run this seed only; without it 0, 1 and 2, with --quick 0.")
    ] = None,
    cycles: Annotated[
        int | None, typer.Option("--cycles", help="Cycles of the path in every trial; 10 fast and 1 slow without it.")
    ] = None,
    robot: Annotated[
        Path | None, typer.Option("--robot", help="Parameter file of the arm, .toml; the packaged arm without it.")
    ] = None,
    out: Annotated[Path, typer.Option("--out", help="Folder for report and logs.")] = Path("reproduction"),
    figures: Annotated[
        Path | None, typer.Option("--figures", help="Write every figure as SVG and PNG into this folder.")
    ] = None,
    json: Annotated[Path | None, typer.Option("--json", help="Write every figure to this JSON file too.")] = None,
    overwrite: Overwrite = False,
) -> None:
    """Run the paper's experiment on the simulated arm and write its report."""
    from dehyst.app.reproduce import ReproduceRequest, run_reproduce

    run_reproduce(
        ReproduceRequest(
            quick,
            plant,
            joint,
            tuple(compensator),
            seed,
            cycles,
            robot,
            out,
            figures,
            json,
            overwrite,
            controller,
        )
    )


@app.command()
def sweep(
    file: Annotated[Path, typer.Argument(metavar="SWEEP.toml", help="What to vary; see examples/sensitivity.toml.")],
    out: Annotated[
        Path | None, typer.Option("--out", help="Table to write, .csv or .parquet; SWEEP.csv here without it.")
    ] = None,
    figure: Annotated[
        Path | None, typer.Option("--figure", help="Picture to write, .svg or .png; beside the table without it.")
    ] = None,
    workers: Annotated[int | None, typer.Option("--workers", help="Processes; one a processor without it.")] = None,
    dask: Annotated[
        str | None, typer.Option("--dask", help="Run on the Dask cluster at this address, tcp://host:port.")
    ] = None,
    restart: Annotated[bool, typer.Option("--restart", help="Drop finished runs of an earlier start.")] = False,
    retry: Annotated[bool, typer.Option("--retry", help="Run again what failed in an earlier start.")] = False,
    overwrite: Overwrite = False,
) -> None:
    """Run the simulated experiment over many parameters; goes on where it was stopped. Status 1 if runs failed."""
    from dehyst.app.sweep import SweepRequest, run_sweep_command

    run_sweep_command(SweepRequest(file, out, figure, workers, dask, restart, retry, overwrite))


@app.command()
def drift(
    model: Model,
    log: Annotated[list[Path], typer.Argument(help="New logs, in their order in time.")],
    input: Annotated[str | None, typer.Option("--input", help="Input column; by default the model's.")] = None,
    output: Annotated[str | None, typer.Option("--output", help="Output column; by default the model's.")] = None,
    time: Time = None,
    time_unit: TimeUnit = None,
    run: Annotated[
        list[str] | None, typer.Option("--run", help="Run to use, if the logs hold several; repeat for more.")
    ] = None,
    start: Start = None,
    stop: Stop = None,
    reference: Annotated[
        Path | None,
        typer.Option(
            "--reference", help="Log of the new actuator; by default that of the model, if it is among the logs."
        ),
    ] = None,
    false_alarm: Annotated[
        float, typer.Option("--false-alarm", help="Probability of a false alarm allowed to the whole call.")
    ] = 0.01,
    least: Annotated[
        float | None, typer.Option("--least", help="Smallest change worth a word, rms in percent of range.")
    ] = None,
    load: Annotated[str | None, typer.Option("--load", help="Column of the load, if the model depends on it.")] = None,
    mean_pressure: Annotated[
        str | None, typer.Option("--mean-pressure", help="Column of the mean pressure, if the model depends on it.")
    ] = None,
    ignore: Annotated[
        list[str] | None, typer.Option("--ignore", help="Part that does not count, e.g. offset; repeat for more.")
    ] = None,
    refit: Annotated[
        Path | None, typer.Option("--refit", help="Identify anew; write this JSON file only if it is better.")
    ] = None,
    report: Annotated[Path | None, typer.Option("--report", help="Write a report page to this HTML file.")] = None,
    overwrite: Overwrite = False,
    json: Json = False,
) -> None:
    """Tell whether the actuator has changed since it was identified; exit status 1 if it has."""
    from dehyst.app.drift import DriftRequest, run_drift

    run_drift(
        DriftRequest(
            model=model, logs=tuple(log), input=input, output=output, time=time, time_unit=time_unit,
            runs=tuple(run or ()), start=start, stop=stop, reference=reference, false_alarm=false_alarm, least=least,
            ignore=tuple(ignore or ()), refit=refit, report=report, overwrite=overwrite, json=json, load=load,
            mean_pressure=mean_pressure,
        )
    )  # fmt: skip


@app.command()
def export(
    model: Model,
    target: Annotated[str, typer.Option("--target", help="c, c-header, fmu2, fmu3, st, simulink or arduino.")],
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="Folder to write.")],
    real: Annotated[
        str | None, typer.Option("--real", help="double or float; without it double, for arduino float.")
    ] = None,
    what: Annotated[str, typer.Option("--what", help="inverse, forward or joint-controller.")] = "inverse",
    range: Annotated[
        tuple[float, float] | None,
        typer.Option("--range", metavar="LO HI", help="What the actuator can be given; else the identified range."),
    ] = None,
    ramp: Annotated[
        int | None, typer.Option("--ramp", help="Samples over which switching on and off fades; 500 without it.")
    ] = None,
    log: Annotated[
        Path | None,
        typer.Option(
            "--log",
            help="Your log: an excerpt becomes part of the check; of a model or its inverse, which take one column.",
        ),
    ] = None,
    run: Run = None,
    start: Start = None,
    stop: Stop = None,
    time: Time = None,
    column: Annotated[
        str | None,
        typer.Option("--column", help="Its column that is the input of what is exported; else the model's."),
    ] = None,
    controller: Annotated[
        Path | None, typer.Option("--controller", help="Parameters of the joint controller, JSON.")
    ] = None,
    period: Annotated[
        float | None, typer.Option("--period", help="Of a unit that depends on time: between two samples [s].")
    ] = None,
    name: Annotated[
        str | None, typer.Option("--name", help="C identifier; made of the model's file name without it.")
    ] = None,
    prune: Annotated[bool, typer.Option("--prune", help="Drop operators of weight zero, which is exact.")] = False,
    overwrite: Overwrite = False,
    json: Json = False,
) -> None:
    """Write a model, its inverse or a joint controller as code for a target, with the proof beside it."""
    from dehyst.app.export import run_export
    from dehyst.app.export_request import ExportRequest
    from dehyst.export.excerpt import Part

    run_export(
        ExportRequest(
            model, target, out, real, what, range, ramp, log, column, controller, name, prune, overwrite, json,
            Part(run, start, stop, time), period,
        )
    )  # fmt: skip


@app.command()
def verify(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="Folder written by `dehyst export`.")],
    json: Json = False,
) -> None:
    """Compile and run an export, compare it with the model and with your log, sign it off."""
    from dehyst.app.verify import run_verify

    run_verify(folder, json)


@app.command()
def compare(
    log: Logs,
    input: Input = None,
    output: Output = None,
    time: Time = None,
    time_unit: TimeUnit = None,
    run: Runs = None,
    start: Start = None,
    stop: Stop = None,
    families: Annotated[
        str | None, typer.Option("--families", help="Only these, with commas, e.g. pi,preisach,bouc-wen; default all.")
    ] = None,
    train_fraction: TrainFraction = None,
    seed: Annotated[int, typer.Option("--seed", help="Of the searches of families whose fit is not convex.")] = 0,
    save: Annotated[
        Path | None, typer.Option("--save", help="Write the model of the best family to this JSON file.")
    ] = None,
    report: Annotated[Path | None, typer.Option("--report", help="Write a report page to this HTML file.")] = None,
    figure: Annotated[
        Path | None, typer.Option("--figure", help="Write the picture to this file, .svg or .png.")
    ] = None,
    overwrite: Overwrite = False,
    json: Json = False,
) -> None:
    """Identify every hysteresis family from a log: errors, parameters, time, inverses, side by side."""
    from dehyst.app.compare import CompareRequest, run_compare

    run_compare(
        CompareRequest(
            tuple(log), input or "", output or "", time, time_unit, tuple(run or ()), start, stop, families,
            train_fraction, seed, save, report, figure, overwrite, json,
        )
    )  # fmt: skip


@app.command()
def evaluate(
    models: Annotated[list[Path], typer.Argument(metavar="MODEL...", help="Model files, of any family.")],
    log: Annotated[Path, typer.Argument(help="Log that they were not identified from, such as one of use.")],
    input: Annotated[str | None, typer.Option("--input", help="Input column; by default that of the models.")] = None,
    output: Annotated[
        str | None, typer.Option("--output", help="Output column; by default that of the models.")
    ] = None,
    time: Time = None,
    time_unit: TimeUnit = None,
    run: Runs = None,
    start: Start = None,
    stop: Stop = None,
    load: LoadColumn = None,
    mean_pressure: MeanPressureColumn = None,
    json: Json = False,
) -> None:
    """Score saved models of any family on another log: output, input of the inverse, and which one to run."""
    from dehyst.app.evaluate import EvaluateRequest, run_evaluate

    run_evaluate(
        EvaluateRequest(
            models=tuple(models), log=log, input=input, output=output, time=time, time_unit=time_unit,
            runs=tuple(run or ()), start=start, stop=stop, load=load, mean_pressure=mean_pressure, json=json,
        )
    )  # fmt: skip


@app.command()
def muscle(
    model: Annotated[
        str | None, typer.Argument(metavar="MODEL", help="Name of a model, or file that --save wrote; see --list.")
    ] = None,
    list_models: Annotated[bool, typer.Option("--list", help="List all models and their parameter sets.")] = False,
    which: Annotated[str | None, typer.Option("--set", help="Published parameter set; the first without it.")] = None,
    param: Annotated[
        list[str] | None, typer.Option("--param", metavar="NAME=VALUE", help="Change a parameter; repeat for more.")
    ] = None,
    length: Annotated[str | None, typer.Option("--length", help="Length at rest, 0.3 [m] or 300mm.")] = None,
    pressures: Annotated[str | None, typer.Option("--pressures", help="Pressures, e.g. 1,3,6 [bar].")] = None,
    contractions: Annotated[str | None, typer.Option("--contractions", help="Contractions, e.g. 0,10,20 [%].")] = None,
    loads: Annotated[str | None, typer.Option("--loads", help="Loads of the isotonic loops, e.g. 100,400 [N].")] = None,
    log: Annotated[Path | None, typer.Option("--log", help="Bench log to fit the model to.")] = None,
    contraction: Annotated[
        str | None, typer.Option("--contraction", help="Column of the contraction, a number, percent or mm.")
    ] = None,
    length_column: Annotated[
        str | None, typer.Option("--length-column", help="Column of the length instead; needs --length.")
    ] = None,
    pressure: Annotated[str, typer.Option("--pressure", help="Column of the gauge pressure.")] = "pressure",
    force: Annotated[str, typer.Option("--force", help="Column of the force.")] = "force",
    time: Time = None,
    time_unit: TimeUnit = None,
    run: Run = None,
    start: Start = None,
    stop: Stop = None,
    contraction_unit: Annotated[
        str | None, typer.Option("--contraction-unit", help="Of contraction or length: 1, percent, mm, ...")
    ] = None,
    pressure_unit: Annotated[str | None, typer.Option("--pressure-unit", help="bar, kPa, MPa, psi, ...")] = None,
    force_unit: Annotated[str | None, typer.Option("--force-unit", help="N, kN, lbf, ...")] = None,
    absolute: Annotated[bool, typer.Option("--absolute", help="The pressure is absolute.")] = False,
    at_rest: Annotated[
        bool, typer.Option("--at-rest", help="Every row is a point at rest, even if the log has time.")
    ] = False,
    seed: Annotated[int, typer.Option("--seed", help="Of starts and of samples left out.")] = 0,
    save: Annotated[Path | None, typer.Option("--save", help="Write the fitted model to this JSON file.")] = None,
    report: Annotated[Path | None, typer.Option("--report", help="Write a report page to this HTML file.")] = None,
    figure: Annotated[Path | None, typer.Option("--figure", help="Picture to write, .svg or .png.")] = None,
    overwrite: Overwrite = False,
    json: Json = False,
) -> None:
    """Put a muscle model on a test bench: forces, loops, quick release; fit it to a bench log."""
    from dehyst.app.muscle import MuscleRequest, run_muscle
    from dehyst.app.muscle_log import LogRequest

    bench_log = None
    if log is not None:
        bench_log = LogRequest(
            log, contraction, length_column, pressure, force, time, time_unit, run, start, stop,
            contraction_unit, pressure_unit, force_unit, absolute, at_rest,
        )  # fmt: skip
    run_muscle(
        MuscleRequest(
            model, list_models, which, tuple(param or ()), length, pressures, contractions, loads, bench_log, seed,
            save, report, figure, overwrite, json,
        )
    )  # fmt: skip


def main() -> None:
    """Run the command line; a fault that a user can cure ends with its message and no traceback."""
    end(app)
