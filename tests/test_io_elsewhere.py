"""A log is read from its own file alone, and groups that hold each other end."""

import time

import h5py
import numpy as np
import pytest

from dehyst.errors import LogError
from dehyst.io import foreign
from dehyst.io.formats import read_table

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


@pytest.mark.parametrize("kind", ["external link", "virtual dataset", "external storage", "link to nothing"])
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
    begin = time.process_time()
    assert set(read_table(tmp_path / "log.h5").columns) == {"x"}
    assert time.process_time() - begin < 5


def test_a_reader_that_takes_too_long_ends_in_a_named_error_however_slow_the_machine_is(monkeypatch):
    monkeypatch.setattr(foreign, "GRACE_SECONDS", 0.05)
    monkeypatch.setattr(foreign.gc, "collect", lambda _: time.sleep(0.2))  # the bell rings every 0.05 s

    def endless():
        while True:
            pass

    with pytest.raises(LogError, match="no end after"):
        foreign.guard("x.mat", "MAT file", 0, endless)
