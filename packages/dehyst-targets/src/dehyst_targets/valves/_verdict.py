"""Says whether a valve sticks, how sure that is, and what to log where the record cannot tell."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from dehyst.arrays import Array
from dehyst.errors import ColumnError
from dehyst.findings import Finding, Grade
from dehyst_targets.valves._fit import ValveEstimate, ValveFit, fit_valve
from dehyst_targets.valves._loop import ControlLoop, exchanged, explained_share
from dehyst_targets.valves._policy import POLICY

STICKS, NO_SIGN, UNKNOWN = "sticks", "no sign", "not identifiable"
RUNS = (6, -5, 7, -8, 5, -6, 8, -7, 4, -6, 7, -5)  # steps up and down of the test in manual


@dataclass(frozen=True, eq=False)
class ValveVerdict:
    """What a record of a control loop says of its valve.

    Attributes
    ----------
    kind
        ``"sticks"``, ``"no sign"`` or ``"not identifiable"``.
    grade
        How far the numbers can be trusted.
    dead_band, jump
        S and J with intervals of 95 %: those of the best sticking valve, whatever the kind. [% of controller output]
    excluded_above
        Where there is no sign: dead bands above this are excluded. [% of controller output]
    mode
        ``"automatic"``, ``"manual"`` or ``"unclear"``, by whether a controller explains its output.
    reason
        Why it is not identifiable, or usable with care only; "" otherwise.
    fit, loop
        What it rests on.
    explained
        Share of the changes of the controller output that a controller explains; None without a measurement.
    findings
        Of reading and of the record.
    """

    kind: str
    grade: Grade
    dead_band: ValveEstimate
    jump: ValveEstimate
    excluded_above: float
    mode: str
    reason: str
    fit: ValveFit
    loop: ControlLoop
    explained: float | None
    findings: tuple[Finding, ...]

    @property
    def words(self) -> str:
        """The verdict on one line."""
        if self.kind == NO_SIGN:
            above = (
                f"a dead band above {self.excluded_above:.2g} % of controller output is excluded"
            )
            return f"no sign of stiction: {above}"
        if self.kind == UNKNOWN:
            return f"not identifiable: {self.reason}"
        name = "stiction"
        if self.jump.low < POLICY.least_jump * self.dead_band.value:
            name = "dead band, perhaps with a jump"
            if self.jump.high < POLICY.no_jump * self.dead_band.value:
                name = "dead band without a jump"
        return f"{name}: S = {_with_interval(self.dead_band)} of controller output, J = {_with_interval(self.jump)}"

    def as_dict(self) -> dict[str, Any]:
        """Return everything as plain values, as ``dehyst valve --json`` prints it."""
        evidence = self.fit.evidence
        controller = None
        if self.explained is not None:
            controller = {"explained": self.explained}
        return {
            "format": "dehyst-valve",
            "kind": self.kind,
            "grade": str(self.grade),
            "verdict": self.words,
            "reason": self.reason,
            "dead_band_percent": self.dead_band.as_dict(),
            "jump_percent": self.jump.as_dict(),
            "excluded_above_percent": self.excluded_above,
            "mode": self.mode,
            "answer": _answer(self.loop),
            "swing_percent": self.fit.swing,
            "period_s": self.fit.period * self.loop.period,
            "cycles": self.fit.cycles,
            "evidence": {
                "over_linear": evidence.over_linear,
                "over_periodic": evidence.over_periodic,
                "steadiness": evidence.steadiness,
            },
            "controller": controller,
            "warnings": [finding.as_dict() for finding in self.findings],
        }


def _with_interval(estimate: ValveEstimate) -> str:
    return f"{estimate.value:.2f} % ({estimate.low:.2f} to {estimate.high:.2f})"


def _answer(loop: ControlLoop) -> str:
    if loop.position is not None:
        return "position"
    return "measurement"


def judge_valve(loop: ControlLoop, *, seed: int = 0) -> ValveVerdict:
    """Say whether the valve of a control loop sticks, and how much.

    A valve with dead band S and jump J (`valve_positions`) in front of a linear process is fitted to what answered. It
    sticks if this explains the record better than a valve that follows, in nearly every part of the record, and better
    than a valve that follows with an external disturbance of one period. Intervals are of a block bootstrap over parts
    of about a cycle.

    Parameters
    ----------
    loop
        The record, of `read_control_loop` or `ControlLoop.of`. If it has a position, that is what answers.
    seed
        Of the bootstrap.

    Raises
    ------
    ColumnError
        If another order of the columns is certainly the right one.

    Examples
    --------
    >>> from dehyst_targets.valves import ControlLoop, judge_valve, valve_positions
    >>> rng = np.random.default_rng(0)
    >>> op = 50 + 0.8 * np.convolve(rng.normal(size=1600), np.ones(30), "valid")[:1500]
    >>> position = valve_positions(op, np.array([4.0]), np.array([2.0]))[:, 0] + 0.1 * rng.normal(size=1500)
    >>> verdict = judge_valve(ControlLoop.of(op, position=position))
    >>> verdict.kind, abs(verdict.dead_band.value - 4.0) < 0.2
    ('sticks', True)
    """
    wrong = exchanged(loop)
    if wrong:
        raise ColumnError(f"of {loop.name} {wrong}")
    answer = loop.measurement
    if loop.position is not None:
        answer = loop.position
    assert answer is not None
    fit = fit_valve(loop.output, answer, measured_directly=loop.position is not None, seed=seed)
    explained = None
    if loop.measurement is not None:
        explained = explained_share(loop.output, loop.measurement, loop.setpoint)
    mode = _mode(explained)
    kind, grade, reason = _judged(fit, mode, loop.position is not None)
    return ValveVerdict(
        kind,
        grade,
        fit.dead_band,
        fit.jump,
        fit.unseen,
        mode,
        reason,
        fit,
        loop,
        explained,
        (*loop.findings, *_about_ends(loop.output)),
    )


def _mode(explained: float | None) -> str:
    """Whether the controller was in automatic: its output follows from the measurement."""
    if explained is None:
        return "unclear"
    if explained >= POLICY.certain_law:
        return "automatic"
    if explained < POLICY.no_law:
        return "manual"
    return "unclear"


def _judged(fit: ValveFit, mode: str, is_position: bool) -> tuple[str, Grade, str]:
    """Return kind, grade and reason."""
    evidence, swing = fit.evidence, fit.swing
    if fit.cycles < POLICY.fewest_cycles:
        return (
            UNKNOWN,
            Grade.BAD,
            f"the controller output swings {fit.cycles:g} times, and {POLICY.fewest_cycles:g} are needed to see what "
            f"repeats",
        )
    is_better = evidence.over_linear > POLICY.certain and evidence.steadiness > POLICY.steady
    if not is_better:
        if fit.unseen <= POLICY.seen * swing and evidence.over_linear < POLICY.certain:
            return NO_SIGN, Grade.GOOD, ""
        return (
            UNKNOWN,
            Grade.BAD,
            f"a valve that follows explains the record as well as one that sticks, and dead bands up to "
            f"{fit.unseen:.2g} % of controller output are not excluded",
        )
    dead_band = fit.dead_band
    if not is_position and mode != "manual":
        if evidence.over_periodic < POLICY.certain:
            return (
                UNKNOWN,
                Grade.BAD,
                "an external disturbance of one period explains the record as well as a valve that sticks",
            )
        if dead_band.value < POLICY.causes * swing:
            return (
                UNKNOWN,
                Grade.BAD,
                f"a dead band of {dead_band.value:.2g} % is small against the swing of the controller output, "
                f"{swing:.2g} %, so that something else swings the loop, and irregular disturbances look alike",
            )
    if dead_band.high - dead_band.low > POLICY.wide * dead_band.value:
        return STICKS, Grade.CARE, "the interval is wide"
    if is_position and not _agrees(fit):
        return (
            STICKS,
            Grade.CARE,
            "the position does not show the moves of this valve clearly, and the intervals may be too narrow",
        )
    if not is_position and mode != "manual":
        # Simulated disturbances from outside passed for stiction in a few loops.
        return (
            STICKS,
            Grade.CARE,
            "confirm it by a test in manual, or log the position of the valve",
        )
    return STICKS, Grade.GOOD, ""


def _agrees(fit: ValveFit) -> bool:
    """Whether dead band and jump that were read off the moves of the position are about those that were fitted."""
    if fit.read_off is None:
        return False
    fitted = np.array([fit.dead_band.value, fit.jump.value])
    apart = np.abs(np.array(fit.read_off) - fitted)
    return bool(apart.max() <= POLICY.agrees * fit.dead_band.value)


def _about_ends(output: Array) -> tuple[Finding, ...]:
    """Return a finding if the controller output stood at an end of its span."""
    share = float(np.mean((output <= 0.0) | (output >= 100.0)))
    if share < POLICY.saturated:
        return ()
    return (
        Finding(
            "valve-saturated",
            f"the controller output stands at an end of its span in {100.0 * share:.0f} % of the samples: there the "
            f"valve is not moved, and tells nothing. Export a time in which the loop works within its span.",
        ),
    )


def step_test(verdict: ValveVerdict) -> tuple[Array, Array]:
    """Return time and controller output of a test in manual: steps up and down with rests, in runs of unlike length.

    After a turn a sticking valve leaves out the first steps, and a linear process answers to each of them. Ramps of one
    length would not do: a lag rounds off their turns as a dead band does. A step is a third of the dead band that the
    record does not exclude.

    Parameters
    ----------
    verdict
        Of the record in automatic.

    Returns
    -------
    time, output : numpy.ndarray
        (T,) each. [s], [% of controller output]

    Examples
    --------
    >>> rng = np.random.default_rng(0)
    >>> op = 50 + 8 * np.sin(np.arange(600) / 12) + rng.normal(size=600)
    >>> time, output = step_test(judge_valve(ControlLoop.of(op, position=op)))
    >>> bool(output[0] == output[-1]), time.size > 600
    (True, True)
    """
    loop, fit = verdict.loop, verdict.fit
    step = max(fit.dead_band.high, POLICY.least_test) / POLICY.test_steps
    places = step * np.concatenate(([0], np.cumsum(_steps())))
    swing = float(np.ptp(places))
    if swing > 100.0:
        places, swing = places * 100.0 / swing, 100.0
    low = float(np.clip(np.median(loop.output), 0.5 * swing, 100.0 - 0.5 * swing)) - 0.5 * swing
    rest_samples = max(round(POLICY.test_rest * fit.period), 3)
    output = np.repeat(low + places - places.min(), rest_samples)
    return np.asarray(loop.period * np.arange(output.size)), np.asarray(output)


def _steps() -> Array:
    """Return 1 or -1 for each step."""
    return np.concatenate([np.full(abs(run), float(np.sign(run))) for run in RUNS])
