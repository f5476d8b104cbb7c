"""Reads the record of a control loop, and says whether its controller was in automatic."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.data import gap_limit, is_even
from dehyst.errors import ColumnError, ParameterError, RecordingError
from dehyst.findings import Finding
from dehyst.io import read_columns
from dehyst.shell import command, visible
from dehyst.units import words
from dehyst_targets.columns import columns_of
from dehyst_targets.valves._policy import POLICY

ROLES = ("setpoint", "output", "measurement", "position")
# What heads a column, by the words of its name. MV is not among the positions: many systems call the output so.
NAMES = {
    "setpoint": frozenset(words("sp setpoint sollwert")),
    "output": frozenset(words("op co out stellgröße")),
    "measurement": frozenset(words("pv istwert")),
    "position": frozenset(words("position travel zt")),
}
LIVE_ZERO = (4.0, 20.0)  # mA


@dataclass(frozen=True, eq=False)
class ControlLoop:
    """A record of a control loop, at even steps of time.

    Attributes
    ----------
    output
        Controller output OP, (T,). [% of its span]
    measurement
        Measurement PV, (T,), or None if only the position was logged. [its unit]
    setpoint
        Set point SP, (T,), or None. [unit of the measurement]
    position
        Position of the valve, (T,), or None. [its unit]
    period
        Time between two samples. [s]
    name
        Of the log.
    is_timed
        Whether the log has a time; otherwise a second stands for a sample.
    findings
        What reading found and cured.
    """

    output: Array
    measurement: Array | None = None
    setpoint: Array | None = None
    position: Array | None = None
    period: float = 1.0
    name: str = "the log"
    is_timed: bool = True
    findings: tuple[Finding, ...] = ()

    @classmethod
    def of(
        cls,
        output: npt.ArrayLike,
        measurement: npt.ArrayLike | None = None,
        setpoint: npt.ArrayLike | None = None,
        position: npt.ArrayLike | None = None,
        *,
        time: npt.ArrayLike | None = None,
        span: tuple[float, float] = (0.0, 100.0),
        name: str = "the log",
        findings: tuple[Finding, ...] = (),
    ) -> ControlLoop:
        """Return a record from anything that numpy takes for an array.

        Parameters
        ----------
        output, measurement, setpoint, position
            (T,) each; one of measurement and position is needed.
        time
            (T,), increasing; without it a sample lasts a second. Uneven steps become even by straight lines; of a log
            with gaps the longest part counts. [s]
        span
            Values of the controller output at 0 and 100 %.
        name
            In messages.
        findings
            Of the reading of a file.

        Raises
        ------
        RecordingError
            If signals differ in length, are too short, hold what is no number, or stand still.
        ParameterError
            If the span is none, or the controller output leaves it.

        Examples
        --------
        >>> op = 50 + 5 * np.sin(np.arange(400) / 10)
        >>> ControlLoop.of(op, op - 20, time=np.arange(400) * 2.0).period
        2.0
        """
        signals: dict[str, Array] = {}
        typed = (setpoint, output, measurement, position)
        for role, values in zip(ROLES, typed, strict=True):
            if values is not None:
                signals[role] = np.asarray(values, dtype=np.float64)
        _refuse(signals, name)
        signals["output"] = _percent(signals["output"], span, name)
        period = 1.0
        if time is not None:
            clock = np.asarray(time, dtype=np.float64)
            if clock.shape != signals["output"].shape or not np.all(np.diff(clock) > 0.0):
                raise RecordingError(
                    f"the times of {name} do not increase, or are not one a sample. Give each sample its time."
                )
            signals, period, more = _evenly(clock, signals)
            findings += more
            _refuse(signals, name)
        return cls(
            **signals, period=period, name=name, is_timed=time is not None, findings=findings
        )


def _refuse(signals: Mapping[str, Array], name: str) -> None:
    if "measurement" not in signals and "position" not in signals:
        raise RecordingError(
            f"of {name} only the controller output is named. Name what answers: --measurement COLUMN or --position "
            f"COLUMN."
        )
    sizes = {role: values.size for role, values in signals.items()}
    if len(set(sizes.values())) > 1:
        raise RecordingError(f"the signals of {name} differ in length: {sizes}.")
    size = sizes["output"]
    if size < POLICY.fewest_samples:
        raise RecordingError(
            f"{name} has {size} samples, fewer than the {POLICY.fewest_samples} that dead band, jump and process take. "
            f"Export a longer part, or more samples in each second.",
            samples=size,
        )
    for role, values in signals.items():
        if not np.all(np.isfinite(values)):
            raise RecordingError(
                f"the {role} of {name} holds what is no number. Leave those rows out."
            )
        if role != "setpoint" and np.ptp(values) <= 1e-9 * max(1.0, float(np.abs(values).max())):
            raise RecordingError(
                f"the {role} of {name} stands still at {values[0]:g}: nothing can be told of a valve that is not "
                f"moved. Name another column, or export a time in which it moves.",
                role=role,
            )


def _percent(output: Array, span: tuple[float, float], name: str) -> Array:
    """Return the controller output in percent of its span."""
    low, high = span
    if not (math.isfinite(low) and math.isfinite(high) and high > low):
        raise ParameterError(f"--span {low:g} {high:g} is no span. Type e.g. --span 0 100.")
    percent = 100.0 * (output - low) / (high - low)
    least, most = float(percent.min()), float(percent.max())
    if least < -POLICY.beyond_span or most > 100.0 + POLICY.beyond_span:
        raise ParameterError(
            f"the controller output of {name} runs from {output.min():g} to {output.max():g}, beyond its span {low:g} "
            f"to {high:g}. Type what 0 and 100 % are, e.g. --span 4 20, or name another column with --output.",
            low=least,
            high=most,
        )
    return np.asarray(percent)


def _evenly(
    time: Array, signals: Mapping[str, Array]
) -> tuple[dict[str, Array], float, tuple[Finding, ...]]:
    """Return the longest part without a gap at even steps, the step, and what was done."""
    steps = np.diff(time)
    edges = np.concatenate(([0], np.flatnonzero(steps > gap_limit(steps)) + 1, [time.size]))
    longest = int(np.diff(edges).argmax())
    part = slice(edges[longest], edges[longest + 1])
    findings = []
    if edges.size > 2:
        findings.append(
            Finding(
                "valve-gap",
                f"the log has {edges.size - 2} gaps; nobody knows how the valve moved in them. The longest part "
                f"without one counts, {part.stop - part.start} of {time.size} samples.",
            )
        )
    times = time[part]
    period = float(np.median(np.diff(times)))
    chosen = {role: values[part] for role, values in signals.items()}
    if is_even(np.diff(times)):
        return chosen, period, tuple(findings)
    findings.append(
        Finding(
            "valve-uneven",
            "the times of the samples are uneven, as a historian leaves them that stores changes only. Between them "
            "straight lines are drawn, which round off jumps: export raw samples.",
        )
    )
    even = np.arange(times[0], times[-1], period)
    resampled = {}
    for role, values in chosen.items():
        resampled[role] = np.interp(even, times, values)
    return resampled, period, tuple(findings)


def read_control_loop(
    path: str | PathLike[str],
    *,
    setpoint: str | None = None,
    output: str | None = None,
    measurement: str | None = None,
    position: str | None = None,
    span: tuple[float, float] | None = None,
    **reading: Any,
) -> ControlLoop:
    """Read the record of a control loop from a log of any format that `dehyst.read_log` reads.

    Parameters
    ----------
    path
        Log file.
    setpoint, output, measurement, position
        Columns; by default those that are called SP, OP, PV, position.
    span
        Values of the controller output at 0 and 100 %; by default 0 and 100, of a column in mA 4 and 20, of values from
        0 to 1 these.
    **reading
        `time`, `time_unit`, `run`, `start`, `stop`, `dt` and `sheet`, as for `dehyst.read_log`.

    Raises
    ------
    LogError
        If the file cannot be read; ColumnError if it does not say which column is which.
    RecordingError, ParameterError
        As `ControlLoop.of`.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> log = pathlib.Path(tempfile.mkdtemp()) / "loop.csv"
    >>> rows = [f"{k},50,{50 + 5 * np.sin(k / 10):.3f},{48 + 4 * np.sin(k / 10 - 1):.3f}" for k in range(400)]
    >>> _ = log.write_text("time_s,SP,OP,PV\\n" + "\\n".join(rows))
    >>> read_control_loop(log).output.size
    400
    """
    typed = {
        "setpoint": setpoint,
        "output": output,
        "measurement": measurement,
        "position": position,
    }
    columns = _columns(path, typed, reading)
    read = read_columns(path, columns, **reading)
    values = dict(read.values)
    findings = list(read.findings)
    if span is None:
        span, about_span = _span(values["output"], read.units["output"])
        findings += about_span
    return ControlLoop.of(
        **values, time=read.time, span=span, name=read.name, findings=tuple(findings)
    )


def _columns(
    path: str | PathLike[str], typed: Mapping[str, str | None], reading: Mapping[str, Any]
) -> dict[str, str]:
    """Return role -> column: those that were typed, others by their names."""
    columns = {role: name for role, name in typed.items() if name is not None}
    if "output" in columns and ("measurement" in columns or "position" in columns):
        return columns
    columns, names = columns_of(path, typed, NAMES, reading)
    if "output" in columns and ("measurement" in columns or "position" in columns):
        return columns
    line = command("valve", Path(path), setpoint="SP", output="OP", measurement="PV")
    raise ColumnError(
        f"the columns of {visible(Path(path).name)} do not say which one is the controller output and which one "
        f"answers: {', '.join(map(visible, names))}. Name them, as in {line}",
        columns=tuple(names),
    )


def _span(output: Array, unit: str) -> tuple[tuple[float, float], list[Finding]]:
    if unit.lower() == "ma":
        return LIVE_ZERO, []
    if unit != "%" and float(output.min()) >= 0.0 and float(output.max()) <= 1.0:
        return (0.0, 1.0), [
            Finding(
                "valve-span",
                f"the controller output runs from {output.min():g} to {output.max():g}: it is taken for a share, 0 to "
                f"1. If it is in percent, type --span 0 100.",
            )
        ]
    return (0.0, 100.0), []


def explained_share(output: Array, measurement: Array, setpoint: Array | None = None) -> float:
    """Return the share of the variance of the changes of an output that a PID controller explains.

    Its velocity form is du(t) = b_0 e(t) + b_1 e(t-1) + b_2 e(t-2) + c with the error e, set point less measurement.

    Parameters
    ----------
    output, measurement, setpoint
        (T,) each; without a set point it is taken for constant.

    Examples
    --------
    >>> pv = np.random.default_rng(0).normal(size=500)
    >>> explained_share(50.0 + np.cumsum(-0.1 * pv) - 0.5 * pv, pv) > 0.999
    True
    """
    error = -measurement
    if setpoint is not None:
        error = setpoint - measurement
    changes = np.diff(output)[1:]
    columns = np.column_stack([error[2:], error[1:-1], error[:-2], np.ones(changes.size)])
    # What is held at the ends of its span follows no law.
    free = (output[2:] > 0.0) & (output[2:] < 100.0)
    changes, columns = changes[free], columns[free]
    total = float(np.sum((changes - changes.mean()) ** 2)) if changes.size else 0.0
    if total == 0.0:
        return 0.0
    b = np.linalg.lstsq(columns, changes, rcond=None)[0]
    left = float(np.sum((changes - columns @ b) ** 2))
    return max(1.0 - left / total, 0.0)


def exchanged(loop: ControlLoop) -> str:
    """Return what is wrong with the order of the columns, "" where nothing is certain.

    An order is wrong where another one makes the controller explain its output, and the one that was named does not; or
    where the measurement hardly ever changes and the set point always does.
    """
    if loop.measurement is None or loop.setpoint is None:
        return ""
    changing = [_changing(values) for values in (loop.setpoint, loop.measurement)]
    if changing[1] < POLICY.held and changing[0] > 0.5:
        return (
            f"the measurement changes in {100.0 * changing[1]:.2g} % of the samples and the set point in "
            f"{100.0 * changing[0]:.2g} %: they look exchanged. Exchange --setpoint and --measurement."
        )
    if explained_share(loop.output, loop.measurement, loop.setpoint) >= POLICY.certain_law:
        return ""
    orders = {
        ("the controller output and the measurement", "--output and --measurement"): (
            loop.measurement, loop.output, loop.setpoint,
        ),
        ("the set point and the controller output", "--setpoint and --output"): (
            loop.setpoint, loop.measurement, loop.output,
        ),
    }  # fmt: skip
    for (names, flags), (output, measurement, setpoint) in orders.items():
        if _moves(output) and explained_share(output, measurement, setpoint) >= POLICY.certain_law:
            return (
                f"{names} look exchanged: the other way round a controller explains its output, as the columns are "
                f"named it does not. Exchange {flags}."
            )
    return ""


def _changing(values: Array) -> float:
    """Share of the samples at which a signal changes."""
    return float(np.mean(np.diff(values) != 0.0))


def _moves(values: Array) -> bool:
    return _changing(values) > POLICY.held
