"""Powers of the input in front of a sum: found where the rig has one, left out where it has none, exact, exported."""

import numpy as np
import pytest

import dehyst
from dehyst.export import export, subject_of, verify
from dehyst.families import Scaling
from dehyst.families._transforms import transform_name, transforms
from simulated_loops import wandering

POWERS = {
    "square": lambda s: s**2,
    "root": np.sqrt,
    "logarithm": lambda s: np.log(0.02 + 0.98 * s) / np.log(50.0) + 1.0,
}


def bouc_wen(x, beta=3.0, gamma=1.0):
    """The hysteretic part of Bouc and Wen: dz = dx - |dx| beta z - dx gamma |z|."""
    z = np.zeros(x.size)
    for k, dx in enumerate(np.diff(x)):
        z[k + 1] = z[k] + dx - beta * abs(dx) * z[k] - gamma * dx * abs(z[k])
    return z


def log(power, low=0.0, high=5.0, samples=4000, seed=3, sign=1.0):
    """A rig of Bouc and Wen that sees a power of its input, which is of one sign."""
    s = 0.5 + 0.5 * wandering(seed, samples)
    seen = 2.0 * POWERS[power](s) - 1.0 if power else 2.0 * s - 1.0
    y = 0.7 * seen + 0.3 * bouc_wen(seen) + 1e-3 * np.random.default_rng(0).normal(size=samples)
    u = sign * (low + (high - low) * s)
    return dehyst.Recording(u, y, 0.01 * np.arange(samples), input_name="u")


@pytest.mark.parametrize(("power", "low"), [("square", 0.0), ("logarithm", 0.1)])
def test_a_power_that_the_rig_has_is_found_and_named(power, low):
    recording = log(power, low)
    fit = dehyst.identify(recording)
    assert f"acts on the {power} of u" in fit.model.remarks
    ramps = dehyst.identify(recording, "full-sum")
    assert fit.test.rmse_percent < 0.9 * ramps.test.rmse_percent
    assert fit.model.free_parameters < 0.6 * ramps.model.free_parameters


def test_a_negative_range_is_of_one_sign_too():
    fit = dehyst.identify(log("square", sign=-1.0))
    assert "acts on the square of u" in fit.model.remarks


@pytest.mark.parametrize("low", [0.0, 2.0, -5.0])
def test_a_rig_without_a_power_is_given_none(low):
    fit = dehyst.identify(log("", low))
    assert not any("acts on" in remark for remark in fit.model.remarks)


@pytest.mark.slow
def test_inverse_and_code_have_the_map(tmp_path):
    recording = log("square")
    model = dehyst.identify(recording).model
    x = recording.input[:500]
    time = recording.time[:500]
    back = model.inverse().simulate(model.simulate(x, time), time)
    assert np.max(np.abs(back - x)) < 1e-11
    export(subject_of(model, name="unit_1"), "c", tmp_path / "unit")
    assert all(check.ok for check in verify(tmp_path / "unit"))


@pytest.mark.parametrize("center", [2.5, -2.5, 5.1, -5.1])
def test_every_map_rises_between_the_ends_of_the_range_and_is_told_by_its_name(center):
    scaling = Scaling(center, 2.5 if abs(center) == 2.5 else 4.9)
    maps = transforms(scaling)
    powers = {"square", "root"}
    assert set(maps) == (powers if abs(center) == 2.5 else {*powers, "logarithm"})
    for name, (u, v) in maps.items():
        assert np.all(np.diff(v) > 0.0) and (u[0], u[-1]) == (-1.0, 1.0)
        assert (v[0], v[-1]) == pytest.approx((-1.0, 1.0))
        assert transform_name(scaling, (u, v)) == name
    assert transform_name(scaling, ((), ())) == ""
