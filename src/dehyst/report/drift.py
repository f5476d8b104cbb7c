"""The report page of a drift test: has the actuator changed since its model was identified?"""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from dehyst.arrays import Array
from dehyst.findings import Grade
from dehyst.monitoring import Drift, LogDrift
from dehyst.monitoring.parts import NAMES, Subject
from dehyst.monitoring.result import other_way
from dehyst.report.drawing import DASHED, Line, chart
from dehyst.report.page import write_page
from dehyst.report.parts import Axes, Draw, Figure, Page, Panel, Table, numbered, tables_section, warnings_section
from dehyst.report.tables import settings_rows
from dehyst.report.text import bracketed, number, short, with_unit
from dehyst.report.theme import DATA, FIFTH, MODEL, MUTED, SIXTH, STATIC, TEST, TRAIN, Token

GRADES = {"unchanged": Grade.GOOD, "drifted": Grade.BAD, "not comparable": Grade.CARE, "cannot tell": Grade.CARE}
# Parts drawn over the cycles in percent.
PARTS: tuple[tuple[str, Token], ...] = (
    ("hysteresis", TEST),
    ("gain", TRAIN),
    ("creep", SIXTH),
    ("own-creep", SIXTH),
    ("viscous", MUTED),
    ("bend", FIFTH),
    ("s-bend", STATIC),
)

TELLING = 100.0  # percent: a part that only a larger change would show is noise, not a line
LOGS_SHOWN = 6  # with a table of changes: the last ones


def write_drift_report(found: Drift, path: str | os.PathLike[str], model_name: str = "the model") -> Path:
    """Write the page of a check for drift: one HTML file that needs nothing else.

    Parameters
    ----------
    found
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
    card = found.model.card
    page = Page(
        kind="Has the actuator changed?",
        title=short(model_name, 80),
        relation=f"{short(card.input.name, 60)} → {short(card.output.name, 60)}",
        subject="drift",
        badge=found.status,
        grade=GRADES[found.status],
        lead=found.verdict,
        more=() if found.acceptance is None else (found.acceptance.reason,),
        sections=(
            *drift_figures(found),
            *warnings_section([*(f for entry in found.logs for f in entry.findings), *found.findings]),
            tables_section(*_tables(found)),
        ),
    )
    return write_page(page, path)


def drift_figures(found: Drift) -> tuple[Figure, ...]:
    """Return the figures of the page: error over the cycles, parts over the cycles, loop then and now."""
    scored = [entry for entry in found.logs if entry.blocks is not None]
    if not scored:
        return ()
    drawn = [_error_figure(found, scored), _parts_figure(scored), _loop_figure(scored, Subject.of(found.model))]
    return numbered([figure for figure in drawn if figure is not None])


def _series(scored: Sequence[LogDrift], part: str) -> list[tuple[Array, Array]]:
    """Cycle numbers and values of each log: "error", "inverse" or a part."""
    found = []
    for entry in scored:
        blocks = entry.blocks
        assert blocks is not None
        values = {"error": blocks.error_percent, "inverse": blocks.inverse_percent}.get(part, blocks.changes.get(part))
        if values is not None:
            found.append((blocks.cycle, values))
    return found


def _error_figure(found: Drift, scored: Sequence[LogDrift]) -> Figure:
    known = found.identified_percent
    line = "" if known is None else f" The dashed line is the error when the model was identified, {number(known)} %."
    way = "forward" if Subject.of(found.model).backward else "as its inverse"
    panels = [
        Panel(
            "Error of the model",
            _over_cycles(scored, [("error", "", TRAIN)], known, "rms error [% of range]"),
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
    return Figure("error", "Error over the cycles", caption, tuple(panels))


def _parts_figure(scored: Sequence[LogDrift]) -> Figure:
    seen = {c.part for entry in scored for c in entry.changes if c.detectable <= TELLING or c.drifted}
    told = [(part, NAMES[part], token) for part, token in PARTS if part in seen and _series(scored, part)]
    untold = ", ".join(NAMES[part] for part, _ in PARTS if part not in seen and _series(scored, part))
    left_out = f" Not drawn, as no log would show a change below {TELLING:g} %: {untold}." if untold else ""
    unit = next((c.unit for entry in scored for c in entry.changes if c.part == "offset"), "")
    return Figure(
        "parts",
        "What changed",
        "Change of each part against the model, fitted to each cycle or block of cycles by itself: hysteresis and gain "
        "in percent of themselves, creep and curve in percent of the response's range (rms)." + left_out,
        (
            Panel(
                "Parts",
                _over_cycles(scored, told, 0.0, "change [%]"),
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
    scored: Sequence[LogDrift], parts: Sequence[tuple[str, str, Token]], level: float | None, up: str
) -> Draw:
    lines = [
        Line(cycle, values, token, name, 0.7, marker="o")
        for part, name, token in parts
        for cycle, values in _series(scored, part)
    ]
    ends = [float(entry.blocks.cycle[-1]) + 0.5 for entry in scored[:-1] if entry.blocks is not None]

    def borders(axes: Axes) -> None:
        if level is not None:
            axes.axhline(level, color=MUTED.light, lw=0.9, ls=DASHED, zorder=1)
        for end in ends:
            axes.axvline(end, color=MUTED.light, lw=0.7, zorder=1)

    return chart("cycle", up, lines, include=() if level is None else (level,), also=borders)


def _loop_figure(scored: Sequence[LogDrift], subject: Subject) -> Figure | None:
    now = next((entry for entry in reversed(scored) if entry.tested), scored[-1])
    if now.recording is None or now.response is None or now.shown[1] <= now.shown[0]:
        return None
    span, across = slice(*now.shown), subject.drive.label
    x, measured = (signal[span] for signal in subject.signals(now.recording))
    model = now.response[span]
    lines = [Line(x, measured, DATA, "now", 2.2), Line(x, model, MODEL, "then (model)", 1.0, outline=True, order=3.0)]
    difference = chart(
        across,
        f"now less then{bracketed(subject.response.unit)}",
        [Line(x, measured - model, TEST, width=0.9)],
        zero=True,
    )
    return Figure(
        "loop",
        "The loop then and now",
        f"The last cycles of {short(now.name, 60)}: measured, and as the model that was identified says they would "
        "have been.",
        (
            Panel(
                "Loop", chart(across, subject.response.label, lines), f"Loop of {now.name}, measured and of the model."
            ),
            Panel("Difference", difference, "Measured less model over the same input."),
        ),
    )


def _tables(found: Drift) -> tuple[Table, ...]:
    rows = tuple(
        (entry.name, entry.status, str(entry.cycles), number(entry.error_percent), number(entry.inverse_percent))
        for entry in found.logs
    )
    other = other_way(Subject.of(found.model).backward)
    head = ("log", "verdict", "cycles", "error [% of range]", f"{other} [% of range]")
    changes = [
        Table(
            f"Changes: {entry.name}",
            ("part", "change", "95 % interval", "effect [% of range]", "would be seen from", "p"),
            tuple(
                (
                    f"{NAMES[c.part]}{' *' if c.drifted else ''}", with_unit(c.estimate, c.unit),
                    f"{number(c.low)} to {number(c.high)}", number(c.effect_percent, 2),
                    with_unit(c.detectable, c.unit, 2), number(c.p_value, 2),
                )
                for c in entry.changes
            ),
            "* counts as drift",
        )
        for entry in found.logs[-LOGS_SHOWN:]
        if entry.changes
    ]  # fmt: skip
    trends = tuple(
        (trend.part, with_unit(trend.slope, trend.unit), f"{number(trend.low)} to {number(trend.high)}")
        for trend in found.trends
    )
    reasons = tuple((entry.name, entry.reason) for entry in found.logs if entry.reason)
    made = (
        Table("Logs", head, rows),
        Table("Not comparable", (), reasons),
        *changes,
        Table("Trends in 100 cycles", ("part", "slope", "interval"), trends),
        Table("Settings", (), settings_rows(found.settings)),
    )
    return tuple(table for table in made if table.rows or table.title in ("Logs", "Settings"))
