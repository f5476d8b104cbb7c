"""Core models against oracles of their own, and their fits."""

import functools
import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dehyst.data import Recording
from dehyst.errors import IdentificationError
from dehyst_targets.magnetics import Chan, JilesAtherton, Tellinen, core_of, fit_core

MU_0 = 4e-7 * math.pi
UNITS = {"input_unit": "A/m", "output_unit": "T"}
SOFT = JilesAtherton(3.5e5, 15.0, 20.0, 0.1, 5e-5)


def jiles_atherton(model, field, first, fineness=400):
    """Euler's method on very small steps, in scalars."""
    m = first / MU_0 - field[0]
    path = [first]
    for before, after in itertools.pairwise(field):
        step = (after - before) / fineness
        for k in range(fineness):
            h = before + (k + 0.5) * step
            x = (h + model.alpha * m) / model.a
            bent = (
                model.ms * x / (1.0 + abs(x))
                if model.pspice
                else model.ms * (1.0 / math.tanh(x) - 1.0 / x)
            )
            slope = (
                1.0 / (1.0 + abs(x)) ** 2 if model.pspice else 1.0 / x**2 - 1.0 / math.sinh(x) ** 2
            )
            slope *= model.ms / model.a
            way = math.copysign(1.0, step)
            pull = max(way * (bent - m), 0.0)
            pull /= model.k - model.alpha * pull
            m += step * (pull + model.c * slope) / (1.0 + model.c - model.c * model.alpha * slope)
        path.append(MU_0 * (after + m))
    return np.array(path)


@pytest.mark.parametrize("model", [SOFT, JilesAtherton(3e5, 20.0, 12.0, 0.3, pspice=True)])
def test_jiles_and_atherton_are_integrated_as_small_steps_do(model):
    field = np.interp(np.arange(61), [0, 20, 40, 50, 60], [1.0, 90.0, -60.0, 30.0, -20.0])
    np.testing.assert_allclose(
        model.simulate(field, 0.01), jiles_atherton(model, field, 0.01), atol=2e-3 * 0.4
    )


def tanh_loop():
    h = 300.0 * np.sin(np.linspace(-0.5 * np.pi, 1.5 * np.pi, 1201))
    side = np.where(np.arange(1201) <= 600, -1.0, 1.0)
    # Far out both branches meet.
    return h, 0.4 * np.tanh((h + side * 20.0 * (1.0 - (h / 300.0) ** 2)) / 40.0) + MU_0 * h


def test_tellinen_follows_its_limiting_loop():
    h, b = tanh_loop()
    modelled = Tellinen.of(h, b).simulate(h, float(b[0]))
    assert np.abs(modelled - b).max() < 0.005 * np.ptp(b)


@settings(max_examples=25, deadline=None)
@given(st.lists(st.floats(-299.0, 299.0), min_size=2, max_size=6))
def test_tellinen_never_leaves_its_limiting_loop(turns):
    h, b = tanh_loop()
    model = Tellinen.of(h, b)
    field = np.interp(np.linspace(0.0, len(turns) - 1.0, 200), np.arange(len(turns)), turns)
    j = model.simulate(field, 0.0) - MU_0 * field
    assert np.all(j >= np.interp(field, model.field, model.rising) - 2.0 * model.gap)
    assert np.all(j <= np.interp(field, model.field, model.falling) + 2.0 * model.gap)


def test_chan_passes_hc_br_and_bs():
    model = Chan(20.0, 0.2, 0.4)
    rising, falling = model.branches(np.array([20.0, 0.0, 1e7]))
    assert rising[0] == pytest.approx(MU_0 * 20.0)
    assert (rising[1], falling[1]) == pytest.approx((-0.2, 0.2))
    assert rising[2] - MU_0 * 1e7 == pytest.approx(0.4, rel=1e-4)


@functools.cache
def soft_core():
    h = 200.0 * np.sin(np.linspace(0.0, 5.0 * np.pi, 1501))
    return core_of(Recording(h, SOFT.simulate(h, 0.0), **UNITS))


@pytest.mark.slow
def test_parameters_of_jiles_and_atherton_are_found_again():
    fits = fit_core(soft_core())
    model = fits["jiles-atherton"].model
    assert model.ms == pytest.approx(SOFT.ms, rel=0.02)
    assert model.k == pytest.approx(SOFT.k, rel=0.02)
    assert abs(fits["jiles-atherton"].loss_error) < 0.01
    assert abs(fits["tellinen"].loss_error) < 0.02
    assert fits["pspice"].error < 0.02
    assert math.isnan(fits["tellinen"].smaller_error)


def test_a_loop_without_width_is_refused():
    h = 100.0 * np.sin(np.linspace(0.0, 5.0 * np.pi, 501))
    with pytest.raises(IdentificationError, match="no area"):
        fit_core(core_of(Recording(h, 1e-3 * h, **UNITS)))


def test_a_field_that_rests_stays_on_its_branch_of_chan():
    model = Chan(20.0, 0.2, 0.4)
    h = np.array([50.0, 30.0, 10.0, 10.0, 10.0, 10.0, -30.0])
    np.testing.assert_allclose(model.simulate(h, 0.0), model.branches(h)[1])


@pytest.mark.slow
def test_noise_of_one_percent_does_not_change_the_errors_of_models():
    time = np.arange(10_000) / 50e3
    h, way = 100.0 * np.sin(100.0 * np.pi * time), np.sign(np.cos(100.0 * np.pi * time))
    b = 1.2 * np.tanh((h - 20.0 * way) / 40.0) + 0.6 * way * (math.tanh(3.0) - math.tanh(2.0))
    random = np.random.default_rng(0)
    noise = random.normal(size=(2, h.size))
    clean = fit_core(core_of(Recording(h, b, time, **UNITS)))
    noisy = fit_core(core_of(Recording(h + noise[0], b + 0.012 * noise[1], time, **UNITS)))
    for name, fit in clean.items():
        assert noisy[name].error == pytest.approx(fit.error, abs=0.003), name
        assert noisy[name].loss_error == pytest.approx(fit.loss_error, abs=0.03), name
