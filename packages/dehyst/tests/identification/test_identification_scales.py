"""Units and offsets of any size: a log is identified as well as in ordinary numbers, or refused in the user's terms."""

import numpy as np
import pytest

from dehyst import Recording, identify
from dehyst.errors import DehystError, ExcitationError, RecordingError
from dehyst.io import read_log, write_csv

T = np.arange(1500) / 50
X = 4 * np.sin(2 * T) * np.exp(-T / 40)


def loop(x):
    """Output of six plays, by the definition."""
    z, y = np.zeros(6), np.empty(x.size)
    r, w = np.linspace(0, 3, 6), np.array([1, 0.4, 0.3, 0.2, 0.1, 0.1])
    for k, value in enumerate(x):
        z = np.maximum(value - r, np.minimum(value + r, z))
        y[k] = w @ z
    return y


Y = loop(X) + np.random.default_rng(0).normal(0, 0.01, X.size)


def error(x_offset, x_scale, y_offset, y_scale, family):
    """True error of the model that was identified, in percent of the range."""
    x, y = x_offset + x_scale * X, y_offset + y_scale * Y
    model = identify(Recording(x, y, T), family=family).model
    return 100 * float(np.std((model.simulate(x, T) - y) / y_scale) / np.ptp(Y))


@pytest.mark.slow
@pytest.mark.parametrize("family", ["pi-cumulative", "modified-pi", "auto"])
@pytest.mark.parametrize("at", [(1e12, 1, 0, 1), (0, 1, 1e12, 1), (1e12, 1, -1e12, 1)])
def test_a_signal_on_a_large_offset_is_identified_as_well_as_without(family, at):
    assert error(*at, family) < error(0, 1, 0, 1, family) + 0.02


@pytest.mark.slow
@pytest.mark.parametrize("family", ["pi-cumulative", "modified-pi", "stop"])
def test_any_scale_is_identified_alike_or_refused_by_what_the_signals_do(family):
    ordinary, refused = error(0, 1, 0, 1, family), 0
    dice = np.random.default_rng(7)
    sizes = [(10.0 ** dice.uniform(-200, 200), 10.0 ** dice.uniform(-200, 200)) for _ in range(24)]
    sizes += [
        (a, b) for a in (1e-94, 1e-60, 1.0, 1e60, 1e94) for b in (1e-94, 1e-60, 1.0, 1e60, 1e94)
    ]
    sizes = sizes[::3] if family == "modified-pi" else sizes  # the slowest of the three
    for x_scale, y_scale in sizes:
        try:
            found = error(0, x_scale, 0, y_scale, family)
        except ExcitationError as fault:
            refused += 1
            assert (
                "moves by" in str(fault)
                and "another unit" in str(fault)
                and "weights[" not in str(fault)
            )
            extreme = [10 ** abs(np.log10(s)) for s in (x_scale, y_scale, y_scale / x_scale)]
            assert max(extreme) > 1e93, (x_scale, y_scale)
        else:
            assert found < 1.001 * ordinary + 1e-3, (x_scale, y_scale)
    assert 2 < refused < len(sizes) - 2


def test_a_signal_that_moves_too_little_for_its_offset_is_told_by_how_much(tmp_path):
    with pytest.raises(
        ExcitationError, match=r"moves by 7\.\d+ .* offset of 1e\+13, .* 0\.002 apart"
    ):
        identify(Recording(1e13 + X, Y, T))
    path = write_csv(
        tmp_path / "log.csv", {"time_s": T, "p_bar": X, "angle_deg": 1e14 + np.round(Y)}
    )
    with pytest.raises(RecordingError, match=r"moves by 1\d only on an offset of 1e\+14"):
        read_log(path, "p_bar", "angle_deg")


@pytest.mark.parametrize("value", [0.0, 3.0, 1e12])
def test_a_signal_that_stands_still_is_said_to_stay(value):
    with pytest.raises(ExcitationError, match="stays at"):
        identify(Recording(np.full(X.size, value), Y, T))


def test_the_largest_and_the_smallest_numbers_end_in_a_named_error():
    for x in (X * 4e307, X * 5e-324, np.where(X > 0, 1.7e308, -1.7e308)):
        with pytest.raises(DehystError, match="moves by"):
            identify(Recording(x, Y, T))
