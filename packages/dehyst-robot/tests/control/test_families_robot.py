"""Families on the robot: each can be what the muscle does and what the controller knows, and nothing else gets in."""

from dataclasses import replace

import numpy as np
import pytest

import dehyst
import dehyst_robot
from dehyst import PrandtlIshlinskii, StopOperatorModel
from dehyst.errors import OutputError, ParameterError
from dehyst.families import Dahl, InverseLoop, example, names
from dehyst.families._loop_work import work
from dehyst_robot.arm import Mechanism
from dehyst_robot.control import Compensator, LoopCompensator, ModelMechanism, along
from dehyst_robot.control._mechanism import STROKES
from dehyst_robot.experiments import run_trial

NAMES = pytest.mark.parametrize("name", names())
FRICTION = Dahl(
    curve=[0.0], lengths=[0.5, 2.0], weights=[1.0, 0.5]
)  # in mechanisms: of 0.5 + 1 forces
TIME = np.linspace(0.0, 12.0, 1200)
PATH = np.sin(TIME) * np.linspace(1.0, 0.3, TIME.size)
SHORT = {
    "simulation.period_s": 0.001,
    "calibration": {"mean_pressures_bar": [2.2, 3.8], "loads_bar": [-0.8, 0.8], "sweep_s": 12.0},
    "identification.loop_s": 6.0,
    "homing.cycles": 3,
    "path.cycles_fast": 1,
}


def leading(name):
    """A relation of a family that leads: the model, or its inverse; None if there is neither."""
    model = example(name)
    ends = (
        model.scaling.center - model.scaling.half_range,
        model.scaling.center + model.scaling.half_range,
    )
    taken, size = work(model, *ends)
    if taken > 1e-9 * size:
        return model
    return None if model.no_inverse else model.inverse()


def test_the_work_of_a_slider_is_its_force_times_its_way():
    slider = StopOperatorModel([0.0, 0.5], [0.0, 2.0], slope=0.0)  # slips at 1, after 0.5
    assert work(slider, -2.0, 2.0)[0] == pytest.approx(2 * 1.0 * (4.0 - 2 * 0.5), rel=1e-4)
    lagging = PrandtlIshlinskii([0.0, 0.5], [1.0, 1.0])
    assert work(lagging, -2.0, 2.0)[0] < 0 < work(lagging.inverse(), -2.0, 2.0)[0]


@NAMES
def test_the_compensator_of_a_family_undoes_it(name):
    model = example(name)
    if model.no_inverse:
        pytest.skip(f"no inverse: {model.no_inverse}")
    if work(model.inverse(), -1.0, 1.0)[0] < -1e-3 * work(model.inverse(), -1.0, 1.0)[1]:
        pytest.skip("its inverse lags: the model itself is the relation")
    wanted = model.simulate(0.8 * PATH, TIME)
    compensator = LoopCompensator(model.inverse(), shear=2e4)
    assert isinstance(compensator, Compensator)
    term = along(compensator, wanted, time=TIME)
    back = model.simulate((term + 2e4 * wanted) / 1e5, TIME)
    np.testing.assert_allclose(back, wanted, atol=1e-6 * np.ptp(wanted))


@NAMES
def test_steps_and_the_whole_path_say_the_same(name):
    relation = leading(name)
    if relation is None:
        pytest.skip("neither it nor an inverse leads")
    path, time = 0.5 * PATH[::10], TIME[::10]
    compensator = LoopCompensator(relation, shear=1e4, period=float(time[1] - time[0]))
    whole = along(compensator, path, time=time)
    np.testing.assert_allclose(along(compensator, path), whole, atol=1e-6 * max(np.ptp(whole), 1.0))


@NAMES
def test_every_family_can_be_the_hysteresis_of_a_muscle(name):
    relation = leading(name)
    if relation is None:
        with pytest.raises(ParameterError, match="output lags"):
            ModelMechanism(example(name), 10.0, 0.1, center=0.11)
        return
    robot = dehyst_robot.load_robot(
        conditions="kind", changes={"homing.cycles": 1, "homing.period_s": 0.5}
    )
    made = {1: tuple(ModelMechanism(relation, 10.0, 0.1, center=0.11) for _ in range(2))}
    assert isinstance(made[1][0], Mechanism)
    t = np.linspace(0.0, 1.0, 101)[:, None]
    pressed = dehyst_robot.Reference.pressures(0.01, 5e4 * np.sin(6 * t), 0 * t + 3e5, 0 * t)
    known = {1: dehyst_robot.JointControllerParameters()}
    angles = [
        dehyst_robot.arm.Arm(robot, moving=(1,), controllers=known, mechanisms=m)
        .run(pressed, every_s=0.05)
        .angle
        for m in (made, None)
    ]
    assert np.all(np.isfinite(angles[0])) and np.ptp(angles[0]) > 0.005
    assert not np.array_equal(*angles)


def test_the_force_is_size_times_the_model_and_grows_with_pressure():
    mechanism = ModelMechanism(FRICTION, 80.0, 0.0125, pressure_share=0.6)
    mechanism.reset(0.1)
    way = 0.1 + 0.01 * np.sin(np.linspace(0, 9, 200))
    said = [mechanism.force(k, 4.5e5, 5e-4) for k in way.tolist()]
    # Oracle: the model of the same path from rest, as friction has no place of its own.
    expected = (
        80.0 * (0.4 + 0.6 * 1.5) * FRICTION.simulate(np.concatenate([[0.1], way]) / 0.0125)[1:]
    )
    np.testing.assert_allclose(said, expected, atol=1e-9)
    mechanism.reset(0.1)
    assert mechanism.force(float(way[0]), 4.5e5, 5e-4) == said[0]


def test_a_mechanism_of_a_family_takes_work_at_every_stroke():
    for stroke in STROKES:
        mechanism = ModelMechanism(FRICTION, 80.0, 0.0125)
        low, high = stroke
        mechanism.reset(low)
        kappa = np.concatenate([np.linspace(a, b, 200) for a, b in ((low, high), (high, low)) * 2])
        force = np.array([mechanism.force(k, 3e5, 5e-4) for k in kappa.tolist()])
        assert np.sum(force[401:] * np.diff(kappa)[400:]) > 0


@pytest.mark.slow
def test_the_compensator_of_the_mechanisms_own_family_beats_none(tmp_path):
    def factory(joint, muscle):
        return ModelMechanism(FRICTION, 55.0, 0.0125)

    robot = dehyst_robot.load_robot(conditions="kind", changes=SHORT)
    backbone = dehyst_robot.calibrate(
        robot, 1
    )  # of the built-in mechanism: the controller knows another muscle's curve
    found = dehyst_robot.identify_joint(robot, 1, backbone, tmp_path, mechanisms=factory)
    log = found.log
    record = dehyst.Recording(input=log["angle_rad"], output=log["sheared_bar"], time=log["time_s"])
    fit = dehyst.identify(record, "dahl", train_fraction=1.0)
    own = {1: LoopCompensator(fit.model, shear=1e5 * found.shear)}
    kit = replace(dehyst_robot.equip(robot, {1: backbone}, {}, mechanisms=factory), own=own)
    path = dehyst_robot.plan_path(robot)
    off, on = (
        np.sqrt(np.mean(run_trial(robot, path, kit, "fast", name, moving=(1,))[0].error[:, 0] ** 2))
        for name in ("off", "dahl")
    )
    assert on < 0.3 * off


def test_what_lags_is_refused_with_the_cure():
    lagging = PrandtlIshlinskii([0.0, 0.3], [0.6, 0.4])
    with pytest.raises(ParameterError, match=r"pass model\.inverse\(\)"):
        LoopCompensator(lagging)
    with pytest.raises(ParameterError, match=r"Pass model\.inverse\(\)"):
        ModelMechanism(lagging, 80.0, 0.0125)
    LoopCompensator(lagging.inverse())
    ModelMechanism(lagging.inverse(), 80.0, 0.0125)


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"size": 0.0}, "size = 0 must be above 0"),
        ({"size": float("nan")}, "size"),
        ({"strain": -1.0}, "strain"),
        ({"pressure_share": 1.5}, "0.7 is usual"),
        ({"reference_pressure": 0.0}, "reference_pressure"),
        ({"model": 3}, "is no model"),
    ],
)
def test_a_mechanism_refuses_what_makes_none(wrong, said):
    with pytest.raises(ParameterError, match=said):
        ModelMechanism(**{"model": FRICTION, "size": 80.0, "strain": 0.0125, **wrong})


def test_a_compensator_refuses_what_makes_none():
    with pytest.raises(ParameterError, match="is no model"):
        LoopCompensator(lambda q: q)
    with pytest.raises(ParameterError, match="shear"):
        LoopCompensator(FRICTION, shear=float("inf"))
    sheared = dehyst.models.ShearedPrandtlIshlinskii(
        PrandtlIshlinskii([0.0, 0.1], [0.5, 0.5]), shear=1.0
    )
    with pytest.raises(ParameterError, match="subtracted twice"):
        LoopCompensator(sheared.inverse(), shear=1e5)


def test_a_path_without_numbers_is_refused_and_a_step_without_one_holds():
    compensator = LoopCompensator(FRICTION)
    compensator.reset(0.0)
    before = compensator.step(0.3, 0.0)
    assert compensator.step(float("nan"), 0.0) == before == compensator.output()
    with pytest.raises(ParameterError, match="does not increase"):
        along(compensator, [0.0, 0.1], time=[0.0, 0.0])

    class Wrong(LoopCompensator):
        def over(self, angle, velocity, time):
            return np.full(angle.size - self.missing, np.nan)

    wrong = Wrong(FRICTION)
    for wrong.missing, said in (
        (1, "one finite pressure difference"),
        (0, r"Wrong\.over answered"),
    ):
        with pytest.raises(OutputError, match=said):
            along(wrong, [0.0, 0.1], time=[0.0, 0.1])


def test_a_model_that_depends_on_rate_wants_to_know_the_time():
    timed = [name for name in names() if leading(name) is not None and leading(name).rate_dependent]
    if not timed:
        pytest.skip("no family depends on rate yet")
    compensator = LoopCompensator(leading(timed[0]))
    compensator.reset(0.0)
    with pytest.raises(ParameterError, match=r"period=0\.0005"):
        compensator.step(0.1, 0.0)


def test_an_inverse_rests_where_its_muscle_does():
    model = replace(Dahl(curve=[0.0, 1.0], lengths=[0.1], weights=[-0.2]), start="rising")
    relation = model.inverse()
    assert isinstance(relation, InverseLoop)
    mechanism = ModelMechanism(relation, 80.0, 0.1)
    mechanism.reset(0.02)
    resting = model.with_start("rest").inverse().simulate([0.2])[0]
    assert mechanism.force(0.02, 3e5, 0.0) == pytest.approx(80.0 * resting, abs=1e-9)
