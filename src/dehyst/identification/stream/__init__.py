"""Identification of logs that are larger than memory."""

from dehyst.identification.stream.procedure import identify_stream
from dehyst.identification.stream.source import Progress, Source

__all__ = ["Progress", "Source", "identify_stream"]
