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
from dehyst.fields import did_you_mean
from dehyst.robot.arm.parameters import Robot

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
    lib: Any, robot: Robot, moving: set[int], payload: float, scale: float, locked: Mapping[int, float], fused: bool
) -> MjModel:
    """Compile a robot's body file; `lib` is the module mujoco, the rest as for `dehyst.robot.arm.rigid_body.arm_mjcf`.

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
    lib: Any, robot: Robot, moving: set[int], payload: float, scale: float, locked: Mapping[int, float], fused: bool
) -> Any:
    """Return what `body_model` compiles, as MuJoCo's MjSpec, before dampings and masses are changed."""
    assert robot.body is not None
    file = robot.body.file
    angles = {
        str(joint.body_joint): None if number in moving else locked.get(number, 0.0)
        for number, joint in robot.joints.items()
    }
    try:
        spec, whole = _read(lib, robot)
        last = spec.joint(robot.joints[max(robot.joints)].body_joint).parent
        _lock(lib, spec, whole, angles, file)  # first: numbers of bodies end with the first part that is added
        _add_tool(robot, spec, last, whole.body(last.name).ipos, payload)
        spec.compiler.fusestatic = fused
        spec.compile()
    except ValueError as fault:
        raise fault if isinstance(fault, ParameterError) else _unreadable(file, fault) from None
    return spec


@dataclass(frozen=True)
class Hinges:
    """Joints of a body file: name and range [rad], else 0, 0, of hinges that can be driven, from the base outwards; and
    what each other joint is."""

    free: tuple[tuple[str, float, float], ...]
    locked: tuple[str, ...]


def hinges_of(lib: Any, file: Path) -> Hinges:
    """Return which joints of a body file can be driven, and why the others cannot."""
    try:
        spec = _parsed(lib, file, file.name)
        model = spec.compile()
    except ValueError as fault:
        raise fault if isinstance(fault, ParameterError) else _unreadable(file.name, fault) from None
    kinds = lib.mjtJoint
    why = {kinds.mjJNT_SLIDE: "slides", kinds.mjJNT_BALL: "is a ball joint", kinds.mjJNT_FREE: "floats freely"}
    led = {each.name1: each.name2 for each in spec.equalities if each.type == lib.mjtEq.mjEQ_JOINT}
    said: dict[int, str] = {}
    for joint in spec.joints:
        if joint.type != kinds.mjJNT_HINGE:
            said[joint.id] = why[joint.type]
        elif not joint.name:
            said[joint.id] = "has no name"
        elif joint.name in led:
            said[joint.id] = f"follows {led[joint.name]}" if led[joint.name] else "is held by an equality"
    bodies = {model.jnt_bodyid[k] for k in said}
    told = {
        k: said.get(k, "shares a body with a locked one") for k in range(model.njnt) if model.jnt_bodyid[k] in bodies
    }
    hinges = [k for k in range(model.njnt) if k not in told]
    told |= dict.fromkeys(hinges[MOST_JOINTS:], f"comes after the first {MOST_JOINTS}")
    return Hinges(
        tuple(
            (model.joint(k).name, *(model.jnt_limited[k] * model.jnt_range[k]).tolist()) for k in hinges[:MOST_JOINTS]
        ),
        tuple(f"{model.joint(k).name or 'a joint'} {words}" for k, words in sorted(told.items())),
    )


# What MuJoCo says -> what to do about it.
CURES = (
    ("mass and inertia of moving bodies", "Give each link that moves an <inertial> with its mass and inertia."),
    ("opening file", "Put that file where the body's file looks for it, or take the part out that names it."),
    ("bad format", "Numbers only: expand a xacro file first, by: xacro ARM.urdf.xacro > ARM.urdf"),
    ("parse error", "Name a URDF or MJCF file, as a simulator takes it."),
    ("empty file", "Name a URDF or MJCF file, as a simulator takes it."),
    ("plugin", "Take that <plugin> out of it: what drives the joints is dehyst's."),
)


def _unreadable(file: str, fault: Exception) -> ParameterError:
    said = " ".join(str(fault).split()).removeprefix("Error: ")
    cures = [cure for words, cure in CURES if words in said]
    cure = cures[0] if cures else f"Look at it with: python -m mujoco.viewer --mjcf={file}"
    return ParameterError(f"MuJoCo cannot use the body file '{file}': {said.rstrip('.')}. {cure}", file=file)


def _parsed(lib: Any, place: Path, file: str) -> Any:
    """A body file with names for all its bodies, without the meshes that cannot be read and are not needed."""
    _refuse_copies(place, file)
    spec = lib.MjSpec.from_file(str(place))
    for many, most, what in ((len(spec.joints), MOST_IN_FILE, "joints"), (len(spec.bodies), MOST_BODIES, "bodies")):
        if many > most:
            raise ParameterError(
                f"'{file}' has {many} {what}; dehyst reads body files of up to {most}, of which it drives up to "
                f"{MOST_JOINTS} joints. Cut the arm out of it: keep its links and joints, and fix the others.",
                **{what: many},
            )
    for k, body in enumerate(spec.bodies):
        body.name = body.name or f"body {k} without a name"
    folder = place.parent / (spec.meshdir or "")
    lost = {
        mesh.name: mesh.file
        for mesh in spec.meshes
        if mesh.file and not (Path(mesh.file).suffix.lower() in MESHES and (folder / mesh.file).is_file())
    }
    for geom in [geom for geom in spec.geoms if geom.meshname in lost]:
        if not geom.parent.explicitinertial and geom.mass != 0 and _moves(spec, geom.parent):
            raise ParameterError(
                f"the link '{geom.parent.name}' of '{file}' has no <inertial>, and the mesh '{lost[geom.meshname]}' "
                f"that its mass would come from is not there or no {', '.join(MESHES)} file. Give it an <inertial>, or "
                f"put the mesh there.",
                body=geom.parent.name,
            )
        spec.delete(geom)
    for mesh in [mesh for mesh in spec.meshes if mesh.name in lost]:
        spec.delete(mesh)
    return spec


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
    """The file without what drives and holds it, its zeros those of the robot; and compiled, all joints free."""
    assert robot.body is not None
    spec = _parsed(lib, robot.beside(robot.body.file), robot.body.file)
    spec.option.timestep = robot.simulation.period
    spec.option.integrator = lib.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.disableflags |= lib.mjtDisableBit.mjDSBL_CONTACT | lib.mjtDisableBit.mjDSBL_CONSTRAINT
    spec.compiler.fusestatic = False
    for each in (*spec.keys, *spec.sensors, *spec.actuators, *spec.equalities):
        spec.delete(each)
    unit = math.degrees(1.0) if spec.compiler.degree else 1.0
    hinges = [joint.name for joint in spec.joints if joint.type == lib.mjtJoint.mjJNT_HINGE]
    for number, told in robot.joints.items():
        if told.body_joint not in hinges:
            raise ParameterError(
                f"joint.{number}.body_joint = {told.body_joint!r} is no hinge of '{robot.body.file}'."
                f"{did_you_mean(told.body_joint, hinges)} It has {', '.join(hinges) or 'none'}.",
                joint=number,
            )
        joint = spec.joint(told.body_joint)
        for place in ("ref", "springref"):  # the angle of the file at which ours is zero
            setattr(joint, place, getattr(joint, place) - unit * told.zero)
        joint.range, joint.limited = [-unit * told.range, unit * told.range], lib.mjtLimited.mjLIMITED_TRUE
    whole, named = spec.compile(), [told.body_joint for told in robot.joints.values()]
    order = [whole.joint(name).id for name in named]
    if twice := [name for name in named if named.count(name) > 1]:
        raise ParameterError(
            f"{len(twice)} joints have body_joint = {twice[0]!r}. Give each a hinge of its own: {', '.join(hinges)}.",
            order=order,
        )
    if order != sorted(set(order)):
        raise ParameterError(
            f"the joints of '{robot.body.file}' are numbered in another order than they have there. Number them from "
            f"the base outwards: {', '.join(name for name in hinges if name in named)}.",
            order=order,
        )
    for tendon, first in zip(spec.tendons, whole.tendon_adr, strict=True):
        if whole.wrap_type[first] == lib.mjtWrap.mjWRAP_JOINT:  # couples joints, of which some may be locked
            spec.delete(tendon)
    return spec, whole


def _lock(lib: Any, spec: Any, whole: MjModel, angles: Mapping[str, float | None], file: str) -> None:
    """Take away the joints that do not move, and put their bodies where the joints' angles put them.

    `angles`: name of a joint -> its angle, None if it moves; joints without a name there stay where the file has them.
    """
    data = lib.MjData(whole)
    for name, angle in angles.items():
        if angle is not None:
            data.qpos[whole.jnt_qposadr[whole.joint(name).id]] = angle
    lib.mj_kinematics(whole, data)
    still = [joint for joint in spec.joints if angles.get(joint.name, 0.0) is not None]
    held = {joint.parent.id: joint.parent for joint in still}
    for body in held.values():  # what is left of their places are those of the <frame>s around them
        body.pos, body.quat, body.alt.type = [0.0] * 3, [1.0, 0.0, 0.0, 0.0], lib.mjtOrientation.mjORIENTATION_QUAT
    frames = spec.compile()
    for body in held.values():
        if any(joint not in still for joint in body.joints):
            raise ParameterError(
                f"the body '{body.name}' of '{file}' has joints that move and joints that are locked: dehyst cannot "
                f"lock them. Give each joint a body of its own.",
                body=body.name,
            )
        parent, back = whole.body_parentid[body.id], np.empty(4)
        place, turn = np.empty(3), np.empty(4)
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
    told = robot.body.tool
    site = spec.site(told or "tool")
    if site is None and told is not None:
        names = [each.name for each in spec.sites]
        raise ParameterError(
            f"body.tool = {told!r} is no site of '{robot.body.file}'.{did_you_mean(told, names)} It has "
            f"{', '.join(names) or 'none'}.",
            tool=told,
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
