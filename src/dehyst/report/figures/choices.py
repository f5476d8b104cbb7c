"""Figures of choices: the candidates that were compared, and what other settings would have given."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from dehyst.arrays import rank
from dehyst.identification.fit import Candidate, Fit, Refit
from dehyst.report.drawing import Bar, Line, bars, chart
from dehyst.report.parts import Axes, Draw, Figure, Panel, Table
from dehyst.report.text import number, short
from dehyst.report.theme import OTHER, STATIC, TRAIN, Token

MAXIMUM_BARS = 7
# Bars longer than this many times the error of the chosen one are cut.
CUT = 3.0

_STARTS = {"zero": "at zero", "rest": "at rest"}

# Grids that are parts of the finest one, so that one pass over the data is enough for all of them.
OPERATORS = (5, 10, 20, 40, 80, 160)
# Relative to output range over input range, whatever the family.
EPS = (0.001, 0.01, 0.03, 0.1, 0.2, 0.4)
_BESIDE = {"pi": "modified-pi", "modified-pi": "pi", "stop": "pi-cumulative", "pi-cumulative": "stop"}


def candidates_figure(fit: Fit) -> Figure | None:
    """Return what was compared; None if a family was named and nothing compared."""
    if not fit.candidates:
        return None
    drawn = shown(fit)
    edge = reach(drawn)
    range_of = "input" if fit.model.judged_backward else "output"
    caption = (
        f"RMSE on loops held out inside the fitted part, in percent of the {range_of}'s range, with its standard "
        "error. A simpler family is preferred to one that is hardly better. The curve without hysteresis is shown with "
        "its error on the fitted part."
    )
    compared = sum(candidate in fit.candidates for candidate in drawn)
    if len(fit.candidates) > compared:
        caption += f" Of {len(fit.candidates)} variants, the best of each family and the best of the rest are drawn."
    if any(c.error_percent > edge for c in drawn):
        caption += " Bars with an arrow are cut; their numbers are right."
    best = ", ".join(f"{_name(c)} {c.error_percent:.3g} %" for c in drawn[:4])
    rows = [
        Bar(
            f"{short(_name(c), 52)}{', taken' if c.chosen else ''}",
            c.error_percent,
            TRAIN if c.chosen else STATIC if _is_static(c) else OTHER,
            f"{number(c.error_percent)} %",
            spread=_spread(c),
            bold=c.chosen,
        )
        for c in drawn
    ]
    draw = bars(rows, "RMSE on held-out loops [% of range]", edge=edge)
    return Figure(
        "candidates", "Models that were compared", caption, (Panel("Error on held-out loops", draw, f"Bars: {best}."),)
    )


def shown(fit: Fit) -> list[Candidate]:
    """Return the chosen one, the best of each family, the curve without hysteresis, then the best of the rest."""
    ranked = sorted((c for c in fit.candidates if np.isfinite(c.error_percent)), key=lambda c: rank(c.error_percent))
    leaders = [next(c for c in ranked if c.family == family) for family in dict.fromkeys(c.family for c in ranked)]
    chosen = [c for c in ranked if c.chosen]
    must = chosen + [c for c in leaders if c not in chosen][: MAXIMUM_BARS - 2]
    named = {_name(c): c for c in reversed(ranked)}  # of variants with the same name, the best
    rest = [c for c in named.values() if _name(c) not in {_name(m) for m in must}]
    rest = sorted(rest, key=lambda c: rank(c.error_percent))[: max(0, MAXIMUM_BARS - 1 - len(must))]
    curve = [Candidate("static", "", None, fit.static_train.rmse_percent, float("nan"))]
    curve = [] if any(_is_static(c) for c in must) else curve
    return sorted(must + rest + curve, key=lambda c: rank(c.error_percent))


def _is_static(candidate: Candidate) -> bool:
    return candidate.family.startswith("static")


def _name(candidate: Candidate) -> str:
    if _is_static(candidate):
        return "curve without hysteresis"
    start = candidate.initial_state
    extra = [f"starts {_STARTS.get(start, start)}"] if start else []
    if candidate.smoothing is not None:
        extra.append(f"smoothing {candidate.smoothing:g}")
    return f"{candidate.family}: {', '.join(extra)}" if extra else candidate.family


def reach(candidates: Sequence[Candidate]) -> float:
    """Return where the axis ends: a candidate that went astray must not squash the others."""
    largest = max(c.error_percent + _spread(c) for c in candidates) or 1.0
    least = min(c.error_percent for c in candidates)
    chosen = min([c.error_percent for c in candidates if c.chosen], default=least)
    return min(largest, CUT * chosen) if chosen > 0.0 else largest


def _spread(candidate: Candidate) -> float:
    return candidate.uncertainty_percent if np.isfinite(candidate.uncertainty_percent) else 0.0


@dataclass(frozen=True, slots=True)
class _Family:
    """Refits of one family: with other numbers of operators, and with other eps."""

    name: str
    token: Token
    by_n: tuple[Refit, ...]
    by_eps: tuple[Refit, ...]


def settings_figure(fit: Fit) -> Figure | None:
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
    by_n = " ".join(f"{f.name}: {_error(f.by_n[0])} % with 5, {_error(f.by_n[-1])} % with 160." for f in families)
    by_eps = " ".join(f"{f.name}: {_error(f.by_eps[0])} % at 0.001, {_error(f.by_eps[-1])} % at 0.4." for f in families)
    panels = (
        Panel("Error over the number of operators", _curves("operators n", OPERATORS, families, "by_n"), by_n),
        Panel("Error over eps", _curves("eps, relative", EPS, families, "by_eps"), by_eps),
    )
    return Figure("settings", "Other numbers of operators, other eps", caption, panels, table=_table(families[0], unit))


def _beside(fit: Fit) -> str:
    """Family to compare with; a sheared loop is refitted with sums of plays only."""
    if fit.model.shear is not None:
        return "pi" if fit.family == "pi-cumulative" else "pi-cumulative"
    return _BESIDE.get(fit.family, "pi")


def _family(fit: Fit, name: str, token: Token) -> _Family:
    # The finest grid first: the others are sums of its cells.
    by_n = [fit.refit(family=name, n=n) for n in reversed(OPERATORS)]
    slope = _mean_slope(fit) if name == "pi" else 1.0
    by_eps = [fit.refit(family=name, eps=eps * slope) for eps in EPS]
    return _Family(name, token, tuple(reversed(by_n)), tuple(by_eps))


def _mean_slope(fit: Fit) -> float:
    """Output range over input range of the fitted samples. [output/input]"""
    spans = []
    for signal in ("output", "input"):
        fitted = [getattr(rec, signal)[mask] for rec, mask in zip(fit.recordings, fit.train_masks, strict=True)]
        there = [values for values in fitted if values.size]
        spans.append(max(float(np.max(v)) for v in there) - min(float(np.min(v)) for v in there))
    return spans[0] / spans[1]


def _percent(refit: Refit) -> float:
    return (refit.test or refit.train).rmse_percent


def _error(refit: Refit) -> str:
    return number(_percent(refit))


def _curves(across: str, values: Sequence[float], families: Sequence[_Family], which: str) -> Draw:
    places = np.log10(np.array(values, dtype=np.float64))
    lines = [
        Line(places, np.array([_percent(refit) for refit in getattr(f, which)]), f.token, f.name, 1.6, marker="o")
        for f in families
    ]

    def ticks(axes: Axes) -> None:
        axes.set_xticks(places, [f"{value:g}" for value in values])

    return chart(across, "RMSE [% of range]", lines, zero=True, also=ticks)


def _table(family: _Family, unit: str) -> Table:
    named = [*((f"n = {r.n}", r) for r in family.by_n), *zip((f"eps = {e:g}" for e in EPS), family.by_eps, strict=True)]
    rows = tuple((name, _error(r), str(r.nonzero_weights), number(r.inverse_gain)) for name, r in named)
    head = ("", f"{unit} [% of range]", "weights", "gain of the inverse")
    return Table(f"{family.name} with other settings", head, rows, folded=True)
