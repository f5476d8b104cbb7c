"""What an export needs beside code: sources of the core, counted instructions, a licence, and the draws of its test signal."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

ROOT = Path(__file__).parents[2]
SEED = 20260722  # of dehyst.export.signal.test_input


class Recorder:
    """A generator of random numbers that remembers what it gave."""

    def __init__(self) -> None:
        self.inner, self.draws = np.random.Generator(np.random.PCG64(SEED)), list[dict[str, object]]()

    def __getattr__(self, name: str):
        def draw(*args: object, **named: object) -> np.ndarray:
            values = getattr(self.inner, name)(*args, **named)
            # The signal takes even draws as powers of ten alone, which differ in their last bits between machines.
            powers = name == "uniform"
            self.draws.append({"values": (10.0**values if powers else values).tolist(), "powers": powers})
            return values

        return draw


def script() -> str:
    """JavaScript that puts it where the page looks for it."""
    from dehyst.export import signal

    recorder = Recorder()
    usual = np.random.default_rng
    np.random.default_rng = lambda _seed: recorder  # type: ignore[assignment,misc]
    try:
        signal.test_input(-1.0, 1.0, "double", 500)
    finally:
        np.random.default_rng = usual
    export = ROOT / "src" / "dehyst" / "export"
    from dehyst.export import core_files

    needed = [
        *core_files.needed(("dehyst_block_reset", "dehyst_block_step", "dehyst_block_save", "dehyst_block_restore"))
    ]
    files = {f"dehyst/core_sources/{name}": ROOT / "core" / name for name in (*needed, "misra.json")}
    files |= {f"dehyst/export/{name}": export / name for name in ("instructions.json", "templates/LICENSE")}
    texts = {name: path.read_text(encoding="utf-8") for name, path in files.items() if path.name != "dehyst_config.h"}
    counted = json.loads(texts["dehyst/export/instructions.json"])
    for target in counted["targets"].values():
        for kind in target.keys() - {"title", "compiler", "block"}:  # a page exports no other kind of unit
            del target[kind]
    texts["dehyst/export/instructions.json"] = json.dumps(counted)
    rules = json.loads(texts["dehyst/core_sources/misra.json"])
    texts["dehyst/core_sources/misra.json"] = json.dumps(
        {rule: entry for rule, entry in rules.items() if entry["files"].keys() & set(needed)}
    )
    return (
        'import { carried } from "../runtime/native.js";\nimport { nd } from "../runtime/python.js";\n'
        f"for (const [name, text] of Object.entries({json.dumps(texts)})) carried.set(name, text);\n"
        f"nd.draws = {json.dumps(recorder.draws)};\nnd.ladder = {json.dumps(np.geomspace(1.0, 1e-4, signal.LADDER // 2).tolist())};\n"
    )
