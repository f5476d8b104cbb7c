"""FMUs of random models, FMI 2.0 and 3.0, stepped through their test signals: bits and flags of the model?

    python benchmarks/fmu_bits.py [--models 1000] [--first 0] [--level=-O0]

Models of every family with up to 30 operators, inverse and forward in turn; 1 060 samples each, with limits, switching
and samples that are no numbers. Compiled with -O0, which is the quickest. Exit status 0: all of them.
"""

import argparse
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from dehyst.export import subject_of
from dehyst.export._signal import same_bits
from dehyst_targets.fmu import _sources as sources
from dehyst_targets.fmu import package
from dehyst_targets.fmu._verification import run_fmu

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

from block_samples import sample


def agrees(seed, folder):
    """Whether both FMUs of a random model answer like it, and the number of samples."""
    model, bounds, rng = sample(seed)
    what = ("inverse", "forward")[seed % 2]
    subject = subject_of(model, what, name="unit_x", range=bounds, ramp=int(rng.integers(1, 60)))
    good = True
    for version in (2, 3):
        path = folder / f"{version}.fmu"
        path.write_bytes(package(subject, version).fmu)
        outputs, flags = run_fmu(path, subject, subject.test)
        good &= same_bits(outputs, subject.test.outputs) and np.array_equal(
            flags, subject.test.flags
        )
    return good, subject.test.samples


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--models", type=int, default=1000)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--level", default="-O0")
    asked = parser.parse_args()
    sources.TARGETS = (sources.LINUX,)
    sources.OPTIONS = (*sources.OPTIONS, asked.level)
    wrong, samples, begin = [], 0, time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(asked.first, asked.first + asked.models):
            good, count = agrees(seed, Path(folder))
            samples += 2 * count
            if not good:
                wrong.append(seed)
    print(
        f"{asked.models} models, FMI 2.0 and 3.0, {samples} samples in {time.perf_counter() - begin:.0f} s: "
        + (
            f"models {wrong[:20]} differ"
            if wrong
            else "all outputs and flags have the bits of the model"
        )
    )
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
