"""Identification of models from logs, with warnings about what the data cannot determine."""

from dehyst.lazy import lazy_names

TYPE_CHECKING = False
if TYPE_CHECKING:
    from dehyst.identification._auto import identify as identify
    from dehyst.identification._candidates import all_names as all_names
    from dehyst.identification._cautions import hidden_by as hidden_by
    from dehyst.identification._cautions import of_range as of_range
    from dehyst.identification._comparison import ComparedFamily as ComparedFamily
    from dehyst.identification._comparison import Comparison as Comparison
    from dehyst.identification._comparison import compare as compare
    from dehyst.identification._coupled import CoupledFit as CoupledFit
    from dehyst.identification._cross_validation import CrossValidation as CrossValidation
    from dehyst.identification._cross_validation import cross_validate as cross_validate
    from dehyst.identification._fit import ComparedSetting as ComparedSetting
    from dehyst.identification._fit import Fit as Fit
    from dehyst.identification._fit import InputError as InputError
    from dehyst.identification._fit import Refit as Refit
    from dehyst.identification._fit import Score as Score
    from dehyst.identification._intervals import Interval as Interval
    from dehyst.identification._memory import INITIAL_STATES as INITIAL_STATES
    from dehyst.identification._memory import known_from as known_from
    from dehyst.identification._memory import past_in_words as past_in_words
    from dehyst.identification._memory import state_before as state_before
    from dehyst.identification._mending import ENDED as ENDED
    from dehyst.identification._mending import mended as mended
    from dehyst.identification._policy import POLICY as POLICY
    from dehyst.identification._residual import Residual as Residual
    from dehyst.identification._threads import single_blas as single_blas

__getattr__, __dir__, __all__ = lazy_names(
    "dehyst.identification",
    {
        "_auto": "identify",
        "_candidates": "all_names",
        "_cautions": "hidden_by of_range",
        "_comparison": "ComparedFamily Comparison compare",
        "_coupled": "CoupledFit",
        "_cross_validation": "CrossValidation cross_validate",
        "_fit": "ComparedSetting Fit InputError Refit Score",
        "_intervals": "Interval",
        "_memory": "INITIAL_STATES known_from past_in_words state_before",
        "_mending": "ENDED mended",
        "_policy": "POLICY",
        "_residual": "Residual",
        "_threads": "single_blas",
    },
)
