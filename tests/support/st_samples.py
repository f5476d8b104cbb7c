"""What is exported as Structured Text: every kind of block and controller, in both precisions."""

import functools

import numpy as np

import dehyst
from dehyst.export import subject_of
from dehyst_targets import st as target
from direct_export_samples import direct_model
from element_samples import element_model, random_elements, scheduled_model
from export_samples import CARD, MODELS, play_model


@functools.cache
def subjects():
    """Every kind of block in both precisions, with loops of one round, by the names of their types."""
    made = []
    single = dehyst.PrandtlIshlinskii([0.0], [1.5], card=CARD)
    dead = dehyst.PrandtlIshlinskii([0.2, 0.5], [1.0, 0.4], card=CARD)
    blocks = {name: make() for name, make in MODELS.items()} | {"single": single}
    blocks |= {
        "elements": element_model(),
        "scheduled": scheduled_model(),
        "start": element_model(start="rising"),
    }
    directs = {
        "direct": direct_model(schedules=3), "plain": direct_model(stops=1, paths=0, creeps=1, schedules=0),
        "strokes": direct_model(stops=3, paths=2, creeps=1, schedules=0, past="rising"),
        "known": direct_model(stops=0, paths=1, creeps=0, past="rest", coefficients=1),
    }  # fmt: skip
    for real in ("double", "float"):
        given = {"real": real}
        for direction in ("forward", "inverse"):
            for name, model in blocks.items():
                made.append(
                    subject_of(model, direction, name=f"{name}_{direction}_{real}", **given)
                )
            followed = {"follow_offset": 0.1, "name": f"offset_{direction}_{real}"}
            made.append(subject_of(play_model(), direction, **followed, **given))
        made.append(subject_of(dead, "forward", name=f"dead_{real}", **given))
        for name, model in directs.items():
            made.append(subject_of(model, name=f"{name}_{real}", period=1e-3, **given))
    made.append(subject_of(element_model(), name="retained", retain=True))
    rng = np.random.default_rng(7)
    made += [subject_of(random_elements(rng), name=f"random_{k}") for k in range(6)]
    return {target.block_name(subject): subject for subject in made}
