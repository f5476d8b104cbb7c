"""identify() of plays: settings checked, then plays, a bounded gain, a sheared loop or a direct inverse."""

from __future__ import annotations

from collections.abc import Sequence

import numpy.typing as npt

from dehyst.data.recording import Recording, require_recordings, takes_recordings
from dehyst.errors import ParameterError
from dehyst.identification.direct import identify_direct
from dehyst.identification.fit import Fit
from dehyst.identification.procedure import DIRECT, call_of, solve_in_memory
from dehyst.identification.settings import (
    PAPER_OPERATORS,
    check_recordings,
    check_settings,
    check_weights,
    eps_of_call,
    refuse_both,
)
from dehyst.identification.shear import identify_sheared, identify_within
from dehyst.identification.split import split_recordings


@takes_recordings
def identify(
    recordings: Recording | Sequence[Recording],
    family: str = "auto",
    *,
    n: int | str = PAPER_OPERATORS,
    eps: float | str | None = None,
    thresholds: npt.ArrayLike | None = None,
    initial_state: str = "auto",
    train_fraction: float | None = None,
    weights: npt.ArrayLike | Sequence[npt.ArrayLike] | None = None,
    shear: float | str | None = None,
    max_inverse_gain: float | None = None,
) -> Fit:
    r"""Identify a hysteresis model from one recording or several.

    The paper's problem, with the input centred and an offset c identified along:

    .. math::

        \min_{w, c} \sum_k \Big(y_k - c - \sum_i w_i z_i[k]\Big)^2
        \quad \text{subject to} \quad w_1 \ge \varepsilon, \; w_i \ge 0

    Parameters
    ----------
    recordings
        One recording or a list of them; all are fitted together.
    family
        "pi" (Prandtl-Ishlinskii, the paper's), "pi-cumulative" (positive partial sums instead of weights),
        "modified-pi" (with an output map, for loops that saturate or are asymmetric), "stop" (for clockwise loops),
        "static" (a curve without memory), or "auto": the one with the least error on loops held out within the
        training part, the simpler one within 2 %, and the curve where none is 5 % better. "direct-inverse" is
        `identify_direct` with its usual settings.
    n
        Number of operators, at thresholds r_i = (i - 1)/n max|x|; ((i - 1)/n)^2 max|x| for "stop", whose
        loops are steep right after a reversal. Memory grows with n^2: 10 000 operators take several gigabytes.
        "auto" takes the fewest operators, on a grid with exponent 1 or 2, that are within 2 % of the least error on
        held-out loops.
    eps
        Smallest slope right after a reversal, whose inverse bounds that of the compensator. For the family "pi" the
        paper's bound w_1 >= eps, by default its 0.001 [output/input]; for all others, and for family "auto", relative
        to output range over input range. "auto", the default of these, begins with 0.001 and, where the inverse would
        amplify by more than 20 times the ratio of the ranges, raises it (relative, for "pi" too) until it does not, or
        as far as the error of the fit grows by no more than 5 %.
    thresholds
        Thresholds to use instead of the grid, (n,), increasing from 0. [input]
    initial_state
        Memory before the first sample: "zero" (after decaying oscillation; the paper), "rest" (never moved),
        "rising" or "falling" (in the middle of a periodic motion), "unknown" (samples before both extremes were
        visited do not count), "origin" (came from rest at input 0), or "auto": by held-out error; for the family
        "pi" it is "zero" unless another start halves the error.
    train_fraction
        Share of each recording that is fitted; the rest is the test. 1 fits everything and tests nothing. None, the
        default, fits the first half of one recording or two; of three or more, whole ones are held out, about half of
        the samples, such that the input of these stays within the range that is fitted.
    weights
        How much each sample counts, (T,), 0 or more, or one such array for each recording: squared errors are
        multiplied by it, in the fit and in the scores. 2 is the same as a sample that was logged twice; 0 leaves
        a sample out, except that its input is remembered. By default all count alike.
    shear
        k: the loop is fitted around the diagonal, as :math:`y = H[u + k y]`, and the model is the sheared one, whose
        inverse subtracts k y again; for the families "pi" (which "auto" then stands for) and "pi-cumulative". "auto"
        chooses k by the held-out error of the inverse (`choose_shear`). None fits the loop as it was logged.
        [input/output]
    max_inverse_gain
        G, largest slope of the inverse right after a reversal, instead of eps: a wanted output that moves by one step
        of its sensor changes the input asked for by at most G times that step. [input/output]

    Returns
    -------
    fit : Fit
        Model, scores, certificate and findings.

    Raises
    ------
    ParameterError
        If a setting lies outside what its formula allows.
    ExcitationError
        If the input or output does not move, or memory is unknown throughout the training part.
    IdentificationError
        If the quadratic program is not solved.

    References
    ----------
    M. Kastner, H. Gattringer, R. Naderer, "Evaluation of a Joint Hysteresis Model in a Robot Actuated by Pneumatic
    Muscles", ICINCO 2012. K. Kuhnen, European Journal of Control 9(4), 2003.

    Examples
    --------
    >>> import numpy as np, dehyst
    >>> x = 2 * np.sin(np.linspace(0, 30, 600)) * np.linspace(1, 0.2, 600)
    >>> y = dehyst.PrandtlIshlinskii([0.0, 0.5, 1.0], [1.0, 0.5, 0.25]).simulate(x)
    >>> rec = dehyst.Recording(input=x, output=y)
    >>> fit = dehyst.identify(rec, family="pi", thresholds=[0.0, 0.5, 1.0])
    >>> fit.model.weights.round(9).tolist()
    [1.0, 0.5, 0.25]
    """
    recordings = require_recordings(recordings)  # before the family: identify(u, y) makes an array of it
    if str(family) == DIRECT:
        given_here = {
            "n": n != PAPER_OPERATORS, "eps": eps is not None, "thresholds": thresholds is not None,
            "weights": weights is not None, "shear": shear is not None,
            "max_inverse_gain": max_inverse_gain is not None,
        }  # fmt: skip
        return _identify_direct(recordings, initial_state, train_fraction, given_here)
    records = check_recordings(recordings)
    begun, chosen = eps_of_call(family, eps)
    given = check_settings(family, n, begun, thresholds, initial_state)
    sample_weights = check_weights(weights, records)
    split = split_recordings(records, train_fraction, sample_weights)
    call = call_of(family, n, (begun, chosen), given, initial_state, split, sample_weights is not None)
    if eps is not None:
        refuse_both(eps, shear, max_inverse_gain)
    if shear is None and max_inverse_gain is None:
        return solve_in_memory(call, records, sample_weights)
    if shear is not None:
        return identify_sheared(call, records, sample_weights, shear, max_inverse_gain)
    return identify_within(call, records, sample_weights, 0.0 if max_inverse_gain is None else max_inverse_gain)


def _identify_direct(
    recordings: Recording | Sequence[Recording],
    initial_state: str,
    train_fraction: float | None,
    given: dict[str, bool],
) -> Fit:
    set_here = [name for name, there in given.items() if there]
    if set_here:
        raise ParameterError(
            f"{' and '.join(set_here)} {'says' if len(set_here) == 1 else 'say'} nothing to the family "
            f"'direct-inverse': its radii, path lengths and slopes are its own and every sample counts alike. Leave "
            f"{'it' if len(set_here) == 1 else 'them'} out; creep and schedules are settings of "
            "dehyst.identify_direct.",
            settings=set_here,
        )
    return identify_direct(recordings, initial_state=initial_state, train_fraction=train_fraction)
