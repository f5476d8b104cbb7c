"""A whole joint controller as something that targets can write."""

from __future__ import annotations

import json
import zlib
from dataclasses import replace
from typing import cast

import numpy as np

import dehyst._native as _native
from dehyst.arrays import Array
from dehyst.control.compensator import refuse_second_shear
from dehyst.control.joint import GIVEN, SWITCHES, JointController, JointReference, direct_parameters, in_si
from dehyst.control.parameters import OFF, Adaptation, JointControllerParameters
from dehyst.control.storage import controller_checksum, controller_text
from dehyst.errors import ParameterError
from dehyst.export.float_rules import check_float, check_values
from dehyst.export.joint_units import in_radians
from dehyst.export.names import check_name
from dehyst.export.numbers import JointNumbers, ModelNumbers, direct_in, direct_numbers, in_real, rounded
from dehyst.export.plays import model_numbers
from dehyst.export.signal import Signal
from dehyst.export.subject import REALS, Subject, check_choice
from dehyst.models import DirectInverse, HysteresisModel, Model
from dehyst.models.storage import model_to_dict

SENSORS = ("angle", "pressure_1", "pressure_2")
REFERENCE = (
    "angle_d", "velocity_d", "acceleration_d", "load_d", "mean_pressure_d", "pressure_difference_d", "extra_d",
)  # fmt: skip
OUTPUTS = (
    "valve_1", "valve_2", "desired_1", "desired_2", "pressure_difference_out", "torque", "integrator", "compensation",
    "angle_observed", "velocity_observed", "load_observed", "contact", "doubt",
)  # fmt: skip
SAMPLES = 1600


def joint_subject(
    model: Model,
    parameters: JointControllerParameters,
    adaptation: Adaptation | None = None,
    *,
    name: str,
    real: str = "double",
) -> Subject:
    """Return a joint controller whose compensator is the inverse of a model, or a direct inverse.

    Parameters
    ----------
    model
        Identified: sheared pressure difference -> angle. Its inverse becomes the compensator. An angle that is not in
        rad is converted, exactly by its unit. Or a direct inverse, angle -> torque.
    parameters
        Of the controller.
    adaptation
        How a direct inverse learns; None: with the defaults of `Adaptation`.
    name
        C identifier.
    real
        "double" or "float".

    Raises
    ------
    ParameterError
        If the name is none, or the model does not survive the rounding to float.
    InvertibilityError
        If the model has no inverse.
    UnitError
        If the model is in no units of a joint, or its pressures in another than the controller's.
    """
    check_choice(real, REALS, "--real")
    check_name(name)
    if model.core not in ("plays", "direct"):
        raise ParameterError(
            f"a joint controller holds a model of plays or a direct inverse, not a {model.family} model. Export that "
            f"as a unit of its own, --what inverse, or identify one for the controller: dehyst identify LOG --family "
            f"pi."
        )
    learning = (adaptation or Adaptation()) if model.core == "direct" else None
    content = model_to_dict(model)
    told = controller_checksum(parameters, learning)
    fingerprint = zlib.crc32(f"{told} {content['sha256']} {real}".encode("ascii"))
    compensator: HysteresisModel | DirectInverse
    if model.core == "direct":
        compensator = in_si(cast(DirectInverse, model))
        numbers = _direct_numbers(compensator, parameters, learning or Adaptation(), real, fingerprint)
        source, result = compensator.card.output, compensator.card.input
    else:
        compensator = in_radians(cast(HysteresisModel, model), parameters).inverse()
        refuse_second_shear(compensator, parameters.shear)
        numbers = _compensator_numbers(compensator, parameters, real, fingerprint)
        source, result = compensator.card.input, compensator.card.output
    return Subject(
        what="joint-controller",
        name=name,
        real=real,
        block=None,
        joint=numbers,
        input=source,
        output=result,
        model=model,
        model_text=json.dumps(content, indent=1, allow_nan=False) + "\n",
        checksum=str(content["sha256"]),
        provenance=dict(model.card.provenance),
        settings={"what": "joint-controller", "name": name, "real": real, "range": None, "ramp": 0},
        test=joint_run(parameters, compensator, real, learning),
        period=parameters.period,
        parameters=parameters,
        adaptation=learning,
        extra={"controller.json": controller_text(parameters, learning)},
    )


def controller_of(subject: Subject) -> JointController:
    """Return the joint controller that a subject is the export of."""
    assert subject.parameters is not None  # a joint controller has parameters
    model = subject.model
    if model.core == "direct":
        return JointController(subject.parameters, cast(DirectInverse, model), subject.adaptation)
    return JointController(subject.parameters, in_radians(cast(HysteresisModel, model), subject.parameters).inverse())


def _compensator_numbers(
    inverse: HysteresisModel, parameters: JointControllerParameters, real: str, fingerprint: int
) -> JointNumbers:
    exact = compensator_numbers(inverse)
    single = in_real(exact, real)
    if real == "float":
        check_float(exact, single)
        check_values(parameters.as_dict())
    return JointNumbers(parameters.as_dict(), single, fingerprint, None, OFF.as_dict())


def _direct_numbers(
    model: DirectInverse, parameters: JointControllerParameters, adaptation: Adaptation, real: str, fingerprint: int
) -> JointNumbers:
    exact = direct_numbers(direct_parameters(model, parameters.period))
    single = direct_in(exact, real)
    if real == "float":
        check_float(exact, single)
        check_values(parameters.as_dict() | {"adaptation": adaptation.as_dict()})
    return JointNumbers(parameters.as_dict(), None, fingerprint, single, adaptation.as_dict())


def compensator_numbers(inverse: HysteresisModel) -> ModelNumbers:
    """Return the numbers of a model with the tables that the core makes of its weights."""
    limits = [-1.0, 1.0, -1.0, 1.0, -1.0, 1.0, 1.0, 0.0, 1.0]  # of a block that nobody runs
    return model_numbers(_native.Block(_native.block_image(*inverse.stepper("dense").parameters, limits, 0)).parameters)


def joint_run(
    parameters: JointControllerParameters,
    compensator: HysteresisModel | DirectInverse | None,
    real: str,
    adaptation: Adaptation | None = None,
) -> Signal:
    """Record a joint that follows a motion, with switching, faulty sensors, and one that fails at the end.

    The joint is a point mass at the controller's own characteristic, its pressures follow what is desired: plain, but
    the controller is in a loop. What is recorded is replayed, in the same order, into whatever is exported.
    """
    controller = JointController(parameters, compensator, adaptation)
    learns = compensator is not None and compensator.core == "direct"
    direct = in_si(cast(DirectInverse, compensator)) if learns else None
    friction = None if direct is None else _Friction(direct, parameters)
    rows: list[Array] = []
    switch: list[int] = []
    answers: list[list[float]] = []
    flags: list[int] = []
    plant = _Joint(parameters, 0.0 if direct else 20.0)
    rng = np.random.default_rng(20260722)
    for k in range(SAMPLES):
        reference = _reference(parameters, k)
        on = _switches(k)
        if direct is not None:
            reference = _taught(reference, direct, adaptation or Adaptation(), parameters, k)
            on |= _learns(k)
            on &= ~SWITCHES["position"] if 350 <= k < 420 else on
        readings = np.array([plant.sensed_angle(), *(plant.pressure + 30.0 * rng.standard_normal(2))])
        readings = _faulty(readings, k, parameters)
        row = _rounded(np.array([*readings, *_lost(reference, k).as_tuple()]), real)
        if k == 0:
            controller.reset(*row[:3])
        out = controller.step(row[0], row[1], row[2], JointReference(*row[3:]), on)
        rows.append(row)
        switch.append(on)
        answers.append([getattr(out, name) for name in _OUT])
        flags.append(out.flags)
        plant.step(np.array([out.desired_1, out.desired_2]))
        if friction is not None:
            plant.load = friction.torque(plant, reference) - (PUSH if 900 <= k < 1100 else 0.0)
    return Signal(np.array(rows), np.array(switch), np.array(answers), np.array(flags), (*SENSORS, *REFERENCE), OUTPUTS)


START = 0.1  # [rad]
PUSH = 15.0  # torque from outside, [Nm]
WORN = 1.2  # what the joint has become of what was identified: there is something to learn


class _Friction:
    """What a joint needs that is a bit more than its direct inverse says."""

    def __init__(self, model: DirectInverse, parameters: JointControllerParameters) -> None:
        self._step = model.core_stepper(parameters.period)
        self._given = [schedule.name for schedule in model.outside]

    def torque(self, plant: _Joint, reference: JointReference) -> float:
        """Return it with the known load, for the present angle. [Nm]"""
        given = [float(getattr(reference, name)) for name in self._given]
        return float(WORN * self._step(plant.angle, plant.velocity, *given) + reference.load)


_OUT = (
    "valve_1", "valve_2", "desired_1", "desired_2", "pressure_difference", "torque", "integrator", "compensation",
    "angle", "velocity", "load", "contact", "doubt",
)  # fmt: skip


class _Joint:
    """A mass at the nominal characteristic whose pressures follow with a short lag."""

    def __init__(self, parameters: JointControllerParameters, damping: float) -> None:
        self.p, self.damping = parameters, damping
        self.angle, self.velocity, self.load = START, 0.0, 0.0
        self.pressure = np.full(2, 0.4 * (parameters.pressure_low + parameters.pressure_high))

    def sensed_angle(self) -> float:
        step = self.p.angle_step
        return round(self.angle / step) * step if step > 0 else self.angle

    def step(self, desired: Array) -> None:
        p = self.p
        q = min(max(self.angle, p.angle_low), p.angle_high)
        a, b, c = (sum(x * q**j for j, x in enumerate(poly)) for poly in (p.a, p.b, p.c))
        torque = a * self.pressure.mean() + b * (self.pressure[0] - self.pressure[1]) + c - self.load
        self.velocity += p.period * (torque / p.inertia - self.damping * self.velocity)
        self.angle = min(max(self.angle + p.period * self.velocity, 2 * p.angle_low), 2 * p.angle_high)
        self.pressure += min(1.0, p.period * 100.0) * (desired - self.pressure)


def _reference(p: JointControllerParameters, k: int) -> JointReference:
    size = 0.4 * (p.angle_high - p.angle_low)
    middle = 0.5 * (p.angle_high + p.angle_low)
    w, t = 8.0, k * p.period
    shrink = 1.0 / (1.0 + t)
    mean = 0.5 * (p.pressure_low + p.pressure_high)
    return JointReference(
        angle=middle + size * shrink * np.sin(w * t),
        velocity=size * shrink * w * np.cos(w * t),
        acceleration=-size * shrink * w * w * np.sin(w * t),
        load=2.0 * np.sin(3.0 * t),
        mean_pressure=mean,
        pressure_difference=0.1 * mean * np.sin(5.0 * t),
        extra=0.01 * mean * np.cos(7.0 * t),
    )


def _taught(
    reference: JointReference, model: DirectInverse, adaptation: Adaptation, p: JointControllerParameters, k: int
) -> JointReference:
    """Sweep what schedules the model; move slowly but for a while, so that it learns, then through all the range."""
    t = k * p.period
    given = {name: getattr(reference, name) for name in GIVEN}
    for schedule, speed in zip(model.outside, (9.0, 13.0), strict=False):
        half = 0.55 * (schedule.high - schedule.low)  # beyond its ends too
        given[schedule.name] = 0.5 * (schedule.low + schedule.high) + half * np.sin(speed * t)
    size = (0.03 if k < 1100 else 0.4) * (p.angle_high - p.angle_low)
    phase = (k % 800) / 800
    return replace(
        reference,
        angle=(START if k < 1100 else 0.5 * (p.angle_high + p.angle_low)) + size * (4 * abs(phase - 0.5) - 1),
        velocity=size * (-4 if phase < 0.5 else 4) / (800 * p.period),
        acceleration=2 * adaptation.most_acceleration if 450 <= k < 550 else 0.5 * adaptation.most_acceleration,
        **given,
    )


def _switches(k: int) -> int:
    position, integrator, compensator = (SWITCHES[name] for name in ("position", "integrator", "compensator"))
    if k < 100:
        return 0
    if k < 300:
        return position
    return position | (integrator if k % 700 < 500 else 0) | (compensator if k < 900 or k >= 1100 else 0)


def _learns(k: int) -> int:
    adapt = SWITCHES["adapt"] if k >= 200 and not 1200 <= k < 1300 else 0
    return adapt | (SWITCHES["disturbance"] if 600 <= k < 800 or 1000 <= k < 1250 else 0)


def _faulty(readings: Array, k: int, p: JointControllerParameters) -> Array:
    """Short faults that are bridged, and from 1500 on an angle that stays away."""
    if k % 250 in (120, 121, 122) or k >= 1500:
        readings[0] = np.nan
    if k % 330 in (200, 201):
        readings[1] = np.inf
    if k % 410 in (300, 301, 302) and p.pressure_jump > 0:
        readings[2] += 3 * p.pressure_jump
    if k % 370 == 250:
        readings[0] = 1e30
    return readings


def _lost(reference: JointReference, k: int) -> JointReference:
    return replace(reference, angle=np.nan) if k % 290 in (140, 141) else reference


def _rounded(row: Array, real: str) -> Array:
    return np.array([rounded(value, real) for value in row])
