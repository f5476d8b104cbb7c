"""C of two inputs and two outputs: the model's answers to the bit, what is refused, and what verify says of it."""

import json
import subprocess

import numpy as np
import pytest

from dehyst.errors import InvertibilityError, OutputError, ParameterError
from dehyst.export import verify, write_pair
from dehyst.families._elements import Element
from dehyst.families.kit import CoupledModel, ElementModel
from dehyst.models import SignalCard

A, B, X, Y = (SignalCard(name, "mm", -1.0, 1.0) for name in "abxy")
OWN = ElementModel(
    (
        Element("input", weight=0.6),
        Element("play", 0.2, weight=0.3),
        Element("creep", 0.1, 0.5, 0.1),
    ),
    period=0.01,
)
BENT = Element("play", 0.3, weight=1.0, map=((-1.0, 0.0, 1.0), (-0.1, 0.0, 0.2)))


def model(first=1.0, second=-1.0, crossed=False):
    across = tuple(
        ElementModel((Element("input", weight=0.1 * s), BENT), 0.1, period=0.01)
        for s in (first, second)
    )
    rows = (OWN, across[0]), (across[1], OWN)
    if crossed:
        rows = rows[1], rows[0]
    return CoupledModel(rows, (A, B), (X, Y), (0.25, -0.5), 0.01)


@pytest.mark.slow
@pytest.mark.parametrize("real", ["double", "float"])
@pytest.mark.parametrize("direction", ["inverse", "forward"])
@pytest.mark.parametrize("crossed", [False, True])
def test_every_compiler_gives_the_answers_of_the_model(tmp_path, real, direction, crossed):
    folder = tmp_path / "stage"
    write_pair(model(crossed=crossed), folder, name="stage", direction=direction, real=real)
    checks = verify(folder)
    assert all(check.ok for check in checks), checks
    assert sum(check.ran for check in checks) >= 2


def test_the_program_answers_what_python_answers(tmp_path):
    folder = tmp_path / "stage"
    pair = model()
    write_pair(pair, folder, name="stage")
    run = subprocess.run(
        ["make", "-s", "run"], cwd=folder, capture_output=True, text=True, check=True
    )
    rows = np.array([line.split() for line in run.stdout.splitlines()], dtype=float)
    expected, _, _ = pair.pair(True, ((-1.0, 1.0), (-1.0, 1.0))).run(
        np.ascontiguousarray(rows[:, :2]), np.full(40, 0.01)
    )
    assert np.max(np.abs(rows[:, 2:] - expected)) < 1e-4


def test_an_edited_file_is_named(tmp_path):
    folder = tmp_path / "stage"
    write_pair(model(), folder, name="stage")
    (folder / "src" / "stage.c").write_text("int stage;\n")
    faults = [check for check in verify(folder) if not check.ok]
    assert any("src/stage.c" in check.detail for check in faults)
    with pytest.raises(OutputError, match="not as it was written"):
        write_pair(model(), folder, name="stage")
    write_pair(model(), folder, name="stage", overwrite=True)


def test_a_manifest_with_other_settings_is_no_such_export(tmp_path):
    folder = tmp_path / "stage"
    write_pair(model(), folder, name="stage")
    path = folder / "manifest.json"
    for change in (
        {"limits": [[-1.0, 1.0]]},
        {"period": "soon"},
        {"limits": [[-2.0, 2.0], [-1.0, 1.0]]},
    ):
        manifest = json.loads(path.read_text())
        manifest["settings"] |= change
        path.write_text(json.dumps(manifest))
        assert any(not check.ok for check in verify(folder))


def one_output():
    return CoupledModel(model().paths[:1], (A, B), (X,), (0.0, 0.0), 0.01)


@pytest.mark.parametrize(
    ("made", "options", "fault", "words"),
    [
        (lambda: OWN, {}, ParameterError, "no model of several inputs"),
        (one_output, {}, ParameterError, "two inputs and two outputs"),
        (model, {"name": "int"}, ParameterError, "int"),
        (model, {"direction": "back"}, ParameterError, "direction"),
        (model, {"period": 0.0}, ParameterError, "a period of 0 s"),
        (model, {"limits": [(1.0, -1.0), (-1.0, 1.0)]}, ParameterError, "the limits of a are"),
        (lambda: model(9.0, 9.0), {}, InvertibilityError, "determinant"),
    ],
)
def test_what_cannot_be_written_is_refused_before_a_file_is(tmp_path, made, options, fault, words):
    with pytest.raises(fault, match=words):
        write_pair(made(), tmp_path / "stage", **options)
    assert not (tmp_path / "stage").exists()
