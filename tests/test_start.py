"""What `simulate` and `compensate` assume of the actuator's past is chosen, said, and by default safe."""

import numpy as np
import pytest

import dehyst
from dehyst.io import write_csv
from dehyst.models import DirectInverse, ModelCard, SignalCard
from dehyst.robot.experiments import example_recording
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
        write_csv(tmp_path / "now.csv", {"time_s": np.arange(300) / 50, "pressure_bar": rig[NOW], "angle_deg": y[NOW]})
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
        == answer(run("compensate", path, log, "--start", "unknown")[1]).tolist()
    )


@pytest.mark.parametrize("kind", MODELS)
def test_the_default_is_never_off_by_more_than_it_says_whatever_the_past(run, files, kind, rig):
    """From every moment of the work: the error of the first value against the input that was really applied."""
    _, _, model, _ = files(kind)
    y, inverse, card = model.simulate(rig), model.inverse(), model.card.output
    worst = {"unknown": 0.0, "model": 0.0}
    for k in range(100, 1100, 20):
        low, high = inverse.interval(y[k : k + 1], past=(min(card.low, y.min()), max(card.high, y.max())))
        assert low[0] - 1e-9 <= rig[k] <= high[0] + 1e-9
        assert abs(0.5 * (low[0] + high[0]) - rig[k]) <= 0.5 * (high[0] - low[0]) + 1e-9
        worst["unknown"] = max(worst["unknown"], abs(0.5 * (low[0] + high[0]) - rig[k]))
        worst["model"] = max(worst["model"], abs(inverse.simulate(y[k : k + 1])[0] - rig[k]))
    assert worst["unknown"] < worst["model"]


def test_on_the_example_log_the_default_halves_the_worst_error_at_the_first_sample():
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


def test_a_direct_inverse_begins_with_any_past_unless_told(run, tmp_path):
    card = ModelCard(SignalCard("p", "bar", -2.0, 2.0), SignalCard("q", "deg", -1.0, 3.0))
    model = DirectInverse(radii=[0.1, 0.4], stop_weights=[1.0, 0.5], polynomial=[0.0, 0.2], card=card)
    model.save(tmp_path / "d.json")
    t = np.arange(200) / 50
    q = 1.0 + np.sin(3 * t)
    write_csv(tmp_path / "r.csv", {"time_s": t, "q_deg": q})
    for start, known in ((None, False), ("unknown", False), ("rest", True), ("model", True)):
        _, out, err = run("compensate", tmp_path / "d.json", tmp_path / "r.csv", *(("--start", start) if start else ()))
        assert err.startswith(f"start: {start or 'unknown'}, ")
        np.testing.assert_allclose(answer(out), model.with_known(known).run(q, t).u, atol=1e-12)


@pytest.mark.parametrize(
    ("words", "cure"),
    [
        (("--start", "zero"), "there are: unknown, rest, model"),
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
