"""Estimates the tracking error of a compensator from a log: its input drives the other candidates' forward models."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from dehyst.arrays import Array, Mask
from dehyst.data.recording import Recording
from dehyst.errors import DehystError
from dehyst.identification.families import STATIC
from dehyst.identification.fit import Fit, Option

MOST_SAMPLES = 20_000  # of a recording; of longer ones every second, third, ... sample


def tracking_errors(
    models: Sequence[Any], rivals: Sequence[bool], records: Sequence[Recording], masks: Sequence[Mask]
) -> tuple[float, ...]:
    r"""Predict the error of open-loop tracking with the inverse of each model, percent of the output's range.

    .. math::

        e_i^2 = \operatorname{mean}_{j \ne i} \operatorname{var}_k \big(F_j[u_i]_k - F_j[x]_k\big),
        \qquad u_i = F_i^{-1}[y]

    with x and y as logged, over the samples k of a mask. An error of the input counts as far as it moves the output:
    where a backlash lets the output stand still, it does not. What a forward model F_j gets wrong itself drops out of
    the difference, and an offset, which any integrator removes, is left out.

    Parameters
    ----------
    models
        Forward models with ``inverse()`` and ``simulate(x, time)``.
    rivals
        Which of them others are played on: those with a memory.
    records
        The log; demands are clipped to the range of its input.
    masks
        Samples that count, (T,), of each recording: those held out.

    Returns
    -------
    errors : tuple of float
        One of each model, percent of the output's range; NaN without an inverse, or without a rival.
    """
    squares: list[list[float]] = [[] for _ in models]
    for record, mask in zip(records, masks, strict=True):
        every = max(1, -(-len(record) // MOST_SAMPLES))
        part = slice(None, None, every)
        x, y, time = record.input[part], record.output[part], None if record.time is None else record.time[part]
        kept = mask[part]
        if not kept.any():
            continue
        demands = [_demand(model, x, y, time, every) for model in models]
        for j, plant in enumerate(models):
            if not rivals[j]:
                continue
            applied = plant.simulate(x, time)
            for i, demand in enumerate(demands):
                if i != j:
                    moved = np.nan if demand is None else np.var((plant.simulate(demand, time) - applied)[kept])
                    squares[i].append(float(moved))
    span = np.ptp(np.concatenate([record.output for record in records]))
    return tuple(float(100.0 * np.sqrt(np.mean(own)) / span) if own else float("nan") for own in squares)


def _demand(model: Any, x: Array, y: Array, time: Array | None, every: int) -> Array | None:
    try:
        return np.asarray(np.clip(model.ahead(model.inverse().simulate(y, time), every), x.min(), x.max()))
    except DehystError:  # no inverse
        return None


def with_table(fit: Fit, *others: Fit) -> Fit:
    """Return a fit with the table of it, others, and the curve; tracking is not known of a loop that was sheared."""
    fits = (fit, *others)
    models, options = [each.model for each in fits], [_option_of(each, each is fit) for each in fits]
    if all(each.family != STATIC for each in fits):
        curve = fit.static_test or fit.static_train
        models.append(fit.static)
        options.append(Option(STATIC, "forward", curve.rmse_percent, fit.curve_input.rms_percent, None, True, False))
    if fit.model.shear is None:
        remembers = [row.family != STATIC and not model.needs for row, model in zip(options, models, strict=True)]
        tracked = tracking_errors(models, remembers, fit.recordings, fit.test_masks if fit.test else fit.train_masks)
        options = [
            replace(row, tracking_percent=None if np.isnan(error) else error)
            for row, error in zip(options, tracked, strict=True)
        ]
    return replace(fit, table=tuple(options))


def _option_of(fit: Fit, chosen: bool) -> Option:
    asked, exportable = fit.input_error.rms_percent, not fit.model.no_export
    return Option(fit.family, fit.direction, fit.output_error.rmse_percent, asked, None, exportable, chosen)
