"""No name of a column, unit, run, file or card writes any page or picture: it is text there, and nothing else."""

from __future__ import annotations

import json
import unicodedata
import xml.etree.ElementTree as ElementTree
from dataclasses import replace
from functools import cache
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

import dehyst
from dehyst.design import design_excitation
from dehyst.findings import Finding
from dehyst.models import ModelCard, SignalCard
from dehyst.report.compare import write_comparison_figure, write_comparison_report
from dehyst.report.drift import write_drift_report
from dehyst.report.pictures import write_excitation_figure
from dehyst.robot.muscles import muscle
from dehyst.robot.muscles.bench import run_bench
from dehyst.robot.muscles.bench_log import BenchLog
from dehyst.robot.muscles.fit import fit_muscle
from dehyst.robot.report.muscle import write_muscle_figure, write_muscle_report
from dehyst.robot.report.page import write_reproduction_report
from dehyst.robot.report.sweep import Curve, write_sweep_figure
from reproduction_samples import sample_reproduction

MARK = "owned"
NAMES = {
    "a script": f"<script>{MARK}()</script>",
    "quotes": f"\"' onload='{MARK}()' x=\"><img src=x onerror={MARK}()>",
    "the end of CDATA": f"]]><{MARK}/>]]>",
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
    "an address": f"javascript:{MARK}() url(#{MARK})",
    "nothing": "",
}


class Reader(HTMLParser):
    """Elements with the names of their attributes, values of attributes, all text."""

    def __init__(self, page: str) -> None:
        super().__init__(convert_charrefs=True)
        self.elements: set[tuple[str, ...]] = set()
        self.values: list[str] = []
        self.text = ""
        self.feed(page)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements |= {(tag, name) for name, _ in attrs} | {(tag,)}
        self.values += [value or "" for name, value in attrs if name != "aria-label"]  # which is text to be read

    def handle_data(self, data: str) -> None:
        self.text += data


def x_and_y(model):
    x = np.sin(np.linspace(0, 60 * np.pi, 3001)) * np.where(np.arange(3001) % 200 < 100, 1.0, 0.6)
    return x, model.simulate(x) + 0.01 * np.cos(np.arange(3001) * 2.4)


@cache
def compared():
    x, y = x_and_y(dehyst.PrandtlIshlinskii([0.0, 0.5], [1.0, 1.0]))
    return dehyst.compare(dehyst.Recording(input=x, output=y), ["static", "pi"])


@cache
def drifted():
    model = dehyst.PrandtlIshlinskii([0.0, 0.5], [1.0, 1.0])
    x, y = x_and_y(model)
    return dehyst.drift(model, dehyst.Recording(input=x, output=1.2 * y), reference=dehyst.Recording(input=x, output=y))


@cache
def bench():
    model = muscle("tondu-lopez")
    return run_bench(model, [0.0, 0.1, 0.2], [2e5, 4e5])


@cache
def fitted():
    model = muscle("tondu-lopez")
    contraction, pressure = (part.ravel() for part in np.meshgrid(np.linspace(0, 0.2, 12), np.linspace(1e5, 5e5, 9)))
    force = model.static_force(contraction, pressure)
    return fit_muscle(BenchLog(contraction, pressure, force), "tondu-lopez")


def compare_pages(name: str, folder: Path) -> list[Path]:
    found = compared()
    recordings = tuple(
        replace(one, name=name, input_name=name, output_name=name, input_unit=name, output_unit=name)
        for one in found.recordings
    )
    found = replace(found, recordings=recordings)
    json.dumps(found.as_dict())
    return [write_comparison_report(found, folder / "a.html"), write_comparison_figure(found, folder / "a.svg")]


def muscle_pages(name: str, folder: Path) -> list[Path]:
    fit = fitted()
    fit = replace(fit, log=replace(fit.log, name=name, findings=(Finding("x", name),)))
    shown = replace(bench(), skipped=(name,))
    page = write_muscle_report(shown, folder / "b.html", title=name, fit=fit)
    return [page, write_muscle_figure(shown, folder / "b.svg", fit)]


def drift_pages(name: str, folder: Path) -> list[Path]:
    found = drifted()
    card = ModelCard(SignalCard(name, name, -1.0, 1.0), SignalCard(name, name, -1.0, 1.0), {name: name})
    logs = tuple(
        replace(
            entry,
            name=name,
            reason=name,
            changes=tuple(replace(change, unit=name) for change in entry.changes),
            recording=replace(entry.recording, name=name, input_name=name, output_name=name, output_unit=name),
        )
        for entry in found.logs
    )
    model = replace(found.model, card=card)
    found = replace(found, model=model, logs=logs, verdict=name, reference=name, settings={name: name})
    json.dumps(found.as_dict())
    return [write_drift_report(found, folder / "c.html", name)]


def sweep_pictures(name: str, folder: Path) -> list[Path]:
    curves = [
        Curve(f"{name}{k}", name, name, [name, "b", f"{name}c"], [1.0, 0.5, None], [name, "", f"_{name}"])
        for k in range(2)
    ]
    return [write_sweep_figure(folder / "d.svg", name, curves)]


def design_pictures(name: str, folder: Path) -> list[Path]:
    return [write_excitation_figure(folder / "e.svg", replace(planned(), unit=name), name)]


@cache
def planned():
    return design_excitation(0.0, 6.0, unit="bar", time_limit=500.0)


WRITERS = [compare_pages, muscle_pages, drift_pages, sweep_pictures, design_pictures]


CASES = [(write, what) for write in WRITERS for what in NAMES]
SLOW = ("a script", "quotes", "escapes", "10 000 letters", "half a pair")  # of a page that takes seconds to draw


@pytest.mark.slow
@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(("write", "what"), [case for case in CASES if case[0] is not drift_pages or case[1] in SLOW])
def test_no_name_becomes_an_element_an_attribute_or_a_command_of_a_page(write, what, tmp_path):
    for path in write(NAMES[what], tmp_path):
        text = path.read_bytes().decode("utf-8")
        shown = Reader(text)
        assert shown.elements <= plain(write.__name__, path.suffix, tmp_path), what
        assert not [value for value in shown.values if MARK in value]
        hidden = {c for c in text + shown.text if unicodedata.category(c) in ("Cc", "Cf", "Cs", "Zl", "Zp")}
        assert hidden <= {"\n"}, hidden
        assert "{{" not in text or "{{" in NAMES[what]
        assert len(text) < 3_000_000
        if path.suffix == ".svg":
            ElementTree.fromstring(text)


PLAIN: dict[tuple[str, str], set[tuple[str, ...]]] = {}


def plain(writer: str, ending: str, folder: Path) -> set[tuple[str, ...]]:
    """Elements and attributes of the same page with names that are only names."""
    if (writer, ending) not in PLAIN:
        place = folder / "plain"
        place.mkdir()
        for path in next(one for one in WRITERS if one.__name__ == writer)("pressure", place):
            PLAIN[writer, path.suffix] = Reader(path.read_text(encoding="utf-8")).elements
    return PLAIN[writer, ending]


@pytest.mark.slow
def test_no_name_writes_the_page_of_the_experiment(tmp_path):
    names = [name for what, name in NAMES.items() if what not in ("10 000 letters", "nothing")]
    result = sample_reproduction(plants=("maxwell-slip",), seeds=(0,), joints=(1,), with_studies=False)
    first, second = names[::2], names[1::2]
    settings = {
        **result.settings,
        "robot": "".join(first),
        "command": "".join(second),
        "changes": dict.fromkeys(names, 1),
    }
    settings |= {"sources": dict.fromkeys(names, first), "versions": dict(zip(first, second, strict=False))}
    plant = result.plants["maxwell-slip"]
    one = plant.identifications[1]
    card = SignalCard("".join(first), "".join(second))
    records = tuple(replace(r, name=card.name, input_name=card.name, output_unit=card.unit) for r in one.fit.recordings)
    fit = replace(one.fit, recordings=records, verdict=card.name, warnings=(Finding("x", card.unit),))
    plant = replace(plant, identifications={1: replace(one, fit=fit)})
    result = replace(result, settings=settings, plants={"maxwell-slip": plant})
    text = write_reproduction_report(result, tmp_path / "f.html").read_bytes().decode("utf-8")
    shown = Reader(text)
    assert not {tag for tag, *_ in shown.elements} & {"script", "img", MARK, "b", "object", "iframe"}
    assert not [value for value in shown.values if MARK in value] and MARK in shown.text
    assert not [name for _, *names in shown.elements for name in names if name.startswith("on")]
    assert not {c for c in text + shown.text if unicodedata.category(c) in ("Cc", "Cf", "Cs", "Zl", "Zp")} - {"\n"}
