"""Interface of every model, of any family, identified forward or as an inverse."""

from __future__ import annotations

import json
import os
import warnings
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Generic, NamedTuple, Self, TypeVar

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.errors import DehystError, InvertibilityError, ParameterError
from dehyst.models._arrays import parameter_number
from dehyst.models._card import ModelCard, SignalCard
from dehyst.models._machine import Direction, Machine
from dehyst.models._offset import following, offset_numbers, range_width
from dehyst.models._policy import POLICY
from dehyst.models._resonance import Resonance
from dehyst.models._storage import save_model

if TYPE_CHECKING:
    from dehyst.models._monotone import MonotoneMap
    from dehyst.models._prandtl_ishlinskii import PrandtlIshlinskii

M = TypeVar("M", bound="Model")


class Band(NamedTuple):
    """Answer of a model of whose past nothing is known.

    Attributes
    ----------
    middle
        (T,) what it answers.
    low, high
        (T,) ends of what it may answer after any past.
    half_width
        (T,) how far the answer may be off to either side.
    certainty
        (T,) how much of the memory is known: 0 for nothing, 1 once no past matters.
    """

    middle: Array
    low: Array
    high: Array
    half_width: Array
    certainty: Array


class WeightTable(NamedTuple):
    """Weights of the terms of one kind over their scale.

    Attributes
    ----------
    name, label, unit
        "stops", "radius r", and its unit.
    scale, weights
        (n,), (sets, n). [unit], [input/output]
    """

    name: str
    label: str
    unit: str
    scale: Array
    weights: Array


class Model(ABC):
    """A frozen relation between the two signals of a card, with a memory: from its input to its output.

    `simulate` answers the card's output for its input, for every model: also for one that was identified the other way
    round, which is solved for it. `inverse` is the model from output to input, with the card's signals exchanged.

    Attributes
    ----------
    card
        Signals and provenance.
    direction
        "forward": identified from input to output. "inverse": from output to input.
    rate_dependent
        Whether the answer depends on time, so that time stamps are needed.
    context
        Scheduling signals that `simulate` must be given beside its input; `needs` are their names.
    bounded
        Whether the memory is bounded, so that `band` holds the answer after any past, and no past exceeds it.
    core
        Which of the core's machines runs it on a target, "" for none: "plays", "direct" or "elements". Controllers of
        joints know the first two.
    closeness
        How close the model comes to its input by way of its inverse, share of range; infinite where both take rates
        from samples in their own way.
    judged_backward
        Whether it is judged as its compensator, from output to input.
    shear
        k of a loop that was sheared before it was identified, else None. [input/output]
    period
        Median time between samples of the log, for what runs sample by sample; 0 where unknown. [s]
    dead_time
        By which the output is late in the model. [s]
    winged
        Whether it is a butterfly, with an inverse on either `wing` and none on both.
    resonance
        At which the actuator rings behind the loop, for what shapes its reference; None where none is known. What the
        model simulates does not ring.
    """

    card: ModelCard
    direction: str = "forward"
    bounded: ClassVar[bool] = False
    closeness: ClassVar[float] = 1e-6
    judged_backward: ClassVar[bool] = False
    shear: float | None = None
    period: float = 0.0
    dead_time: float = 0.0
    resonance: Resonance | None = None
    winged: bool = False
    file_kind: ClassVar[str] = "dehyst-model"
    core: ClassVar[str] = ""

    @property
    @abstractmethod
    def family(self) -> str:
        """Name of the family."""

    @property
    def rate_dependent(self) -> bool:
        """Whether time stamps are needed."""
        return False

    @property
    def context(self) -> tuple[SignalCard, ...]:
        """Scheduling signals with unit and range."""
        return ()

    @property
    def needs(self) -> tuple[str, ...]:
        """Names of the scheduling signals."""
        return tuple(card.name for card in self.context)

    @property
    def wing_to_type(self) -> dict[str, str]:
        """The option of `dehyst compensate` that a butterfly needs, as `command` takes it; {} for other models."""
        return {"wing": "upper"} if self.winged else {}

    @property
    def no_inverse(self) -> str:
        """Why there is no inverse, in one sentence; empty if there is one."""
        return _fault_of(self.inverse)

    @property
    def no_forward(self) -> str:
        """Why the input alone does not decide the output, in one sentence; empty if it does."""
        return ""

    @property
    def unit_needs(self) -> tuple[str, ...]:
        """Further inputs of the unit that runs it on a target."""
        return self.needs

    @property
    def no_export(self) -> str:
        """Why no target can run it, in one sentence; empty if one can."""
        # Only what one of the core's machines runs can be exported.
        if self.core:
            return ""
        return (
            f"a {self.family} model runs in Python alone, with `dehyst simulate` and `dehyst compensate`. For a target "
            f"identify the same log again without --family: `dehyst identify LOG` chooses among sums of elements, "
            f"which run everywhere."
        )

    @property
    @abstractmethod
    def nonzero_weights(self) -> int:
        """Number of terms that carry weight."""

    @property
    def free_parameters(self) -> int:
        """Number of identified values; zero weights do not count."""
        points = 0
        for mapping in self.maps:
            if mapping is not None:
                points += mapping.v.size
        # Without a map there is an offset.
        return self.nonzero_weights + (points or 1)

    @property
    def remarks(self) -> tuple[str, ...]:
        """What only this kind of model says of itself, a few words each."""
        return ()

    @property
    def kinds(self) -> tuple[str, ...]:
        """Kinds of elements that it is made of; the name of its family where it is no sum of elements."""
        return (self.family,)

    @property
    def weight_tables(self) -> tuple[WeightTable, ...]:
        """Weights of its terms by their scale, of a model that is no sum of plays."""
        return ()

    @property
    def play_core(self) -> PrandtlIshlinskii | None:
        """The sum of plays inside, maps and a shear left out; None for a model that is no such sum."""
        return None

    @property
    def operators(self) -> tuple[str, Array, float | None]:
        """Kind of its operators, "play" or "stop", a weight for each of `play_core`, and the slope beside stops."""
        return "play", np.zeros(0), None

    @property
    def maps(self) -> tuple[MonotoneMap | None, MonotoneMap | None]:
        """Maps before and after the operators."""
        return None, None

    @property
    def parts(self) -> tuple[int, str]:
        """Number and name of the parts that `core` runs it by."""
        return 0, "parts"

    @abstractmethod
    def simulate(
        self, x: npt.ArrayLike, time: npt.ArrayLike | None = None, **signals: npt.ArrayLike
    ) -> Array:
        """Return the output (T,) for an input (T,), from the model's start state on. [output]

        Parameters
        ----------
        x
            Input, (T,). [input]
        time
            (T,), increasing; needed where `rate_dependent`. [s]
        signals
            What `needs` names, (T,) or a number each.
        """

    def simulate_following(
        self,
        x: npt.ArrayLike,
        measured: npt.ArrayLike,
        limit: float,
        time: npt.ArrayLike | None = None,
        **signals: npt.ArrayLike,
    ) -> Array:
        """Return the output (T,) with an offset that follows the last cycle of what was measured. [output]

        The same as a forward `Block` with `follow_offset`. No sample depends on a measurement of its own or later.

        Parameters
        ----------
        x, measured
            Input and measured output, (T,); NaN: nothing was measured. [input], [output]
        limit
            Of the offset, a share of the output's identified range, above 0 and at most 0.5.
        time, signals
            As in `simulate`.
        """
        answers = self.simulate(x, time, **signals)
        height, width = range_width(self.card.output, answers), range_width(self.card.input, x)
        return following(x, answers, measured, offset_numbers(limit, height, width))

    def machine(
        self,
        direction: Direction,
        range: tuple[float, float] | None,
        ramp: int,
        period: float | None,
    ) -> Machine:
        """Return the core's block that runs the model, or its inverse, on a machine; `dehyst.block` wraps it."""
        raise ParameterError(self.no_export)

    def wing(self, side: str, outputs: npt.ArrayLike | None = None) -> Model:
        """Return one wing of a butterfly loop, "upper" or "lower"; for other models there is none.

        Raises
        ------
        ParameterError
            If the model has no wings.
        """
        raise ParameterError(
            f"this {self.family} model is no butterfly and has no wings. Leave the wing (--wing) out."
        )

    @abstractmethod
    def inverse(self) -> Model:
        """Return the model from output to input, its start state included."""

    @property
    def ends(self) -> tuple[float, float]:
        """Ends of the identified range of the input; -1 and 1 where the card names none. [input]"""
        low, high = self.card.input.low, self.card.input.high
        if low is None or high is None:
            return -1.0, 1.0
        return float(low), float(high)

    @property
    def usual_past(self) -> tuple[float, float] | None:
        """Range that the input is taken not to have left before, where `band` knows what follows. [input]"""
        return None

    @property
    def prompt(self) -> Self:
        """The same without dead time; itself where there is none."""
        return self

    def ahead(self, demand: Array, time: npt.ArrayLike | None = None) -> Array:
        """Return what the inverse asks for along an output (T,), earlier by the dead time: when it has to be sent.

        Parameters
        ----------
        demand
            Of the inverse, (T,); the last value is held. [input]
        time
            (T,), increasing; without it the samples have the period of the log. [s]
        """
        return demand

    def lead(self, period: float) -> float:
        """Return how long before its time a unit of a period [s] wants its reference: dead time, and its shaper. [s]"""
        lead = self.dead_time
        if self.resonance is not None and self.resonance.samples(period):
            lead += self.resonance.lead
        return lead

    def shaped(self, reference: Array, time: npt.ArrayLike | None = None) -> Array:
        """Return a reference (T,) that does not ring the actuator, and is not late: what to give the inverse.

        Parameters
        ----------
        reference
            (T,), as it is wanted; itself where the model knows no resonance. [output]
        time
            (T,), increasing; without it the samples have the period of the log. [s]
        """
        if self.resonance is None:
            return reference
        if time is None:
            time = self.period * np.arange(reference.size, dtype=np.float64)
        return self.resonance.shaped(reference, time)

    def lost(self, y: Array) -> int:
        """Return at how many samples of a simulated output (T,) the model had none for its input."""
        return 0

    def too_slow(self, period: float) -> str:
        """Why a period [s] is too long for what the log knows of time, and what to type; empty if it is not."""
        # Without a known period of the log nothing can be said.
        if not self.rate_dependent or not 0.0 < POLICY.too_slow * self.period < period:
            return ""
        return (
            f"a period of {period:g} s is {period / self.period:.3g} times that of the log, {self.period:g} s: this "
            f"{self.family} model depends on time, and what happens within a period is lost. Give it in seconds: "
            f"{self.period:g}, or less."
        )

    @abstractmethod
    def stepper(self, period: float | None = None) -> Any:
        """Return the model as a function of one sample, ``step(x)``.

        Parameters
        ----------
        period
            Between two samples, for models that depend on time; ``step(x, seconds)`` overrules it for one sample.
            None takes that of the log. [s]
        """

    def compensator(self) -> Model:
        """Return what is given to a controller: the inverse; of a direct inverse itself."""
        return self.inverse()

    def with_card(self, card: ModelCard) -> Self:
        """Return the same model with another description of its signals."""
        return replace(self, card=card)  # type: ignore[type-var]

    @abstractmethod
    def at_rest(self, first: float) -> Self:
        """Return the same model as if it had been at rest at a first input since ever."""

    @abstractmethod
    def after_strokes(self, first: float, rising: bool) -> Self:
        """Return the same model after strokes over its whole range, the last one rising or falling to a first input."""

    def moved(
        self, x: npt.ArrayLike, time: npt.ArrayLike | None = None, **signals: npt.ArrayLike
    ) -> Model | None:
        """Return the same model with the memory that an input leaves; None where memory is of what was measured."""
        return None

    def after(
        self,
        x: npt.ArrayLike,
        y: npt.ArrayLike | None = None,
        time: npt.ArrayLike | None = None,
        **signals: npt.ArrayLike,
    ) -> Self:
        """Return the same model that runs on after samples of input and measured output.

        Its memory is the one that agrees best with them, whatever the actuator did before. `simulate`, `inverse` and
        `stepper` begin with it; `dehyst.models.kit.known_past` tells in addition how well it agrees, and what is left
        open.

        Parameters
        ----------
        x, y
            Input and output, (T,), one sample or more, y NaN where it is not known; without y the memory of the model
            is moved along the input. [input], [output]
        time, signals
            As of `simulate`.

        Raises
        ------
        ParameterError
            If the samples do not fit together, or the memory is of what was measured.

        Examples
        --------
        >>> from dehyst.families import example
        >>> model = example("play-sum")
        >>> y = model.simulate([0.0, 1.0, -1.0, 0.5, 0.2, 0.8])
        >>> begun = model.after([-1.0, 0.5, 0.2], y[2:5])
        >>> bool(abs(begun.simulate([0.8])[0] - y[5]) < 1e-9)
        True
        """
        from dehyst.models._known import known_past

        return known_past(self, x, y, time, signals).model

    @abstractmethod
    def file_parameters(self) -> dict[str, Any]:
        """Return the parameters as plain JSON values, as they stand in a model file."""

    def _content(self) -> str:
        """What a model file holds of the model, without where it came from."""
        signals = ((card.name, card.unit) for card in (self.card.input, self.card.output))
        # Sorted keys, so that equal models have equal texts.
        return json.dumps(
            [self.file_kind, self.family, self.direction, *signals, self.file_parameters()],
            sort_keys=True,
        )

    def __eq__(self, other: object) -> bool:
        """Whether both answer the same to the bit: same parameters, memory and signals, whatever log they are from."""
        if not isinstance(other, Model):
            return NotImplemented
        return self._content() == other._content()

    def __hash__(self) -> int:
        return hash(self._content())

    def pruned(self) -> Self:
        """Return the same model without terms of zero weight, which is exact; itself where there are none."""
        return self

    def replay(
        self,
        x: npt.ArrayLike,
        y: npt.ArrayLike,
        time: npt.ArrayLike | None = None,
        **signals: npt.ArrayLike,
    ) -> Array:
        """Return the output for an input that came from an output: as `simulate`, but for sheared loops that see y."""
        return self.simulate(x, time, **signals)

    def band(
        self,
        x: npt.ArrayLike,
        time: npt.ArrayLike | None = None,
        past: tuple[float, float] | None = None,
        **signals: npt.ArrayLike,
    ) -> Band:
        """Return where the output lies whatever the actuator did before the first sample.

        Where memory is not `bounded`, it holds what the model answers at rest, and after strokes over its whole range,
        the last one rising or falling. These are the extremes of a usual past; a stranger one may exceed them.

        Parameters
        ----------
        x, time
            As `simulate`.
        past
            Range (low, high) that the input has not left before; None: it may have been anywhere. [input]
        signals
            As `simulate`.

        Raises
        ------
        ParameterError
            If there is a range and memory is not bounded.

        Examples
        --------
        >>> from dehyst.families import example
        >>> band = example("creep-pi").band([0.0, 0.5], [0.0, 0.01])
        >>> bool(band.low[0] < band.middle[0] < band.high[0])
        True
        """
        if past is not None:
            raise ParameterError(
                f"a past within a range (--past) needs a model whose memory is bounded, as plays have (--family "
                f"modified-pi); this is {self.family}. Leave out --past: --start unknown takes strokes over the whole "
                f"range."
            )
        first = float(np.asarray(x, dtype=float)[0])
        pasts = (
            self.at_rest(first), self.after_strokes(first, True), self.after_strokes(first, False),
        )  # fmt: skip
        answers = [begun.simulate(x, time, **signals) for begun in pasts]
        low, high = np.min(answers, axis=0), np.max(answers, axis=0)
        width = high - low
        known = np.clip(1.0 - width / max(float(width[0]), 1e-300), 0.0, 1.0)
        return Band(
            0.5 * (low + high), low, high, 0.5 * width, np.asarray(np.maximum.accumulate(known))
        )

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write the model to a JSON file, atomically; `dehyst.load` reads it back bit for bit.

        Raises
        ------
        ParameterError
            If the file could not be read back, as that of a family that is not registered.
        OutputError
            If the file cannot be written. An earlier file of that name stays as it was.
        """
        return save_model(self, path)

    def given(self, signals: Mapping[str, npt.ArrayLike], size: int) -> dict[str, Array]:
        """Return the scheduling signals, (T,) each.

        Raises
        ------
        ParameterError
            If one is missing, not known, or of another length.
        """
        # Both are refused: a signal that the model needs, and one that it would not look at.
        missing = [name for name in self.needs if name not in signals]
        spare = [name for name in signals if name not in self.needs]
        if missing:
            raise ParameterError(
                f"the model depends on '{missing[0]}', which was not given. Pass {missing[0]}=values, one for each of "
                f"the {size} samples, or one number.",
                signal=missing[0],
            )
        if spare:
            raise ParameterError(
                f"this {self.family} model takes no '{spare[0]}'; it needs {', '.join(self.needs) or 'no signal'} "
                f"beside its input. Leave it out.",
                signal=spare[0],
            )
        arrays = {}
        try:
            for name, values in signals.items():
                array = np.asarray(values, dtype=np.float64)
                arrays[name] = np.ascontiguousarray(np.broadcast_to(array, (size,)))
            return arrays
        except (TypeError, ValueError) as fault:
            raise ParameterError(
                f"a scheduling signal is not one number a sample, ({size},): {fault}."
            ) from None


@dataclass(frozen=True, eq=False)
class Inverted(Model, Generic[M]):
    """The input that an output needs; made by ``model.inverse()``.

    Attributes
    ----------
    of
        The model that is read the other way round.
    """

    of: M

    @property
    def family(self) -> str:
        """Name of the family."""
        return self.of.family

    @property
    def card(self) -> ModelCard:  # type: ignore[override]
        """Signals, exchanged."""
        return self.of.card.swapped()

    @property
    def rate_dependent(self) -> bool:
        """Whether time stamps are needed."""
        return self.of.rate_dependent

    @property
    def context(self) -> tuple[SignalCard, ...]:
        """Scheduling signals."""
        return self.of.context

    @property
    def nonzero_weights(self) -> int:
        """Number of terms that carry weight."""
        return self.of.nonzero_weights

    def inverse(self) -> M:
        """Return the model."""
        return self.of

    def _content(self) -> str:
        return f"inverse of {self.of._content()}"

    def with_card(self, card: ModelCard) -> Self:
        """Return the same with other signals."""
        return replace(self, of=self.of.with_card(card.swapped()))

    def at_rest(self, first: float) -> Self:
        """Return the same that begins as if it had never moved, or after a homing."""
        return replace(self, of=self.of.at_rest(first))

    def after_strokes(self, first: float, rising: bool) -> Self:
        """Return the same after strokes over the whole range."""
        return replace(self, of=self.of.after_strokes(first, rising))

    def after(
        self,
        x: npt.ArrayLike,
        y: npt.ArrayLike | None = None,
        time: npt.ArrayLike | None = None,
        **signals: npt.ArrayLike,
    ) -> Self:
        """Return the same that runs on after samples of its own input and output: of the model's output and input.

        Raises
        ------
        ParameterError
            As `Model.after`; or without y, which moves the memory.
        """
        if y is None:
            raise ParameterError(
                "the memory of an inverse is moved by the input of its model. Give both: after(output, input)."
            )
        return replace(self, of=self.of.after(y, x, time, **signals))

    def pruned(self) -> Self:
        """Return the same without terms of zero weight."""
        return replace(self, of=self.of.pruned())

    def file_parameters(self) -> dict[str, Any]:
        """Refuse: the file is that of the model.

        Raises
        ------
        ParameterError
            Always.
        """
        raise ParameterError(
            "an inverse has no file of its own; save the model, .of, and invert it again."
        )


class Steps(ABC):
    """A model as a function of one sample, ``step(value, period, **signals)``; `reset` begins anew.

    Attributes
    ----------
    period
        Between two samples where a step does not say; 0 where unknown. [s]
    output
        Of the last sample.
    rejected, rejected_ever
        Whether the last sample, or any since the last reset, was no finite number: the output was held.
    """

    period: float
    output: float
    rejected: bool = False
    rejected_ever: bool = False

    def __init__(self, model: Model, period: float | None = None) -> None:
        self._needs, self._family, self._timed = model.needs, model.family, model.rate_dependent
        self.period = model.period if period is None else positive_period(period)
        self.output = 0.0
        if slow := model.too_slow(self.period):
            warnings.warn(slow, UserWarning, stacklevel=3)

    @abstractmethod
    def reset(self) -> None:
        """Forget everything; the next sample is the first."""

    @abstractmethod
    def __call__(self, value: float, period: float | None = None, **signals: float) -> float:
        """Return the output for the next sample, `period` [s] after the one before."""

    def _passed(self, period: float | None) -> float:
        """Time since the sample before, as told or as usual. [s]"""
        # What the call says counts; else the period that the stepper was made for.
        if period is not None:
            return float(period)
        if self._timed and not self.period:
            raise ParameterError(
                f"this {self._family} model depends on time, and nobody said how much passes between two samples. Call "
                f"model.stepper(period) with the period of your loop [s], or step(x, seconds)."
            )
        return self.period


def earlier(values: Array, time: Array, seconds: float) -> Array:
    """Return values (T,) moved to earlier times [s], (T,): between samples on a line, the last one held."""
    return np.asarray(np.interp(time + seconds, time, values))


def require_model(model: object, cure: str) -> Model:
    """Return the model.

    Raises
    ------
    ParameterError
        If it is none; `cure` says what to pass.
    """
    if isinstance(model, Model):
        return model
    raise ParameterError(
        f"a {type(model).__name__} is no model. Pass {cure}.", type=type(model).__name__
    )


def without_inverse(model: Model) -> InvertibilityError:
    """Return the refusal of an inverse that there is not."""
    return InvertibilityError(
        f"this {model.family} model has no inverse: {model.no_inverse}", family=model.family
    )


def positive_period(period: float) -> float:
    """Return a period in seconds, or refuse one that is none."""
    seconds = parameter_number(period, "period")
    if not seconds > 0.0:
        raise ParameterError(
            f"a period of {seconds:g} s is none; pass the time between two samples, above 0."
        )
    return seconds


def _fault_of(inverse: Any) -> str:
    """Return why an inverse cannot be made; empty if it can."""
    try:
        inverse()
    except DehystError as fault:
        return str(fault)
    return ""
