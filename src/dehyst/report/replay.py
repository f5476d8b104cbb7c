"""Run an identified model or its inverse over a recording, with the memory the identification assumed."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from dehyst.errors import DehystError
from dehyst.identification.fit import Fit
from dehyst.identification.memory import INITIAL_STATES, state_before
from dehyst.models import HysteresisModel, ModifiedPrandtlIshlinskii, MonotoneMap, PrandtlIshlinskii, StopOperatorModel
from dehyst.recording import Recording

Array = npt.NDArray[np.float64]


def play_core(model: HysteresisModel) -> PrandtlIshlinskii | None:
    """Return the sum of plays inside a model, or None if it has no memory."""
    if isinstance(model, PrandtlIshlinskii):
        return model
    if isinstance(model, ModifiedPrandtlIshlinskii):
        return model.hysteresis
    if isinstance(model, StopOperatorModel):
        return model.as_play()
    return None


def output_map(model: HysteresisModel) -> MonotoneMap | None:
    """Return the map behind the operator of a modified model, or None."""
    return model.after if isinstance(model, ModifiedPrandtlIshlinskii) else None


def at_start(fit: Fit, recording: Recording, piece: slice) -> HysteresisModel:
    """Return the model of a fit with the memory that was assumed before a piece of a recording."""
    core = play_core(fit.model)
    if core is None or fit.certificate.initial_state not in INITIAL_STATES:
        return fit.model
    reach = _training_reach(fit, core.center)
    first = float(recording.input[piece.start]) - core.center
    return fit.model.with_state(state_before(fit.certificate.initial_state, core.thresholds, first, -reach, reach))


def _training_reach(fit: Fit, center: float) -> float:
    """Largest distance of the fitted input from the model's centre. [input]"""
    farthest = [
        float(np.max(np.abs(recording.input[mask] - center)))
        for recording, mask in zip(fit.recordings, fit.train_masks, strict=True)
        if mask.any()
    ]
    return max(farthest, default=0.0)


def inverse_over(fit: Fit, recording: Recording) -> Array | None:
    """Return the input (T,) that the inverse asks for to reach the measured output, or None without an inverse."""
    demanded = np.empty(len(recording))
    try:
        for piece in recording.pieces:
            demanded[piece] = at_start(fit, recording, piece).inverse().simulate(recording.output[piece])
    except DehystError:
        return None
    return demanded


def inverse_miss(fit: Fit) -> tuple[float, float] | None:
    """Return RMS and largest difference of the input asked for and the input applied, or None without an inverse.

    Over fitted and held-out samples. [input]
    """
    misses = []
    for recording, train, test in zip(fit.recordings, fit.train_masks, fit.test_masks, strict=True):
        demanded = inverse_over(fit, recording)
        if demanded is None:
            return None
        misses.append((demanded - recording.input)[train | test])
    miss = np.concatenate(misses)
    return (float(np.sqrt(np.mean(miss**2))), float(np.max(np.abs(miss)))) if miss.size else None
