"""MDF (.mf4, .mdf, .dat), by asammdf: the extra ``dehyst[mdf]``.

All channels of numbers become columns; each group has its own clock, ``time`` or ``time_group_2``.
"""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from dehyst.io.collect import Collector
from dehyst.io.foreign import refuse_bomb

SYNC_TIME = 1
TIMES = (0, SYNC_TIME)  # what a master counts; version 3 knows nothing but time
ALL_INVALID = 1  # flag of a channel


def fill(found: Collector, data: bytes, path: Path) -> None:
    """Add every group of channels."""
    import asammdf

    with asammdf.MDF(io.BytesIO(data)) as file:
        # asammdf reserves what the headers claim before it reads.
        headers = [group.channel_group for group in file.groups]
        claimed = sum(
            int(h.cycles_nr) * (int(h.samples_byte_nr) + int(getattr(h, "invalidation_bytes_nr", 0))) for h in headers
        )
        refuse_bomb(claimed, len(data), found.name)
        for number in range(len(file.groups)):
            _add_group(found, file, number)


def _add_group(found: Collector, file: Any, number: int) -> None:
    channels = file.groups[number].channels
    master = file.masters_db.get(number)
    # A group may count degrees, metres or samples instead of time: its master is then a channel like others.
    by_time = master is not None and getattr(channels[master], "sync_type", SYNC_TIME) in TIMES
    label = "time" if len(file.groups) == 1 else f"time_group_{number + 1}"
    clock = ""
    for index, channel in enumerate(channels):
        if index == master and by_time:
            continue
        # Left to itself, asammdf drops invalid samples of each channel, which then no longer belong to one clock.
        signal = file.get(group=number, index=index, ignore_invalidation_bits=True)
        names = _add_samples(found, channel.name, signal.samples, signal.unit or "", _invalid(channel, signal))
        sizes = {name: found.columns[name].size for name in names if name in found.columns}
        fitting = [name for name, size in sizes.items() if size == signal.timestamps.size]
        if fitting and by_time and not clock:
            clock = next(iter(found.add(label, signal.timestamps, "s")), "")
        found.clocks.update({name: clock for name in fitting if clock})


def _invalid(channel: Any, signal: Any) -> npt.NDArray[np.bool_]:
    """Samples that the file calls invalid."""
    invalid = np.zeros(len(signal.samples), dtype=bool)
    if signal.invalidation_bits is not None:
        invalid |= np.asarray(signal.invalidation_bits, dtype=bool)
    if getattr(channel, "flags", 0) & ALL_INVALID:
        invalid[:] = True
    return invalid


def _add_samples(
    found: Collector, path: str, samples: npt.NDArray[Any], unit: str, invalid: npt.NDArray[np.bool_]
) -> list[str]:
    """Add samples, those that are invalid as missing; return the columns that they became."""
    if samples.dtype.names:
        fields = [_add_samples(found, f"{path}.{name}", samples[name], "", invalid) for name in samples.dtype.names]
        return [name for names in fields for name in names]
    if invalid.any():
        if samples.dtype.kind in "fiub":
            samples = samples.astype(np.float64)
            samples[invalid] = np.nan
        elif samples.dtype.kind in "US":
            samples = samples.copy()
            samples[invalid] = ""
    return found.add(path, samples, unit)
