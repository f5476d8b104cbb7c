"""Data of a direct inverse: output as regressor, input as target; which creep time constants a log separates."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array, Mask
from dehyst.data import Recording, range_over, robust_range
from dehyst.errors import ExcitationError, ParameterError
from dehyst.identification import _facts as facts
from dehyst.identification._data import (
    all_timed,
    inputs_of,
    middle,
    outputs_of,
    prepare,
    require_gain,
)
from dehyst.identification._memory import known_after_break, known_from
from dehyst.identification._schedules import ScheduleRange, schedule_ranges
from dehyst.identification._split import Split
from dehyst.models import kit as models_kit

# Fewer fitted samples than this cannot tell the terms of a direct inverse apart.
LEAST_SAMPLES = 40


@dataclass(frozen=True)
class DirectPiece:
    """Samples with continuous memory, scaled."""

    # y, u: Output and input, (T,), in [-1, 1] over the fitted part
    y: Array
    u: Array
    time: Array | None  # (T,) [s], or None
    rate: Array  # Smoothed dy/dt, (T,) [1/s]; zeros without time
    # Share xi of each scheduling signal, (T,), 0 at its lowest and 1 at its highest fitted value
    shares: tuple[Array, ...]
    # recording, start: Which recording, and the index of the first sample in it
    recording: int
    start: int
    split: int  # Samples before this index are fitted
    known: int  # Index from which the memory is that of the output's own extremes
    after_break: bool  # Whether nothing is known about the output before this piece
    left_out: npt.NDArray[np.int64]  # Samples that do not count

    @property
    def span(self) -> slice:
        """Where the samples stand in their recording."""
        return slice(self.start, self.start + self.y.size)

    @property
    def usable_from(self) -> int:
        """First sample that counts: after a gap the memory must be known again."""
        if self.after_break:
            return self.known
        return 0

    def mask(self, fitted: bool) -> Mask:
        """Samples that are fitted, or held out, (T,)."""
        index = np.arange(self.y.size)
        mask: Mask = (index >= self.usable_from) & ((index < self.split) == fitted)
        mask[self.left_out] = False
        return mask


@dataclass(frozen=True)
class DirectData:
    """All pieces, and the scaling y = center + half_range * y_scaled, u = level + amplitude * u_scaled."""

    pieces: tuple[DirectPiece, ...]
    center: float
    half_range: float
    level: float
    amplitude: float
    schedules: tuple[ScheduleRange, ...]
    input_range: float
    output_range: float
    timed: bool

    @property
    def fitted(self) -> int:
        """Number of samples that are fitted."""
        return sum(int(np.count_nonzero(piece.mask(True))) for piece in self.pieces)


def prepare_direct(records: Sequence[Recording], split: Split) -> DirectData:
    """Split, scale and cut recordings into pieces.

    Raises
    ------
    ExcitationError
        If input, output or a scheduling signal does not move, too few samples are left, or the output falls while
        the input rises.
    """
    fitted_inputs = []
    fitted_outputs = []
    for record, end in zip(records, split.ends, strict=True):
        fitted_inputs.append(record.input[:end])
        fitted_outputs.append(record.output[:end])
    level, amplitude = middle(records[0], range_over(fitted_inputs), "input", split.fitted_part)
    center, half = middle(records[0], range_over(fitted_outputs), "output", split.fitted_part)
    require_gain(records[0], amplitude, half)
    _refuse_falling(records, split)
    ranges = schedule_ranges(records, split.ends)
    pieces = []
    for index, (record, end) in enumerate(zip(records, split.ends, strict=True)):
        left_out = np.array(record.left_out, dtype=np.int64)
        for order, span in enumerate(record.pieces):
            y = (record.output[span] - center) / half
            time = record.time
            if time is not None:
                time = time[span]
            shares = []
            for signal in ranges:
                shares.append(signal.share(record.schedules[signal.name][span]))
            # After a gap the past is unknown until the output has been at both of its extremes.
            known_since = known_from(y, -1.0, 1.0)
            if order:
                known_since = known_after_break(y)
            pieces.append(
                DirectPiece(
                    y, (record.input[span] - level) / amplitude, time, _rate(time, y), tuple(shares), index,
                    span.start, min(max(end - span.start, 0), y.size), known_since, order > 0,
                    left_out[(left_out >= span.start) & (left_out < span.stop)] - span.start,
                )
            )  # fmt: skip
    input_range = robust_range(inputs_of(records))
    output_range = robust_range(outputs_of(records))
    timed = all_timed(records)
    data = DirectData(
        tuple(pieces),
        center,
        half,
        level,
        amplitude,
        ranges,
        input_range,
        output_range,
        timed,
    )
    if data.fitted < LEAST_SAMPLES:
        raise ExcitationError(
            f"only {data.fitted} samples are fitted, and a direct inverse needs {LEAST_SAMPLES} to tell its terms "
            f"apart. Fit a larger part (--train-fraction), log longer, or log without gaps: after a gap samples count "
            f"once the output has visited both of its extremes again.",
            samples=data.fitted,
        )
    return data


def period_of(data: DirectData) -> float:
    """Median time between two samples of the log; 0 without time stamps. [s]"""
    steps = []
    for piece in data.pieces:
        if piece.time is not None and piece.time.size > 1:
            steps.append(np.diff(piece.time))
    if not steps:
        return 0.0
    # Time stamps tell no more digits.
    return float(f"{np.median(np.concatenate(steps)):.9g}")


def _rate(time: Array | None, y: Array) -> Array:
    """Smoothed rate of a piece; zero where there is no time or no second sample."""
    if time is None or y.size < 3:
        return np.zeros(y.size)
    return facts.velocity(time, y)


def _refuse_falling(records: Sequence[Recording], split: Split) -> None:
    data = prepare(records, split)
    if data.trend < 0:
        first = records[0]
        raise ExcitationError(
            f"'{first.output_name}' falls while '{first.input_name}' rises, but the terms of a direct inverse have "
            f"non-negative weights: its output must rise with its input. Turn the sign of one of the two columns, and "
            f"that of the compensator's signal with it.",
            trend=-1,
        )


AUTO = "auto"
MOST_TIMES = 12
# Offered where their number is not asked for.
USUAL_TIMES = 6
# A log tells time constants apart from three of its sampling steps up to a third of its fitted part; over less than
# 1 : 300 of that nothing is gained.
STEPS, SHARE, WIDEST = 3.0, 1.0 / 3.0, 300.0


def check_creep(creep: int | str, times: npt.ArrayLike | None) -> Array | None:
    """Return the given time constants, or None; refuse a number or times that are none."""
    if times is not None:
        if not (isinstance(creep, str) and creep == AUTO):
            raise ParameterError(
                f"creep = {creep!r} and creep_times = {times!r} are both given: one says how many time constants, the "
                f"other which. Pass one of them (--creep or --creep-times).",
                creep=creep,
            )
        constants = models_kit.parameter_array(times, "creep_times")
        models_kit.strictly_increasing(constants, "creep_times")
        if not constants[0] > 0.0:
            raise ParameterError(
                f"creep_times[0] = {constants[0]:g} s must be positive: it is how long creep takes. Pass for example "
                f"creep_times=[4, 25, 150] (--creep-times 4,25,150)."
            )
        if constants.size > MOST_TIMES:
            raise ParameterError(
                f"{constants.size} creep times: pass at most {MOST_TIMES}; time constants closer than a factor of 2 "
                f"cannot be told apart."
            )
        return constants
    if creep == AUTO and isinstance(creep, str):
        return None
    if (
        isinstance(creep, bool)
        or not isinstance(creep, (int, np.integer))
        or not 0 <= creep <= MOST_TIMES
    ):
        raise ParameterError(
            f"creep = {creep!r}: pass how many time constants to offer, 0 to {MOST_TIMES} (--creep 3), or 'auto'.",
            creep=creep,
        )
    return None


def separable(data: DirectData) -> tuple[float, float]:
    """Shortest and longest time constants that the fitted part tells apart. [s]"""
    steps, longest = [], 0.0
    for piece in data.pieces:
        if piece.time is not None and piece.split >= 2:
            fitted = piece.time[: piece.split]
            steps.append(np.diff(fitted))
            longest = max(longest, float(fitted[-1] - fitted[0]))
    if not steps:
        return 0.0, 0.0
    high = SHARE * longest
    return max(STEPS * float(np.median(np.concatenate(steps))), high / WIDEST), high


def time_constants(data: DirectData, creep: int | str, times: Array | None) -> Array:
    """Time constants to offer, (m,). [s]"""
    if times is not None:
        return times
    low, high = separable(data)
    count = USUAL_TIMES
    if not isinstance(creep, str):
        count = int(creep)
    if count == 0 or not low < high:
        return np.zeros(0)
    if count == 1:
        return np.array([np.sqrt(low * high)])
    return np.geomspace(low, high, count)


def time_constants_text(times: Sequence[float] | Array) -> str:
    """Time constants in words.

    Examples
    --------
    >>> time_constants_text([4.0, 25.0, 150.0])
    '4, 25, 150 s'
    """
    return ", ".join(f"{value:.3g}" for value in times) + " s"
