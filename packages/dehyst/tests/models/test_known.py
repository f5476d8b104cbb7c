"""A past that is known: the memory that agrees with samples of input and output."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import dehyst
from dehyst.errors import ParameterError
from dehyst.families import example
from dehyst.models import ModelCard, SignalCard
from dehyst.models.kit import known_past

CARD = ModelCard(SignalCard("u", low=-1.0, high=1.0), SignalCard("y", low=-1.0, high=1.0))
PLAYS = dehyst.PrandtlIshlinskii(np.linspace(0.0, 0.9, 10), np.full(10, 0.1), card=CARD)
STEP, KNOWN = 0.01, 150


def motion(seed, count=30, size=1.0):
    """Random strokes, a sample every fortieth of the range."""
    tips = np.concatenate([[0.0], size * np.random.default_rng(seed).uniform(-1.0, 1.0, count)])
    parts = []
    for k in range(count):
        samples = max(3, int(40 * abs(tips[k + 1] - tips[k]) / size))
        parts.append(np.linspace(tips[k], tips[k + 1], samples, endpoint=False))
    return np.concatenate(parts)


def continued(model, seed, known=KNOWN):
    """Errors of what follows: of the model that knows the samples before, and of the one as it was saved."""
    x = motion(seed, size=model.ends[1])
    clock = STEP * np.arange(x.size)
    begin = int(np.random.default_rng(seed).integers(200, x.size - 2 * known))
    past, rest = slice(begin, begin + known), slice(begin + known, None)
    timed = model.rate_dependent
    y = model.simulate(x, clock if timed else None)
    begun = model.after(x[past], y[past], clock[past] if timed else None)
    errors = []
    for each in (begun, model):
        answer = each.simulate(x[rest], clock[rest] if timed else None)
        errors.append(float(np.sqrt(np.mean((answer - y[rest]) ** 2)) / np.ptp(y)))
    return errors


@pytest.mark.slow
def test_150_samples_of_a_sum_of_plays_are_enough_to_run_on_exactly():
    errors = np.array([continued(PLAYS, seed) for seed in range(20)])
    assert np.median(errors[:, 0]) < 1e-9
    assert np.mean(errors[:, 0]) < 0.1 * np.mean(errors[:, 1])


@pytest.mark.parametrize(
    ("name", "median"),
    [
        ("play-sum", 1e-9), ("dahl", 1e-7), ("preisach", 1e-6), ("bouc-wen", 1e-6), ("duhem", 1e-6),
        ("creep-pi", 5e-3),
        pytest.param("full-sum", 1e-3, marks=pytest.mark.slow),
        pytest.param("inverse-stop-rate", 2e-3, marks=pytest.mark.slow),
    ],
)  # fmt: skip
def test_every_family_runs_on_nearer_than_from_its_own_start(name, median):
    errors = np.array([continued(example(name), seed) for seed in range(5)])
    assert np.median(errors[:, 0]) < median
    assert np.mean(errors[:, 0]) < 0.4 * np.mean(errors[:, 1])


def test_noise_of_the_known_samples_is_no_more_than_noise():
    x = motion(3)
    y = PLAYS.simulate(x)
    noisy = y + 0.01 * np.random.default_rng(0).standard_normal(x.size)
    known = known_past(PLAYS, x[300:450], noisy[300:450])
    assert 0.008 < known.error < 0.012
    assert np.max(np.abs(known.model.simulate(x[450:]) - y[450:])) < 0.02


def test_one_sample_gives_the_level_and_says_what_is_left_open():
    x = motion(5)
    y = PLAYS.simulate(x)
    known = known_past(PLAYS, x[400:401], y[400:401])
    assert known.error < 1e-9 and known.doubt > 0.01
    assert known.model.simulate(x[400:401])[0] == pytest.approx(y[400], abs=1e-9)
    assert known_past(PLAYS, x[200:600], y[200:600]).doubt < 1e-6


def test_an_input_alone_moves_the_memory():
    x = motion(7)
    whole = PLAYS.simulate(x)
    np.testing.assert_allclose(PLAYS.after(x[:300]).simulate(x[300:]), whole[300:], atol=1e-12)
    model = example("creep-pi")
    clock = STEP * np.arange(x.size)
    rest = model.after(x[:300], time=clock[:300]).simulate(x[300:], clock[300:])
    np.testing.assert_allclose(rest, model.simulate(x, clock)[300:], atol=5e-3)


def test_samples_without_an_output_only_move_the_memory():
    x = motion(9)
    y = PLAYS.simulate(x)
    partly = np.where(np.arange(150) < 100, y[300:450], np.nan)
    begun = PLAYS.after(x[300:450], partly)
    np.testing.assert_allclose(begun.simulate(x[450:]), y[450:], atol=5e-3)


def test_an_inverse_runs_on_after_its_own_signals():
    x = motion(11)
    y = PLAYS.simulate(x)
    begun = PLAYS.inverse().after(y[300:450], x[300:450])
    np.testing.assert_allclose(begun.simulate(y[450:]), x[450:], atol=1e-9)
    model = example("play-sum")
    y = model.simulate(x)
    begun = model.inverse().after(y[300:450], x[300:450])
    np.testing.assert_allclose(begun.simulate(y[450:]), x[450:], atol=1e-6)
    step = begun.stepper()
    np.testing.assert_allclose([step(value) for value in y[450:]], x[450:], atol=1e-6)


def test_a_model_that_runs_on_is_saved_with_its_memory(tmp_path):
    model = example("full-sum")
    x = motion(13)
    clock = STEP * np.arange(x.size)
    begun = model.after(x[:200], model.simulate(x, clock)[:200], clock[:200])
    loaded = dehyst.load(begun.save(tmp_path / "m.json"))
    assert loaded == begun
    np.testing.assert_array_equal(
        loaded.simulate(x[200:], clock[200:]), begun.simulate(x[200:], clock[200:])
    )
    with pytest.raises(ParameterError, match="memory of this full-sum model"):
        replace(begun, start=begun.start[:-1]).simulate(x, clock)


def test_known_samples_that_cannot_serve_are_refused_with_a_cure():
    timed = example("creep-pi")
    for model, arguments, words in (
        (PLAYS, ([0.0, 1.0], [0.0]), "one of each"),
        (PLAYS, ([0.0, np.nan], [0.0, 1.0]), "not finite"),
        (PLAYS, ([0.0, 1.0], [np.nan, np.nan]), "finite number"),
        (PLAYS, ([], []), "one of each"),
        (timed, ([0.0, 1.0], [0.0, 1.0]), "time stamps"),
        (timed, ([0.0, 1.0], [0.0, 1.0], [0.0]), "one of each"),
    ):
        with pytest.raises(ParameterError, match=words):
            model.after(*arguments)
    with pytest.raises(ParameterError, match="after\\(output, input\\)"):
        example("play-sum").inverse().after([0.0, 1.0])
    direct = dehyst.models.DirectInverse(radii=[0.5], stop_weights=[2.0], polynomial=[0.0, 1.0])
    with pytest.raises(ParameterError, match="of what was measured"):
        direct.after([0.0, 1.0], [0.0, 1.0])


@pytest.mark.slow
@given(seed=st.integers(0, 10_000), known=st.integers(1, 60))
@settings(max_examples=25, deadline=None)
def test_the_error_over_the_known_samples_is_never_that_of_the_model_as_it_was_saved(seed, known):
    x = motion(seed, 12)
    y = PLAYS.after_strokes(float(x[0]), seed % 2 == 0).simulate(x)
    window = slice(50, 50 + known)
    found = known_past(PLAYS, x[window], y[window])
    own = np.sqrt(np.mean((PLAYS.simulate(x[window]) - y[window]) ** 2))
    assert found.error <= own + 1e-9
    answer = found.model.after(x[50 + known : 51 + known]).simulate(x[51 + known :])
    assert np.isfinite(answer).all()


def test_the_commands_run_on_after_a_log(run, tmp_path):
    model = example("play-sum").with_card(
        ModelCard(SignalCard("drive", "V", -1.0, 1.0), SignalCard("stroke", "mm", -1.0, 1.0))
    )
    x = motion(15)
    y = model.simulate(x)
    table = np.column_stack([STEP * np.arange(x.size), x, y])
    for name, part in (("past", slice(200, 500)), ("next", slice(500, None))):
        np.savetxt(
            tmp_path / f"{name}.csv", table[part], delimiter=",", comments="",
            header="time_s,drive_V,stroke_mm", fmt="%.17g",
        )  # fmt: skip
    saved, out = model.save(tmp_path / "m.json"), tmp_path / "out.csv"
    after = ("--after", tmp_path / "past.csv", "--out", out, "--overwrite")
    status, text, err = run("simulate", saved, tmp_path / "next.csv", *after)
    assert status == 0, err
    assert "runs on after" in text + err
    np.testing.assert_allclose(dehyst.read_signal(out, "model_stroke").values, y[500:], atol=1e-6)
    status, _, err = run("compensate", saved, tmp_path / "next.csv", *after)
    assert status == 0, err
    asked = dehyst.read_signal(out, "compensated_drive").values
    np.testing.assert_allclose(asked, x[500:], atol=1e-5)
    status, _, err = run("simulate", saved, tmp_path / "next.csv", *after, "--start", "rest")
    assert status == 2 and "Leave one of them out" in err
