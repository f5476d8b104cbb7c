"""The tables on the page of a fit."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from dehyst.arrays import Array
from dehyst.data import Recording
from dehyst.identification import Fit, Score, past_in_words
from dehyst.report._parts import PageTable
from dehyst.report._text import YES_NO, bracketed, count, flattened, number, plain, with_unit

# Rows of a parameter table; a model of 10 000 operators belongs in its file, not on a page.
MAXIMUM_ROWS = 400


def tables(fit: Fit) -> tuple[PageTable, ...]:
    """Return the tables of the page, in order."""
    return (
        _scores(fit),
        *_compared(fit),
        _certificate(fit),
        *_own(fit),
        _facts(fit),
        _settings(fit),
        *map(_source, fit.recordings[:20]),
        *_parameters(fit),
    )


def _scores(fit: Fit) -> PageTable:
    """Errors of the model and of the best curve."""
    bracket = bracketed(fit.recordings[0].output_unit)
    rows = [
        _score_row("Model, fitted part", fit.train),
        _score_row("Model, held-out part", fit.test),
        _score_row("Curve, fitted part", fit.static_train),
        _score_row("Curve, held-out part", fit.static_test),
    ]
    return PageTable(
        "Scores",
        ("", f"RMSE{bracket}", "% of range", "NRMSE", f"largest{bracket}"),
        tuple(filter(None, rows)),
        "NRMSE is the RMSE over the standard deviation of the output: 1 is what a constant reaches. "
        "The curve is the best one without hysteresis.",
    )


def _compared(fit: Fit) -> tuple[PageTable, ...]:
    """The chosen model beside what it was chosen from."""
    rows = []
    for row in fit.table:
        name = row.family
        if row.chosen:
            name += ", chosen"
        input_error, tracking = "none", "-"
        if not np.isnan(row.input_percent):
            input_error = number(row.input_percent)
        if row.tracking_percent is not None:
            tracking = number(row.tracking_percent)
        output_error = number(row.test_percent)
        errors = (output_error, input_error, tracking)
        rows.append((name, row.direction, *errors, YES_NO[row.exportable]))
    if not rows:
        return ()
    head = (
        "",
        "direction",
        "output, % of range",
        "input, % of range",
        "tracking, % of range",
        "runs on targets",
    )
    note = (
        "RMS on the held-out part. Input: what the inverse asks for, less what was applied. Tracking: how far the "
        "output will be from what is wanted if this inverse drives the actuator. This is a prediction: the other "
        "models stand for the actuator, and a constant offset does not count."
    )
    if fit.passed_over:
        note = f"{note} {fit.passed_over}"
    return (PageTable("Compared", head, tuple(rows), note),)


def _score_row(name: str, score: Score | None) -> tuple[str, ...]:
    if score is None:
        return ()
    return (
        name,
        number(score.rmse),
        number(score.rmse_percent),
        number(score.nrmse),
        number(score.max),
    )


def _certificate(fit: Fit) -> PageTable:
    """What was proved of the fit and of its inverse."""
    c = fit.certificate
    unit, out = fit.recordings[0].input_unit, fit.recordings[0].output_unit
    # A slope with half a unit would be misread.
    gain_unit = ""
    if unit and out:
        gain_unit = f"{unit}/{out}"
    route = c.route
    if np.isfinite(c.condition):
        route += f", condition {number(c.condition, 2)}"
    rows = [("Solved by", route)]
    proved = (
        ("KKT residual of the optimisation", c.kkt_residual, number(c.kkt_residual, 2)),
        ("Round trip error, of the range", c.round_trip_error, number(c.round_trip_error, 2)),
        ("Largest slope of the inverse", c.inverse_gain, with_unit(c.inverse_gain, gain_unit)),
    )
    # Not every family has each of these numbers: NaN stands for what was not proved.
    for name, value, words in proved:
        if np.isfinite(value):
            rows.append((name, words))
    undetermined = "none"
    if c.undetermined:
        # A fit of a hundred operators may leave dozens open; the file of the model names all of them.
        undetermined = ", ".join(map(number, c.undetermined[:12]))
        if len(c.undetermined) > 12:
            undetermined += ", …"
        undetermined = f"{undetermined} {unit}".strip()
    rows += [
        ("With weight", fit.size or "a curve without memory"),
        *_certain(fit),
        ("Thresholds the data did not determine", undetermined),
        ("Before the log, assumed", past_in_words(c.initial_state)),
    ]
    return PageTable(
        "Certificate",
        (),
        tuple(rows),
        "The residual: how exactly the optimum was reached. The round trip: how exactly the inverse undoes the model.",
    )


def _certain(fit: Fit) -> list[tuple[str, str]]:
    """How well the log determines the output of the model."""
    if fit.output_certain is None or fit.draws is None:
        return []
    width = with_unit(fit.output_certain, fit.recordings[0].output_unit)
    words = f"± {width}, rms along the fitted part, from the scatter of {fit.draws.blocks} blocks of errors"
    return [("Output of the model is certain to (95 %)", words)]


def _own(fit: Fit) -> tuple[PageTable, ...]:
    """What only this kind of model says."""
    if not fit.details:
        return ()
    rows = []
    for name, value in fit.details.items():
        rows.append((str(name).replace("_", " "), plain(value)))
    for words in fit.evidence_words:
        rows.append(("evidence", words))
    return (PageTable(f"What a {fit.family} model says of itself", (), tuple(rows)),)


def _facts(fit: Fit) -> PageTable:
    """What the log shows without any model."""
    f = fit.facts
    rate = "not known"
    if f.rate_dependence_percent is not None:
        rate = f"{number(f.rate_dependence_percent)} % of range"
    trend = "output falls with the input"
    if f.trend > 0:
        trend = "output rises with the input"
    return PageTable(
        "What the data shows by itself",
        (),
        (
            ("Direction of the loops", f.orientation),
            ("Trend", trend),
            ("Complete loops", str(f.loops)),
            ("Opening of the loop at its widest", f"{number(f.width_percent, 2)} % of range"),
            *_numbers_of(fit),
            ("Rate dependence", rate),
            ("Drift from the first to the last loop", f"{number(f.drift_percent)} % of range"),
        ),
    )


def _numbers_of(fit: Fit) -> list[tuple[str, str]]:
    """Width, loss, coercivity and others of the largest loops, and the dead band of the model."""
    rows = []
    measured = fit.facts.numbers
    if measured is not None:
        for label, number_words, where in measured.rows:
            if label != "opening":
                rows.append((f"{label.capitalize()}: {where}", number_words.replace("+-", "±")))
        rows.append(("Intervals of these numbers (95 %)", measured.basis))
    if fit.dead_band is not None:
        unit = fit.recordings[0].input_unit
        width = with_unit(fit.dead_band.width, unit)
        if fit.dead_band_interval is not None:
            low, high = (
                number(fit.dead_band_interval.low),
                with_unit(fit.dead_band_interval.high, unit),
            )
            width += f" (95 %: {low} to {high})"
        share = f"{number(fit.dead_band.percent, 2)} % of the input's range"
        rows.append(("Dead band of the model behind a turn", f"{width}, {share}"))
    return rows


def _settings(fit: Fit) -> PageTable:
    rows = settings_rows({"family of the result": fit.family, **fit.settings})
    return PageTable("Settings of the identification", (), rows)


def settings_rows(settings: Mapping[str, Any]) -> tuple[tuple[str, str], ...]:
    """Return rows of a table of names and values, nested ones opened."""
    rows = []
    for name, value in flattened(settings, ", ").items():
        rows.append((name.replace("_", " "), plain(value)))
    return tuple(rows)


def _source(recording: Recording) -> PageTable:
    rows = settings_rows({"samples used": len(recording), **recording.provenance})
    return PageTable(f"Where the data came from: {recording.name}", (), rows)


def _parameters(fit: Fit) -> tuple[PageTable, ...]:
    """Tables of all numbers of the model."""
    core, (kind, weights, slope) = fit.model.play_core, fit.model.operators
    tables: list[PageTable] = []
    if core is not None:
        r = core.thresholds
        memory = core.state
        if memory is None:
            memory = np.zeros(len(r))
        weight = "weight w"
        if kind == "stop":
            weight = "stop weight s"
        note = f"centre c = {core.center:.9g}, offset = {core.offset:.9g}."
        if slope is not None:
            note = f"slope k = {slope:.9g}, {note}"
        if len(r) > MAXIMUM_ROWS:
            note += f" The first {MAXIMUM_ROWS} of {len(r)} operators; all are in the model file."
        head = ("threshold r", weight, "memory z")
        tables.append(_numbers(count(len(r), "operator"), head, (r, weights, memory), note))
    for table in fit.model.weight_tables:
        # A family may have terms that this model was identified without.
        if not table.scale.size:
            continue
        heads = ["weight"]
        if len(table.weights) > 1:
            heads = [f"weight, set {k}" for k in range(1, len(table.weights) + 1)]
        label = f"{table.label}{bracketed(table.unit)}"
        title = count(table.scale.size, table.name[:-1])
        tables.append(_numbers(title, (label, *heads), (table.scale, *table.weights)))
    before, after = fit.model.maps
    for title, entry in (("output map S", after), ("input map", before)):
        if entry is not None:
            tables.append(_numbers(title, ("u", "v"), (entry.u, entry.v)))
    return tuple(tables)


def _numbers(
    title: str, head: tuple[str, ...], columns: tuple[Array, ...], note: str = ""
) -> PageTable:
    """Columns of numbers beside each other, numbered from 1."""
    # Thousands of rows would make the page slow; the model file holds all of them.
    shown = [column[:MAXIMUM_ROWS].tolist() for column in columns]
    rows = []
    for i, values in enumerate(zip(*shown, strict=True), 1):
        rows.append((str(i), *map("{:.9g}".format, values)))
    return PageTable(f"Parameters: {title}", ("", *head), tuple(rows), note, folded=True)
