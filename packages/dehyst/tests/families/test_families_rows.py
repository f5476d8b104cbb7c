"""Rows of elements: columns that rise, one program, a choice within the training, models that are what was fitted."""

import dataclasses
import itertools
import json
import sys

import numpy as np
import pytest
from scipy.optimize import lsq_linear

import dehyst
from dehyst import Recording, families, identification
from dehyst.errors import IdentificationError, ParameterError
from dehyst.families import ROW_NAMES, Stretch, Training
from dehyst.families import _choice as choice
from dehyst.families._columns import GROUPS, Columns, Pace, columns_of
from dehyst.families._elements import Element, ElementModel
from dehyst.families._program import (
    BLOCKS,
    LEAST,
    LEAST_OF_MAP,
    Program,
    RampRegularisation,
    block_sums,
)
from dehyst.families._rows import candidates
from dehyst.families._table import ROWS as TABLE
from dehyst.families._table import TERMS, TIMED
from family_checks import ARM, DAMPER, log, measured, wander
from places import ROOT

sys.path.insert(0, str(ROOT / "benchmarks"))
import rows as benchmark

PACE = Pace(0.01, 20.0, (0.01, 0.03, 0.1))
EVERY = tuple(range(BLOCKS))
LIGHT = RampRegularisation(0.003, 0.001)
SOME = ("play", "lag", "lead", "creep", "relax-by-place", "rate")


def bank(columns: Columns, x, step=0.01, start="rest"):
    """Columns along a signal."""
    cells = ElementModel(columns.cells, start=start)
    dt = np.full(x.size, step) if cells.rate_dependent else None
    return columns.values(cells.columns(x, dt, cells.before(float(x[0])))[0])


def training(x, y, step=0.01, orientation="counter-clockwise"):
    """A training of one stretch that is scaled already."""
    dt = None if step is None else np.concatenate([[0.0], np.full(x.size - 1, step)])
    stretch = Stretch(x, y, dt, np.ones(x.size, dtype=bool))
    return Training((stretch,), families.Scaling(), orientation, period=step or 0.0)


def record(model, samples=4000, noise=0.002, seed=4, step=0.01):
    x = wander(samples, seed)
    time = step * np.arange(samples)
    y = model.simulate(x, time)
    return Recording(
        input=x,
        output=y + noise * np.ptp(y) * np.random.default_rng(seed).standard_normal(samples),
        time=time,
    )


@pytest.mark.parametrize("group", GROUPS)
def test_every_column_rises_with_the_present_sample_whatever_came_before(group):
    columns = columns_of((group,), 8, PACE)
    rng = np.random.default_rng(1)
    cells = ElementModel(columns.cells)
    dt = np.array([0.01]) if cells.rate_dependent else None
    for past in range(6):
        x = wander(300, past) if past else np.full(300, 0.3)
        steps = np.full(300, 0.01) if cells.rate_dependent else None
        memory = cells.columns(x, steps, cells.rest(float(x[0])))[1]
        now = np.sort(rng.uniform(-1.3, 1.3, 60))
        values = np.concatenate(
            [columns.values(cells.columns(np.array([v]), dt, memory)[0]) for v in now]
        )
        assert np.diff(values, axis=0).min() > -1e-12
        assert np.ptp(values[:, columns.group == "x"].sum(1)) > 1.0


@pytest.mark.parametrize("group", GROUPS)
def test_the_elements_of_weights_are_the_weighted_columns(group):
    columns = columns_of((group,), 8, PACE)
    weight = np.random.default_rng(2).uniform(0.0, 1.0, columns.cell.size) * (
        np.arange(columns.cell.size) % 3 != 1
    )
    weight[columns.group == "x"] += LEAST
    model = ElementModel(columns.elements(weight), 0.3, period=PACE.period, start="rest")
    x = wander(1500, 3)
    wanted = 0.3 + bank(columns, x) @ weight
    np.testing.assert_allclose(
        model.simulate(x, 0.01 * np.arange(x.size)), wanted, rtol=0.0, atol=1e-9
    )
    if group == "product":  # certain to settle only where the products are small
        weight[columns.group == "product"] *= 1e-5
        model = ElementModel(columns.elements(weight), 0.3, period=PACE.period, start="rest")
    assert not model.no_inverse
    assert model.least_slope >= 0.99 * LEAST - 1e-3 * (group == "product")


def test_products_stand_in_chains_each_reading_the_lag_of_the_next():
    columns = columns_of(("product",), 1, PACE)
    plus = (columns.group == "product") & (columns.gain > 0.0)
    made = columns.elements(
        np.where(columns.group == "x", 1.0, 0.0) + np.where(plus, np.arange(plus.size), 0.0)
    )
    products = [(q, after) for q, after in itertools.pairwise(made) if q.kind == "product"]
    assert len(products) == 21 and len(made) <= 1 + 26
    pairs = {tuple(sorted((q.time, after.time))) for q, after in products}
    assert len(pairs) == 21  # each two lags once


def volterra(samples=9000, step=0.02):
    """A rig whose fast lag counts by where a slow one is."""
    x = wander(samples, 11)
    lags = np.zeros((2, samples))
    for k in range(1, samples):
        lags[:, k] = lags[:, k - 1] + step / np.array([0.3, 6.0]) * (x[k - 1] - lags[:, k - 1])
    y = x + 0.3 * lags[0] + 0.6 * lags[0] * lags[1]
    noise = 0.002 * np.random.default_rng(0).standard_normal(samples)
    return Recording(input=x, output=y + noise, time=step * np.arange(samples))


@pytest.mark.slow
def test_products_of_lags_are_taken_where_a_rig_has_them_and_for_simulation_alone():
    rig = volterra()
    simulated, compensated = (
        dehyst.identify(rig, purpose=purpose) for purpose in ("simulate", "compensate")
    )
    assert simulated.family.endswith("-volterra") and "product" in simulated.model.kinds
    assert simulated.test.rmse_percent < 0.3 * compensated.test.rmse_percent
    assert "product" not in compensated.model.kinds and not compensated.model.no_inverse
    assert not {"high-inverse-gain", "inverse-useless"} & {f.code for f in simulated.warnings}


def test_products_of_lags_have_to_beat_the_others_clearly():
    rows = {row.name: row for row in TABLE}
    with_, without = rows["full-volterra"].sums[0], rows["full-sum"].sums[0]
    assert with_.worth < without.worth == 1.0
    ordered = sorted(
        (
            choice.ScoredSum(one, False, LIGHT, score)
            for one, score in ((with_, 0.9), (without, 1.0))
        ),
        key=choice._demerit,
    )
    assert ordered[0].sum is without


def test_weights_of_zero_leave_no_element():
    columns = columns_of(("play", "creep"), 8, PACE)
    weight = np.where(columns.group == "x", 0.1, 0.0)
    assert [q.kind for q in columns.elements(weight)] == ["input"]


@pytest.mark.parametrize("weighted", [False, True], ids=["alike", "weighted"])
@pytest.mark.parametrize("blocks", [EVERY, (0, 1, 2), (0, 2, 3, 4)])
def test_the_program_finds_what_bounded_least_squares_on_its_rows_finds(blocks, weighted):
    columns = columns_of(("play", "lag", "creep"), 8, PACE)
    x = wander(1200, 5)
    a = bank(columns, x)
    y = 0.1 + a[:, 10] + 0.3 * a[:, 40] + 0.01 * np.random.default_rng(0).standard_normal(x.size)
    rng = np.random.default_rng(1)
    # Of rows in any order: a fold is not one stretch of them.
    block = rng.permutation(np.arange(x.size) * BLOCKS // x.size)
    weight = np.ones(x.size)
    if weighted:
        weight = rng.uniform(0.0, 3.0, x.size) * (rng.random(x.size) > 0.2)
    least = np.where(columns.group == "x", LEAST, 0.0)
    strong = RampRegularisation(0.05, 0.03)
    sums = block_sums(a, y, block, least, columns.neighbours, 4, weight)
    found = Program(sums, np.arange(a.shape[1]), False).solve(blocks, strong)
    seen = np.isin(block, blocks)
    root = np.sqrt(weight[seen])[:, None]
    n, p = float(np.sum(weight[seen])), a.shape[1]
    differences = np.zeros((len(columns.neighbours), 1 + p))
    for row, (i, j) in zip(differences, columns.neighbours, strict=True):
        row[1 + i], row[1 + j] = 1.0, -1.0
    ridge = np.hstack([np.zeros((p, 1)), np.eye(p)])
    system = np.vstack(
        [
            root * np.hstack([np.ones((root.size, 1)), a[seen]]),
            np.sqrt(n) * strong.lam * differences,
            np.sqrt(n) * strong.ridge * ridge,
        ]
    )
    target = np.concatenate([root[:, 0] * y[seen], np.zeros(len(system) - root.size)])
    oracle = lsq_linear(
        system, target, (np.concatenate([[-np.inf], least]), np.inf), method="bvls", tol=1e-14
    )
    np.testing.assert_allclose(np.concatenate([[found.offset], found.weight]), oracle.x, atol=2e-6)
    assert found.kkt < 1e-9


def test_a_map_that_bends_is_found_again():
    columns = columns_of(("play",), 8, PACE)
    x = wander(3000, 6)
    a = bank(columns, x)
    u = a[:, columns.group == "x"].sum(1) * 0.4 + a[:, 21] + 0.5 * a[:, 27]
    y = np.sinh(1.5 * u)
    block = np.arange(x.size) * BLOCKS // x.size
    least = np.where(columns.group == "x", LEAST, 0.0)
    sums = block_sums(a, y, block, least, columns.neighbours, 10, np.ones(x.size))
    every = np.arange(a.shape[1])
    plain, mapped = (
        Program(sums, every, with_map).solve(EVERY, LIGHT) for with_map in (False, True)
    )
    miss = [
        float(np.sqrt(np.mean((f.outputs(a @ f.weight) - y) ** 2)) / np.ptp(y))
        for f in (plain, mapped)
    ]
    assert miss[1] < 0.006
    assert 4.0 * miss[1] < miss[0]
    slopes = np.diff(mapped.inner) / np.diff(mapped.outer)
    assert slopes.min() >= LEAST_OF_MAP - 1e-9
    assert abs(np.average(slopes, weights=np.diff(mapped.outer)) - 1.0) < 0.01


def test_rows_are_thinned_but_elements_see_every_sample(monkeypatch):
    x = wander(3000, 7)
    monkeypatch.setattr(choice, "MOST_ROWS", 1000)
    shop = choice.Workshop(training(x, 0.5 * x), "forward", SOME)
    stretches, rows = shop.bank.places.T
    assert not stretches.any() and np.all(np.diff(rows) > 0)
    assert 500 < rows.size <= 1000 and rows[-1] - rows[0] > 2900
    cells = ElementModel(shop.columns.cells, start=shop.start)
    memory = cells.before(float(x[0]))
    steps = np.concatenate([[0.0], np.full(x.size - 1, 0.01)])
    every = shop.columns.values(cells.columns(x, steps, memory)[0])
    np.testing.assert_allclose(shop.bank.values, every[rows], rtol=0.0, atol=1e-12)
    np.testing.assert_array_equal(shop.bank.output, 0.5 * x[rows])


def test_a_score_is_that_of_the_errors_on_ten_folds_each_fitted_without_them():
    """By bounded least squares on the rows of the other folds."""
    x = wander(2500, 8)
    y = 0.4 * x + 0.5 * x**3 + 0.02 * np.random.default_rng(0).standard_normal(x.size)
    shop = choice.Workshop(training(x, y), "forward", ("play",))
    one = next(row.sums[0] for row in TABLE if row.sums[0].groups == ("play",))
    strong = RampRegularisation(0.05, 0.03)
    bank_, p = shop.bank, shop.columns.cell.size
    assert bank_.weight.mean() == pytest.approx(1.0) and bank_.weight.max() > 1.0
    differences = np.zeros((len(shop.columns.neighbours), 1 + p))
    for row, (i, j) in zip(differences, shop.columns.neighbours, strict=True):
        row[1 + i], row[1 + j] = 1.0, -1.0
    ridge = np.hstack([np.zeros((p, 1)), np.eye(p)])
    columns = np.hstack([np.ones((bank_.output.size, 1)), bank_.values])
    lower = np.concatenate([[-np.inf], np.where(shop.columns.group == "x", LEAST, 0.0)])
    errors = []
    for left_out in [fold == number for fold in bank_.folds for number in range(BLOCKS)]:
        root = np.sqrt(bank_.weight[~left_out])
        penalty = np.linalg.norm(root) * np.vstack([strong.lam * differences, strong.ridge * ridge])
        system = np.vstack([root[:, None] * columns[~left_out], penalty])
        target = np.append(root * bank_.output[~left_out], np.zeros(len(penalty)))
        u = lsq_linear(system, target, (lower, np.inf), method="bvls", tol=1e-14).x
        miss = columns[left_out] @ u - bank_.output[left_out]
        errors.append(np.sqrt(np.average(miss**2, weights=bank_.weight[left_out])))
    assert np.ptp(errors) > 0.0
    assert shop.candidate(one, False, strong).score == pytest.approx(
        np.sqrt(np.mean(errors[:BLOCKS]) * np.mean(errors[BLOCKS:])), rel=1e-5
    )


@pytest.mark.slow
def test_a_model_of_a_thinned_log_runs_at_the_period_of_the_log():
    """An exported block takes this period unless told another."""
    x, step = wander(60_000, 3), 0.001
    y = ElementModel((Element("play", 0.2), Element("creep", 0.0, 0.5))).simulate(
        x, step * np.arange(x.size)
    )
    fit = dehyst.identify(Recording(input=x, output=y, time=step * np.arange(x.size)), "creep-pi")
    assert fit.model.period == pytest.approx(step)
    assert fit.test.rmse_percent < 0.5


def test_few_turns_mean_few_groups_and_no_stamps_no_time():
    def names(x, step):
        return [one.name for one in candidates(training(x, x, step))]

    ramp = np.linspace(-1.0, 1.0, 400)
    loop = np.concatenate([ramp, ramp[::-1], ramp])
    assert names(ramp, 0.01) == ["play-sum"]
    assert [one.maps for one in candidates(training(ramp, ramp))] == [(True,)]
    assert names(loop, 0.01) == ["play-sum", "stop-sum", "generalised-pi", "creep-pi"]
    assert set(names(np.tile(loop, 2), 0.01)) == {
        row.name for row in TABLE if row.chosen in ("always", "many")
    }
    for x in (loop, np.tile(loop, 2)):
        groups = {group for one in candidates(training(x, x, None)) for group in one.groups}
        assert groups and not groups & TIMED


def test_a_row_of_time_without_stamps_says_which_to_take():
    x = wander(800)
    with pytest.raises(IdentificationError, match="take --family play-sum"):
        dehyst.identify(Recording(input=x, output=x), "creep-pi")


def test_the_table_is_the_one_place_where_rows_are_named():
    assert ("elements", *(row.name for row in TABLE)) == ROW_NAMES
    assert len({row.title for row in TABLE}) == len(TABLE)
    assert set(TERMS) == set(GROUPS) and set(TERMS) > TIMED
    assert {group for row in TABLE for one in row.sums for group in one.groups} <= set(TERMS)
    assert all(one.name == row.name for row in TABLE for one in row.sums)


def test_a_handful_of_samples_is_refused_with_a_cure():
    x = wander(19)
    with pytest.raises(IdentificationError, match="20 or more"):
        choice.best_sum(training(x, x), TABLE[0].sums)


def test_a_name_that_is_no_row_is_refused_with_the_rows():
    with pytest.raises(ParameterError, match="mixed-sum"):
        dehyst.identify(Recording(input=wander(), output=wander()), "mixed-sums")


LAGGING = ElementModel(
    (
        Element("input", weight=0.5),
        Element("play", 0.2, weight=0.4),
        Element("creep", 0.0, 1.5, 0.3),
    ),
    start="zero",
)
DAMPED = ElementModel(
    (
        Element("input", weight=0.4),
        Element("stop", 0.15, weight=0.5),
        Element("relax", 0.0, 0.03, 1.0, ((-1.0, -0.01, 0.01, 1.0), (-0.2, -0.2, 0.2, 0.2))),
    ),
    start="zero",
)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("model", "most"), [(LAGGING, 0.5), (DAMPED, 2.0)], ids=["creep", "damper"]
)
def test_what_has_creep_or_dampers_is_followed_on_held_out_loops(model, most):
    log_of = record(model)
    fit = dehyst.identify(log_of, "elements")
    assert fit.test.rmse_percent < most
    assert fit.model.family in ROW_NAMES and not fit.model.no_inverse
    named = dehyst.identify(log_of, "maxwell-slip" if model is DAMPED else "creep-pi")
    assert named.test.rmse_percent < most
    without = dehyst.identify(log_of, "generalised-pi")
    assert without.test.rmse_percent > 2.0 * fit.test.rmse_percent
    assert dehyst.identify(log_of, "elements").model.parameters() == fit.model.parameters()


@pytest.mark.slow
@pytest.mark.parametrize("name", ROW_NAMES)
def test_each_row_is_fitted_by_its_name_saved_and_played(name, tmp_path):
    log_of = record(DAMPED if name == "maxwell-slip" else LAGGING, samples=2500)
    fit = dehyst.identify(log_of, name)
    assert fit.family == fit.model.family and (fit.family == name or name == "elements")
    again = dehyst.load(fit.model.save(tmp_path / "row.json"))
    assert again.family == fit.model.family
    x, time = log_of.input[:600], log_of.time[:600]
    y = fit.model.simulate(x, time)
    assert np.array_equal(again.simulate(x, time), y)
    assert np.max(np.abs(again.inverse().simulate(y, time) - x)) < 1e-8 * np.ptp(x)


def test_an_inverse_row_is_scored_by_what_its_solution_misses():
    x = wander(2000, 9)
    y = DAMPED.simulate(x, 0.01 * np.arange(x.size))
    y = y / np.abs(y).max()
    shop = choice.Workshop(training(x, y, orientation="clockwise"), "inverse", ("stop", "relax"))
    one = next(row.sums[0] for row in TABLE if row.name == "inverse-stop")
    candidate = shop.candidate(one, False, LIGHT)
    model = shop.model(candidate, False).model
    dt = np.concatenate([[0.0], np.full(x.size - 1, 0.01)])
    forward = dataclasses.replace(model, direction="forward")
    solved = forward.run_inverse(x, dt, forward.before(float(y[0])))[0]
    assert 0.3 < candidate.score / np.sqrt(np.mean((solved - y) ** 2)) < 3.0


@pytest.mark.slow
def test_a_comparison_takes_rows_by_name_and_the_chosen_one_by_itself():
    log_of = record(LAGGING, samples=1500)
    found = dehyst.compare(log_of, ["pi", "elements", "creep-pi"])
    assert {entry.family for entry in found.entries} == {"pi", "elements", "creep-pi"}
    assert found["elements"].error_percent < found["pi"].error_percent
    assert found["elements"].title == f"best row of elements: {found['elements'].model.family}"
    assert found["creep-pi"].title == "Prandtl-Ishlinskii with creep"
    assert set(ROW_NAMES) < set(identification.all_names())


TIMELESS = [
    row.name for row in TABLE if not row.sums[-1].timed and row.sums[-1].direction == "forward"
]


def timeless(name, seed=1):
    """A model of a row without time with many columns of random weight."""
    one = next(row for row in TABLE if row.name == name).sums[-1]
    columns, rng = columns_of(one.groups, 4, None), np.random.default_rng(seed)
    weight = rng.exponential(size=columns.cell.size) * (rng.random(columns.cell.size) > 0.5)
    weight /= weight.sum()
    return ElementModel(
        columns.elements(weight + np.where(columns.group == "x", 0.2, 0.0)), row=name
    )


@pytest.mark.parametrize("name", TIMELESS)
def test_without_time_only_turning_points_count_and_passed_ones_are_wiped_out(name):
    model, turns = timeless(name), np.array([0.0, 0.8, -0.5, 0.3, -0.2, 0.3, -0.5, 0.8])
    y = model.simulate(turns)
    assert abs(y[3] - y[5]) < 1e-14 and abs(y[2] - y[6]) < 1e-14 and abs(y[1] - y[7]) < 1e-14
    fine = np.interp(np.linspace(0.0, 7.0, 7001), np.arange(8), turns)
    assert np.max(np.abs(model.simulate(fine)[::1000] - y)) < 1e-13


@pytest.mark.parametrize("name", TIMELESS)
def test_minor_loops_between_the_same_inputs_are_congruent(name):
    model, shapes, levels = timeless(name), [], []
    loop = np.concatenate([np.linspace(-0.2, 0.4, 31), np.linspace(0.4, -0.2, 31)])
    for past in ([-1.0, -0.2], [1.0, -0.2], [-1.0, 0.9, -0.8, 0.6, -0.2]):
        y = model.simulate(np.concatenate([past, np.tile(loop, 2)]))[-62:]
        shapes.append(y - y[0])
        levels.append(y[0])
    assert np.ptp(levels) > 0.01
    assert np.max(np.abs(np.diff(shapes, axis=0))) < 1e-14


def test_curves_of_stops_after_a_reversal_are_the_virgin_curve_doubled():
    """Masing's rule: from a turn at a to a - 2 b the force falls by twice what the virgin curve rises from 0 to b."""
    model = ElementModel(
        (Element("input", weight=0.3), *(Element("stop", r, weight=1.0) for r in (0.05, 0.2, 0.5)))
    )
    b = np.linspace(0.0, 0.8, 81)
    virgin = model.simulate(b)
    down = model.simulate(np.concatenate([b, 0.8 - 2.0 * b]))[81:]
    assert np.max(np.abs((virgin[-1] - down) - 2.0 * virgin)) < 1e-14
    assert abs(model.simulate(np.linspace(0.0, 10.0, 101))[-1] - (3.0 + 0.75)) < 1e-13


@pytest.mark.parametrize("seed", range(5))
def test_closed_loops_of_sliders_and_dampers_cost_work(seed):
    turns = np.random.default_rng(seed).uniform(-1.0, 1.0, 6)
    way = np.concatenate([[0.0], turns, turns, turns[:1]])
    q = np.interp(np.linspace(0.0, way.size - 1.0, 40 * way.size - 39), np.arange(way.size), way)
    f = families.example("maxwell-slip").simulate(q, 0.01 * np.arange(q.size))
    second = slice(40 * (1 + turns.size), 40 * (1 + 2 * turns.size) + 1)
    assert float(np.sum(f[second][1:] * np.diff(q[second]))) > 0.0


def test_loops_of_viscous_plays_widen_with_the_rate():
    model = families.example("rate-dependent-pi")
    x = np.sin(np.linspace(0.0, 6.0 * np.pi, 3000))
    areas = [
        abs(np.trapezoid(model.simulate(x, np.linspace(0.0, span, 3000))[1000:2001], x[1000:2001]))
        for span in (1000.0, 20.0, 5.0)
    ]
    assert areas[0] < areas[1] < areas[2]


def test_creep_is_the_exact_answer_to_a_step_whatever_the_steps_of_time():
    model = ElementModel(
        (Element("input"), Element("creep", 0.0, 2.0), Element("creep", 0.3, 2.0)), start="zero"
    )
    time = np.concatenate(
        [[0.0, 1e-3], np.cumsum(np.random.default_rng(5).uniform(1e-4, 3.0, 50)) + 1e-3]
    )
    y = model.simulate(np.where(time > 0.0, 1.0, 0.0), time)
    wanted = 1.0 + (1.0 + 0.7) * (1.0 - np.exp(-time[1:] / 2.0))
    assert np.max(np.abs(y[1:] - wanted)) < 1e-12


def test_the_inverse_of_an_identified_delay_does_not_oscillate():
    """Half of the output comes one sample late: a fit that looked at the output alone could not be undone."""
    x = wander(3000)
    late = 0.1 * x + 0.9 * np.concatenate([x[:1], x[:-1]])
    fit = dehyst.identify(Recording(input=x, output=late, time=0.01 * np.arange(3000)), "creep-pi")
    rng = np.random.default_rng(0)
    disturbed = fit.model.inverse().simulate(
        late + 1e-3 * rng.standard_normal(3000), 0.01 * np.arange(3000)
    )
    assert np.max(np.abs(disturbed - x)) < 0.2


SMOOTH = [
    row.name
    for row in TABLE
    if row.sums[0].direction == "forward" and "rate" not in row.sums[0].groups
]


@pytest.mark.slow
@pytest.mark.parametrize("name", SMOOTH)
def test_a_row_is_found_again_from_its_own_noisy_log(name):
    truth = families.example(name)
    fit = dehyst.identify(record(truth, samples=3000), name)
    assert fit.test.rmse_percent < 0.6 and "seed" not in fit.settings
    # Of rows with products an inverse is certain to settle only where these are small.
    assert not fit.model.no_inverse or name.endswith("-volterra")
    x, time = wander(2000, 9), 0.01 * np.arange(2000)
    known, found = truth.simulate(x, time), fit.model.simulate(x, time)
    assert np.sqrt(np.mean((known - found) ** 2)) < 0.015 * np.ptp(known)
    if not fit.model.no_inverse:
        back = fit.model.inverse().simulate(found, time)
        assert np.max(np.abs(back - x)) < 1e-6 * np.ptp(x)


def test_a_position_over_a_force_with_sliders_is_a_maxwell_slip_too():
    """The sums of the row read both ways: stops where the output leads, plays where it lags."""
    x = wander(3000)
    force = dehyst.StopOperatorModel([0.0, 0.1, 0.4], [0.0, 0.6, 0.4], 0.4)
    for log_of in (
        Recording(input=x, output=force.simulate(x)),
        Recording(input=force.simulate(x), output=x),
    ):
        assert dehyst.identify(log_of, "maxwell-slip").test.rmse_percent < 0.5


def test_several_recordings_without_time_are_fitted_together():
    truth = timeless("krasnoselskii-pokrovskii")
    signals = [wander(1500, 5), wander(1700, 6)]
    found = dehyst.identify(
        [Recording(input=x, output=truth.simulate(x)) for x in signals], truth.family
    )
    assert (
        len(found.predictions) == 2
        and found.test.rmse_percent < 0.5
        and not found.model.rate_dependent
    )


@pytest.mark.slow
@measured
@pytest.mark.parametrize(("run", "most"), [(DAMPER, 2.4), (ARM, 1.7)], ids=["damper", "soft arm"])
def test_measured_logs_are_followed_as_well_as_the_issue_asks(run, most):
    assert dehyst.identify(log(*run), "elements").test.rmse_percent <= most


def test_the_committed_benchmark_holds_and_can_fail():
    result = json.loads(benchmark.RESULTS.read_text(encoding="utf-8"))
    assert benchmark.holds(result["summary"][benchmark.CHOSEN])
    # A new row has no figures before the benchmark has run again.
    assert benchmark.CHOSEN in result["summary"]
    assert set(result["summary"]) <= {benchmark.CHOSEN, *ROW_NAMES}
    assert not benchmark.holds({**result["summary"][benchmark.CHOSEN], "over_best_median": 1.01})
    assert not benchmark.holds(benchmark.summary(result["runs"], "inverse-path"))
    replaced = {
        name: found["over_before"]
        for name, found in result["summary"].items()
        if found["over_before"]
    }
    assert set(replaced) == {
        "creep-pi",
        "rate-dependent-pi",
        "generalised-pi",
        "maxwell-slip",
        "krasnoselskii-pokrovskii",
    }
    assert all(benchmark.replaces(found) for found in result["summary"].values())
    assert not benchmark.replaces({"over_before": 1.01})
