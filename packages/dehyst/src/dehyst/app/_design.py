"""dehyst design: what to run on the rig before an identification."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from rich.table import Column

from dehyst.app._policy import POLICY
from dehyst.app._targets import EXCITATION, refuse_existing, refuse_unwritable, write_new
from dehyst.app._terminal import print_end, print_json, table, tell, terminal
from dehyst.app.requests import DesignRequest
from dehyst.design import CYCLES, ExcitationPlan, design_drift_motion, design_excitation
from dehyst.errors import MissingExtraError, OutputError, ParameterError
from dehyst.io import format_csv
from dehyst.plugins import added, load_added
from dehyst.shell import command, quoted
from dehyst.units import canonical

WHY = 34  # letters left for the last column of the table at least
GROUP = "dehyst.designs"  # entry points of what can be designed besides a range
# How well a plan separates the parts of a model: attribute, words and format of each row that is printed.
SEPARABLE = (
    ("smallest", "smallest singular value of all regressors", ".2g"),
    ("creep", "creep from everything else", ".2g"),
    ("rate", "rate from everything else", ".2g"),
    ("congruency", "loops at one place from those at another", ".2g"),
    ("condition", "condition number", ".0f"),
)
IDENTIFICATION, DRIFT = "identification", "drift"
MOTIONS = {IDENTIFICATION: design_excitation, DRIFT: design_drift_motion}


@dataclass(frozen=True)
class Designed:
    """A plan in the unit it is shown in, and what is known of the joint."""

    plan: ExcitationPlan
    name: str
    extra: dict[str, npt.NDArray[np.float64]]
    needs: dict[str, float]


def run_design(request: DesignRequest) -> None:
    """Design, print the plan, write what was asked for."""
    _refuse_bad_request(request)
    design = _design_of_joint
    if request.joint is None:
        design = _designed_range
    designed = design(request)
    # The file is written first: it is what the user runs, and a picture that fails must not cost it.
    if request.out is not None:
        text = _csv(designed, request.out)
        write_new(request.out, request.overwrite, text)
    if request.figure is not None:
        from dehyst.report import kit as report_kit

        report_kit.write_excitation_figure(request.figure, designed.plan, designed.name)
    if request.json:
        print_json(_facts(designed, request))
    else:
        _print(designed, request)
    for path in filter(None, (request.out, request.figure)):
        tell(f"wrote {path}")


def _refuse_bad_request(request: DesignRequest) -> None:
    if request.purpose not in MOTIONS:
        raise ParameterError(
            f"--for {request.purpose} names no purpose. Type --for identification (as without it), or --for drift."
        )
    if request.hold is not None and (request.purpose == DRIFT or request.joint is not None):
        raise ParameterError(
            "--hold is for the identification of a rig (--range): cycles for drift, and joints of the robot, have "
            "rests of their own. Leave it out."
        )
    if request.joint is None and request.range is None:
        raise ParameterError(
            "nothing says what is moved. Type --range LO HI --unit UNIT for a rig of your own, e.g. "
            "--range -30 30 --unit deg, or --joint 1 for a joint of the robot."
        )
    if request.robot is not None and request.joint is None:
        raise ParameterError(
            "--robot names a file of joints, but no joint is chosen. Add --joint 1, or leave it out."
        )
    if request.figure is not None:
        from dehyst.report import require_picture_name

        refuse_existing(require_picture_name(request.figure), request.overwrite, own=EXCITATION)
    for path in filter(None, (request.out, request.figure)):
        refuse_unwritable(path)
    if request.out is not None and request.out == request.figure:
        raise OutputError(
            f"--out and --figure both name '{request.out}'. Name two files.", path=str(request.out)
        )


def _design_of_joint(request: DesignRequest) -> Designed:
    """Return the plan of a joint of the robot, which is a package of its own."""
    if "joint" not in added(GROUP):
        raise MissingExtraError(
            "--joint plans for a joint of the simulated robot, which is not installed. Type: pip install dehyst-robot; "
            "or plan for a rig of your own: --range LO HI --unit UNIT.",
            extra="dehyst-robot",
        )
    designed: Designed = load_added(GROUP, "joint")(request)
    return designed


def _designed_range(request: DesignRequest) -> Designed:
    assert request.range is not None
    unit = request.unit or ""
    # The motions for drift know no rest, so that one is passed on only if it was typed.
    more = {}
    if request.hold is not None:
        more["hold"] = request.hold

    def within(time_limit: float) -> ExcitationPlan:
        assert request.range is not None
        return MOTIONS[request.purpose](
            *request.range, rate=request.rate, acceleration=request.acceleration, time_limit=time_limit,
            period=request.period, unit=canonical(unit) or unit, **more,
        )  # fmt: skip

    time_limit = POLICY.usual_limit
    if request.time_limit is not None:
        time_limit = request.time_limit
    try:
        plan = within(time_limit)
    except ParameterError as fault:
        # Rests that were typed may need more than the usual limit, which the user did not type.
        if request.hold is None or request.time_limit is not None or "needed" not in fault.facts:
            raise
        plan = within(float(fault.facts["needed"]))
    return Designed(plan, f"{plan.low:zg} to {plan.high:zg} {plan.unit}".strip(), {}, {})


def _csv(designed: Designed, path: Path) -> str:
    time, value, part = designed.plan.signal()
    name = "command"
    if designed.plan.unit:
        name = f"command [{designed.plan.unit}]"
    # Nine decimals hide the rounding of k * period, and no clock of a rig is finer.
    columns = {"time_s": np.round(time, 9), name: value, **designed.extra, "part": part}
    return format_csv(columns, path)


def _facts(designed: Designed, request: DesignRequest) -> dict[str, Any]:
    """Everything that is printed, as numbers."""
    plan = designed.plan
    sections = []
    for section, begin in zip(plan.sections, plan.begins, strict=True):
        facts = {
            "part": section.part,
            "why": section.why,
            "begin_s": begin,
            "duration_s": section.duration,
            "tips": list(section.tips),
            "stroke_s": list(section.stroke_s),
            "hold_s": list(section.hold_s),
        }
        sections.append(facts)
    cycles = {}
    if request.purpose == DRIFT:
        cycles["cycles"] = CYCLES
    return {
        "format": "dehyst-excitation",
        "low": plan.low,
        "high": plan.high,
        "unit": plan.unit,
        "period_s": plan.period,
        "duration_s": plan.duration,
        "peak_rate": plan.peak_rate,
        "peak_acceleration": plan.peak_acceleration,
        **cycles,
        "separable": asdict(plan.separable),
        "one_loop": asdict(plan.one_loop),
        **designed.needs,
        "sections": sections,
    }


def _print(designed: Designed, request: DesignRequest) -> None:
    plan, out, needs = designed.plan, terminal(), designed.needs
    unit = ""
    if plan.unit:
        unit = f" {plan.unit}"
    out.print(
        f"{designed.name}: {plan.duration:.0f} s, begins and ends at {plan.middle:.4g}{unit}",
        style="bold",
    )
    out.print(
        f"peak rate {plan.peak_rate:.4g}{unit}/s, peak acceleration {plan.peak_acceleration:.4g}{unit}/s^2"
    )
    if needs:
        out.print(
            f"by the nominal model: {100 * needs['pressure_share']:.0f} % of the pressure difference, "
            f"{100 * needs['flow_share']:.0f} % of the valves' flow, at most {needs['inertia_torque_Nm']:.2g} Nm for "
            f"the inertia"
        )
    out.print()
    # Only the last two columns may be folded, and the table rather grows beyond a narrow terminal.
    holds = Column("holds [s]", overflow="fold", min_width=9)
    why = Column("why", overflow="fold", min_width=WHY)
    parts = table((">from [s]", ">for [s]", ">strokes", ">rate", "part", holds, why), _rows(plan))
    out.print(parts, width=max(out.width, 58 + WHY), crop=False)
    out.print()
    # Beside the plan stands one loop, which most users would run: it shows what the plan is longer for.
    rows = []
    for key, label, digits in SEPARABLE:
        this_plan = f"{getattr(plan.separable, key):{digits}}"
        one_loop = f"{getattr(plan.one_loop, key):{digits}}"
        rows.append((label, this_plan, one_loop))
    out.print(table(("told apart (1: for sure)", ">this plan", ">one loop"), rows))
    out.print(
        "good: the first four are above the noise of your sensor, as a share of its range (0.01 for 1 %)"
    )
    if request.purpose == DRIFT:
        out.print()
        out.print(
            f"{CYCLES} complete cycles whose memory is known, in as many blocks alike as drift makes groups"
        )
    print_end(_next(designed, request))


def _rows(plan: ExcitationPlan) -> Iterator[tuple[str, ...]]:
    """One row a part of the motion."""
    before = plan.middle
    for section, begin in zip(plan.sections, plan.begins, strict=True):
        # A stroke begins where the part before it ended.
        ways = np.abs(np.diff([before, *section.tips]))
        peak = float((35.0 / 16.0 * ways / np.array(section.stroke_s)).max())
        holds = ", ".join(dict.fromkeys(f"{time:.3g}" for time in section.hold_s if time > 0))
        numbers = (f"{begin:.1f}", f"{section.duration:.1f}", f"{len(section.tips)}", f"{peak:.3g}")
        yield (*numbers, section.part, holds, section.why)
        before = section.tips[-1]


def _next(designed: Designed, request: DesignRequest) -> str:
    plan = designed.plan
    if request.out is None:
        return "the same line with --out FILE.csv writes it as samples"
    middle = f"{plan.middle:.4g}"
    if request.unit:
        middle += f" {request.unit}"
    if request.purpose == DRIFT:
        return (
            f"bring the rig to {middle}, run {quoted(request.out)}, log what it got and what "
            f"it did: now, as the reference, and again whenever you ask whether the actuator has changed:\n"
            f"{command('drift', 'MODEL.json', 'LATER.csv', reference='NOW.csv')}"
        )
    line = command("identify", "LOG", input="COLUMN", output="COLUMN", **judged_on_test(plan))
    return (
        f"bring the rig to {middle}, run {quoted(request.out)}, log what it got and what it "
        f"did; then, judged on the part test:\n"
        f"{line}\n"
        "(--from and --to for a log whose clock is 0 where the motion begins; if it begins at s seconds, add s to both)"
    )


def judged_on_test(plan: ExcitationPlan) -> dict[str, str]:
    """Options of identify that leave home out and hold out the part test, to the sample.

    A cut lies half a period before its sample, and a share half a sample beyond what is fitted: a clock and a share
    that are rounded mean the same samples.
    """
    part = plan.signal()[2]
    test = int(np.flatnonzero(part == "test")[0])
    first = int(np.flatnonzero(part != "home")[0])
    last = test + int(np.flatnonzero(part[test:] == "home")[0])
    # One digit more than the period has: half a period must not be rounded away.
    digits = max(1, 1 - math.floor(math.log10(plan.period)))
    begin = f"{(first - 0.5) * plan.period:.{digits}f}"
    end = f"{(last - 0.5) * plan.period:.{digits}f}"
    samples = last - first
    share = f"{(test - first + 0.5) / samples:.{len(str(samples))}f}"
    return {"from": begin, "to": end, "train_fraction": share}
