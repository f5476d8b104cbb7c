"""Claims about the pair that inspect proposes, on logs whose input and output are known, among columns that mislead."""

import numpy as np
import pytest
import scipy.io

from dehyst.io import inspect_log
from export_samples import play_model

PLAYS = play_model()
PAIRS = [
    ("pressure_bar", "angle_deg"), ("Pressure [kPa]", "Tilt [rad]"), ("voltage_v", "displacement_um"),
    ("U [V]", "x [um]"), ("Current (A)", "Force (N)"), ("angle_cmd_deg", "angle_deg"),
    ("desired_pos_mm", "actual_pos_mm"), ("Temperature", "Strain"), ("Temperature (C)", "Strain (mm)"),
    ("Temp [degC]", "Elongation [mm]"), ("OP", "PV"), ("valve", "flow"), ("OP", "Flow (m3/h)"),
    ("displacement_mm", "force_N"), ("Position [mm]", "Kraft [N]"), ("u", "y"), ("input", "output"), ("a", "b"),
    ("M1", "thf"), ("H [A/m]", "B [T]"), ("Druck_bar", "Winkel_deg"), ("suction head (cm)", "water content"),
    ("Spannung [V]", "Weg [um]"), ("soll_winkel_deg", "ist_winkel_deg"), ("displacement_mm", "torque_Nm"),
    ("x_mm", "contraction_mm"),
]  # fmt: skip


def log(seed):
    """Columns of a log in any order, the names of input and output, and those of their copies."""
    rng = np.random.default_rng(seed)
    x_name, y_name = PAIRS[seed % len(PAIRS)]
    n = int(rng.choice([300, 1500]))
    t = 0.05 * np.arange(n)
    x = np.sin(np.arange(n) * 2 * np.pi * rng.uniform(1.5, 6.0) / n) * np.linspace(
        1.0, rng.uniform(0.4, 1.0), n
    )
    y = PLAYS.simulate(x)
    if y_name in ("force_N", "Kraft [N]", "torque_Nm"):
        y = 4.0 * x - y  # a force leads its motion
    y = (y + 1e-3 * rng.normal(size=n)) * rng.choice([1.0, 30.0])
    x = x * rng.choice([1.0, 5.0, 100.0]) + rng.choice([0.0, 3.0])
    first, last = x_name.split()[0], y_name.split()[0].split("_")[0]
    slow = 22.0 + 0.05 * rng.normal(size=n) + np.linspace(0.0, 1.0, n)
    others = {
        "counter": np.arange(n), "sample_no": np.arange(n) + 17.0, f"{last} %": 100.0 * y,
        f"{first}_raw": 1.02 * x + 0.5, "noise": rng.normal(size=n), "temp_C": slow,
        "ambient temperature": 22.0 + 0.01 * np.cumsum(rng.normal(size=n)), "load": 100.0 + 0.5 * rng.normal(size=n),
        "status": np.ones(n), "Load_N": 50.0 + 0.3 * rng.normal(size=n), "velocity_mm_s": np.gradient(y),
        "second": 0.05 * y + 1e-3 * rng.normal(size=n), f"filtered_{last}": np.convolve(y, np.ones(5) / 5.0, "same"),
    }  # fmt: skip
    chosen = rng.choice(list(others), rng.integers(0, 5), replace=False)
    columns = {x_name: x, y_name: y} | {name: others[name] for name in chosen}
    if x_name == "OP":
        columns["SP"] = 0.9 * np.roll(x, -5) + 0.01 * rng.normal(size=n)
    names = list(columns)
    if rng.random() < 0.5:
        names = [names[k] for k in rng.permutation(len(names))]
    table = {"time_s": t} if rng.random() < 0.7 else {}
    outputs = {y_name, f"{last} %", f"filtered_{last}", "second"}
    return table | {name: columns[name] for name in names}, {x_name, f"{first}_raw"}, outputs


def write(path, columns):
    rows = zip(*columns.values(), strict=True)
    lines = [",".join(columns), *(",".join(f"{value:.6g}" for value in row) for row in rows)]
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.mark.parametrize("seeds", [range(26), pytest.param(range(26, 312), marks=pytest.mark.slow)])
def test_the_true_pair_is_proposed_or_the_doubt_is_said(tmp_path, seeds):
    wrong, unsure = [], []
    for seed in seeds:
        columns, inputs, outputs = log(seed)
        found = inspect_log(write(tmp_path / "log.csv", columns))
        if found.input in inputs and found.output in outputs:
            continue
        (unsure if found.doubt else wrong).append((seed, found.input, found.output))
    assert not wrong
    assert len(unsure) <= 0.03 * len(seeds)


T = np.concatenate(
    [np.linspace(300.0, 40.0, 150), np.linspace(40.0, 300.0, 150), np.linspace(300.0, 120.0, 100)]
)
FALLS = np.arange(400) % 300 < 150
STRAIN = 1.0 / (1.0 + np.exp((T - np.where(FALLS, 140.0, 170.0)) / 8.0))


@pytest.mark.parametrize(
    ("columns", "pair"),
    [
        (
            {"Temperature": T, "Strain_p": 100 * STRAIN, "Strain": STRAIN},
            ("Temperature", "Strain_p"),
        ),
        ({"Strain": STRAIN, "Temperature": T}, ("Temperature", "Strain")),
        (
            {"Crosshead": 0.05 * STRAIN, "Strain": STRAIN + 0.001 * np.sin(T), "Temperature": T},
            ("Temperature", None),
        ),
    ],
)
def test_copies_and_outputs_are_no_pair(tmp_path, columns, pair):
    found = inspect_log(write(tmp_path / "log.csv", columns))
    assert found.input == pair[0]
    assert pair[1] in (None, found.output)
    assert bool(found.doubt) == (len(columns) > 2)


def test_a_set_point_is_not_the_input_where_a_controller_drives(tmp_path):
    wave = np.sin(np.arange(600) / 40)
    columns = {"SP": wave, "OP": np.roll(PLAYS.simulate(wave), 3), "PV": np.roll(wave, 8)}
    found = inspect_log(write(tmp_path / "log.csv", columns))
    assert (found.input, found.output) == ("OP", "PV")


def test_two_columns_that_cannot_tell_the_direction_say_so(tmp_path, run):
    log = write(tmp_path / "log.csv", {"M1": np.tanh(T / 100.0), "thf": T / 1e4})
    found = inspect_log(log)
    assert {found.input, found.output} == {"M1", "thf"}
    assert "do not tell which of" in found.doubt
    assert "not sure: names and units" in " ".join(run("inspect", log)[1].split())


def test_columns_of_different_lengths_are_no_pair(tmp_path):
    path = tmp_path / "rows.mat"
    scipy.io.savemat(
        path, {"M1": np.tanh(T / 100.0), "Rd": np.linspace(0.9, 1.0, 20), "thf": T / 1e4}
    )
    found = inspect_log(path)
    assert {found.input, found.output} == {"M1", "thf"}
    assert found.command


def test_where_nothing_can_be_read_together_the_next_step_can_be_taken(tmp_path, run):
    log = write(
        tmp_path / "log.csv",
        {
            "time_s": np.random.default_rng(0).permutation(400),
            "pressure_bar": T,
            "angle_deg": STRAIN,
        },
    )
    _, out, _ = run("inspect", log)
    assert "next: name two columns that can be read together" in " ".join(out.split())
