"""Tables of the report: rows of words, no mark-up."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from dehyst.identification.fit import Fit, Score
from dehyst.models import MonotoneMap
from dehyst.models.model import WeightTable
from dehyst.report.text import count, number, plain, with_unit

# Rows of a parameter table; a model of 10 000 operators belongs in its file, not on a page.
MAXIMUM_ROWS = 400

Rows = tuple[tuple[str, ...], ...]


@dataclass(frozen=True, slots=True)
class Table:
    """A table with a heading; the first cell of each row names it.

    Attributes
    ----------
    title
        Heading.
    head
        Column names, () for pairs of name and value.
    rows
        Cells.
    note
        Sentence below the table, or "".
    folded
        Whether it starts closed.
    """

    title: str
    head: tuple[str, ...]
    rows: Rows
    note: str = ""
    folded: bool = False


def key_figures(fit: Fit) -> tuple[tuple[str, str, str, str], ...]:
    """Return the figures of the first screen: name, value, unit, remark."""
    unit, out = fit.recordings[0].input_unit, fit.recordings[0].output_unit
    slope = f"{unit}/{out}" if unit and out else ""
    score = fit.train if fit.test is None else fit.test
    gain, trip = fit.certificate.inverse_gain, fit.certificate.round_trip_error
    static = fit.static_train if fit.static_test is None or fit.test is None else fit.static_test
    tiles = [
        ("Train RMSE", number(fit.train.rmse_percent), "%", f"{with_unit(fit.train.rmse, out)}, fitted"),
        ("Largest error", number(score.max), out, "fitted" if fit.test is None else "held out"),
        ("Without hysteresis", number(static.rmse_percent), "%", "RMSE of the best curve"),
        ("Inverse gain", number(gain), slope, "largest slope"),
        ("Round trip error", number(trip, 2), "", "of the range"),
        ("Weights", str(fit.certificate.nonzero_weights), "", fit.size or "a curve without memory"),
        ("Loop width", number(fit.facts.width_percent), "%", "of the output's range"),
    ]
    if np.isnan(gain):  # families without a bound of it: what their inverse misses
        missed, none = fit.input_error, "–"
        known = not fit.model.no_inverse
        tiles[3:5] = [
            (name, number(value) if known else none, "%" if known else "", words if known else "there is no inverse")
            for name, value, words in (
                ("Input error", missed.rms_percent, "of the input's range, rms"),
                ("Input offset", missed.bias_percent, "of the input's range, mean"),
            )
        ]
    test = ("Test RMSE", "–", "", "nothing was held out")
    if fit.test is not None:
        test = ("Test RMSE", number(fit.test.rmse_percent), "%", f"{with_unit(fit.test.rmse, out)}, held out")
    tiles.insert(0, test)
    return tuple(tiles)


def tables(fit: Fit) -> tuple[Table, ...]:
    """Return the tables of the page, in order."""
    return (
        _scores(fit),
        *_compared(fit),
        _certificate(fit),
        *_own(fit),
        _facts(fit),
        _settings(fit),
        *(source_table(recording.name, recording.provenance, len(recording)) for recording in fit.recordings[:20]),
        *_parameters(fit),
    )


def _scores(fit: Fit) -> Table:
    unit = fit.recordings[0].output_unit
    bracket = f" [{unit}]" if unit else ""
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
        "output would be off with this inverse, predicted by the other models, an offset left out."
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
            *((name, words) for name, value, words in proved if not np.isnan(value)),
            ("With weight", fit.size or "a curve without memory"),
            ("Thresholds the data did not determine", f"{missing} {unit}".strip() if c.undetermined else "none"),
            ("Memory before the first sample", c.initial_state),
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
            ("Mean width of the loop", f"{number(f.width_percent)} % of range"),
            ("Rate dependence", rate),
            ("Drift from the first to the last loop", f"{number(f.drift_percent)} % of range"),
        ),
    )


def _settings(fit: Fit) -> Table:
    return Table("Settings of the identification", (), settings_rows(fit.family, fit.settings))


def settings_rows(family: str, settings: Mapping[str, Any]) -> Rows:
    """Return rows of a table of settings, nested ones opened."""
    return (("family of the result", family), *((str(k), plain(v)) for k, v in _flat(settings)))


def source_table(name: str, provenance: Mapping[str, Any], samples: int) -> Table:
    """Return the table of where the data came from."""
    rows = [("samples used", str(samples)), *((str(k), plain(v)) for k, v in _flat(provenance))]
    return Table(f"Where the data came from: {name}", (), tuple(rows))


def _flat(mapping: Mapping[str, Any], prefix: str = "") -> list[tuple[str, Any]]:
    """Pairs of a mapping with nested mappings opened: {"a": {"b": 1}} -> ("a, b", 1)."""
    pairs: list[tuple[str, Any]] = []
    for key, value in mapping.items():
        name = f"{prefix}{key}".replace("_", " ")
        if isinstance(value, Mapping):
            pairs.extend(_flat(value, f"{name}, "))
        else:
            pairs.append((name, str(value) if isinstance(value, Path) else value))
    return pairs


def _parameters(fit: Fit) -> tuple[Table, ...]:
    core, (kind, weights, slope), (before, after) = fit.model.play_core, fit.model.operators, fit.model.maps
    found: list[Table] = []
    if core is not None:
        head = ("", "threshold r", "stop weight s" if kind == "stop" else "weight w", "memory z")
        beside = "" if slope is None else f"slope k = {slope:.9g}, "
        scalars = f"{beside}centre c = {core.center:.9g}, offset = {core.offset:.9g}"
        found.append(_operators(core.thresholds, weights, core.state, head, scalars))
    maps = (("output map S", after), ("input map", before))
    found += [_weights(each) for each in fit.model.weight_tables if each.scale.size]
    return (*found, *(_map_table(title, mapping) for title, mapping in maps if mapping is not None))


def _weights(table: WeightTable) -> Table:
    sets = table.weights.shape[0]
    heads = tuple(f"weight, set {k + 1}" if sets > 1 else "weight" for k in range(sets))
    rows = tuple(
        (str(i + 1), f"{table.scale[i]:.9g}", *(f"{value:.9g}" for value in table.weights[:, i]))
        for i in range(min(table.scale.size, MAXIMUM_ROWS))
    )
    label = f"{table.label} [{table.unit}]" if table.unit else table.label
    return Table(f"Parameters: {count(table.scale.size, table.name[:-1])}", ("", label, *heads), rows, folded=True)


def _operators(r: Any, w: Any, z: Any, head: tuple[str, ...], scalars: str) -> Table:
    rows = tuple(
        (str(i + 1), f"{r[i]:.9g}", f"{w[i]:.9g}", "0" if z is None else f"{z[i]:.9g}")
        for i in range(min(len(r), MAXIMUM_ROWS))
    )
    more = (
        f" The first {MAXIMUM_ROWS} of {len(r)} operators; all are in the model file." if len(r) > MAXIMUM_ROWS else ""
    )
    return Table(f"Parameters: {count(len(r), 'operator')}", head, rows, f"{scalars}.{more}", folded=True)


def _map_table(title: str, mapping: MonotoneMap) -> Table:
    rows = tuple(
        (str(i + 1), f"{u:.9g}", f"{v:.9g}") for i, (u, v) in enumerate(zip(mapping.u, mapping.v, strict=True))
    )
    return Table(f"Parameters: {title}", ("", "u", "v"), rows[:MAXIMUM_ROWS], folded=True)
