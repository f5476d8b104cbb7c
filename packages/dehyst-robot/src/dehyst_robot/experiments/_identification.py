"""Runs and logs the identification motions of a joint once, and fits each compensator from the log."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from dehyst.arrays import Array
from dehyst.data import Recording
from dehyst.design import UNSEEN_TIPS, loops
from dehyst.errors import ParameterError
from dehyst.identification import Fit, identify
from dehyst.io import read_log, write_csv
from dehyst.models import GROUPS, DirectInverse
from dehyst_robot.arm import Arm, ArmLog, MechanismFactory, Robot
from dehyst_robot.arm import kit as arm_kit
from dehyst_robot.experiments._calibration import (
    SPACING,
    controller_parameters,
    excite,
    home,
    known_torque,
)
from dehyst_robot.experiments._recipes import Recipe, recipe
from dehyst_robot.experiments._results import BAR, Characteristic, JointIdentification

SHEARED, ANGLE, TIME, MEAN = "sheared_torque_Nm", "angle_rad", "time_s", "mean_pressure_bar"
TORQUE = "torque_Nm"
CURVE = 5  # degree of the curve over the angle that is no loop


def identify_torque(files: Sequence[Path], chosen: Recipe) -> Fit:
    """Fit a direct inverse to logs of a joint: angle -> torque of the muscles, sheared so that it rises with the angle.

    ``dehyst identify LOG --family direct-inverse --input sheared_torque_Nm --output angle_rad`` has the same code path.
    """
    schedules = {}
    if "mean_pressure" in chosen.schedules:
        schedules["mean_pressure"] = MEAN
    records = []
    for file in files:
        records.append(read_log(file, input=SHEARED, output=ANGLE, time=TIME, schedules=schedules))
    creep: str | int = 0
    if chosen.time_constants:
        creep = "auto"
    return identify(
        records,
        DirectInverse.family,
        creep=creep,
        creep_times=chosen.time_constants or None,
        initial_state="rest",
        train_fraction=1.0,
        position_schedule=not chosen.stops_only,
        stops_only=chosen.stops_only,
    )


def unsheared(model: DirectInverse, stiffness: float, low: float, high: float) -> DirectInverse:
    """Return tau(q) = u(q) - k q: the torque of a model that was fitted to u = tau + k q.

    Parameters
    ----------
    model
        q [rad] -> u [Nm].
    stiffness
        k. [Nm/rad]
    low, high
        Range of tau in the log. [Nm]

    Examples
    --------
    >>> model = DirectInverse(radii=[0.5], stop_weights=[2.0], polynomial=[0.0, 60.0])
    >>> unsheared(model, 60.0, -1.0, 1.0).polynomial.tolist()
    [[0.0, 0.0]]
    """
    curve = np.array(model.polynomial)
    curve[:2, 0] -= stiffness * model.center  # the factors of two sets of a schedule add up to 1
    curve[:2, 1] -= stiffness
    signal = replace(model.card.input, name="torque_Nm", unit="Nm", low=low, high=high)
    return replace(model, polynomial=curve, card=replace(model.card, input=signal))


def without_time(model: DirectInverse, columns: Mapping[str, Array]) -> float:
    """Return the share of the loops that stops and path lags alone leave unexplained: std of the rest over std.

    Loops are what a curve over the angle does not explain. A joint without hysteresis has loops of creep and viscosity,
    which a direct inverse explains well; compensating them makes its largest error larger, so they do not count.

    Parameters
    ----------
    model
        q [rad] -> tau [Nm].
    columns
        A log by column name: ``angle_rad``, ``time_s``, ``torque_Nm``, ``mean_pressure_bar``.
    """
    q = columns[ANGLE]
    run = model.run(q, columns[TIME], given={"mean_pressure": columns[MEAN]})
    hysteresis = run.parts[:, [GROUPS.index(name) for name in ("short", "long")]].sum(axis=1)
    curves = np.vander((q - q.mean()) / max(float(np.ptp(q)), 1e-12), CURVE + 1)

    def loop(values: Array) -> float:
        return float(np.std(values - curves @ np.linalg.lstsq(curves, values, rcond=None)[0]))

    return loop(columns[TORQUE] - hysteresis) / max(loop(columns[TORQUE]), 1e-12)


INPUT, OUTPUT, HYSTERESIS = "sheared_bar", ANGLE, "hysteresis_bar"


def motion_of(robot: Robot, number: int, log: str) -> Array:
    """Return the angles (K,) of an identification at knots of `SPACING`: "loops", or "rates", loops first. [rad]

    Examples
    --------
    >>> from dehyst_robot.arm import load_robot
    >>> [round(motion_of(load_robot(), 1, log).size * SPACING) for log in ("loops", "rates")]
    [270, 764]
    """
    reach = robot.identification.range_share * robot.joint(number).range
    parts = [_loops(robot), *([_rates(robot)] if log == "rates" else [])]
    return np.asarray(reach * np.concatenate(parts))


def unseen_motion(robot: Robot, number: int) -> Array:
    """Return loops (K,) that no identification contains. [rad]"""
    settings = robot.identification
    reach = settings.range_share * robot.joint(number).range
    return np.asarray(reach * loops(UNSEEN_TIPS, settings.loop, settings.hold, SPACING).value)


def _loops(robot: Robot) -> Array:
    """The decaying loops twice, the second time smaller."""
    settings = robot.identification
    once = loops(settings.tips, settings.loop, settings.hold, SPACING).value
    return np.concatenate([once, settings.second_share * once])


def _rates(robot: Robot) -> Array:
    """The same few loops at several speeds with rests of several lengths: nothing else tells what depends on time."""
    settings = robot.identification
    if len(settings.strokes) != len(settings.rests):
        raise ParameterError(
            f"identification.strokes_s has {len(settings.strokes)} values and rests_s {len(settings.rests)}: the loops "
            f"are run once for every pair. Give as many of one as of the other."
        )
    motions = []
    for stroke, pause in zip(settings.strokes, settings.rests, strict=True):
        period = 2 * (stroke + pause)
        motions.append(loops(settings.rate_tips, period, pause, SPACING).value)
    return np.concatenate(motions)


@dataclass(frozen=True, eq=False)
class JointLog:
    """What was logged of a joint: columns to fit, of loops that test it, and files, also at other mean pressures."""

    fitted: Mapping[str, Array]
    unseen: Mapping[str, Array]
    files: tuple[Path, ...]


def identify_joint(
    robot: Robot,
    number: int,
    characteristic: Characteristic,
    folder: Path,
    *,
    compensator: str = "paper",
    seed: int = 0,
    mechanisms: MechanismFactory | None = None,
) -> JointIdentification:
    """Run nested loops on a joint alone, write their log, and identify a compensator from the written file.

    The input of the paper's model is the loop arranged around the diagonal, x = dp - dp_nom(q) + k q, its output q;
    dp_nom is the calibrated characteristic at the known load. ``dehyst identify LOG --input sheared_bar --output
    angle_rad --family pi --train-fraction 1`` gives the same model, bit for bit.

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
    compensator
        Its name: which motions are logged and what is identified from them.
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
    >>> from dehyst_robot.experiments import calibrate
    >>> from dehyst_robot.arm import load_robot
    >>> short = {"mean_pressures_bar": [2.2, 3.8], "loads_bar": [-0.8, 0.8], "sweep_s": 8.0, "degree": 3}
    >>> robot = load_robot(changes={"calibration": short, "identification.loop_s": 8.0, "homing.cycles": 3})
    >>> with TemporaryDirectory() as folder:
    ...     joint = identify_joint(robot, 1, calibrate(robot, 1), Path(folder))
    >>> joint.accepted, bool(joint.inverse_rms_ratio < 0.3)
    (True, True)
    """
    recipes = {compensator: (recipe(compensator), characteristic)}
    identifications = identify_compensators(
        robot, number, recipes, folder, seed=seed, mechanisms=mechanisms
    )
    return identifications[compensator]


def identify_compensators(
    robot: Robot,
    number: int,
    recipes: Mapping[str, tuple[Recipe, Characteristic]],
    folder: Path,
    *,
    seed: int = 0,
    mechanisms: MechanismFactory | None = None,
) -> dict[str, JointIdentification]:
    """Identify several compensators of a joint; those that need the same log share it.

    `recipes`: name of a compensator -> its recipe, and the joint's A, B, C as it sees them.
    """
    logs: dict[str, JointLog] = {}
    fitted: dict[tuple[object, ...], JointIdentification] = {}
    identifications = {}
    for name, (chosen, characteristic) in recipes.items():
        used, suffix = robot.with_changes(chosen.changes), _suffix(name, chosen)
        if suffix not in logs:
            rig = _Rig(used, number, characteristic, seed, mechanisms)
            logs[suffix] = _logged(rig, chosen.log, folder, suffix)
        # Recipes that ask the same of the same log share the fit.
        same = (
            suffix,
            chosen.family,
            chosen.time_constants,
            chosen.schedules,
            chosen.stops_only,
            chosen.odd,
        )
        if same not in fitted:
            fitted[same] = _identified(used, number, chosen, characteristic, logs[suffix])
        identifications[name] = fitted[same]
    return identifications


@dataclass(frozen=True)
class _Rig:
    """A joint alone, as it is put on the rig."""

    robot: Robot
    number: int
    characteristic: Characteristic
    seed: int
    mechanisms: MechanismFactory | None

    def arm(self, mean: float | None = None) -> Arm:
        """At rest in equilibrium at a mean pressure, [Pa]; without one at the controller's."""
        robot = self.robot
        if mean is not None:
            robot = robot.with_changes({"controller.mean_pressure_bar": mean / BAR})
        return Arm(
            robot,
            moving=(self.number,),
            controllers={
                self.number: controller_parameters(robot, self.number, self.characteristic)
            },
            mechanisms=arm_kit.mechanisms_of(self.mechanisms, (self.number,)),
            seed=self.seed,
        )

    def run(self, arm: Arm, angle: Array) -> Mapping[str, Array]:
        """Home, and run a motion; columns of the log as they are written."""
        characteristics = {self.number: self.characteristic}
        home(arm, characteristics)
        log = excite(arm, angle[:, None], characteristics, arm.robot.identification.sample)
        stiffness = self.characteristic.stiffness(self.robot.controller.mean_pressure)
        return _columns(arm, log, self.characteristic, stiffness)


def _suffix(name: str, chosen: Recipe) -> str:
    """Of the log's file name: compensators with the same one are fitted to the same file."""
    # Another backbone or another shear makes other columns.
    if chosen.local or chosen.changes:
        return f"_{name}"
    if chosen.log == "loops":
        return ""
    return f"_{chosen.log}"


def _logged(rig: _Rig, log: str, folder: Path, suffix: str) -> JointLog:
    """Run the motions, each after a homing, and write every log."""
    arm, motion = rig.arm(), log
    means: Sequence[float] = ()
    # Loops at other mean pressures stand beside the motion that tells what depends on time.
    if log == "pressures":
        motion, means = "rates", rig.robot.identification.mean_pressures
    stem = f"joint{rig.number}{suffix}.csv"
    fitted = rig.run(arm, motion_of(rig.robot, rig.number, motion))
    files = [write_csv(folder / f"identification_{stem}", fitted)]
    unseen = rig.run(arm, unseen_motion(rig.robot, rig.number))
    write_csv(folder / f"unseen_{stem}", unseen)
    for mean in means:
        more = rig.run(rig.arm(mean), motion_of(rig.robot, rig.number, "loops"))
        files.append(write_csv(folder / f"identification_{mean / BAR:g}bar_{stem}", more))
    return JointLog(fitted, unseen, tuple(files))


def _columns(
    arm: Arm, log: ArmLog, characteristic: Characteristic, stiffness: float
) -> Mapping[str, Array]:
    q, shear = log.measured[:, 0], arm.robot.compensator.shear / BAR
    first, second = log.pressure[:, 0, 0] / BAR, log.pressure[:, 0, 1] / BAR
    mean, difference = (first + second) / 2, first - second
    load = known_torque(arm, q[:, None])[:, 0]
    nominal = characteristic.difference(q, BAR * mean, load) / BAR
    torque = characteristic.torque(q, BAR * mean, BAR * difference) - load
    return {
        TIME: log.time,
        "pressure_1_bar": first,
        "pressure_2_bar": second,
        "pressure_difference_bar": difference,
        "nominal_difference_bar": nominal,
        HYSTERESIS: difference - nominal,
        INPUT: difference - nominal + shear * q,
        OUTPUT: q,
        MEAN: mean,
        TORQUE: torque,
        SHEARED: torque + stiffness * q,
    }


def _identified(
    robot: Robot, number: int, chosen: Recipe, characteristic: Characteristic, log: JointLog
) -> JointIdentification:
    """Fit what the recipe says to the written log, and ask it for the hysteresis of loops that it has not seen."""
    shear = robot.compensator.shear / BAR  # [bar/rad]
    direct = None
    if chosen.direct:
        fit = identify_torque(log.files, chosen)
        stiffness = characteristic.stiffness(robot.controller.mean_pressure)
        torque = log.fitted[TORQUE]
        direct = unsheared(fit.model, stiffness, float(torque.min()), float(torque.max()))
    else:
        fit = _played(robot, log.files[0], odd=chosen.odd)

    def says(columns: Mapping[str, Array]) -> Array:
        q = columns[OUTPUT]
        if direct is not None:
            run = direct.run(q, columns[TIME], given={"mean_pressure": columns[MEAN]})
            return np.asarray(run.u / (BAR * characteristic.slope(q)))
        return np.asarray(fit.model.inverse().simulate(q) - shear * q)

    unseen = log.unseen
    measured, modelled = _hysteresis(unseen), says(unseen)
    left = measured - modelled
    unexplained = float(np.std(left) / np.std(measured))
    # Creep is not hysteresis: a direct inverse is judged by its terms without time.
    if direct is not None:
        unexplained = without_time(direct, unseen)
    tested = {
        TIME: unseen[TIME],
        OUTPUT: unseen[OUTPUT],
        "hysteresis_bar": measured,
        "inverse_bar": modelled,
    }
    return JointIdentification(
        joint=number,
        characteristic=characteristic,
        log=log.fitted,
        fit=fit,
        shear=shear,
        unseen=tested,
        inverse_rms_ratio=float(np.sqrt(np.mean(left**2) / np.mean(measured**2))),
        unexplained=unexplained,
        direct=direct,
        modelled_bar=says(log.fitted),
    )


def _played(robot: Robot, file: Path, *, odd: bool = False) -> Fit:
    """The paper's model of the whole log, which other loops test; it is sheared by the k of the robot's file."""
    settings = robot.compensator
    recordings = [read_log(file, input=INPUT, output=OUTPUT, time=TIME)]
    start = "auto"
    if odd:
        # A sum of plays from zero is odd: the mirrored log has the same errors. Centre and offset of both logs together
        # are zero, the thresholds go up to max|x|, and what is minimised is twice (14).
        recordings.append(_mirrored(recordings[0]))
        start = "zero"
    return identify(
        recordings,
        family="pi",
        n=settings.operators,
        eps=settings.eps,
        initial_state=start,
        train_fraction=1.0,
    )


def _mirrored(recording: Recording) -> Recording:
    return replace(recording, input=-recording.input, output=-recording.output)


def _hysteresis(columns: Mapping[str, Array]) -> Array:
    return columns[HYSTERESIS]
