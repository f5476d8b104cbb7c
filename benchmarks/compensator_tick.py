"""What a control period of one joint costs with the full compensator: time here, instructions on each target.

    python benchmarks/compensator_tick.py                  # time, and instructions where the tools are
    python benchmarks/compensator_tick.py --json FILE

The compensator is a direct inverse of 30 stops, 9 lags along the path and 3 creep lags, scheduled by mean pressure and
angle, twice (at the desired and at the measured angle), and it learns; around it is the whole joint controller with
observer and pressure loops, as `dehyst export --what joint-controller` writes it. Ends with status 1 above LIMIT.
"""

from __future__ import annotations

import argparse
import json
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from target import count, jobs, machines

from dehyst.export import Subject, export
from dehyst.models import DirectInverse, ModelCard, Schedule, SignalCard
from dehyst_robot.control import Adaptation, JointControllerParameters
from dehyst_robot.export import joint_subject

LIMIT = 2.0  # [us] on x86-64
PERIODS = 150  # that are counted
SCHEDULES = {
    "by pressure and angle": (
        Schedule("mean_pressure", 2e5, 4e5, "Pa"),
        Schedule("output", -0.5, 0.5, "rad"),
    ),
    "not scheduled": (),
}
MAIN = """#include <stdio.h>
#include <time.h>
#include "unit.h"
#include "../check/expected.h"
#include <string.h>
static dehyst_real real_of(uint64_t word)
{{
    const {bits} bits = ({bits})word;
    dehyst_real value;
    memcpy(&value, &bits, sizeof value);
    return value;
}}
int main(void)
{{
    static unit_state unit;
    static dehyst_joint_sensors s[1400];
    static dehyst_joint_reference r[1400];
    dehyst_joint_output out;
    for (int k = 0; k < 1400; ++k) {{
        const uint64_t *x = test_signal[k].input;
        s[k].angle = real_of(x[0]); s[k].pressure[0] = real_of(x[1]); s[k].pressure[1] = real_of(x[2]);
        r[k].angle = real_of(x[3]); r[k].velocity = real_of(x[4]); r[k].acceleration = real_of(x[5]);
        r[k].load = real_of(x[6]); r[k].mean_pressure = real_of(x[7]); r[k].pressure_difference = real_of(x[8]);
        r[k].extra = real_of(x[9]);
    }}
    double best = 1e9;
    for (int run = 0; run < 60; ++run) {{
        struct timespec a, b;
        unit_reset(&unit, &s[0]);
        clock_gettime(CLOCK_MONOTONIC, &a);
        for (int k = 0; k < 1400; ++k) unit_step(&unit, &s[k], &r[k], test_signal[k].switches, &out);
        clock_gettime(CLOCK_MONOTONIC, &b);
        const double us = ((double)(b.tv_sec - a.tv_sec) * 1e6 + (double)(b.tv_nsec - a.tv_nsec) * 1e-3) / 1400;
        best = us < best ? us : best;
    }}
    printf("%.4f\\n", best);
    return 0;
}}
"""


def full(schedules: tuple[Schedule, ...]) -> DirectInverse:
    """Return a direct inverse of full size."""
    rng = np.random.default_rng(0)
    sets = max(1, 2 * len(schedules))
    card = ModelCard(SignalCard("torque", "Nm", -60.0, 60.0), SignalCard("angle", "rad", -0.6, 0.6))
    return DirectInverse(
        radii=np.geomspace(0.004, 0.57, 30),
        stop_weights=rng.uniform(0, 3, (sets, 30)),
        path_lengths=np.geomspace(0.03, 1.5, 9),
        path_weights=rng.uniform(0, 2, (sets, 9)),
        time_constants=np.array([0.1, 3.0, 100.0]),
        creep_weights=rng.uniform(0, 3, (sets, 3)),
        polynomial=rng.uniform(-1, 1, (sets, 6)),
        viscous=rng.uniform(0, 1, sets),
        schedules=schedules,
        past="unknown",
        card=card,
    )


def timed(subject: Subject) -> float:
    """Return the best mean time of a period. [us]"""
    with tempfile.TemporaryDirectory() as place:
        source = export(subject, "c", Path(place) / "out").folder / "src"
        bits = "uint64_t" if subject.real == "double" else "uint32_t"
        (source / "time_main.c").write_text(MAIN.format(bits=bits), encoding="utf-8")
        program = Path(place) / "timed"
        files = [str(path) for path in sorted(source.glob("*.c"))]
        command = ["cc", "-O2", "-std=gnu11", "-ffp-contract=off", *files, "-o", str(program)]
        subprocess.run(command, check=True)
        return float(
            subprocess.run([str(program)], check=True, capture_output=True, text=True).stdout
        )


def counted(subject: Subject) -> dict[str, dict[str, float]]:
    """Return target -> instructions of a period."""
    found = {}
    for name in ("cortex-m4f", "cortex-m7", "x86-64"):
        machine = machines.MACHINES[name]
        if machine.missing() or (not machine.board and shutil.which("valgrind") is None):
            continue
        with tempfile.TemporaryDirectory() as place:
            export(subject, "c", Path(place) / "out")
            program = machines.build(
                machine, Path(place), subject.real, "-O2", "joint.c", Path(place) / "out" / "src"
            )
            counts = count.count(
                machine, program, jobs.joint_job(subject, PERIODS), Path(place), "unit_step"
            )
        found[machine.name] = {"typical": float(np.mean(counts)), "most": int(np.max(counts))}
    return found


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--json", type=Path, help="write the figures there")
    arguments = parser.parse_args()
    rows: list[dict[str, Any]] = []
    for label, schedules in SCHEDULES.items():
        for real in ("double", "float"):
            subject = joint_subject(
                full(schedules), JointControllerParameters(), Adaptation(), name="unit", real=real
            )
            row = {
                "compensator": label,
                "real": real,
                "us": timed(subject),
                "instructions": counted(subject),
            }
            rows.append(row)
            steps = ", ".join(
                f"{name} {entry['most']:.0f}" for name, entry in row["instructions"].items()
            )
            print(
                f"{label}, {real}: {row['us']:.3f} us here; instructions at most: {steps}",
                flush=True,
            )
    if arguments.json:
        arguments.json.write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")
    return int(max(row["us"] for row in rows) > LIMIT)


if __name__ == "__main__":
    sys.exit(main())
