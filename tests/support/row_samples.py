"""A small model of each row that `auto` can choose, as units for tests of targets."""

from dataclasses import replace
from functools import cache

from dehyst.export import subject_of
from dehyst.families import ROWS
from dehyst.families._rows import sample
from direct_export_samples import direct_model
from element_samples import CARD, MAP
from export_samples import mapped_model, play_model, stop_model

PLAYS = {"pi": play_model, "modified-pi": mapped_model, "stop": stop_model}
CHOSEN = (*PLAYS, *(row.name for row in ROWS if row.chosen != "never"), "direct-inverse")


RINGS = (
    "full-sum",
    "inverse-stop-rate",
)  # one that is solved, and one that is evaluated, shape their reference


def of_row(row):
    """A model of a row of the table, with a map where it can have one."""
    model = replace(sample(row), card=CARD, after_map=MAP if True in row.sums[0].maps else ((), ()))
    if row.name in RINGS:
        model = replace(model, resonance=(0.1 / model.period, 0.05))
    return model


@cache
def models():
    """Name of what `auto` can choose, and a direct inverse -> model."""
    rows = {row.name: of_row(row) for row in ROWS if row.name in CHOSEN}
    return {
        **{name: make() for name, make in PLAYS.items()},
        **rows,
        "direct-inverse": direct_model(),
    }


def use_of(name):
    """What it is exported as: what is chosen to simulate alone as it is, all others as what drives an actuator."""
    return (
        "forward" if name in {row.name for row in ROWS if row.chosen == "simulate"} else "inverse"
    )


@cache
def units(real="double"):
    """Each of them in its use: C name -> subject."""
    made = {}
    for name, model in models().items():
        word, period = (
            f"row_{name}".replace("-", "_"),
            {"period": 0.004} if name == "direct-inverse" else {},
        )
        made[word] = subject_of(model, use_of(name), name=word, real=real, ramp=40, **period)
    return made
