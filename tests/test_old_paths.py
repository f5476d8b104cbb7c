"""Modules under the paths they had before the two floors: the same objects, and a word of where they went."""

import importlib
import subprocess
import sys

import pytest

import dehyst
from dehyst.old_paths import MOVED, spec_of
from in_one import in_one

SAME = [
    ("dehyst.recording", "Recording", "dehyst.data.recording"),
    ("dehyst.plant", "Arm", "dehyst.robot.arm"),
    ("dehyst.plant.arm", "Arm", "dehyst.robot.arm.arm"),
    ("dehyst.plant.bench", "JointBench", "dehyst.robot.arm.joints"),
    ("dehyst.robot.arm.pneumatic", "run_pressures", "dehyst.robot.arm.joints"),
    ("dehyst.robot.arm.joint_path", "joint_path", "dehyst.robot.arm.kinematics"),
    ("dehyst.robot.arm.physics_engine", "mujoco", "dehyst.robot.arm.rigid_body"),
    ("dehyst.experiments.loops_run", "identify_joint", "dehyst.robot.experiments.identification"),
    ("dehyst.robot.experiments.nominal", "controller_parameters", "dehyst.robot.experiments.calibration"),
    ("dehyst.robot.experiments.sweep.keys", "Keys", "dehyst.robot.experiments.sweep.spec"),
    ("dehyst.evaluation", "Limits", "dehyst.design"),
    ("dehyst.evaluation", "TestCube", "dehyst.robot.iso9283"),
    ("dehyst.evaluation.timing", "timed", "dehyst.robot.iso9283.timing"),
    ("dehyst.muscles.base", "MuscleModel", "dehyst.robot.muscles.base"),
    ("dehyst.robot.muscles.storage", "load_muscle", "dehyst.robot.muscles.registry"),
    ("dehyst.muscles.tondu_lopez", "TonduLopez", "dehyst.robot.muscles.conical"),
    ("dehyst.experiments.sweep.spec", "Draw", "dehyst.robot.experiments.sweep.spec"),
    ("dehyst.identification.drift", "drift", "dehyst.monitoring"),
    ("dehyst.identification.evaluate", "evaluate", "dehyst.monitoring.evaluate"),
]


@pytest.fixture(autouse=True)
def forget():
    """Old names are imported anew by each test."""

    def forgotten():
        for name in [*sys.modules]:
            if any(name == old or name.startswith(f"{old}.") for old in MOVED):
                del sys.modules[name]

    forgotten()
    yield forgotten
    forgotten()


@in_one("old, name, new", SAME)
def test_an_old_path_gives_the_same_object_and_names_the_new_one(old, name, new, forget):
    forget()
    with pytest.warns(DeprecationWarning, match="change the import"):
        found = getattr(importlib.import_module(old), name)
    assert found is getattr(importlib.import_module(new), name)


def test_every_path_that_moved_is_there_under_its_new_name():
    for old, new in MOVED.items():
        assert importlib.util.find_spec(new) is not None
        with pytest.warns(DeprecationWarning, match=new.replace(".", r"\.")):
            assert spec_of(old) is not None


def test_a_module_that_never_was_is_refused_as_ever():
    with pytest.raises(ModuleNotFoundError, match=r"dehyst\.plants"):
        importlib.import_module("dehyst.plants")
    with pytest.warns(DeprecationWarning), pytest.raises(ModuleNotFoundError):
        importlib.import_module("dehyst.plant.nowhere")


def test_public_names_warn_of_nothing():
    program = "import dehyst\nfor name in dehyst.__all__: getattr(dehyst, name)"
    subprocess.run([sys.executable, "-W", "error::DeprecationWarning", "-c", program], check=True)
    assert len(dehyst.__all__) > 60
