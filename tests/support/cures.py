"""The table of cures: a small log or call that raises a finding, and what its text names to type against it."""

import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

import dehyst
from backlash_machines import Axis, Plain, measure
from dehyst.families._elements import ElementModel
from dehyst.io import example_recording, write_csv
from dehyst.models import ModelCard, SignalCard
from dehyst_robot.muscles import muscle
from direct_samples import TIPS, asked, log, motion
from identification_oracles import loops
from places import ROOT
from simulated_loops import servo_log, valve_loop
from swings import second_order
from test_identification_findings import FIRING, PI, noise

sys.path.insert(0, str(ROOT / "benchmarks"))

from drift_rig import cycling_log

STOPS = ((0.4, 0.5), (3.0, 0.3))
CARD = ModelCard(SignalCard("volt", "V", -1.0, 1.0), SignalCard("angle", "deg", -1.5, 1.5))
PAIR = "--input volt --output angle"


class Cure(NamedTuple):
    """How a finding is raised, and what is typed then."""

    write: Callable[[Path], None]  # What makes the files, in a folder
    line: str  # What raises the finding, without "dehyst"
    named: str  # Regular expression of what its text names
    typed: str = "{line} {named}"  # What is typed then: the line, and what was named
    after: str = (
        "gone"  # The finding; or it is "changed", its numbers others; or the line only "runs"
    )
    again: str = ""  # What is typed before the line is typed again, such as an identification from the new log
    taus: tuple[float, ...] = ()  # Creep of the rig that answers a motion which design planned


def log_of(record, path):
    """Write a recording as a log."""
    time = record.time
    if record.breaks:  # seconds in which nothing was logged
        time = (0.02 * np.arange(len(record)) if time is None else time) + 5.0 * np.searchsorted(
            record.breaks, np.arange(len(record)), side="right"
        )
    columns = {} if time is None else {"time_s": time}
    write_csv(path, {**columns, "volt": record.input, "angle": record.output})


def fired(code):
    """What writes the recording that raises a finding of identification."""

    def write(folder):
        made = FIRING[code][0]()
        records = made if isinstance(made, list) else [made]
        for number, record in enumerate(records):
            log_of(record, folder / ("log.csv" if not number else f"log{number + 1}.csv"))

    return write


def on_a_wing(folder):
    """The log of a butterfly, and outputs that one of its wings can give."""
    fired("butterfly-loop")(folder)
    rise = np.linspace(0.5, 0.9, 50)
    height = np.max(FIRING["butterfly-loop"][0]().output)
    write_csv(folder / "wanted.csv", {"time_s": 0.05 * np.arange(50), "angle": height * rise})


def wave(count=600, step=0.05, size=1.0):
    """Time and an input of shrinking loops."""
    time = step * np.arange(count)
    return time, size * np.sin(0.9 * time) * np.linspace(1.0, 0.5, count)


def moved(folder, taus):
    """What the rig answers to the motion that design wrote: a log of it."""
    time, command = np.loadtxt(
        folder / "motion.csv", delimiter=",", skiprows=1, usecols=(0, 1), unpack=True
    )
    write_csv(
        folder / "log.csv",
        {"time_s": time, "volt": command, "angle": creeping(command, time, taus)},
    )


def plain(folder, name="log.csv", **columns):
    """A log of plays; columns of other names in their place."""
    time, x = wave()
    write_csv(folder / name, columns or {"time_s": time, "volt": x, "angle": PI.simulate(x)})


def named_time(name, factor=1.0):
    """A log whose time column has another name and another unit."""

    def write(folder):
        time, x = wave()
        plain(folder, **{name: factor * time, "volt": x, "angle": PI.simulate(x)})

    return write


def without_time(folder):
    x = wave()[1]
    plain(folder, volt=x, angle=PI.simulate(x))


def day_numbers(folder):
    time, x = wave()
    plain(folder, time=45000.0 + time / 86400.0, volt=x, angle=PI.simulate(x))


def two_times(folder):
    time, x = wave()
    plain(folder, time_s=time, stamp_s=1.1 * time, volt=x, angle=PI.simulate(x))


def with_a_gap(folder):
    time, x = wave()
    part = (time < 10.0) | (time > 17.0)
    plain(folder, time_s=time[part], volt=x[part], angle=PI.simulate(x)[part])


def long_log(folder):
    """More rows than are read at once, and a file too large to be read whole: 72 MB."""
    time = 0.01 * np.arange(3_000_000)
    x = np.sin(0.9 * time) * (0.75 + 0.25 * np.cos(0.013 * time))
    np.savez(folder / "log.npz", time_s=time, volt=x, angle=PI.simulate(x))


def swapped(folder):
    time, x = wave()
    plain(folder, time_s=time, setpoint_V=x, measured_angle_deg=PI.simulate(x))


def two_sheets(folder):
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    time, x = wave()
    for sheet, gain in ((book.active, 1.0), (book.create_sheet("worn"), 0.8)):
        sheet.append(["time_s", "volt", "angle"])
        for row in np.column_stack([time, x, gain * PI.simulate(x)])[
            : -1 if gain < 1.0 else None
        ].tolist():
            sheet.append(row)
    book.save(folder / "log.xlsx")


def narrow_header(folder):
    time, x = wave()
    rows = np.column_stack([time, x, PI.simulate(x), x**2])
    np.savetxt(folder / "log.csv", rows, delimiter=",", header="volt,angle", comments="")


def saved(model, **tables):
    """What saves a model, and writes a table beside it."""

    def write(folder):
        model.save(folder / "m.json")
        for name, columns in tables.items():
            write_csv(folder / f"{name}.csv", columns)

    return write


def play_model(card=CARD, level=0.0, weights=(1.0, 0.5)):
    return dehyst.PrandtlIshlinskii(
        [0.1 * k for k in range(len(weights))], list(weights), level, card=card
    )


def identified(folder, family, step=0.02, **settings):
    """A model that was identified from loops, saved; and its log."""
    x = loops((1.0, 0.6, 0.9, 0.5, 0.8, 1.0, 0.7, 0.9), 60)
    time = step * np.arange(x.size)
    record = dehyst.Recording(
        input=x,
        output=PI.simulate(x) + noise(x.size, 1e-3),
        time=time,
        input_name="volt",
        output_name="angle",
    )
    log_of(record, folder / "log.csv")
    dehyst.identify(record, family, **settings).model.save(folder / "m.json")


def reference_with_a_gap(folder):
    time = np.r_[np.arange(100), np.arange(400, 500)] / 20.0
    saved(play_model(), ref={"time_s": time, "angle [deg]": np.sin(time)})(folder)


def small_excerpt(folder):
    time, x = wave()
    part = time < 5.0
    small = np.where(part, 0.01 * x, x)
    saved(
        play_model(),
        log={"time_s": time, "volt [V]": small, "angle [deg]": play_model().simulate(small)},
    )(folder)


def log_from_elsewhere(folder):
    """A log whose actuator came from below, and which never visits both ends."""
    card = ModelCard(SignalCard("volt", "V", -1.0, 1.0), SignalCard("angle", "deg", -1.5, 1.5))
    model = dehyst.PrandtlIshlinskii([0.0, 0.2, 0.5], [1.0, 0.6, 0.4], card=card)
    time, x = wave(size=0.3)
    x = 0.1 + x
    before = np.concatenate(
        [np.linspace(0.0, 1.0, 50), np.linspace(1.0, -1.0, 100), np.linspace(-1.0, x[0], 50)]
    )
    y = model.simulate(np.concatenate([before, x]))[before.size :]
    saved(model, log={"time_s": time, "volt [V]": x, "angle [deg]": y})(folder)


def log_from_inside(folder):
    """A log of one way up, which ends where its range does."""
    time = np.arange(400) / 20.0
    x = np.linspace(-0.5, 0.5, 400) + 0.05 * np.sin(time)
    y = play_model().simulate(x)
    saved(play_model(), log={"time_s": time, "volt [V]": x, "angle [deg]": y})(folder)


def another_log(folder):
    time, x = wave()
    other = np.random.default_rng(1).standard_normal(x.size)
    saved(play_model(), log={"time_s": time, "volt [V]": x, "angle [deg]": other})(folder)


def muscle_log(head, contraction=1.0, pressure=1e-5, force=1.0, above=0.0, at_rest=0.0, noise=0.0):
    """What writes a bench log of a muscle: names of its columns, factors of SI units, and what pressure counts from."""

    def write(folder):
        truth = muscle("sarosi", "DMSP-20-map")
        k, p = (
            grid.ravel()
            for grid in np.meshgrid(np.linspace(0.0, 0.2, 12), np.linspace(0.0, 6e5, 12))
        )
        pull = np.maximum(truth.static_force(k, p), 0.0)
        pull += noise * np.abs(np.random.default_rng(0).standard_normal(k.size)) * pull.max()
        rows = np.column_stack([at_rest + contraction * k, pressure * (p + above), force * pull])
        np.savetxt(folder / "log.csv", rows, delimiter=",", header=head, comments="", fmt="%.9g")

    return write


def gain_that_no_eps_reaches(folder):
    x = np.interp(np.linspace(0, 9, 1801), range(10), [0, 1, -1, 1, -1, 0.8, -0.8, 0.6, -0.6, 0])
    y = np.tanh(3.0 * dehyst.PrandtlIshlinskii([0.0, 0.1], [1.0, 0.3]).simulate(x))
    log_of(dehyst.Recording(input=x, output=y), folder / "log.csv")


def example(folder):
    from test_sheared_loop import example as recording

    log_of(recording(), folder / "log.csv")


def gain_that_changes(folder):
    x = (
        np.sin(np.arange(4000) / 60)
        * np.linspace(1.0, 0.9, 4000)
        * (0.75 + 0.25 * np.cos(np.arange(4000) / 400))
    )
    y = PI.simulate(x) * np.where(np.arange(4000) < 2000, 1.0, 1.1)
    log_of(dehyst.Recording(input=x, output=y, time=0.01 * np.arange(4000)), folder / "log.csv")


def unrelated(folder):
    from test_least_is_known import unrelated as recording

    log_of(recording(0), folder / "log.csv")


def direct_log(load=None, creep=(), stops=STOPS, curve=(0.0, 1.0), tips=TIPS):
    """What writes a log for a direct inverse."""

    def write(folder):
        t, y = motion(tips)
        record = log(t, y, asked(t, y, np.zeros(y.size), stops=stops, creep=creep, curve=curve))
        columns = {"time_s": record.time, "volt": record.input, "angle": record.output}
        if load is not None:
            columns["load_N"] = np.where(t < load * t[-1], 10.0, 20.0)
        write_csv(folder / "log.csv", columns)

    return write


def under_two_loads(folder):
    """Two logs, each under a load of its own."""
    t, y = motion()
    for name, load in (("log", 10.0), ("log2", 20.0)):
        x = asked(t, y, np.zeros(y.size), stops=STOPS) * (1.0 + 0.03 * (load - 10.0))
        write_csv(
            folder / f"{name}.csv",
            {"time_s": t, "volt": x, "angle": y, "load_N": np.full(t.size, load)},
        )


def worn(folder):
    """A model of a log, and a later log of the actuator."""
    for name, seed in (("new", 1), ("later", 2)):
        record = cycling_log(seed, 24, {"creep": 0.0}, minor=True)
        write_csv(
            folder / f"{name}.csv",
            {"time_s": record.time, "volt": record.input, "angle": record.output},
        )
    dehyst.identify(dehyst.read_log(folder / "new.csv", "volt", "angle"), "pi", n=30).model.save(
        folder / "m.json"
    )


def worn_without_range(folder):
    worn(folder)
    model = dehyst.load(folder / "m.json")
    model.with_card(ModelCard(SignalCard("volt"), SignalCard("angle"))).save(folder / "m.json")


def soft_model(folder):
    """A model that is nearly flat right after a reversal, and a reference that turns."""
    record = FIRING["inverse-useless"][0]()
    log_of(record, folder / "log.csv")
    read = dehyst.read_log(folder / "log.csv", "volt", "angle")
    dehyst.identify(read, "pi", n=10, eps=1e-8).model.save(folder / "m.json")
    time = np.arange(2000) / 50.0
    write_csv(folder / "ref.csv", {"time_s": time, "angle": 2.0 * np.sin(time)})


def many_operators(folder):
    plain(folder)
    saved(play_model(weights=(0.001,) * 1100))(folder)


def verdict_of_care(folder):
    time, x = wave()
    verdict = "pi: 5.0 % of range rms: usable with care (few-loops)."
    card = ModelCard(CARD.input, CARD.output, {"grade": "care", "verdict": verdict})
    saved(play_model(card), ref={"time_s": time, "angle [deg]": x})(folder)
    plain(folder)


def from_unknown_past(folder):
    time, x = wave(size=0.5)
    saved(
        play_model(weights=(1.0, 0.5, 0.2, 0.4, 0.5)), ref={"time_s": time, "angle [deg]": 2.0 * x}
    )(folder)


def creeping(x, time, taus=(8.0, 60.0)):
    """Plays with creep: a rig."""
    y = dehyst.PrandtlIshlinskii([0.0, 0.3, 0.8], [1.0, 0.4, 0.3]).simulate(x)
    total = y.copy()
    for tau in taus:
        lag, state = np.empty_like(y), y[0]
        for k in range(y.size):
            state += (y[k] - state) * (1.0 - np.exp(-(time[1] - time[0]) / tau))
            lag[k] = state
        total += 0.15 * lag
    return total


def creeps(*taus):
    """What writes a log of creep."""

    def write(folder):
        time, x = wave(1500)
        write_csv(folder / "log.csv", {"time_s": time, "volt": x, "angle": creeping(x, time, taus)})

    return write


def example_log(folder):
    """The example, whose best model has 128 numbers."""
    record = example_recording()
    columns = {"time_s": record.time, "volt": record.input, "angle": record.output}
    write_csv(folder / "log.csv", columns)


def slow_unit(folder):
    time = np.arange(3000) * 1e-4
    x = np.sin(40.0 * time) * np.linspace(1.0, 0.3, time.size)
    record = dehyst.Recording(input=x, output=creeping(x, time, (0.01, 0.1)), time=time)
    dehyst.identify(record, "creep-pi").model.save(folder / "m.json")


def fast_reference(folder):
    """A model with creep of a slow log, and a reference, which is a log of use too, eight times as fast."""
    creeps(0.5, 2.0)(folder)
    read = dehyst.read_log(folder / "log.csv", "volt", "angle")
    dehyst.identify(read, "creep-pi").model.save(folder / "m.json")
    time, x = wave(800)
    write_csv(folder / "ref.csv", {"time_s": time / 8.0, "volt": x, "angle": x})


def weights_that_follow_the_output(folder):
    """What a direct inverse learns with weights that change more than its curve rises."""
    t, y = motion(TIPS * 2)
    x = asked(t, y, np.zeros(y.size), stops=((3.0, 1.0),), curve=(0.0, 0.15), share=1.0 + 0.09 * y)
    write_csv(folder / "log.csv", {"time_s": t, "volt": x, "angle": y})


def late(folder, timed=True):
    x = loops((1.0, 0.6, 0.9, 0.5, 0.8, 1.0, 0.7, 0.9) * 2, 60)
    y = np.concatenate([np.zeros(8), PI.simulate(x)[:-8]]) + noise(x.size, 1e-3)
    time = 0.02 * np.arange(x.size) if timed else None
    log_of(dehyst.Recording(input=x, output=y, time=time), folder / "log.csv")


def late_untimed(folder):
    late(folder, timed=False)


def answers_late(folder):
    t = 0.02 * np.arange(500)
    model = replace(ElementModel.example(), dead_time=0.1, period=0.02, card=CARD)
    saved(model, ref={"time_s": t, "angle": 0.2 * np.sin(t)})(folder)


def rings_when_it_moves(folder):
    """Plays that move, rest and ring at 6 Hz."""
    t = 0.01 * np.arange(6000)
    x = np.where(t % 8.0 < 4.0, np.sin(0.5 * np.pi * t), 0.0)
    y = second_order(PI.simulate(x), 6.0, 0.03, 0.01) + noise(t.size, 1e-3)
    log_of(dehyst.Recording(input=x, output=y, time=t), folder / "log.csv")


def hums(folder):
    """Plays, and a hum of 12 Hz, moving or not."""
    t = 0.01 * np.arange(6000)
    x = np.where(t % 8.0 < 4.0, np.sin(0.5 * np.pi * t), 0.0)
    y = PI.simulate(x) + 0.02 * np.sin(24.0 * np.pi * t) + noise(t.size, 1e-3)
    log_of(dehyst.Recording(input=x, output=y, time=t), folder / "log.csv")


def bends(folder):
    """A curve without hysteresis."""
    t, x = wave(2000)
    y = x + 0.3 * x**3 + noise(t.size, 1e-3)
    log_of(dehyst.Recording(input=x, output=y, time=t), folder / "log.csv")


def model_that_rings(frequency):
    """What writes a model that knows a resonance, the same without, and references of two steps of time."""

    def write(folder):
        t, fine = 0.02 * np.arange(500), 0.002 * np.arange(5000)
        model = replace(ElementModel.example(), period=0.02, card=CARD, resonance=(frequency, 0.03))
        saved(model, ref={"time_s": t, "angle": 0.2 * np.sin(t)})(folder)
        replace(model, resonance=None).save(folder / "plain.json")
        write_csv(folder / "fine.csv", {"time_s": fine, "angle": 0.2 * np.sin(fine)})

    return write


def axis_sheet(play=0.04, repeats=3, approach=2.0, unit=" [mm]", factor=1.0):
    """What writes the filled sheet of an axis."""

    def write(folder):
        lines = [f"approach{unit},commanded{unit},direction,measured{unit}"]
        rows = measure(Plain(Axis(play)), np.linspace(0.0, 300.0, 7), repeats, approach, 1e-3)
        for _, point, rising, value in rows:
            side = "rising" if rising else "falling"
            cells = (approach * factor, point * factor, value * factor)
            lines.append("{:.6g},{:.6g},{},{:.6f}".format(*cells[:2], side, cells[2]))
        (folder / "m.csv").write_text("\n".join(lines))

    return write


def two_files(begin):
    """What writes input and output on clocks of their own, the output from a time on, by its stamps from `begin`."""

    def write(folder):
        time, x = wave()
        time = time + begin
        write_csv(folder / "u.csv", {"time_s": time, "volt": x})
        write_csv(folder / "y.csv", {"time_s": time[40:] - 1.5, "angle": PI.simulate(x)[40:]})

    return write


def closed_loop(folder):
    """A log of a servo in closed loop, with its reference."""
    write_csv(folder / "loop.csv", servo_log())


def valve_shares(folder):
    """A record whose controller output is within 0 and 1 %."""
    columns = valve_loop()
    columns["OP"] = 0.5 + 0.05 * (columns["OP"] - 50.0)
    write_csv(folder / "loop.csv", columns)


def outer_cycle(folder):
    """A slow full cycle of an electrode, and no partial one."""
    x = np.abs(np.linspace(-1.0, 1.0, 401))
    gap = 0.1 * np.sign(np.linspace(-1.0, 1.0, 401)) * np.sin(np.pi * x)
    write_csv(folder / "ocv.csv", {"charge [Ah]": 1.0 - x, "voltage [V]": 0.3 + 0.2 * x + gap})


TWO_FILES = "identify u.csv:volt y.csv:angle --family pi --n 10"
IDENTIFY = f"identify log.csv {PAIR}"
AXIS = "backlash table m.csv --machine marlin"
MUSCLE = "muscle sarosi --log log.csv"
BARE = f"{IDENTIFY} --family pi --n 10"
DIRECT = f"{IDENTIFY} --family direct-inverse"
EXPORT = "export m.json --target c --out c --overwrite"


# Finding -> cures of it, each executed.
def in_a_row(folder):
    """A model, a log, the one before it, an earlier one, and one of another actuator."""
    saved(play_model())(folder)
    model = dehyst.load(folder / "m.json")
    x = loops((1.0, 0.6, 0.9, 0.5, 0.8, 1.0), 60)
    y = model.simulate(x)
    time = 0.02 * np.arange(x.size)
    third = x.size // 3
    for name, part in (
        ("next", slice(2 * third, None)),
        ("past", slice(third, 2 * third)),
        ("early", slice(0, third + 20)),
    ):
        write_csv(folder / f"{name}.csv", {"time_s": time[part], "volt": x[part], "angle": y[part]})
    write_csv(folder / "other.csv", {"time_s": time, "volt": x, "angle": 20.0 - 5.0 * y})


CURES: dict[str, list[Cure]] = {
    "past-unexplained": [
        Cure(
            in_a_row,
            "simulate m.json next.csv --out o.csv --overwrite --after other.csv",
            "leave --after out",
            "simulate m.json next.csv --out o.csv --overwrite",
        )
    ],
    "past-apart": [
        Cure(
            in_a_row,
            "simulate m.json next.csv --out o.csv --overwrite --after early.csv",
            "ends where this one begins",
            "simulate m.json next.csv --out o.csv --overwrite --after past.csv",
        )
    ],
    "no-time": [Cure(without_time, BARE, r"--dt 0\.01")],
    "time-unit": [
        Cure(named_time("time", 1e3), BARE, r"--time-unit ms"),
    ],
    "day-numbers": [Cure(day_numbers, BARE, "--time-unit s")],
    "aligned-clocks": [Cure(two_files(0.0), TWO_FILES, "--clocks stamps")],
    "shape-offset": [Cure(two_files(1.76e9), TWO_FILES, "--clocks shape")],
    "several-time-columns": [
        Cure(two_times, BARE, r"--time time_s"),
        Cure(plain, f"{BARE} --dt 0.05", "leave --dt out", BARE),
    ],
    "gap": [Cure(with_a_gap, BARE, "--from or --to", "{line} --to 10 --train-fraction 1")],
    "memory-carried": [
        Cure(
            reference_with_a_gap,
            "compensate m.json ref.csv --output angle",
            "--from and --to",
            "{line} --to 5",
        )
    ],
    "thinned": [
        Cure(
            long_log,
            "identify log.npz --input volt --output angle --family pi --n 10",
            "--from and --to",
            "{line} --to 4000",
        )
    ],
    "swapped-columns": [
        Cure(
            swapped,
            "identify log.csv --input measured_angle_deg --output setpoint_V --family pi --n 10",
            "--input setpoint_V --output measured_angle_deg",
        )
    ],
    "header-width": [
        Cure(
            narrow_header,
            "inspect log.csv",
            r"--input column_\d --output column_\d",
            "identify log.csv --input column_2 --output column_3 --time column_1 --family pi --n 10",
            "runs",
        )
    ],
    "few-loops": [
        Cure(
            fired("few-loops"),
            f"{BARE} --train-fraction 0.08",
            "--train-fraction",
            "{line} {named} 0.6",
        )
    ],
    "never-turns": [
        Cure(fired("never-turns"), f"{BARE} --train-fraction 0.02", r"--train-fraction 1\b")
    ],
    "butterfly-loop": [
        Cure(
            fired("butterfly-loop"), BARE, "--family butterfly", f"{IDENTIFY} {{named}}", "changed"
        ),
        Cure(
            on_a_wing,
            f"{IDENTIFY} --save model.json",
            "--wing upper",
            "compensate model.json wanted.csv {named} --out c.csv",
            "runs",
        ),
    ],
    "clockwise": [Cure(fired("clockwise"), BARE, "--family stop", after="changed")],
    "rate-dependent": [
        Cure(
            fired("rate-dependent"), BARE, "--family auto", IDENTIFY + " --family rate-dependent-pi"
        )
    ],
    "drift": [Cure(fired("drift"), BARE, "--from", "{line} --from 14", after="changed")],
    "two-actuators": [Cure(fired("two-actuators"), BARE, "--from, --to", "{line} --to 9")],
    "one-loop-size": [
        Cure(
            fired("one-loop-size"),
            BARE,
            r"dehyst design --range \S+ [\d.]+",
            "{named} --out motion.csv",
        )
    ],
    "extrapolation": [Cure(fired("extrapolation"), BARE, "--train-fraction", "{line} {named} 0.8")],
    "small-test": [
        Cure(
            fired("small-test"),
            f"{BARE} --train-fraction 0.998",
            "--train-fraction",
            "{line} {named} 0.5",
        )
    ],
    "no-held-out": [Cure(fired("no-held-out"), BARE, "--train-fraction", "{line} {named} 0.3")],
    "static-as-good": [Cure(fired("static-as-good"), f"{IDENTIFY} --family pi", "--family static")],
    "no-hysteresis": [Cure(fired("no-hysteresis"), IDENTIFY, r"--family [a-z-]+(?=\.)")],
    "high-inverse-gain": [
        Cure(
            fired("high-inverse-gain"),
            f"{IDENTIFY} --family pi --eps 0.0001",
            r"--eps [\d.]+(?= would keep)",
        ),
        Cure(
            fired("high-inverse-gain"),
            f"{IDENTIFY} --family modified-pi --eps 0.0001",
            r"--eps [\d.]+(?=,)",
            after="changed",
        ),
        Cure(
            fired("high-inverse-gain"),
            f"{IDENTIFY} --family modified-pi --eps 0.0001",
            "--eps auto",
            after="changed",
        ),
        Cure(fired("high-inverse-gain"), IDENTIFY, r"--max-inverse-gain [\d.]+\d"),
    ],
    "inverse-useless": [
        Cure(fired("inverse-useless"), f"{BARE} --eps 1e-8", "raise --eps", "{line} --eps 0.1"),
    ],
    "paper-bound": [
        Cure(fired("paper-bound"), f"{IDENTIFY} --family pi", "--eps auto"),
        Cure(fired("paper-bound"), f"{IDENTIFY} --family pi", r"--eps [\d.e-]+\d"),
    ],
    "output-unrelated": [Cure(unrelated, BARE, r"dehyst inspect LOG", "inspect log.csv", "runs")],
    "held-out-worse": [Cure(gain_that_changes, BARE, "--train-fraction 1")],
    "gain-exceeded": [
        Cure(
            gain_that_no_eps_reaches,
            f"{IDENTIFY} --family modified-pi --n 20 --max-inverse-gain 1.6",
            "--family pi",
        )
    ],
    "plays-only": [Cure(plain, f"{IDENTIFY} --n 20", "", IDENTIFY)],
    "recordings-differ": [
        Cure(
            under_two_loads,
            f"identify log.csv log2.csv {PAIR} --family pi",
            r"--schedule \w+",
            f"identify log.csv log2.csv {PAIR} {{named}}",
        )
    ],
    "dead-time": [
        Cure(
            answers_late,
            "compensate m.json ref.csv --output angle",
            "--ahead 0",
            after="changed",
        )
    ],
    "spectral-peak": [
        Cure(hums, IDENTIFY, r"--resonance [\d.]+,0.02", "{line} {named}"),
    ],
    "resonance": [
        Cure(rings_when_it_moves, IDENTIFY, "--resonance none"),
        Cure(
            rings_when_it_moves, IDENTIFY, "--resonance (HZ,DAMPING)", "{line} --resonance 6,0.03"
        ),
    ],
    "resonance-not-shaped": [
        Cure(bends, f"{IDENTIFY} --resonance 6,0.03", "--family full-sum", "{line} {named}")
    ],
    "reference-shaped": [
        Cure(
            model_that_rings(6.0),
            "compensate m.json ref.csv --output angle",
            "identify with (--resonance none)",
            "compensate plain.json ref.csv --output angle",
        ),
        Cure(
            model_that_rings(6.0),
            "export m.json --target c --out unit",
            "identify with (--resonance none)",
            "export plain.json --target c --out unit --overwrite",
        ),
    ],
    "resonance-too-fast": [
        Cure(
            model_that_rings(20.0),
            "export m.json --target c --out unit",
            r"--period [\d.e-]+",
            "{line} {named} --overwrite",
        ),
        Cure(
            model_that_rings(20.0),
            "compensate m.json ref.csv --output angle",
            "Sample it more finely",
            "compensate m.json fine.csv --output angle",
        ),
    ],
    "resonance-left-out": [
        Cure(
            model_that_rings(6.0),
            "export m.json --target c --what forward --out unit",
            "second order",
            "export plain.json --target c --what forward --out unit --overwrite",
        )
    ],
    "output-late": [
        Cure(late, IDENTIFY, "identify with (--ahead 0)", "{line} --ahead 0", after="changed"),
        Cure(late_untimed, IDENTIFY, r"--dt", "{line} {named} 0.02", after="changed"),
    ],
    "slope-not-guaranteed": [
        Cure(weights_that_follow_the_output, f"{DIRECT} --creep 0", "--no-position-schedule")
    ],
    "creep-no-gain": [Cure(direct_log(), f"{DIRECT} --creep 2 --initial-state rest", "--creep 0")],
    "creep-times-outside": [
        Cure(
            direct_log(),
            f"{DIRECT} --creep-times 0.0001,10000 --initial-state rest",
            r"--creep \d",
            f"{DIRECT} --initial-state rest {{named}}",
        )
    ],
    "schedule-once": [
        Cure(
            direct_log(load=0.4, tips=TIPS * 2),
            f"{DIRECT} --schedule load=load_N --creep 0",
            "--train-fraction",
            "{line} {named} 0.9",
        )
    ],
    "forward-better": [
        Cure(
            direct_log(tips=(0.1, -0.1) * 3 + TIPS),
            f"{DIRECT} --creep 0 --train-fraction 0.2",
            r"--family [a-z-]+",
            f"{IDENTIFY} --train-fraction 0.2 {{named}}",
        )
    ],
    "zero-weights": [Cure(saved(play_model(weights=(1.0, 0.0, 0.5))), EXPORT, "--prune")],
    "coarse-float": [
        Cure(saved(play_model(level=1000.0)), f"{EXPORT} --real float", "--real double")
    ],
    "many-operators": [
        Cure(
            many_operators,
            f"{EXPORT} --what forward",
            "--n 100",
            f"identify log.csv {PAIR} --family pi {{named}} --save m.json --overwrite",
        )
    ],
    "long-period": [
        Cure(
            slow_unit,
            f"{EXPORT} --period 0.01",
            r"(?<=seconds: )[\d.e-]+(?=, or less)",
            "{line} --period {named}",
        )
    ],
    "dead-time-rounded": [
        Cure(
            answers_late,
            f"{EXPORT} --what forward --period 0.04",
            r"--period [\d.]+\d",
            f"{EXPORT} --what forward {{named}}",
        )
    ],
    "excerpt-says-little": [
        Cure(
            small_excerpt,
            f"{EXPORT} --what forward --log log.csv --column volt --to 5",
            "--from and --to",
            "{line} --to 30",
        )
    ],
    "outside-range": [
        Cure(
            saved(play_model()),
            f"{EXPORT} --what forward --range -2 2",
            "Narrow --range",
            "{line} --range -1 1",
        )
    ],
    "memory-unknown": [
        Cure(
            from_unknown_past,
            "compensate m.json ref.csv --output angle --unknown-state",
            "",
            "{line} --past -0.3 0.3",
            after="changed",
        )
    ],
    "step-exceeds-period": [
        Cure(slow_unit, f"{EXPORT} --period 0.0001", r"--real float|--period [\d.e-]+(?=\))")
    ],
    "smaller-for-period": [
        Cure(
            example_log,
            f"{IDENTIFY} --processor cortex-m4f --period 0.0001",
            r"--period [\d.e-]+(?=\))",
        )
    ],
    "creep-without-holds": [
        Cure(
            creeps(0.5, 2.0),
            f"{IDENTIFY} --family creep-pi",
            r"dehyst design --range [^`]*",
            "{named} --period 0.04 --out motion.csv",
            taus=(0.5, 2.0),
        ),
    ],
    "creep-beyond-rests": [
        Cure(
            creeps(8.0, 60.0),
            f"{IDENTIFY} --family creep-pi",
            "dehyst design [^`]*",
            "{named} --period 0.04 --out motion.csv",
            taus=(8.0, 60.0),
        )
    ],
    "faster-than-log": [
        Cure(
            fast_reference,
            line,
            r"dehyst design [^`]*",
            "{named} --out motion.csv",
            taus=(0.5, 2.0),
            again=f"{IDENTIFY} --family creep-pi --save m.json --overwrite",
        )
        for line in (
            "compensate m.json ref.csv",
            "simulate m.json ref.csv",
            "evaluate m.json ref.csv",
        )
    ],
    "start-counts": [
        Cure(log_from_inside, "evaluate m.json log.csv", "--start rising", after="changed")
    ],
    "input-jumps": [
        Cure(
            soft_model,
            "compensate m.json ref.csv --output angle",
            "raise --eps",
            f"identify log.csv {PAIR} --family pi --n 10 --eps 0.1 --save m.json --overwrite",
            "changed",
        )
    ],
    "round-trip": [
        Cure(
            soft_model,
            "compensate m.json ref.csv --output angle",
            "raise --eps",
            f"identify log.csv {PAIR} --family pi --n 10 --eps 0.1 --save m.json --overwrite",
        )
    ],
    "verdict": [
        Cure(
            verdict_of_care,
            "compensate m.json ref.csv",
            "dehyst identify",
            f"{BARE} --save m.json --overwrite",
        )
    ],
    "sheet": [
        Cure(two_sheets, "identify log.xlsx " + PAIR + " --family pi --n 10", "--sheet worn")
    ],
    "drift-no-reference": [
        Cure(worn, "drift m.json later.csv", "--reference", "{line} --reference new.csv")
    ],
    "drift-no-range": [
        Cure(
            worn_without_range,
            "drift m.json new.csv later.csv",
            "dehyst identify",
            f"identify new.csv {PAIR} --family pi --save m.json --overwrite",
        )
    ],
    "muscle-unit-guessed": [
        Cure(muscle_log("contraction,pressure_bar,force"), MUSCLE, r"--force-unit \w+"),
        Cure(muscle_log("contraction,pressure_bar,force", force=1e-3), MUSCLE, r"--force-unit \w+"),
        Cure(muscle_log("contraction,pressure,force_N"), MUSCLE, r"--pressure-unit \w+"),
        Cure(
            muscle_log("contraction,pressure,force_N", pressure=1e-6),
            MUSCLE,
            r"--pressure-unit \w+",
        ),
        Cure(
            muscle_log("contraction,pressure,force_N", pressure=1e-3),
            MUSCLE,
            r"--pressure-unit \w+",
        ),
        Cure(
            muscle_log("contraction,pressure_bar,force_N", contraction=59.2),
            MUSCLE,
            "--contraction-unit mm, and --length 300mm",
            "{line} --contraction-unit mm --length 300mm",
        ),
        Cure(
            muscle_log("contraction_percent,pressure_bar,force_N", contraction=0.02),
            f"{MUSCLE} --contraction contraction_percent",
            "--contraction-unit 1",
        ),
        Cure(
            muscle_log("length,pressure_bar,force_N", contraction=-0.296, at_rest=0.296),
            f"{MUSCLE} --length-column length --length 296mm",
            "--length 0.296",
            "{line} --contraction-unit m",
        ),
    ],
    "muscle-mass": [
        Cure(
            muscle_log("contraction,pressure_bar,force_kg", force=1 / 9.80665),
            f"{MUSCLE} --force force_kg",
            "--force-unit N",
        )
    ],
    "muscle-absolute": [
        Cure(muscle_log("contraction,pressure_bar,force_N", above=101325.0), MUSCLE, "--absolute")
    ],
    "muscle-poor-fit": [
        Cure(
            muscle_log("contraction,pressure_bar,force_N", noise=0.4),
            MUSCLE,
            "dehyst muscle --list",
            "muscle --list",
            "runs",
        )
    ],
    "muscle-at-bound": [],
    "closed-loop": [
        Cure(closed_loop, "inspect loop.csv", "dehyst design --range .*?csv", "{named}", "runs"),
    ],
    "ocv-no-partial-cycles": [Cure(outer_cycle, "battery ocv.csv", "--decay 50")],
    "valve-span": [Cure(valve_shares, "valve loop.csv", "--span 0 100", "{line} {named}")],
    "backlash-unit": [
        Cure(axis_sheet(unit="", factor=1.0 / 25.4), AXIS, "--unit in"),
    ],
    "backlash-one-repeat": [
        Cure(
            axis_sheet(repeats=1),
            AXIS,
            "dehyst backlash plan --repeats 3",
            "{named} --from 0 --to 300 --sheet again.csv",
            "runs",
        )
    ],
    "backlash-approach": [
        Cure(
            axis_sheet(play=1.0, approach=0.6),
            AXIS,
            r"--approach.*? at least [\d.]+\d",
            "backlash plan --from 0 --to 300 --approach 4 --sheet again.csv",
            "runs",
        )
    ],
    "unknown-past": [Cure(log_from_elsewhere, "evaluate m.json log.csv", r"--start [a-z]+")],
    "unexplained": [
        Cure(another_log, "evaluate m.json log.csv", "dehyst inspect", "inspect log.csv", "runs")
    ],
}
