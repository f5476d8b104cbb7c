"""A controller of one's own in the place of the paper's: in a bench, an arm, a trial, the whole experiment."""

import gc
import weakref
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import dehyst
import dehyst_robot
from dehyst.errors import OutputError, ParameterError
from dehyst_robot.arm import Arm, Drives, JointBench, Reference, load_robot
from dehyst_robot.commands._reproduce import QUICK
from dehyst_robot.control import SWITCHES, JointController, JointControllerParameters
from dehyst_robot.experiments import equip
from dehyst_robot.experiments._trials import trial_arm
from dehyst_robot.report import write_reproduction_report

ON = SWITCHES["position"] | SWITCHES["integrator"]
SHORT = {**QUICK, "calibration.degree": 3}


class Paper:
    """The paper's controller, as somebody would write it who has it from elsewhere."""

    def __init__(self, told=None):
        self.told, self.starts, self.extras = told or JointControllerParameters(), [], []

    def reset(self, reading, period):
        self.starts.append((reading, period))
        self.inner = JointController(self.told)
        self.inner.reset(*reading)

    def step(self, reading, reference):
        self.extras.append(reference.extra)
        out = self.inner.step(*reading, reference, ON | SWITCHES["compensator"])
        return out.valve_1, out.valve_2


class Answers(Paper):
    def __init__(self, answer):
        super().__init__()
        self.answer = answer

    def step(self, reading, reference):
        if isinstance(self.answer, Exception):
            raise self.answer
        return self.answer


def swing(joints=1, switches=ON, seconds=1.0):
    t = np.tile(0.01 * np.arange(round(100 * seconds) + 1)[:, None], joints)
    motion = (0.2 * (1 - np.cos(2 * t)), 0.4 * np.sin(2 * t), 0.8 * np.cos(2 * t))
    return Reference.motion(0.01, motion, 0 * t, 3e5, switches)


@cache
def kit():
    robot = load_robot(conditions="kind", changes=SHORT)
    return robot, dehyst_robot.equip(robot, {1: dehyst_robot.calibrate(robot, 1)}, {})


@pytest.mark.parametrize("conditions", ["kind", "realistic"])
def test_the_papers_controller_as_ones_own_moves_the_joint_as_it_does_itself(conditions):
    """But for its start: it hears of the first reading of the run, and that inside of the one before."""
    robot = load_robot(conditions=conditions)
    told = {1: JointControllerParameters()}
    inside = Arm(robot, moving=(1,), controllers=told).run(swing(), 0.01)
    log = JointBench(robot, 1, controller=Paper()).run(swing(), 0.01)
    assert np.ptp(log.angle) > 0.2
    assert np.abs(log.angle - inside.angle).max() < 2e-3 * np.ptp(log.angle)
    assert (
        np.array_equal(log.desired, inside.desired) and log.pressure.shape == inside.pressure.shape
    )


def test_what_a_bench_runs_is_what_its_steps_give():
    robot = load_robot()
    bench = JointBench(robot, 1, seed=2, controller=Paper())
    log = bench.run(swing(), robot.simulation.period)
    other, one = JointBench(robot, 1, seed=2), Paper()
    other.reset()
    seen, angles = other.sense()[0], []
    for row in swing().sampled(other.period).values[:-1, 0]:
        if not one.starts:
            one.reset(dehyst_robot.control.Reading(*seen), other.period)
        angles.append(other.angles[0])
        seen = other.step(
            [
                one.step(
                    dehyst_robot.control.Reading(*seen),
                    dehyst_robot.control.JointReference(*row[:7]),
                )
            ]
        )[0]
    assert np.array_equal(log.angle[:, 0], angles) and np.ptp(angles) > 0.2


def test_it_is_in_charge_while_the_position_is_controlled_and_starts_anew_each_time():
    robot, mine = load_robot(), Paper()
    switches = np.full((101, 1), ON, np.uint32)
    switches[:20], switches[50:70] = 0, 0
    told = {1: JointControllerParameters()}
    arm = Arm(robot, moving=(1,), controllers=told, laws={1: mine})
    log = arm.run(swing(switches=switches), 0.01)
    assert len(mine.starts) == 2 and len(mine.extras) == (30 + 30) * 20
    assert mine.starts[0][1] == robot.simulation.period and mine.starts[0][0].pressure_1 > 1e5
    assert not log.integrator[20:50].any()
    plain = Arm(robot, moving=(1,), controllers=told).run(swing(switches=switches), 0.01)
    assert np.array_equal(log.angle[:20], plain.angle[:20])  # before, the paper's pressure loops
    arm.reset()
    arm.run(swing(switches=switches), 0.01)
    assert len(mine.starts) == 4 and mine.starts[2] == mine.starts[0]


def test_the_compensator_goes_on_and_is_told():
    model = dehyst.PrandtlIshlinskii([0.0, 0.02, 0.05], [0.3, 0.1, 0.1])
    robot, mine = load_robot(), Paper()
    arm = Arm(
        robot,
        moving=(1,),
        controllers={1: JointControllerParameters()},
        compensators={1: model},
        laws={1: mine},
    )
    log = arm.run(swing(switches=ON | SWITCHES["compensator"]), robot.simulation.period)
    assert np.ptp(log.compensation) > 0
    assert np.array_equal(log.compensation[:, 0], mine.extras)


@pytest.mark.parametrize(
    "answer", [(0.1,), (0.1, 0.2, 0.3), (np.nan, 0.0), (0.0, np.inf), None, "ab", 0.3]
)
def test_an_answer_that_is_no_pair_of_numbers_ends_the_run_and_is_named(answer):
    bench = JointBench(load_robot(), 1, controller=Answers(answer))
    with pytest.raises(
        OutputError, match=r"Answers\.step of joint 1 answered .* return valve_1, valve_2"
    ):
        bench.run(swing(), 0.01)


def test_a_fault_in_it_comes_out_as_it_is_and_the_bench_can_go_on():
    mine = Answers(KeyError("mine"))
    bench = JointBench(load_robot(), 1, controller=mine)
    with pytest.raises(KeyError, match="mine"):
        bench.run(swing(), 0.01)
    bench.reset()
    mine.answer = (0.0, 0.0)
    assert np.isfinite(bench.run(swing(seconds=0.1), 0.01).angle).all()


def test_commands_beyond_the_valves_are_limited_and_flagged():
    robot = load_robot()
    logs = [
        JointBench(robot, 1, controller=Answers(a)).run(swing(seconds=0.1), 0.01)
        for a in ((7.0, -7.0), (1, -1))
    ]
    assert np.array_equal(logs[0].angle, logs[1].angle)
    flag = dehyst_robot.control.FLAGS["valve-limit"]
    assert (logs[0].flags == flag).all() and not logs[1].flags.any()


def test_what_is_no_controller_is_refused_and_a_joint_without_one_is_named():
    robot = load_robot()
    with pytest.raises(
        ParameterError,
        match=r"a dict is no controller of joint 1: give it reset\(reading, period\)",
    ):
        JointBench(robot, 1, controller={})
    with pytest.raises(ParameterError, match=r"a controller for joint 3, which has no muscles"):
        Drives(robot, (1, 3), controllers={3: Paper()})
    with pytest.raises(ParameterError, match="joint 2 has no controller that could follow"):
        Drives(robot, (1, 2), controllers={1: Paper()}).run(swing(2), 0.01)


def test_what_is_passed_in_the_wrong_place_is_told_where_it_belongs():
    robot, told = load_robot(), {1: JointControllerParameters()}
    with pytest.raises(
        ParameterError, match=r"Paper is a class: pass a controller of joint 1, Paper\(\)"
    ):
        JointBench(robot, 1, controller=Paper)
    with pytest.raises(ParameterError, match="does not say which joint it controls"):
        Drives(robot, (1,), controllers=Paper())
    with pytest.raises(ParameterError, match="pressures would be ignored"):
        Drives(robot, (1,), pressures=True, controllers={1: Paper()})
    with pytest.raises(ParameterError, match=r"laws=\{1: MyController\(\)\}"):
        Arm(robot, moving=(1,), controllers={1: Paper()})
    with pytest.raises(ParameterError, match=r"give it reset\(reading, period\) and"):
        Arm(robot, moving=(1,), controllers=told, laws={1: object()})
    kit = replace(equip(robot, {}, {}), laws={9: Paper()})
    with pytest.raises(ParameterError, match="laws for joint 9"):
        trial_arm(robot, kit, "fast", (1,))


def test_several_joints_have_one_each():
    robot, mine = load_robot(conditions="kind"), {n: Paper() for n in (1, 2)}
    drives = Drives(robot, (1, 2, 3), controllers=mine)
    log = drives.run(swing(3), 0.01)
    assert (np.ptp(log.angle, axis=0) > 0.1).all() and all(
        len(one.starts) == 1 for one in mine.values()
    )


def test_a_controller_that_holds_its_arm_is_collected_with_it():
    mine = Paper()
    mine.arm = JointBench(load_robot(), 1, controller=mine)
    mine.arm.run(swing(seconds=0.1), 0.01)
    gone = weakref.ref(mine)
    del mine
    gc.collect()
    assert gone() is None


@pytest.mark.slow
def test_a_trial_gives_the_same_logs_and_errors_as_under_the_papers():
    robot, equipment = kit()
    path = dehyst_robot.plan_path(robot)
    mine = Paper(equipment.controllers[1])
    runs = [
        dehyst_robot.run_trial(robot, path, one, "fast", "off", moving=(1,))[0]
        for one in (equipment, replace(equipment, laws={1: mine}))
    ]
    assert len(mine.starts) == 1  # after the homing, which is the paper's
    errors = [np.degrees(np.sqrt(np.mean(run.error[:, 0] ** 2))) for run in runs]
    assert errors[0] > 0.1 and errors[1] == pytest.approx(errors[0], rel=0.05)
    assert runs[1].angle.shape == runs[0].angle.shape


@pytest.mark.exhaustive
def test_the_experiment_runs_it_beside_the_papers_and_reports_both(tmp_path):
    robot, equipment = kit()
    request = dehyst_robot.Request(
        plants=("dahl",), joints=(1,), seeds=(0,), trials=("fast",), studies=False, controllers=("paper", "mine"),
        laws={"mine": lambda number: Paper(equipment.controllers[1]) if number == 1 else None},
    )  # fmt: skip
    result = dehyst_robot.reproduce(robot, request, tmp_path)
    told = result.plants["dahl"].figures[0]["controllers"]
    errors = {name: told[name]["joints"]["1"]["trials"]["fast"] for name in ("paper", "mine")}
    off, on = ([errors[name][c]["rms_deg"] for name in errors] for c in ("off", "paper"))
    assert (
        off[1] == pytest.approx(off[0], rel=0.1) and on[0] < 0.2 * off[0] and on[1] < 0.3 * off[1]
    )
    page = write_reproduction_report(result, tmp_path / "page.html").read_text(encoding="utf-8")
    assert "Controllers side by side" in page and "mine" in page
    assert Path(tmp_path / "dahl" / "seed0" / "mine" / "fast_off.csv").is_file()


@pytest.mark.parametrize(
    ("names", "laws"),
    [
        (("paper",), {"mine": Paper}),
        (("paper", "pid"), {"pid": Paper}),
        (("mine",), {}),
        (("mine",), {"mine": Paper()}),
    ],
)
def test_a_name_that_would_run_nothing_is_refused(names, laws, tmp_path):
    with pytest.raises(
        ParameterError,
        match=r"the controller '.*' of `laws` is not among|no controller 'mine'|lambda joint",
    ):
        dehyst_robot.reproduce(
            load_robot(), dehyst_robot.Request(controllers=names, laws=laws), tmp_path
        )
