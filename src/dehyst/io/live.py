"""Samples as they come: lines that are added to a text log, messages of an MQTT broker, values of an OPC UA server.

Each source is a generator of arrays (time, input, output), of `Skipped` where a number is missing, and of None now and
then while nothing comes, so that its reader can do other work. A source outlives the other side: it waits and connects
again.
"""

from __future__ import annotations

import asyncio
import json
import math
import os
import queue
import sys
import threading
import time as clock
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import numpy as np

from dehyst.arrays import Array
from dehyst.errors import ColumnError, LogError, ParameterError
from dehyst.io.cells import comma_number, number
from dehyst.io.clocks import clock_names
from dehyst.io.columns import find_column
from dehyst.io.delimited import read_delimited
from dehyst.io.foreign import optional
from dehyst.io.layout import find_layout, is_comment, split_line
from dehyst.io.text import decode

Batch = tuple[Array, Array, Array]
PAUSE = 0.2  # seconds between two looks
HEAD = 1 << 16  # bytes by which columns are found
PASSWORD = "DEHYST_PASSWORD"  # variable of the environment: a command line can be read by others


@dataclass(frozen=True)
class Skipped:
    """Lines, messages or values that hold no numbers, and the last of them."""

    count: int
    last: str


Arrival = Batch | Skipped | None


@dataclass(frozen=True)
class Names:
    """What the signals are called at the source; `time` is None where the source tells or arrival counts."""

    input: str
    output: str
    time: str | None = None


def _batch(rows: Sequence[tuple[float, float, float]]) -> Batch:
    table = np.array(rows, dtype=np.float64).reshape(-1, 3)
    return table[:, 0], table[:, 1], table[:, 2]


def _arrivals(rows: Sequence[tuple[float, float, float]], skipped: Sequence[str]) -> Iterator[Arrival]:
    """What is yielded of a piece."""
    if skipped:
        yield Skipped(len(skipped), skipped[-1])
    if rows:
        yield _batch(rows)


def follow(path: Path, names: Names) -> Iterator[Arrival]:
    """Lines of a text log, those that are there and those that are added; a file that begins anew is read anew."""
    while not path.exists() or path.stat().st_size == 0:
        yield None
        clock.sleep(PAUSE)
    stream, rest, places, count = path.open("rb"), b"", None, 0
    while True:
        data = stream.read(1 << 20)
        if not data:
            yield None
            clock.sleep(PAUSE)
            there = path.stat() if path.exists() else None
            here = os.fstat(stream.fileno())
            if there and (there.st_ino != here.st_ino or there.st_size < stream.tell()):
                stream.close()
                stream, rest, places = path.open("rb"), b"", None
            continue
        rest += data
        if places is None:
            try:
                places = _places(rest[:HEAD], path.name, names)
            except LogError:
                if len(rest) > HEAD:
                    raise
                continue  # the header is not whole yet
            lines = rest.split(b"\n")[places.first :]
        else:
            lines = rest.split(b"\n")
        rest = lines.pop()  # until its end comes
        rows, skipped = [], []
        for line in lines:
            text = line.decode("utf-8", "replace").rstrip("\r")
            if not text.strip() or is_comment(text):
                continue
            row = places.row(text, count)
            if row is None:
                skipped.append(text)
            else:
                rows.append(row)
            count += 1
        yield from _arrivals(rows, skipped)


@dataclass(frozen=True)
class _Places:
    """Where the signals stand in a line."""

    delimiter: str
    number: Callable[[str], float | None]
    columns: tuple[int, int, int]  # time (-1: the number of the line), input, output
    first: int  # line of data

    def row(self, text: str, count: int) -> tuple[float, float, float] | None:
        """Return the numbers of a line, None of one that lacks one of them."""
        cells = split_line(text, self.delimiter)
        values = [float(count) if k < 0 else self.number(cells[k]) if k < len(cells) else None for k in self.columns]
        time, x, y = (math.nan if value is None else value for value in values)
        return (time, x, y) if math.isfinite(time + x + y) else None


def _places(head: bytes, name: str, names: Names) -> _Places:
    whole = head[: head.rfind(b"\n") + 1]
    table = read_delimited(whole, name)
    layout = find_layout(decode(whole, name).splitlines(), name)
    found = [find_column(table, wanted, role) for wanted, role in ((names.input, "input"), (names.output, "output"))]
    clocks = [find_column(table, names.time, "time")] if names.time else clock_names(table)[:1]
    places = [table.order.index(column) for column in (*clocks, *found)]
    columns = places if clocks else [-1, *places]
    told = comma_number if layout.decimal_comma else number
    return _Places(layout.delimiter, told, (columns[0], columns[1], columns[2]), layout.first)


def mqtt(
    url: str, names: Names, *, ca: Path | None = None, client: str = "dehyst"
) -> tuple[Iterator[Arrival], Callable[[str], None]]:
    """Messages of a topic, and what publishes to TOPIC/alarm.

    A message is a JSON object with the signals' names, each a number or a list of them, or a list of such objects;
    ``time`` in seconds, else that of arrival. The session is kept by the broker under the client's name: what is
    published with QoS 1 while this side is away comes later. Passwords: the variable DEHYST_PASSWORD.

    Parameters
    ----------
    url
        ``mqtt://[user@]host[:port]/topic``, or ``mqtts://`` with TLS.
    names
        Keys of the message.
    ca
        Certificate of the authority that signed the broker's, for TLS; None: those of the system.
    client
        Name of the session.

    Raises
    ------
    ParameterError
        If the URL names no host or topic.
    """
    paho = optional("paho.mqtt.client", "watch", url, "listening to", "follow a file: --follow FILE")
    parts = urlsplit(url)
    topic = parts.path.lstrip("/")
    if parts.scheme not in ("mqtt", "mqtts") or not parts.hostname or not topic:
        raise ParameterError(
            f"{url!r:.80} names no broker and topic. Type mqtt://HOST/TOPIC, or mqtts://USER@HOST:8883/TOPIC with TLS.",
            url=url,
        )
    inbox: queue.Queue[tuple[float, bytes, bool]] = queue.Queue()
    link = paho.Client(paho.CallbackAPIVersion.VERSION2, client_id=client, clean_session=False)
    link.on_connect = lambda c, *_: c.subscribe(topic, qos=1)
    link.on_message = lambda c, data, message: inbox.put((clock.time(), message.payload, message.dup))
    link.reconnect_delay_set(1, 30)
    if parts.username:
        link.username_pw_set(parts.username, os.environ.get(PASSWORD))
    if parts.scheme == "mqtts":
        link.tls_set(ca_certs=None if ca is None else str(ca))
    link.connect_async(parts.hostname, parts.port or (8883 if parts.scheme == "mqtts" else 1883))
    link.loop_start()

    def samples() -> Iterator[Arrival]:
        last = -np.inf
        try:
            while True:
                try:
                    arrived, payload, again = inbox.get(timeout=PAUSE)
                except queue.Empty:
                    yield None
                    continue
                rows, skipped = _rows_of(payload, names, arrived)
                rows = [row for row in rows if row[0] > last] if again else rows  # QoS 1 may deliver twice
                last = rows[-1][0] if rows else last
                yield from _arrivals(rows, skipped)
        finally:
            link.disconnect()
            link.loop_stop()

    def publish(text: str) -> None:
        link.publish(f"{topic}/alarm", text, qos=1, retain=True)

    return samples(), publish


def _is_number(value: object) -> bool:
    """Whether a value of a message is a finite number of double precision, whoever sent it."""
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= sys.float_info.max


def _rows_of(payload: bytes, names: Names, arrived: float) -> tuple[list[tuple[float, float, float]], list[str]]:
    """Samples of a message, whoever sent it, and what of it holds none."""
    try:
        told = json.loads(payload)
    except ValueError:
        return [], [payload.decode("utf-8", "replace")]
    rows: list[tuple[float, float, float]] = []
    skipped = []
    for one in told if isinstance(told, list) else [told]:
        keys = one if isinstance(one, dict) else {}
        values = (keys.get(names.time or "time", arrived), keys.get(names.input), keys.get(names.output))
        lists = [value if isinstance(value, list) else [value] for value in values]
        # Lists of other lengths do not tell which time belongs to which sample.
        samples = list(zip(*lists, strict=True)) if len({*map(len, lists)}) == 1 else [(None,)]
        whole = [row for row in samples if all(map(_is_number, row))]
        rows += [(float(t), float(x), float(y)) for t, x, y in whole]
        if len(whole) < len(samples):
            skipped.append(json.dumps(one))
    return rows, skipped


def opcua(endpoint: str, names: Names, *, period: float = 0.01, security: str = "") -> Iterator[Arrival]:
    """Changes of two nodes by subscription, at the server's own time stamps; the input is held between its changes.

    Parameters
    ----------
    endpoint
        ``opc.tcp://[user@]host:port/path``; the password is the variable DEHYST_PASSWORD.
    names
        Node ids of input and output, ``ns=2;s=Pressure``.
    period
        Sampling interval asked of the server. [s]
    security
        ``Policy,Mode,certificate,key[,server certificate]`` as asyncua takes it, ``Basic256Sha256,SignAndEncrypt,...``.
    """
    asyncua = optional("asyncua", "watch", endpoint, "listening to", "follow a file: --follow FILE")
    inbox: queue.Queue[Any] = queue.Queue()
    stop = threading.Event()

    class Handler:
        """Takes notifications of changes."""

        def datachange_notification(self, node: Any, value: Any, data: Any) -> None:
            told = data.monitored_item.Value
            stamp = told.SourceTimestamp or told.ServerTimestamp
            inbox.put((node.nodeid.to_string(), clock.time() if stamp is None else stamp.timestamp(), value))

    async def listen() -> None:
        while not stop.is_set():
            try:
                await session()
            except (TimeoutError, OSError, asyncua.ua.UaError, ConnectionError):
                await asyncio.sleep(1.0)  # the server is away: it is asked again
            except Exception as fault:
                inbox.put(fault)
                return

    async def session() -> None:
        parts = urlsplit(endpoint)
        link = asyncua.Client(endpoint.replace(f"{parts.username}@", "") if parts.username else endpoint)
        if security:
            await link.set_security_string(security)
        if parts.username:
            link.set_user(parts.username)
            link.set_password(os.environ.get(PASSWORD, ""))
        async with link:
            subscription = await link.create_subscription(1000 * max(period, 0.05), Handler())
            nodes = [link.get_node(name) for name in (names.input, names.output)]
            await subscription.subscribe_data_change(nodes, queuesize=1000, sampling_interval=1000 * period)
            while not stop.is_set():
                await asyncio.sleep(PAUSE)
                await link.check_connection()

    thread = threading.Thread(target=lambda: asyncio.run(listen()), daemon=True)
    thread.start()
    held: float | None = None
    try:
        while True:
            arrived = []
            try:
                arrived.append(inbox.get(timeout=PAUSE))
                while True:
                    arrived.append(inbox.get_nowait())
            except queue.Empty:
                pass
            fault = next((each for each in arrived if isinstance(each, Exception)), None)
            if fault is not None:
                raise ColumnError(f"{endpoint}: {fault!s:.200}. Check node ids, user and security.") from None
            rows, skipped = [], []
            for name, stamp, value in sorted(arrived, key=lambda each: each[1]):
                told = float(value) if _is_number(value) else None
                if told is None:
                    skipped.append(f"{name} = {value!r:.60}")
                if name == names.input:
                    held = told
                elif held is not None and told is not None:
                    rows.append((stamp, held, told))
            yield from _arrivals(rows, skipped)
            if not arrived:
                yield None
    finally:
        stop.set()
        thread.join(timeout=5.0)
