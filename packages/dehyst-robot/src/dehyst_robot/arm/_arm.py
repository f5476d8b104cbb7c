"""The simulated arm: rigid body, pneumatic joints and their controllers in one closed loop.

The plant shares nothing with the compensator: MuJoCo computes the rigid body, and the C code of plant/ the pneumatics.
Controllers know of the arm only what `JointControllerParameters` holds.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, cast

import numpy as np

import dehyst_robot._native as _native
from dehyst.arrays import Array
from dehyst.errors import ParameterError
from dehyst.models import DirectInverse, HysteresisModel, Model
from dehyst.models import kit as models_kit
from dehyst_robot.arm._drives import Drives
from dehyst_robot.arm._mechanisms import Mechanism
from dehyst_robot.arm._parameters import Robot
from dehyst_robot.arm._rigid_body import bias_torque, inverse_dynamics
from dehyst_robot.control import Adaptation, Controller, JointControllerParameters, Law, Seat
from dehyst_robot.control import kit as control_kit


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
        Joint number -> a controller of the literature, see `dehyst_robot.control._reviewed`, or a user-defined
        `dehyst_robot.Controller`; the paper's where missing. With an `OneValveController` the joint's two valves are
        the two sides of one: both follow the same spool, mirrored. A user-defined controller acts while the position is
        controlled, and gets the compensator's part as ``reference.extra``. In a homing, which applies
        pressures, the paper's pressure loops act.

    Raises
    ------
    ParameterError
        If a controller is missing, mechanisms are no pair, the seed is none, or a law is for a joint that has none.

    Examples
    --------
    Joint 1 alone, under position control, goes to 0.1 rad and holds there for 4 s:

    >>> from dehyst_robot.control import SWITCHES
    >>> from dehyst_robot.arm import Reference, load_robot
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
        self._compensators = dict(compensators or {})
        self._adaptations = dict(adaptations or {})
        self.controllers = dict(controllers)
        self._laws = dict(laws or {})
        # `_driven`, below, takes laws of the literature too.
        user_controllers = cast(Mapping[int, Controller], self._laws)
        super().__init__(
            robot, moving, seed=seed, mechanisms=mechanisms, controllers=user_controllers
        )
        self._believed_inertia = np.zeros(len(self.moving))
        for index, number in enumerate(self.moving):
            if number in controllers:
                self._believed_inertia[index] = controllers[number].inertia

    def _driven(
        self, number: int, controller: Controller | Law | None
    ) -> tuple[_native.JointController, Seat | None]:
        if number not in self.controllers:
            raise ParameterError(
                f"joint {number} is pneumatic and has no controller. Pass one: "
                f"Arm(robot, controllers={{{number}: controller_parameters(robot, {number}, characteristic)}}).",
                joint=number,
            )
        parameters = self.controllers[number]
        if not isinstance(parameters, JointControllerParameters):
            raise ParameterError(
                f"controllers[{number}] is a {type(parameters).__name__}, not the parameters of the paper's "
                f"controller, which every joint needs for its homing. Pass one of your own as "
                f"laws={{{number}: MyController()}}.",
                joint=number,
            )
        law = controller if isinstance(controller, Law) else None
        native = control_kit.native_controller(
            parameters, self._compensators.get(number), self._adaptations.get(number), law
        )
        self._controls[number] = native
        if controller is None or isinstance(controller, Law):
            return native, None
        # Anything that is no law of the literature must have the methods of a controller.
        return native, control_kit.seated(controller, number, self.period)

    def forget(self) -> None:
        """Set the memory of the compensators to what a homing leaves: every operator is centred on the present angle.

        While pressures are applied, as in a homing, a compensator does not follow the joint. A direct inverse follows
        the measured angle all the time and keeps its memory.
        """
        for number, control in self._controls.items():
            if number not in self._compensators:
                continue
            angle = self.encoder_angles[self.moving.index(number)]
            homed = self._compensators[number].moved(_decaying_tips(angle))
            if homed is not None:
                parameters = self.controllers[number]
                control.exchange(
                    _native_model(homed), parameters.compensator_unit, parameters.shear
                )

    def restart(self) -> None:
        """Switch the controllers on again, with the joints where they are: they forget the past."""
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
            number = min(self._laws)
            law = self._laws[number]
            name = getattr(law, "name", type(law).__name__)
            raise ParameterError(
                f"joint {number} has the controller '{name}', whose state has no image: only the paper's runs on "
                f"machines. Take images of an arm without laws."
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
            models_kit.refuse_image(
                self._controls[number].restore(image),
                "Restore only what images() of an equal arm returned.",
            )

    def gravity(self, angles: Array) -> Array:
        """Torque that holds the arm still at angles (K, n) against gravity, exactly. [Nm]"""
        return bias_torque(self.model, angles)

    def feedforward(self, angles: Array, velocities: Array, accelerations: Array) -> Array:
        """Load torque (K, n) for `Reference.motion`: the nominal rigid body's without the joint's own inertia torque.

        Inertia and weight are wrong by the shares that the [controller] table names; the controllers add the inertia
        torque of their own joint themselves. [Nm]
        """
        control = self.robot.controller
        # Weight and inertia are separated, because each has an error of its own.
        weight = self.gravity(angles)
        motion = inverse_dynamics(self.model, angles, velocities, accelerations) - weight
        # The controller adds the inertia torque that it believes in; what it adds is not given twice.
        by_controller = accelerations * self._believed_inertia
        load = (1 + control.inertia_error) * motion + (1 + control.gravity_error) * weight
        return np.asarray(load - by_controller)

    @property
    def encoder_angles(self) -> Array:
        """Present angles of the moving joints as their encoders show them, (n,). [rad]"""
        # One count of an encoder that divides a turn into 2^bits.
        step = 2 * np.pi / 2**self.robot.sensors.encoder_bits
        return np.asarray(step * np.round(self.angles / step))


def _decaying_tips(angle: float) -> Array:
    """Return the tips of cycles that decay slowly enough to erase the memory, evenly on both sides of an angle."""
    # From a whole turn down by 5 % a tip: no joint moves as far, and no threshold lies between two tips.
    return np.asarray(angle + 2 * np.pi * np.append((-0.95) ** np.arange(300.0), 0.0))


def _native_model(model: Model | None) -> Any:
    if model is None:
        return None
    return model.stepper().parameters
