"""TDMS of LabVIEW, by npTDMS: the extra ``dehyst[tdms]``.

Channels become columns ``group.channel``; a waveform's own start and increment become its clock.
"""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np

from dehyst.io.collect import Collector


def fill(found: Collector, data: bytes, path: Path) -> None:
    """Add every channel of every group."""
    import nptdms

    groups = nptdms.TdmsFile.read(io.BytesIO(data)).groups()
    clocks: dict[tuple[float, float, int], str] = {}  # channels of one waveform clock share a column
    for group in groups:
        for channel in group.channels():
            name = channel.name if len(groups) == 1 else f"{group.name}.{channel.name}"
            names = found.add(name, channel[:], str(channel.properties.get("unit_string", "")))
            step = float(channel.properties.get("wf_increment", 0.0))
            if not names or step <= 0:
                continue
            offset = float(channel.properties.get("wf_start_offset", 0.0))
            key = (offset, step, len(channel))
            if key not in clocks:
                label = "time" if not clocks else f"time_{len(clocks) + 1}"
                clocks[key] = found.add(label, offset + step * np.arange(len(channel)), "s")[0]
            found.clocks.update(dict.fromkeys(names, clocks[key]))
