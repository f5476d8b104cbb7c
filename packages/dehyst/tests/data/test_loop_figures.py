"""Numbers of loops: textbook loops, generated ones with noise, minor loops, half loops, units, and bad logs."""

import itertools
import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import dehyst
from dehyst.data import measure_loops
from dehyst.data._loop_numbers import LoopEstimate
from dehyst.errors import ExcitationError
from dehyst.units import work_unit
from places import DATA

TIPS = (-1.0, 1.0)


def zigzag(tips, steps=500):
    """Straight ways from tip to tip."""
    ways = [np.linspace(a, b, steps, endpoint=False) for a, b in itertools.pairwise(tips)]
    return np.append(np.concatenate(ways), tips[-1])


def rises(x):
    """Whether the input rises, at every sample."""
    step = np.diff(x, append=2 * x[-1] - x[-2])
    return step > 0.0


def core(x, coercivity=0.15, steepness=0.2):
    """Outputs of a textbook loop: tanh((x -+ c) / s) on the rising and the falling branch."""
    return np.tanh((x - np.where(rises(x), coercivity, -coercivity)) / steepness)


def value(measured, name):
    return measured.estimates[name].value


@pytest.mark.parametrize("begin", [0.0, 0.7, np.pi / 2, 4.0])
def test_an_ellipse_has_the_area_pi_a_b_wherever_it_begins(begin):
    a, b, lag = 3.0, 2.0, 0.6
    turn = np.linspace(begin, begin + 2 * np.pi, 801)
    measured = measure_loops(dehyst.Recording(a * np.sin(turn), b * np.sin(turn - lag)))
    assert measured.count == 1
    assert value(measured, "area") == pytest.approx(np.pi * a * b * np.sin(lag), rel=1e-4)
    assert value(measured, "coercivity") == pytest.approx(a * np.sin(lag), rel=1e-3)
    assert value(measured, "remanence") == pytest.approx(b * np.sin(lag), rel=1e-3)
    assert value(measured, "width") == pytest.approx(2 * b * np.sin(lag), rel=1e-3)
    assert value(measured, "width_input") == pytest.approx(2 * a * np.sin(lag), rel=1e-3)
    assert value(measured, "opening_percent") == pytest.approx(100 * np.sin(lag), rel=1e-3)
    assert measured.orientation == "counter-clockwise"
    assert measured.loops[0].closes


def test_a_play_makes_a_parallelogram():
    """Half width r, weight w, range 2 A: the branches are 2 r w apart, the corners 2 r from the turns."""
    r, w, reach = 0.4, 2.5, 3.0
    x = zigzag([0.0, *[reach, -reach] * 4, reach])
    y = dehyst.PrandtlIshlinskii([r], [w]).simulate(x)
    measured = measure_loops(dehyst.Recording(x, y))
    # The first way there and back depends on what was before the log, and is no loop.
    assert measured.count == 3 and all(loop.closes for loop in measured.loops)
    assert value(measured, "width") == pytest.approx(2 * r * w)
    assert value(measured, "coercivity") == pytest.approx(r)
    assert value(measured, "remanence") == pytest.approx(r * w)
    assert value(measured, "area") == pytest.approx(2 * r * w * (2 * reach - 2 * r), rel=1e-4)
    assert value(measured, "opening_percent") == pytest.approx(100 * 2 * r * w / np.ptp(y))
    assert value(measured, "saturation_high") == pytest.approx(w * (reach - r))
    assert value(measured, "slope_to_high") == pytest.approx(w)
    assert value(measured, "slope_from_high") == pytest.approx(0.0, abs=1e-9)
    assert value(measured, "slope_to_low") == pytest.approx(w)
    assert value(measured, "slope_from_low") == pytest.approx(0.0, abs=1e-9)


def test_a_textbook_magnet_has_its_coercivity_remanence_and_area_to_a_thousandth():
    c, s = 0.15, 0.2
    x = zigzag([0.0, *[1.0, -1.0] * 3, 1.0], 1000)
    measured = measure_loops(dehyst.Recording(x, core(x, c, s)))
    area = 2 * s * np.log(np.cosh((1 + c) / s) / np.cosh((1 - c) / s))
    assert value(measured, "coercivity") == pytest.approx(c, rel=1e-3)
    assert value(measured, "remanence") == pytest.approx(np.tanh(c / s), rel=1e-3)
    assert value(measured, "area") == pytest.approx(area, rel=1e-3)
    assert value(measured, "width") == pytest.approx(2 * np.tanh(c / s), rel=1e-3)


def test_with_noise_on_both_signals_they_stay_within_a_hundredth():
    rng = np.random.default_rng(7)
    c, s = 0.15, 0.2
    x = zigzag([0.0, *[1.0, -1.0] * 8, 1.0], 1000)
    y = core(x, c, s) + 0.005 * rng.normal(size=x.size)
    measured = measure_loops(dehyst.Recording(x + 0.002 * rng.normal(size=x.size), y))
    assert measured.basis == "scatter of 7 loops"
    assert value(measured, "coercivity") == pytest.approx(c, rel=0.01)
    assert value(measured, "remanence") == pytest.approx(np.tanh(c / s), rel=0.01)


@pytest.mark.slow
def test_nineteen_of_twenty_generated_loops_are_within_their_intervals():
    """Of 200 logs of six noisy loops, and of 200 with one loop; the interval is one of 95 %."""
    r, w, reach = 0.4, 2.5, 3.0
    truth = {
        "width": 2 * r * w,
        "coercivity": r,
        "remanence": r * w,
        "area": 2 * r * w * (2 * reach - 2 * r),
        "slope_to_high": w,
        "saturation_low": -w * (reach - r),
    }
    clean_six = zigzag([0.0, *[reach, -reach] * 6, reach], 150)
    clean_one = zigzag([0.0, reach, -reach, reach], 150)
    for clean in (clean_six, clean_one):
        y = dehyst.PrandtlIshlinskii([r], [w]).simulate(clean)
        hits = dict.fromkeys(truth, 0)
        for seed in range(200):
            noise = np.random.default_rng(seed).normal(size=y.size)
            measured = measure_loops(dehyst.Recording(clean, y + 0.05 * noise))
            for name, true in truth.items():
                estimate = measured.estimates[name]
                hits[name] += estimate.low <= true <= estimate.high
        assert min(hits.values()) > 0.88 * 200, hits
        # An interval that always holds the truth is too wide.
        assert min(hits.values()) < 200, hits


@given(st.floats(0.05, 0.9), st.floats(0.1, 5.0), st.floats(1.0, 50.0), st.integers(1, 5))
def test_scales_of_both_signals_scale_the_numbers(threshold, gain, scale, cycles):
    x = zigzag([0.0, *TIPS * cycles, -1.0], 120)
    y = dehyst.PrandtlIshlinskii([0.0, threshold], [0.3, 1.0]).simulate(x)
    plain = measure_loops(dehyst.Recording(x, y))
    scaled = measure_loops(dehyst.Recording(scale * x, gain * y))
    factors = {
        "width": gain,
        "coercivity": scale,
        "area": gain * scale,
        "opening_percent": 1.0,
        "slope_to_high": gain / scale,
    }
    for name, factor in factors.items():
        wanted = factor * value(plain, name)
        assert value(scaled, name) == pytest.approx(wanted, rel=1e-6, abs=1e-9 * factor), name


@pytest.mark.slow
@given(st.integers(0, 10_000))
def test_negating_the_input_turns_the_direction_round_and_nothing_else(seed):
    rng = np.random.default_rng(seed)
    x = zigzag([0.0, *TIPS * 4, -1.0], 150)
    y = core(x, 0.1 + 0.2 * rng.random()) + 0.003 * rng.normal(size=x.size)
    plain = measure_loops(dehyst.Recording(x, y))
    mirrored = measure_loops(dehyst.Recording(-x, y))
    directions = {plain.orientation, mirrored.orientation}
    assert directions == {"counter-clockwise", "clockwise"}
    for name in ("width", "area", "coercivity", "remanence"):
        assert value(mirrored, name) == pytest.approx(value(plain, name), rel=0.02)
    assert value(mirrored, "slope_to_low") == pytest.approx(
        -value(plain, "slope_to_high"), abs=0.05
    )


def test_a_friction_runs_clockwise_and_a_figure_of_eight_crosses_itself():
    x = zigzag([0.0, *TIPS * 3, -1.0])
    friction = dehyst.StopOperatorModel([0.0, 0.2], [0.0, 1.0], 0.0).simulate(x)
    assert measure_loops(dehyst.Recording(x, friction)).orientation == "clockwise"
    turn = np.linspace(0.0, 6 * np.pi, 3001)
    eight = measure_loops(dehyst.Recording(np.cos(turn), np.sin(2 * turn)))
    assert eight.orientation == "mixed"
    line = measure_loops(dehyst.Recording(x, 3 * x))
    assert line.orientation == "none" and value(line, "area") == pytest.approx(0.0, abs=1e-9)


def test_a_flag_is_open_at_its_ends_and_has_no_width_in_the_middle():
    """A self-centring brace: force 1 where it goes out and 0.6 where it comes back, on both sides of zero."""
    x = zigzag([0.0, *TIPS * 3, -1.0], 2000)
    outward = rises(x) == (x > 0.0)
    y = np.sign(x) * np.minimum(np.abs(x) / 0.05, np.where(outward, 1.0, 0.6))
    measured = measure_loops(dehyst.Recording(x, y))
    assert value(measured, "width") == pytest.approx(0.0, abs=1e-9)
    assert value(measured, "opening_percent") == pytest.approx(100 * 0.4 / 2.0, rel=1e-3)
    assert measured.orientation == "clockwise"


def test_loops_inside_others_are_loops_of_their_own():
    """A large loop with three small ones on its way: the large one has the area that it has without them."""
    model = dehyst.PrandtlIshlinskii([0.0, 0.1, 0.4], [1.0, 0.5, 0.5])
    small = [-0.2, 0.3]
    with_small = zigzag([-1.0, *TIPS, -1.0, *TIPS, *small * 3, -0.2, 1.0, -1.0])[500:]
    plain = zigzag([-1.0, *TIPS * 2, -1.0, 1.0, -1.0])
    measured = measure_loops(dehyst.Recording(with_small, model.simulate(with_small)))
    alone = measure_loops(dehyst.Recording(plain, model.simulate(plain)))
    sizes = sorted(round(loop.depth, 6) for loop in measured.loops)
    assert sizes.count(0.5) == 3 and sizes.count(2.0) >= 1
    small_loops = [loop for loop in measured.loops if loop.depth < 0.6]
    assert np.ptp([loop.area for loop in small_loops]) == pytest.approx(0.0, abs=1e-9)
    for loop in measured.loops:
        if loop.depth > 1.9:
            assert loop.area == pytest.approx(value(alone, "area"), rel=1e-3)
            assert loop.closes


def test_a_motion_that_dies_away_makes_loops_that_do_not_close():
    t = np.linspace(0.0, 40.0, 4000)
    fade = np.exp(-t / 20.0)
    measured = measure_loops(dehyst.Recording(np.sin(t) * fade, np.sin(t - 0.2) * fade, t))
    assert measured.count >= 4
    assert not any(loop.closes for loop in measured.loops)
    starts = [loop.start for loop in measured.loops]
    assert starts == sorted(starts)


def test_an_actuator_that_wears_changes_from_cycle_to_cycle():
    """The weight falls by 1 % of its first value each cycle, of which there are 20; the other one does not wear."""
    rng = np.random.default_rng(2)
    x = zigzag([0.0, *TIPS * 20, -1.0], 200)
    wear = 1.0 - 0.01 * np.arange(x.size) / 400.0
    play = dehyst.PrandtlIshlinskii([0.2], [1.0]).simulate(x)
    noise = 0.003 * rng.normal(size=x.size)
    worn = measure_loops(dehyst.Recording(x, play * wear + noise)).trends
    fresh = measure_loops(dehyst.Recording(x, play + noise)).trends
    for name in ("width", "area", "gain"):
        # In percent of the mean, which is about 0.9 of the first.
        assert worn[name].value == pytest.approx(-1.0 / 0.9, rel=0.05), name
        assert worn[name].is_change
        assert fresh[name].low < 0.0 < fresh[name].high or abs(fresh[name].value) < 0.05


def test_three_loops_have_no_trend():
    x = zigzag([0.0, *TIPS * 3, -1.0])
    assert measure_loops(dehyst.Recording(x, core(x))).trends == {}


def test_half_a_loop_is_completed_only_where_somebody_says_so():
    x = np.linspace(-1.0, 1.0, 1001)
    record = dehyst.Recording(x, np.tanh((x - 0.15) / 0.2))
    with pytest.raises(ExcitationError, match="--symmetric") as fault:
        measure_loops(record)
    assert fault.value.facts["turns"] == 0
    measured = measure_loops(record, symmetric=True)
    assert measured.loops[0].completed
    assert value(measured, "coercivity") == pytest.approx(0.15, rel=1e-3)
    # Where there is a whole loop the word changes nothing.
    turned = zigzag([0.0, *TIPS * 2, -1.0])
    whole = dehyst.Recording(turned, core(turned))
    assert measure_loops(whole, symmetric=True).as_dict() == measure_loops(whole).as_dict()


@pytest.mark.parametrize("symmetric", [False, True])
@pytest.mark.parametrize("x", [np.zeros(50), np.full(9, 1e90)], ids=["zero", "constant"])
def test_an_input_that_stands_still_has_no_loop(x, symmetric):
    with pytest.raises(ExcitationError, match="no closed loop"):
        measure_loops(dehyst.Recording(x, np.arange(float(x.size))), symmetric=symmetric)


@given(
    st.lists(st.sampled_from([-3.0, -1.0, 0.0, 0.5, 2.0, 1e6]), min_size=4, max_size=40),
    st.integers(),
)
def test_no_log_is_too_coarse_for_a_number_or_a_reason(values, seed):
    rng = np.random.default_rng(abs(seed))
    y = rng.normal(size=len(values))
    # Steps of a converter: outputs of some loops, or of all, stand still.
    if seed % 2:
        y = rng.choice([0.0, 0.0, 0.0, 1e-90, 1e90][: 3 + seed % 3], size=len(values))
    try:
        measured = measure_loops(dehyst.Recording(values, y))
    except ExcitationError:
        return
    json.dumps(measured.as_dict())
    for loop in measured.loops:
        assert loop.area >= 0.0 and loop.input_low < loop.input_high


def test_samples_left_out_and_gaps_are_no_part_of_a_loop():
    x = zigzag([0.0, *TIPS * 4, -1.0], 200)
    y = core(x)
    clean = measure_loops(dehyst.Recording(x, y))
    spoilt = y.copy()
    spoilt[[300, 701, 702]] = 50.0
    mended = measure_loops(dehyst.Recording(x, spoilt, left_out=(300, 701, 702)))
    assert value(mended, "area") == pytest.approx(value(clean, "area"), rel=1e-3)
    parted = measure_loops(dehyst.Recording(x, y, breaks=(900,)))
    assert parted.count == clean.count - 1


def test_the_reference_is_zero_only_where_it_lies_well_inside():
    x = zigzag([0.0, *TIPS * 3, -1.0])
    y = core(x)
    assert measure_loops(dehyst.Recording(x, y)).output_reference == "zero"
    shifted = measure_loops(dehyst.Recording(x + 5.0, y + 1.0))
    assert (shifted.input_reference, shifted.output_reference) == ("middle", "middle")
    assert value(shifted, "coercivity") == pytest.approx(0.15, rel=0.01)


@pytest.mark.parametrize(
    ("first", "second", "factor", "unit"),
    [
        ("mm", "N", 1.0, "mJ"),
        ("m", "N", 1.0, "J"),
        ("A/m", "T", 1.0, "J/m3"),
        ("T", "A/m", 1.0, "J/m3"),
        ("kA/m", "T", 1.0, "kJ/m3"),
        ("Oe", "G", 1e-1 / (4 * np.pi), "J/m3"),
        ("V", "C", 1.0, "J"),
        ("V", "µC", 1.0, "uJ"),
        ("deg", "Nm", np.pi / 180, "J"),
        ("rad", "mNm", 1.0, "mJ"),
        ("Pa", "m3", 1.0, "J"),
        ("bar", "L", 100.0, "J"),
        ("kV/cm", "uC/cm2", 1.0, "kJ/m3"),
        ("A", "Wb", 1.0, "J"),
        ("%", "MPa", 1e4, "J/m3"),
        ("in", "lbf", 0.112984829, "J"),
        ("bar", "deg", 1.0, "bar deg"),
        ("V", "um", 1.0, "V um"),
        ("furlong", "", 1.0, ""),
        ("", "", 1.0, ""),
        ("N", "N", 1.0, "N N"),
    ],
)
def test_the_unit_of_a_loss_is_that_of_the_product(first, second, factor, unit):
    assert work_unit(first, second) == (pytest.approx(factor, rel=1e-8), unit)
    assert work_unit(second, first)[0] == pytest.approx(factor, rel=1e-8)


def test_a_loss_is_told_in_joules_where_the_units_make_one():
    turn = np.linspace(0.0, 6 * np.pi, 1501)
    log = dehyst.Recording(
        10 * np.sin(turn), 3 * np.sin(turn - 0.5), input_unit="deg", output_unit="Nm"
    )
    measured = measure_loops(log)
    estimate = measured.estimates["area"]
    assert measured.area_word == "loss" and estimate.unit == "J"
    assert estimate.value == pytest.approx(np.pi * 30 * np.sin(0.5) * np.pi / 180, rel=1e-3)


@pytest.mark.parametrize("sizes", [(1e100, 1e-100), (1e-100, 1e100), (1e99, 1e99), (1.0, 1e-12)])
def test_very_large_and_small_signals_have_numbers_and_short_words(sizes):
    turn = np.linspace(0.0, 8 * np.pi, 801)
    x, y = sizes[0] * np.sin(turn), sizes[1] * np.sin(turn - 0.3)
    measured = measure_loops(dehyst.Recording(x, y))
    assert value(measured, "coercivity") == pytest.approx(sizes[0] * np.sin(0.3), rel=1e-3)
    assert measured.orientation == "counter-clockwise"
    assert max(map(len, measured.words.split())) < 15


@pytest.mark.parametrize(
    ("estimate", "words"),
    [
        ((6.4087, 0.0281, "deg"), "6.409 +- 0.028 deg"),
        ((633.2, 37.4, "mJ"), "633 +- 37 mJ"),
        ((2.0, 0.0, ""), "2"),
        ((0.0, 0.0, "N"), "0 N"),
        ((0.0, 0.25, "N"), "0.00 +- 0.25 N"),
        ((1.43e-6, 9.1e-7, "T"), "1.43e-06 +- 9.1e-07 T"),
        ((1.5e9, 2.2e6, "V"), "1.500e+09 +- 2.2e+06 V"),
        ((np.nan, np.nan, "V"), "unknown"),
        ((3.0, np.inf, "V"), "3 V"),
    ],
)
def test_a_number_has_the_digits_of_its_interval(estimate, words):
    number, half, unit = estimate
    assert str(LoopEstimate(number, number - half, number + half, unit)) == words


def test_what_only_rounding_makes_is_nothing():
    x = np.sin(np.linspace(0.0, 20.0, 1000))
    measured = measure_loops(dehyst.Recording(x, 3.0 * x))
    for loop in measured.loops:
        assert loop.area == loop.opening_percent == loop.width == loop.gap_percent == 0.0


def test_what_identify_says_of_the_opening_is_what_loops_says():
    rng = np.random.default_rng(0)
    x = zigzag([0.0, *[3.0, -3.0] * 6, 3.0], 150)
    y = dehyst.PrandtlIshlinskii([0.4], [2.5]).simulate(x) + 0.02 * rng.normal(size=x.size)
    record = dehyst.Recording(x, y)
    fit = dehyst.identify(record, "pi", n=10)
    measured = measure_loops(record)
    assert fit.facts.width_percent == value(measured, "opening_percent")
    said = fit.as_dict()["loop"]["numbers"]["estimates"]
    assert said["width"]["value"] == value(measured, "width")
    assert fit.facts.loop_words == measured.opening_words


@pytest.mark.slow
@pytest.mark.skipif(
    not (DATA / "magnet_3c90").is_dir(), reason="no measured logs beside the repository"
)
def test_the_loss_of_a_measured_magnet_is_the_integral_of_its_loop():
    """Oracle: H dB by the rule of trapezoids from an upper turn of B to where B comes back to it."""
    data = np.load(DATA / "magnet_3c90" / "sequences.npz")
    ratios = []
    for flux, field in zip(data["B"].astype(float), data["H"].astype(float), strict=True):
        record = dehyst.Recording(flux, field, input_unit="T", output_unit="A/m")
        measured = measure_loops(record)
        assert measured.units["work"] == "J/m3"
        for loop in measured.loops:
            # A loop that others were taken out of is no stretch of the log.
            inside = np.arange(np.floor(loop.start) + 1, np.ceil(loop.end))
            if loop.path.shape[1] != inside.size + 2:
                continue
            places = np.concatenate([[loop.start], inside, [loop.end]])
            b, h = (np.interp(places, np.arange(flux.size), signal) for signal in (flux, field))
            assert b[0] == pytest.approx(b[-1], abs=1e-9)
            integral = abs(float(np.sum(0.5 * (h[1:] + h[:-1]) * np.diff(b))))
            ratios.append(loop.area / integral)
    assert len(ratios) > 300
    assert np.median(ratios) == pytest.approx(1.0, abs=0.02)
