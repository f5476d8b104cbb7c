"""Models and controllers side by side: what is learned on a joint, what a gain does, what the committed run says."""

import json
import sys
from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from dehyst.errors import ParameterError
from dehyst.families import names
from dehyst_robot.control._reviewed import CONTROLLERS, TUNED, VoMinhController
from places import ROOT

sys.path.insert(0, str(ROOT / "benchmarks"))

from studies.law_study import OWN, Rung, best, ladder, period_cost, with_factor
from studies.side_by_side import (
    AS_IT_IS,
    INVERTED,
    bouc_wen_muscle,
    errors,
    learned,
    model_names,
    path_cost,
    prepared,
    with_model,
)

SHORT = {
    "calibration": {"mean_pressures_bar": [2.2, 3.8], "loads_bar": [-0.8, 0.8], "sweep_s": 12.0},
    "identification.loop_s": 6.0,
    "homing.cycles": 5,
    "path.cycles_fast": 1,
    "simulation.period_s": 0.001,
}
RESULT = ROOT / "benchmarks" / "results" / "reviewed.json"


@pytest.fixture(scope="module")
def joint():
    return prepared("dahl", 3, compensators=("paper",), changes=SHORT)


def test_every_family_of_the_registry_is_tried():
    assert set(names()) < set(model_names())
    assert {"pi", "modified-pi"} < set(model_names())


@pytest.mark.slow
@pytest.mark.parametrize("name", ["pi", "stop", "dahl"])
def test_a_family_becomes_a_compensator_that_halves_the_error_at_least(joint, name):
    model = learned(joint.found["paper"], name)
    assert model.unexplained < 0.5 and model.parameters > 0
    off, on = (
        errors(joint, with_model(joint, model), "fast", switched) for switched in (False, True)
    )
    assert on["rms_deg"] < 0.5 * off["rms_deg"]
    assert path_cost(model, 50, 1) > 0


@pytest.mark.slow
def test_the_way_that_says_more_of_the_log_is_taken(joint):
    found = joint.found["paper"]
    both, one, other = (learned(found, "dahl", way=way) for way in ("", INVERTED, AS_IT_IS))
    assert both.way == AS_IT_IS  # friction leads: nothing has to be inverted
    assert other.unexplained < one.unexplained
    assert both.unexplained == other.unexplained


@pytest.mark.slow
def test_a_family_that_cannot_be_fitted_says_why(joint):
    log = {name: np.zeros_like(column) for name, column in joint.found["paper"].log.items()}
    nothing = learned(replace(joint.found["paper"], log=log), "pi")
    assert (
        nothing.compensator is None
        and "inverted:" in nothing.reason
        and "as it is:" in nothing.reason
    )


def test_a_plant_that_is_none_is_refused():
    with pytest.raises(ParameterError, match="no plant 'rubber'"):
        prepared("rubber")


def test_the_fourth_plant_slips_at_80_n_and_is_none_of_the_others():
    mechanism = bouc_wen_muscle(1, 0)
    mechanism.reset(0.1)
    force = [mechanism.force(k, 3e5, 5e-4) for k in np.linspace(0.1, 0.2, 400).tolist()]
    assert force[-1] == pytest.approx(80.0, rel=1e-3)
    assert max(force) <= 80.0 + 1e-9


def test_a_factor_multiplies_the_gain_of_every_controller(joint):
    kit = joint.equipped()
    pole = kit.controllers[1].pole
    _, paper = with_factor(joint.robot, kit, "paper", 2.0)
    assert paper.controllers[1].pole == 2 * pole and not paper.laws
    _, mode = with_factor(joint.robot, kit, "sliding-mode", 2.0)
    assert mode.laws[1].surface == mode.laws[1].observer_pole == 2 * pole
    first, second = (
        with_factor(joint.robot, kit, "vo-minh", factor)[1].laws[1] for factor in (1.0, 3.0)
    )
    assert isinstance(first, VoMinhController)
    assert second == VoMinhController(3 * first.proportional, 3 * first.integral)
    for wrong in (0.0, -1.0, float("nan")):
        with pytest.raises(ParameterError, match="must be a positive number"):
            with_factor(joint.robot, kit, "paper", wrong)


def test_a_ladder_goes_through_its_factors_and_a_failure_is_never_the_best(monkeypatch, joint):
    import studies.law_study as study

    from dehyst.errors import SimulationError

    def failing(one, equipment, trial, on, robot):
        if equipment.controllers[1].pole > 10.0:
            raise SimulationError("failed safe")
        return {"rms_deg": 1.0 / equipment.controllers[1].pole, "max_deg": 1.0}

    monkeypatch.setattr(study, "errors", failing)
    rungs = ladder(joint, "paper", "paper", (0.5, 1.0, 2.0))
    assert [rung.factor for rung in rungs] == [0.5, 1.0, 2.0]
    assert rungs[2] == Rung(2.0, float("inf"), float("inf")) and best(rungs) == 1.0


def test_a_period_costs_time_and_more_of_it_with_a_compensator(joint):
    costs = [
        min(period_cost(joint, "paper", name, 2000, 5) for _ in range(3)) for name in ("", "paper")
    ]
    assert 0 < costs[0] < 2 * costs[1] < 1e6


# ---- The committed run, of which docs/explanation/reviewed-controllers.md speaks.


@pytest.fixture(scope="module")
def result():
    if not RESULT.exists():
        pytest.skip("python benchmarks/reviewed.py was not run")
    return json.loads(RESULT.read_text(encoding="utf-8"))


def slow(result, plant, controller, compensator, factor=1.0):
    """Mean rms error of the slow trial over the seeds."""
    wanted = {
        "plant": plant,
        "controller": controller,
        "compensator": compensator,
        "trial": "slow",
        "factor": factor,
    }
    found = [row for row in result["controllers"] if all(row[k] == v for k, v in wanted.items())]
    assert found
    return float(np.mean([row["rms_deg"] for row in found]))


REVIEWED = [name for name in CONTROLLERS if name != "paper"]
PLANTS = ("maxwell-slip", "preisach", "dahl")


@pytest.mark.parametrize(("plant", "name"), list(product(PLANTS, REVIEWED)))
def test_the_papers_controller_with_its_compensator_beats_each_reviewed_one_as_published(
    result, plant, name
):
    told = result["tuning"]["chosen"]
    assert slow(result, plant, "paper", "paper") < slow(result, plant, name, OWN[name] or "off")
    tuned = slow(result, plant, "paper", "paper", told["paper"])
    assert tuned < slow(result, plant, name, OWN[name] or "off", told[name])


@pytest.mark.parametrize(("plant", "name"), list(product(PLANTS, CONTROLLERS)))
def test_the_compensator_helps_every_controller(result, plant, name):
    assert slow(result, plant, name, "paper") < slow(result, plant, name, "off")


@pytest.mark.parametrize("plant", PLANTS)
def test_sliding_mode_is_the_best_without_a_compensator(result, plant):
    errors = {name: slow(result, plant, name, "off") for name in CONTROLLERS}
    assert min(errors, key=lambda name: errors[name]) == "sliding-mode"


def test_the_run_is_of_the_controllers_and_families_that_there_are(result):
    assert result["tuning"]["numbers"] == dict(TUNED)
    assert set(result["tuning"]["ladders"]) == set(CONTROLLERS)
    assert {row["model"] for row in result["models"]} <= set(model_names())
