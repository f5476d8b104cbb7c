"""A sheet of a workbook can be named, in Python and wherever a command reads logs."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import dehyst
from dehyst.app import requests
from dehyst.errors import LogError
from dehyst.io import read_table

openpyxl = pytest.importorskip("openpyxl", reason="openpyxl writes the workbooks")
pytest.importorskip("python_calamine", reason="the extra dehyst[excel] is not installed")

T = np.arange(400) * 0.05


@pytest.fixture
def book(tmp_path: Path) -> Path:
    """Long notes, and two logs of different gain."""
    work = openpyxl.Workbook()
    work.active.title = "notes"
    for k in range(900):
        work.active.append(["clamped" if k % 2 else "checked"])
    for name, gain in (("10 MPa", 1.0), ("20MPa", 2.0)):
        sheet = work.create_sheet(name)
        sheet.append(["time_s", "force_N", "position_mm"])
        for t in T.tolist():
            x = float(np.sin(t) * (1.5 + np.sin(0.11 * t)))
            sheet.append([t, x, gain * x + 0.1 * float(np.cos(t))])
        if name == "20MPa":
            sheet.append([20.0, 0.5, 0.1])
    work.save(tmp_path / "book.xlsx")
    return tmp_path / "book.xlsx"


@pytest.mark.parametrize(
    ("sheet", "gain"), [("10 MPa", 1), ("20MPa", 2), ("20mpa", 2), ("2", 1), (3, 2), (None, 2)]
)
def test_a_sheet_is_named_or_numbered_and_else_the_one_with_the_most_numbers(
    book: Path, sheet: object, gain: int
) -> None:
    rec = dehyst.read_log(book, "force", "position", sheet=sheet)  # type: ignore[arg-type]
    assert np.polyfit(rec.input, rec.output, 1)[0] == pytest.approx(gain, abs=0.05)
    assert rec.provenance["sheet"] == ("10 MPa" if gain == 1 else "20MPa")
    assert [finding.code for finding in rec.findings] == (["sheet"] if sheet is None else [])


@pytest.mark.parametrize("sheet", ["30MPa", "4", "0", 7])
def test_a_sheet_that_is_not_there_is_answered_with_all_that_are(book: Path, sheet: object) -> None:
    with pytest.raises(
        LogError, match=r"--sheet notes .*--sheet \"10 MPa\" \(401 rows\), --sheet 20MPa"
    ):
        read_table(book, sheet)  # type: ignore[arg-type]


def test_a_sheet_without_numbers_is_answered_with_the_others(book: Path) -> None:
    with pytest.raises(
        LogError, match=r"sheet 'notes' .* no table of numbers.*--sheet 20MPa"
    ) as caught:
        read_table(book, "notes")
    assert "delimiter" not in str(caught.value)


def test_what_has_no_sheets_refuses_one(tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_text("time_s,x,y\n0,1,2\n1,2,3\n")
    np.savez(tmp_path / "log.npz", x=T, y=T)
    for name in ("log.csv", "log.npz"):
        with pytest.raises(LogError, match="is no workbook"):
            read_table(tmp_path / name, 1)


def test_every_request_that_reads_a_log_with_a_time_column_has_the_option() -> None:
    kinds = [
        kind
        for kind in vars(requests).values()
        if isinstance(kind, type) and kind.__name__.endswith("Request")
    ]
    names = {kind.__name__: {field.name for field in fields(kind)} for kind in kinds}
    lacking = [name for name, has in names.items() if has & {"log", "logs"} and "sheet" not in has]
    assert names and lacking == []


@pytest.mark.slow
def test_commands_read_the_sheet_that_is_named(
    book: Path, tmp_path: Path, run: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)

    def shown(*words: str) -> str:
        status, out, err = run(*words)
        assert not status, err
        return str(out)

    assert '--sheet "10 MPa"' in " ".join(
        shown("inspect", "book.xlsx", "--sheet", "10 MPa").split()
    )
    columns = ("--sheet", "10 MPa", "--input", "force_N", "--output", "position_mm")
    shown(
        "identify",
        "book.xlsx",
        *columns,
        "--family",
        "pi",
        "--save",
        "model.json",
        "--train-fraction",
        "1",
    )
    assert '"sheet": "10 MPa"' in (tmp_path / "model.json").read_text()
    assert len(shown("simulate", "model.json", "book.xlsx", "--sheet", "20MPa").splitlines()) == 402
