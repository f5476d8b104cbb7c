"""Figure 6: what the residual follows, what of it is noise, and what to try next."""

from __future__ import annotations

from functools import partial

import numpy as np

from dehyst.identification.fit import Fit
from dehyst.identification.residual import TITLES, Residual
from dehyst.report.figures.panel import Axes, Figure, Panel, says
from dehyst.report.tables import Table
from dehyst.report.text import number
from dehyst.report.theme import FIFTH, INK, MUTED, OTHER, TRAIN

NOISE = {
    "repeats": "noise, from strokes that were repeated",
    "differences": "noise, from sample to sample: the least it can be",
}
TOGETHER = "all causes together"


def structure_figure(fit: Fit) -> Figure | None:
    """Return figure 6, or None where there is nothing but rounding, or too little to tell."""
    found = fit.residual
    if not found.causes:
        return None
    caption = (
        f"Shares of the squared residual of the {found.part} part, {number(found.rms_percent)} % of range rms, that "
        "each cause explains by itself, fitted to every other block of it and scored on those between: noise explains "
        "nothing. Dark: what no other cause explains, too. Causes overlap, so shares need not add up."
    )
    best = ", ".join(f"{name} {100.0 * share:.0f} %" for name, share, _, _ in _rows(found))
    return Figure(
        "structure",
        "What is left, and what it follows",
        caption,
        (Panel("Share of the squared residual", partial(_draw, found), says(f"Bars: {best}.")),),
        table=_table(found),
        points=found.suggestions,
    )


def _rows(found: Residual) -> list[tuple[str, float, float, float]]:
    """Name, share, own share and size of every bar."""
    rows = [(TITLES[cause.name], cause.share, cause.own, cause.size_percent) for cause in found.causes]
    if found.noise_share is not None and found.noise_percent is not None:
        rows.append((NOISE[found.noise_from], found.noise_share, found.noise_share, found.noise_percent))
    return rows


def _table(found: Residual) -> Table:
    rows = [
        (name, f"{100.0 * share:.0f} %", f"{100.0 * own:.0f} %", f"{number(size)} %")
        for name, share, own, size in _rows(found)
    ]
    together = found.rms_percent * float(np.sqrt(found.explained))
    rows.append((TOGETHER, f"{100.0 * found.explained:.0f} %", "", f"{number(together)} %"))
    return Table(
        "What it follows",
        ("", "share", "own share", "rms, % of range"),
        tuple(rows),
    )


def _draw(found: Residual, axes: Axes) -> None:
    rows = [(*row[:3], FIFTH if row[0] in NOISE.values() else TRAIN) for row in _rows(found)]
    rows.append((TOGETHER, found.explained, found.explained, OTHER))
    for k, (name, share, own, token) in enumerate(rows):
        colour = token.light
        axes.barh(k, share, height=0.34, color=colour, alpha=0.4, zorder=2)
        axes.barh(k, own, height=0.34, color=colour, zorder=3)
        axes.text(0.0, k - 0.22, name, va="bottom", ha="left", fontsize=10.0, color=INK.light)
        axes.text(share + 0.015, k, f"{100.0 * share:.0f} %", va="center", ha="left", fontsize=9.5, color=MUTED.light)
    axes.set_xlim(0.0, 1.12)
    axes.set_ylim(len(rows) - 0.4, -0.8)
    axes.set_xticks(np.linspace(0.0, 1.0, 6), [f"{p} %" for p in range(0, 101, 20)])
    axes.set_yticks([])
    axes.grid(visible=False, axis="y")
    axes.spines["left"].set_visible(False)
