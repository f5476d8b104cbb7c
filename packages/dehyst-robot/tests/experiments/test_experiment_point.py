"""One point of a sweep on the real evaluator: its keys, what it keeps in mind, and a tiny sweep end to end."""

import csv
import warnings
from functools import cache

import pytest

from dehyst.errors import ParameterError
from dehyst_robot.arm import load_robot
from dehyst_robot.experiments import calibrate, evaluate_point, identify_joint, run_sweep
from dehyst_robot.experiments._sweep.spec import load_sweep

SHORT = {
    "calibration.mean_pressures_bar": [2.2, 3.8], "calibration.loads_bar": [-0.8, 0.8], "calibration.sweep_s": 8.0,
    "calibration.degree": 3, "identification.loop_s": 8.0, "identification.tips": [1.0, -1.0, 0.75, -0.5, 0.3],
    "compensator.operators": 30, "homing.cycles": 3, "homing.period_s": 2.0,
    "path.cycles_fast": 1, "path.slow_factor": 1.2, "path.cube_m": 0.2,
}  # fmt: skip

KIND, KIND_LINE = {"conditions": "kind"}, 'conditions = "kind"'


@cache
def point(*changes, **settings):
    """Figures of joint 1 of the kind arm with the short settings; changes as pairs."""
    told = {**KIND, **dict(settings.pop("run_settings", ()))}
    return evaluate_point({**SHORT, **dict(changes)}, run_settings=told, **settings)


@pytest.mark.slow
def test_a_point_returns_these_figures():
    found = point()
    run = {f"slow/{name}/{key}" for name in ("off", "paper") for key in ("rms_deg", "max_deg")}
    assert set(found) == run | {
        "slow/paper/ratio_rms",
        "slow/paper/ratio_max",
        "paper/declined",
        "nonzero_weights",
        "inverse_rms_ratio_unseen",
    }
    assert all(isinstance(value, float) for value in found.values())
    for key in ("rms", "max"):
        ratio = found[f"slow/paper/{key}_deg"] / found[f"slow/off/{key}_deg"]
        assert found[f"slow/paper/ratio_{key}"] == pytest.approx(ratio, rel=1e-12)
    assert found["slow/paper/ratio_rms"] < 0.4
    assert found["paper/declined"] == 0.0


@pytest.mark.slow
def test_a_compensator_that_is_declined_is_said_so_and_changes_nothing():
    found = point(("hysteresis.mechanism", "none"))
    assert found["paper/declined"] == 1.0
    assert found["slow/paper/ratio_rms"] == found["slow/paper/ratio_max"] == 1.0


@pytest.mark.slow
def test_without_off_there_are_no_ratios():
    found = point(compensators=("paper",))
    assert not any(
        "ratio_rms/" in key or key.endswith(("/ratio_rms", "/ratio_max")) for key in found
    )
    assert found["slow/paper/rms_deg"] == point()["slow/paper/rms_deg"]


@pytest.mark.slow
@pytest.mark.parametrize(
    "change",
    [
        ("hysteresis.mechanism", "dahl"), ("hysteresis.scale", 1.5), ("joint.1.radius_m", 0.052),
        ("controller.mean_pressure_bar", 3.2),
    ],
    ids=str,
)  # fmt: skip
def test_nothing_is_taken_from_another_plant(change):
    first, other = point(), point(change)
    assert other["slow/off/rms_deg"] != first["slow/off/rms_deg"]
    assert other["inverse_rms_ratio_unseen"] != first["inverse_rms_ratio_unseen"]  # identified anew


@pytest.mark.slow
def test_what_is_kept_changes_no_figure():
    point(("controller.pole_1_s", 12.0))
    assert (
        evaluate_point(SHORT, run_settings=KIND) == point()
    )  # bit for bit, from the memory of the process


@pytest.mark.slow
def test_another_pole_is_another_run_of_the_same_identification():
    other = point(("controller.pole_1_s", 12.0))
    assert other["inverse_rms_ratio_unseen"] == point()["inverse_rms_ratio_unseen"]
    assert other["slow/off/rms_deg"] < 0.5 * point()["slow/off/rms_deg"]


@pytest.mark.slow
def test_a_compensator_is_taken_for_stale_where_hysteresis_is_gone_and_not_where_it_was_identified():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        point(("controller.pole_1_s", 11.0))
    with pytest.warns(UserWarning, match="the compensator's model does not fit"):
        point(("hysteresis.scale", 0.0), run_settings=(("identified_on", "default"),))


@pytest.mark.slow
def test_another_seed_is_another_plant_calibrated_and_identified_as_such(tmp_path):
    robot = load_robot(conditions="kind", changes=SHORT)
    found = identify_joint(robot, 1, calibrate(robot, 1, seed=1), tmp_path, seed=1)
    assert point(seed=1)["inverse_rms_ratio_unseen"] == found.inverse_rms_ratio
    assert point(seed=1)["slow/off/rms_deg"] != point()["slow/off/rms_deg"]
    assert point(seed=1)["inverse_rms_ratio_unseen"] != point()["inverse_rms_ratio_unseen"]


@pytest.mark.slow
def test_identified_on_the_default_robot_is_not_identified_here():
    change = ("hysteresis.scale", 2.0)
    here, default = point(change), point(change, run_settings=(("identified_on", "default"),))
    assert default["inverse_rms_ratio_unseen"] == point()["inverse_rms_ratio_unseen"]
    assert here["inverse_rms_ratio_unseen"] != default["inverse_rms_ratio_unseen"]
    # Half of the hysteresis is known: about half of it stays.
    assert here["slow/paper/ratio_rms"] < 0.3 < default["slow/paper/ratio_rms"] < 0.7


@pytest.mark.slow
def test_controllers_of_the_default_robot_are_told_of_no_supply_valve_or_payload(monkeypatch):
    class Heard(Exception):
        pass

    def hear(*words, **_):
        raise Heard(*words[:3])

    monkeypatch.setattr("dehyst_robot.experiments._point.learned_trial", hear)
    changes = {**SHORT, "air.supply_bar": 6.3, "valve.mpye.dead_band": 0.09, "payload.mass_kg": 2.0}
    with pytest.raises(Heard) as here:
        evaluate_point(changes)
    with pytest.raises(Heard) as default:
        evaluate_point(changes, run_settings={"identified_on": "default"})
    with pytest.raises(Heard) as unchanged:
        evaluate_point(SHORT)
    assert here.value.args[0] == default.value.args[0] != unchanged.value.args[0]
    assert (
        here.value.args[2].known is None and default.value.args[2].known == unchanged.value.args[0]
    )
    told, kind, knows = (
        found.value.args[2].controllers[1].pneumatics for found in (default, unchanged, here)
    )
    assert told == kind != knows


@pytest.mark.slow
def test_whole_tables_are_another_robot_also_where_the_default_is_identified():
    table = load_robot(conditions="kind", changes={"hysteresis.scale": 2.0}).values["hysteresis"]
    robot = {**SHORT, "hysteresis": table}
    figures = [
        evaluate_point(robot, run_settings={**KIND, "identified_on": on})
        for on in ("here", "default")
    ]
    assert figures[0] == figures[1] == point(("hysteresis.scale", 2.0))


@pytest.mark.slow
def test_load_and_unknown_state_reach_the_run():
    loaded = point(run_settings=(("load_Nm", 20.0),))
    unknown = point(run_settings=(("initial_state", "unknown"),))
    assert len({x["slow/off/rms_deg"] for x in (point(), loaded, unknown)}) == 3
    assert all(x["slow/paper/ratio_rms"] < 0.4 for x in (loaded, unknown))
    ramped = point(run_settings=(("initial_state", "ramped"),))
    assert ramped["slow/off/rms_deg"] == unknown["slow/off/rms_deg"]
    assert ramped["slow/paper/ratio_max"] < unknown["slow/paper/ratio_max"]


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"run_settings": {"load": 3.0}}, "load_Nm, initial_state, identified_on"),
        ({"run_settings": {"identified_on": "there"}}, "here, default"),
        ({"run_settings": {"initial_state": "hot"}}, "homed, unknown, ramped"),
        ({"run_settings": {"load_Nm": "much"}}, "load_Nm = 'much'"),
        ({"run_settings": {"load_Nm": float("nan")}}, "from -1000 to 1000 Nm"),
        ({"run_settings": {"passes": 2.5}}, "a whole number from -1"),
        ({"experiment": "leg"}, "joint, arm"),
        ({"joint": 3}, "electric"),
        ({"joint": 9}, "no joint 9"),
        ({"seed": -1}, "seed = -1"),
        ({"trials": ("quick",)}, "fast, slow, slow_no_integrator"),
        ({"compensators": ("off", "worst")}, "paper, literal, printed"),
    ],
    ids=str,
)
def test_what_does_not_exist_is_refused(settings, words):
    with pytest.raises(ParameterError, match=words):
        evaluate_point(SHORT, **settings)


def test_an_unknown_key_is_refused_with_the_one_that_was_meant():
    with pytest.raises(ParameterError, match=r"hysteresis\.scale"):
        evaluate_point({"hysteresis.scal": 2.0})


@pytest.mark.slow
def test_a_sweep_of_two_points_runs_the_real_experiment_end_to_end(tmp_path):
    lines = [f'"{key}" = {value}' for key, value in SHORT.items()]
    text = [
        'name = "tiny"',
        "seeds = [0]",
        "[set]",
        KIND_LINE,
        *lines,
        "[[study]]",
        'name = "load"',
        "grid.load_Nm = [0.0, 20.0]",
    ]
    file = tmp_path / "tiny.toml"
    file.write_text("\n".join(text))
    result = run_sweep(load_sweep(file), tmp_path / "tiny.csv", workers=0)
    assert not result.failed
    with (tmp_path / "tiny.csv").open() as stream:
        rows = list(csv.DictReader(line for line in stream if not line.startswith("#")))
    assert [float(row["load_Nm"]) for row in rows] == [0.0, 20.0]
    wanted = [point(), point(run_settings=(("load_Nm", 20.0),))]
    for row, figures in zip(rows, wanted, strict=True):
        assert {key: float(row[key]) for key in figures} == figures
