"""How to use the result: lines to copy, with the names of this log."""

from __future__ import annotations

import os
from dataclasses import dataclass

import numpy as np

from dehyst.grades import Grade
from dehyst.identification.fit import Fit
from dehyst.recording import Recording
from dehyst.report.judgement import overall
from dehyst.report.text import clean
from dehyst.shell import quoted


@dataclass(frozen=True, slots=True)
class Lines:
    """Something to type, and what it does."""

    purpose: str
    code: str


def next_steps(fit: Fit, model_file: str | os.PathLike[str] | None) -> tuple[Lines, ...]:
    """Return what to type next."""
    rec = fit.recordings[0]
    name = clean(os.fspath(model_file)) if model_file is not None else "model.json"
    file = quoted(name)
    x, y = (quoted(_column(rec, role)) for role in ("input", "output"))
    x_unit, y_unit = _one_line(rec.input_unit) or "its unit", _one_line(rec.output_unit) or "its unit"
    simulate = Lines("What the model says about another log", f"dehyst simulate {file} other_log.csv --input {x}")
    head = f"import dehyst\n\nmodel = dehyst.load({name!r})\n# input in {x_unit}, output in {y_unit}\n"
    at, period = (", time", f"{_period(fit):g}") if fit.model.rate_dependent else ("", "")
    one = "".join(f", {each}={each}_k" for each in fit.model.needs)
    more = at + "".join(f", {each}={each}" for each in fit.model.needs)
    if overall(fit) is Grade.BAD:
        steps = [
            Lines(
                "Do not compensate with this model: look at the warnings above, cure what they name, and identify "
                "again. Until then it is for simulation only. " + simulate.purpose,
                simulate.code,
            ),
            Lines("The same in Python", head + f"y = model.simulate(x{more})"),
        ]
    else:
        steps = [
            Lines(
                "The input that makes the actuator follow a reference",
                f"dehyst compensate {file} reference.csv --output {y}",
            ),
            simulate,
            Lines(
                "The same in Python, for whole signals and sample by sample in real time",
                head + f"y = model.simulate(x{more})\n"
                "inverse = model.inverse()\n"
                f"x = inverse.simulate(reference{more})\n\n"
                "# one sample at a time; the state lives in the stepper\n"
                f"step = inverse.stepper({period}){'  # seconds between two samples of your loop' if at else ''}\n"
                f"x_k = step(reference_k{one})",
            ),
        ]
    if model_file is None:
        keep = "Keep the model, in Python or with --save on the command line; this run was not told where"
        steps.insert(0, Lines(keep, 'fit.model.save("model.json")'))
    return tuple(steps)


def _period(fit: Fit) -> float:
    """Seconds between two samples, as the model was identified or as the log was written."""
    time = fit.recordings[0].time
    known = fit.model.period
    return known or (0.001 if time is None else float(np.median(np.diff(time))))


def _column(recording: Recording, role: str) -> str:
    """Name of the column in the log, which may carry the unit: "pressure_bar" rather than "pressure"."""
    named = recording.provenance.get(role)
    return _one_line(named if isinstance(named, str) else getattr(recording, f"{role}_name"))


def _one_line(text: str) -> str:
    return " ".join(clean(text).split())
