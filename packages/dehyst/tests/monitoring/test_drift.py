"""Drift: an actuator that has not changed is not called changed more often than promised; what has changed is named,
with its size; what cannot be compared is not; a new model is accepted only if it is better on unseen cycles."""

import dataclasses
import itertools
import re
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import dehyst
from dehyst.design import CYCLES
from dehyst.design._policy import POLICY
from dehyst.errors import ParameterError
from dehyst.families._preisach import Preisach
from dehyst.models import DirectInverse, ModelCard, SignalCard
from dehyst.monitoring import _groups as grouping
from dehyst.monitoring import _parts as taken
from dehyst.monitoring import _testing as testing
from dehyst.monitoring._logs import MOST_GROUPS
from places import ROOT

sys.path.insert(0, str(ROOT / "benchmarks"))

from drift_rig import cycling_log, logged

PURE = {"creep": 0.0}  # no creep: the loop is hysteresis alone
WITHIN = {
    **PURE,
    "bend": 0.0,
}  # a plant within the class of the model "pi": what changes has one true size


def identified(log, family="pi"):
    return dehyst.identify(log, family, n=30).model


@pytest.fixture(scope="module")
def new():
    log = cycling_log(1000, 24, PURE, minor=True, name="new")
    return identified(log, "auto"), log


def counted(found, log=-1):
    """Parts that count as changed in a log; the error, which is their sum, left out."""
    return {change.part for change in found.logs[log].changes if change.drifted} - {"error"}


# --- no change ----------------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize(
    "referred", [True, False], ids=["against a reference", "against the model"]
)
def test_an_unchanged_actuator_is_called_drifted_no_more_often_than_promised(referred):
    alarms = 0
    for seed in range(25):
        log = cycling_log(500 + seed, 10, minor=True)
        later = cycling_log(seed, 10, minor=True)
        found = dehyst.drift(
            identified(log), later, reference=log if referred else None, false_alarm=0.08
        )
        alarms += found.status == "drifted"
    assert alarms <= 7  # binomial(25, 0.08) exceeds it three times in a thousand


@pytest.mark.slow
def test_noise_that_remembers_does_not_look_like_certainty():
    """Oracle: estimates of many logs scatter as the intervals say, though samples are far from independent."""
    log = cycling_log(77, 16, PURE)
    model = identified(log)
    inside = []
    for seed in range(20):
        change = dehyst.drift(model, cycling_log(seed, 16, PURE, noise=3.0), reference=log).change(
            "offset"
        )
        inside.append(change.low <= 0.0 <= change.high)
    assert sum(inside) >= 15


def test_many_logs_share_the_false_alarms_allowed(new):
    model, log = new
    one = dehyst.drift(model, cycling_log(1, 10, PURE, minor=True), reference=log)
    many = dehyst.drift(
        model, [cycling_log(k, 10, PURE, minor=True) for k in range(4)], reference=log
    )
    assert many.status == "unchanged"
    assert many.settings["level"] == pytest.approx(one.settings["level"] / 4)


# --- change -------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def exact():
    log = cycling_log(1001, 24, WITHIN, minor=True, name="new")
    return identified(log), log


@pytest.mark.parametrize("factor", [0.9, 0.8, 1.15])
@pytest.mark.parametrize("referred", [True, False])
def test_a_hysteresis_of_another_size_is_found_with_its_size_to_a_tenth(exact, factor, referred):
    model, log = exact
    later = cycling_log(3, 24, {**WITHIN, "hysteresis": factor}, minor=True)
    found = dehyst.drift(model, later, reference=log if referred else None)
    change = found.change("hysteresis")
    assert found.status == "drifted" and change.drifted
    assert change.estimate == pytest.approx(100 * (factor - 1), rel=0.1)
    largest = max(
        (c for c in found.logs[0].changes if c.part in counted(found)),
        key=lambda c: c.effect_percent,
    )
    assert largest.part == "hysteresis"
    assert "hysteresis size" in found.verdict


@pytest.mark.parametrize(
    ("wear", "part", "size", "within"),
    [
        ({"offset": 0.3}, "offset", 0.3, 0.03),
        ({"gain": 0.97}, "gain", -3.0, 0.3),
        ({"gain": 1.05, "offset": -0.5}, "gain", 5.0, 0.4),
    ],
)
def test_an_offset_or_gain_is_named_and_sized(new, wear, part, size, within):
    model, log = new
    found = dehyst.drift(model, cycling_log(5, 24, {**PURE, **wear}, minor=True), reference=log)
    change = found.change(part)
    assert change.drifted
    assert change.estimate == pytest.approx(size, abs=within)
    assert not found.change("hysteresis").drifted


def test_a_curve_that_bends_otherwise_is_no_hysteresis(new):
    model, log = new
    found = dehyst.drift(
        model, cycling_log(6, 24, {**PURE, "bend": 1.5}, minor=True), reference=log
    )
    assert found.change("s-bend").drifted
    assert found.change("hysteresis").effect_percent < 0.5 * found.change("s-bend").effect_percent


def test_a_noisier_sensor_shows_as_rest_and_as_nothing_else(new):
    model, log = new
    found = dehyst.drift(model, cycling_log(8, 24, PURE, minor=True, noise=6.0), reference=log)
    assert counted(found) == {"rest"}


def test_a_change_smaller_than_what_is_called_detectable_may_be_missed_and_a_larger_one_is_found(
    new,
):
    model, log = new
    limit = (
        dehyst.drift(model, cycling_log(9, 24, PURE, minor=True), reference=log)
        .change("offset")
        .detectable
    )
    larger = [
        dehyst.drift(
            model, cycling_log(k, 24, {**PURE, "offset": limit}, minor=True), reference=log
        ).status
        for k in range(8)
    ]
    assert larger.count("drifted") >= 5
    tiny = cycling_log(9, 24, {**PURE, "offset": 0.02 * limit}, minor=True)
    assert dehyst.drift(model, tiny, reference=log).status == "unchanged"


def test_the_first_log_that_shows_a_change_is_named(new):
    model, log = new
    later = [
        cycling_log(k, 10, {**PURE, "hysteresis": f}, minor=True)
        for k, f in ((1, 1.0), (2, 1.0), (3, 0.8))
    ]
    found = dehyst.drift(model, later, reference=log)
    assert [entry.status for entry in found.logs] == ["unchanged", "unchanged", "drifted"]
    assert "first seen in log 3" in found.verdict


# --- long logs ----------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def worn():
    new = cycling_log(2000, 20, WITHIN, name="new")
    wear = {**WITHIN, "hysteresis": lambda s: 1.0 - 0.15 * s, "offset": lambda s: 0.2 * s}
    return identified(new), new, cycling_log(2001, 490, wear, rate=10.0, name="490 cycles")


def test_490_uneven_noisy_cycles_are_counted_but_for_the_ends(worn):
    model, new, log = worn
    entry = dehyst.drift(model, log, reference=new).logs[0]
    assert 487 <= entry.cycles <= 490
    assert 120 <= entry.tested <= 125


def test_a_slow_change_over_490_cycles_is_found_at_its_size_with_its_slope(worn):
    """Truth in the last quarter: 15 % * (1 - 1/8) less hysteresis; 15 % in 490 cycles."""
    model, new, log = worn
    found = dehyst.drift(model, log, reference=new)
    change, slope = (
        found.change("hysteresis"),
        next(t for t in found.trends if t.part == "hysteresis"),
    )
    assert change.drifted and change.estimate == pytest.approx(-15.0 * 0.875, abs=1.0)
    assert slope.clear and slope.slope == pytest.approx(-15.0 / 4.9, rel=0.1)
    blocks = found.logs[0].blocks
    assert (
        np.mean(blocks.changes["hysteresis"][:10]) > -3.0
        and np.mean(blocks.changes["hysteresis"][-10:]) < -12.0
    )
    assert np.all(np.diff(blocks.cycle) > 0)


def test_no_slope_is_clear_where_nothing_changes():
    new = cycling_log(2000, 20, PURE)
    found = dehyst.drift(identified(new), cycling_log(7, 200, PURE, rate=10.0), reference=new)
    assert found.status == "unchanged"
    assert len(found.trends) >= 4 and not any(trend.clear for trend in found.trends)


# --- the log that the model was identified from -------------------------------------------------------------


def csv(path, record):
    from dehyst.io import write_csv

    write_csv(
        path, {"time_s": record.time, "pressure_bar": record.input, "angle_deg": record.output}
    )
    return dehyst.read_log(path, "pressure", "angle")


def test_the_log_of_the_model_becomes_the_reference_by_its_checksum(tmp_path):
    first = csv(tmp_path / "new.csv", cycling_log(1, 24, minor=True))
    later = csv(tmp_path / "later.csv", cycling_log(2, 24, minor=True))
    found = dehyst.drift(identified(first), [first, later])
    assert found.reference == "new.csv"
    assert [entry.status for entry in found.logs] == ["reference", "unchanged"]
    renamed = dataclasses.replace(first, name="copy.csv")
    assert dehyst.drift(identified(first), [renamed, later]).reference == "copy.csv"


def test_one_long_log_is_compared_with_its_own_beginning(tmp_path):
    wear = {**PURE, "gain": lambda s: 1.0 - 0.05 * np.maximum(0.0, s - 0.5)}
    log = csv(tmp_path / "long.csv", cycling_log(3, 100, wear, rate=10.0))
    found = dehyst.drift(identified(log), log)
    assert found.reference == "long.csv"
    assert found.logs[0].tested == 12 and found.change("gain").drifted


# --- not comparable -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("later", "reason"),
    [
        (lambda: cycling_log(1, 24, amplitude=1.0), "less than 80 %"),
        (lambda: cycling_log(1, 24, amplitude=2.6), "goes beyond"),
        (lambda: cycling_log(1, 2), "complete cycle"),
        (
            lambda: dataclasses.replace(cycling_log(1, 24), input_unit="deg", output_unit="bar"),
            "swapped",
        ),
        (
            lambda: dataclasses.replace(
                cycling_log(1, 24),
                output=np.random.default_rng(0).standard_normal(len(cycling_log(1, 24))),
            ),
            "another column",
        ),
    ],
    ids=["smaller", "larger", "short", "swapped", "other column"],
)
def test_what_cannot_be_compared_is_not(new, later, reason):
    found = dehyst.drift(new[0], later(), refit=True)
    assert found.status == "not comparable"
    assert reason in found.verdict
    assert not found.acceptance.accepted and found.model is new[0]


def test_another_unit_of_the_same_kind_is_converted(new):
    model, log = new
    later = cycling_log(4, 24, PURE, minor=True)
    kilo = dataclasses.replace(later, input=100.0 * later.input, input_unit="kPa")
    found = dehyst.drift(model, kilo, reference=log)
    assert found.status == "unchanged"
    assert found.change("gain").estimate == pytest.approx(
        dehyst.drift(model, later, reference=log).change("gain").estimate
    )
    assert {"unit-converted"} <= {finding.code for finding in found.findings}


def test_one_bad_log_does_not_spoil_the_others(new):
    model, log = new
    found = dehyst.drift(
        model,
        [cycling_log(1, 24, amplitude=0.8), cycling_log(2, 24, PURE, minor=True)],
        reference=log,
    )
    assert [entry.status for entry in found.logs] == ["not comparable", "unchanged"]
    assert found.status == "unchanged"


# --- refit --------------------------------------------------------------------------------------------------


def test_a_new_model_is_accepted_if_it_is_better_on_held_out_cycles(new):
    model, _ = new
    later = cycling_log(11, 60, {**PURE, "hysteresis": 0.8}, minor=True)
    found = dehyst.drift(model, later, refit=True)
    decision = found.acceptance
    assert decision.accepted and decision.new_percent < 0.6 * decision.old_percent
    assert found.model is decision.model and found.model is not model
    assert found.model.card.provenance["replaces"]["sha256"]
    unseen = cycling_log(12, 20, {**PURE, "hysteresis": 0.8}, minor=True)
    errors = [dehyst.drift(m, unseen).logs[0].error_percent for m in (model, found.model)]
    assert errors[1] < 0.6 * errors[0]


@pytest.mark.parametrize("seed", range(3))
def test_a_new_model_of_an_unchanged_actuator_is_not_accepted(new, seed):
    model, _ = new
    found = dehyst.drift(model, cycling_log(20 + seed, 40, PURE, minor=True), refit=True)
    assert found.status == "unchanged"
    assert not found.acceptance.accepted and found.model is model and found.acceptance.model is None
    assert (
        "has not changed, so nothing was identified anew; the old model stays"
        in found.acceptance.reason
    )


def test_a_new_model_that_only_fits_its_own_half_is_not_accepted(new):
    model, _ = new
    wear = {**PURE, "hysteresis": 0.6, "offset": lambda s: np.where(s < 0.52, 3.0, 0.0)}
    found = dehyst.drift(model, cycling_log(30, 40, wear, minor=True), refit=True)
    assert not found.acceptance.accepted
    assert found.acceptance.new_percent > found.acceptance.old_percent


# --- families -----------------------------------------------------------------------------------------------


def families():
    x = np.sin(np.linspace(0.0, 40 * np.pi, 4001))
    r = [0.0, 0.3, 0.6]
    inner = dehyst.PrandtlIshlinskii(r, [1.0, 0.6, 0.4])
    card = ModelCard(SignalCard("x", "", -1.0, 1.0), SignalCard("y", "", -3.0, 3.0))
    yield "pi", inner.with_card(card), x
    curve = dehyst.MonotoneMap([-3.0, 0.0, 3.0], [-2.0, 0.0, 4.0])
    yield "modified", dehyst.ModifiedPrandtlIshlinskii(inner, after_map=curve).with_card(card), x
    yield "stop", dehyst.StopOperatorModel(r, [0.0, 1.0, 0.5], slope=1.0).with_card(card), x
    yield "static", dehyst.models.StaticCurve(curve).with_card(card), x
    yield "inverse", dehyst.ModifiedPrandtlIshlinskii(inner, after_map=curve).inverse(), x


@pytest.mark.parametrize(
    ("name", "model", "x"), list(families()), ids=lambda v: v if isinstance(v, str) else ""
)
def test_every_family_is_compared_and_a_scale_of_its_output_is_a_gain(name, model, x):
    noise = 0.01 * np.random.default_rng(0).standard_normal(x.size)
    y = model.simulate(x)
    same = dehyst.drift(model, dehyst.Recording(input=x, output=y + noise))
    assert same.status == "unchanged"
    assert all(np.isfinite(change.estimate) for change in same.logs[0].changes)
    scaled = dehyst.drift(model, dehyst.Recording(input=x, output=1.1 * y + noise))
    assert scaled.change("gain").drifted
    assert scaled.change("gain").estimate == pytest.approx(10.0, abs=1.0)


def direct(**more):
    card = ModelCard(SignalCard("u", "", -4.0, 4.0), SignalCard("y", "", -1.0, 1.0))
    parts = {
        "radii": [0.2, 0.5],
        "stop_weights": [1.0, 0.6],
        "polynomial": [0.0, 2.0],
        "card": card,
    }
    return DirectInverse(**(parts | more))


@pytest.mark.parametrize(
    ("worn", "part", "size"),
    [
        ({"stop_weights": [0.8, 0.48]}, "hysteresis", -20.0),
        ({"polynomial": [0.1, 2.0]}, "offset", 0.1),
        ({"creep_weights": [0.6]}, "own-creep", 50.0),
    ],
)
def test_a_direct_inverse_says_which_of_its_parts_changed(worn, part, size):
    """The model maps the log's output to its input: changes are those of the input."""
    cycle = np.arange(12_000) // 200  # of 60; every second one is slow, every third one small
    y = np.sin(np.arange(12_000) * np.pi / 100) * np.where(cycle % 3, 1.0, 0.6)
    t = np.cumsum(np.where(cycle % 2, 0.05, 0.004))
    creep = {"time_constants": [2.0], "creep_weights": [0.4]} if part == "own-creep" else {}
    new, old = direct(**{**creep, **worn}), direct(**creep)
    u = new.run(y, t).u + 0.005 * np.random.default_rng(1).standard_normal(y.size)
    found = dehyst.drift(old, dehyst.Recording(input=u, output=y, time=t))
    change = found.change(part)
    assert change.drifted and change.estimate == pytest.approx(size, rel=0.1)
    assert [
        c.part
        for c in found.logs[0].changes
        if c.drifted and c.effect_percent > 0.5 * change.effect_percent
    ] == [part]
    same = old.run(y, t).u + 0.005 * np.random.default_rng(2).standard_normal(y.size)
    assert dehyst.drift(old, dehyst.Recording(input=same, output=y, time=t)).status == "unchanged"


def test_a_shifted_sensor_is_an_offset_of_a_direct_inverse_and_nothing_else():
    """Where the curve is held, beyond the range, a shift would look like a bend of the curve and a smaller gain."""
    y = np.sin(np.arange(8000) * np.pi / 100)
    model, t = direct(), 0.01 * np.arange(8000)
    u = model.run(y, t).u + 0.005 * np.random.default_rng(3).standard_normal(8000)
    found = dehyst.drift(model, dehyst.Recording(input=u, output=y + 0.1, time=t))
    offset = found.change("offset")
    assert offset.drifted and offset.estimate == pytest.approx(
        -0.2, rel=0.05
    )  # slope 2 of the curve
    assert [
        c.part
        for c in found.logs[0].changes
        if c.drifted and c.effect_percent > 0.2 * offset.effect_percent
    ] == ["offset"]
    beyond = int(np.count_nonzero(y + 0.1 > 1.0))
    told = next(finding for finding in found.findings if finding.code == "drift-beyond-range")
    counted, samples = map(int, re.findall(r"(\d+) of (\d+) samples", told.message)[0])
    assert 0 < counted <= beyond and counted / samples == pytest.approx(beyond / y.size, rel=0.1)
    same = dehyst.drift(model, dehyst.Recording(input=u, output=y, time=t))
    assert "drift-beyond-range" not in {finding.code for finding in same.findings}


def test_a_direct_inverse_that_depends_on_a_load_needs_it():
    schedule = dehyst.models.Schedule("load", 0.0, 10.0, "N")
    sets = {"radii": [0.3], "stop_weights": [[0.5], [1.5]], "polynomial": [[0.0, 2.0], [0.0, 3.0]]}
    model = direct(**{**sets, "schedules": (schedule,)})
    y = np.sin(np.linspace(0.0, 24 * np.pi, 2401))
    t, load = np.linspace(0.0, 24.0, 2401), np.linspace(0.0, 10.0, 2401)
    u = model.run(y, t, given={"load": load}).u + 0.005 * np.random.default_rng(1).standard_normal(
        y.size
    )
    later = dehyst.Recording(input=u, output=y, time=t)
    assert "--schedule load=COLUMN" in dehyst.drift(model, later).verdict
    loaded = dataclasses.replace(later, schedules={"load": load}, schedule_units={"load": "N"})
    assert dehyst.drift(model, loaded).status == "unchanged"
    wrong = dataclasses.replace(loaded, schedules={"load": np.full(2401, 10.0)})
    assert dehyst.drift(model, wrong).status == "drifted"


@pytest.mark.slow
def test_a_direct_inverse_is_identified_anew_and_accepted_only_if_better():
    y = np.sin(np.linspace(0.0, 48 * np.pi, 4801)) * (1.0 - 0.4 * (np.arange(4801) // 300 % 2))
    t = np.linspace(0.0, 48.0, 4801)
    noise = 0.01 * np.random.default_rng(1).standard_normal(y.size)
    old, worn = direct(), direct(stop_weights=[0.7, 0.4])
    better, same = (
        dehyst.drift(
            old, dehyst.Recording(input=m.run(y, t).u + noise, output=y, time=t), refit=True
        )
        for m in (worn, old)
    )
    assert (
        better.acceptance.accepted
        and isinstance(better.model, DirectInverse)
        and better.model is not old
    )
    assert not same.acceptance.accepted and same.model is old


def test_a_sheared_model_is_identified_anew_with_its_shear(new):
    log = cycling_log(1003, 24, WITHIN, minor=True)
    model = dehyst.identify(log, "pi", n=30, shear=0.2).model
    found = dehyst.drift(
        model,
        cycling_log(4, 40, {**WITHIN, "hysteresis": 0.7}, minor=True),
        reference=log,
        refit=True,
    )
    assert found.status == "drifted" and found.change("hysteresis").drifted
    assert found.acceptance.accepted and found.model.shear == model.shear


def slipping_log(seed, size=1.0, backbone=0.0, offset=0.0, cycles=24):
    """Friction of a joint, in bar over an angle in rad, whose backbone was taken off, or part of it."""
    rng = np.random.default_rng(seed)
    height = 0.6 * (1.0 + 0.04 * rng.standard_normal(2 * cycles + 2))
    height[:2], height[4::6], height[5::6] = 0.63, 0.5 * height[4::6], 0.5 * height[5::6]
    tips = np.r_[0.0, height * np.where(np.arange(height.size) % 2, -1.0, 1.0)]
    place = np.linspace(0.0, tips.size - 1.0, 60 * (tips.size - 1) + 1)
    k = np.minimum(place.astype(int), tips.size - 2)
    q = tips[k] + (tips[k + 1] - tips[k]) * (0.5 - 0.5 * np.cos(np.pi * (place - k)))
    weights = size * np.array([0.0, 3.0, 1.5, 0.8, 0.3, 0.1])
    u = (
        dehyst.StopOperatorModel(
            [0.0, 0.01, 0.03, 0.08, 0.2, 0.4], weights, slope=backbone
        ).simulate(q)
        + offset
    )
    return dehyst.Recording(
        input=u + 0.03 * rng.standard_normal(q.size), output=q + 1e-4 * rng.standard_normal(q.size),
        time=0.03 * np.arange(q.size), name=f"log {seed}",
    )  # fmt: skip


@pytest.mark.parametrize(
    ("backbone", "k", "forward"), [(0.0, 5.0, False), (3.0, 1.0, True)], ids=["loop", "curve"]
)
class TestOfShearedModels:
    """They run as their compensators: what the card says of the sheared loop, which sees the output, is too good."""

    def test_an_unchanged_rig_is_not_called_drifted_without_a_reference(self, backbone, k, forward):
        model = dehyst.identify(slipping_log(1000, backbone=backbone), "pi", shear=k, n=30).model
        assert model.has_forward == forward
        for seed in range(8):
            found = dehyst.drift(model, slipping_log(seed, backbone=backbone))
            assert found.status in ("unchanged", "cannot tell")
            assert found.identified_percent == pytest.approx(found.logs[0].error_percent, rel=0.15)

    def test_a_smaller_loop_is_found_and_the_new_model_accepted_with_its_k_and_error(
        self, backbone, k, forward
    ):
        log = slipping_log(1000, backbone=backbone)
        model = dehyst.identify(log, "pi", shear=k, n=30).model
        found = dehyst.drift(model, slipping_log(3, 0.8, backbone), reference=log, refit=True)
        part = found.change(
            "hysteresis" if backbone else "gain"
        )  # without a curve all of it is loop
        assert part.drifted and part.estimate == pytest.approx(-20.0, abs=3.0)
        assert found.acceptance.accepted and found.model.shear == k
        again = dehyst.drift(found.model, slipping_log(4, 0.8, backbone))
        assert again.status in ("unchanged", "cannot tell")
        assert again.identified_percent == pytest.approx(again.logs[0].error_percent, rel=0.15)

    def test_a_shifted_pressure_is_an_offset_in_its_unit(self, backbone, k, forward):
        log = slipping_log(1000, backbone=backbone)
        model = dehyst.identify(log, "pi", shear=k, n=30).model
        found = dehyst.drift(model, slipping_log(3, 1.0, backbone, offset=0.1), reference=log)
        assert counted(found) == {"offset"} and found.change("offset").estimate == pytest.approx(
            0.1, abs=0.01
        )


@pytest.mark.slow
@pytest.mark.parametrize("family", ["pi-cumulative", "modified-pi"])
def test_a_new_model_keeps_the_gain_that_was_allowed_to_the_old_one(family):
    log = cycling_log(1003, 24, WITHIN, minor=True)
    gain = 0.8 * dehyst.identify(log, family, n=30, eps=0.001).certificate.inverse_gain
    model = dehyst.identify(log, family, n=30, max_inverse_gain=gain).model
    found = dehyst.drift(
        model, cycling_log(4, 40, {**WITHIN, "gain": 0.7}, minor=True), reference=log, refit=True
    )
    assert found.acceptance.accepted
    assert found.model.card.provenance["settings"]["max_inverse_gain"] == gain
    assert found.model.inverse_gain <= gain * 1.001


def scheduled(stop=1.0, line=1.0):
    """A direct inverse whose loop and curve grow with load and mean pressure."""
    schedules = (
        dehyst.models.Schedule("load", 0.0, 10.0, "N"),
        dehyst.models.Schedule("mean_pressure", 1.0, 3.0, "bar"),
    )
    stops = stop * np.array([[0.5, 0.3], [1.0, 0.4], [0.7, 0.3], [1.1, 0.5]])
    curve = line * np.array([[0.0, 2.0], [0.0, 3.0], [0.0, 2.5], [0.0, 3.2]])
    return direct(radii=[0.15, 0.4], stop_weights=stops, polynomial=curve, schedules=schedules)


def loaded_log(model, seed, samples=9600):
    """Log of a rig that a scheduled model describes, with the load and the mean pressure that it moved under."""
    rng, turn = np.random.default_rng(seed), np.arange(samples) * np.pi / 100
    y = np.sin(turn) * np.where(np.arange(samples) // 200 % 3, 1.0, 0.6)
    given = {
        "load": 5.0 + 5.0 * np.sin(turn / 6.9 + seed),
        "mean_pressure": 2.0 + np.cos(turn / 4.3 + seed),
    }
    t = 0.02 * np.arange(samples)
    u = model.run(y, t, given=given).u + 0.005 * rng.standard_normal(samples)
    units = {"load": "N", "mean_pressure": "bar"}
    return dehyst.Recording(
        input=u, output=y, time=t, name=f"log {seed}", schedules=given, schedule_units=units
    )


@pytest.mark.exhaustive
@pytest.mark.parametrize(
    "referred", [True, False], ids=["against a reference", "against the model"]
)
def test_a_scheduled_inverse_says_which_of_its_parts_changed_and_is_renewed_with_its_schedules(
    referred,
):
    old = scheduled()
    reference = loaded_log(old, 1) if referred else None

    def asked(rig, **more):
        return dehyst.drift(old, loaded_log(rig, 2), reference=reference, **more)

    assert asked(old).status == "unchanged"
    worn = asked(scheduled(stop=0.8), refit=True)
    assert worn.status == "drifted" and worn.change("hysteresis").estimate == pytest.approx(
        -20.0, abs=1.5
    )
    assert asked(scheduled(line=1.1)).change("gain").drifted
    assert worn.acceptance.accepted
    assert {schedule.name for schedule in worn.model.outside} <= {"load", "mean_pressure"}
    log = loaded_log(scheduled(stop=0.8), 5)
    errors = [dehyst.drift(model, log).logs[0].error_percent for model in (worn.model, old)]
    assert errors[0] < 0.5 * errors[1]


def test_parts_that_are_ignored_are_measured_and_do_not_count(new):
    model, log = new
    later = cycling_log(5, 24, {**PURE, "offset": 0.5}, minor=True)
    found = dehyst.drift(model, later, reference=log, ignore=["offset"])
    assert found.status == "unchanged"
    assert (
        found.change("offset").estimate == pytest.approx(0.5, abs=0.05)
        and not found.change("offset").drifted
    )


# --- hostile input ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "settings",
    [
        {"false_alarm": 0.0},
        {"false_alarm": 0.5},
        {"false_alarm": float("nan")},
        {"least": -1.0},
        {"ignore": "offset"},
    ],
)
def test_settings_outside_their_range_are_refused(new, settings):
    with pytest.raises(ParameterError):
        dehyst.drift(new[0], cycling_log(1, 10), **settings)


@pytest.mark.parametrize("records", [[], [1], "log.csv"])
def test_what_is_no_recording_is_refused(new, records):
    with pytest.raises(ParameterError, match="Recording"):
        dehyst.drift(new[0], records)


@pytest.mark.parametrize(
    "provenance",
    [
        {"logs": 3, "test": {"rmse_percent": "1"}, "settings": []},
        {
            "logs": [None, {"sha256": None}],
            "train": {"rmse_percent": -1},
            "settings": {"n": "many", "eps": None},
        },
        {"settings": {"train_fraction": "half", "n": -5}, "identified_family": ["pi"]},
    ],
)
def test_provenance_written_by_hand_is_no_trap(new, provenance):
    model, _ = new
    hostile = model.with_card(dataclasses.replace(model.card, provenance=provenance))
    found = dehyst.drift(hostile, cycling_log(3, 24, PURE, minor=True), refit=True)
    assert found.status in ("unchanged", "drifted")
    assert found.acceptance.reason


def test_a_log_without_time_stamps_is_compared_without_creep(new):
    later = dataclasses.replace(cycling_log(4, 24, PURE, minor=True), time=None)
    found = dehyst.drift(new[0], later)
    assert found.status == "unchanged"
    assert "creep" not in {change.part for change in found.logs[0].changes}


def test_gaps_cost_cycles_and_nothing_else(new):
    model, log = new
    later = cycling_log(4, 24, PURE, minor=True)
    broken = dataclasses.replace(later, breaks=(700, 1300))
    found = dehyst.drift(model, broken, reference=log)
    assert found.status == "unchanged"
    assert found.logs[0].cycles < dehyst.drift(model, later, reference=log).logs[0].cycles


def test_a_rest_of_a_year_within_a_log_costs_no_memory(new):
    model, log = new
    later = cycling_log(4, 24, PURE, minor=True)
    time = np.where(np.arange(len(later)) < 900, later.time, later.time + 3e7)
    found = dehyst.drift(model, dataclasses.replace(later, time=time), reference=log)
    assert found.status == "unchanged"


def signals():
    k = np.arange(400.0)
    wave = np.sin(k / 6.0)
    yield "rising", k / 400.0 * 4.0 - 2.0, k
    yield "two values", np.where(wave > 0, 2.0, -2.0), np.where(wave > 0, 14.0, -14.0)
    yield "huge", 2.0 * wave, 1e90 * wave
    yield "constant output", 2.0 * wave, np.full(400, 3.0)
    yield "falling", 2.0 * wave, -14.0 * wave
    yield "four samples", 2.0 * wave[:4], wave[:4]
    yield "without a flaw", 2.0 * wave, 14.0 * wave


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "x", "y"), list(signals()), ids=lambda v: v if isinstance(v, str) else ""
)
@pytest.mark.filterwarnings("error")
def test_strange_logs_get_a_verdict_and_no_warning_of_numpy(new, name, x, y):
    log = dehyst.Recording(
        input=x, output=y, time=0.1 * np.arange(x.size), input_unit="bar", output_unit="deg"
    )
    for model in (new[0], direct(card=new[0].card)):
        found = dehyst.drift(model, log, refit=True)
        assert found.status in ("drifted", "not comparable", "unchanged", "cannot tell")
        assert found.verdict and found.acceptance.reason
        dehyst.drift(model, [log, new[1]])


@settings(max_examples=40, deadline=None)
@given(
    st.integers(4, 40),
    st.floats(0.0, 0.03),
    st.floats(0.0, 0.05),
    st.integers(0, 2**32 - 1),
    st.floats(1e-3, 1e3),
)
def test_cycles_are_counted_whatever_noise_unevenness_and_scale(count, noise, uneven, seed, scale):
    random = np.random.default_rng(seed)
    sizes = 1.0 + uneven * random.uniform(-1.0, 1.0, count + 2)
    phase = np.arange((count + 2) * 40) / 40.0
    x = scale * (
        sizes[phase.astype(int)] * np.cos(2 * np.pi * phase)
        + noise * random.standard_normal(phase.size)
    )
    found = grouping.cycles_of(x, [slice(0, x.size)], float(x.min()), float(x.max()))
    assert count - 1 <= len(found) <= count + 1
    assert all(a.end == b.begin for a, b in itertools.pairwise(found))
    groups = grouping.groups_of(found, 6)
    assert sum(map(len, groups)) == len(found) and len(groups) <= 6


def test_the_test_of_groups_is_students(monkeypatch):
    """Oracle: scipy.stats."""
    from scipy import stats

    values = np.random.default_rng(0).normal(0.4, 1.0, 9)
    other = np.random.default_rng(1).normal(0.0, 1.0, 7)
    found = grouping.contrast(values)
    assert found.p_value(0.0) == pytest.approx(stats.ttest_1samp(values, 0.0).pvalue)
    assert found.interval(0.95) == pytest.approx(
        stats.ttest_1samp(values, 0.0).confidence_interval(0.95)
    )
    two = grouping.contrast(values, other)
    assert two.estimate / two.error == pytest.approx(
        stats.ttest_ind(values, other, equal_var=False).statistic
    )
    assert two.freedom == 6 <= stats.ttest_ind(values, other, equal_var=False).df


def test_intervals_of_slopes_hold_the_truth_as_often_as_they_say():
    random, held = np.random.default_rng(5), 0
    k = np.arange(60.0)
    for _ in range(100):
        noise = np.convolve(random.standard_normal(64), [1.0, 0.6, 0.3, 0.2, 0.1], "valid")
        _, low, high = grouping.trend(k, 0.02 * k + noise, 0.95)
        held += low <= 0.02 <= high
    assert held >= 88


# --- unchanged only where the figures allow it --------------------------------------------------------------


def estimates(draw, groups):
    parts = ("offset", "gain", "hysteresis")
    numbers = st.floats(-3.0, 3.0)
    values = np.array(draw(st.lists(numbers, min_size=3 * groups, max_size=3 * groups))).reshape(
        groups, 3
    )
    sizes = st.floats(1e-4, 30.0)
    rest, counted = (
        np.array(draw(st.lists(sizes, min_size=groups, max_size=groups))) for _ in range(2)
    )
    motion = np.full(groups, 1.0)
    scales = np.array([draw(st.floats(1e-3, 30.0)) for _ in parts])
    return taken.Estimates(parts, 0.02 * values, rest, counted, None, counted, scales, motion)


@pytest.mark.slow
@settings(max_examples=300, deadline=None)
@given(
    st.data(),
    st.integers(4, 12),
    st.booleans(),
    st.booleans(),
    st.floats(0.5, 1.0),
    st.floats(1.0, 3.0),
)
def test_a_log_in_which_the_error_doubled_is_never_called_unchanged(
    data, groups, referred, alike, quiet, grown
):
    """Whatever else the groups say: by construction of the errors, not of the test."""
    then = estimates(data.draw, groups)
    now = dataclasses.replace(estimates(data.draw, groups), values=quiet * then.values)
    before = float(np.sqrt(np.mean(then.counted**2)))
    error = now.counted * 2.0 * grown * before / float(np.sqrt(np.mean(now.counted**2)))
    now = dataclasses.replace(now, error=error, counted=error)
    scale = taken.Scale((0.0, 1.0), (0.0, 50.0), None)  # percent of range
    rule = testing.Rule(0.001, None, before)
    changes = testing.changes_of(now, then if referred else None, alike, scale, rule, "deg")
    size = float(np.sqrt(np.mean(error**2)))
    status = testing.status_of(changes, size, rule)
    assert (
        status != "unchanged" or float(np.exp(np.mean(np.log(error)))) < testing.POLICY.least_change
    )
    if status == "unchanged":
        assert all(change.detectable_percent <= testing.POLICY.bound for change in changes[:3])


@settings(max_examples=25, deadline=None)
@given(
    st.integers(0, 10_000), st.integers(6, 16), st.floats(0.6, 1.3), st.floats(0.93, 1.07), st.floats(-0.4, 0.4),
    st.floats(0.5, 4.0), st.booleans(),
)  # fmt: skip
def test_a_worn_rig_is_called_unchanged_only_with_figures_that_say_so(
    new, seed, cycles, loop, gain, offset, noise, referred
):
    model, log = new
    worn = {**PURE, "hysteresis": loop, "gain": gain, "offset": offset}
    found = dehyst.drift(
        model,
        cycling_log(seed, cycles, worn, minor=True, noise=noise),
        reference=log if referred else None,
    )
    entry = found.logs[0]
    if found.status == "unchanged":
        assert entry.error_percent < 2.0 * found.identified_percent
        told = [change for change in entry.changes if change.detectable_percent is not None]
        assert len(told) >= 3 and all(
            abs(change.effect_percent) <= change.detectable_percent <= 1.0 for change in told
        )
        assert found.change("error").high < 100.0
    elif found.status == "cannot tell":
        assert not any(change.drifted for change in entry.changes)
        assert not all(change.resolved for change in entry.changes)
        assert "dehyst design --for drift" in found.verdict


def designed_log(seed, wear=None, *, plan=None, name=""):
    """Log of the rig, with creep, moved as `dehyst design` says: nine cycles, of very different sizes."""
    plan = plan or dehyst.design_excitation(-2.0, 2.0, rate=2.5, time_limit=360.0, unit="bar")
    t, x, _ = plan.signal(0.05)
    return logged(
        np.random.default_rng(seed),
        x,
        t,
        {"hysteresis": 2.0, "creep": 4.0, **(wear or {})},
        name=name,
    )


@pytest.fixture(scope="module")
def poor():
    """A model whose own error is 3 % of range: it lacks the creep of its rig."""
    log = designed_log(0, name="new")
    return identified(log), log


@pytest.mark.parametrize(
    "wear", [{}, {"hysteresis": 1.6, "gain": 1.05}], ids=["unchanged", "changed"]
)
def test_what_a_log_of_few_uneven_cycles_cannot_resolve_is_not_told_and_nothing_is_identified_anew(
    poor, wear
):
    model, _ = poor
    found = dehyst.drift(model, designed_log(1, wear), refit=True)
    assert found.status == "cannot tell"
    assert found.change("gain").detectable > 20.0  # percent: no power
    assert re.search(r"a change of .* may have stayed hidden", found.verdict)
    assert found.model is model and not found.acceptance.accepted and found.acceptance.model is None
    assert "cannot be told" in found.acceptance.reason
    assert found.motion["low"] == pytest.approx(-2.0, abs=0.05) and found.motion["unit"] == "bar"


@pytest.mark.slow
def test_the_motion_designed_for_drift_tells(poor):
    """Closed loop: the log made by the motion is accepted with all its cycles; same rig, unchanged; worn, drifted."""
    model, _ = poor
    motion = dehyst.drift(model, designed_log(1)).motion
    limits = {"rate": motion["rate"], "unit": motion["unit"], "time_limit": 900.0}
    plan = dehyst.design.design_drift_motion(motion["low"], motion["high"], **limits)
    reference, same = (designed_log(k, plan=plan, name=f"log {k}") for k in (2, 3))
    entry = dehyst.drift(model, same, reference=reference).logs[0]
    assert POLICY.groups == MOST_GROUPS
    assert entry.cycles == entry.tested == CYCLES and entry.status == "unchanged"
    told = {change.part: change for change in entry.changes}
    assert told["gain"].detectable < 1.0 and told["hysteresis"].detectable < 3.0
    worn = designed_log(4, {"hysteresis": 1.6, "gain": 1.05}, plan=plan)
    found = dehyst.drift(model, worn, reference=reference)
    assert found.status == "drifted" and {"hysteresis", "gain"} <= counted(found)


def test_an_ignored_offset_may_double_the_error(new):
    model, log = new
    later = cycling_log(5, 24, {**PURE, "offset": 0.5}, minor=True)
    found = dehyst.drift(model, later, reference=log, ignore=["offset"])
    assert (
        found.status == "unchanged" and found.logs[0].error_percent > 2.0 * found.identified_percent
    )
    noisy = cycling_log(5, 24, {**PURE, "offset": 0.5}, minor=True, noise=6.0)
    assert dehyst.drift(model, noisy, reference=log, ignore=["offset"]).status == "drifted"
    assert (
        dehyst.drift(model, noisy, reference=log, ignore=["offset", "rest"]).status == "unchanged"
    )


def test_without_a_known_error_a_model_that_misses_by_more_than_a_change_is_no_proof():
    x = np.sin(np.linspace(0.0, 40 * np.pi, 4001))
    model = dehyst.PrandtlIshlinskii([0.0, 0.5], [1.0, 1.0])
    noise = np.random.default_rng(0).standard_normal(x.size)
    found = [
        dehyst.drift(model, dehyst.Recording(input=x, output=model.simulate(x) + size * noise))
        for size in (0.01, 0.1)
    ]
    assert [each.status for each in found] == ["unchanged", "cannot tell"]
    assert "nobody knows what the error was" in found[1].verdict


def test_an_error_that_grew_counts_though_no_part_alone_does(new):
    """Another shape of error in every cycle: no part has one sign, so that the means are zero, and the error is not."""
    model, log = new
    signs = {
        **PURE,
        "offset": lambda s: 0.6 * np.sign(np.sin(2 * np.pi * 6.5 * s)),
        "gain": lambda s: 1.0 + 0.0 * s,
    }
    found = dehyst.drift(model, cycling_log(3, 24, signs, minor=True), reference=log)
    assert (
        found.status == "drifted"
        and found.change("error").drifted
        and not found.change("offset").drifted
    )


@pytest.mark.slow
def test_an_accepted_model_is_as_good_as_one_identified_from_all_of_the_new_logs(new):
    model, log = new
    wear = {**PURE, "hysteresis": 0.8, "gain": 1.05}
    later = [cycling_log(k, 16, wear, minor=True, name=f"later {k}") for k in (1, 2)]
    found = dehyst.drift(model, later, reference=log, refit=True)
    assert (
        found.acceptance.accepted
        and found.model.card.provenance["settings"]["train_fraction"] == 1.0
    )
    assert found.model.card.provenance["test"]["rmse_percent"] == pytest.approx(
        found.acceptance.new_percent, rel=0.5
    )
    fresh = dehyst.identify(later, model.family, n=30, train_fraction=1.0).model
    unseen = cycling_log(3, 16, wear, minor=True)
    errors = [dehyst.drift(m, unseen).logs[0].error_percent for m in (found.model, fresh)]
    assert errors[0] <= 1.05 * errors[1]


def test_what_is_no_model_of_identify_is_refused(new):
    for model in ("model.json", Preisach.example()):
        with pytest.raises(ParameterError, match=r"dehyst\.identify"):
            dehyst.drift(model, new[1])


# --- a change within a log ----------------------------------------------------------------------------------


def test_a_sensor_set_anew_within_a_log_is_drift_and_nothing_of_the_log_is_left_out(new):
    """Half of the cycles as they were, half shifted: their scatter hid the shift: "cannot tell"."""
    model, log = new
    half = len(log) // 2
    later = cycling_log(7, 24, PURE, minor=True, name="later")
    moved = np.where(np.arange(len(later)) < half, 0.0, 0.3 * np.ptp(later.output))
    found = dehyst.drift(
        model, dataclasses.replace(later, output=later.output + moved), reference=log
    )
    assert found.status == "drifted"
    assert re.search(
        r"^drifted \(against new\): the output '\w+' of later changes at sample \d+ .*error",
        found.verdict,
    )
    [told] = [finding for finding in found.logs[0].findings if finding.code == "two-actuators"]
    assert "left out" not in told.message and "Repair it" in told.message
    assert found.logs[0].recording.left_out == ()
