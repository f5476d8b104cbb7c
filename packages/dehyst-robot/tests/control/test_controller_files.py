"""Controller files with and without how the joint learns: both are read, neither can be edited unnoticed."""

import json

import pytest

from dehyst.errors import ModelFileError
from dehyst_robot.control import (
    Adaptation,
    JointControllerParameters,
    load_adaptation,
    load_controller,
    save_controller,
)

TOLD = JointControllerParameters(pole=5.0)


def test_a_file_without_adaptation_has_none(tmp_path):
    path = save_controller(TOLD, tmp_path / "a.json")
    assert json.loads(path.read_text())["schema"] == 1
    assert (load_controller(path), load_adaptation(path)) == (TOLD, None)


def test_a_file_with_adaptation_gives_it_back(tmp_path):
    path = save_controller(TOLD, tmp_path / "a.json", Adaptation(rate=0.1, rest=2.0))
    assert (load_controller(path), load_adaptation(path)) == (TOLD, Adaptation(rate=0.1, rest=2.0))


@pytest.mark.parametrize(
    "change", [{"schema": 2}, {"schema": True}, {"adaptation": {"rate": 5.0}}, {"adaptation": None}]
)
def test_a_file_that_was_edited_is_refused(change, tmp_path):
    path = save_controller(TOLD, tmp_path / "a.json", Adaptation())
    path.write_text(json.dumps(json.loads(path.read_text()) | change))
    with pytest.raises(ModelFileError, match=r"checksum|schema version"):
        load_controller(path)
