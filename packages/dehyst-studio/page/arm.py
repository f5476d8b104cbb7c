"""Packs trials of the arm for the page: `make demo`, then `python page/arm.py demo`; writes page/src/arm.json.

Every trial is thinned to a coarser clock and rounded to the steps below; what that changes at most, between the kept
samples too, is measured and stands in the file, and on the page.
"""

from __future__ import annotations

import base64
import gzip
import json
import sys
from pathlib import Path

import numpy as np

HERE = Path(__file__).parent
OUT = HERE / "src" / "arm.json"
TRIALS = {"fast": "fast", "slow": "slow", "slow_no_integrator": "slow, without integrator"}
COMPENSATORS = ("off", "paper", "best")
AXES = "xyz"
DRAWN = (2, 4, 6)  # joints where the arm bends
ANGLE, ERROR, PLACE, MISS, POSE = 0.01, 0.005, 0.2, 0.1, 2.0  # steps [deg, deg, mm, mm, mm]
LIMIT = 60_000  # characters
STRIDES = (
    2,
    3,
    4,
    5,
    6,
    8,
)  # of the fast trial; slow ones, in which less happens in a sample, take twice that

sys.path.insert(0, str(HERE.parents[1] / "dehyst-robot" / "src"))


def packed(columns: list[np.ndarray], steps: list[float]) -> bytes:
    """Differences of rounded values, zigzag, seven bits a byte, lowest first; the top bit says that more follow."""
    out = bytearray()
    for values, step in zip(columns, steps, strict=True):
        for move in np.diff(np.rint(values / step).astype(int), prepend=0):
            left = 2 * int(move) if move >= 0 else -2 * int(move) - 1
            while left > 127:
                out.append(left & 127 | 128)
                left >>= 7
            out.append(left)
    return bytes(out)


def lost(time: np.ndarray, values: np.ndarray, kept: slice, step: float) -> float:
    """Largest difference between a signal and straight lines between its kept and rounded values."""
    return float(
        np.abs(np.interp(time, time[kept], np.rint(values[kept] / step) * step) - values).max()
    )


def read(path: Path) -> dict[str, np.ndarray]:
    """Columns of a log by name."""
    table = np.genfromtxt(path, delimiter=",", names=True)
    return {name: table[name] for name in table.dtype.names}


def poses(log: dict[str, np.ndarray], joints: range) -> list[np.ndarray]:
    """Where the arm bends when it is where it should be. [mm]"""
    from dehyst_robot.arm import arm_model, load_robot
    from dehyst_robot.arm._rigid_body import joint_positions

    angles = np.radians(np.column_stack([log[f"joint{j}_desired_deg"] for j in joints]))
    places = 1000.0 * joint_positions(arm_model(load_robot()), angles)
    return [places[:, j - 1, axis] for j in DRAWN for axis in range(3)]


def trial(
    folder: Path, name: str, stride: int
) -> tuple[dict[str, object], bytes, dict[str, float]]:
    """One trial with every compensator: what is said of it, its bytes, what is lost."""
    logs = {each: read(folder / f"{name}_{each}.csv") for each in COMPENSATORS}
    first = logs[COMPENSATORS[0]]
    time = first["time_s"]
    joints = range(1, 1 + sum(key.endswith("_desired_deg") for key in first))
    kept = slice(None, None, stride)
    columns, steps = poses(first, joints), [POSE] * (3 * len(DRAWN))
    columns += [first[f"joint{j}_desired_deg"] for j in joints] + [
        1000.0 * first[f"tool_desired_{a}_m"] for a in AXES
    ]
    steps += [ANGLE] * len(joints) + [PLACE] * 3
    changed = {"deg": 0.0, "mm": 0.0}
    rms: dict[str, list[float]] = {}
    for each, log in logs.items():
        assert np.array_equal(log["time_s"], time), f"{name}: trials do not share their clock"
        errors = [log[f"joint{j}_angle_deg"] - log[f"joint{j}_desired_deg"] for j in joints]
        misses = [1000.0 * (log[f"tool_{a}_m"] - log[f"tool_desired_{a}_m"]) for a in AXES]
        columns += errors + misses
        steps += [ERROR] * len(joints) + [MISS] * 3
        size = [float(np.sqrt(np.mean(e**2))) for e in errors] + [
            float(np.sqrt(np.mean(sum(m**2 for m in misses))))
        ]
        rms[each] = [round(one, 4) for one in size]
        changed["deg"] = max(changed["deg"], *(lost(time, e, kept, ERROR) for e in errors))
        changed["mm"] = max(changed["mm"], *(lost(time, m, kept, MISS) for m in misses))
    about = {
        "name": name, "title": TRIALS[name], "samples": time[kept].size, "step": float(stride * (time[1] - time[0])),
        "joints": len(joints), "rms": rms,
    }  # fmt: skip
    return about, packed([column[kept] for column in columns], steps), changed


def main(arguments: list[str]) -> None:
    """Write the file, as fine as it fits."""
    demo = Path(arguments[0])
    plants = sorted(path.name for path in (demo / "logs").iterdir() if path.name != "none")
    folder = demo / "logs" / plants[0] / "seed0"
    settings = json.loads((demo / "figures.json").read_text())["settings"]
    for stride in STRIDES:
        trials = [trial(folder, name, stride * (1 if name == "fast" else 2)) for name in TRIALS]
        data = base64.b64encode(
            gzip.compress(b"".join(bytes_ for _, bytes_, _ in trials), 9, mtime=0)
        ).decode()
        made = {
            "plant": plants[0],
            "conditions": settings["conditions"],
            "steps": {"pose": POSE, "angle": ANGLE, "error": ERROR, "place": PLACE, "miss": MISS},
            "changed": {
                unit: round(max(one[unit] for *_, one in trials), 4) for unit in ("deg", "mm")
            },
            "base": [0.0, 0.0, 800.0],
            "trials": [about for about, *_ in trials],
            "data": data,
        }
        text = json.dumps(made, separators=(",", ":")) + "\n"
        if len(text) < LIMIT:
            break
    OUT.write_text(text)
    print(f"{OUT}: {len(text)} bytes, changed by {made['changed']} at most")


if __name__ == "__main__":
    main(sys.argv[1:])
