"""What tests of several families need: signals, plays by their definition, and the checks that all families pass."""

import csv
import gzip

import numpy as np
import pytest

from dehyst import Recording, identify
from places import DATA

measured = pytest.mark.skipif(
    not DATA.is_dir(), reason=f"no measured logs in ../{DATA.parent.name}"
)


def wander(samples=1500, seed=1, reach=1.0):
    """A signal of strokes of many lengths within -reach .. reach."""
    rng = np.random.default_rng(seed)
    turns = np.concatenate([[0.0, 1.0, -1.0], rng.uniform(-1.0, 1.0, 25)])
    return reach * np.interp(
        np.linspace(0.0, turns.size - 1.0, samples), np.arange(turns.size), turns
    )


def uneven(samples=1500, seed=2, step=0.01):
    """Time stamps with steps from half to one and a half of the mean one."""
    return np.cumsum(step * np.random.default_rng(seed).uniform(0.5, 1.5, samples))


def plays(x, thresholds, start):
    """Play operators, (T, n), thresholds (n,) or (T, n); by definition."""
    r = np.broadcast_to(thresholds, (len(x), np.shape(thresholds)[-1]))
    z, rows = np.array(start, dtype=float), []
    for k, value in enumerate(x):
        z = np.maximum(value - r[k], np.minimum(value + r[k], z))
        rows.append(z)
    return np.array(rows)


def round_trip(model, x, time=None):
    """Largest error of the inverse after the model."""
    back = model.inverse().simulate(model.simulate(x, time), time)
    return float(np.max(np.abs(back - x)))


def same_in_parts(model, x, dt=None):
    """Whether forward and backward runs in three parts are those in one, bit for bit."""
    for run, signal in ((model.run, x), (model.run_inverse, model.run(x, dt, model.rest(x[0]))[0])):
        whole, memory = run(signal, dt, model.rest(x[0]))
        at, pieces = model.rest(x[0]), []
        for part in (slice(0, 1), slice(1, 700), slice(700, None)):
            piece, at = run(
                np.ascontiguousarray(signal[part]), None if dt is None else dt[part].copy(), at
            )
            pieces.append(piece)
        if not (np.array_equal(np.concatenate(pieces), whole) and np.array_equal(at, memory)):
            return False
    return True


def steps_like_arrays(model, x, time=None):
    """Whether a stepper gives what `simulate` gives, both ways."""
    periods = np.zeros(x.size) if time is None else np.diff(time, prepend=time[:1])
    for which in (model, model.inverse()):
        signal = x if which is model else model.simulate(x, time)
        step = which.stepper()
        one = np.array([step(value, period) for value, period in zip(signal, periods, strict=True)])
        if not np.array_equal(one, which.simulate(signal, time)):
            return False
    return True


def noisy(model, noise=0.003, seed=3, samples=3000, step=0.01):
    """Recording of a model with noise on its output."""
    x = wander(samples, seed)
    time = step * np.arange(samples)
    y = model.simulate(x, time)
    return Recording(
        input=x, output=y + noise * np.random.default_rng(seed).standard_normal(samples), time=time
    )


def log(folder, run, x, y, begin=0.0):
    """A run of a measured log."""
    with gzip.open(DATA / folder / "data.csv.gz", "rt") as file:
        rows = [
            row
            for row in csv.DictReader(file)
            if row["run"] == run and float(row["time_s"]) >= begin
        ]
    columns = (np.array([float(row[name]) for row in rows]) for name in (x, y, "time_s"))
    return Recording(**dict(zip(("input", "output", "time"), columns, strict=True)))


def held_out(recording, family):
    """Held-out error of a family, percent of range."""
    return identify(recording, family).test.rmse_percent


TENDON = ("tendon_sheath_joint", "config_000", "angle_cmd_deg", "angle_deg")
PIEZO = ("piezo_dbo", "test", "voltage_v", "displacement_um", 2.0)
ARM = ("pneumatic_arm_segment", "oct28_exp5", "pressure_interp_psi", "tilt_rad", 12.0)
CAVATAPPI = ("cavatappi_muscle", "400g_s3_t1", "pressure_psi", "displacement_mm")
DAMPER = ("mr_damper", "ensaio1.2", "displacement_mm", "force_N")
