"""Tests a saved model on new logs: its accuracy (`evaluate`), and changes of the actuator (`drift`)."""

from dehyst.lazy import lazy_names

TYPE_CHECKING = False
if TYPE_CHECKING:
    from dehyst.monitoring._evaluate import Evaluation as Evaluation
    from dehyst.monitoring._evaluate import Scored as Scored
    from dehyst.monitoring._evaluate import evaluate as evaluate
    from dehyst.monitoring._parts import NAMES as NAMES
    from dehyst.monitoring._parts import JudgedModel as JudgedModel
    from dehyst.monitoring._procedure import drift as drift
    from dehyst.monitoring._result import Acceptance as Acceptance
    from dehyst.monitoring._result import Drift as Drift
    from dehyst.monitoring._result import LogDrift as LogDrift
    from dehyst.monitoring._result import PartChange as PartChange
    from dehyst.monitoring._result import ScoredBlocks as ScoredBlocks
    from dehyst.monitoring._result import Trend as Trend
    from dehyst.monitoring._result import other_way as other_way
    from dehyst.monitoring._result import without_exponent as without_exponent
    from dehyst.monitoring._sensor import CorrectedReadings as CorrectedReadings
    from dehyst.monitoring._sensor import corrected_readings as corrected_readings

__getattr__, __dir__, __all__ = lazy_names(
    "dehyst.monitoring",
    {
        "_evaluate": "Evaluation Scored evaluate",
        "_parts": "JudgedModel NAMES",
        "_procedure": "drift",
        "_result": "Acceptance Drift LogDrift PartChange ScoredBlocks Trend other_way without_exponent",
        "_sensor": "CorrectedReadings corrected_readings",
    },
)
