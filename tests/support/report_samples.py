"""What tests of reports begin with: fits made by hand, other results, a reader of pages that complains."""

from __future__ import annotations

import re
from dataclasses import replace
from functools import cache
from html.parser import HTMLParser

import numpy as np
from scipy.optimize import nnls

import dehyst
from dehyst.data import Recording
from dehyst.findings import Finding
from dehyst.identification import ComparedSetting, Fit, Score
from dehyst.identification._evidence import Evidence
from dehyst.identification._fit import Certificate, LoopFacts
from dehyst.models import (
    ModifiedPrandtlIshlinskii,
    MonotoneMap,
    PrandtlIshlinskii,
    StaticCurve,
    StopOperatorModel,
)
from dehyst_robot.muscles import BenchLog, fit_muscle, muscle, run_bench

VOID = {"meta", "link", "br", "img", "hr", "input"}


class Reader(HTMLParser):
    """Reads a page, and complains about what a validator would."""

    def __init__(self, text: str) -> None:
        super().__init__(convert_charrefs=True)
        self.open: list[str] = []
        self.faults: list[str] = []
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.words: list[str] = []
        self.feed(text)
        self.close()
        if self.open:
            self.faults.append(f"never closed: {self.open}")

    def handle_starttag(self, tag, attributes):
        names = [name for name, _ in attributes]
        if len(set(names)) != len(names):
            self.faults.append(f"attribute repeated in <{tag}>")
        self.elements.append((tag, dict(attributes)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attributes):
        self.elements.append((tag, dict(attributes)))

    def handle_endtag(self, tag):
        if not self.open or self.open.pop() != tag:
            self.faults.append(f"</{tag}> closes something else")

    def handle_data(self, data):
        if not self.open or self.open[-1] not in ("style", "script"):
            self.words.append(data)

    def ids(self, tag="", of="") -> list[str]:
        """Ids of elements, of one tag or of one class alone."""
        return [
            a["id"]
            for t, a in self.elements
            if "id" in a and tag in ("", t) and of in ("", a.get("class"))
        ]

    @property
    def text(self) -> str:
        return " ".join(" ".join(self.words).split())


def read(page) -> Reader:
    return Reader(page.read_text(encoding="utf-8"))


def letters_of(page) -> list[str]:
    """Texts within the figures of a page."""
    return re.findall(r"<text[^>]*>([^<]*)</text>", page.read_text(encoding="utf-8"))


def x_and_y(model):
    x = np.sin(np.linspace(0, 60 * np.pi, 3001)) * np.where(np.arange(3001) % 200 < 100, 1.0, 0.6)
    return x, model.simulate(x) + 0.01 * np.cos(np.arange(3001) * 2.4)


@cache
def compared():
    x, y = x_and_y(PrandtlIshlinskii([0.0, 0.5], [1.0, 1.0]))
    return dehyst.compare(Recording(input=x, output=y), ["static", "pi"])


@cache
def drifted():
    model = PrandtlIshlinskii([0.0, 0.5], [1.0, 1.0])
    x, y = x_and_y(model)
    return dehyst.drift(
        model, Recording(input=x, output=1.2 * y), reference=Recording(input=x, output=y)
    )


@cache
def bench():
    return run_bench(muscle("tondu-lopez"), [0.0, 0.1, 0.2], [2e5, 4e5])


@cache
def muscle_fit():
    contraction, pressure = (
        part.ravel() for part in np.meshgrid(np.linspace(0, 0.2, 12), np.linspace(1e5, 5e5, 9))
    )
    force = muscle("tondu-lopez").static_force(contraction, pressure)
    return fit_muscle(BenchLog(contraction, pressure, force), "tondu-lopez")


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
    y = 40.0 * np.tanh(
        0.55 * (0.6 * (x - 2.0) + friction + 0.1 * creep)
    ) + 40.0 * noise * rng.standard_normal(samples)
    values = {
        "time": t,
        "name": "elbow-03.csv",
        "input_name": "pressure",
        "output_name": "angle",
        "input_unit": "bar",
        "output_unit": "deg",
        "provenance": {
            "file": "elbow-03.csv",
            "sha256": "ab" * 32,
            "rows": samples,
            "columns": ["pressure", "angle"],
        },
    }
    return Recording(input=x, output=y, **(values | names))


def score(y, model, span):
    error = y - model
    rmse = float(np.sqrt(np.mean(error**2)))
    return Score(rmse, 100 * rmse / span, rmse / float(np.std(y)), float(np.max(np.abs(error))))


def fit_by_hand(
    *recordings: Recording, family: str = "modified-pi", train: float = 0.5, n: int = 20
) -> Fit:
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
        model = ModifiedPrandtlIshlinskii(
            PrandtlIshlinskii(r, w[:n], offset, None, center), after_map=after
        )
    elif family == "stop":
        model = StopOperatorModel(r, np.where(r > 0, 2.0, 0.0), 1.0, level, None, center)
    else:
        model = PrandtlIshlinskii(
            r, sign * amplitude * w[:n], level + sign * amplitude * offset, None, center
        )
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
            kkt_residual=3e-16,
            round_trip_error=4.4e-15,
            inverse_gain=model.inverse_gain,
            inverse_miss_percent=2.0,
            nonzero_weights=model.nonzero_weights,
            operators=n,
            undetermined=tuple(float(v) for v in r[-3:]),
            initial_state="zero",
        ),
        facts=LoopFacts(
            "counter-clockwise",
            int(sign),
            14.2,
            6,
            12,
            -0.4,
            evidence=(Evidence("rate", 1.5, 0.75, 9, 10, 0.01),),
        ),
        candidates=(
            ComparedSetting(family, "zero", 1e-3, 1.12, 0.2, True),
            ComparedSetting("pi", "rest", None, 3.4, 0.5),
            ComparedSetting("pi-cumulative", "zero", None, 3.3, 0.45),
            ComparedSetting("static", "zero", None, 9.7, 1.1),
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
