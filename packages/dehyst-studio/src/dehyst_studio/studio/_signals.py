"""The two signals of a log, thinned for a chart on which a part of it is chosen."""

from __future__ import annotations

import numpy as np

from dehyst.app import ask_progress, print_json
from dehyst.io import inspect_log, read_log
from dehyst.report import kit as report_kit
from dehyst_studio.studio._commands import SignalsRequest


def print_signals(request: SignalsRequest) -> None:
    """Print time, input and output of a run as JSON; extremes of every stretch stay. Without a run: of the first.

    Of a log without time, the number of the sample stands for it.
    """
    with ask_progress("reading"):
        runs = inspect_log(
            request.log,
            request.run,
            time_unit=request.time_unit,
            sheet=request.sheet,
            dt=request.dt,
        ).runs
        run = request.run if request.run is not None or len(runs) < 2 else next(iter(runs))
        rec = read_log(
            request.log, request.input or "", request.output or "", time=request.time, time_unit=request.time_unit,
            run=run, sheet=request.sheet, dt=request.dt,
        )  # fmt: skip
    shown_samples = np.union1d(
        report_kit.thin_series(rec.input), report_kit.thin_series(rec.output)
    )
    clock = np.arange(len(rec), dtype=np.float64) if rec.time is None else rec.time
    print_json(
        {
            "run": run,
            "samples": len(rec),
            "timed": rec.time is not None,
            "time": clock[shown_samples].tolist(),
            "input": rec.input[shown_samples].tolist(),
            "output": rec.output[shown_samples].tolist(),
            "labels": [rec.input_label, rec.output_label],
            "breaks": [float(clock[k]) for k in rec.breaks],
            "findings": [finding.as_dict() for finding in rec.findings],
        }
    )
