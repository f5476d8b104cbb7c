"""The thresholds by which fits are chosen and a late output is reported: one record, each with its reason."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class FamilyPolicy:
    """Numbers that decide the choice among rows and among start states, and what a person reads about a shift.

    Shares are between 0 and 1; of an error they are shares of the error that the other candidate leaves.
    """

    # With fewer turns of the input the rows with many groups follow the one loop that was seen. [turns]
    enough_turns: int = 3
    # A turn counts when the input moves by a tenth of its range behind it. [half ranges]
    swing: float = 0.2
    # Products of lags fit much that only this one log shows: their error must come down to this share.
    worth_of_products: float = 0.85
    # A smaller model wins where its error on what is left out is within this of the least one: less is chance. [times
    # the least error]
    smaller_model: float = 1.03
    # Terms are taken out of a sum as long as it differs from the full one by a quarter of its own error on what is left
    # out: both together are 3 % more than that error alone.
    reduction: float = 0.25
    # A wrong start state may fit a little better by chance: another one than the first must come down to this share.
    better_start: float = 0.98
    # Friction may fit a short log better from a wrong start, with elements so long that they never settle: another
    # start than the usual one must come down to this share.
    friction_start: float = 0.9
    # A range is of one sign where no more than this share of it lies on the other side of input 0.
    one_sided: float = 0.05
    # A transform of the input is taken where a plain sum behind it errs so much less on what is left out than the best
    # row of all without one: on rigs that have none the least was 0.86. [times the error of the best row]
    input_transform: float = 0.85
    # One more element of friction must bring the error down to this share.
    friction_element: float = 0.95
    # Another start state or sign of Preisach's masses must come down to this share.
    preisach_start: float = 0.98
    # An inverse with a lower gain may cost so much of the accuracy. [times the error of the fit]
    affordable_gain: float = 1.03

    # Behind a turn the output stands still as long as its slope is less than this share of that of the loop ...
    dead_slope: float = 0.1
    # ... and that is a dead band from this share of the input's range on.
    dead_least: float = 0.01

    # A butterfly is seen in strokes over most of the input's range: 1.2 of its 2 half ranges, ... [half ranges]
    butterfly_stroke: float = 1.2
    # ... of which there are three, so that either way is seen and one of them twice, ... [strokes]
    butterfly_strokes: int = 3
    # ... where the output turns by a twentieth of its range: less is noise, or a map that is hardly bent. [half ranges]
    butterfly_depth: float = 0.1

    # Sums are fitted to shifted signals only if the first shift promises to remove this share of the squared error.
    promised_error: float = 0.1
    # An output counts as late when the shift brings the error down to this share ...
    late_error: float = 0.85
    # ... and as early, which rate dependence can look like, when it comes down to this share.
    early_error: float = 0.7
    # Differences between neighbours, and stamps at either end of a period, shift a signal by one. [samples]
    least_shift: int = 2


POLICY = FamilyPolicy()
