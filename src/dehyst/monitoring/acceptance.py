"""Accept a new model only if it is better on cycles that it has not seen."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from dehyst.arrays import Array
from dehyst.errors import DehystError
from dehyst.families import identify
from dehyst.identification.direct.procedure import identify_direct
from dehyst.identification.fit import Fit
from dehyst.identification.plays import identify as identify_plays
from dehyst.identification.settings import AUTO
from dehyst.identification.split import end_of
from dehyst.models import ModelCard
from dehyst.models.storage import model_to_dict
from dehyst.monitoring.cycles import groups_of, samples_of
from dehyst.monitoring.design import Scale
from dehyst.monitoring.logs import Log
from dehyst.monitoring.parts import DIRECT, ELEMENTS, Parted, Subject, predict
from dehyst.monitoring.result import Acceptance
from dehyst.monitoring.statistics import contrast

# Share of each log that the new model is fitted to.
FITTED = 0.5
# Probability of accepting a model that is no better, and the gain without which a change is not worth it.
LEVEL, WORTH = 0.01, 0.1
MOST_PAIRS, FEWEST_PAIRS = 16, 4
OPERATORS, EPS = 100, 0.001
CUMULATIVE = ("pi", "pi-cumulative")
# What of a card's provenance tells how good the model is, on cycles that were held out.
JUDGED = ("test", "inverse", "verdict")


def accept(subject: Subject, logs: Sequence[Log], scale: Scale) -> Acceptance:
    """Identify the family of a model anew on the first half of each log and compare both on the other half.

    What is accepted is identified once more, from the whole of each log; what it is worth was told by the half.

    Both models run over the logs in the same way, from a past of their whole range. Their errors are squared, averaged
    over groups of held-out cycles and compared group by group.
    """
    if not logs:
        return Acceptance(False, "no log is comparable, so nothing was identified; the old model stays")
    try:
        fit = _identified(subject.model, logs, FITTED)
        pairs = _pairs(Subject.of(fit.model), logs)
    except DehystError as fault:
        return Acceptance(False, f"no new model could be identified; the old one stays ({fault})")
    if len(pairs) < FEWEST_PAIRS:
        return Acceptance(
            False,
            f"only {len(pairs)} cycles are held out, {FEWEST_PAIRS} are needed to compare two models; the old one "
            f"stays. Log more cycles.",
            fit.model,
            groups=len(pairs),
        )
    decision = _decide(fit.model, np.array(pairs), scale)
    if not decision.accepted:
        return decision
    try:
        whole = _identified(subject.model, logs, 1.0).model
    except DehystError as fault:
        return replace(decision, accepted=False, reason=f"{decision.reason}, but not by all of the log ({fault})")
    return replace(decision, model=_signed(whole, fit.model, subject.model, decision.reason))


def _identified(model: Parted, logs: Sequence[Log], share: float) -> Fit:
    """Fit the first part of each log with the settings of a model; hostile ones are refused by the identification."""
    records = [log.record for log in logs]
    listed = model.card.provenance.get("settings")
    settings: dict[str, Any] = listed if isinstance(listed, dict) else {}
    if model.core == DIRECT:
        known_signals = [name for name in model.needs if name in ("load", "mean_pressure")]
        signals: dict[str, Any] = {name: [log.given[name] for log in logs] for name in known_signals}
        times = settings.get("creep_times") or None
        return identify_direct(records, creep_times=times, train_fraction=share, **signals)
    if model.core == ELEMENTS:
        return identify(records, model.family, train_fraction=share)
    family = model.card.provenance.get("identified_family")
    kinds = {"pi": CUMULATIVE, "sheared-pi": CUMULATIVE}.get(model.family, (model.family,))
    known = family if isinstance(family, str) and family in kinds else kinds[0]
    n, eps = settings.get("n", OPERATORS), settings.get("eps", EPS)
    if settings.get("eps_by") or (known == "pi" and settings.get("family", known) != "pi"):
        eps = AUTO  # chosen again; the bound of a family that `auto` chose is relative, and that of "pi" is not
    limit = settings.get("max_inverse_gain")
    bound = {"eps": eps} if limit is None else {"max_inverse_gain": limit}  # which sets eps
    return identify_plays(records, known, n=n, train_fraction=share, shear=model.shear, **bound)


def _pairs(renewed: Subject, logs: Sequence[Log]) -> list[tuple[float, float]]:
    """Mean squared errors of the old and the new model in each group of held-out cycles."""
    found = []
    share = max(1, MOST_PAIRS // len(logs))
    for log in logs:
        split = end_of(len(log.record), FITTED)
        held = [cycle for cycle in log.cycles if cycle.begin >= split]
        if log.measured is None or not held:
            continue
        missed = log.measured.response - predict(renewed, log.record, log.given).response
        for group in groups_of(held, share):
            place = samples_of(group)
            found.append((float(np.mean(log.measured.error[place] ** 2)), float(np.mean(missed[place] ** 2))))
    return found


def _decide(new_model: Parted, pairs: Array, scale: Scale) -> Acceptance:
    tested = contrast((pairs[:, 0] - pairs[:, 1]) / max(float(np.max(pairs)), 1e-300))  # of any size
    old, new = (100.0 * float(np.sqrt(np.mean(pairs[:, k]))) / scale.span for k in (0, 1))
    p_value = tested.p_value(0.0, sided=1)
    better = p_value < LEVEL and new < (1.0 - WORTH) * old
    numbers = (
        f"on {len(pairs)} groups of held-out cycles the new model errs by {new:.3g} % of range rms and the old one by "
        f"{old:.3g} % (p = {p_value:.2g})"
    )
    rule = f"accepted are gains of more than {100 * WORTH:g} % with p < {LEVEL:g}"
    if new < (1.0 - WORTH) * old:
        rule += ". So few cycles, or so different ones, do not confirm it: log more (dehyst design --for drift)"
    reason = f"{numbers}: the new model is accepted" if better else f"{numbers}: the old model stays; {rule}"
    return Acceptance(better, reason, new_model, old, new, p_value, len(pairs))


def _signed(new: Parted, judged: Parted, old: Parted, reason: str) -> Parted:
    """The new model, with what its family was judged by, what it replaces and why in its provenance."""
    provenance = dict(new.card.provenance)
    provenance |= {key: judged.card.provenance[key] for key in JUDGED if key in provenance}
    provenance["replaces"] = {"sha256": model_to_dict(old)["sha256"], "reason": reason}
    card: ModelCard = replace(new.card, provenance=provenance)
    return new.with_card(card)
