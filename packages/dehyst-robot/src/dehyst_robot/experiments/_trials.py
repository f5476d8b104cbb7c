"""The three trials on the ISO 9283 path: fast, slow, and slow without integrator; iterative learning along it."""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.errors import ParameterError
from dehyst_robot.arm import Arm, ArmLog, Reference, Robot, arm_model
from dehyst_robot.arm import kit as arm_kit
from dehyst_robot.control import SWITCHES, Compensator, JointControllerParameters, along
from dehyst_robot.experiments._calibration import refuse_failed
from dehyst_robot.experiments._equipment import Equipment
from dehyst_robot.experiments._output import joint_figures
from dehyst_robot.experiments._path import PlannedPath
from dehyst_robot.experiments._policy import POLICY
from dehyst_robot.experiments._results import TRIALS, TrialRun
from dehyst_robot.iso9283 import Timed, Timing

POSITION, INTEGRATOR = SWITCHES["position"], SWITCHES["integrator"]
COMPENSATOR, ADAPT = SWITCHES["compensator"], SWITCHES["adapt"]
Value = TypeVar("Value")


SETTLE_S = 1.0  # position control holds where the homing ended
APPROACH_S = 4.0  # from there to the start of the path
REST_S = 1.0  # and rests
LOG_S = (
    0.01,
    0.02,
)  # of the fast and of the slow trials: the tool moves by 3 mm from row to row at most
POSES = 120  # of the animation
SLOW = ("slow", "slow_no_integrator")


def run_trial(
    robot: Robot,
    path: PlannedPath,
    equipment: Equipment,
    trial: str,
    compensator: str,
    moving: tuple[int, ...] | None = None,
) -> tuple[TrialRun, float]:
    """Home the arm, bring it to the path, and follow the path with the compensators on or off.

    Parameters
    ----------
    robot
        The arm and its settings.
    path
        Joint angles of the tool's path and their timing.
    equipment
        Controllers, compensators, plants.
    trial
        "fast", "slow" or "slow_no_integrator".
    compensator
        "off", or the name under which the compensators of `equipment` are switched on.
    moving
        Joints that move, None: all; the others are locked at zero and the tool goes elsewhere.

    Returns
    -------
    run : TrialRun
    real_time_factor : float
        Simulated time over wall time, homing included.

    Raises
    ------
    ParameterError
        If there is no such trial, or `equipment` names a joint that cannot have what it gives it.
    OutputError
        If a compensator of one's own answers with something that is not a finite number.
    SimulationError
        If a controller failed safe, or a joint left the range that it is simulated in.

    Examples
    --------
    Joint 1 alone, with what its data sheets tell and no calibration:

    >>> from dehyst_robot.experiments import equip
    >>> from dehyst_robot.experiments import nominal_characteristic
    >>> from dehyst_robot.experiments import plan_path
    >>> from dehyst_robot.arm import load_robot
    >>> robot = load_robot(changes={"path.cycles_fast": 1, "homing.cycles": 3})
    >>> equipment = equip(robot, {1: nominal_characteristic(robot, 1)}, {})
    >>> run, _ = run_trial(robot, plan_path(robot), equipment, "fast", "off", moving=(1,))
    >>> run.error.shape[1], bool(np.abs(run.error[:, 0]).max() < np.radians(5.0))
    (7, True)
    """
    # One arm for all passes: its muscles keep their memory.
    arm = trial_arm(robot, equipment, trial, moving)
    return follow_path(arm, path, equipment, trial, compensator)


def trial_arm(
    robot: Robot, equipment: Equipment, trial: str, moving: tuple[int, ...] | None = None
) -> Arm:
    """Return the arm of a trial, equipped, at rest at zero; parameters and errors are those of `run_trial`."""
    _check(robot, equipment, trial)
    moving = tuple(robot.joints) if moving is None else moving
    return Arm(
        robot,
        moving=moving,
        controllers=equipment.controllers,
        compensators=equipment.compensators,
        adaptations=equipment.adaptations,
        mechanisms=arm_kit.mechanisms_of(
            equipment.mechanisms, [n for n in moving if n in robot.pneumatic]
        ),
        seed=equipment.seed,
        laws=_of_joints(equipment.laws, moving),
    )


def _of_joints(values: Mapping[int, Value], joints: tuple[int, ...]) -> dict[int, Value]:
    """What there is for these joints."""
    return {number: value for number, value in values.items() if number in joints}


def _columns(joints: tuple[int, ...]) -> list[int]:
    """Columns of joints in tables of all joints, which are numbered from 1."""
    return [number - 1 for number in joints]


def follow_path(
    arm: Arm, path: PlannedPath, equipment: Equipment, trial: str, compensator: str
) -> tuple[TrialRun, float]:
    """Run a trial on an arm from where it is; again on the same arm it is another pass, with other noise."""
    robot, moving = arm.robot, arm.moving
    motion = trial_motion(robot, path, trial)
    cycles = robot.path.cycles_fast
    if trial in SLOW:
        cycles = robot.path.cycles_slow
    switches = trial_switches(robot, moving, trial, compensator, equipment.adaptations)
    begin = time.perf_counter()
    equipment.history(arm, equipment.characteristics)
    hung = np.array([equipment.loads.get(number, 0.0) for number in moving])
    own = {}
    if compensator != "off":
        own = _of_joints(equipment.own, moving)
    # The feedforward is that of the robot as it is known.
    feedforward = arm.feedforward
    if equipment.known:
        feedforward = trial_arm(equipment.known, equipment, trial, moving).feedforward
    approach = _approach(arm, path, hung, feedforward)
    parts = approach, _path(arm, path, motion, cycles, hung, feedforward)
    approach, along_path = _with_extra(arm, parts, motion, equipment, own)
    mean = robot.controller.mean_pressure
    refuse_failed(arm, arm.run(approach.reference(mean, switches), every_s=1.0))
    log = arm.run(along_path.reference(mean, switches), every_s=LOG_S[trial in SLOW])
    refuse_failed(arm, log)
    log = log.until(cycles * motion.duration)  # the reference ends at a knot, a little later
    spent = time.perf_counter() - begin
    homing_s = robot.homing.cycles * robot.homing.period
    simulated = homing_s + approach.duration + along_path.duration
    torque_error = _torque_error(arm, along_path, equipment, log)
    run = _trial_run(arm, motion, log, torque_error, trial, compensator, equipment.missed)
    for text in run.warnings:
        warnings.warn(
            f"{trial} trial, compensator '{compensator}', {text}", UserWarning, stacklevel=2
        )
    return run, simulated / spent


def _check(robot: Robot, equipment: Equipment, trial: str) -> None:
    if trial not in TRIALS:
        raise ParameterError(f"no trial '{trial}'. There are: {', '.join(TRIALS)}.", trial=trial)
    _check_joints("own compensators", equipment.own, robot.pneumatic)
    _check_joints("laws", equipment.laws, robot.pneumatic)
    _check_joints("loads", equipment.loads, tuple(robot.joints))


def _check_joints(kind: str, numbers: Collection[int], allowed: tuple[int, ...]) -> None:
    unknown = sorted(set(numbers) - set(allowed))
    if unknown:
        raise ParameterError(
            f"{kind} for joint {unknown[0]}, which can have none. Joints that can: {allowed}.",
            joint=unknown[0],
        )


def trial_motion(robot: Robot, path: PlannedPath, trial: str) -> Timing:
    """The command motion of a trial: the path's own, or `slow_factor` times as long."""
    timing: Timing = path.timing
    if trial in SLOW:
        return timing.slower(robot.path.slow_factor)
    return timing


def trial_switches(
    robot: Robot,
    moving: tuple[int, ...],
    trial: str,
    compensator: str,
    adaptive: Collection[int] = (),
) -> npt.NDArray[np.uint32]:
    """What is on in each joint; those that get no compensator keep their integrator in the trial without it."""
    # Position and integrator are always on but where the trial says otherwise.
    switches = np.full(len(moving), POSITION | INTEGRATOR, np.uint32)
    if trial == "slow_no_integrator":
        switches[[number in robot.compensated for number in moving]] = POSITION
    if compensator != "off":
        switches |= np.uint32(COMPENSATOR)
        switches[[number in adaptive for number in moving]] |= np.uint32(ADAPT)
    return switches


def _knots(robot: Robot, motion: Timing, cycles: int) -> Array:
    """Times of the reference's knots: 4 ms apart on a fast cycle of 20 s, coarser as the motion is slower."""
    period = robot.simulation.period
    spacing = period * max(1, round(motion.duration / 5000 / period))
    return np.asarray(spacing * np.arange(int(np.ceil(cycles * motion.duration / spacing)) + 1))


def _of(moving: tuple[int, ...], motion: tuple[Array, Array, Array]) -> tuple[Array, Array, Array]:
    """Columns of the moving joints."""
    columns = _columns(moving)
    angle, velocity, acceleration = motion
    return angle[:, columns], velocity[:, columns], acceleration[:, columns]


def _repeated(times: Array, duration: float, once: Array, values: Array) -> Array:
    """Values (K, n) of one cycle at the times of all: inverse dynamics costs more than everything else here."""
    # The path repeats itself, so do its torques.
    phase = np.mod(times, duration)
    repeated = np.empty((times.size, values.shape[1]))
    for k, column in enumerate(values.T):
        repeated[:, k] = np.interp(phase, once, column, period=duration)
    return repeated


@dataclass(frozen=True, eq=False)
class _Part:
    """A part of a run at knots of equal spacing: motion, load that the controller knows, what is hung on, (K, n)."""

    spacing: float
    motion: tuple[Array, Array, Array]
    load: Array
    hung: Array
    extra: Array | float = 0.0

    @property
    def duration(self) -> float:
        return float(self.spacing * (self.load.shape[0] - 1))

    def reference(self, mean: float, switches: npt.NDArray[np.uint32]) -> Reference:
        return Reference.motion(
            self.spacing, self.motion, self.load, mean, switches, self.extra, self.hung
        )


def _approach(arm: Arm, path: PlannedPath, hung: Array, feedforward: Callable[..., Array]) -> _Part:
    """Rest where the homing ended, then move to the start of the path, jerk-limited, and rest there."""
    spacing = 0.01
    start, end = arm.encoder_angles, path.start[_columns(arm.moving)]
    t = spacing * np.arange(round((SETTLE_S + APPROACH_S + REST_S) / spacing) + 1)
    u = np.clip((t - SETTLE_S) / APPROACH_S, 0.0, 1.0)
    rise = u**3 * (10 - 15 * u + 6 * u**2)
    speed = 30 * u**2 * (1 - u) ** 2 / APPROACH_S
    rate = 60 * u * (1 - u) * (1 - 2 * u) / APPROACH_S**2
    way = end - start
    motion = (start + rise[:, None] * way, speed[:, None] * way, rate[:, None] * way)
    return _Part(spacing, motion, feedforward(*motion), rise[:, None] * hung)


def _path(
    arm: Arm,
    path: PlannedPath,
    motion: Timing,
    cycles: int,
    hung: Array,
    feedforward: Callable[..., Array],
) -> _Part:
    """The path, as often as asked for."""
    times = _knots(arm.robot, motion, cycles)
    # The knots of the first cycle.
    once = times[times <= motion.duration]
    load = feedforward(*_of(arm.moving, path.motion(motion, once)))
    return _Part(
        float(times[1]),
        _of(arm.moving, path.motion(motion, times)),
        _repeated(times, motion.duration, once, load),
        np.broadcast_to(hung, (times.size, hung.size)),
    )


def _with_extra(
    arm: Arm,
    parts: tuple[_Part, _Part],
    motion: Timing,
    equipment: Equipment,
    own: Mapping[int, Compensator],
) -> tuple[_Part, _Part]:
    """Add what compensators of the user say, which hear the whole desired motion, and what was learned on the path."""
    learned = _of_joints(equipment.learned, arm.moving)
    if not own and not learned:
        return parts
    first, second = parts
    cut, knots = first.load.shape[0], second.load.shape[0]
    extra = np.zeros((cut + knots, len(arm.moving)))
    angle = np.concatenate([first.motion[0], second.motion[0]])
    velocity = np.concatenate([first.motion[1], second.motion[1]])
    # The second part begins where the first ends; its knots are told one later, for time to increase.
    approach_time = first.spacing * np.arange(cut)
    path_time = first.duration + second.spacing * np.arange(1, knots + 1)
    time = np.concatenate([approach_time, path_time])
    for number, compensator in own.items():
        index = arm.moving.index(number)
        extra[:, index] = along(compensator, angle[:, index], velocity[:, index], time)
    for number, torque in learned.items():
        index = arm.moving.index(number)
        # All of it at the start of the path, and nothing before the arm moves.
        rise = np.linspace(0.0, 1.0, cut)
        phase = np.mod(second.spacing * np.arange(knots), motion.duration)
        on_path = np.interp(phase, np.linspace(0.0, motion.duration, torque.size), torque)
        slope = equipment.characteristics[number].slope(angle[:, index])
        extra[:, index] += np.concatenate([rise * torque[0], on_path]) / slope
    return replace(first, extra=extra[:cut]), replace(second, extra=extra[cut:])


def _torque_error(arm: Arm, part: _Part, equipment: Equipment, log: ArmLog) -> Array:
    """Torque (T, n) of the inverse dynamics along the desired motion, less that of the pressures by the model in use.

    The model in use is the characteristic, and while the compensator is on the compensator besides: what neither
    explains is left to the feedback. [Nm]
    """
    knots = part.spacing * np.arange(part.load.shape[0])
    error = np.zeros_like(log.integrator)
    for k, number in enumerate(arm.moving):
        # An electric joint has no pressures.
        if number not in equipment.characteristics:
            continue
        first, second = log.pressure[:, k, 0], log.pressure[:, k, 1]
        # The compensator's part balances the hysteresis, and so gives no torque.
        difference = first - second - log.compensation[:, k]
        torque = equipment.characteristics[number].torque(
            log.measured[:, k], (first + second) / 2, difference
        )
        # The controller adds the torque of the joint's own inertia to the load.
        asked = equipment.controllers[number].inertia * part.motion[2][:, k] + part.load[:, k]
        error[:, k] = np.interp(log.time, knots, asked) - torque
    return error


def _trial_run(
    arm: Arm,
    motion: Timing,
    log: ArmLog,
    torque_error: Array,
    trial: str,
    compensator: str,
    missed: Mapping[int, float],
) -> TrialRun:
    """Columns of all joints from those that moved; locked ones stand at zero."""
    columns = _columns(arm.moving)

    def full(values: npt.NDArray[Any]) -> npt.NDArray[Any]:
        wide = np.zeros((values.shape[0], len(arm.robot.joints), *values.shape[2:]), values.dtype)
        wide[:, columns] = values
        return wide

    angle, desired = full(log.angle), full(log.desired)
    model = arm_model(arm.robot)
    # A path knows where its tool should be; of motions of joints the arm tells.
    tool_desired = arm_kit.tool_positions(model, desired)
    if isinstance(motion, Timed):
        tool_desired = motion.position(log.time)
    # Poses for the moving picture, of the first cycle.
    in_cycle = np.flatnonzero(log.time <= motion.duration)
    poses = in_cycle[np.linspace(0, in_cycle.size - 1, min(POSES, in_cycle.size)).astype(int)]
    return TrialRun(
        trial=trial,
        compensator=compensator,
        seed=arm.seed,
        time=log.time,
        desired=desired,
        angle=angle,
        integrator=full(log.integrator),
        torque_error=full(torque_error),
        pressure_difference=full(log.pressure_difference),
        compensation=full(log.compensation),
        pressure=full(log.pressure),
        tool_desired=tool_desired,
        tool=arm_kit.tool_positions(model, angle),
        figure=motion.figure(log.time),
        figures=motion.figure_names,
        cycle=motion.cycle(log.time),
        flags=full(log.flags),
        contact=full(log.contact),
        doubt=full(log.doubt),
        hysteresis=full(log.hysteresis),
        offset=full(log.offset),
        scale=full(log.scale),
        scales=full(log.scales),
        frames=arm_kit.joint_positions(model, angle[poses]),
        frame_time=log.time[poses],
        missed=missed,
    )


CUTOFF_HZ = 3.0  # of the filter: beyond, the pressure loops and the nominal inertia are not known well enough
KNOTS_HZ = 25.0  # of what is learned


def learned_trial(
    robot: Robot,
    path: PlannedPath,
    equipment: Equipment,
    trial: str,
    compensator: str,
    moving: tuple[int, ...] | None = None,
    *,
    passes: int = 0,
) -> tuple[TrialRun, float]:
    """Run a trial, then again up to `passes` times with a torque learned from the pass before; return the best.

    All passes are on one arm, each homed again, so that only what comes again is learned, and no noise.

    A pass is kept if the rms errors of the learning joints, each over what it was at first, fall in the sum of their
    squares, and no joint is worse than at first, in rms or largest error. Else it is forgotten and the step halved:
    what is returned is never worse than the first run, whatever the plant does.

    Parameters
    ----------
    robot, path, equipment, trial, compensator, moving
        As for `run_trial`; learning joints are those with a compensator in `equipment`.
    passes
        Most repetitions; 0: none, and nothing is learned.
    """
    arm = trial_arm(robot, equipment, trial, moving)
    best, speed = follow_path(arm, path, equipment, trial, compensator)
    joints = tuple(n for n in equipment.compensators if n in arm.moving)
    if not joints:
        return best, speed
    step, learned = 1.0, dict(equipment.learned)
    first = {n: _size(best, n) for n in joints}
    for _ in range(passes):
        tried = {}
        for n in joints:
            change = learned_torque(robot, best, equipment.controllers[n], n)
            tried[n] = learned.get(n, 0.0) + step * change
        run, _ = follow_path(arm, path, replace(equipment, learned=tried), trial, compensator)
        # The next pass learns from the better run.
        if _better(run, best, first):
            best, learned = run, tried
            continue
        step *= 0.5
        if step < POLICY.least_step:
            break
    return best, speed


def learned_torque(
    robot: Robot, run: TrialRun, controller: JointControllerParameters, number: int
) -> Array:
    r"""Return the torque (K,) [Nm] along a cycle of the path that would have made the error of a joint disappear.

    What the position law answered to the error e, and the inertia torque that was missing,

    .. math:: \Delta Q = F\bigl[M(\ddot e + 3 \lambda \dot e + 3 \lambda^2 e) + I\bigr],

    over the angle as the encoder shows it, the mean of all cycles, F a filter without phase: of a log.
    """
    # The encoder's step is no error that could be learned.
    tick = 2 * np.pi / 2**robot.sensors.encoder_bits
    column = number - 1
    error = run.desired[:, column] - tick * np.round(run.angle[:, column] / tick)
    spacing = float(run.time[1] - run.time[0])
    width = 1.0 / (2 * np.pi * CUTOFF_HZ * spacing)  # of a Gaussian with that cut-off, in samples
    smooth, rate, bend = (_filtered(error, width, order) / spacing**order for order in range(3))
    pole, inertia = controller.pole, controller.inertia
    torque = inertia * (bend + 3 * pole * rate + 3 * pole**2 * smooth) + _filtered(
        run.integrator[:, column], width, 0
    )
    cycles = int(run.cycle.max()) + 1
    duration = (run.time[-1] + spacing) / cycles
    knots = np.linspace(0.0, duration, round(duration * KNOTS_HZ) + 1)
    by_cycle = np.interp(knots + duration * np.arange(cycles)[:, None], run.time, torque)
    return np.asarray(np.mean(by_cycle, axis=0))


def _filtered(values: Array, width: float, order: int) -> Array:
    """Gaussian filter of a width in samples, or its derivative; ends are mirrored at their own value."""
    reach = int(np.ceil(4 * width)) + 1
    x = np.arange(-reach, reach + 1) / width
    bell = np.exp(-0.5 * x**2)
    bell /= bell.sum()
    shape = (bell, -x / width * bell, (x**2 - 1) / width**2 * bell)[order]
    # A derivative of a constant is zero, to the last bit that the cut bell spoils.
    if order:
        shape = shape - shape.mean()
    before = 2 * values[0] - values[reach:0:-1]
    after = 2 * values[-1] - values[-2 : -reach - 2 : -1]
    return np.convolve(np.concatenate([before, values, after]), shape, mode="valid")


def _size(run: TrialRun, number: int) -> tuple[float, float]:
    figures = joint_figures(run, number)
    return figures["rms_deg"], figures["max_deg"]


def _better(run: TrialRun, best: TrialRun, first: Mapping[int, tuple[float, float]]) -> bool:
    """Whether a run has smaller errors than the best, and no joint larger ones than at first."""
    run_sum, best_sum = 0.0, 0.0
    for n, (first_rms, first_max) in first.items():
        rms, largest = _size(run, n)
        if rms > first_rms or largest > first_max:
            return False
        if first_rms > 0:
            run_sum += (rms / first_rms) ** 2
            best_sum += (_size(best, n)[0] / first_rms) ** 2
    return run_sum < best_sum
