"""The evaluator of long signals: as accurate as the core's steps after any length, by every method; pitfalls."""

import threading
from functools import lru_cache

import numpy as np
import pytest

from dehyst import ModifiedPrandtlIshlinskii, MonotoneMap, PrandtlIshlinskii, _native
from dehyst._native import ENGINE_DENSE, Evaluator, Stepper
from oracles import exact_pi

NONE = np.zeros(0)
EVENTS, AUTO = 0, -1
METHODS = {"events": EVENTS, "prefix 8": 8, "prefix 64": 64, "dense": ENGINE_DENSE, "auto": AUTO}
every_method = pytest.mark.parametrize("method", METHODS.values(), ids=METHODS.keys())


@pytest.fixture(autouse=True)
def best_level():
    yield
    _native.engine_use_level(_native.engine_best_level())


def operator(n, seed=0, first=0.0):
    rng = np.random.default_rng(seed)
    r = first + np.concatenate([[0.0], np.cumsum(rng.uniform(0.5, 1.5, n - 1))]) / n
    return r, rng.uniform(0.0, 2.0 / n, n)


def signal(kind, samples, seed=0):
    """Return the benchmark's signals: a sine of 20 s at 2 kHz, with noise of 1 % of the range, full-range noise, ..."""
    rng, t = np.random.default_rng(seed), np.arange(samples)
    sine = np.sin(2 * np.pi * t / 40_000)
    if kind == "decaying":
        return sine * np.linspace(1, 0, samples)
    noise = {"smooth": 0.0, "noisy": 0.02, "white": 1.0}[kind]
    return (sine if kind != "white" else 0.0) + noise * rng.uniform(-1, 1, samples)


def evaluated(x, r, w, method=AUTO, center=0.0, offset=0.0, state=None):
    engine = Evaluator(r, w, center, offset, np.zeros(r.size) if state is None else state)
    engine.method(method)
    return engine.run(x)


def stepped(x, r, w, center=0.0, offset=0.0, state=None):
    """Return the core's outputs, one step a sample."""
    step = Stepper(
        r, w, center, offset, NONE, NONE, NONE, NONE, np.zeros(r.size) if state is None else state
    )
    return np.array([step(v) for v in x.tolist()])


# ---- Accuracy.


@pytest.mark.parametrize("kind", ["noisy", "white", "decaying"])
def test_outputs_stay_within_1e_14_of_the_definition_over_a_million_samples(kind):
    r, w = operator(100)
    x = signal(kind, 1_000_000 if kind == "noisy" else 300_000)
    want = stepped(x, r, w, 0.1, 0.2)
    for name, method in METHODS.items():
        error = np.abs(evaluated(x, r, w, method, 0.1, 0.2) - want) / np.abs(want).max()
        assert error.max() <= 1e-14, name
        assert error[-50_000:].max() <= 2 * error[:100_000].max() + 1e-15, f"{name}: grows"


@every_method
def test_the_output_does_not_drift_from_its_state_in_ten_million_samples(method):
    r, w = operator(100, 1)
    x = signal("noisy", 1_000_000, 1)
    engine = Evaluator(r, w, 0.0, 0.0, np.zeros(100))
    engine.method(method)
    for _ in range(10 if method != EVENTS else 4):
        y = engine.run(x)
        want = np.dot(w.astype(np.longdouble), engine.state.astype(np.longdouble))
        assert abs(y[-1] - want) <= 1e-14 * np.abs(y).max()


@pytest.mark.parametrize(("n", "bound"), [(100, 1e-14), (1000, 1e-14), (10_000, 3e-14)])
def test_inverse_after_model_returns_the_input(n, bound):
    r, w = np.arange(n) / n, np.random.default_rng(n).uniform(0, 2 / n, n)
    w[0] += 0.3
    for kind in ("smooth", "noisy"):
        x = signal(kind, 100_000)
        fault, ri, wi, zi = _native.pi_invert(r, w, np.zeros(n))
        assert fault == 0
        back = evaluated(evaluated(x, r, w), ri, wi, state=zi)
        assert np.abs(back - x).max() <= bound * np.ptp(x)


@pytest.mark.parametrize("method", [EVENTS, AUTO], ids=["events", "auto"])
def test_an_inverse_of_weights_1000_and_minus_999_is_as_accurate_as_the_core(method):
    rng = np.random.default_rng(5)
    r, w = np.arange(12) / 12, np.concatenate([[0.001], rng.uniform(0.2, 1, 11)])
    _, ri, wi, zi = _native.pi_invert(r, w, np.zeros(12))
    assert wi[0] > 999
    assert wi[1] < -990
    y = rng.uniform(-2, 2, 150)
    exact = np.array([float(v) for v in exact_pi(y, ri, wi, zi)])
    core, ours = (
        np.abs(stepped(y, ri, wi, state=zi) - exact),
        np.abs(evaluated(y, ri, wi, method, state=zi) - exact),
    )
    assert ours.max() <= 1.5 * core.max() + 4e-16 * np.abs(exact).max()


def test_automatic_choice_on_long_noise_through_a_steep_inverse_keeps_to_events():
    r, w = np.arange(100) / 100, np.full(100, 0.01)
    w[0] = 0.001
    _, ri, wi, zi = _native.pi_invert(r, w, np.zeros(100))
    x = signal("noisy", 30_000)
    y = stepped(x, r, w)
    want = stepped(y, ri, wi, state=zi)
    assert np.abs(evaluated(y, ri, wi, AUTO, state=zi) - want).max() <= 1e-12 * np.abs(want).max()
    assert (
        np.abs(evaluated(y, ri, wi, ENGINE_DENSE, state=zi) - want).max()
        > np.abs(evaluated(y, ri, wi) - want).max()
    )


# ---- Pitfalls.


@lru_cache
def on_bounds():
    """Return thresholds and samples that meet the bounds of windows, or miss them by a rounding."""
    rng = np.random.default_rng(7)
    r, x = np.arange(96) * 0.1, np.zeros(40_000)
    for k in range(1, x.size):
        base = x[k - 1] if rng.random() < 0.5 else x[max(0, k - int(rng.integers(1, 9)))]
        x[k] = base + rng.choice([-1, 1]) * 2 * r[int(rng.integers(0, 12))]
        x[k] = np.nextafter(x[k], rng.choice([-np.inf, np.inf])) if rng.random() < 0.3 else x[k]
        x[k] = 0.0 if abs(x[k]) > 9 else x[k]
    return r, x


@every_method
def test_a_sample_on_the_bound_of_the_window_or_a_rounding_beyond_ends_its_event(method):
    """Window e + 2 r and swallow test x - e > 2 r round differently: the sample of an event is consumed regardless."""
    r, x = on_bounds()
    w = np.random.default_rng(8).uniform(0, 1, 96)
    want = stepped(x, r, w)
    assert np.abs(evaluated(x, r, w, method) - want).max() <= 1e-14 * np.abs(want).max()


@pytest.mark.parametrize("first", [0.0, 0.05], ids=["r_1 = 0", "r_1 > 0"])
def test_noise_below_the_first_threshold_makes_no_events(first):
    r, w = operator(100, 2, first)
    below = 0.45 * (r[1] if first == 0 else r[0])
    x = np.concatenate(
        [np.linspace(0, 1, 500), 1 + below * (np.random.default_rng(1).uniform(-1, 1, 100_000) - 1)]
    )
    engine = Evaluator(r, w, 0.0, 0.0, np.zeros(100))
    engine.method(EVENTS)
    y = engine.run(x)
    assert engine.events < 200
    assert np.abs(y - stepped(x, r, w)).max() <= 1e-14 * y.max()


def test_an_operator_without_a_threshold_of_zero_follows_the_definition():
    r, w = operator(30, 3, 0.2)
    x = signal("noisy", 20_000) * 1.7
    want = stepped(x, r, w, 0.3)
    for method in (EVENTS, 8, ENGINE_DENSE, AUTO):
        assert np.abs(evaluated(x, r, w, method, 0.3) - want).max() <= 1e-14 * np.abs(want).max()


def test_many_equal_turning_points_and_long_rests_cost_nothing_and_change_nothing():
    r, w = operator(50, 4)
    x = np.repeat(np.tile([0.8, -0.8, 0.3, -0.3, 0.3, -0.8], 200), 17)
    engine = Evaluator(r, w, 0.0, 0.0, np.zeros(50))
    engine.method(EVENTS)
    assert np.abs(engine.run(x) - stepped(x, r, w)).max() <= 1e-15
    assert engine.events <= 1200


# ---- Samples that are no numbers.


@every_method
def test_rejected_samples_hold_the_output_and_are_counted(method):
    r, w = operator(100, 5)
    x = signal("noisy", 5000)
    clean = evaluated(x, r, w, method, 0.2, 0.1)
    holes = np.sort(np.random.default_rng(1).choice(np.arange(1, 5000), 300, replace=False))
    dirty = np.insert(
        x, holes, np.random.default_rng(2).choice([np.nan, np.inf, -np.inf, 1e101], 300)
    )
    engine = Evaluator(r, w, 0.2, 0.1, np.zeros(100))
    engine.method(method)
    y = engine.run(dirty)
    bad = holes + np.arange(300)
    assert engine.rejected == 300
    assert np.array_equal(y[bad], y[bad - 1])
    assert np.abs(np.delete(y, bad) - clean).max() <= 1e-14 * np.abs(clean).max()


@every_method
def test_bad_first_samples_hold_the_output_of_the_start(method):
    r, w = operator(100, 6, 0.1)
    start = np.full(100, 0.3)
    y = evaluated(np.array([np.nan, np.inf, 0.9]), r, w, method, 0.0, 0.5, start)
    assert y[0] == y[1] == pytest.approx(0.5 + 0.3 * w.sum(), abs=1e-14)


# ---- Continuing.


@every_method
def test_a_run_in_pieces_gives_the_bits_of_one_run(method):
    r, w = operator(100, 7)
    x = np.concatenate([signal(k, 30_000, 3) for k in ("smooth", "noisy", "white", "smooth")])
    want = evaluated(x, r, w, method, 0.1)
    engine = Evaluator(r, w, 0.1, 0.0, np.zeros(100))
    engine.method(method)
    cuts = np.sort(np.random.default_rng(4).integers(0, x.size, 400))
    pieces = [engine.run(piece) for piece in np.split(x, cuts)]
    assert np.concatenate(pieces).tobytes() == want.tobytes()


@every_method
def test_a_run_in_place_gives_the_bits_of_a_run_apart(method):
    r, w = operator(100, 8)
    x = signal("noisy", 20_000)
    y = x.copy()
    engine = Evaluator(r, w, 0.0, 0.0, np.zeros(100))
    engine.method(method)
    assert engine.run(y, y) is y
    assert y.tobytes() == evaluated(x, r, w, method).tobytes()


def test_methods_may_change_at_any_sample():
    r, w = operator(80, 9)
    x = signal("noisy", 20_000)
    engine, rng, pieces = Evaluator(r, w, 0.0, 0.0, np.zeros(80)), np.random.default_rng(5), []
    for piece in np.split(x, np.sort(rng.integers(0, x.size, 100))):
        engine.method(int(rng.choice([EVENTS, 8, 16, 72, ENGINE_DENSE, AUTO])))
        pieces.append(engine.run(piece))
    want = stepped(x, r, w)
    assert np.abs(np.concatenate(pieces) - want).max() <= 1e-14 * np.abs(want).max()


def test_the_state_after_a_run_is_that_of_the_plays_and_continues_them():
    r, w = operator(40, 10)
    x = signal("decaying", 30_000)
    for method in (EVENTS, 8, 32, ENGINE_DENSE, AUTO):
        engine = Evaluator(r, w, 0.0, 0.0, np.zeros(40))
        engine.method(method)
        engine.run(x[:20_000])
        _, want = _native.play_bank(x[:20_000], r, np.zeros(40), np.zeros(0, np.int64))
        assert np.abs(engine.state - want).max() <= 4e-16
        again = evaluated(x[20_000:], r, w, method, state=engine.state)
        assert np.abs(again - engine.run(x[20_000:])).max() <= 1e-15


@pytest.mark.parametrize("method", [EVENTS, AUTO], ids=["events", "auto"])
@pytest.mark.parametrize("shift", [1, 3])
def test_outputs_do_not_depend_on_the_alignment_or_length_of_memory(method, shift):
    """Long outputs go past the caches to aligned addresses: the same bits, and nothing beyond the last."""
    r, w = operator(100, 11)
    x = np.tile(signal("smooth", 50_000), 90)
    parts = Evaluator(r, w, 0.0, 0.0, np.zeros(100))
    parts.method(method)
    want = np.concatenate([parts.run(piece) for piece in np.split(x, 90)])
    engine, room = Evaluator(r, w, 0.0, 0.0, np.zeros(100)), np.full(x.size + 20, 7.0)
    engine.method(method)
    engine.run(x, room[shift : shift + x.size])
    assert np.array_equal(room[shift : shift + x.size], want)
    assert np.all(room[:shift] == 7)
    assert np.all(room[shift + x.size :] == 7)


# ---- The choice, the levels, the interface.


def events_of(x, r, w, method):
    engine = Evaluator(r, w, 0.0, 0.0, np.zeros(r.size))
    engine.method(method)
    engine.run(x)
    return engine.events


@pytest.mark.parametrize(("n", "kind"), [(100, "noisy"), (100, "white"), (1000, "noisy")])
def test_noise_is_met_with_a_dense_prefix_and_events_become_rare(n, kind):
    r, w = operator(n)
    x = signal(kind, 200_000)
    assert events_of(x, r, w, AUTO) < 0.1 * events_of(x, r, w, EVENTS)


def test_a_signal_that_calms_down_goes_back_to_events():
    r, w = operator(100)
    x = np.concatenate([signal("white", 20_000), signal("smooth", 600_000)])
    engine = Evaluator(r, w, 0.0, 0.0, np.zeros(100))
    engine.run(x[:-40_000])
    before = engine.events
    engine.run(x[-40_000:])
    assert engine.events - before == events_of(np.tile(x[-40_000:], 2), r, w, EVENTS) - events_of(
        x[-40_000:], r, w, EVENTS
    )


def test_levels_agree_to_rounding():
    r, w = operator(100, 12)
    x = signal("noisy", 30_000)
    for method in METHODS.values():
        found = []
        for level in range(_native.engine_best_level() + 1):
            _native.engine_use_level(level)
            assert _native.engine_level() == level
            found.append(evaluated(x, r, w, method))
        assert all(np.abs(y - found[0]).max() <= 4e-15 for y in found)


def test_a_level_that_does_not_exist_is_refused():
    with pytest.raises(ValueError, match="cannot run here"):
        _native.engine_use_level(3)


@pytest.mark.parametrize("method", [7, -2, 40, 48])
def test_a_method_that_does_not_apply_is_refused(method):
    engine = Evaluator(*operator(40), 0.0, 0.0, np.zeros(40))
    with pytest.raises(ValueError, match="no such method"):
        engine.method(method)
    assert engine.run(np.ones(3)).shape == (3,)


@pytest.mark.parametrize(
    ("r", "z"),
    [
        ([0.0, 0.5], [0.0, 0.6]),
        ([0.5, 0.5], [0.0, 0.0]),
        ([-0.1, 0.5], [0.0, 0.0]),
        ([0.0, 0.5], [0.0, np.nan]),
    ],
    ids=["state beyond reach", "equal thresholds", "negative threshold", "state not finite"],
)
def test_what_the_stack_cannot_hold_is_refused(r, z):
    with pytest.raises(ValueError, match="not an operator with an admissible state"):
        Evaluator(np.array(r), np.ones(2), 0.0, 0.0, np.array(z))


def test_an_out_of_another_length_is_refused():
    with pytest.raises(ValueError, match="another length"):
        Evaluator(*operator(4), 0.0, 0.0, np.zeros(4)).run(np.ones(3), np.ones(4))


def test_an_out_that_cannot_be_written_to_is_refused():
    evaluator = Evaluator(*operator(4), 0.0, 0.0, np.zeros(4))
    frozen = np.ones(3)
    frozen.flags.writeable = False
    for out in (np.ones(3, dtype=np.float32), np.ones(6)[::2], frozen):
        with pytest.raises(TypeError, match="writable contiguous float64"):
            evaluator.run(np.ones(3), out)


@pytest.mark.parametrize("shift", [1, -1])
def test_an_out_that_overlaps_the_input_is_refused(shift):
    memory = np.ones(3001)
    one, other = memory[:-1], memory[1:]
    x, out = (one, other) if shift > 0 else (other, one)
    with pytest.raises(ValueError, match="overlaps"):
        Evaluator(*operator(4), 0.0, 0.0, np.zeros(4)).run(x, out)


def test_evaluators_of_several_threads_do_not_disturb_each_other():
    r, w = operator(100)
    x = signal("noisy", 200_000)
    want, found = evaluated(x, r, w), {}
    shared = PrandtlIshlinskii(r, w).stepper()

    def work(number):
        found[number] = evaluated(x, r, w)
        shared.simulate(x)  # from two threads at once: some order, no crash

    threads = [threading.Thread(target=work, args=(k,)) for k in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(np.array_equal(found[k], want) for k in range(2))
    assert np.all(np.isfinite(shared.state))


# ---- Models.


def test_maps_before_and_after_are_applied_in_long_signals():
    r, w = operator(20, 13)
    bend = MonotoneMap([-2.0, 0.0, 2.0], [-1.0, 0.0, 3.0])
    model = ModifiedPrandtlIshlinskii(
        PrandtlIshlinskii(r, w, center=0.1), before_map=bend, after_map=bend
    )
    x = signal("noisy", 10_000)
    x[[0, 5000, 9999]] = np.nan
    step = model.stepper()
    y, rejected = step.simulate(x)
    again = model.stepper()
    want = np.array([again(v) for v in x.tolist()])
    assert rejected == 3
    assert step.rejected
    assert np.abs(y - want).max() <= 1e-14 * np.abs(want).max()


def test_a_start_that_no_input_leaves_is_stepped():
    r, w, z = np.array([0.0, 0.2, 0.4]), np.ones(3), np.array([0.0, 0.9, 0.0])
    x = signal("smooth", 5000)
    y, _ = Stepper(r, w, 0.0, 0.0, NONE, NONE, NONE, NONE, z).simulate(x)
    assert np.array_equal(y, stepped(x, r, w, state=z))
