"""Parts of a model that figures and tables show, and how far its inverse is from what was applied."""

from __future__ import annotations

import numpy as np

from dehyst.identification.fit import Fit


def inverse_miss(fit: Fit) -> tuple[float, float]:
    """Return RMS and largest difference of the input asked for and the input applied.

    Over held-out samples, or over the fitted ones if none were held out. [input]
    """
    chosen = fit.train_masks if fit.test is None else fit.test_masks
    miss = np.concatenate(
        [
            (demanded - recording.input)[mask]
            for recording, demanded, mask in zip(fit.recordings, fit.inverse_predictions, chosen, strict=True)
        ]
    )
    return float(np.sqrt(np.mean(miss**2))), float(np.max(np.abs(miss)))
