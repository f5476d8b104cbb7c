"""The thresholds by which the lights of a report page are set: one record, each with its reason."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class LightPolicy:
    """Numbers that decide the colours of a page; those that decide the verdict are the identification's own.

    Of two numbers the first is the limit between good and care, the second that between care and bad.
    """

    # The error is so many times smaller than that of the best curve without hysteresis; a smaller gain is no clear one.
    # [factor]
    better_than_curve: float = 1.5
    # The error on samples held out is so many times that on fitted ones: a model that only fits does worse on others.
    # [factor]
    test_over_train: tuple[float, float] = (2.0, 5.0)
    # Twice almost nothing is still almost nothing: below this error that ratio is not judged. [%]
    felt: float = 1.0
    # The inverse undoes the model but for this share of the range: beyond rounding it loses digits.
    round_trip: tuple[float, float] = (1e-9, 1e-6)
    # This share of the operators never moved in the fitted samples, so that their weights are open.
    undetermined: tuple[float, float] = (0.1, 0.5)
    # A fit is at its optimum if the residual of the conditions of Karush, Kuhn and Tucker is no larger. [relative]
    optimality: float = 1e-9

    # A part of which no log would show a smaller change than this is noise, not a line. [%]
    telling: float = 100.0


POLICY = LightPolicy()
