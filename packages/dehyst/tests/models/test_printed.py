"""What Python shows of models and fits: a few lines, never pages of arrays."""

import numpy as np

import dehyst
from dehyst import ModifiedPrandtlIshlinskii, MonotoneMap, PrandtlIshlinskii, StopOperatorModel
from dehyst.models import ModelCard, SignalCard, StaticCurve
from in_one import in_one

BEND = MonotoneMap([-2.0, 0.0, 2.0], [-1.0, 0.0, 3.0])
PLAY = PrandtlIshlinskii(np.linspace(0, 1, 100), np.r_[1.0, np.zeros(99)])
CARD = ModelCard(SignalCard("pressure", "bar", -4.0, 4.25), SignalCard("angle", "deg", -30.0, 31.0))
MODELS = {
    "pi": PLAY,
    "modified-pi": ModifiedPrandtlIshlinskii(PLAY, after_map=BEND),
    "stop": StopOperatorModel([0.0, 0.3], [0.0, 1.0], 0.5),
    "static": StaticCurve(BEND),
}


@in_one("family", MODELS)
def test_a_model_is_shown_as_one_line_with_its_signals(family):
    model = MODELS[family].with_card(CARD)
    line = repr(model)
    assert str(model) == line and "\n" not in line and len(line) < 160
    assert type(model).__name__ in line and repr(family) in line
    assert "pressure [bar] -4 to 4.25 -> angle [deg] -30 to 31" in line
    assert "angle [deg] -30 to 31 -> pressure [bar] -4 to 4.25" in repr(model.inverse())
    assert ("of" in line) == (family != "static")


def test_operators_are_counted():
    assert "1 of 100 operators, input -> output" in repr(PLAY)
    assert "2 of 2 operators" in repr(MODELS["stop"])


def test_names_that_cannot_be_printed_or_do_not_end_stay_one_line():
    line = repr(PLAY.with_card(ModelCard(SignalCard("a\nb\x1b[31m"), SignalCard("y" * 5000))))
    assert line.isprintable() and len(line) < 200


def test_a_fit_is_printed_as_its_verdict_and_a_few_lines():
    x = 2 * np.sin(np.linspace(0, 20, 400)) * np.linspace(1, 0.3, 400)
    y = PrandtlIshlinskii([0.0, 0.6], [1.0, 0.5]).simulate(x)
    fit = dehyst.identify(dehyst.Recording(input=x, output=y, output_unit="deg"), family="pi", n=20)
    lines = str(fit).splitlines()
    assert lines[0] == fit.verdict
    assert [line.partition(":")[0] for line in lines[1:]] == [
        "fitted",
        "held out",
        "model",
        "warnings",
    ]
    assert "deg" in lines[1] and repr(fit.model) in lines[3]
    for finding in fit.warnings:
        assert finding.code in lines[-1]
    assert "\n" not in repr(fit) and "held out" in repr(fit) and len(repr(fit)) < 160
    whole = dehyst.identify(
        dehyst.Recording(input=x, output=y), family="pi", n=20, train_fraction=1.0
    )
    assert "held out:" not in str(whole) and "rms fitted" in repr(whole)
