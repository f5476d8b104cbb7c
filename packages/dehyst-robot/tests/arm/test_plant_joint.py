"""The whole joint: equations put together, determinism, sensors, states, mechanisms of one's own, runs."""

import gc
import weakref

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dehyst.errors import ParameterError
from dehyst_robot._native import PneumaticJoint, muscle_force
from dehyst_robot.arm import _mechanisms as mechanisms
from dehyst_robot.arm._joints import run_pressures
from plant_oracles import MaxwellSlip
from plant_samples import BUILT_IN, MUSCLE, joint, muscle, parameters

NAMES = pytest.mark.parametrize("name", BUILT_IN)
PERIOD = 5e-4


def swing(steps, amplitude=0.4, hertz=0.5, period=PERIOD):
    q = amplitude * np.sin(2 * np.pi * hertz * period * np.arange(steps + 1))
    return q[:-1], np.diff(q) / period


def commands(steps):
    t = PERIOD * np.arange(steps)
    return np.column_stack([0.4 * np.sin(7 * t), 0.4 * np.cos(5 * t)])


def static(pressure, contraction):
    return muscle_force(
        muscle(), np.ascontiguousarray(pressure - 1e5), np.ascontiguousarray(contraction)
    )


# ---- Equations


def test_without_losses_the_torque_is_that_of_the_two_maps():
    made = joint(viscous_force=0.0, creep_time=[], creep_force=[], creep_pressure=[])
    out = made.run(*swing(4000), commands(4000), PERIOD)
    q = np.append(swing(4000)[0][1:], 0.0)
    np.testing.assert_allclose(out["contraction"][:-1, 0] - 0.11, 0.05 * q[:-1] / 0.4, atol=1e-12)
    np.testing.assert_allclose(out["contraction"].sum(axis=1), 0.22, atol=1e-12)
    f = [np.maximum(0, static(out["pressure"][:, m], out["contraction"][:, m])) for m in range(2)]
    np.testing.assert_allclose(out["torque"], 0.05 * (f[0] - f[1]), rtol=0, atol=1e-9)


def test_the_numbers_of_the_joint_are_those_of_the_literature():
    def torque(q, p1, p2):
        return joint(q=q, p=(p1 * 1e5, p2 * 1e5), viscous_force=0.0).impose(
            q, 0.0, p1 * 1e5, p2 * 1e5, PERIOD
        )

    assert abs(torque(0, 3.5, 2.5) - 34.9) < 0.05  # B(0), Nm/bar
    for mean, stiffness in ((2, 128), (3, 190), (4, 252)):
        assert abs((torque(-0.01, mean, mean) - torque(0.01, mean, mean)) / 0.02 - stiffness) < 1
    for degrees, difference in ((10, 0.95), (20, 1.88), (30, 2.79), (40, 3.77)):
        assert abs(torque(np.radians(degrees), 3 + difference / 2, 3 - difference / 2)) < 0.2


def test_viscous_force_saturates_with_speed():
    still = joint(creep_time=[], creep_force=[], creep_pressure=[]).impose(0.0, 0.0, 3e5, 3e5, 1e-9)
    for qd in (-4.0, -0.1, 0.1, 4.0, 100.0):
        fast = joint(creep_time=[], creep_force=[], creep_pressure=[]).impose(
            0.0, qd, 3e5, 3e5, 1e-9
        )
        v = 0.05 * qd
        assert fast - still == pytest.approx(-2 * 0.05 * 40.0 * v / (0.2 + abs(v)), rel=1e-3)


def test_creep_relaxes_as_its_branches_say_whatever_the_period():
    tau, c = np.array(MUSCLE["creep_time"]), np.array(MUSCLE["creep_force"])
    for period in (5e-4, 0.01):
        made = joint(viscous_force=0.0)
        made.impose(0.0, 0.2 / 1e-6, 3e5, 3e5, 1e-6)  # a jump of 0.2 rad
        steps = round(5.0 / period)
        out = made.run_imposed(
            np.full(steps, 0.2), np.zeros(steps), np.full((steps, 2), 3e5), period
        )
        kappa = 0.05 * 0.2 / 0.4
        for k in (0, steps // 10, steps - 1):
            force = static(out["pressure"][k], out["contraction"][k])[0]
            left = np.sum(c * kappa * np.exp(-period * (k + 1) / tau))
            assert out["force"][k, 0] == pytest.approx(force - left, abs=1e-3)


def test_after_a_pressure_step_the_pull_grows_on_towards_the_map():
    # Under a constant load a muscle goes on in the direction of the step, 1 to 2 % of it a decade of time.
    made = joint(p=(2e5, 2e5), viscous_force=0.0)
    out = made.run_imposed(np.zeros(40000), np.zeros(40000), np.full((40000, 2), 4e5), 0.1)
    force, end = out["force"][:, 0], static(out["pressure"][0], out["contraction"][0])[0]
    assert np.all(np.diff(force) >= 0)
    step = end - static(np.full(2, 3e5), out["contraction"][0])[0]
    decade = (force[999] - force[99]) / step
    assert 0.004 < decade < 0.02
    assert abs(force[-1] - end) < 0.02 * step


@given(st.lists(st.floats(-0.7, 0.7), min_size=2, max_size=6), st.sampled_from([*BUILT_IN, "none"]))
def test_no_closed_path_at_constant_pressure_takes_work_from_a_muscle(turns, name):
    made = joint(
        BUILT_IN[name](80.0, asymmetry=0.1) if name != "none" else None, q=turns[0], p=(6e5, 6e5)
    )
    path = np.interp(
        np.linspace(0, len(turns), 400 * len(turns)), np.arange(len(turns) + 1), [*turns, turns[0]]
    )
    out = made.run_imposed(path[:-1], np.diff(path) / 0.01, np.full((path.size - 1, 2), 6e5), 0.01)
    for m in range(2):
        kappa = np.concatenate(
            [[0.11 + (0.05 if m == 0 else -0.05) * path[0] / 0.4], out["contraction"][:, m]]
        )
        held_back = static(out["pressure"][:, m], out["contraction"][:, m]) - out["force"][:, m]
        pulls = out["force"][:, m] > 0
        assert np.sum((held_back * np.diff(kappa))[pulls]) >= -1e-9


@given(
    st.floats(-1.5, 1.5),
    st.floats(-30, 30),
    st.floats(0, 7e5),
    st.floats(0, 7e5),
    st.sampled_from(list(BUILT_IN)),
)
def test_a_muscle_never_pushes(q, qd, p1, p2, name):
    made = joint(BUILT_IN[name](300.0), q=q, p=(p1, p2))
    for k in range(20):
        torque = made.step(q + qd * k * PERIOD, qd, np.sin(k), np.cos(k), PERIOD)
        force = made.state["force"]
        assert min(force) >= 0
        assert torque == pytest.approx(0.05 * (force[0] - force[1]), abs=1e-12)


@pytest.mark.parametrize(("name", "order"), [("maxwell-slip", 2), ("preisach", 2), ("dahl", 1)])
def test_the_step_converges_with_order_two_and_with_dahl_under_changing_pressure_with_one(
    name, order
):
    def torque(steps):
        made = joint(
            BUILT_IN[name](80.0, asymmetry=0.1), q=-0.2, substeps=1, valve={"dead_band": 0.0}
        )
        period = 0.1 / steps
        q = -0.2 + 2.0 * period * np.arange(steps)
        return made.run(q, np.full(steps, 2.0), np.tile([0.3, -0.3], (steps, 1)), period)["torque"][
            -1
        ]

    reference = torque(51200)
    errors = [abs(torque(n) - reference) for n in (100, 1600)]
    assert errors[0] < 2e-3
    assert np.log2(errors[0] / errors[1]) / 4 > order - 0.2


def test_four_substeps_at_half_a_millisecond_are_converged():
    pressures = []
    for substeps in (4, 64):
        made = joint(BUILT_IN["maxwell-slip"](80.0), substeps=substeps)
        pressures.append(made.run(*swing(8000), commands(8000), PERIOD)["pressure"])
    assert np.max(np.abs(pressures[0] - pressures[1])) < 90  # Pa


# ---- Determinism, sensors, state


def readings(seed, steps=400):
    made = joint(BUILT_IN["preisach"](80.0), seed=seed)
    q, qd = swing(steps)
    u = commands(steps)
    seen = []
    for k in range(steps):
        seen.append(made.sense(q[k], PERIOD))
        made.step(q[k], qd[k], *u[k], PERIOD)
    return np.array(seen), made.save()


def test_the_same_seed_gives_the_same_bits_and_another_seed_does_not():
    first, second, other = readings(7), readings(7), readings(8)
    assert first[0].tobytes() == second[0].tobytes()
    assert first[1] == second[1]
    assert np.all(first[0][:, 0] == other[0][:, 0])  # the encoder has no noise
    assert np.mean(first[0][:, 1:] == other[0][:, 1:]) < 0.01


def test_noise_is_white_normal_and_independent_between_sensors_and_seeds():
    noise = []
    for seed in (1, 2):
        made = joint(seed=seed)
        noise.append(np.array([made.sense(0.0, PERIOD)[1:] for _ in range(40000)]) - 3e5)
    columns = np.concatenate(noise, axis=1) / 250.0
    assert np.all(np.abs(columns.mean(axis=0)) < 0.02)
    np.testing.assert_allclose(columns.std(axis=0), 1.0, atol=0.015)
    np.testing.assert_allclose(np.mean(np.abs(columns) > 2, axis=0), 0.0455, atol=0.005)
    assert np.all(np.abs(np.corrcoef(columns.T) - np.eye(4)) < 0.02)
    assert np.all(np.abs([np.corrcoef(c[1:], c[:-1])[0, 1] for c in columns.T]) < 0.02)


def test_the_encoder_rounds_to_its_step():
    step = 2 * np.pi / 2**17
    made = joint()
    for q in np.random.default_rng(0).uniform(-1, 1, 200):
        angle = made.sense(q, PERIOD)[0]
        assert abs(angle - q) <= step / 2 * (1 + 1e-9)
        assert abs(angle / step - round(angle / step)) < 1e-6


def test_the_pressure_sensor_lags():
    made = joint(p=(2e5, 2e5), sensors={"pressure_noise": 0.0})
    made.impose(0.0, 0.0, 3e5, 3e5, PERIOD)
    seen = np.array([made.sense(0.0, PERIOD)[1] for _ in range(40)])
    t = PERIOD * np.arange(1, 41)
    np.testing.assert_allclose(seen, 3e5 - 1e5 * np.exp(-t / 0.002), rtol=1e-12)


@pytest.mark.parametrize("kind", ["angle", "pressure"])
def test_any_kind_of_sensor_lags_is_noisy_and_rounds(kind):
    """Each kind has a noise of its own: that of one changes no bit of the other."""
    exact = {"angle_step": 0.0, "pressure_noise": 0.0, "pressure_lag": 0.0}
    column, other, size = (0, 1, 0.01) if kind == "angle" else (1, 0, 1000.0)

    def shown(**sensors):
        made = joint(p=(2e5, 2e5), sensors=exact | sensors)
        made.impose(0.0, 0.0, 3e5, 3e5, PERIOD)
        return np.array([made.sense(0.3, PERIOD) for _ in range(4000)])

    plain, noisy = shown(), shown(**{f"{kind}_noise": size})
    assert abs(np.std(noisy[:, column]) / size - 1.0) < 0.05
    assert np.ptp(plain, axis=0).tolist() == [0.0] * 3 and plain[0] == pytest.approx(
        [0.3, 3e5, 3e5]
    )
    assert noisy[:, other].tobytes() == plain[:, other].tobytes()
    lagging = shown(**{f"{kind}_lag": 0.01})[:, column]
    start = 0.0 if kind == "angle" else 2e5
    settled = 1.0 - np.exp(-PERIOD / 0.01 * np.arange(1, 4001))
    np.testing.assert_allclose(lagging, start + (plain[0, column] - start) * settled, rtol=1e-12)
    rounded = shown(**{f"{kind}_noise": size, f"{kind}_step": size})[:, column] / size
    assert np.max(np.abs(rounded - np.round(rounded))) < 1e-9 and np.ptp(rounded) > 4


@NAMES
def test_a_restored_state_goes_on_with_the_same_bits(name):
    made = joint(BUILT_IN[name](80.0))
    made.run(*swing(3000), commands(3000), PERIOD)
    image = made.save()
    first = made.run(*swing(500), commands(500), PERIOD)
    fresh = joint(BUILT_IN[name](80.0), seed=9)
    fresh.restore(image)
    second = fresh.run(*swing(500), commands(500), PERIOD)
    assert all(first[key].tobytes() == second[key].tobytes() for key in first)
    assert made.sense(0, PERIOD) == fresh.sense(0, PERIOD)


def test_a_state_of_another_joint_is_refused():
    image = joint(BUILT_IN["dahl"](80.0)).save()
    for other in (
        joint(BUILT_IN["dahl"](81.0)),
        joint(),
        joint(BUILT_IN["dahl"](80.0), length=0.41),
    ):
        with pytest.raises(ValueError, match="other parameters"):
            other.restore(image)
    with pytest.raises(ValueError, match="other parameters"):
        joint().restore(b"")


def test_a_reset_forgets_everything():
    made = joint(BUILT_IN["preisach"](80.0))
    fresh = made.save()
    made.run(*swing(2000), commands(2000), PERIOD)
    made.reset(0.0, 3e5, 3e5, 1)
    assert made.save() == fresh


def test_changing_the_period_in_between_changes_nothing_but_the_steps():
    one, two = (
        joint(BUILT_IN["maxwell-slip"](80.0), substeps=1),
        joint(BUILT_IN["maxwell-slip"](80.0), substeps=4),
    )
    for k in range(300):
        for j in range(4):
            one.step(0.1 + 0.3 * (k + j / 4) * 1e-3, 0.3, 0.2, -0.2, 2.5e-4)
        two.step(0.1 + 0.3 * k * 1e-3, 0.3, 0.2, -0.2, 1e-3)
        if k % 50 == 0:  # and one odd step, the same in both
            one.step(0.1 + 0.3 * (k + 1) * 1e-3, 0.0, 0.2, -0.2, 1e-5)
            two.step(0.1 + 0.3 * (k + 1) * 1e-3, 0.0, 0.2, -0.2, 1e-5)
    np.testing.assert_allclose(one.state["pressure"], two.state["pressure"], rtol=3e-5)
    np.testing.assert_allclose(one.state["friction"], two.state["friction"], rtol=1e-4)


# ---- A mechanism of one's own


def with_foreign(*objects, **changes):
    made = PneumaticJoint(parameters(mechanisms.foreign(), **changes), 1)
    for m, mechanism in enumerate(objects):
        made.attach(m, mechanism)
    made.reset(0.0, 3e5, 3e5, 1)
    return made


def test_a_mechanism_in_python_is_the_built_in_one_when_it_does_the_same():
    built_in = mechanisms.maxwell_slip(80.0, asymmetry=0.1)
    own = with_foreign(MaxwellSlip(built_in), MaxwellSlip(built_in))
    q, qd = swing(1500)
    first = joint(built_in).run(q, qd, commands(1500), PERIOD)
    second = own.run(q, qd, commands(1500), PERIOD)
    assert np.ptp(first["friction"]) > 80
    np.testing.assert_allclose(second["friction"], first["friction"], rtol=0, atol=1e-12 * 80)
    np.testing.assert_allclose(second["torque"], first["torque"], rtol=0, atol=1e-12 * 200)


class Failing(MaxwellSlip):
    def __init__(self, answer, after=10):
        super().__init__(mechanisms.maxwell_slip(80.0))
        self.answer, self.calls, self.after = answer, 0, after

    def force(self, contraction, pressure, period):
        self.calls += 1
        if self.calls <= self.after:
            return super().force(contraction, pressure, period)
        return self.answer()


def complain():
    raise KeyError("no such material")


@pytest.mark.parametrize(
    ("answer", "error", "message"),
    [
        (complain, KeyError, "no such material"),
        (lambda: float("nan"), ValueError, "force of nan N"),
        (lambda: float("-inf"), ValueError, "force of -inf N"),
        (lambda: 1e12, ValueError, "finite number below 1e9 N"),
        (lambda: "eighty", TypeError, "must return one number"),
        (lambda: None, TypeError, "must return one number"),
    ],
)
def test_a_fault_in_a_mechanism_comes_out_as_a_python_error(answer, error, message):
    failing = Failing(answer)
    made = with_foreign(MaxwellSlip(mechanisms.maxwell_slip(80.0)), failing)
    with pytest.raises(error, match=message):
        made.run(*swing(100), commands(100), PERIOD)
    assert failing.calls == 11  # not asked again
    assert all(np.isfinite(list(made.state.values())).ravel())
    with pytest.raises(error, match=message):
        made.step(0.0, 0.1, 0.0, 0.0, PERIOD)
    failing.after = 10**9
    made.reset(0.0, 3e5, 3e5, 1)
    assert np.isfinite(made.step(0.0, 0.1, 0.0, 0.0, PERIOD))


@pytest.mark.slow
def test_an_attached_mechanism_lives_as_long_as_the_joint_and_no_longer():
    own = [MaxwellSlip(mechanisms.maxwell_slip(80.0)) for _ in range(2)]
    made = with_foreign(*own)
    alive = weakref.ref(own[0])
    own[0].joint = made  # a cycle
    del own
    gc.collect()
    made.run(*swing(10), commands(10), PERIOD)
    assert alive() is not None
    del made
    gc.collect()
    assert alive() is None


def test_attaching_what_is_no_mechanism_and_forgetting_to_attach_are_named():
    made = PneumaticJoint(parameters(mechanisms.foreign()), 1)
    with pytest.raises(ValueError, match="attach"):
        made.reset(0.0, 3e5, 3e5, 1)
    with pytest.raises(ValueError, match="attach"):
        made.run(*swing(10), commands(10), PERIOD)
    with pytest.raises(TypeError, match="method reset"):
        made.attach(0, object())
    with pytest.raises(ValueError, match="0 or 1"):
        made.attach(2, MaxwellSlip(mechanisms.maxwell_slip(80.0)))
    assert isinstance(MaxwellSlip(mechanisms.maxwell_slip(80.0)), mechanisms.Mechanism)


# ---- Open-loop runs


def test_an_open_loop_run_is_the_joint_stepped_by_hand():
    physics = parameters(BUILT_IN["dahl"](80.0))
    q = 0.3 * np.sin(np.linspace(0, 6, 301))
    p = 3e5 + 1e5 * commands(301)
    course = run_pressures(physics, q, p, PERIOD)
    by_hand = joint(BUILT_IN["dahl"](80.0), q=0.0, p=tuple(p[0]), seed=0)
    for k in range(300):
        torque = by_hand.impose(q[k], (q[k + 1] - q[k]) / PERIOD, *p[k + 1], PERIOD)
        assert torque == course.torque[k + 1]
    assert course.torque.shape == course.time.shape == q.shape
    np.testing.assert_allclose(course.pressure[0], p[0])
    np.testing.assert_allclose(course.pressure[-1], np.array(by_hand.state["pressure"]) - 1e5)


def test_filling_a_muscle_raises_its_pressure_and_the_torque():
    made = joint()
    filled = made.run(np.zeros(40), np.zeros(40), np.tile([1.0, 0.0], (40, 1)), PERIOD)
    assert (
        3.2e5 < filled["pressure"][-1, 0] - 1e5 < 4e5 and filled["torque"][-1] > filled["torque"][0]
    )


def test_a_joint_with_hysteresis_shows_the_loop_that_the_literature_gives():
    # h = 80 N a muscle at 3 bar: half width 2 r h = 8 Nm where everything slips.
    q = np.radians(40) * np.sin(np.linspace(0, 4 * np.pi, 4001))
    pressure = np.full((4001, 2), 3e5)
    for name, build in BUILT_IN.items():
        course = run_pressures(parameters(build(80.0), viscous_force=0.0), q, pressure, 0.01)
        control = run_pressures(parameters(viscous_force=0.0), q, pressure, 0.01)
        half_width = (course.torque - control.torque)[3000] - (course.torque - control.torque)[2000]
        # At q = 0, after turns at both ends; two of them hold more at this speed than their size.
        largest = {"lugre": 1.3, "ageing": 1.2}.get(name, 1.0) * 8.01
        assert 7.2 < half_width / 2 < largest, name


def test_an_open_loop_run_refuses_what_it_cannot_run():
    physics, q = parameters(), np.zeros(10)
    for wrong in (
        lambda: run_pressures(physics, q, np.zeros((9, 2)), PERIOD),
        lambda: run_pressures(physics, np.full(10, np.nan), np.zeros((10, 2)), PERIOD),
        lambda: run_pressures(physics, q, np.zeros((10, 2)), 0.0),
        lambda: run_pressures({}, q, np.zeros((10, 2)), PERIOD),
        lambda: run_pressures(physics, q, np.zeros(10), PERIOD),
        lambda: run_pressures(
            physics, q, np.zeros((10, 2)), PERIOD, mechanisms=[MaxwellSlip(BUILT_IN["dahl"](1.0))]
        ),
    ):
        with pytest.raises(ParameterError):
            wrong()
