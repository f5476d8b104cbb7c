"""The Bouc-Wen benchmark of the nonlinear system identification community, generated from its published equations.

Noel and Schoukens, "Hysteretic benchmark with a dynamic nonlinearity", Workshop on Nonlinear System Identification
Benchmarks, Brussels 2016, doi 10.4121/12967592: an oscillator with a Bouc-Wen element, force in, position out, sampled
at 750 Hz and integrated at 15 kHz. Here the integration is a Runge-Kutta scheme of order four instead of Newmark's.

Estimation data are multisines of 8192 samples a period, 5 to 150 Hz, 50 N rms, with output noise of 8e-6 m rms that is
white up to half the sampling rate. Test data have no noise: another multisine in its steady state, and a sine of 40 N
swept from 18 to 52 Hz at 10 Hz a minute (153 000 samples), as zero crossings of the original record show.
"""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from dehyst.arrays import Array
from dehyst.errors import ParameterError
from oscillator import (
    BoucWenFit,
    Choice,
    PeriodicRecord,
    average_periods,
    best,
    identify_bouc_wen,
    identify_duhem_polynomial,
    identify_duhem_table,
    identify_linear,
    identify_maxwell_slip,
)
from oscillator.model import BoucWenOscillator, HystereticOscillator, Oscillator

SYSTEM = BoucWenOscillator(2.0, 10.0, 5e4, 5e4, 1e3, 0.8, -1.1, 1.0)
RATE = 750.0  # [Hz]
PERIOD = 8192  # samples
BAND = (5.0, 150.0)  # [Hz]
FORCE = 50.0  # rms [N]
NOISE = 8e-6  # rms [m]
INTEGRATION_STEPS = 20  # a sample: 15 kHz
SWEEP = (
    40.0,
    18.0,
    10.0 / 60.0,
    153_000,
)  # amplitude [N], first frequency [Hz], rate [Hz/s], samples
# Rms errors on the multisine test [m], from table 1 of Iacob, Szecsi, Beintema, Schoukens and Toth, "Learning Koopman
# models from data under general noise conditions" (2025); the papers that it takes errors from were not at hand.
PUBLISHED = {
    "state-space network (gr-SS-NN)": 7.53e-6,
    "state-space network, improved start": 8.91e-6,
    "polynomial nonlinear state space": 1.34e-5,
    "Koopman, input affine, 100 observables": 1.43e-5,
    "Koopman, general input, 50 observables": 1.59e-5,
    "state-space network": 2.65e-5,
    "Koopman, bilinear, 100 observables": 3.69e-5,
    "Koopman, linear, 50 observables": 1.60e-4,
}


@dataclass(frozen=True)
class BenchmarkTest:
    """Noise-free data that no fit has seen.

    Attributes
    ----------
    name
        "multisine" or "sweep".
    force, output
        (T,). [N], [m]
    periodic
        It is one period of a steady state; otherwise it starts at rest.
    """

    name: str
    force: Array
    output: Array
    periodic: bool

    def error(self, oscillator: Oscillator) -> float:
        """Return the rms error of a simulation, nothing of the measured output given to it. [m]"""
        answer = oscillator.simulate(
            self.force, np.arange(self.force.size) / RATE, periodic=self.periodic
        )
        return float(np.sqrt(np.mean((answer - self.output) ** 2)))


def multisine(seed: int, *, samples: int = PERIOD, rms: float = FORCE) -> Array:
    """Return one period of a multisine, every line of the band with the same amplitude and a random phase. [N]

    Parameters
    ----------
    seed
        Of the phases; the same numbers on every machine.
    samples
        A period at 750 Hz; at least 150 so that the band holds a line.
    rms
        Of the force. [N]

    Raises
    ------
    ParameterError
        Too few samples.

    Examples
    --------
    >>> round(float(np.sqrt(np.mean(multisine(1) ** 2))), 9)
    50.0
    """
    if samples < 150:
        raise ParameterError(
            f"samples = {samples}: below 150 a period is shorter than one cycle of 5 Hz."
        )
    frequency = np.fft.rfftfreq(samples, 1.0 / RATE)
    excited = (frequency >= BAND[0]) & (frequency <= BAND[1])
    spectrum = np.zeros(frequency.size, dtype=complex)
    spectrum[excited] = np.exp(2j * np.pi * np.random.default_rng(seed).random(int(excited.sum())))
    force = np.fft.irfft(spectrum, samples)
    force *= rms / np.sqrt(np.mean(force**2))
    return np.asarray(force, dtype=np.float64)


def sweep(samples: int = SWEEP[3]) -> Array:
    """Return the swept sine of the test from its start, (samples,). [N]"""
    time = np.arange(samples) / RATE
    force: Array = SWEEP[0] * np.sin(2 * np.pi * (SWEEP[1] * time + 0.5 * SWEEP[2] * time**2))
    return force


def measure(
    seed: int,
    *,
    periods: int = 5,
    samples: int = PERIOD,
    noise: float = NOISE,
    system: Oscillator = SYSTEM,
) -> PeriodicRecord:
    """Return an averaged estimation record: `periods` of a multisine from rest, noise added, the first one left out.

    Parameters
    ----------
    seed
        Of the multisine's phases and of the noise.
    periods
        At least two.
    samples
        A period.
    noise
        Rms of the output noise. [m]
    system
        What is measured.
    """
    force = np.tile(multisine(seed, samples=samples), periods)
    time = np.arange(force.size) / RATE
    answer = system.simulate(force, time, steps=INTEGRATION_STEPS)
    disturbed = answer + noise * np.random.default_rng([seed, 1]).standard_normal(answer.size)
    return average_periods(force, disturbed, samples, 1.0 / RATE)


def held_out_records(
    *, samples: int = PERIOD, swept: int = SWEEP[3], seed: int = 2016, system: Oscillator = SYSTEM
) -> list[BenchmarkTest]:
    """Return the multisine and the sweep of the test, without noise.

    Parameters
    ----------
    samples
        Period of the multisine.
    swept
        Samples of the sweep.
    seed
        Of the multisine: not one of the estimation's.
    system
        What is tested.
    """
    found = []
    for name, force, periodic in (
        ("multisine", multisine(seed, samples=samples), True),
        ("sweep", sweep(swept), False),
    ):
        time = np.arange(force.size) / RATE
        found.append(
            BenchmarkTest(
                name,
                force,
                system.simulate(force, time, periodic=periodic, steps=INTEGRATION_STEPS),
                periodic,
            )
        )
    return found


@dataclass(frozen=True)
class Row:
    """A model in the table of results.

    Attributes
    ----------
    model
        Name.
    kind
        "white box", "black box" or "baseline".
    parameters
        How many were identified.
    errors
        Rms error on each test, by its name. [m]
    seconds
        Time of the identification.
    oscillator
        The model.
    details
        What else the identification found.
    """

    model: str
    kind: str
    parameters: int
    errors: dict[str, float]
    seconds: float
    oscillator: Oscillator
    details: dict[str, Any]


def describe(fit: BoucWenFit) -> dict[str, Any]:
    """Return values, standard errors and the correlation of stiffness and alpha as plain numbers."""
    return {
        "values": fit.values,
        "standard_errors": fit.standard_errors,
        "correlation_of_stiffness_and_alpha": float(fit.correlation[2, 3]),
    }


Found = tuple[
    str, str, int, Oscillator, dict[str, Any]
]  # name, kind, number of parameters, model, details


def identified(records: Sequence[PeriodicRecord], held_out: PeriodicRecord) -> Iterator[Found]:
    """Yield every model of the table, identified from records; the held-out one chooses between resolutions."""
    yield "linear", "baseline", 3, identify_linear(records), {}
    for name, dependent in (("maxwell-slip", False), ("maxwell-slip, position dependent", True)):
        slip = identify_maxwell_slip(records, position_dependent=dependent)
        yield name, "black box", slip.parameters.size, slip.oscillator, {"estimation": slip.rms}
    polynomials = identify_duhem_polynomial(records, held_out)
    yield _chosen("duhem, polynomial", "degree", polynomials)
    start = best(polynomials).fit.oscillator
    assert isinstance(start, HystereticOscillator)
    yield _chosen(
        "duhem, piecewise linear", "knots", identify_duhem_table(records, held_out, start)
    )
    white = identify_bouc_wen(records)
    details = {"estimation": white.fit.rms, **describe(white)}
    yield "bouc-wen", "white box", white.fit.parameters.size, white.oscillator, details


def _chosen(name: str, size: str, choices: Sequence[Choice]) -> Found:
    """The resolution with the smallest error on the held-out record, and the errors of the others."""
    fit = best(choices).fit
    tried = {str(choice.size): choice.validation for choice in choices}
    details = {"estimation": fit.rms, size: best(choices).size, "validation": tried}
    return name, "black box", fit.parameters.size, fit.oscillator, details


def run(
    *, estimation: int = 2, periods: int = 5, seed: int = 1, samples: int = PERIOD, swept: int = SWEEP[3],
    report: Callable[[Row], None] | None = None,
) -> list[Row]:  # fmt: skip
    """Identify every model from noisy multisines and score it on the tests.

    Parameters
    ----------
    estimation
        Multisines that are fitted; one more chooses between resolutions.
    periods
        Of each, the first of which is left out.
    seed
        Of the first multisine; the others follow.
    samples
        A period.
    swept
        Samples of the sweep.
    report
        Called with each row when it is there.
    """
    records = [measure(seed + j, periods=periods, samples=samples) for j in range(estimation + 1)]
    scored = held_out_records(samples=samples, swept=swept)
    rows = []
    begin = clock.perf_counter()
    for name, kind, parameters, oscillator, details in identified(records[:-1], records[-1]):
        seconds = clock.perf_counter() - begin
        errors = {test.name: test.error(oscillator) for test in scored}
        rows.append(Row(name, kind, parameters, errors, seconds, oscillator, details))
        if report:
            report(rows[-1])
        begin = clock.perf_counter()
    return rows
