"""Units: names are read as a person reads them, and numbers convert as tables say."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from dehyst.errors import UnitError
from dehyst.units import TABLE, canonical, convert, dimension, parse_unit, stray_suffixes


@pytest.mark.parametrize(
    ("name", "bare", "unit"),
    [
        ("pressure_bar", "pressure", "bar"),
        ("pressure_interp_psi", "pressure_interp", "psi"),
        ("pressure_mpa", "pressure", "MPa"),
        ("pressure_MPa", "pressure", "MPa"),
        ("angle [deg]", "angle", "deg"),
        ("angle[deg]", "angle", "deg"),
        ("angle (deg)", "angle", "deg"),
        ("angle [°]", "angle", "deg"),
        ("p/bar", "p", "bar"),
        ("time_s", "time", "s"),
        ("time_ms", "time", "ms"),
        ("t [s]", "t", "s"),
        ("force_N", "force", "N"),
        ("displacement_um", "displacement", "um"),
        ("displacement [µm]", "displacement", "um"),
        ("displacement_nm", "displacement", "nm"),
        ("torque_nm", "torque", "Nm"),
        ("voltage_v", "voltage", "V"),
        ("velocity_mm_s", "velocity", "mm/s"),
        ("flow [l/min]", "flow", "l/min"),
        ("strain [-]", "strain", ""),
    ],
)
def test_a_unit_is_read_from_a_column_name(name: str, bare: str, unit: str) -> None:
    assert parse_unit(name) == (bare, unit)


@pytest.mark.parametrize(
    "name",
    [
        "aux_a",
        "pressure_min",
        "pressure_in",
        "valve_h",
        "joint_m",
        "angle",
        "/joint_states.position[0]",
        "s",
        "",
        "_s",
    ],
)
def test_a_suffix_that_may_be_a_letter_or_a_word_is_no_unit(name: str) -> None:
    assert parse_unit(name) == (name, "")


@pytest.mark.parametrize(
    ("value", "source", "target", "expected"),
    [
        (1.0, "bar", "Pa", 100000.0),
        (14.503773773, "psi", "bar", 1.0),
        (0.6, "MPa", "bar", 6.0),
        (180.0, "deg", "rad", math.pi),
        (1.0, "in", "mm", 25.4),
        (1.0, "lbf", "N", 4.4482216152605),
        (90.0, "min", "h", 1.5),
        (250.0, "ms", "s", 0.25),
    ],
)
def test_conversions_agree_with_printed_tables(
    value: float, source: str, target: str, expected: float
) -> None:
    assert convert(value, source, target) == pytest.approx(expected, rel=1e-9)


def test_every_conversion_within_a_dimension_comes_back() -> None:
    values = np.array([-3.0, 0.0, 1e-9, 7.25, 1e12])
    for dimension_name, units in TABLE.items():
        # A temperature is shifted by hundreds, whose rounding stays.
        rounding = 1e-12 if dimension_name == "temperature" else 0.0
        for a, b in itertools.product(units, repeat=2):
            back = convert(convert(values, a, b), b, a)
            np.testing.assert_allclose(back, values, rtol=1e-15, atol=rounding)


def test_temperatures_are_shifted_as_the_fixed_points_of_water_say() -> None:
    for value, unit, other, expected in (
        (0.0, "degC", "K", 273.15), (32.0, "degF", "degC", 0.0), (212.0, "degF", "K", 373.15),
        (100.0, "degC", "degF", 212.0),
    ):  # fmt: skip
        assert float(convert(value, unit, other)) == pytest.approx(expected, abs=1e-9)


def test_different_dimensions_are_refused_by_name() -> None:
    with pytest.raises(UnitError, match=r"bar \(pressure\) into deg \(angle\)") as caught:
        convert(1.0, "bar", "deg")
    assert caught.value.facts == {"source": "bar", "target": "deg"}
    with pytest.raises(UnitError, match="'furlong' is not known"):
        convert(1.0, "furlong", "m")


def test_spelling_and_dimension() -> None:
    assert [canonical(u) for u in ("BAR", "kpa", "mV", "N", "mN", "Nm", "nm", "degrees")] == [
        "bar", "kPa", "mV", "N", "mN", "Nm", "nm", "deg",
    ]  # fmt: skip
    assert canonical("MV") is None, "megavolt must not pass for millivolt"
    assert dimension("kN") == "force"
    assert dimension("°C") == "temperature"
    assert dimension("furlong") == ""


@pytest.mark.parametrize(
    ("name", "unit"),
    [
        ("Winkel (Grad)", "deg"),
        ("winkel_grad", "deg"),
        ("Druck [Bar]", "bar"),
        ("Spannung [Volt]", "V"),
        ("Zeit (Sekunden)", "s"),
        ("Zeit [Millisekunden]", "ms"),
        ("Weg [Millimeter]", "mm"),
        ("Kraft (Newton)", "N"),
        ("Moment [Newtonmeter]", "Nm"),
        ("force [Kilonewton]", "kN"),
    ],
)
def test_units_may_be_written_out_in_english_or_german(name: str, unit: str) -> None:
    assert parse_unit(name)[1] == unit


def test_a_gradient_is_no_angle() -> None:
    assert parse_unit("pressure_grad") == ("pressure_grad", "")


@pytest.mark.parametrize(
    ("name", "unit"),
    [("micros", "us"), ("millis", "ms"), ("Sekunden", "s"), ("milliseconds", "ms")],
)
def test_a_name_that_is_a_unit_of_time_is_both(name: str, unit: str) -> None:
    assert parse_unit(name) == (name, unit)


def test_a_rate_has_no_stray_ending():
    assert stray_suffixes(["time_s", "velocity_mm_s", "omega_deg_s", "speed_m_s"]) == frozenset()


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("field_kV_per_mm", ("field", "kV/mm")),
        ("H_A_per_m", ("H", "A/m")),
        ("E_kv_per_cm", ("E", "kV/cm")),
        ("flow_l_per_min", ("flow", "l/min")),
        ("counts_per_mm", ("counts_per_mm", "")),
        ("cycles_per_min", ("cycles_per_min", "")),
        ("rate_per_s", ("rate_per_s", "")),
        ("force_per_area_N", ("force_per_area", "N")),
    ],
)
def test_a_quotient_in_a_name_is_a_unit_or_none_and_never_its_denominator(name, expected):
    assert parse_unit(name) == expected
