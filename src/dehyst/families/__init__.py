"""Hysteresis models of the literature: one file per family, fitted to one log and compared."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from dehyst.families.base import STARTS as STARTS
    from dehyst.families.base import UNSCALED as UNSCALED
    from dehyst.families.base import InverseLoop as InverseLoop
    from dehyst.families.base import LoopModel as LoopModel
    from dehyst.families.base import LoopStepper as LoopStepper
    from dehyst.families.base import Scaling as Scaling
    from dehyst.families.best import identify as identify
    from dehyst.families.blocks import block as block
    from dehyst.families.comparison import Comparison as Comparison
    from dehyst.families.comparison import all_names as all_names
    from dehyst.families.comparison import compare as compare
    from dehyst.families.fitting import FamilyFit as FamilyFit
    from dehyst.families.fitting import identify_family as identify_family
    from dehyst.families.registry import MODULES as MODULES
    from dehyst.families.registry import ROWS as ROWS
    from dehyst.families.registry import Family as Family
    from dehyst.families.registry import example as example
    from dehyst.families.registry import family as family
    from dehyst.families.registry import names as names
    from dehyst.families.training import Stretch as Stretch
    from dehyst.families.training import Training as Training

# Each is imported when it is first used: playing a model file must not load what identifies one.
_ROOMS = {
    "dehyst.families.base": "InverseLoop LoopModel LoopStepper STARTS Scaling UNSCALED",
    "dehyst.families.best": "identify",
    "dehyst.families.blocks": "block",
    "dehyst.families.comparison": "Comparison all_names compare",
    "dehyst.families.fitting": "FamilyFit identify_family",
    "dehyst.families.registry": "Family MODULES ROWS example family names",
    "dehyst.families.training": "Stretch Training",
}
_HOME = {name: room for room, names in _ROOMS.items() for name in names.split()}

__all__ = [*sorted(_HOME)]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'dehyst.families' has no attribute '{name}'")
    value = getattr(import_module(_HOME[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted([*globals(), *_HOME])
