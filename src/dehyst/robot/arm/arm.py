"""The simulated arm: rigid body, pneumatic joints and their controllers in one closed loop.

Nothing here is shared with the compensator: the rigid body is MuJoCo's, the pneumatics are plant/'s. What the
controllers know of the arm they are told through `JointControllerParameters`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from types import MappingProxyType
from typing import Any

import numpy as np
import numpy.typing as npt

import dehyst._native as _native
from dehyst.arrays import Array
from dehyst.control import Adaptation, JointControllerParameters
from dehyst.control.joint import native_controller
from dehyst.control.reviewed import Law
from dehyst.control.storage import refuse_image
from dehyst.errors import ParameterError
from dehyst.models import DirectInverse, HysteresisModel
from dehyst.models.model import Model
from dehyst.robot.arm.joints import built_plant, noise_seed, refuse_beyond
from dehyst.robot.arm.mechanisms import Mechanism
from dehyst.robot.arm.parameters import Robot
from dehyst.robot.arm.rigid_body import (
    arm_model,
    bias_torque,
    inverse_dynamics,
    joint_inertia,
    mj_step_address,
    new_data,
)

Switches = npt.NDArray[np.uint32]

SEEDS = 1 << 32
_WRONG = "angle_lost angle_jump angle_frozen pressure_lost pressure_jump pressure_frozen reference_lost supply_lost"
# Added to the switches of a knot: what goes wrong from there to the next.
FAULTS: Mapping[str, int] = MappingProxyType({name: 1 << (16 + bit) for bit, name in enumerate(_WRONG.split())})
_COLUMNS = 8  # of a reference: angle, velocity, acceleration, load, mean pressure, pressure difference, extra, hung


@dataclass(frozen=True, eq=False)
class Reference:
    """What the joints shall do, at knots of equal spacing; between them the loop interpolates.

    Attributes
    ----------
    spacing
        Time between knots, a multiple of the control period. [s]
    values
        (K, n, 8): angle [rad], velocity [rad/s], acceleration [rad/s^2], load torque that the controller knows [Nm],
        mean pressure [Pa], pressure difference [Pa], extra compensation [Pa] and torque that is hung on the joint [Nm],
        of the n moving joints.
    switches
        (K, n) what is switched on from each knot on: see `dehyst.control`; plus values of `FAULTS`, what goes
        wrong with sensors and reference until the next knot.

    Examples
    --------
    One joint, 0.2 bar more in its first muscle than in its second, for 1 s:

    >>> zero = np.zeros((101, 1))
    >>> Reference.pressures(0.01, difference=zero + 2e4, mean=zero + 3e5, hung=zero).duration
    1.0
    """

    spacing: float
    values: Array
    switches: Switches

    @classmethod
    def pressures(cls, spacing: float, difference: Array, mean: Array, hung: Array, switches: int = 0) -> Reference:
        """Pressures are applied as they are, without position control; difference, mean [Pa] and torque, (K, n)."""
        values = np.zeros((*difference.shape, _COLUMNS))
        values[:, :, 4] = mean
        values[:, :, 5] = difference
        values[:, :, 7] = hung
        return cls(spacing, values, np.full(difference.shape, switches, np.uint32))

    @classmethod
    def motion(
        cls,
        spacing: float,
        motion: tuple[Array, Array, Array],
        load: Array,
        mean: float,
        switches: int | Switches,
        extra: Array | float = 0.0,
        hung: Array | float = 0.0,
    ) -> Reference:
        """Position control along angle, velocity and acceleration, each (K, n), with the load torque (K, n)."""
        values = np.zeros((*load.shape, _COLUMNS))
        for column, signal in enumerate((*motion, load)):
            values[:, :, column] = signal
        values[:, :, 4] = mean
        values[:, :, 6] = extra
        values[:, :, 7] = hung
        return cls(spacing, values, np.broadcast_to(np.asarray(switches, np.uint32), load.shape))

    @property
    def duration(self) -> float:
        """From the first to the last knot. [s]"""
        return float(self.spacing * (self.values.shape[0] - 1))

    def sampled(self, period: float) -> Reference:
        """Return the same reference with a knot at every control period, to the bit as the loop interpolates it.

        Cubic in the angle with the given velocities at the knots, linear in everything else.

        Examples
        --------
        >>> coarse = Reference.pressures(0.01, *(np.linspace(0.0, 1.0, 3)[:, None] for _ in range(3)))
        >>> coarse.sampled(0.0025).values[:, 0, 5].tolist()
        [0.0, 0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1.0]
        """
        ticks = round(self.spacing / period)
        span = period * ticks
        count = (self.values.shape[0] - 1) * ticks
        knot = np.arange(count) // ticks
        s = (np.arange(count) % ticks / ticks)[:, None]
        a, b = self.values[knot], self.values[knot + 1]
        u, s2 = 1 - s, s * s
        values = u[..., None] * a + s[..., None] * b
        q_a, v_a, q_b, v_b = a[..., 0], a[..., 1], b[..., 0], b[..., 1]
        values[..., 0] = (
            (1 + 2 * s) * u * u * q_a + s * u * u * span * v_a + s2 * (3 - 2 * s) * q_b - s2 * u * span * v_b
        )
        values[..., 1] = 6 * s * u * (q_b - q_a) / span + u * (1 - 3 * s) * v_a + s * (3 * s - 2) * v_b
        return Reference(period, np.concatenate([values, self.values[-1:]]), self.switches[[*knot, -1]])


@dataclass(frozen=True, eq=False)
class ArmLog:
    """What was logged in one run: rows (T,), the n moving joints (T, n), SI units.

    Attributes
    ----------
    time
        From the start of the run. [s]
    desired, angle
        Reference and true angle at the time of the row. [rad]
    measured
        Encoder, mean over the row's interval. [rad]
    torque
        Of the drive. [Nm]
    pressure
        (T, n, 2) measured gauge pressures, mean over the row's interval. [Pa]
    pressure_difference, compensation
        Desired dp and the compensator's part of it. [Pa]
    integrator, torque_desired, load
        Integrator's part, desired torque, observed disturbance. [Nm]
    contact, doubt
        What of the disturbance a direct inverse does not explain, and what its torque can be wrong by. [Nm]
    hysteresis, offset
        What there is of the hysteresis over that of the compensator's model, 1 until it is known; torque beyond the
        model that is the same both ways. [Nm]
    scale, scales
        Of the compensator while its model does not fit; of the groups of a direct inverse, (T, n, groups), in use.
    flags
        Flags of the controllers, collected since the row before.
    """

    time: Array
    desired: Array
    angle: Array
    measured: Array
    torque: Array
    pressure: Array
    pressure_difference: Array
    compensation: Array
    integrator: Array
    torque_desired: Array
    load: Array
    contact: Array
    doubt: Array
    hysteresis: Array
    offset: Array
    scale: Array
    scales: Array
    flags: npt.NDArray[np.int64]

    @classmethod
    def unpack(cls, time: Array, log: Array) -> ArmLog:
        """From the loop's own order of columns, (T, n, 25)."""
        column = np.moveaxis(log, 2, 0)
        return cls(
            time, column[0], column[1], column[2], column[3], log[:, :, 4:6], column[6], column[7], column[8],
            column[9], column[10], column[11], column[12], column[14], column[15], column[16], log[:, :, 17:],
            column[13].astype(np.int64),
        )  # fmt: skip

    def until(self, end: float) -> ArmLog:
        """Return the rows before a time. [s]"""
        kept = int(np.searchsorted(self.time, end))
        return ArmLog(**{column.name: getattr(self, column.name)[:kept] for column in fields(self)})


class Arm:
    """The arm, or some of its joints with the others locked at their zero pose.

    Parameters
    ----------
    robot
        Parameters, from `load_robot`.
    moving
        Numbers of the joints that move, increasing; None: all.
    controllers
        Joint number -> what its controller knows; one for every moving pneumatic joint.
    compensators
        Joint number -> inverse model q -> x, or direct inverse q -> torque, for the built-in compensator; none where
        missing.
    adaptations
        Joint number -> how its direct inverse learns, where that is switched on; defaults where missing.
    mechanisms
        Joint number -> two foreign hysteresis mechanisms, one a muscle, instead of the built-in one.
    seed
        Of the sensors' noise and the muscles' tolerances: same seed, same bits.
    laws
        Joint number -> a controller of the literature, see `dehyst.control.reviewed`; the paper's where missing. With
        an `OneValveController` the joint's two valves are the two sides of one: both follow the same spool, mirrored.

    Raises
    ------
    ParameterError
        If a controller is missing, mechanisms are no pair, the seed is none, or a law is for a joint that has none.

    Examples
    --------
    Joint 1 alone, under position control, goes to 0.1 rad and holds there for 4 s:

    >>> from dehyst.control import SWITCHES
    >>> from dehyst.robot.arm import load_robot
    >>> arm = Arm(load_robot(), moving=(1,), controllers={1: JointControllerParameters()})
    >>> goal, zero = np.full((401, 1), 0.1), np.zeros((401, 1))
    >>> on = SWITCHES["position"] | SWITCHES["integrator"]
    >>> log = arm.run(Reference.motion(0.01, (goal, zero, zero), zero, 3e5, on), every_s=0.1)
    >>> bool(abs(log.angle[-1, 0] - 0.1) < 0.01)
    True
    """

    def __init__(
        self,
        robot: Robot,
        *,
        moving: tuple[int, ...] | None = None,
        controllers: Mapping[int, JointControllerParameters],
        compensators: Mapping[int, HysteresisModel | DirectInverse] | None = None,
        adaptations: Mapping[int, Adaptation] | None = None,
        mechanisms: Mapping[int, tuple[Mechanism, Mechanism]] | None = None,
        seed: int = 0,
        laws: Mapping[int, Law] | None = None,
    ) -> None:
        moving = tuple(robot.joints) if moving is None else moving
        _refuse_lawless(laws or {}, robot, moving)
        if not 0 <= seed < SEEDS:
            raise ParameterError(f"seed = {seed} is none. Pass a whole number from 0 to {SEEDS - 1}.", seed=seed)
        self.robot = robot
        self.moving = moving
        self.model = arm_model(robot, moving=moving, fused=True)
        self.data = new_data(self.model)
        self._plants: dict[int, _native.PneumaticJoint] = {}
        self._controls: dict[int, _native.JointController] = {}
        self._compensated: dict[int, tuple[_native.JointController, HysteresisModel | DirectInverse]] = {}
        self.controllers = dict(controllers)
        self._laws = dict(laws or {})
        self.seed = seed
        self._believed = np.array([controllers[n].inertia if n in controllers else 0.0 for n in moving])
        period = robot.simulation.period
        self._loop = _native.ClosedLoop(
            mj_step_address(), self.model._address, self.data._address,
            self.data.qpos, self.data.qvel, self.data.qfrc_applied, period,
        )  # fmt: skip
        inertia = joint_inertia(self.model)
        for index, number in enumerate(moving):
            if robot.joint(number).drive == "electric":
                pole = robot.electric_pole
                self._loop.add_electric(inertia[index] * pole**2, 2 * inertia[index] * pole, inertia[index])
                continue
            if number not in controllers:
                raise ParameterError(
                    f"joint {number} is pneumatic and has no controller. Pass one: "
                    f"Arm(robot, controllers={{{number}: controller_parameters(robot, {number}, characteristic)}}).",
                    joint=number,
                )
            plant = built_plant(robot, number, seed, (mechanisms or {}).get(number, ()))
            model = (compensators or {}).get(number)
            control = native_controller(
                controllers[number], model, (adaptations or {}).get(number), (laws or {}).get(number)
            )
            self._loop.add_pneumatic(plant, control)
            self._controls[number] = control
            if model is not None:
                self._compensated[number] = (control, model)
            self._plants[number] = plant
        self.reset()

    def reset(self) -> None:
        """At rest in the zero pose, every muscle at the mean pressure, nothing remembered."""
        self.data.qpos[:] = 0
        self.data.qvel[:] = 0
        self.data.qfrc_applied[:] = 0
        mean = self.robot.controller.mean_pressure
        for number, plant in self._plants.items():
            plant.reset(0.0, mean, mean, noise_seed(self.seed, number))
        self._loop.reset_controllers(False)

    def forget(self) -> None:
        """Tell the compensators that the joints were homed to where they are: no muscle remembers anything.

        While pressures are applied, as in a homing, a compensator hears nothing of where the joint goes. Afterwards its
        memory is set to what the decaying cycles of a homing leave: every operator is centred on the present angle. A
        direct inverse has followed the measured angle and needs no word.
        """
        for number, (control, model) in self._compensated.items():
            told = self.controllers[number]
            spent = model.moved(_dying_out(self.angles[self.moving.index(number)]))
            if spent is not None:
                control.exchange(_native_model(spent), told.compensator_unit, told.shear)

    def restart(self) -> None:
        """Switch the controllers on anew, where the joints are: they know nothing of the past."""
        self._loop.reset_controllers(True)

    def learned(self, number: int) -> Array:
        """Scales in use of the groups of a joint's direct inverse, (groups,); empty without one."""
        return np.array(self._controls[number].applied)

    def learned_extremes(self, number: int) -> tuple[float, float, float, bool]:
        """Lowest and highest scale, largest |offset| [Nm] at any period so far, and whether all were finite."""
        return self._loop.learned(self.moving.index(number))

    def images(self) -> dict[int, bytes]:
        """Return images of the controllers' states, as a machine stores them before it is switched off.

        Raises
        ------
        ParameterError
            If a joint has a controller of the literature: only the paper's runs on machines.
        """
        if self._laws:
            raise ParameterError(
                f"joint {min(self._laws)} has the controller '{self._laws[min(self._laws)].name}', whose state has no "
                f"image: only the paper's runs on machines. Take images of an arm without laws."
            )
        return {number: control.save() for number, control in self._controls.items()}

    def restore(self, images: Mapping[int, bytes]) -> None:
        """Go on with the stored states of controllers.

        Raises
        ------
        ParameterError
            If an image is damaged or of another controller.
        """
        for number, image in images.items():
            refuse_image(self._controls[number].restore(image), "Restore only what images() of an equal arm returned.")

    def run(self, reference: Reference, every_s: float) -> ArmLog:
        """Run the closed loop along a reference from where it is, logging a row every `every_s` seconds.

        Raises
        ------
        ParameterError
            If the reference does not belong to these joints or to the control period, or is not finite.
        SimulationError
            If a joint went so far beyond its range that neither muscles nor stops are simulated there.
        """
        period = self.robot.simulation.period
        ticks = self._ticks(reference, every_s)
        every = max(1, round(every_s / period))
        log = self._loop.run(
            np.ascontiguousarray(reference.values),
            np.ascontiguousarray(reference.switches),
            ticks,
            every,
        )
        found = ArmLog.unpack(np.asarray(np.arange(log.shape[0]) * (every * period)), log)
        refuse_beyond(self.robot, self.moving, np.vstack([found.angle, self.data.qpos]))
        return found

    def _ticks(self, reference: Reference, every_s: float) -> int:
        """Control periods from knot to knot."""
        period, shape = self.robot.simulation.period, np.shape(reference.values)
        if len(shape) != 3 or shape[0] < 2 or shape[1:] != (len(self.moving), _COLUMNS):
            raise ParameterError(
                f"a reference of shape {shape} does not belong to the {len(self.moving)} moving joints {self.moving}: "
                f"pass two knots or more, (K, {len(self.moving)}, {_COLUMNS}).",
                shape=shape,
            )
        if np.shape(reference.switches) != shape[:2]:
            raise ParameterError(
                f"switches of shape {np.shape(reference.switches)} for {shape[0]} knots of {shape[1]} joints: pass one "
                f"a knot and joint, {shape[:2]}.",
                shape=np.shape(reference.switches),
            )
        if not np.isfinite(reference.values).all():
            knot = int(np.flatnonzero(~np.isfinite(reference.values).all(axis=(1, 2)))[0])
            raise ParameterError(
                f"the reference is not finite at knot {knot}: the arm cannot be told to go there. Remove the NaN.",
                knot=knot,
            )
        ticks = round(reference.spacing / period) if np.isfinite(reference.spacing) else 0
        if ticks < 1 or abs(ticks * period - reference.spacing) > 1e-6 * reference.spacing:
            raise ParameterError(
                f"knots lie {reference.spacing} s apart, which is no multiple of the control period, {period} s: the "
                f"arm would run at another speed. Choose another spacing, or a simulation.period_s that divides it.",
                spacing=reference.spacing,
                period=period,
            )
        if not every_s > 0:
            raise ParameterError(f"a row every {every_s} s is no log. Pass a positive time.", every_s=every_s)
        return ticks

    def gravity(self, angles: Array) -> Array:
        """Torque that holds the arm still at angles (K, n) against gravity, exactly. [Nm]"""
        return bias_torque(self.model, angles)

    def feedforward(self, angles: Array, velocities: Array, accelerations: Array) -> Array:
        """Load torque (K, n) for `Reference.motion`: the nominal rigid body's without the joint's own inertia torque.

        Inertia and weight are wrong by the shares that the [controller] table names; the controllers add the inertia
        torque of their own joint themselves. [Nm]
        """
        control = self.robot.controller
        weight = self.gravity(angles)
        motion = inverse_dynamics(self.model, angles, velocities, accelerations) - weight
        own = accelerations * self._believed
        return np.asarray((1 + control.inertia_error) * motion + (1 + control.gravity_error) * weight - own)

    @property
    def angles(self) -> Array:
        """Present angles of the moving joints as their encoders show them, (n,). [rad]"""
        step = 2 * np.pi / 2**self.robot.sensors.encoder_bits
        return np.asarray(step * np.round(np.array(self.data.qpos) / step))


def _refuse_lawless(laws: Mapping[int, Law], robot: Robot, moving: Sequence[int]) -> None:
    wrong = [number for number in laws if number not in moving or number not in robot.pneumatic]
    if wrong:
        raise ParameterError(
            f"a law for joint {wrong[0]}, which {'has no muscles' if wrong[0] in moving else 'does not move'}. Joints "
            f"that can have one: {tuple(n for n in moving if n in robot.pneumatic)}.",
            joint=wrong[0],
        )


def _dying_out(angle: float) -> Array:
    """Tips of cycles that decay so slowly that they wipe out whatever was remembered, evenly on both sides."""
    return np.asarray(angle + 2 * np.pi * np.append((-0.95) ** np.arange(300.0), 0.0))


def _native_model(model: Model | None) -> Any:
    return None if model is None else model.stepper().parameters
