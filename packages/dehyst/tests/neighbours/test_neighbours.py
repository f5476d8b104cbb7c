"""Models in other packages answer as they do here: python-control, scikit-learn, nonlinear_benchmarks."""

import importlib
import sys

import control
import nonlinear_benchmarks
import numpy as np
import pytest
from sklearn.base import clone
from sklearn.model_selection import GridSearchCV, TimeSeriesSplit

import dehyst
from dehyst.errors import MissingExtraError, ParameterError
from dehyst.families import example
from dehyst.io import example_recording
from dehyst.neighbours import HysteresisRegressor, apply_model, recording_of, to_control

REC = example_recording(rate=10)
T = 0.1 * np.arange(200)
U = 3 * np.sin(T) * np.linspace(1, 0.2, 200)
MODELS = {
    "plays": lambda: dehyst.identify(REC, "pi").model,
    "map": lambda: dehyst.identify(REC, "modified-pi").model.inverse(),
    "elements": lambda: dehyst.identify(REC, "play-sum").model,
    "dahl": lambda: example("dahl"),
    "lugre": lambda: example("lugre"),
}


@pytest.mark.parametrize("name", MODELS)
def test_a_system_of_python_control_gives_the_bits_of_the_stepper(name):
    model = MODELS[name]()
    answer = control.input_output_response(to_control(model, 0.1), T, U).outputs
    step = (
        model.stepper("dense")
        if isinstance(model, dehyst.models.HysteresisModel)
        else model.stepper(0.1)
    )
    np.testing.assert_array_equal(answer, [step(u, 0.1) for u in U])


def test_a_model_in_a_closed_loop_of_python_control_settles_on_the_reference():
    plant = to_control(dehyst.PrandtlIshlinskii([0.0, 0.6], [1.0, 0.5]), 0.1, name="plant")
    delayed = control.tf([0.3], [1, -1], 0.1, name="integrator", inputs=["e"], outputs=["u"])
    loop = control.interconnect(
        [plant, delayed, control.summing_junction(["r", "-y"], "e")],
        inputs=["r"],
        outputs=["y"],
        dt=0.1,
    )
    answer = control.input_output_response(loop, T, np.ones(200)).outputs
    assert abs(answer[-1] - 1) < 1e-6


def test_a_memory_that_grows_is_refused():
    with pytest.raises(ParameterError, match="grows"):
        to_control(example("preisach"), 0.1)
    with pytest.raises(ParameterError, match="no period"):
        to_control(example("dahl"), 0.0)


def test_the_regressor_predicts_what_the_model_simulates_and_is_cloned_and_searched():
    regressor = HysteresisRegressor(family="pi").fit(REC.input[:, None], REC.output)
    np.testing.assert_array_equal(regressor.predict(U[:, None]), regressor.model_.simulate(U))
    assert clone(regressor).get_params() == {"family": "pi", "purpose": "simulate", "dt": None}
    search = GridSearchCV(
        HysteresisRegressor(), {"family": ["static", "pi"]}, cv=TimeSeriesSplit(3)
    )
    assert search.fit(REC.input[:, None], REC.output).best_params_ == {"family": "pi"}
    with pytest.raises(ParameterError, match="in the order of time"):
        regressor.predict(np.zeros((5, 2)))


@pytest.mark.slow
def test_a_benchmark_is_identified_and_scored_as_its_package_does():
    half = len(REC) // 2
    data = nonlinear_benchmarks.Input_output_data(
        REC.input, REC.output, sampling_time=0.1, name="rig", state_initialization_window_length=20
    )
    train, test = data[:half], data[half:]
    fit = dehyst.identify(recording_of(train))
    n = 20
    answer = apply_model(fit.model, 0.1)(test.u, test.y[:n])
    error = nonlinear_benchmarks.error_metrics.RMSE(test.y[n:], answer[n:])
    curve = apply_model(dehyst.identify(recording_of(train), "static").model, 0.1)(
        test.u, test.y[:n]
    )
    assert error < 0.6 * nonlinear_benchmarks.error_metrics.RMSE(test.y[n:], curve[n:])
    np.testing.assert_array_equal(answer[:n], test.y[:n])


@pytest.mark.parametrize(
    ("module", "package", "extra"),
    [
        ("dehyst.neighbours.scikit", "sklearn.base", "scikit"),
        ("dehyst_robot.environment", "gymnasium", "gym"),
    ],
)
def test_a_package_that_is_missing_is_named_with_the_line_to_type(
    monkeypatch, module, package, extra
):
    monkeypatch.setitem(sys.modules, package, None)
    monkeypatch.delitem(sys.modules, module, raising=False)
    with pytest.raises(MissingExtraError, match=rf"pip install 'dehyst(-robot)?\[{extra}\]'"):
        importlib.import_module(module)
