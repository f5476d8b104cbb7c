"""A cap on the numbers of a model, and a processor that sets one: it is kept, with as little error as there can be."""

import json
import re
from itertools import pairwise

import numpy as np
import pytest

import dehyst
from dehyst.errors import IdentificationError, ParameterError
from dehyst.export import kit as export_kit
from dehyst.export import subject_of
from dehyst.io import example_recording, write_csv
from dehyst.models import load
from places import ROOT

SIZES = (3, 8, 15, 25, 40, 100)
ROWS = ("play-sum", "creep-pi", "inverse-stop", "elements")


@pytest.fixture(scope="module")
def record():
    return example_recording()


@pytest.fixture(scope="module")
def log(tmp_path_factory, record):
    path = tmp_path_factory.mktemp("size") / "log.csv"
    write_csv(path, {"time_s": record.time, "bar": record.input, "angle": record.output})
    return path


@pytest.mark.exhaustive
def test_no_model_has_more_numbers_than_were_asked_for_and_more_numbers_err_less(record):
    fits = [dehyst.identify(record, size=size) for size in (*SIZES, None)]
    for fit, size in zip(fits, SIZES, strict=False):
        assert fit.model.free_parameters <= size
    errors = [fit.test.rmse_percent for fit in fits]
    for smaller, larger in pairwise(errors):
        assert larger <= 1.1 * smaller
    assert errors[-1] < 0.1 * errors[0]


@pytest.mark.parametrize("family", [*ROWS[:-1], pytest.param(ROWS[-1], marks=pytest.mark.slow)])
def test_a_row_keeps_the_size_and_stays_what_it_is(record, family):
    fit = dehyst.identify(record, family, size=24)
    assert fit.model.free_parameters <= 24
    assert family in ("elements", fit.family)
    assert not fit.model.no_inverse
    assert fit.test.rmse < 0.5 * fit.static_test.rmse


@pytest.mark.parametrize("family", ["play-sum", "creep-pi"])
def test_a_size_that_is_no_limit_changes_no_error_much(record, family):
    free = dehyst.identify(record, family)
    capped = dehyst.identify(record, family, size=free.model.free_parameters)
    assert capped.model.free_parameters <= free.model.free_parameters
    assert capped.test.rmse <= 1.1 * free.test.rmse


def test_a_row_that_cannot_be_so_small_says_how_small_it_can_be(record):
    with pytest.raises(
        IdentificationError, match=r"at most 3 numbers .* smallest has (\d+)"
    ) as raised:
        dehyst.identify(record, "creep-pi", size=3)
    smallest = raised.value.facts["smallest"]
    assert dehyst.identify(record, "creep-pi", size=smallest).model.free_parameters <= smallest


@pytest.mark.parametrize(
    ("family", "settings", "why"),
    [
        ("auto", {"size": 2}, "whole number of 3 or more"),
        ("auto", {"size": True}, "whole number of 3 or more"),
        ("auto", {"size": 20.5}, "whole number of 3 or more"),
        ("auto", {"size": 20, "n": 30}, "Give one of them"),
        ("pi", {"size": 20}, "leave the family out"),
        ("lugre", {"size": 20}, "leave the family out"),
        ("direct-inverse", {"size": 20}, "leave the family out"),
    ],
)
def test_a_size_that_says_nothing_is_refused(record, family, settings, why):
    with pytest.raises(ParameterError, match=why):
        dehyst.identify(record, family, **settings)


@pytest.mark.exhaustive
@pytest.mark.parametrize("period", [0.02, 0.001, 0.0001])
def test_the_model_for_a_processor_keeps_its_period_there(run, log, tmp_path, period):
    model_file = tmp_path / "m.json"
    line = ("identify", log, "--processor", "cortex-m4f", "--period", period, "--save", model_file)
    status, out, err = run(*line, "--json")
    assert status == 0, err
    step = json.loads(out)["step"]
    assert step["fits"] and step["most"] <= period
    unit = subject_of(load(model_file), name="u", period=period, real=step["real"])
    assert export_kit.budget(unit).seconds()["cortex-m4f"] == (step["typical"], step["most"])
    warned = [finding["code"] for finding in json.loads(out)["warnings"]]
    assert ("smaller-for-period" in warned) is (period == 0.0001)


@pytest.mark.slow
def test_a_period_that_no_model_keeps_is_said(run, tmp_path):
    x = 2 * np.sin(np.arange(600) / 20) * np.linspace(1.0, 0.3, 600)
    y = dehyst.PrandtlIshlinskii([0.0, 0.6], [1.0, 0.5]).simulate(x)
    write_csv(tmp_path / "log.csv", {"time_s": np.arange(600) / 100, "bar": x, "angle": y})
    status, out, _ = run(
        "identify", tmp_path / "log.csv", "--processor", "cortex-m7", "--period", 1e-9
    )
    assert status == 0
    assert "step-exceeds-period" in out and "Call it more seldom (--period" in " ".join(out.split())


def figures(record, size):
    """A line of the table: family, numbers, errors, and microseconds of a step in double and in float."""
    fit = dehyst.identify(record, size=size)
    errors = (f"{fit.test.rmse_percent:.2f}", f"{fit.input_test.rms_percent:.2f}")
    times = []
    for real in ("double", "float"):
        unit = subject_of(fit.model, name="u", real=real, period=0.001)
        seconds = export_kit.budget(unit).seconds()["cortex-m4f"]
        times.append(", ".join(f"{float(f'{1e6 * time:.2g}'):g}" for time in seconds))
    return [fit.family, str(fit.model.free_parameters), *errors, *times]


@pytest.mark.exhaustive
def test_the_table_of_sizes_is_as_the_decision_says(record):
    text = (ROOT / "docs" / "decisions" / "0065-size-and-processor.md").read_text()
    rows = re.findall(r"(?m)^\| (no cap|\d+) \| (.*) \|$", text)
    assert len(rows) == 7
    for size, line in rows:
        asked = None if size == "no cap" else int(size)
        assert line.split(" | ") == figures(record, asked)


@pytest.mark.parametrize(
    ("options", "cure"),
    [
        (("--processor", "z80"), "there are: cortex-m4f, cortex-m7"),
        (("--period", "0.001"), "Add --processor cortex-m4f"),
        (("--processor", "cortex-m7", "--period", "-1"), "give seconds, such as 0.001"),
        (
            ("--processor", "cortex-m7", "--family", "direct-inverse"),
            "has the size that its terms take",
        ),
    ],
)
def test_a_processor_that_is_none_is_refused_before_any_work(run, log, options, cure):
    status, _, err = run("identify", log, *options)
    assert status == 2
    assert cure in " ".join(err.split())
