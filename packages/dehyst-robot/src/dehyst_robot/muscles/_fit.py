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
from dehyst.identification import single_blas
from dehyst.shell import command
from dehyst_robot.muscles._base import MuscleModel
from dehyst_robot.muscles._bench_log import BenchLog
from dehyst_robot.muscles._experiments import free_contraction
from dehyst_robot.muscles._parameters import parameter_names
from dehyst_robot.muscles._policy import POLICY
from dehyst_robot.muscles._registry import muscle_class
from dehyst_robot.muscles._search import SearchResult, refine_parameters, search_parameters

FOLDS = 4
LONG = 2500  # samples beyond which starts are compared on every other, third, ... sample


@dataclass(frozen=True, eq=False)
class MuscleFit:
    """A fitted muscle model.

    Attributes
    ----------
    model
        The fitted model.
    log
        The log of the fit.
    used
        (T,) samples that count: those at which the muscle pulls.
    force
        (T,) of the model along the log. [N]
    rmse, rmse_percent, largest
        Error on the samples that count: rms, in percent of their range of force, and the largest. [N]
    held_out, held_out_percent
        Rms error on samples that were left out of a fit, each once. [N]
    standard_errors
        By parameter; None where the log does not determine it, or it is at a bound.
    linear, undetermined, without_effect, at_bound
        Names of parameters: those solved in closed form; those the log does not determine; those without effect on any
        sample, which keep their values; those at a bound of their search.
    starts, seed
        Of the search.
    findings
        Limits of the fit.
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
    the model's `PARAMETERS`, from the model itself, from its published sets and from starts drawn at random. Samples at
    which the muscle hangs loose do not count, but remain part of the motion. The held-out error is that of four fits,
    each without a quarter of the samples: blocks of a motion, or points drawn at random of a log without time.

    Parameters
    ----------
    log
        Contraction, pressure, force; with time, friction and damping are fitted too.
    model
        Name of a model, or a model whose other parameters, such as the length, stay the same.
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
    >>> from dehyst_robot.muscles import muscle
    >>> truth = muscle("tondu-lopez", shape=1.4)
    >>> k, p = (grid.ravel() for grid in np.meshgrid(np.linspace(0, 0.2, 9), [2e5, 4e5]))
    >>> fit = fit_muscle(BenchLog(k, p, truth.static_force(k, p)), muscle("tondu-lopez"))
    >>> fit.rmse < 1e-6 * 2000
    True
    """
    if not 0 <= seed < 2**63:
        raise ParameterError(f"seed = {seed} must be a whole number from 0 on.", seed=seed)
    start = model
    if isinstance(start, str):
        start = muscle_class(start).published()
    used = ~log.slack
    _refuse(log, used, start)
    # Several threads of BLAS add in another order: results would differ from machine to machine.
    with single_blas():
        result = _searched(log, used, start, _published(start), seed)
        held_out = _held_out(log, used, start, result, seed)
    fitted = start.with_vector(result.vector)
    force = forces(fitted, log)
    error = (force - log.force)[used]
    span = float(np.ptp(log.force[used]))
    rmse = _rms(error)
    names, standard_errors, undetermined, at_bound = _certainty(log, start, result, error)
    fit = MuscleFit(
        model=fitted,
        log=log,
        used=used,
        force=force,
        rmse=rmse,
        rmse_percent=100.0 * rmse / span,
        largest=float(np.max(np.abs(error))),
        held_out=held_out,
        held_out_percent=100.0 * held_out / span,
        standard_errors=standard_errors,
        linear=_chosen(names, result.linear & result.active),
        undetermined=undetermined,
        without_effect=_chosen(names, ~result.active),
        at_bound=at_bound,
        starts=result.starts,
        seed=seed,
    )
    return replace(fit, findings=_findings(fit))


def _chosen(names: tuple[str, ...], mask: npt.NDArray[np.bool_]) -> tuple[str, ...]:
    return tuple(names[i] for i in np.flatnonzero(mask))


def forces(model: MuscleModel, log: BenchLog) -> Array:
    """Return a model's forces (T,) along a log: in motion if the log has time, else at rest in every point. [N]"""
    if log.time is None:
        return model.static_force(log.contraction, log.pressure)
    return model.simulate(log.contraction, log.pressure, log.time)


def _refuse(log: BenchLog, used: npt.NDArray[np.bool_], model: MuscleModel) -> None:
    count = int(used.sum())
    free = model.vector().size
    span = float(np.ptp(log.force[used]))
    if not free:
        raise ParameterError(f"{model.name} has no parameter that a fit may change.")
    if count <= free:
        raise RecordingError(
            f"{log.name} has {count} samples at which the muscle pulls, and {model.name} has {free} parameters: any of "
            f"them would do. Log {3 * free} points or more, or take a model with fewer parameters.",
            samples=count,
            parameters=free,
        )
    if span <= POLICY.flat * float(np.max(np.abs(log.force))):
        raise RecordingError(
            f"the force of {log.name} stays at {float(log.force.max()):.4g} N: nothing shows how it depends on "
            f"contraction and pressure. Check the column, and log both over their range.",
            span=span,
        )
    # A contraction or pressure beyond the model's limits is refused before the search.
    forces(model, log)


def _published(model: MuscleModel) -> list[Array]:
    vectors = []
    for name in model.SETS:
        vector = type(model).published(name).vector()
        # A set may have tuples of another length, for instance more knots.
        if vector.shape == model.vector().shape:
            vectors.append(vector)
    return vectors


def _searched(
    log: BenchLog, used: npt.NDArray[np.bool_], start: MuscleModel, others: list[Array], seed: int
) -> SearchResult:
    """Search on a thinner log if it is long, then refine the result on all of it."""
    stride = max(1, len(log) // LONG)
    thin = _every(log, stride)
    mask = used[::stride]
    result = search_parameters(
        _predict(thin, mask, start), thin.force[mask], start.vector(), others, start.bounds(), seed
    )
    if stride == 1:
        return result
    return refine_parameters(_predict(log, used, start), log.force[used], result, start.bounds())


def _every(log: BenchLog, stride: int) -> BenchLog:
    if stride == 1:
        return log
    part = slice(None, None, stride)  # a motion stays in order
    time = log.time
    if time is not None:
        time = time[part]
    return BenchLog(log.contraction[part], log.pressure[part], log.force[part], time, log.name)


def _predict(log: BenchLog, used: npt.NDArray[np.bool_], start: MuscleModel) -> Any:
    return lambda vector: forces(start.with_vector(vector), log)[used]


def _held_out(
    log: BenchLog, used: npt.NDArray[np.bool_], start: MuscleModel, result: SearchResult, seed: int
) -> float:
    """Return the rms error on held-out samples: each lies in one of four parts, and a fit leaves one part out. [N]"""
    stride = max(1, len(log) // LONG)
    thin = _every(log, stride)
    mask = used[::stride]
    count = len(thin)
    # Neighbours in a motion are alike, so that its parts are blocks; points are drawn.
    if thin.time is None:
        part = np.random.default_rng(seed).permutation(np.arange(count) % FOLDS)
    else:
        part = np.arange(count) * FOLDS // count
    errors = []
    for fold in range(FOLDS):
        fitted_on = mask & (part != fold)
        left_out = mask & (part == fold)
        # A part may be slack as a whole, or be too large to leave enough samples.
        if not left_out.any() or fitted_on.sum() <= start.vector().size:
            continue
        refined = refine_parameters(
            _predict(thin, fitted_on, start), thin.force[fitted_on], result, start.bounds()
        )
        error = forces(start.with_vector(refined.vector), thin) - thin.force
        errors.append(error[left_out])
    if not errors:
        return math.nan
    return _rms(np.concatenate(errors))


def _certainty(
    log: BenchLog, start: MuscleModel, result: SearchResult, error: Array
) -> tuple[tuple[str, ...], dict[str, float | None], tuple[str, ...], tuple[str, ...]]:
    """Return names, standard errors, names of parameters that are not determined, and names of those at a bound."""
    names = parameter_names(start)
    low, high = start.bounds()
    width = np.where(np.isfinite(high - low), high - low, 1.0)
    margin = np.minimum(result.vector - low, high - result.vector)
    at_bound = result.active & (margin < 1e-6 * width)
    inner = np.flatnonzero(result.active & ~at_bound)
    errors: dict[str, float | None] = dict.fromkeys(names)
    undetermined: list[str] = []
    if inner.size:
        # Scaled slopes make singular values comparable between parameters of different units.
        slopes = result.jacobian[:, inner]
        norm = np.maximum(np.linalg.norm(slopes, axis=0), 1e-300)
        _, s, v = np.linalg.svd(slopes / norm, full_matrices=False)
        lost = s < POLICY.dependent * s[0]
        mixed = np.max(np.abs(v[lost]), axis=0, initial=0.0) > POLICY.mixed
        noise = _noise(error, int(inner.size), log)
        variance = np.sum((v[~lost] / s[~lost, None]) ** 2, axis=0) * noise
        for place, i in enumerate(inner):
            if mixed[place]:
                undetermined.append(names[i])
            else:
                errors[names[i]] = float(math.sqrt(variance[place]) / norm[place])
    return names, errors, tuple(undetermined), _chosen(names, at_bound)


def _noise(error: Array, parameters: int, log: BenchLog) -> float:
    """Return the variance of the errors, for a motion that of its effective sample size: its errors are correlated."""
    variance = float(np.sum(error**2)) / max(1, error.size - parameters)
    if log.time is None or error.size < 10 or not variance:
        return variance
    # Of a first-order process; positive only, so that no sample counts for more than one.
    correlation = float(np.sum(error[1:] * error[:-1]) / max(float(np.sum(error**2)), 1e-300))
    correlation = min(max(correlation, 0.0), 0.999)
    return variance * (1.0 + correlation) / (1.0 - correlation)


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _findings(fit: MuscleFit) -> tuple[Finding, ...]:
    """Return the limits of a fit, the most important one first."""
    findings: list[Finding] = []
    if fit.rmse_percent > POLICY.poor_percent:
        findings.append(
            Finding(
                "muscle-poor-fit",
                f"{fit.model.name} misses the log by {fit.rmse_percent:.1f} % of its range of force (rms; largest "
                f"{fit.largest:.3g} N): it cannot be bent to this muscle. Check that the pressure is "
                f"gauge and the contraction counts from the length without pressure and load; then try another model: "
                f"sarosi or aschemann-schindele bend to most: dehyst muscle --list",
            )
        )
    findings += _findings_of_log(fit)
    findings += _findings_of_parameters(fit)
    return tuple(findings)


def _findings_of_log(fit: MuscleFit) -> list[Finding]:
    """Return what the log does not show of the muscle: contractions, pressures, forces."""
    log, covers, slack = fit.log, fit.log.covers, fit.log.slack
    k_low, k_high = covers["contraction"]
    p_low, p_high = covers["pressure"]
    free = free_contraction(fit.model, p_high)
    covered = POLICY.covered
    findings = []
    # Without a free contraction there is no range to compare with.
    if math.isfinite(free) and (k_high < covered * free or k_low > (1.0 - covered) * free):
        findings.append(
            Finding(
                "muscle-extrapolation",
                f"where it pulls, the log goes from {100 * k_low:.1f} to {100 * k_high:.1f} % of contraction, and the "
                f"model from 0 to {100 * free:.1f} % at {p_high / 1e5:.3g} bar: forces elsewhere are what the formula "
                f"makes of the rest. Log the whole range, or use the model inside it only.",
            )
        )
    if p_high - p_low < POLICY.same_pressure * p_high:
        findings.append(
            Finding(
                "muscle-one-pressure",
                f"the pressure stays at {p_high / 1e5:.3g} bar: how the force depends on it is the formula's guess. "
                f"Log at three pressures or more.",
            )
        )
    if slack.any():
        findings.append(
            Finding(
                "muscle-slack",
                f"{int(slack.sum())} of {len(log)} samples do not count: there the muscle hangs loose, with less than "
                f"half a percent of the largest force ({float(log.force.max()):.4g} N), and a formula that goes on "
                f"below zero cannot be compared. There the model pulls {max(float(fit.force[slack].max()), 0.0):.3g} N "
                f"at most. Nothing to do, unless the force sensor was off.",
            )
        )
    return findings


def _findings_of_parameters(fit: MuscleFit) -> list[Finding]:
    """Return which parameters the log does not determine, and which ended at a bound."""
    name = fit.model.name
    findings = []
    if fit.without_effect:
        reason = "no sample depends on them, and what the log does not show"
        if fit.log.time is None:
            reason = "the log has no time, so that every row is a point at rest, and what only motion shows"
        findings.append(
            Finding(
                "muscle-not-in-log",
                f"{', '.join(fit.without_effect)} of {name} stayed as given: {reason} was not fitted. For friction "
                f"and damping, log loops of contraction at two speeds, with time.",
            )
        )
    if fit.undetermined:
        findings.append(
            Finding(
                "muscle-undetermined",
                f"{', '.join(fit.undetermined)} cannot be told apart from this log: other values give the same forces. "
                f"Use the forces, not these values; more pressures and contractions may part them.",
            )
        )
    if fit.at_bound:
        findings.append(
            Finding(
                "muscle-at-bound",
                f"{', '.join(fit.at_bound)} ended at a bound of the search. Where that is zero, the log shows nothing "
                f"of it; elsewhere the muscle wants a value that has no meaning in this model, or the log's units are "
                f"wrong. The bounds: {command('muscle', name, json=True)}",
            )
        )
    return findings
