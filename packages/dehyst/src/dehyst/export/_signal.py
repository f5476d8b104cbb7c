"""Test signals of an exported unit and the model's answers to them: generated signals, excerpts of logs."""

from __future__ import annotations

import csv
import io
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.errors import OutputError
from dehyst.export._policy import POLICY
from dehyst.findings import Finding
from dehyst.io import read_signal
from dehyst.models import Block, SignalCard
from dehyst.models import kit as models_kit
from dehyst.shell import visible

Whole = npt.NDArray[np.int64]

LADDER = 240  # samples of nested loops
WALK = 400  # samples of random steps
EDGES = 40  # samples about the limits
MOST_EXCERPT = 2000  # samples of the user's log


@dataclass(frozen=True)
class Signal:
    """Samples and answers, T of them.

    Attributes
    ----------
    inputs
        (T, m), as doubles; rounded to float already if the unit is in float.
    switch
        (T,), `on` of a block, the switches of a joint controller.
    outputs
        (T, k), of the model in double precision.
    flags
        (T,)
    input_names, output_names
        m and k names.
    image
        The state after the last sample as 32-bit words, () if it is not known.
    """

    inputs: Array
    switch: Whole
    outputs: Array
    flags: Whole
    input_names: tuple[str, ...]
    output_names: tuple[str, ...]
    image: tuple[int, ...] = ()

    @property
    def samples(self) -> int:
        """Return T."""
        return int(self.inputs.shape[0])


def answers(block: Block, inputs: Array, on: Whole, names: tuple[str, ...]) -> Signal:
    """Return what a block answers from its reset on to inputs (T, m) and on/off (T,)."""
    block.reset()
    outputs, flags = block.answer(inputs, on)
    image: tuple[int, ...] = ()
    if block.saved:
        image = tuple(map(int, block.save()))
    block.reset()
    return Signal(
        inputs, on, outputs[:, None], flags.astype(np.int64), names[:-1], names[-1:], image
    )


def test_input(low: float, high: float, real: str, ramp: int) -> tuple[Array, Whole]:
    """Return inputs (T,) and on/off (T,) that move every operator, meet every limit and are no numbers at times.

    Parameters
    ----------
    low, high
        Range of the input.
    real
        "double" or "float": the precision that the inputs are rounded to.
    ramp
        Samples of a switching, so that some are completed and some are cut short.
    """
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    rng = np.random.default_rng(20260722)
    # Nested loops that shrink from the whole range to a ten-thousandth of it: each operator turns in some of them.
    sizes = np.geomspace(1.0, 1e-4, LADDER // 2)
    ladder = np.column_stack((sizes, -sizes)).ravel()
    rise = np.concatenate((np.linspace(0, 1, 60), np.linspace(1, -1, 120), np.linspace(-1, 1, 120)))
    walk = np.clip(
        np.cumsum(rng.standard_normal(WALK) * 10.0 ** rng.uniform(-3, -0.5, WALK)), -1.2, 1.2
    )
    edges = rng.choice(
        [-1.0, 1.0, -1.0 - 1e-12, 1.0 + 1e-12, -1.05, 1.05, -30.0, 30.0, 0.0, -0.0], EDGES
    )
    shares = np.concatenate((rise, ladder, walk, edges, ladder[: LADDER // 3]))
    x = middle + half * shares
    strange = (math.nan, math.inf, -math.inf, *_LARGE[real], 5e-324, -0.0, low, high)
    places = rng.choice(np.arange(5, x.size), 3 * len(strange), replace=False)
    x[places] = np.tile(strange, 3)
    on = np.ones(x.size, dtype=np.int64)
    for begin, length in (
        (70, 3 * ramp + 5),
        (70 + 4 * ramp, max(1, ramp // 3)),
        (620, 2 * ramp + 1),
        (900, 1),
    ):
        on[begin : begin + length] = 0
    if real == "float":
        with np.errstate(over="ignore"):
            x = x.astype(np.float32).astype(np.float64)
    return x, on


# Inputs about the largest that the core takes, in double on both sides of it.
_LARGE = {"double": (1e99, -1e99, 1e101, -1e101), "float": (1e14, -1e14)}
Range = tuple[float, float]
SAMPLES = 1400


def moving_input(
    low: float, high: float, further: list[Range | None], ramp: int, real: str
) -> tuple[Array, Whole]:
    """Loops from the whole range to a thousandth of it, random steps, holds, what is no number, switching.

    Parameters
    ----------
    low, high
        Range of the first input.
    further
        Range of each other input; None: the rate of the first.
    ramp, real
        Samples of a switching; the precision that inputs are rounded to.
    """
    # `dehyst verify` computes the signal again, so the seed is always the same.
    rng = np.random.default_rng(20260722)
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    sizes = np.geomspace(1.0, 1e-3, 60)
    tips = np.concatenate(([0.0, 1.0, -1.0, 1.1, -1.2], np.column_stack((sizes, -sizes)).ravel()))
    steps = 8
    # Each stroke is a row: it begins at its tip and ends one step before the next one.
    strokes = np.linspace(tips[:-1], tips[1:], steps, endpoint=False, axis=1).ravel()
    walk = np.clip(
        np.cumsum(rng.standard_normal(300) * 10.0 ** rng.uniform(-3, -0.5, 300)), -1.3, 1.3
    )
    shares = np.concatenate((strokes, walk))[:SAMPLES]
    shares[200:230] = shares[200]  # at rest: creep goes on
    y = middle + half * shares
    columns = [y]
    for k, limits in enumerate(further):
        if limits is None:
            columns.append(np.gradient(shares) * 8.0 * half)  # at most a few ranges a second
        else:
            wide = limits[1] - limits[0]
            columns.append(
                limits[0] + wide * (0.5 + 0.7 * np.sin(0.01 * (2 + k) * np.arange(y.size)))
            )
    inputs = np.column_stack(columns)
    _spoil(inputs, rng, real)
    on = np.ones(y.size, dtype=np.int64)
    for begin, length in (
        (70, 30),
        (150, ramp + 5),
        (250 + 2 * ramp, max(1, ramp // 3)),
        (y.size - 120, 1),
    ):
        on[begin : begin + length] = 0
    if real == "float":
        with np.errstate(over="ignore", under="ignore"):
            inputs = inputs.astype(np.float32).astype(np.float64)
    return inputs, on


def _spoil(inputs: Array, rng: np.random.Generator, real: str) -> None:
    """Put in what is no number, too large, or far away; the first sample too."""
    inputs[0, 0] = math.nan
    for column in range(inputs.shape[1]):
        strange = (math.nan, math.inf, -math.inf, -0.0, 5e-324, *_LARGE[real])
        places = rng.choice(np.arange(5, inputs.shape[0]), len(strange), replace=False)
        inputs[places, column] = strange


def to_csv(signal: Signal) -> str:
    """Return a table of inputs, switch, outputs and flags with all digits."""
    head = map(visible, [*signal.input_names, "switch", *signal.output_names, "flags"])
    rows = []
    for k in range(signal.samples):
        inputs = map(_digits, signal.inputs[k])
        outputs = map(_digits, signal.outputs[k])
        rows.append([*inputs, str(signal.switch[k]), *outputs, str(signal.flags[k])])
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows([head, *rows])
    return text.getvalue()


def to_hex(signal: Signal) -> str:
    """Return rows of inputs, switch, outputs and flags; numbers are patterns of doubles, so that no digit is lost."""
    lines = []
    for k in range(signal.samples):
        inputs = map(_pattern, signal.inputs[k])
        outputs = map(_pattern, signal.outputs[k])
        row = [*inputs, str(signal.switch[k]), *outputs, str(signal.flags[k])]
        lines.append(" ".join(row) + "\n")
    return "".join(lines)


def from_csv(text: str, inputs: int, path: str = "table") -> Signal:
    """Read back what `to_csv` wrote, with that many input columns."""
    rows = list(csv.reader(io.StringIO(text)))
    try:
        head, body = rows[0], rows[1:]
        values = np.array([list(map(float, row)) for row in body])
        if head[inputs] != "switch" or head[-1] != "flags" or values.shape[1] != len(head):
            raise ValueError("its columns are others")
        switch, flags = values[:, inputs].astype(np.int64), values[:, -1].astype(np.int64)
    except (ValueError, IndexError) as fault:
        raise OutputError(
            f"'{path}' is not the table that was exported ({fault}). Export again."
        ) from None
    names = tuple(head[:inputs]), tuple(head[inputs + 1 : -1])
    return Signal(values[:, :inputs], switch, values[:, inputs + 1 : -1], flags, *names)


def same_bits(a: Array, b: Array) -> bool:
    """Return whether two arrays agree to the bit, signs of zero included; every NaN is as good as another.

    Examples
    --------
    >>> same_bits(np.array([0.0]), np.array([-0.0]))
    False
    """
    if a.shape != b.shape:
        return False
    equal = np.ascontiguousarray(a).view(np.uint64) == np.ascontiguousarray(b).view(np.uint64)
    return bool(np.all(equal | (np.isnan(a) & np.isnan(b))))


def _pattern(value: np.float64) -> str:
    return f"{value.view(np.uint64):016x}"


def _digits(value: float) -> str:
    return repr(float(value))


@dataclass(frozen=True)
class Excerpt:
    """Logged samples for the check.

    Attributes
    ----------
    values
        (T,), T at most `MOST_EXCERPT`. [unit of the exported input]
    source
        File and column.
    findings
        What reading found.
    """

    values: Array
    source: str
    findings: tuple[Finding, ...]


@dataclass(frozen=True)
class SignalPart:
    """Which part of a log: its run, times from and to [s], the time column, the sheet of a workbook."""

    run: str | None = None
    start: float | None = None
    stop: float | None = None
    time: str | None = None
    sheet: str | None = None


ALL = SignalPart()


def read_excerpt(log: Path, column: str, card: SignalCard, part: SignalPart = ALL) -> Excerpt:
    """Read the first samples of a column, in the unit of a signal, of a part of the log.

    Raises
    ------
    LogError
        If log or column cannot be read.
    UnitError
        If the units cannot be converted.
    """
    signal = read_signal(
        log,
        column,
        time=part.time,
        run=part.run,
        start=part.start,
        stop=part.stop,
        sheet=part.sheet,
    )
    values, findings = models_kit.in_units_of(card, signal.values, signal.unit, f"'{signal.name}'")
    return Excerpt(
        np.asarray(values)[:MOST_EXCERPT],
        f"{log.name}, {signal.name}",
        (*signal.findings, *findings),
    )


def use_of(signal: Signal, card: SignalCard) -> tuple[int, float]:
    """Return how many samples of an excerpt are limited, and which share of the input's range it uses."""
    limited = int(np.count_nonzero(signal.flags & 4))
    low, high = float(card.low or 0.0), float(card.high or 0.0)
    inside = np.clip(signal.inputs[np.isfinite(signal.inputs)], low, high)
    if not inside.size:
        return limited, 0.0
    return limited, float((inside.max() - inside.min()) / (high - low))


def use_findings(signal: Signal, card: SignalCard) -> list[Finding]:
    """Return a warning if an excerpt says little: most of it at a limit, or a small part of the range."""
    limited, share = use_of(signal, card)
    if 2 * limited <= signal.samples and share >= POLICY.excerpt_share:
        return []
    return [
        Finding(
            "excerpt-says-little",
            f"of the excerpt's {signal.samples} samples {limited} are limited, and it uses {100 * share:.2g} % of the "
            f"range of {card!s}: it proves little. Is --column the input of what is exported, in its unit? Choose "
            f"another part with --run, --from and --to.",
        )
    ]
