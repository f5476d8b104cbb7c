"""A cycling rig for tests and benchmarks of drift: logs of an actuator that may wear, from a generator of its own.

The plant shares no code with dehyst: a curve that stiffens, elastic-slip elements (a loop of Prandtl's kind), creep of
two first-order lags, sensors with noise that remembers (first-order, correlation 0.9 from sample to sample), cycles of
uneven size and length. What wears is given as functions of the progress of the log, 0 to 1.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

import dehyst

Array = npt.NDArray[np.float64]
Course = Callable[[Array], Array]

ELEMENTS = np.geomspace(0.05, 1.2, 12)  # slip distances [bar]
STIFFNESS = 4.5 / ELEMENTS.size  # of each [deg/bar]
SLOPE, BEND = 6.0, 0.15  # of the curve [deg/bar, deg/bar^3]
CREEP, CREEP_TIMES = 0.12, (3.0, 40.0)  # of each lag [deg/bar, s]
AMPLITUDE, PERIOD = 2.0, 4.0  # of a cycle [bar, s]
INPUT_NOISE, OUTPUT_NOISE, MEMORY = 0.002, 0.03, 0.9  # [bar, deg rms]


@dataclass(frozen=True)
class Wear:
    """Factors of the parts (offset: added, in deg) as functions of the progress of a log, 0 to 1."""

    courses: Mapping[str, Course | float] = field(default_factory=dict)

    def at(self, part: str, progress: Array, new: float) -> Array:
        """Value of one part at each sample."""
        course = self.courses.get(part, new)
        return np.asarray(course(progress) if callable(course) else np.full(progress.size, course))


def cycling_log(
    seed: int,
    cycles: int,
    wear: Mapping[str, Course | float] | None = None,
    *,
    rate: float = 20.0,
    uneven: float = 0.04,
    minor: bool = False,
    amplitude: float = AMPLITUDE,
    noise: float = 1.0,
    name: str = "",
) -> dehyst.Recording:
    """Return one log.

    Parameters
    ----------
    seed
        Of noise and unevenness; the same seed gives the same bits.
    cycles
        How many there are.
    wear
        Parts "hysteresis", "gain", "creep" (factors), "offset" [deg], "bend" (factor of the cubic term).
    uneven
        Standard deviation of size and length of the cycles.
    minor
        Whether every third cycle is half as large.
    """
    random = np.random.default_rng(seed)
    x, t = _drive(random, cycles, rate, uneven, minor, amplitude)
    return logged(random, x, t, wear, noise=noise, name=name or f"log {seed}")


def logged(
    random: np.random.Generator,
    x: Array,
    t: Array,
    wear: Mapping[str, Course | float] | None = None,
    *,
    noise: float = 1.0,
    name: str = "",
) -> dehyst.Recording:
    """Return the log of a drive of one's own, (T,) at even times; `wear` as in `cycling_log`."""
    rate = (t.size - 1) / (t[-1] - t[0])
    progress = np.linspace(0.0, 1.0, x.size)
    worn = Wear(wear or {})
    y = SLOPE * x + worn.at("bend", progress, 1.0) * BEND * x**3
    y -= worn.at("hysteresis", progress, 1.0) * _loop(x)
    y += worn.at("creep", progress, 1.0) * _creep(x, 1.0 / rate)
    y = worn.at("gain", progress, 1.0) * y + worn.at("offset", progress, 0.0)
    return dehyst.Recording(
        input=x + noise * INPUT_NOISE * random.standard_normal(x.size),
        output=y + noise * OUTPUT_NOISE * _coloured(random, x.size),
        time=t,
        name=name,
        input_name="pressure",
        output_name="angle",
        input_unit="bar",
        output_unit="deg",
    )


def _drive(
    random: np.random.Generator,
    cycles: int,
    rate: float,
    uneven: float,
    minor: bool,
    amplitude: float,
) -> tuple[Array, Array]:
    """Half sines from tip to tip, preceded by one large cycle that is not counted."""
    size = amplitude * (1.0 + uneven * random.standard_normal(2 * cycles + 2)).clip(0.8, 1.05)
    if minor:
        size[4::6] *= 0.5
        size[5::6] *= 0.5
    size[:2] = 1.05 * amplitude
    tips = size * np.where(np.arange(size.size) % 2, -1.0, 1.0)
    parts = [np.zeros(1)]
    for before, after in zip(np.r_[0.0, tips[:-1]], tips, strict=True):
        steps = max(4, round(rate * 0.5 * PERIOD * (1.0 + uneven * random.standard_normal())))
        parts.append(
            before
            + (after - before) * 0.5 * (1.0 - np.cos(np.pi * np.arange(1, steps + 1) / steps))
        )
    x = np.concatenate(parts)
    return x, np.arange(x.size) / rate


def _loop(x: Array) -> Array:
    """Force of springs that slip, all elements at once."""
    held, last, out = np.zeros(ELEMENTS.size), 0.0, np.empty(x.size)
    for k, value in enumerate(x.tolist()):
        held = np.minimum(ELEMENTS, np.maximum(-ELEMENTS, held + (value - last)))
        out[k] = STIFFNESS * held.sum()
        last = value
    return out


def _creep(x: Array, step: float) -> Array:
    total = np.zeros(x.size)
    for constant in CREEP_TIMES:
        late, decay = 0.0, float(np.exp(-step / constant))
        for k, value in enumerate(x.tolist()):
            late = decay * late + (1.0 - decay) * value
            total[k] += CREEP * late
    return total


def _coloured(random: np.random.Generator, size: int) -> Array:
    white = random.standard_normal(size).tolist()
    out, value, fresh = np.empty(size), white[0], float(np.sqrt(1.0 - MEMORY**2))
    for k, new in enumerate(white):
        value = MEMORY * value + fresh * new
        out[k] = value
    return out
