"""dehyst magnet: figures of a measured core, errors of its models, the file of a simulator, a picture."""

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
from dehyst.errors import OutputError, ParameterError
from dehyst.files import write_atomically
from dehyst.report import PageFigure, Panel, PanelLine, chart
from dehyst.report import kit as report_kit
from dehyst.shell import command, visible
from dehyst_targets.commands import reading_options, refuse_picture
from dehyst_targets.magnetics._loop import Core, read_core
from dehyst_targets.magnetics._models import CoreFit, fit_core
from dehyst_targets.magnetics._requests import MagnetRequest
from dehyst_targets.magnetics._write import FORMATS, core_file, format_named, run_ngspice

TITLE = "dehyst magnet: "  # by which a picture is known that may be drawn anew
COLOURS = {
    "jiles-atherton": report_kit.MODEL,
    "tellinen": report_kit.TEST,
    "chan": report_kit.MUTED,
}


def run_magnet(request: MagnetRequest) -> None:
    """Read, fit, write, print."""
    refuse_clashes([request.log], True, out=(request.out, None), figure=(request.figure, None))
    refuse_picture(request.figure, TITLE, request.overwrite)
    form = None
    if request.out is None and request.format is not None:
        raise ParameterError(
            f"--format {request.format:.20} names a simulator, and no file is written for it. Add --out core.lib."
        )
    if request.out is not None:
        form = format_named(request.format, request.out)
    with ask_progress("reading", request.json):
        core = read_core(
            request.log,
            field=request.field,
            density=request.density,
            field_unit=request.field_unit,
            density_unit=request.density_unit,
            symmetric=request.symmetric,
            **reading_options(request),
        )
    with ask_progress("fitting cores", request.json):
        fits = fit_core(core)
    written: dict[str, Any] = {}
    if request.out is not None and form is not None:
        written = _write(core, fits, form, request.out, request.overwrite)
    if request.figure is not None:
        write_core_figure(request.figure, core, fits)
    if request.json:
        print_json(_plain(core, fits, written))
    else:
        _print(core, fits, written, request)


def _write(
    core: Core, fits: dict[str, CoreFit], form: str, path: Path, overwrite: bool
) -> dict[str, Any]:
    """Write the file, and return what was verified."""
    text = core_file(fits, form, path.stem)
    refuse_existing(path, overwrite, content=text)
    verified = FORMATS[form].unverified
    if form == "ngspice":
        verified, difference = "ngspice is not installed, so it was not run", None
        try:
            difference = run_ngspice(text, fits[FORMATS[form].fit], *core.path)
        except OutputError as fault:
            verified = f"{fault}; the file is not to be trusted"
        if difference is not None:
            verified = (
                f"ngspice ran it along the loop: B within {100.0 * difference:.2g} % of the range"
            )
    write_atomically(path, text)
    return {"format": form, "model": fits[FORMATS[form].fit].name, "verified": verified}


def _plain(core: Core, fits: dict[str, CoreFit], written: dict[str, Any]) -> dict[str, Any]:
    models = {}
    for key, fit in fits.items():
        numbers = {
            name: value
            for name, value in vars(fit.model).items()
            if not isinstance(value, np.ndarray)
        }
        smaller = fit.smaller_error
        models[key] = {
            "error": fit.error,
            "loss_error": fit.loss_error,
            "smaller_loops_error": smaller if math.isfinite(smaller) else None,
            "parameters": numbers,
        }
    return {
        "format": "dehyst-magnet",
        **core.as_dict(),
        "models": models,
        "written": written or None,
        "warnings": [finding.as_dict() for finding in core.findings],
    }


def _print(
    core: Core, fits: dict[str, CoreFit], written: dict[str, Any], request: MagnetRequest
) -> None:
    out = app_kit.terminal()
    figures = core.as_dict()
    out.print(
        f"{visible(core.recording.name)}: loss {core.intervals['loss_J_per_m3']} per cycle",
        style="bold",
        soft_wrap=True,
    )
    out.print()
    rows = table(("", ">", ""), _rows(core, figures))
    rows.show_header = False
    out.print(rows)
    out.print()
    lines = []
    for fit in fits.values():
        smaller = "-"
        if math.isfinite(fit.smaller_error):
            smaller = _plain_number(100.0 * fit.smaller_error, 2)
        loss = _plain_number(100.0 * fit.loss_error, 2, sign=True)
        lines.append((fit.name, _plain_number(100.0 * fit.error, 2), loss, smaller))
    out.print(table(("rms, % of range of B", ">largest loop", ">loss, %", ">smaller loops"), lines))
    out.print(
        "None of these closes a small loop where it began: of smaller loops trust the column above, not the shape.",
        soft_wrap=True,
    )
    if core.largest.completed:
        out.print(
            "half of the loop was measured; the other half is the same, turned about the centre"
        )
    if written:
        out.print(
            f"{written['model']} for {FORMATS[written['format']].title}: {written['verified']}",
            soft_wrap=True,
        )
    print_findings(core.findings)
    following = ""
    if request.out is None:
        following = command(
            "magnet", request.log, field=request.field, density=request.density, field_unit=request.field_unit,
            density_unit=request.density_unit, symmetric=request.symmetric, out="core.cir", format="ngspice",
        )  # fmt: skip
    print_end(following, picture=request.figure, core=request.out)


def _plain_number(value: float, digits: int, sign: bool = False) -> str:
    """Return a number of so many digits without an exponent."""
    return np.format_float_positional(
        value, digits, unique=False, fractional=False, trim="-", sign=sign
    )


def _rows(core: Core, figures: dict[str, Any]) -> list[tuple[str, str, str]]:
    """Label, number, and how it is defined."""
    power = "unknown"
    if figures["loss_W_per_m3"] is not None:
        power = f"{_plain_number(figures['loss_W_per_m3'], 4)} W/m3"
    at_frequency = "the log has no time; --dt SECONDS gives it one"
    if figures["frequency_Hz"] is not None:
        at_frequency = f"at {figures['frequency_Hz']:.4g} Hz"
    about, remains = "half between both H at B = 0", "half between both B at H = 0"
    if core.loops.output_reference != "zero":
        about = "half the width along H"
    if core.loops.input_reference != "zero":
        remains = "half the width along B"
    if not core.centred:
        about, remains = f"{about}, biased", f"{remains}, biased"
    bs, largest = f"{core.bs:.4g} T", core.largest
    if not core.saturated:
        bs = f"above {bs}"
    swing = 0.5 * (largest.output_high - largest.output_low)
    rows = [("loss", power, at_frequency)]
    if core.inner_loss > 1e-3 * core.loss:
        rows.append(
            ("of it in smaller loops", f"{core.inner_loss:.3g} J/m3", "that lie in the cycle")
        )
    rows += [
        ("Hc", str(core.intervals["Hc_A_per_m"]), about),
        ("Br", str(core.intervals["Br_T"]), remains),
        ("Bs", bs, "B at the tips less mu0 H"),
        ("amplitude permeability", f"{figures['amplitude_permeability']:.0f}",
         f"swing of B over mu0 H, {swing:.3g} T"),
    ]  # fmt: skip
    if core.smaller:
        rows += [
            ("of the smallest loop", f"{figures['smallest_loop_permeability']:.0f}",
             f"{figures['smallest_loop_T']:.2g} T; the initial one is that at 0 T"),
            ("maximum permeability", f"{figures['maximum_permeability']:.0f}", "the largest of all loops"),
        ]  # fmt: skip
    return rows


def write_core_figure(path: Path, core: Core, fits: dict[str, CoreFit]) -> Path:
    """Write the picture of a measured loop and its models, ``.svg`` or ``.png``.

    Raises
    ------
    OutputError
        If the ending is another one, or the file cannot be written.
    """
    h, b = core.path
    panels = []
    for title, keys in (
        ("Fitted", ("jiles-atherton", "tellinen")),
        ("As LTspice draws it", ("chan",)),
    ):
        lines = [PanelLine(h, 1e3 * b, report_kit.DATA, "measured", width=2.0)]
        for key in keys:
            if key in fits:
                modelled = 1e3 * fits[key].model.simulate(h, float(b[0]))
                lines.append(PanelLine(h, modelled, COLOURS[key], fits[key].name))
        if len(lines) > 1:
            panels.append(
                Panel(title, chart("H [A/m]", "B [mT]", lines), "Measured loop and models.")
            )
    words = f"loss {core.loss:.4g} J/m3 per cycle"
    figure = PageFigure("magnet", words, core.recording.name, tuple(panels))
    return report_kit.write_picture(figure, path, f"{TITLE}{core.recording.name}", headed=True)
