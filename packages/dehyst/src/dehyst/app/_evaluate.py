"""dehyst evaluate: saved models of any family on another log, one table, and which one to run."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import nullcontext

from rich.table import Column, Table
from rich.text import Text

from dehyst.app._ending import Status, concluding
from dehyst.app._logs import Read, Shares, recordings_of, verdict_findings, with_schedules
from dehyst.app._play_coupled import refuse_coupled
from dehyst.app._terminal import (
    ask_progress,
    print_end,
    print_findings,
    print_json,
    table,
    terminal,
)
from dehyst.app.requests import EvaluateRequest
from dehyst.errors import ColumnError, ParameterError
from dehyst.findings import Finding
from dehyst.models import Model, SignalCard, load
from dehyst.models import kit as models_kit
from dehyst.monitoring import Evaluation, Scored, evaluate
from dehyst.shell import command, schedules_to_type

LONGEST_NAME = 32  # of a file, in a table of 80 columns beside a family and five numbers


def run_evaluate(request: EvaluateRequest) -> None:
    """Read, score, print."""
    models = {str(path): load(path) for path in request.models}
    refuse_coupled(models, "evaluate")
    # The same file twice would be compared with itself.
    if len(models) < len(request.models):
        raise ParameterError(
            f"a model is named twice: {', '.join(map(str, request.models))}. Name each once."
        )
    with ask_progress("reading", request.json) as progress:
        read = _read(request, list(models.values()), progress)
        cards: list[SignalCard] = []
        for model in models.values():
            cards += model.context
        read = with_schedules(request, read, cards)
    with ask_progress("evaluating", request.json):
        evaluation = evaluate(
            models,
            [record for *_, record in read],
            follow_offset=request.follow_offset,
            start=request.begin or models_kit.DEFAULT,
        )
    # A script may ask the status whether one of the models can run.
    with nullcontext() if evaluation.run else concluding(Status.NO):
        if request.json:
            print_json(evaluation.as_dict())
        else:
            _print(evaluation, request)


def _read(request: EvaluateRequest, models: Sequence[Model], progress: Shares) -> list[Read]:
    """Read the log; columns that are not named are those of the models' cards."""
    pairs = {(model.card.input.name, model.card.output.name) for model in models}
    # One pair of columns is read for all models, and none of their cards can decide for the others.
    if len(pairs) > 1 and not (request.input and request.output):
        pairs_named = "; ".join(f"{driven} -> {answer}" for driven, answer in sorted(pairs))
        raise ColumnError(
            f"the models name different signals ({pairs_named}). Say which columns of '{request.log}' hold input and "
            f"output: --input COLUMN --output COLUMN."
        )
    card, log = models[0].card, request.log
    try:
        read = []
        for run in request.runs or (None,):
            for record in recordings_of(request, log, run, card, progress):
                read.append((log, run, record))
        return read
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
    numbers = []
    for head in ("output %", "bias %", "input %", "bias %", "clipped %"):
        numbers.append(Column(head, justify="right", no_wrap=True, overflow="fold"))
    # A name that was cut could not be typed again.
    model = Column("model", overflow="fold", min_width=min(longest, LONGEST_NAME))
    return model, Column("family", overflow="fold"), *numbers


def _print(evaluation: Evaluation, request: EvaluateRequest) -> None:
    """Print which model to run and why, a row a model, and what limits their errors."""
    out = terminal()
    verdict = evaluation.why
    if evaluation.run:
        verdict = f"run {evaluation.run}: {verdict}"
    out.print(verdict, style="bold", soft_wrap=True)
    out.print()
    names = [entry.name for entry in evaluation.entries]
    best = names.index(evaluation.run) if evaluation.run in names else None
    # Numbers are worth more than a line that fits: a terminal that is too narrow breaks it.
    scores = table(_heads(max(map(len, names))), map(_row, evaluation.entries), bold=best)
    out.print(scores, crop=False)
    first = evaluation.recordings[0]
    out.print(
        f"rms without bias, and bias, in percent of the range in this log: output {first.output_name}, and input "
        f"{first.input_name} that the inverse asks for, kept within the identified range",
        soft_wrap=True,
    )
    start = request.begin or models_kit.DEFAULT
    out.print(f"start: {start}, {models_kit.ABOUT[start]}", soft_wrap=True)
    if request.follow_offset is not None:
        share = 100.0 * request.follow_offset
        out.print(
            f"outputs are scored with an offset that follows the last cycle, within {share:g} % of range"
        )
    if evaluation.loops is not None:
        out.print()
        out.print(_loops(evaluation), crop=False)
        out.print(
            "largest loops of the log, and of what each model makes of its input; width at the middle",
            soft_wrap=True,
        )
    reasons = [entry for entry in evaluation.entries if entry.reason]
    if reasons:
        out.print()
    for entry in reasons:
        out.print(Text.assemble((entry.name, "bold"), f": {entry.reason}"), soft_wrap=True)
    print_findings(evaluation.findings)
    for holders, shared in _by_models(evaluation).items():
        # With a single model its name above each warning would be no news.
        if len(names) > 1:
            out.print()
            out.print(", ".join(holders), style="bold", soft_wrap=True)
        print_findings(shared)
    print_end(_next(evaluation, request))


def _by_models(evaluation: Evaluation) -> dict[tuple[str, ...], list[Finding]]:
    """Return findings under the names of the models that they hold for: what several share is said once."""
    names: dict[Finding, list[str]] = {}
    for entry in evaluation.entries:
        for finding in (*entry.findings, *verdict_findings(entry.model, "it")):
            names.setdefault(finding, []).append(entry.name)
    shared: dict[tuple[str, ...], list[Finding]] = {}
    for finding, holders in names.items():
        shared.setdefault(tuple(holders), []).append(finding)
    return shared


def _row(entry: Scored) -> tuple[str, ...]:
    """A model in the table: errors of output and input, "none" where there is none."""
    output, input = ("none", ""), ("none", "", "")
    if entry.output is not None:
        output = (f"{entry.error_percent:.3g}", f"{entry.bias_percent:+.2g}")
    if entry.input is not None:
        bias, clipped = f"{entry.input.bias_percent:+.2g}", f"{100 * entry.clipped:.2g}"
        input = (f"{entry.input_percent:.3g}", bias, clipped)
    return (entry.name, entry.model.family, *output, *input)


def _loops(evaluation: Evaluation) -> Table:
    """Numbers of the measured loops, and below them those of each model that has any."""
    measured = [("measured", evaluation.loops)]
    for entry in evaluation.entries:
        measured.append((entry.name, entry.loops))
    rows = []
    for name, loops in measured:
        if loops is not None:
            numbers = loops.estimates
            area = str(numbers["area"])
            rows.append((name, str(numbers["width"]), area, str(numbers["coercivity"])))
    heads = [Column("loop", overflow="fold")]
    for head in ("width", "area", "coercivity"):
        heads.append(Column(head, no_wrap=True, overflow="fold"))
    return table(heads, rows)


def _next(evaluation: Evaluation, request: EvaluateRequest) -> str:
    if evaluation.run is None:
        return command("identify", request.log, save="model.json")
    model = evaluation[evaluation.run].model
    needs = schedules_to_type(model.needs)
    return command(
        "compensate",
        evaluation.run,
        "REFERENCE.csv",
        output=request.output or model.card.output.name,
        **model.wing_to_type,
        **needs,
    )
