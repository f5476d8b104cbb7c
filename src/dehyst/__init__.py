"""dehyst: from a logged hysteresis loop to a verified compensator, and a simulated robot to try it on.

The public names and nothing else; each is imported when it is first used, so that ``import dehyst`` and
``dehyst --help`` cost nothing.
"""

import sys

TYPE_CHECKING = False  # which type checkers take for true; `typing` would be loaded before Ctrl-C is heeded
if TYPE_CHECKING:
    from typing import Any

    from dehyst.data.recording import Recording as Recording
    from dehyst.design import ExcitationPlan as ExcitationPlan
    from dehyst.design import Homing as Homing
    from dehyst.design import Limits as Limits
    from dehyst.design import design_drift_motion as design_drift_motion
    from dehyst.design import design_excitation as design_excitation
    from dehyst.design import home_model as home_model
    from dehyst.design import shortest_homing as shortest_homing
    from dehyst.errors import DehystError as DehystError
    from dehyst.families import Comparison as Comparison
    from dehyst.families import FamilyFit as FamilyFit
    from dehyst.families import LoopModel as LoopModel
    from dehyst.families import block as block
    from dehyst.families import compare as compare
    from dehyst.families import identify as identify
    from dehyst.families import identify_family as identify_family
    from dehyst.findings import Finding as Finding
    from dehyst.identification import CrossValidation as CrossValidation
    from dehyst.identification import Fit as Fit
    from dehyst.identification import Refit as Refit
    from dehyst.identification import choose_shear as choose_shear
    from dehyst.identification import cross_validate as cross_validate
    from dehyst.identification import identify_direct as identify_direct
    from dehyst.identification.stream import Progress as Progress
    from dehyst.identification.stream import identify_stream as identify_stream
    from dehyst.io import inspect_log as inspect_log
    from dehyst.io import read_log as read_log
    from dehyst.io import read_signal as read_signal
    from dehyst.io.chunks import open_chunks as open_chunks
    from dehyst.models import Block as Block
    from dehyst.models import DirectInverse as DirectInverse
    from dehyst.models import HysteresisModel as HysteresisModel
    from dehyst.models import Model as Model
    from dehyst.models import ModifiedPrandtlIshlinskii as ModifiedPrandtlIshlinskii
    from dehyst.models import MonotoneMap as MonotoneMap
    from dehyst.models import PrandtlIshlinskii as PrandtlIshlinskii
    from dehyst.models import ShearedPrandtlIshlinskii as ShearedPrandtlIshlinskii
    from dehyst.models import StaticCurve as StaticCurve
    from dehyst.models import StopOperatorModel as StopOperatorModel
    from dehyst.models import load as load
    from dehyst.monitoring import Drift as Drift
    from dehyst.monitoring import drift as drift
    from dehyst.monitoring.evaluate import Evaluation as Evaluation
    from dehyst.monitoring.evaluate import evaluate as evaluate
    from dehyst.report import as_html as as_html
    from dehyst.report import plot as plot
    from dehyst.report import write_comparison_report as write_comparison_report
    from dehyst.report import write_drift_report as write_drift_report
    from dehyst.report import write_report as write_report
    from dehyst.robot.arm import Arm as Arm
    from dehyst.robot.arm import Drives as Drives
    from dehyst.robot.arm import JointBench as JointBench
    from dehyst.robot.arm import Mechanism as Mechanism
    from dehyst.robot.arm import Reference as Reference
    from dehyst.robot.arm import Robot as Robot
    from dehyst.robot.arm import load_robot as load_robot
    from dehyst.robot.control import Compensator as Compensator
    from dehyst.robot.control import Controller as Controller
    from dehyst.robot.control import InverseCompensator as InverseCompensator
    from dehyst.robot.control import JointController as JointController
    from dehyst.robot.control import JointControllerParameters as JointControllerParameters
    from dehyst.robot.experiments.calibration import calibrate as calibrate
    from dehyst.robot.experiments.equipment import Equipment as Equipment
    from dehyst.robot.experiments.equipment import equip as equip
    from dehyst.robot.experiments.identification import identify_joint as identify_joint
    from dehyst.robot.experiments.path import plan_path as plan_path
    from dehyst.robot.experiments.reproduce import Request as Request
    from dehyst.robot.experiments.reproduce import reproduce as reproduce
    from dehyst.robot.experiments.results import Reproduction as Reproduction
    from dehyst.robot.experiments.trials import run_trial as run_trial
    from dehyst.robot.gym import gym as gym
    from dehyst.robot.report import write_reproduction_report as write_reproduction_report
    from dehyst.version import __version__ as __version__


def _refuse_subinterpreter() -> None:
    """Refuse before numpy and the binding are loaded: neither knows subinterpreters, and calls of the core hang."""
    for name in ("_interpreters", "_xxsubinterpreters"):  # since Python 3.13; before
        try:
            interpreters: Any = __import__(name)
        except ImportError:
            continue
        if interpreters.get_current() != interpreters.get_main():
            raise ImportError(
                "dehyst was imported in a subinterpreter, where numpy and its compiled core cannot run: import it in "
                "the main interpreter and share work by processes (concurrent.futures.ProcessPoolExecutor); under "
                "mod_wsgi set WSGIApplicationGroup %{GLOBAL}."
            )
        return


_refuse_subinterpreter()

_ROOMS = {
    "dehyst.data.recording": "Recording",
    "dehyst.design": ("ExcitationPlan Homing Limits design_drift_motion design_excitation home_model shortest_homing"),
    "dehyst.errors": "DehystError",
    "dehyst.families": "Comparison FamilyFit LoopModel block compare identify identify_family",
    "dehyst.findings": "Finding",
    "dehyst.identification": ("CrossValidation Fit Refit choose_shear cross_validate identify_direct"),
    "dehyst.identification.stream": "Progress identify_stream",
    "dehyst.io": "inspect_log read_log read_signal",
    "dehyst.io.chunks": "open_chunks",
    "dehyst.models": (
        "Block DirectInverse HysteresisModel Model ModifiedPrandtlIshlinskii MonotoneMap PrandtlIshlinskii "
        "ShearedPrandtlIshlinskii StaticCurve StopOperatorModel load"
    ),
    "dehyst.monitoring": "Drift drift",
    "dehyst.monitoring.evaluate": "Evaluation evaluate",
    "dehyst.report": "as_html plot write_comparison_report write_drift_report write_report",
    "dehyst.robot.arm": "Arm Drives JointBench Mechanism Reference Robot load_robot",
    "dehyst.robot.control": "Compensator Controller InverseCompensator JointController JointControllerParameters",
    "dehyst.robot.gym": "gym",
    "dehyst.robot.experiments.calibration": "calibrate",
    "dehyst.robot.experiments.equipment": "Equipment equip",
    "dehyst.robot.experiments.identification": "identify_joint",
    "dehyst.robot.experiments.path": "plan_path",
    "dehyst.robot.experiments.reproduce": "Request reproduce",
    "dehyst.robot.experiments.results": "Reproduction",
    "dehyst.robot.experiments.trials": "run_trial",
    "dehyst.robot.report": "write_reproduction_report",
    "dehyst.version": "__version__",
}
_HOME = {name: room for room, names in _ROOMS.items() for name in names.split()}

__all__ = sorted(_HOME)


def __getattr__(name: str) -> "Any":
    if name not in _HOME:
        raise AttributeError(f"module 'dehyst' has no attribute '{name}'")
    __import__(_HOME[name])
    value = getattr(sys.modules[_HOME[name]], name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return list(__all__)
