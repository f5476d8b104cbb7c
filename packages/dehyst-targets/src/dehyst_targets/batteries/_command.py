"""dehyst battery: branches and decay rate of an open-circuit voltage, errors, the file for PyBaMM, a picture."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from dehyst.app import (
    ask_progress,
    print_end,
    print_findings,
    print_json,
    refuse_clashes,
    refuse_existing,
    table,
)
from dehyst.app import kit as app_kit
from dehyst.data import Recording
from dehyst.errors import DehystError, OutputError
from dehyst.files import write_atomically
from dehyst.identification import identify
from dehyst.report import PageFigure, Panel, PanelLine, chart
from dehyst.report import kit as report_kit
from dehyst.shell import command, visible
from dehyst_targets.batteries._fit import OcvFit, fit_ocv
from dehyst_targets.batteries._ocv import OcvLog, read_ocv
from dehyst_targets.batteries._requests import BatteryRequest
from dehyst_targets.batteries._write import pybamm_file
from dehyst_targets.commands import reading_options, refuse_picture

TITLE = "dehyst battery: "  # by which a picture is known that may be drawn anew
SHARE = (
    0.7  # of the log that dehyst identify is fitted to; a share must be left to choose its model by
)


def run_battery(request: BatteryRequest) -> None:
    """Read, fit, write, print."""
    refuse_clashes([request.log], True, out=(request.out, None), figure=(request.figure, None))
    refuse_picture(request.figure, TITLE, request.overwrite)
    with ask_progress("reading", request.json):
        log = read_ocv(
            request.log,
            charge=request.charge,
            voltage=request.voltage,
            stoichiometry=request.stoichiometry,
            **reading_options(request),
        )
    with ask_progress("fitting", request.json):
        fit = fit_ocv(log, decay=request.decay)
        default = default_error(log)
    findings = (*log.findings, *fit.findings)
    useless = [finding.message for finding in fit.findings if finding.code == "ocv-no-gain"]
    if request.out is not None and useless:
        raise OutputError(useless[0])
    if request.out is not None:
        state = fit.start(float(log.x[0]), float(log.voltage[0]))
        about = f"From {visible(log.name)}; rms {1e3 * fit.error:.2g} mV."
        text = pybamm_file(
            fit, request.electrode, state, about.replace('"', "'").replace("\\", "/")
        )
        refuse_existing(request.out, request.overwrite, content=text)
        write_atomically(request.out, text)
    if request.figure is not None:
        write_ocv_figure(request.figure, log, fit)
    if request.json:
        print_json({
            "format": "dehyst-battery",
            "decay_rates": fit.rates and dict(zip(("lithiation", "delithiation"), fit.rates, strict=True)),
            "gap_V": float(np.max(fit.delithiation - fit.lithiation)),
            "rms_V": {name: value if math.isfinite(value) else None for name, value in _errors(fit, default)},
            "minor_rms_V": fit.minor_error if math.isfinite(fit.minor_error) else None,
            "warnings": [finding.as_dict() for finding in findings],
        })  # fmt: skip
        return
    _print(log, fit, default, request)
    print_findings(findings)
    following = ""
    if request.out is None and not useless:
        more: dict[str, Any] = {"decay": request.decay}
        if fit.rates is None:
            more["decay"] = 50.0
        following = command(
            "battery", request.log, charge=request.charge, voltage=request.voltage, **more, out="ocv_parameters.py"
        )  # fmt: skip
    print_end(following, picture=request.figure, parameters=request.out)


def default_error(log: OcvLog) -> float:
    """Rms over the whole log of what `dehyst identify` takes by default, NaN where it refuses the log. [V]"""
    record = Recording(
        log.x, log.voltage, name=log.name, input_name="x", output_name="U", output_unit="V"
    )
    try:
        modelled = identify(record, train_fraction=SHARE).model.simulate(log.x)
    except DehystError:
        return math.nan
    return float(np.sqrt(np.mean((modelled - log.voltage) ** 2)))


def _errors(fit: OcvFit, default: float) -> list[tuple[str, float]]:
    return [
        ("one_state", fit.error),
        ("default", default),
        ("without_hysteresis", fit.middle_error),
    ]


def _print(log: OcvLog, fit: OcvFit, default: float, request: BatteryRequest) -> None:
    out = app_kit.terminal()
    widest = int(np.argmax(fit.delithiation - fit.lithiation))
    gap = 1e3 * float(fit.delithiation[widest] - fit.lithiation[widest])
    out.print(
        f"{visible(log.name)}: branches up to {gap:.1f} mV apart, at x = {fit.x[widest]:.2f}",
        style="bold",
    )
    if fit.rates is not None:
        lengths = [2.0 / rate for rate in fit.rates]
        out.print(
            f"decay rates {fit.rates[0]:.3g} in lithiation, {fit.rates[1]:.3g} in delithiation: after a turn the "
            f"voltage is on the other branch to 1/e over {lengths[0]:.2g} and {lengths[1]:.2g} of x",
            soft_wrap=True,
        )
    out.print()
    names = (
        "one-state hysteresis (PyBaMM)",
        f"default of dehyst identify, {100.0 * SHARE:g} % fitted",
        "curve without hysteresis",
    )
    rows = []
    for name, (_, error) in zip(names, _errors(fit, default), strict=True):
        rows.append((name, f"{1e3 * error:.2f}" if math.isfinite(error) else "unknown"))
    if math.isfinite(fit.minor_error):
        rows.append(("one-state, partial cycles alone", f"{1e3 * fit.minor_error:.2f}"))
    out.print(table(("rms over the log", ">mV"), rows))
    if request.out is not None:
        out.print(
            f"{request.electrode} electrode, PyBaMM 25.10 or newer; it was not run in PyBaMM here",
            soft_wrap=True,
        )


def write_ocv_figure(path: Path, log: OcvLog, fit: OcvFit) -> Path:
    """Write the picture of a log, its branches and what the model leaves, ``.svg`` or ``.png``.

    Raises
    ------
    OutputError
        If the ending is another one, or the file cannot be written.
    """
    lines = [
        PanelLine(log.x, log.voltage, report_kit.DATA, "measured", width=0.8),
        PanelLine(fit.x, fit.lithiation, report_kit.TRAIN, "lithiation"),
        PanelLine(fit.x, fit.delithiation, report_kit.TEST, "delithiation"),
    ]
    panels = [
        Panel(
            "Branches",
            chart("x in the electrode", "U [V]", lines),
            "Measured voltage and both branches.",
        )
    ]
    minor = np.flatnonzero(log.minor)
    if fit.rates is not None and minor.size:
        part = slice(int(minor[0]), int(minor[-1]) + 1)
        modelled = fit.simulate(log.x, fit.start(float(log.x[0]), float(log.voltage[0])))
        two = [
            PanelLine(log.x[part], log.voltage[part], report_kit.DATA, "measured", width=2.0),
            PanelLine(log.x[part], modelled[part], report_kit.MODEL, "one-state"),
        ]
        panels.append(
            Panel(
                "Partial cycles",
                chart("x in the electrode", "U [V]", two),
                "Partial cycles and model.",
            )
        )
    figure = PageFigure("battery", "open-circuit voltage", log.name, tuple(panels))
    return report_kit.write_picture(figure, path, f"{TITLE}{log.name}", headed=True)
