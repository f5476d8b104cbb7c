"""A cure that names an option is executed on the log that raised it, and removes the finding."""

import re
import shlex

import numpy as np
import pytest
from typer.testing import CliRunner

import dehyst
from dehyst.cli import app
from dehyst.design import design_excitation


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


def logged(folder, name, line):
    """Run what design wrote on the rig, and log it; returns the line that design printed for it."""
    words = shlex.split(line)[1:]
    done = CliRunner().invoke(app, [*words, "--period", "0.04", "--out", str(folder / "motion.csv"), "--overwrite"])
    assert done.exit_code == 0, done.output
    time, command = np.loadtxt(folder / "motion.csv", delimiter=",", skiprows=1, usecols=(0, 1), unpack=True)
    y = creeping(command, time)
    np.savetxt(
        folder / name, np.column_stack([time, command, y]), delimiter=",", header="time_s,volt,angle", comments=""
    )
    said = next(each for each in done.output.splitlines() if each.startswith("dehyst identify"))
    return said.replace("LOG", name).replace("--input COLUMN --output COLUMN", "--input volt --output angle")


def warnings_of(folder, line, monkeypatch):
    monkeypatch.chdir(folder)
    done = CliRunner().invoke(app, [*shlex.split(line)[1:], "--family", "creep-pi"])
    assert done.exit_code == 0, done.output
    return " ".join(done.output.split())


@pytest.mark.slow
def test_a_rest_that_is_asked_for_is_planned_and_ends_the_guess(tmp_path, monkeypatch):
    first = logged(tmp_path, "log.csv", "dehyst design --range 0 5 --time-limit 300")
    said = warnings_of(tmp_path, first, monkeypatch)
    cure = re.search(r"creep-beyond-rests: .*?`(dehyst design [^`]*)`", said)
    assert cure, said
    second = logged(tmp_path, "log2.csv", cure[1])
    assert "creep-beyond-rests" not in warnings_of(tmp_path, second, monkeypatch)


@pytest.mark.parametrize("hold", [5.0, 80.0, 400.0])
def test_design_rests_as_long_as_was_asked_for(hold):
    plan = design_excitation(-1.0, 1.0, hold=hold, time_limit=2000.0)
    assert max(plan.hold_s) >= hold
    with pytest.raises(dehyst.DehystError) as refused:
        design_excitation(-1.0, 1.0, hold=hold, time_limit=hold)
    enough = refused.value.facts["needed"]
    try:
        plan = design_excitation(-1.0, 1.0, hold=hold, time_limit=enough)
    except dehyst.DehystError as again:
        plan = design_excitation(-1.0, 1.0, hold=hold, time_limit=again.facts["needed"])
    assert max(plan.hold_s) >= hold


@pytest.mark.slow
def test_a_unit_that_cannot_keep_its_period_is_said_and_what_helps_helps(tmp_path):
    time = np.arange(3000) * 1e-4
    x = np.sin(40.0 * time) * np.linspace(1.0, 0.3, time.size)
    rec = dehyst.Recording(input=x, output=creeping(x, time, (0.01, 0.1)), time=time)
    dehyst.identify(rec, "creep-pi").model.save(tmp_path / "m.json")

    def export(*more):
        words = [
            "export",
            str(tmp_path / "m.json"),
            "--target",
            "c",
            "--out",
            str(tmp_path / "c"),
            "--overwrite",
            *more,
        ]
        done = CliRunner().invoke(app, words)
        assert done.exit_code == 0, done.output
        return " ".join(done.output.split())

    said = export("--period", "0.0001")
    assert "step-exceeds-period" in said and "cortex-m4f at 168 MHz" in said
    cure = re.search(r"(--period [\d.e-]+|--real float)(?=[,)])", said.split("step-exceeds-period")[1])[1]
    assert "step-exceeds-period" not in export(
        *(cure.split() if "period" in cure else ["--period", "0.0001", *cure.split()])
    )
