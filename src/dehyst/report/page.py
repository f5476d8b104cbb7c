"""The page of a fit: sections, and lines to type next, as one self-contained HTML file."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from dehyst.data.recording import Recording
from dehyst.errors import OutputError
from dehyst.files import write_atomically
from dehyst.findings import Grade
from dehyst.identification.fit import Fit
from dehyst.report.figures import Figure, all_figures
from dehyst.report.judgement import in_words, lights, overall
from dehyst.report.rendering import pictures, rendered
from dehyst.report.svg import write_figure
from dehyst.report.tables import key_figures, tables
from dehyst.report.text import short
from dehyst.shell import quoted
from dehyst.shell import visible_lines as clean


def write_report(
    fit: Fit,
    path: str | os.PathLike[str],
    *,
    figures: str | os.PathLike[str] | None = None,
    model_file: str | os.PathLike[str] | None = None,
) -> Path:
    """Write the report of a fit: one HTML page that needs nothing else.

    The page works offline, on a phone, in print, light and dark, without JavaScript. Nothing from a log can run in
    it: names are escaped, and the page forbids scripts and every request.

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
    drawn = all_figures(fit)
    page = write_atomically(path, _render(fit, drawn, model_file))
    if figures is not None:
        _write_drawn(drawn, figures)
    return page


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
    return _write_drawn(all_figures(fit), folder)


def _write_drawn(drawn: tuple[Figure, ...], figures: str | os.PathLike[str]) -> Path:
    folder = make_folder(figures)
    for number, figure in enumerate(drawn, start=1):
        write_figure(figure, folder, number)
    return folder


def make_folder(figures: str | os.PathLike[str]) -> Path:
    """Make the folder for figures if it does not exist; raise `OutputError` if that cannot be."""
    folder = Path(figures)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as fault:
        raise OutputError(
            f"cannot make the folder '{folder}' for the figures: {fault.strerror}. "
            f"Name a folder that exists or can be made.",
            path=str(folder),
        ) from None
    return folder


def _render(fit: Fit, drawn: tuple[Figure, ...], model_file: str | os.PathLike[str] | None) -> str:
    first = fit.recordings[0]
    found = lights(fit)
    return rendered(
        "page.html",
        title=_title(fit),
        relation=f"{short(first.input_name, 60)} → {short(first.output_name, 60)}",
        fit=fit,
        lights=found,
        grade=overall(fit),
        words=in_words(fit, found),
        tiles=key_figures(fit),
        figures=pictures(drawn),
        tables=tables(fit),
        steps=next_steps(fit, model_file),
    )


def _title(fit: Fit) -> str:
    first = fit.recordings[0]
    others = f" and {len(fit.recordings) - 1} more" if len(fit.recordings) > 1 else ""
    return f"{short(first.name, 80)}{others}"


@dataclass(frozen=True, slots=True)
class Lines:
    """Something to type, and what it does."""

    purpose: str
    code: str


def next_steps(fit: Fit, model_file: str | os.PathLike[str] | None) -> tuple[Lines, ...]:
    """Return what to type next."""
    rec = fit.recordings[0]
    name = clean(os.fspath(model_file)) if model_file is not None else "model.json"
    file = quoted(name)
    x, y = (quoted(_column(rec, role)) for role in ("input", "output"))
    x_unit, y_unit = _one_line(rec.input_unit) or "its unit", _one_line(rec.output_unit) or "its unit"
    simulate = Lines("What the model says about another log", f"dehyst simulate {file} other_log.csv --input {x}")
    head = f"import dehyst\n\nmodel = dehyst.load({name!r})\n# input in {x_unit}, output in {y_unit}\n"
    at, period = (", time", f"{_period(fit):g}") if fit.model.rate_dependent else ("", "")
    one = "".join(f", {each}={each}_k" for each in fit.model.needs)
    more = at + "".join(f", {each}={each}" for each in fit.model.needs)
    if overall(fit) is Grade.BAD:
        cure = (
            "leave --family or --for simulate out"
            if fit.model.no_inverse
            else "look at the warnings above, cure what they name"
        )
        steps = [
            Lines(
                f"Do not compensate with this model: {cure}, and identify again. Until then it is for simulation "
                f"only. {simulate.purpose}",
                simulate.code,
            ),
            Lines("The same in Python", head + f"y = model.simulate(x{more})"),
        ]
    else:
        steps = [
            Lines(
                "The input that makes the actuator follow a reference",
                f"dehyst compensate {file} reference.csv --output {y}",
            ),
            simulate,
            Lines(
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
        steps.insert(0, Lines(keep, 'fit.model.save("model.json")'))
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
    return " ".join(clean(text).split())
