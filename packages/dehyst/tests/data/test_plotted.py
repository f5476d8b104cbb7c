"""Recordings and results draw themselves, in axes of one's own and in a notebook; equal models are equal."""

import copy
from xml.etree import ElementTree

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as pyplot
import numpy as np
import pytest

import dehyst
import dehyst_robot
from dehyst.errors import ParameterError
from dehyst.families._elements import ElementModel

X = 2 * np.sin(np.linspace(0, 40, 800)) * np.linspace(1, 0.3, 800)
REC = dehyst.Recording(
    X, dehyst.PrandtlIshlinskii([0.0, 0.6], [1.0, 0.5]).simulate(X), input_unit="bar"
)
FIT = dehyst.identify(REC, "pi")
SHOWN = {
    "recording": lambda: REC,
    "fit": lambda: FIT,
    "comparison": lambda: dehyst.compare(REC, ["pi", "static"]),
    "drift": lambda: dehyst.drift(FIT.model, [REC]),
}


@pytest.mark.parametrize("what", SHOWN)
def test_a_result_draws_into_given_axes_and_shows_itself_in_a_notebook(what):
    thing = SHOWN[what]()
    figure, axes = pyplot.subplots()
    assert thing.plot(axes) is axes and (axes.lines or axes.patches) and figure.get_axes() == [axes]
    root = ElementTree.fromstring(thing._repr_html_())
    drawn = [each for each in root.iter() if each.tag.endswith("path")]
    assert len(drawn) > 5 and not [each for each in root.iter() if "script" in each.tag]
    pyplot.close("all")


def test_the_loop_that_is_drawn_is_the_one_that_was_logged():
    line = REC.plot().lines[0]
    np.testing.assert_allclose(
        [line.get_xdata().min(), line.get_xdata().max()], [X.min(), X.max()], atol=1e-3
    )
    pyplot.close("all")


def test_what_has_no_picture_is_refused_with_what_has():
    with pytest.raises(ParameterError, match="a Recording, its Loops, a data sheet, the Fit"):
        dehyst.plot(3)


@pytest.mark.parametrize(
    "model",
    [FIT.model, ElementModel.example(), FIT.model.inverse(), dehyst.identify(REC, "static").model],
)
def test_a_model_equals_its_copy_and_has_its_hash(model):
    other = copy.deepcopy(model)
    assert other == model and hash(other) == hash(model) and model != 3 and {model: 1}[other] == 1


def test_models_differ_by_weights_start_direction_and_signals(tmp_path):
    base = dehyst.PrandtlIshlinskii([0.0, 0.6], [1.0, 0.5])
    others = (
        dehyst.PrandtlIshlinskii([0.0, 0.6], [1.0, np.nextafter(0.5, 1)]),
        base.at_rest(1.0),
        base.inverse(),
        FIT.model,
    )
    assert all(other != base for other in others)
    base.save(tmp_path / "model.json")
    assert dehyst.load(tmp_path / "model.json") == base


def test_dir_of_the_package_shows_public_names_only():
    assert dir(dehyst) == sorted(dehyst.__all__)


def test_a_robot_is_shown_in_a_line():
    assert len(repr(dehyst_robot.load_robot(conditions="kind"))) < 250
