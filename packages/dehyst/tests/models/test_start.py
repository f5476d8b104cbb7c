"""How a model begins: one default for all that runs it, other pasts by name, and what is not known of it is said."""

from itertools import pairwise

import numpy as np
import pytest

import dehyst
from dehyst.families import example, names
from dehyst.io import example_recording, write_csv
from dehyst.models import DirectInverse, ModelCard, SignalCard
from dehyst.models._start import begun
from element_samples import element_model
from export_samples import mapped_model, play_model, stop_model

MODELS = {"play": play_model, "mapped": mapped_model, "stop": stop_model}
NOW = slice(700, 1000)


@pytest.fixture(scope="module")
def rig():
    """An actuator that is its model exactly, somewhere in the middle of its work."""
    x = 2.9 * np.sin(np.arange(1200) / 40) * np.cos(np.arange(1200) / 170) - 0.5
    return np.clip(x, -1.0, 2.0)


@pytest.fixture
def files(tmp_path, rig):
    """Return a function that writes model and wanted output of a kind, from the middle of the work on."""

    def of(kind):
        model = MODELS[kind]()
        y = model.simulate(rig)
        model.save(tmp_path / "m.json")
        write_csv(
            tmp_path / "now.csv",
            {"time_s": np.arange(300) / 50, "pressure_bar": rig[NOW], "angle_deg": y[NOW]},
        )
        return tmp_path / "m.json", tmp_path / "now.csv", model, y[NOW]

    return of


def answer(out):
    return np.loadtxt(out.splitlines()[1:], delimiter=",")[:, 2]


@pytest.mark.parametrize("kind", MODELS)
def test_each_start_is_what_it_says_and_is_said(run, files, kind):
    path, log, model, y = files(kind)
    inverse, card = model.inverse(), model.card.output
    low, high = inverse.interval(y, past=(card.low, card.high))
    expected = {
        "unknown": 0.5 * (low + high),
        "rest": inverse.at_rest(y[0]).simulate(y),
        "model": inverse.simulate(y),
    }
    for start, x in expected.items():
        status, out, err = run("compensate", path, log, "--start", start)
        assert status == 0
        assert err.startswith(f"start: {start}, ")
        np.testing.assert_allclose(answer(out), x, atol=1e-12)
    assert (
        answer(run("compensate", path, log)[1]).tolist()
        == answer(run("compensate", path, log, "--start", "model")[1]).tolist()
    )


@pytest.mark.parametrize("kind", MODELS)
def test_the_default_says_how_far_it_may_be_off_after_any_past_within_the_identified_range(
    run, files, kind
):
    path, log, model, y = files(kind)
    status, out, err = run("compensate", path, log)
    x, card = answer(out), model.card.output
    low, high = model.inverse().interval(y, past=(card.low, card.high))
    doubt = max(high[0] - x[0], x[0] - low[0])
    assert (
        status == 0 and f"off by {doubt:.3g}" in " ".join(err.split()) and "--start unknown" in err
    )


RUNNABLE = [*MODELS, "elements", "direct"]


def runnable(kind):
    """A model with a past of its own that a block can run, and a motion within what it can reach."""
    x = np.clip(1.6 * np.sin(np.arange(400) / 30.0) * np.linspace(0.4, 1.0, 400) + 0.4, -0.9, 1.9)
    if kind == "direct":
        card = ModelCard(SignalCard("p", "bar", -9.0, 9.0), SignalCard("q", "deg", -3.0, 3.0))
        return DirectInverse(
            radii=[0.1, 0.4], stop_weights=[1.0, 0.5], polynomial=[0.0, 2.0], card=card
        ), x
    model = element_model(start="rising", dead_time=0.0) if kind == "elements" else MODELS[kind]()
    return model, model.simulate(x, 0.02 * np.arange(x.size))


@pytest.mark.parametrize("kind", RUNNABLE)
def test_compensate_evaluate_and_the_block_begin_alike(run, tmp_path, kind):
    """Three ways to run one model: the file that `compensate` writes, the demand that is scored, and the block."""
    model, y = runnable(kind)
    time = 0.02 * np.arange(y.size)
    path = model.save(tmp_path / "m.json")
    write_csv(tmp_path / "r.csv", {"time_s": time, "q": y})
    written = answer(run("compensate", path, tmp_path / "r.csv", "--output", "q")[1])
    block = dehyst.block(model, period=0.02)
    if kind != "direct":  # whose block is told the rate
        np.testing.assert_allclose(block.run(y)[0], written, atol=1e-9)
    record = dehyst.Recording(input=written, output=y, time=time)
    np.testing.assert_allclose(
        dehyst.evaluate(model, record).entries[0].demands[0], written, atol=1e-12
    )


@pytest.mark.parametrize("name", names())
def test_every_family_begins_after_strokes_over_its_range_as_if_they_had_been_made(name):
    """The oracle makes the strokes. Lags that relax, and ends of an output, are another past: those only answer."""
    model = example(name)
    low, high = model.ends
    for start, turns in (("rising", (high, low)), ("falling", (low, high))):
        strokes = np.concatenate(
            [np.linspace(a, b, 300) for a, b in pairwise((0.5 * (low + high), *turns, 0.3))]
        )
        then = np.array([0.3, 0.5, 0.1, 0.3])
        time = 1e3 * np.arange(strokes.size + then.size, dtype=float)
        driven = model.at_rest(strokes[0]).simulate(np.concatenate([strokes, then]), time)[
            strokes.size :
        ]
        answered = begun(model, start, 0.3).simulate(then, time[: then.size])
        assert np.isfinite(answered).all()
        if not model.rate_dependent and not name.startswith("inverse"):
            assert np.max(np.abs(driven - answered)) < 0.05 * np.ptp(driven) + 0.02, start


@pytest.mark.parametrize("kind", MODELS)
def test_plays_begin_after_strokes_as_if_they_had_been_made(kind):
    model = MODELS[kind]()
    low, high = model.ends
    then = np.array([0.3, 0.5, -0.4, 0.3])
    for start, turns in (("rising", [high, low]), ("falling", [low, high])):
        driven = model.with_state(model.final_state([*turns, 0.3])).simulate(then)
        np.testing.assert_allclose(begun(model, start, 0.3).simulate(then), driven, atol=1e-12)


@pytest.mark.parametrize("kind", MODELS)
def test_the_middle_is_never_off_by_more_than_it_says_whatever_the_past(run, files, kind, rig):
    """From every moment of the work: the error of the first value against the input that was really applied."""
    _, _, model, _ = files(kind)
    y, inverse, card = model.simulate(rig), model.inverse(), model.card.output
    worst = {"unknown": 0.0, "model": 0.0}
    for k in range(100, 1100, 20):
        low, high = inverse.interval(
            y[k : k + 1], past=(min(card.low, y.min()), max(card.high, y.max()))
        )
        assert low[0] - 1e-9 <= rig[k] <= high[0] + 1e-9
        assert abs(0.5 * (low[0] + high[0]) - rig[k]) <= 0.5 * (high[0] - low[0]) + 1e-9
        worst["unknown"] = max(worst["unknown"], abs(0.5 * (low[0] + high[0]) - rig[k]))
        worst["model"] = max(worst["model"], abs(inverse.simulate(y[k : k + 1])[0] - rig[k]))
    assert worst["unknown"] < worst["model"]


def test_on_the_example_log_the_middle_halves_the_worst_error_at_the_first_sample():
    recording = example_recording()
    model = dehyst.identify(recording, "modified-pi").model
    inverse, card, x = model.inverse(), model.card.output, recording.input
    worst = {"unknown": 0.0, "model": 0.0}
    for k in range(1000, x.size - 10, 60):
        true = model.with_state(model.final_state(x[:k]))
        y = true.simulate(x[k : k + 1])
        low, high = inverse.interval(y, past=(card.low, card.high))
        for start, u in (("unknown", 0.5 * (low + high)), ("model", inverse.simulate(y))):
            worst[start] = max(worst[start], abs(float(true.simulate(u)[0] - y[0])))
    assert worst["unknown"] < 0.6 * worst["model"]


@pytest.mark.parametrize("kind", MODELS)
def test_simulate_begins_as_the_log_of_its_model_unless_told(run, files, kind):
    path, log, model, _ = files(kind)
    x = dehyst.read_signal(log, "pressure_bar").values
    expected = {"model": model.simulate(x), "rest": model.at_rest(x[0]).simulate(x)}
    low, high = model.interval(x, past=(-1.0, 2.0))
    expected["unknown"] = 0.5 * (low + high)
    for start, y in expected.items():
        _, out, err = run("simulate", path, log, "--start", start)
        assert err.startswith(f"start: {start}, ")
        np.testing.assert_allclose(answer(out), y, atol=1e-12)
    assert run("simulate", path, log)[2].startswith("start: model, ")


@pytest.mark.parametrize("kind", MODELS)
def test_a_model_at_rest_answers_as_one_that_was_led_there_by_nothing(kind):
    """Of a play at rest at v the operator's output is its total slope times v: the definition, not the code."""
    model = MODELS[kind]()
    for v in (-0.9, 0.0, 0.3, 1.7):
        start = model.at_rest(v)
        back, forth = start.simulate([v, v + 1e-6, v]), start.simulate([v, v - 1e-6, v])
        assert back[0] == forth[0] == pytest.approx(start.simulate([v])[0])
        assert back[1] > back[0] > forth[1] or kind == "falling"


def test_a_direct_inverse_begins_as_its_file_says_unless_told(run, tmp_path):
    card = ModelCard(SignalCard("p", "bar", -2.0, 2.0), SignalCard("q", "deg", -1.0, 3.0))
    model = DirectInverse(
        radii=[0.1, 0.4], stop_weights=[1.0, 0.5], polynomial=[0.0, 0.2], card=card
    )
    model.save(tmp_path / "d.json")
    t = np.arange(200) / 50
    q = 1.0 + np.sin(3 * t)
    write_csv(tmp_path / "r.csv", {"time_s": t, "q_deg": q})
    for start in (None, "model", "unknown", "rest", "rising", "falling"):
        _, out, err = run(
            "compensate",
            tmp_path / "d.json",
            tmp_path / "r.csv",
            *(("--start", start) if start else ()),
        )
        assert err.startswith(f"start: {start or 'model'}, ")
        past = model.past if start in (None, "model") else start
        np.testing.assert_allclose(answer(out), model.with_past(past).run(q, t).u, atol=1e-12)


STARTS = ("unknown", "rest", "rising", "falling", "model")


@pytest.mark.parametrize("kind", RUNNABLE)
@pytest.mark.parametrize("start", STARTS)
def test_every_start_is_taken_wherever_a_model_runs(run, tmp_path, kind, start):
    """What `evaluate` scores is what `simulate` and `compensate` write, from each past."""
    model, y = runnable(kind)
    time = 0.02 * np.arange(y.size)
    x = model.inverse().simulate(y, time)
    path = model.save(tmp_path / "m.json")
    names = [card.name for card in (model.card.input, model.card.output)]
    write_csv(tmp_path / "r.csv", {"time_s": time, names[0]: x, names[1]: y})
    scored = dehyst.evaluate(
        model, dehyst.Recording(input=x, output=y, time=time), start=start
    ).entries[0]
    for command, answered in (
        ("simulate", scored.predictions[0]), ("compensate", scored.demands[0])
    ):  # fmt: skip
        status, out, err = run(command, path, tmp_path / "r.csv", "--start", start)
        assert status == 0, err
        assert err.startswith(f"start: {start}, ")
        np.testing.assert_allclose(answer(out), answered, atol=1e-9)


@pytest.mark.parametrize("family", [name for name in names() if not example(name).no_inverse])
def test_a_sum_of_unknown_past_begins_in_the_middle_of_rest_and_strokes(run, tmp_path, family):
    model = example(family)
    model.save(tmp_path / "m.json")
    t = np.arange(300) / 100
    y = model.simulate(0.6 * np.sin(3 * t), t)
    write_csv(tmp_path / "r.csv", {"time_s": t, model.card.output.label: y})
    status, out, err = run("compensate", tmp_path / "m.json", tmp_path / "r.csv", "--start", "unknown")  # fmt: skip
    assert status == 0, err
    inverse = model.inverse()
    pasts = (inverse.at_rest(y[0]), inverse.after_strokes(y[0], True), inverse.after_strokes(y[0], False))  # fmt: skip
    answers = [begun.simulate(y, t) for begun in pasts]
    middle = 0.5 * (np.min(answers, axis=0) + np.max(answers, axis=0))
    np.testing.assert_allclose(answer(out), middle, atol=1e-9 * np.ptp(middle))
    assert "between an actuator at rest and strokes over the whole range" in " ".join(err.split())


@pytest.mark.parametrize(
    ("words", "cure"),
    [
        (("--start", "zero"), "there are: unknown, rest, rising, falling, model"),
        (("--start", "rest", "--unknown-state"), "Leave out --unknown-state or --start rest"),
        (("--start", "model", "--past", "-1", "1"), "Leave out --past or --start model"),
    ],
)
def test_starts_that_are_none_or_contradict_are_refused(run, files, words, cure):
    path, log, _, _ = files("play")
    status, _, err = run("compensate", path, log, *words)
    assert status == 2
    assert cure in " ".join(err.split())


def test_a_past_narrows_the_start_without_the_band(run, files):
    path, log, model, y = files("play")
    _, out, err = run("compensate", path, log, "--past", "-0.5", "0.5")
    low, high = model.inverse().interval(y, past=(-0.5, 0.5))
    np.testing.assert_allclose(answer(out), 0.5 * (low + high), atol=1e-12)
    assert "within -0.5 to 0.5 deg" in err
