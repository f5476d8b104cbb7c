r"""Several inputs that act on several outputs: every output is a sum over the inputs of sums of elements.

::

    y_j = level_j + amplitude_j (sum over i of H_ji[x_i]),   x_i = (u_i - center_i) / half_range_i

H_ji is a sum of elements (`dehyst.families._elements`) that rises with x_i, or falls. With two inputs and two outputs
the inverse is found sample by sample by the core (core/pair.c): for every u_1 there is one u_2 that gives y_2, and
along these pairs y_1 is monotone in u_1 where the determinant of the four slopes keeps its sign. The least determinant
over all inputs and memories is bounded by the least and largest slopes of the four sums::

    det >= min |s_11| min |s_22| - max |s_12| max |s_21|     where s_12 s_21 and s_11 s_22 have the same sign
    det >= min |s_11| min |s_22| + min |s_12| min |s_21|     where they have opposite signs

Source: the sums are those of the rows; search and certificate are this project's (docs/decisions/0075).

Cannot show
-----------
An input that changes the effect of another one: effects add up.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from typing import Any, Self

import numpy as np
import numpy.typing as npt

import dehyst._native as _native
from dehyst.arrays import Array
from dehyst.errors import InvertibilityError, ParameterError
from dehyst.families._elements import Element, ElementModel
from dehyst.families._files import family_model
from dehyst.families._inversion import FARTHEST
from dehyst.families._registry import BEST
from dehyst.families._rising import least_slope
from dehyst.models import BLOCK_FLAGS, Model, ModelCard, SignalCard
from dehyst.models import kit as models_kit

FAMILY = "coupled"
LEAST_DETERMINANT = 1e-6  # scaled: below it rounding would be more than 1e-10 of an inverse

Paths = tuple[tuple[ElementModel, ...], ...]
# Of each sum its sign, and the least and largest size of its slope.
Slopes = tuple[tuple[tuple[float, float, float], ...], ...]


@dataclass(frozen=True, repr=False, eq=False)
class CoupledModel(Model):
    """Several inputs, one or two outputs; the module says the formulas.

    Parameters
    ----------
    paths
        H_ji: a row for each output, in it a sum for each input. The scaling of a sum is that of its two signals. The
        offset of an output is that of the sum from its first input.
    inputs, outputs
        Signals with their identified ranges, n and m of them.
    rest
        Inputs at which the actuator rests before the first sample, (n,). [input]
    period
        Of the log; 0 where unknown. [s]

    Raises
    ------
    ParameterError
        If the numbers of sums and signals do not agree, or there are more than two outputs.

    Examples
    --------
    >>> import numpy as np
    >>> own, across = Element("input", weight=0.8), Element("play", 0.1, weight=-0.2)
    >>> paths = ((ElementModel((own,)), ElementModel((across,))), (ElementModel((across,)), ElementModel((own,))))
    >>> model = CoupledModel(paths, (SignalCard("a"), SignalCard("b")), (SignalCard("x"), SignalCard("y")), (0.0, 0.0))
    >>> u = np.array([[0.0, 0.0], [0.5, 0.2], [0.3, 0.6]])
    >>> bool(abs(model.inverse().simulate(model.simulate(u)) - u).max() < 1e-12)
    True
    """

    paths: Paths
    inputs: tuple[SignalCard, ...]
    outputs: tuple[SignalCard, ...]
    rest: tuple[float, ...]
    period: float = 0.0
    card: ModelCard = models_kit.NO_CARD
    file_kind = "dehyst-coupled"

    def __post_init__(self) -> None:
        """Normalise; refuse what is no model."""
        put = object.__setattr__
        put(self, "paths", tuple(map(tuple, self.paths)))
        put(self, "inputs", tuple(self.inputs))
        put(self, "outputs", tuple(self.outputs))
        put(self, "rest", tuple(models_kit.parameter_number(u, "rest") for u in self.rest))
        put(self, "period", models_kit.parameter_number(self.period, "period"))
        n, m = len(self.inputs), len(self.outputs)
        sizes = {len(row) for row in self.paths}
        if len(self.paths) != m or sizes != {n} or len(self.rest) != n or n < 2 or m not in (1, 2):
            raise ParameterError(
                f"{n} inputs at rest at {len(self.rest)} values, {m} outputs, and {len(self.paths)} rows of "
                f"{sorted(sizes)} sums. Pass two or more inputs, one or two outputs, and a sum for each pair of them.",
                inputs=n,
                outputs=m,
            )
        for row in self.paths:
            for path in row:
                plain = isinstance(path, ElementModel) and path.direction == "forward"
                if (
                    not plain
                    or path.schedules
                    or path.before_map[0]
                    or path.after_map[0]
                    or path.dead_time
                ):
                    raise ParameterError(
                        "a path between two signals is a forward sum of elements without maps, schedules and dead "
                        "time; another one was passed."
                    )
        if self.card == models_kit.NO_CARD:
            put(self, "card", ModelCard(self.inputs[0], self.outputs[0]))
        put(self, "direction", "forward")

    @property
    def family(self) -> str:
        return FAMILY

    @property
    def rate_dependent(self) -> bool:
        return any(path.rate_dependent for row in self.paths for path in row)

    @property
    def nonzero_weights(self) -> int:
        """Identified values of all sums, each output's offset once."""
        values = len(self.outputs)
        for row in self.paths:
            values += sum(path.free_parameters - 1 for path in row)
        return values

    @property
    def free_parameters(self) -> int:
        """Identified values."""
        return self.nonzero_weights

    @property
    def no_export(self) -> str:
        """Why no block runs it."""
        return (
            "a model of several inputs is no block of one. Write C of it with `dehyst export MODEL --target c`, in "
            "Python dehyst.export.write_pair(model, folder)."
        )

    @property
    def no_inverse(self) -> str:
        """Why there is no inverse; empty if there is one."""
        n, m = len(self.inputs), len(self.outputs)
        if m == 1:
            _, least, _ = self.slopes[0][self.own[0]]
            if least > LEAST_DETERMINANT:
                return ""
            return f"{self.outputs[0].name} does not rise with {self.inputs[self.own[0]].name} in every state."
        if n != m:
            return f"it has {n} inputs and {m} outputs, so that many inputs give the same outputs."
        if self.determinant > LEAST_DETERMINANT:
            return ""
        return (
            f"the determinant of its slopes may be as low as {self.determinant:.3g} of the ranges, where it must stay "
            f"above 0: two pairs of inputs could give the same outputs."
        )

    @cached_property
    def slopes(self) -> Slopes:
        """Of each sum its sign, and the least and largest size of its slope over all inputs and memories; scaled."""
        rows = []
        for row in self.paths:
            rows.append(tuple(_slopes(path.elements, self.period) for path in row))
        return tuple(rows)

    @cached_property
    def own(self) -> tuple[int, ...]:
        """Which input is the own one of each output: that whose slope is never small, where the inverse is certain."""
        if len(self.outputs) == 1:
            sizes = [least for _, least, _ in self.slopes[0]]
            return (int(np.argmax(sizes)),)
        ranks = {}
        for order in ((0, 1), (1, 0)):
            least = self.slopes[0][order[0]][1] * self.slopes[1][order[1]][1]
            ranks[order] = (_determinant(self.slopes, order) > LEAST_DETERMINANT, least)
        return max(ranks, key=lambda order: ranks[order])

    @property
    def determinant(self) -> float:
        """Lower bound of the determinant of the slopes of two inputs and two outputs, over all states; scaled."""
        if (len(self.inputs), len(self.outputs)) != (2, 2):
            raise ParameterError("a determinant is that of two inputs and two outputs.")
        first, second = self.own
        return _determinant(self.slopes, (first, second))

    def simulate(
        self, x: npt.ArrayLike, time: npt.ArrayLike | None = None, **signals: npt.ArrayLike
    ) -> Array:
        """Return the outputs (T, m) for inputs (T, n), from rest at `rest` on. [outputs]

        Parameters
        ----------
        x
            Inputs, (T, n), in the order of `inputs`. [inputs]
        time
            (T,), increasing; needed where a sum creeps or depends on the rate. [s]

        Raises
        ------
        ParameterError
            If a sample is not finite, or time is needed and missing.
        """
        if signals:
            raise ParameterError(
                f"a model of several inputs takes them as columns, not {', '.join(signals)}."
            )
        u = self._columns(x, self.inputs, "inputs")
        steps = self._steps(time, len(u))
        if len(self.outputs) == 2 and len(self.inputs) == 2:
            return self._pair(False, -FARTHEST, FARTHEST).answers(u, steps)
        scaled = self._scaled(u)
        (row,) = self.paths
        y = sum(path.run(scaled[i], steps, self._rested(path, i))[0] for i, path in enumerate(row))
        return np.asarray(row[0].scaling.outward(np.asarray(y)))[:, None]

    def inverse(self) -> InverseCoupled:
        """Return what undoes this model: ``model.inverse().simulate(model.simulate(u))`` is u.

        Raises
        ------
        InvertibilityError
            If there is no inverse for certain; the message says why.
        """
        if self.no_inverse:
            raise InvertibilityError(
                f"this model of several inputs has no inverse: {self.no_inverse}", family=FAMILY
            )
        return InverseCoupled(self)

    def at_rest(self, first: float) -> Self:
        """Refuse: there are several first inputs; see `rested`."""
        raise ParameterError(
            "a model of several inputs rests at one value of each: model.rested((a, b))."
        )

    def after_strokes(self, first: float, rising: bool) -> Self:
        """Refuse: there are several first inputs; see `rested`."""
        return self.at_rest(first)

    def rested(self, inputs: Sequence[float]) -> Self:
        """Return the same model at rest at other inputs, (n,). [input]"""
        if len(inputs) != len(self.inputs):
            raise ParameterError(
                f"{len(inputs)} inputs to rest at, and the model has {len(self.inputs)}: "
                f"{', '.join(card.name for card in self.inputs)}. Pass a value for each."
            )
        return replace(self, rest=tuple(inputs))

    def stepper(self, period: float | None = None) -> Any:
        """Refuse: a step takes several samples.

        Raises
        ------
        ParameterError
            Always; the message names what there is instead.
        """
        raise ParameterError(
            "a model of several inputs has no stepper. Pass whole signals to simulate(), or write C with "
            "dehyst.export.write_pair(model, folder)."
        )

    def pair(self, solves: bool, limits: Sequence[tuple[float, float]]) -> CorePair:
        """Return two inputs and two outputs as the core runs them, inputs within limits. [input]"""
        scaled = []
        for path, (low, high) in zip(self.paths[0], limits, strict=True):
            ends = path.scaling.inward(np.array([low, high]))
            scaled.append(np.sort(np.asarray(ends)))
        lows, highs = np.array(scaled).T
        return self._pair(solves, lows, highs)

    def _pair(self, solves: bool, low: npt.ArrayLike, high: npt.ArrayLike) -> CorePair:
        """As `pair`, with scaled limits."""
        return CorePair(self, solves, np.broadcast_to(low, (2,)), np.broadcast_to(high, (2,)))

    def _columns(self, values: npt.ArrayLike, cards: Sequence[SignalCard], role: str) -> Array:
        array = np.ascontiguousarray(np.asarray(values, dtype=np.float64))
        if array.ndim == 1 and len(cards) == 1:
            array = array[:, None]
        if array.ndim != 2 or array.shape[1] != len(cards):
            names = ", ".join(card.name for card in cards)
            raise ParameterError(
                f"{role} have the shape {array.shape}; pass a column for each of {names}, (T, {len(cards)}).",
                shape=array.shape,
            )
        bad = np.flatnonzero(~np.all(np.isfinite(array), axis=1))
        if bad.size:
            raise ParameterError(
                f"{bad.size} samples of the {role} are not finite, the first at {bad[0]}; the memory would carry them "
                f"into every later sample. Drop them.",
                index=int(bad[0]),
            )
        return array

    def _steps(self, time: npt.ArrayLike | None, size: int) -> Array | None:
        """Time from the sample before, (T,), a period at the first. [s]"""
        if not self.rate_dependent:
            return None
        if time is None:
            raise ParameterError(
                "this model creeps or depends on the rate, and no time was passed. Pass time, (T,), in seconds."
            )
        stamps = np.asarray(time, dtype=np.float64)
        if (
            stamps.shape != (size,)
            or not np.all(np.isfinite(stamps))
            or np.any(np.diff(stamps) <= 0.0)
        ):
            raise ParameterError(
                f"time has the shape {stamps.shape}; pass {size} increasing numbers. [s]"
            )
        dt = np.diff(stamps, prepend=stamps[:1])
        # On a machine the first sample comes a period after the rest.
        dt[0] = self.period or (dt[1] if size > 1 else 0.0)
        return np.ascontiguousarray(dt)

    def _scaled(self, u: Array) -> list[Array]:
        columns = []
        for i, path in enumerate(self.paths[0]):
            columns.append(np.ascontiguousarray(path.scaling.inward(u[:, i])))
        return columns

    def _rested(self, path: ElementModel, i: int) -> Array:
        return path.rest(float(path.scaling.inward(self.rest[i])))

    def file_parameters(self) -> dict[str, Any]:
        """Return the parameters as plain JSON values."""
        rows = []
        for row in self.paths:
            rows.append(
                [{"values": path.parameters(), "scaling": asdict(path.scaling)} for path in row]
            )
        return {
            "paths": rows,
            "inputs": [_plain_card(card) for card in self.inputs],
            "outputs": [_plain_card(card) for card in self.outputs],
            "rest": list(self.rest),
            "period": self.period,
        }

    def __repr__(self) -> str:
        """One line: number of parameters, signals."""
        return (
            f"<CoupledModel: {self.free_parameters} parameters, {', '.join(map(str, self.inputs))} -> "
            f"{', '.join(map(str, self.outputs))}>"
        )


class CorePair:
    """Two inputs and two outputs as the core runs them: the first output first, its own input first.

    Attributes
    ----------
    sums
        Paths [0][0], [0][1], [1][0] and [1][1] of the core, own ones rising.
    numbers
        center, half_range, level, amplitude, rest, low and high, two each, scaled ones for the last three.
    order
        Which input of the model is the first one of the core.
    """

    sums: list[ElementModel]
    numbers: Array
    order: tuple[int, ...]

    def __init__(self, model: CoupledModel, solves: bool, low: Array, high: Array) -> None:
        self.order = model.own
        self.solves = solves
        self.sums = []
        signs = []
        for j, row in enumerate(model.paths):
            # An own sum that falls becomes one that rises, with the output's amplitude of the other sign.
            sign = model.slopes[j][self.order[j]][0]
            signs.append(sign)
            offset = sum(path.offset for path in row)
            for place, i in enumerate(self.order):
                path = row[i]
                elements = tuple(replace(q, weight=sign * q.weight) for q in path.elements)
                self.sums.append(
                    replace(
                        path,
                        elements=elements,
                        offset=sign * offset if place == 0 else 0.0,
                        start="rest",
                    )
                )
        # The core reads them a quantity at a time, both inputs or both outputs side by side.
        of_inputs, of_outputs = [], []
        for i in self.order:
            scaling = model.paths[0][i].scaling
            rest = float(scaling.inward(model.rest[i]))
            of_inputs.append(
                (scaling.center, scaling.half_range, rest, float(low[i]), float(high[i]))
            )
        for sign, row in zip(signs, model.paths, strict=True):
            scaling = row[0].scaling
            of_outputs.append((scaling.level, sign * scaling.amplitude))
        inputs, outputs = np.array(of_inputs).T, np.array(of_outputs).T
        self.numbers = np.concatenate([*inputs[:2], *outputs, *inputs[2:]])
        self._native_sums = [_native.ElementSum(*path.tables) for path in self.sums]
        own, from_second, from_first, second_own = self._native_sums
        self._machine = _native.ElementPair(
            own, from_second, from_first, second_own, self.numbers, solves
        )

    def run(self, samples: Array, steps: Array | None) -> tuple[Array, npt.NDArray[np.uint32], int]:
        """Return the answers (T, 2) from a reset on, flags (T,), and the most rounds that a solution took."""
        columns = samples if self.solves else np.ascontiguousarray(samples[:, self.order])
        answers, _, flags, rounds = self._machine.run(columns, steps, self._machine.rest())
        if self.solves:
            back = np.empty_like(answers)
            back[:, self.order] = answers
            answers = back
        return answers, flags, rounds

    def gains(self, place: int, period: float) -> list[float]:
        """Return the gains of the elements of one sum at a period, (n,)."""
        gains: list[float] = self._native_sums[place].gains(period).tolist()
        return gains

    def answers(self, samples: Array, steps: Array | None) -> Array:
        """Return the answers (T, 2); refuse samples that the core rejects."""
        answers, flags, _ = self.run(samples, steps)
        rejected = int(np.count_nonzero(flags & BLOCK_FLAGS["rejected"]))
        if rejected:
            raise ParameterError(
                f"{rejected} samples are beyond {_native.INPUT_LIMIT:g}; the memory would carry them into every later "
                f"sample. Drop them."
            )
        return answers


@dataclass(frozen=True, eq=False)
class InverseCoupled(models_kit.Inverted[CoupledModel]):
    """The inputs that outputs need; made by ``model.inverse()``.

    Attributes
    ----------
    of
        The model that is read the other way round.
    """

    of: CoupledModel

    def simulate(
        self, x: npt.ArrayLike, time: npt.ArrayLike | None = None, **signals: npt.ArrayLike
    ) -> Array:
        """Return the inputs (T, n) that give outputs (T, m). [inputs]

        Parameters
        ----------
        x
            Wanted outputs, (T, m), or (T,) of one output. [outputs]
        time
            (T,), increasing; needed where a sum creeps or depends on the rate. [s]
        signals
            Of a model with one output: every input but its own one by its name, (T,). [input]

        Raises
        ------
        ParameterError
            If a sample is not finite, or an input is not known.
        """
        model = self.of
        wanted = model._columns(x, model.outputs, "outputs")
        steps = model._steps(time, len(wanted))
        if len(model.outputs) == 2:
            if signals:
                raise ParameterError(
                    f"both inputs are looked for, and {', '.join(signals)} was passed. Leave it out."
                )
            return model._pair(True, -FARTHEST, FARTHEST).answers(wanted, steps)
        u = self._known(signals, len(wanted))
        own = model.own[0]
        (row,) = model.paths
        scaling = row[own].scaling
        # An own sum that falls becomes one that rises.
        sign = model.slopes[0][own][0]
        missing = (wanted[:, 0] - scaling.level) / scaling.amplitude
        for i, path in enumerate(row):
            if i != own:
                scaled = np.ascontiguousarray(path.scaling.inward(u[:, i]))
                missing = missing - path.run(scaled, steps, model._rested(path, i))[0]
        elements = tuple(replace(q, weight=sign * q.weight) for q in row[own].elements)
        path = replace(row[own], elements=elements, offset=sign * row[own].offset)
        solved, _ = path.run_inverse(
            np.ascontiguousarray(sign * missing), steps, model._rested(path, own)
        )
        u[:, own] = scaling.center + scaling.half_range * solved
        return u

    def stepper(self, period: float | None = None) -> Any:
        """Refuse, as the model does."""
        return self.of.stepper(period)

    def _known(self, known: Mapping[str, npt.ArrayLike], size: int) -> Array:
        model = self.of
        own = model.own[0]
        needed = [card.name for i, card in enumerate(model.inputs) if i != own]
        if sorted(known) != sorted(needed):
            raise ParameterError(
                f"{', '.join(known) or 'no input'} was passed, and the inputs that must be known are "
                f"{', '.join(needed)}: {model.inputs[own].name} is looked for. Pass {needed[0]}=values.",
                needed=needed,
            )
        u = np.zeros((size, len(model.inputs)))
        for i, card in enumerate(model.inputs):
            if i == own:
                continue
            values = np.asarray(known[card.name], dtype=np.float64)
            if values.shape not in ((), (size,)):
                raise ParameterError(
                    f"{card.name} has the shape {values.shape} for {size} wanted outputs; pass one value for each.",
                    shape=values.shape,
                )
            u[:, i] = values
        return model._columns(u, model.inputs, "known inputs")


def coupled_model(name: Any, parameters: Any) -> CoupledModel:
    """Return the model of a file's family and parameters, as `dehyst.models._storage` asks for it.

    Raises
    ------
    ParameterError
        If the parameters are not those of one.
    """
    if name != FAMILY:
        raise ParameterError(
            f"it is of the family {name!r:.40}, and its file is one of several inputs."
        )
    rows = []
    for row in parameters["paths"]:
        sums = []
        for path in row:
            model = family_model(BEST, {**path, "start": "rest"})
            if not isinstance(model, ElementModel):
                raise ParameterError("a path between two signals is no sum of elements.")
            sums.append(model)
        rows.append(tuple(sums))
    cards = []
    for role in ("inputs", "outputs"):
        cards.append(tuple(SignalCard(**card) for card in parameters[role]))
    return CoupledModel(
        tuple(rows), cards[0], cards[1], tuple(parameters["rest"]), parameters["period"]
    )


def _plain_card(card: SignalCard) -> dict[str, Any]:
    return {"name": card.name, "unit": card.unit, "low": card.low, "high": card.high}


def _slopes(elements: Sequence[Element], period: float) -> tuple[float, float, float]:
    """Sign of a sum that rises or falls everywhere, and bounds of the size of its slope."""
    negative = tuple(replace(q, weight=-q.weight) for q in elements)
    least, most = least_slope(elements, period=period), -least_slope(negative, period=period)
    if most >= -least:
        return 1.0, least, most
    return -1.0, -most, -least


def _determinant(slopes: Slopes, own: tuple[int, int]) -> float:
    first, second = own
    of_first, of_second = slopes[0][first], slopes[1][second]
    across = slopes[0][second], slopes[1][first]
    straight = of_first[1] * of_second[1]
    if of_first[1] <= 0.0 or of_second[1] <= 0.0:
        return -np.inf
    same = of_first[0] * of_second[0] == across[0][0] * across[1][0]
    if same:
        return straight - across[0][2] * across[1][2]
    return straight + max(0.0, across[0][1]) * max(0.0, across[1][1])
