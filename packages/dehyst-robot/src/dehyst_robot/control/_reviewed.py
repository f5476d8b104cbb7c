r"""Other controllers of a pneumatic joint from the literature, run in place of the paper's controller.

A record holds the parameters of a law. All laws share the `JointControllerParameters`: checks of the sensors,
observer, characteristic A, B, C, limits, air and valve. ``for_joint`` derives a record from those by the formulas
stated there, so that no law is tuned better than another; ``tuned`` counts the numbers that a person has to choose for
a joint of which only its calibration is known. The C code is in reviewed/, for a host only: it is not exported.

With :math:`e = q_d - q`, the mean pressure :math:`p_m` and the pressure difference :math:`\Delta p`:

==============  =====================================================================================================
pid             :math:`\Delta p_d = s q_d + k_p e + k_i \int e + k_d \dot e`
vo-minh         :math:`\Delta p_d = (Q_{load} + Q_h[q_d] - A(q_d) p_m - C(q_d))/B(q_d) + k_p e + k_i \int e`
sliding-mode    :math:`Q_d = M (\ddot q_d + L \dot e + W \tanh(s/\phi)) + Q_{load} + \hat d`, :math:`s = \dot e + L e`
one-valve       :math:`\dot{\Delta p}` imposed by one spool, :math:`p_m` not free; :math:`\Delta p_d` as the paper's
==============  =====================================================================================================

:math:`Q_h`, or any other compensation, is the output of the joint's compensator, whichever it is. The same switch as in
the paper's controller switches it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, fields
from types import MappingProxyType
from typing import Any, ClassVar, TypeAlias

import numpy as np

import dehyst_robot._native as _native
from dehyst.errors import ParameterError
from dehyst.models import kit as models_kit
from dehyst_robot.control._parameters import JointControllerParameters

PAPER = "paper"
MEAN = 3e5  # mean pressure at which stiffness and slope of the joint are computed, [Pa]
DISTURBANCE = 8.0  # unknown torque: half width of the hysteresis loops of large muscles, [Nm]
DAMPING_RATIO = 0.05  # of a free joint: "lightly damped" in every publication
REACHING = 4.0  # the boundary layer's pole is this much slower than the pressure loops
# Gain margins of a PI: of the gains with which the nominal joint begins to ring to those that are chosen.
P_MARGIN = 8.0
I_MARGIN = 4.0


@dataclass(frozen=True)
class _Law:
    """Base of all records: checks their numbers, and names them as the C code does."""

    name: ClassVar[str]
    tuned: ClassVar[int]

    def __post_init__(self) -> None:
        for entry in fields(self):
            value = models_kit.parameter_number(getattr(self, entry.name), entry.name)
            if value < 0:
                raise ParameterError(
                    f"{entry.name} = {value:g} of the controller '{self.name}' is negative: it would push the joint "
                    f"away from where it should be. Pass 0 or more, or derive all: for_joint(parameters)."
                )
            object.__setattr__(self, entry.name, value)

    def as_dict(self) -> dict[str, float]:
        """Return the numbers by the names of the C code, ``kind`` among them."""
        return {"kind": _native.LAWS[self.name], **asdict(self)}


@dataclass(frozen=True)
class PidController(_Law):
    r"""A PID on the angle without a model: no load, no inertia, one constant slope of the characteristic.

    .. math:: \Delta p_d = s q_d + k_p e + k_i \int e\,dt + k_d \dot e

    The derivative is that of the encoder's readings behind a first-order filter. The mean pressure is constant, the
    pressure loops are the paper's. Defaults: ``for_joint(JointControllerParameters())``, rounded.

    Its limit: it carries a weight and follows an acceleration only by an error, because it knows neither.

    Parameters
    ----------
    proportional
        k_p. [Pa/rad]
    integral
        k_i. [Pa/(rad s)]
    derivative
        k_d. [Pa s/rad]
    slope
        s: d(dp)/dq of the joint at rest, 0 for none. [Pa/rad]
    filter
        Time constant of the derivative. [s]

    Raises
    ------
    ParameterError
        If a value is not finite or negative.

    Examples
    --------
    >>> pid = PidController.for_joint(JointControllerParameters())
    >>> round(pid.slope / 1e5, 2), round(pid.derivative / 1e5, 2), pid.tuned
    (5.46, 2.07, 4)
    """

    name: ClassVar[str] = "pid"
    tuned: ClassVar[int] = 4
    proportional: float = 6.93e5
    integral: float = 2.48e6
    derivative: float = 2.07e5
    slope: float = 5.46e5
    filter: float = 1 / 60

    @classmethod
    def for_joint(
        cls,
        parameters: JointControllerParameters,
        mean: float = MEAN,
        disturbance: float = DISTURBANCE,
    ) -> PidController:
        r"""All poles at :math:`-\lambda`, as the paper's, of the nominal joint :math:`M \ddot q + K q = B \Delta p`.

        .. math::
            k_d = 3 \lambda M/B,\quad k_p = \max(3 \lambda^2 M - K, 0)/B,\quad k_i = \lambda^3 M/B,\quad s = K/B

        with stiffness K and slope B in the middle of the range, both muscles at `mean` [Pa]; the filter has the
        observer's pole. `disturbance` is not used.
        """
        stiffness, slope = stiffness_and_slope(parameters, mean)
        pole, inertia = parameters.pole, parameters.inertia
        # Without an observer the derivative is not filtered either.
        time_constant = 0.0
        if parameters.observer_pole > 0:
            time_constant = 1 / parameters.observer_pole
        return cls(
            proportional=max(3 * pole**2 * inertia - stiffness, 0.0) / slope,
            integral=pole**3 * inertia / slope,
            derivative=3 * pole * inertia / slope,
            slope=stiffness / slope,
            filter=time_constant,
        )


@dataclass(frozen=True)
class VoMinhController(_Law):
    r"""Cascade with hysteresis feedforward (Vo-Minh, Tjahjowidodo, Ramon, Van Brussel, AIM 2009; Mechatronics 2011).

    .. math:: \Delta p_d = \frac{Q_{load} + Q_h[q_d] - A(q_d) p_m - C(q_d)}{B(q_d)} + k_p e + k_i \int e\,dt

    Inner pressure loops (the paper's), the static model and the hysteresis :math:`Q_h` fed forward along the desired
    position, a PI on the position. Structure: high confidence; gains: not accessible, derived here. :math:`Q_h` is
    the joint's compensator: the published one is a Maxwell-slip model, a `DirectInverse` of stop operators alone with
    weights >= 0 (the recipe "maxwell-slip"). Without it, "off", the static model is fed forward alone.

    Its limit: it does not damp. It has no derivative and no feedforward of the inertia torque, so that a fast motion
    makes the joint ring, and the joint's own light damping bounds its gains, not the pressure loops.

    Parameters
    ----------
    proportional
        k_p. [Pa/rad]
    integral
        k_i. [Pa/(rad s)]

    Raises
    ------
    ParameterError
        If a value is not finite or negative.

    Examples
    --------
    >>> vo_minh = VoMinhController.for_joint(JointControllerParameters())
    >>> bool(vo_minh.integral < PidController.for_joint(JointControllerParameters()).integral / 5), vo_minh.tuned
    (True, 2)
    """

    name: ClassVar[str] = "vo-minh"
    tuned: ClassVar[int] = 2
    proportional: float = 6.08e4
    integral: float = 9.17e4

    @classmethod
    def for_joint(
        cls,
        parameters: JointControllerParameters,
        mean: float = MEAN,
        disturbance: float = DISTURBANCE,
    ) -> VoMinhController:
        r"""Gain margins of 8 (P) and 4 (I) on the nominal joint behind its pressure loops.

        The loop is :math:`(M s^2 + d s + K)(\tau s + 1) s + k_p s + k_i` in torque, with :math:`\tau = 1/k_{pressure}`
        and :math:`d = 2 \cdot 0.05 \sqrt{K M}` (assumption: "lightly damped"). By Routh it begins to ring at

        .. math::
            k_{p,u} &= d/\tau + d^2/M + \tau d K/M \\
            k_{i,u} &= (K + k_p) \bigl(a_3 a_2 - \tau M (K + k_p)\bigr)/a_3^2,\quad a_3 = M + \tau d,\ a_2 = d + \tau K

        and :math:`k_p = k_{p,u}/8`, :math:`k_i = k_{i,u}/4`, both over B: twice the usual margins, because the light
        damping that all of it rests on is the worst known number of a joint. `disturbance` is not used.
        """
        stiffness, slope = stiffness_and_slope(parameters, mean)
        lag = 1 / parameters.pressure_gain
        inertia = parameters.inertia
        damping = 2 * DAMPING_RATIO * math.sqrt(stiffness * inertia)
        ringing = damping / lag + damping**2 / inertia + lag * damping * stiffness / inertia
        # The integral gain depends on the stiffness that the proportional gain leaves.
        proportional = ringing / P_MARGIN
        total = stiffness + proportional
        third = inertia + lag * damping
        second = damping + lag * stiffness
        integral = total * (third * second - lag * inertia * total) / third**2 / I_MARGIN
        return cls(proportional / slope, integral / slope)


@dataclass(frozen=True)
class SlidingModeController(_Law):
    r"""Sliding mode with disturbance observer (Aschemann, Schindele 2008), inner flatness-based pressure loops.

    .. math::
        s = \dot e + L e,\quad \dot s = -W \tanh(s/\phi)\ \Rightarrow\
        Q_d = M\bigl(\ddot q_d + L \dot e + W \tanh(s/\phi)\bigr) + Q_{load} + \hat d

    and :math:`\Delta p_d` through the inverse characteristic; the mean pressure is the second output. The observer is
    of reduced order, :math:`\dot{\hat d} = L_o (Q - Q_{load} - Q_c - M \ddot q - \hat d)`; a compensator's torque
    :math:`Q_c` is known to it, so that both do not act on the same hysteresis. The switch "integrator" is that of the
    observer's feedback. Structure: high, numbers: low confidence; derived here.

    Its limit: it does not see the error of the pressure loops. The observer uses measured pressures, so that a few
    thousandths of a bar between them and the desired ones remain an error of the angle.

    Parameters
    ----------
    surface
        L: pole of the error on the surface. [1/s]
    gain
        W: acceleration that reaches the surface. [rad/s^2]
    boundary
        phi: half width of the layer in which it is smooth. [rad/s]
    observer_pole
        L_o of the disturbance observer. [1/s]

    Raises
    ------
    ParameterError
        If a value is not finite or negative, or the layer has no width.

    Examples
    --------
    >>> mode = SlidingModeController.for_joint(JointControllerParameters(inertia=4.0), disturbance=8.0)
    >>> mode.gain, round(mode.gain / mode.boundary, 6), mode.tuned
    (2.0, 15.0, 4)
    """

    name: ClassVar[str] = "sliding-mode"
    tuned: ClassVar[int] = 4
    surface: float = 6.0
    gain: float = 2.0
    boundary: float = 2.0 / 15.0
    observer_pole: float = 6.0

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.boundary > 0:
            raise ParameterError(
                "boundary = 0 rad/s: a switching term without a boundary layer would throw the valves from end to end "
                "at every noise of the encoder. Pass a width such as gain/15."
            )

    @classmethod
    def for_joint(
        cls,
        parameters: JointControllerParameters,
        mean: float = MEAN,
        disturbance: float = DISTURBANCE,
    ) -> SlidingModeController:
        r"""Surface and observer at the paper's :math:`\lambda`; W from the residual of the calibration.

        .. math:: L = L_o = \lambda,\quad W = \bar d/M,\quad W/\phi = \max(k_{pressure}/4, \lambda)

        with :math:`\bar d` = `disturbance` [Nm], the bound of the unknown torque: three times the residual of the
        calibration sweeps, most of which is hysteresis. The layer is as thin as the pressure loops allow.
        """
        gain = disturbance / parameters.inertia
        steepness = max(parameters.pressure_gain / REACHING, parameters.pole)
        return cls(parameters.pole, gain, gain / steepness, parameters.pole)


@dataclass(frozen=True)
class OneValveController(_Law):
    r"""One 5/3-way valve for both muscles (Krichel, Sawodny, Hildebrandt 2010), flat output: the position.

    The spool fills one muscle while it exhausts the other: the valve commands are c and -c, the mean pressure is not
    controlled. For each sign of the opening s exactly one s gives a desired rate of the pressure difference,

    .. math:: \dot{\Delta p} = G_\pm(p_1, p_2, q)\, s + \text{drift}(p_1, p_2, q, \dot q)

    and the desired one is that of :math:`\Delta p_d` along the reference, at the mean pressure that is measured, plus
    :math:`k_{\Delta p} (\Delta p_d - \Delta p)`; :math:`\Delta p_d` is the paper's position law with the poles at
    `pole`. Without position control the pressure difference alone is imposed. Structure: medium confidence.

    Its limit: it does not choose the mean pressure, and with it stiffness and range. That settles where the spool's
    leaks balance, at a share of the supply, which therefore has to be set for it.

    Parameters
    ----------
    pole
        All poles of the position error lie at minus this. [1/s]
    pressure_gain
        Pole of the error of the pressure difference. [1/s]
    mean_time
        Over which the mean pressure is averaged for the feedforward. [s]

    Raises
    ------
    ParameterError
        If a value is not finite or negative.

    Examples
    --------
    >>> OneValveController.for_joint(JointControllerParameters()).pole, OneValveController.tuned
    (6.0, 3)
    """

    name: ClassVar[str] = "one-valve"
    tuned: ClassVar[int] = 3  # with the supply, which decides where the mean pressure rests
    pole: float = 6.0
    pressure_gain: float = 60.0
    mean_time: float = 1 / 6

    @classmethod
    def for_joint(
        cls,
        parameters: JointControllerParameters,
        mean: float = MEAN,
        disturbance: float = DISTURBANCE,
    ) -> OneValveController:
        r"""The paper's :math:`\lambda` and pressure gain; the mean pressure is averaged over :math:`1/\lambda`."""
        time = 0.0  # not averaged
        if parameters.pole > 0:
            time = 1 / parameters.pole
        return cls(parameters.pole, parameters.pressure_gain, time)


Law: TypeAlias = PidController | VoMinhController | SlidingModeController | OneValveController

_RECORDS = (VoMinhController, SlidingModeController, OneValveController, PidController)

LAWS: Mapping[str, Callable[..., Law]] = MappingProxyType(
    {record.name: record.for_joint for record in _RECORDS}
)
"""Name of a reviewed controller -> function that derives its record: ``LAWS["pid"](parameters, mean, disturbance)``."""

CONTROLLERS = (PAPER, *LAWS)
"""Names of all controllers that run on the joint; "paper" is that of the core."""

TUNED: Mapping[str, int] = MappingProxyType(
    {PAPER: 1} | {record.name: record.tuned for record in _RECORDS}
)
"""How many numbers of a controller a person has to choose; of the paper's it is lambda. Numbers that all controllers
share, of pressure loops, observer and anti-windup, are not counted, nor those that a calibration measures."""


def derived_law(
    name: str,
    parameters: JointControllerParameters,
    mean: float = MEAN,
    disturbance: float = DISTURBANCE,
) -> Law | None:
    """Return the record of a controller for a joint; None for the paper's, which needs none.

    Parameters
    ----------
    name
        Of `CONTROLLERS`.
    parameters
        Of the joint's controller.
    mean
        Mean pressure of the motion. [Pa]
    disturbance
        Bound of the unknown torque. [Nm]

    Examples
    --------
    >>> derived_law("paper", JointControllerParameters()) is None
    True
    >>> derived_law("one-valve", JointControllerParameters(pole=8.0)).pole
    8.0
    """
    if name not in CONTROLLERS:
        raise ParameterError(
            f"no controller '{name}'. There are: {', '.join(CONTROLLERS)}.", name=name
        )
    if name == PAPER:
        return None
    return LAWS[name](parameters, mean, disturbance)


def stiffness_and_slope(
    parameters: JointControllerParameters, mean: float = MEAN
) -> tuple[float, float]:
    """Return K = -dQ/dq [Nm/rad], at least 1, and B [Nm/Pa] in the middle of the range, both muscles at `mean` [Pa].

    Examples
    --------
    >>> stiffness, slope = stiffness_and_slope(JointControllerParameters())
    >>> round(stiffness, 1), round(1e5 * slope, 2)
    (190.3, 34.86)
    """
    low, high = parameters.angle_low, parameters.angle_high
    middle = 0.5 * (low + high)
    # The stiffness is the secant over a tenth of the range.
    q = middle + 0.05 * (high - low) * np.array([-1.0, 1.0])
    a = np.polynomial.polynomial.polyval(q, parameters.a)
    b = np.polynomial.polynomial.polyval(q, parameters.b)
    c = np.polynomial.polynomial.polyval(q, parameters.c)
    torque = a * mean + c
    return max(float((torque[0] - torque[1]) / (q[1] - q[0])), 1.0), float(b.mean())


def law_parameters(law: Any) -> dict[str, float] | None:
    """Return the parameters of a record for the native controller; None for the paper's."""
    if law is None:
        return None
    if not isinstance(law, _Law):
        raise ParameterError(
            f"the law is a {type(law).__name__}; pass a record of dehyst_robot.control._reviewed such as "
            f"derived_law('pid', parameters), None for the paper's controller, or in an arm one of your own, with "
            f"reset(reading, period) and step(reading, reference)."
        )
    return law.as_dict()
