"""Tally: what a pass over a log in chunks has met with so far."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array, Rows
from dehyst.data.gaps import gap_limit
from dehyst.findings import Finding
from dehyst.io.columns import MAX_NUMBERED_RUNS
from dehyst.io.table import Table, list_rows

SHOWN = 4  # rows that are named in a finding


class Tally:
    """Counts of a pass: the runs met with, in the order of the log, and the rows of the first and the last sample."""

    def __init__(self, table: Table, columns: tuple[str, str, str | None, str | None]) -> None:
        self._table, self._columns = table, [name for name in columns[:3] if name is not None]
        self.runs: dict[str, None] = {}
        self.first = self.last = 0
        self._rows = self._bad = self._back = self._gaps = 0
        self._bad_rows: list[int] = []
        self._back_rows: list[int] = []
        self._gap_rows: list[int] = []
        self._limit: float | None = None
        self._time = np.nan
        self._longest = 0.0

    def meet_runs(self, labels: npt.NDArray[np.str_]) -> None:
        """Note the runs of some rows."""
        if labels.size and len(self.runs) <= MAX_NUMBERED_RUNS:
            starts = np.concatenate(([True], labels[1:] != labels[:-1]))
            self.runs.update(dict.fromkeys(label for label in labels[starts].tolist() if label))

    def leave_out(self, rows: Rows) -> None:
        """Note rows without numbers."""
        self._rows += rows.size
        self._bad += rows.size
        self._bad_rows += rows[: SHOWN - len(self._bad_rows)].tolist()

    def count(self, rows: Rows, time: Array | None) -> None:
        """Note samples: their rows, and their time [s]."""
        self.first = self.first or int(rows[0])
        self.last = int(rows[-1])
        self._rows += rows.size
        if time is None:
            return
        if self._limit is None:  # by the first chunk, as what a gap is cannot wait for the last one
            self._limit = gap_limit(np.diff(time)) if time.size > 2 else np.inf
        step = np.diff(time, prepend=self._time)
        self._time = float(time[-1])
        back, gaps = np.flatnonzero(step < 0), np.flatnonzero(step > self._limit)
        self._back += back.size
        self._back_rows += rows[back[: SHOWN - len(self._back_rows)]].tolist()
        self._gaps += gaps.size
        self._gap_rows += rows[gaps[: SHOWN - len(self._gap_rows)]].tolist()
        self._longest = max(self._longest, float(np.max(step[gaps], initial=0.0)))

    def findings(self) -> list[Finding]:
        """Findings for what was met with."""
        name, word = self._table.name, self._table.row_word
        found = []
        if self._bad:
            found.append(
                Finding(
                    "non-finite",
                    f"{self._bad} of {self._rows} rows of {name} were left out because a cell of "
                    f"{', '.join(self._columns)} is empty, infinite or not a number: "
                    f"{_listed(self._bad_rows, self._bad, word)}. Nothing to do if the sensor is known to drop out; "
                    f"otherwise check its cable.",
                )
            )
        if self._gaps:
            found.append(
                Finding(
                    "gap",
                    f"{name} has {self._gaps} gap{'s' if self._gaps > 1 else ''}, before "
                    f"{_listed(self._gap_rows, self._gaps, word)}; the longest is {self._longest:.4g} s. The log was "
                    f"read in chunks, and the recording goes on across them. Cut the log there if the input may have "
                    f"turned unseen.",
                )
            )
        if self._back:
            found.append(
                Finding(
                    "clock-restart",
                    f"the clock of {name} jumps back {self._back} times, at "
                    f"{_listed(self._back_rows, self._back, word)}. The log was read in chunks, in the order of its "
                    f"rows, and the recording goes on. If several recordings follow each other, split the log.",
                )
            )
        return found


def _listed(rows: list[int], count: int, word: str) -> str:
    more = count - len(rows)
    return list_rows(rows, word) + (f" and {more} more" if more > 0 else "")
