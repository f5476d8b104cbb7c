"""Direct inverse: the input an actuator needs, as a function of its desired output and the output's history."""

from __future__ import annotations

import itertools
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import Any, ClassVar, NamedTuple, Self

import numpy as np
import numpy.typing as npt

import dehyst._native as _native
from dehyst._native import DirectStepper
from dehyst.arrays import Array
from dehyst.errors import ParameterError
from dehyst.models._arrays import (
    parameter_array,
    parameter_number,
    signal_array,
    strictly_increasing,
)
from dehyst.models._base import RejectedSamplesWarning
from dehyst.models._card import NO_CARD, ModelCard, SignalCard
from dehyst.models._follow import direct_machine, follow
from dehyst.models._machine import Direction, Machine
from dehyst.models._model import Band, Inverted, Model, Steps, WeightTable
from dehyst.models._policy import POLICY
from dehyst.models._start import FALLING, REST, RISING, UNKNOWN
from dehyst.units import MASS_FACTORS

NONE = np.zeros(0)
# Range of a signal that has none: it covers any signal in Pa or counts, and the core takes three times as much.
BOUNDLESS = 1e14
GROUPS: tuple[str, ...] = ("short", "long", "creep", "viscous")
OUTPUT = "output"
# Pasts in the order of the core's DEHYST_PAST_...
DIRECT_PASTS = (UNKNOWN, REST, RISING, FALLING)


@dataclass(frozen=True)
class Schedule:
    """A variable between two ends of whose range weights are blended: xi = (sigma - low)/(high - low) within 0..1.

    Parameters
    ----------
    name
        "output" for y itself, else the name of a signal from outside, for instance "mean_pressure" or "load".
    low, high
        Ends of its range, low < high; beyond them it is held. [unit]
    unit
        Of the variable, "" if unknown.

    Raises
    ------
    ParameterError
        If the range is empty.

    Examples
    --------
    >>> Schedule("mean_pressure", 2.0, 4.0, "bar").outside
    True
    """

    name: str
    low: float
    high: float
    unit: str = ""

    def __post_init__(self) -> None:
        for end in ("low", "high"):
            value = parameter_number(getattr(self, end), f"{end} of schedule '{self.name}'")
            object.__setattr__(self, end, value)
        if not self.low < self.high:
            raise ParameterError(
                f"schedule '{self.name}' has the range {self.low:g} to {self.high:g}: nothing can be blended over it. "
                f"Pass low < high, or leave the schedule out."
            )

    def __str__(self) -> str:
        """Name and, from outside, range; a mass is said to be one."""
        if not self.outside:
            return self.name
        text = f"{self.name} {self.low:z.4g} to {self.high:z.4g} {self.unit}".rstrip()
        if self.unit in MASS_FACTORS:
            text += " (a mass; no joint controller takes it)"
        return text

    @property
    def outside(self) -> bool:
        """Whether its values are given from outside."""
        return self.name != OUTPUT


def _none() -> Array:
    return NONE


class DirectRun(NamedTuple):
    """Answer of a direct inverse along a signal.

    Attributes
    ----------
    u
        (T,) [input of the actuator]
    doubt
        (T,) guaranteed half width of u: however the actuator was moved before, the model's answer with its true past
        lies within u - doubt .. u + doubt. Zero for a known past. [input of the actuator]
    parts
        (T, groups) what each group of `GROUPS` adds. [input of the actuator]
    """

    u: Array
    doubt: Array
    parts: Array


@dataclass(frozen=True, eq=False, repr=False)
class DirectInverse(Model):
    r"""What an actuator needs at its input u for an output y, identified in that direction.

    .. math::

        u = \sum_c h_c(\sigma) \Bigl[ P_c(y - c_0) + \sum_i s_{ci} E_{r_i}[y] + \sum_k p_{ck} R_{x_k}[y]
            + \sum_j k_{cj} (y - L_{\tau_j}[y]) + d_c \dot y \Bigr]

    E is the stop operator (identity less play), R a lag along the path, :math:`dR = dy - R\,|dy|/x`, an element of
    Dahl (1968), and L a first-order lag in time (creep). Weights but for those of P are >= 0: every term opposes
    motion, so that u rises with y whatever the past, if P does. Without schedule there is one set of weights,
    h = 1; schedule v has two, blended by its variable from ``low`` (set 2v) to ``high`` (set 2v + 1); all sets are
    summed.

    Parameters
    ----------
    radii
        r of the stops, (n,), increasing, > 0. [y]
    stop_weights
        s, (sets, n) or (n,). [u/y]
    path_lengths
        x, (k,), increasing, > 0. [y]
    path_weights
        p, (sets, k) or (k,). [u/y]
    time_constants
        tau, (m,), increasing, > 0. [s]
    creep_weights
        k, (sets, m) or (m,). [u/y]
    polynomial
        Coefficients of P, lowest power of y - center first, (sets, d) or (d,), d = 1 to 8. [u/y^j]
    viscous
        d, (sets,) or a number. [u s/y]
    center
        c_0. [y]
    schedules
        At most three.
    past
        What the actuator did before the first sample. "rest": nothing, as after a homing. "rising" or "falling":
        strokes over the whole identified range of y, the last one rising, or falling, to that sample. "unknown":
        anything; a stop answers in the middle of what it may be, 0 at first. Creep has settled at the first sample.
    card
        Signals: ``card.input`` is u, ``card.output`` is y, as the actuator has them.

    Raises
    ------
    ParameterError
        If shapes do not fit, a weight is negative, a number is not finite, or there is no such past.

    Examples
    --------
    >>> model = DirectInverse(radii=[0.5], stop_weights=[2.0], polynomial=[0.0, 1.0])
    >>> model.run([0.0, 1.0, 0.0], [0.0, 1.0, 2.0]).u.tolist()
    [0.0, 2.0, -1.0]
    >>> model.inverse().simulate([0.0, 1.0, 0.0]).tolist()
    [0.0, 2.0, -1.0]
    """

    radii: Array = field(default_factory=_none)
    stop_weights: Array = field(default_factory=_none)
    path_lengths: Array = field(default_factory=_none)
    path_weights: Array = field(default_factory=_none)
    time_constants: Array = field(default_factory=_none)
    creep_weights: Array = field(default_factory=_none)
    polynomial: Array = field(default_factory=_none)
    viscous: Array = field(default_factory=_none)
    center: float = 0.0
    schedules: tuple[Schedule, ...] = ()
    past: str = REST
    card: ModelCard = NO_CARD
    family: ClassVar[str] = "direct-inverse"
    direction = "inverse"
    core = "direct"
    closeness = float("inf")
    judged_backward = True

    def __post_init__(self) -> None:
        put = object.__setattr__
        put(self, "schedules", tuple(self.schedules))
        if self.past not in DIRECT_PASTS:
            raise ParameterError(
                f"past = {self.past!r:.40} is not one of {', '.join(DIRECT_PASTS)}."
            )
        _check_schedules(self.schedules)
        for name in ("radii", "path_lengths", "time_constants"):
            put(self, name, _scale(getattr(self, name), name))
        put(self, "center", parameter_number(self.center, "center"))
        for name, columns in (
            ("stop_weights", self.radii.size),
            ("path_weights", self.path_lengths.size),
            ("creep_weights", self.time_constants.size),
        ):
            table = _table(getattr(self, name), self.sets, columns, name)
            put(self, name, _not_negative(table, name))
        # What is left out is zero: a viscous term of each set, a curve of one coefficient.
        viscous = np.zeros(self.sets)
        if np.size(self.viscous):
            viscous = np.atleast_1d(self.viscous)
        viscous_table = _table(viscous, self.sets, 1, "viscous")
        put(self, "viscous", _not_negative(viscous_table, "viscous")[:, 0])
        curve: npt.ArrayLike = np.zeros((self.sets, 1))
        if np.size(self.polynomial):
            curve = self.polynomial
        degrees = np.shape(curve)[-1] if np.ndim(curve) else 1
        put(self, "polynomial", _table(curve, self.sets, degrees, "polynomial"))
        if not 1 <= degrees <= _native.DIRECT_COEFFICIENTS:
            raise ParameterError(
                f"the polynomial has {degrees} coefficients; the core takes 1 to {_native.DIRECT_COEFFICIENTS}."
            )

    @property
    def sets(self) -> int:
        """Number of sets of weights."""
        return max(1, 2 * len(self.schedules))

    @property
    def nonzero_weights(self) -> int:
        """Number of terms that carry weight in some set, the polynomial left out."""
        number = 0
        # A term counts once, in whichever set of weights it has one.
        for table in (self.stop_weights, self.path_weights, self.creep_weights):
            number += int(np.count_nonzero(table.any(axis=0)))
        return number + int(self.viscous.any())

    @property
    def kinds(self) -> tuple[str, ...]:
        """Kinds of its terms that carry weight."""
        tables = {
            "stop": self.stop_weights,
            "path": self.path_weights,
            "creep": self.creep_weights,
            "viscous": self.viscous,
        }
        return tuple(kind for kind, table in tables.items() if table.any())

    @property
    def free_parameters(self) -> int:
        """Terms with weight, and coefficients of the polynomials."""
        return self.nonzero_weights + self.polynomial.size

    @property
    def remarks(self) -> tuple[str, ...]:
        """Degree, schedules, creep, and whether the input rises with the output."""
        creep = "none"
        if self.time_constants.size:
            creep = ", ".join(f"{value:.3g}" for value in self.time_constants) + " s"
        slope = "may fall after some past"
        # The slope is known only over a range of the output.
        if self.no_forward == "" and self.least_slope() > 0.0:
            slope = "rises with the output whatever the past"
        return (
            f"degree {self.polynomial.shape[1] - 1}",
            f"schedules {', '.join(map(str, self.schedules)) or 'none'}",
            f"terms of creep {creep}",
            f"the input {slope}",
        )

    @property
    def weight_tables(self) -> tuple[WeightTable, ...]:
        """Stops, path lags and creep."""
        return (
            WeightTable("stops", "radius r", self.card.output.unit, self.radii, self.stop_weights),
            WeightTable(
                "path lags", "length x", self.card.output.unit, self.path_lengths, self.path_weights
            ),
            WeightTable(
                "creep lags", "time constant τ", "s", self.time_constants, self.creep_weights
            ),
        )

    @property
    def parts(self) -> tuple[int, str]:
        """Number of stops and lags."""
        return self.radii.size + self.path_lengths.size + self.time_constants.size, "stops and lags"

    @property
    def outside(self) -> tuple[Schedule, ...]:
        """Schedules whose variables come from outside, in the order in which they are given."""
        return tuple(schedule for schedule in self.schedules if schedule.outside)

    @property
    def rate_dependent(self) -> bool:
        """Whether there is creep or a viscous term."""
        return bool(np.any(self.creep_weights > 0.0) or np.any(self.viscous > 0.0))

    @property
    def context(self) -> tuple[SignalCard, ...]:
        """Variables of the schedules from outside."""
        return tuple(SignalCard(s.name, s.unit, s.low, s.high) for s in self.outside)

    @property
    def unit_needs(self) -> tuple[str, ...]:
        """The rate of the output, and the scheduling variables."""
        return ("rate", *self.needs)

    @property
    def no_forward(self) -> str:
        """Without a range of the output there is nowhere to look for the one that an input gives."""
        card = self.card.output
        if card.low is not None and card.high is not None:
            return ""
        return (
            f"the model names no range of '{card.name}', within which the output for an input could be looked for. "
            f"Identify it with `dehyst identify --family direct-inverse`, which writes the range into the model file, "
            f"or give it a card: model.with_card(ModelCard(SignalCard('u'), SignalCard('y', low=-1, high=1)))."
        )

    def __repr__(self) -> str:
        """One line: family, terms, signals and their identified ranges; parameters are attributes."""
        terms = f"{self.radii.size} stops, {self.path_lengths.size} path lags, {self.time_constants.size} creep lags"
        return f"<DirectInverse: {terms}, {self.card.output!s} -> {self.card.input!s}>"

    def with_past(self, past: str) -> Self:
        """Return the same model with another past before its first sample: "unknown", "rest", "rising" or "falling"."""
        return replace(self, past=past)

    def at_rest(self, first: float) -> Self:
        """Return the same model that begins after a homing, wherever that left it."""
        return self.with_past(REST)

    def after_strokes(self, first: float, rising: bool) -> Self:
        """Return the same model after strokes over its whole range; its input rises with its output.

        Examples
        --------
        >>> card = ModelCard(SignalCard("u"), SignalCard("y", low=-3.0, high=3.0))
        >>> model = DirectInverse(radii=[0.5], stop_weights=[2.0], polynomial=[0.0, 1.0], card=card)
        >>> risen = model.after_strokes(1.0, rising=True)
        >>> risen.inverse().simulate([1.0]).tolist(), risen.simulate([2.0]).round(9).tolist()
        ([2.0], [1.0])
        """
        return self.with_past(RISING if rising else FALLING)

    def pruned(self) -> Self:
        """Return the same function without terms of zero weight."""
        changes: dict[str, Any] = {}
        for scale, weights in (
            ("radii", "stop_weights"),
            ("path_lengths", "path_weights"),
            ("time_constants", "creep_weights"),
        ):
            table = getattr(self, weights)
            carrying = np.flatnonzero(table.any(axis=0))
            changes[scale] = getattr(self, scale)[carrying]
            changes[weights] = table[:, carrying]
        return replace(self, **changes)

    def scaled(self, scales: npt.ArrayLike, offset: float = 0.0) -> Self:
        """Return the model with groups multiplied by scales (groups,) >= 0 and an offset added: what was learned."""
        short, long, creep, viscous = parameter_array(scales, "scales")
        curve = np.array(self.polynomial)
        # Both sets of the first schedule get the offset, since their factors add up to 1.
        curve[:2, 0] += parameter_number(offset, "offset")
        # Stops and path lags are short or long; their groups are 0 and 1.
        memory = self.groups[: self.radii.size + self.path_lengths.size]
        factors = np.where(memory == 0, short, long)
        return replace(
            self,
            stop_weights=self.stop_weights * factors[: self.radii.size],
            path_weights=self.path_weights * factors[self.radii.size :],
            creep_weights=self.creep_weights * creep,
            viscous=self.viscous * viscous,
            polynomial=curve,
        )

    def least_slope(
        self, low: float | None = None, high: float | None = None, scale: float = 1.0
    ) -> float:
        """Return a lower bound of du/dy at a moment, over y from low to high and every past: positive means invertible.

        The curve's smallest slope on 401 points, less what weights that change with y can take away: a stop is at most
        r, a path lag at most x, and a creep term at most the range. Without a schedule of y it is the curve's slope.

        Parameters
        ----------
        low, high
            Range of y; None: that of the card. [y]
        scale
            Largest scale that the groups may have been given.

        Raises
        ------
        ParameterError
            If no range is known.

        Examples
        --------
        >>> DirectInverse(radii=[0.5], stop_weights=[2.0], polynomial=[0.0, 1.0]).least_slope(-1.0, 1.0)
        1.0
        """
        low = self.card.output.low if low is None else low
        high = self.card.output.high if high is None else high
        if low is None or high is None or not low < high:
            raise ParameterError("the range of y is not known: pass low and high, low < high.")
        y = np.linspace(low, high, 401)
        away = y - self.center
        if not self.schedules:
            return float(_derivative(self.polynomial[0], away).min())
        lowest, loss = 0.0, 0.0
        # The most that a term of each kind can answer: its weight that changes with y takes so much of the slope.
        terms = (
            (self.stop_weights, self.radii),
            (self.path_weights, self.path_lengths),
            (self.creep_weights, np.full(self.time_constants.size, high - low)),
        )
        for v, schedule in enumerate(self.schedules):
            below, above = self.polynomial[2 * v], self.polynomial[2 * v + 1]
            slope_below, slope_above = _derivative(below, away), _derivative(above, away)
            if schedule.outside:
                lowest += float(min(slope_below.min(), slope_above.min()))
                continue
            width = schedule.high - schedule.low
            xi = np.clip((y - schedule.low) / width, 0.0, 1.0)
            value = np.polynomial.polynomial.polyval
            # The curve changes along each of both sets, and from one set to the other.
            change = (value(away, above) - value(away, below)) / width
            lowest += float(((1 - xi) * slope_below + xi * slope_above + change).min())
            for weights, size in terms:
                loss += float(np.abs(weights[2 * v + 1] - weights[2 * v]) @ size) / width
        return lowest - scale * loss

    def file_parameters(self) -> dict[str, Any]:
        return {
            "radii": self.radii.tolist(),
            "stop_weights": self.stop_weights.tolist(),
            "path_lengths": self.path_lengths.tolist(),
            "path_weights": self.path_weights.tolist(),
            "time_constants": self.time_constants.tolist(),
            "creep_weights": self.creep_weights.tolist(),
            "polynomial": self.polynomial.tolist(),
            "viscous": self.viscous.tolist(),
            "center": self.center,
            "schedules": [asdict(schedule) for schedule in self.schedules],
            "past": self.past,
        }

    @property
    def groups(self) -> npt.NDArray[np.int64]:
        """Group of `GROUPS` of every term: stops, path lags, creep lags, viscous, (n + k + m + 1,)."""
        # Stops and path lags are compared by the same length: both are ways along y.
        far = POLICY.short * max(self.radii.max(initial=0.0), self.path_lengths.max(initial=0.0))
        sizes = np.concatenate([self.radii, self.path_lengths])
        return np.concatenate(
            [(sizes > far).astype(np.int64), np.full(self.time_constants.size, 2), [3]]
        )

    def parameters(
        self, period: float, order: tuple[str, ...] | None = None, boundless: float = BOUNDLESS
    ) -> tuple[Any, ...]:
        """Return what the core takes, for samples `period` apart [s]; `order` names the variables from outside.

        A signal whose card names no range lies within +-`boundless`.
        """
        if order is None:
            order = tuple(schedule.name for schedule in self.outside)
        period = parameter_number(period, "period")
        if not period > 0:
            raise ParameterError(
                f"period = {period:g} s is no time from sample to sample; pass a positive one."
            )
        # One row of the core's table holds all weights of a set, in this order.
        rows = [
            self.polynomial,
            self.stop_weights,
            self.path_weights,
            self.creep_weights,
            self.viscous[:, None],
        ]
        source = []
        for schedule in self.schedules:
            source.append(order.index(schedule.name) if schedule.outside else -1)
        # The share of its distance that a lag of creep makes up in one period.
        gain = -np.expm1(-period / self.time_constants)
        return (
            np.array(self.radii),
            np.array(self.path_lengths),
            gain,
            np.ascontiguousarray(np.concatenate(rows, axis=1)).ravel(),
            self.groups,
            np.array(source, np.int64),
            np.array([schedule.low for schedule in self.schedules], float),
            np.array([schedule.high for schedule in self.schedules], float),
            np.array([self.center, *_range(self.card.output.low, self.card.output.high, 0.0, boundless),
                      *_range(self.card.input.low, self.card.input.high, 1.0, boundless)]),
            self.polynomial.shape[1],
            len(GROUPS),
            DIRECT_PASTS.index(self.past),
        )  # fmt: skip

    def machine(
        self,
        direction: Direction,
        range: tuple[float, float] | None,
        ramp: int,
        period: float | None,
    ) -> Machine:
        return direct_machine(self, direction, range, ramp, period)

    @property
    def period(self) -> float:  # type: ignore[override]
        """Median time between samples of the log that it was identified from; 0 where unknown. [s]"""
        return float(self.card.provenance.get("settings", {}).get("period", 0.0))

    def core_stepper(self, period: float) -> DirectStepper:
        """Return the step of exported code, for samples `period` apart: ``step(y, rate, first, second, third)``
        answers u.

        `first`, `second` and `third` are the scheduling variables from outside in the order of `outside`. `inverse` has
        the step of every model, which takes the rate from the samples.

        It begins at the first sample that it accepts, with the past of the model, as `run` does; ``step.reset(y)``
        begins at y. A sample that is not finite is rejected: the last answer is held and nothing moves, `step.rejected`
        says so, and `step.rejected_ever` that there was one. `step.save()` returns the state, ``step.restore(image)``
        goes on from it, to the bit; images of another model or another period are refused.

        Examples
        --------
        >>> step = DirectInverse(radii=[0.5], stop_weights=[2.0], polynomial=[0.0, 1.0]).core_stepper(1e-3)
        >>> step(0.0), step(1.0), step(0.0)
        (0.0, 2.0, -1.0)
        """
        return DirectStepper(self.parameters(period))

    def stepper(self, period: float | None = None) -> Any:
        """Return nothing: an input is solved for its output along a whole signal, with `simulate`.

        Raises
        ------
        ParameterError
            Always.
        """
        raise ParameterError(
            "a direct inverse has no step from input to output: it was identified the other way round and is solved "
            "along a whole signal, model.simulate(x, time). What runs sample by sample is model.inverse().stepper()."
        )

    def simulate(
        self, x: npt.ArrayLike, time: npt.ArrayLike | None = None, **signals: npt.ArrayLike
    ) -> Array:
        """Return the output (T,) for an input (T,): the one that needs that input, solved sample by sample. [y]

        It is looked for within the card's range and 10 % beyond, and stands at the end of that where there is none;
        `lost` counts such samples. The rate of the output is its difference from the sample before.

        Raises
        ------
        ParameterError
            If the card names no range of the output, time or a scheduling signal is missing, or lengths differ.

        Examples
        --------
        >>> from dehyst.models import SignalCard
        >>> card = ModelCard(SignalCard("u", low=-9.0, high=9.0), SignalCard("y", low=-3.0, high=3.0))
        >>> model = DirectInverse(radii=[0.5], stop_weights=[2.0], polynomial=[0.0, 1.0], card=card)
        >>> model.simulate([0.0, 2.0, -2.0]).round(9).tolist()
        [0.0, 1.0, -1.0]
        """
        u = signal_array(x, "input x")
        scheduling = self.given(signals, u.size)
        if not u.size:
            return NONE
        stamps = self._stamps(time, u.size)
        return follow(self, u, stamps, scheduling, self.past).y

    def lost(self, y: Array) -> int:
        """Return at how many samples of a simulated output (T,) none within reach needs the input.

        Examples
        --------
        >>> from dehyst.models import SignalCard
        >>> card = ModelCard(SignalCard("u"), SignalCard("y", low=-1.0, high=1.0))
        >>> model = DirectInverse(polynomial=[0.0, 1.0], card=card)
        >>> model.lost(model.simulate([0.0, 9.0]))
        1
        """
        # Without a range there is no end at which an output could stand.
        low, high = self.card.output.low, self.card.output.high
        if low is None or high is None:
            return 0
        reach = POLICY.followed_beyond * (high - low)
        return int(np.count_nonzero((y <= low - reach) | (y >= high + reach)))

    def compensator(self) -> Self:
        """Return itself: the controller runs what was identified."""
        return self

    def inverse(self) -> DirectDemand:
        """Return what was identified: the input that an output needs."""
        return DirectDemand(self)

    def _stamps(self, time: npt.ArrayLike | None, size: int) -> Array:
        if time is None and self.rate_dependent:
            raise ParameterError(
                "this direct inverse depends on time (creep or rate), but no time is given. Pass time, one stamp [s] "
                "a sample."
            )
        # Without creep and rate only the order of the samples counts.
        stamps = np.arange(size, dtype=np.float64)
        if time is not None:
            stamps = signal_array(time, "time")
        if stamps.size != size:
            raise ParameterError(
                f"{size} samples but {stamps.size} times; pass one of each a sample."
            )
        return stamps

    def run(
        self,
        y: npt.ArrayLike,
        time: npt.ArrayLike,
        rate: npt.ArrayLike | None = None,
        given: Mapping[str, npt.ArrayLike] | None = None,
        restart: npt.ArrayLike | None = None,
    ) -> DirectRun:
        """Return u along an output signal, beginning at its first sample with the model's past, with doubt and parts.

        Parameters
        ----------
        y
            Output samples, (T,). [y]
        time
            Their times, (T,), not decreasing. [s]
        rate
            dy/dt, (T,); None: from y, by central differences of its finite samples within each segment. [y/s]
        given
            Scheduling variables from outside by name, (T,) or a number each.
        restart
            (T,) true where a new segment begins, after a gap: memory begins anew there. None: nowhere.

        Raises
        ------
        ParameterError
            If lengths differ, time runs backwards, or a scheduling variable is missing.

        Warns
        -----
        RejectedSamplesWarning
            If samples were rejected because a number in them is not finite, with their number: the last answer is held
            for them, and the memory does not move.
        """
        q = signal_array(y, "y")
        t = signal_array(time, "time")
        if t.size != q.size:
            raise ParameterError(
                f"{q.size} samples of y but {t.size} times; pass one of each a sample."
            )
        begins = np.zeros(q.size, np.int64)
        if restart is not None:
            begins = np.asarray(restart).astype(np.int64)
        if q.size == 0:
            return DirectRun(NONE, NONE, np.zeros((0, len(GROUPS))))
        # Time may begin anew after a gap, but nowhere else.
        back = np.flatnonzero((np.diff(t) < 0) & (begins[1:] == 0))
        if back.size:
            raise ParameterError(
                f"time runs backwards at sample {back[0] + 1}: {t[back[0]]:g} s, {t[back[0] + 1]:g} s."
            )
        v = polynomial_slopes(q, t, begins) if rate is None else signal_array(rate, "rate")
        # The stepper takes the time of each sample, so that the period it is made for does not matter.
        step = DirectStepper(self.parameters(1.0))
        scheduling = self._scheduling(given or {}, q.size)
        table, rejected = step.simulate(q, v, t, scheduling, begins, np.array(self.time_constants))
        if rejected:
            warnings.warn(
                f"{rejected} of {q.size} samples are not finite (or beyond {_native.INPUT_LIMIT:g}); the last good "
                f"answer was held for them and the memory did not move. Clean the output, or read it with "
                f"dehyst.read_signal.",
                RejectedSamplesWarning,
                stacklevel=2,
            )
        return DirectRun(table[:, 0].copy(), table[:, 1].copy(), table[:, 2:].copy())

    def _scheduling(self, signals: Mapping[str, npt.ArrayLike], size: int) -> Array:
        """Return the variables from outside as the core takes them: three columns, used or not."""
        table = np.zeros((size, _native.DIRECT_GIVEN))
        for column, schedule in enumerate(self.outside):
            if schedule.name not in signals:
                raise ParameterError(
                    f"the model depends on '{schedule.name}', which was not given. Pass given={{'{schedule.name}': "
                    f"values}}, within {schedule.low:g} to {schedule.high:g} {schedule.unit}."
                )
            table[:, column] = np.broadcast_to(np.asarray(signals[schedule.name], float), size)
        return table


class DirectDemand(Inverted[DirectInverse]):
    """The input that an output needs, as a direct inverse was identified; made by ``model.inverse()``."""

    direction = "inverse"
    bounded = True
    closeness = float("inf")

    @property
    def no_inverse(self) -> str:
        """Why an input does not tell its output."""
        return self.of.no_forward

    def simulate(
        self, x: npt.ArrayLike, time: npt.ArrayLike | None = None, **signals: npt.ArrayLike
    ) -> Array:
        """Return the input (T,) that an output (T,) needs; its rate by central differences.

        Raises
        ------
        ParameterError
            As `DirectInverse.run`.
        """
        return self._run(x, time, signals).u

    def _run(
        self, y: npt.ArrayLike, time: npt.ArrayLike | None, signals: Mapping[str, npt.ArrayLike]
    ) -> DirectRun:
        values = signal_array(y, "y")
        stamps = self.of._stamps(time, values.size)
        return self.of.run(values, stamps, given=self.of.given(signals, values.size))

    def band(
        self,
        x: npt.ArrayLike,
        time: npt.ArrayLike | None = None,
        past: tuple[float, float] | None = None,
        **signals: npt.ArrayLike,
    ) -> Band:
        """Return what may be needed after any past: u and its doubt.

        Raises
        ------
        ParameterError
            If a past range is given.
        """
        if past is not None:
            raise ParameterError(
                "--past does not go with a direct inverse, whose stops begin with any past. Leave it out: the band is "
                "the wider one."
            )
        run = DirectDemand(self.of.with_past(UNKNOWN))._run(x, time, signals)
        # The doubt never grows; the largest one stands for a memory of which nothing is known.
        certainty = 1.0 - run.doubt / max(float(run.doubt.max(initial=0.0)), 1e-300)
        return Band(run.u, run.u - run.doubt, run.u + run.doubt, run.doubt, certainty)

    def stepper(self, period: float | None = None) -> DirectSteps:
        return DirectSteps(self.of, period)


class DirectSteps(Steps):
    """A direct inverse as a function of one sample; the rate is the difference from the sample before.

    Examples
    --------
    >>> step = DirectInverse(radii=[0.5], stop_weights=[2.0], polynomial=[0.0, 1.0]).inverse().stepper()
    >>> step(0.0), step(1.0, 0.01), step(0.0, 0.01), step.output
    (0.0, 2.0, -1.0, -1.0)
    """

    def __init__(self, model: DirectInverse, period: float | None = None) -> None:
        super().__init__(model, period)
        self._model = model
        self._taus = np.array(model.time_constants)
        self.reset()

    def reset(self) -> None:
        """Forget everything; the next sample is the first."""
        # The period does not matter, as each step says how much time has passed.
        self._step = DirectStepper(self._model.parameters(1.0))
        self._last: float | None = None
        self.output = 0.0

    def __call__(self, value: float, period: float | None = None, **signals: float) -> float:
        """Return u for the next sample of y, `period` [s] after the one before."""
        scheduling: Sequence[float] = ()
        if signals or self._needs:
            scheduling = self._scheduling(signals)
        rate = passed = 0.0
        if self._last is not None:
            passed = self._passed(period)
            # Two samples at one time have no rate.
            if passed > 0.0:
                rate = (value - self._last) / passed
        self.output = self._step.advance(value, rate, passed, self._taus, *scheduling)
        # A rejected sample is no place from which a rate can be counted.
        if not self._step.rejected:
            self._last = value
        return self.output

    def _scheduling(self, signals: Mapping[str, float]) -> Sequence[float]:
        try:
            if len(signals) == len(self._needs):
                return [float(signals[name]) for name in self._needs]
        except (KeyError, TypeError, ValueError):
            pass  # the call below raises, with a message
        # Slower, but it says which signal is missing or not known.
        values = self._model.given(signals, 1)
        return [float(values[name][0]) for name in self._needs]


def _derivative(coefficients: Array, x: Array) -> Array:
    polynomial = np.polynomial.polynomial
    return np.asarray(polynomial.polyval(x, polynomial.polyder(coefficients)))


def polynomial_slopes(y: Array, time: Array, restart: npt.NDArray[np.int64]) -> Array:
    """Return dy/dt (T,) by central differences within each segment, 0 where times repeat or y is not finite. [y/s]"""
    slopes = np.zeros(y.size)
    edges = [0, *np.flatnonzero(restart[1:]) + 1, y.size]
    for a, b in itertools.pairwise(edges):
        # Differences reach over samples that the core would reject.
        k = a + np.flatnonzero(np.abs(y[a:b]) <= _native.INPUT_LIMIT)
        if k.size > 1:
            before, after = np.concatenate([k[:1], k[:-1]]), np.concatenate([k[1:], k[-1:]])
            span = time[after] - time[before]
            rise = y[after] - y[before]
            slopes[k] = np.divide(rise, span, out=np.zeros(k.size), where=span > 0)
    return slopes


def _range(
    low: float | None, high: float | None, more: float, boundless: float
) -> tuple[float, float]:
    """Return the range of a card, wider by `more` of its width on both sides; without a range a boundless one."""
    if low is None or high is None or not low < high:
        return -boundless, boundless
    return low - more * (high - low), high + more * (high - low)


def _scale(values: npt.ArrayLike, name: str) -> Array:
    if np.size(values) == 0:
        return NONE
    array = parameter_array(values, name)
    strictly_increasing(array, name)
    if not array[0] > 0:
        raise ParameterError(f"{name}[0] = {array[0]:g} must be positive; leave that term out.")
    return array


def _table(values: npt.ArrayLike, sets: int, columns: int, name: str) -> Array:
    """Return values as a read-only table (sets, columns), or refuse them with the reason."""
    if columns == 0 and np.size(values) == 0:
        return np.zeros((sets, 0))
    array = np.array(parameter_array(np.ravel(np.asarray(values)), name))
    if array.size != sets * columns:
        raise ParameterError(
            f"{name} has shape {np.shape(values)}; with {sets} set{'s' if sets > 1 else ''} of weights pass "
            f"({sets}, {columns}).",
            shape=np.shape(values),
        )
    table = array.reshape(sets, columns)
    table.flags.writeable = False
    return table


def _not_negative(table: Array, name: str) -> Array:
    if (table < 0).any():
        raise ParameterError(
            f"{name} has a negative weight, {table.min():g}: such a term would drive the motion that it should oppose, "
            f"and u might not rise with y. Pass weights >= 0."
        )
    return table


def _check_schedules(schedules: tuple[Schedule, ...]) -> None:
    names = [schedule.name for schedule in schedules]
    if len(names) > _native.DIRECT_SCHEDULES or len(set(names)) < len(names):
        raise ParameterError(
            f"schedules {names}: at most {_native.DIRECT_SCHEDULES} with different names. Leave out those that change "
            f"the loop least."
        )
