"""What there is to say of an exported unit: where it guesses, what it costs, what float leaves, whose controller."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from dehyst.app.requests import ExportRequest
from dehyst.control import load_controller, load_partner
from dehyst.control.storage import about
from dehyst.errors import ModelFileError
from dehyst.export.numbers import DirectNumbers
from dehyst.export.subject import Subject
from dehyst.findings import Finding
from dehyst.models import Model
from dehyst.models.storage import model_to_dict

COARSE = 2e-6  # step between neighbouring floats, share of the range, from which on 1e-5 of the range is not reached
EDGE = 0.02  # share of the identified range: beyond it an input counts as outside
MANY_OPERATORS = 1000  # from here on the cost of a step is worth a word
STALLED = 0.01  # of the range: a lag that stops so far from its end in float is worth a word


def outside(model: Model, request: ExportRequest) -> Iterator[Finding]:
    """Say that the unit may work where nothing was identified."""
    card = model.card.input
    if request.range is None or card.low is None or card.high is None:
        return
    low, high = request.range
    beyond = max(card.low - low, high - card.high)
    if beyond > EDGE * (card.high - card.low):
        yield Finding(
            "outside-range",
            f"--range goes from {low:.4g} to {high:.4g}, the model's {card.label} was identified from {card.low:.4g} "
            f"to {card.high:.4g}; beyond, the model guesses. Narrow --range, or identify from a log that goes so far.",
        )


def slow(model: Model, subject: Subject) -> Iterator[Finding]:
    """Say that the unit runs so seldom that what the model knows of time is lost."""
    if subject.period is not None and (slow := model.too_slow(subject.period)):
        yield Finding("long-period", slow)


def cost(model: Model, request: ExportRequest) -> Iterator[Finding]:
    """Say which parts cost and do nothing, and when there are many."""
    parts, words = model.parts
    idle = parts - model.pruned().parts[0]
    if idle and not request.prune:
        yield Finding(
            "zero-weights",
            f"{idle} of {parts} {words} have weight zero: they take memory and time and change nothing. Add --prune to "
            f"leave them out, which is exact.",
        )
    left = parts - idle if request.prune else parts
    if left >= MANY_OPERATORS:
        yield Finding(
            "many-operators",
            f"{left} {words}: a step that turns the whole stack around moves all of them, and tables and state grow "
            f"with them. Look at the budget above; identify with fewer (--n 100) if it is too much for the target.",
        )


def coarse(subject: Subject) -> Iterator[Finding]:
    """Say where numbers of this size are too coarse in float: a small range far from zero."""
    if subject.real != "float" or subject.block is None or subject.direct is not None:
        return
    for card in (subject.input, subject.output):
        low, high = float(card.low or 0.0), float(card.high or 0.0)
        step = float(np.spacing(np.float32(max(abs(low), abs(high)))))
        if step > COARSE * (high - low):
            yield Finding(
                "coarse-float",
                f"{card.label} goes from {low:.6g} to {high:.6g}, where neighbouring floats lie {step:.2g} apart, "
                f"{100 * step / (high - low):.2g} % of the range: answers within 1e-5 of the range cannot be expected. "
                f"Export with --real double, or identify with a signal whose mean was taken off.",
            )


def stalled(subject: Subject) -> Iterator[Finding]:
    """Say where lags are too slow for float: what they should move is less than the last digit."""
    numbers = subject.direct
    if subject.real != "float" or numbers is None or not numbers.gain:
        return
    share = stall(numbers) / (numbers.input_high - numbers.input_low)
    if share > STALLED:
        yield Finding(
            "coarse-float",
            f"the slowest creep lag moves by {min(numbers.gain):.2g} of its distance in a sample: in single precision "
            f"it stops {100 * share:.2g} % of the range before it is there. Export with --real double, or with a "
            f"longer period.",
        )


def stall(numbers: DirectNumbers) -> float:
    """Return how far from its end the slowest lag stops in float. [y]

    Examples
    --------
    >>> from dehyst.export.numbers import direct_numbers
    >>> from dehyst.models import DirectInverse, ModelCard, SignalCard
    >>> card = ModelCard(SignalCard("torque", "Nm"), SignalCard("angle", "rad", -1.0, 1.0))
    >>> model = DirectInverse(time_constants=[100.0], creep_weights=[1.0], card=card)
    >>> round(stall(direct_numbers(model.parameters(1e-3))), 4)
    0.006
    """
    largest = max(abs(numbers.input_low), abs(numbers.input_high))
    return 0.5 * float(np.spacing(np.float32(largest))) / min(numbers.gain)


SHOWN = 12  # characters of a checksum


def pair_findings(model: Model, path: Path, controller: Path | None) -> list[Finding]:
    """Refuse a controller that was made for another model, and say where the two contradict each other."""
    if controller is None:
        return []
    partner, own = load_partner(controller), str(model_to_dict(model)["sha256"])
    if partner is None:
        return list(_contradictions(model, path, controller))
    checksum, was = partner
    if checksum != own:
        raise ModelFileError(
            f"controller '{controller}' was made for another model than '{path}': for {was}, checksum "
            f"{checksum[:SHOWN]}, and this is {about(model)}, checksum {own[:SHOWN]}. Its shear and its gains belong "
            f"to that model; with this one the compensation is wrong without a sign of it. Give the two files of one "
            f"run, for example model_joint1_best.json with controller_joint1_best.json; or, if they do belong "
            f"together, write the controller again: dehyst.control.save_controller(parameters, FILE, model=model).",
            path=str(controller),
        )
    return []


def _contradictions(model: Model, path: Path, controller: Path) -> Iterator[Finding]:
    """Say that the shear of one is not that of the other, as far as names tell."""
    k, name = load_controller(controller).shear, model.card.input.name
    if model.core == "direct" and k != 0.0:
        what = f"'{path}' is a direct inverse, which is not sheared, and the controller subtracts k q, k = {k:g} Pa/rad"
    elif model.core == "plays" and model.shear is None and k == 0.0 and "sheared" in name.lower():
        what = f"the input {model.card.input.label} of '{path}' holds k q, and the controller subtracts none (shear 0)"
    else:
        return
    yield Finding(
        "pair-doubtful",
        f"{what}: these do not look like files that belong together, and '{controller}' does not say which model it "
        f'was made for. Give the files of one run, or set "shear" right and write the controller again with '
        f"dehyst.control.save_controller(parameters, FILE, model=model).",
    )
