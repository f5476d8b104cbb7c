"""CONTRIBUTING shows a new family as one file, one line and one test file: executed here as they stand there."""

import importlib.util
import inspect
import re
import sys
from pathlib import Path

import numpy as np
import pytest

import test_families_conformity as conformity
from dehyst import Recording, compare, load
from dehyst.families import STARTS, example, identify_family, registry, rows, table

PAGE = (Path(__file__).parents[1] / "CONTRIBUTING.md").read_text(encoding="utf-8")
SECTION = PAGE.partition("### A family for comparison")[2].partition("\n#")[0]
ROW = re.search(r"(?ms)^### A row of elements.*?^```text\n(.*?)^```$", PAGE)[1]
FAMILY, LINE, TESTS = re.findall(r"(?ms)^```python\n(.*?)^```$", SECTION)
OF_RATE = {"test_a_rate_dependent_family_asks_for_time"}
PROMISES = [value for name, value in vars(conformity).items() if name.startswith("test_") and name not in OF_RATE]


@pytest.fixture
def registered(tmp_path, monkeypatch):
    """The file and the line of CONTRIBUTING, as if they were part of the package."""
    ((name, module),) = eval("{" + LINE + "}").items()
    path = tmp_path / "backlash.py"
    path.write_text(FAMILY, encoding="utf-8")
    spec = importlib.util.spec_from_file_location(module, path)
    loaded = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, module, loaded)
    spec.loader.exec_module(loaded)
    monkeypatch.setitem(registry.MODULES, name, module)
    return name


@pytest.fixture
def tabled(monkeypatch):
    """The row of CONTRIBUTING, as if it stood in the table."""
    (row,) = eval(f"({ROW.strip()})", {"_row": table._row})
    monkeypatch.setattr(registry, "ROWS", (*registry.ROWS, row.name))
    monkeypatch.setitem(rows.FAMILIES, row.name, rows.family_of(row))
    return row.name


@pytest.mark.parametrize(
    "promise",
    [value for name, value in vars(conformity).items() if name.startswith("test_")],
    ids=lambda promise: promise.__name__.removeprefix("test_"),
)
def test_the_row_shown_keeps_what_every_family_promises(tabled, promise):
    starts = STARTS if "start" in inspect.signature(promise).parameters else (None,)
    for start in starts:
        promise(tabled, **({} if start is None else {"start": start}))


def test_the_row_shown_is_fitted_inverted_saved_and_loaded(tabled, tmp_path):
    t = 0.01 * np.arange(1500)
    x = np.sin(1.7 * t) * np.linspace(1.0, 0.4, t.size)
    fit = identify_family(Recording(input=x, output=example(tabled).simulate(x, t), time=t), tabled)
    assert fit.family == fit.model.family == tabled and fit.test.rmse_percent < 2.0
    again = load(fit.model.save(tmp_path / "row.json"))
    assert np.max(np.abs(again.inverse().simulate(fit.model.simulate(x, t), t) - x)) < 1e-9


def test_the_tests_shown_pass(registered):
    shown = {}
    exec(compile(TESTS, "CONTRIBUTING.md", "exec", dont_inherit=True), shown)
    tests = [value for name, value in shown.items() if name.startswith("test_")]
    assert len(tests) == 2
    for test in tests:
        test()


@pytest.mark.parametrize("promise", PROMISES, ids=lambda promise: promise.__name__.removeprefix("test_"))
def test_the_family_shown_keeps_what_every_family_promises(registered, promise):
    starts = STARTS if "start" in inspect.signature(promise).parameters else (None,)
    for start in starts:
        promise(registered, **({} if start is None else {"start": start}))


def test_the_family_shown_takes_part_in_the_command(registered, run, tmp_path):
    x = np.sin(np.linspace(0.0, 40.0, 900)) * np.linspace(1.0, 0.4, 900)
    y = example(registered).simulate(x)
    np.savetxt(tmp_path / "log.csv", np.column_stack([x, y]), delimiter=",", header="x_bar,y_deg", comments="")
    model = tmp_path / "model.json"
    signals = ("--input", "x_bar", "--output", "y_deg", "--families", f"static,{registered}", "--save", model)
    status, out, err = run("compare", tmp_path / "log.csv", *signals)
    assert status == 0 and out.startswith(f"{registered} has the smallest error"), out + err
    assert load(model).family == registered
    status, _, err = run("compensate", model, tmp_path / "log.csv", "--output", "y_deg", "--out", tmp_path / "x.csv")
    assert status == 0, err


def test_the_family_shown_says_why_it_cannot_fit_a_clockwise_loop(registered):
    x = np.sin(np.linspace(0.0, 40.0, 900)) * np.linspace(1.0, 0.4, 900)
    found = compare(Recording(input=x, output=x - 0.6 * example(registered).simulate(x)), [registered])
    assert "clockwise" in found[registered].reason


def test_a_mistake_in_the_family_shown_would_be_noticed(registered, monkeypatch):
    """The promises can fail: a model that forgets its memory between two calls breaks the first."""
    record = type(example(registered))
    whole = record.run
    monkeypatch.setattr(record, "run", lambda self, x, dt, memory: whole(self, x, dt, self.rest(float(x[0]))))
    with pytest.raises(AssertionError):
        conformity.test_a_run_cut_in_pieces_is_the_same_run_bit_for_bit(registered)
