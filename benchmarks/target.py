"""The exported arithmetic on Cortex-M and x86-64: instructions of a step, bytes of code and memory, bits.

    python benchmarks/target.py --json benchmarks/results/target.json    # counts and sizes
    python benchmarks/target.py --bits                                   # 100 random models over 1 000 samples
    python benchmarks/target.py --quick                                  # n = 14 alone, bits of a few models

Needs gcc-arm-none-eabi and qemu-system-arm for Cortex-M, valgrind for x86-64; what is missing is named and left out.
Ends with status 1 if bits differ, or in float on the Cortex-M4F the 14-play inverse takes more than 20 instructions a
play while no limit is met, or a sum of 40 elements more than 120 an element forward and 330 back. `--budget` also
writes the straight lines over n that `dehyst export` prints.
"""

from __future__ import annotations

import argparse
import json
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from result_files import save
from target import costs, count, jobs, machines, random_blocks
from target.jobs import Array
from target.machines import Machine

from dehyst import PrandtlIshlinskii
from dehyst.export import Subject, export, subject_of
from dehyst.families import ROWS, example
from dehyst.models import ModelCard, SignalCard
from dehyst_robot.control import JointControllerParameters
from dehyst_robot.export import joint_subject

BUDGET = (
    Path(__file__).resolve().parents[1]
    / "packages"
    / "dehyst"
    / "src"
    / "dehyst"
    / "export"
    / "instructions.json"
)
PLAYS, PER_PLAY = 14, 20
PER_ELEMENT = {"forward": 120, "inverse": 330}  # of 40, as many of them with maps as in costs.MIX
REALS = ("float", "double")
COUNTED = ("cortex-m4f", "cortex-m7", "x86-64")
SIZES = (1, 2, 3, 4, 8, 14, 16, 17, 32, 64, 128, 200)
SOFT = (1, 2, 14, 64, 200)  # where double precision is software, ten times as slow to trace
MAP_POINTS = 200
PERIODS = 150  # of the joint controller's recorded run


def usable(names: tuple[str, ...]) -> Iterator[Machine]:
    """Yield machines whose tools are there; say what is missing for others."""
    for name in names:
        machine = machines.MACHINES[name]
        missing = machine.missing() or (
            "" if machine.board or shutil.which("valgrind") else "valgrind"
        )
        if missing:
            print(f"{name} is left out: no {missing}", file=sys.stderr)
        else:
            yield machine


def step_counts(
    machine: Machine, real: str, level: str, sizes: tuple[int, ...]
) -> dict[int, dict[str, float]]:
    """Return for each n the mean of slow loops, and the most of each kind of signal."""
    found: dict[int, dict[str, float]] = {}
    with tempfile.TemporaryDirectory() as place:
        program = machines.build(machine, Path(place), real, level)
        for n in sizes:
            signals = costs.cases(n, real)
            job = jobs.job(list(signals.values()), real)
            counts = count.count(machine, program, job, Path(place), "dehyst_block_step")
            parts = np.split(
                np.array(counts), np.cumsum([case.x.size for case in signals.values()])[:-1]
            )
            found[n] = {"typical": float(np.mean(parts[0]))}
            found[n] |= {name: int(np.max(part)) for name, part in zip(signals, parts, strict=True)}
            found[n]["most"] = max(found[n][name] for name in signals)
    return found


def map_cost(machine: Machine, real: str) -> int:
    """Return what a map of `MAP_POINTS` breakpoints adds at most."""
    plain = costs.cases(2, real)["free"]
    mapped = jobs.Case(costs.with_maps(plain.block, MAP_POINTS), plain.x, plain.on)
    with tempfile.TemporaryDirectory() as place:
        program = machines.build(machine, Path(place), real)
        job = jobs.job([plain, mapped], real)
        counts = np.array(count.count(machine, program, job, Path(place), "dehyst_block_step"))
    return int(np.ceil(np.max(counts[plain.x.size :] - counts[: plain.x.size]) / 2))


def model(n: int) -> PrandtlIshlinskii:
    """Return a model of n operators with a card, to export."""
    card = ModelCard(
        SignalCard("pressure", "bar", -1.0, 1.0), SignalCard("angle", "rad", -1.0, 1.0)
    )
    return PrandtlIshlinskii(
        np.linspace(0.0, 0.9, n), np.concatenate([[0.5], np.full(n - 1, 0.7 / n)]), card=card
    )


def joint_counts(machine: Machine, subject: Subject) -> dict[str, float]:
    """Return instructions of a whole controller's period."""
    with tempfile.TemporaryDirectory() as place:
        export(subject, "c", Path(place) / "out")
        program = machines.build(
            machine, Path(place), subject.real, "-O2", "joint.c", Path(place) / "out" / "src"
        )
        counts = count.count(
            machine, program, jobs.joint_job(subject, PERIODS), Path(place), "unit_step"
        )
    return {"typical": float(np.mean(counts)), "most": int(np.max(counts))}


def unit_steps(
    machine: Machine, subject: Subject, signals: Sequence[Array], *defines: str
) -> list[list[int]]:
    """Return the instructions of each step of an exported block in each signal."""
    with tempfile.TemporaryDirectory() as place:
        export(subject, "c", Path(place) / "out")
        defines = (f"-DINPUTS={len(subject.numbers.inputs)}", *defines)
        program = machines.build(
            machine,
            Path(place),
            subject.real,
            "-O2",
            "unit.c",
            Path(place) / "out" / "src",
            defines,
        )
        return [list(count.count(machine, program, jobs.unit_job(x, subject.real), Path(place), "unit_step"))
                for x in signals]  # fmt: skip


def tunable_costs(machine: Machine, real: str, samples: int) -> dict[str, dict[str, float]]:
    """Return by kind of block what tunable numbers add to a step: with the page of the export, and with other limits.

    The difference of equal steps with and without them: without maps, whose cost is known.
    """
    found: dict[str, dict[str, float]] = {}
    given: dict[str, Any] = {"name": "unit", "real": real}
    for one, what in (
        (model(PLAYS), "forward"), (model(PLAYS), "inverse"), (costs.element_model(min(costs.MIXED)), "forward"),
        (costs.element_model(min(costs.MIXED)), "inverse"), (costs.direct_model(4, 6, 3, 2, 1), "inverse"),
    ):  # fmt: skip
        given["period"] = 0.001 if one.core == "direct" else None
        plain, tuned = (subject_of(one, what, tunable=on, **given) for on in (False, True))
        x = [0.8 * plain.test.inputs[600 : 600 + samples]]
        base = np.array(unit_steps(machine, plain, x)[0])
        usual, narrow = (
            np.array(unit_steps(machine, tuned, x, *more)[0]) - base for more in ((), ("-DTUNED",))
        )
        row = found.setdefault(plain.numbers.core, {"typical": 0, "most": 0})
        row["typical"] = max(row["typical"], int(np.ceil(np.mean(usual))))
        row["most"] = max(row["most"], int(np.max(usual)), int(np.max(narrow)))
    return found


def unit_counts(machine: Machine, subject: Subject, signals: Sequence[Array]) -> dict[str, float]:
    """Return instructions of a step of an exported block: in the first signal, slow, the first step, and of the others
    the slowest that was found."""
    counts = unit_steps(machine, subject, signals)
    most = max(n for one in counts for n in one[1:])
    return {
        "typical": float(np.mean(counts[0][1:])),
        "first": max(one[0] for one in counts),
        "most": most,
    }


def element_counts(machine: Machine, subject: Subject, samples: int) -> dict[str, float]:
    """Return instructions of a step of an exported sum of elements, its other inputs at rest."""
    middle = 0.5 * (subject.input.low + subject.input.high)
    half = 0.5 * (subject.input.high - subject.input.low)
    signals = [middle + half * x for x in costs.element_signals(samples)]
    rest = subject.middle[1:]
    return unit_counts(
        machine,
        subject,
        [np.column_stack([x, *(np.full(x.size, at) for at in rest)]) for x in signals],
    )


def unit_rows(machine: Machine, real: str, samples: int) -> list[dict[str, Any]]:
    """Return for units of every kind but plays what a step does, and its instructions."""
    units = [
        subject_of(each, name="unit", real=real, period=0.001) for each in costs.direct_models()
    ]
    for direction, what in (("forward", "forward"), ("forward", "inverse"), ("inverse", "inverse")):
        models = [
            *costs.element_models(direction),
            *map(costs.element_model, costs.MIXED if direction == "forward" else ()),
        ]
        units += [subject_of(each, what, name="unit", real=real) for each in models]
    found = []
    for unit in units:
        kind, counts = unit.numbers.work
        if unit.direct:
            row = unit_counts(
                machine,
                unit,
                [unit.test.inputs[600 : 600 + samples], unit.test.inputs[: 2 * samples]],
            )
        else:
            row = element_counts(machine, unit, samples)
        found.append({"kind": kind, "counts": some(counts), **row})
    joint = joint_subject(
        costs.direct_model(4, 6, 3, 2, 1), JointControllerParameters(), name="unit", real=real
    )
    kind, counts = joint.numbers.work
    return [*found, {"kind": kind, "counts": some(counts), **joint_counts(machine, joint)}]


def some(counts: dict[str, int]) -> dict[str, int]:
    """Return what a step does at all."""
    return {name: count for name, count in counts.items() if count}


def family_rows(machine: Machine, real: str, samples: int) -> dict[str, dict[str, Any]]:
    """Return instructions of a step of a sum of every row of elements, and of its inverse if there is one."""
    found: dict[str, dict[str, Any]] = {}
    for row in ROWS:
        one = replace(example(row.name), card=costs.CARD)
        for what in ("forward", "inverse")[: 1 if one.no_inverse else 2]:
            unit = subject_of(one, what, name="unit", real=real, period=0.01 if one.timed else None)
            counted = element_counts(machine, unit, samples)
            kind, counts = unit.numbers.work
            found.setdefault(row.name, {})[what] = {"kind": kind, "counts": some(counts), **counted}
    return found


def elements(machine: Machine, real: str, samples: int) -> dict[str, Any]:
    """Return instructions and bytes of sums of elements, forward and inverse."""
    found: dict[str, Any] = {}
    for what in ("forward", "inverse"):
        units = {
            n: subject_of(costs.element_model(n), what, name="unit", real=real) for n in costs.MIXED
        }
        found[what] = {
            "steps": {str(n): element_counts(machine, unit, samples) for n, unit in units.items()},
            "bytes": {
                level: code_bytes(machine, units[min(units)], level) for level in ("-O2", "-Os")
            },
        }
    return found


def code_bytes(machine: Machine, subject: Subject, level: str) -> dict[str, int]:
    """Return bytes of code with constants, and of memory, that a unit adds to a program."""
    defines = ("-DJOINT",) if subject.what == "joint-controller" else ()
    with tempfile.TemporaryDirectory() as place:
        export(subject, "c", Path(place) / "out")
        core = Path(place) / "out" / "src"
        full = _sections(
            machine,
            machines.build(machine, Path(place), subject.real, level, "size.c", core, defines),
        )
        empty = _sections(
            machine,
            machines.build(machine, Path(place), subject.real, level, "size.c", core, ("-DEMPTY",)),
        )
    return {"flash": full[0] - empty[0], "ram": full[1] - empty[1]}


def _sections(machine: Machine, program: Path) -> tuple[int, int]:
    tool = machine.compiler.replace("gcc", "size") if machine.board else "size"
    said = subprocess.run([tool, str(program)], capture_output=True, text=True, check=True).stdout
    text, data, bss = (int(word) for word in re.findall(r"\d+", said.partition("\n")[2])[:3])
    return text + data, data + bss


def check_bits(models: int, samples: int) -> list[str]:
    """Compare Cortex-M with the extension; return what differs."""
    faults = []
    for real in REALS:
        trials = random_blocks.trials(models, samples, real)
        cases = [trial.case for trial in trials]
        for machine in usable(("cortex-m3", "cortex-m4f", "cortex-m7")):
            with tempfile.TemporaryDirectory() as place:
                program = machines.build(machine, Path(place), real)
                content = machines.run(machine, program, jobs.job(cases, real), Path(place))
            found = jobs.answers(content, cases, real)
            errors = [_error(trial, answer) for trial, answer in zip(trials, found, strict=True)]
            same, worst = sum(error == 0.0 for error in errors), max(errors)
            limit = 0.0 if real == "double" else 1e-5
            print(f"{machine.name:11} {real:7} {models} models x {samples} samples: {same} bit for bit, "
                  f"largest difference {worst:.1e} of the range")  # fmt: skip
            if not worst <= limit:
                faults.append(f"{machine.name} in {real} differs by {worst:.1e} of the range")
    return faults


def _error(trial: random_blocks.Trial, answer: jobs.Answer) -> float:
    y, flags = trial.expected()
    if answer.y.tobytes() == y.tobytes() and np.array_equal(answer.flags, flags):
        return 0.0
    if trial.real == "double" and not np.array_equal(answer.flags, flags):
        return np.inf
    return float(max(np.max(np.abs(answer.y - y)) / trial.range(), 1e-300))


def measure(sizes: tuple[int, ...]) -> dict[str, Any]:
    """Return everything that is counted and measured, by machine."""
    found: dict[str, Any] = {}
    for machine in usable(COUNTED):
        entry: dict[str, Any] = {"title": machine.title, "compiler": _version(machine)}
        for real in REALS:
            soft = real == "double" and machine.name == "cortex-m4f"
            counts = step_counts(
                machine, real, "-O2", tuple(n for n in sizes if not soft or n in SOFT)
            )
            print(f"{machine.name} {real}: counted", file=sys.stderr)
            block = subject_of(model(PLAYS), name="unit", real=real)
            joint = joint_subject(model(PLAYS), JointControllerParameters(), name="unit", real=real)
            entry[real] = {
                "steps": {str(n): row for n, row in counts.items()},
                "steps_os": step_counts(machine, real, "-Os", (PLAYS,))[PLAYS],
                "map": map_cost(machine, real),
                "joint": {
                    str(n): joint_counts(
                        machine,
                        joint_subject(
                            model(n), JointControllerParameters(), name="unit", real=real
                        ),
                    )
                    for n in (2, PLAYS)
                },
                "bytes": {level: code_bytes(machine, block, level) for level in ("-O2", "-Os")},
                "joint_bytes": {
                    level: code_bytes(machine, joint, level) for level in ("-O2", "-Os")
                },
                "elements": elements(machine, real, 6 if soft else 40),
                "units": unit_rows(machine, real, 6 if soft else 40),
                "tunable": tunable_costs(machine, real, 6 if soft else 40),
                "rows": {} if soft else family_rows(machine, real, 40),
            }
        found[machine.name] = entry
    return found


def _version(machine: Machine) -> str:
    said = subprocess.run(
        [machine.compiler, "--version"], capture_output=True, text=True, check=True
    ).stdout
    return said.partition("\n")[0].strip()


def lines(found: dict[str, Any]) -> dict[str, Any]:
    """Return the content of the kernel's export/instructions.json: the cost of each part of a step of each unit."""
    targets: dict[str, Any] = {}
    for name, entry in found.items():
        costs_of: dict[str, Any] = {
            "title": entry["title"],
            "compiler": f"{entry['compiler']}, -O2",
        }
        for real in REALS:
            for kind, rows in _rows(entry[real]).items():
                for key in ("typical", "most"):
                    counted = [
                        (counts, max(row[key], row.get("first", 0) if key == "most" else 0))
                        for counts, row in rows
                    ]
                    fixed = {"maps": entry[real]["map"]}
                    if kind.startswith(
                        "joint"
                    ):  # a compensator in it once, a direct inverse along two angles
                        times, inner = (
                            (2, "direct_block") if kind == "joint_direct" else (1, "block")
                        )
                        parts = costs_of[inner][real][key]
                        fixed |= {
                            part: times * cost
                            for part, cost in parts.items()
                            if part not in ("step", "maps")
                        }
                    costs_of.setdefault(kind, {}).setdefault(real, {})[key] = costs.cover(
                        counted, fixed
                    )
                    for core, cost in entry[real]["tunable"].items():
                        if kind.startswith(core):
                            costs_of[kind][real][key]["tunable"] = cost[key]
        targets[name] = costs_of
    return {"points_of_a_map": MAP_POINTS, "largest_n": max(SIZES), "targets": targets}


def _rows(entry: dict[str, Any]) -> dict[str, list[tuple[dict[str, int], dict[str, float]]]]:
    """What was counted, by kind of unit: what a step does, its instructions."""
    found: dict[str, list[tuple[dict[str, int], dict[str, float]]]] = {}
    for kind, of in (("block", "steps"), ("joint", "joint")):
        found[kind] = [({"operators": int(n)}, row) for n, row in entry[of].items()]
    for row in (
        *entry["units"],
        *(row for both in entry["rows"].values() for row in both.values()),
    ):
        found.setdefault(row["kind"], []).append((row["counts"], row))
    return found


def text(content: dict[str, Any]) -> str:
    """Return JSON with a line a row: an object stands on one where it has room there."""
    said = json.dumps(content, indent=1)
    for pattern in (r"\{[^{}]*\}", r"\{[^{}]*(?:\{[^{}\n]*\}[^{}]*)+\}"):
        said = re.sub(
            pattern, lambda row: one if len(one := " ".join(row[0].split())) < 300 else row[0], said
        )
    return said + "\n"


def table(found: dict[str, Any]) -> list[str]:
    """Return lines of a table of the 14-play inverse and of a whole joint controller."""
    titles = (
        "slow loops",
        "none moved",
        "all moved",
        "any number",
        "held back",
        "all signals",
        "controller",
        "at most",
    )
    rows = [f"{'14-play inverse':22}" + "".join(f"{title:>12}" for title in titles)]
    for name, entry in found.items():
        for real in REALS:
            row, joint = entry[real]["steps"][str(PLAYS)], entry[real]["joint"][str(PLAYS)]
            cells = (
                row["typical"],
                row["none"],
                row["all"],
                row["free"],
                row["held"],
                row["most"],
                joint["typical"],
            )
            rows.append(
                f"{name + ' ' + real:22}"
                + "".join(f"{cell:12.0f}" for cell in cells)
                + f"{joint['most']:12.0f}"
            )
    return rows


def main() -> None:
    """Measure, print, write, and fail if a limit is missed."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--bits", action="store_true", help="compare bits instead of counting")
    parser.add_argument(
        "--quick", action="store_true", help="n = 14 alone, and bits of a few models"
    )
    parser.add_argument("--json", type=Path, help="file for the results")
    parser.add_argument(
        "--budget", action="store_true", help=f"write {BUDGET.name} for dehyst export"
    )
    options = parser.parse_args()
    faults = check_bits(20, 200) if options.quick else check_bits(100, 1000) if options.bits else []
    if not options.bits:
        found = measure((PLAYS,) if options.quick else SIZES)
        print("\n".join(table(found)))
        faults += missed(found)
        if options.json:
            save(options.json, found)
        if options.budget:
            BUDGET.write_text(text(lines(found)), encoding="utf-8")
    if faults:
        sys.exit("over the limit: " + "; ".join(faults))


def missed(found: dict[str, Any]) -> list[str]:
    """Say whether the 14-play inverse, or a sum of 40 elements, takes more than it may."""
    if "cortex-m4f" not in found:
        return []
    entry = found["cortex-m4f"]["float"]
    row, limit, many = entry["steps"][str(PLAYS)], PLAYS * PER_PLAY, max(costs.MIXED)
    faults = [
        f"{name}: {row[name]} > {limit}" for name in ("typical", "none", "all") if row[name] > limit
    ]
    for what, most in PER_ELEMENT.items():
        typical = entry["elements"][what]["steps"][str(many)]["typical"]
        faults += (
            [f"{many} elements {what}: {typical:.0f} > {many * most}"]
            if typical > many * most
            else []
        )
    return faults


if __name__ == "__main__":
    main()
