"""Sums of elements for tests of blocks and exports: of every kind, and random ones that rise."""

import numpy as np

from dehyst.families import Scaling
from dehyst.families._elements import KINDS, Element, ElementModel
from dehyst.models import ModelCard, SignalCard

CARD = ModelCard(
    SignalCard("voltage", "V", -1.0, 3.0),
    SignalCard("travel", "mm", -4.0, 5.0),
    {"verdict": "good for compensation"},
)
SCALING = Scaling(1.0, 2.0, 0.5, 4.0)
MAP = ((-1.0, 0.0, 1.5), (-1.2, 0.0, 2.0))


def element_model(direction="forward", **changes):
    """An element of each kind, two maps and a dead time."""
    example = ElementModel.example()
    told = {
        "elements": example.elements, "before_map": MAP, "after_map": (MAP[1], MAP[0]), "dead_time": 0.06,
        "period": 0.02, "direction": direction, "scaling": SCALING, "start": "zero", "card": CARD,
    }  # fmt: skip
    return ElementModel(**(told | changes))


def scheduled_model(direction="forward", sources=(-1, 0, 1)):
    """Plays whose weights depend on up to three signals."""
    plays = tuple(
        Element("play", 0.1 * (k + 1), weight=0.1, schedule=k + 1) for k in range(2 * len(sources))
    )
    schedules = tuple((source, -1.0 - k, 2.0 + k) for k, source in enumerate(sources))
    return element_model(
        direction, elements=(Element("input", weight=0.7), *plays), schedules=schedules
    )


def random_elements(rng):
    """A random sum that rises: kinds, sizes, maps, schedules, start, direction, scaling."""
    while True:
        schedules = tuple(
            (int(rng.integers(-1, 3)), float(rng.uniform(-2, 0)), float(rng.uniform(0.1, 2)))
            for _ in range(rng.integers(0, 3))
        )
        elements = [Element("input", weight=float(rng.uniform(0.4, 1.0)))]
        for _ in range(rng.integers(1, 9)):
            kind = KINDS[rng.integers(len(KINDS))]
            u = np.sort(rng.uniform(-1, 1, 4))
            bend = (
                (tuple(u), tuple(np.cumsum(rng.uniform(0, 0.2, 4))))
                if rng.random() < 0.4
                else ((), ())
            )
            elements.append(
                Element(
                    kind, float(rng.uniform(0.02, 0.8)),
                    float(rng.uniform(0.0, 0.02)) if kind == "wide" else float(10 ** rng.uniform(-2, 1.5)),
                    float(rng.uniform(0.02, 0.3)), bend, int(rng.integers(0, 2 * len(schedules) + 1)),
                )
            )  # fmt: skip
            if kind == "product":  # the lag it reads
                elements.append(Element("past", 0.0, float(10 ** rng.uniform(-2, 1.5)), 0.02))
        bends = [((-1.0, float(rng.uniform(-0.3, 0.3)), 1.0), (-1.0, 0.1, 1.3)) if rng.random() < 0.5 else ((), ())
                 for _ in range(2)]  # fmt: skip
        direction = ("forward", "inverse")[rng.integers(2)]
        model = ElementModel(
            tuple(elements), float(rng.normal()), *bends, "forward", 0.01 * int(rng.integers(0, 4)), 0.01, schedules,
            "elements", Scaling(float(rng.normal()), 2.0, float(rng.normal()), float(rng.choice([3.0, -0.5]))),
            str(rng.choice(["rest", "zero", "rising", "falling", "origin"])),
        )  # fmt: skip
        if model.least_slope > 0.05:
            low, high = model.scaling.center - 2.0, model.scaling.center + 2.0
            card = ModelCard(SignalCard("u", "V", low, high), SignalCard("y", "mm", -1.0, 1.0))
            return ElementModel(**{**vars_of(model), "direction": direction, "card": card})


def vars_of(model):
    """The fields of a model by name."""
    return {name: getattr(model, name) for name in model.__dataclass_fields__}
