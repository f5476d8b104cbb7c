"""How far the poles of joints 2 and 4 can be raised while they move together with joint 1, which has one of its own.

python benchmarks/unequal_poles.py [--conditions realistic kind] [--first 3 6] [--mechanism preisach]

The margins are those of `highest_pole`: all gains of the raised joints doubled, commands 5 ms late. Calibrated as by
`dehyst reproduce --quick`. Half a minute of processor time.
"""

from __future__ import annotations

import argparse

from dehyst.errors import ParameterError
from dehyst_robot.arm import load_robot
from dehyst_robot.commands._reproduce import QUICK
from dehyst_robot.experiments import calibrate, equip
from dehyst_robot.experiments._gains import at_pole, highest_pole

TOGETHER = (1, 2, 4)
RAISED = ((2,), (4,), (2, 4))


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--conditions", nargs="+", default=["realistic", "kind"])
    parser.add_argument("--first", nargs="+", type=float, default=[3.0, 6.0])
    parser.add_argument("--mechanism", default="preisach")
    options = parser.parse_args()
    for conditions in options.conditions:
        changes = {**QUICK, "hysteresis.mechanism": options.mechanism}
        robot = load_robot(conditions=conditions, changes=changes)
        kit = equip(robot, {n: calibrate(robot, n) for n in TOGETHER}, {})
        for first in options.first:
            for joints in RAISED:
                try:
                    pole = highest_pole(robot, at_pole(kit, first, (1,)), joints, moving=TOGETHER)
                    shown = f"{pole:.1f}"
                except ParameterError:
                    shown = "below 6"
                raised = " and ".join(map(str, joints))
                print(f"{conditions}, joint 1 at {first:g} 1/s, {raised} up to {shown}", flush=True)


if __name__ == "__main__":
    main()
