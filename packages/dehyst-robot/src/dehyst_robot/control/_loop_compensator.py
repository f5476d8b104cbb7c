r"""Compensator from any family: its hysteresis along the desired path, for the joint controller.

A compensator needs a relation from the desired angle to the pressure difference. There are two ways to get one:

- a model that lags, identified from the sheared pressure difference x = dp - dp_nom + k q to the angle q, inverted;
- a model that leads, identified the other way round, from q to x: it is used as it is, and needs no inverse.

The term is :math:`\Delta p = unit \cdot R[q_d] - k q_d` with that relation R.
"""

from __future__ import annotations

import numpy as np

from dehyst.arrays import Array
from dehyst.errors import ParameterError
from dehyst.families import kit as families_kit
from dehyst.models import Model
from dehyst.models import kit as models_kit
from dehyst_robot.control._compensator import refuse_second_shear
from dehyst_robot.control._policy import POLICY


class LoopCompensator:
    """A compensator, as `dehyst_robot.control.Compensator` says, from a model of any family.

    Parameters
    ----------
    model
        Desired angle [rad] -> sheared pressure difference: ``fit.model.inverse()`` of a model from pressure to angle,
        or a model from angle to pressure. It begins in its model's start state.
    shear
        k that was added before the fit. [Pa/rad]
    unit
        Size of one unit of the model's output, 1e5 for bar. [Pa]
    period
        Time between two calls of `step`, for models that depend on rate; `over` gets the time. [s]

    Raises
    ------
    ParameterError
        If `model` is no model, its loops lag the angle, a number is not finite, or k would be subtracted twice.

    Examples
    --------
    >>> import numpy as np
    >>> from dehyst_robot.control import along
    >>> from dehyst.families import Dahl
    >>> friction = Dahl(curve=[0.0], lengths=[0.1], weights=[2.0])  # 0.2 bar of dry friction over 0.1 rad
    >>> along(LoopCompensator(friction), [0.0, 0.5, 0.5]).round(-2).tolist()
    [0.0, 19900.0, 19900.0]
    """

    def __init__(
        self, model: Model, shear: float = 0.0, unit: float = 1e5, period: float | None = None
    ) -> None:
        self.model = models_kit.require_model(
            model, "model.inverse() of a model from pressure to angle"
        )
        self.shear = models_kit.parameter_number(shear, "shear")
        self.unit = models_kit.parameter_number(unit, "unit")
        self.period = period
        if period is not None:
            self.period = models_kit.parameter_number(period, "period")
        _refuse_lag(self.model)
        refuse_second_shear(self.model, self.shear)
        self._step = self.model.stepper()
        self._angle = 0.0

    def reset(self, angle: float) -> None:
        """Return to the model's start state, then to the angle."""
        self._step.reset()
        self._angle = angle
        self._step(angle, 0.0)

    def step(self, angle: float, velocity: float) -> float:
        """Return the term for the next desired angle. [Pa]"""
        if self.period is None and self.model.rate_dependent:
            raise ParameterError(
                "this model depends on rate and does not know how far apart the calls of step() are. Say so: "
                "LoopCompensator(model, ..., period=0.0005), in seconds."
            )
        if np.isfinite(angle):  # else the last term is held
            self._angle = angle
            self._step(angle, self.period or 0.0)
        return self.output()

    def output(self) -> float:
        """Return the present term. [Pa]"""
        return float(self.unit * self._step.output - self.shear * self._angle)

    def over(self, angle: Array, velocity: Array, time: Array) -> Array:
        """Return the term along a whole desired path, (T,), from the start state on: the same as steps, in one go.

        Parameters
        ----------
        angle, velocity, time
            (T,) each. [rad, rad/s, s]
        """
        return np.asarray(self.unit * self.model.simulate(angle, time) - self.shear * angle)


def _refuse_lag(model: Model) -> None:
    """Refuse a model that lags its input: it was not inverted and would double the hysteresis."""
    work, size = families_kit.work(model, *model.ends)
    if work < -POLICY.lagging * size:
        raise ParameterError(
            f"this {type(model).__name__} lags the angle (it gives back {-100 * work / max(size, 1e-300):.1f} % "
            f"of its box): as a compensator it would double the hysteresis. If it was identified from pressure to "
            f"angle, pass model.inverse(); else identify it from angle to pressure."
        )
