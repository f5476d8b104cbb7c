"""What is given in a wrong way in Python ends in an error that says what to type."""

import numpy as np
import pandas
import pytest

import dehyst
import dehyst.families._elements
from dehyst.errors import DehystError, LogError, ModelFileError, ParameterError, TimeError
from in_one import in_one

U = np.sin(np.linspace(0, 30, 400))
Y = 2 * U


def frame():
    return pandas.DataFrame({"time_s": np.arange(400.0), "pressure_bar": U, "angle_deg": Y})


WRONG = {
    "two arrays": ((U, Y), "dehyst.Recording(input=u, output=y"),
    "an array": ((U,), "dehyst.Recording(input=u, output=y"),
    "a matrix": (
        (np.column_stack([U, Y]),),
        "dehyst.Recording(input=data[:, 0], output=data[:, 1])",
    ),
    "lists": (([0.0, 1.0], [1.0, 2.0]), "dehyst.Recording(input=u, output=y"),
    "a table": (
        (frame(),),
        "dehyst.Recording.from_frame(table, input='pressure_bar', output='angle_deg', time='time_s')",
    ),
    "a path": (("log.csv",), "dehyst.read_log('log.csv', input='...', output='...')"),
    "nothing": ((None,), "dehyst.read_log"),
    "an empty list": (([],), "dehyst.read_log"),
    "a dictionary": (({"u": U},), "dehyst.read_log"),
}
TAKERS = (
    dehyst.identify,
    lambda records, *_: dehyst.identify(records, "dahl"),
    lambda records, *_: dehyst.identify(records, "direct-inverse"),
    lambda records, *_: dehyst.drift(dehyst.PrandtlIshlinskii([0.0], [1.0]), records),
)


@in_one("take", range(len(TAKERS)))
@in_one("what", WRONG)
def test_what_is_no_recording_is_refused_with_the_line_that_makes_one(what, take):
    given, cure = WRONG[what]
    with pytest.raises(ParameterError) as fault:
        TAKERS[take](*given[: 2 if take == 0 else 1])
    assert cure in str(fault.value) and len(str(fault.value)) < 500


def test_a_path_is_no_signal():
    for model in (
        dehyst.PrandtlIshlinskii([0.0], [1.0]),
        dehyst.families._elements.ElementModel.example(),
    ):
        with pytest.raises(ParameterError, match=r"dehyst.read_log\('base.csv', input="):
            model.simulate("base.csv")


def test_the_line_that_is_shown_makes_a_recording():
    for what, names in (
        ("two arrays", {"u": U, "y": Y, "t": np.arange(400.0)}),
        ("a table", {"table": frame()}),
    ):
        with pytest.raises(ParameterError) as fault:
            dehyst.identify(*WRONG[what][0])
        line = str(fault.value).partition("recording = ")[2].rpartition(", and give that")[0]
        assert len(eval(line, {"dehyst": dehyst, **names})) == 400


def test_a_generator_of_recordings_is_a_list_of_them():
    fit = dehyst.identify((dehyst.Recording(U, Y + k) for k in (0, 1)), "pi")
    assert fit.model.family == "pi"


@in_one("family", [Y, None, 3, ["pi"]])
def test_a_family_that_is_no_name_is_refused(family):
    with pytest.raises(ParameterError, match="There are: auto"):
        dehyst.identify(dehyst.Recording(U, Y), family)


@in_one("given", [U, None, 3])
def test_a_log_that_is_no_path_is_refused_with_both_ways_out(given):
    with pytest.raises(LogError, match=r"(?s)no path.*'log.csv'.*dehyst.Recording\("):
        dehyst.read_log(given, "u", "y")


@in_one("column", [0, None, U, 2.5])
def test_a_column_that_is_no_name_is_refused_with_the_names_there_are(column, tmp_path):
    path = dehyst.io.write_csv(tmp_path / "log.csv", {"pressure_bar": U, "angle_deg": Y})
    with pytest.raises(DehystError, match="pressure_bar, angle_deg"):
        dehyst.read_log(path, column, "angle_deg")


def test_a_family_that_is_nearly_spelt_is_named():
    with pytest.raises(ParameterError, match=r"Did you mean bouc-wen\?"):
        dehyst.identify(dehyst.Recording(U, Y), "bouc_wen")


@in_one("model", [dehyst.PrandtlIshlinskii([0.0], [1.0]), dehyst.families.example("dahl")])
def test_a_model_is_no_log_and_a_log_no_model(tmp_path, model):
    """A model file was read as text with a column '['."""
    path, log = model.save(tmp_path / "m.json"), tmp_path / "log.csv"
    with pytest.raises(LogError, match="is a model that dehyst saved"):
        dehyst.read_log(path, "a", "b")
    log.write_text("a,b\n1,2\n")
    with pytest.raises(ModelFileError, match="If it is a log, name it behind the model"):
        dehyst.load(log)


@in_one("window", [("start", 100.0, "100 s <= t; "), ("stop", -1.0, "t < -1 s; ")])
def test_a_window_without_samples_is_told_by_the_end_that_was_named(tmp_path, window):
    (tmp_path / "log.csv").write_text(
        "time_s,a,b\n" + "".join(f"{k},{k % 7},{k % 5}\n" for k in range(60))
    )
    name, value, words = window
    with pytest.raises(TimeError, match=f"lies in the window {words}"):
        dehyst.read_log(tmp_path / "log.csv", "a", "b", **{name: value})
