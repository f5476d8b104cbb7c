"""Values of an OPC UA server: changes of two nodes by subscription."""

from __future__ import annotations

import asyncio
import math
import os
import queue
import threading
from collections.abc import Iterator, Sequence
from contextlib import suppress
from datetime import UTC, datetime
from typing import Any, NamedTuple

import numpy as np

from dehyst.errors import ColumnError, DehystError, ParameterError, UnitError
from dehyst.io import kit as io_kit
from dehyst.io import optional
from dehyst.units import canonical
from dehyst_studio.live import (
    PASSWORD,
    PAUSE,
    SHOWN,
    Arrival,
    Batch,
    Names,
    Notice,
    address_of,
    arrivals,
)

EXAMPLE = "opc.tcp://HOST:4840, or opc.tcp://USER@HOST:4840 with a password"
WAITING = 100_000  # changes that wait to be read; what comes then is left out
PAUSE_AWAY = 1.0  # seconds after which a server that is away is asked again
# What a server says that no waiting cures: of a node, of the user, of the certificate.
FINAL = (
    "BadNodeId",
    "BadIdentity",
    "BadUserAccess",
    "BadNotReadable",
    "BadSecurity",
    "BadCertificate",
    "BadAttribute",
)


class NodeChange(NamedTuple):
    """What a server told of a node: its place (0: input, 1: output), when, and the value or what it is instead."""

    place: int
    stamp: float
    value: float | None
    shown: str = ""


def change_of(
    place: int, value: object, source: datetime | None, server: datetime | None, good: bool
) -> NodeChange:
    """Return a change as it was notified; the source's stamp counts, else the server's, else arrival.

    Examples
    --------
    >>> change_of(0, 1.5, datetime(1970, 1, 1, 0, 1), None, True)
    NodeChange(place=0, stamp=60.0, value=1.5, shown='')
    >>> change_of(1, "high", datetime(1970, 1, 1, 0, 1), None, True).shown
    "'high'"
    """
    time = source or server or datetime.now(UTC)
    stamp = time.replace(tzinfo=time.tzinfo or UTC).timestamp()  # without a zone it is in UTC
    if (
        good
        and isinstance(value, int | float)
        and not isinstance(value, bool)
        and abs(value) <= io_kit.LARGEST
    ):
        return NodeChange(place, stamp, float(value))
    shown = repr(value[:SHOWN]) if isinstance(value, str | bytes) else repr(value)[:SHOWN]
    return NodeChange(place, stamp, None, shown if good else f"{shown} of bad quality")


class Changes:
    """Pairs changes of input and output: the input is held between its changes."""

    def __init__(self, names: Names) -> None:
        self.names = names
        self._held: float | None = None

    def read(self, arrived: Sequence[NodeChange]) -> tuple[Batch, list[str]]:
        """Samples at the changes of the output, in the order of their stamps, and values that are no numbers."""
        rows: list[tuple[float, float, float]] = []
        skipped = []
        for change in sorted(arrived, key=lambda change: change.stamp):
            if change.value is None:
                skipped.append(
                    f"{(self.names.input, self.names.output)[change.place]} = {change.shown}"
                )
            if change.place == 0:
                self._held = change.value
            elif self._held is not None and change.value is not None:
                rows.append((change.stamp, self._held, change.value))
        table = np.array(rows, dtype=np.float64).reshape(-1, 3)
        return (table[:, 0], table[:, 1], table[:, 2]), skipped


def opcua(
    endpoint: str, names: Names, *, period: float = 0.01, security: str = ""
) -> Iterator[Arrival]:
    """Changes of two nodes by subscription, at the source's time stamps, in the model's units.

    The unit of a node is its property EngineeringUnits, if the server has it.

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

    Raises
    ------
    ParameterError
        If the address or a node id cannot be meant.
    """
    address = address_of(endpoint, ("opc.tcp",), EXAMPLE)
    if not math.isfinite(period) or period < 0:
        raise ParameterError(
            f"sampling = {period:g} s must be a time, 0.01 for example.", sampling=period
        )
    asyncua = optional("asyncua", "watch", endpoint, "listening to", "follow a file: --follow FILE")
    for name, flag in ((names.input, "--input"), (names.output, "--output")):
        try:
            asyncua.ua.NodeId.from_string(name)
        except Exception:  # whatever that reader raises, the text is no node id
            raise ParameterError(
                f"{name!r:.80} is no node id. Type for example {flag} 'ns=2;s=Pressure', or {flag} 'ns=2;i=1005'.",
                node=name,
            ) from None
    if names.input == names.output:
        raise ParameterError(
            f"input and output are both the node {names.input!r:.80}; a loop needs two."
        )
    return _samples(_Link(asyncua, endpoint, address.user, names, period, security), names)


def _samples(link: _Link, names: Names) -> Iterator[Arrival]:
    """Start listening, and hand on what comes."""
    pairing = Changes(names)
    link.start()
    try:
        while True:
            arrived: list[NodeChange] = []
            for item in link.news():
                if isinstance(item, DehystError):
                    raise item
                if isinstance(item, Notice):
                    yield item
                else:
                    arrived.append(item)
            (times, *signals), skipped = pairing.read(arrived)
            x, y = (names.converted(k, signals[k], link.units[k], link.nodes[k])[0] for k in (0, 1))
            yield from arrivals(times, x, y, skipped)
    finally:
        link.end()


class _Link:
    """A thread that subscribes to the nodes, and again where the server was away."""

    def __init__(
        self, asyncua: Any, endpoint: str, user: str, names: Names, period: float, security: str
    ) -> None:
        self.asyncua, self.endpoint, self.user, self.names = asyncua, endpoint, user, names
        self.period, self.security = period, security
        self.nodes = (names.input, names.output)
        self.units = ["", ""]
        self._inbox: queue.Queue[NodeChange | Notice | DehystError] = queue.Queue(WAITING)
        self._stop = threading.Event()
        self._connected = False  # whether there was a session with both nodes
        self._last = ""  # notice
        self._thread = threading.Thread(target=lambda: asyncio.run(self._listen()), daemon=True)

    def start(self) -> None:
        """Begin to listen."""
        self._thread.start()

    def end(self) -> None:
        """Leave the server."""
        self._stop.set()
        self._thread.join(timeout=5.0)

    def news(self) -> list[NodeChange | Notice | DehystError]:
        """Wait a moment, and return what has come."""
        items: list[NodeChange | Notice | DehystError] = []
        with suppress(queue.Empty):
            items.append(self._inbox.get(timeout=PAUSE))
            while len(items) < WAITING:
                items.append(self._inbox.get_nowait())
        return items

    def put(self, item: NodeChange | Notice | DehystError) -> None:
        """Hand on to the other thread; what it cannot take is lost, which is a gap."""
        with suppress(queue.Full):
            self._inbox.put_nowait(item)

    def _say(self, text: str) -> None:
        if text != self._last:
            self._last = text
            self.put(Notice(text))

    async def _listen(self) -> None:
        """One session after the other; the first must get what was asked for, a later one waits for it."""
        while not self._stop.is_set():
            try:
                await self._session()
            except DehystError as fault:
                if not self._connected:
                    self.put(fault)
                    return
                self._say(f"{fault} It is asked again.")
            except (OSError, self.asyncua.ua.UaError) as fault:  # TimeoutError is an OSError
                why = f"{type(fault).__name__} {fault!s:.120}".strip()
                if any(name in why for name in FINAL) and not self._connected:
                    self.put(self._refused(why))
                    return
                self._say(f"{self.endpoint} is away or refuses ({why}); it is asked again.")
            except Exception as fault:
                self.put(self._refused(f"{type(fault).__name__} {fault!s:.120}"))
                return
            await asyncio.sleep(PAUSE_AWAY)

    def _refused(self, why: str) -> ColumnError:
        return ColumnError(
            f"{self.endpoint} cannot be listened to ({why}). Check node ids, user, password ({PASSWORD}) and security."
        )

    async def _session(self) -> None:
        asyncua = self.asyncua
        link = asyncua.Client(_without_user(self.endpoint))
        if self.security:
            await link.set_security_string(self.security)
        if self.user:
            link.set_user(self.user)
            link.set_password(os.environ.get(PASSWORD, ""))
        async with link:
            nodes = [link.get_node(name) for name in self.nodes]
            ids = [node.nodeid.to_string() for node in nodes]
            if ids[0] == ids[1]:
                raise ColumnError(f"input and output are both the node {ids[0]}; a loop needs two.")
            for place, node in enumerate(nodes):
                await self._look_at_unit(place, node)

            class Handler:
                """Takes notifications of changes."""

                def datachange_notification(_, node: Any, value: Any, data: Any) -> None:
                    notification = data.monitored_item.Value
                    good = notification.StatusCode is None or notification.StatusCode.is_good()
                    place = ids.index(node.nodeid.to_string())
                    self.put(
                        change_of(
                            place,
                            value,
                            notification.SourceTimestamp,
                            notification.ServerTimestamp,
                            good,
                        )
                    )

            subscription = await link.create_subscription(1000 * max(self.period, 0.05), Handler())
            handles = await subscription.subscribe_data_change(
                nodes, queuesize=1000, sampling_interval=1000 * self.period
            )
            for name, handle in zip(self.nodes, handles, strict=True):
                if isinstance(handle, asyncua.ua.StatusCode):
                    raise ColumnError(
                        f"{self.endpoint} does not serve the node {name} ({handle.name}). Browse the server for its id."
                    )
            self._connected, self._last = True, ""
            while not self._stop.is_set():
                await asyncio.sleep(PAUSE)
                await link.check_connection()

    async def _look_at_unit(self, place: int, node: Any) -> None:
        """Take the unit that the server names; refuse one that cannot be the model's."""
        unit = ""
        with suppress(
            self.asyncua.ua.UaStatusCodeError, AttributeError
        ):  # most nodes have no such property
            engineering_units = await (await node.get_child("0:EngineeringUnits")).read_value()
            unit = str(engineering_units.DisplayName.Text or "").strip()[:SHOWN]
        unit = canonical(unit) or unit
        column = f"of the node {self.nodes[place]}"
        try:
            notes = self.names.converted(place, np.zeros(1), unit, column)[1]
        except UnitError as fault:
            raise ColumnError(f"the unit {column}: {fault}") from None
        if not self._connected:
            for note in notes:
                self.put(Notice(note))
        self.units[place] = unit


def _without_user(endpoint: str) -> str:
    scheme, _, location = endpoint.partition("://")
    authority, slash, path = location.partition("/")
    return f"{scheme}://{authority.rpartition('@')[2]}{slash}{path}"
