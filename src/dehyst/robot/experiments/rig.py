"""Makes the file of a robot of one's own, and tells what a robot can do before anything is run on it."""

from __future__ import annotations

import json
import math
import os
import tomllib
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from dehyst.arrays import Array
from dehyst.errors import ParameterError
from dehyst.robot.arm.body import Hinges, hinges_of
from dehyst.robot.arm.joints import pneumatic_joint_parameters, run_pressures
from dehyst.robot.arm.parameters import Robot, load_robot, robot_of
from dehyst.robot.arm.rigid_body import arm_model, bias_torque, joint_inertia, mujoco
from dehyst.robot.experiments.gains import DELAY_S, SLOWEST, steady_pole

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
    (175, 58, 1.3)
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
    return [*said, *_of_poles(robot, found)]


def _of_poles(robot: Robot, found: dict[int, JointCheck]) -> list[str]:
    """Sentences on position loops: too fast for all joints together, else softer than the muscles for no need."""
    poles = {n: robot.joint(n).pole or robot.controller.pole for n in robot.pneumatic}
    if (most := steady_pole(robot)) < math.inf:
        fast = [f"joint.{n}.pole_1_s" for n, pole in poles.items() if pole > most]
        cure = "Add bearing damping, make pulleys larger or delays smaller"
        if most > 0:
            cure = f"Write {' = '.join(fast)} = {math.floor(10 * most) / 10:g} or less"
        return [
            f"the joints swing when they move together with twice their gain or with commands {1e3 * DELAY_S:g} ms "
            f"later: runs may end with a joint out of its range. {cure}."
        ]
    soft = {n: math.ceil(found[n].least_pole) for n, pole in poles.items() if pole < 0.95 * found[n].least_pole}
    if not soft or steady_pole(robot, soft) < math.inf:  # slower than that they have to be
        return []
    return [
        f"joint {n}: with a pole of {poles[n]:g} 1/s its position loop is softer than its own muscles "
        f"({found[n].stiffness:.3g} Nm/rad). Write joint.{n}.pole_1_s = {least:g} or more."
        for n, least in soft.items()
    ]


@dataclass(frozen=True)
class Gear:
    """Two equal muscles that a new file may give a joint, with their valve.

    From zero to an end of the range they shorten by `stroke`; `reach` is the range if nothing else is said. [1], [deg]
    """

    drive: str
    valve: str
    contraction: float
    stroke: float
    reach: float


GEARS = (Gear("dmsp20", "mpye_small", 0.07, 0.0524, 25.0), Gear("dmsp40", "mpye", 0.11, 0.0873, 40.0))  # weakest first
SHRUNK = 0.7  # of a range that neither type of muscle holds, to the next that is tried
LEAST_REACH, MOST_REACH = 15.0, 120.0  # [deg]
LEAST_RADIUS, MOST_RADIUS = 0.002, 0.06  # [m]
ROOM = 0.5  # of what the muscles hold that gravity may take in a new file
LEAST_POLE, MOST_POLE = 6.0, 30.0  # [1/s]
DAMPED = 0.5  # of critical damping by the stiffness of the muscles, where the body's file has less
HEAD = """\
# A robot for dehyst. Check it:      dehyst rig check {file}
# Run the experiment on it:          dehyst reproduce --robot {file} --quick
# Every number says where it comes from; "assumption" means that nobody measured it: measure it, and say so.
extends = "parts"    # muscles, valves, air, sensors, settings of the packaged arm; any of its keys may stand here
name = {name}

[controller]
pressure_gain_1_s = {gain:g} # of the pressure loops: leaves room for the small chambers' delays; assumption
"""
PRESSURE_GAIN = 30.0
BODY = """
[body]               # links, masses, bearings and gravity
file = {body}      # URDF or MJCF, beside this file; its joints that have no [joint.N] here stay locked
"""


@dataclass
class _Choice:
    """What a new file gives a joint: one of the `ranges` [deg] with one of the gears, or none of them."""

    ranges: list[float | None]
    number: int = 0
    most: float = MOST_RADIUS
    damping: float = 0.1
    pole: float = LEAST_POLE
    why: str = ""

    @property
    def gear(self) -> Gear | None:
        return None if self.why else GEARS[self.number % len(GEARS)]

    @property
    def reach(self) -> float:
        told = self.ranges[min(self.number // len(GEARS), len(self.ranges) - 1)]
        return told or (60.0 if self.gear is None else self.gear.reach)

    def radius(self, length: float) -> float:
        """So that the muscle makes its stroke over the range. [m]"""
        assert self.gear is not None
        return min(float(f"{self.gear.stroke * length / math.radians(self.reach):.2g}"), self.most)

    def stronger(self) -> None:
        self.number += 1
        if self.number == len(GEARS) * len(self.ranges):
            self.number, self.why = 0, "the packaged muscles are too weak for gravity here"

    def softer(self, radius: float, factor: float) -> None:
        self.most = float(f"{0.9 * radius * factor:.2g}")  # smaller, whatever the rounding
        if self.most < LEAST_RADIUS:
            self.number, self.why = 0, "the packaged muscles are too stiff for this small inertia"


def new_rig(file: Path, joints: int = 1, body: Path | None = None) -> str:
    """Return the text of a robot's file that works at once.

    The muscles of a joint are the smallest of the packaged ones that hold twice what gravity takes anywhere. From zero
    to an end of the range, that of the body's file, they shorten by 5 (dmsp20) or 9 % (dmsp40) of their length, which
    sets the radius of the pulley; where they would be too weak, the range is smaller, where they would be too stiff for
    the joint's inertia, the radius. Joints that no muscle suits are electric. The position loops are as stiff as the
    muscles, 6 to 30 1/s, and none is faster than `steady_pole` on the realistic plant. Bearings and muscles damp half
    as much as would be critical with the muscles' stiffness.

    Parameters
    ----------
    file
        Where it is going to stand.
    joints
        Of a chain, 1 to 12.
    body
        URDF or MJCF file whose hinges become the joints, the first 12 at most, instead of a chain.

    Examples
    --------
    >>> text = new_rig(Path("rig.toml"))
    >>> text.count("[joint."), "radius_m = 0.03" in text
    (1, True)
    """
    if not 1 <= joints <= 12:
        raise ParameterError(f"a chain of {joints} joints is none. Pass --joints 1 to 12.", joints=joints)
    place = None if body is None else Path(os.path.relpath(body, file.parent))
    hinges = Hinges((), ()) if body is None else hinges_of(mujoco(), body)
    if body is not None and not hinges.free:
        raise ParameterError(
            f"'{body.name}' has no hinge that a muscle could move: {'; '.join(hinges.locked) or 'no joints at all'}. "
            f"Give it a hinge with a name of its own.",
            locked=hinges.locked,
        )
    chosen = [_Choice(_ranges(low, high)) for _, low, high in hinges.free] or [_Choice([None]) for _ in range(joints)]
    settled = False
    while True:
        text = HEAD.format(file=file.name, name=_quoted(file.stem), gain=PRESSURE_GAIN)
        text += "" if place is None else BODY.format(body=_quoted(place.as_posix()))
        text += f"# Locked there: {'; '.join(hinges.locked)}.\n" if hinges.locked else ""
        for k, choice in enumerate(chosen):
            own = _of_body(*hinges.free[k]) if hinges.free else _of_chain(k, len(chosen))
            text += f"\n[joint.{k + 1}]\n{own}{_drive(choice)}"
        robot = robot_of(tomllib.loads(text), file.name, file.parent, conditions="realistic")
        if settled:
            return "".join(map(_aligned, text.splitlines(keepends=True)))
        settled = _settled(robot, chosen)


def _settled(robot: Robot, chosen: list[_Choice]) -> bool:
    """Change what was chosen, or only its dampings and poles, which come last; return whether it was these."""
    found, changed = [*check_rig(robot).values()], False
    for number, (choice, check) in enumerate(zip(chosen, found, strict=True), 1):
        if choice.gear is None:
            continue
        if check.load > ROOM * check.held:
            choice.stronger()
        elif check.least_pole > MOST_POLE:
            choice.softer(robot.joint(number).radius or 0.0, MOST_POLE / check.least_pole)
        else:
            continue
        changed = True
    if changed:
        return False
    driven = {n: (chosen[n - 1], found[n - 1]) for n in robot.pneumatic}
    for choice, check in driven.values():  # a softer loop than the muscles shows the muscles
        choice.pole = min(max(LEAST_POLE, math.ceil(1.1 * check.least_pole)), MOST_POLE)
        choice.damping = float(f"{max(0.1, 2 * DAMPED * math.sqrt(check.stiffness * check.inertia)):.2g}")
    damped = robot.with_changes({f"joint.{n}.damping_Nm_s": choice.damping for n, (choice, _) in driven.items()})
    most = steady_pole(damped, {n: choice.pole for n, (choice, _) in driven.items()}) or SLOWEST
    for choice, _ in driven.values():
        choice.pole = min(choice.pole, math.floor(10 * most) / 10 if most < math.inf else most)
    return True


def _ranges(low: float, high: float) -> list[float | None]:
    """Ranges to both sides of the middle that a joint with these limits [rad] may get, largest first. [deg]"""
    if not high > low:
        return [None]
    found = [min(max(math.degrees(high - low) / 2, 1.0), MOST_REACH)]
    while SHRUNK * found[-1] >= LEAST_REACH:
        found.append(SHRUNK * found[-1])
    return [*found]


def _quoted(text: str) -> str:
    """As a string of TOML."""
    return json.dumps(text, ensure_ascii=False)


def _aligned(line: str) -> str:
    """Comments behind values begin in one column."""
    value, mark, comment = line.partition("# ")
    return f"{value.rstrip():<32}# {comment}" if value.strip() and mark else line


def _drive(choice: _Choice) -> str:
    reach = f"range_deg = {choice.reach:.4g}                # to both sides of zero; assumption\n"
    if choice.gear is None:
        return f'drive = "electric"              # {choice.why}\ndamping_Nm_s = 0.1 # of bearings; assumption\n{reach}'
    length = load_robot().muscle(choice.gear.drive).length
    return (
        f'drive = "{choice.gear.drive}"                # two of them pull against each other; assumption\n'
        f'valve = "{choice.gear.valve}"            # one a muscle; assumption\n'
        f"{reach}"
        f"radius_m = {choice.radius(length):g}                 # of the pulley; assumption\n"
        f"damping_Nm_s = {choice.damping:g}            # of bearings and muscles: half of critical; assumption\n"
        f"contraction = {choice.gear.contraction:g}              # of both muscles at zero; assumption\n"
        f"pole_1_s = {choice.pole:g}                   # of the position loop: as stiff as the muscles if all together "
        "stand it; assumption\n"
    )


def _of_chain(k: int, count: int) -> str:
    axis = "pitch" if count < 3 or k % 3 else "yaw"
    first = axis == "pitch" and k == (0 if count < 3 else 1)
    return (
        f'axis = "{axis}"                 # yaw: about the vertical, pitch: about y, down is positive, roll: about x\n'
        f"zero_deg = {60.0 if first else 0.0:g}                  # of this link against the one before; assumption\n"
        "link_length_m = 0.25          # assumption\n"
        "link_radius_m = 0.02          # of a solid cylinder with round ends; assumption\n"
        "link_mass_kg = 0.5            # assumption\n"
    )


def _of_body(name: str, low: float, high: float) -> str:
    middle = math.degrees(low + high) / 2 if high > low else 0.0
    return (
        f"body_joint = {_quoted(name)}           # name of the joint in the body's file\n"
        f"zero_deg = {middle:.4g}                  # its angle there that is zero here: the middle of its range\n"
    )
