"""What a log lacks is said where its data are judged, and nothing is called absent that was not looked for."""

import numpy as np
import pytest

import dehyst
from dehyst.findings import Grade
from dehyst.report._judgement import lights

PLAYS = dehyst.PrandtlIshlinskii([0.0, 0.4, 0.9], [0.6, 0.5, 0.3])
VARIED = (2.0, -1.6, 1.2, -2.0, 0.8, -0.4, 1.6, -1.2, 2.0, -0.8, 0.4, -1.8)


def log(corners, samples=80, hold=0, slow=1, timed=True):
    """Strokes between corners at one speed, each held for some samples, every third `slow` times slower."""
    parts = []
    for k, (begin, end) in enumerate(zip((0.0, *corners), (*corners, 0.0), strict=True)):
        size = max(2, round(samples * abs(end - begin) / 4.0)) * (slow if k % 3 == 0 else 1)
        parts += [np.linspace(begin, end, size, endpoint=False), np.full(hold, end)]
    x = np.concatenate(parts)
    y = PLAYS.simulate(x) + 0.01 * np.random.default_rng(0).standard_normal(x.size)
    return dehyst.Recording(input=x, output=y, time=0.02 * np.arange(x.size) if timed else None)


def data_light(fit):
    return next(light for light in lights(fit) if light.aspect == "The data")


@pytest.mark.slow
def test_fourteen_loops_of_one_size_are_not_called_good_data():
    fit = dehyst.identify(log((2.0, -2.0) * 28))
    light = data_light(fit)
    assert light.grade is Grade.CARE
    assert "one size" in light.reason and "no holds" in light.reason
    assert "dependence on rate and time (creep) cannot be told" in light.reason
    assert "dehyst design --range -2 2" in light.reason


@pytest.mark.parametrize(
    ("make", "lacks"),
    [
        (lambda: log((2.0, -1.4) * 28), {"no holds", "one speed"}),
        (lambda: log((2.0, -2.0) * 14, hold=60, slow=3), set()),
        (lambda: log(VARIED * 4, timed=False), {"no holds", "one speed", "no time stamps"}),
    ],
)
def test_what_a_log_lacks_is_named_and_nothing_else(make, lacks):
    reason = data_light(dehyst.identify(make(), "pi", n=20)).reason
    assert {
        words for words in ("no holds", "one speed", "no time stamps") if words in reason
    } == lacks
    assert ("dehyst design" in reason) == bool(lacks)


def test_a_log_with_loops_of_all_sizes_holds_and_speeds_lacks_nothing():
    light = data_light(dehyst.identify(log(VARIED * 4, hold=140, slow=3), "pi", n=20))
    assert light.grade is Grade.GOOD and "dehyst design" not in light.reason
    assert "no dependence on rate and no dependence on time (creep) found" in light.reason


def test_sizes_and_speeds_are_those_of_the_motion():
    motion = dehyst.identify(log((2.0, -2.0) * 20), "pi", n=20).facts.motion
    assert (motion.smallest, motion.largest) == pytest.approx((100.0, 100.0), abs=1.0)
    assert (
        motion.one_size and motion.rests is False and motion.speeds == pytest.approx(1.0, abs=0.05)
    )
    varied = dehyst.identify(log(VARIED * 4, slow=3), "pi", n=20).facts.motion
    assert (
        varied.smallest == pytest.approx(30.0, abs=8.0)
        and varied.largest > 85.0
        and not varied.one_size
    )
