"""Build everything in docs/ (and README.md) that is generated: reference pages, shown outputs, notebooks, figures.

    python docs/build.py            write what is not up to date
    python docs/build.py PAGE ...   these pages or notebooks and their figures, such as docs/explanation/proofs.md
    python docs/build.py --check    write nothing; name what is not up to date, exit status 1
    python docs/build.py --headlines    the first line of every module, room by room: the house in words

Idempotent: a second run changes nothing. Reference pages and the page of decisions are written anew; outputs shown on
a page or by a notebook are replaced where they are no longer true (the rules are in generate/blocks.py); figures carry
no date and no random id. Figures are not checked: another version of matplotlib draws other bytes of the same picture.
"""

from __future__ import annotations

import argparse
import ast
import re
import sys
import tempfile
from pathlib import Path

DOCS = Path(__file__).resolve().parent
ROOT = DOCS.parent
sys.path.insert(0, str(DOCS))

from generate import (  # noqa: E402 - found beside this file
    black_boxes,
    blocks,
    bouc_wen,
    commands,
    contacts,
    errors,
    families_in_controller,
    figures,
    findings,
    foreign_rigs,
    gains,
    integrator,
    models,
    notebooks,
    paper_compensator,
    parameters,
    plant_fit,
    proofs,
    python_names,
    rivals,
    sensitivity,
    speed,
    stale,
    targets,
    thresholds,
    valves,
    which_model,
)


def decisions() -> str:
    """Return the page of all decisions: each with its title and the first sentence of what was decided."""
    lines = [
        "# Decisions",
        "",
        "Choices that could have been made otherwise, each with the measurements behind it. What `identify` rests",
        "on: 3, 33, 42, 43, 46, 48, 63 and 64. A number that is missing was merged into another record, which says so.",
        "",
    ]
    for path in sorted((DOCS / "decisions").glob("0*.md")):
        text = path.read_text(encoding="utf-8")
        title = text.partition("\n")[0].lstrip("# ").strip()
        said = " ".join(text.partition("**Decided:**")[2].partition("\n\n")[0].split())
        sentence = re.split(r"(?<=[^.]\.)\s", said, maxsplit=1)[0]
        lines.append(f"- [{title}]({path.name}): {sentence}")
    return "\n".join(lines) + "\n"


REFERENCE = {
    "commands.md": commands.page,
    "errors.md": errors.page,
    "parameters.md": parameters.page,
    "python.md": python_names.page,
    "thresholds.md": thresholds.page,
    "warnings.md": findings.page,
} | models.pages()
PAGES = {f"reference/{name}": make for name, make in REFERENCE.items()} | {
    "decisions/README.md": decisions,
    "../packages/dehyst-robot/src/dehyst_robot/report/gains.csv": gains.of_report,
}


# Page, and name of the part of it that is generated -> what makes it.
PARTS = {
    ("explanation/the-plant.md", "life"): parameters.life,
    ("explanation/the-plant.md", "numbers"): parameters.numbers,
    ("explanation/the-experiment.md", "rest"): paper_compensator.at_rest,
    ("explanation/the-experiment.md", "twice"): paper_compensator.twice,
    ("explanation/the-experiment.md", "sensitivity"): sensitivity.table,
    ("explanation/the-experiment.md", "readings"): paper_compensator.readings,
    ("explanation/gain-or-compensator.md", "poles"): gains.over_poles,
    ("explanation/gain-or-compensator.md", "ratios"): gains.ratios,
    ("explanation/gain-or-compensator.md", "effects"): gains.effects,
    ("explanation/adaptation.md", "changes"): stale.table,
    ("explanation/adaptation.md", "contacts"): contacts.table,
    ("explanation/integrator.md", "gains"): integrator.gains,
    ("explanation/integrator.md", "rest"): integrator.at_rest,
    ("explanation/integrator.md", "observer"): integrator.observer,
    ("explanation/speed.md", "table"): speed.page,
    ("how-to/run-on-a-microcontroller.md", "instructions"): targets.page,
    ("explanation/proofs.md", "results"): proofs.page,
    ("explanation/bouc-wen-benchmark.md", "results"): bouc_wen.page,
    ("explanation/which-model-when.md", "results"): which_model.page,
    ("explanation/which-model-when.md", "rigs"): foreign_rigs.page,
    ("explanation/which-model-when.md", "black boxes"): black_boxes.page,
    ("explanation/families-in-the-controller.md", "results"): families_in_controller.table,
    ("explanation/rivals.md", "draws"): rivals.draws,
    ("explanation/rivals.md", "errors"): rivals.errors,
    ("explanation/rivals.md", "ratios"): rivals.ratios,
    ("explanation/rivals.md", "pairs"): rivals.pairs,
    ("explanation/rivals.md", "mechanisms"): rivals.mechanisms,
    ("explanation/rivals.md", "budgets"): rivals.budgets,
    ("explanation/rivals.md", "lost"): rivals.lost,
    ("how-to/valves.md", "sticking"): valves.sticking,
    ("how-to/valves.md", "controls"): valves.controls,
    ("how-to/valves.md", "closed loop"): valves.closed_loop,
    ("explanation/validate-the-plant.md", "results"): plant_fit.page,
    ("../benchmarks/README.md", "output of speed.py"): speed.console,
}


def with_part(text: str, name: str, part: str) -> str:
    """Return a page with a part between its marks; a page without them is refused."""
    begin, end = f"<!-- {name}: generated by docs/build.py -->", f"<!-- end of {name} -->"
    head, mark, rest = text.partition(begin)
    _, closing, tail = rest.partition(end)
    if not mark or not closing:
        raise ValueError(f"no place for the generated part '{name}': write {begin} and {end}")
    return f"{head}{begin}\n{part}\n{end}{tail}"


def generated_pages() -> dict[Path, str]:
    """Return every page, or part of a page, that is made from the source, with its up-to-date text."""
    pages = {(DOCS / name).resolve(): make() for name, make in PAGES.items()}
    for (name, part), make in PARTS.items():
        path = DOCS / name
        pages[path] = with_part(pages.get(path) or path.read_text(encoding="utf-8"), part, make())
    return pages


def written_pages() -> list[Path]:
    """Return the READMEs and every page below docs/ that show code and what it prints."""
    pages = [ROOT / "README.md", *sorted(ROOT.glob("packages/*/README.md"))]
    # Recipes for contributors are run by tests/test_contributing.py, which puts their files in place.
    pages += [page for page in sorted(DOCS.rglob("*.md")) if page.parent.name != "contributing"]
    return [
        page for page in pages if page.is_file() and blocks.steps(page.read_text(encoding="utf-8"))
    ]


def written_notebooks() -> list[Path]:
    """Return every notebook below docs/."""
    return sorted((DOCS / "notebooks").glob("*.ipynb"))


def true_text(text: str) -> str:
    """Return the text of a page with the outputs that its code prints now."""
    with tempfile.TemporaryDirectory() as folder:
        return blocks.with_outputs(text, blocks.run_page(text, Path(folder)))


def headlines() -> str:
    """Return a line a module of packages/dehyst/src/dehyst: its path and the first line of its docstring."""
    lines, source = [], ROOT / "packages"
    for folder in sorted({path.parent for path in source.rglob("*.py")}):
        lines += ["", folder.relative_to(source.parent).as_posix()]
        for path in sorted(folder.glob("*.py")):
            said = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or ""
            lines.append(f"  {path.name:24}{said.partition(chr(10))[0]}")
    return "\n".join(lines[1:])


def _figures_of(pages: set[Path]) -> set[str]:
    """Names of the figures that pages show."""
    names: set[str] = set()
    for page in pages:
        names.update(re.findall(r"images/([\w/-]+)\.(?:svg|png)", page.read_text(encoding="utf-8")))
    return names


def main() -> int:
    """Write, or check, everything that is generated."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--check", action="store_true", help="write nothing, name what is not up to date"
    )
    parser.add_argument(
        "--headlines", action="store_true", help="print the first line of every module"
    )
    parser.add_argument(
        "pages", nargs="*", type=Path, help="only these pages and the figures that they show"
    )
    given = parser.parse_args()
    if given.headlines:
        print(headlines())
        return 0
    check, chosen = given.check, {page.resolve() for page in given.pages}
    generated = generated_pages()
    shown = [*written_pages(), *written_notebooks()]
    unknown = chosen - {*generated, *shown}
    if unknown:
        parser.error(f"no page of the docs: {', '.join(map(str, sorted(unknown)))}")
    stale = [
        path
        for path, text in generated.items()
        if _chosen(path, chosen) and _put(path, text, check)
    ]
    stale += [path for path in shown if _chosen(path, chosen) and _refresh(path, check)]
    for path in stale:
        print(f"{'not up to date' if check else 'wrote'}: {path.relative_to(ROOT)}")
    if not check:
        (DOCS / "images").mkdir(exist_ok=True)
        for path in figures.build(DOCS / "images", _figures_of(chosen) if chosen else None):
            print(f"drew: {path.relative_to(ROOT)}")
    return 1 if check and stale else 0


def _chosen(path: Path, pages: set[Path]) -> bool:
    return not pages or path in pages


def _refresh(path: Path, check: bool) -> bool:
    """Bring the shown outputs of a page up to date; leave it alone if it was edited while its code ran."""
    before = path.read_text(encoding="utf-8")
    text = (
        notebooks.true_notebook(before, redraw=not check)
        if path.suffix == ".ipynb"
        else true_text(before)
    )
    return path.read_text(encoding="utf-8") == before and _put(path, text, check)


def _put(path: Path, text: str, check: bool) -> bool:
    """Write a text that has changed, unless only checking; say whether it had."""
    if path.is_file() and path.read_text(encoding="utf-8") == text:
        return False
    if not check:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    return True


if __name__ == "__main__":
    sys.exit(main())
