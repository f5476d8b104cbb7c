"""Calibrates the static joint characteristic Q = A(q) p_m + B(q) dp + C(q) by slow sweeps.

Before any measurement a controller has nominal parameters: data sheets, with deliberate errors. Homing, sweeps and
identification loops are quasi-static runs with commanded pressures. A characteristic turns a target angle into a
pressure difference: that shapes the excitation, it does not control the angle. Where the joint really goes is measured.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from dehyst.arrays import Array
from dehyst.design import decaying_cycles, triangle_sweep
from dehyst.errors import ParameterError, SimulationError
from dehyst_robot.arm import Arm, ArmLog, MechanismFactory, Reference, Robot, arm_model
from dehyst_robot.arm import kit as arm_kit
from dehyst_robot.control import FLAGS, SWITCHES, JointControllerParameters, Pneumatics
from dehyst_robot.experiments._policy import POLICY
from dehyst_robot.experiments._results import BAR, Characteristic

# Bench fit of a DMSP-40 (another source than the plant's map): F = (a1 p + a2) exp(a3 k) + a4 k p + a5 p + a6, p in Pa.
BENCH = (0.0002, 369.27, -37.51, -0.0304, 0.0093, -546.02)
BENCH_VOLUME = (
    1.2566e-3  # of that muscle per length [m^2]; smaller muscles are scaled by their cross section
)
DEGREE = 5
VOLUME_DEGREE = 3  # of a chamber's volume in the controller
OBSERVER_RATIO = 8.0  # an observer is this much faster than the loop that it serves


def nominal_characteristic(robot: Robot, number: int) -> Characteristic:
    """Characteristic from a published bench map, another one than the plant has: good enough to plan sweeps."""
    joint = robot.joint(number)
    q = np.linspace(-joint.range, joint.range, 81)
    r, s = (np.polynomial.polynomial.polyval(q, arm) for arm in arm_kit.moment_arms(robot, number))
    passive = nominal_forces(robot, number, q, np.zeros((q.size, 2)))
    slope = (nominal_forces(robot, number, q, np.full((q.size, 2), BAR)) - passive) / BAR
    parts = (  # r F_1 + s F_2 as in packages/dehyst-robot/plant/joint.c; on a pulley r + s = 0
        r * (slope[:, 0] - slope[:, 1]) + (r + s) * slope[:, 1],
        r * slope.sum(axis=1) / 2 - (r + s) * slope[:, 1] / 2,
        r * (passive[:, 0] - passive[:, 1]) + (r + s) * passive[:, 1],
    )
    a, b, c = (np.polynomial.polynomial.polyfit(q, y, DEGREE) for y in parts)
    return Characteristic(a, b, c, float(q[0]), float(q[-1]), 0.0)


def nominal_forces(robot: Robot, number: int, angle: Array, pressure: Array) -> Array:
    """Forces (T, 2) of a joint's muscles at angles (T,) and gauge pressures (T, 2) by the same bench map. [N]

    That of a spring is its own.
    """
    joint = robot.joint(number)
    a1, a2, a3, a4, a5, a6 = BENCH
    muscles = robot.muscles_of(number)
    arms = arm_kit.moment_arms(robot, number)
    contractions = []
    for arm, muscle in zip(arms, muscles, strict=True):
        contraction = arm_kit.contraction(arm, muscle.length, joint.middle)
        contractions.append(contraction(angle))
    k = np.stack(contractions, axis=1)
    scale = joint.parallel * np.array([muscle.volume[0] / BENCH_VOLUME for muscle in muscles])
    force = np.asarray(
        scale * ((a1 * pressure + a2) * np.exp(a3 * k) + a4 * k * pressure + a5 * pressure + a6)
    )
    if joint.sprung:
        force[:, 1] = joint.spring_preload - joint.spring * muscles[1].length * (
            k[:, 1] - joint.middle
        )
    return force


def controller_parameters(
    robot: Robot, number: int, characteristic: Characteristic
) -> JointControllerParameters:
    """Parameters of a joint's controller: calibrated characteristic, nominal geometry, inertia, valve and air.

    Parameters
    ----------
    robot
        Its [controller] table says by how much inertia and valve are believed to differ from the truth.
    number
        Of the joint.
    characteristic
        A, B, C of that joint.
    """
    joint, control = robot.joint(number), robot.controller
    valve = robot.valve(joint.valve)
    inertia = arm_kit.joint_inertia(arm_model(robot))[number - 1]
    volumes = []
    for arm, muscle in zip(
        arm_kit.moment_arms(robot, number), robot.muscles_of(number), strict=True
    ):
        kappa = arm_kit.contraction(arm, muscle.length, joint.middle)
        volume = (
            np.polynomial.Polynomial(muscle.length * np.asarray(muscle.volume)) + muscle.dead_volume
        )(kappa)
        if volume.degree() > VOLUME_DEGREE:
            q = np.linspace(-joint.range, joint.range, 81)
            volume = np.polynomial.Polynomial.fit(q, volume(q), VOLUME_DEGREE).convert()
        volumes.append(tuple(map(float, joint.parallel * np.asarray(volume.coef, np.float64))))
    air = robot.air
    return JointControllerParameters(
        period=robot.simulation.period,
        inertia=float(inertia * (1 + control.inertia_error)),
        pole=joint.pole or control.pole,
        observer_pole=max(control.observer_pole, OBSERVER_RATIO * (joint.pole or control.pole)),
        pressure_gain=control.pressure_gain,
        windup_gain=control.windup_gain,
        a=tuple(characteristic.a),
        b=tuple(characteristic.b),
        c=tuple(characteristic.c),
        volume=(volumes[0], volumes[1]),
        angle_low=characteristic.low,
        angle_high=characteristic.high,
        pressure_low=control.pressure_low,
        pressure_high=control.pressure_high,
        ramp=control.ramp,
        shear=0.0,
        compensator_unit=BAR,
        pneumatics=Pneumatics(
            supply=air.supply,
            ambient=air.ambient,
            gas_temperature=air.gas_constant * air.temperature,
            polytropic=air.polytropic,
            reference_density=air.reference_density,
            conductance=valve.conductance * (1 + control.conductance_error),
            ratio=valve.ratio,
            dead_band=valve.dead_band,
        ),
        angle_jump=control.angle_jump,
        angle_step=2 * np.pi / 2**robot.sensors.encoder_bits,
        pressure_jump=control.pressure_jump,
        frozen_samples=control.frozen_samples,
        hold_samples=control.hold_samples,
    )


SPACING = 0.01  # of the knots of a pressure reference [s]
QUIET_S = 2.0  # after homing, for what still rings


def known_torque(arm: Arm, angles: Array, hung: Array | float = 0.0) -> Array:
    """Torque (K, n) that the drives must give at rest: nominal gravity less what is hung on the joints. [Nm]"""
    return np.asarray(arm.gravity(angles) * (1 + arm.robot.controller.gravity_error) - hung)


def pressure_room(robot: Robot, mean: Array | float) -> Array:
    """Largest |dp| that keeps both muscles within their limits at this mean pressure. [Pa]"""
    control = robot.controller
    return np.asarray(2.0 * np.minimum(mean - control.pressure_low, control.pressure_high - mean))


def excite(
    arm: Arm,
    targets: Array,
    characteristics: Mapping[int, Characteristic],
    every_s: float,
    mean: Array | None = None,
    hung: Array | None = None,
    switches: int = 0,
) -> ArmLog:
    """Run the pressure differences that belong to target angles.

    Parameters
    ----------
    arm
        Where it is.
    targets
        (K, n) angles at knots of `SPACING`. [rad]
    characteristics
        Joint number -> what turns an angle into a pressure difference; other joints stand still.
    every_s
        Of the log. [s]
    mean
        (K, n) mean pressures; None: the controller's. [Pa]
    hung
        (K, n) known torques on the joints; None: none. [Nm]
    switches
        What is on besides: ``SWITCHES["adapt"]`` lets direct inverses learn.

    Raises
    ------
    SimulationError
        If a controller failed safe on the way: the log would be of a joint that is switched off.
    """
    if mean is None:
        mean = np.full(targets.shape, arm.robot.controller.mean_pressure)
    if hung is None:
        hung = np.zeros(targets.shape)
    torque = known_torque(arm, targets, hung)
    difference = np.zeros(targets.shape)
    for i, number in enumerate(arm.moving):
        if number in characteristics:
            asked = characteristics[number].difference(targets[:, i], mean[:, i], torque[:, i])
            room = pressure_room(arm.robot, mean[:, i])
            difference[:, i] = np.clip(asked, -room, room)
    log = arm.run(Reference.pressures(SPACING, difference, mean, hung, switches), every_s)
    refuse_failed(arm, log)
    return log


def refuse_failed(arm: Arm, log: ArmLog) -> None:
    """Refuse a log in which a controller failed safe: from there on it is of a joint that is switched off."""
    failed = (log.flags & FLAGS["failed"]) != 0
    if failed.any():
        row = int(np.argmax(failed.any(axis=1)))
        column = int(np.argmax(failed[row]))
        number, when = arm.moving[column], float(log.time[row])
        raise SimulationError(
            f"the controller of joint {number} failed safe at {when:.1f} s: {_why_failed(arm, log, row, column)}",
            joint=number,
            time=when,
        )


def _why_failed(arm: Arm, log: ArmLog, row: int, column: int) -> str:
    """Which reading was not credible, what had happened before, and what to change."""
    robot, flags = arm.robot, int(log.flags[row, column])
    control, sensors = robot.controller, robot.sensors
    before = (log.time >= log.time[row] - 1.0) & (log.time <= log.time[row])
    limited = (log.flags[before, column] & (FLAGS["valve-limit"] | FLAGS["pressure-limit"])) != 0
    controller = arm.controllers[arm.moving[column]]
    for_long = f"for more than {control.hold_samples} samples"
    if flags & FLAGS["angle-fault"]:
        frozen_s = control.frozen_samples * arm.robot.simulation.period
        last_angles = log.measured[before & (log.time > log.time[row] - frozen_s), column]
        if len(last_angles) >= POLICY.still_rows and np.ptp(last_angles) < controller.angle_step:
            return (
                f"its angle stood still for {control.frozen_samples} samples while its model foretold a motion: the "
                f"encoder is lost, or the model is not that of the joint. Calibrate it, or raise "
                f"controller.frozen_samples."
            )
        jump = np.degrees(controller.angle_jump)
        reading = (
            f"{for_long} its angle was further than {jump:.3g} deg from what its model foretells"
        )
        if controller.angle_jump < controller.angle_step:
            return f"{reading}. A step of its encoder alone is larger: raise controller.angle_jump_deg."
        cure = "Calibrate the joint as it is now, take off what it does not know of, or raise controller.angle_jump_deg"
    else:
        muscles = [str(k) for k in (1, 2) if flags & FLAGS[f"pressure-fault-{k}"]]
        jump = controller.pressure_jump / BAR
        reading = (
            f"{for_long} pressure {' and '.join(muscles)} changed by more than {jump:.3g} bar a period, "
            f"or showed the same {control.frozen_samples} times"
        )
        noise = sensors.pressure_noise / BAR
        if jump < POLICY.above_noise * noise:
            return (
                f"{reading}. The sensor's noise alone, {noise:.3g} bar rms, does that: raise "
                f"controller.pressure_jump_bar."
            )
        cure = "Raise controller.pressure_jump_bar or frozen_samples"
    if limited.mean() > POLICY.overloaded:
        return (
            f"{reading}. In the second before, valves or pressures were at their limits in "
            f"{100 * limited.mean():.0f} % of the time: its loop oscillates, or more pulls than its muscles can. "
            f"Lower joint.{arm.moving[column]}"
            f".pole_1_s (without it controller.pole_1_s), payload.mass_kg or the speed."
        )
    return f"{reading}. {cure}."


def home(arm: Arm, characteristics: Mapping[int, Characteristic]) -> ArmLog:
    """Decaying cycles of all pneumatic joints at once: afterwards the memory of muscles and compensators is spent."""
    return _homed(arm, characteristics, 0)


def home_from_zero(arm: Arm, characteristics: Mapping[int, Characteristic]) -> ArmLog:
    """Home, and leave the states of the compensators at zero, equation (13), wherever the homing ended."""
    return _homed(arm, characteristics, 0, forget=False)


def home_and_learn(arm: Arm, characteristics: Mapping[int, Characteristic]) -> ArmLog:
    """Home while direct inverses learn what their actuators have become: the cycles excite every term."""
    return _homed(arm, characteristics, SWITCHES["adapt"])


def _homed(
    arm: Arm,
    characteristics: Mapping[int, Characteristic],
    switches: int,
    *,
    forget: bool = True,
) -> ArmLog:
    homing = arm.robot.homing
    cycle = decaying_cycles(homing.cycles, homing.decay, homing.period, SPACING).value
    cycle = np.concatenate([cycle, np.zeros(round(QUIET_S / SPACING))])
    share = np.zeros(len(arm.moving))
    for k, n in enumerate(arm.moving):
        # Only joints with a characteristic can be led.
        if n in characteristics:
            share[k] = homing.range_share * arm.robot.joint(n).range
    targets, log = cycle[:, None] * share, None
    try:
        log = excite(arm, targets, characteristics, every_s=0.05, switches=switches)
        _refuse_astray(arm, characteristics)
    except SimulationError as fault:
        cause = _cause(arm, targets, characteristics, log)
        if cause is None:
            raise
        raise SimulationError(f"the homing failed: {cause}", **fault.facts) from fault
    if forget:
        arm.forget()
    return log


def _refuse_astray(arm: Arm, characteristics: Mapping[int, Characteristic]) -> None:
    for number, angle in zip(arm.moving, arm.encoder_angles, strict=True):
        limit = POLICY.astray * arm.robot.joint(number).range
        if number in characteristics and abs(angle) > limit:
            raise SimulationError(
                f"the homing ended with joint {number} at {np.degrees(angle):.1f} deg, more than "
                f"{np.degrees(limit):.1f} deg from the middle: what its muscles remember is not known. Its "
                f"characteristic is not that of the joint, or a sensor of pressure is off: calibrate it anew.",
                joint=number,
            )


def _cause(
    arm: Arm, targets: Array, characteristics: Mapping[int, Characteristic], log: ArmLog | None
) -> str | None:
    """What a rig's builder would look for first: a load, the supply; None if it is neither."""
    robot = arm.robot
    mean, torque = robot.controller.mean_pressure, known_torque(arm, targets)
    room = pressure_room(robot, mean)
    for i, number in enumerate(arm.moving):
        if number not in characteristics:
            continue
        asked = np.abs(characteristics[number].difference(targets[:, i], mean, torque[:, i])).max()
        if asked > room:
            return (
                f"what hangs on joint {number} takes up to {np.abs(torque[:, i]).max():.0f} Nm, for which its muscles "
                f"would need {asked / BAR:.1f} bar of pressure difference; at a mean pressure of {mean / BAR:.2g} bar "
                f"they have {room / BAR:.1f}. Take load off (payload.mass_kg, link masses) or lower homing.range_share."
            )
        short = 0.0 if log is None else mean - float(log.pressure[-len(log.time) // 4 :, i].mean())
        if short > POLICY.missing_pressure:
            return (
                f"the muscles of joint {number} got {(mean - short) / BAR:.1f} bar in the mean of {mean / BAR:.2g} bar "
                f"asked: the supply does not keep up. Raise air.supply_bar, air.supply_conductance_l_s_bar or the "
                f"valve's conductance_l_s_bar, or home more slowly (homing.period_s)."
            )
    return None


APPROACH_S = 5.0  # pressures and the hung weight are brought to the beginning of a sweep
LOG_S = 0.05
TORQUE_DEGREE = 2  # of 1/B: three loads do not tell more


def calibrate(
    robot: Robot, number: int, *, seed: int = 0, mechanisms: MechanismFactory | None = None
) -> Characteristic:
    """Sweep a joint slowly up and down at several mean pressures and known loads, and fit A, B and C.

    The joint moves alone. Fitted is

    .. math:: dp = Q \\beta(q) - p_m \\alpha(q) - \\gamma(q), \\qquad
              B = 1/\\beta, \\; A = \\alpha/\\beta, \\; C = \\gamma/\\beta

    and not Q over dp: the hysteresis sits in dp, and as a regressor it would make B too small (by 8 % with loads of
    20 Nm and a hysteresis of 6 Nm). Sweeps in both directions make it cancel.

    Parameters
    ----------
    robot
        Its [calibration] table.
    number
        Of the joint.
    seed
        Of the noise and the muscles' tolerances.
    mechanisms
        Makes hysteresis mechanisms of one's own, instead of the robot's.

    Returns
    -------
    characteristic : Characteristic

    Raises
    ------
    ParameterError
        If muscles are slack almost everywhere.
    SimulationError
        If the joint's controller failed safe during a sweep.

    Examples
    --------
    A short calibration; the file's own takes three mean pressures, three loads and sweeps of 24 s:

    >>> from dehyst_robot.arm import load_robot
    >>> short = {"mean_pressures_bar": [2.2, 3.8], "loads_bar": [-0.8, 0.8], "sweep_s": 8.0, "degree": 3}
    >>> found = calibrate(load_robot(changes={"calibration": short}), 1)
    >>> round(1e5 * found.b[0])  # B(0): torque of a bar of pressure difference [Nm/bar]
    29
    """
    plan = nominal_characteristic(robot, number)
    arm = Arm(
        robot,
        moving=(number,),
        # What is planned from data sheets is no measure of an angle: a joint in its play or hysteresis stands still
        # while weights are changed, and the plan says that it moves.
        controllers={
            number: replace(
                controller_parameters(robot, number, plan), angle_jump=0.0, frozen_samples=0
            )
        },
        mechanisms=arm_kit.mechanisms_of(mechanisms, (number,)),
        seed=seed,
    )
    settings = robot.calibration
    unit = float(plan.b[0])  # torque that a pressure difference gives at zero [Nm/Pa]
    sweep = triangle_sweep(settings.sweep, SPACING).value
    half = settings.range_share * robot.joint(number).range
    before = (half * float(sweep[-1]), robot.controller.mean_pressure, 0.0)
    half = half * _stretch(arm, plan, half * sweep)
    sweeps = []
    for mean, load in itertools.product(settings.mean_pressures, settings.loads):
        after = (half * sweep[0], mean, load * unit)
        levels = (half * sweep, np.full(sweep.size, mean), np.full(sweep.size, load * unit))
        signals = []
        # Angle, pressure and load go from the last sweep to this one without a jump.
        for old, new, level in zip(before, after, levels, strict=True):
            way = _blend(old, new, APPROACH_S)
            signals.append(np.concatenate([way, level])[:, None])
        target, means, hung = signals
        log = excite(arm, target, {number: plan}, LOG_S, means, hung)
        sweeps.append(_usable(robot, number, arm, log, load * unit))
        before = (float(target[-1, 0]), mean, load * unit)
    sweeps = [sweep for sweep in sweeps if sweep.shape[0]]
    _refuse_too_few(number, sum(sweep.shape[0] for sweep in sweeps), settings.degree)
    return fit_characteristic(sweeps, settings.degree)


def _refuse_too_few(number: int, samples: int, degree: int) -> None:
    unknowns = TORQUE_DEGREE + 1 + 2 * (degree + 1)
    if samples < 10 * unknowns:
        raise ParameterError(
            f"the sweeps of joint {number} left {samples} samples in which both muscles are tight, for {unknowns} "
            f"coefficients: no characteristic follows from so few. Raise calibration.mean_pressures_bar or sweep_s, or "
            f"lower range_share.",
            joint=number,
            samples=samples,
        )


def _blend(start: float, end: float, duration: float) -> Array:
    """A smooth way between two values at knots of `SPACING`."""
    u = np.linspace(0.0, 1.0, round(duration / SPACING), endpoint=False)
    return np.asarray(start + (end - start) * u**3 * (10 - 15 * u + 6 * u**2))


def _stretch(arm: Arm, plan: Characteristic, targets: Array) -> float:
    """How much further the plan must reach for the joint to get where it shall: one trial sweep tells."""
    begin = _blend(0.0, float(targets[0]), APPROACH_S)
    log = excite(arm, np.concatenate([begin, targets])[:, None], {arm.moving[0]: plan}, LOG_S)
    reached = float(np.ptp(log.measured[log.time > APPROACH_S]))
    return float(
        np.clip(
            np.ptp(targets) / max(reached, 1e-6), 1 / POLICY.largest_stretch, POLICY.largest_stretch
        )
    )


def _usable(robot: Robot, number: int, arm: Arm, log: ArmLog, hung: float) -> Array:
    """Rows (T, 4) of a sweep: q, dp, p_m, Q; without the approach and without samples where a muscle may be slack.

    A slack muscle is outside of Q = A p_m + B dp + C. Which sample is, the data sheet tells.
    """
    q, pressure = log.measured[:, 0], log.pressure[:, 0]
    mean = np.full((1, 2), robot.controller.mean_pressure)
    usual_force = nominal_forces(robot, number, np.zeros(1), mean).mean()
    tight = nominal_forces(robot, number, q, pressure).min(axis=1) > POLICY.slack * usual_force
    usable = (log.time >= APPROACH_S) & tight
    torque = known_torque(arm, q[:, None], hung)[:, 0]
    rows = np.stack([q, pressure[:, 0] - pressure[:, 1], pressure.mean(axis=1), torque], axis=1)
    return np.asarray(rows[usable])


def fit_characteristic(sweeps: list[Array], degree: int) -> Characteristic:
    """Fit A, B and C to sweeps, each (T, 4): q [rad], dp [Pa], p_m [Pa], Q [Nm].

    Examples
    --------
    >>> q, dp, load = (x.ravel() for x in np.meshgrid(np.linspace(-0.6, 0.6, 25), [0.0], [-20.0, 0.0, 20.0]))
    >>> law = [(p, (load + 60e-5 * q * p + 4 * q) / 35e-5) for p in (2e5, 3e5)]
    >>> sweeps = [np.stack([q, dp, np.full(q.size, p), load], axis=1) for p, dp in law]
    >>> found = fit_characteristic(sweeps, 3)
    >>> round(float(found.b[0]) * 1e5, 3), round(float(found.a[1]) * 1e5, 3), round(float(found.c[1]), 3)
    (35.0, -60.0, -4.0)
    """
    q, dp, mean, torque = np.concatenate(sweeps).T
    k, m = TORQUE_DEGREE + 1, degree + 1
    power = q[:, None] ** np.arange(degree + 1)
    scale = (10.0, 1e5)  # torques of 10 Nm, pressures of 1 bar: columns of one size
    regressors = np.hstack(
        [power[:, :k] * (torque / scale[0])[:, None], -power * (mean / scale[1])[:, None], -power]
    )
    coefficients, *_ = np.linalg.lstsq(regressors, dp / scale[1], rcond=None)
    low, high = float(q.min()), float(q.max())
    grid = np.linspace(low, high, 201)
    parts = np.split(coefficients, [k, k + m])
    beta, alpha, gamma = (np.polynomial.polynomial.polyval(grid, part) for part in parts)
    beta = beta * scale[1] / scale[0]  # [Pa/Nm]
    fit = np.polynomial.polynomial.polyfit
    a, b = fit(grid, alpha / beta, degree), fit(grid, 1 / beta, degree)
    c = fit(grid, gamma * scale[1] / beta, degree)
    value = np.polynomial.polynomial.polyval
    residual = torque - value(q, a) * mean - value(q, b) * dp - value(q, c)
    return Characteristic(a, b, c, low, high, float(np.sqrt(np.mean(residual**2))), tuple(sweeps))
