"""The bench for muscle models: loops, releases and forces at speed are those that the formulas demand."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dehyst.errors import ParameterError
from dehyst_robot.muscles import (
    default_contractions,
    force_velocity,
    isobaric_loop,
    muscle,
    run_bench,
)
from dehyst_robot.muscles._experiments import (
    STROKE,
    force_map,
    free_contraction,
    isotonic_loop,
    lowest_pressure,
    quick_release,
)
from test_muscles_models import every_set

BAR = 1e5


def trapezium(y, x):
    return float(np.sum(0.5 * (y[1:] + y[:-1]) * np.diff(x)))


@pytest.mark.slow
@every_set
def test_every_published_set_runs_through_all_experiments_at_working_pressures(name, which):
    model = muscle(name, which)
    bench = run_bench(
        model,
        default_contractions(model, [3e5, 6e5]),
        [3e5, 6e5],
        loads=[0.3 * model.static_force(0, 6e5)],
    )
    assert bench.skipped == ()
    assert (len(bench.isobaric), len(bench.isotonic), len(bench.releases)) == (2, 1, 4)
    assert np.all(bench.forces.blocked > 0) and np.all(bench.forces.stiffness > 0)
    loop = bench.isotonic[0]
    assert np.ptp(loop.response) > 0.01  # a muscle shortens when its pressure rises


def test_the_fibres_of_a_free_braid_stand_at_54_7_degrees():
    model = muscle("chou-hannaford", wall=0.0)
    at_rest = model.angle
    shortened = math.acos((1.0 - free_contraction(model, 3 * BAR)) * math.cos(at_rest))
    assert math.degrees(shortened) == pytest.approx(54.7356, abs=1e-4)


def test_free_contraction_of_the_maker_s_map_is_that_of_the_literature_table():
    found = [100 * free_contraction(muscle("maker", "DMSP-40"), p * BAR) for p in range(1, 7)]
    assert found == pytest.approx([9.5, 17.3, 20.6, 22.7, 24.1, 25.3], abs=0.06)


def test_a_free_contraction_under_load_carries_the_load():
    model = muscle("sarosi")
    k = free_contraction(model, 4 * BAR, 800.0)
    assert float(model.static_force(k, 4 * BAR)) == pytest.approx(800.0, abs=1e-5)
    assert math.isnan(free_contraction(model, 1 * BAR, 1e5))


def test_stiffness_is_the_slope_of_the_force_over_the_length():
    model = muscle("boblan-martens")
    found = force_map(model, [0.0], [4 * BAR])
    k = 0.5 * found.free[0]
    near = [float(model.static_force(k + side * 1e-3, 4 * BAR)) for side in (-1, 1)]
    assert found.stiffness[0] == pytest.approx(
        (near[0] - near[1]) / (2e-3 * model.length), rel=1e-3
    )


def test_a_coulomb_band_is_as_wide_as_twice_its_friction():
    model = muscle("chou-hannaford", band=40.0)
    loop = isobaric_loop(model, 3 * BAR, 0.02, 0.2)
    assert loop.width == pytest.approx(80.0, rel=1e-6)
    assert abs(loop.asymmetry_percent) < 1.0


def test_a_coulomb_band_shifts_an_isotonic_loop_by_the_pressure_that_overcomes_it():
    band, load = 25.0, 300.0
    model = muscle("chou-hannaford", band=band)
    low = lowest_pressure(model, load, 6 * BAR)
    loop = isotonic_loop(model, load, low, 6 * BAR)
    for rising, sign in ((slice(0, STROKE + 1), -1.0), (slice(STROKE, None), 1.0)):
        k, p = loop.response[rising], loop.drive[rising]
        slope, offset = model.affine(k)
        moving = np.abs(np.gradient(k)) > 1e-4
        needed = (
            load + offset - sign * band
        ) / slope  # F_static = load + friction against the motion
        assert moving.sum() > STROKE // 2
        assert p[moving][3:-3] == pytest.approx(needed[moving][3:-3], rel=2e-3)


def test_models_without_hysteresis_have_loops_without_width():
    for name in (
        "maker",
        "sarosi",
        "aschemann-schindele",
        "boblan-martens",
        "tondu-zagal",
        "reynolds",
    ):
        model = muscle(name)
        assert isobaric_loop(model, 4 * BAR, 0.01, 0.08).width < 1e-9 * 1e4
        assert isotonic_loop(model, 200.0, 4 * BAR, 5 * BAR).width < 1e-8


def test_a_damper_opens_a_loop_by_its_speed_only():
    model = muscle("kerscher")
    widths = [
        isobaric_loop(model, 3 * BAR, 0.02, 0.1, period=period).width for period in (1.0, 2.0)
    ]
    assert widths[0] == pytest.approx(2 * widths[1], rel=0.02)
    speed = 2 * 0.08 * model.length / 1.0
    assert widths[0] == pytest.approx(
        2 * (model.damping + model.damping_pressure * 3 * BAR) * speed, rel=0.02
    )


@pytest.mark.slow
@settings(max_examples=12, deadline=None)
@given(
    st.sampled_from(["vo-minh", "tondu-lopez", "davis-caldwell"]),
    st.floats(0.1, 0.5),
    st.floats(2.0, 5.0),
)
def test_the_force_along_an_isotonic_loop_is_the_load(name, share, top):
    model = muscle(name)
    load = share * float(model.static_force(0.0, top * BAR))
    loop = isotonic_loop(model, load, 0.8 * top * BAR, top * BAR, cycles=1)
    again, _ = model.run(loop.response, loop.drive, None, model.rest(float(loop.response[0])))
    assert again == pytest.approx(np.full(again.size, load), abs=1e-3 * load)


def test_a_settled_loop_closes_and_falls_where_it_should():
    loop = isobaric_loop(muscle("vo-minh"), 3 * BAR, 0.02, 0.15)
    assert loop.response[-1] == pytest.approx(loop.response[0], abs=1e-9)
    up, down = loop.response[: STROKE + 1], loop.response[: STROKE - 1 : -1]
    assert np.all(down - up > -1e-9)  # lengthening pulls harder than shortening


def test_hill_s_muscle_has_hill_s_figures():
    model = muscle("klute", "muscle")
    found = force_velocity(model, 4 * BAR)
    assert found.hill[0] == pytest.approx(0.25, rel=1e-3)  # a/F_0, Hill 1938
    assert found.hill_percent < 0.01
    assert found.fastest == pytest.approx(
        found.hill[1] / found.hill[0], rel=1e-3
    )  # v_max = b F_0/a
    assert (found.isometric * (1 + found.hill[0])) / found.hill[1] == pytest.approx(
        found.damping, rel=0.01
    )


def test_the_friction_of_tondu_and_zagal_is_hill_s_law_with_a_equal_to_the_force_and_hill_s_a():
    model = muscle("tondu-zagal", "rayon")
    found = force_velocity(model, 4 * BAR, speeds=np.linspace(0.0, 1.0, 21))
    a, b = found.hill
    assert b == pytest.approx(model.drag_speed, rel=1e-3)
    assert model.drag == pytest.approx(found.isometric * (1.0 + a), rel=1e-3)


def test_a_release_without_friction_turns_work_into_motion():
    model = muscle("sarosi")
    load = 0.5 * float(model.static_force(0.0, 4 * BAR))
    found = quick_release(model, 4 * BAR, load)
    until = int(np.argmax(found.speed))
    k = found.contraction[: until + 1]
    work = trapezium((model.static_force(k, np.full(k.size, 4 * BAR)) - load) * model.length, k)
    assert 0.5 * found.mass * found.peak_speed**2 == pytest.approx(work, rel=0.01)
    assert float(model.static_force(found.peak_contraction, 4 * BAR)) == pytest.approx(
        load, rel=0.01
    )


def test_a_strong_damper_lets_the_release_creep_at_the_speed_of_the_force_balance():
    model = muscle("kerscher", damping=20_000.0, damping_pressure=0.0)
    before = float(model.static_force(0.0, 4 * BAR))
    found = quick_release(model, 4 * BAR, 0.8 * before, mass=1.0)
    assert found.peak_speed == pytest.approx(0.2 * before / 20_000.0, rel=0.1)


def test_a_heavier_weight_is_lifted_more_slowly():
    model = muscle("vo-minh")
    before = float(model.static_force(0.0, 4 * BAR))
    speeds = [quick_release(model, 4 * BAR, share * before).peak_speed for share in (0.2, 0.5, 0.8)]
    assert speeds == sorted(speeds, reverse=True)


def test_what_cannot_be_run_is_left_out_and_said():
    model = muscle("sarosi")
    bench = run_bench(model, [0.0, 0.1], [1 * BAR], loads=[1e5])
    assert bench.isotonic == ()
    assert "1e+05 N" in bench.skipped[0] and "Take a smaller one" in bench.skipped[0]
    assert "no pressure is above zero" in run_bench(model, [0.0], [0.0]).skipped[0]


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda m: isobaric_loop(m, 3 * BAR, 0.2, 0.1), "the first must be the lower one"),
        (lambda m: isotonic_loop(m, 100.0, 3 * BAR, 2 * BAR), "the first must be the lower one"),
        (lambda m: isotonic_loop(m, 1e6, 2 * BAR, 3 * BAR), "smaller load"),
        (lambda m: isobaric_loop(m, 3 * BAR, 0.0, 0.1, period=0.0), "no loop"),
        (lambda m: quick_release(m, 3 * BAR, 1e5), "nothing would be released"),
        (lambda m: quick_release(m, 3 * BAR, 100.0, mass=-1.0), "must be positive"),
        (lambda m: force_velocity(m, 3 * BAR, speeds=[-0.1, 0.2]), "not negative"),
        (lambda m: force_map(m, [5.0], [3 * BAR]), "not a length or per cent"),
    ],
)
def test_an_experiment_that_makes_no_sense_is_refused_with_its_numbers(call, words):
    with pytest.raises(ParameterError, match=words):
        call(muscle("chou-hannaford"))
