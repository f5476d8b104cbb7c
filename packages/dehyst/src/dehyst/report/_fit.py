"""The report page of a fit: verdict, figures, next commands, tables."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from dehyst.data import Recording
from dehyst.findings import Grade
from dehyst.identification import Fit
from dehyst.report._figures import all_figures
from dehyst.report._judgement import in_words, lights, overall
from dehyst.report._page import write_figures_of, write_page
from dehyst.report._parts import Page, PageSection, Step, Tile, tables_section, warnings_section
from dehyst.report._tables import tables
from dehyst.report._text import number, short, with_unit
from dehyst.shell import command, schedules_to_type, visible_lines


def write_report(
    fit: Fit,
    path: str | os.PathLike[str],
    *,
    figures: str | os.PathLike[str] | None = None,
    model_file: str | os.PathLike[str] | None = None,
) -> Path:
    """Write the report of a fit: one HTML page that needs nothing else.

    The page works offline, on a phone, in print, light and dark, without JavaScript; with it, a drag zooms a panel,
    and the values at the cursor are told. Nothing from a log can run in it: names are escaped, and the page forbids
    every request and every script but its own.

    Parameters
    ----------
    fit
        Result of `dehyst.identify`.
    path
        File to write, for example ``"report.html"``.
    figures
        Folder for every figure as SVG and PNG; made if it does not exist.
    model_file
        Where the model was saved, for the lines to type next.

    Returns
    -------
    path
        The page.

    Raises
    ------
    OutputError
        If a file cannot be written. An earlier file of that name stays as it was.

    Examples
    --------
    >>> import numpy as np, dehyst, pathlib, tempfile
    >>> x = 2 * np.sin(np.linspace(0, 20, 400)) * np.linspace(1, 0.3, 400)
    >>> y = dehyst.PrandtlIshlinskii([0.0, 0.6], [1.0, 0.5]).simulate(x)
    >>> fit = dehyst.identify(dehyst.Recording(input=x, output=y), family="pi")
    >>> page = write_report(fit, pathlib.Path(tempfile.mkdtemp()) / "report.html")
    >>> page.read_text(encoding="utf-8")[:15]
    '<!DOCTYPE html>'
    """
    return write_page(_page(fit, model_file), path, figures)


def write_figures(fit: Fit, folder: str | os.PathLike[str]) -> Path:
    """Write every figure of the report as SVG and PNG, without the page.

    Returns
    -------
    folder
        The folder, with files ``figure-1-loop.svg``, ``figure-1-loop.png`` and so on.

    Examples
    --------
    >>> import numpy as np, dehyst, pathlib, tempfile
    >>> x = 2 * np.sin(np.linspace(0, 20, 400)) * np.linspace(1, 0.3, 400)
    >>> y = dehyst.PrandtlIshlinskii([0.0, 0.6], [1.0, 0.5]).simulate(x)
    >>> fit = dehyst.identify(dehyst.Recording(input=x, output=y), family="pi")
    >>> folder = write_figures(fit, pathlib.Path(tempfile.mkdtemp()) / "figures")
    >>> (folder / "figure-1-loop.svg").is_file()
    True
    """
    return write_figures_of(_page(fit, None), folder)


def _page(fit: Fit, model_file: str | os.PathLike[str] | None) -> Page:
    """What the page of a fit shows, from its top to its end."""
    first, judged, grade = fit.recordings[0], lights(fit), overall(fit)
    title = short(first.name, 80)
    if len(fit.recordings) > 1:
        title += f" and {len(fit.recordings) - 1} more"
    # A model without an inverse is no compensator, however well it fits.
    badge = grade.words
    if fit.model.no_inverse and not fit.model.winged:
        badge = "for simulation only"
    return Page(
        kind="Hysteresis identification",
        title=title,
        relation=_relation(fit),
        subject="hysteresis report",
        badge=badge,
        grade=grade,
        lead=fit.verdict,
        more=(" ".join(in_words(fit, judged)), *_scheduled_words(fit)),
        tiles=tiles(fit),
        lights=judged,
        sections=(
            *warnings_section(fit.warnings),
            *all_figures(fit),
            PageSection("next", "What to do next", next_steps(fit, model_file)),
            tables_section(*tables(fit)),
        ),
    )


def _relation(fit: Fit) -> str:
    """Input and output, and the signals that the model goes with."""
    first = fit.recordings[0]
    words = f"{short(first.input_name, 60)} → {short(first.output_name, 60)}"
    if fit.model.needs:
        words += f", with {' and '.join(short(name, 60) for name in fit.model.needs)}"
    return words


def _scheduled_words(fit: Fit) -> tuple[str, ...]:
    """What to know of a model whose weights go with other signals; nothing of any other."""
    if not fit.model.needs:
        return ()
    ranges = []
    for card in fit.model.context:
        unit = f" {card.unit}" if card.unit else ""
        ranges.append(f"{short(card.name, 60)} ({card.low:.4g} to {card.high:.4g}{unit})")
    return (
        f"Its weights go with {' and '.join(ranges)}; beyond, those of the nearer end are held. The curve without "
        f"hysteresis and the plays that it is compared with do not know of that.",
    )


def tiles(fit: Fit) -> tuple[Tile, ...]:
    """Return the numbers of the first screen."""
    unit, out = fit.recordings[0].input_unit, fit.recordings[0].output_unit
    slope = ""
    if unit and out:
        slope = f"{unit}/{out}"
    test = Tile("Test RMSE", "–", "", "nothing was held out")
    judged_on = "fitted"
    if fit.test is not None:
        judged_on = "held out"
        test = Tile(
            "Test RMSE",
            number(fit.test.rmse_percent),
            "%",
            f"{with_unit(fit.test.rmse, out)}, held out",
        )
    # The curve is compared on the same samples as the model.
    score = fit.test or fit.train
    static = (fit.test and fit.static_test) or fit.static_train
    return (
        test,
        Tile(
            "Train RMSE",
            number(fit.train.rmse_percent),
            "%",
            f"{with_unit(fit.train.rmse, out)}, fitted",
        ),
        Tile("Largest error", number(score.max), out, judged_on),
        Tile("Without hysteresis", number(static.rmse_percent), "%", "RMSE of the best curve"),
        *_inverse_tiles(fit, slope),
        Tile(
            "Weights",
            str(fit.certificate.nonzero_weights),
            "",
            fit.size or "a curve without memory",
        ),
        Tile(
            "Loop opening",
            number(fit.facts.width_percent, 2),
            "%",
            "of the output's range, at its widest",
        ),
    )


def _inverse_tiles(fit: Fit, slope: str) -> tuple[Tile, ...]:
    """What the inverse does: its gain where that is bounded, else how far it misses."""
    gain, trip = fit.certificate.inverse_gain, fit.certificate.round_trip_error
    if fit.model.no_inverse:
        return (
            Tile("Input error", "–", "", "there is no inverse"),
            Tile("Input offset", "–", "", "there is no inverse"),
        )
    if not np.isnan(gain):
        return (
            Tile("Inverse gain", number(gain), slope, "largest slope"),
            Tile("Round trip error", number(trip, 2), "", "of the range"),
        )
    error = fit.input_error
    return (
        Tile("Input error", number(error.rms_percent), "%", "of the input's range, rms"),
        Tile("Input offset", number(error.bias_percent), "%", "of the input's range, mean"),
    )


def next_steps(fit: Fit, model_file: str | os.PathLike[str] | None) -> tuple[Step, ...]:
    """Return what to type next."""
    rec = fit.recordings[0]
    # A line that was typed as it stands must work: it names the user's own file and columns.
    name = "model.json"
    if model_file is not None:
        name = visible_lines(os.fspath(model_file))
    needs = schedules_to_type(fit.model.needs)
    line = command("simulate", name, "other_log.csv", input=_column(rec, "input"), **needs)
    simulate = Step("What the model says about another log", line)
    # The page must not offer a compensator that its own verdict forbids.
    if overall(fit) is Grade.BAD:
        cure = (
            "Do not compensate with this model: look at the warnings above, cure what they name, and identify "
            "again. Until then it is for simulation only."
        )
        if fit.model.no_inverse:
            cure = "To compensate, leave --family or --for simulate out, and identify again."
        steps = [
            Step(f"{cure} {simulate.purpose}", simulate.code),
            Step("The same in Python", _simulation(fit, name)),
        ]
    else:
        options = {"output": _column(rec, "output"), **needs, **fit.model.wing_to_type}
        line = command("compensate", name, "reference.csv", **options)
        steps = [
            Step("The input that makes the actuator follow a reference", line),
            simulate,
            Step(
                "The same in Python, for whole signals and sample by sample in real time",
                f"{_simulation(fit, name)}\n{_compensation(fit)}",
            ),
        ]
    if model_file is None:
        keep = "Keep the model, in Python or with --save on the command line; this run was not told where"
        steps.insert(0, Step(keep, 'fit.model.save("model.json")'))
    return tuple(steps)


def _signals(fit: Fit) -> str:
    """Further arguments of a simulation: the clock, and each scheduling signal by its name."""
    arguments = ""
    if fit.model.rate_dependent:
        arguments = ", time"
    return arguments + _keywords(fit, "")


def _keywords(fit: Fit, ending: str) -> str:
    """The scheduling signals as arguments; a name that Python does not take stands in a dictionary."""
    arguments = ""
    for place, need in enumerate(fit.model.needs, 1):
        if need.isidentifier():
            arguments += f", {need}={need}{ending}"
        else:
            arguments += f", **{{{need!r}: signal_{place}{ending}}}"
    return arguments


def _simulation(fit: Fit, name: str) -> str:
    """Lines of Python that load a model and run it."""
    rec = fit.recordings[0]
    x_unit = _one_line(rec.input_unit) or "its unit"
    y_unit = _one_line(rec.output_unit) or "its unit"
    return (
        f"import dehyst\n\nmodel = dehyst.load({name!r})\n# input in {x_unit}, output in {y_unit}\n"
        f"y = model.simulate(x{_signals(fit)})"
    )


def _compensation(fit: Fit) -> str:
    """Lines of Python that run the inverse of a model, over a signal and step by step."""
    stepper = "step = inverse.stepper()"
    if fit.model.rate_dependent:
        stepper = (
            f"step = inverse.stepper({_period(fit):g})  # seconds between two samples of your loop"
        )
    inverse = "model.inverse()"
    if fit.model.winged:
        inverse = 'model.wing("upper").inverse()'
    return (
        f"inverse = {inverse}\n"
        f"x = inverse.simulate(reference{_signals(fit)})\n\n"
        "# one sample at a time; the state lives in the stepper\n"
        f"{stepper}\n"
        f"x_k = step(reference_k{_keywords(fit, '_k')})"
    )


def _period(fit: Fit) -> float:
    """Seconds between two samples, as the model was identified or as the log was written."""
    time = fit.recordings[0].time
    period: float | None = fit.model.period
    if period:
        return period
    # Somebody who types the line changes the number: a millisecond is the period of many drives.
    if time is None:
        return 0.001
    return float(np.median(np.diff(time)))


def _column(recording: Recording, role: str) -> str:
    """Name of the column in the log, which may carry the unit: "pressure_bar" rather than "pressure"."""
    named = recording.provenance.get(role)
    if not isinstance(named, str):
        named = getattr(recording, f"{role}_name")
    return _one_line(named)


def _one_line(text: str) -> str:
    return " ".join(visible_lines(text).split())
