"""Identification of a joint's hysteresis: nested loops, sheared, fitted by the one existing code path."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import numpy.typing as npt

from dehyst.evaluation import UNSEEN_TIPS, loops
from dehyst.experiments.nominal import controller_parameters
from dehyst.experiments.quasistatic import SPACING, excite, home, known_torque
from dehyst.experiments.results import Characteristic, JointIdentification
from dehyst.identification import Fit, identify
from dehyst.io import read_log, write_csv
from dehyst.plant.arm import Arm, ArmLog
from dehyst.plant.mechanisms import MechanismFactory, mechanisms_of
from dehyst.plant.parameters import Robot

Array = npt.NDArray[np.float64]

BAR = 1e5
INPUT, OUTPUT, TIME = "sheared_bar", "angle_rad", "time_s"


def identify_joint(
    robot: Robot,
    number: int,
    characteristic: Characteristic,
    folder: Path,
    *,
    seed: int = 0,
    mechanisms: MechanismFactory | None = None,
) -> JointIdentification:
    """Run nested loops on a joint alone, write their log, and identify the paper's model from the written file.

    The input of the model is the loop arranged around the diagonal, x = dp - dp_nom(q) + k q, its output q; dp_nom is
    the calibrated characteristic at the known load. ``dehyst identify LOG --input sheared_bar --output angle_rad
    --family pi`` gives the same model, bit for bit.

    Parameters
    ----------
    robot
        Its [identification] and [compensator] tables.
    number
        Of the joint.
    characteristic
        The joint's A, B, C.
    folder
        Where the log is written.
    seed
        Of the noise and the muscles' tolerances.
    mechanisms
        Makes hysteresis mechanisms of one's own, instead of the robot's.

    Returns
    -------
    identification : JointIdentification

    Examples
    --------
    Shorter than the file's own calibration and loops:

    >>> from tempfile import TemporaryDirectory
    >>> from dehyst.experiments.calibration import calibrate
    >>> from dehyst.plant.parameters import load_robot
    >>> short = {"mean_pressures_bar": [2.2, 3.8], "loads_bar": [-0.8, 0.8], "sweep_s": 8.0, "degree": 3}
    >>> robot = load_robot(changes={"calibration": short, "identification.loop_s": 8.0, "homing.cycles": 3})
    >>> with TemporaryDirectory() as folder:
    ...     found = identify_joint(robot, 1, calibrate(robot, 1), Path(folder))
    >>> found.accepted, bool(found.inverse_rms_ratio < 0.3)
    (True, True)
    """
    arm = Arm(
        robot,
        moving=(number,),
        controllers={number: controller_parameters(robot, number, characteristic)},
        mechanisms=mechanisms_of(mechanisms, (number,)),
        seed=seed,
    )
    settings, shear = robot.identification, robot.compensator.shear / BAR
    reach = settings.range_share * robot.joint(number).range
    seen = loops(settings.tips, settings.loop, settings.hold, SPACING).value
    home(arm, {number: characteristic})
    log = _loops(arm, characteristic, reach * np.concatenate([seen, settings.second_share * seen]), shear)
    file = write_csv(folder / f"identification_joint{number}.csv", log)
    recording = read_log(file, input=INPUT, output=OUTPUT, time=TIME)
    compensator = robot.compensator
    fit = identify(recording, family="pi", n=compensator.operators, eps=compensator.eps)
    home(arm, {number: characteristic})
    others = loops(UNSEEN_TIPS, settings.loop, settings.hold, SPACING).value
    unseen = _loops(arm, characteristic, reach * others, shear)
    write_csv(folder / f"unseen_joint{number}.csv", unseen)
    return _tested(number, characteristic, log, fit, shear, unseen)


def _loops(arm: Arm, characteristic: Characteristic, targets: Array, shear: float) -> Mapping[str, Array]:
    """Run targets (K,) on the only joint of an arm; columns of the log as they are written."""
    robot = arm.robot
    log = excite(arm, targets[:, None], {arm.moving[0]: characteristic}, robot.identification.sample)
    return _columns(arm, log, characteristic, shear)


def _columns(arm: Arm, log: ArmLog, characteristic: Characteristic, shear: float) -> Mapping[str, Array]:
    q = log.measured[:, 0]
    first, second = log.pressure[:, 0, 0] / BAR, log.pressure[:, 0, 1] / BAR
    torque = known_torque(arm, q[:, None])[:, 0]
    nominal = characteristic.difference(q, BAR * (first + second) / 2, torque) / BAR
    difference = first - second
    return {
        TIME: log.time,
        "pressure_1_bar": first,
        "pressure_2_bar": second,
        "pressure_difference_bar": difference,
        "nominal_difference_bar": nominal,
        INPUT: difference - nominal + shear * q,
        OUTPUT: q,
    }


def _tested(
    number: int,
    characteristic: Characteristic,
    log: Mapping[str, Array],
    fit: Fit,
    shear: float,
    unseen: Mapping[str, Array],
) -> JointIdentification:
    """Ask the inverse model for the hysteresis of loops that it has not seen."""
    q = unseen[OUTPUT]
    hysteresis = unseen["pressure_difference_bar"] - unseen["nominal_difference_bar"]
    inverse = fit.model.inverse().simulate(q) - shear * q
    ratio = float(np.sqrt(np.mean((hysteresis - inverse) ** 2) / np.mean(hysteresis**2)))
    unexplained = float(np.std(hysteresis - inverse) / np.std(hysteresis))
    tested = {TIME: unseen[TIME], OUTPUT: q, "hysteresis_bar": hysteresis, "inverse_bar": inverse}
    return JointIdentification(number, characteristic, log, fit, shear, tested, ratio, unexplained)
