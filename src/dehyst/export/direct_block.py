"""A direct inverse as a function block that targets can write."""

from __future__ import annotations

import itertools
import json
import math

import numpy as np

from dehyst.control.direct_block import DirectBlock
from dehyst.errors import ParameterError
from dehyst.export.float_rules import FADE, check_direct, check_values
from dehyst.export.numbers import DirectBlockNumbers, DirectNumbers, direct_in, direct_numbers, rounded
from dehyst.export.signal import Array, Signal, Whole
from dehyst.export.subject import RAMP, REALS, Subject, check_choice, check_name, identifier
from dehyst.models import DirectInverse, SignalCard
from dehyst.models.storage import model_to_dict

WHAT = "direct-inverse"
SAMPLES = 1400
TOLERANCE = 1e-5  # of the range of u, in float
_OWN = ("y", "rate", "on", "self", "given")


def direct_block_subject(
    model: DirectInverse,
    *,
    name: str,
    period: float,
    real: str = "double",
    range: tuple[float, float] | None = None,
    ramp: int = RAMP,
) -> Subject:
    """Return a direct inverse as a function block: y, rate, scheduling variables and on/off in, u out.

    Parameters
    ----------
    model
        Identified.
    name
        C identifier.
    period
        Between two samples: creep lags are printed for it. [s]
    real
        "double" or "float".
    range
        Lowest and highest u of the actuator; None for the identified range. [u]
    ramp
        Samples over which switching on and off fades.

    Raises
    ------
    ParameterError
        If the model has no ranges, or does not survive the rounding to float.

    Examples
    --------
    >>> from dehyst.models import ModelCard
    >>> card = ModelCard(SignalCard("p", "bar", -2.0, 2.0), SignalCard("x", "mm", -1.0, 1.0))
    >>> model = DirectInverse(radii=[0.5], stop_weights=[2.0], polynomial=[0.0, 1.0], card=card)
    >>> direct_block_subject(model, name="valve_1", period=0.001).title
    'direct inverse: x [mm] -> p [bar], 1 stops and lags'
    """
    check_choice(real, REALS, "--real")
    check_name(name)
    block = DirectBlock(model, period, range, ramp)
    exact = direct_numbers(block.parameters)
    direct = direct_in(exact, real)
    line = {what: rounded(value, real) for what, value in (
        ("line_slope", block.line_slope), ("line_offset", block.line_offset), ("fade", block.fade)
    )}  # fmt: skip
    if real == "float":
        check_direct(exact, direct)
        check_values({"line_slope": block.line_slope, "line_offset": block.line_offset})
        _refuse_long_ramp(ramp, line["fade"])
    content = model_to_dict(model)
    names = model.card.output.name or "y", model.card.input.name or "u"
    numbers = DirectBlockNumbers(direct, **line, given=_identifiers(block.given))
    return Subject(
        what=WHAT,
        name=name,
        real=real,
        block=None,
        joint=None,
        direct_block=numbers,
        input=SignalCard(names[0], block.input.unit, direct.input_low, direct.input_high),
        output=SignalCard(names[1], block.output.unit, direct.output_low, direct.output_high),
        model=model,
        model_text=json.dumps(content, indent=1, allow_nan=False) + "\n",
        checksum=str(content["sha256"]),
        provenance=dict(model.card.provenance),
        settings={
            "what": WHAT,
            "name": name,
            "real": real,
            "range": None if range is None else [float(end) for end in range],
            "ramp": int(ramp),
            "period": float(period),
        },
        test=_answers(block, direct, real, names),
        period=float(period),
    )


def _refuse_long_ramp(ramp: int, fade: float) -> None:
    if fade < FADE:
        raise ParameterError(
            f"--ramp {ramp} is too long for --real float: a millionth of a switching is the smallest share that still "
            f"adds up in single precision. Pass --ramp 1000000 or less, or --real double.",
            ramp=ramp,
        )


def _identifiers(names: tuple[str, ...]) -> tuple[str, ...]:
    """C names of the scheduling variables: their own where that is possible."""
    words = [identifier(name) for name in names]
    plain = len(set(words)) == len(words) and not set(words) & set(_OWN)
    return tuple(words) if plain else tuple(f"given_{k + 1}" for k in range(len(names)))


def _answers(block: DirectBlock, direct: DirectNumbers, real: str, names: tuple[str, str]) -> Signal:
    """Return what a block answers from its reset on."""
    inputs, on = _inputs(block, direct, real)
    block.reset()
    given = {name: inputs[:, 2 + k] for k, name in enumerate(block.given)}
    u, flags = block.run(inputs[:, 0], inputs[:, 1], given, on)
    heads = (names[0], f"{names[0]}_rate", *block.given)
    return Signal(inputs, on, u[:, None], flags.astype(np.int64), heads, names[1:])


def _inputs(block: DirectBlock, direct: DirectNumbers, real: str) -> tuple[Array, Whole]:
    """Loops from the whole range to a thousandth of it, random steps, holds, what is no number, switching."""
    rng = np.random.default_rng(20260722)
    low, high = direct.input_low, direct.input_high
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    sizes = np.geomspace(1.0, 1e-3, 60)
    tips = np.concatenate(([0.0, 1.0, -1.0, 1.1, -1.2], np.column_stack((sizes, -sizes)).ravel()))
    steps = 8
    strokes = np.concatenate([np.linspace(a, b, steps, endpoint=False) for a, b in itertools.pairwise(tips)])
    walk = np.clip(np.cumsum(rng.standard_normal(300) * 10.0 ** rng.uniform(-3, -0.5, 300)), -1.3, 1.3)
    shares = np.concatenate((strokes, walk))[:SAMPLES]
    shares[200:230] = shares[200]  # at rest: creep goes on
    y = middle + half * shares
    rate = np.gradient(shares) * 8.0 * half  # at most a few ranges a second
    columns = [y, rate]
    for schedule in block.model.outside:
        wide = schedule.high - schedule.low
        columns.append(schedule.low + wide * (0.5 + 0.7 * np.sin(0.01 * (1 + len(columns)) * np.arange(y.size))))
    inputs = np.column_stack(columns)
    _spoil(inputs, rng, real)
    on = np.ones(y.size, dtype=np.int64)
    ramp = block.ramp
    for begin, length in ((70, 30), (150, ramp + 5), (250 + 2 * ramp, max(1, ramp // 3)), (y.size - 120, 1)):
        on[begin : begin + length] = 0
    if real == "float":
        with np.errstate(over="ignore", under="ignore"):
            inputs = inputs.astype(np.float32).astype(np.float64)
    return inputs, on


def _spoil(inputs: Array, rng: np.random.Generator, real: str) -> None:
    """Put in what is no number, too large, or far away; the first sample too."""
    far = (1e14, -1e14) if real == "float" else (1e99, -1e99, 1e101, -1e101)
    inputs[0, 0] = math.nan
    for column in range(inputs.shape[1]):
        strange = (math.nan, math.inf, -math.inf, -0.0, 5e-324, *far)
        places = rng.choice(np.arange(5, inputs.shape[0]), len(strange), replace=False)
        inputs[places, column] = strange


def float_tolerance(numbers: DirectBlockNumbers) -> float:
    """Return how far answers in float may be from those of the model: 1e-5 of the range of u, and rounding of y. [u]

    A creep lag adds less than its last digit when it is nearly there: that can add up over the samples of the test.
    """
    d = numbers.direct
    largest = max(abs(d.input_low), abs(d.input_high), d.input_high - d.input_low)
    digit = float(np.spacing(np.float32(largest)))
    table = np.array(d.weight).reshape(d.sets, d.terms)[:, d.coefficients : -1]
    weights = np.abs(table).sum(axis=0) if table.size else np.zeros(0)
    first = len(d.radius) + len(d.length)
    stalled = sum(w * 0.5 * digit * min(1.0 / gain, SAMPLES) for w, gain in zip(weights[first:], d.gain, strict=True))
    return TOLERANCE * (d.output_high - d.output_low) + digit * float(weights.sum()) + float(stalled)
