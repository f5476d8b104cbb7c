r"""Families that are sums of elements, built from the table of rows: fitted, run and inverted in the same way.

A row of the table (`dehyst.families.table`) says which groups of columns take part in a sum, whether a map stands
behind it, and its direction::

    T(y) = c + sum over k of f_k(e_k[x])        forward: the output from the input
    x = c + sum over k of f_k(e_k[y])           inverse: the input from the output; forward it is solved

where every column rises, or stands still, with the present sample whatever came before, so that weights from 0 on give
a sum that rises, has one solution, and an inverse that is exact. ``elements`` is the row that a log itself calls for:
chosen within what is fitted, with its regularisation and its map.

Source: Brokate and Sprekels 1996 (Preisach's operator as ramps of plays); Krejci and Kuhnen 2001 (creep); Dahl 1968;
the choice is this project's, docs/decisions/0043. Structure: high confidence.

Cannot show
-----------
Inertia; an output that falls while the input rises, whatever the memory; what changes from day to day.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from functools import partial

import numpy as np

from dehyst.data.loops import turning_points
from dehyst.errors import IdentificationError
from dehyst.families.choice import Chosen, choose
from dehyst.families.columns import Pace, columns_of
from dehyst.families.elements import ElementModel
from dehyst.families.registry import BEST, Family
from dehyst.families.table import OWN, ROWS, Row, Sum
from dehyst.families.training import Training

ENOUGH_TURNS = 3  # within the fitted part, for rows of many groups
SWING = 0.2  # of a turn, scaled: a tenth of the range
SHOWN = 3  # columns of a group in an example
USUAL = Pace(0.01, 5.0, (0.01, 0.03, 0.1))


def candidates(training: Training, firm: bool = True) -> tuple[Sum, ...]:
    """Sums that the training can tell apart: few groups where the input turned seldom, no time without stamps.

    What a group of columns remembers is seen only where the input turns. With fewer than three turns the rows with many
    groups follow the one loop that was seen, and err on the next. Where it never turned, no loop was seen: bends of
    the curve are then taken for those of the map, as `identify` does. Firm ones have inverses.
    """
    turns = turns_of(training)
    if turns < 1:
        return (replace(ROWS[0].sums[0], maps=(True,)),)
    depth = ["few"] if turns < ENOUGH_TURNS else ["many"] if firm else ["many", "simulate"]
    able = [one for row in ROWS if row.chosen in ("always", *depth) for one in row.sums]
    return tuple(able) if training.timed else _timeless(able)


def _timeless(sums: Iterable[Sum]) -> tuple[Sum, ...]:
    """What is left of sums without their elements that take time; of the same groups that of the earlier row."""
    left: dict[tuple[tuple[str, ...], str], Sum] = {}
    for one in sums:
        rest = one.timeless
        if rest.groups:
            left.setdefault((rest.groups, rest.direction), rest)
    return tuple(left.values())


def turns_of(training: Training) -> int:
    """How often the input turns within a training, its ends not counted."""
    return sum(turning_points(stretch.x, SWING).size - 2 for stretch in training.stretches)


def sample(row: Row) -> ElementModel:
    """A model of a row with a few columns of each group."""
    one = row.sums[0]
    columns = columns_of(one.groups, 1, USUAL)
    weight = np.where(columns.group == "x", 0.4, 0.0)
    for group in one.groups:
        own = np.flatnonzero(columns.group == group)
        weight[own[(2 * np.arange(SHOWN) + 1) * own.size // (2 * SHOWN)]] = 0.5 / (SHOWN * len(one.groups))
    period = USUAL.period if one.timed else 0.0
    return ElementModel(columns.elements(weight), direction=one.direction, period=period, row=row.name)


def _fit_row(training: Training, row: Row) -> ElementModel:
    return choose(training, row.sums if training.timed else _without_time(row)).model


def _without_time(row: Row) -> tuple[Sum, ...]:
    """The sums of a row for a log without time stamps: those without time, else what is left of it, as `auto` takes it.

    What is left may be another row, which is then named.
    """
    untimed = tuple(one for one in row.sums if not one.timed)
    if untimed:
        return untimed
    everything = _timeless(one for row in ROWS for one in row.sums)
    left = tuple(one for one in everything if one.name == row.name)
    if left:
        return left
    rest = row.sums[0].timeless
    same = next(one.name for one in everything if (one.groups, one.direction) == (rest.groups, rest.direction))
    raise IdentificationError(
        f"{row.name} has elements that take time, but the recording has no time stamps. Name their column "
        f"(--time); without time {row.name} is {same}, so take --family {same}."
    )


def _fit_best(training: Training) -> ElementModel:
    return best_row(training).model


def best_row(training: Training, firm: bool = True) -> Chosen:
    """Return the best row for a training, and all that were compared."""
    return choose(training, candidates(training, firm), firm)


def family_of(row: Row) -> Family:
    """The family of a row."""
    fit, shown = partial(_fit_row, row=row), partial(sample, row)
    return Family(row.name, row.title, ElementModel, fit, True, row.source, shown)


FAMILIES = {row.name: family_of(row) for row in ROWS}
FAMILIES[BEST] = Family(BEST, "best row of elements", ElementModel, _fit_best, True, OWN)
