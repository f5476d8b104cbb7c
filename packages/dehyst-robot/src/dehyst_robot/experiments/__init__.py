"""The paper's experiment on the simulated arm.

Its calls are public as ``dehyst_robot.reproduce``, ``dehyst_robot.run_trial``, ...
"""

from dehyst.lazy import lazy_names

TYPE_CHECKING = False
if TYPE_CHECKING:
    from dehyst_robot.experiments._calibration import SPACING as SPACING
    from dehyst_robot.experiments._calibration import calibrate as calibrate
    from dehyst_robot.experiments._calibration import controller_parameters as controller_parameters
    from dehyst_robot.experiments._calibration import excite as excite
    from dehyst_robot.experiments._calibration import home as home
    from dehyst_robot.experiments._calibration import (
        nominal_characteristic as nominal_characteristic,
    )
    from dehyst_robot.experiments._equipment import Equipment as Equipment
    from dehyst_robot.experiments._equipment import equip as equip
    from dehyst_robot.experiments._identification import identify_joint as identify_joint
    from dehyst_robot.experiments._path import design_joint as design_joint
    from dehyst_robot.experiments._path import plan_path as plan_path
    from dehyst_robot.experiments._plant_fit import FittedNumber as FittedNumber
    from dehyst_robot.experiments._plant_fit import LogFit as LogFit
    from dehyst_robot.experiments._plant_fit import PlantFit as PlantFit
    from dehyst_robot.experiments._plant_fit import RigLog as RigLog
    from dehyst_robot.experiments._point import evaluate_point as evaluate_point
    from dehyst_robot.experiments._reproduce import Request as Request
    from dehyst_robot.experiments._reproduce import reproduce as reproduce
    from dehyst_robot.experiments._results import JointIdentification as JointIdentification
    from dehyst_robot.experiments._results import PlantResult as PlantResult
    from dehyst_robot.experiments._results import Reproduction as Reproduction
    from dehyst_robot.experiments._rig import JointCheck as JointCheck
    from dehyst_robot.experiments._sweep.points import Summary as Summary
    from dehyst_robot.experiments._sweep.run import run_sweep as run_sweep
    from dehyst_robot.experiments._trials import run_trial as run_trial

__getattr__, __dir__, __all__ = lazy_names(
    "dehyst_robot.experiments",
    {
        "_calibration": "SPACING calibrate controller_parameters excite home nominal_characteristic",
        "_equipment": "Equipment equip",
        "_identification": "identify_joint",
        "_path": "design_joint plan_path",
        "_plant_fit": "FittedNumber LogFit PlantFit RigLog",
        "_point": "evaluate_point",
        "_reproduce": "Request reproduce",
        "_results": "JointIdentification PlantResult Reproduction",
        "_rig": "JointCheck",
        "_sweep.points": "Summary",
        "_sweep.run": "run_sweep",
        "_trials": "run_trial",
    },
)
