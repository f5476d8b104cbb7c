"""Values of a robot that are possible one by one, but not together."""

from __future__ import annotations

from typing import TYPE_CHECKING

from dehyst.errors import ParameterError
from dehyst.plant.validation import closest, refuse

if TYPE_CHECKING:
    from dehyst.plant.parameters import Robot

# Muscles are pretensioned by at most 5 % and contract by at most 25 %: catalogue of the DMSP.
LEAST_CONTRACTION, MOST_CONTRACTION = -0.05, 0.30
COEFFICIENTS = {"tool": 6, "exponential": 6, "geometric": 8}


def refuse_contradictions(robot: Robot, source: str) -> None:
    """Check names that refer to other tables, and values against each other.

    Raises
    ------
    ParameterError
        With both values and the way out.
    """
    for name, law in robot.maps.items():
        wanted = COEFFICIENTS[law.form]
        if len(law.coefficients) != wanted:
            raise refuse(
                f"has not the {wanted} coefficients of the form {law.form!r}.",
                f"map.{name}.coefficients",
                law.coefficients,
                source,
            )
    for name, muscle in robot.muscles.items():
        _known(muscle.map, list(robot.maps), f"muscle.{name}.map", source)
        counts = {len(muscle.creep_time), len(muscle.creep_force), len(muscle.creep_pressure)}
        if len(counts) > 1:
            raise refuse(
                f"and creep_force_N and creep_pressure_N_bar have {sorted(counts)} numbers: one of each a branch of "
                f"creep. For no creep type hysteresis.creep = 0.",
                f"muscle.{name}.creep_time_s", muscle.creep_time, source,
            )  # fmt: skip
    for number in robot.joints:
        _check_joint(robot, number, source)
    _check_pressures(robot, source)
    if 2 * robot.path.rounding >= 0.8 * robot.path.cube:
        raise refuse(
            f"rounds more than the rectangle's short side of 0.8 x {robot.path.cube:g} m holds; below "
            f"{0.4 * robot.path.cube:.4g} m.",
            "path.rounding_m", robot.path.rounding, source,
        )  # fmt: skip


def _known(word: str, names: list[str], key: str, source: str) -> None:
    if word not in names:
        raise refuse(f"is not in the file{closest(word, names)}. It has {', '.join(names)}.", key, word, source)


def _check_joint(robot: Robot, number: int, source: str) -> None:
    joint = robot.joints[number]
    where = f"joint.{number}"
    _known(joint.drive, ["electric", *robot.muscles], f"{where}.drive", source)
    if not joint.pneumatic:
        return
    lacking = [key for key, value in (("valve", joint.valve), ("radius_m", joint.radius),
                                      ("contraction", joint.contraction)) if value is None]  # fmt: skip
    if lacking:
        raise ParameterError(
            f"{source}: {where} is driven by muscles and lacks {', '.join(lacking)}. Add them, or set {where}.drive = "
            f'"electric".',
            key=where,
            missing=lacking,
        )
    assert joint.valve is not None
    assert joint.radius is not None
    assert joint.contraction is not None
    _known(joint.valve, list(robot.valves), f"{where}.valve", source)
    stroke = joint.radius * joint.range / robot.muscles[joint.drive].length
    low, high = joint.contraction - stroke, joint.contraction + stroke
    if low < LEAST_CONTRACTION or high > MOST_CONTRACTION:
        raise ParameterError(
            f"{source}: at the ends of the range of {where} its muscles contract by {low:.3f} and {high:.3f} of their "
            f"length, possible are {LEAST_CONTRACTION:g} .. {MOST_CONTRACTION:g}. Make {where}.range_deg or radius_m "
            f"smaller, the muscle longer, or put contraction in the middle.",
            key=where,
            low=low,
            high=high,
        )


def _check_pressures(robot: Robot, source: str) -> None:
    c, supply = robot.controller, robot.air.supply
    if not c.pressure_low < c.mean_pressure < c.pressure_high:
        raise refuse(
            f"is not between pressure_low_bar = {c.pressure_low / 1e5:g} and pressure_high_bar = "
            f"{c.pressure_high / 1e5:g}.",
            "controller.mean_pressure_bar", c.mean_pressure / 1e5, source,
        )  # fmt: skip
    if c.pressure_high >= supply:
        raise refuse(
            f"is not below the supply, air.supply_bar = {supply / 1e5:g}: nothing would flow.",
            "controller.pressure_high_bar", c.pressure_high / 1e5, source,
        )  # fmt: skip
