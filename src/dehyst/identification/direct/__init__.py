"""Identification of the direct inverse: the compensator itself, from the measured output to the input it needs."""

from dehyst.identification.direct.fit import DirectCertificate, DirectFit, Rival
from dehyst.identification.direct.procedure import identify_direct

__all__ = ["DirectCertificate", "DirectFit", "Rival", "identify_direct"]
