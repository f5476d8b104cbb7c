"""Report section on how the run was simulated: plants, settings with sources, versions, command, log files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from dehyst.report.parts import Section, Step, Table
from dehyst.report.text import listed, number, opened, plain, short
from dehyst.robot.experiments.results import ACCEPTABLE, Reproduction
from dehyst.robot.report.numbers import NO_HYSTERESIS
from dehyst.robot.report.words import MECHANISMS
from dehyst.shell import visible_lines as clean

# Settings with a place of their own on the page; all others are listed as they are.
OWN = ("parameters", "sources", "changes", "versions", "command", "compensator", "compensators")
NAMES = {"fingerprint": "fingerprint of the parameters"}
MAXIMUM_LOGS = 400
Logs = Mapping[str, "str | Sequence[str]"]


def about_section(result: Reproduction, logs: Logs | None) -> Section:
    """Return what the experiment is: words, the line to repeat it, run, parameters, versions, log files."""
    command = clean(result.settings.get("command", ""))
    tables = (_run(result), _changes(result), _versions(result), _parameters(result), _logs(logs))
    steps = (Step("To repeat it:", command),) if command else ()
    return Section(
        "about", "What this is", (*honesty(result), *steps, *(table for table in tables if table is not None))
    )


def honesty(result: Reproduction) -> tuple[str, ...]:
    """Return what a reader must know to judge the figures: about the plants, the controller and the seeds."""
    said = [
        "A simulation of the arm, its valves, sensors and controller, and the paper's experiment on it: homing, "
        "calibration, identification, inversion, trials along the paths of ISO 9283. Nothing here was measured on "
        "hardware, and the paper gives its errors as curves, not as numbers: what can be compared is what "
        "compensation changes, not a figure in degrees.",
        "The plant is not the controller's model. The compensator is a weighted sum of play operators, which know no "
        "time and no pressure. The hysteresis of the plants comes from three other mechanisms ("
        + "; ".join(f"{name}: {MECHANISMS[name]}" for name in MECHANISMS if name != NO_HYSTERESIS)
        + "). All three depend on pressure, differ between contraction and elongation, and creep. A fourth plant has "
        "no hysteresis: whatever a compensator does there is harm.",
        "What was fixed when: the muscles, their hysteresis and creep, valves, sensors, masses and the controller's "
        "errors of the packaged parameter file were fixed before a compensator was first run on this arm, and none was "
        "changed afterwards; a prototype of one joint, with compensators, had been tried before. Most of these numbers "
        "are assumptions, within published ranges where there are any. Set after first runs were the procedure "
        "(homing, motions of calibration and identification, speed and rests of the path, poles of the wrist, "
        f"thresholds of the fault detection) and the limit of {100 * ACCEPTABLE:.0f} % for accepting a model, which "
        "lies between what plants with and without hysteresis gave.",
        "Lengths, masses, gains and the path of the paper's arm were not published: here they are assumptions, and "
        "stand below as such.",
    ]
    return (*said, *filter(None, (_wrong_on_purpose(result), _seeds(result))))


def _wrong_on_purpose(result: Reproduction) -> str:
    """What the controller knows wrongly, and what its sensors do not tell; "" if the parameters are not known."""
    values = opened(_table_of(result, "parameters"))
    parts = []
    for key, what, less, more in (
        ("controller.inertia_error", "the rigid body", "lighter", "heavier"),
        ("controller.gravity_error", "the torque of gravity", "smaller", "larger"),
        ("controller.conductance_error", "the valves", "smaller", "larger"),
    ):
        error = values.get(key)
        if isinstance(error, (int, float)) and error:
            parts.append(f"{what} for {100 * abs(error):.3g} % {less if error < 0 else more}")
    if not parts:
        return ""
    text = f"The controller is wrong on purpose: it takes {listed(parts)} than they are."
    bits, noise = values.get("sensors.encoder_bits"), values.get("sensors.pressure_noise_bar")
    if isinstance(bits, int) and isinstance(noise, (int, float)):
        step = number(360.0 / 2.0**bits, 2)
        text += f" It sees angles in steps of {step}° and pressures with {number(1e3 * noise, 2)} mbar of noise (rms)."
    pole = values.get("controller.pole_1_s")
    if isinstance(pole, (int, float)):
        text += (
            f" The poles of its position loop, λ = {pole:.3g} 1/s, decide how much there is to compensate: with "
            "stiffer ones a compensator can show less."
        )
    return text


def _seeds(result: Reproduction) -> str:
    seeds = sorted({seed for plant in result.plants.values() for seed in plant.figures})
    if not seeds:
        return ""
    text = (
        f"Seed {seeds[0]} draws the noise of the sensors"
        if len(seeds) == 1
        else f"Seeds {listed(seeds)} each draw the noise of the sensors anew"
    )
    values = opened(_table_of(result, "parameters"))
    hysteresis, force = values.get("tolerance.hysteresis"), values.get("tolerance.force")
    if isinstance(hysteresis, (int, float)) and isinstance(force, (int, float)):
        text += (
            f", and muscles of the same make: hysteresis ± {100 * hysteresis:.3g} %, static force "
            f"± {100 * force:.3g} % (rms)"
        )
    text += ". The same seed gives the same figures, to the last bit"
    return f"{text}; curves and pictures are of seed {seeds[0]}." if len(seeds) > 1 else f"{text}."


def _table_of(result: Reproduction, name: str) -> Mapping[Any, Any]:
    found = result.settings.get(name)
    return found if isinstance(found, Mapping) else {}


def _run(result: Reproduction) -> Table:
    rest = {key: value for key, value in result.settings.items() if key not in OWN}
    rows = [("compensator", ", ".join(result.compensators))]
    rows += [(NAMES.get(key, key.replace("_", " ")), plain(value)) for key, value in opened(rest).items()]
    rows += [(f"times real time, {short(n, 40)}", number(p.real_time_factor)) for n, p in result.plants.items()]
    note = "Times real time: simulated time over wall time of a trial, median of all, beside whatever else ran."
    return Table("This run", (), tuple(rows), note if result.plants else "")


def _changes(result: Reproduction) -> Table | None:
    changes = opened(_table_of(result, "changes"))
    if not changes:
        return None
    sources = opened(_table_of(result, "sources"))
    rows = tuple((key, plain(value), clean(sources.get(key, ""))) for key, value in changes.items())
    return Table("Changed against the packaged arm", ("", "value", "meaning and source"), rows, words=True)


def _versions(result: Reproduction) -> Table | None:
    versions = opened(_table_of(result, "versions"))
    rows = tuple((name, plain(value)) for name, value in versions.items())
    return Table("Versions", (), rows) if rows else None


def _parameters(result: Reproduction) -> Table | None:
    values = opened(_table_of(result, "parameters"))
    if not values:
        return None
    sources = opened(_table_of(result, "sources"))
    changed = opened(_table_of(result, "changes"))
    rows = tuple(
        (key, plain(value) + (" (changed)" if key in changed else ""), clean(sources.get(key, "")))
        for key, value in values.items()
    )
    head = ("", "value", "meaning and source")
    return Table(f"All {len(rows)} parameters", head, rows, folded=True, words=True)


def _logs(logs: Logs | None) -> Table | None:
    if not logs:
        return None
    rows = [
        (run, ", ".join([files] if isinstance(files, str) else [str(file) for file in files]))
        for run, files in logs.items()
    ]
    more = f"The first {MAXIMUM_LOGS} of {len(rows)} runs." if len(rows) > MAXIMUM_LOGS else ""
    return Table(
        f"Logs of {len(rows)} runs",
        ("", "files, relative to the run's folder"),
        tuple(rows[:MAXIMUM_LOGS]),
        more,
        folded=True,
        words=True,
    )
