"""What life adds to the plant: each effect does what its row in plant/life.h says, and nothing while it is off."""

import numpy as np
import pytest

from dehyst_robot import _native
from dehyst_robot._native import PneumaticJoint
from dehyst_robot.arm import Arm, JointBench, Reference, load_robot, pneumatic_joint_parameters
from dehyst_robot.arm._runs import FAULTS
from dehyst_robot.control import SWITCHES, JointControllerParameters
from dehyst_robot.experiments import controller_parameters, nominal_characteristic
from plant_samples import BUILT_IN, joint, parameters

PERIOD = 5e-4
BARE = {"angle_step": 0.0, "pressure_noise": 0.0, "pressure_lag": 0.0}
NAMES = pytest.mark.parametrize("name", BUILT_IN)
REALISTIC = load_robot(conditions="realistic")


def lively(hysteresis=None, q=0.0, p=(3e5, 3e5), seed=1, whole=(), **changes):
    """A joint of plant_samples with keys of the whole joint besides."""
    made = PneumaticJoint({**parameters(hysteresis, **changes), **dict(whole)}, seed)
    made.reset(q, p[0], p[1], seed)
    return made


def held(made, q, p, seconds=0.5, period=PERIOD):
    """Torque after a rest at an angle with two pressures."""
    n = round(seconds / period)
    return made.run_imposed(np.full(n, q), np.zeros(n), np.tile(p, (n, 1)), period)["torque"][-1]


def spool(valve=(), whole=(), command=0.3, steps=200):
    u = (
        np.full((steps, 2), command)
        if np.ndim(command) == 0
        else np.repeat(np.asarray(command)[:, None], 2, axis=1)
    )
    made = lively(valve=valve, whole=whole)
    return made.run(np.zeros(len(u)), np.zeros(len(u)), u, PERIOD)["spool"][:, 0]


# ---- Off


@NAMES
def test_effects_that_are_zero_change_no_bit(name):
    rows = {
        "air": ("supply_volume", "supply_conductance"),
        "muscle": ("shift", "tendon", "tendon_time", "warming", "warming_time", "warm_stiffness"),
        "valve": ("delay", "step", "hysteresis", "middle", "tube_length", "tube_diameter"),
        "sensors": tuple(f"{kind}_{quality}" for kind in ("angle", "pressure")
                         for quality in ("delay", "jitter", "offset", "drift", "drift_time")),
    }  # fmt: skip
    off = {table: dict.fromkeys(keys, 0.0) for table, keys in rows.items()}
    mechanism = BUILT_IN[name](80.0, asymmetry=0.1)
    dead = {**mechanism, "pressure_strain": 0.0, "scatter": 0.0, "warm": 0.0}
    whole = dict.fromkeys(("command_delay", "command_jitter", "backlash", "backlash_damping"), 0.0)
    bare = lively(mechanism)
    zero = lively(
        dead,
        air=off["air"],
        valve=off["valve"],
        sensors=off["sensors"],
        whole=whole,
        **off["muscle"],
    )
    t = PERIOD * np.arange(4000)
    q = 0.3 * np.sin(4 * t)
    u = np.column_stack([0.4 * np.sin(7 * t), 0.4 * np.cos(5 * t)])
    first, second = (made.run(q, np.gradient(q, PERIOD), u, PERIOD) for made in (bare, zero))
    assert all(np.array_equal(first[key], second[key]) for key in first)
    assert all(bare.sense(0.1, PERIOD) == zero.sense(0.1, PERIOD) for _ in range(100))


# ---- Delays


@pytest.mark.parametrize("periods", [1.0, 3.0, 7.5, 40.0])
def test_a_sensor_shows_what_was_a_delay_ago(periods):
    made = lively(sensors={**BARE, "angle_delay": periods * PERIOD})
    q = 0.2 * np.arange(100.0)
    seen = np.array([made.sense(each, PERIOD)[0] for each in q])
    start = int(np.ceil(periods))
    np.testing.assert_allclose(seen[start:], q[start:] - 0.2 * periods, atol=1e-12)
    assert np.all(seen[:start] <= 0.2)


def test_jitter_makes_readings_older_but_never_turns_them_back():
    made = lively(sensors={**BARE, "pressure_jitter": 3 * PERIOD, "angle_jitter": 3 * PERIOD})
    seen = np.array([made.sense(float(k), PERIOD)[0] for k in range(2000)])
    age = np.arange(2000.0) - seen
    assert age.min() >= 0.0
    assert age.max() <= 3.0
    assert 0.5 < age.std() < 1.5
    assert np.all(np.diff(seen) >= -1e-12)


def test_valves_follow_their_commands_a_delay_of_computer_and_valve_later():
    at_once = spool()
    late = spool(valve={"delay": 2 * PERIOD}, whole={"command_delay": 3 * PERIOD})
    assert np.array_equal(late[5:], at_once[:-5])
    assert not late[:5].any()
    shaky = spool(whole={"command_jitter": 4 * PERIOD}, command=0.3 * np.sin(np.arange(400) / 20.0))
    calm = spool(command=0.3 * np.sin(np.arange(400) / 20.0))
    assert 1e-3 < np.abs(shaky - calm).max() < 4 * 0.3 / 20


def test_a_tube_delays_the_flow_by_its_length_over_the_speed_of_sound_and_weakens_it():
    def mass(**valve):
        made = lively(valve=valve, p=(2e5, 2e5))
        return made.run(np.zeros(200), np.zeros(200), np.full((200, 2), 1.0), PERIOD)["mass"][:, 0]

    bare, wide, narrow = (
        mass(),
        mass(tube_length=1.7, tube_diameter=0.1),
        mass(tube_length=1.7, tube_diameter=0.006),
    )
    delay = 1.7 / np.sqrt(1.4 * 287.0 * 293.0)  # 5 ms
    level = 0.2 * bare[-1]
    arrives = [PERIOD * np.interp(level, m, np.arange(200)) for m in (bare, wide)]
    assert arrives[1] - arrives[0] == pytest.approx(delay, abs=PERIOD)
    assert narrow[-1] < 0.8 * wide[-1]
    # The law itself, exp(-R_t R T L/(2 p c)) with turbulent friction, from the flows of a short while.
    flow = np.diff(wide)[40] / PERIOD
    reynolds = 4 * flow / (np.pi * 0.006 * 1.82e-5)
    through = np.exp(
        -0.158 * 1.82e-5 / 0.006**2 * reynolds**0.75 * 287 * 293 * 1.7 / (2 * 3e5 * 343)
    )
    assert np.diff(narrow)[40] / np.diff(wide)[40] == pytest.approx(through, abs=0.06)


# ---- Compliance and play


def test_a_tendon_is_a_spring_in_series_with_its_muscle():
    p = (3.5e5, 2.5e5)
    quiet = {"viscous_force": 0.0, "creep_time": [], "creep_force": [], "creep_pressure": []}
    soft = lively(p=p, tendon=4e5, tendon_time=0.002, **quiet)
    rigid = joint(p=p, **quiet)
    slope = [(held(made, 0.1, p) - held(made, 0.0, p)) / 0.1 for made in (soft, rigid)]
    for m in range(2):
        assert soft.state["stretch"][m] == pytest.approx(soft.state["force"][m] / 4e5, rel=1e-9)
    assert 0.8 < slope[0] / slope[1] < 0.97
    # Stretched tendons let the muscles be shorter: a rigid joint whose muscles are shifted so far pulls alike.
    shifted = lively(p=p, shift=0.0, **quiet)
    kappa = np.array(soft.state["contraction"])
    assert kappa - np.array([0.11, 0.11]) == pytest.approx(
        np.array(soft.state["stretch"]) / 0.4, abs=1e-12
    )
    assert held(shifted, 0.0, p) > held(soft, 0.0, p)


def test_play_has_its_width_and_hands_on_the_pulleys_torque():
    b = np.radians(0.5)
    for p, side in (((4e5, 2e5), 1), ((2e5, 4e5), -1)):
        loose = lively(p=p, whole={"backlash": b, "backlash_damping": 0.4})
        torque = held(loose, 0.05, p, 2.0)
        assert loose.gap == pytest.approx(side * b)
        assert torque == pytest.approx(
            held(joint(q=side * b, p=p), 0.05 + side * b, p, 2.0), abs=0.05
        )
    balanced = lively(
        whole={"backlash": b, "backlash_damping": 0.4},
        creep_time=[],
        creep_force=[],
        creep_pressure=[],
    )
    for q in (0.9 * b, -0.9 * b):
        assert (
            abs(held(balanced, q, (3e5, 3e5))) < 0.01
        )  # free within the play: a rigid joint has 190 Nm/rad
    assert abs(held(balanced, 3 * b, (3e5, 3e5))) == pytest.approx(190 * 2 * b, rel=0.05)


@NAMES
def test_a_closed_path_takes_no_work_from_a_joint_with_tendons_and_play(name):
    mechanism = {**BUILT_IN[name](80.0, asymmetry=0.1), "scatter": 0.05}
    made = lively(mechanism, p=(4e5, 4e5), tendon=3e5, tendon_time=0.002,
                  whole={"backlash": 2e-3, "backlash_damping": 0.4})  # fmt: skip
    t = PERIOD * np.arange(16000)
    q = 0.3 * np.sin(2 * np.pi * t / 2.0)
    out = made.run_imposed(q, np.gradient(q, PERIOD), np.full((t.size, 2), 4e5), PERIOD)
    work = np.cumsum(out["torque"] * np.gradient(q))[3999::4000]
    assert np.all(np.diff(work) < -0.5)  # every cycle from the second on dissipates


# ---- Valves


def test_a_spool_has_play_and_steps_and_a_middle_of_its_own():
    ramp = np.concatenate([np.linspace(-0.5, 0.5, 4000), np.linspace(0.5, -0.5, 4000)])
    apart = spool(valve={"hysteresis": 0.02, "frequency": 6e3}, command=ramp)
    up, down = apart[2000], apart[6000]
    assert down - up == pytest.approx(0.04, abs=1e-3)
    steps = spool(valve={"step": 0.125, "frequency": 6e3}, command=ramp)
    settled = steps[np.abs(np.gradient(steps)) < 1e-6]
    np.testing.assert_allclose(settled / 0.125, np.round(settled / 0.125), atol=1e-2)
    assert spool(valve={"middle": 0.01})[-1] == pytest.approx(0.29, abs=1e-6)


def test_a_valves_dead_band_is_not_the_one_that_the_controller_is_told():
    nominal = REALISTIC.valve("mpye").dead_band
    drawn = np.array([[v["dead_band"] for v in pneumatic_joint_parameters(REALISTIC, 1, seed)["valve"]]
                      for seed in range(200)])  # fmt: skip
    assert drawn.std() / nominal == pytest.approx(0.3, rel=0.15)
    assert np.corrcoef(drawn.T)[0, 1] < 0.3
    told = controller_parameters(REALISTIC, 1, nominal_characteristic(REALISTIC, 1))
    assert told.pneumatics.dead_band == nominal


# ---- Supply


def test_the_supply_droops_with_what_is_taken_and_comes_back():
    made = lively(p=(1e5, 1e5), air={"supply_volume": 2e-3, "supply_conductance": 1e-7})
    start = made.supply
    for _ in range(60):
        made.step(0.0, 0.0, 1.0, 1.0, PERIOD)
    # Two valves of 2 l/(s bar) at 8 bar draw 32 l/s: 3.2 bar of droop in the end, with V/(n R T G) = 0.18 s.
    assert 0.3e5 < start - made.supply < 0.6e5
    for _ in range(4000):
        made.step(0.0, 0.0, 0.0, 0.0, PERIOD)
    assert abs(made.supply - start) < 0.1e5
    assert made.supply < start  # leaking valves go on drawing


def supplies(moving, filling, switches=0, volume=2.0):
    """Lowest supply of joint 1, and its pressures, while the joints of `filling` are filled from 2 to 5 bar."""
    robot = load_robot(
        conditions="kind",
        changes={"air.supply_volume_l": volume, "air.supply_conductance_l_s_bar": 10.0},
    )
    arm = Arm(robot, moving=moving, controllers={n: JointControllerParameters() for n in moving})
    mean = np.full((41, len(moving)), 3e5)
    mean[20:, [moving.index(n) for n in filling]] = 5.5e5
    zero = np.zeros_like(mean)
    lowest = []
    for k in range(40):
        arm.run(
            Reference.pressures(0.01, zero[k : k + 2], mean[k : k + 2], zero[k : k + 2], switches),
            every_s=0.01,
        )
        lowest.append(arm._plants[moving[0]].supply)
    return np.array(lowest), [plant.supply for plant in arm._plants.values()]


def test_joints_share_one_supply_and_feel_each_other():
    resting, _ = supplies((1, 2, 4), ())
    other, both = supplies((1, 2, 4), (2,))
    two, _ = supplies((1, 2, 4), (2, 4))
    assert len(set(both)) == 1
    sag = [float(each.max() - each.min()) for each in (resting, other, two)]
    assert sag[0] < 0.3 * sag[1]
    assert sag[1] > 0.05e5
    assert sag[2] > 1.5 * sag[1]


def test_a_failing_supply_empties():
    failed, _ = supplies((1, 2), (1,), FAULTS["supply_lost"])
    assert np.all(np.diff(failed) < 0)
    assert failed[-1] < 7.5e5


# ---- Sensors


def test_offsets_and_drifts_are_drawn_from_the_seed_and_leave_the_noise_alone():
    told = {"pressure_offset": 2000.0, "pressure_drift": 500.0, "pressure_drift_time": 1.0}

    def readings(seed, sensors):
        made = lively(seed=seed, sensors=sensors)
        return np.array([made.sense(0.0, 0.01)[1:] for _ in range(1000)])

    off = np.array([readings(seed, told) - readings(seed, {}) for seed in range(150)])
    assert off[:, 0].std() == pytest.approx(2000.0, rel=0.15)
    grown = off[:, -1] - off[:, 0]
    assert grown.std() == pytest.approx(500.0, rel=0.15)
    t = 0.01 * np.arange(1000)
    np.testing.assert_allclose(
        off[0, :, 0] - off[0, 0, 0], grown[0, 0] * -np.expm1(-t / 1.0), atol=15.0
    )
    assert np.array_equal(readings(3, told), readings(3, told))


# ---- Muscles


def test_a_muscle_warms_up_by_what_it_dissipates_and_its_loop_narrows():
    warming = {
        "warming": 20.0,
        "warming_time": 20.0,
        "viscous_force": 0.0,
        "warm_stiffness": -0.001,
    }
    made = lively({**BUILT_IN["maxwell-slip"](80.0), "warm": -0.005}, **warming)
    t = 1e-3 * np.arange(100_000)
    q = 0.4 * np.sin(2 * np.pi * t)
    made.run_imposed(q[:1000], np.gradient(q, 1e-3)[:1000], np.full((1000, 2), 3e5), 1e-3)
    cool = made.state["warmth"][0]
    out = made.run_imposed(q, np.gradient(q, 1e-3), np.full((t.size, 2), 3e5), 1e-3)
    work = out["friction"][:, 0] * np.gradient(out["contraction"][:, 0]) * 0.4
    warmth = made.state["warmth"][0]
    assert warmth == pytest.approx(20.0 * work[-20_000:].sum() / 20.0, rel=0.05)
    assert warmth > 5.0
    first, last = np.ptp(out["friction"][:1000, 0]), np.ptp(out["friction"][-1000:, 0])
    assert last / first == pytest.approx((1 - 0.005 * warmth) / (1 - 0.005 * cool), rel=0.02)
    still = made.run_imposed(np.zeros(60_000), np.zeros(60_000), np.full((60_000, 2), 3e5), 1e-3)
    assert still["friction"].shape == (60_000, 2)
    assert made.state["warmth"][0] < 0.06 * warmth


@NAMES
def test_no_two_strokes_have_one_loop_and_the_force_stays_continuous(name):
    t = 1e-3 * np.arange(40_000)
    kappa = 0.11 + 0.05 * np.sin(2 * np.pi * t / 2.0)
    made = {**BUILT_IN[name](80.0), "scatter": 0.05}
    drawn = _native.hysteresis_force(made, 0.11, kappa, np.full(t.size, 3e5))
    alike = _native.hysteresis_force(BUILT_IN[name](80.0), 0.11, kappa, np.full(t.size, 3e5))
    peaks = drawn[2500::2000], alike[2500::2000]
    assert np.ptp(peaks[1]) < 1e-2
    assert np.std(peaks[0]) / np.mean(peaks[0]) == pytest.approx(0.05, abs=0.03)
    assert np.abs(np.diff(drawn)).max() < 1.3 * np.abs(np.diff(alike)).max()


def test_loops_over_pressure_at_a_fixed_length_depend_on_the_mechanism():
    t = np.arange(6001) / 1000.0
    p = 3e5 + 1e5 * np.sin(2 * np.pi * t / 2.0)
    kappa, loops = np.full(t.size, 0.11), {}
    for name, build in BUILT_IN.items():
        flat = _native.hysteresis_force(build(80.0), 0.11, kappa, p)
        assert not flat.any()  # without it, nothing moves
        f = _native.hysteresis_force({**build(80.0), "pressure_strain": 0.003e-5}, 0.11, kappa, p)
        loops[name] = f[4000:]
        assert np.sum(f[4001:] * np.diff(p[4000:])) > 0.02 * np.ptp(f) * np.ptp(
            p
        )  # a loop: force is later
        assert 5.0 < np.ptp(loops[name]) < 80.0
    for first, second in (
        ("maxwell-slip", "preisach"),
        ("maxwell-slip", "dahl"),
        ("preisach", "dahl"),
    ):
        assert np.abs(loops[first] - loops[second]).max() > 1.0


def test_muscles_of_a_pair_differ_in_shape_and_fitted_length():
    pairs = [pneumatic_joint_parameters(REALISTIC, 1, seed)["muscle"] for seed in range(200)]
    for index in (1, 2, 3):
        drawn = np.array([[m["coefficient"][index] for m in pair] for pair in pairs])
        assert drawn.std() / drawn.mean() == pytest.approx(0.03, rel=0.2)
        assert np.ptp(drawn, axis=1).min() > 0
    assert np.array([[m["shift"] for m in pair] for pair in pairs]).std() == pytest.approx(
        0.002, rel=0.2
    )


# ---- All of it


@NAMES
def test_the_realistic_arm_holds_an_angle(name):
    robot = REALISTIC.with_changes({"hysteresis.mechanism": name})
    told = controller_parameters(robot, 1, nominal_characteristic(robot, 1))
    arm = Arm(robot, moving=(1,), controllers={1: told})
    goal, zero = np.full((401, 1), 0.1), np.zeros((401, 1))
    on = SWITCHES["position"] | SWITCHES["integrator"]
    log = arm.run(Reference.motion(0.01, (goal, zero, zero), zero, 3e5, on), every_s=0.01)
    assert np.abs(log.angle[-50:, 0] - 0.1).max() < 0.01
    assert np.isfinite(log.pressure).all()


def test_a_bench_takes_mechanisms_of_ones_own():
    class Nothing:
        def reset(self, contraction):
            self.asked = 0

        def force(self, contraction, pressure, period):
            self.asked += 1
            return 0.0

    own = (Nothing(), Nothing())
    bench = JointBench(load_robot(conditions="kind"), 1, mechanisms=own)
    for _ in range(10):
        bench.step([[0.1, 0.0]])
    assert [each.asked for each in own] == [10, 10]
