"""Makes the file of a robot of one's own, and tells what a robot can do before anything is run on it."""

from __future__ import annotations

import math
import os
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from dehyst.arrays import Array
from dehyst.errors import ParameterError
from dehyst.robot.arm.body import hinges_of
from dehyst.robot.arm.joints import pneumatic_joint_parameters, run_pressures
from dehyst.robot.arm.parameters import Robot, robot_of
from dehyst.robot.arm.rigid_body import arm_model, bias_torque, joint_inertia, mujoco

PRESSURES = tuple(1e5 * bar for bar in range(1, 7))  # [Pa]
PLACES = 41  # of a joint's range
POSES = 400  # of the whole robot, drawn
SLOWLY = 9.0  # from place to place: viscous forces are nothing then [s]
PLAIN = {
    "hysteresis.mechanism": "none", "hysteresis.creep": 0.0, "tolerance.force": 0.0, "tolerance.hysteresis": 0.0,
}  # fmt: skip


@dataclass(frozen=True, eq=False)
class JointCheck:
    """What a joint can do.

    Attributes
    ----------
    angle
        (T,) over the range. [rad]
    pulls
        (6, T) torque with the first muscle at 1 to 6 bar and the second at the lowest pressure. Empty for electric
        joints. [Nm]
    back
        (6, T) torque the other way with the muscles exchanged; a spring in the place of the second pulls with what it
        has. [Nm]
    gravity
        Smallest and largest torque that holds the joint in drawn poses of the whole robot. [Nm]
    inertia
        Of the joint while the others stand still in the zero pose. [kg m^2]
    stiffness
        Of its muscles at the mean pressure in the middle of the range, without pressure control. [Nm/rad]
    """

    angle: Array
    pulls: Array
    back: Array
    gravity: tuple[float, float]
    inertia: float
    stiffness: float

    @property
    def frequency(self) -> float:
        """Natural frequency at the mean pressure with the valves shut off from control. [Hz]"""
        return math.sqrt(max(self.stiffness, 0.0) / self.inertia) / (2 * math.pi)

    @property
    def held(self) -> float:
        """Largest torque that the weaker muscle can give wherever the joint stands, at 6 bar. [Nm]"""
        return float(min(self.pulls[-1].min(), self.back[-1].min())) if self.pulls.size else math.inf

    @property
    def load(self) -> float:
        """Largest torque that gravity takes, either way. [Nm]"""
        return max(map(abs, self.gravity))

    @property
    def holds(self) -> bool:
        """Whether the muscles hold the joint against gravity in all poses, at 6 bar."""
        low, high = self.gravity
        return not self.pulls.size or bool(high <= self.pulls[-1].min() and -low <= self.back[-1].min())

    @property
    def least_pole(self) -> float:
        """Pole of a position loop as stiff as the muscles, 3 pole^2 M = k: below, the joint's own springs win. [1/s]"""
        return math.sqrt(max(self.stiffness, 0.0) / (3 * self.inertia))


def check_rig(robot: Robot) -> dict[int, JointCheck]:
    """Return what each joint can do, from muscles without hysteresis, creep and scatter.

    Examples
    --------
    >>> from dehyst.robot.arm import load_robot
    >>> found = check_rig(load_robot())[1]
    >>> round(found.stiffness), round(found.pulls[2, 20]), round(found.frequency, 1)
    (190, 66, 1.4)
    """
    model, plain = arm_model(robot), robot.with_changes(PLAIN)
    reach = np.array([joint.range for joint in robot.joints.values()])
    held = bias_torque(model, np.random.default_rng(0).uniform(-reach, reach, (POSES, reach.size)))
    inertia = joint_inertia(model)
    found = {}
    for k, (number, joint) in enumerate(robot.joints.items()):
        angle = np.linspace(-joint.range, joint.range, PLACES)
        pulls = back = np.empty((0, PLACES))
        stiffness = math.nan
        if joint.pneumatic:
            physics = pneumatic_joint_parameters(plain, number, 0)
            low, mean = robot.controller.pressure_low, robot.controller.mean_pressure

            def torque(one: float, two: float, physics: dict[str, object] = physics, q: Array = angle) -> Array:
                both = np.broadcast_to([one, two], (q.size, 2))
                return run_pressures(physics, q, both, SLOWLY).torque

            pulls = np.stack([torque(pressure, low) for pressure in PRESSURES])
            back = -np.stack([torque(low, pressure) for pressure in PRESSURES])
            middle = torque(mean, mean)[PLACES // 2 - 1 : PLACES // 2 + 2]
            stiffness = float((middle[0] - middle[2]) / (2 * (angle[1] - angle[0])))
        ends = float(held[:, k].min()), float(held[:, k].max())
        found[number] = JointCheck(angle, pulls, back, ends, float(inertia[k]), stiffness)
    return found


def cautions(robot: Robot, found: dict[int, JointCheck]) -> list[str]:
    """Return sentences on joints that cannot work as they are, with the numbers and the keys to change."""
    said = []
    for number, check in found.items():
        if not check.holds:
            said.append(
                f"joint {number}: gravity takes {check.gravity[0]:.3g} .. {check.gravity[1]:.3g} Nm, and at the worst "
                f"angle the joint gives {-check.back[-1].min():.3g} .. {check.pulls[-1].min():.3g} Nm at 6 bar. Some "
                f"poses cannot be held: change joint.{number}.range_deg, the moment arm, drive or spring, or the mass."
            )
        pole = robot.joint(number).pole or robot.controller.pole
        if check.pulls.size and pole < 0.95 * check.least_pole:
            said.append(
                f"joint {number}: with a pole of {pole:g} 1/s its position loop is softer than its own muscles "
                f"({check.stiffness:.3g} Nm/rad). Write joint.{number}.pole_1_s = {math.ceil(check.least_pole):g} or "
                f"more, if delays and the loops of coupled joints allow."
            )
    return said


# drive, valve, radius [m], contraction, largest range [deg]: the drives of the packaged arm, weakest first
GEARS = (("dmsp20", "mpye_small", 0.03, 0.07, 25.0), ("dmsp40", "mpye", 0.05, 0.11, 40.0))
ROOM = 0.5  # of what the muscles hold that gravity may take in a new file
LEAST_POLE, MOST_POLE = 6.0, 30.0  # [1/s]
HEAD = """\
# A robot for dehyst. Check it:      dehyst rig check {file}
# Run the experiment on it:          dehyst reproduce --robot {file} --quick
# Every number says where it comes from; "assumption" means that nobody measured it: measure it, and say so.
extends = "parts"    # muscles, valves, air, sensors, settings of the packaged arm; any of its keys may stand here
name = "{name}"
"""
BODY = """
[body]               # links, masses, bearings and gravity
file = "{body}"      # URDF or MJCF, beside this file; its joints that have no [joint.N] here stay locked
"""


def new_rig(file: Path, joints: int = 1, body: Path | None = None) -> str:
    """Return the text of a robot's file that works at once.

    Parameters
    ----------
    file
        Where it is going to stand.
    joints
        Of a chain, 1 to 12.
    body
        URDF or MJCF file whose hinges become the joints, 12 at most, instead of a chain.

    Examples
    --------
    >>> text = new_rig(Path("rig.toml"))
    >>> text.count("[joint."), "radius_m = 0.03" in text
    (1, True)
    """
    if not 1 <= joints <= 12:
        raise ParameterError(f"a chain of {joints} joints is none. Pass --joints 1 to 12.", joints=joints)
    place = None if body is None else Path(os.path.relpath(body, file.parent))
    hinges = [] if body is None else hinges_of(mujoco(), body)
    if body is not None and not 1 <= len(hinges) <= 12:
        raise ParameterError(
            f"'{body.name}' has {len(hinges)} hinges with names; a robot has 1 to 12 joints. Write [joint.N] for "
            f"those that count by hand: dehyst rig new {file.name}, and [body] in it.",
            joints=len(hinges),
        )
    count = len(hinges) or joints
    gears, poles, settled = [0] * count, [LEAST_POLE] * count, False
    while True:
        text = HEAD.format(file=file.name, name=file.stem)
        text += "" if place is None else BODY.format(body=place.as_posix())
        for k in range(count):
            own = _of_body(*hinges[k]) if hinges else _of_chain(k, count)
            text += f"\n[joint.{k + 1}]\n{own}{_drive(gears[k], poles[k], hinges[k][1:] if hinges else None)}"
        if settled:
            return "".join(map(_aligned, text.splitlines(keepends=True)))
        found = [*check_rig(robot_of(tomllib.loads(text), file.name, file.parent)).values()]
        weak = [k for k, check in enumerate(found) if check.load > ROOM * check.held]
        for k in weak:
            gears[k] += 1
        if not weak:  # a softer loop than the muscles shows the muscles, not the loop
            wanted = [math.ceil(1.1 * check.least_pole) if check.pulls.size else LEAST_POLE for check in found]
            poles, settled = [min(max(LEAST_POLE, pole), MOST_POLE) for pole in wanted], True


def _aligned(line: str) -> str:
    """Comments behind values begin in one column."""
    value, mark, comment = line.partition("# ")
    return f"{value.rstrip():<32}# {comment}" if value.strip() and mark else line


def _drive(gear: int, pole: float, limits: Sequence[float] | None) -> str:
    if gear == len(GEARS):
        free = 60.0 if limits is None else _half(limits)
        return f'drive = "electric"              # the packaged muscles are too weak for gravity here\n{_range(free)}'
    drive, valve, radius, contraction, reach = GEARS[gear]
    free = reach if limits is None else min(reach, _half(limits))
    return (
        f'drive = "{drive}"                # two of them pull against each other; assumption\n'
        f'valve = "{valve}"            # one a muscle; assumption\n'
        f"{_range(free)}"
        f"radius_m = {radius:g}                 # of the pulley; assumption\n"
        f"contraction = {contraction:g}              # of both muscles at zero; assumption\n"
        f"pole_1_s = {pole:g}                   # of the position loop: as stiff as the muscles; assumption\n"
    )


def _range(half: float) -> str:
    return f"range_deg = {half:.4g}                # to both sides of zero; assumption\n"


def _half(limits: Sequence[float]) -> float:
    return float(np.clip(math.degrees(limits[1] - limits[0]) / 2, 1.0, 120.0)) if limits[1] > limits[0] else 120.0


def _of_chain(k: int, count: int) -> str:
    axis = "pitch" if count < 3 or k % 3 else "yaw"
    first = axis == "pitch" and k == (0 if count < 3 else 1)
    return (
        f'axis = "{axis}"                 # yaw: about the vertical, pitch: about y, down is positive, roll: about x\n'
        f"zero_deg = {60.0 if first else 0.0:g}                  # of this link against the one before; assumption\n"
        "damping_Nm_s = 0.1            # bearings; assumption\n"
        "link_length_m = 0.25          # assumption\n"
        "link_radius_m = 0.02          # of a solid cylinder with round ends; assumption\n"
        "link_mass_kg = 0.5            # assumption\n"
    )


def _of_body(name: str, low: float, high: float) -> str:
    middle = math.degrees(low + high) / 2 if high > low else 0.0
    return (
        f'body_joint = "{name}"           # name of the joint in the body\'s file\n'
        f"zero_deg = {middle:.4g}                  # its angle there that is zero here: the middle of its range\n"
    )
