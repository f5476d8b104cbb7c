"""Open-circuit voltages: logs that are none, branches, decay rates, the file for PyBaMM."""

import json
import runpy

import numpy as np
import pytest

from dehyst.errors import ColumnError, ExcitationError, ParameterError, RecordingError
from dehyst.io import write_csv
from dehyst_targets.batteries import fit_ocv, ocv_of, pybamm_file, read_ocv
from simulated_loops import open_circuit


def columns(**settings):
    return tuple(open_circuit(**settings).values())


def test_branches_and_rate_of_a_one_state_electrode_are_found_again():
    fit = fit_ocv(ocv_of(*columns(rate=40.0)))
    assert np.array(fit.rates) == pytest.approx(40.0, rel=0.1)
    middle = slice(30, 90)  # after a turn at an end the voltage is still between the branches
    x = fit.x[middle]
    gap = 0.05 * np.sin(np.pi * x)
    assert fit.lithiation[middle] == pytest.approx(0.5 - 0.4 * x - gap, abs=0.003)
    assert fit.delithiation[middle] == pytest.approx(0.5 - 0.4 * x + gap, abs=0.003)
    assert fit.error < 0.1 * fit.middle_error


def test_charge_may_count_what_enters_or_what_leaves_in_any_unit():
    charge, voltage = columns()
    one, other = ocv_of(charge, voltage), ocv_of(-1000.0 * charge, voltage)
    np.testing.assert_allclose(one.x, other.x, atol=1e-12)
    assert ocv_of(charge, voltage, stoichiometry=(0.1, 0.8)).x.max() == pytest.approx(0.8)


def test_branches_of_a_noisy_log_fall_and_do_not_cross():
    charge, voltage = columns()
    fit = fit_ocv(
        ocv_of(charge, voltage + np.random.default_rng(0).normal(0.0, 2e-3, voltage.size))
    )
    assert np.all(np.diff(fit.lithiation) <= 0.0)
    assert np.all(np.diff(fit.delithiation) <= 0.0)
    assert np.all(fit.delithiation >= fit.lithiation)


def resets(charge, voltage):
    return np.where(np.arange(charge.size) < 150, charge, charge - 2.0 * (charge > 1.0)), voltage


@pytest.mark.parametrize(
    ("change", "error", "words"),
    [
        (lambda q, u: (q[:140], u[:140]), ExcitationError, "one slow full cycle"),
        (lambda q, u: (q, 1e3 * u), RecordingError, "mV"),
        (lambda q, u: (0.0 * q, u), RecordingError, "stands still"),
        (lambda q, u: (q[:5], u[:5]), RecordingError, "20 or more"),
        (resets, RecordingError, "net charge"),
    ],
)
def test_what_is_no_open_circuit_voltage_is_refused_with_a_cure(change, error, words):
    with pytest.raises(error, match=words):
        ocv_of(*change(*columns()))


def test_stoichiometries_lie_between_0_and_1():
    with pytest.raises(ParameterError, match="0 and 1"):
        ocv_of(*columns(), stoichiometry=(0.9, 0.1))


def test_without_partial_cycles_the_rate_is_not_invented():
    log = ocv_of(*columns(turns=(0.0, 1.0, 0.0)))
    fit = fit_ocv(log)
    assert fit.rates is None
    assert [finding.code for finding in fit.findings] == ["ocv-no-partial-cycles"]
    with pytest.raises(ParameterError, match="--decay"):
        pybamm_file(fit, "negative", 1.0)
    assert fit_ocv(log, decay=50.0).rates == (50.0, 50.0)


def test_exchanged_columns_are_named(tmp_path):
    log = write_csv(tmp_path / "ocv.csv", open_circuit())
    assert read_ocv(log).x.max() == pytest.approx(1.0)
    with pytest.raises(ColumnError, match="Exchange --charge and --voltage"):
        read_ocv(log, charge="voltage", voltage="charge")


def test_values_under_the_wrong_headings_are_told_by_the_model_of_the_columns_exchanged():
    charge, voltage = columns()
    (finding,) = fit_ocv(ocv_of(voltage, charge)).findings
    assert finding.code == "ocv-no-gain"
    assert "under the wrong headings" in finding.message
    assert fit_ocv(ocv_of(charge, voltage)).findings == ()


def test_a_rate_that_was_typed_wrong_is_not_taken_for_exchanged_columns():
    (finding,) = fit_ocv(ocv_of(*columns()), decay=0.01).findings
    assert finding.code == "ocv-no-gain"
    assert "the rate that was typed" in finding.message
    assert "headings" not in finding.message


@pytest.mark.slow
def test_a_model_that_is_no_better_than_a_curve_is_not_written(run, tmp_path):
    log = write_csv(tmp_path / "ocv.csv", open_circuit())
    out = tmp_path / "p.py"
    status, _, err = run("battery", str(log), "--decay", "0.01", "--out", str(out))
    assert status == 2
    assert "no file is written" in " ".join(err.split())
    assert not out.exists()


def test_a_log_of_current_is_told_how_it_becomes_a_charge(tmp_path):
    charge, voltage = columns()
    time = 20.0 * np.arange(charge.size)
    current = np.diff(charge, prepend=charge[0]) * 3600.0 / 20.0
    signals = {"time [s]": time, "current [A]": current, "voltage [V]": voltage}
    with pytest.raises(
        ColumnError, match="running sum of current in A times time step in s, over 3600"
    ):
        read_ocv(write_csv(tmp_path / "i.csv", signals))
    # As the message says.
    signals["charge [Ah]"] = np.cumsum(current * np.diff(time, prepend=time[0])) / 3600.0
    summed = read_ocv(write_csv(tmp_path / "q.csv", signals))
    np.testing.assert_allclose(summed.x, ocv_of(charge, voltage).x, atol=1e-6)


@pytest.mark.slow
def test_the_command_prints_errors_and_writes_the_file(run, tmp_path):
    log, out = write_csv(tmp_path / "ocv.csv", open_circuit()), tmp_path / "p.py"
    picture = tmp_path / "ocv.svg"
    status, printed, _ = run(
        "battery", str(log), "--json", "--out", str(out), "--figure", str(picture)
    )
    figures = json.loads(printed)
    assert status == 0
    assert figures["rms_V"]["one_state"] < figures["rms_V"]["without_hysteresis"]
    assert "import pybamm" in out.read_text()
    assert "lithiation" in picture.read_text()
    status, _, err = run(
        "battery", str(log), "--electrode", "left", "--out", str(tmp_path / "q.py")
    )
    assert status == 2
    assert "negative or positive" in err


@pytest.mark.slow
def test_pybamm_reads_the_file_and_simulates_the_same_voltage(tmp_path):
    pybamm = pytest.importorskip("pybamm", reason="PyBaMM is not installed")
    fit = fit_ocv(ocv_of(*columns()))
    path = tmp_path / "p.py"
    path.write_text(pybamm_file(fit, "positive", -1.0))
    values = pybamm.ParameterValues("Xu2019")
    values.update(runpy.run_path(str(path))["get_parameter_values"](), check_already_exists=False)
    most = values["Maximum concentration in positive electrode [mol.m-3]"]
    # Diffusion as fast as that leaves the particles even, so that the voltage is that of the open circuit.
    values.update({
        "Positive particle diffusivity [m2.s-1]": 1e-9,
        "Initial concentration in positive electrode [mol.m-3]": 0.1 * most,
        "Lower voltage cut-off [V]": -1.0,
        "Upper voltage cut-off [V]": 5.0,
    })  # fmt: skip
    options = {
        "working electrode": "positive",
        "open-circuit potential": ("single", "one-state hysteresis"),
    }
    steps = [
        "Discharge at C/50 for 20 hours",
        "Charge at C/50 for 8 hours",
        "Discharge at C/50 for 8 hours",
    ]
    simulation = pybamm.Simulation(
        pybamm.lithium_ion.SPM(options),
        parameter_values=values,
        experiment=pybamm.Experiment(steps),
    )
    solution = simulation.solve()
    x = solution["X-averaged positive particle surface stoichiometry"].entries
    simulated = solution["X-averaged positive electrode open-circuit potential [V]"].entries
    assert np.ptp(x) > 0.15
    np.testing.assert_allclose(simulated, fit.simulate(x, -1.0), atol=1e-3)
