"""Identification of the direct inverse: the compensator itself, from the measured output to the input it needs."""

from dehyst.identification.direct.procedure import identify_direct

__all__ = ["identify_direct"]
