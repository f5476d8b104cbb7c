"""A watch for drift -> one self-contained HTML page."""

from __future__ import annotations

import os
from collections.abc import Sequence
from functools import partial
from pathlib import Path

import numpy as np

from dehyst.arrays import Array
from dehyst.files import write_atomically
from dehyst.findings import Grade
from dehyst.monitoring import Drift, LogDrift
from dehyst.monitoring.parts import NAMES, Subject
from dehyst.monitoring.result import other_way
from dehyst.report.figures.panel import Axes, Figure, Panel, add_legend, draw_path, label_axes, says
from dehyst.report.rendering import Sheet, sheet_page
from dehyst.report.tables import Table
from dehyst.report.text import number, plain, short, with_unit
from dehyst.report.theme import DATA, FIFTH, MODEL, MUTED, SIXTH, STATIC, TEST, TRAIN, Token
from dehyst.report.thin import Window

GRADES = {"unchanged": Grade.GOOD, "drifted": Grade.BAD, "not comparable": Grade.CARE, "cannot tell": Grade.CARE}
# Parts drawn over the cycles, by their unit.
PERCENT_PARTS: tuple[tuple[str, Token], ...] = (
    ("hysteresis", TEST),
    ("gain", TRAIN),
    ("creep", SIXTH),
    ("own-creep", SIXTH),
    ("viscous", MUTED),
    ("bend", FIFTH),
    ("s-bend", STATIC),
)

TELLING = 100.0  # percent: a part that only a larger change would show is noise, not a line
ERRORS = (("error", "model", TRAIN),)
INVERSE = (("inverse", "inverse", FIFTH),)
SHIFT = (("offset", "offset", MODEL),)


def write_drift_report(found: Drift, path: str | os.PathLike[str], model_name: str = "the model") -> Path:
    """Write the page of a watch for drift: one HTML file that needs nothing else and runs nothing.

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
    return write_atomically(path, drift_page(found, model_name))


def drift_page(found: Drift, model_name: str = "the model") -> str:
    """Return the text of the page."""
    card = found.model.card
    return sheet_page(
        Sheet(
            kind="Has the actuator changed?",
            title=short(model_name, 80),
            relation=f"{short(card.input.name, 60)} → {short(card.output.name, 60)}",
            subject="drift",
            badge=found.status,
            grade=GRADES[found.status],
            lead=found.verdict,
            more=() if found.acceptance is None else (found.acceptance.reason,),
            figures=drift_figures(found),
            warnings=[*(f for entry in found.logs for f in entry.findings), *found.findings],
            tables=_tables(found),
        )
    )


def drift_figures(found: Drift) -> tuple[Figure, ...]:
    """Return the figures of the page: error over the cycles, parts over the cycles, loop then and now."""
    scored = [entry for entry in found.logs if entry.blocks is not None]
    if not scored:
        return ()
    drawn = [_error_figure(found, scored), _parts_figure(scored)]
    loop = _loop_figure(scored, Subject.of(found.model))
    return tuple(figure for figure in (*drawn, loop) if figure is not None)


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
    drawn = partial(_draw_over_cycles, scored, INVERSE, None, "rms error [% of range]")
    words = says("RMS error of the model read the other way, over the number of the cycle.")
    inverse = (Panel(f"Read {way}", drawn, words),) if _series(scored, "inverse") else ()
    return Figure(
        "error",
        "Error over the cycles",
        "How far the model as identified is from the logs, a dot for each cycle or block of cycles, log after log; "
        f"vertical lines part the logs.{line} On the right the model is read the other way.",
        (
            Panel(
                "Error of the model",
                partial(_draw_over_cycles, scored, ERRORS, known, "rms error [% of range]"),
                says("RMS error over the number of the cycle.", line),
            ),
            *inverse,
        ),
    )


def _parts_figure(scored: Sequence[LogDrift]) -> Figure:
    seen = {c.part for entry in scored for c in entry.changes if c.detectable <= TELLING or c.drifted}
    told = [(part, NAMES[part], token) for part, token in PERCENT_PARTS if part in seen and _series(scored, part)]
    untold = ", ".join(NAMES[part] for part, _ in PERCENT_PARTS if part not in seen and _series(scored, part))
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
                partial(_draw_over_cycles, scored, told, 0.0, "change [%]"),
                says("Changes in percent over the number of the cycle."),
            ),
            Panel(
                "Offset",
                partial(_draw_over_cycles, scored, SHIFT, 0.0, f"offset [{unit}]" if unit else "offset"),
                says("Offset over the number of the cycle."),
            ),
        ),
    )


def _draw_over_cycles(
    scored: Sequence[LogDrift], parts: Sequence[tuple[str, str, Token]], level: float | None, up: str, axes: Axes
) -> None:
    drawn = [(name, token, _series(scored, part)) for part, name, token in parts]
    pairs = [pair for _, _, series in drawn for pair in series]
    if level is not None and pairs:
        pairs.append((pairs[0][0][:1], np.array([level])))
    label_axes(axes, Window.around(*pairs), "cycle", up)
    for name, token, series in drawn:
        for k, (cycle, values) in enumerate(series):
            label = "_nolegend_" if k else name
            axes.plot(cycle, values, "o-", color=token.light, ms=2.6, mew=0.0, lw=0.7, label=label)
    if level is not None:
        axes.axhline(level, color=MUTED.light, lw=0.9, ls=(0, (5, 3)), zorder=1)
    ends = [float(entry.blocks.cycle[-1]) + 0.5 for entry in scored[:-1] if entry.blocks is not None]
    for end in ends:
        axes.axvline(end, color=MUTED.light, lw=0.7, zorder=1)
    if len(drawn) > 1:
        add_legend(axes)


def _loop_figure(scored: Sequence[LogDrift], subject: Subject) -> Figure | None:
    now = next((entry for entry in reversed(scored) if entry.tested), scored[-1])
    if now.recording is None or now.response is None or now.shown[1] <= now.shown[0]:
        return None
    return Figure(
        "loop",
        "The loop then and now",
        f"The last cycles of {short(now.name, 60)}: measured, and as the model that was identified says they would "
        "have been.",
        (
            Panel(
                "Loop",
                partial(_draw_loop, now, subject),
                says(f"Measured loop of {now.name} and that of the model."),
            ),
            Panel(
                "Difference",
                partial(_draw_difference, now, subject),
                says("Measured less model over the same input."),
            ),
        ),
    )


def _draw_loop(now: LogDrift, subject: Subject, axes: Axes) -> None:
    record = now.recording
    assert record is not None and now.response is not None
    span = slice(*now.shown)
    drive, measured = subject.signals(record)
    x, y, model = drive[span], measured[span], now.response[span]
    window = Window.around((x, y), (x, model))
    label_axes(axes, window, subject.drive.label, subject.response.label)
    draw_path(axes, x, y, window, DATA, label="now", width=2.2)
    draw_path(axes, x, model, window, MODEL, label="then (model)", width=1.0, outline=True)
    add_legend(axes)


def _draw_difference(now: LogDrift, subject: Subject, axes: Axes) -> None:
    record = now.recording
    assert record is not None and now.response is not None
    span = slice(*now.shown)
    drive, measured = subject.signals(record)
    x, missed = drive[span], measured[span] - now.response[span]
    window = Window.around((x, missed), (x[:1], np.zeros(1)))
    unit = f" [{subject.response.unit}]" if subject.response.unit else ""
    label_axes(axes, window, subject.drive.label, f"now less then{unit}")
    axes.axhline(0.0, color=MUTED.light, lw=0.8, zorder=1)
    draw_path(axes, x, missed, window, TEST, label="difference", width=0.9)


def _tables(found: Drift) -> tuple[Table, ...]:
    rows = tuple(
        (entry.name, entry.status, str(entry.cycles), number(entry.error_percent), number(entry.inverse_percent))
        for entry in found.logs
    )
    head = (
        "log",
        "verdict",
        "cycles",
        "error [% of range]",
        f"{other_way(Subject.of(found.model).backward)} [% of range]",
    )
    logs = Table("Logs", head, rows)
    changes = tuple(
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
        for entry in found.logs[-6:]
        if entry.changes
    )  # fmt: skip
    trends = tuple(
        (trend.part, with_unit(trend.slope, trend.unit), f"{number(trend.low)} to {number(trend.high)}")
        for trend in found.trends
    )
    drawn = (Table("Trends in 100 cycles", ("part", "slope", "interval"), trends),) if trends else ()
    settings = Table("Settings", (), tuple((name, plain(value)) for name, value in found.settings.items()))
    reasons = tuple((entry.name, entry.reason) for entry in found.logs if entry.reason)
    why = (Table("Not comparable", (), reasons),) if reasons else ()
    return (logs, *why, *changes, *drawn, settings)
