"""Claims about `dehyst studio` without a browser: who is let in, what the page may ask for, what is left behind."""

from __future__ import annotations

import asyncio
import io
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

pytest.importorskip("starlette", reason="the studio needs starlette and uvicorn: pip install 'dehyst[studio]'")
pytest.importorskip("httpx2", reason="httpx2 stands in for a browser: pip install httpx2")

from starlette.testclient import TestClient

from dehyst.app.requests import StudioRequest
from dehyst.app.studio import _server, run_studio
from dehyst.app.studio._server import Studio, application
from dehyst.app.studio.commands import COMMANDS, READ, WRITTEN, words_of
from dehyst.app.studio.guard import Guard, owner_of
from dehyst.errors import LogError, OutputError, ParameterError

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
    monkeypatch.setattr(_server, "PAGE", Path(__file__).parents[1] / "page" / "src" / "page.html")  # before it is built
    with TestClient(Guard(application(studio), port=PORT, token=TOKEN), base_url=HERE) as client:
        yield client


ROUTES = [("GET", "/api/state"), ("GET", "/api/alive"), ("POST", "/api/logs?name=a.csv"), ("GET", "/api/files/a")]
ROUTES += [("POST", f"/api/run/{command}") for command in COMMANDS]


@pytest.mark.parametrize("sent", [None, "", "Bearer", "Bearer wrong", f"Basic {TOKEN}", TOKEN])
def test_without_the_token_nothing_of_the_user_is_answered(browser, studio, sent):
    for method, path in ROUTES:
        answer = browser.request(method, path, headers={} if sent is None else {"authorization": sent})
        assert answer.status_code == 403 and "open the address" in answer.text, path
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


@pytest.mark.skipif(
    not Path("/proc/net/tcp").exists() or not hasattr(os, "getuid") or os.getuid() != 0,
    reason="needs Linux, and root to become another user",
)
def test_another_user_of_the_machine_is_refused_even_with_the_token():
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
        dial = f"import socket; s = socket.create_connection(('127.0.0.1', {port})); s.recv(1)"
        with subprocess.Popen(["python3", "-c", dial], user=65534, cwd="/") as other:
            connection, client = server.accept()
            guard = Guard(None, port=port, token=TOKEN)
            headers = [(b"host", f"127.0.0.1:{port}".encode()), (b"authorization", b"Bearer secret")]
            scope = {"type": "http", "path": "/api/state", "headers": headers, "client": client}
            assert owner_of(client[1], port) == 65534
            assert guard.refusal(scope) == "The studio belongs to another user of this machine."
            connection.close()
        assert other.returncode == 0


def test_the_page_may_call_the_studio_and_nobody_else(browser):
    text = browser.get("/").text
    assert "default-src 'none'; connect-src 'self';" in text and '<meta name="dehyst-studio"' in text
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
                words_of(command, given, Studio(tmp_path).place, tmp_path)
        else:
            with pytest.raises(ParameterError, match=f"no option '{entry.name}'"):
                words_of(command, given, Studio(tmp_path).place, tmp_path)


def test_what_was_chosen_on_the_page_is_the_line_that_would_be_typed(tmp_path):
    given = {"logs": ["a", "b"], "input": "-x", "start": [2.5], "runs": ["up", "down"], "position_schedule": False}
    words, written = words_of("identify", given | {"family": "pi", "stop": None}, lambda name: Path(name), tmp_path)
    assert words == [
        "identify", "--input=-x", "--run=up", "--run=down", "--from=2.5", "--family=pi", "--no-position-schedule",
        f"--save={tmp_path / 'model.json'}", f"--report={tmp_path / 'report.html'}", "--json", "--", "a", "b",
    ]  # fmt: skip
    assert written == {name: tmp_path / file for name, file in WRITTEN.items()}
    given = {"model": "m", "target": "c", "range": [-1, 2], "tunable": True, "retain": False}
    words, written = words_of("export", given, lambda name: Path(name), tmp_path)
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
    assert studio.place(answer["id"]).read_bytes() == b"a,b\n" and studio.folder in studio.place(answer["id"]).parents
    assert browser.get(f"/api/files/{answer['id']}", headers=MINE).content == b"a,b\n"
    there = sorted(studio.folder.iterdir())
    for large in (b"0" * 1001, iter([b"0" * 600, b"0" * 600])):  # told in advance, and not
        answer = browser.post("/api/logs?name=big.csv", content=large, headers=MINE)
        assert answer.status_code == 413 and "dehyst studio big.csv" in answer.json()["error"]
    assert sorted(studio.folder.iterdir()) == there


def test_an_error_comes_in_its_own_words_and_leaves_no_folder(browser, studio):
    studio.workers.events = ({"status": 2, "said": "ColumnError: no column 'z'. Name one: a, b.", "printed": ""},)
    name = studio.keep(studio.folder / "a.csv", log=True)
    answer = browser.post("/api/run/identify", json={"logs": [name]}, headers=MINE)
    first, *told = answer.text.splitlines()
    line = "dehyst identify a.csv --save=model.json --report=report.html"
    assert first == '{"command": "' + line + '"}'  # to be typed elsewhere: no path of the temporary folder
    assert told == ['{"error": "no column \'z\'. Name one: a, b.", "kind": "ColumnError"}']
    for body in (b"", b"[]", b"{", b"{" * 2_000_000):
        answer = browser.post("/api/run/identify", content=body, headers=MINE)
        assert answer.status_code == 400 and "JSON object" in answer.json()["error"]
    assert browser.post("/api/run/reproduce", json={}, headers=MINE).json()["kind"] == "ParameterError"
    assert list(studio.folder.iterdir()) == []


def test_a_log_that_cannot_be_read_is_marked_until_it_can(browser, studio):
    name = studio.keep(studio.folder / "a.csv", log=True)
    for status, said, printed, marked in ((2, "LogError: no text.", "", True), (0, "", "{}", False)):
        studio.workers.events = ({"status": status, "said": said, "printed": printed},)
        browser.post("/api/run/inspect", json={"log": name}, headers=MINE)
        assert [log["refused"] for log in browser.get("/api/state", headers=MINE).json()["logs"]] == [marked]


def test_verifying_renews_the_archive_of_the_folder(browser, studio):
    code = studio.folder / "code"
    code.mkdir()
    given = {"folder": studio.keep(code), "zip": studio.keep(_server._packed(code))}
    (code / "VERIFIED.txt").write_text("all passed")
    studio.workers.events = ({"status": 0, "said": "", "printed": "{}"},)
    browser.post("/api/run/verify", json={"folder": given["folder"]}, headers=MINE)
    packed = browser.get(f"/api/files/{given['zip']}", headers=MINE).content
    assert "code/VERIFIED.txt" in zipfile.ZipFile(io.BytesIO(packed)).namelist()


def test_a_report_has_an_origin_of_its_own_and_nothing_else_is_given_without_the_token(browser, studio):
    for name in ("report.html", "model.json"):
        (studio.folder / name).write_text("<script>1</script>")
    page, model = (studio.keep(studio.folder / name) for name in ("report.html", "model.json"))
    answer = browser.get(f"/report/{page}")
    assert answer.status_code == 200 and answer.headers["content-security-policy"].startswith("sandbox allow-scripts")
    assert "allow-same-origin" not in answer.headers["content-security-policy"]
    assert browser.get(f"/report/{model}").status_code == 403 and browser.get("/report/x").status_code == 403


def test_it_ends_when_no_page_is_open_for_a_while_and_not_before(tmp_path):
    async def life(pages, busy, idle):
        ended = []
        workers = Scripted()
        workers.busy = busy
        studio = Studio(tmp_path, idle=idle, pages=pages, workers=workers, leave=lambda: ended.append(True))
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
    from dehyst.app.studio.work import Workers

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
