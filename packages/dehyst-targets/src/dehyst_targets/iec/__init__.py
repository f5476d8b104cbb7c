"""Checker of exported Structured Text: parses it, checks its types, and runs it in IEEE arithmetic."""

from dehyst.lazy import lazy_names

TYPE_CHECKING = False
if TYPE_CHECKING:
    from dehyst_targets.iec._machine import Instance as Instance
    from dehyst_targets.iec._machine import Library as Library
    from dehyst_targets.iec._machine import load_program as load_program
    from dehyst_targets.iec._parser import ELEMENTARY as ELEMENTARY
    from dehyst_targets.iec._parser import LARGEST as LARGEST
    from dehyst_targets.iec._parser import REALS as REALS
    from dehyst_targets.iec._parser import SMALLEST as SMALLEST
    from dehyst_targets.iec._parser import TextError as TextError
    from dehyst_targets.iec._reserved import LONGEST_NAME as LONGEST_NAME
    from dehyst_targets.iec._reserved import RESERVED as RESERVED

__getattr__, __dir__, __all__ = lazy_names(
    "dehyst_targets.iec",
    {
        "_machine": "Instance Library load_program",
        "_parser": "ELEMENTARY LARGEST REALS SMALLEST TextError",
        "_reserved": "LONGEST_NAME RESERVED",
    },
)
