"""Makes the example log: Maxwell slip with creep, not the model class that is identified.

A joint of two pneumatic muscles is moved slowly through loops of different size and its pressure difference is
logged. The pressure balances an elastic backbone that stiffens, 40 friction elements whose slip force grows with
pressure, and three viscoelastic branches that relax (creep); both sensors are noisy. Friction at constant pressure
alone would be inside the class that dehyst identifies; pressure dependence, creep and noise are not.
"""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from dehyst.arrays import Array
from dehyst.data import Recording
from dehyst.files import write_atomically
from dehyst.io._write import format_csv

ELEMENTS = 40
SLIP_DISTANCE = (0.2, 16.0)  # angles at which the friction elements begin to slip [deg], log spaced
FRICTION = (
    0.30  # pressure difference that holds all elements back when they slip [bar], about 10 Nm
)
COMPLIANCE = 10.5  # [deg/bar] at 3 bar mean pressure
STIFFENING = 55.0  # angle scale of the backbone's cubic term [deg]
CREEP = (0.06, 0.06, 0.06)  # pressure difference of a branch right after a step of 30 deg [bar]
CREEP_TIME = (4.0, 25.0, 150.0)  # [s]
PERIOD = 12.0  # of one loop [s]
AMPLITUDES = (30.0, 30.0, 24.0, 16.0, 9.0, 20.0, 28.0, 12.0, 30.0, 22.0, 14.0, 26.0)  # [deg]
PRESSURE_NOISE = 0.003  # [bar] rms
ANGLE_NOISE = 0.02  # [deg] rms


def _sweep(rate: float) -> tuple[Array, Array]:
    """Time and angle of loops of different size."""
    time = np.arange(0.0, PERIOD * len(AMPLITUDES), 1.0 / rate)
    loop = np.minimum((time / PERIOD).astype(np.int64), len(AMPLITUDES) - 1)
    return time, np.array(AMPLITUDES)[loop] * np.sin(2 * np.pi * time / PERIOD)


def _friction(angle: Array, backbone: Array) -> Array:
    """Pressure that friction holds back: springs that slip at a force which grows with the pressure."""
    slip = np.geomspace(*SLIP_DISTANCE, ELEMENTS)
    stuck_angle = np.empty(angle.size)
    elongation = np.zeros(ELEMENTS)
    last = 0.0
    for k, (q, p) in enumerate(zip(angle.tolist(), backbone.tolist(), strict=True)):
        limit = slip * (1.0 + 0.15 * abs(p) / 3.0 + 0.10 * p / 3.0)
        elongation = np.clip(elongation + (q - last), -limit, limit)
        stuck_angle[k] = FRICTION * float(np.mean(elongation / slip))
        last = q
    return stuck_angle


def _creep(time: Array, angle: Array) -> Array:
    """Pressure of viscoelastic branches, each c (q - lowpass(q)) with its own time constant."""
    total = np.zeros(angle.size)
    step = float(time[1] - time[0])
    for size, constant in zip(CREEP, CREEP_TIME, strict=True):
        decay = float(np.exp(-step / constant))
        late = 0.0
        for k, q in enumerate(angle.tolist()):
            late = decay * late + (1.0 - decay) * q
            total[k] += size / 30.0 * (q - late)
    return total


def example_recording(seed: int = 0, rate: float = 50.0) -> Recording:
    """Return the example as a recording: pressure difference [bar] -> joint angle [deg].

    Parameters
    ----------
    seed
        Of the sensor noise; the same seed gives the same bits.
    rate
        Samples a second.

    Examples
    --------
    >>> rec = example_recording()
    >>> rec.input_label, rec.output_label, len(rec)
    ('pressure_difference [bar]', 'angle [deg]', 7200)
    """
    random = np.random.default_rng(seed)
    time, angle = _sweep(rate)
    backbone = angle / COMPLIANCE * (1.0 + (angle / STIFFENING) ** 2)
    pressure = backbone + _friction(angle, backbone) + _creep(time, angle)
    return Recording(
        input=np.round(pressure + PRESSURE_NOISE * random.standard_normal(time.size), 5),
        output=np.round(angle + ANGLE_NOISE * random.standard_normal(time.size), 4),
        time=np.round(time, 6),
        name="example",
        input_name="pressure_difference",
        output_name="angle",
        input_unit="bar",
        output_unit="deg",
    )


def example_csv(seed: int = 0) -> str:
    """Return the example log as CSV text, with units in the column names.

    Examples
    --------
    >>> example_csv().partition("\\n")[0]
    'time_s,pressure_difference_bar,angle_deg'
    """
    rec = example_recording(seed)
    time = rec.time if rec.time is not None else np.arange(len(rec))
    return format_csv(
        {"time_s": time, "pressure_difference_bar": rec.input, "angle_deg": rec.output}
    )


def write_example(path: str | os.PathLike[str], seed: int = 0) -> Path:
    """Write the example log as CSV, with units in the column names.

    Examples
    --------
    >>> import tempfile, pathlib
    >>> log = write_example(pathlib.Path(tempfile.mkdtemp()) / "example.csv")
    >>> log.read_text().splitlines()[0]
    'time_s,pressure_difference_bar,angle_deg'
    """
    return write_atomically(path, example_csv(seed))
