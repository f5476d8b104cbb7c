"""Input checks of all models: shape, type, finite values."""

from __future__ import annotations

import math
import os

import numpy as np
import numpy.typing as npt

import dehyst._native as _native
from dehyst.arrays import Array as Array
from dehyst.errors import ParameterError


def _real(values: npt.ArrayLike) -> npt.NDArray[np.generic]:
    """Return values that may become floats: NaN where masked, TypeError for complex numbers and dates."""
    # NumPy itself would take what lies under the mask for data.
    if isinstance(values, np.ma.MaskedArray):
        values = np.ma.filled(values.astype(np.float64), np.nan)
    array = np.asarray(values)
    if array.dtype.kind not in "biufOUS":
        raise TypeError(f"values of type {array.dtype} are not real numbers")
    return array


def parameter_array(values: npt.ArrayLike, name: str) -> Array:
    """Return a read-only contiguous copy (n,) of finite values, or say what is wrong with them."""
    # A copy: what the caller does with its own array later must not change the model.
    try:
        array = np.array(_real(values), dtype=np.float64, copy=True, order="C")
    except (TypeError, ValueError, OverflowError) as fault:
        raise ParameterError(
            f"{name} is not a list of numbers ({fault}). Pass a one-dimensional array."
        ) from None
    if array.ndim != 1 or array.size == 0:
        raise ParameterError(
            f"{name} has shape {array.shape}; pass one value per operator, shape (n,) with n >= 1.",
            shape=array.shape,
        )
    # The comparison is also false for NaN.
    bad = np.flatnonzero(~(np.abs(array) <= _native.INPUT_LIMIT))
    if bad.size:
        raise ParameterError(
            f"{name}[{bad[0]}] = {float(array[bad[0]])!r} is not a finite number of physical size "
            f"(limit {_native.INPUT_LIMIT:g}); the model would answer with infinities. Correct or drop it.",
            index=int(bad[0]),
        )
    array.flags.writeable = False
    return array


def parameter_number(value: float, name: str) -> float:
    """Return a finite float, or say what is wrong with it."""
    try:
        number = float(value)
    except OverflowError:  # an integer of hundreds of digits, too long to be printed
        raise ParameterError(
            f"{name} is beyond every floating point number; pass a finite one."
        ) from None
    except (TypeError, ValueError):
        raise ParameterError(
            f"{name} = {value!r:.60} is not a number; pass one, such as 0.01."
        ) from None
    if not math.isfinite(number) or abs(number) > _native.INPUT_LIMIT:
        raise ParameterError(
            f"{name} = {number!r} is not a finite number of physical size; pass a finite one."
        )
    return number


def strictly_increasing(array: Array, name: str) -> None:
    """Raise ParameterError at the first value that is not larger than the one before it."""
    fault = np.flatnonzero(np.diff(array) <= 0)
    if fault.size:
        k = int(fault[0])
        raise ParameterError(
            f"{name} must increase strictly, but {name}[{k + 1}] = {array[k + 1]:g} follows {array[k]:g}. "
            f"Sort them and drop repeated ones.",
            index=k + 1,
        )


def signal_array(values: npt.ArrayLike, name: str) -> Array:
    """Return samples as a contiguous float array (T,); non-finite ones stay, the core rejects them."""
    # A path is a usual mistake, and NumPy's message about it would not help.
    if isinstance(values, str | os.PathLike):
        raise ParameterError(
            f"{name} is the path {str(values)!r:.80}, and its samples are needed. Type: log = "
            f"dehyst.read_log({str(values)!r:.80}, input='...', output='...'), and give log.input or log.output."
        )
    try:
        array = np.ascontiguousarray(_real(values), dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as fault:
        raise ParameterError(f"{name} is not a sequence of numbers ({fault}).") from None
    if np.ndim(values) != 1:
        raise ParameterError(
            f"{name} has shape {np.shape(values)}; pass one value a sample, shape (T,), for example data[:, 0], "
            f"or use model.stepper() for single samples.",
            shape=np.shape(values),
        )
    return array
