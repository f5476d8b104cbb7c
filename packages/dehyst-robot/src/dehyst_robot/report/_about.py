"""Report section on how the run was simulated: plants, settings with sources, versions, command, log files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from dehyst.report import PageSection, PageTable, Step
from dehyst.report import kit as report_kit
from dehyst.shell import visible_lines as clean
from dehyst_robot.experiments import Reproduction
from dehyst_robot.experiments import kit as experiments_kit
from dehyst_robot.report._numbers import NO_HYSTERESIS
from dehyst_robot.report._words import MECHANISMS

# Settings with a place of their own on the page; all others are listed as they are.
OWN = ("parameters", "sources", "changes", "versions", "command", "compensator", "compensators")
NAMES = {"fingerprint": "fingerprint of the parameters"}
MAXIMUM_LOGS = 400
Logs = Mapping[str, "str | Sequence[str]"]


def about_section(result: Reproduction, logs: Logs | None) -> PageSection:
    """Return what the experiment is: words, the line to repeat it, run, parameters, versions, log files."""
    # Words first: who reads no further knows what this is.
    blocks: list[str | Step | PageTable] = [*honesty(result)]
    command = clean(result.settings.get("command", ""))
    if command:
        blocks.append(Step("To repeat it:", command))
    # Tables of which nothing is known are left out.
    for table in (
        _run(result),
        _changes(result),
        _versions(result),
        _parameters(result),
        _logs(logs),
    ):
        if table is not None:
            blocks.append(table)
    return PageSection("about", "What this is", tuple(blocks))


def _mechanisms(result: Reproduction) -> str:
    """The mechanisms of hysteresis of the plants of this run, in sentences."""
    meanings = []
    for name, meaning in MECHANISMS.items():
        # The control has no mechanism.
        if name in (*result.plants, *result.alone) and name != NO_HYSTERESIS:
            meanings.append(f"{name}: {meaning}")
    words = ""
    if meanings:
        words = (
            f" The hysteresis of the plants comes from other mechanisms ({'; '.join(meanings)}). They depend on "
            f"pressure, differ between contraction and elongation, and creep."
        )
    if NO_HYSTERESIS in result.plants:
        words += " One plant has no hysteresis: whatever a compensator does there is harm."
    return words


def honesty(result: Reproduction) -> tuple[str, ...]:
    """Return what a reader must know to judge the figures: about the plants, the controller and the seeds."""
    paragraphs = [
        "A simulation of the arm, its valves, sensors and controller, and the paper's experiment on it: homing, "
        "calibration, identification, inversion, trials along the paths of ISO 9283. Nothing here was measured on "
        "hardware, and the paper gives its errors as curves, not as numbers: what can be compared is what "
        "compensation changes, not a figure in degrees.",
        "The plant is not the controller's model. The paper's compensator is a weighted sum of play operators, which "
        f"know no time and no pressure.{_mechanisms(result)}",
        "What was fixed when: the muscles, their hysteresis and creep, valves, sensors, masses and the controller's "
        "errors of the packaged parameter file were fixed before a compensator was first run on this arm, and none was "
        "changed afterwards; a prototype of one joint, with compensators, had been tried before. The mechanisms braid, "
        "lugre, pinched and ageing were added later, from the literature, and not changed after a compensator had run "
        "on them. Most of these numbers are assumptions, within published ranges where there are any. Set after first "
        "runs were the procedure (homing, motions of calibration and identification, speed and rests of the path, "
        "poles of the wrist, thresholds of the fault detection) and the limit of "
        f"{100 * experiments_kit.POLICY.acceptable:.0f} % for accepting a model, which lies between what plants with "
        "and without hysteresis gave.",
        "Lengths, masses, gains and the path of the paper's arm were not published: here they are assumptions, and "
        "stand below as such.",
    ]
    return (
        *paragraphs,
        "The controller is wrong on purpose, by the errors that stand among the parameters. Each seed draws the noise "
        "of the sensors and the tolerances of the muscles anew; the same seed gives the same figures, to the last bit. "
        "Curves and pictures are of the first seed.",
    )


def _table_of(result: Reproduction, name: str) -> Mapping[str, Any]:
    """A table of the settings with joined names; an empty one if there is none."""
    table = result.settings.get(name)
    if not isinstance(table, Mapping):
        return {}
    return report_kit.flattened(table)


def _run(result: Reproduction) -> PageTable:
    rows = [("compensator", ", ".join(result.compensators))]
    # What has a place of its own on the page is not said twice.
    listed = {key: value for key, value in result.settings.items() if key not in OWN}
    for key, value in report_kit.flattened(listed).items():
        rows.append((NAMES.get(key, key.replace("_", " ")), report_kit.plain(value)))
    # A browser gets slow with thousands of rows.
    note = ""
    for name, plant in result.everything.items():
        factor = report_kit.number(plant.real_time_factor)
        rows.append((f"times real time, {report_kit.short(name, 40)}", factor))
        note = "Times real time: simulated time over wall time of a trial, median of all, beside whatever else ran."
    return PageTable("This run", (), tuple(rows), note)


def _changes(result: Reproduction) -> PageTable | None:
    changes, sources = _table_of(result, "changes"), _table_of(result, "sources")
    if not changes:
        return None
    rows = []
    for key, value in changes.items():
        rows.append((key, report_kit.plain(value), clean(sources.get(key, ""))))
    head = ("", "value", "meaning and source")
    return PageTable("Changed against the packaged arm", head, tuple(rows), words=True)


def _versions(result: Reproduction) -> PageTable | None:
    versions = _table_of(result, "versions")
    if not versions:
        return None
    rows = tuple((name, report_kit.plain(value)) for name, value in versions.items())
    return PageTable("Versions", (), rows)


def _parameters(result: Reproduction) -> PageTable | None:
    values, changes = _table_of(result, "parameters"), _table_of(result, "changes")
    sources = _table_of(result, "sources")
    if not values:
        return None
    rows = []
    for key, value in values.items():
        shown = report_kit.plain(value)
        if key in changes:
            # Who looks a number up shall see that it is not the packaged one.
            shown += " (changed)"
        rows.append((key, shown, clean(sources.get(key, ""))))
    head = ("", "value", "meaning and source")
    return PageTable(f"All {len(rows)} parameters", head, tuple(rows), folded=True, words=True)


def _logs(logs: Logs | None) -> PageTable | None:
    if not logs:
        return None
    rows = []
    for run, files in logs.items():
        # A run may have one log, or a table and a recording.
        if isinstance(files, str):
            rows.append((run, files))
        else:
            rows.append((run, ", ".join(map(str, files))))
    note = ""
    if len(rows) > MAXIMUM_LOGS:
        note = f"The first {MAXIMUM_LOGS} of {len(rows)} runs."
    head = ("", "files, relative to the run's folder")
    title = f"Logs of {len(rows)} runs"
    return PageTable(title, head, tuple(rows[:MAXIMUM_LOGS]), note, folded=True, words=True)
