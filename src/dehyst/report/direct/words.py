"""Lights, sentences, tiles, tables and next lines of a direct inverse."""

from __future__ import annotations

from dehyst.grades import Grade
from dehyst.identification.cautions import POOR_PERCENT
from dehyst.identification.direct import DirectFit
from dehyst.identification.fit import Score
from dehyst.identification.judge import GOOD_PERCENT
from dehyst.identification.selection import STATIC_AS_GOOD
from dehyst.report.judgement import KKT, Light, overall
from dehyst.report.tables import Table, settings_rows, source_table
from dehyst.report.text import count, number, with_unit

MAXIMUM_ROWS = 400


def direct_lights(fit: DirectFit) -> tuple[Light, ...]:
    """Return the judgement, one light for each aspect."""
    judged, static = fit.judged, fit.static_test or fit.static_train
    where = "samples held out" if fit.test is not None else "fitted samples"
    grade = Grade.GOOD if judged.rmse_percent <= GOOD_PERCENT else Grade.CARE
    grade = Grade.BAD if judged.rmse_percent > POOR_PERCENT else grade
    found = [Light("Accuracy", grade, f"input within {number(judged.rmse_percent)} % of its range (RMSE) on {where}")]
    times = static.rmse / judged.rmse if judged.rmse > 0.0 else float("inf")
    curve = Grade.GOOD if times >= 1.5 else Grade.CARE if times > 1.0 / STATIC_AS_GOOD else Grade.BAD
    found.append(Light("Against a curve", curve, f"error {number(times, 2)} times smaller than that of the best curve"))
    if fit.rivals:
        best = fit.rivals[0]
        ahead = best.inverse_percent / judged.rmse_percent if judged.rmse_percent > 0.0 else float("inf")
        light = Grade.GOOD if ahead >= 1.0 else Grade.CARE
        reason = f"error of the input {number(ahead, 2)} times smaller than that of the inverse of {best.family}"
        found.append(Light("Against forward families", light, reason))
    rises = fit.certificate.rises
    reason = "the input rises with the output, whatever the past" if rises else "the input may fall after some past"
    found.append(Light("Slope", Grade.GOOD if rises else Grade.CARE, reason))
    codes = sorted({finding.code for finding in fit.warnings})
    missing = fit.lacking
    reason = "; ".join(part for part in (", ".join(codes) or "no warnings", missing) if part)
    found.append(Light("The data", Grade.CARE if codes else Grade.GOOD, reason))
    if not fit.certificate.kkt_residual <= KKT:
        found.append(Light("Optimality", Grade.CARE, f"KKT residual {number(fit.certificate.kkt_residual)}"))
    return tuple(found)


def direct_words(fit: DirectFit) -> tuple[str, ...]:
    """Return the plain-language reading of the fit."""
    first, judged = fit.recordings[0], fit.judged
    where = "held out" if fit.test is not None else "fitted"
    says = [
        f"From {sum(len(rec) for rec in fit.recordings)} samples dehyst identified the compensator itself: the input "
        f"that an output needs. On samples {where} it is typically {with_unit(judged.rmse, first.input_unit)} off, "
        f"{with_unit(judged.max, first.input_unit)} at worst."
    ]
    says += [f"{said[0].upper()}{said[1:]}." for said in fit.evidence_words]
    if overall(fit) is Grade.BAD:
        says.append("It should not drive a machine as it is; the warnings say why.")
    return tuple(says)


def direct_tiles(fit: DirectFit) -> tuple[tuple[str, str, str, str], ...]:
    """Return the figures of the first screen: name, value, unit, remark."""
    first, judged, forward = fit.recordings[0], fit.judged, fit.judged_forward
    part = "fitted" if fit.test is None else "held out"
    static = fit.static_test or fit.static_train
    tiles = [
        ("Input RMSE", number(judged.rmse_percent), "%", f"{with_unit(judged.rmse, first.input_unit)}, {part}"),
        ("Largest error", number(judged.max), first.input_unit, part),
        ("Without memory", number(static.rmse_percent), "%", "input RMSE of the best curve"),
        ("Read forward", number(forward.rmse_percent), "%", f"{with_unit(forward.rmse, first.output_unit)}, {part}"),
        ("Terms", str(fit.certificate.nonzero_weights), "", f"of {fit.certificate.terms}"),
        ("Train RMSE", number(fit.train.rmse_percent), "%", f"{with_unit(fit.train.rmse, first.input_unit)}, fitted"),
        ("Loop width", number(fit.facts.width_percent), "%", "of the output's range"),
    ]
    if fit.rivals:
        tiles.insert(1, ("Best forward family", number(fit.rivals[0].inverse_percent), "%", fit.rivals[0].family))
    return tuple(tiles)


def direct_tables(fit: DirectFit) -> tuple[Table, ...]:
    """Return the tables of the page, in order."""
    return (
        _scores(fit),
        _against(fit),
        _certificate(fit),
        Table("Settings of the identification", (), settings_rows(fit.family, fit.settings)),
        *(source_table(rec.name, rec.provenance, len(rec)) for rec in fit.recordings[:20]),
        *_parameters(fit),
    )


def _scores(fit: DirectFit) -> Table:
    rows: list[tuple[str, Score | None]] = [
        ("Input, fitted part", fit.train),
        ("Input, held-out part", fit.test),
        ("Curve without memory, fitted part", fit.static_train),
        ("Curve without memory, held-out part", fit.static_test),
        ("Read forward: output, fitted part", fit.forward_train),
        ("Read forward: output, held-out part", fit.forward_test),
    ]
    shown = tuple(
        (name, number(s.rmse), number(s.rmse_percent), number(s.nrmse), number(s.max))
        for name, s in rows
        if s is not None
    )
    return Table(
        "Scores", ("", "RMSE", "% of range", "NRMSE", "largest"), shown,
        "Input in its unit and percent of its range, output in its own.",
    )  # fmt: skip


def _against(fit: DirectFit) -> Table:
    own = ("direct-inverse", number(fit.judged.rmse_percent), number(fit.judged_forward.rmse_percent))
    rows = (own, *((r.family, number(r.inverse_percent), number(r.forward_percent)) for r in fit.rivals))
    return Table("Against forward families", ("", "input, % of range", "output, % of range"), rows)


def _certificate(fit: DirectFit) -> Table:
    c = fit.certificate
    rows = [
        ("KKT residual of the optimisation", number(c.kkt_residual, 2)),
        ("Terms with weight", f"{c.nonzero_weights} of {c.terms}"),
        ("Past before the first sample", c.initial_state),
        ("Input rises with the output whatever the past", "guaranteed" if c.rises else "not guaranteed"),
        ("Samples whose input no output near the range needs", str(c.missed)),
        *(("Evidence", said) for said in fit.evidence_words),
    ]
    return Table("Certificate and evidence", (), tuple(rows))


def _parameters(fit: DirectFit) -> tuple[Table, ...]:
    model = fit.model
    listed = (
        ("stops", "radius r", model.radii, model.stop_weights),
        ("path lags", "length x", model.path_lengths, model.path_weights),
        ("creep lags", "time constant τ [s]", model.time_constants, model.creep_weights),
    )
    heads = tuple(f"weight, set {k + 1}" if model.sets > 1 else "weight" for k in range(model.sets))
    tables = [
        Table(
            f"Parameters: {count(scale.size, name[:-1])}",
            ("", label, *heads),
            tuple(
                (str(i + 1), f"{scale[i]:.9g}", *(f"{value:.9g}" for value in weights[:, i]))
                for i in range(min(scale.size, MAXIMUM_ROWS))
            ),
            folded=True,
        )
        for name, label, scale, weights in listed
        if scale.size
    ]
    curve = tuple((f"power {j}", *(f"{value:.9g}" for value in column)) for j, column in enumerate(model.polynomial.T))
    viscous = ("viscous", *(f"{value:.9g}" for value in model.viscous))
    note = f"Powers of y - {model.center:.9g}."
    return (*tables, Table("Parameters: curve and viscous", ("", *heads), (*curve, viscous), note, folded=True))
