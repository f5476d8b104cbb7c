"""What attributes of netCDF and HDF5 say about stored numbers: scale, offset, missing values, valid range, unit.

The names and their meaning are those of the CF conventions, which netCDF and many loggers follow:
``value = scale_factor * stored + add_offset``; missing values and valid ranges are compared with what is stored. Limits
in the wider type of scale and offset are those of the value (NetCDF User's Guide, "Attribute Conventions").
"""

from __future__ import annotations

import datetime as dt
import re
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from dehyst.findings import Finding
from dehyst.io._collect import Collector
from dehyst.io._table import SHOWN, list_names
from dehyst.shell import visible
from dehyst.units import TABLE, canonical, dimension, words

Numbers = npt.NDArray[Any]
Mask = npt.NDArray[np.bool_]

NAMES = (
    "scale_factor", "add_offset", "_FillValue", "missing_value", "valid_range", "valid_min", "valid_max", "_Unsigned",
)  # fmt: skip
# Attributes of other loggers that change numbers as well. Nobody says how: they are named, not applied.
OTHERS = frozenset(
    words(
        "scale scaling scalefactor offset addoffset gain slope intercept lsb conversion conversionfactor calibration "
        "calibrationfactor sensitivity missing missingvalue nodata fillvalue validrange validmin validmax"
    )
)
NEUTRAL = {0.0, 1.0}  # a gain or an offset that changes nothing
# What netCDF stores where nothing was written and no _FillValue is declared; bytes have none.
UNWRITTEN = {
    "i2": -32767, "u2": 65535, "i4": -2147483647, "u4": 4294967295, "i8": -9223372036854775806,
    "u8": 18446744073709551614, "f4": np.float32(9.969209968386869e36), "f8": 9.969209968386869e36,
}  # fmt: skip
NAMELESS_UNITS = frozenset({"", "1", "-", "none", "dimensionless", "unitless", "no unit"})
SINCE = re.compile(r"(\S+)\s+since\s+(.*)", re.IGNORECASE | re.DOTALL)
DATE = re.compile(
    r"(\d{1,4})-(\d{1,2})-(\d{1,2})(?:[T\s]\s*(\d{1,2}):(\d{1,2})(?::(\d{1,2}(?:\.\d*)?))?)?"
    r"\s*(?:Z|UTC|GMT|([+-]\d{1,2})(?::?(\d{2}))?)?"
)
REAL_CALENDARS = frozenset({"", "standard", "gregorian", "proleptic_gregorian"})
DAYS = frozenset({"d", "day", "days"})
DAY = 86400.0  # [s]
MOST_MARKS = 100  # values that one attribute may declare as missing
MOST_TITLE = 80  # characters of a long name that a message shows


@dataclass
class ColumnReading:
    """Numbers of a dataset as its attributes mean them."""

    values: Numbers
    units: tuple[str, ...] = ()  # one for all columns of the dataset, or one for each
    start: float | None = None  # what a clock counts from, in seconds since 1970
    notes: list[str] = field(default_factory=list)  # what was done
    left: list[str] = field(default_factory=list)  # attributes that were not applied


def interpret(stored: Numbers, attributes: dict[str, Any], unwritten: bool) -> ColumnReading:
    """Numbers that a dataset stands for.

    Parameters
    ----------
    stored
        Numbers as they stand in the file.
    attributes
        Attributes of the dataset by name.
    unwritten
        Whether the file is of netCDF, whose own filling marks samples that were never written.

    Examples
    --------
    >>> attributes = {"scale_factor": 0.1, "_FillValue": -1, "units": "bar"}
    >>> reading = interpret(np.array([100, -1, 300], "i2"), attributes, False)
    >>> reading.values.tolist(), reading.units
    ([10.0, nan, 30.0], ('bar',))
    """
    reading = ColumnReading(stored)
    _note_others(reading, attributes)
    if stored.dtype.kind not in "iuf" or stored.size == 0:
        _read_unit(reading, attributes)
        return reading
    stored = _signed_as_meant(stored, attributes)
    numbers = {name: _numbers(attributes.get(name)) for name in NAMES[:-1]}
    scale = _factor(reading, "scale_factor", numbers["scale_factor"])
    offset = _factor(reading, "add_offset", numbers["add_offset"])
    if unwritten and numbers["_FillValue"] is None:
        numbers["_FillValue"] = _unwritten(stored.dtype)
    missing = _missing(reading, stored, numbers)
    values = stored
    if scale is not None or offset is not None:
        reading.notes.append(f"value = {scale or 1.0:.10g} x stored + {offset or 0.0:.10g}")
        with np.errstate(all="ignore"):
            values = stored.astype(np.float64) * (scale or 1.0) + (offset or 0.0)
    missing |= _outside(reading, stored, values, missing, numbers)
    if missing.any():
        values = values.astype(np.float64)
        values[missing] = np.nan
    reading.values = values
    _read_unit(reading, attributes)
    return reading


def _numbers(value: Any) -> Numbers | None:
    """Numbers of an attribute, also of one that was written as text; None if it holds none."""
    if value is None:
        return None
    array = np.ravel(np.asarray(value))
    if array.size == 0:
        return None
    if array.dtype.kind in "iufb":
        return array
    try:
        return np.array(list(map(float, texts_of(value))))
    except ValueError:
        return None


def texts_of(value: Any) -> list[str]:
    """Texts of an attribute, without blanks around them; none if it is anything else."""
    texts = []
    for item in np.ravel(np.asarray(value)).tolist():
        if isinstance(item, bytes):
            item = item.decode("utf-8", "replace")
        if isinstance(item, str):
            texts.append(item.strip("\0 \t\r\n"))
    return texts


def _listed(numbers: Numbers) -> str:
    text = ", ".join(map("{:g}".format, numbers[:SHOWN].tolist()))
    if numbers.size > SHOWN:
        text += " ..."
    return text


def _signed_as_meant(stored: Numbers, attributes: dict[str, Any]) -> Numbers:
    """Old netCDF knows no unsigned numbers: _Unsigned says which of the signed ones are meant so."""
    flag = "".join(texts_of(attributes.get("_Unsigned", ""))).lower()
    kind = {"true": "u", "false": "i"}.get(flag, stored.dtype.kind)
    if stored.dtype.kind == "f" or kind == stored.dtype.kind:
        return stored
    return stored.view(np.dtype(f"{stored.dtype.byteorder}{kind}{stored.dtype.itemsize}"))


def _factor(reading: ColumnReading, name: str, numbers: Numbers | None) -> float | None:
    """Scale or offset of a dataset; None if there is none or it changes nothing."""
    if numbers is None:
        return None
    factor = float(numbers[0])
    is_scale = name == "scale_factor"
    if numbers.size != 1 or not np.isfinite(factor) or (is_scale and factor == 0.0):
        reading.left.append(f"{name} = {_listed(numbers)}")
        return None
    if factor == float(is_scale):
        return None
    return factor


def _unwritten(dtype: np.dtype[Any]) -> Numbers | None:
    value = UNWRITTEN.get(f"{dtype.kind}{dtype.itemsize}")
    if value is None:
        return None
    return np.array([value], dtype=dtype)


def _missing(reading: ColumnReading, stored: Numbers, numbers: dict[str, Numbers | None]) -> Mask:
    """Samples that stand for none."""
    missing = np.zeros(stored.shape, dtype=bool)
    for name in ("_FillValue", "missing_value"):
        declared = numbers[name]
        if declared is None:
            continue
        before = int(np.count_nonzero(missing))
        for value in declared[:MOST_MARKS]:
            missing |= stored == _as_stored(value, stored.dtype)
        count = int(np.count_nonzero(missing)) - before
        _note_missing(reading, count, stored.size, f"{name} {_listed(declared)}")
    return missing


def _as_stored(value: Any, dtype: np.dtype[Any]) -> Any:
    """A number of an attribute in the type of the samples, in which it was written: -9999.9 is another as float32."""
    same_size = (
        np.dtype(type(value)).kind in "iu"
        and dtype.kind in "iu"
        and value.dtype.itemsize == dtype.itemsize
    )
    if dtype.kind == "f" or same_size:
        with np.errstate(all="ignore"):
            return np.asarray(value).astype(dtype)
    return value


def _note_missing(reading: ColumnReading, count: int, size: int, why: str) -> None:
    if count:
        reading.notes.append(f"{count} of {size} samples are missing ({why})")


def _outside(
    reading: ColumnReading,
    stored: Numbers,
    values: Numbers,
    missing: Mask,
    numbers: dict[str, Numbers | None],
) -> Mask:
    """Samples beyond the limits that are declared."""
    outside = np.zeros(stored.shape, dtype=bool)
    limits: list[tuple[str, Numbers | None, Numbers | None]] = [
        ("valid_min", numbers["valid_min"], None),
        ("valid_max", None, numbers["valid_max"]),
    ]
    both = numbers["valid_range"]
    if both is not None:
        limits.append(("valid_range", both[:1], both[-1:]))
    for name, low, high in limits:
        declared = [limit[0] for limit in (low, high) if limit is not None]
        if not declared:
            continue
        compared = stored
        if _of_values(declared[0].dtype, stored.dtype, numbers):
            compared = values
        beyond = np.zeros(stored.shape, dtype=bool)
        with np.errstate(invalid="ignore"):
            if low is not None:
                beyond |= compared < _as_stored(low[0], compared.dtype)
            if high is not None:
                beyond |= compared > _as_stored(high[0], compared.dtype)
        beyond &= ~missing
        limits_shown = list(map("{:g}".format, declared))
        if beyond.any() and bool((beyond | missing).all()):
            # Limits that leave nothing were written in another unit than the convention says.
            reading.left.append(f"{name} = {', '.join(limits_shown)}, which leaves no sample")
            continue
        count = int(np.count_nonzero(beyond & ~outside))
        _note_missing(reading, count, stored.size, f"outside {name} {' to '.join(limits_shown)}")
        outside |= beyond
    return outside


def _of_values(
    limit: np.dtype[Any], stored: np.dtype[Any], numbers: dict[str, Numbers | None]
) -> bool:
    """Whether a limit is one of the values, not of what is stored: in the type of scale and offset, a wider one."""
    widest = _width(stored)
    for name in ("scale_factor", "add_offset"):
        factor = numbers[name]
        if factor is not None:
            widest = max(widest, _width(factor.dtype))
    return _width(limit) == widest > _width(stored)


def _width(dtype: np.dtype[Any]) -> tuple[bool, int]:
    return dtype.kind == "f", dtype.itemsize


def _note_others(reading: ColumnReading, attributes: dict[str, Any]) -> None:
    """Keep attributes that look as if they changed the numbers, and are of no convention."""
    for name, value in attributes.items():
        if name in NAMES or "".join(words(name)) not in OTHERS:
            continue
        numbers = _numbers(value)
        if numbers is not None and not set(numbers.tolist()) <= NEUTRAL:
            reading.left.append(f"{name} = {_listed(numbers)}")


def _read_unit(reading: ColumnReading, attributes: dict[str, Any]) -> None:
    """Unit of a dataset. That of a clock may say since when it counts; days become seconds."""
    spelled = {name.lower(): value for name, value in attributes.items()}
    units: list[str] = []
    for name in ("units", "unit", "unit_string"):
        if name in spelled:
            units = texts_of(spelled[name])
            break
    since = None
    if len(units) == 1:
        since = SINCE.fullmatch(units[0])
    if since:
        calendar = "".join(texts_of(attributes.get("calendar", ""))).lower()
        if calendar in REAL_CALENDARS:
            reading.start = _seconds_since_1970(since[2])
        units = [since[1]]
        if units[0].lower() in DAYS:
            units, reading.values = ["s"], np.asarray(reading.values, dtype=np.float64) * DAY
        elif dimension(units[0]) != "time":  # months differ in length
            reading.left.append(f"units = {since[0]}")
    for k, unit in enumerate(units):
        if unit.lower() in NAMELESS_UNITS:
            units[k] = ""
    reading.units = tuple(units)


def _seconds_since_1970(text: str) -> float | None:
    """Seconds from 1970 to a date such as ``2024-1-1 12:00:00 +01:00``, None if it cannot be read.

    Examples
    --------
    >>> _seconds_since_1970("1970-01-02"), _seconds_since_1970("1970-1-1 02:00 +02:00"), _seconds_since_1970("start")
    (86400.0, 0.0, None)
    """
    match = DATE.fullmatch(text.strip())
    if not match:
        return None
    year, month, day = map(int, match.group(1, 2, 3))
    hour, minute, second = int(match[4] or 0), int(match[5] or 0), float(match[6] or 0)
    # Hours and minutes of a zone have one sign.
    minutes_ahead = 60 * int(match[8] or 0)
    if (match[7] or "").startswith("-"):
        minutes_ahead = -minutes_ahead
    ahead = int(match[7] or 0) * 3600 + minutes_ahead
    try:
        midnight = dt.datetime(year, month, day, tzinfo=dt.UTC).timestamp()
    except ValueError:
        return None
    return midnight + 3600 * hour + 60 * minute + second - ahead


@dataclass
class Attributes:
    """Gathers what the attributes of a file did to its columns."""

    log: Collector
    starts: dict[str, float] = field(
        default_factory=dict
    )  # clock -> what it counts from, in seconds since 1970
    notes: list[str] = field(default_factory=list)
    left: list[str] = field(default_factory=list)
    titles: list[str] = field(default_factory=list)

    def add(self, path: str, stored: Numbers, attributes: dict[str, Any], unwritten: bool) -> None:
        """Add a dataset to the columns of its file."""
        reading = interpret(stored, attributes, unwritten)
        common_unit = ""
        if len(reading.units) == 1:
            common_unit = reading.units[0]
        added = self.log.add(path, reading.values, common_unit)
        names = list(filter(self.log.columns.__contains__, added))
        if not names:
            return
        if len(reading.units) == len(names) > 1:
            for name, unit in zip(names, reading.units, strict=True):
                if unit:
                    self.log.units[name] = canonical(unit) or unit
        if reading.start is not None:
            self.starts.update(dict.fromkeys(names, reading.start))
        if reading.notes:
            self.notes.append(f"'{path}': {'; '.join(reading.notes)}")
        if reading.left:
            self.left.append(f"'{path}': {'; '.join(reading.left)}")
        title = visible(" ".join(texts_of(attributes.get("long_name", ""))))[:MOST_TITLE]
        if title and not set(words(title)) & set(words(path)):
            self.titles.append(f"'{path}' is {title}")

    def finish(self) -> None:
        """Put all clocks on one beginning, and say what was done and what was left."""
        self._align()
        log, findings = self.log.name, self.log.findings
        if self.notes:
            findings.append(
                Finding(
                    "attributes-applied",
                    f"attributes of {log} say what its stored numbers mean, and were applied: "
                    f"{list_names(self.notes, SHOWN)}. Nothing to do, if the numbers were stored as they say.",
                )
            )
        if self.left:
            findings.append(
                Finding(
                    "attributes-left",
                    f"attributes of {log} may change what its numbers mean, and were not applied: "
                    f"{list_names(self.left, SHOWN)}. Where they belong to the numbers, convert these yourself, or "
                    f"write the attributes as the CF conventions name them: scale_factor, add_offset, _FillValue.",
                )
            )
        if self.titles:
            explained = list_names(self.titles, SHOWN)
            findings.append(
                Finding("column-titles", f"{log} explains its names: {explained}. Nothing to do.")
            )

    def _align(self) -> None:
        """Clocks that count from several dates count from the earliest of them."""
        if len(set(self.starts.values())) < 2:
            return
        first = min(self.starts.values())
        for name, start in self.starts.items():
            factor = TABLE["time"].get(self.log.units[name], 1.0)
            self.log.columns[name] = self.log.columns[name] + (start - first) / factor
