"""Text of others is shown, never obeyed: by no terminal, no spreadsheet, no page."""

import csv
import io
import json
import sys
import unicodedata

import numpy as np
import pytest

from dehyst import cli, read_log
from dehyst.errors import LogError
from dehyst.findings import Finding
from dehyst.io import format_csv, inspect_log, read_table, write_csv
from dehyst.io._write import write_table
from dehyst.shell import visible

HOSTILE = (
    "\x1b[31mred\x1b[0m",
    "\x1b]0;title\x07",
    "\x9b2J",
    "a\rb",
    "bell\x07\x08\x7f",
    "right\u202eleft\u2066x",
    "zero\u200bwidth\ufeff",
    "line\u2028par\u2029",
    "null\x00",
)
FORMULAS = (
    "=cmd|' /C calc'!A0",
    "+1+1",
    "-x",
    "@SUM(A1)",
    '=HYPERLINK("x","y")',
    "'=kept",
    "''@twice",
    "＝wide",
)
DATA = "\n".join(f"{k / 100},{np.sin(k / 9):.4f},{np.sin(k / 9 - 0.3):.4f}" for k in range(300))


def obeyed(text):
    """Return the characters of a text that a terminal obeys or hides."""
    return [
        c for c in text if unicodedata.category(c) in ("Cc", "Cf", "Cs", "Zl", "Zp") and c != "\n"
    ]


def run(monkeypatch, capsys, *words):
    monkeypatch.setattr(sys, "argv", ["dehyst", *map(str, words)])
    with pytest.raises(SystemExit) as end:
        cli.main()
    told = capsys.readouterr()
    return end.value.code, told.out, told.err


@pytest.mark.parametrize("name", HOSTILE)
def test_no_name_of_a_log_reaches_the_terminal_as_a_command_to_it(
    name, tmp_path, monkeypatch, capsys
):
    log = tmp_path / f"l{name.replace(chr(0), '')}.csv"
    log.write_text(f'time_s,"{name} [bar]","angle [{name}]"\n{DATA}\n', encoding="utf-8")
    monkeypatch.setenv("FORCE_COLOR", "")
    _, out, err = run(monkeypatch, capsys, "inspect", log)
    assert "angle" in out and not obeyed(out + err)
    status, out, err = run(
        monkeypatch, capsys, "identify", log, "--input", "nothing", "--output", "#3"
    )
    assert status == 2 and not obeyed(out + err)


@pytest.mark.parametrize("name", HOSTILE)
def test_what_is_shown_of_a_name_is_what_to_type(name, tmp_path):
    log = tmp_path / "log.csv"
    log.write_text(f'time_s,"{name} [bar]",angle_deg\n{DATA}\n', encoding="utf-8")
    shown = inspect_log(log).columns[1].name
    recording = read_log(log, shown, "angle_deg")
    assert recording.input_unit == "bar" and not obeyed(recording.input_name)
    assert (
        "unprintable-names" in [found.code for found in recording.findings]
        or shown == f"{name} [bar]"
    )


def test_errors_and_findings_are_fit_for_a_terminal_wherever_they_are_raised():
    for name in HOSTILE:
        assert not obeyed(str(LogError(f"no {name} here")))
        assert not obeyed(Finding("x", name).message)


def test_names_of_every_script_stay_as_they_are():
    for name in ("圧力 Δp", "Давление", "ضغط", "می‌خواهم", "Temp °C", "naïve  two blanks", "🦾"):
        assert visible(name) == name


@pytest.mark.parametrize("name", FORMULAS)
def test_no_cell_of_a_table_is_a_formula_and_names_come_back(name, tmp_path):
    text = format_csv({"time_s": np.arange(9) / 10, name: np.arange(9.0), "y": -np.arange(9.0)})
    rows = list(csv.reader(io.StringIO(text)))
    assert not any(cell[:1] in "=+-@＝" for cell in rows[0])
    assert rows[2][2] == "-1.0"  # numbers are numbers
    path = write_csv(tmp_path / "x.csv", {"time_s": np.arange(9) / 10, name: np.arange(9.0)})
    assert list(read_table(path).columns) == ["time_s", name]
    for kind in ("text", "mixed"):
        cells = [name, "plain", "-1.5"] if kind == "text" else [name, -1.5, None]
        written = write_table(tmp_path / "t.csv", {"n": cells}).read_text(encoding="utf-8")
        first = next(csv.reader([written.split("\n")[1]]))[0]
        assert first == f"'{name}" and "\n-1.5\n" in written


def test_a_simulation_writes_the_names_of_a_hostile_model_as_text(tmp_path, monkeypatch, capsys):
    log = tmp_path / "log.csv"
    log.write_text(f"time_s,\"=cmd|' /C calc'!A0 [bar]\",\x1b[31mangle\n{DATA}\n", encoding="utf-8")
    model = tmp_path / "m.json"
    words = ("identify", log, "--input", "#2", "--output", "#3", "--family", "pi", "--save", model)
    assert run(monkeypatch, capsys, *words)[0] == 0
    content = json.loads(model.read_text())
    assert not obeyed(json.dumps(content, ensure_ascii=False))
    status, out, err = run(monkeypatch, capsys, "simulate", model, log, "--input", "#2")
    assert status == 0 and not obeyed(out + err), err
    assert not any(cell[:1] in "=+-@" for cell in next(csv.reader(out.splitlines())))


HEADERS = {
    "a line break": 'time_s,"p\n[bar]","angle\n[deg]"',
    "line breaks of Windows": 'time_s,"p\r\n[bar]","angle\r\n[deg]"',
    "a delimiter": 'time_s,"p [bar]","angle, [deg]"',
    "doubled quotes": '"time_s","p [bar]","angle ""A"" [deg]"',
    "a mark": '\ufeff"time_s","p\n[bar]","angle [deg]"',
    "two marks": '\ufeff\ufeff"time_s","p [bar]","angle [deg]"',
    "a row of units": 'time,p,angle\n"s","\nbar","[deg\n]"',
    "every cell over three lines": '"time\n(stamp)\n[s]","p\nchamber 1\n[bar]","angle\n\n[deg]"',
    "inches in a comment": '# a 5" disc\ntime_s,"p\n[bar]",angle_deg',
}


@pytest.mark.spread(18)
@pytest.mark.parametrize("delimiter", [",", ";", "\t"])
@pytest.mark.parametrize("rows", [30, 3000])
@pytest.mark.parametrize("what", HEADERS)
def test_names_and_units_of_quoted_headers_are_kept_whole_and_in_parts(
    what, rows, delimiter, tmp_path, monkeypatch
):
    t = np.arange(rows) / 100
    lines = [delimiter.join(f"{v:.4f}" for v in (s, 3 * np.sin(s), 9 * np.sin(s - 0.3))) for s in t]
    head = HEADERS[what].replace('",', '"' + delimiter).replace(',"', delimiter + '"')
    head = head.replace(",p,", f"{delimiter}p{delimiter}").replace("time_s,", "time_s" + delimiter)
    head = head.replace(",angle", delimiter + "angle")
    log = tmp_path / "log.csv"
    log.write_bytes((head + "\n" + "\n".join(lines) + "\n").encode("utf-8"))
    table = read_table(log)
    assert list(table.units.values()) == ["s", "bar", "deg"]
    assert [name[:1] for name in table.columns] == ["t", "p", "a"]
    first = head.count("\n") + 2
    assert table.rows[0] == first and table.rows.size == rows
    changed = (
        any(break_ in cell for cell in HEADERS[what].split('"')[1::2] for break_ in "\n")
        and "units" not in what
    )
    assert changed == ("unprintable-names" in [found.code for found in table.findings])
    monkeypatch.setattr("dehyst.io._long.WHOLE_BYTES", 0)
    rec = read_log(log, "#2", "#3")
    assert (len(rec), rec.input_unit, rec.output_unit) == (rows, "bar", "deg")
