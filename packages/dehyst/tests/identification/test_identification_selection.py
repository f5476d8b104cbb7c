"""Comparisons on held-out samples are those of the definition; refits are what identify would say."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import nnls

import dehyst
from dehyst.data import kit as data_kit
from dehyst.errors import ExcitationError, ParameterError
from dehyst.identification import state_before
from dehyst.identification._data import prepare
from dehyst.identification._regressors import make_bank
from dehyst.identification._short_signal import shorten
from dehyst.identification._split import split_recordings
from dehyst.io import example_recording
from identification_oracles import loops, plays
from report_samples import fit_by_hand

SIZES = (2.0, 1.6, 1.9, 1.2, 1.7, 2.0, 1.4, 1.8)
PI = dehyst.PrandtlIshlinskii([0.0, 0.2, 0.5, 0.9], [0.7, 0.4, 0.3, 0.3])


def noisy(samples=60, scale=0.02, seed=0, map_of=lambda y: y):
    rng = np.random.default_rng(seed)
    x = loops((*SIZES, *SIZES), samples)
    x += 0.01 * rng.standard_normal(x.size)
    y = map_of(PI.simulate(x)) + scale * rng.standard_normal(x.size)
    return dehyst.Recording(input=x, output=y, time=0.01 * np.arange(x.size))


@pytest.mark.parametrize("start", ["zero", "rest", "rising", "falling", "unknown"])
@pytest.mark.parametrize("weighted", [False, True])
def test_the_short_signal_has_the_states_of_the_long_one_at_every_row(start, weighted):
    rec = noisy(samples=400)
    weights = None
    if weighted:
        weights = (np.random.default_rng(2).integers(0, 3, len(rec)).astype(float),)
    data = prepare((rec,), split_recordings((rec,), 0.5), weights)
    bank = make_bank(data, np.arange(30) / 30.0, start)
    short = shorten(data, start, 200)
    assert 150 < short.rows <= 201
    piece = data.pieces[0]
    rows = short.pieces[0].rows
    whole = plays(piece.x[: rows[-1] + 1], bank.thresholds, bank.states[0])[rows]
    assert np.array_equal(short.plays(bank.thresholds, bank.states), whole)
    assert np.array_equal(short.y, piece.y[rows])
    assert short.pieces[0].x.size < 12 * short.rows
    assert not weighted or (piece.weight[rows] > 0).all()


def test_operators_that_move_are_those_that_every_sample_says():
    rec = noisy(samples=100)
    data = prepare((rec,), split_recordings((rec,), 0.3))
    for start in ("zero", "rest", "rising", "unknown"):
        r = np.linspace(0.0, 2.5, 60)
        bank, piece = make_bank(data, r, start), data.pieces[0]
        outputs = plays(piece.x, r, state_before(start, r, piece.x[0], -1.0, 1.0))[
            piece.fitted(start)
        ]
        moved = np.ptp(outputs, axis=0) > 1e-6
        assert 20 < moved.sum() < 60
        assert np.array_equal(bank.thresholds, r[moved])
        assert np.array_equal(bank.undetermined, r[~moved])


def test_errors_of_a_trial_are_those_of_the_definition():
    rec = noisy(samples=25, scale=0.05)
    trial = dehyst.cross_validate(rec, n=(6,)).trials[0]
    x = rec.input - (rec.input.max() + rec.input.min()) / 2
    half, amplitude = np.ptp(x) / 2, np.ptp(rec.output) / 2
    z = plays(x / half, np.arange(6) / 6 * np.abs(x / half).max(), np.zeros(6))
    y = rec.output / amplitude
    (spread,) = data_kit.spread_rows([x], [np.ones(x.size, dtype=bool)], 4000)
    z, y, weight = z[spread.rows], y[spread.rows], spread.weight
    fold = data_kit.folds_of(weight)[0]
    errors = []
    for number in range(5):
        others, left_out = fold != number, fold == number
        root = np.sqrt(weight[others])[:, None]
        free = np.column_stack([np.ones(root.size), -np.ones(root.size)])
        ridge = 1e-4 * np.sqrt(np.sum(weight)) * np.eye(6, 8)
        matrix = np.vstack([root * np.hstack([z[others], free]), ridge])
        w, _ = nnls(matrix, np.concatenate([root[:, 0] * y[others], np.zeros(6)]))
        miss = z[left_out] @ w[:6] + w[6] - w[7] - y[left_out]
        errors.append(np.sqrt(np.average(miss**2, weights=weight[left_out])))
    assert trial.errors == pytest.approx(np.array(errors) * amplitude, rel=1e-6)
    assert trial.error == pytest.approx(np.mean(trial.errors))
    assert trial.inverse_error == pytest.approx(np.mean(trial.inverse_errors))
    assert len(trial.inverse_errors) == 5 and trial.inverse_error < 0.2


def test_the_shear_is_found_by_the_inverse():
    # The actuator obeys x + k y = H^-1[y] with k = 0.5: only with that shear is its loop a Prandtl-Ishlinskii one.
    rng = np.random.default_rng(0)
    turned = loops((*SIZES, *SIZES), 60)
    y = PI.simulate(turned)
    rec = dehyst.Recording(input=turned - 0.5 * y, output=y + 1e-4 * rng.standard_normal(y.size))
    table = dehyst.cross_validate(rec, n=(40,), shear=(0.0, 0.25, 0.5, 0.75, 1.0))
    assert table.best("inverse_error").shear == 0.5
    at = {trial.shear: trial.inverse_error for trial in table.trials}
    assert at[0.5] < 0.5 * min(error for k, error in at.items() if k != 0.5)


def test_a_table_holds_every_combination_in_order():
    rec = noisy(samples=25)
    table = dehyst.cross_validate(
        rec,
        families=("stop", "pi"),
        n=(4, 8),
        powers=(1, 2),
        starts=("rest", "zero"),
        train_fraction=0.8,
    )
    found = [(t.family, t.n, t.power, t.initial_state) for t in table.trials]
    expected = [
        (f, n, p, s)
        for f in ("stop", "pi")
        for n in (4, 8)
        for p in (1.0, 2.0)
        for s in ("rest", "zero")
    ]
    assert found == expected
    assert all(0.0 < t.seconds < 5.0 and t.nonzero_weights <= t.n for t in table.trials)
    assert len(str(table).splitlines()) == 17


@pytest.mark.parametrize(
    ("change", "cure"),
    [
        ({"families": "pi"}, "a list"),
        ({"n": ()}, "at least one"),
        ({"families": ("auto",)}, "not auto"),
        ({"families": ("p",)}, "There are: static, pi"),
        ({"n": ("auto",)}, "not auto"),
        ({"n": (0,)}, "whole number"),
        ({"starts": ("auto",)}, "not auto"),
        ({"powers": (0.0,)}, "between"),
        ({"shear": (float("nan"),)}, "finite"),
        ({"eps": -1.0}, "eps"),
    ],
)
def test_settings_that_cannot_be_compared_are_refused(change, cure):
    with pytest.raises(ParameterError, match=cure):
        dehyst.cross_validate(noisy(samples=25), **change)


def test_too_few_samples_for_five_parts_are_refused():
    rec = noisy(samples=25)
    short = dehyst.Recording(input=rec.input[:30], output=rec.output[:30])
    with pytest.raises(ExcitationError, match="five parts"):
        dehyst.cross_validate(short)


@pytest.mark.slow
def test_n_auto_takes_few_operators_where_few_do_and_many_where_they_help():
    truth = dehyst.PrandtlIshlinskii([0.0, 1.0], [1.0, 0.8])
    x = loops((*SIZES, *SIZES), 60)
    x[np.argmax(x)] = 2.0
    rng = np.random.default_rng(0)
    coarse = dehyst.Recording(
        input=x, output=truth.simulate(x) + 0.01 * rng.standard_normal(x.size)
    )
    few = dehyst.identify(coarse, "pi", n="auto")
    # 1 is on every grid with an even n; the smallest of those offered is 10.
    assert few.certificate.operators == 10 and few.settings["n_by"] == "cross-validation"
    fine = dehyst.identify(example_recording(), "modified-pi", n="auto")
    default = dehyst.identify(example_recording(), "modified-pi")
    assert fine.certificate.operators >= 40
    assert fine.test.rmse < 1.05 * default.test.rmse
    with pytest.raises(ParameterError, match="Leave one of them out"):
        dehyst.identify(coarse, "pi", n="auto", thresholds=[0.0, 1.0])


SETTINGS = [
    {},
    {"n": 30},
    {"n": 20},
    {"n": 33},
    {"eps": 0.2},
    {"family": "stop"},
    {"family": "pi-cumulative", "n": 12},
]


@pytest.mark.slow
@pytest.mark.parametrize("family", ["pi", "modified-pi"])
def test_a_refit_is_what_identify_says(family):
    rec = noisy(map_of=np.tanh)
    fit = dehyst.identify(rec, family, n=60)
    for change in [*SETTINGS, {"thresholds": [0.0, 0.4, 0.8]}]:
        refit = fit.refit(**change)
        kept = {
            "family": family,
            "n": 60,
            "initial_state": fit.certificate.initial_state,
            "eps": refit.eps,
        }
        settings = kept | change
        whole = dehyst.identify(rec, **settings)
        if (
            whole.family == "modified-pi"
            and whole.settings["smoothing"] != fit.settings["smoothing"]
        ):
            continue
        assert refit.test.rmse == pytest.approx(whole.test.rmse, rel=1e-8)
        assert refit.train.rmse_percent == pytest.approx(whole.train.rmse_percent, rel=1e-8)
        assert refit.nonzero_weights == whole.certificate.nonzero_weights
        assert (refit.family, refit.n) == (whole.family, whole.certificate.operators)
        assert np.abs(refit.model.simulate(rec.input) - whole.predictions[0]).max() < 1e-8
        assert refit.kkt_residual < 1e-13


def test_a_refit_with_another_eps_looks_at_no_data_for_its_sums(monkeypatch):
    from dehyst.identification._candidates import plays as module

    fit = dehyst.identify(noisy(), "pi", n=60)
    monkeypatch.setattr(module, "normal_equations", lambda *a: pytest.fail("a pass over the data"))
    for change in ({"eps": 0.3}, {"n": 30}, {"n": 20}, {"n": 6}):
        assert fit.refit(**change).test is not None


def test_every_family_is_compared_on_the_same_folds():
    truth = dehyst.families.example("dahl")
    x = loops(SIZES, 60) / 2.0
    rec = dehyst.Recording(input=x, output=truth.simulate(x), time=0.01 * np.arange(x.size))
    table = dehyst.cross_validate(
        rec, families=("pi", "static", "dahl", "direct-inverse"), n=(10, 20)
    )
    rows = {(trial.family, trial.n): trial for trial in table.trials}
    assert list(rows) == [("pi", 10), ("pi", 20), ("static", 0), ("dahl", 0), ("direct-inverse", 0)]
    assert table.best() is rows["dahl", 0] and rows["dahl", 0].error < 0.2 * rows["pi", 20].error
    assert rows["static", 0].error > rows["pi", 20].error
    assert np.isnan(rows["direct-inverse", 0].errors).all() and np.isfinite(
        rows["direct-inverse", 0].inverse_error
    )
    assert "nan" in str(table) and len(str(table).splitlines()) == 6


def test_a_family_of_the_literature_sees_all_samples_but_a_fifth_of_the_way(monkeypatch):
    from dehyst.families import _dahl as dahl
    from dehyst.families import _registry as registry
    from dehyst.identification import _candidates as candidates
    from dehyst.identification import _prepared as prepared

    log = prepared.prepared((noisy(samples=500),), 1.0)
    seen = []

    def fit(training):
        seen.append(np.concatenate([stretch.counts for stretch in training.stretches]))
        return dahl.Dahl(scaling=training.scaling)

    monkeypatch.setattr(dahl, "FAMILY", replace(registry.family("dahl"), fit=fit))
    errors = candidates.candidate_of("dahl").block_errors(log)
    model = dahl.Dahl(scaling=log.training(0).scaling)
    miss = model.simulate(log.records[0].input) - log.records[0].output
    # A fifth of the way, within a sample at each end of four parts; the errors count by the way.
    share = data_kit.shares_of([log.records[0].input], [np.ones(miss.size, dtype=bool)])[0]
    assert len(seen) == 5 and np.array_equal(np.sum(~np.array(seen), axis=0), np.ones(miss.size))
    for counts, error in zip(seen, errors.output, strict=True):
        left_out = ~counts
        assert abs(np.sum(share[left_out]) - 0.2) < 8.0 * share.max()
        assert np.count_nonzero(np.diff(np.flatnonzero(left_out)) > 1) == 3
        wanted = np.sqrt(np.average(miss[left_out] ** 2, weights=share[left_out]))
        assert error == pytest.approx(wanted, rel=1e-9)


@pytest.mark.parametrize(
    ("change", "cure"),
    [
        ({"n": 0}, "whole number"),
        ({"eps": -1.0}, "eps"),
        ({"family": "p"}, "not one of"),
        ({"thresholds": [1.0]}, "0"),
    ],
)
def test_a_refit_refuses_what_identify_refuses(change, cure):
    with pytest.raises(ParameterError, match=cure):
        dehyst.identify(noisy(samples=25), "pi", n=10).refit(**change)


def test_a_fit_made_by_hand_says_that_it_cannot_be_refitted():
    with pytest.raises(ParameterError, match="Identify again"):
        fit_by_hand().refit(n=5)


@pytest.mark.slow
def test_of_a_long_log_facts_are_those_of_all_its_samples(monkeypatch):
    from dehyst.identification import _facts as facts

    rec = noisy(samples=1000, map_of=np.tanh)
    whole = dehyst.identify(rec, "pi", n=20).facts
    monkeypatch.setattr(facts, "LONG", 2000)
    monkeypatch.setattr(facts, "ENOUGH", 2000)
    part = dehyst.identify(rec, "pi", n=20).facts
    assert (part.orientation, part.loops, part.turns) == (
        whole.orientation,
        whole.loops,
        whole.turns,
    )
    assert part.width_percent == pytest.approx(whole.width_percent, rel=0.05)
    assert part.rate_dependence_percent == pytest.approx(whole.rate_dependence_percent, abs=0.5)
    assert part.drift_percent == whole.drift_percent


def test_a_refit_keeps_names_units_and_ranges_and_says_what_it_is():
    fit = dehyst.identify(example_recording(), family="pi")
    card = fit.refit(n=20, eps=0.1).model.card
    assert (card.input, card.output) == (fit.model.card.input, fit.model.card.output)
    assert card.provenance["settings"]["n"] == 20 and card.provenance["settings"]["eps"] == 0.1
    assert (
        "refit" in card.provenance["verdict"]
        and card.provenance["logs"] == fit.model.card.provenance["logs"]
    )


@pytest.mark.slow
def test_settings_that_contradict_each_other_are_refused_by_name():
    fit = dehyst.identify(example_recording(), family="pi")
    with pytest.raises(ParameterError, match="whole number"):
        fit.refit(n="auto")
    with pytest.raises(ParameterError, match="Pass one"):
        fit.refit(n=50, thresholds=[0.0, 1.0])
    with pytest.raises(ParameterError, match=r"n=\[50\]"):
        dehyst.cross_validate(example_recording(), n=50)
