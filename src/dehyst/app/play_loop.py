"""simulate and compensate with a model of a family of the literature."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from dehyst.app.play import PlayRequest, about, in_units_of, jumps, outside, refuse_schedules, write
from dehyst.app.start import MODEL, REST, UNKNOWN, say, start_of
from dehyst.app.terminal import print_findings
from dehyst.app.unknown import column
from dehyst.app.verdict import verdict_findings
from dehyst.errors import ParameterError, TimeError
from dehyst.families import LoopModel
from dehyst.findings import Finding
from dehyst.io import Signal

Array = npt.NDArray[np.float64]


def simulate_loop(request: PlayRequest, model: LoopModel, signal: Signal) -> None:
    """Write time, input and the model's output."""
    model, start = _begun(request, model)
    x, findings = in_units_of(model.card.input, signal)
    findings += outside(x, model.card.input, "input", "the model extrapolates there")
    y = model.simulate(x, _time(request, model, signal))
    write(request, signal, {column(model.card.input): x, column(model.card.output, "model"): y})
    say(start)
    print_findings([*about(signal, "input"), *findings], stderr=True)


def compensate_loop(request: PlayRequest, model: LoopModel, signal: Signal) -> None:
    """Write time, wanted output and the input that produces it."""
    model, start = _begun(request, model)
    said = verdict_findings(model, request.model, "Do not apply this input to a machine")
    y, findings = in_units_of(model.card.output, signal)
    findings += outside(y, model.card.output, "reference", "the inverse extrapolates there")
    time = _time(request, model, signal)
    x = model.inverse().simulate(y, time)
    findings += outside(x, model.card.input, "computed input", "the actuator may not be able to give it")
    findings += jumps(x, model.card.input, signal) + _proof(model, x, y, time)
    write(request, signal, {column(model.card.output): y, column(model.card.input, "compensated"): x})
    say(start)
    print_findings([*said, *about(signal, "reference"), *findings], stderr=True)


def _begun(request: PlayRequest, model: LoopModel) -> tuple[LoopModel, str]:
    """Return the model with the start that was asked for, and the name of that."""
    refuse_schedules(request)
    start = start_of(request, MODEL)
    if start == UNKNOWN:
        raise ParameterError(
            f"an unknown past (--unknown-state, --start unknown) needs a model whose memory is bounded, of `dehyst "
            f"identify`; '{request.model}' is a {model.family} model. Leave it out, or choose --start rest."
        )
    return (model.with_start(REST) if start == REST else model), start


def _time(request: PlayRequest, model: LoopModel, signal: Signal) -> Array | None:
    if not model.rate_dependent:
        return None
    if signal.time is None:
        raise TimeError(
            f"'{request.model}' is a {model.family} model, which depends on time, and '{request.log}' has no time "
            f"column. Name it with --time, or add one.",
            log=str(request.log),
        )
    return signal.time


def _proof(model: LoopModel, x: Array, y: Array, time: Array | None) -> list[Finding]:
    """Run the model on the computed input: it must give the reference back, from the first sample on."""
    error, span = float(np.max(np.abs(model.simulate(x, time) - y))), max(float(np.ptp(y)), 1e-300)
    if error <= 1e-6 * span:
        return []
    return [
        Finding(
            "round-trip",
            f"the model's answer to the computed input differs from the reference by up to {error:.3g} "
            f"({100 * error / span:.2g} % of its range): the model cannot reach it there. Keep the reference within "
            f"the identified range.",
        )
    ]
