"""Files of cores: read back by parsers of their own, run in ngspice; what the command writes and refuses."""

import json
import math
import re
import shutil

import numpy as np
import pytest

from dehyst.errors import OutputError
from dehyst.io import write_csv
from dehyst_targets.magnetics import (
    Chan,
    JilesAtherton,
    Tellinen,
    core_file,
    run_ngspice,
)
from dehyst_targets.magnetics._command import _plain_number
from dehyst_targets.magnetics._models import CoreFit
from simulated_loops import core_loop

MU_0 = 4e-7 * math.pi
SOFT = JilesAtherton(3.5e5, 15.0, 20.0, 0.1, 5e-5)


def fitted(key, model):
    return {
        key: CoreFit(key, model, 0.0, 0.0, math.nan),
        "chan": CoreFit("chan", Chan(20.0, 0.2, 0.4), 0.0, 0.0, 0.0),
    }


def numbers(text, names):
    values = {}
    for name in names:
        values[name] = float(re.search(rf"\b{name}=([-+.\deE]+)", text)[1])
    return values


def test_ltspice_reads_hc_br_and_bs_in_si():
    text = core_file(fitted("chan", Chan(20.0, 0.2, 0.4)), "ltspice", "my core")
    assert ".subckt my_core 1 2" in text
    line = next(row for row in text.splitlines() if row.startswith("L1"))
    assert numbers(line, ("Hc", "Br", "Bs")) == {"Hc": 20.0, "Br": 0.2, "Bs": 0.4}


def test_pspice_reads_level_2_in_ampere_a_metre():
    model = JilesAtherton(3e5, 20.0, 12.0, 0.3, pspice=True)
    card = next(
        row
        for row in core_file(fitted("pspice", model), "pspice", "3C90").splitlines()
        if row[0] == "."
    )
    assert card.startswith(".MODEL core_3C90 CORE (LEVEL=2 ")
    assert numbers(card, ("MS", "A", "K", "C")) == {"MS": 3e5, "A": 20.0, "K": 12.0, "C": 0.3}
    assert "ALPHA" not in card


def test_tables_of_modelica_are_the_polarisation_of_both_branches():
    h = 300.0 * np.sin(np.linspace(-0.5 * np.pi, 1.5 * np.pi, 1201))
    b = (
        0.4 * np.tanh((h - 20.0 * np.cos(np.linspace(-0.5 * np.pi, 1.5 * np.pi, 1201))) / 40.0)
        + MU_0 * h
    )
    text = core_file(fitted("tellinen", Tellinen.of(h, b)), "modelica", "N87")
    assert text.rstrip().endswith("end N87;")
    tables = {}
    for name, body in re.findall(r"(tab\w+)=\[([^\]]*)\]", text):
        tables[name] = np.array(
            [[float(cell) for cell in row.split(",")] for row in body.split(";")]
        )
    rising, falling = tables["tabris"], tables["tabfal"]
    for table, part in ((rising, slice(0, 601)), (falling, slice(600, None))):
        assert np.all(np.diff(table[:, 0]) > 0.0)
        assert table[0, 0] == -table[-1, 0] == -1e7
        polarisation = np.interp(h[part], *table.T)
        assert np.abs(polarisation + MU_0 * h[part] - b[part]).max() < 0.005 * np.ptp(b)
    assert np.all(np.interp(h, *falling.T) >= np.interp(h, *rising.T))


@pytest.mark.parametrize("form", ["ltspice", "modelica"])
def test_a_loop_beside_zero_is_no_core_of_a_limiting_loop(form):
    fits = {"tellinen": CoreFit("", Tellinen(np.zeros(1), np.zeros(1), np.zeros(1)), 0.0, 0.0, 0.0)}
    with pytest.raises(OutputError, match="--format ngspice"):
        core_file(fits, form, "core")


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("ngspice") is None, reason="ngspice is not installed")
def test_ngspice_runs_the_core_as_it_is_simulated_here():
    fits = fitted("jiles-atherton", SOFT)
    h = np.interp(
        np.arange(801), [0, 200, 300, 400, 500, 800], [0.0, 150.0, 20.0, 90.0, -30.0, 120.0]
    )
    b = SOFT.simulate(h, 0.0)
    difference = run_ngspice(core_file(fits, "ngspice", "core"), fits["jiles-atherton"], h, b)
    assert difference < 2e-3


@pytest.fixture
def core_csv(tmp_path):
    return write_csv(tmp_path / "core.csv", core_loop())


@pytest.mark.slow
def test_the_command_prints_json_and_writes_by_the_ending(run, core_csv, tmp_path):
    out, picture = tmp_path / "core.mo", tmp_path / "core.svg"
    status, printed, _ = run(
        "magnet", str(core_csv), "--json", "--out", str(out), "--figure", str(picture)
    )
    figures = json.loads(printed)
    assert status == 0
    assert figures["format"] == "dehyst-magnet"
    assert figures["written"]["format"] == "modelica"
    assert "not run" in figures["written"]["verified"]
    assert out.read_text().startswith("// dehyst")
    assert "measured" in picture.read_text()
    status, _, printed = run("magnet", str(core_csv), "--out", str(core_csv.with_name("core.csv")))
    assert status == 2
    assert core_csv.read_text().startswith("time_s")


def test_an_unknown_simulator_is_refused_before_anything_is_read(run, tmp_path):
    status, _, err = run("magnet", str(tmp_path / "core.csv"), "--out", str(tmp_path / "core.xyz"))
    assert status == 2
    assert "--format" in err
    status, _, err = run("magnet", str(tmp_path / "core.csv"), "--format", "pspice")
    assert status == 2
    assert "--out" in err


@pytest.mark.parametrize(("value", "words"), [(-123.4, "-120"), (0.0412, "+0.041"), (7.0, "+7")])
def test_percents_are_plain_numbers(value, words):
    assert _plain_number(value, 2, sign=True) == words


@pytest.mark.slow
def test_a_core_of_one_size_of_loop_has_no_row_of_a_smallest_one(run, core_csv):
    status, printed, _ = run("magnet", str(core_csv), "--symmetric")
    assert status == 0
    assert "smallest" not in printed
    assert "e+" not in printed
    assert "--symmetric" in printed.partition("next:")[2]
