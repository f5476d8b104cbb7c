r"""A resonance behind the loop, and the shaper of the reference that does not excite it.

An actuator with a mass rings when what moves it turns a corner. Its output is then that of the loop behind

.. math::

    G(s) = \frac{1}{1 + 2 \zeta s/\omega + s^2/\omega^2}, \qquad \omega = 2 \pi f

A reference that is split into two parts, the second one half a damped period later, starts two swings that cancel:

.. math::

    s(t) = (1 - a) r(t) + a r(t - h), \qquad
    h = \frac{1}{2 f \sqrt{1 - \zeta^2}}, \qquad
    a = \frac{K}{1 + K}, \quad K = e^{-\pi \zeta/\sqrt{1 - \zeta^2}}

Both shares are positive and add up to 1, so that the shaped reference never leaves the range of the reference, and no
noise is amplified. It is late by a h in the mean.

Source: N. C. Singer, W. P. Seering, "Preshaping Command Inputs to Reduce System Vibration", Journal of Dynamic Systems,
Measurement, and Control 112(1), 1990 (the zero-vibration shaper).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.errors import ParameterError
from dehyst.models._arrays import parameter_number, signal_array, strictly_increasing

FEWEST = 2  # samples in half a swing: with fewer, two parts are none
HEAVIEST = 0.7  # damping beyond which nothing swings


@dataclass(frozen=True)
class Resonance:
    """A frequency at which an actuator rings.

    Parameters
    ----------
    frequency
        f, of the undamped swing. [Hz]
    damping
        zeta: 0 rings for ever, from 0.7 on nothing rings.

    Raises
    ------
    ParameterError
        If a frequency is not above 0, or a damping not from 0 to below 0.7.

    Examples
    --------
    >>> resonance = Resonance(300.0, 0.02)
    >>> round(1e3 * resonance.half_swing, 3), round(resonance.share, 3)
    (1.667, 0.484)
    """

    frequency: float
    damping: float

    def __post_init__(self) -> None:
        """Refuse what does not ring."""
        for name in ("frequency", "damping"):
            object.__setattr__(self, name, parameter_number(getattr(self, name), name))
        if not self.frequency > 0.0 or not 0.0 <= self.damping < HEAVIEST:
            raise ParameterError(
                f"a resonance of {self.frequency:g} Hz with a damping of {self.damping:g}; its frequency is above 0, "
                f"its damping from 0 to below {HEAVIEST:g}, beyond which nothing rings.",
                frequency=self.frequency,
                damping=self.damping,
            )

    @property
    def half_swing(self) -> float:
        """h: half a period of the damped swing. [s]"""
        return 0.5 / (self.frequency * math.sqrt(1.0 - self.damping**2))

    @property
    def share(self) -> float:
        """a: share of the second part of the reference."""
        left = math.exp(-math.pi * self.damping / math.sqrt(1.0 - self.damping**2))
        return left / (1.0 + left)

    @property
    def lead(self) -> float:
        """a h: how late the shaped reference is in the mean. [s]"""
        return self.share * self.half_swing

    def samples(self, period: float) -> int:
        """Return h in samples of a period [s], rounded; 0 where it is less than two, and nothing can be shaped."""
        number = round(self.half_swing / period)
        return number if number >= FEWEST else 0

    def spacing(self, period: float) -> float:
        """Return h in whole samples of a period [s]; 0 where nothing can be shaped. [s]"""
        return self.samples(period) * period

    def shaped(
        self, reference: npt.ArrayLike, time: npt.ArrayLike, lead: float | None = None
    ) -> Array:
        """Return s(t + lead) of a reference (T,): between samples on a line, both ends held.

        Parameters
        ----------
        reference
            (T,), any unit.
        time
            (T,), increasing. h is rounded to the median step, as in a unit that runs sample by sample. [s]
        lead
            By which it is moved to earlier times; None, the default: so far that it is not late in the mean. [s]

        Raises
        ------
        ParameterError
            If the two differ in length, hold what is no number, or the time does not increase.

        Examples
        --------
        >>> time = 0.5e-3 * np.arange(8)
        >>> Resonance(500.0, 0.0).shaped([0.0, 0, 0, 0, 1, 1, 1, 1], time, 0.0).tolist()
        [0.0, 0.0, 0.0, 0.0, 0.5, 0.5, 1.0, 1.0]
        """
        values, at = signal_array(reference, "reference"), signal_array(time, "time")
        if at.size != values.size:
            raise ParameterError(
                f"the reference has {values.size} samples and the time {at.size}; pass as many of both."
            )
        strictly_increasing(at, "time")
        if at.size < 2:
            return values
        h = self.spacing(float(np.median(np.diff(at))))
        moved = at + (self.share * h if lead is None else lead)
        a = self.share
        first = np.interp(moved, at, values)
        second = np.interp(moved - h, at, values)
        return np.asarray((1.0 - a) * first + a * second)


def resonance_of(value: Any) -> Resonance | None:
    """Return a resonance from itself, or from a pair of frequency and damping; None from nothing, or an empty pair."""
    if value is None or isinstance(value, Resonance):
        return value
    if isinstance(value, list | tuple | np.ndarray) and len(value) == 0:
        return None
    try:
        frequency, damping = value
    except (TypeError, ValueError):
        raise ParameterError(
            f"a resonance is {value!r:.60}; pass its frequency in Hz and its damping."
        ) from None
    return Resonance(frequency, damping)
