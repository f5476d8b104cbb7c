"""Models as other packages take them: `control` (python-control), `scikit` (scikit-learn), `benchmarks`.

Each module needs its package: ``pip install 'dehyst[control]'``, ``'dehyst[scikit]'``, ``'dehyst[benchmarks]'``.
"""

from dehyst.lazy import lazy_names

TYPE_CHECKING = False
if TYPE_CHECKING:
    from dehyst.neighbours.benchmarks import apply_model as apply_model
    from dehyst.neighbours.benchmarks import recording_of as recording_of
    from dehyst.neighbours.control import to_control as to_control
    from dehyst.neighbours.scikit import HysteresisRegressor as HysteresisRegressor

__getattr__, __dir__, __all__ = lazy_names(
    "dehyst.neighbours",
    {
        "benchmarks": "apply_model recording_of",
        "control": "to_control",
        "scikit": "HysteresisRegressor",
    },
)
