"""Figures of choices: the candidates that were compared, and what other settings would have given."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from dehyst.arrays import Array, rank
from dehyst.data import range_over
from dehyst.identification import ComparedSetting, Fit, Refit
from dehyst.report._drawing import Bar, PanelLine, bars, chart
from dehyst.report._parts import Axes, Draw, PageFigure, PageTable, Panel
from dehyst.report._text import number, short
from dehyst.report._theme import OTHER, STATIC, TRAIN, ThemeColour

MAXIMUM_BARS = 7
# Bars longer than this many times the error of the chosen one are cut.
CUT = 3.0

_STARTS = {"zero": "at zero", "rest": "at rest"}

# Grids that are parts of the finest one, so that one pass over the data is enough for all of them.
OPERATORS = (5, 10, 20, 40, 80, 160)
# Relative to output range over input range, whatever the family.
EPS = (0.001, 0.01, 0.03, 0.1, 0.2, 0.4)
_BESIDE = {
    "pi": "modified-pi",
    "modified-pi": "pi",
    "stop": "pi-cumulative",
    "pi-cumulative": "stop",
}


def candidates_figure(fit: Fit) -> PageFigure | None:
    """Return what was compared; None if a family was named and nothing compared."""
    if not fit.candidates:
        return None
    drawn = drawn_candidates(fit)
    edge = reach(drawn)
    range_of = "input" if fit.model.judged_backward else "output"
    caption = (
        f"RMSE on loops held out inside the fitted part, in percent of the {range_of}'s range, with its standard "
        "error. A simpler family is preferred to one that is hardly better. The curve without hysteresis is shown with "
        "its error on the fitted part."
    )
    compared = [candidate for candidate in drawn if candidate in fit.candidates]
    if len(fit.candidates) > len(compared):
        caption += f" Of {len(fit.candidates)} variants, the best of each family and the best of the rest are drawn."
    if any(candidate.error_percent > edge for candidate in drawn):
        caption += " Bars with an arrow are cut; their numbers are right."
    best = ", ".join(f"{_name(c)} {c.error_percent:.3g} %" for c in drawn[:4])
    draw = bars(list(map(_bar, drawn)), "RMSE on held-out loops [% of range]", edge=edge)
    return PageFigure(
        "candidates",
        "Models that were compared",
        caption,
        (Panel("Error on held-out loops", draw, f"Bars: {best}."),),
    )


def _bar(candidate: ComparedSetting) -> Bar:
    """Bar of a candidate; the one that was taken stands out."""
    name = short(_name(candidate), 52)
    colour = OTHER
    if candidate.chosen:
        name, colour = f"{name}, taken", TRAIN
    elif _is_static(candidate):
        colour = STATIC
    return Bar(
        name,
        candidate.error_percent,
        colour,
        f"{number(candidate.error_percent)} %",
        spread=_spread(candidate),
        bold=candidate.chosen,
    )


def drawn_candidates(fit: Fit) -> list[ComparedSetting]:
    """Return the chosen one, the best of each family, the curve without hysteresis, then the best of the rest."""
    finite = [candidate for candidate in fit.candidates if np.isfinite(candidate.error_percent)]
    ranked = sorted(finite, key=_rank)
    must, leaders = [], []
    families = set()
    for candidate in ranked:
        if candidate.chosen:
            must.append(candidate)
        elif candidate.family not in families:
            leaders.append(candidate)
        families.add(candidate.family)
    must += leaders[: MAXIMUM_BARS - 2]
    # Of the rest as many as there is room for: of variants with the same name, the best.
    best_named = {_name(candidate): candidate for candidate in reversed(ranked)}
    for candidate in must:
        best_named.pop(_name(candidate), None)
    room = max(0, MAXIMUM_BARS - 1 - len(must))
    more = sorted(best_named.values(), key=_rank)[:room]
    if not any(map(_is_static, must)):
        more.append(ComparedSetting("static", "", None, fit.static_train.rmse_percent, math.nan))
    return sorted(must + more, key=_rank)


def _rank(candidate: ComparedSetting) -> float:
    return rank(candidate.error_percent)


def _is_static(candidate: ComparedSetting) -> bool:
    return candidate.family.startswith("static")


def _name(candidate: ComparedSetting) -> str:
    """Name of a candidate, with the settings by which it differs from others of its family."""
    if _is_static(candidate):
        return "curve without hysteresis"
    extra = []
    start = candidate.initial_state
    if start:
        extra.append(f"starts {_STARTS.get(start, start)}")
    if candidate.smoothing is not None:
        extra.append(f"smoothing {candidate.smoothing:g}")
    if not extra:
        return candidate.family
    return f"{candidate.family}: {', '.join(extra)}"


def reach(candidates: Sequence[ComparedSetting]) -> float:
    """Return where the axis ends: one candidate with a very large error must not make the others unreadable."""
    largest, least, chosen = 0.0, math.inf, math.inf
    for candidate in candidates:
        error = candidate.error_percent
        largest = max(largest, error + _spread(candidate))
        least = min(least, error)
        if candidate.chosen:
            chosen = min(chosen, error)
    if chosen == math.inf:
        chosen = least
    largest = largest or 1.0
    if chosen > 0.0:
        return min(largest, CUT * chosen)
    return largest


def _spread(candidate: ComparedSetting) -> float:
    return candidate.uncertainty_percent if np.isfinite(candidate.uncertainty_percent) else 0.0


@dataclass(frozen=True, slots=True)
class _Family:
    """Refits of one family: with other numbers of operators, and with other eps."""

    name: str
    token: ThemeColour
    by_n: tuple[Refit, ...]
    by_eps: tuple[Refit, ...]


def settings_figure(fit: Fit) -> PageFigure | None:
    """Return what other settings would do, by refits of the same data; None for a fit that cannot be repeated."""
    if fit.refitter is None:
        return None
    unit = "held out" if fit.test is not None else "fitted"
    families = [_family(fit, fit.family, TRAIN), _family(fit, _beside(fit), OTHER)]
    caption = (
        f"RMSE on the {unit} samples if the same data were fitted with another number of operators or another eps, in "
        "percent of the output's range; the start state stays. Where the curve is flat, fewer operators or a firmer "
        "eps cost nothing: a smaller model, or an inverse that amplifies less. eps is relative to output range over "
        "input range here. The table holds this model's family; gain is the largest slope of the inverse."
    )
    by_n, by_eps = [], []
    for f in families:
        by_n.append(f"{f.name}: {_error(f.by_n[0])} % with 5, {_error(f.by_n[-1])} % with 160.")
        by_eps.append(
            f"{f.name}: {_error(f.by_eps[0])} % at 0.001, {_error(f.by_eps[-1])} % at 0.4."
        )
    panels = (
        Panel(
            "Error over the number of operators",
            _curves("operators n", OPERATORS, families, "by_n"),
            " ".join(by_n),
        ),
        Panel(
            "Error over eps", _curves("eps, relative", EPS, families, "by_eps"), " ".join(by_eps)
        ),
    )
    return PageFigure(
        "settings",
        "Other numbers of operators, other eps",
        caption,
        panels,
        table=_table(families[0], unit),
    )


def _beside(fit: Fit) -> str:
    """Family to compare with; a sheared loop is refitted with sums of plays only."""
    if fit.model.shear is not None:
        return "pi" if fit.family == "pi-cumulative" else "pi-cumulative"
    return _BESIDE.get(fit.family, "pi")


def _family(fit: Fit, name: str, token: ThemeColour) -> _Family:
    # The finest grid first: the others are sums of its cells.
    by_n = [fit.refit(family=name, n=n) for n in reversed(OPERATORS)]
    slope = _mean_slope(fit) if name == "pi" else 1.0
    by_eps = [fit.refit(family=name, eps=eps * slope) for eps in EPS]
    return _Family(name, token, tuple(reversed(by_n)), tuple(by_eps))


def _mean_slope(fit: Fit) -> float:
    """Output range over input range of the fitted samples. [output/input]"""
    inputs, outputs = [], []
    for rec, mask in zip(fit.recordings, fit.train_masks, strict=True):
        inputs.append(rec.input[mask])
        outputs.append(rec.output[mask])
    return _span(outputs) / _span(inputs)


def _span(parts: Sequence[Array]) -> float:
    low, high = range_over(parts)
    return high - low


def _percent(refit: Refit) -> float:
    return (refit.test or refit.train).rmse_percent


def _error(refit: Refit) -> str:
    return number(_percent(refit))


def _curves(across: str, values: Sequence[float], families: Sequence[_Family], which: str) -> Draw:
    """Draw the errors of the families over a setting, on a logarithmic axis."""
    places = np.log10(np.array(values, dtype=np.float64))
    lines = []
    for family in families:
        errors = np.array(list(map(_percent, getattr(family, which))))
        lines.append(PanelLine(places, errors, family.token, family.name, 1.6, marker="o"))

    def ticks(axes: Axes) -> None:
        axes.set_xticks(places, [f"{value:g}" for value in values])

    return chart(across, "RMSE [% of range]", lines, zero=True, also=ticks)


def _table(family: _Family, unit: str) -> PageTable:
    """Errors, weights and gains of one family with other settings."""
    rows = [_refit_row(f"n = {refit.n}", refit) for refit in family.by_n]
    for eps, refit in zip(EPS, family.by_eps, strict=True):
        rows.append(_refit_row(f"eps = {eps:g}", refit))
    head = ("", f"{unit} [% of range]", "weights", "gain of the inverse")
    return PageTable(f"{family.name} with other settings", head, tuple(rows), folded=True)


def _refit_row(name: str, refit: Refit) -> tuple[str, ...]:
    return name, _error(refit), str(refit.nonzero_weights), number(refit.inverse_gain)
