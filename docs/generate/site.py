"""The site: pages of the repository laid out as a tool for sites takes them, built, formulas drawn.

python docs/generate/site.py [--out site]
"""

from __future__ import annotations

import argparse
import json
import posixpath
import re
import shutil
import subprocess
import sys
import tempfile
from html import unescape
from pathlib import Path
from typing import Any

import latex2mathml.converter

DOCS = Path(__file__).resolve().parents[1]
ROOT = DOCS.parent
sys.path.insert(0, str(DOCS))

from generate import notebooks  # noqa: E402 - found through the path above

# File of the repository -> page of the site. The README is the front page.
MOVED = {
    "README.md": "index.md",
    "docs/index.md": "contents.md",
    "CONTRIBUTING.md": "contributing.md",
    "CHANGELOG.md": "changes.md",
    "SECURITY.md": "security.md",
    "benchmarks/README.md": "benchmarks.md",
    "packages/dehyst/README.md": "packages/dehyst.md",
    "packages/dehyst-targets/README.md": "packages/dehyst-targets.md",
    "packages/dehyst-robot/README.md": "packages/dehyst-robot.md",
    "packages/dehyst-studio/README.md": "packages/dehyst-studio.md",
}
LINK = re.compile(r"""(\]\(|(?:src|href)=")(?!\w+:|#)([^)#"\s]+)""")
FENCE = re.compile(r"(?ms)^(`{3,})[^\n]*\n.*?^\1$")
FORMULA = re.compile(r"(?s)<(span|div) class=\"arithmatex\">\\[\[(](.*?)\\[\])]</\1>")


def place(source: str) -> str:
    """Return where a file of the repository stands on the site."""
    return re.sub(r"\.ipynb$", ".md", MOVED.get(source, source.removeprefix("docs/")))


def goal(source: str, target: str) -> str:
    """Return the file of the repository that a link of another one leads to."""
    return posixpath.normpath(posixpath.join(posixpath.dirname(source), target))


def page(source: str) -> str:
    """Return a page of the repository with the links of the site, outside of code."""
    path = ROOT / source
    text = (
        notebooks.as_markdown(path) if path.suffix == ".ipynb" else path.read_text(encoding="utf-8")
    )
    here = posixpath.dirname(place(source))

    def moved(match: re.Match[str]) -> str:
        return match[1] + posixpath.relpath(place(goal(source, match[2])), here)

    code = [re.sub(r"^(`+\w+) no-run", r"\1", block[0]) for block in FENCE.finditer(text)]
    prose = [LINK.sub(moved, part) for part in FENCE.split(text)[::2]]
    return "".join(part + block for part, block in zip(prose, [*code, ""], strict=True))


def order() -> list[Any]:
    """Return the pages as docs/index.md, the page of models and that of decisions list them."""

    def listed(source: str, text: str) -> list[str]:
        return [
            place(goal(source, target))
            for target in dict.fromkeys(re.findall(r"\]\(([^)#\s]+)", text))
        ]

    nav: list[Any] = [{"dehyst": ["index.md", "contents.md"]}]
    for section in re.split(r"(?m)^## ", (DOCS / "index.md").read_text(encoding="utf-8"))[1:]:
        title, _, text = section.partition("\n")
        pages: list[Any] = listed("docs/index.md", text)
        for index in {"reference/models/index.md", "decisions/README.md"} & set(pages):
            inside = listed(f"docs/{index}", (DOCS / index).read_text(encoding="utf-8"))
            one = {
                "Models and controllers": [
                    index,
                    *(each for each in inside if each.startswith(index[:9])),
                ]
            }
            pages[pages.index(index)] = one if "models" in index else index
            pages += [each for each in inside if each.startswith("decisions/")]
        nav.append({title: pages})
    return nav


def lay_out(folder: Path) -> Path:
    """Write the pages and what they link into a folder, and beside them the tool's file; return that."""
    pages = [
        *MOVED,
        *(
            str(path.relative_to(ROOT))
            for end in ("md", "ipynb")
            for path in DOCS.rglob(f"*.{end}")
        ),
    ]
    files = [
        "CITATION.cff",
        "packages/dehyst-studio/src/dehyst_studio/html/dehyst.html",
        *(str(path.relative_to(ROOT)) for path in DOCS.rglob("*.ipynb")),
    ]
    for path in (*(DOCS / "images").rglob("*"), *(ROOT / "examples").rglob("*")):
        files += (
            [str(path.relative_to(ROOT))]
            if path.is_file() and "__pycache__" not in path.parts
            else []
        )
    for source in dict.fromkeys(pages):
        written = folder / "pages" / place(source)
        written.parent.mkdir(parents=True, exist_ok=True)
        written.write_text(page(source), encoding="utf-8")
    for source in files:
        copied = folder / "pages" / source.removeprefix("docs/")
        copied.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / source, copied)
    settings = (DOCS / "site.yml").read_text(encoding="utf-8") + f"nav: {json.dumps(order())}\n"
    (folder / "mkdocs.yml").write_text(settings, encoding="utf-8")
    return folder / "mkdocs.yml"


def draw_formulas(folder: Path) -> None:
    """Write formulas as MathML, which browsers draw without a script."""
    for path in folder.rglob("*.html"):
        text = path.read_text(encoding="utf-8")

        def drawn(match: re.Match[str]) -> str:
            if match[1] == "span":
                return str(latex2mathml.converter.convert(unescape(match[2])))
            formula = latex2mathml.converter.convert(unescape(match[2]), display="block")
            return f'<div style="overflow-x: auto; overflow-y: hidden">{formula}</div>'

        path.write_text(FORMULA.sub(drawn, text), encoding="utf-8")


def build(out: Path) -> None:
    """Build the site into a folder; a broken link fails."""
    with tempfile.TemporaryDirectory() as folder:
        settings = lay_out(Path(folder))
        tool = [sys.executable, "-m", "zensical", "build", "--strict", "--config-file", settings]
        subprocess.run(tool, check=True)
        draw_formulas(Path(folder) / "site")
        shutil.rmtree(out, ignore_errors=True)
        shutil.copytree(Path(folder) / "site", out)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--out", type=Path, default=ROOT / "site", help="folder of the site")
    build(parser.parse_args().out)
