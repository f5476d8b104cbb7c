"""One protocol: every model of every family is asked, run, stepped, saved and read in the same way."""

import pickle

import numpy as np
import pytest

import dehyst
from dehyst.errors import DehystError, ParameterError
from dehyst.families import example, names
from dehyst.families._elements import Element, ElementModel
from dehyst.models import DirectInverse, Model, ModelCard, Schedule, SignalCard

CARD = ModelCard(SignalCard("u", "bar", -4.0, 4.0), SignalCard("y", "deg", -3.0, 3.0))
PLAYS = dehyst.PrandtlIshlinskii([0.0, 0.2, 0.6], [1.0, 0.0, 0.4], card=CARD)
DIRECT = DirectInverse(
    radii=[0.3],
    stop_weights=[[0.5], [0.7]],
    time_constants=[2.0],
    creep_weights=[[0.2], [0.2]],
    polynomial=[[0.0, 1.0], [0.0, 1.2]],
    schedules=(Schedule("load", 0.0, 1.0, "N"),),
    card=CARD,
)
MODELS = {
    "pi": PLAYS,
    "modified-pi": dehyst.ModifiedPrandtlIshlinskii(
        PLAYS, after_map=dehyst.MonotoneMap([-2.0, 0.0, 2.0], [-2.0, 0.0, 3.0])
    ),
    "stop": dehyst.StopOperatorModel([0.0, 0.5, 0.9], [0.0, 2.0, 0.0], slope=1.0, card=CARD),
    "sheared-pi": dehyst.models.ShearedPrandtlIshlinskii(PLAYS, shear=0.1),
    "static": dehyst.models.StaticCurve(dehyst.MonotoneMap([-2.0, 2.0], [-3.0, 3.0])),
    "direct-inverse": DIRECT,
    **{name: example(name) for name in names()},
}
X = np.sin(np.linspace(0.0, 12.0, 240)) * np.linspace(0.9, 0.5, 240)
T = 0.05 * np.arange(240)


def context(model, size=240):
    return {name: np.linspace(0.0, 1.0, size) for name in model.needs}


def gaps(model, steps, x):
    """Answers of a stepper, period by period."""
    held = context(model)
    return [
        steps(float(value), 0.05 if k else 0.0, **{name: float(held[name][k]) for name in held})
        for k, value in enumerate(x)
    ]


@pytest.mark.parametrize("name", MODELS)
def test_every_model_says_what_it_is_and_what_it_needs(name):
    model = MODELS[name]
    assert (
        isinstance(model, Model)
        and model.family == name
        and model.direction in ("forward", "inverse")
    )
    assert isinstance(model.rate_dependent, bool) and isinstance(model.nonzero_weights, int)
    assert model.needs == tuple(card.name for card in model.context)
    assert (
        isinstance(model.no_inverse, str)
        and isinstance(model.no_forward, str)
        and model.ends[0] < model.ends[1]
    )
    if model.rate_dependent:
        with pytest.raises(DehystError, match="time"):
            model.simulate(X, **context(model))
    with pytest.raises(ParameterError, match="takes no 'wind'"):
        model.simulate(X, T, wind=1.0, **context(model))


@pytest.mark.parametrize("name", MODELS)
def test_the_inverse_of_every_model_gives_its_input_back_and_has_the_signals_exchanged(name):
    model = MODELS[name].with_card(CARD)
    if model.no_inverse:
        with pytest.raises(DehystError):
            model.inverse()
        return
    inverse = model.inverse()
    assert inverse.card.input == model.card.output and inverse.card.output == model.card.input
    assert inverse.rate_dependent == model.rate_dependent and inverse.needs == model.needs
    y = model.simulate(X, T, **context(model))
    miss = np.abs(inverse.simulate(y, T, **context(model)) - X).max()
    assert miss < (1e-2 if name == "direct-inverse" else 1e-6) * np.ptp(
        X
    )  # whose search begins on a grid
    again = inverse.inverse().card
    assert (again.input, again.output) == (CARD.input, CARD.output)


@pytest.mark.parametrize("name", MODELS)
def test_a_step_is_called_alike_and_gives_what_a_signal_gives(name):
    for model in (MODELS[name], *([] if MODELS[name].no_inverse else [MODELS[name].inverse()])):
        if name == "direct-inverse" and model is MODELS[name]:
            with pytest.raises(ParameterError, match=r"inverse\(\)\.stepper"):
                model.stepper()
            continue
        found = np.array(gaps(model, model.stepper(), X))
        wanted = model.simulate(X, T, **context(model))
        if (
            name == "direct-inverse"
        ):  # the signal's rates are central, here there are none: no viscous term
            assert not DIRECT.viscous.any()
        np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-11 * np.abs(wanted).max())


@pytest.mark.parametrize("name", MODELS)
def test_a_stepper_is_told_its_period_once_or_says_that_it_needs_one(name):
    model = MODELS[name].inverse() if name == "direct-inverse" else MODELS[name]
    held = {name: float(values[0]) for name, values in context(model).items()}
    told, each, untold = model.stepper(0.05), model.stepper(), model.stepper()
    for k, value in enumerate(X[:40].tolist()):
        assert told(value, **held) == each(value, 0.05 if k else 0.0, **held)
    untold(0.0, **held)  # nothing has passed before the first sample
    if model.rate_dependent and not model.period:
        with pytest.raises(ParameterError, match="depends on time"):
            untold(0.1, **held)
    else:
        assert np.isfinite(untold(0.1, **held))


@pytest.mark.parametrize("name", names())
def test_a_stepper_goes_on_from_its_image_and_refuses_those_of_others(name):
    step = MODELS[name].stepper(0.05)
    first = step.save()
    for value in X[:50].tolist():
        step(value)
    image = step.save()
    ahead = [step(value) for value in X[50:90].tolist()]
    step.restore(image)
    assert [step(value) for value in X[50:90].tolist()] == ahead
    sizes = () if MODELS[name].memory_grows else (image[:-1], [*image, 0.0])
    for wrong in (*sizes, image[:2], np.full(image.size, np.nan), 3.0):
        with pytest.raises(ParameterError, match="none of this"):
            step.restore(wrong)
    step.restore(first)
    assert step(X[0]) == MODELS[name].stepper(0.05)(X[0])


def test_time_in_the_place_of_the_switch_is_refused():
    made = dehyst.block(PLAYS, range=(-2.0, 2.0))
    with pytest.raises(ParameterError, match="takes no time stamps"):
        made.run(X, T)
    assert np.array_equal(
        made.run(X, np.ones(X.size))[0], dehyst.block(PLAYS, range=(-2.0, 2.0)).run(X, True)[0]
    )


@pytest.mark.slow
def test_settings_that_are_the_usual_ones_change_nothing():
    x, y = X, PLAYS.simulate(X) + 0.01 * np.cos(np.arange(240))
    rec = dehyst.Recording(input=x, output=y, time=T)
    chosen = dehyst.identify(rec).family
    for usual in ({"n": 100}, {"eps": "auto"}, {"initial_state": "auto"}, {"thresholds": None}):
        assert dehyst.identify(rec, **usual).family == chosen


@pytest.mark.parametrize("seconds", [0.0, -1.0, float("nan"), "fast"])
def test_a_period_that_is_none_is_refused(seconds):
    with pytest.raises(ParameterError, match=r"period|number"):
        example("creep-pi").stepper(seconds)


@pytest.mark.parametrize("name", MODELS)
def test_one_call_makes_the_block_of_every_model_that_a_target_can_run(name):
    model = MODELS[name].with_card(CARD)
    if not model.core or (model.no_inverse and name != "direct-inverse"):
        with pytest.raises(DehystError):
            dehyst.block(model)
        return
    made = dehyst.block(model, period=0.05, range=(-2.0, 2.0), ramp=20)
    held = {"given": dict.fromkeys(made.given, 0.5)} if made.given else {}
    answers = [made.step(y, **held) for y in (0.0, 0.5, 99.0, float("nan"))]
    assert np.isfinite(answers).all() and max(np.abs(answers)) <= 2.0 and answers[3] == answers[2]
    if model.core == "direct" or (model.core == "elements" and model.timed and not model.period):
        with pytest.raises(ParameterError, match="period"):
            dehyst.block(model)


def test_what_no_target_can_run_says_which_model_can():
    with pytest.raises(ParameterError, match="dehyst identify"):
        dehyst.block(example("bouc-wen"))
    with pytest.raises(ParameterError, match=r"fit\.model"):
        dehyst.block(42)


@pytest.mark.parametrize("name", MODELS)
def test_every_file_is_read_by_one_loader(name, tmp_path):
    model = MODELS[name].with_card(CARD)
    again = dehyst.load(model.save(tmp_path / "m.json"))
    assert type(again) is type(model) and again.card == CARD
    signals = context(model)
    assert again.simulate(X, T, **signals).tobytes() == model.simulate(X, T, **signals).tobytes()
    if not model.no_inverse and model.inverse().file_kind != model.file_kind:
        with pytest.raises(DehystError):
            model.inverse().save(tmp_path / "i.json")


@pytest.mark.parametrize("name", MODELS)
def test_pruning_changes_nothing_that_is_answered(name):
    model = MODELS[name]
    pruned = model.pruned()
    assert type(pruned) is type(model) and pruned.nonzero_weights == model.nonzero_weights
    wanted = model.simulate(X, T, **context(model))
    np.testing.assert_allclose(
        pruned.simulate(X, T, **context(model)), wanted, rtol=0, atol=1e-13 * np.abs(wanted).max()
    )


@pytest.mark.parametrize("name", MODELS)
def test_a_band_holds_every_past_where_memory_is_bounded(name):
    model = MODELS[name]
    for each in both_ways(model):
        if not each.bounded:
            continue
        band = each.band(X, T, **context(each))
        slack = 1e-12 * max(1.0, np.abs(band.high).max())
        rested = each.at_rest(float(X[0])).simulate(X, T, **context(each))
        assert np.all(band.low <= rested + slack) and np.all(rested <= band.high + slack)
        assert np.all(np.abs(band.middle - 0.5 * (band.low + band.high)) <= slack)
        assert np.all((band.certainty >= 0.0) & (band.certainty <= 1.0))


@pytest.mark.parametrize("name", MODELS)
def test_a_band_holds_the_usual_pasts_where_memory_is_not_bounded(name):
    model = MODELS[name]
    for each in both_ways(model):
        if each.bounded:
            continue
        with pytest.raises(ParameterError, match="--start"):
            each.band(X, T, (-1.0, 1.0), **context(each))
        answers = [each.at_rest(float(X[0])).simulate(X, T, **context(each))]
        for rising in (False, True):
            begun = each.after_strokes(float(X[0]), rising)
            answers.append(begun.simulate(X, T, **context(each)))
        band = each.band(X, T, **context(each))
        np.testing.assert_array_equal(band.low, np.min(answers, axis=0))
        np.testing.assert_array_equal(band.high, np.max(answers, axis=0))
        assert np.all(np.diff(band.certainty) >= 0.0) and np.all(band.certainty <= 1.0)


def both_ways(model):
    """A model, and its inverse if it has one."""
    return (model,) if model.no_inverse else (model, model.inverse())


def test_zero_weights_of_a_sum_go_and_a_used_one_can_be_pickled():
    model = ElementModel(
        (Element("input", weight=0.5), Element("play", 0.2, weight=0.0), Element("play", 0.3))
    )
    assert len(model.pruned().elements) == 2 and model.nonzero_weights == 2
    y = model.simulate(X)
    assert pickle.loads(pickle.dumps(model)).simulate(X).tobytes() == y.tobytes()
    assert (
        ElementModel((Element("play", 0.2, weight=0.0),)).pruned().elements
    )  # a sum is never empty


def test_a_sum_that_is_scheduled_takes_its_signals_by_name():
    model = ElementModel((Element("input", schedule=1), Element("input", weight=2.0, schedule=2)),
                         schedules=((0, 0.0, 1.0),))  # fmt: skip
    assert model.needs == ("signal_0",)
    np.testing.assert_allclose(model.simulate(X, signal_0=0.25), 1.25 * X, atol=1e-12)
    assert model.stepper()(0.5, signal_0=1.0) == pytest.approx(1.0)
