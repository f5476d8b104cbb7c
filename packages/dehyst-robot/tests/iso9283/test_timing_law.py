"""Timing of test paths: limits hold by finite differences, ends at rest, factors, and slowing down to limits."""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from dehyst.errors import ParameterError
from dehyst_robot.iso9283 import TestCube, slow_down_to, test_path, timed
from dehyst_robot.iso9283._timing import rest_to_rest
from effort import lines_run

PATH = test_path(TestCube(0.4, [0.6, 0.0, 0.9]), 0.03)
FAST = timed(PATH, 0.25, 2.0, 40.0, rest=1.0)
POSITIVE = st.floats(0.05, 50.0)


def integrate(duration, jerk):
    """Return the states at the phase ends, by the cubic of each phase."""
    s = v = a = 0.0
    states = [(s, v, a)]
    for t, j in zip(duration, jerk, strict=True):
        s, v, a = s + v * t + a * t * t / 2 + j * t**3 / 6, v + a * t + j * t * t / 2, a + j * t
        states.append((s, v, a))
    return np.array(states)


@given(d=POSITIVE, v=POSITIVE, a=POSITIVE, j=POSITIVE)
def test_seven_phases_cover_the_distance_from_rest_to_rest_within_limits(d, v, a, j):
    duration, jerk = rest_to_rest(d, v, a, j)
    states = integrate(duration, jerk)
    assert (duration >= 0).all() and np.abs(jerk).max() == j
    assert np.allclose(states[-1], [d, 0, 0], atol=1e-7 * max(d, v, a))
    assert states[:, 1].max() <= v * (1 + 1e-9) and np.abs(states[:, 2]).max() <= a * (1 + 1e-9)


@settings(max_examples=60)
@given(d=POSITIVE, v=POSITIVE, a=POSITIVE, j=POSITIVE)
def test_no_motion_within_the_limits_is_faster_says_ruckig(d, v, a, j):
    ruckig = pytest.importorskip("ruckig")
    inp = ruckig.InputParameter(1)
    inp.current_position, inp.target_position = [0.0], [d]
    inp.max_velocity, inp.max_acceleration, inp.max_jerk = [v], [a], [j]
    trajectory = ruckig.Trajectory(1)
    result = ruckig.Ruckig(1).calculate(inp, trajectory)
    assume(result == ruckig.Result.Finished or result == ruckig.Result.Working)
    assert math.isclose(rest_to_rest(d, v, a, j)[0].sum(), trajectory.duration, rel_tol=1e-6)


@settings(max_examples=25)
@given(
    v=st.floats(0.05, 1.0),
    a=st.floats(0.3, 8.0),
    j=st.floats(3.0, 200.0),
    rounding=st.floats(0.01, 0.1),
    f=st.floats(1, 9),
)
def test_acceleration_and_jerk_in_space_stay_within_limits_by_finite_differences(
    v, a, j, rounding, f
):
    motion = timed(test_path(TestCube(0.4, [0.6, 0.0, 0.9]), rounding), v, a, j, rest=0.1, factor=f)
    t = np.linspace(0.0, motion.duration, 20001)
    h = t[1]
    r = motion.position(t)
    velocity, acceleration, jerk = (
        np.linalg.norm(np.diff(r, n, axis=0), axis=1).max() / h**n for n in (1, 2, 3)
    )
    noise = 1e-15 * np.array([2, 4, 8]) / h ** np.arange(1, 4)
    assert velocity <= v / f + noise[0] + 1e-9
    assert acceleration <= a / f**2 * (1 + 1e-9) + noise[1]
    assert jerk <= j / f**3 * (1 + 1e-6) + noise[2]


def test_the_state_is_the_derivative_of_the_position():
    t = np.linspace(0.0, FAST.duration, 200001)[:-1]
    position, velocity, acceleration = FAST.state(t)
    assert np.abs(np.gradient(position, t, axis=0) - velocity).max() < 1e-6
    assert np.abs(np.gradient(velocity, t, axis=0) - acceleration).max() < 5e-3
    s, speed, tangential, jerk = FAST.motion(t)
    assert np.abs(np.gradient(s, t)[1:-1] - speed[1:-1]).max() < 1e-6
    assert np.abs(np.gradient(speed, t)[1:-1] - tangential[1:-1]).max() < 5e-3
    assert np.allclose(np.linalg.norm(velocity, axis=1), speed, atol=1e-12)
    assert np.abs(jerk).max() <= 40.0


def test_every_leg_ends_at_rest_for_as_long_as_asked():
    t = np.arange(0.0, FAST.duration, 0.001)
    still = FAST.motion(t).speed == 0.0
    assert math.isclose(still.mean() * FAST.duration, len(PATH.legs) * 1.0, abs_tol=0.02)
    resting = FAST.motion(t[still]).s
    assert np.abs(resting[:, None] - PATH.rests).min(axis=1).max() < 1e-9


def test_cycles_repeat_and_are_counted():
    t = np.linspace(0.01, FAST.duration - 0.01, 999)
    assert np.allclose(FAST.position(t + 3 * FAST.duration), FAST.position(t), atol=1e-9)
    assert (FAST.cycle(t) == 0).all() and (FAST.cycle(t + 3 * FAST.duration) == 3).all()
    assert np.array_equal(FAST.figure(t + 2 * FAST.duration), FAST.figure(t))
    assert np.allclose(FAST.position([-5.0, 0.0]), PATH.home)
    assert [f for f, g in zip(FAST.figure(t), FAST.figure(t)[1:], strict=False) if f != g] == [
        -1,
        0,
        -1,
        1,
        -1,
        2,
        -1,
        3,
    ]


def test_the_rest_after_a_figure_belongs_to_it_so_that_a_lagging_arm_can_finish():
    t = np.arange(0.0, FAST.duration, 0.001)
    still = FAST.motion(t).speed == 0.0
    for figure, strokes in enumerate((2, 1, 1, 1)):
        assert math.isclose(
            (still & (FAST.figure(t) == figure)).sum() * 0.001, strokes * 1.0, abs_tol=0.01
        )


@given(factor=st.floats(0.5, 50.0))
def test_a_slower_motion_is_the_same_path_in_longer_time(factor):
    slow = FAST.slower(factor)
    t = np.linspace(0.0, 1.9 * FAST.duration, 200)
    assert math.isclose(slow.duration, factor * FAST.duration)
    assert np.allclose(slow.position(factor * t), FAST.position(t), atol=1e-9)
    assert np.allclose(slow.motion(factor * t).speed * factor, FAST.motion(t).speed, atol=1e-9)
    assert math.isclose(slow.command_speed(1) * factor, FAST.command_speed(1))
    assert slow.share_at_command_speed(1) == FAST.share_at_command_speed(1)


def test_every_figure_is_run_at_its_command_speed_over_half_its_length():
    t = np.linspace(0.0, FAST.duration, 100001)
    motion, figure = FAST.motion(t), FAST.figure(t)
    for number in range(4):
        speed, share = FAST.command_speed(number), FAST.share_at_command_speed(number)
        here = figure == number
        at_speed = here & (motion.speed > speed * (1 - 1e-9))
        way = np.sum(motion.speed[at_speed]) * t[1]
        assert math.isclose(way / PATH.figures[number].length, share, abs_tol=2e-3)
        assert share >= 0.5
    assert np.allclose([FAST.command_speed(0), FAST.command_speed(1)], 0.25)
    assert FAST.command_speed(2) < 0.25 and FAST.command_speed(3) < 0.25  # sharp bends


def test_the_line_is_steady_once_there_and_once_back():
    (low, high), (low_back, high_back) = FAST.steady_ranges(0)
    half = PATH.figures[0].length / 2
    assert math.isclose(low + high, half) and math.isclose(
        low_back + high_back, 3 * half
    )  # in the middle of each
    assert 0 < low < high < half < low_back < high_back < 2 * half


def test_a_whole_run_is_sampled_without_a_loop_over_samples():
    assert (
        lines_run(lambda: FAST.state(np.arange(0.0, 100.0, 0.001))) < 10_000
    )  # 3 500, however many


@given(
    static=st.floats(0.0, 0.9),
    inertial=st.floats(0.0, 50.0),
    power=st.sampled_from([1, 2, 4]),
    tol=st.floats(0.001, 0.1),
)
def test_slowing_down_finds_the_smallest_factor_that_keeps_the_limits(static, inertial, power, tol):
    calls = []

    def use(motion):
        calls.append(motion.factor)
        return static + inertial / motion.factor**power

    exact = max(1.0, (inertial / (1.0 - static)) ** (1 / power))
    assume(exact < 90)
    found = slow_down_to(FAST, use, tolerance=tol)
    assert use(found) <= 1.0
    assert exact <= found.factor * (1 + 1e-12) and found.factor <= exact * (1 + tol) + 1e-12
    assert len(calls) - 1 <= (6 if power == 2 and exact < 20 else 30)


def test_slowing_down_terminates_on_a_step():
    found = slow_down_to(FAST, lambda motion: 2.0 if motion.factor < 7.0 else 0.9)
    assert 7.0 <= found.factor <= 7.07


def test_slowing_down_leaves_a_motion_within_limits_alone():
    assert slow_down_to(FAST, lambda motion: 1.0) is FAST


def test_slowing_down_starts_from_the_motions_own_factor():
    found = slow_down_to(FAST.slower(2.0), lambda motion: 9.0 / motion.factor**2)
    assert 3.0 <= found.factor <= 3.03


@pytest.mark.parametrize(
    ("call", "cure"),
    [
        (lambda: timed(PATH, 0.0, 1, 1, 1), "speed = 0.0"),
        (lambda: timed(PATH, 1, math.nan, 1, 1), "acceleration = nan"),
        (lambda: timed(PATH, 1, 1, -1, 1), "jerk = -1"),
        (lambda: timed(PATH, 1, 1, 1, -1), "zero or more"),
        (lambda: timed(PATH, 1, 1, 1, 1, 0), "factor = 0"),
        (lambda: FAST.slower(math.inf), "positive"),
        (lambda: slow_down_to(FAST, lambda m: 1.5), "not the speed"),
        (lambda: slow_down_to(FAST, lambda m: math.nan), "must be a number"),
    ],
)
def test_what_cannot_be_timed_is_refused_with_the_cure(call, cure):
    with pytest.raises(ParameterError, match=cure):
        call()
