"""Units in the keys of a parameter file: `pressure_bar` is the quantity `pressure`, written in bar, kept in SI."""

from __future__ import annotations

import math

# what stands after the quantity's name -> factor to SI. Frequencies become angular: [rad/s].
TO_SI: dict[str, float] = {
    "": 1.0,
    "m": 1.0,
    "kg": 1.0,
    "s": 1.0,
    "K": 1.0,
    "N": 1.0,
    "Nm": 1.0,
    "Nm_s": 1.0,
    "m_s": 1.0,
    "m_s2": 1.0,
    "m_s3": 1.0,
    "1_s": 1.0,
    "deg": math.pi / 180.0,
    "bar": 1e5,
    "bar_rad": 1e5,
    "N_bar": 1e-5,
    "l": 1e-3,
    "l_per_m": 1e-3,
    "l_s_bar": 1e-3 / 1e5,
    "Hz": 2.0 * math.pi,
}


def key_of(quantity: str, unit: str) -> str:
    """Return the key of a quantity in a parameter file.

    Examples
    --------
    >>> key_of("supply", "bar")
    'supply_bar'
    >>> key_of("ratio", "")
    'ratio'
    """
    return f"{quantity}_{unit}" if unit else quantity
