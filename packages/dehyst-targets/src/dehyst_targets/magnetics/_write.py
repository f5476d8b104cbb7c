"""Writes a fitted core for LTspice, PSpice, ngspice or Modelica, and runs it in ngspice where that is installed."""

from __future__ import annotations

import math
import re
import shutil
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from dehyst.arrays import Array
from dehyst.errors import OutputError, ParameterError
from dehyst_targets.magnetics._loop import MU_0
from dehyst_targets.magnetics._models import Chan, CoreFit, JilesAtherton, Tellinen


@dataclass(frozen=True)
class CoreFormat:
    """A simulator: the key of the model in `fit_core` that it runs, ending of its files, and what was not verified."""

    title: str
    fit: str
    ending: str
    unverified: str


FORMATS = {
    "ltspice": CoreFormat("LTspice", "chan", ".lib", "not run in LTspice"),
    "pspice": CoreFormat(
        "PSpice",
        "pspice",
        ".lib",
        "not run in PSpice, nor is the equation that was taken for LEVEL=2 checked there",
    ),
    "ngspice": CoreFormat("ngspice", "jiles-atherton", ".cir", ""),
    "modelica": CoreFormat("Modelica", "tellinen", ".mo", "not run in a Modelica tool"),
}
SIZES = "N turns, A area [m2], Lm magnetic path [m]"


def format_named(name: str | None, path: Path) -> str:
    """Return the format of a file, typed or by its ending.

    Raises
    ------
    ParameterError
        If it is not known.
    """
    if name in FORMATS:
        return str(name)
    if name is None:
        for key, form in FORMATS.items():
            if form.ending == path.suffix.lower():
                return key
    raise ParameterError(
        f"no simulator is known for {path.name if name is None else name!s:.40}. Type --format with one of "
        f"{', '.join(FORMATS)}.",
        format=name,
    )


def core_file(fits: dict[str, CoreFit], form: str, name: str) -> str:
    """Return the file of a core.

    Parameters
    ----------
    fits
        Of `fit_core`.
    form
        A key of `FORMATS`.
    name
        Of the core; other characters than letters, digits and _ become _.

    Raises
    ------
    OutputError
        If the loop is not about zero, which LTspice and Modelica ask for.

    Examples
    --------
    >>> fit = CoreFit("", JilesAtherton(3e5, 20.0, 15.0, 0.1, pspice=True), 0.0, 0.0, 0.0)
    >>> print(core_file({"pspice": fit}, "pspice", "N87").splitlines()[-1])
    .MODEL N87 CORE (LEVEL=2 MS=300000 A=20 K=15 C=0.1 AREA=1 PATH=10 GAP=0 PACK=1)
    """
    word = re.sub(r"\W", "_", name, flags=re.ASCII)
    if not word[:1].isalpha():
        word = f"core_{word}"
    fit = fits.get(FORMATS[form].fit)
    if fit is None or (form == "modelica" and "chan" not in fits):
        raise OutputError(
            f"the loop does not swing about zero, and a core of {FORMATS[form].title} is a limiting loop about zero. "
            f"Log such a loop, or write the Jiles-Atherton core: --format ngspice."
        )
    model, about = fit.model, f"dehyst, {fit.name}: rms {100.0 * fit.error:.2g} % of the range of B"
    if isinstance(model, Chan):
        return _ltspice(model, word, about)
    if isinstance(model, Tellinen):
        return _modelica(model, word, about)
    if model.pspice:
        return _pspice(model, word, about)
    return _ngspice(model, word, about)


def _ltspice(model: Chan, name: str, about: str) -> str:
    return (
        f"* {about}\n* {SIZES}, Lg gap [m]: put those of your core where you use it, as in\n"
        f"* X1 in out {name} N=20 A=52e-6 Lm=0.04 Lg=0\n"
        f".subckt {name} 1 2 params: N=10 A=1e-4 Lm=0.1 Lg=0\n"
        f"L1 1 2 Hc={model.hc:.8g} Br={model.br:.8g} Bs={model.bs:.8g} A={{A}} Lm={{Lm}} Lg={{Lg}} N={{N}}\n"
        f".ends {name}\n"
    )


def _pspice(model: JilesAtherton, name: str, about: str) -> str:
    return (
        f"* {about}\n* MS, A, K in A/m. Probe shows B in gauss (1 T = 1e4 G), H in oersted (1 A/m = 0.0125664 Oe).\n"
        f"* AREA in cm2, PATH and GAP in cm: put those of your core. Use: K1 L1 1.0 {name}, value of L1 = its turns\n"
        f".MODEL {name} CORE (LEVEL=2 MS={model.ms:.8g} A={model.a:.8g} K={model.k:.8g} C={model.c:.8g} AREA=1 "
        f"PATH=10 GAP=0 PACK=1)\n"
    )


def _ngspice(model: JilesAtherton, name: str, about: str) -> str:
    """A winding p n; the flux density stands at pin b, a volt for a tesla. The state is M over Ms at pin m."""
    # Names of SPICE do not tell capitals: the shape "a" would be the area.
    coupled = "(V(h)+{alpha*Ms}*V(m))"
    x = f"({coupled}/{{shape}})"
    small = f"abs{x} < 0.01"
    bent = f"({small} ? {x}/3 : 1/tanh({x} + ({small} ? 1 : 0)) - 1/({x} + ({small} ? 1 : 0)))"
    rise = f"({small} ? 1/3 : 1/({x}*{x} + 1e-30) - 1/(sinh(min(max({x},-300),300))^2 + 1e-30))"
    lines = [
        f"* {about}",
        f"* {SIZES}, M0 magnetisation at the start over Ms: put those of your core where you use it, as in",
        f"* X1 in out b {name} N=20 A=52e-6 Lm=0.04      (pin b: flux density, a volt for a tesla); .tran ... uic",
        f".subckt {name} p n b params: N=10 A=1e-4 Lm=0.1 M0=0",
        f".param Ms={model.ms:.10g} shape={model.a:.10g} k={model.k:.10g} c={model.c:.10g} alpha={model.alpha:.10g}",
        f".param mu0={MU_0:.12g}",
        "Vi p x 0",
        "Bv x n V = {N*A*mu0}*(1+{Ms}*V(s))*V(r)",
        "Bh h 0 V = {N/Lm}*I(Vi)",
        "Fi 0 d Vi {N/Lm}",
        "Ld d 0 1",
        "Br r 0 V = V(d)",
        f"Ban an 0 V = {bent}",
        f"Bdan dan 0 V = {rise}/{{shape}}",
        "Baway away 0 V = max((V(r) >= 0 ? 1 : -1)*(V(an)-V(m)), 0)",
        "Bs s 0 V = (V(away)/max({k}-{alpha*Ms}*V(away), {0.02*k}) + {c}*V(dan))/(1+{c}-{c*alpha*Ms}*V(dan))",
        "Cm m 0 1 IC={M0}",
        "Bm 0 m I = V(s)*V(r)",
        "Bb b 0 V = {mu0}*(V(h)+{Ms}*V(m))",
        f".ends {name}",
    ]
    return "\n".join(lines) + "\n"


def _modelica(model: Tellinen, name: str, about: str) -> str:
    tables = {}
    for key, branch in (("tabris", model.rising), ("tabfal", model.falling)):
        # Beyond the loop the polarisation stays; Akima's splines need the rows far away.
        h = np.concatenate(([-1e7], model.field, [1e7]))
        j = np.concatenate((branch[:1], branch, branch[-1:]))
        rows = [f"    {field:.8g}, {density:.8g}" for field, density in zip(h, j, strict=True)]
        tables[key] = f"  {key}=[\n" + ";\n".join(rows) + "]"
    return (
        f"// {about}\n// Use: Modelica.Magnetic.FluxTubes.Shapes.HysteresisAndMagnets.GenericHystTellinenTable "
        f"core(mat={name}(), l=..., A=...);\n"
        f"record {name}\n  extends Modelica.Magnetic.FluxTubes.Material.HysteresisTableData.BaseData(\n"
        f"{tables['tabris']},\n{tables['tabfal']},\n  sigma=1e-6);\nend {name};\n"
    )


def run_ngspice(text: str, fit: CoreFit, h: Array, b: Array) -> float | None:
    """Drive a written core along a field in ngspice; return how far B is from that of `fit`.

    Parameters
    ----------
    text
        Of `core_file` for ngspice.
    fit
        What it was written from.
    h, b
        Field and measured flux density, (T,) each; B decides the start. [A/m], [T]

    Returns
    -------
    float or None
        Largest difference, share of the range of B; None if ngspice is not installed.

    Raises
    ------
    OutputError
        If ngspice does not run it.
    """
    program = shutil.which("ngspice")
    if program is None:
        return None
    assert isinstance(fit.model, JilesAtherton)
    name = re.search(r"^\.subckt (\w+)", text, re.MULTILINE)
    assert name is not None
    start = (b[0] / MU_0 - h[0]) / fit.model.ms
    time = np.arange(h.size) * 1e-3
    points = "\n".join(f"+ {t:.9g} {value:.12g}" for t, value in zip(time, h, strict=True))
    # With one turn on a path of one metre a current is a field.
    deck = (
        f"* core\n{text}\nI1 0 p PWL(\n{points})\nX1 p 0 b {name[1]} N=1 A=1 Lm=1 M0={start:.12g}\n"
        f".options reltol=1e-5 method=gear\n.tran 2e-4 {time[-1]:.9g} 0 2e-4 uic\n"
        f".control\nrun\nset wr_singlescale\nwrdata out.txt V(b)\n.endc\n.end\n"
    )
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "core.cir").write_text(deck)
        try:
            ran = subprocess.run(
                [program, "-b", "core.cir"],
                cwd=folder,
                capture_output=True,
                timeout=120,
                check=False,
            )
            rows = np.loadtxt(Path(folder) / "out.txt")
        except (OSError, ValueError, subprocess.TimeoutExpired) as fault:
            raise OutputError(f"ngspice does not run the core: {fault}") from None
    if rows.ndim != 2 or not math.isfinite(float(rows.sum())):
        raise OutputError(f"ngspice does not run the core: {ran.stderr[-300:]!r}")
    simulated = np.interp(time, rows[:, 0], rows[:, 1])
    modelled = fit.model.simulate(h, float(b[0]))
    return float(np.abs(simulated - modelled)[1:].max() / np.ptp(b))
