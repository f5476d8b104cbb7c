"""What holds the memory of something that runs is neither pickled nor copied, and says what to do instead."""

import copy
import pickle

import pytest

import dehyst
from dehyst import _native
from dehyst.models import Block, DirectInverse
from dehyst_robot import _native as _robot
from dehyst_robot.control import JointController, JointControllerParameters
from export_samples import play_model
from in_one import in_one

RUNNING = {
    "Stepper": lambda: play_model().stepper("dense"),
    "StackStepper": lambda: play_model().stepper("logarithmic"),
    "DirectStepper": lambda: DirectInverse(
        radii=[0.5], stop_weights=[2.0], polynomial=[0.0, 1.0]
    ).core_stepper(0.01),
    "Block": lambda: Block(play_model())._native,
    "JointController": lambda: JointController(JointControllerParameters())._native,
}


def test_every_class_with_an_image_refuses():
    kept = [
        kind
        for part in (_native, _robot)
        for kind in vars(part).values()
        if hasattr(kind, "save") and hasattr(kind, "restore")
    ]
    assert {kind.__name__ for kind in kept} > RUNNING.keys()
    assert all("__reduce__" in vars(kind) for kind in kept)


@in_one("kind", RUNNING)
@in_one("take", [pickle.dumps, copy.copy, copy.deepcopy])
def test_the_refusal_names_save_and_restore(kind, take):
    with pytest.raises(
        TypeError, match=rf"pickle or copy a {kind}: .*image = it.save\(\).*restore\(image\)"
    ):
        take(RUNNING[kind]())


@in_one("wrap", [Block, lambda model: JointController(JointControllerParameters())])
def test_blocks_and_controllers_say_the_same(wrap):
    with pytest.raises(TypeError, match="save"):
        pickle.dumps(wrap(play_model()))


def test_what_the_refusal_offers_works():
    model = play_model()
    step, other = model.stepper(), pickle.loads(pickle.dumps(model)).stepper()
    for x in (0.3, -0.2, 0.9):
        step(x)
    other.restore(pickle.loads(pickle.dumps(step.save())))
    assert other(0.1) == step(0.1)
    assert isinstance(model, dehyst.PrandtlIshlinskii)
