"""Hysteresis models: immutable parameters and formulas."""

from dehyst.models.base import HysteresisModel, RejectedSamplesWarning, StackStepper, Stepper
from dehyst.models.block import BLOCK_FLAGS, Block
from dehyst.models.card import ModelCard, SignalCard
from dehyst.models.direct import GROUPS, DirectDemand, DirectInverse, DirectRun, Schedule
from dehyst.models.machine import BlockParameters
from dehyst.models.model import Band, Model
from dehyst.models.monotone import ModifiedPrandtlIshlinskii, MonotoneMap, StaticCurve
from dehyst.models.prandtl_ishlinskii import PrandtlIshlinskii, StopOperatorModel
from dehyst.models.sheared import ShearedPrandtlIshlinskii, subtracted_shear
from dehyst.models.storage import load, model_from_dict, model_to_dict

__all__ = [
    "BLOCK_FLAGS",
    "GROUPS",
    "Band",
    "Block",
    "BlockParameters",
    "DirectDemand",
    "DirectInverse",
    "DirectRun",
    "HysteresisModel",
    "Model",
    "ModelCard",
    "ModifiedPrandtlIshlinskii",
    "MonotoneMap",
    "PrandtlIshlinskii",
    "RejectedSamplesWarning",
    "Schedule",
    "ShearedPrandtlIshlinskii",
    "SignalCard",
    "StackStepper",
    "StaticCurve",
    "Stepper",
    "StopOperatorModel",
    "load",
    "model_from_dict",
    "model_to_dict",
    "subtracted_shear",
]
