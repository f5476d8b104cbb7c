"""TDMS of LabVIEW, by npTDMS: the extra ``dehyst[tdms]``.

Channels become columns ``group.channel``; a waveform's own start and increment become its clock.
"""

from __future__ import annotations

import io
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from dehyst.findings import Finding
from dehyst.io._collect import Collector
from dehyst.units import TABLE, canonical

# Scales of DAQmx that npTDMS applies; a channel with another one it gives as stored, without a word.
SCALES = {
    "Linear",
    "Polynomial",
    "RTD",
    "Strain",
    "Table",
    "Thermistor",
    "Thermocouple",
    "Add",
    "Subtract",
}
SCALE_TYPE = re.compile(r"NI_Scale\[\d+\]_Scale_Type")


def fill(collector: Collector, data: bytes, path: Path) -> None:
    """Add every channel of every group."""
    import nptdms

    file = nptdms.TdmsFile.read(io.BytesIO(data))
    groups = file.groups()
    channels: list[tuple[Any, Any]] = []
    starts: list[float] = []
    for group in groups:
        for channel in group.channels():
            channels.append((group, channel))
            start = _start(channel)
            if start is not None:
                starts.append(start)
    # Channels of one waveform clock share a column.
    clocks: dict[tuple[float, float, int], str] = {}
    for group, channel in channels:
        name = channel.name if len(groups) == 1 else f"{group.name}.{channel.name}"
        unit = (
            channel.properties.get("unit_string")
            or channel.properties.get("NI_UnitDescription")
            or ""
        )
        names = collector.add(name, channel[:], str(unit))
        _note_scale(collector, name, {**file.properties, **group.properties, **channel.properties})
        # Of a spectrum the unit is hertz, which is none of time.
        counted = canonical(str(channel.properties.get("wf_xunit_string") or "s")) or ""
        second = TABLE["time"].get(counted, 0.0)
        step = second * float(channel.properties.get("wf_increment", 0.0))
        if not names or step <= 0:
            continue
        offset = second * float(channel.properties.get("wf_start_offset", 0.0))
        start = _start(channel)
        # Less than a step is when each channel of one task was set up.
        if start is not None and start - min(starts) >= step:
            offset += start - min(starts)
        key = (offset, step, len(channel))
        if key not in clocks:
            label = "time" if not clocks else f"time_{len(clocks) + 1}"
            clocks[key] = collector.add(label, offset + step * np.arange(len(channel)), "s")[0]
        collector.clocks.update(dict.fromkeys(names, clocks[key]))


def _start(channel: Any) -> float | None:
    """When a waveform began, in seconds; None if its channel does not say."""
    start = channel.properties.get("wf_start_time")
    if not isinstance(start, np.datetime64) or np.isnat(start):
        return None
    return float(start.astype("datetime64[us]").astype(np.int64)) / 1e6


def _note_scale(collector: Collector, name: str, properties: Mapping[str, Any]) -> None:
    """Say so where numbers are counts whose scale is not known."""
    kinds = {str(value) for key, value in properties.items() if SCALE_TYPE.fullmatch(key)}
    if kinds <= SCALES or properties.get("NI_Scaling_Status") == "scaled":
        return
    collector.findings.append(
        Finding(
            "attributes-left",
            f"'{name}' of {collector.name} is stored with the scale {', '.join(sorted(kinds - SCALES))}, which is not "
            f"known here: its numbers are as stored. Export them scaled from LabVIEW, if they are counts.",
        )
    )
