"""The families: one module each, named here and imported when it is first asked for.

A new family is a new module with a `FAMILY`, one line here, and a test file (CONTRIBUTING.md shows it).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING

from dehyst.errors import ParameterError

if TYPE_CHECKING:
    from dehyst.families.base import LoopModel
    from dehyst.families.training import Training

# Simple ones first: the order of the table where nothing else decides.
MODULES = {
    "generalised-pi": "dehyst.families.generalised_pi",
    "rate-dependent-pi": "dehyst.families.rate_dependent_pi",
    "creep-pi": "dehyst.families.creep_pi",
    "maxwell-slip": "dehyst.families.maxwell_slip",
    "dahl": "dehyst.families.dahl",
    "duhem": "dehyst.families.duhem",
    "preisach": "dehyst.families.preisach",
    "bouc-wen": "dehyst.families.bouc_wen",
    "generalised-bouc-wen": "dehyst.families.generalised_bouc_wen",
    "krasnoselskii-pokrovskii": "dehyst.families.krasnoselskii_pokrovskii",
    "lugre": "dehyst.families.lugre",
    "elements": "dehyst.families.rows",  # the best row below for a log; a comparison has no time for all of them
}
# Rows of the one machine of elements, families of dehyst.families.rows that share one record.
ROWS = (
    "elements", "play-sum", "play-creep", "preisach-sum", "damper-sum", "mixed-sum", "full-sum",
    "inverse-stop", "inverse-stop-rate", "inverse-path",
)  # fmt: skip


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
    """

    name: str
    title: str
    model: type[LoopModel]
    fit: Callable[[Training], LoopModel]
    convex: bool
    source: str


def names() -> tuple[str, ...]:
    """Names of the families of this registry.

    Examples
    --------
    >>> "dahl" in names()
    True
    """
    return tuple(MODULES)


def family(name: str) -> Family:
    """Return a family by its name.

    Raises
    ------
    ParameterError
        If there is none of that name.
    """
    if name not in MODULES and name not in ROWS:
        known = ", ".join(dict.fromkeys((*MODULES, *ROWS)))
        raise ParameterError(f"no family '{name!s:.40}'. There are: {known}.", name=name)
    found = import_module(MODULES["elements"]).FAMILIES[name] if name in ROWS else import_module(MODULES[name]).FAMILY
    assert isinstance(found, Family)
    return found


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
    return family(name).model.example()
