"""Constants of Structured Text that read back as the same bits."""

from __future__ import annotations

import numpy as np

from dehyst.errors import ParameterError


def constant(value: float, type_: str) -> str:
    """Return the shortest decimal constant whose nearest LREAL or REAL is `value`: 17 or 9 digits at most.

    IEC 61131-3 has no hexadecimal floating-point constants; it wants digits on both sides of the point.

    Parameters
    ----------
    value
        Finite; for REAL it is rounded to single precision first.
    type_
        ``"LREAL"`` or ``"REAL"``.

    Raises
    ------
    ParameterError
        If the value is not finite in this type.

    Examples
    --------
    >>> [constant(x, "LREAL") for x in (0.1, 1e-05, -2.0, 1e300)]
    ['0.1', '1.0E-5', '-2.0', '1.0E+300']
    >>> constant(0.1, "REAL")
    '0.1'
    """
    with np.errstate(over="ignore"):
        number = np.float64(value) if type_ == "LREAL" else np.float32(value)
    if not np.isfinite(number):
        raise ParameterError(
            f"{value!r} is no number of type {type_}: a PLC has no constant for it. Export with --real double, or "
            "identify the model in units that give numbers of ordinary size.",
            value=value,
            type=type_,
        )
    text = str(number)
    mantissa, _, exponent = text.partition("e")
    if "." not in mantissa:
        mantissa += ".0"
    return f"{mantissa}E{int(exponent):+d}".replace("E-0", "E-").replace("E+0", "E+") if exponent else mantissa
