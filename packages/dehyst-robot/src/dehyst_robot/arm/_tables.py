"""Tables of a robot's parameter file as frozen dataclasses in SI: each field has a unit and a physical range.

`dehyst_robot.fields` says how a field is declared: ``supply`` in ``"bar"`` is the key ``supply_bar``. Fields that are 0
unless a file sets them are effects of real joints, as in realistic.toml; their formulas are in life.h and sensors.h of
packages/dehyst-robot/plant/.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any

from dehyst_robot.arm._mechanisms import PLANTS
from dehyst_robot.fields import Key
from dehyst_robot.muscles import muscle_names

Numbers = tuple[float, ...]
Share = Annotated[float, Key("", 0.0, 1.0)]
Scale = Annotated[float, Key("", 0.0, 100.0)]
SPRING = "spring"  # in the place of muscle 2


@dataclass(frozen=True)
class Air:
    """Supply, room and gas. ``supply`` is gauge, ``ambient`` absolute. [Pa]"""

    supply: Annotated[float, Key("bar", 1.0, 12.0)]
    ambient: Annotated[float, Key("bar", 0.3, 2.0)]
    temperature: Annotated[float, Key("K", 200.0, 400.0)]
    gas_constant: Annotated[float, Key("", 100.0, 5000.0)]
    polytropic: Annotated[float, Key("", 1.0, 1.7)]
    reference_density: Annotated[float, Key("", 0.1, 10.0)]
    # A supply that all joints share: with a volume it falls while muscles fill, and is fed through the conductance.
    supply_volume: Annotated[float, Key("l", 0.0, 1e4)] = 0.0
    supply_conductance: Annotated[float, Key("l_s_bar", 0.0, 1e4)] = 0.0


@dataclass(frozen=True)
class ForceMapTable:
    """Static force of a muscle; forms and order of the coefficients (SI) as in packages/dehyst-robot/plant/plant.h.

    ``force_of_length`` = (c_1, c_2, c_3), if given, replaces the first coefficient of the form "tool":
    F_m = p_ref c_1 atan(c_2 p_ref (l_0 - c_3)).
    """

    form: Annotated[str, Key(choices=("tool", "exponential", "geometric"))]
    coefficients: Annotated[Numbers, Key("", -1e9, 1e9, 6, 8)]
    force_of_length: Annotated[Numbers | None, Key("", 0.0, 1e3, 3, 3)]


@dataclass(frozen=True)
class Muscle:
    """One type of muscle. ``volume`` in powers of the contraction, lowest first, per length. [m^2]

    ``model``, one of `dehyst_robot.muscles.muscle_names`, gives the static force in the place of ``map``: with the
    values of a published ``set``, the first one if none is named, and of ``parameters``, names and SI units as of the
    model.
    """

    map: Annotated[str | None, Key()]
    length: Annotated[float, Key("m", 0.03, 9.0)]
    dead_volume: Annotated[float, Key("l", 0.0, 10.0)]
    volume: Annotated[Numbers, Key("l_per_m", -100.0, 100.0, 4, 4)]
    viscous_force: Annotated[float, Key("N", 0.0, 5000.0)]
    viscous_speed: Annotated[float, Key("m_s", 1e-4, 100.0)]
    creep_time: Annotated[Numbers, Key("s", 1e-3, 1e6, 0, 8)]
    creep_force: Annotated[Numbers, Key("N", 0.0, 1e5, 0, 8)]
    creep_pressure: Annotated[Numbers, Key("N_bar", 0.0, 1e4, 0, 8)]
    hysteresis: Annotated[float, Key("N", 0.0, 5000.0)]
    # A compliant tendon in series, and heat from the friction, which changes the stiffness.
    tendon: Annotated[float, Key("N_m", 0.0, 1e9)] = 0.0
    tendon_time: Annotated[float, Key("s", 0.0, 1.0)] = 0.0
    warming: Annotated[float, Key("K_W", 0.0, 1000.0)] = 0.0
    warming_time: Annotated[float, Key("s", 0.0, 1e5)] = 0.0
    warm_stiffness: Annotated[float, Key("1_K", -0.02, 0.02)] = 0.0
    model: Annotated[str | None, Key(choices=muscle_names())] = None
    set: Annotated[str | None, Key()] = None
    parameters: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Hysteresis:
    """The mechanism that all muscles share; ``scale`` multiplies their sizes, ``creep`` their creep."""

    mechanism: Annotated[str, Key(choices=PLANTS)]
    scale: Scale
    pressure_share: Share
    reference: Annotated[float, Key("bar", 0.1, 10.0)]
    asymmetry: Annotated[float, Key("", -0.5, 0.5)]
    creep: Scale
    # What real muscles add: strain scale that depends on pressure, uneven elements, friction that depends on warmth.
    pressure_strain: Annotated[float, Key("1_bar", -0.1, 0.1)] = 0.0
    scatter: Annotated[float, Key("", 0.0, 0.3)] = 0.0
    warm: Annotated[float, Key("1_K", -0.02, 0.02)] = 0.0


@dataclass(frozen=True)
class Tolerance:
    """Scatter between muscles of one type, rms, drawn by the seed."""

    hysteresis: Annotated[float, Key("", 0.0, 0.5)]
    force: Annotated[float, Key("", 0.0, 0.2)]
    shape: Annotated[float, Key("", 0.0, 0.2)] = 0.0
    contraction: Annotated[float, Key("", 0.0, 0.02)] = 0.0
    dead_band: Annotated[float, Key("", 0.0, 2.0)] = 0.0
    middle: Annotated[float, Key("", 0.0, 0.1)] = 0.0


@dataclass(frozen=True)
class Valve:
    """One way of a proportional valve, ISO 6358. ``conductance`` [m^3/(s Pa)], ``frequency`` [rad/s]."""

    conductance: Annotated[float, Key("l_s_bar", 0.01, 50.0)]
    ratio: Annotated[float, Key("", 0.0, 0.9)]
    dead_band: Annotated[float, Key("", 0.0, 0.5)]
    leak: Annotated[float, Key("", 0.0, 0.5)]
    frequency: Annotated[float, Key("Hz", 1.0, 1000.0)]
    damping: Annotated[float, Key("", 0.05, 10.0)]
    # Electronics in front of the valve, its own hysteresis, and the tube behind it.
    delay: Annotated[float, Key("s", 0.0, 0.1)] = 0.0
    bits: Annotated[int, Key("", 0, 32)] = 0
    hysteresis: Annotated[float, Key("", 0.0, 0.2)] = 0.0
    tube_length: Annotated[float, Key("m", 0.0, 10.0)] = 0.0
    tube_diameter: Annotated[float, Key("m", 0.0, 0.1)] = 0.0


@dataclass(frozen=True, kw_only=True)
class Sensors:
    """Encoders and pressure sensors."""

    encoder_bits: Annotated[int, Key("", 8, 32)]
    pressure_noise: Annotated[float, Key("bar", 0.0, 1.0)]
    pressure_lag: Annotated[float, Key("s", 0.0, 1.0)]
    # Sensors of a real joint answer late, and their zeros are off and drift.
    angle_delay: Annotated[float, Key("s", 0.0, 0.1)] = 0.0
    angle_jitter: Annotated[float, Key("s", 0.0, 0.1)] = 0.0
    angle_offset: Annotated[float, Key("deg", 0.0, 10.0)] = 0.0
    angle_drift: Annotated[float, Key("deg", 0.0, 10.0)] = 0.0
    angle_drift_time: Annotated[float, Key("s", 0.0, 1e6)] = 0.0
    pressure_delay: Annotated[float, Key("s", 0.0, 0.1)] = 0.0
    pressure_jitter: Annotated[float, Key("s", 0.0, 0.1)] = 0.0
    pressure_offset: Annotated[float, Key("bar", 0.0, 1.0)] = 0.0
    pressure_drift: Annotated[float, Key("bar", 0.0, 1.0)] = 0.0
    pressure_drift_time: Annotated[float, Key("s", 0.0, 1e6)] = 0.0


@dataclass(frozen=True)
class Base:
    """Where joint 1 stands."""

    height: Annotated[float, Key("m", 0.0, 10.0)]


@dataclass(frozen=True)
class Body:
    """Links of a model file (MJCF or URDF) instead of a chain.

    ``file`` is looked for in the folder of the robot's file. ``tool`` names the site that is the tool centre point. If
    it is None, the site called tool is the point; without such a site, the centre of mass of the last link.
    """

    file: Annotated[str, Key(most=400)]
    tool: Annotated[str | None, Key(most=200)]


@dataclass(frozen=True)
class Joint:
    """A joint and the link that hangs on it. Muscle joints have a valve, a routing and a contraction at zero.

    ``drive`` is "electric" or the type of both muscles, ``drives`` those of muscle 1 and 2; ``parallel`` such muscles
    lie side by side in the place of each and share its valve. In the place of muscle 2 there may be a "spring", which
    pulls with ``spring_preload`` at zero. What ``routing`` asks for stands in `dehyst_robot.arm._routing`.

    Of a [body], ``body_joint`` is the name there, its angle at ``zero`` is zero here, ``damping`` None is that of the
    file, and axis and link are the file's. ``pole``, if given, replaces that of the [controller] table for this joint.
    """

    # One of these two is needed.
    drive: Annotated[str | None, Key()]
    drives: tuple[str, str] | None
    # Links of a chain; those of a [body] are in its file.
    axis: Annotated[str | None, Key(choices=("yaw", "pitch", "roll"))]
    range: Annotated[float, Key("deg", 1.0, 175.0)]
    damping: Annotated[float | None, Key("Nm_s", 0.0, 1000.0)]
    link_length: Annotated[float | None, Key("m", 0.01, 5.0)]
    link_radius: Annotated[float | None, Key("m", 0.002, 1.0)]
    link_mass: Annotated[float | None, Key("kg", 0.01, 1000.0)]
    body_joint: Annotated[str | None, Key(most=200)]
    valve: Annotated[str | None, Key()]
    radius: Annotated[float | None, Key("m", 0.002, 1.0)]
    contraction: Annotated[float | None, Key("", 0.0, 0.25)]
    pole: Annotated[float | None, Key("1_s", 0.1, 200.0)]
    zero: Annotated[float, Key("deg", -720.0, 720.0)] = 0.0
    parallel: Annotated[int, Key("", 1, 12)] = 1
    routing: Annotated[str, Key(choices=("pulley", "lever", "polynomial", "tendon"))] = "pulley"
    # The keys of the routings; a joint has those of its own routing only.
    lever: Annotated[tuple[float, float] | None, Key("m", 0.002, 2.0)] = None
    lever_angle: Annotated[float | None, Key("deg", 1.0, 179.0)] = None
    moment_arm: Annotated[Numbers | None, Key("m", -100.0, 100.0, 1, 8)] = None
    moment_arm_2: Annotated[Numbers | None, Key("m", -100.0, 100.0, 1, 8)] = None
    tendons: Annotated[tuple[str, str] | None, Key(most=200)] = None
    # In the place of muscle 2.
    spring: Annotated[float, Key("N_m", 0.0, 1e7)] = 0.0
    spring_preload: Annotated[float, Key("N", 0.0, 1e6)] = 0.0
    # Half width of the play of the pulley on its shaft.
    backlash: Annotated[float, Key("deg", 0.0, 5.0)] = 0.0
    backlash_damping: Annotated[float, Key("Nm_s", 0.0, 100.0)] = 0.0

    @property
    def middle(self) -> float:
        """Contraction of both muscles at zero; nan for an electric joint."""
        return math.nan if self.contraction is None else self.contraction

    @property
    def pneumatic(self) -> bool:
        """Whether muscles drive the joint."""
        return self.drive != "electric"

    @property
    def driven(self) -> tuple[str, ...]:
        """Types of muscle 1 and 2; of an electric joint its drive alone."""
        return self.drives or ((self.drive or "",) * (1 + self.pneumatic))

    @property
    def sprung(self) -> bool:
        """Whether a spring is in the place of muscle 2."""
        return self.driven[-1] == SPRING


@dataclass(frozen=True)
class Electric:
    """Electric modules: position servos of their own with a double pole."""

    pole: Annotated[float, Key("1_s", 1.0, 500.0)]


@dataclass(frozen=True)
class Payload:
    """Point mass at the tool centre point."""

    mass: Annotated[float, Key("kg", 0.0, 100.0)]


@dataclass(frozen=True)
class Simulation:
    """Step of control and physics, and substeps of valves and chambers in it."""

    period: Annotated[float, Key("s", 1e-5, 0.01)]
    substeps: Annotated[int, Key("", 1, 1000)]
    command_delay: Annotated[float, Key("s", 0.0, 0.1)] = 0.0
    command_jitter: Annotated[float, Key("s", 0.0, 0.1)] = 0.0


@dataclass(frozen=True)
class ControllerTable:
    """The joint controllers. The three errors are shares by which their knowledge is wrong, on purpose."""

    mean_pressure: Annotated[float, Key("bar", 0.2, 10.0)]
    pole: Annotated[float, Key("1_s", 0.1, 200.0)]
    observer_pole: Annotated[float, Key("1_s", 0.1, 2000.0)]
    pressure_gain: Annotated[float, Key("1_s", 0.1, 2000.0)]
    windup_gain: Annotated[float, Key("1_s", 0.0, 2000.0)]
    # Errors on purpose: what a controller believes is never exact on a real robot.
    inertia_error: Annotated[float, Key("", -0.9, 4.0)]
    gravity_error: Annotated[float, Key("", -0.9, 4.0)]
    conductance_error: Annotated[float, Key("", -0.9, 4.0)]
    pressure_low: Annotated[float, Key("bar", 0.0, 10.0)]
    pressure_high: Annotated[float, Key("bar", 0.1, 10.0)]
    ramp: Annotated[float, Key("s", 0.0, 60.0)]
    # Fault detection: the largest credible steps, equal samples of a frozen sensor, faulty samples that are bridged.
    angle_jump: Annotated[float, Key("deg", 0.001, 360.0)]
    pressure_jump: Annotated[float, Key("bar", 0.001, 20.0)]
    frozen_samples: Annotated[int, Key("", 1, 1_000_000)]
    hold_samples: Annotated[int, Key("", 0, 1_000_000)]


@dataclass(frozen=True)
class CompensatorTable:
    """Identification of the compensator's model. ``shear`` k, [Pa/rad].

    ``joints`` are the numbers of those that get one; None: all that muscles drive.
    """

    joints: Annotated[tuple[int, ...] | None, Key("", 1, 12, 1, 12, distinct=True)]
    shear: Annotated[float, Key("bar_rad", 1e-3, 1000.0)]
    operators: Annotated[int, Key("", 1, 1000)]
    eps: Annotated[float, Key("", 0.0, 1.0)]


@dataclass(frozen=True)
class HomingTable:
    """Decaying cycles before every run, from ``range_share`` of the joint's range on."""

    range_share: Annotated[float, Key("", 0.0, 1.0)]
    decay: Annotated[float, Key("", 0.01, 0.99)]
    cycles: Annotated[int, Key("", 0, 1000)]
    period: Annotated[float, Key("s", 0.01, 1000.0)]


@dataclass(frozen=True)
class Calibration:
    """Quasi-static sweeps for the polynomials A, B, C."""

    mean_pressures: Annotated[Numbers, Key("bar", 0.2, 10.0, 2)]
    loads: Annotated[Numbers, Key("bar", -6.0, 6.0)]
    sweep: Annotated[float, Key("s", 0.1, 1e4)]
    range_share: Annotated[float, Key("", 0.05, 1.0)]
    degree: Annotated[int, Key("", 1, 7)]


@dataclass(frozen=True)
class Identification:
    """Loops of the angle for the hysteresis model.

    ``tips`` are shares of ``range_share`` of the joint's range, at which the strokes turn; the loops come twice, the
    second time ``second_share`` as large. For models that know time there are more: loops through ``rate_tips``, once
    for every pair of ``strokes`` and ``rests``; for those that know the mean pressure, the loops at ``mean_pressures``.
    """

    range_share: Annotated[float, Key("", 0.01, 1.0)]
    second_share: Annotated[float, Key("", 0.0, 1.0)]
    tips: Annotated[Numbers, Key("", -1.0, 1.0)]
    loop: Annotated[float, Key("s", 0.01, 1e4)]
    hold: Annotated[float, Key("s", 0.0, 1e4)]
    sample: Annotated[float, Key("s", 1e-4, 10.0)]
    rate_tips: Annotated[Numbers, Key("", -1.0, 1.0)]
    strokes: Annotated[Numbers, Key("s", 0.01, 1e4)]
    rests: Annotated[Numbers, Key("s", 0.0, 1e4)]
    mean_pressures: Annotated[Numbers, Key("bar", 0.0, 20.0)]


@dataclass(frozen=True)
class Path:
    """The ISO 9283 path. ``center`` of the test cube in the frame of the base's foot: x forward, y left, z up.

    ``acceleration`` and ``jerk`` are limits along the path; ``posture_weights`` resolve the redundancy, see kinematics.
    Without a ``center`` the joints move along a reference of their own; factor and cycles of the trials are the same.
    """

    cube: Annotated[float, Key("m", 0.005, 10.0)]
    center: Annotated[Numbers | None, Key("m", -20.0, 20.0, 3, 3)]
    fast_speed: Annotated[float, Key("m_s", 1e-3, 10.0)]
    slow_factor: Annotated[float, Key("", 1.0, 1000.0)]
    rest: Annotated[float, Key("s", 0.0, 1000.0)]
    acceleration: Annotated[float, Key("m_s2", 0.01, 100.0)]
    jerk: Annotated[float, Key("m_s3", 0.1, 1e5)]
    rounding: Annotated[float, Key("m", 1e-4, 5.0)]
    cycles_fast: Annotated[int, Key("", 1, 1000)]
    cycles_slow: Annotated[int, Key("", 1, 1000)]
    posture_weights: Annotated[Numbers | None, Key("", 1e-3, 1e6, 1, 12)]


@dataclass(frozen=True)
class Drawn:
    """Motion of the joints in the place of a path of the tool: moves to drawn targets, or those of a ``file``.

    ``moves`` targets in ``range_share`` of the ranges; a move takes ``move``, longer where valves need it; a file is
    looked for beside that of the robot.
    """

    file: Annotated[str | None, Key(most=400)] = None
    moves: Annotated[int, Key("", 1, 1000)] = 8
    move: Annotated[float, Key("s", 0.01, 1000.0)] = 2.5
    range_share: Annotated[float, Key("", 0.01, 1.0)] = 0.6
    seed: Annotated[int, Key("", 0, 2**32 - 1)] = 0


@dataclass(frozen=True, eq=False)
class Tables:
    """A robot's parameter file: its name, its tables, and its tables by name."""

    name: Annotated[str, Key(most=200)]
    air: Air
    hysteresis: Hysteresis
    tolerance: Tolerance
    sensors: Sensors
    base: Base
    body: Body | None
    electric: Electric
    payload: Payload
    simulation: Simulation
    controller: ControllerTable
    compensator: CompensatorTable
    homing: HomingTable
    calibration: Calibration
    identification: Identification
    path: Path
    reference: Drawn | None
    maps: Annotated[Mapping[str, ForceMapTable], Key(name="map")]
    muscles: Annotated[Mapping[str, Muscle], Key(name="muscle")]
    valves: Annotated[Mapping[str, Valve], Key(name="valve")]
    joints: Annotated[Mapping[int, Joint], Key(name="joint", most=12)]
