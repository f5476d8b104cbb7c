"""Figure 8: what the choice of a family compared."""

from __future__ import annotations

from functools import partial

import numpy as np

from dehyst.arrays import Array, rank
from dehyst.identification.fit import Candidate, Fit
from dehyst.report.figures.panel import Axes, Figure, Panel, says
from dehyst.report.text import number, short
from dehyst.report.theme import INK, MUTED, OTHER, STATIC, TRAIN

MAXIMUM_BARS = 7
# Bars longer than this many times the error of the chosen one are cut.
CUT = 3.0

_STARTS = {"zero": "at zero", "rest": "at rest"}


def candidates_figure(fit: Fit) -> Figure | None:
    """Return figure 8, or None if a family was named and nothing compared."""
    if not fit.candidates:
        return None
    drawn = _shown(fit)
    range_of = "input" if fit.model.judged_backward else "output"
    caption = (
        f"RMSE on loops held out inside the fitted part, in percent of the {range_of}'s range, with its standard "
        "error. A simpler family is preferred to one that is hardly better. The curve without hysteresis is shown with "
        "its error on the fitted part."
    )
    compared = sum(candidate in fit.candidates for candidate in drawn)
    if len(fit.candidates) > compared:
        caption += f" Of {len(fit.candidates)} variants, the best of each family and the best of the rest are drawn."
    if any(c.error_percent > reach(drawn) for c in drawn):
        caption += " Bars with an arrow are cut; their numbers are right."
    best = ", ".join(f"{_name(c)} {c.error_percent:.3g} %" for c in drawn[:4])
    return Figure(
        "candidates",
        "What was compared",
        caption,
        (
            Panel(
                "Error on held-out loops",
                partial(draw_bars, drawn, "RMSE on held-out loops [% of range]"),
                says(f"Bars: {best}."),
            ),
        ),
    )


def _shown(fit: Fit) -> list[Candidate]:
    """The chosen one, the best of each family, the curve without hysteresis, then the best of the rest."""
    ranked = sorted((c for c in fit.candidates if np.isfinite(c.error_percent)), key=lambda c: rank(c.error_percent))
    leaders = [next(c for c in ranked if c.family == family) for family in dict.fromkeys(c.family for c in ranked)]
    chosen = [c for c in ranked if c.chosen]
    must = chosen + [c for c in leaders if c not in chosen][: MAXIMUM_BARS - 2]
    named = {_name(c): c for c in reversed(ranked)}  # of variants with the same name, the best
    rest = [c for c in named.values() if _name(c) not in {_name(m) for m in must}]
    rest = sorted(rest, key=lambda c: rank(c.error_percent))[: max(0, MAXIMUM_BARS - 1 - len(must))]
    curve = (
        []
        if any(is_static(c) for c in must)
        else [Candidate("static", "", None, fit.static_train.rmse_percent, float("nan"))]
    )
    return sorted(must + rest + curve, key=lambda c: rank(c.error_percent))


def is_static(candidate: Candidate) -> bool:
    """Whether a candidate has no hysteresis."""
    return candidate.family.startswith("static")


def _name(candidate: Candidate) -> str:
    if is_static(candidate):
        return "curve without hysteresis"
    start = candidate.initial_state
    extra = [f"starts {_STARTS.get(start, start)}"] if start else []
    if candidate.smoothing is not None:
        extra.append(f"smoothing {candidate.smoothing:g}")
    return f"{candidate.family}: {', '.join(extra)}" if extra else candidate.family


def reach(shown: list[Candidate]) -> float:
    """Return where the axis ends: a candidate that went astray must not squash the others."""
    error = np.array([c.error_percent for c in shown])
    largest = float(np.max(error + _spread(shown))) or 1.0
    chosen = min([c.error_percent for c in shown if c.chosen], default=float(np.min(error)))
    return min(largest, CUT * chosen) if chosen > 0.0 else largest


def _spread(shown: list[Candidate]) -> Array:
    return np.array([c.uncertainty_percent if np.isfinite(c.uncertainty_percent) else 0.0 for c in shown])


def draw_bars(shown: list[Candidate], label: str, axes: Axes) -> None:
    """Draw errors as bars, the name above each; what was taken stands out."""
    place = np.arange(len(shown))
    error, edge = np.array([c.error_percent for c in shown]), reach(shown)
    cut = error > edge
    end = np.minimum(error + np.where(cut, 0.0, _spread(shown)), edge)
    colours = [TRAIN.light if c.chosen else STATIC.light if is_static(c) else OTHER.light for c in shown]
    axes.barh(place, np.minimum(error, edge), height=0.34, color=colours, zorder=2)
    whole = np.flatnonzero(~cut)
    axes.errorbar(
        error[whole],
        place[whole],
        xerr=(np.minimum(_spread(shown), error)[whole], (end - error)[whole]),
        fmt="none",
        color=INK.light,
        ecolor=INK.light,
        elinewidth=1.1,
        capsize=2.5,
        zorder=3,
    )
    for bar in np.flatnonzero(cut):  # it goes on: an arrow, and the number
        axes.plot([edge * 1.012], [bar], marker=">", markersize=11.0, color=colours[int(bar)], ls="none", zorder=2)
    axes.set_xlim(0.0, edge * 1.2)
    axes.set_ylim(len(shown) - 0.4, -0.75)
    for k, candidate in enumerate(shown):
        mark = ", taken" if candidate.chosen else ""
        axes.text(
            0.0,
            k - 0.22,
            f"{short(_name(candidate), 52)}{mark}",
            va="bottom",
            ha="left",
            fontsize=10.0,
            color=INK.light,
            fontweight="bold" if candidate.chosen else "normal",
        )
        axes.text(
            end[k] + edge * (0.05 if cut[k] else 0.015),
            k,
            f"{number(error[k])} %",
            va="center",
            ha="left",
            fontsize=9.5,
            color=MUTED.light,
        )
    axes.set_yticks([])
    axes.grid(visible=False, axis="y")
    axes.spines["left"].set_visible(False)
    axes.locator_params(axis="x", nbins=6)
    axes.set_xlabel(label)
