"""A relation from one signal to another, whatever model it comes from: along a path, sample by sample, its work."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np

from dehyst.errors import ParameterError
from dehyst.families.base import InverseLoop, LoopModel, LoopStepper
from dehyst.models import HysteresisModel
from dehyst.models.arrays import Array

Relation: TypeAlias = LoopModel | InverseLoop | HysteresisModel


def check_relation(relation: object, wanted: str) -> Relation:
    """Return the relation.

    Raises
    ------
    ParameterError
        If it is no model.
    """
    if isinstance(relation, LoopModel | InverseLoop | HysteresisModel):
        return relation
    raise ParameterError(
        f"a {type(relation).__name__} is no model. Pass {wanted}, for instance dehyst.families.example('dahl'), or "
        f"what dehyst.identify_family(log, NAME).model is.",
        type=type(relation).__name__,
    )


def depends_on_rate(relation: Relation) -> bool:
    """Whether time stamps are needed."""
    return not isinstance(relation, HysteresisModel) and relation.rate_dependent


def along_path(relation: Relation, x: Array, time: Array | None) -> Array:
    """Return the output (T,) along inputs (T,), from the start state on."""
    if isinstance(relation, HysteresisModel):
        return relation.simulate(x)
    return relation.simulate(x, time)


class Stepping:
    """A relation as a function of one sample; `reset` begins anew.

    Examples
    --------
    >>> from dehyst.families import example
    >>> step = Stepping(example("dahl"))
    >>> step(0.0, 0.001), step.output
    (0.0, 0.0)
    """

    def __init__(self, relation: Relation) -> None:
        self._timed = not isinstance(relation, HysteresisModel)
        self._step = relation.stepper()

    def reset(self) -> None:
        """Forget everything; the next sample is the first."""
        self._step.reset()

    def __call__(self, x: float, period: float) -> float:
        """Return the output for the next input, `period` [s] after the one before."""
        return self._step(x, period) if isinstance(self._step, LoopStepper) else float(self._step(x))

    @property
    def output(self) -> float:
        """The last output."""
        return float(self._step.output)


def work(relation: Relation, low: float, high: float, seconds: float = 10.0, samples: int = 400) -> tuple[float, float]:
    """Return the work that a closed loop between two inputs takes up, and its size: range of input times output.

    The third of three equal loops counts: those before bring a relation that forgets to its closed loop. The work is
    positive where the output leads, as friction does, and negative where it lags.

    Examples
    --------
    >>> from dehyst import StopOperatorModel
    >>> taken, _ = work(StopOperatorModel([0.0, 0.5], [0.0, 2.0], slope=0.0), -2.0, 2.0)
    >>> round(taken, 3)  # of a slider of force 1 and stiffness 2: 4 (2 - 0.5)
    6.0
    """
    turns = np.concatenate([np.linspace(high, low, samples + 1)[:-1], np.linspace(low, high, samples + 1)[:-1]])
    x = np.append(np.tile(turns, 3), high)
    y = along_path(relation, x, np.arange(x.size) * seconds / (2 * samples) if depends_on_rate(relation) else None)
    last = slice(4 * samples, None)
    area = float(np.sum(0.5 * (y[last][1:] + y[last][:-1]) * np.diff(x[last])))
    return area, float((high - low) * np.ptp(y[last]))
