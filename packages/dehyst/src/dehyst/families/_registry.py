"""Table of families: names, and modules imported on first use.

A new row is a row in table.py; another family is a module with a `FAMILY`, one line here, and a test file
(docs/contributing/add-a-model.md shows it). A package outside adds a `Family` by an entry point.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING

from dehyst.errors import ParameterError
from dehyst.families._table import ROWS as TABLE
from dehyst.plugins import added, load_added

if TYPE_CHECKING:
    from dehyst.families._base import LoopModel
    from dehyst.families._training import Training

# The families that are no row of elements, each a module. Simple ones first: the order where nothing else decides.
MODULES = {
    "dahl": "dehyst.families._dahl",
    "duhem": "dehyst.families._duhem",
    "preisach": "dehyst.families._preisach",
    "bouc-wen": "dehyst.families._bouc_wen",
    "generalised-bouc-wen": "dehyst.families._generalised_bouc_wen",
    "lugre": "dehyst.families._lugre",
    "butterfly": "dehyst.families._butterfly",
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
# Names of the rows: all of them share one record, that of the sum of elements.
ROW_NAMES = (BEST, *(row.name for row in TABLE))
GROUP = "dehyst.families"  # entry points of other packages, each a `Family`


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
    """Names of the families of this registry, those of other packages last.

    Examples
    --------
    >>> "dahl" in names()
    True
    """
    own = (*ROW_NAMES, *MODULES)
    return (*own, *sorted(set(added(GROUP)) - set(own)))


def is_family(name: str) -> bool:
    """Return whether there is a family of this name; other packages are looked for only where dehyst has none.

    Examples
    --------
    >>> is_family("dahl"), is_family("plays-of-my-own")
    (True, False)
    """
    return name in ROW_NAMES or name in MODULES or name in added(GROUP)


def family(name: str) -> Family:
    """Return a family by its name.

    Raises
    ------
    ParameterError
        If there is none of that name.
    """
    if not is_family(name):
        raise ParameterError(
            f"no family '{name!s:.40}'. There are: {', '.join(names())}.", name=name
        )
    if name in ROW_NAMES:
        entry = import_module("dehyst.families._rows").FAMILIES[name]
    elif name in MODULES:
        entry = import_module(MODULES[name]).FAMILY
    else:
        entry = load_added(GROUP, name)
    if not isinstance(entry, Family):
        raise ParameterError(
            f"the entry point '{name}' of {GROUP} names a {type(entry).__name__} and no dehyst.families.Family. "
            f"Correct it in the package that brings it, or remove that package.",
            name=name,
        )
    return entry


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
    if name not in ROW_NAMES:
        return family(name).model
    # The record alone is enough to play a model; the fit of the rows is not imported.
    record: type[LoopModel] = import_module("dehyst.families._elements").ElementModel
    return record


def example(name: str) -> LoopModel:
    """Return a small model of a family.

    Examples
    --------
    >>> example("dahl").family
    'dahl'
    """
    entry = family(name)
    if entry.sample is not None:
        return entry.sample()
    return entry.model.example()
