"""Whatever is interrupted, by Ctrl-C, a kill or a full disk, at any rename or write: the old or the new is whole."""

import errno
import os
import shutil
import signal
import stat
import sys
import time
from pathlib import Path

import pytest

import dehyst
import dehyst_robot
from command_samples import COMMANDS, PAIR, QUICK, X, make_folder, stand_in
from dehyst.errors import OutputError
from dehyst.export import _exchange as exchange
from dehyst.export import export, subject_of
from dehyst.export._folder import contents
from dehyst.files import write_atomically
from dehyst.models import ModelCard, SignalCard

posix = pytest.mark.skipif(os.name != "posix", reason="devices, modes and signals of POSIX")


class Killed(BaseException):
    """The process is no more: from now on nothing changes any file."""


class Faults:
    """Counts what changes files below a folder, and lets the n-th of these fail."""

    EVENTS = (
        "open",
        "os.rename",
        "os.remove",
        "os.mkdir",
        "os.rmdir",
        "os.link",
        "os.chmod",
        "os.chown",
    )

    def __init__(self):
        self.below, self.at, self.kind, self.count, self.opened = None, 0, None, 0, []
        sys.addaudithook(self.hear)

    def hear(self, event, arguments):
        if self.below is None or event not in self.EVENTS:
            return
        place = arguments[0]
        if not isinstance(place, str | bytes | os.PathLike) or self.below not in os.fsdecode(place):
            return
        if event == "open":
            if not (arguments[2] or 0) & (os.O_WRONLY | os.O_RDWR | os.O_CREAT):
                return
            self.opened.append(os.fsdecode(place))
        self.step()

    def step(self):
        if self.below is None:
            return
        self.count += 1
        if self.count == self.at or (self.kind is Killed and 0 < self.at <= self.count):
            raise (
                OSError(errno.ENOSPC, "No space left on device")
                if self.kind is OSError
                else self.kind()
            )

    def run(self, below, work, at=0, kind=None):
        """Do the work with the n-th change failing; tell whether it came so far."""
        self.below, self.at, self.kind, self.count, self.opened = str(below), at, kind, 0, []
        try:
            work()
        except (KeyboardInterrupt, Killed, OutputError):
            pass
        finally:
            self.below = None
        return self.count


FAULTS = Faults()


@pytest.fixture
def faults(monkeypatch):
    """The faults, with what Python tells no hook of: fsync and the exchange of two folders."""
    for module, name in ((os, "fsync"), (exchange, "_exchange")):
        real = getattr(module, name)

        def told(*arguments, real=real):
            FAULTS.step()
            real(*arguments)
            FAULTS.step()

        monkeypatch.setattr(module, name, told)
    return FAULTS


KINDS = (KeyboardInterrupt, Killed, OSError)
CARD = ModelCard(SignalCard("p", "bar", -1.0, 1.0), SignalCard("angle", "deg", -2.0, 2.0))


# One file.


@pytest.mark.parametrize("kind", KINDS)
def test_a_file_is_the_old_or_the_new_one_wherever_its_writing_ends(faults, tmp_path, kind):
    path = tmp_path / "model.json"
    steps = faults.run(tmp_path, lambda: write_atomically(path, "new"))
    assert steps >= 5
    for at in range(1, steps + 1):
        path.write_text("old")
        faults.run(tmp_path, lambda: write_atomically(path, "new"), at, kind)
        assert path.read_text() in ("old", "new")
        if kind is KeyboardInterrupt and at > 2:
            assert [each.name for each in tmp_path.iterdir()] == ["model.json"]
        write_atomically(path, "new")
        assert path.read_text() == "new"
        for left in tmp_path.glob(".*"):
            left.unlink()


WRITING = {
    "example": ("--out", "made.csv"),
    "identify": ("--save", "made.json"),
    "coupled": ("--save", "made.json"),
    "compare": ("--save", "made.json"),
    "simulate": ("--out", "made.csv"),
    "compensate": ("--out", "made.csv"),
    "drift": ("--report", "made.html"),
    "export": (),
    "verify": (),
    "muscle": ("--save", "made.json"),
    "design": ("--out", "made.csv"),
    "backlash": ("--sheet", "made.csv", "--gcode", "made.ngc"),
    "valve": ("--test", "made.csv"),
    "magnet": ("--out", "made.cir"),
    "battery": ("--out", "made.py"),
    "sweep": ("--out", "made.csv", "--figure", "made.svg"),
    "reproduce": ("--out", "made", "--json", "made.json"),
}
FIT = (
    "muscle",
    "chou-hannaford",
    "--log",
    "bench.csv",
    "--contraction",
    "contraction",
    "--length",
    "0.3",
)


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    place = make_folder(tmp_path_factory.mktemp("interrupted"))
    there_and_back = [0.01 * k for k in (*range(20), *range(20, 0, -1))]
    rows = [
        f"{at},{bar},{100 * bar * (1 - 3 * at):.3f}" for bar in (1, 2, 3) for at in there_and_back
    ]
    (place / "bench.csv").write_text("contraction,pressure_bar,force_N\n" + "\n".join(rows) + "\n")
    return place


@pytest.mark.slow
@pytest.mark.parametrize("name", WRITING)
def test_no_command_opens_a_file_of_the_user_to_write_into_it(faults, run, made, monkeypatch, name):
    monkeypatch.chdir(made)
    stand_in(monkeypatch)
    words = (*(FIT if name == "muscle" else COMMANDS[name]), *WRITING[name])
    words = (*words, "--overwrite") if name != "verify" else words
    assert run(*words)[0] in (0, 4)
    there = {str(path) for path in made.rglob("*") if path.is_file()}
    ended = []
    monkeypatch.setattr(
        dehyst_robot.commands._sweep, "run_sweep", dehyst_robot.commands._sweep.run_sweep
    )
    faults.run("", lambda: ended.append(run(*words)[0]))
    assert ended[0] in (0, 4)
    opened = {str(Path(path).absolute()) for path in faults.opened}
    assert faults.count > 3 and not opened & there


# A model of the user.


@pytest.mark.slow
def test_another_model_is_not_replaced_by_save_unless_it_is_said(run, made, tmp_path, monkeypatch):
    monkeypatch.chdir(made)
    for name, words, other in (
        ("i.json", ("identify", "log.csv", *PAIR, *QUICK), ("--eps", "0.02")),
        ("c.json", ("compare", "log.csv", *PAIR, "--families", "pi"), ("--train-fraction", "0.8")),
        ("m.json", FIT, ("--length", "0.31")),
    ):
        model = tmp_path / name
        for _ in range(2):  # the same content loses nothing
            status, _, err = run(*words, "--save", model)
            assert status == 0, err
        before = model.read_bytes()
        status, _, err = run(*words, *other, "--save", model)
        assert status == 2 and "holds another model" in err and "--overwrite" in err
        assert model.read_bytes() == before
        assert run(*words, *other, "--save", model, "--overwrite")[0] == 0
        assert model.read_bytes() != before


OTHERS = (
    ("identify", ("identify", "log.csv", *PAIR, *QUICK), ("identify", "worn.csv", *PAIR, *QUICK)),
    (
        "identify",
        ("identify", "log.csv", *PAIR, *QUICK),
        ("identify", "log.csv", *PAIR, "--family", "stop"),
    ),
    (
        "identify",
        ("identify", "log.csv", *PAIR, *QUICK),
        ("identify", "log.csv", *PAIR, *QUICK, "--eps", "0.02"),
    ),
    (
        "identify",
        ("identify", "log.csv", *PAIR, *QUICK),
        ("identify", "log.csv", *PAIR, *QUICK[:-1], "20"),
    ),
    (
        "compare",
        ("compare", "log.csv", *PAIR, "--families", "pi"),
        ("compare", "worn.csv", *PAIR, "--families", "pi"),
    ),
    ("muscle", FIT, [word.replace("bench", "other") for word in FIT]),
)


@pytest.mark.parametrize(
    ("name", "words", "other"),
    [*OTHERS[:-2], *(pytest.param(*other, marks=pytest.mark.slow) for other in OTHERS[-2:])],
)
def test_what_cannot_be_the_model_that_is_there_is_refused_before_the_work(
    run, made, tmp_path, monkeypatch, name, words, other
):
    monkeypatch.chdir(made)
    (made / "other.csv").write_text((made / "bench.csv").read_text().replace("0.01", "0.011"))
    model = tmp_path / "m.json"
    words = (*words, "--eps", "0.01") if "0.02" in other else words
    assert run(*words, "--save", model)[0] == 0
    before = model.read_bytes()
    reads = {"identify": "read_logs", "compare": "read_logs", "muscle": "read_bench_log"}
    commands = dehyst_robot.commands if name == "muscle" else dehyst.app
    monkeypatch.setattr(
        getattr(commands, f"_{name}"), reads[name], lambda *_: pytest.fail("it was read")
    )
    status, _, err = run(*other, "--save", model)
    assert status == 2 and "holds another model" in err and "--overwrite" in err
    assert model.read_bytes() == before


def test_a_place_where_nothing_can_be_written_is_refused_before_the_work(
    run, made, tmp_path, monkeypatch
):
    monkeypatch.chdir(made)
    monkeypatch.setattr(dehyst.app._identify, "read_logs", lambda *_: pytest.fail("it was read"))
    (tmp_path / "file").write_text("mine")
    for option, place in (
        ("--save", ""),
        ("--save", "no/m.json"),
        ("--report", "file/r.html"),
        ("--figures", "file"),
    ):
        status, _, err = run("identify", "log.csv", *PAIR, option, tmp_path / place)
        assert status == 2 and "cannot write" in err


# What is no plain file, modes and owners.


@posix
def test_a_device_and_a_pipe_stay_what_they_are(run, made, tmp_path, monkeypatch):
    monkeypatch.chdir(made)
    fifo = tmp_path / "fifo"
    os.mkfifo(fifo)
    reader = os.open(fifo, os.O_RDONLY | os.O_NONBLOCK)
    assert (
        run("simulate", "model.json", "log.csv", "--input", X, "--to", "9", "--out", fifo)[0] == 0
    )
    assert os.read(reader, 20).startswith(b"time [s],") and stat.S_ISFIFO(fifo.stat().st_mode)
    os.close(reader)
    (tmp_path / "null").symlink_to(os.devnull)
    assert run("example", "--out", tmp_path / "null")[0] == 0
    assert (tmp_path / "null").is_symlink() and Path(os.devnull).is_char_device()


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no device that is always full")
def test_a_full_device_is_named_and_stays_one(run, made, monkeypatch, tmp_path):
    link = tmp_path / "full"
    link.symlink_to("/dev/full")
    status, _, err = run("example", "--out", link, "--overwrite")
    assert status == 2 and "No space left on device" in err
    assert Path("/dev/full").is_char_device() and link.is_symlink()


@posix
def test_a_link_stays_and_what_it_points_to_is_written(tmp_path):
    (tmp_path / "far").mkdir()
    target, link = tmp_path / "far" / "model.json", tmp_path / "model.json"
    link.symlink_to(target)
    for text in ("first", "second"):
        write_atomically(link, text)
        assert link.is_symlink() and target.read_text() == text
    assert [each.name for each in target.parent.iterdir()] == ["model.json"]


@posix
@pytest.mark.parametrize("mode", [0o600, 0o640, 0o664, 0o755])
def test_a_file_keeps_its_mode_and_owner(tmp_path, mode):
    path = tmp_path / "secret.json"
    path.write_text("old")
    path.chmod(mode)
    if os.geteuid() == 0:
        os.chown(path, 12345, 23456)
    before = path.stat()
    write_atomically(path, "new")
    after = path.stat()
    assert (after.st_mode, after.st_uid, after.st_gid) == (
        before.st_mode,
        before.st_uid,
        before.st_gid,
    )


@posix
@pytest.mark.skipif(
    os.name == "posix" and os.geteuid() == 0, reason="nothing is protected from root"
)
def test_a_protected_file_is_refused(tmp_path):
    path = tmp_path / "mine.json"
    path.write_text("old")
    path.chmod(0o444)
    with pytest.raises(OutputError, match="protected"):
        write_atomically(path, "new")
    assert path.read_text() == "old"


# A folder.

OLD = {"manifest.json": b"old", "src/a.c": b"old", "src/old/only.c": b"old"}
NEW = {"manifest.json": b"new", "src/a.c": b"new", "src/b.c": b"new"}
MINE = {"notes.txt": b"mine", "src/mine.c": b"mine", "build/deep/x.o": b"mine"}


def content(folder):
    """Relative name -> bytes of the files of a folder; what a call in it left for the next one aside."""
    found = {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file()
    }
    return {name: data for name, data in found.items() if not name.startswith(".dehyst-")}


def begin(folder):
    for left in folder.parent.iterdir():
        shutil.rmtree(left)
    for name, data in {**OLD, **MINE}.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(data)


def no_exchange(*_):
    raise OSError(errno.EINVAL, "not here")


@pytest.mark.slow
@posix
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("way", ["exchanged", "inside"])
def test_a_folder_is_the_old_or_the_new_one_wherever_its_writing_ends(
    faults, tmp_path, monkeypatch, way, kind
):
    folder = tmp_path / "out"
    if way == "inside":
        monkeypatch.setattr(exchange, "_exchange", no_exchange)
    begin(folder)
    steps = faults.run(tmp_path, lambda: exchange.put(folder, NEW, OLD))
    assert content(folder) == {**NEW, **MINE} and steps > 20
    seen = set()
    for at in range(1, steps + 1):
        begin(folder)
        faults.run(tmp_path, lambda: exchange.put(folder, NEW, {*OLD, *NEW}), at, kind)
        if way == "inside" and kind is not KeyboardInterrupt:
            assert {*OLD} - {"src/old/only.c"} <= {
                *content(folder)
            }  # nothing is missing even before the repair
            exchange.repair(folder)
        assert content(folder) in ({**OLD, **MINE}, {**NEW, **MINE}), at
        seen.add(content(folder)["manifest.json"])
        exchange.repair(folder)
        exchange.put(folder, NEW, {*OLD, *NEW})
        assert content(folder) == {**NEW, **MINE}
        assert [path.name for path in tmp_path.iterdir()] == ["out"]
        assert not list(folder.glob(".dehyst-*"))
    assert b"new" in seen


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork")
def test_a_kill_at_any_moment_leaves_one_whole_export(tmp_path):
    folder = tmp_path / "out"
    begin(folder)
    for at in range(12):
        child = os.fork()
        if child == 0:
            for k in range(10**6):
                text = str(k % 10).encode()
                exchange.put(folder, dict.fromkeys(NEW if k % 2 else OLD, text), {*OLD, *NEW})
            os._exit(0)
        time.sleep(0.003 + 0.007 * at)
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
        exchange.repair(folder)
        found = {name: data for name, data in content(folder).items() if name not in MINE}
        assert {*found} in ({*OLD}, {*NEW}) and len(set(found.values())) == 1
        assert {name: content(folder)[name] for name in MINE} == MINE
        assert [path.name for path in tmp_path.iterdir()] == ["out"]


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork")
def test_exports_at_once_into_one_folder_are_written_one_after_another(tmp_path):
    model = dehyst.PrandtlIshlinskii([0.0, 0.5], [1.0, 1.0], card=CARD)
    subject, folder = subject_of(model, name="unit_1"), tmp_path / "out"
    whole = {target: {*contents(subject, target)} for target in ("st", "c-header")}
    children = []
    for target in 2 * list(whole):
        child = os.fork()
        if child == 0:
            try:
                for _ in range(15):
                    export(subject, target, folder)
            except BaseException as fault:
                print(fault, file=sys.stderr, flush=True)
                os._exit(1)
            os._exit(0)
        children.append(child)
    assert [os.waitpid(child, 0)[1] for child in children] == [0, 0, 0, 0]
    assert {*content(folder)} in whole.values()
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


def test_a_forged_repair_reaches_nothing_outside(tmp_path):
    folder = tmp_path / "out"
    begin(folder)
    (tmp_path / "precious").write_text("mine")
    (folder / exchange.WHOLE / "new").mkdir(parents=True)
    (folder / exchange.WHOLE / exchange.GONE).write_text('["../precious"]')
    with pytest.raises(OutputError, match="outside"):
        exchange.repair(folder)
    assert (tmp_path / "precious").read_text() == "mine"
