"""The report page of a drift test: has the actuator changed since its model was identified?"""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from dehyst.arrays import Array
from dehyst.findings import Finding, Grade
from dehyst.monitoring import NAMES, Drift, JudgedModel, LogDrift, other_way
from dehyst.report._drawing import DASHED, PanelLine, chart
from dehyst.report._page import write_page
from dehyst.report._parts import (
    Axes,
    Draw,
    Page,
    PageFigure,
    PageTable,
    Panel,
    numbered,
    tables_section,
    warnings_section,
)
from dehyst.report._policy import POLICY
from dehyst.report._tables import settings_rows
from dehyst.report._text import bracketed, number, short, with_unit
from dehyst.report._theme import DATA, FIFTH, MODEL, MUTED, SIXTH, STATIC, TEST, TRAIN, ThemeColour

GRADES = {
    "unchanged": Grade.GOOD,
    "drifted": Grade.BAD,
    "not comparable": Grade.CARE,
    "cannot tell": Grade.CARE,
}
# Parts drawn over the cycles in percent.
PARTS: tuple[tuple[str, ThemeColour], ...] = (
    ("hysteresis", TEST),
    ("gain", TRAIN),
    ("creep", SIXTH),
    ("own-creep", SIXTH),
    ("viscous", MUTED),
    ("bend", FIFTH),
    ("s-bend", STATIC),
)

LOGS_SHOWN = 6  # with a table of changes: the last ones


def write_drift_report(
    drift: Drift, path: str | os.PathLike[str], model_name: str = "the model"
) -> Path:
    """Write the page of a check for drift: one HTML file that needs nothing else.

    Parameters
    ----------
    drift
        Result of `dehyst.drift`.
    path
        File to write, for example ``"drift.html"``.
    model_name
        What the model is called on the page.

    Returns
    -------
    path
        The page.

    Raises
    ------
    OutputError
        If the file cannot be written. An earlier file of that name stays as it was.

    Examples
    --------
    >>> import numpy as np, dehyst, pathlib, tempfile
    >>> x = np.sin(np.linspace(0, 40 * np.pi, 4001))
    >>> model = dehyst.PrandtlIshlinskii([0.0, 0.5], [1.0, 1.0])
    >>> found = dehyst.drift(model, dehyst.Recording(input=x, output=model.simulate(x) + 0.1))
    >>> page = write_drift_report(found, pathlib.Path(tempfile.mkdtemp()) / "drift.html")
    >>> page.read_text(encoding="utf-8")[:15]
    '<!DOCTYPE html>'
    """
    card = drift.model.card
    # What was met in reading comes before what limits the judgement, as on the terminal.
    findings: list[Finding] = []
    for entry in drift.logs:
        findings += entry.findings
    findings += drift.findings
    refit: tuple[str, ...] = ()
    if drift.acceptance is not None:
        refit = (drift.acceptance.reason,)
    page = Page(
        kind="Has the actuator changed?",
        title=short(model_name, 80),
        relation=f"{short(card.input.name, 60)} → {short(card.output.name, 60)}",
        subject="drift",
        badge=drift.status,
        grade=GRADES[drift.status],
        lead=drift.verdict,
        more=refit,
        sections=(
            *drift_figures(drift),
            *warnings_section(findings),
            tables_section(*_tables(drift)),
        ),
    )
    return write_page(page, path)


def drift_figures(drift: Drift) -> tuple[PageFigure, ...]:
    """Return the figures of the page: error over the cycles, parts over the cycles, loop then and now."""
    scored = [entry for entry in drift.logs if entry.blocks is not None]
    if not scored:
        return ()
    figures = [_error_figure(drift, scored), _parts_figure(scored)]
    loop = _loop_figure(scored, JudgedModel.of(drift.model))
    if loop is not None:
        figures.append(loop)
    return numbered(figures)


def _series(scored: Sequence[LogDrift], part: str) -> list[tuple[Array, Array]]:
    """Cycle numbers and values of each log: "error", "inverse" or a part."""
    series = []
    for entry in scored:
        blocks = entry.blocks
        assert blocks is not None
        if part == "error":
            values: Array | None = blocks.error_percent
        elif part == "inverse":
            values = blocks.inverse_percent
        else:
            values = blocks.changes.get(part)
        if values is not None:
            series.append((blocks.cycle, values))
    return series


def _error_figure(drift: Drift, scored: Sequence[LogDrift]) -> PageFigure:
    """Error of the model over the cycles, and of the model read the other way."""
    identified = drift.identified_percent
    line = ""
    if identified is not None:
        line = (
            f" The dashed line is the error when the model was identified, {number(identified)} %."
        )
    way = "as its inverse"
    if JudgedModel.of(drift.model).backward:
        way = "forward"
    panels = [
        Panel(
            "Error of the model",
            _over_cycles(scored, [("error", "", TRAIN)], identified, "rms error [% of range]"),
            f"RMS error over the number of the cycle.{line}",
        )
    ]
    caption = (
        "Error of the identified model on the logs, a dot for each cycle or block of cycles; vertical lines separate "
        f"the logs.{line}"
    )
    if _series(scored, "inverse"):
        draw = _over_cycles(scored, [("inverse", "", FIFTH)], None, "rms error [% of range]")
        words = f"RMS error of the model used {way}, over the number of the cycle."
        panels.append(Panel(f"Error of the model used {way}", draw, words))
        caption += f" Right: the same with the model used {way}."
    return PageFigure("error", "Error over the cycles", caption, tuple(panels))


def _parts_figure(scored: Sequence[LogDrift]) -> PageFigure:
    """Changes of the parts over the cycles, those left out that no log tells."""
    # A part that no log can measure scatters so widely that it would hide the others in the picture.
    telling = set()
    unit = ""
    for entry in scored:
        for change in entry.changes:
            if change.detectable <= POLICY.telling or change.drifted:
                telling.add(change.part)
            if change.part == "offset":
                unit = unit or change.unit
    parts, untold = [], []
    for part, token in PARTS:
        if not _series(scored, part):
            continue
        if part in telling:
            parts.append((part, NAMES[part], token))
        else:
            untold.append(NAMES[part])
    caption = (
        "Change of each part against the model, fitted to each cycle or block of cycles by itself: hysteresis and gain "
        "in percent of themselves, creep and curve in percent of the response's range (rms)."
    )
    if untold:
        caption += f" Not drawn, as no log would show a change below {POLICY.telling:g} %: {', '.join(untold)}."
    return PageFigure(
        "parts",
        "What changed",
        caption,
        (
            Panel(
                "Parts",
                _over_cycles(scored, parts, 0.0, "change [%]"),
                "Changes in percent over the number of the cycle.",
            ),
            Panel(
                "Offset",
                _over_cycles(scored, [("offset", "", MODEL)], 0.0, f"offset{bracketed(unit)}"),
                "Offset over the number of the cycle.",
            ),
        ),
    )


def _over_cycles(
    scored: Sequence[LogDrift],
    parts: Sequence[tuple[str, str, ThemeColour]],
    level: float | None,
    up: str,
) -> Draw:
    """Draw parts over the cycles, with a border after each log."""
    lines = []
    for part, name, token in parts:
        for cycle, values in _series(scored, part):
            lines.append(PanelLine(cycle, values, token, name, 0.7, marker="o"))
    # Half a cycle behind the last block, so that a border lies between two dots.
    ends = []
    for entry in scored[:-1]:
        if entry.blocks is not None:
            ends.append(float(entry.blocks.cycle[-1]) + 0.5)

    def borders(axes: Axes) -> None:
        if level is not None:
            axes.axhline(level, color=MUTED.light, lw=0.9, ls=DASHED, zorder=1)
        for end in ends:
            axes.axvline(end, color=MUTED.light, lw=0.7, zorder=1)

    # The dashed line must be seen, even where all dots lie far from it.
    include: list[float] = []
    if level is not None:
        include.append(level)
    return chart("cycle", up, lines, include=include, also=borders)


def _loop_figure(scored: Sequence[LogDrift], subject: JudgedModel) -> PageFigure | None:
    # A log of the reference alone shows the actuator as it was, and is drawn only if there is no other.
    now = next((entry for entry in reversed(scored) if entry.tested), scored[-1])
    if now.recording is None or now.response is None or now.shown[1] <= now.shown[0]:
        return None
    span, across = slice(*now.shown), subject.drive.label
    drive, response = subject.signals(now.recording)
    x, measured, model = drive[span], response[span], now.response[span]
    lines = [
        PanelLine(x, measured, DATA, "now", 2.2),
        PanelLine(x, model, MODEL, "then (model)", 1.0, outline=True, order=3.0),
    ]
    difference = chart(
        across,
        f"now less then{bracketed(subject.response.unit)}",
        [PanelLine(x, measured - model, TEST, width=0.9)],
        zero=True,
    )
    return PageFigure(
        "loop",
        "The loop then and now",
        f"The last cycles of {short(now.name, 60)}: measured, and as the model that was identified says they would "
        "have been.",
        (
            Panel(
                "Loop",
                chart(across, subject.response.label, lines),
                f"Loop of {now.name}, measured and of the model.",
            ),
            Panel("Difference", difference, "Measured less model over the same input."),
        ),
    )


def _tables(drift: Drift) -> tuple[PageTable, ...]:
    """The tables of the page; those without rows are left out, except two."""
    logs, reasons = [], []
    for entry in drift.logs:
        errors = (number(entry.error_percent), number(entry.inverse_percent))
        logs.append((entry.name, entry.status, str(entry.cycles), *errors))
        if entry.reason:
            reasons.append((entry.name, entry.reason))
    trends = []
    for trend in drift.trends:
        interval = f"{number(trend.low)} to {number(trend.high)}"
        trends.append((trend.part, with_unit(trend.slope, trend.unit), interval))
    other_direction = other_way(JudgedModel.of(drift.model).backward)
    head = ("log", "verdict", "cycles", "error [% of range]", f"{other_direction} [% of range]")
    made = (
        PageTable("Logs", head, tuple(logs)),
        PageTable("Not comparable", (), tuple(reasons)),
        *map(_changes_table, drift.logs[-LOGS_SHOWN:]),
        PageTable("Trends in 100 cycles", ("part", "slope", "interval"), tuple(trends)),
        PageTable("Settings", (), settings_rows(drift.settings)),
    )
    return tuple(table for table in made if table.rows or table.title in ("Logs", "Settings"))


def _changes_table(entry: LogDrift) -> PageTable:
    """Changes of one log."""
    rows = []
    for change in entry.changes:
        name = NAMES[change.part]
        if change.drifted:
            name += " *"
        rows.append(
            (
                name,
                with_unit(change.estimate, change.unit),
                f"{number(change.low)} to {number(change.high)}",
                number(change.effect_percent, 2),
                with_unit(change.detectable, change.unit, 2),
                number(change.p_value, 2),
            )
        )
    return PageTable(
        f"Changes: {entry.name}",
        ("part", "change", "95 % interval", "effect [% of range]", "would be seen from", "p"),
        tuple(rows),
        "* counts as drift",
    )
