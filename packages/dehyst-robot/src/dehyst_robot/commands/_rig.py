"""dehyst rig: the file of a robot of one's own, and what that robot can do."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

from dehyst.app import ask_progress, print_end, print_json, refuse_existing, table
from dehyst.app import kit as app_kit
from dehyst.errors import ParameterError
from dehyst.files import write_atomically
from dehyst.report import require_picture_name
from dehyst.shell import command
from dehyst_robot.arm import Robot, load_robot, sources
from dehyst_robot.arm import kit as arm_kit
from dehyst_robot.commands._requests import RigRequest
from dehyst_robot.commands._rig_fit import fit
from dehyst_robot.experiments import JointCheck
from dehyst_robot.experiments import kit as experiments_kit


def run_rig(request: RigRequest) -> None:
    """Write a new file, check one, or fit it."""
    if request.action not in ACTIONS:
        raise ParameterError(
            f"'{request.action}' is no action of dehyst rig. Type one of: {', '.join(ACTIONS)}."
        )
    ACTIONS[request.action](request)


def _new(request: RigRequest) -> None:
    # One source for the joints: two could contradict each other.
    bodies = [file for file in (request.from_urdf, request.from_mjcf) if file is not None]
    if len(bodies) + (request.joints is not None) > 1:
        raise ParameterError(
            "--joints, --from-urdf and --from-mjcf each say which joints there are. Type one of them."
        )
    if bodies and not bodies[0].is_file():
        raise ParameterError(f"the file '{bodies[0]}' is not there. Name a URDF or MJCF file.")
    refuse_existing(request.file, request.overwrite)
    joints = request.joints
    if joints is None:
        joints = 1
    text = experiments_kit.new_rig(request.file, joints, *bodies)
    write_atomically(request.file, text)
    print_end(command("rig", "check", request.file), robot=request.file)


def _check(request: RigRequest) -> None:
    robot = load_robot(request.file)
    if request.figure is not None:
        require_picture_name(request.figure)
        refuse_existing(request.figure, request.overwrite, own=app_kit.RIGS)
    if request.mjcf is not None:
        refuse_existing(request.mjcf, request.overwrite)
        write_atomically(request.mjcf, arm_kit.drawn_mjcf(robot))
    with ask_progress("checking", request.json):
        checks = experiments_kit.check_rig(robot)
    # Sentences about what cannot work, with the keys to change.
    cautions = experiments_kit.cautions(robot, checks)
    origins = _origins(robot, request.file)
    if request.figure is not None:
        from dehyst_robot.report import write_rig_figure

        write_rig_figure(request.figure, robot.name, checks)
    if request.json:
        document = {
            "format": "dehyst-rig-check",
            "joints": {str(number): _figures(robot, number, checks[number]) for number in checks},
            "warnings": cautions,
            "numbers": origins,
        }
        print_json(document)
        return
    _print(robot, checks)
    _print_torques(checks)
    _print_origins(origins)
    for words in cautions:
        app_kit.terminal(stderr=True).print(f"\nwarning: {words}")
    print_end(
        command("reproduce", quick=True, robot=request.file),
        picture=request.figure,
        model=request.mjcf,
    )


ACTIONS = {"new": _new, "check": _check, "fit": fit}


def _figures(robot: Robot, number: int, check: JointCheck) -> dict[str, Any]:
    return {
        "drives": list(robot.joint(number).driven),
        "models": [muscle.model or muscle.map for muscle in robot.muscles_of(number)],
        "range_deg": np.degrees(robot.joint(number).range),
        # A value a pressure: where the muscle is shortest, and in the middle of the range.
        "held_Nm": check.pulls.min(axis=1).tolist(),
        "held_back_Nm": check.back.min(axis=1).tolist(),
        "middle_Nm": check.pulls[:, check.pulls.shape[1] // 2].tolist(),
        "gravity_Nm": list(check.gravity),
        "inertia_kg_m2": check.inertia,
        "stiffness_Nm_rad": check.stiffness,
        "frequency_Hz": check.frequency,
    }


def _named(robot: Robot, drive: str) -> str:
    """A type of muscle, with the model of its force if it has one."""
    if drive in robot.muscles and robot.muscles[drive].model:
        return f"{drive} ({robot.muscles[drive].model})"
    return drive


def _print(robot: Robot, checks: dict[int, JointCheck]) -> None:
    heads = ["joint", "drive", ">range", ">gravity", ">inertia", ">stiffness", ">natural"]
    rows = [["", "", "[deg]", "[Nm]", "[kg m²]", "[Nm/rad]", "[Hz]"]]
    for number, check in checks.items():
        joint = robot.joint(number)
        drive = ", ".join(_named(robot, name) for name in dict.fromkeys(joint.driven))
        if joint.parallel > 1:
            drive += f" x {joint.parallel}"
        stiffness, frequency = "", ""
        # An electric joint has no muscles that are stiff.
        if check.pulls.size:
            stiffness, frequency = f"{check.stiffness:.3g}", f"{check.frequency:.3g}"
        row = [
            str(number),
            drive,
            f"±{np.degrees(joint.range):.3g}",
            f"{check.gravity[0]:.3g} .. {check.gravity[1]:.3g}",
            f"{check.inertia:.3g}",
            stiffness,
            frequency,
        ]
        rows.append(row)
    # Stiffness depends on the mean pressure, so the title names it.
    mean = robot.controller.mean_pressure / 1e5
    title = f"{robot.name}: what moves; muscles at {mean:g} bar"
    app_kit.terminal().print(table(heads, rows, title=title))


def _print_torques(checks: dict[int, JointCheck]) -> None:
    """What one muscle pulls at each pressure, of the joints that have muscles."""
    rows = []
    for number, check in checks.items():
        if check.pulls.size:
            middle = check.pulls.shape[1] // 2
            pulls = [f"{pull[middle]:.3g} ({pull.min():.3g})" for pull in check.pulls]
            rows.append([str(number), *pulls])
    if not rows:
        return
    heads = ["joint", *(f">{pressure / 1e5:g}" for pressure in experiments_kit.PRESSURES)]
    title = "torque [Nm] of one muscle in the middle of the range, and where it is shortest, by its pressure [bar]"
    out = app_kit.terminal()
    out.print()
    out.print(table(heads, rows, title=title))


def _origins(robot: Robot, file: Path) -> dict[str, str]:
    """Where each number of the robot comes from: what its file says, else the packaged one."""
    in_file, packaged = sources(file), sources()
    origins: dict[str, str] = {}
    for key in _numbers(robot.values):
        source = in_file.get(key, "")
        # What joints and bodies are is up to the file alone; the rest may be of the packaged arm.
        if key not in in_file and not key.startswith(("joint.", "body.")):
            source = packaged.get(key, "")
        origins[key] = source.rpartition(";")[2].strip() or "nothing said"
    return origins


def _numbers(values: Any, prefix: str = "") -> list[str]:
    """Dotted keys of the numbers and lists of them."""
    if isinstance(values, str):
        return []
    if not isinstance(values, dict):
        return [prefix[:-1]]
    keys = []
    for key, inner in values.items():
        keys += _numbers(inner, f"{prefix}{key}.")
    return keys


def _print_origins(origins: dict[str, str]) -> None:
    """How many numbers of each table are assumptions, nothing said, or have a source."""
    total: Counter[str] = Counter()
    by_table: dict[str, Counter[str]] = {}
    for key, text in origins.items():
        # Counted by the table of the file, as a user would look them up.
        kind = _kind(text)
        total[kind] += 1
        by_table.setdefault(key.rpartition(".")[0], Counter())[kind] += 1
    kinds = ("assumption", "nothing said", "source")
    rows = []
    for name, counts in by_table.items():
        rows.append([name, *(str(counts[kind] or "") for kind in kinds)])
    heads = ["numbers of", *(f">{kind}" for kind in kinds)]
    out = app_kit.terminal()
    out.print()
    out.print(table(heads, rows, title="where the numbers come from"))
    unexplained = total["assumption"] + total["nothing said"]
    out.print(f"{unexplained} of {len(origins)} numbers are assumptions or unexplained.")


def _kind(text: str) -> str:
    if "assumption" in text:
        return "assumption"
    if text == "nothing said":
        return text
    return "source"
