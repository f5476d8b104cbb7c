"""Facts read from the data: orientation and width of the loops, their sizes and speeds, drift."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array, Rows
from dehyst.data import turning_points
from dehyst.identification._data import ENOUGH, LONG, DataSet

BINS = 24
# A loop narrower than this share of the output's range has no orientation.
NARROW = 0.01
# Branches of this share of the largest one are those of the largest loops: averaged, they show no noise.
LARGE = 0.9
# A rest is a stretch within 1 % of the range; loops whose sizes differ by no more than a tenth are of one size.
STILL = 0.01
# and tells creep if it takes this share of a way and its rest; a sine stays as long within 1 % for a seventh.
RESTS = 0.3
ONE_SIZE = 0.9
# Of fewer ways no speeds are compared; sizes are from two on: of a log with less there is the more to say.
FEWEST_WAYS, FEWEST_SIZES = 4, 2


@dataclass(frozen=True, slots=True)
class Orientation:
    """Which way round the loop runs and how wide it is."""

    # "counter-clockwise", "clockwise", "mixed" or "none", for the rising form of the curve
    name: str
    width: float  # Distance of the two branches of the largest loops at their widest, share of the output's range


@dataclass(frozen=True)
class Branches:
    """Samples of one piece on branches that rise or fall."""

    # x, y, weight: The samples, (m,), scaled; no weight where all count alike
    x: Array
    y: Array
    weight: Array | None
    falling: npt.NDArray[np.bool_]  # Which of them lie on falling branches, (m,)
    inner: int  # Number of turning points within the fitted part of the piece
    strokes: Array  # Ways between these, share of the input's range, and how many samples each took, (2, m)
    still: float  # Longest rest of the input, in samples


def branches(data: DataSet) -> tuple[Branches, ...]:
    """Fitted samples of each piece, told apart by turning points after swings of a twentieth of the range."""
    pieces = []
    for piece, most in zip(data.pieces, _samples_of_pieces(data), strict=True):
        x = piece.x[: piece.split]
        points = turning_points(x, 0.1)
        rows = spread(first_branch(points), piece.split, most)
        falling = np.zeros(0, dtype=np.bool_)
        if rows.size:
            branch = np.minimum(np.searchsorted(points, rows, side="right"), points.size - 1)
            falling = x[points[branch]] <= x[points[branch - 1]]
        # The last sample begins a stroke that nobody has seen.
        falling &= rows < piece.split - 1
        weight = piece.weight
        if weight is not None:
            weight = weight[rows]
        inner = points[1:-1]
        pieces.append(
            Branches(
                x[rows],
                piece.y[rows],
                weight,
                falling,
                inner.size,
                strokes(inner, x[inner]),
                longest_rest(x),
            )
        )
    return tuple(pieces)


def strokes(places: Rows | Array, values: Array) -> Array:
    """Return (2, m): the input's way from each turning point to the next, as share of its range, and its samples."""
    return np.array([0.5 * np.abs(np.diff(values)), np.diff(places)], dtype=np.float64)


def longest_rest(x: Array) -> float:
    """Most samples in succession between which the scaled input moves by about 1 % of its range."""
    longest = 0
    # A rest on the edge between two cells is within one of the other grid.
    for offset in (0.0, 0.5):
        steps = np.flatnonzero(np.diff(np.floor(x / (2.0 * STILL) + offset)))
        lengths = np.diff(steps, prepend=-1, append=x.size - 1)
        longest = max(longest, int(np.max(lengths, initial=0)))
    return float(longest)


@dataclass(frozen=True, slots=True)
class Motion:
    """What the input did over the fitted part.

    Attributes
    ----------
    smallest, largest
        Ways between turning points, percent of the input's range: nine in ten lie between. Not a number with fewer
        than two of them.
    speeds
        How many times faster the fastest of these ways is than the slowest; not a number where rests hide it, or with
        fewer than four of them.
    rests
        Whether the input rests long enough to show creep; None with fewer than four of them.
    """

    smallest: float = float("nan")
    largest: float = float("nan")
    speeds: float = float("nan")
    rests: bool | None = None

    @property
    def one_size(self) -> bool:
        """Whether all loops are of about one size."""
        return self.smallest > ONE_SIZE * self.largest


def motion(pieces: tuple[Branches, ...]) -> Motion:
    """Sizes, speeds and rests of the input."""
    ways, samples = np.concatenate([piece.strokes for piece in pieces], axis=1)
    if ways.size < FEWEST_SIZES:
        return Motion()
    low, high = np.quantile(ways, [0.05, 0.95])
    if ways.size < FEWEST_WAYS:
        return Motion(100.0 * float(low), 100.0 * float(high))
    slow, fast = np.quantile(ways / samples, [0.05, 0.95])
    longest = max(piece.still for piece in pieces)
    rests = bool(longest > RESTS * float(np.median(samples)))
    speeds = float(fast / slow)
    if rests:
        # A way with a rest in it looks slow, whatever its speed.
        speeds = float("nan")
    return Motion(100.0 * float(low), 100.0 * float(high), speeds, rests)


def _samples_of_pieces(data: DataSet) -> list[int]:
    """How many samples of each piece stand for it."""
    fitted = sum(piece.split for piece in data.pieces)
    share = 1.0
    if fitted > LONG:
        share = ENOUGH / fitted
    counts = []
    for piece in data.pieces:
        # A piece of less than three fitted samples has no stroke.
        if piece.split < 3:
            counts.append(0)
        else:
            counts.append(max(1, round(share * piece.split)))
    return counts


def first_branch(points: Rows) -> int:
    """Where to begin: the first branch may be a virgin curve, which lies inside the loop."""
    if points.size > 3:
        return int(points[1])
    return 0


def orientation(pieces: tuple[Branches, ...]) -> Orientation:
    """Compare the output on rising and falling branches at the same input, over the training part.

    The output of a lagging actuator is lower while its input rises: the loop runs counter-clockwise.
    """
    edges = np.linspace(-0.9, 0.9, BINS + 1)
    sums = np.zeros((2, BINS))
    counts = np.zeros((2, BINS))
    for piece in pieces:
        cell = np.digitize(piece.x, edges) - 1
        inside = (cell >= 0) & (cell < BINS)
        cell = piece.falling[inside] * BINS + cell[inside]
        values = piece.y[inside]
        weight = None
        if piece.weight is not None:
            weight = piece.weight[inside]
            values = values * weight
        sums += np.bincount(cell, values, 2 * BINS).reshape(2, BINS)
        counts += np.bincount(cell, weight, 2 * BINS).reshape(2, BINS)
    both = (counts > 0).all(axis=0)
    wide = widest(pieces)
    if not both.any():
        return Orientation("none", wide)
    distance = 0.5 * (sums[1, both] / counts[1, both] - sums[0, both] / counts[0, both])
    width = float(np.mean(np.abs(distance)))
    lag = float(np.sum(distance[distance > 0]))
    lead = float(-np.sum(distance[distance < 0]))
    if width < NARROW:
        return Orientation("none", wide)
    if min(lag, lead) > 0.25 * max(lag, lead):
        return Orientation("mixed", wide)
    if lag > lead:
        return Orientation("counter-clockwise", wide)
    return Orientation("clockwise", wide)


def widest(pieces: tuple[Branches, ...]) -> float:
    """Distance of the two branches of the largest loops where they lie farthest apart, share of the output's range.

    Small loops and rests within a large one fill the space between its branches, and would make it look narrow.
    """
    rising: list[_Branch] = []
    falling: list[_Branch] = []
    for piece in pieces:
        for branch in _branches(piece):
            if branch.falling:
                falling.append(branch)
            else:
                rising.append(branch)
    if not rising or not falling:
        return 0.0
    large = LARGE * min(_longest(rising), _longest(falling))
    sides = []
    low, high = -np.inf, np.inf
    for side in (rising, falling):
        x = np.concatenate([branch.x for branch in side if branch.span >= large])
        y = np.concatenate([branch.y for branch in side if branch.span >= large])
        low = max(low, float(np.min(x)))
        high = min(high, float(np.max(x)))
        sides.append((x, y))
    ends = 0.05 * (high - low)  # cells at the ends are not full
    edges = np.linspace(low + ends, high - ends, BINS + 1)
    means = []
    for x, y in sides:
        cells = np.digitize(x, edges) - 1
        inside = (cells >= 0) & (cells < BINS)
        counts = np.bincount(cells[inside], minlength=BINS)
        means.append(np.bincount(cells[inside], y[inside], BINS) / np.maximum(counts, 1))
        means[-1][counts == 0] = np.nan
    distance = 0.5 * np.abs(means[1] - means[0])
    # Where one side has no samples there is no distance.
    distance = distance[np.isfinite(distance)]
    return float(np.max(distance, initial=0.0))


def _longest(branches: list[_Branch]) -> float:
    return max(branch.span for branch in branches)


@dataclass(frozen=True)
class _Branch:
    """Samples of one branch, (m,), scaled."""

    x: Array
    y: Array
    falling: bool
    span: float


def _branches(piece: Branches) -> list[_Branch]:
    """The branches of a piece, one after the other."""
    turns = np.flatnonzero(piece.falling[1:] != piece.falling[:-1]) + 1
    ends = [0, *turns.tolist(), piece.x.size]
    branches = []
    for begin, end in itertools.pairwise(ends):
        x, y = piece.x[begin:end], piece.y[begin:end]
        if piece.weight is not None:
            counts = piece.weight[begin:end] > 0.0
            x, y = x[counts], y[counts]
        if x.size:
            span = float(np.max(x) - np.min(x))
            branches.append(_Branch(x, y, bool(piece.falling[begin]), span))
    return branches


def spread(first: int, end: int, most: int) -> Rows:
    """Return all samples from `first` to `end`, or `most` of them, at uneven steps that match no period of a signal."""
    if most == 0:
        return np.zeros(0, dtype=np.int64)
    if end - first <= most:
        return np.arange(first, end, dtype=np.int64)
    golden = 0.6180339887498949
    step = (end - first) / most
    places = first + step * (np.arange(most) + np.modf(golden * np.arange(most))[0])
    rows: Rows = np.minimum(places.astype(np.int64), end - 1)
    return rows


def count_loops(pieces: tuple[Branches, ...]) -> tuple[int, int]:
    """Input cycles and turning points over the training part."""
    loops = turns = 0
    for piece in pieces:
        loops += (piece.inner + 1) // 2
        turns += piece.inner
    return loops, turns


def velocity(time: Array, x: Array) -> Array:
    """Rate of a signal, smoothed over 1/40 of its mean cycle so that sensor noise does not pose as motion."""
    turns = max(2, turning_points(x).size - 1)
    window = max(1, round(x.size / turns / 20))
    smooth = x
    if window > 1:
        before, after = window // 2, (window - 1) // 2
        padded = np.concatenate([np.full(before, x[0]), x, np.full(after, x[-1])])
        middle = 0.5 * (float(np.max(x)) + float(np.min(x)))  # keeps the running sum small
        running = np.concatenate([[0.0], np.cumsum(padded - middle)])
        smooth = (running[window:] - running[:-window]) / window
    rate: Array = np.gradient(smooth, time)
    return rate


class Cycles:
    """Cycles of an input (T,), along which the residuals of several models are compared."""

    def __init__(self, x: Array) -> None:
        points = turning_points(x)[1:-1]
        self._begins, self._places = points[::2], x[points]
        self._counted = slice(0, 0)
        if self._begins.size > FEWEST_CYCLES:
            self._counted = slice(0, int(self._begins[-1]))
        low, high = float(np.min(x)), float(np.max(x))
        self._inside = middle_third(x[self._counted], low, high)

    def drift(self, residual: Array, less: Array | None = None) -> tuple[float, float]:
        """Change of a residual (T,) from the first to the last cycle, and its standard error, in the residual's unit.

        With `less` the residual is the difference of both, which need not be made for that; see `drift_of`.
        """
        begins, inside = self._begins, self._inside
        if begins.size < FEWEST_CYCLES + 1:
            return 0.0, 0.0
        left = residual[self._counted]
        if less is not None:
            left = left - less[self._counted]
        sums = np.add.reduceat(left, begins[:-1])
        middle = np.add.reduceat(left * inside, begins[:-1])
        counts = np.add.reduceat(inside, begins[:-1])
        return drift_of(sums / np.diff(begins), self._places, middle, counts)


def middle_third(x: Array, low: float, high: float) -> Array:
    """1.0 for samples in the middle third of a range, else 0.0.

    Examples
    --------
    >>> middle_third(np.array([0.0, 0.4, 0.5, 0.7]), 0.0, 1.0).tolist()
    [0.0, 1.0, 1.0, 0.0]
    """
    return np.asarray(np.abs(x - 0.5 * (low + high)) <= (high - low) / 6.0, dtype=np.float64)


def agreed(model: tuple[float, float], curve: tuple[float, float]) -> tuple[float, float]:
    """Return a model's drift and its error where a curve without memory drifts at least half as much; else zeros.

    A zero that wanders moves both. What a model forgets, or remembers wrongly, from some loop on, moves one.

    Examples
    --------
    >>> agreed((0.2, 0.01), (0.18, 0.03)), agreed((0.2, 0.01), (0.02, 0.03))
    ((0.2, 0.01), (0.0, 0.0))
    """
    if model[0] * curve[0] > 0.0 and abs(curve[0]) >= 0.5 * abs(model[0]):
        return model
    return 0.0, 0.0


FEWEST_CYCLES = 4
# Cycles are of one size if their ends scatter by less than this share of the largest.
ALIKE = 0.05


def drift_of(cycles: Array, turns: Array, middle: Array, counts: Array) -> tuple[float, float]:
    """Change of the mean residuals (n,) of cycles from the first to the last, and its standard error.

    A line through them; (0, 0) with fewer than four. `middle` and `counts` are sums and numbers of those residuals in
    the middle third of the input's range: a zero that wanders shows there as elsewhere, and a gain that does by half.
    So the error is that of the middle third where the change is less certain there: what a model errs by at one place,
    as where a loop snaps, is no drift, however often the cycles went there.
    """
    size = cycles.size
    if size < FEWEST_CYCLES:
        return 0.0, 0.0
    ends = turns[: 2 * size : 2], turns[1 : 2 * size : 2]
    change, error = _line(cycles, ends)
    crossed = counts > 0.0
    if np.count_nonzero(crossed) < FEWEST_CYCLES:
        return change, error
    change_middle, doubt = _line(
        middle[crossed] / counts[crossed], (ends[0][crossed], ends[1][crossed])
    )
    if change_middle * change <= 0.0:
        return 0.0, 0.0
    return change, max(error, doubt * change / change_middle)


def _line(cycles: Array, ends: tuple[Array, Array]) -> tuple[float, float]:
    """Rise of a line through values of cycles, and its standard error; (0, 0) where there are too few.

    Where the ends of the cycles are not the same all along, the line stands beside both: what a model errs by depends
    on the size of a cycle, and cycles that grow are no drift.
    """
    count = cycles.size
    largest = float(np.max(np.abs(ends[0] - ends[1])))
    k = np.arange(count, dtype=np.float64)
    beside = [np.ones(count)]
    for end in ends:
        if np.std(end) > ALIKE * largest:
            beside.append(end - end.mean())
    freedom = count - 1 - len(beside)
    if freedom < 1:
        return 0.0, 0.0
    basis = np.column_stack(beside)
    along = k - basis @ np.linalg.lstsq(basis, k, rcond=None)[0]
    means = cycles - basis @ np.linalg.lstsq(basis, cycles, rcond=None)[0]
    spread = float(along @ along)
    # Cycles that grow evenly look like time: then no line can be told from their size.
    if not spread > 1e-6 * count**3:
        return 0.0, 0.0
    slope = float(along @ means) / spread
    scatter = means - slope * along
    error = float(np.sqrt(scatter @ scatter / freedom / spread))
    return slope * (count - 1), error * (count - 1)
