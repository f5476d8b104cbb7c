"""MDF (.mf4, .mdf, .dat), by asammdf: the extra ``dehyst[mdf]``.

All channels of numbers become columns; each group has its own clock, ``time`` or ``time_group_2``.
"""

from __future__ import annotations

import io
import math
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from dehyst.io._collect import HEAD_ROWS, Collector, Column, Source
from dehyst.io._foreign import refuse_bomb

SYNC_TIME = 1
TIMES = (0, SYNC_TIME)  # what a master counts; version 3 knows nothing but time
ALL_INVALID = 1  # flag of a channel


def fill(collector: Collector, data: bytes, path: Path) -> None:
    """Add every group of channels."""
    import asammdf

    with asammdf.MDF(io.BytesIO(data)) as file:
        # asammdf reserves what the headers claim before it reads.
        refuse_bomb(_claimed(file), len(data), collector.name)
        for number in range(len(file.groups)):
            _add_group(collector, file, number)


def _claimed(file: Any) -> int:
    """Bytes of samples by the headers of all groups."""
    claimed = 0
    for group in file.groups:
        header = group.channel_group
        record = int(header.samples_byte_nr) + int(getattr(header, "invalidation_bytes_nr", 0))
        claimed += int(header.cycles_nr) * record
    return claimed


def _add_group(
    collector: Collector, file: Any, number: int, begin: int = 0, rows: int | None = None
) -> None:
    """Add the channels of a group: all of their rows, or so many from one on."""
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
        signal = file.get(
            group=number,
            index=index,
            ignore_invalidation_bits=True,
            record_offset=begin,
            record_count=rows,
        )
        names = _add_samples(
            collector, channel.name, signal.samples, signal.unit or "", _invalid(channel, signal)
        )
        for name in names:
            column = collector.columns.get(name)
            if not by_time or column is None or column.size != signal.timestamps.size:
                continue
            if not clock:
                clock = next(iter(collector.add(label, signal.timestamps, "s")), "")
            if clock:
                collector.clocks[name] = clock


def _invalid(channel: Any, signal: Any) -> npt.NDArray[np.bool_]:
    """Samples that the file calls invalid."""
    invalid = np.zeros(len(signal.samples), dtype=bool)
    if signal.invalidation_bits is not None:
        invalid |= np.asarray(signal.invalidation_bits, dtype=bool)
    if getattr(channel, "flags", 0) & ALL_INVALID:
        invalid[:] = True
    return invalid


def _add_samples(
    collector: Collector,
    path: str,
    samples: npt.NDArray[Any],
    unit: str,
    invalid: npt.NDArray[np.bool_],
) -> list[str]:
    """Add samples, those that are invalid as missing; return the columns that they became."""
    if samples.dtype.names:
        names: list[str] = []
        for name in samples.dtype.names:
            names += _add_samples(collector, f"{path}.{name}", samples[name], "", invalid)
        return names
    if invalid.any():
        if samples.dtype.kind in "fiub":
            samples = samples.astype(np.float64)
            samples[invalid] = np.nan
        elif samples.dtype.kind in "US":
            samples = samples.copy()
            samples[invalid] = ""
    return collector.add(path, samples, unit)


class MdfParts(Source):
    """A .mf4 or .mdf file."""

    def collect(self, collector: Collector) -> None:
        """Gather the first rows of every group."""
        import asammdf

        self._groups: list[list[str]] = []  # columns of each, in their order
        self.lengths: dict[str, int] = {}
        with asammdf.MDF(self.path) as file:
            refuse_bomb(_claimed(file), self.size, collector.name, math.inf)
            groups: list[Any] = file.groups
            for number, group in enumerate(groups):
                before = set(collector.names)
                _add_group(collector, file, number, 0, HEAD_ROWS)
                names = [name for name in collector.names if name not in before]
                self._groups.append(names)
                self.lengths.update(dict.fromkeys(names, int(group.channel_group.cycles_nr)))

    def opened(self, stack: ExitStack, names: Sequence[str]) -> Any:
        """Open the file."""
        import asammdf

        return stack.enter_context(asammdf.MDF(self.path))

    def part(self, file: Any, names: Sequence[str], begin: int, end: int) -> list[Column]:
        """Rows of some columns of one group from one to another."""
        number = next(k for k, group in enumerate(self._groups) if names[0] in group)
        part = Collector(self.path.name)
        _add_group(part, file, number, begin, end - begin)
        values: list[Column] = [*part.columns.values(), *part.labels.values()]
        columns = dict(zip(self._groups[number], values, strict=True))
        return [columns[name] for name in names]
