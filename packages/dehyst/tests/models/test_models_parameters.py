"""What a model refuses, by name and with the facts, and what it keeps."""

import dataclasses

import numpy as np
import pytest

from dehyst import (
    DehystError,
    ModifiedPrandtlIshlinskii,
    MonotoneMap,
    PrandtlIshlinskii,
    StopOperatorModel,
)
from dehyst.errors import ParameterError
from dehyst.models import ModelCard, SignalCard, StaticCurve

R, W = [0.0, 0.25, 0.5], [1.0, 0.5, 0.25]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"thresholds": [0.0, 0.5, 0.25]}, r"thresholds\[2\] = 0.25 follows 0.5"),
        ({"thresholds": [0.0, 0.25, 0.25]}, "increase strictly"),
        ({"thresholds": [-0.1, 0.25, 0.5]}, "negative"),
        ({"thresholds": [0.0, np.nan, 0.5]}, r"thresholds\[1\] = .*nan"),
        ({"thresholds": [0.0, 0.25, np.inf]}, r"thresholds\[2\]"),
        ({"thresholds": []}, "shape"),
        ({"thresholds": [[0.0, 0.25, 0.5]]}, "shape"),
        ({"thresholds": 0.0}, "shape"),
        ({"thresholds": None}, "shape"),
        ({"thresholds": ["a", "b", "c"]}, "not a list of numbers"),
        ({"thresholds": [0.0, [1.0], 2.0]}, "not a list of numbers"),
        ({"thresholds": {"r": 1}}, "not a list of numbers"),
        ({"weights": [1.0, np.nan, 1.0]}, r"weights\[1\] = .*nan"),
        ({"weights": [1.0, -np.inf, 1.0]}, r"weights\[1\]"),
        ({"weights": [1.0, 1e101, 1.0]}, r"weights\[1\]"),
        ({"weights": [1.0, 2.0]}, "3 thresholds but 2 weights"),
        ({"weights": [1 + 1j, 1.0, 1.0]}, "not a list of numbers"),
        ({"weights": np.array([1, 2, 3], dtype="M8[s]")}, "not a list of numbers"),
        ({"weights": np.ma.array([1.0, 1.0, 1.0], mask=[0, 1, 0])}, r"weights\[1\] = .*nan"),
        ({"weights": [10**5000, 1, 1]}, "not a list of numbers"),
        ({"offset": np.nan}, "offset"),
        ({"offset": "x"}, "offset"),
        ({"offset": None}, "offset"),
        ({"offset": [1.0, 2.0]}, "offset"),
        ({"center": np.inf}, "center"),
        ({"center": 10**400}, "center is beyond"),
        ({"center": 10**5000}, "center is beyond"),
        ({"center": "9" * 5000 + "x"}, "center"),
        ({"center": 1e200}, "center"),
        ({"state": [0.0, 0.0]}, "2 values for 3 play operators"),
        ({"state": [0.0, np.nan, 0.0]}, "state"),
        (
            {"state": [1.0, 0.5, 0.4]},
            r"not admissible: \|z\[0\] - z\[1\]\| = 0.5 exceeds r\[1\] - r\[0\] = 0.25",
        ),
        ({"state": [0.0, 0.2, -0.2]}, r"\|z\[1\] - z\[2\]\|"),
    ],
)
def test_a_play_model_refuses_impossible_parameters_by_name(change, words):
    with pytest.raises(ParameterError, match=words) as fault:
        PrandtlIshlinskii(**{"thresholds": R, "weights": W, **change})
    assert isinstance(fault.value, DehystError)
    assert isinstance(fault.value, ValueError)
    assert len(str(fault.value)) < 400


def test_facts_of_a_refusal_are_attributes():
    with pytest.raises(ParameterError) as fault:
        PrandtlIshlinskii([0.0, 2.0, 1.0], W)
    assert fault.value.facts["index"] == 2
    with pytest.raises(ParameterError) as fault:
        PrandtlIshlinskii(R, W, state=[0.0, 0.0, 9.0])
    assert fault.value.facts["index"] == 1


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (([0.1, 0.5], [0.0, 1.0], 1.0), "first element must be r_1 = 0"),
        (([0.0, 0.5], [0.1, 1.0], 1.0), "s_1 = 0.1"),
        (([0.0, 0.5], [0.0, 1.0, 2.0], 1.0), "2 thresholds but 3 stop weights"),
        (([0.0, 0.5], [0.0, 1.0], np.nan), "slope"),
        (([0.0, 0.5], [0.0, np.nan], 1.0), r"stop_weights\[1\]"),
        (([0.0, 0.5, 0.4], [0.0, 1.0, 1.0], 1.0), "increase strictly"),
        (([0.0, 0.5], [0.0, 1.0], 1.0, 0.0, [0.0, 2.0]), "not admissible"),
    ],
)
def test_a_stop_model_refuses_impossible_parameters_by_name(arguments, words):
    with pytest.raises(ParameterError, match=words):
        StopOperatorModel(*arguments)


@pytest.mark.parametrize(
    ("u", "v", "words"),
    [
        ([0.0], [0.0], "at least two breakpoints"),
        ([0.0, 1.0], [0.0, 1.0, 2.0], "as many values"),
        ([0.0, 0.0], [0.0, 1.0], "u must increase strictly"),
        ([0.0, 1.0], [1.0, 1.0], "v must increase|-v must increase"),
        ([0.0, 1.0, 2.0], [0.0, 2.0, 1.0], "v must increase"),
        ([0.0, 1.0, 2.0], [0.0, 1.0, -1.0], "-v must increase"),
        ([0.0, np.nan], [0.0, 1.0], r"u\[1\]"),
        ([0.0, 1.0], [0.0, np.inf], r"v\[1\]"),
    ],
)
def test_a_map_refuses_to_be_anything_but_strictly_monotone(u, v, words):
    with pytest.raises(ParameterError, match=words):
        MonotoneMap(u, v)


def test_a_modified_model_needs_a_map():
    with pytest.raises(ParameterError, match="without a map"):
        ModifiedPrandtlIshlinskii(PrandtlIshlinskii(R, W))


@pytest.mark.parametrize(
    "signal",
    [
        5.0,
        [[1.0], [2.0]],
        ["a"],
        [1j],
        np.array([1j]),
        np.array(["2020-01-01"], dtype="M8[s]"),
        [10**400],
        {},
    ],
)
def test_a_signal_that_is_no_column_of_numbers_is_refused(signal):
    with pytest.raises(ParameterError, match="input x"):
        PrandtlIshlinskii(R, W).simulate(signal)


@pytest.mark.filterwarnings("ignore:.*samples are not finite")
def test_masked_samples_are_held_not_read():
    x = np.ma.array([1.0, 99.0, 0.5], mask=[False, True, False])
    model = PrandtlIshlinskii(R, W)
    assert model.simulate(x).tolist() == model.simulate([1.0, np.nan, 0.5]).tolist()


def every_family():
    bend = MonotoneMap([0.0, 1.0, 3.0], [0.0, 2.0, 3.0])
    inner = PrandtlIshlinskii(R, W, 0.5, [0.1, 0.0, 0.2], -1.0)
    return [
        inner,
        ModifiedPrandtlIshlinskii(inner, after_map=bend),
        StopOperatorModel(R, [0.0, 1.0, 0.0], 0.5),
        StaticCurve(bend),
    ]


@pytest.mark.parametrize("model", every_family(), ids=lambda m: m.family)
def test_models_are_frozen(model):
    with pytest.raises(dataclasses.FrozenInstanceError):
        model.card = ModelCard()
    for name in ("thresholds", "weights", "stop_weights", "state"):
        array = getattr(model, name, None)
        if array is not None:
            with pytest.raises(ValueError, match="read-only"):
                array[0] = 1.0


def test_a_model_keeps_its_own_copy_of_the_parameters():
    r, w = np.array(R), np.array(W)
    model = PrandtlIshlinskii(r, w)
    r[:], w[:] = 7.0, 7.0
    assert model.thresholds.tolist() == R
    assert model.weights.tolist() == W


@pytest.mark.parametrize("model", every_family(), ids=lambda m: m.family)
def test_cards_travel_and_swap_with_the_inverse(model):
    card = ModelCard(
        SignalCard("pressure", "bar", 0.0, 4.0), SignalCard("angle", "deg"), {"log": "a.csv"}
    )
    with_card = model.with_card(card)
    assert with_card.card is card
    inverse = with_card.inverse()
    assert inverse.card.input.label == "angle [deg]"
    assert inverse.card.output.label == "pressure [bar]"
    assert inverse.card.provenance["log"] == "a.csv"
    assert with_card.with_state(None).card is card


def test_a_modified_model_takes_over_the_card_of_its_operator():
    card = ModelCard(SignalCard("pressure", "bar"))
    model = ModifiedPrandtlIshlinskii(
        PrandtlIshlinskii(R, W, card=card), after_map=MonotoneMap([0, 1], [0, 1])
    )
    assert model.card is card


def test_counts_of_weights_ignore_zeros():
    assert PrandtlIshlinskii(R, [1.0, 0.0, 0.5]).nonzero_weights == 2
    assert StopOperatorModel(R, [0.0, 1.0, 0.0], 0.5).nonzero_weights == 2
    assert StopOperatorModel(R, [0.0, 1.0, 0.0], 0.0).nonzero_weights == 1
    assert StaticCurve(MonotoneMap([0, 1], [0, 1])).nonzero_weights == 0


def test_gains_are_those_of_the_flattest_slope():
    assert PrandtlIshlinskii(R, [0.5, 1.0, -1.25]).inverse_gain == 4.0
    assert PrandtlIshlinskii(R, [1.0, -1.0, 1.0]).inverse_gain == np.inf
    assert StopOperatorModel(R, [0.0, 1.0, 1.0], 0.125).inverse_gain == 8.0
    flat = MonotoneMap([0.0, 1.0, 2.0], [0.0, 1.0, 1.25])
    assert StaticCurve(flat).inverse_gain == 4.0
    assert (
        ModifiedPrandtlIshlinskii(PrandtlIshlinskii([0.0], [0.5]), after_map=flat).inverse_gain
        == 8.0
    )
    assert StaticCurve(MonotoneMap([0.0, 1e3], [0.0, 5e-324])).inverse_gain == np.inf
