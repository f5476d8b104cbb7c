"""Ranges of blocks: what a model reaches, over all histories; and settings that are refused with a cure."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from block_samples import plain, sample
from dehyst import Block, ModifiedPrandtlIshlinskii, MonotoneMap, PrandtlIshlinskii
from dehyst.errors import DehystError, InvertibilityError, ParameterError
from dehyst.models import BlockParameters, HysteresisModel, ModelCard, SignalCard, StaticCurve
from oracles import exact_pi, random_thresholds, random_walk
from test_inverse import FAMILIES, make

SEEDS = st.integers(0, 100_000)
MODEL = PrandtlIshlinskii([0.0, 0.2, 0.4], [0.6, 0.3, 0.3])


def histories(rng, low, high):
    """Yield random histories within a range: many short swings, and few that reach the ends."""
    for swing in (1, 2, 10):
        yield np.interp(random_walk(rng, 60, swing=swing), [-1.0, 1.0], [low, high])
    yield rng.choice([low, high, *rng.uniform(low, high, 3)], 12)


@given(SEEDS)
def test_no_history_leads_out_of_what_is_said_to_be_reached(seed):
    model, bounds, rng = sample(seed, most=8)
    block = Block(model, "forward", bounds)
    for x in histories(rng, *bounds):
        y, _ = plain(model, x)
        assert np.all((y >= block.output.low) & (y <= block.output.high))


def unfriendly(rng):
    """Return an operator with slopes S >= 0 but weights of both signs, wide plays, and a lopsided range."""
    n = int(rng.integers(2, 7))
    r = random_thresholds(rng, n, span=3.0)
    model = PrandtlIshlinskii(r, np.diff(rng.uniform(0.0, 2.0, n), prepend=0.0))
    start = random_walk(rng, 20, swing=2) * rng.uniform(0.2, 4.0)
    low = rng.uniform(-1.5, 0.5)
    return model.with_state(model.final_state(start)), low, low + rng.uniform(0.3, 2.0)


def swings(model, low, high):
    """Return outputs at both ends after one turn at every level of a fine grid: what one turn can leave in memory."""
    values = [model.stepper("dense").output]
    for turn in np.linspace(low, high, 400):
        for end in (low, high):
            step = model.stepper("dense")
            step(turn)
            values.append(step(end))
    return min(values), max(values)


@given(SEEDS)
def test_reached_extremes_are_those_of_a_search_with_plays_wider_than_the_range_too(seed):
    model, low, high = unfriendly(np.random.default_rng(seed))
    block = Block(model, "forward", (low, high))
    smallest, largest = swings(model, low, high)
    grid = (high - low) / 399 * np.max(np.abs(np.cumsum(model.weights))) * 2
    assert block.output.low <= smallest <= block.output.low + grid + 1e-12
    assert block.output.high - grid - 1e-12 <= largest <= block.output.high


def test_a_start_that_remembers_more_than_the_range_can_make_extremes_lie_between_turns():
    # On the way down to m a wide play of negative weight sinks first, one of positive weight later.
    model = PrandtlIshlinskii([0.0, 1.0, 1.2], [1.0, -0.9, 1.5], state=[0.0, 0.5, 0.55])
    block = Block(model, "forward", (-1.0, 0.2))
    at_the_ends = [plain(model, x)[0][-1] for x in ([0.2], [-1.0, 0.2])]
    between = plain(model, [-0.65, 0.2])[0][-1]
    assert between > max(at_the_ends) + 0.1
    assert block.output.high == pytest.approx(between, abs=1e-12)


@given(SEEDS)
def test_models_with_slopes_of_both_signs_are_bounded_too(seed):
    rng = np.random.default_rng(seed)
    n = int(rng.integers(2, 8))
    model = PrandtlIshlinskii(
        random_thresholds(rng, n, 2.0), rng.normal(size=n), rng.normal(), None, rng.normal() * 0.3
    )
    model = model.with_state(model.final_state(random_walk(rng, 30, swing=2)))
    low = rng.uniform(-1.5, 0.5)
    block = Block(model, "forward", (low, low + 1.3))
    for x in histories(rng, low, low + 1.3):
        expected, _ = plain(model, x)
        y, flags = block.run(x)
        assert y.tobytes() == expected.tobytes()
        assert not flags.any()
        block.reset()


@pytest.mark.parametrize("first", [0.0, 0.3])
def test_a_dead_zone_has_a_forward_block_and_no_inverse(first):
    model = PrandtlIshlinskii([first, 0.5], [1.0, 0.5])
    block = Block(model, "forward", (-1.0, 1.0))
    assert block.run([1.0, -1.0])[0].tolist() == plain(model, [1.0, -1.0])[0].tolist()
    if first:
        with pytest.raises(InvertibilityError, match="no inverse"):
            Block(model, "inverse", (-1.0, 1.0))


@pytest.mark.parametrize("family", FAMILIES)
def test_every_family_makes_blocks_that_fit_each_other(family):
    model = make(family, 9, np.random.default_rng(5))
    there, back = Block(model, "forward", (-0.8, 0.9)), Block(model, "inverse", (-0.8, 0.9))
    assert (there.input.low, there.input.high) == (back.output.low, back.output.high) == (-0.8, 0.9)
    size = back.input.high - back.input.low
    assert there.output.low == pytest.approx(back.input.low, abs=1e-12 * size)
    assert there.output.high == pytest.approx(back.input.high, abs=1e-12 * size)
    for wanted, limit in ((back.input.high, 0.9), (back.input.low, -0.8)):
        assert back.step(wanted) in (
            pytest.approx(limit, abs=1e-12),
            pytest.approx(0.1 - limit, abs=1e-12),
        )


@given(st.integers(0, 10_000))
def test_rounding_is_bounded_so_that_no_model_in_range_is_cut_off(seed):
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 20))
    model = PrandtlIshlinskii(random_thresholds(rng, n), rng.uniform(0.1, 1.0, n), 1e6, None, -1e4)
    block = Block(model, "forward", (-1e4 - 1.0, -1e4 + 0.7))
    x = np.array([-1e4 - 1.0, -1e4 + 0.7, -1e4 - 1.0, -1e4 + 0.7])
    y, flags = block.run(x)
    assert not flags.any()
    assert y.tolist() == plain(model, x)[0].tolist()
    exact = exact_pi(x, model.thresholds, model.weights, np.zeros(n), model.offset, model.center)
    assert all(block.output.low <= v <= block.output.high for v in exact)


def test_signals_carry_names_units_and_limits():
    card = ModelCard(SignalCard("pressure", "bar", -0.8, 0.5), SignalCard("angle", "deg"))
    block = Block(MODEL.with_card(card))
    assert (block.output.name, block.output.unit, block.output.low, block.output.high) == (
        "pressure",
        "bar",
        -0.8,
        0.5,
    )
    assert (block.input.name, block.input.unit) == ("angle", "deg")
    assert repr(block).startswith("<Block inverse of 'pi': angle [deg] ")
    forward = Block(MODEL.with_card(card), "forward", range=(-0.1, 0.1))
    assert forward.input == SignalCard("pressure", "bar", -0.1, 0.1)


def test_parameters_are_frozen_and_hold_the_tables_of_the_core():
    p = Block(MODEL, "forward", (-1.0, 1.0), ramp=250).parameters
    assert isinstance(p, BlockParameters)
    np.testing.assert_allclose(p.slope, np.cumsum(MODEL.weights), rtol=1e-15)
    np.testing.assert_allclose(p.loading, MODEL.loading_curve(MODEL.thresholds), rtol=1e-15)
    assert p.fade == 1 / 250
    with pytest.raises(ValueError, match="read-only"):
        p.slope[0] = 1.0
    with pytest.raises(AttributeError):
        p.fade = 1.0


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({}, "pass range=\\(low, high\\)"),
        ({"range": (1.0, -1.0)}, "smallest first"),
        ({"range": (1.0, 1.0)}, "smallest first"),
        ({"range": (float("nan"), 1.0)}, "not a finite number"),
        ({"range": (0.0, 1e300)}, "not a finite number"),
        ({"range": 3.0}, "no pair of numbers"),
        ({"range": (1.0, 2.0, 3.0)}, "no pair of numbers"),
        ({"range": ("a", "b")}, "not a number"),
        ({"range": (-1.0, 1.0), "direction": "backward"}, "'inverse'"),
        ({"range": (-1.0, 1.0), "ramp": 0}, "no number of samples"),
        ({"range": (-1.0, 1.0), "ramp": 1.5}, "no number of samples"),
        ({"range": (-1.0, 1.0), "ramp": True}, "no number of samples"),
        ({"range": (-1.0, 1.0), "ramp": 10**10}, "no number of samples"),
        ({"range": (-1e100, 1e100)}, "Scale its signals"),
    ],
)
def test_settings_that_make_no_block_are_refused_with_a_cure(settings, message):
    with pytest.raises(ParameterError, match=message):
        Block(MODEL, **settings)


@pytest.mark.parametrize("thing", [None, [1.0, 2.0], object(), "model.json"])
def test_things_that_are_no_models_are_refused(thing):
    with pytest.raises(ParameterError, match="hysteresis model"):
        Block(thing, range=(0.0, 1.0))


@pytest.mark.parametrize("on", [[True], np.ones((3, 1)), "yes", None, [object()] * 3])
def test_switches_of_another_shape_or_kind_are_refused(on):
    with pytest.raises(ParameterError, match="pass True or False"):
        Block(MODEL, range=(-1.0, 1.0)).run([0.0, 1.0, 0.5], on)


def test_models_of_extreme_sizes_make_a_block_or_say_why_not():
    flat, steep = MonotoneMap([0.0, 1.0], [0.0, 1e-99]), MonotoneMap([0.0, 1e-99], [0.0, 1.0])
    models: list[HysteresisModel] = [
        *(PrandtlIshlinskii([0.0, r], [w, w]) for r in (1e-90, 1e90) for w in (1e-90, 1e90)),
        *(StaticCurve(curve) for curve in (flat, steep)),
        *(
            ModifiedPrandtlIshlinskii(MODEL, before_map=a, after_map=b)
            for a in (flat, steep)
            for b in (flat, steep)
        ),
    ]
    for model in models:
        for direction in ("inverse", "forward"):
            for bounds in ((-1.0, 1.0), (-1e90, 1e90), (0.0, 1e-300)):
                try:
                    block = Block(model, direction, bounds)
                except DehystError:
                    continue
                y, _ = block.run([0.0, 1.0, -1.0, 1e90, -1e90, 1e-300])
                assert np.all((y >= block.output.low) & (y <= block.output.high))
                block.restore(block.save())


@pytest.mark.parametrize("period", [0.0, -1.0, float("nan")])
def test_a_period_that_is_none_is_refused_by_plays_too(period):
    with pytest.raises(ParameterError, match="period"):
        Block(PrandtlIshlinskii([0.0], [1.0]), range=(-1, 1), period=period)
