"""Controllers of one's own drive the simulated joints, as themselves and in a Gymnasium environment."""

import runpy

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import dehyst_robot
from dehyst.errors import ParameterError, SimulationError
from dehyst_robot.arm import Drives, load_robot
from dehyst_robot.environment import MOST_ACCELERATION, TrackEnv
from places import ROOT

ROBOT = load_robot(conditions="kind")
EXAMPLE = ROOT / "examples" / "learn_to_reach.py"


def test_ticks_hold_a_command_and_a_reset_gives_the_same_again():
    one, many = Drives(ROBOT, (1, 3)), Drives(ROBOT, (1, 3))
    command = [[0.2, -0.1], [0.05, 0.0]]
    for _ in range(10):
        seen = one.step(command)
    one_first, many_first = seen, many.step(command, ticks=10)
    np.testing.assert_array_equal(one_first[0, 0], many_first[0, 0])
    assert (
        abs(many_first[1, 0]) > 0 and not many_first[1, 1:].any()
    )  # the electric joint moves, and has no pressures
    again = one.reset()
    np.testing.assert_array_equal(again, Drives(ROBOT, (1, 3)).reset())


def test_pressures_are_reached_at_once():
    drives = Drives(ROBOT, (1,), pressures=True)
    seen = drives.step([[3.2e5, 2.8e5]], ticks=40)
    assert abs(seen[0, 1] - 3.2e5) < 2e3 and abs(seen[0, 2] - 2.8e5) < 2e3 and seen[0, 0] > 0


@pytest.mark.parametrize("commands", [[0.1, 0.1], [[0.1]], [[0.1, 0.1]] * 2])
def test_commands_that_do_not_fit_are_refused_with_the_shape_that_does(commands):
    with pytest.raises(ParameterError, match=r"\(1, 2\)"):
        Drives(ROBOT, (1,)).step(commands)


@pytest.mark.parametrize("more", [{}, {"pressures": True}, {"joints": None}, {"joints": (3,)}])
def test_the_environment_passes_gymnasiums_own_checker(more):
    env = dehyst_robot.gym(**more)
    check_env(env, skip_render_check=True)
    env.reset(seed=1)
    seen, reward, *_ = env.step(env.action_space.sample())
    assert env.observation_space.contains(seen) and -90 < reward < 0


@pytest.mark.parametrize("name", ["Joint-v0", "JointTrack-v0"])
def test_the_registered_environments_pass_gymnasiums_own_checker(name):
    env = gymnasium.make(f"dehyst_robot.environment:dehyst/{name}", joints=(1, 3))
    assert env.spec.id == f"dehyst/{name}"
    assert gymnasium.make(f"dehyst/{name}").spec.id == env.spec.id
    check_env(env.unwrapped, skip_render_check=True)


def test_a_path_to_follow_is_smooth_stays_within_its_reach_and_is_observed_ahead():
    env = TrackEnv(ROBOT, (1, 2), seconds=6.0, reach=0.5, speed=(0.2, 0.4), preview=0.05)
    observation, info = env.reset(seed=4)
    path, step = env.path, 0.005
    assert path.shape == (1200, 2)
    limits = 0.5 * np.array([ROBOT.joint(number).range for number in (1, 2)])
    assert (np.abs(path) <= limits + 1e-12).all()
    rate = np.abs(np.diff(path, axis=0)) / step
    # The speed of a stroke of minimum jerk is at most 15/8 of its mean.
    assert 0.2 < rate.max() <= 1.0001 * 1.875 * 0.4
    assert np.abs(np.diff(path, 2, axis=0)).max() / step**2 < 1.05 * MOST_ACCELERATION
    for k in range(30):
        shown = observation[2:6].reshape(2, 2) * [ROBOT.joint(number).range for number in (1, 2)]
        np.testing.assert_allclose(shown, [path[k], path[k + 10]], atol=1e-6)
        observation, _, _, _, info = env.step(np.zeros(4, np.float32))
        wanted = np.degrees(path[k])
        np.testing.assert_allclose(info["angle_deg"] + info["error_deg"], wanted, atol=1e-9)


def test_two_resets_give_two_paths_and_a_seed_gives_one_again():
    env = TrackEnv(ROBOT, (1,))
    env.reset(seed=1)
    first = env.path.copy()
    env.reset()
    assert not np.array_equal(env.path, first)
    env.reset(seed=1)
    np.testing.assert_array_equal(env.path, first)


@pytest.mark.parametrize(
    "wrong",
    [
        {"speed": (0.0, 1.0)}, {"speed": (2.0, 1.0)}, {"speed": 0.5}, {"speed": (0.1,)}, {"speed": ("a", 1)},
        {"preview": -1.0}, {"preview": "x"},
    ],
)  # fmt: skip
def test_a_path_that_cannot_be_is_refused(wrong):
    with pytest.raises(ParameterError, match="make no path"):
        TrackEnv(ROBOT, **wrong)


def test_environments_run_side_by_side_and_repeat_by_their_seed():
    def run():
        envs = gymnasium.vector.SyncVectorEnv([lambda: dehyst_robot.gym(ticks=2)] * 3)
        seen, _ = envs.reset(seed=5)
        actions = np.tile([0.1, -0.1], (3, 1)).astype(np.float32)
        for _ in range(20):
            seen, reward, *_ = envs.step(actions)
        return seen, reward

    (first, reward), (second, _) = run(), run()
    np.testing.assert_array_equal(first, second)
    assert len(np.unique(reward)) == 3


@pytest.mark.parametrize("action", [[0.1], [np.nan, 0.0], [[0.1, 0.2]]])
def test_an_action_that_is_none_is_refused(action):
    env = dehyst_robot.gym()
    env.reset(seed=0)
    with pytest.raises(ParameterError, match="is not 2 finite numbers from -1 to 1"):
        env.step(action)


@pytest.mark.parametrize(
    "wrong",
    [{"ticks": 0}, {"ticks": 2.5}, {"seconds": -1.0}, {"seconds": float("inf")}, {"seconds": "a"}, {"reach": 2.0}],
)  # fmt: skip
def test_an_episode_that_cannot_be_is_refused(wrong):
    with pytest.raises(ParameterError, match="make no episode"):
        dehyst_robot.gym(**wrong)


def test_a_joint_that_leaves_its_range_ends_the_episode_and_is_named():
    env = dehyst_robot.gym(seconds=100)
    env.reset(seed=0)
    ends = [env.step(np.array([1, -1], np.float32))[2] for _ in range(400)]
    assert ends.index(True) > 5
    drives = Drives(ROBOT, (1,))
    with pytest.raises(SimulationError, match="joint 1 went to"):
        drives.step([[1.0, -1.0]], ticks=4000)


def test_an_episode_ends_after_its_seconds():
    env = dehyst_robot.gym(seconds=0.05)
    env.reset(seed=0)
    ends = [env.step(np.zeros(2, np.float32))[3] for _ in range(10)]
    assert ends == [False] * 9 + [True]


@pytest.mark.exhaustive
def test_the_example_learns_to_reach():
    learn = runpy.run_path(str(EXAMPLE))["learn"]
    errors = learn(rounds=8, seed=1)
    assert errors[-1] < 0.35 * errors[0]
