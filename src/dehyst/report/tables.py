"""The tables on the page of a fit."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from dehyst.arrays import Array
from dehyst.data.recording import Recording
from dehyst.identification.fit import Fit, Score
from dehyst.identification.memory import past_in_words
from dehyst.report.parts import Table
from dehyst.report.text import bracketed, count, number, opened, plain, with_unit

# Rows of a parameter table; a model of 10 000 operators belongs in its file, not on a page.
MAXIMUM_ROWS = 400


def tables(fit: Fit) -> tuple[Table, ...]:
    """Return the tables of the page, in order."""
    return (
        _scores(fit),
        *_compared(fit),
        _certificate(fit),
        *_own(fit),
        _facts(fit),
        _settings(fit),
        *(_source(recording) for recording in fit.recordings[:20]),
        *_parameters(fit),
    )


def _scores(fit: Fit) -> Table:
    bracket = bracketed(fit.recordings[0].output_unit)
    rows = [
        _score_row("Model, fitted part", fit.train),
        _score_row("Model, held-out part", fit.test),
        _score_row("Curve, fitted part", fit.static_train),
        _score_row("Curve, held-out part", fit.static_test),
    ]
    return Table(
        "Scores",
        ("", f"RMSE{bracket}", "% of range", "NRMSE", f"largest{bracket}"),
        tuple(row for row in rows if row),
        "NRMSE is the RMSE over the standard deviation of the output: 1 is what a constant reaches. "
        "The curve is the best one without hysteresis.",
    )


def _compared(fit: Fit) -> tuple[Table, ...]:
    """The chosen model beside what it was chosen from."""
    rows = tuple(
        (
            f"{row.family}, chosen" if row.chosen else row.family, row.direction, number(row.test_percent),
            "none" if np.isnan(row.input_percent) else number(row.input_percent),
            "-" if row.tracking_percent is None else number(row.tracking_percent),
            "yes" if row.exportable else "no",
        )
        for row in fit.table
    )  # fmt: skip
    head = ("", "direction", "output, % of range", "input, % of range", "tracking, % of range", "runs on targets")
    note = (
        "RMS on the held-out part. Input: what the inverse asks for, less what was applied. Tracking: how far the "
        "output will be from what is wanted if this inverse drives the actuator. This is a prediction: the other "
        "models stand for the actuator, and a constant offset does not count."
    )
    return (Table("Compared", head, rows, note),) if rows else ()


def _score_row(name: str, score: Score | None) -> tuple[str, ...]:
    if score is None:
        return ()
    return (name, number(score.rmse), number(score.rmse_percent), number(score.nrmse), number(score.max))


def _certificate(fit: Fit) -> Table:
    c = fit.certificate
    unit, out = fit.recordings[0].input_unit, fit.recordings[0].output_unit
    gain_unit = f"{unit}/{out}" if unit and out else ""
    missing = ", ".join(number(r) for r in c.undetermined[:12]) + (", …" if len(c.undetermined) > 12 else "")
    proved = (
        ("KKT residual of the optimisation", c.kkt_residual, number(c.kkt_residual, 2)),
        ("Round trip error, of the range", c.round_trip_error, number(c.round_trip_error, 2)),
        ("Largest slope of the inverse", c.inverse_gain, with_unit(c.inverse_gain, gain_unit)),
    )
    return Table(
        "Certificate",
        (),
        (
            ("Solved by", c.route + (f", condition {number(c.condition, 2)}" if np.isfinite(c.condition) else "")),
            *((name, words) for name, value, words in proved if np.isfinite(value)),
            ("With weight", fit.size or "a curve without memory"),
            ("Thresholds the data did not determine", f"{missing} {unit}".strip() if c.undetermined else "none"),
            ("Before the log, assumed", past_in_words(c.initial_state)),
        ),
        "The residual: how exactly the optimum was reached. The round trip: how exactly the inverse undoes the model.",
    )


def _own(fit: Fit) -> tuple[Table, ...]:
    """What only this kind of model says."""
    rows = [(str(name).replace("_", " "), plain(value)) for name, value in fit.details.items()]
    rows += [("evidence", said) for said in fit.evidence_words]
    return (Table(f"What a {fit.family} model says of itself", (), tuple(rows)),) if fit.details else ()


def _facts(fit: Fit) -> Table:
    f = fit.facts
    rate = "not known"
    if f.rate_dependence_percent is not None:
        rate = f"{number(f.rate_dependence_percent)} % of range"
    return Table(
        "What the data shows by itself",
        (),
        (
            ("Direction of the loops", f.orientation),
            ("Trend", "output rises with the input" if f.trend > 0 else "output falls with the input"),
            ("Complete loops", str(f.loops)),
            ("Width of the loop at its widest", f"{number(f.width_percent, 2)} % of range"),
            ("Rate dependence", rate),
            ("Drift from the first to the last loop", f"{number(f.drift_percent)} % of range"),
        ),
    )


def _settings(fit: Fit) -> Table:
    rows = settings_rows({"family of the result": fit.family, **fit.settings})
    return Table("Settings of the identification", (), rows)


def settings_rows(settings: Mapping[str, Any]) -> tuple[tuple[str, str], ...]:
    """Return rows of a table of names and values, nested ones opened."""
    return tuple((name.replace("_", " "), plain(value)) for name, value in opened(settings, ", ").items())


def _source(recording: Recording) -> Table:
    rows = settings_rows({"samples used": len(recording), **recording.provenance})
    return Table(f"Where the data came from: {recording.name}", (), rows)


def _parameters(fit: Fit) -> tuple[Table, ...]:
    core, (kind, weights, slope), (before, after) = fit.model.play_core, fit.model.operators, fit.model.maps
    found: list[Table] = []
    if core is not None:
        r, memory = core.thresholds, np.zeros(len(core.thresholds)) if core.state is None else core.state
        head = ("threshold r", "stop weight s" if kind == "stop" else "weight w", "memory z")
        beside = "" if slope is None else f"slope k = {slope:.9g}, "
        note = f"{beside}centre c = {core.center:.9g}, offset = {core.offset:.9g}."
        if len(r) > MAXIMUM_ROWS:
            note += f" The first {MAXIMUM_ROWS} of {len(r)} operators; all are in the model file."
        found.append(_numbers(count(len(r), "operator"), head, (r, weights, memory), note))
    for table in fit.model.weight_tables:
        if table.scale.size:
            sets = len(table.weights)
            heads = (f"weight, set {k + 1}" if sets > 1 else "weight" for k in range(sets))
            label = f"{table.label}{bracketed(table.unit)}"
            what = count(table.scale.size, table.name[:-1])
            found.append(_numbers(what, (label, *heads), (table.scale, *table.weights)))
    maps = (("output map S", after), ("input map", before))
    return (*found, *(_numbers(title, ("u", "v"), (each.u, each.v)) for title, each in maps if each is not None))


def _numbers(title: str, head: tuple[str, ...], columns: tuple[Array, ...], note: str = "") -> Table:
    """Columns of numbers beside each other, numbered from 1."""
    shown = zip(*(column[:MAXIMUM_ROWS].tolist() for column in columns), strict=True)
    rows = tuple((str(i), *(f"{value:.9g}" for value in row)) for i, row in enumerate(shown, 1))
    return Table(f"Parameters: {title}", ("", *head), rows, note, folded=True)
