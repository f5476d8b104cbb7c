"""Scores of compensators on a rig: what identify takes by itself, and each family of the house.

A compensator is played as `dehyst compensate` gives it: the inverse along the whole reference, begun as models are by
default, sent earlier by the dead time that the model knows, and within the range of the rig's input. The error is the
rms of the true output less the reference after the approach, percent of the range of the log's output.
"""

from __future__ import annotations

import json
import time
import zlib
from collections.abc import Iterable, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from result_files import tidy

import dehyst
from dehyst.errors import DehystError
from dehyst.families import ROW_NAMES
from dehyst.families.kit import TITLES
from dehyst.identification import Fit, all_names
from dehyst.models import kit as models_kit
from zoo.compiled import Array
from zoo.logs import recording, true_log
from zoo.references import FAST, REFERENCES, reference
from zoo.rigs import Rig

AUTO, CURVE = "auto", "static"
# Those that a target can run; `elements` is a choice among other families, none of its own.
FAMILIES = tuple(
    name for name in all_names() if name != "elements" and (name in TITLES or name in ROW_NAMES)
)
Scores = dict[str, Any]
ROOMS = ("data", "families", "identification", "models")  # of the kernel, which scores depend on


def fingerprint(rig: Rig, length: str) -> str:
    """Return a word that changes when the rig, its log or its references do."""
    parts = [*true_log(rig, length)]
    for kind in REFERENCES:
        parts.append(reference(rig, kind)[0])
    word = 0
    for part in parts:
        word = zlib.crc32(np.round(part, 9).tobytes(), word)
    word = zlib.crc32(repr((rig.noise, rig.quantum)).encode(), word)
    return f"{word:08x}"


@cache
def sources() -> str:
    """Return a word that changes when the rooms that identify do."""
    word = 0
    kernel = Path(str(dehyst.__file__)).parent
    for room in ROOMS:
        for path in sorted((kernel / room).rglob("*.py")):
            word = zlib.crc32(path.read_bytes(), word)
    return f"{word:08x}"


def demand(fit: Fit, wanted: Array, period: float) -> Array:
    """Return what `dehyst compensate` asks for along a reference (T,), and when its dead time says to send it."""
    at = period * np.arange(wanted.size)
    shaped = fit.model.shaped(wanted, at)
    inverse = models_kit.begun(fit.model.inverse(), models_kit.DEFAULT, float(shaped[0]))
    return np.asarray(fit.model.ahead(inverse.simulate(shaped, at), at))


def tracked(rig: Rig, fit: Fit, span: float) -> dict[str, Scores]:
    """Return the errors of a compensator along each reference, percent of a range of the output."""
    errors = {}
    for kind in REFERENCES:
        wanted, begin = reference(rig, kind)
        missed = rig.play(demand(fit, wanted, rig.period)) - wanted
        errors[kind] = {
            "tracking": _percent(missed[begin:], span),
            "approach": _percent(missed[:begin], span),
            "offset": float(100.0 * np.mean(missed[begin:]) / span),
        }
    return errors


def score(rig: Rig, length: str, family: str) -> Scores:
    """Identify a family, or what identify takes by itself, from a log of a rig; play its compensator."""
    log = recording(rig, length)
    begun = time.process_time()
    try:
        fit = dehyst.identify(log, family)
        spent = time.process_time() - begun
        if fit.model.no_export:
            return {"reason": fit.model.no_export}
        references = tracked(rig, fit, float(np.ptp(true_log(rig, length)[1])))
    except DehystError as fault:
        return {"reason": str(fault)}
    return {
        "family": fit.family,
        "direction": fit.direction,
        "parameters": fit.model.free_parameters,
        "test_percent": fit.output_error.rmse_percent,
        "input_percent": fit.input_error.rms_percent,
        "predicted": fit.tracking,
        "grade": "" if fit.grade is None else fit.grade.name,
        "seconds": round(spent, 2),
        "references": references,
    }


def scored(
    rig: Rig,
    length: str,
    families: Sequence[str] = FAMILIES,
    folder: Path | None = None,
    auto: bool = True,
    fresh: bool = False,
) -> Scores:
    """Return the scores of families and of "auto" from one log of a rig.

    Families that a file of the folder holds already are not identified again, unless the rig has changed since; "auto"
    is, unless `auto` is false and the file holds it. With `fresh` nothing that the file holds counts. "stale" is
    whether the families of the file were identified by other sources than these.
    """
    path = folder / f"{rig.name}-{rig.seed}.json" if folder else None
    saved: Scores = {}
    if path and path.exists():
        saved = json.loads(path.read_text(encoding="utf-8"))
    word = fingerprint(rig, length)
    entries, of_sources = {}, sources()
    if not fresh and saved.get(length, {}).get("fingerprint") == word:
        entries = dict(saved[length]["entries"])
        of_sources = saved[length].get("sources", "")
    for family in families:
        if family not in entries:
            entries[family] = tidy(score(rig, length, family))
    if auto or AUTO not in entries:
        entries[AUTO] = tidy(score(rig, length, AUTO))
    saved[length] = {"fingerprint": word, "sources": of_sources, "entries": entries}
    if path:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text(saved), encoding="utf-8")
    return {
        "rig": rig.name,
        "seed": rig.seed,
        "length": length,
        "entries": entries,
        "stale": of_sources != sources(),
    }


def text(saved: Scores) -> str:
    """Return a file of scores, a line for each family."""
    of_lengths = []
    for length in sorted(saved):
        one = saved[length]
        lines = []
        for name, entry in one["entries"].items():
            lines.append(f"  {json.dumps(name)}: {json.dumps(entry)}")
        head = {"fingerprint": one["fingerprint"], "sources": one.get("sources", "")}
        entries = ",\n".join(lines)
        of_lengths.append(
            f'{json.dumps(length)}: {json.dumps(head)[:-1]}, "entries": {{\n{entries}\n}}}}'
        )
    return "{" + ",\n".join(of_lengths) + "}\n"


def rows(scores: Scores) -> list[Scores]:
    """Return what one log says, a row for each reference: errors of the default, the best family, curve, and first.

    "First" is the family with the smallest error on held-out samples, which `dehyst compare` puts first.
    """
    entries = scores["entries"]
    default = entries[AUTO]
    played = {}
    for name, entry in entries.items():
        if name != AUTO and "references" in entry:
            played[name] = entry
    if not played or "references" not in default:
        return []
    first = min(played, key=lambda name: float(played[name]["test_percent"]))
    lines = []
    for kind in REFERENCES:
        errors = {name: _tracking(entry, kind) for name, entry in played.items()}
        best = min(errors, key=lambda name: errors[name])
        error = _tracking(default, kind)
        lines.append(
            {
                "rig": scores["rig"],
                "length": scores["length"],
                "reference": kind,
                "taken": default["family"],
                "error": error,
                "best": best,
                "least": errors[best],
                "over_best": error / errors[best],
                "over_curve": error / errors[CURVE] if CURVE in errors else None,
                "first": first,
                "over_first": error / errors[first],
                "predicted": default["predicted"],
            }
        )
    return lines


def summary(scores: Sequence[Scores]) -> Scores:
    """Return figures over the rows of many logs: geometric means, worst, shares."""
    lines = []
    predictions = []
    at_its_speed = []
    unable = []
    for one in scores:
        of_log = rows(one)
        if not of_log:
            unable.append(f"{one['rig']} {one['length']}")
            continue
        lines += of_log
        # One log has one prediction; what it is compared with is the rms over its references.
        predicted = of_log[0]["predicted"]
        if predicted is not None:
            predictions.append(predicted / _rms(of_log))
            # At twice the speed of the log nothing was promised.
            at_its_speed.append(predicted / _rms(row for row in of_log if row["reference"] != FAST))
    figures: Scores = {"rows": len(lines), "unable": unable}
    for key in ("over_best", "over_curve", "over_first"):
        ratios = np.array([row[key] for row in lines if row[key] is not None])
        if ratios.size:
            figures[key] = {
                "mean": float(np.exp(np.mean(np.log(ratios)))),
                "worst": float(ratios.max()),
                "within_10_percent": float(np.mean(ratios <= 1.1)),
            }
    for key, of_logs in (("predicted", predictions), ("predicted_at_its_speed", at_its_speed)):
        ratios = np.array(of_logs)
        if ratios.size:
            figures[key] = {
                "logs": ratios.size,
                "mean": float(np.exp(np.mean(np.log(ratios)))),
                "within_1_5": float(np.mean((ratios <= 1.5) & (ratios >= 1.0 / 1.5))),
            }
    return figures


def by_family(scores: Sequence[Scores]) -> Scores:
    """Return what each family, and the default, errs over the best family: always taken, over the rows of many logs.

    `logs` is on how many of the logs it can be played at all; the others do not count.
    """
    ratios: dict[str, list[float]] = {}
    for one in scores:
        played = {}
        for name, entry in one["entries"].items():
            if "references" in entry:
                played[name] = entry
        for kind in REFERENCES:
            errors = {name: _tracking(entry, kind) for name, entry in played.items()}
            least = min(error for name, error in errors.items() if name != AUTO)
            for name, error in errors.items():
                ratios.setdefault(name, []).append(error / least)
    figures = {}
    for name, of_family in ratios.items():
        figures[name] = {
            "mean": float(np.exp(np.mean(np.log(of_family)))),
            "worst": max(of_family),
            "logs": len(of_family) // len(REFERENCES),
        }
    return dict(sorted(figures.items(), key=lambda item: item[1]["mean"]))


def _tracking(entry: Scores, kind: str) -> float:
    return float(entry["references"][kind]["tracking"])


def _rms(lines: Iterable[Scores]) -> float:
    return float(np.sqrt(np.mean([row["error"] ** 2 for row in lines])))


def _percent(missed: Array, span: float) -> float:
    return float(100.0 * np.sqrt(np.mean(missed**2)) / span)
