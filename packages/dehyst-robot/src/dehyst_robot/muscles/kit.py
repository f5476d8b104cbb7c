"""Tools of `dehyst_robot.muscles` for other rooms."""

from dehyst.lazy import lazy_names

# Type checkers take this name for true; without an import of `typing` the room is imported faster.
TYPE_CHECKING = False
if TYPE_CHECKING:
    from dehyst_robot.muscles._base import Arithmetic as Arithmetic
    from dehyst_robot.muscles._experiments import STROKE as STROKE
    from dehyst_robot.muscles._measured import MEASURED_FORCE as MEASURED_FORCE
    from dehyst_robot.muscles._measured import MEASURED_LENGTH as MEASURED_LENGTH
    from dehyst_robot.muscles._measured import MEASURED_PRESSURE as MEASURED_PRESSURE
    from dehyst_robot.muscles._registry import save_muscle as save_muscle

# Module -> names that it has; each is imported when it is first used.
__getattr__, __dir__, __all__ = lazy_names(
    "dehyst_robot.muscles.kit",
    {
        "_base": "Arithmetic",
        "_experiments": "STROKE",
        "_measured": "MEASURED_FORCE MEASURED_LENGTH MEASURED_PRESSURE",
        "_registry": "save_muscle",
    },
)
