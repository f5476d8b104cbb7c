"""What every function block of a machine has: signals with limits, switching, flags, scheduling variables, images."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, ClassVar, Generic, Literal, TypeAlias, TypeVar

import numpy as np
import numpy.typing as npt

from dehyst import _native
from dehyst.arrays import Array
from dehyst.control.images import Words, refuse, words_of
from dehyst.errors import ParameterError
from dehyst.models import Model
from dehyst.models.arrays import parameter_number, signal_array
from dehyst.models.card import SignalCard

Direction: TypeAlias = Literal["inverse", "forward"]
N = TypeVar("N", bound="_native._Machine")
S = TypeVar("S", bound="_native._SavedMachine")

BLOCK_FLAGS: Mapping[str, int] = MappingProxyType(
    {
        "rejected": _native.BLOCK_REJECTED,
        "rejected-ever": _native.BLOCK_REJECTED_EVER,
        "limited": _native.BLOCK_LIMITED,
        "limited-ever": _native.BLOCK_LIMITED_EVER,
    }
)
"""Bits of a block's flags by name; those with "ever" stay until a reset."""

LONGEST_RAMP = 10**9


class MachineBlock(ABC, Generic[N]):
    """A function block of a machine around one of the core's.

    Parameters
    ----------
    native
        The core's block.
    input, output
        Signals with limits.
    given
        Names of the scheduling variables from outside, in their order.
    """

    model: Any
    direction: Direction = "inverse"
    period: float = 0.0  # between two samples, of a block that depends on time [s]
    takes_given: ClassVar[bool] = True
    leading: ClassVar[tuple[str, ...]] = ("x",)

    def __init__(self, native: N, input: SignalCard, output: SignalCard, given: tuple[str, ...] = ()) -> None:
        self._native = native
        self._signals = input, output
        self.given = given

    @property
    def input(self) -> SignalCard:
        """Name, unit and limits of what goes in."""
        return self._signals[0]

    @property
    def output(self) -> SignalCard:
        """Name, unit and limits of what comes out."""
        return self._signals[1]

    @property
    def share(self) -> float:
        """Present share of the model in the output: 0 off, 1 on."""
        return self._native.share

    @property
    def last(self) -> float:
        """Last good output; before the first sample that of the start. [output]"""
        return self._native.output

    @property
    def flags(self) -> int:
        """Sum of the bits in `BLOCK_FLAGS` after the last sample."""
        return self._native.flags

    @abstractmethod
    def run(self, *args: Any, **kwargs: Any) -> tuple[Array, Words]:
        """Return outputs and flags (T,) of many samples, going on from the present state."""

    def answer(self, inputs: Array, on: npt.ArrayLike) -> tuple[Array, Words]:
        """Return outputs and flags (T,) for all inputs in their order, those of `given` last, (T, m)."""
        own = inputs.shape[1] - len(self.given)
        given = {"given": dict(zip(self.given, inputs.T[own:], strict=True))} if self.given else {}
        return self.run(*inputs.T[:own], on=np.asarray(on) != 0, **given)

    def reset(self) -> None:
        """Return to the start, flags cleared; the next good sample begins there and switches at once."""
        self._native.reset()

    def _sample(self, given: Mapping[str, float] | None, on: bool, *values: float | None) -> tuple[Any, ...]:
        """The numbers of one sample, those of two scheduling variables, and the switch; NaN for no answer."""
        told = self._told(given)
        try:
            found = [float("nan") if v is None else float(v) for v in (*values, *(told[name] for name in self.given))]
        except (TypeError, ValueError, OverflowError):
            raise ParameterError(
                "a sample is one number each, or None for a sensor without an answer. Whole signals go through run()."
            ) from None
        return (*[*found, 0.0, 0.0][: len(values) + 2], bool(on))

    def _table(self, given: Mapping[str, npt.ArrayLike] | None, samples: int) -> Array:
        """The two scheduling variables, (T, 2)."""
        told, table = self._told(given), np.zeros((samples, 2))
        for column, name in enumerate(self.given):
            table[:, column] = along(told[name], samples, name)
        return table

    def _told(self, given: Mapping[str, Any] | None) -> Mapping[str, Any]:
        told = given or {}
        missing = [name for name in self.given if name not in told]
        if missing:
            raise ParameterError(
                f"the model depends on '{missing[0]}', which was not given. Pass given={{'{missing[0]}': value}}."
            )
        return told


class SavedBlock(MachineBlock[S]):
    """A block of a model in one of its directions, whose state has an image."""

    model: Model

    def run(
        self, x: npt.ArrayLike, on: npt.ArrayLike = True, given: Mapping[str, npt.ArrayLike] | None = None
    ) -> tuple[Array, Words]:
        """Return outputs and flags of many samples, going on from the present state.

        Parameters
        ----------
        x
            Inputs, (T,). [input]
        on
            Whether the model answers, (T,) or one value for all.
        given
            Scheduling variables by name, (T,) or a number each.

        Returns
        -------
        y : (T,)
            Outputs, with the bits of `step`. [output]
        flags : (T,)
            Sums of the bits in `BLOCK_FLAGS`.

        Raises
        ------
        ParameterError
            If lengths differ, values are no numbers, or a scheduling variable is missing.
        """
        samples = signal_array(x, "input x")
        table = (self._table(given, samples.size),) if self.takes_given else ()
        native: Any = self._native
        y, flags = native.run(samples, *table, switched(on, samples.size))
        return y, flags

    def save(self) -> Words:
        """Return an image of the state, 32-bit words with a checksum: the same as the exported C code saves."""
        return self._native.save()

    def restore(self, image: npt.ArrayLike) -> None:
        """Go on from an image of `save`, bit for bit.

        Raises
        ------
        ParameterError
            If the image is damaged, of another model, or holds an impossible state; ``error.facts["fault"]`` says
            which: "size", "kind", "damaged", "foreign" or "invalid". The block keeps the state that it had.
        """
        refuse(
            self._native.restore(words_of(image)),
            "Restore what save() of a block of the same model returned; this block still has the state it had.",
        )

    def __repr__(self) -> str:
        """One line: direction, signals and their limits."""
        return f"<{type(self).__name__} {self.direction} of {self.model.family!r}: {self.input!s} -> {self.output!s}>"


def along(values: npt.ArrayLike, samples: int, name: str) -> Array:
    """One value for all samples, or one each, as (T,)."""
    array = np.asarray(values)
    if array.dtype.kind not in "biuf" or array.shape not in ((), (samples,)):
        raise ParameterError(
            f"{name} has shape {array.shape} and type {array.dtype} for {samples} samples; pass a number a sample, or "
            f"one for all."
        )
    return np.ascontiguousarray(np.broadcast_to(array.astype(np.float64), (samples,)))


def switched(on: npt.ArrayLike, samples: int) -> npt.NDArray[np.bool_]:
    """Whether the model answers, (T,)."""
    values = np.asarray(on)
    fits = values.dtype.kind in "biuf" and values.shape in ((), (samples,))
    if not fits or np.any((values != 0) & (values != 1)):
        raise ParameterError(
            f"on has shape {values.shape} and type {values.dtype} for {samples} samples; pass True or False, or one of "
            f"them a sample. A block takes no time stamps: it runs at its own period."
        )
    return np.ascontiguousarray(np.broadcast_to(values != 0, (samples,)))


def refuse_direction(direction: str) -> None:
    """Refuse a direction that is none."""
    if direction not in ("inverse", "forward"):
        raise ParameterError(
            f"direction = {direction!r:.40} is none; pass 'inverse' (wanted output in, needed input out) or 'forward'."
        )


def refuse_ramp(ramp: int) -> None:
    """Refuse a number of samples that is none."""
    if isinstance(ramp, bool) or not isinstance(ramp, int | np.integer) or not 1 <= ramp <= LONGEST_RAMP:
        raise ParameterError(
            f"ramp = {ramp!r:.40} is no number of samples; pass a whole one from 1 (at once) to {LONGEST_RAMP:.0e}, "
            f"for example 500.",
            ramp=ramp,
        )


def declared_range(card: SignalCard, bounds: tuple[float, float] | None) -> tuple[float, float]:
    """Return the range of the actuator's input: `bounds`, or those of its signal; refuse what is none."""
    if bounds is None:
        if card.low is None or card.high is None:
            raise ParameterError(
                f"the range of the input {card.label} is not known: this model was not identified from a log. Without "
                f"it a block has no limits; pass range=(low, high), what the actuator can be given."
            )
        bounds = (card.low, card.high)
    try:
        low, high = bounds
    except (TypeError, ValueError):
        raise ParameterError(f"range = {bounds!r:.60} is no pair of numbers; pass range=(low, high).") from None
    low, high = parameter_number(low, "range[0]"), parameter_number(high, "range[1]")
    if not low < high:
        raise ParameterError(
            f"range = ({low:g}, {high:g}) holds no input to move in; pass the smallest first, then the largest.",
            low=low,
            high=high,
        )
    return low, high
