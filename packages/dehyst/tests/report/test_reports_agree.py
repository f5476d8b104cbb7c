"""Headline, cards, captions, terminal and JSON of a fit say the same: fifty fits are read for contradictions."""

import contextlib
import html
import io
import re
from itertools import pairwise

import numpy as np
import pytest

import dehyst
from dehyst.app._identify import _print
from dehyst.app.requests import IdentifyRequest
from dehyst.errors import DehystError
from dehyst.findings import Grade
from dehyst.report import write_report
from dehyst.report._judgement import lights, overall

GOOD_PERCENT = 3.0
PLAYS = dehyst.PrandtlIshlinskii([0.0, 0.1, 0.3, 0.6], [1.0, 0.3, 0.3, 0.4])


def decay(t, last=0.3):
    return np.sin(t) * np.linspace(1.0, last, t.size)


def lagging(x, dt, tau):
    """First-order lag."""
    y = np.empty_like(x)
    y[0] = x[0]
    for k in range(1, x.size):
        y[k] = y[k - 1] + (x[k] - y[k - 1]) * (1.0 - np.exp(-dt / tau))
    return y


def held(n):
    """Strokes and rests, as of a designed motion."""
    tips = [0.0, 1.0, -1.0, 0.5, -0.5, 0.8, -0.8, 0.3, -1.0, 1.0, 0.0, 0.6, -0.6, 0.0]
    parts = []
    for k, (a, b) in enumerate(pairwise(tips)):
        parts += [np.linspace(a, b, n), np.full((k % 3) * 3 * n, b)]
    return np.concatenate(parts)


def rigs(rng):
    """Name -> input, output, time: mechanisms and motions of many kinds."""
    t = np.linspace(0.0, 40.0, 900)
    dt = t[1]
    x = decay(t)
    y = PLAYS.simulate(x)
    noise = rng.normal(size=t.size)
    one = np.sin(np.linspace(0.0, 2.0 * np.pi, 500))
    steps = held(20)
    time = 0.05 * np.arange(steps.size)
    crept = PLAYS.simulate(steps)
    fast = np.sin(t**1.6 / 5.0)
    yield "plays", x, y, t
    yield "plays, no time", x, y, None
    yield "noisy", x, y + 0.05 * noise, t
    yield "very noisy", x, y + 0.6 * noise, t
    yield "stops", x, 2.5 * x - y, t
    yield "stops, no time", x, 2.5 * x - y + 0.01 * noise, None
    yield "curve", x, x + 0.4 * x**3, t
    yield "falling", x, -y, t
    yield "saturated", x, np.tanh(2.0 * y), t
    yield "creep", steps, crept + 0.4 * lagging(crept, 0.05, 20.0), time
    yield "slight creep", steps, crept + 0.02 * lagging(crept, 0.05, 8.0), time
    yield "rate", fast, lagging(PLAYS.simulate(fast), dt, 0.08), t
    yield "drift", x, y + 0.01 * t, t
    yield "one loop", one, PLAYS.simulate(one), np.arange(500) * 0.01
    yield (
        "two loops",
        *(lambda w: (w, PLAYS.simulate(w)))(decay(np.linspace(0, 4 * np.pi, 600))),
        None,
    )
    yield "one size", np.sin(t), PLAYS.simulate(np.sin(t)) + 0.01 * noise, t
    yield "narrow", x, x + 0.02 * y, t
    yield "unrelated", x, noise, t


FAMILIES = ("auto", "pi", "static", "direct-inverse", "creep-pi", "mixed-sum", "stop", "simulate")


def fit_of(rig, family):
    name, x, y, time = rig
    rec = dehyst.Recording(
        input=x, output=y, time=time, name=name, input_unit="V", output_unit="um"
    )
    if family == "direct-inverse":
        return dehyst.identify(rec, "direct-inverse")
    if family == "simulate":
        return dehyst.identify(rec, purpose="simulate")
    return dehyst.identify(rec, family)


def printed(fit):
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        _print(fit, IdentifyRequest(logs=(), family=fit.family))
    return " ".join(out.getvalue().split())


def shown(fit, tmp_path):
    page = write_report(fit, tmp_path / "r.html").read_text(encoding="utf-8")
    page = re.sub(r"<(script|style)\b.*?</\1>", " ", page, flags=re.DOTALL)
    return " ".join(html.unescape(re.sub(r"<[^>]+>", " ", page)).split())


def number(text):
    return float(text.replace("\u202f", "").replace("−", "-"))


def near(text, value):
    """Whether a printed number is a value, to two digits."""
    return abs(number(text) - value) <= 0.05 * abs(value) + 0.006


def contradictions(fit, tmp_path):
    """What does not agree, in words."""
    facts, json = fit.facts, fit.as_dict()
    page, said = shown(fit, tmp_path), printed(fit)
    cards = {light.aspect: light for light in lights(fit)}
    codes = {finding.code for finding in fit.warnings}
    everything = f"{page} {said} {fit.verdict}"
    score = fit.test or fit.train
    for pattern, value in (
        (r"([\d.]+) % of range rms on", score.rmse_percent),
        (r"RMSE ([\d.]+) % of the output's range on", score.rmse_percent),
        (r"\(([\d.]+) % of the output's range\), \S+ um at worst", score.rmse_percent),
        (r"applied input back to ([\d.]+) % of", fit.input_error.rms_percent),
        (r"opening ([\d.]+) % of range", facts.width_percent),
        (r"\(opening ([\d.]+) % of the output's range\)", facts.width_percent),
        (r"At its widest ([\d.]+) %", facts.width_percent),
        (r"(\d+) complete loops?\b", facts.loops),
    ):
        for text in re.findall(pattern, everything):
            if not near(text, value):
                yield f"'{pattern}' says {text}, the fit {value:.4g}"
    missed = re.search(r"misses the applied input by ([\d.]+) % of", cards["Inverse"].reason)
    if missed and not near(missed[1], fit.input_error.rms_percent):
        yield f"card Inverse says {missed[1]}, the fit {fit.input_error.rms_percent:.4g}"
    block = json["test"] or json["train"]
    if (
        block["rmse_percent"] != score.rmse_percent
        or json["loop"]["width_percent"] != facts.width_percent
    ):
        yield "JSON differs"
    misses = fit.input_error.rms_percent > GOOD_PERCENT
    told = f"its inverse misses by more than {GOOD_PERCENT:g} %" in fit.verdict
    if misses != told and overall(fit) is not Grade.BAD:
        yield "verdict and inverse error"
    if cards["Inverse"].grade is Grade.GOOD and (
        "inverse misses" in fit.verdict or "misses less" in fit.verdict
    ):
        yield f"card Inverse is good: {cards['Inverse'].reason}; verdict: {fit.verdict}"
    grades = [card.grade for card in cards.values()]
    if (overall(fit) is Grade.BAD) != (max(grades) is Grade.BAD):
        yield f"badge {overall(fit)}, cards {grades}"
    if overall(fit) is Grade.CARE and max(grades) is Grade.GOOD:
        yield f"care without a card that says why: {fit.verdict}"
    if facts.loops >= 2 and re.search(r"turns only once|a single loop|never turns", everything):
        yield f"a single loop beside {facts.loops}"
    for group, word, kinds in (
        ("creep", r"time \(creep\)", {"creep", "relax"}),
        ("rate", "rate", {"viscous", "rate"}),
    ):
        denied = re.search(
            rf"no dependence on {word}|no [^.;]*and no dependence on {word}",
            cards["The data"].reason,
        )
        if denied and not kinds.isdisjoint(fit.model.kinds):
            yield f"no {group} under a model that has it"
        if denied and any(each.there for each in facts.evidence if each.group == group):
            yield f"{group} denied and found"
    if re.search(r"\de\+\d\d (s|%)", everything):
        yield f"a number with an exponent: {re.search(r'.{30}e.[0-9][0-9] (s|%)', everything)[0]}"
    if "Inverse" in cards and "inverse is exact" in page and misses:
        yield "exact, and misses"
    named = re.search(r"Before you rely on it, read below: ([^.]*)\.", page)
    weak = {aspect for aspect, card in cards.items() if card.grade is not Grade.GOOD}
    if (set(re.findall("“([^”]+)”", named[1])) if named else set()) != weak:
        yield "what is to be read below is not what is not good"
    for code in re.findall(r"with it \(([a-z, -]+)\)", fit.verdict):
        if not set(code.split(", ")) <= codes:
            yield f"the verdict names {code}, the warnings are {codes}"
    if "2012 paper" in page:
        yield "a stranger's log is told of the 2012 paper"


def pairs():
    made = list(rigs(np.random.default_rng(35)))
    return [
        (rig, family)
        for k, rig in enumerate(made)
        for family in FAMILIES
        if family == "auto" or hash_free(k, family)
    ]


def hash_free(k, family):
    """A third of the other families for each rig, in turn."""
    return (k + FAMILIES.index(family)) % 3 == 0


PAIRS = pairs()


@pytest.mark.slow
@pytest.mark.parametrize("case", range(len(PAIRS)), ids=lambda k: f"{PAIRS[k][0][0]}-{PAIRS[k][1]}")
def test_no_report_contradicts_itself(tmp_path, case):
    try:
        fit = fit_of(*PAIRS[case])
    except DehystError:
        return  # refused, with its reason
    assert list(contradictions(fit, tmp_path)) == []


def test_there_are_fifty_fits():
    assert len(PAIRS) >= 50


@pytest.mark.parametrize("rests", [False, True])
def test_the_width_is_that_of_the_largest_loop_however_many_small_ones_and_rests_lie_within(rests):
    """A play of width 2 r and weight w beside x: the branches lie 2 r w apart, of a range of 2 (1 + w) - 2 r w."""
    r, w = 0.2, 0.5
    tips = [1.0, -1.0, 1.0, -1.0] + [0.15, 0.05] * 40 + [1.0, -1.0, 1.0]
    ways = [np.linspace(a, b, 100)[1:] for a, b in pairwise(tips)]
    x = np.concatenate([np.concatenate([way, np.full(300 * rests, way[-1])]) for way in ways])
    y = x + w * dehyst.PrandtlIshlinskii([r], [1.0]).simulate(x)
    fit = dehyst.identify(dehyst.Recording(input=x, output=y), "pi", train_fraction=1.0)
    assert fit.facts.width_percent == pytest.approx(100 * 2 * r * w / np.ptp(y), rel=0.05)
