"""TDMS of LabVIEW: scales, units and clocks of channels."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from dehyst.io import read_log, read_table

nptdms = pytest.importorskip("nptdms", reason="the extra dehyst[tdms] is not installed")

RAMP = np.arange(40)
LINEAR = {
    "NI_Scale[0]_Scale_Type": "Linear",
    "NI_Scale[0]_Linear_Slope": 0.5,
    "NI_Scale[0]_Linear_Y_Intercept": 3.0,
}
LINEAR |= {"NI_Scale[0]_Linear_Input_Source": 0xFFFFFFFF}
WAVE = {"wf_increment": 0.01, "wf_start_offset": 0.0}


def table_of(path: Path, **channels: tuple[Any, dict[str, Any]]) -> Any:
    with nptdms.TdmsWriter(path) as out:
        out.write_segment(
            [
                nptdms.ChannelObject("rig", name, v, properties=p)
                for name, (v, p) in channels.items()
            ]
        )
    return read_table(path)


def test_scales_are_applied_and_unknown_ones_named(tmp_path: Path) -> None:
    scaled = {"NI_Number_Of_Scales": 1, "NI_Scaling_Status": "unscaled", **LINEAR}
    unknown = {**scaled, "NI_Scale[0]_Scale_Type": "Sigmoid"}
    ready = {**unknown, "NI_Scaling_Status": "scaled"}
    table = table_of(tmp_path / "log.tdms", x=(RAMP, scaled), y=(RAMP, unknown), z=(RAMP, ready))
    np.testing.assert_allclose(table.columns["x"], 0.5 * RAMP + 3.0)
    np.testing.assert_array_equal(table.columns["y"], RAMP)
    assert [finding.code for finding in table.findings] == ["attributes-left"]
    assert "'y'" in table.findings[0].message and "Sigmoid" in table.findings[0].message


@pytest.mark.parametrize(("unit", "second"), [("s", 1.0), ("ms", 1e-3), ("", 1.0), ("min", 60.0)])
def test_increments_count_in_their_unit(tmp_path: Path, unit: str, second: float) -> None:
    wave = {**WAVE, "wf_xunit_string": unit, "unit_string": "Bar"}
    table = table_of(tmp_path / "log.tdms", x=(RAMP, wave), y=(RAMP, wave))
    np.testing.assert_allclose(table.columns[table.clocks["x"]], RAMP * 0.01 * second)
    assert table.units["x"] == "bar"


def test_a_spectrum_has_no_clock(tmp_path: Path) -> None:
    table = table_of(tmp_path / "log.tdms", x=(RAMP, {**WAVE, "wf_xunit_string": "Hz"}))
    assert table.clocks == {} and list(table.columns) == ["x"]


def test_waveforms_that_began_at_different_times_are_not_one_recording(tmp_path: Path) -> None:
    first = np.datetime64("2024-05-01T10:00:00.000000", "us")
    for later, together in ((np.timedelta64(4, "ms"), 40), (np.timedelta64(100, "ms"), 30)):
        table_of(
            tmp_path / "log.tdms",
            x=(np.sin(RAMP), {**WAVE, "wf_start_time": first}),
            y=(np.cos(RAMP), {**WAVE, "wf_start_time": first + later}),
        )
        assert len(read_log(tmp_path / "log.tdms", "x", "y")) == together
