"""An actuator is watched while it runs: what is found does not depend on how samples arrive, and outlives restarts."""

import contextlib
import itertools
import json
import os
import shutil
import signal
import socket
import subprocess
import sys
import threading
import time
import tracemalloc

import numpy as np
import pytest

import dehyst
from dehyst.errors import ModelFileError, ParameterError
from dehyst_studio.live import Names, Skipped, follow_live
from dehyst_studio.mqtt import Messages, mqtt
from dehyst_studio.opcua import opcua
from dehyst_studio.watch import MOST, Watch

MODEL = dehyst.PrandtlIshlinskii([0.0, 0.3, 0.6], [1.0, 0.5, 0.4])
T = 0.01 * np.arange(20_000)
X = np.sin(2 * np.pi * 0.5 * T) * (1 - 0.3 * np.abs(np.sin(0.31 * T)))
NOISE = 1e-3 * np.random.default_rng(0).standard_normal(T.size)
Y = MODEL.simulate(X) + NOISE
WORN = MODEL.simulate(X) * np.where(T < 100, 1.0, 1.1) + NOISE


def found(watch, parts):
    return [report for part in parts for report in watch.feed(*part)]


def cut(size, *signals):
    return [[signal[k : k + size] for signal in signals] for k in range(0, len(signals[0]), size)]


@pytest.mark.slow
def test_reports_do_not_depend_on_the_size_of_batches():
    whole = [found(Watch(MODEL), cut(size, T, X, WORN)) for size in (20_000, 777, 50)]
    assert len(whole[0]) > 10
    for other in whole[1:]:
        assert [r.status for r in other][-5:] == [r.status for r in whole[0]][-5:]
        assert abs(other[-1].changes["gain"][0] - whole[0][-1].changes["gain"][0]) < 0.5


def test_a_change_is_an_alarm_once_and_names_its_part():
    reports = found(Watch(MODEL), cut(500, T, X, WORN))
    assert {r.status for r in reports if r.time < 100} == {"unchanged"}
    alarms = [r for r in reports if r.alarm]
    assert [r.status for r in alarms] == [
        "cannot tell",
        "drifted",
    ]  # while old and new cycles stand side by side
    assert 100 < alarms[0].time < 115 and alarms[1].time < 145
    value, low, high, _ = reports[-1].changes["gain"]
    assert low < 10 < high or abs(value - 10) < 0.5


@pytest.mark.slow
def test_a_restart_goes_on_where_it_was_and_a_state_of_another_model_is_refused(tmp_path):
    once = found(Watch(MODEL), cut(500, T, X, WORN))
    parts, twice, state = cut(500, T, X, WORN), [], tmp_path / "state"
    for half in (parts[:17], parts[17:]):
        watch = Watch(MODEL, state=state)
        twice += found(watch, half)
        watch.save()
    assert [(r.status, r.alarm) for r in twice] == [(r.status, r.alarm) for r in once]
    with pytest.raises(ModelFileError, match="another model"):
        Watch(dehyst.PrandtlIshlinskii([0.0], [1.0]), state=state)
    state.write_bytes(b"torn")
    with pytest.raises(ModelFileError, match="Delete it"):
        Watch(MODEL, state=state)


@pytest.mark.slow
def test_memory_stays_flat_over_an_hour_at_a_kilohertz():
    watch, t = Watch(MODEL, cycles=8, every=8), 1e-3 * np.arange(10_000)
    sizes, used = [], []
    tracemalloc.start()
    for k in range(360):
        x = np.sin(
            2 * np.pi * (t + 10 * k) * (0.002 if k < 20 else 0.4)
        )  # cycles that do not end, then usual ones
        watch.feed(t + 10 * k, x, MODEL.simulate(x))
        sizes.append(len(watch._rows))
        used.append(tracemalloc.get_traced_memory()[0])
    tracemalloc.stop()
    assert max(sizes) <= MOST + 10_000
    assert np.mean(used[300:]) < 1.2 * np.mean(used[100:200]) + 1e5


@pytest.mark.parametrize("settings", [{"cycles": 3}, {"every": 0}, {"cycles": 10, "every": 11}])
def test_settings_that_decide_nothing_are_refused(settings):
    with pytest.raises(ParameterError, match="8 to 1000"):
        Watch(MODEL, **settings)


# Sources


def taken(source, count, patience=20.0):
    """The first rows of a source, and the source."""
    rows, until = [], time.monotonic() + patience
    for batch in source:
        if isinstance(batch, tuple):
            rows += list(zip(*batch, strict=True))
        if len({row[0] for row in rows}) >= count or time.monotonic() > until:
            return rows
    return rows


def test_a_log_that_grows_is_followed_over_torn_lines_and_a_new_file(tmp_path):
    log = tmp_path / "log.csv"
    source = follow_live(log, Names("p", "angle"))
    assert next(source) is None
    log.write_text(
        "time_s;p [bar];angle\n"
        + "".join(f"{k / 10:.1f};{k},5;{2 * k}\n".replace(".", ",") for k in range(9))
    )
    assert taken(source, 9)[:2] == [(0.0, 0.5, 0.0), (0.1, 1.5, 2.0)]
    with log.open("a") as stream:
        stream.write("0,9;9,5;1")
        stream.flush()
        assert next(source) is None
        stream.write("8\n\nbroken line\n1,0;10,5;20\n")
    assert taken(source, 2) == [(0.9, 9.5, 18.0), (1.0, 10.5, 20.0)]
    log.unlink()
    log.write_text("angle,p\n" + "".join(f"{k},{2 * k}\n" for k in range(8)))
    assert taken(source, 8) == [
        (12.0 + k, 2.0 * k, float(k)) for k in range(8)
    ]  # there is no time: lines are counted
    with log.open("a") as stream:
        stream.write("7,#ERR\n8,\n")
    assert next(source) == Skipped(2, "8,")
    assert next(source) is None


def port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


@pytest.fixture
def broker(tmp_path):
    """A mosquitto on the loopback interface with TLS and a password, which can be stopped and started again."""
    if shutil.which("mosquitto") is None or shutil.which("openssl") is None:
        pytest.skip("mosquitto or openssl is not installed")

    def openssl(*words):
        subprocess.run(["openssl", *words], cwd=tmp_path, check=True, capture_output=True)

    openssl("req", "-x509", "-newkey", "rsa:2048", "-nodes", "-keyout", "key.pem", "-out", "cert.pem", "-days", "2",
            "-subj", "/CN=localhost", "-addext", "subjectAltName=DNS:localhost")  # fmt: skip
    subprocess.run(
        ["mosquitto_passwd", "-b", "-c", "users", "rig", "secret"], cwd=tmp_path, check=True
    )
    number = port()
    (tmp_path / "conf").write_text(
        f"listener {number} 127.0.0.1\ncafile {tmp_path}/cert.pem\ncertfile {tmp_path}/cert.pem\n"
        f"keyfile {tmp_path}/key.pem\npassword_file {tmp_path}/users\nallow_anonymous false\nuser root\n"
        f"persistence true\npersistence_location {tmp_path}/\nmax_queued_messages 0\n"
    )
    running = []

    def start():
        running.append(
            subprocess.Popen(["mosquitto", "-c", str(tmp_path / "conf")], stderr=subprocess.DEVNULL)
        )
        for _ in range(100):
            with contextlib.suppress(OSError), socket.create_connection(("127.0.0.1", number), 0.1):
                return
            time.sleep(0.05)

    def stop():
        running[-1].terminate()
        running[-1].wait()

    start()
    yield f"mqtts://rig@localhost:{number}/rig/1", start, stop
    stop()


@pytest.mark.slow
def test_nothing_is_lost_when_the_broker_or_this_side_goes_away(broker, tmp_path, monkeypatch):
    import paho.mqtt.client as paho

    url, start, stop = broker
    monkeypatch.setenv("DEHYST_PASSWORD", "secret")
    number = int(url.split(":")[2].split("/")[0])
    sender = paho.Client(paho.CallbackAPIVersion.VERSION2, client_id="rig", clean_session=False)
    sender.username_pw_set("rig", "secret")
    sender.tls_set(ca_certs=str(tmp_path / "cert.pem"))
    sender.reconnect_delay_set(1, 1)

    def send(first, last):
        for k in range(first, last):
            sender.publish("rig/1", json.dumps({"time": k, "p": k, "angle": 2 * k}), qos=1)

    source, publish = mqtt(url, Names("p", "angle"), ca=tmp_path / "cert.pem")
    next(source)
    time.sleep(1.0)
    sender.connect("localhost", number)
    sender.loop_start()
    send(0, 50)
    rows = taken(source, 50)
    stop()
    send(50, 100)  # while the broker is away
    start()
    rows += taken(source, 50, 40)
    source.close()
    time.sleep(0.5)
    send(100, 150)  # while this side is away
    time.sleep(1.0)
    source, publish = mqtt(url, Names("p", "angle"), ca=tmp_path / "cert.pem")
    rows += taken(source, 50)
    assert sorted({t for t, _, _ in rows}) == list(map(float, range(150)))
    assert all(y == 2 * x for _, x, y in rows)
    heard = []
    sender.on_message = lambda c, d, message: heard.append(message.payload)
    sender.subscribe("rig/1/alarm", qos=1)
    publish('{"status": "drifted"}')
    for _ in range(100):
        time.sleep(0.05)
        if heard:
            break
    assert heard == [b'{"status": "drifted"}']
    source.close()
    sender.disconnect()
    sender.loop_stop()


def read(payload, messages=None, arrived=5.0):
    """Rows of a message, and how much of it is left out."""
    messages = messages or Messages(Names("p", "a"))
    batch, skipped, _ = messages.read(
        payload if isinstance(payload, bytes) else payload.encode(), arrived
    )
    return [tuple(map(float, row)) for row in zip(*batch, strict=True)], len(skipped)


def test_what_is_no_message_is_handed_on_as_skipped_and_lists_are_samples():
    for none in (
        b"\xff{",
        '{"p": 1}',
        '"x"',
        '{"p": 1, "a": 1' + "0" * 400 + "}",
        '{"p": true, "a": 1}',
        '{"p": [1, 2], "a": [1, 2, 3]}',
        '{"p": 1, "a": 2, "p": 3}',
        '{"p": "1", "a": 2}',
        "[" * 100_000,
        '{"p": 1, "a": ' * 5000,
    ):
        assert read(none) == ([], 1)
    assert read('{"p": 1, "a": 2}') == ([(5.0, 1.0, 2.0)], 0)
    half = '{"time": [0, 1], "p": [1, 2], "a": [3, null]}'
    assert read(f"[{half}]") == ([(0.0, 1.0, 3.0)], 1)


@pytest.mark.slow
def test_the_command_says_how_many_lines_hold_no_numbers(tmp_path):
    (tmp_path / "log.csv").write_text(
        "time_s,input,output\n0,0,0\n1,1,1\n2,2,2\n3,ERR,1\n4,,2\n5,1,1\n6,2,2\n7,1,1\n"
    )
    said = command(tmp_path, "--follow", "log.csv", "--until-silent", "0.1").stderr
    assert "2 samples lack a number, the last is '4,,2'; they are left out, like a gap" in said
    assert "Expected are lines with the columns 'input' and 'output' in log.csv." in said


def test_a_url_without_a_topic_is_refused_with_one_that_has():
    with pytest.raises(ParameterError, match="mqtt://HOST/TOPIC"):
        mqtt("mqtt://localhost", Names("p", "a"))


@pytest.mark.slow
def test_values_of_an_opc_ua_server_arrive_with_its_stamps_over_its_restart(monkeypatch):
    asyncio = pytest.importorskip("asyncio")
    asyncua = pytest.importorskip("asyncua")
    from asyncua.server.user_managers import UserManager, UserRole

    monkeypatch.setenv("DEHYST_PASSWORD", "secret")
    number = port()

    class Users(UserManager):
        def get_user(self, iserver, username=None, password=None, certificate=None):
            from asyncua.crypto.permission_rules import User

            return User(UserRole.User) if (username, password) == ("rig", "secret") else None

    async def serve(first, last):
        server = asyncua.Server(user_manager=Users())
        await server.init()
        server.set_endpoint(f"opc.tcp://127.0.0.1:{number}")
        server.set_security_policy([asyncua.ua.SecurityPolicyType.NoSecurity])
        index = await server.register_namespace("rig")
        x = await server.nodes.objects.add_variable(f"ns={index};s=p", "p", -1.0)
        y = await server.nodes.objects.add_variable(f"ns={index};s=a", "a", -1.0)
        async with server:
            await asyncio.sleep(3.0)
            for k in range(first, last):
                await x.write_value(float(k))
                await y.write_value(2.0 * k)
                await asyncio.sleep(0.03)
            await asyncio.sleep(1.5)

    def run():
        for first in (0, 40):
            asyncio.run(serve(first, first + 40))

    thread = threading.Thread(target=run, daemon=True)
    thread.start()
    source = opcua(f"opc.tcp://rig@127.0.0.1:{number}", Names("ns=2;s=p", "ns=2;s=a"), period=0.01)
    rows = taken(source, 82, 40)
    source.close()
    thread.join(20)
    pairs = {(x, y) for _, x, y in rows if y == 2 * x}
    assert len(pairs) >= 78
    stamps = [t for t, _, _ in rows]
    assert all(b >= a for a, b in itertools.pairwise(stamps)) and stamps[-1] - stamps[0] > 2


# The command


def command(tmp_path, *words):
    MODEL.save(tmp_path / "model.json")
    return subprocess.run(
        [sys.executable, "-m", "dehyst", "watch", "model.json", *words], cwd=tmp_path, capture_output=True, text=True,
        timeout=120, check=False, env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
    )  # fmt: skip


def logged(path, y):
    np.savetxt(
        path,
        np.column_stack([T, X, y]),
        delimiter=",",
        header="time_s,input,output",
        comments="",
        fmt="%.17g",
    )


@pytest.mark.slow
def test_the_command_ends_with_the_verdict_of_its_last_report(tmp_path):
    logged(tmp_path / "log.csv", WORN)
    done = command(
        tmp_path, "--follow", "log.csv", "--until-silent", "1", "--json", "--state", "kept"
    )
    lines = [json.loads(line) for line in done.stdout.splitlines()]
    assert (
        done.returncode == 1
        and lines[-1]["status"] == "drifted"
        and lines[0]["status"] == "unchanged"
    )
    assert (tmp_path / "kept").exists()


@pytest.mark.slow
def test_the_command_says_at_once_what_it_watches_and_an_alarm_is_a_sentence(tmp_path):
    beginning = [
        "watching log.csv, which is not there yet",
        "model: model.json, input -> output",
        "reports: each 6 cycles about the last 24, the first after 8 whole cycles",
        "state: not kept; --state FILE keeps it over restarts",
        "stop with Ctrl-C",
    ]
    MODEL.save(tmp_path / "model.json")
    run = subprocess.Popen(
        [sys.executable, "-m", "dehyst", "watch", "model.json", "--follow", "log.csv", "--until-silent", "30"],
        cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
    )  # fmt: skip
    try:
        assert [
            run.stderr.readline().rstrip() for _ in beginning
        ] == beginning  # nothing has come yet
        logged(tmp_path / "new.csv", WORN)
        (tmp_path / "new.csv").rename(tmp_path / "log.csv")
        alarms = (line for line in run.stdout if "ALARM" in line or "NOTE" in line)
        assert "s  NOTE: whether the actuator has changed cannot be told now: " in next(alarms)
        assert "s  ALARM: the actuator has changed: gain +" in next(alarms)
    finally:
        run.send_signal(signal.SIGINT)
        run.communicate(timeout=60)


@pytest.mark.slow
def test_the_command_says_where_its_state_is_and_whether_it_goes_on(tmp_path):
    (tmp_path / "log.csv").write_text(
        "time_s,input,output\n" + "".join(f"{k},{k},{k}\n" for k in range(12))
    )
    watch = ("--follow", "log.csv", "--until-silent", "0.1", "--state", "kept")
    assert "state: kept, written every 2 s\nstop with Ctrl-C\n" in command(tmp_path, *watch).stderr
    assert "written every 2 s, goes on after 12 kept samples\n" in command(tmp_path, *watch).stderr


def test_two_sources_or_none_are_refused(tmp_path):
    done = command(tmp_path)
    assert done.returncode == 2 and "0 sources are named" in done.stderr
