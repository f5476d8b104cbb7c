"""Blocks and signals whose steps cost the most, and the straight lines over n that none of them crosses."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt
from scipy.optimize import linprog

from dehyst import PrandtlIshlinskii
from dehyst.export import UnitNumbers
from dehyst.export._units import block_in, block_numbers
from dehyst.families._elements import KINDS, LAGS, Element, ElementModel
from dehyst.models import Block, DirectInverse, ModelCard, Schedule, SignalCard
from target.jobs import Array, Case

FAR = 1e4
# Of 10 and of 40 elements, as benchmarks/elements.c: kind, how many, how many of them with a map, radius, time, weight.
MIX = (
    ("input", (1, 1), (1, 1), 0.0, 0.0, 0.5),
    ("play", (3, 16), (1, 6), 0.8, 0.0, 0.5),
    ("stop", (1, 8), (0, 2), 0.4, 0.0, 0.2),
    ("creep", (1, 5), (1, 2), 0.1, 0.5, 0.2),
    ("relax", (1, 4), (0, 2), 0.1, 0.5, 0.1),
    ("past", (1, 2), (0, 0), 0.1, 0.5, 0.1),
    ("path", (1, 2), (0, 0), 0.3, 0.0, 0.1),
    ("wide", (1, 2), (0, 0), 0.3, 0.005, 0.1),
)
MIXED = (10, 40)


def inverse(n: int, real: str) -> UnitNumbers:
    """Return the inverse of n operators with thresholds 0 .. 1, far from any limit."""
    weights = np.concatenate([[1.0], 0.5 + 0.5 * np.cos(np.arange(n - 1))]) / n
    model = PrandtlIshlinskii(np.linspace(0.0, 1.0, n), weights)
    numbers = block_numbers(Block(model, range=(-FAR, FAR), ramp=20))
    return block_in(numbers, real)


def held(numbers: UnitNumbers, real: str) -> UnitNumbers:
    """Return the same with an output limit that is met when about half of the operators are on their way."""
    limit = 0.5 * (numbers.model.loading[-1] + numbers.model.slope[-1]) + 1e-3
    limits = {"output_low": -limit, "output_high": limit, "reach_low": -limit, "reach_high": limit}
    return block_in(replace(numbers, **limits), real)


def beyond(numbers: UnitNumbers, real: str) -> UnitNumbers:
    """Return the same where every output is beyond the limit: the way back is searched to its end at every step."""
    far = {
        "output_low": -2.0 * FAR,
        "output_high": -FAR,
        "reach_low": -2.0 * FAR,
        "reach_high": -FAR,
    }
    return block_in(replace(numbers, **far), real)


def with_maps(numbers: UnitNumbers, points: int) -> UnitNumbers:
    """Return the same with a map in front of the operator and one behind it."""
    u = tuple(float(x) for x in np.linspace(-FAR, FAR, points))
    return replace(numbers, model=replace(numbers.model, before=(u, u), after=(u, u)))


def turns(numbers: UnitNumbers) -> Array:
    """Return inputs that drag all operators, then every number of them the other way, in both directions."""
    r = np.asarray(numbers.model.threshold)
    top = 2.0 * r[-1] + 1.0
    edges = np.concatenate([[0.0], 0.5 * (r[1:] + r[:-1]) * 2.0, [2.0 * r[-1] + 0.5]])
    chosen = np.unique(
        np.concatenate([np.arange(min(6, r.size)), np.linspace(0, r.size, 8)]).astype(int)
    )
    one_way = np.column_stack([np.full(chosen.size, top), top - edges[chosen]]).ravel()
    return np.concatenate([one_way, -one_way])


def pushes(numbers: UnitNumbers) -> Array:
    """Return inputs far beyond the limit, each after a way back that dragged another number of operators."""
    x = turns(numbers)
    top = np.max(np.abs(x))
    return np.column_stack(
        [np.where(x > 0, 50.0 * top, -50.0 * top), x * 0.5, np.sign(x) * 50.0 * top]
    ).ravel()


def loops(numbers: UnitNumbers, samples: int = 200) -> Array:
    """Return a slow signal: nested loops of 50 samples each that shrink to a fifth."""
    k = np.arange(samples)
    top = 1.5 * numbers.model.threshold[-1] + 0.5
    return top * (1.0 - 0.8 * k / samples) * np.sin(2.0 * np.pi * k / 50.0)


def cases(n: int, real: str) -> dict[str, Case]:
    """Return signals by name: slow "loops", steps that move "none" or "all", "free" ones that move any number of
    operators, "held" at a limit, "beyond" it from the start on, and all that while "switched" on and off."""
    numbers = inverse(n, real)
    rng = np.random.default_rng(n)
    top = 2.0 * numbers.model.threshold[-1] + 1.0
    free, limited = turns(numbers), pushes(numbers)
    random = rng.uniform(-1.5 * top, 1.5 * top, 30)
    return {
        "loops": _on(numbers, loops(numbers)),
        "none": _on(numbers, np.zeros(4)),
        "all": _on(numbers, np.tile([top, -top], 4)),
        "free": _on(numbers, np.concatenate([free, random])),
        "held": _on(held(numbers, real), np.concatenate([limited, random])),
        "beyond": Case(
            beyond(numbers, real),
            np.concatenate([free, random]),
            _toggled(rng, free.size + random.size),
        ),
        "switched": Case(
            held(numbers, real),
            np.concatenate([limited, random]),
            _toggled(rng, limited.size + random.size),
        ),
    }


def _on(numbers: UnitNumbers, x: Array) -> Case:
    return Case(numbers, x, np.ones(x.size, dtype=bool))


def _toggled(rng: np.random.Generator, samples: int) -> npt.NDArray[np.bool_]:
    return np.repeat(rng.random(samples // 5 + 1) < 0.5, 5)[:samples]


def cover(
    rows: Sequence[tuple[Mapping[str, int], float]], fixed: Mapping[str, float] | None = None
) -> dict[str, float]:
    """Return the cost of a step and of each part: no sum over (counts, instructions) lies below what was counted.

    Of all such costs the ones whose sums lie nearest, in shares of what was counted, rounded up; parts that are `fixed`
    have their cost already.
    """
    known = dict(fixed or {})
    names = [
        "step",
        *sorted({name for counts, _ in rows for name, n in counts.items() if n} - known.keys()),
    ]
    table = np.array(
        [[{"step": 1, **counts}.get(name, 0) for name in names] for counts, _ in rows], float
    )
    y = np.array(
        [
            most - sum(cost * counts.get(name, 0) for name, cost in known.items())
            for counts, most in rows
        ]
    )
    shares = np.array([most for _, most in rows])
    found = linprog(
        (table / shares[:, None]).sum(axis=0),
        A_ub=-table,
        b_ub=-y,
        bounds=[(None, None)] + [(0, None)] * (len(names) - 1),
    )
    costs = {
        name: float(np.ceil(100.0 * cost) / 100.0)
        for name, cost in zip(names, found.x, strict=True)
    }
    rest = sum(costs[name] * table[:, k] for k, name in enumerate(names) if k)
    return {**costs, "step": float(np.ceil(np.max(y - rest))), **known}


def element_model(n: int) -> ElementModel:
    """Return a sum of 10 or 40 elements of all kinds, at 100 Hz."""
    size = MIXED.index(n)
    u = np.linspace(-1.0, 1.0, 6)
    bend = (tuple(u), tuple(u + 0.3 * np.sin(3.0 * u)))
    elements = [
        Element(kind, radius * (i + 1) / count[size], time * (i + 1), weight / count[size],
                bend if i < mapped[size] else ((), ()))
        for kind, count, mapped, radius, time, weight in MIX for i in range(count[size])
    ]  # fmt: skip
    return ElementModel(tuple(elements), period=0.01, card=CARD)


CARD = ModelCard(SignalCard("voltage", "V", -1.0, 1.0), SignalCard("travel", "mm", -2.0, 2.0))
MANY = 8  # elements of one kind, beside the input


def element_models(direction: str) -> list[ElementModel]:
    """Return sums of many elements of one kind, with and without maps of few and of many pieces, and of no element."""
    models = [(Element("input"),)]
    for kind in KINDS:
        radius, time = (1.0 if kind == "product" else 0.3), (0.1 if kind in LAGS else 0.005)
        models.append(
            (
                Element("input"),
                *[Element(kind, radius, time, 0.02)] * MANY,
                Element("past", 0.1, 0.1, 0.02),
            )
        )
    for points in (3, 17):
        u = tuple(float(x) for x in np.linspace(-1.0, 1.0, points))
        models.append((Element("input"), *[Element("play", 0.3, 0.0, 0.02, (u, u))] * MANY))
    return [ElementModel(each, period=0.01, direction=direction, card=CARD) for each in models]


def direct_models() -> list[DirectInverse]:
    """Return direct inverses of one kind of term each, and schedules, and one of all of it."""
    sizes = [
        (1, 0, 0, 0, 0),
        (6, 0, 0, 0, 0),
        (1, 8, 0, 0, 0),
        (1, 0, 8, 0, 0),
        (1, 0, 0, 8, 0),
    ]
    return [
        direct_model(*size)
        for size in [*sizes, (6, 8, 0, 0, 1), (6, 8, 0, 0, 2), (4, 10, 5, 5, 2), (4, 6, 3, 2, 1)]
    ]


def direct_model(
    coefficients: int, stops: int, paths: int, creeps: int, schedules: int
) -> DirectInverse:
    """Return a direct inverse of these sizes."""
    sets = max(1, 2 * schedules)
    chosen = (Schedule("load", -8.0, 8.0, "Nm"), Schedule("mean_pressure", 2e5, 4e5, "Pa"))[
        :schedules
    ]
    card = ModelCard(SignalCard("torque", "Nm", -60.0, 60.0), SignalCard("angle", "rad", -0.5, 0.5))
    return DirectInverse(
        radii=np.geomspace(0.01, 0.5, stops) if stops else [], stop_weights=np.full((sets, stops), 1.0),
        path_lengths=np.geomspace(0.03, 1.0, paths) if paths else [], path_weights=np.full((sets, paths), 1.0),
        time_constants=np.geomspace(0.05, 30.0, creeps) if creeps else [], creep_weights=np.full((sets, creeps), 1.0),
        polynomial=np.full((sets, coefficients), 1.0), viscous=np.full(sets, 0.1), schedules=chosen, card=card,
    )  # fmt: skip


def element_signals(samples: int) -> tuple[Array, Array, Array]:
    """Return a slow signal, one that jumps anywhere, and one that jumps beyond the range; of half ranges."""
    rng = np.random.default_rng(1)
    jumps = rng.uniform(-0.9, 0.9, samples)
    return 0.9 * np.sin(2.0 * np.pi * np.arange(samples) / 100.0), jumps, 1.5 * jumps
