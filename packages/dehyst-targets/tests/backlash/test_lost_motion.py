"""Lost motion of readings: identities, chance, and what the data show that no table compensates."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from backlash_machines import Axis, Plain, measure, write_sheet
from dehyst.errors import DehystError
from dehyst_targets.backlash import (
    POLICY,
    AxisReadings,
    LostMotion,
    lost_motion,
    make_table,
    read_measurement,
)

POINTS = np.linspace(0.0, 300.0, 7)


def readings(play=0.04, pitch=0.0, repeats=3, noise=1e-3, seed=0, points=POINTS, change=None):
    rows = measure(Plain(Axis(play, pitch)), points, repeats, noise=noise, seed=seed)
    _, point, rising, value = map(np.array, zip(*rows, strict=True))
    error = value - point
    if change is not None:
        change(error)
    return AxisReadings.of(point, error, rising, unit="mm")


def codes(lost):
    return {finding.code for finding in lost.findings}


def select(made, part):
    return AxisReadings.of(made.commanded[part], made.error[part], made.rising[part], unit="mm")


@settings(max_examples=30, deadline=None)
@given(st.floats(-5.0, 5.0), st.integers(0, 5))
def test_a_shift_of_all_readings_is_the_offset_and_changes_nothing_else(shift, seed):
    made = readings(pitch=lambda x: 1e-2 * np.sin(x / 40.0), seed=seed)
    plain = lost_motion(made)
    moved = lost_motion(AxisReadings.of(made.commanded, made.error + shift, made.rising, unit="mm"))
    assert moved.offset - plain.offset == pytest.approx(shift, abs=1e-9)
    np.testing.assert_allclose(moved.rising, plain.rising, atol=1e-9)
    np.testing.assert_allclose(moved.interval, plain.interval, rtol=1e-6)


def test_the_order_of_readings_does_not_change_means_and_spread():
    made = readings()
    order = np.random.default_rng(3).permutation(made.size)
    one, other = lost_motion(made), lost_motion(select(made, order))
    np.testing.assert_allclose(one.lost_motion, other.lost_motion, atol=1e-12)
    assert one.spread == pytest.approx(other.spread)


def test_directions_exchanged_turn_the_sign_and_no_table_is_written():
    made = readings()
    turned = lost_motion(AxisReadings.of(made.commanded, made.error, ~made.rising, unit="mm"))
    np.testing.assert_allclose(turned.lost_motion, -lost_motion(made).lost_motion)
    for machine in ("linuxcnc", "grblhal", "marlin", "klipper"):
        table = make_table(turned, machine)
        assert table.reason.code == "backlash-sign" and not table.files


@pytest.mark.slow
def test_the_interval_is_that_of_two_means_with_a_pooled_deviation():
    stats = pytest.importorskip("scipy.stats")
    made = readings(repeats=4)
    lost = lost_motion(made)
    groups = [
        made.error[(made.commanded == point) & (made.rising == rising)]
        for point in POINTS
        for rising in (True, False)
    ]
    pooled = np.sqrt(np.mean([group.var(ddof=1) for group in groups]))
    assert lost.spread == pytest.approx(pooled) and lost.freedom == 14 * 3
    expected = stats.t.ppf(0.975, 14 * 3) * pooled * np.sqrt(2.0 / 4.0)
    np.testing.assert_allclose(lost.interval, expected)
    assert lost.mean_interval == pytest.approx(expected / np.sqrt(POINTS.size))


@pytest.mark.slow
@pytest.mark.parametrize("repeats", [1, 3])
def test_without_play_chance_is_taken_for_lost_motion_as_seldom_as_is_said(repeats):
    """Two tests at 1 %, of the mean and of all points together: 2 % at most."""
    runs, alarms, pitches = 400, 0, 0
    for seed in range(runs):
        lost = lost_motion(readings(0.0, repeats=repeats, seed=seed))
        alarms += lost.is_significant
        pitches += lost.is_pitch_significant
    # 400 runs at 2 %: 8 are expected, 18 come by chance less than once in 1000.
    assert alarms <= 18 and pitches <= 18


@pytest.mark.slow
def test_intervals_hold_the_truth_as_often_as_they_say():
    inside = 0
    for seed in range(200):
        lost = lost_motion(readings(0.04, seed=seed))
        inside += int(np.sum(np.abs(lost.lost_motion - 0.04) <= lost.interval))
    share = inside / (200 * POINTS.size)
    assert abs(share - (1.0 - POLICY.outside)) < 0.02


def test_a_small_play_is_seen_once_it_is_measured_often_enough():
    assert not lost_motion(readings(3e-4, repeats=1, seed=1)).is_mean_significant
    assert lost_motion(readings(3e-4, repeats=100, seed=1)).is_mean_significant


def test_readings_that_were_rounded_alike_have_the_spread_of_the_rounding(tmp_path):
    rows = measure(Plain(Axis(0.04)), POINTS, 3)
    lost = lost_motion(read_measurement(write_sheet(tmp_path / "m.csv", rows, digits=2)))
    assert lost.spread == pytest.approx(0.01 / np.sqrt(12.0))
    assert np.all(lost.interval > 0.0)


# Outliers.


def test_a_slip_of_the_pen_is_left_out_and_named():
    clean = readings()

    def slip(error):
        error[5] += 0.1

    lost = lost_motion(readings(change=slip))
    assert codes(lost) == {"backlash-outlier"}
    expected = lost_motion(select(clean, np.arange(clean.size) != 5))
    np.testing.assert_allclose(lost.rising, expected.rising)
    np.testing.assert_allclose(lost.falling, expected.falling)


def test_two_slips_do_not_hide_each_other():
    def slips(error):
        error[[5, 20]] += 0.1, -0.3

    lost = lost_motion(readings(change=slips))
    assert [finding.code for finding in lost.findings] == ["backlash-outlier"] * 2
    assert lost.spread < 2e-3


def test_of_two_readings_that_differ_none_is_left_out():
    def slip(error):
        error[5] += 0.1

    lost = lost_motion(readings(repeats=2, change=slip))
    (finding,) = [entry for entry in lost.findings if entry.code == "backlash-outlier"]
    assert "both count" in finding.message and lost.counts.min() == 2


def test_good_readings_are_seldom_called_outliers():
    alarms = sum(
        "backlash-outlier" in codes(lost_motion(readings(seed=seed))) for seed in range(200)
    )
    assert alarms <= 8  # 1 % of 200 is 2


def test_a_slip_that_would_send_the_axis_back_is_refused_even_in_one_repeat():
    def slip(error):
        error[4] -= 60.0

    with pytest.raises(DehystError, match="go back while it is told to go on"):
        lost_motion(readings(repeats=1, change=slip))


def test_an_error_that_jumps_is_named():
    def slip(error):
        error[4] -= 2.0

    assert "backlash-steep" in codes(lost_motion(readings(repeats=1, change=slip)))
    assert "backlash-steep" not in codes(lost_motion(readings(repeats=1)))


# What a table does not compensate.


def test_readings_that_creep_away_are_told_from_those_that_only_scatter():
    def warm(error):
        error += np.linspace(0.0, 8e-3, error.size)

    assert "backlash-drift" in codes(lost_motion(readings(change=warm)))
    alarms = sum("backlash-drift" in codes(lost_motion(readings(seed=seed))) for seed in range(200))
    assert alarms <= 8


class Wound(Plain):
    """A machine whose axis follows a turn only after a way, as an elastic one does."""

    def __init__(self, axis, way):
        super().__init__(axis)
        self.way, self.turn, self.sense = way, 0.0, 1.0

    def go(self, target):
        sense = np.sign(target - self.command) or self.sense
        if sense != self.sense:
            self.turn, self.sense = self.command, sense
        self.command = target
        wound = (
            0.5 * self.axis.play(target) * (1.0 - 2.0 * np.exp(-abs(target - self.turn) / self.way))
        )
        return target - sense * wound


def amplitudes(machine, approaches, noise=1e-3):
    point, error, rising, way = [], [], [], []
    for number, approach in enumerate(approaches):
        for row in measure(machine, POINTS, 3, approach, noise, seed=number):
            point.append(row[1])
            rising.append(row[2])
            error.append(row[3] - row[1])
            way.append(approach)
    return AxisReadings(
        np.array(point), np.array(error), np.array(rising), np.array(way), unit="mm"
    )


def test_lost_motion_that_depends_on_the_way_after_a_turn_is_told():
    wound = lost_motion(amplitudes(Wound(Axis(0.04), 0.3), (0.2, 4.0)))
    assert "backlash-amplitude" in codes(wound)
    # The table is of the long way.
    assert wound.mean == pytest.approx(0.04, abs=1.5e-3)
    assert "backlash-amplitude" not in codes(lost_motion(amplitudes(Plain(Axis(0.04)), (0.2, 4.0))))


def test_an_approach_that_the_play_may_be_longer_than_is_told():
    def after(approach):
        return lost_motion(amplitudes(Plain(Axis(1.0)), (approach,)))

    short, long = after(0.6), after(4.0)
    assert "backlash-approach" in codes(short) and "backlash-approach" not in codes(long)
    # It is really less than the play: the axis did not follow to the end.
    assert short.mean < 0.7 and long.mean == pytest.approx(1.0, abs=2e-3)


def test_a_wrong_scale_is_told_with_the_factor_that_cures_it():
    lost = lost_motion(readings(pitch=lambda x: 0.004 * x))
    (finding,) = [entry for entry in lost.findings if entry.code == "backlash-scale"]
    factor = float(finding.message.split(" by ")[1].split()[0])
    assert factor == pytest.approx(1.0 / 1.004, abs=2e-5)


def test_a_small_scale_error_that_is_larger_over_the_axis_than_the_play_is_told_with_its_factor():
    """0.06 mm over 300 mm, of a play of 0.04 mm."""
    lost = lost_motion(readings(pitch=lambda x: 0.0002 * x))
    (finding,) = [entry for entry in lost.findings if entry.code == "backlash-scale"]
    factor = float(finding.message.split(" by ")[1].split()[0])
    assert factor == pytest.approx(1.0 / 1.0002, abs=1.1e-5)


@pytest.mark.parametrize(
    "pitch", [lambda x: 0.0001 * x, lambda x: 0.1 * np.sin(x / 48.0), lambda x: 0.0 * x]
)
def test_a_wave_of_the_screw_and_a_line_below_the_play_are_no_wrong_scale(pitch):
    assert "backlash-scale" not in codes(lost_motion(readings(pitch=pitch)))


def test_one_repeat_is_said_and_its_spread_is_not_too_small():
    lost = lost_motion(readings(repeats=1, play=lambda x: 0.03 + 1e-4 * x))
    assert "backlash-one-repeat" in codes(lost)
    assert lost.spread > 1e-3 and lost.freedom == POINTS.size - 1


def test_points_of_one_side_are_left_out_and_named():
    made = readings()
    lost = lost_motion(select(made, ~(made.rising & (made.commanded == 100.0))))
    assert "backlash-one-side" in codes(lost) and 100.0 not in lost.nominal
    with pytest.raises(DehystError, match="no point was read from both sides"):
        lost_motion(select(made, made.rising))


def test_one_point_read_once_is_refused_and_twice_is_enough():
    with pytest.raises(DehystError, match="nothing of the repeatability"):
        lost_motion(AxisReadings.of([0.0, 0.0], [0.0, 0.03], [1, 0]))
    lost = lost_motion(AxisReadings.of([0.0] * 4, [0.0, 0.03, 0.001, 0.031], [1, 0, 1, 0]))
    assert lost.mean == pytest.approx(0.03) and lost.is_significant


def test_the_example_is_what_it_says():
    lost = LostMotion.example()
    assert lost.counts.tolist() == [[3, 3, 3], [3, 3, 3]]
    assert lost.between == pytest.approx(0.0, abs=1e-4) and lost.expected > 2.0 * lost.spread
