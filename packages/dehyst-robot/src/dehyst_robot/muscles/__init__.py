"""Muscle models of the literature: force from contraction and pressure, with memory, and back to the pressure."""

from dehyst.lazy import lazy_names

# Type checkers take this name for true; without an import of `typing` the room is imported faster.
TYPE_CHECKING = False
if TYPE_CHECKING:
    from dehyst_robot.muscles._base import Memory as Memory
    from dehyst_robot.muscles._base import MuscleModel as MuscleModel
    from dehyst_robot.muscles._base import MuscleStepper as MuscleStepper
    from dehyst_robot.muscles._bench import Bench as Bench
    from dehyst_robot.muscles._bench import default_contractions as default_contractions
    from dehyst_robot.muscles._bench import run_bench as run_bench
    from dehyst_robot.muscles._bench_log import BenchLog as BenchLog
    from dehyst_robot.muscles._experiments import Loop as Loop
    from dehyst_robot.muscles._experiments import contraction_reach as contraction_reach
    from dehyst_robot.muscles._experiments import force_velocity as force_velocity
    from dehyst_robot.muscles._experiments import isobaric_loop as isobaric_loop
    from dehyst_robot.muscles._fit import MuscleFit as MuscleFit
    from dehyst_robot.muscles._fit import fit_muscle as fit_muscle
    from dehyst_robot.muscles._joint import JointCharacteristic as JointCharacteristic
    from dehyst_robot.muscles._joint import MuscleJoint as MuscleJoint
    from dehyst_robot.muscles._joint import MuscleMechanism as MuscleMechanism
    from dehyst_robot.muscles._joint import SlippingJoint as SlippingJoint
    from dehyst_robot.muscles._joint import identify_slips as identify_slips
    from dehyst_robot.muscles._joint import joint_characteristic as joint_characteristic
    from dehyst_robot.muscles._parameters import Parameter as Parameter
    from dehyst_robot.muscles._parameters import parameter_names as parameter_names
    from dehyst_robot.muscles._registry import load_muscle as load_muscle
    from dehyst_robot.muscles._registry import muscle as muscle
    from dehyst_robot.muscles._registry import muscle_class as muscle_class
    from dehyst_robot.muscles._registry import muscle_names as muscle_names

# Module -> names that it has; each is imported when it is first used.
__getattr__, __dir__, __all__ = lazy_names(
    "dehyst_robot.muscles",
    {
        "_base": "Memory MuscleModel MuscleStepper",
        "_bench": "Bench default_contractions run_bench",
        "_bench_log": "BenchLog",
        "_experiments": "Loop contraction_reach force_velocity isobaric_loop",
        "_fit": "MuscleFit fit_muscle",
        "_joint": "JointCharacteristic MuscleJoint MuscleMechanism SlippingJoint identify_slips joint_characteristic",
        "_parameters": "Parameter parameter_names",
        "_registry": "load_muscle muscle muscle_class muscle_names",
    },
)
