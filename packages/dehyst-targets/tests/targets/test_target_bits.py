"""On a microcontroller the core gives the bits of the extension: Cortex-M3, M4F and M7 run it, emulated by qemu.

Here a few models; `python benchmarks/target.py --bits` runs 100 of them over 1 000 samples each. The instructions that
benchmarks/target.py prints are counted by code that is tested here as well.
"""

import subprocess
import sys

import numpy as np
import pytest

from places import ROOT

sys.path.insert(0, str(ROOT / "benchmarks"))

from target import count, jobs, machines, random_blocks

from dehyst.export import export
from dehyst_robot.control import JointControllerParameters
from dehyst_robot.export import joint_subject
from export_samples import large_model

MODELS, SAMPLES = 12, 120
BOARDS = [name for name, machine in machines.MACHINES.items() if machine.board]


@pytest.fixture(scope="module")
def programs(tmp_path_factory):
    """Return a function that compiles the driver for a machine, once."""
    built = {}

    def program(name, real, driver="driver.c"):
        machine = machines.MACHINES[name]
        if machine.missing():
            pytest.skip(
                f"no {machine.missing()}; on Debian: apt-get install gcc-arm-none-eabi qemu-system-arm"
            )
        key = (name, real, driver)
        if key not in built:
            built[key] = machines.build(machine, tmp_path_factory.mktemp(name), real, driver=driver)
        return machine, built[key]

    return program


def run(programs, name, real, trials):
    machine, program = programs(name, real)
    cases = [trial.case for trial in trials]
    return jobs.answers(
        machines.run(machine, program, jobs.job(cases, real), program.parent), cases, real
    )


def same_bits(a, b):
    return np.array_equal(
        np.asarray(a, float).view(np.uint64), np.asarray(b, float).view(np.uint64)
    )


@pytest.mark.slow
@pytest.mark.parametrize("name", [*BOARDS, "x86-64"])
def test_a_block_in_double_has_the_bits_of_the_extension(programs, name):
    trials = random_blocks.trials(MODELS, SAMPLES, "double")
    limited = 0
    for trial, answer in zip(trials, run(programs, name, "double", trials), strict=True):
        y, flags = trial.expected()
        assert same_bits(answer.y, y)
        assert np.array_equal(answer.flags, flags)
        assert same_bits(answer.state, trial.block.state)
        limited += np.count_nonzero(flags & 4)
    assert 50 < limited < MODELS * SAMPLES / 2


@pytest.mark.slow
@pytest.mark.parametrize("name", BOARDS)
def test_a_block_in_float_has_the_bits_of_this_computer_and_is_within_1e_5_of_the_model(
    programs, name
):
    trials = random_blocks.trials(MODELS, SAMPLES, "float")
    here, there = run(programs, "x86-64", "float", trials), run(programs, name, "float", trials)
    for trial, one, other in zip(trials, here, there, strict=True):
        assert same_bits(one.y, other.y) and same_bits(one.state, other.state)
        assert np.array_equal(one.flags, other.flags)
        y, _ = trial.expected()
        assert np.max(np.abs(other.y - y)) <= 1e-5 * trial.range()
        assert np.max(np.abs(other.y - y)) > 0.0  # float it is


def test_parameters_have_the_image_of_the_extension():
    for trial in random_blocks.trials(5, 50, "double"):
        assert np.array_equal(
            np.frombuffer(jobs.image(trial.case.block, "double"), "<u4"), trial.block.dump()
        )


@pytest.mark.slow
def test_parameters_that_are_damaged_are_refused_on_the_target(programs):
    machine, program = programs("cortex-m4f", "float")
    job = bytearray(jobs.job([random_blocks.trials(1, 50, "float")[0].case], "float"))
    job[40] ^= 1
    with pytest.raises(RuntimeError, match="refused"):
        machines.run(machine, program, bytes(job), program.parent)


@pytest.mark.slow
@pytest.mark.parametrize(("function", "numbers", "expected"), [
    ("counted", [1, 2, 10, 300], [3, 5, 21, 601]),
    ("conditional", [1001, 1002], [5, 5]),
])  # fmt: skip
def test_instructions_are_counted_right_where_their_number_is_known(
    programs, function, numbers, expected
):
    machine, program = programs("cortex-m4f", "float", "known.c")
    job = np.array([len(numbers), *numbers], "<u4").tobytes()
    assert count.count(machine, program, job, program.parent, function) == expected


@pytest.mark.slow
@pytest.mark.parametrize("name", ["cortex-m4f", "cortex-m7"])
def test_a_whole_joint_controller_has_the_bits_of_the_extension(name, tmp_path):
    machine = machines.MACHINES[name]
    if machine.missing():
        pytest.skip(
            f"no {machine.missing()}; on Debian: apt-get install gcc-arm-none-eabi qemu-system-arm"
        )
    subject = joint_subject(large_model(14), JointControllerParameters(), name="unit")
    export(subject, "c", tmp_path / "out")
    program = machines.build(machine, tmp_path, driver="joint.c", core=tmp_path / "out" / "src")
    test = subject.test
    content = machines.run(machine, program, jobs.joint_job(subject, test.samples), tmp_path)
    rows = np.frombuffer(content, [("y", "<f8", 13), ("flags", "<u4")])
    assert same_bits(rows["y"], test.outputs)
    assert np.array_equal(rows["flags"], test.flags)
    assert len(set(test.flags.tolist())) > 5  # faults and limits are among them


@pytest.mark.slow
def test_the_example_of_firmware_checks_its_unit_on_a_cortex_m4f(tmp_path):
    machine = machines.MACHINES["cortex-m4f"]
    if machine.missing():
        pytest.skip(
            f"no {machine.missing()}; on Debian: apt-get install gcc-arm-none-eabi qemu-system-arm"
        )
    command = ["make", "-C", machines.ROOT / "examples" / "firmware", "cortex-m", f"OUT={tmp_path}"]
    done = subprocess.run(
        [*command, f"DEHYST={sys.executable} -m dehyst"],
        capture_output=True,
        text=True,
        timeout=600,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert "bits of the model" in done.stdout and "all checks passed" in done.stdout
