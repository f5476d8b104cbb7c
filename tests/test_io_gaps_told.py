"""Rows that reading left out are said once; rows that the logger lost are a gap."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import dehyst
from dehyst.io.write import write_csv

T = 0.02 * np.arange(3000.0)
X = np.sin(2 * np.pi * T / 12.0)


def codes(path: Path) -> list[str]:
    return [finding.code for finding in dehyst.read_log(path, "x", "y").findings]


@pytest.mark.parametrize("false", [85.0, np.nan])
def test_rows_left_out_are_said_once(tmp_path: Path, false: float) -> None:
    y = 3.0 * X
    y[1500:1505] = false
    path = write_csv(tmp_path / "log.csv", {"time_s": T, "x": X, "y": y})
    assert codes(path) == ["non-finite" if np.isnan(false) else "outlier"]


def test_rows_that_the_logger_lost_are_a_gap(tmp_path: Path) -> None:
    kept = np.delete(np.arange(3000), slice(1500, 1505))
    path = write_csv(tmp_path / "log.csv", {"time_s": T[kept], "x": X[kept], "y": 3.0 * X[kept]})
    assert codes(path) == ["gap"]
