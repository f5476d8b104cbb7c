"""Three control laws that a reviewer would name: a disturbance observer, an adapted scale, a predictive controller.

Each runs in Python around the joint's own controller in C, which keeps sensors, observer, characteristic and pressure
loops. So a rival differs from the paper's law in what it claims to do better, and in nothing else.
"""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import fields, replace

import daqp
import numpy as np
import numpy.typing as npt
from scipy.linalg import expm, solve_discrete_are

from dehyst.errors import SimulationError
from dehyst.models import DirectInverse
from dehyst_robot.control import (
    FLAGS,
    SWITCHES,
    Adaptation,
    JointControllerParameters,
    JointOutput,
    JointReference,
    Reading,
)
from dehyst_robot.control import kit as control_kit

Array = npt.NDArray[np.float64]

POSITION, INTEGRATOR = SWITCHES["position"], SWITCHES["integrator"]
COMPENSATOR, DISTURBANCE = SWITCHES["compensator"], SWITCHES["disturbance"]
PLACE = {entry.name: k for k, entry in enumerate(fields(JointOutput))}
OBSERVER_RATIO = 8.0  # an observer is this much faster than the loop that it serves
HORIZON, SAMPLE_S = 20, 0.01  # steps of the prediction, and their length
ESTIMATOR_RATIO = (
    3.0  # the estimator of the predictive controller is this much faster than its loop
)


def no_compensation() -> DirectInverse:
    """Return a direct inverse whose torque is zero: what learns or observes needs one, and nothing is compensated.

    Examples
    --------
    >>> no_compensation().run(np.array([0.0, 0.1, -0.1]), np.array([0.0, 1.0, 2.0])).u.tolist()
    [0.0, 0.0, 0.0]
    """
    return DirectInverse(radii=np.ones(1), stop_weights=np.zeros(1))


class Around:
    """The joint's controller with the switches of a trial; rivals change its reference or its switches.

    Parameters
    ----------
    parameters
        Of the controller.
    switches
        What is on.
    compensator, adaptation
        As for `JointController`.
    """

    def __init__(
        self,
        parameters: JointControllerParameters,
        switches: int,
        compensator: DirectInverse | None = None,
        adaptation: Adaptation | None = None,
    ) -> None:
        self.parameters, self.switches = parameters, switches
        self.native = control_kit.native_controller(parameters, compensator, adaptation, None)
        self.seconds, self.calls = 0.0, 0

    def reset(self, reading: Reading, period: float) -> None:
        """Start at these readings."""
        self.native.reset(reading.angle, reading.pressure_1, reading.pressure_2)

    def step(self, reading: Reading, reference: JointReference) -> tuple[float, float]:
        """Return the commands of both valves; a joint that failed safe ends the trial."""
        begin = time.perf_counter()
        # Without a record of the outputs: that would take longer than the law.
        output = self.native.step(
            reading.angle,
            reading.pressure_1,
            reading.pressure_2,
            self.changed(reading, reference).as_tuple(),
            self.switches,
        )
        if int(output[PLACE["flags"]]) & FLAGS["failed"]:
            raise SimulationError(f"{type(self).__name__}: the joint's controller failed safe.")
        self.learn(reference, output)
        self.seconds += time.perf_counter() - begin
        self.calls += 1
        return output[PLACE["valve_1"]], output[PLACE["valve_2"]]

    def changed(self, reading: Reading, reference: JointReference) -> JointReference:
        """Return the reference that the joint's controller gets."""
        return reference

    def learn(self, reference: JointReference, output: Sequence[float]) -> None:
        """Take in what the joint's controller answered, in the order of `JointOutput`."""


class DisturbanceObserver(Around):
    r"""The paper's law with the observed torque fed back, and no compensator (Ohnishi 1987; Chen et al. 2000).

    The observer of the joint estimates the torque beyond characteristic and known load; behind a first-order filter it
    is added to the desired torque: ``SWITCHES["disturbance"]``.

    Parameters
    ----------
    pole
        Of the filter. [1/s]
    """

    def __init__(self, parameters: JointControllerParameters, switches: int, pole: float) -> None:
        settings = Adaptation(rate=0.0, disturbance_pole=pole)
        super().__init__(parameters, switches | DISTURBANCE, no_compensation(), settings)


class AdaptedScale(Around):
    r"""A Prandtl-Ishlinskii compensator whose scale is learned while it runs (Ioannou, Sun 1996, section 4.3).

    The compensator's term comes as the reference's ``extra``; its torque is :math:`\varphi`. Scale :math:`\theta` and
    offset follow the observed torque by the projected, normalised gradient of `Adaptation`, with its limits.

    Parameters
    ----------
    rate
        Share of an error that is removed in a second of full excitation. [1/s]
    """

    def __init__(self, parameters: JointControllerParameters, switches: int, rate: float) -> None:
        super().__init__(parameters, switches | COMPENSATOR)
        self.settings = Adaptation(rate=rate)
        self.scale, self.offset = 1.0, 0.0
        self.delayed = [0.0, 0.0, 0.0]

    def changed(self, reading: Reading, reference: JointReference) -> JointReference:
        """Scale the compensator's term."""
        slope = horner(self.parameters.b, reference.angle)
        extra = self.scale * reference.extra + self.offset / slope
        return with_extra(reference, extra)

    def learn(self, reference: JointReference, output: Sequence[float]) -> None:
        """Correct scale and offset by the torque that the observer sees and the compensator does not."""
        settings, parameters = self.settings, self.parameters
        signal = horner(parameters.b, reference.angle) * reference.extra
        gain = 1.0 - math.exp(-parameters.observer_pole * parameters.period)
        # The observer shows a torque behind three lags, and so is the signal compared.
        for k in range(3):
            self.delayed[k] += gain * (signal - self.delayed[k])
            signal = self.delayed[k]
        slow = abs(reference.acceleration) <= settings.most_acceleration
        moves = abs(reference.velocity) > settings.least_speed
        if not (slow and moves):
            return
        error = output[PLACE["load"]] - self.scale * signal - self.offset
        step = settings.rate * parameters.period * error
        step /= settings.noise**2 + settings.unit**2 + signal**2
        scale = self.scale + step * signal
        self.scale = min(max(scale, settings.lowest), settings.highest)
        limit = settings.offset_limit
        self.offset = min(max(self.offset + step * settings.unit**2, -limit), limit)


class PredictiveController(Around):
    r"""Linear model predictive control with limits of the pressures, free of offset (Maciejowski 2002; Muske, Badgwell
    2002).

    Characteristic, inertia and load are inverted as in the paper. What is left is linear in :math:`e = q_d - q`,

    .. math:: M \ddot e = d - \tau, \qquad \dot\tau = k_p (v - \tau),

    with the lag of the pressure loops. A Kalman filter estimates :math:`e, \dot e, d` from the encoder. Every 10 ms a
    quadratic program over 20 steps minimises :math:`\sum e^2 + (v - d)^2/(M^2 \omega^4)` with the terminal cost of the
    Riccati equation, so that the pressures stay in their range. Without integrator d is not estimated.

    Parameters
    ----------
    frequency
        :math:`\omega`: both poles of the loop without limits lie at this distance from zero. [1/s]
    """

    def __init__(
        self, parameters: JointControllerParameters, switches: int, frequency: float
    ) -> None:
        observer_pole = max(parameters.observer_pole, OBSERVER_RATIO * frequency)
        # The paper's feedback is off: its pole is zero.
        inner = replace(parameters, pole=0.0, observer_pole=observer_pole)
        super().__init__(inner, POSITION | COMPENSATOR)
        self.offset_free = bool(switches & INTEGRATOR)
        self._design(parameters, frequency)
        self.every = max(1, round(SAMPLE_S / parameters.period))
        self.solve_seconds, self.solves = 0.0, 0

    def _design(self, parameters: JointControllerParameters, frequency: float) -> None:
        inertia, lag = parameters.inertia, parameters.pressure_gain
        # States: error, its rate, torque of the feedback, unknown torque; the last column is the input.
        rates = np.zeros((5, 5))
        rates[0, 1] = 1.0
        rates[1, 2], rates[1, 3] = -1.0 / inertia, 1.0 / inertia
        rates[2, 2], rates[2, 4] = -lag, lag
        discrete = expm(SAMPLE_S * rates)
        self.transition, self.input = discrete[:4, :4], discrete[:4, 4]
        a, b = self.transition[:3, :3], self.input[:3, None]
        weight, effort = np.diag([1.0, 0.0, 0.0]), 1.0 / (inertia**2 * frequency**4)
        last = solve_discrete_are(a, b, weight, np.array([[effort]]))
        free = np.zeros((3 * HORIZON, 3))
        forced = np.zeros((3 * HORIZON, HORIZON))
        power = np.eye(3)
        for k in range(HORIZON):
            response = power @ b
            for j in range(HORIZON - k):
                forced[3 * (j + k) : 3 * (j + k) + 3, j] = response[:, 0]
            power = a @ power
            free[3 * k : 3 * k + 3] = power
        cost = np.kron(np.eye(HORIZON), weight)
        cost[-3:, -3:] = last
        hessian = forced.T @ cost @ forced + effort * np.eye(HORIZON)
        # A cost of the order of 1 suits the tolerances of the solver.
        self.size = 1.0 / float(hessian[0, 0])
        self.hessian = self.size * 0.5 * (hessian + hessian.T)
        self.linear = self.size * (forced.T @ cost @ free)
        wide = np.full(HORIZON, 1e6)
        self.program = daqp.Model()
        self.program.setup(self.hessian, np.zeros(HORIZON), np.zeros((0, HORIZON)), wide, -wide)
        self._estimator(inertia, frequency)

    def _estimator(self, inertia: float, frequency: float) -> None:
        """Gain of the Kalman filter of error, rate and, if it is free of offset, unknown torque."""
        states = [0, 1, 3] if self.offset_free else [0, 1]
        a = self.transition[np.ix_(states, states)]
        pole = ESTIMATOR_RATIO * frequency
        noise = np.zeros((len(states), len(states)))
        # Of a chain of integrators behind white noise all poles lie at one distance from zero.
        if self.offset_free:
            noise[2, 2] = SAMPLE_S**2 * inertia**2 * pole**6
        else:
            noise[1, 1] = SAMPLE_S**2 * pole**4
        c = np.zeros((1, len(states)))
        c[0, 0] = 1.0
        covariance = solve_discrete_are(a.T, c.T, noise, np.array([[1.0]]))
        gain = covariance @ c.T / (c @ covariance @ c.T + 1.0)
        self.gain = np.zeros(4)
        self.gain[states] = gain[:, 0]

    def reset(self, reading: Reading, period: float) -> None:
        """Start at rest."""
        super().reset(reading, period)
        self.state, self.wish, self.torque, self.periods = np.zeros(4), 0.0, 0.0, 0
        self.feedforward = 0.0
        self.slope = horner(self.parameters.b, reading.angle)

    def changed(self, reading: Reading, reference: JointReference) -> JointReference:
        """Add the torque of the feedback, behind the lag that the model has."""
        if self.periods % self.every == 0:
            self._decide(reading, reference)
        self.periods += 1
        parameters = self.parameters
        self.torque += parameters.period * parameters.pressure_gain * (self.wish - self.torque)
        return with_extra(reference, reference.extra + self.torque / self.slope)

    def learn(self, reference: JointReference, output: Sequence[float]) -> None:
        """Remember the pressure difference without feedback: the limits are counted from there."""
        difference, compensation = PLACE["pressure_difference"], PLACE["compensation"]
        self.feedforward = output[difference] - output[compensation]

    def _decide(self, reading: Reading, reference: JointReference) -> None:
        self.slope = horner(self.parameters.b, reading.angle)
        error = reference.angle - reading.angle
        predicted = self.transition @ self.state + self.input * self.wish
        self.state = predicted + self.gain * (error - predicted[0])
        self.state[2] = self.torque
        unknown = self.state[3]
        apart = np.array([self.state[0], self.state[1], self.torque - unknown])
        mean = reference.mean_pressure
        low, high = self.parameters.pressure_low, self.parameters.pressure_high
        room = 2.0 * min(mean - low, high - mean)
        top = np.full(HORIZON, self.slope * (room - self.feedforward) - unknown)
        bottom = np.full(HORIZON, self.slope * (-room - self.feedforward) - unknown)
        begin = time.perf_counter()
        self.program.update(f=self.linear @ apart, bupper=top, blower=bottom)
        answer, _, status, _ = self.program.solve()
        self.solve_seconds += time.perf_counter() - begin
        self.solves += 1
        if status < 1:
            raise SimulationError(f"the quadratic program was not solved: status {status}.")
        self.wish = float(answer[0]) + unknown


def horner(coefficients: tuple[float, ...], x: float) -> float:
    """Return a polynomial's value, lowest power first.

    Examples
    --------
    >>> horner((1.0, 2.0, 3.0), 2.0)
    17.0
    """
    value = 0.0
    for coefficient in reversed(coefficients):
        value = value * x + coefficient
    return value


def with_extra(reference: JointReference, extra: float) -> JointReference:
    """Return a reference with another term beside the compensator's; quicker than `dataclasses.replace`."""
    return JointReference(
        reference.angle,
        reference.velocity,
        reference.acceleration,
        reference.load,
        reference.mean_pressure,
        reference.pressure_difference,
        extra,
    )
