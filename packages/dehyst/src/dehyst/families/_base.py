"""Base class of hysteresis families: simulate, identify, and invert where an inverse exists."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, fields, replace
from functools import partial
from math import isfinite
from typing import Any, ClassVar, Self

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.errors import ParameterError
from dehyst.families._inversion import first_input, search_inputs
from dehyst.models import Model
from dehyst.models import kit as models_kit

STARTS = ("zero", "rest", "rising", "falling", "origin")
PRELUDE = 64  # samples of a stroke before the first sample
SMALLEST_SCALE = 1e-100


@dataclass(frozen=True)
class Scaling:
    """From the units of a log to those of a family's formulas: u = (x - center)/half_range, y = level + amplitude f.

    Attributes
    ----------
    center, half_range
        Of the input; the identified range is -1..1. [input]
    level, amplitude
        Of the output; a negative amplitude is that of a falling curve. [output]

    Raises
    ------
    ParameterError
        If one is no finite number of physical size, or `half_range` or `amplitude` is 0.

    Examples
    --------
    >>> Scaling(center=2.0, half_range=4.0).inward(6.0)
    1.0
    """

    center: float = 0.0
    half_range: float = 1.0
    level: float = 0.0
    amplitude: float = 1.0

    def __post_init__(self) -> None:
        """Refuse what would divide by zero or overflow."""
        for entry in fields(self):
            value = models_kit.parameter_number(getattr(self, entry.name), entry.name)
            if entry.name in ("half_range", "amplitude") and not abs(value) >= SMALLEST_SCALE:
                raise ParameterError(
                    f"{entry.name} = {value:g} of the scaling is 0 or next to it, so that every signal would be one "
                    f"point. Pass half the range of the signal.",
                    **{entry.name: value},
                )
            object.__setattr__(self, entry.name, value)

    def inward(self, x: Array | float) -> Array | float:
        """Scaled input."""
        return (x - self.center) / self.half_range

    def outward(self, f: Array) -> Array:
        """Output in the units of the log."""
        return np.asarray(self.level + self.amplitude * f)

    def swapped(self) -> Scaling:
        """Scaling of the inverse."""
        return Scaling(self.level, self.amplitude, self.center, self.half_range)


UNSCALED = Scaling()


class LoopModel(Model):
    """A frozen record of parameters with a formula y = f[x] that has a memory.

    A family derives a frozen dataclass from this class, gives it its parameters, and last the three fields ::

        scaling: Scaling = UNSCALED
        start: str = "rest"
        card: ModelCard = NO_CARD

    and then `rest`, `run`, `free_parameters`, `no_inverse` and, where there is a formula for it, `run_inverse`. In
    these input and output are the scaled ones; `simulate` does the rest.

    Attributes
    ----------
    family
        Name of the family.
    rate_dependent
        Whether the output depends on how fast the input moves, so that time stamps are needed.
    memory_grows
        Whether the memory is as long as what is remembered.
    """

    family: ClassVar[str] = ""
    rate_dependent: ClassVar[bool] = False
    memory_grows: ClassVar[bool] = False
    file_kind = "dehyst-family"
    scaling: Scaling
    # One of `STARTS`, or the memory itself, with which the model then runs on.
    start: str | tuple[float, ...]

    @abstractmethod
    def rest(self, x: float) -> Array:
        """Return the memory (m,) of an actuator that never moved from the scaled input x."""

    @abstractmethod
    def run(self, x: Array, dt: Array | None, memory: Array) -> tuple[Array, Array]:
        """Return the scaled outputs (T,) along scaled inputs, and the memory after them.

        Parameters
        ----------
        x
            Scaled inputs, (T,), finite.
        dt
            Time from the sample before, (T,); 0 is a move without effects of rate or time. None for families that
            are not rate dependent. [s]
        memory
            Before the first sample; not changed. Running in two parts with the memory handed over is the same as
            running once, bit for bit.
        """

    @property
    @abstractmethod
    def free_parameters(self) -> int:
        """Number of values that were, or can be, identified; zero weights do not count."""

    @property
    @abstractmethod
    def no_inverse(self) -> str:
        """Why there is no inverse, in one sentence; empty if there is one: the output strictly follows the input."""

    @property
    def ends(self) -> tuple[float, float]:
        """Ends of the range of the scaling. [input]"""
        s = self.scaling
        return s.center - abs(s.half_range), s.center + abs(s.half_range)

    @property
    def nonzero_weights(self) -> int:
        """Number of identified values."""
        return self.free_parameters

    @property
    def inverse_gain(self) -> float:
        """Largest slope of the inverse; not a number where no formula tells. [input/output]"""
        return float("nan")

    @classmethod
    def example(cls) -> Self:
        """Return a small model of this family, for tests and pictures."""
        return cls()

    def simulate(
        self, x: npt.ArrayLike, time: npt.ArrayLike | None = None, **signals: npt.ArrayLike
    ) -> Array:
        """Return the output (T,) for an input (T,), beginning in the model's start state. [output]

        Parameters
        ----------
        x
            Input, (T,). [input]
        time
            (T,), increasing; needed by families that depend on rate or time. [s]
        signals
            What `needs` names, (T,) or a number each.

        Raises
        ------
        ParameterError
            If a sample is not finite, or time is needed and missing, or does not increase; or if the output would
            not be finite.
        """
        inputs = self._finite(x, "input x")
        if not inputs.size:
            return inputs
        scaled = np.ascontiguousarray(self._scale().inward(inputs))
        more = self._more(signals, inputs.size)
        memory = self.before(float(scaled[0]), **more)
        outputs, _ = self.run(scaled, self._steps(time, inputs.size), memory, **more)
        return self._answer(self.scaling.outward(outputs))

    def inverse(self) -> InverseLoop:
        """Return what undoes this model: ``model.inverse().simulate(model.simulate(x))`` is x.

        Raises
        ------
        InvertibilityError
            If there is no inverse; the message says why.
        """
        if self.no_inverse:
            raise models_kit.without_inverse(self)
        return InverseLoop(self)

    def run_inverse(self, y: Array, dt: Array | None, memory: Array) -> tuple[Array, Array]:
        """Return the scaled inputs (T,) for scaled outputs, and the memory after them; sample by sample a search."""
        return search_inputs(self, y, dt, memory)

    def before(self, first: float, **more: Array) -> Array:
        """Return the memory on arrival at a first scaled input, as `start` says; `more` is what `run` takes beside it.

        "rest": never moved. "zero": went from rest in the middle of the range there; the memory after decaying
        oscillations. "origin": went there from rest at the log's input 0. "rising": went from the upper end of the
        range to the lower and came up; "falling" is the mirror image.
        """
        if isinstance(self.start, tuple):
            return self._remembered(self.start)
        if not isinstance(self.start, str) or self.start not in STARTS:
            raise ParameterError(f"start = {self.start!r:.60} is not one of {', '.join(STARTS)}.")
        if self.start == "rest":
            return self.rest(first)
        return self._stroke(*self.departure(), first)

    def departure(self) -> tuple[Array, float]:
        """Return the memory, and its scaled input, from where one stroke leads to the first sample; not for "rest"."""
        at = 0.0
        if self.start == "origin":
            at = float(self.scaling.inward(0.0))
        memory = self.rest(at)
        # Before it rises, the input went to the upper end of its range and to the lower one.
        strokes = {"rising": (1.0, -1.0), "falling": (-1.0, 1.0)}
        for turn in strokes.get(str(self.start), ()):
            memory = self._stroke(memory, at, turn)
            at = turn
        return memory, at

    def _remembered(self, start: tuple[float, ...]) -> Array:
        """Return the memory that the model was given, or refuse it."""
        memory = np.array(start, dtype=np.float64)
        size = self.rest(0.0).size
        if not self.memory_grows and memory.size != size:
            raise ParameterError(
                f"start has {memory.size} numbers, and the memory of this {self.family} model {size}. Take it from "
                f"model.after(input, output)."
            )
        return memory

    def moved(
        self, x: npt.ArrayLike, time: npt.ArrayLike | None = None, **signals: npt.ArrayLike
    ) -> Self:
        """Return the same model with the memory that an input leaves."""
        inputs = self._finite(x, "input x")
        scaled = np.ascontiguousarray(self._scale().inward(inputs))
        more = self._more(signals, inputs.size)
        memory = self.before(float(scaled[0]), **more)
        _, memory = self.run(scaled, self._steps(time, inputs.size), memory, **more)
        return replace(self, start=tuple(memory.tolist()))  # type: ignore[type-var]

    def _stroke(self, memory: Array, at: float, turn: float) -> Array:
        way = np.linspace(at, turn, PRELUDE + 1)[1:]
        dt = np.zeros(PRELUDE) if self.rate_dependent else None
        return self.run(way, dt, memory)[1]

    def with_start(self, start: str) -> Self:
        """Return the same model that begins in another state, one of `STARTS`."""
        return replace(self, start=start)  # type: ignore[type-var]

    def at_rest(self, first: float) -> Self:
        """Return the same model that begins as if it had never moved from its first input."""
        return self.with_start("rest")

    def after_strokes(self, first: float, rising: bool) -> Self:
        """Return the same model that begins after strokes over its range, the last one rising or falling."""
        # With a negative half range the scaled input falls while the input rises.
        same_side = rising is (self._scale().half_range > 0.0)
        return self.with_start("rising" if same_side else "falling")

    def file_parameters(self) -> dict[str, Any]:
        """Return parameters, scaling and start, as they stand in a model file."""
        return {"values": self.parameters(), "scaling": asdict(self.scaling), "start": self.start}

    def stepper(self, period: float | None = None) -> models_kit.Steps:
        return self.steps(False, period)

    def steps(self, inverse: bool, period: float | None) -> models_kit.Steps:
        """Return the model, or its inverse, as a function of one sample."""
        if inverse:
            first = partial(first_input, self)
            return LoopStepper(self, self.run_inverse, self.scaling.swapped(), first, period)
        return LoopStepper(self, self.run, self.scaling, same_input, period)

    def parameters(self) -> dict[str, Any]:
        """Return the parameters by name, plain values; scaling, start and card left out."""
        parameters = {}
        for entry in fields(self):  # type: ignore[arg-type]
            value = getattr(self, entry.name)
            if isinstance(value, np.ndarray):
                value = value.tolist()
            if entry.name not in ("scaling", "start", "card"):
                parameters[entry.name] = value
        return parameters

    def __repr__(self) -> str:
        """One line: family, parameters, signals."""
        signals = f"{self.card.input!s} -> {self.card.output!s}"
        return (
            f"<{type(self).__name__} {self.family!r}: {self.free_parameters} parameters, {signals}>"
        )

    def _more(self, signals: Mapping[str, npt.ArrayLike], size: int) -> dict[str, Any]:
        """What `run` takes beside input and steps of time: nothing, but for models with schedules."""
        self.given(signals, size)
        return {}

    def _scale(self) -> Scaling:
        if isinstance(self.scaling, Scaling):
            return self.scaling
        raise ParameterError(
            f"scaling is a {type(self.scaling).__name__}; pass a dehyst.families.Scaling."
        )

    def _answer(self, values: Array) -> Array:
        bad = np.flatnonzero(~np.isfinite(values))
        if bad.size:
            low, high = self.ends
            raise ParameterError(
                f"this {self.family} model does not answer with finite numbers from sample {bad[0]} on: its parameters "
                f"let it diverge there. Identify it from data like this, or keep to its range, {low:g} .. {high:g} at "
                f"its input.",
                index=int(bad[0]),
            )
        return values

    def _finite(self, values: npt.ArrayLike, name: str) -> Array:
        signal = models_kit.signal_array(values, name)
        bad = np.flatnonzero(~np.isfinite(signal))
        if bad.size:
            raise ParameterError(
                f"{name} has {bad.size} samples that are not finite, the first at index {bad[0]}. The memory would "
                f"carry them into every later sample. Drop them, or read the log with dehyst.read_log.",
                index=int(bad[0]),
            )
        return signal

    def _steps(self, time: npt.ArrayLike | None, size: int) -> Array | None:
        if not self.rate_dependent:
            return None
        if time is None:
            raise ParameterError(
                f"a {self.family} model depends on how fast the input moves, but no time is given. Call "
                f"simulate(x, time) with one time stamp [s] a sample."
            )
        stamps = self._finite(time, "time")
        if stamps.size != size or np.any(np.diff(stamps) <= 0.0):
            raise ParameterError(
                f"time has {stamps.size} values for {size} samples, or does not increase; pass one time stamp [s] a "
                f"sample, in order."
            )
        return np.diff(stamps, prepend=stamps[:1])


def same_input(first: float, **more: Array) -> float:
    """The first input of a model that is given inputs."""
    return float(first)


class InverseLoop(models_kit.Inverted[LoopModel]):
    """The input that an output needs; made by ``model.inverse()``. The memory of both is the same."""

    @property
    def ends(self) -> tuple[float, float]:
        """Ends of the range of the scaling's output. [output]"""
        s = self.of.scaling
        return s.level - abs(s.amplitude), s.level + abs(s.amplitude)

    def after_strokes(self, first: float, rising: bool) -> Self:
        """Return the same that begins after strokes; on a falling curve a rising output needs a falling input."""
        same_side = rising is (self.of._scale().amplitude > 0.0)
        start = "rising" if same_side else "falling"
        return replace(self, of=self.of.with_start(start))  # type: ignore[arg-type]

    def simulate(
        self, x: npt.ArrayLike, time: npt.ArrayLike | None = None, **signals: npt.ArrayLike
    ) -> Array:
        """Return the inputs (T,) that the outputs (T,) need, from the model's start state on. [input]

        Raises
        ------
        ParameterError
            As `LoopModel.simulate`.
        """
        of = self.of
        outputs = of._finite(x, "output y")
        if not outputs.size:
            return outputs
        scaled = np.ascontiguousarray((outputs - of._scale().level) / of.scaling.amplitude)
        # The start is that of the model, so the input is needed that answers the first output.
        more = of._more(signals, outputs.size)
        memory = of.before(first_input(of, float(scaled[0]), **more), **more)
        inputs, _ = of.run_inverse(scaled, of._steps(time, outputs.size), memory, **more)
        return of._answer(np.asarray(of.scaling.center + of.scaling.half_range * inputs))

    def stepper(self, period: float | None = None) -> models_kit.Steps:
        return self.of.steps(True, period)


class LoopStepper(models_kit.Steps):
    """A model or an inverse as a function of one sample.

    Examples
    --------
    >>> from dehyst.families import example
    >>> step = example("dahl").stepper()
    >>> step(0.0), bool(step(0.5) == example("dahl").simulate([0.0, 0.5])[1])
    (0.0, True)
    """

    def __init__(
        self,
        model: LoopModel,
        run: Callable[..., tuple[Array, Array]],
        scaling: Scaling,
        first: Callable[..., float],
        period: float | None,
    ) -> None:
        super().__init__(model, period)
        self._model, self._run, self._first = model, run, first
        self._from, self._unit = scaling.center, scaling.half_range
        self._onto, self._size = scaling.level, scaling.amplitude
        self._value = np.zeros(1)
        self._dt = np.zeros(1) if model.rate_dependent else None
        self._memory: Array | None = None

    def reset(self) -> None:
        self._memory = None
        self.rejected = self.rejected_ever = False

    def save(self) -> Array:
        """Return an image of the state: output, flags and memory; `restore` continues from it bit for bit."""
        memory = np.zeros(0) if self._memory is None else self._memory
        return np.concatenate([[self.output, self.rejected, self.rejected_ever], memory])

    def restore(self, image: npt.ArrayLike) -> None:
        """Continue from a saved image.

        Raises
        ------
        ParameterError
            If it is none of this model; the state stays as it was.
        """
        values = np.asarray(image, dtype=np.float64)
        size = self._model.before(0.0).size
        # Three numbers alone are an image before the first sample, without a memory.
        fits = values.size in (3, 3 + size) or (self._model.memory_grows and values.size > 3)
        if values.ndim != 1 or not (fits and np.isfinite(values).all()):
            raise ParameterError(
                f"an image of shape {values.shape} is none of this {self._family} model, whose images hold {3 + size} "
                f"finite numbers. Restore what save() of a stepper of the same model returned."
            )
        # First what may refuse it.
        self._memory = values[3:].copy() if values.size > 3 else None
        self.output = float(values[0])
        self.rejected, self.rejected_ever = bool(values[1]), bool(values[2])

    def __call__(self, value: float, period: float | None = None, **signals: float) -> float:
        """Return the output for the next sample, `period` [s] after the one before."""
        self.rejected = not (isfinite(value) and all(map(isfinite, signals.values())))
        if self.rejected:
            # A sample that is no number changes nothing: the output holds its value.
            self.rejected_ever = True
            return self.output
        scaled = (value - self._from) / self._unit
        more = self._model._more(signals, 1) if signals or self._needs else {}
        passed = 0.0
        if self._memory is None:
            self._memory = self._model.before(self._first(scaled, **more), **more)
        else:
            passed = self._passed(period)
        self._value[0] = scaled
        if self._dt is not None:
            self._dt[0] = passed
        answer, self._memory = self._run(self._value, self._dt, self._memory, **more)
        self.output = float(self._onto + self._size * answer[0])
        return self.output
