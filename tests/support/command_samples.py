"""A folder in which every command works, small and quick, and a line to type for each."""

from __future__ import annotations

import functools

import dehyst
import dehyst.app._design
import dehyst_robot
import dehyst_robot.commands._reproduce
import dehyst_robot.commands._sweep
import sweep_evaluators
from dehyst.design import design_excitation
from dehyst.export import export, subject_of
from dehyst.files import write_atomically
from dehyst.io import example_recording, write_csv
from dehyst_robot.experiments import PlantResult, Reproduction, run_sweep
from dehyst_robot.experiments._results import TRIALS
from simulated_loops import core_loop, open_circuit, stage_log, valve_loop

X, Y = "pressure_difference_bar", "angle_deg"
PAIR = ("--input", X, "--output", Y)
QUICK = ("--family", "pi", "--n", "10")
COMMANDS = {
    "example": ("example",),
    "doctor": ("doctor",),
    "page": ("page", "page.html"),
    "inspect": ("inspect", "log.csv"),
    "loops": ("loops", "log.csv"),
    "sensor": ("sensor", "log.csv", "--reading", X, "--quantity", Y),
    "identify": ("identify", "log.csv", *PAIR, *QUICK),
    "compare": ("compare", "log.csv", *PAIR, "--families", "pi"),
    "coupled": (
        "coupled",
        "stage.csv",
        "--input",
        "a",
        "--input",
        "b",
        "--output",
        "x",
        "--output",
        "y",
    ),
    "simulate": ("simulate", "model.json", "log.csv", "--input", X),
    "compensate": ("compensate", "model.json", "log.csv", "--output", Y),
    "drift": ("drift", "model.json", "log.csv"),
    "evaluate": ("evaluate", "model.json", "log.csv"),
    "rig": ("rig", "new", "rig.toml"),
    "watch": ("watch", "model.json", "--follow", "log.csv", "--until-silent", "0.1"),
    "export": ("export", "model.json", "--target", "c-header", "--out", "made"),
    "verify": ("verify", "st"),
    "muscle": ("muscle", "--list"),
    "backlash": ("backlash", "plan", "--from", "0", "--to", "300"),
    "valve": ("valve", "loop.csv"),
    "magnet": ("magnet", "core.csv"),
    "battery": ("battery", "ocv.csv"),
    "design": ("design", "--range", "-30", "30", "--unit", "deg"),
    "sweep": ("sweep", "sweep.toml", "--workers", "0"),
    "reproduce": ("reproduce", "--quick"),
    "studio": ("studio", "log.csv", "--no-browser", "--idle", "0.001"),
}
SWEEP = """
name = "test"
seeds = [1]
trials = ["slow"]
[[study]]
name = "size"
grid."hysteresis.scale" = [0.5, 2.0]
"""
AXIS = """commanded [mm],direction,measured [mm]
0,rising,-0.02
0,falling,0.02
9,rising,8.98
9,falling,9.02
"""


def make_folder(place):
    """Write what the commands read."""
    rec = example_recording(rate=4.0)
    for name, change in (("log", 1.0), ("worn", 1.3)):
        write_csv(place / f"{name}.csv", {"time_s": rec.time, X: rec.input, Y: change * rec.output})
    write_csv(place / "small.csv", {"time_s": rec.time, X: 0.03 * rec.input, Y: 0.03 * rec.output})
    model = dehyst.identify(dehyst.read_log(place / "log.csv", X, Y), "pi", n=10).model
    model.save(place / "model.json")
    export(subject_of(model, name="unit_1"), "st", place / "st")
    (place / "sweep.toml").write_text(SWEEP)
    (place / "axis.csv").write_text(AXIS)
    write_csv(place / "loop.csv", valve_loop(samples=1000))
    write_csv(place / "core.csv", core_loop())
    write_csv(place / "ocv.csv", open_circuit())
    write_csv(place / "stage.csv", stage_log(samples=600))
    return place


ONE = {"off": {"rms_deg": 10.0, "max_deg": 20.0}, "paper": {"rms_deg": 5.0, "max_deg": 10.0}}
PLANT = PlantResult(
    "none", {}, (), {0: {"joints": {"1": {"trials": dict.fromkeys(TRIALS, ONE)}}}}, 30.0
)
DESIGNED = functools.cache(design_excitation)


def stand_in(monkeypatch):
    """Let `design`, `sweep` and `reproduce` write and print what they would, without the hours before."""
    monkeypatch.setitem(dehyst.app._design.MOTIONS, dehyst.app._design.IDENTIFICATION, DESIGNED)
    monkeypatch.setattr(
        dehyst_robot.commands._sweep,
        "run_sweep",
        functools.partial(run_sweep, evaluate=sweep_evaluators.quick),
    )
    monkeypatch.setattr(
        dehyst_robot.commands._reproduce,
        "reproduce",
        lambda *_: Reproduction({"none": PLANT}, "paper", {}),
    )
    monkeypatch.setattr(
        dehyst_robot.commands._reproduce,
        "write_reproduction_report",
        lambda result, page, **_: write_atomically(page, dehyst.app._targets.PAGE),
    )
