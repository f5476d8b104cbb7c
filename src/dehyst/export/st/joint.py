"""The function block of a whole joint controller: two antagonistic muscles, as core/joint.c."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from dehyst.control import JointControllerParameters
from dehyst.control.parameters import OFF
from dehyst.export.numbers import DirectNumbers, ModelNumbers
from dehyst.export.st.blocks import (
    GROUPS,
    common_constants,
    direct_states,
    direct_tables,
    direct_work,
    kept,
    model_tables,
    model_variables,
    number,
    shape,
    table,
)
from dehyst.export.st.pou import Pou, Variable, block_of, names, rendered

DEGREE = 8
_ROOT = {  # smallest radicand, first guess and last digit of the root in core/pressure.c
    "LREAL": (1e-300, (0x1FF7A3BEA91D9B1C & (2**52 - 1)) / 2.0**52, 2.0**-52),
    "REAL": (1e-37, (0x1FBB4F2E & (2**23 - 1)) / 2.0**23, 2.0**-23),
}


def joint_block(
    name: str,
    real: str,
    parameters: JointControllerParameters,
    model: ModelNumbers | None,
    about: str,
    direct: DirectNumbers | None = None,
    adaptation: Mapping[str, float] = MappingProxyType({}),
    retain: bool = False,
) -> Pou:
    """Return the function block of a joint controller.

    Parameters
    ----------
    name
        Of its type.
    real
        LREAL or REAL.
    parameters
        Of the controller.
    model
        Tables of the compensator, reference angle in, sheared pressure difference out; None for none.
    about
        Comment on top.
    direct
        Tables of a direct inverse, reference angle in, torque out; None for none.
    adaptation
        How it learns, by the names of `dehyst.control.Adaptation`.
    retain
        Memory of the actuator and what was learned outlive a power cycle. Observer, integrator, faults and fading do
        not: they belong to the pressures and the motion of before.
    """
    sizes = {} if model is None else shape(model)
    body = rendered("joint.st.j2", compensated=model is not None, d=direct, retain=retain, **sizes)
    past = () if direct is None else (*direct_states(real, direct, "Wanted"), *direct_states(real, direct, "Seen"))
    tables = () if model is None else (*model_tables(real, model), *model_variables(real, len(model.threshold)))
    variables = (
        *_interface(real, direct is not None, direct is not None or model is not None),
        Variable("VAR", "Remembered", "BOOL", ("FALSE",), comment="what is retained is of a call before"),
        *tables,
        *_parameters(real, parameters),
        *(() if direct is None else (*direct_tables(real, direct), *_learning(real, adaptation))),
        *past,
        *(() if direct is None else direct_work(real)),
        *(
            ()
            if direct is None and model is None
            else _fit(real, adaptation if direct else OFF.as_dict(), direct is not None)
        ),
        *_states(real),
        *_work(real, tables),
        *_constants(real),
        *common_constants(real),
    )
    if retain:
        memory = {"Remembered", "States", "CompensatorOutput", *LEARNED, *(v.name for v in past)}
        variables = tuple(kept(v) if v.name in memory else v for v in variables)
    return block_of(name, variables, body, about)


LEARNED = names("LearnedScale AppliedScale LearnedOffset AppliedOffset UsualError LearnedError ErrorBefore CurveScale")


FINDINGS = (
    ("Stale", "BOOL", "the compensator does not fit: it is scaled down to the hysteresis that there is"),
    ("Shifted", "BOOL", "an offset of the torque, the same both ways: a pressure sensor or a weight"),
)
DIRECT_SWITCHES = (
    ("Learning", "BOOL", "the direct inverse learns; may change at any time"),
    ("Resisting", "BOOL", "the contact torque is fed back; may change at any time"),
)


def _interface(real: str, direct: bool, compared: bool) -> tuple[Variable, ...]:
    inputs = (
        ("Angle", real, "q [rad]"),
        ("Pressure1", real, "gauge [Pa]"),
        ("Pressure2", real, "gauge [Pa]"),
        ("DesiredAngle", real, "q_d [rad]"),
        ("DesiredVelocity", real, "[rad/s]"),
        ("DesiredAcceleration", real, "[rad/s^2]"),
        ("DesiredLoad", real, "torque of gravity and coupling at the reference [Nm]"),
        ("MeanPressure", real, "p_m, gauge [Pa]"),
        ("DirectDifference", real, "dp to apply while Position is FALSE [Pa]"),
        ("ExtraDifference", real, "compensator term from outside [Pa]"),
        ("Position", "BOOL", "position control on; may change at any time"),
        ("Integrating", "BOOL", "integrator on; may change at any time"),
        ("Compensating", "BOOL", "compensator on; may change at any time"),
        *(DIRECT_SWITCHES if direct else ()),
        ("Restart", "BOOL", "TRUE: start at the present readings"),
    )
    outputs = (
        ("Valve1", real, "command -1..1, > 0 fills"),
        ("Valve2", real, "command -1..1, > 0 fills"),
        ("Desired1", real, "desired pressure after limits, gauge [Pa]"),
        ("Desired2", real, "desired pressure after limits, gauge [Pa]"),
        ("PressureDifference", real, "dp_d before limits [Pa]"),
        ("Torque", real, "Q_d [Nm]"),
        ("IntegratorTorque", real, "I [Nm]"),
        ("Compensation", real, "compensator part of dp_d [Pa]"),
        ("ObservedAngle", real, "[rad]"),
        ("ObservedVelocity", real, "[rad/s]"),
        ("ObservedLoad", real, "torque beyond DesiredLoad [Nm]"),
        ("Contact", real, "what of it a direct inverse does not explain either [Nm]; 0 without one"),
        ("Doubt", real, "what its torque can be wrong by for an unknown past [Nm]; 0 without one"),
        ("Failed", "BOOL", "a fault outlasted its bridging: valves closed until a restart"),
        ("PressureLimit", "BOOL", "desired pressures were limited"),
        ("ValveLimit", "BOOL", "a valve was limited"),
        *((("Learned", "BOOL", "this period taught the adaptation something"),) if direct else ()),
        *(FINDINGS if compared else ()),
        (
            "FlagWord",
            "UDINT",
            "1 angle, 2 and 4 pressures, 8 failed, 16 and 32 limits, 64 reference, 128 ever, 256 learned, 512 stale, "
            "1024 offset; added",
        ),
    )
    return (
        *(Variable("VAR_INPUT", name, type_, comment=text) for name, type_, text in inputs),
        *(Variable("VAR_OUTPUT", name, type_, comment=text) for name, type_, text in outputs),
    )


def _parameters(real: str, p: JointControllerParameters) -> tuple[Variable, ...]:
    air = p.pneumatics
    numbers = (
        ("SamplePeriod", p.period, "of the task [s]"),
        ("Inertia", p.inertia, "M [kg m^2]"),
        ("Pole", p.pole, "lambda [1/s]"),
        ("ObserverPole", p.observer_pole, "[1/s]"),
        ("PressureGain", p.pressure_gain, "k_p [1/s]"),
        ("WindupGain", p.windup_gain, "[1/s]"),
        ("AngleLow", p.angle_low, "[rad]"),
        ("AngleHigh", p.angle_high, "[rad]"),
        ("PressureLow", p.pressure_low, "[Pa]"),
        ("PressureHigh", p.pressure_high, "[Pa]"),
        ("RampTime", p.ramp, "[s]"),
        ("Shear", p.shear, "k [Pa/rad]"),
        ("CompensatorUnit", p.compensator_unit, "[Pa]"),
        ("SupplyPressure", air.supply, "absolute [Pa]"),
        ("AmbientPressure", air.ambient, "absolute [Pa]"),
        ("GasTemperature", air.gas_temperature, "R T [J/kg]"),
        ("Polytropic", air.polytropic, "n"),
        ("ReferenceDensity", air.reference_density, "rho_0 [kg/m^3]"),
        ("Conductance", air.conductance, "C [m^3/(s Pa)]"),
        ("CriticalRatio", air.ratio, "b"),
        ("DeadBand", air.dead_band, "share of the stroke"),
        ("AngleJump", p.angle_jump, "[rad], 0: any"),
        ("PressureJump", p.pressure_jump, "[Pa], 0: any"),
        ("AngleStep", p.angle_step, "resolution of the encoder [rad]"),
        ("FrozenReal", float(p.frozen_samples), ""),
    )
    tables = (("TableA", p.a, "A [Nm/Pa]"), ("TableB", p.b, "B [Nm/Pa]"), ("TableC", p.c, "C [Nm]"))
    volumes = [x for muscle in p.volume for x in (*muscle, *[0.0] * (4 - len(muscle)))]
    return (
        *(number(name, real, value, text) for name, value, text in numbers),
        *(table(name, real, (*values, *[0.0] * (DEGREE - len(values))), text) for name, values, text in tables),
        table("VolumeTable", real, tuple(volumes), "V_1, V_2 [m^3]"),
        Variable("VAR CONSTANT", "FrozenSamples", "DINT", (str(p.frozen_samples),), comment="equal readings, 0: any"),
        Variable("VAR CONSTANT", "HoldSamples", "DINT", (str(p.hold_samples),), comment="faulty readings bridged"),
    )


def _learning(real: str, adaptation: Mapping[str, float]) -> tuple[Variable, ...]:
    """Constants and states of the learning and of the contact torque."""
    told = (
        ("LearningRate", "rate", "share of an error that a second takes away [1/s]"),
        ("LearningMemory", "memory", "over which errors are compared [s]"),
        ("LearningNoise", "noise", "size of a torque that teaches nothing [Nm]"),
        ("DeadZone", "dead_zone", "errors below teach nothing [Nm]"),
        ("MostError", "most_error", "errors beyond teach nothing [Nm]"),
        ("ContactRatio", "contact_ratio", "unless below so many times the usual error"),
        ("FirstError", "first_error", "usual error at first [Nm]"),
        ("LearningPatience", "patience", "over which larger errors become the usual ones [s]"),
        ("LearningRest", "rest", "without learning after a large error [s]"),
        ("LowestScale", "lowest", "of what is learned"),
        ("HighestScale", "highest", ""),
        ("OffsetLimit", "offset_limit", "[Nm]"),
        ("LearningUnit", "unit", "[Nm]"),
        ("MostAcceleration", "most_acceleration", "of the reference, to learn [rad/s^2]"),
        ("LeastSpeed", "least_speed", "of the reference, to learn [rad/s]"),
        ("DisturbancePole", "disturbance_pole", "of the feedback of the contact torque [1/s]"),
    )
    reals = names(
        "LearnedOffset AppliedOffset LearnedError ErrorBefore UsualError Resting LearnedShare DirectTorque "
        "Disturbance DisturbanceShare LateShare Explained Before OffsetUnit CurveScale"
    )
    return (
        *(number(name, real, adaptation[key], text) for name, key, text in told),
        number("LargestSquared", real, 1e7, "its square is a sample that is accepted"),
        number("MostRatio", real, 1e3),
        number("LargestTorque", real, 1e6, "[Nm]"),
        Variable("VAR", "LearnedScale", real, ("1.0",) * GROUPS, GROUPS, "learned scales of the groups of terms"),
        Variable("VAR", "AppliedScale", real, ("1.0",) * GROUPS, GROUPS, "those in use"),
        Variable("VAR", "DelayedCurve", real, ("0.0",) * 3, 3, "as late as the observer"),
        Variable("VAR", "DelayedPart", real, ("0.0",) * (3 * GROUPS), 3 * GROUPS),
        *(Variable("VAR", name, real, ("0.0",)) for name in reals),
        *(Variable("VAR", name, "BOOL", ("FALSE",)) for name in names("Teaching Better ShiftedBefore")),
    )


def _fit(real: str, adaptation: Mapping[str, float], direct: bool) -> tuple[Variable, ...]:
    """Constants and states of the comparison of the compensator with what the observer sees."""
    constants = {
        "FitMost": 1e3, "FitMost2": 2e3, "FitLeast": 1e-3, "FitHighest": 1e9, "FitSmallest": 1e-12, "FitKept": 0.8,
        "FitWhole": 0.1, "FitHomed": 3.2, "FitGross": 2e-3, "FitOwnShare": 0.1,
        "FitNeeded": 2.0 if direct else 2.5, "FitFar": 0.15 if direct else 0.25, "FitDoubt": 0.5 if direct else 1.25,
        "FitNear": 0.1 if direct else 0.2, "FitWide": 0.25, "FitWideDoubt": 1.25, "FitClose": 0.2, "FitEarlyDoubt": 1.5,
        "FitShift": 0.01, "FitLess": 0.15,
    }  # fmt: skip
    tables = {"FitTorque": 4, "FitLoad": 4, "FitAngle": 4, "FitStroke": 6, "FitSum": 6, "FitAll": 6}
    reals = names(
        "FitStrokes FitWay FitRest FitTime FitMean FitOffset FitNow FitLargest FitLate FitGain FitSlope FitElastic "
        "FitOwn FitBoth"
    )
    speed = () if direct else (number("LeastSpeed", real, adaptation["least_speed"], "[rad/s]"),)
    return (
        *(number(name, real, value) for name, value in constants.items()),
        *speed,
        *(Variable("VAR", name, real, ("0.0",) * n, n) for name, n in tables.items()),
        *(Variable("VAR", name, real, ("0.0",)) for name in reals),
        *(Variable("VAR", name, real, ("1.0",)) for name in names("FitScale FitFound")),
        *(Variable("VAR", name, "BOOL", ("FALSE",)) for name in names("BothWays Loud")),
    )


def _states(real: str) -> tuple[Variable, ...]:
    reals = names(
        "Travel TravelMost KnownTorque AtA AtB AtC HeldAngle HeldVelocity HeldAcceleration HeldLoad HeldMean "
        "HeldDifference HeldExtra IntegratorLeft IntegratorLoss DifferenceLeft DifferenceLoss MeanLeft MeanLoss "
        "CompensatorShare CompensatorOutput"
    )
    pairs = names("PressureNow Desired FeedForward Rate Expected")
    return (
        *(Variable("VAR", name, real, ("0.0",)) for name in reals),
        *(Variable("VAR", name, real, ("0.0",) * 2, 2, "of both muscles") for name in pairs),
        Variable("VAR", "LastReading", real, ("0.0",) * 3, 3, "of angle and both pressures"),
        *(Variable("VAR", name, "DINT", ("0",) * 3, 3) for name in ("EqualCount", "FaultyCount")),
        *(Variable("VAR", name, "BOOL", ("FALSE",)) for name in names("Running Started PositionBefore FaultEver")),
    )


def _work(real: str, tables: tuple[Variable, ...]) -> tuple[Variable, ...]:
    reals = names(
        "PressureRange WideRange FadeShare Size Loss Held Top Room Part HalfPart Middle Value Distance Mean Last "
        "Reading Between Pull Change Share Series Pole3 Rest Wrong Term Compensated Direct Wanted ThereA ThereB ThereC "
        "Volume VolumeRate Inner Wish Flow Down Up Ratio Psi Opening Command Band Radicand Root Mantissa Factor "
        "MantissaPart Rounded"
    )
    flags = names("Good ReferenceFault Strange Frozen Failing AngleFault Jumped Inside Odd Changed")
    known = {variable.name for variable in tables}
    return (
        *(Variable("VAR", name, real, ("0.0",)) for name in reals if name not in known),
        *(Variable("VAR", name, "DINT", ("0",)) for name in ("Power", "Muscle", "Number")),
        *(Variable("VAR", name, "BOOL", ("FALSE",)) for name in flags),
        Variable("VAR", "PressureFault", "BOOL", ("FALSE",) * 2, 2),
        Variable("VAR", "Known", real, ("0.0",) * 2, 2),
    )


def _constants(real: str) -> tuple[Variable, ...]:
    smallest, bias, digit = _ROOT[real]
    values = {
        "Two": 2.0,
        "Three": 3.0,
        "Four": 4.0,
        "Quarter": 0.25,
        "OneAndHalf": 1.5,
        "Sixth": 1.0 / 6.0,
        "TwentyFourth": 1.0 / 24.0,
        "Eighth": 0.125,
        "Margin": 4.0,
        "Ten": 10.0,
        "Smoothing": 1e-3,
        "StepsUnseen": 20.0,
        "Smallest": 1e-9,
        "SmallestB": 1e-9,
        "Laminar": 0.999,
        "SmallestPsi": 0.05,
        "Zone": 0.005,
        "Vacuum": 1.0,
        "SmallestRoot": smallest,
        "RootBias": bias,
        "LastDigit": digit,
        "FarUp": 2.0**32,
        "FarUpRoot": 2.0**16,
        "FarDown": 2.0**-32,
        "FarDownRoot": 2.0**-16,
    }
    return tuple(number(name, real, value) for name, value in values.items())
