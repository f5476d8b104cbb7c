"""A clock that is set while a log is written: repaired where the signals go on, left where something may be missing."""

import re

import numpy as np
import numpy.typing as npt
import pytest

import dehyst
from dehyst.io import write_csv
from dehyst.io._clean import Context, Samples, find_gaps
from dehyst.io._order import order_time

Array = npt.NDArray[np.float64]
STEP = 0.025


def cycling(rng, samples, period, triangle, noise):
    phase = np.arange(samples) / period + rng.uniform()
    x = 2.0 * np.abs(2.0 * (phase % 1.0) - 1.0) - 1.0 if triangle else np.sin(2 * np.pi * phase)
    y = np.sin(2 * np.pi * phase - 0.3) + 0.2 * x
    return 3.0 + 3.0 * x + noise * rng.normal(size=samples), 20.0 * (
        y + noise * rng.normal(size=samples)
    )


def prepared(t, x, y):
    about = Context("log", ("x", "y"))
    samples = find_gaps(order_time(Samples(t, (x, y), np.arange(t.size)), about), about)
    return samples, [finding.code for finding in about.findings]


def changed(kind, t, k, rng):
    t = t.copy()
    if kind == "there and back":
        t[k : k + int(rng.integers(2, 12))] += rng.choice([1.0, -1.0, 0.3, 5.0])
    else:
        t[k:] += {
            "forward": rng.uniform(1, 50), "back": -rng.uniform(0.3, 50), "summer": 3600.0, "winter": -3600.0,
            "rollover": -t[k],
        }[kind]  # fmt: skip
    return t


@pytest.mark.parametrize(
    "kind", ["there and back", "forward", "back", "summer", "winter", "rollover"]
)
def test_a_clock_that_was_set_is_one_clock(kind):
    rng = np.random.default_rng(3)
    whole = 0
    for _ in range(60):
        x, y = cycling(rng, 2000, float(rng.choice([40.0, 200.0, 1000.0])), bool(rng.integers(0, 2)),
                       float(rng.choice([0.0, 1e-4, 1e-3, 1e-2])))  # fmt: skip
        t = STEP * np.arange(x.size) + rng.uniform(0.0, 1e4)
        samples, codes = prepared(changed(kind, t, int(rng.integers(30, x.size - 60)), rng), x, y)
        assert samples.time is not None
        assert codes in (["clock-jump"], ["gap"], ["clock-restart"])  # never without a word
        if samples.breaks or codes == ["gap"]:
            continue
        whole += 1
        np.testing.assert_allclose(np.diff(samples.time), STEP, rtol=0.06)
        assert samples.rows.size == x.size
    assert whole >= (
        60 if kind == "there and back" else 56
    )  # at a corner nothing tells that a signal goes on


def test_one_clock_has_one_explanation_at_corners_too():
    rng = np.random.default_rng(5)
    x, y = cycling(rng, 2000, 200.0, True, 0.0)
    corners = np.flatnonzero(np.diff(np.sign(np.diff(x))) != 0)[:2] + 1
    t = STEP * np.arange(x.size)
    for k, place in enumerate(sorted([*corners.tolist(), 450, 870, 1190, 1610, 1830])):
        t[place:] += 0.7 if k % 2 else -0.7
    samples, codes = prepared(t, x, y)
    assert codes == ["clock-jump"] and not samples.breaks and samples.time is not None
    np.testing.assert_allclose(np.diff(samples.time), STEP, rtol=0.06)


def test_another_recording_and_lost_samples_stay_what_they_are():
    rng = np.random.default_rng(4)
    taken = 0
    for _ in range(120):
        period, triangle = float(rng.choice([40.0, 200.0])), bool(rng.integers(0, 2))
        x, y = cycling(rng, 2000, period, triangle, 1e-3)
        t, k = STEP * np.arange(2000.0), int(rng.integers(100, 1500))
        if rng.integers(0, 2):
            x[k:], y[k:] = (v[k:] for v in cycling(rng, 2000, period, triangle, 1e-3))
            t[k:] -= t[k]
        else:
            lost = slice(k, k + int(rng.integers(30, int(2 * period) + 30)))
            t, x, y = (np.delete(v, lost) for v in (t, x, y))
        taken += "clock-jump" in prepared(t, x, y)[1]
    assert taken <= 4  # those that begin by chance where the others ended


def test_a_signal_that_rests_does_not_tell_whether_time_passed():
    x, y = cycling(np.random.default_rng(0), 2000, 200.0, False, 0.0)
    x[900:1100], y[900:1100] = x[900], y[900]
    t = STEP * np.arange(2000.0)
    t[1000:] += 100.0
    assert prepared(t, x, y)[1] == ["gap"]


def rig_log(folder):
    """490 cycles in 19 610 rows; three times the clock jumps by 1 s and a few samples later back."""
    rng = np.random.default_rng(11)
    samples, cycles = 19_610, 490
    phase = cycles * np.arange(samples) / samples
    x = (2.0 + 0.02 * rng.normal(size=cycles + 1))[phase.astype(int)] * (
        0.5 - 0.5 * np.cos(2 * np.pi * phase)
    )
    y = dehyst.PrandtlIshlinskii([0.0, 0.2, 0.5], [3.0, 2.0, 2.0]).simulate(x) + 0.02 * rng.normal(
        size=samples
    )
    t = 0.05 * np.arange(samples)
    for k, length in ((3_400, 5), (9_007, 3), (15_733, 8)):
        t[k : k + length] += 1.0
    return write_csv(folder / "rig.csv", {"time_s": t, "pressure_bar": x, "angle_deg": y})


@pytest.mark.slow
def test_a_log_whose_clock_was_corrected_loses_no_sample(tmp_path):
    rec = dehyst.read_log(rig_log(tmp_path), "pressure", "angle")
    assert len(rec) == 19_610 and rec.breaks == ()
    [found] = rec.findings
    assert (
        found.code == "clock-jump"
        and "+1 s, -1 s" in found.message
        and "lines 3402, 3407" in found.message
    )
    fit = dehyst.identify(rec)
    assert int(sum(mask.sum() for mask in (*fit.train_masks, *fit.test_masks))) == 19_610
    assert fit.test is not None and fit.test.rmse_percent < 0.3


def by_events(rng, hand):
    """Rows as an encoder, a dead band or a person writes them: one whenever the output has moved one step."""
    t = np.arange(0.0, 600.0, 0.01)
    pace = np.exp(
        np.interp(t, np.arange(0.0, 620.0, 20.0), rng.normal(0.0, 0.8 if hand else 0.3, 31))
    )
    pace[(t % 97.0) < rng.uniform(0.0, 9.0)] *= 0.02  # rests
    phase = np.cumsum(pace) / np.sum(pace) * rng.integers(4, 20)
    x = 1.0 - np.cos(2.0 * np.pi * phase)
    y = dehyst.PrandtlIshlinskii([0.0, 0.2, 0.5], [3.0, 2.0, 2.0]).simulate(x)
    level = np.floor(y / (np.ptp(y) / rng.integers(40, 300)))
    rows = np.flatnonzero(np.diff(level) != 0.0) + 1
    return t[rows], x[rows], y[rows]


def changed_times(logs):
    """How many logs of events have another time than was written."""
    return [
        k for k, (t, x, y) in enumerate(logs) if not np.array_equal(prepared(t, x, y)[0].time, t)
    ]


def test_a_log_with_a_row_per_event_keeps_its_time():
    rng = np.random.default_rng(8)
    assert changed_times(by_events(rng, bool(k % 2)) for k in range(12)) == []


@pytest.mark.slow
def test_two_hundred_logs_with_a_row_per_event_keep_their_time():
    rng = np.random.default_rng(9)
    assert changed_times(by_events(rng, bool(k % 2)) for k in range(200)) == []


def with_lost_rows(rng, most, noise):
    """A log that lost a few rows in several places, and its true time."""
    x, y = cycling(rng, 6000, float(rng.choice([200.0, 700.0])), bool(rng.integers(0, 2)), noise)
    t = STEP * np.arange(6000.0)
    lost = np.unique(
        np.concatenate(
            [
                k + np.arange(rng.integers(4, most))
                for k in rng.integers(100, 5800, rng.integers(1, 9))
            ]
        )
    )
    return tuple(np.delete(v, lost) for v in (t, x, y))


@pytest.mark.parametrize("noise", [0.0, 1e-3, 2e-2])
def test_rows_that_were_lost_are_never_called_a_clock_that_was_set(noise):
    rng = np.random.default_rng(12)
    for _ in range(40):
        t, x, y = with_lost_rows(rng, 19, noise)
        samples, codes = prepared(t, x, y)
        assert "clock-jump" not in codes
        np.testing.assert_array_equal(samples.time, t)


def in_file(folder, t, x, y):
    return write_csv(folder / "log.csv", {"time_s": t, "pressure_bar": x, "angle_deg": y})


@pytest.mark.parametrize("kind", ["lost", "set", "both"])
def test_what_a_jump_is_does_not_depend_on_the_window(tmp_path, kind):
    rng = np.random.default_rng(21)
    for _ in range(2):
        t, x, y = (
            with_lost_rows(rng, 60, 1e-3)
            if kind != "set"
            else (STEP * np.arange(6000.0), *cycling(rng, 6000, 700.0, False, 1e-3))
        )
        if kind != "lost":
            t = t.copy()
            t[rng.integers(2500, 3500) :] += 3600.0
        file = in_file(tmp_path, t, x, y)
        whole = dehyst.read_log(file, "pressure", "angle")
        assert kind != "lost" or "clock-jump" not in [f.code for f in whole.findings]
        assert kind != "set" or "clock-jump" in [f.code for f in whole.findings]
        rows = whole.provenance["first_row"] + np.arange(t.size)
        for _ in range(5):
            begin, end = np.sort(rng.choice(t, 2, replace=False))
            if np.sum((t >= begin) & (t < end)) < 100:
                continue
            part = dehyst.read_log(file, "pressure", "angle", start=begin, stop=end)
            inside = rows[(t >= begin) & (t < end)][1:]
            expected = [size for row, size in jumps_of(whole) if row in inside]
            assert [size for _, size in jumps_of(part)] == pytest.approx(expected)


def jumps_of(rec):
    """Jumps that were taken out, as the finding prints them."""
    said = [f.message for f in rec.findings if f.code == "clock-jump"]
    if not said:
        return []
    rows = [
        int(row)
        for row in re.search(r"jumps at lines? ([\d, ]+)", said[0])[1].rstrip(", ").split(", ")
    ]
    return list(
        zip(rows, [float(s) for s in re.findall(r"([+-][\d.e+]+) s", said[0])], strict=True)
    )


def test_a_gap_that_may_be_two_things_is_called_so(tmp_path):
    t, x, y = with_lost_rows(np.random.default_rng(3), 19, 0.0)
    [finding] = dehyst.read_log(in_file(tmp_path, t, x, y), "pressure", "angle").findings
    assert (
        finding.code == "gap" and "Rows are missing there, or the clock was set." in finding.message
    )
