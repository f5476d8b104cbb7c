r"""Rows of elements: families of one grammar, fitted by one program, run and inverted by one machine.

A row says which groups of columns take part in a sum, whether a map stands behind it, and its direction::

    T(y) = c + sum over k of f_k(e_k[x])        forward: the output from the input
    x = c + sum over k of f_k(e_k[y])           inverse: the input from the output; forward it is solved

where every column rises, or stands still, with the present sample whatever came before, so that weights from 0 on give
a sum that rises, has one solution, and an inverse that is exact. ``elements`` is the row that a log itself calls for:
chosen within what is fitted, with its regularisation and its map.

=====================  ================================================================================================
row                    columns beside the curve
=====================  ================================================================================================
``play-sum``           plays: Prandtl and Ishlinskii; with a map it is modified PI
``play-creep``         plays, creep with dead zones
``preisach-sum``       ramps of plays: Preisach's operator by its two thresholds
``damper-sum``         stops, relaxation by place, saturated rate: a force over a displacement
``mixed-sum``          plays, stops, creep, relaxation, saturated rate
``full-sum``           ramps of plays and of x less plays, creep and relaxation by place, saturated rate
``inverse-stop``       inverse: stops, relaxation
``inverse-stop-rate``  inverse: stops, relaxation, saturated rate
``inverse-path``       inverse: Dahl's lags along the way, relaxation
=====================  ================================================================================================

Source: Brokate and Sprekels 1996 (Preisach's operator as ramps of plays); Krejci and Kuhnen 2001 (creep); Dahl 1968;
the choice is this project's, docs/decisions/0043. Structure: high confidence.

Cannot show
-----------
Inertia; an output that falls while the input rises, whatever the memory; what changes from day to day.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

from dehyst.errors import IdentificationError
from dehyst.families.choice import Sum, best_model
from dehyst.families.columns import TIMED
from dehyst.families.elements import ElementModel
from dehyst.families.registry import Family
from dehyst.families.training import Training
from dehyst.loops import turning_points

ENOUGH_TURNS = 3  # within the fitted part, for rows of many groups
SWING = 0.2  # of a turn, scaled: a tenth of the range


@dataclass(frozen=True)
class Row:
    """A family of the grammar.

    Attributes
    ----------
    name, title
        As typed and as written.
    sum
        Its groups of columns and direction.
    chosen
        When the choice among rows looks at it: "always", with "few" turns, with "many", or "never".
    """

    name: str
    title: str
    sum: Sum
    chosen: str

    @property
    def timed(self) -> bool:
        """Whether it has elements that take time."""
        return not TIMED.isdisjoint(self.sum.groups)


def _row(name: str, title: str, groups: str, chosen: str = "never", direction: str = "forward") -> Row:
    maps = (False, True) if direction == "forward" else (False,)
    return Row(name, title, Sum(name, tuple(groups.split()), direction, maps), chosen)


ROWS = (
    _row("play-sum", "sum of plays", "play", "always"),
    _row("play-creep", "plays and creep", "play creep", "few"),
    _row("preisach-sum", "ramps of plays", "lag", "always"),
    _row("damper-sum", "stops, relaxation, rate", "stop relax-by-place rate"),
    _row("mixed-sum", "plays, stops, creep, rate", "play stop creep relax rate", "many"),
    _row("full-sum", "ramps of plays, creep, rate", "lag lead creep-by-place relax-by-place rate", "many"),
    _row("inverse-stop", "inverse: stops, relaxation", "stop relax", "many", "inverse"),
    _row("inverse-stop-rate", "inverse: stops, relaxation, rate", "stop relax rate", "many", "inverse"),
    _row("inverse-path", "inverse: lags along the way", "path relax", "never", "inverse"),
)


def candidates(training: Training) -> tuple[Sum, ...]:
    """Sums that the training can tell apart: few groups where the input turned seldom, no time without stamps.

    What a group of columns remembers is seen only where the input turns. With fewer than three turns the rows with many
    groups follow the one loop that was seen, and err on the next. Where it never turned, no loop was seen: bends of
    the curve are then taken for those of the map, as `identify` does.
    """
    turns = sum(turning_points(stretch.x, SWING).size - 2 for stretch in training.stretches)  # without its ends
    depth = "many" if turns >= ENOUGH_TURNS else "few"
    timeless = [row for row in ROWS if training.timed or not row.timed]
    if turns < 1:
        return (replace(timeless[0].sum, maps=(True,)),)
    return tuple(row.sum for row in timeless if row.chosen in ("always", depth))


def _fit_row(training: Training, row: Row) -> ElementModel:
    if row.timed and not training.timed:
        raise IdentificationError(
            f"{row.name} has elements that take time, but the recording has no time stamps. Name their column "
            f"(--time), or take a row without time, such as preisach-sum."
        )
    return best_model(training, (row.sum,))


def _fit_best(training: Training) -> ElementModel:
    return best_model(training, candidates(training))


SOURCE = "docs/decisions/0043-rows-of-elements.md"
FAMILIES = {
    row.name: Family(row.name, row.title, ElementModel, partial(_fit_row, row=row), True, SOURCE) for row in ROWS
}
FAMILY = FAMILIES["elements"] = Family("elements", "best row of elements", ElementModel, _fit_best, True, SOURCE)
