"""Accept a new model only if it is better on cycles that it has not seen."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from dehyst.errors import DehystError
from dehyst.identification.drift.cycles import Cycle, groups_of, samples_of
from dehyst.identification.drift.design import Measured, Scale
from dehyst.identification.drift.parts import Subject
from dehyst.identification.drift.result import Acceptance
from dehyst.identification.drift.statistics import contrast
from dehyst.identification.fit import Fit
from dehyst.identification.procedure import identify
from dehyst.models import HysteresisModel, ModelCard
from dehyst.models.storage import model_to_dict
from dehyst.recording import Recording

Array = npt.NDArray[np.float64]

# Share of each log that the new model is fitted to.
FITTED = 0.5
# Probability of accepting a model that is no better, and the gain without which a change is not worth it.
LEVEL, WORTH = 0.01, 0.02
MOST_PAIRS, FEWEST_PAIRS = 16, 4
OPERATORS, EPS = 100, 0.001

Log = tuple[Recording, Sequence[Cycle], Measured | None]


def accept(subject: Subject, logs: Sequence[Log], scale: Scale) -> Acceptance:
    """Identify the family of a model anew on the first half of each log and compare both on the other half.

    The errors of both models are squared, averaged over groups of held-out cycles and compared group by group.
    """
    if not logs:
        return Acceptance(False, "no log is comparable, so nothing was identified; the old model stays")
    model = subject.model
    if not isinstance(model, HysteresisModel) or subject.backward:
        return Acceptance(
            False, f"a {model.family} model is identified anew by `dehyst identify` only; the old one stays"
        )
    try:
        fit = identify([record for record, _, _ in logs], train_fraction=FITTED, **_settings(model))
    except DehystError as fault:
        return Acceptance(False, f"no new model could be identified; the old one stays ({fault})")
    pairs = _pairs(fit, logs)
    if len(pairs) < FEWEST_PAIRS:
        return Acceptance(
            False,
            f"only {len(pairs)} cycles are held out, {FEWEST_PAIRS} are needed to compare two models; the old one "
            f"stays. Log more cycles.",
            fit.model,
            groups=len(pairs),
        )
    return _decide(model, fit, np.array(pairs), scale)


def _settings(model: HysteresisModel) -> dict[str, Any]:
    """Family and settings that a model was identified with; hostile ones are left to `identify` to refuse."""
    given = model.card.provenance
    listed = given.get("settings")
    settings: dict[str, Any] = listed if isinstance(listed, dict) else {}
    family = given.get("identified_family")
    kinds = {"pi": ("pi", "pi-cumulative")}.get(model.family, (model.family,))
    known = family if isinstance(family, str) and family in kinds else kinds[0]
    return {"family": known, "n": settings.get("n", OPERATORS), "eps": settings.get("eps", EPS)}


def _pairs(fit: Fit, logs: Sequence[Log]) -> list[tuple[float, float]]:
    """Mean squared errors of the old and the new model in each group of held-out cycles."""
    found = []
    share = max(1, MOST_PAIRS // len(logs))
    for (record, cycles, measured), mask, new in zip(logs, fit.test_masks, fit.predictions, strict=True):
        held = [cycle for cycle in cycles if mask[cycle.begin : cycle.end].all()]
        if measured is None or not held:
            continue
        for group in groups_of(held, share):
            place = samples_of(group)
            old = float(np.mean(measured.error[place] ** 2))
            found.append((old, float(np.mean((record.output - new)[place] ** 2))))
    return found


def _decide(model: HysteresisModel, fit: Fit, pairs: Array, scale: Scale) -> Acceptance:
    tested = contrast(pairs[:, 0] - pairs[:, 1])
    old, new = (100.0 * float(np.sqrt(np.mean(pairs[:, k]))) / scale.span for k in (0, 1))
    p_value = tested.p_value(0.0, sided=1)
    better = p_value < LEVEL and new < (1.0 - WORTH) * old
    numbers = (
        f"on {len(pairs)} groups of held-out cycles the new model errs by {new:.3g} % of range rms and the old one by "
        f"{old:.3g} % (p = {p_value:.2g})"
    )
    rule = f"accepted are gains of more than {100 * WORTH:g} % with p < {LEVEL:g}"
    reason = f"{numbers}: the new model is accepted" if better else f"{numbers}: the old model stays; {rule}"
    return Acceptance(better, reason, _signed(fit.model, model, reason), old, new, p_value, len(pairs))


def _signed(new: HysteresisModel, old: HysteresisModel, reason: str) -> HysteresisModel:
    """The new model, with what it replaces and why in its provenance."""
    provenance = dict(new.card.provenance)
    provenance["replaces"] = {"sha256": model_to_dict(old)["sha256"], "reason": reason}
    card: ModelCard = replace(new.card, provenance=provenance)
    return new.with_card(card)
