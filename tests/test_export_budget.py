"""The instructions that `dehyst export` prints are those that were counted, and no fewer."""

import json
from pathlib import Path

import numpy as np
import pytest

from dehyst.export import subject_of
from dehyst.export.budget import budget
from export_samples import large_model, mapped_model

RESULT = Path(__file__).parents[1] / "benchmarks" / "results" / "target.json"


@pytest.fixture(scope="module")
def counted():
    return json.loads(RESULT.read_text(encoding="utf-8"))


@pytest.mark.parametrize("real", ["float", "double"])
def test_lines_lie_above_everything_that_was_counted(counted, real):
    assert set(counted) == {"cortex-m4f", "cortex-m7", "x86-64"}
    for n in (2, 14, 64):
        printed = budget(subject_of(large_model(n), name="unit", real=real)).instructions
        for name, entry in counted.items():
            row = entry[real]["steps"][str(n)]
            assert row["most"] <= printed[name]["most"] <= 1.6 * row["most"]
            assert row["most"] == max(value for key, value in row.items() if key != "typical")
            assert row["typical"] <= printed[name]["typical"] <= row["most"]


def test_maps_cost_more():
    plain, mapped = (budget(subject_of(model, name="unit")).instructions for model in (large_model(4), mapped_model()))
    assert all(mapped[name]["most"] > plain[name]["most"] + 50 for name in plain)


def test_the_14_play_inverse_in_float_on_a_cortex_m4f_takes_20_instructions_a_play(counted):
    row = counted["cortex-m4f"]["float"]["steps"]["14"]
    assert np.max([row["typical"], row["none"], row["all"]]) <= 20 * 14
    assert row["free"] <= 22 * 14  # whatever number of operators moves
