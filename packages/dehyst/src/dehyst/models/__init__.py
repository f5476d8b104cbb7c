"""Hysteresis models: immutable parameters and formulas."""

from dehyst.lazy import lazy_names

TYPE_CHECKING = False
if TYPE_CHECKING:
    from dehyst._native import StackStepper as StackStepper
    from dehyst._native import Stepper as Stepper
    from dehyst.models._base import HysteresisModel as HysteresisModel
    from dehyst.models._base import RejectedSamplesWarning as RejectedSamplesWarning
    from dehyst.models._block import BLOCK_FLAGS as BLOCK_FLAGS
    from dehyst.models._block import Block as Block
    from dehyst.models._card import ModelCard as ModelCard
    from dehyst.models._card import SignalCard as SignalCard
    from dehyst.models._direct import GROUPS as GROUPS
    from dehyst.models._direct import DirectDemand as DirectDemand
    from dehyst.models._direct import DirectInverse as DirectInverse
    from dehyst.models._direct import DirectRun as DirectRun
    from dehyst.models._direct import Schedule as Schedule
    from dehyst.models._machine import BlockParameters as BlockParameters
    from dehyst.models._model import Band as Band
    from dehyst.models._model import Model as Model
    from dehyst.models._monotone import ModifiedPrandtlIshlinskii as ModifiedPrandtlIshlinskii
    from dehyst.models._monotone import MonotoneMap as MonotoneMap
    from dehyst.models._monotone import StaticCurve as StaticCurve
    from dehyst.models._prandtl_ishlinskii import PrandtlIshlinskii as PrandtlIshlinskii
    from dehyst.models._prandtl_ishlinskii import StopOperatorModel as StopOperatorModel
    from dehyst.models._resonance import Resonance as Resonance
    from dehyst.models._sheared import ShearedPrandtlIshlinskii as ShearedPrandtlIshlinskii
    from dehyst.models._sheared import subtracted_shear as subtracted_shear
    from dehyst.models._storage import load as load
    from dehyst.models._storage import model_to_dict as model_to_dict

__getattr__, __dir__, __all__ = lazy_names(
    "dehyst.models",
    {
        "_base": "HysteresisModel RejectedSamplesWarning",
        "_block": "BLOCK_FLAGS Block",
        "_card": "ModelCard SignalCard",
        "_direct": "DirectDemand DirectInverse DirectRun GROUPS Schedule",
        "_machine": "BlockParameters",
        "_model": "Band Model",
        "_monotone": "ModifiedPrandtlIshlinskii MonotoneMap StaticCurve",
        "_prandtl_ishlinskii": "PrandtlIshlinskii StopOperatorModel",
        "_resonance": "Resonance",
        "_sheared": "ShearedPrandtlIshlinskii subtracted_shear",
        "_storage": "load model_to_dict",
        "dehyst._native": "StackStepper Stepper",
    },
)
