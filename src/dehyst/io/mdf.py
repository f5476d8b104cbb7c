"""MDF (.mf4, .mdf, .dat), by asammdf: the extra ``dehyst[mdf]``.

All channels of numbers become columns; each group has its own clock, ``time`` or ``time_group_2``.
"""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

from dehyst.io.collect import Collector
from dehyst.io.foreign import refuse_bomb


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
    master = file.masters_db.get(number)
    label = "time" if len(file.groups) == 1 else f"time_group_{number + 1}"
    clock = ""
    for index, channel in enumerate(file.groups[number].channels):
        if index == master:
            continue
        signal = file.get(group=number, index=index)
        names = found.add(channel.name, signal.samples, signal.unit or "")
        if names and not clock and signal.timestamps.size == found.columns[names[0]].size:
            clock = next(iter(found.add(label, signal.timestamps, "s")), "")
        found.clocks.update({column: clock for column in names if clock})
