"""dehyst: from a logged hysteresis loop to a verified compensator.

The public names and nothing else; each is imported when it is first used, so that ``import dehyst`` and
``dehyst --help`` cost nothing.
"""

from dehyst.lazy import lazy_names

TYPE_CHECKING = (
    False  # which type checkers take for true; `typing` would be loaded before Ctrl-C is heeded
)
if TYPE_CHECKING:
    from dehyst.data import Recording as Recording
    from dehyst.design import Limits as Limits
    from dehyst.design import design_excitation as design_excitation
    from dehyst.errors import DehystError as DehystError
    from dehyst.families import block as block
    from dehyst.findings import Finding as Finding
    from dehyst.identification import Comparison as Comparison
    from dehyst.identification import CrossValidation as CrossValidation
    from dehyst.identification import Fit as Fit
    from dehyst.identification import compare as compare
    from dehyst.identification import cross_validate as cross_validate
    from dehyst.identification import identify as identify
    from dehyst.io import inspect_log as inspect_log
    from dehyst.io import read_log as read_log
    from dehyst.io import read_signal as read_signal
    from dehyst.models import Block as Block
    from dehyst.models import Model as Model
    from dehyst.models import ModifiedPrandtlIshlinskii as ModifiedPrandtlIshlinskii
    from dehyst.models import MonotoneMap as MonotoneMap
    from dehyst.models import PrandtlIshlinskii as PrandtlIshlinskii
    from dehyst.models import StopOperatorModel as StopOperatorModel
    from dehyst.models import load as load
    from dehyst.monitoring import Drift as Drift
    from dehyst.monitoring import Evaluation as Evaluation
    from dehyst.monitoring import drift as drift
    from dehyst.monitoring import evaluate as evaluate
    from dehyst.report import as_html as as_html
    from dehyst.report import plot as plot
    from dehyst.report import write_comparison_report as write_comparison_report
    from dehyst.report import write_drift_report as write_drift_report
    from dehyst.report import write_report as write_report
    from dehyst.version import __version__ as __version__

__getattr__, __dir__, __all__ = lazy_names(
    "dehyst",
    {
        "data": "Recording",
        "design": "Limits design_excitation",
        "errors": "DehystError",
        "families": "block",
        "findings": "Finding",
        "identification": "Comparison CrossValidation Fit compare cross_validate identify",
        "io": "inspect_log read_log read_signal",
        "models": "Block Model ModifiedPrandtlIshlinskii MonotoneMap PrandtlIshlinskii "
        "StopOperatorModel load",
        "monitoring": "Drift Evaluation drift evaluate",
        "report": "as_html plot write_comparison_report write_drift_report write_report",
        "version": "__version__",
    },
)
