"""dehyst export of a direct inverse: in a joint controller, or as a function block of its own."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import cast

import numpy as np

from dehyst.app.export_request import ExportRequest
from dehyst.app.verdict import verdict_findings
from dehyst.control import load_adaptation, load_controller
from dehyst.errors import ParameterError
from dehyst.export import direct_block_subject, joint_subject
from dehyst.export.numbers import DirectNumbers
from dehyst.export.subject import RAMP, Subject, identifier
from dehyst.findings import Finding
from dehyst.models import DirectInverse

STALLED = 0.01  # of the range: a lag that stops so far from its end in float is worth a word


def direct_subject_of(model: DirectInverse, request: ExportRequest, real: str) -> tuple[Subject, list[Finding]]:
    """Return the unit, and what there is to say about it."""
    _refuse_what_it_is_not(request)
    said = verdict_findings(model, request.model, "Do not let it drive a machine")
    told = [*said, *_idle(model, request)]
    model = model.pruned() if request.prune else model
    name = request.name or identifier(request.model.stem)
    if request.what == "inverse":
        ramp = RAMP if request.ramp is None else request.ramp
        subject = direct_block_subject(
            model, name=name, real=real, period=cast(float, request.period), range=request.range, ramp=ramp
        )
        return subject, [*told, *_stalled(subject)]
    path = cast(Path, request.controller)
    parameters, adaptation = load_controller(path), load_adaptation(path)
    subject = joint_subject(model, parameters, adaptation, name=name, real=real)
    told += [*_units(model), *_stalled(subject)]
    return subject, told


def _refuse_what_it_is_not(request: ExportRequest) -> None:
    if request.what == "inverse":
        _refuse_unfit_block(request)
    if request.what == "forward":
        raise ParameterError(
            f"'{request.model}' is a direct inverse: it answers which input an output needs, and there is no model of "
            f"the output to export. Leave --what forward out, or identify another family for it."
        )


def _refuse_unfit_block(request: ExportRequest) -> None:
    """Refuse what a direct inverse without a controller cannot be exported with."""
    if request.target not in HOLD:
        raise ParameterError(
            f"target '{request.target}' holds a direct inverse inside a joint controller only: --what joint-controller "
            f"--controller FILE. On its own it is exported as C: --target c or --target c-header."
        )
    if request.period is None:
        raise ParameterError(
            f"'{request.model}' is a direct inverse: what creeps depends on the time between two samples, which is not "
            f"known here. Add --period SECONDS, what your target calls it with, for example --period 0.001."
        )
    if request.log is not None:
        raise ParameterError(
            "--log takes one column, but a direct inverse needs its rate and scheduling variables too: leave --log "
            "out; the test signal moves all of them."
        )


HOLD = ("c", "c-header")  # targets of a direct inverse without a controller


def _idle(model: DirectInverse, request: ExportRequest) -> Iterator[Finding]:
    terms = model.radii.size + model.path_lengths.size + model.time_constants.size
    few = model.pruned()
    idle = terms - few.radii.size - few.path_lengths.size - few.time_constants.size
    if idle and not request.prune:
        yield Finding(
            "zero-weights",
            f"{idle} of {terms} stops and lags have weight zero: they take memory and time and change nothing. Add "
            f"--prune to leave them out, which is exact.",
        )


def _units(model: DirectInverse) -> Iterator[Finding]:
    for card, meant in ((model.card.input, "Nm"), (model.card.output, "rad")):
        if not card.unit:
            yield Finding(
                "unit-unknown",
                f"the model does not say in which unit its {card.name or 'signal'} is: it was taken to be in {meant}. "
                f"If it is not, the compensation is wrong by that factor; name the unit in the column and identify "
                f"again.",
            )


def _stalled(subject: Subject) -> Iterator[Finding]:
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
    >>> from dehyst.models import ModelCard, SignalCard
    >>> card = ModelCard(SignalCard("torque", "Nm"), SignalCard("angle", "rad", -1.0, 1.0))
    >>> model = DirectInverse(time_constants=[100.0], creep_weights=[1.0], card=card)
    >>> round(stall(direct_numbers(model.parameters(1e-3))), 4)
    0.006
    """
    largest = max(abs(numbers.input_low), abs(numbers.input_high))
    return 0.5 * float(np.spacing(np.float32(largest))) / min(numbers.gain)
