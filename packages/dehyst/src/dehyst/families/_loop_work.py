"""Area of a closed loop of a model; its sign tells whether the output leads or lags."""

from __future__ import annotations

import numpy as np

from dehyst.models import Model


def work(
    model: Model, low: float, high: float, seconds: float = 10.0, samples: int = 400
) -> tuple[float, float]:
    """Return the work that a closed loop between two inputs takes up, and its size: range of input times output.

    The third of three equal loops counts: those before bring a model that forgets to its closed loop. The work is
    positive where the output leads, as friction does, and negative where it lags.

    Examples
    --------
    >>> from dehyst import StopOperatorModel
    >>> area, _ = work(StopOperatorModel([0.0, 0.5], [0.0, 2.0], slope=0.0), -2.0, 2.0)
    >>> round(area, 3)  # of a slider of force 1 and stiffness 2: 4 (2 - 0.5)
    6.0
    """
    falling = np.linspace(high, low, samples + 1)[:-1]
    rising = np.linspace(low, high, samples + 1)[:-1]
    turns = np.concatenate([falling, rising])
    x = np.append(np.tile(turns, 3), high)
    y = model.simulate(x, np.arange(x.size) * seconds / (2 * samples))
    # The area by the rule of trapezoids, along the last of the three loops.
    last = slice(4 * samples, None)
    area = float(np.sum(0.5 * (y[last][1:] + y[last][:-1]) * np.diff(x[last])))
    return area, float((high - low) * np.ptp(y[last]))
