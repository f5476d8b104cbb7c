"""ROS bags (.bag, rosbag2 folders, .db3, .mcap), whole or in parts, by rosbags: the extra ``dehyst[ros]``.

All numbers of all topics become columns, as ``/joint_states.position[0]``, with one clock for each topic:
``header.stamp`` where it is set, else the time at which the bag received the message.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from itertools import chain, islice
from pathlib import Path
from typing import Any

import numpy as np

from dehyst.arrays import Array
from dehyst.io._collect import MAX_WIDTH, Collector, FilePiece, NotInPartsError, Source
from dehyst.shell import visible

MAX_DEPTH = 5
BULKY = ("Image", "PointCloud", "CameraInfo", "OccupancyGrid", "Log", "ParameterEvent", "Parameter")
# Messages by which topics, fields and clocks of a bag that is read in parts are found.
HEAD_MESSAGES = 20_000
BATCH = 1000  # messages that are read under one time limit

# Topic, numbers by path, share of the messages read so far.
Message = tuple[str, dict[str, float], float]


class Nanoseconds(float):
    """A time or a duration of a message."""


def fill(collector: Collector, data: bytes, path: Path) -> None:
    """Add every topic of a bag."""
    _add_topics(collector, _messages(path, None))


def _messages(path: Path, topic: str | None) -> Iterator[Message]:
    """Messages of one topic, or of all; pictures, texts and settings are passed over."""
    from rosbags.highlevel import AnyReader
    from rosbags.typesys import Stores, get_typestore

    with AnyReader([path], default_typestore=get_typestore(Stores.LATEST)) as reader:
        connections = []
        total = 0
        for connection in reader.connections:
            bulky = any(word in connection.msgtype for word in BULKY)
            if not bulky and topic in (None, visible(connection.topic)):
                connections.append(connection)
                total += connection.msgcount
        if not connections:
            return  # no connection would mean all of them
        messages = reader.messages(connections=connections)
        for k, (connection, received, raw) in enumerate(messages, 1):
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
            below = f"{path}.{name}".lstrip(".")
            _flatten(row, below, getattr(value, name), depth + 1)


def _add_topics(collector: Collector, messages: Iterable[Message]) -> list[str]:
    """Add the columns and the clock of each topic; return the topics."""
    topics: dict[str, list[dict[str, float]]] = defaultdict(list)
    for topic, row, _ in messages:
        topics[topic].append(row)
    for topic, rows in topics.items():
        first_values: dict[str, float] = {}
        for row in reversed(rows):
            first_values.update(row)
        # Columns stand in the order in which the messages bring them.
        names = dict.fromkeys(chain.from_iterable(rows))
        clock = f"{topic}.bag_time"
        for name in names:
            values = np.array([row.get(name, np.nan) for row in rows])
            unit = "ns" if isinstance(first_values[name], Nanoseconds) else ""
            collector.add(f"{topic}.{name}", values, unit)
            if name == "header.stamp" and _is_set(values):
                clock = f"{topic}.header.stamp"
        for name in names:
            collector.clocks[f"{topic}.{name}"] = clock
    return list(topics)


def _is_set(stamp: Array) -> bool:
    """Whether whoever sent the messages stamped them: the stamps are above zero, and most of them step forward."""
    return stamp.size > 1 and bool(np.all(stamp > 0) and np.mean(np.diff(stamp) > 0) > 0.5)


class RosParts(Source):
    """A .bag, .db3 or .mcap file."""

    def collect(self, collector: Collector) -> None:
        """Gather the first messages."""
        self._topics = _add_topics(collector, islice(_messages(self.path, None), HEAD_MESSAGES))

    def pieces(self, names: Sequence[str], rows: int) -> Iterator[FilePiece]:
        """All messages of the one topic that the columns belong to, at most `rows` at a time."""
        topics: set[str] = set()
        for name in names:
            # Of topics that begin alike the longest is meant.
            matching = [topic for topic in self._topics if name.startswith(topic + ".")]
            topics.add(max(matching, key=len))
        if len(topics) > 1:
            raise NotInPartsError(
                f"{self.path.name} is too long to be read at once, and {', '.join(names)} belong to the topics "
                f"{', '.join(sorted(topics))}, whose clocks are not merged in parts. Record both signals in one topic, "
                f"or split the bag.",
                columns=tuple(names),
            )
        topic = topics.pop()
        fields = [name[len(topic) + 1 :] for name in names]
        batch: list[list[float]] = []
        first, share = 1, 0.0
        for _, row, share in self._guarded(_messages(self.path, topic)):
            batch.append([row.get(field, np.nan) for field in fields])
            if len(batch) == rows:
                yield self._piece(batch, first, share)
                first, batch = first + rows, []
        if batch:
            yield self._piece(batch, first, share)

    def _guarded(self, messages: Iterator[Message]) -> Iterator[Message]:
        while True:
            batch = self._guard(lambda: list(islice(messages, BATCH)))
            if not batch:
                return
            yield from batch

    def _piece(self, batch: list[list[float]], first: int, share: float) -> FilePiece:
        columns = np.ascontiguousarray(np.array(batch, dtype=np.float64).T)
        number = np.arange(first, first + len(batch), dtype=np.int64)
        return FilePiece(list(columns), number, int(share * self.size))
