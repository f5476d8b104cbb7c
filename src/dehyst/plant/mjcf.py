"""The arm in MuJoCo's XML: a chain of capsules."""

from __future__ import annotations

import math
from collections.abc import Mapping

from dehyst.plant.parameters import Robot

AXES = {"roll": (1, 0, 0), "pitch": (0, 1, 0), "yaw": (0, 0, 1)}
POINT_INERTIA = 1e-9  # of a point mass: MuJoCo wants more than nothing [kg m^2]


def arm_mjcf(
    robot: Robot, moving: set[int], payload: float, scale: float, locked: Mapping[int, float], fused: bool = False
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
    body = _tool(robot.joint(7).link_length, payload * scale)
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
    x, y, z = AXES[joint.axis]
    turn = joint.zero + (0.0 if moves else angle)
    half = turn / 2
    quat = f"{math.cos(half)!r} {x * math.sin(half)!r} {y * math.sin(half)!r} {z * math.sin(half)!r}"
    place = f"0 0 {robot.base.height!r}" if number == 1 else f"{robot.joint(number - 1).link_length!r} 0 0"
    hinge = (
        f'<joint name="joint {number}" type="hinge" axis="{x} {y} {z}" damping="{joint.damping!r}" '
        f'range="{-joint.range!r} {joint.range!r}"/>'
        if moves
        else ""
    )
    return (
        f'<body name="link {number}" pos="{place}" quat="{quat}">{hinge}'
        f'<geom name="link {number}" type="capsule" fromto="0 0 0 {joint.link_length!r} 0 0" '
        f'size="{joint.link_radius!r}" mass="{joint.link_mass * scale!r}" contype="0" conaffinity="0"/>{inner}</body>'
    )


def _tool(length: float, payload: float) -> str:
    weight = (
        f'<body name="payload" pos="{length!r} 0 0"><inertial pos="0 0 0" mass="{payload!r}" '
        f'diaginertia="{POINT_INERTIA} {POINT_INERTIA} {POINT_INERTIA}"/></body>'
        if payload
        else ""
    )
    return f'<site name="tool" pos="{length!r} 0 0"/>{weight}'
