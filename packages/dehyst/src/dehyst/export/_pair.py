"""C for a model of two inputs and two outputs, or for its inverse: a folder with sources, example and check."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np

from dehyst.arrays import Array
from dehyst.errors import ParameterError
from dehyst.export import core_files
from dehyst.export._exchange import alone, put
from dehyst.export._folder import (
    FORMAT,
    MANIFEST,
    SCHEMA,
    VERIFIED,
    exported_files,
    manifest_text,
    refuse_folder,
)
from dehyst.export._folders import TEMPLATES
from dehyst.export._names import check_name
from dehyst.export._rendering import render
from dehyst.export._subject import REALS, SAME_WORDS, WHATS, check_choice
from dehyst.families import kit as families_kit
from dehyst.models import SignalCard, model_to_dict
from dehyst.models import kit as models_kit
from dehyst.shell import visible_text
from dehyst.version import __version__

PAIR = "pair"  # what the settings of such an export say
FUNCTIONS = ("dehyst_pair_reset", "dehyst_pair_step")
SAMPLES = 600  # of the test signal
BEYOND = 1.1  # of the range, as far as the test signal goes
TOLERANCE = 1e-4  # of a float, share of the range of an answer
ROUNDS, INNER = 66, 120  # of the core's search in double precision, at most


@dataclass(frozen=True)
class PairSettings:
    """What a pair is exported as.

    Attributes
    ----------
    name
        C identifier.
    direction
        "inverse", outputs in and inputs out, or "forward".
    real
        "double" or "float".
    period
        Between two samples; 0 where time does not count. [s]
    limits
        Smallest and largest value of each input. [input]
    """

    name: str
    direction: str
    real: str
    period: float
    limits: tuple[tuple[float, float], ...]

    def as_dict(self) -> dict[str, Any]:
        """Return the settings as they stand in the manifest."""
        return {
            "what": PAIR,
            "name": self.name,
            "direction": self.direction,
            "real": self.real,
            "period": self.period,
            "limits": [list(ends) for ends in self.limits],
        }


def write_pair(
    model: families_kit.CoupledModel,
    folder: str | os.PathLike[str],
    *,
    name: str = "stage",
    direction: str = "inverse",
    real: str = "double",
    period: float | None = None,
    limits: Sequence[tuple[float, float]] | None = None,
    overwrite: bool = False,
) -> tuple[str, ...]:
    """Write C for two inputs and two outputs into a folder that appears whole or not at all; return its files.

    Parameters
    ----------
    model
        Of two inputs and two outputs.
    folder
        To write; an export that is there already is replaced, anything else is refused.
    name
        C identifier that all names of the unit begin with.
    direction
        "inverse": wanted outputs in, inputs out. "forward": the model.
    real
        "double" or "float".
    period
        Between two samples, where the model creeps or depends on the rate; None takes that of the log. [s]
    limits
        Smallest and largest value of each input; None takes the identified ranges. [input]
    overwrite
        Replace an export also if its files were edited.

    Raises
    ------
    ParameterError
        If the model has other numbers of inputs and outputs, no inverse, or a setting makes no sense.
    OutputError
        If the folder would be lost or cannot be written.

    Examples
    --------
    >>> import tempfile, pathlib
    >>> from dehyst.families.kit import CoupledModel, ElementModel
    >>> a, b, x, y = (SignalCard(name, "", -1.0, 1.0) for name in "abxy")
    >>> from dehyst.families._elements import Element
    >>> weak = ElementModel((Element("play", 0.1, weight=0.2),))
    >>> model = CoupledModel(((ElementModel(), weak), (weak, ElementModel())), (a, b), (x, y), (0.0, 0.0))
    >>> "src/stage.c" in write_pair(model, pathlib.Path(tempfile.mkdtemp()) / "out", name="stage")
    True
    """
    place = Path(folder)
    if not isinstance(model, families_kit.CoupledModel):
        raise ParameterError(
            f"a {type(model).__name__} is no model of several inputs; export it with dehyst.export.export()."
        )
    if len(model.inputs) != 2 or len(model.outputs) != 2:
        raise ParameterError(
            f"C is written for two inputs and two outputs, and this model has {len(model.inputs)} and "
            f"{len(model.outputs)}. Play it in Python with simulate(), or identify two inputs and two outputs."
        )
    check_name(name)
    check_choice(direction, WHATS, "direction")
    check_choice(real, REALS, "real")
    if direction == "inverse":
        model.inverse()  # says why there is none
    seconds = 0.0
    if model.rate_dependent:
        seconds = models_kit.positive_period(model.period if period is None else period)
    ends = []
    for card, typed in zip(model.inputs, limits or (None, None), strict=True):
        low, high = typed if typed is not None else (card.low, card.high)
        if low is None or high is None or not low < high:
            raise ParameterError(
                f"the limits of {card.name} are {low} and {high}; pass limits=[(low, high), (low, high)], what the "
                f"actuators can be given."
            )
        ends.append((float(low), float(high)))
    settings = PairSettings(name, direction, real, seconds, tuple(ends))
    refuse_folder(place, overwrite)
    content = pair_contents(model, settings)
    with alone(place):
        put(place, content, {*(exported_files(place) or {}), MANIFEST, VERIFIED})
    return tuple(sorted(content))


def pair_settings(stored: Mapping[str, Any]) -> PairSettings:
    """Return the settings of a manifest."""
    limits = tuple((float(low), float(high)) for low, high in stored["limits"])
    return PairSettings(
        str(stored["name"]),
        str(stored["direction"]),
        str(stored["real"]),
        float(stored["period"]),
        limits,
    )


def pair_contents(model: families_kit.CoupledModel, settings: PairSettings) -> dict[str, bytes]:
    """Return relative path -> bytes of all files of an export, the manifest included."""
    values = _values(model, settings)
    sources: dict[str, str] = {
        **core_files.needed(FUNCTIONS),
        core_files.CONFIG: core_files.config(settings.real),
        f"{settings.name}.h": render("c/pair.h.j2", **values),
        f"{settings.name}.c": render("c/pair.c.j2", **values),
    }
    rules, objects = [], []
    for file in sorted(sources):
        if file.endswith(".c"):
            rules.append({"stem": Path(file).stem, "source": f"src/{file}"})
            objects.append(f"$(BUILD)/{Path(file).stem}.o")
    headers = " ".join(f"src/{file}" for file in sorted(sources) if file.endswith(".h"))
    files = {f"src/{file}": text for file, text in sources.items()}
    files |= {
        "LICENSE": (TEMPLATES / "LICENSE").read_text(encoding="utf-8"),
        "README.md": render("c/pair_README.md.j2", **values),
        "Makefile": render(
            "c/Makefile.j2", include="src", rules=rules, objects=" ".join(objects), headers=headers
        ),
        "example/main.c": render("c/pair_main.c.j2", **values),
        "check/check.c": render("c/pair_check.c.j2", implementation=False, **values),
        "check/expected.h": render("c/pair_expected.h.j2", **values),
        "model.json": values["model_text"],
    }
    content = {file: visible_text(text).encode("utf-8") for file, text in files.items()}
    manifest = {
        "format": FORMAT,
        "schema": SCHEMA,
        "dehyst": __version__,
        # The date alone differs between two exports of one model.
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
        "target": "c",
        "settings": settings.as_dict(),
        "title": values["title"],
        "model_sha256": values["checksum"],
        "files": {file: hashlib.sha256(data).hexdigest() for file, data in sorted(content.items())},
    }
    return {**content, MANIFEST: manifest_text(manifest).encode("utf-8")}


def _values(model: families_kit.CoupledModel, settings: PairSettings) -> dict[str, Any]:
    """Return what the templates are filled with."""
    solves = settings.direction == "inverse"
    pair = model.pair(solves, settings.limits)
    samples = _test_signal(model, settings)
    steps = np.full(len(samples), settings.period) if model.rate_dependent else None
    answers, flags, _ = pair.run(samples, steps)
    heads, tails = (model.outputs, model.inputs) if solves else (model.inputs, model.outputs)
    content = model_to_dict(model)
    ranges = np.ptp(answers, axis=0)
    ranges[ranges == 0.0] = 1.0
    if solves:
        limits = np.array(settings.limits)
        slack = 1e-6 * np.ptp(limits, axis=1)
        lowest, highest = limits[:, 0] - slack, limits[:, 1] + slack
    else:
        lowest, highest = _reach(pair)
    words = {"double": "bits of the model", "float": "the model to 1e-4"}
    return {
        "version": __version__,
        "name": settings.name,
        "NAME": settings.name.upper(),
        "title": _title(heads, tails, solves),
        "real": settings.real,
        "period": settings.period,
        "solves": solves,
        "order": tuple(pair.order),
        "heads": heads,
        "tails": tails,
        "limits": list(zip(model.inputs, settings.limits, strict=True)),
        "rests": list(zip(model.inputs, model.rest, strict=True)),
        "paths": _paths(model, pair, settings.period),
        "terms": sum(len(path.elements) for path in pair.sums),
        "numbers": _numbers(pair),
        "checksum": content["sha256"],
        "model_text": json.dumps(content, indent=1, allow_nan=False) + "\n",
        "samples": samples.tolist(),
        "answers": answers.tolist(),
        "flags": flags.tolist(),
        "ranges": ranges.tolist(),
        "lowest": lowest.tolist(),
        "highest": highest.tolist(),
        "tolerance": TOLERANCE,
        "words": words[settings.real],
        "same": SAME_WORDS[settings.real],
        "head_ends": [_ends(card, column) for card, column in zip(heads, samples.T, strict=True)],
        "certificate": f"the determinant of the slopes is at least {model.determinant:.2g} of the ranges.",
        "rounds": ROUNDS,
        "inner": INNER,
    }


def _title(heads: Sequence[SignalCard], tails: Sequence[SignalCard], solves: bool) -> str:
    kind = "inverse compensator" if solves else "hysteresis model"
    return f"{kind} of two inputs: {', '.join(c.label for c in heads)} -> {', '.join(c.label for c in tails)}"


def _ends(card: SignalCard, values: Array) -> tuple[float, float]:
    if card.low is not None and card.high is not None:
        return card.low, card.high
    return float(np.nanmin(values)), float(np.nanmax(values))


def _reach(pair: families_kit.CorePair) -> tuple[Array, Array]:
    """Ends that no output leaves: every element at the largest it can be."""
    level, amplitude = pair.numbers[4:6], pair.numbers[6:8]
    lows, highs = pair.numbers[10:12], pair.numbers[12:14]
    reach = np.zeros(2)
    for place, path in enumerate(pair.sums):
        farthest = max(
            abs(lows[place % 2]), abs(highs[place % 2]), abs(pair.numbers[8 + place % 2])
        )
        size = abs(path.offset)
        for q in path.elements:
            # No memory is farther than the input was; what relaxes is a difference of two.
            e = 2.0 * farthest + q.radius
            largest = e
            if q.map[0]:
                ends = np.interp([-e, e], *q.map)
                u, v = np.array(q.map)
                slopes = np.abs(np.diff(v) / np.diff(u))
                largest = float(
                    max(np.max(np.abs(v)), np.max(np.abs(ends))) + e * max(slopes[0], slopes[-1])
                )
            size += abs(q.weight) * largest
        reach[place // 2] += size
    return level - np.abs(amplitude) * reach, level + np.abs(amplitude) * reach


def _numbers(pair: families_kit.CorePair) -> list[tuple[str, list[float]]]:
    values = pair.numbers.reshape(-1, 2).tolist()
    names = ("center", "half_range", "level", "amplitude", "rest")
    return list(zip(names, values[:5], strict=True))


def _paths(
    model: families_kit.CoupledModel, pair: families_kit.CorePair, period: float
) -> list[dict[str, Any]]:
    """Elements of the four sums, with gains for the period."""
    lows, highs = pair.numbers[10:12], pair.numbers[12:14]
    paths = []
    for place, path in enumerate(pair.sums):
        elements = []
        map_u: list[float] = []
        map_v: list[float] = []
        for q, gain in zip(path.elements, pair.gains(place, period), strict=True):
            kind = families_kit.KINDS.index(q.kind)
            points = len(q.map[0])
            elements.append(
                {
                    "kind": kind,
                    "radius": q.radius,
                    "gain": gain,
                    "weight": q.weight,
                    "points": points,
                    "at": len(map_u),
                }
            )
            map_u += q.map[0]
            map_v += q.map[1]
        paths.append(
            {
                "memory": f"path_{place // 2}{place % 2}",
                "input": model.inputs[pair.order[place % 2]].name,
                "output": model.outputs[place // 2].name,
                "elements": elements,
                "map_u": map_u,
                "map_v": map_v,
                "offset": path.offset,
                "low": float(lows[place % 2]),
                "high": float(highs[place % 2]),
            }
        )
    return paths


def _test_signal(model: families_kit.CoupledModel, settings: PairSettings) -> Array:
    """Samples (T, 2): strokes of growing and falling size, a tenth beyond the limits, and three that are no number."""
    k = np.arange(SAMPLES)
    size = BEYOND * np.minimum(1.0, 0.2 + k / 200.0)
    phases = np.stack([np.sin(0.11 * k) * np.cos(0.017 * k), np.sin(0.073 * k + 1.0)], axis=1)
    middles = np.array([0.5 * (low + high) for low, high in settings.limits])
    halves = np.array([0.5 * (high - low) for low, high in settings.limits])
    u = middles + halves * size[:, None] * phases
    samples = u
    if settings.direction == "inverse":
        samples = model.simulate(u, settings.period * k if model.rate_dependent else None)
    samples = (
        samples.astype(np.float32).astype(np.float64)
        if settings.real == "float"
        else samples.copy()
    )
    samples[100, 0] = samples[250, 1] = np.nan
    samples[400] = np.inf
    return np.ascontiguousarray(samples)
