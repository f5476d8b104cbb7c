"""Parameters of a joint controller and of its learning, checked before they reach the C core."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field, fields
from typing import Any

from dehyst.errors import ParameterError
from dehyst.models import kit as models_kit

LEAST_NOISE = 1e-6  # its square is above 0 in single precision, too


@dataclass(frozen=True)
class Adaptation:
    r"""Projected, normalised gradient for the scales of a direct inverse's groups, and how contact is fed back.

    .. math::

        e = Q_{obs} - \Bigl(c + o + \sum_g \theta_g \varphi_g\Bigr), \qquad
        \theta_g \leftarrow \Pi\Bigl[\theta_g + \mu\,\frac{e\,\varphi_g}{\epsilon^2 + u^2 + \sum \varphi^2}\Bigr],
        \qquad \mu = rate \cdot T

    :math:`Q_{obs}` is the torque that the observer estimates beyond the known load, :math:`\varphi_g` the torque of a
    group of the model at the measured angle, with the delay of the observer. Scales stay within lowest..highest and
    the offset within its limit for all measurements: weights stay >= 0, so that the compensator stays invertible. The
    learned values are in use while their squared error over the last `memory` is below that of the identified model.

    Parameters
    ----------
    rate
        Share of an error that is removed in a second of full excitation; 0 switches learning off. [1/s]
    memory
        Time over which errors are compared; learned values are faded in over the same time. [s]
    noise
        epsilon: signals of a group below this size hardly change its scale. [Nm]
    dead_zone
        Smaller errors are not learned. [Nm]
    most_error
        Larger errors count as contact and are not learned until they are over, unless such errors are usual. `equip`
        raises it to the largest torque that the model missed on loops on which nothing touched the joint, 2 Nm at
        most. [Nm]
    contact_ratio
        An error is usual below this many times the rms of the errors over the last `memory`, without contact. 0: no
        error is usual.
    first_error
        That rms at the start. [Nm]
    patience
        Time after which an error that looks like contact, that was there before `settling` and does not end, becomes
        usual and is learned: a hysteresis that is another than at the identification. With a ratio c it takes some
        2 patience/(c^2 - 1) times the logarithm of how many times too large the error is. [s]
    rest
        Time without learning after contact. [s]
    settling
        Time of usual errors after which an error that looks like contact for 0.1 s is never learned, however long it
        lasts: a hand may hold on, and hysteresis does not change at once. The flag ``touched`` says so. Samples that
        teach count: while the joint is to move, without much acceleration, with the switch of learning on. 0:
        `patience` alone decides. [s]
    lowest, highest
        Of every scale, lowest <= 1 <= highest.
    offset_limit
        Of the learned offset; 0: none. [Nm]
    unit
        u: size of the offset as a signal, compared with those of the groups. [Nm]
    most_acceleration
        Of the reference: beyond it the error of the nominal inertia would be learned as hysteresis. [rad/s^2]
    least_speed
        Of the reference under position control: below it a drift at rest would be learned as hysteresis. [rad/s]
    disturbance_pole
        Of the feedback of the contact torque, switched by ``SWITCHES["disturbance"]``. [1/s]

    Raises
    ------
    ParameterError
        If a number is not finite, `noise` is below 1e-6 Nm, or scales could become negative.

    Examples
    --------
    >>> Adaptation(rate=0.5).highest
    2.0
    """

    rate: float = 0.3
    memory: float = 5.0
    noise: float = 0.3
    dead_zone: float = 0.0
    most_error: float = 0.5
    contact_ratio: float = 4.0
    first_error: float = 1.0
    patience: float = 120.0
    rest: float = 1.0
    settling: float = 20.0
    lowest: float = 0.0
    highest: float = 2.0
    offset_limit: float = 2.0
    unit: float = 1.0
    most_acceleration: float = 0.5
    least_speed: float = 0.002
    disturbance_pole: float = 5.0

    def __post_init__(self) -> None:
        for entry in fields(self):
            object.__setattr__(
                self, entry.name, models_kit.parameter_number(getattr(self, entry.name), entry.name)
            )
        # 1 is the scale of the identified model, with which learning begins.
        if not 0 <= self.lowest <= 1 <= self.highest:
            raise ParameterError(
                f"scales from {self.lowest:g} to {self.highest:g}: they begin at 1 and a negative one would drive "
                f"motion instead of opposing it. Pass 0 <= lowest <= 1 <= highest."
            )
        if not self.noise >= LEAST_NOISE:
            raise ParameterError(
                f"noise = {self.noise:g} Nm is too small: without signal errors would be divided by nothing. Pass "
                f"{LEAST_NOISE:g} Nm or more; 0.3 Nm is usual."
            )
        # Those that were checked above have limits of their own.
        checked = ("noise", "lowest", "highest")
        for entry in fields(self):
            value = getattr(self, entry.name)
            if entry.name not in checked and value < 0:
                raise ParameterError(f"{entry.name} = {value:g} must not be negative.")

    def as_dict(self) -> dict[str, float]:
        """Return the values by the names of the core."""
        return asdict(self)


OFF = Adaptation(rate=0.0)  # of controllers that shall not learn


DEGREE = 8  # coefficients of A, B and C at most
_BAR = 1e5


@dataclass(frozen=True)
class Pneumatics:
    """Nominal air and valve of the controller, ISO 6358; the true ones differ.

    Parameters
    ----------
    supply, ambient
        Absolute pressures. [Pa]
    gas_temperature
        R T. [J/kg]
    polytropic
        n, 1 (isothermal) to 1.4 (adiabatic).
    reference_density
        rho_0. [kg/m^3]
    conductance
        C of the fully open valve. [m^3/(s Pa)]
    ratio
        Critical pressure ratio b.
    dead_band
        Half width of the valve's dead band, share of the stroke.

    Raises
    ------
    ParameterError
        If a value is not finite or has no physical meaning.
    """

    supply: float = 8.013e5
    ambient: float = 1.013e5
    gas_temperature: float = 287.0 * 293.0
    polytropic: float = 1.26
    reference_density: float = 1.185
    conductance: float = 2.0e-8
    ratio: float = 0.3
    dead_band: float = 0.03

    def __post_init__(self) -> None:
        _take_numbers(self)
        for name in (
            "ambient",
            "gas_temperature",
            "polytropic",
            "reference_density",
            "conductance",
        ):
            _positive(self, name)
        if not self.supply > self.ambient:
            raise ParameterError(
                f"supply = {self.supply:g} Pa is not above ambient = {self.ambient:g} Pa; both are absolute pressures.",
                supply=self.supply,
                ambient=self.ambient,
            )
        for name in ("ratio", "dead_band"):
            if not 0 <= getattr(self, name) < 1:
                raise ParameterError(
                    f"{name} = {getattr(self, name):g} is a share; pass 0 <= {name} < 1."
                )


@dataclass(frozen=True)
class JointControllerParameters:
    """All parameters of a joint controller; the defaults are those of a joint with two DMSP-40 muscles.

    Parameters
    ----------
    period
        T of the control. [s]
    inertia
        Nominal M. [kg m^2]
    pole
        lambda: all poles of the position error lie at -lambda. [1/s]
    observer_pole
        All poles of the observer of angle, velocity and load. [1/s]
    pressure_gain
        k_p of the pressure loops. [1/s]
    windup_gain
        Rate of back-calculation while pressures or valves saturate. [1/s]
    a, b, c
        Coefficients of A [Nm/Pa], B [Nm/Pa], C [Nm] in powers of the angle, lowest first, 8 at most each.
    volume
        Coefficients of both chambers' volumes, lowest first, 4 at most each. [m^3]
    angle_low, angle_high
        Range of the calibration; A, B, C and the volumes are held beyond it. [rad]
    pressure_low, pressure_high
        Limits of desired gauge pressures. [Pa]
    ramp
        Time over which a switched term fades. [s]
    shear
        k of the sheared loop x = dp - dp_nom + k q. [Pa/rad]
    compensator_unit
        Size of one unit of the compensator's output, 1e5 if it answers in bar. [Pa]
    pneumatics
        Nominal air and valve.
    angle_jump
        Largest credible distance of the angle from its prediction; 0 for no check. [rad]
    pressure_jump
        Largest credible change of a pressure in a period; 0 for no check. [Pa]
    angle_step
        Resolution of the encoder. [rad]
    frozen_samples
        Equal samples of a sensor in a row that mean it is frozen; 0 for never.
    hold_samples
        Faulty samples that are bridged by prediction; beyond it the valves close until a reset.

    Raises
    ------
    ParameterError
        If a value is not finite or has no physical meaning.

    Examples
    --------
    >>> JointControllerParameters(pole=6.0).as_dict()["pole"]
    6.0
    """

    period: float = 5e-4
    inertia: float = 4.0
    pole: float = 6.0
    observer_pole: float = 60.0
    pressure_gain: float = 60.0
    windup_gain: float = 5.0
    a: tuple[float, ...] = (0.0, -62.09 / _BAR, 0.0, 23.13 / _BAR, 0.0, -3.78 / _BAR)
    b: tuple[float, ...] = (34.88 / _BAR, 0.0, -3.88 / _BAR, 0.0, -1.26 / _BAR)
    c: tuple[float, ...] = (0.0, -4.32, 0.0, -14.66, 0.0, -42.37)
    volume: tuple[tuple[float, ...], tuple[float, ...]] = (
        (8.20e-4, 2.28e-4, -7.05e-5, 3.30e-6),
        (8.20e-4, -2.28e-4, -7.05e-5, -3.30e-6),
    )
    angle_low: float = -0.7
    angle_high: float = 0.7
    pressure_low: float = 0.2e5
    pressure_high: float = 6e5
    ramp: float = 0.5
    shear: float = 1e5
    compensator_unit: float = 1e5
    pneumatics: Pneumatics = field(default_factory=Pneumatics)
    angle_jump: float = 0.05
    pressure_jump: float = 0.3e5
    angle_step: float = 2 * 3.141592653589793 / 2**17
    frozen_samples: int = 400
    hold_samples: int = 40

    def __post_init__(self) -> None:
        # The record is frozen for others: only here are values replaced, by numbers of one type.
        put = object.__setattr__
        for name in ("a", "b", "c"):
            put(self, name, _coefficients(getattr(self, name), name, DEGREE))
        if not isinstance(self.volume, (tuple, list)) or len(self.volume) != 2:
            raise ParameterError(
                "volume must be a pair: the coefficients of both chambers, lowest power first."
            )
        first, second = self.volume
        put(self, "volume", (_coefficients(first, "volume", 4), _coefficients(second, "volume", 4)))
        if not isinstance(self.pneumatics, Pneumatics):
            raise ParameterError(
                f"pneumatics is a {type(self.pneumatics).__name__}; pass Pneumatics(...)."
            )
        _take_numbers(self)
        for name in ("period", "inertia", "pressure_gain", "compensator_unit"):
            _positive(self, name)
        for name in (
            "pole",
            "observer_pole",
            "windup_gain",
            "ramp",
            "angle_jump",
            "pressure_jump",
            "angle_step",
        ):
            if getattr(self, name) < 0:
                raise ParameterError(
                    f"{name} = {getattr(self, name):g} is negative; pass 0 or more."
                )
        for low, high in (("angle_low", "angle_high"), ("pressure_low", "pressure_high")):
            if not getattr(self, low) < getattr(self, high):
                raise ParameterError(
                    f"{low} = {getattr(self, low):g} is not below {high} = {getattr(self, high):g}: no range is left.",
                )
        # Explicit Euler steps of a first-order loop overshoot beyond a product of 1.
        if self.period * self.pressure_gain > 1 or self.period * self.pole > 1:
            raise ParameterError(
                f"a period of {self.period:g} s is too long for pressure_gain = {self.pressure_gain:g} 1/s and pole = "
                f"{self.pole:g} 1/s: the loops would overshoot from sample to sample. Keep period * gain below 1."
            )

    def as_dict(self) -> dict[str, Any]:
        """Return the parameters by the names of the core's ``dehyst_joint``."""
        return asdict(self)


def _coefficients(values: Any, name: str, most: int) -> tuple[float, ...]:
    coefficients = tuple(map(float, models_kit.parameter_array(values, name)))
    if len(coefficients) > most:
        raise ParameterError(
            f"{name} has {len(coefficients)} coefficients; the core takes {most} at most.",
            most=most,
        )
    return coefficients


def _take_numbers(parameters: Any) -> None:
    """Replace every field that is one number by a float or an int."""
    for entry in fields(parameters):
        # Annotations are texts in this module.
        value = getattr(parameters, entry.name)
        if entry.type == "float":
            object.__setattr__(
                parameters, entry.name, models_kit.parameter_number(value, entry.name)
            )
        elif entry.type == "int":
            number = models_kit.parameter_number(value, entry.name)
            if number != int(number) or not 0 <= number < 2**31:
                raise ParameterError(
                    f"{entry.name} = {value!r} is not a number of samples; pass 0, 1, 2, ..."
                )
            object.__setattr__(parameters, entry.name, int(number))


def _positive(parameters: Any, name: str) -> None:
    if not getattr(parameters, name) > 0:
        raise ParameterError(f"{name} = {getattr(parameters, name):g} must be positive.")
