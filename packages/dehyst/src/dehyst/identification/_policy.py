"""The thresholds by which a family is chosen and a fit is judged: one record, each with its reason."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Policy:
    """Numbers and sets of findings that decide choice, findings and verdict.

    Percent are of the range of the signal, shares are between 0 and 1.
    """

    # The grade of a fit (docs/decisions/0025): output and inverse within this are good for compensation. [%]
    good_percent: float = 3.0
    # A model that misses by more than this is poor, and so is its compensator. [%]
    poor_percent: float = 10.0
    # A compensator that is off by a quarter of its range does harm. [%]
    inverse_misses: float = 25.0
    # An inverse that turns a two-thousandth of the output's range into the whole of the input's is of no use; the least
    # eps alone keeps it at half of that. [ratio of the ranges]
    useless_gain: float = 2e3
    # Nor is a model of an actuator that became another one: its loop moved by this share of the range.
    other_actuator: float = 0.25
    # Findings that keep a small error from being called good.
    serious: frozenset[str] = frozenset(
        {
            "rate-dependent", "drift", "mixed-loop", "few-loops", "small-test", "high-inverse-gain", "paper-bound",
            "recordings-differ", "swapped-columns", "output-stopped", "forward-better", "schedule-once",
        }
    )  # fmt: skip
    # Findings that forbid compensation where the inverse misses by more than `good_percent`.
    unusable: frozenset[str] = frozenset(
        {
            "output-unrelated", "poor-fit", "static-as-good", "inverse-misses", "never-turns", "inverse-useless",
            "two-actuators",
        }
    )  # fmt: skip
    # Findings that forbid it whatever the inverse misses of this log: on the next motion it does harm.
    harmful: frozenset[str] = frozenset(
        {"output-unrelated", "never-turns", "inverse-useless", "two-actuators"}
    )
    # Findings of drift say nothing where the output does not follow the input at all.
    drifts: frozenset[str] = frozenset({"drift", "two-actuators"})
    # Findings of reading that are counted again in what is fitted.
    few_loops: frozenset[str] = frozenset({"few-loops", "never-turns"})

    # What follows rate counts when it is no smaller than this share of the range ...
    rate_size: float = 0.007
    # ... what follows time when it is no smaller than this one ...
    drift_size: float = 0.02
    # ... and, of drift, so many standard errors. [standard errors]
    drift_certainty: float = 3.0
    # Of several inputs each must move by this share of itself while the others do not explain it. [share]
    inputs_apart: float = 0.05
    # A log of several inputs begins at rest unless its first samples are missed by so much more than the later ones: a
    # wrong past is a tenth of the range, several times what a model misses. [times the rms error]
    begins_elsewhere: float = 3.0
    # Held-out input that leaves the fitted range by this share is a test of extrapolation.
    beyond: float = 0.02
    # Recordings fitted together whose mean residuals differ by more than this share of the output's range do differ.
    levels_apart: float = 0.05
    # A peak of the residual's spectrum as small as this is rounding of a converter. [%]
    peak_size: float = 0.1
    # The output does not follow the input where, held out, its mean is nearer than model and curve, and of the fitted
    # samples the model leaves more than this share of the deviation.
    unrelated: float = 0.3
    # Held-out samples are worse when missed by so many times the error of the fitted ones ... [factor]
    worse: float = 5.0
    # ... and by this much. [%]
    worse_percent: float = 1.0
    # Held-out samples whose input covers less than this share of the fitted range hold no loops.
    small_test: float = 0.1

    # A curve without memory is as good as a model whose error is more than this share of the curve's.
    static_as_good: float = 0.95
    # A simpler family of plays is taken when its error is within this share of the best one.
    within_noise: float = 0.02
    # Cumulative slopes are bounded by nothing outside the fitted amplitudes: they must beat stops by this share.
    clearly_better: float = 0.15
    # Weights go with another signal only if that brings the error on held-out blocks below this share.
    schedule_worth: float = 0.98
    # The starts of pieces are estimated from so many short ones on, ... [pieces]
    pieces: int = 8
    # ... that have so many samples each, ... [samples]
    least_piece: int = 20
    # ... and taken where the error of pieces that are left out whole comes down to this share, ...
    starts_worth: float = 0.97
    # ... whose first part, this share of them, tells their start.
    first_part: float = 0.33
    # Starts and model are estimated in turn so often: the second time brings less than the first. [times]
    rounds_of_starts: int = 2
    # A butterfly is taken where its error on fitted samples is less than this share of what the best sum of elements
    # leaves on those left out: where it is one, this is 0.04 to 0.2 (docs/decisions/0072).
    butterfly_worth: float = 0.5
    # Where blocks hardly tell sums of elements apart, these have to beat plays by a quarter (docs/decisions/0048).
    clear: float = 0.75

    # The doubt of an error comes from so many consecutive parts of the scored samples, ... [parts]
    compared_blocks: int = 10
    # ... drawn anew so often with repetition; ... [times]
    redraws: int = 2000
    # ... the interval holds this share of the results, and two families tie where it reaches across.
    redraw_share: float = 0.9
    # Weights of a fit are drawn anew so often: the width of an interval is then certain to 7 %. [draws]
    interval_draws: int = 100
    # Errors are drawn in blocks so long that this share of the variance of their sums is lost across the ends, ...
    lost_variance: float = 0.05
    # ... but of fewer blocks than this the scatter says little, ... [blocks]
    fewest_interval_blocks: int = 10
    # ... and more than this say no more, and take longer. [blocks]
    most_interval_blocks: int = 100
    # A block without which less than this share of what is known of some unknown remains tells of it alone.
    told_elsewhere: float = 0.1
    # An interval is that of the draws that have such a value, if so many do.
    answering_draws: float = 0.9
    # A row of the table that errs so many times less on held-out samples than the chosen one is named. [factor]
    far_better: float = 3.0
    # Families whose errors differ by more than this are no tie, whatever part makes the difference. [factor]
    tied_ratio: float = 2.0
    # Two models whose answers differ by less than this share of the range are one.
    same_answer: float = 1e-9

    # The width of a loop is another one if it is so many times another's, beyond what the motion makes of it, ...
    # [factor]
    wider: float = 1.35
    # ... and differs by this share of the output's range; what sizes and speeds make of equal loops stays below
    # (tests/support/peculiar_logs.py).
    width_apart: float = 0.015
    # A gain is another one by the same rule: so many times another's, ... [factor]
    steeper: float = 1.08
    # ... and apart by this much.
    gain_apart: float = 0.03
    # A model whose answer at a tenth of the speed differs by so much deserves a warning. [%]
    other_speed: float = 1.0
    # Creep after the longest way of a log counts from this share of the output's range on. [%]
    beyond_rests: float = 2.0

    # A cause of the residual is named from this share of the squared residual on, ...
    named_cause: float = 0.1
    # ... beside the largest one, if so much of it no other cause explains; less cannot be told from the others.
    unshared_cause: float = 0.05
    # A cause is a rival of the largest one if it explains this share of what that one does.
    rival: float = 0.8
    # Noise that is this share of the squared residual leaves little for a better model.
    mostly_noise: float = 0.5

    # A peak in the spectrum of the residual is a resonance if it is so many times as high as what lies beside it: 25
    # and 60 on the rigs that have one, at most 5.5 on the others, ... [factor]
    resonance_peak: float = 7.0
    # ... if the squared swings are so many times as large while the input moves as while it rests (a hum does not
    # care), ... [factor]
    resonance_moves: float = 3.0
    # ... if its damping is below this one: beyond, a swing is over after one period, and corners need no shaping, ...
    # [damping]
    resonance_damping: float = 0.25
    # Frequency and damping come from how the output answers its own corners where that explains this share of a peak,
    # from the width of the peak elsewhere.
    resonance_explained: float = 0.5
    # ... and if its size is above this share of a step of the sensor.
    resonance_step: float = 0.3


POLICY = Policy()
