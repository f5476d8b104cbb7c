"""Figure 9: what another number of operators and another eps would have done, by refits of the same data."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np

from dehyst.identification.fit import Fit, Refit
from dehyst.report.figures.panel import Axes, Figure, Panel, add_legend, label_axes, says
from dehyst.report.tables import Table
from dehyst.report.text import number
from dehyst.report.theme import OTHER, TRAIN, Token
from dehyst.report.thin import Window

# Grids that are parts of the finest one, so that one pass over the data is enough for all of them.
OPERATORS = (5, 10, 20, 40, 80, 160)
# Relative to output range over input range, whatever the family.
EPS = (0.001, 0.01, 0.03, 0.1, 0.2, 0.4)
_BESIDE = {"pi": "modified-pi", "modified-pi": "pi", "stop": "pi-cumulative", "pi-cumulative": "stop"}


@dataclass(frozen=True, slots=True)
class _Family:
    name: str
    token: Token
    by_n: tuple[Refit, ...]
    by_eps: tuple[Refit, ...]


def settings_figure(fit: Fit) -> Figure | None:
    """Return figure 9, or None for a fit that holds no sums over its data."""
    if fit.refitter is None:
        return None
    unit = "held out" if fit.test is not None else "fitted"
    families = [
        _family(fit, fit.family, TRAIN),
        _family(fit, _beside(fit), OTHER),
    ]
    caption = (
        f"RMSE on the {unit} samples if the same data were fitted with another number of operators or another eps, in "
        "percent of the output's range; the start state stays. Where the curve is flat, fewer operators or a firmer "
        "eps cost nothing: a smaller model, or an inverse that amplifies less. eps is relative to output range over "
        "input range here. The table holds this model's family; gain is the largest slope of the inverse."
    )
    own = families[0]
    panels = (
        Panel(
            "Error over the number of operators",
            partial(_draw, families, True, fit),
            says(*(f"{f.name}: {_percent(f.by_n[0])} % with 5, {_percent(f.by_n[-1])} % with 160." for f in families)),
        ),
        Panel(
            "Error over eps",
            partial(_draw, families, False, fit),
            says(
                *(f"{f.name}: {_percent(f.by_eps[0])} % at 0.001, {_percent(f.by_eps[-1])} % at 0.4." for f in families)
            ),
        ),
    )
    return Figure("settings", "Another n, another eps", caption, panels, table=_table(own, unit))


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
    ranges = [
        (float(np.min(v[m])), float(np.max(v[m])))
        for signal in ("output", "input")
        for v, m in ((getattr(rec, signal), mask) for rec, mask in zip(fit.recordings, fit.train_masks, strict=True))
        if m.any()
    ]
    half = len(ranges) // 2
    spans = [max(high for _, high in part) - min(low for low, _ in part) for part in (ranges[:half], ranges[half:])]
    return spans[0] / spans[1]


def _error(refit: Refit) -> float:
    return (refit.train if refit.test is None else refit.test).rmse_percent


def _percent(refit: Refit) -> str:
    return number(_error(refit))


def _draw(families: list[_Family], over_n: bool, fit: Fit, axes: Axes) -> None:
    places = np.log10(np.array(OPERATORS if over_n else EPS, dtype=np.float64))
    curves = [(f, np.array([_error(r) for r in (f.by_n if over_n else f.by_eps)])) for f in families]
    zero = (places, np.zeros(places.size))
    window = Window.around(*((places, errors) for _, errors in curves), zero, margin=0.06)
    label_axes(axes, window, "operators n" if over_n else "eps, relative", "RMSE [% of range]")
    for family, errors in curves:
        axes.plot(places, errors, "o-", color=family.token.light, lw=1.6, ms=4.5, mew=0.0, label=family.name)
    axes.set_xticks(places, [f"{value:g}" for value in (OPERATORS if over_n else EPS)])
    axes.axhline(0.0, color=OTHER.light, lw=0.8, zorder=1)
    add_legend(axes)


def _table(family: _Family, unit: str) -> Table:
    rows = [(f"n = {r.n}", _percent(r), str(r.nonzero_weights), number(r.inverse_gain)) for r in family.by_n]
    rows += [
        (f"eps = {eps:g}", _percent(r), str(r.nonzero_weights), number(r.inverse_gain))
        for eps, r in zip(EPS, family.by_eps, strict=True)
    ]
    return Table(
        f"{family.name} with other settings",
        ("", f"{unit} [% of range]", "weights", "gain of the inverse"),
        tuple(rows),
        folded=True,
    )
