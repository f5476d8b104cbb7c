"""Sweep files: what they mean, and that a wrong one is refused with a cure before anything runs."""

import tomllib

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dehyst.errors import DehystError, ParameterError
from dehyst_robot.arm import load_robot
from dehyst_robot.experiments._sweep.points import expand_points
from dehyst_robot.experiments._sweep.run import arguments_of
from dehyst_robot.experiments._sweep.spec import load_sweep, parse_sweep
from places import ROOT

EXAMPLE = ROOT / "examples" / "sensitivity.toml"
SIZE = '[[study]]\nname = "size"\n'


def sweep(text):
    return parse_sweep(tomllib.loads(text))


def values(text):
    return [point.values for point in expand_points(sweep(text))]


def test_a_grid_is_the_product_of_its_lists_and_the_sweeps_grid_crosses_every_study():
    text = (
        'seeds = [3, 4]\n[grid]\n"hysteresis.mechanism" = ["dahl", "none"]\n'
        + SIZE
        + 'grid."hysteresis.scale" = [0.5, 1]\ngrid."hysteresis.creep" = [0.0, 1.0]\n'
    )
    points = expand_points(sweep(text))
    told = [tuple(point.values.values()) for point in points[::2]]
    assert told == [(m, s, c) for m in ("dahl", "none") for s in (0.5, 1.0) for c in (0.0, 1.0)]
    assert [point.seed for point in points] == [3, 4] * 8
    assert [point.number for point in points] == [k for k in range(1, 9) for _ in range(2)]


def test_numbers_go_on_over_studies_without_a_gap():
    text = (
        SIZE
        + 'grid."hysteresis.scale" = [0.5, 1.0]\n[[study]]\nname = "b"\n[[study]]\nname = "c"\n'
    )
    assert [point.number for point in expand_points(sweep(text))] == [1, 2, 3, 4]


def test_a_key_may_be_quoted_or_nested_and_a_whole_number_is_the_same_value():
    quoted = values(SIZE + 'grid."hysteresis.scale" = [1, 2]')
    nested = values(SIZE + "grid.hysteresis.scale = [1.0, 2.0]")
    assert quoted == nested
    assert all(type(value["hysteresis.scale"]) is float for value in quoted)


@pytest.mark.slow
def test_draws_stay_within_their_bounds_and_fill_them_evenly():
    drawn = values(
        SIZE + "draws = 2000\n[study.random]\n"
        '"controller.pole_1_s" = {low = 4, high = 16.0, log = true}\n'
        '"hysteresis.scale" = {low = 0.5, high = 1.5}\n'
        '"hysteresis.mechanism" = {choice = ["dahl", "preisach"]}\n'
    )
    pole = np.array([value["controller.pole_1_s"] for value in drawn])
    scale = np.array([value["hysteresis.scale"] for value in drawn])
    assert (
        pole.min() >= 4 and pole.max() <= 16 and abs(np.median(pole) - 8.0) < 0.5
    )  # 8 = sqrt(4*16)
    assert scale.min() >= 0.5 and scale.max() <= 1.5 and abs(np.median(scale) - 1.0) < 0.04
    assert abs(np.corrcoef(pole, scale)[0, 1]) < 0.08
    assert 900 < sum(value["hysteresis.mechanism"] == "dahl" for value in drawn) < 1100


def test_more_draws_or_another_parameter_leave_the_first_draws_as_they_are():
    pole = '"controller.pole_1_s" = {low = 4.0, high = 16.0}\n'
    few = values(SIZE + f"draws = 5\n[study.random]\n{pole}")
    more = values(
        SIZE + f'draws = 9\n[study.random]\n"hysteresis.scale" = {{low = 1.0, high = 2.0}}\n{pole}'
    )
    assert [v["controller.pole_1_s"] for v in few] == [v["controller.pole_1_s"] for v in more[:5]]
    other = values("random_seed = 1\n" + SIZE + f"draws = 5\n[study.random]\n{pole}")
    assert few != other


def test_the_same_run_in_two_studies_has_one_key_even_if_one_spells_the_robots_own_value():
    text = (
        SIZE
        + 'grid."hysteresis.scale" = [1.0, 2.0]\n[[study]]\nname = "b"\ngrid.load_Nm = [0, 20]\n'
    )
    keys = [point.key for point in expand_points(sweep(text))]
    assert keys[0] == keys[2] and len(set(keys)) == 3


def test_set_of_the_file_holds_for_all_studies_and_a_study_may_set_it_anew():
    text = (
        '[set]\n"hysteresis.creep" = 0.5\n'
        + SIZE
        + '[[study]]\nname = "b"\nset."hysteresis.creep" = 0\n'
    )
    assert [value["hysteresis.creep"] for value in values(text)] == [0.5, 0.0]


def test_a_robot_of_ones_own_is_what_is_changed(tmp_path):
    (tmp_path / "my.toml").write_text('extends = "default"\n[hysteresis]\nscale = 1.25\n')
    (tmp_path / "s.toml").write_text(
        'robot = "my.toml"\n' + SIZE + 'grid."hysteresis.creep" = [0.0]\n'
    )
    spec = load_sweep(tmp_path / "s.toml")
    assert spec.keys.nominal["hysteresis.scale"] == 1.25
    changes = {**spec.keys.foreign, **expand_points(spec)[0].changes}
    assert load_robot(changes=changes) == load_robot(
        tmp_path / "my.toml", {"hysteresis.creep": 0.0}
    )


def test_conditions_of_the_arm_come_from_the_robots_file_or_are_set(tmp_path):
    (tmp_path / "my.toml").write_text('extends = "kind"\n[hysteresis]\nscale = 1.25\n')
    (tmp_path / "s.toml").write_text('robot = "my.toml"\n' + SIZE)
    spec = load_sweep(tmp_path / "s.toml")
    changes, settings = arguments_of(spec, expand_points(spec)[0])
    conditions = settings["run_settings"]["conditions"]
    kind = load_robot(tmp_path / "my.toml", expand_points(spec)[0].changes)
    assert conditions == "kind" and load_robot(changes=changes, conditions=conditions) == kind
    set_ = sweep('[set]\nconditions = "kind"\n' + SIZE)
    for file, wanted in ((set_, "kind"), (sweep(SIZE), "realistic")):
        assert arguments_of(file, expand_points(file)[0])[1]["run_settings"]["conditions"] == wanted


def test_the_example_is_the_sensitivity_table_of_the_three_mechanisms():
    points = expand_points(load_sweep(EXAMPLE))
    assert {point.values["hysteresis.mechanism"] for point in points} == {
        "maxwell-slip",
        "preisach",
        "dahl",
    }
    seen = {key: {p.values[key] for p in points if p.study == study} for study, key in (
        ("hysteresis", "hysteresis.scale"), ("creep", "hysteresis.creep"), ("load", "load_Nm"),
        ("initial state", "initial_state"),
    )}  # fmt: skip
    assert seen["hysteresis.scale"] == {0.5, 1.0, 1.5} and seen["hysteresis.creep"] == {0.0, 1.0}
    assert seen["load_Nm"] == {-20.0, 0.0, 20.0} and seen["initial_state"] == {"homed", "unknown"}
    poles = [p.values["controller.pole_1_s"] for p in points if p.study == "pole"]
    means = [p.values["controller.mean_pressure_bar"] for p in points if p.study == "mean pressure"]
    assert (min(poles), max(poles), min(means), max(means)) == (4.0, 16.0, 2.0, 4.0)


BAD = {
    SIZE
    + 'grid."hysteresis.scal" = [1.0]': "hysteresis.scale",  # the cure names the key that was meant
    SIZE + 'grid."muscles_of_joint_1.scale" = [1.0]': "hysteresis.scale",
    SIZE + 'grid."hysteresis.scale" = 1.0': "list",
    SIZE + 'grid."hysteresis.scale" = []': "list",
    SIZE + 'grid."hysteresis.scale" = [1.0, 1]': "two times",
    SIZE + 'grid."hysteresis.scale" = ["big"]': "number",
    SIZE + 'grid."hysteresis.scale" = [nan]': "hysteresis.scale",
    SIZE + 'grid."hysteresis.scale" = [1.0, -1.0]': "hysteresis.scale",
    SIZE + 'grid."hysteresis.mechanism" = ["rust"]': "preisach",
    SIZE + 'grid.initial_state = ["hot"]': "homed, unknown",
    SIZE + "grid.load_Nm = [inf]": "number",
    SIZE + "draws = 5": "random",
    SIZE + 'random."hysteresis.scale" = {low = 1, high = 2}': "draws",
    SIZE + 'draws = 3\nrandom."hysteresis.scale" = {low = 2, high = 1}': "low < high",
    SIZE + 'draws = 3\nrandom."hysteresis.scale" = {low = 0, high = 1, log = true}': "0 < low",
    SIZE + 'draws = 3\nrandom."hysteresis.scale" = {low = 0, hihg = 1}': "high",
    SIZE + 'draws = 3\nrandom."hysteresis.scale" = 3': "table",
    SIZE + 'draws = 3\nrandom."path.cycles_fast" = {low = 1, high = 3}': "choice",
    SIZE + 'draws = 3\nrandom."a.b" = {low = 1, high = 3}': "no parameter",
    SIZE + 'set."hysteresis.scale" = 1.0\ngrid."hysteresis.scale" = [1.0]': "two times",
    SIZE + SIZE: "two studies",
    SIZE + "gird.load_Nm = [1.0]": "grid",
    SIZE + "seeds = []": "seeds",
    SIZE + "seeds = [1, 1]": "seeds",
    SIZE + "seeds = [true]": "seeds",
    "seeds = 3\n" + SIZE: "a list [..., ...]",
    "seeds = [-1]\n" + SIZE: "seeds[0] = -1 is not a whole number from 0 on",
    "jiont = 1\n" + SIZE: "Did you mean joint?",
    'trials = ["quick"]\n' + SIZE: "slow_no_integrator",
    "compensators = []\n" + SIZE: "compensators",
    'experiment = "leg"\n' + SIZE: "joint, arm",
    "joint = 13\n" + SIZE: "1 to 12",
    'robot = "nowhere.toml"\n' + SIZE: "nowhere.toml",
    'name = "a\\u0007"\n' + SIZE: "printable",
    "study = 3": "[[study]]",
    "study = [3]": "table",
    'name = "x"': "[[study]]",
    SIZE + 'draws = 1000000\nrandom."hysteresis.scale" = {low = 1, high = 2}': "200000",
    SIZE
    + 'grid."controller.pressure_low_bar" = [6.5]': "pressure",  # contradicts another key of the robot
}


@pytest.mark.parametrize("text", BAD, ids=range(len(BAD)))
def test_a_wrong_file_is_refused_with_its_cure(text):
    with pytest.raises(ParameterError) as caught:
        expand_points(sweep(text))
    assert BAD[text] in str(caught.value)


@pytest.mark.parametrize(
    "content", [None, b"", b"\xff\xfe", b"[[study", b"a = " + b"[" * 5000, b"#" * (1 << 21)]
)
def test_a_file_that_is_no_sweep_is_refused(tmp_path, content):
    file = tmp_path / "s.toml"
    if content is not None:
        file.write_bytes(content)
    with pytest.raises(ParameterError):
        load_sweep(file)
    for path in (tmp_path, "a\0b"):
        with pytest.raises(ParameterError):
            load_sweep(path)


@pytest.mark.slow
@given(st.data())
def test_no_mutilation_of_the_example_gives_anything_but_a_sweep_or_a_named_error(data):
    lines = EXAMPLE.read_text().splitlines()
    for _ in range(data.draw(st.integers(1, 3))):
        k = data.draw(st.integers(0, len(lines) - 1))
        line = lines[k]
        i = data.draw(st.integers(0, max(len(line) - 1, 0)))
        lines[k] = data.draw(
            st.sampled_from(
                [
                    "",
                    line[:i],
                    line[i:],
                    line * 2,
                    line[:i] + "[" + line[i:],
                    line.replace("=", "= -", 1),
                ]
            )
        )
    try:
        document = tomllib.loads("\n".join(lines))
    except ValueError:
        return
    try:
        parse_sweep(document)
    except DehystError as fault:
        assert len(str(fault)) > 20
