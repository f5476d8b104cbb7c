"""The zoo of rigs: repeatable, loops of some width, references inside the range, scores that are what they say."""

import json
import sys
from dataclasses import replace

import numpy as np
import pytest

import dehyst
from places import ROOT

sys.path.insert(0, str(ROOT / "benchmarks"))

from zoo import checks, logs, references, scores
from zoo.compiled import NUMBA
from zoo.rigs import DESIGN, JUDGE, RIGS

# Without numba a rig of 10 kHz takes minutes; those that need few steps take a second.
needs_numba = pytest.mark.skipif(
    not NUMBA, reason="numba is not installed: pip install --group bench"
)
SIMPLE = RIGS["elastomer"]


def coarse(rig):
    """A rig sampled so rarely that its logs have some thousand rows."""
    return replace(rig, period=rig.stroke / 90)


def played(rig):
    """Output of two strokes over the range."""
    return rig.play(
        np.concatenate([np.linspace(rig.low, rig.high, 60), np.linspace(rig.high, rig.low, 60)])
    )


def test_rigs_that_choose_rules_and_rigs_that_judge_them_share_none():
    assert sorted([*DESIGN, *JUDGE]) == sorted(RIGS)
    assert abs(len(DESIGN) - len(JUDGE)) <= 1
    for group in (DESIGN, JUDGE):
        assert {RIGS[name].one_sided for name in group} == {True, False}


@pytest.mark.slow
def test_a_specimen_is_the_same_at_every_call_and_no_other_is_like_it():
    assert np.array_equal(played(SIMPLE), played(replace(SIMPLE)))
    assert not np.allclose(played(SIMPLE), played(replace(SIMPLE, seed=1)), rtol=1e-3)
    log, again = (logs.recording(replace(coarse(SIMPLE)), "routine") for _ in range(2))
    assert np.array_equal(log.output, again.output)


@pytest.mark.slow
def test_the_sensor_shows_noise_and_steps_that_the_truth_has_not():
    rig = coarse(RIGS["valve"])
    _, y = logs.true_log(rig, "routine")
    log = logs.recording(rig, "routine")
    steps = log.output / rig.quantum
    assert np.allclose(steps, np.round(steps))
    assert 0.5 * rig.noise < np.std(log.output - y) < 2.0 * rig.noise + rig.quantum


@pytest.mark.parametrize("kind", references.REFERENCES)
def test_references_begin_at_rest_and_stay_inside(kind):
    rig = coarse(SIMPLE)
    wanted, begin = references.reference(rig, kind)
    _, y = logs.true_log(rig, "usual")
    assert wanted[0] == rig.play(np.full(2, rig.rest))[0]
    shares = (wanted[begin:] - y.min()) / np.ptp(y)
    assert shares.min() >= 0.1 - 1e-9 and shares.max() <= 0.9 + 1e-9


def test_a_file_holds_families_until_the_rig_changes_and_auto_is_made_anew(tmp_path, monkeypatch):
    asked = []

    def fake(rig, length, family):
        asked.append(family)
        tracking = {"static": 2.0, "pi": 1.0, "auto": 1.5}[family]
        return {
            "family": family, "test_percent": tracking, "predicted": 1.4,
            "references": {kind: {"tracking": tracking} for kind in references.REFERENCES},
        }  # fmt: skip

    monkeypatch.setattr(scores, "score", fake)
    rig = coarse(SIMPLE)
    scores.scored(rig, "routine", ("static", "pi"), tmp_path)
    again = scores.scored(rig, "routine", ("static", "pi"), tmp_path)
    assert asked == ["static", "pi", "auto", "auto"]
    assert not again["stale"]
    monkeypatch.setattr(scores, "sources", lambda: "others")
    assert scores.scored(rig, "routine", (), tmp_path, auto=False)["stale"]
    row = scores.rows(again)[0]
    assert (row["best"], row["over_best"], row["over_curve"]) == ("pi", 1.5, 0.75)
    figures = scores.summary([again])
    assert figures["predicted"]["within_1_5"] == 1.0
    assert figures["over_best"]["worst"] == 1.5
    assert {name: row["mean"] for name, row in scores.by_family([again]).items()} == {
        "pi": 1.0, "auto": 1.5, "static": 2.0,
    }  # fmt: skip
    scores.scored(replace(rig, noise=2 * rig.noise), "routine", ("pi",), tmp_path, auto=False)
    assert asked[4:] == ["pi", "auto"]
    assert set(json.loads(next(tmp_path.glob("*.json")).read_text())["routine"]["entries"]) == {
        "pi",
        "auto",
    }


@needs_numba
@pytest.mark.slow
@pytest.mark.parametrize("name", RIGS)
def test_a_rig_is_fit_for_the_zoo(name, capsys):
    assert checks.checked(RIGS[name]), capsys.readouterr().out


@needs_numba
@pytest.mark.slow
def test_no_two_rigs_have_the_same_loop():
    grid = np.linspace(0.0, 1.0, 40)
    shapes = []
    for rig in RIGS.values():
        down, falling, up, rising = checks.loop(rig)
        low, span = rising.min(), np.ptp(rising)
        shape = []
        for u, y in ((up, rising), (down[::-1], falling[::-1])):
            shape.append((np.interp(grid, (u - rig.low) / (rig.high - rig.low), y) - low) / span)
        shapes.append(np.concatenate(shape))
    for k, shape in enumerate(shapes):
        for other in shapes[:k]:
            assert np.max(np.abs(shape - other)) > 0.01


@needs_numba
@pytest.mark.slow
@pytest.mark.parametrize("name", RIGS)
def test_no_rig_is_a_sum_of_elements(name):
    """Fitted without noise, the largest sum leaves more than twice what the sensor's noise would."""
    rig = RIGS[name]
    u, y = logs.true_log(rig, "routine")
    every = max(1, u.size // 6_000)
    log = dehyst.Recording(
        input=u[::every], output=y[::every], time=rig.period * np.arange(u.size)[::every]
    )
    fit = dehyst.identify(log, "full-sum", train_fraction=1.0)
    assert fit.train.rmse_percent > 2.0 * 100.0 * rig.noise / np.ptp(y)


@needs_numba
@pytest.mark.slow
def test_a_compensator_tracks_better_than_a_curve():
    rig = RIGS["tendon"]
    scored = scores.scored(rig, "routine", ("static", "pi"))
    for row in scores.rows(scored):
        assert row["over_curve"] < 0.7
