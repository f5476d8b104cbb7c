"""ROS bags (.bag, rosbag2 folders, .db3, .mcap), whole or in chunks, by rosbags: the extra ``dehyst[ros]``.

All numbers of all topics become columns, as ``/joint_states.position[0]``, with one clock for each topic:
``header.stamp`` where it is set, else the time at which the bag received the message.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from dehyst.errors import LogError
from dehyst.io.collect import MAX_WIDTH, Collector, Piece, Source
from dehyst.shell import visible

MAX_DEPTH = 5
BULKY = ("Image", "PointCloud", "CameraInfo", "OccupancyGrid", "Log", "ParameterEvent", "Parameter")
HEAD_MESSAGES = 20_000  # by which topics, fields and clocks of a bag in chunks are found
BATCH = 1000  # messages that are read under one time limit

Message = tuple[str, dict[str, float], float]  # topic, numbers by path, share of the messages read so far


class Nanoseconds(float):
    """A time or a duration of a message."""


def fill(found: Collector, data: bytes, path: Path) -> None:
    """Add every topic of a bag."""
    _add_topics(found, _messages(path, None))


def _messages(path: Path, topic: str | None) -> Iterator[Message]:
    """Messages of one topic, or of all; pictures, texts and settings are passed over."""
    from rosbags.highlevel import AnyReader
    from rosbags.typesys import Stores, get_typestore

    with AnyReader([path], default_typestore=get_typestore(Stores.LATEST)) as reader:
        wanted = [
            c
            for c in reader.connections
            if not any(word in c.msgtype for word in BULKY) and topic in (None, visible(c.topic))
        ]
        total = max(1, sum(c.msgcount for c in wanted))
        for k, (connection, received, raw) in enumerate(reader.messages(connections=wanted) if wanted else (), 1):
            row: dict[str, float] = {"bag_time": Nanoseconds(received)}
            _flatten(row, "", reader.deserialize(raw, connection.msgtype), 0)
            yield visible(connection.topic), row, k / total


def _flatten(row: dict[str, float], path: str, value: Any, depth: int) -> None:
    """Numbers of a message by path; text and long arrays are passed over."""
    if isinstance(value, (bool, int, float, np.number, np.bool_)):
        row[path] = float(value)
    elif isinstance(value, (np.ndarray, list, tuple)):
        if depth <= MAX_DEPTH and len(value) <= MAX_WIDTH:
            for k, item in enumerate(value):
                _flatten(row, f"{path}[{k}]", item, depth + 1)
    elif hasattr(value, "__dataclass_fields__") and depth <= MAX_DEPTH:
        fields = [name for name in value.__dataclass_fields__ if name != "__msgtype__"]
        if set(fields) == {"sec", "nanosec"}:
            # Nanoseconds since 1970 as one float keep 256 ns: far below any sampling of a bag.
            row[path] = Nanoseconds(value.sec * 1_000_000_000 + value.nanosec)
            return
        for name in fields:
            _flatten(row, f"{path}.{name}" if path else name, getattr(value, name), depth + 1)


def _add_topics(found: Collector, messages: Iterable[Message]) -> list[str]:
    """Add the columns and the clock of each topic; return the topics."""
    topics: dict[str, list[dict[str, float]]] = defaultdict(list)
    for topic, row, _ in messages:
        topics[topic].append(row)
    for topic, rows in topics.items():
        names = list(dict.fromkeys(name for row in rows for name in row))
        columns = {name: np.array([row.get(name, np.nan) for row in rows]) for name in names}
        stamp = columns.get("header.stamp")
        trusted = stamp is not None and stamp.size > 1 and bool(np.all(stamp > 0) and np.mean(np.diff(stamp) > 0) > 0.5)
        for name, values in columns.items():
            first = next(row[name] for row in rows if name in row)
            found.add(f"{topic}.{name}", values, "ns" if isinstance(first, Nanoseconds) else "")
        clock = f"{topic}.{'header.stamp' if trusted else 'bag_time'}"
        found.clocks.update({f"{topic}.{name}": clock for name in columns})
    return list(topics)


class Chunks(Source):
    """A .bag, .db3 or .mcap file."""

    def collect(self, found: Collector) -> None:
        """Gather the first messages."""
        self._topics = _add_topics(found, islice(_messages(self.path, None), HEAD_MESSAGES))

    def pieces(self, names: Sequence[str], rows: int) -> Iterator[Piece]:
        """All messages of the one topic that the columns belong to, at most `rows` at a time."""
        topics = {max((topic for topic in self._topics if name.startswith(topic + ".")), key=len) for name in names}
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
        for _, row, share in self._guarded(_messages(self.path, topic)):
            taken.append([row.get(field, np.nan) for field in fields])
            if len(taken) == rows:
                yield self._piece(taken, first, share)
                first, taken = first + rows, []
        if taken:
            yield self._piece(taken, first, share)

    def _guarded(self, messages: Iterator[Message]) -> Iterator[Message]:
        while True:
            batch: list[Message] = []
            self._guard(lambda into=batch: into.extend(islice(messages, BATCH)))  # type: ignore[misc]
            if not batch:
                return
            yield from batch

    def _piece(self, taken: list[list[float]], first: int, share: float) -> Piece:
        columns: Any = np.array(taken, dtype=np.float64).T
        number = np.arange(first, first + len(taken), dtype=np.int64)
        return Piece([np.ascontiguousarray(column) for column in columns], number, int(share * self.size))
