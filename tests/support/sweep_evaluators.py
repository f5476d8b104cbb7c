"""Stand-ins for the experiment, importable by name so that other processes find them."""

import os
import signal
import time
import zlib
from pathlib import Path


def quick(changes, *, experiment, joint, seed, trials, compensators, run_settings):
    """Figures that depend on everything that is handed over, without computing anything."""
    told = repr((sorted(changes.items()), experiment, joint, seed, sorted(run_settings.items())))
    size = 1.0 + zlib.crc32(told.encode()) / 2**32
    return {
        f"{t}/{c}/rms_deg": size * (1.0 if c == "off" else 0.3)
        for t in trials
        for c in compensators
    }


def slow(changes, **settings):
    time.sleep(0.5)
    return quick(changes, **settings)


def touches_a_file_and_sleeps(changes, **settings):
    Path("begun").touch()
    time.sleep(600.0)
    return quick(changes, **settings)


def fails_at_scale_2(changes, **settings):
    if changes.get("hysteresis.scale") == 2.0:
        raise ZeroDivisionError("no such\nplant")
    return quick(changes, **settings)


def dies_at_scale_2(changes, **settings):
    if changes.get("hysteresis.scale") == 2.0:
        os.kill(os.getpid(), signal.SIGKILL)
    return quick(changes, **settings)


def tells_its_surroundings(changes, **settings):
    import numpy as np

    return {
        "threads": float(os.environ["OMP_NUM_THREADS"]),
        "deaf": float(signal.getsignal(signal.SIGINT) == signal.SIG_IGN),
        "pid": float(os.getpid()),
        "nan": float(np.nan),
    }
