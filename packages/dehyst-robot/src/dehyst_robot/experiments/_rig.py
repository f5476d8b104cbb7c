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
from dehyst_robot.arm import (
    Hinges,
    Robot,
    arm_model,
    bias_torque,
    load_robot,
    mujoco,
    pneumatic_joint_parameters,
    robot_of,
)
from dehyst_robot.arm import kit as arm_kit
from dehyst_robot.experiments._gains import SLOWEST, steady_pole
from dehyst_robot.experiments._policy import POLICY

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
        if not self.pulls.size:
            return math.inf
        return float(min(self.pulls[-1].min(), self.back[-1].min()))

    @property
    def load(self) -> float:
        """Largest torque that gravity takes, either way. [Nm]"""
        return max(map(abs, self.gravity))

    @property
    def holds(self) -> bool:
        """Whether the muscles hold the joint against gravity in all poses, at 6 bar."""
        low, high = self.gravity
        return not self.pulls.size or bool(
            high <= self.pulls[-1].min() and -low <= self.back[-1].min()
        )

    @property
    def least_pole(self) -> float:
        """Pole of a position loop as stiff as the muscles, 3 pole^2 M = k: below, the joint's own springs win. [1/s]"""
        return math.sqrt(max(self.stiffness, 0.0) / (3 * self.inertia))


def check_rig(robot: Robot) -> dict[int, JointCheck]:
    """Return what each joint can do, from muscles without hysteresis, creep and scatter.

    Examples
    --------
    >>> from dehyst_robot.arm import load_robot
    >>> found = check_rig(load_robot())[1]
    >>> round(found.stiffness), round(found.pulls[2, 20]), round(found.frequency, 1)
    (175, 58, 1.3)
    """
    model, plain = arm_model(robot), robot.with_changes(PLAIN)
    reach = np.array([joint.range for joint in robot.joints.values()])
    gravity = bias_torque(
        model, np.random.default_rng(0).uniform(-reach, reach, (POSES, reach.size))
    )
    inertia = arm_kit.joint_inertia(model)
    checks = {}
    for k, (number, joint) in enumerate(robot.joints.items()):
        angle = np.linspace(-joint.range, joint.range, PLACES)
        pulls = back = np.empty((0, PLACES))
        stiffness = math.nan
        if joint.pneumatic:
            physics = pneumatic_joint_parameters(plain, number, 0)
            low, mean = robot.controller.pressure_low, robot.controller.mean_pressure

            def torque(
                first: float, second: float, physics: dict[str, object] = physics, q: Array = angle
            ) -> Array:
                both = np.broadcast_to([first, second], (q.size, 2))
                return arm_kit.run_pressures(physics, q, both, SLOWLY).torque

            pulls = np.stack([torque(pressure, low) for pressure in PRESSURES])
            back = -np.stack([torque(low, pressure) for pressure in PRESSURES])
            middle = torque(mean, mean)[PLACES // 2 - 1 : PLACES // 2 + 2]
            stiffness = float((middle[0] - middle[2]) / (2 * (angle[1] - angle[0])))
        ends = float(gravity[:, k].min()), float(gravity[:, k].max())
        checks[number] = JointCheck(angle, pulls, back, ends, float(inertia[k]), stiffness)
    return checks


def cautions(robot: Robot, checks: dict[int, JointCheck]) -> list[str]:
    """Return sentences on joints that cannot work as they are, with the numbers and the keys to change."""
    sentences = []
    for number, check in checks.items():
        if not check.holds:
            sentences.append(
                f"joint {number}: gravity takes {check.gravity[0]:.3g} .. {check.gravity[1]:.3g} Nm, and at the worst "
                f"angle the joint gives {-check.back[-1].min():.3g} .. {check.pulls[-1].min():.3g} Nm at 6 bar. Some "
                f"poses cannot be held: change joint.{number}.range_deg, the moment arm, drive or spring, or the mass."
            )
    return [*sentences, *_of_poles(robot, checks)]


def _of_poles(robot: Robot, checks: dict[int, JointCheck]) -> list[str]:
    """Sentences on position loops: too fast for all joints together, else softer than the muscles for no need."""
    # A joint without a pole of its own has the controller's.
    poles = {n: robot.joint(n).pole or robot.controller.pole for n in robot.pneumatic}
    most = steady_pole(robot)
    if most < math.inf:
        cure = "Add bearing damping, make pulleys larger or delays smaller"
        if most > 0:
            fast = [f"joint.{n}.pole_1_s" for n, pole in poles.items() if pole > most]
            cure = f"Write {' = '.join(fast)} = {math.floor(10 * most) / 10:g} or less"
        return [
            f"the joints swing when they move together with twice their gain or with commands "
            f"{1e3 * POLICY.delay_margin_s:g} ms later: runs may end with a joint out of its range. {cure}."
        ]
    soft = {}
    for n, pole in poles.items():
        if pole < 0.95 * checks[n].least_pole:
            soft[n] = math.ceil(checks[n].least_pole)
    # Where stiffer loops would swing together, they have to be as soft as they are.
    if not soft or steady_pole(robot, soft) < math.inf:
        return []
    sentences = []
    for n, least in soft.items():
        sentences.append(
            f"joint {n}: with a pole of {poles[n]:g} 1/s its position loop is softer than its own muscles "
            f"({checks[n].stiffness:.3g} Nm/rad). Write joint.{n}.pole_1_s = {least:g} or more."
        )
    return sentences


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


GEARS = (
    Gear("dmsp20", "mpye_small", 0.07, 0.0524, 25.0),
    Gear("dmsp40", "mpye", 0.11, 0.0873, 40.0),
)  # weakest first
SHRUNK = 0.7  # of a range that neither type of muscle holds, to the next that is tried
LEAST_REACH, MOST_REACH = 15.0, 120.0  # [deg]
LEAST_RADIUS, MOST_RADIUS = 0.002, 0.06  # [m]
LEAST_POLE, MOST_POLE = 6.0, 30.0  # [1/s]
LEAST_DAMPING = 0.01  # of bearings [Nm s/rad]
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
class _GearChoice:
    """What a new file gives a joint: one of the `ranges` [deg] with one of the gears, or none of them."""

    ranges: list[float | None]
    number: int = 0
    most: float = MOST_RADIUS
    damping: float = 0.1
    pole: float = LEAST_POLE
    why: str = ""

    @property
    def gear(self) -> Gear | None:
        if self.why:
            return None
        return GEARS[self.number % len(GEARS)]

    @property
    def reach(self) -> float:
        reach = self.ranges[min(self.number // len(GEARS), len(self.ranges) - 1)]
        if reach:
            return reach
        if self.gear is None:
            return POLICY.electric_reach
        return self.gear.reach

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
        raise ParameterError(
            f"a chain of {joints} joints is none. Pass --joints 1 to 12.", joints=joints
        )
    hinges, body_lines = Hinges((), ()), ""
    if body is not None:
        hinges = arm_kit.hinges_of(mujoco(), body)
        beside = Path(os.path.relpath(body, file.parent))
        body_lines = BODY.format(body=_quoted(beside.as_posix()))
    if body is not None and not hinges.free:
        raise ParameterError(
            f"'{body.name}' has no hinge that a muscle could move: {'; '.join(hinges.locked) or 'no joints at all'}. "
            f"Give it a hinge with a name of its own.",
            locked=hinges.locked,
        )
    choices, links = [], []
    for hinge, low, high in hinges.free:
        choices.append(_GearChoice(_ranges(low, high)))
        links.append(_of_body(hinge, low, high))
    if body is None:
        for k in range(joints):
            choices.append(_GearChoice([None]))
            links.append(_of_chain(k, joints))
    if hinges.locked:
        body_lines += f"# Locked there: {'; '.join(hinges.locked)}.\n"
    settled = False
    while True:
        # Written again until no choice changes.
        text = HEAD.format(file=file.name, name=_quoted(file.stem), gain=PRESSURE_GAIN)
        text += body_lines
        for k, choice in enumerate(choices):
            text += f"\n[joint.{k + 1}]\n{links[k]}{_drive(choice)}"
        robot = robot_of(tomllib.loads(text), file.name, file.parent, conditions="realistic")
        if settled:
            return "".join(map(_aligned, text.splitlines(keepends=True)))
        settled = _settled(robot, choices)


def _settled(robot: Robot, choices: list[_GearChoice]) -> bool:
    """Change what was chosen, or only its dampings and poles, which come last; return whether it was these."""
    checks = [*check_rig(robot).values()]
    changed = False
    for number, (choice, check) in enumerate(zip(choices, checks, strict=True), 1):
        if choice.gear is None:
            continue
        if check.load > POLICY.gravity_share * check.held:
            choice.stronger()
            changed = True
        elif check.least_pole > MOST_POLE:
            choice.softer(robot.joint(number).radius or 0.0, MOST_POLE / check.least_pole)
            changed = True
    if changed:
        return False
    dampings, poles = {}, {}
    for n in robot.pneumatic:
        choice, check = choices[n - 1], checks[n - 1]
        # A position loop that is softer than the muscles shows the muscles.
        choice.pole = min(max(LEAST_POLE, math.ceil(1.1 * check.least_pole)), MOST_POLE)
        # Damping at which the joint, on its muscles' stiffness, would not swing.
        critical = 2 * math.sqrt(check.stiffness * check.inertia)
        choice.damping = float(f"{max(LEAST_DAMPING, POLICY.damped * critical):.2g}")
        dampings[f"joint.{n}.damping_Nm_s"] = choice.damping
        poles[n] = choice.pole
    # Loops that are fine alone may swing together.
    most = steady_pole(robot.with_changes(dampings), poles) or SLOWEST
    if most < math.inf:
        most = math.floor(10 * most) / 10
    for n in robot.pneumatic:
        choices[n - 1].pole = min(choices[n - 1].pole, most)
    return True


def _ranges(low: float, high: float) -> list[float | None]:
    """Ranges to both sides of the middle that a joint with these limits [rad] may get, largest first. [deg]"""
    if not high > low:
        return [None]
    ranges = [min(max(math.degrees(high - low) / 2, 1.0), MOST_REACH)]
    while SHRUNK * ranges[-1] >= LEAST_REACH:
        ranges.append(SHRUNK * ranges[-1])
    return [*ranges]


def _quoted(text: str) -> str:
    """As a string of TOML."""
    return json.dumps(text, ensure_ascii=False)


def _aligned(line: str) -> str:
    """Comments behind values begin in one column."""
    value, mark, comment = line.partition("# ")
    if not mark or not value.strip():
        return line
    return f"{value.rstrip():<32}# {comment}"


def _drive(choice: _GearChoice) -> str:
    reach = f"range_deg = {choice.reach:.4g}                # to both sides of zero; assumption\n"
    if choice.gear is None:
        return f'drive = "electric"              # {choice.why}\ndamping_Nm_s = 0.1 # of bearings; assumption\n{reach}'
    length = load_robot().muscle(choice.gear.drive).length
    return (
        f'drive = "{choice.gear.drive}"                # two of them pull against each other; assumption\n'
        f'valve = "{choice.gear.valve}"            # one a muscle; assumption\n'
        f"{reach}"
        f"radius_m = {choice.radius(length):g}                 # of the pulley; assumption\n"
        f"damping_Nm_s = {choice.damping:g}            # of bearings and muscles: {100 * POLICY.damped:g} % of "
        "critical; assumption\n"
        f"contraction = {choice.gear.contraction:g}              # of both muscles at zero; assumption\n"
        f"pole_1_s = {choice.pole:g}                   # of the position loop: as stiff as the muscles if all together "
        "stand it; assumption\n"
    )


def _of_chain(k: int, count: int) -> str:
    # Every third axis of a longer chain, from the first on, is vertical; the first link that pitches hangs.
    axis, zero = "pitch", 0.0
    if count >= 3 and k % 3 == 0:
        axis = "yaw"
    if (count < 3 and k == 0) or (count >= 3 and k == 1):
        zero = 60.0
    return (
        f'axis = "{axis}"                 # yaw: about the vertical, pitch: about y, down is positive, roll: about x\n'
        f"zero_deg = {zero:g}                  # of this link against the one before; assumption\n"
        "link_length_m = 0.25          # assumption\n"
        "link_radius_m = 0.02          # of a solid cylinder with round ends; assumption\n"
        "link_mass_kg = 0.5            # assumption\n"
    )


def _of_body(name: str, low: float, high: float) -> str:
    middle = 0.0
    if high > low:
        middle = math.degrees(low + high) / 2
    return (
        f"body_joint = {_quoted(name)}           # name of the joint in the body's file\n"
        f"zero_deg = {middle:.4g}                  # its angle there that is zero here: the middle of its range\n"
    )
