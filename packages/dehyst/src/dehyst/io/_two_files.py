"""Reads input and output from two files, each with a clock of its own or none."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np

from dehyst.arrays import Array
from dehyst.data import Recording
from dehyst.errors import ParameterError, TimeError
from dehyst.findings import Finding
from dehyst.io._alignment import Alignment, align
from dehyst.io._clean import Samples
from dehyst.io._clocks import (
    choose_clock,
    clock_names,
    counting_clock,
    refuse_clock,
    with_clock,
)
from dehyst.io._columns import find_column
from dehyst.io._dates import join_dates
from dehyst.io._formats import PathLike, read_table
from dehyst.io._logs import origin_of
from dehyst.io._policy import POLICY
from dehyst.io._select import (
    WHOLE,
    context,
    parse_window,
    prepare_recording,
    read_pair,
    select_rows,
    selected_samples,
)
from dehyst.io._table import LogTable, unique_names, usual_step

CLOCKS = ("auto", "stamps", "shape")
NAMELESS = re.compile(r"column_\d+")
IN_CLOCK, OUT_CLOCK = "time of the input", "time of the output"


class SignalPlace(NamedTuple):
    """A column of a file."""

    path: Path
    column: str


def signal_place(text: PathLike) -> SignalPlace | None:
    r"""Take ``FILE:COLUMN`` apart; None if it names a file alone.

    A file of that very name wins, and a drive is no file: ``C:\log.csv`` is one name.

    Examples
    --------
    >>> signal_place("u.csv:voltage").column, signal_place("u.csv"), signal_place("C:/log.csv")
    ('voltage', None, None)
    """
    typed = str(text)
    if ":" not in typed or Path(typed).exists():
        return None
    ends = [match.start() for match in re.finditer(":", typed)]
    likely = None
    for end in ends:
        path, column = Path(typed[:end]), typed[end + 1 :]
        if not column or not path.name:
            continue
        if path.is_file():
            return SignalPlace(path, column)
        # A file that is not there is still meant where its name ends like one, so that the error names it.
        if likely is None and path.suffix:
            likely = SignalPlace(path, column)
    return likely


def two_places(logs: Sequence[PathLike]) -> tuple[SignalPlace, SignalPlace] | None:
    """Return the places of input and output, if logs are typed as ``FILE:COLUMN``; None if they are whole files.

    Raises
    ------
    ParameterError
        If they are one such place, more than two, or mixed with whole files.
    """
    places = [place for place in map(signal_place, logs) if place is not None]
    if not places:
        return None
    if len(places) != 2 or len(logs) != 2:
        typed = " ".join(map(str, logs))
        raise ParameterError(
            f"'{typed:.100}' names {len(places)} column{'s' * (len(places) > 1)} of files in {len(logs)} arguments; "
            f"two are needed, the input first: dehyst identify u.csv:voltage y.csv:position. For two columns of one "
            f"file type: dehyst identify log.csv --input COLUMN --output COLUMN"
        )
    return places[0], places[1]


@dataclass(frozen=True, eq=False)
class _ClockedColumn:
    """A column of a file on its own clock."""

    table: LogTable
    column: str
    run: str | None
    clock: str | None
    samples: Samples  # as logged, in seconds from `origin`
    origin: float  # since 1970, 0 where the clock is not absolute [s]
    absolute: bool
    findings: list[Finding]

    @property
    def file(self) -> str:
        """Name of the file."""
        return self.table.name

    @property
    def label(self) -> tuple[str, str]:
        """Name and unit; a column without a name is called like its file."""
        bare, unit = self.table.label(self.column)
        if NAMELESS.fullmatch(bare):
            bare = Path(self.file).stem
        return bare, unit

    def cleaned(self) -> Samples:
        """Samples without what reading leaves out; what it says of them is said later."""
        about = replace(context(self.table, (self.column,)), findings=[])
        clean = prepare_recording(self.samples, about, WHOLE)
        if clean.breaks:
            raise TimeError(
                f"the clock of {self.file} restarts {len(clean.breaks)} times, and recordings on several clocks cannot "
                f"be aligned with another file. Keep one recording in each file.",
                file=self.file,
            )
        return clean


def read_two_files(
    input: tuple[PathLike, str],
    output: tuple[PathLike, str],
    *,
    clocks: Literal["auto", "stamps", "shape"] | str = "auto",
    time: str | None = None,
    run: str | None = None,
    time_unit: str | float | None = None,
    sheet: str | int | None = None,
    start: float | None = None,
    stop: float | None = None,
    dt: float | None = None,
) -> Recording:
    """Read the input of an actuator from one file and its output from another, logged by two instruments.

    The output is interpolated at the samples of the input. Its time in the input's clock is

        t = begin + (1 + drift) (t_out - t_out[0])

    where `begin` and `drift` are those of the stamps, or those under which the output follows the input best as a sum
    of plays. Such a sum has loops of any width and turns when its input turns: width is not taken for an offset, while
    a lag of the actuator is, since the shape of two signals cannot tell one from the other.

    Parameters
    ----------
    input, output
        File and column, named as for `read_log`.
    clocks
        ``"stamps"``: both files were stamped by one clock. ``"shape"``: align them. ``"auto"``: keep equal stamps, and
        dates or epochs that overlap; align all others.
    time, run, time_unit, sheet
        As for `read_log`, in both files.
    start, stop
        Window in the input's own time. [s]
    dt
        Seconds from one row to the next, in the files without a time column.

    Returns
    -------
    recording : Recording
        On the samples and the clock of the input; findings say what was done with the clocks, and
        ``provenance["clocks"]`` has the numbers.

    Raises
    ------
    LogError
        If a file cannot be read; ColumnError, RunError and TimeError if it does not hold what was asked for.
    TimeError
        If the clocks do not overlap, or no offset makes the output follow the input.
    ParameterError
        If `clocks` is none of the three.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> folder = pathlib.Path(tempfile.mkdtemp())
    >>> t = np.arange(0.0, 60.0, 0.05)
    >>> u = lambda t: np.sin(t) + 0.4 * np.sin(0.37 * t)
    >>> np.savetxt(folder / "u.csv", np.c_[t, u(t)], delimiter=",", header="time_s,voltage_V", comments="")
    >>> rows = np.c_[t, 3 * u(t + 2.5)][:999]
    >>> np.savetxt(folder / "y.csv", rows, delimiter=",", header="time_s,position_mm", comments="")
    >>> rec = read_two_files((folder / "u.csv", "voltage"), (folder / "y.csv", "position"))
    >>> round(rec.provenance["clocks"]["begin_s"], 2), rec.findings[0].code
    (2.5, 'aligned-clocks')
    """
    if clocks not in CLOCKS:
        raise ParameterError(
            f"--clocks {clocks!r:.40} is none of {', '.join(CLOCKS)}: stamps, if one clock stamped both files; shape, "
            f"to align them by their signals."
        )
    window = parse_window(start, stop)
    tables = [read_table(input[0], sheet), read_table(output[0], sheet)]
    clocked = [bool(clock_names(join_dates(table))) for table in tables]
    signals: list[_ClockedColumn] = []
    for table, has_clock, column, role in zip(
        tables, clocked, (input[1], output[1]), ("input", "output"), strict=True
    ):
        by_rows = dt is not None and (not has_clock or all(clocked))
        if by_rows:
            table = with_clock(table, None, None, dt)
            signals.append(_signal(table, column, role, None, run))
        else:
            if has_clock or dt is None:
                table = with_clock(table, time_unit if has_clock else None, time)
            signals.append(_signal(table, column, role, time if has_clock else None, run))
    x, y = signals
    stamps, alignment, findings = _on_input_clock(x, y, clocks, dt)
    joint = _joint(x, y, stamps)
    about = context(joint, joint.order[:2], [*x.findings, *y.findings, *findings])
    samples, _, _ = read_pair(joint, about, None, None, window)
    if alignment is not None:
        # Of the two clocks the alignment has said more.
        about.findings[:] = [entry for entry in about.findings if entry.code != "two-clocks"]
    in_file = replace(samples, rows=x.samples.rows[samples.rows - 1])
    columns = {"input": x.column, "output": y.column, "time": x.clock}
    origin = origin_of(x.table, columns, x.run, start, stop, in_file)
    origin |= {"output_file": y.file, "output_sha256": y.table.sha256}
    if alignment is not None:
        origin["clocks"] = {
            "begin_s": alignment.begin - float(_stamps(x)[0]),
            "begin_doubt_s": alignment.begin_doubt,
            "drift_ppm": 1e6 * alignment.drift,
            "drift_doubt_ppm": 1e6 * alignment.drift_doubt,
        }
    return Recording(
        input=samples.values[0],
        output=samples.values[1],
        time=samples.time,
        name=joint.name,
        input_name=x.label[0],
        output_name=y.label[0],
        input_unit=x.label[1],
        output_unit=y.label[1],
        breaks=samples.breaks,
        findings=tuple(about.findings),
        provenance=origin,
    )


def _signal(
    table: LogTable, column: str, role: str, time: str | None, run: str | None
) -> _ClockedColumn:
    """One column of a table, in seconds."""
    name = find_column(table, column, role)
    refuse_clock(table, name, role)
    about = context(table, (name,))
    clock = choose_clock(table, name, time)
    chosen, mask = select_rows(table, name, run)
    samples = selected_samples(table, (name,), clock, mask, about)
    origin, absolute = 0.0, False
    if clock is not None and samples.time is not None:
        shifted = selected_samples(
            table, (name,), clock, mask, replace(about, findings=[]), shift=True
        )
        assert shifted.time is not None
        absolute = counting_clock(table, clock)[1]
        both = np.isfinite(samples.time)
        if both.any():
            origin = float(np.median(shifted.time[both] - samples.time[both]))
    return _ClockedColumn(table, name, chosen, clock, samples, origin, absolute, about.findings)


def _stamps(signal: _ClockedColumn) -> Array:
    """Stamps of a signal, in seconds."""
    time = signal.cleaned().time
    assert time is not None
    return time


def _on_input_clock(
    x: _ClockedColumn, y: _ClockedColumn, clocks: str, dt: float | None
) -> tuple[Array | None, Alignment | None, list[Finding]]:
    """Stamps of the output in the input's clock, how they were found, and what is to be said of that."""
    tx, ty = x.samples.time, y.samples.time
    if tx is None and ty is None and x.samples.rows.size == y.samples.rows.size:
        return None, None, []
    _refuse_without_clock(x, y, dt)
    assert tx is not None and ty is not None
    common = x.absolute == y.absolute
    logged = ty + (y.origin - x.origin)
    if clocks == "stamps":
        _refuse_apart(x, y, common)
        return logged, None, []
    clean_x, clean_y = x.cleaned(), y.cleaned()
    assert clean_x.time is not None and clean_y.time is not None
    alignment = align(clean_x.time, clean_x.values[0], clean_y.time, clean_y.values[0])
    shift = float(clean_y.time[0]) + (y.origin - x.origin)
    dated = x.absolute and y.absolute and _overlap(tx, logged)
    # Equal stamps were written by one logger, or by two that both begin at zero: the shape then says so.
    if clocks == "auto" and (dated or (common and _equal(tx, logged))):
        return logged, None, _beside_stamps(x, y, alignment, shift)
    if alignment is None or alignment.explained < POLICY.least_explained:
        raise _no_agreement(x, y, alignment, common)
    lead = alignment.begin - float(clean_x.time[0])
    findings = [_aligned(x, y, alignment, lead)]
    if alignment.rival is not None:
        findings.append(_alike(x, y, alignment))
    stamps = alignment.begin + (1.0 + alignment.drift) * (ty - clean_y.time[0])
    return stamps, alignment, findings


def _refuse_without_clock(x: _ClockedColumn, y: _ClockedColumn, dt: float | None) -> None:
    """Refuse signals without stamps that are not row by row."""
    missing = [signal for signal in (x, y) if signal.samples.time is None]
    if not missing:
        return
    sizes = f"{x.file} has {x.samples.rows.size} samples, {y.file} {y.samples.rows.size}"
    raise TimeError(
        f"{sizes}, and {' and '.join(signal.file for signal in missing)} no time column, so nothing tells which belong "
        f"together. Say how many seconds lie between two rows, such as --dt 0.001: then the files are aligned by the "
        f"shape of their signals.",
        log=missing[0].file,
    )


def _equal(tx: Array, ty: Array) -> bool:
    """Whether two logs have the same stamps."""
    if tx.size != ty.size:
        return False
    return bool(np.nanmax(np.abs(tx - ty), initial=0.0) <= POLICY.equal_stamps * usual_step(tx))


def _overlap(tx: Array, ty: Array) -> bool:
    """Whether two logs cover a common time that is enough to compare them."""
    common = min(np.nanmax(tx), np.nanmax(ty)) - max(np.nanmin(tx), np.nanmin(ty))
    shorter = min(np.nanmax(tx) - np.nanmin(tx), np.nanmax(ty) - np.nanmin(ty))
    return bool(common >= POLICY.least_overlap * shorter)


def _refuse_apart(x: _ClockedColumn, y: _ClockedColumn, common: bool) -> None:
    """Refuse to keep stamps that have no common zero."""
    if common:
        return
    dated, other = (x, y) if x.absolute else (y, x)
    raise TimeError(
        f"the stamps of {dated.file} are dates or count from 1970, those of {other.file} begin elsewhere, so they have "
        f"no common zero. Align them by their signals: --clocks shape",
        log=other.file,
    )


def _no_agreement(
    x: _ClockedColumn, y: _ClockedColumn, alignment: Alignment | None, common: bool
) -> TimeError:
    """What is wrong where no offset makes the output follow the input."""
    sizes = f"{x.samples.rows.size} and {y.samples.rows.size} samples"
    result = f"they are too short to compare ({sizes})"
    explained = 0.0
    if alignment is not None:
        explained = alignment.explained
        result = (
            f"at the best offset {100 * explained:.0f} % of the variance of '{y.label[0]}' follow '{x.label[0]}', and "
            f"{100 * POLICY.least_explained:.0f} % are needed"
        )
    cure = "Check that the files are of one motion, the columns, and --dt."
    if common:
        cure += " If one clock stamped both files, keep its stamps: --clocks stamps"
    return TimeError(
        f"the clocks of {x.file} and {y.file} cannot be aligned by their signals: {result}. {cure}",
        explained=explained,
    )


def _aligned(x: _ClockedColumn, y: _ClockedColumn, alignment: Alignment, lead: float) -> Finding:
    """Say which offset and drift were taken out, and what they may be."""
    drift = f"no drift is seen (less than {1e6 * alignment.drift_doubt:.2g} ppm)"
    if alignment.drift:
        pace = "slow" if alignment.drift > 0.0 else "fast"
        drift = (
            f"its clock is {abs(1e6 * alignment.drift):.3g} ppm {pace} (within "
            f"{1e6 * alignment.drift_doubt:.2g} ppm)"
        )
    side = "after" if lead >= 0.0 else "before"
    return Finding(
        "aligned-clocks",
        f"clocks of {x.file} and {y.file}, by the shape of the signals: {y.file} begins {abs(lead):.6g} s {side} "
        f"{x.file} (within {alignment.begin_doubt:.2g} s); {drift}; {100 * alignment.explained:.4g} % of its variance "
        f"follow the input then. A lag of the actuator or a sensor makes the output turn late as well. The shape "
        f"cannot tell it from the clocks, and it was taken out with them. If one clock stamped both files, keep its "
        f"stamps: --clocks stamps",
    )


def _alike(x: _ClockedColumn, y: _ClockedColumn, alignment: Alignment) -> Finding:
    """Say that another period would do as well."""
    assert alignment.rival is not None
    away = alignment.rival - alignment.begin
    side = "later" if away > 0.0 else "earlier"
    return Finding(
        "alike-periods",
        f"{y.file} would follow {x.file} as well if it began {abs(away):.4g} s {side}: the motion repeats itself. "
        f"For a model of the loop it matters little. If it matters to you, begin the log with a motion that comes "
        f"once, such as a small loop, and log it with both instruments.",
    )


def _beside_stamps(
    x: _ClockedColumn, y: _ClockedColumn, alignment: Alignment | None, shift: float
) -> list[Finding]:
    """What the shape says about stamps that were kept."""
    if alignment is None or alignment.explained < POLICY.least_explained:
        return []
    half = 0.5 * float(np.ptp(_stamps(y)))
    late = shift - alignment.begin - alignment.drift * half
    if abs(late) <= alignment.begin_doubt:
        return []
    side = "after" if late > 0.0 else "before"
    cause = "That is a lag of the actuator or a sensor, or the clocks differ"
    if late < 0.0:
        cause = "No actuator does that, so the clocks differ"
    return [
        Finding(
            "shape-offset",
            f"by the stamps of {x.file} and {y.file} the output turns {abs(late):.3g} s {side} the input (within "
            f"{alignment.begin_doubt:.2g} s). {cause}. The stamps were kept. To take the offset out: --clocks shape",
        )
    ]


def _joint(x: _ClockedColumn, y: _ClockedColumn, stamps: Array | None) -> LogTable:
    """Both signals as one table, each with its clock, both in the time of the input."""
    x_label, y_label = x.label, y.label
    names = unique_names([x_label[0], y_label[0], IN_CLOCK, OUT_CLOCK])
    columns: dict[str, Array] = {names[0]: x.samples.values[0], names[1]: y.samples.values[0]}
    clocks = {}
    if stamps is not None and x.samples.time is not None:
        columns[names[2]], columns[names[3]] = x.samples.time, stamps
        clocks = {names[0]: names[2], names[1]: names[3]}
    return LogTable(
        name=f"{x.file} and {y.file}",
        columns=columns,
        units={names[0]: x_label[1], names[1]: y_label[1], names[2]: "s", names[3]: "s"},
        rows=np.arange(1, max(x.samples.rows.size, y.samples.rows.size) + 1),
        row_word="sample",
        clocks=clocks,
        order=tuple(columns),
    )
