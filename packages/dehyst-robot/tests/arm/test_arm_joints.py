"""Parameters of a pneumatic joint: the published maps, tolerances drawn by the seed, SI."""

import math

import numpy as np
import pytest

from dehyst.errors import ParameterError
from dehyst_robot.arm import _mechanisms as mechanisms
from dehyst_robot.arm import load_robot, pneumatic_joint_parameters
from dehyst_robot.arm._joints import FORCES, FORMS, map_coefficients, muscle_scatter

ROBOT = load_robot(conditions="kind")
EXACT = ROBOT.with_changes({"tolerance": {"force": 0.0, "hysteresis": 0.0}})

# Table F of the literature, [N]: contraction 0, 5, 10, 15, 20 %
TOOL = {
    1: (1032, 265, -24, -283, -500),
    3: (3096, 2169, 1469, 713, 65),
    6: (6192, 5024, 3709, 2207, 913),
}
BENCH = {
    1: (773, 292, 89, -71, -224),
    3: (2673, 1854, 1342, 878, 420),
    6: (5523, 4197, 3221, 2300, 1386),
}


def force(form, c, p, k):
    """The formulas of packages/dehyst-robot/plant/plant.h."""
    if form == "tool":
        return c[0] * (
            c[1] * (math.exp(-c[2] * k / c[4]) - 1) + p / c[5] * math.exp(-c[3] * (k / c[4]) ** 2)
        )
    if form == "exponential":
        return (c[0] * p + c[1]) * math.exp(c[2] * k) + c[3] * k * p + c[4] * p + c[5]
    return (
        c[0] * c[1] * p * (c[2] * (1 - c[4] * k) ** 2 - c[3])
        + c[5] * k
        + c[6] * (1 - math.exp(-c[7] * k))
    )


@pytest.mark.parametrize(("name", "table"), [("tool", TOOL), ("bench", BENCH)])
def test_the_maps_give_the_published_forces(name, table):
    law = ROBOT.maps[name]
    c = map_coefficients(law, 0.4)
    for bar, row in table.items():
        found = [force(law.form, c, bar * 1e5, k) for k in (0.0, 0.05, 0.10, 0.15, 0.20)]
        np.testing.assert_allclose(found, row, atol=0.6)


def test_the_geometric_map_is_within_100_newton_rms_of_the_makers_tool_where_that_pulls():
    tool, own = (map_coefficients(ROBOT.maps[name], 0.4) for name in ("tool", "tondu-lopez"))
    pairs = [
        (force("tool", tool, p, k), force("geometric", own, p, k))
        for p in np.linspace(0.5e5, 6e5, 12)
        for k in np.linspace(0, 0.25, 26)
    ]
    pulling = np.array([(a, b) for a, b in pairs if a > 0])
    assert np.sqrt(np.mean((pulling[:, 0] - pulling[:, 1]) ** 2)) < 100.0


def test_the_20_mm_map_has_the_makers_largest_force_at_each_length():
    for length in (0.1, 0.25, 0.6):
        expected = 620 * 1.4877 * math.atan(0.0248 * (length - 0.0075) * 620)
        assert map_coefficients(ROBOT.maps["tool20"], length)[0] == pytest.approx(expected)
    assert map_coefficients(ROBOT.maps["tool20"], 0.25)[0] == pytest.approx(1207.0, abs=0.5)


@pytest.mark.parametrize("name", ["tool", "tool20", "bench", "tondu-lopez"])
def test_a_muscle_that_is_3_percent_stronger_is_so_at_every_pressure_and_contraction(name):
    law = ROBOT.maps[name]
    one, more = map_coefficients(law, 0.3), map_coefficients(law, 0.3, 1.03)
    for p in (0.0, 1e5, 5e5):
        for k in (0.0, 0.07, 0.2):
            assert force(law.form, more, p, k) == pytest.approx(
                1.03 * force(law.form, one, p, k), rel=1e-12
            )


def test_same_seed_same_muscles_other_seed_other_muscles():
    first = pneumatic_joint_parameters(ROBOT, 1, 5)
    assert first == pneumatic_joint_parameters(ROBOT, 1, 5)
    assert first["muscle"] != pneumatic_joint_parameters(ROBOT, 1, 6)["muscle"]
    assert first["muscle"] != pneumatic_joint_parameters(ROBOT, 2, 5)["muscle"]
    assert first["muscle"][0] != first["muscle"][1]


def test_tolerances_scatter_by_their_rms_and_have_ends():
    drawn = np.array([muscle_scatter(ROBOT, 1, seed) for seed in range(600)]) - 1
    rms = np.sqrt(np.mean(drawn**2, axis=(0, 1)))
    np.testing.assert_allclose(rms, [ROBOT.tolerance.force, ROBOT.tolerance.hysteresis], rtol=0.12)
    assert np.abs(drawn.mean(axis=(0, 1))).max() < 0.005
    assert np.abs(drawn[..., 1]).max() <= 2.5 * ROBOT.tolerance.hysteresis + 1e-12


def test_without_tolerances_both_muscles_are_those_of_the_file():
    joint = pneumatic_joint_parameters(EXACT, 4, 1)
    one, two = joint["muscle"]
    assert one == two
    assert one["hysteresis"]["size"] == 80.0
    assert one["coefficient"][0] == 6398.4
    assert (joint["arm"], joint["contraction"], joint["substeps"]) == ([[0.05], [-0.05]], 0.11, 4)
    assert joint["sensors"]["angle_step"] == 2 * math.pi / 131072
    assert joint["air"]["supply"] == pytest.approx(8.013e5)
    assert one["map"] == FORMS["tool"] == 0


@pytest.mark.parametrize("name", mechanisms.BUILDERS)
def test_mechanism_scale_and_shape_are_those_of_the_file(name):
    changes = {"hysteresis.mechanism": name, "hysteresis.scale": 1.5, "hysteresis.asymmetry": 0.2}
    made = pneumatic_joint_parameters(EXACT.with_changes(changes), 1, 0)["muscle"][0]["hysteresis"]
    kind = 1 + list(mechanisms.BUILDERS).index(name)  # their order in plant.h
    assert (made["kind"], made["size"], made["asymmetry"]) == (kind, 120.0, 0.2)
    assert (made["pressure_share"], made["reference_pressure"]) == (0.7, pytest.approx(3e5))


@pytest.mark.parametrize("changes", [{"hysteresis.mechanism": "none"}, {"hysteresis.scale": 0.0}])
def test_hysteresis_can_be_switched_off(changes):
    made = pneumatic_joint_parameters(ROBOT.with_changes(changes), 1, 0)["muscle"][0]["hysteresis"]
    assert made["kind"] == mechanisms.NONE


def test_creep_scales_and_switches_off():
    half = pneumatic_joint_parameters(EXACT.with_changes({"hysteresis.creep": 0.5}), 1, 0)[
        "muscle"
    ][0]
    assert (half["creep_branches"], half["creep_force"][0]) == (6, 50.0)
    assert half["creep_pressure"][0] == pytest.approx(0.5 * 3.5e-5)
    off = pneumatic_joint_parameters(EXACT.with_changes({"hysteresis.creep": 0.0}), 1, 0)["muscle"][
        0
    ]
    assert (off["creep_branches"], off["creep_time"]) == (0, [])


def test_an_electric_joint_has_no_muscles():
    with pytest.raises(ParameterError, match=r"joint 3 is electric.*\(1, 2, 4, 6, 7\)"):
        pneumatic_joint_parameters(ROBOT, 3, 0)


def test_at_rest_no_muscle_goes_slack_within_nine_tenths_of_the_range():
    for number in EXACT.pneumatic:
        joint, muscle = EXACT.joint(number), EXACT.muscle(EXACT.joint(number).drive)
        c = map_coefficients(EXACT.maps[muscle.map], muscle.length)
        stroke = joint.radius * 0.9 * joint.range / muscle.length
        p1 = np.linspace(0.0, 6e5, 6001)
        one = np.array([force("tool", c, p, joint.contraction + stroke) for p in p1])
        two = np.array([force("tool", c, 6e5 - p, joint.contraction - stroke) for p in p1])
        balance = np.argmin(np.abs(one - two))
        assert one[balance] > 50.0


def test_every_form_says_what_its_force_is_proportional_to():
    assert set(FORCES) == set(FORMS)
