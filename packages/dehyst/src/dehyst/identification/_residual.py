"""Analyses the residual of a fit: what it depends on, what is noise, how much a better model could gain."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

import dehyst._native as _native
from dehyst.arrays import Array, Mask, Rows
from dehyst.data import POLICY as DATA_POLICY
from dehyst.data import Recording
from dehyst.identification._data import all_timed, input_range
from dehyst.identification._facts import spread
from dehyst.identification._policy import POLICY
from dehyst.identification._threads import single_blas
from dehyst.models import Resonance
from dehyst.shell import command

# Where one cause explains as much as another, the first one is named: the simpler, and rate-independent ones first.
TITLES = {
    "offset": "one constant offset",
    "drift": "the place within the log",
    "position": "the input itself",
    "way-since-turn": "how far the input has gone since its last turn",
    "time-since-turn": "the time since the input's last turn",
    "rate": "the speed of the input",
    "delay": "the slope of the output",
}
CAUSES = tuple(TITLES)
WHAT = {"offset": "is"}  # what the residual does; of all others it depends on them
MOST_ROWS = 20_000  # that stand for a longer log, spread unevenly, so that no period of it is met
FEWEST = 100
BLOCKS = 10  # consecutive; odd ones are fitted and even ones scored, then the other way round
PLACES = 7  # knots along the range of the input
KNOTS = (0.0, 0.05, 0.15, 0.35, 0.65, 1.0)  # quantiles of the way, or time, since a turn
LAGS = np.array([0.3, 1.0, 3.0])  # usual strokes: time constants
MOST_LAGGING = 50_000  # samples through which lags are followed
USUAL = 0.95  # quantile by which speeds are scaled
RIDGE = 1e-4  # of a column's square
NOTHING = 1e-9  # of the output's range: less is rounding
# Strokes are one stroke repeated if they turn at the same places to this share of the input's range and take the same
# time to this share.
SAME_PLACE, SAME_TIME = 0.02, 0.05
FEWEST_PAIRS, MOST_PAIRS, PHASES = 6, 400, 64
# A peak of the spectrum is one if it is so many times as high as what is usual, holds this share of the square, is so
# many times as fast as the strokes, which have harmonics, and the input has less than this share of its square there.
HIGH = 10.0
PEAK_SHARE = 0.3
FASTER = 6.0
DRIVEN = 0.01
EDGE = 0.1  # of its height: as far as that a peak goes, and its end is at most so many times its beginning
NARROW = 1.6
MOST_SEGMENT, MOST_SEGMENTS = 1024, 64
# Of four samples in succession; it is free of everything that is smooth.
DIFFERENCE = np.array([1.0, -3.0, 3.0, -1.0])


@dataclass(frozen=True, slots=True)
class Cause:
    """How much of the squared residual follows one thing.

    Attributes
    ----------
    name
        One of `CAUSES`.
    share
        Share of the squared residual that it explains by itself, fitted to every other block of the samples and scored
        on those between: 0 for noise, 1 for all of it. Causes overlap; shares need not add up to 1.
    own
        What of it no other cause explains, too.
    size_percent
        Root mean square of what it explains, percent of the output's range.
    """

    name: str
    share: float
    own: float
    size_percent: float

    @property
    def title(self) -> str:
        """What it is, in words."""
        return TITLES[self.name]

    @property
    def words(self) -> str:
        """What the residual does."""
        return f"{WHAT.get(self.name, 'depends on')} {TITLES[self.name]}"

    def as_dict(self) -> dict[str, Any]:
        """Return the values as printed by ``--json``."""
        return {
            "name": self.name,
            "share": self.share,
            "own": self.own,
            "size_percent": self.size_percent,
        }


@dataclass(frozen=True, slots=True)
class Peak:
    """A frequency at which much of a residual lies.

    Attributes
    ----------
    frequency, low, high
        Of its top and of its edges, in Hz, or 1/samples without time stamps.
    share
        Of the squared residual that lies between the edges.
    """

    frequency: float
    low: float
    high: float
    share: float

    def words(self, timed: bool) -> str:
        """Share and frequency, for a person."""
        if timed:
            return (
                f"{100.0 * self.share:.0f} % of the model's squared error lies around {self.frequency:.4g} Hz "
                f"({self.low:.3g} to {self.high:.3g} Hz)"
            )
        percent = f"{100.0 * self.share:.0f} %"
        return f"{percent} of the model's squared error repeats every {1.0 / self.frequency:.3g} samples"


@dataclass(frozen=True, slots=True)
class Residual:
    """What is left of an output when a model has said what it knows.

    Attributes
    ----------
    part
        "held-out" or "fitted": the samples that were looked at.
    rms_percent
        Of the residual, percent of the output's range.
    causes
        All `CAUSES`, in that order; none where there are fewer than 100 samples, or nothing but rounding is left.
    explained
        Share of the squared residual that all of them explain together, on blocks that were not fitted.
    noise_percent
        Noise floor, percent of the output's range; None if nothing tells it.
    noise_from
        "repeats": how far strokes differ that were repeated, an error that no model of this input can undercut;
        "differences": what jumps from sample to sample, the least that noise can be; "" if nothing tells it.
    delay
        Time by which the output is behind the model where the residual follows its slope, in seconds, or samples
        without time stamps; below 0 it is ahead.
    timed
        Whether the recordings have time stamps.
    suggestions
        What to log or to try next, each with its number.
    peak
        Frequency at which much of it lies, though the input hardly moves there; None where there is none.
    """

    part: str
    rms_percent: float
    causes: tuple[Cause, ...] = ()
    explained: float = 0.0
    noise_percent: float | None = None
    noise_from: str = ""
    delay: float = 0.0
    timed: bool = False
    suggestions: tuple[str, ...] = ()
    peak: Peak | None = None

    @property
    def largest(self) -> Cause | None:
        """The cause that explains most, the simpler one of two alike; None if none explains anything."""
        largest = max(self.causes, key=lambda cause: round(cause.share, 2), default=None)
        if largest is None or not largest.share > 0.0:
            return None
        return largest

    @property
    def noise_share(self) -> float | None:
        """Share of the squared residual that is noise."""
        if self.noise_percent is None or not self.rms_percent > 0.0:
            return None
        return min(1.0, (self.noise_percent / self.rms_percent) ** 2)

    def as_dict(self) -> dict[str, Any]:
        """Return the values as printed by ``--json``."""
        peak = None
        if self.peak is not None and self.timed:
            peak = self.peak.frequency
        return {
            "part": self.part,
            "rms_percent": self.rms_percent,
            "causes": [cause.as_dict() for cause in self.causes],
            "explained": self.explained,
            "noise_percent": self.noise_percent,
            "noise_share": self.noise_share,
            "noise_from": self.noise_from,
            "delay": self.delay,
            "peak_Hz": peak,
            "suggestions": list(self.suggestions),
        }


def residual_structure(
    recordings: Sequence[Recording],
    predictions: Sequence[Array],
    masks: Sequence[Mask],
    output_range: float,
    *,
    part: str = "held-out",
    knows_time: bool = False,
    confirmed: Collection[str] = (),
    excluded: Collection[str] = (),
    resonance: Resonance | None = None,
) -> Residual:
    r"""Say what the residual e = y - f of a model follows.

    Each cause is a small set of columns B, fitted to half of ten blocks of the samples and scored on the other half,
    then the other way round, beside a constant:

    .. math::

        R^2_B = 1 - \frac{\sum_k (e_k - c - B_k a_{\text{other half}})^2}{\sum_k e_k^2} - R^2_{\text{offset}}

    offset: c alone; drift: a cubic along the log; position: piecewise linear in the input; since a turn: piecewise
    linear in the way or the time since then, with the sign of the stroke; the way also times the height of the stroke
    before, the time beside lags of the input; rate: v, v|v| and |v|; delay: the slope of f.

    Parameters
    ----------
    recordings
        The data.
    predictions
        Output f of the model for each, (T,). [output]
    masks
        Samples that count, (T,) each.
    output_range
        Of which percents are. [output]
    part
        What the masks hold: "held-out" or "fitted" samples.
    knows_time
        Whether the model knows rate and creep.
    confirmed
        Those of `CAUSES` that a test of their own has shown to be there. Of the others is said what was seen: what
        follows the time since a turn is creep, or a loop that the model lacks where all strokes take one time.
    excluded
        Those that a test of their own would have shown, and did not: a log that can tell is not asked for more of it.
    resonance
        That the model knows of.

    Examples
    --------
    >>> t = np.linspace(0.0, 60.0, 3000)
    >>> x = np.sin(t**1.2)
    >>> y = 2.0 * x + 0.01 * t / 60.0
    >>> structure = residual_structure([Recording(input=x, output=y, time=t)], [2.0 * x], [t >= 0.0], 4.0)
    >>> {cause.name: round(cause.share, 2) for cause in structure.causes if cause.share > 0.1}
    {'offset': 0.73, 'drift': 0.27}
    """
    timed = all_timed(recordings)
    spans = _spans(recordings, predictions, masks)
    samples = sum(span.counted.size for span in spans)
    sampled = []
    squares = 0.0
    count = 0
    for span in spans:
        at = span.rows(max(1, round(MOST_ROWS * span.counted.size / samples)))
        sampled.append((span, at))
        squares += float(np.sum(span.e[at] ** 2))
        count += at.size
    rms = 100.0 * float(np.sqrt(squares / max(1, count))) / output_range
    residual = Residual(part, rms, timed=timed)
    # Of a few samples, or of rounding, nothing is to be said.
    if count < FEWEST or not rms > 100.0 * NOTHING:
        return residual
    times = LAGS * float(np.median([span.stroke for span in spans]))
    with single_blas():
        table = _Table([span.features(at, times) for span, at in sampled])
        causes = table.causes(rms)
    noise, source = _noise(sampled)
    if noise is not None:
        noise = 100.0 * noise / output_range
    residual = replace(
        residual,
        causes=causes,
        explained=table.explained,
        noise_percent=noise,
        noise_from=source,
        delay=table.delay,
        peak=_peak(spans),
    )
    suggestions = _suggestions(residual, knows_time, confirmed, excluded, resonance)
    return replace(residual, suggestions=tuple(suggestions))


def spectral_peak(
    recordings: Sequence[Recording], predictions: Sequence[Array], masks: Sequence[Mask]
) -> Peak | None:
    """Return the frequency at which much of a residual lies though the input hardly moves there; None if there is none.

    Examples
    --------
    >>> t = np.arange(0.0, 60.0, 0.01)
    >>> x = np.sin(t)
    >>> hum = Recording(input=x, output=2.0 * x + 0.01 * np.sin(2.0 * np.pi * 12.0 * t), time=t)
    >>> round(spectral_peak([hum], [2.0 * x], [t >= 0.0]).frequency, 1)
    12.0
    """
    return _peak(_spans(recordings, predictions, masks))


class _Features(NamedTuple):
    """At some samples, (m,): residual, input, way and time since a turn, sign and height of strokes, both slopes.

    Lags are what the input is ahead of its lags in time, (m, len(LAGS)).
    """

    e: Array
    x: Array
    way: Array
    since: Array
    sign: Array
    height: Array
    speed: Array
    slope: Array
    lags: Array


class _MemorySpan:
    """Samples with continuous memory; those counted say what is left, the others where the input turned."""

    def __init__(
        self, time: Array, x: Array, f: Array, e: Array, counted: Rows, turns: Rows, width: float
    ) -> None:
        self.time, self.x, self.f, self.e, self.counted = time, x, f, e, counted
        self.turns, self.width = turns, width

    def rows(self, most: int) -> Rows:
        """Counted samples, or so many that stand for them."""
        return self.counted[spread(0, self.counted.size, most)]

    def jumps(self, at: Rows) -> Array:
        """Third differences of the residual from some samples on, where all of it counts."""
        counts = np.zeros(self.x.size, dtype=np.bool_)
        counts[self.counted] = True
        four = at[at < self.x.size - 3][:, None] + np.arange(4)
        return np.asarray(self.e[four[counts[four].all(axis=1)]] @ DIFFERENCE)

    def repeats(self) -> Array:
        """Differences of the residual between strokes and the next ones that repeat them, (pairs, phases)."""
        # Whole strokes, and what came before them.
        begin, end = self.turns[1:-2], self.turns[2:-1]
        samples = np.searchsorted(self.counted, end) - np.searchsorted(self.counted, begin)
        inside = samples == end - begin
        begin, end = begin[inside], end[inside]
        before = self.turns[np.searchsorted(self.turns, begin) - 1]
        # Strokes between the same cells of the input, in about the same time, are one stroke repeated.
        places = np.round(self.x[np.stack([begin, end, before])] / (SAME_PLACE * self.width))
        duration = np.round(np.log(self.time[end] - self.time[begin]) / SAME_TIME)
        alike = np.unique(np.vstack([places, duration]), axis=1, return_inverse=True)[1].ravel()
        order = np.argsort(alike, kind="stable")
        next_ones = np.flatnonzero(np.diff(alike[order]) == 0)
        chosen = next_ones[spread(0, next_ones.size, MOST_PAIRS)]
        phase = (np.arange(PHASES) + 0.5) / PHASES
        at = begin[:, None] + np.round(phase * (end - begin)[:, None]).astype(np.int64)
        return np.asarray(self.e[at[order[chosen]]] - self.e[at[order[chosen + 1]]])

    @property
    def stroke(self) -> float:
        """Usual time between two turns."""
        return float(self.time[-1] - self.time[0]) / max(1, self.turns.size - 1)

    def behind(self, at: Rows, times: Array) -> Array:
        """Input less its lags of some time constants."""
        every, none = max(1, self.x.size // MOST_LAGGING), np.zeros(0)
        time, x = np.ascontiguousarray(self.time[::every]), np.ascontiguousarray(self.x[::every])
        ahead = _native.direct_bank(x, time, none, none, times, True)[0]
        return np.column_stack([np.interp(self.time[at], time, lag) for lag in ahead.T])

    def features(self, at: Rows, times: Array) -> _Features:
        """What causes are made of."""
        x, time, turns = self.x, self.time, self.turns
        stroke = np.clip(np.searchsorted(turns, at, side="right") - 1, 0, max(0, turns.size - 2))
        begin = turns[stroke]
        heights = np.abs(np.diff(x[turns], prepend=x[turns[0]])) / self.width
        sign = np.sign(x[turns[np.minimum(stroke + 1, turns.size - 1)]] - x[begin])
        # Differences over several samples: noise of a sensor must not look like motion.
        half = max(1, round(x.size / max(1, turns.size - 1) / 40))
        low, high = np.maximum(at - half, 0), np.minimum(at + half, x.size - 1)
        step = time[high] - time[low]
        return _Features(
            self.e[at], x[at], np.abs(x[at] - x[begin]), time[at] - time[begin], sign, heights[stroke],
            (x[high] - x[low]) / step, (self.f[high] - self.f[low]) / step,
            self.behind(at, times),
        )  # fmt: skip


def _spans(
    recordings: Sequence[Recording], predictions: Sequence[Array], masks: Sequence[Mask]
) -> list[_MemorySpan]:
    low, high = input_range(recordings)
    timed = all_timed(recordings)
    spans = []
    for recording, f, mask in zip(recordings, predictions, masks, strict=True):
        # Recordings of which one has no time stamps are compared by their samples.
        time = np.arange(len(recording), dtype=np.float64)
        if timed and recording.time is not None:
            time = recording.time
        for piece in recording.pieces:
            counted = np.flatnonzero(mask[piece])
            if counted.size > 1:
                x = recording.input[piece]
                e = recording.output[piece] - f[piece]
                turns = recording.turns(piece, DATA_POLICY.turn_fraction * (high - low))
                spans.append(_MemorySpan(time[piece], x, f[piece], e, counted, turns, high - low))
    return spans


class _Table:
    """Columns of all causes behind a constant, their normal equations on either half, and what they explain."""

    def __init__(self, parts: Sequence[_Features]) -> None:
        features = _Features(*map(np.concatenate, zip(*parts, strict=True)))
        groups = {"offset": np.ones((features.e.size, 1)), **_columns(features)}
        self.columns = {}
        end = 0
        for name, columns in groups.items():
            begin, end = end, end + columns.shape[1]
            self.columns[name] = np.arange(begin, end)
        rows = np.column_stack([*groups.values(), features.e])
        even = np.arange(features.e.size) * BLOCKS // features.e.size % 2 == 0
        self.halves = [half.T @ half for half in (rows[even], rows[~even])]
        self.alone = {name: self._share(name) for name in groups}
        self.together = self._share(*list(groups)[1:])

    @property
    def explained(self) -> float:
        """By all causes together, or by one where all are too many for the samples."""
        return max(0.0, self.together, *self.alone.values())

    @property
    def delay(self) -> float:
        """Of the output behind the model: e = c - delay f'."""
        return -float(_solved(sum(self.halves), np.append(0, self.columns["delay"]))[1])

    def causes(self, rms: float) -> tuple[Cause, ...]:
        """All of them; the offset is left out of the others."""
        offset = max(0.0, self.alone["offset"])
        causes = [Cause("offset", offset, offset, rms * float(np.sqrt(offset)))]
        names = [name for name in self.columns if name != "offset"]
        for name in names:
            share = max(0.0, self.alone[name] - offset)
            without = self._share(*(other for other in names if other != name))
            alone = min(share, max(0.0, self.together - without))
            causes.append(Cause(name, share, alone, rms * float(np.sqrt(share))))
        return tuple(causes)

    def _share(self, *names: str) -> float:
        """Of the square of e that a constant and the columns of some causes explain where they were not fitted."""
        places = [0]
        for name in names:
            places += self.columns[name].tolist()
        use = np.unique(places)
        at, left, total = np.append(use, -1), 0.0, 0.0
        for fitted, scored in (self.halves, self.halves[::-1]):
            miss = np.append(_solved(fitted, use), -1.0)
            left += float(miss @ scored[np.ix_(at, at)] @ miss)
            total += float(scored[-1, -1])
        return 1.0 - left / total


def _solved(gram: Array, use: Rows) -> Array:
    """Weights of some columns, the first of them the constant; the last column is what they explain."""
    length = np.sqrt(np.diag(gram)[use])
    length[length == 0.0] = 1.0
    a = gram[np.ix_(use, use)] / np.outer(length, length)
    a[1:, 1:] += RIDGE * np.eye(use.size - 1)
    weights = np.linalg.lstsq(a, gram[use, -1] / length, rcond=None)[0] / length
    return np.asarray(weights, dtype=np.float64)


def _columns(features: _Features) -> dict[str, Array]:
    """Columns of each cause, (m, .)."""
    along = np.linspace(-1.0, 1.0, features.e.size)[:, None]
    low, high = float(features.x.min()), float(features.x.max())
    v = features.speed / (float(np.quantile(np.abs(features.speed), USUAL)) or 1.0)
    # What follows a turn has the sign of the stroke: it is mirrored on the way back.
    sign = features.sign[:, None]
    way = sign * _hats(features.way, _knots(features.way))
    since = sign * _hats(features.since, _knots(features.since))
    return {
        "drift": along ** np.arange(1, 4),
        "position": _hats(features.x, np.linspace(low, high, PLACES)),
        "way-since-turn": np.hstack([way, way * features.height[:, None]]),
        "time-since-turn": np.hstack([since, features.lags]),
        "rate": np.column_stack([v, v * np.abs(v), np.abs(v)]),
        "delay": features.slope[:, None],
    }


def _knots(since: Array) -> Array:
    """Closer right after a turn."""
    return np.asarray(np.quantile(since, KNOTS))


def _hats(values: Array, knots: Array) -> Array:
    """Piecewise linear functions that are 1 at one knot and 0 at the others, (m, knots); fewer where knots agree."""
    knots = np.unique(knots)
    return np.column_stack([np.interp(values, knots, unit) for unit in np.eye(knots.size)])


def _noise(sampled: Sequence[tuple[_MemorySpan, Rows]]) -> tuple[float | None, str]:
    """Noise of the output, and what tells it. [output]"""
    repeated = np.concatenate([span.repeats() for span, _ in sampled])
    if repeated.shape[0] >= FEWEST_PAIRS:
        return float(np.sqrt(0.5 * np.mean(repeated**2))), "repeats"
    jumps = np.concatenate([span.jumps(at) for span, at in sampled])
    if jumps.size < FEWEST:
        return None, ""
    return float(np.sqrt(np.mean(jumps**2) / np.sum(DIFFERENCE**2))), "differences"


def _peak(spans: Sequence[_MemorySpan]) -> Peak | None:
    """Peak of the mean spectrum of segments of one length, tapered, or None."""
    # A spectrum needs samples in succession.
    whole = [span for span in spans if span.counted.size == span.counted[-1] - span.counted[0] + 1]
    size = min(MOST_SEGMENT, max((span.counted.size for span in whole), default=0) // 4)
    if size < 32:
        return None
    steps = []
    strokes = []
    errors, inputs = [], []
    most = MOST_SEGMENTS // len(whole) + 1
    for span in whole:
        steps.append((span.time[-1] - span.time[0]) / (span.time.size - 1))
        strokes.append(span.stroke)
        first, count = int(span.counted[0]), span.counted.size
        if count < size:
            continue
        for begin in spread(0, count - size + 1, most).tolist():
            part = slice(first + begin, first + begin + size)
            errors.append(span.e[part])
            inputs.append(span.x[part])
    step = float(np.median(steps))
    stroke = float(np.median(strokes)) / step
    cycles = np.arange(size // 2 + 1)
    power = _spectrum(np.array(errors))
    driven = _spectrum(np.array(inputs))
    faster = np.flatnonzero(cycles > FASTER * size / (2.0 * stroke))
    if faster.size < 8 or not power.sum() > 0.0:
        return None
    top = int(faster[np.argmax(power[faster])])
    low = high = top
    while low > faster[0] and power[low - 1] > EDGE * power[top]:
        low -= 1
    while high < cycles.size - 1 and power[high + 1] > EDGE * power[top]:
        high += 1
    if high > NARROW * low:
        return None
    share = float(power[low : high + 1].sum() / power.sum())
    usual = np.delete(power[faster], np.arange(low, high + 1) - faster[0])
    moved = float(driven[low : high + 1].sum() / max(float(driven.sum()), 1e-300))
    if share < PEAK_SHARE or moved > DRIVEN or not usual.size:
        return None
    if power[top] < HIGH * float(np.median(usual)):
        return None
    # The centre of a narrow peak is that of its top; a broad one has no single top.
    inside = np.arange(low, high + 1)
    if high - low < size // 16:
        inside = np.arange(max(top - 1, 0), min(top + 2, cycles.size))
    centre = float(power[inside] @ inside / power[inside].sum())
    per = 1.0 / (size * step)
    return Peak(centre * per, low * per, high * per, share)


def _spectrum(segments: Array) -> Array:
    """Mean square of segments (m, n) at whole numbers of cycles, each less its mean and tapered."""
    size = segments.shape[1]
    taper = 0.5 - 0.5 * np.cos(2.0 * np.pi * (np.arange(size) + 0.5) / size)
    level = (segments - segments.mean(axis=1)[:, None]) * taper
    return np.asarray(np.mean(np.abs(np.fft.rfft(level)) ** 2, axis=0))


def _suggestions(
    residual: Residual,
    knows_time: bool,
    confirmed: Collection[str],
    excluded: Collection[str],
    resonance: Resonance | None,
) -> Iterator[str]:
    """Plain words: the number, and what to log or to try next; the largest cause first."""
    order = sorted(residual.causes, key=lambda cause: -round(cause.share, 2))
    named = []
    rivals = []
    for cause in order:
        largest = cause is order[0]
        if cause.share >= POLICY.named_cause and (largest or cause.own >= POLICY.unshared_cause):
            named.append(cause)
        elif (
            not largest
            and cause.own < POLICY.unshared_cause
            and cause.share >= POLICY.rival * order[0].share
        ):
            rivals.append(TITLES[cause.name])
    # A weak cause may be a rival too, but only of one that is worth a word.
    if not named:
        rivals = []
    for cause in named:
        effect = f"{100.0 * cause.share:.0f} % of the model's squared error {cause.words}"
        cure = _cure(cause, residual, knows_time, confirmed, excluded)
        yield f"{effect}, {cause.size_percent:.2g} % of range rms. {cure}"
    if rivals and not excluded:
        yield (
            f"Nearly as much of the same may come from {' and '.join(rivals)}: log "
            f"several speeds, sizes of loop, and rests, which tell them apart (dehyst design plans such a motion)."
        )
    elif rivals:
        yield f"Nearly as much of the same may come from {' and '.join(rivals)}."
    if residual.peak is not None:
        peak = residual.peak.words(residual.timed)
        if resonance is not None and residual.peak.low <= resonance.frequency <= residual.peak.high:
            yield f"{peak}: the resonance that the compensator does not excite."
        else:
            yield (
                f"{peak}, where the input hardly moves: a resonance that the motion rings, or a "
                f"disturbance of that frequency. No model of hysteresis follows it: smooth the reference, filter that "
                f"frequency out of the measured output, or damp it."
            )
    noise = residual.noise_share
    if noise is not None and noise >= POLICY.mostly_noise:
        yield (
            f"{100.0 * noise:.0f} % of the model's squared error is noise, {residual.noise_percent:.2g} % of range "
            f"rms: no model will do much better. Average samples, take a better sensor, or leave it at that."
        )
    elif not named and residual.causes and residual.peak is None:
        yield (
            "None of these causes explains the error of the model, and the error is more than the noise that is seen. "
            "Either the actuator behaves in a way that the model cannot show, or something acts on it that was not "
            "logged. See whether another family does better (dehyst compare), and repeat the same strokes: no model of "
            "this input can know what differs between repetitions."
        )


ALIKE = (
    "Creep, rate, and a loop that the model does not show look alike in this log: log rests and several speeds, which "
    "tell them apart (dehyst design plans them), or see whether another family does better (dehyst compare)."
)

OTHER_LOOP = (
    "The tests of this log for rate and creep do not show that one of them is why, so it is rather a loop that the "
    "model does not show: see whether another family does better (dehyst compare)."
)


def _cure(
    cause: Cause,
    residual: Residual,
    knows_time: bool,
    confirmed: Collection[str],
    excluded: Collection[str],
) -> str:
    samples = "the samples"
    extend = "See whether another family does better (dehyst compare)."
    if residual.part == "held-out":
        samples = "the samples held out"
        extend = (
            "Let loops {} be part of what is fitted (--train-fraction), or see whether another family does better "
            "(dehyst compare)."
        )
    if knows_time:
        creep = rate = "The model knows it, but not all of it: log longer rests and several speeds."
    else:
        creep = "It creeps: take a model that knows creep (--family mixed-sum or creep-pi)."
        rate = "Take a model that knows the rate (--family mixed-sum), or identify at that of use."
    alike = ALIKE
    if not residual.timed:
        alike = f"{ALIKE} Without time stamps none of that can be told."
    if cause.name in excluded:
        alike = OTHER_LOOP
    # What no test has confirmed may be one of several things that look alike.
    if cause.name not in confirmed:
        creep = rate = alike
    limit = min(50, max(1, math.ceil(2 * cause.size_percent))) / 100
    follow = command("export", "MODEL.json", target="c", out="DIR", follow_offset=f"{limit:g}")
    cures = {
        "offset": (
            f"The mean of {samples} is not that of the model, and they do not tell why: another zero, load or "
            f"temperature, or a past that is not known. In use an offset can follow the last cycle, up to twice this "
            f"one ({follow})."
        ),
        "drift": "Make the first strokes again at the end, and log what may be the cause, such as a temperature.",
        "position": extend.format("over the whole range"),
        "way-since-turn": extend.format("of all sizes"),
        "time-since-turn": creep,
        "rate": rate,
        "delay": _late(residual, cause.name in confirmed),
    }
    return cures[cause.name]


def _late(residual: Residual, confirmed: bool) -> str:
    unit = "samples"
    if residual.timed:
        unit = "s"
    place = "ahead of"
    if residual.delay > 0.0:
        place = "behind"
    size = f"The output is about {abs(residual.delay):.2g} {unit} {place} the model"
    if confirmed:
        return f"{size}: log both signals by one clock and without filters on one of them, or shift one by that time."
    return (
        f"{size}. A loop that the model does not show looks like that, and so does a lag. See whether "
        f"another family does better (dehyst compare)."
    )
