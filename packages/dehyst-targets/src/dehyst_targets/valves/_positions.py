"""Where sticking valves stand: two numbers, dead band and jump, for many valves at once."""

from __future__ import annotations

import numpy as np

from dehyst.arrays import Array, Mask


def valve_positions(
    signal: Array,
    dead_band: Array,
    jump: Array,
    start: Array | None = None,
    moves_on: Mask | bool = True,
) -> Array:
    """Return the positions of valves that stick, in the unit of the signal.

    A valve at x stands still until the signal u is further from it than f_s = (S + J)/2, then it moves to
    u - sign(u - x) f_d, f_d = (S - J)/2. A ramp that turns goes S before the valve answers with a jump of J. These are
    the two parameters of M. A. A. Shoukat Choudhury, N. F. Thornhill, S. L. Shah, "Modelling valve stiction", Control
    Engineering Practice 13, 2005, and with friction after every sample the model of Q. P. He, J. Wang, M. Pottmann,
    S. J. Qin, "A curve fitting method for detecting valve stiction in oscillating control loops", Industrial &
    Engineering Chemistry Research 46, 2007.

    Parameters
    ----------
    signal
        Controller output u, (T,).
    dead_band
        S of each valve, (k,). [unit of the signal]
    jump
        J of each valve, 0 <= J <= S, (k,). [unit of the signal]
    start
        Position of each valve before the first sample, (k,); the first value of the signal without it. [unit of the
        signal]
    moves_on
        Whether a valve that moves goes on, without another jump, until the signal turns, as Choudhury's and Kano's
        models do; otherwise it sticks again after every sample, as He's does. One for all, or (k,).

    Returns
    -------
    positions : numpy.ndarray
        (T, k). [unit of the signal]

    Examples
    --------
    >>> ramp = np.array([0.0, 1.0, 2.0, 3.0, 2.0, 1.0, 0.0, -1.0])
    >>> valve_positions(ramp, np.array([2.5]), np.array([0.5]))[:, 0].tolist()
    [0.0, 0.0, 1.0, 2.0, 2.0, 2.0, 1.0, 0.0]
    """
    static, kinetic = 0.5 * (dead_band + jump), 0.5 * (dead_band - jump)
    positions = np.empty((signal.size, dead_band.size))
    x = np.full(dead_band.size, signal[0])
    if start is not None:
        x = np.array(start, dtype=np.float64)
    direction = np.zeros(dead_band.size)  # 0 at rest
    last = signal[0]
    for k, u in enumerate(signal):
        # A signal that rests does not tell that the valve does: records are rounded.
        direction *= moves_on & (direction * (u - last) >= 0.0)
        force = u - x
        breaks_free = (np.abs(force) > static) & (direction == 0.0)
        direction = np.where(breaks_free, np.sign(force), direction)
        x = np.where(direction != 0.0, u - direction * kinetic, x)
        positions[k] = x
        last = u
    return positions
