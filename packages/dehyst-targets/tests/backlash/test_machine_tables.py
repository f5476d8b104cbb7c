"""Tables of generated backlash, read and applied by simulated machines that know nothing of the package."""

import configparser
import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from backlash_machines import Axis, GrblHAL, LinuxCNC, Marlin, Plain, errors, measure
from dehyst.errors import DehystError
from dehyst_targets.backlash import (
    MACHINES,
    AxisReadings,
    Compensation,
    LostMotion,
    compensation_for,
    lost_motion,
    make_table,
    read_compensation,
    write_table,
)

POINTS = np.linspace(0.0, 300.0, 13)
CONSTANT = {"grblhal": GrblHAL, "marlin": Marlin}


def play(position):
    return 0.03 + 0.02 * position / 300.0


def pitch(position):
    return 0.012 * np.sin(position / 35.0) + 4e-5 * position


def evaluated(rows, unit="mm"):
    _, point, rising, value = map(np.array, zip(*rows, strict=True))
    return lost_motion(AxisReadings.of(point, value - point, rising, unit=unit))


def around_zero(rising, falling):
    """Errors less the mean of both directions at 0, as a table is meant."""
    shift = 0.5 * (rising[0] + falling[0])
    return rising - shift, falling - shift


def rms(*values):
    return float(np.sqrt(np.mean(np.square(values))))


def test_a_joint_of_linuxcnc_with_the_table_errs_by_its_repeatability_alone():
    noise = 0.001
    before = measure(Plain(Axis(play, pitch)), POINTS, 3, noise=noise, seed=1)
    lost = evaluated(before)
    table = make_table(lost, "linuxcnc")
    after = measure(
        LinuxCNC(Axis(play, pitch), table.files["x.comp"]), POINTS, 3, noise=noise, seed=2
    )
    left = around_zero(*errors(after))
    # Means of three readings, those of the table and those after it; and those of the reference.
    assert rms(*left) < 2.0 * noise * np.sqrt(2.0 / 3.0) < 0.1 * rms(lost.rising, lost.falling)
    again = evaluated(after)
    assert not again.is_significant and abs(again.mean) < 3.0 * noise / np.sqrt(POINTS.size)
    assert make_table(again, "linuxcnc").files == {}


def test_without_noise_only_the_pitch_between_command_and_motor_is_left():
    lost = evaluated(measure(Plain(Axis(play, pitch)), POINTS))
    machine = LinuxCNC(Axis(play, pitch), make_table(lost, "linuxcnc").files["x.comp"])
    rising, falling = around_zero(*errors(measure(machine, POINTS)))
    # |e(x - e) - e(x)| <= |e'| |e|: 5e-4 of 0.05 mm; and a digit of the file.
    assert max(np.abs(rising).max(), np.abs(falling).max()) < 3e-5


def test_between_points_the_error_left_is_about_what_is_said():
    lost = evaluated(measure(Plain(Axis(play, pitch)), POINTS))
    machine = LinuxCNC(Axis(play, pitch), make_table(lost, "linuxcnc").files["x.comp"])
    rising, falling = errors(measure(machine, np.linspace(0.0, 300.0, 97)))
    largest = max(np.abs(rising - rising[0]).max(), np.abs(falling - falling[0]).max())
    assert 0.6 * lost.between < largest < 1.7 * lost.between


def test_a_table_with_the_sign_turned_doubles_the_error():
    lost = evaluated(measure(Plain(Axis(play)), POINTS))
    lines = []
    for line in make_table(lost, "linuxcnc").files["x.comp"].splitlines():
        nominal, forward, reverse = map(float, line.split())
        lines.append(f"{nominal} {2 * nominal - forward} {2 * nominal - reverse}")
    rising, falling = errors(measure(LinuxCNC(Axis(play), "\n".join(lines)), POINTS))
    np.testing.assert_allclose(falling - rising, 2.0 * lost.lost_motion, rtol=2e-2)


@settings(max_examples=40, deadline=None)
@given(
    st.lists(st.floats(0.01, 0.3), min_size=2, max_size=12),
    st.floats(-0.05, 0.05),
    st.floats(20.0, 80.0),
)
def test_whatever_the_play_is_over_the_axis_the_table_takes_it_out(widths, size, length):
    nodes = np.linspace(0.0, 300.0, len(widths))

    def width(position):
        return float(np.interp(position, nodes, widths))

    def screw(position):
        return size * np.sin(position / length)

    lost = evaluated(measure(Plain(Axis(width, screw)), nodes, 2))
    np.testing.assert_allclose(lost.lost_motion, widths, atol=0.02 * max(widths) + 1e-6)
    table = make_table(lost, "linuxcnc")
    left = errors(measure(LinuxCNC(Axis(width, screw), table.files["x.comp"]), nodes))
    # What is left is of second order: the slope of the errors, at most 0.02, times the errors.
    assert max(np.abs(side - side.mean()).max() for side in left) < 0.02 * (
        max(widths) + 2.0 * abs(size)
    )


@pytest.mark.parametrize("machine", CONSTANT)
def test_one_number_takes_out_the_mean_and_leaves_what_is_said(machine):
    lost = evaluated(measure(Plain(Axis(play, pitch)), POINTS))
    table = make_table(lost, machine)
    text = table.files[f"x{MACHINES[machine].main}"]
    rising, falling = errors(measure(CONSTANT[machine](Axis(play, pitch), text), POINTS))
    left = around_zero(rising, falling)
    np.testing.assert_allclose(left[0], table.rising, atol=1e-3)
    np.testing.assert_allclose(left[1], table.falling, atol=1e-3)
    # The play varies by 0.02 mm, of which half is left at each end; the pitch is left whole.
    assert 0.009 < np.abs(falling - rising).max() < 0.0115
    middle = 0.5 * (left[0] + left[1])
    np.testing.assert_allclose(middle - middle[0], lost.middle, atol=5e-4)


@pytest.mark.parametrize("machine", CONSTANT)
def test_a_play_that_is_the_same_everywhere_is_taken_out_by_one_number(machine):
    lost = evaluated(measure(Plain(Axis(0.04)), POINTS))
    text = make_table(lost, machine).files[f"x{MACHINES[machine].main}"]
    rising, falling = errors(measure(CONSTANT[machine](Axis(0.04), text), POINTS))
    np.testing.assert_allclose(falling, rising, atol=1.1e-3)


def test_marlin_takes_up_no_more_than_the_length_of_a_move():
    machine = Marlin(Axis(0.2), "M425 X0.2 F1 S0\n")
    machine.go(10.0)
    at = machine.go(10.05), machine.go(10.0)
    # 0.05 mm back with a play of 0.2 mm: only 0.05 mm were added, so that the axis has not moved.
    assert at[1] == pytest.approx(at[0])
    assert "no more than its own" in MACHINES["marlin"].limit


# Formats, read back by parsers of their own.


def test_linuxcnc_files_hold_actual_positions_and_the_lines_for_the_ini_file(tmp_path):
    lost = LostMotion.example()
    write_table(lost, "linuxcnc", "Z", tmp_path / "new" / "folder")
    rows = np.loadtxt(tmp_path / "new" / "folder" / "z.comp")
    np.testing.assert_allclose(rows[:, 0], lost.nominal)
    np.testing.assert_allclose(rows[:, 1] - rows[:, 0], lost.rising, atol=1e-6)
    np.testing.assert_allclose(rows[:, 2] - rows[:, 0], lost.falling, atol=1e-6)
    # A rising axis with play comes short, and a falling one stays above.
    assert np.all(rows[:, 1] < rows[:, 2])
    ini = configparser.ConfigParser(comment_prefixes="#")
    ini.read(tmp_path / "new" / "folder" / "z.ini")
    assert dict(ini["JOINT_2"]) == {"comp_file": "z.comp", "comp_file_type": "0"}


def test_the_example_of_linuxcnc_s_documentation_is_read_as_its_source_does():
    text = "-1.000 -1.005 -0.995\n0.000 0.002 -0.003\n1.000 1.003 0.998\n"
    read = read_compensation(text, "linuxcnc")
    joint = LinuxCNC(Axis(0.0), text)
    np.testing.assert_allclose(read.rising, joint.forward, atol=1e-7)
    np.testing.assert_allclose(read.falling, joint.reverse, atol=1e-7)
    np.testing.assert_allclose(read.rising, [0.005, -0.002, -0.003], atol=1e-12)
    # Constant beyond the ends, straight between points.
    assert read.added(np.array([-9.0, 0.5, 9.0]), rising=True).round(6).tolist() == [
        0.005,
        -0.0025,
        -0.003,
    ]


@pytest.mark.parametrize(
    ("axis", "number"), [("X", 160), ("Y", 161), ("Z", 162), ("A", 163), ("V", 167)]
)
def test_grblhal_gets_one_setting_of_its_axis(axis, number):
    lost = LostMotion.example()
    text = make_table(lost, "grblhal", axis).files[f"{axis.lower()}.settings"]
    assert text == f"${number}=0.040\n"


def test_marlin_gets_m425_and_lines_of_its_configuration():
    files = make_table(LostMotion.example(), "marlin", "Y", smoothing=3.0).files
    assert files["y.gcode"] == "G21\nM425 Y0.0398 F1 S3\n"
    (distances,) = re.findall(
        r"#define BACKLASH_DISTANCE_MM \{ (.*) \}", files["y_configuration.h"]
    )
    assert distances == "0, 0.0398, 0"
    for name in ("COMPENSATION", "CORRECTION", "SMOOTHING_MM", "GCODE"):
        assert f"#define BACKLASH_{name}" in files["y_configuration.h"]


def test_examples_of_marlin_s_documentation_are_read():
    both = "M425 X0.1 Y0.2 Z0.3 ; Set backlash to specific values for all axis\nM425 F1 ; Enable\n"
    for axis, size in (("X", 0.1), ("Y", 0.2), ("Z", 0.3)):
        assert read_compensation(both, "marlin", axis).rising.tolist() == [0.5 * size]
    assert read_compensation("M425 X0.1\n", "marlin").rising.tolist() == [0.0]  # not enabled


def test_klipper_gets_nothing_and_it_is_said_why():
    table = make_table(LostMotion.example(), "klipper")
    assert table.files == {} and table.reason.code == "backlash-no-table"
    assert "7259" in table.reason.message and "mechanics" in table.reason.message


@pytest.mark.parametrize("unit", ["mm", "in", "um", "deg"])
def test_units_of_a_sheet_become_those_of_the_machine(unit):
    factor = {"mm": 1.0, "in": 1.0 / 25.4, "um": 1000.0, "deg": 1.0}[unit]
    lost = evaluated(measure(Plain(Axis(0.04)), POINTS))
    readings = AxisReadings.of(
        np.repeat(factor * POINTS, 2),
        factor * np.column_stack([lost.rising, lost.falling]).ravel(),
        np.tile([1, 0], POINTS.size),
        unit=unit,
    )
    scaled = lost_motion(readings)
    assert make_table(scaled, "grblhal", "A").files["a.settings"] == "$163=0.040\n"
    last = make_table(scaled, "linuxcnc").files["x.comp"].splitlines()[-1].split()
    assert float(last[0]) == pytest.approx(300.0 / (25.4 if unit == "in" else 1.0), abs=1e-6)
    if unit != "deg":
        assert "M425 X0.0400 " in make_table(scaled, "marlin").files["x.gcode"]
    else:
        with pytest.raises(DehystError, match="grblhal and linuxcnc"):
            make_table(scaled, "marlin")


def test_more_points_than_linuxcnc_takes_are_thinned_and_the_rest_is_still_right():
    points = np.linspace(0.0, 300.0, 601)
    lost = evaluated(measure(Plain(Axis(play, pitch)), points))
    table = make_table(lost, "linuxcnc")
    joint = LinuxCNC(Axis(play, pitch), table.files["x.comp"])
    assert len(joint.nominal) == 256 and not joint.reports
    assert (joint.nominal[0], joint.nominal[-1]) == (0.0, 300.0)
    assert max(np.abs(table.rising).max(), np.abs(table.falling).max()) < 1e-4


def test_a_digit_of_the_file_is_all_that_differs_from_what_was_meant():
    lost = evaluated(measure(Plain(Axis(play, pitch)), POINTS))
    for machine, half_digit in (("linuxcnc", 5e-7), ("grblhal", 5e-4), ("marlin", 5e-5)):
        assert make_table(lost, machine).read_back <= half_digit * 1.001


def test_lost_motion_within_the_repeatability_leaves_the_pitch_to_the_table():
    lost = evaluated(measure(Plain(Axis(0.0, pitch)), POINTS, 3, noise=1e-3))
    assert not lost.is_significant and lost.is_pitch_significant
    made = compensation_for(lost, one_number=False)
    np.testing.assert_array_equal(made.rising, made.falling)
    assert make_table(lost, "linuxcnc").files and not make_table(lost, "marlin").files


BAD_TABLES = {
    "comment first": ("linuxcnc", "# my table\n0 0 0\n", "2 of 2 lines would be lost"),
    "two numbers": ("linuxcnc", "0 0 0\n1 1\n2 2 2\n", "2 of 3 lines would be lost"),
    "descending": ("linuxcnc", "1 1 1\n0 0 0\n", "not above"),
    "twice": ("linuxcnc", "0 0 0\n0 0 0\n", "not above"),
    "nothing": ("linuxcnc", "", "0 triplets"),
    "not finite": ("linuxcnc", "0 nan 0\n", "stops at"),
    "too many": ("linuxcnc", "".join(f"{k} {k} {k}\n" for k in range(257)), "257 triplets"),
    "another setting": ("grblhal", "$100=250\n", "no line \\$160"),
    "no setting": ("grblhal", "G1 X3\n", "no setting of grblHAL"),
    "negative": ("grblhal", "$160=-0.1\n", "no setting of grblHAL"),
    "no M425": ("marlin", "G1 X0.1\n", "no M425"),
    "another axis": ("marlin", "M425 Y0.1 F1\n", "no M425"),
    "bad word": ("marlin", "M425 Xabc\n", "no word of M425"),
    "bad fade": ("marlin", "M425 X0.1 F2\n", "lies between"),
    "klipper": ("klipper", "", "nothing to read"),
    "unknown": ("mach3", "", "is not known"),
}


@pytest.mark.parametrize("name", BAD_TABLES)
def test_what_a_machine_would_not_read_is_refused_with_the_place(name):
    machine, text, words = BAD_TABLES[name]
    with pytest.raises(DehystError, match=words):
        read_compensation(text, machine)


def test_what_linuxcnc_loses_of_such_files_is_really_lost():
    """The oracle of the refusals: the simulated joint stops where the parser says so."""
    assert LinuxCNC(Axis(), BAD_TABLES["comment first"][1]).nominal == []
    assert LinuxCNC(Axis(), BAD_TABLES["two numbers"][1]).nominal == [0.0]
    assert LinuxCNC(Axis(), BAD_TABLES["descending"][1]).reports
    assert LinuxCNC(Axis(), BAD_TABLES["too many"][1]).reports


def test_a_compensation_in_another_unit_is_the_same():
    made = Compensation(np.array([0.0, 1.0]), np.array([0.1, 0.2]), np.array([-0.1, 0.0]))
    back = made.converted("in", "mm").converted("mm", "in")
    np.testing.assert_allclose(back.rising, made.rising)
    assert made.converted("in", "mm").nominal.tolist() == [0.0, 25.4]
