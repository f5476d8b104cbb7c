"""Estimates the tracking error of a compensator from a log: its input drives the other candidates' forward models."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from dehyst.arrays import Array, Mask
from dehyst.data import Recording
from dehyst.errors import DehystError
from dehyst.identification._data import outputs_of
from dehyst.identification._families import STATIC
from dehyst.identification._fit import Fit, Option

MOST_SAMPLES = 20_000  # of a recording; of longer ones every second, third, ... sample


def tracking_errors(
    models: Sequence[Any],
    rivals: Sequence[bool],
    records: Sequence[Recording],
    masks: Sequence[Mask],
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
        time = record.time
        if time is not None:
            time = time[part]
        counted = mask[part]
        if not counted.any():
            continue
        demands = []
        for model in models:
            demands.append(_demand(model, record, part))
        for j, plant in enumerate(models):
            if not rivals[j]:
                continue
            signals = record.signals(plant.needs, part)
            applied = plant.simulate(record.input[part], time, **signals)
            for i, demand in enumerate(demands):
                # No model is its own judge.
                if i == j:
                    continue
                moved = float("nan")
                if demand is not None:
                    answer = plant.simulate(demand, time, **signals)
                    moved = float(np.var((answer - applied)[counted]))
                squares[i].append(moved)
    span = np.ptp(np.concatenate(outputs_of(records)))
    errors = []
    for model_squares in squares:
        error = float("nan")
        if model_squares:
            error = float(100.0 * np.sqrt(np.mean(model_squares)) / span)
        errors.append(error)
    return tuple(errors)


def _demand(model: Any, record: Recording, part: slice) -> Array | None:
    """What the inverse asks for along the measured output, within the input that was applied."""
    x, time = record.input[part], record.time
    if time is not None:
        time = time[part]
    try:
        demand = model.inverse().simulate(
            record.output[part], time, **record.signals(model.needs, part)
        )
    except DehystError:  # no inverse
        return None
    return np.asarray(np.clip(model.ahead(demand, time), x.min(), x.max()))


def with_table(fit: Fit, *rivals: Fit) -> Fit:
    """Return a fit with a table of itself, its rivals and the curve; for a sheared loop the table has no tracking."""
    models = []
    options = []
    for row in (fit, *rivals):
        models.append(row.model)
        options.append(_option_of(row, row is fit))
    if STATIC not in [option.family for option in options]:
        curve = fit.static_test or fit.static_train
        models.append(fit.static)
        options.append(
            Option(
                STATIC,
                "forward",
                curve.rmse_percent,
                fit.curve_input.rms_percent,
                None,
                True,
                False,
            )
        )
    if fit.model.shear is not None:
        return replace(fit, table=tuple(options))
    # An inverse is tried on models that remember.
    remembers = [option.family != STATIC for option in options]
    masks = fit.train_masks
    if fit.test:
        masks = fit.test_masks
    errors = tracking_errors(models, remembers, fit.recordings, masks)
    for k, error in enumerate(errors):
        if not np.isnan(error):
            options[k] = replace(options[k], tracking_percent=error)
    return replace(fit, table=tuple(options))


def _option_of(fit: Fit, chosen: bool) -> Option:
    asked, exportable = fit.input_error.rms_percent, not fit.model.no_export
    return Option(
        fit.family, fit.direction, fit.output_error.rmse_percent, asked, None, exportable, chosen
    )
