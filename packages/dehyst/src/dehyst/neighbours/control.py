"""A model as a nonlinear discrete-time system of python-control, to simulate it in a loop with other systems."""

from __future__ import annotations

from typing import Any

import numpy as np

from dehyst.arrays import Array
from dehyst.errors import ParameterError
from dehyst.io import optional
from dehyst.models import HysteresisModel, Model


def to_control(model: Model, dt: float, *, name: str = "hysteresis") -> Any:
    """Return x_{k+1} = f(x_k, u_k), y_k = h(x_k, u_k): outputs are those of ``model.stepper(dt)``, bit for bit.

    Parameters
    ----------
    model
        Any model whose memory has a fixed size, or its ``inverse()``.
    dt
        Period of the system. [s]
    name
        Of the system; its input and output are called u and y.

    Returns
    -------
    system : control.NonlinearIOSystem
        Its state is the stepper's image behind a 1, or zeros before the first sample.

    Raises
    ------
    ParameterError
        If the memory grows with the signal (Preisach), or `dt` is no period.
    MissingExtraError
        If python-control is not installed.

    Examples
    --------
    >>> import control, numpy as np
    >>> from dehyst import PrandtlIshlinskii
    >>> model, t = PrandtlIshlinskii([0.0, 0.6], [1.0, 0.5]), 0.1 * np.arange(50)
    >>> system = to_control(model, 0.1)
    >>> y = control.input_output_response(system, t, np.sin(t)).outputs
    >>> bool(np.array_equal(y, model.simulate(np.sin(t))))
    True
    """
    control = optional(
        "control",
        "control",
        model.family,
        "making a system of",
        "step model.stepper(dt) by yourself",
    )
    if not (np.isfinite(dt) and dt > 0):
        raise ParameterError(
            f"dt = {dt} s is no period. Pass the time between two samples of the system.", dt=dt
        )
    if getattr(model, "memory_grows", False) or getattr(
        getattr(model, "of", None), "memory_grows", False
    ):
        raise ParameterError(
            f"the memory of {model.family} grows with the signal, and a state of python-control has a fixed size. Take "
            f"a family of plays or elements: dehyst.identify(recording)."
        )
    step = _stepper(model, dt)
    # A stepper knows the size of its state only after the first sample.
    step(0.0)
    size = 1 + np.asarray(step.save()).size

    def at(state: Array, u: Array) -> float:
        step.reset()
        # The first number of the state says whether a sample was seen: at first there is nothing to restore.
        if state[0]:
            step.restore(state[1:])
        return float(step(float(u[0]), dt))

    def update(t: float, state: Array, u: Array, params: Any) -> Array:
        at(state, u)
        return np.concatenate([[1.0], step.save()])

    def output(t: float, state: Array, u: Array, params: Any) -> Array:
        return np.array([at(state, u)])

    return control.nlsys(update, output, states=size, inputs=["u"], outputs=["y"], dt=dt, name=name)


def _stepper(model: Model, dt: float) -> Any:
    # The state of python-control has one size, and that of a sparse stepper grows with the signal.
    if isinstance(model, HysteresisModel):
        return model.stepper("dense")
    return model.stepper(dt)
