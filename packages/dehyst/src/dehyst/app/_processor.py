"""Identifies a model whose compensator keeps its period on a processor: smaller sums, plays, and cheap inverses."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from dehyst.app._terminal import percent
from dehyst.errors import DehystError, ParameterError
from dehyst.export import kit as export_kit
from dehyst.export import subject_of
from dehyst.findings import Finding
from dehyst.identification import Fit
from dehyst.models import Model

# Each try has so many of the numbers of the one before.
SMALLER = 0.8
BETWEEN = 3  # sizes tried between one that fits and the next larger one that does not
# Where the best model is too slow: their steps take a small part of what a forward sum with as many numbers takes.
CHEAP = (
    "pi",
    "modified-pi",
    "inverse-stop",
    "inverse-stop-rate",
    "inverse-path",
    "inverse-stop-path",
)


@dataclass(frozen=True)
class StepCost:
    """What one step of a compensator takes on a processor.

    Attributes
    ----------
    processor, real
        Its name, and "double" or "float".
    period
        Time that there is for a step. [s]
    typical, most
        Time that a step takes, usually and at most. [s]
    """

    processor: str
    real: str
    period: float
    typical: float
    most: float

    @property
    def fits(self) -> bool:
        """Whether the slowest step ends within the period."""
        return self.most <= self.period

    @property
    def words(self) -> str:
        """It in a sentence."""
        clock = export_kit.CLOCKS[self.processor] / 1e6
        return (
            f"a step takes {percent(self.typical / self.period)} of the period of {self.period:g} s on a "
            f"{self.processor} at {clock:.0f} MHz in {self.real}, {percent(self.most / self.period)} at most (its "
            f"instructions alone, at one a cycle)"
        )

    def as_dict(self) -> dict[str, Any]:
        """Return plain values for JSON."""
        return {
            "processor": self.processor, "real": self.real, "period": self.period, "typical": self.typical,
            "most": self.most, "fits": self.fits,
        }  # fmt: skip


def refuse_processor(processor: str | None, period: float | None) -> None:
    """Refuse a processor whose instructions were not counted, and a period that is none or has no processor."""
    if processor is None:
        if period is not None:
            raise ParameterError(
                f"--period {period:g} says how long a step may take, but not on which processor. Add --processor "
                f"{' or --processor '.join(export_kit.CLOCKS)}."
            )
        return
    export_kit.check_choice(processor, tuple(export_kit.CLOCKS), "--processor")
    if period is not None and not 0.0 < period < float("inf"):
        raise ParameterError(f"--period {period:g} is no time; give seconds, such as 0.001.")


def fit_for(
    identify_with: Callable[[str | None, int | None], Fit], processor: str, period: float | None
) -> tuple[Fit, StepCost, list[Finding]]:
    """Return a fit whose compensator keeps the period, what a step of it takes, and what to say.

    Where the best one does not keep it, the largest smaller one that does is compared with plays and rows that were
    identified as an inverse; the one that errs least on the fitted part is taken.

    Parameters
    ----------
    identify_with
        Family, None for what was asked for, and largest number of numbers, None for as many as pay off -> the fit.
    processor
        One of `export_kit.CLOCKS`.
    period
        Time for a step; None for that between the samples of the log. [s]

    Raises
    ------
    ParameterError
        If there is no period.
    """
    first = identify_with(None, None)
    period = period or first.model.period
    if not period > 0.0:
        raise ParameterError(
            "--processor needs the period of the controller, and the log has no time. Add --period SECONDS."
        )
    first_cost = cost_of(first.model, processor, period)
    if first_cost.fits:
        return first, first_cost, []
    tried = [(first, first_cost), *_smaller(first, first_cost, identify_with)]
    if first.settings.get("family") == "auto":
        for family in CHEAP:
            try:
                fit = identify_with(family, None)
                tried.append((fit, cost_of(fit.model, processor, period)))
            except DehystError:  # not a family for this log
                continue
    fitting = [row for row in tried if row[1].fits and not row[0].model.no_inverse]
    if not fitting:
        fit, cost = min(tried, key=lambda row: row[1].most)
        return fit, cost, [_too_slow(cost)]
    fit, cost = min(fitting, key=lambda row: row[0].train.rmse)
    finding = Finding(
        "smaller-for-period",
        f"the best model, {_named(first)}, is too slow: {first_cost.words}. This one is {_named(fit)}."
        f"{_errors(fit, first)} The best one keeps a period of {_longer(first_cost.most)} s (--period "
        f"{_longer(first_cost.most)}).",
    )
    return fit, cost, [finding]


def _smaller(
    first: Fit, first_cost: StepCost, identify_with: Callable[[str | None, int | None], Fit]
) -> list[tuple[Fit, StepCost]]:
    """Return fits with fewer numbers, until one keeps the period, and some between that one and the one before."""
    tried = []

    def try_size(size: int) -> bool:
        fit = identify_with(None, size)
        cost = cost_of(fit.model, first_cost.processor, first_cost.period)
        tried.append((fit, cost))
        return cost.fits

    too_many = first.model.free_parameters
    # Time goes with numbers, roughly: what is far from fitting need not be tried.
    step = min(SMALLER, first_cost.period / first_cost.most)
    try:
        # Ends with a refusal where there is nothing so small.
        while not try_size(size := int(step * too_many)):
            too_many, step = size, SMALLER
        for _ in range(BETWEEN):
            middle = (size + too_many) // 2
            if middle > size and try_size(middle):
                size = middle
            else:
                too_many = middle
    except DehystError as fault:
        smallest = fault.facts.get("smallest")
        # The message of a row says how small it can be; that one may be the first that fits.
        if isinstance(smallest, int) and smallest < too_many:
            with suppress(DehystError):
                try_size(smallest)
    return tried


def _named(fit: Fit) -> str:
    return f"{fit.family} with {fit.model.free_parameters} numbers"


def _too_slow(cost: StepCost) -> Finding:
    return Finding(
        "step-exceeds-period",
        f"{cost.words}: no model of this log was found that is faster. A step that is late answers a sample that is "
        f"old. Call it more seldom (--period {_longer(cost.most)}), or take a faster processor.",
    )


def cost_of(model: Model, processor: str, period: float) -> StepCost:
    """Return what a step takes: in double, or if only float keeps the period, in float."""
    kind = "forward" if model.no_inverse else "inverse"
    costs = []
    for real in export_kit.REALS:
        unit = subject_of(model, kind, name="unit", period=period, real=real)
        typical, most = export_kit.budget(unit).seconds()[processor]
        costs.append(StepCost(processor, real, period, typical, most))
    for cost in costs:
        if cost.fits:
            return cost
    return min(costs, key=lambda cost: cost.most)


def _longer(time: float) -> str:
    """A time with two digits that is a little longer."""
    return f"{1.05 * time:.2g}"


def _errors(fit: Fit, first: Fit) -> str:
    if fit.test is None or first.test is None:
        return ""
    held_out, best = fit.test.rmse_percent, first.test.rmse_percent
    return f" Its held-out error is {held_out:.2g} % of the range, that of the best {best:.2g} %."
