"""Homing of a direct inverse: what it guarantees is what the compiled model says of its own doubt."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dehyst import Limits
from dehyst.design import home_model
from dehyst.design._excitation import sampled
from dehyst.errors import ParameterError
from dehyst.models import DirectInverse

LIMITS = Limits(1.0, 4.0)
WEIGHTS = st.lists(st.floats(0.1, 2.0), min_size=2, max_size=2)


@st.composite
def models(draw):
    """Direct inverses without creep, some of them with lags along the path."""
    paths = draw(st.booleans())
    return DirectInverse(
        radii=sorted(draw(st.lists(st.floats(0.02, 0.9), min_size=2, max_size=2, unique=True))),
        stop_weights=draw(WEIGHTS),
        path_lengths=[0.05, 0.3] if paths else [],
        path_weights=draw(WEIGHTS) if paths else [],
        polynomial=[0.1, 1.0],
    )


def samples(homing):
    if homing.duration == 0.0:  # what is known already is enough: stand still
        return np.array([0.0, 1.0]), np.full(2, homing.points[0]), np.zeros(2)
    return sampled(
        homing.points, homing.stroke_s, np.zeros(homing.stroke_s.size), homing.duration / 600
    )


@pytest.mark.exhaustive
@given(
    model=models(), tolerance=st.floats(0.05, 0.5), start=st.floats(-1.0, 1.0), spent=st.booleans()
)
@settings(deadline=None, max_examples=40)
def test_afterwards_the_doubt_of_the_compiled_model_is_the_guaranteed_half_width(
    model, tolerance, start, spent
):
    homing = home_model(
        model, LIMITS, tolerance=tolerance, low=-1.0, high=1.0, start=start, spent=spent
    )
    time, y, _ = samples(homing)
    unknown = model.with_past("unknown").run(y, time)
    assert homing.half_width <= tolerance * (1 + 1e-9)
    assert unknown.doubt[-1] == pytest.approx(homing.half_width, abs=1e-3)
    if spent:
        assert homing.residual <= tolerance * (1 + 1e-9)
        backbone = 0.1 + y[-1]
        assert abs(unknown.u[-1] - backbone) <= homing.residual + 1e-3
    assert y[0] == start and np.abs(y).max() <= 1.0


@pytest.mark.slow
@given(
    model=models(), past=st.lists(st.floats(-1.0, 1.0), min_size=1, max_size=6), spent=st.booleans()
)
@settings(deadline=None, max_examples=40)
def test_the_answer_of_a_model_with_any_past_is_known_to_the_tolerance(model, past, spent):
    homing = home_model(model, LIMITS, tolerance=0.1, low=-1.0, high=1.0, spent=spent)
    _, y, _ = samples(homing)
    earlier = np.concatenate(
        [np.linspace(a, b, 30) for a, b in zip([0.0, *past], [*past, 0.0], strict=True)]
    )
    answers = []
    for before in (earlier, -earlier):
        whole = np.concatenate([before, y])
        answers.append(model.run(whole, 0.01 * np.arange(whole.size)).u[-1])
    assert abs(answers[0] - answers[1]) <= 2 * homing.half_width + 2e-3


def test_a_lag_along_the_path_forgets_with_travel_and_not_with_span():
    model = DirectInverse(path_lengths=[0.5], path_weights=[1.0], polynomial=[0.0, 1.0])
    homing = home_model(model, LIMITS, tolerance=0.01, low=-0.2, high=0.2, spent=False)
    assert homing.half_width == pytest.approx(0.5 * np.exp(-homing.travel / 0.5))
    assert homing.half_width <= 0.01 and homing.travel > np.ptp(homing.points)


def test_the_largest_weight_of_a_schedule_is_counted():
    from dehyst.models import Schedule

    model = DirectInverse(
        radii=[0.3], stop_weights=[[1.0], [3.0]], polynomial=[[0.0, 1.0], [0.0, 1.0]],
        schedules=(Schedule("output", -1.0, 1.0),),
    )  # fmt: skip
    plain = DirectInverse(radii=[0.3], stop_weights=[3.0], polynomial=[0.0, 2.0])
    each = [
        home_model(m, LIMITS, tolerance=0.1, low=-1.0, high=1.0, spent=False)
        for m in (model, plain)
    ]
    assert np.allclose(each[0].points, each[1].points) and each[0].half_width == each[1].half_width


@pytest.mark.slow
@pytest.mark.parametrize(
    ("model", "change", "words"),
    [
        (
            DirectInverse(radii=[0.5], stop_weights=[1.0], polynomial=[0.0, 1.0]),
            {"low": None},
            "no range",
        ),
        (DirectInverse(polynomial=[0.0, 1.0]), {}, "remembers nothing"),
        (
            DirectInverse(radii=[0.5], stop_weights=[1.0], polynomial=[0.0, 1.0]),
            {"tolerance": 0.0},
            "positive number",
        ),
        (
            DirectInverse(radii=[5.0], stop_weights=[1.0], polynomial=[0.0, 1.0]),
            {},
            "Allow a wider range",
        ),
        (
            DirectInverse(path_lengths=[900.0], path_weights=[1.0], polynomial=[0.0, 1.0]),
            {},
            "wider range",
        ),
        (
            DirectInverse(path_lengths=[0.5], path_weights=[1.0], polynomial=[0.0, 1.0]),
            {"start": 9.0},
            "outside the",
        ),
        (
            DirectInverse(path_lengths=[0.5], path_weights=[1.0], polynomial=[0.0, 1.0]),
            {"high": -1.0},
            "low < high",
        ),
    ],
)
def test_a_model_that_cannot_be_homed_is_refused_with_a_cure(model, change, words):
    for spent in (True, False):
        with pytest.raises(ParameterError, match=words):
            home_model(
                model,
                LIMITS,
                **{"tolerance": 0.01, "low": -1.0, "high": 1.0, "spent": spent, **change},
            )
