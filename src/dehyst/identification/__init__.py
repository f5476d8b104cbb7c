"""Identification: data -> model, with what the data can and cannot tell."""

from dehyst.identification.fit import Candidate, Certificate, Fit, LoopFacts, Score
from dehyst.identification.procedure import identify, identify_paper

__all__ = ["Candidate", "Certificate", "Fit", "LoopFacts", "Score", "identify", "identify_paper"]
