"""No name of a column, unit, run, file or card writes any page or picture: it is text there, and nothing else."""

from __future__ import annotations

import json
import unicodedata
import xml.etree.ElementTree as ElementTree
from dataclasses import replace
from functools import cache
from itertools import cycle
from pathlib import Path

import numpy as np
import pytest

from dehyst.design import design_excitation
from dehyst.findings import Finding
from dehyst.models import ModelCard, SignalCard
from dehyst.report import (
    write_comparison_figure,
    write_comparison_report,
    write_drift_report,
    write_report,
)
from dehyst.report._pictures import write_excitation_figure
from dehyst_robot.experiments._results import TRIALS
from dehyst_robot.report import (
    SweepCurve,
    write_muscle_figure,
    write_muscle_report,
    write_reproduction_report,
    write_sweep_figure,
)
from report_samples import (
    Reader,
    bench,
    compared,
    drifted,
    fit_by_hand,
    maxwell_slip_log,
    muscle_fit,
)
from reproduction_samples import SETTINGS, plant_result, sample_reproduction, studies

MARK = "owned"
NAMES = {
    "a script": f"<script>{MARK}()</script>",
    "quotes": f"\"' onload='{MARK}()' x=\"><img src=x onerror={MARK}()>",
    "the end of CDATA": f"]]><{MARK}/>]]>",
    "the end of a script": f"</script><script>{MARK}()</script>",
    "the end of a style": f"</style></script></svg></title><{MARK}>",
    "an entity": f"&lt;{MARK}&gt; &#60;{MARK}&#62; <!-- ",
    "escapes": f"\x1b[31m{MARK}\x1b]0;title\x07\x9b2J\x00\x7f",
    "marks of direction": f"\u202e{MARK}\u2066x\u200b\ufeff",
    "10 000 letters": f"{MARK}<b>" + "x" * 10_000,
    "lines": f"{MARK}\n<p>\r\n\u2028<br>\ttab",
    "a template": f"{{{{ 7 * 7 }}}}{{% include '{MARK}' %}}{{# ${{{MARK}}} #}}%({MARK})s {{0.__class__}}",
    "a formula": f"=cmd|' /C {MARK}'!A0",
    "mathematics": f"$\\frac{{{MARK}}}{{0}}$ _{MARK}_ \\input{{{MARK}}}",
    "half a pair": f"{MARK} \ud800 \udfff",
    "an address": f"javascript:{MARK}() url(#{MARK}) style='x' #0072b2 var(--ink)",
    "other scripts": "圧力 Δp Давление ضغط 🦾" * 30,
    "nothing": "",
}


def fit_pages(names: tuple[str, ...], folder: Path) -> list[Path]:
    n = cycle(names)
    log = maxwell_slip_log(
        400, name=next(n), input_name=next(n), output_name=next(n), input_unit=next(n)[:60]
    )
    log = replace(
        log,
        provenance={next(n): next(n), "nested": {next(n): [next(n)]}},
        findings=(Finding("x", next(n)),),
    )
    other = replace(log, name=next(n))
    fit = replace(
        fit_by_hand(log, other), warnings=(Finding(next(n), next(n)),), settings={next(n): next(n)}
    )
    fit = replace(fit, verdict=f"verdict {' '.join(names)}")
    pages = [
        write_report(fit, folder / "g.html", figures=folder / "figures", model_file=next(n) or None)
    ]
    return [*pages, *sorted((folder / "figures").glob("*.svg"))]


def compare_pages(names: tuple[str, ...], folder: Path) -> list[Path]:
    (name,), found = names, compared()
    recordings = tuple(
        replace(
            one, name=name, input_name=name, output_name=name, input_unit=name, output_unit=name
        )
        for one in found.recordings
    )
    found = replace(found, recordings=recordings)
    json.dumps(found.as_dict())
    return [
        write_comparison_report(found, folder / "a.html"),
        write_comparison_figure(found, folder / "a.svg"),
    ]


def muscle_pages(names: tuple[str, ...], folder: Path) -> list[Path]:
    (name,), fit = names, muscle_fit()
    fit = replace(fit, log=replace(fit.log, name=name, findings=(Finding("x", name),)))
    shown = replace(bench(), skipped=(name,))
    page = write_muscle_report(shown, folder / "b.html", title=name, fit=fit)
    return [page, write_muscle_figure(shown, folder / "b.svg", fit)]


def drift_pages(names: tuple[str, ...], folder: Path) -> list[Path]:
    n, found = cycle(names), drifted()
    card = ModelCard(
        SignalCard(next(n), next(n), -1.0, 1.0),
        SignalCard(next(n), next(n), -1.0, 1.0),
        {next(n): next(n)},
    )
    logs = tuple(
        replace(
            entry,
            name=next(n),
            reason=next(n),
            changes=tuple(replace(change, unit=next(n)) for change in entry.changes),
            recording=replace(
                entry.recording, name=next(n), input_name=next(n), output_name=next(n)
            ),
        )
        for entry in found.logs
    )
    settings = {next(n): next(n)}
    found = replace(
        found, model=replace(found.model, card=card), logs=logs, verdict=next(n), settings=settings
    )
    json.dumps(replace(found, reference=next(n)).as_dict())
    return [write_drift_report(found, folder / "c.html", next(n))]


def sweep_pictures(names: tuple[str, ...], folder: Path) -> list[Path]:
    (name,) = names
    curves = [
        SweepCurve(
            f"{name}{k}",
            name,
            name,
            [name, "b", f"{name}c"],
            [1.0, 0.5, None],
            [name, "", f"_{name}"],
        )
        for k in range(2)
    ]
    return [write_sweep_figure(folder / "d.svg", name, curves)]


def design_pictures(names: tuple[str, ...], folder: Path) -> list[Path]:
    (name,) = names
    return [write_excitation_figure(folder / "e.svg", replace(planned(), unit=name), name)]


@cache
def planned():
    return design_excitation(0.0, 6.0, unit="bar", time_limit=500.0)


def experiment_pages(names: tuple[str, ...], folder: Path) -> list[Path]:
    n = cycle(names)
    plant = plant_result("dahl", seeds=(0,), joints=(1,))
    one = plant.identifications[1]
    records = tuple(
        replace(r, name=next(n), input_name=next(n), output_unit=next(n))
        for r in one.fit.recordings
    )
    fit = replace(one.fit, recordings=records, verdict=next(n), warnings=(Finding("x", next(n)),))
    runs = tuple(
        replace(run, figures=(*names, *names, *names, *names)[:4])
        for run in plant.runs
        if run.trial == "slow"
    )
    tool = {
        t: {k: {f"{next(n)}_mm": 1.0, next(n): {next(n): 2.0}} for k in ("off", "paper")}
        for t in TRIALS
    }
    figures = {0: {**plant.figures[0], "tool": tool}}
    name = next(n)
    plant = replace(
        plant, plant=name, runs=runs, identifications={1: replace(one, fit=fit)}, figures=figures
    )
    told = {
        "changes": {next(n): next(n)},
        "sources": {next(n): next(n)},
        "versions": {next(n): next(n)},
    }
    double = {"case": [next(n) for _ in range(4)], "ratio": np.arange(4.0)}
    result = replace(
        sample_reproduction(("dahl",), (0,), (1,)),
        plants={name: plant},
        settings=SETTINGS
        | told
        | {next(n): next(n), "command": f"dehyst {next(n)}", "robot": next(n)},
        studies={**studies(), "double compensation": double, next(n): {next(n): [1.0]}},
    )
    page = write_reproduction_report(
        result,
        folder / "f.html",
        logs={next(n): next(n), next(n): [next(n)]},
        figures=folder / "figures",
    )
    return [page, *sorted((folder / "figures").glob("*.svg"))]


QUICK = [compare_pages, muscle_pages, sweep_pictures, design_pictures]
SLOW = [fit_pages, drift_pages, experiment_pages]  # drawn for seconds: several names at once
CASES = [(write, (what,)) for write in QUICK for what in NAMES]
CASES += [(write, (*NAMES,)[k : k + 6]) for write in SLOW for k in range(0, len(NAMES), 6)]


@pytest.mark.slow
@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(("write", "what"), CASES, ids=lambda case: getattr(case, "__name__", "-"))
def test_no_name_becomes_an_element_an_attribute_or_a_command_of_a_page(write, what, tmp_path):
    names = tuple(NAMES[each] for each in what)
    for path in write(names, tmp_path):
        text = path.read_bytes().decode("utf-8")
        shown = Reader(text)
        assert elements(shown) <= plain(write, path.suffix, tmp_path), what
        assert path.suffix == ".svg" or shown.faults == []
        values = [
            value or ""
            for _, one in shown.elements
            for key, value in one.items()
            if key not in ("aria-label", "data-about")
        ]
        assert not [value for value in values if MARK in value]
        seen = "".join(shown.words)
        hidden = {
            c for c in text + seen if unicodedata.category(c) in ("Cc", "Cf", "Cs", "Zl", "Zp")
        }
        assert hidden <= {"\n"}, hidden
        assert "{{" not in text or any("{{" in name for name in names)
        assert len(text) < 3_000_000
        if path.suffix == ".svg":
            ElementTree.fromstring(text)
        elif write is not compare_pages:
            assert all(
                " ".join(name.split()) in shown.text
                for name in names
                if name.isprintable() and len(name) < 9000
            )


def elements(shown: Reader) -> set[tuple[str, ...]]:
    """Elements, with the name of each attribute."""
    return {(tag, name) for tag, attributes in shown.elements for name in ("", *attributes)}


PLAIN: dict[tuple[str, str], set[tuple[str, ...]]] = {}


def plain(write, ending: str, folder: Path) -> set[tuple[str, ...]]:
    """Elements and attributes of the same page with names that are only names."""
    if (write.__name__, ending) not in PLAIN:
        place = folder / "plain"
        place.mkdir()
        names = ("pressure",) if write in QUICK else ("pressure", "angle", "bar", "deg")
        for path in write(names, place):
            PLAIN.setdefault((write.__name__, path.suffix), set()).update(
                elements(Reader(path.read_text("utf-8")))
            )
    return PLAIN[write.__name__, ending]
