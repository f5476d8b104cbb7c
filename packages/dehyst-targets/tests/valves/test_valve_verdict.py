"""What is told of simulated loops: sticking valves, valves that follow, records that cannot tell, bad input."""

import numpy as np
import pytest

from dehyst.errors import ColumnError, ParameterError, RecordingError
from dehyst.findings import Grade
from dehyst.io import write_csv
from dehyst_targets.valves import (
    ControlLoop,
    explained_share,
    judge_valve,
    read_control_loop,
    step_test,
)
from simulated_loops import simulator, valve_loop


def record(columns, *, position=False):
    """A record of a simulated loop."""
    place = None
    if position:
        place = columns["MV"] + 0.1 * np.random.default_rng(0).normal(size=columns["MV"].size)
    return ControlLoop.of(
        columns["OP"], columns["PV"], columns["SP"], place, time=columns["time_s"]
    )


@pytest.mark.slow
@pytest.mark.parametrize("valve", ["choudhury", "kano", "he", "friction"])
def test_a_flow_loop_that_sticks_is_told_with_a_dead_band_within_a_tenth(valve):
    verdict = judge_valve(record(valve_loop("flow", valve, seed=1)))
    assert verdict.kind == "sticks"
    assert verdict.mode == "automatic"
    assert verdict.dead_band.value == pytest.approx(4.0, rel=0.12)
    assert verdict.words.startswith(("stiction: S =", "dead band"))


@pytest.mark.slow
def test_with_the_position_dead_band_and_jump_are_told_within_a_twentieth():
    verdict = judge_valve(record(valve_loop("pressure", "he", seed=1), position=True))
    assert verdict.dead_band.value == pytest.approx(4.0, rel=0.05)
    assert verdict.jump.value == pytest.approx(2.0, rel=0.05)
    assert verdict.dead_band.low < 4.0 < verdict.dead_band.high


@pytest.mark.slow
@pytest.mark.parametrize("share", [0.0, 1 / 6, 0.4, 0.5, 0.67])
def test_a_jump_of_any_share_of_the_dead_band_is_in_its_interval_where_the_position_is_logged(
    share,
):
    """The log of the position has no noise: the true valve reproduces it, and lies on no grid."""
    dead_band = 5.0
    output, position = loop_of_he(dead_band, share * dead_band)
    verdict = judge_valve(ControlLoop.of(output, position=position))
    assert verdict.dead_band.value == pytest.approx(dead_band, abs=0.05)
    assert verdict.dead_band.low <= dead_band <= verdict.dead_band.high
    assert verdict.jump.low <= share * dead_band <= verdict.jump.high
    assert verdict.dead_band.high - verdict.dead_band.low < 0.5
    assert verdict.grade == Grade.GOOD


@pytest.mark.slow
def test_a_position_whose_noise_hides_the_jumps_is_graded_with_care():
    output, position = loop_of_he(5.0, 0.85)
    noisy = position + 0.3 * np.random.default_rng(1).normal(size=position.size)
    verdict = judge_valve(ControlLoop.of(output, position=noisy))
    assert verdict.kind == "sticks" and verdict.grade == Grade.CARE
    assert "does not show the moves" in verdict.reason


@pytest.mark.slow
def test_a_jump_whose_interval_leaves_out_none_is_called_stiction():
    """Of S = 6 % a jump of 1 % is small, and none is excluded."""
    output, position = loop_of_he(6.0, 1.0)
    words = judge_valve(ControlLoop.of(output, position=position)).words
    assert words.startswith("stiction: S = ")


def loop_of_he(dead_band, jump, samples=2400):
    """A PI loop of a lag of 8 s and a valve by He's rule, with noise and random load: (output, position)."""
    rng = np.random.default_rng(1)
    static, kinetic = 0.5 * (dead_band + jump), 0.5 * (dead_band - jump)
    output, position = np.empty(samples), np.empty(samples)
    valve = process = integral = 50.0
    delayed, load = [50.0] * 3, 0.0
    for k in range(samples):
        load = 0.98 * load + 0.05 * rng.normal()
        error = 50.0 - process - 0.05 * rng.normal()
        integral += 0.2 * error
        output[k] = integral + 0.8 * error
        if abs(output[k] - valve) > static:
            valve = output[k] - np.sign(output[k] - valve) * kinetic
        position[k] = valve
        delayed.append(valve)
        process += 0.125 * (delayed.pop(0) + load - process)
    return output, position


@pytest.mark.slow
def test_a_valve_that_follows_shows_no_sign_of_stiction():
    verdict = judge_valve(record(valve_loop("flow", "linear", seed=2)))
    assert verdict.kind == "no sign"
    assert verdict.excluded_above < 0.5


@pytest.mark.slow
@pytest.mark.parametrize("shape", ["sine", "triangle", "square", "irregular"])
def test_an_external_disturbance_is_never_called_stiction(shape):
    verdict = judge_valve(record(valve_loop("flow", "linear", seed=2, wave=(shape, 3.0, 40.0))))
    assert verdict.kind == "not identifiable"


@pytest.mark.slow
@pytest.mark.parametrize(("valve", "kind"), [("kano", "sticks"), ("linear", "no sign")])
def test_the_test_in_manual_tells_what_the_record_in_automatic_did_not(valve, kind):
    disturbed = judge_valve(record(valve_loop("flow", "linear", seed=2, wave=("sine", 3.0, 40.0))))
    _, output = step_test(disturbed)
    columns = valve_loop("flow", valve, samples=output.size, manual=output)
    verdict = judge_valve(record(columns))
    assert verdict.mode == "manual"
    assert verdict.kind == kind


def test_four_swings_are_needed():
    columns = {name: values[:150] for name, values in valve_loop("flow", "kano").items()}
    verdict = judge_valve(record(columns))
    assert verdict.kind == "not identifiable"
    assert "are needed" in verdict.reason


def test_ten_samples_are_refused():
    columns = {name: values[:10] for name, values in valve_loop().items()}
    with pytest.raises(RecordingError, match="10 samples"):
        record(columns)


@pytest.mark.parametrize("role", ["OP", "PV"])
def test_a_signal_that_stands_still_is_refused(role):
    columns = valve_loop()
    columns[role] = np.full(columns[role].size, 40.0)
    with pytest.raises(RecordingError, match="stands still at 40"):
        record(columns)


def test_no_number_is_refused():
    columns = valve_loop()
    columns["PV"][5] = np.nan
    with pytest.raises(RecordingError, match="no number"):
        record(columns)


def test_an_output_beyond_its_span_is_refused_with_what_to_type():
    columns = valve_loop()
    columns["OP"] = 40.95 * columns["OP"]
    with pytest.raises(ParameterError, match="--span"):
        record(columns)


@pytest.mark.parametrize(("first", "second"), [("SP", "PV"), ("OP", "PV"), ("SP", "OP")])
def test_exchanged_columns_are_refused(first, second):
    columns = valve_loop(steps=3.0)
    columns[first], columns[second] = columns[second], columns[first]
    with pytest.raises(ColumnError, match=r"look exchanged.*Exchange --"):
        judge_valve(record(columns))


def test_a_constant_set_point_is_no_reason_to_refuse():
    columns = valve_loop()
    assert np.ptp(columns["SP"]) == 0.0
    assert explained_share(columns["OP"], columns["PV"], columns["SP"]) > 0.999


def test_an_output_that_was_planned_follows_no_controller():
    columns = valve_loop(manual=np.repeat(50.0 + np.arange(24) % 5, 100))
    assert explained_share(columns["OP"], columns["PV"], columns["SP"]) < 0.3


def test_of_a_record_with_gaps_the_longest_part_counts():
    columns = valve_loop()
    columns["time_s"] = columns["time_s"] + 500.0 * (np.arange(columns["time_s"].size) >= 1500)
    loop = record(columns)
    assert loop.output.size == 1500
    assert [finding.code for finding in loop.findings] == ["valve-gap"]


def test_uneven_times_become_even():
    columns = valve_loop()
    chosen = np.cumsum(np.resize([1, 2, 4], 900))
    loop = record({name: values[chosen] for name, values in columns.items()})
    assert "valve-uneven" in {finding.code for finding in loop.findings}
    assert loop.period == 2.0
    assert loop.output.size == pytest.approx(1050, rel=0.01)


@pytest.mark.slow
def test_an_output_at_its_end_is_said():
    columns = valve_loop(samples=700)
    columns["OP"] = np.clip(60.0 * (columns["OP"] - 50.0) + 50.0, 0.0, 100.0)
    verdict = judge_valve(ControlLoop.of(columns["OP"], columns["PV"]))
    assert "valve-saturated" in {finding.code for finding in verdict.findings}


@pytest.mark.parametrize(
    ("head", "factor", "codes"),
    [("OP", 0.01, {"valve-span"}), ("OP_mA", 0.16, set()), ("OP", 1.0, set())],
)
def test_an_output_from_0_to_1_and_one_in_milliampere_are_read_as_percent(
    tmp_path, head, factor, codes
):
    columns = valve_loop()
    values = factor * columns.pop("OP") + 4.0 * (head == "OP_mA")
    path = write_csv(tmp_path / "loop.csv", columns | {head: values})
    loop = read_control_loop(path)
    assert loop.output.mean() == pytest.approx(50.0, abs=2.0)
    assert {finding.code for finding in loop.findings} == codes


def test_columns_without_a_name_for_their_role_are_refused_with_a_line_to_type(tmp_path):
    columns = valve_loop()
    path = write_csv(
        tmp_path / "loop.csv", {"time_s": columns["time_s"], "a": columns["OP"], "b": columns["PV"]}
    )
    with pytest.raises(ColumnError, match=r"dehyst valve .* --output OP --measurement PV"):
        read_control_loop(path)


@pytest.mark.slow
def test_the_test_in_manual_stays_within_the_span():
    columns = valve_loop(samples=700)
    columns["OP"] = columns["OP"] + 47.0
    columns["OP"] = np.clip(columns["OP"], 0.0, 100.0)
    _, output = step_test(judge_valve(ControlLoop.of(columns["OP"], columns["PV"])))
    assert output.min() >= 0.0
    assert output.max() <= 100.0
    assert set(np.sign(np.diff(output))) == {-1.0, 0.0, 1.0}


def test_the_example_has_the_processes_of_the_page():
    assert set(simulator()["PROCESSES"]) == {"flow", "pressure", "level", "temperature"}
