"""Recording: input, output and time of a test-rig log, ready for identification."""

from __future__ import annotations

import itertools
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array, Rows
from dehyst.data._loops import turning_points
from dehyst.data._plotted import Plotted
from dehyst.data._ranges import range_of
from dehyst.errors import MissingExtraError, ParameterError, RecordingError
from dehyst.findings import Finding

MINIMUM_SAMPLES = 4


def _signal(values: npt.ArrayLike, role: str, name: str) -> Array:
    try:
        array = np.array(values, dtype=np.float64, copy=True, order="C")
    except (TypeError, ValueError) as fault:
        raise RecordingError(
            f"{role} of recording '{name}' is not a sequence of numbers ({fault}). "
            f"Pass a one-dimensional array of numbers: Recording(input=x, output=y, time=t).",
            role=role,
        ) from None
    if array.ndim != 1:
        raise RecordingError(
            f"{role} of recording '{name}' has shape {array.shape}, but one value a sample is needed. "
            f"Pass one column, shape (T,), for example data[:, 0].",
            role=role,
            shape=array.shape,
        )
    bad = np.flatnonzero(~np.isfinite(array))
    if bad.size:
        raise RecordingError(
            f"{role} of recording '{name}' has {bad.size} samples that are not finite, the first at "
            f"index {bad[0]}. A play operator would carry them into every later sample. Drop those samples "
            f"(keep = numpy.isfinite(x) & numpy.isfinite(y)), or let dehyst.read_log do it.",
            role=role,
            indices=bad,
        )
    array.flags.writeable = False
    return array


@dataclass(frozen=True, eq=False)
class Recording(Plotted):
    """One log of an actuator: input and output sampled together.

    Values stay in the units of the log; a rate-independent model has no other units than its data.

    Parameters
    ----------
    input
        What drives the actuator, x, (T,), for example pressure. [input_unit]
    output
        What the actuator does, y, (T,), for example angle. [output_unit]
    time
        Time of each sample, (T,), strictly increasing within a piece, or None. [s]
    name
        Used in messages and figures.
    input_name, output_name
        Names of the two signals, for axis labels.
    input_unit, output_unit
        Units, or "" where they are not known.
    breaks
        Indices k, increasing, such that nothing is known about the input between samples k-1 and k: the
        memory of the actuator is unknown after each.
    findings
        What reading the log found and cured.
    provenance
        Where the samples came from: file, columns, rows.
    left_out
        Indices of samples that count in no fit and no score: at least one of their values is none that was measured.
        `identify` and its relatives add the outliers that they find.
    schedules, schedule_units
        Further signals by name, (T,) each, that change the loop, such as temperature, load or voltage, and their
        units: `identify` lets the weights of a model go with them.

    Raises
    ------
    RecordingError
        If lengths differ, a sample is not finite, time runs backward within a piece, or fewer than 4 samples remain.

    Examples
    --------
    >>> import numpy as np
    >>> t = np.linspace(0.0, 10.0, 101)
    >>> rec = Recording(input=np.sin(t), output=2 * np.sin(t), time=t, input_unit="bar")
    >>> len(rec)
    101
    >>> rec.input_label
    'input [bar]'
    """

    input: Array
    output: Array
    time: Array | None = None
    name: str = "recording"
    input_name: str = "input"
    output_name: str = "output"
    input_unit: str = ""
    output_unit: str = ""
    breaks: tuple[int, ...] = ()
    findings: tuple[Finding, ...] = ()
    provenance: Mapping[str, Any] = field(default_factory=dict)
    left_out: tuple[int, ...] = ()
    schedules: Mapping[str, Array] = field(default_factory=dict)
    schedule_units: Mapping[str, str] = field(default_factory=dict)

    @cached_property
    def input_range(self) -> tuple[float, float]:
        """Least and largest input. [input_unit]"""
        return range_of(self.input)

    @cached_property
    def output_range(self) -> tuple[float, float]:
        """Least and largest output. [output_unit]"""
        return range_of(self.output)

    def __post_init__(self) -> None:
        put = object.__setattr__  # frozen: normalise once, here
        put(self, "input", _signal(self.input, "input", self.name))
        put(self, "output", _signal(self.output, "output", self.name))
        put(self, "findings", tuple(self.findings))
        put(self, "provenance", dict(self.provenance))
        put(self, "breaks", tuple(int(k) for k in self.breaks))
        put(self, "left_out", tuple(sorted({int(k) for k in self.left_out})))
        if not isinstance(self.schedules, Mapping) or not all(map(str, self.schedules)):
            raise RecordingError(
                f"schedules of recording '{self.name}' are signals by their names, each with one. Pass for example "
                f'schedules={{"temperature": values}}.'
            )
        unknown = set(self.schedule_units) - set(self.schedules)
        if unknown:
            raise RecordingError(
                f"schedule_units of recording '{self.name}' names {', '.join(map(repr, sorted(unknown)))}, which is no "
                f"schedule; they are {', '.join(map(repr, self.schedules)) or 'none'}.",
                unknown=sorted(unknown),
            )
        schedules = {}
        for name, values in self.schedules.items():
            schedules[str(name)] = _signal(values, f"schedule '{name}'", self.name)
        put(self, "schedules", schedules)
        put(
            self,
            "schedule_units",
            {name: str(self.schedule_units.get(name, "")) for name in schedules},
        )
        if self.input.size != self.output.size:
            raise RecordingError(
                f"recording '{self.name}' has {self.input.size} input samples but {self.output.size} output "
                f"samples; sample k of both must belong together. Cut or resample them to one clock first.",
                input=self.input.size,
                output=self.output.size,
            )
        if self.input.size < MINIMUM_SAMPLES:
            raise RecordingError(
                f"recording '{self.name}' has {self.input.size} samples; a loop needs at least "
                f"{MINIMUM_SAMPLES}. Check the window (--from, --to) and the run (--run).",
                samples=self.input.size,
            )
        edges = (0, *self.breaks, self.input.size)
        if any(b <= a for a, b in itertools.pairwise(edges)):
            raise RecordingError(
                f"breaks of recording '{self.name}' must increase strictly and lie between 1 and "
                f"{self.input.size - 1}, got {self.breaks}.",
                breaks=self.breaks,
            )
        if self.left_out and not 0 <= self.left_out[0] <= self.left_out[-1] < self.input.size:
            raise RecordingError(
                f"left_out of recording '{self.name}' must hold indices from 0 to {self.input.size - 1}, got "
                f"{self.left_out[0]} to {self.left_out[-1]}.",
                left_out=self.left_out,
            )
        for name, values in self.schedules.items():
            if values.size != self.input.size:
                raise RecordingError(
                    f"schedule '{name}' of recording '{self.name}' has {values.size} values for {self.input.size} "
                    f"samples. Pass one value for each sample.",
                    schedule=name,
                    values=values.size,
                    samples=self.input.size,
                )
        if self.time is not None:
            self._check_time(edges)

    def _check_time(self, edges: tuple[int, ...]) -> None:
        time = _signal(self.time if self.time is not None else [], "time", self.name)
        object.__setattr__(self, "time", time)
        if time.size != self.input.size:
            raise RecordingError(
                f"recording '{self.name}' has {time.size} time stamps for {self.input.size} samples. "
                f"Pass one time per sample, or time=None.",
                time=time.size,
                samples=self.input.size,
            )
        backward = np.flatnonzero(np.diff(time) <= 0) + 1
        inside = np.setdiff1d(backward, np.array(edges[1:-1], dtype=np.int64))
        if inside.size:
            raise RecordingError(
                f"time of recording '{self.name}' does not increase at {inside.size} samples, the first at index "
                f"{inside[0]}. The order of the samples decides the memory of the model. Sort or drop them, "
                f"or let dehyst.read_log do it.",
                indices=inside,
            )

    def __len__(self) -> int:
        return int(self.input.size)

    @property
    def samples(self) -> int:
        """Number of samples behind the recording: more than its length if it stands for a longer log."""
        stands_for = self.provenance.get("samples")
        return stands_for if isinstance(stands_for, int) else len(self)

    @property
    def input_label(self) -> str:
        """Axis label of the input, ``name [unit]``."""
        return f"{self.input_name} [{self.input_unit}]" if self.input_unit else self.input_name

    @property
    def output_label(self) -> str:
        """Axis label of the output, ``name [unit]``."""
        return f"{self.output_name} [{self.output_unit}]" if self.output_unit else self.output_name

    @property
    def pieces(self) -> tuple[slice, ...]:
        """Index ranges between breaks; within each the memory is continuous."""
        edges = (0, *self.breaks, len(self))
        return tuple(slice(a, b) for a, b in itertools.pairwise(edges))

    @cached_property
    def _turns(self) -> dict[tuple[int, float], Rows]:
        return {}

    def turns(self, piece: slice, swing: float) -> Rows:
        """Where the input turns by more than `swing` within one of the `pieces`, counted from its start, (m,)."""
        key = (piece.start, swing)
        if key not in self._turns:
            self._turns[key] = turning_points(self.input[piece], swing)
        return self._turns[key]

    def signals(self, names: Sequence[str], part: slice = slice(None)) -> dict[str, Array]:
        """Return the schedules of these names along a part of the recording, (T,) each; as a model's `needs` asks."""
        return {name: np.ascontiguousarray(self.schedules[name][part]) for name in names}

    @classmethod
    def from_frame(
        cls, frame: Any, input: str, output: str, *, time: str | None = None, **more: Any
    ) -> Recording:
        """Return the recording of a data frame: columns are found, cleaned and reported as those of a file.

        Parameters
        ----------
        frame
            Of pandas, polars, Arrow or whatever narwhals knows; an index of times counts as a column.
        input, output, time
            As for `dehyst.read_log`.
        **more
            As for `dehyst.read_log`.

        Raises
        ------
        MissingExtraError
            If narwhals is not installed; else as `dehyst.read_log`.

        Examples
        --------
        >>> import pandas
        >>> table = pandas.DataFrame({"p [bar]": [0.0, 1.0, 2.0, 1.0], "angle": [0.0, 1.0, 3.0, 2.0]})
        >>> Recording.from_frame(table, input="p", output="angle").input_label
        'p [bar]'
        """
        import dehyst  # not its readers, which stand on this module: the public name finds them when it is called

        return dehyst.read_log(frame, input, output, time=time, **more)

    def to_frame(self, backend: str = "pandas") -> Any:
        """Return the samples as a frame of "pandas", "polars" or "pyarrow": time_s and all signals, with their units.

        Examples
        --------
        >>> Recording([0.0, 1, 2, 1], [0.0, 1, 3, 2], input_unit="bar").to_frame().columns.tolist()
        ['input [bar]', 'output']
        """
        columns = {} if self.time is None else {"time_s": self.time}
        columns |= {self.input_label: self.input, self.output_label: self.output}
        for name, values in self.schedules.items():
            unit = self.schedule_units[name]
            columns[f"{name} [{unit}]" if unit else name] = values
        try:
            import narwhals

            return narwhals.from_dict(columns, backend=backend).to_native()  # type: ignore[arg-type]
        except (ImportError, ValueError, TypeError) as fault:
            raise MissingExtraError(
                f"no frame of {backend!r:.40} can be made ({fault!s:.120}). Type to_frame('pandas'), 'polars' or "
                f"'pyarrow' once it is installed, and: pip install 'dehyst[frames]'",
                extra="frames",
            ) from None

    def with_findings(self, *more: Finding) -> Recording:
        """Return the same recording with further findings."""
        return replace(self, findings=(*self.findings, *more))


def require_recordings(recordings: Recording | Sequence[Recording]) -> tuple[Recording, ...]:
    """Return one recording or several as a tuple.

    Raises
    ------
    ParameterError
        If anything else was given; the message tells how to make a recording of it.
    """
    if isinstance(recordings, Recording):
        return (recordings,)
    records = tuple(recordings) if isinstance(recordings, Sequence | Iterator) else ()
    if records and all(isinstance(record, Recording) for record in records):
        return records
    mistake, cure = _made_of(recordings)
    raise ParameterError(
        f"a Recording or a list of Recordings is needed, and {mistake} was given: nothing tells what in it is input, "
        f"output and time. Type: recording = {cure}, and give that.",
        given=type(recordings).__name__,
    )


def _made_of(thing: Any) -> tuple[str, str]:
    """What was given for a recording, and the line that makes one of it."""
    if isinstance(thing, str | os.PathLike):
        return (
            f"the path {str(thing)!r:.80}",
            f"dehyst.read_log({str(thing)!r:.80}, input='...', output='...')",
        )
    names = [name for name in getattr(thing, "columns", ()) if isinstance(name, str)]
    if len(names) >= 2:
        shown = (
            f"a table with the columns {', '.join(names[:8])}{', ...' if len(names) > 8 else ''}"
        )
        x, y = names[-2:]
        time = f", time={names[0]!r}" if len(names) > 2 else ""
        return shown, f"dehyst.Recording.from_frame(table, input={x!r}, output={y!r}{time})"
    shape = getattr(thing, "shape", None)
    if isinstance(shape, tuple) and len(shape) == 2:
        return f"an array of shape {shape}", "dehyst.Recording(input=data[:, 0], output=data[:, 1])"
    made = "dehyst.Recording(input=u, output=y, time=t)"
    if shape is None and not (isinstance(thing, Sequence) and thing):
        return (
            f"{type(thing).__name__}",
            f"{made} of arrays, or dehyst.read_log(path, input=..., output=...) of a file",
        )
    return f"a {type(thing).__name__} of numbers", made


def counted_rows(record: Recording) -> Iterator[tuple[Rows, Array]]:
    """Yield the samples of each piece that are not left out, and their times, by number where there is no clock. [s]"""
    for piece in record.pieces:
        rows = np.setdiff1d(np.arange(piece.start, piece.stop), record.left_out, assume_unique=True)
        if not rows.size:
            continue
        time = rows.astype(np.float64)
        if record.time is not None:
            time = record.time[rows]
        yield rows, time
