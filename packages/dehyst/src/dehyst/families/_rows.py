r"""Families that are sums of elements, built from the table of rows: fitted, run and inverted in the same way.

A row of the table (`dehyst.families.ROWS`) says which groups of columns take part in a sum, whether a map stands
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

from dehyst.data import turning_points
from dehyst.errors import IdentificationError
from dehyst.families._choice import Chosen, best_sum
from dehyst.families._columns import Pace, columns_of
from dehyst.families._elements import ElementModel
from dehyst.families._policy import POLICY
from dehyst.families._registry import BEST, Family
from dehyst.families._table import OWN, ROWS, Row, Sum
from dehyst.families._training import Training
from dehyst.families._transforms import transforms

SHOWN = 3  # columns of a group in an example
# Groups of columns that bend with the place, which a transform spares.
RAMPED = frozenset(("lag", "lead", "creep-by-place", "relax-by-place", "product"))
USUAL = Pace(0.01, 5.0, (0.01, 0.03, 0.1))


def candidates(training: Training, firm: bool = True) -> tuple[Sum, ...]:
    """Return the sums that the training can tell apart: few groups if the input seldom turned, no time without stamps.

    The memory of a group shows only where the input turns. With fewer than three turns the rows with many groups follow
    the one loop of the log, and are wrong on the next one. If the input never turned, the log shows no loop: bends of
    the curve then belong to the map, as in `identify`. With `firm`, the rows that have no certain inverse stay out.
    """
    turns = turns_of(training)
    if turns < 1:
        return (replace(ROWS[0].sums[0], maps=(True,)),)
    chosen: tuple[str, ...]
    if turns < POLICY.enough_turns:
        chosen = ("always", "few")
    elif firm:
        chosen = ("always", "many")
    else:
        chosen = ("always", "many", "simulate")
    sums: list[Sum] = []
    for row in ROWS:
        if row.chosen in chosen:
            sums += row.sums
    return tuple(sums) if training.timed else _timeless(sums)


def _timeless(sums: Iterable[Sum]) -> tuple[Sum, ...]:
    """Return the sums without their elements that take time; of equal ones that of the earlier row."""
    by_groups: dict[tuple[tuple[str, ...], str], Sum] = {}
    for row in sums:
        timeless = row.timeless
        if timeless.groups:
            by_groups.setdefault((timeless.groups, timeless.direction), timeless)
    return tuple(by_groups.values())


def turns_of(training: Training) -> int:
    """Return how often the input turns within a training, its ends not counted."""
    turns = 0
    for stretch in training.stretches:
        turns += turning_points(stretch.x, POLICY.swing).size - 2
    return turns


def sample(row: Row) -> ElementModel:
    """Return a model of a row with a few columns of each group."""
    first = row.sums[0]
    columns = columns_of(first.groups, 1, USUAL)
    weight = np.where(columns.group == "x", 0.4, 0.0)
    for group in first.groups:
        # Spread evenly over the columns of the group, none of them at its ends.
        members = np.flatnonzero(columns.group == group)
        shown = members[(2 * np.arange(SHOWN) + 1) * members.size // (2 * SHOWN)]
        weight[shown] = 0.5 / (SHOWN * len(first.groups))
    period = USUAL.period if first.timed else 0.0
    return ElementModel(
        columns.elements(weight), direction=first.direction, period=period, row=row.name
    )


def _fit_row(training: Training, row: Row) -> ElementModel:
    return _chosen_row(training, row).model


def _chosen_row(training: Training, row: Row, most: int | None = None) -> Chosen:
    sums = row.sums if training.timed else _without_time(row)
    return best_sum(training, sums, most=most)


def _without_time(row: Row) -> tuple[Sum, ...]:
    """Return the sums of a row for a log without time stamps: those without time, else its sums without such elements.

    Without them a row may be the same as another one, which the message then names.
    """
    untimed = tuple(candidate for candidate in row.sums if not candidate.timed)
    if untimed:
        return untimed
    every_sum: list[Sum] = []
    for listed in ROWS:
        every_sum += listed.sums
    timeless = _timeless(every_sum)
    remaining = tuple(candidate for candidate in timeless if candidate.name == row.name)
    if remaining:
        return remaining
    first = row.sums[0].timeless
    same = {(candidate.groups, candidate.direction): candidate.name for candidate in timeless}
    name = same[first.groups, first.direction]
    raise IdentificationError(
        f"{row.name} has elements that take time, but the recording has no time stamps. Name their column "
        f"(--time); without time {row.name} is {name}, so take --family {name}."
    )


def row_named(name: str, training: Training, most: int | None = None) -> Chosen:
    """Return the model of a row of `ROW_NAMES`, or of the best one, of at most so many numbers."""
    if name == BEST:
        return best_row(training, most=most)
    (row,) = (row for row in ROWS if row.name == name)
    return _chosen_row(training, row, most)


def _fit_best(training: Training) -> ElementModel:
    return best_row(training).model


def best_row(
    training: Training, firm: bool = True, most: int | None = None, forward: bool = False
) -> Chosen:
    """Return the best row for a training, of at most so many numbers, and all that were compared.

    With `forward`, rows of the other direction stay out.
    """
    sums = candidates(training, firm)
    if forward:
        sums = tuple(one for one in sums if one.direction == "forward")
    return best_sum(training, sums, firm, most)


def transformed(
    training: Training, chosen: Chosen, firm: bool, size: int | None
) -> tuple[Training, Chosen]:
    """Return the training and its best row behind the transform that pays, or both as they are.

    Behind the right transform a sum without ramps is enough, so these alone are tried; one is taken where it errs
    clearly less on what is left out than the best row of all without a transform.
    """
    plain = tuple(one for one in candidates(training, firm) if RAMPED.isdisjoint(one.groups))
    plain = tuple(one for one in plain if one.direction == "forward")
    if training.schedules or not plain:
        return training, chosen
    least, best = POLICY.input_transform * chosen.candidates[0].score, (training, chosen)
    for pairs in transforms(training.scaling).values():
        behind = replace(training, before_map=pairs, shared=[])
        try:
            row = best_sum(behind, plain, firm, size)
        except IdentificationError:
            continue
        if row.candidates[0].score < least:
            least, best = row.candidates[0].score, (behind, row)
    return best


def family_of(row: Row) -> Family:
    """Return the family of a row."""
    fit = partial(_fit_row, row=row)
    return Family(row.name, row.title, ElementModel, fit, True, row.source, partial(sample, row))


FAMILIES = {row.name: family_of(row) for row in ROWS}
FAMILIES[BEST] = Family(BEST, "best row of elements", ElementModel, _fit_best, True, OWN)
