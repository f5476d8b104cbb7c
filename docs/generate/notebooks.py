"""The notebooks of docs/notebooks/: run them, keep what is still true, show them as Markdown on the site."""

from __future__ import annotations

import json
import os
import re
import sys
import tempfile
import textwrap
from pathlib import Path
from typing import Any

from generate.blocks import WIDTH, agree

COLOUR = re.compile(r"\x1b\[[\d;]*m")  # of a terminal; Jupyter asks commands for it


def true_notebook(text: str, redraw: bool) -> str:
    """Return a notebook with what its cells print now; printed text that agrees stays, pictures too unless redrawn.

    No count of executions, no date, no version: the same bytes whenever nothing has changed.
    """
    import nbclient  # here: everything else of docs/build.py works without it
    import nbformat
    from traitlets.config import Config

    book, before = (nbformat.reads(text, as_version=4) for _ in range(2))
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", "")])
    with tempfile.TemporaryDirectory() as folder:
        private = Config(
            KernelManager={"transport": "ipc", "ip": f"{folder}/kernel"}
        )  # no port that others can reach
        here = {"metadata": {"path": folder}}
        client = nbclient.NotebookClient(
            book,
            timeout=600,
            resources=here,
            record_timing=False,
            coalesce_streams=True,
            config=private,
        )
        client.execute(
            env={**os.environ, "PATH": path, "COLUMNS": WIDTH, "NO_COLOR": "1", "TERM": "dumb"}
        )
    for cell, old in zip(book.cells, before.cells, strict=True):
        if cell.cell_type != "code":
            continue
        cell.execution_count, cell.metadata = None, {}
        same = len(cell.outputs) == len(old.outputs) and all(map(_same, old.outputs, cell.outputs))
        for shown, kept in zip(cell.outputs, old.outputs if same else cell.outputs, strict=True):
            if "execution_count" in shown:
                shown.execution_count = None
            if "text" in shown:
                shown.text = COLOUR.sub("", kept.text)
            for kind in shown.get("data", {}):
                if kind == "text/plain" or not redraw:
                    shown.data[kind] = kept.data[kind]
    book.metadata = {
        "kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"},
        "language_info": {"name": "python"},
    }
    return str(nbformat.writes(book)) + "\n"


def _same(old: Any, new: Any) -> bool:
    kinds = [set(one.get("data", {})) for one in (old, new)]
    return (
        old.output_type == new.output_type
        and kinds[0] == kinds[1]
        and agree(_said(old), _said(new))
    )


def _said(output: Any) -> str:
    """What an output prints, without its picture."""
    return COLOUR.sub(
        "", "".join(output.get("text", "") or output.get("data", {}).get("text/plain", ""))
    )


def printed(path: Path) -> str:
    """Return all that a notebook prints."""
    cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
    return "\n".join(_said(output) for cell in cells for output in cell.get("outputs", ()))


def as_markdown(path: Path) -> str:
    """Return a notebook as a page: text, code, and below each cell what it shows."""
    parts = []
    for cell in json.loads(path.read_text(encoding="utf-8"))["cells"]:
        source = "".join(cell["source"])
        if cell["cell_type"] == "markdown":
            parts.append(source)
            continue
        shell = source.startswith("%%sh\n")
        parts.append(
            f"```{'sh' if shell else 'python'}\n{source.removeprefix('%%sh' + chr(10))}\n```"
        )
        for output in cell["outputs"]:
            data = {kind: "".join(value) for kind, value in output.get("data", {}).items()}
            if "text/html" in data:
                parts.append(
                    f"<div data-search-exclude>{' '.join(data['text/html'].split())}</div>"
                )
            elif "image/png" in data:
                picture = "".join(data["image/png"].split())
                parts.append(
                    f'<img alt="What the cell above draws" src="data:image/png;base64,{picture}">'
                )
            else:
                lines = _said(output).rstrip().split("\n")
                wrapped = [
                    textwrap.fill(line, 80) if len(line) > int(WIDTH) else line for line in lines
                ]
                parts.append("\n".join(["```text", *wrapped, "```"]))
    note = (
        f"*This page is a notebook: [download it]({path.name}), or open it from `docs/notebooks/`.*"
    )
    return "\n\n".join(["---\nhide: [toc]\n---", parts[0], note, *parts[1:]]) + "\n"
