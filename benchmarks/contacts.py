"""A hand, a wall and a load at a joint that moves to and fro: errors before, during and after, and what is learned.

python benchmarks/contacts.py [--plants maxwell-slip dahl ...] [--joint 1] [--seed 0] [--jobs 2]
    [--only "a load of 5 Nm" ...] [--compensators best ...] [--settling 20] [--out docs/generate/contacts.csv]

The joint is alone, on the realistic arm, with the integrator; strokes of 8 s through 28 degrees, touched from 40 s to
120 s. What is not run stays in the file as it was. docs/build.py makes the table of docs/explanation/adaptation.md from
the file. Status 1 if `best` errs more than 1.5 times as much 5 s after the release as before it.
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
PLANTS = ("maxwell-slip", "preisach", "dahl", "lugre", "pinched", "ageing", "braid")
IN_FOREIGN = (  # what is measured of those that are no part of `best`
    "none",
    "a hand that brakes, 4 Nm",
    "a hand that helps, 4 Nm",
    "a wall at 6 degrees, 200 Nm/rad",
    "a load of 5 Nm",
)
IN_MUJOCO = "a wall at 6 degrees, 200 Nm/rad, of MuJoCo"  # measured with Maxwell slip
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


def measured(plant: str, contact: str) -> bool:
    """Whether a contact of a plant is in the table."""
    if contact == IN_MUJOCO:
        return plant == "maxwell-slip"
    return plant in PLANTS[:3] or contact in IN_FOREIGN


def written(rows: list[Row], file: Path) -> None:
    """Write rows in the order of the table, among those that the file has of other cases."""
    names = [field.name for field in fields(Row)]
    by_case: dict[tuple[str, ...], list[str]] = {}
    if file.is_file():
        with file.open(encoding="utf-8", newline="") as before:
            for known in list(csv.reader(before))[1:]:
                by_case[case_of(known)] = known
    for row in rows:
        cells = [str(value) for value in astuple(row)]
        by_case[case_of(cells)] = cells
    with file.open("w", encoding="utf-8", newline="") as out:
        writer = csv.writer(out, lineterminator="\n")
        writer.writerow(names)
        writer.writerows(sorted(by_case.values(), key=place))


def case_of(cells: list[str]) -> tuple[str, ...]:
    """Plant, joint, seed, contact and compensator."""
    return tuple(cells[:5])


def place(cells: list[str]) -> tuple[int, ...]:
    """Where a row is in the file."""
    plant, joint, seed, contact, compensator = cells[:5]
    return (
        PLANTS.index(plant),
        int(joint),
        int(seed),
        list(CONTACTS).index(contact),
        COMPENSATORS.index(compensator),
    )


def main() -> int:
    """Run all, write the file, and say whether `best` is as before after the release."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--plants", nargs="+", default=list(PLANTS), choices=PLANTS)
    parser.add_argument("--compensators", nargs="+", default=COMPENSATORS, choices=COMPENSATORS)
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
        contacts = [name for name in options.only if measured(plant, name)]
        for contact, compensator in itertools.product(contacts, options.compensators):
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
    written(rows, options.out)
    return int(bad)


if __name__ == "__main__":
    sys.exit(main())
