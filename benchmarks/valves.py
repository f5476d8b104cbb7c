"""Dead band and jump of simulated control valves: errors, coverage of the intervals, false alarms, what is not told.

    python benchmarks/valves.py [--jobs 2] [--out docs/generate/valves.csv]

Loops of examples/simulators/valve_loop.py: four valve models, none written like the one that is fitted, on four
processes, with controls that swing without a sticking valve, records with the position, and tests in manual. A case
that the file has already is not run again. docs/build.py makes the tables of docs/how-to/valves.md from the file.
Status 1 if more than one linear loop in twenty is said to stick, or if intervals of the dead band cover less than
three of four.

Truth of the valve with mass is what it does in a slow ramp without noise: static friction is what was set, and the jump
is the mean of its jumps.
"""

from __future__ import annotations

import argparse
import csv
import runpy
import sys
import warnings
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np

ROOT = Path(__file__).parents[1]
OUT = ROOT / "docs" / "generate" / "valves.csv"
COLUMNS = (
    "group", "process", "valve", "case", "seed", "S", "J", "kind", "mode", "S_fit", "S_low", "S_high", "J_fit",
    "J_low", "J_high", "excluded_above", "swing", "over_linear", "over_periodic", "steadiness",
)  # fmt: skip
PROCESSES = ("flow", "pressure", "level", "temperature")
VALVES = ("choudhury", "kano", "he", "friction")
STICKING = {  # name -> dead band, jump, noise, load
    "S 4 J 2": (4.0, 2.0, 0.1, 0.3),
    "S 2 J 0.5, half the noise": (2.0, 0.5, 0.05, 0.15),
    "S 6 J 5, three times the noise": (6.0, 5.0, 0.3, 0.5),
    "S 5 J 0, set point steps": (5.0, 0.0, 0.1, 0.3),
}
AGGRESSIVE = {"flow": 4.3, "pressure": 4.3, "level": 6.0, "temperature": 2.15}
WAVES = {"flow": 40.0, "pressure": 100.0, "level": 1500.0, "temperature": 600.0}  # periods [s]
CONTROLS = (
    "noise alone", "aggressive tuning", "sine", "triangle", "square", "irregular square", "positioner, dead band 0.3",
)  # fmt: skip


def cases() -> Iterator[tuple[str, str, str, str, int]]:
    """Yield group, process, valve, case, seed."""
    for process in PROCESSES:
        for valve in VALVES:
            for case in STICKING:
                yield "sticking", process, valve, case, 1
        for case in CONTROLS:
            for seed in (1, 2):
                yield "control", process, "linear", case, seed
        for valve in (*VALVES, "linear"):
            yield "position", process, valve, "S 4 J 2", 1
            yield "manual", process, valve, "S 4 J 2", 1


def measured(job: tuple[str, str, str, str, int]) -> tuple[object, ...]:
    """Simulate and judge one case."""
    from dehyst_targets.valves import ControlLoop, judge_valve, step_test

    warnings.simplefilter("ignore", UserWarning)
    group, process, valve, case, seed = job
    simulated = runpy.run_path(str(ROOT / "examples" / "simulators" / "valve_loop.py"))
    loop = simulated["Loop"](simulated["PROCESSES"][process], valve, seed=seed)
    if case in STICKING:
        loop.dead_band, loop.jump, loop.noise, loop.load = STICKING[case]
    if "steps" in case:
        loop.steps = 3.0
    if case == "aggressive tuning":
        loop.detune = AGGRESSIVE[process]
    if case.startswith("positioner"):
        loop.valve, loop.dead_band, loop.jump = "kano", 0.3, 0.0
    for shape in ("sine", "triangle", "square"):
        if case == shape:
            loop.wave = (shape, 3.0, WAVES[process])
    if case == "irregular square":
        loop.wave = ("irregular", 3.0, WAVES[process])
    logged = loop.run()
    part = slice(200, None)
    position = None
    if group == "position":
        rng = np.random.default_rng(seed)
        position = (logged["MV"] + 0.1 * rng.normal(size=logged["MV"].size))[part]
    record = ControlLoop.of(
        logged["OP"][part],
        logged["PV"][part],
        logged["SP"][part],
        position,
        time=logged["time_s"][part],
    )
    verdict = judge_valve(record)
    if group == "manual":
        loop.manual = step_test(verdict)[1]
        loop.samples, loop.seed = loop.manual.size, seed + 100
        logged = loop.run()
        verdict = judge_valve(ControlLoop.of(logged["OP"], logged["PV"], time=logged["time_s"]))
    true = truth(simulated["VALVES"][loop.valve], loop)
    fit, evidence = verdict, verdict.fit.evidence
    numbers = (
        fit.dead_band.value, fit.dead_band.low, fit.dead_band.high, fit.jump.value, fit.jump.low, fit.jump.high,
        fit.excluded_above, verdict.fit.swing, evidence.over_linear, evidence.over_periodic, evidence.steadiness,
    )  # fmt: skip
    return (
        *job,
        *(f"{number:.3f}" for number in true),
        verdict.kind,
        verdict.mode,
        *(f"{number:.3f}" for number in numbers),
    )


def truth(valve: type, loop: object) -> tuple[float, float]:
    """Return dead band and jump of a valve."""
    dead_band, jump = float(loop.dead_band), float(loop.jump)  # type: ignore[attr-defined]
    if valve.__name__ == "Linear":
        return 0.0, 0.0
    if valve.__name__ != "Friction" or jump == 0.0:
        return dead_band, jump
    mass = valve(dead_band, jump, 1.0, 50.0)
    ramp = 50.0 + 0.02 * np.arange(1500)
    moves = np.diff([mass.step(float(signal)) for signal in ramp])
    jumps = moves[moves > 0.2 * jump]
    own = float(jumps.mean())
    return dead_band + jump - own, own


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--out", type=Path, default=OUT)
    options = parser.parse_args()
    if not options.out.exists():
        options.out.write_text(",".join(COLUMNS) + "\n", encoding="utf-8")
    with options.out.open(encoding="utf-8", newline="") as file:
        done = {tuple(row[:5]) for row in csv.reader(file)}
    wanted = [case for case in cases() if tuple(map(str, case)) not in done]
    with ProcessPoolExecutor(options.jobs) as pool:
        for row in pool.map(measured, wanted):
            with options.out.open("a", encoding="utf-8", newline="") as file:
                csv.writer(file, lineterminator="\n").writerow(row)
            print(*row, flush=True)
    with options.out.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    alarms = controls = told = covered = 0
    for row in rows:
        sticks = row["kind"] == "sticks"
        if float(row["S"]) == 0.0:
            controls += 1
            alarms += sticks
        elif sticks:
            told += 1
            covered += float(row["S_low"]) <= float(row["S"]) <= float(row["S_high"])
    print(
        f"{alarms} false alarms of {controls}; {covered} of {told} intervals of the dead band cover the truth"
    )
    return int(alarms > 0.05 * controls or covered < 0.75 * told)


if __name__ == "__main__":
    sys.exit(main())
