"""Spellings of units whose truth is known: a wrong unit is worse than none."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from dehyst.io import LogTable
from dehyst.units import canonical, parse_unit, work_unit


def pairs(text: str) -> list[tuple[str, str]]:
    return [
        (spelling, unit) for spelling, _, unit in (pair.rpartition("=") for pair in text.split())
    ]


# Spelling in brackets -> unit; what is not known stands as it is. Beside "signal", the wrong case is another unit.
SPELLINGS = {
    "pressure": """
        Pa=Pa PA=Pa pascal=Pa kPa=kPa KPA=kPa kpa=kPa KPa=kPa Kpa=kPa MPa=MPa MPA=MPa mpa=MPa Mpa=MPa mPa=mPa
        bar=bar Bar=bar BAR=bar mbar=mbar MBAR=mbar hPa=mbar HPA=mbar hpa=mbar psi=psi PSI=psi Psi=psi psig=psi
        pA=pA Mbar=Mbar GPa=GPa torr=torr Millibar=mbar kilopascal=kPa
    """,
    "angle": """
        rad=rad RAD=rad Rad=rad deg=deg DEG=deg Deg=deg °=deg Grad=deg mrad=mrad MRAD=mrad Mrad=Mrad radians=rad
        Degrees=deg
    """,
    "length": """
        m=m mm=mm MM=mm Mm=Mm um=um UM=um µm=um μm=um nm=nm NM=nm cm=cm in=in IN=in inch=in mM=mM µM=µM nM=nM
        M=m
    """,
    "force": """
        N=N n=N kN=kN KN=kN kn=kN mN=mN MN=MN mn=mN Mn=Mn lbf=lbf newton=N Ns=Ns
    """,
    "voltage": """
        V=V v=V mV=mV MV=MV mv=mV Mv=Mv kV=kV KV=kV Volt=V VOLTS=V
    """,
    "current": """
        A=A a=A mA=mA MA=MA ma=mA Ma=Ma amp=A nA=nA
    """,
    "torque": """
        Nm=Nm nm=Nm NM=Nm N·m=Nm N*m=Nm mNm=mNm MNm=MNm MNM=MNM mnm=mNm
    """,
    "time": """
        s=s S=s sec=s Sec=s SECONDS=s ms=ms MS=ms Ms=Ms msec=ms us=us US=us µs=us μs=us ns=ns NS=ns Ns=Ns
        min=min Min=min MIN=min h=h H=h hours=h uS=uS µS=µS mS=mS nS=nS
    """,
    "signal": """
        S=S H=H a=a n=n v=v M=M A=A V=V N=N m=m s=s h=h mS=mS µS=µS Ns=Ns NM=NM MV=MV -= %=% rpm=rpm
        l/min=l/min K=K °C=degC none=
    """,
}

# Names that end in a unit, or seem to.
SUFFIXES = """
    pressure_bar=bar p_mpa=MPa p_MPa=MPa p_mPa=mPa p_kPa=kPa PRESSURE_MPA=MPa pressure_pa=Pa P_PA=Pa drive_pa=
    pressure_hPa=mbar pos_in= x_in= y_in= pressure_in= valve_in= position_in=in stroke_in=in length_in=in x_out=
    pos_out= u_in= pressure_min= angle_min= force_min= pos_max= time_min=min t_min=min elapsed_min=min valve_h=
    t_h=h time_h=h level_h= x_d= pos_d= p_d= theta_d= x_k= gain_k= temp_c= i_c= x_v= u_v=V drive_v=V valve_v=
    valve_V=V aux_a= i_a=A current_a=A phase_a= chamber_a= tendon_n= force_n=N force_N=N channel_n= node_n=
    tendon_N=N x_m=m pos_m=m joint_m= mass_m= disp_nm=nm torque_nm=Nm torque_NM=Nm load_Nm=Nm stroke_nm=nm
    STROKE_NM=nm valve_nm= force_kn=kN speed_kn= force_kN=kN motor_kv= voltage_kv=kV motor_mA=mA valve_ma=
    i_ma=mA tendon_mN=mN valve_mn= force_MN= voltage_mV=mV voltage_MV= voltage_mv=mV pressure_mV=mV force_mA=mA
    time_s=s t_s=s x_s= joint_s= time_ms=ms TIME_MS=ms frame_ms=ms time_Ms= time_us=us loop_us=us pressure_us=
    flow_us= uS= g_uS= g_mS= time_ns=ns p_Ns= angle_deg=deg angle_rad=rad theta_rad=rad force_rad=
    pressure_psi=psi p_psi=psi angle_psi= yaw_psi= euler_psi= winkel_grad=deg pressure_grad= displacement_mm=mm
    x_mm=mm X_MM=mm x_Mm= x_um=um x_uM= x_mM= volume_ml=ml flow_lpm= valve_A= i_A=A speed_rpm=
"""

SLASHES = """
    p/bar=bar s/m=m U/V=V I/A=A F/N=N F/kN=kN t/s=s t/ms=ms phi/rad=rad M/Nm=Nm x/mm=mm pos/in= x/in= valve/in=
    valve/a= in/out= pressure/min= p/mPa=mPa p/MPa=MPa left/n=
"""

BRACKETED = [(q, *pair) for q, text in SPELLINGS.items() for pair in pairs(text)]


@pytest.mark.parametrize("form", ["{} [{}]", "{}[{}]", "{} ({})", "{}_[{}]"])
def test_spellings_in_brackets_are_the_units_that_they_are(form: str) -> None:
    assert len(BRACKETED) >= 150
    read = {(q, unit): parse_unit(form.format(q, unit)) for q, unit, _ in BRACKETED}
    assert read == {(q, unit): (q, truth) for q, unit, truth in BRACKETED}


def test_endings_of_names_are_units_only_where_they_are() -> None:
    cases = dict(pairs(SUFFIXES))
    assert len(cases) >= 120
    assert {name: parse_unit(name)[1] for name in cases} == cases


def test_a_slash_before_a_unit_is_a_label_of_a_standard() -> None:
    cases = dict(pairs(SLASHES))
    assert {name: parse_unit(name)[1] for name in cases} == cases


def test_no_case_of_a_unit_is_another_unit() -> None:
    """Units of one letter sequence differ by a power of ten: a spelling is the one that is written so, or none."""
    exact = {
        "mPa": "mPa",
        "MPa": "MPa",
        "mN": "mN",
        "MN": None,
        "mV": "mV",
        "MV": None,
        "mA": "mA",
        "MA": None,
    }
    exact |= {
        "ms": "ms",
        "Ms": None,
        "mm": "mm",
        "Mm": None,
        "Nm": "Nm",
        "nm": "nm",
        "NM": None,
        "uS": None,
        "us": "us",
    }
    assert {text: canonical(text) for text in exact} == exact


def units_of(*names: str) -> list[str]:
    columns = dict.fromkeys(names, np.zeros(3))
    table = LogTable("log", columns, {name: parse_unit(name)[1] for name in names}, np.arange(3))
    return [table.label(name)[1] for name in names]


@pytest.mark.parametrize(
    ("names", "units"),
    [
        (("time_s", "position_in", "position_out"), ["s", "", ""]),
        (("time_s", "stroke_in", "pressure_out"), ["s", "", ""]),
        (("time_s", "stroke_in", "force_N"), ["s", "in", "N"]),
        (("i_a", "i_b", "i_c"), ["", "", ""]),
        (("i_a", "u_v"), ["A", "V"]),
        (("F_N", "F_T"), ["", ""]),
        (("motor_V", "current_A"), ["V", "A"]),
        (("x_m", "x_d"), ["", ""]),
        (("x_m", "x_mm"), ["m", "mm"]),
        (("time_s", "time_h"), ["s", "h"]),
    ],
)
def test_another_column_may_show_that_an_ending_is_no_unit(
    names: tuple[str, ...], units: list[str]
) -> None:
    for order in itertools.permutations(range(len(names))):
        assert units_of(*(names[k] for k in order)) == [units[k] for k in order]


@pytest.mark.parametrize(
    ("name", "unit"),
    [
        ("H_Oe", "Oe"),
        ("coil_kOe", "kOe"),
        ("B_G", "G"),
        ("hall_field_mT", "mT"),
        ("volume_ml", "ml"),
        ("V_mL", "mL"),
        ("H [Oe]", "Oe"),
        # An acceleration, a centre of gravity, a mass, and a prediction.
        ("acc_G", ""),
        ("x_G", ""),
        ("load_g", ""),
        ("b_g", ""),
        ("force_ml", ""),
        ("enable_OE", ""),
    ],
)
def test_gauss_oersted_and_millilitre_are_known_where_nothing_else_is_meant(
    name: str, unit: str
) -> None:
    assert parse_unit(name)[1] == unit


def test_a_loop_of_gauss_over_oersted_is_a_loss() -> None:
    """1 G times 1 Oe is 1 erg / (4 pi cm3), 0.1 / (4 pi) J/m3."""
    factor, unit = work_unit("Oe", "G")
    assert unit == "J/m3" and factor == pytest.approx(0.1 / (4.0 * np.pi))
    assert work_unit("bar", "ml") == (pytest.approx(0.1), "J")
