"""What is wrong with an image of a state, in words."""

from __future__ import annotations

from dehyst.errors import ParameterError

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
