"""Collector: arrays of a binary log become columns, labels and clocks of a table."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.findings import Finding
from dehyst.io.clocks import TIME_WORDS, is_clock
from dehyst.io.streams import labels_of, numbers_of
from dehyst.io.table import Table, require_columns
from dehyst.shell import visible
from dehyst.units import canonical, parse_unit, words

MAX_COLUMNS = 4000
MAX_WIDTH = 64  # a wider matrix is a picture or a point cloud, not signals
STEP_NAMES = frozenset(["ts", "dt", "sampletime", "samplingtime", "sampleperiod", "stepsize"])
RATE_NAMES = frozenset(["fs", "samplerate", "samplingrate", "samplefrequency", "samplingfrequency"])


@dataclass
class Collector:
    """Gathers what a binary log holds: columns and all that belongs to them as in `Table`, and what was noticed."""

    name: str
    columns: dict[str, Array] = field(default_factory=dict)
    labels: dict[str, npt.NDArray[np.str_]] = field(default_factory=dict)
    units: dict[str, str] = field(default_factory=dict)
    clocks: dict[str, str] = field(default_factory=dict)
    stamps: set[str] = field(default_factory=set)
    scalars: dict[str, float] = field(default_factory=dict)
    findings: list[Finding] = field(default_factory=list)

    def add(self, path: str, value: Any, unit: str = "") -> list[str]:
        """Add an array under a path; return the names of the columns it became.

        A vector becomes one column, a matrix one column per signal (``path_1``, ``path_2``, ...) with time along
        its longer side, a single number a scalar. Whatever is no signal is passed over.
        """
        path, unit = visible(path), visible(unit)
        array = np.asarray(value)
        if array.dtype.names:
            fields = ((f"{path}.{f}" if path else f, array[f]) for f in array.dtype.names)
            return [name for sub, part in fields for name in self.add(sub, part)]
        if array.dtype.kind in "mM":
            names = self.add(path, numbers_of(array), "s")
            self.stamps.update(names if array.dtype.kind == "M" else [])
            return names
        if array.dtype.kind in "US":
            self._add_labels(path, array)
            return []
        if array.dtype.kind not in "fiub" or array.size == 0:
            return []
        array = np.squeeze(array)
        if array.ndim == 0:
            self.scalars[path] = float(array)
            return []
        if array.ndim == 1:
            return [self._put(path, array, unit)]
        if array.ndim != 2:
            return []
        if array.shape[0] < array.shape[1]:
            array = array.T
        if array.shape[1] > MAX_WIDTH:
            return []
        return [self._put(f"{path}_{k + 1}", array[:, k], unit) for k in range(array.shape[1])]

    def _put(self, path: str, vector: npt.NDArray[Any], unit: str) -> str:
        if len(self.columns) >= MAX_COLUMNS:
            return path
        name, k = path, 1
        while name in self.columns:
            k += 1
            name = f"{path}_{k}"
        with np.errstate(all="ignore"):
            self.columns[name] = np.ascontiguousarray(vector, dtype=np.float64)
        self.units[name] = (canonical(unit) or unit) if unit else parse_unit(name.rpartition(".")[2])[1]
        return name

    def _add_labels(self, path: str, array: npt.NDArray[Any]) -> None:
        flat = np.atleast_1d(np.squeeze(array))
        if flat.ndim == 1 and flat.size > 1:
            self.labels[path] = labels_of(flat)

    def table(self, sha256: str) -> Table:
        """Finish: find the clocks of structs, make time from a sampling time, and build the table.

        Raises
        ------
        LogError
            If there is no column of numbers.
        """
        self._sibling_clocks()
        self._time_from_step()
        longest = max((column.size for column in self.columns.values()), default=0)
        return require_columns(
            Table(
                name=self.name,
                columns=self.columns,
                units=self.units,
                rows=np.arange(1, longest + 1, dtype=np.int64),
                labels=self.labels,
                row_word="sample",
                clocks=self.clocks,
                stamps=frozenset(self.stamps),
                scalars=self.scalars,
                sha256=sha256,
                findings=tuple(self.findings),
            )
        )

    def _sibling_clocks(self) -> None:
        """A field called time in a struct is the clock of the fields beside and below it."""
        for name in list(self.columns):
            folder, dot, leaf = name.rpartition(".")
            if not dot or not set(words(leaf)) & TIME_WORDS:
                continue
            size = self.columns[name].size
            for other, values in self.columns.items():
                if other.startswith(folder + ".") and other != name and values.size == size:
                    self.clocks.setdefault(other, name)

    def _time_from_step(self) -> None:
        """Without any time column, a sampling time or rate stored beside the signals tells the time."""
        probe = self.as_probe()
        if not self.columns or any(is_clock(probe, name) for name in self.columns):
            return
        steps: list[tuple[str, float]] = []
        for path, value in self.scalars.items():
            leaf = "".join(words(path.rpartition(".")[2]))
            if value > 0 and np.isfinite(value) and leaf in STEP_NAMES | RATE_NAMES:
                steps.append((path, value if leaf in STEP_NAMES else 1.0 / value))
        if len(steps) != 1:
            return
        path, step = steps[0]
        longest = max(column.size for column in self.columns.values())
        made = self._put(f"time_from_{path}", np.arange(longest) * step, "s")
        self.findings.append(
            Finding("time-from-step", f"{self.name} holds no time column; time was counted from {path}: {step:g} s.")
        )
        self.clocks.update({name: made for name, v in self.columns.items() if v.size == longest and name != made})

    def as_probe(self) -> Table:
        """Table of the columns so far, to ask which of them is a clock."""
        return Table(self.name, self.columns, self.units, np.zeros(0, dtype=np.int64), stamps=frozenset(self.stamps))


def strings_of(rows: Sequence[Any]) -> npt.NDArray[np.str_] | None:
    """Labels from a sequence of strings, or None if it holds anything else.

    Examples
    --------
    >>> strings_of(["a", "bc"]).tolist(), strings_of(["a", 1])
    (['a', 'bc'], None)
    """
    return np.array(rows, dtype=np.str_) if rows and all(isinstance(row, str) for row in rows) else None
