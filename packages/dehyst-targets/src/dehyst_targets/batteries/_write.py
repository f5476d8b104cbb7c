"""Writes the parameters of an open-circuit voltage with hysteresis as a Python file that PyBaMM reads."""

from __future__ import annotations

from dehyst.arrays import Array
from dehyst.errors import ParameterError
from dehyst_targets.batteries._fit import OcvFit

ELECTRODES = ("negative", "positive")


def pybamm_file(fit: OcvFit, electrode: str, state: float, about: str = "") -> str:
    """Return a Python file whose ``get_parameter_values()`` updates a parameter set of PyBaMM 25.10 or newer.

    Parameters
    ----------
    fit
        Of `fit_ocv`.
    electrode
        "negative" or "positive".
    state
        State h at the start: 1 after delithiation, -1 after lithiation.
    about
        A line on where the numbers come from.

    Raises
    ------
    ParameterError
        If the electrode is none, or the decay rates are not known.

    Examples
    --------
    >>> import numpy as np
    >>> ends = np.array([0.0, 1.0])
    >>> fit = OcvFit(ends, 0.5 - 0.4 * ends, 0.6 - 0.4 * ends, (40.0, 30.0), 0.0, 0.0, 0.0)
    >>> "lithiation hysteresis decay rate" in pybamm_file(fit, "negative", -1.0)
    True
    """
    if electrode not in ELECTRODES:
        raise ParameterError(f"--electrode {electrode:.40} is none. Type negative or positive.")
    if fit.rates is None:
        raise ParameterError(
            "the decay rate is not known, and PyBaMM asks for it. Type it: --decay 50, or log partial cycles."
        )
    name = electrode.capitalize()
    return f'''"""Open-circuit potential with hysteresis for PyBaMM 25.10 or newer. {about}

    values = pybamm.ParameterValues("Chen2020")
    values.update(get_parameter_values(), check_already_exists=False)

The model option "open-circuit potential" is then "one-state hysteresis" for the {electrode} electrode.
"""

import numpy as np
import pybamm

X = np.array({_list(fit.x)})
LITHIATION = np.array({_list(fit.lithiation)})  # V
DELITHIATION = np.array({_list(fit.delithiation)})  # V


def lithiation_ocp(sto):
    return pybamm.Interpolant(X, LITHIATION, sto, name="lithiation OCP")


def delithiation_ocp(sto):
    return pybamm.Interpolant(X, DELITHIATION, sto, name="delithiation OCP")


def mean_ocp(sto):
    return 0.5 * (lithiation_ocp(sto) + delithiation_ocp(sto))


def get_parameter_values():
    return {{
        "{name} electrode OCP [V]": mean_ocp,
        "{name} electrode lithiation OCP [V]": lithiation_ocp,
        "{name} electrode delithiation OCP [V]": delithiation_ocp,
        "{name} particle lithiation hysteresis decay rate": {fit.rates[0]:.6g},
        "{name} particle delithiation hysteresis decay rate": {fit.rates[1]:.6g},
        "Initial hysteresis state in {electrode} electrode": {state:.6g},
    }}
'''


def _list(values: Array) -> str:
    """Return numbers as Python writes them, eight a line."""
    rows = []
    for k in range(0, values.size, 8):
        rows.append("    " + ", ".join(f"{value:.7g}" for value in values[k : k + 8].tolist()))
    return "[\n" + ",\n".join(rows) + "\n]"
