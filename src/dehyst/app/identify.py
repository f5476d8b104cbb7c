"""dehyst identify: log -> model, verdict, report."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from dehyst.app.columns import named_columns, read_logs
from dehyst.app.identify_direct import DIRECT, identify_from, refuse_options
from dehyst.app.identify_stream import open_streams, progress_bar
from dehyst.app.requests import IdentifyRequest
from dehyst.app.targets import MODEL, PAGE, refuse_clashes, refuse_other_model, refuse_unwritable, save_model
from dehyst.app.terminal import ask_progress, print_end, print_findings, print_json, terminal
from dehyst.errors import ParameterError
from dehyst.families.best import PURPOSES, identify
from dehyst.findings import Grade, grade_of
from dehyst.identification import Fit, Score
from dehyst.identification.settings import PAPER_OPERATORS
from dehyst.identification.stream import identify_stream
from dehyst.shell import quoted

if TYPE_CHECKING:
    from rich.table import Table

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
    refuse_options(request)
    request = named_columns("identify", request, request.json)
    fit = _identify(request)
    if request.save is not None:
        save_model(request.save, request.overwrite, fit.model.save)
    if request.report is not None or request.figures is not None:
        with ask_progress("drawing", request.json):
            _report(fit, request)
    if request.json:
        print_json(fit.as_dict())
        return
    _print(fit, request)


def _identify(request: IdentifyRequest) -> Fit:
    if request.family == DIRECT:
        with ask_progress("reading", request.json):
            records = read_logs(request)
        return identify_from(request, records)
    typed = {
        "n": (_operators(request.n), PAPER_OPERATORS),
        "eps": (_eps(request) if request.eps != "auto" else None, None),
        "thresholds": (_thresholds(request.thresholds), None),
        "initial_state": (request.initial_state, "auto"),
    }
    settings: dict[str, Any] = {name: value for name, (value, usual) in typed.items() if value != usual}
    settings |= {"family": request.family, "train_fraction": request.train_fraction}
    if request.shear is not None or request.max_inverse_gain is not None:
        shear = _number("--shear", request.shear, "k of the sheared loop, input + k output")
        settings |= {"shear": shear, "max_inverse_gain": request.max_inverse_gain}
        _refuse_streaming(request)
    streams = None if "shear" in settings else open_streams(request)
    if streams is not None:
        with progress_bar(request.json) as show:
            return identify_stream(streams, progress=show, spool_dir=request.spool_dir, **settings)
    with ask_progress("reading", request.json):
        records = read_logs(request)
    with ask_progress("identifying", request.json):
        return identify(records, purpose=request.purpose, **settings)


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


def _refuse_streaming(request: IdentifyRequest) -> None:
    """Refuse what needs the log in memory."""
    if request.stream:
        raise ParameterError(
            "--shear and --max-inverse-gain compare several fits and need the log in memory; leave --stream out, or "
            "take a part of the log with --from and --to."
        )


def _thresholds(text: str | None) -> list[float] | None:
    if text is None:
        return None
    try:
        return [float(part) for part in text.split(",")]
    except ValueError:
        raise ParameterError(
            f"--thresholds {text!r} is not a list of numbers; write them with commas: --thresholds 0,0.5,1"
        ) from None


def _report(fit: Fit, request: IdentifyRequest) -> None:
    from dehyst.report import write_figures, write_report

    if request.report is not None:
        write_report(fit, request.report, figures=request.figures, model_file=request.save)
    elif request.figures is not None:
        write_figures(fit, request.figures)


def _print(fit: Fit, request: IdentifyRequest) -> None:
    from rich.table import Table
    from rich.text import Text

    out = terminal()
    out.print(Text(fit.verdict, style="bold"))
    out.print()
    unit = fit.recordings[0].output_unit
    table = Table(box=None, pad_edge=False)
    for name in ("", "rms" + (f" [{unit}]" if unit else ""), "rms [% of range]", "NRMSE", "max"):
        table.add_column(Text(name), justify="left" if not name else "right")
    certificate = fit.certificate
    name = "sheared loop" if fit.model.shear is not None else fit.family
    rows: list[tuple[str, Score | None]] = [(f"{name}, fitted", fit.train), (f"{name}, held out", fit.test)]
    if certificate.operators:
        rows.append(
            ("no hysteresis, held out" if fit.test else "no hysteresis, fitted", fit.static_test or fit.static_train)
        )
    for label, score in rows:
        if score is not None:
            table.add_row(
                Text(label), f"{score.rmse:.4g}", f"{score.rmse_percent:.2f}", f"{score.nrmse:.3f}", f"{score.max:.4g}"
            )
    out.print(table)
    if fit.table:
        out.print()
        out.print(_compared(fit))
        if fit.test and fit.settings.get("family") == "auto":
            out.print("The choice was made without these held-out errors, on blocks of the fitted part.")
    memory = f"{fit.size} carry weight; start state '{certificate.initial_state}'" if fit.size else "no operators"
    out.print(
        Text(
            f"\n{memory}; loop {fit.facts.orientation}, {fit.facts.width_percent:.0f} % wide\n"
            + ", ".join(
                f"{what} {value:{digits}}"
                for what, value, digits in (
                    ("optimality", certificate.kkt_residual, ".0e"),
                    ("inverse round trip", certificate.round_trip_error, ".0e"),
                    ("inverse gain at most", certificate.inverse_gain, ".4g"),
                )
                if math.isfinite(value)
            )
        )
    )
    if fit.model.remarks:
        out.print(Text("; ".join(fit.model.remarks)))
        out.print(Text("\n".join(filter(None, (*fit.evidence_words, fit.lacking)))))
    left = fit.residual.largest
    if left is not None and left.share > MUCH and left.size_percent > FELT:
        out.print(
            Text(
                f"{100.0 * left.share:.0f} % of the squared residual {left.words}, {left.size_percent:.2g} % of range "
                f"rms: what to try is in the report (--report)"
            )
        )
    print_findings(fit.warnings)
    print_end(out, _next(fit, request.save), model=request.save, report=request.report, figures=request.figures)


def _compared(fit: Fit) -> Table:
    """From what the model was chosen: errors of the output, and of the input that the inverse asks for."""
    from rich.table import Table
    from rich.text import Text

    table = Table(box=None, pad_edge=False)
    for name in ("% of range, rms", "direction", "output", "input", "tracking", ""):
        table.add_column(Text(name), justify="right" if name in ("output", "input", "tracking") else "left")
    for row in fit.table:
        table.add_row(
            Text(row.family), row.direction, f"{row.test_percent:.2f}",
            "none" if math.isnan(row.input_percent) else f"{row.input_percent:.2f}",
            "" if row.tracking_percent is None else f"{row.tracking_percent:.2f}", "chosen" if row.chosen else "",
        )  # fmt: skip
    return table


def _next(fit: Fit, saved: Path | None) -> str:
    """What to do now; a compensator is offered only where the verdict allows one."""
    rec = fit.recordings[0]
    model = quoted(saved)
    if grade_of(fit.verdict) is Grade.BAD:
        chosen = "--for simulate" if fit.settings.get("family") == "auto" else "--family"
        cure = f"leave {chosen} out" if fit.model.no_inverse else "cure what the warnings above name"
        advice = f"do not compensate with this model; {cure} and identify again"
        if saved is None:
            return advice
        return f"{advice}. To simulate only: dehyst simulate {model} LOG.csv --input {quoted(rec.input_name)}"
    if saved is None:
        return "repeat with --save model.json --report report.html"
    return f"dehyst compensate {model} REFERENCE.csv --output {quoted(rec.output_name)}"
