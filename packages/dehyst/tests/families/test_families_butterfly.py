"""Butterfly loops: they are seen, a turning map behind plays follows them, a wing has an exact inverse."""

import dataclasses
import json
import runpy

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import dehyst
from dehyst.errors import DehystError, IdentificationError, InvertibilityError, ParameterError
from dehyst.families import example
from dehyst.families.kit import ElementModel, butterfly_in
from dehyst.findings import Grade
from dehyst.io import write_csv
from generated_logs import generated
from peculiar_logs import KINDS
from peculiar_logs import logs as peculiar
from places import ROOT

WINGS = ("upper", "lower")
TIME = 0.01 * np.arange(1600)
SIZE = np.interp(TIME % 8.0, [0.0, 3.0, 8.0], [1.0, 1.0, 0.35])
FIELD = SIZE * np.sin(2.0 * np.pi * TIME)


def played(x, radii, weights):
    """Sum of plays from rest, by their definition."""
    total = np.zeros(x.size)
    for r, w in zip(radii, weights, strict=True):
        z = 0.0
        for k, value in enumerate(x.tolist()):
            z = max(value - r, min(value + r, z))
            total[k] += w * z
    return total


def butterfly_log(
    shape=np.square, radii=(0.1, 0.3, 0.5), weights=(0.3, 0.5, 0.3), noise=0.002, seed=0
):
    """A log of a map behind plays, which no line of the fit shares."""
    y = shape(played(FIELD, radii, weights) + 0.1 * FIELD)
    y = y + np.random.default_rng(seed).normal(0.0, noise * np.ptp(y), y.size)
    return dehyst.Recording(FIELD, y, TIME, input_name="field", output_name="strain")


@pytest.fixture(scope="module")
def fitted():
    return dehyst.identify(butterfly_log(lambda z: z**2 + 0.1 * z))


@pytest.mark.slow
def test_auto_takes_a_butterfly_and_says_so(fitted):
    assert fitted.family == "butterfly" and fitted.grade == Grade.CARE
    codes = [finding.code for finding in fitted.warnings]
    assert "butterfly-loop" in codes and "mixed-loop" not in codes
    assert fitted.facts.loop_words.startswith("butterfly loop")
    up, down = fitted.facts.butterfly
    assert up > 0.1 and down < -0.1
    # What auto would have taken stands in the table, and errs ten times as much.
    assert fitted.table[1].test_percent > 10.0 * fitted.output_error.rmse_percent


@pytest.mark.slow
@settings(max_examples=6, deadline=None)
@given(
    st.floats(0.15, 0.4),
    st.floats(0.2, 0.8),
    st.floats(-0.25, 0.25),
    st.sampled_from([1.0, -1.0]),
    st.integers(0, 9),
)
def test_the_loop_of_a_generated_butterfly_is_found_again(radius, share, tilt, sign, seed):
    log = butterfly_log(
        lambda z: sign * (z**2 + tilt * z),
        (0.5 * radius, 2.0 * radius),
        (share, 1.0 - share),
        seed=seed,
    )
    fit = dehyst.identify(log, "butterfly")
    assert fit.output_error.rmse_percent < 1.0
    # The turn of the map is that of z^2 + tilt z; noise is 0.2 % of range.
    turn = sign * -0.25 * tilt**2
    model = fit.model
    bottom = float(model.scaling.outward(np.array(model.after_map[1][model.turn])))
    assert abs(bottom - turn) < 0.02 * np.ptp(log.output)


def test_behind_an_even_map_a_mirrored_field_gives_the_same_output():
    model = example("butterfly")
    x = 0.9 * FIELD[:400]
    np.testing.assert_allclose(model.simulate(-x), model.simulate(x), rtol=0.0, atol=1e-15)


@settings(max_examples=25, deadline=None)
@given(
    st.sampled_from(WINGS),
    st.sampled_from([1.0, -1.0]),
    st.lists(st.floats(0.01, 1.4), min_size=2, max_size=30),
)
def test_on_a_wing_model_and_inverse_undo_each_other(side, sign, squares):
    model = dataclasses.replace(
        example("butterfly"), scaling=dehyst.families.Scaling(1.0, 2.0, 3.0, 5.0 * sign)
    )
    wing = model.wing(side)
    y = 3.0 + 5.0 * sign * np.array(squares)
    x = wing.inverse().simulate(y)
    assert np.max(np.abs(wing.simulate(x) - y)) < 1e-12 * 5.0
    # After the same poling the butterfly itself gives these outputs for these inputs.
    poled = model.after_strokes(x[0], side == "lower")
    assert np.max(np.abs(poled.simulate(x) - y)) < 1e-12 * 5.0


@pytest.mark.parametrize("side", WINGS)
def test_beyond_the_turn_the_inverse_holds_the_input_of_the_turn(side):
    wing = example("butterfly").wing(side)
    at, beyond = wing.inverse().simulate([0.5, 0.0]), wing.inverse().simulate([0.5, -0.4])
    np.testing.assert_allclose(beyond, at, rtol=0.0, atol=1e-5)


@pytest.mark.slow
def test_a_wing_refuses_outputs_beyond_its_turn_with_the_numbers(fitted):
    wing = fitted.model.wing("upper")
    low, high = wing.card.output.low, wing.card.output.high
    fitted.model.wing("upper", [low, high])
    with pytest.raises(
        ParameterError, match=r"1 of 2 wanted outputs .* turns at .* Move the reference by"
    ) as fault:
        fitted.model.wing("upper", [low - 0.2, high])
    assert fault.value.facts["turn"] == pytest.approx(low)
    with pytest.raises(ParameterError, match="one of upper, lower"):
        fitted.model.wing("left")
    with pytest.raises(ParameterError, match="no wings"):
        example("play-sum").wing("upper")
    with pytest.raises(ParameterError, match="no wings"):
        dehyst.PrandtlIshlinskii([0.0], [1.0]).wing("upper")


@pytest.mark.slow
def test_over_both_wings_there_is_neither_inverse_nor_export_and_a_cure(fitted, tmp_path):
    with pytest.raises(InvertibilityError, match="--wing upper"):
        fitted.model.inverse()
    with pytest.raises(ParameterError, match=r'wing\("upper"\)'):
        dehyst.block(fitted.model)
    # The cure of the message.
    fitted.model.save(tmp_path / "model.json")
    dehyst.load(tmp_path / "model.json").wing("upper").save(tmp_path / "upper.json")
    wing = dehyst.load(tmp_path / "upper.json")
    block = dehyst.block(wing)
    assert block.output.low == pytest.approx(FIELD.min(), abs=1e-9)


@pytest.mark.slow
def test_a_file_gives_the_model_back(fitted, tmp_path):
    fitted.model.save(tmp_path / "model.json")
    again = dehyst.load(tmp_path / "model.json")
    assert again.winged and again.turn == fitted.model.turn
    assert np.array_equal(again.simulate(FIELD, TIME), fitted.model.simulate(FIELD, TIME))
    step = again.stepper()
    assert [step(x) for x in FIELD[:50]] == fitted.model.simulate(FIELD[:50]).tolist()


@pytest.mark.parametrize(
    "values", [(1.0, 0.0, 1.0, 0.0), (1.0, 0.0, 0.0, 1.0), (2.0, 1.0, 0.5, 0.0)]
)
def test_a_map_that_stands_still_falls_or_turns_twice_is_refused(values):
    with pytest.raises(ParameterError, match="after_map"):
        ElementModel(after_map=((0.0, 1.0, 2.0, 3.0), values))
    with pytest.raises(ParameterError, match="after_map"):
        ElementModel(after_map=((0.0, 1.0, 2.0), (1.0, 0.0, 1.0)), direction="inverse")


NO_BUTTERFLIES = {
    "a rising loop": lambda z: z,
    "one wing": lambda z: (z + 1.5) ** 2,
    "a bend that hardly turns": lambda z: (z + 0.75) ** 2,
    "three turns": lambda z: np.sin(7.0 * z),
}


@pytest.mark.parametrize("shape", NO_BUTTERFLIES.values(), ids=NO_BUTTERFLIES)
def test_what_is_no_butterfly_is_not_taken_for_one(shape):
    log = butterfly_log(shape)
    with pytest.raises(IdentificationError, match="no butterfly"):
        dehyst.identify(log, "butterfly")


def test_half_a_butterfly_a_peak_on_one_way_alone_and_a_rest_are_none():
    x = np.sin(np.linspace(0.0, 20.0, 2000))
    z = np.sin(np.linspace(0.0, 20.0, 2000) - 0.3)
    assert butterfly_in([(x, 2.0 * z**2 - 1.0)]) is not None
    assert butterfly_in([(x, 1.0 - 2.0 * z**2)]).valley is False
    # One stroke up, one down: nothing repeats.
    assert butterfly_in([(x[:470], 2.0 * z[:470] ** 2 - 1.0)]) is None
    # A unipolar drive stays on a wing.
    assert butterfly_in([(x, 2.0 * (0.5 + 0.5 * z) ** 2 - 1.0)]) is None
    # A damper has a peak on one way, a valley on the other.
    assert butterfly_in([(x, np.cos(np.linspace(0.0, 20.0, 2000)))]) is None
    assert butterfly_in([(x, np.zeros(2000))]) is None
    assert butterfly_in([(np.zeros(2000), z)]) is None
    # The turn on the way up comes first: the output leads.
    early = np.sin(np.linspace(0.0, 20.0, 2000) + 0.3)
    assert butterfly_in([(x, 2.0 * early**2 - 1.0)]) is None


@pytest.mark.parametrize("output", [np.zeros(1600), FIELD], ids=["constant", "line"])
def test_other_logs_are_refused_with_an_error_of_dehyst(output):
    with pytest.raises(DehystError):
        dehyst.identify(dehyst.Recording(FIELD, output, TIME), "butterfly")


def first_halves(records):
    """Input and output of the fitted part of a log, scaled as a fit does."""
    ranges = []
    for name in ("input", "output"):
        values = np.concatenate([getattr(record, name) for record in records])
        ranges.append((0.5 * (values.max() + values.min()), 0.5 * np.ptp(values)))
    (center, half_range), (level, amplitude) = ranges
    halves = []
    for record in records:
        part = slice(0, len(record) // 2)
        x = np.ascontiguousarray((record.input[part] - center) / half_range)
        halves.append((x, (record.output[part] - level) / amplitude))
    return halves


@pytest.mark.parametrize("seed", range(6))
def test_no_generated_rig_is_taken_for_a_butterfly(seed):
    assert butterfly_in(first_halves(generated(seed).recordings())) is None


@pytest.mark.parametrize("kind", KINDS)
def test_no_peculiar_rig_is_taken_for_a_butterfly(kind):
    made = peculiar(kind, 0)
    records = list(made) if isinstance(made, list | tuple) else [made]
    assert butterfly_in(first_halves(records)) is None


def test_the_numbers_of_a_butterfly_are_its_wings_and_where_it_turns():
    x = np.sin(np.linspace(0.0, 20.0, 4000))
    z = np.sin(np.linspace(0.0, 20.0, 4000) - 0.3)
    loops = dehyst.data.measure_loops(dehyst.Recording(x, z**2))
    loop = loops.largest[0]
    assert loop.orientation == "butterfly" and np.isnan(loop.width_input)
    # z = 0 where x = sin(0.3); both wings are alike, and their areas cancel.
    assert loop.coercivity == pytest.approx(np.sin(0.3), rel=5e-3)
    lags, leads = loop.wings
    # By the definition: the branches apart, over the input, where the falling one is above.
    t = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 20001)
    up, down = np.sin(t - 0.3) ** 2, np.sin(t + 0.3) ** 2
    apart = np.maximum(down - up, 0.0)
    wanted = np.trapezoid(apart, np.sin(t))
    assert lags == pytest.approx(wanted, rel=0.02) and leads == pytest.approx(wanted, rel=0.02)
    assert loop.area < 0.01 * wanted
    assert "clockwise wing" in loops.wing_words and json.dumps(loops.as_dict())


@pytest.mark.parametrize(("side", "rising"), [("upper", False), ("lower", True)])
def test_the_inverse_of_a_wing_begins_poled_from_the_end_of_that_wing(side, rising):
    model = example("butterfly")
    end = {"upper": 1.0, "lower": -1.0}[side] * np.max(np.abs(model.ends))
    wing = model.wing(side)
    wanted = wing.simulate(end * np.array([0.9, 0.6, 0.8, 0.55, 0.95]))
    demand = wing.inverse().simulate(wanted)
    # The whole model, after strokes over its range, the last one from that end.
    answer = model.after_strokes(demand[0], rising).simulate(demand)
    assert np.max(np.abs(answer - wanted)) < 1e-12 * np.ptp(wanted)


@pytest.mark.slow
@pytest.mark.parametrize("curve", [np.abs, np.square, lambda x: np.cos(1.3 * (x - 0.2))])
def test_a_curve_that_turns_without_a_loop_is_followed_and_is_called_no_loop(curve):
    x = np.interp(
        np.arange(6000), np.arange(0, 6001, 500), [0, 2, -2, 2, -2, 1, -1.5, 2, -2, 0.5, 2, -2, 2]
    )
    y = curve(0.5 * x)
    y = y + 2e-3 * np.ptp(y) * np.random.default_rng(1).standard_normal(x.size)
    fit = dehyst.identify(dehyst.Recording(x, y))
    assert fit.test.rmse_percent < 1.0 < 0.1 * fit.static_test.rmse_percent
    finding = next(f for f in fit.warnings if f.code == "butterfly-loop")
    assert "without a loop" in finding.message and fit.facts.loop_words.startswith("no loop")


def test_evaluate_of_a_butterfly_names_the_wing_and_is_no_refusal():
    model = example("butterfly")
    x = 0.5 * np.sum(model.ends) + 0.5 * np.ptp(model.ends) * np.sin(np.linspace(0.0, 20.0, 2000))
    evaluation = dehyst.evaluate({"m": model}, dehyst.Recording(x, model.simulate(x)))
    assert evaluation.run == "m" and "on one wing" in evaluation.why


@pytest.mark.slow
def test_the_actuator_of_the_examples_follows_on_one_wing(tmp_path, run, monkeypatch):
    monkeypatch.chdir(tmp_path)
    rig = runpy.run_path(str(ROOT / "examples" / "simulators" / "butterfly.py"))
    time, field = rig["drive"]()
    write_csv(
        "log.csv",
        {"time [s]": time, "field [kV/mm]": field, "strain [%]": rig["ferroelectric"](field)},
    )
    wanted = 0.1 + 0.025 * np.sin(time[:800])
    write_csv("wanted.csv", {"time [s]": time[:800], "strain [%]": wanted})
    assert (
        run("identify", "log.csv", "--input", "field", "--output", "strain", "--save", "m.json")[0]
        == 0
    )
    status, _, error = run("compensate", "m.json", "wanted.csv", "--out", "c.csv")
    assert status != 0 and "--wing upper" in error
    line = ("compensate", "m.json", "wanted.csv", "--out", "c.csv")
    assert run(*line, "--wing", "upper")[0] == 0
    demand = np.genfromtxt("c.csv", delimiter=",", names=True)["compensated_field_kVmm"]
    # The same from a log of the poling, in place of its name.
    poling = 2.0 * np.sin(np.linspace(0.0, 2.5 * np.pi, 300))
    came = np.append(poling, np.linspace(2.0, demand[0], 30))
    before = {
        "time [s]": time[:330],
        "field [kV/mm]": came,
        "strain [%]": rig["ferroelectric"](came),
    }
    write_csv("before.csv", before)
    line = ("compensate", "m.json", "wanted.csv", "--after", "before.csv", "--out", "d.csv")
    assert run(*line, "--wing", "upper")[0] == 0
    same = np.genfromtxt("d.csv", delimiter=",", names=True)["compensated_field_kVmm"]
    assert np.max(np.abs(same - demand)) < 0.1
    strain = rig["ferroelectric"](np.concatenate([poling, demand]))[300:]
    assert np.sqrt(np.mean((strain - wanted) ** 2)) < 0.03 * np.ptp(rig["ferroelectric"](field))
