"""The joint controller of the simulated robot as an FMU: in the loop with the plant it gives the built-in one's run."""

import math

import numpy as np
import pytest

from dehyst.export import export, verify
from dehyst.models import PrandtlIshlinskii
from dehyst_robot.control import SWITCHES, JointControllerParameters
from dehyst_robot.export import joint_subject
from dehyst_robot.export._joint_run import REFERENCE, SENSORS
from fmu_tools import (
    NEEDS_COMPILER,
    Importer,
    fmpy,
    quickly,
    readme_commands,
    readme_simulation,
    run_sequences,
)

pytestmark = NEEDS_COMPILER
TOLD = JointControllerParameters()
PERIOD = TOLD.period
INPUTS = [*SENSORS, *(f"reference_{name.removesuffix('_d')}" for name in REFERENCE)]


@pytest.fixture(autouse=True, scope="module")
def quick():
    with quickly():
        yield


def model():
    """Sheared pressure difference [bar] -> angle [rad]."""
    return PrandtlIshlinskii([0.0, 0.05, 0.1], [0.3, 0.1, 0.1])


@pytest.fixture(scope="module", params=[2, 3], ids=["fmi2", "fmi3"])
def fmu(request, tmp_path_factory):
    folder = tmp_path_factory.mktemp("joint") / "out"
    export(joint_subject(model(), TOLD, name="joint_1"), f"fmu{request.param}", folder)
    return request.param, folder


def started(folder):
    instance = Importer(folder / "joint_1.fmu")
    instance.enter()
    for name, value in zip(SENSORS, (0.1, 3e5, 2.5e5), strict=True):
        instance.set(name, [value])
    instance.exit()
    return instance


@pytest.mark.slow
def test_an_export_verifies_itself(fmu):
    checks = verify(fmu[1])
    assert all(check.ok for check in checks), checks
    assert sum("1600 samples, bits" in check.detail for check in checks) == 1


@pytest.mark.slow
@pytest.mark.parametrize("weights", [[0.3, 0.1, 0.1, 0.05], [0.18, 0.1, 0.1], [0.47]], ids=len)
def test_single_precision_is_near_enough(weights, tmp_path):
    """Also where it meets a limit a period earlier or later, as it does with the first and the last of these."""
    thresholds = [0.0, 0.02, 0.05, 0.1][: len(weights)]
    subject = joint_subject(
        PrandtlIshlinskii(thresholds, weights), TOLD, name="joint_1", real="float"
    )
    assert all(
        np.array(subject.tolerances)[2:11] < 4e-3 * np.abs(subject.test.outputs).max(axis=0)[2:11]
    )  # and no looser
    export(subject, "fmu3", tmp_path / "out")
    checks = verify(tmp_path / "out")
    assert all(check.ok for check in checks), checks


@pytest.mark.slow
def test_the_simulation_of_the_readme_gives_the_expected_table(fmu):
    fmpy()
    result, expected = readme_simulation(
        fmu[1], "joint_1", ["valve_1", "valve_2", "observed_angle", "compensation"]
    )
    assert expected.size > 1000
    for name in result.dtype.names:
        assert np.array_equal(result[name], expected[name]), name
    assert np.ptp(expected["valve_1"]) > 0.1
    assert np.ptp(expected["compensation"]) > 0


def test_the_commands_of_the_readme_compare_every_output(fmu, tmp_path):
    fmpy()
    assert readme_commands(fmu[1], tmp_path) == [0.0] * 14  # time and thirteen outputs


def test_the_fmu_in_the_loop_gives_the_run_of_the_controller_inside(fmu):
    lib = fmpy()
    pytest.importorskip("mujoco", reason="needs MuJoCo: pip install dehyst-robot")
    from dehyst_robot.arm import Arm, JointBench, Reference, load_robot

    version, folder = fmu
    robot = load_robot(conditions="kind")
    t = 0.01 * np.arange(101)[:, None]
    switches = np.full(t.shape, sum(SWITCHES.values()), np.uint32)
    switches[30:50], switches[70:80] = SWITCHES["position"], 0
    motion = (0.2 * np.sin(2 * t), 0.4 * np.cos(2 * t), -0.8 * np.sin(2 * t))
    reference = Reference.motion(0.01, motion, 1.0 + t, 3e5, switches, extra=1e3 * t, hung=-2.0 * t)
    compensator = {1: model().inverse()}
    inside = Arm(robot, moving=(1,), controllers={1: TOLD}, compensators=compensator, seed=5).run(
        reference, PERIOD
    )

    name = str(folder / "joint_1.fmu")
    about = lib.read_model_description(name)
    number = {variable.name: variable.valueReference for variable in about.modelVariables}
    slave = lib.instantiate_fmu(lib.extract(name), about)
    get, put = (
        (slave.getReal, slave.setReal) if version == 2 else (slave.getFloat64, slave.setFloat64)
    )
    inputs = [number[word] for word in INPUTS]
    outputs = [number[word] for word in ("valve_1", "valve_2", "integrator", "compensation")]
    on = [number[f"{word}_on"] for word in SWITCHES]
    bench, fine, found = JointBench(robot, 1, seed=5), reference.sampled(PERIOD), []
    if version == 2:
        slave.setupExperiment()
    slave.enterInitializationMode()
    put(inputs[:3], bench.reset()[0])
    slave.exitInitializationMode()
    seen = bench.sense()[0]
    for k, (row, bits) in enumerate(zip(fine.values[:-1, 0], fine.switches[:-1, 0], strict=True)):
        put(inputs, [*seen, *row[:7]])
        slave.setBoolean(on, [bool(bits & bit) for bit in SWITCHES.values()])
        slave.doStep(k * PERIOD, PERIOD)
        valve_1, valve_2, *rest = get(outputs)
        found.append((bench.angles[0], *rest))
        seen = bench.step([[valve_1, valve_2]], hung=row[7])[0]
    slave.terminate()
    slave.freeInstance()
    assert np.array_equal(
        found, np.column_stack([inside.angle, inside.integrator, inside.compensation])
    )
    assert np.ptp(inside.angle) > 0.05
    assert np.ptp(inside.compensation) > 0


def test_a_communication_step_of_several_periods_holds_the_inputs(fmu):
    with started(fmu[1]) as one, started(fmu[1]) as other:
        for instance in (one, other):
            instance.set("position_on", [True])
            instance.set("reference_angle", [0.2])
        one.step(7 * PERIOD)
        for _ in range(7):
            other.step(PERIOD)
        names = [
            name for name in one.variables if name != "time" and not name.startswith("parameter_")
        ]
        assert all(one.get(name) == other.get(name) for name in names)
        assert one.get("valve_1") != (0.0,)


@pytest.mark.parametrize("step", [0.5 * PERIOD, 1.37 * PERIOD, 1e-9, 1e6])
def test_a_step_that_is_no_multiple_of_the_period_is_refused_and_changes_nothing(step, fmu):
    from fmpy.fmi1 import FMICallException

    with started(fmu[1]) as instance:
        instance.step(PERIOD)
        before = instance.get("observed_angle"), instance.get("desired_1")
        instance.set("angle", [0.105])
        with pytest.raises(FMICallException, match="discard"):
            instance.step(step)
        assert (instance.get("observed_angle"), instance.get("desired_1")) == before


def test_the_controller_starts_where_the_sensors_are(fmu):
    with started(fmu[1]) as instance:
        assert instance.get("valve_1") == instance.get("valve_2") == (0.0,)
        instance.step(PERIOD)
        assert instance.get("observed_angle")[0] == pytest.approx(0.1, abs=1e-4)
        assert instance.get("flags") == (0,)
    with Importer(fmu[1] / "joint_1.fmu") as instance:
        instance.enter()
        instance.set("pressure_1", [math.nan])
        instance.exit()
        assert instance.get("failed") == (1,)


def test_parameters_can_be_read(fmu):
    with Importer(fmu[1] / "joint_1.fmu") as instance:
        assert instance.get("parameter_pole") == (TOLD.pole,)
        assert instance.get("parameter_supply") == (TOLD.pneumatics.supply,)
        assert instance.get("parameter_b" if fmu[0] == 3 else "parameter_b[1]")[0] == TOLD.b[0]
        assert instance.get("parameter_hold_samples") == (TOLD.hold_samples,)


@pytest.mark.exhaustive
def test_random_sequences_of_calls_never_crash(fmu, tmp_path):
    # A step of a joint takes long; the machine of states is that of the block, of which test_export_fmu.py asks more.
    assert run_sequences(*fmu, tmp_path, count=8000)["discarded"] > 100
