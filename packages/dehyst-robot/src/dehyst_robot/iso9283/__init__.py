"""ISO 9283: test paths, and the figures measured along them."""

from dehyst.lazy import lazy_names

# Type checkers take this name for true; without an import of `typing` the room is imported faster.
TYPE_CHECKING = False
if TYPE_CHECKING:
    from dehyst_robot.iso9283._metrics import cornering_deviation as cornering_deviation
    from dehyst_robot.iso9283._metrics import error_summary as error_summary
    from dehyst_robot.iso9283._metrics import iso9283 as iso9283
    from dehyst_robot.iso9283._metrics import path_accuracy as path_accuracy
    from dehyst_robot.iso9283._metrics import path_repeatability as path_repeatability
    from dehyst_robot.iso9283._metrics import path_velocity as path_velocity
    from dehyst_robot.iso9283._metrics import tracking_error as tracking_error
    from dehyst_robot.iso9283._metrics import tracking_figures as tracking_figures
    from dehyst_robot.iso9283._paths import Figure as Figure
    from dehyst_robot.iso9283._paths import TestCube as TestCube
    from dehyst_robot.iso9283._paths import TestPath as TestPath
    from dehyst_robot.iso9283._paths import circle as circle
    from dehyst_robot.iso9283._paths import line as line
    from dehyst_robot.iso9283._paths import rectangle as rectangle
    from dehyst_robot.iso9283._paths import test_path as test_path
    from dehyst_robot.iso9283._sections import sections as sections
    from dehyst_robot.iso9283._timing import Timed as Timed
    from dehyst_robot.iso9283._timing import Timing as Timing
    from dehyst_robot.iso9283._timing import slow_down_to as slow_down_to
    from dehyst_robot.iso9283._timing import timed as timed

# Module -> names that it has; each is imported when it is first used.
__getattr__, __dir__, __all__ = lazy_names(
    "dehyst_robot.iso9283",
    {
        "_metrics": "cornering_deviation error_summary iso9283 path_accuracy path_repeatability path_velocity "
        "tracking_error tracking_figures",
        "_paths": "Figure TestCube TestPath circle line rectangle test_path",
        "_sections": "sections",
        "_timing": "Timed Timing slow_down_to timed",
    },
)
