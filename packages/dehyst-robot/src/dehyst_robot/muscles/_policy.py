"""The thresholds by which the fit of a muscle is judged: one record, each with its reason."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class MusclePolicy:
    """Numbers that decide which samples of a bench log count, and which findings a fit gets."""

    # A muscle hangs loose below this share of the largest force: its force then shows nothing of the model.
    slack: float = 0.005
    # A fit needs this many samples at least. [samples]
    fewest: int = 6
    # A force that varies less than this share of its largest value shows no dependence on anything.
    flat: float = 1e-6
    # A rms error above this means that the model does not fit: the best models leave less of any muscle. [% of the
    # range of force]
    poor_percent: float = 5.0
    # A log that reaches less than this share of the contractions up to the free one leaves the rest to the formula.
    covered: float = 0.8
    # A pressure that varies less than this share of its highest value counts as constant.
    same_pressure: float = 0.02
    # A combination of parameters whose singular value, of scaled slopes, is below this share of the largest one is not
    # determined by the log ...
    dependent: float = 1e-7
    # ... and a parameter that has at least this part in such a combination is not determined either.
    mixed: float = 0.05


POLICY = MusclePolicy()
