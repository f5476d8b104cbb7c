"""Tools of `dehyst_robot.arm` for other rooms."""

from dehyst.lazy import lazy_names

# Type checkers take this name for true; without an import of `typing` the room is imported faster.
TYPE_CHECKING = False
if TYPE_CHECKING:
    from dehyst_robot.arm._body import hinges_of as hinges_of
    from dehyst_robot.arm._drawn import drawn_mjcf as drawn_mjcf
    from dehyst_robot.arm._joints import run_pressures as run_pressures
    from dehyst_robot.arm._kinematics import joint_path as joint_path
    from dehyst_robot.arm._mechanisms import PLANTS as PLANTS
    from dehyst_robot.arm._mechanisms import mechanisms_of as mechanisms_of
    from dehyst_robot.arm._parameters import CONDITIONS as CONDITIONS
    from dehyst_robot.arm._parameters import DEFAULT as DEFAULT
    from dehyst_robot.arm._parameters import conditions_of as conditions_of
    from dehyst_robot.arm._parameters import numbers_text as numbers_text
    from dehyst_robot.arm._rigid_body import inverse_dynamics as inverse_dynamics
    from dehyst_robot.arm._rigid_body import joint_inertia as joint_inertia
    from dehyst_robot.arm._rigid_body import joint_positions as joint_positions
    from dehyst_robot.arm._rigid_body import moment_arms as moment_arms
    from dehyst_robot.arm._rigid_body import tool_positions as tool_positions
    from dehyst_robot.arm._routing import contraction as contraction
    from dehyst_robot.arm._tables import SPRING as SPRING

# Module -> names that it has; each is imported when it is first used.
__getattr__, __dir__, __all__ = lazy_names(
    "dehyst_robot.arm.kit",
    {
        "_body": "hinges_of",
        "_drawn": "drawn_mjcf",
        "_joints": "run_pressures",
        "_kinematics": "joint_path",
        "_mechanisms": "PLANTS mechanisms_of",
        "_parameters": "CONDITIONS DEFAULT conditions_of numbers_text",
        "_rigid_body": "inverse_dynamics joint_inertia joint_positions moment_arms tool_positions",
        "_routing": "contraction",
        "_tables": "SPRING",
    },
)
