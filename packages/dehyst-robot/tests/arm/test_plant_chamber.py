"""Air in the muscles: balances, bounds, and the order of its integration, against other integrators."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from dehyst_robot._native import muscle_volume, valve_flow
from plant_samples import AIR, VALVE, joint, muscle, parameters

RT = AIR["gas_constant"] * AIR["temperature"]
R = 0.05


def volume(kappa):
    v, slope = muscle_volume(muscle(), np.atleast_1d(np.asarray(kappa, float)))
    return v, slope


def moved(period, steps):
    """A smooth angle as the joint sees it: starts of the steps and speeds within them."""
    t = period * np.arange(steps + 1)
    q = 0.35 * np.sin(3.0 * t)
    return q[:-1], np.diff(q) / period


def test_without_expansion_the_air_that_goes_in_is_the_pressure_that_comes_up():
    made = joint(p=(1e5, 5e5))
    u = np.tile([0.6, -0.4], (400, 1))
    out = made.run(np.zeros(400), np.zeros(400), u, 5e-4)
    v = volume(0.11)[0]
    rise = (out["pressure"] - [2e5, 6e5]) * v / (1.26 * RT)
    np.testing.assert_allclose(out["mass"], rise, rtol=1e-10, atol=1e-18)
    assert out["mass"][-1, 0] > 1e-4 > -1e-4 > out["mass"][-1, 1]


def test_isothermal_air_is_conserved_while_the_muscle_moves():
    made = joint(q=0.0, air={"polytropic": 1.0})
    start, speed = moved(5e-4, 2000)
    u = 0.3 * np.sin(np.outer(np.arange(2000) * 5e-4, [9.0, 7.0]))
    out = made.run(start, speed, u, 5e-4)
    held = (
        out["pressure"]
        * np.column_stack([volume(out["contraction"][:, m])[0] for m in range(2)])
        / RT
    )
    before = 4e5 * volume(0.11)[0] / RT
    np.testing.assert_allclose(held - before, out["mass"], rtol=0, atol=1e-8 * before[0])
    assert np.ptp(held) > 0.1 * before[0]


@pytest.mark.parametrize("polytropic", [1.0, 1.26, 1.4])
def test_a_closed_chamber_keeps_p_v_to_the_n(polytropic):
    made = joint(air={"polytropic": polytropic}, valve={"leak": 0.0})
    start, speed = moved(5e-4, 3000)
    out = made.run(start, speed, np.zeros((3000, 2)), 5e-4)
    v = np.column_stack([volume(out["contraction"][:, m])[0] for m in range(2)])
    np.testing.assert_allclose(
        out["pressure"] * v**polytropic, 4e5 * volume(0.11)[0][0] ** polytropic, rtol=1e-8
    )
    assert np.ptp(out["pressure"]) > 2e4
    assert np.all(out["mass"] == 0)


def test_polytropic_air_takes_up_what_flows_in_while_the_muscle_moves():
    # d(p V^n)/dt = n R T V^(n-1) mdot: summed from the masses of the plant, at mid-step volumes.
    made = joint()
    start, speed = moved(5e-4, 2000)
    u = 0.3 * np.sin(np.outer(np.arange(2000) * 5e-4, [9.0, 7.0]))
    out = made.run(start, speed, u, 5e-4)
    kappa = np.vstack([[0.11, 0.11], out["contraction"]])
    middle = np.column_stack([volume((kappa[1:, m] + kappa[:-1, m]) / 2)[0] for m in range(2)])
    gained = 1.26 * RT * middle**0.26 * np.diff(np.vstack([[0, 0], out["mass"]]), axis=0)
    end = np.column_stack([volume(kappa[1:, m])[0] for m in range(2)])
    expected = (4e5 * volume(0.11)[0] ** 1.26 + np.cumsum(gained, axis=0)) / end**1.26
    np.testing.assert_allclose(out["pressure"], expected, rtol=2e-6)


def exact(duration, u, speed, p0, q0):
    """Muscle 1 by an adaptive integrator of high order: pressure, spool, spool speed."""
    w, d = VALVE["frequency"], VALVE["damping"]

    def rates(t, y):
        p, s, sd = y
        v, slope = volume(0.11 + R * (q0 + speed * t) / 0.4)
        mdot = valve_flow(VALVE, AIR, np.array([s]), np.array([p]))[0]
        dp = 1.26 / v[0] * (RT * mdot - p * slope[0] * speed * R / 0.4)
        return [dp, sd, w * w * (u - s) - 2 * d * w * sd]

    crossing = [lambda t, y: y[1] - 0.03]
    return solve_ivp(
        rates,
        (0, duration),
        [p0, 0.0, 0.0],
        method="DOP853",
        rtol=1e-11,
        atol=1e-9,
        max_step=2e-4,
        events=crossing,
    ).y[:, -1]


def at_end(duration, steps, u, speed, p0, q0, substeps):
    made = joint(q=q0, p=(p0 - 1e5, 3e5), substeps=substeps)
    period = duration / steps
    q = q0 + speed * period * np.arange(steps)
    out = made.run(q, np.full(steps, speed), np.tile([u, 0.0], (steps, 1)), period)
    return out["pressure"][-1, 0], out["spool"][-1, 0]


CASE = {"duration": 0.04, "u": 0.7, "speed": 1.5, "p0": 2.5e5, "q0": -0.3}


def test_pressure_and_spool_agree_with_an_adaptive_integrator():
    p, s, _ = exact(**CASE)
    found, spool = at_end(**CASE, steps=80, substeps=4)
    assert abs(found - p) < 20  # Pa; 9e-4 bar is the claim
    assert abs(spool - s) < 1e-9


def test_the_chamber_converges_with_order_two_in_its_substeps():
    reference = exact(**CASE)[0]
    errors = [abs(at_end(**CASE, steps=20, substeps=n)[0] - reference) for n in (1, 2, 4, 8, 16)]
    order = np.log2(np.array(errors[:-1]) / errors[1:])
    assert errors[0] > 1 > 100 * errors[-1] / errors[0]
    assert 1.6 < np.mean(order) < 2.4


@pytest.mark.parametrize("way", ["fills", "exhausts"])
def test_a_step_of_the_valve_moves_the_pressure_at_the_published_rates(way):
    sign = 1.0 if way == "fills" else -1.0
    made = joint(q=0.0, p=(3e5, 3e5), valve={"conductance": 2.75e-8})
    out = made.run(np.zeros(60), np.zeros(60), np.tile([sign, sign], (60, 1)), 5e-4)
    rate = sign * (out["pressure"][40, 0] - out["pressure"][30, 0]) / (10 * 5e-4) / 1e5
    assert 9 < rate < 40
    assert (rate > 30) == (way == "fills")


commands = st.lists(
    st.tuples(
        *[st.one_of(st.floats(-2, 2), st.sampled_from([np.nan, np.inf, -np.inf, 1e300]))] * 2
    ),
    min_size=1,
    max_size=8,
)


@given(commands, st.sampled_from([1, 4]), st.floats(0.0, 6.9))
def test_no_command_drives_the_pressure_beyond_supply_and_ambient(levels, substeps, start_bar):
    made = joint(p=(start_bar * 1e5, start_bar * 1e5), substeps=substeps)
    u = np.repeat(np.array(levels), 400, axis=0)
    zeros = np.zeros(len(u))
    out = made.run(zeros, zeros, u, 5e-4)
    assert np.all(out["pressure"] >= AIR["ambient"] - 1e-6)
    assert np.all(out["pressure"] <= AIR["supply"] + 1e-6)
    assert np.all(np.abs(out["spool"]) <= 1)


def test_the_pressure_ends_at_supply_and_at_ambient():
    made = joint()
    out = made.run(np.zeros(20000), np.zeros(20000), np.tile([1.0, -1.0], (20000, 1)), 5e-4)
    np.testing.assert_allclose(out["pressure"][-1], [AIR["supply"], AIR["ambient"]], rtol=1e-6)


def test_a_command_that_is_no_number_closes_the_valve():
    u = np.array([[np.nan, 0.5]] * 300)
    closed = np.array([[0.0, 0.5]] * 300)
    first, second = (joint().run(np.zeros(300), np.zeros(300), c, 5e-4) for c in (u, closed))
    assert first["pressure"].tobytes() == second["pressure"].tobytes()


def test_an_angle_that_is_no_number_leaves_the_joint_where_it_is():
    made = joint()
    made.step(0.1, 0.2, 0.3, -0.3, 5e-4)
    before = made.state["contraction"]
    torque = made.step(np.nan, 0.0, 0.3, -0.3, 5e-4)
    assert np.isfinite(torque)
    assert made.state["contraction"] == before
    assert np.isfinite(made.step(0.1, np.inf, 0.0, 0.0, 5e-4))


def test_a_violent_motion_never_makes_a_pressure_negative():
    made = joint(p=(0.0, 0.0), substeps=1)
    q = 0.7 * np.sign(np.sin(np.arange(200)))
    out = made.run(q, np.zeros(200), np.tile([-1.0, -1.0], (200, 1)), 5e-4)
    assert np.all(np.isfinite(out["pressure"]))
    assert np.all(out["pressure"] >= 0)
    assert np.all(out["force"] >= 0)


def test_the_spool_is_exact_for_every_damping():
    for damping in (0.3, 0.7, 1.0, 1.0 + 1e-9, 2.5):
        changed = parameters(valve={"damping": damping, "frequency": 200.0})
        made = type(joint())(changed, 0)
        made.reset(0.0, 3e5, 3e5, 0)
        out = made.run(np.zeros(50), np.zeros(50), np.tile([0.5, -0.5], (50, 1)), 5e-4)
        oracle = solve_ivp(
            lambda t, y, d=damping: [y[1], 200.0**2 * (0.5 - y[0]) - 2 * d * 200.0 * y[1]],
            (0, 0.025), [0, 0], rtol=1e-12, atol=1e-13,
        ).y[0, -1]  # fmt: skip
        assert abs(out["spool"][-1, 0] - oracle) < 1e-8
