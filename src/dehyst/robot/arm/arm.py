"""The simulated arm: rigid body, pneumatic joints and their controllers in one closed loop.

Nothing here is shared with the compensator: the rigid body is MuJoCo's, the pneumatics are plant/'s. What the
controllers know of the arm they are told through `JointControllerParameters`.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, cast

import numpy as np

import dehyst.robot._native as _native
from dehyst.arrays import Array
from dehyst.errors import ParameterError
from dehyst.models import DirectInverse, HysteresisModel
from dehyst.models.block import refuse_image
from dehyst.models.model import Model
from dehyst.robot.arm.drives import Drives
from dehyst.robot.arm.mechanisms import Mechanism
from dehyst.robot.arm.parameters import Robot
from dehyst.robot.arm.rigid_body import bias_torque, inverse_dynamics
from dehyst.robot.control import Adaptation, JointControllerParameters
from dehyst.robot.control.controller import Controller, Seat, seated
from dehyst.robot.control.joint import native_controller
from dehyst.robot.control.reviewed import Law


class Arm(Drives):
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
        Joint number -> a controller of the literature, see `dehyst.robot.control.reviewed`, or a `dehyst.Controller` of
        one's own; the paper's where missing. With an `OneValveController` the joint's two valves are the two sides of
        one: both follow the same spool, mirrored. One's own is in charge while the position is controlled, and
        hears of the compensator by ``wanted.extra``; in a homing, where pressures are applied, the paper's pressure
        loops are.

    Raises
    ------
    ParameterError
        If a controller is missing, mechanisms are no pair, the seed is none, or a law is for a joint that has none.

    Examples
    --------
    Joint 1 alone, under position control, goes to 0.1 rad and holds there for 4 s:

    >>> from dehyst.robot.control import SWITCHES
    >>> from dehyst.robot.arm import Reference, load_robot
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
        laws: Mapping[int, Law | Controller] | None = None,
    ) -> None:
        self._controls: dict[int, _native.JointController] = {}
        self._compensators, self._adaptations = dict(compensators or {}), dict(adaptations or {})
        self.controllers, self._laws = dict(controllers), dict(laws or {})
        own = cast(Mapping[int, Controller], self._laws)
        super().__init__(robot, moving, seed=seed, mechanisms=mechanisms, controllers=own)
        self._believed = np.array([controllers[n].inertia if n in controllers else 0.0 for n in self.moving])

    def _driven(self, number: int, own: Controller | Law | None) -> tuple[_native.JointController, Seat | None]:
        if number not in self.controllers:
            raise ParameterError(
                f"joint {number} is pneumatic and has no controller. Pass one: "
                f"Arm(robot, controllers={{{number}: controller_parameters(robot, {number}, characteristic)}}).",
                joint=number,
            )
        told = self.controllers[number]
        if not isinstance(told, JointControllerParameters):
            raise ParameterError(
                f"controllers[{number}] is a {type(told).__name__}, not the parameters of the paper's controller, "
                f"which every joint needs for its homing. Pass one of your own as laws={{{number}: MyController()}}.",
                joint=number,
            )
        law = own if isinstance(own, Law) else None
        self._controls[number] = native_controller(
            told, self._compensators.get(number), self._adaptations.get(number), law
        )
        # Whatever is no record of the literature is asked for the methods of a controller.
        seat = None if own is None or isinstance(own, Law) else seated(own, number, self.period)
        return self._controls[number], seat

    def forget(self) -> None:
        """Tell the compensators that the joints were homed to where they are: no muscle remembers anything.

        While pressures are applied, as in a homing, a compensator hears nothing of where the joint goes. Afterwards its
        memory is set to what the decaying cycles of a homing leave: every operator is centred on the present angle. A
        direct inverse has followed the measured angle and needs no word.
        """
        for number, control in self._controls.items():
            if number not in self._compensators:
                continue
            told, seen = self.controllers[number], self.encoder_angles[self.moving.index(number)]
            spent = self._compensators[number].moved(_dying_out(seen))
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
            If a joint has another controller: only the paper's runs on machines.
        """
        if self._laws:
            law = self._laws[min(self._laws)]
            raise ParameterError(
                f"joint {min(self._laws)} has the controller '{getattr(law, 'name', type(law).__name__)}', whose state "
                f"has no image: only the paper's runs on machines. Take images of an arm without laws."
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
    def encoder_angles(self) -> Array:
        """Present angles of the moving joints as their encoders show them, (n,). [rad]"""
        step = 2 * np.pi / 2**self.robot.sensors.encoder_bits
        return np.asarray(step * np.round(self.angles / step))


def _dying_out(angle: float) -> Array:
    """Tips of cycles that decay so slowly that they wipe out whatever was remembered, evenly on both sides."""
    return np.asarray(angle + 2 * np.pi * np.append((-0.95) ** np.arange(300.0), 0.0))


def _native_model(model: Model | None) -> Any:
    return None if model is None else model.stepper().parameters
