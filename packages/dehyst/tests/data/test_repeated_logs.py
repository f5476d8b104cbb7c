"""Claims about one log that is named twice: it is refused or counts once, so that noise never confirms itself."""

from dataclasses import replace

import numpy as np
import pytest

import dehyst
from dehyst import Recording
from dehyst.data import counted_once
from dehyst.data._repeats import shared_samples
from dehyst.errors import ParameterError
from in_one import in_one

SEEDS = range(12)
PLAYS = dehyst.PrandtlIshlinskii([0.0, 0.3, 0.8], [1.0, 0.5, 0.4])


def junk(seed, samples=1500):
    """Two signals that have nothing to do with each other."""
    return np.cumsum(np.random.default_rng(seed).normal(size=(2, samples)), axis=1)


def measured(seed, samples=1500):
    """An actuator with noise on both signals, at 16 bits."""
    rng = np.random.default_rng(seed)
    t = np.linspace(0.0, 60.0, samples)
    x = np.sin(t) * np.cos(0.13 * t)
    signals = np.array([x, PLAYS.simulate(x)]) + rng.normal(size=(2, samples)) * 1e-3
    return np.round(signals * 2**15) / 2**15


def written(values, form):
    return np.array([float(form % value) for value in values.ravel()]).reshape(values.shape)


def named_twice(log, seed):
    """Pairs of logs that share samples, by what was done to the second one."""
    n = log.shape[1]
    left = np.sort(np.random.default_rng(seed).permutation(n)[: 9 * n // 10])
    yield "the same", log, log
    yield "single precision", log, log.astype(np.float32).astype(float)
    yield "six digits", log, written(log, "%.6g")
    yield "three decimals", log, written(log, "%.3f")
    yield "both rounded", written(log, "%.6g"), written(log, "%.3f")
    yield "a window", log, log[:, n // 4 : n // 2]
    yield "a window, rounded", log, written(log[:, n // 4 : n // 2], "%.3f")
    yield "windows that overlap", log[:, : 6 * n // 10], log[:, n // 2 :]
    yield "joined copies", np.tile(log, 2), log
    yield "every second sample", log, log[:, ::2]
    yield "rows lost", log, log[:, left]
    yield "a short part", log, log[:, 300:400]


@pytest.mark.parametrize("make", [junk, measured])
@pytest.mark.parametrize("seeds", [SEEDS[:2], pytest.param(SEEDS[2:], marks=pytest.mark.slow)])
def test_a_log_named_twice_in_twelve_ways_is_found_in_every_one(make, seeds):
    missed = [
        (seed, way)
        for seed in seeds
        for way, first, second in named_twice(make(seed), seed)
        if not shared_samples(Recording(*first), Recording(*second))
    ]
    assert not missed


def test_copies_without_noise_are_found_too():
    x = np.sin(np.linspace(0.0, 60.0, 900)) * np.linspace(1.0, 0.3, 900)
    first = Recording(x, PLAYS.simulate(x))
    for second in (
        first,
        Recording(x[200:500], first.output[200:500]),
        Recording(x.round(4), first.output.round(4)),
    ):
        assert shared_samples(first, second) == len(second)


@pytest.mark.parametrize("bits", [4, 6, 8, 10, 12, 16])
def test_one_motion_measured_twice_is_no_copy(bits):
    t = np.linspace(0.0, 60.0, 3000)
    x = np.sin(t) * np.cos(0.13 * t)
    y = PLAYS.simulate(x)
    step = np.ptp(y) / 2**bits
    for noise in (0.03, 0.1, 0.3, 1.0):  # of a step
        rng = np.random.default_rng(bits)
        outputs = [np.round(y / step + noise * rng.normal(size=y.size)) * step for _ in range(2)]
        first, second = (Recording(x, output) for output in outputs)
        assert shared_samples(first, second) == 0, noise
        assert not counted_once(Recording(np.tile(x, 2), np.concatenate(outputs))).left_out


def test_what_a_simulation_repeats_is_no_copy():
    x = 2.0 * np.sin(np.arange(1200) * 2.0 * np.pi / 100)
    for digits in (2, 4, 15):  # period after period the same numbers
        assert not counted_once(
            Recording(x.round(digits), PLAYS.simulate(x).round(digits))
        ).left_out
    up = np.linspace(0.0, 1.0, 100)  # one way in, then others
    ways = [np.concatenate([up, size * up[::-1], up]) for size in (1.0, 0.9)]
    assert shared_samples(*(Recording(way, PLAYS.simulate(way)) for way in ways)) == 0


DOORS = {
    "identify": dehyst.identify,
    "pi": lambda records: dehyst.identify(records, "pi"),
    "compare": lambda records: dehyst.compare(records, ["static"]),
    "cross_validate": dehyst.cross_validate,
    "direct": lambda *given: dehyst.identify(*given, "direct-inverse"),
    "evaluate": lambda records: dehyst.evaluate(PLAYS, records),
    "drift": lambda records: dehyst.drift(PLAYS, records),
}


@in_one("door", DOORS)
def test_every_call_refuses_the_same_recording_twice(door):
    record = Recording(*measured(1), name="rig.csv")
    with pytest.raises(
        ParameterError, match=r"recordings 1 and 3 \(rig.csv\) hold the same 1500 samples"
    ):
        DOORS[door]([record, Recording(*measured(2)), record])


@pytest.mark.slow
def test_commands_refuse_a_log_named_twice(run, tmp_path):
    x, y = measured(3)
    text = "\n".join(
        ["run,pressure_bar,angle_deg", *(f"a,{p:.5f},{q:.5f}" for p, q in zip(x, y, strict=True))]
    )
    log, copy, link = (tmp_path / name for name in ("a.csv", "copy.csv", "link.csv"))
    for path in (log, copy):
        path.write_text(text)
    link.hardlink_to(log)
    dotted = f"{tmp_path}/./a.csv"
    for logs in (
        [log, log],
        [log, copy],
        [log, dotted],
        [log, link],
        [log, log, log],
        [log, "--run", "a", "--run", "a"],
    ):
        for command in ("identify", "compare"):
            status, _, err = run(command, *logs, "--input", "pressure_bar", "--output", "angle_deg")
            assert status == 2
            assert "the same 1500 samples" in " ".join(err.split())


@pytest.mark.parametrize("copies", [2, 3])
def test_a_file_joined_with_its_copy_counts_once(copies):
    for seed in SEEDS:
        record = Recording(*np.tile(measured(seed), copies))
        once = counted_once(record)
        assert once.left_out == tuple(range(1500, 1500 * copies))
        assert [finding.code for finding in once.findings] == ["repeated-samples"]


def test_a_block_that_was_sent_twice_counts_once():
    log = junk(5)
    again = np.concatenate([log[:, :900], log[:, 700:900], log[:, 900:]], axis=1)
    assert counted_once(Recording(*again)).left_out == tuple(range(900, 1100))


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 7])
def test_joined_copies_of_noise_are_judged_as_the_noise_itself(seed):
    alone = dehyst.identify(Recording(*junk(seed)))
    for copies in (2, 3):
        joined = dehyst.identify(Recording(*np.tile(junk(seed), copies)))
        assert joined.test.rmse == pytest.approx(alone.test.rmse, rel=1e-9)
        assert "do not compensate" in joined.verdict
        assert "repeated-samples" in [finding.code for finding in joined.warnings]


def test_a_shared_name_and_other_findings_stay():
    record = replace(
        Recording(*np.tile(junk(2), 2)), name="rig.csv", findings=(dehyst.Finding("gap", "a gap"),)
    )
    assert [finding.code for finding in counted_once(record).findings] == [
        "gap",
        "repeated-samples",
    ]
    assert "of rig.csv" in counted_once(record).findings[1].message
