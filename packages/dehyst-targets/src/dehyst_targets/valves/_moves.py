"""Dead band and jump read off the moves of a position that was logged."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst_targets.valves._policy import POLICY

Index = npt.NDArray[np.intp]


def read_off_valves(signal: Array, position: Array) -> list[tuple[float, float]]:
    """Return dead band and jump of a valve whose position was logged, read off in two ways; none if it seldom moves.

    A move at signal u ends at x = u - d f_d, d its direction: a line through all moves tells gain and zero of the
    position, and f_d. Where the direction changes, the last signal at rest is nearer to the valve than f_s and that of
    the move is further: f_s is the median of all these distances. S = f_s + f_d, J = f_s - f_d. Means between moves
    have the least noise if the valve rests there; single samples are right as well if it goes on after its jump.

    Parameters
    ----------
    signal
        Controller output u, (T,). [%]
    position
        Position of the valve, (T,). [its unit]

    Examples
    --------
    >>> from dehyst_targets.valves._positions import valve_positions
    >>> signal = 50.0 + 8.0 * np.sin(0.01 * np.arange(6000))
    >>> position = valve_positions(signal, np.array([5.0]), np.array([2.0]), moves_on=False)
    >>> for dead_band, jump in read_off_valves(signal, 0.16 * position[:, 0] + 4.0):
    ...     print(round(dead_band, 1), round(jump, 1))
    5.0 2.0
    5.0 2.0
    """
    changes = np.diff(position)
    # Most changes are noise, or a slide along the signal, which is smaller than a jump.
    least = POLICY.move_over_noise * 1.4826 * float(np.median(np.abs(changes)))
    moves = np.flatnonzero(np.abs(changes) > max(least, 1e-6 * float(np.ptp(position)))) + 1
    if moves.size < POLICY.fewest_moves:
        return []
    directions = np.sign(changes[moves - 1])
    lengths = np.diff(np.append(moves, position.size))
    means = np.add.reduceat(position, moves) / lengths
    valves = []
    for after, before in ((means, means[:-1]), (position[moves], position[moves[1:] - 1])):
        valve = _valve_of(signal, moves, directions, after, before)
        if valve is not None:
            valves.append(valve)
    return valves


def _valve_of(
    signal: Array, moves: Index, directions: Array, after: Array, before: Array
) -> tuple[float, float] | None:
    """Return dead band and jump from the positions after each move, and before each but the first."""
    columns = np.column_stack([signal[moves], directions, np.ones(moves.size)])
    (gain, kinetic, zero), _, rank, _ = np.linalg.lstsq(columns, after, rcond=None)
    turns = np.flatnonzero(directions[1:] != directions[:-1])
    if rank < columns.shape[1] or gain == 0.0 or turns.size < POLICY.fewest_moves:
        return None
    first = moves[turns + 1]
    away = np.array([signal[first - 1], signal[first]]) - (before[turns] - zero) / gain
    # A valve that closes as the signal rises has a negative gain.
    static = float(np.median(np.sign(gain) * directions[turns + 1] * away))
    if static <= 0.0:
        return None
    kinetic = min(max(float(-kinetic / abs(gain)), 0.0), static)
    return static + kinetic, static - kinetic
