"""Weights that go with another signal: a rig whose loop changes with its temperature, identified, inverted, run."""

import json
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import dehyst
from dehyst.errors import ExcitationError, ParameterError, RecordingError
from dehyst.export import export, subject_of, verify
from dehyst.families._columns import GROUPS, Pace, columns_of, shares
from dehyst.families._elements import ElementModel
from dehyst.report import write_report

PLAYS = dehyst.PrandtlIshlinskii(np.linspace(0.0, 0.6, 7), np.full(7, 0.15))
WIDE = dehyst.PrandtlIshlinskii([0.25], [1.0])
DT, LOW, HIGH = 0.01, 20.0, 80.0


def strokes(count, seed):
    """Random strokes between -1 and 1."""
    tips = np.concatenate([[0.0, 1.0, -1.0], np.random.default_rng(seed).uniform(-1, 1, count)])
    parts = []
    for begin, end in pairwise(tips):
        parts.append(np.linspace(begin, end, max(3, int(60 * abs(end - begin))), endpoint=False))
    return np.concatenate(parts)


def rig(x, temperature):
    """Gain, width and level go with the temperature, none of them as a model has it: along a curve."""
    xi = (temperature - LOW) / (HIGH - LOW)
    loop = x - WIDE.simulate(x)
    return (1.0 + 0.5 * xi**1.3) * PLAYS.simulate(x) + 0.4 * (1.0 - xi) * loop + 0.3 * xi


def log(seed, temperature=None, count=40, noise=0.002):
    """A log of the rig while its temperature sways, or at one temperature."""
    x = strokes(count, seed)
    t = DT * np.arange(x.size)
    T = 50.0 + 30.0 * np.sin(2.0 * np.pi * t / 5.0 + seed)
    if temperature is not None:
        T = np.full(x.size, float(temperature))
    y = rig(x, T) + noise * np.random.default_rng(seed).standard_normal(x.size)
    return dehyst.Recording(
        x, y, t, name=f"log {seed}", schedules={"temperature": T},
        schedule_units={"temperature": "degC"},
    )  # fmt: skip


def plain(record):
    return replace(record, schedules={}, schedule_units={})


@pytest.fixture(scope="module")
def swaying():
    return dehyst.identify(log(1))


@pytest.mark.slow
def test_a_loop_that_goes_with_a_temperature_is_followed_where_the_temperature_is_told(swaying):
    without = dehyst.identify(plain(log(1)))
    assert swaying.model.needs == ("temperature",) and without.model.needs == ()
    assert swaying.test.rmse_percent < 0.2 * without.test.rmse_percent
    assert swaying.input_test.rms_percent < 0.2 * without.input_test.rms_percent
    (card,) = swaying.model.context
    assert (card.name, card.unit) == ("temperature", "degC")
    assert swaying.model.remarks[0].startswith("weights go with temperature, 20")
    assert swaying.as_dict()["schedules"] == ["temperature"]


@pytest.mark.slow
@pytest.mark.parametrize("temperature", [20.0, 50.0, 71.0])
def test_the_inverse_undoes_the_model_at_every_temperature(swaying, temperature):
    x, model = strokes(15, 8), swaying.model
    t = DT * np.arange(x.size)
    y = model.simulate(x, t, temperature=temperature)
    back = model.inverse().simulate(y, t, temperature=temperature)
    np.testing.assert_allclose(back, x, atol=1e-12)
    assert model.least_slope > 0.0


@pytest.mark.slow
def test_a_block_of_the_core_answers_as_the_model_and_its_inverse(swaying):
    model, record = swaying.model, log(3)
    T = record.schedules["temperature"]
    y = model.simulate(record.input, record.time, temperature=T)
    for what, driven, answer in (("forward", record.input, y), ("inverse", y, record.input)):
        block = dehyst.block(model, what, range=(-1.2, 1.2), period=DT)
        steps = []
        for value, told in zip(driven, T, strict=True):
            steps.append(block.step(value, given={"temperature": told}))
        np.testing.assert_allclose(steps, answer, atol=1e-12)


@pytest.mark.slow
def test_between_levels_that_were_logged_the_left_out_one_is_predicted():
    fit = dehyst.identify([log(10 + k, T, 25) for k, T in enumerate((20, 40, 60, 80))])
    between = log(20, 50, 25)
    entry = dehyst.evaluate(fit.model, between)[fit.family]
    pooled = dehyst.identify([plain(log(10 + k, T, 25)) for k, T in enumerate((20, 40, 60, 80))])
    assert entry.error_percent < 1.0
    assert entry.error_percent < 0.25 * dehyst.evaluate(pooled.model, between)[pooled.family].error_percent  # fmt: skip
    assert not {"recordings-differ"} & {finding.code for finding in fit.warnings}


@pytest.mark.slow
def test_a_signal_that_changes_nothing_is_left_out_and_that_is_said():
    record = plain(log(1))
    noise = np.random.default_rng(0).standard_normal(len(record))
    still = replace(record, schedules={"noise": noise})
    fit = dehyst.identify(still)
    assert fit.model == dehyst.identify(record).model
    assert "schedule-no-gain" in {finding.code for finding in fit.warnings}


@pytest.mark.slow
def test_a_level_in_one_stretch_alone_is_said():
    record = log(1, 20.0)
    T = np.where(record.time < 0.15 * record.time[-1], 20.0, 30.0)
    fit = dehyst.identify(replace(record, schedules={"temperature": T}), train_fraction=1.0)
    assert "schedule-once" in {finding.code for finding in fit.warnings}


@pytest.mark.parametrize(
    "family",
    [pytest.param("full-sum", marks=pytest.mark.slow), "inverse-stop-rate", "direct-inverse"],
)
def test_a_row_that_is_named_goes_with_the_signal_too(family):
    fit = dehyst.identify(log(1), family)
    assert fit.model.needs == ("temperature",)
    assert fit.input_test.rms_percent < 3.0


@pytest.mark.slow
def test_two_signals_are_told_apart():
    x = strokes(60, 1)
    t = DT * np.arange(x.size)
    T, load = 50.0 + 30.0 * np.sin(1.3 * t), 5.0 + 5.0 * np.sin(2.9 * t)
    y = (1.0 + 0.01 * T) * PLAYS.simulate(x) + 0.1 * load * (x - WIDE.simulate(x))
    record = dehyst.Recording(x, y, t, schedules={"temperature": T, "load": load})
    fit = dehyst.identify(record)
    assert fit.model.needs == ("temperature", "load")
    assert fit.test.rmse_percent < 1.0


@pytest.fixture(scope="module")
def of_three():
    """A log whose gain, loop and level go with a signal each, and how the model of all three errs."""
    x = strokes(40, 1)
    t = DT * np.arange(x.size)
    T, load = 50.0 + 30.0 * np.sin(1.3 * t), 5.0 + 5.0 * np.sin(2.9 * t)
    voltage = 3.0 + 2.0 * np.sin(0.71 * t + 1.0)
    y = (1.0 + 0.01 * T) * PLAYS.simulate(x) + 0.1 * load * (x - WIDE.simulate(x))
    y += 0.15 * voltage * (1.0 + x) + 0.002 * np.random.default_rng(3).standard_normal(x.size)
    signals = {"temperature": T, "load": load, "voltage": voltage}
    record = dehyst.Recording(x, y, t, schedules=signals)
    return record, dehyst.identify(record)


@pytest.mark.slow
def test_a_third_signal_is_told_apart_from_the_other_two(of_three):
    record, fit = of_three
    two = {name: record.schedules[name] for name in ("temperature", "load")}
    without = dehyst.identify(replace(record, schedules=two, schedule_units={}))
    assert fit.model.needs == ("temperature", "load", "voltage")
    assert fit.test.rmse_percent < without.test.rmse_percent / 3.0
    assert fit.test.rmse_percent < 1.0


@pytest.mark.slow
def test_the_inverse_undoes_a_model_of_three_signals_and_its_exported_c_has_its_bits(
    of_three, tmp_path
):
    record, fit = of_three
    model, signals = fit.model, record.schedules
    y = model.simulate(record.input, record.time, **signals)
    back = model.inverse().simulate(y, record.time, **signals)
    np.testing.assert_allclose(back, record.input, atol=1e-12)
    block = dehyst.block(model, "inverse", range=(-1.2, 1.2), period=DT)
    steps, _ = block.run(y, given=signals)
    np.testing.assert_allclose(steps, record.input, atol=1e-12)
    unit = export(subject_of(model, "inverse", name="unit_1", ramp=40), "c", tmp_path / "out")
    assert "temperature, dehyst_real load, dehyst_real voltage" in (
        unit.folder / "src" / "unit_1.h"
    ).read_text(encoding="utf-8")
    assert [check for check in verify(unit.folder) if not check.ok] == []


@pytest.mark.slow
def test_a_saved_model_answers_alike(swaying, tmp_path):
    loaded = dehyst.load(swaying.model.save(tmp_path / "m.json"))
    assert loaded == swaying.model and loaded.context == swaying.model.context


@pytest.mark.slow
def test_a_size_that_no_model_with_the_signal_has_is_refused_with_the_one_that_fits():
    with pytest.raises(dehyst.DehystError, match="the smallest has"):
        dehyst.identify(log(1), size=4)


@pytest.mark.slow
def test_a_stepper_holds_its_output_while_the_signal_is_no_number(swaying):
    step = swaying.model.stepper(DT)
    first = step(0.3, temperature=40.0)
    assert step(0.5, temperature=float("nan")) == first and step.rejected
    assert step(0.5, temperature=40.0) != first and not step.rejected


def test_what_does_not_go_with_a_signal_refuses_it():
    record = log(1)
    for family, more in (("pi", {}), ("dahl", {}), ("auto", {"n": 20})):
        with pytest.raises(ParameterError, match=r"temperature; --schedule"):
            dehyst.identify(record, family, **more)


@pytest.mark.slow
def test_signals_that_cannot_serve_are_refused_with_a_cure(swaying):
    record = log(1)
    T = record.schedules["temperature"]
    with pytest.raises(RecordingError, match="one value for each sample"):
        replace(record, schedules={"temperature": T[:-1]})
    for schedules, words in (({"": T}, "by their names"), ([T], "by their names")):
        with pytest.raises(RecordingError, match=words):
            replace(plain(record), schedules=schedules)
    with pytest.raises(RecordingError, match="no schedule"):
        replace(record, schedule_units={"heat": "K"})
    with pytest.raises(RecordingError, match="not finite"):
        replace(record, schedules={"temperature": np.full(len(record), np.nan)})
    with pytest.raises(ExcitationError, match="stays at 3"):
        dehyst.identify(replace(record, schedules={"temperature": np.full(len(record), 3.0)}))
    with pytest.raises(ParameterError, match=r"3 signals at most\. Leave out"):
        dehyst.identify(replace(plain(record), schedules=dict.fromkeys("abcd", T)))
    with pytest.raises(ParameterError, match="NAME=COLUMN"):
        dehyst.identify(replace(plain(record), schedules={"time": T}))
    with pytest.raises(ParameterError, match="same signals in the same units"):
        dehyst.identify([record, replace(log(2), schedule_units={"temperature": "K"})])
    with pytest.raises(ParameterError, match="temperature"):
        swaying.model.simulate(record.input, record.time)


@given(data=st.data(), group=st.sampled_from(sorted(GROUPS)), schedules=st.integers(1, 3))
@settings(max_examples=40)
def test_the_elements_of_scheduled_weights_are_the_weighted_columns(data, group, schedules):
    rng = np.random.default_rng(data.draw(st.integers(0, 2**32 - 1)))
    columns = columns_of((group,), 4, Pace(DT, 2.0, (0.01, 0.03, 0.1)), schedules)
    weight = np.where(rng.random(columns.cell.size) < 0.4, rng.random(columns.cell.size), 0.0)
    weight[0] = 0.5
    x = np.clip(np.cumsum(rng.normal(0.0, 0.1, 60)), -1.0, 1.0)
    dt = np.full(60, DT)
    dt[0] = 0.0
    told = rng.uniform(0.0, 1.0, (60, 3))
    ranges = tuple((source, 0.0, 1.0) for source in range(schedules))
    template = ElementModel(columns.cells, period=DT)
    e, _ = template.columns(x, dt, template.rest(float(x[0])))
    wanted = columns.values(e, told[:, :schedules]) @ weight
    model = ElementModel(columns.elements(weight), schedules=ranges, period=DT)
    y, _ = model.run(x, dt, model.rest(float(x[0])), told)
    np.testing.assert_allclose(y, wanted, atol=1e-10)


def test_shares_of_a_schedule_add_up_to_one():
    xi = np.array([[0.0, 0.25], [1.0, 0.75]])
    np.testing.assert_allclose(shares(xi)[:, 1::2] + shares(xi)[:, 2::2], 1.0)


@pytest.mark.slow
def test_the_commands_read_the_signal_by_its_name(run, tmp_path):
    for name, record in (("log", log(1)), ("later", log(2))):
        table = np.column_stack(
            [record.time, record.input, record.output, record.schedules["temperature"]]
        )
        np.savetxt(
            tmp_path / f"{name}.csv", table, delimiter=",", comments="", fmt="%.9g",
            header="time_s,drive_V,stroke_mm,T_degC",
        )  # fmt: skip
    model, played = tmp_path / "m.json", tmp_path / "u.csv"
    columns = ("--input", "drive_V", "--output", "stroke_mm")
    status, out, err = run(
        "identify", tmp_path / "log.csv", *columns, "--schedule", "heat=T_degC", "--save", model
    )
    assert status == 0, err
    assert "weights go with heat, 20" in out and "--schedule heat=COLUMN" in " ".join(out.split())
    status, out, _ = run(
        "evaluate", model, tmp_path / "later.csv", "--schedule", "heat=T_degC", "--json"
    )
    assert status == 0 and json.loads(out)["models"][0]["output_error"]["rmse_percent"] < 1.0
    status, _, err = run("evaluate", model, tmp_path / "later.csv")
    assert status == 1
    reference = ("compensate", model, tmp_path / "later.csv", "--output", "stroke_mm")
    status, _, err = run(*reference, "--out", played)
    assert status == 2 and "--schedule heat=COLUMN" in " ".join(err.split())
    status, _, err = run(*reference, "--schedule", "heat=T_degC", "--out", played)
    assert status == 0, err
    asked = dehyst.read_signal(played, "compensated_drive").values
    later = log(2)
    assert 100.0 * np.std(asked - later.input) / 2.0 < 1.0
    evaluated = ("evaluate", model, tmp_path / "later.csv", "--schedule", "load=stroke_mm")
    status, _, err = run(*evaluated)
    assert status == 2 and "--schedule heat=COLUMN" in " ".join(err.split())
    dehyst.identify(plain(log(1)), "pi").model.save(tmp_path / "plain.json")
    evaluated = ("evaluate", tmp_path / "plain.json", *evaluated[2:], *columns)
    status, _, err = run(*evaluated)
    assert status == 2 and "no --schedule" in " ".join(err.split())
    spare = ("simulate", model, tmp_path / "later.csv", "--schedule", "load=stroke_mm")
    assert run(*spare, "--schedule", "heat=T_degC")[0] == 2


@pytest.mark.slow
def test_the_report_says_what_the_weights_go_with(swaying, tmp_path):
    page = write_report(swaying, tmp_path / "report.html").read_text(encoding="utf-8")
    text = " ".join(page.split())
    assert "Its weights go with temperature (20" in text and "degC)" in text
    assert "output, with temperature" in text
    without = write_report(dehyst.identify(plain(log(1))), tmp_path / "plain.html")
    assert "Its weights go with" not in without.read_text(encoding="utf-8")
