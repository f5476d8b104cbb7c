"""Hysteresis models of the literature: one file per family, fitted to one log and compared."""

from dehyst.lazy import lazy_names

TYPE_CHECKING = False
if TYPE_CHECKING:
    from dehyst.families._base import STARTS as STARTS
    from dehyst.families._base import UNSCALED as UNSCALED
    from dehyst.families._base import InverseLoop as InverseLoop
    from dehyst.families._base import LoopModel as LoopModel
    from dehyst.families._base import LoopStepper as LoopStepper
    from dehyst.families._base import Scaling as Scaling
    from dehyst.families._blocks import block as block
    from dehyst.families._choice import Chosen as Chosen
    from dehyst.families._dahl import Dahl as Dahl
    from dehyst.families._element_machine import ElementBlockParameters as ElementBlockParameters
    from dehyst.families._inversion import first_input as first_input
    from dehyst.families._lateness import Lateness as Lateness
    from dehyst.families._lateness import best_row_and_delay as best_row_and_delay
    from dehyst.families._loop_work import dead_band as dead_band
    from dehyst.families._registry import MODULES as MODULES
    from dehyst.families._registry import ROW_NAMES as ROW_NAMES
    from dehyst.families._registry import Family as Family
    from dehyst.families._registry import example as example
    from dehyst.families._registry import family as family
    from dehyst.families._registry import is_family as is_family
    from dehyst.families._registry import names as names
    from dehyst.families._registry import title_of as title_of
    from dehyst.families._table import ROWS as ROWS
    from dehyst.families._training import Stretch as Stretch
    from dehyst.families._training import Training as Training
    from dehyst.families._training import steps_of as steps_of

__getattr__, __dir__, __all__ = lazy_names(
    "dehyst.families",
    {
        "_base": "InverseLoop LoopModel LoopStepper STARTS Scaling UNSCALED",
        "_blocks": "block",
        "_choice": "Chosen",
        "_dahl": "Dahl",
        "_element_machine": "ElementBlockParameters",
        "_inversion": "first_input",
        "_lateness": "Lateness best_row_and_delay",
        "_loop_work": "dead_band",
        "_registry": "Family MODULES ROW_NAMES example family is_family names title_of",
        "_table": "ROWS",
        "_training": "Stretch Training steps_of",
    },
)
