"""How a command ends: one status for each meaning, one line and no traceback, whatever happens to it."""

import gc
import io
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from command_samples import COMMANDS, make_folder, stand_in
from dehyst.app import Status, concluding

posix = pytest.mark.skipif(os.name != "posix", reason="pipes and devices of POSIX")
full = pytest.mark.skipif(not Path("/dev/full").exists(), reason="no device that is always full")
LIMIT = 10_000_000  # bytes of a file: more than any command of these tests writes
VERDICTS = {
    ("verify", "st"): Status.DONE,
    ("verify", "st", "--json"): Status.DONE,
    ("verify", "edited"): Status.NO,
    ("verify", "edited", "--json"): Status.NO,
    ("drift", "model.json", "log.csv"): Status.CANNOT_TELL,
    ("drift", "model.json", "worn.csv", "--reference", "log.csv"): Status.NO,
    ("drift", "model.json", "worn.csv", "--reference", "log.csv", "--json"): Status.NO,
    ("drift", "model.json", "small.csv", "--reference", "log.csv"): Status.NOT_COMPARABLE,
    ("backlash", "table", "axis.csv", "--machine", "klipper"): Status.NO,
}
REFUSED = (
    ("inspect", "nowhere.csv"),
    ("inspect",),
    ("nonsense",),
    ("verify", "."),
    ("drift", "log.csv", "log.csv"),
    ("export", "model.json", "--target", "cobol", "--out", "made"),
    ("example", "--out", "no/such/folder.csv"),
    ("muscle", "nobody"),
)


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    place = make_folder(tmp_path_factory.mktemp("ending"))
    shutil.copytree(place / "st", place / "edited")
    (place / "edited" / "unit_1.st").write_text("(* not what was exported *)")
    return place


@pytest.fixture
def here(made, tmp_path, monkeypatch):
    """The folder, a copy for each test, with `sweep` and `reproduce` made quick."""
    place = shutil.copytree(made, tmp_path / "here")
    monkeypatch.chdir(place)
    stand_in(monkeypatch)
    return place


def test_a_command_looks_for_garbage_but_not_among_what_was_loaded(run, tmp_path):
    gc.unfreeze()
    run("example", "--out", tmp_path / "first.csv")
    assert gc.get_freeze_count() == 0
    gc.disable()  # as `python -m dehyst` begins
    try:
        run("example", "--out", tmp_path / "second.csv")
        assert gc.isenabled() and gc.get_freeze_count() > 0
    finally:
        gc.unfreeze()
        gc.enable()


@pytest.fixture
def onto(monkeypatch, run):
    """Run a command with its standard output going elsewhere: into a pipe that nobody reads, or to a full disk."""

    def command(where, *words):
        if where == "pipe":
            read, number = os.pipe()
            os.close(read)
        elif where == "part":
            return nearly_full(*words)
        else:
            number = os.open("/dev/full", os.O_WRONLY)
        with monkeypatch.context() as patch, open(number, "w") as stream:  # noqa: PTH123
            patch.setattr(sys, "stdout", stream)
            status, _, err = run(*words)
        return status, err

    def nearly_full(*words):
        """Onto a file that takes 10 bytes more, by a stream as Python makes it with PYTHONUNBUFFERED."""
        import resource

        before = resource.getrlimit(resource.RLIMIT_FSIZE)
        with monkeypatch.context() as patch, Path("part").open("wb", buffering=0) as raw:
            raw.seek(LIMIT - 10)
            stream = io.TextIOWrapper(
                raw, write_through=True
            )  # kept, as the interpreter keeps its own
            patch.setattr(sys, "stdout", stream)
            resource.setrlimit(resource.RLIMIT_FSIZE, (LIMIT, before[1]))
            try:
                status, _, err = run(*words)
            finally:
                resource.setrlimit(resource.RLIMIT_FSIZE, before)
        return status, err

    return command


def test_every_command_is_among_those_that_are_tried():
    from dehyst.cli import add_packages, app

    add_packages()

    assert set(COMMANDS) == {each.callback.__name__ for each in app.registered_commands}


# One status for each meaning.


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(COMMANDS.keys() - {"drift", "watch"}))
def test_what_worked_ends_with_0(run, here, name):
    assert run(*COMMANDS[name])[0] == Status.DONE


@pytest.mark.slow
@pytest.mark.parametrize(("words", "status"), VERDICTS.items(), ids=map(" ".join, VERDICTS))
def test_a_verdict_is_the_status(run, here, words, status):
    assert run(*words)[0] == status


@pytest.mark.parametrize("words", REFUSED, ids=" ".join)
def test_what_is_refused_ends_with_2_and_prints_nothing(run, here, words):
    status, out, err = run(*words)
    assert (status, out) == (Status.REFUSED, "") and err


def test_a_defect_is_no_verdict(here, monkeypatch, capsys):
    from dehyst import cli

    monkeypatch.setattr("dehyst.app._inspect.inspect_log", lambda *_, **__: 1 / 0)
    monkeypatch.setattr(sys, "argv", ["dehyst", "inspect", "log.csv"])
    with pytest.raises(SystemExit) as ended:
        cli.main()
    assert ended.value.code == Status.DEFECT and "ZeroDivisionError" in capsys.readouterr().err


def test_no_two_meanings_share_a_status_and_none_is_one_that_python_or_the_shell_gives():
    assert (
        len({status.meaning for status in Status})
        == len(set(map(int, Status)))
        == len(Status.__members__)
    )
    assert not {120, 126, 127, 128} & set(Status) and max(Status) < 256


# A reader that leaves, a disk that is full, a stream that is closed.


@pytest.mark.slow
@posix
@pytest.mark.parametrize("words", list(COMMANDS.values()), ids=list(COMMANDS))
def test_a_reader_that_leaves_early_has_a_status_and_no_words(onto, here, words):
    status, err = onto("pipe", *words)
    assert status == VERDICTS.get(words, Status.UNREAD)
    assert "rror" not in err


@pytest.mark.slow
@posix
@pytest.mark.parametrize(("words", "status"), VERDICTS.items(), ids=map(" ".join, VERDICTS))
def test_a_verdict_stays_when_its_reader_leaves(onto, here, words, status):
    assert onto("pipe", *words) == (status, "")


@pytest.mark.slow
@full
@pytest.mark.parametrize("words", list(COMMANDS.values()), ids=list(COMMANDS))
def test_a_full_disk_has_a_status_of_its_own_and_one_line(onto, here, words):
    status, err = onto("full", *words)
    assert status == Status.LOST
    assert err.splitlines()[-1].startswith(
        "the result could not be written: No space left on device. "
    )


@posix
@pytest.mark.parametrize("unbuffered", ["", "1"])
@pytest.mark.parametrize("stream", ["stdout", "stderr"])
def test_what_is_written_in_part_is_not_taken_for_written(tmp_path, unbuffered, stream):
    """A disk that fills up part-way; an unbuffered stream of Python's own takes one short write for all."""
    program = f"""
import resource, signal, sys
from dehyst.app._ending import end
resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000))
end(lambda: sys.{stream}.write("0123456789\\n" * 20_000))
"""
    out, err = tmp_path / "out", tmp_path / "err"
    with out.open("w") as one, err.open("w") as two:
        done = subprocess.run(
            [sys.executable, "-c", program], stdout=one, stderr=two, check=False,
            env={**os.environ, "PYTHONUNBUFFERED": unbuffered},
        )  # fmt: skip
    assert done.returncode == Status.LOST
    assert (tmp_path / stream[3:]).stat().st_size == 100_000
    if stream == "stdout":
        assert (
            err.read_text()
            == "the result could not be written: File too large. Free some space, or write it "
            "elsewhere.\n"
        )


@posix
@pytest.mark.parametrize("unbuffered", ["", "1"])
def test_a_reader_that_leaves_part_way_is_noticed(unbuffered):
    program = "import sys; from dehyst.app._ending import end; end(lambda: sys.stdout.write('0123456789\\n' * 100_000))"
    environment = {**os.environ, "PYTHONUNBUFFERED": unbuffered}
    with subprocess.Popen(
        [sys.executable, "-c", program], stdout=subprocess.PIPE, env=environment
    ) as writer:
        assert len(writer.stdout.read(20)) == 20
        writer.stdout.close()
    assert writer.returncode == Status.UNREAD


@pytest.mark.slow
@posix
@pytest.mark.parametrize("words", list(COMMANDS.values()), ids=list(COMMANDS))
def test_a_disk_that_is_full_after_the_first_bytes_has_that_status_too(onto, here, words):
    status, err = onto("part", *words)
    assert status == Status.LOST and "could not be written: File too large. Free some space" in err
    assert Path("part").stat().st_size == LIMIT


@full
@pytest.mark.parametrize(
    "words", [words for words, status in VERDICTS.items() if status == Status.NO], ids=" ".join
)
def test_a_verdict_that_nobody_can_read_is_not_taken_for_one(onto, here, words):
    assert onto("full", *words)[0] == Status.LOST


def test_a_verdict_ends_the_command_even_if_all_of_it_was_read(capsys):
    with pytest.raises(SystemExit) as ended, concluding(Status.NO):
        print("not verified")
    assert ended.value.code == 1 and capsys.readouterr().out == "not verified\n"


@pytest.mark.slow
@posix
@pytest.mark.parametrize(
    ("redirection", "status", "words"),
    [
        (
            ">&-",
            Status.LOST,
            "could not be written: Bad file descriptor. The standard output is closed: leave out",
        ),
        ("2>&-", Status.DONE, ""),
        ("<&- >&- 2>&-", Status.LOST, ""),
        (">/dev/full 2>&1", Status.LOST, ""),
    ],
)
def test_the_shell_sees_the_status(here, redirection, status, words):
    line = f'("$0" -m dehyst inspect log.csv; echo $? > status) {redirection}'
    done = subprocess.run(
        ["sh", "-c", line, sys.executable], capture_output=True, text=True, check=False
    )
    assert int(Path("status").read_text()) == status
    assert words in done.stderr and len(done.stderr.splitlines()) == bool(words)


# Ctrl-C.


@pytest.mark.parametrize("name", ["inspect", "identify", "drift", "export", "verify", "design"])
def test_ctrl_c_in_a_command_ends_with_130_and_one_line(run, here, monkeypatch, name):
    import dehyst.app._terminal

    def stop(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(dehyst.app._terminal._Terminal, "print", stop)
    status, out, err = run(*COMMANDS[name])
    assert (status, out) == (Status.STOPPED, "")
    assert err.startswith("stopped; ") and len(err.splitlines()) == 1


INTERRUPT = """
import os, signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)
sys.argv = ["dehyst", "inspect", "log.csv"]

class Press:
    loaded = 0
    at = None
    def find_spec(self, name, path=None, target=None):
        Press.loaded += 1
        if Press.at == Press.loaded:
            os.kill(os.getpid(), signal.SIGINT)

sys.meta_path.insert(0, Press())
from dehyst.__main__ import main

def ends_as(at):
    read, write = os.pipe()
    child = os.fork()
    if child == 0:
        Press.loaded, Press.at = 0, at
        os.dup2(write, 2)
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        try:
            main()
        finally:
            sys.stderr.flush()
            os._exit(99 if sys.exc_info()[0] is not SystemExit else sys.exc_info()[1].code)
    os.close(write)
    _, status = os.waitpid(child, 0)
    return os.waitstatus_to_exitcode(status), open(read).read()

at = 1
while (ended := ends_as(at))[0] != 0:
    assert ended[0] == 130 and ended[1].startswith("stopped") and ended[1].count("\\n") == 1, (at, ended)
    at = 2 * at + 1
print("interrupted up to the", at, "th module")
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork")
def test_ctrl_c_while_any_module_is_loaded_ends_with_130_and_one_line(here):
    done = subprocess.run(
        [sys.executable, "-c", INTERRUPT], capture_output=True, text=True, check=False, timeout=120
    )
    assert done.returncode == 0, done.stderr
    assert "interrupted up to the" in done.stdout


def test_nothing_is_loaded_before_ctrl_c_is_heeded():
    """What the interpreter has loaded already excepted: loading is where the time goes, and where Ctrl-C would hit."""
    program = """
import importlib.machinery, importlib.util, sys  # which the finder of an editable install uses
before = set(sys.modules)
import dehyst
print(*sorted(set(sys.modules) - before - set(sys.builtin_module_names)))
import dehyst.__main__
print(*sorted(set(sys.modules) - before - set(sys.builtin_module_names)))
"""
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    assert done.stdout.splitlines() == ["dehyst dehyst.lazy", "dehyst dehyst.__main__ dehyst.lazy"]


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
def test_ctrl_c_between_loading_and_beginning_has_no_traceback():
    program = """
import signal
signal.signal(signal.SIGINT, signal.default_int_handler)
import dehyst.__main__
signal.raise_signal(signal.SIGINT)
print("lost")
"""
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stdout, done.stderr) == (Status.STOPPED, "", "stopped\n")


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
def test_ctrl_c_in_a_destructor_is_neither_lost_nor_printed():
    program = """
import signal, time
signal.signal(signal.SIGINT, signal.default_int_handler)
from dehyst.app._ending import heed
heed()
class Thing:
    def __del__(self):
        signal.raise_signal(signal.SIGINT)
try:
    Thing()
    time.sleep(5.0)
    print("lost")
except KeyboardInterrupt:
    print("came")
"""
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=False
    )
    assert (done.stdout, done.stderr) == ("came\n", "")
