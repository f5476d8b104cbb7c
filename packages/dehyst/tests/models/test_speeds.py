"""How fast a signal moves is found, whatever its shape, noise, rests and sampling; one faster than a log is said."""

import json

import numpy as np
import pytest

import dehyst
from dehyst.data import POLICY as POLICY_OF_LOGS
from dehyst.data import top_speed
from dehyst.data._speeds import _passes
from dehyst.models._policy import POLICY
from dehyst.models._speed import faster_than_log

SHAPES = ("sine", "triangle", "growing", "rests", "two speeds")


def strokes(durations, rest=0.0, step=0.01, sizes=(1.0,)):
    """Straight strokes from -size to size and back, a rest after each: time and values."""
    times, values = [0.0], [-sizes[0]]
    for k, seconds in enumerate(durations):
        times += [times[-1] + seconds, times[-1] + seconds + rest + 1e-9]
        values += [sizes[k % len(sizes)] * (1 if k % 2 == 0 else -1)] * 2
    time = np.arange(0.0, times[-1], step)
    return time, np.interp(time, times, values)


def moving(shape, speed, step=0.01):
    """A signal of the range -1 to 1 whose fast strokes go over `speed` ranges a second: time and values."""
    time = np.arange(0.0, 60.0 / speed, step / speed)
    if shape == "sine":
        return time, np.sin(2.0 * speed * time)
    if shape == "growing":
        return time, np.sin(2.0 * speed * time) * np.linspace(0.1, 1.0, time.size)
    durations, rest = {
        "triangle": ([1.0 / speed] * 40, 0.0),
        "rests": ([1.0 / speed] * 8, 20.0 / speed),
        "two speeds": ([1.0 / speed] * 6 + [30.0 / speed] * 6, 0.0),
    }[shape]
    return strokes(durations, rest, step / speed)


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("speed", [1e-3, 0.3, 40.0])
@pytest.mark.parametrize("noise", [0.0, 2e-3, 1e-2])
def test_the_speed_of_the_fast_strokes_is_found(shape, speed, noise):
    for seed, step in ((0, 0.01), (1, 0.002), (2, 0.04)):
        time, x = moving(shape, speed, step)
        x = x + noise * np.random.default_rng(seed).standard_normal(x.size)
        assert top_speed([(time, x)], 2.0) == pytest.approx(speed, rel=0.3)


def test_a_false_value_a_gap_and_a_still_signal_have_no_speed():
    time, x = moving("triangle", 0.3)
    spiked = x.copy()
    spiked[1000] += 1.0
    assert top_speed([(time, spiked)], 2.0) == pytest.approx(0.3, rel=0.3)
    keep = (time < 50.0) | (time > 90.0)
    assert top_speed([(time[keep], x[keep])], 2.0) == pytest.approx(0.3, rel=0.3)
    assert top_speed([(time, np.zeros(time.size))], 2.0) == 0.0
    assert top_speed([(time[:1], x[:1])], 2.0) == 0.0
    assert top_speed([], 2.0) == 0.0


@pytest.fixture(scope="module")
def model():
    from cures import creeping

    time, x = moving("triangle", 0.3, 0.02)
    record = dehyst.Recording(input=x, output=creeping(x, time, (0.5, 2.0)), time=time)
    return dehyst.identify(record, "creep-pi").model


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("size", [1.0, 0.3])
def test_a_reference_at_the_speed_of_the_log_brings_no_word_and_a_faster_one_does(
    model, shape, size
):
    span = model.card.output.high - model.card.output.low
    for times in (0.2, 1.0, 4.0, 50.0):
        time, x = moving(shape, 0.3 * times / size)
        said = faster_than_log(
            model, model.card.output, "the reference", [(time, 0.5 * span * size * x)]
        )
        assert bool(said) == (times > POLICY.faster), (times, said)
        assert all(
            "ranges a second" in finding.message and "--rate" in finding.message for finding in said
        )


def test_a_model_that_depends_on_no_time_or_does_not_tell_its_speed_brings_no_word(model, tmp_path):
    time, x = moving("sine", 30.0)
    card = model.card
    assert faster_than_log(model, card.input, "the input", [(time, x)])
    assert faster_than_log(model, card.input, "the input", [(None, x)]) == []
    plays = dehyst.PrandtlIshlinskii([0.0, 0.3], [1.0, 0.4], card=card)
    assert faster_than_log(plays, card.input, "the input", [(time, x)]) == []
    model.save(tmp_path / "m.json")
    assert json.loads((tmp_path / "m.json").read_text())["provenance"]["fitted_speed"][
        "input"
    ] == pytest.approx(0.3, rel=0.3)
    older = model.with_card(type(card)(card.input, card.output, {}))
    assert faster_than_log(older, card.input, "the input", [(time, x)]) == []


@pytest.mark.slow
def test_every_way_to_identify_keeps_the_speed():
    time, x = moving("triangle", 0.3, 0.02)
    y = dehyst.PrandtlIshlinskii([0.0, 0.3], [1.0, 0.4]).simulate(x)
    record = dehyst.Recording(input=x, output=y, time=time)
    fits = [
        dehyst.identify(record, "pi", n=5),
        dehyst.identify(record, "static"),
        dehyst.identify(record, "direct-inverse", creep=0),
    ]
    for fit in fits:
        assert fit.model.card.provenance["fitted_speed"]["input"] == pytest.approx(0.3, rel=0.3)
    without = dehyst.identify(dehyst.Recording(input=x, output=y), "pi", n=5)
    assert "fitted_speed" not in without.model.card.provenance


def test_whether_the_fastest_samples_pass_a_chord_is_what_the_quantile_of_their_ways_says():
    rng = np.random.default_rng(3)
    for size in (2, 3, 200, 201, 401, 1000):
        # Few levels, so that many ways are equal, and chords at, between and beside them.
        ways = rng.integers(0, 4, size).astype(float)
        for chord in np.linspace(-0.5, 3.5, 17).tolist():
            by_quantile = float(np.quantile(ways, 1.0 - POLICY_OF_LOGS.moving)) >= chord
            assert _passes(ways, chord) is by_quantile
