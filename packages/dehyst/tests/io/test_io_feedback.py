"""A log that was taken in closed loop is named; one that was planned before never is."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import dehyst
from dehyst.design import design_excitation
from dehyst.io import inspect_log, read_log, write_csv
from simulated_loops import servo_log


def codes(columns, folder, input="command", output="measured"):
    path = write_csv(folder / "log.csv", columns)
    return [finding.code for finding in read_log(path, input, output).findings]


@pytest.mark.parametrize(("proportional", "integral"), [(0.3, 0.02), (0.1, 0.2), (0.5, 0.0)])
def test_a_servo_that_was_logged_with_its_set_point_is_named(tmp_path, proportional, integral):
    columns = servo_log(proportional=proportional, integral=integral)
    assert "closed-loop" in codes(columns, tmp_path)


def test_inspect_names_it_too(tmp_path):
    path = write_csv(tmp_path / "log.csv", servo_log())
    summary = inspect_log(path)
    assert (summary.input, summary.output) == ("command_V", "measured_mm")
    assert "closed-loop" in {finding.code for finding in summary.findings}


@pytest.mark.slow
@given(noise=st.floats(0.0, 0.5))
def test_a_command_that_was_planned_is_not_accused_even_if_it_was_logged_twice(
    noise, tmp_path_factory
):
    columns = servo_log(noise=noise, closed=False)
    assert "closed-loop" not in codes(columns, tmp_path_factory.mktemp("log"))


@pytest.mark.parametrize("noise", [0.0, 0.01, 0.3])
def test_a_log_that_design_planned_is_not_accused(tmp_path, noise):
    time, value, _ = design_excitation(-5.0, 5.0, unit="V").signal()
    model = dehyst.PrandtlIshlinskii([0.0, 0.5, 1.0], [1.0, 0.5, 0.5])
    rng = np.random.default_rng(0)
    angle = model.simulate(value) + noise * rng.normal(size=value.size)
    columns = {"time_s": time, "command_V": value, "measured_deg": angle, "reference_deg": 2.0 * value,
               "sensor2_deg": angle + noise * rng.normal(size=value.size)}  # fmt: skip
    assert "closed-loop" not in codes(columns, tmp_path)


@pytest.mark.slow
@given(seed=st.integers(0, 100), gain=st.sampled_from([-2.0, 0.5, 3.0]))
def test_an_output_that_answers_within_a_sample_is_no_controller(seed, gain, tmp_path_factory):
    rng = np.random.default_rng(seed)
    command = np.cumsum(rng.normal(size=500))
    columns = {"time_s": 0.1 * np.arange(500), "command_V": command, "measured_mm": gain * command,
               "temperature_K": 0.001 * np.cumsum(rng.normal(size=500))}  # fmt: skip
    assert "closed-loop" not in codes(columns, tmp_path_factory.mktemp("log"))


def test_a_lag_without_noise_is_no_controller(tmp_path):
    # A reference that is the command, and an output that lags behind it, obey the law of a controller exactly.
    time = 0.01 * np.arange(3000)
    command = np.sin(time) + 0.4 * np.sin(2.7 * time)
    lagged = np.zeros(3000)
    for k in range(1, 3000):
        lagged[k] = lagged[k - 1] + 0.05 * (command[k] - lagged[k - 1])
    columns = {"time_s": time, "command_V": command, "measured_mm": lagged, "reference_mm": command}
    assert "closed-loop" not in codes(columns, tmp_path)
