"""Damaged logs: each is read or refused by name within two seconds; what is read was in the file.

Seeded, so that a failure can be repeated: its message names the base, the number of the case and the mutation.
"""

import io
import os
import random
import subprocess
import sys
import time
import warnings

import h5py
import numpy as np
import pytest
from scipy.io import savemat

from dehyst.errors import DehystError, LogError
from dehyst.io import _foreign as foreign
from dehyst.io import inspect_log, read_log, read_signal, read_table
from effort import no_hang
from log_files import FORMS, save
from structured_files import hostile_hdf5, hostile_mat4, hostile_mat5, hostile_mat73

N = 60
T = [f"{0.01 * k:.2f}" for k in range(N)]
X = [f"{3 * np.sin(0.37 * k):.5f}" for k in range(N)]
Y = [f"{20 * np.sin(0.37 * k - 0.2):.4f}" for k in range(N)]
HEADER = "run,time_s,pressure_bar,angle_deg"
LINES = [f"r_1,{t},{x},{y}" for t, x, y in zip(T, X, Y, strict=True)]
TEXT = "\n".join([HEADER, *LINES]) + "\n"
NUMBERS = {line: tuple(float(cell) for cell in line.split(",")[1:]) for line in LINES}

SPELLINGS = [
    "nan",
    "NaN",
    "inf",
    "-inf",
    "Infinity",
    "1e999",
    "-1e308",
    "1e-320",
    "1e308",
    "",
    " ",
    "--",
    "1_0",
    "٣",
]
SPELLINGS += [
    "0x1F",
    "1,5",
    "1.5.2",
    "+",
    "e5",
    "1e",
    "#",
    '"',
    "'",
    "NULL",
    "true",
    "9" * 400,
    "\0",
    "\x1b[2J",
    "=1+1",
]


def attempt(path, what, run=None):
    """Read, and hold the promise: a recording or a named error, no hang, no warning."""
    recording = None
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            with no_hang(what):
                recording = read_log(path, "pressure_bar", "angle_deg", run=run)
        except DehystError as fault:
            assert len(str(fault)) > 30, what
        except BaseException as fault:
            pytest.fail(f"{what}: {type(fault).__name__}: {fault}")
        for look in (lambda: inspect_log(path), lambda: read_signal(path, "#2")):
            try:
                with no_hang(what):
                    look()
            except DehystError:
                pass
            except BaseException as fault:
                pytest.fail(f"{what}, inspect: {type(fault).__name__}: {fault}")
    assert not caught, f"{what}: {caught[0].message}"
    if recording is not None:
        assert np.isfinite(recording.input).all(), what
    return recording


# Text: mutations of lines, with an oracle


def mutate_lines(lines, dice):
    """Change the lines in place; return what was done."""
    kind = dice.choice(
        [
            "flip",
            "spell",
            "delete",
            "double",
            "swap",
            "cut",
            "join",
            "break",
            "insert",
            "cell",
            "tail",
        ]
    )
    at = dice.randrange(len(lines))
    line = lines[at]
    if kind == "flip" and line:
        k = dice.randrange(len(line))
        lines[at] = line[:k] + chr(ord(line[k]) ^ (1 << dice.randrange(7))) + line[k + 1 :]
    elif kind == "spell":
        cells = line.split(",")
        cells[dice.randrange(len(cells))] = dice.choice(SPELLINGS)
        lines[at] = ",".join(cells)
    elif kind == "delete":
        del lines[at]
    elif kind == "double":
        lines.insert(at, line)
    elif kind == "swap":
        other = dice.randrange(len(lines))
        lines[at], lines[other] = lines[other], line
    elif kind == "cut":
        lines[at] = line[: dice.randrange(len(line) + 1)]
    elif kind == "join" and at + 1 < len(lines):
        lines[at : at + 2] = [line + lines[at + 1]]
    elif kind == "break":
        k = dice.randrange(len(line) + 1)
        lines[at : at + 1] = [line[:k], line[k:]]
    elif kind == "insert":
        lines.insert(at, "".join(chr(dice.randrange(1, 256)) for _ in range(dice.randrange(40))))
    elif kind == "cell":
        lines[at] = line + "," + dice.choice(SPELLINGS)
    elif kind == "tail":
        del lines[at + 1 :]
    return f"{kind} at {at}"


def check_against_oracle(path, text, recording, what):
    """Lines that nobody touched keep their numbers and their place; no number appears from nowhere."""
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    touched = sum(line not in NUMBERS for line in lines)
    try:
        table = read_table(path)
    except DehystError:
        assert recording is None, what
        return
    columns = [table.columns[name] for name in table.order if name in table.columns]
    seen = set(table.rows.tolist())
    for k, row in enumerate(table.rows.tolist()):
        expected = NUMBERS.get(lines[row - 1])
        if expected is not None and len(columns) >= 3:
            assert tuple(float(column[k]) for column in columns[-3:]) == expected, (
                f"{what}, line {row}"
            )
    if len(lines) < 6:
        return  # too little is left to tell header from data
    missing = [row for row, line in enumerate(lines, 1) if line in NUMBERS and row not in seen]
    assert not missing, f"{what}: whole lines {missing} vanished"
    if recording is not None and recording.time is not None:
        known = set(NUMBERS.values())
        triples = zip(
            recording.time.tolist(),
            recording.input.tolist(),
            recording.output.tolist(),
            strict=True,
        )
        strange = sum(triple not in known for triple in triples)
        assert strange <= touched, f"{what}: {strange} samples from {touched} touched lines"


@pytest.mark.slow
@pytest.mark.parametrize("block", range(4))
def test_mutated_lines_are_read_or_refused_and_whole_lines_keep_their_numbers(tmp_path, block):
    dice = random.Random(100 + block)
    read = 0
    for case in range(150):
        lines = [HEADER, *LINES]
        done = [mutate_lines(lines, dice) for _ in range(dice.choice([1, 1, 2, 5]))]
        text = "\n".join(lines)
        path = tmp_path / f"log{case}.csv"
        path.write_text(text, encoding="utf-8", newline="")
        what = f"block {block} case {case}: {done}"
        recording = attempt(path, what, run="r_1")
        check_against_oracle(path, text, recording, what)
        read += recording is not None
    assert read > 75, "most logs with a few damaged lines must still be readable"


@pytest.mark.slow
def test_a_dropped_row_is_never_silent(tmp_path):
    dice = random.Random(7)
    for case in range(150):
        lines = [HEADER, *LINES]
        at = dice.randrange(2, len(lines))
        cells = lines[at].split(",")
        cells[dice.randrange(1, 4)] = dice.choice(["", "nan", "x", "1e999", "1_0", "٣", "1;2"])
        lines[at] = ",".join(cells)
        path = tmp_path / "log.csv"
        path.write_text("\n".join(lines), encoding="utf-8")
        recording = attempt(path, f"case {case}")
        assert recording is not None
        assert len(recording) == N - 1
        assert any("line" in f.message and str(at + 1) in f.message for f in recording.findings), (
            lines[at]
        )


# Bytes of any format


ARRAYS = {
    "time_s": np.array(T, float),
    "pressure_bar": np.array(X, float),
    "angle_deg": np.array(Y, float),
}
CASES = {
    "plain.csv": 100,
    "utf16.txt": 80,
    "packed.csv.gz": 80,
    "vectors.npz": 80,
    "matrix.npy": 60,
    "plain.mat": 100,
}
CASES |= {
    "packed.mat": 60,
    "old.mat": 60,
    "plain.h5": 80,
    "table.parquet": 60,
    "table.feather": 60,
    "log.mf4": 60,
}
CASES |= {"classic.nc": 80}


def mutate_bytes(data, dice):
    kind = dice.choice(
        ["flip", "flips", "cut", "head", "zeros", "noise", "double", "large", "shift"]
    )
    raw = bytearray(data)
    # Headers decide most; half of the damage goes there.
    reach = len(raw) if dice.random() < 0.5 else min(len(raw), 256)
    at = dice.randrange(reach)
    if kind == "flip":
        raw[at] ^= 1 << dice.randrange(8)
    elif kind == "flips":
        for _ in range(20):
            raw[dice.randrange(reach)] = dice.randrange(256)
    elif kind == "cut":
        del raw[at:]
    elif kind == "head":
        del raw[: dice.randrange(1, 64)]
    elif kind == "zeros":
        raw[at : at + 16] = bytes(16)
    elif kind == "noise":
        raw[at:at] = dice.randbytes(dice.randrange(1, 64))
    elif kind == "double":
        raw[at:at] = raw[: dice.randrange(1, len(raw))]
    elif kind == "large":
        raw[at : at + 4] = b"\xff\xff\xff\x7f"
    elif kind == "shift":
        del raw[at : at + dice.randrange(1, 5)]
    return bytes(raw), f"{kind} at {at}"


def require_read_or_refused(victim, cases, path=None):
    """Damage a file in so many ways; `path` is the log if the file is a part of it."""
    data, dice = victim.read_bytes(), random.Random(victim.name)
    for case in range(cases):
        mutated, done = mutate_bytes(data, dice)
        victim.write_bytes(mutated)
        attempt(path or victim, f"{victim.name} case {case}: {done}")


@pytest.mark.slow
@pytest.mark.parametrize("form", CASES)
def test_mutated_bytes_are_read_or_refused(tmp_path, capfd, form):
    if form not in FORMS:
        pytest.skip("its package is not installed")
    path, x, _ = save(tmp_path, form, ARRAYS)
    assert attempt(path, "untouched") is not None or x != "pressure"
    require_read_or_refused(path, CASES[form])
    assert capfd.readouterr() == ("", "")


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["bag", "db3", "mcap", "folder"])
def test_mutated_bags_are_read_or_refused(tmp_path, capfd, kind):
    pytest.importorskip("rosbags", reason="the extra dehyst[ros] is not installed")
    from test_io_formats import write_bag

    path = write_bag(tmp_path, kind)
    require_read_or_refused(path / "metadata.yaml" if kind == "folder" else path, 20, path)
    assert capfd.readouterr() == ("", "")


STRUCTURED = [
    (hostile_mat5, "mat", 60),
    (hostile_mat4, "mat", 60),
    (hostile_hdf5, "h5", 25),
    (hostile_mat73, "mat", 25),
]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("make", "ending", "cases"), STRUCTURED, ids=[make.__name__ for make, _, _ in STRUCTURED]
)
def test_files_with_lies_in_their_structure_are_read_or_refused(tmp_path, make, ending, cases):
    """DEHYST_FUZZ=3000 runs so many cases of each; the number of a case is its seed."""
    path = tmp_path / f"log.{ending}"
    for case in range(int(os.environ.get("DEHYST_FUZZ", cases))):
        path.write_bytes(make(random.Random(case)))
        attempt(path, f"{make.__name__} case {case}")


@pytest.mark.parametrize(
    ("entry", "size"), [(b"\0\0", 0), (b"\1\0", 2**64 - 16), (b"\0\0", 2**64 - 8)]
)
def test_a_heap_that_leads_to_itself_is_refused(tmp_path, entry, size):
    """In a process of its own: the HDF5 library would go round for ever, and hear no signal."""
    path = tmp_path / "log.h5"
    with h5py.File(path, "w") as out:
        out["pressure_bar"], out["angle_deg"] = np.arange(60.0), np.arange(60.0)
        out.create_dataset("label", data=["new", "old"], dtype=h5py.string_dtype())
    assert len(read_log(path, "pressure_bar", "angle_deg")) == 60
    raw = bytearray(path.read_bytes())
    first = raw.index(b"GCOL") + 16
    raw[first + 24 : first + 26], raw[first + 32 : first + 40] = entry, size.to_bytes(8, "little")
    path.write_bytes(raw)
    line = f"import dehyst; dehyst.read_log({str(path)!r}, 'pressure_bar', 'angle_deg')"
    done = subprocess.run([sys.executable, "-c", line], capture_output=True, text=True, timeout=60)
    assert "LogError" in done.stderr and "has no end" in done.stderr


def test_packed_and_plain_variables_may_stand_in_one_file(tmp_path):
    parts = []
    for k, (name, values) in enumerate(ARRAYS.items()):
        stream = io.BytesIO()
        savemat(stream, {name: values[:57]}, do_compression=k % 2 == 0)
        parts.append(stream.getvalue())
    path = tmp_path / "log.mat"
    path.write_bytes(parts[0] + b"".join(part[128:] for part in parts[1:]))
    recording = attempt(path, "packed and plain")
    assert recording is not None and len(recording) == 57


ENDINGS = [
    "csv",
    "txt",
    "tsv",
    "dat",
    "gz",
    "mat",
    "npz",
    "npy",
    "h5",
    "bag",
    "db3",
    "mcap",
    "mf4",
    "mdf",
    "parquet",
]
MAGICS = [
    b"",
    b"\x1f\x8b\x08\0",
    b"PK\x03\x04",
    b"\x93NUMPY\x01\0",
    b"\x89HDF\r\n\x1a\n",
    b"MDF     4.10    ",
    b"PAR1",
]
MAGICS += [
    b"MATLAB 5.0 MAT-file" + b" " * 105 + b"\0\1IM",
    b"#ROSBAG V2.0\n",
    b"\x89MCAP0\r\n",
    b"ARROW1\0\0",
]
MAGICS += [b"SQLite format 3\0", b"\xff\xfe", b"\xef\xbb\xbf"]


def test_garbage_under_every_ending_and_behind_every_magic_is_refused(tmp_path, capfd):
    dice = random.Random(5)
    for ending in ENDINGS:
        for magic in MAGICS:
            path = tmp_path / f"log.{ending}"
            path.write_bytes(magic + dice.randbytes(dice.randrange(3000)))
            attempt(path, f"{ending} after {magic[:8]!r}")
            path.unlink()
    out, err = capfd.readouterr()
    assert (out, err) == ("", "")


@pytest.mark.parametrize("delimiter", [",", ";", "\t", " ", "|", ":", "  ", ", "])
def test_a_wrong_delimiter_gives_the_same_numbers_or_none(tmp_path, delimiter):
    path = tmp_path / "log.csv"
    path.write_text(TEXT.replace(",", delimiter))
    recording = attempt(path, repr(delimiter))
    if delimiter == ":":
        assert recording is None
    else:
        assert recording is not None
        np.testing.assert_array_equal(recording.output, np.array(Y, float))


# A log is read from its own file alone, and every reader ends

SECRET = np.arange(50.0) + 7000


def hostile(kind, path, other):
    with h5py.File(other, "w") as file:
        file["secret"] = SECRET
    raw = other.with_suffix(".bin")
    raw.write_bytes(SECRET.tobytes())
    with h5py.File(path, "w") as file:
        file["time"], file["x"] = np.arange(50) / 10, np.sin(np.arange(50.0))
        inside = file.create_group("deep")
        for group in (file, inside):
            if kind == "external link":
                group["bad"] = h5py.ExternalLink(str(other), "/secret")
            elif kind == "virtual dataset":
                layout = h5py.VirtualLayout(shape=(50,), dtype="f8")
                layout[:] = h5py.VirtualSource(str(other), "secret", shape=(50,))
                group.create_virtual_dataset("bad", layout)
            elif kind == "external storage":
                group.create_dataset("bad", (50,), "f8", external=[(str(raw), 0, 400)])
            elif kind == "link to nothing":
                group["bad"] = h5py.SoftLink("/nowhere")


@pytest.mark.parametrize(
    "kind", ["external link", "virtual dataset", "external storage", "link to nothing"]
)
def test_no_number_of_another_file_is_read_and_the_others_are(kind, tmp_path):
    hostile(kind, tmp_path / "log.h5", tmp_path / "other.h5")
    table = read_table(tmp_path / "log.h5")
    assert set(table.columns) == {"time", "x"}
    assert [found.code for found in table.findings] == ["data-elsewhere"] * 2


def test_groups_that_hold_each_other_are_walked_once(tmp_path):
    with h5py.File(tmp_path / "log.h5", "w") as file:
        file["x"] = np.sin(np.arange(50.0))
        for k in range(60):
            file.create_group(f"g{k}")
        for k in range(60):
            for j in range(60):
                file[f"g{k}"][f"to{j}"] = file[f"g{j}"]
    with no_hang():
        assert set(read_table(tmp_path / "log.h5").columns) == {"x"}


def test_a_reader_that_takes_too_long_ends_in_a_named_error_however_slow_the_machine_is(
    monkeypatch,
):
    monkeypatch.setattr(foreign, "GRACE_SECONDS", 0.05)
    monkeypatch.setattr(
        foreign.gc, "collect", lambda _: time.sleep(0.2)
    )  # the bell rings every 0.05 s

    def endless():
        while True:
            pass

    with pytest.raises(LogError, match="no end after"):
        foreign.guard("x.mat", "MAT file", 0, endless)
