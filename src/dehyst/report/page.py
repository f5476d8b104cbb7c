"""Sections -> one self-contained HTML page."""

from __future__ import annotations

import os
from pathlib import Path

from dehyst.errors import OutputError
from dehyst.files import write_atomically
from dehyst.identification.fit import Fit
from dehyst.report.figures import Figure, all_figures
from dehyst.report.judgement import in_words, lights, overall
from dehyst.report.next_steps import next_steps
from dehyst.report.rendering import pictures, rendered
from dehyst.report.svg import write_figure
from dehyst.report.tables import key_figures, tables
from dehyst.report.text import short


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

    Parameters
    ----------
    fit
        Result of `dehyst.identify`.
    folder
        Where to; made if it does not exist.

    Returns
    -------
    folder
        The folder, with files ``figure-1-loop.svg``, ``figure-1-loop.png`` and so on.

    Raises
    ------
    OutputError
        If the folder cannot be made or a file cannot be written.

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
