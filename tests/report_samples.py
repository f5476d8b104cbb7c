"""Fits made by hand for the tests of the report: Maxwell slip with creep and noise, a plain least-squares model."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.optimize import nnls

from dehyst.data.recording import Recording
from dehyst.findings import Finding
from dehyst.identification.evidence import Evidence
from dehyst.identification.fit import Candidate, Certificate, Fit, LoopFacts, Score
from dehyst.models import ModifiedPrandtlIshlinskii, MonotoneMap, PrandtlIshlinskii, StaticCurve, StopOperatorModel

HOSTILE = '<script>alert("x")</script>'


RATE = Evidence("rate", 1.5, 0.75, 9, 10, 0.01)


def maxwell_slip_log(
    samples: int = 2000, *, loops: float = 6.0, noise: float = 0.004, seed: int = 3, **names
) -> Recording:
    """A mechanism that is not Prandtl-Ishlinskii: saturating backbone, friction of four slip elements, creep, noise."""
    rng = np.random.default_rng(seed)
    t = np.linspace(0.0, 10.0 * loops, samples)
    x = 2.0 - 2.0 * np.cos(2 * np.pi * t / 10.0) * (1.0 - 0.55 * t / t[-1])
    friction = sum(
        PrandtlIshlinskii([r], [w], center=2.0).simulate(x)
        for r, w in ((0.1, 0.1), (0.3, 0.15), (0.7, 0.2), (1.2, 0.1))
    )
    creep = np.zeros(samples)
    share = (t[1] - t[0]) / 4.0
    for k in range(1, samples):
        creep[k] = creep[k - 1] + share * (friction[k] - creep[k - 1])
    y = 40.0 * np.tanh(0.55 * (0.6 * (x - 2.0) + friction + 0.1 * creep)) + 40.0 * noise * rng.standard_normal(samples)
    values = {
        "time": t,
        "name": "elbow-03.csv",
        "input_name": "pressure",
        "output_name": "angle",
        "input_unit": "bar",
        "output_unit": "deg",
        "provenance": {"file": "elbow-03.csv", "sha256": "ab" * 32, "rows": samples, "columns": ["pressure", "angle"]},
    }
    return Recording(input=x, output=y, **(values | names))


def score(y, model, span):
    error = y - model
    rmse = float(np.sqrt(np.mean(error**2)))
    return Score(rmse, 100 * rmse / span, rmse / float(np.std(y)), float(np.max(np.abs(error))))


def fit_by_hand(*recordings: Recording, family: str = "modified-pi", train: float = 0.5, n: int = 20) -> Fit:
    """A Fit like identify() returns, by plain least squares: good enough to draw."""
    recordings = recordings or (maxwell_slip_log(),)
    x = np.concatenate([r.input for r in recordings])
    y = np.concatenate([r.output for r in recordings])
    center, half = (x.max() + x.min()) / 2, (x.max() - x.min()) / 2
    level, amplitude = (y.max() + y.min()) / 2, (y.max() - y.min()) / 2
    sign = 1.0 if np.corrcoef(x, y)[0, 1] > 0 else -1.0
    r = np.arange(n) / n * half
    plays = np.column_stack([PrandtlIshlinskii([ri], [1.0], center=center).simulate(x) for ri in r])
    inner = np.clip(sign * (y - level) / amplitude, -0.97, 0.97)
    target = np.arctanh(inner) if family == "modified-pi" else inner
    columns = np.column_stack([plays, np.ones(x.size), -np.ones(x.size)])
    w, _ = nnls(columns, target)
    w[0] += 1e-3 / half
    offset = float(w[n] - w[n + 1])
    if family == "modified-pi":
        grid = np.linspace(target.min() - 0.1, target.max() + 0.1, 21)
        after = MonotoneMap(grid, level + sign * amplitude * np.tanh(grid))
        model = ModifiedPrandtlIshlinskii(PrandtlIshlinskii(r, w[:n], offset, None, center), after=after)
    elif family == "stop":
        model = StopOperatorModel(r, np.where(r > 0, 2.0, 0.0), 1.0, level, None, center)
    else:
        model = PrandtlIshlinskii(r, sign * amplitude * w[:n], level + sign * amplitude * offset, None, center)
    predictions = tuple(model.simulate(rec.input) for rec in recordings)
    masks = tuple(np.arange(len(rec)) < train * len(rec) for rec in recordings)
    line = np.polyfit(x, y, 1)
    static = StaticCurve(MonotoneMap([x.min(), x.max()], np.polyval(line, [x.min(), x.max()])))
    span = float(np.ptp(y))
    fitted, held = np.concatenate(masks), ~np.concatenate(masks)
    p, s = np.concatenate(predictions), static.simulate(x)
    inverse_predictions = tuple(model.inverse().simulate(rec.output) for rec in recordings)
    tested = bool(held.any())
    return Fit(
        family=family,
        model=model,
        recordings=recordings,
        predictions=predictions,
        inverse_predictions=inverse_predictions,
        train_masks=masks,
        test_masks=tuple(~mask for mask in masks),
        train=score(y[fitted], p[fitted], span),
        test=score(y[held], p[held], span) if tested else None,
        static=static,
        static_train=score(y[fitted], s[fitted], span),
        static_test=score(y[held], s[held], span) if tested else None,
        certificate=Certificate(
            3e-16,
            4.4e-15,
            model.inverse_gain,
            2.0,
            None,
            model.nonzero_weights,
            n,
            tuple(float(v) for v in r[-3:]),
            "zero",
        ),
        facts=LoopFacts(
            "counter-clockwise", int(sign), 14.2, 6, 12, -0.4, evidence=(Evidence("rate", 1.5, 0.75, 9, 10, 0.01),)
        ),
        candidates=(
            Candidate(family, "zero", 1e-3, 1.12, 0.2, True),
            Candidate("pi", "rest", None, 3.4, 0.5),
            Candidate("pi-cumulative", "zero", None, 3.3, 0.45),
            Candidate("static", "zero", None, 9.7, 1.1),
        ),
        warnings=(
            Finding(
                "undetermined",
                "3 of 20 operators never moved in the fitted half: their thresholds are 1.7-1.9 bar. Sweep the "
                "pressure further, or identify fewer operators: --n 17.",
            ),
        ),
        settings={"family": "auto", "n": n, "eps": 0.001, "train_fraction": train},
        verdict="Usable: the model is 1.4 % of range off on data it has not seen, six times better than a curve.",
    )


def falling(recording: Recording) -> Recording:
    """The same log with an output that falls."""
    return replace(recording, output=-recording.output)
