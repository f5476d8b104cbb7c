"""Sheets and logs: columns, units, directions, stops; and the sheets that are refused."""

import numpy as np
import pytest

from backlash_machines import Axis, Plain, measure, write_sheet
from dehyst.errors import DehystError
from dehyst_targets.backlash import lost_motion, read_measurement

POINTS = np.linspace(0.0, 300.0, 5)


def sheet(folder, text, name="m.csv"):
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def rows(noise=0.0, repeats=2):
    return measure(Plain(Axis(0.04)), POINTS, repeats, noise=noise)


def codes(made):
    return [finding.code for finding in made.findings]


WORDS = [
    ("rising", "falling"), ("Up", "DOWN"), ("1", "-1"), ("forward", "reverse"),
    ("from below", "from above"),
]  # fmt: skip


@pytest.mark.parametrize("words", WORDS)
def test_a_direction_may_be_written_in_many_ways(tmp_path, words):
    lines = ["commanded [mm];direction;measured [mm]"]
    for _, point, rising, value in rows():
        lines.append(f"{point:g};{words[0] if rising else words[1]};{value:.3f}".replace(".", ","))
    made = read_measurement(sheet(tmp_path, "\n".join(lines)))
    assert codes(made) == [] and lost_motion(made).mean == pytest.approx(0.04)


def test_errors_in_place_of_positions_give_the_same(tmp_path):
    measured = read_measurement(write_sheet(tmp_path / "m.csv", rows()))
    lines = ["nominal [mm],direction,deviation [um]"]
    for point, rising, error in zip(
        measured.commanded, measured.rising, measured.error, strict=True
    ):
        lines.append(f"{point:g},{'up' if rising else 'down'},{1000 * error:.1f}")
    from_errors = read_measurement(sheet(tmp_path, "\n".join(lines), "e.csv"))
    np.testing.assert_allclose(from_errors.error, measured.error, atol=1e-12)
    assert from_errors.unit == "mm"


def test_inch_and_mm_beside_each_other_become_one_unit(tmp_path):
    lines = ["commanded [in],direction,measured [mm]"]
    for _, point, rising, value in rows():
        lines.append(f"{point / 25.4:.9f},{'up' if rising else 'down'},{value:.6f}")
    made = read_measurement(sheet(tmp_path, "\n".join(lines)))
    assert made.unit == "in" and lost_motion(made).mean == pytest.approx(0.04 / 25.4, rel=1e-3)


def test_without_a_unit_mm_is_taken_and_said_and_typed_it_is_not(tmp_path):
    path = write_sheet(tmp_path / "m.csv", rows(), "commanded,direction,measured")
    assert codes(read_measurement(path)) == ["backlash-unit"]
    typed = read_measurement(path, unit="inch")
    assert codes(typed) == [] and typed.unit == "in"


def test_a_typed_unit_that_contradicts_the_sheet_is_refused(tmp_path):
    path = write_sheet(tmp_path / "m.csv", rows())
    assert read_measurement(path, unit="mm").unit == "mm"
    with pytest.raises(DehystError, match="contradicts the column"):
        read_measurement(path, unit="in")


def test_rows_that_were_not_filled_in_are_left_out(tmp_path):
    path = write_sheet(tmp_path / "m.csv", rows())
    lines = path.read_text().splitlines()
    lines[3] = lines[3].rpartition(",")[0] + ","
    made = read_measurement(sheet(tmp_path, "\n".join(lines), "gap.csv"))
    assert made.size == len(lines) - 2 and 4 not in made.rows and 5 in made.rows


@pytest.mark.parametrize("order", ["each point from both sides", "up and down"])
def test_directions_come_from_the_order_where_no_column_says_them(tmp_path, order):
    lines, truth = ["commanded [mm],measured [mm]"], []
    run = rows(repeats=2)
    if order == "up and down":
        run = []
        for _ in range(2):
            run += [(0, point, True, point - 0.02) for point in POINTS]
            run += [(0, point, False, point + 0.02) for point in POINTS[::-1]]
    for _, point, rising, value in run:
        lines.append(f"{point:g},{value:.3f}")
        truth.append(rising)
    made = read_measurement(sheet(tmp_path, "\n".join(lines)))
    assert codes(made) == ["backlash-direction"]
    assert made.rising.tolist() == truth


def test_an_order_that_tells_no_direction_is_refused(tmp_path):
    text = "commanded [mm],measured [mm]\n" + "".join(f"{p:g},{p:g}\n" * 3 for p in POINTS)
    with pytest.raises(DehystError, match="Add a column 'direction'"):
        read_measurement(sheet(tmp_path, text))


def test_a_log_with_time_gives_its_stops(tmp_path):
    axis, lines, time = Axis(0.04), ["time_s,commanded [mm],actual [mm]"], 0.0
    rng = np.random.default_rng(0)
    place = 0.0
    for _ in range(3):
        for point in POINTS:
            for turn in (point - 2.0, point + 2.0):
                for target, stop in ((turn, 2), (point, 40)):
                    way = np.linspace(place, target, 12)[1:]
                    for count, command in enumerate((*way, *[target] * stop)):
                        time += 0.02
                        at = axis.move(command) + 1e-3 * rng.normal()
                        # The axis swings until just before the middle of a stop.
                        if count < len(way) + 0.48 * stop:
                            at -= 0.05 * np.sign(target - place)
                        lines.append(f"{time:.2f},{command:.4f},{at:.5f}")
                    place = target
    made = read_measurement(sheet(tmp_path, "\n".join(lines)))
    # The very first stop is reached by a motion that the log holds, too.
    assert made.size == 6 * POINTS.size
    lost = lost_motion(made)
    assert lost.mean == pytest.approx(0.04, abs=5e-4)
    assert lost.nominal.tolist() == POINTS.tolist()


def body(change):
    lines = []
    for _, point, rising, value in rows():
        lines.append(change(point, "rising" if rising else "falling", value))
    return "\n".join(lines)


PLAIN = body(lambda p, d, v: f"{p:g},{d},{v:.4f}")
BAD = {
    "empty": ("", "holds nothing|is empty|no "),
    "not filled in": (
        "commanded [mm],direction,measured [mm]\n" + body(lambda p, d, v: f"{p:g},{d},"),
        "Fill it in|text",
    ),
    "no commands": ("place [mm],direction,measured [mm]\n" + PLAIN, "no column 'commanded'"),
    "no readings": ("commanded [mm],direction,gap [mm]\n" + PLAIN, "neither a column 'measured'"),
    "two commands": (
        "commanded [mm],direction,measured [mm],target [mm]\n"
        + body(lambda p, d, v: f"{p:g},{d},{v:.4f},{p:g}"),
        "2 columns that may be",
    ),
    "another word": (
        "commanded [mm],direction,measured [mm]\n" + PLAIN.replace("rising", "left"),
        "is no direction",
    ),
    "inch beside mm": (
        "commanded,direction,measured\n" + body(lambda p, d, v: f"{p:g},{d},{v / 25.4:.6f}"),
        "the other in inch",
    ),
    "against the axis": (
        "commanded [mm],direction,measured [mm]\n" + body(lambda p, d, v: f"{p:g},{d},{-v:.4f}"),
        "counts against the axis",
    ),
    "errors as positions": (
        "commanded [mm],direction,measured [mm]\n" + body(lambda p, d, v: f"{p:g},{d},{v - p:.4f}"),
        "Head it 'error'",
    ),
    "half the steps": (
        "commanded [mm],direction,measured [mm]\n" + body(lambda p, d, v: f"{p:g},{d},{v / 2:.4f}"),
        "steps per unit",
    ),
    "a pressure": ("commanded [bar],direction,measured [mm]\n" + PLAIN, "moves by a length"),
    "length and angle": ("commanded [mm],direction,measured [deg]\n" + PLAIN, "deg"),
}


@pytest.mark.parametrize("name", BAD)
def test_a_sheet_that_cannot_be_used_is_refused_with_what_to_do(tmp_path, name):
    text, words = BAD[name]
    with pytest.raises(DehystError, match=words):
        lost_motion(read_measurement(sheet(tmp_path, text)))


def test_commands_that_flicker_are_one_point_and_errors_are_those_of_each_row(tmp_path):
    lines, rng = ["commanded [mm],direction,measured [mm]"], np.random.default_rng(0)
    for _, point, rising, value in rows(noise=1e-3, repeats=3):
        at = 0.001 * rng.integers(-3, 4)
        lines.append(f"{point + at:.4f},{'up' if rising else 'down'},{value + at:.4f}")
    lost = lost_motion(read_measurement(sheet(tmp_path, "\n".join(lines))))
    np.testing.assert_allclose(lost.nominal, POINTS, atol=0.003)
    assert lost.counts.min() == 3 and lost.spread < 1.5e-3


@pytest.mark.parametrize("cell", ["9.9e37", "1e308", "inf", "-2e6"])
def test_what_an_overloaded_gauge_writes_is_refused_with_its_line(tmp_path, cell):
    text = "commanded [mm],direction,measured [mm]\n" + PLAIN
    lines = text.split("\n")
    lines[4] = lines[4].rpartition(",")[0] + f",{cell}"
    with pytest.raises(DehystError, match=r"line 5: .* is no position"):
        read_measurement(sheet(tmp_path, "\n".join(lines)))


def test_columns_may_be_named(tmp_path):
    path = sheet(tmp_path, "x [mm],direction,laser [mm]\n" + PLAIN)
    made = read_measurement(path, commanded="x", measured="laser")
    assert lost_motion(made).mean == pytest.approx(0.04)
