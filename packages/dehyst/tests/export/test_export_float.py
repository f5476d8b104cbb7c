"""Exports in float: branches that are flat keep their memory, and what float cannot hold is refused with a cure."""

from dataclasses import replace

import numpy as np
import pytest

import dehyst
from dehyst.errors import ParameterError
from dehyst.export import export, subject_of, verify
from dehyst.export.precision import FLOAT_LIMIT
from dehyst.models import Block, ModelCard, SignalCard
from dehyst_robot.control import JointControllerParameters
from dehyst_robot.export import joint_subject
from export_samples import MODELS, play_model

CARD = ModelCard(SignalCard("voltage", "V", -1.0, 1.0), SignalCard("travel", "um", -1.0, 1.0), {})


def flat(last):
    """Slopes that fall to `last`: the widest loops run along it."""
    weights = np.array([1.5507, -0.6251, -0.2534, 0.0])
    weights[3] = last - weights.sum()
    return dehyst.PrandtlIshlinskii([0.0, 0.1237, 0.2168, 0.2994], weights, card=CARD)


def saturated():
    return dehyst.StopOperatorModel(
        [0.0, 0.11, 0.27, 0.31], [0.0, 1.3, 0.7, 0.2], 0.0, center=0.3, card=CARD
    )


FLAT = {f"slope {last:g}": flat(last) for last in (0.0, 1e-4, 1e-2)} | {
    "saturated": saturated(),
    "stop": MODELS["stop"](),
}


@pytest.mark.slow
@pytest.mark.parametrize("target", ["c", "st"])
@pytest.mark.parametrize("model", FLAT)
def test_a_forward_model_in_float_keeps_its_memory_on_flat_branches(model, target, tmp_path):
    folder = export(
        subject_of(FLAT[model], "forward", name="unit_1", real="float", ramp=40),
        target,
        tmp_path / "o",
    ).folder
    assert {check.status for check in verify(folder)} <= {"passed", "skipped"}


@pytest.mark.parametrize("model", [*FLAT.values(), *(make() for make in MODELS.values())])
def test_a_forward_block_never_holds_back_and_its_float_range_holds_what_it_reaches(model):
    block, unit = (
        Block(model, "forward").parameters,
        subject_of(model, "forward", name="unit_1", real="float").block,
    )
    assert (block.reach_low, block.reach_high) == (-1e100, 1e100)
    assert (unit.reach_low, unit.reach_high) == (-FLOAT_LIMIT, FLOAT_LIMIT)
    size = block.output_high - block.output_low
    assert block.output_low - 1e-3 * size < unit.output_low < block.output_low
    assert block.output_high < unit.output_high < block.output_high + 1e-3 * size


def scaled(input_factor=1.0, output_factor=1.0, shift=0.0):
    model = play_model()
    card = replace(
        model.card,
        input=replace(model.card.input, low=-input_factor + shift, high=2 * input_factor + shift),
    )
    weights = model.weights * output_factor / input_factor
    return dehyst.PrandtlIshlinskii(
        model.thresholds * input_factor, weights, 0.0, None, shift, card=card
    )  # fmt: skip


REFUSED = {
    "infinite": (scaled(output_factor=1e45), "beyond 1e+15"),
    "too large": (scaled(input_factor=1e20, output_factor=1e20), "beyond 1e+15"),
    "slope lost": (scaled(output_factor=1e-50), "would become zero"),
    "thresholds one": (scaled(input_factor=1e-50, output_factor=1e-50), "become the same number"),
    "range lost": (
        dehyst.PrandtlIshlinskii(
            [0.0], [1.0], card=ModelCard(SignalCard("u", "V", 1e6, 1e6 + 0.01), CARD.output, {})
        ),
        "nothing is left of that range",
    ),
}


@pytest.mark.parametrize("what", ["inverse", "forward"])
@pytest.mark.parametrize("fault", REFUSED)
def test_what_float_cannot_hold_is_refused_with_a_cure_and_goes_as_double(fault, what):
    model, words = REFUSED[fault]
    with pytest.raises(ParameterError, match="--real double") as told:
        subject_of(model, what, name="unit_1", real="float")
    assert what == "inverse" or words in str(told.value)
    assert subject_of(model, what, name="unit_1").block is not None


def test_a_ramp_too_long_for_float_is_refused_and_the_longest_is_not():
    with pytest.raises(ParameterError, match="--ramp 1000000 or less"):
        subject_of(play_model(), name="unit_1", real="float", ramp=1_000_001)
    assert subject_of(play_model(), name="unit_1", real="float", ramp=1_000_000).block.fade > 0


def test_a_controller_with_a_number_that_float_cannot_hold_is_refused():
    with pytest.raises(ParameterError, match="parameter angle_step"):
        joint_subject(
            play_model(), JointControllerParameters(angle_step=1e-60), name="axis", real="float"
        )
