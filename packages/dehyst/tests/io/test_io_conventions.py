"""Attributes of HDF5 and netCDF: the numbers of a log are those that its writer packed, not those that it stored."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from scipy.io import netcdf_file

from dehyst.io import read_log, read_table

N = 400
STEP = 0.01  # [s]
TYPES = ("i1", "u1", "i2", "u2", "i4", "u4", "i8", "f4", "f8", ">i2", ">f4")
PACKINGS = (
    {},
    {"scale_factor": 0.05},
    {"add_offset": -7.5},
    {"scale_factor": -0.02, "add_offset": 3.0},
)
MISSING = ("none", "_FillValue", "missing_value", "two missing values", "unwritten")
LIMITS = ("none", "range of stored", "min of stored", "max of stored", "range of values")
UNITS = (("bar", "bar"), ("degrees", "deg"), ("1", ""), ("kPa", "kPa"), ("furlong", "furlong"))
# Unit of the clock as written, seconds in it.
CLOCKS = (
    ("seconds since 2024-01-01 00:00:00", 1.0),
    ("milliseconds since 2024-01-01T00:00:00Z", 1e-3),
    ("microseconds since 2024-5-1", 1e-6),
    ("days since 2024-01-01", 86400.0),
    ("hours since 2024-01-01 12:00:00 +02:00", 3600.0),
    ("minutes since 1970-01-01", 60.0),
    ("Days Since 1999-12-31", 86400.0),
    ("s", 1.0),
    ("ms", 1e-3),
    ("h", 3600.0),
)


@dataclass
class Case:
    """A file and what it stands for."""

    kind: str
    packing: dict[str, float]
    missing: str
    limits: str
    unit: tuple[str, str]
    clock: tuple[str, float]

    def write(self, path: Path, rng: np.random.Generator) -> np.ndarray:
        """Write the file; return its values, NaN where there is none."""
        dtype = np.dtype(self.kind)
        small = dtype.itemsize == 1
        low, high = (5, 100) if small else (-2000, 2000)
        low = 5 if dtype.kind == "u" else low
        wave = np.sin(np.arange(N) * 0.11)
        stored = np.round((low + high) / 2 + (high - low) / 2 * wave).astype(dtype)
        scale, offset = self.packing.get("scale_factor", 1.0), self.packing.get("add_offset", 0.0)
        truth = stored.astype(float) * scale + offset
        attributes: dict[str, Any] = {**self.packing, "units": self.unit[0]}
        holes = rng.choice(np.arange(10, N - 10), 12, replace=False)
        mark = 120 if small else 3000
        marks = {
            "_FillValue": [mark],
            "missing_value": [mark],
            "two missing values": [mark, mark + 1],
        }
        marks = marks.get(self.missing, [])
        if self.missing == "unwritten":
            marks = [
                {
                    "i2": -32767,
                    "i4": -2147483647,
                    "f4": 9.969209968386869e36,
                    "f8": 9.969209968386869e36,
                }[self.kind]
            ]
        for place, mark in zip(holes[:8], itertools.cycle(marks), strict=False):
            stored[place], truth[place] = mark, np.nan
        if marks and self.missing != "unwritten":
            name = self.missing if len(marks) == 1 else "missing_value"
            attributes[name] = np.array(marks, dtype) if len(marks) > 1 else dtype.type(marks[0])
        edge = {
            "range of stored": "valid_range",
            "min of stored": "valid_min",
            "max of stored": "valid_max",
        }
        if self.limits in edge:
            bounds = {"valid_range": (low, high), "valid_min": low, "valid_max": high}[
                edge[self.limits]
            ]
            attributes[edge[self.limits]] = np.array(bounds, dtype)
            stored[holes[8:]], truth[holes[8:]] = (
                (low - 3 if self.limits == "min of stored" else high + 4),
                np.nan,
            )
        elif self.limits == "range of values":
            bounds = sorted([low * scale + offset, high * scale + offset])
            attributes["valid_range"] = np.array(bounds, "f8")
            stored[holes[8:]], truth[holes[8:]] = high + 4, np.nan
        with h5py.File(path, "w") as out:
            if self.missing == "unwritten":
                out.attrs["_NCProperties"] = "version=2,netcdf=4.9.0,hdf5=1.12.0"
            time = out.create_dataset("time", data=np.arange(N) * STEP / self.clock[1])
            time.attrs["units"] = self.clock[0]
            for name, values in (("x", stored), ("y", np.cos(np.arange(N) * 0.11))):
                out.create_dataset(name, data=values)
            out["x"].attrs.update(attributes)
        return truth


def _possible(case: Case) -> bool:
    if case.missing == "unwritten" and case.kind not in ("i2", "i4", "f4", "f8"):
        return False
    # Limits are of values only where they are wider than what is stored, and written like the scale.
    return case.limits != "range of values" or (bool(case.packing) and case.kind != "f8")


CASES = [
    case
    for k, (kind, packing, missing, limits) in enumerate(
        itertools.product(TYPES, PACKINGS, MISSING, LIMITS)
    )
    if _possible(
        case := Case(
            kind, packing, missing, limits, UNITS[k % len(UNITS)], CLOCKS[k % 7 + k // 7 % 4]
        )
    )
]


def right(case: Case, path: Path, seed: int) -> bool:
    truth = case.write(path, np.random.default_rng(seed))
    rec = read_log(path, "x", "y")
    there = np.isfinite(truth)
    assert rec.time is not None
    return (
        rec.input.size == there.sum()
        and np.allclose(rec.input, truth[there], rtol=1e-12, atol=1e-12)
        and np.allclose(
            rec.time - rec.time[0],
            (np.arange(N) * STEP)[there] - STEP * np.flatnonzero(there)[0],
            atol=1e-6,
        )
        and rec.input_unit == case.unit[1]
    )


def wrong_of(cases: list[Case], folder: Path) -> list[Case]:
    return [case for k, case in enumerate(cases) if not right(case, folder / f"{k}.nc", k)]


def test_packed_numbers_are_unpacked_as_their_attributes_say(tmp_path: Path) -> None:
    assert wrong_of(CASES[::23], tmp_path) == []


@pytest.mark.slow
def test_packed_numbers_of_every_type_scale_mark_limit_unit_and_clock_are_unpacked(
    tmp_path: Path,
) -> None:
    assert len(CASES) > 500
    assert wrong_of(CASES, tmp_path) == []


def table_of(path: Path, **datasets: tuple[Any, dict[str, Any]]) -> Any:
    with h5py.File(path, "w") as out:
        for name, (values, attributes) in datasets.items():
            out.create_dataset(name, data=values).attrs.update(attributes)
    return read_table(path)


RAMP = np.arange(20)


def test_old_netcdf_s_signed_bytes_are_unsigned_where_it_says_so(tmp_path: Path) -> None:
    stored = np.array([1, 127, -128, -2, -1], "i1")
    table = table_of(
        tmp_path / "a.nc", x=(stored, {"_Unsigned": "true", "_FillValue": np.int8(-1)})
    )
    np.testing.assert_array_equal(table.columns["x"], [1, 127, 128, 254, np.nan])


def test_a_mark_that_was_written_as_text_or_in_double_precision_marks_floats_too(
    tmp_path: Path,
) -> None:
    stored = np.array([1, -9999.9, 3], "f4")
    for mark in (-9999.9, np.float32(-9999.9), "-9999.9"):
        table = table_of(tmp_path / "a.h5", x=(stored, {"missing_value": mark}))
        np.testing.assert_array_equal(table.columns["x"], [1, np.nan, 3])


def test_clocks_that_count_from_two_dates_are_put_on_one(tmp_path: Path) -> None:
    table = table_of(
        tmp_path / "a.nc",
        time_a=(RAMP * 1.0, {"units": "seconds since 2024-01-01 00:00:10"}),
        time_b=(RAMP * 1000, {"units": "milliseconds since 2024-01-01"}),
    )
    np.testing.assert_array_equal(table.columns["time_a"], RAMP + 10.0)
    np.testing.assert_array_equal(table.columns["time_b"], RAMP * 1000.0)


def test_limits_that_leave_no_sample_are_not_applied_and_said(tmp_path: Path) -> None:
    table = table_of(
        tmp_path / "a.h5", x=(RAMP + 100, {"scale_factor": 0.01, "valid_range": np.array([0, 5])})
    )
    np.testing.assert_allclose(table.columns["x"], (RAMP + 100) * 0.01)
    assert [finding.code for finding in table.findings] == ["attributes-applied", "attributes-left"]
    assert "valid_range = 0, 5, which leaves no sample" in table.findings[1].message


@pytest.mark.parametrize(
    "attributes",
    [
        {"gain": 0.01},
        {"Scale_Factor": 2.0},
        {"offset": -5},
        {"scale_factor": [1.0, 2.0]},
        {"scale_factor": 0.0},
        {"scale_factor": np.nan},
        {"units": "months since 2024-01-01"},
    ],
)
def test_attributes_that_no_convention_explains_are_named_and_leave_the_numbers(
    tmp_path: Path, attributes: dict[str, Any]
) -> None:
    table = table_of(tmp_path / "a.h5", x=(RAMP, attributes))
    np.testing.assert_array_equal(table.columns["x"], RAMP)
    assert [finding.code for finding in table.findings] == ["attributes-left"]
    assert next(iter(attributes)) in table.findings[0].message


def test_attributes_that_change_nothing_are_not_worth_a_word(tmp_path: Path) -> None:
    neutral = {
        "scale_factor": 1.0,
        "add_offset": 0.0,
        "gain": 1.0,
        "offset": 0,
        "_FillValue": -1,
        "units": "bar",
    }
    table = table_of(
        tmp_path / "a.h5", x=(RAMP, {**neutral, "valid_range": np.array([0, 19]), "long_name": "x"})
    )
    np.testing.assert_array_equal(table.columns["x"], RAMP)
    assert table.findings == () and table.units["x"] == "bar"


def test_a_matrix_with_a_list_of_units_has_one_for_each_column(tmp_path: Path) -> None:
    table = table_of(
        tmp_path / "a.h5", log=(np.zeros((20, 3)) + RAMP[:, None], {"units": ["ms", "Bar", "1"]})
    )
    assert [table.units[f"log_{k}"] for k in (1, 2, 3)] == ["ms", "bar", ""]


@pytest.mark.parametrize(
    ("name", "value", "unit"), [("dt", 10.0, "ms"), ("fs", 0.1, "kHz"), ("sample_rate", 100, "Hz")]
)
def test_a_sampling_time_or_rate_counts_in_the_unit_of_its_attribute(
    tmp_path: Path, name: str, value: float, unit: str
) -> None:
    table = table_of(tmp_path / "a.h5", x=(RAMP, {}), **{name: (value, {"units": unit})})
    np.testing.assert_allclose(table.columns[f"time_from_{name}"], RAMP * 0.01)


def test_what_long_names_explain_is_said(tmp_path: Path) -> None:
    table = table_of(tmp_path / "a.h5", ai0=(RAMP, {"long_name": "chamber pressure"}))
    assert "'ai0' is chamber pressure" in table.findings[0].message


@pytest.mark.parametrize("kind", ["b", "h", "i", "f", "d"])
def test_classic_netcdf_is_unpacked_too(tmp_path: Path, kind: str) -> None:
    with netcdf_file(tmp_path / "log.nc", "w") as out:
        out.createDimension("n", 20)
        for name, values in (("x", np.where(RAMP == 4, 99, RAMP)), ("y", RAMP % 7), ("t", RAMP)):
            out.createVariable(name, kind, ("n",))[:] = values
        out.variables["x"].scale_factor, out.variables["x"].add_offset = 0.5, 1.0
        out.variables["x"]._FillValue = np.array([99], kind)
        out.variables["t"].units = "days since 2024-01-01"
    rec = read_log(tmp_path / "log.nc", "x", "y")
    left = RAMP[RAMP != 4]
    np.testing.assert_allclose(rec.input, left * 0.5 + 1)
    np.testing.assert_allclose(rec.time, left * 86400.0)
