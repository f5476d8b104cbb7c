"""Logs as oscilloscopes, test machines, historians, controllers and forums write them, each with its truth."""

from __future__ import annotations

import datetime as dt
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest

import dehyst
from dehyst.io import parse_date_times
from dehyst.io._cells import is_date_time
from dehyst.units import parse_unit

ROWS = 300
COUNT = np.arange(ROWS)
DRIVE = np.round(4.0 * (1.0 - 0.4 * COUNT / ROWS) * np.sin(8.0 * np.pi * COUNT / ROWS), 4)
FOLLOW = DRIVE.copy()
for k in range(1, ROWS):
    FOLLOW[k] = np.round(min(max(FOLLOW[k - 1], DRIVE[k] - 0.8), DRIVE[k] + 0.8), 4)
BEGIN = dt.datetime(2024, 3, 5, 10, 11, 12)

Row = Callable[[int, float, float, float], str]


@dataclass(frozen=True)
class Log:
    """A text log and its truth."""

    file: str
    head: str
    row: Row
    step: float | None  # [s], None where the log tells no time
    input: str
    output: str
    units: tuple[str, str] = ("", "")
    foot: str = ""
    says: tuple[str, ...] = ()  # findings that it may raise
    clocked: float = 0.0  # step of the rows that are written, where the log itself tells none [s]
    times: float = 1.0  # of the output
    missing: int = 0  # rows without a number

    def text(self) -> str:
        step = self.step or self.clocked or 1.0
        values = zip(COUNT.tolist(), DRIVE.tolist(), (self.times * FOLLOW).tolist(), strict=True)
        return self.head + "".join(self.row(k, k * step, x, y) for k, x, y in values) + self.foot


def at(second: float, form: str) -> str:
    return (BEGIN + dt.timedelta(seconds=second)).strftime(form)


def joined(mark: str, *, comma: bool = False, digits: int = 6) -> Row:
    def row(_: int, t: float, x: float, y: float) -> str:
        line = mark.join((f"{t:.{digits}f}", f"{x:.4f}", f"{y:.4f}"))
        return (line.replace(".", ",") if comma else line) + "\n"

    return row


def tight(k: int, t: float, x: float, y: float) -> str:
    return f"{t:.3f},{x:.4f},{y:.4f}\n"


SCOPE = "Model,MSO54\nLabel,CH1,CH2\nHorizontal Units,s,\nSample Interval,1e-05,1e-05\nVertical Units,V,V\n\n\n"
LABVIEW = (
    "LabVIEW Measurement\t\nWriter_Version\t2\nSeparator\tTab\nMulti_Headings\tNo\nX_Columns\t{0}\n"
    "Time_Pref\tRelative\nDate\t2024/03/05\nTime\t10:11:12.1\n***End_of_Header***\t\n\t\nChannels\t2\t\t\nSamples\t300\t300\t\n"
    "Date\t2024/03/05\t2024/03/05\t\nTime\t10:11:12.1\t10:11:12.1\t\nX_Dimension\tTime\tTime\t\nX0\t0.0\t0.0\t\n"
    "Delta_X\t0.002\t0.002\t\n***End_of_Header***\t\t\t\nX_Value\tVoltage_0\tPressure\tComment\n"
)
TWINCAT = (
    "Name\tScope\tName\tScope\nFile\tx.svdx\tFile\tx.svdx\nStartTime\t133541106721230000\tStartTime\t133541106721230000\n"
    "\nName\tMAIN.fSet\tName\tMAIN.fAct\nSymbolComment\t\tSymbolComment\t\nData-Type\tREAL64\tData-Type\tREAL64\n"
    "SampleTime[ms]\t1\tSampleTime[ms]\t1\nVariableSize\t8\tVariableSize\t8\nSymbolBased\tTrue\tSymbolBased\tTrue\n"
    "Unit\tV\tUnit\tmm\n"
)
YOKOGAWA = (
    '"Model Name","DL850"\n"Trace Name","CH1       ","CH2       "\n"Block Size",300,300\n"VUnit","V","V"\n'
    '"SampleRate",10000.00,10000.00\n"HOffset",0,0\n"HUnit","s","s"\n"Date","2024/03/05","2024/03/05"\n'
    '"Time","10:11:12.00","10:11:12.00"\n\n\n'
)
CAMPBELL = (
    '"TOA5","CR1000","CR1000","1234","CR1000.Std.31","CPU:x.CR1","5678","Table1"\n'
    '"TIMESTAMP","RECORD","Suction_Avg","VWC_Avg"\n"TS","RN","kPa","m^3/m^3"\n"","","Avg","Avg"\n'
)
GAMRY = "EXPLAIN\nTAG\tCV\nCURVE1\tTABLE\t300\n\tPt\tT\tVf\tIm\tVu\tAch\tIERange\n\t#\ts\tV\tA\tV\tV\t#\n"
CATMAN = (
    "HBM_CATMANDATAFILE\t5.4\nCHANNELS\t3\n\nZeit 1 - Standardmessrate\tWeg_1\tKraft_1\ns\tmm\tN\nMX840\tMX840\tMX840\n"
    "50 Hz\t50 Hz\t50 Hz\n"
)
EXPERION = "Point,PIC200,PIC200\nParameter,OP,PV\nDescription,Pressure control,Pressure control\nUnits,%,BARG\n"
PI_RECORDER = (
    "# REM E-727 data recorder\n#\n# SAMPLE_TIME = 5e-05\n# NAME0 = Voltage\n#\n# END_HEADER\n"
)


def narrow(value: float) -> str:
    """A number as French spreadsheets write it."""
    return f"{value:,.2f}".replace(",", "\u202f").replace(".", ",")


# Each of these was read wrongly, without its time or its names, or refused.
MENDED = {
    "labview": Log("l.lvm", LABVIEW.format("One"), joined("\t"), 0.002, "Voltage_0", "Pressure"),
    "dewesoft": Log(
        "d.txt", "Data file: x.dxd\nSample rate: 200 Hz\n\nTime (s)\tPressure (bar)\tAngle (deg)\n", joined("\t"),
        0.005, "Pressure (bar)", "Angle (deg)", ("bar", "deg"),
    ),
    "rigol": Log(
        "r.csv", "X,CH1,CH2,Start,Increment,\nSequence,Volt,Volt,-6.0e-02,2.0e-04\n",
        lambda k, t, x, y: f"{k},{x:.4f},{y:.4f},\n", None, "CH1", "CH2", ("V", "V"),
    ),
    "rohde": Log("r.csv", "in s,CH1 in V,CH2 in V\n", joined(","), 1e-4, "CH1 in V", "CH2 in V", ("V", "V")),
    "yokogawa": Log("y.csv", YOKOGAWA, lambda k, t, x, y: f",{x:.4f},{y:.4f}\n", None, "column_2", "column_3"),
    "labview without time": Log(
        "l.lvm", LABVIEW.format("No"), lambda k, t, x, y: f"\t{x:.4f}\t{y:.4f}\n", None, "Voltage_0", "Pressure",
    ),
    "catman": Log("c.asc", CATMAN, joined("\t", comma=True), 0.02, "Weg_1", "Kraft_1", ("mm", "N")),
    "campbell": Log(
        "c.dat", CAMPBELL, lambda k, t, x, y: f'"{at(t, "%Y-%m-%d %H:%M:%S")}",{k},{x:.4f},{y:.4f}\n', 60.0,
        "Suction_Avg", "VWC_Avg", ("kPa", "m^3/m^3"),
    ),
    "origin": Log(
        "o.dat", "Time\tVoltage\tDisplacement\ns\tV\tμm\n\tset\tmeasured\n", joined("\t"), 0.01, "Voltage",
        "Displacement", ("V", "um"),
    ),
    "gamry": Log(
        "g.dta", GAMRY, lambda k, t, x, y: f"\t{k}\t{t:.3f}\t{x:.4f}\t{y:.4f}\t0\t0\t8\n", 0.1, "Vf", "Im", ("V", "A"),
    ),
    "experion": Log(
        "e.csv", EXPERION, lambda k, t, x, y: f"{at(t, '%m/%d/%Y %I:%M:%S %p')},{x:.4f},{y:.4f}\n", 5.0,
        "OP Pressure control", "PV Pressure control", ("%", "bar"),
    ),
    "historian": Log(
        "p.csv", "Timestamp,FIC101.OP,FI101.PV\n",
        lambda k, t, x, y: f"{at(t, '%d-%b-%y %H:%M:%S')},{x:.4f},{y:.4f}\n", 60.0, "FIC101.OP", "FI101.PV",
    ),
    "historian, bad values": Log(
        "p.csv", "Timestamp;FIC101.OP (%);FI101.PV (m3/h)\n",
        lambda k, t, x, y: (
            f"{at(t, '%d-%b-%Y %H:%M:%S')};{x:.4f};{'Bad Input' if k in {50, 51, 200} else f'{y:.4f}'}\n"
        ),
        60.0, "FIC101.OP (%)", "FI101.PV (m3/h)", ("%", "m3/h"), says=("non-finite",), missing=3,
    ),
    "month first": Log(
        "m.csv", "When;Pressure [bar];Angle [deg]\n",
        lambda k, t, x, y: f"{at(t, '%b %d, %Y %I:%M:%S %p')};{x:.4f};{y:.4f}\n", 1.0, "Pressure [bar]",
        "Angle [deg]", ("bar", "deg"),
    ),
    "minutes and seconds": Log(
        "e.csv", "Time,Pressure (psi),Angle (deg)\n",
        lambda k, t, x, y: f"{int(t // 60):02d}:{t % 60:04.1f},{x:.4f},{y:.4f}\n", 0.5, "Pressure (psi)",
        "Angle (deg)", ("psi", "deg"),
    ),
    "timedelta": Log(
        "p.csv", ",u_V,d_um\n",
        lambda k, t, x, y: (
            f"{t // 86400:.0f} days {int(t // 3600) % 24:02d}:{int(t // 60) % 60:02d}:{t % 60:09.6f},{x},{y}\n"
        ),
        400.0, "u_V", "d_um", ("V", "um"),
    ),
    "circuit": Log("l.txt", "time\tV(in)\tI(L1)\n", joined("\t", digits=9), 1e-5, "V(in)", "I(L1)"),
    "circuit in steps": Log(
        "l.txt", "time\tV(in)\tI(L1)\nStep Information: R=1K  (Step: 1/1)\n", joined("\t", digits=9), 1e-5, "V(in)",
        "I(L1)",
    ),
    "twincat": Log(
        "b.csv", TWINCAT, lambda k, t, x, y: f"{k}\t{x:.4f}\t{k}\t{y:.4f}\n", None, "MAIN.fSet", "MAIN.fAct",
        ("V", "mm"), says=("duplicate-columns",),
    ),
    "french thousands": Log(
        "f.csv", "Temps (s);Tension (V);Force (N)\n",
        lambda k, t, x, y: f"{t:.2f};{x:.4f};".replace(".", ",") + narrow(y) + "\n", 0.01, "Tension (V)", "Force (N)",
        ("V", "N"), times=1000.0,
    ),
    "units in cells": Log(
        "g.csv", '"Time","valve","flow"\n',
        lambda k, t, x, y: f'"{at(t, "%Y-%m-%d %H:%M:%S")}",{x:.4f} %,{y:.4f} L/min\n', 10.0, "valve", "flow",
        ("%", "L/min"), says=("unit-in-cells",),
    ),
    "serial monitor": Log(
        "a.txt", "10:11:11.900 -> set,pos\n",
        lambda k, t, x, y: f"{at(t, '%H:%M:%S.')}{round(t * 1000) % 1000:03d} -> {x:.4f},{y:.4f}\n", 0.02, "set",
        "pos",
    ),
    "names are units": Log("u.csv", "s,bar,deg\n", tight, 0.01, "bar", "deg", ("bar", "deg")),
    "one number a stamp": Log(
        "n.csv", "Time;U [V];s [mm]\n", lambda k, t, x, y: f"{at(t, '%Y%m%d%H%M%S')};{x:.4f};{y:.4f}\n", 1.0, "U [V]",
        "s [mm]", ("V", "mm"),
    ),
    "header again": Log(
        "h.csv", "Time (s),Disp (mm),Force (N)\n",
        lambda k, t, x, y: ("Time (s),Disp (mm),Force (N)\n" if k == 200 else "") + tight(k, t, x, y), 0.01,
        "Disp (mm)", "Force (N)", ("mm", "N"),
    ),
    "another table below": Log(
        "a.csv", "Time (s),Disp (mm),Force (N)\n", tight, 0.01, "Disp (mm)", "Force (N)", ("mm", "N"),
        foot="\nTime (s),Temp (C),Hum (%)\n" + "".join(f"{k / 100},{20 + k % 3},{40 + k % 7}\n" for k in COUNT),
        says=("second-table",),
    ),
    "columns in another order": Log(
        "a.csv", "Time (s),Disp (mm),Force (N)\n", tight, 0.01, "Disp (mm)", "Force (N)", ("mm", "N"),
        foot="Time (s),Force (N),Disp (mm)\n" + "".join(f"{3 + k / 100},{k % 3},{k % 7}\n" for k in COUNT),
        says=("second-table",),
    ),
    "overload of a meter": Log(
        "o.csv", "Time (s),Disp (mm),Force (N)\n",
        lambda k, t, x, y: f"{t:.3f},{x:.4f},{'9.9E+37' if k % 20 == 7 else f'{y:.4f}'}\n", 0.01, "Disp (mm)",
        "Force (N)", ("mm", "N"), says=("non-finite",), missing=15,
    ),
    "piezo recorder": Log(
        "p.txt", PI_RECORDER, lambda k, t, x, y: f"{x:.4e}\t{y:.4e}\n", None, "column_1", "column_2",
    ),
}  # fmt: skip
# And these were right.
RIGHT = {
    "source meter": Log(
        "k.csv", "Index,Reading,Unit,Source Value,Date,Time,Fractional Seconds\n",
        lambda k, t, x, y: f"{k + 1},{y:.4f},Amp DC,{x:.4f},03/05/2024,{at(t, '%H:%M:%S')},{t % 1:.6f}\n", 0.25,
        "Source Value", "Reading", says=("coarse-time", "date-order"),
    ),
    "tektronix": Log("t.csv", SCOPE + "TIME,CH1,CH2\n", joined(",", digits=9), 1e-5, "CH1", "CH2"),
    "rigol with time": Log("r.csv", "Time(s),CH1(V),CH2(V)\n", joined(","), 2e-4, "CH1(V)", "CH2(V)", ("V", "V")),
    "keysight": Log(
        "k.csv", "x-axis,1,2\nsecond,Volt,Volt\n", joined(",", digits=9), 2e-6, "1", "2", ("V", "V"),
    ),
    "lecroy": Log(
        "l.csv", "Time,C1,Time,C2\n", lambda k, t, x, y: f"{t:.9f},{x:.4f},{t:.9f},{y:.4f}\n", 2e-6, "C1", "C2",
        says=("duplicate-columns",),
    ),
    "codesys": Log(
        "c.csv", "Time(us);rSet;Time(us);rAct\n",
        lambda k, t, x, y: f"{1e6 * t:.0f};{x:.4f};{1e6 * t:.0f};{y:.4f}\n", 0.002, "rSet", "rAct",
        says=("duplicate-columns",),
    ),
    "picoscope": Log(
        "p.csv", "Zeit;Kanal A;Kanal B\n(ms);(V);(mV)\n\n",
        lambda k, t, x, y: f"{1e3 * t:.4f};{x:.4f};{y:.4f}\n".replace(".", ","), 5e-5, "Kanal A", "Kanal B",
        ("V", "mV"),
    ),
    "siglent": Log(
        "s.csv", "Record Length,Analog:600,\nVertical Units,CH1:V CH2:V,\nSource,CH1,CH2\nSecond,Volt,Volt\n",
        joined(",", digits=9), 1e-5, "CH1", "CH2", ("V", "V"),
    ),
    "instron": Log(
        "i.csv", '"Rate 1","5.0","mm/min"\n\nTime,Extension,Load\n(s),(mm),(kN)\n',
        lambda k, t, x, y: f'"{t:.3f}","{x:.4f}","{y:.4f}"\n', 0.1, "Extension", "Load", ("mm", "kN"),
    ),
    "zwick": Log(
        "z.tra", "Probe 1;;;\nPrüfzeit;Standardweg;Standardkraft;\ns;mm;N;\n",
        lambda k, t, x, y: f"{t:.3f};{x:.4f};{y:.4f};\n".replace(".", ","), 0.1, "Standardweg", "Standardkraft",
        ("mm", "N"),
    ),
    "mts": Log(
        "m.dat", "Station Name:\tax.cfg\nAxial Displacement\tAxial Force\tTime\t\nmm\tkN\tSec\t\n",
        lambda k, t, x, y: f"{x:.4f}\t{y:.4f}\t{t:.4f}\t\n", 0.01, "Axial Displacement", "Axial Force", ("mm", "kN"),
    ),
    "siemens": Log(
        "s.csv", "Sample;Time [us];Torque;Position\n", lambda k, t, x, y: f"{k};{1e6 * t:.0f};{x:.4f};{y:.4f}\n",
        0.004, "Torque", "Position",
    ),
    "excel with two columns": Log(
        "e.csv", "Date,Time,Pressure (psi),Angle (deg)\n",
        lambda k, t, x, y: f"{at(t, '%m/%d/%Y')},{at(t, '%I:%M:%S %p')},{x:.4f},{y:.4f}\n", 300.0, "Pressure (psi)",
        "Angle (deg)", ("psi", "deg"), says=("date-order",),
    ),
    "R": Log(
        "r.csv", '"";"time";"force";"disp"\n',
        lambda k, t, x, y: f'"{k + 1}";{t:.3f};{y:.4f};{x:.4f}\n'.replace(".", ","), 0.01, "disp", "force",
    ),
    "pandas": Log(
        "p.csv", ",time_s,u_V,d_um\n", lambda k, t, x, y: f"{k},{t},{x},{y}\n", 0.01, "u_V", "d_um", ("V", "um"),
    ),
    "matlab": Log("m.txt", "", lambda k, t, x, y: f"  {t: .7e}  {x: .7e}  {y: .7e}\n", 0.01, "column_2", "column_3"),
    "comsol": Log(
        "c.txt", "% Model: x.mph\n% Date: Mar 5 2024, 10:11\n% Time (s)     Voltage (V)     Displacement (um)\n",
        lambda k, t, x, y: f"{t:<20.6f}{x:<20.4f}{y:.4f}\n", 0.01, "Voltage_(V)", "Displacement_(um)", ("V", "um"),
    ),
    "footer": Log(
        "f.csv", "Time (s),Disp (mm),Force (N)\n", tight, 0.01, "Disp (mm)", "Force (N)", ("mm", "N"),
        foot="\nMax,4.0,3.2\nMin,-4.0,-3.2\n", says=("non-finite",),
    ),
    "arduino": Log(
        "a.txt", "millis,pwm,pot\n", lambda k, t, x, y: f"{5000 + 1000 * t:.0f},{x:.4f},{y:.4f}\n", 0.02, "pwm", "pot",
    ),
    "force gauge": Log(
        "m.csv", "Mark-10 M5-50\nUnits: N\n\nReading,Load [N],Travel [mm],Time [sec.]\n",
        lambda k, t, x, y: f"{k + 1},{y:.4f},{x:.4f},{t:.3f}\n", 0.01, "Travel [mm]", "Load [N]", ("mm", "N"),
    ),
    "biologic": Log(
        "b.mpt", "EC-Lab ASCII FILE\nNb header lines : 4\n\nmode\ttime/s\tcontrol/V\t<I>/mA\n",
        lambda k, t, x, y: f"2\t{t:.6E}\t{x:.6E}\t{y:.6E}\n", 0.1, "control/V", "<I>/mA", ("V", "mA"),
    ),
    "ferrite": Log(
        "b.txt", "Material: N87\nf = 10 kHz  T = 25 C\n\nH [A/m]\tB [mT]\n", lambda k, t, x, y: f"{x:.4f}\t{y:.4f}\n",
        None, "H [A/m]", "B [mT]", ("A/m", "mT"),
    ),
    "state in a column": Log(
        "d.csv", "t;state;U [V];s [nm]\n",
        lambda k, t, x, y: f"{t:.3f};{'up' if k % 74 < 37 else 'down'};{x:.4f};{y:.4f}\n", 0.01, "U [V]", "s [nm]",
        ("V", "nm"),
    ),
}  # fmt: skip


def check(log: Log, folder) -> None:
    path = folder / log.file
    path.write_text(log.text(), encoding="utf-8")
    summary = dehyst.inspect_log(path)
    assert {finding.code for finding in summary.findings} <= {"no-time", *log.says}
    assert {summary.input, summary.output} == {log.input, log.output}
    units = {column.name: column.unit for column in summary.columns}
    assert (units[log.input], units[log.output]) == log.units
    assert (summary.sampling is None) == (log.step is None)
    run = next(iter(summary.runs), None)
    record = dehyst.read_log(path, log.input, log.output, run=run)
    assert record.input.size == ROWS - log.missing
    if not log.missing:
        assert np.allclose(record.input, DRIVE, atol=1e-9)
        assert np.allclose(record.output, log.times * FOLLOW, atol=6e-3 * log.times)
    if log.step is not None:
        assert abs(record.time[-1] - record.time[0] - (ROWS - 1) * log.step) <= 4.0 * log.step


@pytest.mark.parametrize("name", MENDED)
def test_a_log_that_was_misread_gives_its_columns_units_and_time(name, tmp_path):
    check(MENDED[name], tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("name", RIGHT)
def test_a_log_of_an_instrument_gives_its_columns_units_and_time_without_an_alarm(name, tmp_path):
    check(RIGHT[name], tmp_path)


@pytest.mark.parametrize(
    ("cell", "seconds"),
    [
        ("05-Mar-24 10:00:00", 1709632800.0),
        ("5 March 2024 10:00", 1709632800.0),
        ("05.Mrz.2024 10:00:00", 1709632800.0),
        ("05-MAR-2024 10:00:00.5", 1709632800.5),
        ("Mar 5, 2024 10:00:00 AM", 1709632800.0),
        ("02:05.5", 125.5),
        ("1 days 00:00:01.500000", 86401.5),
        ("1 day, 0:00:01", 86401.0),
        ("-1 days +23:59:59", -1.0),
        ("2024-03-05 10:00:00:250", 1709632800.25),
        ("05.03.2024 10:00:00:250", 1709632800.25),
        ("25/03/2024 10:00:00 p. m.", 1711404000.0),
    ],
)
def test_stamps_with_named_months_and_durations_are_read(cell, seconds):
    assert is_date_time(cell)
    assert parse_date_times([cell]).tolist() == [seconds]


@pytest.mark.parametrize(
    "cell", ["05-Foo-24 10:00:00", "May", "12:75.5", "3 days", "Mar 5", "1.5", "A 5, 2024 10:00"]
)
def test_what_only_resembles_a_stamp_is_none(cell):
    assert not is_date_time(cell)


def test_names_of_a_circuit_carry_no_unit_and_units_in_brackets_stay():
    names = ("V(in)", "I(R1)", "V(out)", "V(mV)", "I(mA)", "V (in)", "x(in)")
    assert [parse_unit(name)[1] for name in names] == ["", "", "", "mV", "mA", "in", "in"]


def test_a_count_of_the_rows_is_proposed_for_nothing(tmp_path):
    rows = "".join(
        f"{k + 1},2024/03/05,10:{k // 60:02d}:{k % 60:02d},{y:.4f},V\n"
        for k, y in enumerate(FOLLOW)
    )
    (tmp_path / "m.csv").write_text("No,Date,Time,Value,Unit\n" + rows)
    summary = dehyst.inspect_log(tmp_path / "m.csv")
    assert (summary.input, summary.output) == (None, None)


def test_signals_below_one_another_in_one_column_are_said(tmp_path):
    rows = "".join(
        f"valve;{at(k, '%d.%m.%Y %H:%M:%S')};{x:.4f}\nflow;{at(k, '%d.%m.%Y %H:%M:%S')};{y:.4f}\n"
        for k, (x, y) in enumerate(zip(DRIVE, FOLLOW, strict=True))
    )
    (tmp_path / "w.csv").write_text("VarName;TimeString;VarValue\n" + rows)
    summary = dehyst.inspect_log(tmp_path / "w.csv")
    said = [finding.message for finding in summary.findings if finding.code == "long-table"]
    assert len(said) == 1
    assert "valve, flow" in said[0]


def test_stamps_that_are_not_understood_are_named_where_time_is_missed(tmp_path):
    rows = "".join(f"Tue 5th {k};{DRIVE[k]};{FOLLOW[k]}\n" for k in COUNT)
    (tmp_path / "t.csv").write_text("Time;U [V];s [mm]\n" + rows)
    record = dehyst.read_log(tmp_path / "t.csv", "U [V]", "s [mm]")
    (said,) = [finding.message for finding in record.findings if finding.code == "no-time"]
    assert "'Tue 5th 0', are not understood" in said


def test_the_number_of_the_run_is_no_condition_of_it(tmp_path):
    rows = "".join(f"{run},{k / 100},{DRIVE[k]},{FOLLOW[k]}\n" for run in (1, 2) for k in COUNT)
    (tmp_path / "r.csv").write_text("run,time_s,u_V,d_um\n" + rows)
    record = dehyst.read_log(tmp_path / "r.csv", "u_V", "d_um", run="2")
    assert "run" not in record.provenance.get("stills", {})
