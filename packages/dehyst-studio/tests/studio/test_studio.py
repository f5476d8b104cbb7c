"""Claims about `dehyst studio` without a browser: who is let in, what the page may ask for, what is left behind."""

from __future__ import annotations

import asyncio
import io
import json
import os
import socket
import subprocess
import sys
import zipfile
from contextlib import suppress
from dataclasses import fields
from pathlib import Path
from typing import get_type_hints

import pytest

from places import STUDIO

pytest.importorskip(
    "starlette", reason="the studio needs starlette and uvicorn: pip install dehyst-studio"
)
pytest.importorskip("httpx2", reason="httpx2 stands in for a browser: pip install httpx2")

from starlette.testclient import TestClient

from dehyst.errors import LogError, OutputError, ParameterError
from dehyst.shell import typed
from dehyst_studio.requests import StudioRequest
from dehyst_studio.studio import _server, run_studio
from dehyst_studio.studio._commands import COMMANDS, READ, WRITTEN, command_words
from dehyst_studio.studio._guard import ENTER, Guard, is_listed, owner_of
from dehyst_studio.studio._server import Studio, application

PORT, TOKEN = 8123, "secret"
HERE = f"http://127.0.0.1:{PORT}"
MINE = {"authorization": f"Bearer {TOKEN}"}


class Scripted:
    """Stands for the processes: remembers the words, and says what it was told to say."""

    def __init__(self, *events):
        self.events, self.words, self.busy = events, [], False

    async def prepare(self):
        pass

    async def end(self):
        pass

    async def run(self, words):
        self.words.append(words)
        for event in self.events:
            yield event


@pytest.fixture
def studio(tmp_path):
    return Studio(tmp_path, limit=1000, workers=Scripted())


@pytest.fixture
def browser(studio, monkeypatch):
    monkeypatch.setattr(
        _server, "PAGE", STUDIO / "page" / "src" / "page.html"
    )  # before it is built
    with TestClient(Guard(application(studio), port=PORT, token=TOKEN), base_url=HERE) as client:
        yield client


ROUTES = [
    ("POST", ENTER),
    ("GET", "/api/state"),
    ("GET", "/api/alive"),
    ("POST", "/api/logs?name=a.csv"),
    ("GET", "/api/files/a"),
]
ROUTES += [("POST", f"/api/run/{command}") for command in COMMANDS]


@pytest.mark.parametrize("sent", [None, "", "Bearer", "Bearer wrong", f"Basic {TOKEN}", TOKEN])
def test_without_the_token_nothing_of_the_user_is_answered(browser, studio, sent):
    for method, path in ROUTES:
        answer = browser.request(
            method, path, headers={} if sent is None else {"authorization": sent}
        )
        assert answer.status_code == 403 and "pen the " in answer.text, path
    assert studio.workers.words == [] and list(studio.folder.iterdir()) == []
    assert browser.get("/api/state", headers=MINE).status_code == 200


FOREIGN = [
    {"host": f"evil.example:{PORT}"},  # DNS rebinding
    {"host": f"127.0.0.1.evil.example:{PORT}"},
    {"host": "127.0.0.1:1"},
    {"host": "127.0.0.1"},
    {"origin": "https://evil.example"},
    {"origin": f"http://127.0.0.1:{PORT + 1}"},
    {"origin": f"http://localhost:{PORT}"},  # the page of the other name is another origin
    {"origin": "null"},
    {"sec-fetch-site": "cross-site"},
    {"sec-fetch-site": "same-site"},  # another port of this machine
]


@pytest.mark.parametrize("sent", FOREIGN, ids=str)
@pytest.mark.parametrize("path", ["/", "/report/x", "/api/state"])
def test_pages_from_elsewhere_are_refused_even_with_the_token(browser, path, sent):
    answer = browser.get(path, headers=MINE | sent)
    assert answer.status_code == 403
    assert not any(name.startswith("access-control") for name in answer.headers)


def test_no_answer_lets_another_origin_read_it_and_a_preflight_is_refused(browser):
    ask = {"origin": "https://evil.example", "access-control-request-method": "POST"}
    assert browser.options("/api/run/identify", headers=ask).status_code == 403
    for path in ("/", "/api/state"):
        answer = browser.get(path, headers=MINE | {"origin": HERE, "sec-fetch-site": "same-origin"})
        assert answer.status_code == 200 and answer.headers["x-frame-options"] == "DENY"
        assert answer.headers["cross-origin-resource-policy"] == "same-origin"
        assert not any(name.startswith("access-control") for name in answer.headers)


DIALS = {
    "by IPv4": "s = socket.socket(); s.connect(('127.0.0.1', {port}))",
    "by IPv6": "s = socket.socket(socket.AF_INET6); s.connect(('::ffff:127.0.0.1', {port}))",
    "from another address": "s = socket.socket(); s.bind(('127.0.0.2', 0)); s.connect(('127.0.0.1', {port}))",
    "closed": "s = socket.socket(); s.connect(('127.0.0.1', {port})); s.close()",
    "half closed": "s = socket.socket(); s.connect(('127.0.0.1', {port})); s.shutdown(1)",
    "reset": "s = socket.socket(); s.connect(('127.0.0.1', {port})); "
    "s.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, bytes([1, 0, 0, 0, 0, 0, 0, 0])); s.close()",
}


@pytest.mark.skipif(
    not Path("/proc/net/tcp").exists() or not hasattr(os, "getuid") or os.getuid() != 0,
    reason="needs Linux, and root to become another user",
)
@pytest.mark.parametrize("way", DIALS)
def test_another_user_of_the_machine_is_refused_even_with_the_token(way):
    """However the connection is made: by IPv6, from another loopback address, closed or reset before it is asked."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        server.settimeout(20.0)
        port = server.getsockname()[1]
        guard = Guard(None, port=port, token=TOKEN, key="once")
        dial = f"import socket, sys; {DIALS[way].format(port=port)}; print(flush=True); sys.stdin.read()"
        words = ["python3", "-S", "-c", dial]  # that of the system, which every user may run
        with subprocess.Popen(
            words, user=65534, cwd="/", stdin=subprocess.PIPE, stdout=subprocess.PIPE
        ) as other:
            connection, client = server.accept()
            other.stdout.readline()
            headers = [
                (b"host", f"127.0.0.1:{port}".encode()),
                (b"authorization", b"Bearer secret"),
            ]
            scope = {"type": "http", "path": "/api/state", "headers": headers, "client": client}
            why = guard.refusal(scope)
            enters = guard.refusal(
                scope | {"path": ENTER, "headers": [headers[0], (b"authorization", b"Bearer once")]}
            )
            connection.close()
            other.stdin.close()
        assert other.returncode == 0
        assert why == enters == "The studio belongs to another user of this machine."
        assert guard.key  # it did not die by it
        with socket.create_connection(("127.0.0.1", port)) as mine:
            assert guard.refusal(scope | {"client": mine.getsockname()}) == ""


CONNECTION = (
    "  0: {} {} {} 00000000:00000000 00:00000000 00000000 {} 0 1 1 0000000000000000 20 4 0 10 -1"
)


def _tables(folder, name, *lines):
    (folder / name).write_text(
        "\n".join(["  sl  local_address ...", *(CONNECTION.format(*line) for line in lines)])
    )
    return folder


def _end_of(address, port):
    words = [address[k : k + 4] for k in range(0, len(address), 4)]
    return "".join(f"{int.from_bytes(word, sys.byteorder):08X}" for word in words) + f":{port:04X}"


def test_the_owner_of_a_connection_is_that_of_its_own_line(tmp_path):
    here, there = bytes([127, 0, 0, 1]), bytes([127, 0, 0, 2])
    mapped = bytes(10) + b"\xff\xff" + here
    server, client = ("127.0.0.1", 8000), ("127.0.0.1", 5000)
    assert owner_of(client, server, tmp_path) is None and not is_listed(server, tmp_path)
    ends = _end_of(here, 5000), _end_of(here, 8000)
    lines = [(ends[1], _end_of(bytes(4), 0), "0A", 7), (_end_of(there, 5000), ends[1], "01", 8)]
    _tables(tmp_path, "tcp", *lines, (*ends, "05", 0))
    assert is_listed(server, tmp_path) and not is_listed(client, tmp_path)
    assert (
        owner_of(client, server, tmp_path) is None
    )  # closed; what is established is another address
    _tables(tmp_path, "tcp6", (_end_of(mapped, 5000), _end_of(mapped, 8000), "01", 9))
    assert owner_of(client, server, tmp_path) == 9
    _tables(tmp_path, "tcp", *lines, (*ends, "01", 10))
    assert (
        owner_of(client, server, tmp_path) == 10
        and owner_of(("127.0.0.2", 5000), server, tmp_path) == 8
    )


def test_the_key_gives_the_token_once(studio, monkeypatch):
    studio.token = TOKEN
    with TestClient(
        Guard(application(studio), port=PORT, token=TOKEN, key="once"), base_url=HERE
    ) as client:
        for wrong in ("Bearer wrong", "Bearer ", "Bearer secret", ""):
            assert client.post(ENTER, headers={"authorization": wrong}).status_code == 403
        assert client.get("/api/state", headers={"authorization": "Bearer once"}).status_code == 403
        foreign = {"authorization": "Bearer once", "origin": "https://evil.example"}
        assert client.post(ENTER, headers=foreign).status_code == 403
        assert client.post(ENTER, headers={"authorization": "Bearer once"}).json() == {
            "token": TOKEN
        }
        again = client.post(ENTER, headers={"authorization": "Bearer once"})
        assert again.status_code == 403 and "somebody else was quicker" in again.text
    with TestClient(Guard(application(studio), port=PORT, token=TOKEN), base_url=HERE) as client:
        assert (
            client.post(ENTER, headers={"authorization": "Bearer "}).status_code == 403
        )  # no key, no entry


def test_the_command_line_of_the_browser_holds_no_token(monkeypatch, capsys):
    opened = []
    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.setattr("webbrowser.open", lambda address: opened.append(address) or True)
    monkeypatch.setattr(_server, "serve", lambda *args, **others: opened.append((args, others)))
    run_studio(StudioRequest())
    address, ((_, token, _), others) = opened
    assert (
        token not in address
        and address.endswith(f"#once={others['key']}")
        and len(others["key"]) > 40
    )
    assert f"#studio={token}" in capsys.readouterr().out


def test_the_page_may_call_the_studio_and_nobody_else(browser):
    text = browser.get("/").text
    assert (
        "default-src 'none'; connect-src 'self';" in text and '<meta name="dehyst-studio"' in text
    )
    assert TOKEN not in text  # it is in the address alone, behind #, which no browser sends


@pytest.mark.parametrize("command", COMMANDS)
def test_the_page_names_no_file_of_the_machine(command, tmp_path):
    hints = get_type_hints(COMMANDS[command])
    for entry in fields(COMMANDS[command]):
        if "Path" not in str(hints[entry.name]):
            continue
        given = {entry.name: "/etc/passwd"}
        if entry.name in READ:
            with pytest.raises(ParameterError, match="no file '/etc/passwd'"):
                command_words(command, given, Studio(tmp_path).place, tmp_path)
        else:
            with pytest.raises(ParameterError, match=f"no option '{entry.name}'"):
                command_words(command, given, Studio(tmp_path).place, tmp_path)


def test_what_was_chosen_on_the_page_is_the_line_that_would_be_typed(tmp_path):
    given = {
        "logs": ["a", "b"],
        "input": "-x",
        "start": [2.5],
        "runs": ["up", "down"],
        "position_schedule": False,
    }
    words, written = command_words(
        "identify", given | {"family": "pi", "stop": None}, lambda name: Path(name), tmp_path
    )
    assert words == [
        "identify", "--input=-x", "--run=up", "--run=down", "--from=2.5", "--family=pi", "--no-position-schedule",
        f"--save={tmp_path / 'model.json'}", f"--report={tmp_path / 'report.html'}", "--json", "--", "a", "b",
    ]  # fmt: skip
    assert written == {name: tmp_path / file for name, file in WRITTEN.items()}
    given = {"model": "m", "target": "c", "range": [-1, 2], "tunable": True, "retain": False}
    words, written = command_words("export", given, lambda name: Path(name), tmp_path)
    assert words[1:] == [
        "--target=c",
        f"--out={tmp_path / 'code'}",
        "--range",
        "-1",
        "2",
        "--tunable",
        "--json",
        "--",
        "m",
    ]


def test_a_dropped_log_is_kept_under_its_own_name_within_the_limit(browser, studio):
    answer = browser.post(
        "/api/logs", params={"name": "../../C:\\x/elbow 3.csv"}, content=b"a,b\n", headers=MINE
    ).json()
    assert answer["name"] == "elbow 3.csv" and answer["bytes"] == 4
    assert (
        studio.place(answer["id"]).read_bytes() == b"a,b\n"
        and studio.folder in studio.place(answer["id"]).parents
    )
    assert browser.get(f"/api/files/{answer['id']}", headers=MINE).content == b"a,b\n"
    there = sorted(studio.folder.iterdir())
    for large in (b"0" * 1001, iter([b"0" * 600, b"0" * 600])):  # told in advance, and not
        answer = browser.post("/api/logs?name=big.csv", content=large, headers=MINE)
        assert answer.status_code == 413 and "dehyst studio big.csv" in answer.json()["error"]
    assert sorted(studio.folder.iterdir()) == there


LONG = (
    "\u6f22" * 99 + ".csv",
    "\U0001f600" * 70 + ".csv",
    "e\u0301" * 80 + ".tar.gz",
    "a" * 300 + ".csv",
    "x" * 250,
)


@pytest.mark.parametrize(
    "name",
    [*LONG, ".csv", "a:b?.csv", "-rf.csv", "--help", "\u202egnp.csv", "a=b.csv", "<img src=x>.csv"],
)
def test_a_log_of_any_name_is_kept_and_shown_under_it(browser, studio, name):
    """File systems count bytes: 255 as a rule, 143 where names are encrypted."""
    answer = browser.post("/api/logs", params={"name": name}, content=b"a,b\n", headers=MINE).json()
    path = studio.place(answer["id"])
    assert path.read_bytes() == b"a,b\n" and len(path.name.encode()) <= 120
    shown = name.replace("\u202e", "").strip(". ")
    assert answer["name"] == shown[-255:] and path.suffix in (Path(shown).suffix, ".csv")
    studio.workers.events = ({"status": 0, "said": "", "printed": "{}"},)
    told = browser.post("/api/run/inspect", json={"log": answer["id"]}, headers=MINE)
    line = json.loads(told.text.splitlines()[0])["command"]
    word = f"./{shown[-255:]}" if name.startswith("-") else shown[-255:]
    assert line == typed(["dehyst", "inspect", word])
    assert browser.get(f"/api/files/{answer['id']}", headers=MINE).content == b"a,b\n"


def test_an_upload_that_breaks_off_leaves_nothing(studio):
    """Neither a file nor a traceback; and the body of a command that breaks off is no command."""

    async def half(path):
        sent = []
        parts = iter(
            [
                {"type": "http.request", "body": b"1,2\n" * 100, "more_body": True},
                {"type": "http.disconnect"},
            ]
        )

        async def receive():
            return next(parts)

        async def send(message):
            sent.append(message)

        query = b"name=a.csv"
        headers = [
            (b"host", f"127.0.0.1:{PORT}".encode()),
            (b"authorization", MINE["authorization"].encode()),
        ]
        scope = {
            "type": "http",
            "method": "POST",
            "path": path,
            "raw_path": path.encode(),
            "query_string": query,
        }
        guard = Guard(application(studio), port=PORT, token=TOKEN)
        await guard(
            scope | {"headers": headers, "client": None, "server": None, "scheme": "http"},
            receive,
            send,
        )
        return sent[0]["status"]

    for path in ("/api/logs", "/api/run/identify"):
        assert asyncio.run(half(path)) == 400
    assert list(studio.folder.iterdir()) == [] and studio.logs == [] and studio.workers.words == []


def test_of_a_large_body_no_more_is_read_than_is_allowed(studio):
    read = []

    async def endless():
        part = b" " * 65536
        headers = [
            (b"host", f"127.0.0.1:{PORT}".encode()),
            (b"authorization", MINE["authorization"].encode()),
        ]

        async def receive():
            read.append(len(part))
            return {"type": "http.request", "body": part, "more_body": True}

        async def send(message):
            sent.append(message)

        sent = []
        scope = {
            "type": "http",
            "method": "POST",
            "path": "/api/run/identify",
            "query_string": b"",
            "headers": headers,
        }
        guard = Guard(application(studio), port=PORT, token=TOKEN)
        await guard(scope | {"client": None, "server": None, "scheme": "http"}, receive, send)
        return sent[0]["status"]

    assert asyncio.run(endless()) == 400
    assert sum(read) <= _server.BODY + 2 * 65536


def test_a_folder_and_a_file_that_is_gone_are_refused(browser, studio):
    folder, gone = studio.keep(studio.folder), studio.keep(studio.folder / "gone.html")
    for name in (folder, gone):
        answer = browser.get(f"/api/files/{name}", headers=MINE)
        assert answer.status_code == 400 and "no file" in answer.json()["error"]
    assert browser.get(f"/report/{gone}").status_code == 403


def test_a_log_whose_name_is_no_text_is_shown(browser, studio):
    path = Path(os.fsdecode(bytes(str(studio.folder), "utf-8") + b"/caf\xe9.csv"))
    path.write_bytes(b"a,b\n")
    name = studio.keep(path, log=True)
    assert browser.get("/api/state", headers=MINE).json()["logs"][0]["name"] == "caf\\udce9.csv"
    assert browser.get(f"/api/files/{name}", headers=MINE).content == b"a,b\n"


def test_an_error_comes_in_its_own_words_and_leaves_no_folder(browser, studio):
    studio.workers.events = (
        {"status": 2, "said": "ColumnError: no column 'z'. Name one: a, b.", "printed": ""},
    )
    name = studio.keep(studio.folder / "a.csv", log=True)
    answer = browser.post("/api/run/identify", json={"logs": [name]}, headers=MINE)
    first, *told = answer.text.splitlines()
    line = "dehyst identify a.csv --save=model.json --report=report.html"
    assert (
        first == '{"command": "' + line + '"}'
    )  # to be typed elsewhere: no path of the temporary folder
    assert told == ['{"error": "no column \'z\'. Name one: a, b.", "kind": "ColumnError"}']
    for body in (b"", b"[]", b"{", b"{" * 2_000_000):
        answer = browser.post("/api/run/identify", content=body, headers=MINE)
        assert answer.status_code == 400 and "JSON object" in answer.json()["error"]
    assert (
        browser.post("/api/run/reproduce", json={}, headers=MINE).json()["kind"] == "ParameterError"
    )
    assert list(studio.folder.iterdir()) == []


def test_a_log_that_cannot_be_read_is_marked_until_it_can(browser, studio):
    name = studio.keep(studio.folder / "a.csv", log=True)
    for status, said, printed, marked in (
        (2, "LogError: no text.", "", True),
        (0, "", "{}", False),
    ):
        studio.workers.events = ({"status": status, "said": said, "printed": printed},)
        browser.post("/api/run/inspect", json={"log": name}, headers=MINE)
        assert [
            log["refused"] for log in browser.get("/api/state", headers=MINE).json()["logs"]
        ] == [marked]


def test_verifying_renews_the_archive_of_the_folder(browser, studio):
    code = studio.folder / "code"
    code.mkdir()
    given = {"folder": studio.keep(code), "zip": studio.keep(_server._packed(code))}
    (code / "VERIFIED.txt").write_text("all passed")
    studio.workers.events = ({"status": 0, "said": "", "printed": "{}"},)
    browser.post("/api/run/verify", json={"folder": given["folder"]}, headers=MINE)
    packed = browser.get(f"/api/files/{given['zip']}", headers=MINE).content
    assert "code/VERIFIED.txt" in zipfile.ZipFile(io.BytesIO(packed)).namelist()


def test_a_report_has_an_origin_of_its_own_and_nothing_else_is_given_without_the_token(
    browser, studio
):
    for name in ("report.html", "model.json"):
        (studio.folder / name).write_text("<script>1</script>")
    page, model = (studio.keep(studio.folder / name) for name in ("report.html", "model.json"))
    answer = browser.get(f"/report/{page}")
    assert answer.status_code == 200 and answer.headers["content-security-policy"].startswith(
        "sandbox allow-scripts"
    )
    assert "allow-same-origin" not in answer.headers["content-security-policy"]
    assert (
        browser.get(f"/report/{model}").status_code == 403
        and browser.get("/report/x").status_code == 403
    )


def test_it_ends_when_no_page_is_open_for_a_while_and_not_before(tmp_path):
    async def life(pages, busy, idle):
        ended = []
        workers = Scripted()
        workers.busy = busy
        studio = Studio(
            tmp_path, idle=idle, pages=pages, workers=workers, leave=lambda: ended.append(True)
        )
        with suppress(TimeoutError):
            await asyncio.wait_for(studio.watch(), 0.3)
        return bool(ended)

    assert asyncio.run(life(0, False, 0.05))
    assert not asyncio.run(life(1, False, 0.05)) and not asyncio.run(life(0, True, 0.05))
    assert not asyncio.run(life(0, False, 0.0))


def test_a_log_that_is_missing_and_a_port_that_is_taken_are_told(tmp_path):
    with pytest.raises(LogError, match=r"no log 'none\.csv'"):
        run_studio(StudioRequest(Path("none.csv"), browser=False))
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        with pytest.raises(OutputError, match=f"port {port} .* cannot be used: .*--port"):
            run_studio(StudioRequest(port=port, browser=False))


@pytest.mark.slow
def test_one_command_has_a_worker_that_ends_with_it(tmp_path):
    """Its words, its progress, its result; and with nobody waiting for it, it is gone."""
    from dehyst_studio.studio._work import Workers

    (tmp_path / "log.csv").write_text("time_s,pressure_bar,angle_deg\n" + "\n".join(
        f"{k / 10},{abs(k % 14 - 7)},{2 * abs(k % 14 - 7)}" for k in range(200)))  # fmt: skip

    async def work():
        workers = Workers()
        words = ["identify", "--json", "--family=pi", "--", str(tmp_path / "log.csv")]
        events = [event async for event in workers.run(words)]
        async for _ in (running := workers.run(words)):
            process = next(iter(workers._busy))
            break
        await running.aclose()
        status = await process.wait()
        await workers.end()
        return events, status, workers.busy

    events, status, busy = asyncio.run(work())
    assert [event.get("stage") for event in events[:-1]] == ["reading", "identifying"]
    assert events[-1]["status"] == 0 and '"family": "pi"' in events[-1]["printed"]
    assert (status == -9 or sys.platform == "win32") and not busy
