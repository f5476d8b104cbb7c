"""ROS bags (.bag, rosbag2 folders, .db3, .mcap), whole or in chunks, by rosbags: the extra ``dehyst[ros]``."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from dehyst.errors import LogError
from dehyst.io.collect import MAX_WIDTH, Collector
from dehyst.io.foreign import guard, optional
from dehyst.io.streams import Piece, Source
from dehyst.io.table import Table
from dehyst.shell import visible

MAX_DEPTH = 5
BULKY = ("Image", "PointCloud", "CameraInfo", "OccupancyGrid", "Log", "ParameterEvent", "Parameter")


def read_bag(path: Path, sha256: str) -> Table:
    """Read all numbers of all topics: ``/joint_states.position[0]``, one clock for each topic.

    The clock of a topic is ``header.stamp`` where it is set, else the time at which the bag received it.
    """
    highlevel = optional("rosbags.highlevel", "ros", path.name)
    typesys = optional("rosbags.typesys", "ros", path.name)
    found = Collector(path.name)
    size = sum(part.stat().st_size for part in path.iterdir()) if path.is_dir() else path.stat().st_size
    guard(path.name, "ROS bag", size, lambda: _fill(found, highlevel, typesys, path))
    return found.table(sha256)


def _fill(found: Collector, highlevel: Any, typesys: Any, path: Path) -> None:
    store = typesys.get_typestore(typesys.Stores.LATEST)
    rows: dict[str, list[dict[str, float]]] = defaultdict(list)
    with highlevel.AnyReader([path], default_typestore=store) as reader:
        wanted = [c for c in reader.connections if not bulky(c)]
        for connection, received, raw in reader.messages(connections=wanted) if wanted else ():
            row: dict[str, float] = {"bag_time": float(received)}
            flatten(row, "", reader.deserialize(raw, connection.msgtype), 0)
            rows[visible(connection.topic)].append(row)
    for topic, messages in rows.items():
        add_topic(found, topic, messages)


def bulky(connection: Any) -> bool:
    """Whether the messages of a connection hold pictures, texts or settings instead of signals."""
    return any(word in connection.msgtype for word in BULKY)


def flatten(row: dict[str, float], path: str, value: Any, depth: int) -> None:
    """Numbers of a message by path; text and long arrays are passed over."""
    if isinstance(value, (bool, int, float, np.number, np.bool_)):
        row[path] = float(value)
    elif isinstance(value, (np.ndarray, list, tuple)):
        if depth <= MAX_DEPTH and len(value) <= MAX_WIDTH:
            for k, item in enumerate(value):
                flatten(row, f"{path}[{k}]", item, depth + 1)
    elif hasattr(value, "__dataclass_fields__") and depth <= MAX_DEPTH:
        fields = [name for name in value.__dataclass_fields__ if name != "__msgtype__"]
        if set(fields) == {"sec", "nanosec"}:
            # Nanoseconds since 1970 as one float keep 256 ns: far below any sampling of a bag.
            row[path] = float(value.sec * 1_000_000_000 + value.nanosec)
            return
        for name in fields:
            flatten(row, f"{path}.{name}" if path else name, getattr(value, name), depth + 1)


def add_topic(found: Collector, topic: str, messages: list[dict[str, float]]) -> None:
    """Columns and clock of a topic from the numbers of its messages."""
    names = list(dict.fromkeys(name for message in messages for name in message))
    columns = {name: np.array([message.get(name, np.nan) for message in messages]) for name in names}
    stamp = columns.get("header.stamp")
    trusted = stamp is not None and stamp.size > 1 and bool(np.all(stamp > 0) and np.mean(np.diff(stamp) > 0) > 0.5)
    clock = f"{topic}.{'header.stamp' if trusted else 'bag_time'}"
    for name, values in columns.items():
        unit = "ns" if name in {"bag_time", "header.stamp"} else ""
        found.add(f"{topic}.{name}", values, unit)
    found.clocks.update({f"{topic}.{name}": clock for name in columns})


HEAD_MESSAGES = 20_000  # by which topics, fields and clocks are found


class BagSource(Source):
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
