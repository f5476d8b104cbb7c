"""Ten thousand hostile messages on each transport: right samples between them are judged, and the alarm still comes."""

import json
import math
import tracemalloc
from datetime import UTC, datetime, timedelta
from itertools import islice

import numpy as np
import pytest

import dehyst
from dehyst.errors import DehystError, LogError, ParameterError
from dehyst.models import ModelCard, SignalCard
from dehyst_studio.live import LONGEST_LINE, Names, Notice, Skipped, follow_live
from dehyst_studio.mqtt import Messages, _address, mqtt
from dehyst_studio.opcua import Changes, change_of, opcua
from dehyst_studio.watch import Watch

CARD = ModelCard(SignalCard("pressure", "bar", -1.0, 1.0), SignalCard("angle", "deg", -2.0, 2.0))
MODEL = dehyst.PrandtlIshlinskii([0.0, 0.3, 0.6], [1.0, 0.5, 0.4]).with_card(CARD)
NAMES = Names("pressure", "angle", cards=(CARD.input, CARD.output))
HUGE = [1e300, -1e300, 1e101, 1e30, -1e6]
WEIRD_TIMES = [-1e9, 0.0, -5.0, 1e300, 1e18, 1.7e9, 1e12, -1e300]


def samples(count):
    """Samples of an actuator that wears in the middle, (count, 3)."""
    t = 0.05 * np.arange(count)
    x = np.sin(2 * np.pi * 0.5 * t) * (1 - 0.15 * np.abs(np.sin(0.31 * t)))
    y = MODEL.simulate(x) * np.where(t < t[count // 2], 1.0, 1.1)
    return np.column_stack([t, x, y + 1e-3 * np.random.default_rng(0).standard_normal(count)])


def hostile_message(rng, now):
    """One message that holds no right sample."""
    t, p, a = now + 0.01, 0.1, 0.2
    huge, weird = float(rng.choice(HUGE)), float(rng.choice(WEIRD_TIMES))
    texts = [
        "[" * int(rng.integers(1, 100_000)),
        '{"time":' * int(rng.integers(1, 3000)) + "1" + "}" * 3000,
        f'{{"time": {t}, "pressure": {huge!r}, "angle": {a}}}',
        f'{{"time": {t}, "pressure": {p}, "angle": {huge!r}}}',
        f'{{"time": {t}, "pressure": 1{"0" * 5000}, "angle": 1}}',
        f'{{"time": {t}, "pressure": NaN, "angle": {a}}}',
        f'{{"time": {t}, "pressure": {p}, "angle": -Infinity}}',
        f'{{"time": {t}, "pressure": 1e999, "angle": {a}}}',
        f'{{"time": {t}, "pressure": "{p}", "angle": {a}}}',
        f'{{"time": {t}, "p": {p}, "angle": {a}}}',
        f'{{"time": {t}, "pressure": {p}, "pressure": {a}, "angle": {a}}}',
        f'{{"time": {t}, "pressure": {p}, "pressure_kPa": 3, "Pressure": 5, "angle": null}}',
        f'{{"time": {t}, "pressure [V]": {p}, "angle": {a}}}',
        f'{{"time": {weird!r}, "pressure": {p}, "angle": {a}}}',
        f'{{"time": "{weird!r}", "pressure": {p}, "angle": {a}}}',
        f'{{"time": "2024-99-99T12:00:00", "pressure": {p}, "angle": {a}}}',
        f'{{"time [ticks]": {t}, "pressure": {p}, "angle": [{a}]}}' if rng.random() < 0.5 else "[[[]]]",
        f'{{"time": [{t}, {t}], "pressure": {p}, "angle": {a}}}',
        f'{{"pressure": {p}, "angle": {a}}}',  # arrives now, not at the clock of the others
        json.dumps({f"key {k}": k for k in range(1500)}),
        json.dumps({"pressure" * 100: 1, "angle": 2}),
        "", " ", "null", "true", "[]", "{}", "3", '"text"', "\x00" * 50, f'{{"time": {t}, "pressure": {p}, "ang',
    ]  # fmt: skip
    if rng.random() < 0.1:
        return rng.bytes(int(rng.integers(0, 400)))
    if rng.random() < 0.002:
        return b'{"time": 1, "pressure": [' + b"1," * 200_000 + b"1]}"
    text = texts[int(rng.integers(len(texts)))]
    return text.encode(
        str(rng.choice(["utf-8", "utf-16", "latin-1", "utf-32"])) if rng.random() < 0.1 else "utf-8"
    )


def hostile_line(rng, now):
    """One line that holds no right sample."""
    t, p, a = repr(now + 0.01), "0.1", "0.2"
    huge, weird = repr(float(rng.choice(HUGE))), repr(float(rng.choice(WEIRD_TIMES)))
    lines = [
        f"{t},{huge},{a}", f"{t},{p},{huge}", f"{t},nan,{a}", f"{t},{p},inf", f"{t},1e999,{a}", f"{t},{p}",
        f"{t},{p},{a},{a}", f"{weird},{p},{a}", f"{t};{p};{a}", f'{t},"{p},{a}', f"{t},1_0,{a}", "# a comment",
        f"{t},\u0661,{a}", "", ",,", "[" * 5000, "x" * 20_000, "time_s,pressure_bar,angle_deg", f"{t},{p} kPa,{a}",
        f"2024-03-05 12:00:00,{p},{a}", "\t\t\t", "\x00" * 30, f"{t},0x10,{a}", f"{t},--,{a}", f"{t},1{'0' * 400},{a}",
    ]  # fmt: skip
    if rng.random() < 0.1:
        return rng.bytes(int(rng.integers(0, 300))).replace(b"\n", b"")
    line = lines[int(rng.integers(len(lines)))]
    return line.encode("utf-16" if rng.random() < 0.05 else "utf-8").replace(b"\n", b"")


def hostile_change(rng, now):
    """What a server may notify of a node that is no right value."""
    stamp = datetime(2024, 1, 1, tzinfo=UTC) + timedelta(seconds=now + 0.001)
    place = int(rng.integers(2))
    wrong = [
        math.nan,
        math.inf,
        10**400,
        "0.1",
        b"\x00\xff" * 500,
        None,
        True,
        [0.1, 0.2],
        {"a": 1},
        "x" * 10**6,
        1 + 2j,
    ]
    stamps = [
        datetime(1601, 1, 1),
        datetime(9999, 12, 31, tzinfo=UTC),
        datetime(1970, 1, 1),
        stamp - timedelta(days=1),
    ]
    kind = int(rng.integers(3))
    if kind == 0:
        return change_of(place, wrong[int(rng.integers(len(wrong)))], stamp, None, True)
    if kind == 1:
        return change_of(1, 0.1, stamps[int(rng.integers(len(stamps)))], stamp, True)
    return change_of(1, float(rng.choice(HUGE)), stamp, None, True)


def judged(reports, middle):
    """Whether reports say what is true: unchanged before the wear, drifted at the end, an alarm of it soon after."""
    before = {report.status for report in reports if report.time < middle}
    alarms = [report for report in reports if report.alarm and report.status == "drifted"]
    value, low, high, _ = reports[-1].changes["gain"]
    is_right = low < 10.0 < high or abs(value - 10.0) < 1.0
    return (
        before == {"unchanged"} and len(alarms) == 1 and alarms[0].time < middle + 45 and is_right
    )


def feed(watch, reports, batch):
    reports += watch.feed(*batch)


def shaken(count, rng):
    """Right samples with hostile ones between them: (sample or None)."""
    rows, left = samples(max(1800, count // 3)), count
    per_row = count / len(rows)
    for row in rows:
        yield row
        for _ in range(min(left, int(rng.poisson(per_row)))):
            left -= 1
            yield None
    for _ in range(left):
        yield None


@pytest.mark.slow
@pytest.mark.parametrize("count", [300, 10_000])
def test_messages(count):
    rng, watch, messages, reports = np.random.default_rng(1), Watch(MODEL), Messages(NAMES), []
    skipped, now, hostile = 0, 0.0, 0
    for row in shaken(count, rng):
        if row is None:
            payload = hostile_message(rng, now)
            hostile += 1
        else:
            now = float(row[0])
            payload = json.dumps(
                dict(zip(("time", "pressure", "angle"), row.tolist(), strict=True))
            ).encode()
        batch, left, _ = messages.read(payload, 1.7e9)
        skipped += len(left)
        feed(watch, reports, batch)
    assert hostile == count and skipped > 0.5 * count and watch.strange > 0.05 * count
    assert judged(reports, samples(max(1800, count // 3))[-1, 0] / 2)


@pytest.mark.parametrize("count", [300, pytest.param(10_000, marks=pytest.mark.slow)])
def test_lines(count, tmp_path):
    rng, watch, reports, skipped = np.random.default_rng(2), Watch(MODEL), [], 0
    lines, now = [b"time_s,pressure_bar,angle_deg"], 0.0
    for number, row in enumerate(shaken(count, rng)):
        if row is not None:
            now = float(row[0])
            lines.append(",".join(repr(float(value)) for value in row).encode())
        elif number > count // 10:  # a table that begins with other things than its rows is none
            lines.append(hostile_line(rng, now))
    (tmp_path / "log.csv").write_bytes(b"\n".join(lines) + b"\n")
    for arrival in follow_live(tmp_path / "log.csv", NAMES):
        if arrival is None:
            break
        if isinstance(arrival, Skipped):
            skipped += arrival.count
        elif not isinstance(arrival, Notice):
            feed(watch, reports, arrival)
    assert skipped > 0.5 * count and judged(reports, samples(max(1800, count // 3))[-1, 0] / 2)


@pytest.mark.parametrize("count", [300, pytest.param(10_000, marks=pytest.mark.slow)])
def test_changes(count):
    rng, watch, pairing, reports, now = (
        np.random.default_rng(3),
        Watch(MODEL),
        Changes(NAMES),
        [],
        0.0,
    )
    begin, skipped, waiting = datetime(2024, 1, 1, tzinfo=UTC), 0, []
    for row in shaken(count, rng):
        if row is None:
            waiting.append(hostile_change(rng, now))
        else:
            now = float(row[0])
            stamp = begin + timedelta(seconds=now)
            waiting += [
                change_of(0, float(row[1]), stamp, None, True),
                change_of(1, float(row[2]), stamp, None, True),
            ]
        if len(waiting) > 20:
            batch, left = pairing.read(waiting)
            skipped += len(left)
            waiting = []
            feed(watch, reports, batch)
    assert skipped > 0.2 * count
    assert judged(reports, begin.timestamp() + samples(max(1800, count // 3))[-1, 0] / 2)


@pytest.mark.slow
def test_memory_stays_flat_however_long_a_line_or_how_many_the_messages(tmp_path):
    log = tmp_path / "log.csv"
    begin = "time_s,pressure_bar,angle_deg\n" + "".join(f"{k},{k % 3},{k % 5}\n" for k in range(20))
    log.write_text(begin + "1,2" + "0" * (5 * LONGEST_LINE) + "\n20,1,2\n")
    tracemalloc.start()
    rows, skipped = [], []
    for arrival in islice(follow_live(log, NAMES), 12):
        if isinstance(arrival, Skipped):
            skipped.append(arrival)
        elif isinstance(arrival, tuple):
            rows += arrival[0].tolist()
    assert rows == [*range(21)] and all(len(one.last) <= 200 for one in skipped)
    messages = Messages(NAMES)
    for k in range(300):  # keys that were never seen before, and will not be seen again
        messages.read(json.dumps({f"{k} key {j}": 1 for j in range(30)}).encode(), 0.0)
    assert len(messages.notes) == 0 and tracemalloc.get_traced_memory()[1] < 12 * LONGEST_LINE
    tracemalloc.stop()


def test_a_stream_without_samples_still_ticks(tmp_path):
    """Who listens can look at its clock: nothing has come, keep the state, end."""
    log = tmp_path / "log.csv"
    log.write_text("# comments only\n" * 3)
    source = follow_live(log, NAMES)
    assert next(source) is None
    with log.open("a") as stream:
        stream.write(
            "time_s,pressure_bar,angle_deg\n" + "".join(f"{k},{k % 3},{k % 5}\n" for k in range(20))
        )
    assert next(arrival for arrival in source if isinstance(arrival, tuple))[0].size == 20
    with log.open("a") as stream:
        stream.write("# nothing\n" * 1000)
    assert next(source) is None


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"\x00\x01\x02" * 40_000, "hold no lines"),
        (b"x" * 200_000, "hold no lines"),
        (
            (
                "time_s,pressure_bar,angle_deg\n" + "".join(f"{k},{k % 3},4\n" for k in range(40))
            ).encode("utf-16"),
            "line by line",
        ),
        (b"time_s,p_bar,angle_deg\n" + b"1,2,3\n2,3,4\n" * 20, "has no input column 'pressure'"),
    ],
)
def test_a_file_that_is_no_table_of_these_signals_is_refused(tmp_path, content, words):
    (tmp_path / "log.csv").write_bytes(content)
    with pytest.raises(DehystError, match=words):
        for arrival in islice(follow_live(tmp_path / "log.csv", NAMES), 8):
            assert not isinstance(arrival, tuple)


def test_a_folder_cannot_be_followed(tmp_path):
    with pytest.raises(LogError, match="cannot be followed"):
        next(follow_live(tmp_path, NAMES))


@pytest.mark.parametrize(
    ("address", "words"),
    [
        ("mqtt://127.0.0.1:99999/x", "no address"),
        ("mqtt://[::1/x", "no address"),
        ("mqtt://HOST:abc/x", "no address"),
        ("mqtt://HOST:0/x", "no address"),
        ("mqtt://HOST:-1/x", "no address"),
        ("mqtt:///x", "no address"),
        ("mqtt://" + "a" * 300 + "/x", "no address"),
        ("mqtt://a..b/x", "no address"),
        ("http://HOST/x", "no address"),
        ("HOST/x", "no address"),
        ("", "no address"),
        ("mqtt://HOST", "no broker and topic"),
        ("mqtt://HOST/", "no broker and topic"),
        ("mqtt://HOST/plant/+/elbow", "wildcards"),
        ("mqtt://HOST/plant/#", "wildcards"),
        ("mqtt://HOST/a\0b", "NUL"),
        ("mqtt://HOST/" + "a" * 70_000, "too long"),
        ("mqtt://rig:secret@HOST/x", "DEHYST_PASSWORD"),
    ],
)
def test_addresses_that_cannot_be_meant_are_refused_by_name(address, words):
    with pytest.raises(ParameterError, match=words) as refusal:
        mqtt(address, NAMES)
    assert "secret" not in str(refusal.value)


def test_a_topic_is_taken_as_it_stands():
    for url, topic in (
        ("mqtt://h/a?b=1", "a?b=1"),
        ("mqtt://h//a/b", "/a/b"),
        ("mqtts://u@[::1]:8883/$SYS/x", "$SYS/x"),
    ):
        assert _address(url).path == topic


def test_a_certificate_that_cannot_be_read_is_refused(tmp_path):
    pytest.importorskip("paho.mqtt.client")
    (tmp_path / "ca.pem").write_text("no certificate")
    for file in ("none.pem", "ca.pem"):
        with pytest.raises(ParameterError, match="certificate"):
            mqtt("mqtts://HOST/x", NAMES, ca=tmp_path / file)


@pytest.mark.parametrize(
    ("endpoint", "nodes", "words"),
    [
        ("http://HOST", ("i=1", "i=2"), "no address"),
        ("opc.tcp://HOST:99999", ("i=1", "i=2"), "no address"),
        ("opc.tcp://[::1", ("i=1", "i=2"), "no address"),
        ("opc.tcp://rig:secret@HOST", ("i=1", "i=2"), "DEHYST_PASSWORD"),
        ("opc.tcp://HOST", ("p", "i=2"), "'p' is no node id"),
        ("opc.tcp://HOST", ("i=1", "ns=x;s=a"), "--output"),
        ("opc.tcp://HOST", ("i=1", ""), "no node id"),
        ("opc.tcp://HOST", ("i=1", "i=1"), "both"),
    ],
)
def test_servers_and_nodes_that_cannot_be_meant_are_refused_by_name(endpoint, nodes, words):
    pytest.importorskip("asyncua")
    with pytest.raises(ParameterError, match=words):
        opcua(endpoint, Names(*nodes))
