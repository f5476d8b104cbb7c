"""What is exported: one unit with its parameters, test signals and checks."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from dehyst.arrays import Array
from dehyst.errors import ParameterError
from dehyst.export._controller import ControllerInterface
from dehyst.export._names import check_name
from dehyst.export._numbers import DirectNumbers, JointNumbers, UnitNumbers
from dehyst.export._signal import MOST_EXCERPT, Signal, Whole, answers
from dehyst.export._units import Unit, unit_of
from dehyst.models import BLOCK_FLAGS, Model, SignalCard, model_to_dict
from dehyst.models import kit as models_kit
from dehyst.shell import visible

WHATS = ("inverse", "forward")  # as typed; packages add kinds of controllers
DIRECT = "direct-inverse"  # what a direct inverse alone is exported as
REALS = ("double", "float")
SAME_WORDS = {"double": "bits", "float": "answers"}  # that a unit gives again
RAMP = 500  # samples over which a switching fades, unless said otherwise
TUNING = (
    "dehyst_accept",
    "dehyst_within",
    "dehyst_map_value",
)  # of the core, that tunable numbers need
_KINDS = {
    "inverse": "inverse compensator",
    "forward": "hysteresis model",
    DIRECT: "direct inverse",
}


@dataclass(frozen=True)
class Subject:
    """One unit to export; targets read it and change nothing.

    Attributes
    ----------
    what
        "inverse", "forward", "joint-controller", or "direct-inverse" for a direct inverse alone.
    name
        C identifier that all names of the exported unit begin with.
    real
        "double" or "float".
    numbers
        Of the block or the joint controller in that precision.
    input, output
        Signals of the unit with their units and the limits that it keeps; of a joint controller those of the
        compensator.
    model
        The identified model: the unit is this one (forward) or its inverse; a direct inverse is one already.
    settings
        What ``subject_of`` was asked for, so that it can be asked again: what, range, ramp, name, real.
    test
        Test signal with the model's answers.
    tolerances
        Largest error of each output in float, as the test signal is long. [output]
    period
        Of the samples, where the unit knows it. [s]
    excerpt
        Excerpt of the user's log with the model's answers, or None.
    excerpt_source
        Which log and column, "" for none.
    controller
        Signals, switches and flags of a joint controller, None for a block.
    start_output
        Of a block after a reset. [output]
    tunable
        Whether a block has numbers that may be changed while it runs.
    unit
        Of a block, as it runs here; None for a joint controller.
    extra
        Files that go along for this subject: path -> text.
    retain
        Whether a PLC keeps the memory of the unit over a power cycle.
    """

    what: str
    name: str
    real: str
    numbers: UnitNumbers | JointNumbers
    input: SignalCard
    output: SignalCard
    model: Model
    settings: Mapping[str, Any]
    test: Signal
    tolerances: tuple[float, ...]
    period: float | None = None
    excerpt: Signal | None = None
    excerpt_source: str = ""
    controller: ControllerInterface | None = None
    start_output: float = 0.0
    tunable: bool = False
    unit: Unit | None = None
    extra: Mapping[str, str] = field(default_factory=dict)
    retain: bool = False

    @property
    def block(self) -> UnitNumbers | None:
        """Numbers of the block; None for a joint controller."""
        return self.numbers if isinstance(self.numbers, UnitNumbers) else None

    @property
    def joint(self) -> JointNumbers | None:
        """Numbers of the joint controller; None for a block."""
        return self.numbers if isinstance(self.numbers, JointNumbers) else None

    @property
    def direct(self) -> DirectNumbers | None:
        """Numbers of the direct inverse, if it is one or holds one."""
        return self.numbers.direct

    @property
    def functions(self) -> tuple[str, ...]:
        """Of the core, that the unit calls."""
        if self.tunable:
            return self.numbers.functions + TUNING
        return self.numbers.functions

    @property
    def operators(self) -> int:
        """Number of play operators, or of the elements that the unit has instead."""
        return self.numbers.parts

    @cached_property
    def _content(self) -> dict[str, Any]:
        return model_to_dict(self.model)

    @property
    def model_text(self) -> str:
        """Content of ``model.json`` of the folder."""
        return json.dumps(self._content, indent=1, allow_nan=False) + "\n"

    @property
    def checksum(self) -> str:
        """sha256 of the model's content."""
        return str(self._content["sha256"])

    @property
    def provenance(self) -> Mapping[str, Any]:
        """Of the model."""
        return dict(self.model.card.provenance)

    @property
    def more(self) -> tuple[tuple[str, str], ...]:
        """C name and meaning of each input of a block behind the first."""
        return self.unit.more if self.unit else ()

    @property
    def middle(self) -> tuple[float, ...]:
        """A usual value of each input of a block."""
        return self.unit.middle if self.unit else ()

    @property
    def flag_bits(self) -> Mapping[str, int]:
        """Name -> bit of every flag."""
        return self.controller.flag_bits if self.controller else BLOCK_FLAGS

    def answer(self, inputs: Array, on: Whole) -> Signal:
        """Return what a block answers from its reset on to inputs (T, m)."""
        assert self.unit is not None  # a block has one
        return answers(
            self.unit.block, inputs, on, (*self.test.input_names, *self.test.output_names)
        )

    @property
    def title(self) -> str:
        """One line: what it is and what it maps."""
        if self.block is None:
            kind = "operators in its compensator"
            if self.direct:
                kind = "stops and lags in its direct inverse"
            return f"joint controller with {self.operators} {kind}"
        ahead = ""
        if (
            self.what == "inverse"
            and self.period is not None
            and self.model.lead(self.period) > 0.0
        ):
            ahead = f", wants its input {self.model.lead(self.period):.3g} s ahead"
        return (
            f"{_KINDS[self.what]}: {self.input.label} -> {self.output.label}, {self.operators} {self.block.kind}"
            f"{ahead}"
        )


def subject_of(
    model: Model,
    what: str = "inverse",
    *,
    name: str,
    period: float | None = None,
    real: str = "double",
    range: tuple[float, float] | None = None,
    ramp: int = RAMP,
    excerpt: Array | None = None,
    excerpt_source: str = "",
    follow_offset: float | None = None,
    retain: bool = False,
    tunable: bool = False,
) -> Subject:
    """Return a model or its inverse as something that targets can write.

    Parameters
    ----------
    model
        The identified model, of any family that the core runs; it is inverted here if `what` is "inverse".
    what
        "inverse" or "forward".
    name
        C identifier.
    period
        Between two samples, of models whose answer depends on it. [s]
    real
        "double" or "float".
    range
        Lowest and highest input of the actuator; None for the identified range. [input of the model]
    ramp
        Samples over which switching on and off fades.
    excerpt
        Logged input of what is exported, (T,); `MOST_EXCERPT` samples at most are kept.
    excerpt_source
        Which log and column that is.
    follow_offset
        Limit of an offset that follows the last cycle, as a share of the output's range; None: there is none.
    retain
        Keep the states over a power cycle: for a PLC, which has memory that does.
    tunable
        Whether scale, offset and limits of the output and the ramp may be changed while the unit runs.

    Raises
    ------
    ParameterError
        If the core does not run the model, it has no ranges, or does not survive the rounding to float.
    InvertibilityError
        If it has no inverse.

    Examples
    --------
    >>> from dehyst.models import DirectInverse, ModelCard
    >>> card = ModelCard(SignalCard("p", "bar", -2.0, 2.0), SignalCard("x", "mm", -1.0, 1.0))
    >>> model = DirectInverse(radii=[0.5], stop_weights=[2.0], polynomial=[0.0, 1.0], card=card)
    >>> subject_of(model, name="valve_1", period=0.001).title
    'direct inverse: x [mm] -> p [bar], 1 stops and lags'
    """
    check_choice(what, WHATS[:2], "--what")
    check_choice(real, REALS, "--real")
    check_name(name)
    if tunable and follow_offset is not None:
        raise ParameterError(
            f"--tunable does not go with --follow-offset {follow_offset:g}: an offset or a scale that is tuned by "
            f"hand is an error to the offset that follows the last cycle, which takes it away again a stroke later. "
            f"To tune by hand leave --follow-offset out; to have the offset found leave --tunable out, and give "
            f"limits and ramp to the export: --range LO HI --ramp SAMPLES."
        )
    direction: models_kit.Direction = "forward" if what == "forward" else "inverse"
    made = unit_of(model, direction, real, range, ramp, period, follow_offset)
    block, numbers = made.block, made.numbers
    names = block.input.name or "input", *made.heads, block.output.name or "output"
    what = DIRECT if numbers.direct else what
    log = None
    if excerpt is not None:
        x = np.asarray(excerpt, dtype=np.float64)[:MOST_EXCERPT]
        # The unit gets floats, so the model must answer the same rounded numbers.
        if real == "float":
            x = x.astype(np.float32).astype(np.float64)
        log = answers(block, x[:, None], np.ones(x.size, dtype=np.int64), names)
    settings: dict[str, Any] = {
        "what": what,
        "name": name,
        "real": real,
        "range": None if range is None else [float(end) for end in range],
        "ramp": int(ramp),
    }
    # What was not asked for is left out: manifests of plain exports stay short.
    if made.period is not None:
        settings["period"] = made.period
    if follow_offset is not None:
        settings["follow_offset"] = float(follow_offset)
    if retain:
        settings["retain"] = True
    if tunable:
        settings["tunable"] = True
    block.reset()
    return Subject(
        what=what,
        name=name,
        real=real,
        numbers=numbers,
        input=_limited(block.input, numbers.input_low, numbers.input_high),
        output=_limited(block.output, numbers.least, numbers.most),
        model=model,
        settings=settings,
        test=answers(block, made.inputs, made.on, names),
        tolerances=(made.allowed,),
        period=made.period,
        excerpt=log,
        excerpt_source=visible(excerpt_source) if log else "",
        start_output=block.last,
        tunable=tunable,
        unit=made,
        retain=retain,
    )


def _limited(card: SignalCard, low: float, high: float) -> SignalCard:
    return SignalCard(card.name, card.unit, low, high)


def check_choice(value: str, allowed: tuple[str, ...], option: str) -> None:
    """Refuse a value that is not among the allowed ones."""
    if value not in allowed:
        raise ParameterError(
            f"{option} {value!r:.40} is unknown; there are: {', '.join(allowed)}.", value=value
        )
