"""dehyst identify: a model and its verdict from logs, or a direct inverse."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from dehyst.app._logs import files_of, named_columns, read_logs, seconds_ahead
from dehyst.app._targets import (
    MODEL,
    PAGE,
    refuse_clashes,
    refuse_other_model,
    refuse_unwritable,
    save_model_file,
)
from dehyst.app._terminal import (  # fmt: skip
    ask_progress,
    print_end,
    print_findings,
    print_json,
    table,
    terminal,
)
from dehyst.app.requests import IdentifyRequest
from dehyst.errors import ParameterError
from dehyst.findings import Grade
from dehyst.identification import Fit, Score, identify, past_in_words
from dehyst.shell import command, schedules_to_type

if TYPE_CHECKING:
    from dehyst.app._processor import StepCost

DIRECT = "direct-inverse"
# A cause of what is left is named where it explains more than this share of it, and more than this percent of range.
MUCH, FELT = 0.3, 0.5


def run_identify(request: IdentifyRequest) -> None:
    """Read, identify, save, report, print."""
    # The files are checked first: the work may take long, and its result must not be lost at its end.
    refuse_clashes(
        files_of(request.logs),
        request.overwrite,
        save=(request.save, MODEL),
        report=(request.report, PAGE),
    )
    if request.save is not None:
        refuse_other_model(request.save, request.overwrite, files_of(request.logs), _known(request))
    if request.figures is not None:
        refuse_unwritable(request.figures, folder=True)
    _refuse_options(request)
    if request.processor is not None or request.period is not None:
        # What counts instructions loads all that exports.
        from dehyst.app._processor import refuse_processor

        refuse_processor(request.processor, request.period)
    request = named_columns("identify", request, request.json)
    fit, cost = _identify(request)
    if request.save is not None:
        save_model_file(request.save, request.overwrite, fit.model.save)
    if request.report is not None or request.figures is not None:
        with ask_progress("drawing", request.json):
            _report(fit, request)
    if request.json:
        figures = fit.as_dict()
        if cost is not None:
            figures["step"] = cost.as_dict()
        print_json(figures)
    else:
        _print(fit, request, cost)


def _refuse_options(request: IdentifyRequest) -> None:
    """Refuse options that say nothing to the family that was asked for."""
    direct = {
        "--creep": request.creep is not None,
        "--creep-times": request.creep_times is not None,
        "--no-position-schedule": not request.position_schedule,
    }
    forward = {
        "--n": request.n != "100",
        "--eps": request.eps is not None,
        "--thresholds": request.thresholds is not None,
        "--shear": request.shear is not None,
        "--max-inverse-gain": request.max_inverse_gain is not None,
        "--relative": request.relative,
    }
    sized = request.size is not None or request.processor is not None
    if request.family != "auto" and request.ahead != "auto":
        raise ParameterError(
            f"--ahead says how much of a dead time the default choice may take into the model, and --family "
            f"{request.family} has none. Leave one of them out."
        )
    if request.family == DIRECT and sized:
        raise ParameterError(
            f"--size and --processor make models smaller, and a {DIRECT} has the size that its terms take. Leave them "
            f"out; `dehyst export --period SECONDS` prints how much of the period a step takes."
        )
    if request.family == DIRECT:
        # A typed option that does nothing would let the user believe in a model that was not made.
        options, cure = forward, "another family"
        about = f"says nothing to --family {DIRECT}, whose terms are its own and which reads the log at once"
    else:
        options, cure = direct, "that family"
        about = f"belongs to --family {DIRECT}, and the family is {request.family}"
    wrong = [name for name, is_typed in options.items() if is_typed]
    if wrong:
        raise ParameterError(
            f"{' and '.join(wrong)} {about}. Leave it out, or choose {cure}.", options=wrong
        )


def _resonance(request: IdentifyRequest) -> str | tuple[float, float] | None:
    """Return a typed --resonance: "auto", frequency and damping, or None."""
    text = request.resonance
    if text == "auto":
        return text
    if text == "none":
        return None
    try:
        frequency, damping = map(float, text.split(","))
    except ValueError:
        frequency = damping = math.nan
    if not (math.isfinite(frequency) and math.isfinite(damping)):
        raise ParameterError(
            f"--resonance {text!r:.40} is neither auto nor none nor a frequency in Hz and a damping, two numbers with "
            f"a comma between them: --resonance 300,0.02. A damping that is not known is between 0.01 (steel) and "
            f"0.1 (with bearings)."
        )
    return frequency, damping


def _identify(request: IdentifyRequest) -> tuple[Fit, StepCost | None]:
    """Read the logs and identify what was asked for; with a processor also what a step takes there."""
    if request.family == DIRECT:
        return _identify_direct(request), None
    typed = {
        "n": (_operators(request.n), 100),
        "eps": (_eps(request), None),
        "thresholds": (_numbers("--thresholds", request.thresholds, "numbers", "0,0.5,1"), None),
        "initial_state": (request.initial_state, "auto"),
    }
    settings: dict[str, Any] = {}
    for name, (value, usual) in typed.items():
        # What was not typed is chosen by the identification itself.
        if value != usual:
            settings[name] = value
    settings |= {"family": request.family, "train_fraction": request.train_fraction}
    if request.shear is not None or request.max_inverse_gain is not None:
        settings |= {"shear": request.shear, "max_inverse_gain": request.max_inverse_gain}
    settings["ahead"] = seconds_ahead(request.ahead)
    settings["resonance"] = _resonance(request)
    settings["relative"] = request.relative
    with ask_progress("reading", request.json) as progress:
        records = [record for _, _, record in read_logs(request, progress)]

    def identify_with(family: str | None, size: int | None) -> Fit:
        sizes = [number for number in (size, request.size) if number is not None]
        most = min(sizes) if sizes else None
        if family is None:
            best: Fit = identify(records, purpose=request.purpose, size=most, **settings)
            return best
        fraction = request.train_fraction
        fit = identify(
            records,
            family,
            purpose=request.purpose,
            train_fraction=fraction,
            resonance=settings["resonance"],
            relative=request.relative,
        )
        if most is not None and fit.model.free_parameters > most:
            raise ParameterError(f"{family} has more than {most} numbers.")
        return fit

    with ask_progress("identifying", request.json):
        if request.processor is None:
            return identify_with(None, None), None
        from dehyst.app._processor import fit_for

        fit, cost, findings = fit_for(identify_with, request.processor, request.period)
    return replace(fit, warnings=(*fit.warnings, *findings)), cost


def _identify_direct(request: IdentifyRequest) -> Fit:
    with ask_progress("reading", request.json) as progress:
        read = read_logs(request, progress)
    with ask_progress("identifying", request.json):
        return identify(
            [record for _, _, record in read],
            DIRECT,
            creep="auto" if request.creep is None else request.creep,
            creep_times=_numbers("--creep-times", request.creep_times, "seconds", "4,25,150"),
            position_schedule=request.position_schedule,
            initial_state=request.initial_state,
            train_fraction=request.train_fraction,
        )


def _known(request: IdentifyRequest) -> dict[str, Any]:
    """Settings that stand in the model file as they were typed."""
    refused = (request.shear, request.max_inverse_gain, request.thresholds)
    if refused != (None, None, None) or request.family == DIRECT:
        return {}  # which come to others
    typed = {"n": _operators(request.n), "eps": _eps(request)}
    settings = {name: value for name, value in typed.items() if value not in (None, "auto")}
    if request.size is not None:
        settings["size"] = request.size
    return {"family": request.family, "initial_state": request.initial_state, **settings}


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
        raise ParameterError(
            f"{option} {text!r} is neither a number nor auto; it is {meaning}."
        ) from None


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
    """Write the page and the figures that were asked for."""
    from dehyst.report import write_figures, write_report

    if request.report is not None:
        write_report(fit, request.report, figures=request.figures, model_file=request.save)
    elif request.figures is not None:
        write_figures(fit, request.figures)


def _print(fit: Fit, request: IdentifyRequest, cost: StepCost | None = None) -> None:
    """Print the verdict, the scores, what the model was chosen from, and how exact it and its inverse are."""
    out, certificate, unit = terminal(), fit.certificate, fit.recordings[0].output_unit
    out.print(fit.verdict, style="bold")
    out.print()
    name = fit.family
    if fit.model.shear is not None:
        name = "sheared loop"
    scores: list[tuple[str, Score | None]] = [
        (f"{name}, fitted", fit.train),
        (f"{name}, held out", fit.test),
    ]
    if certificate.operators:
        # The curve tells what the memory is worth, so it is scored on the same samples as the model.
        part = "held out" if fit.test else "fitted"
        scores.append((f"no hysteresis, {part}", fit.static_test or fit.static_train))
    rows = [_score_row(label, score) for label, score in scores if score is not None]
    rms = ">rms"
    if unit:
        rms += f" [{unit}]"
    out.print(table(("", rms, ">rms [% of range]", ">NRMSE", ">max"), rows))
    if fit.table:
        out.print()
        _print_choice(fit)
        if fit.test and fit.settings.get("family") == "auto":
            out.print(
                "The choice was made without these held-out errors, on fifths left out of the fitted part."
            )
        if fit.passed_over:
            out.print(fit.passed_over, style="yellow")
    size = fit.size
    if " of " in size:
        size += " carry weight"
    out.print(f"\n{size or 'no operators'}; {fit.facts.loop_words}")
    if fit.facts.numbers is not None:
        out.print(fit.facts.numbers.words, soft_wrap=True)
    if fit.dead_band is not None:
        unit = ""
        if fit.recordings[0].input_unit:
            unit = f" {fit.recordings[0].input_unit}"
        range_words = ""
        if fit.dead_band_interval is not None:
            low, high = fit.dead_band_interval.low, fit.dead_band_interval.high
            range_words = f" (95 %: {low:.3g} to {high:.3g}{unit})"
        out.print(
            f"dead band {fit.dead_band.width:.3g}{unit}{range_words}, {fit.dead_band.percent:.2g} % of the input's "
            f"range: "
            f"so far the input moves behind a turn before the output does"
        )
    if size:
        out.print(f"assumed before the log: {past_in_words(certificate.initial_state)}")
    out.print(_certified(fit))
    if cost is not None:
        cure = ""
        if cost.fits and cost.real == "float":
            cure = "; in double it would not keep the period: export it with --real float"
        out.print(f"{cost.words}{cure}")
    if fit.model.remarks:
        out.print("; ".join(fit.model.remarks))
    if fit.family == DIRECT:
        out.print("\n".join(filter(None, (*fit.evidence_words, fit.lacking))))
    left = fit.residual.largest
    # What is left in the errors is worth a line where it is large and has one clear cause.
    if left is not None and left.share > MUCH and left.size_percent > FELT:
        out.print(fit.residual.suggestions[0])
    print_findings(fit.warnings)
    print_end(
        _next(fit, request.save, cost),
        model=request.save,
        report=request.report,
        figures=request.figures,
    )


def _score_row(label: str, score: Score) -> tuple[str, ...]:
    """Errors of one part of the log."""
    return (
        label,
        f"{score.rmse:.4g}",
        f"{score.rmse_percent:.2f}",
        f"{score.nrmse:.3f}",
        f"{score.max:.4g}",
    )


def _certified(fit: Fit) -> str:
    """How exactly the optimum was reached and the inverse undoes the model, and how much it amplifies."""
    certificate = fit.certificate
    drive, response = fit.recordings[0].input_unit, fit.recordings[0].output_unit
    slope = ""
    if drive and response:
        slope = f" {drive}/{response}"
    figures = (
        ("optimality", certificate.kkt_residual, ".0e", ""),
        ("inverse round trip", certificate.round_trip_error, ".0e", ""),
        ("inverse gain at most", certificate.inverse_gain, ".4g", slope),
    )
    words = []
    for label, value, digits, unit in figures:
        # A family without an optimum or a bounded inverse has NaN here, which says nothing to a reader.
        if math.isfinite(value):
            words.append(f"{label} {value:{digits}}{unit}")
    return ", ".join(words)


def _print_choice(fit: Fit) -> None:
    """From what the model was chosen: errors of the output, and of the input that the inverse asks for."""
    rows = []
    for row in fit.table:
        asked, tracking = "none", ""
        if not math.isnan(row.input_percent):
            asked = f"{row.input_percent:.2f}"
        if row.tracking_percent is not None:
            tracking = f"{row.tracking_percent:.2f}"
        errors = (f"{row.test_percent:.2f}", asked, tracking)
        rows.append((row.family, row.direction, *errors, "chosen" if row.chosen else ""))
    heads = ("% of range, rms", "direction", ">output", ">input", ">tracking", "")
    terminal().print(table(heads, rows))


def _next(fit: Fit, saved: Path | None, cost: StepCost | None = None) -> str:
    """What to do now; a compensator is offered only where the verdict allows one."""
    rec = fit.recordings[0]
    # Without a saved model the next command would have nothing to read.
    again = "repeat with --save model.json --report report.html"
    needs = schedules_to_type(fit.model.needs)
    simulate = command("simulate", saved, "LOG.csv", input=rec.input_name, **needs)
    bad = fit.grade is Grade.BAD
    if fit.settings.get("purpose") == "simulate" and (fit.model.no_inverse or not bad):
        return simulate if saved is not None else again
    if bad:
        cure = "cure what the warnings above name"
        if fit.model.no_inverse:
            cure = "leave --family out"
        advice = f"do not compensate with this model; {cure} and identify again"
        if saved is None:
            return advice
        return f"{advice}. To simulate only: {simulate}"
    if saved is None:
        return again
    if cost is not None:
        # The model file knows neither the period nor the precision that were asked about.
        real = cost.real if cost.real != "double" else None
        return command("export", saved, target="c", period=cost.period, real=real, out="unit")
    wing = fit.model.wing_to_type
    options = {"output": rec.output_name, "out": "compensated.csv", **needs, **wing}
    return command("compensate", saved, "REFERENCE.csv", **options)
