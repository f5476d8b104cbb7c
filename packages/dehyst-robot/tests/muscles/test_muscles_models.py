"""What every muscle model must do: take energy only, remember exactly, give pressures back, refuse what is wrong."""

import dataclasses
import inspect

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dehyst.errors import InvertibilityError, ParameterError, RecordingError
from dehyst_robot.muscles import MuscleModel, muscle, muscle_class, muscle_names
from dehyst_robot.muscles._solve import solve_pressure
from in_one import in_one


def each_set(test, models):
    """Give the test each of the models with all of its published sets."""

    def of_model(name):
        for which in muscle_class(name).SETS:
            try:
                test(name, which)
            except Exception as fault:
                fault.add_note(f"{name}, set {which}")
                raise

    of_model.__name__, of_model.__doc__ = test.__name__, test.__doc__
    of_model.pytestmark = list(getattr(test, "pytestmark", ()))
    return pytest.mark.parametrize("name", models)(of_model)


def every_set(test):
    return each_set(test, muscle_names())


def every_dynamic(test):
    return each_set(test, [name for name in muscle_names() if muscle_class(name).dynamic])


def walk(seed, samples=300, period=0.01):
    """A motion within 0.02 .. 0.15 with turns of many sizes, pressures of 2 to 5 bar, and times."""
    rng = np.random.default_rng(seed)
    turns = rng.uniform(0.02, 0.15, 12)
    path = np.interp(np.linspace(0, 11, samples), np.arange(12), turns)
    pressure = 3.5e5 + 1.5e5 * np.sin(
        np.linspace(0, rng.uniform(3, 20), samples) + rng.uniform(0, 6)
    )
    return path, pressure, period * np.cumsum(rng.uniform(0.5, 1.5, samples))


few = settings(max_examples=30)
seeds = st.integers(0, 2**32 - 1)


def test_the_twelve_models_of_the_review_are_there():
    assert set(muscle_names()) == {
        "chou-hannaford", "tondu-lopez", "klute", "reynolds", "kerscher", "tondu-zagal", "davis-caldwell", "vo-minh",
        "boblan-martens", "aschemann-schindele", "sarosi", "maker",
    }  # fmt: skip
    for name in muscle_names():
        assert muscle_class(name).name == name


@every_set
def test_every_parameter_is_described(name, which):
    model = muscle(name, which)
    listed = [entry.name for entry in model.PARAMETERS]
    assert (
        listed
        == [field.name for field in dataclasses.fields(model)]
        == list(inspect.signature(type(model)).parameters)
    )
    assert all(
        entry.unit and entry.source and entry.meaning and entry.low < entry.high
        for entry in model.PARAMETERS
    )
    assert set(model.as_dict()) == set(listed)
    assert type(model)(**model.as_dict()) == model
    low, high = model.bounds()
    assert np.all((low <= model.vector()) & (model.vector() <= high))
    assert model.with_vector(model.vector()) == model
    page = type(model).__doc__
    assert "Cannot show" in page and ".. math::" in page


@every_set
def test_records_are_frozen_and_hashable(name, which):
    model = muscle(name, which)
    with pytest.raises(dataclasses.FrozenInstanceError):
        model.length = 1.0
    assert hash(model) == hash(muscle(name, which))


@every_set
@few
@given(
    share=st.floats(0, 1),
    pressure=st.floats(0, 8e5),
    speed=st.floats(-3, 3),
    period=st.floats(1e-5, 10),
)
def test_forces_are_numbers_wherever_the_model_holds(name, which, share, pressure, speed, period):
    model = muscle(name, which)
    low, high = model.limits
    start = min(high, low + share * (high - low))
    end = min(high, max(low, start + speed * period / model.length))
    assert np.isfinite(model.static_force(start, pressure))
    assert np.all(
        np.isfinite(model.simulate([start, end, start], pressure, [0.0, period, 2 * period]))
    )
    assert np.all(
        model.simulate([start, end, start], pressure, [0.0, period, 2 * period], clamp=True) >= 0
    )


@every_set
@few
@given(seed=seeds, cut=st.integers(0, 300), second=st.integers(0, 300))
def test_pieces_of_a_motion_give_the_forces_of_the_whole(name, which, seed, cut, second):
    model, (x, p, t) = muscle(name, which), walk(seed)
    cuts = sorted((cut, second))
    memory, pieces = None, []
    for part in (slice(0, cuts[0]), slice(cuts[0], cuts[1]), slice(cuts[1], None)):
        if x[part].size:
            force, memory = model.run(x[part], p[part], t[part], memory)
            pieces.append(force)
    np.testing.assert_allclose(
        np.concatenate(pieces), model.simulate(x, p, t), rtol=1e-10, atol=1e-8
    )


@every_set
@few
@given(seed=seeds)
def test_sample_by_sample_gives_the_same_forces(name, which, seed):
    model, (x, p, _) = muscle(name, which), walk(seed, 100)
    step = model.stepper(x[0])
    one_by_one = [step(*sample, 0.01) for sample in zip(x.tolist(), p.tolist(), strict=True)]
    force, memory = model.run(x, p, 0.01 * np.arange(100))
    np.testing.assert_allclose(one_by_one, force, rtol=1e-9, atol=1e-7)
    np.testing.assert_allclose(step.memory.plays, memory.plays, rtol=1e-12)
    assert step.memory.contraction == memory.contraction


@every_dynamic
@few
@given(seed=seeds, pressure=st.floats(1e5, 6e5))
def test_friction_takes_energy_along_every_closed_motion_from_rest(name, which, seed, pressure):
    model, (x, _, t) = muscle(name, which), walk(seed, 4000, 1e-3)
    x = np.r_[x, np.linspace(x[-1], x[0], 400)]
    t = np.r_[t, t[-1] + 1e-3 * np.arange(1, 401)]
    for time in (t, None):
        friction = model.static_force(x, pressure) - model.simulate(x, pressure, time)
        work = np.cumsum(friction[1:] * np.diff(x))  # per metre of length
        assert work[-1] >= -1e-12
        if model.dynamic and time is not None and not isinstance(model, muscle_class("klute")):
            assert work[-1] > 0


@every_dynamic
def test_friction_opposes_the_motion_once_everything_slips(name, which):
    model = muscle(name, which)
    up = np.linspace(0.02, 0.15, 200)
    time = 1e-3 * np.arange(400)
    friction = model.static_force(np.r_[up, up[::-1]], 3e5) - model.simulate(
        np.r_[up, up[::-1]], 3e5, time
    )
    assert friction[0] == 0.0  # at rest
    if (name, which) != ("klute", "bare"):
        assert friction[199] > 0 > friction[399]


@pytest.mark.slow
@every_set
@few
@given(seed=seeds)
def test_pressures_are_found_from_forces_with_friction_and_memory(name, which, seed):
    model, (x, p, t) = muscle(name, which), walk(seed, 60, 0.1)
    x = 0.02 + 0.5 * (x - 0.02)  # where every model still pulls
    for time in (t, None):
        found = model.inverse(model.simulate(x, p, time), x, time)
        np.testing.assert_allclose(found, p, rtol=1e-6)


@every_set
@few
@given(kappa=st.floats(0, 0.12), pressure=st.floats(1e5, 8e5))
def test_pressures_are_found_from_forces_at_rest(name, which, kappa, pressure):
    model = muscle(name, which)
    assert model.inverse_pressure(model.static_force(kappa, pressure), kappa) == pytest.approx(
        pressure, rel=1e-6
    )


@every_set
def test_an_affine_model_is_affine_and_says_so(name, which):
    model, k = muscle(name, which), np.linspace(0, 0.12, 13)
    pull, hold = model.affine(k)
    p = np.array([0.5e5, 3e5, 6e5])[:, None]
    error = np.abs(pull * p - hold - model.static_force(k, p)).max()
    if model.affine_in_pressure:
        assert error < 1e-8
    assert np.all(pull > 0)


@every_set
def test_a_memory_left_at_rest_is_that_of_a_fresh_start(name, which):
    model = muscle(name, which)
    x, p, t = walk(1, 50)
    np.testing.assert_array_equal(model.run(x, p, t, model.rest(x[0]))[0], model.simulate(x, p, t))


def test_contraction_in_per_cent_and_lengths_in_millimetres_are_refused():
    with pytest.raises(ParameterError, match="not a length or per cent"):
        muscle("maker").static_force(10.0, 3e5)
    with pytest.raises(ParameterError, match="not a length or per cent"):
        muscle("maker").simulate([0.1, 300.0], 3e5)


@in_one(
    "x, p, t, error, message",
    [
        ([0.1, float("nan")], 3e5, None, ParameterError, "nan"),
        ([0.1, 0.1], [3e5, float("inf")], None, ParameterError, "inf"),
        ([0.1, 0.1], 3e8, None, ParameterError, "up to"),
        ([0.1, 0.1], [3e5], None, RecordingError, "of one log"),
        ([0.1, 0.1], 3e5, [0.0], RecordingError, "one time for each"),
        ([0.1, 0.1], 3e5, [1.0, 1.0], RecordingError, "does not increase"),
        ([0.1, 0.1], 3e5, [1.0, 0.5], RecordingError, "does not increase"),
        ([0.1, 0.1], 3e5, [0.0, float("nan")], RecordingError, "does not increase"),
        ([0.1], 3e5, [float("nan")], RecordingError, "does not increase"),
        ([[0.1]], 3e5, None, ParameterError, "shape"),
        (["a"], 3e5, None, ParameterError, "not a sequence of numbers"),
        ([0.1], "a lot", None, ParameterError, "not a number"),
    ],
)
def test_bad_signals_are_named(x, p, t, error, message):
    with pytest.raises(error, match=message):
        muscle("tondu-lopez").simulate(x, p, t)


def test_a_piece_that_begins_before_the_memory_ends_is_refused():
    model = muscle("tondu-lopez")
    _, memory = model.run([0.1, 0.11], 3e5, [0.0, 1.0])
    with pytest.raises(RecordingError, match="does not increase"):
        model.run([0.11, 0.12], 3e5, [0.5, 2.0], memory)


@in_one(
    "name, changes, message",
    [
        ("maker", {"length": 0.0}, "must be positive"),
        ("maker", {"length": "long"}, "not a number"),
        ("maker", {"radius": 1.0}, "no parameter 'radius'"),
        ("chou-hannaford", {"angle": 28.6}, "in rad"),
        ("chou-hannaford", {"wall": 0.01}, "fills the muscle"),
        ("chou-hannaford", {"band": -1.0}, "negative"),
        ("klute", {"wall": 0.01}, "fills the muscle"),
        ("tondu-lopez", {"angle": 1.2}, "54.7"),
        ("reynolds", {"force": (1.0, 2.0, 3.0)}, "3 values for 2 pressures"),
        ("reynolds", {"pressures": (2e5, 1e5)}, "increase strictly"),
        ("reynolds", {"relaxing": (-1.0, 1.0)}, "negative"),
        ("vo-minh", {"slip_strains": (0.1, 0.2)}, "a force for each"),
        ("vo-minh", {"pressure_share": 2.0}, "share of 0 to 1"),
        ("aschemann-schindele", {"a": ()}, "shape"),
        ("sarosi", {"a3": float("nan")}, "finite"),
    ],
)
def test_bad_parameters_are_named(name, changes, message):
    with pytest.raises(ParameterError, match=message):
        muscle(name, **changes)


def test_unknown_models_and_sets_are_answered_with_those_there_are():
    with pytest.raises(ParameterError, match="Did you mean tondu-lopez"):
        muscle("tondulopez")
    with pytest.raises(ParameterError, match="there are: DMSP-40, DMSP-20, DMSP-10"):
        muscle("maker", "DMSP-5")
    with pytest.raises(ParameterError, match="fitted parameters"):
        muscle("maker").with_vector([1.0])


def test_beyond_the_largest_contraction_no_pressure_is_made_up():
    model = muscle("chou-hannaford")
    with pytest.raises(InvertibilityError, match="does not grow with the pressure"):
        model.inverse_pressure(10.0, model.largest_contraction + 0.01)
    serres = muscle(
        "reynolds"
    )  # its spring stiffens with the pressure: beyond 45 mm pressure takes force away
    with pytest.raises(InvertibilityError, match="does not grow with the pressure"):
        serres.inverse_pressure(10.0, 0.16)


def test_a_force_that_no_pressure_gives_is_named_with_what_can_be_had():
    with pytest.raises(InvertibilityError, match="Ask for a force in between"):
        muscle("kerscher").inverse_pressure(1e6, 0.1)


@given(wanted=st.floats(0.0, 2e6), curve=st.floats(0.0, 1e-9))
def test_the_solver_finds_the_root_of_a_convex_curve(wanted, curve):
    def force(p):
        return 1e-3 * p + curve * p * p

    found = solve_pressure(force, np.array([force(wanted)]), False, "a curve")
    assert found[0] == pytest.approx(wanted, rel=1e-9, abs=1e-6)


def test_parameters_far_beyond_their_meaning_give_no_silent_infinities():
    wild = muscle("maker", decay=1e5)
    with pytest.raises(ParameterError, match="far outside"):
        wild.static_force(-0.05, 3e5)
    with pytest.raises(ParameterError, match="far outside"):
        wild.simulate([0.0, -0.05], 3e5)
    with pytest.raises(ParameterError, match="far outside"):
        wild.stepper(0.0)(-0.05, 3e5, 1e-3)


def test_time_stamps_that_nearly_repeat_and_periods_of_zero_are_named():
    model = muscle("tondu-zagal")
    with pytest.raises(RecordingError, match="nearly repeat"):
        model.simulate([0.1, 0.11], 3e5, [0.0, 1e-300])
    for period in (0.0, float("nan")):
        with pytest.raises(ParameterError, match="period"):
            model.stepper(0.1)(0.1, 3e5, period)


def test_empty_motions_give_empty_forces():
    model = muscle("tondu-lopez")
    assert isinstance(model, MuscleModel)
    assert model.simulate([], []).size == 0
    assert model.inverse([], []).size == 0


@every_dynamic
def test_a_force_that_is_only_tried_is_the_one_of_the_motion_and_leaves_the_memory(name, which):
    model, (path, pressure, time) = muscle(name, which), walk(7)
    _, memory = model.run(path[:200], pressure[:200], time[:200])
    for i in (200, 230, 260, 299):
        for stamp, stamps in ((float(time[200]), [time[200]]), (float("nan"), None)):
            at, p = float(path[i]), float(pressure[i])
            force, _ = model.run([at], [p], stamps, memory)
            assert model.force_after(memory, at, p, stamp) == pytest.approx(
                float(force[0]), abs=1e-8
            )
    with pytest.raises(ParameterError, match="outside"):
        model.force_after(memory, 2.0, 3e5)


def test_a_stepper_outside_the_limits_of_its_model_says_where_it_is():
    with pytest.raises(ParameterError, match="left the range"):
        muscle("tondu-lopez").stepper(0.1)(0.9, 3e5, 1e-3)
