"""Which models were switched on: what each leaves unexplained of loops that it was not fitted to."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from dehyst.experiments.results import ACCEPTABLE, PlantResult, Reproduction
from dehyst.report.reproduction.numbers import (
    NO_HYSTERESIS,
    OFF,
    Spread,
    accepted_of,
    identification_figure,
    joints_of,
    left_off,
    listed,
    run_of,
    same_run,
    trials_of,
)
from dehyst.report.text import count, number, short

ACCEPTED, REFUSED = "accepted", "not accepted"


@dataclass(frozen=True)
class Cell:
    """What the table says of one joint of one plant: the unexplained share, and what followed from it."""

    share: str
    verdict: str
    good: bool


@dataclass(frozen=True)
class Acceptance:
    """The part of the page.

    Attributes
    ----------
    rule
        What is tested and where the limit lies.
    head
        Names of the columns.
    rows
        Plant -> one cell a joint, None for a joint that was not identified there.
    words
        What followed on the plants where a model was not accepted.
    """

    rule: str
    head: tuple[str, ...]
    rows: tuple[tuple[str, tuple[Cell | None, ...]], ...]
    words: tuple[str, ...]


def acceptance(result: Reproduction) -> Acceptance | None:
    """Return what was accepted, or None if that is not known of any model."""
    joints = joints_of(result)
    rows = tuple((short(p.plant, 40), tuple(_cell(p, j) for j in joints)) for p in result.plants.values())
    if not any(cell for _, cells in rows for cell in cells):
        return None
    rule = (
        "Before a compensator is switched on, its model is asked for loops that it was not fitted to. Shown is what it "
        "leaves unexplained: the standard deviation of measured hysteresis − inverse model, in percent of that of the "
        f"hysteresis. With more than {100 * ACCEPTABLE:.0f} % the compensator stays off."
    )
    if any(one.direct is not None for plant in result.plants.values() for one in plant.identifications.values()):
        rule += " Of a direct inverse only the terms without time count, and only loops: creep is no hysteresis."
    words = tuple(filter(None, (_consequence(result, plant, joints) for plant in result.plants.values())))
    return Acceptance(rule, tuple(f"joint {joint}" for joint in joints), rows, words)


def _cell(plant: PlantResult, joint: int) -> Cell | None:
    accepted, known = accepted_of(plant, joint)
    if not known:
        return None
    some = f"accepted in {accepted} of {count(known, 'seed')}"
    verdict = ACCEPTED if accepted == known else REFUSED if accepted == 0 else some
    return Cell(_percent(unexplained_of(plant, joint)), verdict, accepted == known)


def unexplained_of(plant: PlantResult, joint: int) -> Spread | None:
    """Return the unexplained share of unseen loops over the seeds."""
    found = identification_figure(plant, joint, "unexplained_unseen")
    if found is None and joint in plant.identifications:
        value = plant.identifications[joint].unexplained
        found = Spread(value, value, value, 1)
    return found


def _percent(found: Spread | None) -> str:
    if found is None:
        return "–"
    text = f"{number(100 * found.mean)} %"
    low, high = number(100 * found.low), number(100 * found.high)
    return text if found.seeds < 2 or low == high else f"{text} ({low}–{high})"


def _consequence(result: Reproduction, plant: PlantResult, joints: Sequence[int]) -> str:
    """Say plainly what it means that a model was not accepted; "" where all were."""
    off = [joint for joint in joints if left_off(plant, joint)]
    if not off:
        return ""
    which = f"joint{'s' if len(off) > 1 else ''} {listed(off)}"
    text = f"Plant {short(plant.plant, 40)}: the compensator of {which} was never switched on."
    if plant.plant == NO_HYSTERESIS:
        text += (
            " There is no hysteresis to compensate; what loops there are come from creep and viscosity, which a model "
            "without time does not explain."
        )
    if len(off) == len(joints) and _all_equal(result, plant):
        text += (
            " Its runs “without” and “with compensator” are therefore the same, equal to the last bit: no benefit is "
            "claimed there, and no harm was done."
        )
    return text


def _all_equal(result: Reproduction, plant: PlantResult) -> bool:
    pairs = [(run_of(plant, t, OFF), run_of(plant, t, result.compensator)) for t in trials_of(result)]
    complete = [(off, on) for off, on in pairs if off is not None and on is not None]
    return bool(complete) and all(same_run(off, on) for off, on in complete)
