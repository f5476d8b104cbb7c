"""The mechanism of the example log, driven by pressure: what a compensator meets on the simulated joint.

`dehyst.io._example` computes the pressure that an angle takes. Here the same equations (elastic backbone,
40 friction elements, three creep branches) are solved for the angle that a pressure gives, without sensor noise.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from dehyst.io import _example as law

Array = npt.NDArray[np.float64]

TOLERANCE = 1e-9  # of the pressure balance [bar]
PROBE = 1e-4  # angle over which its slope is taken [deg]


class Joint:
    """Pressure difference [bar] -> angle [deg], one sample a call, at a fixed sampling time."""

    def __init__(self, step: float) -> None:
        self.angle = 0.0
        self._slip = np.geomspace(*law.SLIP_DISTANCE, law.ELEMENTS)
        self._elongation = np.zeros(law.ELEMENTS)
        self._size = np.array(law.CREEP) / 30.0
        self._decay = np.exp(-step / np.array(law.CREEP_TIME))
        self._late = np.zeros(self._decay.size)

    def __call__(self, pressure: float) -> float:
        """Advance by one sample and return the angle at which the pressures balance."""
        angle = self.angle
        for _ in range(60):
            miss = self._pressure(angle) - pressure
            if abs(miss) < TOLERANCE:
                break
            slope = (self._pressure(angle + PROBE) - pressure - miss) / PROBE
            angle -= miss / slope
        else:
            raise RuntimeError(f"no angle balances {pressure} bar")
        self._elongation = self._stretched(angle)
        self._late += (1.0 - self._decay) * (angle - self._late)
        self.angle = angle
        return angle

    def _backbone(self, angle: float) -> float:
        return angle / law.COMPLIANCE * (1.0 + (angle / law.STIFFENING) ** 2)

    def _stretched(self, angle: float) -> Array:
        backbone = self._backbone(angle)
        limit = self._slip * (1.0 + 0.15 * abs(backbone) / 3.0 + 0.10 * backbone / 3.0)
        return np.clip(self._elongation + (angle - self.angle), -limit, limit)

    def _pressure(self, angle: float) -> float:
        held = law.FRICTION * float(np.mean(self._stretched(angle) / self._slip))
        late = self._late + (1.0 - self._decay) * (angle - self._late)
        return self._backbone(angle) + held + float(self._size @ (angle - late))


def respond(pressure: Array, step: float) -> Array:
    """Angle of a joint at rest that is driven by a pressure signal, (T,). [deg]"""
    joint = Joint(step)
    return np.array([joint(p) for p in pressure.tolist()])
