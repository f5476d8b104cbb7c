"""Table of muscle models: names, and modules imported on first use.

A new model is a new module with a `MUSCLE`, its class, one line here, and a test file.
"""

from __future__ import annotations

import difflib
from importlib import import_module
from typing import Any

from dehyst.errors import ParameterError
from dehyst.robot.muscles.base import MuscleModel

# Maps first, then what adds friction, speed and memory.
MODULES = {
    "maker": "dehyst.robot.muscles.maker",
    "sarosi": "dehyst.robot.muscles.sarosi",
    "aschemann-schindele": "dehyst.robot.muscles.aschemann_schindele",
    "boblan-martens": "dehyst.robot.muscles.boblan_martens",
    "chou-hannaford": "dehyst.robot.muscles.chou_hannaford",
    "tondu-lopez": "dehyst.robot.muscles.tondu_lopez",
    "davis-caldwell": "dehyst.robot.muscles.davis_caldwell",
    "tondu-zagal": "dehyst.robot.muscles.tondu_zagal",
    "klute": "dehyst.robot.muscles.klute",
    "reynolds": "dehyst.robot.muscles.reynolds",
    "kerscher": "dehyst.robot.muscles.kerscher",
    "vo-minh": "dehyst.robot.muscles.vo_minh",
}


def names() -> tuple[str, ...]:
    """Names of the models.

    Examples
    --------
    >>> "tondu-lopez" in names()
    True
    """
    return tuple(MODULES)


def muscle_class(name: str) -> type[MuscleModel]:
    """Return a model's class by its name.

    Raises
    ------
    ParameterError
        If there is none of that name.
    """
    if name not in MODULES:
        near = difflib.get_close_matches(str(name), MODULES, 1)
        hint = f"Did you mean {near[0]}? " if near else ""
        raise ParameterError(f"no muscle model '{name!s:.40}'. {hint}There are: {', '.join(MODULES)}.", name=name)
    found: type[MuscleModel] = import_module(MODULES[name]).MUSCLE
    return found


def muscle(name: str, which: str = "", **changes: Any) -> MuscleModel:
    """Return a model with a published parameter set, and some parameters changed.

    Parameters
    ----------
    name
        Of the model.
    which
        Parameter set, one of its `SETS`; the first one if none is named.
    **changes
        Parameters by name.

    Raises
    ------
    ParameterError
        If there is no such model, set or parameter, or a value has no meaning.

    Examples
    --------
    >>> muscle("tondu-lopez", length=0.25).length
    0.25
    """
    kind = muscle_class(name)
    model = kind.published(which)
    known = [entry.name for entry in kind.PARAMETERS]
    wrong = [key for key in changes if key not in known]
    if wrong:
        raise ParameterError(
            f"{name} has no parameter {wrong[0]!r:.40}; it has: {', '.join(known)}.", parameter=wrong[0]
        )
    return kind(**{**{key: getattr(model, key) for key in known}, **changes})
