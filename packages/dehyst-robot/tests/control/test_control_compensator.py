"""Compensators: the protocol of three methods, the paper's one, and answers that must not reach the valves."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dehyst import ModifiedPrandtlIshlinskii, MonotoneMap, PrandtlIshlinskii
from dehyst.errors import DehystError, OutputError, ParameterError
from dehyst_robot.control import (
    Compensator,
    InverseCompensator,
    JointController,
    JointControllerParameters,
    along,
)

MODEL = PrandtlIshlinskii([0.0, 0.3, 0.8], [0.6, 0.2, 0.1])
PATH = 0.5 * np.sin(np.linspace(0, 20, 400))


class Own:
    """Dahl friction of the desired velocity, as a user would write it."""

    def reset(self, angle):
        self.force = 0.0

    def step(self, angle, velocity):
        self.force += 0.01 * velocity * (1 - self.force * np.sign(velocity))
        return 2e4 * self.force

    def output(self):
        return 2e4 * self.force


def test_three_methods_make_a_compensator():
    assert isinstance(Own(), Compensator)
    assert isinstance(InverseCompensator(MODEL.inverse(), 1e5), Compensator)
    assert not isinstance(object(), Compensator)
    term = along(Own(), PATH, np.gradient(PATH))
    assert term.shape == PATH.shape
    assert np.ptp(term) > 0


@given(
    st.lists(st.floats(-1, 1), min_size=1, max_size=50),
    st.floats(0, 1e6),
    st.sampled_from([1.0, 1e5]),
)
def test_the_papers_compensator_is_the_inverse_less_the_shear(path, shear, unit):
    # After the loop is undone nothing but the shear is left: H of the sheared term is the desired angle.
    term = along(InverseCompensator(MODEL.inverse(), shear, unit), path)
    back = MODEL.simulate((term + shear * np.array(path)) / unit)
    np.testing.assert_allclose(back, path, atol=1e-9)


def test_looking_does_not_advance_and_a_reset_starts_anew():
    compensator = InverseCompensator(MODEL.inverse(), 1e5)
    first = along(compensator, PATH)
    assert compensator.output() == compensator.output() == first[-1]
    assert np.array_equal(along(compensator, PATH), first)
    compensator.reset(0.2)
    assert compensator.output() == along(InverseCompensator(MODEL.inverse(), 1e5), [0.2])[0]


def test_a_sample_that_is_no_number_changes_nothing():
    compensator = InverseCompensator(MODEL.inverse(), 1e5)
    compensator.reset(0.3)
    before = compensator.output()
    assert compensator.step(float("nan"), 0.0) == before


@pytest.mark.parametrize("answer", [float("nan"), float("inf"), None, "much", [1.0, 2.0], 1 + 2j])
def test_an_answer_that_is_no_number_is_refused_with_its_sample(answer):
    class Broken(Own):
        def step(self, angle, velocity):
            return answer if angle > 0.4 else 0.0

    with pytest.raises(OutputError, match=r"Broken\.step answered .* at sample \d+") as caught:
        along(Broken(), PATH)
    assert caught.value.facts["sample"] == np.flatnonzero(PATH > 0.4)[0]


@pytest.mark.parametrize(
    ("compensator", "angle", "velocity", "message"),
    [
        (object(), PATH, None, "lacks reset and step and output"),
        (Own(), PATH, PATH[:-1], "400 angles but 399 velocities"),
        (Own(), [0.0, float("nan")], None, "not finite"),
        (Own(), [0.0, 1.0], [float("inf"), 0.0], "not finite"),
        (Own(), "path", None, "angle"),
        (Own(), [[0.0]], None, "shape"),
    ],
)
def test_what_cannot_be_evaluated_is_refused(compensator, angle, velocity, message):
    with pytest.raises(ParameterError, match=message):
        along(compensator, angle, velocity)


def test_an_empty_path_has_an_empty_term():
    assert along(Own(), np.zeros(0)).shape == (0,)


@pytest.mark.parametrize("inverse", [None, "model", 3.0, Own()])
def test_only_a_model_is_an_inverse(inverse):
    with pytest.raises(ParameterError, match="not a hysteresis model"):
        InverseCompensator(inverse, 1e5)


@pytest.mark.parametrize("model", ["pi", Own(), 3.0])
def test_only_a_model_runs_inside_the_controller(model):
    with pytest.raises(DehystError, match="not a hysteresis model"):
        JointController(JointControllerParameters(), model)


def test_models_with_maps_run_inside_the_controller_too():
    curve = MonotoneMap([-1.0, 0.0, 1.0], [-1.5, 0.0, 1.0])
    model = ModifiedPrandtlIshlinskii(MODEL, after_map=curve).inverse()
    joint = JointControllerParameters(ramp=0.0, frozen_samples=0, angle_jump=0.0)
    controller = JointController(joint, model)
    controller.reset(0.0, 3e5, 3e5)
    reference = np.zeros((PATH.size, 7))
    reference[:, 0], reference[:, 4] = PATH, 3e5
    out = controller.run(PATH, *np.full((2, PATH.size), 3e5), reference, np.full(PATH.size, 5))
    np.testing.assert_allclose(
        out.compensation[2:], along(InverseCompensator(model, 1e5), PATH)[2:], atol=1e-6
    )
