"""Tools of `dehyst.families` for other rooms."""

from dehyst.lazy import lazy_names

TYPE_CHECKING = False
if TYPE_CHECKING:
    from dehyst.families._butterfly import Butterfly as Butterfly
    from dehyst.families._butterfly import butterfly_in as butterfly_in
    from dehyst.families._choice import Terms as Terms
    from dehyst.families._choice import row_again as row_again
    from dehyst.families._coupled import CorePair as CorePair
    from dehyst.families._coupled import CoupledModel as CoupledModel
    from dehyst.families._coupled_fit import CoupledTraining as CoupledTraining
    from dehyst.families._coupled_fit import FittedCoupled as FittedCoupled
    from dehyst.families._coupled_fit import fit_coupled as fit_coupled
    from dehyst.families._elements import KINDS as KINDS
    from dehyst.families._elements import LAGS as LAGS
    from dehyst.families._elements import SOURCES as SOURCES
    from dehyst.families._elements import ElementModel as ElementModel
    from dehyst.families._lateness import ChosenRow as ChosenRow
    from dehyst.families._linear_form import NEXT_TO_NOTHING as NEXT_TO_NOTHING
    from dehyst.families._linear_form import LinearForm as LinearForm
    from dehyst.families._loop_work import DeadBand as DeadBand
    from dehyst.families._loop_work import work as work
    from dehyst.families._policy import POLICY as POLICY
    from dehyst.families._registry import BEST as BEST
    from dehyst.families._registry import TITLES as TITLES
    from dehyst.families._rows import row_named as row_named
    from dehyst.families._rows import turns_of as turns_of

__getattr__, __dir__, __all__ = lazy_names(
    "dehyst.families.kit",
    {
        "_butterfly": "Butterfly butterfly_in",
        "_choice": "Terms row_again",
        "_coupled": "CoupledModel CorePair",
        "_coupled_fit": "CoupledTraining FittedCoupled fit_coupled",
        "_elements": "ElementModel KINDS LAGS SOURCES",
        "_lateness": "ChosenRow",
        "_linear_form": "NEXT_TO_NOTHING LinearForm",
        "_loop_work": "DeadBand work",
        "_policy": "POLICY",
        "_registry": "BEST TITLES",
        "_rows": "row_named turns_of",
    },
)
