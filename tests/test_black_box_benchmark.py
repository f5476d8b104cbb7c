"""Black boxes beside rows: every run was measured, the page says what was, no box sees the half that is held out."""

import json
import sys

import numpy as np
import pytest

import dehyst
from dehyst import Recording
from dehyst.io import example_recording
from places import ROOT

sys.path.insert(0, str(ROOT / "benchmarks"))
sys.path.insert(0, str(ROOT / "docs"))

import black_box as benchmark
from boxes.signals import run_of
from generate import black_boxes

RUNS = json.loads(benchmark.RESULTS.read_text(encoding="utf-8"))["runs"]
TABLE = benchmark.beside(RUNS)


def loop(strokes=6):
    """A few strokes of falling size: output of two plays, rounded by a creep."""
    x = np.sin(np.linspace(0.0, strokes * np.pi, 60 * strokes)) * np.linspace(
        1.0, 0.4, 60 * strokes
    )
    return x, dehyst.PrandtlIshlinskii([0.0, 0.2], [0.5, 0.5]).simulate(x)


def trained(name):
    if name == "gru":
        pytest.importorskip("jax", reason="jax is not installed: pip install --group bench")
    return benchmark.BOXES[name]


def test_every_box_was_trained_on_the_runs_and_samples_of_the_rows():
    rows = json.loads(benchmark.ROWS.read_text(encoding="utf-8"))["runs"]
    named = [tuple(run[key] for key in ("log", "run", "samples")) for run in RUNS]
    assert sorted(named) == sorted(
        tuple(row[key] for key in ("log", "run", "samples")) for row in rows
    )
    for run in RUNS:
        assert set(run["boxes"]) == set(benchmark.BOXES)
        assert [len(box["seeds"]) for box in run["boxes"].values()] == [3, 1, 1, 1]
        for box in run["boxes"].values():
            assert (
                sorted(box["seeds"])[len(box["seeds"]) // 2]
                == box["test_percent"]
                >= abs(box["bias_percent"])
            )


def test_a_run_is_scored_as_identify_scores_it():
    record = example_recording()
    fit = dehyst.identify(record, "play-sum", purpose="simulate")
    run = run_of(record)
    predicted = fit.predictions[0]
    slope = np.polyfit(record.output, run.y, 1)  # the scaling of a run is a line
    rms, bias = run.held_out(np.polyval(slope, predicted))
    assert rms == pytest.approx(fit.test.rmse_percent, rel=1e-9)
    assert abs(bias) < rms


@pytest.mark.exhaustive
@pytest.mark.parametrize("name", benchmark.BOXES)
def test_no_box_sees_the_held_out_half(name, monkeypatch):
    box = trained(name)
    if name == "gru":
        monkeypatch.setattr("boxes.gru.STEPS", 100)
    x, y = loop()
    changed = np.where(np.arange(x.size) < x.size // 2, y, 0.3 * np.cos(9.0 * x) * np.abs(y).max())
    whole, other = (
        run_of(Recording(input=x, output=out, time=0.01 * np.arange(x.size)))
        for out in (y, changed)
    )
    assert not np.array_equal(whole.y, other.y)
    first, second = (box(run.half)[0](run.x) for run in (whole, other))
    assert first.shape == x.shape and np.array_equal(first, second)
    assert whole.held_out(first) != other.held_out(
        second
    )  # the scores are those of what was held out


@pytest.mark.exhaustive
@pytest.mark.parametrize("name", benchmark.BOXES)
def test_a_box_errs_less_than_a_curve_on_a_small_loop(name):
    x, y = loop()
    run = run_of(Recording(input=x, output=y, time=0.01 * np.arange(x.size)))
    error = benchmark.scored(run, trained(name))["test_percent"]
    curve = np.polyval(np.polyfit(run.half.x, run.half.y, 3), run.x)
    assert error < run.held_out(curve)[0]


def test_the_page_has_a_line_for_every_run_with_its_figures():
    lines = black_boxes.page().split("\n\n")[0].splitlines()[2:]
    assert len(lines) == len(TABLE) == 26
    for row, line in zip(TABLE, lines, strict=True):
        cells = [cell.strip(" *") for cell in line.strip("|").split("|")[2:]]
        shown = [cell.split(" (")[0].strip("*") for cell in cells]
        assert shown == [f"{row[name]:.3g}" for name in ("ours", "seventeen", *benchmark.BOXES)]


def test_what_the_page_says_of_black_boxes_is_what_the_numbers_say():
    def of(log):
        return [row for row in TABLE if row["run"].startswith(log)]

    means = {
        over: round(benchmark.mean(benchmark.ratio(TABLE, over)), 2)
        for over in ("best", "kernel", "gru", "narx")
    }
    assert means == {"best": 0.88, "kernel": 0.73, "gru": 0.48, "narx": 0.39}
    assert round(benchmark.mean([row[row["best"]] / row["seventeen"] for row in TABLE]), 2) == 1.02
    arm, muscle = (of(log) for log in ("pneumatic_arm", "cavatappi"))
    assert round(benchmark.mean(benchmark.ratio(arm, "kernel")), 1) == 1.3
    assert round(benchmark.mean(benchmark.ratio(muscle, "kernel")), 1) == 1.0
    assert sum(row["kernel"] < row["ours"] for row in muscle) == 3
    for log in ("tendon_sheath_joint/config", "pam_wrist", "simulated_joint"):
        assert max(benchmark.ratio(of(log), "best")) < 1.0
    (wrist,) = of("pam_wrist")
    assert wrist["family"] == "modified-pi" and 2.5 < wrist["kernel"] / wrist["ours"] < 3.5
    assert sum(row["best"] == "narx" for row in TABLE) == 2
    damper = of("mr_damper")
    assert sum(row["ours"] < row["gru"] for row in damper) == 2 and len(damper) == 4
    assert round(benchmark.mean(benchmark.ratio(damper, "gru")), 2) == 0.84
    assert sum(row["ours"] < row["gru"] for row in arm) == 2 and len(arm) == 4
    spread = max(
        max(run["boxes"]["gru"]["seeds"]) / min(run["boxes"]["gru"]["seeds"]) for run in RUNS
    )
    assert 2.4 < spread < 2.6


@pytest.mark.slow
def test_a_network_has_as_many_numbers_as_the_page_says():
    jax = pytest.importorskip("jax", reason="jax is not installed: pip install --group bench")
    from boxes import gru

    assert sum(leaf.size for leaf in jax.tree.leaves(gru.born(0, 100.0))) == 1971
