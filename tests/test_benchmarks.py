"""The benchmark's own claims: its limits can be missed, its signals are what they are called, its rivals compute the
same thing."""

import sys

import numpy as np
import pytest

import dehyst
from oracles import exact_pi
from places import ROOT

sys.path.insert(0, str(ROOT / "benchmarks"))

from speed import alternatives, limits, measure, signals
from speed.figures import Figures


def test_every_limit_can_be_missed_and_a_short_run_asks_for_a_quarter_of_each_ratio():
    for limit in limits.LIMITS:
        worse, better = (10.0, 0.1) if limit.sense == "<=" else (0.1, 10.0)
        assert limit.holds(better * limit.value)
        assert limit.holds(worse * limit.value) is False
        part = limit.value * (3.8 if limit.sense == "<=" else 1 / 3.8)
        assert (
            limit.holds(part, quick=True)
            is {"ratio": True, "accuracy": False, "time": None}[limit.kind]
        )
        assert not limit.holds(worse * limit.value, quick=True)
    assert len({(limit.what, limit.signal) for limit in limits.LIMITS}) == len(limits.LIMITS)


def test_what_was_not_measured_is_not_ok_and_not_missed():
    figures = Figures()
    figures.add("overhead of a step [ns]", "", 31.0)
    verdicts = {row["what"]: row["ok"] for row in figures.rows(quick=False)}
    assert verdicts.pop("overhead of a step [ns]") is False
    assert set(verdicts.values()) == {None}
    assert len(figures.rows(quick=False, partial=True)) == 1


@pytest.mark.parametrize("name", list(signals.SIGNALS))
def test_signals_stay_within_their_range_and_are_the_same_every_time(name):
    x = signals.SIGNALS[name](50_000)
    assert x.shape == (50_000,) and np.array_equal(x, signals.SIGNALS[name](50_000))
    assert 0.9 < np.max(np.abs(x)) <= (1.02 if name == "noisy" else 1.0)


def test_noise_is_one_percent_of_the_range_and_the_sine_takes_twenty_seconds():
    difference = signals.noisy(40_000) - signals.smooth(40_000)
    assert 0.0199 < np.max(np.abs(difference)) <= 0.02
    crossings = np.flatnonzero(np.diff(np.sign(signals.smooth(100_001))) > 0)
    assert crossings[-1] - crossings[-2] == 40_000


@pytest.mark.slow
def test_rivals_compute_the_operator():
    x, (r, w) = signals.noisy(300), signals.operator(7)
    exact = [float(y) for y in exact_pi(x, r, w, np.zeros(7))]
    loops = [alternatives.numpy_loop, alternatives.core_dense, alternatives.numba_loop()]
    for loop in filter(None, loops):
        assert np.allclose(loop(x, r, w), exact, rtol=0, atol=1e-14)
    plays = np.column_stack([alternatives.numpy_plays(x, r), exact])
    sums = alternatives.chunked_blas(x, np.array(exact), r)
    assert np.allclose(sums, plays.T @ plays, rtol=0, atol=1e-12 * np.max(sums))


def test_the_dense_rival_is_the_core_to_the_bit():
    x, (r, w) = signals.noisy(1000), signals.operator(100)
    assert alternatives.core_dense(x, r, w).tolist() == list(
        map(dehyst.PrandtlIshlinskii(r, w).stepper(), x.tolist())
    )


def test_rival_solvers_find_the_same_weights():
    rng = np.random.default_rng(0)
    a, truth = rng.standard_normal((60, 6)), np.array([1.0, 0.0, 0.5, 0.0, 2.0, 0.0])
    g, b = a.T @ a, a.T @ (a @ truth - 0.01)
    expected = alternatives.solve_nnls(*alternatives.triangle(g, b))
    assert np.sum(expected == 0.0) > 0
    for solve in filter(None, alternatives.solvers().values()):
        assert np.allclose(solve(g, b), expected, rtol=0, atol=1e-9)


def test_works_take_turns_and_a_slow_one_is_not_repeated(monkeypatch):
    order, clock = [], [0.0]
    monkeypatch.setattr(measure.time, "process_time", lambda: clock[0])

    def work(name, seconds):
        def run():
            order.append(name)
            clock[0] += seconds

        return measure.Work(run, 1000)

    works = {"fast": work("fast", 0.5), "slow": work("slow", 5.0), "missing": None}
    times = measure.measure(works, rounds=2)
    assert order == ["fast", "slow", "fast", "fast"]
    assert times.seconds == {"slow": [5.0], "fast": [0.5, 0.5]}
    assert times.ratio("slow", "fast") == pytest.approx(10.0)


def test_every_limit_of_evaluation_and_normal_equations_is_measured(monkeypatch):
    from speed import evaluation, normal_equations

    monkeypatch.setattr(
        normal_equations, "data_to_weights", lambda *_: None
    )  # needs a million samples
    figures = Figures()
    evaluation.run(2000, 1, figures, quick=True)
    normal_equations.run(2048, 1, figures, quick=True)
    parts = ("evaluation /", "numpy loop", "normal equations", "chunked BLAS")
    wanted = {(limit.what, limit.signal) for limit in limits.LIMITS if limit.what.startswith(parts)}
    assert len(wanted) > 15 and wanted <= set(figures.values)
