"""The reviewed controllers as laws: what they answer to sensors and references, alone, without an arm."""

import math
from dataclasses import astuple, fields

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dehyst.errors import ParameterError
from dehyst.models import DirectInverse, PrandtlIshlinskii
from dehyst_robot.control import (
    FLAGS,
    SWITCHES,
    JointController,
    JointControllerParameters,
    JointReference,
    OneValveController,
)
from dehyst_robot.control._reviewed import (
    CONTROLLERS,
    LAWS,
    TUNED,
    PidController,
    SlidingModeController,
    VoMinhController,
    derived_law,
    stiffness_and_slope,
)

P = JointControllerParameters()
POSITION, INTEGRATOR, COMPENSATOR = (
    SWITCHES[name] for name in ("position", "integrator", "compensator")
)
ALL = POSITION | INTEGRATOR | COMPENSATOR
BAR = 1e5
STOPS = DirectInverse(radii=[0.01, 0.05], stop_weights=[60.0, 40.0], polynomial=[0.0])
PLAYS = PrandtlIshlinskii(thresholds=[0.0, 0.02, 0.1], weights=[0.7, 0.2, 0.1])


def bench(name, compensator=None, law=None, parameters=P):
    controller = JointController(parameters, compensator, law=law or derived_law(name, parameters))
    controller.reset(0.0, 3 * BAR, 3 * BAR)
    return controller


def wandering(seed, samples=4000):
    """Readings and references of a joint that moves smoothly, with noise on the pressures."""
    draw = np.random.default_rng(seed)
    t = P.period * np.arange(samples)
    w = draw.uniform(1.0, 6.0, 3)
    q = 0.2 * np.sin(w[0] * t)
    p_1, p_2 = (
        3 * BAR + 0.8 * BAR * s * np.sin(w[1] * t) + draw.normal(0, 200.0, samples) for s in (1, -1)
    )
    table = np.zeros((samples, len(fields(JointReference))))
    table[:, 0], table[:, 1] = 0.25 * np.sin(w[2] * t), 0.25 * w[2] * np.cos(w[2] * t)
    table[:, 2], table[:, 3] = -0.25 * w[2] ** 2 * np.sin(w[2] * t), 3.0
    table[:, 4], table[:, 5] = 3 * BAR, 0.5 * BAR * np.sin(t)
    return np.round(q / P.angle_step) * P.angle_step, p_1, p_2, table


def same(a, b):
    return all(np.array_equal(x, y) for x, y in zip(astuple(a), astuple(b), strict=True))


def test_every_controller_has_a_record_and_the_paper_none():
    assert CONTROLLERS == ("paper", "vo-minh", "sliding-mode", "one-valve", "pid")
    assert derived_law("paper", P) is None
    assert all(derived_law(name, P).name == name and TUNED[name] >= 1 for name in LAWS)


@pytest.mark.parametrize("name", LAWS)
def test_defaults_are_the_numbers_of_the_default_joint(name):
    derived, default = derived_law(name, P), type(derived_law(name, P))()
    assert np.allclose(astuple(default), astuple(derived), rtol=5e-3)


def test_the_pid_places_the_poles_of_the_nominal_joint_where_the_paper_does():
    stiffness, slope = stiffness_and_slope(P)
    pid = PidController.for_joint(P)
    poles = np.roots(
        [
            P.inertia,
            slope * pid.derivative,
            stiffness + slope * pid.proportional,
            slope * pid.integral,
        ]
    )
    assert np.allclose(poles, -P.pole, atol=1e-3)


def test_a_joint_stiffer_than_its_poles_gets_no_negative_gain():
    light = JointControllerParameters(inertia=0.05)
    assert PidController.for_joint(light).proportional == 0.0
    stiffness, slope = stiffness_and_slope(light)
    pid = PidController.for_joint(light)
    assert (
        np.roots(
            [light.inertia, slope * pid.derivative, stiffness, slope * pid.integral]
        ).real.max()
        < 0
    )


@pytest.mark.parametrize(("inertia", "gain"), [(2.0, 60.0), (4.0, 60.0), (6.0, 40.0)])
def test_the_pi_of_vo_minh_keeps_its_margins_on_the_nominal_joint(inertia, gain):
    parameters = JointControllerParameters(inertia=inertia, pressure_gain=gain)
    law = VoMinhController.for_joint(parameters)
    stiffness, slope = stiffness_and_slope(parameters)
    damping, lag = 0.1 * math.sqrt(stiffness * inertia), 1 / gain

    def slowest(p, i):
        loop = np.polymul(np.polymul([inertia, damping, stiffness], [lag, 1.0]), [1.0, 0.0])
        return np.roots(
            np.polyadd(loop, [slope * p * law.proportional, slope * i * law.integral])
        ).real.max()

    assert slowest(1.0, 1.0) < 0
    assert slowest(1.0, 3.99) < 0 < slowest(1.0, 4.01)
    assert slowest(7.99, 0.0) < 1e-9 < slowest(8.01, 0.0)


@pytest.mark.parametrize("name", ["pid", "vo-minh", "sliding-mode"])
@pytest.mark.parametrize("compensator", [None, STOPS, PLAYS], ids=["none", "stops", "plays"])
def test_without_position_control_a_law_is_the_papers_to_the_bit(name, compensator):
    signals = wandering(1)
    off = np.full(signals[0].size, COMPENSATOR)
    assert same(
        bench(name, compensator).run(*signals, off), bench("paper", compensator).run(*signals, off)
    )


@pytest.mark.parametrize("name", CONTROLLERS)
def test_a_law_starts_anew_to_the_bit(name):
    signals = wandering(2)
    on = np.full(signals[0].size, ALL)
    controller = bench(name, STOPS)
    first = controller.run(*signals, on)
    controller.reset(0.0, 3 * BAR, 3 * BAR)
    assert same(first, controller.run(*signals, on))


@pytest.mark.parametrize("name", LAWS)
def test_commands_and_desired_pressures_stay_within_their_limits(name):
    draw = np.random.default_rng(3)
    q, p_1, p_2, table = wandering(3)
    table[:, 0] = draw.uniform(-3.0, 3.0, q.size)  # nothing a joint can follow
    table[:, 3] = draw.uniform(-500.0, 500.0, q.size)
    out = bench(name, PLAYS).run(q, p_1, p_2, table, np.full(q.size, ALL))
    assert max(np.abs(out.valve_1).max(), np.abs(out.valve_2).max()) <= 1.0
    if name != "one-valve":  # which cannot choose them
        desired = np.stack([out.desired_1, out.desired_2])
        assert desired.min() >= P.pressure_low and desired.max() <= P.pressure_high
    assert np.abs(out.desired_1 - out.desired_2).max() <= (P.pressure_high - P.pressure_low) * (
        1 + 1e-12
    )
    assert out.raised("pressure-limit").any()
    assert np.isfinite(astuple(out)[:-1]).all()


@pytest.mark.parametrize("name", LAWS)
@pytest.mark.parametrize("lost", [0, 1, 2], ids=["angle", "pressure 1", "pressure 2"])
def test_a_sensor_that_dies_closes_the_valves(name, lost):
    signals = list(wandering(4))
    signals[lost] = signals[lost].copy()
    signals[lost][1000:] = np.nan
    out = bench(name).run(*signals, np.full(signals[0].size, ALL))
    end = 1000 + P.hold_samples + 1
    assert not (out.flags[:1000] & FLAGS["failed"]).any()
    assert out.raised("failed")[end:].all()
    assert not out.valve_1[end:].any() and not out.valve_2[end:].any()
    assert np.isfinite(astuple(out)[:-1]).all()


@pytest.mark.parametrize("name", LAWS)
def test_a_reference_that_is_no_number_is_held(name):
    q, p_1, p_2, table = wandering(5, 400)
    held = table.copy()
    held[200:] = held[199]
    table[200:, 0] = np.nan
    on = np.full(q.size, ALL)
    broken, whole = bench(name).run(q, p_1, p_2, table, on), bench(name).run(q, p_1, p_2, held, on)
    assert np.array_equal(broken.valve_1, whole.valve_1)
    assert broken.raised("reference-fault")[200:].all()


@pytest.mark.parametrize("name", LAWS)
def test_switching_position_control_on_makes_no_step_of_the_pressures(name):
    q, p_1, p_2, table = wandering(6, 800)
    table[:, :4], p_1, p_2 = 0.0, np.full(800, 3.2 * BAR), np.full(800, 2.8 * BAR)
    table[:, 0], table[:, 5] = 0.3, 0.4 * BAR
    on = np.where(np.arange(800) < 400, 0, ALL)
    out = bench(name, STOPS).run(np.zeros(800), p_1 + 50 * q, p_2, table, on)
    steps = np.abs(np.diff(np.clip(out.pressure_difference, -5.8 * BAR, 5.8 * BAR)))
    assert steps[395:405].max() < 0.02 * BAR


def test_vo_minh_feeds_forward_the_sum_of_stop_operators():
    q, p_1, p_2, table = wandering(7, 8000)
    table[:, 3] = 0.0
    off, on = (
        bench("vo-minh", STOPS).run(q, p_1, p_2, table, np.full(q.size, POSITION | x))
        for x in (0, COMPENSATOR)
    )
    start = round(P.ramp / P.period) + 1  # faded in
    q_d, z = table[:, 0], np.zeros(2)
    radii, stops = np.array([0.01, 0.05]), np.zeros(q_d.size)
    for k, x in enumerate(q_d):  # each one x - play, from an angle of 0 with nothing remembered
        z = np.maximum(x - radii, np.minimum(x + radii, z))
        stops[k] = np.dot([60.0, 40.0], x - z)
    slope = np.polynomial.polynomial.polyval(q_d, P.b)
    extra = on.pressure_difference - off.pressure_difference
    assert np.allclose((extra * slope)[start:], stops[start:], atol=1e-6)
    assert np.abs(stops).max() > 2.0


def test_vo_minh_feeds_forward_the_static_model_and_no_inertia():
    law = VoMinhController(0.0, 0.0)
    steady = JointControllerParameters(frozen_samples=0)
    out = bench("vo-minh", law=law, parameters=steady)
    for _ in range(2000):  # the fades are over
        got = out.step(0.0, 3 * BAR, 3 * BAR, JointReference(0.2, 0.0, 50.0, load=4.0), POSITION)
    a, b, c = (np.polynomial.polynomial.polyval(0.2, k) for k in (P.a, P.b, P.c))
    assert got.pressure_difference == pytest.approx((4.0 - a * 3 * BAR - c) / b, rel=1e-9)


def test_the_pid_answers_to_angle_and_encoder_alone():
    table = np.zeros((600, 7))
    table[:, 4] = 3 * BAR
    on = np.full(600, POSITION)
    p = np.full(600, 3 * BAR) + np.random.default_rng(0).normal(0, 200, 600)
    plain = bench("pid").run(np.zeros(600), p, p[::-1], table, on)
    table[:, 2], table[:, 3] = 30.0, 20.0  # acceleration and load: an inverse dynamics would answer
    told = bench("pid").run(np.zeros(600), p, p[::-1], table, on)
    assert np.array_equal(plain.pressure_difference, told.pressure_difference)


def test_the_integrator_is_switched_and_fades():
    q, p_1, p_2, table = wandering(8, 4000)
    table[:, 0], table[:, 1:4] = 0.1, 0.0
    on = np.where(np.arange(4000) < 2000, POSITION | INTEGRATOR, POSITION)
    steady = JointControllerParameters(frozen_samples=0)
    for name in ("pid", "vo-minh", "one-valve"):
        out = bench(name, parameters=steady).run(0 * q, p_1, p_2, table, on)
        assert abs(out.integrator[1999]) > 0.1
        assert out.integrator[-1] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(
    "record", [PidController, VoMinhController, SlidingModeController, OneValveController]
)
def test_numbers_that_are_none_are_refused(record):
    first = fields(record)[0].name
    for wrong in (-1.0, math.nan, math.inf, "much"):
        with pytest.raises(ParameterError, match=first):
            record(**{first: wrong})


def test_a_sliding_mode_needs_a_boundary_layer():
    with pytest.raises(ParameterError, match="from end to end"):
        SlidingModeController(boundary=0.0)


def test_what_is_no_law_and_no_name_is_refused():
    with pytest.raises(ParameterError, match="pass a record"):
        JointController(P, law="pid")
    with pytest.raises(ParameterError, match="no controller 'lqr'"):
        derived_law("lqr", P)


def test_a_reviewed_controller_has_no_image():
    controller = bench("pid")
    with pytest.raises(ParameterError, match="has no image"):
        controller.save()
    with pytest.raises(ParameterError):
        controller.restore(bench("paper").save())


def test_one_valve_commands_both_sides_of_one_spool():
    q, p_1, p_2, table = wandering(9)
    for switches in (0, POSITION, ALL):
        out = bench("one-valve", STOPS).run(q, p_1, p_2, table, np.full(q.size, switches))
        assert np.array_equal(out.valve_1, -out.valve_2)
        assert np.abs(out.valve_1).max() > 0.02


@pytest.mark.parametrize("seed", range(5))
def test_the_opening_of_one_valve_makes_the_wanted_rate_of_the_pressure_difference(seed):
    """Both chambers by themselves, as the plant has them, at the opening that was commanded."""
    draw = np.random.default_rng(seed)
    q, p = draw.uniform(-0.4, 0.4), draw.uniform(1.5, 4.5, 2) * BAR
    controller = bench("one-valve")
    controller.reset(q, *p)
    out = controller.step(q, *p, JointReference(pressure_difference=p[0] - p[1]), 0)
    wished = p[0] - p[1] + draw.uniform(0.005, 0.02) * draw.choice([-1, 1]) * BAR
    first = controller.step(q, *p, JointReference(pressure_difference=wished), 0)
    change = (wished - (p[0] - p[1])) / (
        P.period + 1e-3
    )  # smoothed derivative, then the pole of the error
    rate = change + 60.0 * (first.desired_1 - first.desired_2 - (p[0] - p[1]))
    air = P.pneumatics
    opening = (abs(first.valve_1) - air.dead_band) / (1 - air.dead_band)
    rates = [0.0, 0.0]
    for i, sign in enumerate(np.sign([first.valve_1, first.valve_2])):
        inside = p[i] + air.ambient
        up, down = (air.supply, inside) if sign > 0 else (inside, air.ambient)
        share = max((down / up - air.ratio) / (1 - air.ratio), 0.0)
        flow = (
            sign * opening * air.conductance * air.reference_density * up * math.sqrt(1 - share**2)
        )
        volume = np.polynomial.polynomial.polyval(q, P.volume[i])
        rates[i] = air.polytropic * air.gas_temperature * flow / volume
    assert abs(out.valve_1) < 0.2 and opening > 0.01
    assert rates[0] - rates[1] == pytest.approx(rate, rel=1e-6)
    assert rates[0] * rates[1] < 0


def test_the_disturbance_observer_finds_a_constant_torque_whatever_is_compensated():
    """A joint that stands still under pressures which the characteristic does not explain."""
    steady = JointControllerParameters(frozen_samples=0)
    for compensator in (None, STOPS):
        controller = bench("sliding-mode", compensator, parameters=steady)
        controller.reset(0.0, 3 * BAR, 3 * BAR)
        for k in range(6000):  # 3 s: 18 times its time constant
            out = controller.step(0.0, 3.05 * BAR, 2.95 * BAR, JointReference(angle=0.1), ALL)
            if k == 0:
                first = controller.disturbance
        known = out.compensation * P.b[0] if compensator else 0.0
        assert controller.disturbance == pytest.approx(P.b[0] * 0.1 * BAR - known, abs=1e-3)
        assert first == pytest.approx(P.b[0] * 0.1 * BAR, abs=1.0)  # as the core's observer has it
        assert compensator is None or known > 2.0


HOSTILE = st.one_of(
    st.floats(allow_nan=True, allow_infinity=True),
    st.sampled_from([0.0, 0.1, 3e5, 1e100, -1e100, 1e308]),
)


@pytest.mark.parametrize("name", LAWS)
@settings(max_examples=40, deadline=None, derandomize=True)
@given(st.lists(st.tuples(*(HOSTILE for _ in range(10))), min_size=1, max_size=12))
def test_whatever_the_numbers_are_the_valves_get_commands(name, rows):
    patient = JointControllerParameters(hold_samples=1000, angle_jump=0.0, pressure_jump=0.0)
    table = np.array(rows)
    out = bench(name, STOPS, parameters=patient).run(
        *table[:, :3].T, table[:, 3:], np.full(len(rows), ALL)
    )
    for valve in (out.valve_1, out.valve_2):
        assert np.isfinite(valve).all() and np.abs(valve).max() <= 1.0
    assert (
        np.isfinite(out.desired_1).all()
        and np.isfinite(out.integrator).all()
        and np.isfinite(out.torque).all()
    )
