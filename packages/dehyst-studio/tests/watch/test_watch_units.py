"""A log that is watched is read as `drift` reads it, whatever its units, stamps and spellings; or both refuse it."""

import datetime
import math

import numpy as np
import pytest

import dehyst
from dehyst.errors import DehystError, UnitError
from dehyst.models import ModelCard, SignalCard
from dehyst_studio.live import Names, follow_live
from dehyst_studio.mqtt import Messages
from dehyst_studio.opcua import Changes, change_of
from dehyst_studio.watch import Watch

CARD = ModelCard(SignalCard("pressure", "bar", -1.0, 1.0), SignalCard("angle", "deg", -2.0, 2.0))
MODEL = dehyst.PrandtlIshlinskii([0.0, 0.3, 0.6], [1.0, 0.5, 0.4]).with_card(CARD)
T = 0.04 * np.arange(1200)
X = np.sin(2 * np.pi * 0.5 * T) * (1 - 0.15 * np.abs(np.sin(0.31 * T)))
NOISE = 1e-3 * np.random.default_rng(0).standard_normal(T.size)
ANGLES = {"as it was": MODEL.simulate(X) + NOISE, "worn": 1.1 * MODEL.simulate(X) + NOISE}
BEGIN = datetime.datetime(2024, 3, 5, 12, 0, 0, tzinfo=datetime.UTC)


def dates(form):
    return [(BEGIN + datetime.timedelta(seconds=float(t))).strftime(form) for t in T]


TIMES = {  # header -> cells
    "time_s": T, "time": T, "time_ms": 1e3 * T, "t/ms": 1e3 * T, "time [us]": 1e6 * T, "time (min)": T / 60,
    "Zeit [h]": T / 3600, "elapsed_ns": 1e9 * T, "Time [msec]": 1e3 * T, "timestamp": BEGIN.timestamp() + T,
    "epoch_ms": 1e3 * (BEGIN.timestamp() + T), "stamp": np.round(1e3 * (BEGIN.timestamp() + T)),
    "time [days]": T / 86400, "time [ticks]": T * 50, "time [0.1s]": T * 10, "column": T,
    "date": dates("%Y-%m-%d %H:%M:%S.%f"), "when": dates("%Y-%m-%dT%H:%M:%S.%fZ"),
    "Datum": dates("%d.%m.%Y %H:%M:%S.%f"), "clock": dates("%H:%M:%S.%f"), "us_date": dates("%m/%d/%Y %H:%M:%S.%f"),
    "coarse": dates("%Y-%m-%d %H:%M:%S"),
}  # fmt: skip
PRESSURES = {
    "pressure_bar": 1.0, "pressure [kPa]": 100.0, "pressure_MPa": 0.1, "pressure (Pa)": 1e5, "Pressure/psi": 14.5037738,
    "pressure_mbar": 1e3, "pressure [hPa]": 1e3, "PRESSURE": 1.0, "pressure [V]": 1.0, "pressure [furlong]": 1.0,
    "pressures_bar": 1.0,
}  # fmt: skip
TURNS = {
    "angle_deg": 1.0, "angle_rad": math.pi / 180, "angle [mrad]": 1e3 * math.pi / 180, "angle [°]": 1.0,
    "Angle (degrees)": 1.0, "angle": 1.0, "angle_mm": 1.0,
}  # fmt: skip


def written(path, time, pressure, turn, angle, delimiter=",", decimal="."):
    cells = TIMES[time] if isinstance(TIMES[time], list) else [repr(float(t)) for t in TIMES[time]]
    rows = [[time, pressure, turn]]
    for stamp, x, y in zip(cells, X * PRESSURES[pressure], angle * TURNS[turn], strict=True):
        rows.append([stamp, repr(float(x)), repr(float(y))])
    lines = [
        delimiter.join(cell.replace(".", decimal) if k else cell for cell in row)
        for k, row in enumerate(rows)
    ]
    path.write_text("\n".join(lines) + "\n")
    return path


def watched(path, time_unit=None):
    """Last report over a log, or the error that refused it."""
    watch, names, reports = (
        Watch(MODEL, every=18),
        Names("pressure", "angle", None, time_unit, (CARD.input, CARD.output)),
        [],
    )
    try:
        for arrival in follow_live(path, names):
            if isinstance(arrival, tuple):
                reports += watch.feed(*arrival)
            elif arrival is None:
                return reports[-1] if reports else "no report"
    except DehystError as refusal:
        return type(refusal)


def drifted(path, time_unit=None):
    try:
        found = dehyst.drift(
            MODEL,
            dehyst.read_log(path, "pressure", "angle", time_unit=time_unit),
            false_alarm=0.001,
        )
    except DehystError as refusal:
        return type(refusal)
    return found


def agree(path, time_unit=None):
    ours, theirs = watched(path, time_unit), drifted(path, time_unit)
    if isinstance(theirs, type):
        return ours == theirs
    if theirs.status == "not comparable" and isinstance(ours, type):
        return (
            ours is UnitError
        )  # what drift finds out of one log among several, is refused here before it runs
    if isinstance(ours, type) or ours.status != theirs.status:
        return False
    log = theirs.logs[0]
    gain = theirs.change("gain").estimate
    return (
        abs(ours.changes["gain"][0] - gain) < 0.3
        and abs(ours.error_percent - log.error_percent) < 0.1
    )


@pytest.mark.parametrize(
    ("time", "pressure", "turn"),
    [
        ("time_ms", "pressure_bar", "angle_deg"),
        ("time_s", "pressure [kPa]", "angle_rad"),
        ("when", "Pressure/psi", "angle [mrad]"),
        ("Datum", "pressure_bar", "Angle (degrees)"),
        ("epoch_ms", "PRESSURE", "angle"),
        ("time [ticks]", "pressure_bar", "angle_deg"),
        ("time", "pressure [V]", "angle_deg"),
        ("time", "pressures_bar", "angle_mm"),
    ],
)
def test_watch_and_drift_agree(tmp_path, time, pressure, turn):
    assert agree(written(tmp_path / "log.csv", time, pressure, turn, ANGLES["as it was"]))


@pytest.mark.slow
def test_watch_and_drift_agree_about_every_unit_of_the_signals(tmp_path):
    path, wrong = tmp_path / "log.csv", []
    for pressure in PRESSURES:
        for turn in TURNS:
            written(path, "time_ms", pressure, turn, ANGLES["worn"])
            if not agree(path):
                wrong.append((pressure, turn, watched(path), drifted(path)))
    assert not wrong


@pytest.mark.exhaustive
def test_watch_and_drift_agree_about_every_spelling_of_a_worn_actuator_in_every_dialect(tmp_path):
    path, wrong, count = tmp_path / "log.csv", [], 0
    for time in TIMES:
        for pressure, turn in (("pressure_bar", "angle_deg"), ("pressure [kPa]", "angle_rad")):
            for delimiter, decimal in ((",", "."), (";", ","), ("\t", ".")):
                for name, angle in ANGLES.items():
                    written(path, time, pressure, turn, angle, delimiter, decimal)
                    count += 1
                    if not agree(path):
                        wrong.append(
                            (time, pressure, turn, delimiter, name, watched(path), drifted(path))
                        )
    assert count >= 250 and not wrong


def test_a_unit_of_time_that_no_name_tells_is_named(tmp_path):
    path = written(tmp_path / "log.csv", "time_ms", "pressure_bar", "angle_deg", ANGLES["worn"])
    path.write_text(path.read_text().replace("time_ms", "time", 1))
    assert agree(path, "ms") and abs(watched(path, "ms").time - T[-1]) < 0.1


def test_messages_are_read_in_the_units_of_their_keys():
    cards = CARD.input, CARD.output
    for payload, row in (
        (
            '{"time_ms": 1500, "pressure [kPa]": 50, "angle_rad": 0.5}',
            (1.5, 0.5, math.degrees(0.5)),
        ),
        ('{"Time": 1.5, "PRESSURE": 0.5, "Angle [deg]": 3}', (1.5, 0.5, 3)),
        ('{"timestamp": 1709640000123, "pressure": 0.5, "angle": 3}', (1709640000.123, 0.5, 3)),
        (
            '{"ts_us": 2500000, "pressure_Pa": 50000, "angle_mrad": 1000}',
            (2.5, 0.5, math.degrees(1)),
        ),
        (
            '{"stamp": "2024-03-05T12:00:00.5Z", "pressure": 0.5, "angle": 3}',
            (BEGIN.timestamp() + 0.5, 0.5, 3),
        ),
        ('{"pressure": 0.5, "angle": 3}', (7.0, 0.5, 3)),
    ):
        batch, skipped, _ = Messages(Names("pressure", "angle", cards=cards)).read(
            payload.encode(), 7.0
        )
        assert not skipped and np.allclose([float(values[0]) for values in batch], row, rtol=1e-12)
    units = Messages(Names("pressure", "angle", time_unit="ms", cards=cards))
    assert units.read(b'{"time": 1500, "pressure": 0.5, "angle": 3}', 7.0)[0][0].tolist() == [1.5]
    other = Messages(Names("pressure", "angle", cards=cards))
    batch, skipped, why = other.read(b'{"pressure_V": 0.5, "angle": 3}', 7.0)
    assert not batch[0].size and len(skipped) == 1 and "cannot convert V" in why
    batch, skipped, why = other.read(
        b'{"time": "03/04/2024 12:00:00", "pressure": 0.5, "angle": 3}', 7.0
    )
    assert not batch[0].size and len(skipped) == 1  # March or April


def test_what_is_converted_is_said_once():
    messages = Messages(Names("pressure", "angle", cards=(CARD.input, CARD.output)))
    for _ in range(3):
        messages.read(b'{"pressure_kPa": 50, "angle_deg": 3}', 7.0)
    assert messages.notes == [
        "column 'pressure_kPa' of the messages was converted from kPa to bar."
    ]


def test_changes_of_a_server_count_at_the_stamp_of_their_source_and_only_if_they_are_good():
    one, two = (datetime.datetime(2024, 3, 5, 12, 0, k, tzinfo=datetime.UTC) for k in (1, 2))
    pairing = Changes(Names("ns=2;s=p", "ns=2;s=a"))
    arrived = [
        change_of(1, 4.0, two, one, True),
        change_of(0, 1.5, one, two, True),
        change_of(1, "high", one, one, True),
        change_of(1, 5.0, one, one, False),
        change_of(1, math.nan, None, one, True),
    ]
    (times, x, y), skipped = pairing.read(arrived)
    assert (times.tolist(), x.tolist(), y.tolist()) == ([two.timestamp()], [1.5], [4.0])
    assert skipped == ["ns=2;s=a = 'high'", "ns=2;s=a = 5.0 of bad quality", "ns=2;s=a = nan"]
