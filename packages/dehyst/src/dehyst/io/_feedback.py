"""Says that a log was taken in closed loop: a controller made the input from the output and a set point.

A fit of output over input takes the noise of the output for a cause, because the input answers to it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.findings import Finding
from dehyst.io._clocks import clock_names
from dehyst.io._policy import POLICY
from dehyst.io._table import LogTable
from dehyst.shell import command

# A law of six numbers needs no more samples, and every log that is read pays for them.
LOOKED_AT = 4000
CANDIDATES = 20  # columns
LAGS = 4  # samples of the error in a law: proportional, integral and derivative part, and one sample late


@dataclass(frozen=True)
class Feedback:
    """How a controller explains an input.

    Attributes
    ----------
    setpoint
        Column.
    explained
        Share of the variance of the changes of the input that follows from set point less output.
    reacts
        Share of it that the set point and the input's past leave open: that of the output's noise and disturbances.
    """

    setpoint: str
    explained: float
    reacts: float


def closed_loop_findings(
    table: LogTable, mask: npt.NDArray[np.bool_], x_name: str, y_name: str
) -> list[Finding]:
    """Return a finding if a column is the set point of a controller that makes the input from the output."""
    feedback = find_feedback(table, mask, x_name, y_name)
    if feedback is None:
        return []
    u = table.columns[x_name][mask]
    low, high = float(np.nanmin(u)), float(np.nanmax(u))
    line = command(
        "design",
        range=(f"{low:.3g}", f"{high:.3g}"),
        unit=table.label(x_name)[1] or None,
        out="command.csv",
    )
    return [
        Finding(
            "closed-loop",
            f"a controller made '{x_name}' from '{feedback.setpoint}' less '{y_name}': this explains "
            f"{100.0 * feedback.explained:.3g} % of its changes, and {100.0 * feedback.reacts:.2g} % of them answer "
            f"to what '{y_name}' does by itself, noise included. A fit takes that for a cause, and comes out biased. "
            f"Switch the controller off and log a motion that is planned before: {line}",
        )
    ]


def find_feedback(
    table: LogTable, mask: npt.NDArray[np.bool_], x_name: str, y_name: str
) -> Feedback | None:
    """Return the controller that made an input, None unless other explanations are excluded.

    Four things hold of a controller, and not of an actuator that is driven by a plan:

    - The changes of the input follow from set point less output, of the last samples, nearly without rest.
    - The set point alone, with the input's own past, leaves much of them open. (A plan that is logged twice, as command
      and as input, leaves nothing.)
    - The input opposes the output, while the output follows the input. (An output that answers within a sample explains
      the input too, with the other sign.)
    - The set point moves.
    """
    size = table.columns[x_name].size
    if table.columns[y_name].size != size or mask.size != size:
        return None
    u, y = table.columns[x_name][mask][:LOOKED_AT], table.columns[y_name][mask][:LOOKED_AT]
    clocks = set(clock_names(table))
    best = None
    names = [
        name
        for name, column in table.columns.items()
        if name not in (x_name, y_name) and name not in clocks and column.size == size
    ]
    for name in names[:CANDIDATES]:
        feedback = _feedback(u, y, table.columns[name][mask][:LOOKED_AT], name)
        if feedback is not None and (best is None or feedback.explained > best.explained):
            best = feedback
    return best


def _feedback(u: Array, y: Array, r: Array, name: str) -> Feedback | None:
    """Return the controller with this set point, None unless it is certain."""
    changes = np.diff(u)[LAGS - 1 :]
    error = _lagged(r - y)
    point = _lagged(r)
    before = np.column_stack([np.diff(u)[LAGS - 2 : -1], np.diff(u)[LAGS - 3 : -2]])
    ones = np.ones((changes.size, 1))
    usable = np.isfinite(np.column_stack([changes, error, point, before])).all(axis=1)
    if int(usable.sum()) < POLICY.law_samples or np.ptp(r[np.isfinite(r)]) == 0.0:
        return None
    law, left = _fitted(np.hstack([error, before[:, :1], ones])[usable], changes[usable])
    if not left <= POLICY.law_left:
        return None
    _, reacts = _fitted(np.hstack([point, before, ones])[usable], changes[usable])
    if reacts < POLICY.law_reacts:
        return None
    # What a step of the error makes of the input, over what the output does with it.
    answers = np.cumsum(law[:LAGS])
    opposes = float(answers[np.argmax(np.abs(answers))])
    both = np.isfinite(u) & np.isfinite(y)
    follows = float(np.mean((u[both] - u[both].mean()) * (y[both] - y[both].mean())))
    if opposes * follows <= 0.0:
        return None
    return Feedback(name, 1.0 - left, reacts)


def _lagged(values: Array) -> Array:
    """Return a row for each sample from the fourth on: it and those before."""
    size = values.size
    return np.column_stack([values[LAGS - k : size - k] for k in range(LAGS)])


def _fitted(columns: Array, target: Array) -> tuple[Array, float]:
    """Return coefficients, and the share of the variance that is left."""
    about = target - target.mean()
    total = float(about @ about)
    if total == 0.0:
        return np.zeros(columns.shape[1]), np.inf
    scale = np.maximum(np.abs(columns).max(axis=0), 1e-300)
    a = np.linalg.lstsq(columns / scale, target, rcond=None)[0] / scale
    rest = target - columns @ a
    return a, float(rest @ rest) / total
