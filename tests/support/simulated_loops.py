"""Simulated control loops: those of examples/simulators/valve_loop.py, and a servo with a reference."""

import functools
import runpy

import numpy as np

from places import ROOT

RECORDS = slice(200, None)  # the loop has come to its swing


@functools.cache
def simulator():
    """Return the names of the example."""
    return runpy.run_path(str(ROOT / "examples" / "simulators" / "valve_loop.py"))


def valve_loop(process="flow", valve="kano", **changes):
    """Return columns of a simulated loop after its start; of a test in manual all."""
    names = simulator()
    columns = names["Loop"](names["PROCESSES"][process], valve, **changes).run()
    if "manual" in changes:
        return columns
    return {name: values[RECORDS] for name, values in columns.items()}


def servo_log(noise=0.1, closed=True, samples=3000, proportional=0.3, integral=0.02):
    """Return columns of a servo with a dead band, in closed loop, or with a command that was planned before."""
    rng = np.random.default_rng(0)
    time = 0.01 * np.arange(samples)
    reference = 4.0 * np.sin(0.8 * time) + np.sin(2.1 * time)
    command, measured = np.empty(samples), np.empty(samples)
    u = total = position = 0.0
    for k in range(samples):
        position = min(max(position, u - 0.5), u + 0.5)
        command[k], measured[k] = u, position + noise * rng.normal()
        if closed:
            error = reference[k] - measured[k]
            total += integral * error
            u = proportional * error + total
        else:
            u = reference[k]
    return {
        "time_s": time,
        "reference_mm": reference,
        "command_V": command,
        "measured_mm": measured,
    }
