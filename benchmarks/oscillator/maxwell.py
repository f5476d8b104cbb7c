"""Oscillators with Maxwell slip: a convex start from spectra, refined by output error."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import lsq_linear

from dehyst import _native
from dehyst.arrays import Array
from dehyst.errors import ParameterError
from oscillator.linear import Spectrum, dynamic_stiffness, identify_linear, spectrum
from oscillator.model import HystereticOscillator
from oscillator.output_error import OutputErrorFit, fit_output_error, lead_time
from oscillator.records import PeriodicRecord
from oscillator.upsampling import finer_periodic

_RIDGE = 5.0  # cost of a weight of the size of the linear stiffness, in units of the noise, where its sign is free
_FINER = 4  # the stops of a measured output are followed on a grid so much finer, that extremes are not cut off


@dataclass(frozen=True)
class _Shape:
    """Which unknowns there are: m, c, k, weights, and if position dependent k3 and weights of the square."""

    thresholds: Array
    position_dependent: bool
    scale: Array  # of the unknowns

    def lower(self) -> Array:
        """Bounds: mass, damping and, unless the element depends on the position, stiffness and weights."""
        low = np.zeros(self.scale.size)
        if self.position_dependent:
            low[2:] = -np.inf
        return low

    def build(self, p: Array) -> HystereticOscillator:
        n, q = self.thresholds.size, p * self.scale
        mass, damping, stiffness = q[:3].tolist()
        cubic = float(q[3 + n]) if self.position_dependent else 0.0
        square = q[4 + n :].tolist() if self.position_dependent else ()
        return HystereticOscillator(
            mass, damping, stiffness, cubic, self.thresholds.tolist(), q[3 : 3 + n].tolist(), square
        )


def stop_outputs(y: Array, thresholds: Array) -> Array:
    """Return the stop operators (N, n) of one period of a position in its steady state, y (N,)."""
    twice = np.concatenate([y, y])
    plays, _ = _native.play_bank(
        twice, thresholds, np.zeros(thresholds.size), np.arange(y.size, twice.size)
    )
    return y[:, None] - plays


def _columns(record: PeriodicRecord, shape: _Shape) -> Spectrum:
    """Spectra (lines, unknowns) of what m, c, k, ... are multiplied by, up to half the sampling rate."""
    omega, _, answer = spectrum(record)
    y = finer_periodic(record.output, _FINER)
    stops = stop_outputs(y, shape.thresholds)
    others = [stops]
    if shape.position_dependent:
        others += [(y**3)[:, None], y[:, None] ** 2 * stops]
    spectra = np.fft.rfft(np.concatenate(others, axis=1), axis=0)[: omega.size] / _FINER
    motion = np.stack([-(omega**2) * answer, 1j * omega * answer, answer], axis=1)
    return np.concatenate([motion, spectra], axis=1)


def _convex_start(
    records: Sequence[PeriodicRecord], shape: _Shape, linear: HystereticOscillator
) -> Array:
    """Unknowns with the smallest error of the equation of motion, divided by the linear dynamic stiffness.

    That division makes it nearly an output error. m, c, k and the weights are not negative unless the element depends
    on the position, where single weights have no sign of their own.
    """
    left, right = [], []
    for record in records:
        omega, force, _ = spectrum(record)
        weight = 1.0 / np.abs(dynamic_stiffness(linear, omega))
        left.append(weight[1:-1, None] * _columns(record, shape)[1:-1] * shape.scale)
        right.append(weight[1:-1] * force[1:-1])
    matrix, target = np.concatenate(left), np.concatenate(right)
    real, values = (
        np.concatenate([matrix.real, matrix.imag]),
        np.concatenate([target.real, target.imag]),
    )
    size = np.linalg.norm(real, axis=0)
    solution: Array = lsq_linear(real / size, values, (shape.lower(), np.inf)).x / size
    return solution


def identify_maxwell_slip(
    records: Sequence[PeriodicRecord],
    operators: int = 8,
    *,
    position_dependent: bool = False,
    evaluations: int = 25,
) -> OutputErrorFit:
    r"""Identify an oscillator with Maxwell slip, h = sum_i (w_i + v_i y^2) E_{r_i}[y].

    Thresholds are spread geometrically over the motion. The start is a convex problem: least squares, weights >= 0, of
    the equation of motion at the lines of the averaged spectra. Output error refines it and keeps them so: the model is
    passive.

    Parameters
    ----------
    records
        Averaged periods.
    operators
        Number of stop operators, at least one.
    position_dependent
        Add a cubic spring and the weights v_i; weights may then have any sign, and passivity is not promised.
    evaluations
        Limit of the iterations of the refinement.

    Raises
    ------
    ParameterError
        `operators` is below one.
    ExcitationError, IdentificationError
        As by the linear fit and the optimiser.
    """
    if operators < 1:
        raise ParameterError(
            f"operators = {operators}: Maxwell slip needs at least one.", operators=operators
        )
    linear = identify_linear(records)
    reach = max(float(np.abs(record.output).max()) for record in records)
    spring = [linear.stiffness] * operators
    scale = [linear.mass, linear.damping, linear.stiffness, *spring]
    if position_dependent:
        scale += [value / reach**2 for value in (linear.stiffness, *spring)]
    shape = _Shape(
        np.geomspace(0.1 * reach, 0.9 * reach, operators), position_dependent, np.array(scale)
    )
    start = _convex_start(records, shape, linear)
    lead = lead_time(linear.mass, 0.5 * linear.damping)
    prior = (lambda p: _RIDGE * p[3:]) if position_dependent else None
    low = shape.lower()
    return fit_output_error(
        shape.build, start, records, lead=lead, prior=prior, lower=low, evaluations=evaluations
    )
