"""What the integrator has to do without and with a compensator: gain in the slow trial, three minutes of rest.

python benchmarks/integrator.py [--plants maxwell-slip preisach dahl] [--conditions realistic] [--seed 0]

Writes results/integrator.json, from which docs/build.py makes tables and picture of docs/explanation/integrator.md.
"""

from __future__ import annotations

import argparse
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict
from pathlib import Path
from typing import Any

from result_files import save
from studies.alone import DISTURBANCE, Alone, follow, identified_alone
from studies.hold import gains, hold
from studies.robustness import without

from dehyst_robot.arm import load_robot
from dehyst_robot.experiments import plan_path

PLANTS = ("maxwell-slip", "preisach", "dahl")
RESULTS = Path(__file__).parent / "results" / "integrator.json"
EVERY = 20  # rows of 0.1 s of a rest that become one


def measured(plant: str, conditions: str, seed: int) -> dict[str, Any]:
    """All figures of a plant."""
    robot = load_robot(conditions=conditions, changes={"hysteresis.mechanism": plant})
    joint = identified_alone(robot, plan_path(robot), seed=seed)
    found: dict[str, Any] = {"conditions": conditions}
    for name, one in (("off", without(joint)), ("on", joint)):
        found[name] = {
            "gains": [asdict(gain) for gain in gains(one)],
            "rest": rest(one),
            "drift": drift(one),
        }
    observed = follow(joint, "slow_no_integrator", DISTURBANCE).figures()
    both = follow(joint, "slow", DISTURBANCE).figures()
    found["observer"] = {
        "rms_deg": observed[0],
        "max_deg": observed[1],
        "rest": rest(joint, DISTURBANCE),
    }
    found["observer and integrator"] = {"rms_deg": both[0], "max_deg": both[1]}
    return found


def rest(joint: Alone, switches: int = 0) -> dict[str, list[float]]:
    """Error while the joint rests without integrator."""
    held = hold(joint, switches)
    return {
        "time_s": held.time[::EVERY].round(1).tolist(),
        "error_deg": held.error[::EVERY].round(4).tolist(),
    }


def drift(joint: Alone) -> dict[str, Any]:
    """Torque of the integrator while the joint rests with it."""
    held = hold(joint, integrator=True)
    return {"slope_Nm_s": held.drift, "torque_Nm": held.integrator[::EVERY].round(4).tolist()}


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--plants", nargs="+", default=list(PLANTS))
    parser.add_argument("--conditions", default="realistic", choices=("realistic", "kind"))
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    with ThreadPoolExecutor() as pool:  # the simulation does not hold Python's lock
        found = dict(
            zip(
                options.plants,
                pool.map(lambda p: measured(p, options.conditions, options.seed), options.plants),
                strict=True,
            )
        )
    save(RESULTS, found)
    for plant, figures in found.items():
        for name in ("off", "on"):
            row = "  ".join(f"{g['gain']:g}: {g['rms_deg']:.4f}" for g in figures[name]["gains"])
            print(
                f"{plant:13s} {name:3s} {row}  drift {1e3 * figures[name]['drift']['slope_Nm_s']:.2f} mNm/s"
            )
        print(f"{plant:13s} observer instead of integrator: {figures['observer']['rms_deg']:.4f}")


if __name__ == "__main__":
    main()
