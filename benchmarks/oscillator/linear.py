"""Best linear oscillator: where every other fit of an oscillator starts, and what it has to beat."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.errors import ExcitationError
from oscillator.model import HystereticOscillator
from oscillator.records import PeriodicRecord

ROUNDS = 12
Spectrum = npt.NDArray[np.complex128]


def dynamic_stiffness(oscillator: HystereticOscillator, omega: Array) -> Spectrum:
    """Return -m omega^2 + i omega c + k, complex (n,), of an oscillator without its hysteretic part. [N/m]"""
    stiffness: Spectrum = (
        oscillator.stiffness - oscillator.mass * omega**2 + 1j * omega * oscillator.damping
    )
    return stiffness


def spectrum(record: PeriodicRecord) -> tuple[Array, Spectrum, Spectrum]:
    """Return omega [rad/s], force and output at the lines of a record."""
    omega: Array = (
        2 * np.pi * np.fft.rfftfreq(record.force.size, record.sampling_time).astype(np.float64)
    )
    return omega, np.fft.rfft(record.force), np.fft.rfft(record.output)


def identify_linear(records: Sequence[PeriodicRecord]) -> HystereticOscillator:
    r"""Return m, c, k of the linear oscillator whose output errors at the excited lines are smallest.

    .. math::  \min \sum_\omega |Y - U / (-m \omega^2 + i \omega c + k)|^2

    by least squares on the equation error, weighted by the stiffness of the round before (Sanathanan and Koerner).

    Parameters
    ----------
    records
        Periodic experiments.

    Raises
    ------
    ExcitationError
        Fewer than two lines are excited, or the answer has no positive mass and stiffness.
    """
    rows, forces = [], []
    for record in records:
        omega, u, y = spectrum(record)
        excited = np.abs(u) > 1e-3 * np.abs(u).max()
        w, answer = omega[excited], y[excited]
        rows.append(np.stack([-(w**2) * answer, 1j * w * answer, answer], axis=1))
        forces.append(u[excited])
    matrix, right = np.concatenate(rows), np.concatenate(forces)
    if right.size < 2:
        raise ExcitationError(
            "the force excites fewer than two frequencies: three parameters need at least two."
        )
    weight = np.ones(right.size)
    for _ in range(ROUNDS):
        left, target = weight[:, None] * matrix, weight * right
        real = np.concatenate([left.real, left.imag])
        size = np.linalg.norm(real, axis=0)
        solution = (
            np.linalg.lstsq(real / size, np.concatenate([target.real, target.imag]), rcond=None)[0]
            / size
        )
        answer = matrix[:, 2]
        weight = np.abs(answer) / np.maximum(np.abs(matrix @ solution), 1e-300)
    mass, damping, stiffness = (float(value) for value in solution)
    if not (mass > 0 and stiffness > 0):
        raise ExcitationError(
            f"the best linear oscillator has mass {mass:.3g} and stiffness {stiffness:.3g}: output and force do not "
            f"belong to one oscillator, or the force stays on one side of its resonance. Excite both sides."
        )
    return HystereticOscillator(mass, damping, stiffness)
