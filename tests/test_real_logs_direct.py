"""The direct inverse on measured logs: smaller held-out error of the input than the inverse of every forward family."""

import sys

import pytest

import dehyst
from places import ROOT

sys.path.insert(0, str(ROOT / "benchmarks"))

import direct_inverse as table

pytestmark = pytest.mark.skipif(
    not (table.DATA / "piezo_dbo" / "data.csv.gz").is_file(), reason="no measured logs in ../shared"
)
BETTER = [run for run in table.RUNS if run[0] in (table.PIEZO, table.ARM, table.CAVATAPPI)]
# Since eps is chosen, the inverse of a forward family is closer on these (decision 33).
FORWARD_CLOSER = {
    "cavatappi_muscle 200g_s2_t1",
    "cavatappi_muscle 200g_s3_t1",
    "cavatappi_muscle 400g_s3_t1",
}
DECISION = next((ROOT / "docs" / "decisions").glob("0025-*.md"))


@pytest.mark.slow
@pytest.mark.spread(5)
@pytest.mark.parametrize("run", BETTER, ids=lambda run: table.name_of(*run).replace(" ", "-"))
def test_the_input_is_closer_than_through_any_forward_family_and_the_decision_shows_it(run):
    row = table.measure(*run)
    assert row["held_out"]
    assert (row["input"] < row["input_forward"]) == (row["log"] not in FORWARD_CLOSER)
    lines = [
        line
        for line in DECISION.read_text(encoding="utf-8").splitlines()
        if line.startswith(f"| {row['log']} |")
    ]
    assert len(lines) == 1
    shown = [float(cell.strip("* ").split()[0].strip("*")) for cell in lines[0].split("|")[2:6]]
    measured = [row["input"], row["input_forward"], row["output"], row["output_forward"]]
    assert shown == pytest.approx(measured, rel=0.02, abs=0.02)


@pytest.mark.slow
def test_read_forward_it_is_the_best_model_of_the_piezo():
    for run in table.RUNS[:3]:
        row = table.measure(*run)
        assert row["output"] < row["output_forward"]


@pytest.mark.slow
def test_a_damper_is_not_called_a_compensator():
    rec = dehyst.read_log(
        table.DATA / "mr_damper" / "data.csv.gz", *table.DAMPER[1:], run="ensaio1.2"
    )
    fit = dehyst.identify(rec, "direct-inverse")
    assert {"poor-fit", "static-as-good"} <= {finding.code for finding in fit.warnings}
    assert "do not compensate with it" in fit.verdict
