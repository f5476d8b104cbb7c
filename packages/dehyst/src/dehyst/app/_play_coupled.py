"""What simulate and compensate do with a model of several inputs, and who else refuses one."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import fields
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from dehyst.app._logs import log_part, outside
from dehyst.app._targets import place_of, write_new
from dehyst.app._terminal import ask_progress, print_findings, tell
from dehyst.app.requests import CompensateRequest, SimulateRequest
from dehyst.arrays import Array
from dehyst.errors import OutputError, ParameterError, TimeError
from dehyst.findings import Finding
from dehyst.io import format_csv, read_columns
from dehyst.models import Model, SignalCard, load
from dehyst.models import kit as models_kit

if TYPE_CHECKING:
    from dehyst.families import kit as families_kit

# Of simulate and compensate, what a model of several inputs has.
PLAYED = (
    "model", "log", "time", "time_unit", "dt", "sheet", "run", "start", "stop", "out", "overwrite",
)  # fmt: skip


def coupled_in(model: Model) -> families_kit.CoupledModel | None:
    """Return a model of several inputs as such, None for any other."""
    # Other models are played without the room that fits families.
    if model.file_kind != "dehyst-coupled":
        return None
    from dehyst.families import kit as families_kit

    return model if isinstance(model, families_kit.CoupledModel) else None


def play_coupled(request: SimulateRequest) -> bool:
    """Write what a model of several inputs answers, or its inverse; False for a model of one input."""
    model = coupled_in(load(request.model))
    if model is None:
        return False
    backward = isinstance(request, CompensateRequest)
    _refuse_options(request)
    wanted = model.outputs if backward else model.inputs
    columns = {card.name: card.name for card in wanted}
    known = []
    if backward and len(model.outputs) == 1:
        # One output tells one input; the others must be known.
        known = [card for i, card in enumerate(model.inputs) if i != model.own[0]]
        columns |= {card.name: card.name for card in known}
    with ask_progress("reading"):
        log = read_columns(request.log, columns, run=request.run, **log_part(request))
    if log.time is None and model.rate_dependent:
        raise TimeError(
            f"'{request.model}' creeps or depends on the rate, and '{request.log}' has no time column. Name it with "
            f"--time, or type --dt SECONDS.",
            log=str(request.log),
        )
    findings: list[Finding] = list(log.findings)
    values = {}
    for card in (*wanted, *known):
        values[card.name], more = models_kit.in_units_of(
            card, log.values[card.name], log.units[card.name], f"'{log.names[card.name]}'"
        )
        findings += more
        findings += outside(values[card.name], card, card.name, "the model extrapolates there")
    samples = np.column_stack([values[card.name] for card in wanted])
    answers, tails = _answers(
        model, samples, log.time, backward, {c.name: values[c.name] for c in known}
    )
    if backward:
        for card, column in zip(tails, answers.T, strict=True):
            findings += outside(
                column, card, f"computed {card.name}", "the actuator may not be able to give it"
            )
    prefix = "compensated" if backward else "model"
    columns_out: dict[str, npt.ArrayLike] = {}
    if log.time is not None:
        columns_out["time [s]"] = log.time
    columns_out |= {card.label: values[card.name] for card in wanted}
    for card, column in zip(tails, answers.T, strict=True):
        columns_out[f"{prefix} {card.label}"] = column
    write_columns(request, columns_out)
    rest = ", ".join(
        f"{card.name} = {value:.4g}" for card, value in zip(model.inputs, model.rest, strict=True)
    )
    tell(f"start: at rest at {rest}, as the log of the model began")
    print_findings(findings, stderr=True)
    return True


def write_columns(request: SimulateRequest, columns: Mapping[str, npt.ArrayLike]) -> None:
    """Write columns to the file that was asked for, or to the terminal."""
    text = format_csv(columns, request.out or "the table")
    if request.out is None:
        sys.stdout.write(text)
    else:
        # Checked only now: the file may hold just this content, which is then no loss.
        write_new(request.out, request.overwrite, text)
        tell(f"wrote {request.out}: {', '.join(columns)}")


def refuse_coupled(models: Mapping[str, Model], verb: str) -> None:
    """Refuse a command that takes models of one input."""
    for path, model in models.items():
        coupled = coupled_in(model)
        if coupled is not None:
            names = ", ".join(card.name for card in coupled.inputs)
            raise ParameterError(
                f"'{path}' is a model of the inputs {names}, and dehyst {verb} takes models of one input. Its held-out "
                f"errors are those that dehyst coupled prints; dehyst simulate and dehyst compensate play it.",
                model=path,
            )


def _answers(
    model: families_kit.CoupledModel,
    samples: Array,
    time: Array | None,
    backward: bool,
    known: dict[str, Array],
) -> tuple[Array, tuple[SignalCard, ...]]:
    """Return what the model, or its inverse, answers, and the signals of it."""
    with ask_progress("inverting" if backward else "simulating"):
        if not backward:
            return model.simulate(samples, time), model.outputs
        demand = model.inverse().simulate(samples, time, **known)
    if len(model.outputs) == 1:
        return demand[:, list(model.own)], (model.inputs[model.own[0]],)
    return demand, model.inputs


def _refuse_options(request: SimulateRequest) -> None:
    """Refuse options that a model of several inputs does not have, and a file that would be lost."""
    typed = []
    for entry in fields(request):
        if entry.name in PLAYED:
            continue
        if getattr(request, entry.name) != entry.default:
            typed.append(entry.metadata.get("flag") or f"--{entry.name.replace('_', '-')}")
    if typed:
        raise ParameterError(
            f"{' and '.join(typed)}: a model of several inputs begins at rest, where its log began, and finds its "
            f"columns by their names. Leave it out.",
            options=typed,
        )
    if request.out is not None and place_of(request.out) in {
        place_of(request.log),
        place_of(request.model),
    }:
        raise OutputError(
            f"'{request.out}' is the log or the model itself; writing there would lose it. Name another file."
        )
