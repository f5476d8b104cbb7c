"""Claims about the notebooks: what they show is true, built again the same, and agrees with the README."""

from __future__ import annotations

import json
import sys

import pytest

from places import ROOT

sys.path.insert(0, str(ROOT / "docs"))

import build
from generate import blocks, notebooks

BOOKS = {path.stem: path for path in build.written_notebooks()}


@pytest.mark.slow
@pytest.mark.parametrize("name", BOOKS)
def test_a_notebook_shows_what_its_cells_print_now(name):
    pytest.importorskip("nbclient", reason="nbclient runs the notebooks: pip install --group test")
    before = BOOKS[name].read_text(encoding="utf-8")
    assert notebooks.true_notebook(before, redraw=False) == before, (
        f"run: python docs/build.py {BOOKS[name]}"
    )


def test_a_notebook_is_small_and_every_figure_that_it_draws_is_shown():
    assert len(BOOKS) == 5
    for path in BOOKS.values():
        assert path.stat().st_size < 200_000
        for cell in json.loads(path.read_text(encoding="utf-8"))["cells"]:
            drawn = any("image/png" in output.get("data", {}) for output in cell.get("outputs", ()))
            assert drawn == "".join(cell["source"]).endswith(");"), (path.name, cell["id"])


@pytest.mark.slow
def test_a_notebook_built_twice_is_the_same_file_and_what_is_no_longer_true_is_replaced():
    nbformat = pytest.importorskip("nbformat")
    pytest.importorskip("nbclient", reason="nbclient runs the notebooks: pip install --group test")
    code = "import dehyst\nrec = dehyst.Recording([0, 1, 2, 1, 0.0], [0, 1, 2, 2, 1.0])\nprint(0.5)\nrec.plot();"
    cells = [
        nbformat.v4.new_code_cell(source, id=f"c{k}") for k, source in enumerate((code, "rec"))
    ]
    first = notebooks.true_notebook(
        nbformat.writes(nbformat.v4.new_notebook(cells=cells)), redraw=True
    )
    assert (
        notebooks.true_notebook(first, redraw=True) == first
        and '"0.5\\n"' in first
        and "<svg" in first
    )
    for shown, kept in (("0.7", "0.5"), ("0.501", "0.501")):
        again = notebooks.true_notebook(first.replace('"0.5\\n"', f'"{shown}\\n"'), redraw=False)
        assert again == first.replace('"0.5\\n"', f'"{kept}\\n"')


@pytest.mark.parametrize(
    "name, code",
    [
        ("first-loop", "fit.verdict"),
        ("from-log-to-c", "--target c"),
        ("the-papers-joint", "run_trial"),
    ],
)
def test_a_notebook_prints_what_the_readme_prints(name, code):
    steps = blocks.steps((ROOT / "README.md").read_text(encoding="utf-8"))
    shown = next(step.shown for step in steps if code in step.code).strip().splitlines()
    printed = notebooks.printed(BOOKS[name])
    assert not [line for line in shown if line and not blocks.agree(f"...\n{line}\n...", printed)]
