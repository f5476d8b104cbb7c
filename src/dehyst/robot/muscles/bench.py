"""Simulated test bench for muscle models: the same experiments on every model.

Static forces, isobaric and isotonic loops, quick release, force over speed: so that two models, or a model and a log,
can be laid side by side.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.errors import DehystError, ParameterError
from dehyst.robot.muscles.base import MuscleModel
from dehyst.robot.muscles.experiments import (
    SHARES,
    ForceMap,
    ForceVelocity,
    Loop,
    Release,
    force_map,
    force_velocity,
    free_contraction,
    isobaric_loop,
    isotonic_loop,
    lowest_pressure,
    quick_release,
    reach,
)

LOADS = (0.1, 0.25, 0.5)  # of the largest force: loads of the isotonic loops
SPEED_AT = 0.2  # of the free contraction: where the force over speed is read

Result = TypeVar("Result")


@dataclass(frozen=True, eq=False)
class Bench:
    """Everything that a model showed on the bench.

    Attributes
    ----------
    model
        Which was on it.
    forces
        Static map.
    isobaric
        Loops of force over contraction, one a pressure.
    isotonic
        Loops of contraction over pressure, one a load.
    releases
        From contraction 0, at the middle one of the pressures.
    velocity
        Force over speed of shortening there, or None.
    skipped
        Which experiments could not be run, and why.
    """

    model: MuscleModel
    forces: ForceMap
    isobaric: tuple[Loop, ...]
    isotonic: tuple[Loop, ...]
    releases: tuple[Release, ...]
    velocity: ForceVelocity | None
    skipped: tuple[str, ...]

    def as_dict(self) -> dict[str, Any]:
        """Return figures and map as plain values, without the samples of loops and motions."""
        found = self.forces
        return {
            "model": self.model.name,
            "length_m": self.model.length,
            "parameters": self.model.as_dict(),
            "force_map": {
                "contraction": found.contraction.tolist(),
                "pressure_Pa": found.pressure.tolist(),
                "force_N": found.force.tolist(),
                "blocked_N": found.blocked.tolist(),
                "free_contraction": [_or_none(each) for each in found.free.tolist()],
                "stiffness_N_m": found.stiffness.tolist(),
            },
            "isobaric": [_loop_figures(loop, "pressure_Pa", "contraction", "force_N") for loop in self.isobaric],
            "isotonic": [_loop_figures(loop, "load_N", "pressure_Pa", "contraction") for loop in self.isotonic],
            "releases": [
                {
                    "load_N": each.load,
                    "mass_kg": each.mass,
                    "peak_speed_m_s": each.peak_speed,
                    "peak_contraction": each.peak_contraction,
                }
                for each in self.releases
            ],
            "force_velocity": None if self.velocity is None else self.velocity.as_dict(),
            "skipped": list(self.skipped),
        }


def run_bench(
    model: MuscleModel, contraction: npt.ArrayLike, pressure: npt.ArrayLike, loads: npt.ArrayLike | None = None
) -> Bench:
    """Return what a model shows in every experiment; what cannot be run is left out and said.

    Parameters
    ----------
    model
        Any muscle model.
    contraction, pressure
        Of the map; loops are run at the same pressures. [1], [Pa]
    loads
        Of the isotonic loops; by default 10, 25 and 50 % of the largest force. [N]

    Raises
    ------
    ParameterError
        If a contraction or a pressure is not finite, or outside the model's limits.

    Examples
    --------
    >>> from dehyst.robot.muscles import muscle
    >>> bench = run_bench(muscle("tondu-lopez"), [0.0, 0.1], [2e5, 4e5])
    >>> len(bench.isobaric), len(bench.isotonic), len(bench.releases), bench.skipped
    (2, 3, 4, ())
    """
    forces = force_map(model, contraction, pressure)
    skipped: list[str] = []
    pressures = np.unique(forces.pressure[forces.pressure > 0])
    if not pressures.size:
        return Bench(model, forces, (), (), (), None, ("everything that moves: no pressure is above zero",))
    top, middle = float(pressures[-1]), float(pressures[pressures.size // 2])
    strongest = float(model.static_force(0.0, top))
    carried = (np.array(LOADS) * strongest if loads is None else np.asarray(loads, float)).tolist()
    isobaric = _each(pressures.tolist(), _isobaric(model), lambda p: f"isobaric loop at {p / 1e5:g} bar", skipped)
    isotonic = _each(
        carried, lambda load: _isotonic(model, load, top, strongest), lambda f: f"isotonic loop at {f:.4g} N", skipped
    )
    held = float(model.static_force(0.0, middle))
    releases = _each(
        [share * held for share in SHARES],
        lambda load: quick_release(model, middle, load),
        lambda f: f"quick release to {f:.4g} N",
        skipped,
    )
    free = free_contraction(model, middle)
    place = SPEED_AT * (free if math.isfinite(free) else 0.25)
    velocity = _each([place], lambda k: force_velocity(model, middle, k), lambda k: "force over speed", skipped)
    return Bench(model, forces, isobaric, isotonic, releases, velocity[0] if velocity else None, tuple(skipped))


def _each(
    values: list[float], run: Callable[[float], Result], name: Callable[[float], str], skipped: list[str]
) -> tuple[Result, ...]:
    """Run an experiment at each value; what fails is said, once for each reason."""
    found: list[Result] = []
    for value in values:
        try:
            found.append(run(value))
        except DehystError as fault:
            skipped.append(f"{name(value)}: {fault}")
    return tuple(found)


def _isobaric(model: MuscleModel) -> Callable[[float], Loop]:
    """Loop from 5 to 90 % of the free contraction."""

    def loop(pressure: float) -> Loop:
        free = free_contraction(model, pressure)
        high = 0.9 * (free if math.isfinite(free) else min(0.25, reach(model)[1]))
        return isobaric_loop(model, pressure, high / 18.0, high)

    return loop


def _isotonic(model: MuscleModel, load: float, top: float, strongest: float) -> Loop:
    """Loop from the pressure at which the muscle just carries the load at its length at rest."""
    low = lowest_pressure(model, load, top)
    if not low < 0.9 * top:
        raise ParameterError(
            f"the muscle pulls at most {strongest:.4g} N at {top / 1e5:g} bar, which leaves no stroke with this load. "
            "Take a smaller one, or a higher pressure."
        )
    return isotonic_loop(model, load, max(low, 0.05 * top), top)


def _loop_figures(loop: Loop, held: str, drive: str, response: str) -> dict[str, Any]:
    return {
        held: loop.held,
        f"{drive}_range": [float(loop.drive.min()), float(loop.drive.max())],
        f"{response}_range": [float(loop.response.min()), float(loop.response.max())],
        "width": loop.width,
        "width_percent": loop.width_percent,
        "asymmetry_percent": loop.asymmetry_percent,
    }


def _or_none(value: float) -> float | None:
    return value if math.isfinite(value) else None


def default_contractions(model: MuscleModel, pressures: npt.ArrayLike) -> Array:
    """Return 0, 5, 10 ... % up to the largest free contraction, as far as the formulas go.

    Examples
    --------
    >>> from dehyst.robot.muscles import muscle
    >>> default_contractions(muscle("tondu-lopez"), [1e5, 3e5]).round(2).tolist()
    [0.0, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3]
    """
    free = [free_contraction(model, p) for p in np.atleast_1d(np.asarray(pressures, float)).tolist()]
    most = max((each for each in free if math.isfinite(each)), default=0.25)
    last = min(math.ceil(most / 0.05 - 1e-9), 7)
    grid = 0.05 * np.arange(last + 1)
    return np.asarray(grid[grid <= reach(model)[1]])
