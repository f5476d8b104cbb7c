"""Each muscle model gives a published number, or has the exact property that its source derives; sources beside."""

import math
from dataclasses import fields, replace

import numpy as np
import pytest

from dehyst.errors import ParameterError
from dehyst_robot.muscles import joint_characteristic, muscle, muscle_class, muscle_names
from dehyst_robot.muscles import kit as muscles_kit
from dehyst_robot.muscles._braided import NEUTRAL
from dehyst_robot.muscles._elements import VoMinh, slips

KAPPA = np.array([0.0, 0.02, 0.05, 0.10, 0.15, 0.20, 0.25])
BAR = 1e5


def slope(function, x, h=1e-5):
    """Derivative by central differences of fourth order."""
    return (
        8 * (function(x + h) - function(x - h)) - (function(x + 2 * h) - function(x - 2 * h))
    ) / (12 * h)


def moved(model, start, speed, pressure, period=1e-4):
    """Force in a motion at a constant speed of shortening, from a contraction on, and its last contraction."""
    time = period * np.arange(4)
    path = start + speed * time / model.length
    return model.simulate(path, pressure, time)[-1], path[-1]


# ---- Maps


def test_makers_map_gives_the_table_of_the_tool():
    # Bolen's fit of the maker's tool, DMSP-40; rows 1, 3, 6 bar
    table = [
        [1032, 575, 265, -24, -283, -500, -646],
        [3096, 2612, 2169, 1469, 713, 65, -374],
        [6192, 5668, 5024, 3709, 2207, 913, 36],
    ]
    force = muscle("maker").static_force(KAPPA, np.array([[1.0], [3.0], [6.0]]) * BAR)
    np.testing.assert_allclose(force, table, atol=0.51)


def test_makers_map_of_thinner_muscles_grows_with_their_length():
    # the same fit: Fm = 620 * 1.4877 atan(0.0248 (l0 - 0.0075) 620), 10 mm likewise
    for length in (0.1, 0.25, 1.0):
        expected = 620 * 1.4877 * math.atan(0.0248 * (length - 0.0075) * 620)
        assert muscle("maker", "DMSP-20", length=length).static_force(0.0, 620e3) == pytest.approx(
            expected
        )
    expected = 620 * 0.4895 * math.atan(0.03068 * (0.25 - 0.0075) * 620)
    assert muscle("maker", "DMSP-10").largest_force == pytest.approx(expected)


def test_free_contractions_of_both_maps_are_those_of_the_table():
    from scipy.optimize import brentq

    for name, expected in (
        ("maker", [9.5, 17.3, 20.6, 22.7, 24.1, 25.3]),
        ("sarosi", [12.7, 21.6, 24.6, 26.1, 27.0, 27.6]),
    ):
        model = muscle(name)
        found = [
            brentq(lambda k, p=p, model=model: float(model.static_force(k, p * BAR)), 0.0, 0.35)
            for p in range(1, 7)
        ]
        np.testing.assert_allclose(100 * np.array(found), expected, atol=0.051)


def test_bench_map_gives_its_table():
    # droll23/Semester_project, DMSP-40 of 1 m
    table = [[773, 507, 292, 89, -71, -224, -376], [5523, 4900, 4197, 3221, 2300, 1386, 474]]
    force = muscle("sarosi").static_force(KAPPA, np.array([[1.0], [6.0]]) * BAR)
    np.testing.assert_allclose(force, table, atol=0.51)
    smaller = muscle("sarosi", "DMSP-40-installed").static_force(KAPPA, 3 * BAR)
    np.testing.assert_allclose(
        1.612 * smaller, muscle("sarosi").static_force(KAPPA, 3 * BAR), rtol=1e-12
    )


@pytest.mark.parametrize(
    ("which", "numbers"),
    [
        (
            "DMSP-20-200N",
            (-4.00180705, 292.4620246, -0.32930845, -9.33564098, 294.0538256, -280.498151),
        ),
        ("DMSP-20-400N", (-4.35573, 281.22370, -0.32866, -9.27035, 302.20107, -263.69185)),
        ("DMSP-10", (-9.2194029, 203.7012413, -0.34221042, -3.2255991, 109.2038216, -208.372034)),
    ],
)
def test_sarosis_sets_are_those_for_bar_and_per_cent(which, numbers):
    a, b, c, d, e, f = numbers  # ModelComparison2.m: F = (a p + b) exp(c k) + d p k + e p + f
    p, k = np.array([[1.0], [4.0]]), np.array([0.0, 1.0, 7.0, 20.0])
    expected = (a * p + b) * np.exp(c * k) + d * p * k + e * p + f
    np.testing.assert_allclose(
        muscle("sarosi", which).static_force(k / 100, p * BAR), expected, rtol=1e-12
    )


@pytest.mark.parametrize(
    ("which", "name", "rms"),
    [
        ("DMSP-40-maker", "maker", 25.0),
        ("DMSP-40-bench", "sarosi", 8.5),
        ("DMSP-40-hildebrandt", "maker", 49.0),
    ],
)
def test_polynomials_are_as_close_to_the_maps_as_they_say(which, name, rms):
    k, p = np.linspace(0, 0.25, 51), np.linspace(0.5, 6, 23)[:, None] * BAR
    error = muscle("aschemann-schindele", which).static_force(k, p) - muscle(name).static_force(
        k, p
    )
    assert 0.8 * rms < np.sqrt(np.mean(error**2)) < rms


@pytest.mark.parametrize(
    ("name", "rms", "pulling"), [("vo-minh", 34.0, False), ("kerscher", 181.0, True)]
)
def test_sets_fitted_to_the_makers_map_are_as_close_as_they_say(name, rms, pulling):
    k, p = np.meshgrid(np.linspace(0, 0.25, 51), np.linspace(0.5, 6, 23) * BAR)
    model, force = muscle(name, "DMSP-40"), muscle("maker").static_force(k, p)
    kept = force > 0 if pulling else np.ones(force.shape, bool)
    error = (model.static_force(k, p) - force)[kept]
    assert 0.9 * rms < np.sqrt(np.mean(error**2)) < rms


@pytest.mark.parametrize("name", ["chou-hannaford", "tondu-lopez", "davis-caldwell", "vo-minh"])
def test_muscles_of_40_mm_have_the_friction_of_the_simulated_arms(name):
    # 80 N at 3 bar, 1.3 % of the largest force: an assumption, the same for all
    model = muscle(name, "DMSP-40")
    friction = model.static_force(0.11, 3e5) - model.simulate([0.05, 0.11], 3e5)[-1]
    assert friction == pytest.approx(80.0, rel=0.03)


def test_a_measured_muscle_is_affine_in_the_pressure():
    # Martens, Boblan 2017, DMSP-20 of 300 mm: within 0.4 % of the largest force at every length
    worst = 0.0
    for column in muscles_kit.MEASURED_FORCE.T[:5]:
        pulls = column > 0
        line = np.polyfit(muscles_kit.MEASURED_PRESSURE[pulls], column[pulls], 1)
        worst = max(
            worst,
            np.abs(np.polyval(line, muscles_kit.MEASURED_PRESSURE[pulls]) - column[pulls]).max(),
        )
    assert worst < 0.004 * muscles_kit.MEASURED_FORCE.max()


@pytest.mark.parametrize(
    ("name", "which", "rms"),
    [
        ("boblan-martens", "DMSP-20-300", 16.0),
        ("sarosi", "DMSP-20-map", 7.5),
        ("vo-minh", "DMSP-20", 5.7),
        ("kerscher", "DMSP-20", 79.0),
    ],
)
def test_models_of_the_measured_muscle_are_as_close_to_it_as_they_say(name, which, rms):
    model = muscle(name, which)
    force = model.static_force(
        1 - muscles_kit.MEASURED_LENGTH / model.length, muscles_kit.MEASURED_PRESSURE[:, None]
    )
    error = (force - muscles_kit.MEASURED_FORCE)[muscles_kit.MEASURED_FORCE > 0]
    assert 0.9 * rms < np.sqrt(np.mean(error**2)) < rms


def test_the_physical_model_gives_the_forces_measured_at_600_kpa():
    # 1460, 1004, 715, 444 and 188 N at 296 to 237 mm; within 2 % of the largest
    model = muscle("boblan-martens", "DMSP-20-300")
    force = model.static_force(1 - muscles_kit.MEASURED_LENGTH[:5] / 0.3, 6e5)
    np.testing.assert_allclose(force, [1460.1, 1004.0, 714.8, 443.5, 188.1], atol=0.02 * 1460)


def test_the_physical_model_has_the_coefficients_of_its_source_for_10_mm_too():
    model = muscle("boblan-martens", "DMSP-10-250")
    assert float(model.modulus(0.0)) == pytest.approx(
        74.085e6 - 689.20e6 * 0.25 + 1.837e9 * 0.25**2 - 848.79e6 * 0.25**3
    )
    assert model.static_force(0.0, 0.0) == pytest.approx(
        0.0, abs=1e-9
    )  # at rest all stresses are zero


# ---- Geometry


@pytest.mark.parametrize("angle", [15.0, 25.0, 40.0])
def test_a_braid_stops_pulling_at_54_7_degrees(angle):
    # Chou, Hannaford 1996: arccos(1/sqrt 3), whatever the pressure
    model = muscle("chou-hannaford", angle=math.radians(angle))
    at = 1 - math.cos(math.radians(54.73561031724535)) / math.cos(math.radians(angle))
    np.testing.assert_allclose(
        model.static_force(at, np.array([1.0, 4.0, 8.0]) * BAR), 0.0, atol=1e-9
    )
    assert model.largest_contraction == pytest.approx(at, abs=1e-12)
    assert model.static_force(at - 1e-3, 4e5) > 0 > model.static_force(at + 1e-3, 4e5)
    assert math.degrees(NEUTRAL) == pytest.approx(54.7, abs=0.05)


@pytest.mark.parametrize("wall", [0.0, 1e-3])
def test_the_force_of_a_braid_is_the_virtual_work_of_its_volume(wall):
    # F = -p dV/dl, V of a cylinder with fibres of length b and n turns, less a wall: an independent derivative
    l0, d0, theta, p = 0.2, 0.015, math.radians(23.0), 4e5
    b, n = l0 / math.cos(theta), l0 * math.tan(theta) / (math.pi * d0)

    def volume(length):
        diameter = math.sqrt(b**2 - length**2) / (n * math.pi)
        return math.pi * length * (diameter - 2 * wall) ** 2 / 4

    model = muscle("chou-hannaford", wall=wall)
    for k in (-0.03, 0.0, 0.1, 0.25, 0.4):
        assert model.static_force(k, p) == pytest.approx(-p * slope(volume, l0 * (1 - k)), rel=1e-7)


def test_the_volume_of_a_dmsp_40_is_the_cubic_of_its_fibre_geometry():
    # per metre, litres: 1.2566 + 7.1981 k - 12.6821 k^2 + 4.2274 k^3; 0.932 l at 25 % for 0.4 m
    braid = muscle("chou-hannaford", "DMSP-40").braid
    cubic = np.polynomial.polynomial.polyval(KAPPA, [1.2566, 7.1981, -12.6821, 4.2274])
    np.testing.assert_allclose(1e3 * braid.volume(KAPPA) / 0.4, cubic, atol=2e-4)
    assert 1e3 * braid.volume(0.25) == pytest.approx(0.932, abs=6e-4)


@pytest.mark.parametrize(
    ("name", "which"),
    [("boblan-martens", "DMSP-20-300"), ("boblan-martens", "DMSP-10-250"), ("davis-caldwell", "")],
)
def test_what_pressure_adds_to_the_force_is_the_slope_of_the_volume(name, which):
    # V = l (b^2 - l^2)/(4 pi n^2), as given in their sources
    model = muscle(name, which)
    l0, d0, theta = model.length, model.diameter, model.angle
    b, n = l0 / math.cos(theta), l0 * math.tan(theta) / (math.pi * d0)
    pull, _ = model.affine(KAPPA)
    lengths = l0 * (1 - KAPPA)
    np.testing.assert_allclose(
        pull,
        [-slope(lambda x: x * (b**2 - x**2) / (4 * math.pi * n**2), x) for x in lengths],
        rtol=1e-6,
        atol=1e-12,
    )


@pytest.mark.parametrize(("angle", "k"), [(20.0, 1.25), (25.0, 1.35)])
def test_tondu_lopez_stop_at_their_largest_contraction(angle, k):
    # eps_max = (1/k)(1 - sqrt(b/a)), a = 3/tan^2, b = 1/sin^2
    a, b = 3 / math.tan(math.radians(angle)) ** 2, 1 / math.sin(math.radians(angle)) ** 2
    at = (1 - math.sqrt(b / a)) / k
    for name in ("tondu-lopez", "tondu-zagal"):
        model = muscle(name, angle=math.radians(angle), shape=k)
        assert model.largest_contraction == pytest.approx(at, rel=1e-12)
        assert model.static_force(at, 5e5) == pytest.approx(0.0, abs=1e-9)
        assert model.static_force(0.0, 5e5) == pytest.approx(
            math.pi * model.radius**2 * 5e5 * (a - b), rel=1e-12
        )


def test_a_muscle_of_50_g_pulls_more_than_1000_n_at_5_bar():
    # Tondu, Lopez 2000, abstract; outer radius 15 mm at rest, and an inner one below it
    assert muscle("tondu-lopez").radius < 0.015
    assert muscle("tondu-lopez").static_force(0.0, 5e5) > 1000


def test_friction_of_tondu_lopez_is_in_proportion_to_pressure_and_falls_with_speed():
    model = muscle("tondu-lopez")
    low, high = (
        model.static_force(k, p) - f for p in (2e5, 4e5) for f, k in [moved(model, 0.1, 0.05, p)]
    )
    assert high == pytest.approx(2 * low, rel=1e-12)
    area = 2 * math.pi * model.radius * model.length / math.sin(model.angle)
    for speed, coefficient in ((1e-7, model.friction_static), (5.0, model.friction_kinetic)):
        path, time = np.array([0.1, 0.11, 0.12]), 0.01 * model.length / speed * np.arange(3)
        friction = model.static_force(0.12, 3e5) - model.simulate(path, 3e5, time)[-1]
        sine = math.sqrt(1 - (math.cos(model.angle) * 0.88) ** 2)
        assert friction == pytest.approx(coefficient * area * 0.88 * sine * 3e5, rel=1e-5)


def test_a_constant_shape_is_the_limit_of_the_refined_one_at_high_pressure():
    # Tondu, Lopez 2000: k(p) = a_k exp(-p) + b_k, p in bar
    fixed, refined = muscle("tondu-lopez"), muscle("tondu-lopez", shape_pressure=0.5)
    assert not refined.affine_in_pressure
    np.testing.assert_allclose(
        refined.static_force(0.1, 40e5), fixed.static_force(0.1, 40e5), rtol=1e-12
    )
    assert refined.static_force(0.1, 1e5) < fixed.static_force(0.1, 1e5)


def test_the_dmsp_40_set_of_tondu_lopez_has_the_friction_it_names():
    model = muscle("tondu-lopez", "DMSP-40")
    friction = model.static_force(0.11, 3e5) - model.simulate([0.10, 0.11], 3e5)[-1]
    assert friction == pytest.approx(80.0, rel=0.02)
    pulls = muscle("maker").static_force(KAPPA[:-1], 3e5)
    assert (
        np.sqrt(np.mean((model.static_force(KAPPA[:-1], 3e5) - pulls) ** 2)) < 250
    )  # rms of the fit over all pressures


# ---- Strands


def test_strands_lock_where_neighbours_touch():
    # perpendicular distance of N strands on a circumference pi D at theta: pi D cos(theta)/N = d at both limits
    model = muscle("davis-caldwell")
    widest = model.diameter / math.sin(model.angle)
    for k in model.limits:
        cosine = (1 - k) * math.cos(model.angle)
        diameter = widest * math.sqrt(1 - cosine**2)
        assert math.pi * diameter * cosine / model.strands == pytest.approx(model.strand, rel=1e-9)
    with pytest.raises(ParameterError, match="overlap"):
        replace(model, strands=400.0)


def test_strand_friction_is_contact_area_times_pressure_to_the_power_of_the_contact():
    # Davis, Caldwell 2006: mu A p; Hertzian contacts widen, so that it grows with p^(5/3)
    for which, power in (("nylon", 1.0), ("hertz", 5 / 3)):
        model = muscle("davis-caldwell", which)
        one, two = (
            model.static_force(0.1, p) - model.simulate([0.09, 0.1], p)[-1] for p in (3e5, 6e5)
        )
        assert two / one == pytest.approx(2.0**power, rel=1e-9)
        assert one == pytest.approx(17.0, rel=0.02)  # what the set says of itself
    crossings, width = 2 * model.braid.turns * model.strands**2, model.contact * model.strand
    theta = math.acos(0.9 * math.cos(model.angle))
    assert one == pytest.approx(
        model.friction * 3e5 * crossings * width**2 / math.sin(2 * theta), rel=1e-9
    )


# ---- Speed


@pytest.mark.parametrize("speed", [0.05, 0.3, 0.9])
def test_klutes_muscle_obeys_hills_law(speed):
    # Hill 1938, as in Klute and others 2002: (F + a)(v + b) = (F_0 + a) b with a/F_0 = 0.25; zero at b F_0/a
    model, b = muscle("klute", "muscle"), 0.25
    force, k = moved(model, 0.05, speed, 4e5)
    isometric = float(model.static_force(k, 4e5))
    a = 0.25 * isometric
    assert (force + a) * (speed + b) == pytest.approx((isometric + a) * b, rel=1e-9)
    assert moved(model, 0.05, model.largest_speed, 4e5)[0] == pytest.approx(
        0.0, abs=1e-9 * isometric
    )


@pytest.mark.parametrize("speed", [0.05, 0.3, 0.9])
def test_tondu_zagal_is_hills_law_with_a_equal_to_isometric_force_and_hills_a(speed):
    # identity: F = F_0 - a v/(b + v) with a = F_0 + a_H  <=>  (F + a_H)(v + b) = (F_0 + a_H) b
    rayon = muscle("tondu-zagal")
    _, k = moved(rayon, 0.05, speed, 4e5)
    isometric = float(rayon.static_force(k, 4e5))
    hill = 0.25 * isometric
    model = replace(rayon, drag=isometric + hill)
    force, _ = moved(model, 0.05, speed, 4e5)
    b = model.drag_speed
    assert (force + hill) * (speed + b) == pytest.approx((isometric + hill) * b, rel=1e-9)


def test_tondu_zagal_damps_at_first_and_rubs_in_the_end():
    # rayon: a/b at rest, saturating at a; iron: viscous
    rayon, iron = muscle("tondu-zagal"), muscle("tondu-zagal", "iron")
    slow, k = moved(rayon, 0.05, 1e-5, 3e5)
    assert (rayon.static_force(k, 3e5) - slow) / 1e-5 == pytest.approx(
        rayon.drag / rayon.drag_speed, rel=1e-3
    )
    fast, k = moved(rayon, 0.05, 100.0, 3e5, period=1e-5)
    assert rayon.static_force(k, 3e5) - fast == pytest.approx(rayon.drag, rel=0.003)
    force, k = moved(iron, 0.05, 0.4, 3e5)
    assert iron.static_force(k, 3e5) - force == pytest.approx(0.4 * iron.viscosity)


def test_klutes_damper_is_an_orifice_and_the_bare_actuator_hardly_depends_on_speed():
    damped, bare = muscle("klute"), muscle("klute", "bare")
    for speed in (0.1, 0.2, -0.2):
        force, k = moved(damped, 0.1, speed, 4e5)
        assert damped.static_force(k, 4e5) - force == pytest.approx(
            damped.damper * speed * abs(speed), rel=1e-6
        )
        force, k = moved(bare, 0.1, speed, 4e5)
        assert force == bare.static_force(k, 4e5)


def test_klutes_bladder_pulls_with_the_slope_of_its_energy():
    # V_b dW/dl of a Mooney-Rivlin tube that stays on the braid, by an independent derivative of the energy
    model = muscle("klute")
    volume = (
        math.pi
        * ((model.diameter / 2) ** 2 - (model.diameter / 2 - model.wall) ** 2)
        * model.length
    )

    def energy(length):
        along = length / model.length
        theta = math.acos(along * math.cos(model.angle))
        c = np.array([along, math.sin(theta) / math.sin(model.angle), 0.0]) ** 2
        c[2] = 1 / (c[0] * c[1])
        return volume * (model.c10 * (c.sum() - 3) + model.c01 * ((1 / c).sum() - 3))

    for k in (0.0, 0.1, 0.2, 0.3):
        assert model.static_force(k, 0.0) == pytest.approx(
            slope(energy, model.length * (1 - k)), rel=1e-6, abs=1e-6
        )
    assert abs(float(model.static_force(0.0, 0.0))) < 1e-9  # relaxed at rest


@pytest.mark.parametrize(
    ("pressure", "force", "stiffness", "contracting", "relaxing"),
    [(207, 466.93, 12064.9, 2440.37, 433.779), (621, 1042.39, 24774.7, 5301.11, 101.337)],
)
def test_reynolds_elements_at_both_ends_of_the_identified_range(
    pressure, force, stiffness, contracting, relaxing
):
    # Reynolds and others 2003: 179.2 + 1.39 p; 5.71 + 0.0307 p; 1.01 + 0.00691 p; 0.6 - 0.000803 p (kPa, mm)
    model, p = muscle("reynolds"), 1e3 * pressure
    assert model.static_force(0.0, p) == pytest.approx(force)
    assert (force - model.static_force(0.1, p)) / (0.1 * model.length) == pytest.approx(stiffness)
    for speed, damping in ((0.2, contracting), (-0.2, relaxing)):
        found, k = moved(model, 0.05, speed, p)
        assert (model.static_force(k, p) - found) / speed == pytest.approx(damping)


@pytest.mark.parametrize(
    ("pressure", "stiffness", "relaxing"),
    [
        (200, 32.7 - 0.0321 * 200, 1.57),
        (350, 17 + 0.0179 * 350, 1.57),
        (500, 17 + 0.0179 * 500, 0.311 + 0.00338 * 500),
    ],
)
def test_serres_elements_within_each_piece(pressure, stiffness, relaxing):
    # re-identification: F = 2.91 p + 44.6; K and B in pieces at 314 and 372 kPa; contraction 2.90 N s/mm
    model, p = muscle("reynolds", "serres"), 1e3 * pressure
    force = 2.91 * pressure + 44.6
    assert model.static_force(0.0, p) == pytest.approx(force)
    assert (force - model.static_force(0.1, p)) / (1e3 * 0.1 * model.length) == pytest.approx(
        stiffness
    )
    for speed, damping in ((0.2, 2.90), (-0.2, relaxing)):
        found, k = moved(model, 0.05, speed, p)
        assert (model.static_force(k, p) - found) / speed / 1e3 == pytest.approx(
            damping, rel=2e-3
        )  # pieces do not meet


def test_loops_of_three_elements_vanish_with_the_speed():
    model, path = muscle("reynolds"), 0.08 + 0.04 * np.sin(np.linspace(0, 2 * np.pi, 400))
    widths = []
    for duration in (1.0, 10.0, 100.0):
        friction = model.static_force(path, 4e5) - model.simulate(
            path, 4e5, np.linspace(0, duration, 400)
        )
        widths.append(np.ptp(friction))
    np.testing.assert_allclose(np.array(widths[:-1]) / widths[1:], 10.0, rtol=1e-6)
    np.testing.assert_array_equal(
        model.simulate(path, 4e5), model.static_force(path, 4e5)
    )  # infinitely slow


def test_kerschers_muscle_drops_by_its_damper_at_a_quick_release():
    # Kerscher and others 2006: affine in pressure, in proportion to speed, up to 0.9 m/s
    model = muscle("kerscher")
    for p in (1e5, 3e5, 5e5):
        for speed in (0.3, 0.9, -0.3):
            force, k = moved(model, 0.05, speed, p)
            expected = (model.damping + model.damping_pressure * p) * speed
            assert model.static_force(k, p) - force == pytest.approx(expected, rel=1e-9)
    assert 300 <= model.damping + 3e5 * model.damping_pressure <= 1000  # N s/m for 20 mm


# ---- Memory


def test_branches_of_vo_minhs_loops_are_the_first_curve_twice_as_large():
    # Masing's rule
    model = muscle("vo-minh")
    up, down = np.linspace(0.05, 0.10, 200), np.linspace(0.10, 0.05, 200)
    friction = model.static_force(np.r_[up, down], 3e5) - model.simulate(np.r_[up, down], 3e5)
    np.testing.assert_allclose(friction[:200], model.virgin(up - 0.05), atol=1e-9)
    np.testing.assert_allclose(
        friction[199] - friction[200:], 2 * model.virgin((0.10 - down) / 2), atol=1e-9
    )


def test_vo_minhs_first_curve_is_the_one_it_was_made_of():
    strains = np.geomspace(0.15, 4, 10) * 0.0125
    expected = 20.0 * -np.expm1(-strains / 0.0125) / -math.expm1(-4.0)
    np.testing.assert_allclose(muscle("vo-minh").virgin(strains), expected, rtol=1e-12)
    strain, force = slips(strains, expected)
    np.testing.assert_allclose(
        VoMinh(slip_strains=strain, slip_forces=force).virgin(strains), expected, rtol=1e-12
    )
    assert muscle("vo-minh").virgin(1.0) == pytest.approx(20.0)  # everything slips


def test_a_first_curve_that_bends_upwards_is_refused():
    with pytest.raises(ParameterError, match="bends upwards"):
        slips([0.01, 0.02], [1.0, 5.0])


def test_vo_minhs_friction_depends_on_pressure_only_if_told_so():
    # MAS-20: not; Tondu, Lopez: in proportion. Both are options
    path = [0.05, 0.15]
    for which, ratio in (("DMSP-20", 1.0), ("DMSP-20-pressure", 2.0)):
        model = muscle("vo-minh", which)
        low, high = (
            float(model.static_force(0.15, p) - model.simulate(path, p)[-1]) for p in (3e5, 6e5)
        )
        assert high / low == pytest.approx(ratio)


def test_vo_minhs_loops_close_with_return_point_memory():
    model = muscle("vo-minh")
    big = np.r_[np.linspace(0.05, 0.15, 50), np.linspace(0.15, 0.08, 40)]
    inner = np.r_[np.linspace(0.08, 0.11, 20), np.linspace(0.11, 0.08, 20)]
    force = model.simulate(np.r_[big, inner], 3e5)
    assert force[-1] == pytest.approx(force[len(big) - 1], abs=1e-9)


# ---- The joint


def test_a_joint_of_two_makers_muscles_has_the_published_characteristic():
    # kappa_0 = 0.11, l_0 = 0.40 m, r = 50 mm, +-40 degrees: A, B, C and dp_nom at 3 bar
    joint = joint_characteristic(muscle("maker"), 0.05, 0.11, reach=math.radians(40))
    np.testing.assert_allclose(np.array(joint.a) * BAR, [0, -62.09, 0, 23.13, 0, -3.78], atol=0.06)
    np.testing.assert_allclose(np.array(joint.b) * BAR, [34.88, 0, -3.88, 0, -1.26, 0], atol=0.06)
    assert joint.residual < 0.07
    difference = joint.balance(np.radians([10, 20, 30, 40]), 3 * BAR) / BAR
    np.testing.assert_allclose(difference, [0.95, 1.88, 2.79, 3.77], atol=0.006)
    h = 1e-5
    stiffness = -(joint.torque(h, 3 * BAR, 0.0) - joint.torque(-h, 3 * BAR, 0.0)) / (2 * h)
    assert stiffness == pytest.approx(190, abs=1)


@pytest.mark.parametrize(
    ("length", "radius", "start", "b"), [(0.3, 0.04, 0.11, 27.9), (0.5, 0.06, 0.11, 41.9)]
)
def test_other_joints_have_the_published_torque_for_a_pressure(length, radius, start, b):
    joint = joint_characteristic(muscle("maker", length=length), radius, start)
    assert joint.b[0] * BAR == pytest.approx(b, abs=0.05)


@pytest.mark.parametrize("name", muscle_names())
def test_fields_are_the_parameters_of_the_file_and_sets_change_only_those(name):
    model = muscle_class(name)
    parameters = [parameter.name for parameter in model.PARAMETERS]
    assert [entry.name for entry in fields(model)] == parameters
    for published_set in model.PUBLISHED:
        assert set(published_set.values) <= set(parameters) and len(published_set.source) > 5
        low, high = model.published(published_set.name).bounds()
        vector = model.published(published_set.name).vector()
        assert np.all(low <= vector) and np.all(vector <= high)
