"""Any family as the true hysteresis of a simulated muscle."""

from __future__ import annotations

import numpy as np

from dehyst.errors import ParameterError
from dehyst.families import kit as families_kit
from dehyst.models import Model
from dehyst.models import kit as models_kit
from dehyst_robot.control._policy import POLICY

# Contractions between which a mechanism may not give work: almost all that a muscle can do, a part, and a small loop.
STROKES = ((0.0, 0.22), (0.08, 0.14), (0.105, 0.115))


class ModelMechanism:
    """A hysteresis mechanism, as `dehyst_robot.arm.Mechanism` says, from a model of any family.

        force = size g(p) model[(contraction - center)/strain],   g(p) = 1 - pressure_share + pressure_share p/3 bar

    The model's output must lead its input, as a force over a displacement does: a model that lags, as that of an
    actuator's position, gives a mechanism when it is inverted. Whatever the model has besides loops, a slope or a
    curve, adds to the muscle's stiffness.

    Parameters
    ----------
    model
        A model of any family, or the inverse of one that lags. Input and output are its own.
    size
        Force for one unit of the model's output, at the reference pressure. [N]
    strain
        Contraction for one unit of the model's input.
    center
        Contraction at which the model's input is 0; matters to families whose loops differ from place to place.
    pressure_share
        Share of the force that is proportional to the gauge pressure.
    reference_pressure
        At which g is 1. [Pa]

    Raises
    ------
    ParameterError
        If `model` is no model, gives work in a closed loop, or a number is not finite or not in its range.

    Examples
    --------
    >>> from dehyst.families import Dahl
    >>> mechanism = ModelMechanism(Dahl(curve=[0.0], lengths=[1.0], weights=[1.0]), size=80.0, strain=0.0125)
    >>> mechanism.reset(0.1)
    >>> round(mechanism.force(0.1125, 3e5, 0.0005), 2)  # 80 N (1 - exp(-1))
    50.57
    """

    def __init__(
        self,
        model: Model,
        size: float,
        strain: float,
        *,
        center: float = 0.0,
        pressure_share: float = 0.7,
        reference_pressure: float = 3e5,
    ) -> None:
        self.model = models_kit.require_model(model, "a model whose output leads")
        for name, value in (
            ("size", size),
            ("strain", strain),
            ("reference_pressure", reference_pressure),
        ):
            if not models_kit.parameter_number(value, name) > 0.0:
                raise ParameterError(f"{name} = {value:g} must be above 0.", **{name: value})
        if not 0.0 <= models_kit.parameter_number(pressure_share, "pressure_share") <= 1.0:
            raise ParameterError(
                f"pressure_share = {pressure_share:g} lies outside 0 .. 1: friction would pull at some pressure. "
                f"0.7 is usual.",
                pressure_share=pressure_share,
            )
        self.size = size
        self.strain = strain
        self.center = models_kit.parameter_number(center, "center")
        # g(p) = constant + slope p
        self._constant = 1.0 - pressure_share
        self._slope = pressure_share / reference_pressure
        self._refuse_work()
        self.reset(self.center)

    def reset(self, contraction: float) -> None:
        """Forget everything; the muscle rests at this contraction."""
        x = (contraction - self.center) / self.strain
        # The mechanism has no memory but that of the present contraction.
        self._step = self.model.at_rest(x).stepper()
        self._step(x, 0.0)

    def force(self, contraction: float, pressure: float, period: float) -> float:
        """Return the force that opposes contraction. [N]"""
        size = self.size * (self._constant + self._slope * pressure)
        return float(size * self._step((contraction - self.center) / self.strain, period))

    def _refuse_work(self) -> None:
        for stroke in STROKES:
            low = (stroke[0] - self.center) / self.strain
            high = (stroke[1] - self.center) / self.strain
            work, size = families_kit.work(self.model, low, high)
            if not np.isfinite(work):
                raise ParameterError(
                    f"the model does not answer with finite numbers between contractions {stroke[0]:g} and "
                    f"{stroke[1]:g}. Make strain larger: it is the contraction of one unit of the model's input."
                )
            if work < -POLICY.giving * size:
                raise ParameterError(
                    f"this {type(self.model).__name__} gives {-self.size * self.strain * work:.3g} Nm of work per "
                    f"metre of muscle in a loop between contractions {stroke[0]:g} and {stroke[1]:g}: its output lags, "
                    f"and a muscle with it would be a motor. Pass model.inverse() of a model that lags, or positive "
                    f"weights.",
                    stroke=stroke,
                )
