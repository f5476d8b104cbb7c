"""A reproduction as plain values: means over the seeds, and what ``--json`` writes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from dehyst.experiments.results import PlantResult, Reproduction

FORMAT = "dehyst-reproduction"


def mean_figures(result: PlantResult) -> dict[str, Any]:
    """Return the figures of a plant, each the mean over its seeds; None where no seed gave a number."""
    mean: dict[str, Any] = _mean(list(result.figures.values()))
    return mean


def as_json(result: Reproduction) -> dict[str, Any]:
    """Return what ``dehyst reproduce --json`` writes.

    ``plants``: plant -> ``joints`` and ``tool`` (means over the seeds) and ``seeds`` (the same for each);
    ``real_time_factor``: the slowest plant's; ``settings``, ``studies``.
    """
    plants = {
        name: {**mean_figures(plant), "seeds": {str(seed): _plain(one) for seed, one in plant.figures.items()}}
        for name, plant in result.plants.items()
    }
    return {
        "format": FORMAT,
        "plants": plants,
        "real_time_factor": min(plant.real_time_factor for plant in result.plants.values()),
        "compensator": result.compensator,
        "compensators": list(result.compensators),
        "settings": _plain(result.settings),
        "studies": _plain(result.studies),
    }


def _mean(values: Sequence[Any]) -> Any:
    given = [value for value in values if value is not None]
    if not given:
        return None
    first = given[0]
    if isinstance(first, Mapping):
        keys = dict.fromkeys(key for value in given for key in value)  # a reason may be one seed's alone
        return {key: _mean([value.get(key) for value in given]) for key in keys}
    if isinstance(first, bool | np.bool_):
        return bool(all(given))
    numbers = [float(v) for v in given if isinstance(v, int | float | np.number) and np.isfinite(float(v))]
    if numbers:
        mean = float(np.mean(numbers))
        return round(mean) if all(isinstance(v, int) for v in given) and mean == round(mean) else mean
    return _plain(first)


def _plain(value: Any) -> Any:
    """Values as JSON knows them: no arrays, no NaN."""
    if isinstance(value, Mapping):
        return {str(key): _plain(one) for key, one in value.items()}
    if isinstance(value, np.ndarray | list | tuple):
        return [_plain(one) for one in value]
    if isinstance(value, bool | np.bool_):
        return bool(value)
    if isinstance(value, np.integer):
        return int(value)
    if isinstance(value, float | np.floating):
        return float(value) if np.isfinite(value) else None
    return value
