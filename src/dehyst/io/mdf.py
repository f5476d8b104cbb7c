"""MDF (.mf4, .mdf, .dat), by asammdf: the extra ``dehyst[mdf]``."""

from __future__ import annotations

import io

from dehyst.io.collect import Collector
from dehyst.io.foreign import foreign_reader, optional
from dehyst.io.table import Table


def read_mdf(data: bytes, name: str, sha256: str) -> Table:
    """Read all channels of numbers; each group has its own clock, ``time`` or ``time_group_2``.

    Raises
    ------
    LogError
        If it is damaged or holds no numbers.
    MissingExtraError
        If asammdf is not installed.
    """
    asammdf = optional("asammdf", "mdf", name)
    found = Collector(name)
    with foreign_reader(name, "MDF file"), asammdf.MDF(io.BytesIO(data)) as file:
        for number, group in enumerate(file.groups):
            master = file.masters_db.get(number)
            clock = ""
            for index, channel in enumerate(group.channels):
                if index == master:
                    continue
                signal = file.get(group=number, index=index)
                names = found.add(channel.name, signal.samples, signal.unit or "")
                if names and not clock and signal.timestamps.size == found.columns[names[0]].size:
                    label = "time" if len(file.groups) == 1 else f"time_group_{number + 1}"
                    clock = next(iter(found.add(label, signal.timestamps, "s")), "")
                found.clocks.update({column: clock for column in names if clock})
    return found.table(sha256)
