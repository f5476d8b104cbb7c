"""Whether a rig is fit for the zoo: finite, a loop of some width, an output that rises with the input, repeatable."""

from __future__ import annotations

import time

import numpy as np

from zoo.compiled import Array
from zoo.logs import ROUTINE, recording, smooth, true_log
from zoo.references import REFERENCES, reference
from zoo.rigs import Rig

WIDTH = (2.0, 35.0)  # of a loop over the range, percent
RISE = 0.3  # least mean slope of a tenth of a branch, over the mean one of the rig, in the middle of the range


def loop(rig: Rig, slower: float = 1.0) -> tuple[Array, Array, Array, Array]:
    """Return falling and rising branch over the range: input and output of each, (T,)."""
    samples = round(slower * rig.stroke / rig.period)
    up, down = smooth(rig.low, rig.high, samples), smooth(rig.high, rig.low, samples)
    u = np.concatenate([smooth(rig.rest, rig.high, samples), down, up, down, up])
    y = rig.play(u)
    return u[-2 * samples : -samples], y[-2 * samples : -samples], u[-samples:], y[-samples:]


def width(rig: Rig, slower: float = 1.0) -> float:
    """Return the mean width of the loop over the range: its area over that of its box, percent."""
    down, falling, up, rising = loop(rig, slower)
    area = abs(float(np.trapezoid(falling, down) + np.trapezoid(rising, up)))
    return 100.0 * area / ((rig.high - rig.low) * float(np.ptp(np.concatenate([falling, rising]))))


def rise(rig: Rig) -> float:
    """Return the least slope over a tenth of the input, over the mean one, where the output is within 10..90 %."""
    down, falling, up, rising = loop(rig)
    low, span = float(rising.min()), float(np.ptp(rising))
    least = np.inf
    for u, y in ((up, rising), (down[::-1], falling[::-1])):
        inside = (y > low + 0.1 * span) & (y < low + 0.9 * span)
        grid = np.arange(u[inside].min(), u[inside].max(), 0.1 * (rig.high - rig.low))
        if grid.size > 1:
            least = min(least, 10.0 * float(np.diff(np.interp(grid, u, y)).min()) / span)
    return least


def checked(rig: Rig) -> bool:
    """Print the figures of a rig; return whether it is fit."""
    begun = time.perf_counter()
    u, y = true_log(rig, "usual")
    spent = time.perf_counter() - begun
    wide, slow, slope = width(rig), width(rig, 10.0), rise(rig)
    same = np.array_equal(recording(rig, ROUTINE).output, recording(rig, ROUTINE).output)
    finite = bool(np.isfinite(y).all())
    fit = finite and same and WIDTH[0] <= wide <= WIDTH[1] and slope >= RISE
    sizes = [reference(rig, kind)[0].size for kind in REFERENCES]
    print(
        f"{rig.name:11s} {'ok ' if fit else 'BAD'} {1.0 / rig.period:7.0f} Hz {u.size:7d} rows "
        f"{u.size * rig.period:7.0f} s in {spent:4.1f} s  output {y.min():8.3g} to {y.max():8.3g} "
        f"{rig.output_unit:4s} width {wide:5.1f} %, slow "
        f"{slow:5.1f} %  slope {slope:4.2f}  noise {100.0 * rig.noise / np.ptp(y):5.3f} %  references {sizes}",
        flush=True,
    )
    return fit
