"""Claims about the studio under every hostile value of every field of every command that it offers."""

from __future__ import annotations

import json
import os
import random
import sys
from dataclasses import fields
from functools import cache
from pathlib import Path
from types import UnionType
from typing import get_args, get_origin, get_type_hints

import pytest
import typer

pytest.importorskip(
    "starlette", reason="the studio needs starlette and uvicorn: pip install dehyst-studio"
)
pytest.importorskip("httpx2", reason="httpx2 stands in for a browser: pip install httpx2")

from starlette.testclient import TestClient

from dehyst.app import Command
from dehyst.cli import add, app, main
from dehyst.errors import ParameterError
from dehyst.io import example_csv
from dehyst_studio.studio._commands import COMMANDS, READ, SIGNALS, WRITTEN, command_words
from dehyst_studio.studio._guard import Guard
from dehyst_studio.studio._server import Studio, application
from test_studio import HERE, MINE, PORT, TOKEN, Scripted

SECRET = "the-content-of-a-file-elsewhere"
OPTIONS = (
    "--overwrite",
    "--out=/tmp/x",
    "-o",
    "--",
    "--json",
    "--help",
    "--version",
    "--log=secret.csv",
)
PATHS = (
    "/etc/passwd",
    "../secret.csv",
    "~/secret.csv",
    "secret.csv",
    "secret.csv\0.csv",
    "C:\\x",
    "file:///etc/passwd",
)
TEXTS = (
    "",
    " ",
    "\x1b[31m",
    "\u202e",
    "\u2028",
    "\n--out=/x\n",
    "\0",
    "\ud800",
    "%s{0}${HOME}`id`$(id)",
    "x" * 20_000,
    "١",
)
NUMBERS = (0, -1, 1.5, 1e400, -0.0, 1e-320, float("nan"), 10**300, 10**4000, True, False)
SCALARS = (*OPTIONS, *PATHS, *TEXTS, *NUMBERS)
LISTS = (
    [], [None], [[]], [{}], [1, 2, 3], [1], ["-4", "4", "--overwrite", "--out=/x"], ["--log=secret.csv", "1"],
    [float("nan"), float("inf")], ["a"] * 5000, [["a", "b"], ["c", "d"]], [True, False], ["\0", "\ud800"],
)  # fmt: skip
OBJECTS = ({}, {"a": 1}, {"--out": "x"})
HOSTILE = (
    *SCALARS,
    *LISTS,
    *OBJECTS,
    *([value] for value in SCALARS),
    *([value, value] for value in SCALARS),
)
FIELDS = [(command, entry.name) for command in COMMANDS for entry in fields(COMMANDS[command])]
FIELDS += [(command, name) for command in COMMANDS for name in ("__class__", "--out", "")]


def _sure(command):
    """What a command needs beside the field that is tried."""
    needed = {
        "log": "a",
        "logs": ["a"],
        "model": "m",
        "models": ["m"],
        "folder": "f",
        "target": "c",
    }
    names = {entry.name for entry in fields(COMMANDS[command])}
    return {name: value for name, value in needed.items() if name in names}


@pytest.fixture(scope="module", autouse=True)
def _signals():
    """The command that the process of the studio adds."""
    before = [*app.registered_commands]
    add(Command("dehyst_studio.studio._signals:print_signals", COMMANDS[SIGNALS]))
    yield
    app.registered_commands[:] = before


@cache
def _parser(name):
    group = typer.main.get_command(app)
    command = group.get_command(group.context_class(group), name)
    return command.make_parser(command.context_class(command, info_name=name))


def _read(words):
    """Command line -> value of every parameter, as click itself reads it."""
    values, _, _ = _parser(words[0]).parse_args(args=[*words[1:]])
    return values


@pytest.mark.parametrize(("command", "name"), FIELDS)
def test_a_hostile_value_sets_its_own_option_or_is_refused(command, name, tmp_path):
    """What click reads from the line differs from that without the value in the field alone."""
    place = {"a": Path("-a.csv"), "m": Path("m.json"), "f": Path("f")}

    def placed(file):
        if not isinstance(file, str) or file not in place:
            raise ParameterError("no such file")
        return place[file]

    sure = _sure(command)
    usual = _read(command_words(command, sure, placed, tmp_path)[0])
    for value in HOSTILE:
        try:
            words, written = command_words(command, sure | {name: value}, placed, tmp_path)
        except ParameterError:
            continue
        if value in ("", []):
            continue  # left out
        values = _read(words)
        others = {key: values.get(key) for key in values | usual if key != name}
        assert others == {key: usual.get(key) for key in others}, value
        assert all(path.parent == tmp_path for path in written.values())
        assert words[0] == command and words.count("--") >= 1


def _kinds(hint):
    return get_args(hint) if isinstance(hint, UnionType) or get_origin(hint) is not tuple else ()


def test_right_values_pass(tmp_path):
    """What the page sends: texts, numbers, pairs, lists."""
    right = {str: "x", int: 3, float: 0.5, bool: True}
    for command in COMMANDS:
        hints = get_type_hints(COMMANDS[command])
        for entry in fields(COMMANDS[command]):
            hint = hints[entry.name]
            kind = next((one for one in (hint, *_kinds(hint)) if one in right), None)
            if kind and entry.name != "json":
                words, _ = command_words(command, {entry.name: right[kind]}, Path, tmp_path)
                assert any(
                    word.startswith("--") and word not in ("--", "--json") for word in words
                ), entry.name


@pytest.fixture
def outside(tmp_path, monkeypatch, tmp_path_factory):
    """A folder with a secret, in which the studio runs, and its own folder within; fails if a file changes outside."""
    (tmp_path / "secret.csv").write_text(
        f"time_s,{SECRET}_bar,angle_deg\n" + "\n".join(f"{k},{k % 9},1" for k in range(99))
    )
    (tmp_path / "own").mkdir()
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("MPLCONFIGDIR", str(tmp_path_factory.mktemp("fonts")))

    def seen():
        there = (
            path for path in tmp_path.rglob("*") if tmp_path / "own" not in (path, *path.parents)
        )
        return {path: path.read_bytes() for path in there if path.is_file()}

    before = seen()
    yield tmp_path
    assert seen() == before


@pytest.mark.parametrize(
    ("command", "tries"),
    [(one, 1) for one in COMMANDS]
    + [pytest.param(one, 20, marks=pytest.mark.slow) for one in COMMANDS],
)
def test_no_body_of_a_command_makes_a_defect(command, tries, outside):
    """Every hostile value by the way that the page takes: answered, never with a status of a defect."""
    workers = Scripted({"status": 2, "said": "LogError: no.", "printed": ""})
    studio = Studio(outside / "own", workers=workers)
    studio.keep(outside / "own" / "a.csv", log=True)
    sure = _sure(command)
    rng = random.Random(f"{command} {tries}")
    names = [name for one, name in FIELDS if one == command]
    names = names if tries > 1 else rng.sample(names, min(6, len(names)))
    with TestClient(Guard(application(studio), port=PORT, token=TOKEN), base_url=HERE) as client:
        for name in names:
            for value in rng.sample(HOSTILE, tries):
                answer = client.post(
                    f"/api/run/{command}", content=_body(sure | {name: value}), headers=MINE
                )
                assert answer.status_code in (200, 400), (name, value)
                answer.json() if answer.status_code == 400 else None
    assert list(studio.folder.iterdir()) == []


def _body(asked):
    return json.dumps(asked).encode()


DEEP = [
    b"[" * 100_000,
    b'{"a":' * 100_000,
    b'{"logs":' + b"[" * 900 + b"]" * 900 + b"}",
    b'{"logs":' + b"[" * 5000,
]
STRANGE = [
    *DEEP,
    b"",
    b"null",
    b"1e999",
    b"NaN",
    b'"x"',
    b"\xff\xfe",
    b"\0",
    b"{}" + b" " * (1 << 21),
    b'{"a":1,"a":2}',
]


@pytest.mark.parametrize("body", STRANGE, ids=range(len(STRANGE)))
def test_a_body_that_is_no_request_is_refused(body, outside):
    studio = Studio(outside / "own", workers=Scripted())
    with TestClient(Guard(application(studio), port=PORT, token=TOKEN), base_url=HERE) as client:
        for path in ("identify", "nothing"):
            assert client.post(f"/api/run/{path}", content=body, headers=MINE).status_code == 400
    assert list(studio.folder.iterdir()) == [] and studio.workers.words == []


@pytest.mark.parametrize(
    "name",
    ["x", "%00", "..%2f..%2fetc%2fpasswd", "%2fetc%2fpasswd", "\u202e", "x" * 3000, "%ed%a0%80"],
)
def test_a_name_that_the_studio_did_not_give_is_refused(name, outside):
    studio = Studio(outside / "own", workers=Scripted())
    with TestClient(Guard(application(studio), port=PORT, token=TOKEN), base_url=HERE) as client:
        assert client.post(f"/api/run/{name}", content=b"{}", headers=MINE).status_code in (
            400,
            404,
        )
        assert client.get(f"/api/files/{name}", headers=MINE).status_code in (400, 404)
        assert client.get(f"/report/{name}").status_code in (403, 404)
    assert list(studio.folder.iterdir()) == [] and studio.workers.words == []


# ---- by the commands themselves
def _tried(examples):
    """Fields and values whose line the studio lets through, in an order that a seed shuffles."""
    cases = []
    for command, name in FIELDS:
        for value in HOSTILE:
            if name not in READ and name not in WRITTEN:
                cases.append((command, name, value))
    random.Random(35).shuffle(cases)
    return cases[:examples]


@pytest.mark.exhaustive
def test_no_command_reads_or_writes_a_file_elsewhere_or_ends_in_a_traceback(
    outside, monkeypatch, capsys
):
    """The lines of hostile values, run: refused in a sentence, or done, within the folder of the studio."""
    own = outside / "own"
    (own / "a.csv").write_text("\n".join(example_csv(0).splitlines()[:1500]), encoding="utf-8")

    def ran(words):
        monkeypatch.setattr(sys, "argv", ["dehyst", *words])
        with pytest.raises(SystemExit) as end:
            main()
        return int(end.value.code or 0), "".join(capsys.readouterr())

    studio = Studio(own)
    ids = {
        "a": studio.keep(own / "a.csv"),
        "m": studio.keep(own / "m.json"),
        "f": studio.keep(own / "code"),
    }
    shared = ["--family=static", "--json", "--", str(own / "a.csv")]
    assert ran(["identify", f"--save={own / 'm.json'}", *shared])[0] == 0
    assert (
        ran(["export", "--target=c", f"--out={own / 'code'}", "--json", "--", str(own / "m.json")])[
            0
        ]
        == 0
    )
    lines = 0
    for command, name, value in _tried(int(os.environ.get("STUDIO_EXAMPLES", "2000"))):
        if command == "verify":
            continue  # compiles; its one field is the id of a folder
        room = studio.room()
        asked = {key: [ids[one] for one in file] if isinstance(file, list) else ids.get(file, file)
                 for key, file in _sure(command).items()}  # fmt: skip
        if command == "identify":
            asked |= {"family": "static"}  # quick
        if command == "compare":
            asked |= {"families": "static"}
        try:
            words, _ = command_words(command, asked | {name: value}, studio.place, room)
        except ParameterError:
            continue
        status, printed = ran(words)
        assert status in (0, 1, 2), (command, name, value, printed[-2000:])
        assert "Traceback" not in printed and SECRET not in printed, (command, name, value)
        lines += 1
    assert lines > 100
