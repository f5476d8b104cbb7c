"""A muscle model as the muscle of the simulated arm.

The plant's muscle pulls with F = F_map(p, kappa) - F_hysteresis - F_creep - F_viscous, at least 0. What
:class:`MuscleMechanism` gives as hysteresis is the plant's map less the model's force, so that map and hysteresis
together are the model. Creep and viscous friction of the plant stay unless they are switched off in its parameters.
"""

from __future__ import annotations

from dehyst.muscles.arithmetic import FLOATS
from dehyst.muscles.base import MuscleModel
from dehyst.muscles.maker import Maker


class MuscleMechanism:
    """A muscle model in place of the plant's muscle: a `dehyst.plant.mechanisms.Mechanism`.

    Parameters
    ----------
    model
        The muscle.
    plant_map
        Static map of the plant's muscle, which is taken off; None for that of a DMSP-40 by the maker's tool.

    Notes
    -----
    The plant scales its map by the tolerance of each muscle: set ``tolerance.force`` to 0 for the model alone.

    Examples
    --------
    >>> from dehyst.muscles import muscle
    >>> mechanism = MuscleMechanism(muscle("sarosi"))
    >>> mechanism.reset(0.1)
    >>> plant, model = Maker(), muscle("sarosi")
    >>> force = float(plant.static_force(0.1, 3e5)) - mechanism.force(0.1, 3e5, 5e-4)
    >>> round(force - float(model.static_force(0.1, 3e5)), 9)
    0.0
    """

    def __init__(self, model: MuscleModel, plant_map: MuscleModel | None = None) -> None:
        self._step = model.stepper(0.0)
        self._map = (plant_map or Maker())._static

    def reset(self, contraction: float) -> None:
        """Forget everything; the muscle rests at this contraction."""
        self._step.reset(contraction)

    def force(self, contraction: float, pressure: float, period: float) -> float:
        """Return the plant's map less the model's force after moving there within a period [s]. [N]"""
        return float(self._map(contraction, pressure, FLOATS)) - self._step(contraction, pressure, period)
