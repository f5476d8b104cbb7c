"""Sums of elements: kinds by their definitions, the exact inverse, monotone for any memory, other families as rows."""

import dataclasses
import itertools
import json
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import dehyst
from dehyst import _native
from dehyst.errors import InvertibilityError, ModelFileError, ParameterError
from dehyst.families import Dahl, Scaling
from dehyst.families._elements import KINDS, Element, ElementModel
from dehyst.families._rising import least_slope
from element_oracle import answers, bend, random_model, signal

SEEDS = st.integers(0, 10**6)
EXACT = tuple(kind for kind in KINDS if kind != "path")
BY_TWO = ((-1, -0.5, 0.5), (0, 0.0, 2.0))


def steps_of(x, seed=0, period=0.02):
    return np.random.default_rng(seed).uniform(0.5, 1.0, x.size) * period


def visited(model, seed):
    """A memory that an input leaves."""
    x = signal(seed, 40)
    return model.run(x, steps_of(x, seed), model.rest(0.3))[1]


@pytest.mark.parametrize("kind", KINDS)
@given(seed=SEEDS)
@settings(max_examples=10, deadline=None)
def test_every_kind_is_its_definition(kind, seed):
    rng = np.random.default_rng(seed)
    x = signal(seed, 60) * (
        0.1 if kind == "path" else 1.0
    )  # exp is exact to 1e-7 for steps of half a length
    dt = steps_of(x, seed) * (rng.random(x.size) > 0.2)
    radius, time = float(rng.uniform(0.2, 0.9)), float(rng.choice([0.0, 0.01, 1.0]))
    read = (Element("past", 0.0, 0.3, 0.2),) if kind == "product" else ()
    model = ElementModel((Element(kind, radius, time, 0.7), *read))
    expected = answers(model, x, dt, 0.1)
    got = model.run(x, dt, model.rest(0.1))[0]
    assert np.max(np.abs(got - expected)) < (1e-6 if kind == "path" else 1e-14)


@pytest.mark.slow
@given(SEEDS)
@settings(max_examples=30, deadline=None)
def test_sums_with_maps_and_schedules_are_their_definition(seed):
    rng = np.random.default_rng(seed)
    model = random_model(
        seed, EXACT, schedules=BY_TWO, before_map=bend(rng, 0.2, 2.0), after_map=bend(rng, 0.2, 2.0)
    )
    x = signal(seed, 60)
    dt, sigma = steps_of(x, seed), rng.uniform(-1.0, 3.0, (x.size, 3))
    expected = answers(model, x, dt, -0.2, sigma)
    got = model.run(x, dt, model.rest(-0.2), sigma)[0]
    assert np.max(np.abs(got - expected)) < 1e-13 * (1.0 + np.max(np.abs(expected)))


@given(SEEDS, SEEDS)
@settings(max_examples=60, deadline=None)
def test_the_inverse_after_the_model_is_exact_from_any_visited_memory(seed, other):
    for kinds, most in ((EXACT, 1e-12), (KINDS, 1e-9)):
        model = random_model(seed, kinds)
        memory, x = visited(model, other), signal(other + 1)
        dt = np.full(x.size, 0.02)
        y, after = model.run(x, dt, memory)
        back, same = model.run_inverse(y, dt, memory)
        assert np.max(np.abs(back - x)) <= most * 2.0
        assert np.max(np.abs(same - after)) <= most * 20.0


@given(SEEDS, SEEDS)
@settings(max_examples=60, deadline=None)
def test_the_output_rises_with_the_present_sample_for_any_memory(seed, other):
    model = random_model(seed, room=0.05)
    memory = visited(model, other)
    x = np.sort(np.unique(np.concatenate([signal(seed), memory, [-3.0, 3.0]])))
    dt = steps_of(x[:1], other)
    y = np.array([model.run(x[k : k + 1], dt, memory)[0][0] for k in range(x.size)])
    slopes = np.diff(y) / np.diff(x)
    assert np.all(slopes[np.diff(x) > 1e-6] > 0.05 - 1e-6)


@pytest.mark.slow
def test_the_least_slope_of_plays_and_stops_is_met_by_some_memory():
    elements = (
        Element("input", weight=1.0),
        Element("input", map=((-0.5, 0.0, 0.5), (-0.1, 0.0, 0.4))),
        Element("play", 0.1, weight=-0.3),
        Element("play", 0.3, weight=0.2),
        Element("stop", 0.2, weight=-0.15),
    )
    model, found = ElementModel(elements), []
    for seed in range(60):
        memory = visited(model, seed)
        x = memory[0] + np.linspace(-0.9, 0.9, 1801)
        y = np.array([model.run(x[k : k + 1], None, memory)[0][0] for k in range(x.size)])
        found.append(np.min(np.diff(y) / np.diff(x)))
    assert min(found) == pytest.approx(least_slope(elements), abs=1e-9)
    assert least_slope(elements) == pytest.approx(
        1.0 + 0.2 - 0.3 - 0.15
    )  # the smaller play moves, the stop stands


@pytest.mark.parametrize(
    "elements",
    [
        (Element("input", weight=0.5), Element("play", 0.1, weight=-0.5)),
        (Element("play", 0.1),),
        (
            Element("input", weight=0.1),
            Element("past", time=0.02, weight=0.9),
        ),  # a delay cannot be undone
        (Element("input", weight=0.5), Element("past", time=1.0, weight=-0.6)),  # slowly it falls
        (Element("input", weight=-0.1), Element("relax", time=1.0, weight=0.6)),
        (Element("input", weight=0.15), Element("path", 0.3, weight=-0.1)),
        (Element("input", weight=0.5, schedule=1), Element("stop", 0.1, weight=0.5, schedule=2)),
        (
            Element("input", weight=0.5),
            Element("product", 1.0, 1.0, -0.3),
            Element("past", time=1.0, weight=0.0),
        ),
    ],
    ids=[
        "cancelled",
        "backlash",
        "delay",
        "non-minimum",
        "falls-slowly",
        "path",
        "schedule",
        "product",
    ],
)
def test_a_sum_that_can_stand_still_or_fall_has_no_inverse_and_says_the_slope(elements):
    model = ElementModel(elements, period=0.02, schedules=((-1, 0.0, 1.0),))
    with pytest.raises(InvertibilityError, match="slope of the sum"):
        model.inverse()
    with pytest.raises(ParameterError, match="slope of the sum"):
        dataclasses.replace(model, direction="inverse")


def test_products_of_lags_that_cancel_count_as_one():
    def slope(*weights):
        pairs = [
            (Element("product", 1.0, 1.0, w), Element("past", time=5.0, weight=0.0))
            for w in weights
        ]
        return least_slope([Element("input", weight=1.0), *itertools.chain(*pairs)])

    assert slope(0.2) == pytest.approx(1.0 - 0.4)  # both lags follow: twice the input, at its end
    assert slope(0.2, -0.2) == pytest.approx(1.0)
    assert slope(0.3, -0.2) == pytest.approx(1.0 - 0.2)
    assert least_slope(
        [Element("product", 0.5, 1.0, 0.2), Element("past", time=5.0, weight=0.0)]
    ) == pytest.approx(-0.2)


@pytest.mark.parametrize("last", [(), (Element("play", 0.1),), (Element("creep", time=1.0),)])
def test_a_product_without_a_lag_behind_it_is_refused(last):
    with pytest.raises(ParameterError, match="followed by"):
        ElementModel((Element("input"), Element("product", 1.0, 1.0, 0.1), *last))


def test_what_is_pruned_keeps_the_lag_that_a_product_reads():
    product, read = Element("product", 1.0, 0.5, 0.1), Element("past", time=2.0, weight=0.0)
    model = ElementModel((Element("input"), product, read, Element("play", 0.1, weight=0.0)))
    assert model.pruned().elements == (Element("input"), product, read)
    assert (
        dataclasses.replace(model, elements=(Element("input", weight=0.0),)).pruned().parts[0] == 1
    )


def test_lags_that_have_caught_up_make_squares_of_products():
    model = ElementModel(
        (Element("input"), Element("product", 0.8, 0.5, 0.3), Element("past", time=2.0, weight=0.1))
    )
    x = np.array([-1.0, -0.8, -0.4, 0.0, 0.4, 0.8, 1.0])
    expected = 1.1 * x + 0.3 * np.clip(x, -0.8, 0.8) ** 2
    for still in (model.without_lags, model.without_memory):
        assert np.max(np.abs(still.run(x, None, still.rest(0.0))[0] - expected)) < 1e-12


def test_an_inverse_that_the_certificate_lets_pass_does_not_oscillate():
    for seed in range(40):
        model = random_model(seed, ("past", "relax", "creep", "input", "product"), room=0.05)
        rng, dt = np.random.default_rng(seed), np.full(3000, 0.02)
        y = 0.3 * np.sin(0.01 * np.arange(3000))
        quiet = model.run_inverse(y, dt, model.rest(0.0))[0]
        noisy = model.run_inverse(y + 1e-6 * rng.standard_normal(3000), dt, model.rest(0.0))[0]
        assert np.max(np.abs(noisy - quiet)[np.abs(quiet) < 60.0], initial=0.0) < 1e-2


@given(SEEDS)
@settings(max_examples=20, deadline=None)
def test_two_parts_are_one_bit_for_bit(seed):
    for others in ({"dead_time": 0.1}, {"direction": "inverse"}):
        model = random_model(seed, **others)
        x = signal(seed)
        dt = steps_of(x, seed)
        for run in (model.run, model.run_inverse):
            memory = model.rest(float(x[0]))
            whole, last = run(x, dt, memory)
            parts = []
            for part in (slice(0, 1), slice(1, 3), slice(3, 90), slice(90, None)):
                y, memory = run(np.ascontiguousarray(x[part]), dt[part].copy(), memory)
                parts.append(y)
            assert np.array_equal(np.concatenate(parts), whole) and np.array_equal(memory, last)


@pytest.mark.slow
def test_a_solution_takes_few_rounds_and_never_more_than_its_bound():
    most = 0
    for seed in range(300):
        model = random_model(seed, room=1e-3)
        x = signal(seed)
        y, *_ = model._sum.run(x, np.full(x.size, 0.02), None, model.rest(0.0))
        far = np.concatenate([y, 1e6 * signal(seed + 1)])  # out of reach: the ends
        answer, _, rejected, rounds = model._sum.solve(
            far, np.full(far.size, 0.02), None, model.rest(0.0)
        )
        assert np.max(np.abs(answer)) <= 64.0 and not rejected
        most = max(most, rounds)
    assert 3 <= most <= 40  # 120 is the bound


def test_a_demand_out_of_reach_gives_the_end_and_memory_follows_the_end():
    model = ElementModel((Element("input", weight=0.5), Element("play", 0.3, weight=0.5)))
    x, memory = model.run_inverse(np.array([1e9]), None, model.rest(0.0))
    assert x[0] == 64.0 and memory.tolist() == [64.0, 64.0, 64.0, 63.7]


def test_plays_are_the_prandtl_ishlinskii_operator():
    r, w = np.array([0.0, 0.1, 0.3, 0.6]), np.array([0.5, -0.1, 0.3, 0.2])
    plays = tuple(
        Element("play", radius, weight=weight)
        for radius, weight in zip(r.tolist(), w.tolist(), strict=True)
    )
    plain, mine = (
        dehyst.PrandtlIshlinskii(thresholds=r, weights=w, offset=0.2),
        ElementModel(plays, 0.2, start="zero"),
    )
    x = signal(1, 400)
    assert np.max(np.abs(mine.simulate(x) - plain.simulate(x))) < 1e-15
    y = plain.simulate(x)
    assert np.max(np.abs(mine.inverse().simulate(y) - plain.inverse().simulate(y))) < 1e-14


def test_past_creep_moves_towards_the_play_of_the_held_input_over_each_step():
    """q <- t + (q - t) exp(-h / tau), t = clip(q, x' - r, x' + r), x' the sample before: never the sample itself."""
    creeps = [(0.0, 0.1, 0.2), (0.2, 2.0, 0.3)]
    mine = ElementModel(
        (Element("input", weight=0.5), *(Element("past", *creep) for creep in creeps)), period=0.02
    )
    x = signal(2, 300)
    dt = steps_of(x, 3)
    states, expected = [x[0], x[0]], []
    for value, step in zip(x.tolist(), dt.tolist(), strict=True):
        expected.append(
            0.5 * value + sum(w * q for q, (_, _, w) in zip(states, creeps, strict=True))
        )
        targets = [
            max(value - r, min(value + r, q)) for q, (r, _, _) in zip(states, creeps, strict=True)
        ]
        states = [
            t + (q - t) * np.exp(-step / tau)
            for q, t, (_, tau, _) in zip(states, targets, creeps, strict=True)
        ]
    assert np.max(np.abs(mine.run(x, dt, mine.rest(x[0]))[0] - expected)) < 1e-15


def test_the_path_is_dahl_s_element():
    known = Dahl(curve=[0.0, 1.5], lengths=[0.1, 0.4], weights=[-0.3, 0.2])
    elements = (
        Element("input", weight=1.5),
        Element("path", 0.1, weight=-0.3),
        Element("path", 0.4, weight=0.2),
    )
    mine = ElementModel(elements, start="zero")
    x = np.interp(np.arange(2000), np.arange(0, 2000, 100), signal(0, 20))
    assert (
        np.max(np.abs(mine.simulate(x) - dataclasses.replace(known, start="zero").simulate(x)))
        < 2e-6
    )


def test_stops_and_creep_are_those_of_the_direct_inverse_in_the_core():
    radius, gain, x = 0.2, 1.0 - np.exp(-0.02 / 0.5), signal(5, 300)
    low, creep, expected = x[0], x[0], []
    for value in (
        x.tolist()
    ):  # packages/dehyst/core/direct.c: E = y - z, and y - L with L of the present sample
        low, creep = max(value - radius, min(value + radius, low)), creep + gain * (value - creep)
        expected.append(0.7 * (value - low) + 0.4 * (value - creep))
    elements = (
        Element("stop", radius, weight=0.7),
        Element("input", weight=0.4),
        Element("creep", 0.0, 0.5, -0.4),
    )
    model = ElementModel(elements)
    y = model.run(x, np.full(x.size, 0.02), model.rest(x[0]))[0]
    assert np.max(np.abs(y - expected)) < 1e-15


@pytest.mark.parametrize("start", ["zero", "rest", "rising", "origin"])
def test_an_inverse_model_runs_what_it_solves_and_inverts_what_it_evaluates(start):
    model = dataclasses.replace(
        ElementModel.example(),
        direction="inverse",
        start=start,
        scaling=Scaling(3.0, 2.0, -5.0, 7.0),
    )
    u = 3.0 + 2.0 * signal(5)
    time = np.cumsum(steps_of(u))
    assert np.max(np.abs(model.inverse().simulate(model.simulate(u, time), time) - u)) < 1e-12


def test_a_dead_time_delays_the_input_by_whole_periods():
    model = ElementModel.example()
    late = dataclasses.replace(model, dead_time=0.1)
    x = signal(5)
    time = 0.02 * np.arange(x.size)
    y = late.simulate(x, time)
    first = np.full(5, x[0])
    assert np.array_equal(y, model.simulate(np.concatenate([first, x[:-5]]), time))
    assert late.stepper()(float(x[0])) == y[0]


def test_columns_are_the_elements_alone():
    model = ElementModel.example()
    x = signal(5)
    dt = steps_of(x)
    columns, _ = model.columns(x, dt, model.rest(0.1))
    for k, q in enumerate(model.elements):
        read = [replace(model.elements[k + 1], weight=0.0)] if q.kind == "product" else []
        alone = ElementModel((Element(q.kind, q.radius, q.time), *read))
        assert np.array_equal(columns[:, k], alone.run(x, dt, alone.rest(0.1))[0])


@given(SEEDS)
@settings(max_examples=20, deadline=None)
def test_a_file_holds_the_model_to_the_bit(tmp_path_factory, seed):
    rng = np.random.default_rng(seed)
    model = random_model(
        seed, schedules=((-1, -0.5, 0.5),), before_map=bend(rng, 0.2, 2.0), dead_time=0.06
    )
    path = model.save(tmp_path_factory.mktemp("m") / "m.json")
    assert dehyst.load(path) == model
    assert json.loads(json.dumps(model.parameters())) == model.parameters()


def test_a_model_says_whether_it_needs_time_and_what_row_it_is():
    quick, slow = (
        ElementModel(),
        ElementModel((Element("input"), Element("creep", 0.1, 1.0)), row="elements"),
    )
    assert (quick.rate_dependent, slow.rate_dependent, quick.family) == (False, True, "elements")
    with pytest.raises(ParameterError, match="time"):
        slow.simulate([0.0, 1.0])


@pytest.mark.parametrize(
    "bad",
    [
        {"elements": ()},
        {"elements": 5},
        {"elements": ["play"]},
        {"elements": [["play", -1.0]]},
        {"elements": [["path", 0.0]]},
        {"elements": [["creep", 0.0, float("nan")]]},
        {"elements": [["play", 0.1, 0.0, 1e300]]},
        {"elements": [["play", 0.1, 0.0, 1.0, [[0.0, 0.0], [0.0, 1.0]]]]},
        {"elements": [["play", 0.1, 0.0, 1.0, [[0.0], [0.0]]]]},
        {"elements": [["play", 0.1, 0.0, 1.0, [[], []], 3]]},
        {"elements": [["play", 0.1, 0.0, 1.0, [[], []], 0.5]]},
        {"elements": [["magic"]]},
        {"after_map": ((0.0, 1.0), (1.0, 0.0))},
        {"direction": "sideways"},
        {"dead_time": 1.0},
        {"dead_time": 1e9, "period": 0.01},
        {"schedules": [(7, 0.0, 1.0)]},
        {"schedules": [(0, 1.0, 1.0)]},
        {"schedules": [(-1, 0.0, 1.0)] * 4},
        {"schedules": 3},
    ],
)
def test_what_is_no_model_is_refused_with_a_cure(bad):
    with pytest.raises(ParameterError) as fault:
        ElementModel(**bad)
    assert len(str(fault.value)) > 30


def test_samples_that_are_no_numbers_are_refused():
    model = ElementModel.example()
    time = np.arange(3.0)
    for x in ([0.0, np.nan, 1.0], [0.0, 1e300, 1.0]):
        for run in (model, model.inverse()):
            with pytest.raises(ParameterError):
                run.simulate(x, time)
    with pytest.raises(ValueError, match="memory"):
        model.run(np.zeros(1), None, np.zeros(3))
    with pytest.raises(ValueError, match="no input leaves"):
        model.run(np.zeros(1), None, np.full(12, 9.0) * np.arange(12))


def test_a_hostile_file_is_refused(tmp_path):
    from dehyst.models._storage import signed

    model = ElementModel.example()
    content = json.loads(model.save(tmp_path / "m.json").read_text())
    for key, value in (
        ("elements", [[1.0], {}]),
        ("elements", [["play"] * 9]),
        ("row", 3.0),
        ("schedules", [[[1]]]),
    ):
        parameters = {
            **content["parameters"],
            "values": {**content["parameters"]["values"], key: value},
        }
        (tmp_path / "bad.json").write_text(
            json.dumps(signed("dehyst-family", "elements", parameters, model.card))
        )
        with pytest.raises(ModelFileError):
            dehyst.load(tmp_path / "bad.json")


def test_the_binding_refuses_tables_that_do_not_fit():
    whole, none, real = np.zeros(1, dtype=np.int32), np.zeros((2, 0)), np.zeros(1)
    good = [
        whole,
        whole,
        real,
        real,
        real,
        whole,
        none,
        0.0,
        none,
        none,
        -1.0,
        1.0,
        whole[:0],
        none,
    ]
    _native.ElementSum(*good)
    for place, bad in ((0, whole + 9), (1, whole + 1), (2, -np.ones(1)), (3, np.ones(2)), (4, np.array([np.nan])),
                       (5, whole + 2), (6, np.ones((2, 2))), (10, 2.0), (12, whole)):  # fmt: skip
        with pytest.raises(ValueError):
            _native.ElementSum(*[*good[:place], bad, *good[place + 1 :]])


@pytest.mark.parametrize("knot", [0.2, 0.3 - 0.1, 0.2 + 1e-15])
def test_the_least_slope_does_not_hang_on_how_knots_are_rounded(knot):
    """Knots of a ramp and of a play that meet: a step between them as wide as rounding is no stretch of its own."""
    rises = Element("input", map=((-1.0, knot, 1.0), (0.0, 0.0, 1.0 - knot)))
    falls = Element("play", 0.1, weight=-0.9, map=((-1.0, 0.3, 1.0), (0.0, 0.0, 0.7)))
    assert least_slope([Element("input", weight=0.2), rises, falls]) == pytest.approx(0.2)
