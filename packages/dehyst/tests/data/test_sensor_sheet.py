"""Data sheets of sensors: curves whose figures are known in closed form, and logs that lack what a figure needs."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog
from scipy.signal import lfilter

import dehyst
from dehyst.data import sensor_data_sheet
from dehyst.data._holds import holds_of
from dehyst.data._straight_lines import best_line, terminal_line, zero_line
from dehyst.errors import ExcitationError, ParameterError

STEP = 0.1


def cycles(count, low=0.0, high=1.0, seconds=40.0, hold=0.0):
    """Up and down, with a rest at both ends."""
    size = round(seconds / STEP)
    rest = round(hold / STEP)
    one = [
        np.linspace(low, high, size, endpoint=False),
        np.full(rest, high),
        np.linspace(high, low, size, endpoint=False),
        np.full(rest, low),
    ]
    return np.append(np.concatenate(one * count), low)


def sheet_of(reading, quantity, line="terminal", **more):
    time = STEP * np.arange(quantity.size)
    return sensor_data_sheet(dehyst.Recording(reading, quantity, time, **more), line)


def value(sheet, name):
    return sheet.figures[name].value.value


def bent(x):
    """Zero at both ends, and bent to one side between them."""
    return 0.1 * x * (1.0 - x) * (2.0 - x)


# Lines


def test_the_lines_of_a_cubic_are_those_by_hand():
    """Its deviation is largest at 1 - 1 / sqrt(3); the best line of a curve bent to one side is half as far away."""
    x = cycles(3)
    sheet = sheet_of(x + bent(x), x)
    top = bent(1.0 - 1.0 / np.sqrt(3.0))
    assert value(sheet, "terminal") == pytest.approx(100.0 * top, rel=5e-3)
    assert sheet.figures["terminal"].place == pytest.approx(0.4)
    assert value(sheet, "best") == pytest.approx(50.0 * top, rel=5e-3)
    dense = np.linspace(0.0, 1.0, 2001)
    slopes = np.linspace(0.0, 0.1, 2001)
    least = min(np.max(np.abs(bent(dense) - slope * dense)) for slope in slopes)
    assert value(sheet, "through_zero") == pytest.approx(100.0 * least, rel=5e-3)
    assert value(sheet, "combined") == pytest.approx(100.0 * top, rel=5e-3)
    assert value(sheet, "hysteresis") == pytest.approx(0.0, abs=1e-3)
    mean_square = np.mean(bent(dense) ** 2)
    assert value(sheet, "rms") == pytest.approx(100.0 * np.sqrt(mean_square), rel=1e-2)


POINTS = st.lists(st.floats(-10.0, 10.0), min_size=3, max_size=12)


@given(POINTS)
@settings(max_examples=60, deadline=None)
def test_no_line_is_closer_than_the_best_one(values):
    """A linear program finds the same largest deviation."""
    y = np.array(values)
    x = np.arange(y.size, dtype=float)
    ones = np.ones_like(x)
    above = np.column_stack([-x, -ones, -ones])
    below = np.column_stack([x, ones, -ones])
    program = linprog(
        [0, 0, 1],
        A_ub=np.vstack([above, below]),
        b_ub=np.concatenate([-y, y]),
        bounds=[(None, None)] * 3,
    )
    left = np.max(np.abs(y - best_line(x, y).at(x)))
    assert left == pytest.approx(program.fun, abs=1e-7)


@given(POINTS)
@settings(max_examples=60, deadline=None)
def test_no_line_through_the_first_point_is_closer_than_the_zero_based_one(values):
    y = np.array(values)
    x = np.arange(y.size, dtype=float)
    line = zero_line(x, y)
    assert line.at(x)[0] == pytest.approx(y[0])
    left = np.max(np.abs(y - line.at(x)))
    for slope in np.linspace(-25.0, 25.0, 501):
        assert left <= np.max(np.abs(y - y[0] - slope * x)) + 1e-9
    assert np.max(np.abs(y - best_line(x, y).at(x))) <= left + 1e-9
    assert left <= np.max(np.abs(y - terminal_line(x, y).at(x))) + 1e-9


# Hysteresis, repeatability, creep


def test_the_hysteresis_of_a_play_is_its_width():
    r, w = 0.05, 2.0
    x = np.concatenate([np.linspace(0.5, 0.0, 100), cycles(4)])
    reading = dehyst.PrandtlIshlinskii([r], [w]).simulate(x)
    sheet = sheet_of(reading, x)
    # From turn to turn the reading moves by w (1 - 2 r).
    assert value(sheet, "output") == pytest.approx(w * (1.0 - 2.0 * r), rel=2e-3)
    assert value(sheet, "hysteresis") == pytest.approx(100.0 * 2.0 * r / (1.0 - 2.0 * r), rel=2e-3)
    assert value(sheet, "repeatability") == pytest.approx(0.0, abs=0.2)
    assert value(sheet, "zero_return") == pytest.approx(0.0, abs=0.2)


def test_the_spread_of_cycles_is_the_one_that_was_put_in():
    """Offsets of 0, 3 and 1 % of full scale, which change while the quantity rests at the lower end."""
    x = cycles(3, hold=20.0)
    each = np.array([0.0, 0.03, 0.01])
    offsets = np.append(np.repeat(each, 1200)[100:], np.full(101, 0.01))
    sheet = sheet_of(x + offsets, x)
    repeatability = sheet.figures["repeatability"]
    assert repeatability.value.value == pytest.approx(3.0)
    assert repeatability.count == 3
    zero = sheet.figures["zero"].value
    assert zero.value == pytest.approx(np.mean(each))
    # Student's 4.303 of two degrees of freedom.
    assert zero.high - zero.value == pytest.approx(
        4.3027 * np.std(each, ddof=1) / np.sqrt(3.0), rel=1e-4
    )


def test_exponential_creep_is_read_over_its_hold():
    x = cycles(3, hold=60.0)
    amplitude, lag = 0.02, 25.0
    # What the reading would be at rest under the quantity for ever, less what is not there yet.
    late = np.zeros(x.size)
    for k in range(1, x.size):
        late[k] = late[k - 1] + STEP / lag * (x[k] - late[k - 1])
    reading = x + amplitude * late
    sheet = sheet_of(reading, x)
    upper = sheet.figures["creep_upper"]
    assert upper.count == 3 and upper.seconds == pytest.approx(60.0, abs=0.5)
    begin = int(np.flatnonzero(x == 1.0)[0])
    true = late[begin + 599] - late[begin]
    assert upper.value.value == pytest.approx(100.0 * amplitude * true / sheet.full_scale, rel=3e-2)
    assert value(sheet, "creep_lower") < 0.0 < value(sheet, "creep_upper")


@pytest.mark.parametrize("lag", [1.0, 3.0, 10.0, 30.0])
@pytest.mark.parametrize("noise", [0.0, 1e-6, 1e-5, 1e-4, 1e-3])
def test_fast_creep_is_that_from_the_first_sample_at_rest_and_in_its_interval(lag, noise):
    """An exact first-order lag, whose hold begins with its steepest creep."""
    x = cycles(4, seconds=20.0, hold=60.0)
    amplitude = 8e-4
    forget = np.exp(-STEP / lag)
    late = lfilter([1.0 - forget], [1.0, -forget], x)
    scatter = noise * np.random.default_rng(3).normal(size=x.size)
    sheet = sheet_of(x + amplitude * late + scatter, x)
    begin = int(np.flatnonzero(x == 1.0)[0])
    after = begin + 800 * 2  # the second hold: the first one begins from a sensor that has rested
    true = 100.0 * amplitude * (late[after + 599] - late[after]) / sheet.full_scale
    creep = sheet.figures["creep_upper"].value
    assert creep.low <= true <= creep.high
    if noise <= 1e-6:
        assert creep.value == pytest.approx(true, rel=0.03, abs=1e-4)
        assert creep.high - creep.low < 0.2 * true + 1e-3


def test_a_quantity_that_sinks_in_its_hold_is_no_creep():
    x = cycles(3, hold=60.0)
    sinking = x.copy()
    for k in np.flatnonzero(np.diff(np.append(0, x == 1.0)) == 1):
        sinking[k : k + 600] -= np.linspace(0.0, 0.002, 600)
    sheet = sheet_of(2.0 * sinking, sinking)
    assert value(sheet, "creep_upper") == pytest.approx(0.0, abs=1e-6)


def test_a_sine_rests_nowhere():
    x = 0.5 - 0.5 * np.cos(np.linspace(0.0, 6.0 * np.pi, 3000))
    sheet = sheet_of(x, x)
    for name in ("creep_upper", "creep_lower"):
        assert np.isnan(value(sheet, name))
        assert "no hold of" in sheet.figures[name].why and "30 min" in sheet.figures[name].why


@given(st.floats(0.0, 0.001), st.integers(0, 20))
@settings(max_examples=20, deadline=None)
def test_holds_are_found_in_noise(noise, seed):
    x = cycles(2, hold=20.0) + noise * np.random.default_rng(seed).normal(size=1201 + 400)[:1]
    noisy = x + noise * np.random.default_rng(seed).normal(size=x.size)
    holds = holds_of(noisy, STEP * np.arange(x.size), 5.0, 0.01)
    assert [round(hold.level) for hold in holds] == [1, 0, 1, 0]
    for hold in holds:
        assert 190 <= hold.end - hold.begin <= 212


def test_temperature_moves_zero_and_full_scale_as_it_was_told_to():
    x = cycles(8, hold=20.0)
    warm = 20.0 + 10.0 * np.sin(np.linspace(0.0, 6.0, x.size))
    reading = (2.0 + 0.004 * (warm - 20.0)) * x + 0.003 * (warm - 20.0)
    sheet = sheet_of(reading, x, schedules={"body": warm}, schedule_units={"body": "degC"})
    full_scale = sheet.full_scale
    assert value(sheet, "output with body") == pytest.approx(0.4 / full_scale, rel=0.02)
    assert value(sheet, "zero with body") == pytest.approx(0.3 / full_scale, rel=0.02)
    assert sheet.figures["zero with body"].value.unit == "%/degC"
    # What the temperature moves within a hold is no creep.
    without = sheet_of(reading, x)
    assert abs(value(sheet, "creep_upper")) < 0.5 * sheet_worst(without)


def sheet_worst(sheet):
    return abs(sheet.figures["creep_upper"].worst)


# Steps and tables


def staircase(count, levels, dwell):
    """Up and down in steps, each held."""
    one = np.concatenate([np.repeat(levels, dwell), np.repeat(levels[-2:0:-1], dwell)])
    return np.append(np.tile(one, count), np.repeat(levels[0], dwell))


def test_a_staircase_is_read_at_the_end_of_its_steps():
    """While a step lasts the reading creeps in; the curve is that of the ends."""
    levels = np.linspace(0.0, 10.0, 11)
    x = staircase(3, levels, 60)
    into = np.tile(1.0 - np.exp(-np.arange(60) / 8.0), x.size // 60)
    step = np.repeat(np.append(0.0, np.diff(x[::60])), 60)
    reading = 3.0 * (x - step * (1.0 - into)) + 0.2 * (x / 10.0) ** 2
    sheet = sheet_of(reading, x)
    assert sheet.stepped and sheet.places.tolist() == pytest.approx(levels.tolist())
    # The parabola is 0.2 / 4 from its chord in the middle.
    assert value(sheet, "terminal") == pytest.approx(-100.0 * 0.05 / 30.2, rel=1e-2)
    assert value(sheet, "hysteresis") < 0.05


def test_a_table_of_a_certificate_is_read_at_its_rows():
    up = np.array([0.0, 0.9, 2.1, 3.1, 4.0])
    down = np.array([3.3, 2.3, 1.0, 0.1])
    quantity = np.array([0.0, 10, 20, 30, 40, 30, 20, 10, 0, 10, 20, 30, 40, 30, 20, 10, 0])
    reading = np.concatenate([up, down, up[1:] + np.array([0.0, 0.02, 0.0, 0.0]), down])
    sheet = sensor_data_sheet(dehyst.Recording(reading, quantity))
    assert sheet.places.tolist() == [0.0, 10.0, 20.0, 30.0, 40.0]
    # Means of both cycles: 2.11 rising, 2.3 falling; 3.1 and 3.3.
    assert value(sheet, "output") == pytest.approx(4.0 - 0.075)
    assert value(sheet, "hysteresis") == pytest.approx(100.0 * 0.2 / 3.925)
    assert value(sheet, "repeatability") == pytest.approx(100.0 * 0.1 / 3.925)
    assert "no time" in sheet.figures["creep_upper"].why


# What must not matter


@given(
    st.floats(0.1, 50.0), st.floats(-5.0, 5.0), st.sampled_from([1.0, -1.0]), st.floats(0.1, 50.0)
)
@settings(max_examples=25, deadline=None)
def test_units_zero_and_sign_of_the_reading_do_not_matter(gain, zero, sign, scale):
    x = cycles(3, hold=20.0)
    reading = x + bent(x) + dehyst.PrandtlIshlinskii([0.02], [0.1]).simulate(x)
    plain = sheet_of(reading, x)
    other = sheet_of(sign * gain * reading + zero, scale * x)
    for name in ("terminal", "zero_return", "creep_upper"):
        assert value(other, name) == pytest.approx(sign * value(plain, name), rel=1e-6, abs=1e-6)
    for name in ("best", "through_zero", "hysteresis", "repeatability", "combined", "rms"):
        assert value(other, name) == pytest.approx(value(plain, name), rel=1e-6, abs=1e-6)
    assert value(other, "sensitivity") == pytest.approx(
        sign * gain / scale * value(plain, "sensitivity")
    )


def test_a_sensor_that_falls_has_a_negative_sensitivity_and_the_same_hysteresis():
    x = cycles(3)
    sheet = sheet_of(10.0 * np.exp(-2.0 * x), x, input_unit="kOhm", output_unit="degC")
    assert value(sheet, "sensitivity") == pytest.approx(10.0 * (np.exp(-2.0) - 1.0), rel=1e-3)
    assert sheet.figures["sensitivity"].value.unit == "kOhm/degC"
    assert sheet.full_scale > 0.0


def test_intervals_hold_what_they_say():
    """Noise of 1 %, cycles that scatter by 2 %: the true full-scale output is inside in nineteen of twenty logs."""
    x = cycles(5, seconds=10.0)
    inside = 0
    for seed in range(100):
        random = np.random.default_rng(seed)
        gains = np.repeat(1.0 + 0.02 * random.normal(size=5), 200)
        reading = np.append(gains, gains[-1]) * x + 0.01 * random.normal(size=x.size)
        figure = sheet_of(reading, x).figures["output"].value
        inside += figure.low <= 1.0 <= figure.high
    assert 88 <= inside <= 100


def test_figures_that_noise_makes_are_named_as_such():
    x = cycles(5)
    noisy = x + 0.003 * np.random.default_rng(1).normal(size=x.size)
    sheet = sheet_of(noisy, x)
    assert any(note.startswith("hysteresis and repeatability: ") for note in sheet.notes)
    reading = noisy + dehyst.PrandtlIshlinskii([0.02], [0.5]).simulate(x)
    assert not any("noise of the readings" in note for note in sheet_of(reading, x).notes)


def test_noise_of_the_quantity_parts_no_cycle():
    x = cycles(5, hold=20.0)
    noisy = x + 0.01 * np.random.default_rng(0).normal(size=x.size)
    sheet = sheet_of(x, noisy)
    assert len(sheet.cycles) == 5
    assert value(sheet, "sensitivity") == pytest.approx(1.0, rel=0.05)


@given(st.integers(0, 10**6))
@settings(max_examples=20, deadline=None)
def test_the_noise_of_one_cycle_makes_its_intervals(seed):
    """One cycle does not scatter: the zero return of a sensor that has none lies within what its noise makes."""
    x = cycles(1, seconds=60.0)
    noisy = x + 0.002 * np.random.default_rng(seed).normal(size=x.size)
    figure = sheet_of(noisy, x).figures["zero_return"].value
    half = figure.high - figure.value
    # A line through twelve samples errs at its end by about 2 / sqrt(12) of their noise.
    assert 0.1 < half < 0.6 and abs(figure.value) < 4.0 * half


def test_a_first_cycle_from_rest_is_named():
    x = cycles(5)
    first = np.where(np.arange(x.size) < 400, 0.02 * (1.0 - x), 0.0)
    sheet = sheet_of(x + first, x)
    assert any("first cycle" in note and "--from" in note for note in sheet.notes)
    assert not sheet_of(x, x).notes


# Logs that lack something


def test_one_direction_alone_has_no_hysteresis_and_says_so():
    one = np.append(np.linspace(0.0, 1.0, 400), 0.0)
    x = np.tile(one[:-1], 4)
    record = dehyst.Recording(x, x, breaks=(400, 800, 1200))
    sheet = sensor_data_sheet(record)
    for name in ("hysteresis", "zero_return"):
        assert np.isnan(value(sheet, name)) and "rising strokes only" in sheet.figures[name].why
    assert value(sheet, "repeatability") == pytest.approx(0.0, abs=1e-9)
    assert len(sheet.rising) == 4 and not sheet.cycles
    assert any(sentence.startswith("hysteresis, zero return: ") for sentence in sheet.lacking)


def test_one_cycle_has_no_repeatability_and_says_so():
    x = cycles(1)
    sheet = sheet_of(x, x)
    assert "three cycles" in sheet.figures["repeatability"].why
    assert any("noise alone" in note for note in sheet.notes)


def test_cycles_from_above_have_no_zero_return():
    x = 1.0 - cycles(2)
    sheet = sheet_of(x[:1200], x[:1200])
    assert len(sheet.cycles) == 1  # Between the two falling strokes a whole cycle rises first.
    sheet = sheet_of(x[:801], x[:801])
    assert len(sheet.cycles) == 1 and "upper end" in sheet.figures["zero_return"].why


@pytest.mark.parametrize(
    "reading, quantity, words",
    [
        (np.ones(500), cycles(1)[:500], "reading 'input' stands still"),
        (cycles(1)[:500], np.ones(500), "quantity 'output' stands still"),
        (np.sin(np.pi * cycles(2)), cycles(2), "full-scale output"),
    ],
)
def test_a_log_without_a_sensor_says_why(reading, quantity, words):
    with pytest.raises(ExcitationError, match=words):
        sheet_of(reading, quantity)


def test_without_a_full_stroke_it_says_which_is_the_longest():
    ends = [0.3, 1.0, 0.2, 0.8, 0.0]
    x = np.concatenate([np.linspace(a, b, 300) for a, b in itertools.pairwise(ends)])
    with pytest.raises(ExcitationError, match="80 % of it"):
        sheet_of(x, x, output_unit="N")


def test_an_unknown_line_names_those_there_are():
    with pytest.raises(ParameterError, match="terminal, best, zero, ideal"):
        sheet_of(cycles(2), cycles(2), "straight")


def test_samples_that_do_not_count_make_no_figure():
    x = cycles(3)
    reading = x.copy()
    reading[1234] = 40.0
    record = dehyst.Recording(reading, x, STEP * np.arange(x.size), left_out=(1234,))
    assert value(sensor_data_sheet(record), "combined") == pytest.approx(0.0, abs=1e-3)


def test_it_is_drawn_and_shown():
    x = cycles(3, hold=20.0)
    sheet = sheet_of(x + bent(x), x, input_name="bridge")
    axes = sheet.plot()
    texts = " ".join(text.get_text() for text in axes.texts)
    for word in ("non-linearity", "hysteresis", "repeatability", "creep"):
        assert word in texts
    assert "<svg" in sheet._repr_html_()


def test_one_direction_alone_is_drawn_too():
    x = np.tile(np.linspace(0.0, 1.0, 400), 3)
    sheet = sensor_data_sheet(dehyst.Recording(x + bent(x), x, breaks=(400, 800)))
    texts = " ".join(text.get_text() for text in sheet.plot().texts)
    assert "repeatability" in texts and "hysteresis" not in texts


def test_a_signal_that_one_recording_lacks_is_left_out():
    x = cycles(3)
    warm = dehyst.Recording(x, x, schedules={"body": 20.0 + x})
    sheet = sensor_data_sheet([warm, dehyst.Recording(x, x)])
    assert not any("body" in name for name in sheet.figures)
    assert len(sheet.cycles) == 6
