"""dehyst export: a model, its inverse or a joint controller as code for a target."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import cast

from rich.text import Text

from dehyst.app.context import verdict_findings
from dehyst.app.export_findings import coarse, cost, outside, pair_findings, slow, stalled
from dehyst.app.requests import ExportRequest
from dehyst.app.terminal import ask_progress, print_findings, print_json, terminal
from dehyst.control import load_adaptation, load_controller
from dehyst.errors import ModelFileError, ParameterError
from dehyst.export import Written, export, joint_subject, subject_of
from dehyst.export.folder import refuse_folder
from dehyst.export.joint import unit_findings
from dehyst.export.joint_run import OUTPUTS, REFERENCE, SENSORS
from dehyst.export.names import check_name, identifier, why_prefixed
from dehyst.export.signal import ALL, Part, read_excerpt, use_findings, use_of
from dehyst.export.subject import RAMP, REALS, WHATS, Subject, check_choice
from dehyst.export.targets import target
from dehyst.findings import Finding
from dehyst.models import Model, ShearedPrandtlIshlinskii, load
from dehyst.shell import quoted


def run_export(request: ExportRequest) -> None:
    """Read, make the unit, write the folder, print what it costs."""
    kind = target(request.target)
    real = request.real or kind.reals[0]
    check_choice(request.what, WHATS, "--what")
    check_choice(real, REALS, "--real")
    _refuse_contradictions(request)
    inputs = [path for path in (request.model, request.log, request.controller) if path is not None]
    refuse_folder(request.out, request.overwrite, inputs)
    loaded = load(request.model)
    if loaded.no_export:
        raise ModelFileError(f"model file '{request.model}' cannot be exported: {loaded.no_export}")
    pair = pair_findings(loaded, request.model, request.controller)
    model, request, told = _as_unit(loaded, request)
    _refuse_unknown_range(model, request)
    drives = request.what != "forward" or bool(told)  # a forward model drives nothing
    said = verdict_findings(model, f"'{request.model}'", "Do not let it drive a machine") if drives else []
    findings = [*pair, *said, *told, *outside(model, request), *cost(model, request)]
    model = model.pruned() if request.prune else model
    with ask_progress("exporting", request.json):
        subject, more = _subject(model, request, real)
        more += [*coarse(subject), *stalled(subject), *slow(model, subject)]
        written = export(subject, request.target, request.out, request.overwrite)
    _say(written, subject, request, [*findings, *more])


def _say(written: Written, subject: Subject, request: ExportRequest, findings: list[Finding]) -> None:
    if request.json:
        print_json(_as_dict(written, subject, findings))
        return
    _print(written, subject, request)
    print_findings(findings)
    terminal().print(Text(f"\nnext: dehyst verify {quoted(request.out)}"), soft_wrap=True)


def _as_unit(model: Model, request: ExportRequest) -> tuple[Model, ExportRequest, list[Finding]]:
    """Return a sheared model as the sum of plays that it is: from input to output, or else its compensator alone."""
    if model.shear is None or request.what == "joint-controller":
        return model, request, []
    if not model.no_forward or request.what == "forward":
        return cast(ShearedPrandtlIshlinskii, model).as_play(), request, []
    if request.range is not None:
        raise ParameterError(
            "--range holds an inverse back where the actuator meets its limits, which needs the model itself, and this "
            "sheared one only exists as a compensator. Leave --range out, and limit what the unit answers together "
            "with what it is added to."
        )
    told = Finding(
        "compensator-only",
        f"the model was sheared by k = {model.shear:.4g} and its input alone does not decide its output: it only "
        f"exists as a compensator, what is added to "
        f"{model.card.input.name} (k {model.card.output.name} is subtracted already): the unit runs it forward and "
        f"does not hold back at the actuator's limits. Limit the sum behind it.",
    )
    return model.inverse(), replace(request, what="forward"), [told]


def _refuse_contradictions(request: ExportRequest) -> None:
    if request.log is None and request.column is not None:
        raise ParameterError(
            "--column without --log: an excerpt of your log needs --log LOG, and its column that is the input of what "
            "is exported unless it has the model's name."
        )
    if request.controller is not None and request.what != "joint-controller":
        raise ParameterError("--controller belongs to --what joint-controller; add that, or leave --controller out.")
    if request.controller is None and request.what == "joint-controller":
        raise ParameterError(
            "--what joint-controller needs the parameters of the controller: --controller FILE, written by "
            "`dehyst reproduce` or by dehyst.control.save_controller(parameters, FILE). MODEL is the identified model; "
            "its inverse becomes the compensator."
        )
    if request.what == "joint-controller" and (request.log is not None or request.range is not None):
        raise ParameterError("--log and --range belong to --what inverse or forward; leave them out here.")
    if request.what == "joint-controller" and request.ramp is not None:
        raise ParameterError(
            f'--ramp {request.ramp} belongs to --what inverse or forward; the ramp of a joint controller is "ramp" in '
            f"its file, in seconds. Leave --ramp out and set it there."
        )
    if request.what == "joint-controller" and request.period is not None:
        raise ParameterError(
            f"--period {request.period:g} belongs to a unit of its own; the period of a joint controller is "
            f'"period" in its file, in seconds. Leave --period out and set it there.'
        )
    if request.follow_offset is not None and (request.what == "joint-controller" or request.log is not None):
        other = "--what joint-controller" if request.log is None else "--log"
        why = "learns its own" if request.log is None else "takes one column, and what was measured is another"
        raise ParameterError(f"--follow-offset does not go with {other}, which {why}. Leave one of them out.")
    if request.log is None and _part(request) != ALL:
        raise ParameterError("--run, --from, --to and --time choose a part of --log LOG; add that, or leave them out.")
    if request.name is not None:
        check_name(request.name)


def _part(request: ExportRequest) -> Part:
    return Part(request.run, request.start, request.stop, request.time)


def _refuse_unknown_range(model: Model, request: ExportRequest) -> None:
    card = model.card.input
    if request.range is None and request.what != "joint-controller" and (card.low is None or card.high is None):
        raise ParameterError(
            f"'{request.model}' does not say from where to where its input {card.label} goes: it was not identified "
            f"from a log. Without it a unit has no limits; add --range LO HI, what the actuator can be given."
        )


def _subject(model: Model, request: ExportRequest, real: str) -> tuple[Subject, list[Finding]]:
    name = request.name or identifier(request.model.stem)
    ramp = RAMP if request.ramp is None else request.ramp
    if request.what == "joint-controller":
        path = cast(Path, request.controller)
        subject = joint_subject(model, load_controller(path), load_adaptation(path), name=name, real=real)
        return subject, unit_findings(model)
    excerpt = None
    if request.log is not None and model.unit_needs:
        raise ParameterError(
            "--log takes one column, but this unit needs its rate or scheduling variables too: leave --log out; the "
            "test signal moves all of them."
        )
    if request.log is not None:
        into = model.card.output if request.what == "inverse" else model.card.input
        excerpt = read_excerpt(request.log, request.column or into.name, into, _part(request))
    subject = subject_of(
        model, request.what, name=name, period=request.period, real=real, range=request.range, ramp=ramp,
        excerpt=excerpt.values if excerpt else None, excerpt_source=excerpt.source if excerpt else "",
        follow_offset=request.follow_offset,
    )  # fmt: skip
    if excerpt is None:
        return subject, []
    used = use_findings(subject.excerpt, subject.input) if subject.excerpt else []
    return subject, [*excerpt.findings, *used]


def _as_dict(written: Written, subject: Subject, findings: list[Finding]) -> dict[str, object]:
    return {
        "folder": str(written.folder),
        "name": subject.name,
        "what": subject.what,
        "real": subject.real,
        "operators": subject.operators,
        "files": list(written.files),
        "bytes": written.size,
        "budget": written.budget.as_dict(),
        "excerpt_samples": 0 if subject.excerpt is None else subject.excerpt.samples,
        "warnings": [finding.as_dict() for finding in findings],
    }


def _print(written: Written, subject: Subject, request: ExportRequest) -> None:
    out = terminal()
    lines = [
        f"{subject.title}",
        f"{subject.real} precision, names begin with {subject.name}_{_why(request)}",
        *_interface(subject),
        *written.budget.lines(),
        _check_line(subject),
        f"wrote {len(written.files)} files, {written.size / 1e3:.0f} kB: {written.folder}",
    ]
    for line in lines:
        out.print(Text(line), soft_wrap=True)


def _why(request: ExportRequest) -> str:
    """Say why the name is not that of the model's file."""
    why = "" if request.name else why_prefixed(request.model.stem)
    return f" ({why}; --name NAME chooses another)" if why else ""


def _interface(subject: Subject) -> list[str]:
    if subject.block is not None:
        every = f", every {subject.period:.9g} s" if subject.period else ""
        names = ", ".join((*subject.block.inputs, "on"))
        more = [f"a step takes {names}{every}"] if subject.period or subject.more else []
        return [f"input {subject.input!s}; output {subject.output!s}", *more]
    shown = (("sensors", SENSORS), ("references", REFERENCE), ("outputs", OUTPUTS))
    return [f"{what}: " + ", ".join(f"{name} [{_unit(name)}]" for name in names) for what, names in shown]


def _unit(name: str) -> str:
    """Unit of a signal of a joint controller."""
    words = {"angle": "rad", "velocity": "rad/s", "acceleration": "rad/s^2", "valve": "-1 .. 1"}
    torques = ("load", "torque", "integrator")
    first = name.split("_")[0]
    return words.get(first, "Nm" if first in torques else "Pa")


def _check_line(subject: Subject) -> str:
    if subject.joint is not None:
        return f"check: recorded run of {subject.test.samples} periods with switching and faults"
    signal = f"check: test signal of {subject.test.samples} samples"
    if subject.more:
        return f"{signal} with {', '.join(name for name, _ in subject.more)}, limits, switching and no numbers"
    if subject.excerpt is None:
        return f"{signal}, none of your log (add --log LOG --column COLUMN)"
    limited, share = use_of(subject.excerpt, subject.input)
    told = f"{limited} of them limited, {100 * share:.3g} % of the range"
    return f"{signal}, {subject.excerpt.samples} samples of {subject.excerpt_source} ({told})"
