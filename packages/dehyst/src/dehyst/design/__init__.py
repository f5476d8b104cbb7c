"""Design of test motions: what to log for a good identification, and how to home."""

from dehyst.lazy import lazy_names

TYPE_CHECKING = False
if TYPE_CHECKING:
    from dehyst.design._design import CYCLES as CYCLES
    from dehyst.design._design import design_drift_motion as design_drift_motion
    from dehyst.design._design import design_excitation as design_excitation
    from dehyst.design._design import limits_of as limits_of
    from dehyst.design._excitation import UNSEEN_TIPS as UNSEEN_TIPS
    from dehyst.design._excitation import Limits as Limits
    from dehyst.design._excitation import decaying_cycles as decaying_cycles
    from dehyst.design._excitation import loops as loops
    from dehyst.design._excitation import triangle_sweep as triangle_sweep
    from dehyst.design._homing import Homing as Homing
    from dehyst.design._homing import admissible as admissible
    from dehyst.design._homing import shortest_homing as shortest_homing
    from dehyst.design._homing_model import home_model as home_model
    from dehyst.design._plan import ExcitationPlan as ExcitationPlan
    from dehyst.design._separability import lags as lags
    from dehyst.design._separability import separability as separability

__getattr__, __dir__, __all__ = lazy_names(
    "dehyst.design",
    {
        "_design": "CYCLES design_drift_motion design_excitation limits_of",
        "_excitation": "Limits UNSEEN_TIPS decaying_cycles loops triangle_sweep",
        "_homing": "Homing admissible shortest_homing",
        "_homing_model": "home_model",
        "_plan": "ExcitationPlan",
        "_separability": "lags separability",
    },
)
