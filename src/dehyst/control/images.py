"""What is wrong with an image of a state, in words."""

from __future__ import annotations

from typing import cast

import numpy as np
import numpy.typing as npt

from dehyst.errors import ParameterError

Words = npt.NDArray[np.uint32]

_FAULTS = {  # answers of the core, as in core/dehyst.h
    1: ("size", "it has another length: cut off, or of a model with another number of operators"),
    2: ("kind", "it is no image of such a state in double precision"),
    3: ("damaged", "its checksum is wrong"),
    4: ("foreign", "it was saved with another model or other parameters"),
    5: ("invalid", "it holds a state that cannot be here"),
}


def refuse(answer: int, cure: str) -> None:
    """Raise ParameterError with the fault's name as ``facts["fault"]`` unless the core's answer is good."""
    if answer:
        fault, what = _FAULTS[answer]
        raise ParameterError(f"the state was not restored: {what}. {cure}", fault=fault)


def words_of(image: npt.ArrayLike) -> Words:
    """Return an image as 32-bit words, or refuse what is none."""
    words = np.asarray(image)
    whole = words.ndim == 1 and words.dtype.kind in "iu" and bool(np.all((words >= 0) & (words < 2**32)))
    if not whole:
        raise ParameterError(
            f"the state was not restored: an image is an array of 32-bit words, (m,), not {type(image).__name__} of "
            f"shape {words.shape} and type {words.dtype}; pass what save() returned.",
            fault="kind",
        )
    return cast(Words, np.ascontiguousarray(words, dtype=np.uint32))
