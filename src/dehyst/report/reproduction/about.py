"""What the reproduction is: settings with their sources, versions, the command, the log files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from dehyst.experiments.results import Reproduction
from dehyst.report.tables import Table
from dehyst.report.text import clean, number, plain, short

# Settings with a place of their own on the page; all others are listed as they are.
OWN = ("parameters", "sources", "changes", "versions", "command")
MAXIMUM_LOGS = 400
Logs = Mapping[str, "str | Sequence[str]"]


def about_tables(result: Reproduction, logs: Logs | None) -> tuple[Table, ...]:
    """Return the tables: run, changed parameters, all parameters, versions, log files."""
    made = (_run(result), _changes(result), _versions(result), _parameters(result), _logs(logs))
    return tuple(table for table in made if table is not None)


def command(result: Reproduction) -> str:
    """Return the line to type to repeat the run, or ""."""
    return clean(result.settings.get("command", ""))


def flat(table: Mapping[Any, Any], before: str = "") -> dict[str, Any]:
    """Return nested tables with dotted names, as in the parameter file.

    Examples
    --------
    >>> flat({"joint": {"1": {"radius_m": 0.05}}, "name": "arm"})
    {'joint.1.radius_m': 0.05, 'name': 'arm'}
    """
    found: dict[str, Any] = {}
    for key, value in table.items():
        if isinstance(value, Mapping):
            found |= flat(value, f"{before}{key}.")
        else:
            found[f"{before}{key}"] = value
    return found


def _table_of(result: Reproduction, name: str) -> Mapping[Any, Any]:
    found = result.settings.get(name)
    return found if isinstance(found, Mapping) else {}


def _run(result: Reproduction) -> Table:
    rest = {key: value for key, value in result.settings.items() if key not in OWN}
    rows = [("compensator", result.compensator)]
    rows += [(key.replace("_", " "), plain(value)) for key, value in flat(rest).items()]
    rows += [
        (
            f"real time factor, {short(name, 40)}",
            f"{number(plant.real_time_factor)} (simulated over wall time, one core)",
        )
        for name, plant in result.plants.items()
    ]
    return Table("This run", (), tuple(rows))


def _changes(result: Reproduction) -> Table | None:
    changes = flat(_table_of(result, "changes"))
    if not changes:
        return None
    sources = flat(_table_of(result, "sources"))
    rows = tuple((key, plain(value), clean(sources.get(key, ""))) for key, value in changes.items())
    return Table("Changed against the packaged arm", ("", "value", "meaning and source"), rows)


def _versions(result: Reproduction) -> Table | None:
    versions = flat(_table_of(result, "versions"))
    rows = tuple((name, plain(value)) for name, value in versions.items())
    return Table("Versions", (), rows) if rows else None


def _parameters(result: Reproduction) -> Table | None:
    values = flat(_table_of(result, "parameters"))
    if not values:
        return None
    sources = flat(_table_of(result, "sources"))
    changed = flat(_table_of(result, "changes"))
    rows = tuple(
        (key, plain(value) + (" (changed)" if key in changed else ""), clean(sources.get(key, "")))
        for key, value in values.items()
    )
    return Table(f"All {len(rows)} parameters", ("", "value", "meaning and source"), rows, folded=True)


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
    )
