"""The thresholds by which a change is told, a log refused and a model replaced: one record, each with its reason."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class MonitoringPolicy:
    """Numbers that decide what is said of a saved model on new logs.

    Percent are of the range of the signal, shares are between 0 and 1.
    """

    # A log must cover this share of the identified range: loops of another size show other parts of the hysteresis ...
    covered_share: float = 0.8
    # ... and may go beyond it by this share of it: further out the model only extrapolates.
    drift_beyond: float = 0.1
    # Groups of cycles without which no scatter between them can be told. [groups]
    fewest_groups: int = 4
    # Share of the response's variance that the model and its parts must explain.
    explained: float = 0.5
    # A log of so many cycles is long: it tells how the actuator was, and how it is now ... [cycles]
    long_log: int = 48
    # ... in its last part, this share of it.
    now_share: float = 0.25
    # Drives that differ no more than this share in size ...
    alike_size: float = 0.15
    # ... and not by more than this in speed are alike. [factor]
    alike_speed: float = 1.5
    # Groups of cycles whose drives scatter within this share of each other were moved alike, and are compared in pairs.
    same_motion: float = 0.05

    # A part of the model whose variance is raised by more than this by the others cannot be told from them ... [factor]
    inflation: float = 100.0
    # ... and so cannot a part that the model lacks, which needs clearer evidence. [factor]
    inflation_lacked: float = 10.0

    # Smallest change worth a word: rms of what it does. [%]
    least_change: float = 0.1
    # "Unchanged" is said only where every part would have shown a change that does this, rms. A change that is not
    # worth a word cannot be asked for: where `least` is given, twice that, if it is more. [%]
    bound: float = 1.0
    # And only where the error has not doubled, nor may have for all that the scatter tells. [% more]
    doubled: float = 100.0
    # Without a reference a model's own error may look like a change: by this share of it ...
    own_share: float = 1.0
    # ... and by this one for the offset, which every fit brings to zero.
    offset_share: float = 0.5
    # Rest and error may grow by this against a reference that was moved alike ... [factor]
    rest_growth: float = 1.25
    # ... and by this against another motion, or against the error that the card names. [factor]
    rest_growth_card: float = 1.5

    # A new model is fitted to this share of each log and compared on the others.
    refit_share: float = 0.5
    # Probability of accepting a new model that is no better.
    refit_level: float = 0.01
    # Gain as a share of the old error without which a change of the model is not worth it.
    refit_worth: float = 0.1

    # With fewer turns of the input not even one loop was closed. [turns]
    few_turns: int = 3
    # A log that is evaluated may leave the identified range by this share of it without a word.
    evaluated_beyond: float = 0.02
    # Pasts shift the output by this much before it is said: a third of what is good for compensation. [%]
    shifts: float = 1.0
    # A bias is a constant, as that of a sensor's zero, where what is left without it is smaller than this share of it.
    constant_bias: float = 0.5
    # This share of a piece tells its past, where it is to be told by the log itself.
    telling: float = 0.1


POLICY = MonitoringPolicy()
