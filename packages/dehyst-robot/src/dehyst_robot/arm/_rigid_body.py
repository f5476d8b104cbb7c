"""Rigid-body model of the arm in MuJoCo: links with mass, gravity and bearings; no contacts, no constraints.

Frames: x forward, y left, z up, origin on the floor under joint 1. At angles of zero the arm stands in its zero pose
(``zero_deg`` of the joints is in the bodies' frames). A link lies along the x axis of its body; yaw turns about z,
pitch about y (down is positive), roll about x. MuJoCo is imported on first use; its exceptions become errors of dehyst.
"""

from __future__ import annotations

import ctypes
import importlib
import math
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from dehyst.arrays import Array
from dehyst.errors import MissingExtraError, ParameterError
from dehyst.shell import did_you_mean
from dehyst_robot.arm._body import POINT_INERTIA, body_model
from dehyst_robot.arm._parameters import CONTRACTIONS, Robot, numbers_text
from dehyst_robot.arm._routing import Arms, joint_arms, reduced, refuse_unusable

if TYPE_CHECKING:
    from mujoco import MjData, MjModel

SMALL = 1e-5  # of the difference quotient of a tendon's length [rad]
AXES = {"roll": (1, 0, 0), "pitch": (0, 1, 0), "yaw": (0, 0, 1)}
LEAST_MUJOCO = (3, 14)


def mujoco() -> Any:
    """Return the module mujoco; versions that give fused links a wrong inertia are refused."""
    module = _imported("mujoco", "simulating the arm")
    if tuple(map(int, module.__version__.split(".")[:2])) < LEAST_MUJOCO:
        raise MissingExtraError(
            f"mujoco {module.__version__} is installed; versions before 3.14 give a wrong inertia to links that cannot "
            f"move (0.24 in place of 2.48 kg m^2 at joint 1 with 3.9). Type: pip install 'mujoco>=3.14'",
            extra="dehyst-robot",
            version=module.__version__,
        )
    return module


def mink() -> Any:
    """Return the module mink, inverse kinematics."""
    _imported("daqp", "the inverse kinematics of the arm")
    return _imported("mink", "the inverse kinematics of the arm")


@cache
def mj_step_address() -> int:
    """Return the address of MuJoCo's ``void mj_step(const mjModel*, mjData*)``, for a loop without Python."""
    package = Path(mujoco().__file__).parent
    libraries: list[Path] = []
    for pattern in ("libmujoco.so*", "libmujoco*.dylib", "mujoco*.dll"):
        libraries += package.rglob(pattern)
    libraries.sort()
    for library in libraries:
        try:
            address = ctypes.cast(ctypes.CDLL(str(library)).mj_step, ctypes.c_void_p).value
        except (OSError, AttributeError):  # a plugin's library, or one of another machine
            continue
        if address:
            return address
    names = ", ".join(file.name for file in libraries) or "none"
    raise MissingExtraError(
        f"mujoco {mujoco().__version__} is installed, but no library beside it has the function mj_step (libraries "
        f"found: {names}); the closed loop calls it directly. Type: pip install --force-reinstall 'mujoco>=3.14'",
        extra="dehyst-robot",
        libraries=names,
    )


def _imported(module: str, doing: str) -> Any:
    try:
        return importlib.import_module(module)
    except ImportError as fault:
        raise MissingExtraError(
            f"{doing} needs the package {module}, which is not installed ({fault}). Type: pip install dehyst-robot",
            extra="dehyst-robot",
            module=module,
        ) from None


def arm_mjcf(
    robot: Robot,
    moving: set[int],
    payload: float,
    scale: float,
    locked: Mapping[int, float],
    fused: bool = False,
) -> str:
    """Return the arm as XML.

    Parameters
    ----------
    robot
        Geometry, masses, bearings.
    moving
        Numbers of the joints that are degrees of freedom.
    payload
        Point mass at the tool centre point. [kg]
    scale
        Factor of all masses.
    locked
        Angles of the other joints. [rad]
    fused
        Links that cannot move become one with what they hang on: the same physics in half the time.
    """
    # From the tool inwards: each link holds the ones behind it.
    body = _tool(robot.joints[max(robot.joints)].link_length, payload * scale)
    for number in sorted(robot.joints, reverse=True):
        body = _link(robot, number, number in moving, scale, locked.get(number, 0.0), body)
    return (
        f'<mujoco model="arm"><compiler angle="radian" autolimits="true" fusestatic="{str(fused).lower()}"/>'
        f'<option timestep="{robot.simulation.period!r}" integrator="implicitfast" gravity="0 0 -9.81">'
        f'<flag contact="disable" constraint="disable"/></option>'
        f"<worldbody>{body}</worldbody></mujoco>"
    )


def _link(robot: Robot, number: int, moves: bool, scale: float, angle: float, inner: str) -> str:
    joint = robot.joint(number)
    assert joint.axis is not None
    assert joint.link_mass is not None
    mass = joint.link_mass * scale
    x, y, z = AXES[joint.axis]
    turn = joint.zero
    hinge = ""
    if moves:
        hinge = (
            f'<joint name="joint {number}" type="hinge" axis="{x} {y} {z}" damping="{joint.damping!r}" '
            f'range="{-joint.range!r} {joint.range!r}"/>'
        )
    else:
        # A locked joint is no degree of freedom: its angle is in the frame of its body.
        turn = joint.zero + angle
    half = turn / 2
    quat = (
        f"{math.cos(half)!r} {x * math.sin(half)!r} {y * math.sin(half)!r} {z * math.sin(half)!r}"
    )
    # The base carries joint 1; a link begins where the one before it ends.
    place = f"0 0 {robot.base.height!r}"
    if number > 1:
        place = f"{robot.joint(number - 1).link_length!r} 0 0"
    return (
        f'<body name="link {number}" pos="{place}" quat="{quat}">{hinge}'
        f'<geom name="link {number}" type="capsule" fromto="0 0 0 {joint.link_length!r} 0 0" '
        f'size="{joint.link_radius!r}" mass="{mass!r}" contype="0" conaffinity="0"/>{inner}</body>'
    )


def _tool(length: float | None, payload: float) -> str:
    site = f'<site name="tool" pos="{length!r} 0 0"/>'
    if not payload:
        return site
    inertia = f"{POINT_INERTIA} {POINT_INERTIA} {POINT_INERTIA}"
    return (
        f'{site}<body name="payload" pos="{length!r} 0 0"><inertial pos="0 0 0" mass="{payload!r}" '
        f'diaginertia="{inertia}"/></body>'
    )


def arm_model(
    robot: Robot,
    moving: Sequence[int] | None = None,
    payload: float | None = None,
    mass_error: float = 0.0,
    locked: Mapping[int, float] | None = None,
    fused: bool = False,
) -> MjModel:
    """Build the arm as a MuJoCo model.

    Parameters
    ----------
    robot
        From `load_robot`.
    moving
        Numbers of the joints that move, increasing; they are the model's degrees of freedom, in this order. None: all.
    payload
        Point mass at the tool centre point [kg]; None: that of the file.
    mass_error
        All masses and inertias are multiplied by 1 + mass_error.
    locked
        Joint number -> angle of a joint that does not move [rad]; zero where missing.
    fused
        Make links that cannot move one with what they hang on: the same physics in half the time, but then there is
        no body for them, and `joint_positions` cannot ask where they are.

    Returns
    -------
    model : mujoco.MjModel
        With the site "tool", and one body "link J" per joint.

    Raises
    ------
    ParameterError
        If `moving` names a joint that is not there, or one twice; if `locked` names one that moves.
    MissingExtraError
        If MuJoCo is not installed.

    Examples
    --------
    >>> from dehyst_robot.arm import load_robot
    >>> model = arm_model(load_robot(), moving=(1, 2, 4))
    >>> model.nv, round(float(model.body_mass.sum()), 1)
    (3, 19.2)
    """
    numbers = list(robot.joints if moving is None else moving)
    if not numbers or numbers != sorted(set(numbers)) or not set(numbers) <= set(robot.joints):
        raise ParameterError(
            f"the moving joints {tuple(numbers)} are not increasing numbers out of {numbers_text(robot.joints)}. Type "
            f"e.g. moving={tuple(robot.joints)[:3]}.",
            moving=tuple(numbers),
        )
    angles = dict(locked or {})
    still = set(robot.joints) - set(numbers)
    if not set(angles) <= still or not all(map(math.isfinite, angles.values())):
        raise ParameterError(
            f"locked = {angles} must give finite angles of joints that do not move, and {tuple(numbers)} do.",
            locked=angles,
        )
    if not (math.isfinite(mass_error) and mass_error > -1.0):
        raise ParameterError(
            f"mass_error = {mass_error} leaves no mass. It must be above -1.", mass_error=mass_error
        )
    mass = payload
    if mass is None:
        mass = robot.payload.mass
    if not (math.isfinite(mass) and 0.0 <= mass <= 1000.0):
        raise ParameterError(
            f"payload = {mass} kg is no mass. It must be 0 .. 1000 kg.", payload=mass
        )
    build = (robot, set(numbers), mass, 1.0 + mass_error, angles, fused)
    if robot.body is None:
        return mujoco().MjModel.from_xml_string(arm_mjcf(*build))
    return body_model(mujoco(), *build)


def new_data(model: MjModel) -> MjData:
    """Return a state of the model: at rest in the zero pose."""
    data = mujoco().MjData(model)
    data.qpos[:] = 0  # a body's file may have another pose at first
    return data


@cache
def moment_arms(robot: Robot, number: int) -> Arms:
    """Return the coefficients of both muscles' moment arms, see `dehyst_robot.arm._routing`. [m/rad^j]

    Raises
    ------
    ParameterError
        If the joint is electric, or a tendon is not there, depends on other joints too or has an arm that is no
        polynomial.

    Examples
    --------
    >>> from dehyst_robot.arm import load_robot
    >>> moment_arms(load_robot(), 1)[1].tolist()
    [-0.05]
    """
    joint = robot.joint(number)
    key = f"joint.{number}"
    if not joint.pneumatic:
        raise ParameterError(
            f"joint {number} is electric: it has no muscles and no valves. Joints with muscles: {robot.pneumatic}.",
            joint=number,
        )
    if joint.routing != "tendon":
        return joint_arms(joint, key)
    model = arm_model(robot)
    assert joint.tendons is not None  # checked with the file
    first = _tendon_arm(robot, model, number, joint.tendons[0])
    second = _tendon_arm(robot, model, number, joint.tendons[1])
    refuse_unusable(joint, (first, second), robot.lengths(number), CONTRACTIONS, key)
    return first, second


def _tendon_arm(robot: Robot, model: MjModel, number: int, name: str) -> Array:
    """Return the moment arm of a spatial tendon; refuse one that other joints shorten too."""
    names = [model.tendon(k).name for k in range(model.ntendon)]
    if name not in names:
        raise ParameterError(
            f"joint.{number}.tendons: {name!r} is no spatial tendon of the body's file.{did_you_mean(name, names)} It "
            f"has {', '.join(names) or 'none'}.",
            tendon=name,
        )
    data, row = new_data(model), list(robot.joints).index(number)

    def lengths(moving_row: int, angles: Array) -> Array:
        lengths_at_angles = []
        for angle in angles:
            data.qpos[:] = 0
            data.qpos[moving_row] = angle
            mujoco().mj_fwdPosition(model, data)
            lengths_at_angles.append(data.ten_length[names.index(name)])
        return np.array(lengths_at_angles)

    for k, (number_of_other, joint) in enumerate(robot.joints.items()):
        # A length that changes by less than a nanometre does not change.
        if k != row and np.ptp(lengths(k, np.linspace(-joint.range, joint.range, 21))) > 1e-9:
            raise ParameterError(
                f"joint.{number}.tendons: joint {number_of_other} ({joint.body_joint}) moves the tendon {name!r} too. "
                f"A muscle of one joint pulls at that joint only: lead the tendon past no other.",
                tendon=name,
                joint=number_of_other,
            )
    reach, h = robot.joint(number).range, SMALL
    return reduced(
        lambda q: (lengths(row, q - h) - lengths(row, q + h)) / (2 * h), reach, f"tendon {name!r}"
    )


def inverse_dynamics(
    model: MjModel, angles: Array, velocities: Array, accelerations: Array
) -> Array:
    """Torque M(q) qdd + c(q, qd) + g(q) + D qd that the drives must give for a motion.

    D holds the bearings' ``damping_Nm_s`` (MuJoCo counts it as a passive force; it is in here once, and an
    integrator of that model adds nothing to it).

    `angles`, `velocities` [rad/s] and `accelerations` of the moving joints are (T, n).

    Returns
    -------
    torque : ndarray
        (T, n). [Nm]
    """
    lib, data = mujoco(), new_data(model)
    q, qd, qdd = _rows(model, angles), _rows(model, velocities), _rows(model, accelerations)
    out = np.empty_like(q)
    for k in range(q.shape[0]):
        data.qpos[:] = q[k]
        data.qvel[:] = qd[k]
        data.qacc[:] = qdd[k]
        lib.mj_inverse(model, data)
        out[k] = data.qfrc_inverse
    return out


def bias_torque(model: MjModel, angles: Array) -> Array:
    """Torque that holds the arm still against gravity at angles (T, n), (T, n). [Nm]"""
    # At rest all that is left of the equations of motion is weight, springs of the file included.
    q = _rows(model, angles)
    return inverse_dynamics(model, q, np.zeros_like(q), np.zeros_like(q))


def joint_inertia(model: MjModel, angles: Array | None = None) -> Array:
    """Inertia about each moving joint while the others stand still: the diagonal of M(q).

    Returns
    -------
    inertia : ndarray
        (T, n) or (n,). [kg m^2]
    """
    if angles is None:
        angles = np.zeros(model.nv)
    lib, data = mujoco(), new_data(model)
    q = _rows(model, angles)
    out = np.empty_like(q)
    full = np.empty((model.nv, model.nv))  # MuJoCo itself stores M sparsely
    for k in range(q.shape[0]):
        data.qpos[:] = q[k]
        lib.mj_forward(model, data)
        lib.mj_fullM(model, data, full)
        out[k] = np.diag(full)
    return out.reshape(np.shape(angles))


def tool_site(model: MjModel) -> int:
    """Return the number of the site that is the tool centre point."""
    return int(model.site("tool").id)


def tool_positions(model: MjModel, angles: Array) -> Array:
    """Tool centre point at angles (T, n): (T, 3) in the frame of the base. [m]"""
    lib, data = mujoco(), new_data(model)
    q = _rows(model, angles)
    out, tool = np.empty((q.shape[0], 3)), tool_site(model)
    for k in range(q.shape[0]):
        data.qpos[:] = q[k]
        lib.mj_kinematics(model, data)  # positions need no forces
        out[k] = data.site_xpos[tool]
    return out


def joint_positions(model: MjModel, angles: Array) -> Array:
    """Positions of the n moving joints and the tool centre point at angles (T, n): (T, n + 1, 3), for drawing. [m]"""
    lib, data = mujoco(), new_data(model)
    q = _rows(model, angles)
    out, tool = np.empty((q.shape[0], model.nv + 1, 3)), tool_site(model)
    for k in range(q.shape[0]):
        data.qpos[:] = q[k]
        lib.mj_kinematics(model, data)
        out[k, :-1] = data.xanchor
        out[k, -1] = data.site_xpos[tool]
    return out


def _rows(model: MjModel, angles: Array) -> Array:
    rows = np.atleast_2d(np.asarray(angles, np.float64))
    if rows.ndim != 2 or rows.shape[1] != model.nv:
        raise ParameterError(
            f"angles of shape {np.shape(angles)} do not belong to {model.nv} moving joints: pass (T, {model.nv}).",
            shape=np.shape(angles),
        )
    return rows
