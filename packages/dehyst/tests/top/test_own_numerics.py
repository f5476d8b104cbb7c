"""What the kernel computes by itself, against SciPy and mpmath: weights >= 0, searches, Student's distribution."""

import math

import mpmath
import numpy as np
import pytest
from scipy.optimize import minimize, nnls
from scipy.signal import lfilter

from dehyst.design import lags
from dehyst.families._duhem import golden_sections
from dehyst.families._friction import quick
from dehyst.families._shapes import nelder_mead
from dehyst.least_squares import lawson_hanson
from dehyst.student import place_of_tail, tail


def hard_program(seed):
    """Columns that may be many, alike or twice the same, and a target."""
    random = np.random.default_rng(seed)
    rows, size = int(random.integers(2, 40)), int(random.integers(1, 40))
    columns = random.normal(size=(rows, size)) + random.choice([0.0, 1.0, 3.0])
    if seed % 3 == 0:
        columns = np.cumsum(columns, axis=1)
    if seed % 7 == 0 and size > 2:
        columns[:, 1] = columns[:, 0]
    return columns, random.normal(size=rows)


def test_weights_from_zero_on_reach_the_residual_of_scipy():
    for seed in range(300):
        columns, target = hard_program(seed)
        weights = lawson_hanson(columns, target)
        assert np.all(weights >= 0.0)
        residual = nnls(columns, target)[1]
        assert np.linalg.norm(columns @ weights - target) <= residual + 1e-13 * np.linalg.norm(
            target
        )


def test_the_quick_error_is_that_of_the_weights():
    for seed in range(300):
        columns, target = hard_program(seed)
        if columns.shape[0] > columns.shape[1] + 3:
            residual = nnls(columns - columns.mean(axis=0), target - target.mean())[1]
            assert quick(columns, target) == pytest.approx(
                residual / math.sqrt(target.size), rel=1e-8, abs=1e-6
            )


def test_exchanges_that_do_not_end_are_said(monkeypatch):
    monkeypatch.setattr("dehyst.least_squares.EXCHANGES", 0)
    monkeypatch.setattr("dehyst.least_squares.EXCHANGES_AT_LEAST", 1)
    assert lawson_hanson(np.eye(3), np.ones(3)) is None


def valley(x):
    return float(100.0 * (x[1] - x[0] ** 2) ** 2 + (1.0 - x[0]) ** 2)


CORNERS = np.array([[-1.0, 1.0], [-0.5, 1.0], [-1.0, 0.5]])
BOUNDS = np.array([[-2.0, 0.8], [-2.0, 2.0]])


def test_the_simplex_ends_where_scipys_does():
    options = {"initial_simplex": CORNERS, "xatol": 1e-3, "fatol": 1e-6, "maxfev": 1000}
    theirs = minimize(valley, CORNERS[0], method="Nelder-Mead", bounds=BOUNDS, options=options)
    best, least = nelder_mead(valley, CORNERS, BOUNDS, 1000, 1e-3, 1e-6)
    np.testing.assert_allclose(best, theirs.x, rtol=1e-12)
    assert least == pytest.approx(theirs.fun, rel=1e-9) and best[0] == 0.8


def test_the_simplex_keeps_its_budget_but_for_the_iteration_that_spends_it():
    count = 0

    def counted(x):
        nonlocal count
        count += 1
        return valley(x)

    nelder_mead(counted, CORNERS, BOUNDS, 40, 1e-3, 1e-6)
    assert 40 <= count <= 40 + 1 + CORNERS.shape[0]


def test_golden_sections_close_in_by_the_golden_ratio():
    asked = []
    best = golden_sections(lambda x: asked.append(x) or abs(x - 0.71), 0.0, 1.0, 18)
    assert len(asked) == 20 and abs(best - 0.71) < 0.618**18
    assert golden_sections(lambda x: x, 2.0, 3.0, 30) == pytest.approx(
        2.0, abs=1e-6
    )  # the valley is at the limit


def exact_tail(t, freedom):
    with mpmath.workdps(40):
        x = mpmath.mpf(freedom) / (freedom + mpmath.mpf(t) ** 2)
        return float(
            mpmath.betainc(mpmath.mpf(freedom) / 2, mpmath.mpf(1) / 2, 0, x, regularized=True) / 2
        )


@pytest.mark.parametrize("freedom", [1, 2, 3, 7, 20, 100, 500])
def test_the_tail_of_student_has_ten_digits_however_small_it_is(freedom):
    for t in (1e-8, 0.001, 0.5, 1.0, 2.0, 5.0, 10.0, 30.0, 1000.0):
        assert tail(t, freedom) == pytest.approx(exact_tail(t, freedom), rel=1e-10, abs=1e-290)
        assert tail(-t, freedom) == pytest.approx(1.0 - exact_tail(t, freedom), rel=1e-14)
    assert (
        tail(1e200, freedom) == 0.0 and tail(math.inf, freedom) == 0.0 and tail(0.0, freedom) == 0.5
    )


@pytest.mark.parametrize("freedom", [1, 2, 7, 100, 500])
@pytest.mark.parametrize("share", [0.4, 0.1, 0.025, 0.0005, 5e-6])
def test_the_place_of_a_tail_has_that_tail(share, freedom):
    assert exact_tail(place_of_tail(share, freedom), freedom) == pytest.approx(share, rel=1e-10)


def test_a_lag_is_the_filter_of_one_pole():
    random = np.random.default_rng(3)
    signal = np.concatenate([[0.0], np.cumsum(random.normal(size=5000))])
    for constant in (0.2, 3.0, 500.0):
        gain = 1.0 - math.exp(-0.1 / constant)
        expected = lfilter([gain], [1.0, gain - 1.0], signal)
        np.testing.assert_allclose(lags(signal, 0.1, [constant])[:, 0], expected, atol=1e-11)
