"""The robot as an MJCF file that shows its muscles in MuJoCo's viewer, as two spatial tendons without force a joint."""

from __future__ import annotations

from typing import Any

import numpy as np

from dehyst.arrays import Array
from dehyst_robot.arm._body import body_spec
from dehyst_robot.arm._parameters import Robot
from dehyst_robot.arm._rigid_body import arm_mjcf, moment_arms, mujoco, new_data

THROUGH = 0.35  # opacity
LONGEST = 0.2  # of what is drawn of a muscle [m]
COLOURS = (
    (0.8, 0.25, 0.2, 1.0),
    (0.2, 0.35, 0.8, 1.0),
)  # of muscle 1, which turns its joint forward, and of 2


def drawn_mjcf(robot: Robot) -> str:
    """Return the robot as MJCF with its muscles as tendons "muscle J.1" and "muscle J.2", which pull nothing.

    Each is led from the body before the joint, along it, to a point of the link that is as far from the axis as the
    moment arm at zero: there its length changes with the angle as the muscle's. Tendons of the body's own file stay.

    Examples
    --------
    >>> from dehyst_robot.arm import load_robot
    >>> model = mujoco().MjModel.from_xml_string(drawn_mjcf(load_robot()))
    >>> model.ntendon, model.tendon(0).name, bool(model.tendon_stiffness.any())
    (10, 'muscle 1.1', False)
    """
    lib = mujoco()
    spec = _spec_without_muscles(lib, robot)
    model = spec.compile()
    data = new_data(model)
    lib.mj_forward(model, data)
    spec.visual.headlight.ambient, spec.visual.headlight.diffuse = [0.4] * 3, [0.6] * 3
    for geom in spec.geoms:  # links that one sees through: muscles run close to them
        geom.rgba[3] = min(geom.rgba[3], THROUGH)
    for row, (number, joint) in enumerate(robot.joints.items()):
        if joint.damping is not None and joint.body_joint is not None:
            spec.joint(joint.body_joint).damping[0] = joint.damping
        if not joint.pneumatic or joint.routing == "tendon":
            continue
        link = int(model.jnt_bodyid[row])
        axis, anchor = data.xaxis[row], data.xanchor[row]
        before = int(model.body_parentid[link])
        back = _across(axis, data.xpos[before] - anchor, anchor - data.subtree_com[link])
        side = np.cross(back, axis)  # a point there goes back where the joint turns forward
        length = min(LONGEST, *robot.lengths(number))
        for muscle, arm in enumerate(moment_arms(robot, number), 1):
            name, end = f"muscle {number}.{muscle}", anchor + float(arm[0]) * side
            tendon = spec.add_tendon(name=name, width=0.008, rgba=COLOURS[muscle - 1])
            for body, place, suffix in ((before, end + length * back, "rest"), (link, end, "link")):
                local = data.xmat[body].reshape(3, 3).T @ (place - data.xpos[body])
                site = f"{name} {suffix}"
                spec.body(model.body(body).name).add_site(name=site, pos=local, size=[0.004] * 3)
                tendon.wrap_site(site)
    spec.compile()
    return str(spec.to_xml())


def _spec_without_muscles(lib: Any, robot: Robot) -> Any:
    # All joints move, masses are nominal, and links stay separate: they are drawn.
    build = (robot, set(robot.joints), robot.payload.mass, 1.0, dict[int, float](), False)
    if robot.body is None:
        return lib.MjSpec.from_string(arm_mjcf(*build))
    return body_spec(lib, *build)


def _across(axis: Array, *preferred: Array) -> Array:
    """Return the first of these directions that is not along an axis, at right angles to it, as long as 1."""
    for direction in (*preferred, *np.eye(3)):
        across = direction - axis * (axis @ direction)
        if np.linalg.norm(across) > 1e-3:
            return np.asarray(across / np.linalg.norm(across))
    raise AssertionError("one of three axes is at right angles to any other")
