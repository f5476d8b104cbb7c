"""Identification of logs that are larger than memory."""

from dehyst.identification.stream.procedure import identify_stream
from dehyst.identification.stream.source import Source
from dehyst.identification.stream.watch import Progress

__all__ = ["Progress", "Source", "identify_stream"]
