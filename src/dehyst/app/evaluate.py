"""dehyst evaluate: saved models of any family on another log, one table, and which one to run."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import nullcontext

from rich.table import Column
from rich.text import Text

from dehyst.app.ending import Status, concluding
from dehyst.app.logs import Read, recordings_of, signals_of, verdict_findings
from dehyst.app.requests import EvaluateRequest
from dehyst.app.terminal import ask_progress, print_end, print_findings, print_json, table, terminal
from dehyst.errors import ColumnError, ParameterError
from dehyst.findings import Finding
from dehyst.models import Model, load
from dehyst.models.start import ABOUT, DEFAULT
from dehyst.monitoring.evaluate import Evaluation, Scored, evaluate
from dehyst.shell import command

LONGEST_NAME = 32  # of a file, in a table of 80 columns beside a family and five numbers


def run_evaluate(request: EvaluateRequest) -> None:
    """Read, score, print."""
    models = {str(path): load(path) for path in request.models}
    if len(models) < len(request.models):
        raise ParameterError(f"a model is named twice: {', '.join(map(str, request.models))}. Name each once.")
    with ask_progress("reading", request.json):
        read = _read(request, list(models.values()))
        signals, _ = signals_of(request, read, [card for model in models.values() for card in model.context])
    with ask_progress("evaluating", request.json):
        found = evaluate(
            models,
            [record for *_, record in read],
            follow_offset=request.follow_offset,
            start=request.begin or DEFAULT,
            **signals,
        )
    with nullcontext() if found.run else concluding(Status.NO):
        if request.json:
            print_json(found.as_dict())
        else:
            _print(found, request)


def _read(request: EvaluateRequest, models: Sequence[Model]) -> list[Read]:
    """Read the log; columns that are not named are those of the models' cards."""
    pairs = {(model.card.input.name, model.card.output.name) for model in models}
    if len(pairs) > 1 and not (request.input and request.output):
        said = "; ".join(f"{driven} -> {answer}" for driven, answer in sorted(pairs))
        raise ColumnError(
            f"the models name different signals ({said}). Say which columns of '{request.log}' hold input and output: "
            f"--input COLUMN --output COLUMN."
        )
    card, log = models[0].card, request.log
    try:
        return [
            (log, run, record) for run in request.runs or (None,) for record in recordings_of(request, log, run, card)
        ]
    except ColumnError as fault:
        if request.input and request.output:
            raise
        raise ColumnError(
            f"{fault}. It is a signal of '{request.models[0]}'; if other columns hold that, add --input COLUMN "
            f"--output COLUMN.",
            **fault.facts,
        ) from None


def _heads(longest: int) -> tuple[Column, ...]:
    """Columns of the table, for names of models of up to so many letters: where room lacks, families are wrapped."""
    numbers = [
        Column(head, justify="right", no_wrap=True, overflow="fold")
        for head in ("output %", "bias %", "input %", "bias %", "clipped %")
    ]
    # A name that was cut could not be typed again.
    model = Column("model", overflow="fold", min_width=min(longest, LONGEST_NAME))
    return model, Column("family", overflow="fold"), *numbers


def _print(found: Evaluation, request: EvaluateRequest) -> None:
    out = terminal()
    out.print(f"run {found.run}: {found.why}" if found.run else found.why, style="bold", soft_wrap=True)
    out.print()
    heads = _heads(max(len(entry.name) for entry in found.entries))
    best = next((k for k, entry in enumerate(found.entries) if entry.name == found.run), None)
    out.print(table(heads, map(_row, found.entries), bold=best))
    first = found.recordings[0]
    out.print(
        f"rms without bias, and bias, in percent of the range in this log: output {first.output_name}, and input "
        f"{first.input_name} that the inverse asks for, kept within the identified range",
        soft_wrap=True,
    )
    start = request.begin or DEFAULT
    out.print(f"start: {start}, {ABOUT[start]}", soft_wrap=True)
    if request.follow_offset is not None:
        share = 100.0 * request.follow_offset
        out.print(f"outputs are scored with an offset that follows the last cycle, within {share:g} % of range")
    reasons = [entry for entry in found.entries if entry.reason]
    if reasons:
        out.print()
    for entry in reasons:
        out.print(Text.assemble((entry.name, "bold"), f": {entry.reason}"), soft_wrap=True)
    print_findings(found.findings)
    for names, shared in _by_models(found).items():
        if len(found.entries) > 1:
            out.print()
            out.print(", ".join(names), style="bold", soft_wrap=True)
        print_findings(shared)
    print_end(_next(found, request))


def _by_models(found: Evaluation) -> dict[tuple[str, ...], list[Finding]]:
    """Return findings under the names of the models that they hold for: what several share is said once."""
    names: dict[Finding, list[str]] = {}
    for entry in found.entries:
        for finding in (*entry.findings, *verdict_findings(entry.model, "it")):
            names.setdefault(finding, []).append(entry.name)
    shared: dict[tuple[str, ...], list[Finding]] = {}
    for finding, holders in names.items():
        shared.setdefault(tuple(holders), []).append(finding)
    return shared


def _row(entry: Scored) -> tuple[str, ...]:
    output = ("none", "") if entry.output is None else (f"{entry.error_percent:.3g}", f"{entry.bias_percent:+.2g}")
    asked = entry.input
    input = ("none", "", "") if asked is None else (
        f"{entry.input_percent:.3g}", f"{asked.bias_percent:+.2g}", f"{100 * entry.clipped:.2g}",
    )  # fmt: skip
    return (entry.name, entry.model.family, *output, *input)


def _next(found: Evaluation, request: EvaluateRequest) -> str:
    if found.run is None:
        return command("identify", request.log, save="model.json")
    model = found[found.run].model
    needs = dict.fromkeys(model.needs, "COLUMN")
    return command("compensate", found.run, "REFERENCE.csv", output=request.output or model.card.output.name, **needs)
