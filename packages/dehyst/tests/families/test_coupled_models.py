"""Models of several inputs: their definition, the inverse of two by two, its certificate, files and refusals."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import dehyst
from dehyst import _native
from dehyst.errors import DehystError, InvertibilityError, ModelFileError, ParameterError
from dehyst.families import Scaling
from dehyst.families._coupled import CorePair, CoupledModel
from dehyst.families._elements import Element, ElementModel
from dehyst.models import SignalCard
from element_oracle import answers, signal

SEEDS = st.integers(0, 10**6)
PERIOD = 0.01
INPUTS = (SignalCard("a", "V", -1.0, 1.0), SignalCard("b", "V", -1.0, 1.0))
OUTPUTS = (SignalCard("x", "um", -1.0, 1.0), SignalCard("y", "um", -1.0, 1.0))
SCALES = (
    (Scaling(0.3, 2.0, 1.0, 4.0), Scaling(-1.0, 3.0, 1.0, 4.0)),
    (Scaling(0.3, 2.0, 0.0, -3.0), Scaling(-1.0, 3.0, 0.0, -3.0)),
)


def elements_of(rng, share, least=0.5):
    """A sum whose slope is share (least to least + 0.6): plays, stops, creep, rate and a bent curve."""
    plays = [Element("play", r, weight=share * 0.1) for r in rng.uniform(0.05, 0.8, 3).tolist()]
    bent = Element("play", 0.3, weight=share, map=((-1.0, 0.0, 1.0), (-0.05, 0.0, 0.1)))
    return (
        Element("input", weight=share * least), *plays, bent, Element("creep", 0.1, 0.3, share * 0.1),
        Element("relax", 0.0, 0.2, share * 0.05),
    )  # fmt: skip


def pair_of(seed, shares=((1.0, 0.2), (0.2, 1.0))):
    rng = np.random.default_rng(seed)
    rows = []
    for j, row in enumerate(shares):
        paths = []
        for i, share in enumerate(row):
            offset = 0.1 * (j + 1) if i == 0 else 0.0
            elements = elements_of(rng, share)
            paths.append(
                ElementModel(elements, offset, scaling=SCALES[j][i], start="rest", period=PERIOD)
            )
        rows.append(tuple(paths))
    return CoupledModel(tuple(rows), INPUTS, OUTPUTS, (0.3, -1.0), PERIOD)


def motion(seed, samples=200):
    """Inputs (T, 2) within the scales, and time."""
    u = np.stack(
        [0.3 + 2.0 * signal(seed, samples), -1.0 + 3.0 * signal(seed + 1, samples)], axis=1
    )
    return u, PERIOD * np.arange(samples)


@given(SEEDS)
@settings(max_examples=15, deadline=None)
def test_outputs_are_the_sums_over_both_inputs(seed):
    model = pair_of(seed)
    u, time = motion(seed)
    y = model.simulate(u, time)
    dt = np.full(time.size, PERIOD)  # the first sample comes a period after the rest
    for j, row in enumerate(model.paths):
        total = np.zeros(len(u))
        for i, path in enumerate(row):
            x = np.asarray(path.scaling.inward(u[:, i]))
            rest = float(path.scaling.inward(model.rest[i]))
            total += answers(replace(path, scaling=Scaling()), x, dt, rest)
        assert np.max(np.abs(row[0].scaling.outward(total) - y[:, j])) < 1e-12


@pytest.mark.parametrize(
    "shares",
    [
        ((1.0, 0.2), (0.2, 1.0)),
        ((1.0, -0.9), (0.8, 1.0)),
        ((0.1, 1.0), (-1.0, 0.2)),
        ((-1.0, 0.2), (0.1, 0.8)),
    ],
    ids=["weak", "differential", "crossed", "falling"],
)
@given(seed=SEEDS)
@settings(max_examples=10, deadline=None)
def test_the_inverse_gives_both_inputs_back(shares, seed):
    model = pair_of(seed, shares)
    u, time = motion(seed)
    assert model.determinant > 0.0
    back = model.inverse().simulate(model.simulate(u, time), time)
    assert np.max(np.abs(back - u)) < 1e-12 * 6.0


@given(SEEDS)
@settings(max_examples=10, deadline=None)
def test_the_determinant_is_a_lower_bound_of_what_two_near_motions_show(seed):
    model = pair_of(seed)
    u, time = motion(seed, 60)
    # Both inputs move on their own by a little at the last sample: four slopes.
    step = 1e-6
    slopes = np.empty((2, 2))
    base = model.simulate(u, time)[-1]
    for i in range(2):
        moved = u.copy()
        moved[-1, i] += step
        slopes[:, i] = (model.simulate(moved, time)[-1] - base) / step
    scales = np.array(
        [[path.scaling.half_range / path.scaling.amplitude for path in row] for row in model.paths]
    )
    assert np.linalg.det(slopes * scales) > model.determinant - 1e-6


def test_an_inverse_that_could_have_two_answers_is_refused_with_the_determinant():
    model = pair_of(1, ((1.0, 0.9), (0.9, 1.0)))
    assert model.determinant < 0.0
    with pytest.raises(
        InvertibilityError, match=r"determinant of its slopes may be as low as -0\.\d+"
    ):
        model.inverse()


def test_outputs_that_no_input_within_limits_gives_are_held_at_the_limit_and_flagged():
    model = pair_of(3)
    pair = model.pair(True, ((-1.7, 2.3), (-4.0, 2.0)))
    far = np.array([[50.0, 0.0], [0.0, 50.0], [-80.0, -80.0], [1.0, 0.0]])
    inputs, flags, _ = pair.run(far, np.full(4, PERIOD))
    assert np.all(flags[:3] & 4)
    assert np.all(inputs >= [-1.7 - 1e-12, -4.0 - 1e-12]) and np.all(
        inputs <= [2.3 + 1e-12, 2.0 + 1e-12]
    )


@given(SEEDS)
@settings(max_examples=20, deadline=None)
def test_a_step_takes_few_rounds_and_never_more_than_its_bound(seed):
    rng = np.random.default_rng(seed)
    model = pair_of(seed, ((1.0, rng.uniform(-1.0, 0.3)), (rng.uniform(0.0, 0.3), 1.0)))
    wanted = rng.normal(0.0, 30.0, (100, 2))
    _, _, rounds = CorePair(model, True, np.full(2, -2.0), np.full(2, 2.0)).run(
        wanted, np.full(100, PERIOD)
    )
    assert rounds <= 66
    u, time = motion(seed)
    _, _, usual = CorePair(model, True, np.full(2, -2.0), np.full(2, 2.0)).run(
        model.simulate(u, time), np.diff(time, prepend=0.0)
    )
    assert usual <= 14


def test_a_sample_that_is_no_number_changes_nothing_but_flags():
    model = pair_of(4)
    pair = model.pair(True, ((-1.7, 2.3), (-4.0, 2.0)))
    good = model.simulate(*motion(5, 40))
    with_bad = np.insert(good, 3, [np.nan, 0.0], axis=0)
    expected, _, _ = pair.run(good, np.full(40, PERIOD))
    inputs, flags, _ = pair.run(with_bad, np.full(41, PERIOD))
    assert flags[3] & 1 and np.array_equal(inputs[3], inputs[2])
    assert np.array_equal(np.delete(inputs, 3, axis=0), expected)


def test_one_output_is_inverted_for_its_own_input_while_the_others_are_known():
    full = pair_of(6, ((0.3, 1.0), (0.2, 1.0)))
    model = CoupledModel(full.paths[:1], INPUTS, OUTPUTS[:1], full.rest, PERIOD)
    u, time = motion(7)
    y = model.simulate(u, time)
    assert y.shape == (200, 1) and model.own == (1,)
    back = model.inverse().simulate(y, time, a=u[:, 0])
    assert np.max(np.abs(back - u)) < 1e-11
    with pytest.raises(ParameterError, match="inputs that must be known are a"):
        model.inverse().simulate(y, time)


def test_a_file_gives_the_same_model_to_the_bit(tmp_path):
    model = pair_of(8)
    loaded = dehyst.load(model.save(tmp_path / "pair.json"))
    assert loaded == model and isinstance(loaded, CoupledModel)
    u, time = motion(8)
    assert np.array_equal(loaded.simulate(u, time), model.simulate(u, time))


@pytest.mark.parametrize(
    "change",
    [
        lambda p: p.pop("rest"),
        lambda p: p["paths"].pop(),
        lambda p: p["inputs"][0].pop("name"),
        lambda p: p.update(rest=[0.0]),
        lambda p: p["paths"][0][0].update(scaling={}) or p["paths"][0][0].update(values={}),
        lambda p: p.update(period="soon"),
    ],
)
def test_a_file_that_lacks_a_part_is_refused_by_name(change):
    from dehyst.models._storage import model_from_dict, signed

    model = pair_of(9)
    parameters = model.file_parameters()
    change(parameters)
    content = signed(model.file_kind, model.family, parameters, model.card)
    with pytest.raises(ModelFileError, match=r"pair\.json"):
        model_from_dict(content, "pair.json")


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda m, u, t: m.simulate(u), "no time was passed"),
        (lambda m, u, t: m.simulate(u[:, 0], t), "pass a column for each of a, b"),
        (lambda m, u, t: m.simulate(np.full_like(u, np.nan), t), "200 samples of the inputs are not finite"),
        (lambda m, u, t: m.simulate(u * 1e200, t), "not finite or beyond|are beyond"),
        (lambda m, u, t: m.simulate(u, t, c=t), "takes them as columns, not c"),
        (lambda m, u, t: m.stepper(), "has no stepper"),
        (lambda m, u, t: m.at_rest(0.0), r"model.rested"),
        (lambda m, u, t: dehyst.block(m), "dehyst export MODEL --target c"),
        (lambda m, u, t: CoupledModel(m.paths, INPUTS[:1], OUTPUTS, (0.0,)), "1 inputs at rest"),
        (lambda m, u, t: m.inverse().simulate(u, t, a=t), "both inputs are looked for"),
    ],
)  # fmt: skip
def test_what_does_not_fit_is_refused_with_what_to_pass(call, words):
    with pytest.raises(DehystError, match=words):
        call(pair_of(10), *motion(10))


def test_the_core_refuses_parameters_of_no_pair():
    model = pair_of(11)
    pair = CorePair(model, True, np.full(2, -2.0), np.full(2, 2.0))
    for place, value in ((2, 0.0), (6, 0.0), (0, np.nan), (10, 3.0)):
        numbers = pair.numbers.copy()
        numbers[place] = value
        with pytest.raises(ValueError, match="not those of a pair"):
            _native.ElementPair(*pair._native_sums, numbers, True)
