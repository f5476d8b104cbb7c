"""Identification of the direct inverse: the compensator itself, from the measured output to the input it needs."""

from dehyst.identification.direct.procedure import direct_fit, identify_direct

__all__ = ["direct_fit", "identify_direct"]
