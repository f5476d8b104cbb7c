"""Identification of joints: one code path with the command line, tested on loops that the fit has not seen."""

import contextlib
import itertools

import numpy as np
import pytest
from scipy.optimize import lsq_linear

import dehyst
from dehyst import cli
from dehyst.design import UNSEEN_TIPS
from dehyst.models import PrandtlIshlinskii
from dehyst_robot.experiments import identify_joint
from dehyst_robot.experiments._identification import _played
from dehyst_robot.experiments._policy import POLICY
from experiment_samples import PLANTS, calibrated, equipment, folder, identified, robot, trial


def rms(x):
    return float(np.sqrt(np.mean(np.square(x))))


@pytest.mark.slow
def test_the_command_line_gives_the_same_model_bit_for_bit_from_the_written_log(
    tmp_path, monkeypatch, capsys
):
    found = identified(1)
    saved = tmp_path / "m.json"
    log = folder("maxwell-slip") / "identification_joint1.csv"
    words = [
        "identify",
        str(log),
        "--input",
        "sheared_bar",
        "--output",
        "angle_rad",
        "--family",
        "pi",
        "--train-fraction",
        "1",
    ]
    monkeypatch.setattr("sys.argv", ["dehyst", *words, "--save", str(saved)])
    with contextlib.suppress(SystemExit):
        cli.main()
    model = dehyst.load(saved)
    for name in ("weights", "thresholds", "center", "offset"):
        assert np.array_equal(getattr(model, name), getattr(found.fit.model, name))
    assert model.state is None and found.fit.model.state is None
    q = found.unseen["angle_rad"]
    assert np.array_equal(model.inverse().simulate(q), found.fit.model.inverse().simulate(q))


@pytest.mark.slow
def test_the_printed_model_has_no_offset_and_no_centre_and_solves_the_printed_problem():
    identified(1)
    log = folder("maxwell-slip") / "identification_joint1.csv"
    model = _played(robot(), log, odd=True).model
    assert abs(model.offset) < 1e-15 and abs(model.center) < 1e-15  # rounding
    assert model.state is None  # equation (13): all zero
    read = dehyst.read_log(log, input="sheared_bar", output="angle_rad")
    # (12): 100 evenly spaced thresholds below the largest size of the input
    grid = np.arange(100) / 100 * np.abs(read.input).max()
    plays = [PrandtlIshlinskii([r], [1.0]).simulate(read.input) for r in grid]
    solved = lsq_linear(np.column_stack(plays), read.output, ([0.001] + 99 * [0.0], np.inf))
    places = np.round(model.thresholds / grid[1]).astype(int)
    np.testing.assert_allclose(model.thresholds, grid[places], rtol=1e-12)
    rest = read.output - model.simulate(read.input)
    assert np.sum(rest**2) <= 2 * solved.cost * (1 + 1e-9)
    assert model.weights[0] >= 0.001 and (model.weights >= 0).all()


@pytest.mark.slow
def test_the_log_on_disk_is_the_log_of_the_run():
    found = identified(1)
    read = dehyst.read_log(
        folder("maxwell-slip") / "identification_joint1.csv",
        input="sheared_bar",
        output="angle_rad",
    )
    assert np.array_equal(read.input, found.log["sheared_bar"]) and np.array_equal(
        read.output, found.log["angle_rad"]
    )
    log = found.log
    dp = log["pressure_1_bar"] - log["pressure_2_bar"]
    assert np.array_equal(dp, log["pressure_difference_bar"])
    x = dp - log["nominal_difference_bar"] + found.shear * log["angle_rad"]
    np.testing.assert_allclose(x, log["sheared_bar"], rtol=0, atol=1e-12)


@pytest.mark.slow
def test_the_nominal_difference_is_the_calibrated_characteristic_at_the_pressures_of_the_moment():
    found, c = identified(1), calibrated(1)
    log = found.log
    q, mean = log["angle_rad"], 1e5 * (log["pressure_1_bar"] + log["pressure_2_bar"]) / 2
    value = np.polynomial.polynomial.polyval
    nominal = (
        -(value(q, c.a) * mean + value(q, c.c)) / value(q, c.b) / 1e5
    )  # joint 1 carries no weight
    inside = (q > c.low) & (q < c.high)
    np.testing.assert_allclose(
        log["nominal_difference_bar"][inside], nominal[inside], rtol=0, atol=1e-9
    )


@pytest.mark.slow
@pytest.mark.parametrize("mechanism", PLANTS)
def test_the_inverse_explains_unseen_loops_to_a_fifth_of_their_hysteresis(mechanism):
    found = identified(1, mechanism)
    table = np.genfromtxt(folder(mechanism) / "unseen_joint1.csv", delimiter=",", names=True)
    q = table["angle_rad"]
    hysteresis = table["pressure_difference_bar"] - table["nominal_difference_bar"]
    inverse = found.fit.model.inverse().simulate(q) - found.shear * q
    assert rms(hysteresis - inverse) <= 0.20 * rms(hysteresis)
    assert found.inverse_rms_ratio == pytest.approx(
        rms(hysteresis - inverse) / rms(hysteresis), rel=1e-9
    )
    assert found.accepted and 3 <= found.nonzero_weights < 100
    assert 0.04 < rms(hysteresis) < 0.5  # [bar]: +-4 to 8 Nm at 35 Nm/bar, and not nothing


def turns(x, least=0.02):
    """Angles where a motion turns, after more than `least`."""
    found, last, way = [], x[0], 0
    for value in x:
        if way * (value - last) >= 0 and abs(value - last) > (least if way == 0 else 0):
            way, last = np.sign(value - last), value
        elif way * (last - value) > least:
            found.append(last)
            way, last = -way, value
    return np.array(found)


@pytest.mark.slow
def test_unseen_loops_are_not_those_of_the_fit():
    tips = np.array(robot().identification.tips)
    fitted = np.unique(np.concatenate([tips, robot().identification.second_share * tips, [0.0]]))
    assert not np.isclose(np.array(UNSEEN_TIPS)[:, None], fitted, atol=0.004).any()
    found = identified(1)
    seen, unseen = turns(found.log["angle_rad"]), turns(found.unseen["angle_rad"])
    assert seen.size >= 2 * tips.size - 1 and unseen.size >= len(UNSEEN_TIPS)
    pairs = {(round(a, 2), round(b, 2)) for a, b in itertools.pairwise(seen)}
    again = [(round(a, 2), round(b, 2)) in pairs for a, b in itertools.pairwise(unseen)]
    assert not any(again)  # no stroke of the test was in the fit


@pytest.mark.slow
def test_the_same_seed_gives_the_same_log_and_the_same_model_bit_for_bit(tmp_path):
    again = identify_joint(robot(), 1, calibrated(1), tmp_path)
    assert np.array_equal(again.fit.model.weights, identified(1).fit.model.weights)
    for name in ("identification_joint1.csv", "unseen_joint1.csv"):
        assert (tmp_path / name).read_bytes() == (folder("maxwell-slip") / name).read_bytes()


@pytest.mark.slow
def test_a_joint_without_hysteresis_gets_no_compensator():
    found = identified(1, "none")
    assert not found.accepted and found.unexplained > POLICY.acceptable
    ready = equipment("none")
    assert not ready.compensators and ready.controllers[1].shear == 0.0


@pytest.mark.slow
@pytest.mark.parametrize("name", ["fast", "slow_no_integrator"])
def test_runs_with_paper_and_off_are_then_the_same_bit_for_bit(name):
    off, on = trial(name, "off", "none"), trial(name, "paper", "none")
    assert np.array_equal(off.angle, on.angle) and np.array_equal(off.pressure, on.pressure)
    assert not on.compensation.any()


@pytest.mark.slow
def test_the_accepted_model_is_put_into_the_controller_with_its_shear():
    ready = equipment()
    assert ready.controllers[1].shear == identified(1).shear * 1e5 == 1e5
    assert ready.controllers[1].compensator_unit == 1e5
    q = identified(1).unseen["angle_rad"]
    full, pruned = (
        identified(1).fit.model.inverse().simulate(q),
        identified(1).compensator.simulate(q),
    )
    np.testing.assert_allclose(full, pruned, rtol=0, atol=1e-12)


@pytest.mark.slow
def test_the_scaled_compensator_has_another_k_and_no_step_at_reversals(tmp_path):
    found = identify_joint(robot(), 1, calibrated(1), tmp_path, compensator="scaled")
    assert found.shear == 10.0 > robot().compensator.shear / 1e5
    assert (
        found.fit.model.inverse_gain < identified(1).fit.model.inverse_gain / 10
    )  # no step at reversals
    sheared = found.log["hysteresis_bar"] + found.shear * found.log["angle_rad"]
    np.testing.assert_allclose(sheared, found.log["sheared_bar"], rtol=0, atol=1e-12)
