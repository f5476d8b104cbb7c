"""Table of families: names, and modules imported on first use.

A new row is a row in table.py; another family is a module with a `FAMILY`, one line here, and a test file
(CONTRIBUTING.md shows it).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING

from dehyst.errors import ParameterError
from dehyst.families.table import ROWS as TABLE

if TYPE_CHECKING:
    from dehyst.families.base import LoopModel
    from dehyst.families.training import Training

# The families that are no row of elements, each a module. Simple ones first: the order where nothing else decides.
MODULES = {
    "dahl": "dehyst.families.dahl",
    "duhem": "dehyst.families.duhem",
    "preisach": "dehyst.families.preisach",
    "bouc-wen": "dehyst.families.bouc_wen",
    "generalised-bouc-wen": "dehyst.families.generalised_bouc_wen",
    "lugre": "dehyst.families.lugre",
}
BEST = "elements"  # the row that a log itself calls for
TITLES = {  # of families that `dehyst.identification` knows
    "static": "curve without memory",
    "pi": "Prandtl-Ishlinskii (the paper)",
    "pi-cumulative": "Prandtl-Ishlinskii, partial sums",
    "modified-pi": "modified Prandtl-Ishlinskii",
    "stop": "stop operators",
    "direct-inverse": "direct inverse",
}
ROWS = (BEST, *(row.name for row in TABLE))  # of the one machine of elements: they share one record


@dataclass(frozen=True)
class Family:
    """A family that can be identified from a log.

    Attributes
    ----------
    name
        As typed, "bouc-wen".
    title
        As written, "Bouc-Wen".
    model
        Its record.
    fit
        Training data -> the fitted model, with the training's scaling. It raises a `DehystError` that says why where
        the family cannot fit the data.
    convex
        Whether the fit is a convex program: no seeds, no local minima.
    source
        Where it comes from.
    sample
        A small model, where that of the record is another family's, too.
    """

    name: str
    title: str
    model: type[LoopModel]
    fit: Callable[[Training], LoopModel]
    convex: bool
    source: str
    sample: Callable[[], LoopModel] | None = None


def names() -> tuple[str, ...]:
    """Names of the families of this registry.

    Examples
    --------
    >>> "dahl" in names()
    True
    """
    return (*ROWS, *MODULES)


def family(name: str) -> Family:
    """Return a family by its name.

    Raises
    ------
    ParameterError
        If there is none of that name.
    """
    if name not in names():
        raise ParameterError(f"no family '{name!s:.40}'. There are: {', '.join(names())}.", name=name)
    if name in ROWS:
        found = import_module("dehyst.families.rows").FAMILIES[name]
    else:
        found = import_module(MODULES[name]).FAMILY
    assert isinstance(found, Family)
    return found


def title_of(name: str) -> str:
    """Return how a family is written in tables, one of `dehyst.identification` or of this registry."""
    return TITLES.get(name) or family(name).title


def record_of(name: str) -> type[LoopModel]:
    """Return the record that models of a name are made of, identified here or not.

    Raises
    ------
    ParameterError
        If there is none of that name.

    Examples
    --------
    >>> record_of("elements").__name__, record_of("dahl").__name__
    ('ElementModel', 'Dahl')
    """
    if name not in ROWS:
        return family(name).model
    found: type[LoopModel] = import_module("dehyst.families.elements").ElementModel  # playing needs no fit
    return found


def example(name: str) -> LoopModel:
    """Return a small model of a family.

    Examples
    --------
    >>> example("dahl").family
    'dahl'
    """
    found = family(name)
    return found.sample() if found.sample is not None else found.model.example()
