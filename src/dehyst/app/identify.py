"""dehyst identify: a model and its verdict from logs, in memory, in chunks, or as a direct inverse."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from dehyst.app.logs import is_large, named_columns, read_logs, signals_of
from dehyst.app.requests import IdentifyRequest
from dehyst.app.targets import MODEL, PAGE, refuse_clashes, refuse_other_model, refuse_unwritable, save_model
from dehyst.app.terminal import (
    ask_progress,
    print_end,
    print_findings,
    print_json,
    progress_bar,
    table,
    terminal,
)  # fmt: skip
from dehyst.errors import DehystError, LogError, ParameterError
from dehyst.families.best import PURPOSES, identify
from dehyst.findings import Grade, grade_of
from dehyst.identification import Fit, Score, identify_direct
from dehyst.identification.memory import past_in_words
from dehyst.identification.settings import PAPER_OPERATORS
from dehyst.identification.stream import Progress, identify_stream
from dehyst.io.chunks import ChunkedLog, open_chunks
from dehyst.shell import command

if TYPE_CHECKING:
    from rich.console import Console

DIRECT = "direct-inverse"
# A cause of what is left is named where it explains more than this share of it, and more than this percent of range.
MUCH, FELT = 0.3, 0.5


def run_identify(request: IdentifyRequest) -> None:
    """Read, identify, save, report, print."""
    if request.purpose not in PURPOSES:
        raise ParameterError(f"--for {request.purpose!r:.40} is none; write --for {' or --for '.join(PURPOSES)}.")
    refuse_clashes(request.logs, request.overwrite, save=(request.save, MODEL), report=(request.report, PAGE))
    if request.save is not None:
        refuse_other_model(request.save, request.overwrite, request.logs, _known(request))
    if request.figures is not None:
        refuse_unwritable(request.figures, folder=True)
    _refuse_options(request)
    request = named_columns("identify", request, request.json)
    fit = _identify(request)
    if request.save is not None:
        save_model(request.save, request.overwrite, fit.model.save)
    if request.report is not None or request.figures is not None:
        with ask_progress("drawing", request.json):
            _report(fit, request)
    if request.json:
        print_json(fit.as_dict())
    else:
        _print(fit, request)


def _refuse_options(request: IdentifyRequest) -> None:
    """Refuse options that say nothing to the family that was asked for."""
    direct = {
        "--creep": request.creep is not None,
        "--creep-times": request.creep_times is not None,
        "--load": request.load is not None,
        "--mean-pressure": request.mean_pressure is not None,
        "--no-position-schedule": not request.position_schedule,
    }
    forward = {
        "--n": request.n != "100",
        "--eps": request.eps is not None,
        "--thresholds": request.thresholds is not None,
        "--stream": request.stream is True,
        "--spool-dir": request.spool_dir is not None,
        "--shear": request.shear is not None,
        "--max-inverse-gain": request.max_inverse_gain is not None,
    }
    is_direct = request.family == DIRECT
    wrong = [name for name, given in (forward if is_direct else direct).items() if given]
    if not wrong:
        return
    about = (
        f"says nothing to --family {DIRECT}, whose terms are its own and which reads the log at once"
        if is_direct
        else f"belongs to --family {DIRECT}, and the family is {request.family}"
    )
    raise ParameterError(
        f"{' and '.join(wrong)} {about}. Leave it out, or choose {'another family' if is_direct else 'that family'}.",
        options=wrong,
    )


def _identify(request: IdentifyRequest) -> Fit:
    if request.family == DIRECT:
        return _identify_direct(request)
    typed = {
        "n": (_operators(request.n), PAPER_OPERATORS),
        "eps": (_eps(request), None),
        "thresholds": (_numbers("--thresholds", request.thresholds, "numbers", "0,0.5,1"), None),
        "initial_state": (request.initial_state, "auto"),
    }
    settings: dict[str, Any] = {name: value for name, (value, usual) in typed.items() if value != usual}
    settings |= {"family": request.family, "train_fraction": request.train_fraction}
    if request.shear is not None or request.max_inverse_gain is not None:
        shear = _number("--shear", request.shear, "k of the sheared loop, input + k output")
        settings |= {"shear": shear, "max_inverse_gain": request.max_inverse_gain}
        if request.stream:
            raise ParameterError(
                "--shear and --max-inverse-gain compare several fits and need the log in memory; leave --stream out, "
                "or take a part of the log with --from and --to."
            )
    streams = None if "shear" in settings else _open_streams(request)
    if streams is not None:
        with stream_progress(request.json) as show:
            return identify_stream(streams, progress=show, spool_dir=request.spool_dir, **settings)
    with ask_progress("reading", request.json):
        records = [record for _, _, record in read_logs(request)]
    with ask_progress("identifying", request.json):
        return identify(records, purpose=request.purpose, **settings)


def _identify_direct(request: IdentifyRequest) -> Fit:
    with ask_progress("reading", request.json):
        read = read_logs(request)
        signals, units = signals_of(request, read)
    more: dict[str, Any] = dict(signals)
    with ask_progress("identifying", request.json):
        return identify_direct(
            [record for _, _, record in read],
            creep="auto" if request.creep is None else request.creep,
            creep_times=_numbers("--creep-times", request.creep_times, "seconds", "4,25,150"),
            units=units,
            position_schedule=request.position_schedule,
            initial_state=request.initial_state,
            train_fraction=request.train_fraction,
            **more,
        )


def _open_streams(request: IdentifyRequest) -> list[ChunkedLog] | None:
    """Open the logs of a request in chunks if it asks for that, or if they are large; None: read them at once.

    Raises
    ------
    ParameterError
        If streaming was asked for together with what it does not do.
    DehystError
        If streaming was asked for and a log cannot be read in chunks.
    """
    windowed = bool(request.start or request.stop)
    if request.stream and windowed:
        raise ParameterError(
            "--stream reads whole logs: --from and --to do not go with it. Leave them out, cut the log into files "
            "beforehand, or read it at once with --no-stream."
        )
    if request.stream and request.sheet is not None:
        raise ParameterError("--stream reads no workbooks: leave out --sheet, or --stream.")
    large = request.stream is None and not windowed and request.sheet is None and is_large(request.logs)
    if not request.stream and not large:
        return None
    columns = request.input or "", request.output or "", request.time
    try:
        return [
            open_chunks(log, *columns, run=run, time_unit=request.time_unit, dt=request.dt)
            for log in request.logs
            for run in request.runs or (None,)
        ]
    except DehystError as fault:
        # Nobody asked for chunks: a format that cannot be read in them is read at once, as smaller logs are.
        if request.stream or type(fault) is not LogError:
            raise
        return None


@contextmanager
def stream_progress(quiet: bool, console: Console | None = None) -> Iterator[Callable[[Progress], None] | None]:
    """Show stage, share and bytes of a long identification, on a terminal only."""
    from rich.progress import BarColumn, DownloadColumn, TextColumn, TimeRemainingColumn

    columns = (TextColumn("{task.description}"), BarColumn(), DownloadColumn(), TimeRemainingColumn())
    with progress_bar(*columns, quiet=quiet, console=console) as bar:
        if bar is None:
            yield None
            return
        task = bar.add_task("reading")
        stage = ""

        def show(now: Progress) -> None:
            nonlocal stage
            if now.stage != stage:
                stage = now.stage
                bar.reset(task, description=f"{now.stage}, {now.number} of {now.of}")
            bar.update(task, completed=now.done, total=now.total or None)

        yield show


def _known(request: IdentifyRequest) -> dict[str, Any]:
    """Settings that stand in the model file as they were typed."""
    given = (request.shear, request.max_inverse_gain, request.thresholds)
    if given != (None, None, None) or request.family == DIRECT:
        return {}  # which come to others
    typed = {"n": _operators(request.n), "eps": _eps(request)}
    kept = {name: value for name, value in typed.items() if value not in (None, "auto")}
    return {"family": request.family, "initial_state": request.initial_state, **kept}


def _operators(text: str) -> int | str:
    if text == "auto":
        return text
    try:
        return int(text)
    except ValueError:
        raise ParameterError(
            f"--n {text!r} is neither a whole number nor auto; write --n 100, or --n auto to choose by held-out error."
        ) from None


def _eps(request: IdentifyRequest) -> float | str | None:
    return _number("--eps", request.eps, "the smallest slope after a reversal, such as 0.1")


def _number(option: str, text: str | None, meaning: str) -> float | str | None:
    if text is None or text == "auto":
        return text
    try:
        return float(text)
    except ValueError:
        raise ParameterError(f"{option} {text!r} is neither a number nor auto; it is {meaning}.") from None


def _numbers(option: str, text: str | None, kind: str, example: str) -> list[float] | None:
    if text is None:
        return None
    try:
        return [float(part) for part in text.split(",")]
    except ValueError:
        raise ParameterError(
            f"{option} {text!r} is not a list of {kind}; write them with commas: {option} {example}"
        ) from None


def _report(fit: Fit, request: IdentifyRequest) -> None:
    from dehyst.report import write_figures, write_report

    if request.report is not None:
        write_report(fit, request.report, figures=request.figures, model_file=request.save)
    elif request.figures is not None:
        write_figures(fit, request.figures)


def _print(fit: Fit, request: IdentifyRequest) -> None:
    out, certificate, unit = terminal(), fit.certificate, fit.recordings[0].output_unit
    out.print(fit.verdict, style="bold")
    out.print()
    name = "sheared loop" if fit.model.shear is not None else fit.family
    scores: list[tuple[str, Score | None]] = [(f"{name}, fitted", fit.train), (f"{name}, held out", fit.test)]
    if certificate.operators:
        label = "no hysteresis, held out" if fit.test else "no hysteresis, fitted"
        scores.append((label, fit.static_test or fit.static_train))
    rows = [
        (label, f"{score.rmse:.4g}", f"{score.rmse_percent:.2f}", f"{score.nrmse:.3f}", f"{score.max:.4g}")
        for label, score in scores
        if score is not None
    ]
    out.print(table(("", f">rms [{unit}]" if unit else ">rms", ">rms [% of range]", ">NRMSE", ">max"), rows))
    if fit.table:
        out.print()
        _print_choice(fit)
        if fit.test and fit.settings.get("family") == "auto":
            out.print("The choice was made without these held-out errors, on blocks of the fitted part.")
    size = f"{fit.size} carry weight" if " of " in fit.size else fit.size
    drive = fit.recordings[0].input_unit
    figures = (
        ("optimality", certificate.kkt_residual, ".0e", ""),
        ("inverse round trip", certificate.round_trip_error, ".0e", ""),
        ("inverse gain at most", certificate.inverse_gain, ".4g", f" {drive}/{unit}" if drive and unit else ""),
    )
    out.print(f"\n{size or 'no operators'}; {fit.facts.loop_words}")
    if size:
        out.print(f"assumed before the log: {past_in_words(certificate.initial_state)}")
    out.print(", ".join(f"{what} {value:{digits}}{of}" for what, value, digits, of in figures if math.isfinite(value)))
    if fit.model.remarks:
        out.print("; ".join(fit.model.remarks))
        out.print("\n".join(filter(None, (*fit.evidence_words, fit.lacking))))
    left = fit.residual.largest
    if left is not None and left.share > MUCH and left.size_percent > FELT:
        out.print(fit.residual.suggestions[0])
    print_findings(fit.warnings)
    print_end(_next(fit, request.save), model=request.save, report=request.report, figures=request.figures)


def _print_choice(fit: Fit) -> None:
    """From what the model was chosen: errors of the output, and of the input that the inverse asks for."""
    rows = [
        (
            row.family, row.direction, f"{row.test_percent:.2f}",
            "none" if math.isnan(row.input_percent) else f"{row.input_percent:.2f}",
            "" if row.tracking_percent is None else f"{row.tracking_percent:.2f}", "chosen" if row.chosen else "",
        )
        for row in fit.table
    ]  # fmt: skip
    terminal().print(table(("% of range, rms", "direction", ">output", ">input", ">tracking", ""), rows))


def _next(fit: Fit, saved: Path | None) -> str:
    """What to do now; a compensator is offered only where the verdict allows one."""
    rec = fit.recordings[0]
    needs = dict.fromkeys(fit.model.needs, "COLUMN")
    simulate = command("simulate", saved, "LOG.csv", input=rec.input_name, **needs)
    bad = grade_of(fit.verdict) is Grade.BAD
    if fit.settings.get("purpose") == "simulate" and (fit.model.no_inverse or not bad):
        return simulate if saved is not None else "repeat with --save model.json --report report.html"
    if bad:
        cure = "leave --family out" if fit.model.no_inverse else "cure what the warnings above name"
        advice = f"do not compensate with this model; {cure} and identify again"
        if saved is None:
            return advice
        return f"{advice}. To simulate only: {simulate}"
    if saved is None:
        return "repeat with --save model.json --report report.html"
    return command("compensate", saved, "REFERENCE.csv", output=rec.output_name, **needs)
