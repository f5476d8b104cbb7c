"""MDF of every version: samples that the file calls invalid are missing, and those beside them stay where they are."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from dehyst.io import read_log, read_table

asammdf = pytest.importorskip("asammdf", reason="the extra dehyst[mdf] is not installed")

N = 240
T = np.arange(N) * 0.01
VERSIONS = ("3.30", "4.00", "4.10", "4.11", "4.20")
TYPES = ("u1", "i1", "u2", "i2", "u4", "i4", "f4", "f8", ">u2", ">f8")
# Conversion of MDF -> what it makes of a raw number.
CONVERSIONS: dict[str, tuple[dict[str, Any] | None, Any]] = {
    "none": (None, lambda raw: raw),
    "linear": ({"a": 0.25, "b": -3.0}, lambda raw: 0.25 * raw - 3.0),
    "texts": ({"val_0": 61, "text_0": b"SNA", "default_addr": {"a": 0.5, "b": 1.0}}, None),
    "table": (
        {"raw_0": 0, "phys_0": 1.0, "raw_1": 200, "phys_1": 401.0, "interpolation": True},
        lambda raw: 2.0 * raw + 1.0,
    ),
}
GAPS = {
    "none": [],
    "one": [7],
    "block": [*range(20, 60)],
    "apart": [*range(3, N, 11)],
    "first and last": [0, N - 1],
}
CASES = [
    case
    for case in itertools.product(VERSIONS, TYPES, CONVERSIONS, GAPS, (0, 2))
    if case[0][0] == "4" or case[2] != "texts"
]


def write(path: Path, case: tuple[str, str, str, str, int]) -> tuple[Path, np.ndarray, np.ndarray]:
    """Write a file; return its path, its input and output, NaN where there is none."""
    version, kind, conversion, gaps, compression = case
    raw = np.round(60 + 55 * np.sin(np.arange(N) * 0.13)).astype(kind)
    rule, makes = CONVERSIONS[conversion]
    if makes is None:
        x = np.where(raw == 61, np.nan, 0.5 * raw.astype(float) + 1.0)
    else:
        x = np.array(makes(raw.astype(float)))
    y = np.cos(np.arange(N) * 0.13)
    invalid = [np.zeros(N, dtype=bool) for _ in range(2)]
    if version[0] == "4":
        invalid[0][GAPS[gaps]] = True
        invalid[1][[place + 1 for place in GAPS[gaps] if place + 1 < N]] = True
    x[invalid[0]], truth = np.nan, y.copy()
    truth[invalid[1]] = np.nan
    signals = [
        asammdf.Signal(raw, T, name="x", unit="bar", conversion=rule, invalidation_bits=invalid[0]),
        asammdf.Signal(y, T, name="y", unit="deg", invalidation_bits=invalid[1]),
    ]
    with asammdf.MDF(version=version) as out:
        out.append(signals)
        path = Path(
            out.save(path, overwrite=True, compression=compression)
        )  # the version has its own ending
    return path, x, truth


def right(path: Path, case: tuple[str, str, str, str, int]) -> bool:
    path, x, y = write(path, case)
    rec = read_log(path, "x", "y")
    there = np.isfinite(x) & np.isfinite(y)
    assert rec.time is not None
    return (
        rec.input.size == there.sum()
        and np.allclose(rec.input, x[there], rtol=1e-12)
        and np.allclose(rec.output, y[there], rtol=1e-12)
        and np.allclose(rec.time, T[there])
        and (rec.input_unit, rec.output_unit) == ("bar", "deg")
    )


def test_invalid_samples_are_missing_each_in_its_own_channel(tmp_path: Path) -> None:
    assert [case for case in CASES[5::149] if not right(tmp_path / "log.mf4", case)] == []


@pytest.mark.slow
def test_every_version_type_conversion_and_pattern_of_invalid_samples_is_read(
    tmp_path: Path,
) -> None:
    assert len(CASES) == 1900
    assert [case for case in CASES[::2] if not right(tmp_path / "log.mf4", case)] == []


def signal(name: str, values: Any, **more: Any) -> Any:
    return asammdf.Signal(np.asarray(values), T, name=name, **more)


def test_a_channel_that_is_wholly_invalid_leaves_the_others_whole(tmp_path: Path) -> None:
    with asammdf.MDF(version="4.10") as out:
        dead = signal("dead", np.arange(N), invalidation_bits=np.ones(N, dtype=bool))
        out.append([dead, signal("x", T), signal("y", T)])
        out.save(tmp_path / "log.mf4")
    table = read_table(tmp_path / "log.mf4")
    assert np.isnan(table.columns["dead"]).all() and np.isfinite(table.columns["x"]).all()
    assert len(read_log(tmp_path / "log.mf4", "x", "y")) == N


def test_a_group_that_counts_degrees_has_no_clock(tmp_path: Path) -> None:
    with asammdf.MDF(version="4.10") as out:
        out.append([signal("x", np.sin(T)), signal("y", np.cos(T))])
        master = out.groups[0].channels[0]
        master.sync_type, master.name, master.unit = 2, "crank", "deg"
        out.save(tmp_path / "log.mf4")
    table = read_table(tmp_path / "log.mf4")
    assert "time" not in table.columns and table.clocks == {}
    np.testing.assert_allclose(table.columns["crank"], T)


def test_texts_keep_their_letters_beyond_ascii(tmp_path: Path) -> None:
    labels = np.array([b"Hin", "Rückweg".encode()] * (N // 2))
    with asammdf.MDF(version="4.10") as out:
        out.append([signal("x", T), signal("phase", labels, encoding="utf-8")])
        out.save(tmp_path / "log.mf4")
    assert set(read_table(tmp_path / "log.mf4").labels["phase"].tolist()) == {"Hin", "Rückweg"}
