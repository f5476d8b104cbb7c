"""Identification of models from logs, with warnings about what the data cannot determine."""

from dehyst.identification.cross_validation import CrossValidation, Trial, cross_validate
from dehyst.identification.direct import identify_direct
from dehyst.identification.evidence import Evidence
from dehyst.identification.fit import Candidate, Certificate, Fit, LoopFacts, Refit, Score
from dehyst.identification.plays import identify
from dehyst.identification.shear import ShearChoice, choose_shear

__all__ = [
    "Candidate",
    "Certificate",
    "CrossValidation",
    "Evidence",
    "Fit",
    "LoopFacts",
    "Refit",
    "Score",
    "ShearChoice",
    "Trial",
    "choose_shear",
    "cross_validate",
    "identify",
    "identify_direct",
]
