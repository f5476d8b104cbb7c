"""Learned inverse dynamics as a feedforward: what a log says of the hysteresis, by a Gaussian process or a network.

Both get the log that `paper` and `best` get: angle, and the pressure difference beyond the calibrated characteristic.
Both predict it along the desired path before the run, in place of the compensator; characteristic, load and inertia
stay those of the controller. So they learn the part of the inverse dynamics that a model is looked for, which is easier
than all of it. Needs scikit-learn and jax: pip install --group bench.

Sources: Rasmussen, Williams, Gaussian Processes for Machine Learning, 2006; Nguyen-Tuong, Peters, Using model knowledge
for learning inverse dynamics, ICRA 2010; Cho et al., gated recurrent unit, EMNLP 2014.
"""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
import numpy.typing as npt

from dehyst_robot.experiments import JointIdentification
from dehyst_robot.experiments._identification import HYSTERESIS, OUTPUT, TIME
from dehyst_robot.experiments._results import BAR

Array = npt.NDArray[np.float64]
History = Callable[[Array, Array, Array], Array]

PLAY = 1e-4  # half width of the play that keeps an encoder's steps out of the travelled way [rad]
SEARCHED = 300  # samples on which the kernel's lengths are searched
MOST = 1.5  # of the log's largest value: what is predicted beyond is cut
PADDED = 512  # a path's samples are padded to a multiple, so that few networks are compiled

SHORT_WAYS = (0.01, 0.03, 0.1, 0.2, 0.4)
WAYS = (0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.4, 0.8)
LAGS = (0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0)


@dataclass(frozen=True)
class ProcessSetting:
    """Features of a Gaussian process: earlier angles, by time [s] or by the travelled way [rad], and turns."""

    lags: tuple[float, ...]
    by: str
    turns: int
    samples: int


@dataclass(frozen=True)
class NetworkSetting:
    """What a step of the recurrent network is: of the travelled way [rad], or of time [s]."""

    by: str
    step: float


PROCESSES: Mapping[str, ProcessSetting] = MappingProxyType(
    {
        "5 ways": ProcessSetting(SHORT_WAYS, "way", 0, 600),
        "8 ways": ProcessSetting(WAYS, "way", 0, 600),
        "8 ways, 3 turns": ProcessSetting(WAYS, "way", 3, 600),
        "8 ways, 3 turns, more samples": ProcessSetting(WAYS, "way", 3, 1200),
        "8 times": ProcessSetting(LAGS, "time", 0, 600),
    }
)
NETWORKS: Mapping[str, NetworkSetting] = MappingProxyType(
    {
        "way of 0.01 rad": NetworkSetting("way", 0.01),
        "way of 0.02 rad": NetworkSetting("way", 0.02),
        "way of 0.04 rad": NetworkSetting("way", 0.04),
        "time of 0.15 s": NetworkSetting("time", 0.15),
        "time of 0.3 s": NetworkSetting("time", 0.3),
    }
)


class LearnedFeedforward:
    """A compensator that is evaluated along the whole desired path at once.

    Parameters
    ----------
    predict
        Angles (T,) [rad] and times (T,) [s] -> pressure differences (T,). [bar]
    parameters
        Numbers that were learned.
    """

    def __init__(self, predict: Callable[[Array, Array], Array], parameters: int) -> None:
        self.predict, self.parameters = predict, parameters
        self.seconds, self.samples = 0.0, 0

    def over(self, angle: Array, velocity: Array, times: Array) -> Array:
        """Return the term along a path. [Pa]"""
        begin = time.perf_counter()
        term = BAR * self.predict(angle, times)
        self.seconds += time.perf_counter() - begin
        self.samples += angle.size
        return term


def travelled(angle: Array, play: float = PLAY) -> Array:
    """Return the way (T,) that an angle has travelled, small steps left out. [rad]

    Examples
    --------
    >>> travelled(np.array([0.0, 0.2, 0.1, 0.1]), play=0.0).round(6).tolist()
    [0.0, 0.2, 0.3, 0.3]
    """
    played = np.empty(angle.size)
    last = float(angle[0])
    for k, q in enumerate(angle.tolist()):
        last = min(max(last, q - play), q + play)
        played[k] = last
    return np.concatenate([[0.0], np.cumsum(np.abs(np.diff(played)))])


def turning_angles(angle: Array, count: int, play: float = 10 * PLAY) -> Array:
    """Return the last `count` angles at which the motion turned before each sample, (T, count), latest first. [rad]

    Examples
    --------
    >>> turning_angles(np.array([0.0, 0.2, 0.1, 0.15]), 2, play=0.01).tolist()
    [[0.0, 0.0], [0.0, 0.0], [0.2, 0.0], [0.1, 0.2]]
    """
    turns = np.empty((angle.size, count))
    last = [float(angle[0])] * count
    extreme, way = float(angle[0]), 0.0
    for k, q in enumerate(angle.tolist()):
        if way * (q - extreme) >= 0.0:
            if abs(q - extreme) > play and way == 0.0:
                way = float(np.sign(q - extreme))
            if way != 0.0:
                extreme = q
        elif abs(q - extreme) > play:
            last = [extreme, *last[:-1]]
            way, extreme = -way, q
        turns[k] = last
    return turns


def features(setting: ProcessSetting, angle: Array, times: Array) -> Array:
    """Return the features (T, n) of a motion: its angle, how far it has moved since, and since its last turns."""
    at = times if setting.by == "time" else travelled(angle)
    # Where the way stands still, time does not: the last angle at a way counts.
    distinct = np.flatnonzero(np.diff(at, append=np.inf) > 0.0)
    columns = [angle]
    for lag in setting.lags:
        columns.append(angle - np.interp(at - lag, at[distinct], angle[distinct]))
    if setting.turns:
        columns.extend((angle[:, None] - turning_angles(angle, setting.turns)).T)
    return np.stack(columns, axis=1)


def gaussian_process(identification: JointIdentification, name: str) -> LearnedFeedforward:
    """Train a Gaussian process with a length for each feature on a joint's log; settings of `PROCESSES`."""
    from sklearn.exceptions import ConvergenceWarning
    from sklearn.gaussian_process import GaussianProcessRegressor
    from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel

    setting, log = PROCESSES[name], identification.log
    x, y = features(setting, log[OUTPUT], log[TIME]), log[HYSTERESIS]
    middle, size = x.mean(axis=0), np.maximum(x.std(axis=0), 1e-9)
    level, unit = float(y.mean()), float(y.std())
    x, y = (x - middle) / size, (y - level) / unit
    most = MOST * float(np.abs(log[HYSTERESIS]).max())
    kernel = ConstantKernel(1.0) * RBF(np.ones(x.shape[1]), (1e-2, 1e3)) + WhiteKernel(1e-2)
    order = np.random.default_rng(0).permutation(y.size)
    searched_on, trained_on = order[:SEARCHED], order[: setting.samples]
    with warnings.catch_warnings():
        # A length at its bound means that a feature does not matter.
        warnings.simplefilter("ignore", ConvergenceWarning)
        searched = GaussianProcessRegressor(kernel, random_state=0).fit(
            x[searched_on], y[searched_on]
        )
        process = GaussianProcessRegressor(searched.kernel_, optimizer=None).fit(
            x[trained_on], y[trained_on]
        )

    def predict(angle: Array, times: Array) -> Array:
        scaled = (features(setting, angle, times) - middle) / size
        return np.asarray(np.clip(level + unit * process.predict(scaled), -most, most))

    return LearnedFeedforward(predict, setting.samples + x.shape[1] + 2)


def recurrent_network(identification: JointIdentification, name: str) -> LearnedFeedforward:
    """Train three gated recurrent networks on a joint's log and take their mean; settings of `NETWORKS`."""
    from boxes.gru import STATES, gru
    from boxes.signals import Half

    setting, log = NETWORKS[name], identification.log
    q, h = log[OUTPUT], log[HYSTERESIS]
    at = log[TIME] if setting.by == "time" else travelled(q)
    grid = np.arange(0.0, float(at[-1]), setting.step)
    reach, unit = float(np.abs(q).max()), float(np.abs(h).max())
    # The mean over the samples of a step: what a rest leaves is averaged.
    half = Half(stepped(grid, at, q) / reach, stepped(grid, at, h) / unit)
    networks = gru(half)

    def predict(angle: Array, times: Array) -> Array:
        now = times - times[0] if setting.by == "time" else travelled(angle)
        steps = np.arange(0.0, float(now[-1]) + setting.step, setting.step)
        x = stepped(steps, now, angle) / reach
        padded = np.concatenate([x, np.full(-x.size % PADDED, x[-1])])
        outputs = np.mean([network(padded) for network in networks], axis=0)
        along = np.interp(now, steps, outputs[: x.size])
        return np.asarray(np.clip(unit * along, -MOST * unit, MOST * unit))

    each = 3 * STATES * (2 + STATES + 1) + STATES + 3
    return LearnedFeedforward(predict, len(networks) * each)


def stepped(grid: Array, at: Array, values: Array) -> Array:
    """Return values at the points of a grid of the way or of time; where the way stands still, the last one."""
    distinct = np.flatnonzero(np.diff(at, append=np.inf) > 0.0)
    return np.asarray(np.interp(grid, at[distinct], values[distinct]))
