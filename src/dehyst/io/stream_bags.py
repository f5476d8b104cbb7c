"""ROS bags and MCAP files in chunks, message by message, by rosbags."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from dehyst.errors import LogError
from dehyst.findings import Finding
from dehyst.io.collect import Collector
from dehyst.io.foreign import guard, optional
from dehyst.io.ros import add_topic, bulky, flatten
from dehyst.io.streams import Piece
from dehyst.io.table import Table
from dehyst.visible import visible

HEAD_MESSAGES = 20_000  # by which topics, fields and clocks are found


class BagSource:
    """A .bag, .db3 or .mcap file."""

    costly = True

    def __init__(self, path: Path) -> None:
        self.path, self.size = path, path.stat().st_size
        self.lengths: Mapping[str, int] = {}
        self._highlevel = optional("rosbags.highlevel", "ros", path.name)
        self._typesys = optional("rosbags.typesys", "ros", path.name)
        rows: dict[str, list[dict[str, float]]] = defaultdict(list)
        for topic, row, _ in self._messages(None):
            rows[topic].append(row)
            if sum(map(len, rows.values())) >= HEAD_MESSAGES:
                break
        found = Collector(path.name)
        for topic, messages in rows.items():
            add_topic(found, topic, messages)
        self._topics = list(rows)
        self._table = found.table("")

    def _messages(self, topic: str | None) -> Iterator[tuple[str, dict[str, float], float]]:
        """Topic and numbers of each message, and the share of messages read so far."""
        messages = self._read(topic)
        while True:
            batch: list[tuple[str, dict[str, float], float]] = []

            def fill(into: list[tuple[str, dict[str, float], float]] = batch) -> None:
                for _, message in zip(range(1000), messages, strict=False):
                    into.append(message)

            guard(self.path.name, "ROS bag", self.size, fill)
            if not batch:
                return
            yield from batch

    def _read(self, topic: str | None) -> Iterator[tuple[str, dict[str, float], float]]:
        store = self._typesys.get_typestore(self._typesys.Stores.LATEST)
        with self._highlevel.AnyReader([self.path], default_typestore=store) as reader:
            wanted = [c for c in reader.connections if not bulky(c) and topic in (None, visible(c.topic))]
            total = max(1, sum(c.msgcount for c in wanted))
            found = reader.messages(connections=wanted) if wanted else ()
            for k, (connection, received, raw) in enumerate(found, 1):
                row: dict[str, float] = {"bag_time": float(received)}
                flatten(row, "", reader.deserialize(raw, connection.msgtype), 0)
                yield visible(connection.topic), row, k / total

    def head(self) -> Table:
        """First messages, as the reader of whole files gives them."""
        return self._table

    def findings(self) -> list[Finding]:
        """Nothing: what a message lacks is a cell without a number."""
        return []

    def pieces(self, names: Sequence[str], rows: int) -> Iterator[Piece]:
        """All messages of the one topic that the columns belong to, at most `rows` at a time.

        Raises
        ------
        LogError
            If the columns belong to several topics.
        """
        topics = {self._topic(name) for name in names}
        if len(topics) > 1:
            raise LogError(
                f"the columns {', '.join(names)} of {self.path.name} belong to the topics {', '.join(sorted(topics))}, "
                f"whose clocks cannot be merged in chunks. Read the log at once, with dehyst.read_log, or record both "
                f"signals in one topic.",
                columns=tuple(names),
            )
        topic = topics.pop()
        fields = [name[len(topic) + 1 :] for name in names]
        taken: list[list[float]] = []
        first, share = 1, 0.0
        for _, row, share in self._messages(topic):
            taken.append([row.get(field, np.nan) for field in fields])
            if len(taken) == rows:
                yield self._piece(taken, first, share)
                first, taken = first + rows, []
        if taken:
            yield self._piece(taken, first, share)

    def _topic(self, name: str) -> str:
        return max((topic for topic in self._topics if name.startswith(topic + ".")), key=len)

    def _piece(self, taken: list[list[float]], first: int, share: float) -> Piece:
        columns: Any = np.array(taken, dtype=np.float64).T
        number = np.arange(first, first + len(taken), dtype=np.int64)
        return Piece([np.ascontiguousarray(column) for column in columns], number, int(share * self.size))
