"""Joint controllers as code for a target."""

from dehyst.lazy import lazy_names

TYPE_CHECKING = False
if TYPE_CHECKING:
    from dehyst_robot.export._joint import joint_subject as joint_subject

__getattr__, __dir__, __all__ = lazy_names(
    "dehyst_robot.export",
    {
        "_joint": "joint_subject",
    },
)
