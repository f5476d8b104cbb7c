"""The plan: the program reaches each point from the side that the sheet says, in the G-code of each machine."""

import csv
import io
import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dehyst.errors import DehystError
from dehyst_targets.backlash import MACHINES, plan_measurement


def stops(program, dwell=r"G4 "):
    """Where a program rests: the position, and whether it was reached from below; every move by itself."""
    place, rising, rests = None, None, []
    for line in program.splitlines():
        move = re.fullmatch(r"(?:G53 )?G1 ([XYZABCUVW])(-?\d+(?:\.\d+)?) F[\d.]+", line)
        if move:
            target = float(move[2])
            if place is not None and target != place:
                rising = target > place
            place = target
        elif re.match(dwell, line):
            rests.append((place, rising))
    return rests


@settings(max_examples=40, deadline=None)
@given(
    st.floats(-500.0, 500.0),
    st.floats(1.0, 900.0),
    st.integers(2, 9),
    st.integers(1, 3),
    st.lists(st.sampled_from([0.5, 2.0, 10.0]), min_size=1, max_size=2, unique=True),
)
def test_every_row_of_the_sheet_is_a_rest_of_the_program_reached_from_its_side(
    low, way, points, repeats, approaches
):
    plan = plan_measurement(
        low, low + way, points=points, repeats=repeats, approach=tuple(approaches)
    )
    rests = stops(plan.gcode())
    sheet = list(csv.DictReader(io.StringIO(plan.sheet())))
    assert len(rests) == len(sheet) == 2 * points * repeats * len(approaches)
    for (place, rising), row in zip(rests, sheet, strict=True):
        assert float(row["commanded [mm]"]) == place
        assert row["direction"] == ("rising" if rising else "falling")
        assert row["measured [mm]"] == ""
    assert min(place for place, _ in rests) == pytest.approx(low, abs=1e-5)
    assert plan.low == pytest.approx(low - max(approaches), abs=1e-4)


RESTS = {"linuxcnc": "G4 P1.5", "grblhal": "G4 P1.5", "marlin": "G4 S1.5", "klipper": "G4 P1500"}


@pytest.mark.parametrize("machine", MACHINES)
def test_a_rest_is_written_in_the_unit_of_the_machine(machine):
    """LinuxCNC and grblHAL take P in seconds, Marlin S in seconds, Klipper P in milliseconds."""
    program = plan_measurement(0.0, 10.0, points=2, hold=1.5).gcode(machine, "Y")
    lines = program.splitlines()
    assert lines.count(RESTS[machine]) == 4 and len(stops(program)) == 4
    paused = plan_measurement(0.0, 10.0, points=2).gcode(machine, "Y", pause=True)
    assert len(stops(paused, r"M0$|PAUSE$")) == 4 and not stops(paused)
    # Only machines with machine coordinates get G53.
    assert ("G53" in program) == (machine in ("linuxcnc", "grblhal"))


def test_inch_programs_begin_with_g20_and_klipper_takes_none():
    plan = plan_measurement(0.0, 12.0, unit="inch", approach=(0.1,))
    assert "G20" in plan.gcode() and "G21" not in plan.gcode() and "[in]" in plan.sheet()
    assert "G20" in plan.gcode("marlin")
    with pytest.raises(DehystError, match="Type --unit mm"):
        plan.gcode("klipper")


def test_the_duration_is_that_of_all_ways_and_rests():
    plan = plan_measurement(0.0, 10.0, points=2, approach=(1.0,), rate=2.0, hold=3.0)
    # -1, 0, 1, 0, 9, 10, 11, 10: 1 + 1 + 1 + 9 + 1 + 1 + 1 at 2 a second, four rests.
    assert plan.duration == pytest.approx(15.0 / 2.0 + 12.0)


BAD = [
    {"low": 10.0, "high": 0.0}, {"points": 1}, {"repeats": 0}, {"approach": (0.0,)}, {"approach": (np.nan,)},
    {"unit": "bar"}, {"unit": "m"}, {"rate": 0.0}, {"hold": -1.0}, {"points": 10**6}, {"high": np.inf},
]  # fmt: skip


@pytest.mark.parametrize("change", BAD)
def test_a_plan_that_makes_no_sense_is_refused(change):
    settings = {"low": 0.0, "high": 300.0, **change}
    with pytest.raises(DehystError, match=r"--|Type|must"):
        plan_measurement(settings.pop("low"), settings.pop("high"), **settings)


@pytest.mark.parametrize(("machine", "axis"), [("marlin", "A"), ("linuxcnc", "XY"), ("fanuc", "X")])
def test_a_machine_or_an_axis_that_is_not_there_is_refused(machine, axis):
    with pytest.raises(DehystError, match="Type one of"):
        plan_measurement(0.0, 10.0).gcode(machine, axis)
