"""Links from a model file, URDF or MJCF, read by MuJoCo's own reader.

Of the file are taken: bodies with their masses, joints, bearings, springs and tendons, gravity. Joints that the robot's
file does not name are locked where the file has them at first. Actuators, sensors, key frames, contacts, stops and
equality constraints are left out: what moves the joints is dehyst's, and it simulates no constraints. Meshes that
cannot be read are left out, too, where masses do not come from them.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from dehyst.arrays import Array
from dehyst.errors import ParameterError
from dehyst.shell import did_you_mean
from dehyst_robot.arm._parameters import Robot

if TYPE_CHECKING:
    from mujoco import MjModel

MOST_JOINTS = 12  # of a robot
# Of a body file: what dehyst does with it takes 5 s with 150 joints and grows with their square; a humanoid with hands
# has 60 to 100 joints.
MOST_IN_FILE = 120
MOST_BODIES = 1000
MOST_COPIES = 10_000  # that <replicate>, <composite> and <flexcomp> may ask for; MuJoCo makes them while it reads
COPIES = re.compile(r"""\bcount\s*=\s*["']([\d\s.eE+]+)["']""")
MESHES = (".stl", ".obj", ".msh")  # that MuJoCo reads
POINT_INERTIA = 1e-9  # of a point mass: MuJoCo wants more than nothing [kg m^2]


def body_model(
    lib: Any,
    robot: Robot,
    moving: set[int],
    payload: float,
    scale: float,
    locked: Mapping[int, float],
    fused: bool,
) -> MjModel:
    """Compile a robot's body file; `lib` is the module mujoco, the rest as for `dehyst_robot.arm._rigid_body.arm_mjcf`.

    Raises
    ------
    ParameterError
        If MuJoCo cannot read the file, or it does not have what the robot's file names.
    """
    spec = body_spec(lib, robot, moving, payload, scale, locked, fused)
    model = spec.compile()
    for number, joint in robot.joints.items():
        if joint.damping is not None and number in moving:
            model.dof_damping[model.joint(joint.body_joint).dofadr] = joint.damping
    for values in (model.body_mass, model.body_inertia, model.dof_armature):
        values *= scale
    lib.mj_setConst(model, lib.MjData(model))
    return model


def body_spec(
    lib: Any,
    robot: Robot,
    moving: set[int],
    payload: float,
    scale: float,
    locked: Mapping[int, float],
    fused: bool,
) -> Any:
    """Return what `body_model` compiles, as MuJoCo's MjSpec, before dampings and masses are changed."""
    assert robot.body is not None
    file = robot.body.file
    angles: dict[str, float | None] = {}  # None: the joint moves
    for number, joint in robot.joints.items():
        angles[str(joint.body_joint)] = None if number in moving else locked.get(number, 0.0)
    try:
        spec, whole = _read(lib, robot)
        last = spec.joint(robot.joints[max(robot.joints)].body_joint).parent
        # Joints are locked first: numbers of bodies are valid until the first part is added.
        _lock(lib, spec, whole, angles, file)
        _add_tool(robot, spec, last, whole.body(last.name).ipos, payload)
        spec.compiler.fusestatic = fused
        spec.compile()
    except ParameterError:  # which is a ValueError, too
        raise
    except ValueError as fault:
        raise _unreadable(file, fault) from None
    return spec


@dataclass(frozen=True)
class Hinges:
    """Joints of a body file.

    Attributes
    ----------
    free
        Name and ends of the range [rad], 0 and 0 without one, of the hinges that can be driven, from the base outwards.
    locked
        Name of every other joint, and why it cannot be driven.
    """

    free: tuple[tuple[str, float, float], ...]
    locked: tuple[str, ...]


def hinges_of(lib: Any, file: Path) -> Hinges:
    """Return which joints of a body file can be driven, and why the others cannot."""
    try:
        spec = _parsed(lib, file, file.name)
        model = spec.compile()
    except ParameterError:  # which is a ValueError, too
        raise
    except ValueError as fault:
        raise _unreadable(file.name, fault) from None
    reasons = _reasons(lib, spec)
    # A body moves with all its joints or with none: one locked joint locks the others of its body.
    locked_bodies = {model.jnt_bodyid[index] for index in reasons}
    hinges: list[int] = []
    for index in range(model.njnt):
        if model.jnt_bodyid[index] not in locked_bodies:
            hinges.append(index)
        elif index not in reasons:
            reasons[index] = "shares a body with a locked one"
    for index in hinges[MOST_JOINTS:]:
        reasons[index] = f"comes after the first {MOST_JOINTS}"
    free = []
    for index in hinges[:MOST_JOINTS]:
        low, high = (model.jnt_limited[index] * model.jnt_range[index]).tolist()
        free.append((model.joint(index).name, low, high))
    locked = []
    for index, reason in sorted(reasons.items()):
        locked.append(f"{model.joint(index).name or 'a joint'} {reason}")
    return Hinges(tuple(free), tuple(locked))


def _reasons(lib: Any, spec: Any) -> dict[int, str]:
    """Return number of a joint -> why it cannot be driven, of joints that are not named hinges of their own."""
    kinds = lib.mjtJoint
    reason_of_kind = {
        kinds.mjJNT_SLIDE: "slides",
        kinds.mjJNT_BALL: "is a ball joint",
        kinds.mjJNT_FREE: "floats freely",
    }
    leaders = {}
    for equality in spec.equalities:
        if equality.type == lib.mjtEq.mjEQ_JOINT:
            leaders[equality.name1] = equality.name2
    reasons: dict[int, str] = {}
    for joint in spec.joints:
        if joint.type != kinds.mjJNT_HINGE:
            reasons[joint.id] = reason_of_kind[joint.type]
        elif not joint.name:
            reasons[joint.id] = "has no name"
        elif leader := leaders.get(joint.name):
            reasons[joint.id] = f"follows {leader}"
        elif joint.name in leaders:
            reasons[joint.id] = "is held by an equality"
    return reasons


# Words in a message of MuJoCo -> what to do about it.
CURES = (
    (
        "mass and inertia of moving bodies",
        "Give each link that moves an <inertial> with its mass and inertia.",
    ),
    (
        "opening file",
        "Put that file where the body's file looks for it, or take the part out that names it.",
    ),
    ("bad format", "Numbers only: expand a xacro file first, by: xacro ARM.urdf.xacro > ARM.urdf"),
    ("parse error", "Name a URDF or MJCF file, as a simulator takes it."),
    ("empty file", "Name a URDF or MJCF file, as a simulator takes it."),
    ("plugin", "Take that <plugin> out of it: what drives the joints is dehyst's."),
)


def _unreadable(file: str, fault: Exception) -> ParameterError:
    message = " ".join(str(fault).split()).removeprefix("Error: ")
    cure = f"Look at it with: python -m mujoco.viewer --mjcf={file}"
    for words, cure_of_words in CURES:
        if words in message:
            cure = cure_of_words
            break
    return ParameterError(
        f"MuJoCo cannot use the body file '{file}': {message.rstrip('.')}. {cure}", file=file
    )


def _parsed(lib: Any, place: Path, file: str) -> Any:
    """A body file with names for all its bodies, without the meshes that cannot be read and are not needed."""
    _refuse_copies(place, file)
    spec = lib.MjSpec.from_file(str(place))
    for count, most, parts in (
        (len(spec.joints), MOST_IN_FILE, "joints"),
        (len(spec.bodies), MOST_BODIES, "bodies"),
    ):
        if count > most:
            raise ParameterError(
                f"'{file}' has {count} {parts}; dehyst reads body files of up to {most}, of which it drives up to "
                f"{MOST_JOINTS} joints. Cut the arm out of it: keep its links and joints, and fix the others.",
                **{parts: count},
            )
    for index, body in enumerate(spec.bodies):
        body.name = body.name or f"body {index} without a name"
    _remove_unreadable_meshes(spec, place, file)
    return spec


def _remove_unreadable_meshes(spec: Any, place: Path, file: str) -> None:
    """Remove meshes that cannot be read, and what is drawn of them; refuse those that a mass comes from."""
    folder = place.parent / (spec.meshdir or "")
    unreadable = {}
    for mesh in spec.meshes:
        readable = Path(mesh.file).suffix.lower() in MESHES and (folder / mesh.file).is_file()
        if mesh.file and not readable:
            unreadable[mesh.name] = mesh.file
    # What is deleted changes the lists of the spec, so loops go over copies.
    for geom in list(spec.geoms):
        if geom.meshname not in unreadable:
            continue
        if not geom.parent.explicitinertial and geom.mass != 0 and _moves(spec, geom.parent):
            raise ParameterError(
                f"the link '{geom.parent.name}' of '{file}' has no <inertial>, and the mesh "
                f"'{unreadable[geom.meshname]}' that its mass would come from is not there or no "
                f"{', '.join(MESHES)} file. Give it an <inertial>, or put the mesh there.",
                body=geom.parent.name,
            )
        spec.delete(geom)
    for mesh in list(spec.meshes):
        if mesh.name in unreadable:
            spec.delete(mesh)


def _refuse_copies(place: Path, file: str) -> None:
    """Refuse, before MuJoCo reads it, a file that asks for very many copies of its parts."""
    try:
        text = place.read_text(encoding="utf-8", errors="replace")
    except OSError:
        return  # MuJoCo says why
    copies = 1.0
    for match in COPIES.finditer(text):
        for word in match[1].split():
            with suppress(ValueError):  # MuJoCo says what is no number
                copies *= max(1.0, float(word))
    if copies > MOST_COPIES:
        raise ParameterError(
            f"'{file}' asks for {copies:.3g} copies of its parts (count of <replicate>, <composite> or <flexcomp>), "
            f"more than the {MOST_COPIES} that are read. Take them out: dehyst needs the links of an arm only.",
            copies=copies,
        )


def _moves(spec: Any, body: Any) -> bool:
    while body.name != spec.worldbody.name:
        if body.joints:
            return True
        body = body.parent
    return False


def _read(lib: Any, robot: Robot) -> tuple[Any, MjModel]:
    """Return the file with the robot's zeros, without actuators and constraints; and its model with all joints free."""
    assert robot.body is not None
    spec = _parsed(lib, robot.beside(robot.body.file), robot.body.file)
    spec.option.timestep = robot.simulation.period
    spec.option.integrator = lib.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.disableflags |= (
        lib.mjtDisableBit.mjDSBL_CONTACT | lib.mjtDisableBit.mjDSBL_CONSTRAINT
    )
    spec.compiler.fusestatic = False
    for part in (*spec.keys, *spec.sensors, *spec.actuators, *spec.equalities):
        spec.delete(part)
    unit = math.degrees(1.0) if spec.compiler.degree else 1.0
    hinges = [joint.name for joint in spec.joints if joint.type == lib.mjtJoint.mjJNT_HINGE]
    for number, joint in robot.joints.items():
        if joint.body_joint not in hinges:
            raise ParameterError(
                f"joint.{number}.body_joint = {joint.body_joint!r} is no hinge of '{robot.body.file}'."
                f"{did_you_mean(joint.body_joint, hinges)} It has {', '.join(hinges) or 'none'}.",
                joint=number,
            )
        hinge = spec.joint(joint.body_joint)
        # The angles of the file move by the one at which the robot's angle is zero.
        hinge.ref -= unit * joint.zero
        hinge.springref -= unit * joint.zero
        hinge.range = [-unit * joint.range, unit * joint.range]
        hinge.limited = lib.mjtLimited.mjLIMITED_TRUE
    whole = spec.compile()
    _refuse_order(robot, whole, hinges)
    for tendon, first in zip(spec.tendons, whole.tendon_adr, strict=True):
        # A fixed tendon couples joints, of which some may be locked.
        if whole.wrap_type[first] == lib.mjtWrap.mjWRAP_JOINT:
            spec.delete(tendon)
    return spec, whole


def _refuse_order(robot: Robot, whole: MjModel, hinges: list[str]) -> None:
    """Refuse two joints of one name, and numbers of joints in another order than that of the file."""
    assert robot.body is not None
    names = [joint.body_joint for joint in robot.joints.values()]
    order = [whole.joint(name).id for name in names]
    repeated = [name for name in names if names.count(name) > 1]
    if repeated:
        raise ParameterError(
            f"{len(repeated)} joints have body_joint = {repeated[0]!r}. Give each a hinge of its own: "
            f"{', '.join(hinges)}.",
            order=order,
        )
    if order != sorted(set(order)):
        raise ParameterError(
            f"the joints of '{robot.body.file}' are numbered in another order than they have there. Number them from "
            f"the base outwards: {', '.join(name for name in hinges if name in names)}.",
            order=order,
        )


def _lock(
    lib: Any, spec: Any, whole: MjModel, angles: Mapping[str, float | None], file: str
) -> None:
    """Remove the joints that do not move, and place their bodies as these joints' angles say.

    `angles` holds for each joint its angle, or None if the joint moves. Joints without an entry stay as in the file.
    """
    data = lib.MjData(whole)
    for name, angle in angles.items():
        if angle is not None:
            data.qpos[whole.jnt_qposadr[whole.joint(name).id]] = angle
    lib.mj_kinematics(whole, data)
    still = [joint for joint in spec.joints if angles.get(joint.name, 0.0) is not None]
    locked_bodies = {joint.parent.id: joint.parent for joint in still}
    # With the bodies at their parents' origins, what a compilation shows are the places of the <frame>s around them.
    for body in locked_bodies.values():
        body.pos = [0.0] * 3
        body.quat = [1.0, 0.0, 0.0, 0.0]
        body.alt.type = lib.mjtOrientation.mjORIENTATION_QUAT
    frames = spec.compile()
    for body in locked_bodies.values():
        if any(joint not in still for joint in body.joints):
            raise ParameterError(
                f"the body '{body.name}' of '{file}' has joints that move and joints that are locked: dehyst cannot "
                f"lock them. Give each joint a body of its own.",
                body=body.name,
            )
        parent = whole.body_parentid[body.id]
        back, place, turn = np.empty(4), np.empty(3), np.empty(4)
        # The pose relative to the parent body, then relative to the frame around it.
        lib.mju_negQuat(back, data.xquat[parent])
        lib.mju_rotVecQuat(place, data.xpos[body.id] - data.xpos[parent], back)
        lib.mju_mulQuat(turn, back, data.xquat[body.id])
        lib.mju_negQuat(back, frames.body_quat[body.id])
        lib.mju_rotVecQuat(place, place - frames.body_pos[body.id], back)
        lib.mju_mulQuat(turn, back, turn.copy())
        body.pos, body.quat = place, turn
    for joint in still:
        spec.delete(joint)


def _add_tool(robot: Robot, spec: Any, last: Any, center: Array, payload: float) -> None:
    """Make the site "tool", at the centre of mass of the last body if there is none, and hang the payload on it."""
    assert robot.body is not None
    tool = robot.body.tool
    site = spec.site(tool or "tool")
    if site is None and tool is not None:
        names = [other_site.name for other_site in spec.sites]
        raise ParameterError(
            f"body.tool = {tool!r} is no site of '{robot.body.file}'.{did_you_mean(tool, names)} It has "
            f"{', '.join(names) or 'none'}.",
            tool=tool,
        )
    if site is None:
        site = last.add_site(pos=center)
    site.name = "tool"
    if payload:
        site.parent.add_body(
            name="payload",
            pos=site.pos,
            mass=payload,
            ipos=[0, 0, 0],
            inertia=[POINT_INERTIA] * 3,
            explicitinertial=True,
        )
