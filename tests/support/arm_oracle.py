"""The arm once more, slowly and without MuJoCo: frames by matrices, energy and inertia by differences."""

import math

import numpy as np

GRAVITY = 9.81


def turn(axis, angle):
    c, s = math.cos(angle), math.sin(angle)
    return {
        "roll": np.array([[1, 0, 0], [0, c, -s], [0, s, c]]),
        "pitch": np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]),
        "yaw": np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]),
    }[axis]


def frames(robot, q):
    """Return origins of the seven joints and the tool, (8, 3), and the rotations of the seven links."""
    origin, rotation = np.array([0.0, 0.0, robot.base.height]), np.eye(3)
    origins, rotations = [origin], []
    for number in range(1, 8):
        joint = robot.joint(number)
        rotation = rotation @ turn(joint.axis, joint.zero + q[number - 1])
        origin = origin + rotation @ [joint.link_length, 0.0, 0.0]
        origins.append(origin)
        rotations.append(rotation)
    return np.array(origins), rotations


def tool(robot, q):
    return frames(robot, q)[0][7]


def centers(robot, q):
    origins, _ = frames(robot, q)
    return (origins[:7] + origins[1:8]) / 2


def potential_energy(robot, q, payload=0.0):
    masses = np.array([robot.joint(n).link_mass for n in range(1, 8)])
    return GRAVITY * (masses @ centers(robot, q)[:, 2] + payload * tool(robot, q)[2])


def capsule_inertia(mass, length, radius):
    """Principal inertias (3,) of a solid cylinder with half spheres at both ends, about its centre; x along it."""
    cylinder, sphere = math.pi * radius**2 * length, 4 / 3 * math.pi * radius**3
    mc, ms = mass * cylinder / (cylinder + sphere), mass * sphere / (cylinder + sphere)
    along = mc * radius**2 / 2 + ms * 2 / 5 * radius**2
    half = mc * (length**2 / 12 + radius**2 / 4)
    ends = ms * (2 / 5 * radius**2 + length**2 / 4 + 3 / 8 * length * radius)
    return np.array([along, half + ends, half + ends])


def gradient(function, q, step=1e-6):
    """Derivative by q of a function of any shape, (..., 7), central differences."""
    columns = [
        (np.asarray(function(q + d)) - function(q - d)) / (2 * step) for d in step * np.eye(7)
    ]
    return np.stack(columns, axis=-1)


def mass_matrix(robot, q):
    """Return M with kinetic energy qd M qd/2, from the speeds of all links."""
    matrix = np.zeros((7, 7))
    move = gradient(lambda x: centers(robot, x), q)
    _, rotations = frames(robot, q)
    spin = gradient(lambda x: np.array(frames(robot, x)[1]), q)
    for i in range(7):
        joint = robot.joint(i + 1)
        matrix += joint.link_mass * move[i].T @ move[i]
        skew = np.einsum("abj,cb->acj", spin[i], rotations[i])
        rate = np.stack([skew[2, 1], skew[0, 2], skew[1, 0]])
        local = rotations[i].T @ rate
        inertia = capsule_inertia(joint.link_mass, joint.link_length, joint.link_radius)
        matrix += local.T @ (inertia[:, None] * local)
    return matrix
