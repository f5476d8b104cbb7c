"""Every line that is printed to be typed does what it says, whatever files and columns are called."""

import ast
import re
import shlex
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from typer.main import get_command
from typer.testing import CliRunner

import dehyst
from dehyst.app._design import judged_on_test
from dehyst.cli import app
from dehyst.design import design_excitation
from dehyst.errors import IdentificationError
from dehyst.families import ROWS
from dehyst.identification._split import split_recordings
from dehyst.shell import command, visible
from places import SOURCES

LINE = re.compile(r"dehyst [a-z]+ .*")
WORDS = st.text(
    st.characters(min_codepoint=33, exclude_categories=["Cs", "Cc", "Cf"]), min_size=1, max_size=12
)
FILES = [
    "-rf",
    "two  blanks",
    "[1]",
    "--help",
    "--",
    "a b",
    "it's",
    "$HOME",
    "`id`",
    "<img src=x>",
    "--run=2",
    "*",
    "~",
    "x;y",
    "%PATH%",
    "a&b",
]
COLUMNS = [
    "---",
    "-",
    "--input",
    "--help",
    "a b",
    "it's",
    '"q"',
    "$x",
    "`id`",
    "p=3",
    "<b>",
    "~",
    "#3",
    "a;b",
    "\\",
    "\x1b[31mred",
    "a\u202eb",
]


def typed(line, folder, monkeypatch):
    """Type a line in a folder, as a shell would take it apart."""
    monkeypatch.chdir(folder)
    words = shlex.split(line)
    assert words[0] == "dehyst"
    return CliRunner().invoke(app, words[1:])


def following(result):
    """The line that a command says comes next."""
    lines = [line for line in result.output.splitlines() if line.startswith("next: ")]
    return LINE.search(lines[-1])[0]


def write_loop(path, x_name="x", y_name="y", time=False):
    """Decaying loops of two plays; columns of any name."""
    t = np.linspace(0.0, 40.0, 600)
    x = 2 * np.sin(t) * np.linspace(1, 0.3, t.size)
    y = dehyst.PrandtlIshlinskii([0.0, 0.6], [1.0, 0.5]).simulate(x)
    names = [f'"{name.replace(chr(34), 2 * chr(34))}"' for name in (x_name, y_name)]
    head, columns = ",".join(names), [x, y]
    if time:
        head, columns = f"time_s,{head}", [t, x, y]
    rows = "\n".join(
        ",".join(f"{value:.6f}" for value in row) for row in zip(*columns, strict=True)
    )
    path.write_text(f"{head}\n{rows}\n", encoding="utf-8")


@pytest.mark.slow
@given(WORDS, WORDS, WORDS)
def test_any_word_arrives_at_its_option_or_argument(file, driving, answering):
    line = command(
        "identify", file, input=driving, output=answering, run=[driving, answering], overwrite=True
    )
    parser = get_command(app).commands["identify"]
    parsed = parser.make_context("identify", shlex.split(line)[2:]).params
    assert [str(each) for each in parsed["logs"]] == [str(Path(file))]
    assert (parsed["input"], parsed["output"], list(parsed["runs"])) == (
        driving,
        answering,
        [driving, answering],
    )
    assert parsed["overwrite"] is True


def chain(folder, monkeypatch, file, driving, answering):
    """Inspect, identify, compensate, evaluate, compare: each by the line that one before printed."""

    def done(line):
        result = typed(line, folder, monkeypatch)
        assert result.exit_code == 0, f"{line}\n{result.output}"
        return result

    write_loop(folder / file, driving, answering)
    write_loop(folder / "REFERENCE.csv", driving, answering)
    shown = done(command("inspect", file))
    driving, answering = visible(driving), visible(answering)  # as they are shown they are typed
    done(f"{following(shown)} --family pi --json")
    saved = done(
        command("identify", file, input=driving, output=answering, family="pi", save="model.json")
    )
    done(f"{following(saved)} --out x.csv")
    scored = done(command("evaluate", "model.json", file))
    done(f"{following(scored)} --out x.csv --overwrite")
    compared = done(
        f"{command('compare', file, input=driving, output=answering)} --families pi,static"
    )
    done(f"{following(compared)} --family pi --overwrite --json")


NASTY = list(zip(FILES, COLUMNS, [*COLUMNS[1:], COLUMNS[0]], strict=False))


@pytest.mark.slow
@pytest.mark.parametrize(("file", "driving", "answering"), NASTY)
def test_lines_of_nasty_names_can_be_typed_one_after_the_other(
    tmp_path, monkeypatch, file, driving, answering
):
    chain(tmp_path, monkeypatch, f"{file}.csv", driving, answering)


@pytest.mark.slow
def test_no_line_is_made_by_hand():
    commands = "|".join(get_command(app).commands)
    line = re.compile(rf"dehyst ({commands}) [^`.;]*$")
    by_hand = []
    for path in (path for folder in SOURCES.values() for path in folder.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if not isinstance(node, ast.JoinedStr):
                continue
            for text, value in zip(node.values, node.values[1:], strict=False):
                if (
                    isinstance(text, ast.Constant)
                    and line.search(text.value)
                    and isinstance(value, ast.FormattedValue)
                ):
                    by_hand.append(f"{path.name}:{node.lineno}: {text.value[-60:]}")
    assert by_hand == []


@pytest.mark.parametrize("row", [row.name for row in ROWS])
def test_a_row_without_time_is_identified_by_its_name_or_the_name_in_the_refusal_is(row):
    x = np.sin(np.linspace(0, 30, 400)) * np.linspace(1, 0.4, 400)
    rec = dehyst.Recording(
        input=x, output=dehyst.PrandtlIshlinskii([0.0, 0.3], [1.0, 0.5]).simulate(x)
    )
    try:
        assert dehyst.identify(rec, row).family == row
    except IdentificationError as refused:
        other = re.search(r"--family ([\w-]+)", str(refused))[1]
        assert dehyst.identify(rec, other).family == other != row


def test_what_auto_took_without_time_is_taken_by_its_name():
    rng = np.random.default_rng(3)
    x = np.sin(np.linspace(0, 30, 600)) * np.linspace(1, 0.4, 600)
    stops = sum(
        w * (x - dehyst.PrandtlIshlinskii([r], [1.0]).simulate(x))
        for r, w in ((0.1, 1.0), (0.4, 0.7))
    )
    rec = dehyst.Recording(input=x, output=stops + 0.1 * x**3 + 0.001 * rng.normal(size=x.size))
    auto = dehyst.identify(rec)
    again = dehyst.identify(rec, auto.family)
    assert again.family == auto.family and again.test.rmse == pytest.approx(auto.test.rmse, rel=0.5)


@pytest.mark.slow
def test_compare_prints_the_line_that_makes_the_model_it_names(tmp_path, monkeypatch):
    write_loop(tmp_path / "log.csv", time=True)
    shown = typed(
        "dehyst compare log.csv --input x --output y --families pi,static --train-fraction 0.6 --from 1 --to 39",
        tmp_path, monkeypatch,
    )  # fmt: skip
    line = following(shown)
    assert "--train-fraction 0.6" in line and "--from 1.0 --to 39.0" in line
    done = typed(f"{line} --json", tmp_path, monkeypatch)
    assert done.exit_code == 0, done.output


@pytest.mark.exhaustive
@pytest.mark.parametrize("timed", [False, True])
def test_every_family_of_compare_is_made_again_by_its_name(timed):
    rng, t = np.random.default_rng(0), np.linspace(0.0, 40.0, 500)
    x = 2 * np.sin(t) * np.linspace(1.0, 0.3, t.size)
    y = dehyst.PrandtlIshlinskii([0.0, 0.6], [1.0, 0.5]).simulate(x) + 0.02 * rng.normal(
        size=t.size
    )
    rec = dehyst.Recording(input=x, output=y, time=t if timed else None)
    for entry in dehyst.compare(rec, train_fraction=0.6).entries:
        if entry.model is not None:
            again = dehyst.identify(rec, entry.family, train_fraction=0.6)
            assert again.test.rmse_percent == pytest.approx(entry.error_percent, rel=1e-6), (
                entry.family
            )


PLANS = [(1e-4, 12.0, (0.0, 150.0), 6000.0), (0.02, 600.0, (-30.0, 30.0), None), (1.0, 30000.0, (0.0, 100.0), 0.5),
         (0.003, 300.0, (-4.0, 4.0), 4.0), (1 / 3, 9000.0, (0.0, 5.0), 0.1)]  # fmt: skip


@pytest.mark.parametrize(("period", "limit", "span", "rate"), PLANS)
@pytest.mark.parametrize("wobble", [0.0, 0.3])
def test_the_line_of_design_splits_its_log_to_the_sample(period, limit, span, rate, wobble):
    plan = design_excitation(*span, rate=rate, time_limit=limit, period=period)
    time, value, part = plan.signal()
    cut = {name: float(text) for name, text in judged_on_test(plan).items()}
    clock = time + wobble * period * np.random.default_rng(1).uniform(-1, 1, time.size)
    inside = (clock >= cut["from"]) & (clock < cut["to"])
    rec = dehyst.Recording(input=value[inside], output=value[inside], time=clock[inside])
    end = split_recordings([rec], cut["train_fraction"]).ends[0]
    assert set(part[inside][:end]) == {"loops", "holds"} and set(part[inside][end:]) == {"test"}
    assert np.sum(part != "home") == inside.sum() and np.sum(part == "test") == inside.sum() - end
