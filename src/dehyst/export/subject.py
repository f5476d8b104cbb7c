"""What is exported: one unit, its numbers, its signals, the proof that goes with it."""

from __future__ import annotations

import json
import keyword
import re
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any, cast

import numpy as np

from dehyst.control.adaptation import Adaptation
from dehyst.control.block import Block, Direction
from dehyst.control.parameters import JointControllerParameters
from dehyst.errors import ParameterError
from dehyst.export.core_files import core_files
from dehyst.export.float_rules import check_block
from dehyst.export.numbers import BlockNumbers, DirectBlockNumbers, DirectNumbers, JointNumbers, ModelNumbers, block_in
from dehyst.export.signal import Array, Signal, answers, test_input
from dehyst.models import DirectInverse, HysteresisModel, SignalCard
from dehyst.models.storage import model_to_dict

WHATS = ("inverse", "forward", "joint-controller")  # as typed; a direct inverse is exported as "direct-inverse"
REALS = ("double", "float")
RAMP = 500  # samples over which a switching fades, unless said otherwise
MOST_EXCERPT = 2000  # samples of the user's log


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
    block
        Numbers of the block in that precision; None for a joint controller and a direct inverse.
    joint
        Numbers of the joint controller; None for blocks.
    input, output
        Signals of the unit with their units and the limits that it keeps; of a joint controller those of the
        compensator.
    model
        The identified model: the unit is this one (forward) or its inverse; a direct inverse is one already.
    model_text
        Content of ``model.json`` of the folder.
    checksum
        sha256 of the model's content.
    provenance
        Of the model.
    settings
        What ``subject_of`` was asked for, so that it can be asked again: what, range, ramp, name, real.
    period
        Of the samples, where the unit knows it. [s]
    test
        Test signal with the model's answers.
    excerpt
        Excerpt of the user's log with the model's answers, or None.
    excerpt_source
        Which log and column, "" for none.
    parameters
        Of the joint controller, None for a block.
    adaptation
        Of a joint controller with a direct inverse, else None.
    start_output
        Of a block after a reset. [output]
    direct_block
        Numbers of a direct inverse alone, else None.
    extra
        Files that go along for this subject: path -> text.
    """

    what: str
    name: str
    real: str
    block: BlockNumbers | None
    joint: JointNumbers | None
    input: SignalCard
    output: SignalCard
    model: HysteresisModel | DirectInverse
    model_text: str
    checksum: str
    provenance: Mapping[str, Any]
    settings: Mapping[str, Any]
    test: Signal
    period: float | None = None
    excerpt: Signal | None = None
    excerpt_source: str = ""
    parameters: JointControllerParameters | None = None
    adaptation: Adaptation | None = None
    start_output: float = 0.0
    direct_block: DirectBlockNumbers | None = None
    extra: Mapping[str, str] = field(default_factory=dict)

    @property
    def operators(self) -> int:
        """Number of play operators; of stops and lags in a direct inverse."""
        if self.direct is not None:
            return self.direct.memory // 2
        numbers = self.block.model if self.block else self.joint.compensator if self.joint else None
        return numbers.operators if numbers else 0

    @property
    def direct(self) -> DirectNumbers | None:
        """Numbers of the direct inverse, if it is one or holds one."""
        if self.direct_block is not None:
            return self.direct_block.direct
        return self.joint.direct if self.joint else None

    @property
    def title(self) -> str:
        """One line: what it is and what it maps."""
        if self.what == "joint-controller":
            kind = "stops and lags in its direct inverse" if self.direct else "operators in its compensator"
            return f"joint controller with {self.operators} {kind}"
        if self.direct_block is not None:
            return f"direct inverse: {self.input.label} -> {self.output.label}, {self.operators} stops and lags"
        kind = "inverse compensator" if self.what == "inverse" else "hysteresis model"
        return f"{kind}: {self.input.label} -> {self.output.label}, {self.operators} operators"


def identifier(text: str) -> str:
    """Return a C identifier that reads like the text.

    Examples
    --------
    >>> identifier("Gelenk 1 (links).json"), identifier("1st"), identifier("int")
    ('gelenk_1_links_json', 'unit_1st', 'unit_int')
    """
    word = _word(text)
    return word if word and word[0].isalpha() and not _reserved(word) else f"unit_{word}".rstrip("_")


def why_prefixed(text: str) -> str:
    """Return why `identifier` puts unit_ in front of this text; "" if it does not.

    Examples
    --------
    >>> why_prefixed("math"), why_prefixed("1st"), why_prefixed("elbow")
    ("'math' is a word of C, of its headers or of dehyst", "'1st' does not begin with a letter", '')
    """
    word = _word(text)
    if not word or not word[0].isalpha():
        return f"'{word}' does not begin with a letter"
    return f"'{word}' is a word of C, of its headers or of dehyst" if _reserved(word) else ""


def _word(text: str) -> str:
    return re.sub(r"[^a-z0-9]+", "_", text.lower()).strip("_")[:40].rstrip("_")


_WORDS = """
auto break case char const continue default do double else enum extern float for goto if inline int long register
restrict return short signed sizeof static struct switch typedef union unsigned void volatile while bool class delete
explicit export false friend mutable namespace new operator private protected public template this throw true try
typename using virtual main std asm and or not xor bitand bitor compl linux unix near far
"""
C_WORDS = frozenset(_WORDS.split())


_HEADERS = """
assert complex ctype errno fenv float inttypes iso646 limits locale math memory setjmp signal stdalign stdarg
stdatomic stdbool stddef stdint stdio stdlib stdnoreturn string strings tgmath threads time uchar wchar wctype
malloc unistd windows arduino simstruc
"""
HEADERS = frozenset(_HEADERS.split())  # a unit of that name would be found in their place
_PROGRAMS = ("check", "check_main", "example_main", "expected")


def _reserved(word: str) -> bool:
    """Words of C, C++ and the core, whose files lie beside those of the unit; and those of its own programs."""
    taken = f"{word}.c" in core_files() or f"{word}.h" in core_files() or word in _PROGRAMS
    ours = word == "dehyst" or word.startswith(("dehyst_", "fmu", "fmi"))
    return ours or taken or word in C_WORDS or word in HEADERS or keyword.iskeyword(word)


def check_name(name: str) -> str:
    """Return the name, or refuse it.

    Raises
    ------
    ParameterError
        If it is no identifier that C, C++ and Structured Text allow, or the name of something else.
    """
    if re.fullmatch(r"[a-z_0-9]+", name) and _reserved(name):
        raise ParameterError(
            f"--name {name!r:.60} is taken: it is a word of C or the name of a file that lies beside those of the "
            f"unit, or of a header that would be found in its place. Choose another: --name {identifier(name)}.",
            name=name,
        )
    if not re.fullmatch(r"[a-z][a-z0-9]*(_[a-z0-9]+)*", name) or len(name) > 48:
        raise ParameterError(
            f"--name {name!r:.60} cannot be the name of C functions; use small letters, digits and single underscores, "
            f"a letter first, 48 at most, for example --name {identifier(name)}.",
            name=name,
        )
    return name


def model_numbers(values: Mapping[str, Any]) -> ModelNumbers:
    """Return the numbers of the core's model from a mapping of arrays."""

    def pair(place: str) -> tuple[tuple[float, ...], tuple[float, ...]] | None:
        u, v = floats(f"{place}_u"), floats(f"{place}_v")
        return (u, v) if u else None

    def floats(name: str) -> tuple[float, ...]:
        return tuple(float(value) for value in np.asarray(values[name]).ravel())

    return ModelNumbers(
        floats("threshold"),
        floats("slope"),
        floats("loading"),
        floats("start"),
        float(values["center"]),
        float(values["offset"]),
        pair("before"),
        pair("after"),
    )


def block_numbers(block: Block) -> BlockNumbers:
    """Return the numbers of a block, in double precision."""
    values = {entry.name: getattr(block.parameters, entry.name) for entry in fields(block.parameters)}
    own = {entry.name: float(values[entry.name]) for entry in fields(BlockNumbers)[1:-1]}
    return BlockNumbers(model_numbers(values), **own, fingerprint=int(values["fingerprint"]))


def subject_of(
    model: HysteresisModel,
    what: str = "inverse",
    *,
    name: str,
    real: str = "double",
    range: tuple[float, float] | None = None,
    ramp: int = RAMP,
    excerpt: Array | None = None,
    excerpt_source: str = "",
) -> Subject:
    """Return a model or its inverse as something that targets can write.

    Parameters
    ----------
    model
        The identified model; it is inverted here if `what` is "inverse".
    what
        "inverse" or "forward".
    name
        C identifier.
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

    Raises
    ------
    ParameterError
        If the model has no ranges, or does not survive the rounding to float.
    InvertibilityError
        If it has no inverse.
    """
    check_choice(what, WHATS[:2], "--what")
    check_choice(real, REALS, "--real")
    check_name(name)
    block = Block(model, cast(Direction, what), range=range, ramp=ramp)
    _refuse_narrow(model, range)
    exact = block_numbers(block)
    numbers = block_in(exact, real)
    if real == "float":
        check_block(exact, numbers)
    names = block.input.name or "input", block.output.name or "output"
    content = model_to_dict(model)
    x, on = test_input(numbers, real, ramp)
    log = None
    if excerpt is not None:
        taken = np.asarray(excerpt, dtype=np.float64)[:MOST_EXCERPT]
        taken = taken.astype(np.float32).astype(np.float64) if real == "float" else taken
        log = answers(block, taken, np.ones(taken.size, dtype=np.int64), names)
    block.reset()
    return Subject(
        what=what,
        name=name,
        real=real,
        block=numbers,
        joint=None,
        input=_limited(block.input, numbers.input_low, numbers.input_high),
        output=_limited(block.output, numbers.output_low, numbers.output_high),
        model=model,
        model_text=json.dumps(content, indent=1, allow_nan=False) + "\n",
        checksum=str(content["sha256"]),
        provenance=dict(model.card.provenance),
        settings={
            "what": what,
            "name": name,
            "real": real,
            "range": None if range is None else [float(end) for end in range],
            "ramp": ramp,
        },
        test=answers(block, x, on, names),
        excerpt=log,
        excerpt_source=excerpt_source if log else "",
        start_output=block.last,
    )


NARROWEST = 1e-6  # share of the identified range


def _refuse_narrow(model: HysteresisModel, bounds: tuple[float, float] | None) -> None:
    card = model.card.input
    if bounds is None or card.low is None or card.high is None:
        return
    low, high = (float(end) for end in bounds)
    if 0 < high - low < NARROWEST * (card.high - card.low):
        raise ParameterError(
            f"the range from {low:.9g} to {high:.9g} is less than a millionth of what was identified, {card!s}: the "
            f"unit would do nothing. Pass --range LO HI in {card.unit or 'the unit of the input'}, what the actuator "
            f"can be given.",
            low=low,
            high=high,
        )


def _limited(card: SignalCard, low: float, high: float) -> SignalCard:
    return SignalCard(card.name, card.unit, low, high)


def check_choice(value: str, allowed: tuple[str, ...], option: str) -> None:
    """Refuse a value that is not among the allowed ones."""
    if value not in allowed:
        raise ParameterError(f"{option} {value!r:.40} is unknown; there are: {', '.join(allowed)}.", value=value)
