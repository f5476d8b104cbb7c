"""Calibration: the plant's own static map comes back, against that map written a second time in numpy."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.polynomial.polynomial import polyval

from dehyst.errors import ParameterError, SimulationError
from dehyst_robot.arm import Arm, load_robot, pneumatic_joint_parameters
from dehyst_robot.experiments import calibrate, controller_parameters, home, nominal_characteristic
from dehyst_robot.experiments._calibration import fit_characteristic, nominal_forces
from dehyst_robot.experiments._equipment import local_characteristic
from dehyst_robot.experiments._policy import POLICY
from experiment_samples import calibrated, robot

GRID = np.linspace(-0.4, 0.4, 33)


def force(muscle, p, kappa):
    """The published map of the DMSP-40, from the design, with the muscle's own scatter of the largest force."""
    km, p_ref = 0.25, 6.2e5
    return muscle["coefficient"][0] * (
        0.122366 * np.expm1(-10.47143 * kappa / km)
        + p / p_ref * np.exp(-2.023288 * (kappa / km) ** 2)
    )


def map_of_the_plant(arm, number, q, seed=0):
    """A, B and C of a joint from the map at three pairs of pressures: it is affine in them."""
    physics = pneumatic_joint_parameters(arm, number, seed)
    first, second = physics["muscle"]
    turn = physics["arm"][0][0] / first["length"] * q

    def torque(p1, p2):
        return physics["arm"][0][0] * (
            force(first, p1, 0.11 + turn) - force(second, p2, 0.11 - turn)
        )

    c = torque(0.0, 0.0)
    return torque(1.0, 1.0) - c, (torque(1.0, -1.0) - c) / 2, c


@pytest.mark.parametrize("number", [1, 2, 4])
def test_the_calibration_recovers_the_static_map_of_the_plant(number):
    a, b, c = map_of_the_plant(robot(), number, GRID)
    found = calibrated(number)
    assert found.b[0] == pytest.approx(b[16], rel=0.05)
    np.testing.assert_allclose(polyval(GRID, found.b), b, rtol=0.06)
    line = np.polynomial.Polynomial.fit

    def stiffness(a, c):  # at 3 bar over half of the range
        return -line(GRID, 3e5 * a + c, 3).deriv()(0.0)

    assert stiffness(polyval(GRID, found.a), polyval(GRID, found.c)) == pytest.approx(
        stiffness(a, c), rel=0.08
    )
    torque = polyval(GRID, found.a) * 3e5 + polyval(GRID, found.c) - 3e5 * a - c
    inner = np.abs(GRID) < 0.31
    assert (
        np.abs(torque[inner]).max() < 10.0
    )  # [Nm] of +-60: creep, and what of the hysteresis did not cancel


def test_another_muscle_is_another_calibration():
    b = map_of_the_plant(robot(), 1, GRID, seed=5)[1]
    found = calibrate(robot(), 1, seed=5)
    assert found.b[0] == pytest.approx(b[16], rel=0.05)
    assert not np.array_equal(found.b, calibrated(1).b)


def test_the_same_seed_gives_the_same_calibration_bit_for_bit():
    again = calibrate(robot(), 1)
    assert all(np.array_equal(getattr(again, k), getattr(calibrated(1), k)) for k in "abc")


def torque_over_pressure(sweeps, degree=5):
    """B(0) of the regression that was not chosen: Q on dp, instead of dp on Q."""
    q, dp, mean, torque = np.concatenate(sweeps).T
    power = q[:, None] ** np.arange(degree + 1)
    columns = np.hstack([power * (mean / 1e5)[:, None], power * (dp / 1e5)[:, None], power])
    return np.linalg.lstsq(columns, torque, rcond=None)[0][degree + 1] / 1e5


@pytest.mark.parametrize("number", [1, 4])
def test_torque_over_pressure_would_make_b_too_small_and_pressure_over_torque_does_not(number):
    true = map_of_the_plant(robot(), number, GRID)[1][16]
    assert 0.85 < torque_over_pressure(calibrated(number).sweeps) / true < 0.96
    assert 0.97 < calibrated(number).b[0] / true < 1.03


@cache
def without_friction():
    changes = {"hysteresis.mechanism": "none", "hysteresis.creep": 0.0, "calibration.sweep_s": 24.0}
    return calibrate(robot().with_changes(changes), 1)


@pytest.mark.slow
def test_without_hysteresis_and_creep_only_viscosity_and_noise_are_left_over():
    a, b, _ = map_of_the_plant(load_robot(conditions="kind"), 1, GRID)
    found = without_friction()
    assert found.residual < 1.0 < calibrated(1).residual  # [Nm]
    np.testing.assert_allclose(polyval(GRID, found.b), b, rtol=0.02)
    np.testing.assert_allclose(polyval(GRID, found.a), a, rtol=0, atol=0.02 * np.abs(a).max())


@pytest.mark.slow
def test_a_joint_that_stands_still_while_its_weight_is_changed_is_calibrated():
    realistic = load_robot(conditions="realistic")
    found = calibrate(realistic, 4)  # its play and hysteresis hold it for 0.2 s
    assert found.b[0] == pytest.approx(nominal_characteristic(realistic, 4).b[0], rel=0.2)


def test_slack_samples_are_left_out_and_only_those():
    sweeps = {"mean_pressures_bar": [1.6, 3.0], "loads_bar": [0.0], "sweep_s": 10.0}
    wide = load_robot(conditions="kind", changes={"calibration": sweeps})
    found = calibrate(wide, 1)
    least = POLICY.slack * nominal_forces(wide, 1, np.zeros(1), np.full((1, 2), 3e5)).mean()
    kept = []
    for sweep in found.sweeps:
        q, dp, mean, _ = sweep.T
        pressure = np.stack([mean + dp / 2, mean - dp / 2], axis=1)
        assert nominal_forces(wide, 1, q, pressure).min() > least
        kept.append(q.size)
    assert kept[0] < 0.8 * kept[1]  # at 1.6 bar a muscle hangs slack over much of the way
    assert kept[1] == pytest.approx(10.0 / 0.05, abs=3)  # at 3 bar over none of it


def test_sweeps_with_slack_muscles_only_are_refused_with_their_cure():
    with pytest.raises(
        ParameterError, match=r"joint 1 left \d+ samples .* calibration\.mean_pressures_bar"
    ):
        sweeps = {"mean_pressures_bar": [0.8, 0.9], "loads_bar": [0.0], "sweep_s": 5.0}
        calibrate(load_robot(conditions="kind", changes={"calibration": sweeps}), 1)


def test_a_sweep_that_is_slack_throughout_is_left_out():
    sweeps = {"mean_pressures_bar": [0.8, 3.0, 4.0], "loads_bar": [0.0], "sweep_s": 10.0}
    found = calibrate(load_robot(conditions="kind", changes={"calibration": sweeps}), 1)
    assert [round(sweep[:, 2].mean() / 1e5) for sweep in found.sweeps] == [3, 4]


coefficient = st.floats(-1.0, 1.0, allow_subnormal=False)


@given(
    b=st.floats(5e-5, 1e-3),
    a=st.lists(coefficient, min_size=4, max_size=4),
    c=st.lists(coefficient, min_size=4, max_size=4),
    loads=st.tuples(st.floats(-30, -5), st.floats(5, 30)),
)
def test_exact_data_give_the_characteristic_exactly(b, a, c, loads):
    a, c = 6e-4 * np.array(a), 20.0 * np.array(c)
    q = np.linspace(-0.6, 0.5, 41)
    sweeps = []
    for mean in (2e5, 3e5, 4e5):
        for load in loads:
            dp = (load - polyval(q, a) * mean - polyval(q, c)) / b
            sweeps.append(np.stack([q, dp, np.full(q.size, mean), np.full(q.size, load)], axis=1))
    found = fit_characteristic(sweeps, 3)
    np.testing.assert_allclose(found.b, [b, 0, 0, 0], rtol=1e-7, atol=1e-7 * b)
    np.testing.assert_allclose(found.a, a, rtol=0, atol=1e-10)
    np.testing.assert_allclose(found.c, c, rtol=0, atol=1e-5)
    assert found.residual < 1e-6 and (found.low, found.high) == (-0.6, 0.5)
    sweep = sweeps[0]
    np.testing.assert_allclose(
        found.difference(sweep[:, 0], 2e5, loads[0]), sweep[:, 1], rtol=1e-6, atol=1.0
    )


@given(slope=st.floats(-0.3, 0.3), bend=st.floats(-0.3, 0.3), stiffness=st.floats(50, 250))
def test_a_b_that_changes_with_the_angle_is_followed(slope, bend, stiffness):
    q = np.linspace(-0.6, 0.6, 61)
    beta = (1 + slope * q + bend * q**2) / 35e-5
    sweeps = [
        np.stack(
            [q, (load + stiffness * q * mean / 3e5) * beta, np.full(61, mean), np.full(61, load)],
            axis=1,
        )
        for mean in (2e5, 4e5)
        for load in (-25.0, 0.0, 25.0)
    ]
    found = fit_characteristic(sweeps, 5)
    np.testing.assert_allclose(polyval(q, found.b), 1 / beta, rtol=1e-3)
    np.testing.assert_allclose(polyval(q, found.a) * 3e5, -stiffness * q, atol=0.2)


def through_the_loop(found, mean):
    """The sweep without load at a mean pressure, and the polynomial through its loop."""
    sweep = next(
        s for s in found.sweeps if abs(s[:, 2].mean() - mean) < 2e3 and abs(s[:, 3]).mean() < 1.0
    )
    q, dp = sweep[:, 0], sweep[:, 1]
    return sweep, polyval(q, np.polynomial.polynomial.polyfit(q, dp, 5))


@pytest.mark.slow
def test_the_local_characteristic_goes_through_the_loop_at_3_bar():
    full = load_robot(conditions="kind", changes={"calibration.sweep_s": 10.0})
    found = calibrate(full, 1)
    sweep, middle = through_the_loop(found, 3e5)
    local = local_characteristic(full, found)
    q, _, mean, torque = sweep.T
    assert np.abs(local.difference(q, mean, torque) - middle).max() < 0.01e5  # of +-3 bar
    assert (
        np.abs(found.difference(q, mean, torque) - middle).max() > 0.02e5
    )  # the calibrated one does not
    assert np.array_equal(local.a, found.a) and np.array_equal(local.b, found.b)


def test_without_a_sweep_at_3_bar_the_local_characteristic_goes_through_the_nearest_loop():
    found = calibrated(1)  # at 2.2 and 3.8 bar
    local = local_characteristic(robot(), found)
    for_3_bar = [x.difference(GRID, 3e5) for x in (found, local)]
    assert np.abs(for_3_bar[0] - for_3_bar[1]).max() < 0.3e5  # no more than its hysteresis


def homed(changes):
    arm = load_robot(conditions="kind", changes={"homing.cycles": 3, **changes})
    plan = {2: nominal_characteristic(arm, 2)}
    joint = Arm(arm, moving=(2,), controllers={2: controller_parameters(arm, 2, plan[2])})
    home(joint, plan)
    return joint.angles[0]


@pytest.mark.parametrize(
    ("changes", "cause"),
    [
        ({"payload.mass_kg": 20.0}, "what hangs on joint 2 takes up to 1.. Nm.*payload.mass_kg"),
        (
            {"air": {"supply_volume_l": 0.5, "supply_conductance_l_s_bar": 0.02}},
            "the supply does not keep up",
        ),
    ],
)
def test_a_homing_that_fails_names_the_load_or_the_supply(changes, cause):
    assert abs(homed({})) < np.radians(3.0)
    with pytest.raises(SimulationError, match=f"homing failed: .*{cause}"):
        homed(changes)


def test_a_homing_with_a_characteristic_that_is_25_Nm_off_is_none():
    arm = load_robot(conditions="kind", changes={"homing.cycles": 3})
    known = nominal_characteristic(arm, 4)
    plan = {4: replace(known, c=known.c + np.eye(known.c.size)[0] * 25.0)}  # [Nm]
    joint = Arm(arm, moving=(4,), controllers={4: controller_parameters(arm, 4, plan[4])})
    with pytest.raises(SimulationError, match="ended with joint 4 at"):
        home(joint, plan)
