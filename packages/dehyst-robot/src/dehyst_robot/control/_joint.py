"""The controller of a joint with two antagonistic muscles: parameters, references, outputs."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from types import MappingProxyType
from typing import Any, cast

import numpy as np
import numpy.typing as npt

import dehyst_robot._native as _native
from dehyst.arrays import Array
from dehyst.errors import ParameterError, UnitError
from dehyst.models import DirectInverse, HysteresisModel, Schedule
from dehyst.models import kit as models_kit
from dehyst.units import MASS_FACTORS, TABLE, canonical
from dehyst_robot.control._compensator import PLAYS, refuse_second_shear
from dehyst_robot.control._parameters import Adaptation, JointControllerParameters
from dehyst_robot.control._reviewed import Law, law_parameters

DIRECT = "direct"  # form of the models that are one
# Signals that the controller passes to the model, in the order of the core.
GIVEN = ("mean_pressure", "load")
# No joint has more, and its powers are still finite numbers in a stored state. [rad], [Nm]
LARGEST = 1e6
SI = {"mean_pressure": "pressure", "load": "torque"}


def in_si(model: DirectInverse) -> DirectInverse:
    """Return a joint's model in rad, Nm and Pa: the same function of the converted signals.

    A signal without a unit counts as one in SI.

    Raises
    ------
    UnitError
        If its y is no angle, its u no torque, or a schedule in no unit of its size.
    ParameterError
        If it is scheduled by something that the controller does not know.

    Examples
    --------
    >>> from dehyst.models import ModelCard, SignalCard
    >>> card = ModelCard(SignalCard("torque", "Nm"), SignalCard("angle", "deg"))
    >>> model = DirectInverse(radii=[90.0], stop_weights=[1.0], card=card)
    >>> in_si(model).radii.round(6).tolist()
    [1.570796]
    """
    angle = _factor(model.card.output.unit, "angle", f"its output {model.card.output.label}")
    torque = _factor(model.card.input.unit, "torque", f"its input {model.card.input.label}")
    schedules = tuple(_schedule(schedule, angle) for schedule in model.schedules)
    gain = torque / angle
    # Coefficient k of the polynomial is a torque over the k-th power of an angle.
    powers = torque / angle ** np.arange(model.polynomial.shape[1])
    # The card names the units, and so changes with them.
    card = model.card
    output_card = replace(
        card.output,
        unit="rad",
        low=_times(card.output.low, angle),
        high=_times(card.output.high, angle),
    )
    input_card = replace(
        card.input,
        unit="Nm",
        low=_times(card.input.low, torque),
        high=_times(card.input.high, torque),
    )
    # A model in SI keeps its card, and with it its checksum.
    if angle == 1.0 and torque == 1.0 and schedules == model.schedules:
        return model
    return replace(
        model,
        radii=model.radii * angle,
        path_lengths=model.path_lengths * angle,
        stop_weights=model.stop_weights * gain,
        path_weights=model.path_weights * gain,
        creep_weights=model.creep_weights * gain,
        viscous=model.viscous * gain,
        polynomial=model.polynomial * powers,
        center=model.center * angle,
        schedules=schedules,
        card=replace(card, input=input_card, output=output_card),
    )


def direct_parameters(model: DirectInverse, period: float) -> tuple[Any, ...]:
    """Return the parameters of the core's joint: the model in SI, its schedules in the order of `GIVEN`.

    A joint that is not at rest may come from anywhere: the strokes of a log say nothing about it.
    """
    si = in_si(model)
    if si.past != "rest":
        si = si.with_past(models_kit.UNKNOWN)
    return si.parameters(period, GIVEN, LARGEST)


def _times(value: float | None, factor: float) -> float | None:
    if value is None:
        return None
    return value * factor


def _schedule(schedule: Schedule, angle: float) -> Schedule:
    # A schedule that is not from outside is one of the model's own angle.
    if not schedule.outside:
        return replace(schedule, low=schedule.low * angle, high=schedule.high * angle, unit="rad")
    if schedule.name not in GIVEN:
        raise ParameterError(
            f"the model is scheduled by '{schedule.name}', which no joint controller knows; it gives "
            f"{' and '.join(GIVEN)}. Identify with --mean-pressure or --load.",
            schedule=schedule.name,
        )
    dimension = SI[schedule.name]
    factor = _factor(schedule.unit, dimension, f"its schedule '{schedule.name}'")
    return replace(
        schedule, low=schedule.low * factor, high=schedule.high * factor, unit=_unit(dimension)
    )


def _unit(dimension: str) -> str:
    return next(iter(TABLE[dimension]))  # the first one is that of SI


def _factor(unit: str, dimension: str, signal: str) -> float:
    """Return the factor from a unit to SI; 1 for none, and for texts that are no unit."""
    if not unit:
        return 1.0
    name = canonical(unit)
    if not name and unit in MASS_FACTORS:
        name = unit
    if not name:
        return 1.0
    if name not in TABLE[dimension]:
        raise UnitError(
            f"the direct inverse of a joint maps an angle to a torque, but {signal} is in {unit}, which is no "
            f"{dimension}. Identify it from the torque A(q) p_m + B(q) dp + C(q) - load, as `dehyst reproduce` does.",
            unit=unit,
        )
    return TABLE[dimension][name]


SWITCHES: Mapping[str, int] = MappingProxyType(
    {
        "position": _native.POSITION,
        "integrator": _native.INTEGRATOR,
        "compensator": _native.COMPENSATOR,
        "adapt": _native.ADAPT,
        "disturbance": _native.DISTURBANCE,
    }
)
"""Terms that can be switched, by name: add the values, ``SWITCHES["position"] | SWITCHES["integrator"]``."""

FLAGS: Mapping[str, int] = MappingProxyType(dict(_native.JOINT_FLAGS))
"""Bits of `JointOutput.flags` by name."""


@dataclass(frozen=True)
class JointReference:
    """Reference of a joint for one period, with the load that is known.

    Parameters
    ----------
    angle, velocity, acceleration
        q_d [rad] and its derivatives [rad/s], [rad/s^2].
    load
        Q_load: torque of gravity and coupling at the reference. [Nm]
    mean_pressure
        p_m, gauge. [Pa]
    pressure_difference
        dp that is applied while position control is off. [Pa]
    extra
        Compensator's term from outside, added to the built-in one and switched with it. [Pa]
    """

    angle: float = 0.0
    velocity: float = 0.0
    acceleration: float = 0.0
    load: float = 0.0
    mean_pressure: float = 3e5
    pressure_difference: float = 0.0
    extra: float = 0.0

    def as_tuple(self) -> tuple[float, float, float, float, float, float, float]:
        """Return the values in the order of the core."""
        return (
            self.angle,
            self.velocity,
            self.acceleration,
            self.load,
            self.mean_pressure,
            self.pressure_difference,
            self.extra,
        )


@dataclass(frozen=True)
class JointOutput:
    """Outputs of the controller in one period, or arrays (T,) of them.

    Attributes
    ----------
    valve_1, valve_2
        Commands to both valves, -1..1; positive fills the muscle.
    desired_1, desired_2
        Desired pressures after limits, gauge. [Pa]
    pressure_difference
        dp_d before limits. [Pa]
    torque
        Q_d of the position law; while position control is off, the torque of the characteristic at dp_d. [Nm]
    integrator
        I, the integrator's part of it. [Nm]
    compensation
        The compensator's part of dp_d. [Pa]
    angle, velocity
        Observed q and its derivative. [rad], [rad/s]
    load
        Observed torque beyond the characteristic and Q_load, with the sign of Q_load. [Nm]
    contact
        Part of it that a direct inverse as compensator does not explain either; 0 without one. [Nm]
    doubt
        Largest error of the direct inverse's torque while the joint's past is unknown. [Nm]
    flags
        Sum of the bits in `FLAGS`.
    """

    valve_1: Any
    valve_2: Any
    desired_1: Any
    desired_2: Any
    pressure_difference: Any
    torque: Any
    integrator: Any
    compensation: Any
    angle: Any
    velocity: Any
    load: Any
    contact: Any
    doubt: Any
    flags: Any

    def raised(self, flag: str) -> Any:
        """Return whether a flag of `FLAGS` is up, sample by sample if the outputs are arrays."""
        return (self.flags & FLAGS[flag]) != 0


class JointController:
    """Controller of one joint in the C core, with its state.

    # Signals that the controller passes to the model, in the order of the core.
    GIVEN = ("mean_pressure", "load")
    # No joint has more, and its powers are still finite numbers in a stored state. [rad], [Nm]

        Parameters
        ----------
        parameters
            Of joint, pneumatics and loops.
        compensator
            H^-1: desired angle -> sheared pressure difference, for instance ``fit.model.inverse()``, in units of
            ``parameters.compensator_unit``, beginning in the model's start state; or a `DirectInverse`: desired angle
            -> torque, which also distinguishes contact from hysteresis; None for none.
        adaptation
            How a `DirectInverse` learns while ``SWITCHES["adapt"]`` is on; None: with the defaults of `Adaptation`.
        law
            A controller of the literature in the place of the paper's, see `dehyst_robot.control._reviewed`; None: the
            paper's.

        Raises
        ------
        ParameterError
            If `compensator` is no model, or k would be subtracted twice.

        Examples
        --------
        >>> controller = JointController(JointControllerParameters())
        >>> controller.reset(0.0, 3e5, 3e5)
        >>> out = controller.step(0.0, 3e5, 3e5, JointReference(angle=0.1), SWITCHES["position"])
        >>> out.flags, round(out.pressure_difference, 6)
        (0, 0.0)
    """

    def __init__(
        self,
        parameters: JointControllerParameters,
        compensator: HysteresisModel | DirectInverse | None = None,
        adaptation: Adaptation | None = None,
        law: Law | None = None,
    ) -> None:
        self.parameters = parameters
        self.law = law
        self._native = native_controller(parameters, compensator, adaptation, law)

    @property
    def scales(self) -> Array:
        """Learned scales of the direct inverse's groups, (groups,); empty without one."""
        return np.array(self._native.scales)

    @property
    def applied(self) -> Array:
        """Scales of the groups that are in use, (groups,)."""
        return np.array(self._native.applied)

    @property
    def disturbance(self) -> float:
        """Unknown torque that the disturbance observer of a sliding mode estimates; 0 for other laws. [Nm]"""
        return float(self._native.disturbance)

    @property
    def offset(self) -> float:
        """Learned offset. [Nm]"""
        return float(self._native.offsets[0])

    def reset(self, angle: float, pressure_1: float, pressure_2: float) -> None:
        """Start at these readings, at rest; the compensator at its model's start state. [rad], [Pa]

        From there mean pressure and pressure difference run to those of the reference over ``parameters.ramp``.
        A reading that is not finite leaves the joint failed, valves closed.
        """
        self._native.reset(angle, pressure_1, pressure_2)

    def step(
        self,
        angle: float | None,
        pressure_1: float | None,
        pressure_2: float | None,
        reference: JointReference,
        switches: int,
    ) -> JointOutput:
        """Return the outputs for the next period.

        Parameters
        ----------
        angle, pressure_1, pressure_2
            Readings; gauge pressures. None, for a sensor without an answer, is a faulty sample. [rad], [Pa]
        reference
            What the joint should do.
        switches
            Sum of values of `SWITCHES`.

        Raises
        ------
        ParameterError
            If `switches` has other bits.
        """
        _refuse_unknown(switches)
        # The core takes a reading that is not finite for a faulty sample.
        readings = []
        for reading in (angle, pressure_1, pressure_2):
            readings.append(math.nan if reading is None else reading)
        q, p_1, p_2 = readings
        return JointOutput(*self._native.step(q, p_1, p_2, reference.as_tuple(), switches))

    def run(
        self,
        angle: npt.ArrayLike,
        pressure_1: npt.ArrayLike,
        pressure_2: npt.ArrayLike,
        reference: npt.ArrayLike,
        switches: npt.ArrayLike,
    ) -> JointOutput:
        """Return the outputs (T,) for readings (T,), references (T, 7) in the order of `JointReference`, switches (T,).

        Raises
        ------
        ParameterError
            If lengths differ, values are not numbers, or `switches` has other bits than those of `SWITCHES`.
        """
        try:
            q = np.ascontiguousarray(angle, dtype=np.float64)
            p_1 = np.ascontiguousarray(pressure_1, dtype=np.float64)
            p_2 = np.ascontiguousarray(pressure_2, dtype=np.float64)
            table = np.ascontiguousarray(reference, dtype=np.float64)
            on = np.ascontiguousarray(switches, dtype=np.int64)
        except (TypeError, ValueError, OverflowError) as fault:
            raise ParameterError(
                f"readings, reference or switches are not arrays of numbers ({fault})."
            ) from None
        columns = len(fields(JointReference))
        # One row a sample in every array.
        shapes = [q.shape, p_1.shape, p_2.shape, on.shape]
        if len(set(shapes)) > 1 or len(shapes[0]) != 1 or table.shape != (*shapes[0], columns):
            raise ParameterError(
                f"readings have shapes {shapes[:3]}, switches {shapes[3]} and the reference {table.shape}; pass one "
                f"value a sample, (T,), and a reference (T, {columns}) with the columns of JointReference."
            )
        _refuse_unknown(int(np.bitwise_or.reduce(on)))
        # Rows of the C code are numbers; the last column, the flags, are whole ones.
        out = self._native.run(q, p_1, p_2, table, on)
        values: list[Any] = [*out.T[:-1], out[:, -1].astype(np.int64)]
        return JointOutput(*values)

    def exchange(
        self,
        compensator: HysteresisModel | None,
        unit: float | None = None,
        shear: float | None = None,
    ) -> None:
        """Exchange the compensator while running; its term fades from the old one to the new one over the ramp.

        Parameters
        ----------
        compensator
            The new one; None for none.
        unit
            Of its output; None keeps that of the parameters. [Pa]
        shear
            k of its loop; None keeps that of the parameters. [Pa/rad]
        """
        if shear is None:
            shear = self.parameters.shear
        if unit is None:
            unit = self.parameters.compensator_unit
        self._native.exchange(_parameters_of(compensator, shear), unit, shear)

    def save(self) -> bytes:
        """Return an image of the state; `restore` continues from it bit for bit.

        Raises
        ------
        ParameterError
            If the controller is one of the literature: images are those of the paper's, which runs on machines.
        """
        # Only the state of the core has a format that does not depend on the machine.
        if self.law is not None:
            raise ParameterError(
                f"the state of the controller '{self.law.name}' has no image: it runs on a host, beside the paper's. "
                f"Start it anew with reset(), or run the paper's (law=None)."
            )
        return self._native.save()

    def restore(self, image: bytes) -> None:
        """Continue from a saved image.

        Raises
        ------
        ParameterError
            If the image is damaged, or was saved by a controller with other parameters or another compensator;
            ``error.facts["fault"]`` says which: "size", "kind", "damaged", "foreign" or "invalid".
        """
        models_kit.refuse_image(
            self._native.restore(image),
            "Restore only what save() returned, into a controller with the same parameters and the same compensator; "
            "this one still has the state it had.",
        )


def native_controller(
    parameters: JointControllerParameters,
    compensator: HysteresisModel | DirectInverse | None,
    adaptation: Adaptation | None = None,
    law: Law | None = None,
) -> _native.JointController:
    """Return the core's controller, or the one of the literature that `law` asks for.

    Raises
    ------
    ParameterError
        If the compensator is no model, or the law is no record of `dehyst_robot.control._reviewed`.
    """
    # The core has a place for either kind of compensator.
    plays = direct = None
    if getattr(compensator, "core", "") == DIRECT:
        direct = direct_parameters(cast(DirectInverse, compensator), parameters.period)
    else:
        plays = _parameters_of(compensator, parameters.shear)
    return _native.JointController(
        parameters.as_dict(),
        plays,
        direct,
        (adaptation or Adaptation()).as_dict(),
        law_parameters(law),
    )


def _refuse_unknown(switches: int) -> None:
    if not 0 <= switches <= sum(SWITCHES.values()):
        listed = ", ".join(f"{name} = {bit}" for name, bit in SWITCHES.items())
        raise ParameterError(
            f"switches = {switches} has unknown bits; add values of SWITCHES: {listed}.",
            switches=switches,
        )


def _parameters_of(model: Any, shear: float) -> Any:
    if model is None:
        return None
    if getattr(model, "core", "") != PLAYS:
        raise ParameterError(
            f"the compensator is a {type(model).__name__}, not a hysteresis model; pass model.inverse(), or give the "
            f"term of a compensator of your own as the reference's extra (dehyst_robot.control.along)."
        )
    # The core subtracts k q: a model that does it itself would do it twice.
    refuse_second_shear(model, shear)
    return model.stepper().parameters
