"""The reviewed controllers on the simulated joint and arm: stable on every plant, and what they are compared by."""

from functools import lru_cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest

from dehyst.errors import ParameterError
from dehyst_robot.arm import Arm, Reference, load_robot
from dehyst_robot.arm._runs import FAULTS
from dehyst_robot.control import FLAGS, SWITCHES
from dehyst_robot.control._reviewed import CONTROLLERS, LAWS, PidController
from dehyst_robot.experiments import Request, reproduce, run_trial
from dehyst_robot.experiments import _calibration as calibration
from dehyst_robot.experiments import _equipment as kits
from dehyst_robot.experiments import _point as point
from dehyst_robot.experiments._reproduce import _check
from dehyst_robot.experiments._trials import trial_arm
from dehyst_robot.report import write_reproduction_report
from test_reviewed_laws import STOPS

POSITION, INTEGRATOR, COMPENSATOR = (
    SWITCHES[name] for name in ("position", "integrator", "compensator")
)
HELD = POSITION | INTEGRATOR
PLANTS = ("maxwell-slip", "preisach", "dahl", "none")
QUICK = {
    "calibration.mean_pressures_bar": [2.2, 3.8],
    "calibration.loads_bar": [-0.8, 0.8],
    "calibration.sweep_s": 8.0,
    "identification.loop_s": 8.0,
    "homing.cycles": 3,
    "path.cycles_fast": 1,
    "path.slow_factor": 2.0,
    "simulation.substeps": 2,
}


@lru_cache
def robot(plant="maxwell-slip"):
    return load_robot(conditions="kind", changes={**QUICK, "hysteresis.mechanism": plant})


@lru_cache
def characteristic():
    return calibration.calibrate(robot("none"), 1)


@lru_cache
def equipment(plant="maxwell-slip", seed=0):
    return kits.equip(robot(plant), {1: characteristic()}, {}, seed)


def joint(name, plant="maxwell-slip", model=None, seed=0):
    """Joint 1 alone under a controller, at rest at zero."""
    used, kit = kits.under_controller(robot(plant), equipment(plant, seed), name)
    told = {1: model} if model is not None else {}
    return Arm(
        used, moving=(1,), controllers=kit.controllers, compensators=told, laws=kit.laws, seed=seed
    )


def held(angle, seconds, switches=HELD, hung=0.0):
    """Go to an angle within 2 s and stay there."""
    t = 0.01 * np.arange(round(seconds / 0.01) + 1)
    u = np.clip(t / 2.0, 0.0, 1.0)
    motion = (
        u**3 * (10 - 15 * u + 6 * u**2),
        15 * u**2 * (1 - u) ** 2,
        15 * u * (1 - u) * (1 - 2 * u),
    )
    zero = np.zeros((t.size, 1))
    return Reference.motion(
        0.01, tuple(angle * x[:, None] for x in motion), zero, 3e5, switches, hung=zero + hung
    )


@pytest.mark.parametrize("name", LAWS)
@pytest.mark.parametrize("plant", PLANTS)
def test_a_law_comes_to_rest_on_every_plant(plant, name):
    log = joint(name, plant).run(held(0.25, 18.0), every_s=0.01)
    error = np.degrees(log.desired - log.angle)[:, 0]
    late = error[log.time > 15.0]
    assert np.abs(late).max() < 0.5  # of 14 degrees
    assert (
        np.std(late - np.polyval(np.polyfit(np.arange(late.size), late, 2), np.arange(late.size)))
        < 0.02
    )
    assert not log.flags.any()


@pytest.mark.parametrize("name", LAWS)
def test_a_joint_that_was_thrown_off_does_not_go_on_ringing(name):
    """Without hysteresis nothing but the law and light damping brings it to rest."""
    hung = np.zeros((2001, 1))
    hung[100:110] = 60.0
    reference = held(0.1, 20.0)
    reference.values[:, :, 7] = hung
    log = joint(name, "none").run(reference, every_s=0.01)
    swing = np.abs(np.degrees(log.angle[:, 0]) - np.degrees(0.1))
    assert swing[log.time < 3.0].max() > 0.5
    assert swing[log.time > 18.0].max() < 0.1 * swing[log.time < 3.0].max()


@pytest.mark.parametrize("name", LAWS)
def test_a_law_meets_the_same_noise_twice_with_the_same_bits(name):
    first, second = (joint(name, model=STOPS).run(held(0.2, 3.0), every_s=0.01) for _ in range(2))
    assert np.array_equal(first.angle, second.angle) and np.array_equal(
        first.pressure, second.pressure
    )


def test_the_paper_under_its_own_name_is_the_paper_to_the_bit():
    kit = equipment()
    used, same = kits.under_controller(robot(), kit, "paper")
    assert used == robot() and not same.laws
    plain = Arm(robot(), moving=(1,), controllers=kit.controllers)
    logs = [arm.run(held(0.2, 3.0), every_s=0.01) for arm in (plain, joint("paper"))]
    assert np.array_equal(logs[0].angle, logs[1].angle)


@pytest.mark.parametrize("name", [name for name in LAWS if name != "one-valve"])
def test_a_homing_is_the_same_whoever_is_in_charge_afterwards(name):
    zero = np.zeros((401, 1))
    swing = 1.5e5 * np.sin(np.linspace(0.0, 6.0, 401))[:, None]
    told = Reference.pressures(0.01, swing, zero + 3e5, zero)
    logs = [joint(one).run(told, every_s=0.01) for one in ("paper", name)]
    assert np.array_equal(logs[0].pressure, logs[1].pressure)


@pytest.mark.parametrize("load", [-6.0, 4.0])
def test_the_sliding_mode_observes_a_constant_torque_and_holds_against_it(load):
    arm = joint("sliding-mode", "none")
    free, pulled = (arm.run(held(0.0, 6.0, hung=x), every_s=0.05) for x in (0.0, load))
    assert pulled.integrator[-1, 0] - free.integrator[-1, 0] == pytest.approx(-load, abs=0.1)
    assert abs(np.degrees(pulled.angle[-1, 0])) < 0.2


def test_the_mean_pressure_of_one_valve_rests_where_leaks_balance():
    arm = joint("one-valve", "none")
    assert arm.robot.air.supply == pytest.approx(kits.resting_supply(robot(), 1))
    log = arm.run(held(0.1, 40.0), every_s=0.5)
    assert log.pressure[-1, 0].mean() == pytest.approx(3e5, rel=0.01)


def test_the_mean_pressure_of_one_valve_is_not_that_of_the_reference():
    """At the supply of two valves the air takes it to where the leaks balance; two valves hold what is asked for."""
    kit = equipment("none")
    laws = {1: kits.joint_law(robot("none"), kit, "one-valve", 1)}
    arm = Arm(robot("none"), moving=(1,), controllers=kit.controllers, laws=laws)
    log = arm.run(held(0.1, 40.0), every_s=0.5)
    assert 4.5e5 < log.pressure[-1, 0].mean() < 5.2e5
    assert joint("pid", "none").run(held(0.1, 10.0), every_s=0.5).pressure[
        -1, 0
    ].mean() == pytest.approx(3e5, rel=0.01)


@pytest.mark.parametrize("name", LAWS)
@pytest.mark.parametrize("fault", ["angle_lost", "pressure_lost", "angle_frozen", "reference_lost"])
def test_a_fault_in_the_arm_fails_safe(name, fault):
    reference = held(0.2, 4.0)
    reference = Reference(
        reference.spacing,
        reference.values,
        np.where(np.arange(401)[:, None] < 100, HELD, HELD | FAULTS[fault]).astype(np.uint32),
    )
    arm = joint(name)
    log = arm.run(reference, every_s=0.01)
    failed = (log.flags[:, 0] & FLAGS["failed"]) != 0
    assert not failed[:100].any() and np.isfinite(log.angle).all()
    assert failed[-1] == (fault != "reference_lost")


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in CONTROLLERS if name != "paper"])
def test_a_compensator_makes_every_controller_better_in_the_slow_trial(name):
    changes = {**QUICK, "hysteresis.mechanism": "preisach"}
    figures = point.evaluate_point(
        changes, compensators=("off", "paper"), run_settings={"controller": name}
    )
    assert figures["slow/paper/ratio_rms"] < 0.9


def test_every_controller_runs_the_whole_arm():
    used = robot()
    kit = kits.equip(
        used, {n: calibration.nominal_characteristic(used, n) for n in used.pneumatic}, {}
    )
    for name in LAWS:
        changed, equipment = kits.under_controller(used, kit, name)
        arm = trial_arm(changed, equipment, "fast")
        assert sorted(equipment.laws) == list(used.pneumatic)
        zero = np.zeros((301, 7))
        motion = (zero, zero, zero)
        log = arm.run(
            Reference.motion(0.01, motion, arm.feedforward(*motion), 3e5, HELD), every_s=0.05
        )
        assert np.abs(np.degrees(log.angle[-1])).max() < 12.0


def test_a_law_for_a_joint_without_muscles_is_refused():
    kit = equipment()
    with pytest.raises(ParameterError, match="a controller for joint 3, which has no muscles"):
        Arm(robot(), moving=(1, 3), controllers=kit.controllers, laws={3: PidController()})
    with pytest.raises(ParameterError, match="does not move"):
        Arm(robot(), moving=(1,), controllers=kit.controllers, laws={2: PidController()})


def test_images_of_an_arm_under_a_law_are_refused():
    with pytest.raises(ParameterError, match="'pid', whose state has no image"):
        joint("pid").images()


def test_a_request_for_what_does_not_exist_is_refused():
    for wrong, said in (
        ({"controllers": ("lqr",)}, "no controller 'lqr'"),
        ({"controllers": ()}, "not names"),
        ({"controllers": ("pid", "pid")}, "not names"),
        ({"controllers": ("pid",), "compensators": ("ilc",)}, "answers otherwise"),
    ):
        with pytest.raises(ParameterError, match=said):
            _check(robot(), Request(joints=(1,), **wrong))
    with pytest.raises(ParameterError, match="controller = 'lqr'"):
        point.evaluate_point(QUICK, run_settings={"controller": "lqr"})


@pytest.mark.slow
def test_a_run_under_a_law_is_a_trial_like_every_other():
    kit = equipment()
    used, kit = kits.under_controller(robot(), equipment(), "pid")
    run, _ = run_trial(
        used, point._path(load_robot(conditions="kind")), kit, "fast", "off", moving=(1,)
    )
    assert np.degrees(np.abs(run.error[:, 0])).max() < 4.0


SMALL = {**QUICK, "calibration.degree": 3}


@lru_cache
def reproduced(controllers):
    """Joint 1's figures and the page of a run of the whole arm, as short as it goes."""
    request = Request(
        plants=("dahl",),
        joints=(1,),
        seeds=(0,),
        trials=("fast",),
        studies=False,
        controllers=controllers,
    )
    with TemporaryDirectory() as folder:
        result = reproduce(load_robot(conditions="kind", changes=SMALL), request, Path(folder))
        page = write_reproduction_report(result, Path(folder) / "page.html").read_text(
            encoding="utf-8"
        )
        logs = sorted(
            file.relative_to(folder).as_posix() for file in Path(folder).rglob("fast_off.csv")
        )
    return result, page, logs


@pytest.mark.exhaustive
def test_another_controller_adds_figures_and_changes_none():
    (alone, plain, _), (both, page, logs) = reproduced(("paper",)), reproduced(("paper", "pid"))
    figures, more = alone.plants["dahl"].figures[0], dict(both.plants["dahl"].figures[0])
    told = more.pop("controllers")
    assert figures == more and "controllers" not in figures and "controllers" not in alone.settings
    assert list(told) == ["paper", "pid"] and [one["tuned"] for one in told.values()] == [1, 4]
    assert told["paper"]["joints"]["1"]["trials"] == figures["joints"]["1"]["trials"]
    assert (
        told["pid"]["joints"]["1"]["trials"]["fast"]["off"]
        != told["paper"]["joints"]["1"]["trials"]["fast"]["off"]
    )
    assert logs == ["dahl/seed0/fast_off.csv", "dahl/seed0/pid/fast_off.csv"]
    assert "Controllers side by side" in page and "controller “paper”, beside pid" in page
    assert "Controllers side by side" not in plain and "controller “" not in plain
