"""Test paths of ISO 9283: where the figures lie, how long they are, that they are smooth."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dehyst.errors import ParameterError
from dehyst_robot.iso9283 import TestCube, TestPath, circle, line, rectangle, test_path
from dehyst_robot.iso9283._curves import Blend, Circle
from dehyst_robot.iso9283._paths import PLANES

L, CENTER = 0.4, np.array([0.6, 0.1, 0.9])
CUBE = TestCube(L, CENTER)
PATH = test_path(CUBE, 0.03)
EDGES = st.floats(0.05, 2.0)
CENTERS = st.tuples(*3 * [st.floats(-2.0, 2.0)])


def walk(path, n=4001):
    return path.position(np.linspace(0.0, path.length, n))


def measured_length(points):
    return np.linalg.norm(np.diff(points, axis=0), axis=1).sum()


@pytest.mark.parametrize("plane", PLANES)
@given(edge=EDGES, center=CENTERS)
def test_the_whole_path_lies_in_the_test_plane_and_inside_the_cube(plane, edge, center):
    cube = TestCube(edge, center, plane)
    points = walk(test_path(cube, 0.1 * edge), 801) - cube.origin
    a, b, c, d = (cube.corner(n) for n in PLANES[plane])
    normal = np.cross(b - a, d - a)  # of three corners of the plane
    assert np.abs(points @ normal / np.linalg.norm(normal)).max() < 1e-12
    assert abs((c - a) @ normal) < 1e-12  # and the fourth lies in it
    assert np.abs(points).max() < edge / 2


def test_the_preferred_plane_rises_with_the_distance_and_holds_the_horizontal_edge():
    c1, c2, c7, c8 = (CUBE.corner(n) for n in (1, 2, 7, 8))
    assert (
        np.allclose(c2 - c1, [0, -L, 0])
        and np.allclose(c7 - c2, [L, 0, L])
        and np.allclose(c8 - c1, [L, 0, L])
    )
    assert math.isclose(math.dist(c1, c7), math.sqrt(3) * L)


@given(edge=EDGES)
def test_lengths_equal_their_formulas(edge):
    cube = TestCube(edge, CENTER)
    figures = test_path(cube, 0.05 * edge).figures
    assert math.isclose(
        figures[0].length, 2 * 0.8 * math.sqrt(3) * edge, rel_tol=1e-12
    )  # there and back
    assert math.isclose(figures[1].length, math.pi * 0.8 * edge, rel_tol=1e-12)
    assert math.isclose(figures[2].length, math.pi * 0.1 * edge, rel_tol=1e-12)
    # scipy-free oracle: the blend's tangent length over its arc length, by the midpoint rule
    u = (np.arange(20000) + 0.5) / 20000
    share = np.cos(np.pi / 4 * (1 - np.cos(np.pi * u))).mean()
    sharp = 2 * 0.8 * edge * (1 + math.sqrt(2))
    assert math.isclose(figures[3].length, sharp + 4 * 0.05 * edge * (1 / share - 2), rel_tol=1e-8)


def test_the_figures_are_where_the_standard_puts_them():
    p1, p2, p3, p4, p5 = CUBE.pose_points()
    diagonal = CUBE.corner(7) - CUBE.corner(1)
    assert np.allclose(p1, CENTER)
    assert np.allclose(p2, CUBE.corner(1) + 0.1 * diagonal) and np.allclose(
        p4, CUBE.corner(7) - 0.1 * diagonal
    )
    out = line(CUBE)
    assert np.allclose(out.position([0.0, 0.5 * out.length, out.length]), [p2, p4, p2])
    for figure, radius in zip(PATH.figures[1:3], (0.16, 0.02), strict=True):
        assert np.allclose(np.linalg.norm(walk(figure) - CENTER, axis=1), radius)
    corners = PATH.figures[3].corners
    assert np.allclose(corners, [p2, p3, p4, p5])  # E1..E4 in the order passed
    gap = np.linalg.norm(walk(PATH.figures[3])[:, None] - corners, axis=2)
    assert (np.diff(np.argmin(gap, axis=0)) > 0).all()


def test_all_figures_are_closed_and_so_is_the_cycle():
    assert [figure.closed for figure in PATH.figures] == [True] * 4
    assert np.allclose(PATH.position([0.0, PATH.length]), [CENTER, CENTER], atol=1e-15)
    assert PATH.rests[0] == 0 and PATH.rests[-1] == PATH.length and (np.diff(PATH.rests) > 0).all()


def test_transfers_are_marked_and_straight():
    s = np.linspace(0, PATH.length, 5001)
    figure = PATH.figure(s)
    changes = figure[np.flatnonzero(np.diff(figure, prepend=-9))]
    assert changes.tolist() == [-1, 0, -1, 1, -1, 2, -1, 3, -1]
    for leg, start, end in zip(PATH.legs, PATH.rests, PATH.rests[1:], strict=False):
        if leg.figure == -1:
            assert math.isclose(math.dist(*PATH.position([start, end])), end - start)


@given(rounding=st.floats(0.01, 0.15), edge=st.floats(0.4, 1.0))
def test_the_path_is_one_line_over_its_own_arc_length(rounding, edge):
    path = test_path(TestCube(edge, CENTER), rounding)
    s = np.union1d(
        np.linspace(0.0, path.length, 8001), path.rests
    )  # no chord across a corner at rest
    assert math.isclose(measured_length(path.position(s)), path.length, rel_tol=2e-5)


@pytest.mark.parametrize("figure", PATH.figures, ids=lambda f: f.name)
def test_tangent_and_bend_are_the_derivatives_of_the_position(figure):
    for stroke in figure.strokes:
        s = np.linspace(0.0, stroke.length, 20001)
        r, t, b = stroke.at(s)
        h = s[1]
        assert np.abs(np.gradient(r, h, axis=0) - t)[1:-1].max() < 1e-5
        assert np.abs(np.gradient(t, h, axis=0) - b)[1:-1].max() < 2e-2 * max(
            stroke.curvature, 1e-3
        )
        assert np.allclose(np.linalg.norm(t, axis=1), 1.0)
        assert np.linalg.norm(b, axis=1).max() <= stroke.curvature * (1 + 1e-9)


def test_the_rounding_has_continuous_curvature_and_an_arc_would_not():
    rect = PATH.figures[3].strokes[0]
    s = np.linspace(0.0, rect.length, 200001)
    bend = rect.at(s)[2]
    jump = np.linalg.norm(np.diff(bend, axis=0), axis=1).max()
    assert jump < 1.01 * math.hypot(rect.curvature_rate, rect.curvature**2) * s[1]
    assert rect.curvature > 40.0 and jump < 0.06


def test_the_blend_ends_on_both_legs_and_its_smallest_radius_is_as_stated():
    x, y, _ = np.eye(3)
    blend = Blend(np.zeros(3), x, y, 1.0)
    r, t, b = blend.at(np.array([0.0, 0.5 * blend.length, blend.length]))
    assert np.allclose(r[[0, 2]], [-x, y], atol=1e-14) and np.allclose(
        t[[0, 2]], [x, y], atol=1e-14
    )
    assert np.allclose(b[[0, 2]], 0, atol=1e-14)
    assert math.isclose(1 / np.linalg.norm(b[1]), 0.674, abs_tol=1e-3)
    assert np.allclose(-r[1, 0], r[1, 1])  # symmetric about the bisector


def test_the_circle_runs_once_around_with_its_curvature():
    circ = circle(CUBE, 0.8, "c").strokes[0]
    assert isinstance(circ, Circle)
    angle = np.unwrap(
        np.arctan2(
            *(
                (circ.at(np.linspace(0, circ.length, 99))[0] - CENTER)
                @ np.array([circ.v, circ.u]).T
            ).T
        )
    )
    assert math.isclose(angle[-1] - angle[0], 2 * math.pi)


@pytest.mark.parametrize(
    ("call", "cure"),
    [
        (lambda: TestCube(0.0, CENTER), "positive length"),
        (lambda: TestCube(math.nan, CENTER), "positive length"),
        (lambda: TestCube(0.4, [1, 2]), "x, y, z"),
        (lambda: TestCube(0.4, CENTER, "C1-C2-C3-C4"), "C2-C3-C8-C5"),
        (lambda: rectangle(CUBE, 0.0), "0 < rounding < 0.16"),
        (lambda: rectangle(CUBE, 0.161), "0 < rounding < 0.16"),
        (lambda: TestPath((), CENTER), "at least one figure"),
    ],
)
def test_what_cannot_be_a_path_is_refused_with_the_cure(call, cure):
    with pytest.raises(ParameterError, match=cure):
        call()
