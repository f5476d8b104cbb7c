"""The streaming normal equations are those of the cells written out, whatever the signal, the state and the pieces."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dehyst import _native
from test_engine_levels import FLAGS, compiled, run, tool

UNIT = np.finfo(float).eps


def play_outputs(x, r, z):
    """Return outputs (T, n) of play operators and their last states, by the definition."""
    out = np.empty((len(x), len(r)))
    for k, sample in enumerate(x):
        z = np.maximum(sample - r, np.minimum(sample + r, z))
        out[k] = z
    return out, z


def written_out(x, targets, r, z, weights=None):
    """Return sums of products of [1 | cells | targets] in extended precision, and the last states."""
    outputs, last = play_outputs(x, r, z)
    plays = outputs.astype(np.longdouble)
    cells = plays - np.column_stack([plays[:, 1:], np.zeros(len(x))])
    columns = np.column_stack([np.ones(len(x)), cells, targets.T])
    return (columns.T * (1 if weights is None else weights)) @ columns, last


def in_plays(sums, n):
    """Return the sums with z_i = cell_i + ... + cell_n in place of the cells."""
    sums = sums.astype(np.longdouble)
    plays = np.eye(len(sums), dtype=np.longdouble)
    plays[1 : n + 1, 1 : n + 1] = np.triu(np.ones((n, n)))
    return plays @ sums @ plays.T


def error(found, exact, n):
    """Return max|G - G_ref| / max|G_ref| of the cells, or of the plays if it is larger."""
    of_cells = np.abs(found - exact).max() / np.abs(exact).max()
    a, b = in_plays(found, n), in_plays(exact, n)
    return float(max(of_cells, np.abs(a - b).max() / np.abs(b).max()))


def thresholds(rng, n):
    """Return 0 = r_1 < ... < r_n: evenly spaced, uneven, or on integers."""
    return [
        np.arange(n) / n,
        np.r_[0, np.cumsum(rng.uniform(0.02, 1, n))[:-1]],
        np.arange(n) * 2.0,
    ][rng.integers(3)]


def signal(rng, samples, reach):
    """Return a signal of one of the kinds that matter: white, walking, on a grid, smooth, noisy, constant."""
    k = np.arange(samples)
    kind = rng.integers(6)
    smooth = reach * np.sin(k / rng.uniform(2, 40))
    if kind == 0:
        return rng.uniform(-reach, reach, samples)
    if kind == 1:
        return np.cumsum(rng.normal(0, reach / 8, samples))
    if kind == 2:
        return np.round(rng.uniform(-reach, reach, samples))
    if kind == 3:
        return smooth
    if kind == 4:
        return smooth + rng.uniform(-0.05, 0.05, samples) * reach
    return np.full(samples, rng.uniform(-reach, reach))


def start_state(rng, r, reach):
    """Return an admissible state: demagnetised, flat, or left behind by a history."""
    kind = rng.integers(4)
    if kind == 0:
        return np.zeros(len(r))
    if kind == 1:
        return np.full(len(r), rng.uniform(-reach, reach))
    return play_outputs(rng.uniform(-reach, reach, rng.integers(1, 12)), r, np.zeros(len(r)))[1]


def case(seed, n=None, samples=200):
    """Return x, targets, thresholds and a start state drawn from a seed."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 41)) if n is None else n
    r = thresholds(rng, n)
    reach = (r[-1] + 0.3) * rng.uniform(0.3, 2)
    x = signal(rng, int(rng.integers(1, samples)), reach)
    return x, rng.normal(size=(int(rng.integers(0, 4)), len(x))), r, start_state(rng, r, reach)


@pytest.mark.parametrize("n", range(1, 41))
def test_sums_are_those_of_the_cells_written_out(n):
    for seed in range(6):
        x, targets, r, z = case([n, seed], n)
        gram = _native.Gram(r, z, len(targets))
        gram.add(x, targets)
        exact, last = written_out(x, targets, r, z)
        found = gram.take()
        assert np.array_equal(found, found.T)
        assert error(found, exact, n) < 4e-14
        assert np.abs(gram.state - last).max() <= 4 * UNIT * (np.abs(x).max() + r[-1])


@settings(max_examples=150, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_pieces_weights_and_skipped_samples_add_up(seed):
    x, targets, r, z = case(seed)
    rng = np.random.default_rng([seed, 1])
    weights = (
        rng.choice([0.0, 1.0, 2.5], len(x)) * rng.uniform(0.5, 1, len(x))
        if rng.random() < 0.5
        else None
    )
    cuts = np.sort(rng.integers(0, len(x) + 1, 4))
    gram = _native.Gram(r, z, len(targets))
    found = np.zeros((1 + len(r) + len(targets),) * 2)
    kept = np.ones(len(x))
    for piece, (a, b) in enumerate(zip(np.r_[0, cuts], np.r_[cuts, len(x)], strict=True)):
        if piece == 2:
            gram.skip(x[a:b])
            kept[a:b] = 0
        else:
            gram.add(x[a:b], targets[:, a:b].copy(), None if weights is None else weights[a:b])
        if rng.random() < 0.5:
            found += gram.take()
    found += gram.take()
    exact, last = written_out(x, targets, r, z, kept if weights is None else kept * weights)
    if kept @ (kept if weights is None else weights) > 0:
        assert error(found, exact, len(r)) < 4e-14
    assert np.abs(gram.state - last).max() <= 4 * UNIT * (np.abs(x).max() + r[-1])


def test_a_take_forgets_the_sums_and_keeps_the_state():
    x, r = np.array([0.0, 3.0, -1.0]), np.arange(4.0)
    gram = _native.Gram(r, np.zeros(4), 0)
    gram.add(x, np.empty((0, 3)))
    gram.take()
    assert not gram.take().any()
    gram.add(x, np.empty((0, 3)))
    exact, _ = written_out(x, np.empty((0, 3)), r, play_outputs(x, r, np.zeros(4))[1])
    assert error(gram.take(), exact, 4) < 1e-15


def test_only_targets_leaves_the_rest_at_zero():
    x, _, r, z = case(3, 12)
    y = np.vstack([x**2, np.cos(x)])
    gram = _native.Gram(r, z, 2)
    gram.only_targets(True)
    gram.add(x, y)
    found, (exact, _) = gram.take(), written_out(x, y, r, z)
    assert not found[:13, 1:13].any()
    assert np.abs(found[13:] - exact[13:]).max() < 1e-13 * np.abs(exact[13:]).max()
    gram.only_targets(False)
    gram.add(x, y)
    assert error(gram.take(), written_out(x, y, r, play_outputs(x, r, z)[1])[0], 12) < 4e-14


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"x": np.array([0.0, np.nan, 1.0])}, "sample 1 of x is nan"),
        ({"x": np.array([0.0, 0.0, 1e101])}, r"sample 2 of x is 1e\+101"),
        ({"targets": np.array([[0.0, 0.0, np.inf]])}, "sample 2 of target 0 is inf"),
        ({"weights": np.array([1.0, -1.0, 1.0])}, "sample 1 of the weights is -1"),
        ({"targets": np.zeros((2, 3))}, r"shape \(1, 3\)"),
        ({"weights": np.ones(2)}, "differ in length"),
    ],
)
def test_bad_samples_are_named_and_shapes_checked(change, message):
    gram = _native.Gram(np.arange(3.0), np.zeros(3), 1)
    with pytest.raises(ValueError, match=message):
        gram.add(**({"x": np.zeros(3), "targets": np.zeros((1, 3))} | change))


@pytest.mark.parametrize("method", [0, 8])
@pytest.mark.parametrize("what", ["x", "target", "second target", "weight"])
def test_samples_before_a_bad_one_are_in_the_sums_and_none_from_it_on(what, method):
    x, _, r, z = case(21, 20, 3000)
    x, y, w = np.tile(x, 3), np.vstack([np.cos(np.tile(x, 3))] * 2), np.full(3 * len(x), 0.5)
    for bad in (0, 5, len(x) // 2, len(x) - 1):
        a, b, c = x.copy(), y.copy(), w.copy()
        {"x": a, "target": b[0], "second target": b[1], "weight": c}[what][bad] = np.nan
        gram = _native.Gram(r, z, 2)
        gram.method(method)
        with pytest.raises(ValueError, match=f"sample {bad} of "):
            gram.add(a, b, c if what == "weight" else None)
        exact, last = written_out(x[:bad], y[:, :bad], r, z, w[:bad] if what == "weight" else None)
        found = gram.take()
        assert np.abs(found - exact).max() <= 4e-14 * np.abs(exact).max()
        assert np.abs(gram.state - last).max() <= 4 * UNIT * (np.abs(x).max() + r[-1])


@pytest.mark.parametrize(
    ("r", "z", "message"),
    [
        ([0.5, 1.0], [0.0, 0.0], "first threshold must be 0"),
        ([0.0, 1.0, 1.0], [0.0] * 3, "increase strictly"),
        ([0.0, 1e-310], [0.0] * 2, "too close"),
        ([0.0, 1.0], [0.0, 2.0], "not admissible"),
        ([0.0, np.nan], [0.0, 0.0], "not finite"),
        ([], [], "operators"),
        ([0.0, 1.0], [0.0], "differ in length"),
    ],
)
def test_operators_that_cannot_be_are_refused(r, z, message):
    with pytest.raises(ValueError, match=message):
        _native.Gram(np.array(r, dtype=float), np.array(z, dtype=float), 1)


METHODS = (-1, 0, 4, 8, 12, 16, 20, 28, 40, 44, _native.ENGINE_DENSE)


def sums_of(x, targets, r, z, method, weights=None):
    """Return the sums of one pass with this method."""
    gram = _native.Gram(r, z, len(targets))
    gram.method(method)
    gram.add(x, targets, weights)
    return gram.take()


def by_blas(x, y, r, piece=512):
    """Return sums of products of [1 | cells | y] and of [1 | plays | y] by BLAS, on pieces that round little."""
    n, z = len(r), np.zeros(len(r))
    totals = [np.zeros((n + 2, n + 2), np.longdouble) for _ in range(2)]
    for k in range(0, len(x), piece):
        part = x[k : k + piece]
        plays, z = _native.play_bank(part, r, z, np.arange(len(part)))
        cells = plays - np.column_stack([plays[:, 1:], np.zeros(len(part))])
        for total, columns in zip(totals, (cells, plays), strict=True):
            rows = np.column_stack([np.ones(len(part)), columns, y[k : k + piece]])
            total += rows.T @ rows
    return totals


@pytest.mark.parametrize("method", METHODS)
def test_every_method_gives_the_same_sums(method):
    for seed in range(25):
        x, targets, r, z = case([9, seed], 40)
        weights = np.random.default_rng(seed).uniform(0, 2, len(x)) if seed % 2 else None
        exact, _ = written_out(x, targets, r, z, weights)
        assert error(sums_of(x, targets, r, z, method, weights), exact, 40) < 4e-14


def test_a_method_may_change_between_any_two_samples():
    rng = np.random.default_rng(8)
    for seed in range(10):
        x, targets, r, z = case([10, seed], 33)
        gram = _native.Gram(r, z, len(targets))
        for k in range(len(x)):
            if rng.random() < 0.2:
                gram.method(int(rng.choice((*METHODS[:-2], _native.ENGINE_DENSE))))
            gram.add(x[k : k + 1], targets[:, k : k + 1].copy())
        exact, last = written_out(x, targets, r, z)
        assert error(gram.take(), exact, 33) < 4e-14
        assert np.abs(gram.state - last).max() <= 4 * UNIT * (np.abs(x).max() + r[-1])


@pytest.mark.parametrize("method", [7, -2, 72, 48])
def test_a_method_that_cannot_be_is_refused(method):
    with pytest.raises(ValueError, match="does not apply"):
        _native.Gram(np.arange(40.0), np.zeros(40), 0).method(method)


LONG = 300_000


def long_signal(kind):
    rng, k = np.random.default_rng(4), np.arange(LONG)
    sine = np.sin(k * (2 * np.pi / 40_000))
    return {
        "smooth": sine,
        "noisy": sine + rng.uniform(-0.02, 0.02, LONG),
        "white": rng.uniform(-1, 1, LONG),
        "decaying": np.linspace(1, 0, LONG) * (1 - 4 * np.abs(k % 2000 / 2000 - 0.5)),
        "constant": np.full(LONG, 0.3),
    }[kind]


@pytest.mark.spread(5)
@pytest.mark.parametrize("kind", ["smooth", "noisy", "white", "decaying", "constant"])
@pytest.mark.parametrize("method", [0, 8])
def test_long_runs_lose_no_digits(kind, method):
    x, r = long_signal(kind), np.arange(24) / 24
    y = x + np.random.default_rng(5).normal(0, 0.1, LONG)
    found = sums_of(x, y[None], r, np.zeros(24), method)
    cells, plays = by_blas(x, y, r)
    assert np.abs(found - cells).max() < 3e-15 * np.abs(cells).max()
    g, b = in_plays(found, 24)[:-1, :-1], in_plays(found, 24)[-1, :-1]
    assert (
        np.abs(g - plays[:-1, :-1]).max() < 1e-14 * np.abs(plays[:-1, :-1]).max()
    )  # 2.3e-14 is asked for
    assert np.abs(b - plays[-1, :-1]).max() < 1e-14 * np.abs(plays[-1, :-1]).max()  # 1e-13 is
    length = np.sqrt(np.diag(cells)) + 1e-300
    assert (
        np.abs((found - cells) / np.outer(length, length)).max() < 1e-12
    )  # cells seldom visited count as much


def test_an_event_takes_its_sample_whatever_rounding_says():
    rng = np.random.default_rng(0)
    r = np.r_[0, np.cumsum(rng.uniform(0.1, 1, 20))] / 3
    x = rng.choice(
        np.r_[r, -r, 2 * r, np.nextafter(r, 9), np.nextafter(-r, -9)], 20_000
    ) * rng.choice([1, 0.1, 1 / 3], 20_000)
    exact, _ = written_out(x, x[None], r, np.zeros(21))
    for method in (0, 8):
        assert error(sums_of(x, x[None], r, np.zeros(21), method), exact, 21) < 4e-14


def test_noise_below_the_first_threshold_makes_no_events():
    gram = _native.Gram(np.arange(50) / 50, np.zeros(50), 0)
    gram.method(0)
    gram.add(np.random.default_rng(1).uniform(-0.0199, 0.0199, 100_000), np.empty((0, 100_000)))
    assert gram.events == 0


def test_events_do_not_depend_on_the_number_of_operators_when_they_are_few():
    x = long_signal("smooth")
    for n in (10, 1000):
        gram = _native.Gram(np.arange(n) / n, np.zeros(n), 0)
        gram.add(x, np.empty((0, LONG)))
        assert gram.prefix == 0
        assert gram.events <= 2 * n * (2 * LONG // 40_000 + 1)


@pytest.mark.parametrize("method", [0, 8])
def test_nearly_equal_thresholds_keep_the_sums_of_plays(method):
    rng = np.random.default_rng(2)
    r = np.sort(np.r_[0, rng.uniform(0.1, 1, 9), rng.uniform(0.1, 1, 9)])
    r = np.unique(np.r_[r, np.nextafter(r[1:], 2), r[1:] * (1 + 1e-13)])
    for x in (rng.uniform(-1, 1, 3000), np.sin(np.arange(3000) / 50)):
        exact, _ = written_out(x, x[None] ** 2, r, np.zeros(len(r)))
        found = sums_of(x, x[None] ** 2, r, np.zeros(len(r)), method)
        a, b = in_plays(found, len(r)), in_plays(exact, len(r))
        assert np.abs(a - b).max() < 2e-14 * np.abs(b).max()


@pytest.mark.parametrize("scale", [1e-9, 1e6])
@pytest.mark.parametrize("method", [0, 8])
def test_the_last_cell_may_be_far_larger_than_the_others(scale, method):
    rng = np.random.default_rng(3)
    r, x = np.arange(20) * scale, rng.uniform(-1, 1, 2000) * 1e4 * scale
    exact, _ = written_out(x, x[None], r, np.zeros(20))
    found = sums_of(x, x[None], r, np.zeros(20), method)
    length = np.sqrt(np.diag(exact))
    assert np.abs((found - exact) / np.outer(length, length)).max() < 1e-12


def test_the_signal_chooses_how_many_operators_are_taken_one_by_one():
    r, none = np.arange(200) / 200, np.empty((0, LONG))
    smooth, noisy = long_signal("smooth"), long_signal("noisy")
    gram = _native.Gram(r, np.zeros(200), 0)
    chosen = []
    for x in (smooth, noisy, smooth):
        for _ in range(2):
            gram.add(x, none)
        chosen.append(gram.prefix)
    assert chosen[0] == 0 < chosen[1]
    assert chosen[2] == 0
    plain = _native.Gram(r, np.zeros(200), 0)
    plain.method(0)
    for x in (smooth, smooth, noisy, noisy, smooth, smooth):
        plain.add(x, none)
    a, b = gram.take(), plain.take()
    assert np.abs(a - b).max() < 4e-15 * np.abs(b).max()


def test_threads_with_sums_of_their_own_do_not_meet():
    data = [case([11, seed], 30, 20_000) for seed in range(4)]
    alone = [sums_of(*one, 0) for one in data]
    with ThreadPoolExecutor(4) as pool:
        together = list(pool.map(lambda one: sums_of(*one, 0), data * 5))
    for k, found in enumerate(together):
        assert np.array_equal(found, alone[k % 4])


@pytest.fixture
def use_level():
    before = _native.engine_level()
    yield _native.engine_use_level
    _native.engine_use_level(before)


@pytest.mark.parametrize("level", [0, 1, 2], ids=["portable", "avx2", "avx512"])
def test_every_instruction_set_gives_the_same_sums(level, use_level):
    if level > _native.engine_best_level():
        pytest.skip("this processor has no such instructions")
    use_level(level)
    for seed in range(30):
        x, targets, r, z = case([12, seed], 1 + seed, 1500)
        exact, _ = written_out(x, targets, r, z)
        for method in (0, 8, _native.ENGINE_DENSE):
            assert error(sums_of(x, targets, r, z, method), exact, 1 + seed) < 4e-14


def program(folder, compiler, levels, *options):
    return compiled(tool(compiler), folder, levels, *options, driver="engine_gram.c")


@pytest.mark.exhaustive
def test_no_sum_reads_or_writes_beyond_its_arrays(tmp_path):
    best = list(FLAGS)[_native.engine_best_level()]
    driver = program(
        tmp_path, "gcc", sorted({"portable", best}), "-O0", "-fsanitize=address,undefined"
    )
    for level in {0, _native.engine_best_level()}:
        done = run(driver, level, 1, 1000)
        assert done.returncode == 0, done.stdout + done.stderr


def test_sums_are_right_on_another_architecture(tmp_path):
    machine = tool("qemu-aarch64", "qemu-aarch64-static")
    driver = program(tmp_path, "aarch64-linux-gnu-gcc", ["portable"], "-O1", "-static")
    done = run(machine, driver, 0, 2, 800)
    assert done.returncode == 0, done.stdout + done.stderr
