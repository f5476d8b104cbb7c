"""Simulated test bench for muscle models: the same experiments on every model.

Static forces, isobaric and isotonic loops, quick release, force over speed: so that two models, or a model and a log,
can be compared.
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
from dehyst_robot.muscles._base import MuscleModel
from dehyst_robot.muscles._experiments import (
    SHARES,
    ForceMap,
    ForceVelocity,
    Loop,
    Release,
    contraction_reach,
    finite_or_none,
    force_map,
    force_velocity,
    free_contraction,
    isobaric_loop,
    isotonic_loop,
    lowest_pressure,
    quick_release,
)

LOADS = (0.1, 0.25, 0.5)  # of the largest force: loads of the isotonic loops
SPEED_AT = 0.2  # of the free contraction: where the force over speed is read
USUAL_FREE = 0.25  # free contraction of a muscle whose formula has none: that of most muscles

Result = TypeVar("Result")


@dataclass(frozen=True, eq=False)
class Bench:
    """Results of all experiments on a model.

    Attributes
    ----------
    model
        The model on the bench.
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
        Experiments that could not be run, with the reason.
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
        forces = self.forces
        velocity = None
        if self.velocity is not None:
            velocity = self.velocity.as_dict()
        isobaric = []
        for loop in self.isobaric:
            isobaric.append(_loop_figures(loop, "pressure_Pa", "contraction", "force_N"))
        isotonic = []
        for loop in self.isotonic:
            isotonic.append(_loop_figures(loop, "load_N", "pressure_Pa", "contraction"))
        return {
            "model": self.model.name,
            "length_m": self.model.length,
            "parameters": self.model.as_dict(),
            "force_map": {
                "contraction": forces.contraction.tolist(),
                "pressure_Pa": forces.pressure.tolist(),
                "force_N": forces.force.tolist(),
                "blocked_N": forces.blocked.tolist(),
                "free_contraction": list(map(finite_or_none, forces.free.tolist())),
                "stiffness_N_m": forces.stiffness.tolist(),
            },
            "isobaric": isobaric,
            "isotonic": isotonic,
            "releases": list(map(_release_figures, self.releases)),
            "force_velocity": velocity,
            "skipped": list(self.skipped),
        }


def run_bench(
    model: MuscleModel,
    contraction: npt.ArrayLike,
    pressure: npt.ArrayLike,
    loads: npt.ArrayLike | None = None,
) -> Bench:
    """Run every experiment on a model; those that cannot be run are left out, with the reason.

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
    >>> from dehyst_robot.muscles import muscle
    >>> bench = run_bench(muscle("tondu-lopez"), [0.0, 0.1], [2e5, 4e5])
    >>> len(bench.isobaric), len(bench.isotonic), len(bench.releases), bench.skipped
    (2, 3, 4, ())
    """
    forces = force_map(model, contraction, pressure)
    skipped: list[str] = []
    pressures = np.unique(forces.pressure[forces.pressure > 0])
    # Loops and motions need a muscle that pulls.
    if not pressures.size:
        return Bench(
            model, forces, (), (), (), None, ("everything that moves: no pressure is above zero",)
        )
    top = float(pressures[-1])
    middle = float(pressures[pressures.size // 2])
    strongest = float(model.static_force(0.0, top))
    if loads is None:
        loads = np.array(LOADS) * strongest

    def name_of_loop(pressure: float) -> str:
        return f"isobaric loop at {pressure / 1e5:g} bar"

    isobaric = _run_at(pressures.tolist(), _isobaric(model), name_of_loop, skipped)
    isotonic = _run_at(
        np.asarray(loads, float).tolist(),
        lambda load: _isotonic(model, load, top, strongest),
        lambda load: f"isotonic loop at {load:.4g} N",
        skipped,
    )
    # Releases and the force over speed are run at one pressure only: the middle one.
    blocked = float(model.static_force(0.0, middle))
    releases = _run_at(
        [share * blocked for share in SHARES],
        lambda load: quick_release(model, middle, load),
        lambda load: f"quick release to {load:.4g} N",
        skipped,
    )
    free = free_contraction(model, middle)
    if not math.isfinite(free):
        free = USUAL_FREE
    velocities = _run_at(
        [SPEED_AT * free],
        lambda contraction: force_velocity(model, middle, contraction),
        lambda contraction: "force over speed",
        skipped,
    )
    velocity = next(iter(velocities), None)
    return Bench(model, forces, isobaric, isotonic, releases, velocity, tuple(skipped))


def _run_at(
    values: list[float],
    run: Callable[[float], Result],
    name: Callable[[float], str],
    skipped: list[str],
) -> tuple[Result, ...]:
    """Run an experiment at every value; a failure is added to `skipped` with its reason."""
    results: list[Result] = []
    for value in values:
        try:
            results.append(run(value))
        except DehystError as fault:
            skipped.append(f"{name(value)}: {fault}")
    return tuple(results)


def _isobaric(model: MuscleModel) -> Callable[[float], Loop]:
    """Return the experiment: a loop from 5 to 90 % of the free contraction at a pressure."""

    def loop(pressure: float) -> Loop:
        free = free_contraction(model, pressure)
        if not math.isfinite(free):
            free = min(USUAL_FREE, contraction_reach(model)[1])
        high = 0.9 * free
        return isobaric_loop(model, pressure, high / 18.0, high)

    return loop


def _isotonic(model: MuscleModel, load: float, top: float, strongest: float) -> Loop:
    """Run a loop from the pressure at which the muscle just carries the load at its length at rest."""
    low = lowest_pressure(model, load, top)
    # nan, where no pressure carries the load, fails this test, too.
    if not low < 0.9 * top:
        raise ParameterError(
            f"the muscle pulls at most {strongest:.4g} N at {top / 1e5:g} bar, which leaves no stroke with this load. "
            "Take a smaller one, or a higher pressure."
        )
    return isotonic_loop(model, load, max(low, 0.05 * top), top)


def _loop_figures(loop: Loop, constant: str, drive: str, response: str) -> dict[str, Any]:
    return {
        constant: loop.held,
        f"{drive}_range": [float(loop.drive.min()), float(loop.drive.max())],
        f"{response}_range": [float(loop.response.min()), float(loop.response.max())],
        "width": loop.width,
        "width_percent": loop.width_percent,
        "asymmetry_percent": loop.asymmetry_percent,
    }


def _release_figures(release: Release) -> dict[str, float]:
    return {
        "load_N": release.load,
        "mass_kg": release.mass,
        "peak_speed_m_s": release.peak_speed,
        "peak_contraction": release.peak_contraction,
    }


def default_contractions(model: MuscleModel, pressures: npt.ArrayLike) -> Array:
    """Return 0, 5, 10 ... % up to the largest free contraction, as far as the formulas go.

    Examples
    --------
    >>> from dehyst_robot.muscles import muscle
    >>> default_contractions(muscle("tondu-lopez"), [1e5, 3e5]).round(2).tolist()
    [0.0, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3]
    """
    most = -math.inf
    for pressure in np.atleast_1d(np.asarray(pressures, float)).tolist():
        free = free_contraction(model, pressure)
        if math.isfinite(free):
            most = max(most, free)
    if most == -math.inf:
        most = USUAL_FREE
    # Seven steps at most: 35 % is more than any muscle contracts.
    last = min(math.ceil(most / 0.05 - 1e-9), 7)
    grid = 0.05 * np.arange(last + 1)
    return np.asarray(grid[grid <= contraction_reach(model)[1]])
