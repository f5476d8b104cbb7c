"""Table of instructions and bytes in how-to/run-on-a-microcontroller.md, from benchmarks/results/target.json.

    python benchmarks/target.py --json benchmarks/results/target.json

needs gcc-arm-none-eabi, qemu-system-arm and valgrind and takes minutes, so it is not run with the other pages.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

RESULT = Path(__file__).resolve().parents[2] / "benchmarks" / "results" / "target.json"
COMMAND = "python benchmarks/target.py --json benchmarks/results/target.json"
PLAYS = "14"
COLUMNS = {"typical": "slow loops", "none": "none moves", "all": "all move", "free": "any number", "held": "held back",
           "most": "all signals"}  # fmt: skip


def page() -> str:
    """Return both tables in Markdown."""
    if not RESULT.exists():
        return f"(Not run yet: `{COMMAND}`)"
    found: dict[str, Any] = json.loads(RESULT.read_text(encoding="utf-8"))
    compilers = "; ".join(dict.fromkeys(f"{entry['compiler']}" for entry in found.values()))
    head = f"Instructions of a step of the inverse of 14 operators, -O2 ({compilers}; `{COMMAND}`):"
    return "\n".join(
        [head, "", *_steps(found), "", *_sizes(found), "", *_elements(found), "", *_families(found)]
    )


def _rows(found: dict[str, Any]) -> list[tuple[str, dict[str, Any]]]:
    return [
        (f"{entry['title']}: {real}", entry[real])
        for entry in found.values()
        for real in ("float", "double")
    ]


def _steps(found: dict[str, Any]) -> list[str]:
    lines = [
        f"| | {' | '.join(COLUMNS.values())} | all signals, -Os | a map |",
        "|---|" + "---:|" * (len(COLUMNS) + 2),
    ]
    for name, entry in _rows(found):
        row = entry["steps"][PLAYS]
        cells = [f"{row[key]:.0f}" for key in COLUMNS]
        lines.append(
            f"| {name} | {' | '.join(cells)} | {entry['steps_os']['most']:.0f} | {entry['map']:.0f} |"
        )
    return lines


def _sizes(found: dict[str, Any]) -> list[str]:
    lines = [
        "And of a period of a whole joint controller with such a compensator; bytes of flash (code, constants and what "
        "it needs of the compiler's library) and of RAM, of the inverse and of the controller:",
        "",
        "| | controller | slowest period | inverse, -O2 | -Os | RAM | controller, -O2 | -Os | RAM |",
        "|---|" + "---:|" * 8,
    ]
    for name, entry in _rows(found):
        joint, own, whole = entry["joint"][PLAYS], entry["bytes"], entry["joint_bytes"]
        cells = [joint["typical"], joint["most"]]
        cells += [own["-O2"]["flash"], own["-Os"]["flash"], own["-O2"]["ram"]]
        cells += [whole["-O2"]["flash"], whole["-Os"]["flash"], whole["-O2"]["ram"]]
        lines.append(f"| {name} | " + " | ".join(f"{cell:.0f}" for cell in cells) + " |")
    return lines


def _elements(found: dict[str, Any]) -> list[str]:
    lines = [
        "A step of a sum of 40 elements of all kinds, a third of them with maps of six points: instructions in a slow "
        "signal, at most in one that jumps anywhere, of the first sample of an inverse, which looks for where to "
        "begin; bytes of a unit of 10 such elements:",
        "",
        "| | forward | at most | inverse | at most | first | forward, -O2 | -Os | RAM |",
        "|---|" + "---:|" * 8,
    ]
    for name, entry in _rows(found):
        there, back = (entry["elements"][what]["steps"]["40"] for what in ("forward", "inverse"))
        own = entry["elements"]["forward"]["bytes"]
        cells = [there["typical"], there["most"], back["typical"], back["most"], back["first"]]
        cells += [own["-O2"]["flash"], own["-Os"]["flash"], own["-O2"]["ram"]]
        lines.append(f"| {name} | " + " | ".join(f"{cell:.0f}" for cell in cells) + " |")
    return lines


def _families(found: dict[str, Any]) -> list[str]:
    """A step of a small sum of every row of elements, and of a direct inverse."""
    machines = (("cortex-m4f", "float"), ("cortex-m7", "double"))
    names = [f"{found[machine]['title'].split(',')[0]} {real}" for machine, real in machines]
    lines = [
        "A step of a sum of every row of elements, as small as tests have it, of its inverse, and of a direct inverse: "
        "instructions in a slow signal, and the most of any step, that after a reset included:",
        "",
        f"| | elements | {' | '.join(f'{name}, forward | at most | inverse | at most' for name in names)} |",
        "|---|---:|" + "---:|" * 8,
    ]
    for name, both in found[machines[0][0]][machines[0][1]]["rows"].items():
        rows = [
            found[machine][real]["rows"][name].get(what, {})
            for machine, real in machines
            for what in both
        ]
        cells = [
            f"{value:.0f}"
            for row in rows
            for value in (row["typical"], max(row["most"], row["first"]))
        ]
        parts = sum(count for part, count in both["forward"]["counts"].items() if "map" not in part)
        lines.append(f"| `{name}` | {parts} | {' | '.join(cells)} |")
    of = [
        [row for row in found[machine][real]["units"] if row["kind"] == "direct_block"][-1]
        for machine, real in machines
    ]
    cells = [f" | | {row['typical']:.0f} | {row['most']:.0f} |" for row in of]
    terms = sum(of[0]["counts"].get(part, 0) for part in ("stops", "paths", "creeps"))
    lines.append(f"| direct inverse, one schedule | {terms} |{''.join(cells)}")
    return lines
