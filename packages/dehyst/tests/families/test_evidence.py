"""The one test of rate and creep: found where they are, not where they are not, "cannot tell" where a log cannot."""

import numpy as np
import pytest

import dehyst
from dehyst.identification._evidence import Evidence, evidence, rows_of
from dehyst.identification._evidence_rows import TimedStretch
from dehyst.identification._fit import LoopFacts
from dehyst.report._judgement import lights

STEP = 0.05
STOPS = ((0.05, 1.2), (0.3, 0.5))


def steps_with_rests():
    """Strokes of all sizes at two speeds, each followed by a rest of 0.5 to 8 s."""
    rng, parts, last = np.random.default_rng(7), [], 0.0
    for k in range(40):
        to, seconds = (float(rng.uniform(-1, 1)) if k % 7 else (-1.0) ** k), rng.choice([1.5, 4.0])
        share = np.arange(0.0, seconds, STEP) / seconds
        parts += [
            last + (to - last) * (3 - 2 * share) * share**2,
            np.full(int(rng.choice([0.5, 3, 8]) / STEP), to),
        ]
        last = to
    return np.concatenate(parts)


def sines():
    return np.sin(2 * np.pi * np.arange(0.0, 84.0, STEP) / 6.0)


def opposing(q, creep, rate):
    """Stops, lags in time and viscosity, sample by sample."""
    plays, lags, out = [q[0]] * len(STOPS), [q[0], q[0]], np.empty(q.size)
    for k, value in enumerate(q):
        plays = [max(value - r, min(value + r, z)) for (r, _), z in zip(STOPS, plays, strict=True)]
        lags = [
            z + (1 - np.exp(-STEP / tau)) * (value - z)
            for z, tau in zip(lags, (1.0, 8.0), strict=True)
        ]
        speed = (value - q[max(k - 1, 0)]) / STEP
        out[k] = sum(w * (value - z) for (_, w), z in zip(STOPS, plays, strict=True)) + rate * speed
        out[k] += creep * sum(value - z for z in lags)
    return out


def made(kind, q, creep=0.0, rate=0.0, wander=0.0):
    """Input and output of an actuator: friction at the output, a lagging output, or a force."""
    rng = np.random.default_rng(1)
    terms = opposing(q, creep, rate) + 0.005 * rng.standard_normal(q.size)
    terms += wander * np.cumsum(rng.standard_normal(q.size)) / np.sqrt(q.size)
    return {
        "friction": (q + terms, q),
        "lagging": (q, q - 0.4 * terms),
        "clockwise": (q, 0.5 * q + terms),
    }[kind]


def found(x, y):
    time = STEP * np.arange(x.size)
    return {each.group: each for each in evidence([TimedStretch(time, x, y, time >= 0.0)])}


@pytest.mark.spread(8)
@pytest.mark.parametrize("kind", ["friction", "lagging", "clockwise"])
@pytest.mark.parametrize(("creep", "rate"), [(0.0, 0.0), (0.15, 0.0), (0.0, 0.15), (0.15, 0.15)])
@pytest.mark.parametrize("wander", [0.0, 0.03])
def test_what_is_there_is_found_and_nothing_else_whichever_signal_drives(kind, creep, rate, wander):
    says = found(*made(kind, steps_with_rests(), creep, rate, wander))
    assert says["creep"].told and says["rate"].told
    assert (says["creep"].there, says["rate"].there) == (creep > 0.0, rate > 0.0)


@pytest.mark.parametrize("kind", ["friction", "lagging", "clockwise"])
@pytest.mark.parametrize("creep", [0.0, 0.15])
def test_loops_of_one_size_and_speed_cannot_tell(kind, creep):
    says = found(*made(kind, sines(), creep))
    assert not any(each.told or each.there for each in says.values())
    assert all("cannot be told" in str(each) for each in says.values())


def test_units_signs_and_offsets_change_nothing():
    x, y = made("lagging", steps_with_rests(), creep=0.15)
    for other in (found(1e-6 * x + 3.0, 1e5 * y), found(x, -y), found(-x, y - 70.0)):
        for group, each in found(x, y).items():
            assert (other[group].there, other[group].told) == (each.there, each.told)
            assert other[group].own == pytest.approx(each.own, rel=1e-6)


def test_a_loop_that_grows_with_a_load_is_tested_beside_the_load():
    q = steps_with_rests()
    load = 0.5 + 0.5 * np.sin(0.05 * np.arange(q.size) * STEP)
    x = q + (0.5 + load) * opposing(q, 0.15, 0.0)
    time = STEP * np.arange(q.size)
    says = evidence([TimedStretch(time, x, q, time >= 0.0, (load,))])
    assert [each.there for each in says] == [False, True]


@pytest.mark.slow
@pytest.mark.parametrize("creep", [0.0, 0.15])
def test_both_directions_and_the_report_say_the_same_of_one_log(creep):
    x, y = made("friction", steps_with_rests(), creep)
    log = dehyst.Recording(input=x, output=y, time=STEP * np.arange(x.size))
    forward, direct = dehyst.identify(log), dehyst.identify(log, "direct-inverse")
    assert [str(each) for each in forward.facts.evidence] == [str(each) for each in direct.evidence]
    assert forward.as_dict()["evidence"] == direct.as_dict()["evidence"]
    says = {each.group: each for each in direct.evidence}
    assert says["creep"].there == (creep > 0.0)
    (reason,) = (light.reason for light in lights(forward) if light.aspect == "The data")
    assert ("of range depend on time (creep)" in reason) == (creep > 0.0)
    denied = "no dependence on time (creep)" in reason
    assert denied == (creep == 0.0) or "one of size" in reason or "too small for a test" in reason
    assert any(
        "found" in words and ("not found" in words) == (creep == 0.0)
        for words in direct.evidence_words
    )


def test_a_log_without_time_or_of_few_samples_says_that_it_cannot_tell():
    x, y = made("lagging", steps_with_rests())
    fit = dehyst.identify(dehyst.Recording(input=x, output=y), "pi", n=20)
    assert fit.facts.evidence == () and fit.facts.rate_dependence_percent is None
    assert "no time stamps" in fit.facts.lacking(-1.0, 1.0) and "--range -1 1" in fit.facts.lacking(
        -1.0, 1.0
    )
    assert found(x[:150], y[:150]) == {}


def test_a_dependence_is_there_by_p_by_size_and_by_what_is_its_own():
    assert Evidence("creep", 1.0, 0.5, 10, 10, 0.001, own=0.05).there
    assert not Evidence("creep", 1.0, 0.5, 10, 10, 0.001, own=0.03).there
    assert (
        not Evidence("creep", 1.0, 0.99, 10, 10, 0.001).there
        and not Evidence("creep", 1.0, 0.5, 8, 10, 0.06).there
    )
    assert Evidence("rate", 1.0, 0.6, 10, 10, 0.001).size_percent == pytest.approx(0.8)


def test_of_long_logs_some_rows_are_taken_at_least_forty_to_a_swing():
    assert rows_of([1000, 2000], 10) == [slice(0, 1000), slice(0, 2000)]
    (rows,) = rows_of([1_000_000], 100)
    assert rows == slice(0, 1_000_000, 20)
    (rows,) = rows_of([1_000_000], 12_500)
    assert rows == slice(0, 100_000, 2)


@pytest.mark.parametrize("lead", [0.0, 1.0])
def test_on_one_sine_what_a_saturating_response_shows_is_not_named(lead):
    q = np.concatenate([np.zeros(int(lead / STEP)), sines()])
    speed = np.gradient(q, STEP)
    force = np.tanh(3.0 * speed) + 0.1 * q + 0.02 * np.random.default_rng(3).standard_normal(q.size)
    log = dehyst.Recording(input=q, output=force, time=STEP * np.arange(q.size))
    fit = dehyst.identify(log, "stop", n=20)
    assert not any(each.told for each in fit.facts.evidence)
    said = " ".join(
        [
            fit.verdict,
            *(finding.message for finding in fit.warnings),
            *(each.reason for each in lights(fit)),
        ]
    )
    assert (
        "depend on time" not in said
        and "depend on rate," not in said
        and "no dependence on" not in said
    )
    assert "direct-inverse for loops that lag" not in said


def test_what_is_found_but_not_told_apart_is_one_sentence_that_names_neither():
    pair = (
        Evidence("rate", 3.2, 3.0, 9, 10, 0.01, 0.2, 0.02),
        Evidence("creep", 6.0, 3.0, 10, 10, 0.001, 0.2, 0.04),
    )
    facts = LoopFacts("clockwise", 1, 90.0, 12, 24, 0.0, evidence=pair)
    assert facts.depends == ("5.2 % of range depend on rate or time",)
    assert "rate and creep cannot be told apart" in facts.lacking(0.0, 1.0)
