"""The routes of the studio: the page, logs that were dropped on it, commands, and the files that they wrote.

Private, because it is the one module that cannot be imported without the extra `studio`.
"""

from __future__ import annotations

import asyncio
import errno
import json
import re
import secrets
import shutil
import signal
import socket
import time
from collections.abc import AsyncIterator, Callable, Mapping
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import uvicorn
from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.requests import ClientDisconnect, Request
from starlette.responses import (
    FileResponse,
    HTMLResponse,
    JSONResponse,
    Response,
    StreamingResponse,
)
from starlette.routing import Route

from dehyst.app import Status
from dehyst.errors import DehystError, OutputError, ParameterError
from dehyst.shell import command as line_of
from dehyst.shell import typed, visible, visible_lines
from dehyst.version import __version__
from dehyst_studio.studio._commands import SIGNALS, command_words
from dehyst_studio.studio._guard import ENTER, Guard
from dehyst_studio.studio._work import Workers

PAGE = Path(__file__).parents[1] / "html" / "dehyst.html"
LIMIT = (
    1 << 30
)  # bytes of a log that is dropped on the page; a larger one is named on the command line, and not copied
SHOWN = 255  # characters of a file name that are shown
LONGEST = 120  # bytes of a file name; the smallest limit of a file system that is in use is 143, of an encrypted one
BODY = 1 << 20  # bytes of a request that names what to do
TICK = 0.25  # s from one look at what has changed to the next
BEAT = 15.0  # seconds from one sign of life to the next
# Reports are pages with a script of their own: they get an origin of their own too, and cannot call the studio.
REPORT = {"content-security-policy": "sandbox allow-scripts allow-downloads allow-popups"}


@dataclass
class Studio:
    """What lasts from one request to the next: files by their id, processes, and how many pages are open."""

    folder: Path
    idle: float = 0.0  # s
    token: str = ""
    limit: int = LIMIT
    files: dict[str, Path] = field(default_factory=dict)
    names: dict[Path, str] = field(
        default_factory=dict
    )  # as it was dropped, of a log whose file has another name
    logs: list[str] = field(default_factory=list)
    refused: set[str] = field(default_factory=set)  # logs that cannot be read
    workers: Workers = field(default_factory=Workers)
    pages: int = 0
    left: float = field(default_factory=time.monotonic)
    leave: Callable[[], None] = lambda: None
    leaving: Callable[[], bool] = lambda: False  # by Ctrl-C too

    def keep(self, path: Path, log: bool = False) -> str:
        """Return the id of a file; whoever knows it, and may ask, gets the file."""
        name = secrets.token_urlsafe(12)
        self.files[name] = path
        if log:
            self.logs.append(name)
        return name

    def place(self, name: object) -> Path:
        """Path of an id."""
        if not isinstance(name, str):
            raise ParameterError(
                "the studio knows a file by its id, which is a text. Open the log again."
            )
        if name not in self.files:
            raise ParameterError(
                f"the studio has no file '{name:.40}' any more. Open the log again."
            )
        return self.files[name]

    def called(self, path: Path) -> str:
        """Name of a file for people."""
        return visible(self.names.get(path, path.name))

    def room(self) -> Path:
        """Make a new folder for what a command writes."""
        made = self.folder / secrets.token_hex(8)
        made.mkdir(mode=0o700)
        return made

    def about(self, name: str) -> dict[str, Any]:
        """Id, name and size of a log, and whether it was found that it cannot be read."""
        path = self.files[name]
        size = path.stat().st_size if path.exists() else 0
        return {
            "id": name,
            "name": self.called(path),
            "bytes": size,
            "refused": name in self.refused,
        }

    async def watch(self) -> None:
        """End when no page was open and nothing ran for so long; stop what runs when the studio ends."""
        while not self.leaving():
            await asyncio.sleep(TICK if self.idle == 0.0 else min(TICK, self.idle / 4.0))
            if self.pages or self.workers.busy:
                self.left = time.monotonic()
            elif 0.0 < self.idle < time.monotonic() - self.left:
                self.leave()
                return
        await self.workers.end()


def serve(
    listener: socket.socket, token: str, folder: Path, *, key: str, log: Path | None, idle: float
) -> None:
    """Serve until Ctrl-C, SIGTERM, SIGHUP, or until no page was open for `idle` seconds (0: never).

    `key` gives the token once.
    """
    studio = Studio(folder, idle, token)
    if log is not None:
        studio.keep(log, log=True)
    guard = Guard(application(studio), port=listener.getsockname()[1], token=token, key=key)
    server: Any = uvicorn.Server(
        uvicorn.Config(
            guard,
            log_config=None,
            log_level="error",
            access_log=False,
            server_header=False,
            proxy_headers=False,  # nobody stands between: what a header says of the client would be a lie
            timeout_graceful_shutdown=5,
        )
    )

    def leave(*_: object) -> None:
        server.should_exit = True

    studio.leave, studio.leaving = leave, lambda: bool(server.should_exit)
    server.handle_exit = (
        leave  # of SIGINT and SIGTERM, each as often as it comes: its own would tear the rest down
    )
    if hasattr(signal, "SIGHUP"):
        signal.signal(signal.SIGHUP, leave)
    server.run(sockets=[listener])


def application(studio: Studio) -> Starlette:
    """Return the routes over a studio, without the guard."""
    routes: Mapping[tuple[str, str], Callable[[Studio, Request], Any]] = {
        ("GET", "/"): page,
        ("GET", "/report/{id}"): report,
        ("POST", ENTER): enter,
        ("GET", "/api/state"): state,
        ("GET", "/api/alive"): alive,
        ("POST", "/api/logs"): take,
        ("GET", "/api/files/{id}"): give,
        ("POST", "/api/run/{command}"): answer_run,
    }

    def bound(answer: Callable[[Studio, Request], Any]) -> Callable[[Request], Any]:
        async def answered(request: Request) -> Response:
            made: Response = await answer(studio, request)
            return made

        return answered

    @asynccontextmanager
    async def life(_: Starlette) -> AsyncIterator[None]:
        tasks = [asyncio.ensure_future(work) for work in (studio.workers.prepare(), studio.watch())]
        try:
            yield
        finally:
            for task in tasks:
                task.cancel()
            await studio.workers.end()

    return Starlette(
        routes=[
            Route(path, bound(answer), methods=[method])
            for (method, path), answer in routes.items()
        ],
        exception_handlers={DehystError: _refused},
        lifespan=life,
    )


async def _refused(_: Request, fault: Exception) -> Response:
    return JSONResponse(
        {"error": visible_lines(fault), "kind": type(fault).__name__}, status_code=400
    )


async def page(studio: Studio, request: Request) -> Response:
    """The page that is also a file of its own; served, it may call this server, and shows what only Python can do."""
    text = PAGE.read_text(encoding="utf-8")
    text = text.replace("default-src 'none';", "default-src 'none'; connect-src 'self';", 1)
    return HTMLResponse(
        text.replace("<title>", '<meta name="dehyst-studio" content="">\n<title>', 1)
    )


async def report(studio: Studio, request: Request) -> Response:
    """A report page, by its id alone: a tab that is opened sends no token."""
    path = studio.files.get(request.path_params["id"])
    if path is None or path.suffix != ".html" or not path.is_file():
        return Response(
            "There is no such report, or the studio that made it has ended.", status_code=403
        )
    return FileResponse(path, media_type="text/html", headers=REPORT)


async def enter(studio: Studio, request: Request) -> Response:
    """The token, for the page that was opened with the key: the guard lets one in."""
    return JSONResponse({"token": studio.token})


async def state(studio: Studio, request: Request) -> Response:
    """What the page needs to know at its start."""
    return JSONResponse(await run_in_threadpool(_state, studio))


def _state(studio: Studio) -> dict[str, Any]:
    from dehyst.export import kit as export_kit
    from dehyst.families import title_of
    from dehyst.identification import INITIAL_STATES, all_names
    from dehyst.units import TABLE

    return {
        "version": __version__,
        "logs": [studio.about(name) for name in studio.logs],
        "limit": studio.limit,
        "starts": INITIAL_STATES,
        "units": [*TABLE["time"]],
        "families": [{"name": name, "title": title_of(name)} for name in all_names()],
        "targets": [
            {"name": target.name, "summary": target.summary, "reals": target.reals}
            for target in export_kit.targets().values()
        ],
    }


async def alive(studio: Studio, request: Request) -> Response:
    """An answer that lasts as long as the page is open."""

    async def beats() -> AsyncIterator[str]:
        studio.pages += 1
        try:
            last = 0.0
            while not studio.leaving():
                if time.monotonic() - last > BEAT:
                    last = time.monotonic()
                    yield "\n"
                await asyncio.sleep(TICK)
        finally:
            studio.pages -= 1
            studio.left = time.monotonic()

    return StreamingResponse(beats(), media_type="text/plain")


async def take(studio: Studio, request: Request) -> Response:
    """Keep a log that was dropped on the page, or nothing of it."""
    shown = _file_name(request.query_params.get("name", ""))
    announced = request.headers.get("content-length", "")
    if announced.isdecimal() and float(announced) > studio.limit:
        return _too_large(studio, shown)
    room, size = studio.room(), 0
    path = room / _stored(shown)
    is_whole = False
    try:
        with path.open("wb") as stream:
            async for part in request.stream():
                size += len(part)
                if size > studio.limit:
                    return _too_large(studio, shown)
                stream.write(part)
        is_whole = True
    except ClientDisconnect:
        return Response(status_code=400)  # nobody reads it
    except OSError as fault:
        is_full = fault.errno in NO_SPACE
        cure = "Free some space" if is_full else "Rename it"
        words = f"'{shown}' could not be kept: {fault.strerror}. {cure}, or type: {line_of('studio', shown)}"
        return JSONResponse(
            {"error": words, "kind": "OutputError"}, status_code=507 if is_full else 400
        )
    finally:
        if not is_whole:
            shutil.rmtree(room, ignore_errors=True)
    studio.names[path] = shown
    return JSONResponse(studio.about(studio.keep(path, log=True)))


NO_SPACE = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)


def _too_large(studio: Studio, name: str) -> Response:
    words = (
        f"'{name}' has more than {studio.limit >> 20} MB, the most that the page copies. Name it on the command line, "
        f"where it is read in place: {line_of('studio', name)}"
    )
    return JSONResponse({"error": words, "kind": "LogError"}, status_code=413)


def _file_name(text: str) -> str:
    """The last part of a path, printable; it appears in messages and reports.

    Examples
    --------
    >>> _file_name("C:\\\\logs/../elbow 3.csv"), _file_name(".."), _file_name("a\\nb.csv")
    ('elbow 3.csv', 'log.csv', 'ab.csv')
    """
    last = "".join(
        letter for letter in text.replace("\\", "/").split("/")[-1] if letter.isprintable()
    )
    return last[-SHOWN:].strip(". ") or "log.csv"


def _stored(name: str) -> str:
    """Name of the file that holds a log: as short as file systems want it, its ending as it is.

    Examples
    --------
    >>> _stored("elbow: 3.csv"), len(_stored("\\U0001f600" * 70 + ".csv").encode())
    ('elbow_ 3.csv', 120)
    """
    plain = re.sub(r'[<>:"|?*]', "_", name)  # what Windows allows in no name
    short = plain.encode()[-LONGEST:].decode(errors="ignore")
    return short.strip(". ") or "log.csv"


async def give(studio: Studio, request: Request) -> Response:
    """A file that was kept or written."""
    path = studio.place(request.path_params["id"])
    if not path.is_file():
        raise OutputError(
            f"there is no file '{studio.called(path)}' any more, or it is a folder.", path=str(path)
        )
    return FileResponse(path, filename=studio.called(path))


async def _told(request: Request) -> dict[str, Any]:
    """The JSON object of a request; no more of it is read than is allowed."""
    body = b""
    async for part in request.stream():
        body += part
        if len(body) > BODY:
            break
    try:
        asked = None
        # A body beyond the limit was not read to its end.
        if len(body) <= BODY:
            asked = json.loads(body)
    except (ValueError, RecursionError):
        asked = None
    if not isinstance(asked, dict):
        raise ParameterError(
            f"the body of a command is a JSON object, option -> value, of at most {BODY >> 20} MB."
        )
    return asked


async def answer_run(studio: Studio, request: Request) -> Response:
    """Run a command; the answer is a line of JSON an event: the command, its progress, its result or error.

    Whoever closes the connection stops the command.
    """
    try:
        asked = await _told(request)
    except ClientDisconnect:
        return Response(status_code=400)  # nobody reads it
    command, room = request.path_params["command"], studio.room()
    try:
        words, written = command_words(command, asked, studio.place, room)
    except DehystError:
        room.rmdir()
        raise

    async def events() -> AsyncIterator[str]:
        succeeded = False
        try:
            if command != SIGNALS:
                yield _line({"command": _shown(words, studio)})
            async for event in studio.workers.run(words):
                if "status" in event and studio.leaving():
                    break  # it was killed because the studio ends, which the page says by itself
                if "status" in event:
                    event = await run_in_threadpool(_ended, studio, event, written)
                    succeeded = "result" in event
                    if command == "inspect":
                        log = str(asked.get("log"))
                        if succeeded:
                            studio.refused.discard(log)
                        else:
                            studio.refused.add(log)
                    elif (
                        command == "verify" and succeeded
                    ):  # which writes its record into the folder
                        await run_in_threadpool(_packed, Path(words[-1]))
                yield _line(event)
        finally:
            if not succeeded:
                shutil.rmtree(room, ignore_errors=True)
            if not studio.leaving():
                await studio.workers.prepare()

    return StreamingResponse(events(), media_type="application/x-ndjson")


def _line(event: dict[str, Any]) -> str:
    return json.dumps(event, allow_nan=False) + "\n"


def _shown(words: list[str], studio: Studio) -> str:
    """The same in a terminal: what lies in the temporary folder has its bare name."""

    def bare(path: str) -> str:
        if studio.folder in Path(path).parents:
            return studio.called(Path(path))
        return path

    cut = words.index("--")
    options = []
    for word in words[1:cut]:
        flag, sign, value = word.partition("=")
        if word != "--json":
            options.append(f"{flag}{sign}{bare(value)}")
    return f"{line_of(words[0], *map(bare, words[cut + 1 :]))} {typed(options)}".rstrip()


def _ended(studio: Studio, event: dict[str, Any], written: Mapping[str, Path]) -> dict[str, Any]:
    """Result and files of a command, or its own words on why there is none."""
    try:
        result = json.loads(event["printed"])
    except ValueError:
        result = None
    if result is None or event["status"] not in (Status.DONE, Status.NO):
        kind, _, words = (
            visible(event["said"]).partition(": ")
            if event["status"] == Status.REFUSED
            else ("", "", "")
        )
        words = words or event["said"] or f"the command ended with status {event['status']}"
        return {"error": words, "kind": kind or "Defect"}
    files = {}
    for name, path in written.items():
        if path.is_dir():
            named = path.rename(path.with_name(str(result["name"])))
            files["folder"] = studio.keep(named)
            files["zip"] = studio.keep(_packed(named))
        elif path.exists():
            files[name] = studio.keep(path)
    return {"result": result, "files": files}


def _packed(folder: Path) -> Path:
    """Archive of a folder, beside it; an older one is replaced."""
    return Path(shutil.make_archive(str(folder), "zip", folder.parent, folder.name))
