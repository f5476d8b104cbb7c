"""What a model reaches while its input stays in a range, over every history: the limits of a block."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import dehyst._native as _native
from dehyst.arrays import Array

_NO_MAP = np.zeros(0)
EPS = float(np.finfo(np.float64).eps)
EPS_FLOAT = float(np.finfo(np.float32).eps)


@dataclass(frozen=True)
class Operator:
    """Parameters of a model y = after(H[before(x)]) as its stepper shows them."""

    thresholds: Array
    weights: Array
    center: float
    offset: float
    before_u: Array
    before_v: Array
    after_u: Array
    after_v: Array
    start: Array

    def before(self, low: float, high: float) -> tuple[float, float]:
        """Range of the argument of H while the input stays within low..high."""
        return _mapped(self.before_u, self.before_v, low, high)

    def after(self, low: float, high: float) -> tuple[float, float]:
        """Range of the output while H stays within low..high."""
        return _mapped(self.after_u, self.after_v, low, high)

    def in_front_of_after(self, low: float, high: float) -> tuple[float, float]:
        """Range of H for which the output stays within low..high."""
        order = slice(None) if self.after_v.size == 0 or self.after_v[-1] > self.after_v[0] else slice(None, None, -1)
        return _mapped(self.after_v[order], self.after_u[order], low, high)

    def reached(self, low: float, high: float) -> tuple[float, float]:
        """Smallest and largest H while the input stays within low..high, over all histories; also before the first.

        Let all S_i = w_1 + ... + w_i have one sign, say S_i >= 0. Then H rises with its input from any state, so that
        the largest value is taken at the upper end x = b of the range. There

            z_i = max(b - r_i, min(z_i at the start, m + r_i))

        whatever happened between, m the smallest input so far: H is piecewise linear in m, and its largest value
        lies at one of the bends, m = z_i - r_i or m = b - 2 r_i, or at an end. So it is found by a few steps. With
        S_i of both signs (such a model has no inverse) bounds that need not be reached are returned.
        """
        a, b = (x - self.center for x in self.before(low, high))
        slopes = np.cumsum(self.weights)
        if np.any(slopes > 0) and np.any(slopes < 0):
            return self._bounds(a, b, slopes)
        r, z, one_sign = self.thresholds, self.start, np.all(self.weights >= 0) or np.all(self.weights <= 0)
        bends = np.zeros(0) if one_sign else np.concatenate([z - r, b - 2 * r])
        down = _between(a, b, bends)[::-1]
        up = _between(a, b, np.zeros(0) if one_sign else np.concatenate([z + r, a + 2 * r]))
        step = _native.Stepper(r, self.weights, 0.0, self.offset, _NO_MAP, _NO_MAP, _NO_MAP, _NO_MAP, z)
        values = [step.output]
        for end, turns in ((b, down), (a, up)):
            step.reset()
            values.append(step(end))
            for turn in turns.tolist():
                values += [step(turn), step(end)]
        return min(values), max(values)

    def _bounds(self, a: float, b: float, slopes: Array) -> tuple[float, float]:
        """Bounds of H from those of its states and of their differences, |z_i - z_{i+1}| <= r_{i+1} - r_i."""
        r, z = self.thresholds, self.start
        bottom, top = np.minimum(z, a + r), np.maximum(z, b - r)
        w = self.weights
        by_states = (np.minimum(w * bottom, w * top).sum(), np.maximum(w * bottom, w * top).sum())
        cells = float(np.abs(slopes[:-1]) @ np.diff(r))
        last = sorted((float(slopes[-1] * bottom[-1]), float(slopes[-1] * top[-1])))
        low, high = max(by_states[0], last[0] - cells), min(by_states[1], last[1] + cells)
        return self.offset + float(low), self.offset + float(high)

    def widened(self, low: float, high: float, bottom: float, top: float, eps: float = EPS) -> tuple[float, float]:
        """Range of the output for H within bottom .. top and inputs within low..high, and what rounding may add."""
        more = self.rounding(low, high, eps)
        wide = self.after(bottom - more, top + more)
        last = max(abs(y) for y in wide) * 8 * eps if self.after_u.size else 0.0
        return wide[0] - last, wide[1] + last

    def rounding(self, low: float, high: float, eps: float = EPS) -> float:
        """Bound of the rounding of H by a step while the input stays within low..high, eps that of the precision."""
        r, slopes = self.thresholds, np.cumsum(self.weights)
        states = max(abs(x - self.center) for x in self.before(low, high)) + float(r[-1] + np.max(np.abs(self.start)))
        size = abs(self.offset) + float(np.abs(slopes[:-1]) @ np.diff(r)) + abs(float(slopes[-1])) * states
        size += float(np.max(np.abs(slopes))) * states  # the edge cell is a difference of states
        return 4 * (r.size + 4) * eps * size


def _between(a: float, b: float, bends: Array) -> Array:
    return np.unique(np.clip(np.append(bends, [a, b]), a, b))


def _mapped(u: Array, v: Array, low: float, high: float) -> tuple[float, float]:
    if u.size == 0:
        return low, high
    ends = _native.map_values(np.ascontiguousarray(u), np.ascontiguousarray(v), np.array([low, high]))
    return float(ends.min()), float(ends.max())
