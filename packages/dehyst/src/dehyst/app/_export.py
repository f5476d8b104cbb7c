"""dehyst export: a model, its inverse or a joint controller as code for a target, and what it costs there."""

from __future__ import annotations

from dataclasses import fields, replace
from pathlib import Path
from typing import cast

from dehyst.app._logs import dead_time_findings, verdict_findings
from dehyst.app._terminal import (
    ask_progress,
    percent,
    print_end,
    print_findings,
    print_json,
    terminal,
)
from dehyst.app.requests import ExportRequest
from dehyst.errors import ModelFileError, ParameterError
from dehyst.export import SignalPart, Subject, Written, export, subject_of, write_pair
from dehyst.export import kit as export_kit
from dehyst.families import kit as families_kit
from dehyst.findings import Finding
from dehyst.models import Model, ShearedPrandtlIshlinskii, load
from dehyst.shell import command

REFERENCE_AHEAD = (
    "give the unit the reference that much ahead (or, where nobody knows it before it is due, identify again with "
    "--ahead 0)"
)


def run_export(request: ExportRequest) -> None:
    """Read, make the unit, write the folder, print what it costs."""
    kind = export_kit.target(request.target)
    real = request.real or kind.reals[0]
    if request.what not in export_kit.WHATS:
        export_kit.controller_kind(request.what)  # refuses what nobody knows
    export_kit.check_choice(real, export_kit.REALS, "--real")
    _refuse_contradictions(request)
    # A folder that is written anew must not hold what is read.
    inputs = [path for path in (request.model, request.log, request.controller) if path is not None]
    export_kit.refuse_folder(request.out, request.overwrite, inputs)
    loaded = load(request.model)
    if isinstance(loaded, families_kit.CoupledModel):
        _export_pair(loaded, request, real)
        return
    # Refused before the long work, and before an earlier folder is touched.
    if loaded.no_export:
        raise ModelFileError(f"model file '{request.model}' cannot be exported: {loaded.no_export}")
    pair: list[Finding] = []
    if request.controller is not None:
        pair = export_kit.controller_kind(request.what).pair_findings(
            loaded, request.model, request.controller
        )
    model, request, unit_finding = _as_unit(loaded, request)
    _refuse_unknown_range(model, request)
    findings = list(pair)
    if request.what != "forward" or unit_finding:  # a forward model drives nothing
        findings += verdict_findings(model, f"'{request.model}'", "Do not let it drive a machine")
        findings += dead_time_findings(model, REFERENCE_AHEAD)
    findings += unit_finding
    # Operators without weight cost time and memory on the target and change no number.
    if request.prune:
        model = model.pruned()
    with ask_progress("exporting", request.json):
        subject, more = _subject(model, request, real)
        check_own_name = kind.load().check_own_name
        # A name that the user typed is refused if the language of the target reserves it; ours is made to fit.
        if request.name is not None and check_own_name is not None:
            check_own_name(subject)
        written = export(subject, request.target, request.out, request.overwrite)
    findings += [*more, *written.findings]
    if request.json:
        print_json(_as_dict(written, subject, findings))
        return
    _print(written, subject, request)
    print_findings(findings)
    print_end(command("verify", request.out))


# Of `dehyst export`, what a model of two inputs has.
OF_PAIR = ("model", "target", "out", "real", "what", "period", "name", "overwrite", "json")


def _export_pair(model: families_kit.CoupledModel, request: ExportRequest, real: str) -> None:
    """Write C for two inputs and two outputs, and say where."""
    typed = []
    for entry in fields(request):
        if entry.name not in OF_PAIR and getattr(request, entry.name) != entry.default:
            typed.append(f"--{entry.name.replace('_', '-')}")
    if typed or request.target != "c" or request.what not in export_kit.WHATS:
        others = ", ".join([*typed, f"--target {request.target}", f"--what {request.what}"])
        raise ParameterError(
            f"'{request.model}' has {len(model.inputs)} inputs, and a unit of several is written in C alone, with its "
            f"identified ranges as limits; typed was {others}. Type: "
            f"{command('export', request.model, target='c', out=request.out)}",
            options=typed,
        )
    name = request.name or export_kit.identifier(request.model.stem)
    with ask_progress("exporting", request.json):
        files = write_pair(
            model, request.out, name=name, direction=request.what, real=real, period=request.period,
            overwrite=request.overwrite,
        )  # fmt: skip
    if request.json:
        print_json(
            {
                "folder": str(request.out),
                "name": name,
                "what": request.what,
                "real": real,
                "files": [*files],
            }
        )
        return
    terminal().print(
        f"{real} precision, names begin with {name}_; wrote {len(files)} files: {request.out}",
        soft_wrap=True,
    )
    print_end(command("verify", request.out))


def _as_unit(model: Model, request: ExportRequest) -> tuple[Model, ExportRequest, list[Finding]]:
    """Return a sheared model as the sum of plays that it is: from input to output, or else its compensator alone."""
    if model.shear is None or request.what not in export_kit.WHATS:
        return model, request, []
    if not model.no_forward or request.what == "forward":
        return cast(ShearedPrandtlIshlinskii, model).as_play(), request, []
    if request.range is not None:
        raise ParameterError(
            "--range holds an inverse back where the actuator meets its limits, which needs the model itself, and this "
            "sheared one only exists as a compensator. Leave --range out, and limit what the unit answers together "
            "with what it is added to."
        )
    finding = Finding(
        "compensator-only",
        f"the model was sheared by k = {model.shear:.4g} and its input alone does not decide its output: it only "
        f"exists as a compensator, what is added to "
        f"{model.card.input.name} (k {model.card.output.name} is subtracted already): the unit runs it forward and "
        f"does not hold back at the actuator's limits. Limit the sum behind it.",
    )
    return model.inverse(), replace(request, what="forward"), [finding]


def _refuse_contradictions(request: ExportRequest) -> None:
    # Each contradiction says which options exclude each other: a silent choice would surprise on the machine.
    is_controller = request.what not in export_kit.WHATS
    if request.log is None and request.column is not None:
        raise ParameterError(
            "--column without --log: an excerpt of your log needs --log LOG, and its column that is the input of what "
            "is exported unless it has the model's name."
        )
    if request.controller is not None and not is_controller:
        raise ParameterError(
            "--controller belongs to --what joint-controller; add that, or leave --controller out."
        )
    if request.controller is None and is_controller:
        raise ParameterError(
            "--what joint-controller needs the parameters of the controller: --controller FILE, written by "
            "`dehyst reproduce` or by dehyst_robot.control.save_controller(parameters, FILE). MODEL is the identified "
            "model; its inverse becomes the compensator."
        )
    if is_controller and (request.log is not None or request.range is not None):
        raise ParameterError(
            "--log and --range belong to --what inverse or forward; leave them out here."
        )
    if is_controller and request.ramp is not None:
        raise ParameterError(
            f'--ramp {request.ramp} belongs to --what inverse or forward; the ramp of a joint controller is "ramp" in '
            f"its file, in seconds. Leave --ramp out and set it there."
        )
    if is_controller and request.period is not None:
        raise ParameterError(
            f"--period {request.period:g} belongs to a unit of its own; the period of a joint controller is "
            f'"period" in its file, in seconds. Leave --period out and set it there.'
        )
    if request.tunable and is_controller:
        line = command(
            "export", request.model, target=request.target, what=request.what, controller=request.controller,
            out=request.out, overwrite=True,
        )  # fmt: skip
        raise ParameterError(
            f"--tunable belongs to --what inverse or forward: the numbers of a joint controller hold for each other "
            f"and for its period (period * pole and period * pressure_gain below 1, the observer faster than the "
            f"position law), and its integrator, observer and learned scales are of those it ran with: one that is "
            f"changed alone, while it runs, can make the loop swing. Change what you want in its file, and export "
            f"again without --tunable: {line}. While it runs, "
            f"reference, load, mean pressure, extra and the switches may change; the file in calibration/ shows all "
            f"its numbers."
        )
    if request.follow_offset is not None and (is_controller or request.log is not None):
        opposite = "--log, which takes one column, and what was measured is another"
        if request.log is None:
            opposite = "--what joint-controller, which learns its own"
        raise ParameterError(f"--follow-offset does not go with {opposite}. Leave one of them out.")
    if request.retain and is_controller:
        raise ParameterError(
            f"--retain belongs to --what inverse or forward: a PLC keeps the memory of a block, and --what "
            f"{request.what} is exported as C, which says itself what it saves and restores. Leave --retain out."
        )
    if request.log is None and _part(request) != export_kit.ALL:
        raise ParameterError(
            "--run, --from, --to and --time choose a part of --log LOG; add that, or leave them out."
        )
    if request.name is not None:
        export_kit.check_name(request.name)


def _part(request: ExportRequest) -> SignalPart:
    return SignalPart(request.run, request.start, request.stop, request.time, request.sheet)


def _refuse_unknown_range(model: Model, request: ExportRequest) -> None:
    """Refuse a unit whose limits nobody has named."""
    card = model.card.input
    # A range that was typed is the limit, and a joint controller has limits of its own.
    if request.range is not None or request.what not in export_kit.WHATS:
        return
    if card.low is None or card.high is None:
        raise ParameterError(
            f"'{request.model}' does not say from where to where its input {card.label} goes: it was not identified "
            f"from a log. Without it a unit has no limits; add --range LO HI, what the actuator can be given."
        )


def _subject(model: Model, request: ExportRequest, real: str) -> tuple[Subject, list[Finding]]:
    name = request.name or export_kit.identifier(request.model.stem)
    ramp = export_kit.RAMP
    if request.ramp is not None:
        ramp = request.ramp
    if request.what not in export_kit.WHATS:
        path = cast(Path, request.controller)
        return export_kit.controller_kind(request.what).from_file(model, path, name=name, real=real)
    excerpt = None
    # One column cannot move several inputs.
    if request.log is not None and model.unit_needs:
        raise ParameterError(
            "--log takes one column, but this unit needs its rate or scheduling variables too: leave --log out; the "
            "test signal moves all of them."
        )
    if request.log is not None:
        # An inverse is driven by what the output should be.
        into = model.card.input
        if request.what == "inverse":
            into = model.card.output
        excerpt = export_kit.read_excerpt(
            request.log, request.column or into.name, into, _part(request)
        )
    subject = subject_of(
        model, request.what, name=name, period=request.period, real=real, range=request.range, ramp=ramp,
        excerpt=excerpt.values if excerpt else None, excerpt_source=excerpt.source if excerpt else "",
        follow_offset=request.follow_offset, retain=request.retain, tunable=request.tunable,
    )  # fmt: skip
    if excerpt is None:
        return subject, []
    findings = list(excerpt.findings)
    if subject.excerpt:
        findings += export_kit.use_findings(subject.excerpt, subject.input)
    return subject, findings


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
    """Print what was exported, what it costs, and where it was written."""
    named = f"names begin with {subject.name}_"
    # Why the name is not that of the model's file.
    why = "" if request.name else export_kit.why_prefixed(request.model.stem)
    if why:
        named += f" ({why}; --name NAME chooses another)"
    lines = (
        subject.title,
        f"{subject.real} precision, {named}",
        *_interface(subject),
        *written.budget.lines(),
        *_shares(subject, request.period),
        _check_line(subject),
        f"wrote {len(written.files)} files, {written.size / 1e3:.0f} kB: {written.folder}",
    )
    # Lines are not wrapped, so that a path can be copied whole.
    for line in lines:
        terminal().print(line, soft_wrap=True)


def _shares(subject: Subject, asked: float | None) -> list[str]:
    """How much of its period a step takes on each processor with a clock."""
    # A unit that does not depend on time has no period, and the controller that calls it has one.
    period = subject.period or asked
    if period is None:
        return []
    shares = []
    for name, (usual, most) in export_kit.budget(subject).seconds().items():
        clock = f"{name} at {export_kit.CLOCKS[name] / 1e6:.0f} MHz"
        shares.append(f"{clock} {percent(usual / period)}, {percent(most / period)} at most")
    if not shares:
        return []
    return [f"of the period, at one instruction a cycle: {', '.join(shares)}"]


def _interface(subject: Subject) -> list[str]:
    """What goes into a unit and comes out of it."""
    if subject.block is None:
        return export_kit.controller_kind(subject.what).shown_interface()
    lines = [f"input {subject.input!s}; output {subject.output!s}"]
    # A unit that depends on its input alone takes one number, which needs no words.
    if subject.period or subject.more:
        step = f"a step takes {', '.join((*subject.block.inputs, 'on'))}"
        if subject.period:
            step += f", every {subject.period:.9g} s"
        lines.append(step)
    return lines


def _check_line(subject: Subject) -> str:
    if subject.joint is not None:
        return f"check: recorded run of {subject.test.samples} periods with switching and faults"
    signal = f"check: test signal of {subject.test.samples} samples"
    if subject.more:
        return f"{signal} with {', '.join(name for name, _ in subject.more)}, limits, switching and no numbers"
    if subject.excerpt is None:
        return f"{signal}, none of your log (add --log LOG --column COLUMN)"
    limited, share = export_kit.use_of(subject.excerpt, subject.input)
    summary = f"{limited} of them limited; they span {100 * share:.3g} % of the input range"
    return f"{signal}, {subject.excerpt.samples} samples of {subject.excerpt_source} ({summary})"
