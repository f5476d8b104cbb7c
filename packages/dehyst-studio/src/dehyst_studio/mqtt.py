"""Messages of an MQTT broker: JSON objects with the signals' names, whoever sent them."""

from __future__ import annotations

import json
import math
import os
import queue
import re
import sys
import time as clock
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from dehyst.arrays import Array
from dehyst.errors import DehystError, ParameterError
from dehyst.io import LogTable, optional, parse_date_times, require_unit, seconds
from dehyst.io import kit as io_kit
from dehyst.io import with_time_unit as with_unit_of_time
from dehyst.units import parse_unit
from dehyst_studio.live import (
    PASSWORD,
    PAUSE,
    SHOWN,
    Address,
    Arrival,
    Batch,
    Names,
    Notice,
    address_of,
    arrivals,
    is_called_time,
)

EXAMPLE = "mqtt://HOST/TOPIC, or mqtts://USER@HOST:8883/TOPIC with TLS"
LONGEST = 1 << 18  # bytes of a message: 3 000 samples take less
WAITING = 256  # messages that wait to be read, 64 MB of the longest; more wait at the broker
REPEATED = 4096  # messages that are remembered, so that one that the broker sends twice counts once
MOST_KEYS, LONGEST_KEY = (
    1000,
    200,
)  # of an object: names are remembered, and nobody shall fill the memory with them
LONGEST_TOPIC = 65_000  # bytes; MQTT allows 65 535, and an alarm's is longer
YEAR_FIRST = re.compile(
    r"\d{4}-\d\d-\d\d[T ]", re.ASCII
)  # the only order of day and month that one stamp tells


class _NoSampleError(Exception):
    """A message holds no sample, and why."""


@dataclass(frozen=True)
class _Keys:
    """Keys of a message that hold time, input and output, and the units of the signals."""

    time: str | None
    signals: tuple[str, str]
    units: tuple[str, str]


class Messages:
    """Decodes messages: JSON objects, or lists of them, in which each signal is a number or a list of numbers.

    Keys are found like columns of a log: by the exact name, in any case, without the unit. ``time`` is a number, in
    the unit that its key names, or a date-time with the year first; where there is none, arrival counts.

    Examples
    --------
    >>> messages = Messages(Names("p", "angle"))
    >>> batch, skipped, why = messages.read(b'{"time_ms": 1500, "p [bar]": 1, "angle": 2}', 0.0)
    >>> [values.tolist() for values in batch], skipped
    ([[1.5], [1.0], [2.0]], [])
    """

    def __init__(self, names: Names) -> None:
        self.names = names
        self.notes: list[str] = []  # what is to be said of units, once
        self._keys = lru_cache(maxsize=64)(self._found)
        self._remembered: set[str] = set()

    def read(self, payload: bytes, arrived: float) -> tuple[Batch, list[str], str]:
        """Samples of a message, what of it holds none, and what is wrong with the last of that."""
        batches: list[Batch] = []
        skipped, why = [], ""
        shown = payload[:SHOWN].decode("utf-8", "replace")
        try:
            objects = _objects(payload)
        except _NoSampleError as fault:
            objects, skipped, why = [], [shown], str(fault)
        for entry in objects:
            try:
                batch, left = self._samples(entry, arrived)
                batches.append(batch)
                if left:
                    skipped.append(shown)
            except _NoSampleError as fault:
                skipped.append(shown)
                why = str(fault)
        times, x, y = np.zeros(0), np.zeros(0), np.zeros(0)
        if batches:
            times, x, y = map(np.concatenate, zip(*batches, strict=True))
        return (times, x, y), skipped, why

    def _samples(self, entry: object, arrived: float) -> tuple[Batch, bool]:
        """Return samples of one object, and whether some of it is none."""
        if not isinstance(entry, dict):
            raise _NoSampleError("it is no JSON object")
        keys = self._keys(tuple(entry))
        lists: list[list[Any]] = []
        for key in (keys.time, *keys.signals):
            # Without a time in the message its arrival counts.
            value = entry.get(key) if key else arrived
            if not isinstance(value, list):
                value = [value]
            lists.append(value)
        if len(set(map(len, lists))) != 1:
            raise _NoSampleError(
                "its lists have different lengths, which does not tell what belongs together"
            )
        samples: list[tuple[float, Any, Any]] = []
        first_time: object = None
        for time, x, y in zip(*lists, strict=True):
            stamp = _stamp(time)
            if stamp is None or not _is_number(x) or not _is_number(y):
                continue
            if not samples:
                first_time = time
            samples.append((stamp, x, y))
        if not samples:
            raise _NoSampleError("time, input and output are not all numbers")
        times, *signals = np.array(samples, dtype=np.float64).T
        try:
            times = self._in_seconds(keys.time, times, isinstance(first_time, str))
            for role in (0, 1):
                column = f"'{keys.signals[role]}' of the messages"
                signals[role], notes = self.names.converted(
                    role, signals[role], keys.units[role], column
                )
                self._note(notes)
        except DehystError as fault:
            raise _NoSampleError(str(fault)) from None
        return (times, signals[0], signals[1]), len(samples) < len(lists[0])

    def _in_seconds(self, key: str | None, times: Array, dates: bool) -> Array:
        """Times as a column of a log with this name would be read; counted from 1970 where they tell."""
        if key is None or dates:
            return times
        table = LogTable(
            "the messages", {key: times}, {key: parse_unit(key)[1]}, np.arange(times.size)
        )
        table = with_unit_of_time(table, self.names.time_unit, key)
        require_unit(table, key)
        stamps, origin = seconds(table, key)
        return stamps + origin

    def _found(self, keys: tuple[str, ...]) -> _Keys:
        """Return which keys are meant."""
        if len(keys) > MOST_KEYS or any(len(key) > LONGEST_KEY for key in keys):
            raise _NoSampleError(
                f"it has more than {MOST_KEYS} keys, or one of more than {LONGEST_KEY} characters"
            )
        table = LogTable("the messages", {}, {}, np.arange(1), order=keys)
        names, keys_meant = [self.names.input, self.names.output], []
        if self.names.time:
            names.append(self.names.time)
        for name in names:
            candidates = io_kit.matching(table, name)
            if not candidates:
                raise _NoSampleError(f"it lacks the key '{name}'")
            if len(candidates) > 1:
                raise _NoSampleError(f"it has {len(candidates)} keys that may be '{name}'")
            keys_meant.append(candidates[0])
        x, y, *timer = keys_meant
        if x == y:
            raise _NoSampleError(f"input and output are both its key '{x}'")
        timers = [key for key in keys if key not in (x, y) and is_called_time(key)]
        plain = [key for key in timers if key.lower() == "time"]
        time = next(iter([*timer, *plain, *timers]), None)
        return _Keys(time, (x, y), (parse_unit(x)[1], parse_unit(y)[1]))

    def _note(self, notes: Sequence[str]) -> None:
        for note in notes:
            if note not in self._remembered and len(self._remembered) < WAITING:
                self._remembered.add(note)
                self.notes.append(note)


def _objects(payload: bytes) -> list[object]:
    """Return the entries of a message."""
    if len(payload) > LONGEST:
        raise _NoSampleError(f"it is longer than {LONGEST >> 10} kB")
    try:
        content = json.loads(payload, object_pairs_hook=_without_repetition)
    except (
        ValueError,
        RecursionError,
    ):  # a hostile message may be nested deeper than any that holds samples
        raise _NoSampleError("it is no JSON") from None
    return content if isinstance(content, list) else [content]


def _without_repetition(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    entry = dict(pairs)
    if len(entry) < len(pairs):
        raise _NoSampleError(
            "one of its keys stands there twice, and nothing tells which number counts"
        )
    return entry


def _is_number(value: object) -> bool:
    """Whether a value of a message is a number that a sensor can have measured."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    return abs(value) <= io_kit.LARGEST  # False of NaN


def _stamp(value: object) -> float | None:
    """Number of a time, seconds since 1970 of a date-time with the year first, or None."""
    if isinstance(value, str) and len(value) < SHOWN and YEAR_FIRST.match(value):
        stamp = float(parse_date_times([value], "day")[0])
        # NaN stands for a text that is no date.
        if math.isnan(stamp):
            return None
        return stamp
    if isinstance(value, bool) or not isinstance(value, int | float):
        return None
    return float(value) if abs(value) <= sys.float_info.max else None


def mqtt(
    url: str, names: Names, *, ca: Path | None = None, client: str = "dehyst"
) -> tuple[Iterator[Arrival], Callable[[str], None]]:
    """Messages of a topic, and what publishes to TOPIC/alarm.

    What a message may hold: `Messages`. The session is kept by the broker under the client's name: what is published
    with QoS 1 while this side is away comes later. Passwords: the variable DEHYST_PASSWORD.

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
        If the URL names no host or not one topic, or the certificate cannot be read.
    """
    address = _address(url)
    topic = address.path
    paho = optional(
        "paho.mqtt.client", "watch", url, "listening to", "follow a file: --follow FILE"
    )
    inbox: queue.Queue[Any] = queue.Queue(WAITING)
    closing: list[bool] = []
    link = paho.Client(paho.CallbackAPIVersion.VERSION2, client_id=client, clean_session=False)

    def put(item: object) -> None:
        """Hand on; where the other thread is behind, wait, so that the broker has to."""
        waiting = True
        while waiting and not closing:
            with suppress(queue.Full):
                inbox.put(item, timeout=PAUSE)
                waiting = False

    def heard(_: object, __: object, message: Any) -> None:
        payload = (
            message.payload if len(message.payload) <= LONGEST else message.payload[: LONGEST + 1]
        )
        put((clock.time(), payload, message.dup))

    def connected(_: object, __: object, ___: object, reason: Any, ____: object) -> None:
        if reason.is_failure:
            put(
                Notice(
                    f"the broker refuses: {reason}. It is asked again. A password stands in {PASSWORD}."
                )
            )
        else:
            link.subscribe(topic, qos=1)

    def subscribed(
        _: object, __: object, ___: object, reasons: Sequence[Any], ____: object
    ) -> None:
        if any(reason.is_failure for reason in reasons):
            put(Notice(f"the broker does not let this user read the topic {topic}: {reasons[0]}."))

    link.on_connect, link.on_subscribe, link.on_message = connected, subscribed, heard
    link.on_connect_fail = lambda *_: put(
        Notice(f"{address.host} does not answer; it is asked again.")
    )
    link.reconnect_delay_set(1, 30)
    if address.user:
        link.username_pw_set(address.user, os.environ.get(PASSWORD))
    if address.scheme == "mqtts":
        try:
            link.tls_set(ca_certs=None if ca is None else str(ca))
        except OSError as fault:
            raise ParameterError(
                f"the certificate '{ca}' cannot be read: {fault}. Give a PEM file.", ca=ca
            ) from None
    link.connect_async(address.host, address.port or (8883 if address.scheme == "mqtts" else 1883))
    link.loop_start()

    def samples() -> Iterator[Arrival]:
        messages = Messages(names)
        recent: deque[int] = deque(maxlen=REPEATED)
        last: Notice | None = None
        try:
            while True:
                try:
                    item = inbox.get(timeout=PAUSE)
                except queue.Empty:
                    yield None
                    continue
                if isinstance(item, Notice):
                    yield item if item != last else None
                    last = item
                    continue
                arrived, payload, again = item
                mark = hash(payload)
                repeated = again and mark in recent  # QoS 1 may deliver twice
                recent.append(mark)
                if repeated:
                    yield None
                    continue
                batch, skipped, why = messages.read(payload, arrived)
                while messages.notes:
                    yield Notice(messages.notes.pop(0))
                yield from arrivals(*batch, skipped, why)
        finally:
            closing.append(True)
            link.disconnect()
            link.loop_stop()

    def publish(text: str) -> None:
        link.publish(f"{topic}/alarm", text, qos=1, retain=True)

    return samples(), publish


def _address(url: str) -> Address:
    """Take an address apart, and refuse what is not one topic."""
    address = address_of(url, ("mqtt", "mqtts"), EXAMPLE)
    topic = address.path
    if not topic:
        raise ParameterError(f"{url!r:.80} names no broker and topic. Type {EXAMPLE}.", url=url)
    if "+" in topic or "#" in topic:
        raise ParameterError(
            f"the topic {topic!r:.80} stands for many topics (+ and # are wildcards): a watch follows one actuator, "
            f"and samples of several would be mixed. Name one topic, and start a watch for each.",
            url=url,
        )
    if "\0" in topic or len(topic.encode("utf-8", "replace")) > LONGEST_TOPIC:
        raise ParameterError(
            f"the topic {topic!r:.40} is no topic: it holds NUL, or is too long.", url=url
        )
    return address
