"""Branches of the outer loop, made monotone, and the decay rate of the hysteresis state from partial cycles.

The model is PyBaMM's "one-state hysteresis" (from version 25.10 on), of a constant decay rate Gamma a direction::

    U = (1 + h)/2 U_delithiation(x) + (1 - h)/2 U_lithiation(x)
    dh/dx = -Gamma (1 - h)/2 in delithiation,  -Gamma (1 + h)/2 in lithiation

so that h goes to 1 or -1 over a stoichiometry of 2/Gamma. Source: D. Axen et al., Evaluation of hysteresis expressions
in a lithium-ion battery model, J. Energy Storage 48 (2022) 103985.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from dehyst.arrays import Array
from dehyst.errors import DehystError, ParameterError
from dehyst.findings import Finding
from dehyst_targets.batteries._ocv import OcvLog, ocv_of
from dehyst_targets.batteries._policy import POLICY

POINTS = 120  # of a branch
RATES = np.geomspace(1.0, 1000.0, 61)  # of the search; finer ones between follow
FINER = 4  # rounds, each a sixth as wide
SAMPLES = 4000  # of the search


@dataclass(frozen=True, eq=False)
class OcvFit:
    """Open-circuit voltage with one state of hysteresis.

    Attributes
    ----------
    x
        Stoichiometry, increasing, (n,).
    lithiation, delithiation
        Voltage of both branches, falling, (n,) each. [V]
    rates
        Decay rates Gamma in lithiation and in delithiation; None if the log has no partial cycles.
    error, minor_error, middle_error
        Rms over the whole log, over what is outside of the outer loop (NaN without), and over the whole log of the
        mean of both branches, a curve without hysteresis. [V]
    findings
        Of the fit.
    """

    x: Array
    lithiation: Array
    delithiation: Array
    rates: tuple[float, float] | None
    error: float
    minor_error: float
    middle_error: float
    findings: tuple[Finding, ...] = ()

    def start(self, x: float, voltage: float) -> float:
        """State h of a point, within -1 .. 1."""
        low, high = np.interp(x, self.x, self.lithiation), np.interp(x, self.x, self.delithiation)
        return float(
            np.clip((2.0 * voltage - low - high) / max(float(high - low), 1e-9), -1.0, 1.0)
        )

    def simulate(self, x: Array, state: float) -> Array:
        """Return the voltage (T,) along x (T,) from a state h on. [V]

        Raises
        ------
        ParameterError
            If the decay rates are not known.

        Examples
        --------
        >>> ends = np.array([0.0, 1.0])
        >>> fit = OcvFit(ends, 0.5 - 0.4 * ends, 0.6 - 0.4 * ends, (40.0, 40.0), 0.0, 0.0, 0.0)
        >>> fit.simulate(np.array([0.5, 0.4, 0.3]), -1.0).round(3).tolist()
        [0.3, 0.426, 0.478]
        """
        if self.rates is None:
            raise ParameterError(
                "the decay rate is not known. Type it: --decay 50, or log partial cycles."
            )
        h = _states(x, np.array([self.rates]), state)[:, 0]
        return voltage_of(self, x, h)


def voltage_of(fit: OcvFit, x: Array, h: Array) -> Array:
    """Return the voltage at stoichiometries (T,) and states h, (T,) or (T, P). [V]"""
    low, high = np.interp(x, fit.x, fit.lithiation), np.interp(x, fit.x, fit.delithiation)
    if h.ndim == 2:
        low, high = low[:, None], high[:, None]
    return np.asarray(0.5 * (1.0 + h) * high + 0.5 * (1.0 - h) * low)


def _states(x: Array, rates: Array, start: float) -> Array:
    """States h (T, P) of many pairs of rates (P, 2); each step is exact."""
    h = np.full(len(rates), start)
    path = np.empty((x.size, h.size))
    path[0] = h
    for k, move in enumerate(np.diff(x).tolist()):
        if move > 0.0:
            h = -1.0 + (h + 1.0) * np.exp(-0.5 * rates[:, 0] * move)
        else:
            h = 1.0 + (h - 1.0) * np.exp(0.5 * rates[:, 1] * move)
        path[k + 1] = h
    return path


def fit_ocv(log: OcvLog, *, decay: float | None = None) -> OcvFit:
    """Fit branches and decay rates to a log.

    Parameters
    ----------
    log
        Of `read_ocv` or `ocv_of`.
    decay
        Decay rate, where it is known; otherwise it is fitted to the partial cycles.

    Raises
    ------
    ParameterError
        If the decay rate is none.

    Examples
    --------
    >>> from dehyst_targets.batteries import ocv_of
    >>> x = np.interp(np.arange(900), [0, 300, 600, 700, 800, 899], [0, 1, 0, 0.5, 0.3, 0.5])
    >>> ends = np.array([0.0, 1.0])
    >>> truth = OcvFit(ends, 0.5 - 0.4 * ends, 0.6 - 0.4 * ends, (40.0, 30.0), 0.0, 0.0, 0.0)
    >>> fit = fit_ocv(ocv_of(x, truth.simulate(x, -1.0)))
    >>> [round(rate / 5.0) for rate in fit.rates]
    [8, 6]
    """
    if decay is not None and not 0.0 < decay < 1e6:
        raise ParameterError(
            f"--decay {decay:g} is no decay rate. Type a number above 0, e.g. --decay 50."
        )
    fit = _fitted(log, decay)
    if fit.rates is None or fit.error <= POLICY.gain * fit.middle_error:
        return fit
    cause = "Check that both columns are of one electrode, and that its cycles were slow"
    if decay is not None:
        cause += ", and the rate that was typed"
    if _is_exchanged(log):
        cause = (
            "With charge and voltage exchanged, the model follows them: the values stand under the wrong headings. "
            "Correct the headings in the log"
        )
    finding = Finding(
        "ocv-no-gain",
        f"one-state hysteresis errs by {1e3 * fit.error:.1f} mV, and a curve without hysteresis by "
        f"{1e3 * fit.middle_error:.1f} mV: the model is no better, so no file is written. {cause}.",
    )
    return replace(fit, findings=(finding,))


def _is_exchanged(log: OcvLog) -> bool:
    """Whether the model follows the log with charge and voltage exchanged."""
    try:
        other = _fitted(ocv_of(log.voltage, log.x), None)
    except DehystError:
        return False
    return other.error < POLICY.exchanged * other.middle_error


def _fitted(log: OcvLog, decay: float | None) -> OcvFit:
    """Branches, and the rates that were typed or are fitted."""
    x = np.linspace(log.x.min(), log.x.max(), POINTS)
    low, high = (_branch(log, x, lithiation) for lithiation in (True, False))
    # Noise must not let the branches cross.
    low, high = np.minimum(low, high), np.maximum(low, high)
    nan = float("nan")
    fit = OcvFit(x, low, high, None, nan, nan, nan)
    # The curve that a model without hysteresis would use.
    middle = float(
        np.sqrt(np.mean((voltage_of(fit, log.x, np.zeros(log.x.size)) - log.voltage) ** 2))
    )
    minor = log.minor
    samples = int(np.count_nonzero(minor))
    if decay is not None:
        rates = (decay, decay)
    elif samples >= POLICY.fewest_minor:
        rates = _rates(log, fit)
    else:
        finding = Finding(
            "ocv-no-partial-cycles",
            f"{samples} samples of {log.name} lie outside of the outer loop, which does not tell how soon the "
            f"voltage changes branches after a turn. Log partial cycles, or type the rate: --decay 50.",
        )
        return OcvFit(x, low, high, None, nan, nan, middle, (finding,))
    fitted = OcvFit(x, low, high, rates, nan, nan, middle)
    left = fitted.simulate(log.x, fitted.start(log.x[0], log.voltage[0])) - log.voltage
    minor_error = nan
    if samples:
        minor_error = float(np.sqrt(np.mean(left[minor] ** 2)))
    return OcvFit(x, low, high, rates, float(np.sqrt(np.mean(left**2))), minor_error, middle)


def _branch(log: OcvLog, x: Array, lithiation: bool) -> Array:
    """Mean of the outer strokes of a direction around each x, never rising."""
    strokes = log.outer(lithiation)
    place = np.concatenate([log.x[stroke] for stroke in strokes])
    voltage = np.concatenate([log.voltage[stroke] for stroke in strokes])
    order = np.argsort(place, kind="stable")
    place, voltage = place[order], voltage[order]
    bins = np.clip(np.rint((place - x[0]) / (x[1] - x[0])).astype(np.int64), 0, x.size - 1)
    counts = np.bincount(bins, minlength=x.size)
    filled = counts > 0
    means = np.bincount(bins, voltage, x.size)[filled] / counts[filled]
    middles = np.bincount(bins, place, x.size)[filled] / counts[filled]
    curve = np.interp(x, middles, means)
    # Noise lets a branch rise here and there; the middle of these two bounds never does.
    downward = np.minimum.accumulate(curve)
    upward = np.maximum.accumulate(curve[::-1])[::-1]
    return 0.5 * (downward + upward)


def _rates(log: OcvLog, fit: OcvFit) -> tuple[float, float]:
    """Least squares over what is outside of the outer loop: a grid of both rates, then finer ones around the best."""
    stride = max(1, log.x.size // SAMPLES)
    # A turn that is left out would come late, and with it the decay behind it.
    rows = np.unique(np.concatenate((np.arange(0, log.x.size, stride), log.turns)))
    minor = log.minor[rows]
    x, voltage = log.x[rows], log.voltage[rows]
    start = fit.start(x[0], voltage[0])
    shares = np.log(RATES)[::6]
    best, width = np.zeros(2), shares[1] - shares[0]
    grid = np.array(np.meshgrid(shares, shares)).reshape(2, -1).T
    for _ in range(1 + FINER):
        # On the outer loop the state rests at its ends, whatever the rate.
        left = voltage_of(fit, x, _states(x, np.exp(grid), start))[minor] - voltage[minor, None]
        best = grid[int(np.argmin(np.mean(left**2, axis=0)))]
        near = np.linspace(-width, width, 7)
        grid = best + np.array(np.meshgrid(near, near)).reshape(2, -1).T
        width /= 3.0
    lithiation, delithiation = np.exp(best).tolist()
    return lithiation, delithiation
