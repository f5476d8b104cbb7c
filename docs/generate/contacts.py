"""Table of explanation/adaptation.md, from what benchmarks/contacts.py measured, which takes 20 minutes."""

from __future__ import annotations

import csv
from pathlib import Path

RESULT = Path(__file__).with_name("contacts.csv")
PLANTS = {
    "maxwell-slip": "Maxwell slip",
    "preisach": "Preisach",
    "dahl": "Dahl",
    "lugre": "LuGre",
    "pinched": "Pinched",
    "ageing": "Ageing",
    "braid": "Braid",
}
Cases = dict[tuple[str, str, str], dict[str, str]]


def cases() -> Cases:
    """Return the rows of the file by plant, contact and compensator."""
    rows: Cases = {}
    with RESULT.open(encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file):
            rows[row["plant"], row["contact"], row["compensator"]] = row
    return rows


def table() -> str:
    """Errors before, during and after a contact, [mdeg], and when `best` noticed it."""
    rows = cases()
    lines = [
        "| plant, contact | off: before, during, after | paper | best | noticed [s] | force [Nm] | scales in use |",
        "|---|---|---|---|---|---|---|",
    ]
    for plant, title in PLANTS.items():
        for contact in dict.fromkeys(name for _, name, _ in rows):
            if contact == "none" or (plant, contact, "best") not in rows:
                continue
            best = rows[plant, contact, "best"]
            cells = [f"{title}, {contact}"]
            for name in ("off", "paper", "best"):
                cells.append(_errors(rows.get((plant, contact, name))))
            cells += [
                best["touched_s"] or "not",
                f"{float(best['peak_Nm']):.0f}",
                f"{float(best['lowest_scale']):.2f} to {float(best['highest_scale']):.2f}",
            ]
            lines.append(f"| {' | '.join(cells)} |")
    energies = []
    for plant, title in PLANTS.items():
        energies.append(f"{float(rows[plant, 'none', 'best']['loop_J']):.1f} J ({title})")
    lines += [
        "",
        f"Work of `best` along two strokes, to and fro, as identified: {', '.join(energies)}.",
    ]
    return "\n".join(lines)


def _errors(row: dict[str, str] | None) -> str:
    if row is None:
        return "not run"
    columns = ("before_mdeg", "during_mdeg", "settled_mdeg")
    return ", ".join(f"{float(row[name]):.0f}" for name in columns)
