"""dehyst rig: the file of a robot of one's own, and what that robot can do."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

from dehyst.app.targets import RIGS, refuse_existing
from dehyst.app.terminal import ask_progress, print_end, print_json, table, terminal
from dehyst.errors import ParameterError
from dehyst.files import write_atomically
from dehyst.report.svg import require_picture_name
from dehyst.robot.arm.drawn import drawn_mjcf
from dehyst.robot.arm.parameters import Robot, load_robot, sources
from dehyst.robot.commands.requests import RigRequest
from dehyst.robot.commands.rig_fit import fit
from dehyst.robot.experiments.rig import PRESSURES, JointCheck, cautions, check_rig, new_rig
from dehyst.shell import command


def run_rig(request: RigRequest) -> None:
    """Write a new file, check one, or fit it."""
    if request.action not in ACTIONS:
        raise ParameterError(f"'{request.action}' is no action of dehyst rig. Type one of: {', '.join(ACTIONS)}.")
    ACTIONS[request.action](request)


def _new(request: RigRequest) -> None:
    bodies = [file for file in (request.from_urdf, request.from_mjcf) if file is not None]
    if len(bodies) + (request.joints is not None) > 1:
        raise ParameterError("--joints, --from-urdf and --from-mjcf each say which joints there are. Type one of them.")
    if bodies and not bodies[0].is_file():
        raise ParameterError(f"the file '{bodies[0]}' is not there. Name a URDF or MJCF file.")
    refuse_existing(request.file, request.overwrite)
    text = new_rig(request.file, 1 if request.joints is None else request.joints, *bodies)
    write_atomically(request.file, text)
    print_end(command("rig", "check", request.file), robot=request.file)


def _check(request: RigRequest) -> None:
    robot = load_robot(request.file)
    if request.figure is not None:
        require_picture_name(request.figure)
        refuse_existing(request.figure, request.overwrite, own=RIGS)
    if request.mjcf is not None:
        refuse_existing(request.mjcf, request.overwrite)
        write_atomically(request.mjcf, drawn_mjcf(robot))
    with ask_progress("checking", request.json):
        found = check_rig(robot)
    warned, said = cautions(robot, found), _said(robot, request.file)
    if request.figure is not None:
        from dehyst.robot.report.rig import write_rig_figure

        write_rig_figure(request.figure, robot.name, found)
    if request.json:
        joints = {str(number): _figures(robot, number, check) for number, check in found.items()}
        print_json({"format": "dehyst-rig-check", "joints": joints, "warnings": warned, "numbers": said})
        return
    _print(robot, found)
    _print_said(said)
    for words in warned:
        terminal(stderr=True).print(f"\nwarning: {words}")
    print_end(command("reproduce", quick=True, robot=request.file), picture=request.figure, model=request.mjcf)


ACTIONS = {"new": _new, "check": _check, "fit": fit}


def _figures(robot: Robot, number: int, check: JointCheck) -> dict[str, Any]:
    return {
        "drives": list(robot.joint(number).driven),
        "models": [muscle.model or muscle.map for muscle in robot.muscles_of(number)],
        "range_deg": np.degrees(robot.joint(number).range),
        "held_Nm": [float(pull.min()) for pull in check.pulls],
        "held_back_Nm": [float(pull.min()) for pull in check.back],
        "middle_Nm": [float(pull[pull.size // 2]) for pull in check.pulls],
        "gravity_Nm": list(check.gravity),
        "inertia_kg_m2": check.inertia,
        "stiffness_Nm_rad": check.stiffness,
        "frequency_Hz": check.frequency,
    }


def _named(robot: Robot, drive: str) -> str:
    """A type of muscle, with the model of its force if it has one."""
    model = robot.muscles[drive].model if drive in robot.muscles else None
    return f"{drive} ({model})" if model else drive


def _print(robot: Robot, found: dict[int, JointCheck]) -> None:
    out, bars = terminal(), [f"{p / 1e5:g}" for p in PRESSURES]
    heads = ["joint", "drive", ">range", ">gravity", ">inertia", ">stiffness", ">natural"]
    units = ["", "", "[deg]", "[Nm]", "[kg m²]", "[Nm/rad]", "[Hz]"]
    rows = []
    for number, check in found.items():
        muscles = [f"{check.stiffness:.3g}", f"{check.frequency:.3g}"] if check.pulls.size else ["", ""]
        gravity = f"{check.gravity[0]:.3g} .. {check.gravity[1]:.3g}"
        reach = f"±{np.degrees(robot.joint(number).range):.3g}"
        drive = ", ".join(_named(robot, name) for name in dict.fromkeys(robot.joint(number).driven))
        drive += f" x {robot.joint(number).parallel}" if robot.joint(number).parallel > 1 else ""
        rows.append([str(number), drive, reach, gravity, f"{check.inertia:.3g}", *muscles])
    mean = robot.controller.mean_pressure / 1e5
    out.print(table(heads, [units, *rows], title=f"{robot.name}: what moves; muscles at {mean:g} bar"))
    pulled = [
        [str(number), *(f"{pull[pull.size // 2]:.3g} ({pull.min():.3g})" for pull in check.pulls)]
        for number, check in found.items()
        if check.pulls.size
    ]
    title = "torque [Nm] of one muscle in the middle of the range, and where it is shortest, by its pressure [bar]"
    if pulled:
        out.print()
        out.print(table(["joint", *(f">{bar}" for bar in bars)], pulled, title=title))


def _said(robot: Robot, file: Path) -> dict[str, str]:
    """Where each number of the robot comes from: what its file says, else the packaged one."""
    own, packaged = sources(file), sources()
    told: dict[str, str] = {}
    for key in _numbers(robot.values):
        given = own.get(key, "" if key in own or key.startswith(("joint.", "body.")) else packaged.get(key, ""))
        told[key] = given.rpartition(";")[2].strip() or "nothing said"
    return told


def _numbers(values: Any, prefix: str = "") -> list[str]:
    """Dotted keys of the numbers and lists of them."""
    if isinstance(values, dict):
        return [found for key, inner in values.items() for found in _numbers(inner, f"{prefix}{key}.")]
    return [] if isinstance(values, str) else [prefix[:-1]]


def _print_said(said: dict[str, str]) -> None:
    """How many numbers of each table are assumptions, nothing said, or have a source."""
    kinds = Counter((key.rpartition(".")[0], _kind(text)) for key, text in said.items())
    groups = list(dict.fromkeys(group for group, _ in kinds))
    names = ("assumption", "nothing said", "source")
    rows = [[group, *(str(kinds[group, name] or "") for name in names)] for group in groups]
    out = terminal()
    out.print()
    out.print(table(["numbers of", *(f">{name}" for name in names)], rows, title="where the numbers come from"))
    total = Counter(_kind(text) for text in said.values())
    out.print(f"{total['assumption'] + total['nothing said']} of {len(said)} numbers are assumptions or unexplained.")


def _kind(text: str) -> str:
    return "assumption" if "assumption" in text else "nothing said" if text == "nothing said" else "source"
