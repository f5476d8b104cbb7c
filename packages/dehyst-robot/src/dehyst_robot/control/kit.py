"""Tools of `dehyst_robot.control` for other rooms."""

from dehyst.lazy import lazy_names

# Type checkers take this name for true; without an import of `typing` the room is imported faster.
TYPE_CHECKING = False
if TYPE_CHECKING:
    from dehyst_robot.control._compensator import refuse_second_shear as refuse_second_shear
    from dehyst_robot.control._controller import seated as seated
    from dehyst_robot.control._joint import DIRECT as DIRECT
    from dehyst_robot.control._joint import GIVEN as GIVEN
    from dehyst_robot.control._joint import direct_parameters as direct_parameters
    from dehyst_robot.control._joint import in_si as in_si
    from dehyst_robot.control._joint import native_controller as native_controller
    from dehyst_robot.control._parameters import OFF as OFF
    from dehyst_robot.control._reviewed import CONTROLLERS as CONTROLLERS
    from dehyst_robot.control._reviewed import PAPER as PAPER
    from dehyst_robot.control._reviewed import TUNED as TUNED
    from dehyst_robot.control._reviewed import derived_law as derived_law
    from dehyst_robot.control._storage import controller_checksum as controller_checksum
    from dehyst_robot.control._storage import controller_text as controller_text

# Module -> names that it has; each is imported when it is first used.
__getattr__, __dir__, __all__ = lazy_names(
    "dehyst_robot.control.kit",
    {
        "_compensator": "refuse_second_shear",
        "_controller": "seated",
        "_joint": "DIRECT GIVEN direct_parameters in_si native_controller",
        "_parameters": "OFF",
        "_reviewed": "CONTROLLERS PAPER TUNED derived_law",
        "_storage": "controller_checksum controller_text",
    },
)
