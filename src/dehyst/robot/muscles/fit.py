"""Fits a muscle model to a test-bench log: standard errors, held-out error, warnings."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.errors import ParameterError, RecordingError
from dehyst.findings import Finding
from dehyst.identification.threads import single_blas
from dehyst.robot.muscles.base import MuscleModel
from dehyst.robot.muscles.bench_log import BenchLog
from dehyst.robot.muscles.experiments import free_contraction
from dehyst.robot.muscles.parameters import parameter_names
from dehyst.robot.muscles.registry import muscle_class
from dehyst.robot.muscles.search import Found, refine, search
from dehyst.shell import command

FOLDS = 4
FLAT = 1e-6  # relative range of a force that does not vary
LONG = 2500  # samples beyond which starts are compared on every other, third, ... sample
DEPENDENT = 1e-7  # singular value, of scaled slopes, below which a combination of parameters is not told by the log
POOR_PERCENT = 5.0  # of the range of force, rms: more than the best models leave of any muscle
COVERED = 0.8  # of the contractions up to the free one
SAME_PRESSURE = 0.02  # relative range of a pressure that counts as held


@dataclass(frozen=True, eq=False)
class MuscleFit:
    """A fitted muscle model.

    Attributes
    ----------
    model
        Fitted.
    log
        What it was fitted to.
    used
        (T,) samples that counted: those at which the muscle pulls.
    force
        (T,) of the model along the log. [N]
    rmse, rmse_percent, largest
        Error on the samples that counted: rms, in percent of their range of force, and the largest. [N]
    held_out, held_out_percent
        Rms error on samples that were left out of a fit, each once. [N]
    standard_errors
        By parameter; None where the log does not tell, or a bound was met.
    linear, undetermined, without_effect, at_bound
        Names of parameters: those solved in closed form; those the log does not tell apart; those that make no
        difference to any sample, and stayed as they were; those at a bound of their search.
    starts, seed
        Of the search.
    findings
        What to know before trusting it.
    """

    model: MuscleModel
    log: BenchLog
    used: npt.NDArray[np.bool_]
    force: Array
    rmse: float
    rmse_percent: float
    largest: float
    held_out: float
    held_out_percent: float
    standard_errors: dict[str, float | None]
    linear: tuple[str, ...]
    undetermined: tuple[str, ...]
    without_effect: tuple[str, ...]
    at_bound: tuple[str, ...]
    starts: int
    seed: int
    findings: tuple[Finding, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """Return everything but the samples, as plain values."""
        return {
            "model": self.model.name,
            "samples": len(self.log),
            "used": int(self.used.sum()),
            "at_rest": self.log.time is None,
            "covers": {key: list(ends) for key, ends in self.log.covers.items()},
            "rmse_N": self.rmse,
            "rmse_percent": self.rmse_percent,
            "max_N": self.largest,
            "held_out_N": self.held_out,
            "held_out_percent": self.held_out_percent,
            "parameters": self.model.as_dict(),
            "standard_errors": self.standard_errors,
            "linear": list(self.linear),
            "undetermined": list(self.undetermined),
            "without_effect": list(self.without_effect),
            "at_bound": list(self.at_bound),
            "starts": self.starts,
            "seed": self.seed,
            "warnings": [finding.as_dict() for finding in (*self.log.findings, *self.findings)],
        }


def fit_muscle(log: BenchLog, model: MuscleModel | str, *, seed: int = 0) -> MuscleFit:
    """Return a model with the parameters that fit a bench log best, by least squares of the force.

    Parameters that the forces are linear in are solved in closed form. The others are searched, within the bounds of
    the model's `PARAMETERS`, from the model as given, from its published sets and from starts drawn at random. Samples
    at which the muscle hangs loose do not count, but remain part of the motion. The error on samples left out is that
    of four fits, each without a quarter of the samples: blocks of a motion, points drawn at random of a log without
    time.

    Parameters
    ----------
    log
        Contraction, pressure, force; with time, friction and damping are fitted too.
    model
        Name of a model, or one whose other parameters, such as the length, are kept.
    seed
        Of starts and of points left out.

    Raises
    ------
    ParameterError
        If there is no such model, or the log leaves the range in which it has a force.
    RecordingError
        If hardly any sample pulls, or the model has more parameters than the log samples.

    Examples
    --------
    >>> import numpy as np
    >>> from dehyst.robot.muscles import muscle
    >>> truth = muscle("tondu-lopez", shape=1.4)
    >>> k, p = (each.ravel() for each in np.meshgrid(np.linspace(0, 0.2, 9), [2e5, 4e5]))
    >>> found = fit_muscle(BenchLog(k, p, truth.static_force(k, p)), muscle("tondu-lopez"))
    >>> found.rmse < 1e-6 * 2000
    True
    """
    if not 0 <= seed < 2**63:
        raise ParameterError(f"seed = {seed} must be a whole number from 0 on.", seed=seed)
    start = muscle_class(model).published() if isinstance(model, str) else model
    used = ~log.slack
    _refuse(log, used, start)
    with single_blas():
        found = _searched(log, used, start, _published(start), seed)
        held_out = _held_out(log, used, start, found, seed)
    fitted = start.with_vector(found.vector)
    force = forces(fitted, log)
    missed = (force - log.force)[used]
    span = float(np.ptp(log.force[used]))
    names, errors, unsure, bound = _certainty(log, start, found, missed)
    rmse = _rms(missed)
    fit = MuscleFit(
        fitted, log, used, force, rmse, 100.0 * rmse / span, float(np.max(np.abs(missed))),
        held_out, 100.0 * held_out / span, errors,
        tuple(name for name, is_linear in zip(names, found.linear & found.active, strict=True) if is_linear),
        unsure, tuple(name for name, moves in zip(names, found.active, strict=True) if not moves), bound,
        found.starts, seed,
    )  # fmt: skip
    return replace(fit, findings=_findings(fit))


def forces(model: MuscleModel, log: BenchLog) -> Array:
    """Return a model's forces (T,) along a log: in motion if it has time, at rest in every point otherwise. [N]"""
    if log.time is None:
        return model.static_force(log.contraction, log.pressure)
    return model.simulate(log.contraction, log.pressure, log.time)


def _refuse(log: BenchLog, used: npt.NDArray[np.bool_], model: MuscleModel) -> None:
    many, free, span = int(used.sum()), model.vector().size, float(np.ptp(log.force[used]))
    if not free:
        raise ParameterError(f"{model.name} has no parameter that a fit may change.")
    if many <= free:
        raise RecordingError(
            f"{log.name} has {many} samples at which the muscle pulls, and {model.name} has {free} parameters: any of "
            f"them would do. Log {3 * free} points or more, or take a model with fewer parameters.",
            samples=many,
            parameters=free,
        )
    if span <= FLAT * float(np.max(np.abs(log.force))):
        raise RecordingError(
            f"the force of {log.name} stays at {float(log.force.max()):.4g} N: nothing shows how it depends on "
            f"contraction and pressure. Check the column, and log both over their range.",
            span=span,
        )
    forces(model, log)  # a contraction or pressure beyond the model's limits is named before the search


def _published(model: MuscleModel) -> list[Array]:
    found = [type(model).published(which).vector() for which in model.SETS]
    return [each for each in found if each.shape == model.vector().shape]


def _searched(log: BenchLog, used: npt.NDArray[np.bool_], start: MuscleModel, others: list[Array], seed: int) -> Found:
    """Search on a thinner log if it is long, then all of it from there."""
    stride = max(1, len(log) // LONG)
    thin, kept = _every(log, stride), used[::stride]
    found = search(_predict(thin, kept, start), thin.force[kept], start.vector(), others, start.bounds(), seed)
    if stride == 1:
        return found
    return refine(_predict(log, used, start), log.force[used], found, start.bounds())


def _every(log: BenchLog, stride: int) -> BenchLog:
    if stride == 1:
        return log
    part = slice(None, None, stride)
    time = None if log.time is None else log.time[part]
    return BenchLog(log.contraction[part], log.pressure[part], log.force[part], time, log.name)


def _predict(log: BenchLog, used: npt.NDArray[np.bool_], start: MuscleModel) -> Any:
    return lambda vector: forces(start.with_vector(vector), log)[used]


def _held_out(log: BenchLog, used: npt.NDArray[np.bool_], start: MuscleModel, found: Found, seed: int) -> float:
    """Rms error on samples left out: each in one of four parts, fitted without it. [N]"""
    stride = max(1, len(log) // LONG)
    thin, kept = _every(log, stride), used[::stride]
    many = len(thin)
    if thin.time is None:
        part = np.random.default_rng(seed).permutation(np.arange(many) % FOLDS)
    else:
        part = np.arange(many) * FOLDS // many
    missed = []
    for fold in range(FOLDS):
        fitted_on, left_out = kept & (part != fold), kept & (part == fold)
        if not left_out.any() or fitted_on.sum() <= start.vector().size:
            continue
        vector = refine(_predict(thin, fitted_on, start), thin.force[fitted_on], found, start.bounds()).vector
        missed.append((forces(start.with_vector(vector), thin) - thin.force)[left_out])
    return _rms(np.concatenate(missed)) if missed else math.nan


def _certainty(
    log: BenchLog, start: MuscleModel, found: Found, missed: Array
) -> tuple[tuple[str, ...], dict[str, float | None], tuple[str, ...], tuple[str, ...]]:
    """Names, standard errors, names that are not told apart, and names at a bound."""
    names, (low, high) = parameter_names(start), start.bounds()
    width = np.where(np.isfinite(high - low), high - low, 1.0)
    at_bound = found.active & (np.minimum(found.vector - low, high - found.vector) < 1e-6 * width)
    inner = np.flatnonzero(found.active & ~at_bound)
    errors: dict[str, float | None] = dict.fromkeys(names)
    unsure: tuple[str, ...] = ()
    if inner.size:
        slopes = found.jacobian[:, inner]
        norm = np.maximum(np.linalg.norm(slopes, axis=0), 1e-300)
        _, s, v = np.linalg.svd(slopes / norm, full_matrices=False)
        lost = s < DEPENDENT * s[0]
        mixed = np.max(np.abs(v[lost]), axis=0) > 0.05 if lost.any() else np.zeros(inner.size, dtype=bool)
        variance = np.sum((v[~lost] / s[~lost, None]) ** 2, axis=0) * _noise(missed, int(inner.size), log)
        for place, i in enumerate(inner):
            errors[names[i]] = None if mixed[place] else float(math.sqrt(variance[place]) / norm[place])
        unsure = tuple(names[i] for place, i in enumerate(inner) if mixed[place])
    return names, errors, unsure, tuple(names[i] for i in np.flatnonzero(at_bound))


def _noise(missed: Array, parameters: int, log: BenchLog) -> float:
    """Variance of the errors; of a motion, whose errors follow each other, that of as many as are worth one each."""
    variance = float(np.sum(missed**2)) / max(1, missed.size - parameters)
    if log.time is None or missed.size < 10 or not variance:
        return variance
    like = float(np.sum(missed[1:] * missed[:-1]) / max(float(np.sum(missed**2)), 1e-300))
    like = min(max(like, 0.0), 0.999)
    return variance * (1.0 + like) / (1.0 - like)


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _findings(fit: MuscleFit) -> tuple[Finding, ...]:
    """What the log cannot determine of the muscle, that which matters most first."""
    log, model, covers, slack = fit.log, fit.model, fit.log.covers, fit.log.slack
    (k_low, k_high), (p_low, p_high) = covers["contraction"], covers["pressure"]
    free = free_contraction(model, p_high)
    found = []
    if fit.rmse_percent > POOR_PERCENT:
        found.append(
            Finding(
                "muscle-poor-fit",
                f"{model.name} misses the log by {fit.rmse_percent:.1f} % of its range of force (rms; largest "
                f"{fit.largest:.3g} N): it cannot be bent to this muscle. Check that the pressure is "
                f"gauge and the contraction counts from the length without pressure and load; then try another model: "
                f"sarosi or aschemann-schindele bend to most: dehyst muscle --list",
            )
        )
    if math.isfinite(free) and (k_high < COVERED * free or k_low > (1.0 - COVERED) * free):
        found.append(
            Finding(
                "muscle-extrapolation",
                f"where it pulls, the log goes from {100 * k_low:.1f} to {100 * k_high:.1f} % of contraction, and the "
                f"model from 0 to {100 * free:.1f} % at {p_high / 1e5:.3g} bar: forces elsewhere are what the formula "
                f"makes of the rest. Log the whole range, or use the model inside it only.",
            )
        )
    if p_high - p_low < SAME_PRESSURE * p_high:
        found.append(
            Finding(
                "muscle-one-pressure",
                f"the pressure stays at {p_high / 1e5:.3g} bar: how the force depends on it is the formula's guess. "
                f"Log at three pressures or more.",
            )
        )
    if slack.any():
        found.append(
            Finding(
                "muscle-slack",
                f"{int(slack.sum())} of {len(log)} samples do not count: there the muscle hangs loose, with less than "
                f"half a percent of the largest force ({float(log.force.max()):.4g} N), and a formula that goes on "
                f"below zero cannot be compared. There the model pulls {max(float(fit.force[slack].max()), 0.0):.3g} N "
                f"at most. Nothing to do, unless the force sensor was off.",
            )
        )
    if fit.without_effect:
        why = (
            "the log has no time, so that every row is a point at rest, and what only motion shows"
            if log.time is None
            else "no sample depends on them, and what the log does not show"
        )
        found.append(
            Finding(
                "muscle-not-in-log",
                f"{', '.join(fit.without_effect)} of {model.name} stayed as given: {why} was not fitted. For friction "
                f"and damping, log loops of contraction at two speeds, with time.",
            )
        )
    if fit.undetermined:
        found.append(
            Finding(
                "muscle-undetermined",
                f"{', '.join(fit.undetermined)} cannot be told apart from this log: other values give the same forces. "
                f"Use the forces, not these values; more pressures and contractions may part them.",
            )
        )
    if fit.at_bound:
        found.append(
            Finding(
                "muscle-at-bound",
                f"{', '.join(fit.at_bound)} ended at a bound of the search. Where that is zero, the log shows nothing "
                f"of it; elsewhere the muscle wants a value that has no meaning in this model, or the log's units are "
                f"wrong. The bounds: {command('muscle', model.name, json=True)}",
            )
        )
    return tuple(found)
