"""Measured logs of five actuators and a damper, when they are at hand: the promised accuracy, and nothing lost since.

The logs may not be passed on, so they stand beside the project and not in it; without them the tests are skipped.
"""

import json
import re
import sys

import pytest

import dehyst
from dehyst import cli
from places import DATA, ROOT

pytestmark = pytest.mark.skipif(
    not (DATA / "tendon_sheath_joint" / "data.csv.gz").is_file(),
    reason=f"no measured logs in ../{DATA.parent.name}",
)

TENDON = ("tendon_sheath_joint", "angle_cmd_deg", "angle_deg")
PIEZO = ("piezo_dbo", "voltage_v", "displacement_um")
ARM = ("pneumatic_arm_segment", "pressure_interp_psi", "tilt_rad")
CAVATAPPI = ("cavatappi_muscle", "pressure_psi", "displacement_mm")
WRIST = ("pam_wrist_joint", "pressure_mpa", "angle_deg")
DAMPER = ("mr_damper", "displacement_mm", "force_N")

# log, arguments, largest test (or train) error in percent of range
ACCEPTANCE = [
    (TENDON, ("--run", "config_000"), 1.4),
    (TENDON, ("--run", "config_180"), 2.6),
    (PIEZO, ("--run", "model", "--from", "2"), 0.55),
    (ARM, ("--run", "oct28_exp5", "--from", "12"), 1.7),
    (CAVATAPPI, ("--run", "200g_s3_t1"), 5.2),
    (WRIST, ("--train-fraction", "1"), 2.0),
    (DAMPER, ("--run", "ensaio1.2"), 2.4),
]
KEYS = {
    "family",
    "n",
    "nonzero_weights",
    "train",
    "test",
    "static_test",
    "kkt_residual",
    "round_trip_error",
}


README = (ROOT / "README.md").read_text(encoding="utf-8")


def names(case):
    return f"{case[0][0]}-{case[1][1]}"


@pytest.fixture
def identify(monkeypatch, capsys):
    """Run `dehyst identify ... --json` and return what it prints."""

    def command(log, *arguments):
        folder, x, y = log
        line = [
            "dehyst",
            "identify",
            str(DATA / folder / "data.csv.gz"),
            "--input",
            x,
            "--output",
            y,
            "--json",
        ]
        monkeypatch.setattr(sys, "argv", [*line, *arguments])
        with pytest.raises(SystemExit) as end:
            cli.main()
        assert not end.value.code
        out, err = capsys.readouterr()
        assert err == ""
        return json.loads(out, parse_constant=pytest.fail)

    return command


@pytest.mark.slow
@pytest.mark.parametrize("case", ACCEPTANCE, ids=names)
def test_accuracy_on_a_measured_log(identify, case):
    log, arguments, bound = case
    result = identify(log, "--family", "auto", *arguments)
    assert set(result) >= KEYS | {"inverse_gain", "warnings"}
    held_out = "--train-fraction" not in arguments
    assert (result["test"] is not None) == held_out
    score = result["test"] if held_out else result["train"]
    assert set(score) == {"rmse", "rmse_percent", "nrmse", "max"}
    assert score["rmse_percent"] <= bound
    table = [line for line in README.splitlines() if line.startswith("|")]
    shown = f"{score['rmse_percent']:.2f}"
    assert any(shown in line and result["family"] in line for line in table), (
        f"README does not show {shown}"
    )
    static = result["static_test"] if held_out else result["static_train"]
    assert score["rmse"] < 0.6 * static["rmse"]
    assert result["kkt_residual"] < 1e-12
    assert result["round_trip_error"] < 1e-11
    assert 0 < result["nonzero_weights"] <= result["n"]
    assert all(
        set(warning) == {"code", "message"} and len(warning["message"]) > 40
        for warning in result["warnings"]
    )


@pytest.mark.slow
def test_the_damper_is_called_clockwise_and_a_model_knows_its_rate_or_says_so(identify):
    result = identify(DAMPER, "--run", "ensaio1.2")
    assert "clockwise" in {warning["code"] for warning in result["warnings"]}
    assert {"relax", "past"} & set(result["elements"])
    assert "good for compensation" not in result["verdict"]
    # And a plain PI model says that it does not fit.
    plain = identify(DAMPER, "--run", "ensaio1.2", "--family", "pi")
    assert {"clockwise", "rate-dependent", "static-as-good", "poor-fit"} <= {
        warning["code"] for warning in plain["warnings"]
    }
    assert "do not compensate with it" in plain["verdict"]


@pytest.mark.parametrize("case", [case for case in ACCEPTANCE if case[0] != DAMPER], ids=names)
def test_an_actuator_is_not_called_a_damper(identify, case):
    log, arguments, _ = case
    assert not {"clockwise", "mixed-loop", "static-as-good", "poor-fit"} & {
        warning["code"] for warning in identify(log, "--n", "50", *arguments)["warnings"]
    }


# A net under further runs: bounds are generous, about 1.2 times what was reached when they were written.
NET = [
    (TENDON, {"run": "config_030"}, 1.9),
    (TENDON, {"run": "config_090"}, 1.7),
    (TENDON, {"run": "config_270"}, 5.3),
    (TENDON, {"run": "conf0_60"}, 1.1),
    (TENDON, {"run": "conf0_70"}, 0.75),
    (TENDON, {"run": "conf90_60"}, 4.5),
    (PIEZO, {"run": "test", "start": 2}, 0.6),
    (PIEZO, {"run": "test", "start": 2, "stop": 30}, 1.8),
    (ARM, {"run": "oct28_exp1", "start": 12}, 2.9),
    (ARM, {"run": "oct28_exp9", "start": 12}, 1.7),
    (ARM, {"run": "oct25_axial", "start": 12}, 3.3),
    (CAVATAPPI, {"run": "200g_s2_t1"}, 6.6),
    (CAVATAPPI, {"run": "300g_s3_t1"}, 8.6),
    (CAVATAPPI, {"run": "400g_s3_t1"}, 6.3),
    (DAMPER, {"run": "ensaio.A.6"}, 3.5),
    (DAMPER, {"run": "ensaio10.1"}, 4.4),
]


def run_name(case):
    (folder, *_), window, _ = case
    return f"{folder}-{window['run']}"


# The held-out half moves 8 % beyond the fitted range, where the chosen sum is little better than a curve.
BEYOND = pytest.mark.xfail(reason="extrapolates: 8.5 % of range, curve 10.3 %", strict=True)
RUNS = [pytest.param(case, marks=BEYOND if "300g" in case[1]["run"] else ()) for case in NET]


@pytest.mark.slow
@pytest.mark.parametrize("case", RUNS, ids=run_name)
def test_no_run_becomes_worse_than_a_curve_without_hysteresis(case):
    (folder, x, y), window, bound = case
    fit = dehyst.identify(dehyst.read_log(DATA / folder / "data.csv.gz", x, y, **window))
    assert fit.test.rmse_percent < bound
    assert fit.test.rmse < 0.75 * fit.static_test.rmse
    assert fit.certificate.kkt_residual < 1e-12
    assert fit.certificate.round_trip_error < 1e-11
    if folder == DAMPER[0]:
        assert "clockwise" in {finding.code for finding in fit.warnings}
        assert fit.model.rate_dependent


def test_repeated_runs_of_one_joint_are_fitted_together():
    runs = [
        dehyst.read_log(DATA / TENDON[0] / "data.csv.gz", *TENDON[1:], run=run)
        for run in ("conf0_60", "conf0_60_")
    ]
    fit = dehyst.identify(runs, n=50)
    assert [predicted.size for predicted in fit.predictions] == [len(run) for run in runs]
    assert fit.test.rmse_percent < 2.9
    assert fit.test.rmse < 0.5 * fit.static_test.rmse


@pytest.mark.slow
def test_every_model_of_a_measured_loop_survives_its_file(tmp_path):
    for folder, x, y, window in (
        (*WRIST, {}),
        (*PIEZO, {"run": "model", "start": 2}),
        (*DAMPER, {"run": "ensaio1.2"}),
    ):
        rec = dehyst.read_log(DATA / folder / "data.csv.gz", x, y, **window)
        fit = dehyst.identify(rec, n=50)
        model = dehyst.load(fit.model.save(tmp_path / f"{folder}.json"))
        assert (model.simulate(rec.input) == fit.predictions[0]).all()
        assert model.card.provenance["logs"][0]["file"] == "data.csv.gz"


@pytest.mark.slow
def test_the_spread_of_the_tendon_joint_is_as_the_readme_says(identify):
    low, high = map(float, re.search(r"tendon joint reach ([\d.]+) to ([\d.]+) %", README).groups())
    runs = [f"config_{k:03d}" for k in range(0, 271, 30)]
    runs += ["conf0_50", "conf0_60", "conf0_60_", "conf0_70", "conf90_50", "conf90_60", "conf90_70"]
    errors = [identify(TENDON, "--run", run)["test"]["rmse_percent"] for run in runs]
    assert min(errors) == pytest.approx(low, abs=0.05)
    assert max(errors) == pytest.approx(high, abs=0.05)
