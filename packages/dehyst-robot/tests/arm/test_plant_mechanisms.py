"""The built-in hysteresis mechanisms: they take energy only, never jump, and remember what each of them should."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dehyst.errors import ParameterError
from dehyst_robot._native import PLANT_TURNS, everett, hysteresis_force
from dehyst_robot.arm import _mechanisms as mechanisms
from plant_oracles import MaxwellSlip, Relays
from plant_oracles import everett as everett_oracle
from plant_samples import BUILT_IN

SIZE = 80.0
MIDDLE = 0.11
NAMES = pytest.mark.parametrize("name", BUILT_IN)
# Largest force over the size: of a braid where the muscle is longest, of a bristle at rest, of contacts 10 s old.
LARGEST = {"braid": 2.4, "lugre": 1.3, "ageing": 1.25}
# Least loss over that of dry friction of the full size: a pinched spring is soft once in every stroke.
LEAST_LOSS = {"pinched": 0.4}


def path(turns, step=2e-4):
    """Straight lines through the turning points."""
    legs = [np.linspace(a, b, max(2, int(abs(b - a) / step) + 1))[1:] for a, b in pairwise(turns)]
    return np.concatenate([[turns[0]], *legs])


def force(mechanism, kappa, pressure=3e5):
    kappa = np.asarray(kappa, float)
    return hysteresis_force(
        mechanism, kappa[0], kappa, np.broadcast_to(pressure, kappa.shape).astype(float)
    )


def ends(mechanism, turns, pressure=3e5):
    """Forces at the turning points."""
    kappa = path(turns)
    f = force(mechanism, kappa, pressure)
    where = np.cumsum([0] + [path([a, b]).size - 1 for a, b in pairwise(turns)])
    return f[where]


turning_points = st.lists(st.floats(-0.04, 0.26), min_size=2, max_size=9)
asymmetries = st.floats(-0.3, 0.3)


@given(
    turning_points,
    st.sampled_from(list(BUILT_IN)),
    asymmetries,
    st.floats(0, 6e5),
    st.sampled_from([2e-4, 2e-5]),
)
def test_no_closed_path_of_contraction_yields_energy(turns, name, asymmetry, pressure, step):
    kappa = path([*turns, turns[0]], step)  # at 0.2 or at 0.02 1/s
    f = force(BUILT_IN[name](SIZE, asymmetry=asymmetry), kappa, pressure)
    # The later force times the motion is not below what a spring stores: k d(f^2) / 2 <= f df.
    assert np.sum(f[1:] * np.diff(kappa)) >= -1e-10
    assert np.all(
        np.abs(f)
        <= LARGEST.get(name, 1.0)
        * SIZE
        * (0.3 + 0.7 * pressure / 3e5)
        * (1 + abs(asymmetry))
        * (1 + 1e-9)
    )


@NAMES
def test_a_loop_dissipates_most_of_what_full_friction_would(name):
    kappa = path([MIDDLE, 0.19, 0.03, 0.19, 0.03])
    f = force(BUILT_IN[name](SIZE), kappa)
    second = slice(kappa.size // 2, None)
    loss = np.sum(f[1:] * np.diff(kappa))
    travel = np.sum(np.abs(np.diff(kappa)))
    assert LEAST_LOSS.get(name, 0.5) < loss / (SIZE * travel) < 1.0
    assert np.max(f[second]) > 0.95 * SIZE


@given(turning_points, st.sampled_from(list(BUILT_IN)), asymmetries)
def test_the_force_never_jumps(turns, name, asymmetry):
    mechanism = BUILT_IN[name](SIZE, asymmetry=asymmetry)
    kappa = np.concatenate([[turns[0]], *(t + np.array([0, 1e-7, -1e-7, 2e-7]) for t in turns)])
    kappa = np.concatenate(
        [path(kappa[i : i + 2].tolist(), 1e-3)[:-1] for i in range(kappa.size - 1)]
    )
    f = force(mechanism, kappa)
    stiffest = (
        30 * SIZE / 0.0125 * (1 + abs(asymmetry)) / (1 - abs(asymmetry))
    )  # the finest of the springs
    assert np.all(np.abs(np.diff(f)) <= stiffest * np.abs(np.diff(kappa)) + 1e-10)


@given(
    st.lists(st.floats(0.0, 0.22), min_size=1, max_size=6),
    st.sampled_from(["maxwell-slip", "preisach"]),
    asymmetries,
)
def test_maxwell_slip_and_preisach_come_back_to_where_a_loop_was_opened(turns, name, asymmetry):
    mechanism = BUILT_IN[name](SIZE, asymmetry=asymmetry)
    x, y = turns[-1], 0.5 * (turns[-1] + MIDDLE) + 0.01
    f = ends(mechanism, [MIDDLE, *turns, y, x, y, x])
    np.testing.assert_allclose(f[[-1, -2]], f[[-3, -4]], rtol=0, atol=1e-9)


@pytest.mark.parametrize("name", ["maxwell-slip", "preisach"])
def test_a_closed_loop_is_wiped_out(name):
    mechanism = BUILT_IN[name](SIZE, asymmetry=0.1)
    with_loops = force(
        mechanism, path([MIDDLE, 0.16, 0.08, 0.14, 0.10, 0.13, 0.09, 0.14, 0.15, 0.05])
    )
    without = force(mechanism, path([MIDDLE, 0.16, 0.08, 0.15, 0.05]))
    np.testing.assert_allclose(with_loops[-200:], without[-200:], rtol=0, atol=1e-9)


def test_dahl_has_no_return_point_memory():
    mechanism = mechanisms.dahl(SIZE)
    f = ends(mechanism, [MIDDLE, 0.13, 0.128, 0.13])
    assert abs(f[-1] - f[1]) > 0.01 * SIZE
    # and a pulsating strain drifts towards its own middle, whatever was before
    pulsating = ends(mechanism, [MIDDLE, 0.13, *([0.128, 0.13] * 30)])
    assert abs(pulsating[-1] + pulsating[-2]) < 0.5 * abs(f[1] + f[2])


def test_branches_of_maxwell_slip_are_the_virgin_curve_twice_as_large():
    mechanism = mechanisms.maxwell_slip(SIZE)
    reach = np.linspace(0, 0.05, 300)
    virgin = force(mechanism, MIDDLE + reach)
    down = force(mechanism, np.concatenate([MIDDLE + reach, MIDDLE + 0.05 - 2 * reach]))[300:]
    np.testing.assert_allclose(virgin[-1] - down, 2 * virgin, rtol=0, atol=1e-9)


@NAMES
def test_virgin_curves_are_comparable_and_reach_the_size(name):
    x = np.linspace(0, 0.1, 800)
    f = force(BUILT_IN[name](SIZE), MIDDLE + x)
    if name != "pinched":  # which is soft at first
        assert np.max(np.abs(f / SIZE - (1 - np.exp(-x / 0.0125)))) < 0.1
    assert 0.94 < f[-1] / SIZE <= LARGEST.get(name, 1.0) + 1e-12


@pytest.mark.parametrize("name", ["maxwell-slip", "dahl"])
def test_full_slip_differs_between_the_directions_by_the_asymmetry(name):
    f = ends(BUILT_IN[name](SIZE, asymmetry=0.1), [MIDDLE, 0.4, -0.3])
    np.testing.assert_allclose(f[1:], [1.1 * SIZE, -0.9 * SIZE], rtol=1e-3)


def test_saturation_of_preisach_differs_between_the_directions_by_the_asymmetry():
    f = ends(mechanisms.preisach(SIZE, asymmetry=0.1), [MIDDLE, 0.3, -0.1])
    np.testing.assert_allclose(f[1:], [1.1 * SIZE, -0.9 * SIZE], rtol=1e-9)


@NAMES
def test_friction_grows_with_pressure_but_less_than_in_proportion(name):
    full = np.array([ends(BUILT_IN[name](SIZE), [MIDDLE, 0.5], p)[-1] for p in (0.0, 3e5, 6e5)])
    np.testing.assert_allclose(full / full[1], [0.3, 1.0, 1.7], rtol=2e-3)


@given(st.lists(st.floats(0, 6e5), min_size=2, max_size=20))
def test_at_rest_pressure_only_ever_loosens_maxwell_slip(pressures):
    kappa = np.concatenate([np.linspace(MIDDLE, 0.15, 100), np.full(len(pressures), 0.15)])
    p = np.concatenate([np.full(100, 6e5), pressures])
    f = force(mechanisms.maxwell_slip(SIZE), kappa, p)[99:]
    assert np.all(np.diff(f) <= 1e-12)
    assert np.all(f >= 0)


# ---- What kind of memory


def minor_loop(mechanism, centre, half, history=()):
    """Second loop between centre - half and centre + half: forces over the start of the loop."""
    return loop_between(mechanism, [MIDDLE, *history], centre - half, centre + half)


def loop_between(mechanism, history, low, high):
    line = np.linspace(low, high, 60)
    kappa = np.concatenate([path([*history, low, high, low]), line, line[::-1]])
    f = force(mechanism, kappa)[-120:]
    return f - f[0]


PLACES = (0.04, 0.11, 0.18)


def test_loops_of_one_width_are_congruent_wherever_they_lie_in_prandtl_ishlinskii():
    loops = [minor_loop(mechanisms.maxwell_slip(SIZE), c, 0.006) for c in PLACES]
    np.testing.assert_allclose(loops[0], loops[1], rtol=0, atol=1e-9)
    np.testing.assert_allclose(loops[2], loops[1], rtol=0, atol=1e-9)


def test_loops_of_one_width_are_not_congruent_in_preisach():
    loops = [minor_loop(mechanisms.preisach(SIZE), c, 0.006) for c in PLACES]
    height = np.ptp(loops[1])
    for outer in (0, 2):
        assert np.max(np.abs(loops[outer] - loops[1])) > 0.05 * height
    # ... and their shapes differ, not their heights alone: no amplitude map repairs it
    scaled = loops[0] * height / np.ptp(loops[0])
    assert np.max(np.abs(scaled - loops[1])) > 0.005 * height


def test_loops_between_the_same_ends_are_congruent_in_preisach_whatever_was_before():
    mechanism = mechanisms.preisach(SIZE)
    first = loop_between(mechanism, [MIDDLE], 0.12, 0.14)
    for history in ([MIDDLE, 0.25], [MIDDLE, 0.25, 0.02], [MIDDLE, 0.2, 0.05, 0.18, 0.07]):
        np.testing.assert_allclose(
            loop_between(mechanism, history, 0.12, 0.14), first, rtol=0, atol=1e-9
        )


def test_loops_between_the_same_ends_are_not_congruent_in_dahl():
    mechanism = mechanisms.dahl(SIZE)
    first = loop_between(mechanism, [MIDDLE, 0.05], 0.128, 0.13)
    assert np.max(
        np.abs(loop_between(mechanism, [MIDDLE, 0.25], 0.128, 0.13) - first)
    ) > 0.02 * np.ptp(first)


def test_the_density_of_preisach_is_positive_and_not_separable():
    a, b = np.meshgrid(np.linspace(-0.8, 0.1, 60), np.linspace(0.15, 0.8, 60), indexing="ij")
    h = 1e-4

    def density(a, b):
        e = [
            everett((a + i * h).ravel(), (b + j * h).ravel()).reshape(a.shape)
            for i in (0, 1)
            for j in (0, 1)
        ]
        return (e[3] - e[2] - e[1] + e[0]) / h**2

    nu = density(a, b)
    assert np.all(nu > 0)
    # nu = f(a) g(b) would make the cross ratio of any four points 1.
    cross = nu[0, 0] * nu[-1, -1] / (nu[0, -1] * nu[-1, 0])
    assert not 0.5 < cross < 2


def test_no_change_of_coordinate_makes_preisach_prandtl_ishlinskii():
    # If E(a, b) = phi(G(b) - G(a)), points of equal E to their neighbours have equal E to the next but one.
    def after(x, e):
        low, high = x, 1.0
        for _ in range(60):
            middle = (low + high) / 2
            low, high = (
                (middle, high)
                if everett(np.array([x]), np.array([middle]))[0] < e
                else (low, middle)
            )
        return low

    chain = [-0.6]
    while chain[-1] < 0.5:
        chain.append(after(chain[-1], 0.6))
    chain = np.array(chain)
    doubled = everett(chain[:-2], chain[2:])
    assert doubled.max() > 1.015 * doubled.min()


def test_the_everett_function_is_symmetric_and_spans_the_whole_output():
    a, b = np.random.default_rng(0).uniform(-1, 1, (2, 500))
    np.testing.assert_allclose(everett(a, b), everett_oracle(a, b), rtol=0, atol=1e-14)
    np.testing.assert_allclose(everett(a, b), everett(b, a), rtol=0, atol=1e-15)
    np.testing.assert_allclose(everett(a, b), everett(-b, -a), rtol=0, atol=1e-14)
    ends = everett(np.array([-1.0, -5.0, 0.3]), np.array([1.0, 7.0, 0.3]))
    np.testing.assert_allclose(ends, [2, 2, 0], rtol=0, atol=1e-14)


@given(st.lists(st.integers(0, 80), min_size=1, max_size=12))
def test_preisach_is_the_plane_of_relays_that_its_density_weighs(points):
    relays = Relays(80)
    mechanism = mechanisms.preisach(1.0, pressure_share=0.0)
    half = mechanism["strain"][-1]
    turns = np.concatenate([[40], points])
    legs = [np.arange(a, b, np.sign(b - a)) for a, b in pairwise(turns) if a != b]
    steps = np.concatenate([*legs, turns[-1:]])
    expected = [relays.to(k) for k in steps]
    found = force(mechanism, MIDDLE + half * relays.x[np.concatenate([[40], steps])])[1:]
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9)


def test_maxwell_slip_is_its_definition_under_changing_pressure():
    rng = np.random.default_rng(3)
    mechanism = mechanisms.maxwell_slip(SIZE, asymmetry=0.15)
    kappa = MIDDLE + 0.05 * np.cumsum(rng.normal(size=3000)) / 30
    p = 3e5 + 2e5 * np.sin(np.arange(3000) / 50)
    oracle = MaxwellSlip(mechanism)
    oracle.reset(kappa[0])
    expected = [oracle.force(k, pressure, 1e-3) for k, pressure in zip(kappa, p, strict=True)]
    np.testing.assert_allclose(force(mechanism, kappa, p), expected, rtol=0, atol=1e-11)


def test_dahl_is_exact_whatever_the_step():
    mechanism = mechanisms.dahl(SIZE, asymmetry=0.1)
    coarse = ends(mechanism, [MIDDLE, 0.15, 0.08, 0.12])
    jumps = force(mechanism, [MIDDLE, 0.15, 0.08, 0.12])
    np.testing.assert_allclose(coarse, jumps, rtol=0, atol=1e-10)
    # df/dkappa = k (1 - f/W), element by element
    f = np.zeros(3)
    share, strain = np.array(mechanism["share"]), np.array(mechanism["strain"])
    for target in (0.15, 0.08):
        start = MIDDLE if target == 0.15 else 0.15
        slip = SIZE * share * (1.1 if target > start else -0.9)
        for _ in range(20000):
            f = f + (target - start) / 20000 * SIZE * share / strain * (1 - f / slip)
    np.testing.assert_allclose(f.sum(), jumps[2], rtol=0, atol=2e-3 * SIZE)


def test_more_nested_loops_than_fit_neither_jump_nor_give_energy():
    shrinking = 0.06 * 0.985 ** np.arange(3 * PLANT_TURNS)
    turns = MIDDLE + shrinking * (-1.0) ** np.arange(shrinking.size)
    kappa = path([MIDDLE, *turns, *turns[-2::-1], MIDDLE], 1e-4)
    f = force(mechanisms.preisach(SIZE), kappa)
    assert np.all(np.abs(np.diff(f)) <= 40 * SIZE / 0.0125 * np.abs(np.diff(kappa)) + 1e-10)
    work = np.cumsum(f[1:] * np.diff(kappa))
    assert work[-1] > 0
    full = ends(mechanisms.preisach(SIZE), [MIDDLE, 0.27])
    assert abs(force(mechanisms.preisach(SIZE), np.append(kappa, 0.27))[-1] - full[-1]) < 1e-9


@pytest.mark.parametrize(
    "wrong",
    [
        lambda: mechanisms.maxwell_slip(-1.0),
        lambda: mechanisms.maxwell_slip(80.0, elements=65),
        lambda: mechanisms.maxwell_slip(80.0, strain=(4e-2, 2e-4)),
        lambda: mechanisms.dahl(80.0, spread=0.5),
        lambda: mechanisms.preisach(80.0, strain_scale=float("nan")),
        lambda: mechanisms.maxwell_slip(80.0, asymmetry=0.7),
        lambda: mechanisms.maxwell_slip(80.0, pressure_share=-0.1),
        lambda: mechanisms.dahl(80.0, reference_pressure=0.0),
    ],
)
def test_a_wrong_setting_of_a_builder_is_refused(wrong):
    with pytest.raises(ParameterError):
        wrong()


# ---- What no compensator of this repository contains


def at_speed(mechanism, speed, turns):
    """Forces at the turning points when every sample is 1 ms."""
    kappa = path(turns, 1e-3 * speed)
    f = force(mechanism, kappa)
    where = np.cumsum([0] + [path([a, b], 1e-3 * speed).size - 1 for a, b in pairwise(turns)])
    return f[where]


def test_slip_of_a_braid_follows_the_area_on_which_its_strands_touch():
    mechanism = mechanisms.braid(SIZE)

    def contact(kappa):
        return 1 / np.sin(2 * np.arccos((1 - kappa) * 0.9135))

    for place in (0.0, 0.04, 0.11, 0.2):
        full = ends(mechanism, [place - 0.08, place])[-1] if place > 0.03 else None
        back = ends(mechanism, [place + 0.08, place])[-1]
        expected = SIZE * contact(place) / contact(MIDDLE)
        np.testing.assert_allclose(back, -expected, rtol=1e-9)
        if full is not None:
            np.testing.assert_allclose(full, expected, rtol=1e-9)


def test_loops_of_one_width_are_wider_in_a_long_braid():
    long, short = (np.ptp(minor_loop(mechanisms.braid(SIZE), c, 0.03)) for c in (0.0, 0.2))
    assert long > 1.1 * short


def test_lugre_slides_with_the_force_of_its_stribeck_curve():
    for speed in (0.002, 0.02, 0.2):
        sliding = at_speed(mechanisms.lugre(SIZE), speed, [MIDDLE, 0.3])[-1]
        curve = 1 + 0.3 * np.exp(-((speed / 0.02) ** 2))
        np.testing.assert_allclose(sliding, SIZE * curve, rtol=1e-4)


def test_a_pinched_spring_is_soft_once_in_a_stroke_just_past_the_zero_of_its_force():
    kappa = path([MIDDLE, 0.19, 0.03, 0.19], 1e-4)
    f = force(mechanisms.pinched(SIZE), kappa)
    stroke = path([0.03, 0.19], 1e-4).size
    load, slope = f[-stroke:-1] / SIZE, np.diff(f[-stroke:])

    def at(low, high):
        return slope[(load > low) & (load < high)].mean()

    assert at(0.05, 0.15) < 0.5 * at(0.5, 0.6) < 0.5 * at(-0.9, -0.7)


def test_pinched_springs_neither_jump_nor_grow_where_pressure_takes_their_slip_force_away():
    mechanism = mechanisms.pinched(SIZE, pressure_share=1.0)
    kappa = np.concatenate([np.linspace(MIDDLE, 0.2, 500), [0.2 + 1e-5, 0.2 - 1e-5, 0.2 + 1e-3]])
    p = np.concatenate([np.full(500, 3e5), [10.0, 10.0, 10.0]])
    loaded, *later = force(mechanism, kappa, p)[499:]
    assert all(abs(value) <= loaded for value in later)


def test_pinched_is_its_equation_whatever_the_step():
    mechanism = mechanisms.pinched(SIZE, asymmetry=0.1)
    fine = force(mechanism, path([MIDDLE, 0.15, 0.08, 0.12], 1e-5))[-1]
    jumps = force(mechanism, [MIDDLE, 0.15, 0.08, 0.12])[-1]
    np.testing.assert_allclose(jumps, fine, rtol=0, atol=1e-4 * SIZE)
    # df/dkappa = k h(u) (1 - max(u, 0)), by the method of Euler
    f, kappa = 0.0, MIDDLE
    for target in (0.15, 0.08):
        change = (target - kappa) / 40000
        slip = 1.1 * SIZE if change > 0 else 0.9 * SIZE
        for _ in range(40000):
            u = np.sign(change) * f / slip
            h = 1 - 0.8 * np.exp(-(((u - 0.1) / 0.3) ** 2))
            f += SIZE / 0.0125 * h * (1 - max(u, 0.0)) * change
        kappa = target
    np.testing.assert_allclose(
        f, force(mechanism, [MIDDLE, 0.15, 0.08])[-1], rtol=0, atol=2e-3 * SIZE
    )


def test_after_a_rest_the_contacts_of_ageing_hold_more_by_its_logarithm():
    mechanism = mechanisms.ageing(SIZE)

    def peak(rest):
        """Largest force of a stroke that follows `rest` seconds at its start."""
        kappa = np.concatenate(
            [path([MIDDLE, 0.2, 0.1]), np.full(int(1e3 * rest), 0.1), path([0.1, 0.2])]
        )
        return np.max(force(mechanism, kappa)[-500:]) / SIZE

    short, long = peak(1.0), peak(10.0)
    assert long > short > peak(0.0)
    # The stroke itself wears a part of it away before everything slips.
    assert 0.2 < (long - short) / (0.05 * np.log(101 / 11)) <= 1.0
