"""The scale k of the sheared loop: chosen by what the inverse misses on held-out blocks."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy.typing as npt

from dehyst.data.ranges import robust_range
from dehyst.data.recording import Recording, takes_recordings
from dehyst.errors import ParameterError
from dehyst.identification.cross_validation import Trial, cross_validate
from dehyst.identification.data import prepare
from dehyst.identification.families import HIGH_GAIN
from dehyst.identification.settings import PAPER_EPS, PAPER_OPERATORS, check_recordings
from dehyst.identification.split import split_recordings
from dehyst.models.arrays import parameter_number

# Candidates for k lie from the range of the input over the range of the output to so many times that.
LARGEST = 100.0
# The smallest k whose inverse misses no more than this above the least: beyond, k only costs digits and threshold grid.
WITHIN = 0.05
# A gain of the compensator above this share of what the bound allows is decided by the bound, not by the data.
OFF_BOUND = 0.75
# The paper's eps has units: in those of another log, or with a large k, it may exceed the slope itself.
LARGEST_EPS = 0.01
SHEARED_FAMILIES = ("pi", "pi-cumulative")


@dataclass(frozen=True)
class ShearChoice:
    """What `choose_shear` compared, and what it took.

    Attributes
    ----------
    shear
        k. [input/output]
    gain
        Slope of the compensator right after a reversal, with k subtracted, in cross-validation. [input/output]
    error
        What the inverse missed on held-out blocks, geometric mean of the RMS. [input]
    on_bound
        Whether the chosen k leaves the compensator steep after a reversal, or its first weight at the bound: then the
        bound decides the gain, not the data.
    trials
        All candidates in the order of k, as `cross_validate` returns them.

    Examples
    --------
    >>> from dehyst.robot.experiments import example_recording
    >>> choice = choose_shear(example_recording())
    >>> choice.on_bound, choice.error <= 1.05 * min(trial.inverse_error for trial in choice.trials)
    (False, True)
    """

    shear: float
    gain: float
    error: float
    on_bound: bool
    trials: tuple[Trial, ...]

    def as_list(self) -> list[dict[str, float]]:
        """Return k, what the inverse missed and the gain of the compensator for each candidate, as plain values."""
        return [{"shear": t.shear, "inverse_error": t.inverse_error, "gain": _gain(t)} for t in self.trials]


@takes_recordings
def choose_shear(
    recordings: Recording | Sequence[Recording],
    *,
    family: str = "pi",
    n: int = PAPER_OPERATORS,
    eps: float = PAPER_EPS,
    max_inverse_gain: float | None = None,
    initial_state: str = "zero",
    train_fraction: float | None = None,
    weights: npt.ArrayLike | Sequence[npt.ArrayLike] | None = None,
) -> ShearChoice:
    r"""Choose the scale k of the sheared loop :math:`x = u + k y` by the held-out error of the inverse.

    Forward accuracy says little: the larger k, the nearer y lies to x/k whatever the model. What counts is

    .. math:: u - (H^{-1}[y] - k y)

    on blocks of the log that were not fitted. With a small k the first weight ends at the paper's bound, and the
    compensator steps at every reversal; candidates with a gain of more than 20 times the ratio of the ranges there are
    left out if there are others, and all count where a gain is given. Of these the smallest k within 5 % of the least
    error is taken.

    Parameters
    ----------
    recordings
        One recording or a list of them: input u and output y as they were logged, not sheared.
    family
        "pi" or "pi-cumulative".
    n
        Number of operators.
    eps
        Smallest first weight, as `identify` takes it; at most a hundredth of the slope of the sheared loop.
    max_inverse_gain
        G, largest slope of the compensator right after a reversal: then eps = 1/(G + k) for each k. [input/output]
    initial_state
        Memory before the first sample, as `cross_validate` takes it.
    train_fraction
        Share of each recording that takes part; the rest stays unseen.
    weights
        How much each sample counts, as `identify` takes it.

    Returns
    -------
    choice : ShearChoice

    Raises
    ------
    ParameterError
        If a setting lies outside what its formula allows.
    ExcitationError
        If input or output does not move.

    Examples
    --------
    A loop whose backbone was taken off: the output does not follow from the input, the compensator does.

    >>> import numpy as np, dehyst
    >>> y = np.interp(np.linspace(0, 12, 2401), range(13), [0, 1, -1, .8, -.8, .5, -.9, .6, -.5, 1, -.3, .7, 0])
    >>> u = dehyst.StopOperatorModel([0.0, 0.1, 0.3], [0.0, 1.0, 0.5], slope=0.0).simulate(y)
    >>> choice = choose_shear(dehyst.Recording(input=u, output=y))
    >>> choice.shear > 0, bool(choice.error < 0.05 * np.std(u))
    (True, True)
    """
    records = check_recordings(recordings)
    check_family(family)
    data = prepare(records, split_recordings(records, 1.0))
    ratio = data.trend * robust_range([record.input for record in records]) / robust_range([r.output for r in records])
    trials: list[Trial] = []
    bounds: list[float] = []
    for k in candidates(ratio):
        bounds.append(_bound(family, eps, max_inverse_gain, k, ratio))
        table = cross_validate(
            records, families=(family,), n=(n,), shear=(k,), starts=(initial_state,),
            eps=bounds[-1], train_fraction=train_fraction, weights=weights,
        )  # fmt: skip
        trials += table.trials
    steep = HIGH_GAIN * abs(ratio)  # what the finding high-inverse-gain warns of
    free = [
        t
        for t, eps_k in zip(trials, bounds, strict=True)
        if _gain(t) <= min(steep, OFF_BOUND * (1.0 / eps_k - abs(t.shear)))
    ]
    eligible = free if free and max_inverse_gain is None else trials
    least = min(t.inverse_error for t in eligible)
    chosen = next(t for t in eligible if t.inverse_error <= (1.0 + WITHIN) * least)
    return ShearChoice(chosen.shear, _gain(chosen), chosen.inverse_error, chosen not in free, tuple(trials))


def _bound(family: str, eps: float, gain: float | None, k: float, ratio: float) -> float:
    """Return the eps of a cross-validation: that of the gain, or the paper's where the sheared slope allows it."""
    slope = 1.0 / (abs(k) + abs(ratio))
    if gain is not None:
        bound = min(eps_of_gain(gain, k), slope)
        return bound if family == "pi" else bound / slope
    return min(eps, LARGEST_EPS * slope) if family == "pi" else eps


def candidates(ratio: float) -> list[float]:
    """Return 1, 2 and 5 times powers of ten from a ratio to a hundred times it, with its sign.

    Examples
    --------
    >>> candidates(0.54)
    [1.0, 2.0, 5.0, 10.0, 20.0, 50.0]
    """
    size = abs(ratio)
    first = math.floor(math.log10(size))
    grid = [float(f"{digit}e{first + decade}") for decade in range(4) for digit in (1, 2, 5)]
    return [math.copysign(k, ratio) for k in grid if size <= k <= LARGEST * size]


def _gain(trial: Trial) -> float:
    """Slope of the compensator right after a reversal: k is subtracted."""
    return trial.inverse_gain - abs(trial.shear)


def eps_of_gain(gain: float, shear: float = 0.0) -> float:
    """Return the bound of the first weight that keeps |1/w_1| - |k| <= G: eps = 1/(G + |k|). [output/input].

    Examples
    --------
    >>> eps_of_gain(20.0), eps_of_gain(20.0, shear=5.0)
    (0.05, 0.04)
    """
    gain = parameter_number(gain, "max_inverse_gain")
    if gain <= 0.0:
        raise ParameterError(
            f"max_inverse_gain = {gain:g} must be positive: it is the largest change of the inverse's output for one "
            f"unit of its input, right after a reversal. 1000 is what the paper's eps = 0.001 allows.",
            gain=gain,
        )
    return 1.0 / (gain + abs(shear))


def check_family(family: str) -> None:
    """Refuse families whose inverse less k y is not of their own kind."""
    if family not in SHEARED_FAMILIES:
        raise ParameterError(
            f"a shear does not go with family '{family}': its inverse less k y is no sum of plays. Take --family "
            f"{' or '.join(SHEARED_FAMILIES)}, or leave the shear out.",
            family=family,
        )


def sheared(records: tuple[Recording, ...], k: float) -> tuple[Recording, ...]:
    """Return the recordings with u + k y as input, which says so in its name."""
    return tuple(
        replace(r, input=r.input + k * r.output, input_name=f"{r.input_name} + {k:.4g} {r.output_name}")
        for r in records
    )
