"""The report page of a fit: verdict, figures, next commands, tables."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from dehyst.data.recording import Recording
from dehyst.findings import Grade
from dehyst.identification.fit import Fit
from dehyst.report.figures import all_figures
from dehyst.report.judgement import in_words, lights, overall
from dehyst.report.page import write_figures_of, write_page
from dehyst.report.parts import Page, Section, Step, Tile, tables_section, warnings_section
from dehyst.report.tables import tables
from dehyst.report.text import number, short, with_unit
from dehyst.shell import command, visible_lines


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
    first, found, grade = fit.recordings[0], lights(fit), overall(fit)
    others = f" and {len(fit.recordings) - 1} more" if len(fit.recordings) > 1 else ""
    return Page(
        kind="Hysteresis identification",
        title=f"{short(first.name, 80)}{others}",
        relation=f"{short(first.input_name, 60)} → {short(first.output_name, 60)}",
        subject="hysteresis report",
        badge="for simulation only" if fit.model.no_inverse else grade.words,
        grade=grade,
        lead=fit.verdict,
        more=(" ".join(in_words(fit, found)),),
        tiles=tiles(fit),
        lights=found,
        sections=(
            *warnings_section(fit.warnings),
            *all_figures(fit),
            Section("next", "What to do next", next_steps(fit, model_file)),
            tables_section(*tables(fit)),
        ),
    )


def tiles(fit: Fit) -> tuple[Tile, ...]:
    """Return the numbers of the first screen."""
    unit, out = fit.recordings[0].input_unit, fit.recordings[0].output_unit
    test = Tile("Test RMSE", "–", "", "nothing was held out")
    if fit.test is not None:
        test = Tile("Test RMSE", number(fit.test.rmse_percent), "%", f"{with_unit(fit.test.rmse, out)}, held out")
    score = fit.test or fit.train
    static = (fit.test and fit.static_test) or fit.static_train
    return (
        test,
        Tile("Train RMSE", number(fit.train.rmse_percent), "%", f"{with_unit(fit.train.rmse, out)}, fitted"),
        Tile("Largest error", number(score.max), out, "fitted" if fit.test is None else "held out"),
        Tile("Without hysteresis", number(static.rmse_percent), "%", "RMSE of the best curve"),
        *_inverse_tiles(fit, f"{unit}/{out}" if unit and out else ""),
        Tile("Weights", str(fit.certificate.nonzero_weights), "", fit.size or "a curve without memory"),
        Tile("Loop width", number(fit.facts.width_percent, 2), "%", "of the output's range, at its widest"),
    )


def _inverse_tiles(fit: Fit, slope: str) -> tuple[Tile, ...]:
    gain, trip = fit.certificate.inverse_gain, fit.certificate.round_trip_error
    if fit.model.no_inverse:
        return tuple(Tile(name, "–", "", "there is no inverse") for name in ("Input error", "Input offset"))
    if not np.isnan(gain):
        return (
            Tile("Inverse gain", number(gain), slope, "largest slope"),
            Tile("Round trip error", number(trip, 2), "", "of the range"),
        )
    missed = fit.input_error  # families without a bound of the gain: what their inverse misses
    return (
        Tile("Input error", number(missed.rms_percent), "%", "of the input's range, rms"),
        Tile("Input offset", number(missed.bias_percent), "%", "of the input's range, mean"),
    )


def next_steps(fit: Fit, model_file: str | os.PathLike[str] | None) -> tuple[Step, ...]:
    """Return what to type next."""
    rec = fit.recordings[0]
    name = visible_lines(os.fspath(model_file)) if model_file is not None else "model.json"
    x, y = (_column(rec, role) for role in ("input", "output"))
    needs = dict.fromkeys(fit.model.needs, "COLUMN")
    x_unit, y_unit = _one_line(rec.input_unit) or "its unit", _one_line(rec.output_unit) or "its unit"
    line = command("simulate", name, "other_log.csv", input=x, **needs)
    simulate = Step("What the model says about another log", line)
    head = f"import dehyst\n\nmodel = dehyst.load({name!r})\n# input in {x_unit}, output in {y_unit}\n"
    at, period = (", time", f"{_period(fit):g}") if fit.model.rate_dependent else ("", "")
    one = "".join(f", {each}={each}_k" for each in fit.model.needs)
    more = at + "".join(f", {each}={each}" for each in fit.model.needs)
    if overall(fit) is Grade.BAD:
        cure = (
            "To compensate, leave --family or --for simulate out, and identify again."
            if fit.model.no_inverse
            else "Do not compensate with this model: look at the warnings above, cure what they name, and identify "
            "again. Until then it is for simulation only."
        )
        steps = [
            Step(f"{cure} {simulate.purpose}", simulate.code),
            Step("The same in Python", head + f"y = model.simulate(x{more})"),
        ]
    else:
        steps = [
            Step(
                "The input that makes the actuator follow a reference",
                command("compensate", name, "reference.csv", output=y, **needs),
            ),
            simulate,
            Step(
                "The same in Python, for whole signals and sample by sample in real time",
                head + f"y = model.simulate(x{more})\n"
                "inverse = model.inverse()\n"
                f"x = inverse.simulate(reference{more})\n\n"
                "# one sample at a time; the state lives in the stepper\n"
                f"step = inverse.stepper({period}){'  # seconds between two samples of your loop' if at else ''}\n"
                f"x_k = step(reference_k{one})",
            ),
        ]
    if model_file is None:
        keep = "Keep the model, in Python or with --save on the command line; this run was not told where"
        steps.insert(0, Step(keep, 'fit.model.save("model.json")'))
    return tuple(steps)


def _period(fit: Fit) -> float:
    """Seconds between two samples, as the model was identified or as the log was written."""
    time = fit.recordings[0].time
    known = fit.model.period
    return known or (0.001 if time is None else float(np.median(np.diff(time))))


def _column(recording: Recording, role: str) -> str:
    """Name of the column in the log, which may carry the unit: "pressure_bar" rather than "pressure"."""
    named = recording.provenance.get(role)
    return _one_line(named if isinstance(named, str) else getattr(recording, f"{role}_name"))


def _one_line(text: str) -> str:
    return " ".join(visible_lines(text).split())
