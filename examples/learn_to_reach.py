"""Learns to reach angles with a pneumatic joint that has hysteresis: cross-entropy method on a linear policy.

    python examples/learn_to_reach.py

Two valves are moved by K1 (wanted - angle) + K2 change + K3 (both pressures less the mean) + K4; the four gains of the
first valve are searched, the second one does the opposite. It takes about a minute.
"""

import numpy as np

import dehyst_robot


def policy(gains, seen):
    """Both valves for an observation of one joint: change, wanted, angle, two pressures."""
    change, wanted, angle, first, second = seen
    push = gains[0] * (wanted - angle) - gains[1] * change - gains[2] * (first - second) + gains[3]
    return np.array([push, -push], np.float32)


def error(env, gains, seeds):
    """Mean distance from the target over the last half of some episodes. [deg]"""
    missed = []
    for seed in seeds:
        seen, _ = env.reset(seed=seed)
        done, course = False, []
        while not done:
            seen, reward, _, done, _ = env.step(policy(gains, seen))
            course.append(-reward)
        missed.append(np.mean(course[len(course) // 2 :]))
    return float(np.mean(missed))


def learn(rounds=12, population=24, elite=6, seed=0):
    """Return the error of the mean policy after each round. [deg]"""
    env, random = dehyst_robot.gym(joints=(1,), seconds=1.5), np.random.default_rng(seed)
    mean, spread, errors = np.zeros(4), np.array([3.0, 1.0, 1.0, 0.1]), []
    for k in range(rounds):
        errors.append(error(env, mean, range(100, 106)))
        print(f"round {k}: {errors[-1]:.2f} deg, gains {np.round(mean, 2)}")
        tried = mean + spread * random.standard_normal((population, 4))
        order = np.argsort([error(env, gains, range(10 * k, 10 * k + 4)) for gains in tried])
        best = tried[order[:elite]]
        mean, spread = best.mean(axis=0), best.std(axis=0) + 0.02
    errors.append(error(env, mean, range(100, 106)))
    return errors


if __name__ == "__main__":
    print(f"error at the end: {learn()[-1]:.2f} deg")
