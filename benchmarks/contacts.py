"""A hand, a wall and a load at a joint that moves to and fro: errors before, during and after, and what is learned.

python benchmarks/contacts.py [--plants maxwell-slip preisach dahl] [--joint 1] [--seed 0] [--jobs 2]
    [--only "a load of 5 Nm" ...] [--settling 20] [--out docs/generate/contacts.csv]

The joint is alone, on the realistic arm, with the integrator; strokes of 8 s through 28 degrees, touched from 40 s to
120 s. docs/build.py makes the table of docs/explanation/adaptation.md from the file. Status 1 if `best` errs more than
1.5 times as much 5 s after the release as before it.
"""

from __future__ import annotations

import argparse
import csv
import itertools
import sys
import warnings
from concurrent.futures import ThreadPoolExecutor
from dataclasses import astuple, dataclass, fields, replace
from pathlib import Path

from studies.contacts import CONTACTS, loop_energy, touch

from dehyst_robot.arm import Robot, load_robot
from dehyst_robot.control import Adaptation
from dehyst_robot.experiments import _point as point
from dehyst_robot.experiments._recipes import recipe

OUT = Path(__file__).parents[1] / "docs" / "generate" / "contacts.csv"
PLANTS = ("maxwell-slip", "preisach", "dahl")
COMPENSATORS = ("off", "paper", "best")
MOST_AFTER = 1.5  # of the error before


@dataclass(frozen=True)
class Row:
    """A line of the file.

    Errors are rms in millidegrees; `loop_J` is what the compensator as identified gives the joint along two strokes, to
    and fro; times are from the beginning of the contact, empty where a flag was not raised.
    """

    plant: str
    joint: int
    seed: int
    contact: str
    compensator: str
    before_mdeg: float
    during_mdeg: float
    settled_mdeg: float
    later_mdeg: float
    peak_Nm: float
    loop_J: float
    lowest_scale: float
    highest_scale: float
    touched_s: str
    stale_s: str
    shifted_s: str


@dataclass(frozen=True)
class Case:
    """One run."""

    robot: Robot
    plant: str
    joint: int
    seed: int
    contact: str
    compensator: str
    settling: float

    def run(self) -> Row:
        """Calibrate and identify, once for all runs of a plant, and run."""
        recipes = {name: recipe(name) for name in COMPENSATORS if name != "off"}
        prepared = point._prepared(self.robot, self.robot, recipes, self.joint, "joint", self.seed)
        kit = prepared["paper" if self.compensator == "off" else self.compensator][0]
        learning = {}
        for number, one in kit.adaptations.items():
            learning[number] = replace(one, settling=self.settling)
        kit = replace(kit, adaptations=learning)
        touched = touch(self.robot, kit, self.joint, self.compensator, CONTACTS[self.contact])
        times = {}
        for name in ("touched", "stale", "shifted"):
            noticed = touched.noticed(name)
            times[name] = f"{noticed:.2f}" if noticed == noticed else ""
        lowest, highest = touched.scale_extremes()
        return Row(
            plant=self.plant,
            joint=self.joint,
            seed=self.seed,
            contact=self.contact,
            compensator=self.compensator,
            before_mdeg=round(1e3 * touched.before, 3),
            during_mdeg=round(1e3 * touched.during, 3),
            settled_mdeg=round(1e3 * touched.settled, 3),
            later_mdeg=round(1e3 * touched.later, 3),
            peak_Nm=round(touched.peak, 2),
            loop_J=round(loop_energy(self.robot, kit, self.joint, self.compensator), 4),
            lowest_scale=round(lowest, 3),
            highest_scale=round(highest, 3),
            touched_s=times["touched"],
            stale_s=times["stale"],
            shifted_s=times["shifted"],
        )


def main() -> int:
    """Run all, write the file, and say whether `best` is as before after the release."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--plants", nargs="+", default=list(PLANTS))
    parser.add_argument("--joint", type=int, default=1)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--settling", type=float, default=Adaptation().settling)
    parser.add_argument("--only", nargs="+", default=list(CONTACTS), choices=list(CONTACTS))
    parser.add_argument("--out", type=Path, default=OUT)
    options = parser.parse_args()
    warnings.simplefilter("ignore", UserWarning)  # flags are in the table
    cases = []
    for plant in options.plants:
        robot = load_robot(changes={"hysteresis.mechanism": plant})
        for contact, compensator in itertools.product(options.only, COMPENSATORS):
            cases.append(
                Case(
                    robot,
                    plant,
                    options.joint,
                    options.seed,
                    contact,
                    compensator,
                    options.settling,
                )
            )
    rows = []
    bad = False
    with ThreadPoolExecutor(options.jobs) as pool:  # the simulation does not hold Python's lock
        for row in pool.map(Case.run, cases):
            rows.append(row)
            bad = bad or (
                row.compensator == "best" and row.settled_mdeg > MOST_AFTER * row.before_mdeg
            )
            print(*astuple(row), sep="  ", flush=True)
    with options.out.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow([field.name for field in fields(Row)])
        writer.writerows(map(astuple, rows))
    return int(bad)


if __name__ == "__main__":
    sys.exit(main())
