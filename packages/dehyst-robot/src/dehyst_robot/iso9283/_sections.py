"""Intersections of a run with planes normal to its command path, where ISO 9283 measures path figures."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array, Rows
from dehyst.errors import ParameterError, RecordingError
from dehyst_robot.iso9283._paths import Figure

SECTIONS = 50  # a stroke; the standard leaves the number open
# Time over which the path speed is measured: over less, an encoder's steps would look like speed.
WINDOW_S = 0.02


@dataclass(frozen=True, eq=False)
class Sections:
    """Attained points in m sections normal to the command path, for n cycles; NaN where a cycle missed a section.

    Attributes
    ----------
    s
        (m,) arc lengths of the sections along the figure. [m]
    command
        (m, 3) commanded points x_ci. [m]
    attained
        (n, m, 3) attained points x_ij. [m]
    speed
        (n, m) attained path speeds v_ij, over 20 ms around the crossing. [m/s]
    """

    s: Array
    command: Array
    attained: Array
    speed: Array

    @property
    def missed(self) -> int:
        """How many of the n m crossings did not happen."""
        return int(np.isnan(self.speed).sum())


def check_run(
    time: npt.ArrayLike, position: npt.ArrayLike, cycle: npt.ArrayLike
) -> tuple[Array, Array, Rows]:
    """Return time (T,), position (T, 3) and cycle (T,) as arrays, or raise RecordingError with the fault."""
    t = np.asarray(time, dtype=np.float64)
    x = np.asarray(position, dtype=np.float64)
    n = np.asarray(cycle)
    if t.ndim != 1 or x.shape != (t.size, 3) or n.shape != t.shape:
        raise RecordingError(
            f"time {t.shape}, position {x.shape} and cycle {n.shape} do not belong together; pass shapes (T,), (T, 3) "
            f"and (T,)."
        )
    if t.size < 2:
        raise RecordingError(f"a run of {t.size} samples crosses no section; pass at least two.")
    bad = np.flatnonzero(~(np.isfinite(t) & np.isfinite(x).all(axis=1)))
    if bad.size:
        raise RecordingError(
            f"{bad.size} of {t.size} samples are not finite, the first is sample {bad[0]}; a path figure is a worst "
            f"case and must not leave samples out. Find out why the run broke off.",
            index=int(bad[0]),
        )
    back = np.flatnonzero(np.diff(t) <= 0)
    if back.size:
        raise RecordingError(
            f"time does not increase from sample {back[0]} ({t[back[0]]:g} s) to the next ({t[back[0] + 1]:g} s); sort "
            f"the samples and drop repeated ones."
        )
    return t, x, n.astype(np.int64)


def sections(
    figure: Figure,
    time: npt.ArrayLike,
    position: npt.ArrayLike,
    cycle: npt.ArrayLike,
    count: int = SECTIONS,
) -> Sections:
    """Find where every cycle of a run crosses the sections of a figure.

    The sections of a stroke are the planes normal to the command path at the arc lengths (i + 1/2) l/count. A cycle
    crosses a section where it passes its plane in the direction of the path. If it passes a plane several times, the
    crossing is chosen that keeps the sections in the order of the path; the choice goes from the middle of the stroke
    outwards. Time does not matter: a run that is late but stays on the path has no path error.

    Parameters
    ----------
    figure
        Command path.
    time
        (T,) increasing. [s]
    position
        (T, 3) attained points, of this figure only, the rest after it included. [m]
    cycle
        (T,) number of the cycle.
    count
        Sections of a stroke.

    Raises
    ------
    RecordingError
        If lengths differ, a sample is not finite, or time does not increase.

    Examples
    --------
    >>> from dehyst_robot.iso9283._curves import Straight
    >>> line = Figure("line", (Straight(np.zeros(3), np.array([4.0, 0.0, 0.0])),))
    >>> x = np.array([[-1.0, 1.0, 0.0], [5.0, 1.0, 0.0]])
    >>> crossed = sections(line, [0.0, 3.0], x, [0, 0], count=2)
    >>> crossed.command[:, 0].tolist(), crossed.attained[0].tolist(), crossed.speed.tolist()
    ([1.0, 3.0], [[1.0, 1.0, 0.0], [3.0, 1.0, 0.0]], [[2.0, 2.0]])
    """
    if count < 1:
        raise ParameterError(
            f"count = {count}: without sections nothing is measured; pass one or more."
        )
    t, x, n = check_run(time, position, cycle)
    ends = np.cumsum([stroke.length for stroke in figure.strokes])
    share = (np.arange(count) + 0.5) / count
    of_strokes = []
    for end, stroke in zip(ends, figure.strokes, strict=True):
        of_strokes.append(end - stroke.length * (1.0 - share))
    s = np.concatenate(of_strokes)
    numbers = np.unique(n)
    attained = np.full((numbers.size, s.size, 3), np.nan)
    speed = np.full((numbers.size, s.size), np.nan)
    for row, number in enumerate(numbers):
        here = n == number
        if here.sum() > 1:
            attained[row], speed[row] = _cross(figure, s, t[here], x[here])
    return Sections(s, figure.position(s), attained, speed)


def _cross(figure: Figure, s: Array, t: Array, x: Array) -> tuple[Array, Array]:
    """Return the points (m, 3) and speeds (m,) at which one cycle crosses the sections; NaN where it does not."""
    index = crossings(figure, s, x)
    reached = np.isfinite(index)
    k = np.minimum(index[reached].astype(np.int64), t.size - 2)
    w = index[reached] - k
    attained = np.full((s.size, 3), np.nan)
    speed = np.full(s.size, np.nan)
    attained[reached] = x[k] + w[:, None] * (x[k + 1] - x[k])
    now = t[k] + w * (t[k + 1] - t[k])
    before = np.maximum(now - 0.5 * WINDOW_S, t[0])
    after = np.minimum(now + 0.5 * WINDOW_S, t[-1])
    way = np.empty((3, now.size))
    for row, axis in enumerate(x.T):
        way[row] = np.interp(after, t, axis) - np.interp(before, t, axis)
    speed[reached] = np.linalg.norm(way, axis=0) / (after - before)
    return attained, speed


def crossings(figure: Figure, s: Array, x: Array) -> Array:
    """Return for arc lengths s (m,), increasing, the fractional sample (m,) at which one cycle x (N, 3) crosses them.

    NaN where it does not.
    """
    command, tangent, _ = figure.chain.at(s)
    # (N, m), distance of every point beyond every plane
    beyond = x @ tangent.T - np.einsum("ij,ij->i", command, tangent)
    section, sample = np.nonzero(((beyond[:-1] < 0.0) & (beyond[1:] >= 0.0)).T)
    before, after = beyond[sample, section], beyond[sample + 1, section]
    weight = before / (before - after)
    crossing = sample + weight
    points = x[sample] + weight[:, None] * (x[sample + 1] - x[sample])
    miss = np.linalg.norm(points - command[section], axis=1)
    # A plane is crossed elsewhere too, where the run is near another part of the path: such crossings are left out by
    # their distance from the nearest commanded point.
    off = np.sqrt(((points[:, None] - command[None]) ** 2).sum(axis=2).min(axis=1))
    near = miss <= 2.0 * off + figure.length / s.size
    section, crossing, miss = section[near], crossing[near], miss[near]
    bounds = np.searchsorted(section, np.arange(s.size + 1))
    stroke = figure.chain.index(s)
    index = np.full(s.size, np.nan)
    for number in np.unique(stroke):
        _order(index, np.flatnonzero(stroke == number), bounds, crossing, miss)
    return index


def _order(index: Array, chosen: Rows, bounds: Rows, crossing: Array, miss: Array) -> None:
    """Choose one crossing a section of a stroke so that they follow one another, from the middle outwards."""
    reached = [i for i in chosen if bounds[i + 1] > bounds[i]]
    if not reached:
        return
    # In the middle of a stroke the nearest crossing is the right one; there the run is far from both rests.
    middle = int(np.argmin(np.abs(np.array(reached) - chosen.mean())))
    start = reached[middle]
    of_start = slice(bounds[start], bounds[start + 1])
    index[start] = crossing[of_start][np.argmin(miss[of_start])]
    now = index[start]
    for i in reached[middle + 1 :]:
        later = crossing[bounds[i] : bounds[i + 1]]
        later = later[later >= now]
        if later.size:
            index[i] = now = later[0]
    now = index[start]
    for i in reversed(reached[:middle]):
        earlier = crossing[bounds[i] : bounds[i + 1]]
        earlier = earlier[earlier <= now]
        if earlier.size:
            index[i] = now = earlier[-1]
