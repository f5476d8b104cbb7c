"""What benchmarks/contacts.py measured holds what docs/explanation/adaptation.md says of contact."""

import csv
import sys

import mujoco
import numpy as np
import pytest

from dehyst_robot.arm import load_robot
from dehyst_robot.experiments import equip, nominal_characteristic
from places import ROOT

sys.path.insert(0, str(ROOT / "benchmarks"))

from studies.contacts import CONTACTS, touched_arm

RESULT = ROOT / "docs" / "generate" / "contacts.csv"


def rows(compensator):
    with RESULT.open(encoding="utf-8", newline="") as file:
        return [row for row in csv.DictReader(file) if row["compensator"] == compensator]


# adaptation.md says so: a hand that takes a minute to come is learned up to the limit, where the limit is widest.
SLOWEST = ("dahl", "a hand that brakes, 4 Nm after 60 s")
WALL = "a wall at 6 degrees, 200 Nm/rad, of MuJoCo"


def beside_the_slowest(every):
    return [row for row in every if (row["plant"], row["contact"]) != SLOWEST]


def test_after_a_contact_best_errs_as_before_within_5_s():
    touched = [row for row in rows("best") if row["contact"] != "none"]
    # Four foreign mechanisms with four contacts each, and the wall of MuJoCo.
    assert len(touched) == 3 * 8 + 4 * 4 + 1
    for row in beside_the_slowest(touched):
        assert float(row["settled_mdeg"]) <= 1.5 * float(row["before_mdeg"]), row


def test_no_contact_is_learned_or_taken_for_missing_hysteresis():
    free = {row["plant"]: row for row in rows("best") if row["contact"] == "none"}
    for row in beside_the_slowest(rows("best")):
        assert not row["stale_s"] and not row["shifted_s"], row
        assert float(row["lowest_scale"]) > float(free[row["plant"]]["lowest_scale"]) - 0.1, row
        assert float(row["highest_scale"]) < float(free[row["plant"]]["highest_scale"]) + 0.1, row


def test_what_comes_at_once_is_noticed_within_half_a_second_and_nothing_is_noticed_without():
    for row in rows("best"):
        if row["contact"] == "none":
            assert row["touched_s"] == ""
        elif ("a hand" in row["contact"] and "after" not in row["contact"]) or "load" in row[
            "contact"
        ]:
            assert float(row["touched_s"]) < 0.5, row


@pytest.fixture
def arm_at_wall():
    robot = load_robot()
    equipment = equip(robot, {1: nominal_characteristic(robot, 1)}, {})
    return touched_arm(robot, equipment, 1, CONTACTS[WALL])


def pushed_at_rest(arm, degrees, there):
    """Torque of the contact of a joint that something holds at an angle, and what MuJoCo says of each contact."""
    arm.there(there)
    data = mujoco.MjData(arm.model)
    data.qpos[0] = np.radians(degrees)
    for _ in range(
        2000
    ):  # a soft contact takes part of what holds the joint; the rest is what is sought
        data.qfrc_applied[0] = data.qfrc_bias[0] - data.qfrc_passive[0] - data.qfrc_constraint[0]
        mujoco.mj_forward(arm.model, data)
    return float(data.qfrc_constraint[0]), data


def test_the_walls_force_is_that_of_mujocos_contact_and_200_newton_metres_a_radian_at_rest(
    arm_at_wall,
):
    torque, data = pushed_at_rest(arm_at_wall, 8.0, there=True)
    by_contacts, force = 0.0, np.empty(6)
    for k, contact in enumerate(data.contact):
        mujoco.mj_contactForce(arm_at_wall.model, data, k, force)
        push = -contact.frame[:3] * force[0]
        sign = 1.0 if push[1] < 0 else -1.0
        by_contacts += sign * float(contact.pos[0] * push[1] - contact.pos[1] * push[0])
    assert data.ncon == 2
    assert torque == pytest.approx(by_contacts, rel=1e-6)
    assert torque == pytest.approx(-200.0 * np.radians(2.0), rel=5e-3)


def test_the_wall_pushes_only_beyond_its_angle_and_while_it_is_there(arm_at_wall):
    assert pushed_at_rest(arm_at_wall, 5.9, there=True)[0] == 0.0
    assert pushed_at_rest(arm_at_wall, 8.0, there=False)[0] == 0.0
    assert pushed_at_rest(arm_at_wall, 6.1, there=True)[0] < 0.0
