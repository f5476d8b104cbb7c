"""dehyst: from a logged hysteresis loop to a verified compensator.

The public names and nothing else; each is imported when it is first used, so that ``import dehyst`` and
``dehyst --help`` cost nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from dehyst.errors import DehystError as DehystError
    from dehyst.findings import Finding as Finding
    from dehyst.identification import Fit as Fit
    from dehyst.identification import identify as identify
    from dehyst.identification import identify_paper as identify_paper
    from dehyst.io import inspect_log as inspect_log
    from dehyst.io import read_log as read_log
    from dehyst.io import read_signal as read_signal
    from dehyst.models import HysteresisModel as HysteresisModel
    from dehyst.models import ModifiedPrandtlIshlinskii as ModifiedPrandtlIshlinskii
    from dehyst.models import MonotoneMap as MonotoneMap
    from dehyst.models import PrandtlIshlinskii as PrandtlIshlinskii
    from dehyst.models import StaticCurve as StaticCurve
    from dehyst.models import StopOperatorModel as StopOperatorModel
    from dehyst.models import load_model as load_model
    from dehyst.recording import Recording as Recording
    from dehyst.report import write_report as write_report

__version__ = "0.1.0"

_HOME = {
    "DehystError": "dehyst.errors",
    "Finding": "dehyst.findings",
    "Fit": "dehyst.identification",
    "HysteresisModel": "dehyst.models",
    "ModifiedPrandtlIshlinskii": "dehyst.models",
    "MonotoneMap": "dehyst.models",
    "PrandtlIshlinskii": "dehyst.models",
    "Recording": "dehyst.recording",
    "StaticCurve": "dehyst.models",
    "StopOperatorModel": "dehyst.models",
    "identify": "dehyst.identification",
    "identify_paper": "dehyst.identification",
    "inspect_log": "dehyst.io",
    "load_model": "dehyst.models",
    "read_log": "dehyst.io",
    "read_signal": "dehyst.io",
    "write_report": "dehyst.report",
}

__all__ = [*sorted(_HOME), "__version__"]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'dehyst' has no attribute '{name}'")
    value = getattr(import_module(_HOME[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted([*globals(), *_HOME])
