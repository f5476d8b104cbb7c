"""Tools of `dehyst.models` for other rooms."""

from dehyst.lazy import lazy_names

TYPE_CHECKING = False
if TYPE_CHECKING:
    from dehyst.models._arrays import parameter_array as parameter_array
    from dehyst.models._arrays import parameter_number as parameter_number
    from dehyst.models._arrays import signal_array as signal_array
    from dehyst.models._arrays import strictly_increasing as strictly_increasing
    from dehyst.models._base import make_stepper as make_stepper
    from dehyst.models._block import MEASURED as MEASURED
    from dehyst.models._block import refuse_image as refuse_image
    from dehyst.models._card import NO_CARD as NO_CARD
    from dehyst.models._card import in_units_of as in_units_of
    from dehyst.models._follow import follow as follow
    from dehyst.models._known import KnownPast as KnownPast
    from dehyst.models._known import known_past as known_past
    from dehyst.models._machine import EPS_FLOAT as EPS_FLOAT
    from dehyst.models._machine import Direction as Direction
    from dehyst.models._machine import Machine as Machine
    from dehyst.models._machine import Operator as Operator
    from dehyst.models._machine import declared_range as declared_range
    from dehyst.models._model import Inverted as Inverted
    from dehyst.models._model import Steps as Steps
    from dehyst.models._model import WeightTable as WeightTable
    from dehyst.models._model import earlier as earlier
    from dehyst.models._model import positive_period as positive_period
    from dehyst.models._model import require_model as require_model
    from dehyst.models._model import without_inverse as without_inverse
    from dehyst.models._offset import following as following
    from dehyst.models._offset import offset_numbers as offset_numbers
    from dehyst.models._offset import range_width as range_width
    from dehyst.models._policy import POLICY as POLICY
    from dehyst.models._resonance import resonance_of as resonance_of
    from dehyst.models._speed import faster_than_log as faster_than_log
    from dehyst.models._start import ABOUT as ABOUT
    from dehyst.models._start import DEFAULT as DEFAULT
    from dehyst.models._start import KNOWN as KNOWN
    from dehyst.models._start import MODEL as MODEL
    from dehyst.models._start import PASTS as PASTS
    from dehyst.models._start import UNKNOWN as UNKNOWN
    from dehyst.models._start import begun as begun
    from dehyst.models._start import check_start as check_start
    from dehyst.models._storage import model_from_dict as model_from_dict
    from dehyst.models._storage import model_from_text as model_from_text

__getattr__, __dir__, __all__ = lazy_names(
    "dehyst.models.kit",
    {
        "_arrays": "parameter_array parameter_number signal_array strictly_increasing",
        "_base": "make_stepper",
        "_block": "MEASURED refuse_image",
        "_card": "NO_CARD in_units_of",
        "_follow": "follow",
        "_known": "KnownPast known_past",
        "_machine": "Direction EPS_FLOAT Machine Operator declared_range",
        "_model": "Inverted Steps WeightTable earlier positive_period require_model without_inverse",
        "_offset": "following offset_numbers range_width",
        "_resonance": "resonance_of",
        "_speed": "faster_than_log",
        "_start": "ABOUT DEFAULT KNOWN MODEL PASTS UNKNOWN begun check_start",
        "_policy": "POLICY",
        "_storage": "model_from_dict model_from_text",
    },
)
